//! Reading the deck's text.

use crate::memory;
use estar_io::read_ordinary;
use std::path::{Path, PathBuf};

/// No deck that a person or a script writes is larger.
const MOST_BYTES: u64 = 64 << 20;

/// A text file that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum TextError {
    /// It cannot be read.
    #[error("{}: {error}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        error: std::io::Error,
    },
    /// It is larger than any text of its kind.
    #[error("{}: larger than {} MiB", path.display(), MOST_BYTES >> 20)]
    TooLarge {
        /// The file.
        path: PathBuf,
    },
    /// It is a mesh.
    #[error(
        "{}: this is a mesh; `estar mesh info` tells what is in it, and a deck names it: `file` in [mesh] (`estar example` writes one)",
        path.display()
    )]
    Mesh {
        /// The file.
        path: PathBuf,
    },
    /// What is made of it does not fit into memory.
    #[error("{shortage}; {}", memory::HELP)]
    NoMemory {
        /// How much is needed, and left.
        shortage: String,
    },
    /// It is not UTF-8.
    #[error("{}:{line}: not UTF-8 text: byte {byte:#04x} at column {column}; save the file as UTF-8", path.display())]
    NotUtf8 {
        /// The file.
        path: PathBuf,
        /// Line of the first wrong byte.
        line: usize,
        /// Its column.
        column: usize,
        /// The byte.
        byte: u8,
    },
}

/// The text of a file, without a byte order mark.
///
/// # Errors
/// The file cannot be read, is too large or is not UTF-8.
pub fn read_text(path: &Path) -> Result<String, TextError> {
    let unreadable = |error| TextError::Unreadable { path: path.to_owned(), error };
    if let Some(shortage) = memory::shortage_of_text(path) {
        return Err(TextError::NoMemory { shortage });
    }
    let bytes = read_ordinary(path, MOST_BYTES).map_err(|error| match error.kind() {
        std::io::ErrorKind::InvalidData => TextError::TooLarge { path: path.to_owned() },
        _ => unreadable(error),
    })?;
    // no TOML and no table begins so
    const OF_MESHES: [&[u8]; 5] = [b"$MeshFormat", b"*", b"# vtk DataFile", b"<?xml", b"<VTKFile"];
    if OF_MESHES.iter().any(|beginning| bytes.starts_with(beginning)) {
        return Err(TextError::Mesh { path: path.to_owned() });
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        let good = error.utf8_error().valid_up_to();
        let bytes = error.as_bytes();
        let line_start = bytes[..good].iter().rposition(|byte| *byte == b'\n').map_or(0, |newline| newline + 1);
        let column = String::from_utf8_lossy(&bytes[line_start..good]).chars().count() + 1;
        let line = bytes[..good].iter().filter(|byte| **byte == b'\n').count() + 1;
        TextError::NotUtf8 { path: path.to_owned(), line, column, byte: bytes.get(good).copied().unwrap_or_default() }
    })?;
    Ok(text.strip_prefix('\u{feff}').map_or(text.clone(), str::to_owned))
}
