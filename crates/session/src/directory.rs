//! The directory that a run writes to: made, cleared of results, and never of what is somebody else's.

use crate::error::SessionError;
use crate::files::{HISTORY, LOG, RECORDS, SUMMARY, TROUBLE, is_checkpoint};
use estar_io::{FIELDS, PARTIAL, SERIES, make_own_folder};
use std::path::{Path, PathBuf};

/// The directory of results of a deck: beside it, named after it.
pub fn default_directory(deck: &Path) -> PathBuf {
    let directory = deck.with_extension("");
    if directory == deck { deck.with_extension("results") } else { directory }
}

/// Makes the output directory, unless it is there. It may be a link; what is in it may not.
///
/// # Errors
/// It is a file, or it cannot be made.
pub fn make_directory(directory: &Path) -> Result<(), SessionError> {
    if directory.exists() && !directory.is_dir() {
        return Err(SessionError::NoDirectory { path: directory.to_owned() });
    }
    let fields = directory.join(FIELDS);
    std::fs::create_dir_all(directory).and_then(|()| make_own_folder(&fields)).map_err(SessionError::writing(&fields))
}

/// Refuses an output directory that holds results, or frees it of them by `force`.
///
/// # Errors
/// It holds results, or they cannot be removed.
pub fn clear_directory(directory: &Path, force: bool) -> Result<(), SessionError> {
    let old = results_in(directory, "");
    if !old.is_empty() && !force {
        return Err(SessionError::ResultsThere { directory: directory.to_owned() });
    }
    for file in old {
        std::fs::remove_file(&file).map_err(SessionError::writing(&file))?;
    }
    Ok(())
}

/// Removes what runs that were killed left of files on their way. The directory must be this run's own.
pub fn clear_partial_files(directory: &Path) {
    for path in results_in(directory, PARTIAL) {
        // one that cannot be removed is told of when it is in the way
        let _ = std::fs::remove_file(path);
    }
}

/// The files in a directory that a run has written, with `ending` behind their names. Links are neither such files nor followed.
fn results_in(directory: &Path, ending: &str) -> Vec<PathBuf> {
    const FILES: [&str; 5] = [SERIES, HISTORY, SUMMARY, RECORDS, LOG];
    let is_of_run: fn(&Path) -> bool = |name| FILES.iter().any(|file| name.as_os_str() == *file) || is_checkpoint(name);
    let is_series: fn(&Path) -> bool = |name| name.as_os_str() == SERIES;
    let trouble = directory.join(TROUBLE);
    let is_own = |folder: &Path| folder.symlink_metadata().is_ok_and(|metadata| metadata.is_dir());
    let mut found = Vec::new();
    for (folder, around, is_ours) in [
        (directory.to_owned(), directory, is_of_run),
        (directory.join(FIELDS), directory, is_frame),
        (trouble.clone(), directory, is_series),
        (trouble.join(FIELDS), trouble.as_path(), is_frame),
    ] {
        // the directory itself is wherever the user wants it
        if folder != directory && !(is_own(&folder) && (around == directory || is_own(around))) {
            continue;
        }
        let entries = std::fs::read_dir(&folder).into_iter().flatten().flatten();
        let files = entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_file()));
        found.extend(files.map(|entry| entry.path()).filter(|path| {
            let name = path.file_name().and_then(|name| name.to_str()).and_then(|name| name.strip_suffix(ending));
            name.is_some_and(|name| is_ours(Path::new(name)))
        }));
    }
    found
}

fn is_frame(path: &Path) -> bool {
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let number = name.strip_prefix("frame_").and_then(|rest| rest.strip_suffix(".vtu"));
    number.is_some_and(|number| !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(unix)]
    fn only_own_files_on_their_way_are_cleared() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path();
        make_directory(path).unwrap();
        let ours = ["results.pvd", "summary.json", "checkpoint_000000000012.estar", "fields/frame_00003.vtu"]
            .map(|name| path.join(format!("{name}.partial")));
        let theirs = ["notes.txt.partial", "fields/frame_x.vtu.partial", "history.csv.part", "frame_1.vtu", "notes"];
        ours.iter().for_each(|file| std::fs::write(file, "x").unwrap());
        theirs.iter().for_each(|file| std::fs::write(path.join(file), "x").unwrap());
        let link = path.join("fields/frame_00004.vtu.partial");
        std::os::unix::fs::symlink(path.join("notes"), &link).unwrap();
        std::os::unix::fs::symlink(path.join("fields"), path.join("trouble")).unwrap();
        clear_partial_files(path);
        assert!(ours.iter().all(|file| !file.exists()));
        assert!(theirs.iter().all(|file| path.join(file).exists()) && link.symlink_metadata().is_ok());
    }

    #[test]
    fn results_lie_beside_the_deck_and_are_named_after_it() {
        assert_eq!(default_directory(Path::new("a/taylor.toml")), Path::new("a/taylor"));
        assert_eq!(default_directory(Path::new("a/taylor")), Path::new("a/taylor.results"));
    }

    #[test]
    fn only_results_are_removed() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path();
        make_directory(path).unwrap();
        clear_directory(path, false).unwrap();
        let ours =
            ["history.csv", "fields/frame_00003.vtu", "checkpoint_000000000012.estar"].map(|name| path.join(name));
        let theirs = ["notes.txt", "fields/frame_x.vtu"].map(|name| path.join(name));
        ours.iter().chain(&theirs).for_each(|file| std::fs::write(file, "x").unwrap());
        assert!(matches!(clear_directory(path, false), Err(SessionError::ResultsThere { .. })));
        clear_directory(path, true).unwrap();
        assert!(ours.iter().all(|file| !file.exists()) && theirs.iter().all(|file| file.exists()));
        assert!(matches!(make_directory(&theirs[0]), Err(SessionError::NoDirectory { .. })));
    }
}
