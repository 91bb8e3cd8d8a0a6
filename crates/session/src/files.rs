//! The names of the files that a run writes, but for those of frames, which `estar_io` names.

use std::path::Path;

/// A row of numbers every so often.
pub const HISTORY: &str = "history.csv";
/// What a run was and what came of it.
pub const SUMMARY: &str = "summary.json";
/// How far the run is, a line every second.
pub const RECORDS: &str = "run.jsonl";
/// What was printed.
pub const LOG: &str = "estar.log";
/// The file that is locked. It stays when the run ends; the lock on it goes with the process, however that ends.
pub const LOCK: &str = "estar.lock";
/// The directory of the frames of an element that turned inside out, and its neighbours.
pub const TROUBLE: &str = "trouble";

/// The name of the checkpoint of a step.
pub fn checkpoint(step: u64) -> String {
    format!("checkpoint_{step:012}.estar")
}

/// Whether a file has the name of a checkpoint.
pub fn is_checkpoint(path: &Path) -> bool {
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let step = name.strip_prefix("checkpoint_").and_then(|rest| rest.strip_suffix(".estar"));
    step.is_some_and(|step| step.len() >= 12 && step.bytes().all(|byte| byte.is_ascii_digit()))
}
