//! The ten-node tet with four points, `tet10`, edges straight or bent at their middles, with the mean
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
//! The element is the composite one of Thoutireddy, Molinari, Repetto & Ortiz (2002), here with four points: its motion is linear in each of twelve tets, four at the corners and eight round the mean of the middles,
//! and its gradient is the field linear in the volume coordinates λ that is nearest in the sum of squares. So corners have their
//! share of the mean pressure, which those of the quadratic tet do not have (∫ ∇N_a dV = 0 for straight edges): a shock would
//! drive them through the tet. Volume coordinates of the point nearest corner p are λ_p = ¼ (1 + 3/√5) and ¼ (1 − 1/√5) for the
//! others. There, with M_i = Σ_j x_ij, T the sum of all middles and x_ii = x_i,
//!
//! ```text
//! ∂x/∂λ_i = b_i + ¾ √5 x_ip  (i ≠ p),   ∂x/∂λ_p = b_p + ¼ √5 (2 x_p + M_p) − (√5/12) T,
//! b_i = ⅛ (2 − √5) x_i + ¼ (3 − √5) M_i
//! ```
//!
//! The force is the transpose of the same. The lumped mass is that of the twelve tets, which sixteen flat triangles enclose, also
//! where edges are bent: a corner has 1/32 and a middle 7/48 of the whole, all positive.
//!
//! The 24 motions that deform a single tet have at the points 20 changes of shape and one mean change of volume, so that three
//! of them would have no stress. Two tets with a common face have none of these left, but where a metal flows little holds them,
//! and a shock turns tets at a rim inside out. So each point keeps the share α = 1/16 of its own volume change,
//! θ̂ = (1 − α) θ̄ + α θ, and the forces have the mean stress (1 − α) σ̄ + α σ, which does the same work; the volume change that
//! differs from the mean has the stiffness α² k.

use crate::bulk_viscosity::{ViscousState, damped_step_factor};
use crate::element::{Element, ElementHistory, ElementMotion, ElementStep, ElementUpdate, Tangent};
use crate::stable_time_step::{ElasticBounds, Metrics, TetGeometry, TetParent};
use crate::tet_parent::{self, CORNERS, SIGNS};
use arrayvec::ArrayVec;
use estar_material::{IsotropicElasticity, Material, Motion, PointGradients, PointState, StepKinematics};
use estar_tensor::{Real, Rotation, SymmetricTensor, Tensor, Vector3, array, prefetch};

/// Nodes of an element.
pub const NODES: usize = 10;
/// Quadrature points of an element.
pub const POINTS: usize = 4;

/// The node between two corners; of a corner and itself, the corner.
const BETWEEN: [[usize; CORNERS]; CORNERS] = [[0, 4, 6, 7], [4, 1, 5, 8], [6, 5, 2, 9], [7, 8, 9, 3]];

/// √5.
const ROOT_FIVE: f64 = 2.236_067_977_499_79;
/// Shares of the nodes in ∂x/∂λ, see above.
const OF_CORNER: f64 = (2.0 - ROOT_FIVE) / 8.0;
const OF_MIDDLES: f64 = (3.0 - ROOT_FIVE) / 4.0;
const TO_POINT: f64 = 0.75 * ROOT_FIVE;
const AT_POINT: f64 = 0.25 * ROOT_FIVE;
const OF_ALL: f64 = ROOT_FIVE / -12.0;
/// Volume of a point in the parent.
const WEIGHT: f64 = tet_parent::VOLUME / POINTS as f64;

/// α, the share of its own volume change that a point keeps; a power of ½, see [`stabilized`].
const OWN_SHARE: f64 = 1.0 / 16.0;

/// φ of corners and of middles.
const CORNER_SHARE: f64 = 1.0 / 32.0;
const MIDDLE_SHARE: f64 = 7.0 / 48.0;
/// κ of [`stable_time_step`](crate::stable_time_step).
const PARENT_BOUND: f64 = 20.0 / 3.0;

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
    let mut middles = [Vector3::zero(); CORNERS];
    let mut bases = middles;
    for corner in 0..CORNERS {
        for other in 0..CORNERS {
            if other != corner {
                middles[corner] = middles[corner] + nodes[BETWEEN[corner][other]];
            }
        }
        bases[corner] = middles[corner].mul_add(R::splat(OF_MIDDLES), nodes[corner] * R::splat(OF_CORNER));
    }
    // every middle is in two of the sums
    let all = (middles[0] + middles[1] + middles[2] + middles[3]) * R::splat(0.5 * OF_ALL);
    let mut gradients = [Tensor::zero(); POINTS];
    for (point, gradient) in gradients.iter_mut().enumerate() {
        let mut slopes = bases;
        for (corner, slope) in slopes.iter_mut().enumerate() {
            *slope = if corner == point {
                (nodes[point] + nodes[point] + middles[point]).mul_add(R::splat(AT_POINT), *slope + all)
            } else {
                nodes[BETWEEN[corner][point]].mul_add(R::splat(TO_POINT), *slope)
            };
        }
        *gradient = tet_parent::gradient(&slopes);
    }
    gradients
}

/// The transpose of [`gradients`]: what the fluxes of the points, whose columns belong to ∂/∂r, do on the nodes.
#[inline(always)]
fn node_sums<R: Real>(fluxes: &[Tensor<R>]) -> NodeVectors<R> {
    let mut nodes = [Vector3::zero(); NODES];
    let mut bases = [Vector3::zero(); CORNERS];
    let mut at_points = bases;
    let mut all = Vector3::zero();
    for (point, flux) in fluxes.iter().enumerate() {
        let slopes = tet_parent::slopes(flux);
        for (corner, slope) in slopes.iter().enumerate() {
            bases[corner] = bases[corner] + *slope;
            if corner == point {
                at_points[point] = *slope * R::splat(AT_POINT);
                all = slope.mul_add(R::splat(OF_ALL), all);
            } else {
                let node = &mut nodes[BETWEEN[corner][point]];
                *node = slope.mul_add(R::splat(TO_POINT), *node);
            }
        }
    }
    for corner in 0..CORNERS {
        nodes[corner] = bases[corner].mul_add(R::splat(OF_CORNER), at_points[corner] + at_points[corner]);
        let to_middles = bases[corner].mul_add(R::splat(OF_MIDDLES), at_points[corner]);
        for other in 0..CORNERS {
            if other != corner {
                let node = &mut nodes[BETWEEN[corner][other]];
                *node = *node + to_middles;
            }
        }
    }
    for middle in &mut nodes[CORNERS..] {
        *middle = *middle + all;
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
        let mass = density * enclosed_volume(reference);
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
            // L̄ = L + ⅓ (θ̂ − tr L) I with θ̂ = (1 − α) θ̄ + α tr L, F̄ = (J̄/J)^{⅓ (1 − α)} F
            let correction = (mean_increment - increments[point].trace()) * ((1.0 - OWN_SHARE) / 3.0);
            let scale = stabilized(mean_jacobian / jacobians[point]).cbrt();
            let motion = M::Motion::new(&StepKinematics {
                incremental_displacement_gradient: increments[point].plus_spherical(correction),
                deformation_gradient: deformation_gradients[point] * scale,
                rotation_old: history.rotations[point],
                rotation_new: rotations[point],
            });
            history.rotations[point] = rotations[point];
            let update = material.update(&history.states[point], &motion, step.time_step);
            history.states[point] = update.state;
            if let Some(ratio) = material.stiffening(&update.state, &motion) {
                stiffening = Some(stiffening.map_or(ratio, |largest: R| largest.max(ratio)));
            }
            internal_energy = update.internal_energy.mul_add(volumes_half[point], internal_energy);
            plastic_dissipation = update.plastic_dissipation.mul_add(volumes_half[point], plastic_dissipation);
        }

        // (iii) forces f_a = Σ_q w T cof(∂x/∂r) ∂N_a/∂r with the mean stress (1 − α) σ̄ + α σ in T
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
            let shared = (mean_stress - stress.trace() * (1.0 / 3.0)) * (1.0 - OWN_SHARE) - viscous_pressure;
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
        let undamped =
            bounds.stable_time_step_tet10(&geometry, &TetParent { bound: PARENT_BOUND, own_share: OWN_SHARE }, mass);
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

    fn tangent<R: Real>(
        self,
        _: &IsotropicElasticity,
        _: R,
        _: &ElementMotion<R, NODES>,
        _: &ElementStep,
    ) -> Tangent<R> {
        Tangent { stiffening: R::splat(1.0), ..Tangent::none() }
    }

    #[inline(always)]
    fn linear_forces<R: Real>(
        self,
        elasticity: &IsotropicElasticity,
        _: &Tangent<R>,
        position: &NodeVectors<R>,
        displacement: &NodeVectors<R>,
    ) -> NodeVectors<R> {
        let (shear, bulk) = (elasticity.shear_modulus(), elasticity.bulk_modulus());
        // j D of the points, with j ∇u = (∂u/∂r) cof(∂x/∂r)ᵀ, and θ̄
        let mut cofactors = ArrayVec::<Tensor<R>, POINTS>::new();
        let mut strains = ArrayVec::<SymmetricTensor<R>, POINTS>::new();
        let mut jacobians = ArrayVec::<R, POINTS>::new();
        let (mut volume, mut change) = (R::splat(0.0), R::splat(0.0));
        for (gradient, slope) in gradients(position).iter().zip(&gradients(displacement)) {
            let cofactor = gradient.cofactor();
            let strain = slope.dot(&cofactor.transpose()).symmetric_part();
            let jacobian = gradient.columns[0].dot(cofactor.columns[0]);
            volume += jacobian;
            change += strain.trace();
            cofactors.push(cofactor);
            strains.push(strain);
            jacobians.push(jacobian);
        }
        let mean = change / volume;
        let mut fluxes = ArrayVec::<Tensor<R>, POINTS>::new();
        for ((strain, cofactor), jacobian) in strains.iter().zip(&cofactors).zip(&jacobians) {
            let strain = *strain * jacobian.recip();
            // 2μ dev D + k (θ̄ + α² (θ − θ̄)) I
            let trace = strain.trace();
            let volumetric = (trace - mean).mul_add(R::splat(OWN_SHARE * OWN_SHARE), mean) * bulk;
            let stress = (strain * R::splat(2.0 * shear)).plus_spherical(volumetric - trace * (2.0 / 3.0 * shear));
            fluxes.push(stress.to_tensor().dot(&(*cofactor * R::splat(WEIGHT))));
        }
        node_sums(&fluxes)
    }
}

/// Corners of each face, counter-clockwise as seen from outside.
const FACES: [[usize; 3]; CORNERS] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

/// Volume of the twelve tets, m³: what the four flat triangles of each face enclose, ⅙ Σ x_a · (x_b × x_c).
fn enclosed_volume(position: &NodeVectors<f64>) -> f64 {
    // from one of its nodes, so that nothing is lost far from the origin
    let from_first = |node: usize| position[node] - position[0];
    let mut sum = 0.0;
    for [a, b, c] in FACES {
        let (ab, bc, ca) = (BETWEEN[a][b], BETWEEN[b][c], BETWEEN[c][a]);
        for triangle in [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]] {
            let [x, y, z] = triangle.map(from_first);
            sum += x.dot(y.cross(z));
        }
    }
    sum / 6.0
}

/// `ratio`^(1 − α), by roots, which are the same on every machine.
#[inline(always)]
fn stabilized<R: Real>(ratio: R) -> R {
    ratio / ratio.sqrt().sqrt().sqrt().sqrt()
}

/// Volume of the element by its points, m³.
pub fn volume(position: &NodeVectors<f64>) -> f64 {
    WEIGHT * gradients(position).iter().map(Tensor::determinant).sum::<f64>()
}
