//! Sessions of the Estar solver: from a deck and its mesh to the results of a run. Nothing here prints.
//!
//! [`Session::load`] reads and checks, [`Session::write_to`] gives it a directory, [`Session::advance`] makes a step and writes what
//! falls due, [`Session::finish`] writes the summary. An [`Observer`] is told on the way, and may end the run.

mod bits;
pub mod bodies;
mod checkpoint;
pub mod conformity;
mod constraints;
mod course;
mod directory;
mod error;
mod expectations;
pub mod files;
pub mod frames;
mod history;
mod inversion;
mod judgement;
mod lock;
mod machine;
mod observer;
mod output;
mod passing;
mod plausibility;
mod probes;
mod problem;
pub mod problem_memory;
mod progress;
mod quasi_static;
mod results;
mod session;
mod setup;
mod snapshot;
mod summary;
mod tools;
mod trouble;

pub use directory::default_directory;
pub use error::SessionError;
pub use expectations::Outcome;
pub use lock::Holder;
pub use machine::machine;
pub use observer::{Beginning, Observer, Resumed};
pub use output::output_plan;
pub use probes::Probe;
pub use problem::Problem;
pub use progress::Progress;
pub use session::{Destination, Ending, Finished, Session, Start};
pub use snapshot::Snapshot;
pub use summary::{MeshSummary, Summary};
