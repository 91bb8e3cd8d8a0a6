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

/// A table of cases with a deck of its own, as a user may have; what comes of it.
fn verified(expected: &str, tolerance: &str) -> (i32, String, PathBuf, tempfile::TempDir) {
    let directory = tempfile::tempdir().unwrap();
    for name in ["cook.toml", "cook_2.msh"] {
        fs::copy(in_repository(&format!("meshes/cook/{name}")), directory.path().join(name)).unwrap();
    }
    let text = format!(
        "[[case]]\nname = \"mine\"\nabout = \"two <by> two\"\ndeck = \"cook.toml\"\nmesh = \"cook_2.msh\"\ncost = 0.1\nbits = true\n\
         check = [{{ quantity = \"tip_displacement\", value = \"{expected}\", tolerance = \"{tolerance}\", source = \"this program\" }}]\n"
    );
    fs::write(directory.path().join("mine.toml"), text).unwrap();
    let output = directory.path().join("out");
    let arguments = ["verify", "--cases", "mine.toml", "--output", "out"];
    let said = Command::new(program()).args(arguments).current_dir(directory.path()).output().unwrap();
    let text = String::from_utf8_lossy(&[said.stdout, said.stderr].concat()).into_owned();
    (said.status.code().unwrap_or(-1), text, output, directory)
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
    let lost = "[[case]]\nname = \"lost\"\nabout = \"\"\ndeck = \"lost.toml\"\ncost = 1\ncheck = []\n";
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
