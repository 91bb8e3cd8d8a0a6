//! What tells one version of a file from another.

use std::fs;
use std::io;
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

/// When a file was written last, and its length: what tells one version of it from another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stamp {
    written: SystemTime,
    length: u64,
}

impl Stamp {
    /// That of a file.
    ///
    /// # Errors
    /// What the system says.
    pub fn of(path: &Path) -> io::Result<Self> {
        let metadata = fs::metadata(path)?;
        Ok(Self { written: metadata.modified()?, length: metadata.len() })
    }

    /// Bytes of the file.
    pub fn length(self) -> u64 {
        self.length
    }

    /// When it was written last.
    pub fn written(self) -> SystemTime {
        self.written
    }

    /// A text that is another one for every version of the file.
    pub fn version(self) -> String {
        let since = self.written.duration_since(UNIX_EPOCH).unwrap_or_default();
        format!("{}-{}", since.as_nanos(), self.length)
    }
}
