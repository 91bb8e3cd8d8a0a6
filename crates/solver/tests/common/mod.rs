//! What the tests of the solver share: materials, meshes, and a run that must not fail.

// each file of tests uses a part of this
#![allow(dead_code)]

use estar_material::{
    AdiabaticHeating, Elastic, ElasticConstant, IsotropicElasticity, IsotropicHardening, JohnsonCook,
    JohnsonCookParameters, KinematicHardening, MaterialModel,
};
use estar_mesh::generate::{BoxSpec, box_mesh, cut_into};
use estar_mesh::{ElementLabel, Elements, Face, Mesh, NodeLabel, Shape};
use estar_solver::fields::ElementMeans;
use estar_solver::model::{
    Direction, Formulation, HourglassControl, InitialVelocity, Load, LoadKind, Part, Prescribed, Quantity, Spin,
    TimeSettings,
};
use estar_solver::{Curve, Interpolation, LaneLevel, Model, Simulation};

pub const FORMULATIONS: [Formulation; 6] = [
    Formulation::Full,
    Formulation::FBar,
    Formulation::BBar,
    Formulation::OnePoint(HourglassControl::Physical),
    Formulation::OnePoint(HourglassControl::Stiffness { coefficient: 0.05 }),
    Formulation::OnePoint(HourglassControl::Viscous { coefficient: 0.1 }),
];
/// Every formulation with every shape of element that structured meshes can be cut into and that it is made for.
pub const ELEMENTS: [(Formulation, Shape); 13] = {
    let mut elements = [(Formulation::Tet4, Shape::Tet4); 13];
    elements[1] = (Formulation::Tet10, Shape::Tet10);
    let (mut k, mut next) = (0, 2);
    while k < FORMULATIONS.len() {
        elements[next] = (FORMULATIONS[k], Shape::Hex8);
        next += 1;
        if !matches!(FORMULATIONS[k], Formulation::FBar) {
            elements[next] = (FORMULATIONS[k], Shape::Wedge6);
            next += 1;
        }
        k += 1;
    }
    elements
};
pub const DIRECTIONS: [Direction; 3] = [Direction::X, Direction::Y, Direction::Z];

pub fn elasticity(density: f64, young_modulus: f64, poisson_ratio: f64) -> IsotropicElasticity {
    let constants = (ElasticConstant::YoungModulus(young_modulus), ElasticConstant::PoissonRatio(poisson_ratio));
    IsotropicElasticity::new(density, constants.0, constants.1).unwrap()
}

/// Steel: ρ = 7850 kg/m³, E = 200 GPa, ν = 0.3.
pub fn steel() -> IsotropicElasticity {
    elasticity(7850.0, 200e9, 0.3)
}

pub fn elastic() -> MaterialModel {
    Elastic::new(steel()).into()
}

/// Steel that yields at `yield_stress` and hardens linearly.
pub fn yielding(yield_stress: f64, modulus: f64) -> MaterialModel {
    let hardening = IsotropicHardening::linear(yield_stress, modulus).unwrap();
    MaterialModel::e_star_box_rate(steel(), hardening, KinematicHardening::NONE)
}

pub fn bricks(lengths: [f64; 3], cells: [u32; 3]) -> Mesh {
    box_mesh(&BoxSpec::new(lengths, cells).unwrap())
}

pub fn nodes(mesh: &Mesh, group: &str) -> Vec<u32> {
    mesh.group(group).unwrap().nodes.clone()
}

pub fn faces(mesh: &Mesh, group: &str) -> Vec<Face> {
    mesh.outward_faces(mesh.group(group).unwrap()).unwrap()
}

pub fn all_nodes(mesh: &Mesh) -> Vec<u32> {
    (0..mesh.node_count() as u32).collect()
}

/// The same mesh at other coordinates.
pub fn moved(mesh: &Mesh, coordinates: Vec<[f64; 3]>) -> Mesh {
    let (node_labels, element_labels) = (mesh.node_labels().to_vec(), mesh.element_labels().to_vec());
    Mesh::new(coordinates, node_labels, mesh.elements().clone(), element_labels, mesh.groups().to_vec()).unwrap()
}

/// A mesh numbered from 1, without groups.
pub fn mesh_of(coordinates: Vec<[f64; 3]>, elements: impl Into<Elements>) -> Mesh {
    let elements = elements.into();
    let node_labels = (1..=coordinates.len() as u64).map(NodeLabel).collect();
    let element_labels = (1..=elements.len() as u64).map(ElementLabel).collect();
    Mesh::new(coordinates, node_labels, elements, element_labels, Vec::new()).unwrap()
}

/// A structured mesh cut into elements of a shape.
pub fn cut_bricks(lengths: [f64; 3], cells: [u32; 3], shape: Shape) -> Mesh {
    cut_into(&bricks(lengths, cells), shape)
}

/// Nodes on the faces of the unit cube.
pub fn on_unit_cube(mesh: &Mesh) -> Vec<u32> {
    let is_outer = |x: &[f64; 3]| x.iter().any(|c| c.abs() < 1e-9 || (c - 1.0).abs() < 1e-9);
    (0..).zip(mesh.coordinates()).filter(|(_, x)| is_outer(x)).map(|(node, _)| node).collect()
}

/// A unit cube in elements of a shape whose inner corners are moved, the middles of edges with them.
pub fn irregular_cube(shape: Shape) -> Mesh {
    let regular = bricks([1.0; 3], [3; 3]);
    let outer = on_unit_cube(&regular);
    let shifted = |(node, x): (u32, &[f64; 3])| {
        let off = |axis: usize| 0.09 * (f64::from(node) * (1.7 + axis as f64)).sin();
        if outer.contains(&node) { *x } else { std::array::from_fn(|axis| x[axis] + off(axis)) }
    };
    let coordinates = (0..).zip(regular.coordinates()).map(shifted).collect();
    cut_into(&moved(&regular, coordinates), shape)
}

/// A unit cube of eight: below two hexes and two that are cut into wedges, above four that are cut into pyramids and tets
/// round their centres. Inner nodes are moved. With the elements that are no tets, and the tets.
pub fn mixed_cube() -> (Mesh, [Vec<u32>; 2]) {
    let cubes = bricks([1.0; 3], [2; 3]);
    let mut coordinates = cubes.coordinates().to_vec();
    coordinates[13] = [0.53, 0.46, 0.55];
    let (mut solids, mut tets) = (Elements::default(), Elements::default());
    for (cube, nodes) in cubes.elements().iter().enumerate() {
        let [a, b, c, d, e, f, g, h]: [u32; 8] = nodes.try_into().unwrap();
        match cube {
            0 | 3 => solids.push(Shape::Hex8, nodes),
            1 | 2 => {
                solids.push(Shape::Wedge6, &[a, b, c, e, f, g]);
                solids.push(Shape::Wedge6, &[a, c, d, e, g, h]);
            }
            _ => {
                let centre = coordinates.len() as u32;
                let mean = |axis: usize| nodes.iter().map(|&n| coordinates[n as usize][axis]).sum::<f64>() / 8.0;
                coordinates.push([mean(0) + 0.03, mean(1) - 0.02, mean(2) + 0.04]);
                for face in cubes.elements().faces(cube) {
                    let [p, q, r, s]: [u32; 4] = face.nodes().try_into().unwrap();
                    let is_on_hex = face.key() == Face::from([a, b, c, d]).key() && (cube == 4 || cube == 7);
                    if is_on_hex {
                        solids.push(Shape::Pyramid5, &[p, s, r, q, centre]);
                        continue;
                    }
                    // as the wedges are cut, from the least node
                    let mut quad = [p, q, r, s];
                    let first = (0..4).min_by_key(|&k| quad[k]).unwrap();
                    quad.rotate_left(first);
                    let [p, q, r, s] = quad;
                    tets.push(Shape::Tet4, &[p, r, q, centre]);
                    tets.push(Shape::Tet4, &[p, s, r, centre]);
                }
            }
        }
    }
    let (count, all) = (solids.len() as u32, (solids.len() + tets.len()) as u32);
    tets.iter().for_each(|nodes| solids.push(Shape::Tet4, nodes));
    (mesh_of(coordinates, solids), [(0..count).collect(), (count..all).collect()])
}

/// Seven hexes in a unit cube: the outer eight nodes are 0 to 7, the inner hex has the nodes 8 to 15, nowhere a
/// parallelepiped (the coordinates of MacNeal & Harder 1985).
pub fn patch_of_seven() -> Mesh {
    let outer = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];
    let inner = [
        [0.249, 0.342, 0.192],
        [0.826, 0.288, 0.288],
        [0.850, 0.649, 0.263],
        [0.273, 0.750, 0.230],
        [0.320, 0.186, 0.643],
        [0.677, 0.305, 0.683],
        [0.788, 0.693, 0.644],
        [0.165, 0.745, 0.702],
    ];
    let coordinates = outer.map(|x| x.map(f64::from)).into_iter().chain(inner).collect();
    let faces = [[0, 1, 2, 3], [4, 7, 6, 5], [0, 4, 5, 1], [3, 2, 6, 7], [0, 3, 7, 4], [1, 5, 6, 2]];
    // each face of the outer cube with the same face of the inner one
    let around = faces.map(|[a, b, c, d]: [u32; 4]| [a, b, c, d, a + 8, b + 8, c + 8, d + 8]);
    let hexes: Vec<[u32; 8]> = [[8, 9, 10, 11, 12, 13, 14, 15]].into_iter().chain(around).collect();
    mesh_of(coordinates, hexes)
}

/// One part of all hexes.
pub fn whole(mesh: &Mesh, material: MaterialModel, element: Formulation) -> Vec<Part> {
    vec![Part { elements: (0..mesh.element_count() as u32).collect(), material, element }]
}

pub fn until(end: f64) -> TimeSettings {
    TimeSettings { end, ..TimeSettings::default() }
}

pub fn translation(mesh: &Mesh, velocity: [f64; 3]) -> InitialVelocity {
    InitialVelocity { nodes: all_nodes(mesh), translation: velocity, spin: None }
}

pub fn spinning(mesh: &Mesh, velocity: [f64; 3], spin: Spin) -> InitialVelocity {
    InitialVelocity { nodes: all_nodes(mesh), translation: velocity, spin: Some(spin) }
}

pub fn prescribed(nodes: Vec<u32>, direction: Direction, quantity: Quantity, curve: Curve) -> Prescribed {
    Prescribed { nodes, direction, quantity, curve }
}

pub fn load(name: &str, kind: LoadKind) -> Load {
    Load { name: name.to_owned(), kind }
}

/// From 0 at time 0 smoothly to `value` at time `end`.
pub fn ramp(end: f64, value: f64) -> Curve {
    Curve::new(vec![[0.0, 0.0], [end, value]], Interpolation::Smooth).unwrap()
}

pub fn new(mesh: &Mesh, model: Model) -> Simulation {
    Simulation::new(mesh, model, LaneLevel::best()).unwrap()
}

/// Copper of Johnson and Cook, which its own flow heats, and its specific heat, J/(kg K).
pub fn heated_copper(elasticity: &IsotropicElasticity) -> (JohnsonCook, f64) {
    let law = JohnsonCook::new(JohnsonCookParameters {
        a: 90e6,
        b: 292e6,
        n: 0.31,
        c: 0.025,
        m: 1.09,
        reference_rate: 1.0,
        reference_temperature: 293.0,
        melting_temperature: 1356.0,
    });
    let specific_heat = 383.0;
    let heating = AdiabaticHeating { specific_heat, taylor_quinney: 0.9, initial_temperature: 300.0 };
    (law.unwrap().with_heating(heating, elasticity).unwrap(), specific_heat)
}

/// Runs to the end, in one thread, and shows every state to `visit`.
pub fn run(simulation: &mut Simulation, mut visit: impl FnMut(&Simulation) + Send) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        while !simulation.is_finished() {
            simulation.advance().unwrap();
            visit(simulation);
        }
    });
}

/// Cauchy stress of every hex.
pub fn stresses(simulation: &Simulation) -> Vec<[f64; 6]> {
    let mut stresses = vec![[0.0; 6]; simulation.element_count()];
    simulation.write_means(ElementMeans { cauchy_stress: Some(&mut stresses), ..ElementMeans::default() });
    stresses
}

pub fn norm(vector: [f64; 3]) -> f64 {
    dot(vector, vector).sqrt()
}

pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

#[track_caller]
pub fn assert_close(value: f64, expected: f64, tolerance: f64) {
    assert!((value - expected).abs() <= tolerance, "{value} instead of {expected} ± {tolerance}");
}
