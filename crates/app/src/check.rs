//! `estar check`: a dry run that says what a run would be and would cost.

use crate::console::{print, print_json, rendered, tell_findings, tell_rendered};
use crate::failure::Failure;
use crate::run_words::announcement;
use estar_deck::diagnostics::{Finding, Findings, Rendered};
use estar_deck::fields::Field;
use estar_deck::format::{bytes, count, duration, prefixed};
use estar_deck::history_column::COLUMNS;
use estar_deck::memory;
use estar_material::MaterialModel;
use estar_session::{MeshSummary, Observer, Problem, Session, SessionError, machine, problem_memory};
use estar_solver::model::{Formulation, Part};
use estar_solver::{LaneLevel, Simulation};
use serde::Serialize;
use std::fmt::Write;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Elements that are named because they control the time step.
const CONTROLLING_SHOWN: usize = 10;
/// Real steps are timed for so long at most.
const TIMING: Duration = Duration::from_millis(1000);
/// Steps that are timed at most.
const TIMED_STEPS: u64 = 200;

/// What the command line asks for.
#[derive(Clone, Debug)]
pub struct CheckOptions {
    /// The deck.
    pub deck: PathBuf,
    /// Overrides of keys of the deck.
    pub overrides: Vec<String>,
    /// Threads; all cores unless given.
    pub threads: Option<usize>,
    /// Vector instructions; the best unless given.
    pub lanes: Option<LaneLevel>,
    /// Print JSON.
    pub json: bool,
}

/// What a check found.
#[derive(Debug, Default, Serialize)]
struct Report {
    is_good: bool,
    findings: Vec<Finding>,
    #[serde(flatten)]
    forecast: Option<Forecast>,
}

/// What a run would be.
#[derive(Debug, Serialize)]
struct Forecast {
    mesh: MeshSummary,
    quality: Quality,
    end_time: f64,
    initial_time_step: f64,
    stable_time_steps: StableTimeSteps,
    controlling_elements: Vec<Controlling>,
    steps_expected: f64,
    threads: usize,
    lanes: &'static str,
    element_steps_per_second: f64,
    seconds_expected: f64,
    memory_bytes: f64,
    memory_left_bytes: Option<f64>,
    frames_expected: f64,
    output_bytes_at_most: f64,
    /// Whether more steps, because they shrink, make more frames or rows.
    #[serde(skip)]
    grows_with_steps: bool,
    /// What to know of the elements that were chosen.
    notes: Vec<String>,
}

/// Quality of the mesh.
#[derive(Debug, Serialize)]
struct Quality {
    min_scaled_jacobian: f64,
    mean_scaled_jacobian: f64,
    min_volume: f64,
    max_volume: f64,
    total_volume: f64,
}

/// Stable time steps without the safety factor, s.
#[derive(Debug, Serialize)]
struct StableTimeSteps {
    /// From the bound of the elements, of `time_step = "element"`.
    element: f64,
    /// From the estimate for the assembled mesh, of `time_step = "power"`, where its elements can have that.
    #[serde(skip_serializing_if = "Option::is_none")]
    power: Option<f64>,
}

/// An element with its stable time step.
#[derive(Debug, Serialize)]
struct Controlling {
    element: u64,
    stable_time_step: f64,
}

/// Checks a deck and says what a run would be.
///
/// # Errors
/// Every fault of deck and mesh.
pub fn check(options: &CheckOptions) -> Result<(), Failure> {
    let (pool, lanes) = machine(options.threads, options.lanes)?;
    pool.install(|| {
        let mut noted = Noted { memory_left: None, doubts: Vec::new(), doubts_in_words: None };
        match Session::load(&options.deck, &options.overrides, lanes, &mut noted) {
            Ok(mut session) => report(&mut session, noted.memory_left, options, lanes),
            Err(error) => {
                // what was doubted of the input is often why the solver refuses it
                if options.json {
                    let findings = noted.doubts.into_iter().chain(findings_of(&error)).collect();
                    print_json(&Report { findings, ..Report::default() })?;
                } else if let Some(doubts) = &noted.doubts_in_words {
                    tell_rendered(doubts);
                }
                Err(error.into())
            }
        }
    })
}

/// What is noted while a problem is loaded.
struct Noted {
    /// The memory (bytes) that is left for its state.
    memory_left: Option<u64>,
    /// What is doubted of deck and mesh.
    doubts: Vec<Finding>,
    /// The same as it is told.
    doubts_in_words: Option<Rendered>,
}

impl Observer for Noted {
    fn loaded(&mut self, _problem: &Problem) {
        self.memory_left = memory::available();
    }

    fn findings(&mut self, findings: &Findings) {
        self.doubts = findings.data();
        self.doubts_in_words = Some(rendered(findings));
    }
}

fn findings_of(error: &SessionError) -> Vec<Finding> {
    match error {
        SessionError::Faults { findings, .. } => findings.data(),
        SessionError::Deck(error) => vec![Finding::without_place(error.to_string())],
        error => vec![Finding::without_place(format!("error: {error}"))],
    }
}

fn report(
    session: &mut Session,
    memory_left: Option<u64>,
    options: &CheckOptions,
    lanes: LaneLevel,
) -> Result<(), Failure> {
    let introduction = announcement(session.problem(), session.simulation(), rayon::current_num_threads(), lanes);
    let forecast = forecast(session, memory_left, lanes);
    let problem = session.problem();
    if options.json {
        let report = Report { is_good: true, findings: problem.findings.data(), forecast: Some(forecast) };
        return print_json(&report);
    }
    tell_findings(&problem.findings);
    print(&format!("{introduction}\n{}", in_words(problem, &forecast)))
}

/// What a run would be; steps are made to time them.
fn forecast(session: &mut Session, memory_left: Option<u64>, lanes: LaneLevel) -> Forecast {
    let power = session.simulation_mut().global_time_step();
    let simulation = session.simulation();
    let initial_time_step = simulation.time_step();
    let controlling_elements = controlling_elements(session.problem(), simulation);
    let stable_time_steps = StableTimeSteps { element: simulation.element_time_step(), power };
    let rate = timed_rate(session);

    let (problem, simulation) = (session.problem(), session.simulation());
    let end_time = simulation.end_time();
    let steps_expected = (end_time / initial_time_step).ceil();
    let frames_expected = problem.output.frames.count(end_time, steps_expected);
    let rows = problem.output.history.count(end_time, steps_expected);
    Forecast {
        mesh: MeshSummary::new(problem),
        quality: Quality {
            min_scaled_jacobian: problem.quality.min_scaled_jacobian,
            mean_scaled_jacobian: problem.quality.mean_scaled_jacobian,
            min_volume: problem.quality.min_volume,
            max_volume: problem.quality.max_volume,
            total_volume: problem.quality.total_volume,
        },
        end_time,
        initial_time_step,
        stable_time_steps,
        controlling_elements,
        steps_expected,
        threads: rayon::current_num_threads(),
        lanes: lanes.name(),
        element_steps_per_second: rate,
        seconds_expected: steps_expected * simulation.element_count() as f64 / rate,
        memory_bytes: problem_memory::needed(problem) as f64,
        memory_left_bytes: memory_left.map(|left| left as f64),
        frames_expected,
        output_bytes_at_most: frames_expected * bytes_of_frame(problem) + rows * bytes_of_row(problem),
        grows_with_steps: [problem.output.frames, problem.output.history]
            .iter()
            .any(|interval| interval.count(end_time, 2.0 * steps_expected) > interval.count(end_time, steps_expected)),
        notes: notes(problem),
    }
}

/// The elements with the smallest stable time steps, the smallest first.
fn controlling_elements(problem: &Problem, simulation: &Simulation) -> Vec<Controlling> {
    let mut steps: Vec<(u64, f64)> =
        problem.mesh.element_labels().iter().map(|label| label.0).zip(simulation.stable_time_steps()).collect();
    steps.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
    let shown = steps.into_iter().take(CONTROLLING_SHOWN);
    shown.map(|(element, stable_time_step)| Controlling { element, stable_time_step }).collect()
}

/// Element steps per second of the first real steps; a failing step ends the timing.
fn timed_rate(session: &mut Session) -> f64 {
    // the first step wakes the threads and the caches
    let mut goes_on = matches!(session.advance(&mut ()), Ok(None));
    let (start, mut steps) = (Instant::now(), 0_u64);
    while goes_on && (steps == 0 || (steps < TIMED_STEPS && start.elapsed() < TIMING)) {
        goes_on = matches!(session.advance(&mut ()), Ok(None));
        steps += u64::from(goes_on);
    }
    steps.max(1) as f64 * session.simulation().element_count() as f64 / start.elapsed().as_secs_f64()
}

/// Bytes of a frame before compression.
fn bytes_of_frame(problem: &Problem) -> f64 {
    let (nodes, elements) = (problem.mesh.node_count() as f64, problem.mesh.element_count() as f64);
    let corners = problem.mesh.elements().all_nodes().len() as f64;
    let field = |field: &Field| match field {
        Field::Displacement | Field::Velocity => 24.0 * nodes,
        Field::CauchyStress => 48.0 * elements,
        _ => 8.0 * elements,
    };
    let fixed = nodes * (24.0 + 8.0) + 4.0 * corners + elements * (4.0 + 1.0 + 8.0 + 4.0);
    fixed + problem.output.fields.iter().map(field).sum::<f64>()
}

/// Bytes of a row of the history.
fn bytes_of_row(problem: &Problem) -> f64 {
    20.0 * (COLUMNS.len() + problem.probes.len()) as f64
}

fn in_words(problem: &Problem, forecast: &Forecast) -> String {
    let mut text = String::from("  quality    ");
    text.push_str(&problem.quality.to_string().trim_end().replace('\n', "\n             "));
    let StableTimeSteps { element, power } = forecast.stable_time_steps;
    let _ = write!(text, "\n  stable     {element:.6e} s by the bound of the elements");
    if let Some(power) = power {
        let _ = write!(
            text,
            ", {power:.6e} s by the assembled mesh: {:.1} % more with\n             [time] time_step = \"power\"",
            100.0 * (power / element - 1.0)
        );
    }
    let _ = write!(text, "\n  the elements that control the time step (stable step without the safety factor):");
    for controlling in &forecast.controlling_elements {
        let _ = write!(text, "\n    element {:<10} {:.6e} s", controlling.element, controlling.stable_time_step);
    }
    let left = forecast.memory_left_bytes.map_or(String::new(), |left| format!(" of {} that are left", bytes(left)));
    let memory = bytes(forecast.memory_bytes);
    let (about, at_most) = if forecast.grows_with_steps { ("about ", "about") } else { ("", "at most") };
    let _ = write!(
        text,
        "\n  steps      {} or more: steps shrink where elements are squeezed\n  memory     about {memory}{left}\n  \
         output     {about}{} frames, {at_most} {} before compression\n  time       {} or more at {}element steps/s, timed on real steps",
        count(forecast.steps_expected),
        count(forecast.frames_expected),
        bytes(forecast.output_bytes_at_most),
        duration(forecast.seconds_expected),
        prefixed(forecast.element_steps_per_second)
    );
    for note in &forecast.notes {
        let _ = write!(text, "\n  note       {note}");
    }
    text.push_str("\nno errors");
    text
}

/// What to know of the elements that were chosen, of each part that it concerns.
fn notes(problem: &Problem) -> Vec<String> {
    let yields = |part: &Part| !matches!(part.material, MaterialModel::Elastic(_) | MaterialModel::Hypoelastic(_));
    let parts = problem.parts.iter().zip(&problem.model.parts);
    parts
        .filter(|(_, part)| part.element == Formulation::Tet4 && yields(part))
        .map(|(description, _)| {
            format!(
                "part {}: forces of `tet4` are good where metals flow, but its pressure is coarse and it is stiff in bending; `tet10`, on \
                 tets of ten nodes, is better in both",
                description.group
            )
        })
        .collect()
}
