//! Closest-point return in the energy norm ("Exploring closest point return plasticity", cited as CP).
//!
//! In perfect plasticity with associated flow, backward Euler returns a trial stress to the point of the yield surface that is
//! nearest in ‖σ‖² = σ : C⁻¹ : σ (CP, introduction). With Lode coordinates z = tr σ/√3 and r = ‖dev σ‖ the norm is Euclidean
//! in z* = z/√(3k) and r* = r/√(2μ). One projector of principal stresses serves two kinds of convex surface:
//!
//! - of revolution: r ≤ A − B z, a cylinder (von Mises) or a cone with its apex (Drucker-Prager); a line in (z*, r*)
//! - polyhedral: a · σ ≤ c for the sorted principal stresses σ₁ ≥ σ₂ ≥ σ₃ (Rankine, Mohr-Coulomb); the nearest point lies on
//!   the face, on one of its edges σ₁ = σ₂ and σ₂ = σ₃, or at the apex, and is the nearest of these that is admissible
//!
//! Drucker-Prager may also flow along another cone, with a dilatancy angle of its own: then the return follows the normal of
//! the flow potential r + B_ψ z, and nothing is nearest.
//!
//! Parameters: elasticity, surface. No history.

use crate::IsotropicElasticity;
use crate::parameter::{ParameterError, checked, not_negative, positive};
use estar_tensor::{Real, array, inlined};

/// A yield surface with the elasticity that measures distance from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosestPoint {
    elasticity: IsotropicElasticity,
    surface: Surface,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Surface {
    /// r ≤ radius − slope z; flow along the normal of r + dilatancy z.
    Revolution { radius: f64, slope: f64, dilatancy: f64 },
    /// (1 + s) σ₁ − (1 − s) σ₃ ≤ bound; s = 1 is Rankine's surface.
    Polyhedral { sine: f64, bound: f64 },
}

impl ClosestPoint {
    /// √(3/2) ‖dev σ‖ ≤ `yield_stress`.
    ///
    /// # Errors
    /// `yield_stress` not greater than 0.
    pub fn von_mises(elasticity: IsotropicElasticity, yield_stress: f64) -> Result<Self, ParameterError> {
        let radius = (2.0_f64 / 3.0).sqrt() * positive("yield_stress", yield_stress)?;
        Ok(Self { elasticity, surface: Surface::Revolution { radius, slope: 0.0, dilatancy: 0.0 } })
    }

    /// √(½) ‖dev σ‖ + α tr σ ≤ κ, α = 2 sin φ/(√3 (3 − sin φ)), κ = 6 c cos φ/(√3 (3 − sin φ)): the cone through the outer
    /// edges of Mohr and Coulomb's, with friction angle φ, cohesion c (Pa) and dilatancy angle ψ; angles in rad. The flow is
    /// associated for ψ = φ.
    ///
    /// # Errors
    /// A friction angle outside (0, π/2), a cohesion not greater than 0, or a dilatancy angle outside [0, φ].
    pub fn drucker_prager(
        elasticity: IsotropicElasticity,
        friction_angle: f64,
        cohesion: f64,
        dilatancy_angle: f64,
    ) -> Result<Self, ParameterError> {
        let friction = friction(friction_angle)?;
        let bound = "it must lie between 0 and friction_angle";
        let dilatancy_angle = checked("dilatancy_angle", dilatancy_angle, |psi| 0.0 <= psi && psi <= friction, bound)?;
        // r = √2 (κ − α √3 z)
        let slope = |angle: f64| 2.0 * 2.0_f64.sqrt() * angle.sin() / (3.0 - angle.sin());
        let radius = 2.0 * 6.0_f64.sqrt() * positive("cohesion", cohesion)? * friction.cos() / (3.0 - friction.sin());
        let surface = Surface::Revolution { radius, slope: slope(friction), dilatancy: slope(dilatancy_angle) };
        Ok(Self { elasticity, surface })
    }

    /// σ₁ ≤ `strength`.
    ///
    /// # Errors
    /// A negative `strength`.
    pub fn rankine(elasticity: IsotropicElasticity, strength: f64) -> Result<Self, ParameterError> {
        let bound = 2.0 * not_negative("strength", strength)?;
        Ok(Self { elasticity, surface: Surface::Polyhedral { sine: 1.0, bound } })
    }

    /// (1 + sin φ) σ₁ − (1 − sin φ) σ₃ ≤ 2 c cos φ with friction angle φ (rad) and cohesion c (Pa).
    ///
    /// # Errors
    /// A friction angle outside (0, π/2), or a cohesion not greater than 0.
    pub fn mohr_coulomb(
        elasticity: IsotropicElasticity,
        friction_angle: f64,
        cohesion: f64,
    ) -> Result<Self, ParameterError> {
        let friction = friction(friction_angle)?;
        let bound = 2.0 * positive("cohesion", cohesion)? * friction.cos();
        Ok(Self { elasticity, surface: Surface::Polyhedral { sine: friction.sin(), bound } })
    }

    /// f(σ) of sorted principal stresses, Pa: not positive where the stress is admissible.
    #[inline(always)]
    pub fn yield_function<R: Real>(&self, stress: [R; 3]) -> R {
        match self.surface {
            Surface::Revolution { radius, slope, .. } => {
                let Lode { z, r, .. } = Lode::new(stress);
                z.mul_add(R::splat(slope), r) - radius
            }
            Surface::Polyhedral { sine, bound } => stress[0] * (1.0 + sine) - stress[2] * (1.0 - sine) - bound,
        }
    }

    /// ‖σ‖² = σ : C⁻¹ : σ of principal stresses, Pa.
    #[inline(always)]
    pub fn energy_norm_squared<R: Real>(&self, stress: [R; 3]) -> R {
        let Lode { z, r, .. } = Lode::new(stress);
        let [volumetric, deviatoric] = self.compliances();
        (z * z).mul_add(R::splat(volumetric), r * r * deviatoric)
    }

    /// The returned principal stresses of the sorted `trial`, σ₁ ≥ σ₂ ≥ σ₃; the trial itself where it is admissible.
    #[inline(always)]
    pub fn returned<R: Real>(&self, trial: [R; 3]) -> [R; 3] {
        let outside = self.yield_function(trial).gt(R::splat(0.0));
        let point = match self.surface {
            Surface::Revolution { radius, slope, dilatancy } => self.on_cone(trial, radius, slope, dilatancy),
            Surface::Polyhedral { sine, bound } => self.on_polyhedron(trial, sine, bound),
        };
        array(|i| R::select(outside, point[i], trial[i]))
    }

    /// The elasticity that measures distance.
    pub fn elasticity(&self) -> &IsotropicElasticity {
        &self.elasticity
    }

    /// Whether the flow keeps the volume everywhere, at an apex too.
    #[inline(always)]
    pub fn keeps_volume(&self) -> bool {
        matches!(self.surface, Surface::Revolution { slope, .. } if slope == 0.0)
    }

    /// [1/3k, 1/2μ].
    fn compliances(&self) -> [f64; 2] {
        [(3.0 * self.elasticity.bulk_modulus()).recip(), (2.0 * self.elasticity.shear_modulus()).recip()]
    }

    /// The point of r = A − B z along the flow (z, r) −= Δγ (3k B_ψ, 2μ), or the apex z = A/B where that leads to r < 0.
    #[inline(always)]
    fn on_cone<R: Real>(&self, trial: [R; 3], radius: f64, slope: f64, dilatancy: f64) -> [R; 3] {
        let [three_k, two_mu] = [3.0 * self.elasticity.bulk_modulus(), 2.0 * self.elasticity.shear_modulus()];
        let Lode { z, r, direction } = Lode::new(trial);
        let excess = z.mul_add(R::splat(slope), r) - radius;
        let multiplier = excess * (two_mu + three_k * slope * dilatancy).recip();
        let r_cone = r - multiplier * two_mu;
        let beyond = r_cone.lt(R::splat(0.0));
        let apex = if slope > 0.0 { radius / slope } else { f64::INFINITY };
        let r_new = R::select(beyond, R::splat(0.0), r_cone);
        let z_new = R::select(beyond, R::splat(apex), z - multiplier * (three_k * dilatancy));
        let mean = z_new * THIRD_ROOT;
        array(|i| direction[i].mul_add(r_new, mean))
    }

    /// The nearest of the face, the edges and the apex that is sorted and admissible.
    #[inline(always)]
    fn on_polyhedron<R: Real>(&self, trial: [R; 3], sine: f64, bound: f64) -> [R; 3] {
        let [mu, lambda] = [self.elasticity.shear_modulus(), self.elasticity.lame_lambda()];
        // C a = 2μ a + λ (1·a) 1
        let stiff = inlined!(|a: [f64; 3]| -> [f64; 3] {
            let spherical = lambda * (a[0] + a[1] + a[2]);
            [2.0 * mu * a[0] + spherical, 2.0 * mu * a[1] + spherical, 2.0 * mu * a[2] + spherical]
        });
        // σ − (a · σ − c)/(a · C a) C a, with a the mean of the normals of the faces that meet: by symmetry they flow alike
        let projected = inlined!(|stress: [R; 3], a: [f64; 3]| -> [R; 3] {
            let flow = stiff(a);
            let stiffness = a[0] * flow[0] + a[1] * flow[1] + a[2] * flow[2];
            let excess = stress[0] * a[0] + stress[1] * a[1] + stress[2] * a[2] - bound;
            let multiplier = excess * stiffness.recip();
            [stress[0] - multiplier * flow[0], stress[1] - multiplier * flow[1], stress[2] - multiplier * flow[2]]
        });
        let (tension, compression) = (1.0 + sine, sine - 1.0);
        let upper = (trial[0] + trial[1]) * 0.5;
        let lower = (trial[1] + trial[2]) * 0.5;
        // (1 + s + s − 1) σ = c at the apex
        let apex = R::splat(bound / (2.0 * sine));
        let candidates = [
            projected(trial, [tension, 0.0, compression]),
            projected([upper, upper, trial[2]], [0.5 * tension, 0.5 * tension, compression]),
            projected([trial[0], lower, lower], [tension, 0.5 * compression, 0.5 * compression]),
        ];
        let mut best = [apex; 3];
        let distance = inlined!(|point: [R; 3]| {
            self.energy_norm_squared([point[0] - trial[0], point[1] - trial[1], point[2] - trial[2]])
        });
        let mut least = distance(best);
        for point in candidates {
            // sorted, but for rounding: on this side of the apex
            let slack = (point[0].abs() + point[2].abs()) * SORTED;
            let sorted = (point[1] - slack).le(point[0]) & (point[2] - slack).le(point[1]);
            let candidate = distance(point);
            let nearer = sorted & candidate.lt(least);
            least = R::select(nearer, candidate, least);
            best = array(|i| R::select(nearer, point[i], best[i]));
        }
        best
    }
}

const THIRD_ROOT: f64 = 0.577_350_269_189_625_8;
/// Principal values that differ by less of their size are equal.
const SORTED: f64 = 1e-15;

/// z = tr σ/√3, r = ‖dev σ‖ and dev σ/r.
struct Lode<R> {
    z: R,
    r: R,
    direction: [R; 3],
}

impl<R: Real> Lode<R> {
    #[inline(always)]
    fn new(stress: [R; 3]) -> Self {
        let z = (stress[0] + stress[1] + stress[2]) * THIRD_ROOT;
        let mean = z * THIRD_ROOT;
        let deviator: [R; 3] = array(|i| stress[i] - mean);
        let [a, b, c] = deviator;
        let r = a.mul_add(a, b.mul_add(b, c * c)).sqrt();
        let safe = R::select(r.gt(R::splat(0.0)), r, R::splat(1.0));
        Self { z, r, direction: array(|i| deviator[i] / safe) }
    }
}

fn friction(angle: f64) -> Result<f64, ParameterError> {
    let bound = "it must lie between 0 and a right angle";
    checked("friction_angle", angle, |phi| 0.0 < phi && phi < std::f64::consts::FRAC_PI_2, bound)
}
