//! The deck of the Estar solver: what a user writes, read with every fault found in one go. Nothing here starts a run.
//!
//! A key is written once, in a table of [`mod@deck`], [`model`], [`material`], [`settings`], [`probe`] or [`point`]: that text is its
//! reader, its type, its default and its documentation ([`document`]). [`diagnostics`] says what is wrong and where; [`fields`] and
//! [`history_column`] are the tables of what a run writes.

pub mod deck;
pub mod decoder;
pub mod diagnostics;
pub mod document;
pub mod fields;
pub mod format;
mod hardening;
pub mod history_column;
pub mod json_schema;
mod macros;
pub mod material;
mod material_plausibility;
pub mod memory;
pub mod model;
pub mod names;
pub mod point;
pub mod point_column;
pub mod point_path;
pub mod point_problem;
pub mod probe;
mod schema;
pub mod settings;
pub mod source;
mod synonyms;
mod tree;
pub mod units;
pub mod values;

pub use deck::{Deck, Reading, read, read_point};
