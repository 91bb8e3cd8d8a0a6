//! Goal: the lowest natural frequency of a body as it is held is that of its matrices and that of closed forms; rigid motions are
//! no vibrations.
//!
//! Meshes: a small block, free and held in every way; bars and strips. Source: M⁻¹K column by column from the accelerations that
//! the solver's own forces give a body of which one node moves along one axis, eigenvalues by faer; closed forms of bars
//! (c/4L, c/2L) and of a strip (Euler and Bernoulli, β₁L = 1.8751).

mod common;

use common::{DIRECTIONS, ELEMENTS, cut_bricks, elasticity, mesh_of, new, until, whole};
use estar_material::{Elastic, MaterialModel};
use estar_mesh::{Elements, Mesh, Shape};
use estar_solver::model::{Direction, Fix, Formulation, HourglassControl, InitialVelocity, TimeSettings};
use estar_solver::{LaneLevel, Model, NaturalFrequency, Simulation};
use faer::Mat;
use std::f64::consts::TAU;

const PHYSICAL: Formulation = Formulation::OnePoint(HourglassControl::Physical);

/// ρ = 7850 kg/m³, E = 200 GPa, without sideways contraction.
fn slender() -> MaterialModel {
    Elastic::new(elasticity(7850.0, 200e9, 0.0)).into()
}

fn nodes_where(mesh: &Mesh, is_meant: impl Fn(&[f64; 3]) -> bool) -> Vec<u32> {
    (0..).zip(mesh.coordinates()).filter(|(_, x)| is_meant(x)).map(|(node, _)| node).collect()
}

fn held(nodes: Vec<u32>, directions: &[Direction]) -> Fix {
    Fix { nodes, directions: directions.to_vec() }
}

fn model(mesh: &Mesh, formulation: Formulation, fixes: &[Fix]) -> Model {
    let parts = whole(mesh, slender(), formulation);
    Model { parts, fixes: fixes.to_vec(), settings: until(1.0), ..Model::default() }
}

fn found(mesh: &Mesh, formulation: Formulation, fixes: &[Fix]) -> f64 {
    match new(mesh, model(mesh, formulation, fixes)).natural_frequency() {
        NaturalFrequency::Found { frequency, .. } => frequency,
        other => panic!("{other:?}"),
    }
}

/// The eigenvalues of M⁻¹K of the free directions, from the smallest on, 1/s².
fn eigenvalues(mesh: &Mesh, formulation: Formulation, fixes: &[Fix]) -> Vec<f64> {
    const SPEED: f64 = 1e-3;
    let is_free = |place: &usize| {
        let (node, direction) = ((place / 3) as u32, DIRECTIONS[place % 3]);
        !fixes.iter().any(|fix| fix.directions.contains(&direction) && fix.nodes.contains(&node))
    };
    let free: Vec<usize> = (0..3 * mesh.node_count()).filter(is_free).collect();
    let mut matrix = Mat::zeros(free.len(), free.len());
    for (column, place) in free.iter().enumerate() {
        let mut velocity = [0.0; 3];
        velocity[place % 3] = SPEED;
        let nodes = vec![(place / 3) as u32];
        let moves = InitialVelocity { nodes, translation: velocity, spin: None };
        let settings = TimeSettings { energy_error_limit: f64::MAX, ..until(1.0) };
        let mut simulation =
            new(mesh, Model { initial_velocities: vec![moves], settings, ..model(mesh, formulation, &[]) });
        simulation.advance().unwrap();
        let per_displacement = -1.0 / (SPEED * simulation.time_step());
        let accelerations = simulation.acceleration().as_flattened();
        for (row, place) in free.iter().enumerate() {
            matrix[(row, column)] = per_displacement * accelerations[*place];
        }
    }
    let mut eigenvalues: Vec<f64> = matrix.eigenvalues().unwrap().iter().map(|value| value.re).collect();
    eigenvalues.sort_by(f64::total_cmp);
    eigenvalues
}

#[test]
fn frequency_is_that_of_the_smallest_eigenvalue_that_is_not_zero() {
    let lengths = [2e-3, 3e-3, 8e-3];
    for (formulation, shape) in ELEMENTS {
        let is_viscous = matches!(formulation, Formulation::OnePoint(HourglassControl::Viscous { .. }));
        if shape == Shape::Wedge6 || is_viscous {
            continue;
        }
        let cells = if shape == Shape::Tet10 { [1, 1, 2] } else { [1, 2, 4] };
        let mesh = cut_bricks(lengths, cells, shape);
        let [x, y, bottom] = [0, 1, 2].map(|axis| nodes_where(&mesh, |x| x[axis] == 0.0));
        // free, two planes of symmetry and a bar between them, one held end
        let planes = [held(x, &[Direction::X]), held(y, &[Direction::Y])];
        let cases = [(6, Vec::new()), (1, planes.to_vec()), (0, vec![held(bottom, &DIRECTIONS)])];
        for (rigid, fixes) in cases {
            let exact = eigenvalues(&mesh, formulation, &fixes);
            let largest = exact[exact.len() - 1];
            assert!(exact.iter().take(rigid).all(|value| value.abs() < 1e-6 * largest), "{exact:?}");
            let exact = exact[rigid].sqrt() / TAU;
            let found = found(&mesh, formulation, &fixes);
            let error = found / exact - 1.0;
            println!("{formulation:?}, {rigid} rigid motions: {found:.0} Hz, {error:.1e}");
            // The search ends where a quarter more of its steps changes the eigenvalue by less than 1 %. Tets of four nodes share no
            // volume in it and are stiffer, most of all one across in bending.
            let above = if formulation == Formulation::Tet4 { 0.25 } else { 1e-2 };
            assert!(-1e-4 < error && error < above, "{formulation:?}, {rigid}: {found} {exact}");
        }
    }
}

#[test]
fn bars_vibrate_with_a_quarter_or_half_of_a_wave() {
    let length = 0.1;
    let speed = (200e9_f64 / 7850.0).sqrt();
    for (formulation, shape) in [(Formulation::FBar, Shape::Hex8), (Formulation::Tet10, Shape::Tet10)] {
        let mesh = cut_bricks([4e-3, 4e-3, length], [1, 1, 25], shape);
        let along = held(nodes_where(&mesh, |_| true), &[Direction::X, Direction::Y]);
        let end = held(nodes_where(&mesh, |x| x[2] == 0.0), &[Direction::Z]);
        for (quarters, fixes) in [(2.0, vec![along.clone()]), (1.0, vec![along, end])] {
            let exact = quarters * speed / (4.0 * length);
            let found = found(&mesh, formulation, &fixes);
            println!("{formulation:?}: {found:.0} Hz, exact {exact:.0} Hz");
            assert!((found / exact - 1.0).abs() < 5e-3, "{found} {exact}");
        }
    }
}

#[test]
fn held_strip_vibrates_as_a_beam() {
    let [length, thickness] = [40e-3, 1e-3];
    // ω = (β/L)² √(E/ρ) h/√12
    let of_beam = |beta: f64| (beta / length).powi(2) * (200e9_f64 / 7850.0).sqrt() * thickness / 12.0_f64.sqrt() / TAU;
    let elements = [(PHYSICAL, Shape::Hex8, [40, 2, 2]), (Formulation::Tet10, Shape::Tet10, [40, 2, 2])];
    for (formulation, shape, cells) in elements {
        let mesh = cut_bricks([length, 2e-3, thickness], cells, shape);
        let end = held(nodes_where(&mesh, |x| x[0] == 0.0), &DIRECTIONS);
        for (beta, fixes) in [(1.875_104, vec![end]), (4.730_041, Vec::new())] {
            let (found, exact) = (found(&mesh, formulation, &fixes), of_beam(beta));
            println!("{formulation:?}: {found:.1} Hz, beam {exact:.1} Hz");
            assert!((found / exact - 1.0).abs() < 0.02, "{formulation:?}: {found} {exact}");
        }
    }
}

/// Two bodies, of which each moves rigidly by itself; the slower one sets the pace.
#[test]
fn slowest_of_several_bodies_counts() {
    let short = cut_bricks([2e-3, 2e-3, 4e-3], [1, 1, 2], Shape::Hex8);
    let long = cut_bricks([2e-3, 2e-3, 16e-3], [1, 1, 8], Shape::Hex8);
    let apart = |x: &[f64; 3]| [x[0] + 10e-3, x[1], x[2]];
    let coordinates = short.coordinates().iter().copied().chain(long.coordinates().iter().map(apart)).collect();
    let first = short.node_count() as u32;
    let mut elements = Elements::default();
    short.elements().iter().for_each(|nodes| elements.push(Shape::Hex8, nodes));
    let shifted = |nodes: &[u32]| nodes.iter().map(|node| node + first).collect::<Vec<_>>();
    long.elements().iter().for_each(|nodes| elements.push(Shape::Hex8, &shifted(nodes)));
    let both = mesh_of(coordinates, elements);
    let (both, alone) = (found(&both, PHYSICAL, &[]), found(&long, PHYSICAL, &[]));
    assert!((both / alone - 1.0).abs() < 5e-3, "{both} {alone}");
}

#[test]
fn what_cannot_vibrate_is_told() {
    let mesh = cut_bricks([1.0; 3], [2, 2, 2], Shape::Hex8);
    let all = held(nodes_where(&mesh, |_| true), &DIRECTIONS);
    let nothing = new(&mesh, model(&mesh, PHYSICAL, &[all])).natural_frequency();
    assert_eq!(nothing, NaturalFrequency::NothingFree);
    // two cubes that share an edge
    let corners =
        |x: f64, y: f64| (0..8).map(move |i| [x + f64::from(i & 1), y + f64::from(i >> 1 & 1), f64::from(i >> 2)]);
    let mut coordinates: Vec<[f64; 3]> = corners(0.0, 0.0).collect();
    let mut nodes = Vec::new();
    for x in corners(1.0, 1.0) {
        nodes.push(coordinates.iter().position(|other| *other == x).unwrap_or_else(|| {
            coordinates.push(x);
            coordinates.len() - 1
        }) as u32);
    }
    let mut elements = Elements::default();
    elements.push(Shape::Hex8, &[0, 1, 3, 2, 4, 5, 7, 6]);
    elements.push(Shape::Hex8, &[0, 1, 3, 2, 4, 5, 7, 6].map(|place| nodes[place]));
    let hinge = mesh_of(coordinates, elements);
    assert_eq!(new(&hinge, model(&hinge, PHYSICAL, &[])).natural_frequency(), NaturalFrequency::Mechanism);
}

#[test]
fn frequency_has_the_same_bits_for_any_threads_and_lanes() {
    let mesh = cut_bricks([40e-3, 2e-3, 1e-3], [80, 6, 3], Shape::Hex8);
    let find = |lanes, threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| Simulation::new(&mesh, model(&mesh, PHYSICAL, &[]), lanes).unwrap().natural_frequency())
    };
    let one = find(LaneLevel::best(), 1);
    assert_eq!(find(LaneLevel::best(), 3), one);
    assert_eq!(find(LaneLevel::Portable, 2), one);
}
