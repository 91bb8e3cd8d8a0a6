//! The shapes of elements and the numbering of their nodes, which is that of VTK; Gmsh and Abaqus have the same but for the
//! last two nodes of Gmsh's ten-node tet. Hexes are drawn in [`hex`](crate::hex).
//!
//! ```text
//!   wedge6           pyramid5           tet4            tet10: the same corners, then the middles of
//!
//!      5                 4                3             the edges 01, 12, 20, 03, 13, 23
//!     /|\               /|\              /|\
//!    3---4             / | \            / | \
//!    | 2 |            3--|--2          0--|--2
//!    |/ \|           /   | /            \ | /
//!    0---1          0------1              1
//! ```
//!
//! Seen from the nodes that come last, the first three or four run counter-clockwise.

use std::fmt;

use arrayvec::ArrayVec;

use crate::hex;

/// No shape has more nodes.
pub const MOST_NODES: usize = 10;

/// What an element looks like.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Shape {
    /// Hexahedron of eight nodes.
    Hex8,
    /// Wedge of six nodes.
    Wedge6,
    /// Pyramid of five nodes.
    Pyramid5,
    /// Tetrahedron of four nodes.
    Tet4,
    /// Tetrahedron of four corners and the middles of its edges.
    Tet10,
}

/// Nodes of an element.
pub type ElementNodes = ArrayVec<u32, MOST_NODES>;

impl Shape {
    /// Every shape.
    pub const ALL: [Self; 5] = [Self::Hex8, Self::Wedge6, Self::Pyramid5, Self::Tet4, Self::Tet10];

    /// How many nodes it has.
    pub const fn node_count(self) -> usize {
        match self {
            Self::Hex8 => 8,
            Self::Wedge6 => 6,
            Self::Pyramid5 => 5,
            Self::Tet4 => 4,
            Self::Tet10 => 10,
        }
    }

    /// What many of it are called.
    pub const fn plural(self) -> &'static str {
        match self {
            Self::Hex8 => "hexes",
            Self::Wedge6 => "wedges",
            Self::Pyramid5 => "pyramids",
            Self::Tet4 => "4-node tets",
            Self::Tet10 => "10-node tets",
        }
    }

    /// What one of it is called.
    pub const fn singular(self) -> &'static str {
        match self {
            Self::Hex8 => "hex",
            Self::Wedge6 => "wedge",
            Self::Pyramid5 => "pyramid",
            Self::Tet4 => "4-node tet",
            Self::Tet10 => "10-node tet",
        }
    }

    /// The nodes of each face, such that the right-hand normal points out of the element; the middles of edges follow the
    /// corners.
    pub const fn faces(self) -> &'static [&'static [usize]] {
        match self {
            Self::Hex8 => &[&[0, 3, 2, 1], &[4, 5, 6, 7], &[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7, 6], &[3, 0, 4, 7]],
            Self::Wedge6 => &[&[0, 2, 1], &[3, 4, 5], &[0, 1, 4, 3], &[1, 2, 5, 4], &[2, 0, 3, 5]],
            Self::Pyramid5 => &[&[0, 3, 2, 1], &[0, 1, 4], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4]],
            Self::Tet4 => &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]],
            Self::Tet10 => &[&[0, 2, 1, 6, 5, 4], &[0, 1, 3, 4, 8, 7], &[1, 2, 3, 5, 9, 8], &[2, 0, 3, 6, 7, 9]],
        }
    }

    /// Corners and, of each, three neighbours that form a right-handed triad.
    pub const fn corner_neighbours(self) -> &'static [[usize; 3]] {
        match self {
            Self::Hex8 => &hex::CORNER_NEIGHBOURS,
            Self::Wedge6 => &[[1, 2, 3], [2, 0, 4], [0, 1, 5], [5, 4, 0], [3, 5, 1], [4, 3, 2]],
            // at the top the faces meet two by two, of which the corners below take care
            Self::Pyramid5 => &[[1, 3, 4], [2, 0, 4], [3, 1, 4], [0, 2, 4]],
            Self::Tet4 | Self::Tet10 => &[[1, 2, 3], [2, 0, 3], [0, 1, 3], [1, 0, 2]],
        }
    }

    /// The node in the middle of the edge between two corners, if the shape has one.
    pub const fn middle(self, corner: usize, other: usize) -> Option<usize> {
        if !matches!(self, Self::Tet10) {
            return None;
        }
        Some(match (corner, other) {
            (0, 1) | (1, 0) => 4,
            (1, 2) | (2, 1) => 5,
            (0, 2) | (2, 0) => 6,
            (0, 3) | (3, 0) => 7,
            (1, 3) | (3, 1) => 8,
            _ => 9,
        })
    }

    /// The node at each corner of the hex that has this shape where some of its corners fall together; no tet is such a hex.
    pub const fn corners_of_hex(self) -> Option<&'static [usize; 8]> {
        match self {
            Self::Hex8 => Some(&[0, 1, 2, 3, 4, 5, 6, 7]),
            Self::Wedge6 => Some(&[0, 1, 2, 2, 3, 4, 5, 5]),
            Self::Pyramid5 => Some(&[0, 1, 2, 3, 4, 4, 4, 4]),
            Self::Tet4 | Self::Tet10 => None,
        }
    }

    /// The shape and the nodes of a hex some of whose corners are one node: a wedge, a pyramid, a tet, or the hex itself where
    /// it is none of them.
    pub fn of_hex(nodes: &[u32; 8]) -> (Self, ElementNodes) {
        let distinct = (1..8).filter(|&corner| !nodes[..corner].contains(&nodes[corner])).count() + 1;
        for face in Self::Hex8.faces().iter().filter(|_| distinct < 8) {
            for turn in 0..2 {
                // p q r s round the face, and what they are joined to through the hex
                let corners: [usize; 4] = std::array::from_fn(|k| face[(k + turn) % 4]);
                let [p, q, r, s] = corners.map(|corner| nodes[corner]);
                let [a, b, c, d] = corners.map(|corner| {
                    let behind = hex::CORNER_NEIGHBOURS[corner].into_iter().find(|neighbour| !face.contains(neighbour));
                    nodes[behind.unwrap_or(corner)]
                });
                if p == q && q == r && r == s {
                    let mut base: ElementNodes = [a, b, c, d].into_iter().collect();
                    if let Some(double) = (0..4).find(|&k| base[k] == base[(k + 1) % 4]) {
                        base.remove(double);
                    }
                    base.push(p);
                    match (distinct, base.len()) {
                        (5, 5) => return (Self::Pyramid5, base),
                        (4, 4) => return (Self::Tet4, base),
                        _ => {}
                    }
                } else if distinct == 6 && p == q && r == s {
                    return (Self::Wedge6, [b, a, p, c, d, r].into_iter().collect());
                }
            }
        }
        (Self::Hex8, nodes.iter().copied().collect())
    }
}

impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Hex8 => "hex8",
            Self::Wedge6 => "wedge6",
            Self::Pyramid5 => "pyramid5",
            Self::Tet4 => "tet4",
            Self::Tet10 => "tet10",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_edge_belongs_to_two_faces_that_run_it_in_opposite_directions() {
        for shape in Shape::ALL {
            let mut directed = Vec::new();
            for face in shape.faces() {
                // a face of six nodes has three corners
                let corners = if face.len() == 6 { 3 } else { face.len() };
                for corner in 0..corners {
                    let (from, to) = (face[corner], face[(corner + 1) % corners]);
                    directed.push((from, to));
                    if face.len() == 6 {
                        assert_eq!(shape.middle(from, to), Some(face[3 + corner]));
                    }
                }
            }
            for (from, to) in &directed {
                assert_eq!(directed.iter().filter(|edge| **edge == (*to, *from)).count(), 1, "{shape}");
            }
        }
    }

    #[test]
    fn collapsed_hexes_are_known_however_they_are_turned() {
        // every rotation of a hex is made of these two: a quarter about ζ and a third about a diagonal
        let turns = [[1, 2, 3, 0, 5, 6, 7, 4], [0, 3, 7, 4, 1, 2, 6, 5]];
        let mut seen = vec![[0, 1, 2, 3, 4, 5, 6, 7_usize]];
        while let Some(next) = seen
            .iter()
            .flat_map(|order| turns.map(|turn| turn.map(|k: usize| order[k])))
            .find(|next| !seen.contains(next))
        {
            seen.push(next);
        }
        assert_eq!(seen.len(), 24);
        let tet = [0, 1, 2, 2, 3, 3, 3, 3];
        for order in seen {
            for shape in [Shape::Hex8, Shape::Wedge6, Shape::Pyramid5] {
                let corners = shape.corners_of_hex().unwrap();
                let (found, nodes) = Shape::of_hex(&order.map(|corner| corners[corner] as u32));
                assert_eq!(found, shape);
                // the same element, turned: every face of it is one of the given
                let key = |face: &[usize], of: &dyn Fn(usize) -> u32| {
                    let mut face: Vec<u32> = face.iter().map(|&node| of(node)).collect();
                    let least = (0..face.len()).min_by_key(|&k| face[k]).unwrap();
                    face.rotate_left(least);
                    face
                };
                let given: Vec<Vec<u32>> = shape.faces().iter().map(|face| key(face, &|node| node as u32)).collect();
                for face in shape.faces() {
                    assert!(given.contains(&key(face, &|node| nodes[node])), "{shape} {order:?} {nodes:?}");
                }
            }
            let (found, nodes) = Shape::of_hex(&order.map(|corner| tet[corner]));
            let even = [[0, 1, 2, 3], [1, 2, 0, 3], [2, 0, 1, 3], [0, 2, 3, 1], [1, 0, 3, 2], [3, 0, 2, 1]];
            let even = even.iter().chain(&[
                [2, 3, 0, 1],
                [3, 2, 1, 0],
                [0, 3, 1, 2],
                [3, 1, 0, 2],
                [1, 3, 2, 0],
                [2, 1, 3, 0],
            ]);
            assert!(found == Shape::Tet4 && even.into_iter().any(|even| *even == nodes[..]), "{nodes:?}");
        }
        assert_eq!(Shape::of_hex(&[0, 1, 2, 3, 4, 5, 6, 0]).0, Shape::Hex8);
        assert_eq!(Shape::of_hex(&[0; 8]).0, Shape::Hex8);
    }
}
