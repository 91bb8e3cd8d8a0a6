//! A directory belongs to one run at a time.

use crate::failure::Failure;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::path::Path;

/// The file that is locked. It stays when the run ends; the lock on it goes with the process, however that ends.
pub const LOCK_FILE: &str = "estar.lock";

/// The right to write into a directory, until dropped.
#[derive(Debug)]
pub struct Lock {
    _file: File,
}

impl Lock {
    /// Takes a directory.
    ///
    /// # Errors
    /// Another run has it, whose process is named; or the file cannot be written.
    pub fn acquire(directory: &Path) -> Result<Self, Failure> {
        let path = directory.join(LOCK_FILE);
        let open = || OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path);
        let mut file = open().map_err(Failure::writing(&path))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut owner = String::new();
                // who has it is told if it can be read
                let _ = file.take(200).read_to_string(&mut owner);
                let owner = if owner.trim().is_empty() { "another run" } else { owner.trim() };
                return Err(Failure::File(format!(
                    "error: {} is written to by {owner}\nhelp: take another directory with --output, or wait for that run",
                    directory.display()
                )));
            }
            // a file system that cannot lock is no reason not to run
            Err(TryLockError::Error(error)) if error.kind() == io::ErrorKind::Unsupported => {}
            Err(TryLockError::Error(error)) => return Err(Failure::writing(&path)(error)),
        }
        let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
        let on_host = if host.trim().is_empty() { String::new() } else { format!(" on {}", host.trim()) };
        let mut write = || {
            file.set_len(0)?;
            file.rewind()?;
            writeln!(file, "process {}{on_host}", std::process::id())
        };
        write().map_err(Failure::writing(&path))?;
        Ok(Self { _file: file })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_directory_has_one_owner_who_is_named() {
        let directory = tempfile::tempdir().unwrap();
        let first = Lock::acquire(directory.path()).unwrap();
        let told = Lock::acquire(directory.path()).unwrap_err().to_string();
        assert!(told.contains(&format!("process {}", std::process::id())), "{told}");
        drop(first);
        Lock::acquire(directory.path()).unwrap();
    }
}
