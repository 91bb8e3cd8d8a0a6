//! What the generators ask of their parameters.

use thiserror::Error;

/// A parameter out of its bounds.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{parameter} = {}: must be {bound}", short(*value))]
pub struct SpecError {
    /// The parameter.
    pub parameter: &'static str,
    /// Its value.
    pub value: f64,
    /// What it must be.
    pub bound: &'static str,
}

/// A number in at most some twenty characters.
fn short(value: f64) -> String {
    let is_short = value == 0.0 || (1e-6..1e12).contains(&value.abs());
    if is_short { format!("{value}") } else { format!("{value:e}") }
}

/// A generated mesh has at most this many hexes: past it, memory is short before indices are.
const MOST_HEXES: f64 = 5e8;

/// Lengths are in any unit, but their cubes must be numbers.
pub(super) fn positive_length(parameter: &'static str, value: f64) -> Result<f64, SpecError> {
    if (1e-90..=1e90).contains(&value) {
        Ok(value)
    } else {
        Err(SpecError { parameter, value, bound: "a length greater than 0, from 1e-90 to 1e90" })
    }
}

pub(super) fn positive_count(parameter: &'static str, value: u32) -> Result<u32, SpecError> {
    if value >= 1 { Ok(value) } else { Err(SpecError { parameter, value: 0.0, bound: "1 or more" }) }
}

pub(super) fn grading_ratio(parameter: &'static str, value: f64) -> Result<f64, SpecError> {
    if (1e-3..=1e3).contains(&value) {
        Ok(value)
    } else {
        Err(SpecError { parameter, value, bound: "between 0.001 and 1000" })
    }
}

pub(super) fn hex_count(value: f64) -> Result<(), SpecError> {
    if value <= MOST_HEXES {
        Ok(())
    } else {
        Err(SpecError { parameter: "number of hexes", value, bound: "at most 500 million" })
    }
}
