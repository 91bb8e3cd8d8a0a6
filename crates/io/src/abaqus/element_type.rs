//! The element types of Abaqus and CalculiX, and what each is to a mesh of solids.

use estar_mesh::Shape;

/// What an element is to a mesh of solids.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Use {
    Solid(Shape),
    /// A face of so many nodes, which only names faces.
    Face(usize),
    /// A line of so many nodes, which only names nodes.
    Line(usize),
    /// Holds solids together that have no nodes in common: nothing is right without it.
    Joint,
    /// Of no use.
    LeftOut,
    /// A solid that cannot be used; what to do about it.
    Unsupported(&'static str),
}

const SECOND_ORDER: &str =
    "hexes and wedges of second order are not supported: mesh with C3D8 and C3D6, or with the tets C3D10";
const OTHER_SOLIDS: &str =
    "mesh the volume with C3D8, C3D6, C3D4 or C3D10 (or what has as many nodes, such as C3D8R or C3D10M)";

impl Use {
    /// The use of an element type, whose name is in capitals.
    pub fn of(element_type: &str) -> Self {
        const SOLIDS: [(&str, Shape); 5] = [
            ("C3D8", Shape::Hex8),
            ("C3D6", Shape::Wedge6),
            ("C3D5", Shape::Pyramid5),
            ("C3D4", Shape::Tet4),
            ("C3D10", Shape::Tet10),
        ];
        const QUADS: [&str; 7] = ["CPS4", "CPE4", "CAX4", "S4", "M3D4", "SFM3D4", "R3D4"];
        const TRIANGLES: [&str; 8] = ["CPS3", "CPE3", "CAX3", "S3", "STRI3", "M3D3", "SFM3D3", "R3D3"];
        const TRIANGLES_OF_SIX: [&str; 7] = ["CPS6", "CPE6", "CAX6", "STRI65", "M3D6", "SFM3D6", "S6"];
        const LINES: [&str; 5] = ["T2D2", "T3D2", "B31", "B21", "R2D2"];
        const LINES_OF_THREE: [&str; 4] = ["T2D3", "T3D3", "B32", "B22"];
        let is_type = |of: &str, base: &str| {
            of.strip_prefix(base).is_some_and(|letters| letters.bytes().all(|byte| byte.is_ascii_uppercase()))
        };
        let is_any = |types: &[&str]| types.iter().any(|base| is_type(element_type, base));
        let begins = |beginnings: &[&str]| beginnings.iter().any(|beginning| element_type.starts_with(beginning));
        // diffusive elements are those of the same shape
        let solid = element_type.strip_prefix('D').unwrap_or(element_type);
        if let Some((_, shape)) = SOLIDS.into_iter().find(|(base, _)| is_type(solid, base)) {
            Self::Solid(shape)
        } else if ["C3D20", "C3D15", "C3D27"].iter().any(|base| solid.starts_with(base)) {
            Self::Unsupported(SECOND_ORDER)
        } else if solid.starts_with("C3D") || begins(&["SC", "CCL", "CSS"]) {
            Self::Unsupported(OTHER_SOLIDS)
        } else if begins(&["COH3D", "GK3D"]) {
            Self::Joint
        } else if is_any(&QUADS) {
            Self::Face(4)
        } else if is_any(&TRIANGLES) {
            Self::Face(3)
        } else if is_any(&TRIANGLES_OF_SIX) {
            Self::Face(6)
        } else if is_any(&LINES) {
            Self::Line(2)
        } else if is_any(&LINES_OF_THREE) {
            Self::Line(3)
        } else {
            Self::LeftOut
        }
    }

    /// How many nodes elements of this type have, as far as is known; of others, a line that ends in a comma goes on.
    pub fn node_count(self, element_type: &str) -> Option<usize> {
        match self {
            Self::Solid(shape) => Some(shape.node_count()),
            Self::Face(count) | Self::Line(count) => Some(count),
            _ => {
                // the number behind the dimension: C3D20R, COH3D8, AC3D8, CONN3D2
                let (_, behind) = element_type.rsplit_once('D')?;
                let digits = behind.bytes().take_while(u8::is_ascii_digit).count();
                behind[..digits].parse().ok().filter(|count| (1..=64).contains(count))
            }
        }
    }
}
