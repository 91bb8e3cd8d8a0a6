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
use estar_material::{IsotropicElasticity, Material, Motion, PointGradients, PointState, StepKinematics};
use estar_tensor::{Real, Rotation, Vector3, prefetch};

/// Nodes of an element.
pub const NODES: usize = 4;

/// The element: nothing is to be chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tet4;

/// A vector at each node.
pub type NodeVectors<R> = [Vector3<R>; NODES];

/// History of an element.
#[derive(Clone, Copy, Debug)]
pub struct Tet4History<State, R> {
    /// History of the material.
    pub states: [State; 1],
    /// Rotation R_n; none where the theory needs none.
    pub rotations: [Rotation<R>; 1],
    /// Stable time step at t_n, s.
    pub stable_time_step: R,
    /// Pressure of bulk viscosity at t_n, Pa.
    pub viscous_pressure: R,
    /// What is shared in the step.
    pub neighbourhood: Neighbourhood<R>,
}

impl<R: Real> Neighbourhood<R> {
    /// Of elements that have not moved.
    fn at_rest() -> Self {
        Self { jacobian: R::splat(1.0), increment: R::splat(0.0), mean_stress: R::splat(0.0) }
    }
}

impl<R: Real, S: PointState<R>> ElementHistory<R, S> for Tet4History<S, R> {
    fn states(&self) -> &[S] {
        &self.states
    }

    fn rotations(&self) -> &[Rotation<R>] {
        &self.rotations
    }

    fn stable_time_step(&self) -> R {
        self.stable_time_step
    }

    fn neighbourhood(&self) -> Option<&Neighbourhood<R>> {
        Some(&self.neighbourhood)
    }

    fn neighbourhood_mut(&mut self) -> Option<&mut Neighbourhood<R>> {
        Some(&mut self.neighbourhood)
    }

    fn for_each(&self, mut visit: impl FnMut(R)) {
        self.states[0].for_each(&mut visit);
        self.rotations[0].0.into_iter().for_each(&mut visit);
        visit(self.stable_time_step);
        visit(self.viscous_pressure);
        // no step needs them, but who looks at the state
        visit(self.neighbourhood.jacobian);
        visit(self.neighbourhood.mean_stress);
    }

    fn from_numbers(mut next: impl FnMut() -> R) -> Self {
        Self {
            states: [S::from_numbers(&mut next)],
            rotations: [Rotation(estar_tensor::array(|_| next()))],
            stable_time_step: next(),
            viscous_pressure: next(),
            neighbourhood: Neighbourhood { jacobian: next(), mean_stress: next(), ..Neighbourhood::at_rest() },
        }
    }

    fn select(mask: R::Mask, chosen: &Self, otherwise: &Self) -> Self {
        let number = |chosen: R, otherwise: R| R::select(mask, chosen, otherwise);
        let (shared, other) = (&chosen.neighbourhood, &otherwise.neighbourhood);
        Self {
            states: [S::select(mask, &chosen.states[0], &otherwise.states[0])],
            rotations: [Rotation(estar_tensor::array(|i| {
                number(chosen.rotations[0].0[i], otherwise.rotations[0].0[i])
            }))],
            stable_time_step: number(chosen.stable_time_step, otherwise.stable_time_step),
            viscous_pressure: number(chosen.viscous_pressure, otherwise.viscous_pressure),
            neighbourhood: Neighbourhood {
                jacobian: number(shared.jacobian, other.jacobian),
                increment: number(shared.increment, other.increment),
                mean_stress: number(shared.mean_stress, other.mean_stress),
            },
        }
    }
}

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
    type History<R: Real, S: PointState<R>> = Tet4History<S, R>;

    fn initial_history<R: Real, M: Material>(material: &M, stable_time_step: f64) -> Tet4History<M::State<R>, R> {
        Tet4History {
            states: [material.initial_state()],
            rotations: [Rotation::identity()],
            stable_time_step: R::splat(stable_time_step),
            viscous_pressure: R::splat(0.0),
            neighbourhood: Neighbourhood::at_rest(),
        }
    }

    fn lumped_mass(reference: &NodeVectors<f64>, density: f64) -> [f64; NODES] {
        [0.25 * density * volume(reference); NODES]
    }

    fn smallest_jacobian(position: &NodeVectors<f64>) -> f64 {
        tet_parent::gradient(position).determinant()
    }

    #[inline(always)]
    fn advance<R: Real, M: Material>(
        self,
        material: &M,
        history: &mut Tet4History<M::State<R>, R>,
        upcoming: Option<&Tet4History<M::State<R>, R>>,
        motion: &ElementMotion<R, NODES>,
        step: &ElementStep,
    ) -> ElementUpdate<R, NODES> {
        if let Some(upcoming) = upcoming {
            prefetch(upcoming);
        }
        let elasticity = material.elasticity();
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
        let rotation_old = history.rotations[0];
        let rotation = if M::Motion::<R>::NEEDS_ROTATION {
            Rotation::nearest(&scaled_gradient, rotation_old)
        } else {
            rotation_old
        };
        history.rotations[0] = rotation;
        let shared = history.neighbourhood;
        let trace = increment.trace();
        let scale = (shared.jacobian / jacobian).cbrt();
        let motion_of_point = M::Motion::new(&StepKinematics {
            incremental_displacement_gradient: increment.plus_spherical((shared.increment - trace) * (1.0 / 3.0)),
            deformation_gradient: scaled_gradient * (per_reference_volume * scale),
            rotation_old,
            rotation_new: rotation,
        });
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
        let update = material.update(&history.states[0], &motion_of_point, step.time_step);
        history.states[0] = update.state;
        let stress = material.cauchy_stress(&update.state, rotation);
        let mean_stress = stress.trace() * (1.0 / 3.0);
        history.neighbourhood.mean_stress = mean_stress;

        // (iii) forces of the deviator and of bulk viscosity, f_a = V dev T ∇N_a
        let volume = R::splat(tet_parent::VOLUME);
        let flux = stress.plus_spherical(-viscous_pressure - mean_stress).to_tensor().dot(&(cofactor * volume));
        let bounds =
            ElasticBounds { shear_modulus: elasticity.shear_modulus(), bulk_modulus: elasticity.bulk_modulus() };
        let metric = Metrics::none().with(&position, &cofactor, parent_jacobian).greatest();
        let undamped = bounds.stable_time_step_tet4(&metric, motion.corner_mass);
        let undamped = match material.stiffening(&update.state, &motion_of_point) {
            Some(ratio) => undamped / ratio.sqrt(),
            None => undamped,
        };
        history.stable_time_step = undamped;
        let mean_pressure = (history.viscous_pressure + viscous_pressure) * 0.5;
        let viscous_energy = -(mean_pressure * trace * volume_half * volume);
        history.viscous_pressure = viscous_pressure;
        ElementUpdate {
            internal_force: tet_parent::slopes(&flux),
            internal_energy: update.internal_energy * volume_half * volume,
            plastic_dissipation: update.plastic_dissipation * volume_half * volume,
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
