//! What a deck may contain, described by the types that read it.

use super::units::Dimension;

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
    /// A list of pairs of quantities.
    Points(QuantitySchema, QuantitySchema),
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

/// The dimension of a quantity, and its bound in words.
#[derive(Clone, Copy, Debug)]
pub struct QuantitySchema {
    /// The dimension; none where it follows from another key.
    pub dimension: Option<Dimension>,
    /// The bound, such as "greater than 0".
    pub bound: Option<&'static str>,
    /// Whether it is an angle, which must say in what.
    pub is_angle: bool,
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
