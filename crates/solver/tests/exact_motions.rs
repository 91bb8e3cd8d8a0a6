//! Goal: motions whose answer is known exactly.
//!
//! Mesh: one brick, a cube of a few, or an irregular patch of seven hexes. Loading: prescribed motion, gravity, spin.
//! Source: closed forms.

mod common;

use common::{
    DIRECTIONS, ELEMENTS, FORMULATIONS, all_nodes, assert_close, bricks, cut_bricks, elastic, irregular_cube, load,
    mesh_of, minus, mixed_cube, new, norm, on_unit_cube, patch_of_seven, prescribed, ramp, run, spinning, steel,
    stresses, translation, until, whole, yielding,
};
use estar_material::{MaterialModel, ObjectiveRate};
use estar_mesh::generate::cut_into;
use estar_mesh::{Mesh, Shape};
use estar_solver::model::{
    Direction, Formulation, InitialVelocity, LoadKind, Part, Prescribed, Quantity, Spin, TimeSettings,
};
use estar_solver::{Curve, Interpolation, Model, Simulation};
use estar_tensor::{Rotation, SymmetricTensor, Tensor, Vector3};
use std::f64::consts::PI;

/// Moves `nodes` along straight lines between the maps of a path, X ↦ F X at each time.
fn along(mesh: &Mesh, nodes: &[u32], path: &[(f64, Tensor<f64>)]) -> Vec<Prescribed> {
    let mut driven = Vec::new();
    for &node in nodes {
        let x = Vector3(mesh.coordinates()[node as usize]);
        for direction in DIRECTIONS {
            let displacement = |map: &Tensor<f64>| (map.apply(x) - x).0[direction.index()];
            let points = path.iter().map(|(time, map)| [*time, displacement(map)]).collect();
            let curve = Curve::new(points, Interpolation::Linear).unwrap();
            driven.push(prescribed(vec![node], direction, Quantity::Displacement, curve));
        }
    }
    driven
}

/// Initial velocities v = G X.
fn homogeneous_velocity(mesh: &Mesh, gradient: &Tensor<f64>) -> Vec<InitialVelocity> {
    let velocity = |node: u32| gradient.apply(Vector3(mesh.coordinates()[node as usize])).0;
    let entry = |node| InitialVelocity { nodes: vec![node], translation: velocity(node), spin: None };
    all_nodes(mesh).into_iter().map(entry).collect()
}

/// Patch test: an irregular patch of seven hexes whose outer nodes follow a uniform velocity gradient. The inner nodes
/// are free and must follow, and stress must be uniform, elastic and plastic.
///
/// Source: Irons' patch test as Belytschko, Liu & Moran pose it for dynamics, with the patch of MacNeal & Harder (1985).
#[test]
fn patch_test_inner_nodes_follow_and_stress_is_uniform() {
    let end = 3e-4;
    let mut patches = vec![(patch_of_seven(), (0..8).collect())];
    patches.extend([Shape::Wedge6, Shape::Tet4, Shape::Tet10].map(irregular_cube).map(|mesh| {
        let outer = on_unit_cube(&mesh);
        (mesh, outer)
    }));
    let unit = |i: usize, j: usize| {
        let mut gradient = Tensor::zero();
        gradient.columns[j].0[i] = 0.01;
        gradient
    };
    let mut gradients: Vec<Tensor<f64>> = (0..9).map(|k| unit(k / 3, k % 3)).collect();
    gradients.push(Tensor::from_rows([[0.2, 0.3, -0.1], [-0.4, -0.1, 0.1], [0.2, 0.1, -0.05]]));
    for gradient in gradients {
        for (mesh, outer) in &patches {
            for (formulation, shape) in ELEMENTS {
                if shape == mesh.elements().shape(0) {
                    for material in [elastic(), yielding(300e6, 1e9)] {
                        assert_patch(mesh, outer, whole(mesh, material, formulation), &gradient, end);
                    }
                }
            }
        }
    }
}

/// The same of a cube of hexes, wedges, pyramids and tets, each formulation of wedges with the four-node tet.
#[test]
fn patch_test_holds_where_shapes_meet() {
    let (mesh, [solids, tets]) = mixed_cube();
    let outer = on_unit_cube(&mesh);
    let gradient = Tensor::from_rows([[0.2, 0.3, -0.1], [-0.4, -0.1, 0.1], [0.2, 0.1, -0.05]]);
    for element in FORMULATIONS.into_iter().filter(|element| *element != Formulation::FBar) {
        for material in [elastic(), yielding(300e6, 1e9)] {
            let solids = Part { elements: solids.clone(), material: material.clone(), element };
            let tets = Part { elements: tets.clone(), material, element: Formulation::Tet4 };
            assert_patch(&mesh, &outer, vec![solids, tets], &gradient, 3e-4);
        }
    }
}

fn assert_patch(mesh: &Mesh, outer: &[u32], parts: Vec<Part>, gradient: &Tensor<f64>, end: f64) {
    let name = format!("{:?} {:?} {gradient:?}", parts[0].element, mesh.elements().shape(0));
    let model = Model {
        parts,
        prescribed: along(mesh, outer, &[(0.0, Tensor::identity()), (end, Tensor::identity() + *gradient)]),
        initial_velocities: homogeneous_velocity(mesh, &(*gradient * (1.0 / end))),
        settings: until(end),
        ..Model::default()
    };
    let mut simulation = new(mesh, model);
    run(&mut simulation, |_| ());
    for (x, u) in mesh.coordinates().iter().zip(simulation.displacement()) {
        let expected = gradient.apply(Vector3(*x)).0;
        assert!(norm(minus(*u, expected)) < 1e-12, "{name}: {u:?} {expected:?}");
    }
    let stresses = stresses(&simulation);
    let first = SymmetricTensor(stresses[0]);
    for stress in stresses {
        let difference = SymmetricTensor(stress) - first;
        let relative = (difference.norm_squared() / first.norm_squared()).sqrt();
        assert!(relative < 1e-10, "{name}: {relative:e}");
    }
    // the ledger is of second order in the step, and each element has its own
    let error = simulation.energies().error() * (simulation.step() as f64).powi(2);
    assert!(error.abs() < 0.2, "{name}: {error}");
}

/// One distorted hex, whole or cut into other shapes, falls freely from rest: u = ½ g t², v = g t, at every step, whatever its length. The lumped mass is
/// right, and the ledger holds from the first step on.
#[test]
fn one_free_brick_falls_with_exactly_g() {
    let patch = patch_of_seven();
    let acceleration = [0.3, -4.0, -9.81];
    let hex = || mesh_of(patch.coordinates()[8..].to_vec(), vec![[0, 1, 2, 3, 4, 5, 6, 7]]);
    for (formulation, shape) in ELEMENTS {
        let mesh = cut_into(&hex(), shape);
        let model = Model {
            parts: whole(&mesh, elastic(), formulation),
            loads: vec![load("gravity", LoadKind::Gravity { acceleration })],
            settings: TimeSettings { energy_error_limit: 1e-9, ..until(5e-3) },
            ..Model::default()
        };
        let mut simulation = new(&mesh, model);
        let mass: f64 = simulation.mass().iter().sum();
        run(&mut simulation, |now| {
            let time = now.time();
            for i in 0..3 {
                let (u, v) = (0.5 * acceleration[i] * time * time, acceleration[i] * time);
                let tolerance = |value: f64| 1e-12 * value.abs();
                for (node, displacement) in now.displacement().iter().enumerate() {
                    let velocity = now.velocity(node);
                    assert_close(displacement[i], u, tolerance(u));
                    assert_close(velocity[i], v, tolerance(v));
                }
                assert_close(now.momentum()[i], mass * v, tolerance(mass * v));
            }
            let work = 0.5 * mass * (norm(acceleration) * time).powi(2);
            assert_close(now.energies().load_work[0], work, 1e-12 * work);
            assert!(now.energies().error().abs() < 1e-12, "{}", now.energies().error());
        });
        assert_eq!(simulation.time(), 5e-3);
    }
}

/// A cube spun at 105 rad/s about an oblique axis while it flies, for one turn.
///
/// Source: Newton's laws; the case is that of NimbleSM's and Sierra's momentum tests.
#[test]
fn a_spinning_cube_keeps_its_momenta_and_its_energy() {
    for (formulation, shape) in ELEMENTS {
        assert_spinning(&cut_bricks([0.1; 3], [2; 3], shape), formulation);
    }
}

fn assert_spinning(mesh: &Mesh, formulation: Formulation) {
    let rate = [1.0, 2.0, 2.0].map(|c| 105.0 * c / 3.0);
    let end = std::f64::consts::TAU / 105.0;
    let start = {
        let model = Model {
            parts: whole(mesh, elastic(), formulation),
            initial_velocities: vec![spinning(mesh, [3.0, 0.0, -1.0], Spin { rate, centre: [0.05; 3] })],
            settings: until(end),
            ..Model::default()
        };
        new(mesh, model)
    };
    let mut simulation = start;
    let (momentum, angular) = (simulation.momentum(), simulation.angular_momentum());
    let energy = simulation.energies().initial_kinetic;
    let (mut momentum_drift, mut angular_drift, mut energy_drift) = (0.0_f64, 0.0_f64, 0.0_f64);
    run(&mut simulation, |now| {
        momentum_drift = momentum_drift.max(norm(minus(now.momentum(), momentum)) / norm(momentum));
        angular_drift = angular_drift.max(norm(minus(now.angular_momentum(), angular)) / norm(angular));
        let total = now.energies().kinetic + now.energies().internal + now.energies().integration;
        energy_drift = energy_drift.max((total / energy - 1.0).abs());
    });
    println!(
        "spin, {formulation:?} {}: {} steps, {momentum_drift:e} {angular_drift:e} {energy_drift:e}",
        mesh.elements().shape(0),
        simulation.step()
    );
    assert!(momentum_drift < 1e-12, "{momentum_drift:e}");
    assert!(angular_drift < 1e-12, "{angular_drift:e}");
    assert!(energy_drift < 1e-3, "{energy_drift:e}");
    // one turn later every corner of hexes is where it was, moved with the centre (the cube is a little wider: centrifugal
    // strain); the masses of other shapes have no such symmetry, and the cube tumbles
    let is_symmetric = mesh.elements().shape(0) == Shape::Hex8;
    for u in simulation.displacement().iter().filter(|_| is_symmetric) {
        let flown = [3.0 * end, 0.0, -end];
        assert!(norm(minus(*u, flown)) < 1e-5, "{u:?}");
    }
}

/// Stretch, then a rigid turn by 150° between two instants that lie within one step: Cauchy stress turns with the body
/// and the rotated stress keeps its value to rounding.
///
/// Source: the box rate in mid-step form (de Vera 2016, section 6.5; Hughes & Winget 1980 for the incremental idea).
#[test]
fn a_rotation_of_150_degrees_in_one_step_turns_the_stress_with_the_body() {
    let stretch = Tensor::from_rows([[1.003, 0.001, 0.0], [0.002, 0.998, 0.001], [0.0, -0.001, 1.001]]);
    let turn = Rotation::about([1.0, -2.0, 0.5], 150_f64.to_radians()).to_tensor();
    let (pulled, end) = (2e-6, 4e-6);
    let path = [
        (0.0, Tensor::identity()),
        (pulled, stretch),
        (3e-6, stretch),
        (3e-6 + 1e-12, turn.dot(&stretch)),
        (end, turn.dot(&stretch)),
    ];
    for (formulation, shape) in ELEMENTS {
        let mesh = cut_bricks([1e-3; 3], [1; 3], shape);
        let model = Model {
            parts: whole(&mesh, elastic(), formulation),
            prescribed: along(&mesh, &all_nodes(&mesh), &path),
            settings: until(end),
            ..Model::default()
        };
        let mut simulation = new(&mesh, model);
        let mut before = [0.0; 6];
        run(&mut simulation, |now| {
            if now.time() < 3e-6 {
                before = stresses(now)[0];
            }
        });
        let after = SymmetricTensor(stresses(&simulation)[0]);
        let expected = SymmetricTensor(before).pushed_by(&turn);
        let error = ((after - expected).norm_squared() / expected.norm_squared()).sqrt();
        println!("turn: {error:e}");
        // a strain is rounded at 10⁻¹⁶ times the size of the step, Δt L = 2 tan 75°, beside an elastic strain of 10⁻³
        assert!(expected.norm_squared() > 1e16 && error < 1e-11, "{error:e}");
    }
}

/// T₁₁ and T₁₂ over μ in elastic simple shear F = I + γ e₁⊗e₂ (T₂₂ = −T₁₁) with the rates that elements can have.
///
/// Source: the closed forms of the box rate with tan β = γ/2 (Dienes 1979; de Vera 2016, section 6.5),
/// T₁₂ = 2μ cos 2β (2β − 2 tan 2β ln cos β − tan β), T₁₁ = 4μ (cos 2β ln cos β + β sin 2β − sin² β), of Jaumann's and of
/// the logarithmic rate (Xiao, Bruhns & Meyers 1997).
fn sheared(rate: ObjectiveRate, gamma: f64) -> [f64; 2] {
    let half = 0.5 * gamma;
    match rate {
        ObjectiveRate::Box => {
            let b = half.atan();
            let (ln_cos, (sine, cosine)) = (b.cos().ln(), (2.0 * b).sin_cos());
            // cos 2β tan 2β = sin 2β, which has no pole at γ = 2
            let t12 = 2.0 * (cosine * (2.0 * b - b.tan()) - 2.0 * sine * ln_cos);
            [4.0 * (cosine * ln_cos + b * sine - b.sin() * b.sin()), t12]
        }
        ObjectiveRate::Jaumann => [1.0 - gamma.cos(), gamma.sin()],
        ObjectiveRate::Logarithmic => {
            let t12 = 2.0 * half.asinh() / half.hypot(1.0);
            [half * t12, t12]
        }
        other => panic!("no element has the rate {other:?}"),
    }
}

/// One hex, whole or cut into other shapes, driven at all its nodes, up to γ = 10.
#[test]
fn simple_shear_to_ten_meets_the_closed_form_of_every_rate() {
    // figures that others printed for γ = 1, 2 and 5
    for (rate, figures) in [
        (ObjectiveRate::Box, [[0.415900, 0.869784], [PI - 2.0, 2.0 * 2_f64.ln()], [2.704319, 2.905369]]),
        (ObjectiveRate::Jaumann, [[0.459698, 0.841471], [1.416147, 0.909297], [0.716338, -0.958924]]),
        (ObjectiveRate::Logarithmic, [[0.430409, 0.860818], [1.246450, 1.246450], [3.058831, 1.223533]]),
    ] {
        for (gamma, [t11, t12]) in [1.0, 2.0, 5.0].into_iter().zip(figures) {
            let [a, b] = sheared(rate, gamma);
            assert!((a - t11).abs() < 1e-6 && (b - t12).abs() < 1e-6);
        }
        for (formulation, shape) in ELEMENTS {
            assert_sheared(rate, formulation, shape);
        }
    }
}

fn assert_sheared(rate: ObjectiveRate, formulation: Formulation, shape: Shape) {
    let mesh = cut_bricks([1e-3; 3], [1; 3], shape);
    let shear_modulus = steel().shear_modulus();
    let end = 1e-3;
    let top: Vec<u32> = mesh.group("y_max").unwrap().nodes.clone();
    let sheared_node = |node: u32| {
        let shear =
            Curve::new(vec![[0.0, 0.0], [end, 10.0 * mesh.coordinates()[node as usize][1]]], Interpolation::Linear);
        prescribed(vec![node], Direction::X, Quantity::Displacement, shear.unwrap())
    };
    let mut driven: Vec<Prescribed> = all_nodes(&mesh).into_iter().map(sheared_node).collect();
    for direction in [Direction::Y, Direction::Z] {
        driven.push(prescribed(all_nodes(&mesh), direction, Quantity::Displacement, Curve::constant(0.0)));
    }
    let model = Model {
        parts: whole(&mesh, MaterialModel::hypoelastic(steel(), rate), formulation),
        prescribed: driven,
        settings: until(end),
        ..Model::default()
    };
    let mut simulation = new(&mesh, model);
    let mut worst = 0.0_f64;
    run(&mut simulation, |now| {
        let gamma = 1e3 * now.displacement()[top[0] as usize][0];
        let [t11, t12] = sheared(rate, gamma);
        let stress = stresses(now)[0].map(|component| component / shear_modulus);
        let expected = [t11, -t11, 0.0, t12, 0.0, 0.0];
        for (component, expected) in stress.iter().zip(expected) {
            worst = worst.max((component - expected).abs() / gamma.max(0.1));
        }
    });
    println!("shear, {rate:?} {formulation:?} {shape}: {} steps, {worst:e}", simulation.step());
    assert!(worst < 1e-6, "{rate:?}: {worst:e}");
    assert!(simulation.energies().error().abs() < 1e-6, "{}", simulation.energies().error());
}

/// Nodes driven by a displacement, a velocity and an acceleration are where the curve and its integrals say.
#[test]
fn prescribed_motions_meet_their_curves() {
    let mesh = bricks([2e-3, 1e-3, 1e-3], [2, 1, 1]);
    let end = 1e-5;
    let group = |name: &str| mesh.group(name).unwrap().nodes.clone();
    let displacement = ramp(0.8 * end, 1e-5);
    let velocity = Curve::new(vec![[0.0, 1.0], [0.3 * end, -0.5], [end, 2.0]], Interpolation::Linear).unwrap();
    let acceleration = Curve::new(vec![[0.1 * end, 1e5], [0.7 * end, -3e5]], Interpolation::Smooth).unwrap();
    let driven = vec![
        prescribed(group("x_min"), Direction::X, Quantity::Displacement, displacement.clone()),
        prescribed(group("x_max"), Direction::Y, Quantity::Velocity, velocity.clone()),
        prescribed(group("x_max"), Direction::Z, Quantity::Acceleration, acceleration.clone()),
    ];
    let model = Model {
        parts: whole(&mesh, elastic(), Formulation::FBar),
        prescribed: driven,
        settings: TimeSettings { safety_factor: 0.05, ..until(end) },
        ..Model::default()
    };
    let (left, right) = (group("x_min")[0] as usize, group("x_max")[0] as usize);
    let check = |now: &Simulation| {
        let time = now.time();
        let u = now.displacement();
        assert_close(u[left][0], displacement.value(time), 1e-19);
        assert_close(u[right][1], velocity.integral(time), 1e-19);
        assert_close(u[right][2], acceleration.double_integral(time), 1e-19);
        // velocity and acceleration follow by differences, of second order in the step
        assert_close(now.velocity(right)[1], velocity.value(time), 0.02);
        assert_close(now.velocity(right)[2], acceleration.integral(time), 0.01);
    };
    let mut simulation = new(&mesh, model);
    run(&mut simulation, check);
    assert_close(simulation.acceleration()[right][2], -3e5, 1e3);
}

/// A body that nothing acts on flies straight, and no energy moves.
#[test]
fn free_flight_changes_nothing_but_the_place() {
    let mesh = patch_of_seven();
    let model = Model {
        parts: whole(&mesh, yielding(300e6, 1e9), Formulation::FBar),
        initial_velocities: vec![translation(&mesh, [100.0, -40.0, 7.0])],
        settings: until(1e-3),
        ..Model::default()
    };
    let mut simulation = new(&mesh, model);
    run(&mut simulation, |_| ());
    for u in simulation.displacement() {
        assert!(norm(minus(*u, [0.1, -0.04, 0.007])) < 1e-12);
    }
    let energies = simulation.energies();
    assert!(energies.internal.abs() < 1e-15 * energies.kinetic);
    assert!(energies.error().abs() < 1e-13);
}
