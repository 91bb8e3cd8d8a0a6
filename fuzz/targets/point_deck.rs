//! Any text as the deck of a material point. What is not refused is led along its path and drawn.
#![no_main]

use estar_deck as deck;
use estar_post::plot::Figure;
use estar::point::{Journey, panels};
use std::path::Path;

/// Longer paths are only read.
const MOST_STEPS: usize = 100;

libfuzzer_sys::fuzz_target!(|text: &str| {
    let reading = deck::read_point(Path::new("deck.toml"), text, &[]);
    let _ = reading.decoder.diagnostics.render(&reading.sources, true);
    let Some(problem) = reading.deck.filter(|problem| problem.path.times.len() <= MOST_STEPS) else { return };
    let journeys: Vec<Journey> = problem.subjects.iter().map(|subject| Journey::of(subject, &problem.path)).collect();
    let figure = Figure { title: String::new(), panels: panels(&problem, &journeys).collect() };
    if !figure.panels.is_empty() {
        assert!(!figure.drawing().svg().contains("NaN"));
    }
});
