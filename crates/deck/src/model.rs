//! `[mesh]`, `[[part]]`, and what acts on the body.

use crate::decoder::{At, Decoder, FromDeck};
use crate::diagnostics::{Diagnostic, Diagnostics};
use crate::macros::{deck_choice, deck_table, deck_variants};
use crate::names::{GroupName, MaterialName, MeshFile, NewWallName, OfElements, OfFaces, OfNodes};
use crate::schema::{Choice, Schema};
use crate::tree::{Node, Value};
use crate::values::{
    Acceleration, Displacement, Length, NotNegative, Number, Positive, Quantity, Rate, Stress, TimePoints, UnitVector,
    Vector, Velocity,
};
use estar_material::MaterialModel;
use estar_mesh::{Mesh, Shape};
use estar_solver::model::{Direction, Formulation, HourglassControl, WallShape};
use estar_solver::{Curve, Interpolation};

deck_table! {
    /// The mesh: where it is and in which unit.
    pub struct MeshTable {
        /// The file: Gmsh 4.1, 4.0 or 2.2 (`.msh`), Abaqus (`.inp`), or VTK (`.vtu`, `.vtk`).
        file: MeshFile = required,
        /// Length of the file's unit, m: 1e-3 for a file in mm.
        scale: Quantity<Positive<Number>> = default("1.0"),
        /// Nodes within this distance of each other, directly or by way of others, become one: the one of the least number stays
        /// where it is, and groups follow. None are merged unless given.
        merge: At<Quantity<Positive<Length>>> = optional,
    }
}

deck_table! {
    /// Elements of one material and one formulation. Every element of the mesh belongs to exactly one part.
    pub struct PartTable {
        /// The elements.
        group: GroupName<OfElements> = required,
        /// Their material.
        material: MaterialName = required,
        /// Their element. Unless given `hex8-f-bar` for hexes, `hex8-b-bar` where wedges or pyramids are among them or where plastic flow
        /// changes the volume (Drucker-Prager, Mohr-Coulomb, Rankine, Green-Naghdi), `tet4` or `tet10` for tets.
        element: At<ElementKind> = optional,
        /// Hourglass control of `hex8-one-point`; `"physical"` unless given.
        hourglass: At<Hourglass> = optional,
        /// Coefficient of the control `stiffness` or `viscous`; 0.05 or 0.1 unless given.
        hourglass_coefficient: At<Quantity<Positive<Number>>> = optional,
    }
}

/// Elements by their names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ElementKind {
    /// `hex8-f-bar`.
    FBar,
    /// `hex8-b-bar`.
    BBar,
    /// `hex8`.
    Full,
    /// `hex8-one-point`.
    OnePoint,
    /// `tet4`.
    Tet4,
    /// `tet10`.
    Tet10,
}

/// Hourglass controls by their names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hourglass {
    /// `physical`.
    Physical,
    /// `stiffness`.
    Stiffness,
    /// `viscous`.
    Viscous,
}

/// Coefficients where the deck gives none: values in common use.
const STIFFNESS_COEFFICIENT: f64 = 0.05;
const VISCOUS_COEFFICIENT: f64 = 0.1;

impl PartTable {
    /// The formulation of the part's elements; shapes that it is not made for and keys that do not suit it are reported.
    pub fn formulation(
        &self,
        mesh: &Mesh,
        elements: &[u32],
        material: &MaterialModel,
        diagnostics: &mut Diagnostics,
    ) -> Formulation {
        let has = |shape: Shape| elements.iter().any(|&element| mesh.elements().shape(element as usize) == shape);
        let shapes: Vec<Shape> = Shape::ALL.into_iter().filter(|shape| has(*shape)).collect();
        let usual = match shapes[..] {
            // the forces of F-bar do not do the work of flow that changes the volume
            [Shape::Hex8] if material.keeps_volume() => ElementKind::FBar,
            [Shape::Tet4] => ElementKind::Tet4,
            [Shape::Tet10] => ElementKind::Tet10,
            _ => ElementKind::BBar,
        };
        let formulation = self.of_kind(self.element.as_ref().map_or(usual, |element| element.value), diagnostics);
        let others: Vec<Shape> = shapes.iter().copied().filter(|shape| formulation.places(*shape).is_none()).collect();
        if others.is_empty() {
            return formulation;
        }
        let plurals = |shapes: &[Shape]| shapes.iter().map(|shape| shape.plural()).collect::<Vec<_>>().join(" and ");
        let name = element_name(formulation);
        let group = &self.group.name;
        let message =
            format!("the group `{}` has {}, which elements `{name}` are not made for", group.value, plurals(&others));
        let fits = [Formulation::FBar, Formulation::BBar, Formulation::Tet4, Formulation::Tet10]
            .into_iter()
            .find(|element| shapes.iter().all(|shape| element.places(*shape).is_some()));
        let help = match fits {
            Some(element) => format!("take element = \"{}\"", element_name(element)),
            None => format!("give {} groups and parts of their own: a part has one kind of element", plurals(&shapes)),
        };
        let span = self.element.as_ref().map_or(group.span, |element| element.span);
        diagnostics.push(Diagnostic::error(message).at(span, "this part").help(help));
        formulation
    }

    fn of_kind(&self, kind: ElementKind, diagnostics: &mut Diagnostics) -> Formulation {
        let coefficient = self.hourglass_coefficient.as_ref();
        let of_kind = match kind {
            ElementKind::FBar => Formulation::FBar,
            ElementKind::BBar => Formulation::BBar,
            ElementKind::Full => Formulation::Full,
            ElementKind::Tet4 => Formulation::Tet4,
            ElementKind::Tet10 => Formulation::Tet10,
            ElementKind::OnePoint => {
                let control = self.hourglass.as_ref().map_or(Hourglass::Physical, |control| control.value);
                let or = |default| coefficient.map_or(default, |coefficient| coefficient.value.value);
                if let (Hourglass::Physical, Some(coefficient)) = (control, coefficient) {
                    let diagnostic = Diagnostic::error("the hourglass control `physical` has no coefficient");
                    let help = "`hourglass = \"stiffness\"` and `\"viscous\"` have one";
                    diagnostics.push(diagnostic.at(coefficient.span, "this one").help(help));
                }
                return Formulation::OnePoint(match control {
                    Hourglass::Physical => HourglassControl::Physical,
                    Hourglass::Stiffness => HourglassControl::Stiffness { coefficient: or(STIFFNESS_COEFFICIENT) },
                    Hourglass::Viscous => HourglassControl::Viscous { coefficient: or(VISCOUS_COEFFICIENT) },
                });
            }
        };
        let keys = [self.hourglass.as_ref().map(|key| key.span), coefficient.map(|key| key.span)];
        if let Some(span) = keys.into_iter().flatten().next() {
            let name = element_name(of_kind);
            let diagnostic = Diagnostic::error(format!("elements `{name}` need no hourglass control"));
            let help = "it belongs to element = \"hex8-one-point\"";
            diagnostics.push(diagnostic.at(span, "this key").help(help));
        }
        of_kind
    }
}

deck_choice! { Hourglass {
    "physical" => Hourglass::Physical, "by the stiffness of assumed strains, of bending and torsion; nothing to choose";
    "stiffness" => Hourglass::Stiffness, "by a share of the stiffness of uniform strain, Flanagan & Belytschko 1981";
    "viscous" => Hourglass::Viscous, "by a viscosity, Flanagan & Belytschko 1981";
} }

deck_choice! { ElementKind {
    "hex8-f-bar" => ElementKind::FBar, "eight nodes, full integration, F-bar against volumetric locking";
    "hex8-b-bar" => ElementKind::BBar, "eight nodes, full integration, mean dilatation (B-bar) against volumetric locking; its forces \
        do the work of its stress";
    "hex8-one-point" => ElementKind::OnePoint, "eight nodes, one point, hourglass control: the cheapest";
    "hex8" => ElementKind::Full, "eight nodes, full integration; locks where plastic flow constrains the volume, as in metals and soils";
    "tet4" => ElementKind::Tet4, "tets of four nodes, one point, volume change and pressure averaged over the nodes of a material, \
        and so told; stiff in bending, and its stress is coarser than its forces";
    "tet10" => ElementKind::Tet10, "tets of ten nodes, four points, mean dilatation against volumetric locking";
} }

deck_table! {
    /// Velocity at time 0: a translation, a rotation, or both. Where groups overlap, the later entry holds.
    pub struct InitialVelocityTable {
        /// The nodes that move.
        group: GroupName<OfNodes> = required,
        /// Velocity of translation.
        value: Vector<Velocity> = optional,
        /// Rotation.
        angular: AngularTable = optional,
    }
}

deck_table! {
    /// Rotation about a centre.
    pub struct AngularTable {
        /// Rate of rotation about the axes x, y, z.
        rate: Vector<Rate> = required,
        /// Centre of rotation.
        centre: Vector<Length> = default("[0.0, 0.0, 0.0]"),
    }
}

deck_table! {
    /// Nodes that do not move in some directions.
    pub struct FixTable {
        /// The nodes.
        group: GroupName<OfNodes> = required,
        /// The directions.
        directions: Vec<At<Direction>> = required,
    }
}

deck_choice! { Direction {
    "x" => Direction::X, "along x";
    "y" => Direction::Y, "along y";
    "z" => Direction::Z, "along z";
} }

deck_table! {
    /// Nodes whose motion in one direction is given.
    pub struct PrescribedTable {
        /// The nodes.
        group: GroupName<OfNodes> = required,
        /// The direction.
        direction: At<Direction> = required,
        /// What the curve gives, with the curve.
        motion: Motion = flatten,
        /// How the curve runs between its points: `"linear"` unless given, in a process of `time.quasi_static` `"monotone"`.
        interpolation: Interpolation = optional,
    }
}

deck_variants! {
    /// What the curve gives.
    pub enum Motion by quantity {
        /// Displacement from the first position.
        Displacement = "displacement" {
            /// Points [time, displacement], times increasing, from 0 on (up to 1e-4 of the largest is taken as 0); constant before
            /// the first and after the last.
            curve: TimePoints<Displacement> = required,
        }
        /// Velocity.
        Velocity = "velocity" {
            /// Points [time, velocity], times increasing; constant before the first and after the last.
            curve: TimePoints<Velocity> = required,
        }
        /// Acceleration; the motion starts at rest.
        Acceleration = "acceleration" {
            /// Points [time, acceleration], times increasing; constant before the first and after the last.
            curve: TimePoints<Acceleration> = required,
        }
    }
}

deck_choice! { Interpolation {
    "linear" => Interpolation::Linear, "straight lines";
    "smooth" => Interpolation::Smooth, "a quintic from point to point, at rest at each of them";
    "monotone" => Interpolation::Monotone, "through the points without a stop, at rest at the first and the last; two points as smooth";
} }

deck_table! {
    /// Pressure on faces. It acts on the current area along the current normal.
    pub struct PressureTable {
        /// The faces.
        group: GroupName<OfFaces> = required,
        /// Points [time, pressure], positive into the body; constant before the first and after the last.
        curve: TimePoints<Stress> = required,
        /// How the curve runs between its points: `"linear"` unless given, in a process of `time.quasi_static` `"monotone"`.
        interpolation: Interpolation = optional,
    }
}

deck_table! {
    /// Force per reference area of faces, in a fixed direction.
    pub struct TractionTable {
        /// The faces.
        group: GroupName<OfFaces> = required,
        /// Direction of the force; its length does not matter.
        direction: UnitVector = required,
        /// Points [time, traction]; constant before the first and after the last.
        curve: TimePoints<Stress> = required,
        /// How the curve runs between its points: `"linear"` unless given, in a process of `time.quasi_static` `"monotone"`.
        interpolation: Interpolation = optional,
    }
}

deck_table! {
    /// Acceleration of free fall, on every node.
    pub struct GravityTable {
        /// The acceleration.
        acceleration: Vector<Acceleration> = required,
    }
}

deck_table! {
    /// A rigid tool that no node passes.
    pub struct RigidWallTable {
        /// Its name, for probes of its force and for the energy ledger.
        name: NewWallName = optional,
        /// Its surface.
        surface: WallSurface = flatten,
        /// Coulomb's coefficient of friction; or "sticking": what is pressed on the wall does not slide on it.
        friction: WallFriction = default("0.0"),
        /// How it moves; at rest unless given.
        motion: WallMotionTable = optional,
    }
}

deck_variants! {
    /// The shape of the tool, which the body is outside of.
    pub enum WallSurface by shape or "plane" {
        /// A half space.
        Plane = "plane" {
            /// A point of the plane.
            point: Vector<Length> = required,
            /// Normal of the plane, into the body's side; its length does not matter.
            normal: UnitVector = required,
        }
        /// A cylinder without ends.
        Cylinder = "cylinder" {
            /// A point of its axis.
            point: Vector<Length> = required,
            /// Direction of its axis; its length does not matter.
            axis: UnitVector = required,
            /// Its radius.
            radius: Quantity<Positive<Length>> = required,
        }
        /// A sphere.
        Sphere = "sphere" {
            /// Its centre.
            centre: Vector<Length> = required,
            /// Its radius.
            radius: Quantity<Positive<Length>> = required,
        }
    }
}

impl WallSurface {
    /// The surface as the solver knows it.
    pub fn shape(&self) -> WallShape {
        match self {
            Self::Plane { point, normal } => WallShape::Plane { point: point.value, normal: normal.0 },
            Self::Cylinder { point, axis, radius } => {
                WallShape::Cylinder { point: point.value, axis: axis.0, radius: radius.value }
            }
            Self::Sphere { centre, radius } => WallShape::Sphere { centre: centre.value, radius: radius.value },
        }
    }
}

deck_table! {
    /// A translation along a line.
    pub struct WallMotionTable {
        /// The direction; its length does not matter.
        direction: UnitVector = required,
        /// What the curve gives, with the curve.
        motion: Motion = flatten,
        /// How the curve runs between its points: `"linear"` unless given, in a process of `time.quasi_static` `"monotone"`.
        interpolation: Interpolation = optional,
    }
}

/// Coulomb's coefficient, infinite where the deck says "sticking".
#[derive(Clone, Copy, Debug)]
pub struct WallFriction(pub f64);

impl FromDeck for WallFriction {
    fn schema() -> Schema {
        let sticking = Choice { name: "sticking", doc: "without any sliding" };
        Schema::Either(vec![Quantity::<NotNegative<Number>>::schema(), Schema::Choice(vec![sticking])])
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        match &node.value {
            Value::Text(text) if text == "sticking" => Some(Self(f64::INFINITY)),
            _ => Quantity::<NotNegative<Number>>::decode(node, decoder).map(|coefficient| Self(coefficient.value)),
        }
    }
}

impl Motion {
    /// The curve with an interpolation, checked when it was read.
    pub fn curve(&self, interpolation: Interpolation) -> Option<Curve> {
        match self {
            Self::Displacement { curve } => curve.curve(interpolation),
            Self::Velocity { curve } => curve.curve(interpolation),
            Self::Acceleration { curve } => curve.curve(interpolation),
        }
        .ok()
    }

    /// What the curve gives.
    pub fn quantity(&self) -> estar_solver::model::Quantity {
        match self {
            Self::Displacement { .. } => estar_solver::model::Quantity::Displacement,
            Self::Velocity { .. } => estar_solver::model::Quantity::Velocity,
            Self::Acceleration { .. } => estar_solver::model::Quantity::Acceleration,
        }
    }
}

/// The deck's name of an element.
pub fn element_name(element: Formulation) -> &'static str {
    match element {
        Formulation::Full => "hex8",
        Formulation::FBar => "hex8-f-bar",
        Formulation::BBar => "hex8-b-bar",
        Formulation::Tet4 => "tet4",
        Formulation::Tet10 => "tet10",
        Formulation::OnePoint(HourglassControl::Physical) => "hex8-one-point",
        Formulation::OnePoint(HourglassControl::Stiffness { .. }) => "hex8-one-point, stiffness",
        Formulation::OnePoint(HourglassControl::Viscous { .. }) => "hex8-one-point, viscous",
    }
}
