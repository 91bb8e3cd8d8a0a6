//! What the readers of all formats return.

use estar_mesh::Mesh;

/// A mesh and what its file said beside it.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshFile {
    /// The mesh, with the file's own node and element numbers.
    pub mesh: Mesh,
    /// The format, as "Gmsh 4.1, binary".
    pub format: String,
    /// What was passed over, in words for the user.
    pub warnings: Vec<String>,
}
