//! `estar point`: materials along a path, without a mesh.

pub mod column;
pub mod path;
mod plots;

use crate::console::{is_coloured, print, tell};
use crate::deck::point::{PointProblem, Subject};
use crate::deck::source::read_text;
use crate::deck::{self, Reading};
use crate::diagnostics::Findings;
use crate::failure::Failure;
use crate::output::default_directory;
use column::Column;
use estar_io::{AtomicFile, Value, write_atomically};
use estar_material::point::{MaterialPoint, Observation, PathError, follow};
use estar_material::{Consistency, Material, MaterialModel, MaterialVisitor};
use path::Path;
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

/// Pixels of the picture per unit of the drawing: sharp on paper at the width of a page.
const PIXELS_PER_UNIT: f64 = 2.0;

/// Leads the materials of a deck along its path.
///
/// # Errors
/// See [`Failure`].
pub fn point(options: &PointOptions) -> Result<(), Failure> {
    let text = read_text(&options.deck)?;
    let Reading { sources, deck: problem, decoder } = deck::read_point(&options.deck, &text, &options.overrides);
    let findings = Findings { sources, diagnostics: decoder.diagnostics };
    let told = findings.render(is_coloured());
    let Some(problem) = problem else { return Err(Failure::Input(told)) };
    tell(&told);

    let journeys: Vec<Journey> = problem.subjects.iter().map(|subject| Journey::of(subject, &problem.path)).collect();
    let directory = options.output.clone().unwrap_or_else(|| default_directory(&options.deck));
    std::fs::create_dir_all(&directory).map_err(Failure::writing(&directory))?;
    let table = directory.join("point.csv");
    write_table(&table, &problem, &journeys).map_err(Failure::writing(&table))?;
    let figure = plots::figure(&problem, &journeys).drawing();
    let files = [("point.svg", Some(figure.svg().into_bytes())), ("point.png", figure.png(PIXELS_PER_UNIT))];
    for (name, content) in files {
        let path = directory.join(name);
        let too_large = || io::Error::new(io::ErrorKind::FileTooLarge, "so many panels make too large a picture");
        let written = content.ok_or_else(too_large).and_then(|content| write_atomically(&path, &content));
        written.map_err(Failure::writing(&path))?;
    }
    let verdict = verdict(&problem);
    print(&(account(&problem, &journeys) + &verdict + &format!("\n  written    {}", directory.display())))?;

    let troubles: Vec<String> = problem.subjects.iter().zip(&journeys).filter_map(trouble).collect();
    if troubles.is_empty() { Ok(()) } else { Err(Failure::Simulation(troubles.join("\n"))) }
}

fn trouble((subject, journey): (&Subject, &Journey)) -> Option<String> {
    let error = journey.trouble.as_ref()?;
    Some(format!("error: {}: {error}\nhelp: the table and the plots show the path up to this step", subject.label))
}

/// What is told of a material at a moment.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// The time, s.
    pub time: f64,
    /// The value of the curve.
    pub driven: f64,
    /// What there is to tell of the point.
    pub observation: Observation,
    /// Whether plastic strain grew in the last step.
    pub flows: bool,
}

/// A material's way along the path.
#[derive(Clone, Debug)]
pub struct Journey {
    /// Its rows, the first that of the undeformed state.
    pub rows: Vec<Row>,
    /// What ended it too soon.
    trouble: Option<PathError>,
}

impl Journey {
    fn of(subject: &Subject, path: &Path) -> Self {
        subject.model.visit(Along(path))
    }
}

struct Along<'a>(&'a Path);

impl MaterialVisitor for Along<'_> {
    type Output = Journey;

    fn visit<M: Material>(self, material: &M) -> Journey {
        let Self(path) = self;
        let row = |time: f64, point: &MaterialPoint<'_, M>, flows| Row {
            time,
            driven: path.value(time),
            observation: point.observation(),
            flows,
        };
        let mut rows = vec![row(path.times[0], &MaterialPoint::new(material), false)];
        let last = path.times.len() - 1;
        let (mut step, mut strain_old) = (0, 0.0);
        let journey = follow(
            material,
            |time| path.control(time),
            &path.times,
            |time, point| {
                step += 1;
                let strain = point.equivalent_plastic_strain();
                if step % path.every == 0 || step == last {
                    rows.push(row(time, point, strain > strain_old));
                }
                strain_old = strain;
            },
        );
        Journey { rows, trouble: journey.err() }
    }
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
        text.push_str(&format!(": {}", problem.title.replace(char::is_control, " ")));
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

/// What the flow rules for the plastic metric keep along the path, each judged by its own figures.
fn verdict(problem: &PointProblem) -> String {
    let mut text = String::new();
    for subject in &problem.subjects {
        let MaterialModel::PlasticMetric(material) = &subject.model else { continue };
        let path = &problem.path;
        let Ok(found) = Consistency::along(material, |time| path.control(time), &path.times) else { continue };
        if text.is_empty() {
            text.push_str(&format!(
                "\n  {:<20} {:>11} {:>11} {:>11} {:>11} {:>11}",
                "plastic metric", "dissipation", "det C_p - 1", "asymmetry", "least value", "Simo-Miehe"
            ));
        }
        let is_consistent = if found.is_consistent() { "consistent" } else { "not consistent" };
        text.push_str(&format!(
            "\n  {:<20} {:>11.3e} {:>11.1e} {:>11.1e} {:>11.6} {:>11.1e}  {is_consistent}",
            subject.label,
            found.least_dissipation,
            found.determinant_drift,
            found.asymmetry,
            found.least_principal_value,
            found.distance_from_simo_miehe,
        ));
    }
    text
}
