//! Prints how long the checks of a mesh of a million hexes take, each beside its aim: the least and the median of nine runs on all
//! cores. Quality and what hangs together are what `estar check` and `run` look at before they set a mesh up; merging is for
//! `[mesh] merge`, and finds nothing to merge here, which is most of its work. Not measured: reading the file.
//!
//! `cargo run --release -p estar-mesh --example mesh_rates`

use std::error::Error;
use std::time::Instant;

use estar_mesh::conformity::Conformity;
use estar_mesh::generate::{BoxSpec, box_mesh};
use estar_mesh::quality::QualityReport;
use estar_mesh::{Connectivity, Mesh};

const RUNS: usize = 9;

fn seconds<T>(work: impl FnOnce() -> T) -> f64 {
    let start = Instant::now();
    drop(work());
    start.elapsed().as_secs_f64()
}

fn report(what: &str, mut times: Vec<f64>, aim: &str) {
    times.sort_by(f64::total_cmp);
    println!("{what:<32} least {:.3} s   median {:.3} s   {aim}", times[0], times[times.len() / 2]);
}

fn main() -> Result<(), Box<dyn Error>> {
    let mesh: Mesh = box_mesh(&BoxSpec::new([1.0; 3], [100; 3])?);
    let connectivity = Connectivity::new(&mesh);
    let mut checks: [Vec<f64>; 4] = Default::default();
    for _ in 0..RUNS {
        let [quality, connected, conformity, merged] = &mut checks;
        quality.push(seconds(|| QualityReport::new(&mesh)));
        connected.push(seconds(|| Connectivity::new(&mesh)));
        conformity.push(seconds(|| Conformity::new(&mesh, &connectivity)));
        merged.push(seconds(|| mesh.merged(1e-6)));
    }
    let [quality, connected, conformity, merged] = checks;
    let all = (0..RUNS).map(|run| quality[run] + connected[run] + conformity[run]).collect();
    report("quality", quality, "");
    report("what hangs together", connected, "");
    report("nodes and faces that match", conformity, "");
    report("all three", all, "at most 0.5 s");
    report("merge", merged, "at most 1 s");
    Ok(())
}
