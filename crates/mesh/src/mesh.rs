//! The mesh and what makes it valid.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use thiserror::Error;

use arrayvec::ArrayVec;

use crate::{ElementLabel, Elements, Face, FaceKey, Group, GroupKind, MOST_NODES, NodeLabel};

/// Nodes, elements and named groups. Valid once it exists; see [`Mesh::new`]. Clones share one memory: whoever needs a mesh
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
    pub elements: Elements,
    pub element_labels: Vec<ElementLabel>,
    pub groups: Vec<Group>,
}

/// Why nodes, elements and groups do not make a mesh.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MeshError {
    /// No element at all.
    #[error("the mesh has no solid elements; mesh its volume with hexahedra, wedges or tetrahedra and export them")]
    NoElements,
    /// More nodes or elements than 32-bit indices reach.
    #[error("the mesh has {count} {what}; at most {limit} are supported")]
    TooLarge {
        /// "nodes" or "elements".
        what: &'static str,
        /// How many there are.
        count: usize,
        /// How many there may be.
        limit: usize,
    },
    /// Two lists that must be equally long are not.
    #[error("{labels} {what} labels for {count} {what}s")]
    LengthMismatch {
        /// "node" or "element".
        what: &'static str,
        /// How many labels.
        labels: usize,
        /// How many nodes or elements.
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
    /// A label used for two elements.
    #[error("element number {element} is used twice; give every element its own number")]
    DuplicateElementLabel {
        /// The label.
        element: ElementLabel,
    },
    /// An element one of whose nodes is none of the mesh.
    #[error("element {element}: its node {place} is node index {index}, but there are only {node_count} nodes")]
    ElementNodeOutOfRange {
        /// The element.
        element: ElementLabel,
        /// Which of its nodes, counted from 1.
        place: usize,
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
        /// "node" or "element".
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
    /// A name used for two groups of one kind and owner.
    #[error("two {kind} groups are named \"{group}\"; give each its own name")]
    DuplicateGroup {
        /// The name.
        group: String,
        /// The kind of both.
        kind: GroupKind,
    },
}

/// Why a face of a surface group is no outer face of the mesh.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum FaceError {
    /// The face belongs to no element.
    #[error(
        "surface \"{group}\": the face with nodes {} belongs to no element; mesh surface and volume together",
        words(nodes)
    )]
    NoElement {
        /// The surface group.
        group: String,
        /// The face's nodes.
        nodes: Vec<NodeLabel>,
    },
    /// The face lies between two elements, so that no side of it is outside.
    #[error(
        "surface \"{group}\": the face with nodes {} lies between elements {} and {}; a load needs an outer face",
        words(nodes), elements[0], elements[1]
    )]
    Interior {
        /// The surface group.
        group: String,
        /// The face's nodes.
        nodes: Vec<NodeLabel>,
        /// Two of the elements it belongs to.
        elements: [ElementLabel; 2],
    },
}

/// Numbers with spaces between them.
fn words(nodes: &[NodeLabel]) -> String {
    nodes.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ")
}

/// The largest number of nodes or elements: an index is a `u32`.
const INDEX_LIMIT: usize = u32::MAX as usize;

impl Mesh {
    /// A mesh of elements whose nodes are in the order of VTK (see [`hex`](crate::hex) and [`Shape`](crate::Shape)).
    ///
    /// # Errors
    /// What is out of range, not finite, missing or there twice, by its label.
    pub fn new(
        coordinates: Vec<[f64; 3]>,
        node_labels: Vec<NodeLabel>,
        elements: impl Into<Elements>,
        element_labels: Vec<ElementLabel>,
        mut groups: Vec<Group>,
    ) -> Result<Self, MeshError> {
        let elements = elements.into();
        let (node_count, element_count) = (coordinates.len(), elements.len());
        if element_count == 0 {
            return Err(MeshError::NoElements);
        }
        for (what, count, labels) in
            [("node", node_count, node_labels.len()), ("element", element_count, element_labels.len())]
        {
            if labels != count {
                return Err(MeshError::LengthMismatch { what, labels, count });
            }
        }
        for (what, count) in [("nodes", node_count), ("elements", element_count)] {
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
        if let Some(element) = first_duplicate(&element_labels) {
            return Err(MeshError::DuplicateElementLabel { element });
        }
        for (nodes, &element) in elements.iter().zip(&element_labels) {
            if let Some(place) = nodes.iter().position(|&index| index as usize >= node_count) {
                let (place, index) = (place + 1, nodes[place]);
                return Err(MeshError::ElementNodeOutOfRange { element, place, index, node_count });
            }
        }
        let mut names = HashSet::new();
        for group in &groups {
            if group.name.is_empty() {
                return Err(MeshError::UnnamedGroup);
            }
            if !names.insert((group.name.as_str(), group.kind, group.owners.first())) {
                return Err(MeshError::DuplicateGroup { group: group.name.clone(), kind: group.kind });
            }
            let out_of_range =
                |what, index, count| Err(MeshError::GroupOutOfRange { group: group.name.clone(), what, index, count });
            if let Some(&index) = group.elements.iter().find(|&&index| index as usize >= element_count) {
                return out_of_range("element", index, element_count);
            }
            if let Some(&index) = group
                .nodes
                .iter()
                .chain(group.faces.iter().flat_map(Face::nodes))
                .find(|&&index| index as usize >= node_count)
            {
                return out_of_range("node", index, node_count);
            }
        }
        for group in &mut groups {
            // a surface is a set: a face that is listed twice, in whatever order of its nodes, is in it once
            let mut seen = HashSet::new();
            group.faces.retain(|face| seen.insert(face.key()));
            group.complete(&elements, coordinates.len());
            if group.nodes.is_empty() {
                return Err(MeshError::EmptyGroup { group: group.name.clone() });
            }
        }
        Ok(Self::of(Parts { coordinates, node_labels, elements, element_labels, groups }))
    }

    /// A mesh numbered from 1 whose parts are valid by construction.
    pub(crate) fn generated(coordinates: Vec<[f64; 3]>, elements: impl Into<Elements>, mut groups: Vec<Group>) -> Self {
        let elements = elements.into();
        for group in &mut groups {
            group.complete(&elements, coordinates.len());
        }
        let node_labels = (1..=coordinates.len() as u64).map(NodeLabel).collect();
        let element_labels = (1..=elements.len() as u64).map(ElementLabel).collect();
        Self::of(Parts { coordinates, node_labels, elements, element_labels, groups })
    }

    /// The mesh of valid parts.
    pub(crate) fn of(parts: Parts) -> Self {
        Self { parts: Arc::new(parts) }
    }

    /// The number of nodes.
    pub fn node_count(&self) -> usize {
        self.parts.coordinates.len()
    }

    /// The number of elements.
    pub fn element_count(&self) -> usize {
        self.parts.elements.len()
    }

    /// The position of every node.
    pub fn coordinates(&self) -> &[[f64; 3]] {
        &self.parts.coordinates
    }

    /// The user's number of every node.
    pub fn node_labels(&self) -> &[NodeLabel] {
        &self.parts.node_labels
    }

    /// The elements.
    pub fn elements(&self) -> &Elements {
        &self.parts.elements
    }

    /// The user's number of every element.
    pub fn element_labels(&self) -> &[ElementLabel] {
        &self.parts.element_labels
    }

    /// All groups, in the order of the file.
    pub fn groups(&self) -> &[Group] {
        &self.parts.groups
    }

    /// The first group of that name; [`Mesh::find`] tells namesakes apart.
    pub fn group(&self, name: &str) -> Option<&Group> {
        self.parts.groups.iter().find(|group| group.name == name)
    }

    /// The positions of an element's nodes.
    pub fn positions(&self, element: usize) -> ArrayVec<[f64; 3], MOST_NODES> {
        let nodes = self.parts.elements.nodes(element).iter();
        nodes.map(|&node| self.parts.coordinates[node as usize]).collect()
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

    /// The faces of a surface group, each turned so that its right-hand normal points out of the element it belongs to.
    ///
    /// # Errors
    /// The first face that belongs to no element, or to two.
    pub fn outward_faces(&self, group: &Group) -> Result<Vec<Face>, FaceError> {
        // Only elements with three nodes in the group can own one of its faces: a small map, whatever the mesh's size.
        let mut in_group = vec![false; self.node_count()];
        for &node in group.faces.iter().flat_map(Face::nodes) {
            in_group[node as usize] = true;
        }
        let mut owners: HashMap<FaceKey, (Face, Vec<usize>)> =
            group.faces.iter().map(|face| (face.key(), (*face, Vec::new()))).collect();
        for (element, nodes) in self.parts.elements.iter().enumerate() {
            if nodes.iter().filter(|&&node| in_group[node as usize]).count() < 3 {
                continue;
            }
            for face in self.parts.elements.faces(element) {
                if let Some((outward, elements)) = owners.get_mut(&face.key()) {
                    *outward = face;
                    elements.push(element);
                }
            }
        }
        group
            .faces
            .iter()
            .map(|face| {
                let labels =
                    |face: &Face| face.nodes().iter().map(|&node| self.parts.node_labels[node as usize]).collect();
                match owners.get(&face.key()) {
                    Some((outward, elements)) if elements.len() == 1 => Ok(*outward),
                    Some((_, elements)) if elements.len() > 1 => Err(FaceError::Interior {
                        group: group.name.clone(),
                        nodes: labels(face),
                        elements: [0, 1].map(|k| self.parts.element_labels[elements[k]]),
                    }),
                    _ => Err(FaceError::NoElement { group: group.name.clone(), nodes: labels(face) }),
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
    fn a_mesh_without_elements_is_refused() {
        assert_eq!(Mesh::new(vec![], vec![], vec![], vec![], vec![]), Err(MeshError::NoElements));
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
            Err(MeshError::ElementNodeOutOfRange { element: ElementLabel(7), place: 8, .. })
        ));
    }

    #[test]
    fn group_names_are_unique_and_groups_are_not_empty() {
        let (x, n, h, e) = cube_parts();
        let twice = vec![Group::volume("a", vec![0]), Group::volume("a", vec![0])];
        let new = |groups| Mesh::new(x.clone(), n.clone(), h.clone(), e.clone(), groups);
        assert!(matches!(new(twice), Err(MeshError::DuplicateGroup { .. })));
        assert!(matches!(new(vec![Group::curve("c", vec![])]), Err(MeshError::EmptyGroup { .. })));
        assert!(matches!(new(vec![Group::curve("", vec![1])]), Err(MeshError::UnnamedGroup)));
    }

    #[test]
    fn a_group_knows_the_nodes_of_its_elements_and_faces() {
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
        again[0] = again[0].reversed();
        surface.faces.extend(again);
        let name = surface.name.clone();
        let parts = (mesh.node_labels().to_vec(), mesh.elements().clone(), mesh.element_labels().to_vec());
        let read = Mesh::new(mesh.coordinates().to_vec(), parts.0, parts.1, parts.2, groups).unwrap();
        assert_eq!(read.group(&name).unwrap().faces.len(), count);
    }

    #[test]
    fn faces_are_turned_outwards_whatever_their_orientation_in_the_file() {
        let mesh = two_hexes();
        for name in ["x_min", "x_max", "y_min", "y_max", "z_min", "z_max"] {
            let mut group = mesh.group(name).unwrap().clone();
            let outward = mesh.outward_faces(&group).unwrap();
            group.faces.iter_mut().for_each(|face| *face = face.reversed());
            assert_eq!(mesh.outward_faces(&group).unwrap(), outward);
            for face in outward {
                let [a, b, d] = [0, 1, 3].map(|k| mesh.coordinates()[face.nodes()[k] as usize]);
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
        assert!(matches!(mesh.outward_faces(&group), Err(FaceError::NoElement { .. })));
    }

    #[test]
    fn scaling_scales_the_extent_and_refuses_to_overflow() {
        let mesh = two_hexes().scaled(1e-3).unwrap();
        assert_eq!(mesh.extent(), [[0.0; 3], [2e-3, 1e-3, 1e-3]]);
        assert!(mesh.scaled(f64::INFINITY).is_err());
    }
}
