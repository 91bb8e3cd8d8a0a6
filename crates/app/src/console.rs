//! What is printed, and kept in `estar.log`.
//!
//! All of it goes through [`visible`]: text of files and of command lines does not steer the terminal that shows it.

use crate::failure::Failure;
use estar_deck::diagnostics::{Findings, Rendered};
use estar_io::{create_ordinary, open_or_create, steers, visible};
use estar_session::SessionError;
use estar_session::files::LOG;
use serde::Serialize;
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, IsTerminal, Write};
use std::path::Path;

/// Prints a text and a line break to standard output.
///
/// # Errors
/// It cannot be written; but a reader that has gone away has read enough.
pub fn print(text: &str) -> Result<(), Failure> {
    write_line(&visible(text.trim_end()))
}

/// Prints a value as JSON. What would steer a terminal is in it by its number.
///
/// # Errors
/// As [`print()`].
pub fn print_json(value: &impl Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(value).map_err(|error| Failure::File(format!("error: {error}")))?;
    let mut shown = String::with_capacity(text.len());
    for character in text.chars() {
        if steers(character) && character != '\n' {
            // only strings have such characters, and they are of the basic plane
            shown.push_str(&format!("\\u{:04x}", u32::from(character)));
        } else {
            shown.push(character);
        }
    }
    write_line(&shown)
}

fn write_line(text: &str) -> Result<(), Failure> {
    match writeln!(std::io::stdout().lock(), "{text}") {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::writing(Path::new("standard output"))(error))
        }
        _ => Ok(()),
    }
}

/// Prints a text to standard error, if that can be.
pub fn tell(text: &str) {
    let _ = write!(std::io::stderr().lock(), "{}", visible(text));
}

/// Prints findings to standard error, coloured where it is a terminal, if that can be.
pub fn tell_findings(findings: &Findings) {
    tell_rendered(&rendered(findings));
}

/// Findings as they are told, coloured where standard error is a terminal.
pub fn rendered(findings: &Findings) -> Rendered {
    findings.render(is_coloured())
}

/// Prints what [`rendered`] gave to standard error, if that can be.
pub fn tell_rendered(findings: &Rendered) {
    let _ = write!(std::io::stderr().lock(), "{findings}");
}

/// Tells why a command did not do what it was asked to.
pub fn tell_failure(failure: &Failure) {
    match failure {
        Failure::Findings { findings, .. } => tell_findings(findings),
        other => tell(&format!("{}\n", other.to_string().trim_end())),
    }
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
    pub fn log_into(&mut self, directory: &Path, goes_on: bool) -> Result<(), SessionError> {
        let path = directory.join(LOG);
        let log = if goes_on { open_or_create(&path, OpenOptions::new().append(true)) } else { create_ordinary(&path) };
        self.log = Some(log.map_err(SessionError::writing(&path))?);
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
            let _ = writeln!(std::io::stdout().lock(), "{}", visible(text));
        }
        self.note(text);
    }

    /// Prints a warning to standard error, and writes it to the log.
    pub fn warn(&mut self, warning: &str) {
        tell(&format!("warning: {warning}\n"));
        self.note(&format!("warning: {warning}"));
    }

    /// Writes a text and a line break to the log only.
    pub fn note(&mut self, text: &str) {
        // what is printed is not worth stopping a run for; its results are written with care elsewhere
        if let Some(Err(error)) = self.log.as_mut().map(|log| writeln!(log, "{}", visible(text))) {
            self.log = None;
            tell(&format!("warning: estar.log cannot be written: {error}; the run goes on without it\n"));
        }
    }
}

/// Whether messages on standard error may be coloured.
fn is_coloured() -> bool {
    std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn a_log_that_is_full_is_given_up_and_nothing_else() {
        let full = OpenOptions::new().write(true).open("/dev/full").unwrap();
        let mut console = Console { is_quiet: true, log: Some(full) };
        console.note("a line");
        assert!(console.log.is_none());
        console.note("another");
    }
}
