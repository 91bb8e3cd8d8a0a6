//! Goal: the mass that moves is density times the volume that is told of the mesh, and the weight is that of this mass.
//!
//! Mesh: a bent cube in elements of every shape; of ten-node tets the edges are bent, too. Source: one body has one mass.

mod common;

use common::{ELEMENTS, elastic, irregular_cube, load, moved, new, steel, until, whole};
use estar_mesh::quality::QualityReport;
use estar_solver::Model;
use estar_solver::model::LoadKind;

#[test]
fn the_mass_that_moves_is_the_mass_that_is_told() {
    for (formulation, shape) in ELEMENTS {
        let straight = irregular_cube(shape);
        let bend = |&[x, y, z]: &[f64; 3]| [x + 0.2 * y * y, y + 0.3 * z * x, z - 0.2 * x * x];
        let mesh = moved(&straight, straight.coordinates().iter().map(bend).collect());
        let told = steel().density() * QualityReport::new(&mesh).total_volume();
        let gravity = load("gravity", LoadKind::Gravity { acceleration: [0.0, 0.0, -10.0] });
        let parts = whole(&mesh, elastic(), formulation);
        let mut simulation =
            new(&mesh, Model { parts, loads: vec![gravity], settings: until(1e-5), ..Model::default() });
        let moves: f64 = simulation.mass().iter().sum();
        assert!((moves / told - 1.0).abs() < 1e-13, "{formulation:?} of {shape}: {moves} kg move, {told} kg are told");
        // the momentum that its weight gives it
        common::run(&mut simulation, |_| ());
        let expected = -10.0 * 1e-5 * told;
        let momentum = simulation.momentum()[2];
        assert!((momentum / expected - 1.0).abs() < 1e-9, "{formulation:?} of {shape}: {momentum} and {expected}");
    }
}
