//! `estar point`: materials along a path, without a mesh.

mod journey;
mod plots;

pub use journey::Journey;
pub use plots::panels;

use crate::console::{print, tell_findings};
use crate::failure::Failure;
use estar_deck::diagnostics::Findings;
use estar_deck::point_column::{Column, Row};
use estar_deck::point_problem::{PointProblem, Subject};
use estar_deck::source::read_text;
use estar_deck::{self as deck, Reading};
use estar_io::{AtomicFile, Value, one_line, write_atomically};
use estar_material::{Consistency, MaterialModel};
use estar_post::sheets;
use estar_session::default_directory;
use serde::Serialize;
use std::io::{self, Write};
use std::path::PathBuf;

/// What the command line asks for.
#[derive(Clone, Debug)]
pub struct PointOptions {
    /// The deck.
    pub deck: PathBuf,
    /// Overrides of keys of the deck.
    pub overrides: Vec<String>,
    /// Directory of the results.
    pub output: Option<PathBuf>,
}

/// Leads the materials of a deck along its path.
///
/// # Errors
/// See [`Failure`].
pub fn point(options: &PointOptions) -> Result<(), Failure> {
    let text = read_text(&options.deck)?;
    let Reading { sources, deck: problem, decoder } = deck::read_point(&options.deck, &text, &options.overrides);
    let findings = Findings { sources, diagnostics: decoder.diagnostics };
    let Some(problem) = problem else {
        return Err(Failure::Findings { findings, is_unreadable_file: false });
    };
    tell_findings(&findings);

    let journeys: Vec<Journey> = problem.subjects.iter().map(|subject| Journey::of(subject, &problem.path)).collect();
    let troubles: Vec<String> = problem.subjects.iter().zip(&journeys).filter_map(trouble).collect();
    let verdicts = verdicts(&problem);
    let directory = options.output.clone().unwrap_or_else(|| default_directory(&options.deck));
    std::fs::create_dir_all(&directory).map_err(Failure::writing(&directory))?;
    let table = directory.join("point.csv");
    write_table(&table, &problem, &journeys).map_err(Failure::writing(&table))?;
    let records = verdicts.iter().map(|(label, found)| VerdictRecord::new(label, found)).collect::<Vec<_>>();
    let records = if records.is_empty() { None } else { serde_json::to_vec_pretty(&records).ok() };
    replace(&directory.join("consistency.json"), records)?;
    // a path on which nothing changes has no panel
    let sheets = sheets::write(&directory, "point", &problem.title, panels(&problem, &journeys))?;
    let plots = if sheets > 1 { format!(", the plots on {sheets} sheets") } else { String::new() };
    let written = format!("\n  written    {}{plots}", directory.display());
    print(&(account(&problem, &journeys) + &verdict_in_words(&verdicts) + &written))?;
    if troubles.is_empty() { Ok(()) } else { Err(Failure::Simulation(troubles.join("\n"))) }
}

/// Writes a file whole, in place of that of an earlier run; or sees to it that there is none.
fn replace(path: &std::path::Path, content: Option<Vec<u8>>) -> Result<(), Failure> {
    let replaced = match content {
        Some(content) => write_atomically(path, &content),
        None => match std::fs::remove_file(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
            removed => removed,
        },
    };
    replaced.map_err(Failure::writing(path))
}

fn trouble((subject, journey): (&Subject, &Journey)) -> Option<String> {
    let error = journey.trouble.as_ref()?;
    Some(format!("error: {}: {error}\nhelp: the table and the plots show the path up to this step", subject.label))
}

/// Writes point.csv. A material that came to grief has empty cells from there on, and so has what is not defined: an
/// elastic strain where the plastic metric is not positive definite, as linear theories can have it.
fn write_table(path: &std::path::Path, problem: &PointProblem, journeys: &[Journey]) -> io::Result<()> {
    let columns = Column::all();
    let own: Vec<Column> = columns.iter().copied().filter(|column| !column.is_of_path()).collect();
    let of_path: Vec<Column> = columns.into_iter().filter(|column| column.is_of_path()).collect();
    let mut file = AtomicFile::create(path)?;
    let mut names: Vec<String> = of_path.iter().map(|column| column.name()).collect();
    for subject in &problem.subjects {
        names.extend(own.iter().map(|column| format!("{}{}", subject.prefix, column.name())));
    }
    writeln!(file, "{}", names.join(","))?;
    let longest = journeys.iter().max_by_key(|journey| journey.rows.len()).map_or(&[][..], |journey| &journey.rows);
    for (index, row) in longest.iter().enumerate() {
        let cell = |column: &Column, row: Option<&Row>| {
            let value = row.and_then(|row| column.value(row)).filter(|value| value.is_finite());
            value.map_or(Value::Missing, Value::Real).to_string()
        };
        let mut cells: Vec<String> = of_path.iter().map(|column| cell(column, Some(row))).collect();
        for journey in journeys {
            cells.extend(own.iter().map(|column| cell(column, journey.rows.get(index))));
        }
        writeln!(file, "{}", cells.join(","))?;
    }
    file.commit()
}

/// What came of it, in a few lines.
fn account(problem: &PointProblem, journeys: &[Journey]) -> String {
    let mut text = format!("Estar {}", env!("CARGO_PKG_VERSION"));
    if !problem.title.is_empty() {
        text.push_str(&format!(": {}", one_line(&problem.title)));
    }
    text.push_str(&format!(
        "\n  {:<20} {:>10} {:>14} {:>14} {:>14} {:>10}",
        "at the end", "steps", "T11, Pa", "T12, Pa", "S11, Pa", "plastic"
    ));
    for (subject, journey) in problem.subjects.iter().zip(journeys) {
        let Some(row) = journey.rows.last() else { continue };
        let seen = &row.observation;
        let steps = journey.trouble.as_ref().map_or(problem.path.times.len() - 1, |error| error.step - 1);
        text.push_str(&format!(
            "\n  {:<20} {steps:>10} {:>14.5e} {:>14.5e} {:>14.5e} {:>10.6}",
            subject.label,
            seen.stress.0[0],
            seen.stress.0[3],
            seen.second_piola_stress.0[0],
            seen.equivalent_plastic_strain
        ));
    }
    text
}

/// What each flow rule for the plastic metric keeps along the path, by the label of its material.
fn verdicts(problem: &PointProblem) -> Vec<(&str, Consistency)> {
    let path = &problem.path;
    let mut verdicts = Vec::new();
    for subject in &problem.subjects {
        if let MaterialModel::PlasticMetric(material) = &subject.model {
            let found = Consistency::along(material, |time| path.control(time), &path.times);
            verdicts.push((subject.label.as_str(), found));
        }
    }
    verdicts
}

/// The verdict on a flow rule.
fn verdict(found: &Consistency) -> String {
    if let Some(error) = &found.ended {
        return format!("not consistent: ended at step {}", error.step);
    }
    match found.is_consistent() {
        Some(true) => "consistent",
        Some(false) => "not consistent",
        None => "no flow: no verdict",
    }
    .to_owned()
}

fn verdict_in_words(verdicts: &[(&str, Consistency)]) -> String {
    if verdicts.is_empty() {
        return String::new();
    }
    let mut text = format!(
        "\n  {:<20} {:>11} {:>11} {:>11} {:>11} {:>11}",
        "plastic metric", "dissipation", "det drift", "asymmetry", "least value", "Simo-Miehe"
    );
    for (label, found) in verdicts {
        text.push_str(&format!(
            "\n  {label:<20} {:>11.3e} {:>11.1e} {:>11.1e} {:>11.6} {:>11.1e}  {}",
            found.least_dissipation,
            found.determinant_drift,
            found.asymmetry,
            found.least_principal_value,
            found.distance_from_simo_miehe,
            verdict(found),
        ));
    }
    text
}

/// A verdict as consistency.json has it; what is not a number is null there.
#[derive(Serialize)]
struct VerdictRecord<'a> {
    material: &'a str,
    verdict: String,
    flowing_steps: usize,
    least_dissipation: f64,
    determinant_drift: f64,
    asymmetry: f64,
    least_principal_value: f64,
    distance_from_simo_miehe: f64,
}

impl<'a> VerdictRecord<'a> {
    fn new(material: &'a str, found: &Consistency) -> Self {
        Self {
            material,
            verdict: verdict(found),
            flowing_steps: found.flowing_steps,
            least_dissipation: found.least_dissipation,
            determinant_drift: found.determinant_drift,
            asymmetry: found.asymmetry,
            least_principal_value: found.least_principal_value,
            distance_from_simo_miehe: found.distance_from_simo_miehe,
        }
    }
}
