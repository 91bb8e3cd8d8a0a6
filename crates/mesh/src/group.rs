//! Named sets of a mesh's parts, by which a deck says where a load, a constraint or a material goes.

use std::fmt;

use crate::{Elements, Face};

/// What a group is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum GroupKind {
    /// Elements.
    Volume,
    /// Faces of elements.
    Surface,
    /// Nodes along a curve.
    Curve,
    /// Single nodes.
    Point,
    /// Nodes that the file lists by themselves, as a set of an Abaqus file does.
    Nodes,
}

impl GroupKind {
    /// The word before a name that groups of several kinds have: `surface.lid`.
    pub const fn qualifier(self) -> &'static str {
        match self {
            GroupKind::Volume => "volume",
            GroupKind::Surface => "surface",
            GroupKind::Curve => "curve",
            GroupKind::Point => "point",
            GroupKind::Nodes => "nodes",
        }
    }
}

impl fmt::Display for GroupKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            GroupKind::Nodes => "node set",
            other => other.qualifier(),
        })
    }
}

/// A named set of elements, faces or nodes. Every group knows its nodes, so that a constraint may name any kind.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Group {
    /// The name a deck uses. Groups of other kinds or owners may have it, too: see [`Mesh::find`](crate::Mesh::find).
    pub name: String,
    /// What of the file the group belongs to, where a file has levels: the instance of an Abaqus file, `part` where there is
    /// one, or `assembly`. The first is shown, the others are understood.
    pub owners: Vec<String>,
    /// What the group is made of.
    pub kind: GroupKind,
    /// Indices of all its nodes, ascending, each once. [`Mesh::new`](crate::Mesh::new) adds those of `elements` and `faces`.
    pub nodes: Vec<u32>,
    /// Indices of its elements, ascending, each once; empty unless a [`GroupKind::Volume`].
    pub elements: Vec<u32>,
    /// Its faces by their node indices, as the file wrote them; empty unless a [`GroupKind::Surface`].
    /// Their orientation is free: see [`Mesh::outward_faces`](crate::Mesh::outward_faces).
    pub faces: Vec<Face>,
}

impl Group {
    /// A group without members.
    pub fn new(name: impl Into<String>, kind: GroupKind) -> Self {
        let (owners, nodes, elements, faces) = Default::default();
        Self { name: name.into(), owners, kind, nodes, elements, faces }
    }

    /// A group of elements; its nodes are filled in by [`Mesh::new`](crate::Mesh::new).
    pub fn volume(name: impl Into<String>, elements: Vec<u32>) -> Self {
        Self { elements, ..Self::new(name, GroupKind::Volume) }
    }

    /// A group of faces; its nodes are filled in by [`Mesh::new`](crate::Mesh::new).
    pub fn surface(name: impl Into<String>, faces: impl IntoIterator<Item: Into<Face>>) -> Self {
        Self { faces: faces.into_iter().map(Into::into).collect(), ..Self::new(name, GroupKind::Surface) }
    }

    /// A group of the nodes along a curve.
    pub fn curve(name: impl Into<String>, nodes: Vec<u32>) -> Self {
        Self { nodes, ..Self::new(name, GroupKind::Curve) }
    }

    /// A group of single nodes.
    pub fn point(name: impl Into<String>, nodes: Vec<u32>) -> Self {
        Self { nodes, ..Self::new(name, GroupKind::Point) }
    }

    /// A set of nodes.
    pub fn node_set(name: impl Into<String>, nodes: Vec<u32>) -> Self {
        Self { nodes, ..Self::new(name, GroupKind::Nodes) }
    }

    /// Brings the group into its one form: elements and nodes ascending and unique, the nodes of elements and faces included.
    pub(crate) fn complete(&mut self, elements: &Elements, node_count: usize) {
        self.elements.sort_unstable();
        self.elements.dedup();
        self.nodes.extend(self.faces.iter().flat_map(Face::nodes));
        if self.elements.is_empty() {
            self.nodes.sort_unstable();
            self.nodes.dedup();
        } else {
            // marks instead of a sort: every node of a volume comes up about eight times
            let mut is_member = vec![false; node_count];
            let of_elements = self.elements.iter().flat_map(|&element| elements.nodes(element as usize)).copied();
            for node in of_elements.chain(self.nodes.drain(..)) {
                is_member[node as usize] = true;
            }
            self.nodes = (0..).zip(is_member).filter(|(_, is_member)| *is_member).map(|(node, _)| node).collect();
        }
    }
}
