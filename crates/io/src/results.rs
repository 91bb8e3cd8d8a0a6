//! The series of frames that ParaView opens: `results.pvd` and `fields/frame_00000.vtu`, ...

use std::fs;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::atomic::AtomicFile;
use crate::file::{make_own_folder, open_ordinary};
use crate::vtu::{Frame, FrameError, write_vtu};

/// Why a frame was not written.
#[derive(Debug, Error)]
pub enum WriteError {
    /// The system refused.
    #[error("{}: cannot be written: {source}", path.display())]
    Unwritable {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A frame of the series that is to go on.
    #[error("{}: {what}", path.display())]
    EarlierFrame {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// The system refused, the file not yet known.
    #[error("cannot be written: {0}")]
    Io(#[from] io::Error),
    /// The frame's parts do not fit.
    #[error(transparent)]
    Frame(#[from] FrameError),
}

impl WriteError {
    fn of(path: &Path) -> impl FnOnce(WriteError) -> WriteError {
        let path = path.to_owned();
        move |error| match error {
            WriteError::Io(source) => WriteError::Unwritable { path, source },
            other => other,
        }
    }
}

/// Whether a frame has its end.
fn is_whole(path: &Path) -> io::Result<bool> {
    const END: &[u8] = b"</VTKFile>";
    let mut file = open_ordinary(path)?;
    let length = file.metadata()?.len();
    file.seek(SeekFrom::Start(length.saturating_sub(END.len() as u64 + 8)))?;
    let mut tail = Vec::new();
    file.take(64).read_to_end(&mut tail)?;
    Ok(tail.trim_ascii_end().ends_with(END))
}

/// Writes frames one after another. Every file is whole or not there, and `results.pvd` names only frames that are:
/// the series can be opened at any time, also after a kill or on a full disk.
#[derive(Debug)]
pub struct ResultWriter {
    folder: PathBuf,
    times: Vec<f64>,
    /// Frames that somebody has removed, which the series does not name.
    removed: Vec<usize>,
    /// Frames that are known to be on the disk.
    synced: usize,
}

impl ResultWriter {
    /// A new series in `folder`, which is made if need be.
    ///
    /// # Errors
    /// [`WriteError::Unwritable`].
    pub fn create(folder: &Path) -> Result<Self, WriteError> {
        let fields = folder.join(FIELDS);
        fs::create_dir_all(folder)
            .and_then(|()| make_own_folder(&fields))
            .map_err(|source| WriteError::Unwritable { path: fields, source })?;
        Ok(Self { folder: folder.to_owned(), times: Vec::new(), removed: Vec::new(), synced: 0 })
    }

    /// A series that goes on after the frames that were written at `times`; the next frame follows them, and the series
    /// names no later one, and none that somebody has removed.
    ///
    /// # Errors
    /// [`WriteError::Unwritable`]; [`WriteError::EarlierFrame`] where one of these frames is not whole.
    pub fn resume(folder: &Path, times: Vec<f64>) -> Result<Self, WriteError> {
        let removed = removed_frames(folder, times.len())?;
        let writer = Self { synced: times.len(), times, removed, ..Self::create(folder)? };
        writer.write_series()?;
        Ok(writer)
    }

    /// Puts the frames so far on the disk, so that they survive the end of the machine.
    ///
    /// # Errors
    /// [`WriteError::Unwritable`].
    pub fn sync(&mut self) -> Result<(), WriteError> {
        let sync = |path: &Path| open_ordinary(path).and_then(|file| file.sync_all());
        for number in self.synced..self.times.len() {
            let path = self.folder.join(frame_name(number));
            match sync(&path) {
                // removed by somebody who needs no more of it
                Err(error) if error.kind() == io::ErrorKind::NotFound => self.removed.push(number),
                synced => synced.map_err(|source| WriteError::Unwritable { path, source })?,
            }
        }
        self.synced = self.times.len();
        let path = self.folder.join(SERIES);
        sync(&path).map_err(|source| WriteError::Unwritable { path, source })
    }

    /// Frames that are there.
    pub fn frame_count(&self) -> usize {
        self.times.len() - self.removed.len()
    }

    /// Writes the next frame and the series with it; returns the frame's file.
    ///
    /// # Errors
    /// [`WriteError::Frame`] if a field does not fit; [`WriteError::Unwritable`].
    pub fn write_frame(&mut self, frame: &Frame) -> Result<PathBuf, WriteError> {
        let path = self.folder.join(frame_name(self.times.len()));
        write_frame_file(&path, frame)?;
        self.times.push(frame.time);
        self.write_series()?;
        Ok(path)
    }

    fn write_series(&self) -> Result<(), WriteError> {
        let path = self.folder.join(SERIES);
        let mut xml = String::from(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n\
             <Collection>\n",
        );
        let is_there = |(number, _): &(usize, &f64)| self.removed.binary_search(number).is_err();
        for (number, time) in self.times.iter().enumerate().filter(is_there) {
            let file = frame_name(number);
            xml += &format!("<DataSet timestep=\"{time:?}\" part=\"0\" file=\"{file}\"/>\n");
        }
        xml += "</Collection>\n</VTKFile>\n";
        let write = || {
            let mut file = AtomicFile::create(&path)?;
            file.write_all(xml.as_bytes())?;
            Ok(file.commit()?)
        };
        write().map_err(WriteError::of(&path))
    }
}

/// The numbers of those of the first `count` frames of a series that are not there.
///
/// # Errors
/// [`WriteError::EarlierFrame`] where one of the others is not whole.
pub fn removed_frames(folder: &Path, count: usize) -> Result<Vec<usize>, WriteError> {
    let mut removed = Vec::new();
    for number in 0..count {
        let path = folder.join(frame_name(number));
        match is_whole(&path) {
            Ok(true) => {}
            Ok(false) => return Err(WriteError::EarlierFrame { path, what: "is cut short".to_owned() }),
            Err(error) if error.kind() == io::ErrorKind::NotFound => removed.push(number),
            Err(error) => return Err(WriteError::EarlierFrame { path, what: format!("cannot be read: {error}") }),
        }
    }
    Ok(removed)
}

/// Writes a frame that stands alone.
///
/// # Errors
/// [`WriteError::Frame`] if a field does not fit; [`WriteError::Unwritable`].
pub fn write_frame_file(path: &Path, frame: &Frame) -> Result<(), WriteError> {
    let write = || {
        let mut file = AtomicFile::create(path)?;
        write_vtu(&mut file, frame)?;
        Ok(file.commit()?)
    };
    write().map_err(WriteError::of(path))
}

/// The folder of the frames, in that of the series.
pub const FIELDS: &str = "fields";
/// The file that names the frames.
pub const SERIES: &str = "results.pvd";

/// With a slash on every system: it is also what the series calls the file.
fn frame_name(number: usize) -> String {
    format!("{FIELDS}/frame_{number:05}.vtu")
}
