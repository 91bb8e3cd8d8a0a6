//! A million hexes from file to steps: time to read and set up, to step, to take a frame from the loop, and the memory
//! that it all needs, each beside its target. One run, since it takes what a user's run takes: repeat it for a median.
//!
//! Measured on all cores: a box of 100 × 100 × 100 hexes in a binary Gmsh file in the system's cache, E* in the box-rate
//! update, F-bar, every field in the frames. Not measured: the disk, which frames reach on a thread of their own.

use estar_session::frames::{EarlierFrames, FrameWriter};
use estar_session::{Observer, Problem, Session, machine};
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

const CELLS: usize = 100;
const STEPS: u32 = 5;

const DECK: &str = r#"
[mesh]
file = "box.msh"
[material.copper]
theory = "e-star"
density = 8930.0
young_modulus = "117 GPa"
poisson_ratio = 0.35
hardening = { law = "linear", yield_stress = "400 MPa", modulus = "100 MPa" }
[[part]]
group = "box"
material = "copper"
[[initial_velocity]]
group = "box"
value = [0.0, 0.0, -227.0]
[[rigid_wall]]
point = [0.0, 0.0, 0.0]
normal = [0.0, 0.0, 1.0]
[time]
end = "1 ms"
"#;

fn main() {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let deck = folder.path().join("box.toml");
    std::fs::write(&deck, DECK).expect("a deck");
    // made by another process, so that its memory is not counted
    let cells = CELLS.to_string();
    let mut generator = Command::new(env!("CARGO_BIN_EXE_estar"));
    generator.args(["mesh", "box", "--cells", &cells, &cells, &cells, "--output"]);
    let made = generator.arg(folder.path().join("box.msh")).output().expect("the generator of meshes");
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));

    let (pool, lanes) = machine(None, None).expect("threads");
    println!("{} hexes, {} threads, {}", CELLS.pow(3), pool.current_num_threads(), lanes.name());
    pool.install(|| measure(&deck, folder.path(), lanes));
}

/// When deck and mesh were read.
struct Loaded(Option<Instant>);

impl Observer for Loaded {
    fn loaded(&mut self, _problem: &Problem) {
        self.0 = Some(Instant::now());
    }
}

fn measure(deck: &Path, folder: &Path, lanes: estar_solver::LaneLevel) {
    let begun = Instant::now();
    let mut loaded = Loaded(None);
    let mut session = Session::load(deck, &[], lanes, &mut loaded).expect("a sound deck");
    let set_up = begun.elapsed();
    let loaded = loaded.0.map_or(set_up, |loaded| loaded - begun);
    row("read, checked and ordered", seconds(loaded), "");
    row("and set up, with the forces of t = 0", seconds(set_up), "3 s");
    row("memory then", per_hex("VmRSS:"), "");

    let problem = session.problem();
    let (parts, fields) = (&problem.model.parts, &problem.output.fields);
    let frames = FrameWriter::start(folder, &problem.mesh, parts, fields, EarlierFrames::default());
    let mut frames = frames.expect("a folder");
    for frame in 1..=3 {
        let begun = Instant::now();
        frames.write(session.simulation()).expect("room for frames");
        row(&format!("frame {frame} taken from the loop"), milliseconds(begun.elapsed()), "50 ms");
        // the writer is done before the steps are timed
        if frame < 3 {
            frames.sync().expect("room for frames");
        }
        session.advance(&mut ()).expect("a sound run");
    }
    frames.finish().expect("room for frames");

    let begun = Instant::now();
    for _ in 0..STEPS {
        session.advance(&mut ()).expect("a sound run");
    }
    row("step", milliseconds(begun.elapsed() / STEPS), "");
    row("memory with frames", per_hex("VmRSS:"), "1000 B per hex");
    row("memory at its peak", per_hex("VmHWM:"), "1000 B per hex");
}

fn row(what: &str, value: String, target: &str) {
    let bound = if target.is_empty() { String::new() } else { format!("   at most {target}") };
    println!("{what:<40} {value:>16}{bound}");
}

fn seconds(duration: Duration) -> String {
    format!("{:.2} s", duration.as_secs_f64())
}

fn milliseconds(duration: Duration) -> String {
    format!("{:.1} ms", 1e3 * duration.as_secs_f64())
}

/// A row of the memory of this process (Linux), by hexes.
fn per_hex(name: &str) -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let kilobytes =
        status.lines().find_map(|line| line.strip_prefix(name)?.trim().strip_suffix("kB")?.trim().parse().ok());
    kilobytes.map_or("unknown".to_owned(), |kb: f64| format!("{:.0} B per hex", 1024.0 * kb / CELLS.pow(3) as f64))
}
