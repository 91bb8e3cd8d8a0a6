//! Goal: waves run at their speed with their stress.
//!
//! Mesh: a column of cubes. Loading: it meets a rigid wall. Source: one-dimensional wave theory (Kolsky 1953).

mod common;

use common::{
    DIRECTIONS, ELEMENTS, all_nodes, assert_close, bricks, cut_bricks, elasticity, new, run, stresses, translation,
    until, whole,
};
use estar_material::{EStarTotal, Elastic, IsotropicHardening, KinematicHardening, MaterialModel};
use estar_mesh::Shape;
use estar_solver::Model;
use estar_solver::model::{BulkViscosity, Fix, Formulation, RigidWall, TimeSettings};

const WALL: RigidWall = RigidWall::plane([0.0; 3], [1.0, 0.0, 0.0], 0.0);

/// An elastic rod with ν = 0 flies on a wall: behind the front the stress is −ρ c v and the rod is at rest, the foot
/// leaves the wall at 2L/c, and the rod flies back with the velocity it came with.
#[test]
fn an_elastic_rod_rebounds_after_twice_its_length() {
    let (density, young_modulus, speed) = (8000.0_f64, 200e9, 2.0);
    let wave_speed = (young_modulus / density).sqrt();
    let count = 200;
    let length = 0.2;
    let side = length / f64::from(count);
    for (formulation, shape) in ELEMENTS {
        let mesh = cut_bricks([length, side, side], [count, 1, 1], shape);
        let foot = &mesh.group("x_min").unwrap().nodes;
        let pieces = mesh.element_count() / count as usize;
        let model = Model {
            parts: whole(&mesh, Elastic::new(elasticity(density, young_modulus, 0.0)).into(), formulation),
            initial_velocities: vec![translation(&mesh, [-speed, 0.0, 0.0])],
            walls: vec![WALL],
            settings: until(2.5 * length / wave_speed),
            ..Model::default()
        };
        let mut simulation = new(&mesh, model);
        let (mut stress, mut velocity, mut leaves) = (None, 0.0, None);
        run(&mut simulation, |now| {
            if stress.is_none() && now.time() >= 0.7 * length / wave_speed {
                // half of what lies behind the front, away from its ringing
                let behind = &stresses(now)[20 * pieces..80 * pieces];
                stress = Some(behind.iter().map(|stress| stress[0]).sum::<f64>() / behind.len() as f64);
                velocity = (20..80).map(|node| now.velocity(node)[0]).sum::<f64>() / 60.0;
            }
            let lift = foot.iter().map(|&node| now.displacement()[node as usize][0]).sum::<f64>() / foot.len() as f64;
            if leaves.is_none() && lift > 0.05 * side * speed / wave_speed {
                leaves = Some(now.time());
            }
        });
        let stress = stress.unwrap() / (density * wave_speed * speed);
        let contact = leaves.unwrap() * wave_speed / (2.0 * length);
        let back = simulation.momentum()[0] / (density * length * side * side * speed);
        println!("rod, {formulation:?} {shape}: stress {stress}, velocity {velocity}, contact {contact}, back {back}");
        assert_close(stress, -1.0, 0.005);
        assert_close(velocity, 0.0, 0.005 * speed);
        assert_close(contact, 1.0, 0.01);
        assert_close(back, 1.0, if shape == Shape::Tet4 { 0.015 } else { 0.01 });
        assert!(simulation.energies().error().abs() < 1e-3, "{:?}", simulation.energies());
    }
}

/// A column that cannot widen flies on a wall so fast that it yields: an elastic precursor with the stress
/// σ_y (1 − ν)/(1 − 2ν) runs ahead of a plastic wave with the speed √((k + 4μ/3 · H/(3μ + H))/ρ).
///
/// Source: Wood (1952), plane waves in solids that harden linearly.
#[test]
fn a_yielding_column_sends_a_precursor_and_a_slower_plastic_wave() {
    let (yield_stress, modulus) = (100e6, 20e9);
    let elasticity = elasticity(8000.0, 200e9, 0.3);
    let (shear, bulk, density) = (elasticity.shear_modulus(), elasticity.bulk_modulus(), elasticity.density());
    let precursor = yield_stress * 0.7 / 0.4;
    let elastic_speed = (elasticity.p_wave_modulus() / density).sqrt();
    let plastic_modulus = bulk + 4.0 / 3.0 * shear * modulus / (3.0 * shear + modulus);
    let plastic_speed = (plastic_modulus / density).sqrt();
    // the wall stops the column: v = σ_p/(ρ c_e) + (σ − σ_p)/(ρ c_p), with twice the precursor behind
    let speed = precursor / (density * elastic_speed) + precursor / (density * plastic_speed);
    let count = 400;
    let length = 0.4;
    let side = length / f64::from(count);
    let mesh = bricks([length, side, side], [count, 1, 1]);
    let hardening = IsotropicHardening::linear(yield_stress, modulus).unwrap();
    let materials = [
        MaterialModel::e_star_box_rate(elasticity, hardening.clone(), KinematicHardening::NONE),
        EStarTotal::new(elasticity, hardening).into(),
    ];
    for material in materials {
        let model = Model {
            parts: whole(&mesh, material, Formulation::FBar),
            fixes: vec![Fix { nodes: all_nodes(&mesh), directions: DIRECTIONS[1..].to_vec() }],
            initial_velocities: vec![translation(&mesh, [-speed, 0.0, 0.0])],
            walls: vec![WALL],
            settings: TimeSettings {
                bulk_viscosity: Some(BulkViscosity { linear: 0.06, quadratic: 1.2 }),
                ..until(0.9 * length / elastic_speed)
            },
            ..Model::default()
        };
        let mut simulation = new(&mesh, model);
        // the place where the stress passes `level`, counted from the wall in the reference configuration
        let front = |stress: &[f64], level: f64| {
            let last = stress.iter().rposition(|&stress| stress > level).unwrap();
            let within = (stress[last] - level) / (stress[last] - stress[last + 1]);
            (last as f64 + 0.5 + within) * side
        };
        let mut snapshots = Vec::new();
        let times = [0.45, 0.85].map(|share| share * length / elastic_speed);
        run(&mut simulation, |now| {
            if snapshots.len() < 2 && now.time() >= times[snapshots.len()] {
                let stress: Vec<f64> = stresses(now).iter().map(|stress| -stress[0]).collect();
                snapshots.push((now.time(), stress));
            }
        });
        let measured = |level: f64| {
            let [(early, before), (late, after)] = &snapshots[..] else { panic!("two snapshots") };
            (front(after, level) - front(before, level)) / (late - early)
        };
        let (elastic, plastic) = (measured(0.5 * precursor), measured(1.5 * precursor));
        let (time, stress) = &snapshots[1];
        let mean = |from: f64, to: f64| {
            let cells = &stress[(from * time / side) as usize..(to * time / side) as usize];
            cells.iter().sum::<f64>() / cells.len() as f64
        };
        let plateau = mean(plastic_speed + 0.3 * (elastic_speed - plastic_speed), 0.97 * elastic_speed);
        let behind = mean(0.3 * plastic_speed, 0.8 * plastic_speed);
        println!(
            "column: speeds {} {}, precursor {}, behind {}",
            elastic / elastic_speed,
            plastic / plastic_speed,
            plateau / precursor,
            behind / precursor
        );
        assert_close(elastic / elastic_speed, 1.0, 0.01);
        assert_close(plastic / plastic_speed, 1.0, 0.01);
        assert_close(plateau / precursor, 1.0, 0.01);
        assert_close(behind / precursor, 2.0, 0.02);
        assert!(simulation.energies().error().abs() < 1e-3, "{:?}", simulation.energies());
    }
}
