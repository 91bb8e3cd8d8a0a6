//! Named sets of a mesh's parts, by which a deck says where a load, a constraint or a material goes.

use std::fmt;

/// What a group is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum GroupKind {
    /// Hexes.
    Volume,
    /// Quadrilateral faces of hexes.
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

/// A named set of hexes, faces or nodes. Every group knows its nodes, so that a constraint may name any kind.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Group {
    /// The name a deck uses.
    pub name: String,
    /// What the group is made of.
    pub kind: GroupKind,
    /// Indices of all its nodes, ascending, each once. [`Mesh::new`](crate::Mesh::new) adds those of `hexes` and `faces`.
    pub nodes: Vec<u32>,
    /// Indices of its hexes, ascending, each once; empty unless a [`GroupKind::Volume`].
    pub hexes: Vec<u32>,
    /// Its faces by their node indices, as the file wrote them; empty unless a [`GroupKind::Surface`].
    /// Their orientation is free: see [`Mesh::outward_faces`](crate::Mesh::outward_faces).
    pub faces: Vec<[u32; 4]>,
}

impl Group {
    /// A group of hexes; its nodes are filled in by [`Mesh::new`](crate::Mesh::new).
    pub fn volume(name: impl Into<String>, hexes: Vec<u32>) -> Self {
        Self { name: name.into(), kind: GroupKind::Volume, nodes: Vec::new(), hexes, faces: Vec::new() }
    }

    /// A group of faces; its nodes are filled in by [`Mesh::new`](crate::Mesh::new).
    pub fn surface(name: impl Into<String>, faces: Vec<[u32; 4]>) -> Self {
        Self { name: name.into(), kind: GroupKind::Surface, nodes: Vec::new(), hexes: Vec::new(), faces }
    }

    /// A group of the nodes along a curve.
    pub fn curve(name: impl Into<String>, nodes: Vec<u32>) -> Self {
        Self { name: name.into(), kind: GroupKind::Curve, nodes, hexes: Vec::new(), faces: Vec::new() }
    }

    /// A group of single nodes.
    pub fn point(name: impl Into<String>, nodes: Vec<u32>) -> Self {
        Self { name: name.into(), kind: GroupKind::Point, nodes, hexes: Vec::new(), faces: Vec::new() }
    }

    /// Brings the group into its one form: hexes and nodes ascending and unique, the nodes of hexes and faces included.
    pub(crate) fn complete(&mut self, hexes: &[[u32; 8]], node_count: usize) {
        self.hexes.sort_unstable();
        self.hexes.dedup();
        self.nodes.extend(self.faces.iter().flatten());
        if self.hexes.is_empty() {
            self.nodes.sort_unstable();
            self.nodes.dedup();
        } else {
            // marks instead of a sort: every node of a volume comes up about eight times
            let mut is_member = vec![false; node_count];
            let of_hexes = self.hexes.iter().flat_map(|&hex| hexes[hex as usize]);
            for node in of_hexes.chain(self.nodes.drain(..)) {
                is_member[node as usize] = true;
            }
            self.nodes = (0..).zip(is_member).filter(|(_, is_member)| *is_member).map(|(node, _)| node).collect();
        }
    }
}
