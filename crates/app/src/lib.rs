//! The `estar` command: decks, runs, checks, meshes. The only crate that prints, times and knows the deck.
//!
//! `estar_deck` reads what a user wrote, `estar_session` runs it, `estar_post` shows what came of it.

pub mod bench;
pub mod check;
pub mod cli;
pub mod console;
pub mod example;
pub mod failure;
pub mod mesh_command;
pub mod plot_command;
pub mod point;
pub mod progress;
pub mod run;
pub mod run_words;
pub mod shipped;
pub mod signals;
pub mod verify;
pub mod view;
