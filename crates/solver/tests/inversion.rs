//! Goal: what is told to help where elements turn inside out does help.
//!
//! Mesh and loading: a block of copper of 512 hexes, indented deeply by a rough cylinder. Source: docs/elements.md, where other problems
//! show the same.

mod common;

use common::{DIRECTIONS, bricks, elasticity, nodes, ramp, until, whole};
use estar_material::{IsotropicHardening, KinematicHardening, MaterialModel};
use estar_solver::model::{Direction, Fix, Formulation, HourglassControl, Quantity, RigidWall, WallMotion, WallShape};
use estar_solver::{LaneLevel, Model, Simulation, SimulationError};

/// The time up to which the elements follow, s, and whether they turn inside out then.
fn followed(element: Formulation) -> (f64, bool) {
    let end = 0.3e-3;
    let mesh = bricks([20e-3, 10e-3, 10e-3], [16, 4, 8]);
    let hardening = IsotropicHardening::linear(400e6, 100e6).unwrap();
    let copper = MaterialModel::e_star_box_rate(elasticity(8930.0, 117e9, 0.35), hardening, KinematicHardening::NONE);
    let held = |group, directions: &[Direction]| Fix { nodes: nodes(&mesh, group), directions: directions.to_vec() };
    let cylinder = WallShape::Cylinder { point: [0.0, 0.0, 13e-3], axis: [0.0, 1.0, 0.0], radius: 3e-3 };
    let motion = WallMotion { direction: [0.0, 0.0, -1.0], quantity: Quantity::Displacement, curve: ramp(end, 7e-3) };
    let model = Model {
        parts: whole(&mesh, copper, element),
        fixes: vec![held("z_min", &DIRECTIONS), held("x_min", &[Direction::X]), held("y_min", &[Direction::Y])],
        walls: vec![RigidWall { shape: cylinder, friction: 0.3, motion: Some(motion) }],
        settings: until(end),
        ..Model::default()
    };
    let mut simulation = Simulation::new(&mesh, model, LaneLevel::best()).unwrap();
    let mut inverted = false;
    while !simulation.is_finished() && !inverted {
        match simulation.advance() {
            Ok(()) => {}
            Err(SimulationError::ElementInverted { .. }) => inverted = true,
            Err(other) => panic!("{other}"),
        }
    }
    println!("{element:?}: {:.1} µs, inverted: {inverted}", 1e6 * simulation.time());
    (simulation.time() / end, inverted)
}

#[test]
fn the_one_point_hex_follows_where_f_bar_and_b_bar_turn_inside_out() {
    let [f_bar, b_bar] = [Formulation::FBar, Formulation::BBar].map(followed);
    assert!(f_bar.1 && b_bar.1 && (f_bar.0 - b_bar.0).abs() < 0.02, "{f_bar:?} {b_bar:?}");
    assert_eq!(followed(Formulation::OnePoint(HourglassControl::Physical)), (1.0, false));
}
