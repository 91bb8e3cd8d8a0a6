//! The files that a run writes while it goes: history, frames, `run.jsonl` and checkpoints, in a directory of its own.

use crate::bits::Bits;
use crate::checkpoint::{Bookmark, Checkpoints, Identity};
use crate::error::SessionError;
use crate::frames::{EarlierFrames, FrameWriter};
use crate::history::History;
use crate::lock::Lock;
use crate::problem::Problem;
use crate::progress::Records;
use estar_deck::settings::CheckpointEvery;
use estar_solver::Simulation;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The files that a run writes while it goes.
#[derive(Debug)]
pub struct Results {
    /// Where they are.
    pub directory: PathBuf,
    /// `history.csv`.
    pub history: History,
    /// The frames.
    pub frames: FrameWriter,
    /// `run.jsonl`.
    pub records: Records,
    /// The checkpoints.
    pub checkpoints: Checkpoints,
    /// The right to write into the directory.
    pub lock: Lock,
    /// When the next checkpoint falls due.
    checkpoint_due: Option<Instant>,
    has_checkpoint: bool,
}

impl Results {
    /// Begins the files in a directory, or goes on with those that are there from where a bookmark was left.
    ///
    /// # Errors
    /// A file cannot be read or written.
    pub fn start(
        directory: &Path,
        lock: Lock,
        identity: Identity,
        problem: &Problem,
        bookmark: &Bookmark,
        goes_on: bool,
    ) -> Result<Self, SessionError> {
        let history = if goes_on {
            History::resume(directory, problem, bookmark.history_rows)?
        } else {
            History::create(directory, problem)?
        };
        let earlier = EarlierFrames {
            times: bookmark.frame_times.iter().map(|time| f64::from(*time)).collect(),
            last_step: bookmark.last_frame,
        };
        let frames =
            FrameWriter::start(directory, &problem.mesh, &problem.model.parts, &problem.output.fields, earlier)?;
        let mut results = Self {
            directory: directory.to_owned(),
            history,
            frames,
            records: Records::start(directory, bookmark.record_bytes)?,
            checkpoints: Checkpoints::of(directory, identity),
            lock,
            checkpoint_due: None,
            has_checkpoint: goes_on,
        };
        results.schedule_checkpoint(problem);
        Ok(results)
    }

    fn schedule_checkpoint(&mut self, problem: &Problem) {
        self.checkpoint_due = match problem.output.checkpoint {
            // a wait that no clock can tell is one for ever
            CheckpointEvery::Seconds(seconds) => {
                Duration::try_from_secs_f64(seconds).ok().and_then(|wait| Instant::now().checked_add(wait))
            }
            CheckpointEvery::Never => None,
        };
    }

    /// Whether it is time for a checkpoint.
    pub fn checkpoint_is_due(&self) -> bool {
        self.checkpoint_due.is_some_and(|due| Instant::now() >= due)
    }

    /// Whether there is a checkpoint to go on from.
    pub fn has_checkpoint(&self) -> bool {
        self.has_checkpoint
    }

    /// Puts everything on the disk that a checkpoint refers to, and writes into a bookmark where the files are.
    ///
    /// # Errors
    /// The system refuses.
    pub fn mark(&mut self, bookmark: &mut Bookmark) -> Result<(), SessionError> {
        self.history.sync()?;
        let EarlierFrames { times, last_step } = self.frames.sync()?;
        bookmark.frame_times = times.iter().map(|time| Bits::from(*time)).collect();
        bookmark.last_frame = *last_step;
        bookmark.history_rows = self.history.row_count();
        bookmark.record_bytes = self.records.bytes()?;
        Ok(())
    }

    /// Writes a checkpoint of the present step; its file's name.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write_checkpoint(
        &mut self,
        bookmark: Bookmark,
        problem: &Problem,
        simulation: &Simulation,
    ) -> Result<String, SessionError> {
        let name = self.checkpoints.write(bookmark, simulation)?;
        self.schedule_checkpoint(problem);
        self.has_checkpoint = true;
        Ok(name)
    }
}
