//! Yield surfaces in principal values with their return mappings, for theories whose flow keeps the principal directions and
//! whose stress is linear in a strain of them (RM section 1; see [`crate::Hencky`]). With principal strains ε and stresses
//! τᵢ = 2μ εᵢ + λ tr ε:
//!
//! - [`VonMises`]: √(3/2) ‖dev τ‖ ≤ σ_y. The return scales the deviator. ε̄ᵖ grows by √⅔ ‖Δε_p‖.
//! - [`Rankine`]: τ₁ ≤ σ_y. The return levels the principal values: with ε₁ ≥ ε₂ ≥ ε₃ and p = tr Δε_p, by which ε̄ᵖ grows, the
//!   j largest are cut to one value, and since each cut falls slower with p than the one before,
//!   - ε_i = min(ε_i, w), w = max_j ((ε₁ + … + ε_j − p)/j)
//!   - the cut stress is c(p) = max_j ((τ₁ + … + τ_j)/j − (λ + 2μ/j) p) and c(p) = σ_y(ε̄ᵖ_n + p)
//!
//!   The four branches of RM section 1 are p = 0 and j = 1, 2, 3.
//! - [`ClosestPoint`]: any of its surfaces, perfectly plastic: Δε_p = C⁻¹(τ_trial − τ). ε̄ᵖ grows by √⅔ ‖Δε_p‖.
//!
//! Von Mises keeps the volume; Rankine opens, and so do the cones.
//!
//! The source prints the deviator of its von Mises branch as τ̂ − (1·τ̂) 1; it is τ̂ − ⅓ (1·τ̂) 1. In uniaxial stress σ the
//! norm is √⅔ σ = 0.8165 σ, and √2 σ = 1.4142 σ as printed.

use crate::closest_point::ClosestPoint;
use crate::e_star::von_mises;
use crate::hardening::{FlowStart, Hardening, IsotropicHardening};
use crate::return_mapping::{Equivalent, RadialReturn, plastic_increment, radial_hardening_index};
use crate::{IsotropicElasticity, PointState, YieldCriterion};
use estar_tensor::{Real, SymmetricTensor, array, inlined};

/// A yield surface in principal values.
pub trait PrincipalSurface: Clone + Send + Sync + 'static {
    /// What the hardening law remembers besides ε̄ᵖ.
    type Memory<R: Real>: PointState<R>;

    /// Whether tr Δε_p = 0.
    fn keeps_volume(&self) -> bool;

    /// The memory of the undeformed material.
    fn initial_memory<R: Real>(&self) -> Self::Memory<R>;

    /// The return of the principal strains ε₁ ≥ ε₂ ≥ ε₃ of a trial. Implementations are `#[inline(always)]`.
    fn returned<R: Real>(
        &self,
        elasticity: &IsotropicElasticity,
        strain: [R; 3],
        start: &FlowStart<R, Self::Memory<R>>,
    ) -> PrincipalReturn<R>;

    /// Φ = f̂/ĝ at principal stresses (Pa), ε̄ᵖ and a memory on the surface.
    fn hardening_index(
        &self,
        elasticity: &IsotropicElasticity,
        principal_stress: [f64; 3],
        plastic_strain: f64,
        memory: &Self::Memory<f64>,
    ) -> f64;

    /// See [`Material::yield_criterion`](crate::Material::yield_criterion); of the principal stresses σ₁ ≥ σ₂ ≥ σ₃ of a
    /// predictor (Pa).
    fn yield_criterion(
        &self,
        principal_stress: [f64; 3],
        plastic_strain: f64,
        memory: &Self::Memory<f64>,
    ) -> Option<YieldCriterion>;

    /// See [`Hardening::heated`].
    #[inline(always)]
    fn heated<R: Real>(&self, memory: Self::Memory<R>, _dissipation: R) -> Self::Memory<R> {
        memory
    }

    /// Temperature, K, of a law that has one. Implementations are `#[inline(always)]`.
    #[inline(always)]
    fn temperature<R: Real>(&self, _memory: &Self::Memory<R>) -> Option<R> {
        None
    }

    /// The share of the plastic dissipation that heats, of a law that has a temperature.
    fn heat_share(&self) -> Option<f64> {
        None
    }
}

/// A return in principal values.
#[derive(Clone, Copy, Debug)]
pub struct PrincipalReturn<R: Real> {
    /// Lanes outside the surface.
    pub yields: R::Mask,
    /// Δε_p,ᵢ; zero in lanes that do not yield.
    pub flow: [R; 3],
    /// Δε̄ᵖ.
    pub plastic_increment: R,
}

/// √(3/2) ‖dev τ‖ = σ_y.
#[derive(Clone, Debug, PartialEq)]
pub struct VonMises<H> {
    pub(crate) hardening: H,
}

impl<H: Hardening> PrincipalSurface for VonMises<H> {
    type Memory<R: Real> = H::Memory<R>;

    #[inline(always)]
    fn keeps_volume(&self) -> bool {
        true
    }

    fn initial_memory<R: Real>(&self) -> H::Memory<R> {
        self.hardening.initial_memory()
    }

    /// (ii) admissibility: √(3/2) ‖dev τ_trial‖ ≤ σ_y, and (iii) return mapping: Δε_p = (3/2) p dev τ/(√(3/2) ‖dev τ‖).
    #[inline(always)]
    fn returned<R: Real>(
        &self,
        elasticity: &IsotropicElasticity,
        strain: [R; 3],
        start: &FlowStart<R, H::Memory<R>>,
    ) -> PrincipalReturn<R> {
        let mean = (strain[0] + strain[1] + strain[2]) * (1.0 / 3.0);
        let deviator: [R; 3] = array(|i| strain[i] - mean);
        let [a, b, c] = deviator;
        // √(3/2) ‖dev ε‖
        let equivalent_strain = (a.mul_add(a, b.mul_add(b, c * c)) * 1.5).sqrt();
        let equivalent_stress = equivalent_strain * (2.0 * elasticity.shear_modulus());
        let law = RadialReturn { elasticity, hardening: &self.hardening, start: *start };
        let flow_stress_old = law.flow_stress_old();
        let yields = equivalent_stress.gt(flow_stress_old.stress);
        let p = law.plastic_increment(yields, equivalent_stress, flow_stress_old);
        let safe_strain = R::select(yields, equivalent_strain, R::splat(1.0));
        let factor = R::select(yields, p * 1.5 / safe_strain, R::splat(0.0));
        PrincipalReturn { yields, flow: array(|i| deviator[i] * factor), plastic_increment: p }
    }

    /// Φ = H/(3μ + H).
    fn hardening_index(
        &self,
        elasticity: &IsotropicElasticity,
        principal_stress: [f64; 3],
        plastic_strain: f64,
        memory: &H::Memory<f64>,
    ) -> f64 {
        let flow_stress = von_mises(&SymmetricTensor::diagonal(principal_stress).deviator());
        radial_hardening_index(elasticity, self.hardening.slope_of_flow(plastic_strain, memory, flow_stress))
    }

    /// √(3/2) ‖dev τ‖.
    fn yield_criterion(
        &self,
        principal_stress: [f64; 3],
        plastic_strain: f64,
        memory: &H::Memory<f64>,
    ) -> Option<YieldCriterion> {
        let equivalent_stress = von_mises(&SymmetricTensor::diagonal(principal_stress).deviator());
        YieldCriterion::under(&self.hardening, plastic_strain, memory, equivalent_stress)
    }

    #[inline(always)]
    fn heated<R: Real>(&self, memory: H::Memory<R>, dissipation: R) -> H::Memory<R> {
        self.hardening.heated(memory, dissipation)
    }

    #[inline(always)]
    fn temperature<R: Real>(&self, memory: &H::Memory<R>) -> Option<R> {
        self.hardening.temperature(memory)
    }

    fn heat_share(&self) -> Option<f64> {
        self.hardening.heat_share()
    }
}

/// Largest principal value = σ_y: materials that break in tension.
#[derive(Clone, Debug, PartialEq)]
pub struct Rankine {
    pub(crate) hardening: IsotropicHardening,
}

/// Principal stresses that differ by less of their size are equal.
const EQUAL: f64 = 1e-9;

/// λ + 2μ/j, Pa: how fast the cut stress falls with p where the j largest are cut.
#[inline(always)]
fn cut_modulus(elasticity: &IsotropicElasticity, j: usize) -> f64 {
    elasticity.lame_lambda() + 2.0 * elasticity.shear_modulus() / j as f64
}

impl PrincipalSurface for Rankine {
    type Memory<R: Real> = ();

    #[inline(always)]
    fn keeps_volume(&self) -> bool {
        false
    }

    fn initial_memory<R: Real>(&self) {}

    /// (ii) admissibility: τ₁ ≤ σ_y, and (iii) return mapping: c(p) = σ_y(ε̄ᵖ_n + p).
    #[inline(always)]
    fn returned<R: Real>(
        &self,
        elasticity: &IsotropicElasticity,
        strain: [R; 3],
        start: &FlowStart<R, ()>,
    ) -> PrincipalReturn<R> {
        let zero = R::splat(0.0);
        let flow_stress_old = self.hardening.flow_stress(start, zero);
        let [first, second, third] = elasticity.principal_stress(strain);
        let means = [first, (first + second) * 0.5, (first + second + third) * (1.0 / 3.0)];
        let moduli: [f64; 3] = array(|j| cut_modulus(elasticity, j + 1));
        let yields = first.gt(flow_stress_old.stress);
        let most = inlined!(|values: [R; 3]| values[0].max(values[1]).max(values[2]));
        let p = if let Some(slope) = self.hardening.constant_slope() {
            // where every line falls, the root of their maximum is the largest of their roots
            let roots = array(|j| (means[j] - flow_stress_old.stress) * (moduli[j] + slope).recip());
            R::select(yields, most(roots), zero)
        } else {
            let equivalent = inlined!(|p: R| {
                let mut cut = Equivalent { stress: means[0] - p * moduli[0], slope: R::splat(-moduli[0]) };
                for j in 1..3 {
                    let stress = means[j] - p * moduli[j];
                    let above = stress.gt(cut.stress);
                    cut.stress = R::select(above, stress, cut.stress);
                    cut.slope = R::select(above, R::splat(-moduli[j]), cut.slope);
                }
                cut
            });
            let flow = inlined!(|p: R| self.hardening.flow_stress(start, p));
            let upper_bound = most(array(|j| means[j] * moduli[j].recip()));
            plastic_increment(yields, upper_bound, (equivalent(zero), flow_stress_old), equivalent, flow)
        };
        let sums = [strain[0], strain[0] + strain[1], strain[0] + strain[1] + strain[2]];
        let level = most([sums[0] - p, (sums[1] - p) * 0.5, (sums[2] - p) * (1.0 / 3.0)]);
        let flow = array(|i| R::select(yields, (strain[i] - level).max(zero), zero));
        PrincipalReturn { yields, flow, plastic_increment: p }
    }

    /// Φ = H/(λ + 2μ/j + H) with the j largest principal values on the cut.
    fn hardening_index(
        &self,
        elasticity: &IsotropicElasticity,
        principal_stress: [f64; 3],
        plastic_strain: f64,
        _: &(),
    ) -> f64 {
        let largest = principal_stress[0];
        let on_cut = principal_stress.iter().filter(|value| **value >= largest - EQUAL * largest.abs()).count();
        let slope = self.hardening.at(plastic_strain).slope;
        slope / (cut_modulus(elasticity, on_cut) + slope)
    }

    /// τ₁.
    fn yield_criterion(&self, principal_stress: [f64; 3], plastic_strain: f64, memory: &()) -> Option<YieldCriterion> {
        YieldCriterion::under(&self.hardening, plastic_strain, memory, principal_stress[0])
    }
}

impl PrincipalSurface for ClosestPoint {
    type Memory<R: Real> = ();

    #[inline(always)]
    fn keeps_volume(&self) -> bool {
        ClosestPoint::keeps_volume(self)
    }

    fn initial_memory<R: Real>(&self) {}

    /// (ii) admissibility: f(τ_trial) ≤ 0, and (iii) return mapping: Δε_p = C⁻¹(τ_trial − τ).
    #[inline(always)]
    fn returned<R: Real>(
        &self,
        elasticity: &IsotropicElasticity,
        strain: [R; 3],
        _: &FlowStart<R, ()>,
    ) -> PrincipalReturn<R> {
        let zero = R::splat(0.0);
        let trial = elasticity.principal_stress(strain);
        let yields = self.yield_function(trial).gt(zero);
        let stress = ClosestPoint::returned(self, trial);
        let lost: [R; 3] = array(|i| trial[i] - stress[i]);
        // C⁻¹σ = (σ − λ/3k tr(σ) 1)/2μ
        let share = elasticity.lame_lambda() / (3.0 * elasticity.bulk_modulus());
        let spherical = (lost[0] + lost[1] + lost[2]) * share;
        let per_two_mu = (2.0 * elasticity.shear_modulus()).recip();
        let [a, b, c] = array(|i| R::select(yields, (lost[i] - spherical) * per_two_mu, zero));
        let plastic_increment = (a.mul_add(a, b.mul_add(b, c * c)) * (2.0 / 3.0)).sqrt();
        PrincipalReturn { yields, flow: [a, b, c], plastic_increment }
    }

    /// Perfectly plastic: 0.
    fn hardening_index(&self, _: &IsotropicElasticity, _: [f64; 3], _: f64, _: &()) -> f64 {
        0.0
    }

    /// f(τ) − f(0), which may reach −f(0).
    fn yield_criterion(&self, principal_stress: [f64; 3], _: f64, _: &()) -> Option<YieldCriterion> {
        let flow_stress = -self.yield_function([0.0; 3]);
        let equivalent_stress = self.yield_function(principal_stress) + flow_stress;
        Some(YieldCriterion { equivalent_stress, flow_stress })
    }
}
