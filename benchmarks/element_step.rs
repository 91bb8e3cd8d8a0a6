//! Whole steps of a quarter Taylor bar: time per element step for each element, material and set of vector instructions.
//!
//! Measured: elements, node sums, wall, constraints, energies and the time step, on one thread, in the first 200 steps, in
//! which most of the foot yields. Not measured: reading, set-up, output, more threads, meshes beyond the caches.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use estar::bench::taylor_bar::{ELEMENTS, materials, mesh, model, shape};
use estar_deck::model::element_name;
use estar_solver::{LaneLevel, Simulation};
use std::time::{Duration, Instant};

/// Of a mesh that stays in the cache.
const ELEMENT_COUNT: usize = 3_000;
const STEPS: u64 = 200;

fn element_step(criterion: &mut Criterion) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    for level in LaneLevel::ALL.into_iter().filter(|level| level.is_available()).rev() {
        let mut group = criterion.benchmark_group(format!("element step, {}", level.name()));
        group.throughput(Throughput::Elements(1)).sample_size(10).measurement_time(Duration::from_secs(3));
        for (name, material) in materials() {
            for element in ELEMENTS {
                let mesh = mesh(ELEMENT_COUNT, shape(element));
                let model = model(&mesh, material.clone(), element);
                group.bench_function(format!("{}, {name}", element_name(element)), |bencher| {
                    // an iteration is one step of one element
                    bencher.iter_custom(|iterations| {
                        let mut simulation = Simulation::new(&mesh, model.clone(), level).expect("a sound model");
                        let begun = Instant::now();
                        pool.install(|| {
                            for _ in 0..STEPS {
                                simulation.advance().expect("a sound run");
                            }
                        });
                        let element_steps = STEPS as f64 * mesh.element_count() as f64;
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
