//! Why a session could not do what it was asked to.

use estar_deck::diagnostics::Findings;
use estar_deck::memory;
use estar_deck::source::TextError;
use estar_io::WriteError;
use estar_mesh::MeshError;
use estar_solver::{LaneLevel, ModelError};
use std::io;
use std::path::{Path, PathBuf};

/// Why a session could not do what it was asked to.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    /// The text of the deck cannot be had.
    #[error(transparent)]
    Deck(#[from] TextError),
    /// Deck or mesh have faults.
    #[error("{}", findings.render(false))]
    Faults {
        /// All that were found, with their places.
        findings: Findings,
        /// Whether the only fault is a file that cannot be read.
        is_unreadable_file: bool,
    },
    /// The run does not fit into memory.
    #[error("{shortage}\nhelp: {}", memory::HELP)]
    NoMemory {
        /// How much is needed, and left.
        shortage: String,
    },
    /// The solver refuses the model.
    #[error("{told}")]
    Model {
        /// What it says, by positions in the model.
        error: ModelError,
        /// The same in the numbers of the mesh file.
        told: String,
    },
    /// The time step is so small that the time would never reach the end.
    #[error("{told}")]
    Standstill {
        /// The step and the element that controls it.
        told: String,
    },
    /// The directory holds results, which nobody said to overwrite.
    #[error("{} holds results already", directory.display())]
    ResultsThere {
        /// The directory.
        directory: PathBuf,
    },
    /// What is to be the directory of the results is a file.
    #[error("{} is a file, not a directory", path.display())]
    NoDirectory {
        /// The file.
        path: PathBuf,
    },
    /// Another run writes to the directory.
    #[error("{} is written to by {owner}", directory.display())]
    Taken {
        /// The directory.
        directory: PathBuf,
        /// The process of that run.
        owner: String,
    },
    /// There is no checkpoint to go on from.
    #[error("{}", no_checkpoint(directory, refusals))]
    NoCheckpoint {
        /// The directory.
        directory: PathBuf,
        /// Why each that was found cannot be taken up.
        refusals: Vec<String>,
    },
    /// A file cannot be written.
    #[error("{}: cannot be written: {error}", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// Why.
        error: io::Error,
    },
    /// A frame cannot be written.
    #[error(transparent)]
    Frame(#[from] WriteError),
    /// A piece of the mesh is no mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// This machine has no such vector instructions.
    #[error("this machine has no {} instructions", .0.name())]
    NoLanes(LaneLevel),
    /// The threads cannot be started.
    #[error("cannot start the threads: {reason}")]
    NoThreads {
        /// Why.
        reason: String,
    },
    /// There is no thread to write frames by.
    #[error("no threads for the frames: {reason}")]
    NoFrameThreads {
        /// Why.
        reason: String,
    },
    /// The thread that writes the frames has ended without a result.
    #[error("the writer of the frames broke down")]
    FrameWriter,
    /// The step at which to stop lies before that of the newest checkpoint.
    #[error("step {stop}, at which to stop, lies before step {step}, from which this run would go on ({checkpoint})")]
    StopIsOver {
        /// The step at which to stop.
        stop: u64,
        /// The step of the checkpoint.
        step: u64,
        /// Its file name.
        checkpoint: String,
    },
    /// A run under way cannot write its results any more. What was written before can be read.
    #[error("{error}")]
    Lost {
        /// What cannot be written.
        error: Box<SessionError>,
        /// Whether there is a checkpoint to go on from.
        has_checkpoint: bool,
    },
}

fn no_checkpoint(directory: &Path, refusals: &[String]) -> String {
    let directory = directory.display();
    if refusals.is_empty() {
        return format!("{directory} has no checkpoint to resume from");
    }
    let reasons: String = refusals.iter().map(|refusal| format!("\n  {refusal}")).collect();
    format!("{directory} has no checkpoint that can be taken up{reasons}")
}

impl SessionError {
    /// A file that cannot be written.
    pub fn writing(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |error| Self::Unwritable { path, error }
    }
}
