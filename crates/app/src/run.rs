//! `estar run`: a session that is told of on the console, and may be watched on a page.

use crate::console::{Console, tell, tell_findings};
use crate::failure::Failure;
use crate::progress::Bar;
use crate::run_words::{announcement, conclusion, expectation_table};
use crate::signals;
use crate::view::Watch;
use estar_deck::diagnostics::Findings;
use estar_deck::format::count;
use estar_session::{
    Beginning, Destination, Ending, Finished, Observer, Progress, Resumed, Session, SessionError, Start,
    default_directory, machine,
};
use estar_solver::LaneLevel;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

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

/// Runs a deck.
///
/// # Errors
/// See [`Failure`].
pub fn run(options: &RunOptions) -> Result<(), Failure> {
    let (pool, lanes) = machine(options.threads, options.lanes)?;
    pool.install(|| {
        let mut told = Told::new(options.is_quiet, options.watch);
        let mut session = Session::load(&options.deck, &options.overrides, lanes, &mut told)?;
        let destination = Destination {
            directory: options.output.clone().unwrap_or_else(|| default_directory(&options.deck)),
            start: match (options.resume, options.force) {
                (true, _) => Start::Resuming,
                (false, true) => Start::Overwriting,
                (false, false) => Start::Fresh,
            },
            stop_at_step: options.stop_at_step,
        };
        session.write_to(&destination, &mut told)?;
        let outcome = match session.advance_to_end(&mut told) {
            Ok(ending) => session.finish(ending, &mut told).map_err(Failure::from),
            Err(error) => {
                let failure = Failure::from(error);
                told.console.note(&failure.to_string());
                Err(failure)
            }
        };
        let outcome = outcome.and_then(|finished| told.conclude(&finished, &destination.directory));
        if let Some(watch) = told.watch {
            watch.end();
        }
        outcome
    })
}

/// What a user is told of a run.
struct Told {
    console: Console,
    /// Whether a page is to show the run.
    is_watched: bool,
    /// Once the run has begun.
    bar: Option<Bar>,
    watch: Option<Watch>,
    is_interrupted: Option<Arc<AtomicBool>>,
}

impl Told {
    fn new(is_quiet: bool, is_watched: bool) -> Self {
        Self { console: Console::new(is_quiet), is_watched, bar: None, watch: None, is_interrupted: None }
    }

    fn tell_resumed(&mut self, resumed: &Resumed) {
        for refusal in &resumed.refusals {
            self.console.warn(refusal);
        }
        if resumed.removed_frames > 0 {
            self.console.warn(&format!(
                "{} of the frames of this run are not there any more; results.pvd names the others",
                resumed.removed_frames
            ));
        }
        self.console.say(&format!("  resumes    from {}, step {}", resumed.checkpoint, count(resumed.step as f64)));
    }

    /// Says what came of the run.
    fn conclude(&mut self, finished: &Finished, directory: &Path) -> Result<(), Failure> {
        let Finished { ending, summary, probes, .. } = finished;
        self.console.say(&conclusion(summary, probes, directory));
        for warning in &summary.warnings {
            self.warns(warning);
        }
        let outcomes = &summary.expectations;
        if !outcomes.is_empty() {
            self.console.say(&expectation_table(outcomes));
        }
        if let Some(trouble) = &summary.message {
            self.console.note(trouble);
        }
        match (ending, &summary.message) {
            (Ending::Stopped, _) => Ok(()),
            (Ending::Interrupted, Some(trouble)) => Err(Failure::Interrupted(trouble.clone())),
            (Ending::Failed(_), Some(trouble)) => Err(Failure::Simulation(trouble.clone())),
            _ if !summary.expectations_met => {
                let missed = outcomes.iter().filter(|outcome| !outcome.met).count();
                let table =
                    if self.console.is_quiet() { format!("\n{}", expectation_table(outcomes)) } else { String::new() };
                Err(Failure::Expectation(format!("error: {missed} of {} expectations missed{table}", outcomes.len())))
            }
            _ => Ok(()),
        }
    }
}

impl Observer for Told {
    fn findings(&mut self, findings: &Findings) {
        tell_findings(findings);
    }

    fn begins(&mut self, beginning: &Beginning<'_>) -> Result<(), SessionError> {
        self.console.log_into(beginning.directory, beginning.resumed.is_some())?;
        let threads = rayon::current_num_threads();
        self.console.say(&announcement(beginning.problem, beginning.simulation, threads, beginning.lanes));
        if let Some(resumed) = beginning.resumed {
            self.tell_resumed(resumed);
        }
        self.watch = self.is_watched.then(|| Watch::start(beginning.directory));
        self.is_interrupted = Some(signals::interruption());
        self.bar = Some(Bar::start(&self.console));
        Ok(())
    }

    fn progress(&mut self, progress: &Progress) {
        if let Some(bar) = &mut self.bar {
            bar.show(progress, &mut self.console);
        }
    }

    fn notes(&mut self, note: &str) {
        self.console.note(note);
    }

    fn warns(&mut self, warning: &str) {
        let told = || tell(&format!("{warning}\n"));
        match &self.bar {
            Some(bar) => bar.beside(told),
            None => told(),
        }
        self.console.note(warning);
    }

    fn repeats(&mut self, from: u64, to: u64) {
        self.console
            .say(&format!("repeating the steps from {from} to {to}, to show the last of them (Ctrl-C leaves it)"));
    }

    fn ends(&mut self) {
        if let Some(bar) = &mut self.bar {
            bar.end();
        }
    }

    fn is_interrupted(&self) -> bool {
        self.is_interrupted.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed))
    }
}
