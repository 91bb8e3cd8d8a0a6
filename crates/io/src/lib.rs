//! Files of the Estar solver: meshes in, results out.
//!
//! Meshes: [`read_mesh`] reads Gmsh 4.1, 4.0 and 2.2 (ASCII and binary), Abaqus, and VTK (`.vtu`, `.vtk`); [`write_gmsh`] writes Gmsh 4.1.
//! Bad content never panics, loops or costs memory that the file does not warrant: it is a [`ReadError`] that names
//! the place, the node or element number of the file, and what to do.
//!
//! Results: [`ResultWriter`] writes what ParaView opens, [`HistoryWriter`] a growing CSV table, [`CheckpointWriter`] the numbers
//! of a state, [`write_atomically`] any file whole or not at all.

mod abaqus;
mod assembly;
mod atomic;
mod checkpoint;
mod cursor;
mod error;
mod file;
mod gmsh;
mod history;
mod mesh_content;
mod mesh_file;
mod other_format;
mod results;
#[cfg(test)]
mod test_folder;
mod text;
mod vtk;
mod vtu;
mod vtu_reader;

pub use atomic::{AtomicFile, PARTIAL, append_whole, write_atomically};
pub use checkpoint::{Checkpoint, CheckpointError, CheckpointWriter, Numbers};
pub use error::{Place, Problem, ReadError, Unsupported};
pub use file::{create_ordinary, make_own_folder, open_or_create, open_ordinary, read_ordinary};
pub use gmsh::{write_gmsh, write_gmsh_file};
pub use history::{HistoryWriter, Value};
pub use mesh_content::MeshFile;
pub use mesh_file::{read_mesh, read_mesh_bytes, read_mesh_within};
pub use results::{FIELDS, ResultWriter, SERIES, WriteError, removed_frames, write_frame_file};
pub use text::{LONGEST_NAME, one_line, steers, visible};
pub use vtu::{Field, FieldData, Frame, FrameError, Grid};
pub use vtu_reader::{
    FieldContent, FrameContent, FrameLimits, FrameReadError, read_frame, read_frame_bytes, read_frame_with,
};
