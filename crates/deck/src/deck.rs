//! The deck of a simulation or of a material point: read with every fault found in one go.

use crate::decoder::{Decoder, Mention, ReadKeys};
use crate::diagnostics::{Diagnostic, Sources};
use crate::macros::deck_table;
use crate::model::{
    FixTable, GravityTable, InitialVelocityTable, MeshTable, PartTable, PrescribedTable, PressureTable, RigidWallTable,
    TractionTable,
};
use crate::names::Materials;
use crate::point_problem::PointProblem;
use crate::probe::{ExpectTable, ProbeTable};
use crate::settings::{OutputTable, TimeTable};
use crate::tree::{self, Node};
use estar_material::MaterialModel;
use estar_solver::Interpolation;
use std::path::Path;

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

impl Deck {
    /// How a curve runs between its points, where `chosen` is what the deck says of it.
    pub fn interpolation(&self, chosen: Option<Interpolation>) -> Interpolation {
        chosen.unwrap_or(match self.time.quasi_static {
            // a process that begins and ends at rest, and does not stop on its way
            Some(_) => Interpolation::Monotone,
            None => Interpolation::Linear,
        })
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
    read_as(path, text, overrides, Kind::Simulation, |deck, _, _| Some(deck))
}

/// Reads the text of the deck of a material point at `path`, with the overrides of the command line.
pub fn read_point(path: &Path, text: &str, overrides: &[String]) -> Reading<PointProblem> {
    read_as(path, text, overrides, Kind::Point, PointProblem::new)
}

/// What a deck is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Simulation,
    Point,
}

impl Kind {
    fn words(self) -> &'static str {
        match self {
            Self::Simulation => "simulation",
            Self::Point => "material point",
        }
    }

    fn command(self) -> &'static str {
        match self {
            Self::Simulation => "estar run",
            Self::Point => "estar point",
        }
    }

    /// The keys that only decks of this kind have and all of them need.
    fn marks(self) -> &'static [&'static str] {
        match self {
            Self::Simulation => &["mesh", "part", "time"],
            Self::Point => &["path"],
        }
    }

    /// The other kind, if the deck is plainly of that one.
    fn other_of(self, tree: &Node) -> Option<Self> {
        let other = match self {
            Self::Simulation => Self::Point,
            Self::Point => Self::Simulation,
        };
        let has = |key: &&str| tree.value.entry(key).is_some();
        (other.marks().iter().all(&has) && !self.marks().iter().any(has)).then_some(other)
    }
}

/// Reads a deck whose keys are those of `D`; `finish` makes of it, and of its tree, what is wanted.
fn read_as<D: ReadKeys, P>(
    path: &Path,
    text: &str,
    overrides: &[String],
    kind: Kind,
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
    // what a broken grammar leaves of the deck would only breed false alarms, and so would a deck of the other kind
    let mut deck = None;
    if is_whole && let Some(other) = kind.other_of(&tree) {
        let message = format!("this is the deck of a {}", other.words());
        let place = tree.span.beginning();
        let help = format!("run it by `{} {}`", other.command(), path.display());
        decoder.report(Diagnostic::error(message).at(place, format!("not of a {}", kind.words())).help(help));
    } else if is_whole {
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
    use crate::diagnostics::{listed, nearest};
    for (index, definition) in decoder.definitions.iter().enumerate() {
        let same = |other: &&Mention| other.of == definition.of && other.name.value == definition.name.value;
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
