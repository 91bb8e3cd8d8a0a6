//! The hexahedron's corner numbering, shared by VTK, Gmsh and Abaqus:
//!
//! ```text
//!        7--------6          ζ
//!       /|       /|          | η
//!      4--------5 |          |/
//!      | |      | |          +---ξ
//!      | 3------|-2
//!      |/       |/
//!      0--------1
//! ```

/// The three neighbours of each corner along ξ, η, ζ, ordered so that a positive hex has positive corner Jacobians.
pub const CORNER_NEIGHBOURS: [[usize; 3]; 8] =
    [[1, 3, 4], [2, 0, 5], [3, 1, 6], [0, 2, 7], [7, 5, 0], [4, 6, 1], [5, 7, 2], [6, 4, 3]];

/// The natural coordinates (ξ, η, ζ), each ±1, of each corner.
pub const CORNER_SIGNS: [[f64; 3]; 8] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corner_neighbours_form_right_handed_triads_in_the_reference_cube() {
        for (corner, neighbours) in CORNER_NEIGHBOURS.iter().enumerate() {
            let edge = |k: usize| {
                let mut e = [0.0; 3];
                for (axis, value) in e.iter_mut().enumerate() {
                    *value = CORNER_SIGNS[neighbours[k]][axis] - CORNER_SIGNS[corner][axis];
                }
                e
            };
            let (a, b, c) = (edge(0), edge(1), edge(2));
            let det = a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
                + a[2] * (b[0] * c[1] - b[1] * c[0]);
            assert_eq!(det, 8.0, "corner {corner}");
        }
    }
}
