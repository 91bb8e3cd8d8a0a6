//! Checkpoints of a run: written whole or not at all, and taken up by `--resume`.
//!
//! The numbers of a checkpoint are those of [`Simulation::for_each_number`]; its head says of which run they are and how far
//! the outputs were, so that these go on without a gap and without a double.

use crate::bits::Bits;
use crate::error::SessionError;
use crate::expectations::Moment;
use crate::files;
use crate::inversion::Approach;
use crate::problem::Problem;
use estar_deck::format::hex;
use estar_io::{Checkpoint, CheckpointWriter, one_line};
use estar_mesh::Mesh;
use estar_solver::{STATE_LAYOUT, Simulation};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::fs;
use std::path::{Path, PathBuf};

/// Checkpoints that are kept.
const KEPT: usize = 2;

/// Which run a checkpoint is of.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identity {
    /// Version of Estar.
    pub version: String,
    /// Layout of the numbers of the state, [`STATE_LAYOUT`]; 0 of checkpoints that did not say.
    #[serde(default)]
    pub state_layout: u32,
    /// SHA-256 of the deck's text, and of overrides.
    pub deck: String,
    /// SHA-256 of the mesh.
    pub mesh: String,
}

/// How far the outputs of a run were.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bookmark {
    /// Rows of history.csv.
    pub history_rows: u64,
    /// Times of the frames, s.
    pub frame_times: Vec<Bits>,
    /// Step of the last frame.
    pub last_frame: Option<u64>,
    /// Bytes of run.jsonl.
    pub record_bytes: u64,
    /// Multiples of the intervals that have passed: of frames, of rows.
    pub passed: [u64; 2],
    /// Step of the last row.
    pub last_row: Option<u64>,
    /// Expectations whose moment is still to come.
    pub pending: Vec<usize>,
    /// Time and value of each expectation that has been looked at.
    pub outcomes: Vec<Option<[Bits; 2]>>,
    /// Step and smallest Jacobian of the last rows.
    pub jacobians: Vec<(u64, Bits)>,
    /// How close each part has come to inversion.
    pub approach: Approach,
    /// The first time step, s.
    pub initial_time_step: Bits,
    /// Wall time so far, s.
    pub wall_seconds: f64,
}

impl Bookmark {
    /// Where the outputs of a run are before its first row.
    pub fn beginning(problem: &Problem, simulation: &Simulation) -> Self {
        let expectations = &problem.expectations;
        let is_pending = |index: &usize| matches!(expectations[*index].moment, Moment::Time(_));
        Self {
            history_rows: 0,
            frame_times: Vec::new(),
            last_frame: None,
            record_bytes: 0,
            passed: [0; 2],
            last_row: None,
            pending: (0..expectations.len()).filter(is_pending).collect(),
            outcomes: vec![None; expectations.len()],
            jacobians: Vec::new(),
            approach: Approach::beginning(problem),
            initial_time_step: Bits::from(simulation.time_step()),
            wall_seconds: 0.0,
        }
    }

    /// Whether it can be one of a run of this problem: a checksum tells damage, but not forgery.
    fn is_of(&self, problem: &Problem) -> bool {
        let count = problem.expectations.len();
        self.outcomes.len() == count && self.pending.iter().all(|index| *index < count) && self.approach.is_of(problem)
    }
}

#[derive(Debug, Serialize, Deserialize)]
struct Head {
    #[serde(flatten)]
    identity: Identity,
    step: u64,
    time: f64,
    bookmark: Bookmark,
}

impl Identity {
    /// That of a problem.
    pub fn of(problem: &Problem) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            state_layout: STATE_LAYOUT,
            deck: problem.deck_hash.clone(),
            mesh: mesh_hash(&problem.mesh),
        }
    }

    /// What tells this run, whose checkpoint was found, from the `wanted` one.
    fn difference(&self, wanted: &Self) -> Option<String> {
        if self.version != wanted.version {
            // it may be forged
            let written_by = one_line(&self.version);
            return Some(format!("it was written by Estar {written_by}, and this is {}", wanted.version));
        }
        if self.state_layout != wanted.state_layout {
            let (found, read) = (self.state_layout, wanted.state_layout);
            return Some(format!("its state has layout {found}, and this program reads layout {read}"));
        }
        if self.mesh != wanted.mesh {
            return Some("it is of another mesh: the mesh file, or [mesh] scale, has changed since".to_owned());
        }
        let deck = "it is of another deck: the deck, or what was given by --set, has changed since";
        (self.deck != wanted.deck).then(|| deck.to_owned())
    }
}

/// SHA-256 of everything that a mesh is.
fn mesh_hash(mesh: &Mesh) -> String {
    let mut hasher = Sha256::new();
    let mut numbers = |numbers: &mut dyn Iterator<Item = u64>| {
        let mut bytes = Vec::with_capacity(1 << 16);
        for number in numbers {
            bytes.extend_from_slice(&number.to_le_bytes());
            if bytes.len() >= 1 << 16 {
                hasher.update(&bytes);
                bytes.clear();
            }
        }
        hasher.update(&bytes);
    };
    let count = |length: usize| std::iter::once(length as u64);
    numbers(&mut count(mesh.node_count()).chain(count(mesh.element_count())).chain(count(mesh.groups().len())));
    numbers(&mut mesh.coordinates().iter().flatten().map(|coordinate| coordinate.to_bits()));
    numbers(&mut mesh.node_labels().iter().map(|label| label.0));
    numbers(&mut mesh.elements().all_nodes().iter().map(|node| u64::from(*node)));
    numbers(&mut mesh.elements().shapes().iter().map(|shape| *shape as u64));
    numbers(&mut mesh.element_labels().iter().map(|label| label.0));
    for group in mesh.groups() {
        let name = group.name.bytes().map(u64::from);
        let members = |members: &[u32]| members.iter().map(|member| u64::from(*member)).collect::<Vec<_>>();
        numbers(&mut count(group.name.len()).chain(name).chain(count(group.kind as usize)));
        numbers(&mut count(group.nodes.len()).chain(members(&group.nodes)));
        numbers(&mut count(group.elements.len()).chain(members(&group.elements)));
        numbers(&mut count(group.faces.len()).chain(group.faces.iter().flat_map(|face| members(face.nodes()))));
    }
    hex(&hasher.finalize())
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// The checkpoints in a directory, the newest first.
fn checkpoints_in(directory: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(directory).into_iter().flatten().flatten();
    let mut found: Vec<PathBuf> = entries.map(|entry| entry.path()).filter(|path| files::is_checkpoint(path)).collect();
    // steps have as many digits as it takes; a longer name is a later step
    found.sort_by_key(|path| std::cmp::Reverse((path.as_os_str().len(), path.clone())));
    found
}

/// The checkpoints of a run that is under way.
#[derive(Debug)]
pub struct Checkpoints {
    directory: PathBuf,
    identity: Identity,
    /// Those that this process has written, which need not be read through.
    written: Vec<PathBuf>,
}

impl Checkpoints {
    /// Those of a run in its directory.
    pub fn of(directory: &Path, identity: Identity) -> Self {
        Self { directory: directory.to_owned(), identity, written: Vec::new() }
    }

    /// Writes the checkpoint of the present step and removes those that are too old; the file's name.
    ///
    /// # Errors
    /// It cannot be written; then the older ones stay.
    pub fn write(&mut self, bookmark: Bookmark, simulation: &Simulation) -> Result<String, SessionError> {
        let name = files::checkpoint(simulation.step());
        let path = self.directory.join(&name);
        let identity = self.identity.clone();
        let head = Head { identity, step: simulation.step(), time: simulation.time(), bookmark };
        let write = || -> std::io::Result<()> {
            let mut number_count = 0;
            simulation.for_each_number(|_| number_count += 1);
            let mut writer = CheckpointWriter::create(&path, &serde_json::to_string(&head)?, number_count)?;
            simulation.for_each_number(|number| writer.number(number));
            writer.commit()
        };
        write().map_err(SessionError::writing(&path))?;
        self.written.push(path);
        self.remove_old();
        Ok(name)
    }

    /// Keeps the last one that was written and sound ones before it, and removes those that are older than these. One that is
    /// damaged does not count; one of a later step is of an earlier leg, and waits until this one has passed it.
    fn remove_old(&mut self) {
        let Some(last) = self.written.last().cloned() else { return };
        let mut kept = Vec::new();
        for path in checkpoints_in(&self.directory).into_iter().skip_while(|path| *path != last) {
            if kept.len() == KEPT {
                // one that cannot be removed is only one too many
                let _ = fs::remove_file(path);
            } else if self.written.contains(&path) || open(&path, &self.identity).is_ok() {
                kept.push(path);
            }
        }
        self.written.retain(|path| kept.contains(path));
    }

    /// The newest good checkpoint of this run at a step or before it; if all are later, the oldest. None if there is none.
    pub fn before(&self, step: u64) -> Option<Found> {
        let mut oldest = None;
        for path in checkpoints_in(&self.directory) {
            let Ok((checkpoint, head)) = open(&path, &self.identity) else { continue };
            let found = Found::new(checkpoint, &path, head);
            if found.step <= step {
                return Some(found);
            }
            oldest = Some(found);
        }
        oldest
    }
}

/// A checkpoint that can be taken up.
#[derive(Debug)]
pub struct Found {
    checkpoint: Checkpoint,
    /// Its file's name.
    pub name: String,
    /// Its step.
    pub step: u64,
    /// How far the outputs were.
    pub bookmark: Bookmark,
    /// What was said of newer ones that cannot be taken up.
    pub refusals: Vec<String>,
}

/// The newest checkpoint in a directory that is whole, of this run, and can be taken up, which `take_up` says of it.
///
/// # Errors
/// There is none, with the reason for each that was refused.
pub fn newest(
    directory: &Path,
    identity: &Identity,
    mut take_up: impl FnMut(&Found) -> Result<(), String>,
) -> Result<Found, SessionError> {
    let mut refusals = Vec::new();
    for path in checkpoints_in(directory) {
        let name = name_of(&path);
        let opened = open(&path, identity).map(|(checkpoint, head)| Found::new(checkpoint, &path, head));
        match opened.and_then(|found| take_up(&found).map(|()| found)) {
            Ok(found) => return Ok(Found { refusals, ..found }),
            Err(reason) => refusals.push(format!("{name} cannot be taken up: {reason}")),
        }
    }
    Err(SessionError::NoCheckpoint { directory: directory.to_owned(), refusals })
}

fn open(path: &Path, wanted: &Identity) -> Result<(Checkpoint, Head), String> {
    let checkpoint = Checkpoint::open(path).map_err(|error| format!("it {error}"))?;
    let head: Head = serde_json::from_str(checkpoint.head())
        .map_err(|_| "it has a head of another version of this program".to_owned())?;
    match head.identity.difference(wanted) {
        Some(difference) => Err(difference),
        None => Ok((checkpoint, head)),
    }
}

impl Found {
    fn new(checkpoint: Checkpoint, path: &Path, head: Head) -> Self {
        Self { checkpoint, name: name_of(path), step: head.step, bookmark: head.bookmark, refusals: Vec::new() }
    }

    /// Brings a simulation of this run to the step of the checkpoint.
    ///
    /// # Errors
    /// The file cannot be read, or has a head or numbers that such a run has not; then the simulation is of no use any more.
    pub fn restore(&self, problem: &Problem, simulation: &mut Simulation) -> Result<(), String> {
        if !self.bookmark.is_of(problem) {
            return Err("its head is that of no run of this deck".to_owned());
        }
        let mut number_count = 0;
        simulation.for_each_number(|_| number_count += 1);
        if number_count != self.checkpoint.number_count() {
            let found = self.checkpoint.number_count();
            return Err(format!("it has {found} numbers where this run has {number_count}"));
        }
        let unreadable = |error| format!("it cannot be read: {error}");
        let mut numbers = self.checkpoint.numbers().map_err(unreadable)?;
        let restored = simulation.restore(|| numbers.next_number());
        numbers.finish().map_err(unreadable)?;
        restored.map_err(|error| error.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_is_that_of_the_latest_step() {
        let directory = tempfile::tempdir().unwrap();
        for step in [3, 999_999_999_999, 20, 1_000_000_000_000] {
            fs::write(directory.path().join(files::checkpoint(step)), "").unwrap();
        }
        for other in ["checkpoint_000000000003.estar.partial", "checkpoint_x.estar", "checkpoint_12.estar", "a"] {
            fs::write(directory.path().join(other), "").unwrap();
        }
        let names: Vec<String> = checkpoints_in(directory.path())
            .iter()
            .map(|path| path.file_name().unwrap().to_str().unwrap().to_owned())
            .collect();
        assert_eq!(names, [1_000_000_000_000, 999_999_999_999, 20, 3].map(files::checkpoint));
    }

    #[test]
    fn another_layout_of_the_state_is_refused_by_name() {
        let text = r#"{"version": "0.1.0", "deck": "d", "mesh": "m"}"#;
        let found: Identity = serde_json::from_str(text).unwrap();
        let wanted = Identity { state_layout: STATE_LAYOUT, ..found.clone() };
        let difference = found.difference(&wanted).unwrap();
        assert_eq!(difference, format!("its state has layout 0, and this program reads layout {STATE_LAYOUT}"));
        assert_eq!(wanted.difference(&wanted), None);
    }
}
