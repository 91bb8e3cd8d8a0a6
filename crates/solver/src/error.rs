//! What can be wrong with a model, and what can go wrong in a run. Numbers are indices of the mesh; who knows the
//! user's labels says them.

use crate::model::Direction;
use estar_mesh::Shape;

/// A model that cannot be simulated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModelError {
    /// An index beyond the mesh.
    #[error("{what} refers to node or element {index}, but the mesh has only {count}")]
    OutOfRange {
        /// Which entry of the model.
        what: &'static str,
        /// The index.
        index: u32,
        /// How many there are.
        count: usize,
    },
    /// A part without elements.
    #[error("part {part} has no elements")]
    EmptyPart {
        /// Position of the part in the model.
        part: usize,
    },
    /// An element of a shape that the part's formulation is not made for.
    #[error("element {element} is a {shape}, which elements of part {part} are not made for")]
    WrongShape {
        /// Position of the part in the model.
        part: usize,
        /// The element.
        element: u32,
        /// Its shape.
        shape: Shape,
    },
    /// An element that belongs to two parts.
    #[error("element {element} belongs to part {first} and to part {second}")]
    ElementInTwoParts {
        /// The element.
        element: u32,
        /// Position of the first part in the model.
        first: usize,
        /// Position of the second.
        second: usize,
    },
    /// Elements that belong to no part.
    #[error("{count} elements belong to no part, the first is {first}")]
    ElementWithoutPart {
        /// How many.
        count: usize,
        /// The first of them.
        first: u32,
    },
    /// An element that is inside out, or so distorted that a corner has no mass.
    #[error("element {element} is inverted or too distorted: its smallest {what} is {value:?}")]
    BadElement {
        /// The element.
        element: u32,
        /// What is not positive.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// An element whose force, energy or stable time step is not a number or infinite before anything has moved.
    #[error("a value in element {element} is not finite at the start")]
    NotFinite {
        /// The element.
        element: u32,
    },
    /// Nodes that no element uses.
    #[error("{count} nodes belong to no element, the first is {first}")]
    NodeWithoutMass {
        /// How many.
        count: usize,
        /// The first of them.
        first: u32,
    },
    /// Two entries that prescribe different motions of one degree of freedom.
    #[error("node {node} is driven in {direction:?} by {first:?} and by {second:?}")]
    ConflictingConstraints {
        /// The node.
        node: u32,
        /// The direction.
        direction: Direction,
        /// The first entry.
        first: ConstraintSource,
        /// The second entry.
        second: ConstraintSource,
    },
    /// A node that begins behind a rigid wall.
    #[error("{count} nodes begin behind rigid wall {wall}, the deepest, node {node}, by {depth:?} m")]
    NodeBehindWall {
        /// Position of the wall in the model.
        wall: usize,
        /// How many nodes.
        count: usize,
        /// The deepest node.
        node: u32,
        /// How deep it is, m.
        depth: f64,
    },
    /// A part whose elements the time step of the assembled mesh does not know.
    #[error("the time step of the assembled mesh is not known for the elements of part {part}")]
    NoGlobalTimeStep {
        /// Position of the part in the model.
        part: usize,
    },
    /// More mass than allowed that the target step of mass scaling would add to a part.
    #[error(
        "mass scaling would add {share:.4} of its mass to part {part}, in {count} elements, over the limit {limit:?}; within it          the time step is {attainable:e} s"
    )]
    AddedMass {
        /// Position of the part in the model.
        part: usize,
        /// Added mass over the part's own.
        share: f64,
        /// The limit.
        limit: f64,
        /// Elements that would be made heavier.
        count: usize,
        /// The largest target within the limit, s.
        attainable: f64,
    },
    /// A direction that is not a unit vector.
    #[error("the {what} must be a unit vector")]
    NotUnit {
        /// Which direction.
        what: &'static str,
    },
    /// A setting out of its bounds.
    #[error("{setting} = {value:?} is not allowed: {bound}")]
    Setting {
        /// The deck's name of the setting.
        setting: &'static str,
        /// Its value.
        value: f64,
        /// What would be allowed.
        bound: &'static str,
    },
}

/// An entry of the model that constrains motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConstraintSource {
    /// Position in [`Model::fixes`](crate::Model::fixes).
    Fix(usize),
    /// Position in [`Model::prescribed`](crate::Model::prescribed).
    Prescribed(usize),
}

/// A run that cannot go on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SimulationError {
    /// An element turned inside out.
    #[error("element {element} inverted (det F = {jacobian:?}) at step {step}, t = {time:?} s")]
    ElementInverted {
        /// The element.
        element: u32,
        /// Smallest det F of its points.
        jacobian: f64,
        /// Step.
        step: u64,
        /// Time, s.
        time: f64,
    },
    /// A force, an energy or a time step that is infinite or not a number.
    #[error("a value in element {element} is not finite at step {step}, t = {time:?} s")]
    NotFinite {
        /// The element.
        element: u32,
        /// Step.
        step: u64,
        /// Time, s.
        time: f64,
    },
    /// A time step so small that it no longer moves the time.
    #[error(
        "the time step {time_step:?} s, which element {element} controls, no longer moves the time {time:?} s at step {step}"
    )]
    Standstill {
        /// The element that controls the step.
        element: u32,
        /// The step that comes, s.
        time_step: f64,
        /// Step.
        step: u64,
        /// Time, s.
        time: f64,
    },
    /// A stable time step below the smallest allowed.
    #[error(
        "the time step {time_step:?} s, which element {element} controls, is below the limit {limit:?} s at step {step}, \
         t = {time:?} s"
    )]
    TimeStepTooSmall {
        /// The element that controls the step.
        element: u32,
        /// The step that would come, s.
        time_step: f64,
        /// The limit, s.
        limit: f64,
        /// Step.
        step: u64,
        /// Time, s.
        time: f64,
    },
    /// As many steps as allowed, and the end not reached.
    #[error("the end is not reached in {step} steps, but t = {time:?} s")]
    StepLimit {
        /// Step.
        step: u64,
        /// Time, s.
        time: f64,
    },
    /// An energy balance that is off by more than allowed.
    #[error("the energy error {error:?} is over the limit {limit:?} at step {step}, t = {time:?} s")]
    EnergyError {
        /// Energy error as a fraction.
        error: f64,
        /// The limit.
        limit: f64,
        /// Step.
        step: u64,
        /// Time, s.
        time: f64,
    },
    /// A node that constraints take behind a rigid wall.
    #[error(
        "node {node}, which is held or driven, gets behind rigid wall {wall} by {depth:?} m at step {step}, t = {time:?} s"
    )]
    HeldBehindWall {
        /// Position of the wall in the model.
        wall: usize,
        /// The deepest such node.
        node: u32,
        /// How deep it would be after the step that comes, m.
        depth: f64,
        /// Step.
        step: u64,
        /// Time, s.
        time: f64,
    },
    /// A curved tool that moves farther in a step than its radius, so that it could pass over nodes.
    #[error(
        "rigid wall {wall} moves farther than its radius within the time step {time_step:?} s at step {step}, t = {time:?} s"
    )]
    ToolTooFast {
        /// Position of the wall in the model.
        wall: usize,
        /// The step that comes, s.
        time_step: f64,
        /// Step.
        step: u64,
        /// Time, s.
        time: f64,
    },
    /// Added mass that has more of the energy than allowed.
    #[error(
        "added mass has the share {share:?} of the energy as kinetic energy, over the limit {limit:?}, at step {step},          t = {time:?} s"
    )]
    AddedKineticEnergy {
        /// Its kinetic energy as a share of the largest energy in play.
        share: f64,
        /// The limit.
        limit: f64,
        /// Step.
        step: u64,
        /// Time, s.
        time: f64,
    },
}
