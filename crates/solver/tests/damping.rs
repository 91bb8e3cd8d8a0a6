//! Damping in proportion to mass, and what holds the body.
//!
//! Goal: damping brakes the motion that constraints and walls leave, so that at rest it is not felt anywhere.
//! Mesh: a column of eight bricks. Loading: its weight. Source: equilibrium.

mod common;

use common::{DIRECTIONS, assert_close, bricks, elasticity, load, new, nodes, run, until, whole};
use estar_material::Elastic;
use estar_mesh::Mesh;
use estar_solver::model::{Direction, Fix, Formulation, LoadKind, RigidWall, TimeSettings};
use estar_solver::{Model, Simulation};

/// ρ V g = 2500 · 0.02² · 0.16 · 9.81 N.
const WEIGHT: f64 = 1.5696;

fn column() -> Mesh {
    bricks([0.02, 0.02, 0.16], [1, 1, 8])
}

fn under_its_weight(mesh: &Mesh, mass_damping: f64, safety_factor: f64) -> Model {
    let material = Elastic::new(elasticity(2500.0, 100e6, 0.2)).into();
    Model {
        parts: whole(mesh, material, Formulation::BBar),
        loads: vec![load("weight", LoadKind::Gravity { acceleration: [0.0, 0.0, -9.81] })],
        settings: TimeSettings { mass_damping, safety_factor, ..until(0.08) },
        ..Model::default()
    }
}

fn settled(mesh: &Mesh, model: Model) -> Simulation {
    let mut simulation = new(mesh, model);
    let mut damping = 0.0;
    run(&mut simulation, |now| {
        let taken = now.energies().damping;
        assert!(taken >= damping - 1e-9 * now.energies().in_play, "{taken} after {damping}");
        damping = taken;
    });
    simulation
}

/// After Kratos #11107, where damping took a part of the reaction.
#[test]
fn the_reaction_of_a_damped_column_at_rest_is_its_weight() {
    let mesh = column();
    let foot = nodes(&mesh, "z_min");
    for (mass_damping, safety_factor) in [(1000.0, 0.9), (4000.0, 0.9), (4000.0, 0.3)] {
        let fixes = vec![Fix { nodes: foot.clone(), directions: DIRECTIONS.to_vec() }];
        let simulation = settled(&mesh, Model { fixes, ..under_its_weight(&mesh, mass_damping, safety_factor) });
        assert_close(simulation.reaction(&foot, Direction::Z), WEIGHT, 1e-7 * WEIGHT);
        let energies = simulation.energies();
        // half of the work of a load that is suddenly there is left in the column, the other half was damped, to second order
        let order = 4e-3 * (safety_factor / 0.9_f64).powi(2);
        assert_close(energies.damping, 0.5 * energies.external_work(), order * energies.external_work());
        assert!(energies.error().abs() < 1e-4, "{}", energies.error());
    }
}

#[test]
fn a_damped_column_at_rest_presses_on_a_wall_with_its_weight() {
    let mesh = column();
    for (mass_damping, safety_factor) in [(1000.0, 0.9), (4000.0, 0.9), (4000.0, 0.3)] {
        let symmetry = |group, direction| Fix { nodes: nodes(&mesh, group), directions: vec![direction] };
        let model = Model {
            fixes: vec![symmetry("x_min", Direction::X), symmetry("y_min", Direction::Y)],
            walls: vec![RigidWall::plane([0.0; 3], [0.0, 0.0, 1.0], 0.0)],
            ..under_its_weight(&mesh, mass_damping, safety_factor)
        };
        let simulation = settled(&mesh, model);
        assert_close(simulation.wall_force(0)[2], WEIGHT, 1e-6 * WEIGHT);
    }
}

/// A bar that is drawn at a constant rate, damped: what its ends are pulled with differs by what brakes the moving mass, and what
/// the damping takes is the power of that force.
#[test]
fn a_driven_body_pays_for_its_damping() {
    let mesh = column();
    let (mass_damping, speed) = (50.0, 0.3);
    let everything = common::all_nodes(&mesh);
    let curve = estar_solver::Curve::constant(speed);
    let mut model = under_its_weight(&mesh, mass_damping, 0.9);
    model.loads.clear();
    model.prescribed = DIRECTIONS
        .map(|direction| {
            let curve = if direction == Direction::X { curve.clone() } else { estar_solver::Curve::constant(0.0) };
            common::prescribed(everything.clone(), direction, estar_solver::model::Quantity::Velocity, curve)
        })
        .to_vec();
    model.initial_velocities = vec![common::translation(&mesh, [speed, 0.0, 0.0])];
    let simulation = settled(&mesh, model);
    // F = α m v, and its work F v t
    let mass = WEIGHT / 9.81;
    let force = mass_damping * mass * speed;
    assert_close(simulation.reaction(&everything, Direction::X), force, 1e-9 * force);
    let work = force * speed * simulation.time();
    assert_close(simulation.energies().external_work(), work, 1e-9 * work);
    assert_close(simulation.energies().damping, work, 1e-9 * work);
}
