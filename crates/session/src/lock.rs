//! A directory belongs to one run at a time.

use crate::error::SessionError;
use crate::files::LOCK;
use estar_io::{open_or_create, open_ordinary};
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::path::Path;
use std::process;

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
    pub fn acquire(directory: &Path) -> Result<Self, SessionError> {
        let path = directory.join(LOCK);
        let opened = open_or_create(&path, OpenOptions::new().read(true).write(true));
        let mut file = opened.map_err(SessionError::writing(&path))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut owner = String::new();
                // who has it is told if it can be read
                let _ = file.take(200).read_to_string(&mut owner);
                let owner = owner.lines().next().map(str::trim).filter(|owner| !owner.is_empty());
                let owner = owner.unwrap_or("another run");
                return Err(SessionError::Taken { directory: directory.to_owned(), owner: owner.to_owned() });
            }
            // a file system that cannot lock is no reason not to run
            Err(TryLockError::Error(error)) if error.kind() == io::ErrorKind::Unsupported => {}
            Err(TryLockError::Error(error)) => return Err(SessionError::writing(&path)(error)),
        }
        let on_host = host().map_or(String::new(), |name| format!(" on {name}"));
        let mut write = || {
            file.set_len(0)?;
            file.rewind()?;
            let started = started(process::id()).map_or(String::new(), |ticks| format!("started {ticks}\n"));
            // at once, for those who read it meanwhile
            file.write_all(format!("process {}{on_host}\n{started}", process::id()).as_bytes())
        };
        write().map_err(SessionError::writing(&path))?;
        Ok(Self { _file: file })
    }
}

/// Whether the process lives that took a directory last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holder {
    /// It lives; in a directory that does not tell when its process started, another one of the same number may.
    Alive,
    /// It has ended, one way or another.
    Gone,
    /// It ran on another machine, or the system does not tell, or nobody ever took the directory.
    Unknown,
}

impl Holder {
    /// That of a directory. The lock is not touched: whoever wants it gets it.
    pub fn of(directory: &Path) -> Self {
        let mut text = String::new();
        let read = open_ordinary(&directory.join(LOCK)).and_then(|file| file.take(200).read_to_string(&mut text));
        let mut lines = text.lines().map(str::trim);
        let owner = lines.next().and_then(|line| line.strip_prefix("process ")?.split_once(" on "));
        let (Ok(_), Some((process, on)), Some(here)) = (read, owner, host()) else { return Self::Unknown };
        let Ok(process) = process.parse::<u32>() else { return Self::Unknown };
        if on != here {
            return Self::Unknown;
        }
        let told = lines.find_map(|line| line.strip_prefix("started ")?.parse::<u64>().ok());
        match (told, started(process)) {
            // the number is another process's by now, as after a restart of the machine
            (Some(told), Some(now)) if told != now => Self::Gone,
            _ if Path::new(&format!("/proc/{process}")).exists() => Self::Alive,
            _ => Self::Gone,
        }
    }
}

/// When a process started, in ticks since the machine did, where the system tells it in a file.
fn started(process: u32) -> Option<u64> {
    let text = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // the second field is the program's name in brackets, which may have any sign in it; this is the 22nd
    let (_, after_name) = text.rsplit_once(')')?;
    after_name.split_whitespace().nth(22 - 3)?.parse().ok()
}

/// The name of this machine, where the system tells it in a file.
fn host() -> Option<String> {
    let name = std::fs::read_to_string("/proc/sys/kernel/hostname").ok()?;
    Some(name.trim().to_owned()).filter(|name| !name.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_directory_has_one_owner_who_is_named() {
        let directory = tempfile::tempdir().unwrap();
        let first = Lock::acquire(directory.path()).unwrap();
        let told = Lock::acquire(directory.path()).unwrap_err().to_string();
        assert!(told.contains(&format!("process {}", process::id())), "{told}");
        drop(first);
        Lock::acquire(directory.path()).unwrap();
    }

    #[test]
    fn a_process_that_took_a_directory_is_known_to_live_or_not() {
        let directory = tempfile::tempdir().unwrap();
        assert_eq!(Holder::of(directory.path()), Holder::Unknown);
        let _lock = Lock::acquire(directory.path()).unwrap();
        let Some(here) = host() else { return };
        assert_eq!(Holder::of(directory.path()), Holder::Alive);
        let own = process::id();
        let since = started(own).unwrap();
        // numbers of processes do not go so far
        for (owner, holder) in [
            (format!("process 4294967295 on {here}"), Holder::Gone),
            (format!("process 4294967295 on {here}-2"), Holder::Unknown),
            (format!("process {own} on {here}\n"), Holder::Alive),
            (format!("process {own} on {here}\nstarted {since}\n"), Holder::Alive),
            (format!("process {own} on {here}\nstarted {}\n", since + 1), Holder::Gone),
            ("process of another kind".to_owned(), Holder::Unknown),
        ] {
            std::fs::write(directory.path().join(LOCK), owner).unwrap();
            assert_eq!(Holder::of(directory.path()), holder);
        }
    }
}
