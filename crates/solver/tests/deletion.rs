//! Goal: an element that turns inside out can be deleted: it has no force any more, its mass stays, and every joule that it
//! had taken is in the ledger; the bits are the same for any number of threads and lanes, and from any step on.
//!
//! Mesh: a block of 324 bricks that hits a wall so fast that it breaks up. Source: conservation.

mod common;

use common::{bricks, elastic, faces, load, translation, until, whole, yielding};
use estar_mesh::Mesh;
use estar_solver::model::{Formulation, LoadKind, OnInversion, Part, RigidWall, TimeSettings};
use estar_solver::{Curve, LaneLevel, Model, Simulation, SimulationError};

const CELLS: [u32; 3] = [6, 6, 9];

fn block() -> Mesh {
    bricks([4e-3, 4e-3, 6e-3], CELLS)
}

/// A block of metal whose top is elastic, thrown on a rough wall.
fn wreck(mesh: &Mesh, speed: f64, end: f64) -> Model {
    let soft = mesh.element_count() as u32 - 70;
    let part = |hexes: std::ops::Range<u32>, material| Part {
        elements: hexes.collect(),
        material,
        element: Formulation::FBar,
    };
    Model {
        parts: vec![part(0..soft, yielding(300e6, 1e8)), part(soft..mesh.element_count() as u32, elastic())],
        initial_velocities: vec![translation(mesh, [0.0, 0.0, -speed])],
        walls: vec![RigidWall::plane([0.0; 3], [0.0, 0.0, 1.0], 0.2)],
        settings: TimeSettings { on_inversion: OnInversion::Delete, ..until(end) },
        ..Model::default()
    }
}

fn pooled<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
}

#[test]
fn a_body_that_breaks_up_keeps_its_mass_and_its_ledger() {
    let mesh = block();
    let mut simulation = Simulation::new(&mesh, wreck(&mesh, 500.0, 10e-6), LaneLevel::best()).unwrap();
    let mass: f64 = simulation.mass().iter().sum();
    let (mut worst, mut worst_jump, mut deleted_before) = (0.0_f64, 0.0_f64, 0);
    while !simulation.is_finished() {
        let before = simulation.energies().clone();
        simulation.advance().unwrap();
        let now = simulation.energies();
        worst = worst.max(now.error().abs());
        if simulation.deleted_count() > deleted_before {
            // what is booked comes out of the internal energy
            assert!(now.deleted > before.deleted && now.internal < before.internal);
            worst_jump = worst_jump.max((now.error() - before.error()).abs());
        } else {
            assert_eq!(now.deleted, before.deleted);
        }
        deleted_before = simulation.deleted_count();
    }
    let energies = simulation.energies();
    println!(
        "{} of {} deleted, {:.4} of the energy with them, balance {worst:e}, by a deletion {worst_jump:e}",
        simulation.deleted_count(),
        mesh.element_count(),
        energies.deleted / energies.initial_kinetic
    );
    assert!(simulation.deleted_count() > 20 && energies.deleted > 0.05 * energies.initial_kinetic);
    let deleted = simulation.deleted();
    assert_eq!(deleted.iter().filter(|deleted| **deleted).count() as u64, simulation.deleted_count());
    assert_eq!(simulation.mass().iter().sum::<f64>(), mass);
    // what a deletion leaves open is half the work of the element's last step
    assert!(worst < 5e-3 && worst_jump < 1e-6, "{worst:e} {worst_jump:e}");
    assert!(simulation.extremes().min_jacobian > 0.0);
    for (value, hex) in simulation.min_jacobians() {
        assert!(value > 0.0 && !deleted[hex as usize], "{value} {hex}");
    }
}

#[test]
fn deletion_has_the_same_bits_for_any_threads_and_lanes_and_from_any_step_on() {
    let mesh = block();
    let bits = |simulation: &Simulation| {
        let mut bits = Vec::new();
        simulation.for_each_number(|number| bits.push(number.to_bits()));
        bits
    };
    let end = 6e-6;
    let straight = |level, threads, stop: u64| {
        pooled(threads, || {
            let mut simulation = Simulation::new(&mesh, wreck(&mesh, 700.0, end), level).unwrap();
            while !simulation.is_finished() && simulation.step() < stop {
                simulation.advance().unwrap();
            }
            assert!(simulation.deleted_count() > 0);
            (bits(&simulation), simulation.step())
        })
    };
    let (expected, steps) = straight(LaneLevel::Portable, 1, u64::MAX);
    for (level, threads) in [(LaneLevel::best(), 2), (LaneLevel::best(), 5), (LaneLevel::Avx2, 3)] {
        if level.is_available() {
            assert!(straight(level, threads, u64::MAX).0 == expected, "{level:?}, {threads} threads");
        }
    }
    let (middle, _) = straight(LaneLevel::best(), 1, steps - steps / 8);
    let resumed = pooled(3, || {
        let mut simulation = Simulation::new(&mesh, wreck(&mesh, 700.0, end), LaneLevel::best()).unwrap();
        let mut numbers = middle.iter().map(|bits| f64::from_bits(*bits));
        simulation.restore(|| numbers.next().unwrap()).unwrap();
        assert!(numbers.next().is_none());
        while !simulation.is_finished() {
            simulation.advance().unwrap();
        }
        bits(&simulation)
    });
    assert!(resumed == expected);
}

#[test]
fn a_body_of_which_nothing_is_left_flies_on() {
    let mesh = block();
    let model = wreck(&mesh, 4000.0, 10e-6);
    let model = Model {
        parts: whole(&mesh, yielding(300e6, 1e8), Formulation::FBar),
        settings: TimeSettings { energy_error_limit: 1.0, ..model.settings },
        ..model
    };
    let mut simulation = Simulation::new(&mesh, model, LaneLevel::best()).unwrap();
    while !simulation.is_finished() {
        simulation.advance().unwrap();
    }
    assert_eq!(simulation.deleted_count(), mesh.element_count() as u64);
    let mut finite = true;
    simulation.for_each_number(|number| finite &= !number.is_nan());
    assert!(finite && simulation.energies().error().abs() < 0.1, "{:?}", simulation.energies());
    assert!(simulation.momentum()[2].is_finite());
}

/// Deletion costs no bit where nothing inverts, and loads on the faces of deleted elements go on.
#[test]
fn nothing_changes_for_a_body_that_stays_whole() {
    let mesh = block();
    let faces = faces(&mesh, "z_max");
    let model = Model {
        loads: vec![load("pressure", LoadKind::Pressure { faces, curve: Curve::constant(1e8) })],
        ..wreck(&mesh, 100.0, 3e-6)
    };
    let place = |on_inversion| {
        let settings = TimeSettings { on_inversion, ..model.settings };
        let mut simulation = Simulation::new(&mesh, Model { settings, ..model.clone() }, LaneLevel::best()).unwrap();
        while !simulation.is_finished() {
            simulation.advance().unwrap();
        }
        (simulation.displacement().to_vec(), simulation.energies().clone())
    };
    assert_eq!(place(OnInversion::Stop), place(OnInversion::Delete));
}

#[test]
fn limits_on_steps_end_the_run() {
    let mesh = block();
    let ends = |settings: TimeSettings| {
        let model = Model { settings, ..wreck(&mesh, 500.0, 10e-6) };
        let mut simulation = Simulation::new(&mesh, model, LaneLevel::best()).unwrap();
        let first = simulation.time_step();
        loop {
            if let Err(error) = simulation.advance() {
                break (error, first, simulation.step());
            }
        }
    };
    let settings = TimeSettings { on_inversion: OnInversion::Delete, ..until(10e-6) };
    let (error, first, step) = ends(TimeSettings { max_steps: Some(7), ..settings });
    assert!(matches!(error, SimulationError::StepLimit { step: 7, .. }) && step == 7, "{error}");
    let (error, ..) =
        ends(TimeSettings { min_time_step: Some(0.5 * first), on_inversion: OnInversion::Stop, ..settings });
    match error {
        SimulationError::TimeStepTooSmall { time_step, limit, step, .. } => {
            assert!(time_step < limit && limit == 0.5 * first && step > 7, "{error}");
        }
        other => panic!("{other}"),
    }
    // a step that only has to meet the end is none too small
    let meets_the_end =
        TimeSettings { max_steps: Some(1), min_time_step: Some(0.9 * first), end: 0.1 * first, ..settings };
    let mut simulation =
        Simulation::new(&mesh, Model { settings: meets_the_end, ..wreck(&mesh, 1.0, 1.0) }, LaneLevel::best()).unwrap();
    simulation.advance().unwrap();
    assert!(simulation.is_finished());
}
