//! The deck: what a user writes, read with every fault found in one go.
//!
//! A key is written once, in a table of [`model`], [`material`], [`settings`], [`probe`] or [`point`]: that text is its reader,
//! its type, its default and its documentation ([`document`]).

pub mod decoder;
pub mod document;
pub mod json_schema;
mod macros;
pub mod material;
pub mod model;
pub mod point;
pub mod probe;
pub mod schema;
pub mod settings;
pub mod source;
pub mod tree;
pub mod units;
pub mod values;

use crate::diagnostics::Sources;
use decoder::{Decoder, ReadKeys};
use estar_material::MaterialModel;
use macros::deck_table;
use model::{
    FixTable, GravityTable, InitialVelocityTable, MeshTable, PartTable, PrescribedTable, PressureTable, RigidWallTable,
    TractionTable,
};
use point::PointProblem;
use probe::{ExpectTable, ProbeTable};
use settings::{OutputTable, TimeTable};
use std::path::Path;
use tree::Node;
use values::Materials;

deck_table! {
    /// A simulation. Numbers are in SI units, or strings with a unit: `"117 GPa"`, `"32.4 mm"`, `"80 us"`,
    /// `"8930 kg/m^3"`, `"0.3 %"`.
    pub struct Deck {
        /// A title for people.
        title: String = default("''"),
        /// The mesh.
        mesh: MeshTable = required,
        /// The materials.
        material: Materials<MaterialModel> = required,
        /// Which elements are of which material.
        part: Vec<PartTable> = required,
        /// Velocities at time 0.
        initial_velocity: Vec<InitialVelocityTable> = default("[]"),
        /// Nodes that are held.
        fix: Vec<FixTable> = default("[]"),
        /// Nodes that are moved.
        prescribed: Vec<PrescribedTable> = default("[]"),
        /// Pressures.
        pressure: Vec<PressureTable> = default("[]"),
        /// Tractions.
        traction: Vec<TractionTable> = default("[]"),
        /// Gravity.
        gravity: Vec<GravityTable> = default("[]"),
        /// Rigid walls and other rigid tools.
        rigid_wall: Vec<RigidWallTable> = default("[]"),
        /// Time integration.
        time: TimeTable = required,
        /// Output.
        output: OutputTable = default("{}"),
        /// Numbers that are followed.
        probe: Vec<ProbeTable> = default("[]"),
        /// Values that probes must have.
        expect: Vec<ExpectTable> = default("[]"),
    }
}

/// A deck that has been read: its texts, what it says as far as it could be read, and what the decoder found out.
#[derive(Debug)]
pub struct Reading<D = Deck> {
    /// The texts.
    pub sources: Sources,
    /// The deck, unless it has faults.
    pub deck: Option<D>,
    /// The faults, and the names that must be looked up in the mesh.
    pub decoder: Decoder,
}

/// Reads the text of the deck at `path`, with the overrides of the command line.
pub fn read(path: &Path, text: &str, overrides: &[String]) -> Reading {
    read_as(path, text, overrides, |deck, _, _| Some(deck))
}

/// Reads the text of the deck of a material point at `path`, with the overrides of the command line.
pub fn read_point(path: &Path, text: &str, overrides: &[String]) -> Reading<PointProblem> {
    read_as(path, text, overrides, PointProblem::new)
}

/// Reads a deck whose keys are those of `D`; `finish` makes of it, and of its tree, what is wanted.
fn read_as<D: ReadKeys, P>(
    path: &Path,
    text: &str,
    overrides: &[String],
    finish: impl FnOnce(D, &Node, &mut Decoder) -> Option<P>,
) -> Reading<P> {
    let mut sources = Sources::default();
    let directory = path.parent().unwrap_or(Path::new(""));
    let mut decoder = Decoder::new(directory);
    let source = sources.add(path.display().to_string(), text);
    let mut tree = tree::parse(source, text, &mut decoder.diagnostics);
    let is_whole = !decoder.diagnostics.has_errors();
    for argument in overrides {
        tree::apply_override(&mut tree, argument, &mut sources, &mut decoder.diagnostics);
    }
    // what a broken grammar leaves of the deck would only breed false alarms
    let mut deck = None;
    if is_whole {
        let read = decoder.table(&tree);
        check_names(&mut decoder);
        deck = read.and_then(|read| finish(read, &tree, &mut decoder));
    }
    if decoder.diagnostics.has_errors() {
        deck = None;
    }
    Reading { sources, deck, decoder }
}

/// Every name that is used must be defined, and none twice.
fn check_names(decoder: &mut Decoder) {
    use crate::diagnostics::{Diagnostic, listed, nearest};
    for (index, definition) in decoder.definitions.iter().enumerate() {
        let same = |other: &&decoder::Mention| other.of == definition.of && other.name.value == definition.name.value;
        if let Some(first) = decoder.definitions[..index].iter().find(same) {
            let message = format!("two {}s are named `{}`", definition.of, definition.name.value);
            let diagnostic = Diagnostic::error(message).at(definition.name.span, "the second");
            decoder.diagnostics.push(diagnostic.at(first.name.span, "the first"));
        }
    }
    for mention in &decoder.mentions {
        let names = || {
            let same_kind = decoder.definitions.iter().filter(|definition| definition.of == mention.of);
            same_kind.map(|definition| definition.name.value.as_str())
        };
        if names().any(|name| name == mention.name.value) {
            continue;
        }
        let label = match nearest(&mention.name.value, names()) {
            Some(name) => format!("did you mean \"{name}\"?"),
            None => "unknown".to_owned(),
        };
        let help = match listed(names()) {
            none if none.is_empty() => format!("the deck has no {}s", mention.of),
            names => format!("the {}s of the deck are {names}", mention.of),
        };
        let message = format!("there is no {} `{}`", mention.of, mention.name.value);
        decoder.diagnostics.push(Diagnostic::error(message).at(mention.name.span, label).help(help));
    }
}
