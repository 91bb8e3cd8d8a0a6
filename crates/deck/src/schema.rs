//! What a deck may contain, described by the types that read it.

use crate::units::Dimension;
use End::{Excluded, Included};

/// What a value must be.
#[derive(Clone, Debug)]
pub enum Schema {
    /// A string, with what it stands for.
    Text(&'static str),
    /// The name of a group of the mesh, with the kinds it may be.
    Group(&'static str),
    /// A whole number from 1.
    Count,
    /// A number or a string with a unit.
    Quantity(QuantitySchema),
    /// A list of quantities of one dimension, as long as said.
    Vector(QuantitySchema, usize),
    /// Three numbers, not all 0.
    Direction,
    /// A list of pairs of quantities.
    Points(QuantitySchema, QuantitySchema),
    /// A list of rows of so many quantities, with what they are.
    Rows(&'static str, usize),
    /// One of the names.
    Choice(Vec<Choice>),
    /// A table.
    Table(TableSchema),
    /// A list of values.
    List(Box<Schema>),
    /// A table whose keys are names that the user gives.
    Named(Box<Schema>),
    /// Any of these.
    Either(Vec<Schema>),
}

/// The dimension of a quantity, and the values that it may have.
#[derive(Clone, Copy, Debug)]
pub struct QuantitySchema {
    /// The dimension; none where it follows from another key.
    pub dimension: Option<Dimension>,
    /// The values in SI units.
    pub interval: Interval,
    /// Whether it is an angle, which must say in what.
    pub is_angle: bool,
}

/// Finite values between two ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// The end below, if any.
    pub low: Option<End>,
    /// The end above, if any.
    pub high: Option<End>,
}

/// An end of an interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// It belongs to the interval.
    Included(f64),
    /// It does not.
    Excluded(f64),
}

impl Interval {
    /// Every finite value.
    pub const ALL: Self = Self { low: None, high: None };
    /// Values greater than 0.
    pub const POSITIVE: Self = Self { low: Some(Excluded(0.0)), high: None };

    /// Whether a value is in it.
    pub fn contains(&self, value: f64) -> bool {
        let is_above = self.low.is_none_or(|end| match end {
            Included(low) => value >= low,
            Excluded(low) => value > low,
        });
        let is_below = self.high.is_none_or(|end| match end {
            Included(high) => value <= high,
            Excluded(high) => value < high,
        });
        value.is_finite() && is_above && is_below
    }

    /// The ends in words, such as "greater than 0", if there are any.
    pub fn words(&self) -> Option<String> {
        let above = |end| match end {
            Included(low) => format!("{low} or greater"),
            Excluded(low) => format!("greater than {low}"),
        };
        let below = |end| match end {
            Included(high) => format!("at most {high}"),
            Excluded(high) => format!("less than {high}"),
        };
        match (self.low, self.high) {
            (None, None) => None,
            (Some(low), None) => Some(above(low)),
            (None, Some(high)) => Some(below(high)),
            (Some(Included(low)), Some(Included(high))) => Some(format!("from {low} to {high}")),
            (Some(Excluded(low)), Some(Excluded(high))) => Some(format!("between {low} and {high}")),
            (Some(low), Some(high)) => Some(format!("{} and {}", above(low), below(high))),
        }
    }
}

/// A name that may be written, and what it means.
#[derive(Clone, Copy, Debug)]
pub struct Choice {
    /// The name.
    pub name: &'static str,
    /// Its meaning.
    pub doc: &'static str,
}

/// The keys of a table.
#[derive(Clone, Debug, Default)]
pub struct TableSchema {
    /// What the table is for.
    pub doc: &'static str,
    /// Its keys.
    pub keys: Vec<KeySchema>,
    /// Keys that depend on the value of another key.
    pub variants: Vec<Variants>,
}

/// A key of a table.
#[derive(Clone, Debug)]
pub struct KeySchema {
    /// The key.
    pub name: &'static str,
    /// What it means.
    pub doc: &'static str,
    /// Whether it must be there.
    pub presence: Presence,
    /// What its value must be.
    pub value: Schema,
}

/// Whether a key must be there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presence {
    /// It must.
    Required,
    /// It need not, and then there is nothing.
    Optional,
    /// It need not, and then it has this value, written as in a deck.
    Default(&'static str),
}

/// The keys that depend on the value of the key `tag`.
#[derive(Clone, Debug)]
pub struct Variants {
    /// The key.
    pub tag: &'static str,
    /// What it means.
    pub doc: &'static str,
    /// Its value where it is not there; without one it must be there.
    pub default: Option<&'static str>,
    /// Its values, each with the keys that belong to it.
    pub cases: Vec<(Choice, Vec<KeySchema>)>,
}

impl TableSchema {
    /// Moves the keys of another table into this one.
    pub fn absorb(&mut self, other: Self) {
        self.keys.extend(other.keys);
        self.variants.extend(other.variants);
    }
}
