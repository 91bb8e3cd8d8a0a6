//! How a command can end other than well, and the exit status that says so.

use estar_deck::diagnostics::Findings;
use estar_deck::source::TextError;
use estar_post::error::PostError;
use estar_session::SessionError;

/// Why a command did not do what it was asked to.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// Deck, mesh or command line are wrong.
    #[error("{0}")]
    Input(String),
    /// Deck or mesh are wrong, as findings with their places.
    #[error("{}", findings.render(false))]
    Findings {
        /// The findings.
        findings: Findings,
        /// Whether the only fault is a file that cannot be read.
        is_unreadable_file: bool,
    },
    /// The simulation failed.
    #[error("{0}")]
    Simulation(String),
    /// A file could not be read or written.
    #[error("{0}")]
    File(String),
    /// An expectation was not met.
    #[error("{0}")]
    Expectation(String),
    /// Ctrl-C.
    #[error("{0}")]
    Interrupted(String),
}

impl From<TextError> for Failure {
    fn from(error: TextError) -> Self {
        let message = format!("error: the deck cannot be read: {error}");
        if matches!(error, TextError::Unreadable { .. }) { Self::File(message) } else { Self::Input(message) }
    }
}

impl From<SessionError> for Failure {
    fn from(error: SessionError) -> Self {
        let help = match &error {
            SessionError::ResultsThere { .. } => {
                "\nhelp: take another directory with --output, overwrite these with --force, or go on from their newest checkpoint with \
                 --resume"
            }
            SessionError::Taken { .. } => "\nhelp: take another directory with --output, or wait for that run",
            SessionError::NoCheckpoint { refusals, .. } if refusals.is_empty() => {
                "\nhelp: start from the beginning: without --resume, and with --force if results of an earlier run are there"
            }
            SessionError::NoCheckpoint { .. } => {
                "\nhelp: resume with the deck, mesh, --set and program of the run, and with history.csv as it left it; a damaged frame \
                 may be removed; or start from the beginning with --force, which removes its results"
            }
            _ => "",
        };
        match error {
            SessionError::Deck(error) => error.into(),
            SessionError::Faults { findings, is_unreadable_file } => Self::Findings { findings, is_unreadable_file },
            SessionError::StopIsOver { stop, step, checkpoint } => Self::Input(format!(
                "error: --stop-at-step {stop} lies before step {step}, from which this run would go on ({checkpoint})\nhelp: a run goes \
                 on from its newest checkpoint; nothing has been changed"
            )),
            SessionError::Lost { error, has_checkpoint } => {
                let help = if has_checkpoint {
                    "everything written before can be read; when the cause is gone, --resume goes on from the newest checkpoint"
                } else {
                    "everything written before can be read; there was no checkpoint yet, from which --resume could go on"
                };
                Self::File(format!("{}\nhelp: {help}", Self::from(*error)))
            }
            SessionError::NoMemory { .. }
            | SessionError::NoLanes(_)
            | SessionError::NoThreads { .. }
            | SessionError::Model { .. }
            | SessionError::Standstill { .. }
            | SessionError::ResultsThere { .. } => Self::Input(format!("error: {error}{help}")),
            SessionError::NoDirectory { .. }
            | SessionError::Taken { .. }
            | SessionError::NoCheckpoint { .. }
            | SessionError::Unwritable { .. }
            | SessionError::Frame(_)
            | SessionError::Mesh(_)
            | SessionError::NoFrameThreads { .. }
            | SessionError::FrameWriter => Self::File(format!("error: {error}{help}")),
        }
    }
}

impl From<PostError> for Failure {
    fn from(error: PostError) -> Self {
        let message = format!("error: {error}");
        match error {
            PostError::NoMemory { .. } | PostError::TooLarge => Self::Input(message),
            PostError::Unreadable { .. }
            | PostError::Unwritable { .. }
            | PostError::Unusable { .. }
            | PostError::Frame(_) => Self::File(message),
        }
    }
}

impl Failure {
    /// The exit status of the program.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Input(_) | Self::Findings { is_unreadable_file: false, .. } => 2,
            Self::Simulation(_) => 3,
            Self::File(_) | Self::Findings { is_unreadable_file: true, .. } => 4,
            Self::Expectation(_) => 5,
            Self::Interrupted(_) => 130,
        }
    }

    /// A file that could not be read.
    pub fn reading(path: &std::path::Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |error| Self::File(format!("error: {}: cannot be read: {error}", path.display()))
    }

    /// A file that could not be written.
    pub fn writing(path: &std::path::Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |error| Self::File(format!("error: {}: cannot be written: {error}", path.display()))
    }
}
