//! What the fuzz targets share.

use estar_io::{MeshFile, read_mesh_bytes, write_gmsh};
use estar_mesh::Mesh;
use estar_mesh::generate::{BoxSpec, box_mesh};
use estar_mesh::quality::QualityReport;
use std::path::Path;
use tempfile::TempDir;

/// Steps that a deck may run for: what a reader let through must also run.
pub const STEPS: u64 = 3;

/// A directory with the mesh `mesh.msh`: eight hexes of the group `box`, with its six sides.
///
/// # Panics
/// It cannot be made.
pub fn workshop() -> TempDir {
    let directory = tempfile::tempdir().expect("a directory for temporary files");
    let spec = BoxSpec::new([1e-3; 3], [2; 3]).expect("a box");
    let mut bytes = Vec::new();
    write_gmsh(&mut bytes, &box_mesh(&spec), false).expect("a mesh in memory");
    write(&directory.path().join("mesh.msh"), &bytes);
    directory
}

/// Writes a file of the workshop.
///
/// # Panics
/// It cannot be written.
pub fn write(path: &Path, bytes: &[u8]) {
    std::fs::write(path, bytes).expect("room for temporary files");
}

/// Reads a mesh. What is read is written again, which orders hexes by their groups; from then on it must stay the same.
///
/// # Panics
/// It does not.
pub fn read_and_write_mesh(bytes: &[u8]) {
    match read_mesh_bytes(bytes, "mesh") {
        Ok(MeshFile { mesh, .. }) => {
            let quality = QualityReport::new(&mesh);
            assert!(quality.errors().iter().all(|error| !error.to_string().is_empty()));
            // names with quotes and numbers up to the largest are refused by the writer
            let binary = bytes.len().is_multiple_of(2);
            let Some(ordered) = written_and_read(&mesh, binary) else { return };
            let counts = |mesh: &Mesh| [mesh.node_count(), mesh.element_count(), mesh.groups().len()];
            assert_eq!(counts(&ordered), counts(&mesh));
            assert_eq!(written_and_read(&ordered, !binary).as_ref(), Some(&ordered));
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

fn written_and_read(mesh: &Mesh, binary: bool) -> Option<Mesh> {
    let mut bytes = Vec::new();
    match write_gmsh(&mut bytes, mesh, binary) {
        Ok(()) => Some(read_mesh_bytes(&bytes, "written").expect("what was written").mesh),
        Err(error) => {
            assert_eq!(error.kind(), std::io::ErrorKind::InvalidInput);
            None
        }
    }
}
