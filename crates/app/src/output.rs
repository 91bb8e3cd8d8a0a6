//! What is written, and when.

use crate::checkpoint::is_checkpoint;
use crate::deck::Deck;
use crate::deck::settings::CheckpointEvery;
use crate::diagnostics::{Diagnostic, Diagnostics};
use crate::failure::Failure;
use crate::fields::Field;
use crate::inversion;
use estar_io::{FIELDS, PARTIAL, SERIES, make_own_folder};
use std::path::{Path, PathBuf};

/// Frames where the deck does not say how many.
const DEFAULT_FRAMES: u64 = 20;
/// Rows of the history where the deck does not say when.
const DEFAULT_ROWS: u64 = 1000;

/// What is written, and when.
#[derive(Clone, Debug)]
pub struct OutputPlan {
    /// Fields of the frames.
    pub fields: Vec<Field>,
    /// When frames are written.
    pub frames: Interval,
    /// When rows of the history are written.
    pub history: Interval,
    /// When checkpoints are written.
    pub checkpoint: CheckpointEvery,
}

/// How often something is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Interval {
    /// So many seconds of simulated time.
    Time(f64),
    /// So many steps.
    Steps(u64),
}

impl Interval {
    /// About how many times it falls due until `end` (s), at `steps` steps.
    pub fn count(self, end: f64, steps: f64) -> f64 {
        match self {
            Self::Time(interval) => (end / interval).min(steps).ceil() + 1.0,
            Self::Steps(count) => (steps / count as f64).ceil() + 1.0,
        }
    }
}

/// The plan of a deck.
pub fn output_plan(deck: &Deck, diagnostics: &mut Diagnostics) -> OutputPlan {
    let end = deck.time.end.value;
    let output = &deck.output;
    if let (Some(frames), Some(every)) = (&output.frames, &output.every) {
        let diagnostic = Diagnostic::error("`output` has both `frames` and `every`");
        diagnostics.push(diagnostic.at(every.span, "the interval").at(frames.span, "the number").help("one is enough"));
    }
    if let (Some(history), Some(steps)) = (&output.history, &output.history_steps) {
        let diagnostic = Diagnostic::error("`output` has both `history` and `history_steps`");
        diagnostics.push(diagnostic.at(steps.span, "in steps").at(history.span, "in time").help("one is enough"));
    }
    for (index, field) in output.fields.iter().enumerate() {
        if let Some(first) = output.fields[..index].iter().find(|other| other.value == field.value) {
            let diagnostic = Diagnostic::error("`output.fields` names a field twice").at(field.span, "the second time");
            diagnostics.push(diagnostic.at(first.span, "the first time").help("once is enough"));
        }
    }
    let frames = output.frames.map_or(DEFAULT_FRAMES, |frames| frames.value.0);
    OutputPlan {
        fields: output.fields.iter().map(|field| field.value).collect(),
        frames: Interval::Time(output.every.map_or(end / frames as f64, |every| every.value.value)),
        history: match (&output.history, &output.history_steps) {
            (Some(history), _) => Interval::Time(history.value.value),
            (None, Some(steps)) => Interval::Steps(steps.value.0),
            (None, None) => Interval::Time(end / DEFAULT_ROWS as f64),
        },
        checkpoint: output.checkpoint,
    }
}

/// Multiples of an interval that are counted; of more, not even the next can be told from the last.
const MOST_COUNTED: u64 = 1 << 53;

/// Says when something falls due: at the first step at or after each multiple of its interval.
#[derive(Clone, Copy, Debug)]
pub struct Schedule {
    interval: Interval,
    passed: u64,
}

impl Schedule {
    /// A schedule whose first turn, at time 0, is over.
    pub fn new(interval: Interval) -> Self {
        Self { interval, passed: 0 }
    }

    /// The schedule when so many multiples of the interval have passed.
    pub fn after(interval: Interval, passed: u64) -> Self {
        Self { interval, passed }
    }

    /// Multiples of the interval that have passed.
    pub fn passed(&self) -> u64 {
        self.passed
    }

    /// Whether it is due at a step; then it is not due again before the next multiple.
    pub fn is_due(&mut self, time: f64, step: u64) -> bool {
        let passed = match self.interval {
            Interval::Time(interval) => (time / interval * (1.0 + 1e-14)) as u64,
            Interval::Steps(count) => step / count,
        };
        // an interval that is nothing beside the time passes in every step
        let is_due = passed > self.passed || passed >= MOST_COUNTED;
        self.passed = passed;
        is_due
    }
}

/// The directory of results of a deck: beside it, named after it.
pub fn default_directory(deck: &Path) -> PathBuf {
    let directory = deck.with_extension("");
    if directory == deck { deck.with_extension("results") } else { directory }
}

/// Makes the output directory, unless it is there. It may be a link; what is in it may not.
///
/// # Errors
/// It is a file, or it cannot be made.
pub fn make_directory(directory: &Path) -> Result<(), Failure> {
    if directory.exists() && !directory.is_dir() {
        return Err(Failure::File(format!("error: {} is a file, not a directory", directory.display())));
    }
    let fields = directory.join(FIELDS);
    std::fs::create_dir_all(directory).and_then(|()| make_own_folder(&fields)).map_err(Failure::writing(&fields))
}

/// Refuses an output directory that holds results, or frees it of them by `force`.
///
/// # Errors
/// It holds results, or they cannot be removed.
pub fn clear_directory(directory: &Path, force: bool) -> Result<(), Failure> {
    let old = results_in(directory, "");
    if !old.is_empty() && !force {
        let message = format!(
            "error: {} holds results already\nhelp: take another directory with --output, overwrite these with --force, or go on \
             from their newest checkpoint with --resume",
            directory.display()
        );
        return Err(Failure::Input(message));
    }
    for file in old {
        std::fs::remove_file(&file).map_err(Failure::writing(&file))?;
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
    const FILES: [&str; 5] = [SERIES, "history.csv", "summary.json", "run.jsonl", "estar.log"];
    let is_of_run: fn(&Path) -> bool = |name| FILES.iter().any(|file| name.as_os_str() == *file) || is_checkpoint(name);
    let is_series: fn(&Path) -> bool = |name| name.as_os_str() == SERIES;
    let trouble = directory.join(inversion::FOLDER);
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
    fn schedule_is_due_once_at_or_after_each_multiple() {
        let mut schedule = Schedule::new(Interval::Time(1.0));
        let due: Vec<bool> = [0.4, 0.9, 1.0, 1.5, 3.7, 3.9, 4.1].iter().map(|t| schedule.is_due(*t, 0)).collect();
        assert_eq!(due, [false, false, true, false, true, false, true]);
        let mut schedule = Schedule::new(Interval::Steps(3));
        let due: Vec<bool> = (1..8).map(|step| schedule.is_due(0.0, step)).collect();
        assert_eq!(due, [false, false, true, false, false, true, false]);
    }

    #[test]
    fn absurd_intervals_fall_due_as_often_as_they_are_told_to() {
        let steps = 1000;
        let end = steps as f64 * 1e-9;
        for (interval, times) in [
            (Interval::Time(1e-300), steps),
            (Interval::Time(5e-324), steps),
            (Interval::Time(0.0), steps),
            (Interval::Time(end / 4e9), steps),
            (Interval::Time(1e300), 0),
            (Interval::Steps(1), steps),
            (Interval::Steps(u64::MAX), 0),
        ] {
            let mut schedule = Schedule::new(interval);
            let mut due = 0;
            for step in 1..=steps {
                // a run that goes on in the middle
                schedule = Schedule::after(interval, schedule.passed());
                due += u64::from(schedule.is_due(step as f64 * 1e-9, step));
            }
            assert_eq!(due, times, "{interval:?}");
            // those of time 0 and of the end are told, too
            let told = interval.count(end, steps as f64);
            assert!((told - due as f64 - 1.0).abs() <= 1.0, "{interval:?}: {told}");
        }
    }

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
        assert!(matches!(clear_directory(path, false), Err(Failure::Input(_))));
        clear_directory(path, true).unwrap();
        assert!(ours.iter().all(|file| !file.exists()) && theirs.iter().all(|file| file.exists()));
        assert!(matches!(make_directory(&theirs[0]), Err(Failure::File(_))));
    }
}
