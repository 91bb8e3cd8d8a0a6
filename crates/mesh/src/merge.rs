//! Nodes at one place made one.

use std::ops::ControlFlow;

use rayon::prelude::*;
use thiserror::Error;

use crate::body::DisjointSets;
use crate::mesh::Parts;
use crate::point_tree::PointTree;
use crate::points::distance;
use crate::{ElementLabel, Group, Mesh, NodeLabel};

/// More nodes than this within the tolerance of one are no nodes at one place.
const MOST_NEAR_ONE: usize = 1000;

/// A mesh whose coincident nodes have been merged.
#[derive(Debug, Clone, PartialEq)]
pub struct Merged {
    /// The mesh. Of the nodes that became one, the one with the least label has stayed, where it was.
    pub mesh: Mesh,
    /// How many nodes have gone.
    pub node_count: usize,
    /// How far two nodes that became one were from each other at most.
    pub largest_distance: f64,
}

/// Why nodes cannot be merged.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MergeError {
    /// An element two of whose nodes would be one.
    #[error(
        "merging nodes within {tolerance:e} m of each other would make one of nodes {} and {} of element {element}, which are {distance:e} m \
         apart{}", nodes[0], nodes[1], if *.count > 1 { format!("; {count} elements would collapse so") } else { String::new() }
    )]
    Collapse {
        /// The tolerance.
        tolerance: f64,
        /// The element; of several the one with the least label.
        element: ElementLabel,
        /// Two of its nodes.
        nodes: [NodeLabel; 2],
        /// How far these are from each other.
        distance: f64,
        /// How many elements would collapse.
        count: usize,
    },
    /// Too many nodes within the tolerance.
    #[error(
        "more than {MOST_NEAR_ONE} nodes are within {tolerance:e} m of node {node}: the tolerance of the merge is too large"
    )]
    Crowded {
        /// The tolerance.
        tolerance: f64,
        /// The node; of several the one with the least label.
        node: NodeLabel,
    },
}

impl Mesh {
    /// The mesh in which nodes within `tolerance` of each other, directly or by way of others, are one. Groups follow. The
    /// order of nodes and elements does not matter.
    ///
    /// # Errors
    /// An element that would collapse, or a tolerance so large that very many nodes would become one.
    pub fn merged(&self, tolerance: f64) -> Result<Merged, MergeError> {
        let near = near_pairs(self, tolerance)?;
        let mut sets = DisjointSets::new(self.node_count());
        for &[a, b] in &near {
            sets.join(a, b);
        }
        // the node of a set that stays: that of the least label
        let mut stays: Vec<u32> = (0..self.node_count() as u32).collect();
        for node in near.iter().flatten() {
            let first = sets.first(*node) as usize;
            if self.node_labels()[*node as usize] < self.node_labels()[stays[first] as usize] {
                stays[first] = *node;
            }
        }
        let staying: Vec<u32> = (0..self.node_count() as u32).map(|node| stays[sets.first(node) as usize]).collect();
        if let Some(error) = collapse(self, tolerance, &staying) {
            return Err(error);
        }
        let lengths = near.iter().flatten().map(|&node| {
            distance(&self.coordinates()[node as usize], &self.coordinates()[staying[node as usize] as usize])
        });
        let largest_distance = lengths.fold(0.0, f64::max);
        let mesh = self.with_nodes(&staying);
        Ok(Merged { node_count: self.node_count() - mesh.node_count(), mesh, largest_distance })
    }

    /// The mesh with the node that `staying` names in the place of each; the others have gone.
    fn with_nodes(&self, staying: &[u32]) -> Self {
        let mut new_nodes = vec![0; staying.len()];
        let mut old_nodes = Vec::with_capacity(staying.len());
        for (node, &stays) in staying.iter().enumerate() {
            if node == stays as usize {
                new_nodes[node] = old_nodes.len() as u32;
                old_nodes.push(stays);
            }
        }
        let new = |old: u32| new_nodes[staying[old as usize] as usize];
        let all_elements: Vec<u32> = (0..self.element_count() as u32).collect();
        let group = |group: &Group| {
            let mut nodes: Vec<u32> = group.nodes.iter().map(|&old| new(old)).collect();
            nodes.sort_unstable();
            nodes.dedup();
            let mut seen = std::collections::HashSet::new();
            let faces = group.faces.iter().map(|face| face.map(new)).filter(|face| seen.insert(face.key())).collect();
            Group { nodes, faces, ..group.clone() }
        };
        Self::of(Parts {
            coordinates: old_nodes.iter().map(|&old| self.coordinates()[old as usize]).collect(),
            node_labels: old_nodes.iter().map(|&old| self.node_labels()[old as usize]).collect(),
            elements: self.elements().reordered(&all_elements, new),
            element_labels: self.element_labels().to_vec(),
            groups: self.groups().iter().map(group).collect(),
        })
    }
}

/// The pairs of nodes within the tolerance of each other.
fn near_pairs(mesh: &Mesh, tolerance: f64) -> Result<Vec<[u32; 2]>, MergeError> {
    let points = mesh.coordinates().iter().zip(0..).map(|(&position, node)| (position, node));
    let tree = PointTree::new(points.collect());
    let of_node = |node: u32| {
        let position = mesh.coordinates()[node as usize];
        let (mut count, mut near) = (0, Vec::new());
        tree.in_box(&position.map(|x| x - tolerance), &position.map(|x| x + tolerance), |other, place| {
            if other != node && distance(place, &position) <= tolerance {
                count += 1;
                if node < other {
                    near.push([node, other]);
                }
            }
            if count <= MOST_NEAR_ONE { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        if count <= MOST_NEAR_ONE { Ok(near) } else { Err(mesh.node_labels()[node as usize]) }
    };
    let nodes = 0..mesh.node_count() as u32;
    let crowded = || {
        let labels = nodes.clone().into_par_iter().filter_map(|node| of_node(node).err());
        labels.min().map(|node| MergeError::Crowded { tolerance, node })
    };
    let near: Result<Vec<Vec<[u32; 2]>>, NodeLabel> = nodes
        .clone()
        .into_par_iter()
        .map(of_node)
        .filter(|near| near.as_ref().map_or(true, |near| !near.is_empty()))
        .collect();
    near.map(|near| near.concat()).map_err(|node| crowded().unwrap_or(MergeError::Crowded { tolerance, node }))
}

/// The element with the least label that would have a node twice.
fn collapse(mesh: &Mesh, tolerance: f64, staying: &[u32]) -> Option<MergeError> {
    let of_element = |element: usize| {
        let nodes = mesh.elements().nodes(element);
        let stays = |place: usize| staying[nodes[place] as usize];
        let pairs = (0..nodes.len()).flat_map(|b| (0..b).map(move |a| [a, b]));
        // what has a node twice already is a fault of the mesh, not of the merge
        let mut doubled = pairs.filter(|&[a, b]| nodes[a] != nodes[b] && stays(a) == stays(b));
        doubled.next().map(|pair| (mesh.element_labels()[element], pair.map(|place| nodes[place])))
    };
    let elements = (0..mesh.element_count()).into_par_iter();
    let collapsing: Vec<_> = elements.filter_map(of_element).collect();
    let &(element, nodes) = collapsing.iter().min_by_key(|(element, _)| *element)?;
    let [a, b] = nodes.map(|node| mesh.coordinates()[node as usize]);
    Some(MergeError::Collapse {
        tolerance,
        element,
        nodes: nodes.map(|node| mesh.node_labels()[node as usize]),
        distance: distance(&a, &b),
        count: collapsing.len(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::{BoxSpec, box_mesh};
    use crate::quality::QualityReport;
    use crate::{Connectivity, Renumbering, locality_order};

    /// Two cubes of 2 × 2 × 2 hexes, side by side along x, the second moved in z by an offset; surfaces where they meet.
    fn two_cubes(offset: f64) -> Mesh {
        let cube = box_mesh(&BoxSpec::new([1.0; 3], [2; 3]).unwrap());
        let count = cube.node_count() as u32;
        let mut coordinates = cube.coordinates().to_vec();
        coordinates.extend(cube.coordinates().iter().map(|x| [x[0] + 1.0, x[1], x[2] + offset]));
        let mut elements = cube.elements().clone();
        for element in 0..8 {
            let nodes: Vec<u32> = cube.elements().nodes(element).iter().map(|node| node + count).collect();
            elements.push(cube.elements().shape(element), &nodes);
        }
        let face = |name: &str| cube.group(name).unwrap().faces.clone();
        let groups = vec![
            Group::volume("left", (0..8).collect()),
            Group::volume("right", (8..16).collect()),
            Group::surface("from_left", face("x_max")),
            Group::surface("from_right", face("x_min").into_iter().map(|face| face.map(|node| node + count))),
            Group::surface(
                "both",
                face("x_max").into_iter().chain(face("x_min").into_iter().map(|face| face.map(|node| node + count))),
            ),
            Group::point("point", vec![2, count]),
        ];
        let labels = (1..=2 * u64::from(count)).map(NodeLabel).collect();
        Mesh::new(coordinates, labels, elements, (1..=16).map(ElementLabel).collect(), groups).unwrap()
    }

    #[test]
    fn two_cubes_become_one_body_and_their_groups_follow() {
        let merged = two_cubes(1e-7).merged(2e-7).unwrap();
        assert_eq!((merged.node_count, merged.mesh.node_count()), (9, 45));
        assert!((merged.largest_distance - 1e-7).abs() < 1e-15);
        let mesh = &merged.mesh;
        assert!(QualityReport::new(mesh).errors().is_empty());
        let connectivity = Connectivity::new(mesh);
        assert_eq!((connectivity.bodies.len(), connectivity.bodies[0].piece_count), (1, 1));
        let group = |name: &str| mesh.group(name).unwrap();
        assert_eq!(group("from_left").nodes, group("from_right").nodes);
        assert_eq!((group("both").nodes.len(), group("both").faces.len()), (9, 4));
        assert_eq!((group("left").nodes.len(), group("right").nodes.len()), (27, 27));
        // node 3 and node 28, at (1, 0, 0), are one
        assert_eq!(group("point").nodes.len(), 1);
        // what stays is the first by label, where it was
        assert!(mesh.node_labels().contains(&NodeLabel(3)) && !mesh.node_labels().contains(&NodeLabel(28)));
        assert!(group("from_right").nodes.iter().all(|&node| mesh.node_labels()[node as usize] <= NodeLabel(27)));
        let interior = mesh.outward_faces(group("from_left"));
        assert!(interior.is_err(), "a load cannot act between the two cubes any more");
    }

    #[test]
    fn what_is_farther_away_stays_apart() {
        let mesh = two_cubes(1e-6);
        let merged = mesh.merged(0.9e-6).unwrap();
        assert_eq!((merged.node_count, merged.largest_distance), (0, 0.0));
        assert_eq!(merged.mesh, mesh);
    }

    #[test]
    fn the_order_of_the_file_does_not_matter() {
        let mesh = two_cubes(1e-7);
        let back: Vec<u32> = (0..mesh.node_count() as u32).rev().collect();
        let turned = mesh.renumbered(&Renumbering { old_nodes: back, old_elements: (0..16).rev().collect() });
        let [a, b] = [&mesh, &turned].map(|mesh| {
            let merged = mesh.merged(1e-6).unwrap().mesh;
            let mut nodes: Vec<_> = merged
                .node_labels()
                .iter()
                .zip(merged.coordinates())
                .map(|(label, x)| (label.0, x.map(f64::to_bits)))
                .collect();
            nodes.sort_unstable();
            let mut elements: Vec<_> = (0..16)
                .map(|element| {
                    let nodes =
                        merged.elements().nodes(element).iter().map(|&node| merged.node_labels()[node as usize].0);
                    (merged.element_labels()[element].0, nodes.collect::<Vec<_>>())
                })
                .collect();
            elements.sort_unstable();
            (nodes, elements)
        });
        assert_eq!(a, b);
        assert_eq!(locality_order(&turned).old_nodes.len(), mesh.node_count());
    }

    #[test]
    fn an_element_that_would_collapse_is_named() {
        let error = two_cubes(0.0).merged(0.5).unwrap_err();
        let MergeError::Collapse { element, distance, count, .. } = error else { panic!("{error}") };
        assert_eq!((element, distance, count), (ElementLabel(1), 0.5, 16));
        let text = error.to_string();
        assert!(text.contains("element 1, which are 5e-1 m apart; 16 elements would collapse so"), "{text}");
    }

    #[test]
    fn chains_are_merged_as_one_and_collapse_when_they_span_an_element() {
        // single hexes in a row, each a third of the tolerance from the next, join from the first to the last
        let hex = box_mesh(&BoxSpec::new([1.0; 3], [1; 3]).unwrap());
        let (mut coordinates, mut hexes) = (Vec::new(), Vec::new());
        for copy in 0..4_u32 {
            coordinates.extend(hex.coordinates().iter().map(|x| [x[0] + 0.1 * f64::from(copy), x[1], x[2]]));
            hexes.push(std::array::from_fn(|k| hex.elements().nodes(0)[k] + 8 * copy));
        }
        let labels = (1..=32).map(NodeLabel).collect();
        let mesh = Mesh::new(coordinates, labels, hexes, (1..=4).map(ElementLabel).collect(), vec![]).unwrap();
        let merged = mesh.merged(0.15).unwrap();
        assert_eq!(merged.mesh.node_count(), 8);
        assert!((merged.largest_distance - 0.3).abs() < 1e-12);
    }

    #[test]
    fn very_many_nodes_at_one_place_are_refused() {
        let (count, one) = (2000_u32, box_mesh(&BoxSpec::new([1.0; 3], [1; 3]).unwrap()));
        let coordinates = (0..count).flat_map(|_| one.coordinates().to_vec()).collect();
        let hexes: Vec<[u32; 8]> =
            (0..count).map(|copy| std::array::from_fn(|k| one.elements().nodes(0)[k] + 8 * copy)).collect();
        let labels = (1..=u64::from(8 * count)).map(NodeLabel).collect();
        let mesh =
            Mesh::new(coordinates, labels, hexes, (1..=u64::from(count)).map(ElementLabel).collect(), vec![]).unwrap();
        assert_eq!(mesh.merged(1e-6), Err(MergeError::Crowded { tolerance: 1e-6, node: NodeLabel(1) }));
    }
}
