//! `exp`, `ln` and the cube root from exactly rounded operations alone, so that every machine and every number of
//! lanes gives the same bits; the system's library is not asked.

use crate::real::Real;

/// 3 · 2⁵¹ + 1023: added to an integer k it leaves k + 1023, the biased exponent of 2ᵏ, in the lowest bits.
pub(crate) const EXPONENT_SHIFTER: f64 = 6_755_399_441_055_744.0 + 1023.0;
/// The bits of 2⁵².
pub(crate) const TWO_52_BITS: u64 = 0x4330_0000_0000_0000;
/// 2⁵² + 1023.
pub(crate) const TWO_52_AND_BIAS: f64 = 4_503_599_627_370_496.0 + 1023.0;
/// The fraction field of an `f64`.
pub(crate) const FRACTION_BITS: u64 = 0x000F_FFFF_FFFF_FFFF;
/// The bits of 1.
pub(crate) const ONE_BITS: u64 = 0x3FF0_0000_0000_0000;

/// ln 2 to 32 bits, so that its product with an exponent is exact, and the rest.
const LN_2_HIGH: f64 = f64::from_bits(0x3FE6_2E42_FEE0_0000);
const LN_2_LOW: f64 = f64::from_bits(0x3DEA_39EF_3579_3C76);

/// Beyond these arguments e^x leaves the normal numbers.
const EXP_SMALLEST: f64 = -708.0;
const EXP_LARGEST: f64 = 709.0;

/// 1/n! for n = 13 … 2.
const EXP_SERIES: [f64; 12] = [
    1.0 / 6_227_020_800.0,
    1.0 / 479_001_600.0,
    1.0 / 39_916_800.0,
    1.0 / 3_628_800.0,
    1.0 / 362_880.0,
    1.0 / 40_320.0,
    1.0 / 5_040.0,
    1.0 / 720.0,
    1.0 / 120.0,
    1.0 / 24.0,
    1.0 / 6.0,
    0.5,
];

/// e^x = 2ᵏ e^r with k = round(x / ln 2) and |r| ≤ ½ ln 2, e^r by its series.
#[inline(always)]
pub(crate) fn exp<R: Real>(x: R) -> R {
    let bounded = x.max(R::splat(EXP_SMALLEST)).min(R::splat(EXP_LARGEST));
    let k = (bounded * std::f64::consts::LOG2_E).round();
    let r = (-k).mul_add(R::splat(LN_2_LOW), (-k).mul_add(R::splat(LN_2_HIGH), bounded));
    let mut sum = R::splat(EXP_SERIES[0]);
    for coefficient in &EXP_SERIES[1..] {
        sum = sum.mul_add(r, R::splat(*coefficient));
    }
    let tail = (r * r).mul_add(sum, r);
    let power = k.power_of_two();
    R::select(x.lt(R::splat(EXP_SMALLEST)), R::splat(0.0), power.mul_add(tail, power))
}

/// ln x = e ln 2 + 2 artanh f with x = m 2ᵉ, √½ ≤ m < √2 and f = (m − 1)/(m + 1), artanh by its series.
#[inline(always)]
pub(crate) fn ln<R: Real>(x: R) -> R {
    let (exponent, mantissa) = x.exponent_and_mantissa();
    let large = mantissa.gt(R::splat(std::f64::consts::SQRT_2));
    let m = R::select(large, mantissa * 0.5, mantissa);
    let e = R::select(large, exponent + 1.0, exponent);
    let f = (m - 1.0) / (m + 1.0);
    let s = f * f;
    // 2 artanh f = 2 f (1 + s/3 + s²/5 + …), s ≤ 0.0295
    let mut sum = R::splat(1.0 / 23.0);
    for divisor in [21.0, 19.0, 17.0, 15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0] {
        sum = sum.mul_add(s, R::splat(1.0 / divisor));
    }
    let tail = (f * s + f * s).mul_add(sum, e * LN_2_LOW);
    e.mul_add(R::splat(LN_2_HIGH), (f + f) + tail)
}

/// x^⅓ by logarithm, then one Newton step of y³ = x.
#[inline(always)]
pub(crate) fn cbrt<R: Real>(x: R) -> R {
    let y = exp(ln(x) * (1.0 / 3.0));
    let square = y * y;
    y - (square * y - x) / (square * 3.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distance in units in the last place.
    fn ulps(a: f64, b: f64) -> f64 {
        (a - b).abs() / (b.abs() * f64::EPSILON)
    }

    #[test]
    fn exp_is_within_one_unit_in_the_last_place() {
        let mut worst: f64 = 0.0;
        for i in -70_000..70_000 {
            let x = f64::from(i) * 0.010_007;
            worst = worst.max(ulps(exp(x), x.exp()));
        }
        assert!(worst <= 1.5, "{worst}");
        assert_eq!(exp(0.0), 1.0);
        assert_eq!(exp(-1000.0), 0.0);
        assert!(exp(1000.0).is_finite());
    }

    #[test]
    fn ln_is_within_two_units_in_the_last_place() {
        let mut worst: f64 = 0.0;
        for i in 1..200_000 {
            let x = f64::from(i) * 1.234_5e-4;
            let error = (ln(x) - x.ln()).abs();
            worst = worst.max(error / (x.ln().abs().max(1e-2) * f64::EPSILON));
        }
        assert!(worst <= 2.0, "{worst}");
        assert_eq!(ln(1.0), 0.0);
        assert!(ulps(ln(1e-300), 1e-300_f64.ln()) <= 1.0);
        assert!(ulps(ln(1e300), 1e300_f64.ln()) <= 1.0);
    }

    #[test]
    fn cube_root_cubed_is_the_number() {
        for x in [1e-12, 0.1, 0.5, 1.0, 1.5, 27.0, 1e9] {
            let y: f64 = cbrt(x);
            assert!(ulps(y * y * y, x) <= 4.0, "{x}");
        }
    }
}
