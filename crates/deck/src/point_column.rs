//! The columns of point.csv.

use crate::units;
use estar_material::point::{Observation, StretchMeasure};

/// A column of point.csv.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Column {
    /// The time, s.
    Time,
    /// The value of the curve.
    Driven,
    /// A component of F, by row and column from 0.
    Gradient(usize, usize),
    /// A component of a stress or a strain, by its place in the order 11, 22, 33, 12, 13, 23.
    Component(Quantity, usize),
    /// ε̄ᵖ.
    EquivalentPlasticStrain,
    /// Φ where the material flows.
    HardeningIndex,
    /// ĝ, Pa²/s, of a material that can flow.
    LoadingIndex,
    /// What plastic flow has dissipated, J per m³ of reference volume.
    Dissipation,
    /// The work of the stress, J per m³ of reference volume.
    InternalEnergy,
    /// det C_p.
    PlasticDeterminant,
    /// Temperature, K.
    Temperature,
}

/// A symmetric tensor of point.csv.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Cauchy stress T.
    Stress,
    /// Rotated Cauchy stress RᵀTR.
    RotatedStress,
    /// Second Piola-Kirchhoff stress S.
    SecondPiolaStress,
    /// Green strain E.
    GreenStrain,
    /// Plastic strain E_p.
    PlasticStrain,
    /// Elastic strain E_*.
    ElasticStrain,
    /// Strain difference E − E_p.
    StrainDifference,
}

impl Quantity {
    /// All of them, in the order of the columns.
    const ALL: [Self; 7] = [
        Self::Stress,
        Self::RotatedStress,
        Self::SecondPiolaStress,
        Self::GreenStrain,
        Self::PlasticStrain,
        Self::ElasticStrain,
        Self::StrainDifference,
    ];

    fn is_stress(self) -> bool {
        matches!(self, Self::Stress | Self::RotatedStress | Self::SecondPiolaStress)
    }
}

/// Components in the order of the columns, with their places in a symmetric tensor.
const COMPONENTS: [(&str, usize); 6] = [("11", 0), ("22", 1), ("33", 2), ("12", 3), ("13", 5), ("23", 4)];

/// What the numbers of a column are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// Pure numbers.
    Number,
    /// Seconds.
    Time,
    /// Pascals.
    Stress,
    /// Joules per m³.
    EnergyDensity,
    /// Kelvins.
    Temperature,
    /// Pa²/s.
    LoadingRate,
}

/// What is told of a material at a moment.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// The time, s.
    pub time: f64,
    /// The value of the curve.
    pub driven: f64,
    /// What there is to tell of the point.
    pub observation: Observation,
    /// Whether plastic strain grew in the last step.
    pub flows: bool,
}

impl Column {
    /// T_ij by its place in the order 11, 22, 33, 12, 13, 23.
    pub const fn stress(place: usize) -> Self {
        Self::Component(Quantity::Stress, place)
    }

    /// All columns in their order.
    pub fn all() -> Vec<Self> {
        let gradient = (0..3).flat_map(|i| (0..3).map(move |j| Self::Gradient(i, j)));
        let components = |quantity| (0..COMPONENTS.len()).map(move |place| Self::Component(quantity, place));
        let scalars = [
            Self::EquivalentPlasticStrain,
            Self::HardeningIndex,
            Self::LoadingIndex,
            Self::Dissipation,
            Self::InternalEnergy,
            Self::PlasticDeterminant,
            Self::Temperature,
        ];
        let tensors = gradient.chain(Quantity::ALL.into_iter().flat_map(components));
        [Self::Time, Self::Driven].into_iter().chain(tensors).chain(scalars).collect()
    }

    /// Whether it belongs to the path, not to the material on it.
    pub fn is_of_path(self) -> bool {
        matches!(self, Self::Time | Self::Driven)
    }

    /// The name at its head.
    pub fn name(self) -> String {
        let letters = |quantity| match quantity {
            Quantity::Stress => "T",
            Quantity::RotatedStress => "R",
            Quantity::SecondPiolaStress => "S",
            Quantity::GreenStrain => "E",
            Quantity::PlasticStrain => "Ep",
            Quantity::ElasticStrain => "Es",
            Quantity::StrainDifference => "Ed",
        };
        match self {
            Self::Time => "time".to_owned(),
            Self::Driven => "driven".to_owned(),
            Self::Gradient(i, j) => format!("F{}{}", i + 1, j + 1),
            Self::Component(quantity, place) => format!("{}{}", letters(quantity), COMPONENTS[place].0),
            Self::EquivalentPlasticStrain => "equivalent_plastic_strain".to_owned(),
            Self::HardeningIndex => "hardening_index".to_owned(),
            Self::LoadingIndex => "loading_index".to_owned(),
            Self::Dissipation => "dissipation".to_owned(),
            Self::InternalEnergy => "internal_energy".to_owned(),
            Self::PlasticDeterminant => "det_Cp".to_owned(),
            Self::Temperature => "temperature".to_owned(),
        }
    }

    /// Its value in a row; none where there is nothing to tell.
    pub fn value(self, row: &Row) -> Option<f64> {
        let seen = &row.observation;
        Some(match self {
            Self::Time => row.time,
            Self::Driven => row.driven,
            Self::Gradient(i, j) => seen.deformation_gradient.at(i, j),
            Self::Component(quantity, place) => {
                let tensor = match quantity {
                    Quantity::Stress => seen.stress,
                    Quantity::RotatedStress => seen.rotated_stress,
                    Quantity::SecondPiolaStress => seen.second_piola_stress,
                    Quantity::GreenStrain => seen.green_strain,
                    Quantity::PlasticStrain => seen.factors.plastic_strain(),
                    Quantity::ElasticStrain => seen.factors.elastic_strain(),
                    Quantity::StrainDifference => seen.green_strain - seen.factors.plastic_strain(),
                };
                tensor.0[COMPONENTS[place].1]
            }
            Self::EquivalentPlasticStrain => seen.equivalent_plastic_strain,
            Self::HardeningIndex => return seen.hardening_index.filter(|_| row.flows),
            Self::LoadingIndex => return seen.loading_index,
            Self::Dissipation => seen.plastic_dissipation,
            Self::InternalEnergy => seen.internal_energy,
            Self::PlasticDeterminant => seen.plastic_determinant,
            Self::Temperature => return seen.temperature,
        })
    }

    /// What its numbers are.
    pub fn dimension(self) -> Dimension {
        match self {
            Self::Time => Dimension::Time,
            Self::Temperature => Dimension::Temperature,
            Self::LoadingIndex => Dimension::LoadingRate,
            Self::Component(quantity, _) if quantity.is_stress() => Dimension::Stress,
            Self::Dissipation | Self::InternalEnergy => Dimension::EnergyDensity,
            _ => Dimension::Number,
        }
    }

    /// The dimension of its unit on such a path; none for what no deck has a unit of.
    pub fn unit(self, driven: Driven) -> Option<units::Dimension> {
        Some(match self.dimension() {
            Dimension::Number if self == Self::Driven && driven == Driven::Time => units::Dimension::TIME,
            Dimension::Number => units::Dimension::NUMBER,
            Dimension::Time => units::Dimension::TIME,
            // J/m³ are Pa
            Dimension::Stress | Dimension::EnergyDensity => units::Dimension::STRESS,
            Dimension::Temperature => units::Dimension::TEMPERATURE,
            Dimension::LoadingRate => return None,
        })
    }

    /// Its symbol, with the markup of plots.
    pub fn symbol(self, driven: Driven) -> String {
        let letters = |quantity| match quantity {
            Quantity::Stress => ["T_{", "}"],
            Quantity::RotatedStress => ["(R^{T}TR)_{", "}"],
            Quantity::SecondPiolaStress => ["S_{", "}"],
            Quantity::GreenStrain => ["E_{", "}"],
            Quantity::PlasticStrain => ["E_{p ", "}"],
            Quantity::ElasticStrain => ["E_{* ", "}"],
            Quantity::StrainDifference => ["(E − E_{p})_{", "}"],
        };
        match self {
            Self::Time => "time".to_owned(),
            Self::Driven => driven.symbol().to_owned(),
            Self::Gradient(i, j) => format!("F_{{{}{}}}", i + 1, j + 1),
            Self::Component(quantity, place) => {
                let [before, after] = letters(quantity);
                format!("{before}{}{after}", COMPONENTS[place].0)
            }
            Self::EquivalentPlasticStrain => "equivalent plastic strain".to_owned(),
            Self::HardeningIndex => "hardening index Φ".to_owned(),
            Self::LoadingIndex => "loading index ĝ".to_owned(),
            Self::Dissipation => "plastic dissipation".to_owned(),
            Self::InternalEnergy => "work of the stress".to_owned(),
            Self::PlasticDeterminant => "det C_{p}".to_owned(),
            Self::Temperature => "temperature".to_owned(),
        }
    }

    /// Its name on an axis that it has for itself.
    pub fn title(self, driven: Driven) -> String {
        let words = match self {
            Self::Component(Quantity::Stress, _) => "Cauchy stress",
            Self::Component(Quantity::RotatedStress, _) => "rotated stress",
            Self::Component(Quantity::SecondPiolaStress, _) => "second Piola-Kirchhoff stress",
            Self::Component(Quantity::GreenStrain, _) => "Green strain",
            Self::Component(Quantity::PlasticStrain, _) => "plastic strain",
            Self::Component(Quantity::ElasticStrain, _) => "elastic strain",
            Self::Component(Quantity::StrainDifference, _) => "strain difference",
            Self::Driven => driven.words(),
            _ => return self.symbol(driven),
        };
        format!("{words} {}", self.symbol(driven))
    }
}

/// What the curve of a path measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Driven {
    /// The stretch along x.
    Stretch(StretchMeasure),
    /// The shear γ.
    Shear,
    /// Time itself: the path gives all of F.
    Time,
}

impl Driven {
    fn symbol(self) -> &'static str {
        match self {
            Self::Stretch(StretchMeasure::GreenLagrange) => "E_{11}",
            Self::Stretch(StretchMeasure::Stretch) => "λ",
            Self::Stretch(StretchMeasure::Logarithmic) => "ln λ",
            Self::Shear => "γ",
            Self::Time => "t",
        }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Stretch(StretchMeasure::GreenLagrange) => "Green strain",
            Self::Stretch(StretchMeasure::Stretch) => "stretch",
            Self::Stretch(StretchMeasure::Logarithmic) => "logarithmic strain",
            Self::Shear => "shear",
            Self::Time => "time",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_have_different_names_in_the_promised_order() {
        let names: Vec<String> = Column::all().iter().map(|column| column.name()).collect();
        assert_eq!(names[..5], ["time", "driven", "F11", "F12", "F13"]);
        assert_eq!(names[11..17], ["T11", "T22", "T33", "T12", "T13", "T23"]);
        assert_eq!(names.len(), 2 + 9 + 42 + 7);
        let mut unique = names.clone();
        unique.sort_unstable();
        unique.dedup();
        assert_eq!(unique.len(), names.len());
    }
}
