//! What a simulation is made of: parts, constraints, loads and settings, in SI units and in indices of the mesh.

use crate::curve::Curve;
pub use estar_element::bulk_viscosity::BulkViscosity;
use estar_element::element::ElementVisitor;
use estar_element::hex8;
pub use estar_element::hex8_one_point::HourglassControl;
use estar_element::tet4::Tet4;
use estar_element::tet10::Tet10;
use estar_material::MaterialModel;
use estar_mesh::{Face, Shape};

/// A complete problem on a mesh. Node and element indices are positions in the mesh that the simulation is made with.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// Parts: together they must own every element exactly once.
    pub parts: Vec<Part>,
    /// Nodes held at rest.
    pub fixes: Vec<Fix>,
    /// Nodes that follow a curve.
    pub prescribed: Vec<Prescribed>,
    /// Velocities at time 0; a later entry overrides an earlier one on shared nodes.
    pub initial_velocities: Vec<InitialVelocity>,
    /// External loads; each has a row of its own in the energy ledger.
    pub loads: Vec<Load>,
    /// Rigid walls; each acts on every node.
    pub walls: Vec<RigidWall>,
    /// Time integration.
    pub settings: TimeSettings,
}

/// Elements of one material and one formulation.
#[derive(Clone, Debug)]
pub struct Part {
    /// Elements of the mesh that are the part, in any order, all of shapes that the formulation is made for.
    pub elements: Vec<u32>,
    /// Their material.
    pub material: MaterialModel,
    /// Their element.
    pub element: Formulation,
}

/// Element formulation of a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Formulation {
    /// Eight points, the volume change of each.
    Full,
    /// Eight points, the volume change of the centre.
    FBar,
    /// Eight points, the volume change and the pressure of the whole element.
    BBar,
    /// One point and hourglass control.
    OnePoint(HourglassControl),
    /// Tets of four nodes, volume change and pressure averaged over nodes.
    Tet4,
    /// Tets of ten nodes, the volume change and the pressure of the whole element.
    Tet10,
}

impl Formulation {
    /// Hands the element to the visitor.
    pub fn visit<V: ElementVisitor>(self, visitor: V) -> V::Output {
        match self {
            Self::Full => visitor.visit(hex8::Formulation::Full),
            Self::FBar => visitor.visit(hex8::Formulation::FBar),
            Self::BBar => visitor.visit(hex8::Formulation::BBar),
            Self::OnePoint(control) => visitor.visit(control),
            Self::Tet4 => visitor.visit(Tet4),
            Self::Tet10 => visitor.visit(Tet10),
        }
    }

    /// The node at each of its corners, of an element of the given shape; none where it is not made for the shape. Wedges and
    /// pyramids are hexes some of whose corners fall together; there the centre says so little of the whole that F-bar, whose
    /// stiffness is not symmetric, makes vibrations grow (a spinning cube of wedges gains a tenth of its energy in half a turn).
    pub fn places(self, shape: Shape) -> Option<&'static [usize]> {
        match self {
            Self::FBar if shape != Shape::Hex8 => None,
            Self::Full | Self::FBar | Self::BBar | Self::OnePoint(_) => {
                shape.corners_of_hex().map(<[usize; 8]>::as_slice)
            }
            Self::Tet4 if shape == Shape::Tet4 => Some(&[0, 1, 2, 3]),
            Self::Tet10 if shape == Shape::Tet10 => Some(&[0, 1, 2, 3, 4, 5, 6, 7, 8, 9]),
            Self::Tet4 | Self::Tet10 => None,
        }
    }
}

/// A coordinate direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// x.
    X,
    /// y.
    Y,
    /// z.
    Z,
}

impl Direction {
    /// Position of the component in a vector.
    pub fn index(self) -> usize {
        self as usize
    }
}

/// Nodes whose displacement in some directions stays zero.
#[derive(Clone, Debug)]
pub struct Fix {
    /// Nodes held.
    pub nodes: Vec<u32>,
    /// Directions held.
    pub directions: Vec<Direction>,
}

/// Nodes whose motion in one direction is a function of time.
#[derive(Clone, Debug)]
pub struct Prescribed {
    /// Nodes driven.
    pub nodes: Vec<u32>,
    /// Direction driven.
    pub direction: Direction,
    /// What the curve gives.
    pub quantity: Quantity,
    /// The function of time: m, m/s or m/s².
    pub curve: Curve,
}

/// What a prescribed curve gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Displacement, m.
    Displacement,
    /// Velocity, m/s.
    Velocity,
    /// Acceleration, m/s²; the motion starts at rest.
    Acceleration,
}

impl Quantity {
    /// The displacement (m) at a time that the curve of this quantity leads to.
    pub fn displacement(self, curve: &Curve, time: f64) -> f64 {
        match self {
            Self::Displacement => curve.value(time),
            Self::Velocity => curve.integral(time),
            Self::Acceleration => curve.double_integral(time),
        }
    }
}

/// Velocity of nodes at time 0.
#[derive(Clone, Debug)]
pub struct InitialVelocity {
    /// Nodes that move.
    pub nodes: Vec<u32>,
    /// Velocity of translation, m/s.
    pub translation: [f64; 3],
    /// Spin about a centre, added to the translation.
    pub spin: Option<Spin>,
}

/// Rigid rotation rate about a centre: v = ω × (x − c).
#[derive(Clone, Copy, Debug)]
pub struct Spin {
    /// ω, rad/s.
    pub rate: [f64; 3],
    /// c, m.
    pub centre: [f64; 3],
}

/// An external load with the name of its ledger row.
#[derive(Clone, Debug)]
pub struct Load {
    /// Name, for messages and the energy ledger.
    pub name: String,
    /// What acts.
    pub kind: LoadKind,
}

/// The kinds of external load.
#[derive(Clone, Debug)]
pub enum LoadKind {
    /// Acceleration of free fall on every node, m/s².
    Gravity {
        /// g.
        acceleration: [f64; 3],
    },
    /// Pressure on faces, positive into the body, on the current area along the current normal.
    Pressure {
        /// The faces, right-handed about the outward normal.
        faces: Vec<Face>,
        /// Pressure, Pa.
        curve: Curve,
    },
    /// Force per reference area of faces in a fixed direction.
    Traction {
        /// The faces.
        faces: Vec<Face>,
        /// Unit vector of the force.
        direction: [f64; 3],
        /// Traction, Pa.
        curve: Curve,
    },
}

/// A rigid tool that no node passes.
#[derive(Clone, Debug)]
pub struct RigidWall {
    /// Its surface at time 0 of its motion.
    pub shape: WallShape,
    /// Coulomb's friction coefficient; infinite where what touches the wall sticks to it as long as it is pressed on it.
    pub friction: f64,
    /// How it moves; at rest without.
    pub motion: Option<WallMotion>,
}

/// The surface of a rigid tool; the body is outside of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WallShape {
    /// A half space.
    Plane {
        /// A point of the plane, m.
        point: [f64; 3],
        /// Unit normal towards the body.
        normal: [f64; 3],
    },
    /// A cylinder without ends.
    Cylinder {
        /// A point of its axis, m.
        point: [f64; 3],
        /// Unit vector along its axis.
        axis: [f64; 3],
        /// Radius, m.
        radius: f64,
    },
    /// A sphere.
    Sphere {
        /// Centre, m.
        centre: [f64; 3],
        /// Radius, m.
        radius: f64,
    },
}

/// A translation of a rigid tool.
#[derive(Clone, Debug)]
pub struct WallMotion {
    /// Unit vector of the motion.
    pub direction: [f64; 3],
    /// What the curve gives.
    pub quantity: Quantity,
    /// The function of time along the direction: m, m/s or m/s².
    pub curve: Curve,
}

/// Mass added to elements so that the run takes longer steps.
#[derive(Clone, Copy, Debug)]
pub struct MassScaling {
    /// Factor on the mass of every element.
    pub factor: f64,
    /// Time step, s, that the run begins with at least: elements whose own is shorter are made heavier. Zero asks for none.
    pub target_time_step: f64,
    /// Largest added mass of a part by the target, as a share of its own.
    pub limit: f64,
    /// Largest kinetic energy of added mass, as a share of the largest energy in play so far, from a tenth of the time on.
    pub kinetic_limit: f64,
}

/// Settings of the time integration.
#[derive(Clone, Copy, Debug)]
pub struct TimeSettings {
    /// Time at which the simulation ends, s.
    pub end: f64,
    /// Fraction of the stable time step that is used.
    pub safety_factor: f64,
    /// Where the stable time step is taken from.
    pub time_step: TimeStep,
    /// Bulk viscosity, if any.
    pub bulk_viscosity: Option<BulkViscosity>,
    /// Largest allowed |energy error|, as a fraction.
    pub energy_error_limit: f64,
    /// What becomes of an element that turns inside out.
    pub on_inversion: OnInversion,
    /// Steps after which a run that has not reached its end is over.
    pub max_steps: Option<u64>,
    /// Smallest time step that is worth going on with, s, but for the last two, which meet the end. Where elements are deleted,
    /// those that ask for a smaller one are, and a hundredth of the first step is the limit unless given.
    pub min_time_step: Option<f64>,
    /// Mass scaling, if any.
    pub mass_scaling: Option<MassScaling>,
    /// Damping in proportion to mass, α of the force −α m v, 1/s.
    pub mass_damping: f64,
}

/// Where the stable time step is taken from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TimeStep {
    /// A bound of the highest frequency of each element.
    #[default]
    Element,
    /// An estimate of the highest frequency of the assembled mesh, but no less than that.
    Power {
        /// Steps from one estimate to the next.
        interval: u64,
    },
}

/// What becomes of an element that turns inside out, or is squeezed so flat that its time step is too small.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OnInversion {
    /// The run ends.
    #[default]
    Stop,
    /// The element is deleted: it has no force and no time step any more, its mass stays at its nodes, and the stress power
    /// that it has taken is a row of the ledger. Loads on its faces go on.
    Delete,
}

impl Default for TimeSettings {
    fn default() -> Self {
        Self {
            end: 0.0,
            safety_factor: 0.9,
            time_step: TimeStep::Element,
            bulk_viscosity: None,
            energy_error_limit: 0.1,
            on_inversion: OnInversion::Stop,
            max_steps: None,
            min_time_step: None,
            mass_scaling: None,
            mass_damping: 0.0,
        }
    }
}
