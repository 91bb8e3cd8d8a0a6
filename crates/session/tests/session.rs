//! Goal: a session gives the same bits whether it writes or not, in one go or in two, tells its observer what it does, and says by a
//! type what went wrong.
//!
//! Mesh: eight hexes. Loading: the block flies against a rigid wall. Source: the session itself, in one go.

use estar_io::write_gmsh;
use estar_mesh::generate::{BoxSpec, box_mesh};
use estar_session::{
    Beginning, Destination, Ending, Finished, Observer, Problem, Session, SessionError, Start, Summary,
};
use estar_solver::LaneLevel;
use std::cell::Cell;
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

const DECK: &str = r#"
mesh = { file = "mesh.msh" }
part = [{ group = "box", material = "rubber" }]
rigid_wall = [{ point = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0] }]
initial_velocity = [{ group = "box", value = [0.0, 0.0, -1.0] }]
probe = [{ name = "height", kind = "extent", group = "box", axis = "z" }]
expect = [
    { probe = "height", at = "0.1 ms", value = "1 mm", tolerance = "50 %" },
    { probe = "height", at = "max", value = "1 mm", tolerance = "50 %" },
    { probe = "height", at = "end", value = "1 mm", tolerance = "50 %" },
]
[material.rubber]
theory = "elastic"
density = 1000.0
young_modulus = "1 MPa"
poisson_ratio = 0.3
[time]
end = "0.2 ms"
[output]
frames = 2
history_steps = 1
"#;

fn workshop(deck: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut mesh = Vec::new();
    write_gmsh(&mut mesh, &box_mesh(&BoxSpec::new([1e-3; 3], [2; 3]).unwrap()), false).unwrap();
    fs::write(folder.path().join("mesh.msh"), mesh).unwrap();
    fs::write(folder.path().join("deck.toml"), deck).unwrap();
    folder
}

fn load(folder: &Path, observer: &mut dyn Observer) -> Result<Session, SessionError> {
    Session::load(&folder.join("deck.toml"), &[], LaneLevel::best(), observer)
}

fn into(folder: &Path, start: Start) -> Destination {
    Destination { directory: folder.join("results"), start, stop_at_step: None }
}

/// What an observer was told.
#[derive(Default)]
struct Told {
    loaded: usize,
    begun: Option<PathBuf>,
    /// Step of the checkpoint that was taken up.
    resumed: Option<u64>,
    progress: usize,
    notes: Vec<String>,
    ended: usize,
    /// Questions after which the run is to end.
    patience: Option<u64>,
    asked: Cell<u64>,
}

impl Observer for Told {
    fn loaded(&mut self, problem: &Problem) {
        assert_eq!(problem.mesh.element_count(), 8);
        self.loaded += 1;
    }

    fn begins(&mut self, beginning: &Beginning<'_>) -> Result<(), SessionError> {
        self.begun = Some(beginning.directory.to_owned());
        self.resumed = beginning.resumed.map(|resumed| resumed.step);
        assert_eq!(self.resumed.unwrap_or(0), beginning.simulation.step());
        Ok(())
    }

    fn progress(&mut self, _progress: &estar_session::Progress) {
        self.progress += 1;
    }

    fn notes(&mut self, note: &str) {
        self.notes.push(note.to_owned());
    }

    fn ends(&mut self) {
        self.ended += 1;
    }

    fn is_interrupted(&self) -> bool {
        self.asked.set(self.asked.get() + 1);
        self.patience.is_some_and(|patience| self.asked.get() > patience)
    }
}

fn ended(mut session: Session, observer: &mut dyn Observer) -> Finished {
    let ending = session.advance_to_end(observer).unwrap();
    session.finish(ending, observer).unwrap()
}

/// What of a summary is the same in every run of a deck.
fn essence(summary: &Summary) -> (String, u64, Vec<(f64, f64)>) {
    let seen = summary.expectations.iter().map(|outcome| (outcome.time, outcome.found)).collect();
    (summary.state_hash.clone(), summary.steps, seen)
}

#[test]
fn a_session_that_writes_ends_in_the_bits_of_one_that_does_not() {
    let folder = workshop(DECK);
    let silent = ended(load(folder.path(), &mut ()).unwrap(), &mut ());
    assert!(matches!(silent.ending, Ending::Finished) && silent.summary.expectations_met);
    assert!(!folder.path().join("results").exists());

    let mut told = Told::default();
    let mut session = load(folder.path(), &mut told).unwrap();
    session.write_to(&into(folder.path(), Start::Fresh), &mut told).unwrap();
    let written = ended(session, &mut told);
    assert_eq!(essence(&written.summary), essence(&silent.summary));
    assert_eq!(written.summary.expectations.len(), 3);
    assert_eq!((told.loaded, told.ended, told.resumed), (1, 1, None));
    assert_eq!(told.begun, Some(folder.path().join("results")));
    assert!(told.progress > 0 && told.asked.get() > written.summary.steps / 2);
    for file in ["history.csv", "run.jsonl", "summary.json", "results.pvd", "fields/frame_00002.vtu"] {
        assert!(folder.path().join("results").join(file).is_file(), "{file}");
    }
    // a row of the beginning, and one of every step
    let rows = fs::read_to_string(folder.path().join("results/history.csv")).unwrap().lines().count() as u64 - 1;
    assert_eq!(rows, written.summary.steps + 1);
}

#[test]
fn a_session_that_its_observer_ends_goes_on_to_the_same_bits() {
    let folder = workshop(DECK);
    let whole = ended(load(folder.path(), &mut ()).unwrap(), &mut ());
    let mut told = Told { patience: Some(7), ..Told::default() };
    let mut session = load(folder.path(), &mut told).unwrap();
    session.write_to(&into(folder.path(), Start::Fresh), &mut told).unwrap();
    let first = ended(session, &mut told);
    assert!(matches!(first.ending, Ending::Interrupted) && first.summary.steps == 7, "{:?}", first.summary);
    assert!(told.notes.iter().any(|note| note.starts_with("checkpoint_000000000007.estar")), "{:?}", told.notes);
    drop(first);

    let mut told = Told::default();
    let mut session = load(folder.path(), &mut told).unwrap();
    session.write_to(&into(folder.path(), Start::Resuming), &mut told).unwrap();
    assert_eq!((session.simulation().step(), told.resumed), (7, Some(7)));
    let second = ended(session, &mut told);
    assert_eq!(essence(&second.summary), essence(&whole.summary));
}

#[test]
fn the_fields_are_those_of_the_present_step() {
    let folder = workshop(DECK);
    let mut session = load(folder.path(), &mut ()).unwrap();
    let height = |session: &Session| session.problem().probes[0].value(&session.fields());
    let first = height(&session);
    assert!((first - 1e-3).abs() < 1e-15, "{first}");
    // a wave, at some 37 m/s, is on its way to the middle of the body
    while session.simulation().time() < 5e-6 {
        assert!(session.advance(&mut ()).unwrap().is_none());
    }
    // the foot stands, the head has not heard of it: h = h_0 − v t
    let fallen = session.simulation().time() * 1.0;
    let shorter = first - height(&session);
    assert!((shorter / fallen - 1.0).abs() < 0.01, "{shorter} {fallen}");
}

#[test]
fn what_is_wrong_is_told_by_its_type() {
    let folder = workshop(DECK);
    let write = |destination: &Destination| {
        let mut session = load(folder.path(), &mut ()).unwrap();
        session.write_to(destination, &mut ()).map(|()| session)
    };
    let refused = |destination: &Destination| write(destination).err().expect("it was taken");
    let none = refused(&into(folder.path(), Start::Resuming));
    assert!(matches!(&none, SessionError::NoCheckpoint { refusals, .. } if refusals.is_empty()), "{none}");
    let stop = Destination { stop_at_step: Some(5), ..into(folder.path(), Start::Fresh) };
    let stopped = ended(write(&stop).unwrap(), &mut ());
    assert!(matches!(stopped.ending, Ending::Stopped) && stopped.summary.steps == 5);
    let taken = refused(&into(folder.path(), Start::Overwriting));
    assert!(matches!(taken, SessionError::Taken { .. }), "{taken}");
    drop(stopped);
    let there = refused(&into(folder.path(), Start::Fresh));
    assert!(matches!(there, SessionError::ResultsThere { .. }), "{there}");
    let over = refused(&Destination { stop_at_step: Some(4), ..into(folder.path(), Start::Resuming) });
    assert!(matches!(over, SessionError::StopIsOver { stop: 4, step: 5, .. }), "{over}");
    let file = Destination { directory: folder.path().join("deck.toml"), ..into(folder.path(), Start::Fresh) };
    let file = refused(&file);
    assert!(matches!(file, SessionError::NoDirectory { .. }), "{file}");

    let missing = Session::load(&folder.path().join("none.toml"), &[], LaneLevel::best(), &mut ());
    assert!(matches!(missing, Err(SessionError::Deck(_))));
    let wrong = workshop(&DECK.replace("\"box\", material", "\"bax\", material"));
    let Err(SessionError::Faults { findings, .. }) = load(wrong.path(), &mut ()) else { panic!("it was taken") };
    assert!(findings.data().iter().any(|finding| finding.line == Some(3)), "{:?}", findings.data());
    let fast = workshop(&DECK.replace("end = \"0.2 ms\"", "end = 1e300"));
    let fast = load(fast.path(), &mut ()).err().expect("it was taken");
    assert!(matches!(fast, SessionError::Standstill { .. }), "{fast}");
}
