//! Goal: what the program is built of keeps what is promised of it. As cargo tells it, no package needs a newer compiler than
//! `rust-version` says, and THIRD-PARTY-NOTICES has every package that is in the program, and no other.
//!
//! Cargo asks the network for packages of other systems that were never fetched; without it the tests say that they were skipped, but
//! for CI (where `CI` is set), which must have it.

use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// What cargo prints about the packages of Cargo.lock.
fn told_by_cargo(arguments: &[&str]) -> Option<String> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo).args(arguments).arg("--locked").current_dir(root()).output().unwrap();
    if !output.status.success() {
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(std::env::var_os("CI").is_none(), "{told}");
        eprintln!("skipped: cargo {}: {told}", arguments.join(" "));
        return None;
    }
    Some(String::from_utf8(output.stdout).unwrap())
}

fn text<'a>(value: &'a Value, key: &str) -> &'a str {
    value[key].as_str().unwrap()
}

/// Major, minor and patch of a version.
fn version(text: &str) -> [u32; 3] {
    let mut numbers = text.split('.').map(|number| number.parse().unwrap());
    std::array::from_fn(|_| numbers.next().unwrap_or(0))
}

#[test]
fn no_dependency_needs_a_newer_compiler_than_the_program_says() {
    let Some(told) = told_by_cargo(&["metadata", "--format-version", "1"]) else { return };
    let metadata: Value = serde_json::from_str(&told).unwrap();
    let packages = metadata["packages"].as_array().unwrap();
    let ours = packages.iter().find(|package| text(package, "name") == "estar").unwrap();
    let ours = version(text(ours, "rust_version"));
    let newer = |package: &&Value| package["rust_version"].as_str().is_some_and(|needed| version(needed) > ours);
    let newer: Vec<String> = packages
        .iter()
        .filter(newer)
        .map(|package| format!("{} {}", text(package, "name"), text(package, "rust_version")))
        .collect();
    assert!(newer.is_empty(), "{newer:?} need more than {ours:?}");
    assert!(packages.len() > 100, "{}", packages.len());
}

#[test]
fn the_notices_have_every_package_of_the_program_and_no_other() {
    // neither what builds it nor what tests it, on any system; packages of this workspace have a path
    let Some(tree) = told_by_cargo(&["tree", "--edges", "normal", "--target", "all", "--prefix", "none"]) else {
        return;
    };
    let foreign = tree.lines().filter(|line| !line.contains("(/") && !line.contains(":\\"));
    let named = |line: &str| {
        let mut words = line.split_whitespace();
        Some(format!("{} {}", words.next()?, words.next()?.strip_prefix('v')?))
    };
    let needed: BTreeSet<String> = foreign.filter_map(named).collect();
    assert!(needed.len() > 50, "{needed:?}");
    let notices = notices();
    let told = notices.lines().filter_map(|line| line.strip_prefix("package "));
    let told: BTreeSet<String> = told.map(str::to_owned).collect();
    let (missing, stale): (Vec<_>, Vec<_>) = (needed.difference(&told).collect(), told.difference(&needed).collect());
    let help = "about.toml has the command that makes THIRD-PARTY-NOTICES again";
    assert!(missing.is_empty() && stale.is_empty(), "missing {missing:?}, stale {stale:?}: {help}");
}

fn notices() -> String {
    std::fs::read_to_string(root().join("THIRD-PARTY-NOTICES")).unwrap()
}

#[test]
fn the_program_prints_the_notices_that_it_is_given_away_with() {
    let output = Command::new(env!("CARGO_BIN_EXE_estar")).arg("notices").output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let printed = String::from_utf8(output.stdout).unwrap();
    let notices = notices();
    assert!(printed.trim_end() == notices.trim_end(), "the program has other notices than the file");
    // the licences of the fonts that are in the program, too
    let font = std::fs::read_to_string(root().join("crates/post/src/plot/font/LICENSE")).unwrap();
    assert!(notices.contains(font.trim()));
}
