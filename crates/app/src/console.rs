//! What is printed, and kept in `estar.log`.

use crate::failure::Failure;
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, IsTerminal, Write};
use std::path::Path;

/// Prints a text and a line break to standard output.
///
/// # Errors
/// It cannot be written; but a reader that has gone away has read enough.
pub fn print(text: &str) -> Result<(), Failure> {
    match writeln!(std::io::stdout().lock(), "{}", text.trim_end()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::writing(Path::new("standard output"))(error))
        }
        _ => Ok(()),
    }
}

/// Prints a text to standard error, if that can be.
pub fn tell(text: &str) {
    let _ = write!(std::io::stderr().lock(), "{text}");
}

/// Prints to standard output unless it is to be quiet, and to the log in any case.
#[derive(Debug)]
pub struct Console {
    is_quiet: bool,
    log: Option<File>,
}

impl Console {
    /// A console without a log.
    pub fn new(is_quiet: bool) -> Self {
        Self { is_quiet, log: None }
    }

    /// Begins the log in a directory, or goes on with the one that is there.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn log_into(&mut self, directory: &Path, goes_on: bool) -> Result<(), Failure> {
        let path = directory.join("estar.log");
        let mut options = OpenOptions::new();
        let options = if goes_on { options.append(true) } else { options.write(true).truncate(true) };
        self.log = Some(options.create(true).open(&path).map_err(Failure::writing(&path))?);
        Ok(())
    }

    /// Whether nothing is to be printed.
    pub fn is_quiet(&self) -> bool {
        self.is_quiet
    }

    /// Prints a text and a line break.
    pub fn say(&mut self, text: &str) {
        if !self.is_quiet {
            // a reader that has gone away must not stop the run
            let _ = writeln!(std::io::stdout().lock(), "{text}");
        }
        self.note(text);
    }

    /// Writes a text and a line break to the log only.
    pub fn note(&mut self, text: &str) {
        // what is printed is not worth stopping a run for; its results are written with care elsewhere
        if let Some(Err(error)) = self.log.as_mut().map(|log| writeln!(log, "{text}")) {
            self.log = None;
            tell(&format!("warning: estar.log cannot be written: {error}; the run goes on without it\n"));
        }
    }
}

/// Whether messages on standard error may be coloured.
pub fn is_coloured() -> bool {
    std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
}
