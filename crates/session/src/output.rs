//! What is written, and when.

use estar_deck::Deck;
use estar_deck::diagnostics::{Diagnostic, Diagnostics};
use estar_deck::fields::Field;
use estar_deck::settings::CheckpointEvery;

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn schedule_is_due_once_at_or_after_each_multiple() {
        let mut schedule = Schedule::after(Interval::Time(1.0), 0);
        let due: Vec<bool> = [0.4, 0.9, 1.0, 1.5, 3.7, 3.9, 4.1].iter().map(|t| schedule.is_due(*t, 0)).collect();
        assert_eq!(due, [false, false, true, false, true, false, true]);
        let mut schedule = Schedule::after(Interval::Steps(3), 0);
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
            let mut schedule = Schedule::after(interval, 0);
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
}
