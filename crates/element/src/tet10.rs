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
use estar_material::points::PackPoints;
use estar_material::{IsotropicElasticity, PointGradients};
use estar_tensor::{Real, SymmetricTensor, Tensor, Vector3};

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
    type Own<R: Real> = ();

    fn lumped_mass(reference: &NodeVectors<f64>, density: f64) -> [f64; NODES] {
        let mass = density * enclosed_volume(reference);
        std::array::from_fn(|node| mass * if node < CORNERS { CORNER_SHARE } else { MIDDLE_SHARE })
    }

    fn smallest_jacobian(position: &NodeVectors<f64>) -> f64 {
        gradients(position).iter().fold(f64::INFINITY, |smallest, gradient| smallest.min(gradient.determinant()))
    }

    #[inline(always)]
    fn advance<R: Real>(
        self,
        elasticity: &IsotropicElasticity,
        mut points: PackPoints<'_, R>,
        history: &mut ElementHistory<R, ()>,
        motion: &ElementMotion<R, NODES>,
        step: &ElementStep,
    ) -> ElementUpdate<R, NODES> {
        let zero = R::splat(0.0);
        let weight = R::splat(WEIGHT);
        let (reference, position, velocity) =
            (gradients(&motion.reference), gradients(&motion.position), gradients(&motion.velocity));

        // (i) L and F of every point, and the mean volume change θ̄ = ∫ tr L dv / v, J̄ = v/V
        let mut increments = ArrayVec::<Tensor<R>, POINTS>::new();
        let mut volumes_half = ArrayVec::<R, POINTS>::new();
        let mut per_reference_volumes = ArrayVec::<R, POINTS>::new();
        let mut jacobians = ArrayVec::<R, POINTS>::new();
        let exchange = &mut *points.exchange;
        let (mut change, mut volume_half) = (zero, zero);
        let (mut parent_volume, mut reference_volume) = (zero, zero);
        let mut min_jacobian = R::splat(f64::INFINITY);
        for point in 0..POINTS {
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
            per_reference_volumes.push(per_reference_volume);
            exchange.motions[point].scaled_gradient = scaled_gradient;
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

        // L̄ = L + ⅓ (θ̂ − tr L) I with θ̂ = (1 − α) θ̄ + α tr L, F̄ = (J̄/J)^{⅓ (1 − α)} F
        let needs_deformation_gradient = points.points.needs().deformation_gradient;
        for (point, told) in exchange.motions[..POINTS].iter_mut().enumerate() {
            let correction = (mean_increment - increments[point].trace()) * ((1.0 - OWN_SHARE) / 3.0);
            told.incremental_displacement_gradient = increments[point].plus_spherical(correction);
            told.volume_half = volumes_half[point];
            if needs_deformation_gradient {
                let scale = stabilized(mean_jacobian / jacobians[point]).cbrt();
                told.deformation_gradient = told.scaled_gradient * per_reference_volumes[point] * scale;
            }
        }
        exchange.tells_flow = false;

        // (ii) history and stress
        let update = points.update(step.time_step);
        let stresses = &points.exchange.stresses[..POINTS];

        // (iii) forces f_a = Σ_q w T cof(∂x/∂r) ∂N_a/∂r with the mean stress (1 − α) σ̄ + α σ in T
        let mut mean_stress = zero;
        for (stress, gradient) in stresses.iter().zip(&position) {
            mean_stress = stress.trace().mul_add(gradient.determinant(), mean_stress);
        }
        mean_stress = mean_stress / (parent_volume * 3.0);
        let mut cofactors = ArrayVec::<Tensor<R>, POINTS>::new();
        let mut fluxes = ArrayVec::<Tensor<R>, POINTS>::new();
        let mut metrics = Metrics::none();
        for (gradient, stress) in position.iter().zip(stresses) {
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
        let undamped = if let Some(ratio) = update.stiffening { undamped / ratio.sqrt() } else { undamped };
        history.stable_time_step = undamped;
        // −∫∫ q dV̇ dt, the mean pressure of the step on the volume change
        let mean_pressure = (history.viscous_pressure + viscous_pressure) * 0.5;
        let viscous_energy = -(mean_pressure * change * weight);
        history.viscous_pressure = viscous_pressure;
        ElementUpdate {
            internal_force: node_sums(&fluxes),
            internal_energy: update.internal_energy * weight,
            plastic_dissipation: update.plastic_dissipation * weight,
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
