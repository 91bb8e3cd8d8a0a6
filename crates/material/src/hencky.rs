//! Hencky hyperelasticity with return mapping in principal values ("Supplementary notes on return mapping and theory of
//! plasticity", sections 1 to 3, cited as RM).
//!
//! With b_e = F C_p⁻¹ Fᵀ, ε = ½ ln b_e and the Kirchhoff stress τ = J T:
//!
//! - elasticity   ψ = μ ε : ε + ½ λ (tr ε)², τ = 2μ ε + λ tr(ε) I
//! - yield, flow  those of a [`PrincipalSurface`]: ε_trial − ε_{n+1} = Δε_p, which keeps the principal directions (RM 1)
//!
//! Plastic dissipation −½ τ : (L_v b_e b_e⁻¹) ≥ 0 (RM 27) with L_v b_e = F (dC_p⁻¹/dt) Fᵀ; over a step that is τ : Δε_p.
//!
//! Parameters: elasticity, yield surface. History: C_p⁻¹, ε̄ᵖ, T for the stress power of the next step, and what the hardening
//! law remembers.

use crate::elastic::stress_power;
use crate::metric_state::isochoric;
use crate::principal_surface::{PrincipalSurface, Rankine, VonMises};
use crate::tangent_bound::logarithmic;
use crate::{
    ClosestPoint, FlowStart, Hardening, IsotropicElasticity, IsotropicHardening, Material, MaterialUpdate, MetricState,
    SpatialMotion, YieldCriterion,
};
use estar_tensor::{Mask, Real, Rotation, SymmetricTensor, Tensor, array, inlined};

/// Hencky hyperelasticity that yields on the surface `S`.
#[derive(Clone, Debug, PartialEq)]
pub struct Hencky<S> {
    elasticity: IsotropicElasticity,
    surface: S,
}

impl<H: Hardening> Hencky<VonMises<H>> {
    /// The material that yields by von Mises, √(3/2) ‖dev τ‖ = σ_y.
    pub fn von_mises(elasticity: IsotropicElasticity, hardening: H) -> Self {
        Self { elasticity, surface: VonMises { hardening } }
    }
}

impl Hencky<Rankine> {
    /// The material that yields by Rankine, largest principal value of τ = σ_y.
    pub fn rankine(elasticity: IsotropicElasticity, hardening: IsotropicHardening) -> Self {
        Self { elasticity, surface: Rankine { hardening } }
    }
}

impl Hencky<ClosestPoint> {
    /// The material that yields perfectly, on the surface and with the elasticity of a closest-point return.
    pub fn closest_point(surface: ClosestPoint) -> Self {
        Self { elasticity: *surface.elasticity(), surface }
    }
}

impl<S> Hencky<S> {
    /// The yield surface.
    pub fn surface(&self) -> &S {
        &self.surface
    }
}

/// ε = ½ ln b_e in principal values.
#[inline(always)]
pub(crate) fn hencky_strain<R: Real>(elastic_metric: &[R; 3]) -> [R; 3] {
    array(|i| elastic_metric[i].max(R::splat(f64::MIN_POSITIVE)).ln() * 0.5)
}

impl<S: PrincipalSurface> Material for Hencky<S> {
    type State<R: Real> = MetricState<R, S::Memory<R>>;

    type Motion<R: Real> = SpatialMotion<R>;

    fn elasticity(&self) -> &IsotropicElasticity {
        &self.elasticity
    }

    /// The moduli are those of the Kirchhoff stress.
    #[inline(always)]
    fn stiffening<R: Real>(&self, state: &Self::State<R>, motion: &SpatialMotion<R>) -> Option<R> {
        let jacobian = motion.deformation_gradient.determinant();
        Some(logarithmic(&self.elasticity, &(state.stress * jacobian)).over_rest(&self.elasticity) / jacobian)
    }

    fn initial_state<R: Real>(&self) -> Self::State<R> {
        MetricState::initial(self.surface.initial_memory())
    }

    #[inline(always)]
    fn update<R: Real>(
        &self,
        old: &Self::State<R>,
        motion: &SpatialMotion<R>,
        time_step: f64,
    ) -> MaterialUpdate<R, Self::State<R>> {
        let gradient = &motion.deformation_gradient;

        // (i) elastic predictor: ε_trial = ½ ln(F C_p⁻¹ Fᵀ) with the plastic metric of t_n
        let trial = old.inverse_plastic_metric.pushed_by(gradient).eigensystem();
        let values: [R; 3] = array(|i| trial.values[i].max(R::splat(f64::MIN_POSITIVE)));
        let strain = hencky_strain(&values);

        // (ii) admissibility, (iii) return mapping
        let start = FlowStart::new(old.equivalent_plastic_strain, old.memory, time_step);
        let returned = self.surface.returned(&self.elasticity, strain, &start);
        let trial_stress = self.elasticity.principal_stress(strain);
        let kirchhoff = self.elasticity.principal_stress(array(|i| strain[i] - returned.flow[i]));
        let per_volume = gradient.determinant().recip();
        let in_space = inlined!(|values: [R; 3]| SymmetricTensor::diagonal(values).pushed_by(&trial.vectors));

        let mut state = MetricState { stress: in_space(kirchhoff) * per_volume, ..*old };
        let mut dissipation = R::splat(0.0);
        if returned.yields.any() {
            // b_e = Σ λᵢ² exp(−2 Δε_p,ᵢ) vᵢ⊗vᵢ and C_p⁻¹ = F⁻¹ b_e F⁻ᵀ
            let elastic_metric = in_space(array(|i| values[i] * (returned.flow[i] * -2.0).exp()));
            let metric = elastic_metric.pushed_by(&gradient.inverse());
            let metric = if self.surface.keeps_volume() { isochoric(&metric) } else { metric };
            state.inverse_plastic_metric =
                SymmetricTensor::select(returned.yields, &metric, &old.inverse_plastic_metric);
            state.equivalent_plastic_strain = old.equivalent_plastic_strain + returned.plastic_increment;
            // the ledger's share of the stress power by the same rule as the whole of it
            dissipation = stress_power(&old.stress, &state.stress, &in_space(returned.flow)).max(R::splat(0.0));
            // a temperature must not depend on how the step turns: ½ (τ_n + τ_{n+1}) : Δε_p with τ_n = τ_trial − 2μ Δt D but
            // for its mean, on which flow that keeps the volume, as of every law with a temperature, does no work
            let strained = motion.strain_increment.pulled_by(&trial.vectors).0;
            let two_mu = 2.0 * self.elasticity.shear_modulus();
            let [a, b, c] = array(|i| {
                let twice_mean = trial_stress[i] + kirchhoff[i] - strained[i] * two_mu;
                R::select(returned.yields, twice_mean * returned.flow[i] * 0.5, R::splat(0.0))
            });
            state.memory = self.surface.heated(old.memory, (a + b + c).max(R::splat(0.0)));
        }
        MaterialUpdate {
            state,
            internal_energy: stress_power(&old.stress, &state.stress, &motion.strain_increment),
            plastic_dissipation: dissipation,
        }
    }

    #[inline(always)]
    fn equivalent_plastic_strain<R: Real>(&self, state: &Self::State<R>) -> R {
        state.equivalent_plastic_strain
    }

    #[inline(always)]
    fn cauchy_stress<R: Real>(&self, state: &Self::State<R>, _: Rotation<R>) -> SymmetricTensor<R> {
        state.stress
    }

    fn plastic_metric(&self, state: &Self::State<f64>, _: &SymmetricTensor<f64>) -> SymmetricTensor<f64> {
        state.plastic_metric()
    }

    fn hardening_index(&self, state: &Self::State<f64>, gradient: &Tensor<f64>) -> Option<f64> {
        let principal_stress = (state.stress * gradient.determinant()).eigensystem().values;
        let strain = state.equivalent_plastic_strain;
        Some(self.surface.hardening_index(&self.elasticity, principal_stress, strain, &state.memory))
    }

    fn yield_criterion(&self, state: &Self::State<f64>, motion: &SpatialMotion<f64>) -> Option<YieldCriterion> {
        let trial = state.inverse_plastic_metric.pushed_by(&motion.deformation_gradient).eigensystem();
        let stress = self.elasticity.principal_stress(hencky_strain(&trial.values));
        self.surface.yield_criterion(stress, state.equivalent_plastic_strain, &state.memory)
    }

    #[inline(always)]
    fn temperature<R: Real>(&self, state: &Self::State<R>) -> Option<R> {
        self.surface.temperature(&state.memory)
    }

    fn keeps_volume(&self) -> bool {
        self.surface.keeps_volume()
    }

    fn heat_share(&self) -> Option<f64> {
        self.surface.heat_share()
    }
}
