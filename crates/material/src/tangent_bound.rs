//! Upper bounds of elastic tangents in the current configuration, over the bound that an element's stable time step starts
//! from.
//!
//! With the gradient L of a small motion from a state under the Cauchy stress T, the second variation of the work is
//! Q = L : (Ṫ + tr(L) T − T Lᵀ) a volume, the stiffness of the stress included. At rest it is 2μ |dev D|² + k (tr L)², and an
//! element bounds it by 2μ |L|² + λ⁺ (tr L)², which is 2μ (|dev L|² + z²) + 3 λ⁺ z² with z = tr L/√3 and dev L of nine
//! components. Where
//!
//! Q ≤ x |dev L|² + 2 y |dev L| z + v z²,
//!
//! it is at most s times that, s the larger eigenvalue of [[x/2μ, y/√(2μ κ)], [y/√(2μ κ), v/κ]], κ = 2μ + 3 λ⁺.
//!
//! Where an element averages the volume change, Ṫ knows nothing of what a point has of its own, for which Q = ⅔ tr(T) z². Nothing but
//! 2μ |L|² bounds that, so that x is at least ⅔ tr T.

use crate::IsotropicElasticity;
use estar_tensor::{Real, SymmetricTensor};

const SQRT_2_THIRDS: f64 = 0.816_496_580_927_726;
const SQRT_3: f64 = 1.732_050_807_568_877_2;

/// x, y, v and the mean stress, Pa.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TangentBound<R> {
    pub deviatoric: R,
    pub mixed: R,
    pub volumetric: R,
    /// ⅓ tr T.
    pub mean_stress: R,
}

impl<R: Real> TangentBound<R> {
    /// s.
    #[inline(always)]
    pub fn over_rest(&self, elasticity: &IsotropicElasticity) -> R {
        let shear = 2.0 * elasticity.shear_modulus();
        let bulk = shear + 3.0 * elasticity.lame_lambda().max(0.0);
        let deviatoric = self.deviatoric.max(self.mean_stress * 2.0) * shear.recip();
        let volumetric = self.volumetric * bulk.recip();
        let mixed = self.mixed * (shear * bulk).sqrt().recip();
        let half_difference = (deviatoric - volumetric) * 0.5;
        (deviatoric + volumetric) * 0.5 + half_difference.mul_add(half_difference, mixed * mixed).sqrt()
    }
}

/// Mean, ‖dev A‖ and an upper bound of the largest principal value of a tensor A, exact where its deviator is uniaxial tension.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Size<R> {
    pub mean: R,
    pub deviator: R,
    pub largest: R,
}

impl<R: Real> Size<R> {
    #[inline(always)]
    pub fn of(tensor: &SymmetricTensor<R>) -> Self {
        let mean = tensor.trace() * (1.0 / 3.0);
        let deviator = tensor.deviator().norm_squared().sqrt();
        Self { mean, deviator, largest: deviator.mul_add(R::splat(SQRT_2_THIRDS), mean) }
    }
}

/// Of T = μ b + t I with t = ½ k (tr b − 3) − ⅓ μ tr b, the total form of the E* theory, at the Cauchy stress T. With
/// ḃ = L b + b Lᵀ
///
/// Q = μ tr(L b Lᵀ) − t tr(L L) + ((k + ⅓ μ) b : L + t tr L) tr L.
///
/// tr(L L) is at most |dev L|² + z² either way, tr(L b Lᵀ) ≤ b₁ |L|², and b : L = ⅓ tr b tr L + dev b : L.
#[inline(always)]
pub(crate) fn linear_in_elastic_metric<R: Real>(
    elasticity: &IsotropicElasticity,
    stress: &SymmetricTensor<R>,
) -> TangentBound<R> {
    let [mu, k] = [elasticity.shear_modulus(), elasticity.bulk_modulus()];
    let Size { mean, deviator, largest } = Size::of(stress);
    // ⅓ tr b = 1 + ⅔ tr T/3k, μ b₁ = T₁ − t
    let metric_mean = mean.mul_add(R::splat(2.0 / (3.0 * k)), R::splat(1.0));
    let t = metric_mean.mul_add(R::splat(-mu), mean);
    let stretched = largest - t;
    TangentBound {
        deviatoric: stretched + t.abs(),
        mixed: deviator * (0.5 * SQRT_3 * (k + mu / 3.0) / mu),
        volumetric: metric_mean.mul_add(R::splat(3.0 * k + mu), t + t) + stretched,
        mean_stress: mean,
    }
}

/// Of the Kirchhoff stress τ = μ (b − I) + λ ln J_e I, neo-Hooke's, with `metric_mean` = ⅓ tr b:
///
/// J Q = μ tr(L b Lᵀ) + (μ − λ ln J_e) tr(L L) + λ (tr L)².
#[inline(always)]
pub(crate) fn neo_hooke<R: Real>(
    elasticity: &IsotropicElasticity,
    kirchhoff: &SymmetricTensor<R>,
    metric_mean: R,
) -> TangentBound<R> {
    let Size { mean, largest, .. } = Size::of(kirchhoff);
    // τ = μ b − (μ − λ ln J_e) I
    let c = metric_mean.mul_add(R::splat(elasticity.shear_modulus()), -mean);
    let stretched = largest + c;
    TangentBound {
        deviatoric: stretched + c.abs(),
        mixed: R::splat(0.0),
        volumetric: stretched + c + 3.0 * elasticity.lame_lambda(),
        mean_stress: mean,
    }
}

/// Of the Kirchhoff stress τ = 2μ ε + λ tr(ε) I in the logarithmic strain ε = ½ ln b. In the principal axes of τ
///
/// J Q = Σ (2μ − τᵢ) Lᵢᵢ² + λ (tr L)² + Σ_{i<j} (pᵢⱼ Lᵢⱼ² + qᵢⱼ Lⱼᵢ² + 2 cᵢⱼ Lᵢⱼ Lⱼᵢ)
///
/// with r = bᵢ/bⱼ, p = μ ln r/(r − 1), q = r p, q − p = τᵢ − τⱼ and c = p − τⱼ = ½ (p + q) − ½ (τᵢ + τⱼ). From
/// ½ (p + q) = μ w coth w ≤ μ (1 + ⅓ w²), w = ½ (τᵢ − τⱼ)/μ, τᵢ − τⱼ ≤ √2 ‖dev τ‖ and |dev τᵢ| ≤ √⅔ ‖dev τ‖ the larger
/// eigenvalue of each pair is at most ½ (p + q) + √(½ ‖dev τ‖² + c²).
#[inline(always)]
pub(crate) fn logarithmic<R: Real>(
    elasticity: &IsotropicElasticity,
    kirchhoff: &SymmetricTensor<R>,
) -> TangentBound<R> {
    let [mu, k] = [elasticity.shear_modulus(), elasticity.bulk_modulus()];
    let Size { mean, deviator, .. } = Size::of(kirchhoff);
    let spread = deviator * SQRT_2_THIRDS;
    let deviator_squared = deviator * deviator;
    // ½ (p + q): between μ and this
    let half_sum = deviator_squared.mul_add(R::splat(1.0 / (6.0 * mu)), R::splat(mu));
    let c = (half_sum - mean).abs().max((R::splat(mu) - mean).abs()) + spread * 0.5;
    let of_pairs = half_sum + c.mul_add(c, deviator_squared * 0.5).sqrt();
    let of_axes = spread - mean;
    TangentBound {
        deviatoric: of_pairs.max(of_axes + 2.0 * mu),
        mixed: R::splat(0.0),
        volumetric: of_axes + 3.0 * k,
        mean_stress: mean,
    }
}

/// Of S = 2μ dev(E − E_p) + k tr(E − E_p) I with τ = F S Fᵀ and b = FFᵀ, the `metric`:
///
/// J Q = 2μ ‖FᵀDF‖² + λ (b : L)² + tr(L τ Lᵀ),
///
/// where ‖FᵀDF‖ ≤ b₁ |L| and |b : L| ≤ √⅓ tr b z + ‖dev b‖ |dev L|.
#[inline(always)]
pub(crate) fn second_piola_kirchhoff<R: Real>(
    elasticity: &IsotropicElasticity,
    kirchhoff: &SymmetricTensor<R>,
    metric: &SymmetricTensor<R>,
) -> TangentBound<R> {
    let lambda = elasticity.lame_lambda().max(0.0);
    let Size { mean, deviator, largest } = Size::of(metric);
    let stress = Size::of(kirchhoff);
    let of_stress = stress.largest.max(R::splat(0.0));
    let stretched = (largest * largest).mul_add(R::splat(2.0 * elasticity.shear_modulus()), of_stress);
    TangentBound {
        deviatoric: (deviator * deviator).mul_add(R::splat(lambda), stretched),
        mixed: mean * deviator * (SQRT_3 * lambda),
        volumetric: (mean * mean).mul_add(R::splat(3.0 * lambda), stretched),
        mean_stress: stress.mean,
    }
}
