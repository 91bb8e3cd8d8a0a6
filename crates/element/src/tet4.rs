//! The four-node tet, `tet4`: one point, and volume change and pressure that are averaged over the nodes, so that it does not
//! lock (after Bonet & Burton 1998).
//!
//! A node has the volume change of all tets that meet there, J_a = Σ_e v_e / Σ_e V_e and θ_a = Σ_e v_e θ_e / Σ_e v_e, and a tet
//! the mean of its nodes, ln J̄ = ¼ Σ_a ln J_a and θ̄ = ¼ Σ_a θ_a; F̄ = (J̄/J)^⅓ F. The mean stress takes the same way: to the
//! nodes by volume, σ_a = Σ_e v_e σ_e / Σ_e v_e, and back, σ̄ = ¼ Σ_a σ_a. That way S is self-adjoint, Σ_e v_e σ_e (S θ)_e =
//! Σ_e v_e (S σ)_e θ_e, so that the forces do the work of the stress: Σ_e v_e (dev T : D + σ̄ tr D) = Σ_e v_e T : D̄.
//!
//! The element computes what is its own; who has the neighbours averages before and after, with [`volumes`] and
//! [`mean_stress_forces`].

use crate::bulk_viscosity::{ViscousState, damped_step_factor};
use crate::element::{Element, ElementHistory, ElementMotion, ElementStep, ElementUpdate, Neighbourhood, Tangent};
use crate::stable_time_step::{ElasticBounds, Metrics};
use crate::tet_parent::{self, SIGNS};
use estar_material::points::PackPoints;
use estar_material::{IsotropicElasticity, PointGradients};
use estar_tensor::{Real, Vector3};

/// Nodes of an element.
pub const NODES: usize = 4;

/// The element: nothing is to be chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tet4;

/// A vector at each node.
pub type NodeVectors<R> = [Vector3<R>; NODES];

/// Volumes of an element, m³.
#[derive(Clone, Copy, Debug)]
pub struct Volumes<R> {
    /// V, at the start.
    pub reference: R,
    /// v at t_{n+1}.
    pub now: R,
    /// v at mid-step.
    pub half: R,
    /// Its change in the step, v θ Δt at mid-step.
    pub change: R,
}

/// The volumes of an element in a step of length `time_step` (s).
#[inline(always)]
pub fn volumes<R: Real>(motion: &ElementMotion<R, NODES>, time_step: f64) -> Volumes<R> {
    let position = tet_parent::gradient(&motion.position);
    let gradients = PointGradients {
        reference: tet_parent::gradient(&motion.reference),
        position,
        velocity: tet_parent::gradient(&motion.velocity),
    };
    let (increment, half) = gradients.incremental_displacement_gradient(time_step);
    let half = half * tet_parent::VOLUME;
    Volumes {
        reference: gradients.reference.determinant() * tet_parent::VOLUME,
        now: position.determinant() * tet_parent::VOLUME,
        half,
        change: half * increment.trace(),
    }
}

/// Volume of an element, m³.
#[inline(always)]
pub fn volume<R: Real>(position: &NodeVectors<R>) -> R {
    tet_parent::gradient(position).determinant() * tet_parent::VOLUME
}

/// Internal force on each node of the mean stress σ̄, V σ̄ ∇N_a = V/j σ̄ cof(∂x/∂r) ∂λ_a/∂r.
#[inline(always)]
pub fn mean_stress_forces<R: Real>(position: &NodeVectors<R>, mean_stress: R) -> NodeVectors<R> {
    tet_parent::slopes(&(tet_parent::gradient(position).cofactor() * (mean_stress * tet_parent::VOLUME)))
}

impl Element<NODES> for Tet4 {
    const POINTS: usize = 1;
    const SHARES_VOLUME: bool = true;
    const PARENT: [[f64; 3]; NODES] = SIGNS;
    type Own<R: Real> = Neighbourhood<R>;

    fn lumped_mass(reference: &NodeVectors<f64>, density: f64) -> [f64; NODES] {
        [0.25 * density * volume(reference); NODES]
    }

    fn smallest_jacobian(position: &NodeVectors<f64>) -> f64 {
        tet_parent::gradient(position).determinant()
    }

    #[inline(always)]
    fn advance<R: Real>(
        self,
        elasticity: &IsotropicElasticity,
        mut points: PackPoints<'_, R>,
        history: &mut ElementHistory<R, Neighbourhood<R>>,
        motion: &ElementMotion<R, NODES>,
        step: &ElementStep,
    ) -> ElementUpdate<R, NODES> {
        let zero = R::splat(0.0);
        let position = tet_parent::gradient(&motion.position);
        let gradients = PointGradients {
            reference: tet_parent::gradient(&motion.reference),
            position,
            velocity: tet_parent::gradient(&motion.velocity),
        };

        // (i) the motion, with the volume change of the neighbourhood: L̄ = L + ⅓ (θ̄ − tr L) I, F̄ = (J̄/J)^⅓ F
        let (increment, volume_half) = gradients.incremental_displacement_gradient(step.time_step);
        let (scaled_gradient, per_reference_volume) = gradients.scaled_deformation_gradient();
        let cofactor = position.cofactor();
        let parent_jacobian = position.columns[0].dot(cofactor.columns[0]);
        let jacobian = parent_jacobian * per_reference_volume;
        let shared = history.own;
        let trace = increment.trace();
        let needs = points.points.needs();
        let exchange = &mut *points.exchange;
        exchange.tells_flow = false;
        let told = &mut exchange.motions[0];
        told.incremental_displacement_gradient = increment.plus_spherical((shared.increment - trace) * (1.0 / 3.0));
        told.volume_half = volume_half;
        if needs.rotation {
            told.scaled_gradient = scaled_gradient;
        }
        if needs.deformation_gradient {
            let scale = (shared.jacobian / jacobian).cbrt();
            told.deformation_gradient = scaled_gradient * (per_reference_volume * scale);
        }
        let viscous = step.bulk_viscosity.map(|viscosity| {
            let density = R::splat(elasticity.density()) / jacobian;
            let wave_speed = (R::splat(elasticity.p_wave_modulus()) / density).sqrt();
            let length = wave_speed * history.stable_time_step;
            // at the start no step has been made, and nothing moves
            let volumetric_rate = if step.time_step > 0.0 { trace * (1.0 / step.time_step) } else { zero };
            viscosity.response(&ViscousState { volumetric_rate, density, wave_speed, length })
        });
        let viscous_pressure = viscous.map_or(zero, |response| response.pressure);

        // (ii) history and stress
        let update = points.update(step.time_step);
        let stress = points.exchange.stresses[0];
        let mean_stress = stress.trace() * (1.0 / 3.0);
        history.own.mean_stress = mean_stress;

        // (iii) forces of the deviator and of bulk viscosity, f_a = V dev T ∇N_a
        let volume = R::splat(tet_parent::VOLUME);
        let flux = stress.plus_spherical(-viscous_pressure - mean_stress).to_tensor().dot(&(cofactor * volume));
        let bounds =
            ElasticBounds { shear_modulus: elasticity.shear_modulus(), bulk_modulus: elasticity.bulk_modulus() };
        let metric = Metrics::none().with(&position, &cofactor, parent_jacobian).greatest();
        let undamped = bounds.stable_time_step_tet4(&metric, motion.corner_mass);
        let undamped = match update.stiffening {
            Some(ratio) => undamped / ratio.sqrt(),
            None => undamped,
        };
        history.stable_time_step = undamped;
        let mean_pressure = (history.viscous_pressure + viscous_pressure) * 0.5;
        let viscous_energy = -(mean_pressure * trace * volume_half * volume);
        history.viscous_pressure = viscous_pressure;
        ElementUpdate {
            internal_force: tet_parent::slopes(&flux),
            internal_energy: update.internal_energy * volume,
            plastic_dissipation: update.plastic_dissipation * volume,
            viscous_energy,
            hourglass_energy: zero,
            min_jacobian: jacobian,
            stable_time_step: viscous
                .map_or(undamped, |response| undamped * damped_step_factor(response.damping_ratio)),
        }
    }

    fn tangent<R: Real>(
        self,
        _: &IsotropicElasticity,
        _: R,
        _: &ElementMotion<R, NODES>,
        _: &ElementStep,
    ) -> Tangent<R> {
        Tangent { stiffening: R::splat(1.0), ..Tangent::none() }
    }

    /// Of the tet alone, whose volume change is its own: f_a = V (2μ dev D + k tr D I) ∇N_a.
    #[inline(always)]
    fn linear_forces<R: Real>(
        self,
        elasticity: &IsotropicElasticity,
        _: &Tangent<R>,
        position: &NodeVectors<R>,
        displacement: &NodeVectors<R>,
    ) -> NodeVectors<R> {
        let gradient = tet_parent::gradient(position);
        let cofactor = gradient.cofactor();
        let per_jacobian = gradient.columns[0].dot(cofactor.columns[0]).recip();
        // j ∇u = (∂u/∂r) cof(∂x/∂r)ᵀ
        let strain = tet_parent::gradient(displacement).dot(&cofactor.transpose()).symmetric_part() * per_jacobian;
        let (shear, bulk) = (elasticity.shear_modulus(), elasticity.bulk_modulus());
        let pressure = strain.trace() * (bulk - 2.0 / 3.0 * shear);
        let stress = (strain * R::splat(2.0 * shear)).plus_spherical(pressure);
        tet_parent::slopes(&stress.to_tensor().dot(&(cofactor * R::splat(tet_parent::VOLUME))))
    }
}
