//! Why results cannot be shown.

use estar_deck::memory;
use estar_io::FrameReadError;
use std::io;
use std::path::{Path, PathBuf};

/// Why results cannot be shown.
#[derive(Debug, thiserror::Error)]
pub enum PostError {
    /// A file cannot be read.
    #[error("{}: cannot be read: {error}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        error: io::Error,
    },
    /// A file cannot be written.
    #[error("{}: cannot be written: {error}", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// Why.
        error: io::Error,
    },
    /// A file is not what it is to be.
    #[error("{}: {what}", path.display())]
    Unusable {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// A frame cannot be read.
    #[error(transparent)]
    Frame(#[from] FrameReadError),
    /// A table does not fit into memory.
    #[error("{shortage}\nhelp: {}", memory::HELP)]
    NoMemory {
        /// How much is needed, and left.
        shortage: String,
    },
    /// A plot is larger than a picture can be.
    #[error("the plot is larger than a picture can be")]
    TooLarge,
}

impl PostError {
    /// A file that cannot be read.
    pub fn reading(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |error| Self::Unreadable { path, error }
    }

    /// A file that cannot be written.
    pub fn writing(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |error| Self::Unwritable { path, error }
    }
}
