//! The table of verification: what is run, and what must come of it. Tests, docs and `estar verify` read the same one.

use crate::deck::units;
use crate::table::Table;
use serde::Deserialize;
use std::collections::BTreeMap;

/// The table that the program carries.
pub const TABLE: &str = include_str!("../../../../tests/verification.toml");

/// A run and what must come of it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Its name.
    pub name: String,
    /// What it shows.
    pub about: String,
    /// The deck, relative to the repository.
    pub deck: String,
    /// A mesh in place of the deck's.
    pub mesh: Option<MeshSource>,
    /// Overrides of the deck, as for `--set`.
    #[serde(default)]
    pub set: Vec<String>,
    /// Millions of element steps.
    pub cost: f64,
    /// Whether it is run only where all cases are.
    #[serde(default)]
    pub full: bool,
    /// Whether it is run again with other numbers of threads, and stopped and resumed, to the same bits.
    #[serde(default)]
    pub bits: bool,
    /// Axes whose planes of symmetry mirror the picture.
    #[serde(default)]
    pub mirror: Vec<String>,
    /// The values that it must give.
    pub check: Vec<Check>,
}

/// Where a mesh comes from.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
pub enum MeshSource {
    /// A file relative to the repository.
    File(String),
    /// Arguments of `estar mesh`.
    Generated(Vec<String>),
}

/// A value that a run must give.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Check {
    /// A column of history.csv, or `mass`.
    pub quantity: String,
    /// Which row of the history counts.
    #[serde(default = "at_the_end")]
    pub at: When,
    /// How many of the modelled part make the whole body.
    #[serde(default = "one")]
    pub times: f64,
    /// The value, with its unit.
    pub value: String,
    /// A percentage of the value, or a quantity in its unit.
    pub tolerance: String,
    /// Where the value is from.
    pub source: String,
}

/// Which row of the history counts.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
pub enum When {
    /// `start`, `end`, `largest` (the largest value of the run) or `always` (every row).
    Word(String),
    /// Where another column first rises to a value.
    Where(BTreeMap<String, String>),
}

fn at_the_end() -> When {
    When::Word("end".to_owned())
}

fn one() -> f64 {
    1.0
}

impl std::fmt::Display for When {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Word(word) => formatter.write_str(word),
            Self::Where(columns) => {
                let places: Vec<String> = columns.iter().map(|(column, value)| format!("{column} = {value}")).collect();
                formatter.write_str(&places.join(", "))
            }
        }
    }
}

/// The cases of a table.
///
/// # Errors
/// It is no such table; the message says where.
pub fn cases(text: &str) -> Result<Vec<Case>, String> {
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Cases {
        case: Vec<Case>,
    }
    let cases = toml::from_str::<Cases>(text).map_err(|error| error.to_string())?.case;
    for (index, case) in cases.iter().enumerate() {
        let name = &case.name;
        // it names a folder
        let is_name = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-'));
        if !is_name {
            return Err(format!("the case \"{name}\": a name has letters, digits, `_` and `-` only"));
        }
        if cases[..index].iter().any(|other| other.name == *name) {
            return Err(format!("two cases are named \"{name}\""));
        }
        if let Some(axis) = case.mirror.iter().find(|axis| !["x", "y", "z"].contains(&axis.as_str())) {
            return Err(format!("the case \"{name}\": mirror has x, y and z, not \"{axis}\""));
        }
        if case.check.iter().any(|check| matches!(&check.at, When::Where(places) if places.is_empty())) {
            return Err(format!("the case \"{name}\": `at` names no column"));
        }
    }
    Ok(cases)
}

/// What became of a check.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Finding {
    /// The quantity.
    pub quantity: String,
    /// Which row of the history counts.
    pub at: String,
    /// What was found, SI; of several rows that farthest from what was expected.
    pub found: f64,
    /// What was expected, SI.
    pub expected: f64,
    /// How far from it is allowed, SI.
    pub tolerance: f64,
    /// What was expected, as the table says it.
    pub wanted: String,
    /// Where that is from.
    pub source: String,
    /// Whether it was met.
    pub met: bool,
}

impl Check {
    /// Holds the check against the history of a run and the mass of its mesh (kg).
    ///
    /// # Errors
    /// The check cannot be made: a quantity, a time or a unit that there is none of.
    pub fn finding(&self, history: &Table, mass: f64) -> Result<Finding, String> {
        let expected = si(&self.value)?;
        let tolerance = match self.tolerance.strip_suffix('%') {
            Some(percent) if expected != 0.0 => {
                let share: f64 =
                    percent.trim().parse().map_err(|_| format!("\"{}\" is no tolerance", self.tolerance))?;
                share / 100.0 * expected.abs()
            }
            _ => si(&self.tolerance)?,
        };
        let values = if self.quantity == "mass" { vec![mass] } else { self.values(history)? };
        let distance = |value: &f64| (self.times * value - expected).abs();
        // what is no number is farther than any other
        let farthest = values.into_iter().max_by(|a, b| distance(a).total_cmp(&distance(b)));
        let found = self.times * farthest.ok_or("the history has no rows")?;
        Ok(Finding {
            quantity: self.quantity.clone(),
            at: if self.quantity == "mass" { String::new() } else { self.at.to_string() },
            found,
            expected,
            tolerance,
            wanted: format!("{} ± {}", self.value, self.tolerance),
            source: self.source.clone(),
            met: (found - expected).abs() <= tolerance,
        })
    }

    /// The values that count.
    fn values(&self, history: &Table) -> Result<Vec<f64>, String> {
        let column = column(history, &self.quantity)?;
        match &self.at {
            When::Word(word) => match (word.as_str(), column) {
                ("start", [first, ..]) => Ok(vec![*first]),
                ("end", [.., last]) => Ok(vec![*last]),
                ("largest", values) => Ok(vec![values.iter().copied().fold(f64::NEG_INFINITY, f64::max)]),
                ("always", values) => Ok(values.to_vec()),
                _ => Err(format!("at = \"{word}\" is none of start, end, largest and always")),
            },
            When::Where(places) => places
                .iter()
                .map(|(other, value)| where_reached(column, self::column(history, other)?, si(value)?))
                .collect(),
        }
    }
}

fn column<'a>(history: &'a Table, name: &str) -> Result<&'a [f64], String> {
    history.column(name).ok_or_else(|| format!("history.csv has no column \"{name}\""))
}

/// Value of a column where another first reaches `value`, between rows by a straight line.
fn where_reached(column: &[f64], other: &[f64], value: f64) -> Result<f64, String> {
    let after = (1..other.len()).find(|&row| other[row - 1] < value && value <= other[row]);
    let after = after.ok_or_else(|| format!("{value} is never reached"))?;
    let part = (value - other[after - 1]) / (other[after] - other[after - 1]);
    Ok(column[after - 1] + part * (column[after] - column[after - 1]))
}

/// SI value of a quantity such as `"7.22 mm"`.
fn si(text: &str) -> Result<f64, String> {
    units::parse(text).map(|measured| measured.value).map_err(|error| format!("\"{text}\": {error}"))
}
