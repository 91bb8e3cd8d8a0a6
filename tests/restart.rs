//! A run that is stopped, killed or interrupted and taken up again is, to the last byte, the run that never stopped.
//!
//! Decks: a Taylor bar whose foot rebounds, a necking bar under a probe and expectations, a block that slides on a rough wall
//! with every load, a block that breaks up; coarse meshes. Source: none is needed, the straight run is the reference. The long loops are ignored:
//! `cargo test --release --test restart -- --include-ignored --nocapture --test-threads 1` prints the figures of
//! `docs/reliability.md`.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// A deck with its mesh, in a directory of its own.
struct Workshop {
    directory: TempDir,
}

const TAYLOR: (&str, &[&str]) = (
    r#"
title = "Taylor bar"
[mesh]
file = "mesh.msh"
[material.copper]
theory = "e-star"
density = 8930.0
young_modulus = "117 GPa"
poisson_ratio = 0.35
specific_heat = 383.0
hardening = { law = "johnson-cook", a = "90 MPa", b = "292 MPa", n = 0.31, c = 0.025, m = 1.09, reference_rate = 1.0, reference_temperature = 293.0, melting_temperature = 1356.0 }
[[part]]
group = "bar"
material = "copper"
[[initial_velocity]]
group = "bar"
value = [0.0, 0.0, -190.0]
[[fix]]
group = "symmetry_x"
directions = ["x"]
[[fix]]
group = "symmetry_y"
directions = ["y"]
[[rigid_wall]]
point = [0.0, 0.0, 0.0]
normal = [0.0, 0.0, 1.0]
[time]
end = "40 us"
[output]
frames = 7
history = "0.5 us"
checkpoint = "20 ms"
fields = ["displacement", "velocity", "cauchy_stress", "temperature"]
[[probe]]
name = "length"
kind = "extent"
group = "bar"
axis = "z"
[[expect]]
probe = "length"
at = "10 us"
value = "30.7 mm"
tolerance = "3 %"
[[expect]]
probe = "length"
at = "max"
value = "32.4 mm"
tolerance = "1 %"
"#,
    &["cylinder", "--core-cells", "2", "--rings", "2", "--axial-cells", "16"],
);

const NECKING: (&str, &[&str]) = (
    r#"
[mesh]
file = "mesh.msh"
[material.steel]
theory = "e-star"
update = "total"
density = "7850 kg/m^3"
bulk_modulus = "164.21 GPa"
shear_modulus = "80.1938 GPa"
hardening = { law = "saturation", yield_stress = "450 MPa", saturation_stress = "715 MPa", saturation_exponent = 16.93, modulus = "129.24 MPa" }
[[part]]
group = "bar"
material = "steel"
[[fix]]
group = "symmetry_x"
directions = ["x"]
[[fix]]
group = "symmetry_y"
directions = ["y"]
[[fix]]
group = "symmetry_z"
directions = ["z"]
[[prescribed]]
group = "grip"
direction = "z"
quantity = "displacement"
curve = [[0.0, 0.0], ["0.4 ms", "3 mm"]]
interpolation = "smooth"
[time]
end = "0.4 ms"
[output]
every = "0.07 ms"
history_steps = 13
checkpoint = "20 ms"
[[probe]]
name = "force"
kind = "reaction"
group = "grip"
direction = "z"
[[expect]]
probe = "force"
at = "max"
value = "19 kN"
tolerance = "10 %"
"#,
    &["necking-bar", "--core-cells", "2", "--rings", "2", "--axial-cells", "8"],
);

const WALL: (&str, &[&str]) = (
    r#"
[mesh]
file = "mesh.msh"
[material.moving]
theory = "e-star"
density = 7850.0
young_modulus = "200 GPa"
poisson_ratio = 0.3
hardening = { law = "linear", yield_stress = "300 MPa", modulus = "1 GPa" }
kinematic = { law = "armstrong-frederick", modulus = "20 GPa", recovery = 100.0 }
[[part]]
group = "box"
material = "moving"
element = "hex8"
[[initial_velocity]]
group = "box"
value = [60.0, 0.0, -150.0]
angular = { rate = [0.0, 2000.0, 0.0], centre = [0.0, 0.0, 0.0] }
[[rigid_wall]]
point = [0.0, 0.0, -1e-3]
normal = [0.0, 0.0, 1.0]
friction = 0.3
[[gravity]]
acceleration = [0.0, 0.0, -9.81]
[[pressure]]
group = "z_max"
curve = [[0.0, 0.0], ["20 us", "80 MPa"]]
[[traction]]
group = "x_max"
direction = [0.0, 1.0, 0.0]
curve = [[0.0, "1 MPa"], ["20 us", "9 MPa"]]
interpolation = "smooth"
[time]
end = "60 us"
bulk_viscosity = { linear = 0.06, quadratic = 1.2 }
[output]
frames = 5
history_steps = 7
checkpoint = "20 ms"
"#,
    &["box", "--size", "10 mm", "8 mm", "12 mm", "--cells", "5", "4", "6"],
);

const BREAKING: (&str, &[&str]) = (
    r#"
[mesh]
file = "mesh.msh"
[material.soft]
theory = "e-star"
density = 7850.0
young_modulus = "200 GPa"
poisson_ratio = 0.3
hardening = { law = "linear", yield_stress = "300 MPa", modulus = "100 MPa" }
[[part]]
group = "box"
material = "soft"
[[initial_velocity]]
group = "box"
value = [0.0, 0.0, -600.0]
[[rigid_wall]]
point = [0.0, 0.0, 0.0]
normal = [0.0, 0.0, 1.0]
friction = 0.2
[time]
end = "8 us"
on_inversion = "delete"
[output]
frames = 5
history_steps = 7
checkpoint = "20 ms"
"#,
    &["box", "--size", "4 mm", "4 mm", "6 mm", "--cells", "6", "6", "9"],
);

/// A block that spins, yields and bounces on a wall.
const SOAK: (&str, &[&str]) = (
    r#"
[mesh]
file = "mesh.msh"
[material.steel]
theory = "e-star"
density = 7850.0
young_modulus = "200 GPa"
poisson_ratio = 0.3
hardening = { law = "voce", yield_stress = "250 MPa", saturation_stress = "400 MPa", saturation_exponent = 20.0 }
kinematic = { law = "armstrong-frederick", modulus = "20 GPa", recovery = 200.0 }
[[part]]
group = "box"
material = "steel"
[[initial_velocity]]
group = "box"
value = [0.0, 0.0, -40.0]
angular = { rate = [3000.0, 0.0, 20000.0], centre = ["2 mm", "2 mm", "2 mm"] }
[[gravity]]
acceleration = [0.0, 0.0, -1e4]
[[rigid_wall]]
point = [0.0, 0.0, "-1 mm"]
normal = [0.0, 0.0, 1.0]
friction = 0.02
[time]
end = "110 ms"
[output]
frames = 4
history = "1 ms"
"#,
    &["box", "--size", "4 mm", "4 mm", "4 mm", "--cells", "4", "4", "4"],
);

const DECKS: [(&str, (&str, &[&str])); 4] =
    [("taylor", TAYLOR), ("necking", NECKING), ("friction wall", WALL), ("deletion", BREAKING)];

/// What a run has left: every byte of its results, and the hash of its state.
#[derive(PartialEq)]
struct Results {
    files: BTreeMap<PathBuf, Vec<u8>>,
    state_hash: String,
}

impl Workshop {
    fn new((deck, mesh): (&str, &[&str])) -> Self {
        let workshop = Self { directory: tempfile::tempdir().unwrap() };
        fs::write(workshop.path("deck.toml"), deck).unwrap();
        let made = workshop.estar(&[&["mesh"], mesh, &["--output", "mesh.msh"]].concat());
        assert!(made.status.success(), "{}", text(&made));
        workshop
    }

    fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_estar"));
        command.args(arguments).current_dir(self.directory.path()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    fn estar(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// Runs the deck into a directory.
    fn run(&self, output: &str, arguments: &[&str]) -> Output {
        self.estar(&[&["run", "deck.toml", "--quiet", "--output", output], arguments].concat())
    }

    #[track_caller]
    fn run_well(&self, output: &str, arguments: &[&str]) {
        let said = self.run(output, arguments);
        assert!(said.status.success(), "{arguments:?}: {}", text(&said));
    }

    /// The straight run.
    fn straight(&self) -> Results {
        self.run_well("straight", &[]);
        self.results("straight")
    }

    fn results(&self, output: &str) -> Results {
        let directory = self.path(output);
        let mut files = BTreeMap::new();
        for name in ["history.csv", "results.pvd"] {
            files.insert(PathBuf::from(name), fs::read(directory.join(name)).unwrap());
        }
        for entry in fs::read_dir(directory.join("fields")).unwrap() {
            let path = entry.unwrap().path();
            let name = Path::new("fields").join(path.file_name().unwrap());
            files.insert(name, fs::read(path).unwrap());
        }
        let summary = fs::read_to_string(directory.join("summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
        assert_eq!(summary["status"], "finished");
        assert_eq!(summary["frames"].as_u64().unwrap() + 2, files.len() as u64);
        Results { files, state_hash: summary["state_hash"].as_str().unwrap().to_owned() }
    }

    fn summary(&self, output: &str) -> serde_json::Value {
        serde_json::from_str(&fs::read_to_string(self.path(output).join("summary.json")).unwrap()).unwrap()
    }

    fn checkpoints(&self, output: &str) -> Vec<String> {
        let entries = fs::read_dir(self.path(output)).unwrap();
        let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> = names.filter(|name| name.ends_with(".estar")).collect();
        names.sort();
        names
    }
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr].concat()).into_owned()
}

#[track_caller]
fn assert_same(found: &Results, straight: &Results, what: &str) {
    assert_eq!(found.state_hash, straight.state_hash, "{what}");
    assert_eq!(found.files.keys().collect::<Vec<_>>(), straight.files.keys().collect::<Vec<_>>(), "{what}");
    for (name, bytes) in &straight.files {
        assert!(found.files[name] == *bytes, "{what}: {} differs", name.display());
    }
}

/// As climate codes test it: A is the straight run, B stops midway and C goes on from there: A = C.
#[test]
fn stopped_and_resumed_is_straight_on_any_threads_and_lanes() {
    for (name, deck) in DECKS {
        let workshop = Workshop::new(deck);
        let straight = workshop.straight();
        let steps = workshop.summary("straight")["steps"].as_u64().unwrap();
        for (leg, stop) in [1, steps / 3, steps - 1].into_iter().enumerate() {
            let output = format!("leg{leg}");
            workshop.run_well(&output, &["--stop-at-step", &stop.to_string(), "--threads", "1"]);
            assert_eq!(workshop.summary(&output)["status"], "stopped");
            assert_eq!(workshop.summary(&output)["steps"], stop);
            let lanes = ["portable", "avx2", "avx512"][leg];
            let resumed = workshop.run(&output, &["--resume", "--threads", "3", "--lanes", lanes]);
            // this machine may lack the instructions
            if text(&resumed).contains("this machine has no") {
                workshop.run_well(&output, &["--resume"]);
            }
            assert_same(&workshop.results(&output), &straight, &format!("{name}, stopped at step {stop}"));
        }
        // once more from the end: nothing is left to do, and nothing is doubled
        workshop.run_well("leg0", &["--resume"]);
        assert_same(&workshop.results("leg0"), &straight, name);
    }
}

#[test]
fn a_run_that_goes_on_counts_the_steps_that_are_left() {
    let workshop = Workshop::new(TAYLOR);
    let steps_told = |said: &Output, behind: &str| -> u64 {
        let text = text(said);
        let line = text.lines().find(|line| line.contains(behind)).unwrap_or_else(|| panic!("{text}"));
        let told = line.split("about ").nth(1).unwrap().split(behind).next().unwrap();
        told.replace(' ', "").parse().unwrap()
    };
    let until = |stop: &str| {
        let arguments = ["run", "deck.toml", "--output", "r", "--resume", "--stop-at-step", stop];
        workshop.estar(&[&arguments[..], &NEVER[..]].concat())
    };
    workshop.run_well("r", &[&["--stop-at-step", "1"], &NEVER[..]].concat());
    let all = steps_told(&until("2"), " more steps if it stays so");
    until(&(3 * all / 4).to_string());
    let gone_on = until(&all.to_string());
    let left = steps_told(&gone_on, " more steps if it stays so");
    assert!((all / 8..all / 2).contains(&left), "{all} in all, {left} after three quarters: {}", text(&gone_on));
    assert!(text(&gone_on).contains(" s of it done; next step "), "{}", text(&gone_on));
}

#[test]
fn the_newest_two_checkpoints_are_kept_and_a_damaged_one_is_passed_over() {
    let workshop = Workshop::new(TAYLOR);
    let straight = workshop.straight();
    let never = ["--set", "output.checkpoint='never'"];
    workshop.run_well("legs", &[&["--stop-at-step", "100"], &never[..]].concat());
    for stop in ["200", "300"] {
        workshop.run_well("legs", &[&["--resume", "--stop-at-step", stop], &never[..]].concat());
    }
    assert_eq!(workshop.checkpoints("legs"), ["checkpoint_000000000200.estar", "checkpoint_000000000300.estar"]);
    let newest = workshop.path("legs").join("checkpoint_000000000300.estar");
    let whole = fs::read(&newest).unwrap();
    let mut damaged = whole.clone();
    damaged[whole.len() / 2] ^= 1;
    for (bytes, reason) in [
        (damaged, "its checksum is not that of its content"),
        (whole[..whole.len() - 9].to_vec(), "bytes of the"),
        (b"title = \"a deck\"\n[time]\nend = 1.0".to_vec(), "is no checkpoint"),
    ] {
        fs::write(&newest, bytes).unwrap();
        let said = workshop.run("legs", &[&["--resume", "--stop-at-step", "200"], &never[..]].concat());
        assert!(said.status.success(), "{}", text(&said));
        let told = format!("warning: checkpoint_000000000300.estar cannot be taken up: it {}", "");
        assert!(text(&said).contains(told.trim_end()) && text(&said).contains(reason), "{}", text(&said));
    }
    // with none that is whole it ends, and says why of each
    for name in workshop.checkpoints("legs") {
        fs::write(workshop.path("legs").join(name), "").unwrap();
    }
    let said = workshop.run("legs", &[&["--resume"], &never[..]].concat());
    assert_eq!(said.status.code(), Some(4));
    assert_eq!(text(&said).matches("cannot be taken up: it is no checkpoint").count(), 2, "{}", text(&said));
    // other overrides are another deck; without them the run is the straight one again
    workshop.run_well("again", &["--stop-at-step", "100"]);
    workshop.run_well("again", &["--resume"]);
    assert_same(&workshop.results("again"), &straight, "resumed from step 100");
}

const NEVER: [&str; 2] = ["--set", "output.checkpoint='never'"];

/// Stops a run at two steps, where it leaves its checkpoints.
fn in_two_legs(workshop: &Workshop, output: &str, stops: [u64; 2]) {
    let [first, second] = stops.map(|stop| stop.to_string());
    workshop.run_well(output, &[&["--stop-at-step", &first], &NEVER[..]].concat());
    workshop.run_well(output, &[&["--resume", "--stop-at-step", &second], &NEVER[..]].concat());
}

/// Rows and frames that there were at a checkpoint.
fn outputs_at(path: &Path) -> [usize; 2] {
    let bytes = fs::read(path).unwrap();
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let head: serde_json::Value = serde_json::from_slice(&bytes[24..24 + length]).unwrap();
    let bookmark = &head["bookmark"];
    [bookmark["history_rows"].as_u64().unwrap() as usize, bookmark["frame_times"].as_array().unwrap().len()]
}

#[test]
fn damaged_checkpoints_do_not_drive_out_sound_ones() {
    let workshop = Workshop::new(TAYLOR);
    let straight = workshop.straight();
    in_two_legs(&workshop, "out", [100, 200]);
    let run = |arguments: &[&str]| workshop.run("out", &[&["--resume"], arguments, &NEVER[..]].concat());
    let at = |step: u32| workshop.path("out").join(format!("checkpoint_{step:012}.estar"));
    // of later steps, as a crash of the machine could leave them, and of one between
    for step in [150, 300, 400, 500] {
        fs::write(at(step), "damaged").unwrap();
    }
    let said = run(&["--stop-at-step", "250"]);
    assert!(said.status.success() && text(&said).matches("cannot be taken up").count() == 3, "{}", text(&said));
    assert!(at(250).exists(), "the one that was just written");
    assert!(at(200).exists() && !at(100).exists() && !at(150).exists(), "{:?}", workshop.checkpoints("out"));
    // the newest of all is damaged, and there is one before it
    let whole = fs::read(at(250)).unwrap();
    fs::write(at(250), &whole[..whole.len() - 1]).unwrap();
    assert!(run(&["--stop-at-step", "260"]).status.success());
    assert!(at(260).exists() && at(200).exists(), "{:?}", workshop.checkpoints("out"));
    // with two sound ones after it, what is damaged is cleared away
    assert!(run(&["--stop-at-step", "270"]).status.success());
    assert!(at(270).exists() && at(260).exists() && !at(250).exists() && !at(200).exists());
    assert!(run(&[]).status.success());
    assert_same(&workshop.results("out"), &straight, "after damages");
}

#[test]
fn outputs_too_short_for_the_newest_checkpoint_may_do_for_the_one_before() {
    let workshop = Workshop::new(TAYLOR);
    let straight = workshop.straight();
    let steps = workshop.summary("straight")["steps"].as_u64().unwrap();
    let stops = [steps / 3, 2 * steps / 3];
    for output in ["history.csv", "frame"] {
        in_two_legs(&workshop, "out", stops);
        let directory = workshop.path("out");
        let [first, second] = stops.map(|step| format!("checkpoint_{step:012}.estar"));
        let [[first_rows, first_frames], [rows, frames]] =
            [&first, &second].map(|name| outputs_at(&directory.join(name)));
        assert!(first_rows < rows && first_frames < frames);
        let reason = if output == "history.csv" {
            let history = fs::read_to_string(directory.join(output)).unwrap();
            let kept: Vec<&str> = history.lines().take(1 + rows).collect();
            fs::write(directory.join(output), kept.join("\n")).unwrap();
            "whole rows of the"
        } else {
            let last = directory.join(format!("fields/frame_{:05}.vtu", frames - 1));
            let bytes = fs::read(&last).unwrap();
            fs::write(&last, &bytes[..bytes.len() / 2]).unwrap();
            "is cut short"
        };
        let said = workshop.run("out", &[&["--resume"], &NEVER[..]].concat());
        let told = text(&said);
        assert!(said.status.success() && told.contains(&format!("{second} cannot be taken up")), "{told}");
        assert!(told.contains(reason), "{told}");
        assert_same(&workshop.results("out"), &straight, output);
        fs::remove_dir_all(directory).unwrap();
    }
}

#[test]
fn frames_that_a_user_removed_and_files_on_their_way_do_not_stop_a_run() {
    let workshop = Workshop::new(TAYLOR);
    let straight = workshop.straight();
    in_two_legs(&workshop, "out", [100, 200]);
    let directory = workshop.path("out");
    fs::remove_file(directory.join("fields/frame_00000.vtu")).unwrap();
    fs::remove_file(directory.join("results.pvd")).unwrap();
    let on_their_way = ["results.pvd", "fields/frame_00001.vtu", "checkpoint_000000000300.estar", "summary.json"];
    for name in on_their_way {
        fs::write(directory.join(format!("{name}.partial")), "half").unwrap();
    }
    fs::write(directory.join("notes.partial"), "mine").unwrap();
    let said = workshop.run("out", &[&["--resume"], &NEVER[..]].concat());
    assert!(said.status.success(), "{}", text(&said));
    assert!(text(&said).contains("warning: 1 of the frames of this run are not there any more"), "{}", text(&said));
    assert!(on_their_way.iter().all(|name| !directory.join(format!("{name}.partial")).exists()));
    assert!(directory.join("notes.partial").exists());
    let series = fs::read_to_string(directory.join("results.pvd")).unwrap();
    let straight_series = String::from_utf8(straight.files[Path::new("results.pvd")].clone()).unwrap();
    let without = straight_series.lines().filter(|line| !line.contains("frame_00000")).collect::<Vec<_>>().join("\n");
    assert_eq!(series.trim_end(), without.trim_end());
    let found = workshop.results("out");
    assert_eq!(found.state_hash, straight.state_hash);
    assert_eq!(found.files[Path::new("history.csv")], straight.files[Path::new("history.csv")]);
}

#[test]
fn a_checkpoint_of_another_run_is_refused_with_the_reason() {
    let workshop = Workshop::new(WALL);
    workshop.run_well("out", &["--stop-at-step", "50"]);
    let refused = |arguments: &[&str], reason: &str| {
        let said = workshop.run("out", &[&["--resume"], arguments].concat());
        assert_eq!(said.status.code(), Some(4), "{}", text(&said));
        let told = text(&said);
        assert!(told.contains("checkpoint_000000000050.estar cannot be taken up") && told.contains(reason), "{told}");
    };
    refused(&["--set", "time.end='70 us'"], "it is of another deck");
    refused(&["--set", "mesh.scale=2.0"], "it is of another mesh");
    let deck = fs::read_to_string(workshop.path("deck.toml")).unwrap();
    fs::write(workshop.path("deck.toml"), deck.replace("friction = 0.3", "friction = 0.2")).unwrap();
    refused(&[], "it is of another deck");
    fs::write(workshop.path("deck.toml"), &deck).unwrap();
    let mesh = fs::read(workshop.path("mesh.msh")).unwrap();
    let other = [
        "mesh", "box", "--size", "10 mm", "8 mm", "12 mm", "--cells", "5", "4", "7", "--force", "--output", "mesh.msh",
    ];
    assert!(workshop.estar(&other).status.success());
    refused(&[], "it is of another mesh");
    fs::write(workshop.path("mesh.msh"), mesh).unwrap();

    // the version is in the head, whose checksum a later version would have written
    let path = workshop.path("out").join("checkpoint_000000000050.estar");
    let bytes = fs::read(&path).unwrap();
    let version = env!("CARGO_PKG_VERSION");
    let head = String::from_utf8_lossy(&bytes[24..2000]).find(&format!("\"version\":\"{version}\"")).unwrap();
    assert!(head < 2000);
    let nothing = workshop.run("nowhere", &["--resume"]);
    assert_eq!(nothing.status.code(), Some(4));
    assert!(text(&nothing).contains("nowhere has no checkpoint to resume from"), "{}", text(&nothing));
    workshop.run_well("out", &["--resume"]);
    // with results in the directory one of the two must be said
    let neither = workshop.run("out", &[]);
    assert_eq!(neither.status.code(), Some(2));
    assert!(text(&neither).contains("--resume"), "{}", text(&neither));
    let both = workshop.run("out", &["--resume", "--force"]);
    assert_eq!(both.status.code(), Some(2), "{}", text(&both));
}

/// A checkpoint after a change of its bytes, under a checksum that is right again.
fn forged(bytes: &[u8], change: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    use sha2::Digest;
    let mut forged = bytes[..bytes.len() - 32].to_vec();
    change(&mut forged);
    let checksum = sha2::Sha256::digest(&forged);
    forged.extend(checksum);
    forged
}

/// Found by the fuzzer: a checksum tells damage, but not that numbers and head are of no run.
#[test]
fn a_forged_checkpoint_is_refused() {
    let workshop = Workshop::new(TAYLOR);
    workshop.run_well("out", &["--stop-at-step", "20"]);
    let path = workshop.path("out").join("checkpoint_000000000020.estar");
    let bytes = fs::read(&path).unwrap();
    let head_length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let number = |index: usize| 24 + head_length + 8 * index;
    let refused = |forged: Vec<u8>, reason: &str| {
        fs::write(&path, forged).unwrap();
        let said = workshop.run("out", &["--resume"]);
        assert_eq!(said.status.code(), Some(4), "{}", text(&said));
        assert!(text(&said).contains(reason), "{}", text(&said));
    };
    // the hex of the smallest Jacobian, the time
    for (index, value) in [(12, 4_294_967_295.0), (14, 1e300), (1, -1.0), (1, f64::NAN), (0, 0.5)] {
        let at = number(index);
        let change = |bytes: &mut Vec<u8>| bytes[at..at + 8].copy_from_slice(&f64::to_le_bytes(value));
        refused(forged(&bytes, change), "its numbers are those of no state of this run");
    }
    // the version stands in what is told, and must not steer the terminal or fill it
    let version = env!("CARGO_PKG_VERSION");
    let place = bytes.windows(version.len()).position(|window| window == version.as_bytes()).unwrap();
    let evil = "9\\u001b]0;x\\u0007\\u009b\\u202e\\nerror: a line of its own";
    let change = |bytes: &mut Vec<u8>| {
        bytes.splice(place..place + version.len(), evil.bytes());
        let length = (head_length + evil.len() - version.len()) as u32;
        bytes[12..16].copy_from_slice(&length.to_le_bytes());
    };
    fs::write(&path, forged(&bytes, change)).unwrap();
    let said = text(&workshop.run("out", &["--resume"]));
    assert!(said.contains("it was written by Estar 9\u{fffd}]0;x"), "{said}");
    assert_eq!(estar_io::visible(&said), said);
    assert!(!said.contains("\nerror: a line"), "{said}");
    let pending = bytes.windows(12).position(|window| window == b"\"pending\":[0").unwrap();
    refused(forged(&bytes, |bytes| bytes[pending + 11] = b'9'), "its head is that of no run of this deck");
    fs::write(&path, &bytes).unwrap();
    workshop.run_well("out", &["--resume"]);
}

/// Runs the deck until it is finished, killed with SIGKILL after each of the given times, and resumed when there is a
/// checkpoint to resume from. The number of kills that met a run.
fn killed_again_and_again(workshop: &Workshop, output: &str, mut waits: impl FnMut() -> Duration) -> u32 {
    let mut kills = 0;
    loop {
        let has_checkpoint = workshop.path(output).is_dir() && !workshop.checkpoints(output).is_empty();
        let how = if has_checkpoint { "--resume" } else { "--force" };
        let threads = if kills % 2 == 0 { "2" } else { "1" };
        let arguments = ["run", "deck.toml", "--quiet", "--output", output, how, "--threads", threads];
        let mut child = workshop.command(&arguments).spawn().unwrap();
        let end = Instant::now() + waits();
        loop {
            if let Some(status) = child.try_wait().unwrap() {
                let said = child.wait_with_output().unwrap();
                assert!(status.success(), "after {kills} kills: {}", text(&said));
                return kills;
            }
            if Instant::now() >= end {
                child.kill().unwrap();
                child.wait().unwrap();
                kills += 1;
                break;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

/// Numbers that differ from run to run, as moments of kills do.
struct Moments(u64);

impl Moments {
    fn new() -> Self {
        let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap();
        Self(now.as_nanos() as u64 | 1)
    }

    /// A time up to `longest`.
    fn next(&mut self, longest: Duration) -> Duration {
        // xorshift (Marsaglia 2003)
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        longest.mul_f64((self.0 >> 11) as f64 / (1_u64 << 53) as f64)
    }
}

fn kill_loop(least_kills: u32) {
    let mut moments = Moments::new();
    for (name, deck) in DECKS {
        let workshop = Workshop::new(deck);
        let straight = workshop.straight();
        let (mut kills, mut runs) = (0, 0);
        while kills < least_kills {
            let output = format!("killed{runs}");
            kills += killed_again_and_again(&workshop, &output, || moments.next(Duration::from_millis(400)));
            assert_same(&workshop.results(&output), &straight, &format!("{name}, run {runs}"));
            fs::remove_dir_all(workshop.path(&output)).unwrap();
            runs += 1;
        }
        println!(
            "{name}: {kills} kills in {runs} runs, no row or frame lost or doubled, state {}",
            straight.state_hash
        );
    }
}

#[test]
fn a_run_that_is_killed_at_any_moment_ends_as_the_straight_one() {
    kill_loop(6);
}

#[test]
#[ignore = "long"]
fn two_hundred_kills_lose_nothing() {
    kill_loop(70);
}

#[test]
#[ignore = "long"]
fn every_number_of_threads_straight_and_resumed_has_one_hash() {
    for (name, deck) in DECKS {
        let workshop = Workshop::new(deck);
        let straight = workshop.straight();
        for threads in ["1", "2", "3", "5", "8"] {
            let output = format!("straight{threads}");
            workshop.run_well(&output, &["--threads", threads]);
            assert_same(&workshop.results(&output), &straight, &format!("{name}, {threads} threads"));
            let output = format!("resumed{threads}");
            let half = (workshop.summary("straight")["steps"].as_u64().unwrap() * 3 / 4).to_string();
            workshop.run_well(&output, &["--stop-at-step", &half, "--threads", "2"]);
            workshop.run_well(&output, &["--resume", "--threads", threads]);
            assert_same(&workshop.results(&output), &straight, &format!("{name}, resumed on {threads} threads"));
        }
        let deleted = workshop.summary("resumed8")["deleted_elements"].as_u64();
        assert_eq!(deleted > Some(20), name == "deletion", "{deleted:?}");
        println!("{name}: threads 1, 2, 3, 5, 8, straight and resumed: state {}", straight.state_hash);
    }
}

/// Memory of a process, KiB.
#[cfg(target_os = "linux")]
fn resident_kibibytes(process: u32) -> Option<u64> {
    let status = fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.trim().trim_end_matches("kB").trim().parse().ok()
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "long"]
fn a_million_steps_keep_energy_memory_and_bits() {
    let workshop = Workshop::new(SOAK);
    let mut child = workshop.command(&["run", "deck.toml", "--quiet", "--output", "straight"]).spawn().unwrap();
    let mut memory = Vec::new();
    while child.try_wait().unwrap().is_none() {
        memory.extend(resident_kibibytes(child.id()));
        std::thread::sleep(Duration::from_millis(500));
    }
    assert!(child.wait().unwrap().success());
    let straight = workshop.results("straight");
    let history = String::from_utf8(straight.files[Path::new("history.csv")].clone()).unwrap();
    let columns: Vec<&str> = history.lines().next().unwrap().split(',').collect();
    let column = |name: &str| columns.iter().position(|column| *column == name).unwrap();
    let [step, error, kinetic] = ["step", "energy_error", "kinetic_energy"].map(column);
    let rows: Vec<Vec<f64>> =
        history.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    for row in rows.iter().step_by(rows.len() / 10) {
        println!(
            "step {:>8}: kinetic energy {:.3e} J, energy error {:+.4} %",
            row[step],
            row[kinetic],
            100.0 * row[error]
        );
    }
    let largest = rows.iter().map(|row| row[error].abs()).fold(0.0, f64::max);
    let last = rows.last().unwrap();
    // the first samples are of a process that is still setting up, the last of one that is leaving
    let settled = &memory[2..memory.len() - 1];
    let (least, most) = (settled.iter().min().unwrap(), settled.iter().max().unwrap());
    println!(
        "{} steps, largest energy error {:.4} %, {least} to {most} KiB in {} samples",
        last[step],
        100.0 * largest,
        settled.len()
    );
    assert!(last[step] > 1e6 && last[kinetic] > 1e-3 && largest < 1e-3);
    assert!(most - least < 1024, "{memory:?}");
    workshop.run_well("legs", &["--stop-at-step", "500000", "--threads", "1"]);
    workshop.run_well("legs", &["--resume", "--threads", "2"]);
    assert_same(&workshop.results("legs"), &straight, "resumed");
    println!("state {}, also stopped at half and resumed", straight.state_hash);
}
