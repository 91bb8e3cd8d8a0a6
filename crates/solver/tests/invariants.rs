//! Goal: the same bits for any number of threads and lanes, the same body however it is cut into parts, and an answer to
//! every wrong model and every run that cannot go on.
//!
//! Mesh: a block of 1,053 bricks, and of such cut into wedges and tets, three chunks of elements (the last of 29) and two of nodes, none a multiple of the
//! lanes; and single bricks. Source: the invariants that ARCHITECTURE.md states.

mod common;

use common::{
    DIRECTIONS, ELEMENTS, FORMULATIONS, all_nodes, bricks, cut_bricks, elastic, elasticity, faces, load, mesh_of,
    minus, nodes, norm, prescribed, ramp, run, stresses, translation, until, whole, yielding,
};
use estar_material::{EStarTotal, Elastic, Hencky, IsotropicHardening, MaterialModel};
use estar_mesh::{Mesh, Shape};
use estar_solver::model::{
    BulkViscosity, Direction, Fix, Formulation, InitialVelocity, LoadKind, Part, Prescribed, Quantity, RigidWall,
    TimeSettings, WallMotion, WallShape,
};
use estar_solver::{ConstraintSource, Curve, Interpolation, LaneLevel, Model, ModelError, Simulation, SimulationError};

const WALL: RigidWall = RigidWall::plane([0.0; 3], [0.0, 0.0, 1.0], 0.2);

/// A block that yields on a rough wall, with every kind of load and constraint; of three materials, the last two of 3 and
/// 1 hexes. In four-node tets the last is the first again, so that two parts share volume changes.
fn crash(mesh: &Mesh) -> Model {
    let hexes: Vec<u32> = (0..mesh.element_count() as u32).collect();
    let hardening = IsotropicHardening::saturation(300e6, 500e6, 10.0, 1e8).unwrap();
    let last = if mesh.elements().shape(0) == Shape::Tet4 { yielding(300e6, 1e9) } else { elastic() };
    let materials = [yielding(300e6, 1e9), EStarTotal::new(elasticity(7850.0, 200e9, 0.3), hardening).into(), last];
    let (most, last) = hexes.split_at(hexes.len() - 4);
    let parts = [most, &last[..3], &last[3..]].into_iter().zip(materials);
    let formulations = match mesh.elements().shape(0) {
        Shape::Tet4 => [Formulation::Tet4; 3],
        Shape::Tet10 => [Formulation::Tet10; 3],
        Shape::Hex8 => [Formulation::FBar, Formulation::FBar, Formulation::Full],
        _ => [Formulation::BBar, Formulation::BBar, Formulation::Full],
    };
    Model {
        parts: parts
            .zip(formulations)
            .map(|((hexes, material), element)| Part { elements: hexes.to_vec(), material, element })
            .collect(),
        fixes: vec![Fix { nodes: nodes(mesh, "x_min"), directions: vec![Direction::X] }],
        prescribed: vec![prescribed(nodes(mesh, "y_min"), Direction::Y, Quantity::Displacement, ramp(5e-6, 1e-5))],
        initial_velocities: vec![translation(mesh, [0.0, 0.0, -200.0])],
        loads: vec![
            load("gravity", LoadKind::Gravity { acceleration: [0.0, 0.0, -9.81] }),
            load("pressure", LoadKind::Pressure { faces: faces(mesh, "x_max"), curve: ramp(5e-6, 1e7) }),
            load(
                "traction",
                LoadKind::Traction {
                    faces: faces(mesh, "z_max"),
                    direction: [0.0, 1.0, 0.0],
                    curve: Curve::constant(1e7),
                },
            ),
        ],
        walls: vec![WALL],
        settings: TimeSettings { bulk_viscosity: Some(BulkViscosity { linear: 0.06, quadratic: 1.2 }), ..until(5e-6) },
    }
}

/// FNV-1a over the bits of every number of the state, and the steps.
fn state_after_crash(mesh: &Mesh, level: LaneLevel, threads: usize) -> (u64, u64) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        let mut simulation = Simulation::new(mesh, crash(mesh), level).unwrap();
        while !simulation.is_finished() {
            simulation.advance().unwrap();
        }
        assert!(simulation.extremes().max_equivalent_plastic_strain > 0.01);
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        simulation.for_each_number(|number| hash = (hash ^ number.to_bits()).wrapping_mul(0x0100_0000_01b3));
        (hash, simulation.step())
    })
}

#[test]
fn a_step_moves_as_many_bytes_on_any_lanes_and_more_with_more_history() {
    let mesh = bricks([1.0, 1.0, 1.0], [4, 4, 4]);
    let bytes = |material: &MaterialModel, level| {
        let model = Model {
            parts: whole(&mesh, material.clone(), Formulation::FBar),
            settings: until(1.0),
            ..Model::default()
        };
        Simulation::new(&mesh, model, level).unwrap().bytes_per_step()
    };
    // the number of hexes is a multiple of the lanes: no pack is filled up
    for material in [elastic(), yielding(300e6, 1e9)] {
        for level in LaneLevel::ALL {
            assert_eq!(bytes(&material, level), bytes(&material, LaneLevel::Portable), "{level:?}");
        }
    }
    // ε̄ᵖ of eight points, read and written
    let [elastic, yielding] = [elastic(), yielding(300e6, 1e9)].map(|material| bytes(&material, LaneLevel::best()));
    assert_eq!(yielding - elastic, mesh.element_count() * 8 * 2 * 8);
}

#[test]
fn threads_and_lanes_do_not_change_a_bit() {
    let cut = [Shape::Wedge6, Shape::Tet4, Shape::Tet10].map(|shape| cut_bricks([5e-3, 5e-3, 7e-3], [5, 5, 7], shape));
    for mesh in [bricks([9e-3, 9e-3, 13e-3], [9, 9, 13])].into_iter().chain(cut) {
        let expected = state_after_crash(&mesh, LaneLevel::best(), 1);
        println!("crash: {} steps", expected.1);
        for threads in [2, 3, 7] {
            assert_eq!(state_after_crash(&mesh, LaneLevel::best(), threads), expected, "{threads} threads");
        }
        for level in LaneLevel::ALL {
            if level.is_available() {
                assert_eq!(state_after_crash(&mesh, level, 2), expected, "{level:?}");
            } else {
                eprintln!("{level:?} is not available on this machine: not compared");
            }
        }
    }
}

/// The numbers of the state half way, taken up by another simulation with other lanes and threads, lead to the end that
/// the straight way leads to, and every number that users see of it is the same.
#[test]
fn a_state_taken_up_by_another_simulation_ends_in_the_same_bits() {
    for shape in [Shape::Hex8, Shape::Wedge6, Shape::Tet4, Shape::Tet10] {
        assert_taken_up(&cut_bricks([4e-3, 4e-3, 6e-3], [4, 4, 6], shape));
    }
}

fn assert_taken_up(mesh: &Mesh) {
    let bits = |simulation: &Simulation| {
        let mut bits = Vec::new();
        simulation.for_each_number(|number| bits.push(number.to_bits()));
        bits
    };
    let seen = |simulation: &Simulation| {
        let (energies, extremes) = (simulation.energies().clone(), simulation.extremes());
        let mut volume_ratios = vec![0.0; simulation.element_count()];
        simulation.write_volume_ratio(&mut volume_ratios);
        let fields = (stresses(simulation), volume_ratios);
        (energies, extremes, simulation.momentum(), simulation.time_step(), simulation.step(), fields)
    };
    let leg = |level, threads, start: Option<&[u64]>, steps: u64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut simulation = Simulation::new(mesh, crash(mesh), level).unwrap();
            if let Some(numbers) = start {
                let mut numbers = numbers.iter();
                simulation.restore(|| f64::from_bits(*numbers.next().unwrap())).unwrap();
                assert!(numbers.next().is_none());
            }
            while simulation.step() < steps && !simulation.is_finished() {
                simulation.advance().unwrap();
            }
            simulation
        })
    };
    let straight = leg(LaneLevel::best(), 2, None, u64::MAX);
    for (first, second) in [(LaneLevel::best(), LaneLevel::Portable), (LaneLevel::Portable, LaneLevel::best())] {
        for steps in [0, 1, straight.step() / 2, straight.step()] {
            let start = leg(first, 1, None, steps);
            let taken_up = leg(second, 3, Some(&bits(&start)), steps);
            assert!(bits(&taken_up) == bits(&start), "{steps} steps");
            assert_eq!(seen(&taken_up), seen(&start), "{steps} steps");
            let end = leg(second, 3, Some(&bits(&start)), u64::MAX);
            assert!(bits(&end) == bits(&straight), "{steps} steps");
            assert_eq!(seen(&end), seen(&straight), "{steps} steps");
        }
    }
}

/// The state does not depend on how the mesh is cut into parts of the same material, some with fewer elements than lanes,
/// but for the order of sums.
#[test]
fn cutting_a_body_into_parts_changes_nothing_but_rounding() {
    for (formulation, shape) in ELEMENTS {
        assert_cut_changes_nothing(formulation, &cut_bricks([4e-3, 4e-3, 6e-3], [4, 4, 6], shape));
    }
}

fn assert_cut_changes_nothing(formulation: Formulation, mesh: &Mesh) {
    let moved = |cuts: &[u32]| {
        let ends = cuts.iter().copied().chain([mesh.element_count() as u32]);
        let mut start = 0;
        let mut parts = Vec::new();
        for end in ends {
            let hexes = (start..end).rev().collect();
            parts.push(Part { elements: hexes, material: yielding(300e6, 1e9), element: formulation });
            start = end;
        }
        let model = Model {
            parts,
            initial_velocities: vec![translation(mesh, [20.0, 0.0, -200.0])],
            walls: vec![WALL],
            settings: until(5e-6),
            ..Model::default()
        };
        let mut simulation = Simulation::new(mesh, model, LaneLevel::best()).unwrap();
        run(&mut simulation, |_| ());
        simulation.displacement().to_vec()
    };
    let expected = moved(&[]);
    for cuts in [&[1][..], &[3, 5, 6, 40], &[8, 16, 95]] {
        for (u, expected) in moved(cuts).iter().zip(&expected) {
            let difference = norm(minus(*u, *expected));
            // of displacements of 1 mm; contact and hourglass control amplify what rounding has begun
            assert!(difference < 1e-12 * 1e-3, "{formulation:?}, {cuts:?}: {u:?} {expected:?}");
        }
    }
}

/// What a model of one brick gets for an answer after `change`.
fn refused(change: impl FnOnce(&mut Model)) -> ModelError {
    let mesh = bricks([1.0; 3], [2, 1, 1]);
    let mut model =
        Model { parts: whole(&mesh, elastic(), Formulation::FBar), settings: until(1e-3), ..Model::default() };
    assert!(Simulation::new(&mesh, model.clone(), LaneLevel::best()).is_ok());
    change(&mut model);
    Simulation::new(&mesh, model, LaneLevel::best()).err().expect("a model that is refused")
}

fn fix(nodes: &[u32], directions: &[Direction]) -> Fix {
    Fix { nodes: nodes.to_vec(), directions: directions.to_vec() }
}

#[test]
fn indices_beyond_the_mesh_are_refused() {
    let beyond = |what| ModelError::OutOfRange { what, index: 12, count: 12 };
    assert_eq!(refused(|model| model.fixes.push(fix(&[12], &DIRECTIONS))), beyond("a fix"));
    let driven = || prescribed(vec![0, 12], Direction::X, Quantity::Velocity, Curve::constant(1.0));
    assert_eq!(refused(|model| model.prescribed.push(driven())), beyond("a prescribed motion"));
    let velocity = InitialVelocity { nodes: vec![12], translation: [0.0; 3], spin: None };
    assert_eq!(refused(|model| model.initial_velocities.push(velocity)), beyond("an initial velocity"));
    let pressure = LoadKind::Pressure { faces: vec![[0, 1, 2, 12].into()], curve: Curve::constant(1.0) };
    assert_eq!(refused(|model| model.loads.push(load("p", pressure))), beyond("a load"));
    let hex = ModelError::OutOfRange { what: "a part", index: 2, count: 2 };
    assert_eq!(refused(|model| model.parts[0].elements.push(2)), hex);
}

#[test]
fn parts_must_own_every_hex_once() {
    assert_eq!(refused(|model| model.parts[0].elements.clear()), ModelError::EmptyPart { part: 0 });
    assert_eq!(
        refused(|model| model.parts[0].elements = vec![1]),
        ModelError::ElementWithoutPart { count: 1, first: 0 }
    );
    let twice = |model: &mut Model| model.parts.push(Part { elements: vec![1], ..model.parts[0].clone() });
    assert_eq!(refused(twice), ModelError::ElementInTwoParts { element: 1, first: 0, second: 1 });
    let again = |model: &mut Model| model.parts[0].elements.push(0);
    assert_eq!(refused(again), ModelError::ElementInTwoParts { element: 0, first: 0, second: 0 });
}

#[test]
fn a_part_of_other_shapes_than_its_formulation_is_made_for_is_refused() {
    let wrong = refused(|model| model.parts[0].element = Formulation::Tet10);
    assert_eq!(wrong, ModelError::WrongShape { part: 0, element: 0, shape: Shape::Hex8 });
    let mesh = cut_bricks([1.0; 3], [1; 3], Shape::Tet4);
    for element in FORMULATIONS.into_iter().chain([Formulation::Tet10]) {
        let model = Model { parts: whole(&mesh, elastic(), element), settings: until(1.0), ..Model::default() };
        let error = Simulation::new(&mesh, model, LaneLevel::best()).err();
        assert_eq!(error, Some(ModelError::WrongShape { part: 0, element: 0, shape: Shape::Tet4 }));
    }
}

#[test]
fn two_motions_of_one_direction_are_refused_unless_they_are_the_same() {
    let conflict = |model: &mut Model| {
        model.fixes.push(fix(&[3], &[Direction::Y]));
        model.prescribed.push(prescribed(vec![3], Direction::Y, Quantity::Velocity, Curve::constant(1.0)));
    };
    let (first, second) = (ConstraintSource::Fix(0), ConstraintSource::Prescribed(0));
    let expected = ModelError::ConflictingConstraints { node: 3, direction: Direction::Y, first, second };
    assert_eq!(refused(conflict), expected);
    let two = |model: &mut Model| {
        for value in [1.0, 2.0] {
            model.prescribed.push(prescribed(vec![3], Direction::X, Quantity::Velocity, Curve::constant(value)));
        }
    };
    assert!(matches!(refused(two), ModelError::ConflictingConstraints { node: 3, direction: Direction::X, .. }));
    // fixed twice, or driven twice alike, on an edge that two groups share
    let mesh = bricks([1.0; 3], [1; 3]);
    let alike: Prescribed = prescribed(vec![0, 1], Direction::Z, Quantity::Velocity, Curve::constant(1.0));
    let model = Model {
        parts: whole(&mesh, elastic(), Formulation::FBar),
        fixes: vec![fix(&[0, 1], &[Direction::X]), fix(&[1, 2], &[Direction::X])],
        prescribed: vec![alike.clone(), alike],
        settings: until(1e-3),
        ..Model::default()
    };
    assert!(Simulation::new(&mesh, model, LaneLevel::best()).is_ok());
}

#[test]
fn walls_and_directions_must_make_sense() {
    let behind = |model: &mut Model| {
        model.walls.push(RigidWall::plane([0.0, 0.0, 0.25], [0.0, 0.0, 1.0], 0.0));
    };
    assert_eq!(refused(behind), ModelError::NodeBehindWall { wall: 0, count: 6, node: 0, depth: 0.25 });
    let long = |model: &mut Model| model.walls.push(RigidWall::plane([0.0; 3], [0.0, 0.0, 2.0], 0.0));
    assert_eq!(refused(long), ModelError::NotUnit { what: "normal of a rigid wall" });
    let traction = |model: &mut Model| {
        let kind =
            LoadKind::Traction { faces: vec![[0, 1, 4, 3].into()], direction: [0.0; 3], curve: Curve::constant(1.0) };
        model.loads.push(load("t", kind));
    };
    assert_eq!(refused(traction), ModelError::NotUnit { what: "direction of a traction" });
    for friction in [-0.1, f64::NAN] {
        let rough = |model: &mut Model| model.walls.push(RigidWall { friction, ..WALL });
        assert!(matches!(refused(rough), ModelError::Setting { setting: "friction", .. }));
    }
    for radius in [0.0, -1.0, f64::NAN] {
        let shape = WallShape::Sphere { centre: [0.0, 0.0, 9.0], radius };
        let hollow = |model: &mut Model| model.walls.push(RigidWall { shape, ..WALL });
        assert!(matches!(refused(hollow), ModelError::Setting { setting: "radius", .. }));
    }
    let shape = WallShape::Cylinder { point: [0.0, 0.0, 9.0], axis: [0.0; 3], radius: 1.0 };
    let flat = |model: &mut Model| model.walls.push(RigidWall { shape, ..WALL });
    assert_eq!(refused(flat), ModelError::NotUnit { what: "axis of a rigid cylinder" });
    let motion = WallMotion { direction: [0.0; 3], quantity: Quantity::Velocity, curve: Curve::constant(1.0) };
    let lost = |model: &mut Model| model.walls.push(RigidWall { motion: Some(motion.clone()), ..WALL });
    assert_eq!(refused(lost), ModelError::NotUnit { what: "direction of a rigid wall's motion" });
}

#[test]
fn settings_out_of_bounds_are_refused_by_name() {
    let setting =
        |change: fn(&mut TimeSettings, f64), value: f64| match refused(|model| change(&mut model.settings, value)) {
            ModelError::Setting { setting, .. } => setting,
            other => panic!("{other}"),
        };
    for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(setting(|settings, value| settings.end = value, value), "end");
        assert_eq!(setting(|settings, value| settings.energy_error_limit = value, value), "energy_error_limit");
    }
    for value in [0.0, 1.1, f64::NAN] {
        assert_eq!(setting(|settings, value| settings.safety_factor = value, value), "safety_factor");
    }
    for value in [-0.1, f64::NAN] {
        let viscosity = |linear, quadratic| Some(BulkViscosity { linear, quadratic });
        let linear = refused(|model| model.settings.bulk_viscosity = viscosity(value, 1.0));
        assert!(matches!(linear, ModelError::Setting { setting: "linear", .. }));
        let quadratic = refused(|model| model.settings.bulk_viscosity = viscosity(0.06, value));
        assert!(matches!(quadratic, ModelError::Setting { setting: "quadratic", .. }));
    }
}

#[test]
fn hexes_without_volume_and_nodes_without_mass_are_refused() {
    let of = |mesh: &Mesh| {
        let parts = whole(mesh, elastic(), Formulation::FBar);
        let model = Model { parts, settings: until(1e-3), ..Model::default() };
        Simulation::new(mesh, model, LaneLevel::best()).err().expect("a mesh that is refused")
    };
    let cube = bricks([1.0; 3], [1; 3]);
    let upside_down: [u32; 8] = cube.elements().nodes(0).try_into().unwrap();
    let [a, b, c, d, e, f, g, h] = upside_down;
    let inverted = mesh_of(cube.coordinates().to_vec(), vec![[e, f, g, h, a, b, c, d]]);
    assert!(matches!(of(&inverted), ModelError::BadElement { element: 0, value, .. } if value < 0.0));
    let flat = mesh_of(cube.coordinates().iter().map(|x| [x[0], x[1], 0.0]).collect(), cube.elements().clone());
    assert!(matches!(of(&flat), ModelError::BadElement { element: 0, value: 0.0, .. }));
    let mut coordinates = cube.coordinates().to_vec();
    coordinates.push([2.0; 3]);
    let lonely = mesh_of(coordinates, cube.elements().clone());
    assert_eq!(of(&lonely), ModelError::NodeWithoutMass { count: 1, first: 8 });
    // volumes of such lengths are numbers, products of areas and moduli are not
    let huge = mesh_of(cube.coordinates().iter().map(|x| x.map(|x| 1e100 * x)).collect(), cube.elements().clone());
    assert_eq!(of(&huge), ModelError::NotFinite { element: 0 });
    // one corner pushed far in: the points still have volume, a corner has no mass left or the centre none
    for depth in (0..100).map(|i| 0.01 * f64::from(i)) {
        let mut coordinates = cube.coordinates().to_vec();
        coordinates[7] = [1.0 - depth; 3];
        let dented = mesh_of(coordinates, cube.elements().clone());
        let parts = whole(&dented, elastic(), Formulation::FBar);
        let model = Model { parts, settings: until(1e-6), ..Model::default() };
        match Simulation::new(&dented, model, LaneLevel::best()) {
            Ok(simulation) => assert!(simulation.extremes().stable_time_step > 0.0),
            Err(error) => assert!(matches!(error, ModelError::BadElement { element: 0, value, .. } if value <= 0.0)),
        }
    }
}

/// A soft brick crushed by prescribed motion turns inside out: the run ends with the hex and its Jacobian, in every
/// material, formulation and number of lanes, and never in a panic.
#[test]
fn a_crushed_brick_ends_the_run_as_inverted() {
    let mesh = bricks([1.0, 1.0, 3.0], [1, 1, 3]);
    let hardening = IsotropicHardening::perfect(1e4).unwrap();
    let soft = elasticity(1000.0, 1e6, 0.3);
    let materials: [MaterialModel; 3] = [
        Elastic::new(soft).into(),
        EStarTotal::new(soft, hardening.clone()).into(),
        Hencky::von_mises(soft, hardening).into(),
    ];
    for material in materials {
        for element in [Formulation::Full, Formulation::FBar] {
            for level in LaneLevel::ALL {
                // the upper two bricks are turned inside out together, whatever the middle does
                let curve = Curve::new(vec![[0.0, 0.0], [1.0, -6.0]], Interpolation::Linear).unwrap();
                let model = Model {
                    parts: whole(&mesh, material.clone(), element),
                    fixes: vec![fix(&nodes(&mesh, "z_min"), &DIRECTIONS)],
                    prescribed: vec![prescribed(nodes(&mesh, "z_max"), Direction::Z, Quantity::Displacement, curve)],
                    settings: TimeSettings { energy_error_limit: 1e9, ..until(1.0) },
                    ..Model::default()
                };
                let mut simulation = Simulation::new(&mesh, model, level).unwrap();
                let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
                let mut steps = 0;
                let error = pool.install(|| {
                    loop {
                        steps += 1;
                        if steps > 100_000 {
                            panic!("no end");
                        }
                        if let Err(error) = simulation.advance() {
                            break error;
                        }
                    }
                });
                match error {
                    SimulationError::ElementInverted { element, jacobian, step, time } => {
                        assert!(element < 3 && jacobian <= 0.0 && step > 0 && time > 0.0 && time < 1.0);
                    }
                    other => panic!("{element:?} {level:?}: {other}"),
                }
            }
        }
    }
}

/// Places and forces that overflow end the run, and an energy that is not a number is never within the limit.
#[test]
fn values_that_are_not_finite_end_the_run() {
    let mesh = bricks([1.0; 3], [1; 3]);
    let run = |model: Model| {
        let mut simulation = Simulation::new(&mesh, model, LaneLevel::best()).unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        pool.install(|| {
            loop {
                if let Err(error) = simulation.advance() {
                    break error;
                }
                assert!(simulation.step() < 1000);
            }
        })
    };
    let model = Model { parts: whole(&mesh, elastic(), Formulation::FBar), settings: until(1.0), ..Model::default() };
    let flung = Model { initial_velocities: vec![translation(&mesh, [1e300, 0.0, 0.0])], ..model.clone() };
    // so far away that all corners are rounded to one place
    let error = run(flung);
    assert!(matches!(error, SimulationError::ElementInverted { jacobian: 0.0, .. }), "{error}");
    let gravity = LoadKind::Gravity { acceleration: [f64::NAN, 0.0, 0.0] };
    let error = run(Model { loads: vec![load("gravity", gravity)], ..model });
    assert!(matches!(error, SimulationError::NotFinite { .. } | SimulationError::EnergyError { .. }), "{error}");
}

#[test]
fn an_energy_error_over_the_limit_ends_the_run() {
    let mesh = bricks([4e-3, 4e-3, 12e-3], [2, 2, 4]);
    let model = Model {
        parts: whole(&mesh, yielding(400e6, 100e6), Formulation::FBar),
        initial_velocities: vec![translation(&mesh, [0.0, 0.0, -300.0])],
        walls: vec![WALL],
        settings: TimeSettings { energy_error_limit: 1e-9, ..until(20e-6) },
        ..Model::default()
    };
    let mut simulation = Simulation::new(&mesh, model, LaneLevel::best()).unwrap();
    let error = loop {
        if let Err(error) = simulation.advance() {
            break error;
        }
    };
    assert!(matches!(error, SimulationError::EnergyError { error, limit: 1e-9, .. } if error.abs() > 1e-9), "{error}");
}

/// The last step ends at the end, and no step before it is cut to a sliver.
#[test]
fn the_last_step_ends_at_the_end() {
    let mesh = bricks([1e-3; 3], [1; 3]);
    for end in [1e-9, 3.7e-7, 1e-6] {
        let model =
            Model { parts: whole(&mesh, elastic(), Formulation::FBar), settings: until(end), ..Model::default() };
        let mut simulation = Simulation::new(&mesh, model, LaneLevel::best()).unwrap();
        let stable = 0.9 * simulation.extremes().stable_time_step;
        let mut least = f64::INFINITY;
        run(&mut simulation, |now| least = least.min(now.time_step()));
        assert_eq!(simulation.time(), end);
        assert!(least >= 0.499 * stable.min(2.0 * end), "{least} {stable}");
        assert_eq!(all_nodes(&mesh).len(), simulation.displacement().len());
    }
}
