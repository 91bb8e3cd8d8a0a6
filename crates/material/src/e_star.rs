//! The E* theory in box-rate form: Eulerian finite plasticity with the elastic strain E* measured from the unique
//! intermediate configuration (de Vera 2016, chapters 5-7).
//!
//! Rotated Cauchy stress T̃ = RᵀTR, T□ = R (dT̃/dt) Rᵀ (dV 2.51). Small elastic strain, any plastic strain:
//!
//! - elasticity   T̃ = 2μ dev E* + k tr(E*) I (dV 7.36, 7.37), in rate form dT̃/dt = 2μ dev(D̃ − D̄_p) + k tr(D̃) I
//! - yield        √(3/2) ‖dev T̃ − α̃‖ ≤ σ_y(ε̄ᵖ) (dV 7.76, 7.78)
//! - flow         D̄_p = γ̇ n, n = (dev T̃ − α̃)/‖dev T̃ − α̃‖, ε̄̇ᵖ = √⅔ γ̇, so tr D̄_p = 0
//! - hardening    σ_y as the [`Hardening`] law gives it, and the motion of α̃ that the [`KinematicRule`] gives
//!
//! Update at the mid-step configuration, exactly objective: elastic predictor, radial return. Second order in the step for
//! elastic response and for flow in one direction, first order where the direction of flow turns (backward Euler).
//!
//! Dissipation is the plastic work less what the back stress stores, (T̃ − α̃) : D̄_p and what its recovery dissipates.
//! Heating is by the dissipation per undeformed volume, J times it with J = exp(tr T̃/3k).
//!
//! Parameters: elasticity, isotropic and kinematic hardening. History: T̃, ε̄ᵖ, α̃ where the surface moves, and what the
//! hardening law remembers.

use crate::elastic::{predicted_stress, stress_power};
use crate::factors::{elastic_metric, plastic_metric_under};
use crate::point_state;
use crate::return_mapping::{RadialReturn, radial_hardening_index};
use crate::{
    FlowStart, FlowStress, Hardening, IsotropicElasticity, Material, MaterialUpdate, PointState, RotatedMotion,
    YieldCriterion,
};
use estar_tensor::{Mask, Real, Rotation, SymmetricTensor, Tensor};

/// The E* theory in box-rate form; `K` is `()` or [`KinematicHardening`](crate::KinematicHardening).
#[derive(Clone, Debug, PartialEq)]
pub struct EStar<K, H> {
    elasticity: IsotropicElasticity,
    hardening: H,
    kinematic: K,
}

/// History of [`EStar`].
#[derive(Clone, Copy, Debug)]
pub struct EStarState<R, BackStress, Memory> {
    /// Rotated Cauchy stress T̃ = RᵀTR, Pa.
    pub rotated_stress: SymmetricTensor<R>,
    /// Equivalent plastic strain ε̄ᵖ.
    pub equivalent_plastic_strain: R,
    /// Rotated back stress α̃, where the surface moves.
    pub back_stress: BackStress,
    /// What the hardening law remembers.
    pub memory: Memory,
}

point_state!(EStarState<BackStress, Memory> {
    rotated_stress: symmetric,
    equivalent_plastic_strain: number,
    back_stress: inner,
    memory: inner,
});

/// Whether and how the centre of the yield surface moves. `()` is a surface that rests and costs no history;
/// [`KinematicHardening`](crate::KinematicHardening) moves it.
pub trait KinematicRule: Clone + Send + Sync + 'static {
    /// What a history keeps of the centre.
    type BackStress<R: Real>: PointState<R>;

    /// α̃ of what is kept, Pa.
    fn back_stress<R: Real>(kept: &Self::BackStress<R>) -> SymmetricTensor<R>;

    /// What is kept of α̃ (Pa).
    fn kept<R: Real>(back_stress: SymmetricTensor<R>) -> Self::BackStress<R>;

    /// √(3/2) n : dα̃/dε̄ᵖ, Pa, where the flow has the direction of `relative` = dev T̃ − α̃.
    fn back_stress_slope(&self, back_stress: &SymmetricTensor<f64>, relative: &SymmetricTensor<f64>) -> f64;

    /// The return of an inadmissible trial stress to the yield surface.
    fn return_mapping<R: Real, H: Hardening>(&self, trial: &Trial<R>, law: &RadialReturn<'_, H, R>) -> Return<R>;
}

/// A trial state outside the yield surface, in the lanes that yield.
#[derive(Clone, Copy, Debug)]
pub struct Trial<R: Real> {
    /// Lanes outside the surface.
    pub yields: R::Mask,
    /// dev T̃_trial, Pa.
    pub deviator: SymmetricTensor<R>,
    /// √(3/2) ‖dev T̃_trial − α̃_n‖, Pa.
    pub equivalent_stress: R,
    /// 1 over this.
    pub per_equivalent_stress: R,
    /// σ_y before the step.
    pub flow_stress_old: FlowStress<R>,
    /// α̃_n, Pa.
    pub back_stress: SymmetricTensor<R>,
}

/// What the return mapping gives; lanes that do not yield carry the values of rest.
#[derive(Clone, Copy, Debug)]
pub struct Return<R> {
    /// 2μ Δγ n, what the trial stress loses, Pa.
    pub stress_correction: SymmetricTensor<R>,
    /// Δε̄ᵖ = √⅔ Δγ.
    pub plastic_increment: R,
    /// α̃_{n+1}, Pa.
    pub back_stress: SymmetricTensor<R>,
    /// What the recovery of the back stress dissipates in the step, J/m³; none of a rule without recovery.
    pub recovered_energy: Option<R>,
}

impl KinematicRule for () {
    type BackStress<R: Real> = ();

    #[inline(always)]
    fn back_stress<R: Real>((): &()) -> SymmetricTensor<R> {
        SymmetricTensor::zero()
    }

    #[inline(always)]
    fn kept<R: Real>(_: SymmetricTensor<R>) {}

    fn back_stress_slope(&self, _: &SymmetricTensor<f64>, _: &SymmetricTensor<f64>) -> f64 {
        0.0
    }

    /// Radial return with p = Δε̄ᵖ: √(3/2) ‖dev T̃_trial‖ − 3μ p = σ_y(ε̄ᵖ_n + p), n = dev T̃_trial/‖dev T̃_trial‖.
    #[inline(always)]
    fn return_mapping<R: Real, H: Hardening>(&self, trial: &Trial<R>, law: &RadialReturn<'_, H, R>) -> Return<R> {
        let three_mu = 3.0 * law.elasticity.shear_modulus();
        let p = law.plastic_increment(trial.yields, trial.equivalent_stress, trial.flow_stress_old);

        // 2μ Δγ n = 3μ p dev T̃_trial / (√(3/2) ‖dev T̃_trial‖)
        let factor = R::select(trial.yields, p * three_mu * trial.per_equivalent_stress, R::splat(0.0));
        Return {
            stress_correction: trial.deviator * factor,
            plastic_increment: p,
            back_stress: trial.back_stress,
            recovered_energy: None,
        }
    }
}

impl<K: KinematicRule, H: Hardening> EStar<K, H> {
    /// The material with these parameters.
    pub fn new(elasticity: IsotropicElasticity, hardening: H, kinematic: K) -> Self {
        Self { elasticity, hardening, kinematic }
    }
}

impl<K: KinematicRule, H: Hardening> Material for EStar<K, H> {
    type State<R: Real> = EStarState<R, K::BackStress<R>, H::Memory<R>>;

    type Motion<R: Real> = RotatedMotion<R>;

    fn elasticity(&self) -> &IsotropicElasticity {
        &self.elasticity
    }

    fn initial_state<R: Real>(&self) -> Self::State<R> {
        EStarState {
            rotated_stress: SymmetricTensor::zero(),
            equivalent_plastic_strain: R::splat(0.0),
            back_stress: K::kept(SymmetricTensor::zero()),
            memory: self.hardening.initial_memory(),
        }
    }

    #[inline(always)]
    fn update<R: Real>(
        &self,
        old: &Self::State<R>,
        motion: &RotatedMotion<R>,
        time_step: f64,
    ) -> MaterialUpdate<R, Self::State<R>> {
        let EStarState { rotated_stress: stress_old, equivalent_plastic_strain: strain_old, memory, .. } = *old;
        let back_stress_old = K::back_stress(&old.back_stress);

        // (i) elastic predictor: T̃_trial = T̃_n + Δt (2μ dev D̃ + k tr(D̃) I), its deviator and its mean
        let strain_increment = &motion.strain_increment;
        let (shear_modulus, bulk_modulus) = (self.elasticity.shear_modulus(), self.elasticity.bulk_modulus());
        let (mean_old, dilatation) = (stress_old.trace() * (1.0 / 3.0), strain_increment.trace());
        let spherical = dilatation.mul_add(R::splat(-2.0 / 3.0 * shear_modulus), -mean_old);
        let deviator = strain_increment.mul_add(R::splat(2.0 * shear_modulus), &stress_old).plus_spherical(spherical);
        let mean = dilatation.mul_add(R::splat(bulk_modulus), mean_old);

        // (ii) admissibility: √(3/2) ‖dev T̃_trial − α̃_n‖ ≤ σ_y of t_n
        let equivalent_squared = von_mises_squared(&(deviator - back_stress_old));
        let start = FlowStart::new(strain_old, memory, time_step);
        let law = RadialReturn { elasticity: &self.elasticity, hardening: &self.hardening, start };
        let flow_stress_old = law.flow_stress_old();
        let yields = equivalent_squared.gt(flow_stress_old.stress * flow_stress_old.stress);

        // (iii) return mapping
        let at_rest = Return {
            stress_correction: SymmetricTensor::zero(),
            plastic_increment: R::splat(0.0),
            back_stress: back_stress_old,
            recovered_energy: None,
        };
        let returned = if yields.any() {
            let equivalent_stress = equivalent_squared.sqrt();
            let trial = Trial {
                yields,
                deviator,
                equivalent_stress,
                // the root and the reciprocal side by side
                per_equivalent_stress: equivalent_stress * equivalent_squared.recip(),
                flow_stress_old,
                back_stress: back_stress_old,
            };
            self.kinematic.return_mapping(&trial, &law)
        } else {
            at_rest
        };
        let stress_new = (deviator - returned.stress_correction).plus_spherical(mean);
        let driving_stress_old = stress_old - back_stress_old;
        let driving_stress_new = stress_new - returned.back_stress;
        // Δε_p = Δγ n = (2μ Δγ n)/2μ
        let dissipation = stress_power(&driving_stress_old, &driving_stress_new, &returned.stress_correction)
            * (0.5 / self.elasticity.shear_modulus());
        let dissipation =
            if let Some(recovered) = returned.recovered_energy { dissipation + recovered } else { dissipation };
        let dissipation = dissipation.max(R::splat(0.0));
        // small elastic strain: beyond this the stress has no meaning either
        let one = R::splat(1.0);
        let jacobian = (mean * bulk_modulus.recip()).min(one).max(-one).exp();

        MaterialUpdate {
            state: EStarState {
                rotated_stress: stress_new,
                equivalent_plastic_strain: strain_old + returned.plastic_increment,
                back_stress: K::kept(returned.back_stress),
                memory: self.hardening.heated(memory, dissipation * jacobian),
            },
            internal_energy: stress_power(&stress_old, &stress_new, strain_increment),
            plastic_dissipation: dissipation,
        }
    }

    #[inline(always)]
    fn equivalent_plastic_strain<R: Real>(&self, state: &Self::State<R>) -> R {
        state.equivalent_plastic_strain
    }

    /// T = R T̃ Rᵀ.
    #[inline(always)]
    fn cauchy_stress<R: Real>(&self, state: &Self::State<R>, rotation: Rotation<R>) -> SymmetricTensor<R> {
        state.rotated_stress.pushed_by(&rotation.to_tensor())
    }

    /// I until something has flowed; then what the elastic stretch leaves of C. The elastic strain of the rate form is
    /// logarithmic, so that this has det C_p = 1 under any change of volume.
    fn plastic_metric(&self, state: &Self::State<f64>, metric: &SymmetricTensor<f64>) -> SymmetricTensor<f64> {
        if state.equivalent_plastic_strain > 0.0 {
            plastic_metric_under(&elastic_metric(&self.elasticity, &state.rotated_stress), metric)
        } else {
            SymmetricTensor::spherical(1.0)
        }
    }

    /// Φ = H/(3μ + H), H the slope of the flow stress and of the back stress in the direction of flow.
    fn hardening_index(&self, state: &Self::State<f64>, _: &Tensor<f64>) -> Option<f64> {
        let back_stress = K::back_stress(&state.back_stress);
        let relative = state.rotated_stress.deviator() - back_stress;
        let flow_stress = von_mises(&relative);
        let slope = self.hardening.slope_of_flow(state.equivalent_plastic_strain, &state.memory, flow_stress)
            + self.kinematic.back_stress_slope(&back_stress, &relative);
        Some(radial_hardening_index(&self.elasticity, slope))
    }

    /// √(3/2) ‖dev T̃ − α̃‖.
    fn yield_criterion(&self, state: &Self::State<f64>, motion: &RotatedMotion<f64>) -> Option<YieldCriterion> {
        let trial = predicted_stress(&self.elasticity, &state.rotated_stress, &motion.strain_increment);
        let relative = trial.deviator() - K::back_stress(&state.back_stress);
        let strain = state.equivalent_plastic_strain;
        YieldCriterion::under(&self.hardening, strain, &state.memory, von_mises(&relative))
    }

    #[inline(always)]
    fn temperature<R: Real>(&self, state: &Self::State<R>) -> Option<R> {
        self.hardening.temperature(&state.memory)
    }

    fn heat_share(&self) -> Option<f64> {
        self.hardening.heat_share()
    }
}

/// √(3/2) ‖A‖ of a deviator.
#[inline(always)]
pub(crate) fn von_mises<R: Real>(deviator: &SymmetricTensor<R>) -> R {
    von_mises_squared(deviator).sqrt()
}

/// (3/2) ‖A‖² of a deviator.
#[inline(always)]
pub(crate) fn von_mises_squared<R: Real>(deviator: &SymmetricTensor<R>) -> R {
    deviator.norm_squared() * 1.5
}
