//! Reading the deck's text.

use std::io::Read;
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
    let file = std::fs::File::open(path).map_err(unreadable)?;
    let mut bytes = Vec::new();
    file.take(MOST_BYTES + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(TextError::TooLarge { path: path.to_owned() });
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
