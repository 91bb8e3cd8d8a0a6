//! The mesh and what makes it valid.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use thiserror::Error;

use crate::hex::{face_key, faces};
use crate::{ElementLabel, Group, NodeLabel};

/// Nodes, hexes and named groups. Valid once it exists; see [`Mesh::new`]. Clones share one memory: whoever needs a mesh
/// for long keeps one.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    pub(crate) parts: Arc<Parts>,
}

/// What a mesh is made of.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Parts {
    pub coordinates: Vec<[f64; 3]>,
    pub node_labels: Vec<NodeLabel>,
    pub hexes: Vec<[u32; 8]>,
    pub hex_labels: Vec<ElementLabel>,
    pub groups: Vec<Group>,
}

/// Why nodes, hexes and groups do not make a mesh.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MeshError {
    /// No hex at all.
    #[error("the mesh has no hexahedra; mesh its volume with 8-node hexahedra and export them")]
    NoHexes,
    /// More nodes or hexes than 32-bit indices reach.
    #[error("the mesh has {count} {what}; at most {limit} are supported")]
    TooLarge {
        /// "nodes" or "hexes".
        what: &'static str,
        /// How many there are.
        count: usize,
        /// How many there may be.
        limit: usize,
    },
    /// Two lists that must be equally long are not.
    #[error("{labels} {what} labels for {count} {what}s")]
    LengthMismatch {
        /// "node" or "hex".
        what: &'static str,
        /// How many labels.
        labels: usize,
        /// How many nodes or hexes.
        count: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("node {node}: its {axis} coordinate is {value}; coordinates must be finite numbers")]
    NonFiniteCoordinate {
        /// The node.
        node: NodeLabel,
        /// 'x', 'y' or 'z'.
        axis: char,
        /// What it is.
        value: f64,
    },
    /// A label used for two nodes.
    #[error("node number {node} is used twice; give every node its own number")]
    DuplicateNodeLabel {
        /// The label.
        node: NodeLabel,
    },
    /// A label used for two hexes.
    #[error("element number {element} is used twice; give every element its own number")]
    DuplicateHexLabel {
        /// The label.
        element: ElementLabel,
    },
    /// A hex whose corner is not a node.
    #[error("element {element}: corner {corner} is node index {index}, but there are only {node_count} nodes")]
    HexNodeOutOfRange {
        /// The hex.
        element: ElementLabel,
        /// Its corner, counted from 1.
        corner: usize,
        /// The index out of range.
        index: u32,
        /// How many nodes there are.
        node_count: usize,
    },
    /// A group with a member that the mesh does not have.
    #[error("group \"{group}\": {what} index {index} is out of range; there are {count}")]
    GroupOutOfRange {
        /// The group.
        group: String,
        /// "node" or "hex".
        what: &'static str,
        /// The index out of range.
        index: u32,
        /// How many there are.
        count: usize,
    },
    /// A group without members.
    #[error("group \"{group}\" is empty; give it members or remove it")]
    EmptyGroup {
        /// The group.
        group: String,
    },
    /// A group without a name.
    #[error("a group has no name; name every group")]
    UnnamedGroup,
    /// A name used for two groups.
    #[error("two groups are named \"{group}\"; give every group its own name, also across dimensions")]
    DuplicateGroup {
        /// The name.
        group: String,
    },
}

/// Why a face of a surface group is no outer face of the mesh.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum FaceError {
    /// The face belongs to no hex.
    #[error(
        "surface \"{group}\": the face with nodes {} {} {} {} belongs to no hex; mesh surface and volume together",
        nodes[0], nodes[1], nodes[2], nodes[3]
    )]
    NoHex {
        /// The surface group.
        group: String,
        /// The face's nodes.
        nodes: [NodeLabel; 4],
    },
    /// The face lies between two hexes, so that no side of it is outside.
    #[error(
        "surface \"{group}\": the face with nodes {} {} {} {} lies between elements {} and {}; \
         a load needs an outer face",
        nodes[0], nodes[1], nodes[2], nodes[3], elements[0], elements[1]
    )]
    Interior {
        /// The surface group.
        group: String,
        /// The face's nodes.
        nodes: [NodeLabel; 4],
        /// Two of the hexes it belongs to.
        elements: [ElementLabel; 2],
    },
}

/// The largest number of nodes or hexes: an index is a `u32`.
const INDEX_LIMIT: usize = u32::MAX as usize;

impl Mesh {
    /// A mesh of hexes in VTK and Gmsh corner order (see [`hex`](crate::hex)).
    ///
    /// # Errors
    /// What is out of range, not finite, missing or there twice, by its label.
    pub fn new(
        coordinates: Vec<[f64; 3]>,
        node_labels: Vec<NodeLabel>,
        hexes: Vec<[u32; 8]>,
        hex_labels: Vec<ElementLabel>,
        mut groups: Vec<Group>,
    ) -> Result<Self, MeshError> {
        let (node_count, hex_count) = (coordinates.len(), hexes.len());
        if hex_count == 0 {
            return Err(MeshError::NoHexes);
        }
        for (what, count, labels) in [("node", node_count, node_labels.len()), ("hex", hex_count, hex_labels.len())] {
            if labels != count {
                return Err(MeshError::LengthMismatch { what, labels, count });
            }
        }
        for (what, count) in [("nodes", node_count), ("hexes", hex_count)] {
            if count > INDEX_LIMIT {
                return Err(MeshError::TooLarge { what, count, limit: INDEX_LIMIT });
            }
        }
        for (position, &node) in coordinates.iter().zip(&node_labels) {
            for (&value, axis) in position.iter().zip(['x', 'y', 'z']) {
                if !value.is_finite() {
                    return Err(MeshError::NonFiniteCoordinate { node, axis, value });
                }
            }
        }
        if let Some(node) = first_duplicate(&node_labels) {
            return Err(MeshError::DuplicateNodeLabel { node });
        }
        if let Some(element) = first_duplicate(&hex_labels) {
            return Err(MeshError::DuplicateHexLabel { element });
        }
        for (corners, &element) in hexes.iter().zip(&hex_labels) {
            if let Some(corner) = corners.iter().position(|&index| index as usize >= node_count) {
                return Err(MeshError::HexNodeOutOfRange {
                    element,
                    corner: corner + 1,
                    index: corners[corner],
                    node_count,
                });
            }
        }
        let mut names = HashSet::new();
        for group in &groups {
            if group.name.is_empty() {
                return Err(MeshError::UnnamedGroup);
            }
            if !names.insert(group.name.as_str()) {
                return Err(MeshError::DuplicateGroup { group: group.name.clone() });
            }
            let out_of_range =
                |what, index, count| Err(MeshError::GroupOutOfRange { group: group.name.clone(), what, index, count });
            if let Some(&index) = group.hexes.iter().find(|&&index| index as usize >= hex_count) {
                return out_of_range("hex", index, hex_count);
            }
            if let Some(&index) =
                group.nodes.iter().chain(group.faces.iter().flatten()).find(|&&index| index as usize >= node_count)
            {
                return out_of_range("node", index, node_count);
            }
        }
        for group in &mut groups {
            // a surface is a set: a face that is listed twice, in whatever order of its nodes, is in it once
            let mut seen = HashSet::new();
            group.faces.retain(|face| seen.insert(face_key(face)));
            group.complete(&hexes, coordinates.len());
            if group.nodes.is_empty() {
                return Err(MeshError::EmptyGroup { group: group.name.clone() });
            }
        }
        Ok(Self::of(Parts { coordinates, node_labels, hexes, hex_labels, groups }))
    }

    /// A mesh numbered from 1 whose parts are valid by construction.
    pub(crate) fn generated(coordinates: Vec<[f64; 3]>, hexes: Vec<[u32; 8]>, mut groups: Vec<Group>) -> Self {
        for group in &mut groups {
            group.complete(&hexes, coordinates.len());
        }
        let node_labels = (1..=coordinates.len() as u64).map(NodeLabel).collect();
        let hex_labels = (1..=hexes.len() as u64).map(ElementLabel).collect();
        Self::of(Parts { coordinates, node_labels, hexes, hex_labels, groups })
    }

    /// The mesh of valid parts.
    pub(crate) fn of(parts: Parts) -> Self {
        Self { parts: Arc::new(parts) }
    }

    /// The number of nodes.
    pub fn node_count(&self) -> usize {
        self.parts.coordinates.len()
    }

    /// The number of hexes.
    pub fn hex_count(&self) -> usize {
        self.parts.hexes.len()
    }

    /// The position of every node.
    pub fn coordinates(&self) -> &[[f64; 3]] {
        &self.parts.coordinates
    }

    /// The user's number of every node.
    pub fn node_labels(&self) -> &[NodeLabel] {
        &self.parts.node_labels
    }

    /// The corner nodes of every hex.
    pub fn hexes(&self) -> &[[u32; 8]] {
        &self.parts.hexes
    }

    /// The user's number of every hex.
    pub fn hex_labels(&self) -> &[ElementLabel] {
        &self.parts.hex_labels
    }

    /// All groups, in the order of the file.
    pub fn groups(&self) -> &[Group] {
        &self.parts.groups
    }

    /// The group of that name.
    pub fn group(&self, name: &str) -> Option<&Group> {
        self.parts.groups.iter().find(|group| group.name == name)
    }

    /// The positions of a hex's corners.
    pub fn corners(&self, hex: usize) -> [[f64; 3]; 8] {
        self.parts.hexes[hex].map(|node| self.parts.coordinates[node as usize])
    }

    /// The least and the greatest coordinates.
    pub fn extent(&self) -> [[f64; 3]; 2] {
        let mut extent = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        for position in &self.parts.coordinates {
            for axis in 0..3 {
                extent[0][axis] = extent[0][axis].min(position[axis]);
                extent[1][axis] = extent[1][axis].max(position[axis]);
            }
        }
        extent
    }

    /// The mesh with every coordinate multiplied, as by 1e-3 for a file in millimetres.
    ///
    /// # Errors
    /// [`MeshError::NonFiniteCoordinate`] if a coordinate leaves the range of numbers.
    pub fn scaled(mut self, factor: f64) -> Result<Self, MeshError> {
        let parts = Arc::make_mut(&mut self.parts);
        for (position, &node) in parts.coordinates.iter_mut().zip(&parts.node_labels) {
            for (value, axis) in position.iter_mut().zip(['x', 'y', 'z']) {
                *value *= factor;
                if !value.is_finite() {
                    return Err(MeshError::NonFiniteCoordinate { node, axis, value: *value });
                }
            }
        }
        Ok(self)
    }

    /// The faces of a surface group, each turned so that its right-hand normal points out of the hex it belongs to.
    ///
    /// # Errors
    /// The first face that belongs to no hex, or to two.
    pub fn outward_faces(&self, group: &Group) -> Result<Vec<[u32; 4]>, FaceError> {
        // Only hexes with four nodes in the group can own one of its faces: a small map, whatever the mesh's size.
        let mut in_group = vec![false; self.node_count()];
        for &node in group.faces.iter().flatten() {
            in_group[node as usize] = true;
        }
        let mut owners: HashMap<[u32; 4], ([u32; 4], Vec<usize>)> =
            group.faces.iter().map(|face| (face_key(face), (*face, Vec::new()))).collect();
        for (hex, corners) in self.parts.hexes.iter().enumerate() {
            if corners.iter().filter(|&&node| in_group[node as usize]).count() < 4 {
                continue;
            }
            for face in faces(corners) {
                if let Some((outward, hexes)) = owners.get_mut(&face_key(&face)) {
                    *outward = face;
                    hexes.push(hex);
                }
            }
        }
        group
            .faces
            .iter()
            .map(|face| {
                let nodes = face.map(|node| self.parts.node_labels[node as usize]);
                match owners.get(&face_key(face)) {
                    Some((outward, hexes)) if hexes.len() == 1 => Ok(*outward),
                    Some((_, hexes)) if hexes.len() > 1 => Err(FaceError::Interior {
                        group: group.name.clone(),
                        nodes,
                        elements: [self.parts.hex_labels[hexes[0]], self.parts.hex_labels[hexes[1]]],
                    }),
                    _ => Err(FaceError::NoHex { group: group.name.clone(), nodes }),
                }
            })
            .collect()
    }
}

/// The smallest value that is there twice.
fn first_duplicate<T: Ord + Copy>(values: &[T]) -> Option<T> {
    if values.windows(2).all(|pair| pair[0] < pair[1]) {
        return None;
    }
    let mut sorted = values.to_vec();
    sorted.sort_unstable();
    sorted.windows(2).find(|pair| pair[0] == pair[1]).map(|pair| pair[0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::GroupKind;
    use crate::generate::{BoxSpec, box_mesh};

    type Parts = (Vec<[f64; 3]>, Vec<NodeLabel>, Vec<[u32; 8]>, Vec<ElementLabel>);

    fn cube_parts() -> Parts {
        let coordinates = crate::hex::CORNER_SIGNS.to_vec();
        (coordinates, (11..19).map(NodeLabel).collect(), vec![[0, 1, 2, 3, 4, 5, 6, 7]], vec![ElementLabel(7)])
    }

    fn two_hexes() -> Mesh {
        box_mesh(&BoxSpec::new([2.0, 1.0, 1.0], [2, 1, 1]).unwrap())
    }

    #[test]
    fn a_mesh_without_hexes_is_refused() {
        assert_eq!(Mesh::new(vec![], vec![], vec![], vec![], vec![]), Err(MeshError::NoHexes));
    }

    #[test]
    fn a_non_finite_coordinate_is_refused_by_its_label() {
        let (mut x, n, h, e) = cube_parts();
        x[3][2] = f64::NAN;
        let error = Mesh::new(x, n, h, e, vec![]).unwrap_err().to_string();
        assert_eq!(error, "node 14: its z coordinate is NaN; coordinates must be finite numbers");
    }

    #[test]
    fn labels_must_be_unique_and_as_many_as_their_owners() {
        let (x, mut n, h, e) = cube_parts();
        n[5] = n[0];
        assert_eq!(
            Mesh::new(x.clone(), n.clone(), h.clone(), e.clone(), vec![]),
            Err(MeshError::DuplicateNodeLabel { node: NodeLabel(11) })
        );
        n.pop();
        assert!(matches!(Mesh::new(x, n, h, e, vec![]), Err(MeshError::LengthMismatch { what: "node", .. })));
    }

    #[test]
    fn indices_out_of_range_are_refused_in_hexes_and_groups() {
        let (x, n, mut h, e) = cube_parts();
        let group = vec![Group::point("p", vec![8])];
        assert!(matches!(
            Mesh::new(x.clone(), n.clone(), h.clone(), e.clone(), group),
            Err(MeshError::GroupOutOfRange { what: "node", index: 8, .. })
        ));
        h[0][7] = 8;
        assert!(matches!(
            Mesh::new(x, n, h, e, vec![]),
            Err(MeshError::HexNodeOutOfRange { element: ElementLabel(7), corner: 8, .. })
        ));
    }

    #[test]
    fn group_names_are_unique_and_groups_are_not_empty() {
        let (x, n, h, e) = cube_parts();
        let twice = vec![Group::volume("a", vec![0]), Group::point("a", vec![1])];
        let new = |groups| Mesh::new(x.clone(), n.clone(), h.clone(), e.clone(), groups);
        assert!(matches!(new(twice), Err(MeshError::DuplicateGroup { .. })));
        assert!(matches!(new(vec![Group::curve("c", vec![])]), Err(MeshError::EmptyGroup { .. })));
        assert!(matches!(new(vec![Group::curve("", vec![1])]), Err(MeshError::UnnamedGroup)));
    }

    #[test]
    fn a_group_knows_the_nodes_of_its_hexes_and_faces() {
        let mesh = two_hexes();
        let volume = mesh.group("box").unwrap();
        assert_eq!((volume.kind, volume.nodes.len()), (GroupKind::Volume, 12));
        assert_eq!(mesh.group("x_min").unwrap().nodes.len(), 4);
        assert!(mesh.group("nowhere").is_none());
    }

    #[test]
    fn a_face_that_is_listed_twice_is_in_the_group_once() {
        let mesh = two_hexes();
        let mut groups = mesh.groups().to_vec();
        let surface = groups.iter_mut().find(|group| !group.faces.is_empty()).unwrap();
        let count = surface.faces.len();
        let mut again = surface.faces.clone();
        again[0].reverse();
        surface.faces.extend(again);
        let name = surface.name.clone();
        let parts = (mesh.node_labels().to_vec(), mesh.hexes().to_vec(), mesh.hex_labels().to_vec());
        let read = Mesh::new(mesh.coordinates().to_vec(), parts.0, parts.1, parts.2, groups).unwrap();
        assert_eq!(read.group(&name).unwrap().faces.len(), count);
    }

    #[test]
    fn faces_are_turned_outwards_whatever_their_orientation_in_the_file() {
        let mesh = two_hexes();
        for name in ["x_min", "x_max", "y_min", "y_max", "z_min", "z_max"] {
            let mut group = mesh.group(name).unwrap().clone();
            let outward = mesh.outward_faces(&group).unwrap();
            group.faces.iter_mut().for_each(|face| face.reverse());
            assert_eq!(mesh.outward_faces(&group).unwrap(), outward);
            for face in outward {
                let [a, b, _, d] = face.map(|node| mesh.coordinates()[node as usize]);
                let axis = usize::from(name.as_bytes()[0] - b'x');
                let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
                let normal = (b[i] - a[i]) * (d[j] - a[j]) - (b[j] - a[j]) * (d[i] - a[i]);
                assert_eq!(normal > 0.0, name.ends_with("max"), "{name}");
            }
        }
    }

    #[test]
    fn interior_and_foreign_faces_are_named() {
        let mesh = two_hexes();
        let interior: Vec<u32> =
            (0..12).filter(|&node| (mesh.coordinates()[node as usize][0] - 1.0).abs() < 1e-12).collect();
        let group = Group::surface("mid", vec![[interior[0], interior[1], interior[2], interior[3]]]);
        let error = mesh.outward_faces(&group).unwrap_err();
        assert!(matches!(error, FaceError::Interior { elements: [ElementLabel(1), ElementLabel(2)], .. }));
        let group = Group::surface("odd", vec![[0, 1, 2, 9]]);
        assert!(matches!(mesh.outward_faces(&group), Err(FaceError::NoHex { .. })));
    }

    #[test]
    fn scaling_scales_the_extent_and_refuses_to_overflow() {
        let mesh = two_hexes().scaled(1e-3).unwrap();
        assert_eq!(mesh.extent(), [[0.0; 3], [2e-3, 1e-3, 1e-3]]);
        assert!(mesh.scaled(f64::INFINITY).is_err());
    }
}
