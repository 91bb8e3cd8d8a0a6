//! Files opened for what they are: ordinary ones. A device may never end, a pipe may never begin, and where results are written a
//! link that somebody has put there may lead anywhere.
//!
//! Each is looked at before it is opened, since to open a pipe is to wait for whoever has its other end.

use std::fs::{self, File, FileType, Metadata, OpenOptions};
use std::io::{self, ErrorKind, Read};
use std::path::Path;

/// Opens an ordinary file, or the one that a link leads to, to be read.
///
/// # Errors
/// What the system says; it is a folder, a device or a pipe.
pub fn open_ordinary(path: &Path) -> io::Result<File> {
    ordinary(&fs::metadata(path)?)?;
    let file = File::open(path)?;
    // whatever has taken its place meanwhile
    ordinary(&file.metadata()?)?;
    Ok(file)
}

fn ordinary(metadata: &Metadata) -> io::Result<()> {
    if metadata.is_file() {
        Ok(())
    } else if metadata.is_dir() {
        Err(ErrorKind::IsADirectory.into())
    } else {
        Err(io::Error::other("it is a device or a pipe; save its content to a file"))
    }
}

/// The content of an ordinary file of so many bytes at most.
///
/// # Errors
/// As [`open_ordinary`]; it is larger.
pub fn read_ordinary(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let file = open_ordinary(path)?;
    let mut bytes = Vec::with_capacity(usize::try_from(file.metadata()?.len().min(most)).unwrap_or(0));
    // one more than is kept, to know that there is more
    file.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        return Err(io::Error::new(ErrorKind::InvalidData, format!("it has more than {most} bytes")));
    }
    Ok(bytes)
}

/// Makes a new file, in place of an ordinary one that has its name.
///
/// # Errors
/// What the system says; what has its name is a link, a folder, a device or a pipe.
pub fn create_ordinary(path: &Path) -> io::Result<File> {
    match fs::symlink_metadata(path) {
        // removed, not emptied: a file may have other names elsewhere
        Ok(metadata) if metadata.is_file() => fs::remove_file(path)?,
        Ok(metadata) => return Err(in_the_way(metadata.file_type())),
        Err(error) if error.kind() == ErrorKind::NotFound => {}
        Err(error) => return Err(error),
    }
    OpenOptions::new().write(true).create_new(true).open(path)
}

/// Opens the ordinary file of this name to go on with it, or makes one.
///
/// # Errors
/// As [`create_ordinary`].
pub fn open_or_create(path: &Path, options: &mut OpenOptions) -> io::Result<File> {
    loop {
        match reopen(path, options) {
            Err(error) if error.kind() == ErrorKind::NotFound => {}
            opened => return opened,
        }
        match options.clone().create_new(true).open(path) {
            // another program was faster
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
            made => return made,
        }
    }
}

/// Opens the ordinary file of this name to go on with it.
///
/// # Errors
/// As [`create_ordinary`]; there is none.
pub fn reopen(path: &Path, options: &OpenOptions) -> io::Result<File> {
    let seen = fs::symlink_metadata(path)?;
    if !seen.is_file() {
        return Err(in_the_way(seen.file_type()));
    }
    let file = options.open(path)?;
    if is_same(&seen, &file.metadata()?) {
        Ok(file)
    } else {
        Err(io::Error::other("it was exchanged for another file while it was opened"))
    }
}

#[cfg(unix)]
fn is_same(seen: &Metadata, opened: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    (seen.dev(), seen.ino()) == (opened.dev(), opened.ino())
}

#[cfg(not(unix))]
fn is_same(_: &Metadata, opened: &Metadata) -> bool {
    opened.is_file()
}

/// Makes a folder, unless there is one that is no link.
///
/// # Errors
/// As [`create_ordinary`].
pub fn make_own_folder(path: &Path) -> io::Result<()> {
    match fs::create_dir(path) {
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {
            let found = fs::symlink_metadata(path)?;
            if found.is_dir() { Ok(()) } else { Err(in_the_way(found.file_type())) }
        }
        made => made,
    }
}

/// What is told of something that is in the place of results.
fn in_the_way(kind: FileType) -> io::Error {
    let what = match kind {
        kind if kind.is_symlink() => "a link",
        kind if kind.is_dir() => "a folder",
        kind if kind.is_file() => "a file",
        _ => "a device or a pipe",
    };
    io::Error::other(format!("{what} is in its place, through which nothing is written; remove it"))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use crate::test_folder::TestFolder;
    use std::io::Write;
    use std::os::unix::fs::symlink;
    use std::os::unix::net::UnixListener;

    #[test]
    fn what_is_read_is_an_ordinary_file_and_not_too_long() {
        let folder = TestFolder::new();
        let path = folder.path().join("file");
        fs::write(&path, "1234").unwrap();
        symlink(&path, folder.path().join("link")).unwrap();
        assert_eq!(read_ordinary(&folder.path().join("link"), 4).unwrap(), b"1234");
        assert!(read_ordinary(&path, 3).unwrap_err().to_string().contains("more than 3 bytes"));
        assert!(open_ordinary(Path::new("/dev/zero")).unwrap_err().to_string().contains("device or a pipe"));
        assert_eq!(open_ordinary(folder.path()).unwrap_err().kind(), ErrorKind::IsADirectory);
        let _socket = UnixListener::bind(folder.path().join("socket")).unwrap();
        assert!(open_ordinary(&folder.path().join("socket")).is_err());
        assert_eq!(open_ordinary(&folder.path().join("none")).unwrap_err().kind(), ErrorKind::NotFound);
    }

    #[test]
    fn nothing_is_written_through_a_link_a_pipe_or_another_name() {
        let folder = TestFolder::new();
        let precious = folder.path().join("precious");
        fs::write(&precious, "mine").unwrap();
        let at = |name: &str| folder.path().join(name);
        symlink(&precious, at("link")).unwrap();
        symlink(at("nowhere"), at("dangling")).unwrap();
        symlink(folder.path(), at("folder")).unwrap();
        let _socket = UnixListener::bind(at("socket")).unwrap();
        for name in ["link", "dangling", "folder", "socket"] {
            let mut options = OpenOptions::new();
            options.write(true);
            for refused in [
                create_ordinary(&at(name)).map(|_| ()),
                open_or_create(&at(name), &mut options).map(|_| ()),
                reopen(&at(name), &options).map(|_| ()),
                make_own_folder(&at(name)),
            ] {
                assert!(refused.unwrap_err().to_string().contains("is in its place"), "{name}");
            }
        }
        // another name of a file elsewhere is given up, and the file keeps its content
        fs::hard_link(&precious, at("twin")).unwrap();
        create_ordinary(&at("twin")).unwrap().write_all(b"new").unwrap();
        assert_eq!(
            (fs::read_to_string(&precious).unwrap(), fs::read_to_string(at("twin")).unwrap()),
            ("mine".into(), "new".into())
        );
        assert!(!at("nowhere").exists());
    }

    #[test]
    fn a_file_is_gone_on_with_or_made() {
        let folder = TestFolder::new();
        let path = folder.path().join("log");
        for _ in 0..2 {
            open_or_create(&path, OpenOptions::new().append(true)).unwrap().write_all(b"line\n").unwrap();
        }
        assert_eq!(fs::read_to_string(&path).unwrap(), "line\nline\n");
        make_own_folder(&folder.path().join("fields")).unwrap();
        make_own_folder(&folder.path().join("fields")).unwrap();
        assert!(make_own_folder(&path).is_err());
    }
}
