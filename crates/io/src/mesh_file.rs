//! Reading a mesh, whatever its format.

use std::fs;
use std::path::Path;

use crate::error::{Place, Problem, ReadError};
use crate::file::read_ordinary;
use crate::mesh_content::MeshFile;
use crate::{abaqus, gmsh, other_format, vtk};

/// Reads a mesh: Gmsh 4.1, 4.0 or 2.2, ASCII or binary, Abaqus, or VTK (`.vtu`, `.vtk`). The content says which it is, not the file's name.
///
/// # Errors
/// [`ReadError::Unreadable`] when the file cannot be opened or read; [`ReadError::Content`], with place, numbers and
/// advice, when it is no usable mesh.
pub fn read_mesh(path: &Path) -> Result<MeshFile, ReadError> {
    read_mesh_within(path, u64::MAX)
}

/// As [`read_mesh`], if all files that make up the mesh, or what they are unpacked to, have no more than `limit` bytes.
///
/// # Errors
/// As [`read_mesh`]; [`Problem::NoMemory`] when there are more, before they are read.
pub fn read_mesh_within(path: &Path, limit: u64) -> Result<MeshFile, ReadError> {
    let file = path.display().to_string();
    let unreadable = |source| ReadError::Unreadable { file: file.clone(), source };
    // a file that cannot be looked at is told of when it is read
    if fs::metadata(path).is_ok_and(|metadata| metadata.is_file() && metadata.len() > limit) {
        return Err(Problem::NoMemory { limit }.at(Place::File).in_file(&file));
    }
    let bytes = read_ordinary(path, u64::MAX).map_err(unreadable)?;
    read_content(&bytes, &file, Some(path), limit)
}

/// Reads a mesh from the content of a file; `name` stands for it in messages. It can include no other file.
///
/// # Errors
/// As [`read_mesh`].
pub fn read_mesh_bytes(bytes: &[u8], name: &str) -> Result<MeshFile, ReadError> {
    read_content(bytes, name, None, u64::MAX)
}

fn read_content(bytes: &[u8], name: &str, path: Option<&Path>, limit: u64) -> Result<MeshFile, ReadError> {
    const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";
    let bytes = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
    let content = bytes.trim_ascii_start();
    if let Some(problem) = other_format::recognised(content, name) {
        Err(problem.at(Place::File).in_file(name))
    } else if content.starts_with(b"$") {
        gmsh::read(bytes).map_err(|located| located.in_file(name))
    } else if content.starts_with(b"*") {
        abaqus::read(bytes, name, path, limit)
    } else if content.starts_with(b"# vtk DataFile") {
        vtk::read_legacy(content, limit).map_err(|located| located.in_file(name))
    } else if is_vtk_xml(content) {
        vtk::read_xml(content, limit).map_err(|located| located.in_file(name))
    } else {
        Err(Problem::UnknownFormat.at(Place::File).in_file(name))
    }
}

fn is_vtk_xml(content: &[u8]) -> bool {
    /// The tag comes behind a declaration and comments.
    const LOOKED_AT: usize = 1 << 12;
    const TAG: &[u8] = b"<VTKFile";
    let start = &content[..content.len().min(LOOKED_AT)];
    content.starts_with(b"<") && start.windows(TAG.len()).any(|window| window == TAG)
}
