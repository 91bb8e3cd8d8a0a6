//! `[[expect]]`: values that probes must have.

use estar_deck::Deck;
use estar_deck::diagnostics::{Diagnostic, Diagnostics};
use estar_deck::probe::When;
use estar_deck::units::Dimension;
use serde::Serialize;

/// A value that a probe must have.
#[derive(Clone, Copy, Debug)]
pub struct Expectation {
    /// Index of the probe.
    pub probe: usize,
    /// When.
    pub moment: Moment,
    /// The value, SI.
    pub value: f64,
    /// Allowed deviation, SI.
    pub tolerance: f64,
}

/// When an expectation is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Moment {
    /// At the end.
    End,
    /// At the first step at or after a time, s.
    Time(f64),
    /// At the row of the history where the probe is largest.
    Max,
}

/// What became of an expectation.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// The probe.
    pub probe: String,
    /// Time of the step that counted, s.
    pub time: f64,
    /// What was expected, SI.
    pub expected: f64,
    /// What came out, SI.
    pub found: f64,
    /// Allowed deviation, SI.
    pub tolerance: f64,
    /// Whether it was met.
    pub met: bool,
}

impl Expectation {
    /// What has become of it with the value `found` at `time`.
    pub fn outcome(&self, probe: &str, time: f64, found: f64) -> Outcome {
        Outcome {
            probe: probe.to_owned(),
            time,
            expected: self.value,
            found,
            tolerance: self.tolerance,
            met: (found - self.value).abs() <= self.tolerance,
        }
    }
}

/// The expectations of a deck, in SI units and by the probes' positions.
pub fn resolve(deck: &Deck, diagnostics: &mut Diagnostics) -> Vec<Expectation> {
    let mut expectations = Vec::new();
    for entry in &deck.expect {
        let Some(probe) = deck.probe.iter().position(|probe| probe.name.0.value == entry.probe.0.value) else {
            continue;
        };
        let wanted = deck.probe[probe].kind.dimension();
        let mut dimension_fault = |what: &str, given: Option<Dimension>, span| {
            if let Some(given) = given.filter(|given| *given != wanted) {
                let name = &entry.probe.0.value;
                let message = format!("`expect.{what}` is {given}, but the probe `{name}` gives {wanted}");
                let help = format!("such as \"1 {}\"", wanted.si_unit());
                diagnostics.push(Diagnostic::error(message).at(span, format!("{wanted} is needed")).help(help));
            }
        };
        let (value, tolerance) = (entry.value.value.0, entry.tolerance.value.0);
        dimension_fault("value", value.dimension, entry.value.span);
        if !tolerance.is_percentage {
            dimension_fault("tolerance", tolerance.dimension, entry.tolerance.span);
        }
        // a tolerance is a difference: 5 °C more or less are 5 K
        let difference = tolerance.value - tolerance.zero;
        let allowed = if tolerance.is_percentage { tolerance.value * value.value.abs() } else { difference };
        if allowed < 0.0 || (allowed == 0.0 && tolerance.is_percentage) {
            let message = "`expect.tolerance` allows no deviation at all";
            let help = "a percentage of a value other than 0, or a quantity in the unit of the probe";
            diagnostics.push(Diagnostic::error(message).at(entry.tolerance.span, "this tolerance").help(help));
        }
        let moment = match entry.at {
            When::End => Moment::End,
            When::Max => Moment::Max,
            When::Time(time) => {
                if time.value > deck.time.end.value {
                    let message =
                        format!("`expect.at` lies after the end of the simulation, {:?} s", deck.time.end.value);
                    diagnostics.push(Diagnostic::error(message).at(time.span, "too late"));
                }
                Moment::Time(time.value)
            }
        };
        expectations.push(Expectation { probe, moment, value: value.value, tolerance: allowed });
    }
    expectations
}
