//! Goal: whatever the machine does to a run, what it has written is whole, the message says what is wrong and the run can go on.
//!
//! A full disk: a device that refuses every byte stands where a file is going to be written; and a limit on the size of files,
//! which refuses them in the middle.

mod common;

use common::{DECK, Said, Workshop};
use std::fs;
use std::path::Path;

/// A box that is pressed, slowly.
const PRESSED: &str = "[[fix]]\ngroup = \"x_min\"\ndirections = [\"x\"]\n\
                       [[pressure]]\ngroup = \"x_max\"\ncurve = [[0, 0], [\"20 ms\", \"1 MPa\"]]\n";

/// Asserts that every file of the results is whole: frames, their list, rows, records.
#[track_caller]
fn assert_whole(directory: &Path) {
    let mut folders = vec![directory.to_owned()];
    while let Some(folder) = folders.pop() {
        for path in fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()) {
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            assert!(!name.ends_with(".partial"), "{name}");
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let bytes = fs::read(&path).unwrap();
            let text = String::from_utf8_lossy(&bytes);
            match name.rsplit('.').next().unwrap() {
                "vtu" | "pvd" => assert!(text.trim_end().ends_with("</VTKFile>"), "{name} is cut short"),
                "csv" => {
                    let columns = |line: &str| line.matches(',').count();
                    let header = text.lines().next().map_or(0, columns);
                    assert!(text.is_empty() || text.ends_with('\n'), "{name} is cut short");
                    assert!(text.lines().all(|line| columns(line) == header), "{name}");
                }
                "jsonl" => {
                    for line in text.lines() {
                        serde_json::from_str::<serde_json::Value>(line).unwrap();
                    }
                }
                "json" => {
                    serde_json::from_str::<serde_json::Value>(&text).unwrap();
                }
                _ => {}
            }
        }
    }
    let series = fs::read_to_string(directory.join("results.pvd")).unwrap_or_default();
    for name in series.split("file=\"").skip(1).map(|rest| rest.split('"').next().unwrap()) {
        assert!(directory.join(name).is_file(), "results.pvd lists {name}");
    }
}

fn state_hash(workshop: &Workshop) -> String {
    workshop.summary()["state_hash"].as_str().unwrap().to_owned()
}

#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_is_full_when_a_file_begins_ends_with_status_4_and_the_run_goes_on_later() {
    let workshop = Workshop::new();
    let deck = format!("{DECK}{PRESSED}");
    workshop.run_deck(&deck, &[]).assert(0, &[]);
    let (straight, history) = (state_hash(&workshop), workshop.read("deck/history.csv"));
    let later = "checkpoint_000000000009.estar";
    for (file, arguments) in [
        ("results.pvd.partial", &[][..]),
        ("fields/frame_00003.vtu.partial", &[]),
        ("summary.json.partial", &[]),
        (&format!("{later}.partial"), &["--stop-at-step", "9"]),
    ] {
        workshop.run_deck(&deck, &["--stop-at-step", "6"]).assert(0, &[]);
        std::os::unix::fs::symlink("/dev/full", workshop.path("deck").join(file)).unwrap();
        let said = workshop.estar(&[&["run", "deck.toml", "--resume"], arguments].concat());
        said.assert(4, &[file.trim_end_matches(".partial"), "cannot be written", "No space left on device"]);
        assert_whole(&workshop.path("deck"));
        workshop.estar(&["run", "deck.toml", "--resume"]).assert(0, &[]);
        assert_whole(&workshop.path("deck"));
        assert_eq!(
            (state_hash(&workshop), workshop.read("deck/history.csv")),
            (straight.clone(), history.clone()),
            "{file}"
        );
    }
    // these grow, and are there from the beginning
    for (file, code) in [("history.csv", 4), ("run.jsonl", 4), ("estar.log", 0), ("estar.lock", 4)] {
        fs::remove_dir_all(workshop.path("deck")).unwrap();
        fs::create_dir_all(workshop.path("deck")).unwrap();
        std::os::unix::fs::symlink("/dev/full", workshop.path("deck").join(file)).unwrap();
        workshop.run_deck(&deck, &[]).assert(code, &[file, "cannot be written"]);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn an_inversion_is_told_also_when_it_cannot_be_shown() {
    let workshop = Workshop::new();
    fs::create_dir_all(workshop.path("deck/trouble/fields")).unwrap();
    std::os::unix::fs::symlink("/dev/full", workshop.path("deck/trouble/results.pvd.partial")).unwrap();
    let crushed = "[[fix]]\ngroup = \"x_min\"\ndirections = [\"x\"]\n[[prescribed]]\ngroup = \"x_max\"\ndirection = \"x\"\n\
                   quantity = \"displacement\"\ncurve = [[0, 0], [\"20 ms\", -3]]\n";
    let said = workshop.run(crushed, &["--set", "time.energy_error_limit=1e9"]);
    said.assert(3, &["its last steps are not shown", "trouble", "No space left on device"]);
    assert_whole(&workshop.path("deck"));
}

/// Runs the deck where no file may be longer than so many blocks of 1 KiB.
#[cfg(target_os = "linux")]
fn run_within(workshop: &Workshop, blocks: u32, arguments: &str) -> Said {
    let estar = env!("CARGO_BIN_EXE_estar");
    let script = format!("ulimit -f {blocks}; exec '{estar}' run deck.toml {arguments}");
    let mut command = std::process::Command::new("bash");
    command.args(["-c", &script]).current_dir(workshop.directory.path());
    Said::of(&command.output().unwrap())
}

#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_is_full_in_the_middle_of_a_file_leaves_no_half_of_it() {
    let workshop = Workshop::new();
    let deck = format!("{DECK}{PRESSED}");
    workshop.run_deck(&deck, &["--set", "output.history_steps=1"]).assert(0, &[]);
    let straight = state_hash(&workshop);
    let mut refused = std::collections::BTreeSet::new();
    for blocks in 1..40 {
        let said = run_within(&workshop, blocks, "--force --set output.history_steps=1");
        if said.code == 0 {
            continue;
        }
        said.assert(4, &["cannot be written", "File too large", "everything written before can be read"]);
        let name = said.errors.split(": cannot be written").next().unwrap();
        refused.insert(name.rsplit('/').next().unwrap().trim_end_matches(|c: char| c.is_ascii_digit()).to_owned());
        assert_whole(&workshop.path("deck"));
    }
    let refused: Vec<&str> = refused.iter().map(String::as_str).collect();
    assert!(refused.contains(&"history.csv") && refused.iter().any(|name| name.ends_with(".vtu")), "{refused:?}");
    // a checkpoint that does not fit leaves the one before
    workshop.run_deck(&deck, &["--stop-at-step", "6", "--set", "output.history_steps=1"]).assert(0, &[]);
    let size = fs::metadata(workshop.path("deck/checkpoint_000000000006.estar")).unwrap().len();
    let blocks = (size / 1024) as u32;
    let said = run_within(&workshop, blocks, "--resume --stop-at-step 7 --set output.history_steps=1");
    said.assert(4, &["checkpoint_000000000007.estar: cannot be written: File too large"]);
    assert_whole(&workshop.path("deck"));
    workshop.estar(&["run", "deck.toml", "--resume", "--set", "output.history_steps=1"]).assert(0, &[]);
    assert_eq!(state_hash(&workshop), straight);
}

#[test]
fn a_directory_that_goes_away_ends_the_run_with_status_4() {
    let workshop = Workshop::new();
    workshop.write("deck.toml", DECK);
    let endless = ["run", "deck.toml", "--set", "time.end=1e6", "--set", "output.frames=1000000"];
    let child = workshop.start(&endless);
    workshop.wait_for("deck/run.jsonl");
    fs::rename(workshop.path("deck"), workshop.path("gone")).unwrap();
    fs::remove_dir_all(workshop.path("gone")).unwrap();
    Said::of(&child.wait_with_output().unwrap())
        .assert(4, &["deck/", "cannot be written", "No such file or directory"]);
}

#[cfg(unix)]
#[test]
fn a_directory_that_may_not_be_written_is_told_before_anything_is_computed() {
    use std::os::unix::fs::PermissionsExt;
    let workshop = Workshop::new();
    workshop.run("", &["--output", "/dev/null"]).assert(4, &["/dev/null is a file, not a directory"]);
    workshop.run("", &["--output", "/dev/null/results"]).assert(4, &["/dev/null/results", "cannot be written"]);
    // nobody may make directories here, not even the administrator
    if cfg!(target_os = "linux") {
        workshop.run("", &["--output", "/proc/results"]).assert(4, &["/proc/results", "cannot be written"]);
    }
    fs::create_dir(workshop.path("closed")).unwrap();
    fs::set_permissions(workshop.path("closed"), fs::Permissions::from_mode(0o555)).unwrap();
    if fs::write(workshop.path("closed/try"), "").is_ok() {
        eprintln!("skipped: the administrator may write anywhere");
        return;
    }
    workshop.run("", &["--output", "closed"]).assert(4, &["closed", "cannot be written: Permission denied"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_signal_that_is_ignored_when_the_program_begins_does_not_stop_the_run() {
    let workshop = Workshop::new();
    workshop.write("deck.toml", DECK);
    let estar = env!("CARGO_BIN_EXE_estar");
    let script = format!("trap '' HUP; exec '{estar}' run deck.toml --force --set time.end=1e6 --set output.frames=2");
    let mut child = std::process::Command::new("bash")
        .args(["-c", &script])
        .current_dir(workshop.directory.path())
        .stdout(std::process::Stdio::null())
        .spawn()
        .unwrap();
    workshop.wait_for("deck/run.jsonl");
    let kill = |signal: &str| {
        let status = std::process::Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
        assert!(status.success());
    };
    kill("-HUP");
    std::thread::sleep(std::time::Duration::from_millis(300));
    kill("-TERM");
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let steps = workshop.summary()["steps"].as_u64().unwrap();
    let records = workshop.read("deck/run.jsonl");
    assert!(steps > 0 && workshop.summary()["status"] == "interrupted", "{records}");
}

#[test]
fn outputs_that_are_gone_or_cut_short_are_named_before_a_run_goes_on() {
    let workshop = Workshop::new();
    workshop.run_deck(DECK, &["--stop-at-step", "9"]).assert(0, &[]);
    let frame = workshop.path("deck/fields/frame_00001.vtu");
    let whole = fs::read(&frame).unwrap();
    fs::write(&frame, &whole[..whole.len() / 2]).unwrap();
    let resume = |arguments: &[&str]| workshop.estar(&[&["run", "deck.toml", "--resume"], arguments].concat());
    resume(&[]).assert(4, &["cannot go on", "frame_00001.vtu: is cut short", "--force"]);
    fs::remove_file(&frame).unwrap();
    resume(&[]).assert(4, &["cannot go on", "frame_00001.vtu: cannot be read", "--force"]);
    fs::write(&frame, &whole).unwrap();
    let history = workshop.read("deck/history.csv");
    fs::write(workshop.path("deck/history.csv"), history.lines().next().unwrap()).unwrap();
    resume(&[]).assert(4, &["cannot go on", "history.csv", "--force"]);
    fs::write(workshop.path("deck/history.csv"), history).unwrap();
    resume(&["--stop-at-step", "5"]).assert(2, &["--stop-at-step 5 lies before step 9"]);
    resume(&[]).assert(0, &[]);
}

#[test]
fn a_second_run_in_a_directory_is_told_who_has_it() {
    let workshop = Workshop::new();
    workshop.write("deck.toml", DECK);
    let mut first = workshop.start(&["run", "deck.toml", "--set", "time.end=1e6"]);
    workshop.wait_for("deck/run.jsonl");
    let process = format!("process {}", first.id());
    for how in ["--force", "--resume"] {
        workshop.estar(&["run", "deck.toml", how]).assert(4, &["deck is written to by", &process, "--output"]);
    }
    first.kill().unwrap();
    first.wait().unwrap();
    // the lock goes with its owner, however that ends
    workshop.estar(&["run", "deck.toml", "--force"]).assert(0, &[]);
}

#[test]
fn more_threads_than_cores_are_used_and_said_to_be_no_faster() {
    let workshop = Workshop::new();
    let said = workshop.run("", &["--threads", "200"]);
    said.assert(0, &[]);
    let cores = std::thread::available_parallelism().unwrap().get();
    if cores < 200 {
        assert!(said.text.contains(&format!("200 threads (on {cores} cores, which is no faster)")), "{}", said.text);
    }
    workshop.run("", &["--threads", "0"]).assert(2, &["a whole number from 1 to 4096"]);
    workshop.run("", &["--threads", "4097"]).assert(2, &["a whole number from 1 to 4096"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_run_that_does_not_fit_into_memory_is_refused_before_it_begins() {
    let workshop = Workshop::new();
    let cells = ["--cells", "60", "60", "60", "--force"];
    workshop.estar(&[&["mesh", "box", "--output", "box.msh"], &cells[..]].concat()).assert(0, &[]);
    workshop.write("deck.toml", DECK);
    let limited = |kibibytes: u32, command: &str| {
        let estar = env!("CARGO_BIN_EXE_estar");
        let script = format!("ulimit -v {kibibytes}; exec '{estar}' {command} --threads 1");
        let mut shell = std::process::Command::new("bash");
        Said::of(&shell.args(["-c", &script]).current_dir(workshop.directory.path()).output().unwrap())
    };
    for command in ["run deck.toml", "check deck.toml"] {
        limited(300_000, command).assert(2, &["this run needs about", "MiB are left", "coarser mesh"]);
        limited(70_000, command).assert(2, &["reading box.msh needs about", "deck.toml:5:8", "coarser mesh"]);
    }
    assert!(!workshop.path("deck").exists(), "nothing is written before");
    limited(300_000, "mesh box --cells 300 300 300 --output big.msh #")
        .assert(2, &["this mesh needs about", "coarser"]);
    limited(4_000_000, "check deck.toml").assert(0, &[]);
}
