//! The element types of Gmsh that are met in practice.

use estar_mesh::Shape;

use crate::error::Unsupported;

/// An element type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ElementType {
    pub code: i32,
    name: &'static str,
    pub node_count: usize,
    pub dimension: usize,
}

/// What an element is to a mesh of solids.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Use {
    Solid(Shape),
    Face,
    /// Names the nodes of a curve or a point.
    Nodes,
    Unsupported,
}

pub(super) const QUAD4: i32 = 3;
pub(super) const TRIANGLE3: i32 = 2;
pub(super) const TRIANGLE6: i32 = 9;
pub(super) const LINE2: i32 = 1;
pub(super) const POINT: i32 = 15;
const LINE3: i32 = 8;

/// The codes of solids.
const SOLIDS: [(i32, Shape); 5] =
    [(5, Shape::Hex8), (6, Shape::Wedge6), (7, Shape::Pyramid5), (4, Shape::Tet4), (11, Shape::Tet10)];

/// Brings the nodes of a solid from Gmsh's order into that of [`Shape`], or back: of ten-node tets Gmsh has the middles of the
/// last two edges the other way round.
pub(super) fn swap_order<T>(shape: Shape, nodes: &mut [T]) {
    if shape == Shape::Tet10 {
        nodes.swap(8, 9);
    }
}

/// The code of a solid.
pub(super) fn solid_code(shape: Shape) -> i32 {
    SOLIDS.into_iter().find(|(_, other)| *other == shape).map_or(0, |(code, _)| code)
}

const fn element(code: i32, name: &'static str, node_count: usize, dimension: usize) -> ElementType {
    ElementType { code, name, node_count, dimension }
}

const ELEMENT_TYPES: [ElementType; 19] = [
    element(LINE2, "2-node lines", 2, 1),
    element(TRIANGLE3, "3-node triangles", 3, 2),
    element(QUAD4, "4-node quadrilaterals", 4, 2),
    element(4, "4-node tetrahedra", 4, 3),
    element(5, "8-node hexahedra", 8, 3),
    element(6, "6-node prisms", 6, 3),
    element(7, "5-node pyramids", 5, 3),
    element(LINE3, "3-node lines", 3, 1),
    element(TRIANGLE6, "6-node triangles", 6, 2),
    element(10, "9-node quadrilaterals", 9, 2),
    element(11, "10-node tetrahedra", 10, 3),
    element(12, "27-node hexahedra", 27, 3),
    element(13, "18-node prisms", 18, 3),
    element(14, "14-node pyramids", 14, 3),
    element(POINT, "points", 1, 0),
    element(16, "8-node quadrilaterals", 8, 2),
    element(17, "20-node hexahedra", 20, 3),
    element(18, "15-node prisms", 15, 3),
    element(19, "13-node pyramids", 13, 3),
];

impl ElementType {
    /// The type with this code, if it is one of the usual ones.
    pub fn of(code: i32) -> Option<Self> {
        ELEMENT_TYPES.into_iter().find(|element_type| element_type.code == code)
    }

    /// What elements of this type are good for.
    pub fn usage(self) -> Use {
        match self.code {
            QUAD4 | TRIANGLE3 | TRIANGLE6 => Use::Face,
            LINE2 | LINE3 | POINT => Use::Nodes,
            code => SOLIDS
                .into_iter()
                .find(|(solid, _)| *solid == code)
                .map_or(Use::Unsupported, |(_, shape)| Use::Solid(shape)),
        }
    }

    /// How elements of this type are reported.
    pub fn unsupported(self, count: u64, first: u64) -> Unsupported {
        let advice = match self.code {
            12 | 17 | 10 | 16 => "set Mesh.ElementOrder = 1: hexahedra have 8 nodes here, and their faces 4",
            13 | 14 | 18 | 19 => "set Mesh.ElementOrder = 1: prisms have 6 nodes here, and pyramids 5",
            _ => "mesh with hexahedra, prisms or pyramids of first order, or tetrahedra of first or second order",
        };
        Unsupported { kind: self.name.to_owned(), count, first, advice }
    }
}
