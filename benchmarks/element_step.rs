//! Whole steps of a quarter Taylor bar: time per element step for each element, material and set of vector instructions.
//!
//! Measured: elements, node sums, wall, constraints, energies and the time step, on one thread, in the first 200 steps, in
//! which most of the foot yields. Not measured: reading, set-up, output, more threads, meshes beyond the caches.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use estar_material::{ElasticConstant, IsotropicElasticity, IsotropicHardening, KinematicHardening, MaterialModel};
use estar_mesh::generate::{CylinderParameters, CylinderSpec, Section, cylinder};
use estar_mesh::{Mesh, locality_order};
use estar_solver::model::{Direction, Fix, Formulation, InitialVelocity, Model, Part, RigidWall, TimeSettings};
use estar_solver::{LaneLevel, Simulation};
use std::time::{Duration, Instant};

const STEPS: u64 = 200;

fn mesh() -> Mesh {
    let parameters = CylinderParameters {
        radius: 3.2e-3,
        length: 32.4e-3,
        section: Section::Quarter,
        core_cells: 4,
        radial_rings: 4,
        axial_cells: 64,
        axial_grading: 1.0,
    };
    let mesh = cylinder(&CylinderSpec::try_from(parameters).expect("valid parameters"));
    mesh.renumbered(&locality_order(&mesh))
}

fn model(mesh: &Mesh, material: MaterialModel, element: Formulation) -> Model {
    let nodes = |name: &str| mesh.group(name).expect("a group of the generator").nodes.clone();
    let bar = mesh.group("bar").expect("a group of the generator");
    Model {
        parts: vec![Part { hexes: bar.hexes.clone(), material, element }],
        fixes: vec![
            Fix { nodes: nodes("symmetry_x"), directions: vec![Direction::X] },
            Fix { nodes: nodes("symmetry_y"), directions: vec![Direction::Y] },
        ],
        initial_velocities: vec![InitialVelocity {
            nodes: bar.nodes.clone(),
            translation: [0.0, 0.0, -227.0],
            spin: None,
        }],
        walls: vec![RigidWall { point: [0.0; 3], normal: [0.0, 0.0, 1.0], friction: 0.0 }],
        settings: TimeSettings { end: 80e-6, ..TimeSettings::default() },
        ..Model::default()
    }
}

fn materials() -> Vec<(&'static str, MaterialModel)> {
    let elasticity =
        IsotropicElasticity::new(8930.0, ElasticConstant::YoungModulus(117e9), ElasticConstant::PoissonRatio(0.35))
            .expect("valid constants");
    let linear = IsotropicHardening::linear(400e6, 100e6).expect("valid parameters");
    let voce = IsotropicHardening::voce(400e6, 500e6, 10.0).expect("valid parameters");
    let kinematic = KinematicHardening::prager(1e8).expect("valid parameters");
    vec![
        ("elastic", MaterialModel::elastic(elasticity)),
        (
            "e-star box-rate linear",
            MaterialModel::e_star_box_rate(elasticity, linear.clone(), KinematicHardening::NONE),
        ),
        ("e-star box-rate voce", MaterialModel::e_star_box_rate(elasticity, voce, KinematicHardening::NONE)),
        ("e-star box-rate prager", MaterialModel::e_star_box_rate(elasticity, linear.clone(), kinematic)),
        ("e-star total linear", MaterialModel::e_star_total(elasticity, linear)),
    ]
}

fn element_step(criterion: &mut Criterion) {
    let mesh = mesh();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    for level in LaneLevel::ALL.into_iter().filter(|level| level.is_available()).rev() {
        let mut group = criterion.benchmark_group(format!("element step, {}", level.name()));
        group.throughput(Throughput::Elements(1)).sample_size(10).measurement_time(Duration::from_secs(3));
        for (name, material) in materials() {
            for (element, formulation) in [("hex8-f-bar", Formulation::FBar), ("hex8", Formulation::Full)] {
                let model = model(&mesh, material.clone(), formulation);
                group.bench_function(format!("{element}, {name}"), |bencher| {
                    // an iteration is one step of one element
                    bencher.iter_custom(|iterations| {
                        let mut simulation = Simulation::new(&mesh, model.clone(), level).expect("a sound model");
                        let begun = Instant::now();
                        pool.install(|| {
                            for _ in 0..STEPS {
                                simulation.advance().expect("a sound run");
                            }
                        });
                        let element_steps = STEPS as f64 * mesh.hex_count() as f64;
                        begun.elapsed().mul_f64(iterations as f64 / element_steps)
                    });
                });
            }
        }
        group.finish();
    }
}

criterion_group!(benches, element_step);
criterion_main!(benches);
