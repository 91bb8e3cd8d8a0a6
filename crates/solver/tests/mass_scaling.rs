//! Mass scaling and damping in proportion to mass.
//!
//! Goal: the run takes the step that was asked for, the mass that it costs is told and bounded, and the ledger knows its energy.
//! Mesh: bricks, one layer of them thin. Source: Δt ∝ √m; v̇ = −α v.

mod common;

use common::{
    ELEMENTS, assert_close, bricks, cut_bricks, elastic, load, moved, new, nodes, run, translation, until, whole,
    yielding,
};
use estar_mesh::{Mesh, Shape};
use estar_solver::model::{BulkViscosity, Direction, Fix, Formulation, LoadKind, MassScaling, RigidWall, TimeSettings};
use estar_solver::{LaneLevel, Model, ModelError, Simulation, SimulationError};

const NO_LIMIT: MassScaling =
    MassScaling { factor: 1.0, target_time_step: 0.0, limit: f64::MAX, kinetic_limit: f64::MAX };

/// A block whose lowest layer is a tenth as high as the others.
fn layered(shape: Shape) -> Mesh {
    let mesh = cut_bricks([4e-3, 4e-3, 8e-3], [4, 4, 8], shape);
    let squeezed = |z: f64| if z > 1e-3 { z - 0.9e-3 } else { 0.1 * z };
    moved(&mesh, mesh.coordinates().iter().map(|&[x, y, z]| [x, y, squeezed(z)]).collect())
}

fn still(mesh: &Mesh, element: Formulation, settings: TimeSettings) -> Result<Simulation, ModelError> {
    let model = Model { parts: whole(mesh, elastic(), element), settings, ..Model::default() };
    Simulation::new(mesh, model, LaneLevel::best())
}

fn scaled(scaling: MassScaling) -> TimeSettings {
    TimeSettings { mass_scaling: Some(scaling), ..until(1e-3) }
}

/// With and without bulk viscosity, which shortens the step.
#[test]
fn the_run_takes_the_step_that_was_asked_for_in_every_element() {
    for (element, shape) in ELEMENTS {
        let mesh = layered(shape);
        for bulk_viscosity in [None, Some(BulkViscosity { linear: 0.06, quadratic: 1.2 })] {
            let unscaled = still(&mesh, element, TimeSettings { bulk_viscosity, ..until(1e-3) }).unwrap();
            let target_time_step = 4.0 * unscaled.time_step();
            let settings = scaled(MassScaling { target_time_step, ..NO_LIMIT });
            let simulation = still(&mesh, element, TimeSettings { bulk_viscosity, ..settings }).unwrap();
            // the viscous hourglass control damps heavier elements less: they get a longer step than asked for
            let reached = simulation.time_step() / target_time_step;
            let most = if matches!(element, Formulation::OnePoint(_)) { 1.1 } else { 1.0 + 1e-9 };
            assert!(reached > 1.0 - 1e-9 && reached < most, "{element:?}, {shape:?}: {reached}");
            let (before, after): (f64, f64) = (unscaled.mass().iter().sum(), simulation.mass().iter().sum());
            let [added] = simulation.added_mass() else { panic!("one part") };
            assert_close(after - before, *added, 1e-9 * before);
            // the thin layer has a seventy-first of the mass and gets 15 times that at most; elements with a loose bound above it
            // are made heavier, too
            let most = if shape == Shape::Hex8 { 15.001 / 71.0 } else { 1.0 };
            assert!(*added > 0.0 && *added <= most * before, "{element:?}, {shape:?}: {added} of {before}");
        }
    }
}

#[test]
fn a_target_that_costs_too_much_is_refused_with_the_step_that_does_not() {
    let mesh = layered(Shape::Hex8);
    let try_target = |target_time_step, limit| {
        still(&mesh, Formulation::FBar, scaled(MassScaling { target_time_step, limit, ..NO_LIMIT }))
    };
    let own = still(&mesh, Formulation::FBar, until(1e-3)).unwrap().time_step();
    let Err(error) = try_target(4.0 * own, 0.01) else { panic!("the limit is passed") };
    let ModelError::AddedMass { part: 0, share, limit: 0.01, count: 16, attainable } = error else { panic!("{error}") };
    assert!(share > 0.05 && attainable > own, "{share} {attainable:e}");
    let within = try_target(attainable, 0.01).unwrap();
    let mass: f64 = still(&mesh, Formulation::FBar, until(1e-3)).unwrap().mass().iter().sum();
    let used = within.added_mass()[0] / mass;
    assert!(used <= 0.01 && used > 0.0099, "{used}");
    assert!(try_target(1.001 * attainable, 0.01).is_err());
}

/// A factor f on every mass makes every step √f times as long, and added mass has inertia but no weight.
#[test]
fn added_mass_has_inertia_but_no_weight() {
    let mesh = bricks([4e-3; 3], [2; 3]);
    let (factor, gravity) = (16.0, 9.81);
    let fall = |mass_scaling| {
        let model = Model {
            parts: whole(&mesh, elastic(), Formulation::FBar),
            loads: vec![load("gravity", LoadKind::Gravity { acceleration: [0.0, 0.0, -gravity] })],
            settings: TimeSettings { mass_scaling, ..until(1e-4) },
            ..Model::default()
        };
        let mut simulation = new(&mesh, model);
        let step = simulation.time_step();
        run(&mut simulation, |_| {});
        (step, simulation.displacement()[0][2], simulation.energies().error())
    };
    let (step, fallen, _) = fall(None);
    let (step_scaled, fallen_scaled, error) = fall(Some(MassScaling { factor, ..NO_LIMIT }));
    assert_close(step_scaled, step * factor.sqrt(), 1e-12 * step);
    assert_close(fallen_scaled, fallen / factor, 1e-9 * fallen.abs());
    assert!(error.abs() < 1e-9, "{error:e}");
}

#[test]
fn the_ledger_knows_the_kinetic_energy_of_added_mass_and_bounds_it() {
    let mesh = layered(Shape::Hex8);
    let model = |kinetic_limit| Model {
        parts: whole(&mesh, yielding(300e6, 1e9), Formulation::FBar),
        initial_velocities: vec![translation(&mesh, [0.0, 0.0, -100.0])],
        walls: vec![RigidWall::plane([0.0; 3], [0.0, 0.0, 1.0], 0.0)],
        settings: TimeSettings {
            mass_scaling: Some(MassScaling { factor: 1.25, kinetic_limit, ..NO_LIMIT }),
            ..until(10e-6)
        },
        ..Model::default()
    };
    let mut simulation = new(&mesh, model(f64::MAX));
    let at_start = simulation.energies().clone();
    assert_close(at_start.mass_scaling, 0.2 * at_start.initial_kinetic, 1e-12 * at_start.initial_kinetic);
    run(&mut simulation, |now| {
        let energies = now.energies();
        assert_close(energies.mass_scaling, 0.2 * energies.kinetic, 1e-9 * energies.initial_kinetic);
    });
    assert!(simulation.energies().error().abs() < 5e-3, "{:?}", simulation.energies());

    let mut bounded = new(&mesh, model(0.1));
    let error = loop {
        if let Err(error) = bounded.advance() {
            break error;
        }
    };
    assert!(matches!(error, SimulationError::AddedKineticEnergy { limit: 0.1, .. }), "{error}");
    // not before a tenth of the time
    assert!(bounded.time() >= 1e-6 && bounded.time() < 1.1e-6, "{}", bounded.time());
}

/// A free body slows down by exp(−α t), and its energy is in the row of damping.
#[test]
fn damping_slows_a_free_body_exponentially() {
    let mesh = bricks([4e-3; 3], [2; 3]);
    let (alpha, end, speed) = (2e4, 1e-4, 10.0);
    let model = Model {
        parts: whole(&mesh, elastic(), Formulation::FBar),
        initial_velocities: vec![translation(&mesh, [speed, 0.0, 0.0])],
        settings: TimeSettings { mass_damping: alpha, ..until(end) },
        ..Model::default()
    };
    let mut simulation = new(&mesh, model);
    run(&mut simulation, |now| assert!(now.energies().error().abs() < 1e-4, "{:?}", now.energies()));
    let left = simulation.momentum()[0] / simulation.mass().iter().sum::<f64>() / speed;
    assert_close(left, (-alpha * end).exp(), 1e-4);
    let energies = simulation.energies();
    assert_close(energies.damping, energies.initial_kinetic * (1.0 - left * left), 1e-4 * energies.initial_kinetic);
}

/// A bar under a load that stays comes to rest at the static stretch.
#[test]
fn damping_brings_a_loaded_bar_to_its_static_state() {
    let mesh = bricks([2e-3, 2e-3, 20e-3], [1, 1, 10]);
    let gravity = 1e6;
    let model = |mass_damping| Model {
        parts: whole(&mesh, elastic(), Formulation::Full),
        fixes: vec![Fix { nodes: nodes(&mesh, "z_min"), directions: vec![Direction::Z] }],
        loads: vec![load("gravity", LoadKind::Gravity { acceleration: [0.0, 0.0, gravity] })],
        settings: TimeSettings { mass_damping, ..until(1e-3) },
        ..Model::default()
    };
    // u = ρ g L²/(2 E) at the free end of a bar that may contract
    let stretch = 7850.0 * gravity * 20e-3_f64.powi(2) / (2.0 * 200e9);
    let mut damped = new(&mesh, model(8e4));
    run(&mut damped, |_| {});
    let end = nodes(&mesh, "z_max")[0] as usize;
    assert_close(damped.displacement()[end][2], stretch, 0.01 * stretch);
    assert!(damped.energies().kinetic < 1e-9 * damped.energies().internal, "{:?}", damped.energies());
    assert!(damped.energies().error().abs() < 1e-3, "{:?}", damped.energies());
}

/// 27 elements fill no number of lanes, and the last of them is scaled.
#[test]
fn scaled_runs_have_the_same_bits_on_any_lanes_and_when_resumed() {
    let mesh = bricks([3e-3; 3], [3; 3]);
    let model = || {
        let own = still(&mesh, Formulation::FBar, until(1e-3)).unwrap().time_step();
        Model {
            parts: whole(&mesh, yielding(300e6, 1e9), Formulation::FBar),
            initial_velocities: vec![translation(&mesh, [0.0, 0.0, -100.0])],
            walls: vec![RigidWall::plane([0.0; 3], [0.0, 0.0, 1.0], 0.1)],
            settings: TimeSettings {
                mass_scaling: Some(MassScaling { target_time_step: 1.2 * own, ..NO_LIMIT }),
                bulk_viscosity: Some(BulkViscosity { linear: 0.06, quadratic: 1.5 }),
                ..until(5e-6)
            },
            ..Model::default()
        }
    };
    let numbers = |simulation: &Simulation| {
        let mut numbers = Vec::new();
        simulation.for_each_number(|number| numbers.push(number.to_bits()));
        numbers
    };
    let ends = LaneLevel::ALL.into_iter().filter(|level| level.is_available()).map(|level| {
        let mut straight = Simulation::new(&mesh, model(), level).unwrap();
        let mut stopped = Simulation::new(&mesh, model(), level).unwrap();
        (0..5).for_each(|_| stopped.advance().unwrap());
        let state = numbers(&stopped);
        let mut resumed = Simulation::new(&mesh, model(), level).unwrap();
        let mut next = state.iter().map(|bits| f64::from_bits(*bits));
        resumed.restore(|| next.next().unwrap()).unwrap();
        run(&mut straight, |_| {});
        run(&mut resumed, |_| {});
        assert_eq!(numbers(&straight), numbers(&resumed), "{}", level.name());
        numbers(&straight)
    });
    let ends: Vec<_> = ends.collect();
    assert!(ends.windows(2).all(|pair| pair[0] == pair[1]));
}
