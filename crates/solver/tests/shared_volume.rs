//! Goal: four-node tets of one material share volume change and pressure over the borders of parts, those of two materials do
//! not, and what is told of their stress and volume is what acts.
//!
//! Mesh and loading: a block cut into tets, part of which flies at the rest of it. Source: Newton's second law; the averages of
//! `estar_element::tet4`, formed again here.

mod common;

use common::{bricks, cut_bricks, elasticity, minus, nodes, norm, run, stresses, until, yielding};
use estar_material::{IsotropicHardening, KinematicHardening, MaterialModel};
use estar_mesh::{Mesh, Shape};
use estar_solver::model::{Formulation, InitialVelocity, Part};
use estar_solver::{LaneLevel, Model, Simulation};

fn tets() -> Mesh {
    cut_bricks([4e-3, 4e-3, 6e-3], [4, 4, 6], Shape::Tet4)
}

/// A block whose lower end flies upwards, in parts of these materials of one half each.
fn struck(mesh: &Mesh, materials: [MaterialModel; 2]) -> Simulation {
    let (count, half) = (mesh.element_count() as u32, mesh.element_count() as u32 / 2);
    let part = |elements: std::ops::Range<u32>, material| Part {
        elements: elements.collect(),
        material,
        element: Formulation::Tet4,
    };
    let [first, second] = materials;
    let end = InitialVelocity { nodes: nodes(mesh, "z_min"), translation: [30.0, 10.0, 200.0], spin: None };
    let model = Model {
        parts: vec![part(0..half, first), part(half..count, second)],
        initial_velocities: vec![end],
        settings: until(4e-6),
        ..Model::default()
    };
    let mut simulation = Simulation::new(mesh, model, LaneLevel::best()).unwrap();
    run(&mut simulation, |_| ());
    assert!(simulation.extremes().max_equivalent_plastic_strain > 0.05);
    simulation
}

/// The largest distance between places of two simulations over the largest displacement.
fn apart(a: &Simulation, b: &Simulation) -> f64 {
    let pairs = a.displacement().iter().zip(b.displacement());
    let largest = a.displacement().iter().map(|u| norm(*u)).fold(0.0, f64::max);
    pairs.map(|(a, b)| norm(minus(*a, *b))).fold(0.0, f64::max) / largest
}

/// What differs in density by 10⁻⁹ is another material, though it moves alike.
#[test]
fn tets_share_their_volume_within_a_material_and_not_with_another() {
    let mesh = tets();
    let steel = || yielding(300e6, 1e9);
    let alone = struck(&mesh, [steel(), steel()]);
    let heavier = {
        let hardening = IsotropicHardening::linear(300e6, 1e9).unwrap();
        let elasticity = elasticity(7850.0 * (1.0 + 1e-9), 200e9, 0.3);
        MaterialModel::e_star_box_rate(elasticity, hardening, KinematicHardening::NONE)
    };
    let distance = apart(&alone, &struck(&mesh, [steel(), heavier]));
    println!("two materials of equal behaviour move apart by {distance:.1e} of the displacement");
    assert!(distance > 1e-3, "{distance}");
}

/// f_a = −Σ_e v_e T_e ∇N_a of the stress that is told is m_a a_a: the pressure of a tet is the one that acts.
#[test]
fn the_stress_that_is_told_of_tets_moves_their_nodes() {
    let mesh = tets();
    let simulation = struck(&mesh, [yielding(300e6, 1e9), yielding(300e6, 1e9)]);
    let mut forces = vec![[0.0; 3]; mesh.node_count()];
    for (element, [xx, yy, zz, xy, yz, xz]) in stresses(&simulation).into_iter().enumerate() {
        let nodes = mesh.elements().nodes(element);
        let place = |node: usize| place(&simulation, nodes[node]);
        // v ∇N_a = ⅓ times the area vector of the opposite face, inwards
        for (corner, [a, b, c]) in [[1, 3, 2], [0, 2, 3], [0, 3, 1], [0, 1, 2]].into_iter().enumerate() {
            let [x, y, z] = cross(minus(place(b), place(a)), minus(place(c), place(a))).map(|area| area / 6.0);
            let force = [xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z];
            (0..3).for_each(|i| forces[nodes[corner] as usize][i] -= force[i]);
        }
    }
    let largest = forces.iter().map(|force| norm(*force)).fold(0.0, f64::max);
    for (node, force) in forces.into_iter().enumerate() {
        let inertia = simulation.acceleration()[node].map(|a| simulation.mass()[node] * a);
        let open = norm(minus(force, inertia));
        assert!(open < 1e-11 * largest, "node {node}: {force:?} and {inertia:?}");
    }
}

/// ln J̄ = ¼ Σ_a ln J_a with J_a = Σ v/Σ V of the tets at a node, in both parts.
#[test]
fn the_volume_ratio_that_is_told_of_tets_is_that_of_their_neighbourhood() {
    let mesh = tets();
    let simulation = struck(&mesh, [yielding(300e6, 1e9), yielding(300e6, 1e9)]);
    let mut of_nodes = vec![[0.0; 2]; mesh.node_count()];
    let volume = |places: [[f64; 3]; 4]| {
        let edge = |node: usize| minus(places[node], places[0]);
        common::dot(cross(edge(1), edge(2)), edge(3)) / 6.0
    };
    let nodes = |element: usize| -> [u32; 4] { mesh.elements().nodes(element).try_into().unwrap() };
    let volumes: Vec<[f64; 2]> = (0..mesh.element_count())
        .map(|element| {
            let still = |node: u32| mesh.coordinates()[node as usize];
            [volume(nodes(element).map(|node| place(&simulation, node))), volume(nodes(element).map(still))]
        })
        .collect();
    for (element, volumes) in volumes.iter().enumerate() {
        for node in nodes(element) {
            (0..2).for_each(|i| of_nodes[node as usize][i] += volumes[i]);
        }
    }
    let mut told = vec![0.0; mesh.element_count()];
    simulation.write_volume_ratio(&mut told);
    let mut farthest = 0.0_f64;
    for (element, told) in told.into_iter().enumerate() {
        let logarithm = |node: u32| (of_nodes[node as usize][0] / of_nodes[node as usize][1]).ln();
        let expected = (nodes(element).into_iter().map(logarithm).sum::<f64>() / 4.0).exp();
        assert!((told / expected - 1.0).abs() < 1e-13, "element {element}: {told} and {expected}");
        farthest = farthest.max((volumes[element][0] / volumes[element][1] / told - 1.0).abs());
    }
    println!("volumes of single tets differ from it by up to {farthest:.3}");
    assert!(farthest > 0.01);
}

#[test]
fn hexes_share_no_volume() {
    let mesh = bricks([1.0; 3], [2; 3]);
    let parts = common::whole(&mesh, yielding(300e6, 1e9), Formulation::FBar);
    assert!(!common::new(&mesh, Model { parts, settings: until(1e-3), ..Model::default() }).shares_volume());
}

fn place(simulation: &Simulation, node: u32) -> [f64; 3] {
    let (x, u) = (simulation.reference()[node as usize], simulation.displacement()[node as usize]);
    std::array::from_fn(|i| x[i] + u[i])
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
