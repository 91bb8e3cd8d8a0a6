//! `[[probe]]` and `[[expect]]`.

use crate::decoder::{At, Decoder, FromDeck};
use crate::fields::{Component, ProbeField};
use crate::macros::{deck_choice, deck_table, deck_variants};
use crate::names::{GroupName, NewProbeName, OfNodes, ProbeName, WallName};
use crate::schema::{Choice, Schema};
use crate::tree::{Node, Value};
use crate::units::Dimension;
use crate::values::{AnyQuantity, Count, Length, Quantity, Time, Vector};
use estar_solver::model::Direction;

deck_table! {
    /// A number that is followed through the simulation: a column of history.csv.
    pub struct ProbeTable {
        /// Its name.
        name: NewProbeName = required,
        /// What is followed, with its own keys.
        kind: ProbeKind = flatten,
    }
}

deck_variants! {
    /// What is followed.
    pub enum ProbeKind by kind {
        /// Largest minus smallest coordinate of nodes, m.
        Extent = "extent" {
            /// The nodes.
            group: GroupName<OfNodes> = required,
            /// The coordinate.
            axis: Direction = required,
        }
        /// Largest distance of nodes from a line along an axis, m.
        MaxRadius = "max-radius" {
            /// The nodes.
            group: GroupName<OfNodes> = required,
            /// The direction of the line.
            axis: Direction = required,
            /// A point of the line.
            centre: Vector<Length> = default("[0.0, 0.0, 0.0]"),
        }
        /// Sum of the forces with which `fix` and `prescribed` hold nodes, N.
        Reaction = "reaction" {
            /// The nodes.
            group: GroupName<OfNodes> = required,
            /// The direction of the force.
            direction: Direction = required,
        }
        /// Force of a rigid wall on the body, N.
        ContactForce = "contact-force" {
            /// The wall.
            wall: WallName = required,
            /// The direction of the force.
            direction: Direction = required,
        }
        /// A field at one node; either `label` or `group`.
        Node = "node" {
            /// Its number in the mesh file.
            label: At<Count> = optional,
            /// A group of this one node.
            group: GroupName<OfNodes> = optional,
            /// A field of nodes.
            field: At<ProbeField> = required,
            /// Its component: x, y, z or magnitude.
            component: At<Component> = optional,
        }
        /// A field in one element.
        Element = "element" {
            /// Its number in the mesh file.
            label: At<Count> = required,
            /// A field of elements.
            field: At<ProbeField> = required,
            /// Its component, for `cauchy_stress`: xx, yy, zz, xy, yz or xz.
            component: At<Component> = optional,
        }
        /// Mean of a field: over nodes, or over elements by their volume at time 0.
        GroupAverage = "group-average" {
            /// The nodes or elements.
            group: GroupName<OfNodes> = required,
            /// The field.
            field: At<ProbeField> = required,
            /// Its component.
            component: At<Component> = optional,
        }
        /// Largest value of a field.
        Maximum = "maximum" {
            /// The nodes or elements.
            group: GroupName<OfNodes> = required,
            /// The field.
            field: At<ProbeField> = required,
            /// Its component.
            component: At<Component> = optional,
        }
    }
}

deck_choice! { ProbeField {
    "position" => ProbeField::Position, "of nodes, m";
    "displacement" => ProbeField::Displacement, "of nodes, m";
    "velocity" => ProbeField::Velocity, "of nodes, m/s";
    "cauchy_stress" => ProbeField::CauchyStress, "of elements, Pa";
    "equivalent_plastic_strain" => ProbeField::EquivalentPlasticStrain, "of elements";
    "temperature" => ProbeField::Temperature, "of elements whose material has one, K";
    "von_mises_stress" => ProbeField::VonMisesStress, "of elements, Pa";
    "pressure" => ProbeField::Pressure, "of elements, Pa";
    "volume_ratio" => ProbeField::VolumeRatio, "of elements";
} }

deck_choice! { Component {
    "x" => Component::X, "of a vector";
    "y" => Component::Y, "of a vector";
    "z" => Component::Z, "of a vector";
    "magnitude" => Component::Magnitude, "of a vector";
    "xx" => Component::Xx, "of a tensor";
    "yy" => Component::Yy, "of a tensor";
    "zz" => Component::Zz, "of a tensor";
    "xy" => Component::Xy, "of a tensor";
    "yz" => Component::Yz, "of a tensor";
    "xz" => Component::Xz, "of a tensor";
} }

deck_table! {
    /// A value that a probe must have; a run that misses one ends with exit status 5.
    pub struct ExpectTable {
        /// The probe.
        probe: ProbeName = required,
        /// When: the end, a time (the first step at or after it counts), or the largest of the rows of history.csv.
        at: When = default("'end'"),
        /// The value, in the unit of the probe.
        value: At<AnyQuantity> = required,
        /// Allowed deviation: a percentage of the value in SI units (of kelvins, where it is a temperature), or a quantity in the
        /// unit of the probe.
        tolerance: At<AnyQuantity> = required,
    }
}

/// A moment of the simulation.
#[derive(Clone, Copy, Debug)]
pub enum When {
    /// Its end.
    End,
    /// When the probe is largest, among the rows of the history.
    Max,
    /// A time, s.
    Time(At<f64>),
}

impl FromDeck for When {
    fn schema() -> Schema {
        let end = Choice { name: "end", doc: "the end of the simulation" };
        let max = Choice { name: "max", doc: "the largest value" };
        Schema::Either(vec![Schema::Choice(vec![end, max]), Quantity::<super::values::NotNegative<Time>>::schema()])
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        match &node.value {
            Value::Text(text) if text == "end" => Some(Self::End),
            Value::Text(text) if text == "max" => Some(Self::Max),
            _ => {
                let time = Quantity::<super::values::NotNegative<Time>>::decode(node, decoder)?;
                Some(Self::Time(At { value: time.value, span: node.span }))
            }
        }
    }
}

impl ProbeKind {
    /// Dimension of what the probe gives.
    pub fn dimension(&self) -> Dimension {
        match self {
            Self::Extent { .. } | Self::MaxRadius { .. } => Dimension::LENGTH,
            Self::Reaction { .. } | Self::ContactForce { .. } => Dimension::FORCE,
            Self::Node { field, .. }
            | Self::Element { field, .. }
            | Self::GroupAverage { field, .. }
            | Self::Maximum { field, .. } => field.value.dimension(),
        }
    }
}
