//! The files that make up an Abaqus input: the file itself and those that it includes, at the places where they are included.

use std::borrow::Cow;
use std::fs;
use std::path::{Path, PathBuf};

use super::keyword::{Keyword, Lines, Origin};
use crate::error::{Place, Problem, ReadError};
use crate::file::read_ordinary;

/// An include within an include, and so on, this deep at most.
const MOST_DEPTH: usize = 20;
/// This many files in all: each may be read at a place of its own.
const MOST_FILES: usize = 1000;
/// One file may be included so often.
const MOST_TIMES: usize = 10;

/// One file's bytes, and where others come in.
#[derive(Debug)]
pub(super) struct Source<'a> {
    /// As messages show it.
    pub name: String,
    pub bytes: Cow<'a, [u8]>,
    pub insertions: Vec<Insertion>,
    /// On disk, free of links; none of what was never a file.
    path: Option<PathBuf>,
    /// The file and the line that include this one.
    included_by: Option<Origin>,
}

/// Another file that is read when this one has been read up to a place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Insertion {
    pub at: usize,
    /// Where it goes on afterwards, and the number of the line before.
    pub resume: (usize, u64),
    /// The other file.
    pub source: usize,
}

/// The file with all that it includes, which has so many bytes at most. `path` is where it lies, if it is a file.
pub(super) fn load<'a>(
    bytes: &'a [u8],
    name: &str,
    path: Option<&Path>,
    limit: u64,
) -> Result<Vec<Source<'a>>, ReadError> {
    let path = path.and_then(|path| fs::canonicalize(path).ok());
    let mut sources = vec![Source {
        name: name.to_owned(),
        bytes: Cow::Borrowed(bytes),
        insertions: Vec::new(),
        path,
        included_by: None,
    }];
    let mut next = 0;
    while next < sources.len() {
        for (keyword, at, resume) in includes(&sources, next) {
            let included = read_include(&sources, &keyword, limit)?;
            sources.push(included);
            let source = sources.len() - 1;
            sources[next].insertions.push(Insertion { at, resume, source });
        }
        next += 1;
    }
    Ok(sources)
}

/// The keywords of a file that bring in another, where its lines come in, and where the file itself goes on.
fn includes(sources: &[Source], source: usize) -> Vec<(Keyword, usize, (usize, u64))> {
    let mut lines = Lines::of_one(sources, source);
    let mut found = Vec::new();
    while let Some(line) = lines.next_keyword() {
        let start = line.start;
        let keyword = Keyword::parse(&line, &mut lines);
        if keyword.value("INPUT").is_none() {
            continue;
        }
        let resume = lines.position();
        match keyword.name.as_str() {
            "INCLUDE" => found.push((keyword, start, resume)),
            // the data lines of these may stand in a file of their own
            "NODE" | "ELEMENT" | "NSET" | "ELSET" => found.push((keyword, resume.0, resume)),
            _ => {}
        }
    }
    found
}

fn read_include<'a>(sources: &[Source], keyword: &Keyword, limit: u64) -> Result<Source<'a>, ReadError> {
    let origin = keyword.origin;
    let includer = &sources[origin.source as usize];
    let fail = |what: String, advice| ReadError::Content {
        file: includer.name.clone(),
        place: Place::Line(origin.line),
        problem: Box::new(Problem::NotSupported { what, advice }),
    };
    let wanted = keyword.value("INPUT").unwrap_or_default();
    if wanted.is_empty() {
        let message = format!("*{} names no file after INPUT=", keyword.name);
        return Err(keyword.syntax(message).in_file(&includer.name));
    }
    let Some(of_includer) = &includer.path else {
        return Err(fail(format!("*{}, INPUT={wanted}", keyword.name), "save the mesh to a file beside the other"));
    };
    if sources.len() >= MOST_FILES {
        return Err(fail(format!("a mesh of more than {MOST_FILES} files"), "join them"));
    }
    // relative to the file that names it, or to the first one, where Abaqus itself looks
    let folders = [Some(of_includer), sources[0].path.as_ref()].into_iter().flatten().filter_map(|path| path.parent());
    let with_slashes = wanted.replace('\\', "/");
    let candidates: Vec<PathBuf> =
        folders.flat_map(|folder| [folder.join(wanted), folder.join(&with_slashes)]).collect();
    let found = candidates.iter().find(|path| path.exists()).or(candidates.first());
    let found = found.ok_or_else(|| fail(format!("INPUT={wanted}"), "name a file"))?;
    let name = format!("{}, which {}:{} names", found.display(), includer.name, origin.line);
    let unreadable = |source| ReadError::Unreadable { file: name, source };
    let so_far: u64 = sources.iter().map(|source| source.bytes.len() as u64).sum();
    if fs::metadata(found).is_ok_and(|metadata| metadata.is_file() && metadata.len() > limit.saturating_sub(so_far)) {
        return Err(keyword.origin.fail(Problem::NoMemory { limit }).in_file(&includer.name));
    }
    let bytes = read_ordinary(found, u64::MAX).map_err(unreadable.clone())?;
    let path = fs::canonicalize(found).map_err(unreadable)?;

    let mut depth = 1;
    let mut above = Some(origin);
    while let Some(of_above) = above {
        let source = &sources[of_above.source as usize];
        if source.path.as_ref() == Some(&path) {
            return Err(fail(
                format!("the file {wanted}, which includes itself,"),
                "take the *INCLUDE out of one of them",
            ));
        }
        depth += 1;
        above = source.included_by;
    }
    if depth > MOST_DEPTH {
        return Err(fail(format!("*INCLUDE in more than {MOST_DEPTH} files in one another"), "join some of them"));
    }
    if sources.iter().filter(|source| source.path.as_ref() == Some(&path)).count() >= MOST_TIMES {
        return Err(fail(format!("including {wanted} more than {MOST_TIMES} times"), "include it once"));
    }
    let bytes = match bytes.strip_prefix(b"\xef\xbb\xbf") {
        Some(rest) => rest.to_vec(),
        None => bytes,
    };
    let name = found.display().to_string();
    Ok(Source { name, bytes: bytes.into(), insertions: Vec::new(), path: Some(path), included_by: Some(origin) })
}
