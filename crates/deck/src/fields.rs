//! Fields on the mesh, by the names that a user reads and writes.

use crate::units::Dimension;

/// A field of the frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    /// Displacement of nodes, m.
    Displacement,
    /// Velocity of nodes, m/s.
    Velocity,
    /// Cauchy stress of elements, Pa.
    CauchyStress,
    /// Equivalent plastic strain of elements.
    EquivalentPlasticStrain,
    /// Temperature of elements, K.
    Temperature,
    /// Von Mises stress of elements, Pa.
    VonMisesStress,
    /// Pressure of elements, Pa.
    Pressure,
    /// Volume ratio of elements.
    VolumeRatio,
}

/// A field that a probe can follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProbeField {
    /// Position of nodes, m.
    Position,
    /// Displacement of nodes, m.
    Displacement,
    /// Velocity of nodes, m/s.
    Velocity,
    /// Cauchy stress of elements, Pa.
    CauchyStress,
    /// Equivalent plastic strain of elements.
    EquivalentPlasticStrain,
    /// Temperature of elements, K.
    Temperature,
    /// Von Mises stress of elements, Pa.
    VonMisesStress,
    /// Pressure of elements, Pa.
    Pressure,
    /// Volume ratio of elements.
    VolumeRatio,
}

impl ProbeField {
    /// Whether the field lives on nodes, or else on elements.
    pub fn is_nodal(self) -> bool {
        matches!(self, Self::Position | Self::Displacement | Self::Velocity)
    }

    /// Its dimension.
    pub fn dimension(self) -> Dimension {
        match self {
            Self::Position | Self::Displacement => Dimension::LENGTH,
            Self::Velocity => Dimension::VELOCITY,
            Self::CauchyStress | Self::VonMisesStress | Self::Pressure => Dimension::STRESS,
            Self::EquivalentPlasticStrain | Self::VolumeRatio => Dimension::NUMBER,
            Self::Temperature => Dimension::TEMPERATURE,
        }
    }

    /// The components that must be chosen from; none for a scalar.
    pub fn components(self) -> &'static [Component] {
        match self {
            Self::Position | Self::Displacement | Self::Velocity => &Component::OF_VECTOR,
            Self::CauchyStress => &Component::OF_TENSOR,
            _ => &[],
        }
    }
}

/// SI unit of a field of the frames by its name; none of a pure number or of a name that is no field's.
pub fn unit_of(name: &str) -> Option<String> {
    let dimension = match name {
        "displacement" => ProbeField::Displacement.dimension(),
        "velocity" => ProbeField::Velocity.dimension(),
        "cauchy_stress" | "von_mises_stress" | "pressure" => ProbeField::CauchyStress.dimension(),
        "temperature" => ProbeField::Temperature.dimension(),
        _ => return None,
    };
    Some(dimension.si_unit().to_owned())
}

/// Whether a field of cells numbers or marks them: what lies between two such values has no meaning.
pub fn is_label(name: &str) -> bool {
    ["part", "element_id", "vtkGhostType"].contains(&name)
}

/// A component of a vector or a tensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Component {
    /// x.
    X,
    /// y.
    Y,
    /// z.
    Z,
    /// Length of a vector.
    Magnitude,
    /// xx.
    Xx,
    /// yy.
    Yy,
    /// zz.
    Zz,
    /// xy.
    Xy,
    /// yz.
    Yz,
    /// xz.
    Xz,
}

impl Component {
    const OF_VECTOR: [Self; 4] = [Self::X, Self::Y, Self::Z, Self::Magnitude];
    const OF_TENSOR: [Self; 6] = [Self::Xx, Self::Yy, Self::Zz, Self::Xy, Self::Yz, Self::Xz];

    /// The deck's name.
    pub fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
            Self::Magnitude => "magnitude",
            Self::Xx => "xx",
            Self::Yy => "yy",
            Self::Zz => "zz",
            Self::Xy => "xy",
            Self::Yz => "yz",
            Self::Xz => "xz",
        }
    }

    /// The component of a vector.
    pub fn of_vector(self, vector: &[f64; 3]) -> f64 {
        match self {
            Self::X => vector[0],
            Self::Y => vector[1],
            Self::Z => vector[2],
            _ => vector.iter().map(|c| c * c).sum::<f64>().sqrt(),
        }
    }

    /// The component of a tensor in the order XX YY ZZ XY YZ XZ.
    pub fn of_tensor(self, tensor: &[f64; 6]) -> f64 {
        tensor[Self::OF_TENSOR.iter().position(|component| *component == self).unwrap_or(0)]
    }
}
