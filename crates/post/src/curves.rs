//! Which columns of a history are drawn, and which of them together.

use estar_deck::history_column;
use estar_deck::units::Dimension;

/// An energy that is never more than this share of the largest is not shown.
const SEEN: f64 = 1e-3;

/// Energies that share a panel.
const ENERGIES: [&str; 11] = [
    "kinetic_energy",
    "internal_energy",
    "plastic_dissipation",
    "external_work",
    "contact_energy",
    "friction_energy",
    "viscous_energy",
    "hourglass_energy",
    "damping_energy",
    "deleted_energy",
    "mass_scaling_energy",
];

/// Columns with a panel of their own.
const OTHERS: [&str; 5] =
    ["energy_error", "time_step", "max_equivalent_plastic_strain", "min_jacobian", "kinetic_over_internal"];

/// Columns that are no curve over time.
const SKIPPED: [&str; 6] = ["time", "step", "controlling_element", "momentum_x", "momentum_y", "momentum_z"];

/// Curves over time that share a panel.
#[derive(Clone, Debug, PartialEq)]
pub struct CurvePanel<'a> {
    /// What the axis says.
    pub label: String,
    /// SI unit; empty where there is none, or where the history does not tell it.
    pub unit: String,
    /// Whether the axis is logarithmic.
    pub is_logarithmic: bool,
    /// Whether it is a probe of the deck.
    pub is_probe: bool,
    /// The columns.
    pub columns: Vec<&'a str>,
}

/// The panels of a history with these columns, of each of which the largest absolute value is known: the energies that count,
/// then what has a panel of its own, then the probes.
pub fn panels<'a>(names: &[&'a str], largest: impl Fn(&str) -> f64) -> Vec<CurvePanel<'a>> {
    let has = |column: &str| names.iter().copied().find(|name| *name == column);
    let energies = || ENERGIES.iter().filter_map(|column| has(column));
    let most = energies().map(&largest).fold(0.0, f64::max);
    let seen = energies().filter(|column| largest(column) > SEEN * most).collect();
    let label = "energy".to_owned();
    let unit = Dimension::ENERGY.si_unit();
    let mut panels = vec![CurvePanel { label, unit, is_logarithmic: false, is_probe: false, columns: seen }];
    let alone = |column: &'a str| {
        let dimension = history_column::dimension(column);
        CurvePanel {
            label: plain(column),
            unit: dimension
                .filter(|dimension| *dimension != Dimension::NUMBER)
                .map_or(String::new(), Dimension::si_unit),
            // it begins at infinity, and what counts is how small it becomes
            is_logarithmic: column == "kinetic_over_internal",
            is_probe: dimension.is_none(),
            columns: vec![column],
        }
    };
    panels.extend(OTHERS.iter().filter_map(|column| has(column)).filter(|column| largest(column) > 0.0).map(alone));
    let is_known = |column: &&str| SKIPPED.contains(column) || ENERGIES.contains(column) || OTHERS.contains(column);
    panels.extend(names.iter().copied().filter(|column| !is_known(column)).map(alone));
    panels
}

/// The name of a column in words.
pub fn plain(column: &str) -> String {
    column.replace('_', " ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn energies_that_count_share_a_panel_and_probes_have_their_own() {
        let names = ["time", "step", "time_step", "kinetic_energy", "viscous_energy", "momentum_x", "heat", "length"];
        let largest = |name: &str| if name == "viscous_energy" { 1e-9 } else { 1.0 };
        let panels = panels(&names, largest);
        let columns: Vec<&[&str]> = panels.iter().map(|panel| panel.columns.as_slice()).collect();
        assert_eq!(columns, [&["kinetic_energy"], &["time_step"], &["heat"], &["length"]].map(|c: &[&str; 1]| &c[..]));
        assert_eq!(panels.iter().map(|panel| panel.unit.as_str()).collect::<Vec<_>>(), ["J", "s", "J", ""]);
        assert_eq!(panels.iter().map(|panel| panel.is_probe).collect::<Vec<_>>(), [false, false, false, true]);
    }
}
