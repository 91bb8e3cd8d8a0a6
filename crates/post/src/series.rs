//! The frames of a run, as `results.pvd` names them.

use crate::error::PostError;
use estar_deck::memory;
use estar_io::{FrameContent, FrameLimits, SERIES, read_frame_with, read_ordinary};
use std::path::{Component, Path, PathBuf};

/// The frames of a run; at least one.
#[derive(Clone, Debug)]
pub struct Series {
    /// Times, s, and files.
    pub frames: Vec<(f64, PathBuf)>,
}

impl Series {
    /// The file that names the frames of a directory.
    pub fn file(directory: &Path) -> PathBuf {
        directory.join(SERIES)
    }

    /// Those of a directory, all of which are below it.
    ///
    /// # Errors
    /// They cannot be read, there are none, or one is elsewhere.
    pub fn of(directory: &Path) -> Result<Self, PostError> {
        /// Of a million frames.
        const MOST_BYTES: u64 = 128 << 20;
        let path = Self::file(directory);
        let text = read_ordinary(&path, MOST_BYTES).map_err(PostError::reading(&path))?;
        let text = String::from_utf8_lossy(&text);
        let attribute = |tag: &str, name: &str| -> Option<String> {
            let (_, after) = tag.split_once(&format!("{name}=\""))?;
            after.split_once('"').map(|(value, _)| value.to_owned())
        };
        let frames: Vec<(f64, PathBuf)> = text
            .split('<')
            .filter(|tag| tag.starts_with("DataSet"))
            .filter_map(|tag| Some((attribute(tag, "timestep")?.parse().ok()?, attribute(tag, "file")?.into())))
            .collect();
        if frames.is_empty() {
            return Err(PostError::Unusable { path, what: "it names no frame".to_owned() });
        }
        // results may be a stranger's: they are not to lead to files that are none of theirs
        let is_below =
            |name: &Path| name.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
        if let Some((_, name)) = frames.iter().find(|(_, name)| !is_below(name)) {
            let what = format!("it names {:?}, which is not below its directory", name.display().to_string());
            return Err(PostError::Unusable { path, what });
        }
        let frames = frames.into_iter().map(|(time, name)| (time, directory.join(name))).collect();
        Ok(Self { frames })
    }

    /// The frame at or before a time, or the last one.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn at(&self, time: Option<f64>) -> Result<FrameContent, PostError> {
        let is_due = |frame: &&(f64, PathBuf)| time.is_none_or(|time| frame.0 <= time * (1.0 + 1e-12));
        let (_, path) = self.frames.iter().rev().find(is_due).unwrap_or(&self.frames[0]);
        read(path)
    }

    /// All frames, read one after another; one that cannot be read is an error.
    pub fn all(&self) -> impl Iterator<Item = Result<FrameContent, PostError>> {
        self.frames.iter().map(|(_, path)| read(path))
    }
}

/// The frame of a file, as large as there is memory for it.
///
/// # Errors
/// It cannot be read, or is too large.
pub fn read(path: &Path) -> Result<FrameContent, PostError> {
    let numbers = memory::available().unwrap_or(u64::MAX);
    Ok(read_frame_with(path, FrameLimits { file: numbers, numbers }, |_| true)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn naming(directory: &Path, name: &str) -> Result<Series, PostError> {
        std::fs::write(Series::file(directory), format!("<DataSet timestep=\"0\" file=\"{name}\"/>")).unwrap();
        Series::of(directory)
    }

    #[test]
    fn frames_are_below_the_directory_that_names_them() {
        let directory = tempfile::tempdir().unwrap();
        let at = directory.path();
        let found = naming(at, "fields/frame_00000.vtu").unwrap();
        assert_eq!(found.frames, [(0.0, at.join("fields/frame_00000.vtu"))]);
        for name in ["/dev/zero", "../frame_00000.vtu", "fields/../../frame_00000.vtu"] {
            let told = naming(at, name).unwrap_err().to_string();
            assert!(told.contains("not below its directory") && told.contains(name), "{told}");
        }
    }

    #[test]
    #[cfg(unix)]
    fn a_frame_is_a_regular_file() {
        let directory = tempfile::tempdir().unwrap();
        std::os::unix::fs::symlink("/dev/zero", directory.path().join("frame.vtu")).unwrap();
        let told = naming(directory.path(), "frame.vtu").unwrap().at(None).unwrap_err().to_string();
        assert!(told.contains("a device or a pipe"), "{told}");
    }
}
