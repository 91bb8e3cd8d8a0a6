//! `estar view` and `estar run --watch`: a page on this machine that shows a run while it runs, and afterwards.
//!
//! Both serve the same page from the same files. `results` reads what a run writes, `history` and `body` make curves and a
//! surface of it, `server` hands them out by `http`. Nothing is written, and nothing is asked of the loop that computes.

mod body;
mod history;
mod http;
mod results;
mod server;

use crate::console::{print, tell};
use crate::failure::Failure;
use crate::signals;
use clap::Args;
use server::Server;
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
    let is_interrupted = signals::interruption();
    let server = Server::start(directory)
        .map_err(|error| Failure::File(format!("error: the page cannot be served on this machine: {error}")))?;
    print(&format!("{} is shown at {} until Ctrl-C", directory.display(), server.address()))?;
    while !is_interrupted.load(Ordering::Relaxed) {
        std::thread::sleep(Duration::from_millis(100));
    }
    Ok(())
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
