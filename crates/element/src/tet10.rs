//! The ten-node tet with four points, `tet10`: quadratic in position and motion, edges straight or curved, with the mean
//! dilatation of the element at every point and the mean pressure in the forces (as `hex8-b-bar`, see [`hex8`](crate::hex8)),
//! so that plastic flow, which keeps the volume, does not lock.
//!
//! ```text
//!            3
//!           /|\           corners 0 to 3, then the middles of the edges
//!          7 9 8          4: 01   5: 12   6: 20   7: 03   8: 13   9: 23
//!         /  |  \
//!        0-6-|---2
//!         \  |  /
//!          4 | 5
//!           \|/
//!            1
//! ```
//!
//! With volume coordinates λ_i, N_i = λ_i (2 λ_i − 1) and N_ij = 4 λ_i λ_j. The point nearest corner p has λ_p = ¼ (1 + 3/√5)
//! and ¼ (1 − 1/√5) for the others, and there ∂x/∂λ_i = s_i + (4/√5) x_ip with s_i = (1 − 1/√5) Σ_j x_ij − (1/√5) x_i, where
//! x_ii is x_i: a sum for each corner, and one more node for each point. The force is the transpose of the same.
//!
//! The lumped mass has the shares of the diagonal of the consistent one of a tet with straight edges, 1/36 for a corner and
//! 4/27 for a middle: positive, where row sums give corners −1/20 (Hinton, Rock & Zienkiewicz 1976).
//!
//! A single tet has three motions without stress, u = 2 (a·x) x − (x·x) a with x from its centre (special conformal maps): they
//! have no strain but a dilatation that is linear, and its mean is none. Two tets with a common face have none left.

use crate::bulk_viscosity::{ViscousState, damped_step_factor};
use crate::element::{Element, ElementHistory, ElementMotion, ElementStep, ElementUpdate};
use crate::stable_time_step::{ElasticBounds, Metrics, TetGeometry};
use crate::tet_parent::{self, CORNERS, SIGNS};
use arrayvec::ArrayVec;
use estar_material::{Material, Motion, PointGradients, PointState, StepKinematics};
use estar_tensor::{Real, Rotation, Tensor, Vector3, array, prefetch};

/// Nodes of an element.
pub const NODES: usize = 10;
/// Quadrature points of an element.
pub const POINTS: usize = 4;

/// The node between two corners; of a corner and itself, the corner.
const BETWEEN: [[usize; CORNERS]; CORNERS] = [[0, 4, 6, 7], [4, 1, 5, 8], [6, 5, 2, 9], [7, 8, 9, 3]];

/// 1/√5.
const PER_ROOT_FIVE: f64 = 0.447_213_595_499_957_94;
/// Volume of a point in the parent.
const WEIGHT: f64 = tet_parent::VOLUME / POINTS as f64;

/// φ of corners and of middles.
const CORNER_SHARE: f64 = 1.0 / 36.0;
const MIDDLE_SHARE: f64 = 4.0 / 27.0;
/// κ of [`stable_time_step`](crate::stable_time_step), rounded up; `tests/tets.rs` computes it.
const PARENT_BOUND: f64 = 17.167_125;

/// The element: nothing is to be chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tet10;

/// A vector at each node.
type NodeVectors<R> = [Vector3<R>; NODES];

/// History of an element's points.
#[derive(Clone, Copy, Debug)]
pub struct Tet10History<State, R> {
    /// History of the material.
    pub states: [State; POINTS],
    /// Rotations R_n; none where the theory needs none.
    pub rotations: [Rotation<R>; POINTS],
    /// Stable time step at t_n, s.
    pub stable_time_step: R,
    /// Pressure of bulk viscosity at t_n, Pa.
    pub viscous_pressure: R,
}

impl<R: Real, S: PointState<R>> ElementHistory<R, S> for Tet10History<S, R> {
    fn states(&self) -> &[S] {
        &self.states
    }

    fn rotations(&self) -> &[Rotation<R>] {
        &self.rotations
    }

    fn stable_time_step(&self) -> R {
        self.stable_time_step
    }

    fn for_each(&self, mut visit: impl FnMut(R)) {
        for (state, rotation) in self.states.iter().zip(&self.rotations) {
            state.for_each(&mut visit);
            rotation.0.into_iter().for_each(&mut visit);
        }
        visit(self.stable_time_step);
        visit(self.viscous_pressure);
    }

    fn from_numbers(mut next: impl FnMut() -> R) -> Self {
        let points: [_; POINTS] = array(|_| (S::from_numbers(&mut next), Rotation(array(|_| next()))));
        Self {
            states: points.map(|(state, _)| state),
            rotations: points.map(|(_, rotation)| rotation),
            stable_time_step: next(),
            viscous_pressure: next(),
        }
    }

    fn select(mask: R::Mask, chosen: &Self, otherwise: &Self) -> Self {
        let number = |chosen: R, otherwise: R| R::select(mask, chosen, otherwise);
        let rotation =
            |point: usize| Rotation(array(|i| number(chosen.rotations[point].0[i], otherwise.rotations[point].0[i])));
        Self {
            states: array(|point| S::select(mask, &chosen.states[point], &otherwise.states[point])),
            rotations: array(rotation),
            stable_time_step: number(chosen.stable_time_step, otherwise.stable_time_step),
            viscous_pressure: number(chosen.viscous_pressure, otherwise.viscous_pressure),
        }
    }
}

/// ∂x/∂r at the points.
#[inline(always)]
fn gradients<R: Real>(nodes: &NodeVectors<R>) -> [Tensor<R>; POINTS] {
    let mut sums = [Vector3::zero(); CORNERS];
    for (corner, sum) in sums.iter_mut().enumerate() {
        let mut middles = Vector3::zero();
        for other in 0..CORNERS {
            if other != corner {
                middles = middles + nodes[BETWEEN[corner][other]];
            }
        }
        *sum = middles * R::splat(1.0 - PER_ROOT_FIVE) - nodes[corner] * R::splat(PER_ROOT_FIVE);
    }
    let mut gradients = [Tensor::zero(); POINTS];
    for (point, gradient) in gradients.iter_mut().enumerate() {
        let mut slopes = sums;
        for (corner, slope) in slopes.iter_mut().enumerate() {
            *slope = nodes[BETWEEN[corner][point]].mul_add(R::splat(4.0 * PER_ROOT_FIVE), *slope);
        }
        *gradient = tet_parent::gradient(&slopes);
    }
    gradients
}

/// The transpose of [`gradients`]: what the fluxes of the points, whose columns belong to ∂/∂r, do on the nodes.
#[inline(always)]
fn node_sums<R: Real>(fluxes: &[Tensor<R>]) -> NodeVectors<R> {
    let mut nodes = [Vector3::zero(); NODES];
    let mut sums = [Vector3::zero(); CORNERS];
    for (point, flux) in fluxes.iter().enumerate() {
        let slopes = tet_parent::slopes(flux);
        for (corner, slope) in slopes.iter().enumerate() {
            sums[corner] = sums[corner] + *slope;
            let node = &mut nodes[BETWEEN[corner][point]];
            *node = slope.mul_add(R::splat(4.0 * PER_ROOT_FIVE), *node);
        }
    }
    for (corner, sum) in sums.iter().enumerate() {
        for other in 0..CORNERS {
            let factor = if other == corner { -PER_ROOT_FIVE } else { 1.0 - PER_ROOT_FIVE };
            let node = &mut nodes[BETWEEN[corner][other]];
            *node = sum.mul_add(R::splat(factor), *node);
        }
    }
    nodes
}

impl Element<NODES> for Tet10 {
    const POINTS: usize = POINTS;
    const PARENT: [[f64; 3]; NODES] = {
        let mut parent = [[0.0; 3]; NODES];
        let mut entry = 0;
        while entry < CORNERS * CORNERS * 3 {
            let (corner, other, axis) = (entry / 12, entry / 3 % CORNERS, entry % 3);
            parent[BETWEEN[corner][other]][axis] = 0.5 * (SIGNS[corner][axis] + SIGNS[other][axis]);
            entry += 1;
        }
        parent
    };
    type History<R: Real, S: PointState<R>> = Tet10History<S, R>;

    fn initial_history<R: Real, M: Material>(material: &M, stable_time_step: f64) -> Tet10History<M::State<R>, R> {
        Tet10History {
            states: [material.initial_state(); POINTS],
            rotations: [Rotation::identity(); POINTS],
            stable_time_step: R::splat(stable_time_step),
            viscous_pressure: R::splat(0.0),
        }
    }

    fn lumped_mass(reference: &NodeVectors<f64>, density: f64) -> [f64; NODES] {
        let volumes = gradients(reference).map(|gradient| gradient.determinant());
        let mass = density * WEIGHT * volumes.iter().sum::<f64>();
        std::array::from_fn(|node| mass * if node < CORNERS { CORNER_SHARE } else { MIDDLE_SHARE })
    }

    fn smallest_jacobian(position: &NodeVectors<f64>) -> f64 {
        gradients(position).iter().fold(f64::INFINITY, |smallest, gradient| smallest.min(gradient.determinant()))
    }

    #[inline(always)]
    fn advance<R: Real, M: Material>(
        self,
        material: &M,
        history: &mut Tet10History<M::State<R>, R>,
        upcoming: Option<&Tet10History<M::State<R>, R>>,
        motion: &ElementMotion<R, NODES>,
        step: &ElementStep,
    ) -> ElementUpdate<R, NODES> {
        let elasticity = material.elasticity();
        let zero = R::splat(0.0);
        let weight = R::splat(WEIGHT);
        let (reference, position, velocity) =
            (gradients(&motion.reference), gradients(&motion.position), gradients(&motion.velocity));

        // (i) L, F and R of every point, and the mean volume change θ̄ = ∫ tr L dv / v, J̄ = v/V
        let mut increments = ArrayVec::<Tensor<R>, POINTS>::new();
        let mut volumes_half = ArrayVec::<R, POINTS>::new();
        let mut deformation_gradients = ArrayVec::<Tensor<R>, POINTS>::new();
        let mut jacobians = ArrayVec::<R, POINTS>::new();
        let mut rotations = ArrayVec::<Rotation<R>, POINTS>::new();
        let (mut change, mut volume_half) = (zero, zero);
        let (mut parent_volume, mut reference_volume) = (zero, zero);
        let mut min_jacobian = R::splat(f64::INFINITY);
        for point in 0..POINTS {
            if let Some(upcoming) = upcoming {
                prefetch(&upcoming.states[point]);
                prefetch(&upcoming.rotations[point]);
            }
            let gradients =
                PointGradients { reference: reference[point], position: position[point], velocity: velocity[point] };
            let (increment, half) = gradients.incremental_displacement_gradient(step.time_step);
            change = increment.trace().mul_add(half, change);
            volume_half += half;
            increments.push(increment);
            volumes_half.push(half);
            let (scaled_gradient, per_reference_volume) = gradients.scaled_deformation_gradient();
            let volume = position[point].determinant();
            let jacobian = volume * per_reference_volume;
            parent_volume += volume;
            reference_volume += per_reference_volume.recip();
            min_jacobian = min_jacobian.min(jacobian);
            jacobians.push(jacobian);
            deformation_gradients.push(scaled_gradient * per_reference_volume);
            let rotation_old = &history.rotations[point];
            rotations.push(if M::Motion::<R>::NEEDS_ROTATION {
                Rotation::nearest(&scaled_gradient, *rotation_old)
            } else {
                *rotation_old
            });
        }
        let mean_increment = change / volume_half;
        let mean_jacobian = parent_volume / reference_volume;
        let volume = parent_volume * weight;
        let viscous = step.bulk_viscosity.map(|viscosity| {
            let density = R::splat(elasticity.density()) / mean_jacobian;
            let wave_speed = (R::splat(elasticity.p_wave_modulus()) / density).sqrt();
            let length = wave_speed * history.stable_time_step;
            // at the start no step has been made, and nothing moves
            let volumetric_rate = if step.time_step > 0.0 { mean_increment * (1.0 / step.time_step) } else { zero };
            viscosity.response(&ViscousState { volumetric_rate, density, wave_speed, length })
        });
        let viscous_pressure = viscous.map_or(zero, |response| response.pressure);

        // (ii) history, and ∫ T : D̄ dV over the step on the mid-step volume
        let (mut internal_energy, mut plastic_dissipation) = (zero, zero);
        let mut stiffening = None;
        for point in 0..POINTS {
            // L̄ = L + ⅓ (θ̄ − tr L) I, F̄ = (J̄/J)^⅓ F
            let correction = (mean_increment - increments[point].trace()) * (1.0 / 3.0);
            let scale = (mean_jacobian / jacobians[point]).cbrt();
            let motion = M::Motion::new(&StepKinematics {
                incremental_displacement_gradient: increments[point].plus_spherical(correction),
                deformation_gradient: deformation_gradients[point] * scale,
                rotation_old: history.rotations[point],
                rotation_new: rotations[point],
            });
            history.rotations[point] = rotations[point];
            if let Some(ratio) = material.stiffening(&motion) {
                stiffening = Some(stiffening.map_or(ratio, |largest: R| largest.max(ratio)));
            }
            let update = material.update(&history.states[point], &motion, step.time_step);
            history.states[point] = update.state;
            internal_energy = update.internal_energy.mul_add(volumes_half[point], internal_energy);
            plastic_dissipation = update.plastic_dissipation.mul_add(volumes_half[point], plastic_dissipation);
        }

        // (iii) forces f_a = Σ_q w T cof(∂x/∂r) ∂N_a/∂r with the mean pressure in T
        let mut stresses = ArrayVec::<_, POINTS>::new();
        let mut mean_stress = zero;
        for (point, gradient) in position.iter().enumerate() {
            let stress = material.cauchy_stress(&history.states[point], rotations[point]);
            mean_stress = stress.trace().mul_add(gradient.determinant(), mean_stress);
            stresses.push(stress);
        }
        mean_stress = mean_stress / (parent_volume * 3.0);
        let mut cofactors = ArrayVec::<Tensor<R>, POINTS>::new();
        let mut fluxes = ArrayVec::<Tensor<R>, POINTS>::new();
        let mut metrics = Metrics::none();
        for (gradient, stress) in position.iter().zip(&stresses) {
            let cofactor = gradient.cofactor();
            metrics = metrics.with(gradient, &cofactor, gradient.columns[0].dot(cofactor.columns[0]));
            let shared = mean_stress - viscous_pressure - stress.trace() * (1.0 / 3.0);
            let weighted = cofactor * weight;
            fluxes.push(stress.plus_spherical(shared).to_tensor().dot(&weighted));
            cofactors.push(weighted);
        }

        let divergences = node_sums(&cofactors);
        let mut divergence = zero;
        for (node, vector) in divergences.iter().enumerate() {
            let per_share = if node < CORNERS { 1.0 / CORNER_SHARE } else { 1.0 / MIDDLE_SHARE };
            divergence = vector.dot(*vector).mul_add(R::splat(per_share), divergence);
        }
        let bounds =
            ElasticBounds { shear_modulus: elasticity.shear_modulus(), bulk_modulus: elasticity.bulk_modulus() };
        let geometry = TetGeometry { metric: metrics.greatest(), volume, divergence };
        let mass = motion.corner_mass * (1.0 / CORNER_SHARE);
        let undamped = bounds.stable_time_step_tet10(&geometry, PARENT_BOUND, mass);
        let undamped = if let Some(ratio) = stiffening { undamped / ratio.sqrt() } else { undamped };
        history.stable_time_step = undamped;
        // −∫∫ q dV̇ dt, the mean pressure of the step on the volume change
        let mean_pressure = (history.viscous_pressure + viscous_pressure) * 0.5;
        let viscous_energy = -(mean_pressure * change * weight);
        history.viscous_pressure = viscous_pressure;
        ElementUpdate {
            internal_force: node_sums(&fluxes),
            internal_energy: internal_energy * weight,
            plastic_dissipation: plastic_dissipation * weight,
            viscous_energy,
            hourglass_energy: zero,
            min_jacobian,
            stable_time_step: viscous
                .map_or(undamped, |response| undamped * damped_step_factor(response.damping_ratio)),
        }
    }
}

/// Volume of the element by its points, m³.
pub fn volume(position: &NodeVectors<f64>) -> f64 {
    WEIGHT * gradients(position).iter().map(Tensor::determinant).sum::<f64>()
}
