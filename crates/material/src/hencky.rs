//! Hencky hyperelasticity with return mapping in principal values, for the surfaces of von Mises and of Rankine
//! ("Supplementary notes on return mapping and theory of plasticity", sections 1 to 3, cited as RM).
//!
//! With b_e = F C_p⁻¹ Fᵀ, ε = ½ ln b_e and the Kirchhoff stress τ = J T:
//!
//! - elasticity   ψ = μ ε : ε + ½ λ (tr ε)², τ = 2μ ε + λ tr(ε) I
//! - yield        von Mises: √(3/2) ‖dev τ‖ ≤ σ_y(ε̄ᵖ); Rankine: the largest principal value of τ ≤ σ_y(ε̄ᵖ)
//! - flow         associated: ε_trial − ε_{n+1} = Δγ ∂y/∂τ (RM 1), which keeps the principal directions
//! - hardening    ε̄ᵖ grows by what σ_y works on: √⅔ ‖Δε_p‖ for von Mises, tr Δε_p for Rankine
//!
//! The return of von Mises scales the deviator. That of Rankine levels the principal values: with ε₁ ≥ ε₂ ≥ ε₃ and
//! p = tr Δε_p, the j largest are cut to one value, and since each cut falls slower with p than the one before,
//!
//! - ε_i = min(ε_i, w), w = max_j ((ε₁ + … + ε_j − p)/j)
//! - the cut stress is c(p) = max_j ((τ₁ + … + τ_j)/j − (λ + 2μ/j) p) and c(p) = σ_y(ε̄ᵖ_n + p)
//!
//! The four branches of RM section 1 are p = 0 and j = 1, 2, 3. Von Mises keeps det C_p = 1; Rankine opens, so det C_p grows.
//!
//! Plastic dissipation −½ τ : (L_v b_e b_e⁻¹) ≥ 0 (RM 27) with L_v b_e = F (dC_p⁻¹/dt) Fᵀ; over a step that is τ : Δε_p.
//!
//! The source prints the deviator of its von Mises branch as τ̂ − (1·τ̂) 1; it is τ̂ − ⅓ (1·τ̂) 1. In uniaxial stress σ the
//! norm is √⅔ σ = 0.8165 σ, and √2 σ = 1.4142 σ as printed.
//!
//! Parameters: elasticity, hardening, yield surface. History: C_p⁻¹, ε̄ᵖ, and T for the stress power of the next step.

use crate::elastic::stress_power;
use crate::metric_state::isochoric;
use crate::return_mapping::{Equivalent, plastic_increment, radial_hardening_index, radial_increment};
use crate::{
    FlowStress, IsotropicElasticity, IsotropicHardening, Material, MaterialUpdate, MetricState, SpatialMotion,
};
use estar_tensor::{Mask, Real, Rotation, SymmetricTensor, array, inlined};

/// Hencky hyperelasticity with plasticity.
#[derive(Clone, Debug)]
pub struct Hencky {
    elasticity: IsotropicElasticity,
    hardening: IsotropicHardening,
    surface: HenckySurface,
}

/// Principal stresses that differ by less of their size are equal.
const EQUAL: f64 = 1e-9;

/// Which Kirchhoff stresses yield.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HenckySurface {
    /// √(3/2) ‖dev τ‖ = σ_y.
    VonMises,
    /// Largest principal value = σ_y: materials that break in tension.
    Rankine,
}

/// A return in principal values.
pub(crate) struct PrincipalReturn<R: Real> {
    pub yields: R::Mask,
    /// Δε_p,ᵢ; zero in lanes that do not yield.
    pub flow: [R; 3],
    /// Δε̄ᵖ.
    pub plastic_increment: R,
}

impl Hencky {
    /// The material with these parameters.
    pub fn new(elasticity: IsotropicElasticity, hardening: IsotropicHardening, surface: HenckySurface) -> Self {
        Self { elasticity, hardening, surface }
    }

    /// τᵢ = 2μ εᵢ + λ tr ε, Pa, of principal Hencky strains.
    #[inline(always)]
    pub fn principal_stress<R: Real>(&self, strain: [R; 3]) -> [R; 3] {
        let spherical = (strain[0] + strain[1] + strain[2]) * self.elasticity.lame_lambda();
        array(|i| strain[i].mul_add(R::splat(2.0 * self.elasticity.shear_modulus()), spherical))
    }

    /// (ii) admissibility: √(3/2) ‖dev τ_trial‖ ≤ σ_y, and (iii) return mapping: Δε_p = (3/2) p dev τ/(√(3/2) ‖dev τ‖).
    #[inline(always)]
    pub(crate) fn von_mises_return<R: Real>(
        &self,
        strain: [R; 3],
        plastic_strain: R,
        flow_stress: FlowStress<R>,
    ) -> PrincipalReturn<R> {
        let mean = (strain[0] + strain[1] + strain[2]) * (1.0 / 3.0);
        let deviator: [R; 3] = array(|i| strain[i] - mean);
        let [a, b, c] = deviator;
        // √(3/2) ‖dev ε‖
        let equivalent_strain = (a.mul_add(a, b.mul_add(b, c * c)) * 1.5).sqrt();
        let equivalent_stress = equivalent_strain * (2.0 * self.elasticity.shear_modulus());
        let yields = equivalent_stress.gt(flow_stress.stress);
        let Self { elasticity, hardening, .. } = self;
        let p = radial_increment(elasticity, hardening, yields, equivalent_stress, plastic_strain, flow_stress);
        let safe_strain = R::select(yields, equivalent_strain, R::splat(1.0));
        let factor = R::select(yields, p * 1.5 / safe_strain, R::splat(0.0));
        PrincipalReturn { yields, flow: array(|i| deviator[i] * factor), plastic_increment: p }
    }

    /// λ + 2μ/j, Pa: how fast the cut stress falls with p where the j largest are cut.
    #[inline(always)]
    fn cut_modulus(&self, j: usize) -> f64 {
        self.elasticity.lame_lambda() + 2.0 * self.elasticity.shear_modulus() / j as f64
    }

    /// (ii) admissibility: τ₁ ≤ σ_y, and (iii) return mapping: c(p) = σ_y(ε̄ᵖ_n + p).
    #[inline(always)]
    fn rankine_return<R: Real>(
        &self,
        strain: [R; 3],
        plastic_strain: R,
        flow_stress: FlowStress<R>,
    ) -> PrincipalReturn<R> {
        let zero = R::splat(0.0);
        let [first, second, third] = self.principal_stress(strain);
        let means = [first, (first + second) * 0.5, (first + second + third) * (1.0 / 3.0)];
        let moduli: [f64; 3] = array(|j| self.cut_modulus(j + 1));
        let yields = first.gt(flow_stress.stress);
        let most = inlined!(|values: [R; 3]| values[0].max(values[1]).max(values[2]));
        let p = if let Some(slope) = self.hardening.constant_slope() {
            // where every line falls, the root of their maximum is the largest of their roots
            let roots = array(|j| (means[j] - flow_stress.stress) * (moduli[j] + slope).recip());
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
            let flow = inlined!(|p: R| self.hardening.flow_stress(plastic_strain + p));
            let upper_bound = most(array(|j| means[j] * moduli[j].recip()));
            plastic_increment(yields, upper_bound, (equivalent(zero), flow_stress), equivalent, flow)
        };
        let sums = [strain[0], strain[0] + strain[1], strain[0] + strain[1] + strain[2]];
        let level = most([sums[0] - p, (sums[1] - p) * 0.5, (sums[2] - p) * (1.0 / 3.0)]);
        let flow = array(|i| R::select(yields, (strain[i] - level).max(zero), zero));
        PrincipalReturn { yields, flow, plastic_increment: p }
    }
}

/// ε = ½ ln b_e in principal values.
#[inline(always)]
pub(crate) fn hencky_strain<R: Real>(elastic_metric: &[R; 3]) -> [R; 3] {
    array(|i| elastic_metric[i].max(R::splat(f64::MIN_POSITIVE)).ln() * 0.5)
}

impl Material for Hencky {
    type State<R: Real> = MetricState<R>;

    type Motion<R: Real> = SpatialMotion<R>;

    fn elasticity(&self) -> &IsotropicElasticity {
        &self.elasticity
    }

    /// 1/J: the moduli are those of the Kirchhoff stress.
    #[inline(always)]
    fn stiffening<R: Real>(&self, motion: &SpatialMotion<R>) -> Option<R> {
        Some(motion.deformation_gradient.determinant().recip())
    }

    fn initial_state<R: Real>(&self) -> MetricState<R> {
        MetricState::initial()
    }

    #[inline(always)]
    fn update<R: Real>(&self, old: &MetricState<R>, motion: &SpatialMotion<R>) -> MaterialUpdate<R, MetricState<R>> {
        let strain_old = old.equivalent_plastic_strain;
        let gradient = &motion.deformation_gradient;

        // (i) elastic predictor: ε_trial = ½ ln(F C_p⁻¹ Fᵀ) with the plastic metric of t_n
        let trial = old.inverse_plastic_metric.pushed_by(gradient).eigensystem();
        let values: [R; 3] = array(|i| trial.values[i].max(R::splat(f64::MIN_POSITIVE)));
        let strain = hencky_strain(&values);

        // (ii) admissibility, (iii) return mapping
        let flow_stress = self.hardening.flow_stress(strain_old);
        let returned = match self.surface {
            HenckySurface::VonMises => self.von_mises_return(strain, strain_old, flow_stress),
            HenckySurface::Rankine => self.rankine_return(strain, strain_old, flow_stress),
        };
        let kirchhoff = self.principal_stress(array(|i| strain[i] - returned.flow[i]));
        let per_volume = gradient.determinant().recip();
        let in_space = inlined!(|values: [R; 3]| SymmetricTensor::diagonal(values).pushed_by(&trial.vectors));

        let mut state = MetricState { stress: in_space(kirchhoff) * per_volume, ..*old };
        let mut dissipation = R::splat(0.0);
        if returned.yields.any() {
            // b_e = Σ λᵢ² exp(−2 Δε_p,ᵢ) vᵢ⊗vᵢ and C_p⁻¹ = F⁻¹ b_e F⁻ᵀ
            let elastic_metric = in_space(array(|i| values[i] * (returned.flow[i] * -2.0).exp()));
            let metric = elastic_metric.pushed_by(&gradient.inverse());
            let metric = match self.surface {
                HenckySurface::VonMises => isochoric(&metric),
                HenckySurface::Rankine => metric,
            };
            state.inverse_plastic_metric =
                SymmetricTensor::select(returned.yields, &metric, &old.inverse_plastic_metric);
            state.equivalent_plastic_strain = strain_old + returned.plastic_increment;
            dissipation = stress_power(&old.stress, &state.stress, &in_space(returned.flow)).max(R::splat(0.0));
        }
        MaterialUpdate {
            state,
            internal_energy: stress_power(&old.stress, &state.stress, &motion.strain_increment),
            plastic_dissipation: dissipation,
        }
    }

    #[inline(always)]
    fn equivalent_plastic_strain<R: Real>(&self, state: &MetricState<R>) -> R {
        state.equivalent_plastic_strain
    }

    #[inline(always)]
    fn cauchy_stress<R: Real>(&self, state: &MetricState<R>, _: Rotation<R>) -> SymmetricTensor<R> {
        state.stress
    }

    fn plastic_metric(&self, state: &MetricState<f64>, _: &SymmetricTensor<f64>) -> SymmetricTensor<f64> {
        state.plastic_metric()
    }

    /// Φ = H/(3μ + H) for von Mises, H/(λ + 2μ/j + H) for Rankine with the j largest principal values on the cut.
    fn hardening_index(&self, state: &MetricState<f64>) -> Option<f64> {
        let strain = state.equivalent_plastic_strain;
        Some(match self.surface {
            HenckySurface::VonMises => radial_hardening_index(&self.elasticity, &self.hardening, strain),
            HenckySurface::Rankine => {
                let values = state.stress.eigensystem().values;
                let on_cut = values.iter().filter(|value| **value >= values[0] - EQUAL * values[0].abs()).count();
                let slope = self.hardening.flow_stress(strain).slope;
                slope / (self.cut_modulus(on_cut) + slope)
            }
        })
    }
}
