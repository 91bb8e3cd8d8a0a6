//! The frames of a run, as `results.pvd` names them.

use crate::failure::Failure;
use estar_io::{FrameContent, read_frame};
use std::path::{Path, PathBuf};

/// The frames of a run; at least one.
#[derive(Clone, Debug)]
pub struct Series {
    /// Times, s, and files.
    pub frames: Vec<(f64, PathBuf)>,
}

impl Series {
    /// The file that names the frames of a directory.
    pub fn file(directory: &Path) -> PathBuf {
        directory.join("results.pvd")
    }

    /// Those of a directory.
    ///
    /// # Errors
    /// They cannot be read, or there are none.
    pub fn of(directory: &Path) -> Result<Self, Failure> {
        let path = Self::file(directory);
        let text = std::fs::read_to_string(&path).map_err(Failure::reading(&path))?;
        let attribute = |tag: &str, name: &str| -> Option<String> {
            let (_, after) = tag.split_once(&format!("{name}=\""))?;
            after.split_once('"').map(|(value, _)| value.to_owned())
        };
        let frames: Vec<(f64, PathBuf)> = text
            .split('<')
            .filter(|tag| tag.starts_with("DataSet"))
            .filter_map(|tag| {
                Some((attribute(tag, "timestep")?.parse().ok()?, directory.join(attribute(tag, "file")?)))
            })
            .collect();
        if frames.is_empty() {
            return Err(Failure::File(format!("error: {}: it names no frame", path.display())));
        }
        Ok(Self { frames })
    }

    /// The frame at or before a time, or the last one.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn at(&self, time: Option<f64>) -> Result<FrameContent, Failure> {
        let is_due = |frame: &&(f64, PathBuf)| time.is_none_or(|time| frame.0 <= time * (1.0 + 1e-12));
        let (_, path) = self.frames.iter().rev().find(is_due).unwrap_or(&self.frames[0]);
        read(path)
    }

    /// All frames.
    ///
    /// # Errors
    /// One of them cannot be read.
    pub fn all(&self) -> Result<Vec<FrameContent>, Failure> {
        self.frames.iter().map(|(_, path)| read(path)).collect()
    }
}

fn read(path: &Path) -> Result<FrameContent, Failure> {
    read_frame(path).map_err(|error| Failure::File(format!("error: {error}")))
}
