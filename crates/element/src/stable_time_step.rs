//! An upper bound of the highest frequency of an element, cheap enough for every step on the current mesh.
//!
//! Central differences are stable for Δt ≤ 2/ω with ω² the spectral radius of M⁻¹K of the assembled mesh, and for a
//! lumped mass that is bounded by the largest norm of M_e^{-½} K_e M_e^{-½} among the elements (Irons & Fried for
//! symmetric K; for the F-bar operator, which is not symmetric, the same by Cauchy-Schwarz:
//! |uᵀKv| ≤ Σ_e ω_e² ‖u‖_{M_e} ‖v‖_{M_e} ≤ max ω_e² ‖u‖_M ‖v‖_M). For one element, with G_q = j J⁻¹J⁻ᵀ at the Gauss
//! point q (j = det J, J = ∂x/∂ξ), g = max_q λ_max(G_q), h = max_q tr G_q, m the smallest corner mass, V the volume,
//! θ = tr D, λ⁺ = max(λ, 0), and b̄, b₀ the mean and the central divergence operator (θ̄ = b̄ᵀu, θ₀ = b₀ᵀu):
//!
//! 1. Σ_q j |∇u|² ≤ g Σ_q |∂u/∂ξ|² ≤ g Σ_a |u_a|² ≤ (g/m) uᵀMu, because the modes ξ; ξη; ξηζ of the trilinear field
//!    are orthogonal over corners and over Gauss points, with the ratios 1; ⅔; ⅓ of the two sums.
//! 2. `hex8`: |D|² ≤ |∇u|², and j θ² = (cof J : ∂u/∂ξ)²/j ≤ tr G_q |∂u/∂ξ|², so ω² ≤ (2μ g + λ⁺ h)/m.
//! 3. `hex8-f-bar`: K = K_dev + k V b̄ b₀ᵀ. By Jensen Σ_q j θ² ≥ V θ̄², so K_dev ≤ 2μ (g/m) M − ⅔ μ V b̄b̄ᵀ and
//!    ω² ≤ 2μ g/m + λ⁺ V |b̄|²/m + k V |b̄| |b₀ − b̄|/m.
//! 4. `hex8-b-bar`: K = K_dev + k V b̄ b̄ᵀ, the same without the last term.
//!
//! 5. `tet10`: as 4. On the regular parent tet in the cube ∓1, whose volume is 8/3 and whose four points weigh w = ⅔,
//!    Σ_q w |∂u/∂r|² ≤ κ Σ_a φ_a |u_a|² where node a has the share φ_a of the mass M; κ is the largest eigenvalue of a matrix
//!    of 10 × 10 numbers. What a point keeps of its own volume change, α (θ − θ̄), adds k α² Σ_q j (θ − θ̄)² to the energy, of
//!    which K_dev takes ⅔ μ away. So ω² ≤ (2μ g + (k α² − ⅔ μ)⁺ h) κ/M + λ⁺ Σ_a |V b̄_a|²/(φ_a V M).
//! 6. `tet4`: one point, on the same parent Σ_a ∇N_a ∇N_aᵀ = ¼ J⁻ᵀJ⁻¹ and V = 8/3 j, so that ω² ≤ ⅔ (2μ g + λ⁺ h)/m. The mean
//!    over neighbours S of the volume change is self-adjoint in the sum over volumes and takes 1 to 1 with no negative share,
//!    so that its norm is 1 and Σ_e V k (S θ)² ≤ Σ_e V k θ².
//! 7. Wedges and pyramids are hexes some of whose corners move alike: the same quotients over fewer motions.
//! 8. `hex8-one-point`: K = A + B with A of the mean gradient B̄ᵀu, ω² ≤ a/m alone by 2. with the metric V Σ_a b̄_a b̄_aᵀ in place of Σ_q G_q,
//!    and B of the hourglass motions, ω² ≤ b/m alone. Both together are bounded where they are written
//!    (`hex8_one_point.rs`, `largest_stiffness`).
//!
//! For bricks all are the same; they are equalities for a cube with λ ≥ 0 and for any brick with λ = 0, and at
//! ν = 0.3 no brick loses more than 4 % of its exact step. What distorted hexes lose stands in
//! `tests/stable_time_step.rs`. These are the moduli at rest. A theory whose stress follows from the deformation tells by how much
//! its tangent exceeds them, the stiffness of the stress included ([`Material::stiffening`](estar_material::Material::stiffening)),
//! and ω² grows by that. For the theories in rate form the stiffness of the stress is left out: it changes ω² by the order of
//! stress over modulus, which the safety factor covers (`tests/stiffening.rs` says how far).
//!
//! The bound is of the norm, so that it covers every eigenvalue of the F-bar operator. It cannot make them real: on
//! distorted hexes they have imaginary parts of some 10⁻³ of the norm, and such vibrations of an elastic body grow at any
//! step. The energy ledger shows it (figures in the verification manual).

use crate::PER_ROOT_3;
use estar_tensor::{Real, SymmetricTensor, Tensor};

/// What the bound needs of the current geometry of an element, gathered over its points.
#[derive(Clone, Copy, Debug)]
pub struct ElementGeometry<R> {
    /// g and h.
    pub metric: Metric<R>,
    /// V = Σ_q j, m³.
    pub volume: R,
    /// |V b̄|² = Σ_a |V b̄_a|², m⁴.
    pub mean_divergence_squared: R,
    /// |V b₀ − V b̄|², m⁴.
    pub divergence_difference_squared: R,
}

/// What the bound needs of the current geometry of a `tet10`.
#[derive(Clone, Copy, Debug)]
pub struct TetGeometry<R> {
    /// g and h.
    pub metric: Metric<R>,
    /// V, m³.
    pub volume: R,
    /// Σ_a |V b̄_a|²/φ_a, m⁴.
    pub divergence: R,
}

/// What the bound needs to know of the parent of a `tet10`.
#[derive(Clone, Copy, Debug)]
pub struct TetParent {
    /// κ.
    pub bound: f64,
    /// α.
    pub own_share: f64,
}

/// Greatest sizes of the metrics G = j J⁻¹J⁻ᵀ of several points.
#[derive(Clone, Copy, Debug)]
pub struct Metric<R> {
    /// Upper bound of λ_max(G), m.
    pub largest: R,
    /// tr G, m.
    pub trace: R,
}

/// What is gathered of the metrics of several points. The invariants of G are t = tr G = |C|²/j with the cofactor
/// C = j J⁻ᵀ, ½ (t² − G : G) = |J|² and det G = j; size and shape of G are t and the pair α = |J|²/t², β = j/t³, for
/// which λ_max(G) = t λ(α, β) with λ the largest root of λ³ − λ² + α λ − β = 0. That grows with β and falls with α.
#[derive(Clone, Copy, Debug)]
pub struct Metrics<R> {
    trace: R,
    alpha: R,
    beta: R,
}

impl<R: Real> Metrics<R> {
    /// Of no point yet.
    #[inline(always)]
    pub fn none() -> Self {
        Self { trace: R::splat(0.0), alpha: R::splat(f64::INFINITY), beta: R::splat(0.0) }
    }

    /// Of one metric given itself.
    #[inline(always)]
    pub fn of(metric: &SymmetricTensor<R>) -> Self {
        let trace = metric.trace();
        let per_trace = trace.recip();
        let per_trace_squared = per_trace * per_trace;
        Self {
            trace,
            alpha: (trace * trace - metric.norm_squared()) * per_trace_squared * 0.5,
            beta: metric.determinant() * per_trace * per_trace_squared,
        }
    }

    /// With one more point, from its J = ∂x/∂ξ, the cofactor and the determinant of that.
    #[inline(always)]
    pub fn with(self, gradient: &Tensor<R>, cofactor: &Tensor<R>, determinant: R) -> Self {
        let cofactor_squared = cofactor.norm_squared();
        let per_both = (cofactor_squared * determinant).recip();
        let trace = cofactor_squared * cofactor_squared * per_both;
        let per_trace = determinant * determinant * per_both;
        let per_trace_squared = per_trace * per_trace;
        Self {
            trace: self.trace.max(trace),
            alpha: self.alpha.min(gradient.norm_squared() * per_trace_squared),
            beta: self.beta.max(determinant * per_trace * per_trace_squared),
        }
    }

    /// The greatest trace, and an upper bound of λ_max from the greatest trace, the smallest α and the greatest β: exact
    /// (but for 10⁻⁶, upwards) for a parallelepiped two of whose principal values of G are equal, and for any other never
    /// more than 1 % above.
    #[inline(always)]
    pub fn greatest(self) -> Metric<R> {
        // λ = ⅓ + 2 p cos(⅓ arccos r), p² = (1 − 3 α)/9, r = (2 − 9 α + 27 β)/(54 p³), both rounded up
        let p_squared = ((self.alpha * -3.0 + 1.0) * (1.0 / 9.0)).max(R::splat(0.0)) + ROUNDING;
        let p = p_squared.sqrt();
        let numerator = self.beta.mul_add(R::splat(27.0), self.alpha * -9.0 + (2.0 + ROUNDING));
        let r = (numerator / (p_squared * p * 54.0)).max(R::splat(-1.0)).min(R::splat(1.0));
        Metric { largest: self.trace * ((p + p) * largest_root(r) + 1.0 / 3.0), trace: self.trace }
    }
}

/// More than the rounding of α and β, which are below 1.
const ROUNDING: f64 = 4e-15;

/// Elastic constants as the bound needs them, Pa.
#[derive(Clone, Copy, Debug)]
pub struct ElasticBounds {
    /// μ.
    pub shear_modulus: f64,
    /// k.
    pub bulk_modulus: f64,
}

impl ElasticBounds {
    /// Lower bound of the stable time step of `hex8` (s) with the smallest corner mass `corner_mass`.
    #[inline(always)]
    pub fn stable_time_step<R: Real>(&self, geometry: &ElementGeometry<R>, corner_mass: R) -> R {
        // Δt = 2/ω, ω² ≤ (2μ g + λ⁺ h)/m
        (corner_mass / self.stiffness(&geometry.metric)).sqrt() * 2.0
    }

    /// 2μ g + λ⁺ h.
    #[inline(always)]
    pub fn stiffness<R: Real>(&self, metric: &Metric<R>) -> R {
        metric.trace.mul_add(R::splat(self.positive_lambda()), metric.largest * (2.0 * self.shear_modulus))
    }

    /// Lower bound of the stable time step of `hex8-f-bar` (s) with the smallest corner mass `corner_mass`.
    #[inline(always)]
    pub fn stable_time_step_f_bar<R: Real>(&self, geometry: &ElementGeometry<R>, corner_mass: R) -> R {
        let mixed = (geometry.mean_divergence_squared * geometry.divergence_difference_squared).sqrt();
        self.with_mean_dilatation(geometry, mixed * self.bulk_modulus, corner_mass)
    }

    /// Lower bound of the stable time step of `hex8-b-bar` (s) with the smallest corner mass `corner_mass`.
    #[inline(always)]
    pub fn stable_time_step_b_bar<R: Real>(&self, geometry: &ElementGeometry<R>, corner_mass: R) -> R {
        self.with_mean_dilatation(geometry, R::splat(0.0), corner_mass)
    }

    /// Δt = 2/ω, ω² ≤ (2μ g V + λ⁺ |V b̄|² + `mixed`)/(m V), of F-bar with k |V b̄| |V b₀ − V b̄|.
    #[inline(always)]
    fn with_mean_dilatation<R: Real>(&self, geometry: &ElementGeometry<R>, mixed: R, corner_mass: R) -> R {
        let volumetric = geometry.mean_divergence_squared * self.positive_lambda() + mixed;
        let deviatoric = geometry.metric.largest * geometry.volume * (2.0 * self.shear_modulus);
        (corner_mass * geometry.volume / (deviatoric + volumetric)).sqrt() * 2.0
    }

    /// Lower bound of the stable time step of `tet10` (s) of mass `mass`.
    #[inline(always)]
    pub fn stable_time_step_tet10<R: Real>(&self, geometry: &TetGeometry<R>, parent: &TetParent, mass: R) -> R {
        let own = (parent.own_share * parent.own_share * self.bulk_modulus - 2.0 * self.shear_modulus / 3.0).max(0.0);
        let of_points =
            geometry.metric.trace.mul_add(R::splat(own), geometry.metric.largest * (2.0 * self.shear_modulus));
        let deviatoric = of_points * geometry.volume * parent.bound;
        let volumetric = geometry.divergence * self.positive_lambda();
        (mass * geometry.volume / (deviatoric + volumetric)).sqrt() * 2.0
    }

    /// Lower bound of the stable time step of `tet4` (s) with the mass `corner_mass` of each corner.
    #[inline(always)]
    pub fn stable_time_step_tet4<R: Real>(&self, metric: &Metric<R>, corner_mass: R) -> R {
        (corner_mass * 1.5 / self.stiffness(metric)).sqrt() * 2.0
    }

    /// λ⁺.
    #[inline(always)]
    fn positive_lambda(&self) -> f64 {
        (self.bulk_modulus - 2.0 * self.shear_modulus / 3.0).max(0.0)
    }
}

/// Upper bound of cos(⅓ arccos r) for −1 ≤ r ≤ 1: with s = √(½ (1 + r)) it is cos(⅔ arccos s), a concave function of
/// s, and ½ + s/√3 − (1/√3 − ½) s² touches it at both ends and lies above between.
#[inline(always)]
fn largest_root<R: Real>(r: R) -> R {
    let s = (r * 0.5 + 0.5).sqrt();
    (s * (0.5 - PER_ROOT_3) + PER_ROOT_3).mul_add(s, R::splat(0.5))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn largest_root_is_bounded_from_above_and_closely() {
        for i in 0..=200_000 {
            let r = -1.0 + f64::from(i) * 1e-5;
            let exact = (r.acos() / 3.0).cos();
            let bound = largest_root(r);
            assert!(bound >= exact - 1e-15 && bound <= exact + 0.006, "{r}: {bound} {exact}");
        }
    }
}
