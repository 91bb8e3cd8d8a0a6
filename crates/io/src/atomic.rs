//! Files that are there whole or not at all, written under another name, then renamed; and files that grow by whole pieces.

use crate::file::create_ordinary;
use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// How the name of a file on its way ends. One that is there when nobody writes was left by a program that was killed.
pub const PARTIAL: &str = ".partial";

/// A file on its way. Nothing has its name until [`AtomicFile::commit`]; dropped before, it leaves nothing behind.
#[derive(Debug)]
pub struct AtomicFile {
    path: PathBuf,
    partial: PathBuf,
    file: Option<BufWriter<File>>,
}

impl AtomicFile {
    /// Opens `path` with [`PARTIAL`] appended, in the same folder, so that the renaming never crosses a file system.
    ///
    /// # Errors
    /// What the system says; something that is no ordinary file has that name.
    pub fn create(path: &Path) -> io::Result<Self> {
        let mut name: OsString = path.as_os_str().to_owned();
        name.push(PARTIAL);
        let partial = PathBuf::from(name);
        // the message names the file that the user asked for, which is another
        let told = |error: io::Error| {
            let name = partial.file_name().unwrap_or_default().to_string_lossy().into_owned();
            io::Error::new(error.kind(), format!("{name}, as which it is written first: {error}"))
        };
        let file = BufWriter::with_capacity(1 << 18, create_ordinary(&partial).map_err(told)?);
        Ok(Self { path: path.to_owned(), partial, file: Some(file) })
    }

    /// Gives the file its name. It survives the end of this program from now on; see
    /// [`AtomicFile::commit_durably`] for the end of the machine.
    ///
    /// # Errors
    /// What the system says; the file that had the name before is then untouched.
    pub fn commit(mut self) -> io::Result<()> {
        self.finish(false)
    }

    /// As [`AtomicFile::commit`], after the system has put the content on the disk.
    ///
    /// # Errors
    /// As [`AtomicFile::commit`].
    pub fn commit_durably(mut self) -> io::Result<()> {
        self.finish(true)
    }

    fn finish(&mut self, durably: bool) -> io::Result<()> {
        if let Some(mut writer) = self.file.take() {
            let written = writer.flush().and_then(|()| if durably { writer.get_ref().sync_all() } else { Ok(()) });
            drop(writer);
            if let Err(error) = written.and_then(|()| fs::rename(&self.partial, &self.path)) {
                // The first error is the one to report.
                let _ = fs::remove_file(&self.partial);
                return Err(error);
            }
            if durably {
                sync_folder_of(&self.path)?;
            }
        }
        Ok(())
    }
}

/// Puts the names in the folder of a file on the disk, where the system can.
fn sync_folder_of(path: &Path) -> io::Result<()> {
    if cfg!(unix) {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        File::open(folder)?.sync_all()?;
    }
    Ok(())
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.file {
            Some(file) => file.write(bytes),
            None => Err(io::Error::other("the file is complete")),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.as_mut().map_or(Ok(()), Write::flush)
    }
}

impl Drop for AtomicFile {
    fn drop(&mut self) {
        if self.file.take().is_some() {
            // Nothing can be reported from here, and a stray partial file harms nobody.
            let _ = fs::remove_file(&self.partial);
        }
    }
}

/// Writes a file whole or not at all, and durably.
///
/// # Errors
/// What the system says; a file that had the name before is then untouched.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = AtomicFile::create(path)?;
    file.write_all(bytes)?;
    file.commit_durably()
}

/// Appends bytes to a file, all of them or, if the system refuses in the middle, none.
///
/// # Errors
/// What the system says.
pub fn append_whole(file: &mut File, bytes: &[u8]) -> io::Result<()> {
    let start = file.stream_position()?;
    file.write_all(bytes).inspect_err(|_| {
        // the first error is the one to report; what is not cut off now is when the run goes on
        let _ = file.set_len(start).and_then(|()| file.seek(SeekFrom::Start(start)));
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_folder::TestFolder;

    #[test]
    fn a_file_has_its_name_only_when_complete() {
        let folder = TestFolder::new();
        let path = folder.path().join("summary.json");
        write_atomically(&path, b"old").unwrap();
        let mut file = AtomicFile::create(&path).unwrap();
        file.write_all(b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        file.commit().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[cfg(unix)]
    #[test]
    fn what_is_in_the_way_is_named_as_the_file_that_it_is() {
        let folder = TestFolder::new();
        let path = folder.path().join("summary.json");
        std::os::unix::fs::symlink(folder.path().join("elsewhere"), folder.path().join("summary.json.partial"))
            .unwrap();
        let error = write_atomically(&path, b"new").unwrap_err().to_string();
        assert!(
            error.starts_with("summary.json.partial, as which it is written first: a link is in its place"),
            "{error}"
        );
    }

    #[test]
    fn an_abandoned_file_leaves_nothing_behind() {
        let folder = TestFolder::new();
        let mut file = AtomicFile::create(&folder.path().join("a")).unwrap();
        file.write_all(b"half").unwrap();
        drop(file);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn a_folder_that_is_not_there_is_an_error() {
        let folder = TestFolder::new();
        assert!(write_atomically(&folder.path().join("no/file"), b"").is_err());
    }
}
