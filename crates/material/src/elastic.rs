//! Isotropic elasticity in rate form with the box rate.
//!
//! T□ = 2μ dev D + k tr(D) I, that is dT̃/dt = 2μ dev D̃ + k tr(D̃) I for the rotated stress T̃ = RᵀTR and
//! D̃ = RᵀDR (de Vera 2016, section 6.5; Green & McInnis 1967; Green & Naghdi 1965).
//!
//! Parameters: density and two elastic constants. History: T̃.

use crate::point_state;
use crate::{IsotropicElasticity, Material, MaterialUpdate, RotatedMotion};
use estar_tensor::{Real, Rotation, SymmetricTensor, Tensor};

/// Isotropic elasticity in rate form.
#[derive(Clone, Debug, PartialEq)]
pub struct Elastic {
    elasticity: IsotropicElasticity,
}

/// History of [`Elastic`].
#[derive(Clone, Copy, Debug)]
pub struct ElasticState<R> {
    /// Rotated Cauchy stress T̃ = RᵀTR, Pa.
    pub rotated_stress: SymmetricTensor<R>,
}

point_state!(ElasticState { rotated_stress: symmetric });

impl Elastic {
    /// The material with these constants.
    pub fn new(elasticity: IsotropicElasticity) -> Self {
        Self { elasticity }
    }
}

impl Material for Elastic {
    type State<R: Real> = ElasticState<R>;

    type Motion<R: Real> = RotatedMotion<R>;

    fn elasticity(&self) -> &IsotropicElasticity {
        &self.elasticity
    }

    fn initial_state<R: Real>(&self) -> ElasticState<R> {
        ElasticState { rotated_stress: SymmetricTensor::zero() }
    }

    #[inline(always)]
    fn update<R: Real>(
        &self,
        old: &ElasticState<R>,
        motion: &RotatedMotion<R>,
        _: f64,
    ) -> MaterialUpdate<R, ElasticState<R>> {
        let rotated_stress = predicted_stress(&self.elasticity, &old.rotated_stress, &motion.strain_increment);
        MaterialUpdate {
            state: ElasticState { rotated_stress },
            internal_energy: stress_power(&old.rotated_stress, &rotated_stress, &motion.strain_increment),
            plastic_dissipation: R::splat(0.0),
        }
    }

    #[inline(always)]
    fn equivalent_plastic_strain<R: Real>(&self, _state: &ElasticState<R>) -> R {
        R::splat(0.0)
    }

    /// T = R T̃ Rᵀ.
    #[inline(always)]
    fn cauchy_stress<R: Real>(&self, state: &ElasticState<R>, rotation: Rotation<R>) -> SymmetricTensor<R> {
        state.rotated_stress.pushed_by(&rotation.to_tensor())
    }

    fn plastic_metric(&self, _: &ElasticState<f64>, _: &SymmetricTensor<f64>) -> SymmetricTensor<f64> {
        SymmetricTensor::spherical(1.0)
    }

    fn hardening_index(&self, _: &ElasticState<f64>, _: &Tensor<f64>) -> Option<f64> {
        None
    }
}

/// T̃_n + 2μ dev(Δt D̃) + k tr(Δt D̃) I = T̃_n + 2μ Δt D̃ + λ tr(Δt D̃) I.
#[inline(always)]
pub(crate) fn predicted_stress<R: Real>(
    elasticity: &IsotropicElasticity,
    stress_old: &SymmetricTensor<R>,
    strain_increment: &SymmetricTensor<R>,
) -> SymmetricTensor<R> {
    let spherical = strain_increment.trace() * elasticity.lame_lambda();
    strain_increment.mul_add(R::splat(2.0 * elasticity.shear_modulus()), stress_old).plus_spherical(spherical)
}

/// ½ (T_n + T_{n+1}) : Δε, the work of a stress on a strain increment, Δt D or its plastic part.
#[inline(always)]
pub(crate) fn stress_power<R: Real>(
    stress_old: &SymmetricTensor<R>,
    stress_new: &SymmetricTensor<R>,
    strain_increment: &SymmetricTensor<R>,
) -> R {
    (*stress_old + *stress_new).double_dot(strain_increment) * 0.5
}
