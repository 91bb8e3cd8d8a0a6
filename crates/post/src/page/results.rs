//! What the page shows, read from the files that a run writes and from nothing else: a run under way, one that has ended and one
//! that was killed are the same to it. Files that are missing or cut short are waited for.

use super::body::Bodies;
use super::history::HistoryTail;
use super::stamp::Stamp;
use crate::plot::{figure, shaded};
use crate::series::Series;
use estar_io::{one_line, open_ordinary, read_ordinary, visible};
use estar_session::Holder;
use estar_session::files::{HISTORY, LOCK, LOG, RECORDS, SUMMARY};
use serde::Serialize;
use serde_json::Value;
use std::fs;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// Bytes at the end of `run.jsonl` in which its last line is.
const END_OF_RECORDS: u64 = 16 * 1024;
/// Bytes at the beginning and at the end of the log that are shown.
const SHOWN_OF_LOG: u64 = 6 * 1024;
/// A summary is not so large.
const LARGEST_SUMMARY: u64 = 4 << 20;
/// A run that has told nothing for so long, in seconds, is said to be silent, whatever lives under the number of its process.
const SILENCE: f64 = 60.0;

/// The results of a directory.
#[derive(Debug)]
pub struct Results {
    directory: PathBuf,
    history: Mutex<HistoryTail>,
    series: Mutex<Option<(Stamp, Arc<Series>)>>,
    bodies: Mutex<Bodies>,
}

/// Where a run is.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum Status {
    /// Nothing to be seen of it yet.
    Waiting,
    Running,
    /// It has said nothing for long, and may live or not.
    Silent,
    /// Its process has gone without an end.
    Killed,
    /// What its summary says: finished, stopped, interrupted, failed.
    #[serde(untagged)]
    Ended(String),
}

/// What the page asks for every second.
#[derive(Debug, Serialize)]
pub struct State {
    status: Status,
    directory: String,
    /// First line of the log without the name of the program.
    title: String,
    /// What there is to wait for, or what cannot be read.
    notes: Vec<String>,
    /// The last line of `run.jsonl`.
    progress: Option<Value>,
    /// Seconds since it was written.
    age: Option<f64>,
    /// Changes with `history.csv`.
    history_version: String,
    frames: usize,
    /// Changes with the series of frames.
    frames_version: String,
    /// Of `summary.json`, once the run has ended.
    summary: Option<Value>,
    beginning_of_log: String,
    end_of_log: String,
    /// From small to large values.
    colours: [[u8; 3]; shaded::COLOURS.len()],
    no_value: [u8; 3],
    curve_colours: [[u8; 3]; figure::COLOURS.len()],
}

impl State {
    /// Whether nothing more will come.
    pub fn has_ended(&self) -> bool {
        matches!(self.status, Status::Ended(_))
    }

    /// As JSON.
    pub fn json(&self) -> Vec<u8> {
        // its parts are numbers and words, which are never refused
        serde_json::to_vec(self).unwrap_or_default()
    }
}

impl Results {
    /// Those of a directory, which may still be empty.
    pub fn of(directory: &Path) -> Self {
        Self {
            directory: directory.to_owned(),
            history: Mutex::default(),
            series: Mutex::default(),
            bodies: Mutex::default(),
        }
    }

    /// How the run is.
    pub fn state(&self) -> State {
        let file = |name: &str| self.directory.join(name);
        let mut notes = Vec::new();
        if !self.directory.is_dir() {
            notes.push("the directory is not there (any more)".to_owned());
        }
        let records = file(RECORDS);
        let progress = last_record(&records);
        let age =
            Stamp::of(&records).ok().and_then(|stamp| stamp.written().elapsed().ok()).map(|age| age.as_secs_f64());
        let summary = file(SUMMARY);
        let mut content = read_summary(&summary);
        let holder = Holder::of(&self.directory);
        // a run that goes on leaves the summary of its earlier leg until it has its own
        let written = |path: &Path| Stamp::of(path).ok().map(Stamp::written);
        if holder == Holder::Alive && written(&summary) < written(&file(LOCK)) {
            content = None;
        }
        // a run that goes on has the lines of its earlier leg until it has its own
        let taken = Stamp::of(&file(LOCK)).ok().and_then(|stamp| stamp.written().elapsed().ok());
        let silence = age.map(|age| taken.map_or(age, |taken| age.min(taken.as_secs_f64())));
        let status = status(content.as_ref(), progress.as_ref(), holder, silence);
        if !matches!(status, Status::Ended(_)) {
            content = None;
        }
        if progress.is_none() && content.is_none() {
            notes.push("waiting for the first line of run.jsonl".to_owned());
        }
        let stamp = Stamp::of(&file(HISTORY));
        match &stamp {
            Ok(_) => notes.extend(self.locked_history().note().map(|note| format!("history.csv: {note}"))),
            Err(_) => notes.push("waiting for history.csv".to_owned()),
        }
        let series = self.series();
        if let Err(note) = &series {
            notes.push(note.clone());
        }
        let (frames, frames_version) = match &series {
            Ok((stamp, series)) => (series.frames.len(), stamp.version()),
            Err(_) => (0, String::new()),
        };
        let log = file(LOG);
        let beginning_of_log = piece(&log, SeekFrom::Start(0), SHOWN_OF_LOG).unwrap_or_default();
        let first = beginning_of_log.lines().next().unwrap_or("");
        let name = self.directory.canonicalize().unwrap_or_else(|_| self.directory.clone());
        State {
            status,
            directory: one_line(&name.display().to_string()),
            title: first.split_once(": ").map_or(first, |(_, title)| title).to_owned(),
            notes: notes.iter().map(|note| one_line(note)).collect(),
            progress,
            age,
            history_version: stamp.map_or(String::new(), Stamp::version),
            frames,
            frames_version,
            summary: content,
            beginning_of_log,
            end_of_log: end_of(&log, SHOWN_OF_LOG).unwrap_or_default(),
            colours: shaded::COLOURS,
            no_value: shaded::NO_VALUE,
            curve_colours: figure::COLOURS,
        }
    }

    /// The curves, as JSON.
    pub fn history(&self) -> Vec<u8> {
        let mut history = self.locked_history();
        history.update(&self.directory.join(HISTORY));
        history.json()
    }

    fn locked_history(&self) -> std::sync::MutexGuard<'_, HistoryTail> {
        self.history.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The outer surface of a frame (the newest unless its number is given) with a field on it.
    ///
    /// # Errors
    /// What is missing, or cannot be read.
    pub fn surface(
        &self,
        number: Option<usize>,
        field: Option<&str>,
        component: Option<&str>,
    ) -> Result<Arc<[u8]>, String> {
        let (_, series) = self.series()?;
        let number = number.unwrap_or(series.frames.len() - 1);
        let (_, path) = series.frames.get(number).ok_or_else(|| format!("there is no frame {number}"))?;
        // one at a time: memory for one frame is enough, and two pages ask for the same
        let mut bodies = self.bodies.lock().unwrap_or_else(PoisonError::into_inner);
        bodies.surface(number, path, field, component)
    }

    /// The frames so far, read again only when there are others.
    fn series(&self) -> Result<(Stamp, Arc<Series>), String> {
        let waiting = |_| "waiting for the first frame in results.pvd".to_owned();
        let stamp = Stamp::of(&Series::file(&self.directory)).map_err(waiting)?;
        let mut known = self.series.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((of, series)) = known.as_ref().filter(|(of, _)| *of == stamp) {
            return Ok((*of, Arc::clone(series)));
        }
        let series = Arc::new(Series::of(&self.directory).map_err(|error| format!("error: {error}"))?);
        *known = Some((stamp, Arc::clone(&series)));
        Ok((stamp, series))
    }
}

/// What is known of a run, put together, with the seconds since it began or said anything.
fn status(summary: Option<&Value>, progress: Option<&Value>, holder: Holder, silence: Option<f64>) -> Status {
    let step = |of: Option<&Value>, name: &str| of.and_then(|of| of.get(name)).and_then(Value::as_u64);
    let told = summary.and_then(|summary| summary.get("status")).and_then(Value::as_str);
    let has_gone_on = step(progress, "step") > step(summary, "steps") && told != Some("failed");
    match (told, progress, holder) {
        // the steps after its summary are those of a later leg; one that failed is left at the step before its last
        (Some(told), _, _) if !has_gone_on => Status::Ended(told.to_owned()),
        (_, None, Holder::Gone | Holder::Unknown) => Status::Waiting,
        (_, Some(_), Holder::Gone) => Status::Killed,
        (_, Some(_), _) if silence.is_some_and(|silence| silence > SILENCE) => Status::Silent,
        (_, _, Holder::Alive) | (_, Some(_), Holder::Unknown) => Status::Running,
    }
}

fn read_summary(path: &Path) -> Option<Value> {
    let bytes = read_ordinary(path, LARGEST_SUMMARY).ok()?;
    serde_json::from_slice(&bytes).ok().map(shown)
}

/// A value whose words turn no page about.
fn shown(value: Value) -> Value {
    match value {
        Value::String(text) => Value::String(visible(&text).into_owned()),
        Value::Array(values) => Value::Array(values.into_iter().map(shown).collect()),
        Value::Object(entries) => Value::Object(
            entries.into_iter().map(|(name, value)| (visible(&name).into_owned(), shown(value))).collect(),
        ),
        other => other,
    }
}

/// The last line of `run.jsonl` that is whole.
fn last_record(path: &Path) -> Option<Value> {
    let end = end_of(path, END_OF_RECORDS)?;
    let whole = &end[..end.rfind('\n')?];
    let line = whole.rsplit('\n').next()?;
    serde_json::from_str(line).ok().filter(Value::is_object).map(shown)
}

/// The end of a file, of so many bytes at most, from the beginning of a line.
fn end_of(path: &Path, bytes: u64) -> Option<String> {
    let length = fs::metadata(path).ok()?.len();
    let start = length.saturating_sub(bytes);
    let text = piece(path, SeekFrom::Start(start), bytes)?;
    if start == 0 {
        return Some(text);
    }
    text.split_once('\n').map(|(_, whole)| whole.to_owned())
}

fn piece(path: &Path, start: SeekFrom, bytes: u64) -> Option<String> {
    let mut file = open_ordinary(path).ok()?;
    file.seek(start).ok()?;
    let mut content = Vec::new();
    file.take(bytes).read_to_end(&mut content).ok()?;
    Some(visible(&String::from_utf8_lossy(&content)).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn the_status_follows_from_summary_progress_and_process() {
        let at = |step: u64| Some(json!({ "step": step }));
        let ended = |status: &str, steps: u64| Some(json!({ "status": status, "steps": steps }));
        let finished = || Status::Ended("finished".to_owned());
        for (summary, progress, holder, age, expected) in [
            (None, None, Holder::Unknown, None, Status::Waiting),
            (None, None, Holder::Alive, None, Status::Running),
            (None, at(5), Holder::Alive, Some(1.0), Status::Running),
            (None, at(5), Holder::Alive, Some(900.0), Status::Silent),
            (None, at(5), Holder::Gone, Some(1.0), Status::Killed),
            (None, at(5), Holder::Unknown, Some(1.0), Status::Running),
            (None, at(5), Holder::Unknown, Some(900.0), Status::Silent),
            (ended("finished", 9), at(9), Holder::Gone, Some(900.0), finished()),
            (ended("finished", 9), at(9), Holder::Alive, Some(0.1), finished()),
            (ended("finished", 9), None, Holder::Unknown, None, finished()),
            // the step at which it failed is not the state that it left
            (ended("failed", 8), at(9), Holder::Gone, Some(1.0), Status::Ended("failed".to_owned())),
            (ended("interrupted", 5), at(9), Holder::Gone, Some(1.0), Status::Killed),
        ] {
            assert_eq!(status(summary.as_ref(), progress.as_ref(), holder, age), expected);
        }
    }

    #[test]
    fn a_directory_that_holds_nothing_or_rubbish_is_waited_for() {
        let directory = tempfile::tempdir().unwrap();
        let results = Results::of(directory.path());
        let state = results.state();
        assert_eq!((state.status.clone(), state.frames), (Status::Waiting, 0));
        assert_eq!(state.notes.len(), 3, "{:?}", state.notes);
        assert!(results.surface(None, None, None).unwrap_err().starts_with("waiting for"));
        for name in ["run.jsonl", "history.csv", "results.pvd", "summary.json", "estar.log", "estar.lock"] {
            fs::write(directory.path().join(name), b"\xff\x00{,<DataSet\n\n{").unwrap();
        }
        let state = results.state();
        assert_eq!((state.status.clone(), state.frames), (Status::Waiting, 0));
        results.history();
        assert!(results.surface(None, None, None).is_err());
        serde_json::from_slice::<Value>(&state.json()).unwrap();
    }

    #[test]
    fn the_last_whole_line_is_the_progress() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("run.jsonl");
        let long = "{\"step\":1}\n".repeat(5000);
        fs::write(&path, format!("{long}{{\"step\":2}}\n{{\"step\":3")).unwrap();
        assert_eq!(last_record(&path).unwrap()["step"], 2);
        fs::write(&path, "{\"step\":2}").unwrap();
        assert_eq!(last_record(&path), None);
    }
}
