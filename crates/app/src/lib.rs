//! The `estar` command: the only crate that prints.
//!
//! `estar_deck` reads what a user wrote, `estar_session` runs it, `estar_post` shows what came of it. Here are the command line, the
//! console, and the commands beside runs: `check`, `point`, `verify`, `bench`, `mesh`, `example`.

pub mod bench;
mod check;
pub mod cli;
mod console;
mod example;
pub mod failure;
mod mesh_command;
mod plot_command;
pub mod point;
mod progress;
mod run;
mod run_words;
pub mod shipped;
mod signals;
pub mod verify;
mod view;
