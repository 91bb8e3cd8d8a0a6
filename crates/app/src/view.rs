//! `estar view` and `estar run --watch`: a page on this machine that shows a run while it runs, and afterwards.
//!
//! Both serve the same page from the same files.

use crate::console::{print, tell};
use crate::failure::Failure;
use crate::signals;
use clap::Args;
use estar_io::SERIES;
use estar_post::page::server::Server;
use estar_session::files::{HISTORY, LOCK, LOG, RECORDS, SUMMARY};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::Duration;

/// What the command line asks for.
#[derive(Debug, Args)]
pub struct ViewArguments {
    /// Directory of a run's results, finished or under way
    #[arg(value_name = "DIR")]
    directory: PathBuf,
}

/// Serves a directory until Ctrl-C.
///
/// # Errors
/// There is no such directory, or this machine has no address of its own to serve from.
pub fn view(arguments: &ViewArguments) -> Result<(), Failure> {
    let directory = &arguments.directory;
    if !directory.is_dir() {
        return Err(Failure::File(format!(
            "error: {} is no directory\nhelp: it is to be the directory that `estar run` writes to",
            directory.display()
        )));
    }
    if let Some(failure) = one_above(directory) {
        return Err(failure);
    }
    let is_interrupted = signals::interruption();
    let server = Server::start(directory)
        .map_err(|error| Failure::File(format!("error: the page cannot be served on this machine: {error}")))?;
    print(&format!("{} is shown at {} until Ctrl-C", directory.display(), server.address()))?;
    while !is_interrupted.load(Ordering::Relaxed) {
        std::thread::sleep(Duration::from_millis(100));
    }
    Ok(())
}

/// What is wrong with a directory that has nothing of a run while one below it has, as that of a deck: nothing would ever come.
fn one_above(directory: &Path) -> Option<Failure> {
    const OF_A_RUN: [&str; 6] = [RECORDS, SUMMARY, HISTORY, SERIES, LOG, LOCK];
    const MOST_NAMED: usize = 5;
    if OF_A_RUN.iter().any(|name| directory.join(name).exists()) {
        return None;
    }
    let below = std::fs::read_dir(directory).ok()?.filter_map(|entry| Some(entry.ok()?.path()));
    let has_run = |path: &PathBuf| OF_A_RUN[..2].iter().any(|name| path.join(name).is_file());
    let mut runs: Vec<PathBuf> = below.filter(has_run).collect();
    runs.sort();
    let mut named: Vec<String> = runs.iter().take(MOST_NAMED).map(|run| run.display().to_string()).collect();
    if runs.len() > MOST_NAMED {
        named.push("others".to_owned());
    }
    (!runs.is_empty()).then(|| {
        Failure::Input(format!(
            "error: {} has no results of a run\nhelp: these have: {}",
            directory.display(),
            named.join(", ")
        ))
    })
}

/// The page of a run that this process computes. It never changes what comes of the run.
#[derive(Debug)]
pub struct Watch(Option<Server>);

impl Watch {
    /// Begins to serve the directory that the run writes to, and says where on standard error.
    pub fn start(directory: &Path) -> Self {
        match Server::start(directory) {
            Ok(server) => {
                tell(&format!("watch this run at {}\n", server.address()));
                Self(Some(server))
            }
            Err(error) => {
                tell(&format!(
                    "warning: the page cannot be served on this machine: {error}; the run goes on without it\n"
                ));
                Self(None)
            }
        }
    }

    /// Ends with the run. A page that is open is first told how it ended, which takes a second or two.
    pub fn end(self) {
        const AT_MOST: Duration = Duration::from_secs(3);
        if let Some(server) = self.0 {
            server.tell_end(AT_MOST);
        }
    }
}
