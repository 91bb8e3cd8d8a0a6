//! Goal: whatever the machine does to a run, what it has written is whole, the message says what is wrong and the run can go on.
//!
//! A full disk: a folder stands where a file is going to be written; a limit on the size of files, which refuses them in the
//! middle; and where the system lets a test have one, a disk that is really full.

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
fn a_file_that_cannot_begin_ends_the_run_with_status_4_and_it_goes_on_later() {
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
        let in_the_way = workshop.path("deck").join(file);
        fs::create_dir(&in_the_way).unwrap();
        let said = workshop.estar(&[&["run", "deck.toml", "--resume"], arguments].concat());
        said.assert(4, &[file.trim_end_matches(".partial"), "cannot be written", "a folder is in its place"]);
        fs::remove_dir(&in_the_way).unwrap();
        assert_whole(&workshop.path("deck"));
        workshop.estar(&["run", "deck.toml", "--resume"]).assert(0, &[]);
        assert_whole(&workshop.path("deck"));
        assert_eq!(
            (state_hash(&workshop), workshop.read("deck/history.csv")),
            (straight.clone(), history.clone()),
            "{file}"
        );
    }
}

/// What a stranger may have put into a directory of results.
#[cfg(target_os = "linux")]
#[test]
fn nothing_is_written_through_a_link_or_into_a_pipe() {
    let workshop = Workshop::new();
    workshop.write("precious", "mine");
    let put = |kind: &str, path: &Path| match kind {
        "pipe" => assert!(std::process::Command::new("mkfifo").arg(path).status().unwrap().success()),
        to => std::os::unix::fs::symlink(to, path).unwrap(),
    };
    let precious = workshop.path("precious").display().to_string();
    let nowhere = workshop.path("nowhere").display().to_string();
    for file in [
        "history.csv",
        "run.jsonl",
        "estar.log",
        "estar.lock",
        "results.pvd.partial",
        "summary.json.partial",
        "fields/frame_00000.vtu.partial",
        "fields",
    ] {
        for kind in [precious.as_str(), &nowhere, "/dev/full", "pipe"] {
            let _ = fs::remove_dir_all(workshop.path("deck"));
            fs::create_dir_all(workshop.path("deck").join(if file == "fields" { "" } else { "fields" })).unwrap();
            put(kind, &workshop.path("deck").join(file));
            for how in ["--force", "--resume"] {
                if how == "--resume" && !["estar.lock", "fields"].contains(&file) {
                    continue;
                }
                workshop.write("deck.toml", DECK);
                let said = workshop.estar(&["run", "deck.toml", how]);
                said.assert(4, &[file.trim_end_matches(".partial"), "is in its place"]);
            }
            assert!(workshop.path("deck").join(file).symlink_metadata().is_ok(), "{file} is left as it is");
        }
    }
    // of a run that is to go on
    fs::remove_dir_all(workshop.path("deck")).unwrap();
    for file in ["history.csv", "run.jsonl", "estar.log"] {
        workshop.run_deck(DECK, &["--stop-at-step", "6"]).assert(0, &[]);
        let path = workshop.path("deck").join(file);
        fs::rename(&path, workshop.path("theirs")).unwrap();
        let theirs = fs::read(workshop.path("theirs")).unwrap();
        put(&workshop.path("theirs").display().to_string(), &path);
        workshop.estar(&["run", "deck.toml", "--resume"]).assert(4, &[file, "a link is in its place"]);
        assert_eq!(fs::read(workshop.path("theirs")).unwrap(), theirs, "{file}");
        fs::remove_file(&path).unwrap();
    }
    // files of another name are not written through, and plots are written beside results only
    workshop.run_deck(DECK, &[]).assert(0, &[]);
    fs::create_dir(workshop.path("elsewhere")).unwrap();
    put(&workshop.path("elsewhere").display().to_string(), &workshop.path("deck/plots"));
    workshop.estar(&["plot", "deck"]).assert(4, &["plots", "a link is in its place"]);
    assert_eq!(fs::read_dir(workshop.path("elsewhere")).unwrap().count(), 0);
    // a link that has the name of a whole file gives way to it
    fs::remove_file(workshop.path("deck/summary.json")).unwrap();
    put(&precious, &workshop.path("deck/summary.json"));
    workshop.run_deck(DECK, &[]).assert(0, &[]);
    assert!(workshop.path("deck/summary.json").symlink_metadata().unwrap().is_file());
    assert_eq!((workshop.read("precious").as_str(), workshop.path("nowhere").exists()), ("mine", false));
}

/// Whatever is read is looked at first: to open a pipe is to wait for ever, and a device has no end.
#[cfg(target_os = "linux")]
#[test]
fn devices_and_pipes_are_refused_by_every_reader() {
    let workshop = Workshop::new();
    workshop.run_deck(DECK, &["--stop-at-step", "6"]).assert(0, &[]);
    let pipe = workshop.path("pipe");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let table = "material.rubber.hardening={ law = 'tabulated', file = 'pipe' }";
    for endless in ["/dev/zero", "pipe"] {
        for (arguments, code) in [
            (&["run", endless][..], 4),
            (&["check", endless], 4),
            (&["point", endless], 4),
            (&["mesh", "info", endless], 4),
            (&["convert", endless], 4),
            (&["verify", "--list", "--cases", endless], 4),
        ] {
            workshop.estar(arguments).assert(code, &["a device or a pipe"]);
        }
    }
    workshop.run("", &["--set", "material.rubber.theory='e-star'", "--set", table]).assert(4, &["a device or a pipe"]);
    for file in ["history.csv", "checkpoint_000000000006.estar", "fields/frame_00000.vtu", "results.pvd"] {
        workshop.run_deck(DECK, &["--stop-at-step", "6"]).assert(0, &[]);
        let path = workshop.path("deck").join(file);
        fs::remove_file(&path).unwrap();
        fs::rename(&pipe, &path).unwrap();
        // a run that goes on writes the series anew
        let reader = if file == "results.pvd" { &["plot", "deck"][..] } else { &["run", "deck.toml", "--resume"] };
        workshop.estar(reader).assert(4, &[file, "a device or a pipe"]);
        fs::rename(&path, &pipe).unwrap();
    }
}

/// A disk of a few KiB, where the system lets a test have one.
#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_is_full_leaves_what_is_whole_and_the_run_goes_on_elsewhere() {
    let workshop = Workshop::new();
    let deck = format!("{DECK}{PRESSED}");
    workshop.run_deck(&deck, &[]).assert(0, &[]);
    let straight = state_hash(&workshop);
    let on_a_disk_of = |kibibytes: u32| {
        let estar = env!("CARGO_BIN_EXE_estar");
        let script = format!(
            "rm -rf small kept; mkdir small && mount -t tmpfs -o size={kibibytes}k,mode=777 tmpfs small || exit 77; \
             '{estar}' run deck.toml --output small --set output.checkpoint=\"'1e-9 s'\"; status=$?; \
             cp -a small kept; exit $status"
        );
        let mut command = std::process::Command::new("unshare");
        command.args(["-rm", "bash", "-c", &script]).current_dir(workshop.directory.path());
        command.output().map_or(77, |output| Said::of(&output).code)
    };
    let mut full = 0;
    for kibibytes in (16..160).step_by(12) {
        match on_a_disk_of(kibibytes) {
            0 => break,
            4 => full += 1,
            77 | 1 => {
                eprintln!("skipped: the system lends no disk to a test");
                return;
            }
            other => panic!("{kibibytes} KiB: status {other}"),
        }
        assert_whole(&workshop.path("kept"));
        let how = if fs::read_dir(workshop.path("kept"))
            .unwrap()
            .any(|entry| entry.unwrap().path().extension().is_some_and(|ending| ending == "estar"))
        {
            "--resume"
        } else {
            "--force"
        };
        let frequent = ["--set", "output.checkpoint='1e-9 s'"];
        workshop.estar(&[&["run", "deck.toml", "--output", "kept", how], &frequent[..]].concat()).assert(0, &[]);
        let summary: serde_json::Value = serde_json::from_str(&workshop.read("kept/summary.json")).unwrap();
        assert_eq!(summary["state_hash"], straight.as_str(), "{kibibytes} KiB");
    }
    assert!(full >= 3, "{full} disks were full");
}

#[cfg(target_os = "linux")]
#[test]
fn an_inversion_is_told_also_when_it_cannot_be_shown() {
    let workshop = Workshop::new();
    fs::create_dir_all(workshop.path("deck/trouble/fields")).unwrap();
    std::os::unix::fs::symlink("/dev/full", workshop.path("deck/trouble/results.pvd.partial")).unwrap();
    let link = workshop.path("deck/trouble/results.pvd.partial");
    let crushed = "[[fix]]\ngroup = \"x_min\"\ndirections = [\"x\"]\n[[prescribed]]\ngroup = \"x_max\"\ndirection = \"x\"\n\
                   quantity = \"displacement\"\ncurve = [[0, 0], [\"20 ms\", -3]]\n";
    let said = workshop.run(crushed, &["--set", "time.energy_error_limit=1e9"]);
    said.assert(3, &["its last steps are not shown", "trouble", "a link is in its place"]);
    fs::remove_file(link).unwrap();
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
    resume(&[]).assert(4, &["cannot be taken up", "frame_00001.vtu: is cut short", "may be removed", "--force"]);
    fs::write(&frame, &whole).unwrap();
    let history = workshop.read("deck/history.csv");
    for short in ["", &history[..history.len() / 2]] {
        fs::write(workshop.path("deck/history.csv"), short).unwrap();
        resume(&[]).assert(4, &["cannot be taken up", "history.csv", "--force"]);
    }
    fs::remove_file(workshop.path("deck/history.csv")).unwrap();
    resume(&[]).assert(4, &["cannot be taken up", "history.csv", "--force"]);
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
    for made in [
        "mesh box --cells 300 300 300",
        "mesh box --cells 70 70 70 --shape tet10",
        "mesh cylinder --core-cells 100 --rings 100 --axial-cells 100",
        "mesh cylinder --full --core-cells 20 --rings 20 --axial-cells 100 --shape tet10",
        "mesh necking-bar --core-cells 100 --rings 100 --axial-cells 100",
    ] {
        let said = limited(300_000, &format!("{made} --output big.msh #"));
        said.assert(2, &["this mesh needs about", "coarser"]);
    }
    let cases = "[[case]]\nname = \"large\"\nabout = \"a large mesh\"\ndeck = \"deck.toml\"\ncost = 1.0\n\
                 mesh = [\"cylinder\", \"--core-cells\", \"400\", \"--rings\", \"100\", \"--axial-cells\", \"100\"]\n\
                 check = [{ quantity = \"time\", value = 1.0, tolerance = 1.0, source = \"none\" }]\n";
    workshop.write("cases.toml", cases);
    let said = limited(600_000, "verify --cases cases.toml --output out #");
    said.assert(5, &["this mesh needs about"]);
    limited(4_000_000, "check deck.toml").assert(0, &[]);
}

/// Goal: the memory that is told before a mesh is made is what it takes, and never much more.
#[cfg(target_os = "linux")]
#[test]
fn the_memory_told_for_a_new_mesh_is_the_memory_taken() {
    use estar_deck::memory::{MeshSize, of_new_mesh};
    use estar_mesh::Shape;
    let workshop = Workshop::new();
    let peak = |command: &str| -> f64 {
        let estar = env!("CARGO_BIN_EXE_estar");
        let script = format!(
            "import resource, subprocess\nsubprocess.run({command:?}.split(), executable={estar:?}, check=True, \
             stdout=subprocess.DEVNULL)\nprint(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024)"
        );
        let mut python = std::process::Command::new("python3");
        let output = python.args(["-c", &script]).current_dir(workshop.directory.path()).output().unwrap();
        Said::of(&output).text.trim().parse().unwrap()
    };
    if std::process::Command::new("python3").arg("--version").output().is_err() {
        eprintln!("skipped: there is no python3 to measure with");
        return;
    }
    // what the program takes that makes no mesh
    let nothing = 5e6;
    for cells in [[48, 48, 48], [300, 300, 1], [1, 1, 60_000]] {
        for (shape, name) in
            [(Shape::Hex8, "hex8"), (Shape::Wedge6, "wedge6"), (Shape::Tet4, "tet4"), (Shape::Tet10, "tet10")]
        {
            let [x, y, z] = cells;
            let command = format!("estar mesh box --force --output m.msh --cells {x} {y} {z} --shape {name}");
            let taken = peak(&command) - nothing;
            let told = of_new_mesh(MeshSize::of_box(cells), shape) as f64;
            println!("{cells:?} {name}: told {told:.3e} bytes, taken {taken:.3e}");
            assert!(taken <= 1.05 * told && told < 1.6 * taken, "{cells:?} {name}: told {told:.3e}, taken {taken:.3e}");
        }
    }
}
