//! Goal: tets, and hexes some of whose corners fall together, do what their shape functions say, and the bound behind their
//! stable time step is safe and not wasteful.
//!
//! Mesh: one element; hundreds of distorted shapes. Materials from auxetic to nearly incompressible.
//!
//! Source: the exact step is that of the largest eigenvalue of M^{-½} K M^{-½}, where K comes column by column out of the shipped
//! element: the forces of a motion along one degree of freedom, with the mean over neighbours that one `tet4` by itself has none
//! of. By faer.

mod common;

use common::{DENSITY, Driven, Random, elasticity};
use estar_element::element::{Element, ElementMotion, ElementStep, OwnHistory};
use estar_element::hex8::Formulation;
use estar_element::hex8_one_point::HourglassControl;
use estar_element::tet4::{self, Tet4};
use estar_element::tet10::Tet10;
use estar_material::{Elastic, IsotropicElasticity};
use estar_tensor::{Tensor, Vector3};
use faer::Mat;

/// ν from auxetic to nearly incompressible.
const POISSON_RATIOS: [f64; 4] = [-0.5, 0.0, 0.3, 0.4999];
/// Edges of the ten-node tet in the order of its middle nodes.
const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

type Nodes<const NODES: usize> = [[f64; 3]; NODES];

/// Forces on the nodes of an elastic element that is moved by `motion` (m), and its stable time step.
fn forces<const NODES: usize, E: Element<NODES>>(
    element: E,
    nodes: &Nodes<NODES>,
    elasticity: &IsotropicElasticity,
    motion: &[Vector3<f64>; NODES],
) -> ([Vector3<f64>; NODES], f64) {
    let material = Elastic::new(*elasticity);
    let reference = nodes.map(Vector3);
    let time_step = 1.0;
    let masses = E::lumped_mass(&reference, elasticity.density());
    let corner_mass = masses.into_iter().fold(f64::INFINITY, f64::min);
    let position = std::array::from_fn(|node| reference[node] + motion[node]);
    let moved = ElementMotion { reference, position, velocity: *motion, corner_mass };
    let mut driven = Driven::<_, _, f64, NODES>::new(element, &material);
    if let Some(shared) = driven.history.own.neighbourhood_mut() {
        // an element without neighbours has its own volume change
        let of_tet = |field: &[Vector3<f64>; NODES]| std::array::from_fn(|node| field[node]);
        let moved = ElementMotion {
            reference: of_tet(&moved.reference),
            position: of_tet(&moved.position),
            velocity: of_tet(&moved.velocity),
            corner_mass,
        };
        let volumes = tet4::volumes(&moved, time_step);
        shared.jacobian = volumes.now / volumes.reference;
        shared.increment = volumes.change / volumes.half;
    }
    let step = ElementStep { bulk_viscosity: None, time_step };
    let update = driven.advance(&moved, &step);
    let mut forces = update.internal_force;
    if let Some(shared) = driven.history.own.neighbourhood() {
        let position = std::array::from_fn(|node| moved.position[node]);
        let of_mean_stress = tet4::mean_stress_forces(&position, shared.mean_stress);
        forces.iter_mut().zip(of_mean_stress).for_each(|(force, other)| *force = *force + other);
    }
    (forces, update.stable_time_step)
}

/// Stiffness over mass of the degrees of freedom that `places` leaves: corners with the same place are one node.
fn operator<const NODES: usize, E: Element<NODES>>(
    element: E,
    nodes: &Nodes<NODES>,
    places: &[usize; NODES],
    elasticity: &IsotropicElasticity,
) -> Mat<f64> {
    let count = places.iter().max().unwrap() + 1;
    let size = nodes.iter().flatten().fold(0.0_f64, |size, c| size.max(c.abs()));
    let masses = E::lumped_mass(&nodes.map(Vector3), DENSITY);
    let mut mass = vec![0.0; count];
    places.iter().zip(masses).for_each(|(&place, of_corner)| mass[place] += of_corner);
    let mut stiffness = Mat::<f64>::zeros(3 * count, 3 * count);
    for column in 0..3 * count {
        let amount = 1e-7 * size;
        let along = |sign: f64| {
            let mut motion = [Vector3([0.0; 3]); NODES];
            for (corner, place) in places.iter().enumerate() {
                if *place == column / 3 {
                    motion[corner].0[column % 3] = sign * amount;
                }
            }
            forces(element, nodes, elasticity, &motion).0
        };
        let (there, back) = (along(1.0), along(-1.0));
        for (corner, &place) in places.iter().enumerate() {
            for i in 0..3 {
                stiffness[(3 * place + i, column)] += (there[corner].0[i] - back[corner].0[i]) / (2.0 * amount);
            }
        }
    }
    Mat::from_fn(3 * count, 3 * count, |row, column| {
        stiffness[(row, column)] / (mass[row / 3] * mass[column / 3]).sqrt()
    })
}

/// How much of the exactly stable time step the bound leaves.
fn share<const NODES: usize, E: Element<NODES>>(
    element: E,
    nodes: &Nodes<NODES>,
    places: &[usize; NODES],
    elasticity: &IsotropicElasticity,
) -> f64 {
    let operator = operator(element, nodes, places, elasticity);
    let exact = operator.singular_values().unwrap().into_iter().fold(0.0, f64::max);
    let (_, step) = forces(element, nodes, elasticity, &[Vector3([0.0; 3]); NODES]);
    let share = step * exact.sqrt() / 2.0;
    assert!(share <= 1.0 + 1e-6, "{share}, nu = {}, {nodes:?}", elasticity.poisson_ratio());
    share
}

/// The least and the median share of many shapes, for ν of [`POISSON_RATIOS`].
fn shares<const NODES: usize, E: Element<NODES>>(
    name: &str,
    element: E,
    shapes: &[Nodes<NODES>],
    places: &[usize; NODES],
) -> [[f64; 2]; 4] {
    let kept = POISSON_RATIOS.map(|poisson_ratio| {
        let elasticity = elasticity(poisson_ratio);
        let mut shares: Vec<f64> = shapes.iter().map(|shape| share(element, shape, places, &elasticity)).collect();
        shares.sort_by(f64::total_cmp);
        [shares[0], shares[shares.len() / 2]]
    });
    println!("{name}: least and median {kept:.3?}");
    kept
}

/// The parent element with moved nodes, stretched up to 10 : 1 in each direction, sheared and turned; all with positive
/// Jacobians. The middles of edges are moved by a third of what corners are.
fn distorted<const NODES: usize, E: Element<NODES>>(
    count: usize,
    places: &[usize; NODES],
    random: &mut Random,
) -> Vec<Nodes<NODES>> {
    let mut shapes = Vec::with_capacity(count);
    while shapes.len() < count {
        let amount = random.between(0.0, 0.5);
        let mut nodes = E::PARENT;
        for (corner, node) in nodes.iter_mut().enumerate() {
            let amount = if NODES == 10 && corner >= 4 { 0.3 * amount } else { amount };
            *node = node.map(|c| c + random.between(-amount, amount));
        }
        if NODES == 10 {
            for (middle, [a, b]) in EDGES.into_iter().enumerate() {
                let (off, parent) = (nodes[4 + middle], E::PARENT[4 + middle]);
                nodes[4 + middle] = std::array::from_fn(|i| 0.5 * (nodes[a][i] + nodes[b][i]) + off[i] - parent[i]);
            }
        }
        // corners that are one node are in one place
        let first = |place: usize| places.iter().position(|other| *other == place).unwrap();
        let nodes: Nodes<NODES> = std::array::from_fn(|corner| nodes[first(places[corner])]);
        let mut map = random.tensor(0.5);
        (0..3).for_each(|i| map.columns[i].0[i] += 1.0);
        let stretch: [f64; 3] = std::array::from_fn(|_| 10_f64.powf(random.between(-1.0, 0.0)));
        let nodes = nodes.map(|x| map.apply(Vector3(std::array::from_fn(|i| stretch[i] * x[i]))).0);
        let is_usable = E::smallest_jacobian(&nodes.map(Vector3)) > 0.0
            && E::lumped_mass(&nodes.map(Vector3), 1.0).iter().all(|mass| *mass > 0.0);
        if is_usable {
            shapes.push(nodes);
        }
    }
    shapes
}

#[test]
fn bounds_of_tets_hold_for_hundreds_of_distorted_ones() {
    let tets = distorted::<4, Tet4>(300, &[0, 1, 2, 3], &mut Random::new(1));
    let kept = shares("tet4", Tet4, &tets, &[0, 1, 2, 3]);
    assert!(kept.iter().all(|[least, median]| *least > 0.86 && *median > 0.87), "{kept:?}");
    let places = std::array::from_fn(|node| node);
    let tets = distorted::<10, Tet10>(100, &places, &mut Random::new(2));
    let kept = shares("tet10", Tet10, &tets, &places);
    assert!(kept.iter().all(|[least, median]| *least > 0.4 && *median > 0.6), "{kept:?}");
}

/// Wedges and pyramids as collapsed hexes: the bound of the hex holds over the motions that are left.
#[test]
fn bounds_of_hexes_hold_where_corners_fall_together() {
    for (name, places) in [("wedge", [0, 1, 2, 2, 3, 4, 5, 5]), ("pyramid", [0, 1, 2, 3, 4, 4, 4, 4])] {
        let shapes = distorted::<8, Formulation>(100, &places, &mut Random::new(3));
        for formulation in [Formulation::Full, Formulation::BBar] {
            let kept = shares(&format!("{name}, {formulation:?}"), formulation, &shapes, &places);
            assert!(kept.iter().all(|[least, _]| *least > 0.1), "{kept:?}");
        }
        shares(&format!("{name}, one point"), HourglassControl::Physical, &shapes, &places);
    }
}

/// The bounds are nearly exact for regular tets, which for `tet10` is κ = 20/3.
#[test]
fn bounds_of_regular_tets_are_close() {
    let regular = [[-1.0, -1.0, -1.0], [-1.0, 1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, -1.0]];
    for poisson_ratio in [0.0, 0.3, 0.4999] {
        let kept = share(Tet4, &regular, &[0, 1, 2, 3], &elasticity(poisson_ratio));
        assert!(kept > 0.95, "tet4, nu = {poisson_ratio}: {kept}");
        let kept = share(Tet10, &Tet10::PARENT, &std::array::from_fn(|node| node), &elasticity(poisson_ratio));
        assert!(kept > 0.99, "tet10, nu = {poisson_ratio}: {kept}");
    }
}

/// A linear motion of a tet of any shape has its gradient at every point: the forces are those of its uniform stress on the
/// faces of the twelve tets, or of the one.
#[test]
fn uniform_stress_pulls_at_the_faces() {
    let elasticity = elasticity(0.3);
    let mut random = Random::new(5);
    let strain = Tensor::from_rows([[2e-6, 1e-6, 0.0], [1e-6, -1e-6, 3e-6], [0.0, 3e-6, 1e-6]]);
    let (shear, lambda) =
        (elasticity.shear_modulus(), elasticity.bulk_modulus() - elasticity.shear_modulus() * 2.0 / 3.0);
    let stress = strain * (2.0 * shear) + Tensor::identity() * (lambda * 2e-6);
    let straight = |mut nodes: Nodes<10>| {
        for (middle, [a, b]) in EDGES.into_iter().enumerate() {
            nodes[4 + middle] = std::array::from_fn(|i| 0.5 * (nodes[a][i] + nodes[b][i]));
        }
        nodes
    };
    for shape in distorted::<10, Tet10>(20, &std::array::from_fn(|node| node), &mut random).into_iter().map(straight) {
        let motion = shape.map(|x| strain.apply(Vector3(x)));
        let (forces, _) = forces(Tet10, &shape, &elasticity, &motion);
        let x = |node: usize| Vector3(shape[node]);
        for (corner, [a, b, c]) in [[1, 3, 2], [0, 2, 3], [0, 3, 1], [0, 1, 2]].into_iter().enumerate() {
            // the three faces at a corner have the opposite one's area vector, outwards from the corner's side: a twelfth each
            let opposite = (x(b) - x(a)).cross(x(c) - x(a)) * (0.5 / 12.0);
            let expected = stress.apply(opposite);
            let size = expected.dot(expected).sqrt();
            for i in 0..3 {
                let difference = (forces[corner].0[i] - expected.0[i]).abs();
                assert!(difference < 1e-4 * size, "corner {corner}: {:?} {expected:?}", forces[corner]);
            }
        }
    }
}
