//! A checkpoint with any damage, some of it under a checksum that is right. What is not refused goes on.
#![no_main]

use estar_fuzz::{STEPS, workshop, write};
use estar_session::{Destination, Session, SessionError, Start, machine};
use libfuzzer_sys::arbitrary::{self, Arbitrary};
use sha2::{Digest, Sha256};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use tempfile::TempDir;

const DECK: &str = r#"
mesh = { file = "mesh.msh" }
part = [{ group = "box", material = "steel" }]
rigid_wall = [{ point = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0], friction = 0.1 }]
initial_velocity = [{ group = "box", value = [0.0, 0.0, -100.0] }]
pressure = [{ group = "z_max", curve = [[0.0, 0.0], ["1 us", "10 MPa"]] }]
probe = [{ name = "height", kind = "extent", group = "box", axis = "z" }]
expect = [{ probe = "height", at = "0.2 us", value = "1 mm", tolerance = "1 %" }, { probe = "height", at = "max", value = "1 mm", tolerance = "1 %" }]
[material.steel]
theory = "e-star"
density = 7850.0
young_modulus = "200 GPa"
poisson_ratio = 0.3
hardening = { law = "linear", yield_stress = "300 MPa", modulus = "1 GPa" }
kinematic = { law = "prager", modulus = "1 GPa" }
[time]
end = "1 us"
on_inversion = "delete"
[output]
history_steps = 1
every = "0.1 us"
"#;

/// The step of the checkpoint.
const MIDWAY: u64 = 5;
/// Bytes before the head.
const FIXED: usize = 24;
/// Bytes after the numbers.
const CHECKSUM: usize = 32;

/// What is done to the checkpoint.
#[derive(Arbitrary, Debug)]
struct Damage {
    /// Pieces of the head: where, how many bytes are lost, what comes in their place.
    head: Vec<(u16, u8, String)>,
    /// Numbers by position.
    numbers: Vec<(u16, f64)>,
    /// Bytes of the file by position, after the checksum.
    bytes: Vec<(u16, u8)>,
    /// Bytes that are left.
    length: Option<u16>,
}

/// A run that was stopped midway.
struct Stopped {
    workshop: TempDir,
    checkpoint: PathBuf,
    head: String,
    numbers: Vec<f64>,
    /// Its other files.
    others: Vec<(PathBuf, Vec<u8>)>,
}

static STOPPED: LazyLock<Stopped> = LazyLock::new(|| {
    let workshop = workshop();
    write(&workshop.path().join("deck.toml"), DECK.as_bytes());
    run(workshop.path(), Start::Fresh, MIDWAY).expect("a run up to its checkpoint");
    let (mut checkpoint, mut others) = (PathBuf::new(), Vec::new());
    for directory in ["results", "results/fields"].map(|name| workshop.path().join(name)) {
        for path in fs::read_dir(directory).expect("results").map(|entry| entry.expect("an entry").path()) {
            if path.to_string_lossy().contains("checkpoint_") {
                checkpoint = path;
            } else if path.is_file() {
                others.push((path.clone(), fs::read(path).expect("a file of the results")));
            }
        }
    }
    let bytes = fs::read(&checkpoint).expect("the checkpoint");
    let head_length = u32::from_le_bytes(bytes[12..16].try_into().expect("four bytes")) as usize;
    let (head, numbers) = bytes[FIXED..bytes.len() - CHECKSUM].split_at(head_length);
    let numbers = numbers.chunks_exact(8).map(|eight| f64::from_le_bytes(eight.try_into().expect("eight bytes")));
    Stopped {
        checkpoint,
        head: String::from_utf8_lossy(head).into_owned(),
        numbers: numbers.collect(),
        others,
        workshop,
    }
});

/// Runs the deck of the workshop up to a step, on one thread.
fn run(workshop: &Path, start: Start, stop: u64) -> Result<(), SessionError> {
    let (pool, lanes) = machine(Some(1), None)?;
    pool.install(|| {
        let mut session = Session::load(&workshop.join("deck.toml"), &[], lanes, &mut ())?;
        let destination = Destination { directory: workshop.join("results"), start, stop_at_step: Some(stop) };
        session.write_to(&destination, &mut ())?;
        let ending = session.advance_to_end(&mut ())?;
        session.finish(ending, &mut ()).map(|_| ())
    })
}

libfuzzer_sys::fuzz_target!(|damage: Damage| {
    let mut head = STOPPED.head.clone();
    for (start, length, piece) in &damage.head {
        let start = *start as usize % (head.len() + 1);
        let end = (start + *length as usize).min(head.len());
        if head.is_char_boundary(start) && head.is_char_boundary(end) {
            head.replace_range(start..end, piece);
        }
    }
    let mut numbers = STOPPED.numbers.clone();
    for (at, number) in &damage.numbers {
        let at = *at as usize % numbers.len();
        numbers[at] = *number;
    }
    let mut file = b"ESTARCKP\x01\0\0\0".to_vec();
    file.extend((head.len() as u32).to_le_bytes());
    file.extend((numbers.len() as u64).to_le_bytes());
    file.extend(head.bytes());
    file.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    let checksum = Sha256::digest(&file);
    file.extend(checksum);
    for (at, byte) in &damage.bytes {
        let at = *at as usize % file.len();
        file[at] = *byte;
    }
    file.truncate(damage.length.map_or(file.len(), usize::from));

    let _ = fs::remove_dir_all(STOPPED.workshop.path().join("results"));
    fs::create_dir_all(STOPPED.workshop.path().join("results/fields")).expect("a directory");
    for (path, bytes) in &STOPPED.others {
        write(path, bytes);
    }
    write(&STOPPED.checkpoint, &file);
    let _ = run(STOPPED.workshop.path(), Start::Resuming, MIDWAY + STEPS);
});
