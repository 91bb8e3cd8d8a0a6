//! A run of a deck, from its first line to its summary.

use crate::checkpoint::{self, Bookmark, Identity};
use crate::course::Course;
use crate::directory::{clear_directory, clear_partial_files, make_directory};
use crate::error::SessionError;
use crate::history::History;
use crate::inversion::{self, Neighbourhood};
use crate::judgement;
use crate::lock::Lock;
use crate::observer::{Beginning, Observer, Resumed};
use crate::plausibility;
use crate::probes::Probe;
use crate::problem::Problem;
use crate::results::Results;
use crate::setup;
use crate::snapshot::Snapshot;
use crate::summary::{EnergySummary, ExtremeSummary, MeshSummary, QuasiStaticSummary, Summary, number, state_hash};
use crate::{files, trouble};
use estar_solver::model::TimeStep;
use estar_solver::{Energies, LaneLevel, Simulation, SimulationError};
use std::path::{Path, PathBuf};

/// A run of a deck. It is at time 0 when it is loaded, and writes nothing before it is given a directory.
pub struct Session {
    problem: Problem,
    simulation: Simulation,
    lanes: LaneLevel,
    course: Course,
    stop_at_step: Option<u64>,
    results: Option<Results>,
}

/// Where a session writes to.
#[derive(Clone, Debug)]
pub struct Destination {
    /// The directory.
    pub directory: PathBuf,
    /// What is done about results that are there.
    pub start: Start,
    /// Write a checkpoint at this step and stop there.
    pub stop_at_step: Option<u64>,
}

/// What is done about results that are in the directory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// They stay, and the session refuses.
    Fresh,
    /// They are removed.
    Overwriting,
    /// The session goes on from the newest checkpoint.
    Resuming,
}

/// How a run ended.
#[derive(Debug)]
pub enum Ending {
    /// It has reached its end.
    Finished,
    /// At the step at which it was to stop, with a checkpoint.
    Stopped,
    /// By its observer, with a checkpoint.
    Interrupted,
    /// It could not go on.
    Failed(SimulationError),
}

/// What came of a run. The directory stays its own as long as this lives.
#[derive(Debug)]
pub struct Finished {
    /// How it ended.
    pub ending: Ending,
    /// What is in `summary.json`.
    pub summary: Summary,
    /// What was followed.
    pub probes: Vec<Probe>,
    _lock: Option<Lock>,
}

impl Session {
    /// Reads the deck at `deck` with overrides of its keys, and its mesh, and computes the state at time 0.
    ///
    /// # Errors
    /// Every fault of deck and mesh; what the solver refuses; too little memory.
    pub fn load(
        deck: &Path,
        overrides: &[String],
        lanes: LaneLevel,
        observer: &mut dyn Observer,
    ) -> Result<Self, SessionError> {
        let mut problem = setup::load(deck, overrides)?;
        observer.loaded(&problem);
        let simulation = setup::simulation(&problem, lanes);
        let of_steps = simulation.as_ref().ok().and_then(plausibility::doubt_about_steps);
        problem.findings.diagnostics.extend(of_steps);
        observer.findings(&problem.findings);
        let simulation = simulation?;
        let course = Course::of(&Bookmark::beginning(&problem, &simulation), &problem, &simulation);
        Ok(Self { problem, simulation, lanes, course, stop_at_step: None, results: None })
    }

    /// What deck and mesh say.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// The present state.
    pub fn simulation(&self) -> &Simulation {
        &self.simulation
    }

    /// The present state, for questions that take its working memory. A step is made by [`Self::advance`].
    pub fn simulation_mut(&mut self) -> &mut Simulation {
        &mut self.simulation
    }

    /// The fields of the present state.
    pub fn fields(&self) -> Snapshot<'_> {
        Snapshot::new(&self.problem.mesh, &self.simulation)
    }

    /// Writes the results into a directory from now on, or goes on there from the newest checkpoint. Its place is before the first
    /// step: rows and expectations of steps that have been made are not taken over.
    ///
    /// # Errors
    /// The directory is another run's, holds results that are in the way or none to go on from, or cannot be written to.
    pub fn write_to(&mut self, destination: &Destination, observer: &mut dyn Observer) -> Result<(), SessionError> {
        let directory = destination.directory.as_path();
        let identity = Identity::of(&self.problem);
        make_directory(directory)?;
        let lock = Lock::acquire(directory)?;
        let resumed = match destination.start {
            Start::Resuming => Some(self.resume(destination, &identity)?),
            Start::Fresh | Start::Overwriting => {
                clear_directory(directory, destination.start == Start::Overwriting)?;
                None
            }
        };
        clear_partial_files(directory);
        let (problem, simulation) = (&self.problem, &self.simulation);
        let (resumed, bookmark) = resumed.unzip();
        observer.begins(&Beginning { directory, problem, simulation, lanes: self.lanes, resumed: resumed.as_ref() })?;
        let goes_on = bookmark.is_some();
        let bookmark = bookmark.unwrap_or_else(|| Bookmark::beginning(problem, simulation));
        self.results = Some(Results::start(directory, lock, identity, problem, &bookmark, goes_on)?);
        self.course = Course::of(&bookmark, problem, simulation);
        self.stop_at_step = destination.stop_at_step;
        if !goes_on {
            self.begin(observer)?;
        }
        Ok(())
    }

    /// Brings the simulation to the newest checkpoint that can be taken up.
    fn resume(&mut self, destination: &Destination, identity: &Identity) -> Result<(Resumed, Bookmark), SessionError> {
        let (directory, problem, simulation) = (&destination.directory, &self.problem, &mut self.simulation);
        let mut removed_frames = 0;
        let found = checkpoint::newest(directory, identity, |found| {
            History::check(directory, problem, found.bookmark.history_rows)?;
            let frames = estar_io::removed_frames(directory, found.bookmark.frame_times.len());
            removed_frames = frames.map_err(|error| error.to_string())?.len();
            let restored = found.restore(problem, simulation);
            if restored.is_err() {
                *simulation = setup::simulation(problem, self.lanes).map_err(|error| error.to_string())?;
            }
            restored
        })?;
        if let Some(stop) = destination.stop_at_step.filter(|stop| *stop < found.step) {
            return Err(SessionError::StopIsOver { stop, step: found.step, checkpoint: found.name });
        }
        let resumed = Resumed { checkpoint: found.name, step: found.step, refusals: found.refusals, removed_frames };
        Ok((resumed, found.bookmark))
    }

    /// Takes the first row and the first frame.
    fn begin(&mut self, observer: &mut dyn Observer) -> Result<(), SessionError> {
        self.write(true, true, observer)?;
        self.course.check_pending(&self.problem, &self.simulation);
        Ok(())
    }

    /// Makes a step, and writes what falls due; how the run ended, if it is over.
    ///
    /// # Errors
    /// Results cannot be written: then the session is over.
    pub fn advance(&mut self, observer: &mut dyn Observer) -> Result<Option<Ending>, SessionError> {
        self.step(observer).map_err(|error| self.lose(error, observer))
    }

    /// Makes steps until the run is over.
    ///
    /// # Errors
    /// As [`Self::advance`].
    pub fn advance_to_end(&mut self, observer: &mut dyn Observer) -> Result<Ending, SessionError> {
        loop {
            if let Some(ending) = self.advance(observer)? {
                return Ok(ending);
            }
        }
    }

    fn step(&mut self, observer: &mut dyn Observer) -> Result<Option<Ending>, SessionError> {
        if self.simulation.is_finished() {
            return Ok(Some(Ending::Finished));
        }
        if self.course.is_empty() {
            self.begin(observer)?;
        }
        let ending = if observer.is_interrupted() {
            Some(Ending::Interrupted)
        } else {
            self.stop_at_step.filter(|step| self.simulation.step() >= *step).map(|_| Ending::Stopped)
        };
        if ending.is_some() || self.results.as_ref().is_some_and(Results::checkpoint_is_due) {
            self.write_checkpoint(observer)?;
        }
        if ending.is_some() {
            return Ok(ending);
        }
        if let Err(error) = self.simulation.advance() {
            return Ok(Some(Ending::Failed(error)));
        }
        self.look_out(observer)?;
        let (time, step) = (self.simulation.time(), self.simulation.step());
        let row_is_due = self.course.history_schedule.is_due(time, step);
        let frame_is_due = self.course.frame_schedule.is_due(time, step);
        if row_is_due || frame_is_due {
            self.write(row_is_due, frame_is_due, observer)?;
        }
        self.course.check_pending(&self.problem, &self.simulation);
        if let Some(progress) = self.course.pace.due(&self.simulation) {
            observer.progress(&progress);
            if let Some(results) = &mut self.results {
                results.records.tell(&progress)?;
            }
        }
        Ok(None)
    }

    /// Writes a checkpoint of the present step, once everything that it refers to is on the disk.
    fn write_checkpoint(&mut self, observer: &mut dyn Observer) -> Result<(), SessionError> {
        let Some(results) = &mut self.results else { return Ok(()) };
        let mut bookmark = Bookmark::beginning(&self.problem, &self.simulation);
        results.mark(&mut bookmark)?;
        self.course.mark(&mut bookmark);
        let name = results.write_checkpoint(bookmark, &self.problem, &self.simulation)?;
        observer.notes(&format!("{name}: t = {:.6e} s", self.simulation.time()));
        Ok(())
    }

    /// Tells of elements that come close to inversion or are deleted. The approach is worth a checkpoint, unless the beginning
    /// is as near: if it ends badly the last steps are repeated from there.
    fn look_out(&mut self, observer: &mut dyn Observer) -> Result<(), SessionError> {
        if let Some(deletions) = self.course.approach.deletions(&self.problem, &self.simulation) {
            observer.notes(&deletions.told);
            deletions.warnings.iter().for_each(|warning| observer.warns(warning));
        }
        let warnings = self.course.approach.look(&self.problem, &self.simulation);
        warnings.iter().for_each(|warning| observer.warns(warning));
        if !warnings.is_empty() && self.results.as_ref().is_some_and(Results::has_checkpoint) {
            self.write_checkpoint(observer)?;
        }
        Ok(())
    }

    /// Takes a row and a frame of the present step, each once.
    fn write(&mut self, row: bool, frame: bool, observer: &mut dyn Observer) -> Result<(), SessionError> {
        let Self { problem, simulation, course, results, .. } = self;
        if row && course.is_new(simulation.step()) {
            let snapshot = Snapshot::new(&problem.mesh, simulation);
            let values: Vec<f64> = problem.probes.iter().map(|probe| probe.value(&snapshot)).collect();
            let min_jacobian = match results {
                Some(results) => results.history.write(&snapshot, &values)?,
                None => simulation.extremes().min_jacobian,
            };
            course.take_row(problem, simulation, &values, min_jacobian);
        }
        if frame {
            if let Some(results) = results {
                results.frames.write(simulation)?;
            }
            if let Some(warning) = course.passing.look(problem, simulation) {
                observer.warns(&warning);
            }
        }
        Ok(())
    }

    /// The disk is at fault: what is there stays, what can still be said is said.
    fn lose(&mut self, error: SessionError, observer: &mut dyn Observer) -> SessionError {
        observer.ends();
        let Some(results) = &mut self.results else { return error };
        let _ = results.records.write(&self.course.pace.now(&self.simulation));
        let error = Box::new(results.frames.finish().err().unwrap_or(error));
        SessionError::Lost { error, has_checkpoint: results.has_checkpoint() }
    }

    /// Writes what remains to be written, however the run ended; what came of it.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn finish(mut self, ending: Ending, observer: &mut dyn Observer) -> Result<Finished, SessionError> {
        observer.ends();
        if let Some(results) = &mut self.results {
            results.records.write(&self.course.pace.now(&self.simulation))?;
        }
        let message = match &ending {
            Ending::Finished => None,
            Ending::Stopped => Some(format!("stopped {}", self.where_it_goes_on())),
            Ending::Interrupted => Some(format!("interrupted {}", self.where_it_goes_on())),
            Ending::Failed(error) => Some(self.why_it_failed(error, observer)),
        };
        self.write(true, true, observer)?;
        let frames = self.results.as_mut().map_or(Ok(0), |results| results.frames.finish())?;
        if matches!(ending, Ending::Finished) {
            self.course.check_end(&self.problem, &self.simulation);
        }
        let mut summary = self.summary(&ending, message, frames);
        summary.warnings = judgement::warnings(&summary, &self.problem, self.simulation.energies().in_play);
        if let Some(results) = &self.results {
            summary.write(&results.directory)?;
        }
        let _lock = self.results.map(|results| results.lock);
        Ok(Finished { ending, summary, probes: self.problem.probes, _lock })
    }

    /// Where the run was stopped, and how it goes on.
    fn where_it_goes_on(&self) -> String {
        format!(
            "at step {}, t = {:.6e} s; everything written so far can be read, and --resume goes on from here",
            self.simulation.step(),
            self.simulation.time()
        )
    }

    /// Why the run failed, and where its last steps are shown.
    fn why_it_failed(&mut self, error: &SimulationError, observer: &mut dyn Observer) -> String {
        let told = trouble::of_simulation(error, &self.problem, &self.simulation, &self.course.jacobians);
        let shown = match error {
            SimulationError::ElementInverted { element, .. } | SimulationError::NotFinite { element, .. } => {
                // why the run failed must be told, also when this cannot be written
                let shown = self.show_last_steps(*element, observer);
                shown.unwrap_or_else(|error| format!("its last steps are not shown: error: {error}"))
            }
            _ => "the last frame and the last row show the state at this step".to_owned(),
        };
        format!("{}\n  {shown}\n{}", told.what, told.help)
    }

    /// Goes back to the last good step, which is repeated bit for bit from the newest checkpoint or from the beginning, and
    /// writes the series of `element` and its neighbours through the steps before and the bad one; what there is to see.
    fn show_last_steps(&mut self, element: u32, observer: &mut dyn Observer) -> Result<String, SessionError> {
        let Some(results) = &self.results else { return Ok("nothing was to be written of it".to_owned()) };
        let neighbourhood = Neighbourhood::of(element, &self.problem)?;
        let bad = neighbourhood.seen(&self.simulation);
        let last_good = self.simulation.step() - 1;
        let first_shown = last_good.saturating_sub(inversion::STEPS_SHOWN);
        let found = results.checkpoints.before(first_shown);
        if found.filter(|found| found.restore(&self.problem, &mut self.simulation).is_ok()).is_none() {
            // it could be made before, when there was no other in memory
            self.simulation = setup::simulation(&self.problem, self.lanes)?;
        }
        observer.repeats(self.simulation.step(), last_good);
        let mut states = Vec::new();
        loop {
            let step = self.simulation.step();
            if step >= first_shown {
                states.push(neighbourhood.seen(&self.simulation));
            }
            if step >= last_good {
                break;
            }
            if observer.is_interrupted() || self.simulation.advance().is_err() {
                return Ok(
                    "its last steps were not repeated to the end; the last frame and the last row are older".to_owned()
                );
            }
        }
        states.push(bad);
        neighbourhood.write(&states, &results.directory)?;
        Ok(format!(
            "the last frame and the last row show the step before; {}/results.pvd shows the element and its neighbours through \
             the last {} steps",
            files::TROUBLE,
            states.len()
        ))
    }

    fn summary(&self, ending: &Ending, message: Option<String>, frames: usize) -> Summary {
        let (problem, simulation) = (&self.problem, &self.simulation);
        let snapshot = self.fields();
        let wall_seconds = self.course.pace.wall_seconds();
        let element_steps = simulation.step() as f64 * simulation.element_count() as f64;
        let (expectations, expectations_met) = self.course.outcomes();
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
            initial_time_step: self.course.initial_time_step,
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
            threads: rayon::current_num_threads(),
            lanes: self.lanes.name(),
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
            parts: self.course.approach.summary(problem, simulation),
            extremes: ExtremeSummary::new(&snapshot),
            probes: problem.probes.iter().map(|probe| (probe.name.clone(), probe.value(&snapshot))).collect(),
            expectations_met,
            expectations,
            state_hash: state_hash(simulation),
        }
    }
}

/// The share of the external work that damping has taken; 0 where no work was done.
fn damping_share(energies: &Energies) -> f64 {
    let work = energies.external_work().abs();
    if work > 0.0 { energies.damping / work } else { 0.0 }
}
