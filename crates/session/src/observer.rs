//! Who is told of a session while it runs.

use crate::error::SessionError;
use crate::problem::Problem;
use crate::progress::Progress;
use estar_deck::diagnostics::Findings;
use estar_solver::{LaneLevel, Simulation};
use std::path::Path;

/// Who is told of a session while it runs. What it does never changes what comes of the run.
pub trait Observer {
    /// Deck and mesh are read, checked and ordered; the state at time 0 is next.
    fn loaded(&mut self, _problem: &Problem) {}

    /// What was found in deck and mesh that does not stop the run.
    fn findings(&mut self, _findings: &Findings) {}

    /// The directory of the results is this run's own; nothing of the run is written yet.
    ///
    /// # Errors
    /// The observer has a file in the directory, which cannot be written.
    fn begins(&mut self, _beginning: &Beginning<'_>) -> Result<(), SessionError> {
        Ok(())
    }

    /// How far the run is, a few times a second.
    fn progress(&mut self, _progress: &Progress) {}

    /// What is worth a line of a log.
    fn notes(&mut self, _note: &str) {}

    /// What is to be doubted, with its first word `warning`.
    fn warns(&mut self, _warning: &str) {}

    /// An element has turned inside out: the last good steps are repeated, to show them.
    fn repeats(&mut self, _from: u64, _to: u64) {}

    /// The last step has been made.
    fn ends(&mut self) {}

    /// Whether the run is to end at the next step. It is asked between steps.
    fn is_interrupted(&self) -> bool {
        false
    }
}

/// Nobody is told.
impl Observer for () {}

/// What is going to be computed.
#[derive(Clone, Copy)]
pub struct Beginning<'a> {
    /// The directory of the results.
    pub directory: &'a Path,
    /// The problem.
    pub problem: &'a Problem,
    /// Its state at the first step.
    pub simulation: &'a Simulation,
    /// Vector instructions.
    pub lanes: LaneLevel,
    /// Where it goes on, unless it begins at time 0.
    pub resumed: Option<&'a Resumed>,
}

/// From where a run goes on.
#[derive(Clone, Debug)]
pub struct Resumed {
    /// File name of the checkpoint.
    pub checkpoint: String,
    /// Its step.
    pub step: u64,
    /// Why newer checkpoints cannot be taken up.
    pub refusals: Vec<String>,
    /// Frames of the run that are not there any more.
    pub removed_frames: usize,
}
