//! The `estar` command: decks, runs, checks, meshes. The only crate that prints, times and knows the deck.

pub mod deck;
pub mod diagnostics;
pub mod fields;
