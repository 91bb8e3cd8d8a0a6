//! Any bytes as a deck. What is not refused is set up on a mesh and makes its first steps.
#![no_main]

use estar_session::setup;
use estar_fuzz::{STEPS, workshop, write};
use estar_solver::LaneLevel;
use std::sync::LazyLock;
use tempfile::TempDir;

static WORKSHOP: LazyLock<TempDir> = LazyLock::new(workshop);

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let path = WORKSHOP.path().join("deck.toml");
    write(&path, bytes);
    match setup::load(&path, &[]) {
        Ok(problem) => {
            let _ = problem.findings.render(false);
            if let Ok(mut simulation) = setup::simulation(&problem, LaneLevel::best()) {
                while simulation.step() < STEPS && !simulation.is_finished() && simulation.advance().is_ok() {}
            }
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
});
