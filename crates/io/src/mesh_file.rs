//! Reading a mesh, whatever its format.

use std::path::Path;

use estar_mesh::Mesh;

use crate::error::{Place, Problem, ReadError};
use crate::file::read_ordinary;
use crate::{abaqus, gmsh, other_format};

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

/// Reads a mesh: Gmsh 4.1 or 2.2, ASCII or binary, or Abaqus. The content says which it is, not the file's name.
///
/// # Errors
/// [`ReadError::Unreadable`] when the file cannot be opened or read; [`ReadError::Content`], with place, numbers and
/// advice, when it is no usable mesh.
pub fn read_mesh(path: &Path) -> Result<MeshFile, ReadError> {
    let file = path.display().to_string();
    let bytes = read_ordinary(path, u64::MAX).map_err(|source| ReadError::Unreadable { file: file.clone(), source })?;
    read_content(&bytes, &file, Some(path))
}

/// Reads a mesh from the content of a file; `name` stands for it in messages. It can include no other file.
///
/// # Errors
/// As [`read_mesh`].
pub fn read_mesh_bytes(bytes: &[u8], name: &str) -> Result<MeshFile, ReadError> {
    read_content(bytes, name, None)
}

fn read_content(bytes: &[u8], name: &str, path: Option<&Path>) -> Result<MeshFile, ReadError> {
    const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";
    let bytes = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
    let content = bytes.trim_ascii_start();
    if let Some(problem) = other_format::recognised(content, name) {
        Err(problem.at(Place::File).in_file(name))
    } else if content.starts_with(b"$") {
        gmsh::read(bytes).map_err(|located| located.in_file(name))
    } else if content.starts_with(b"*") {
        abaqus::read(bytes, name, path)
    } else {
        Err(Problem::UnknownFormat.at(Place::File).in_file(name))
    }
}
