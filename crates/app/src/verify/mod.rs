//! `estar verify`: the cases of verification, run on the user's machine, and a report that shows what came of them.

pub mod cases;
pub mod dimensions;
mod report;

use crate::console::{print, tell};
use crate::failure::Failure;
use crate::shipped;
use cases::{Case, Finding, MeshSource, Reference, Runner};
use clap::Args;
use dimensions::Dimensions;
use estar_deck::format::duration;
use estar_deck::source::{TextError, read_text};
use estar_deck::units::Dimension;
use estar_io::{read_ordinary, write_atomically};
use estar_post::table::Table;
use serde::Serialize;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

/// What the command line asks for.
#[derive(Debug, Args)]
pub struct VerifyArguments {
    /// Only this case; may be given several times
    #[arg(long = "case", value_name = "NAME")]
    names: Vec<String>,
    /// Print the cases
    #[arg(long)]
    list: bool,
    /// All cases, those that take long, too
    #[arg(long)]
    full: bool,
    /// Directory of the report and of the runs
    #[arg(long, value_name = "DIR", default_value = "verification")]
    output: PathBuf,
    /// A table of cases of your own, in place of the program's; decks and meshes are relative to it
    #[arg(long, value_name = "FILE")]
    cases: Option<PathBuf>,
}

/// What became of a case.
#[derive(Debug, Serialize)]
pub struct Outcome {
    /// Its name.
    pub name: String,
    /// What it shows.
    pub about: String,
    /// The deck, and what was changed in it.
    pub deck: String,
    /// Whether all of it was as it should be.
    pub met: bool,
    /// What was found.
    pub findings: Vec<Finding>,
    /// Why it could not be run or judged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trouble: Option<String>,
    /// Wall time, s.
    pub seconds: f64,
    /// SHA-256 of every bit of the final state; empty for a material point.
    pub state_hash: String,
    /// What the columns of its table are, as far as its deck says.
    #[serde(skip)]
    pub dimensions: Option<Dimensions>,
    /// The points of its reference curves, SI.
    #[serde(skip)]
    pub references: Vec<Vec<[f64; 2]>>,
}

/// Where decks and meshes come from.
#[derive(Clone, Debug)]
pub enum Source {
    /// The program itself.
    Shipped,
    /// The folder of a table of cases.
    Folder(PathBuf),
}

/// Runs the cases and writes the report.
///
/// # Errors
/// No such case, a table or a report that cannot be read or written, or a case that was not met.
pub fn verify(arguments: &VerifyArguments) -> Result<(), Failure> {
    let (text, source) = match &arguments.cases {
        None => (cases::TABLE.to_owned(), Source::Shipped),
        Some(path) => {
            let text = read_text(path).map_err(|error| match error {
                TextError::Unreadable { path, error } => Failure::reading(&path)(error),
                other => Failure::Input(format!("error: {other}")),
            })?;
            (text, Source::Folder(path.parent().unwrap_or(Path::new("")).to_owned()))
        }
    };
    let refused = |error: String| {
        let path = arguments.cases.as_deref().unwrap_or(Path::new("verification.toml"));
        Failure::Input(format!("error: {}: {error}", path.display()))
    };
    let all = cases::cases(&text).map_err(refused)?;
    for name in &arguments.names {
        if !all.iter().any(|case| case.name == *name) {
            let names = || all.iter().map(|case| case.name.as_str());
            let similar = estar_deck::diagnostics::nearest(name, names());
            let similar = similar.map_or(String::new(), |name| format!("did you mean `{name}`? "));
            let help = format!("help: {similar}`estar verify --list` prints them");
            return Err(Failure::Input(format!("error: there is no case `{name}`\n{help}")));
        }
    }
    let is_wanted = |case: &&Case| match arguments.names.as_slice() {
        [] => arguments.full || arguments.list || !case.full,
        names => names.contains(&case.name),
    };
    let wanted: Vec<&Case> = all.iter().filter(is_wanted).collect();
    if arguments.list {
        let line = |case: &&Case| {
            let full = if case.full { ", with --full" } else { "" };
            format!("{:32} {} ({} million element steps{full})", case.name, case.about, case.cost)
        };
        return print(&wanted.iter().map(line).collect::<Vec<_>>().join("\n"));
    }
    for case in &wanted {
        let fault = dimensions(case, &source).and_then(|dimensions| dimensions.fault(case));
        if let Some(fault) = fault {
            return Err(refused(format!("the case \"{}\": {fault}", case.name)));
        }
    }
    let output = &arguments.output;
    fs::create_dir_all(output).map_err(Failure::writing(output))?;
    let output = &output.canonicalize().map_err(Failure::reading(output))?;
    let program = std::env::current_exe().map_err(Failure::reading(Path::new("estar")))?;
    let start = Instant::now();
    let mut outcomes = Vec::new();
    for (index, case) in wanted.iter().enumerate() {
        tell(&format!("{}/{} {}: {} ... ", index + 1, wanted.len(), case.name, case.about));
        let outcome = run_case(&program, case, &source, &output.join("runs").join(&case.name))?;
        let verdict = if outcome.met { "passed" } else { "FAILED" };
        tell(&format!("{verdict} in {}\n", duration(outcome.seconds)));
        for line in faults(&outcome) {
            tell(&format!("    {line}\n"));
        }
        outcomes.push(outcome);
    }
    let report = report::Report::new(&wanted, &outcomes, &text, start.elapsed().as_secs_f64());
    let page = report.write(output)?;
    let failed = outcomes.iter().filter(|outcome| !outcome.met).count();
    let said = format!("{} of {} cases passed: {}", outcomes.len() - failed, outcomes.len(), page.display());
    if failed == 0 { print(&said) } else { Err(Failure::Expectation(format!("error: {said}"))) }
}

/// What was not as it should be, a line each.
pub fn faults(outcome: &Outcome) -> Vec<String> {
    let missed = outcome.findings.iter().filter(|finding| !finding.met);
    let line = |finding: &Finding| {
        let at = if finding.at.is_empty() { String::new() } else { format!(" at {}", finding.at) };
        format!("{}{at} is {}, not {} ({})", finding.quantity, finding.shown, finding.wanted, finding.source)
    };
    missed.map(line).chain(outcome.trouble.iter().cloned()).collect()
}

/// Runs a case in a directory of its own with the program at `program`, and holds what comes out against the table. A deck that
/// is run as it stands must meet its own expectations, too.
///
/// # Errors
/// The directory cannot be written. A run that fails is an outcome.
pub fn run_case(program: &Path, case: &Case, source: &Source, directory: &Path) -> Result<Outcome, Failure> {
    let start = Instant::now();
    // what an earlier verification left would be shown as if it were of this one
    if results(directory).exists() {
        fs::remove_dir_all(results(directory)).map_err(Failure::writing(directory))?;
    }
    fs::create_dir_all(directory).map_err(Failure::writing(directory))?;
    let mut outcome = Outcome {
        name: case.name.clone(),
        about: case.about.clone(),
        deck: deck_in_words(case),
        met: false,
        findings: Vec::new(),
        trouble: None,
        seconds: 0.0,
        state_hash: String::new(),
        dimensions: dimensions(case, source),
        references: Vec::new(),
    };
    match judged(program, case, source, directory, &mut outcome) {
        Ok(()) => outcome.met = outcome.findings.iter().all(|finding| finding.met),
        Err(trouble) => outcome.trouble = Some(trouble),
    }
    outcome.seconds = start.elapsed().as_secs_f64();
    Ok(outcome)
}

/// The deck of a case, and what is changed in it.
pub fn deck_in_words(case: &Case) -> String {
    let mut words = format!("`{}`", case.deck);
    if case.command == Runner::Point {
        words += "; `estar point`";
    }
    match &case.mesh {
        None => (),
        Some(MeshSource::File(file)) => words += &format!("; mesh `{file}`"),
        Some(MeshSource::Generated(arguments)) => words += &format!("; mesh `{}`", arguments.join(" ")),
    }
    for entry in &case.set {
        words += &format!("; `{entry}`");
    }
    words
}

/// Where the results of a case are.
pub fn results(directory: &Path) -> PathBuf {
    directory.join("results")
}

/// Runs a case and puts into `outcome` what was found; why there is nothing, if there is not.
fn judged(program: &Path, case: &Case, source: &Source, directory: &Path, outcome: &mut Outcome) -> Result<(), String> {
    for curve in &case.curve {
        outcome.references.push(reference(curve, case.command, source, directory)?);
    }
    let deck = placed(&case.deck, source, directory)?;
    let mut set = case.set.clone();
    match &case.mesh {
        None => (),
        Some(MeshSource::File(file)) => {
            let mesh = placed(file, source, directory)?;
            set.push(mesh_file(&mesh.display().to_string()));
        }
        Some(MeshSource::Generated(arguments)) => {
            let mesh = directory.join("mesh.msh").display().to_string();
            let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
            estar(program, &[&["mesh"], &arguments[..], &["--force", "--output", &mesh]].concat())?;
            set.extend([mesh_file(&mesh), "mesh.scale=1.0".to_owned()]);
        }
    }
    if !set.is_empty() && case.command == Runner::Run {
        set.push("expect=[]".to_owned());
    }
    let set: Vec<&str> = set.iter().flat_map(|entry| ["--set", entry]).collect();
    let deck = deck.display().to_string();
    let run = |folder: &Path, more: &[&str]| {
        let folder = folder.display().to_string();
        let command: &[&str] = match case.command {
            Runner::Run => &["run", &deck, "--quiet", "--output", &folder],
            Runner::Point => &["point", &deck, "--output", &folder],
        };
        estar(program, &[command, &set[..], more].concat())
    };
    let results = results(directory);
    run(&results, if case.command == Runner::Run { &["--force"] } else { &[] })?;
    let table = Table::read(&results.join(case.command.table())).map_err(|failure| failure.to_string())?;
    let summary = if case.command == Runner::Run { summary(&results)? } else { serde_json::Value::Null };
    for check in &case.check {
        let dimension = outcome.dimensions.as_ref().and_then(|dimensions| dimensions.column(&check.quantity));
        outcome.findings.push(Finding {
            unit: dimension.map_or_else(String::new, unit),
            ..check.finding(&table, summary["mesh"]["mass"].as_f64())?
        });
    }
    let hash = summary["state_hash"].as_str().unwrap_or("").to_owned();
    if case.bits {
        let steps = summary["steps"].as_u64().unwrap_or(0);
        for threads in ["1", "2", "3"] {
            let again = directory.join(format!("threads_{threads}"));
            run(&again, &["--force", "--threads", threads])?;
            same_bits(&hash, &again, &format!("{threads} threads"))?;
        }
        let again = directory.join("resumed");
        run(&again, &["--force", "--threads", "2", "--stop-at-step", &(steps / 2).max(1).to_string()])?;
        run(&again, &["--resume", "--threads", "1"])?;
        same_bits(&hash, &again, "a run that was stopped half-way and resumed")?;
    }
    outcome.state_hash = hash;
    Ok(())
}

/// The points of a reference curve, SI.
fn reference(curve: &Reference, command: Runner, source: &Source, directory: &Path) -> Result<Vec<[f64; 2]>, String> {
    let Some(file) = &curve.file else {
        return Ok(curve.points.iter().map(|[x, y]| [x.si(), y.si()]).collect());
    };
    let table = Table::read(&placed(file, source, directory)?).map_err(|failure| failure.to_string())?;
    let (over, quantity) = (curve.over(command), curve.quantity.as_str());
    table.pairs(over, quantity).ok_or_else(|| format!("{file} lacks a column \"{over}\" or \"{quantity}\""))
}

/// The SI unit of a dimension; none of a pure number.
fn unit(dimension: Dimension) -> String {
    if dimension == Dimension::NUMBER { String::new() } else { dimension.si_unit() }
}

/// What the columns of a case's table are; nothing if its deck cannot be read, which its run will say.
fn dimensions(case: &Case, source: &Source) -> Option<Dimensions> {
    let deck = match source {
        Source::Folder(folder) => read_text(&folder.join(&case.deck)).ok()?,
        Source::Shipped => String::from_utf8(shipped::file(&case.deck)?.to_vec()).ok()?,
    };
    Dimensions::of(case, &deck)
}

/// The override of the mesh's file, whatever characters its path has.
fn mesh_file(path: &str) -> String {
    format!("mesh.file=\"{}\"", path.replace('\\', "\\\\").replace('"', "\\\""))
}

fn same_bits(hash: &str, again: &Path, whose: &str) -> Result<(), String> {
    let found = summary(again)?;
    let found = found["state_hash"].as_str().unwrap_or("");
    if found == hash { Ok(()) } else { Err(format!("the bits of {whose} are others: {found} in place of {hash}")) }
}

fn summary(results: &Path) -> Result<serde_json::Value, String> {
    /// A summary is not so large.
    const MOST_BYTES: u64 = 64 << 20;
    let path = results.join("summary.json");
    let text = read_ordinary(&path, MOST_BYTES).map_err(|error| format!("{}: {error}", path.display()))?;
    serde_json::from_slice(&text).map_err(|error| format!("{}: {error}", path.display()))
}

/// A deck or a mesh, with what it needs beside it, in a place where the program can read it.
fn placed(path: &str, source: &Source, directory: &Path) -> Result<PathBuf, String> {
    match source {
        Source::Folder(folder) => {
            let path = folder.join(path);
            path.canonicalize().map_err(|error| format!("{}: {error}", path.display()))
        }
        Source::Shipped => {
            let (folder, name) = path.rsplit_once('/').unwrap_or(("", path));
            if shipped::file(path).is_none() {
                return Err(format!("the program does not carry {path}"));
            }
            for (name, content) in shipped::folder(folder) {
                let target = directory.join(name);
                write_atomically(&target, content).map_err(|error| format!("{}: {error}", target.display()))?;
            }
            Ok(directory.join(name))
        }
    }
}

/// Runs the program; what it said if it failed.
fn estar(program: &Path, arguments: &[&str]) -> Result<(), String> {
    let output =
        Command::new(program).args(arguments).output().map_err(|error| format!("{}: {error}", program.display()))?;
    if output.status.success() {
        return Ok(());
    }
    Err(format!("estar {}\n{}", arguments.join(" "), String::from_utf8_lossy(&output.stderr).trim()))
}
