//! The table of verification: what is run, and what must come of it. Tests, docs and `estar verify` read the same one.

use estar_deck::format::digits;
use estar_deck::units::{self, Dimension, Measured};
use estar_post::table::Table;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt;

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
    /// What runs it.
    #[serde(default)]
    pub command: Runner,
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
    /// Curves that the report draws beside those of the run.
    #[serde(default)]
    pub curve: Vec<Reference>,
}

/// The command that runs a deck.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Runner {
    /// `estar run`.
    #[default]
    Run,
    /// `estar point`.
    Point,
}

impl Runner {
    /// The table that it writes.
    pub fn table(self) -> &'static str {
        match self {
            Self::Run => "history.csv",
            Self::Point => "point.csv",
        }
    }

    /// The column that the others are drawn over.
    pub fn abscissa(self) -> &'static str {
        match self {
            Self::Run => "time",
            Self::Point => "driven",
        }
    }
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
    /// A column of the table that the command writes, or `mass`.
    pub quantity: String,
    /// Which row of the table counts.
    #[serde(default = "at_the_end")]
    pub at: When,
    /// How many of the modelled part make the whole body.
    #[serde(default = "one")]
    pub times: f64,
    /// The value, with its unit.
    pub value: Quantity,
    /// A percentage of the value, or a quantity in its unit.
    pub tolerance: Quantity,
    /// Where the value is from.
    pub source: String,
}

/// A curve that others published, or a closed form, at some points.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reference {
    /// The column that it is a curve of.
    pub quantity: String,
    /// The column that it is over; `time`, or `driven` for a point, unless given.
    pub over: Option<String>,
    /// Its points.
    #[serde(default)]
    pub points: Vec<[Quantity; 2]>,
    /// A file with them, relative to the repository: two columns in SI units under their names, `over` first.
    pub file: Option<String>,
    /// Whether it is straight from point to point.
    #[serde(default)]
    pub straight: bool,
    /// Where it is from.
    pub source: String,
}

impl Reference {
    /// The column that it is over.
    pub fn over(&self, command: Runner) -> &str {
        self.over.as_deref().unwrap_or(command.abscissa())
    }
}

/// A quantity of the table: a number in SI units, or a string such as `"7.22 mm"`.
#[derive(Clone, Debug, Deserialize)]
#[serde(try_from = "Written")]
pub struct Quantity {
    text: String,
    measured: Measured,
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "a quantity is a number or a string such as \"7.22 mm\"")]
enum Written {
    Text(String),
    Number(f64),
}

impl TryFrom<Written> for Quantity {
    type Error = String;

    fn try_from(written: Written) -> Result<Self, String> {
        let text = match written {
            Written::Text(text) => text,
            Written::Number(number) => number.to_string(),
        };
        let measured = units::parse(&text).map_err(|error| format!("\"{text}\": {error}"))?;
        if !measured.value.is_finite() {
            return Err(format!("\"{text}\" is too large"));
        }
        Ok(Self { text, measured })
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.text)
    }
}

impl Quantity {
    /// Its value, SI.
    pub fn si(&self) -> f64 {
        self.measured.value
    }

    /// The dimension of its unit, if it has one.
    pub fn dimension(&self) -> Option<Dimension> {
        self.measured.dimension
    }

    /// A value in SI units as it reads in the unit of this one.
    fn in_its_unit(&self, value: f64) -> String {
        let unit = self.text.trim().split_once(' ').map_or("", |(_, unit)| unit.trim());
        match units::parse(&format!("1 {unit}")) {
            Ok(one) if !unit.is_empty() => {
                format!("{} {unit}", digits((value - one.zero) / (one.value - one.zero), 6))
            }
            _ => digits(value, 6),
        }
    }

    /// Whether it is a percentage.
    pub fn is_percentage(&self) -> bool {
        self.measured.is_percentage
    }
}

/// Which row of the table counts.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged, expecting = "`at` is start, end, largest, always or { COLUMN = VALUE }")]
pub enum When {
    /// `start`, `end`, `largest` (the largest value of the run) or `always` (every row).
    Word(Word),
    /// Where another column first rises to a value.
    Where(BTreeMap<String, Quantity>),
}

/// A row of the table by its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Word {
    /// The first.
    Start,
    /// The last.
    End,
    /// That of the largest value.
    Largest,
    /// All of them.
    Always,
}

fn at_the_end() -> When {
    When::Word(Word::End)
}

fn one() -> f64 {
    1.0
}

impl fmt::Display for When {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Word(Word::Start) => "start",
            Self::Word(Word::End) => "end",
            Self::Word(Word::Largest) => "largest",
            Self::Word(Word::Always) => "always",
            Self::Where(columns) => {
                let places: Vec<String> = columns.iter().map(|(column, value)| format!("{column} = {value}")).collect();
                return formatter.write_str(&places.join(", "));
            }
        })
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
        if let Some(fault) = case.fault() {
            return Err(format!("the case \"{name}\": {fault}"));
        }
    }
    Ok(cases)
}

impl Case {
    /// What of it cannot be, whatever its deck says.
    fn fault(&self) -> Option<String> {
        if let Some(axis) = self.mirror.iter().find(|axis| !["x", "y", "z"].contains(&axis.as_str())) {
            return Some(format!("mirror has x, y and z, not \"{axis}\""));
        }
        if self.command == Runner::Point && (self.mesh.is_some() || self.bits || !self.mirror.is_empty()) {
            return Some("a material point has no `mesh`, `bits` and `mirror`".to_owned());
        }
        if self.check.is_empty() {
            return Some("`check` is empty: nothing could fail".to_owned());
        }
        for check in &self.check {
            let Check { quantity, at, value, tolerance, .. } = check;
            if check.allowance() < 0.0 {
                return Some(format!("`{quantity}`: a tolerance of {tolerance} is negative"));
            }
            if matches!(at, When::Where(places) if places.is_empty()) {
                return Some("`at` names no column".to_owned());
            }
            if tolerance.is_percentage()
                && value.si() == 0.0
                && value.dimension().is_some_and(|it| it != Dimension::NUMBER)
            {
                return Some(format!("`{quantity}`: {tolerance} of {value} allows no deviation at all"));
            }
        }
        for Reference { quantity, points, file, .. } in &self.curve {
            if points.is_empty() == file.is_none() {
                return Some(format!("the curve of `{quantity}` needs either `points` or `file`"));
            }
        }
        None
    }
}

/// What became of a check.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Finding {
    /// The quantity.
    pub quantity: String,
    /// Which row of the table counts.
    pub at: String,
    /// What was found, SI; of several rows that farthest from what was expected.
    pub found: f64,
    /// What was expected, SI.
    pub expected: f64,
    /// How far from it is allowed, SI.
    pub tolerance: f64,
    /// The SI unit of the three; empty for a pure number, and where it is not known.
    pub unit: String,
    /// What was found, in the unit of what was expected.
    pub shown: String,
    /// What was expected, as the table says it.
    pub wanted: String,
    /// Where that is from.
    pub source: String,
    /// Whether it was met.
    pub met: bool,
}

impl Finding {
    /// How far what is found is from what is expected, as a share of what is allowed; nothing where no deviation is.
    pub fn share_of_tolerance(&self) -> Option<f64> {
        (self.tolerance > 0.0).then(|| (self.found - self.expected).abs() / self.tolerance)
    }
}

impl Check {
    /// How far from the value is allowed, SI.
    pub fn allowance(&self) -> f64 {
        let Measured { value, zero, is_percentage, .. } = self.tolerance.measured;
        // a tolerance is a difference: 5 °C more or less are 5 K
        if is_percentage && self.value.si() != 0.0 { value * self.value.si().abs() } else { value - zero }
    }

    /// Holds the check against the table of a run and the mass of its mesh (kg).
    ///
    /// # Errors
    /// The check cannot be made: a quantity or a place that there is none of.
    pub fn finding(&self, table: &Table, mass: Option<f64>) -> Result<Finding, String> {
        let (expected, tolerance) = (self.value.si(), self.allowance());
        let is_mass = self.quantity == "mass";
        let values = if is_mass { vec![mass.ok_or("there is no mass")?] } else { self.values(table)? };
        let distance = |value: &f64| (self.times * value - expected).abs();
        // what is no number is farther than any other
        let farthest = values.into_iter().max_by(|a, b| distance(a).total_cmp(&distance(b)));
        let found = self.times * farthest.ok_or("the table has no rows")?;
        Ok(Finding {
            quantity: self.quantity.clone(),
            at: if is_mass { String::new() } else { self.at.to_string() },
            found,
            expected,
            tolerance,
            unit: String::new(),
            shown: self.value.in_its_unit(found),
            wanted: format!("{} ± {}", self.value, self.tolerance),
            source: self.source.clone(),
            met: (found - expected).abs() <= tolerance,
        })
    }

    /// The values that count.
    fn values(&self, table: &Table) -> Result<Vec<f64>, String> {
        let column = column(table, &self.quantity)?;
        Ok(match &self.at {
            When::Word(Word::Start) => column.first().copied().into_iter().collect(),
            When::Word(Word::End) => column.last().copied().into_iter().collect(),
            When::Word(Word::Largest) => vec![largest(column)],
            When::Word(Word::Always) => column.to_vec(),
            When::Where(places) => {
                let reached =
                    |(other, value): (&String, &Quantity)| where_reached(column, self::column(table, other)?, value);
                return places.iter().map(reached).collect();
            }
        })
    }
}

/// The largest of some numbers; none if one of them is none, which `f64::max` would pass over.
fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().copied().fold(f64::NEG_INFINITY, |a, b| if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) })
}

fn column<'a>(table: &'a Table, name: &str) -> Result<&'a [f64], String> {
    table.column(name).ok_or_else(|| format!("there is no column \"{name}\""))
}

/// Value of a column where another first reaches `value`, between rows by a straight line.
fn where_reached(column: &[f64], other: &[f64], value: &Quantity) -> Result<f64, String> {
    let wanted = value.si();
    let after = (1..other.len()).find(|&row| other[row - 1] < wanted && wanted <= other[row]);
    let after = after.ok_or_else(|| format!("{value} is never reached"))?;
    let part = (wanted - other[after - 1]) / (other[after] - other[after - 1]);
    Ok(column[after - 1] + part * (column[after] - column[after - 1]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_of_numbers_with_one_that_is_none_is_none() {
        assert_eq!(largest(&[-3.0, -1.0, -2.0]), -1.0);
        for numbers in [[f64::NAN, 1.0, 2.0], [1.0, f64::NAN, 2.0], [1.0, 2.0, f64::NAN]] {
            assert!(largest(&numbers).is_nan(), "{numbers:?}");
        }
    }
}
