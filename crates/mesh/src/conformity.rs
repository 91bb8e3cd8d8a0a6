//! Where elements lie on one another without being joined: nodes at one place, faces that share nodes but not their shape, nodes
//! on faces that do not have them, pieces that only touch at edges or nodes.
//!
//! All of it is on outer faces, so that the search is cheap. Lengths are judged by the faces at hand: "on" means within
//! [`GAP`] of the shortest length there.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use nalgebra::Vector3;
use rayon::prelude::*;

use crate::body::DisjointSets;
use crate::point_tree::PointTree;
use crate::points::{difference, distance};
use crate::quality::volume;
use crate::{Connectivity, ElementLabel, Face, Mesh, NodeLabel, OuterFace};

/// What lies within this share of the shortest length of a face lies on it: of its edges, its height, and the thickness of its
/// element.
pub const GAP: f64 = 0.01;
/// So many nodes at one place are looked at to find the first of them; of more, an earlier one will do.
const MOST_AT_ONE_PLACE: usize = 64;
/// Triangles at one edge that are looked at in pairs.
const MOST_AT_ONE_EDGE: usize = 16;
/// Triangles that turn less than this (the cosine) make a quad together.
const FLAT: f64 = 0.5;

/// A node at the place of another, to which it is not joined.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoincidentNode {
    /// The node.
    pub node: NodeLabel,
    /// The node with the least label at the place.
    pub other: NodeLabel,
    /// Where the node is.
    pub position: [f64; 3],
    /// How far the two are from each other.
    pub distance: f64,
    /// How long the shortest edge, or height, of the faces there is.
    pub length: f64,
}

/// Two ways in which the elements on either side of a face divide it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum MismatchKind {
    /// A quad on two triangles.
    QuadOnTriangles,
    /// Two triangles on two others, with the other diagonal of the four nodes.
    CrossedDiagonals,
    /// Two triangles with the same corners but not the same nodes between them.
    MiddleNodes,
}

/// A face on which two elements share the corners, but do not move alike between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mismatch {
    /// What does not match.
    pub kind: MismatchKind,
    /// An element on either side.
    pub elements: [ElementLabel; 2],
    /// The mean of the corners.
    pub centre: [f64; 3],
}

/// A node on a face that does not have it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HangingNode {
    /// The node.
    pub node: NodeLabel,
    /// Where it is.
    pub position: [f64; 3],
    /// The element of the face; of several the one with the least label.
    pub element: ElementLabel,
    /// Whether node and face are of two bodies, which share no node.
    pub is_between_bodies: bool,
}

/// A node that alone, or with others along an edge, joins pieces of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HingeNode {
    /// The node.
    pub node: NodeLabel,
    /// Where it is.
    pub position: [f64; 3],
}

/// Where elements lie on one another without being joined as elements of one body are. Nodes by label, faces by the labels
/// of their elements: the order of the file does not matter.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Conformity {
    /// Nodes at the place of another, each but the first of a place.
    pub coincident: Vec<CoincidentNode>,
    /// Faces that two elements divide in two ways.
    pub mismatches: Vec<Mismatch>,
    /// Nodes on faces that do not have them.
    pub hanging: Vec<HangingNode>,
    /// How many faces have such nodes on them.
    pub faces_with_hanging_nodes: usize,
    /// Nodes at which pieces of a body hang together that share no face.
    pub hinges: Vec<HingeNode>,
}

impl Conformity {
    /// That of a mesh of sound elements.
    pub fn new(mesh: &Mesh, connectivity: &Connectivity) -> Self {
        Search::new(mesh, connectivity).conformity()
    }

    /// Whether there is nothing of the kind.
    pub fn is_whole(&self) -> bool {
        self.coincident.is_empty() && self.mismatches.is_empty() && self.hanging.is_empty() && self.hinges.is_empty()
    }
}

/// What the search looks at again and again.
struct Search<'a> {
    mesh: &'a Mesh,
    connectivity: &'a Connectivity,
    faces: &'a [OuterFace],
    /// The nodes of outer faces.
    nodes: Vec<u32>,
    /// Of each outer face, the shortest length there.
    lengths: Vec<f64>,
    /// Of each node, the shortest of its outer faces; infinite inside.
    node_lengths: Vec<f64>,
}

/// Four nodes that are a quad, or two triangles side by side.
struct Patch {
    nodes: [u32; 4],
    /// The nodes that the two triangles share; of a quad none.
    diagonal: Option<[u32; 2]>,
    area: Vector3<f64>,
    face: usize,
}

impl<'a> Search<'a> {
    fn new(mesh: &'a Mesh, connectivity: &'a Connectivity) -> Self {
        let faces = &connectivity.outer_faces[..];
        let lengths: Vec<f64> = faces.par_iter().map(|outer| shortest_length(mesh, outer)).collect();
        let mut node_lengths = vec![f64::INFINITY; mesh.node_count()];
        for (outer, &length) in faces.iter().zip(&lengths) {
            for &node in outer.face.nodes() {
                node_lengths[node as usize] = node_lengths[node as usize].min(length);
            }
        }
        Self { mesh, connectivity, faces, nodes: connectivity.outer_nodes(mesh), lengths, node_lengths }
    }

    fn conformity(&self) -> Conformity {
        let (coincident, is_coincident) = self.coincident();
        let mismatched = self.mismatched();
        let hanging = self.hanging(&is_coincident);
        let hinges = self.hinges(&mismatched, &hanging);
        let mut found = Conformity {
            coincident,
            mismatches: mismatched.iter().map(|(kind, faces)| self.mismatch(*kind, *faces)).collect(),
            ..Conformity::default()
        };
        let mut of_faces: Vec<usize> = hanging.iter().map(|&(face, _)| face).collect();
        of_faces.dedup();
        found.faces_with_hanging_nodes = of_faces.len();
        found.hanging = self.hanging_nodes(&hanging);
        found.hinges = hinges;
        found.coincident.sort_by_key(|coincident| coincident.node);
        found.mismatches.sort_by_key(|mismatch| (mismatch.elements, mismatch.kind));
        found.hinges.sort_by_key(|hinge| hinge.node);
        found
    }

    fn position(&self, node: u32) -> [f64; 3] {
        self.mesh.coordinates()[node as usize]
    }

    fn label(&self, node: u32) -> NodeLabel {
        self.mesh.node_labels()[node as usize]
    }

    fn corners(&self, face: usize) -> Vec<[f64; 3]> {
        corners(&self.faces[face].face).iter().map(|&node| self.position(node)).collect()
    }

    fn tree(&self, nodes: impl Iterator<Item = u32>) -> PointTree {
        PointTree::new(nodes.map(|node| (self.position(node), node)).collect())
    }

    /// The nodes at the place of one with a smaller label; and which nodes are at the place of any other.
    fn coincident(&self) -> (Vec<CoincidentNode>, Vec<bool>) {
        let tree = self.tree(self.nodes.iter().copied());
        let partner = |&node: &u32| -> Option<(u32, CoincidentNode)> {
            let (position, label) = (self.position(node), self.label(node));
            let length = self.node_lengths[node as usize];
            let reach = GAP * length;
            let (mut count, mut first) = (0, None);
            tree.in_box(&position.map(|x| x - reach), &position.map(|x| x + reach), |other, place| {
                let distance = distance(place, &position);
                let shorter = length.min(self.node_lengths[other as usize]);
                if other != node && distance <= GAP * shorter {
                    count += 1;
                    let found =
                        CoincidentNode { node: label, other: self.label(other), position, distance, length: shorter };
                    if first.is_none_or(|first: CoincidentNode| found.other < first.other) {
                        first = Some(found);
                    }
                }
                let is_later = first.is_some_and(|first| first.other < label);
                if count < MOST_AT_ONE_PLACE || !is_later { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
            });
            first.map(|first| (node, first))
        };
        let found: Vec<(u32, CoincidentNode)> = self.nodes.par_iter().filter_map(partner).collect();
        let mut is_coincident = vec![false; self.mesh.node_count()];
        for (node, _) in &found {
            is_coincident[*node as usize] = true;
        }
        let later = found.into_iter().map(|(_, found)| found).filter(|found| found.other < found.node);
        (later.collect(), is_coincident)
    }

    /// Outer faces that lie on one another with the same corners.
    fn mismatched(&self) -> Vec<(MismatchKind, [usize; 2])> {
        let is_triangle = |face: &Face| !matches!(face, Face::Quad4(_));
        if !self.faces.iter().any(|outer| is_triangle(&outer.face)) {
            return Vec::new();
        }
        let area = |face: usize| area(&self.corners(face));
        let triangles = || (0..self.faces.len()).filter(|&face| is_triangle(&self.faces[face].face));
        let mut edges: Vec<([u32; 2], u32, usize)> = triangles()
            .flat_map(|face| {
                let of_face = corners(&self.faces[face].face);
                (0..3).map(move |k| (ascending([of_face[k], of_face[(k + 1) % 3]]), of_face[(k + 2) % 3], face))
            })
            .collect();
        edges.par_sort_unstable();
        let mut patches: Vec<Patch> = Vec::new();
        for at_edge in edges.chunk_by(|a, b| a.0 == b.0) {
            let at_edge = &at_edge[..at_edge.len().min(MOST_AT_ONE_EDGE)];
            for (k, &(diagonal, tip, face)) in at_edge.iter().enumerate() {
                for &(_, other_tip, other) in &at_edge[..k] {
                    let areas = [area(face), area(other)];
                    if tip != other_tip && areas[0].dot(&areas[1]) > FLAT * areas[0].norm() * areas[1].norm() {
                        let nodes = ascending([diagonal[0], diagonal[1], tip, other_tip]);
                        let area = areas[0] + areas[1];
                        patches.push(Patch { nodes, diagonal: Some(diagonal), area, face: face.min(other) });
                    }
                }
            }
        }
        for (face, outer) in self.faces.iter().enumerate() {
            if let Face::Quad4(nodes) = outer.face {
                patches.push(Patch { nodes: ascending(nodes), diagonal: None, area: area(face), face });
            }
        }
        patches.sort_unstable_by_key(|patch| (patch.nodes, patch.diagonal, patch.face));
        let mut found = Vec::new();
        for same in patches.chunk_by(|a, b| a.nodes == b.nodes) {
            let [first, ..] = same else { continue };
            let across = |patch: &&Patch| patch.diagonal != first.diagonal && patch.area.dot(&first.area) < 0.0;
            if let Some(other) = same.iter().find(across) {
                let kind = match first.diagonal {
                    None => MismatchKind::QuadOnTriangles,
                    Some(_) => MismatchKind::CrossedDiagonals,
                };
                found.push((kind, [first.face, other.face]));
            }
        }
        let mut by_corners: Vec<([u32; 3], usize)> = triangles()
            .map(|face| {
                let of_face = corners(&self.faces[face].face);
                (ascending([of_face[0], of_face[1], of_face[2]]), face)
            })
            .collect();
        by_corners.par_sort_unstable();
        for same in by_corners.chunk_by(|a, b| a.0 == b.0) {
            if let [first, second, ..] = same
                && area(first.1).dot(&area(second.1)) < 0.0
            {
                found.push((MismatchKind::MiddleNodes, [first.1, second.1]));
            }
        }
        found
    }

    fn mismatch(&self, kind: MismatchKind, faces: [usize; 2]) -> Mismatch {
        let mut nodes: Vec<u32> = faces.iter().flat_map(|&face| corners(&self.faces[face].face)).copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        let mean = |axis| nodes.iter().map(|&node| self.position(node)[axis] / nodes.len() as f64).sum();
        let elements = faces.map(|face| self.mesh.element_labels()[self.faces[face].element as usize]);
        Mismatch { kind, elements: ascending(elements), centre: std::array::from_fn(mean) }
    }

    /// Faces, in ascending order, with nodes on them that are not theirs.
    fn hanging(&self, is_coincident: &[bool]) -> Vec<(usize, u32)> {
        // where nodes of two meshes coincide the faces do not hang, they are not joined
        let tree = self.tree(self.nodes.iter().copied().filter(|&node| !is_coincident[node as usize]));
        let on_face = |face: usize| {
            let own = self.faces[face].face;
            let corners = self.corners(face);
            let reach = GAP * self.lengths[face];
            let low = std::array::from_fn(|axis| corners.iter().map(|x| x[axis]).fold(f64::INFINITY, f64::min) - reach);
            let high =
                std::array::from_fn(|axis| corners.iter().map(|x| x[axis]).fold(f64::NEG_INFINITY, f64::max) + reach);
            let mut found = Vec::new();
            tree.in_box(&low, &high, |node, position| {
                let reach = GAP * self.lengths[face].min(self.node_lengths[node as usize]);
                let is_apart = |&own: &u32| own != node && distance(&self.position(own), position) > reach;
                if own.nodes().iter().all(is_apart) && is_on(position, &corners, reach) {
                    found.push((face, node));
                }
                ControlFlow::Continue(())
            });
            found
        };
        (0..self.faces.len()).into_par_iter().flat_map_iter(on_face).collect()
    }

    fn hanging_nodes(&self, found: &[(usize, u32)]) -> Vec<HangingNode> {
        let bodies = &self.connectivity.body_of_element;
        let mut body_of_node = BTreeMap::new();
        if self.connectivity.bodies.len() > 1 && !found.is_empty() {
            for outer in self.faces {
                for &node in outer.face.nodes() {
                    body_of_node.insert(node, bodies[outer.element as usize]);
                }
            }
        }
        let mut nodes: BTreeMap<NodeLabel, HangingNode> = BTreeMap::new();
        for &(face, node) in found {
            let index = self.faces[face].element as usize;
            let element = self.mesh.element_labels()[index];
            let is_between_bodies = body_of_node.get(&node).is_some_and(|body| *body != bodies[index]);
            let (label, position) = (self.label(node), self.position(node));
            let hanging = HangingNode { node: label, position, element, is_between_bodies };
            let known = nodes.entry(label).or_insert(hanging);
            if element < known.element {
                *known = hanging;
            }
        }
        nodes.into_values().collect()
    }

    /// Nodes of pieces that no face joins, neither a shared one nor one that does not match.
    fn hinges(&self, mismatched: &[(MismatchKind, [usize; 2])], hanging: &[(usize, u32)]) -> Vec<HingeNode> {
        if self.connectivity.bodies.iter().all(|body| body.piece_count < 2) {
            return Vec::new();
        }
        let piece = |face: usize| self.connectivity.piece_of_element[self.faces[face].element as usize];
        let mut sets = DisjointSets::new(self.connectivity.bodies.iter().map(|body| body.piece_count).sum());
        for &(_, [a, b]) in mismatched {
            sets.join(piece(a), piece(b));
        }
        let mut piece_of_node = vec![None; self.mesh.node_count()];
        for (face, outer) in self.faces.iter().enumerate() {
            for &node in outer.face.nodes() {
                piece_of_node[node as usize] = Some(piece(face));
            }
        }
        for &(face, node) in hanging {
            if let Some(of_node) = piece_of_node[node as usize] {
                sets.join(piece(face), of_node);
            }
        }
        let mut is_hinge = vec![false; self.mesh.node_count()];
        for (face, outer) in self.faces.iter().enumerate() {
            for &node in outer.face.nodes() {
                if let Some(other) = piece_of_node[node as usize]
                    && sets.first(piece(face)) != sets.first(other)
                {
                    is_hinge[node as usize] = true;
                }
            }
        }
        let hinges = self.nodes.iter().filter(|&&node| is_hinge[node as usize]);
        hinges.map(|&node| HingeNode { node: self.label(node), position: self.position(node) }).collect()
    }
}

/// The corners of a face.
fn corners(face: &Face) -> &[u32] {
    match face {
        Face::Triangle6(nodes) => &nodes[..3],
        other => other.nodes(),
    }
}

/// The shortest of the edges of a face, its height, and the thickness of its element.
fn shortest_length(mesh: &Mesh, outer: &OuterFace) -> f64 {
    let corners: Vec<[f64; 3]> = corners(&outer.face).iter().map(|&node| mesh.coordinates()[node as usize]).collect();
    let edges = (0..corners.len()).map(|k| distance(&corners[k], &corners[(k + 1) % corners.len()]));
    let (shortest, longest) = edges.fold((f64::INFINITY, 0.0), |(least, most), edge| (edge.min(least), edge.max(most)));
    let area = area(&corners).norm();
    let element = outer.element as usize;
    let volume = volume(mesh.elements().shape(element), &mesh.positions(element));
    shortest.min(area / longest).min(volume / area)
}

/// Normal of a triangle or quad, as long as it is large.
fn area(corners: &[[f64; 3]]) -> Vector3<f64> {
    let to = |a: usize, b: usize| difference(&corners[b], &corners[a]);
    // of a quad half the product of the diagonals
    let (first, second) = if corners.len() == 4 { (to(0, 2), to(1, 3)) } else { (to(0, 1), to(0, 2)) };
    0.5 * first.cross(&second)
}

/// Whether a point lies within `reach` of a triangle or quad.
fn is_on(point: &[f64; 3], corners: &[[f64; 3]], reach: f64) -> bool {
    let on_triangle = |places: [usize; 3]| {
        let triangle = places.map(|place| corners[place]);
        let normal = area(&triangle).normalize();
        let height = difference(point, &triangle[0]).dot(&normal);
        let is_inside = |k: usize| {
            let edge = difference(&triangle[(k + 1) % 3], &triangle[k]);
            edge.cross(&difference(point, &triangle[k])).dot(&normal) >= -reach * edge.norm()
        };
        height.abs() <= reach && (0..3).all(is_inside)
    };
    on_triangle([0, 1, 2]) || corners.len() == 4 && on_triangle([0, 2, 3])
}

fn ascending<T: Ord, const N: usize>(mut values: [T; N]) -> [T; N] {
    values.sort_unstable();
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::{BoxSpec, box_mesh, cut_into};
    use crate::{Elements, Shape};

    fn cells(counts: [u32; 3]) -> Mesh {
        box_mesh(&BoxSpec::new([1.0; 3], counts).unwrap())
    }

    /// One mesh beside another, which is moved; nodes at one place become one node where `is_joined`.
    fn beside(first: &Mesh, second: &Mesh, shift: [f64; 3], is_joined: bool) -> Mesh {
        let mut coordinates = first.coordinates().to_vec();
        let mut nodes = Vec::new();
        for position in second.coordinates() {
            let moved: [f64; 3] = std::array::from_fn(|axis| position[axis] + shift[axis]);
            let known = first.coordinates().iter().position(|x| is_joined && distance(x, &moved) < 1e-9);
            nodes.push(known.unwrap_or(coordinates.len()) as u32);
            if known.is_none() {
                coordinates.push(moved);
            }
        }
        let mut elements = first.elements().clone();
        for element in 0..second.element_count() {
            let of_element: Vec<u32> =
                second.elements().nodes(element).iter().map(|&node| nodes[node as usize]).collect();
            elements.push(second.elements().shape(element), &of_element);
        }
        let labels = (0..coordinates.len() as u64).map(|k| NodeLabel(1000 - k)).collect();
        let element_labels = (1..=elements.len() as u64).map(ElementLabel).collect();
        Mesh::new(coordinates, labels, elements, element_labels, vec![]).unwrap()
    }

    fn conformity(mesh: &Mesh) -> Conformity {
        Conformity::new(mesh, &Connectivity::new(mesh))
    }

    #[test]
    fn conforming_meshes_of_every_shape_are_whole() {
        for shape in [Shape::Hex8, Shape::Wedge6, Shape::Tet4, Shape::Tet10] {
            let mesh = cells([3, 4, 2]);
            let mesh = if shape == Shape::Hex8 { mesh } else { cut_into(&mesh, shape) };
            assert_eq!(conformity(&mesh), Conformity::default(), "{shape}");
            let joined = beside(&mesh, &mesh, [0.0, 0.0, 1.0], true);
            assert_eq!(conformity(&joined), Conformity::default(), "{shape}");
        }
    }

    #[test]
    fn nodes_at_one_place_are_found_with_their_distance() {
        let offset = 1e-4;
        let mesh = beside(&cells([2; 3]), &cells([2; 3]), [1.0, 0.0, offset], false);
        let found = conformity(&mesh);
        assert_eq!((found.coincident.len(), found.hanging.len(), found.mismatches.len()), (9, 0, 0));
        for coincident in &found.coincident {
            assert!((coincident.distance - offset).abs() < 1e-15 && coincident.position[0] == 1.0, "{coincident:?}");
            assert!(coincident.other < coincident.node);
        }
        // a gap of 2 % of an edge is one
        assert!(conformity(&beside(&cells([2; 3]), &cells([2; 3]), [1.01, 0.0, 0.0], false)).is_whole());
    }

    #[test]
    fn a_quad_on_two_triangles_is_found() {
        let tets = cut_into(&cells([2, 2, 1]), Shape::Tet4);
        let found = conformity(&beside(&cells([2, 2, 1]), &tets, [0.0, 0.0, 1.0], true));
        assert_eq!((found.mismatches.len(), found.coincident.len(), found.hanging.len()), (4, 0, 0));
        assert!(found.hinges.is_empty());
        for mismatch in &found.mismatches {
            assert_eq!((mismatch.kind, mismatch.centre[2]), (MismatchKind::QuadOnTriangles, 1.0));
            assert!(mismatch.elements[0] <= ElementLabel(4) && mismatch.elements[1] > ElementLabel(4));
        }
    }

    #[test]
    fn crossed_diagonals_are_found() {
        let tets = cut_into(&cells([2, 2, 1]), Shape::Tet4);
        // mirrored in x, with the order of its nodes turned
        let mut mirrored = Elements::default();
        for nodes in tets.elements().iter() {
            mirrored.push(Shape::Tet4, &[nodes[0], nodes[2], nodes[1], nodes[3]]);
        }
        let coordinates = tets.coordinates().iter().map(|x| [1.0 - x[0], x[1], x[2]]).collect();
        let labels = tets.element_labels().to_vec();
        let mirrored = Mesh::new(coordinates, tets.node_labels().to_vec(), mirrored, labels, vec![]).unwrap();
        let found = conformity(&beside(&tets, &mirrored, [0.0, 0.0, 1.0], true));
        let kinds: Vec<_> = found.mismatches.iter().map(|mismatch| mismatch.kind).collect();
        assert_eq!((kinds, found.hanging.len()), (vec![MismatchKind::CrossedDiagonals; 4], 0));
        // a tet alone has four nodes with triangles on either diagonal, too, but they are not flat
        let mut single = Elements::default();
        single.push(Shape::Tet4, &[0, 1, 2, 3]);
        let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let single =
            Mesh::new(corners, (1..5).map(NodeLabel).collect(), single, vec![ElementLabel(1)], vec![]).unwrap();
        assert!(conformity(&single).is_whole());
    }

    #[test]
    fn triangles_with_and_without_middle_nodes_do_not_match() {
        let tets = cut_into(&cells([1; 3]), Shape::Tet4);
        let curved = cut_into(&cells([1; 3]), Shape::Tet10);
        let found = conformity(&beside(&curved, &tets, [0.0, 0.0, 1.0], true));
        let kinds: Vec<_> = found.mismatches.iter().map(|mismatch| mismatch.kind).collect();
        assert_eq!(kinds, [MismatchKind::MiddleNodes; 2]);
    }

    #[test]
    fn hanging_nodes_are_found_on_faces_and_edges() {
        // 2 × 2 faces on one: corners are shared, one node is inside and four are on edges
        let found = conformity(&beside(&cells([1; 3]), &cells([2; 3]), [0.0, 0.0, 1.0], true));
        assert_eq!((found.hanging.len(), found.coincident.len(), found.hinges.len()), (5, 0, 0));
        // the top of the coarse cube and its four sides, whose upper edges have the nodes
        assert_eq!(found.faces_with_hanging_nodes, 5);
        assert!(found.hanging.iter().all(|hanging| hanging.position[2] == 1.0 && hanging.element == ElementLabel(1)));
        assert!(found.hanging.iter().all(|hanging| !hanging.is_between_bodies));
    }

    #[test]
    fn bodies_that_lie_on_one_another_with_other_nodes_are_found() {
        let found = conformity(&beside(&cells([2; 3]), &cells([3; 3]), [1.0, 0.0, 0.0], false));
        // four corners coincide; of 16 and 9 nodes the others lie on faces of the other body
        assert_eq!((found.coincident.len(), found.hanging.len()), (4, 12 + 5));
        assert!(found.hanging.iter().all(|hanging| hanging.is_between_bodies && hanging.position[0] == 1.0));
    }

    #[test]
    fn pieces_that_share_an_edge_are_a_hinge() {
        let found = conformity(&beside(&cells([1, 1, 2]), &cells([1, 1, 2]), [1.0, 1.0, 0.0], true));
        let places: Vec<_> = found.hinges.iter().map(|hinge| hinge.position).collect();
        assert_eq!(places.len(), 3);
        assert!(places.iter().all(|place| place[0] == 1.0 && place[1] == 1.0));
        assert!(found.mismatches.is_empty() && found.hanging.is_empty() && found.coincident.is_empty());
    }

    #[test]
    fn thin_layers_and_flat_elements_are_whole() {
        // a sheet a thousand times wider than thick, and tets of it
        let sheet = box_mesh(&BoxSpec::new([1.0, 1.0, 1e-4], [10, 10, 2]).unwrap());
        assert!(conformity(&sheet).is_whole());
        assert!(conformity(&cut_into(&sheet, Shape::Tet4)).is_whole());
        assert!(conformity(&cut_into(&sheet, Shape::Tet10)).is_whole());
    }

    #[test]
    fn what_is_found_does_not_depend_on_the_order_of_the_file() {
        let mesh = beside(&cells([2; 3]), &cells([3; 3]), [1.0, 0.0, 0.0], false);
        let other = mesh.renumbered(&crate::locality_order(&mesh));
        assert_ne!(mesh, other);
        assert_eq!(conformity(&mesh), conformity(&other));
    }

    #[test]
    fn very_many_nodes_at_one_place_and_huge_coordinates_end() {
        let one = cells([1; 3]);
        let mut coordinates = Vec::new();
        let mut hexes: Vec<[u32; 8]> = Vec::new();
        for copy in 0..5000_u32 {
            coordinates.extend_from_slice(one.coordinates());
            hexes.push(std::array::from_fn(|k| 8 * copy + one.elements().nodes(0)[k]));
        }
        let last = coordinates.len() - 1;
        coordinates[last] = [1e300; 3];
        let labels = (1..=coordinates.len() as u64).map(NodeLabel).collect();
        let element_labels = (1..=hexes.len() as u64).map(ElementLabel).collect();
        let found = conformity(&Mesh::new(coordinates, labels, hexes, element_labels, vec![]).unwrap());
        assert_eq!(found.coincident.len(), 8 * 4999 - 1);
    }
}
