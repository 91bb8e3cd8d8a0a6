//! Goal: `time_step = "power"` takes steps a few percent below the stable one of the assembled mesh through whole runs.
//!
//! Decks: the Taylor bar (copper at 227 m/s, 3,510 hexes, the foot to twice its radius) and the necking bar.
//!
//! Source: Lanczos' method with ten times as many steps as the run has, converged to 10⁻⁸.
//!
//! `cargo test --release --test time_step -- --ignored --nocapture` prints figures of `docs/time-step.md`.

use estar_session::Session;
use estar_solver::LaneLevel;
use std::path::Path;

/// Least and largest share of the exact stable step that a run of `steps` steps or less has at `looks` of them.
fn shares(deck: &str, steps: u64, looks: u64) -> (f64, f64) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes").join(deck);
    let settings = ["time.time_step='power'".to_owned(), "expect=[]".to_owned()];
    let mut session = Session::load(&path, &settings, LaneLevel::best(), &mut ()).unwrap();
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    loop {
        let simulation = session.simulation_mut();
        if simulation.step().is_multiple_of(steps / looks) {
            let used = simulation.extremes().stable_time_step;
            let [nearly, exact] = [260, 300].map(|k| simulation.exact_global_time_step(k));
            assert!((nearly / exact - 1.0).abs() < 1e-8, "{nearly} {exact}");
            let element = simulation.element_time_step();
            println!(
                "{deck} step {:6}: {used:.4e} s, exact {exact:.8e} s, {:.4} of it; bound of the elements {:.4} of it",
                simulation.step(),
                used / exact,
                element / exact
            );
            (least, most) = (least.min(used / exact), most.max(used / exact));
        }
        if simulation.is_finished() {
            return (least, most);
        }
        assert!(session.advance(&mut ()).unwrap().is_none());
    }
}

#[test]
#[ignore = "long"]
fn steps_of_the_taylor_bar_stay_below_the_exact_ones() {
    let (least, most) = shares("taylor/taylor.toml", 8_000, 8);
    assert!(least > 0.94 && most < 1.0, "{least} {most}");
}

#[test]
#[ignore = "long"]
fn steps_of_the_necking_bar_stay_below_the_exact_ones() {
    let (least, most) = shares("necking/necking.toml", 36_000, 6);
    assert!(least > 0.94 && most < 1.0, "{least} {most}");
}
