//! From the tree of the deck to values: a decoder that finds every fault in one go.

use crate::diagnostics::{Diagnostic, Diagnostics, Span, listed, nearest};
use crate::schema::{Choice, Schema, TableSchema};
use crate::synonyms;
use crate::tree::{Entry, Node, Table, Value};
use estar_material::ParameterError;
use std::path::{Path, PathBuf};

/// A type that can be read from a value of the deck.
pub trait FromDeck: Sized {
    /// What the value must be.
    fn schema() -> Schema;
    /// The value, or nothing after the faults have been reported.
    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self>;
}

/// A type that is read from keys of a table.
pub trait ReadKeys: Sized {
    /// The keys.
    fn keys() -> TableSchema;
    /// The value, or nothing after the faults have been reported.
    fn read(reader: &mut TableReader<'_, '_>) -> Option<Self>;
}

/// A value with the place where it was written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct At<T> {
    /// The value.
    pub value: T,
    /// Where it was written.
    pub span: Span,
}

impl<T: FromDeck> FromDeck for At<T> {
    fn schema() -> Schema {
        T::schema()
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        Some(Self { value: T::decode(node, decoder)?, span: node.span })
    }
}

/// What the decoder found out on its way, also where other parts of the deck are wrong.
#[derive(Debug)]
pub struct Decoder {
    /// The faults.
    pub diagnostics: Diagnostics,
    /// Every mention of a group of the mesh.
    pub groups: Vec<GroupMention>,
    /// Every mention of a name that the deck itself must define.
    pub mentions: Vec<Mention>,
    /// Every name that the deck defines.
    pub definitions: Vec<Mention>,
    /// The mesh file.
    pub mesh_file: Option<At<PathBuf>>,
    /// The text of every other file that the deck names, in the order in which they were read.
    pub texts: Vec<String>,
    /// Such files that could not be read.
    pub unreadable_count: usize,
    directory: PathBuf,
    path: Vec<String>,
}

/// A mention of a group of the mesh.
#[derive(Clone, Debug)]
pub struct GroupMention {
    /// Its name.
    pub name: At<String>,
    /// What of the group is wanted.
    pub wanted: estar_mesh::Wanted,
}

/// A mention or a definition of a name.
#[derive(Clone, Debug)]
pub struct Mention {
    /// What the name is of.
    pub of: Named,
    /// The name.
    pub name: At<String>,
}

/// What a deck gives names to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Named {
    /// Materials.
    Material,
    /// Probes.
    Probe,
    /// Rigid walls.
    Wall,
}

impl std::fmt::Display for Named {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(match self {
            Self::Material => "material",
            Self::Probe => "probe",
            Self::Wall => "rigid wall",
        })
    }
}

impl Decoder {
    /// A decoder for a deck in `directory`.
    pub fn new(directory: &Path) -> Self {
        Self {
            diagnostics: Diagnostics::default(),
            groups: Vec::new(),
            mentions: Vec::new(),
            definitions: Vec::new(),
            mesh_file: None,
            texts: Vec::new(),
            unreadable_count: 0,
            directory: directory.to_owned(),
            path: Vec::new(),
        }
    }

    /// A file that the deck names, from the deck's own directory.
    pub fn file(&self, name: &str) -> PathBuf {
        self.directory.join(name)
    }

    /// Reports a fault at a place.
    pub fn report(&mut self, diagnostic: Diagnostic) {
        self.diagnostics.push(diagnostic);
    }

    /// Where in the deck the decoder is, such as `material.copper.hardening`.
    pub fn place(&self) -> String {
        self.path.join(".")
    }

    /// Reports that a value is of the wrong type.
    pub fn wrong_type(&mut self, node: &Node, wanted: &str) {
        self.wrong_form(node, wanted, None);
    }

    /// Reports that a value is of the wrong type, with the right form if that is clear.
    pub fn wrong_form(&mut self, node: &Node, wanted: &str, help: Option<String>) {
        let message = format!("`{}` must be {wanted}, not {}", self.place(), node.value.kind());
        self.report(Diagnostic::error(message).at(node.span, format!("{wanted} is needed")).help_if(help));
    }

    /// The key that the decoder is at.
    pub fn key(&self) -> &str {
        self.path.last().map_or("", String::as_str)
    }

    /// A material parameter, or its fault reported at the key of the table `node` that it came from.
    pub fn parameter<T>(&mut self, node: &Node, result: Result<T, ParameterError>) -> Option<T> {
        result
            .map_err(|error| {
                let span = node.value.entry(error.parameter).map_or(node.span, |entry| entry.node.span);
                self.report(Diagnostic::error(format!("{}.{error}", self.place())).at(span, error.bound));
            })
            .ok()
    }

    /// Decodes the value of a key.
    pub fn value<T: FromDeck>(&mut self, key: &str, node: &Node) -> Option<T> {
        self.inside(key, |decoder| T::decode(node, decoder))
    }

    /// Does what belongs to a key; its faults are told as of that key.
    pub fn inside<T>(&mut self, key: &str, work: impl FnOnce(&mut Self) -> T) -> T {
        self.path.push(key.to_owned());
        let done = work(self);
        self.path.pop();
        done
    }

    /// Decodes the keys of a table; keys that nothing asked for are reported.
    pub fn table<T: ReadKeys>(&mut self, node: &Node) -> Option<T> {
        let Value::Table(table) = &node.value else {
            self.wrong_type(node, "a table");
            return None;
        };
        let mut reader = TableReader {
            table,
            span: node.span,
            decoder: self,
            known: Vec::new(),
            elsewhere: Vec::new(),
            is_excused: false,
        };
        let value = T::read(&mut reader);
        reader.finish();
        value
    }

    /// The meaning of one of the names.
    pub fn choice<T: Copy>(&mut self, node: &Node, choices: &[(Choice, T)]) -> Option<T> {
        let names = || choices.iter().map(|(choice, _)| choice.name);
        let Value::Text(text) = &node.value else {
            let one = match &node.value {
                Value::List(list) => list.first().and_then(|node| match &node.value {
                    Value::Text(text) if list.len() == 1 => Some(text),
                    _ => None,
                }),
                _ => None,
            };
            let help = one.map(|text| format!("one name, without brackets: \"{text}\""));
            self.wrong_form(node, &format!("one of the strings {}", listed(names())), help);
            return None;
        };
        if let Some((_, value)) = choices.iter().find(|(choice, _)| choice.name == text) {
            return Some(*value);
        }
        let instead = synonyms::of_name(&self.place(), text);
        let label = match nearest(text, names()).filter(|_| instead.is_none()) {
            Some(name) => format!("did you mean \"{name}\"?"),
            None => "unknown".to_owned(),
        };
        let help = instead.map_or_else(|| format!("the choices are {}", listed(names())), str::to_owned);
        let message = format!("`{}` cannot be \"{text}\"", self.place());
        self.report(Diagnostic::error(message).at(node.span, label).help(help));
        None
    }
}

/// Reads the keys of one table and remembers which ones it was asked for.
#[derive(Debug)]
pub struct TableReader<'a, 'd> {
    table: &'a Table,
    span: Span,
    decoder: &'d mut Decoder,
    known: Vec<&'static str>,
    elsewhere: Vec<(&'static str, String)>,
    is_excused: bool,
}

impl TableReader<'_, '_> {
    fn entry(&mut self, key: &'static str) -> Option<&Entry> {
        self.known.push(key);
        self.table.get(key)
    }

    /// The value of a key that must be there.
    pub fn required<T: FromDeck>(&mut self, key: &'static str) -> Option<T> {
        self.known.push(key);
        match self.table.get(key) {
            Some(entry) => self.decoder.value(key, &entry.node),
            None => {
                let place = match self.decoder.place() {
                    place if place.is_empty() => "the deck".to_owned(),
                    place => format!("`{place}`"),
                };
                let mut diagnostic = Diagnostic::error(format!("{place} lacks `{key}`"));
                diagnostic = diagnostic.at(self.span.beginning(), format!("`{key}` is missing here"));
                // a key with a slip of the pen is reported as unknown, too; the two messages belong together
                let slip = nearest(key, self.table.entries.iter().map(|entry| entry.key.as_str()));
                let help = match slip.filter(|slip| !self.known.contains(slip)) {
                    Some(slip) => format!("`{slip}` looks like it"),
                    None => example_of(key, &T::schema()),
                };
                self.decoder.report(diagnostic.help(help));
                None
            }
        }
    }

    /// The value of a key that need not be there; nothing at all if there was a fault.
    pub fn optional<T: FromDeck>(&mut self, key: &'static str) -> Option<Option<T>> {
        self.known.push(key);
        match self.table.get(key) {
            Some(entry) => self.decoder.value(key, &entry.node).map(Some),
            None => Some(None),
        }
    }

    /// The value of a key, or its default, written as in a deck.
    pub fn default<T: FromDeck>(&mut self, key: &'static str, default: &'static str) -> Option<T> {
        self.known.push(key);
        if let Some(entry) = self.table.get(key) {
            return self.decoder.value(key, &entry.node);
        }
        let text = format!("{key} = {default}");
        let source = crate::diagnostics::Sources::default().add("", "");
        let tree = super::tree::parse(source, &text, &mut self.decoder.diagnostics);
        let Value::Table(table) = &tree.value else { return None };
        // a default is nobody's text: it stands where the table stands
        let node = Node { span: self.span.beginning(), value: table.get(key)?.node.value.clone() };
        self.decoder.value(key, &node)
    }

    /// The value of the key that says which further keys there are.
    pub fn tag(&mut self, tag: &'static str, variants: &super::schema::Variants) -> Option<&'static str> {
        let choices: Vec<_> = variants.cases.iter().map(|(choice, _)| (*choice, choice.name)).collect();
        let chosen = match self.entry(tag).map(|entry| entry.node.clone()) {
            Some(node) => {
                self.decoder.path.push(tag.to_owned());
                let chosen = self.decoder.choice(&node, &choices);
                self.decoder.path.pop();
                chosen
            }
            None if variants.default.is_some() => variants.default,
            None => {
                let place = self.decoder.place();
                let choices = listed(choices.iter().map(|(choice, _)| choice.name));
                let diagnostic = Diagnostic::error(format!("`{place}` lacks `{tag}`"));
                let diagnostic = diagnostic.at(self.span.beginning(), format!("`{tag}` is missing here"));
                self.decoder.report(diagnostic.help(format!("the choices are {choices}")));
                None
            }
        };
        self.is_excused |= chosen.is_none();
        for (choice, keys) in variants.cases.iter().filter(|(choice, _)| Some(choice.name) != chosen) {
            let owner = format!("{tag} = \"{}\"", choice.name);
            self.elsewhere.extend(keys.iter().map(|key| (key.name, owner.clone())));
        }
        chosen
    }

    /// Where the table stands.
    pub fn span(&self) -> Span {
        self.span
    }

    /// Reports the keys that nothing asked for.
    fn finish(self) {
        let Self { table, decoder, known, elsewhere, is_excused, .. } = self;
        for entry in table.entries.iter().filter(|entry| !known.contains(&entry.key.as_str())) {
            let owners: Vec<_> =
                elsewhere.iter().filter(|(key, _)| *key == entry.key).map(|(_, owner)| owner).collect();
            if is_excused && !owners.is_empty() {
                continue;
            }
            let place = match decoder.place() {
                place if place.is_empty() => String::new(),
                place => format!(" in `{place}`"),
            };
            let message = format!("unknown key `{}`{place}", entry.key);
            let nearest = nearest(&entry.key, known.iter().copied());
            let instead = synonyms::of_key(&decoder.place(), &entry.key);
            let label = match nearest.filter(|_| instead.is_none()) {
                Some(name) => format!("did you mean `{name}`?"),
                None => "unknown".to_owned(),
            };
            let help = match (owners.first(), instead) {
                (Some(owner), _) => format!("`{}` belongs to {owner}", entry.key),
                (None, Some(instead)) => instead.to_owned(),
                (None, None) => format!("the keys are {}", listed(known.iter().copied())),
            };
            decoder.report(Diagnostic::error(message).at(entry.key_span, label).help(help));
        }
    }
}

/// A line that would supply a missing key.
fn example_of(key: &str, schema: &Schema) -> String {
    match schema {
        Schema::Quantity(quantity) if quantity.is_angle => format!("it is an angle, such as {key} = \"30 deg\""),
        Schema::Quantity(quantity) => match quantity.dimension {
            Some(dimension) => format!("it is {dimension}, such as {key} = \"{}\"", dimension.example()),
            None => format!("{key} = a number or a string with a unit"),
        },
        Schema::Choice(choices) => format!("the choices are {}", listed(choices.iter().map(|choice| choice.name))),
        Schema::Group(kinds) => format!("it names a {kinds} group of the mesh"),
        Schema::Text(what) => format!("it is {what}"),
        Schema::Table(table) => {
            let tags = table.variants.iter().map(|variants| variants.tag);
            format!("a table with {}", listed(table.keys.iter().map(|key| key.name).chain(tags)))
        }
        Schema::Named(_) => format!("a table such as [{key}.NAME]"),
        Schema::List(_) => format!("a list, or [[{key}]]"),
        Schema::Points(..) => format!("a list of points, such as {key} = [[0.0, 0.0], [1.0, 1.0]]"),
        Schema::Vector(..) | Schema::Direction => format!("a list of three numbers, such as {key} = [0.0, 0.0, 1.0]"),
        Schema::Rows(row, _) => format!("a list of rows {row}"),
        Schema::Count => "a whole number from 1".to_owned(),
        Schema::Either(schemas) => schemas.first().map_or_else(String::new, |schema| example_of(key, schema)),
    }
}
