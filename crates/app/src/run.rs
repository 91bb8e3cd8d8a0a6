//! `estar run`: from the deck to the results.

use crate::console::{Console, tell, tell_findings};
use crate::failure::Failure;
use crate::progress::{EarlierLegs, Progress};
use crate::signals;
use crate::view::Watch;
use estar_deck::format::{bytes, count, duration, prefixed};
use estar_deck::settings::CheckpointEvery;
use estar_deck::units::Dimension;
use estar_io::one_line;
use estar_session::bits::Bits;
use estar_session::checkpoint::{self, Bookmark, Checkpoints, Identity};
use estar_session::directory::{clear_directory, clear_partial_files, default_directory, make_directory};
use estar_session::expectations::{self, Expectation, Moment, Outcome};
use estar_session::files;
use estar_session::frames::{EarlierFrames, FrameWriter};
use estar_session::history::History;
use estar_session::inversion::{self, Approach, Neighbourhood};
use estar_session::judgement;
use estar_session::lock::Lock;
use estar_session::output::Schedule;
use estar_session::passing::Passing;
use estar_session::plausibility;
use estar_session::probes::Probe;
use estar_session::problem::Problem;
use estar_session::setup;
use estar_session::snapshot::Snapshot;
use estar_session::summary::{
    EnergySummary, ExtremeSummary, MeshSummary, QuasiStaticSummary, Summary, number, state_hash,
};
use estar_session::trouble;
use estar_solver::model::TimeStep;
use estar_solver::{Energies, LaneLevel, Simulation, SimulationError};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// What the command line asks for.
#[derive(Clone, Debug)]
pub struct RunOptions {
    /// The deck.
    pub deck: PathBuf,
    /// Overrides of keys of the deck.
    pub overrides: Vec<String>,
    /// Directory of the results.
    pub output: Option<PathBuf>,
    /// Threads; all cores unless given.
    pub threads: Option<usize>,
    /// Vector instructions; the best unless given.
    pub lanes: Option<LaneLevel>,
    /// Print nothing but errors.
    pub is_quiet: bool,
    /// Overwrite results.
    pub force: bool,
    /// Go on from the newest checkpoint in the directory.
    pub resume: bool,
    /// Stop at this step.
    pub stop_at_step: Option<u64>,
    /// Serve a page that shows the run.
    pub watch: bool,
}

/// How the loop ended.
enum Ending {
    Finished,
    /// By `--stop-at-step`, with a checkpoint.
    Stopped,
    /// By a signal, with a checkpoint.
    Interrupted,
    Failed(SimulationError),
}

/// Runs a deck.
///
/// # Errors
/// See [`Failure`].
pub fn run(options: &RunOptions) -> Result<(), Failure> {
    let (pool, lanes) = machine(options.threads, options.lanes)?;
    pool.install(|| {
        let problem = setup::load(&options.deck, &options.overrides)?;
        run_problem(problem, options, lanes)
    })
}

/// The threads and vector instructions to run on.
///
/// # Errors
/// The machine cannot give them.
pub fn machine(threads: Option<usize>, lanes: Option<LaneLevel>) -> Result<(rayon::ThreadPool, LaneLevel), Failure> {
    let lanes = lanes.unwrap_or_else(LaneLevel::best);
    if !lanes.is_available() {
        return Err(Failure::Input(format!("error: this machine has no {} instructions", lanes.name())));
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build();
    Ok((pool.map_err(|error| Failure::Input(format!("error: cannot start the threads: {error}")))?, lanes))
}

fn run_problem(mut problem: Problem, options: &RunOptions, lanes: LaneLevel) -> Result<(), Failure> {
    let simulation = setup::simulation(&problem, lanes);
    let of_steps = simulation.as_ref().ok().and_then(plausibility::doubt_about_steps);
    problem.findings.diagnostics.extend(of_steps);
    tell_findings(&problem.findings);
    let mut simulation = simulation?;
    let directory = options.output.clone().unwrap_or_else(|| default_directory(&options.deck));
    let identity = Identity::of(&problem);
    make_directory(&directory)?;
    let lock = Lock::acquire(&directory)?;
    let mut removed_frames = 0;
    let found = if options.resume {
        let found = checkpoint::newest(&directory, &identity, |found| {
            History::check(&directory, &problem, found.bookmark.history_rows)?;
            let frames = estar_io::removed_frames(&directory, found.bookmark.frame_times.len());
            removed_frames = frames.map_err(|error| error.to_string())?.len();
            let restored = found.restore(&problem, &mut simulation);
            if restored.is_err() {
                simulation = setup::simulation(&problem, lanes).map_err(|failure| failure.to_string())?;
            }
            restored
        })?;
        if let Some(stop) = options.stop_at_step.filter(|stop| *stop < found.step) {
            return Err(Failure::Input(format!(
                "error: --stop-at-step {stop} lies before step {}, from which this run would go on ({})\nhelp: a run goes on from \
                 its newest checkpoint; nothing has been changed",
                found.step, found.name
            )));
        }
        Some(found)
    } else {
        clear_directory(&directory, options.force)?;
        None
    };
    clear_partial_files(&directory);
    let mut console = Console::new(options.is_quiet);
    console.log_into(&directory, options.resume)?;
    let threads = rayon::current_num_threads();
    console.say(&announcement(&problem, &simulation, threads, lanes));
    if let Some(found) = &found {
        for refusal in &found.refusals {
            console.warn(refusal);
        }
        if removed_frames > 0 {
            console.warn(&format!(
                "{removed_frames} of the frames of this run are not there any more; results.pvd names the others"
            ));
        }
        console.say(&format!("  resumes    from {}, step {}", found.name, count(found.step as f64)));
    }

    let watch = options.watch.then(|| Watch::start(&directory));
    let is_interrupted = signals::interruption();
    let bookmark = found.map(|found| found.bookmark);
    let mut run = Run::start(problem, simulation, bookmark, &directory, identity, console)?;
    let ending = run.advance_to_end(&is_interrupted, options.stop_at_step);
    let outcome = run.conclude(ending, &is_interrupted, threads, lanes);
    drop(lock);
    if let Some(watch) = watch {
        watch.end();
    }
    outcome
}

/// A run under way.
struct Run<'a> {
    problem: Problem,
    simulation: Simulation,
    directory: &'a Path,
    console: Console,
    history: History,
    frames: FrameWriter,
    progress: Progress,
    frame_schedule: Schedule,
    history_schedule: Schedule,
    /// Position of each expectation whose moment is still to come.
    pending: Vec<usize>,
    outcomes: Vec<Option<Outcome>>,
    last_row: Option<u64>,
    jacobians: Vec<(u64, f64)>,
    approach: Approach,
    passing: Passing,
    initial_time_step: f64,
    checkpoints: Checkpoints<'a>,
    /// When the next checkpoint falls due.
    checkpoint_due: Option<Instant>,
    has_checkpoint: bool,
}

impl<'a> Run<'a> {
    /// A run that begins, or goes on from where a bookmark was left.
    fn start(
        problem: Problem,
        simulation: Simulation,
        bookmark: Option<Bookmark>,
        directory: &'a Path,
        identity: Identity,
        console: Console,
    ) -> Result<Self, Failure> {
        let goes_on = bookmark.is_some();
        let bookmark = bookmark.unwrap_or_else(|| beginning(&problem, &simulation));
        let history = if goes_on {
            History::resume(directory, &problem, bookmark.history_rows)?
        } else {
            History::create(directory, &problem)?
        };
        let earlier = EarlierFrames {
            times: bookmark.frame_times.iter().map(|time| f64::from(*time)).collect(),
            last_step: bookmark.last_frame,
        };
        let frames =
            FrameWriter::start(directory, &problem.mesh, &problem.model.parts, &problem.output.fields, earlier)?;
        let earlier = EarlierLegs { record_bytes: bookmark.record_bytes, wall_seconds: bookmark.wall_seconds };
        let progress = Progress::start(directory, &console, &simulation, earlier)?;
        let [frames_passed, rows_passed] = bookmark.passed;
        let outcome = |(expectation, seen): (&Expectation, &Option<[Bits; 2]>)| {
            let [time, value] = (*seen)?.map(f64::from);
            Some(expectation.outcome(&problem.probes[expectation.probe].name, time, value))
        };
        let mut run = Self {
            frame_schedule: Schedule::after(problem.output.frames, frames_passed),
            history_schedule: Schedule::after(problem.output.history, rows_passed),
            pending: bookmark.pending,
            outcomes: problem.expectations.iter().zip(&bookmark.outcomes).map(outcome).collect(),
            last_row: bookmark.last_row,
            jacobians: bookmark.jacobians.iter().map(|(step, jacobian)| (*step, f64::from(*jacobian))).collect(),
            approach: bookmark.approach,
            passing: Passing::new(&problem),
            initial_time_step: f64::from(bookmark.initial_time_step),
            checkpoint_due: None,
            has_checkpoint: goes_on,
            problem,
            simulation,
            directory,
            console,
            history,
            frames,
            progress,
            checkpoints: Checkpoints::of(directory, identity),
        };
        run.schedule_checkpoint();
        if !goes_on {
            run.write(true, true)?;
            run.check_pending();
        }
        Ok(run)
    }

    fn schedule_checkpoint(&mut self) {
        self.checkpoint_due = match self.problem.output.checkpoint {
            // a wait that no clock can tell is one for ever
            CheckpointEvery::Seconds(seconds) => {
                Duration::try_from_secs_f64(seconds).ok().and_then(|wait| Instant::now().checked_add(wait))
            }
            CheckpointEvery::Never => None,
        };
    }

    /// Writes a checkpoint of the present step, once everything that it refers to is on the disk.
    fn write_checkpoint(&mut self) -> Result<(), Failure> {
        self.history.sync()?;
        let EarlierFrames { times, last_step } = self.frames.sync()?;
        let frame_times = times.iter().map(|time| Bits::from(*time)).collect();
        let seen = |outcome: &Option<Outcome>| {
            outcome.as_ref().map(|outcome| [Bits::from(outcome.time), Bits::from(outcome.found)])
        };
        let bookmark = Bookmark {
            history_rows: self.history.row_count(),
            frame_times,
            last_frame: *last_step,
            record_bytes: self.progress.record_bytes()?,
            passed: [self.frame_schedule.passed(), self.history_schedule.passed()],
            last_row: self.last_row,
            pending: self.pending.clone(),
            outcomes: self.outcomes.iter().map(seen).collect(),
            jacobians: self.jacobians.iter().map(|(step, jacobian)| (*step, Bits::from(*jacobian))).collect(),
            approach: self.approach.clone(),
            initial_time_step: Bits::from(self.initial_time_step),
            wall_seconds: self.progress.wall_seconds(),
        };
        let name = self.checkpoints.write(bookmark, &self.simulation)?;
        self.console.note(&format!("{name}: t = {:.6e} s", self.simulation.time()));
        self.schedule_checkpoint();
        self.has_checkpoint = true;
        Ok(())
    }

    /// The loop.
    fn advance_to_end(&mut self, is_interrupted: &AtomicBool, stop_at_step: Option<u64>) -> Result<Ending, Failure> {
        while !self.simulation.is_finished() {
            let ending = if is_interrupted.load(Ordering::Relaxed) {
                Some(Ending::Interrupted)
            } else {
                stop_at_step.filter(|step| self.simulation.step() >= *step).map(|_| Ending::Stopped)
            };
            if ending.is_some() || self.checkpoint_due.is_some_and(|due| Instant::now() >= due) {
                self.write_checkpoint()?;
            }
            if let Some(ending) = ending {
                return Ok(ending);
            }
            if let Err(error) = self.simulation.advance() {
                return Ok(Ending::Failed(error));
            }
            self.look_out()?;
            let (time, step) = (self.simulation.time(), self.simulation.step());
            let row_is_due = self.history_schedule.is_due(time, step);
            let frame_is_due = self.frame_schedule.is_due(time, step);
            if row_is_due || frame_is_due {
                self.write(row_is_due, frame_is_due)?;
            }
            if !self.pending.is_empty() {
                self.check_pending();
            }
            self.progress.tell(&self.simulation, &mut self.console)?;
        }
        Ok(Ending::Finished)
    }

    /// Tells of elements that come close to inversion or are deleted. The approach is worth a checkpoint, unless the beginning
    /// is as near: if it ends badly the last steps are repeated from there.
    fn look_out(&mut self) -> Result<(), Failure> {
        if let Some(deletions) = self.approach.deletions(&self.problem, &self.simulation) {
            self.console.note(&deletions.told);
            for warning in &deletions.warnings {
                self.progress.beside(|| tell(&format!("{warning}\n")));
                self.console.note(warning);
            }
        }
        let warnings = self.approach.look(&self.problem, &self.simulation);
        for warning in &warnings {
            self.progress.beside(|| tell(&format!("{warning}\n")));
            self.console.note(warning);
        }
        if !warnings.is_empty() && self.has_checkpoint {
            self.write_checkpoint()?;
        }
        Ok(())
    }

    /// Writes a row and a frame of the present step, each once.
    fn write(&mut self, row: bool, frame: bool) -> Result<(), Failure> {
        let snapshot = Snapshot::new(&self.problem.mesh, &self.simulation);
        let step = self.simulation.step();
        // a repetition that was left may be at an earlier step than the last row
        if row && self.last_row < Some(step) {
            let values: Vec<f64> = self.problem.probes.iter().map(|probe| probe.value(&snapshot)).collect();
            let min_jacobian = self.history.write(&snapshot, &values)?;
            self.jacobians.push((step, min_jacobian));
            if self.jacobians.len() > trouble::JACOBIANS_SHOWN {
                self.jacobians.remove(0);
            }
            self.last_row = Some(step);
            for (expectation, outcome) in self.problem.expectations.iter().zip(&mut self.outcomes) {
                let value = values[expectation.probe];
                if expectation.moment == Moment::Max && outcome.as_ref().is_none_or(|largest| value > largest.found) {
                    let name = &self.problem.probes[expectation.probe].name;
                    *outcome = Some(expectation.outcome(name, self.simulation.time(), value));
                }
            }
        }
        if frame {
            self.frames.write(&self.simulation)?;
            if let Some(warning) = self.passing.look(&self.problem, &self.simulation) {
                self.progress.beside(|| tell(&format!("{warning}\n")));
                self.console.note(&warning);
            }
        }
        Ok(())
    }

    /// Looks at the expectations whose moment has come.
    fn check_pending(&mut self) {
        let time = self.simulation.time();
        let has_come =
            |index: &usize| matches!(self.problem.expectations[*index].moment, Moment::Time(moment) if time >= moment);
        let due: Vec<usize> = self.pending.iter().copied().filter(has_come).collect();
        if due.is_empty() {
            return;
        }
        self.pending.retain(|index| !due.contains(index));
        for index in due {
            self.outcomes[index] = Some(self.outcome(index));
        }
    }

    fn outcome(&self, index: usize) -> Outcome {
        let expectation = self.problem.expectations[index];
        let probe = &self.problem.probes[expectation.probe];
        let value = probe.value(&Snapshot::new(&self.problem.mesh, &self.simulation));
        expectation.outcome(&probe.name, self.simulation.time(), value)
    }

    /// Writes what remains to be written, however the loop ended, and says what came of it.
    fn conclude(
        mut self,
        ending: Result<Ending, Failure>,
        is_interrupted: &AtomicBool,
        threads: usize,
        lanes: LaneLevel,
    ) -> Result<(), Failure> {
        let ending = match ending {
            Ok(ending) => ending,
            Err(failure) => {
                // the disk is at fault: what is there stays, what can still be said is said
                let _ = self.progress.finish(&self.simulation);
                let failure = self.frames.finish().err().map_or(failure, Failure::from);
                let help = if self.has_checkpoint {
                    "everything written before can be read; when the cause is gone, --resume goes on from the newest checkpoint"
                } else {
                    "everything written before can be read; there was no checkpoint yet, from which --resume could go on"
                };
                let told = format!("{failure}\nhelp: {help}");
                self.console.note(&told);
                return Err(Failure::File(told));
            }
        };
        self.progress.finish(&self.simulation)?;
        let trouble = match &ending {
            Ending::Finished => None,
            Ending::Stopped => Some(format!("stopped {}", self.where_it_goes_on())),
            Ending::Interrupted => Some(format!("interrupted {}", self.where_it_goes_on())),
            Ending::Failed(error) => {
                let told = trouble::of_simulation(error, &self.problem, &self.simulation, &self.jacobians);
                let shown = match error {
                    SimulationError::ElementInverted { element, .. } | SimulationError::NotFinite { element, .. } => {
                        // why the run failed must be told, also when this cannot be written
                        let shown = self.show_last_steps(*element, is_interrupted, lanes);
                        shown.unwrap_or_else(|failure| format!("its last steps are not shown: {failure}"))
                    }
                    _ => "the last frame and the last row show the state at this step".to_owned(),
                };
                Some(format!("{}\n  {shown}\n{}", told.what, told.help))
            }
        };
        self.write(true, true)?;
        let frames = self.frames.finish()?;
        if matches!(ending, Ending::Finished) {
            for index in 0..self.outcomes.len() {
                if self.outcomes[index].is_none() {
                    self.outcomes[index] = Some(self.outcome(index));
                }
            }
        }
        let mut summary = self.summary(&ending, trouble.clone(), frames, threads, lanes);
        summary.warnings = judgement::warnings(&summary, &self.problem, self.simulation.energies().in_play);
        summary.write(self.directory)?;
        let outcomes = &summary.expectations;
        self.console.say(&conclusion(&summary, &self.problem.probes, self.directory));
        for warning in &summary.warnings {
            tell(&format!("{warning}\n"));
            self.console.note(warning);
        }
        if !outcomes.is_empty() {
            self.console.say(&expectations::table(outcomes));
        }
        if let Some(trouble) = &trouble {
            self.console.note(trouble);
        }
        match (ending, trouble) {
            (Ending::Stopped, _) => Ok(()),
            (Ending::Interrupted, Some(trouble)) => Err(Failure::Interrupted(trouble)),
            (Ending::Failed(_), Some(trouble)) => Err(Failure::Simulation(trouble)),
            _ if !summary.expectations_met => {
                let missed = outcomes.iter().filter(|outcome| !outcome.met).count();
                let table = if self.console.is_quiet() {
                    format!("\n{}", expectations::table(outcomes))
                } else {
                    String::new()
                };
                Err(Failure::Expectation(format!("error: {missed} of {} expectations missed{table}", outcomes.len())))
            }
            _ => Ok(()),
        }
    }

    /// Goes back to the last good step, which is repeated bit for bit from the newest checkpoint or from the beginning, and
    /// writes the series of `hex` and its neighbours through the steps before and the bad one; what there is to see.
    fn show_last_steps(&mut self, hex: u32, is_interrupted: &AtomicBool, lanes: LaneLevel) -> Result<String, Failure> {
        let neighbourhood = Neighbourhood::of(hex, &self.problem)?;
        let bad = neighbourhood.seen(&self.simulation);
        let last_good = self.simulation.step() - 1;
        let first_shown = last_good.saturating_sub(inversion::STEPS_SHOWN);
        let found = self.checkpoints.before(first_shown);
        match found.filter(|found| found.restore(&self.problem, &mut self.simulation).is_ok()) {
            Some(_) => {}
            None => match setup::simulation(&self.problem, lanes) {
                Ok(simulation) => self.simulation = simulation,
                // it could be made before, when there was no other in memory
                Err(error) => return Ok(format!("its last steps are not shown: {error}")),
            },
        }
        let from = self.simulation.step();
        self.console.say(&format!(
            "repeating the steps from {from} to {last_good}, to show the last of them (Ctrl-C leaves it)"
        ));
        let mut states = Vec::new();
        loop {
            let step = self.simulation.step();
            if step >= first_shown {
                states.push(neighbourhood.seen(&self.simulation));
            }
            if step >= last_good {
                break;
            }
            if is_interrupted.load(Ordering::Relaxed) || self.simulation.advance().is_err() {
                return Ok(
                    "its last steps were not repeated to the end; the last frame and the last row are older".to_owned()
                );
            }
        }
        states.push(bad);
        neighbourhood.write(&states, self.directory)?;
        Ok(format!(
            "the last frame and the last row show the step before; {}/results.pvd shows the element and its neighbours through \
             the last {} steps",
            files::TROUBLE,
            states.len()
        ))
    }

    /// Where the run was stopped, and how it goes on.
    fn where_it_goes_on(&self) -> String {
        format!(
            "at step {}, t = {:.6e} s; everything written so far can be read, and --resume goes on from here",
            self.simulation.step(),
            self.simulation.time()
        )
    }

    fn summary(
        &self,
        ending: &Ending,
        message: Option<String>,
        frames: usize,
        threads: usize,
        lanes: LaneLevel,
    ) -> Summary {
        let (problem, simulation) = (&self.problem, &self.simulation);
        let snapshot = Snapshot::new(&problem.mesh, simulation);
        let wall_seconds = self.progress.wall_seconds();
        let element_steps = simulation.step() as f64 * simulation.element_count() as f64;
        let outcomes: Vec<Outcome> = self.outcomes.iter().flatten().cloned().collect();
        Summary {
            version: env!("CARGO_PKG_VERSION"),
            title: problem.title.clone(),
            deck: problem.deck_path.display().to_string(),
            deck_hash: problem.deck_hash.clone(),
            mesh: MeshSummary::new(problem),
            status: match ending {
                Ending::Finished => "finished",
                Ending::Stopped => "stopped",
                Ending::Interrupted => "interrupted",
                Ending::Failed(_) => "failed",
            },
            message,
            time: simulation.time(),
            steps: simulation.step(),
            time_step: simulation.time_step(),
            initial_time_step: self.initial_time_step,
            time_step_source: match problem.model.settings.time_step {
                TimeStep::Element => "element",
                TimeStep::Power { .. } => "power",
            },
            element_time_step: number(simulation.element_time_step()),
            stable_time_step: number(simulation.extremes().stable_time_step),
            time_step_estimates: simulation.estimate_count(),
            wall_seconds,
            element_steps_per_second: element_steps / wall_seconds,
            grind_time_ns: number(1e9 * wall_seconds / element_steps),
            threads,
            lanes: lanes.name(),
            frames,
            energies: EnergySummary::new(simulation, problem),
            energy_error: simulation.energies().error(),
            momentum: simulation.momentum(),
            warnings: Vec::new(),
            deleted_elements: simulation.deleted_count(),
            quasi_static: problem.quasi_static.map(|chosen| QuasiStaticSummary {
                mass_factor: chosen.mass_factor,
                mass_damping: chosen.mass_damping,
                transits: chosen.transits,
                natural_frequency: chosen.natural_frequency.map(|(frequency, _)| frequency),
                largest_kinetic_over_internal: simulation.energies().kinetic_share,
                damping_over_external_work: damping_share(simulation.energies()),
            }),
            parts: self.approach.summary(problem, simulation),
            extremes: ExtremeSummary::new(&snapshot),
            probes: problem.probes.iter().map(|probe| (probe.name.clone(), probe.value(&snapshot))).collect(),
            expectations_met: outcomes.len() == self.outcomes.len() && outcomes.iter().all(|outcome| outcome.met),
            expectations: outcomes,
            state_hash: state_hash(simulation),
        }
    }
}

/// The share of the external work that damping has taken; 0 where no work was done.
fn damping_share(energies: &Energies) -> f64 {
    let work = energies.external_work().abs();
    if work > 0.0 { energies.damping / work } else { 0.0 }
}

/// Where the outputs of a run are before its first row.
fn beginning(problem: &Problem, simulation: &Simulation) -> Bookmark {
    let expectations = &problem.expectations;
    let is_pending = |index: &usize| matches!(expectations[*index].moment, Moment::Time(_));
    Bookmark {
        history_rows: 0,
        frame_times: Vec::new(),
        last_frame: None,
        record_bytes: 0,
        passed: [0; 2],
        last_row: None,
        pending: (0..expectations.len()).filter(is_pending).collect(),
        outcomes: vec![None; expectations.len()],
        jacobians: Vec::new(),
        approach: Approach::beginning(problem),
        initial_time_step: Bits::from(simulation.time_step()),
        wall_seconds: 0.0,
    }
}

/// What is going to be computed.
pub fn announcement(problem: &Problem, simulation: &Simulation, threads: usize, lanes: LaneLevel) -> String {
    let mut text = format!("Estar {}", env!("CARGO_PKG_VERSION"));
    if !problem.title.is_empty() {
        let _ = write!(text, ": {}", one_line(&problem.title));
    }
    let time_step = simulation.time_step();
    let _ = write!(
        text,
        "\n  mesh       {} ({}): {} nodes, {}",
        problem.mesh_path.display(),
        problem.mesh_format,
        count(problem.mesh.node_count() as f64),
        estar_deck::format::elements(&problem.mesh, |number| count(number as f64))
    );
    if let Some(merged) = &problem.merged {
        let _ = write!(text, "\n  merge      {merged}");
    }
    for (description, part) in problem.parts.iter().zip(&problem.model.parts) {
        let _ = write!(
            text,
            "\n  part       {}: {} elements of {}, {}, {:.6e} kg",
            description.group,
            count(description.element_count as f64),
            description.material,
            estar_deck::model::element_name(part.element),
            description.mass
        );
    }
    if let Some(chosen) = &problem.quasi_static {
        let _ = write!(text, "\n  process    {}", chosen.told());
    }
    let added: f64 = simulation.added_mass().iter().sum();
    if added > 0.0 {
        let _ = write!(text, "\n  scaling    {added:.6e} kg added by mass scaling");
    }
    let _ = write!(
        text,
        "\n  mass       {:.6e} kg\n  time       {:.6e} s, first step {:.4e} s, about {} steps if it stays so",
        problem.parts.iter().map(|part| part.mass).sum::<f64>(),
        simulation.end_time(),
        time_step,
        count((simulation.end_time() / time_step).ceil())
    );
    if let TimeStep::Power { interval } = problem.model.settings.time_step {
        let gain = 100.0 * (simulation.extremes().stable_time_step / simulation.element_time_step() - 1.0);
        let _ = write!(
            text,
            "\n  time step  of the assembled mesh, estimated every {} steps: {gain:.1} % above the bound of the elements",
            count(interval as f64)
        );
    }
    let cores = std::thread::available_parallelism().map_or(threads, usize::from);
    let sharing = if threads > cores { format!(" (on {cores} cores, which is no faster)") } else { String::new() };
    let _ = write!(text, "\n  machine    {threads} threads{sharing}, {} lanes of {}", lanes.lanes(), lanes.name());
    text
}

/// What came of it.
fn conclusion(summary: &Summary, probes: &[Probe], directory: &Path) -> String {
    let energies = &summary.energies;
    let mut text = format!(
        "{} at t = {:.6e} s after {} steps in {}{}\n",
        summary.status,
        summary.time,
        count(summary.steps as f64),
        duration(summary.wall_seconds),
        summary.grind_time_ns.map_or(String::new(), |grind| {
            format!(": {}element steps/s, {grind:.1} ns per element step", prefixed(summary.element_steps_per_second))
        })
    );
    let rows = [
        ("kinetic energy", energies.kinetic_energy),
        ("internal energy", energies.internal_energy),
        ("plastic dissipation", energies.plastic_dissipation),
        ("of it as heat", energies.heat),
        ("deleted elements", energies.deleted_energy),
        ("bulk viscosity", energies.viscous_energy),
        ("hourglass control", energies.hourglass_energy),
        ("external work", energies.external_work),
        ("contact", energies.contact_energy),
        ("of it by friction", energies.friction_energy),
        ("damping", energies.damping_energy),
        ("motion of added mass", energies.mass_scaling_energy),
    ];
    for (name, value) in rows.iter().filter(|(_, value)| *value != 0.0) {
        let _ = writeln!(text, "  {name:<20} {value:>14.6e} J");
    }
    match rows.iter().filter(|(_, value)| *value == 0.0).count() {
        0 => {}
        1 => text.push_str("  1 other row of the energy ledger is 0\n"),
        count => {
            let _ = writeln!(text, "  {count} other rows of the energy ledger are 0");
        }
    }
    let _ = writeln!(text, "  {:<20} {:>14.4} %", "energy error", 100.0 * summary.energy_error);
    if let Some(quasi_static) = &summary.quasi_static {
        let share = 100.0 * quasi_static.largest_kinetic_over_internal;
        let _ = writeln!(text, "  {:<20} {share:>14.4} % at most", "kinetic / internal");
        let share = 100.0 * quasi_static.damping_over_external_work;
        let _ = writeln!(text, "  {:<20} {share:>14.4} %", "damping / work");
    }
    for (name, value) in &summary.probes {
        let dimension = probes.iter().find(|probe| probe.name == *name).map(|probe| probe.dimension);
        let unit = dimension.filter(|dimension| *dimension != Dimension::NUMBER).map(Dimension::si_unit);
        let line = format!("  {name:<20} {value:>14.6e} {}", unit.unwrap_or_default());
        let _ = writeln!(text, "{}", line.trim_end());
    }
    let _ = writeln!(
        text,
        "  largest plastic strain {:.4}, {}\n  state {}",
        summary.extremes.max_equivalent_plastic_strain,
        match summary.extremes.min_jacobian {
            Some(jacobian) => format!("smallest Jacobian {jacobian:.4}"),
            None => "no element is left".to_owned(),
        },
        summary.state_hash
    );
    let _ = write!(
        text,
        "  {} ({} frames, {})",
        directory.join("results.pvd").display(),
        summary.frames,
        bytes(size_of_directory(directory))
    );
    text
}

/// Bytes of the frames.
fn size_of_directory(directory: &Path) -> f64 {
    let entries = std::fs::read_dir(directory.join("fields")).into_iter().flatten().flatten();
    entries.filter_map(|entry| entry.metadata().ok()).map(|metadata| metadata.len() as f64).sum()
}
