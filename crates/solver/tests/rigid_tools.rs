//! Rigid tools: what they push, what they hold, what they cost.
//!
//! Goal: a tool that moves does to a body what mechanics says it must, and the ledger knows of every joule.
//! Mesh: bricks with mean dilatation, whose forces do the work of their stress. Loading: planes, spheres and cylinders along curves. Source: momentum balance, d'Alembert's wave, Coulomb.

mod common;

use common::{
    DIRECTIONS, assert_close, bricks, dot, elastic, elasticity, minus, new, nodes, norm, ramp, run, steel, translation,
    until, whole, yielding,
};
use estar_material::Elastic;
use estar_solver::model::{Direction, Fix, Formulation, LoadKind, Quantity, RigidWall, WallMotion, WallShape};
use estar_solver::{Curve, Interpolation, Model, Simulation, SimulationError};

const DOWN: [f64; 3] = [0.0, 0.0, -1.0];

fn steadily(direction: [f64; 3], speed: f64) -> Option<WallMotion> {
    let curve = Curve::new(vec![[0.0, speed]], Interpolation::Linear).unwrap();
    Some(WallMotion { direction, quantity: Quantity::Velocity, curve })
}

fn places(simulation: &Simulation) -> impl Iterator<Item = [f64; 3]> {
    let nodes = simulation.reference().iter().zip(simulation.displacement());
    nodes.map(|(x, u)| std::array::from_fn(|i| x[i] + u[i]))
}

/// A block between a still plane and one that comes down on it, both rough.
fn press(friction: f64) -> Model {
    let mesh = block();
    let height = 10e-3;
    let motion = Some(WallMotion { direction: DOWN, quantity: Quantity::Displacement, curve: ramp(100e-6, 3e-3) });
    let upper = RigidWall { motion, ..RigidWall::plane([0.0, 0.0, height], DOWN, friction) };
    Model {
        parts: whole(&mesh, yielding(300e6, 500e6), Formulation::BBar),
        walls: vec![RigidWall::plane([0.0; 3], [0.0, 0.0, 1.0], friction), upper],
        settings: until(100e-6),
        ..Model::default()
    }
}

fn block() -> estar_mesh::Mesh {
    bricks([8e-3, 6e-3, 10e-3], [4, 3, 5])
}

/// A plane pushes the end of a rod that cannot bulge at constant speed: until the wave comes back the stress behind its front
/// is ρ c v, so that the force is A ρ c v. Source: d'Alembert's solution, with c² = (λ + 2μ)/ρ.
#[test]
fn a_plane_at_constant_speed_pushes_with_the_force_of_the_wave() {
    let (length, side, speed) = (100e-3, 1e-3, 1.0);
    let mesh = bricks([length, side, side], [200, 1, 1]);
    let all: Vec<u32> = (0..mesh.node_count() as u32).collect();
    let impedance = (steel().density() * steel().p_wave_modulus()).sqrt();
    let wave_speed = impedance / steel().density();
    let wall =
        RigidWall { motion: steadily([1.0, 0.0, 0.0], speed), ..RigidWall::plane([0.0; 3], [1.0, 0.0, 0.0], 0.0) };
    let model = Model {
        parts: whole(&mesh, elastic(), Formulation::BBar),
        fixes: vec![Fix { nodes: all, directions: vec![Direction::Y, Direction::Z] }],
        walls: vec![wall],
        settings: until(1.5 * length / wave_speed),
        ..Model::default()
    };
    let mut simulation = new(&mesh, model);
    let mut pushed = 0.0;
    run(&mut simulation, |now| pushed += now.wall_force(0)[0] * now.time_step());
    let expected = side * side * impedance * speed * simulation.end_time();
    println!("impulse {pushed:e} of {expected:e}, {:?}", simulation.energies());
    assert_close(pushed, expected, 0.01 * expected);
    // all that the wall does but what its first blow loses is in the rod
    let work = simulation.energies().external_work();
    assert_close(work, expected * speed, 0.01 * expected * speed);
    assert!(simulation.energies().contact < 0.01 * work, "{:?}", simulation.energies());
    assert!(simulation.energies().error().abs() < 1e-3, "{}", simulation.energies().error());
}

/// The force of the tools is all that changes the momentum of a free body.
#[test]
fn tools_give_the_momentum_that_the_body_gets() {
    let mesh = block();
    let mut simulation = new(&mesh, press(0.2));
    let mut impulse = [0.0; 3];
    // F_n acts from t_{n−½} to t_{n+½}; momentum is that of t_n
    let mut half_before = [0.0; 3];
    let mut worst = 0.0_f64;
    run(&mut simulation, |now| {
        let force: [f64; 3] = std::array::from_fn(|i| now.wall_force(0)[i] + now.wall_force(1)[i]);
        let half = force.map(|component| 0.5 * now.time_step() * component);
        impulse = std::array::from_fn(|i| impulse[i] + half_before[i] + half[i]);
        half_before = half;
        worst = worst.max(norm(minus(now.momentum(), impulse)) / now.mass().iter().sum::<f64>());
    });
    // steps change a little from one to the next: to second order
    println!("worst {worst:e} m/s");
    assert!(worst < 0.02, "{worst:e}");
}

/// Nothing penetrates, friction takes a part of what contact takes, and every joule has a row.
#[test]
fn a_rough_press_balances_and_nothing_penetrates() {
    let mesh = block();
    for friction in [0.0, 0.1, f64::INFINITY] {
        let model = press(friction);
        let walls = model.walls.clone();
        let mut simulation = new(&mesh, model);
        let (mut worst, mut deepest) = (0.0_f64, 0.0_f64);
        run(&mut simulation, |now| {
            worst = worst.max(now.energies().error().abs());
            let gaps = || places(now).flat_map(|place| walls.iter().map(move |wall| wall.gap(&place, now.time())));
            deepest = gaps().fold(deepest, f64::min);
        });
        let energies = simulation.energies();
        println!("friction {friction}: error {worst:e}, depth {deepest:e} m, {energies:?}");
        assert!(worst < 1e-5, "{friction}: {worst:e}");
        assert!(deepest > -1e-15, "{friction}: {deepest:e}");
        assert!(energies.external_work() > 0.0 && energies.wall_work[0] == 0.0, "{energies:?}");
        assert!(energies.friction <= energies.contact + 1e-12 * energies.external_work(), "{energies:?}");
        // what sticks does not slide, but for the moment at which it is caught
        let share = energies.friction / energies.external_work();
        match friction {
            0.0 => assert_eq!(share, 0.0),
            0.1 => assert!(share > 0.01, "{share}"),
            _ => assert!((0.0..2e-3).contains(&share), "{share}"),
        }
    }
}

#[test]
fn what_sticks_to_a_platen_stays_where_it_is() {
    let mesh = block();
    let mut simulation = new(&mesh, press(f64::INFINITY));
    let lower = nodes(&mesh, "z_min");
    run(&mut simulation, |_| {});
    let slid = lower.iter().map(|&node| {
        let [x, y, _] = simulation.displacement()[node as usize];
        x.hypot(y)
    });
    let most = slid.fold(0.0, f64::max);
    println!("slid {most:e} m");
    assert!(most == 0.0, "{most:e}");
    let free =
        nodes(&mesh, "x_max").iter().map(|&node| simulation.displacement()[node as usize][0]).fold(0.0, f64::max);
    assert!(free > 0.5e-3, "{free:e}");
}

/// A body thrown on a plane at rest, and the plane thrown on the body at rest, are one problem seen by two observers.
#[test]
fn a_moving_plane_is_a_moving_body_seen_by_another() {
    let mesh = block();
    let (speed, end) = (100.0, 10e-6);
    let at_rest = RigidWall::plane([0.0; 3], [0.0, 0.0, 1.0], 0.3);
    let velocity = [20.0, 0.0, -speed];
    let material = || whole(&mesh, yielding(300e6, 500e6), Formulation::BBar);
    let thrown = Model {
        parts: material(),
        initial_velocities: vec![translation(&mesh, velocity)],
        walls: vec![at_rest.clone()],
        settings: until(end),
        ..Model::default()
    };
    let motion = steadily(velocity.map(|v| -v / norm(velocity)), norm(velocity));
    let struck = Model {
        parts: material(),
        walls: vec![RigidWall { motion, ..at_rest }],
        settings: until(end),
        ..Model::default()
    };
    let [thrown, struck] = [thrown, struck].map(|model| {
        let mut simulation = new(&mesh, model);
        run(&mut simulation, |_| {});
        simulation
    });
    for (moved, stood) in thrown.displacement().iter().zip(struck.displacement()) {
        let seen = minus(*moved, velocity.map(|v| v * end));
        assert!(norm(minus(seen, *stood)) < 1e-9 * speed * end, "{seen:?} {stood:?}");
    }
    let (a, b) = (thrown.energies(), struck.energies());
    assert_close(b.internal, a.internal, 1e-9 * a.internal);
    assert_close(b.contact, a.contact, 1e-9 * a.contact);
    assert_close(b.friction, a.friction, 1e-9 * a.friction);
}

/// A sphere and a cylinder are pressed into a block: no node enters them, and the balance closes.
#[test]
fn curved_tools_indent_without_penetration() {
    let mesh = bricks([10e-3, 10e-3, 6e-3], [6, 6, 4]);
    let radius = 4e-3;
    let above = 6e-3 + radius;
    let sphere = WallShape::Sphere { centre: [5e-3, 5e-3, above], radius };
    let cylinder = WallShape::Cylinder { point: [5e-3, 0.0, above], axis: [0.0, 1.0, 0.0], radius };
    for shape in [sphere, cylinder] {
        let motion = Some(WallMotion { direction: DOWN, quantity: Quantity::Displacement, curve: ramp(60e-6, 1e-3) });
        let tool = RigidWall { shape, friction: 0.1, motion };
        let model = Model {
            parts: whole(&mesh, yielding(300e6, 500e6), Formulation::BBar),
            fixes: vec![Fix { nodes: nodes(&mesh, "z_min"), directions: DIRECTIONS.to_vec() }],
            walls: vec![tool.clone()],
            settings: until(60e-6),
            ..Model::default()
        };
        let mut simulation = new(&mesh, model);
        let (mut worst, mut deepest, mut touching) = (0.0_f64, 0.0_f64, 0);
        run(&mut simulation, |now| {
            worst = worst.max(now.energies().error().abs());
            deepest = places(now).map(|place| tool.gap(&place, now.time())).fold(deepest, f64::min);
            touching = places(now).filter(|place| tool.gap(place, now.time()) < 1e-9).count();
        });
        println!(
            "{shape:?}: error {worst:e}, depth {deepest:e} m, {touching} nodes touch, {:?}",
            simulation.energies()
        );
        assert!(worst < 5e-5, "{worst:e}");
        assert!(deepest > -1e-15, "{deepest:e}");
        assert!(touching >= 3, "{touching}");
        // the body pushes back
        assert!(dot(simulation.wall_force(0), DOWN) > 0.0);
    }
}

/// A block of 1 kg that gravity of 10 m/s² presses on a rough floor of μ = 0.2, moving along x at 1 m/s and along y at `sideways`.
fn on_a_rough_floor(sideways: f64, motion: Option<WallMotion>) -> (estar_mesh::Mesh, Model) {
    let mesh = bricks([0.1, 0.1, 0.05], [2, 2, 1]);
    let material = Elastic::new(elasticity(2000.0, 10e6, 0.0)).into();
    let speed = if motion.is_some() { 0.0 } else { 1.0 };
    let model = Model {
        parts: whole(&mesh, material, Formulation::BBar),
        prescribed: vec![common::prescribed(
            common::all_nodes(&mesh),
            Direction::X,
            Quantity::Velocity,
            Curve::constant(speed),
        )],
        initial_velocities: vec![translation(&mesh, [speed, sideways, 0.0])],
        loads: vec![common::load("weight", LoadKind::Gravity { acceleration: [0.0, 0.0, -10.0] })],
        walls: vec![RigidWall { motion, ..RigidWall::plane([0.0; 3], [0.0, 0.0, 1.0], 0.2) }],
        settings: until(0.3),
        ..Model::default()
    };
    (mesh, model)
}

/// Impulse of the floor and of what drives the block along x, N s.
fn impulses(simulation: &mut Simulation, nodes: &[u32]) -> ([f64; 3], f64) {
    let (mut floor, mut drive) = ([0.0; 3], 0.0);
    run(simulation, |now| {
        let force = now.wall_force(0);
        floor = std::array::from_fn(|i| floor[i] + now.time_step() * force[i]);
        drive += now.time_step() * now.reaction(nodes, Direction::X);
    });
    (floor, drive)
}

/// A block that is drawn over a rough floor takes μ N, and friction takes μ N v t. After dart #809.
#[test]
fn a_driven_block_is_drawn_against_the_friction_of_the_floor() {
    let (mesh, model) = on_a_rough_floor(0.0, None);
    let mut simulation = new(&mesh, model);
    let (floor, drive) = impulses(&mut simulation, &common::all_nodes(&mesh));
    // the block rings on the floor: impulses over 0.3 s, not forces
    assert_close(floor[2], 3.0, 0.02 * 3.0);
    assert_close(floor[0], -0.2 * floor[2], 1e-3 * floor[2]);
    assert_close(drive, -floor[0], 1e-3 * drive);
    let energies = simulation.energies();
    println!("{energies:?}");
    assert_close(energies.friction, drive, 1e-3 * drive);
    assert_close(energies.external_work() - energies.load_work[0], drive, 1e-3 * drive);
    assert!(energies.error().abs() < 1e-3, "{}", energies.error());
}

/// Friction acts against the whole sliding: of μ N the share v_y/v is along y. Source: dv_y/dt = −μ g v_y/√(1 + v_y²), so that
/// √(1 + v_y²) − asinh(1/v_y) falls by μ g t.
#[test]
fn a_driven_block_slips_sideways_slowly() {
    let (mesh, model) = on_a_rough_floor(0.1, None);
    let mut simulation = new(&mesh, model);
    run(&mut simulation, |_| {});
    let [_, y, _] = simulation.momentum();
    let law = |v: f64| v.hypot(1.0) - v.recip().asinh();
    let fallen = law(0.1) - law(y);
    println!("v_y {y:e} m/s, fallen by {fallen}");
    assert_close(fallen, 0.2 * 10.0 * 0.3, 0.02 * 0.6);
}

/// A belt under a held block: μ N on the block, which the constraint takes, and all that the belt does is friction.
#[test]
fn a_belt_under_a_held_block_rubs() {
    let (mesh, model) = on_a_rough_floor(0.0, steadily([1.0, 0.0, 0.0], 1.0));
    let mut simulation = new(&mesh, model);
    let (floor, drive) = impulses(&mut simulation, &common::all_nodes(&mesh));
    assert_close(floor[0], 0.2 * floor[2], 1e-3 * floor[2]);
    assert_close(drive, -floor[0], 1e-3 * floor[0]);
    let energies = simulation.energies();
    assert_close(energies.friction, floor[0], 1e-3 * floor[0]);
    assert_close(energies.wall_work[0], floor[0], 1e-3 * floor[0]);
    assert_eq!(energies.constraint_work, 0.0);
}

/// A bar on its edge falls into a groove of two walls at 120° that is as symmetric as the bar: no node gets behind a wall, both
/// walls give the same impulse, and their order does not matter. After taichi_mpm #8.
#[test]
fn a_groove_of_walls_is_as_good_as_its_mirror_image() {
    let square = bricks([10e-3, 10e-3, 10e-3], [4, 4, 4]);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let turned = |x: &[f64; 3]| [half * (x[0] - x[2]), x[1], half * (x[0] + x[2])];
    let mesh = common::moved(&square, square.coordinates().iter().map(turned).collect());
    for friction in [0.0, 0.2, f64::INFINITY] {
        let wall = |x: f64| RigidWall::plane([0.0; 3], [x, 0.0, 0.75_f64.sqrt()], friction);
        let runs = [[0.5, -0.5], [-0.5, 0.5]].map(|order| {
            let model = Model {
                parts: whole(&mesh, yielding(300e6, 1e9), Formulation::BBar),
                initial_velocities: vec![translation(&mesh, [0.0, 0.0, -50.0])],
                walls: order.map(wall).to_vec(),
                settings: until(40e-6),
                ..Model::default()
            };
            let walls = model.walls.clone();
            let mut simulation = new(&mesh, model);
            let (mut deepest, mut impulses) = (0.0_f64, [[0.0; 3]; 2]);
            run(&mut simulation, |now| {
                let gaps = || places(now).flat_map(|place| walls.iter().map(move |wall| wall.gap(&place, now.time())));
                deepest = gaps().fold(deepest, f64::min);
                for (wall, impulse) in impulses.iter_mut().enumerate() {
                    let force = now.wall_force(wall);
                    *impulse = std::array::from_fn(|i| impulse[i] + now.time_step() * force[i]);
                }
            });
            let [first, second] = impulses;
            println!("friction {friction}: {first:?} {second:?}, depth {deepest:e} m");
            assert!(deepest > -1e-12, "{deepest:e}");
            assert!(first[2] > 0.0 && norm(minus(first, [-second[0], second[1], second[2]])) < 1e-9 * norm(first));
            assert!(simulation.energies().error().abs() < 1e-4, "{}", simulation.energies().error());
            simulation
        });
        for (one, other) in runs[0].displacement().iter().zip(runs[1].displacement()) {
            assert!(norm(minus(*one, *other)) < 1e-12, "{one:?} {other:?}");
        }
    }
}

/// A wall that moves into what is held, and a tool that would pass over its own width in a step, end the run with their names.
#[test]
fn what_cannot_be_kept_out_ends_the_run() {
    let mesh = block();
    let model = |wall: RigidWall| Model {
        parts: whole(&mesh, elastic(), Formulation::BBar),
        fixes: vec![Fix { nodes: nodes(&mesh, "z_max"), directions: DIRECTIONS.to_vec() }],
        walls: vec![wall],
        settings: until(10e-6),
        ..Model::default()
    };
    let error = |model: Model| {
        let mut simulation = new(&mesh, model);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        pool.install(|| {
            loop {
                if let Err(error) = simulation.advance() {
                    return error;
                }
                assert!(!simulation.is_finished());
            }
        })
    };
    let wall = RigidWall { motion: steadily(DOWN, 100.0), ..RigidWall::plane([0.0, 0.0, 10e-3], DOWN, 0.0) };
    assert!(matches!(error(model(wall)), SimulationError::HeldBehindWall { wall: 0, .. }));
    let shape = WallShape::Sphere { centre: [0.0, 0.0, -1.0], radius: 1e-3 };
    let tool = RigidWall { shape, friction: 0.0, motion: steadily([0.0, 0.0, 1.0], 1e5) };
    assert!(matches!(error(model(tool)), SimulationError::ToolTooFast { wall: 0, .. }));
}
