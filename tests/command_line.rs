//! The program as a user meets it: what the commands write, say and return.

mod common;

use common::{DECK, Said, Workshop};
use estar::bench::taylor_bar::{ELEMENTS, materials};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

#[test]
fn a_run_leaves_all_its_files() {
    let workshop = Workshop::new();
    let said = workshop
        .run("[[probe]]\nname = \"place\"\nkind = \"node\"\nlabel = 1\nfield = \"position\"\ncomponent = \"x\"\n", &[]);
    said.assert(0, &[]);
    assert!(said.text.contains("A box flies") && said.text.contains("8 hexes") && said.text.contains("finished"));

    let history = workshop.read("deck/history.csv");
    let mut lines = history.lines();
    assert_eq!(
        lines.next().unwrap(),
        "time,step,time_step,kinetic_energy,internal_energy,plastic_dissipation,viscous_energy,hourglass_energy,\
         external_work,contact_energy,mass_scaling_energy,energy_error,momentum_x,momentum_y,momentum_z,\
         max_equivalent_plastic_strain,min_jacobian,controlling_element,place"
    );
    let rows: Vec<Vec<f64>> = lines.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    assert_eq!((rows[0][0], rows[0][1]), (0.0, 0.0));
    assert!((rows[0][3] - 500.0).abs() < 1e-9 && (rows[0][12] - 1000.0).abs() < 1e-9, "{:?}", rows[0]);
    assert!(rows.windows(2).all(|pair| pair[0][1] < pair[1][1]));
    let last = rows.last().unwrap();
    assert!((last[0] - 0.02).abs() < 1e-15 && (last[18] - 0.02).abs() < 1e-12, "{last:?}");

    let series = workshop.read("deck/results.pvd");
    assert_eq!(series.matches("<DataSet ").count(), 5);
    assert!(series.contains("timestep=\"0.0\"") && series.contains("timestep=\"0.02\""), "{series}");
    assert!((0..5).all(|number| workshop.path(&format!("deck/fields/frame_{number:05}.vtu")).is_file()));
    let frame = fs::read(workshop.path("deck/fields/frame_00004.vtu")).unwrap();
    let frame = String::from_utf8_lossy(&frame);
    for name in [
        "displacement",
        "velocity",
        "cauchy_stress",
        "von_mises_stress",
        "pressure",
        "volume_ratio",
        "part",
        "element_id",
    ] {
        assert!(frame.contains(&format!("Name=\"{name}\"")), "{name}");
    }

    let summary = workshop.summary();
    assert_eq!(summary["status"], "finished");
    assert_eq!(summary["mesh"]["elements"], 8);
    assert_eq!(summary["state_hash"].as_str().unwrap().len(), 64);
    assert!((summary["energies"]["kinetic_energy"].as_f64().unwrap() - 500.0).abs() < 1e-9);
    assert!((summary["probes"]["place"].as_f64().unwrap() - 0.02).abs() < 1e-12);
    for line in workshop.read("deck/run.jsonl").lines() {
        let record: serde_json::Value = serde_json::from_str(line).unwrap();
        assert!(record["time"].is_number() && record["step"].is_number() && record["energy_error"].is_number());
    }
    assert!(workshop.read("deck/estar.log").contains("A box flies"));
}

#[test]
fn results_are_overwritten_only_by_force() {
    let workshop = Workshop::new();
    workshop.write("deck.toml", DECK);
    workshop.estar(&["run", "deck.toml", "--quiet"]).assert(0, &[]);
    workshop.write("deck/notes.txt", "mine");
    workshop.estar(&["run", "deck.toml"]).assert(2, &["holds results already", "--force"]);
    let said = workshop.estar(&["run", "deck.toml", "--force", "--quiet", "--set", "output.frames=2"]);
    said.assert(0, &[]);
    assert_eq!(said.text, "");
    assert_eq!(workshop.read("deck/notes.txt"), "mine");
    assert!(!workshop.path("deck/fields/frame_00003.vtu").exists());
}

#[test]
fn bits_depend_neither_on_threads_nor_on_lanes_nor_on_output() {
    let workshop = Workshop::new();
    let spin = "[[initial_velocity]]\ngroup = \"x_max\"\nangular = { rate = [0.0, 20.0, 3.0] }\n";
    let mut hashes = Vec::new();
    for arguments in [
        &["--threads", "1"][..],
        &["--threads", "3"],
        &["--lanes", "portable"],
        &["--set", "output.frames=1", "--set", "output.history_steps=7"],
    ] {
        workshop.run(spin, arguments).assert(0, &[]);
        hashes.push(workshop.summary()["state_hash"].as_str().unwrap().to_owned());
    }
    assert!(hashes.iter().all(|hash| *hash == hashes[0]), "{hashes:?}");
    workshop.run("", &[]).assert(0, &[]);
    assert_ne!(workshop.summary()["state_hash"], hashes[0].as_str());
}

#[test]
fn every_probe_sees_the_free_flight() {
    let probe = |name: &str, keys: &str, value: &str| {
        format!(
            "[[probe]]\nname = \"{name}\"\n{keys}\n[[expect]]\nprobe = \"{name}\"\nvalue = {value}\ntolerance = 1e-9\n"
        )
    };
    let node = "field = \"displacement\"\ncomponent = \"x\"";
    let hex = "field = \"cauchy_stress\"\ncomponent = \"xx\"";
    let probes = [
        probe("extent", "kind = \"extent\"\ngroup = \"box\"\naxis = \"x\"", "1.0"),
        probe(
            "radius",
            "kind = \"max-radius\"\ngroup = \"x_min\"\naxis = \"x\"\ncentre = [0, 0.5, \"500 mm\"]",
            "0.7071067811865476",
        ),
        probe("reaction", "kind = \"reaction\"\ngroup = \"y_min\"\ndirection = \"y\"", "\"0 N\""),
        probe("node", &format!("kind = \"node\"\nlabel = 5\n{node}"), "\"20 mm\""),
        probe("element", &format!("kind = \"element\"\nlabel = 3\n{hex}"), "0.0"),
        probe("nodes", &format!("kind = \"group-average\"\ngroup = \"y_max\"\n{node}"), "0.02"),
        probe("hexes", "kind = \"group-average\"\ngroup = \"box\"\nfield = \"volume_ratio\"", "1.0"),
        probe("fastest", "kind = \"maximum\"\ngroup = \"box\"\nfield = \"velocity\"\ncomponent = \"magnitude\"", "1.0"),
        probe("strain", "kind = \"maximum\"\ngroup = \"box\"\nfield = \"equivalent_plastic_strain\"", "0"),
    ];
    let workshop = Workshop::new();
    let fix = "[[fix]]\ngroup = \"y_min\"\ndirections = [\"y\"]\n";
    workshop.run(&format!("{fix}{}", probes.concat()), &[]).assert(0, &[]);
    assert_eq!(workshop.summary()["expectations"].as_array().unwrap().len(), 9);
    assert_eq!(workshop.summary()["expectations_met"], true);
}

#[test]
fn wrong_probes_are_told_all_at_once() {
    let workshop = Workshop::new();
    let probe = |name: &str, keys: &str| format!("[[probe]]\nname = \"{name}\"\n{keys}\n");
    let probes = [
        probe("a", "kind = \"node\"\nlabel = 999\nfield = \"velocity\"\ncomponent = \"x\""),
        probe("b", "kind = \"node\"\ngroup = \"x_min\"\nfield = \"velocity\"\ncomponent = \"x\""),
        probe("c", "kind = \"element\"\nlabel = 1\nfield = \"velocity\"\ncomponent = \"x\""),
        probe("d", "kind = \"maximum\"\ngroup = \"x_min\"\nfield = \"pressure\""),
        probe("e", "kind = \"maximum\"\ngroup = \"box\"\nfield = \"velocity\""),
        probe("f", "kind = \"maximum\"\ngroup = \"box\"\nfield = \"pressure\"\ncomponent = \"x\""),
        probe("g", "kind = \"element\"\nlabel = 1\nfield = \"cauchy_stress\"\ncomponent = \"x\""),
        probe("h", "kind = \"element\"\nlabel = 99\nfield = \"pressure\""),
        probe("time", "kind = \"extent\"\ngroup = \"box\"\naxis = \"x\""),
        "[[expect]]\nprobe = \"time\"\nvalue = \"3 N\"\ntolerance = \"1 %\"\nat = \"1 s\"\n".to_owned(),
    ];
    workshop.run(&probes.concat(), &[]).assert(
        2,
        &[
            "the mesh has no node with the number 999",
            "its nodes are 1 to 27",
            "the mesh has no element with the number 99",
            "its elements are 1 to 8",
            "the group `x_min` has 9 nodes",
            "does not live on an element",
            "is a surface, but the field lives on elements",
            "`component` must say which",
            "this field has no components",
            "this field has no component `x`",
            "has the name of a column",
            "`expect.value` is a force, but the probe `time` gives a length",
            "lies after the end",
        ],
    );
}

#[test]
fn a_missed_expectation_ends_with_status_5_and_a_table() {
    let workshop = Workshop::new();
    let probe = "[[probe]]\nname = \"x\"\nkind = \"node\"\nlabel = 1\nfield = \"position\"\ncomponent = \"x\"\n";
    let expect = "[[expect]]\nprobe = \"x\"\nat = \"10 ms\"\nvalue = \"30 mm\"\ntolerance = \"10 %\"\n";
    let said = workshop.run(&format!("{probe}{expect}"), &[]);
    said.assert(5, &["1 of 1 expectations missed"]);
    assert!(said.text.contains("MISSED") && said.text.contains("3.000000e-2"), "{}", said.text);
    let largest = "[[expect]]\nprobe = \"x\"\nat = \"max\"\nvalue = \"20 mm\"\ntolerance = \"1e-9 mm\"\n";
    let summary = || workshop.summary()["expectations"].clone();
    let outcome = &summary()[0];
    let (time, found) = (outcome["time"].as_f64().unwrap(), outcome["found"].as_f64().unwrap());
    // the first step at or after the time counts, and the row with the largest value
    assert!((0.01..0.02).contains(&time) && (found - time).abs() < 1e-12);
    workshop.run(&format!("{probe}{largest}"), &[]).assert(0, &[]);
    assert!((summary()[0]["time"].as_f64().unwrap() - 0.02).abs() < 1e-12);
}

#[test]
fn faults_of_deck_and_mesh_are_told_at_once() {
    let workshop = Workshop::new();
    let deck = DECK.replace("group = \"box\"\nmaterial", "group = \"bax\"\nmaterial").replace("\"20 ms\"", "\"20 mm\"");
    workshop.run_deck(&deck, &[]).assert(
        2,
        &[
            "the mesh has no group `bax`",
            "did you mean \"box\"?",
            "must be a time, not a length",
            "deck.toml:14:9",
            "2 errors",
        ],
    );
    let wrong_kind = DECK.replace("group = \"box\"\nmaterial", "group = \"x_min\"\nmaterial");
    workshop.run_deck(&wrong_kind, &[]).assert(2, &["the group `x_min` is a surface, but a volume is needed"]);
}

#[test]
fn a_flow_rule_that_loses_the_plastic_metric_is_refused_for_elements() {
    let workshop = Workshop::new();
    let told = |rule: &str, code: i32, words: &[&str]| {
        let hardening = "hardening = { law = \"perfect\", yield_stress = \"1 MPa\" }";
        let theory = format!("theory = \"plastic-metric\"\nflow_rule = \"{rule}\"\n{hardening}");
        workshop.run_deck(&DECK.replace("theory = \"elastic\"", &theory), &[]).assert(code, words);
    };
    told("simo-hughes", 2, &["`rubber` is for `estar point` only", "does not keep det C_p = 1"]);
    told("frobenius-normal", 2, &["`rubber` is for `estar point` only", "does not keep C_p symmetric"]);
    for rule in ["simo-miehe", "miehe", "lion", "helm", "grandi-stefanelli"] {
        told(rule, 0, &[]);
    }
}

#[test]
fn parts_must_own_every_hex_once() {
    let workshop = Workshop::new();
    let twice = "[[part]]\ngroup = \"box\"\nmaterial = \"rubber\"\n";
    workshop.run(twice, &[]).assert(2, &["8 elements are in two parts", "the first part", "the second part"]);
    workshop.run("", &["--set", "part=[]"]).assert(2, &["8 elements belong to no part", "volume group `box`"]);
}

#[test]
fn contradictory_constraints_are_told_with_both_places() {
    let workshop = Workshop::new();
    let fix = "[[fix]]\ngroup = \"x_min\"\ndirections = [\"x\", \"y\"]\n";
    let pull = |group: &str, end: &str| {
        format!(
            "[[prescribed]]\ngroup = \"{group}\"\ndirection = \"y\"\nquantity = \"displacement\"\ncurve = [[0, 0], [1, {end}]]\n"
        )
    };
    let both = workshop.run(&format!("{fix}{}", pull("y_min", "0.1")), &[]);
    both.assert(2, &["3 nodes, among them node", "both fixed and prescribed in y", "fixed here", "prescribed here"]);
    let two = workshop.run(&format!("{}{}", pull("y_min", "0.1"), pull("x_max", "0.2")), &[]);
    two.assert(2, &["prescribed in y in two ways", "first prescribed here"]);
    let same = workshop.run(&format!("{}{}", pull("y_min", "1e-9"), pull("x_max", "1e-9")), &[]);
    same.assert(0, &[]);
    let nothing = workshop.run("[[fix]]\ngroup = \"x_min\"\ndirections = []\n", &[]);
    nothing.assert(2, &["`fix.directions` is empty"]);
    let jump = workshop.run(&pull("y_min", "0.1").replace("[0, 0]", "[0, 0.1]"), &[]);
    jump.assert(2, &["jumps to 0.1 m at time 0"]);
    // the noise of a gauge is no jump
    let noise = workshop.run(&pull("y_min", "1e-4").replace("[0, 0]", "[0, -3.7e-9]"), &[]);
    noise.assert(0, &["`prescribed.curve` begins with -3.7e-9 m, which is taken as 0", "the first point"]);
}

#[test]
fn a_wall_through_the_body_is_refused() {
    let workshop = Workshop::new();
    let wall = "[[rigid_wall]]\npoint = [0.5, 0, 0]\nnormal = [1, 0, 0]\n";
    workshop.run(wall, &[]).assert(2, &["9 nodes lie behind the wall at time 0", "this wall"]);
}

#[test]
fn loads_and_walls_do_the_work_that_the_ledger_says() {
    let workshop = Workshop::new();
    let loads = "[[gravity]]\nacceleration = [0, 0, -10]\n\
                 [[pressure]]\ngroup = \"z_max\"\ncurve = [[0, 0], [\"10 ms\", \"1 kPa\"]]\n\
                 [[traction]]\ngroup = \"x_max\"\ndirection = [0, 3, 0]\ncurve = [[0, 500]]\n\
                 [[rigid_wall]]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nfriction = 0.2\n";
    workshop.run(loads, &[]).assert(0, &[]);
    let energies = &workshop.summary()["energies"];
    let works = energies["load_work"].as_object().unwrap();
    let names: Vec<&str> = works.keys().map(String::as_str).collect();
    assert_eq!(names, ["gravity", "pressure on z_max", "traction on x_max"]);
    assert!(works.values().all(|work| work.as_f64().unwrap() > 0.0), "{works:?}");
    assert!(workshop.summary()["energy_error"].as_f64().unwrap().abs() < 1e-3);
}

#[test]
fn missing_and_unusable_files_have_their_status() {
    let workshop = Workshop::new();
    workshop.estar(&["run", "nowhere.toml"]).assert(4, &["nowhere.toml"]);
    workshop.run("", &["--set", "mesh.file='nowhere.msh'"]).assert(4, &["nowhere.msh", "--set mesh.file"]);
    workshop.write("garbage.msh", "\u{0}\u{1}garbage");
    workshop.run("", &["--set", "mesh.file='garbage.msh'"]).assert(2, &["garbage.msh"]);
    fs::write(workshop.path("latin.toml"), b"title = \"\xe9\"").unwrap();
    workshop.estar(&["run", "latin.toml"]).assert(2, &["latin.toml:1", "UTF-8", "column 10"]);
    workshop.write("empty.toml", "");
    workshop.estar(&["run", "empty.toml"]).assert(2, &["lacks `mesh`"]);
    workshop.run("", &["--output", "box.msh"]).assert(4, &["box.msh is a file"]);
    workshop.run("", &["--output", "box.msh/results"]).assert(4, &[]);
    workshop.estar(&["run", "."]).assert(4, &[]);
}

#[test]
fn a_table_of_an_override_takes_the_place_of_the_deck_s() {
    let workshop = Workshop::new();
    let law = r#"material.rubber.hardening={ law = "perfect", yield_stress = "1 MPa" }"#;
    let deck = DECK.replace(
        "theory = \"elastic\"",
        "theory = \"e-star\"\nhardening = { law = \"linear\", yield_stress = \"1 MPa\", modulus = \"1 MPa\" }",
    );
    workshop.run_deck(&deck, &["--set", law]).assert(0, &[]);
    workshop.run_deck(&deck, &["--set", "time={ max_steps = 3 }"]).assert(2, &["`time` lacks `end`"]);
    workshop.run_deck(&deck, &["--set", "part=[]"]).assert(2, &["part"]);
}

#[test]
fn tables_of_other_files_are_read_and_belong_to_the_run() {
    let workshop = Workshop::new();
    let deck = DECK
        .replace("theory = \"elastic\"", "theory = \"e-star\"\nhardening = { law = \"tabulated\", file = \"t.csv\" }");
    workshop.run_deck(&deck, &[]).assert(4, &["t.csv", "No such file"]);
    for (text, fault) in
        [("0 1e6\n1 2e6\n", "line 2 of t.csv"), ("a,b\nc,d\n0,1e6\n", "line 2 of t.csv"), ("", "one point")]
    {
        workshop.write("t.csv", text);
        workshop.run_deck(&deck, &[]).assert(2, &[fault]);
    }
    workshop.write("t.csv", "strain,stress\n0,1e6\n1,2e6\n");
    workshop.run_deck(&deck, &["--stop-at-step", "5"]).assert(0, &[]);
    workshop.write("t.csv", "strain,stress\n0,3e6\n1,9e6\n");
    workshop.estar(&["run", "deck.toml", "--resume"]).assert(4, &["it is of another deck"]);
}

#[test]
fn hourglass_control_is_chosen_where_there_is_one() {
    let workshop = Workshop::new();
    let one_point = ["--set", "part.0.element='hex8-one-point'"];
    for control in ["physical", "stiffness", "viscous"] {
        let set = format!("part.0.hourglass='{control}'");
        workshop.run("", &[&one_point[..], &["--set", &set]].concat()).assert(0, &[]);
    }
    workshop
        .run("", &["--set", "part.0.hourglass='viscous'"])
        .assert(2, &["need no hourglass control", "hex8-one-point"]);
    let coefficient = ["--set", "part.0.hourglass_coefficient=0.1"];
    workshop.run("", &[&one_point[..], &coefficient].concat()).assert(2, &["`physical` has no coefficient"]);
    let stiff = ["--set", "part.0.hourglass='stiffness'"];
    workshop.run("", &[&one_point[..], &stiff, &coefficient].concat()).assert(0, &[]);
    let part = &workshop.summary()["parts"][0];
    assert!(part["internal_energy"].is_number() && part["hourglass_energy"].is_number(), "{part}");
    // a slender beam of two layers bends, and a quarter of that is hourglass
    let beam = ["mesh", "box", "--output", "beam.msh", "--size", "8 m", "1 m", "1 m", "--cells", "8", "2", "2"];
    workshop.estar(&beam).assert(0, &[]);
    let bent = "[[fix]]\ngroup = \"x_min\"\ndirections = [\"x\", \"y\", \"z\"]\n\
                [[traction]]\ngroup = \"x_max\"\ndirection = [0, 0, 1]\ncurve = [[0, 0], [\"0.2 s\", \"1 kPa\"]]\n";
    let set = ["--set", "mesh.file='beam.msh'", "--set", "time.end='0.2 s'", "--set", "initial_velocity=[]"];
    let said = workshop.run(bent, &[&one_point[..], &set].concat());
    said.assert(0, &["warning: the hourglass control of part box has taken", "where up to 10 % is sound"]);
    let said = workshop.run(bent, &set);
    said.assert(0, &[]);
    assert!(!said.errors.contains("hourglass"), "{}", said.errors);
}

#[test]
fn wrong_command_lines_end_with_status_2() {
    let workshop = Workshop::new();
    workshop.write("deck.toml", DECK);
    workshop.estar(&[]).assert(2, &["Usage"]);
    workshop.estar(&["runn", "deck.toml"]).assert(2, &["run"]);
    workshop.estar(&["run", "deck.toml", "--threads", "0"]).assert(2, &["a whole number from 1"]);
    workshop.estar(&["run", "deck.toml", "--set", ""]).assert(2, &["sets nothing", "KEY=VALUE"]);
    workshop.estar(&["run", "deck.toml", "--lanes", "mmx"]).assert(2, &["portable"]);
    workshop.estar(&["run", "deck.toml", "--set", "time.end=1 us"]).assert(2, &["--set 'time.end=\"1 us\"'"]);
    assert_eq!(workshop.estar(&["--help"]).code, 0);
    assert!(workshop.estar(&["--version"]).text.starts_with("estar "));
}

/// A box that is pressed to nothing and turned inside out.
const CRUSH: &str = "[[fix]]\ngroup = \"x_min\"\ndirections = [\"x\"]\n\
                     [[prescribed]]\ngroup = \"x_max\"\ndirection = \"x\"\nquantity = \"displacement\"\n\
                     curve = [[0, 0], [\"20 ms\", -3]]\n";
const UNBALANCED: [&str; 2] = ["--set", "time.energy_error_limit=1e9"];

/// The step that a message names.
fn step_in(errors: &str) -> u64 {
    let (_, rest) = errors.split_once(" at step ").unwrap();
    rest.split(',').next().unwrap().parse().unwrap()
}

#[test]
fn an_inverted_element_ends_with_status_3_and_is_named() {
    let workshop = Workshop::new();
    let said = workshop.run(CRUSH, &UNBALANCED);
    let named = [
        "element ",
        "at step ",
        "t = ",
        "it is in part box, has the nodes",
        "what usually helps: element = \"hex8-one-point\"",
    ];
    said.assert(3, &[&named[..], &["the last frame and the last row show the step before"]].concat());
    let summary = workshop.summary();
    assert_eq!(summary["status"], "failed");
    let frames = summary["frames"].as_u64().unwrap();
    assert!(frames >= 2);
    assert_eq!(workshop.read("deck/results.pvd").matches("<DataSet ").count() as u64, frames);
    assert!(workshop.read("deck/estar.log").contains("what usually helps"));

    // who came close was named once, and the summary says how close
    assert_eq!(said.errors.matches("warning: element ").count(), 1, "{}", said.errors);
    let part = &summary["parts"][0];
    assert_eq!(part["group"], "box");
    assert!(part["smallest_jacobian"].as_f64().unwrap() < 0.1 && part["time"].as_f64().unwrap() > 0.0);

    // the last steps of the element and its neighbours: of eight hexes all
    let series = workshop.read("deck/trouble/results.pvd");
    assert_eq!(series.matches("<DataSet ").count(), 22.min(inverted_steps(&said.errors)));

    // the same from a checkpoint on the way
    let frames_of_series = |directory: &str| -> Vec<Vec<u8>> {
        let mut names: Vec<PathBuf> = fs::read_dir(workshop.path(directory))
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .filter(|path| path.extension().is_some_and(|extension| extension == "vtu"))
            .collect();
        names.sort();
        names.iter().map(|path| fs::read(path).unwrap()).collect()
    };
    let series = frames_of_series("deck/trouble/fields");
    let often = ["--output", "often", "--set", "output.checkpoint='1 us'"];
    workshop.run(CRUSH, &[&UNBALANCED[..], &often].concat()).assert(3, &["trouble/results.pvd"]);
    let again = frames_of_series("often/trouble/fields");
    assert!(series.ends_with(&again), "{} {}", series.len(), again.len());

    // what is shown is the step before, bit for bit
    let bad = step_in(said.errors.split_once("error: ").unwrap().1);
    let (last_row, last_frame) = (last_line(&workshop.read("deck/history.csv")), frames - 1);
    let frame = fs::read(workshop.path(&format!("deck/fields/frame_{last_frame:05}.vtu"))).unwrap();
    let stop = (bad - 1).to_string();
    workshop.run(CRUSH, &[&UNBALANCED[..], &["--stop-at-step", &stop, "--threads", "1"]].concat()).assert(0, &[]);
    assert_eq!(last_line(&workshop.read("deck/history.csv")), last_row);
    assert_eq!(fs::read(workshop.path(&format!("deck/fields/frame_{last_frame:05}.vtu"))).unwrap(), frame);
    assert!(!workshop.path("deck/trouble/results.pvd").exists(), "of an earlier run");
}

fn last_line(text: &str) -> String {
    text.lines().last().unwrap().to_owned()
}

/// Frames of the series of a run: the undeformed state, if it is among the last steps, and those that follow.
fn inverted_steps(errors: &str) -> usize {
    step_in(errors.split_once("error: ").unwrap().1) as usize + 1
}

#[test]
fn inverted_elements_are_deleted_if_the_deck_says_so() {
    let workshop = Workshop::new();
    let said = workshop.run(CRUSH, &[&UNBALANCED[..], &["--set", "time.on_inversion='delete'"]].concat());
    let summary = workshop.summary();
    assert_eq!((summary["status"].as_str(), summary["deleted_elements"].as_u64()), (Some("finished"), Some(8)));
    let history = workshop.read("deck/history.csv");
    assert!(history.lines().next().unwrap().ends_with(",deleted_energy,deleted_elements"));
    assert!(last_line(&history).ends_with(",8"));

    // that nothing is left is told when it happens and at the end, to whoever reads what
    let gone = "warning: all 8 elements of part box are deleted";
    said.assert(0, &[gone]);
    assert_eq!(said.errors.matches(gone).count(), 2, "{}", said.errors);
    assert!(said.text.contains("no element is left"), "{}", said.text);
    let log = workshop.read("deck/estar.log");
    assert_eq!(log.matches(gone).count(), 2, "{log}");
    let warnings = summary["warnings"].as_array().unwrap();
    assert!(warnings.iter().any(|warning| warning.as_str().unwrap().starts_with(gone)), "{warnings:?}");
    let counts = ["elements", "deleted_elements"].map(|count| summary["parts"][0][count].as_u64());
    assert_eq!(counts, [Some(8); 2]);
    // the least of nothing is no number
    assert!(summary["extremes"]["min_jacobian"].is_null() && summary["extremes"]["controlling_element"].is_null());
    assert!(summary["element_time_step"].is_null() && summary["stable_time_step"].is_null());
    let names: Vec<&str> = history.lines().next().unwrap().split(',').collect();
    let (names, last) = (names.into_iter(), last_line(&history));
    let empty: Vec<&str> =
        names.zip(last.split(',')).filter(|(_, cell)| cell.is_empty()).map(|(name, _)| name).collect();
    assert_eq!(empty, ["min_jacobian", "controlling_element"]);
    for text in [&history, &log, &said.text, &workshop.read("deck/summary.json"), &workshop.read("deck/run.jsonl")] {
        let is_infinite = |word: &str| matches!(word.trim_matches(','), "inf" | "-inf" | "NaN");
        assert!(!text.split([' ', ',', ':', '\n']).any(is_infinite), "{text}");
    }
    let [taken, left] = ["deleted_energy", "internal_energy"].map(|row| summary["energies"][row].as_f64().unwrap());
    assert!(taken > 0.0 && left.abs() < 1e-9 * taken, "{taken} {left}");
    assert!(workshop.read("deck/estar.log").contains("turned inside out or were squeezed flat"));
    let last = summary["frames"].as_u64().unwrap() - 1;
    let frame = fs::read(workshop.path(&format!("deck/fields/frame_{last:05}.vtu"))).unwrap();
    assert!(String::from_utf8_lossy(&frame).contains("Name=\"vtkGhostType\""));
    workshop.run(CRUSH, &["--set", "time.on_inversion='explode'"]).assert(2, &["the choices are `stop`, `delete`"]);
}

#[test]
fn time_step_of_the_assembled_mesh_is_told_by_the_check_and_taken_where_the_deck_says_so() {
    let workshop = Workshop::new();
    workshop.write("deck.toml", DECK);
    let check = workshop.estar(&["check", "deck.toml"]);
    check.assert(0, &[]);
    assert!(check.text.contains("by the assembled mesh"), "{}", check.text);
    let check = workshop.estar(&["check", "deck.toml", "--json"]);
    let forecast: serde_json::Value = serde_json::from_str(&check.text).unwrap();
    let [element, power] = ["element", "power"].map(|source| forecast["stable_time_steps"][source].as_f64().unwrap());
    assert!(power > 1.2 * element, "{power} {element}");

    workshop.run("", &[]).assert(0, &[]);
    let of_elements = workshop.summary();
    let by_power = ["--set", "time.time_step='power'", "--set", "time.time_step_interval=3"];
    let said = workshop.run("", &by_power);
    said.assert(0, &[]);
    assert!(workshop.read("deck/estar.log").contains("of the assembled mesh, estimated every 3 steps"));
    let summary = workshop.summary();
    assert_eq!((&of_elements["time_step_source"], &summary["time_step_source"]), (&"element".into(), &"power".into()));
    assert_eq!(of_elements["time_step_estimates"], 0);
    assert!(
        summary["time_step_estimates"].as_u64() > Some(1) && summary["steps"].as_u64() < of_elements["steps"].as_u64()
    );
    assert!(summary["stable_time_step"].as_f64() > summary["element_time_step"].as_f64());
    assert_eq!(of_elements["stable_time_step"], of_elements["element_time_step"]);

    // stopped between two estimates and resumed
    workshop.run("", &[&by_power[..], &["--stop-at-step", "5"]].concat()).assert(0, &[]);
    workshop.estar(&[&["run", "deck.toml", "--resume"], &by_power[..]].concat()).assert(0, &[]);
    assert_eq!(workshop.summary()["state_hash"], summary["state_hash"]);

    for (bad, told) in [
        ("time.time_step='fast'", "the choices are `element`, `power`"),
        ("time.time_step_interval=100", "an interval belongs to time_step = \"power\""),
    ] {
        workshop.run("", &["--set", bad]).assert(2, &[told]);
    }
    for bad in ["time.time_step_interval=0", "time.time_step_interval='1 s'"] {
        let power = ["--set", "time.time_step='power'", "--set", bad];
        workshop.run("", &power).assert(2, &["`time.time_step_interval` must be a whole number from 1"]);
    }
}

#[test]
fn limits_on_steps_end_with_status_3_and_say_so() {
    let workshop = Workshop::new();
    let said = workshop.run("", &["--set", "time.max_steps=3"]);
    said.assert(3, &["the end of 2.000000e-2 s is not reached in [time] max_steps", "at step 3", "`estar check`"]);
    assert_eq!(workshop.summary()["steps"], 3);
    let limits = ["--set", "time.min_time_step='0.9 ms'"];
    workshop.run(CRUSH, &[&UNBALANCED[..], &limits].concat()).assert(
        3,
        &["is below [time] min_time_step = 9.0000e-4 s", "which element ", "the last row show the state at this step"],
    );
    for bad in ["time.max_steps=0", "time.max_steps=1.5", "time.min_time_step=0.0", "time.min_time_step='1 m'"] {
        workshop.run("", &["--set", bad]).assert(2, &["`time.m"]);
    }
}

#[test]
fn an_energy_error_over_the_limit_ends_with_status_3() {
    let workshop = Workshop::new();
    let spin = "[[initial_velocity]]\ngroup = \"x_max\"\nangular = { rate = [0.0, 20.0, 3.0] }\n";
    let said = workshop.run(spin, &["--set", "time.energy_error_limit=1e-12"]);
    said.assert(3, &["the energy error", "is over the limit", "energy_error_limit"]);
}

#[test]
fn numbers_out_of_all_bounds_are_told_in_short() {
    let workshop = Workshop::new();
    let said = workshop.run("[[gravity]]\nacceleration = [0.0, 0.0, 1e300]\n", &[]);
    said.assert(3, &["at step 1"]);
    assert!(said.errors.lines().all(|line| line.len() < 300), "{}", said.errors);
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_with_status_130_and_readable_files() {
    let workshop = Workshop::new();
    workshop.write("deck.toml", DECK);
    let mut child = workshop.start(&["run", "deck.toml", "--set", "time.end=1e6", "--set", "output.frames=2"]);
    workshop.wait_for("deck/run.jsonl");
    // shells ignore SIGINT for what they run in the background, and so does then the program
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| u64::from_str_radix(line.strip_prefix("SigIgn:")?.trim(), 16).ok());
    let signal = if ignored.unwrap_or(0) >> 1 & 1 == 0 { "-INT" } else { "-TERM" };
    // `timeout` and its like send the signal twice: the echo must not cut the end short
    for _ in 0..2 {
        let kill = Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
        assert!(kill.success());
    }
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert_eq!(workshop.summary()["status"], "interrupted");
    assert_eq!(workshop.read("deck/results.pvd").matches("<DataSet ").count(), 2);
    assert!(workshop.read("deck/history.csv").ends_with('\n'));
}

#[test]
fn check_says_what_a_run_would_be() {
    let workshop = Workshop::new();
    workshop.write("deck.toml", DECK);
    let said = workshop.estar(&["check", "deck.toml"]);
    said.assert(0, &[]);
    for part in ["scaled Jacobian", "control the time step", "steps", "memory", "output", "no errors"] {
        assert!(said.text.contains(part), "{part}: {}", said.text);
    }
    assert!(!workshop.path("deck").exists());
    assert!(said.text.contains("output     about 5 frames, about"), "rows of steps are not known: {}", said.text);
    // without an interval of time for the history its rows follow the steps
    for (output, told) in [
        ("{ frames = 4, history = \"1 ms\" }", "output     5 frames, at most"),
        ("{ frames = 4 }", "output     about 5 frames, about "),
        ("{ every = \"1e-300 s\" }", " frames, about "),
    ] {
        let said = workshop.estar(&["check", "deck.toml", "--set", &format!("output={output}")]);
        assert!(said.code == 0 && said.text.contains(told), "{told}: {}", said.text);
    }

    let said = workshop.estar(&["check", "deck.toml", "--json"]);
    let report: serde_json::Value = serde_json::from_str(&said.text).unwrap();
    assert_eq!(report["is_good"], true);
    assert_eq!(report["controlling_elements"].as_array().unwrap().len(), 8);
    assert!(report["seconds_expected"].as_f64().unwrap() > 0.0);

    let said =
        workshop.estar(&["check", "deck.toml", "--json", "--set", "time.end='1 mm'", "--set", "part.0.group='bex'"]);
    said.assert(2, &[]);
    let report: serde_json::Value = serde_json::from_str(&said.text).unwrap();
    assert_eq!(report["is_good"], false);
    let findings = report["findings"].as_array().unwrap();
    assert_eq!(findings.len(), 2);
    assert_eq!(findings[0]["file"], "--set time.end='1 mm'");
    assert_eq!((&findings[0]["line"], &findings[0]["column"]), (&1.into(), &10.into()));

    // what is found only when the state at time 0 is known has its place, too
    let jump = "[[prescribed]]\ngroup = \"x_max\"\ndirection = \"y\"\nquantity = \"displacement\"\ncurve = [[0, 0], [1e-9, 0.1]]\n";
    workshop.write("jump.toml", &format!("{DECK}{jump}"));
    let said = workshop.estar(&["check", "jump.toml", "--json"]);
    said.assert(2, &[]);
    let report: serde_json::Value = serde_json::from_str(&said.text).unwrap();
    let findings = report["findings"].as_array().unwrap();
    let message = findings[0]["message"].as_str().unwrap();
    assert!(findings.len() == 1 && message.starts_with("the prescribed displacement jumps by"), "{findings:?}");
    let line = DECK.lines().count() + 1;
    assert_eq!((&findings[0]["file"], &findings[0]["line"]), (&"jump.toml".into(), &line.into()));
}

#[test]
fn meshes_are_made_and_described() {
    let workshop = Workshop::new();
    let mesh = |arguments: &[&str]| workshop.estar(&[&["mesh"], arguments].concat());
    mesh(&["cylinder", "--output", "quarter.msh"]).assert(0, &[]);
    mesh(&["cylinder", "--output", "full.msh", "--full", "--radius", "3mm", "--ascii"]).assert(0, &[]);
    mesh(&["necking-bar", "--output", "bar.msh", "--grading", "4"]).assert(0, &[]);
    for (file, parts) in [
        ("box.msh", ["8 hexes", "27 nodes", "x_max", "numbers: nodes 1 to 27; elements 1 to 8"]),
        ("quarter.msh", ["symmetry_x", "foot", "top", "bar"]),
        ("full.msh", ["Gmsh 4.1, ASCII", "axis", "side", "from -3.000000e-3 to 3.000000e-3"]),
        ("bar.msh", ["neck", "grip", "symmetry_z", "scaled Jacobian"]),
    ] {
        let said = mesh(&["info", file]);
        said.assert(0, &[]);
        assert!(parts.iter().all(|part| said.text.to_lowercase().contains(&part.to_lowercase())), "{}", said.text);
    }
    mesh(&["box", "--output", "one.msh", "--cells", "1", "1", "1"]).assert(0, &[]);
    let said = mesh(&["info", "one.msh"]);
    let one = ["8 nodes, 1 hex\n", "1 element, 8 nodes", "1 face, 4 nodes"];
    assert!(said.code == 0 && one.iter().all(|part| said.text.contains(part)), "{}", said.text);
    workshop.write("deck.toml", DECK);
    mesh(&["info", "deck.toml"]).assert(2, &["a deck, not a mesh", "`estar check`"]);
    workshop.estar(&["run", "box.msh"]).assert(2, &["box.msh: this is a mesh; `estar mesh info`", "`file` in [mesh]"]);
    mesh(&["box", "--output", "box.msh"]).assert(2, &["is there already", "--force"]);
    mesh(&["box", "--output", "b.msh", "--cells", "0", "1", "1"]).assert(2, &["cells in x"]);
    mesh(&["box", "--output", "b.msh", "--size", "1kg", "1", "1"]).assert(2, &["a length is needed"]);
    mesh(&["box", "--output", "b.msh", "--size", "-1", "1", "1"])
        .assert(2, &["length in x = -1: must be", "from 1e-90"]);
    mesh(&["box", "--output", "b.msh", "--size", "1e300", "1", "1"]).assert(2, &["length in x = 1e300: must be"]);
    mesh(&["box", "--output", "nowhere/b.msh"]).assert(4, &["nowhere"]);
    mesh(&["info", "nowhere.msh"]).assert(4, &["nowhere.msh"]);
    workshop.write("garbage.msh", "garbage");
    mesh(&["info", "garbage.msh"]).assert(2, &["garbage.msh"]);
}

#[test]
fn an_element_that_does_not_suit_a_material_is_warned_of() {
    let workshop = Workshop::new();
    let soil = "theory = \"hencky\"\nyield_surface = { kind = \"mohr-coulomb\", friction_angle = \"0.5 rad\", cohesion = \"1 MPa\" }";
    let deck = DECK.replacen("theory = \"elastic\"", soil, 1);
    let with = |element: &str| {
        deck.replacen("material = \"rubber\"\n", &format!("material = \"rubber\"\nelement = \"{element}\"\n"), 1)
    };
    let said = workshop.run_deck(&with("hex8-f-bar"), &[]);
    said.assert(0, &["warning: plastic flow that changes the volume", "take element = \"hex8-b-bar\""]);
    let said = workshop.run_deck(&with("hex8"), &[]);
    said.assert(0, &["warning: elements `hex8` lock", "take element = \"hex8-b-bar\""]);
    // what is taken unless something is given
    for deck in [&deck, &with("hex8-b-bar")] {
        let said = workshop.run_deck(deck, &[]);
        said.assert(0, &[]);
        assert!(!said.errors.contains("warning") && said.text.contains("rubber, hex8-b-bar"), "{}", said.errors);
    }
}

/// F-bar gains energy where flow changes the volume; B-bar does the work of its stress.
#[test]
fn an_energy_error_over_a_percent_is_told_with_what_helps() {
    let workshop = Workshop::new();
    let soil = "theory = \"hencky\"\nyield_surface = { kind = \"mohr-coulomb\", friction_angle = \"0.5 rad\", cohesion = \"0.1 MPa\" }";
    let flies = "[[initial_velocity]]\ngroup = \"box\"\nvalue = [1.0, 0.0, 0.0]\n";
    let pressed = "[[fix]]\ngroup = \"z_min\"\ndirections = [\"x\", \"y\", \"z\"]\n\
                   [[fix]]\ngroup = \"z_max\"\ndirections = [\"x\", \"y\"]\n\
                   [[prescribed]]\ngroup = \"z_max\"\ndirection = \"z\"\nquantity = \"velocity\"\ncurve = [[0, -1]]\n";
    let deck = DECK.replacen("theory = \"elastic\"", soil, 1).replacen(flies, pressed, 1);
    let of = |element: &str| {
        let element = format!("part.0.element=\"{element}\"");
        let said = workshop.run_deck(&deck, &[&UNBALANCED[..], &["--set", &element]].concat());
        said.assert(0, &[]);
        (said.errors, workshop.summary())
    };
    let told = "warning: the energy error is";
    let (errors, summary) = of("hex8-f-bar");
    let error = 100.0 * summary["energy_error"].as_f64().unwrap();
    assert!(error.abs() > 1.0, "{error} %");
    assert!(
        errors.contains(&format!("{told} {error:+.2} %")) && errors.contains("with element = \"hex8-b-bar\""),
        "{errors}"
    );
    assert!(workshop.read("deck/estar.log").contains(told));
    assert!(summary["warnings"][0].as_str().unwrap().starts_with(told));
    let (errors, summary) = of("hex8-b-bar");
    assert!(summary["energy_error"].as_f64().unwrap().abs() < 1e-3 && !errors.contains(told), "{errors}");
    assert_eq!(summary["warnings"], serde_json::json!([]));
}

#[test]
fn check_says_what_four_node_tets_are_good_for() {
    let workshop = Workshop::new();
    workshop.estar(&["mesh", "box", "--output", "box.msh", "--cells", "2", "2", "2", "--shape", "tet4", "--force"]);
    workshop.write("deck.toml", DECK);
    let note = "note       part box: forces of `tet4`";
    let elastic = workshop.estar(&["check", "deck.toml"]);
    assert!(elastic.code == 0 && !elastic.text.contains("note "), "{}", elastic.text);
    let metal = "theory = \"e-star\"\nhardening = { law = \"perfect\", yield_stress = \"1 MPa\" }";
    workshop.write("deck.toml", &DECK.replacen("theory = \"elastic\"", metal, 1));
    let said = workshop.estar(&["check", "deck.toml"]);
    assert!(said.code == 0 && said.text.contains(note), "{}", said.text);
    let report: serde_json::Value =
        serde_json::from_str(&workshop.estar(&["check", "--json", "deck.toml"]).text).unwrap();
    assert_eq!(report["notes"].as_array().unwrap().len(), 1);
}

#[test]
fn temperature_is_a_field_a_probe_and_a_row_of_the_ledger() {
    let workshop = Workshop::new();
    let output = "history_steps = 2\n";
    let probe = "[[probe]]\nname = \"hot\"\nkind = \"maximum\"\ngroup = \"box\"\nfield = \"temperature\"\n";
    let fields = "history_steps = 2\nfields = [\"temperature\"]\n";
    let cold = DECK.replacen(output, fields, 1) + probe;
    let told = ["asks for the temperature of a material that has none", "has the temperature, but no material has one"];
    workshop.run_deck(&cold, &[]).assert(2, &told);

    let hot = cold
        .replacen("theory = \"elastic\"", "theory = \"e-star\"\nspecific_heat = \"2 kJ/(kg K)\"", 1)
        .replacen("value = [1.0, 0.0, 0.0]", "angular = { rate = [300.0, 0.0, 0.0], centre = [0.0, 0.0, 0.0] }", 1)
        .replacen(
            "[[part]]",
            "[material.rubber.hardening]\nlaw = \"johnson-cook\"\na = \"1 kPa\"\nb = \"1 kPa\"\nn = 0.5\nc = 0.01\nm = 1.0\n\
             reference_rate = 1.0\nreference_temperature = \"20 degC\"\nmelting_temperature = \"200 degC\"\n[[part]]",
            1,
        );
    workshop.run_deck(&hot, &["--set", "time.end='1 ms'"]).assert(0, &[]);
    let frame = fs::read(workshop.path("deck/fields/frame_00002.vtu")).unwrap();
    assert!(String::from_utf8_lossy(&frame).contains("Name=\"temperature\""));
    let summary = workshop.summary();
    let number = |path: [&str; 2]| summary[path[0]][path[1]].as_f64().unwrap();
    let (hottest, mean) = (number(["extremes", "max_temperature"]), number(["probes", "hot"]));
    assert!(mean > 293.15 && hottest >= mean && hottest < 300.0, "{mean} {hottest}");
    let share = number(["energies", "heat"]) / number(["energies", "plastic_dissipation"]);
    assert!((share - 0.9).abs() < 1e-12, "{share}");
    let history = workshop.read("deck/history.csv");
    assert!(history.lines().next().unwrap().ends_with("controlling_element,heat,max_temperature,hot"));
    let last: Vec<f64> = history.lines().last().unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
    assert_eq!(last[18..], [number(["energies", "heat"]), hottest, mean]);
}

#[test]
fn bench_measures_every_element_and_material() {
    let workshop = Workshop::new();
    let said = workshop.estar(&["bench", "--quick", "--hexes", "24", "--threads", "2", "--lanes", "portable"]);
    said.assert(0, &["memory and arithmetic of the machine"]);
    for part in [
        "hex8-f-bar     e-star box-rate linear",
        "hex8           elastic",
        "arithmetic, portable",
        "1 thread",
        "2 threads",
    ] {
        assert!(said.text.contains(part), "no {part:?} in\n{}", said.text);
    }
    let widest = said.text.lines().map(|line| line.chars().count()).max();
    assert!(widest <= Some(100), "{widest:?}\n{}", said.text);
}

#[test]
fn bench_writes_figures_for_programs() {
    let workshop = Workshop::new();
    let said = workshop.estar(&["bench", "--quick", "--hexes", "24", "--threads", "1", "--lanes", "all", "--json"]);
    said.assert(0, &[]);
    let report: serde_json::Value = serde_json::from_str(&said.text).unwrap();
    assert_eq!(report["threads"], serde_json::json!([1]));
    let problem = &report["problems"].as_array().unwrap().last().unwrap();
    assert_eq!((&problem["lanes"], &problem["hexes"]), (&"portable".into(), &24.into()));
    let rows = problem["rows"].as_array().unwrap();
    assert_eq!(rows.len(), ELEMENTS.len() * materials().len());
    for row in rows {
        let number = |value: &serde_json::Value| value.as_f64().unwrap();
        let [elastic, flops, yielding] =
            [&row["elastic"]["flops"], &row["flops"], &row["yielding"]["flops"]].map(number);
        assert!(elastic <= flops && flops <= yielding, "{row}");
        let is_of_hexes = row["element"].as_str().unwrap().starts_with("hex8");
        assert!(if is_of_hexes { row["elements"] == 24 } else { number(&row["elements"]) > 0.0 }, "{row}");
        assert!(number(&row["bytes"]) > 0.0 && number(&row["runs"][0]["nanoseconds"]) > 0.0, "{row}");
    }
}

#[test]
fn bench_draws_the_curve_over_sizes() {
    let said = Workshop::new().estar(&["bench", "--quick", "--sizes", "--threads", "1"]);
    said.assert(0, &[]);
    assert!(said.text.contains("\n1 536 "), "{}", said.text);
}

#[test]
fn bench_refuses_what_it_cannot_measure() {
    let workshop = Workshop::new();
    let refused =
        |arguments: &[&str], parts: &[&str]| workshop.estar(&[&["bench"], arguments].concat()).assert(2, parts);
    refused(&["--lanes", "sse"], &["'sse'", "portable, avx2, avx512, all"]);
    refused(&["--hexes", "0"], &["a whole number from 1 to 10000000"]);
    refused(&["--hexes", "1e5"], &["a whole number"]);
    refused(&["--threads", "0"], &["a whole number from 1 to 4096"]);
    refused(&["--hexes", "24", "--sizes"], &["cannot be used with"]);
    refused(&["deck.toml"], &["deck.toml"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_listener_that_goes_away_or_is_full_causes_no_panic() {
    let workshop = Workshop::new();
    workshop.write("deck.toml", DECK);
    let said_to = |listener: std::process::Stdio, arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_estar"));
        command.args(arguments).current_dir(workshop.directory.path()).stdout(listener);
        Said::of(&command.output().unwrap())
    };
    for arguments in [&["mesh", "info", "box.msh"][..], &["check", "deck.toml"], &["example", "--list"]] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        said_to(writer.into(), arguments).assert(0, &[]);
        let full = fs::File::options().write(true).open("/dev/full").unwrap();
        said_to(full.into(), arguments).assert(4, &["standard output: cannot be written"]);
    }
}

#[cfg(unix)]
#[test]
fn devices_pipes_and_links_are_neither_meshes_nor_replaced_by_one() {
    let workshop = Workshop::new();
    let pipe = Command::new("mkfifo").arg(workshop.path("pipe")).status().unwrap();
    assert!(pipe.success());
    for endless in ["/dev/zero", "pipe"] {
        workshop.estar(&["mesh", "info", endless]).assert(4, &[endless, "save its content to a file"]);
        workshop.run("", &["--set", &format!("mesh.file='{endless}'")]).assert(4, &[endless]);
    }
    workshop.run("", &["--set", "mesh.file='.'"]).assert(4, &["cannot be read"]);
    std::os::unix::fs::symlink(workshop.path("box.msh"), workshop.path("link")).unwrap();
    for precious in ["pipe", "link"] {
        workshop.estar(&["mesh", "box", "--force", "--output", precious]).assert(4, &[precious, "no ordinary file"]);
        assert!(!workshop.path(precious).symlink_metadata().unwrap().is_file());
    }
}

#[test]
fn a_time_that_could_never_reach_the_end_is_refused() {
    let workshop = Workshop::new();
    for slow in ["material.rubber.density=1e-40", "material.rubber.young_modulus=1e308", "time.end=1e300"] {
        workshop.run("", &["--set", slow]).assert(2, &["too small for the time ever to reach", "element ", "units"]);
        workshop.estar(&["check", "deck.toml", "--set", slow]).assert(2, &["too small for the time ever to reach"]);
    }
}

#[test]
fn a_title_stays_on_its_line_and_cannot_steer_the_terminal() {
    let said = Workshop::new().run("", &["--set", r#"title="one\n\u001b[31mtwo""#]);
    said.assert(0, &[]);
    assert!(said.text.contains("one \u{fffd}[31mtwo\n"), "{}", said.text);
}

/// What a terminal obeys, and what turns the direction of writing.
const STEERING: &str = "\u{1b}]0;x\u{7}\u{1b}[2J\u{9b}31m\u{202e}\u{2066}\u{200f}\u{61c}";

#[test]
fn no_text_of_a_file_or_of_the_command_line_steers_the_terminal() {
    let workshop = Workshop::new();
    let escaped: String = STEERING.chars().map(|sign| format!("\\u{:04x}", u32::from(sign))).collect();
    let case = format!(
        "[[case]]\nname = \"a\"\nabout = \"{escaped}\"\ndeck = \"{escaped}.toml\"\ncost = 1.0\n\
         check = [{{ quantity = \"time\", value = 1.0, tolerance = 1.0, source = \"{escaped}\" }}]\n"
    );
    workshop.write("cases.toml", &case);
    workshop.write("wrong.toml", &case.replace("cost", &format!("\"{escaped}\"")));
    workshop.write("raw.toml", &format!("title = '{STEERING}'\n"));
    workshop.write("deck.toml", &DECK.replace("A box flies", &escaped));
    let mesh = workshop.read_bytes("box.msh");
    let named = String::from_utf8_lossy(&mesh).find("\"box\"").unwrap();
    let evil = [&mesh[..named + 1], STEERING.as_bytes(), &mesh[named + 4..]].concat();
    fs::write(workshop.path("evil.msh"), evil).unwrap();
    let set = format!("title=\"{escaped}\"");
    let unknown = format!("\"{escaped}\"=1");
    let raw = format!("a.{STEERING}=1");
    let file = format!("mesh.file=\"{escaped}\"");
    let group = format!("part.0.group=\"{escaped}\"");
    let nowhere = format!("nowhere{STEERING}");
    for arguments in [
        &["verify", "--list", "--cases", "cases.toml"][..],
        &["verify", "--cases", "cases.toml", "--output", "out"],
        &["verify", "--list", "--cases", "wrong.toml"],
        &["verify", "--case", STEERING],
        &["run", "deck.toml", "--force"],
        &["run", "deck.toml", "--force", "--set", &set],
        &["run", "deck.toml", "--force", "--set", &unknown],
        &["run", "deck.toml", "--force", "--set", &raw],
        &["run", "deck.toml", "--force", "--set", &file],
        &["run", "deck.toml", "--force", "--set", &group],
        &["check", "deck.toml", "--json", "--set", &group],
        &["check", "raw.toml"],
        &["check", "raw.toml", "--json"],
        &["run", STEERING],
        &["run", "deck.toml", "--threads", STEERING],
        &["run", "deck.toml", "--force", "--output", STEERING],
        &["mesh", "info", "evil.msh"],
        &["mesh", "info", STEERING],
        &["mesh", "box", "--output", STEERING],
        &["convert", STEERING],
        &["plot", STEERING],
        &["plot", "deck", "--field", STEERING],
        &["view", &nowhere],
        &["example", STEERING],
        &[STEERING],
    ] {
        let said = workshop.estar(arguments);
        for text in [&said.text, &said.errors] {
            assert_eq!(estar_io::visible(text), text.as_str(), "{arguments:?}");
        }
        assert!(!said.errors.contains("panicked"), "{}", said.errors);
    }
    let log = workshop.read("deck/estar.log");
    assert_eq!(estar_io::visible(&log), log);
    // programs that read JSON have the text as it is
    let said = workshop.estar(&["check", "deck.toml", "--json", "--set", &group]);
    let report: serde_json::Value = serde_json::from_str(&said.text).unwrap();
    let message = report["findings"][0]["message"].as_str().unwrap();
    assert!(message.contains(STEERING), "{message}");
}

#[test]
fn names_have_a_longest_and_none_panics() {
    let workshop = Workshop::new();
    let mesh = workshop.read_bytes("box.msh");
    let named = String::from_utf8_lossy(&mesh).find("\"x_min\"").unwrap();
    for length in [255, 256, 65_535, 65_536, 100_000, 3_000_000] {
        let long = "n".repeat(length);
        let is_good = length <= 255;
        let code = if is_good { 0 } else { 2 };
        let told: &[&str] = if is_good { &[] } else { &["up to 255 are read"] };
        fs::write(workshop.path("long.msh"), [&mesh[..named + 1], long.as_bytes(), &mesh[named + 6..]].concat())
            .unwrap();
        workshop.estar(&["mesh", "info", "long.msh"]).assert(code, told);
        let probe = format!(
            "[[probe]]\nname = \"{long}\"\nkind = \"extent\"\ngroup = \"box\"\naxis = \"x\"\n\
             [[expect]]\nprobe = \"{long}\"\nvalue = 1.0\ntolerance = 1e-6\n"
        );
        let said = workshop.run(&probe, &[]);
        said.assert(code, told);
        assert!(said.errors.len() + said.text.len() < 40_000, "{}", said.errors.len());
        let material = DECK.replace("rubber", &long);
        workshop.run_deck(&material, &[]).assert(code, told);
        let group = DECK.replace("group = \"box\"", &format!("group = \"{long}\""));
        let said = workshop.run_deck(&group, &[]);
        said.assert(2, if is_good { &["has no group"] } else { told });
        // words where a choice, a key, a unit or a title is expected
        for deck in [
            DECK.replace("\"elastic\"", &format!("\"{long}\"")),
            DECK.replace("density", &long),
            DECK.replace("100 MPa", &format!("100 {long}")),
            DECK.replace("box.msh", &long),
        ] {
            let said = workshop.run_deck(&deck, &[]);
            assert!(matches!(said.code, 2 | 4) && !said.errors.contains("panicked"), "{}", said.errors);
            assert!(said.errors.len() < 60_000, "{}", said.errors.len());
        }
        workshop.run_deck(&DECK.replace("A box flies", &long), &["--quiet"]).assert(0, &[]);
        assert!(workshop.read("deck/estar.log").len() < 10_000);
    }
}

#[test]
fn absurd_schedules_do_what_the_check_says() {
    let workshop = Workshop::new();
    workshop.write("deck.toml", DECK);
    let without = DECK.replace("frames = 4\nhistory_steps = 2\n", "");
    workshop.write("deck.toml", &without);
    for (key, is_of_frames) in [
        ("history='1e-300 s'", false),
        ("history=5e-324", false),
        ("history='1e300 s'", false),
        ("history_steps=9223372036854775807", false),
        ("every='1e-300 s'", true),
        ("every=1e300", true),
        ("frames=4000000000", true),
        ("frames=9223372036854775807", true),
    ] {
        let set = format!("output.{key}");
        let said = workshop.estar(&["check", "deck.toml", "--json", "--set", &set]);
        said.assert(0, &[]);
        let report: serde_json::Value = serde_json::from_str(&said.text).unwrap();
        workshop.estar(&["run", "deck.toml", "--force", "--quiet", "--set", &set]).assert(0, &[]);
        let steps = workshop.summary()["steps"].as_u64().unwrap();
        let often = steps + 1;
        let rows = workshop.read("deck/history.csv").lines().count() as u64 - 1;
        let frames = workshop.summary()["frames"].as_u64().unwrap();
        let expected = if key.contains("e300") || key.contains("history_steps") { 2 } else { often };
        let found = if is_of_frames { frames } else { rows };
        assert_eq!(found, expected, "{key}: {steps} steps");
        if is_of_frames {
            // steps that grow or shrink on the way are not foreseen
            let told = report["frames_expected"].as_f64().unwrap();
            assert!((told - found as f64).abs() <= 2.0, "{key}: {told} told, {found} found");
        }
    }
}

#[test]
fn every_example_is_written_and_good() {
    let workshop = Workshop::new();
    let list = workshop.estar(&["example", "--list"]).text;
    let names: Vec<&str> = list.lines().filter_map(|line| line.split_whitespace().next()).collect();
    assert_eq!(names, ["taylor", "necking", "cook", "upset"]);
    for name in names {
        workshop.estar(&["example", name]).assert(0, &[]);
        let deck = Path::new(name).join(format!("{name}.toml"));
        workshop.estar(&["check", &deck.display().to_string()]).assert(0, &[]);
    }
    workshop.estar(&["example", "taylor"]).assert(2, &["is there already"]);
    workshop.estar(&["example", "tailor"]).assert(2, &["there is no example `tailor`", "taylor, necking, cook, upset"]);
    workshop.estar(&["example"]).assert(2, &["NAME"]);
}

/// Width and height of a PNG, and whether it moves.
fn png_of(workshop: &Workshop, name: &str) -> ([u32; 2], bool) {
    let bytes = fs::read(workshop.path(name)).unwrap();
    assert_eq!(bytes[..8], *b"\x89PNG\r\n\x1a\n", "{name}");
    let number = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap());
    ([number(16), number(20)], bytes.windows(4).any(|chunk| chunk == b"acTL"))
}

#[test]
fn a_run_is_plotted_without_a_display() {
    let workshop = Workshop::new();
    workshop.run_deck(DECK, &[]).assert(0, &[]);
    let said = workshop.estar(&["plot", "deck", "--field", "velocity"]);
    said.assert(0, &[]);
    for name in ["history.svg", "history.png", "picture.png"] {
        assert!(said.text.contains(name), "{}", said.text);
    }
    assert_eq!(png_of(&workshop, "deck/plots/picture.png"), ([1200, 900], false));
    // text is drawn as outlines: what can be seen is that there is something
    assert!(workshop.read("deck/plots/history.svg").matches("<path").count() > 50);

    let small = ["plot", "deck", "--size", "320x240", "--output", "small", "--view", "-30,20", "--mirror", "x,y"];
    let moving = ["--field", "velocity", "--component", "x", "--range", "-1,2", "--no-edges", "--animate"];
    workshop.estar(&[&small[..], &moving[..]].concat()).assert(0, &[]);
    assert_eq!(png_of(&workshop, "small/animation.png"), ([320, 240], true));

    workshop.estar(&["run", "deck.toml", "--output", "other", "--quiet"]).assert(0, &[]);
    let compared = ["plot", "deck", "--compare", "other", "--field", "displacement", "--time", "10ms"];
    workshop.estar(&compared).assert(0, &[]);
}

#[test]
fn hundreds_of_probes_are_plotted_on_sheets_and_what_was_written_is_told() {
    let workshop = Workshop::new();
    workshop.run_deck(DECK, &[]).assert(0, &[]);
    let history = workshop.read("deck/history.csv");
    let more = |row: usize| -> String {
        (0..200).map(|n| if row == 0 { format!(",p{n}") } else { format!(",{row}") }).collect()
    };
    let rows: Vec<String> = history.lines().enumerate().map(|(row, line)| format!("{line}{}\n", more(row))).collect();
    fs::write(workshop.path("deck/history.csv"), rows.concat()).unwrap();
    let said = workshop.estar(&["plot", "deck"]);
    said.assert(0, &[]);
    for told in ["history.png", "history_2.svg to ", "history_11.svg", "11 sheets"] {
        assert!(said.text.contains(told), "{}", said.text);
    }
    for number in 2..=11 {
        let ([width, height], _) = png_of(&workshop, &format!("deck/plots/history_{number}.png"));
        assert!(width <= 1720 && height <= 6300, "{width} x {height}");
    }
    // with fewer, none of those that are no longer true stays
    fs::write(workshop.path("deck/history.csv"), history).unwrap();
    let said = workshop.estar(&["plot", "deck"]);
    assert!(said.text.contains("history.svg") && !said.text.contains("history_2"), "{}", said.text);
    assert!(workshop.path("deck/plots/history.png").exists() && !workshop.path("deck/plots/history_2.png").exists());
}

#[test]
fn plots_that_cannot_be_are_refused_with_what_would_be_right() {
    let workshop = Workshop::new();
    workshop.run_deck(DECK, &[]).assert(0, &[]);
    let refused = |arguments: &[&str], code: i32, parts: &[&str]| {
        workshop.estar(&[&["plot"], arguments].concat()).assert(code, parts);
    };
    refused(&["nowhere"], 4, &["nowhere holds no results", "estar run"]);
    refused(&["deck", "--compare", "nowhere"], 4, &["nowhere holds no results"]);
    refused(&["deck", "--field", "velocities"], 2, &["no field `velocities`", "did you mean `velocity`?"]);
    refused(&["deck", "--field", "velocity", "--component", "xx"], 2, &["no component `xx`", "`x`, `y`, `z`"]);
    refused(&["deck", "--field", "pressure", "--component", "x"], 2, &["it is one number"]);
    let tensor = ["`cauchy_stress` is a tensor: --component says which", "`xx`", "von_mises_stress and pressure"];
    refused(&["deck", "--field", "cauchy_stress"], 2, &tensor);
    refused(&["deck", "--field", "cauchy_stress", "--component", "zz"], 0, &[]);
    refused(&["deck", "--view", "above"], 2, &["iso, x, y, z"]);
    refused(&["deck", "--range", "2,1"], 2, &["the smaller first"]);
    refused(&["deck", "--size", "10x10"], 2, &["from 64 to 8192"]);
    refused(&["deck", "--mirror", "w"], 2, &["x, y or z"]);

    let frame = workshop.path("deck/fields/frame_00004.vtu");
    let bytes = fs::read(&frame).unwrap();
    fs::write(&frame, &bytes[..bytes.len() / 2]).unwrap();
    refused(&["deck"], 4, &["frame_00004.vtu: no frame of this program"]);
    fs::remove_file(&frame).unwrap();
    refused(&["deck"], 4, &["frame_00004.vtu: cannot be read"]);
    fs::write(workshop.path("deck/history.csv"), "time,step\n0.0\n").unwrap();
    refused(&["deck"], 4, &["history.csv: line 2 has 1 cells, not 2"]);
}

#[test]
fn completions_and_the_manual_know_every_command() {
    let workshop = Workshop::new();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let said = workshop.estar(&["completions", shell]);
        said.assert(0, &[]);
        for word in ["estar", "stop-at-step", "verify"] {
            assert!(said.text.contains(word), "{shell}: {word}");
        }
    }
    workshop.estar(&["completions", "tcsh"]).assert(2, &["bash"]);
    let said = workshop.estar(&["man"]);
    said.assert(0, &[]);
    for word in [".TH", "estar run", "estar plot", "estar mesh box", "docs/README.md"] {
        assert!(said.text.contains(word), "{word}");
    }
    // every page that is referred to is there
    let title =
        |line: &str| line.strip_prefix(".TH ").map(|rest| rest.split(" 1").next().unwrap_or(rest).replace('"', ""));
    let titles: Vec<String> = said.text.lines().filter_map(title).collect();
    assert!(titles.iter().any(|title| title == "estar mesh info"), "{titles:?}");
    assert!(!said.text.contains("(1)"), "a page of its own is named");
    assert!(workshop.estar(&["--help"]).text.contains("docs/README.md"));
}

#[test]
fn a_mesh_is_converted_for_paraview_with_its_groups() {
    let workshop = Workshop::new();
    workshop.estar(&["mesh", "box", "--shape", "tet10", "--output", "tets.msh"]).assert(0, &[]);
    let said = workshop.estar(&["convert", "tets.msh"]);
    said.assert(0, &[]);
    assert!(said.text.contains("tets.vtu") && said.text.contains("8 groups"), "{}", said.text);
    let frame = estar_io::read_frame(&workshop.path("tets.vtu")).unwrap();
    assert!(frame.types.iter().all(|shape| *shape == 24));
    assert!(frame.cell_fields["group box"].data.iter().all(|mark| *mark == 1.0));
    assert!(frame.node_fields["group z_max"].data.contains(&0.0));
    workshop.estar(&["convert", "tets.msh"]).assert(2, &["is there already", "--force"]);
    workshop.estar(&["convert", "nowhere.msh"]).assert(4, &["nowhere.msh"]);
    workshop.write("text.msh", "no mesh");
    workshop.estar(&["convert", "text.msh"]).assert(2, &["text.msh"]);
}

#[test]
fn the_rows_that_a_run_prints_add_up_to_its_imbalance() {
    let workshop = Workshop::new();
    let loads = "[[gravity]]\nacceleration = [0, 0, -10]\n[[rigid_wall]]\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nfriction = 0.2\n\
                 [[traction]]\ngroup = \"x_max\"\ndirection = [0, 3, 0]\ncurve = [[0, 500], [1e-3, 5e6]]\n";
    let said = workshop.run(loads, &[]);
    said.assert(0, &[]);
    let row = |name: &str| {
        let line = said.text.lines().find(|line| line.trim_start().starts_with(name));
        line.map_or(0.0, |line| line.trim_end_matches(" J").rsplit(' ').next().unwrap().parse::<f64>().unwrap())
    };
    let held = ["kinetic energy", "internal energy", "deleted elements", "bulk viscosity", "hourglass control"];
    let taken = ["contact", "damping", "time integration"];
    let came_in = row("external work") + row("brought along");
    let imbalance = held.iter().chain(&taken).map(|name| row(name)).sum::<f64>() - came_in;
    assert_ne!(row("time integration"), 0.0, "{}", said.text);
    let energies = &workshop.summary()["energies"];
    assert!(
        (row("time integration") - energies["integration_energy"].as_f64().unwrap()).abs()
            <= 1e-6 * row("time integration").abs()
    );
    // rows have seven digits
    let largest = row("kinetic energy").max(row("internal energy")).max(came_in.abs());
    let error = said.text.lines().find(|line| line.trim_start().starts_with("energy error")).unwrap();
    let error: f64 = error.trim_end_matches(" %").rsplit(' ').next().unwrap().parse().unwrap();
    assert!(
        (imbalance / largest - error / 100.0).abs() < 2e-6 + 1e-2 * (error / 100.0).abs(),
        "{imbalance} {largest} {}",
        said.text
    );
}

#[test]
fn end_of_a_run_has_units_and_leaves_out_what_is_nothing() {
    let workshop = Workshop::new();
    let probes = "[[probe]]\nname = \"length\"\nkind = \"extent\"\ngroup = \"box\"\naxis = \"x\"\n\
                  [[probe]]\nname = \"strain\"\nkind = \"maximum\"\ngroup = \"box\"\nfield = \"equivalent_plastic_strain\"\n";
    let said = workshop.run(probes, &[]);
    said.assert(0, &[]);
    assert!(!said.text.contains("0.000000e0 J"), "{}", said.text);
    assert!(said.text.contains("other rows of the energy ledger are 0"), "{}", said.text);
    let line =
        |name: &str| said.text.lines().find(|line| line.trim_start().starts_with(name)).unwrap_or_default().to_owned();
    assert!(line("kinetic energy").ends_with(" J"), "{}", said.text);
    assert!(line("length").ends_with("e0 m"), "{}", said.text);
    assert!(line("strain").ends_with("0.000000e0"), "{}", said.text);
}
