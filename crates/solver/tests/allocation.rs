//! Goal: one step allocates nothing, whatever acts.
//!
//! Mesh: 1,053 bricks, whole or cut into tets, two parts; loads of every kind, a rough wall, held and driven nodes, bulk viscosity. A file of its
//! own, since it counts what the whole process allocates.

mod common;

use common::{cut_bricks, elastic, faces, load, nodes, prescribed, ramp, translation, until, yielding};
use estar_mesh::{Mesh, Shape};
use estar_solver::model::{
    BulkViscosity, Direction, Fix, Formulation, LoadKind, Part, Quantity, RigidWall, TimeSettings, TimeStep,
};
use estar_solver::{Curve, LaneLevel, Model, Simulation};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use std::alloc::System;

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

#[test]
fn one_step_allocates_nothing() {
    for shape in [Shape::Hex8, Shape::Tet4, Shape::Tet10] {
        assert_nothing_allocated(&cut_bricks([9e-3, 9e-3, 13e-3], [9, 9, 13], shape));
    }
}

fn assert_nothing_allocated(mesh: &Mesh) {
    let [first, second] = match mesh.elements().shape(0) {
        Shape::Tet4 => [Formulation::Tet4; 2],
        Shape::Tet10 => [Formulation::Tet10; 2],
        _ => [Formulation::FBar, Formulation::Full],
    };
    let count = mesh.element_count() as u32;
    let curve = ramp(1e-5, 1e7);
    let part = |hexes: std::ops::Range<u32>, material, element| Part { elements: hexes.collect(), material, element };
    // two blocks of tets that share their volume change
    let other = if first == Formulation::Tet4 { yielding(300e6, 1e9) } else { elastic() };
    let model = Model {
        parts: vec![part(0..count - 153, yielding(300e6, 1e9), first), part(count - 153..count, other, second)],
        fixes: vec![Fix { nodes: nodes(mesh, "x_min"), directions: vec![Direction::X] }],
        prescribed: vec![prescribed(nodes(mesh, "y_min"), Direction::Y, Quantity::Velocity, Curve::constant(1.0))],
        initial_velocities: vec![translation(mesh, [0.0, 0.0, -200.0])],
        loads: vec![
            load("gravity", LoadKind::Gravity { acceleration: [0.0, 0.0, -9.81] }),
            load("pressure", LoadKind::Pressure { faces: faces(mesh, "x_max"), curve: curve.clone() }),
            load("traction", LoadKind::Traction { faces: faces(mesh, "z_max"), direction: [0.0, 1.0, 0.0], curve }),
        ],
        walls: vec![RigidWall::plane([0.0; 3], [0.0, 0.0, 1.0], 0.2)],
        settings: TimeSettings {
            bulk_viscosity: Some(BulkViscosity { linear: 0.06, quadratic: 1.2 }),
            time_step: if first == Formulation::FBar { TimeStep::Power { interval: 20 } } else { TimeStep::Element },
            ..until(1e-3)
        },
    };
    let mut simulation = Simulation::new(mesh, model, LaneLevel::best()).unwrap();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    let stretches = pool.install(|| {
        let mut advance = |steps: u32| (0..steps).for_each(|_| simulation.advance().unwrap());
        advance(100);
        [(); 5].map(|()| {
            let region = Region::new(ALLOCATOR);
            advance(50);
            let change = region.change();
            (change.allocations, change.reallocations, change.deallocations)
        })
    });
    // a thread of the pool registers with its queues once, when it first looks for work, and makes its rows for its first patch,
    // which may be late; what a step allocates it would allocate in every stretch
    assert!(stretches.contains(&(0, 0, 0)), "{stretches:?}");
}
