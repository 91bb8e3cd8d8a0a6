//! Sessions of the Estar solver: from a deck and its mesh to the results of a run. Nothing here prints.

pub mod bits;
pub mod bodies;
pub mod checkpoint;
pub mod conformity;
pub mod constraints;
pub mod directory;
pub mod error;
pub mod expectations;
pub mod files;
pub mod frames;
pub mod history;
pub mod inversion;
pub mod judgement;
pub mod lock;
pub mod output;
pub mod passing;
pub mod plausibility;
pub mod probes;
pub mod problem;
pub mod problem_memory;
pub mod quasi_static;
pub mod setup;
pub mod snapshot;
pub mod summary;
pub mod tools;
pub mod trouble;
