//! Goal: the stable time step of the assembled mesh is that of the exact eigenvalue, less 2 to 3 %, never more.
//!
//! Meshes: bricks of one size; the same with displaced nodes; with slivers, a tenth as thick as their neighbours, in one corner and
//! through the whole; seven hexes none of which is a parallelepiped; and a block that is squeezed against a wall.
//!
//! Source: M⁻¹K and M⁻¹C column by column from the accelerations that the solver's own forces give a body of which one node moves
//! along one axis, which shares nothing with the operator that is estimated; eigenvalues by faer.

mod common;

use common::{
    FORMULATIONS, all_nodes, bricks, elastic, moved, new, patch_of_seven, translation, until, whole, yielding,
};
use estar_mesh::Mesh;
use estar_solver::model::{
    BulkViscosity, Formulation, HourglassControl, InitialVelocity, RigidWall, TimeSettings, TimeStep,
};
use estar_solver::{Energies, LaneLevel, Model, Simulation};
use faer::Mat;

/// Numbers in [−1, 1) from a linear congruential generator.
fn random(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// Every node displaced by up to `amount` in each direction.
fn distorted(mesh: &Mesh, amount: f64) -> Mesh {
    let mut seed = 5;
    let displaced = mesh.coordinates().iter().map(|x| x.map(|c| c + amount * random(&mut seed)));
    moved(mesh, displaced.collect())
}

fn meshes() -> [(&'static str, Mesh); 5] {
    let regular = bricks([3e-3, 3e-3, 4e-3], [3, 3, 4]);
    let squeezed = |x: &[f64; 3]| [x[0], x[1], if x[2] == 2e-3 { 1.1e-3 } else { x[2] }];
    let in_corner = |x: &[f64; 3]| if x[0] < 0.5e-3 && x[1] < 0.5e-3 { squeezed(x) } else { *x };
    let slivers =
        |map: &dyn Fn(&[f64; 3]) -> [f64; 3]| moved(&regular, regular.coordinates().iter().map(map).collect());
    [
        ("regular", bricks([3e-3, 3e-3, 4e-3], [3, 3, 4])),
        ("distorted", distorted(&regular, 0.22e-3)),
        ("a layer of slivers", slivers(&squeezed)),
        ("slivers in a corner", slivers(&in_corner)),
        ("seven hexes", patch_of_seven()),
    ]
}

/// A body at rest but for one node that moves along one axis.
fn model(mesh: &Mesh, formulation: Formulation, node: u32, axis: usize, settings: TimeSettings) -> Model {
    let mut velocity = [0.0; 3];
    velocity[axis] = SPEED;
    Model {
        parts: whole(mesh, elastic(), formulation),
        initial_velocities: vec![InitialVelocity { nodes: vec![node], translation: velocity, spin: None }],
        settings: TimeSettings { energy_error_limit: f64::MAX, ..settings },
        ..Model::default()
    }
}

/// So slow that the forces are linear to seven digits.
const SPEED: f64 = 1e-3;

/// Accelerations of all nodes after a step, over −`SPEED`, a column for every direction of every node, and the step.
fn columns(mesh: &Mesh, formulation: Formulation, settings: TimeSettings) -> (Mat<f64>, f64) {
    let size = 3 * mesh.node_count();
    let (mut matrix, mut time_step) = (Mat::zeros(size, size), 0.0);
    for column in 0..size {
        let model = model(mesh, formulation, (column / 3) as u32, column % 3, settings);
        let mut simulation = new(mesh, model);
        simulation.advance().unwrap();
        time_step = simulation.time_step();
        for (row, acceleration) in simulation.acceleration().as_flattened().iter().enumerate() {
            matrix[(row, column)] = -acceleration / SPEED;
        }
    }
    (matrix, time_step)
}

/// The largest modulus of an eigenvalue.
fn radius(matrix: &Mat<f64>) -> f64 {
    matrix.eigenvalues().unwrap().iter().map(|z| z.re.hypot(z.im)).fold(0.0, f64::max)
}

/// M⁻¹K, and M⁻¹C of dampers.
fn operators(mesh: &Mesh, formulation: Formulation, bulk_viscosity: Option<BulkViscosity>) -> [Mat<f64>; 2] {
    let settings = |safety_factor| TimeSettings { safety_factor, ..until(1.0) };
    let undamped = match formulation {
        Formulation::OnePoint(HourglassControl::Viscous { .. }) => {
            Formulation::OnePoint(HourglassControl::Stiffness { coefficient: 1e-300 })
        }
        other => other,
    };
    let (mut stiffness, step) = columns(mesh, undamped, settings(0.5));
    stiffness.col_iter_mut().for_each(|column| column.iter_mut().for_each(|entry| *entry /= step));
    // Δt K + C with a step of nearly nothing
    let (mut damping, step) = columns(mesh, formulation, TimeSettings { bulk_viscosity, ..settings(1e-7) });
    for (damping, stiffness) in damping.col_iter_mut().zip(stiffness.col_iter()) {
        damping.iter_mut().zip(stiffness.iter()).for_each(|(damping, stiffness)| *damping -= step * stiffness);
    }
    [stiffness, damping]
}

/// Δt with λ_max(Δt² M⁻¹K + 2 Δt M⁻¹C) = 4.
fn exact_limit([stiffness, damping]: &[Mat<f64>; 2], is_damped: bool) -> f64 {
    if !is_damped {
        return 2.0 / radius(stiffness).sqrt();
    }
    let (mut low, mut high) = (0.0, 2.0 / radius(stiffness).sqrt() * 1.001);
    while high - low > 1e-7 * high {
        let step = 0.5 * (low + high);
        let sum = Mat::from_fn(stiffness.nrows(), stiffness.ncols(), |i, j| {
            step * step * stiffness[(i, j)] + 2.0 * step * damping[(i, j)]
        });
        if radius(&sum) > 4.0 { high = step } else { low = step }
    }
    low
}

#[test]
fn step_is_within_3_percent_below_the_exact_limit_and_converges_to_it_in_every_formulation() {
    for (name, mesh) in meshes() {
        for formulation in FORMULATIONS {
            let is_viscous = matches!(formulation, Formulation::OnePoint(HourglassControl::Viscous { .. }));
            let exact = exact_limit(&operators(&mesh, formulation, None), is_viscous);
            let mut simulation = new(&mesh, Model { parts: whole(&mesh, elastic(), formulation), ..resting() });
            let (element, step) = (simulation.element_time_step(), simulation.global_time_step().unwrap());
            let converged = simulation.exact_global_time_step(400);
            println!(
                "{name}, {formulation:?}: {:.4} of the exact step, converged {:.1e}, bound of the elements {:.3}",
                step / exact,
                converged / exact - 1.0,
                element / exact
            );
            assert!(step <= exact, "{name}, {formulation:?}: {step} {exact}");
            assert!(step >= 0.97 * exact, "{name}, {formulation:?}: {step} {exact}");
            // the largest eigenvalue of the symmetric part is that of F-bar or more
            let below = if formulation == Formulation::FBar { 1e-3 } else { 1e-7 };
            let error = converged / exact - 1.0;
            assert!(-below < error && error < 1e-7, "{name}, {formulation:?}: {converged} {exact}");
        }
    }
}

#[test]
fn step_accounts_for_the_damping_of_bulk_viscosity() {
    let bulk_viscosity = Some(BulkViscosity { linear: 0.2, quadratic: 0.0 });
    let mesh = &meshes()[3].1;
    for formulation in FORMULATIONS {
        let exact = exact_limit(&operators(mesh, formulation, bulk_viscosity), true);
        let settings = TimeSettings { bulk_viscosity, ..until(1.0) };
        let mut simulation =
            new(mesh, Model { parts: whole(mesh, elastic(), formulation), settings, ..Model::default() });
        let (element, step) = (simulation.element_time_step(), simulation.global_time_step().unwrap());
        let converged = simulation.exact_global_time_step(400);
        println!(
            "{formulation:?}: {:.4} of the exact step, converged {:.1e}, bound of the elements {:.3}",
            step / exact,
            converged / exact - 1.0,
            element / exact
        );
        assert!(step <= exact && step >= 0.97 * exact, "{formulation:?}: {step} {exact}");
        assert!((converged / exact - 1.0).abs() < 1e-3, "{formulation:?}: {converged} {exact}");
    }
}

fn resting() -> Model {
    Model { settings: until(1.0), ..Model::default() }
}

/// The share of the exact step that k steps from many starts give, without the allowance.
#[test]
fn hundred_starts_in_a_row_miss_the_largest_eigenvalue_by_less_than_the_allowance() {
    let mesh = bricks([6e-3, 6e-3, 12e-3], [6, 6, 12]);
    let settings = TimeSettings { time_step: TimeStep::Power { interval: 1 }, ..until(1.0) };
    let mut simulation =
        new(&mesh, Model { parts: whole(&mesh, elastic(), Formulation::Full), settings, ..Model::default() });
    let exact = simulation.exact_global_time_step(600);
    let mut shares: Vec<f64> = Vec::new();
    for _ in 0..100 {
        simulation.advance().unwrap();
        shares.push(simulation.extremes().stable_time_step / exact);
    }
    shares.sort_by(f64::total_cmp);
    println!("{:.4} to {:.4} of the exact step", shares[0], shares[99]);
    assert!(shares[0] > 0.97 && shares[99] < 0.99, "{shares:?}");
}

/// A block that hits a wall at `speed`.
fn impact(time_step: TimeStep, formulation: Formulation, speed: f64) -> (Mesh, Model) {
    let mesh = distorted(&bricks([6e-3, 6e-3, 12e-3], [5, 5, 10]), 0.15e-3);
    let lowest = mesh.coordinates().iter().map(|x| x[2]).fold(f64::INFINITY, f64::min);
    let model = Model {
        parts: whole(&mesh, yielding(300e6, 500e6), formulation),
        initial_velocities: vec![translation(&mesh, [0.0, 0.0, -speed])],
        walls: vec![RigidWall::plane([0.0, 0.0, lowest], [0.0, 0.0, 1.0], 0.0)],
        settings: TimeSettings { time_step, ..until(40e-6) },
        ..Model::default()
    };
    (mesh, model)
}

/// The bound of the block's elements follows its deformation, an estimate every 50 of some 600 steps the rest: with one in 200
/// steps are up to 1 % above the limit for a while.
#[test]
fn step_stays_below_the_exact_limit_while_a_block_is_squeezed() {
    for formulation in FORMULATIONS {
        let (mesh, model) = impact(TimeStep::Power { interval: 50 }, formulation, 250.0);
        let mut simulation = new(&mesh, model);
        let (mut least, mut most, mut gains) = (f64::INFINITY, 0.0_f64, Vec::new());
        while !simulation.is_finished() {
            simulation.advance().unwrap();
            if simulation.step().is_multiple_of(10) {
                let used = simulation.extremes().stable_time_step;
                let share = used / simulation.exact_global_time_step(200);
                (least, most) = (least.min(share), most.max(share));
                gains.push(used / simulation.element_time_step());
            }
        }
        let gain = gains.iter().sum::<f64>() / gains.len() as f64;
        println!(
            "{formulation:?}: {least:.3} to {most:.3} of the exact step, {gain:.3} of that of the elements, {} estimates in {} steps",
            simulation.estimate_count(),
            simulation.step()
        );
        assert!(least > 0.9 && most < 1.0 && gain > 1.2, "{formulation:?}: {least} {most} {gain}");
    }
}

/// Vibrations of all frequencies at once, with every step as long as it may be.
#[test]
fn vibrations_stay_bounded_at_a_safety_factor_of_one() {
    let mesh = &meshes()[3].1;
    for formulation in FORMULATIONS.into_iter().filter(|formulation| *formulation != Formulation::FBar) {
        let mut seed = 11;
        let velocity = |node| InitialVelocity {
            nodes: vec![node],
            translation: std::array::from_fn(|_| 1e-3 * random(&mut seed)),
            spin: None,
        };
        let model = Model {
            parts: whole(mesh, elastic(), formulation),
            initial_velocities: all_nodes(mesh).into_iter().map(velocity).collect(),
            settings: TimeSettings {
                safety_factor: 1.0,
                time_step: TimeStep::Power { interval: 500 },
                energy_error_limit: f64::MAX,
                ..until(1.0)
            },
            ..Model::default()
        };
        let mut simulation = new(mesh, model);
        let gain = simulation.time_step() / simulation.element_time_step();
        let initial = simulation.energies().initial_kinetic;
        let mut largest = 0.0_f64;
        for _ in 0..20_000 {
            simulation.advance().unwrap();
            largest = largest.max(kept(simulation.energies()));
        }
        println!("{formulation:?}: step {gain:.3} of that of the elements, energy up to {:.3}", largest / initial);
        assert!(gain > 1.0 && largest < 1.2 * initial, "{formulation:?}: {gain} {largest} {initial}");
    }
}

/// What central differences keep in an elastic body.
fn kept(energies: &Energies) -> f64 {
    energies.kinetic + energies.internal + energies.integration
}

fn bits(simulation: &Simulation) -> Vec<u64> {
    let mut bits = Vec::new();
    simulation.for_each_number(|number| bits.push(number.to_bits()));
    bits
}

#[test]
fn steps_have_the_same_bits_for_any_threads_and_lanes_and_after_a_restart() {
    let (mesh, mut model) = impact(TimeStep::Power { interval: 30 }, Formulation::FBar, 250.0);
    model.settings.bulk_viscosity = Some(BulkViscosity { linear: 0.06, quadratic: 1.2 });
    let begin = |lanes| Simulation::new(&mesh, model.clone(), lanes).unwrap();
    let go_on = |simulation: &mut Simulation, steps: usize, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| (0..steps).for_each(|_| simulation.advance().unwrap()));
    };
    let mut one = begin(LaneLevel::best());
    go_on(&mut one, 70, 1);
    let mut numbers = Vec::new();
    one.for_each_number(|number| numbers.push(number));
    go_on(&mut one, 80, 1);
    for lanes in [LaneLevel::best(), LaneLevel::Portable] {
        let mut other = begin(lanes);
        go_on(&mut other, 150, 3);
        assert!(bits(&one) == bits(&other), "{lanes:?}");
        let mut resumed = begin(lanes);
        let mut numbers = numbers.iter().copied();
        resumed.restore(|| numbers.next().unwrap()).unwrap();
        go_on(&mut resumed, 80, 2);
        assert!(bits(&one) == bits(&resumed), "{lanes:?}");
    }
}
