//! What the columns are that a case's deck leads to: a check or a curve in units of something else is a slip of the pen.

use super::cases::{Case, Check, Quantity, Reference, Runner, When};
use estar_deck as deck;
use estar_deck::history_column;
use estar_deck::point_column::{Column, Driven};
use estar_deck::units::Dimension;
use std::collections::BTreeMap;
use std::path::Path;

/// The dimensions of the columns of a table that a command writes.
#[derive(Clone, Debug)]
pub enum Dimensions {
    /// history.csv, with the probes of the deck.
    History(BTreeMap<String, Dimension>),
    /// point.csv, with what the path measures.
    Point(Driven),
}

impl Dimensions {
    /// Those of a case whose deck has the text `deck`; nothing if it cannot be read, which the run will say.
    pub fn of(case: &Case, deck: &str) -> Option<Self> {
        let path = Path::new(&case.deck);
        match case.command {
            Runner::Run => {
                let deck = deck::read(path, deck, &case.set).deck?;
                let probe = |probe: deck::probe::ProbeTable| (probe.name.0.value, probe.kind.dimension());
                Some(Self::History(deck.probe.into_iter().map(probe).collect()))
            }
            Runner::Point => Some(Self::Point(deck::read_point(path, deck, &case.set).deck?.path.driven())),
        }
    }

    /// That of a column, if it is known.
    pub fn column(&self, name: &str) -> Option<Dimension> {
        match self {
            Self::History(_) if name == "mass" => Some(Dimension::MASS),
            Self::History(probes) => history_column::dimension(name).or_else(|| probes.get(name).copied()),
            Self::Point(driven) => {
                // what is compared has its name before the column
                let own = name.rsplit_once('.').map_or(name, |(_, own)| own);
                Column::all().into_iter().find(|column| column.name() == own)?.unit(*driven)
            }
        }
    }

    /// A quantity of the case that is in no unit of its column.
    pub fn fault(&self, case: &Case) -> Option<String> {
        let checks = case.check.iter().find_map(|check| self.fault_of_check(check));
        checks.or_else(|| case.curve.iter().find_map(|curve| self.fault_of_curve(curve, case.command)))
    }

    fn fault_of_check(&self, Check { quantity, at, value, tolerance, .. }: &Check) -> Option<String> {
        let mut wanted = vec![("value", quantity, value)];
        // a share of a value has no unit; of nothing it is a quantity
        if !tolerance.is_percentage() || value.si() == 0.0 {
            wanted.push(("tolerance", quantity, tolerance));
        }
        if let When::Where(places) = at {
            wanted.extend(places.iter().map(|(column, value)| ("at", column, value)));
        }
        wanted.into_iter().find_map(|(key, column, quantity)| self.misfit(key, column, quantity))
    }

    fn fault_of_curve(&self, curve: &Reference, command: Runner) -> Option<String> {
        let columns = [curve.over(command), &curve.quantity];
        let misfit = |point: &[Quantity; 2]| {
            columns.iter().zip(point).find_map(|(column, quantity)| self.misfit("points", column, quantity))
        };
        curve.points.iter().find_map(misfit)
    }

    fn misfit(&self, key: &str, column: &str, quantity: &Quantity) -> Option<String> {
        let wanted = self.column(column)?;
        let given = quantity.dimension().filter(|given| *given != wanted)?;
        Some(format!("`{key}` is {given}, {quantity}, but the column `{column}` is {wanted}"))
    }
}
