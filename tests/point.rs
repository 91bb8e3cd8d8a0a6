//! `estar point`: the figures it gives, the files it writes, and what a user is told about a deck that cannot be read.
//!
//! Loading: the shipped decks of `meshes/point`. Source: de Vera 2016, sections 6.5 and 7.5; Xiao, Bruhns & Meyers 1997.

use estar_deck as deck;
use estar_material::point::Control;
use estar_tensor::Tensor;
use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes/point").join(name)
}

/// Runs `estar point` and returns what it said with the table that it wrote.
fn point(deck: &Path, arguments: &[&str]) -> (Output, TempDir, Table) {
    let directory = tempfile::tempdir().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_estar"));
    command.arg("point").arg(deck).arg("--output").arg(directory.path()).args(arguments);
    let output = command.output().unwrap();
    let table = Table::read(&directory.path().join("point.csv"));
    (output, directory, table)
}

/// point.csv by columns; an empty cell is not a number.
struct Table(HashMap<String, Vec<f64>>);

impl Table {
    fn read(path: &Path) -> Self {
        let text = fs::read_to_string(path).unwrap_or_default();
        let mut lines = text.lines();
        let names: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
        let mut columns: HashMap<String, Vec<f64>> =
            names.iter().map(|name| ((*name).to_owned(), Vec::new())).collect();
        for line in lines {
            let cells: Vec<&str> = line.split(',').collect();
            assert_eq!(cells.len(), names.len());
            for (name, cell) in names.iter().zip(cells) {
                let value = if cell.is_empty() { f64::NAN } else { cell.parse().unwrap() };
                columns.get_mut(*name).unwrap().push(value);
            }
        }
        Self(columns)
    }

    fn column(&self, name: &str) -> &[f64] {
        self.0.get(name).unwrap_or_else(|| panic!("no column {name}"))
    }

    /// The value of a column in the row in which another has the value `at`.
    fn value(&self, name: &str, driven: &str, at: f64) -> f64 {
        let row = self.column(driven).iter().position(|value| (value - at).abs() < 1e-9);
        self.column(name)[row.unwrap_or_else(|| panic!("{driven} is never {at}"))]
    }
}

#[test]
fn every_shipped_deck_runs_and_leaves_a_table_and_two_pictures() {
    let mut count = 0;
    for entry in fs::read_dir(shipped("")).unwrap() {
        let deck = entry.unwrap().path();
        if deck.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        let (output, directory, table) = point(&deck, &[]);
        assert!(output.status.success(), "{}: {}", deck.display(), String::from_utf8_lossy(&output.stderr));
        assert!(table.column("time").len() > 100, "{}", deck.display());
        for (name, values) in &table.0 {
            let may_be_empty = name.ends_with("ing_index") || name.ends_with("temperature");
            assert!(may_be_empty || values.iter().all(|value| value.is_finite()), "{}: {name}", deck.display());
        }
        let png = fs::read(directory.path().join("point.png")).unwrap();
        assert!(png.starts_with(b"\x89PNG") && png.len() > 20_000, "{}", deck.display());
        let svg = fs::read_to_string(directory.path().join("point.svg")).unwrap();
        // docs/theories.md shows these pictures
        let name = deck.file_stem().unwrap().to_str().unwrap();
        let shown = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("docs/figures/{name}.svg"));
        if std::env::var_os("ESTAR_UPDATE_DOCS").is_some() {
            fs::write(&shown, &svg).unwrap();
        }
        let stale = "is stale: ESTAR_UPDATE_DOCS=1 cargo test --release --test point";
        assert!(fs::read_to_string(&shown).unwrap_or_default() == svg, "{} {stale}", shown.display());
        assert!(svg.starts_with("<svg") && svg.ends_with("</svg>\n") && !svg.contains("NaN"), "{}", deck.display());
        count += 1;
    }
    assert!(count >= 5);
}

#[test]
fn uniaxial_tension_gives_the_figures_of_the_dissertation() {
    let (_, _, table) = point(&shipped("uniaxial-tension.toml"), &[]);
    let close = |found: f64, wanted: f64, tolerance: f64| {
        assert!((found - wanted).abs() <= tolerance, "{found} is not {wanted}");
    };
    close(table.value("T11", "driven", 0.2), 260e6, 1.0);
    close(table.value("S11", "driven", 0.2), 185.8e6, 0.05e6);
    close(table.value("Ep11", "driven", 0.2), 0.1982, 0.00005);
    close(table.value("Es11", "driven", 0.2), 0.0013, 1e-9);
    // figures 7.5 and 7.7 of the dissertation show T11 λ₂²/λ₁² where its eq. 7.65 has T11 λ₂²/λ₁
    let [axial, lateral] = ["F11", "F22"].map(|name| table.value(name, "driven", 0.2));
    close(260e6 * (lateral / axial).powi(2), 157.0e6, 0.05e6);
    close(260e6 * lateral.powi(2) / axial, 185.8e6, 0.05e6);
    // constant from E11 = 0.0013 on, linear before
    for (strain, stress) in table.column("E11").iter().zip(table.column("T11")) {
        close(*stress, (200e9 * strain).min(260e6), 1.0);
    }
    // Green-Naghdi: S11 stays, and T11 = λ₁/λ₂² S11 grows
    close(table.value("green_naghdi.T11", "driven", 0.2), 384.3e6, 0.05e6);
    close(table.value("green_naghdi.S11", "driven", 0.2), 260e6, 1.0);
    close(table.value("green_naghdi.Ep11", "driven", 0.2), 0.1987, 0.00005);
    close(table.value("green_naghdi.Es11", "driven", 0.2), 0.00093, 0.000005);
    // perfect plasticity: Φ = 0 where the material flows, and there is no Φ before
    let index = table.column("hardening_index");
    assert!(index[..13].iter().all(|value| value.is_nan()) && index[14..].iter().all(|value| *value == 0.0));

    let (_, _, table) = point(&shipped("uniaxial-compression.toml"), &[]);
    close(table.value("T11", "driven", -0.2), -260e6, 1.0);
    close(table.value("Es11", "driven", -0.2), -0.0013, 1e-9);
    close(table.value("T22", "driven", -0.2), 0.0, 30.0);
}

/// A deck of one material on a path; the material's keys behind its elastic constants, those of the path.
fn one_material(keys: &str, path: &str) -> String {
    format!(
        "[material.m]\ndensity = 7850.0\nyoung_modulus = \"200 GPa\"\npoisson_ratio = 0.3\n{keys}\n[path]\n{path}\n"
    )
}

#[test]
fn dynamic_recovery_is_dissipated() {
    let keys = "theory = \"e-star\"\nhardening = { law = \"perfect\", yield_stress = \"200 MPa\" }\nkinematic = { law = \
                \"armstrong-frederick\", modulus = \"40 GPa\", recovery = 200.0 }";
    let path = "kind = \"uniaxial-stress\"\nmeasure = \"logarithmic\"\ncurve = [[0.0, 0.0], [1.0, 1.0]]\nsteps = 5000\nevery = 50";
    let directory = tempfile::tempdir().unwrap();
    let deck = directory.path().join("deck.toml");
    fs::write(&deck, one_material(keys, path)).unwrap();
    let (output, _, table) = point(&deck, &[]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    // 3.98·10⁸ J/m³: crates/material/tests/closed_forms.rs has the closed form
    let dissipation = table.value("dissipation", "driven", 1.0);
    assert!((dissipation / 3.98e8 - 1.0).abs() < 1e-3, "{dissipation:e}");
}

#[test]
fn indices_are_those_of_the_theory_or_empty() {
    // to and fro, from the third row on all but a few rows flow
    let path = "kind = \"uniaxial-strain\"\nmeasure = \"logarithmic\"\ncurve = [[0, 0], [1, 0.05], [3, -0.05], [4, 0]]\nsteps = 400";
    let perfect = "hardening = { law = \"perfect\", yield_stress = \"200 MPa\" }";
    let theories = [
        format!("theory = \"e-star\"\n{perfect}\nkinematic = {{ law = \"prager\", modulus = \"20 GPa\" }}"),
        format!("theory = \"green-naghdi\"\n{perfect}"),
        format!("theory = \"hencky\"\nyield_surface = {{ kind = \"rankine\" }}\n{perfect}"),
        "theory = \"hencky\"\nyield_surface = { kind = \"drucker-prager\", friction_angle = \"30 deg\", cohesion = \"1 MPa\" }".to_owned(),
        "theory = \"hencky\"\nyield_surface = { kind = \"mohr-coulomb\", friction_angle = \"30 deg\", cohesion = \"1 MPa\" }".to_owned(),
        format!("theory = \"plastic-metric\"\nflow_rule = \"simo-hughes\"\n{perfect}"),
    ];
    for keys in theories {
        let directory = tempfile::tempdir().unwrap();
        let deck = directory.path().join("deck.toml");
        fs::write(&deck, one_material(&keys, path)).unwrap();
        let (output, _, table) = point(&deck, &[]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let [strain, loading, hardening] =
            ["equivalent_plastic_strain", "loading_index", "hardening_index"].map(|name| table.column(name));
        let flowing: Vec<usize> = (1..strain.len()).filter(|row| strain[*row] > strain[row - 1]).collect();
        assert!(flowing.len() > 50, "{keys}: {}", flowing.len());
        for row in flowing {
            assert!(loading[row] > 0.0, "{keys}: row {row} flows at {}", loading[row]);
            assert!(hardening[row] >= 0.0 || keys.contains("simo-hughes"), "{keys}: {}", hardening[row]);
        }
    }
}

#[test]
fn simple_shear_gives_the_published_values_of_every_rate() {
    let (_, _, table) = point(&shipped("corotational.toml"), &[]);
    // γ, T12/μ, T11/μ
    let published = [
        ("", [(1.0, 0.869784, 0.415900), (2.0, 1.386294, 1.141593), (5.0, 2.905369, 2.704319)]),
        ("jaumann.", [(1.0, 0.841471, 0.459698), (2.0, 0.909297, 1.416147), (5.0, -0.958924, 0.716338)]),
        ("logarithmic.", [(1.0, 0.860818, 0.430409), (2.0, 1.246450, 1.246450), (5.0, 1.223533, 3.058831)]),
    ];
    for (prefix, values) in published {
        for (shear, t12, t11) in values {
            let found = ["T12", "T11", "T22"].map(|name| table.value(&format!("{prefix}{name}"), "driven", shear));
            for (found, wanted) in found.into_iter().zip([t12, t11, -t11]) {
                assert!((found - wanted).abs() < 5e-6, "{prefix} γ = {shear}: {found} is not {wanted}");
            }
        }
    }
    let (_, _, table) = point(&shipped("convected.toml"), &[]);
    for shear in [1.0, 5.0, 10.0] {
        let square = shear * shear;
        let wanted = [
            ("", [shear, square, 0.0]),
            ("upper_convected.", [shear, square, 0.0]),
            ("lower_convected.", [shear, 0.0, -square]),
        ];
        for (prefix, wanted) in wanted {
            let found = ["T12", "T11", "T22"].map(|name| table.value(&format!("{prefix}{name}"), "driven", shear));
            for (found, wanted) in found.into_iter().zip(wanted) {
                assert!((found - wanted).abs() < 1e-9, "{prefix} γ = {shear}: {found} is not {wanted}");
            }
        }
    }
}

#[test]
fn the_table_has_the_promised_columns_and_rows() {
    let (output, directory, table) = point(&shipped("cyclic.toml"), &["--set", "path.every=7"]);
    let text = fs::read_to_string(directory.path().join("point.csv")).unwrap();
    let head = "time,driven,F11,F12,F13,F21,F22,F23,F31,F32,F33,T11,T22,T33,T12,T13,T23,R11,R22,R33,R12,R13,R23,S11,S22,S33,\
                S12,S13,S23,E11,E22,E33,E12,E13,E23,Ep11,Ep22,Ep33,Ep12,Ep13,Ep23,Es11,Es22,Es33,Es12,Es13,Es23,\
                Ed11,Ed22,Ed33,Ed12,Ed13,Ed23,equivalent_plastic_strain,hardening_index,loading_index,dissipation,\
                internal_energy,det_Cp,temperature,resting.F11,";
    assert!(text.starts_with(head), "{}", text.lines().next().unwrap());
    // 0, 7, 14, ..., 1799 and the last of 1800 steps
    assert_eq!(table.column("time").len(), 1 + 1800 / 7 + 1);
    assert_eq!(table.column("time").last(), Some(&9.0));
    assert!(String::from_utf8_lossy(&output.stdout).contains("the Bauschinger effect"));
}

const GOOD: &str = r#"
title = "A path"

[material.steel]
theory = "elastic"
density = 7850.0
young_modulus = "200 GPa"
poisson_ratio = 0.3

[material.copper]
theory = "e-star"
density = 8930.0
young_modulus = "117 GPa"
poisson_ratio = 0.35
hardening = { law = "linear", yield_stress = "400 MPa", modulus = "100 MPa" }

[path]
material = "steel"
kind = "uniaxial-stress"
measure = "logarithmic"
curve = [[0.0, 0.0], ["1 s", 0.1], [2.0, "-10 %"]]
rate = "jaumann"
compare = ["copper"]
steps = 20
every = 2

[[plot]]
x = "driven"
y = ["T11", "S11"]
"#;

/// What a user is told about a deck.
fn told(text: &str) -> String {
    let reading = deck::read_point(Path::new("deck.toml"), text, &[]);
    assert_eq!(reading.deck.is_none(), reading.decoder.diagnostics.has_errors());
    reading.decoder.diagnostics.render(&reading.sources, false).to_string()
}

/// What a user is told about the good deck after one replacement.
#[track_caller]
fn told_after(from: &str, to: &str) -> String {
    assert!(GOOD.contains(from), "{from}");
    told(&GOOD.replacen(from, to, 1))
}

#[track_caller]
fn assert_told(told: &str, parts: &[&str]) {
    for part in parts {
        assert!(told.contains(part), "no {part:?} in\n{told}");
    }
}

const CURVE: &str = "curve = [[0.0, 0.0], [\"1 s\", 0.1], [2.0, \"-10 %\"]]";

#[test]
fn the_good_deck_is_good() {
    assert_eq!(told(GOOD), "");
    assert_eq!(told(&GOOD.replace('\n', "\r\n")), "");
}

#[test]
fn what_every_path_needs_is_missed() {
    assert_told(&told(""), &["lacks `material`", "lacks `path`", "2 errors"]);
    assert_told(&told_after("kind = \"uniaxial-stress\"\n", ""), &["`path` lacks `kind`", "`simple-shear`"]);
    assert_told(&told_after(CURVE, ""), &["`path` lacks `curve`"]);
    let none = "title = \"x\"\n[material]\n[path]\nkind = \"simple-shear\"\ncurve = [[0, 0], [1, 1]]\n";
    assert_told(&told(none), &["the deck has no material", "[material.steel]"]);
    assert_told(&told_after("y = [\"T11\", \"S11\"]", ""), &["`plot` lacks `y`"]);
}

#[test]
fn keys_of_the_path_are_checked_each_at_its_place() {
    assert_told(&told_after("\"uniaxial-stress\"", "\"uniaxial\""), &["deck.toml:19:8", "cannot be \"uniaxial\""]);
    assert_told(&told_after("\"logarithmic\"", "\"log\""), &["deck.toml:20:11", "`green-lagrange`, `stretch`"]);
    assert_told(
        &told_after("measure = \"logarithmic\"", "measure = \"shear\""),
        &["`path.measure` cannot be \"shear\""],
    );
    assert_told(&told_after("\"jaumann\"", "\"jauman\""), &["deck.toml:22:8", "did you mean \"jaumann\"?"]);
    assert_told(
        &told_after("steps = 20", "steps = 0"),
        &["deck.toml:24:9", "`path.steps` must be a whole number from 1"],
    );
    assert_told(&told_after("steps = 20", "steps = 20.5"), &["`path.steps` must be a whole number from 1"]);
    assert_told(&told_after("steps = 20", "steps = 99999999999999999999"), &["`path.steps` must be a whole number"]);
    assert_told(&told_after("steps = 20", "steps = 18446744073709551615"), &["`path` would take", "the most are"]);
    assert_told(&told_after("steps = 20\nevery = 2", "steps = 5000000"), &["write 5000000 rows", "`every`"]);
    assert_told(&told_after("every = 2", "every = -1"), &["`path.every` must be a whole number from 1"]);
    assert_told(
        &told_after("material = \"steel\"", "material = \"stel\""),
        &["no material `stel`", "did you mean \"steel\"?"],
    );
    assert_told(&told_after("steps = 20", "stps = 20"), &["unknown key `stps`", "did you mean `steps`?"]);
    assert_told(&told_after("title = \"A path\"", "title = 3"), &["`title` must be a string"]);
    assert_told(&told_after("[path]", "[[path]]"), &["`path` must be a table, not a list"]);
}

#[test]
fn curves_must_be_those_of_a_body_that_begins_undeformed() {
    let curve = |measure: &str, curve: &str| {
        told(&GOOD.replace(CURVE, &format!("curve = {curve}")).replace("logarithmic", measure))
    };
    assert_eq!(curve("stretch", "[[0, 1], [1, 2]]"), "");
    assert_eq!(curve("green-lagrange", "[[0, 0], [1, -0.49]]"), "");
    assert_told(
        &curve("green-lagrange", "[[0, 0], [1, -0.5]]"),
        &["deck.toml:21:9", "point 2", "no stretch above 0 has"],
    );
    assert_told(&curve("stretch", "[[0, 1], [1, 0.0]]"), &["point 2", "no stretch above 0 has"]);
    assert_told(
        &curve("stretch", "[[0, 0.5], [1, 2]]"),
        &["begins with 0.5, which is not the undeformed state", "1 in"],
    );
    assert_told(&curve("logarithmic", "[[0, 0], [1, 1e6]]"), &["point 2"]);
    assert_told(&curve("logarithmic", "[[0, 0]]"), &["two points at least"]);
    assert_told(&curve("logarithmic", "[]"), &["the curve has no points"]);
    assert_told(&curve("logarithmic", "[[0, 0], [0, 1]]"), &["the times of the curve must increase"]);
    assert_told(&curve("logarithmic", "[[0, 0], [1, \"1 mm\"]]"), &["must be a pure number, not a length"]);
    assert_told(&curve("logarithmic", "[[0, 0], [1, nan]]"), &["must be a finite number"]);
    assert_told(&curve("logarithmic", "[[0, 0], [1, 2, 3]]"), &["must be [time, value]"]);
    assert_told(&curve("logarithmic", "7"), &["must be a list of points"]);
    let shear = GOOD.replace("uniaxial-stress", "simple-shear").replace("measure = \"logarithmic\"\n", "");
    assert_eq!(told(&shear), "");
    assert_told(&told(&shear.replace("[[0.0, 0.0]", "[[0.0, 0.1]")), &["begins with 0.1"]);
    // the noise of a gauge is undeformed
    let taken = |text: &str| {
        let reading = deck::read_point(Path::new("deck.toml"), text, &[]);
        let control = reading.deck.unwrap().path.control(0.0);
        assert_eq!(
            format!("{control:?}"),
            format!("{:?}", Control::deformation_gradient(Tensor::identity())),
            "{text}"
        );
        reading.decoder.diagnostics.render(&reading.sources, false).to_string()
    };
    let parts =
        ["warning: `path.curve` begins with 3.7e-9, which is taken as 0.0, the undeformed state", "at most 0.0001"];
    assert_told(&taken(&shear.replace("[[0.0, 0.0]", "[[0.0, 3.7e-9]")), &parts);
    let stretch = GOOD.replace("logarithmic", "stretch").replace(CURVE, "curve = [[0, 1.000001], [1, 0.98]]");
    let stretch = stretch.replace("uniaxial-stress", "uniaxial-strain");
    assert_told(&taken(&stretch), &["begins with 1.000001, which is taken as 1.0"]);
    assert_told(
        &told(&stretch.replace("0.98", "0.9999")),
        &["begins with 1.000001, which is not the undeformed state"],
    );
}

#[test]
fn rows_of_deformation_gradients_are_checked_one_by_one() {
    let rows = |rows: &str| {
        let path = format!("kind = \"deformation-gradient\"\ncurve = {rows}");
        told(&GOOD.replace("kind = \"uniaxial-stress\"\nmeasure = \"logarithmic\"\n", "").replace(CURVE, &path))
    };
    let identity = "[0, 1, 0, 0, 0, 1, 0, 0, 0, 1]";
    assert_eq!(rows(&format!("[{identity}, [\"1 ms\", 1, 0.5, 0, 0, 1, 0, 0, 0, 1.2]]")), "");
    assert_told(&rows(&format!("[{identity}]")), &["needs two rows at least"]);
    assert_told(
        &rows("[[0, 1, 0, 0, 0, 1, 0, 0, 0, 2], [1, 1, 0, 0, 0, 1, 0, 0, 0, 1]]"),
        &["must be the undeformed state"],
    );
    assert_told(
        &rows("[[0, 1, 0, 0, 0, 1, 0, 0, 0, 1.000003], [1, 1.1, 0, 0, 0, 1, 0, 0, 0, 1]]"),
        &["warning: `path.curve` begins with F11 = 1.0 to F33 = 1.000003, which is taken as the undeformed state"],
    );
    assert_told(&rows(&format!("[{identity}, [1, 2, 3]]")), &["has 3 numbers, not 10", "F31, F32, F33"]);
    assert_told(&rows(&format!("[{identity}, 5]")), &["is no list"]);
    assert_told(&rows(&format!("[{identity}, [1, -1, 0, 0, 0, 1, 0, 0, 0, 1]]")), &["deforms no body", "det F = -1"]);
    assert_told(&rows(&format!("[{identity}, [1, 1e200, 0, 0, 0, 1e200, 0, 0, 0, 1]]")), &["deforms no body", "inf"]);
    assert_told(&rows(&format!("[{identity}, [0, 1, 0, 0, 0, 1, 0, 0, 0, 1]]")), &["is not later than the one before"]);
    assert_told(
        &rows(&format!("[{identity}, [1, 1, 0, 0, 0, \"x\", 0, 0, 0, 1]]")),
        &["it does not begin with a number"],
    );
    assert_told(&rows("\"none\""), &["must be a list of rows"]);
}

#[test]
fn what_is_compared_must_be_there_and_fit() {
    let compared = |with: &str| told_after("compare = [\"copper\"]", &format!("compare = {with}"));
    assert_eq!(compared("[]"), "");
    assert_eq!(compared("[\"box\", \"truesdell\", \"copper\"]"), "");
    assert_told(
        &compared("[\"coper\"]"),
        &["deck.toml:23:12", "`path.compare` cannot have \"coper\"", "did you mean \"copper\"?"],
    );
    assert_told(&compared("[\"steel\"]"), &["\"steel\" once too often", "the material of the path itself"]);
    assert_told(&compared("[\"jaumann\"]"), &["\"jaumann\" once too often"]);
    assert_told(&compared("[\"copper\", \"copper\"]"), &["once too often", "the second time"]);
    assert_told(&compared("\"copper\""), &["`path.compare` must be a list"]);
    // a theory that needs what the material does not have
    assert_told(&compared("[\"e-star\"]"), &["lacks `hardening`", "deck.toml:23:12"]);
    // a rate is for elastic materials
    let plastic = GOOD.replace("material = \"steel\"", "material = \"copper\"");
    assert_told(&told(&plastic), &["`path.rate` is for elastic materials", "deck.toml:22:8"]);
    let plastic = plastic.replace("rate = \"jaumann\"\n", "");
    assert_eq!(told(&plastic.replace("compare = [\"copper\"]", "compare = [\"elastic\", \"steel\"]")), "");
    assert_told(&told(&plastic.replace("compare = [\"copper\"]", "compare = [\"box\"]")), &["cannot have \"box\""]);
    // a fault of the material is told once
    let faulty =
        plastic.replace("compare = [\"copper\"]", "compare = [\"hencky\"]").replace("\"117 GPa\"", "\"117 GPs\"");
    assert_told(&told(&faulty), &["`GPs` is not known", "1 error "]);
    // a yield surface that one theory has
    let soil = format!("{SOIL}{}", PULLED.replace("steps", "compare = [\"e-star\"]\nsteps"));
    assert_told(&told(&soil), &["cannot have \"e-star\": it does not know the yield surface", "1 error "]);
    assert_eq!(told(&soil.replace("\"e-star\"", "\"elastic\"")), "");
}

#[test]
fn panels_name_columns_of_one_kind() {
    let panel = |y: &str| told_after("y = [\"T11\", \"S11\"]", &format!("y = {y}"));
    assert_told(&panel("[]"), &["`plot.y` names no column"]);
    assert_told(&panel("[\"T11\", \"E11\"]"), &["columns of different kinds", "begin another [[plot]]"]);
    assert_told(&panel("[\"T11\", \"T11\"]"), &["names a column twice"]);
    assert_told(&panel("[\"T99\"]"), &["point.csv has no column \"T99\"", "the columns are time, driven"]);
    assert_told(&panel("[\"equivalent_plastic_strian\"]"), &["did you mean \"equivalent_plastic_strain\"?"]);
    assert_told(&told_after("x = \"driven\"", "x = 1"), &["`plot.x` must be a string"]);
    let cold = ["shows a temperature, but no material", "the law johnson-cook"];
    assert_told(&panel("[\"temperature\"]"), &cold);
    assert_told(&told_after("x = \"driven\"", "x = \"temperature\""), &cold);
}

#[test]
fn any_deck_is_answered_without_a_panic() {
    for end in (0..GOOD.len()).filter(|end| GOOD.is_char_boundary(*end)) {
        told(&GOOD[..end]);
    }
    let lines: Vec<&str> = GOOD.lines().collect();
    for skipped in 0..lines.len() {
        let kept = lines.iter().enumerate().filter(|(index, _)| *index != skipped);
        told(&kept.map(|(_, line)| format!("{line}\n")).collect::<String>());
    }
    // every value by what it must not be
    for (index, line) in lines.iter().enumerate() {
        let Some((key, _)) = line.split_once(" = ") else { continue };
        for value in ["nan", "-inf", "\"\"", "[]", "{}", "[[]]", "[[[]]]", "1979-05-27", "true", "\"\\u0000\"", "9e999"]
        {
            let changed: Vec<String> = lines
                .iter()
                .enumerate()
                .map(|(other, line)| if other == index { format!("{key} = {value}") } else { (*line).to_owned() })
                .collect();
            told(&changed.join("\n"));
        }
    }
}

#[test]
fn what_goes_wrong_on_the_way_is_told_and_what_came_before_is_kept() {
    let directory = tempfile::tempdir().unwrap();
    let deck = directory.path().join("deck.toml");
    let run = |text: &str| {
        fs::write(&deck, text).unwrap();
        let (output, kept, table) = point(&deck, &[]);
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned(), kept, table)
    };
    let (code, errors, ..) = run(&GOOD.replace("steps = 20", "steps = 0"));
    assert_eq!(code, Some(2), "{errors}");

    // a turn by half a revolution between two steps
    let rows = "curve = [[0, 1,0,0, 0,1,0, 0,0,1], [1, 1.1,0,0, 0,1,0, 0,0,1], [2, -1,0,0, 0,-1,0, 0,0,1]]";
    let turned = GOOD
        .replace("kind = \"uniaxial-stress\"\nmeasure = \"logarithmic\"\n", "kind = \"deformation-gradient\"\n")
        .replace(CURVE, rows);
    let (code, errors, kept, table) = run(&turned);
    assert_eq!(code, Some(3), "{errors}");
    assert_told(&errors, &["error: steel: step ", "from time 1.", "error: copper: step "]);
    assert!(table.column("time").len() > 5 && kept.path().join("point.png").is_file());

    // a first step that cannot be made leaves the undeformed state, and nothing to draw
    let at_once = format!(
        "{SOIL}[path]\nkind = \"deformation-gradient\"\ncurve = [[0, 1,0,0, 0,1,0, 0,0,1], [1, -1,0,0, 0,-1,0, 0,0,1]]\nsteps = 1\n"
    );
    let (code, errors, kept, table) = run(&at_once);
    assert_eq!((code, table.column("time").len()), (Some(3), 1), "{errors}");
    assert_told(&errors, &["error: soil: step 1, from time 0.0 s"]);
    assert!(!kept.path().join("point.png").exists());

    let missing = Command::new(env!("CARGO_BIN_EXE_estar")).args(["point", "no/such/deck.toml"]).output().unwrap();
    assert_eq!(missing.status.code(), Some(4));
    fs::write(&deck, GOOD).unwrap();
    let occupied =
        Command::new(env!("CARGO_BIN_EXE_estar")).arg("point").arg(&deck).arg("--output").arg(&deck).output();
    assert_eq!(occupied.unwrap().status.code(), Some(4));
    let no_deck = Command::new(env!("CARGO_BIN_EXE_estar")).arg("point").output().unwrap();
    assert_eq!(no_deck.status.code(), Some(2));
}

const SOIL: &str = "[material.soil]\ndensity = 2000.0\nyoung_modulus = \"1 GPa\"\npoisson_ratio = 0.3\ntheory = \"hencky\"\n\
                    yield_surface = { kind = \"mohr-coulomb\", friction_angle = \"30 deg\", cohesion = \"1 MPa\" }\n";
const PULLED: &str =
    "[path]\nkind = \"uniaxial-stress\"\nmeasure = \"logarithmic\"\ncurve = [[0, 0], [1, 0.1]]\nsteps = 100\n";

#[test]
fn verdicts_on_flow_rules_are_written_for_programs() {
    let (output, kept, table) = point(&shipped("flow-rules.toml"), &[]);
    // of the invariants of C C_p⁻¹; that of the symmetric part of C_p⁻¹ would be -1983 MPa
    let last = |name: &str| *table.column(&format!("frobenius_normal.{name}")).last().unwrap();
    let mean = (last("T11") + last("T22") + last("T33")) / 3.0;
    assert!((mean + 537.4e6).abs() < 0.5e6, "{mean:e}");
    let text = fs::read_to_string(kept.path().join("consistency.json")).unwrap();
    let verdicts: serde_json::Value = serde_json::from_str(&text).unwrap();
    let verdicts = verdicts.as_array().unwrap();
    assert_eq!(verdicts.len(), 7);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    for verdict in verdicts {
        let faulty = ["Simo & Hughes", "Frobenius-normal"].contains(&verdict["material"].as_str().unwrap());
        assert_eq!(verdict["verdict"], if faulty { "not consistent" } else { "consistent" }, "{verdict}");
        assert!(verdict["flowing_steps"].as_u64().unwrap() > 10, "{verdict}");
    }
    assert_told(&said, &["det drift", "not consistent"]);

    // where nothing flows nothing is shown
    let elastic = "material.solid.hardening.yield_stress='1e6 GPa'";
    let (output, kept, _) = point(&shipped("flow-rules.toml"), &["--set", elastic, "--set", "path.steps=100"]);
    assert_told(&String::from_utf8_lossy(&output.stdout), &["no flow: no verdict"]);
    let text = fs::read_to_string(kept.path().join("consistency.json")).unwrap();
    assert_told(&text, &["\"flowing_steps\": 0", "\"least_dissipation\": null"]);
}

#[test]
fn a_rate_that_stretches_is_refused_for_elements() {
    let directory = tempfile::tempdir().unwrap();
    let estar = |arguments: &[&str]| {
        Command::new(env!("CARGO_BIN_EXE_estar")).args(arguments).current_dir(directory.path()).output().unwrap()
    };
    estar(&["mesh", "box", "--output", "box.msh"]);
    let deck = |rate: &str| {
        format!(
            "[mesh]\nfile = \"box.msh\"\n[material.rubber]\ntheory = \"elastic\"\nrate = \"{rate}\"\ndensity = 1000.0\n\
             young_modulus = \"1 GPa\"\npoisson_ratio = 0.3\n[[part]]\ngroup = \"box\"\nmaterial = \"rubber\"\n[time]\nend = \
             \"1 us\"\n"
        )
    };
    for (rate, code) in
        [("truesdell", 2), ("upper-convected", 2), ("lower-convected", 2), ("jaumann", 0), ("logarithmic", 0)]
    {
        fs::write(directory.path().join("deck.toml"), deck(rate)).unwrap();
        let output = estar(&["run", "deck.toml", "--force"]);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{rate}: {errors}");
        assert!(code == 0 || errors.contains("is for `estar point` only") && errors.contains("jaumann"), "{errors}");
    }
}
