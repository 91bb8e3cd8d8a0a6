//! Goal: the memory that is told before is the memory that is taken, within a fifth and never less.
//!
//! Mesh: 32,768 bricks. Materials: none that yields, one that yields, one that yields and has a load and deletes its elements.
//! A file of its own, since it counts what the whole process allocates.

mod common;

use common::{bricks, elastic, load, until, yielding};
use estar_mesh::Mesh;
use estar_solver::model::{Formulation, LoadKind, OnInversion, Part, TimeSettings};
use estar_solver::{LaneLevel, Model, Simulation, memory_needed};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use std::alloc::System;

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

#[track_caller]
fn assert_told(what: &str, mesh: &Mesh, model: Model) {
    let told = memory_needed(mesh, &model) as f64;
    let region = Region::new(ALLOCATOR);
    let simulation = Simulation::new(mesh, model, LaneLevel::best()).unwrap();
    let change = region.change();
    // the lists of the model's hexes have been there before, and are handed on
    let taken = change.bytes_allocated as f64 - change.bytes_deallocated as f64;
    println!("{what}: told {told:.3e} bytes, taken {taken:.3e}");
    assert!(taken <= told && told < 1.2 * taken, "{what}: told {told}, taken {taken}");
    drop(simulation);
}

#[test]
fn the_memory_told_is_the_memory_taken() {
    let mesh = bricks([32e-3, 32e-3, 32e-3], [32, 32, 32]);
    let all: Vec<u32> = (0..mesh.element_count() as u32).collect();
    let model = |material, element| Model {
        parts: vec![Part { elements: all.clone(), material, element }],
        settings: until(1e-3),
        ..Model::default()
    };
    assert_told("elastic", &mesh, model(elastic(), Formulation::Full));
    assert_told("yielding", &mesh, model(yielding(300e6, 1e9), Formulation::FBar));
    let mut deleting = model(yielding(300e6, 1e9), Formulation::FBar);
    deleting.loads = vec![load("gravity", LoadKind::Gravity { acceleration: [0.0, 0.0, -9.81] })];
    deleting.settings = TimeSettings { on_inversion: OnInversion::Delete, ..until(1e-3) };
    assert_told("deleting", &mesh, deleting);
}
