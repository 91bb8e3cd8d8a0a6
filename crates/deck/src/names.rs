//! Names: of what the deck defines and uses, of groups of the mesh, of files.

use crate::decoder::{At, Decoder, FromDeck, GroupMention, Mention, Named};
use crate::diagnostics::{Diagnostic, Span};
use crate::schema::Schema;
use crate::tree::{Node, Value};
use estar_io::{LONGEST_NAME, steers};
use estar_mesh::{Group, Mesh, Wanted};
use std::marker::PhantomData;
use std::path::PathBuf;

/// What a name must be to stand in messages, in ledgers and at the head of a column.
pub fn checked_name(name: &str, span: Span, what: Named, decoder: &mut Decoder) -> Option<()> {
    checked_length(name, span, &what.to_string(), decoder)?;
    if !name.trim().is_empty() && !name.chars().any(|c| steers(c) || matches!(c, ',' | '"' | ';')) {
        return Some(());
    }
    let message = format!("a {what} cannot be named {name:?}");
    let help = "a name has at least one character to be seen, and none of these: comma, semicolon, quote, control \
                character such as a line break, mark of the direction of writing";
    decoder.report(Diagnostic::error(message).at(span, "this name").help(help));
    None
}

/// Reports a name that is longer than any that is read from a mesh, or shown.
fn checked_length(name: &str, span: Span, what: &str, decoder: &mut Decoder) -> Option<()> {
    let length = name.chars().count();
    if length <= LONGEST_NAME {
        return Some(());
    }
    let message = format!("the name of a {what} has {length} characters, where up to {LONGEST_NAME} are read");
    decoder.report(Diagnostic::error(message).at(span, "this name").help("take a shorter one"));
    None
}

/// Tables under names that the user gives.
#[derive(Clone, Debug)]
pub struct Materials<T>(pub Vec<(String, T)>);

impl<T: FromDeck> FromDeck for Materials<T> {
    fn schema() -> Schema {
        Schema::Named(Box::new(T::schema()))
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        let Value::Table(table) = &node.value else {
            decoder.wrong_type(node, "a table with a name, such as [material.copper]");
            return None;
        };
        let mut values = Vec::new();
        let mut is_good = true;
        for entry in &table.entries {
            let name = At { value: entry.key.clone(), span: entry.key_span };
            is_good &= checked_name(&entry.key, entry.key_span, Named::Material, decoder).is_some();
            decoder.definitions.push(Mention { of: Named::Material, name });
            match decoder.value(&entry.key, &entry.node) {
                Some(value) => values.push((entry.key.clone(), value)),
                None => is_good = false,
            }
        }
        is_good.then_some(Self(values))
    }
}

/// The name of a material of the deck.
#[derive(Clone, Debug)]
pub struct MaterialName(pub At<String>);

impl FromDeck for MaterialName {
    fn schema() -> Schema {
        Schema::Text("the name of a material: NAME of [material.NAME]")
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        let name = At::<String>::decode(node, decoder)?;
        checked_length(&name.value, name.span, "material", decoder)?;
        decoder.mentions.push(Mention { of: Named::Material, name: name.clone() });
        Some(Self(name))
    }
}

/// The name of a probe, where it is defined.
#[derive(Clone, Debug)]
pub struct NewProbeName(pub At<String>);

impl FromDeck for NewProbeName {
    fn schema() -> Schema {
        Schema::Text("a name of your own, which heads the probe's column in history.csv")
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        let name = At::<String>::decode(node, decoder)?;
        decoder.definitions.push(Mention { of: Named::Probe, name: name.clone() });
        checked_name(&name.value, name.span, Named::Probe, decoder)?;
        Some(Self(name))
    }
}

/// The name of a rigid wall, where it is defined.
#[derive(Clone, Debug)]
pub struct NewWallName(pub At<String>);

impl FromDeck for NewWallName {
    fn schema() -> Schema {
        Schema::Text("a name of your own")
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        let name = At::<String>::decode(node, decoder)?;
        decoder.definitions.push(Mention { of: Named::Wall, name: name.clone() });
        checked_name(&name.value, name.span, Named::Wall, decoder)?;
        Some(Self(name))
    }
}

/// The name of a rigid wall, where it is used.
#[derive(Clone, Debug)]
pub struct WallName(pub At<String>);

impl FromDeck for WallName {
    fn schema() -> Schema {
        Schema::Text("the name of a rigid wall")
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        let name = At::<String>::decode(node, decoder)?;
        checked_length(&name.value, name.span, "rigid wall", decoder)?;
        decoder.mentions.push(Mention { of: Named::Wall, name: name.clone() });
        Some(Self(name))
    }
}

/// The name of a probe, where it is used.
#[derive(Clone, Debug)]
pub struct ProbeName(pub At<String>);

impl FromDeck for ProbeName {
    fn schema() -> Schema {
        Schema::Text("the name of a probe")
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        let name = At::<String>::decode(node, decoder)?;
        checked_length(&name.value, name.span, "probe", decoder)?;
        decoder.mentions.push(Mention { of: Named::Probe, name: name.clone() });
        Some(Self(name))
    }
}

/// The file of the mesh.
#[derive(Clone, Debug)]
pub struct MeshFile(pub At<PathBuf>);

impl FromDeck for MeshFile {
    fn schema() -> Schema {
        Schema::Text("a path, relative to the deck")
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        let name = String::decode(node, decoder)?;
        if name.is_empty() {
            decoder.report(Diagnostic::error("the path of the mesh is empty").at(node.span, "a file is needed"));
            return None;
        }
        let file = At { value: decoder.file(&name), span: node.span };
        decoder.mesh_file = Some(file.clone());
        Some(Self(file))
    }
}

/// What of a group a key takes.
pub trait OfGroup {
    /// What is wanted.
    const WANTED: Wanted;
}

/// The elements of a group.
#[derive(Clone, Copy, Debug)]
pub struct OfElements;

impl OfGroup for OfElements {
    const WANTED: Wanted = Wanted::Elements;
}

/// The faces of a group.
#[derive(Clone, Copy, Debug)]
pub struct OfFaces;

impl OfGroup for OfFaces {
    const WANTED: Wanted = Wanted::Faces;
}

/// The nodes of a group of any kind.
#[derive(Clone, Copy, Debug)]
pub struct OfNodes;

impl OfGroup for OfNodes {
    const WANTED: Wanted = Wanted::Nodes;
}

/// The name of a group of the mesh.
#[derive(Clone, Debug)]
pub struct GroupName<K> {
    /// The name.
    pub name: At<String>,
    wanted: PhantomData<K>,
}

impl<K: OfGroup> GroupName<K> {
    /// The group that is meant, which the mesh has once the mentions are checked.
    pub fn group<'mesh>(&self, mesh: &'mesh Mesh) -> Option<&'mesh Group> {
        mesh.find(&self.name.value, K::WANTED).ok()
    }

    /// Its nodes.
    pub fn nodes(&self, mesh: &Mesh) -> Option<Vec<u32>> {
        self.group(mesh).map(|group| group.nodes.clone())
    }
}

impl<K: OfGroup> FromDeck for GroupName<K> {
    fn schema() -> Schema {
        Schema::Group(K::WANTED.kinds())
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        let name = At::<String>::decode(node, decoder)?;
        checked_length(&name.value, name.span, "group", decoder)?;
        decoder.groups.push(GroupMention { name: name.clone(), wanted: K::WANTED });
        Some(Self { name, wanted: PhantomData })
    }
}
