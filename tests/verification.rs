//! Verification: whole problems, run as a user runs them, against published values and closed forms.
//!
//! The cases are in `tests/verification.toml`; `estar verify` runs the same, and `docs/verification.md` shows the same table. Those that
//! take long are ignored unless asked for: `cargo test --release --test verification -- --include-ignored`.

use estar::verify::cases::{Case, Check, TABLE, cases};
use estar::verify::{Source, deck_in_words, faults, run_case};
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

fn in_repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

fn program() -> &'static Path {
    Path::new(env!("CARGO_BIN_EXE_estar"))
}

fn table() -> Vec<Case> {
    cases(TABLE).unwrap()
}

fn verify(name: &str) {
    let case = table().into_iter().find(|case| case.name == name).unwrap();
    let directory = tempfile::tempdir().unwrap();
    let outcome = run_case(program(), &case, &Source::Shipped, directory.path()).unwrap();
    for finding in &outcome.findings {
        println!("{} at {}: {:.6e}, expected {}", finding.quantity, finding.at, finding.found, finding.wanted);
    }
    assert!(outcome.met, "{name}\n{}", faults(&outcome).join("\n"));
}

/// A test for each case.
macro_rules! verification {
    ($($(#[ignore = $reason:literal])? $name:ident)*) => {
        $(#[test] $(#[ignore = $reason])? fn $name() { verify(stringify!($name)); })*

        #[test]
        fn every_case_has_its_test() {
            let names: Vec<(String, bool)> = table().into_iter().map(|case| (case.name, case.full)).collect();
            let tests = [$((stringify!($name).to_owned(), [$($reason,)? ""][0] == "long")),*];
            assert_eq!(names, tests);
        }
    };
}

verification! {
    patch
    patch_b_bar
    patch_one_point
    free_fall
    spin
    wave
    plastic_wave
    cantilever
    tube
    uniaxial_tension
    uniaxial_compression
    rates_that_turn
    rates_that_stretch
    taylor
    taylor_quarter
    taylor_whole
    taylor_total
    taylor_johnson_cook
    taylor_johnson_cook_total
    taylor_johnson_cook_hencky
    cook_2
    cook_4
    cook_8
    cook_8_hex8
    necking
    #[ignore = "long"] taylor_hex8
    #[ignore = "long"] taylor_b_bar
    #[ignore = "long"] taylor_one_point
    #[ignore = "long"] taylor_tet4
    #[ignore = "long"] taylor_wall
    #[ignore = "long"] taylor_fine
    #[ignore = "long"] cook_16
    #[ignore = "long"] cook_32
    #[ignore = "long"] necking_slow
    #[ignore = "long"] taylor_theory_total
    #[ignore = "long"] taylor_theory_hencky
    #[ignore = "long"] taylor_theory_simo_miehe
    #[ignore = "long"] taylor_theory_neo_hooke
    #[ignore = "long"] taylor_theory_green_naghdi
    upset_frictionless
    upset_coulomb
    upset_sticking
}

#[test]
fn every_file_that_a_case_needs_is_carried() {
    for case in table() {
        assert!(estar::shipped::file(&case.deck).is_some(), "{}", case.deck);
    }
}

/// Exit status, what was printed, the report's directory, and the one that holds it all.
type Verified = (i32, String, PathBuf, tempfile::TempDir);

/// What comes of a table of cases as a user may have, beside copies of these files of `meshes`.
fn verified_table(table: &str, files: &[&str]) -> Verified {
    let directory = tempfile::tempdir().unwrap();
    for name in files {
        let path = in_repository(&format!("meshes/{name}"));
        fs::copy(&path, directory.path().join(path.file_name().unwrap())).unwrap();
    }
    fs::write(directory.path().join("curve.csv"), "time,tip_displacement\n0,0\n5e-3,2.2e-3\n").unwrap();
    fs::write(directory.path().join("mine.toml"), table).unwrap();
    let output = directory.path().join("out");
    let arguments = ["verify", "--cases", "mine.toml", "--output", "out"];
    let said = Command::new(program()).args(arguments).current_dir(directory.path()).output().unwrap();
    let text = String::from_utf8_lossy(&[said.stdout, said.stderr].concat()).into_owned();
    (said.status.code().unwrap_or(-1), text, output, directory)
}

/// What comes of a case of Cook's membrane with this reference.
fn verified(expected: &str, tolerance: &str) -> Verified {
    let table = format!(
        "[[case]]\nname = \"mine\"\nabout = \"two <by> two\"\ndeck = \"cook.toml\"\nmesh = \"cook_2.msh\"\ncost = 0.1\nbits = true\n\
         check = [{{ quantity = \"tip_displacement\", value = \"{expected}\", tolerance = \"{tolerance}\", source = \"this program\" }}]\n"
    );
    verified_table(&table, &["cook/cook.toml", "cook/cook_2.msh"])
}

#[test]
fn a_right_reference_passes_and_the_report_shows_it() {
    let (code, said, output, _directory) = verified("2.180 mm", "1 %");
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("1 of 1 cases passed"), "{said}");
    let page = fs::read_to_string(output.join("report.html")).unwrap();
    for part in ["all 1 cases passed", "two &lt;by&gt; two", "2.180 mm ± 1 %", "<svg", "data:image/png;base64,"] {
        assert!(page.contains(part), "{part}");
    }
    // nothing is fetched from anywhere
    assert!(!page.contains("src=\"http") && !page.contains("href=\"http"));
    let json: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(output.join("verification.json")).unwrap()).unwrap();
    assert_eq!((json["passed"].as_bool(), json["cases"][0]["met"].as_bool()), (Some(true), Some(true)));
    assert_eq!(json["cases"][0]["state_hash"].as_str().map(str::len), Some(64));
}

#[test]
fn a_wrong_reference_fails_and_so_does_the_command() {
    let (code, said, output, _directory) = verified("2.9 mm", "1 %");
    assert_eq!(code, 5, "{said}");
    assert!(said.contains("FAILED") && said.contains("tip_displacement at end is 2.1"), "{said}");
    let page = fs::read_to_string(output.join("report.html")).unwrap();
    assert!(page.contains("1 of 1 cases failed"));
}

#[test]
fn tables_that_cannot_be_are_refused() {
    let directory = tempfile::tempdir().unwrap();
    let verify = |arguments: &[&str]| {
        let said =
            Command::new(program()).arg("verify").args(arguments).current_dir(directory.path()).output().unwrap();
        (said.status.code().unwrap_or(-1), String::from_utf8_lossy(&[said.stdout, said.stderr].concat()).into_owned())
    };
    let (code, said) = verify(&["--case", "tailor"]);
    assert!(code == 2 && said.contains("did you mean `taylor`?"), "{said}");
    let (code, said) = verify(&["--cases", "nowhere.toml"]);
    assert!(code == 4 && said.contains("nowhere.toml: cannot be read"), "{said}");
    fs::write(directory.path().join("bad.toml"), "[[case]]\nname = 1\n").unwrap();
    let (code, said) = verify(&["--cases", "bad.toml"]);
    assert!(code == 2 && said.contains("bad.toml"), "{said}");
    let lost = "[[case]]\nname = \"lost\"\nabout = \"\"\ndeck = \"lost.toml\"\ncost = 1\n\
                check = [{ quantity = \"mass\", value = \"1 kg\", tolerance = \"1 %\", source = \"\" }]\n";
    fs::write(directory.path().join("lost.toml"), lost.replace("lost.toml", "no.toml")).unwrap();
    let (code, said) = verify(&["--cases", "lost.toml"]);
    assert!(code == 5 && said.contains("no.toml"), "{said}");
    for (name, fault) in [("../escape", "letters, digits"), ("", "letters, digits")] {
        fs::write(directory.path().join("odd.toml"), lost.replacen("lost", name, 1)).unwrap();
        let (code, said) = verify(&["--cases", "odd.toml"]);
        assert!(code == 2 && said.contains(fault), "{said}");
    }
    fs::write(directory.path().join("twice.toml"), lost.repeat(2)).unwrap();
    let (code, said) = verify(&["--cases", "twice.toml"]);
    assert!(code == 2 && said.contains("two cases are named"), "{said}");
    let (code, said) = verify(&["--list"]);
    assert!(code == 0 && said.contains("taylor") && said.contains("with --full"), "{said}");
}

/// A table with a run of Cook's membrane and one with a material point; `change` makes another of it. What comes of it.
fn told(change: &dyn Fn(&str) -> String) -> Verified {
    const TABLE: &str = r#"
[[case]]
name = "membrane"
about = "two by two"
deck = "cook.toml"
mesh = "cook_2.msh"
cost = 0.1
check = [
    { quantity = "tip_displacement", at = { time = "5 ms" }, value = "2.18 mm", tolerance = "2 %", source = "this program" },
    { quantity = "time", at = { tip_displacement = "1 mm" }, value = "4 ms", tolerance = "0.5 ms", source = "this program" },
    { quantity = "kinetic_energy", at = "end", value = 0, tolerance = "1 J", source = "slow" },
]
curve = [
    { quantity = "tip_displacement", points = [[0, 0], ["5 ms", "2.18 mm"]], source = "a <curve>" },
    { quantity = "tip_displacement", file = "curve.csv", straight = true, source = "a file" },
]

[[case]]
name = "shear"
about = "sine"
command = "point"
deck = "corotational.toml"
set = ["path.steps=1000"]
cost = 0
check = [{ quantity = "jaumann.T12", at = { driven = 2 }, value = "0.909297 Pa", tolerance = "1e-4 Pa", source = "sin 2" }]
"#;
    verified_table(&change(TABLE), &["cook/cook.toml", "cook/cook_2.msh", "point/corotational.toml"])
}

#[test]
fn a_material_point_is_a_case_and_reference_curves_stand_in_the_report() {
    let (code, said, output, _directory) = told(&str::to_owned);
    assert_eq!(code, 0, "{said}");
    let page = fs::read_to_string(output.join("report.html")).unwrap();
    for part in ["a &lt;curve&gt;", "a file", "jaumann.T12", "<code>estar point</code>"] {
        assert!(page.contains(part), "{part}");
    }
    // words are drawn as outlines: a curve shows by its colour
    assert!(page.contains("stroke=\"#009e73\""));
    assert!(page.contains("<td>2.1") && page.contains(" mm</td><td>2.18 mm ± 2 %</td><td>"));
    let json: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(output.join("verification.json")).unwrap()).unwrap();
    let units = |case: usize| {
        let findings = json["cases"][case]["findings"].as_array().unwrap();
        findings.iter().map(|finding| finding["unit"].as_str().unwrap()).collect::<Vec<_>>()
    };
    assert_eq!((units(0), units(1)), (vec!["m", "s", "J"], vec!["Pa"]));
}

#[test]
fn what_is_in_a_unit_of_something_else_is_refused_before_anything_runs() {
    for (from, to, parts) in [
        ("\"2.18 mm\", tol", "\"2.18 MPa\", tol", ["`value` is a stress, 2.18 MPa", "`tip_displacement` is a length"]),
        ("\"0.5 ms\"", "\"0.5 mm\"", ["`tolerance` is a length, 0.5 mm", "`time` is a time"]),
        ("at = { time = \"5 ms\" }", "at = { time = \"5 mm\" }", ["`at` is a length, 5 mm", "`time` is a time"]),
        (
            "at = { tip_displacement = \"1 mm\" }",
            "at = { tip_displacement = \"1 N\" }",
            ["`at` is a force", "a length"],
        ),
        ("value = 0, tolerance = \"1 J\"", "value = 0, tolerance = \"1 %\"", ["is a pure number, 1 %", "is an energy"]),
        ("[\"5 ms\", \"2.18 mm\"]]", "[\"5 ms\", \"2.18 s\"]]", ["`points` is a time, 2.18 s", "is a length"]),
        ("[\"5 ms\", \"2.18 mm\"]]", "[\"5 K\", \"2.18 mm\"]]", ["`points` is a temperature, 5 K", "is a time"]),
        ("\"0.909297 Pa\"", "\"0.909297 m\"", ["\"shear\": `value` is a length", "`jaumann.T12` is a stress"]),
        ("{ driven = 2 }", "{ driven = \"2 s\" }", ["`at` is a time, 2 s", "`driven` is a pure number"]),
    ] {
        let (code, said, output, _directory) = told(&|table| {
            assert!(table.contains(from), "{from}");
            table.replacen(from, to, 1)
        });
        assert!(code == 2 && parts.iter().all(|part| said.contains(part)), "{to}: {said}");
        assert!(!output.exists(), "{to}");
    }
}

#[test]
fn checks_and_curves_that_cannot_be_are_refused() {
    for (from, to, code_wanted, part) in [
        ("\"2.18 mm\", tol", "\"2.18 mmm\", tol", 2, "the unit `mmm` is not known"),
        ("\"2.18 mm\", tol", "\"1e999 mm\", tol", 2, "\"1e999 mm\" is too large"),
        ("\"2.18 mm\", tol", "true, tol", 2, "a quantity is a number or a string"),
        ("at = \"end\"", "at = \"ende\"", 2, "`at` is start, end, largest, always"),
        ("at = \"end\"", "at = {}", 2, "`at` names no column"),
        ("value = 0, tolerance = \"1 J\"", "value = \"0 J\", tolerance = \"1 %\"", 2, "allows no deviation at all"),
        (
            "value = 0, tolerance = \"1 J\"",
            "value = 0, tolerance = \"-1 J\"",
            2,
            "the case \"membrane\": `kinetic_energy`: a tolerance of -1 J is negative",
        ),
        ("tolerance = \"2 %\"", "tolerance = \"-2 %\"", 2, "`tip_displacement`: a tolerance of -2 % is negative"),
        (
            "check = [{ quantity = \"jaumann.T12\", at = { driven = 2 }, value = \"0.909297 Pa\", tolerance = \"1e-4 Pa\", source = \"sin 2\" }]",
            "check = []",
            2,
            "the case \"shear\": `check` is empty",
        ),
        ("points = [[0, 0], [\"5 ms\", \"2.18 mm\"]], ", "", 2, "needs either `points` or `file`"),
        ("file = \"curve.csv\"", "file = \"curve.csv\", points = [[0, 0]]", 2, "needs either `points` or `file`"),
        ("file = \"curve.csv\"", "file = \"no.csv\"", 5, "no.csv"),
        ("file = \"curve.csv\"", "file = \"curve.csv\", over = \"step\"", 5, "lacks a column \"step\""),
        ("set = [\"path.steps=1000\"]", "bits = true", 2, "a material point has no `mesh`, `bits` and `mirror`"),
        ("command = \"point\"", "command = \"points\"", 2, "points"),
        ("command = \"point\"", "", 5, "this is the deck of a material point"),
        ("quantity = \"jaumann.T12\"", "quantity = \"mass\"", 5, "there is no mass"),
        ("quantity = \"jaumann.T12\"", "quantity = \"zaremba.T12\"", 5, "there is no column \"zaremba.T12\""),
        ("at = { driven = 2 }", "at = { driven = 200 }", 5, "200 is never reached"),
    ] {
        let (code, said, _output, _directory) = told(&|table| {
            assert!(table.contains(from), "{from}");
            table.replacen(from, to, 1)
        });
        assert!(code == code_wanted && said.contains(part), "{to}: {code}: {said}");
    }
}

/// The table of cases as docs/verification.md shows it.
fn markdown() -> String {
    let mut text = String::from(
        "| case | deck, with | quantity | at | expected | source | million element steps |\n|---|---|---|---|---|---|---|\n",
    );
    for case in table() {
        let mut cells = [format!("`{}`: {}", case.name, case.about), deck_in_words(&case), format!("{}", case.cost)];
        for check in &case.check {
            let times = if check.times == 1.0 { String::new() } else { format!("{} × ", check.times) };
            let Check { quantity, at, value, tolerance, source, .. } = check;
            let at = if quantity == "mass" { String::new() } else { at.to_string() };
            let [name, deck, cost] = &cells;
            let _ = writeln!(
                text,
                "| {name} | {deck} | {times}`{quantity}` | {at} | {value} ± {tolerance} | {source} | {cost} |"
            );
            cells = Default::default();
        }
    }
    text
}

#[test]
fn docs_show_the_cases() {
    const BEGIN: &str = "<!-- cases: generated from tests/verification.toml -->\n";
    const END: &str = "<!-- end of cases -->";
    let path = in_repository("docs/verification.md");
    let found = fs::read_to_string(&path).unwrap();
    let (before, rest) = found.split_once(BEGIN).expect("docs/verification.md has no place for the cases");
    let (_, after) = rest.split_once(END).expect("docs/verification.md has no end of the cases");
    let wanted = format!("{before}{BEGIN}{}{END}{after}", markdown());
    if std::env::var_os("ESTAR_UPDATE_DOCS").is_some() {
        fs::write(&path, &wanted).unwrap();
    } else {
        assert!(
            found == wanted,
            "docs/verification.md is stale: ESTAR_UPDATE_DOCS=1 cargo test --release --test verification"
        );
    }
}
