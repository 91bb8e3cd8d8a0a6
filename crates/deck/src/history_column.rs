//! The columns of `history.csv`: their names, and what their numbers are.

use crate::units::Dimension;

/// The columns before those of the probes.
pub const COLUMNS: [&str; 18] = [
    "time",
    "step",
    "time_step",
    "kinetic_energy",
    "internal_energy",
    "plastic_dissipation",
    "viscous_energy",
    "hourglass_energy",
    "external_work",
    "contact_energy",
    "mass_scaling_energy",
    "energy_error",
    "momentum_x",
    "momentum_y",
    "momentum_z",
    "max_equivalent_plastic_strain",
    "min_jacobian",
    "controlling_element",
];

/// Columns that only some problems have; they follow those, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extra {
    /// Where a material has a temperature.
    Thermal,
    /// Where elements can be deleted.
    Deletion,
    /// Where walls are rough.
    Friction,
    /// Where vibration is damped.
    Damping,
    /// Where the process is quasi-static.
    QuasiStatic,
}

impl Extra {
    /// All of them, in the order of their columns.
    pub const ALL: [Self; 5] = [Self::Thermal, Self::Deletion, Self::Friction, Self::Damping, Self::QuasiStatic];

    /// Its columns.
    pub fn columns(self) -> &'static [&'static str] {
        match self {
            Self::Thermal => &["heat", "max_temperature"],
            Self::Deletion => &["deleted_energy", "deleted_elements"],
            Self::Friction => &["friction_energy"],
            Self::Damping => &["damping_energy"],
            Self::QuasiStatic => &["kinetic_over_internal"],
        }
    }
}

/// Whether a probe cannot have this name, because a column can.
pub fn is_column(name: &str) -> bool {
    COLUMNS.iter().chain(Extra::ALL.iter().flat_map(|extra| extra.columns())).any(|column| *column == name)
}

/// The dimension of a column that is no probe.
pub fn dimension(column: &str) -> Option<Dimension> {
    Some(match column {
        "time" | "time_step" => Dimension::TIME,
        "momentum_x" | "momentum_y" | "momentum_z" => Dimension::MOMENTUM,
        "max_temperature" => Dimension::TEMPERATURE,
        "step" | "controlling_element" | "deleted_elements" | "energy_error" => Dimension::NUMBER,
        "max_equivalent_plastic_strain" | "min_jacobian" | "kinetic_over_internal" => Dimension::NUMBER,
        "plastic_dissipation" | "external_work" | "heat" => Dimension::ENERGY,
        energy if is_column(energy) && energy.ends_with("_energy") => Dimension::ENERGY,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_column_that_is_no_probe_has_its_dimension() {
        let extras = Extra::ALL.iter().flat_map(|extra| extra.columns());
        for column in COLUMNS.iter().chain(extras) {
            assert!(dimension(column).is_some(), "{column}");
        }
        assert_eq!(dimension("my_energy"), None);
    }
}
