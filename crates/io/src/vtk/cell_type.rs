//! The cell types of VTK: those that a mesh of solids is made of, and what becomes of the others.

use estar_mesh::Shape;

use crate::error::Unsupported;

/// What a cell is to a mesh of solids.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Use {
    Solid(Shape),
    /// Names a face.
    Face,
    /// Names the nodes of a curve.
    Line,
    /// Names a node.
    Point,
    /// Of no use.
    LeftOut,
    /// A solid that cannot be used.
    Unsupported,
}

/// A type of cell: VTK's number, what many of it are called, how many nodes it has if that is fixed, what it is used as.
struct CellType(i64, &'static str, Option<usize>, Use);

const CELL_TYPES: [CellType; 41] = [
    CellType(0, "empty cells", None, Use::LeftOut),
    CellType(1, "vertices", Some(1), Use::Point),
    CellType(2, "poly-vertices", None, Use::LeftOut),
    CellType(3, "lines", Some(2), Use::Line),
    CellType(4, "polylines", None, Use::Line),
    CellType(5, "triangles", Some(3), Use::Face),
    CellType(6, "triangle strips", None, Use::LeftOut),
    CellType(7, "polygons", None, Use::Face),
    CellType(PIXEL, "pixels", Some(4), Use::Face),
    CellType(9, "quads", Some(4), Use::Face),
    CellType(10, "tetrahedra", Some(4), Use::Solid(Shape::Tet4)),
    CellType(VOXEL, "voxels", Some(8), Use::Solid(Shape::Hex8)),
    CellType(12, "hexahedra", Some(8), Use::Solid(Shape::Hex8)),
    CellType(13, "wedges", Some(6), Use::Solid(Shape::Wedge6)),
    CellType(14, "pyramids", Some(5), Use::Solid(Shape::Pyramid5)),
    CellType(15, "pentagonal prisms", Some(10), Use::Unsupported),
    CellType(16, "hexagonal prisms", Some(12), Use::Unsupported),
    CellType(21, "3-node lines", Some(3), Use::Line),
    CellType(22, "6-node triangles", Some(6), Use::Face),
    CellType(23, "8-node quads", Some(8), Use::LeftOut),
    CellType(24, "10-node tetrahedra", Some(10), Use::Solid(Shape::Tet10)),
    CellType(25, "20-node hexahedra", Some(20), Use::Unsupported),
    CellType(26, "15-node wedges", Some(15), Use::Unsupported),
    CellType(27, "13-node pyramids", Some(13), Use::Unsupported),
    CellType(28, "9-node quads", Some(9), Use::LeftOut),
    CellType(29, "27-node hexahedra", Some(27), Use::Unsupported),
    CellType(30, "6-node quads", Some(6), Use::LeftOut),
    CellType(31, "12-node wedges", Some(12), Use::Unsupported),
    CellType(32, "18-node wedges", Some(18), Use::Unsupported),
    CellType(33, "24-node hexahedra", Some(24), Use::Unsupported),
    CellType(34, "7-node triangles", Some(7), Use::LeftOut),
    CellType(35, "4-node curved lines", Some(4), Use::LeftOut),
    CellType(36, "polygons of second order", None, Use::LeftOut),
    CellType(37, "19-node pyramids", Some(19), Use::Unsupported),
    CellType(41, "convex point sets", None, Use::Unsupported),
    CellType(42, "polyhedra", None, Use::Unsupported),
    CellType(68, "Lagrange curves", None, Use::LeftOut),
    CellType(69, "Lagrange triangles", None, Use::LeftOut),
    CellType(70, "Lagrange quads", None, Use::LeftOut),
    CellType(71, "Lagrange tetrahedra", None, Use::Unsupported),
    CellType(72, "Lagrange hexahedra", None, Use::Unsupported),
];
/// A quad and a hex whose nodes run along the axes: the last two of each four are the other way round.
const PIXEL: i64 = 8;
const VOXEL: i64 = 11;

fn of(code: i64) -> Option<&'static CellType> {
    CELL_TYPES.iter().find(|cell_type| cell_type.0 == code)
}

/// What a cell of this type and so many nodes is used as; nothing if that type has another number of nodes.
pub(super) fn usage(code: i64, node_count: usize) -> Option<Use> {
    match of(code) {
        Some(CellType(_, _, Some(needed), _)) if *needed != node_count => None,
        Some(CellType(7, ..)) if !matches!(node_count, 3 | 4) => Some(Use::LeftOut),
        Some(CellType(.., usage)) => Some(*usage),
        None => Some(Use::Unsupported),
    }
}

/// Brings nodes into the order of [`Shape`] and of faces.
pub(super) fn put_in_order(code: i64, nodes: &mut [u32]) {
    match (code, nodes) {
        (PIXEL, [_, _, c, d]) => std::mem::swap(c, d),
        (VOXEL, [_, _, c, d, _, _, g, h]) => {
            std::mem::swap(c, d);
            std::mem::swap(g, h);
        }
        _ => {}
    }
}

/// What many cells of a type are called.
pub(super) fn name(code: i64) -> String {
    of(code).map_or_else(|| format!("cells of VTK's type {code}"), |cell_type| cell_type.1.to_owned())
}

/// How cells of a type are reported that cannot be used.
pub(super) fn unsupported(code: i64, count: u64, first: u64) -> Unsupported {
    let advice = match code {
        25..=27 | 29 | 31..=33 | 37 | 71 | 72 => {
            "mesh with elements of first order, or with 10-node tetrahedra (type 24)"
        }
        _ => "mesh with hexahedra, wedges, pyramids or tetrahedra; in ParaView the filter Tetrahedralize makes some",
    };
    Unsupported { kind: name(code), count, first, advice }
}
