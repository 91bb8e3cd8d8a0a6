//! Any bytes as a deck. What is not refused is set up on a mesh and makes its first steps.
#![no_main]

use estar_session::Session;
use estar_fuzz::{STEPS, workshop, write};
use estar_solver::LaneLevel;
use std::sync::LazyLock;
use tempfile::TempDir;

static WORKSHOP: LazyLock<TempDir> = LazyLock::new(workshop);

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let path = WORKSHOP.path().join("deck.toml");
    write(&path, bytes);
    match Session::load(&path, &[], LaneLevel::best(), &mut ()) {
        Ok(mut session) => {
            let _ = session.problem().findings.render(false);
            while session.simulation().step() < STEPS && matches!(session.advance(&mut ()), Ok(None)) {}
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
});
