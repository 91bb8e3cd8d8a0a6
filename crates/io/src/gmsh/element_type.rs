//! The element types of Gmsh that are met in practice.

use crate::error::Unsupported;

/// An element type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ElementType {
    pub code: i32,
    name: &'static str,
    pub node_count: usize,
    pub dimension: usize,
}

pub(super) const HEX8: i32 = 5;
pub(super) const QUAD4: i32 = 3;
pub(super) const LINE2: i32 = 1;
pub(super) const POINT: i32 = 15;

const fn element(code: i32, name: &'static str, node_count: usize, dimension: usize) -> ElementType {
    ElementType { code, name, node_count, dimension }
}

const ELEMENT_TYPES: [ElementType; 19] = [
    element(LINE2, "2-node lines", 2, 1),
    element(2, "3-node triangles", 3, 2),
    element(QUAD4, "4-node quadrilaterals", 4, 2),
    element(4, "4-node tetrahedra", 4, 3),
    element(HEX8, "8-node hexahedra", 8, 3),
    element(6, "6-node prisms", 6, 3),
    element(7, "5-node pyramids", 5, 3),
    element(8, "3-node lines", 3, 1),
    element(9, "6-node triangles", 6, 2),
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

    /// True for what a hex mesh is made of: hexes, and the quads, lines and points that bound them.
    pub fn is_supported(self) -> bool {
        matches!(self.code, HEX8 | QUAD4 | LINE2 | POINT)
    }

    /// How elements of this type are reported.
    pub fn unsupported(self, count: u64, first: u64) -> Unsupported {
        let advice = match self.code {
            8..=14 | 16..=19 => "set Mesh.ElementOrder = 1 and mesh with hexahedra",
            2 => "a surface of hexahedra has quadrilaterals: recombine the surface",
            _ => "mesh the volume with 8-node hexahedra (transfinite and recombined, or extruded with Recombine)",
        };
        Unsupported { kind: self.name.to_owned(), count, first, advice }
    }
}
