//! Verification: whole problems, run as a user runs them, against published values and closed forms.
//!
//! The cases are in `tests/verification.toml`, and `docs/verification.md` shows the same table. Those that take long are
//! ignored unless asked for: `cargo test --release --test verification -- --include-ignored`.

use estar::deck::units;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A run and what must come of it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Case {
    name: String,
    about: String,
    /// Relative to the repository.
    deck: String,
    /// A mesh in place of the deck's: a file relative to the repository, or arguments of `estar mesh`.
    mesh: Option<MeshSource>,
    /// Overrides of the deck, as for `--set`.
    #[serde(default)]
    set: Vec<String>,
    /// Millions of element steps.
    cost: f64,
    check: Vec<Check>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum MeshSource {
    File(String),
    Generated(Vec<String>),
}

/// A value that a run must give.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Check {
    /// A column of history.csv, or `mass`.
    quantity: String,
    #[serde(default = "at_the_end")]
    at: When,
    /// How many of the modelled part make the whole body.
    #[serde(default = "one")]
    times: f64,
    value: String,
    /// A percentage of the value, or a quantity in its unit.
    tolerance: String,
    source: String,
}

/// Which row of the history counts.
#[derive(Deserialize)]
#[serde(untagged)]
enum When {
    /// `start`, `end`, `largest` (the largest value of the run) or `always` (every row).
    Word(String),
    /// Where another column first reaches a value.
    Where(BTreeMap<String, String>),
}

fn at_the_end() -> When {
    When::Word("end".to_owned())
}

fn one() -> f64 {
    1.0
}

impl When {
    fn text(&self) -> String {
        match self {
            Self::Word(word) => word.clone(),
            Self::Where(columns) => {
                columns.iter().map(|(column, value)| format!("{column} = {value}")).collect::<Vec<_>>().join(", ")
            }
        }
    }
}

fn in_repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

fn cases() -> Vec<Case> {
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Table {
        case: Vec<Case>,
    }
    let text = fs::read_to_string(in_repository("tests/verification.toml")).unwrap();
    toml::from_str::<Table>(&text).unwrap_or_else(|error| panic!("tests/verification.toml: {error}")).case
}

/// SI value of a quantity such as `"7.22 mm"`.
fn si(text: &str) -> f64 {
    units::parse(text).unwrap_or_else(|error| panic!("{text:?}: {error}")).value
}

/// history.csv by columns.
struct History(BTreeMap<String, Vec<f64>>);

impl History {
    fn read(path: &Path) -> Self {
        let text = fs::read_to_string(path).unwrap();
        let mut lines = text.lines();
        let names: Vec<&str> = lines.next().unwrap().split(',').collect();
        let mut columns = BTreeMap::new();
        for line in lines {
            for (name, cell) in names.iter().zip(line.split(',')) {
                columns.entry((*name).to_owned()).or_insert_with(Vec::new).push(cell.parse().unwrap());
            }
        }
        Self(columns)
    }

    fn column(&self, name: &str) -> &[f64] {
        self.0.get(name).unwrap_or_else(|| panic!("history.csv has no column {name:?}"))
    }

    /// The values that count.
    fn values(&self, name: &str, at: &When) -> Vec<f64> {
        let column = self.column(name);
        match at {
            When::Word(word) => match word.as_str() {
                "start" => vec![column[0]],
                "end" => vec![column[column.len() - 1]],
                "largest" => vec![column.iter().copied().fold(f64::NEG_INFINITY, f64::max)],
                "always" => column.to_vec(),
                _ => panic!("at = {word:?}"),
            },
            When::Where(columns) => {
                columns.iter().map(|(other, value)| self.where_reached(name, other, si(value))).collect()
            }
        }
    }

    /// Value of a column where another first reaches `value`, between rows by a straight line.
    fn where_reached(&self, name: &str, other: &str, value: f64) -> f64 {
        let (column, other) = (self.column(name), self.column(other));
        let after = (1..other.len())
            .find(|&row| other[row - 1] < value && value <= other[row])
            .unwrap_or_else(|| panic!("{value} is never reached"));
        let part = (value - other[after - 1]) / (other[after] - other[after - 1]);
        column[after - 1] + part * (column[after] - column[after - 1])
    }
}

fn estar(arguments: &[&str]) -> (i32, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_estar")).args(arguments).output().unwrap();
    let said = [output.stdout, output.stderr].concat();
    (output.status.code().unwrap_or(-1), String::from_utf8_lossy(&said).into_owned())
}

/// Runs a case and compares what comes out. A deck that is run as it stands must meet its own expectations, too.
fn verify(name: &str) {
    let cases = cases();
    let case = cases.iter().find(|case| case.name == name).unwrap();
    let directory = tempfile::tempdir().unwrap();
    let path = |name: &str| directory.path().join(name).to_str().unwrap().to_owned();
    let (deck, results) = (in_repository(&case.deck), path("results"));

    let mut set = case.set.clone();
    match &case.mesh {
        None => (),
        Some(MeshSource::File(file)) => set.push(format!("mesh.file='{}'", in_repository(file).display())),
        Some(MeshSource::Generated(arguments)) => {
            let mesh = path("mesh.msh");
            let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
            let (code, said) = estar(&[&["mesh"], &arguments[..], &["--output", &mesh]].concat());
            assert_eq!(code, 0, "{said}");
            set.extend([format!("mesh.file='{mesh}'"), "mesh.scale=1.0".to_owned()]);
        }
    }
    if !set.is_empty() {
        set.push("expect=[]".to_owned());
    }
    let set: Vec<&str> = set.iter().flat_map(|entry| ["--set", entry]).collect();
    let run = ["run", deck.to_str().unwrap(), "--output", &results, "--quiet", "--threads", "1"];
    let (code, said) = estar(&[&run[..], &set].concat());
    assert_eq!(code, 0, "{said}");

    let history = History::read(&directory.path().join("results/history.csv"));
    let summary = fs::read_to_string(directory.path().join("results/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    let mut missed = String::new();
    for check in &case.check {
        let expected = si(&check.value);
        let tolerance = match check.tolerance.strip_suffix('%') {
            Some(percent) if expected != 0.0 => percent.trim().parse::<f64>().unwrap() / 100.0 * expected.abs(),
            _ => si(&check.tolerance),
        };
        let found = match check.quantity.as_str() {
            "mass" => vec![summary["mesh"]["mass"].as_f64().unwrap()],
            quantity => history.values(quantity, &check.at),
        };
        for found in found.into_iter().map(|found| check.times * found) {
            println!("{} at {}: {found:.6e}, expected {expected:.6e}", check.quantity, check.at.text());
            if (found - expected).abs().partial_cmp(&tolerance) != Some(std::cmp::Ordering::Less) {
                let Check { quantity, value, tolerance, source, .. } = check;
                let _ = writeln!(
                    missed,
                    "{quantity} at {} is {found:.6e}, not {value} ± {tolerance} ({source})",
                    check.at.text()
                );
            }
        }
    }
    assert!(missed.is_empty(), "{name}\n{missed}");
}

/// A test for each case.
macro_rules! verification {
    ($($(#[$attribute:meta])* $name:ident)*) => {
        $(#[test] $(#[$attribute])* fn $name() { verify(stringify!($name)); })*

        #[test]
        fn every_case_has_its_test() {
            let names: Vec<String> = cases().into_iter().map(|case| case.name).collect();
            assert_eq!(names, [$(stringify!($name)),*]);
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

/// The table of cases as docs/verification.md shows it.
fn markdown() -> String {
    let mut text = String::from(
        "| case | deck, with | quantity | at | expected | source | million element steps |\n|---|---|---|---|---|---|---|\n",
    );
    for case in cases() {
        let mut deck = format!("`{}`", case.deck);
        match &case.mesh {
            None => (),
            Some(MeshSource::File(file)) => deck += &format!("; mesh `{file}`"),
            Some(MeshSource::Generated(arguments)) => deck += &format!("; mesh `{}`", arguments.join(" ")),
        }
        for entry in &case.set {
            deck += &format!("; `{entry}`");
        }
        let mut cells = [format!("`{}`: {}", case.name, case.about), deck, format!("{}", case.cost)];
        for check in &case.check {
            let times = if check.times == 1.0 { String::new() } else { format!("{} × ", check.times) };
            let Check { quantity, value, tolerance, source, .. } = check;
            let at = if quantity == "mass" { String::new() } else { check.at.text() };
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
