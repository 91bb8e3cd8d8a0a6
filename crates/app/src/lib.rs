//! The `estar` command: decks, runs, checks, meshes. The only crate that prints, times and knows the deck.
//!
//! [`deck`] reads what a user wrote, [`setup`] makes a problem of it and of the mesh, [`run`] runs it.

pub mod bench;
pub mod check;
pub mod checkpoint;
pub mod cli;
pub mod console;
pub mod constraints;
pub mod curves;
pub mod deck;
pub mod diagnostics;
pub mod example;
pub mod expectations;
pub mod failure;
pub mod fields;
pub mod format;
pub mod frames;
pub mod history;
pub mod inversion;
pub mod judgement;
pub mod lock;
pub mod memory;
pub mod mesh_command;
pub mod output;
pub mod plot;
pub mod plot_command;
pub mod point;
pub mod probes;
pub mod progress;
pub mod quasi_static;
pub mod run;
pub mod series;
pub mod setup;
pub mod sheets;
pub mod shipped;
pub mod signals;
pub mod snapshot;
pub mod summary;
pub mod table;
pub mod tools;
pub mod trouble;
pub mod verify;
pub mod view;
