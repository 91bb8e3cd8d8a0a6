//! A numbering in which neighbours in space are neighbours in memory.

use rayon::prelude::*;

use crate::mesh::Parts;
use crate::{Group, Mesh};

/// A new order of nodes and elements.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Renumbering {
    /// The old index of each new node.
    pub old_nodes: Vec<u32>,
    /// The old index of each new element.
    pub old_elements: Vec<u32>,
}

impl Renumbering {
    /// The new index of each old node.
    pub fn new_nodes(&self) -> Vec<u32> {
        inverse(&self.old_nodes)
    }

    /// The new index of each old element.
    pub fn new_elements(&self) -> Vec<u32> {
        inverse(&self.old_elements)
    }
}

fn inverse(permutation: &[u32]) -> Vec<u32> {
    let mut inverse = vec![0; permutation.len()];
    for (new, &old) in permutation.iter().enumerate() {
        inverse[old as usize] = new as u32;
    }
    inverse
}

/// Elements along a Hilbert curve through the means of their nodes, nodes in the order in which those elements first meet
/// them (nodes of no element come last). The same mesh always gives the same order: ties keep the old one.
pub fn locality_order(mesh: &Mesh) -> Renumbering {
    let [least, greatest] = mesh.extent();
    let side = (0..3).map(|axis| greatest[axis] - least[axis]).fold(f64::MIN_POSITIVE, f64::max);
    let mut keyed: Vec<(u64, u32)> = mesh
        .elements()
        .par_iter()
        .enumerate()
        .map(|(element, nodes)| {
            let count = nodes.len() as f64;
            let mut cell = [0; 3];
            for (axis, cell) in cell.iter_mut().enumerate() {
                let centre = nodes.iter().map(|&node| mesh.coordinates()[node as usize][axis] / count).sum::<f64>();
                // One cube for all axes keeps the curve's cells cubes, so that it is local in every direction alike.
                *cell = ((centre - least[axis]) / side * LAST_CELL) as u32;
            }
            (hilbert_index(cell), element as u32)
        })
        .collect();
    // no two are equal: the order does not depend on the threads
    keyed.par_sort_unstable();
    let old_elements: Vec<u32> = keyed.into_iter().map(|(_, element)| element).collect();

    let mut seen = vec![false; mesh.node_count()];
    let mut old_nodes = Vec::with_capacity(mesh.node_count());
    let by_use = old_elements.iter().flat_map(|&element| mesh.elements().nodes(element as usize)).copied();
    for node in by_use.chain(0..mesh.node_count() as u32) {
        if !std::mem::replace(&mut seen[node as usize], true) {
            old_nodes.push(node);
        }
    }
    Renumbering { old_nodes, old_elements }
}

/// Bits per axis of the Hilbert curve: three of them fill a `u64`.
const BITS: u32 = 21;
const LAST_CELL: f64 = ((1_u32 << BITS) - 1) as f64;

/// The position of a cell along the Hilbert curve.
/// J. Skilling, "Programming the Hilbert curve", AIP Conf. Proc. 707 (2004) 381-387.
fn hilbert_index(mut x: [u32; 3]) -> u64 {
    // (i) undo the curve's turns, from the coarsest level to the finest
    let mut level = 1_u32 << (BITS - 1);
    while level > 1 {
        let finer = level - 1;
        for axis in 0..3 {
            if x[axis] & level != 0 {
                x[0] ^= finer;
            } else {
                let swap = (x[0] ^ x[axis]) & finer;
                x[0] ^= swap;
                x[axis] ^= swap;
            }
        }
        level >>= 1;
    }
    // (ii) Gray encode
    x[1] ^= x[0];
    x[2] ^= x[1];
    let mut turned = 0;
    let mut level = 1_u32 << (BITS - 1);
    while level > 1 {
        if x[2] & level != 0 {
            turned ^= level - 1;
        }
        level >>= 1;
    }
    // (iii) interleave the bits
    let mut index = 0;
    for bit in (0..BITS).rev() {
        for value in x {
            index = index << 1 | u64::from((value ^ turned) >> bit & 1);
        }
    }
    index
}

impl Mesh {
    /// The same mesh in another order; labels and groups follow.
    pub fn renumbered(&self, renumbering: &Renumbering) -> Mesh {
        let new_nodes = renumbering.new_nodes();
        let new_elements = renumbering.new_elements();
        let node = |old: u32| new_nodes[old as usize];
        let sorted = |mut indices: Vec<u32>| {
            indices.sort_unstable();
            indices
        };
        let (old_nodes, old_elements) = (&renumbering.old_nodes, &renumbering.old_elements);
        Mesh::of(Parts {
            coordinates: old_nodes.par_iter().map(|&old| self.coordinates()[old as usize]).collect(),
            node_labels: old_nodes.par_iter().map(|&old| self.node_labels()[old as usize]).collect(),
            elements: self.elements().reordered(old_elements, node),
            element_labels: old_elements.par_iter().map(|&old| self.element_labels()[old as usize]).collect(),
            groups: self
                .groups()
                .iter()
                .map(|group| Group {
                    name: group.name.clone(),
                    owners: group.owners.clone(),
                    kind: group.kind,
                    nodes: sorted(group.nodes.iter().map(|&old| node(old)).collect()),
                    elements: sorted(group.elements.iter().map(|&old| new_elements[old as usize]).collect()),
                    faces: group.faces.iter().map(|face| face.map(node)).collect(),
                })
                .collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::{BoxSpec, box_mesh};

    /// The mean over hexes of the distance in memory between a hex's first and last node.
    fn mean_span(mesh: &Mesh) -> f64 {
        let span = |hex: &[u32]| f64::from(hex.iter().max().unwrap() - hex.iter().min().unwrap());
        mesh.elements().iter().map(span).sum::<f64>() / mesh.element_count() as f64
    }

    #[test]
    fn consecutive_cells_of_the_hilbert_curve_are_neighbours() {
        let mut cells: Vec<[u32; 3]> =
            (0..8).flat_map(|x| (0..8).flat_map(move |y| (0..8).map(move |z| [x, y, z]))).collect();
        cells.sort_by_key(|&cell| hilbert_index(cell));
        for pair in cells.windows(2) {
            let distance: u32 = (0..3).map(|axis| pair[0][axis].abs_diff(pair[1][axis])).sum();
            assert_eq!(distance, 1, "{pair:?}");
        }
    }

    #[test]
    fn renumbering_is_a_permutation_that_keeps_labels_geometry_and_groups() {
        let mesh = box_mesh(&BoxSpec::new([1.0, 2.0, 3.0], [5, 6, 7]).unwrap());
        let renumbering = locality_order(&mesh);
        assert_eq!(renumbering, locality_order(&mesh));
        let new = mesh.renumbered(&renumbering);
        let mut labels = new.node_labels().to_vec();
        labels.sort();
        assert_eq!(labels, mesh.node_labels());
        for (hex, label) in new.element_labels().iter().enumerate() {
            assert_eq!(new.positions(hex), mesh.positions((label.0 - 1) as usize));
        }
        for (old, new_group) in mesh.groups().iter().zip(new.groups()) {
            let back = |nodes: &[u32]| {
                let mut old: Vec<u32> = nodes.iter().map(|&n| renumbering.old_nodes[n as usize]).collect();
                old.sort_unstable();
                old
            };
            assert_eq!(back(&new_group.nodes), old.nodes);
            assert_eq!((&new_group.name, new_group.faces.len()), (&old.name, old.faces.len()));
            assert_eq!(new.outward_faces(new_group).is_ok(), old.kind == new_group.kind);
        }
        let undo = Renumbering { old_nodes: renumbering.new_nodes(), old_elements: renumbering.new_elements() };
        assert_eq!(new.renumbered(&undo), mesh);
    }

    #[test]
    fn the_locality_order_brings_a_hex_s_nodes_together() {
        let mesh = box_mesh(&BoxSpec::new([1.0; 3], [24; 3]).unwrap());
        let median = |mesh: &Mesh| {
            let mut spans: Vec<u32> =
                mesh.elements().iter().map(|hex| hex.iter().max().unwrap() - hex.iter().min().unwrap()).collect();
            spans.sort_unstable();
            spans[spans.len() / 2]
        };
        let new = mesh.renumbered(&locality_order(&mesh));
        assert!(mean_span(&mesh) > 600.0);
        assert!(median(&new) < median(&mesh) / 2, "{} against {}", median(&new), median(&mesh));
    }
}
