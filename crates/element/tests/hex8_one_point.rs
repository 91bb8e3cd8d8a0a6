//! Goal: the hex with one point sees every uniform motion exactly, on any shape; its hourglass control resists what is left, does
//! the work that the ledger says, turns with the element and leaves no motion free; its step is bounded.
//!
//! Mesh: one element. Source: closed forms with the quadrature of `common`, the material-point driver, the theory of plates.

mod common;

use common::{
    Corners, DENSITY, Driven, Random, brick, distorted_hexes, elasticity, mapped, perturbed, quadrature, row_sum_mass,
    smallest, vectors,
};
use estar_element::bulk_viscosity::BulkViscosity;
use estar_element::element::ElementStep;
use estar_element::hex8::{CornerVectors, HexMotion, HexUpdate};
use estar_element::hex8_one_point::HourglassControl;
use estar_material::point::MaterialPoint;
use estar_material::{EStar, Elastic, Hencky, IsotropicHardening, Material};
use estar_tensor::{LaneLevel, Real, Rotation, SymmetricTensor, Tensor, Vector3, WithLanes, dispatch};
use faer::{Mat, Side};

const TIME_STEP: f64 = 1e-7;
const CONTROLS: [HourglassControl; 3] = [
    HourglassControl::Physical,
    HourglassControl::Stiffness { coefficient: 0.05 },
    HourglassControl::Viscous { coefficient: 0.1 },
];

/// An element on its way.
struct Hex<M: Material> {
    driven: Driven<HourglassControl, M, f64, 8>,
    reference: Corners,
    position: Corners,
    bulk_viscosity: Option<BulkViscosity>,
}

impl<M: Material> Hex<M> {
    fn new(material: &M, control: HourglassControl, reference: Corners) -> Self {
        Self { driven: Driven::new(control, material), reference, position: reference, bulk_viscosity: None }
    }

    /// Moves the corners along straight lines in a step.
    fn move_to(&mut self, position: Corners, time_step: f64) -> HexUpdate<f64> {
        let per_step = if time_step > 0.0 { 1.0 / time_step } else { 0.0 };
        let velocity = std::array::from_fn(|a| (Vector3(position[a]) - Vector3(self.position[a])) * per_step);
        let corner_mass = smallest(&row_sum_mass(&self.reference, DENSITY));
        let motion =
            HexMotion { reference: vectors(&self.reference), position: vectors(&position), velocity, corner_mass };
        self.position = position;
        let step = ElementStep { bulk_viscosity: self.bulk_viscosity, time_step };
        self.driven.advance(&motion, &step)
    }
}

fn elastic() -> Elastic {
    Elastic::new(elasticity(0.35))
}

/// Copper of the Taylor bar.
fn copper() -> EStar<(), IsotropicHardening> {
    EStar::new(elasticity(0.35), IsotropicHardening::linear(400e6, 100e6).unwrap(), ())
}

fn distance(a: &CornerVectors<f64>, b: &CornerVectors<f64>) -> f64 {
    a.iter().zip(b).flat_map(|(a, b)| (*a - *b).0).fold(0.0, |greatest, difference| greatest.max(difference.abs()))
}

fn greatest(vectors: &CornerVectors<f64>) -> f64 {
    distance(vectors, &[Vector3::zero(); 8])
}

fn volume(corners: &Corners) -> f64 {
    quadrature(corners).iter().map(|point| point.volume).sum()
}

/// Hexes and homogeneous deformations F of up to 20 %, with rotation.
fn cases() -> Vec<(Corners, Tensor<f64>)> {
    let mut random = Random::new(7);
    let shapes = distorted_hexes(20, &mut random);
    shapes.into_iter().map(|shape| (shape, Tensor::identity() + random.tensor(0.2))).collect()
}

fn assert_uniform_motion_is_exact<M: Material>(material: &M) {
    for (reference, deformation) in cases() {
        for control in CONTROLS {
            let mut point = MaterialPoint::new(material);
            let mut hex = Hex::new(material, control, reference);
            let (mut energy, mut hourglass) = (0.0, 0.0);
            for part in [0.25, 0.5, 0.75, 1.0] {
                let gradient = Tensor::identity() * (1.0 - part) + deformation * part;
                point.advance(&gradient, TIME_STEP);
                let update = hex.move_to(mapped(&reference, &gradient), TIME_STEP);
                energy += update.internal_energy;
                hourglass += update.hourglass_energy;
                let stress = *point.stress();
                // f_a = T ∫ ∇N_a dV
                let points = quadrature(&hex.position);
                let force: CornerVectors<f64> = std::array::from_fn(|a| {
                    points.iter().fold(Vector3::zero(), |sum, point| {
                        stress.to_tensor().apply(Vector3(point.gradient[a])).mul_add(point.volume, sum)
                    })
                });
                assert!(distance(&update.internal_force, &force) < 1e-9 * greatest(&force), "{control:?}");
                assert!((update.min_jacobian - gradient.determinant()).abs() < 1e-12, "{control:?}");
            }
            let expected = volume(&reference) * point.internal_energy();
            assert!((energy - expected).abs() < 1e-9 * expected.abs(), "{control:?}: {energy} {expected}");
            assert!(hourglass.abs() < 1e-15 * expected.abs(), "{control:?}: {hourglass}");
        }
    }
}

/// The patch test of one element: every control, every distorted shape, also where the material yields.
#[test]
fn uniform_motion_gives_the_stress_of_the_point_and_its_closed_form_forces_and_no_hourglass_force() {
    assert_uniform_motion_is_exact(&elastic());
    assert_uniform_motion_is_exact(&copper());
    assert_uniform_motion_is_exact(&Hencky::von_mises(
        elasticity(0.35),
        IsotropicHardening::linear(400e6, 100e6).unwrap(),
    ));
}

#[test]
fn a_rigid_turn_turns_stress_and_hourglass_forces_and_does_no_work() {
    let material = copper();
    let turn = Rotation::about([1.0, 2.0, -0.5], 150_f64.to_radians()).to_tensor();
    for (reference, deformation) in cases() {
        for control in CONTROLS {
            let mut hex = Hex::new(&material, control, reference);
            let bent = perturbed(&mapped(&reference, &deformation), 1e-3, &mut Random::new(3));
            let before = hex.move_to(bent, TIME_STEP);
            let after = hex.move_to(mapped(&bent, &turn), TIME_STEP);
            let expected = match control {
                // a rate that is over resists no more
                HourglassControl::Viscous { .. } => {
                    let mut still = Hex::new(&material, control, reference);
                    still.move_to(bent, TIME_STEP);
                    still.move_to(bent, TIME_STEP).internal_force
                }
                _ => before.internal_force,
            };
            let expected = expected.map(|force| turn.apply(force));
            assert!(distance(&after.internal_force, &expected) < 1e-9 * greatest(&expected), "{control:?}");
            let energy = before.internal_energy + before.hourglass_energy;
            assert!((after.internal_energy + after.hourglass_energy).abs() < 1e-9 * energy, "{control:?}");
        }
    }
}

#[test]
fn forces_and_their_moments_balance_in_any_motion() {
    let material = copper();
    let mut random = Random::new(11);
    for reference in distorted_hexes(50, &mut random) {
        let size = volume(&reference).cbrt();
        for control in CONTROLS {
            let mut hex = Hex::new(&material, control, reference);
            hex.bulk_viscosity = Some(BulkViscosity { linear: 0.06, quadratic: 1.2 });
            for _ in 0..3 {
                let update = hex.move_to(perturbed(&hex.position, 5e-3 * size, &mut random), TIME_STEP);
                let force = &update.internal_force;
                let sum = force.iter().fold(Vector3::zero(), |sum, force| sum + *force);
                let places = vectors(&hex.position);
                let moment = force.iter().zip(places).fold(Vector3::zero(), |sum, (f, x)| sum + x.cross(*f));
                let scale = greatest(force);
                assert!(sum.dot(sum).sqrt() < 1e-12 * scale, "{control:?}: {sum:?} of {scale}");
                assert!(moment.dot(moment).sqrt() < 1e-11 * scale, "{control:?}: {moment:?} of {scale}");
            }
        }
    }
}

/// Work of the corner forces over a straight motion, less stress power and hourglass energy, as a fraction of those.
fn work_surplus(reference: &Corners, end: &Corners, steps: u32, control: HourglassControl) -> f64 {
    let material = elastic();
    let mut hex = Hex::new(&material, control, *reference);
    let mut force_old = [Vector3::zero(); 8];
    let (mut work, mut energy) = (0.0, 0.0);
    for part in (1..=steps).map(|step| f64::from(step) / f64::from(steps)) {
        let new = std::array::from_fn(|a| std::array::from_fn(|i| reference[a][i] * (1.0 - part) + end[a][i] * part));
        let old = hex.position;
        // the motion takes as long in many short steps as in few long ones
        let update = hex.move_to(new, 1e-5 / f64::from(steps));
        for a in 0..8 {
            let mean = (force_old[a] + update.internal_force[a]) * 0.5;
            work += mean.dot(Vector3(new[a]) - Vector3(old[a]));
        }
        energy += update.internal_energy + update.hourglass_energy;
        force_old = update.internal_force;
    }
    (work - energy) / energy
}

#[test]
fn stress_power_and_hourglass_energy_are_the_work_of_the_forces_in_any_motion() {
    let mut random = Random::new(17);
    for (reference, deformation) in cases() {
        let end = perturbed(&mapped(&reference, &deformation), 0.05 * volume(&reference).cbrt(), &mut random);
        for control in CONTROLS {
            let [coarse, fine] = [50, 100].map(|steps| work_surplus(&reference, &end, steps, control));
            assert!(fine.abs() < 1e-4, "{control:?}: {coarse} {fine}");
            assert!((coarse / fine - 4.0).abs() < 0.8 || fine.abs() < 1e-7, "{control:?}: {coarse} {fine}");
        }
    }
}

/// M^{-½} K M^{-½} of the elastic element at rest, from the forces of small displacements.
fn operator(corners: &Corners, poisson_ratio: f64, control: HourglassControl) -> Mat<f64> {
    let material = Elastic::new(elasticity(poisson_ratio));
    let size = volume(corners).cbrt();
    let mass = row_sum_mass(corners, DENSITY);
    let small = 1e-7 * size;
    let columns: Vec<Vec<f64>> = (0..24)
        .map(|column| {
            let mut position = *corners;
            position[column / 3][column % 3] += small;
            let force = Hex::new(&material, control, *corners).move_to(position, TIME_STEP).internal_force;
            force.iter().flat_map(|force| force.0).map(|component| component / small).collect()
        })
        .collect();
    Mat::from_fn(24, 24, |row, column| {
        let stiffness = 0.5 * (columns[column][row] + columns[row][column]);
        stiffness / (mass[row / 3] * mass[column / 3]).sqrt()
    })
}

fn eigenvalues(corners: &Corners, poisson_ratio: f64, control: HourglassControl) -> Vec<f64> {
    operator(corners, poisson_ratio, control).self_adjoint_eigenvalues(Side::Lower).unwrap()
}

/// ω² that the stable time step stands for.
fn bound(corners: &Corners, poisson_ratio: f64, control: HourglassControl) -> f64 {
    let material = Elastic::new(elasticity(poisson_ratio));
    let update = Hex::new(&material, control, *corners).move_to(*corners, 0.0);
    (2.0 / update.stable_time_step).powi(2)
}

/// Stiffness leaves no other motion free; a viscosity resists the twelve hourglass motions only while they last.
#[test]
fn only_rigid_motions_are_free() {
    for shape in distorted_hexes(100, &mut Random::new(23)) {
        for control in [HourglassControl::Physical, HourglassControl::Stiffness { coefficient: 0.05 }] {
            let values = eigenvalues(&shape, 0.3, control);
            let zeros = values.iter().filter(|value| value.abs() < 1e-6 * values[23]).count();
            assert_eq!(zeros, 6, "{control:?}: {values:?}");
        }
    }
}

/// The least and the median share of the exact step that many shapes keep, to two digits, for ν of −½, 0, 0.3 and 0.4999.
const KEPT: [(HourglassControl, [[f64; 2]; 4]); 2] = [
    (HourglassControl::Physical, [[0.55, 0.79], [0.62, 0.90], [0.63, 0.88], [0.73, 0.95]]),
    (HourglassControl::Stiffness { coefficient: 0.05 }, [[0.71, 0.84], [0.74, 0.95], [0.74, 0.92], [0.74, 0.95]]),
];

#[test]
fn the_stable_step_is_bounded_on_any_shape_closely_on_most_and_exact_for_cubes() {
    let mut shapes = distorted_hexes(300, &mut Random::new(1));
    for sides in [[1.0, 1.0, 0.01], [1.0, 1.0, 100.0], [1.0, 0.1, 0.01], [1.0; 3]] {
        shapes.push(brick(sides));
        let taper = |x: [f64; 3]| if x[2] > 0.0 { [0.1 * x[0], 0.1 * x[1], x[2]] } else { x };
        shapes.push(brick(sides).map(taper));
    }
    for (control, kept) in KEPT {
        for (poisson_ratio, [least, median]) in [-0.5, 0.0, 0.3, 0.4999].into_iter().zip(kept) {
            let mut shares: Vec<f64> = shapes
                .iter()
                .map(|shape| {
                    let exact = *eigenvalues(shape, poisson_ratio, control).last().unwrap();
                    let bound = bound(shape, poisson_ratio, control);
                    assert!(bound >= exact * (1.0 - 1e-5), "{control:?}, nu = {poisson_ratio}: {bound} < {exact}");
                    (exact / bound).sqrt()
                })
                .collect();
            shares.sort_by(f64::total_cmp);
            let name = format!("{control:?}, nu = {poisson_ratio}");
            println!("{name}: least {:.3}, median {:.3} of the exact step", shares[0], shares[shares.len() / 2]);
            assert!((shares[0] - least).abs() < 0.006, "{name}: {} instead of {least}", shares[0]);
            assert!((shares[shares.len() / 2] - median).abs() < 0.006, "{name}: median");
            let cube = brick([1.0; 3]);
            let exact = *eigenvalues(&cube, poisson_ratio, control).last().unwrap();
            assert!((exact / bound(&cube, poisson_ratio, control) - 1.0).abs() < 1e-5, "{name}: cube");
        }
    }
}

/// Energy of a displacement field u(x, y, z) of a brick of 2 × 1.4 × 0.6 under the physical control.
fn energy_of(field: impl Fn([f64; 3]) -> [f64; 3]) -> f64 {
    let material = Elastic::new(elasticity(0.3));
    let corners = brick([2.0, 1.4, 0.6]);
    let small = 1e-6;
    let position = corners.map(|x| {
        let displacement = field(x);
        std::array::from_fn(|i| x[i] + small * displacement[i])
    });
    let update = Hex::new(&material, HourglassControl::Physical, corners).move_to(position, TIME_STEP);
    (update.internal_energy + update.hourglass_energy) / (small * small)
}

/// u_x = x z and u_y = y z bend a plate of thickness h = 0.6 in its plane, u = (y z, 0, 0) twists it: the element has the plate's
/// energy, ½ D (κ_x² + κ_y² + 2 ν κ_x κ_y) A and ½ G h³/12 κ² A, without the shear that corners of straight edges would have.
#[test]
fn bending_and_torsion_have_the_energy_of_a_plate() {
    let (young, poisson) = (common::YOUNG_MODULUS, 0.3);
    let (height, area) = (0.6_f64, 2.0 * 1.4);
    let plate = young * height.powi(3) / (12.0 * (1.0 - poisson * poisson));
    let shear = young / (2.0 * (1.0 + poisson));
    let close = |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-5, "{found} {expected}");
    close(energy_of(|[x, _, z]| [x * z, 0.0, 0.0]), 0.5 * plate * area);
    close(energy_of(|[_, y, z]| [0.0, 2.0 * y * z, 0.0]), 0.5 * plate * area * 4.0);
    close(energy_of(|[x, y, z]| [x * z, 2.0 * y * z, 0.0]), 0.5 * plate * area * (1.0 + 4.0 + 4.0 * poisson));
    // y z twists the planes normal to y and z
    let twist = |height: f64, area: f64| 0.5 * shear * height.powi(3) / 12.0 * area;
    close(energy_of(|[_, y, z]| [y * z, 0.0, 0.0]), twist(0.6, 2.0 * 1.4) + twist(1.4, 2.0 * 0.6));
    // η ζ u_x,ξ: a fibre along x in uniaxial stress
    let fibre = 0.5 * young * 2.0 * (1.4_f64.powi(3) / 12.0) * (0.6_f64.powi(3) / 12.0);
    close(energy_of(|[x, y, z]| [x * y * z, 0.0, 0.0]), fibre);
}

/// The bits of every number after some steps of several elements side by side.
struct AllBits<'a> {
    references: &'a [Corners],
    paths: &'a [Vec<Corners>],
    control: HourglassControl,
}

impl WithLanes for AllBits<'_> {
    type Output = Vec<Vec<u64>>;

    fn with_lanes<R: Real>(self) -> Vec<Vec<u64>> {
        let material = copper();
        let mut bits = vec![Vec::new(); self.references.len()];
        for first in (0..self.references.len()).step_by(R::LANES) {
            let packed = |corners: &dyn Fn(usize) -> Corners| -> CornerVectors<R> {
                std::array::from_fn(|a| {
                    Vector3(std::array::from_fn(|i| R::from_lanes(|lane| corners(first + lane)[a][i])))
                })
            };
            let mut driven = Driven::<_, _, R, 8>::new(self.control, &material);
            let bulk_viscosity = Some(BulkViscosity { linear: 0.06, quadratic: 1.2 });
            let step = ElementStep { bulk_viscosity, time_step: TIME_STEP };
            let reference = packed(&|element| self.references[element]);
            let corner_mass = R::from_lanes(|lane| smallest(&row_sum_mass(&self.references[first + lane], DENSITY)));
            let mut old = reference;
            for time in 0..self.paths[first].len() {
                let position = packed(&|element| self.paths[element][time]);
                let velocity = std::array::from_fn(|a| (position[a] - old[a]) * R::splat(1.0 / TIME_STEP));
                let motion = HexMotion { reference, position, velocity, corner_mass };
                let update = driven.advance(&motion, &step);
                old = position;
                let mut note = |number: R| {
                    for lane in 0..R::LANES {
                        bits[first + lane].push(number.lane(lane).to_bits());
                    }
                };
                update.internal_force.iter().flat_map(|force| force.0).for_each(&mut note);
                let others = [update.internal_energy, update.hourglass_energy, update.viscous_energy];
                others.into_iter().chain([update.min_jacobian, update.stable_time_step]).for_each(&mut note);
                driven.for_each(&mut note);
            }
        }
        bits
    }
}

#[test]
fn lanes_give_the_bits_of_f64() {
    let mut random = Random::new(13);
    let references = distorted_hexes(16, &mut random);
    let paths: Vec<Vec<Corners>> = references
        .iter()
        .enumerate()
        .map(|(element, reference)| {
            let size = [0.0, 1e-5, 1e-3, 1e-2][element % 4];
            let mut position = *reference;
            let turn = Rotation::about([1.0, 0.3, -2.0], 20.0 * size).to_tensor();
            let mut next = || {
                position = mapped(&perturbed(&position, 0.1 * size, &mut random), &turn);
                position
            };
            (0..5).map(|_| next()).collect()
        })
        .collect();
    for control in CONTROLS {
        let all = |level| dispatch(level, AllBits { references: &references, paths: &paths, control });
        let scalar = all(LaneLevel::Portable);
        for level in LaneLevel::ALL.into_iter().filter(|level| level.is_available()) {
            assert_eq!(all(level), scalar, "{control:?}, {}", level.name());
        }
    }
}

/// A point that flows returns the hourglass stress with its own: it fades by σ/(σ + 3μ Δε̄ᵖ) a step, and is full again when the
/// flow ends.
#[test]
fn hourglass_stress_returns_with_the_point() {
    let material = copper();
    let corners = brick([1.0; 3]);
    let mut hex = Hex::new(&material, HourglassControl::Physical, corners);
    let bent = corners.map(|[x, y, z]| [x + 1e-4 * x * z, y, z]);
    hex.move_to(bent, TIME_STEP);
    let size = |hex: &Hex<_>| hex.driven.history.own.0.iter().map(|force| force.dot(*force)).sum::<f64>().sqrt();
    let before = size(&hex);
    let strain =
        |hex: &Hex<EStar<(), IsotropicHardening>>| material.equivalent_plastic_strain(&hex.driven.points.states()[0]);
    let mut expected = before;
    for step in 1..=20 {
        let stretch = 1.0 + 1e-3 * f64::from(step);
        let old = strain(&hex);
        hex.move_to(bent.map(|[x, y, z]| [x, y, stretch * z]), TIME_STEP);
        let stress: SymmetricTensor<f64> =
            material.cauchy_stress(&hex.driven.points.states()[0], hex.driven.points.rotations()[0]);
        let equivalent = (1.5 * stress.deviator().norm_squared()).sqrt();
        let shear = material.elasticity().shear_modulus();
        expected *= equivalent / (equivalent + 3.0 * shear * (strain(&hex) - old));
    }
    assert!(expected < 0.1 * before);
    // the bend is stretched with the body, which adds a little
    assert!((size(&hex) - expected).abs() < 0.02 * before, "{} {expected}", size(&hex));
}
