//! The number that physics is written in.

use crate::elementary;
use crate::lanes::LaneLevel;
use std::fmt::Debug;
use std::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, Neg, Not, Sub, SubAssign};

/// One real number, or several side by side that undergo the same operations.
///
/// Each operation acts on every lane alone and rounds as IEEE 754 binary64 says, so a lane's bits depend neither on its
/// neighbours nor on how many there are. Branches are [`Real::select`] on a mask; a divisor that can be zero in the lane
/// not selected must be made safe first.
pub trait Real:
    Copy
    + Debug
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
{
    /// The answer of a comparison, lane by lane.
    type Mask: Mask;

    /// How many numbers stand side by side.
    const LANES: usize;

    /// The instructions that they need, which [`dispatch`](crate::dispatch) has asked the processor for.
    const LEVEL: LaneLevel;

    /// `value` in every lane.
    fn splat(value: f64) -> Self;

    /// `value(lane)` in each lane.
    fn from_lanes(value: impl FnMut(usize) -> f64) -> Self;

    /// The first three numbers of the rows `rows[indices[lane] × FIELDS + field]`.
    ///
    /// # Panics
    /// Fewer indices than lanes, or an index beyond the rows.
    #[inline(always)]
    fn gather<const FIELDS: usize>(rows: &[[f64; 4]], indices: &[u16]) -> [[Self; 3]; FIELDS] {
        let mut fields = [[Self::splat(0.0); 3]; FIELDS];
        for (field, components) in fields.iter_mut().enumerate() {
            for (component, number) in components.iter_mut().enumerate() {
                *number = Self::from_lanes(|lane| rows[indices[lane] as usize * FIELDS + field][component]);
            }
        }
        fields
    }

    /// Writes (x, y, z, 0) of each lane of a vector to `rows[lane × stride]`.
    ///
    /// # Panics
    /// The rows do not reach to the last lane's.
    #[inline(always)]
    fn scatter([x, y, z]: [Self; 3], rows: &mut [[f64; 4]], stride: usize) {
        for lane in 0..Self::LANES {
            rows[lane * stride] = [x.lane(lane), y.lane(lane), z.lane(lane), 0.0];
        }
    }

    /// The number in one lane, `lane < LANES`.
    fn lane(self, lane: usize) -> f64;

    /// Writes the lanes to the first `LANES` places of `target`, which must have as many.
    fn store(self, target: &mut [f64]);

    /// `self × factor + addend`, rounded once.
    fn mul_add(self, factor: Self, addend: Self) -> Self;

    /// Square root.
    fn sqrt(self) -> Self;

    /// Absolute value.
    fn abs(self) -> Self;

    /// `self` where it is greater than `other`, else `other` (so a NaN in `self` is dropped).
    fn max(self, other: Self) -> Self;

    /// `self` where it is less than `other`, else `other` (so a NaN in `self` is dropped).
    fn min(self, other: Self) -> Self;

    /// Nearest integer, ties to even.
    fn round(self) -> Self;

    /// `self < other`.
    fn lt(self, other: Self) -> Self::Mask;

    /// `self ≤ other`.
    fn le(self, other: Self) -> Self::Mask;

    /// `chosen` where the mask is set, else `otherwise`.
    fn select(mask: Self::Mask, chosen: Self, otherwise: Self) -> Self;

    /// 2ᵏ for an integral `self` = k, −1022 ≤ k ≤ 1023.
    fn power_of_two(self) -> Self;

    /// `(e, m)` with `self` = m 2ᵉ and 1 ≤ m < 2, for a normal positive `self`.
    fn exponent_and_mantissa(self) -> (Self, Self);

    /// Runs `kernel` compiled for the instructions that these lanes use.
    ///
    /// Code generic over `Real` is slow outside of such a call: each operation would be a function call.
    fn vectorize<K: Kernel>(kernel: K) -> K::Output;

    /// `self > other`.
    #[inline(always)]
    fn gt(self, other: Self) -> Self::Mask {
        other.lt(self)
    }

    /// `self ≥ other`.
    #[inline(always)]
    fn ge(self, other: Self) -> Self::Mask {
        other.le(self)
    }

    /// 1 / `self`.
    #[inline(always)]
    fn recip(self) -> Self {
        Self::splat(1.0) / self
    }

    /// Where `self` is neither infinite nor NaN.
    #[inline(always)]
    fn is_finite(self) -> Self::Mask {
        self.abs().le(Self::splat(f64::MAX))
    }

    /// e to the power of `self`, to 1 unit in the last place; 0 below −708 and constant above 709.
    #[inline(always)]
    fn exp(self) -> Self {
        elementary::exp(self)
    }

    /// Natural logarithm of a normal positive number, to 2 units in the last place.
    #[inline(always)]
    fn ln(self) -> Self {
        elementary::ln(self)
    }

    /// Cube root of a normal positive number.
    #[inline(always)]
    fn cbrt(self) -> Self {
        elementary::cbrt(self)
    }
}

/// One truth value a lane.
pub trait Mask:
    Copy + Debug + Send + Sync + 'static + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self>
{
    /// Whether any lane is true.
    fn any(self) -> bool;

    /// Whether every lane is true.
    #[inline(always)]
    fn all(self) -> bool {
        !(!self).any()
    }
}

/// Work for [`Real::vectorize`]. `run` and what it calls must be `#[inline(always)]` to be compiled for the lanes.
pub trait Kernel {
    /// What the work returns.
    type Output;

    /// Does the work.
    fn run(self) -> Self::Output;
}

impl Real for f64 {
    type Mask = bool;

    const LANES: usize = 1;
    const LEVEL: LaneLevel = LaneLevel::Portable;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn from_lanes(mut value: impl FnMut(usize) -> f64) -> Self {
        value(0)
    }

    #[inline(always)]
    fn lane(self, _lane: usize) -> f64 {
        self
    }

    #[inline(always)]
    fn store(self, target: &mut [f64]) {
        target[0] = self;
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        f64::mul_add(self, factor, addend)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        f64::abs(self)
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }

    #[inline(always)]
    fn round(self) -> Self {
        self.round_ties_even()
    }

    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self < other
    }

    #[inline(always)]
    fn le(self, other: Self) -> bool {
        self <= other
    }

    #[inline(always)]
    fn select(mask: bool, chosen: Self, otherwise: Self) -> Self {
        if mask { chosen } else { otherwise }
    }

    #[inline(always)]
    fn power_of_two(self) -> Self {
        f64::from_bits((self + elementary::EXPONENT_SHIFTER).to_bits() << 52)
    }

    #[inline(always)]
    fn exponent_and_mantissa(self) -> (Self, Self) {
        let bits = self.to_bits();
        let exponent = f64::from_bits((bits >> 52) | elementary::TWO_52_BITS) - elementary::TWO_52_AND_BIAS;
        let mantissa = f64::from_bits((bits & elementary::FRACTION_BITS) | elementary::ONE_BITS);
        (exponent, mantissa)
    }

    #[inline(always)]
    fn vectorize<K: Kernel>(kernel: K) -> K::Output {
        kernel.run()
    }
}

impl Mask for bool {
    #[inline(always)]
    fn any(self) -> bool {
        self
    }
}
