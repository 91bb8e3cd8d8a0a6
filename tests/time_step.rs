//! Goal: `time_step = "power"` takes steps within a few percent below the stable one of the assembled mesh through whole runs.
//!
//! Decks: the Taylor bar (copper at 227 m/s, 3,510 hexes, the foot to three times its radius) and, of the necking bar, the beginning.
//!
//! Source: Lanczos' method with ten times as many steps as the run has, converged to 10⁻⁸.
//!
//! `cargo test --release --test time_step -- --nocapture` prints the figures of `docs/time-step.md`.

use estar::setup;
use estar_solver::LaneLevel;
use std::path::Path;

/// Runs a deck for `steps` steps at most and prints the step against the exact one `looks` times; the least and the most.
fn shares(deck: &str, overrides: &[&str], steps: u64, looks: u64) -> (f64, f64) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes").join(deck);
    let mut settings = vec!["time.time_step='power'".to_owned()];
    settings.extend(overrides.iter().map(ToString::to_string));
    let problem = setup::load(&path, &settings).unwrap();
    let mut simulation = setup::simulation(&problem, LaneLevel::best()).unwrap();
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    loop {
        if simulation.step().is_multiple_of(steps / looks) {
            let used = simulation.extremes().stable_time_step;
            let exact = simulation.exact_global_time_step(300);
            let converged = simulation.exact_global_time_step(260);
            assert!((converged / exact - 1.0).abs() < 1e-8, "{converged} {exact}");
            let element = simulation.element_time_step();
            println!(
                "{deck} step {:6}: {used:.4e} s, exact {exact:.8e} s, {:.4} of it; bound of the elements {:.4} of it",
                simulation.step(),
                used / exact,
                element / exact
            );
            (least, most) = (least.min(used / exact), most.max(used / exact));
        }
        if simulation.is_finished() || simulation.step() == steps {
            println!("{} estimates in {} steps", simulation.estimate_count(), simulation.step());
            return (least, most);
        }
        simulation.advance().unwrap();
    }
}

#[test]
fn steps_of_the_taylor_bar_are_3_percent_below_the_exact_ones_or_less_and_never_above() {
    let (least, most) = shares("taylor/taylor.toml", &[], 20_000, 100);
    assert!(least > 0.94 && most < 1.0, "{least} {most}");
}

#[test]
fn steps_of_the_necking_bar_are_3_percent_below_the_exact_ones_or_less_and_never_above() {
    let (least, most) = shares("necking/necking.toml", &[], 100_000, 25);
    assert!(least > 0.94 && most < 1.0, "{least} {most}");
}
