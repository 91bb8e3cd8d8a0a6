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
}

impl fmt::Display for GroupKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            GroupKind::Volume => "volume",
            GroupKind::Surface => "surface",
            GroupKind::Curve => "curve",
            GroupKind::Point => "point",
        })
    }
}

/// A named set of elements, faces or nodes. Every group knows its nodes, so that a constraint may name any kind.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Group {
    /// The name a deck uses.
    pub name: String,
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
    /// A group of elements; its nodes are filled in by [`Mesh::new`](crate::Mesh::new).
    pub fn volume(name: impl Into<String>, elements: Vec<u32>) -> Self {
        Self { name: name.into(), kind: GroupKind::Volume, nodes: Vec::new(), elements, faces: Vec::new() }
    }

    /// A group of faces; its nodes are filled in by [`Mesh::new`](crate::Mesh::new).
    pub fn surface(name: impl Into<String>, faces: impl IntoIterator<Item: Into<Face>>) -> Self {
        let faces = faces.into_iter().map(Into::into).collect();
        Self { name: name.into(), kind: GroupKind::Surface, nodes: Vec::new(), elements: Vec::new(), faces }
    }

    /// A group of the nodes along a curve.
    pub fn curve(name: impl Into<String>, nodes: Vec<u32>) -> Self {
        Self { name: name.into(), kind: GroupKind::Curve, nodes, elements: Vec::new(), faces: Vec::new() }
    }

    /// A group of single nodes.
    pub fn point(name: impl Into<String>, nodes: Vec<u32>) -> Self {
        Self { name: name.into(), kind: GroupKind::Point, nodes, elements: Vec::new(), faces: Vec::new() }
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
