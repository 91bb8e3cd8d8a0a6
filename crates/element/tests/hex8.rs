//! Goal: what one hex does is what its shape functions say, for both formulations and on distorted shapes.
//!
//! Mesh: one element. Loading: straight motions of its corners over one or several steps. Source: closed forms with this
//! file's own quadrature, and the material-point driver.

mod common;

use common::{
    Corners, DENSITY, Driven, FORMULATIONS, Hex, Random, distorted_hexes, elasticity, mapped, perturbed, quadrature,
    row_sum_mass, smallest, vectors,
};
use estar_element::bulk_viscosity::BulkViscosity;
use estar_element::element::ElementStep;
use estar_element::hex8::{CornerVectors, Formulation, HexMotion, lumped_mass};
use estar_material::point::MaterialPoint;
use estar_material::{EStar, Elastic, IsotropicHardening, Material};
use estar_tensor::{LaneLevel, Real, Rotation, SymmetricTensor, Tensor, Vector3, WithLanes, dispatch};

const TIME_STEP: f64 = 1e-7;

const STEP: ElementStep = ElementStep { bulk_viscosity: None, time_step: TIME_STEP };

fn elastic() -> Elastic {
    Elastic::new(elasticity(0.35))
}

/// Copper of the Taylor bar: it yields at a strain of 0.3 %.
fn copper() -> EStar<(), IsotropicHardening> {
    EStar::new(elasticity(0.35), IsotropicHardening::linear(400e6, 100e6).unwrap(), ())
}

/// Hexes and homogeneous deformations F of up to 20 %, with rotation.
fn cases() -> Vec<(Corners, Tensor<f64>)> {
    let mut random = Random::new(7);
    let shapes = distorted_hexes(20, &mut random);
    shapes.into_iter().map(|shape| (shape, Tensor::identity() + random.tensor(0.2))).collect()
}

/// Greatest component of a difference of corner vectors.
fn distance(a: &CornerVectors<f64>, b: &CornerVectors<f64>) -> f64 {
    let differences = a.iter().zip(b).flat_map(|(a, b)| (*a - *b).0);
    differences.fold(0.0, |greatest, difference| greatest.max(difference.abs()))
}

fn greatest(vectors: &CornerVectors<f64>) -> f64 {
    distance(vectors, &[Vector3::zero(); 8])
}

/// f_a = Σ_q T ∇N_a j for one stress at all points.
fn uniform_stress_force(position: &Corners, stress: &SymmetricTensor<f64>) -> CornerVectors<f64> {
    let points = quadrature(position);
    std::array::from_fn(|a| {
        points.iter().fold(Vector3::zero(), |sum, point| {
            stress.to_tensor().apply(Vector3(point.gradient[a])).mul_add(point.volume, sum)
        })
    })
}

fn assert_homogeneous_motion_is_uniform<M: Material>(material: &M) {
    for (reference, deformation) in cases() {
        let mut point = MaterialPoint::new(material);
        let mut hexes = FORMULATIONS.map(|formulation| Hex::new(formulation, material));
        let mut old = reference;
        for part in [0.25, 0.5, 0.75, 1.0] {
            let gradient = Tensor::identity() * (1.0 - part) + deformation * part;
            let new = mapped(&reference, &gradient);
            point.advance(&gradient, TIME_STEP);
            let stress = *point.stress();
            let size = stress.norm_squared().sqrt();
            let force = uniform_stress_force(&new, &stress);
            let volume: f64 = quadrature(&reference).iter().map(|point| point.volume).sum();
            for (hex, formulation) in hexes.iter_mut().zip(FORMULATIONS) {
                let update = hex.moved(&reference, [&old, &new], &STEP);
                for of_point in hex.stresses() {
                    let difference = of_point - stress;
                    assert!(difference.norm_squared().sqrt() < 1e-10 * size, "{formulation:?}: {difference:?}");
                }
                assert!(distance(&update.internal_force, &force) < 1e-10 * greatest(&force), "{formulation:?}");
                let jacobian = gradient.determinant();
                assert!((update.min_jacobian - jacobian).abs() < 1e-12, "{formulation:?}");
                if part == 1.0 {
                    // the last step's share of the energy of the point
                    let mut before = MaterialPoint::new(material);
                    for part in [0.25, 0.5, 0.75] {
                        before.advance(&(Tensor::identity() * (1.0 - part) + deformation * part), TIME_STEP);
                    }
                    let energy = volume * (point.internal_energy() - before.internal_energy());
                    assert!((update.internal_energy - energy).abs() < 1e-10 * energy.abs(), "{formulation:?}");
                    let dissipation = volume * (point.plastic_dissipation() - before.plastic_dissipation());
                    let difference = (update.plastic_dissipation - dissipation).abs();
                    assert!(difference <= 1e-10 * energy.abs(), "{formulation:?}");
                }
            }
            old = new;
        }
    }
}

/// F-bar and full integration are the same here, on the distorted shape as on a parallelepiped: J is everywhere that of
/// the centre.
#[test]
fn homogeneous_motion_gives_the_stress_of_the_point_everywhere_and_its_closed_form_forces() {
    assert_homogeneous_motion_is_uniform(&elastic());
    assert_homogeneous_motion_is_uniform(&copper());
}

#[test]
fn a_rigid_turn_of_150_degrees_in_one_step_turns_stress_and_forces_and_does_no_work() {
    let material = copper();
    let turn = Rotation::about([1.0, 2.0, -0.5], 150_f64.to_radians()).to_tensor();
    for (reference, deformation) in cases() {
        for formulation in FORMULATIONS {
            // without stress there is no force
            let mut hex = Hex::new(formulation, &material);
            let turned = mapped(&reference, &turn);
            let update = hex.moved(&reference, [&reference, &turned], &STEP);
            let stiffness = 1e11 * quadrature(&reference).iter().map(|point| point.volume).sum::<f64>().cbrt().powi(2);
            assert!(greatest(&update.internal_force) < 1e-13 * stiffness, "{:?}", update.internal_force);
            // stress of a motion that is not uniform goes with the body
            let mut hex = Hex::new(formulation, &material);
            let bent = perturbed(&mapped(&reference, &deformation), 1e-3, &mut Random::new(3));
            let before = hex.moved(&reference, [&reference, &bent], &STEP);
            let states = hex.points.states();
            let turned = mapped(&bent, &turn);
            let after = hex.moved(&reference, [&bent, &turned], &STEP);
            let expected = before.internal_force.map(|force| turn.apply(force));
            assert!(distance(&after.internal_force, &expected) < 1e-11 * greatest(&expected));
            for (old, new) in states.iter().zip(hex.points.states()) {
                let difference = old.rotated_stress - new.rotated_stress;
                assert!(difference.norm_squared() < 1e-22 * old.rotated_stress.norm_squared());
            }
            assert!(after.internal_energy.abs() < 1e-12 * before.internal_energy);
        }
    }
}

/// Forces of any motion, with plastic flow and bulk viscosity: stress is symmetric and points carry no moment.
#[test]
fn forces_and_their_moments_balance_in_any_motion() {
    let material = copper();
    let mut random = Random::new(11);
    for reference in distorted_hexes(50, &mut random) {
        let size = quadrature(&reference).iter().map(|point| point.volume).sum::<f64>().cbrt();
        for formulation in FORMULATIONS {
            let mut hex = Hex::new(formulation, &material);
            let mut old = reference;
            for _ in 0..3 {
                let new = perturbed(&old, 5e-3 * size, &mut random);
                let bulk_viscosity = Some(BulkViscosity { linear: 0.06, quadratic: 1.2 });
                let step = ElementStep { bulk_viscosity, ..STEP };
                let update = hex.moved(&reference, [&old, &new], &step);
                old = new;
                let force = &update.internal_force;
                let sum = force.iter().fold(Vector3::zero(), |sum, force| sum + *force);
                let moment = force.iter().zip(vectors(&new)).fold(Vector3::zero(), |sum, (f, x)| sum + x.cross(*f));
                let scale = greatest(force);
                assert!(sum.dot(sum).sqrt() < 1e-12 * scale, "{formulation:?}: {sum:?} of {scale}");
                assert!(moment.dot(moment).sqrt() < 1e-11 * scale, "{formulation:?}: {moment:?} of {scale}");
            }
        }
    }
}

#[test]
fn lumped_mass_is_the_row_sum_and_all_of_the_mass() {
    for reference in distorted_hexes(100, &mut Random::new(5)) {
        let mass = lumped_mass(&vectors(&reference), DENSITY);
        let expected = row_sum_mass(&reference, DENSITY);
        let total = DENSITY * quadrature(&reference).iter().map(|point| point.volume).sum::<f64>();
        assert!((mass.iter().sum::<f64>() - total).abs() < 1e-13 * total);
        for (mass, expected) in mass.iter().zip(expected) {
            assert!((mass - expected).abs() < 1e-13 * total);
        }
    }
}

/// Work of the corner forces, ½ (f_n + f_{n+1}) · Δx, over a straight motion to `end`, less the stress power at the points, as
/// a fraction of that.
fn work_surplus(reference: &Corners, end: &Corners, steps: u32, formulation: Formulation) -> f64 {
    let material = elastic();
    let mut hex = Hex::new(formulation, &material);
    let mut old = *reference;
    let mut force_old = [Vector3::zero(); 8];
    let (mut work, mut energy) = (0.0, 0.0);
    for part in (1..=steps).map(|step| f64::from(step) / f64::from(steps)) {
        let new = std::array::from_fn(|a| std::array::from_fn(|i| reference[a][i] * (1.0 - part) + end[a][i] * part));
        let update = hex.moved(reference, [&old, &new], &STEP);
        for a in 0..8 {
            let mean = (force_old[a] + update.internal_force[a]) * 0.5;
            work += mean.dot(Vector3(new[a]) - Vector3(old[a]));
        }
        energy += update.internal_energy;
        force_old = update.internal_force;
        old = new;
    }
    (work - energy) / energy
}

#[test]
fn internal_energy_is_the_work_of_the_forces_to_second_order() {
    for (reference, deformation) in cases() {
        for formulation in FORMULATIONS {
            let end = mapped(&reference, &deformation);
            let [coarse, fine] = [20, 40].map(|steps| work_surplus(&reference, &end, steps, formulation));
            assert!(coarse.abs() < 3e-3, "{coarse}");
            let ratio = coarse / fine;
            assert!((ratio - 4.0).abs() < 0.3, "{coarse} {fine} {ratio}");
        }
    }
}

/// The stress power of F-bar is that of the volume change at the centre, the power of its forces is not: on a shape or in a
/// motion that is not uniform a difference remains. B-bar has none.
#[test]
fn in_motions_that_are_not_uniform_the_forces_of_f_bar_alone_do_other_work_than_the_stress() {
    let mut random = Random::new(17);
    let mut worst = FORMULATIONS.map(|_| 0.0_f64);
    for (reference, deformation) in cases() {
        let size = quadrature(&reference).iter().map(|point| point.volume).sum::<f64>().cbrt();
        let end = perturbed(&mapped(&reference, &deformation), 0.05 * size, &mut random);
        for (worst, formulation) in worst.iter_mut().zip(FORMULATIONS) {
            *worst = worst.max(work_surplus(&reference, &end, 400, formulation).abs());
        }
    }
    println!("largest differences: {FORMULATIONS:?} {worst:?}");
    let [full, f_bar, b_bar] = worst;
    assert!(full < 1e-4 && b_bar < 1e-4 && f_bar > 1e-2, "{worst:?}");
}

/// A pure bend u_x = x z of a brick a long and h high has a shear γ_xz = x that a plate does not have. Energy over that of the plate,
/// ½ E h²/(12 (1 − ν²)) V: (1 − ν²)/E ((λ + 2μ) + μ (a/h)²) with full integration; F-bar and B-bar change the volumetric part only,
/// which vanishes in their mean, (1 − ν²)/E (4/3 μ + μ (a/h)²).
#[test]
fn a_bend_is_too_stiff_in_long_elements_whatever_the_volumetric_part() {
    let elasticity = elasticity(0.3);
    let material = Elastic::new(elasticity);
    let (shear, bulk) = (elasticity.shear_modulus(), elasticity.bulk_modulus());
    let plate_modulus = common::YOUNG_MODULUS / (1.0 - 0.3 * 0.3);
    for formulation in FORMULATIONS {
        for ratio in [1.0, 2.0, 4.0] {
            let corners = common::brick([ratio, 0.7, 1.0]);
            let bent = corners.map(|[x, y, z]| [x + 1e-6 * x * z, y, z]);
            let mut hex = Hex::new(formulation, &material);
            let update = hex.moved(&corners, [&corners, &bent], &STEP);
            let plate = 0.5e-12 * plate_modulus / 12.0 * 0.7 * ratio;
            let of_fibres = if formulation == Formulation::Full { bulk + 4.0 / 3.0 * shear } else { 4.0 / 3.0 * shear };
            let expected = (of_fibres + shear * ratio * ratio) / plate_modulus;
            let found = update.internal_energy / plate;
            println!("{formulation:?}, a/h = {ratio}: {found:.3} of the plate's energy");
            assert!((found / expected - 1.0).abs() < 1e-4, "{formulation:?}: {found} {expected}");
        }
    }
}

/// The bits of every number after some steps of several elements, side by side as far as the lanes go.
struct AllBits<'a> {
    references: &'a [Corners],
    /// Positions after each step.
    paths: &'a [Vec<Corners>],
    formulation: Formulation,
    step: ElementStep,
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
            let mut hex = Driven::<_, _, R, 8>::new(self.formulation, &material);
            let reference = packed(&|element| self.references[element]);
            let corner_mass = R::from_lanes(|lane| smallest(&row_sum_mass(&self.references[first + lane], DENSITY)));
            let mut old = reference;
            for time in 0..self.paths[first].len() {
                let position = packed(&|element| self.paths[element][time]);
                let velocity = std::array::from_fn(|a| (position[a] - old[a]) * R::splat(1.0 / self.step.time_step));
                let motion = HexMotion { reference, position, velocity, corner_mass };
                let update = hex.advance(&motion, &self.step);
                old = position;
                let mut note = |number: R| {
                    for lane in 0..R::LANES {
                        bits[first + lane].push(number.lane(lane).to_bits());
                    }
                };
                update.internal_force.iter().flat_map(|force| force.0).for_each(&mut note);
                for number in [
                    update.internal_energy,
                    update.plastic_dissipation,
                    update.viscous_energy,
                    update.min_jacobian,
                    update.stable_time_step,
                ] {
                    note(number);
                }
                hex.for_each(&mut note);
            }
        }
        bits
    }
}

/// Lanes that yield stand beside lanes that do not, and lanes that turn far beside lanes at rest.
#[test]
fn lanes_give_the_bits_of_f64() {
    let mut random = Random::new(13);
    let references = distorted_hexes(16, &mut random);
    let paths: Vec<Vec<Corners>> = references
        .iter()
        .enumerate()
        .map(|(element, reference)| {
            let mut position = *reference;
            let size = [0.0, 1e-5, 1e-3, 1e-2][element % 4];
            (0..5)
                .map(|_| {
                    let turn = Rotation::about([1.0, 0.3, -2.0], 20.0 * size).to_tensor();
                    position = mapped(&perturbed(&position, 0.1 * size, &mut random), &turn);
                    position
                })
                .collect()
        })
        .collect();
    for formulation in FORMULATIONS {
        for bulk_viscosity in [None, Some(BulkViscosity { linear: 0.06, quadratic: 1.2 })] {
            let step = ElementStep { bulk_viscosity, ..STEP };
            let all = |level| dispatch(level, AllBits { references: &references, paths: &paths, formulation, step });
            let scalar = all(LaneLevel::Portable);
            for level in LaneLevel::ALL {
                if level.is_available() {
                    assert!(all(level) == scalar, "{level:?} {formulation:?}");
                } else {
                    eprintln!("{level:?} is not available on this machine: not compared");
                }
            }
        }
    }
}
