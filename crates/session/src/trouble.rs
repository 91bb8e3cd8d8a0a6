//! What to tell a user about a model or a run that failed, in the numbers of the user's own mesh.

use crate::inversion;
use crate::judgement;
use crate::problem::Problem;
use estar_solver::{ModelError, Simulation, SimulationError};

/// How many of the last rows' smallest Jacobians are told.
pub const JACOBIANS_SHOWN: usize = 6;

/// A model that the solver refuses.
pub fn of_model(error: &ModelError, problem: &Problem) -> String {
    let element_label = |element: u32| problem.mesh.element_labels()[element as usize].0;
    let node_label = |node: u32| problem.mesh.node_labels()[node as usize].0;
    let message = match error {
        ModelError::ElementInTwoParts { element, .. } => {
            format!("element {} belongs to two parts", element_label(*element))
        }
        ModelError::ElementWithoutPart { count, first } => {
            format!("{count} elements belong to no part, the first is {}", element_label(*first))
        }
        ModelError::BadElement { element, what, value } => {
            format!(
                "element {} is inverted or too distorted: its smallest {what} is {value:?}",
                element_label(*element)
            )
        }
        ModelError::NotFinite { element } => format!(
            "element {} has forces or a time step that no number holds: check [mesh] scale, density and stiffness",
            element_label(*element)
        ),
        ModelError::NodeWithoutMass { count, first } => {
            format!("{count} nodes belong to no element, the first is {}", node_label(*first))
        }
        ModelError::ConflictingConstraints { node, direction, .. } => {
            format!("node {} is held or driven in {direction:?} in two ways", node_label(*node))
        }
        ModelError::NodeBehindWall { count, node, depth, .. } => {
            format!("{count} nodes begin behind a rigid wall, the deepest, node {}, by {depth:?} m", node_label(*node))
        }
        ModelError::NoGlobalTimeStep { part } => format!(
            "`time.time_step = \"power\"` is not known for the elements `{}` of part {}\nhelp: leave it out, or write \"element\"",
            estar_deck::model::element_name(problem.model.parts[*part].element),
            problem.parts[*part].group
        ),
        ModelError::AddedMass { part, share, limit, count, attainable } => format!(
            "`time.mass_scaling` would add {:.3} % to the mass of part {}, in {count} of its elements, over its `limit` of {:.3} %\n\
             help: target_time_step = {attainable:.3e} stays within the limit; or a larger `limit`, or a mesh without such small \
             elements (`estar check` names them)",
            100.0 * share,
            problem.parts[*part].group,
            100.0 * limit,
            // four digits of this are below it
            attainable = attainable * (1.0 - 5e-4),
        ),
        other => other.to_string(),
    };
    format!("{}: {message}", problem.deck_path.display())
}

/// A run whose time would stand still before the end.
pub fn of_standstill(problem: &Problem, simulation: &Simulation) -> String {
    format!(
        "{}: the time step of {:.4e} s, which element {} controls, is too small for the time ever to reach \
         {:.4e} s\nhelp: check the units of density, stiffness and length ([mesh] scale), and [time] end, safety_factor \
         and bulk_viscosity",
        problem.deck_path.display(),
        simulation.time_step(),
        label(simulation.extremes().controlling_element, problem),
        simulation.end_time()
    )
}

/// What is told of a run that could not go on.
pub struct Told {
    /// What went wrong, and where.
    pub what: String,
    /// What usually helps.
    pub help: String,
}

/// A run that could not go on.
pub fn of_simulation(
    error: &SimulationError,
    problem: &Problem,
    simulation: &Simulation,
    jacobians: &[(u64, f64)],
) -> Told {
    let (what, element, help) = explained(error, problem, simulation);
    let first = match error {
        SimulationError::ElementInverted { element, .. }
        | SimulationError::Standstill { element, .. }
        | SimulationError::TimeStepTooSmall { element, .. } => other_element(*element, problem),
        SimulationError::EnergyError { error, .. } if !error.is_nan() => judgement::energy_advice(problem) + "; ",
        _ => String::new(),
    };
    let mut text = format!("error: {what} at step {}, t = {:.6e} s", simulation.step(), simulation.time());
    if let Some(element) = element {
        text.push_str(&format!("\n  {}", whereabouts(element, problem, simulation)));
    }
    let numbers = jacobians.iter().filter(|(_, value)| value.is_finite());
    let history: Vec<String> = numbers.map(|(step, value)| format!("{} at step {step}", short(*value))).collect();
    text.push_str(&format!(
        "\n  smallest Jacobian of all elements in the last rows of the history: {}",
        history.join(", ")
    ));
    Told { what: text, help: format!("help: what usually helps: {first}{help}") }
}

/// What went wrong, in which element, and what usually helps.
fn explained(
    error: &SimulationError,
    problem: &Problem,
    simulation: &Simulation,
) -> (String, Option<u32>, &'static str) {
    match error {
        SimulationError::ElementInverted { element, jacobian, .. } => (
            format!("element {} inverted (smallest Jacobian {jacobian:.4e})", label(*element, problem)),
            Some(*element),
            "a finer or better shaped mesh there, bulk_viscosity for shocks, a slower load, [time] on_inversion = \"delete\"; or a unit \
             that is wrong",
        ),
        SimulationError::NotFinite { element, .. } => (
            format!("a value in element {} is not finite", label(*element, problem)),
            Some(*element),
            "a smaller [time] safety_factor; check units, densities and the sizes of loads",
        ),
        SimulationError::Standstill { element, time_step, .. } => (
            format!(
                "the time step of {time_step:.4e} s, which element {} controls, no longer moves the time",
                label(*element, problem)
            ),
            Some(*element),
            "a better shaped mesh there: an element is squeezed flat",
        ),
        SimulationError::TimeStepTooSmall { element, time_step, limit, .. } => (
            format!(
                "the time step of {time_step:.4e} s, which element {} controls, is below [time] min_time_step = {limit:.4e} s",
                label(*element, problem)
            ),
            Some(*element),
            "a better shaped mesh there, or a smaller min_time_step if the wait is worth it",
        ),
        SimulationError::StepLimit { .. } => (
            format!("the end of {:.6e} s is not reached in [time] max_steps", simulation.end_time()),
            None,
            "a larger max_steps; `estar check` says how many steps to expect",
        ),
        SimulationError::HeldBehindWall { wall, node, depth, .. } => (
            format!(
                "node {}, which is held or driven, gets behind {} by {depth:.4e} m",
                problem.mesh.node_labels().get(*node as usize).map_or(0, |label| label.0),
                problem.wall_names[*wall]
            ),
            None,
            "let the wall stop before what is held, or leave the direction of its normal free there",
        ),
        SimulationError::ToolTooFast { wall, time_step, .. } => (
            format!(
                "{} moves farther than its radius within the time step of {time_step:.4e} s, so that it could pass over nodes",
                problem.wall_names[*wall]
            ),
            None,
            "a slower tool or a larger radius, a smaller [time] safety_factor",
        ),
        SimulationError::AddedKineticEnergy { share, limit, .. } => (
            format!(
                "the kinetic energy of added mass is {:.2} % of the largest energy in play, over the limit of {:.2} %",
                100.0 * share,
                100.0 * limit
            ),
            None,
            "less mass scaling, or a slower process; [time] mass_scaling.kinetic_limit sets the limit",
        ),
        SimulationError::EnergyError { error, .. } if error.is_nan() => (
            "the energy error is not a number".to_owned(),
            None,
            "units, densities and the sizes of loads that a number can hold",
        ),
        SimulationError::EnergyError { error, limit, .. } => (
            format!("the energy error {:+.2} % is over the limit of {:.2} %", 100.0 * error, 100.0 * limit),
            None,
            "[time] energy_error_limit sets the limit",
        ),
    }
}

/// The element that held where those of the part turn inside out, if there is one.
fn other_element(element: u32, problem: &Problem) -> String {
    let part = problem.model.parts.iter().find(|part| part.elements.contains(&element));
    part.and_then(|part| inversion::other_element(part.element)).map_or(String::new(), |other| other + ", ")
}

/// A Jacobian: near 1 as people write it, far from it with an exponent.
fn short(jacobian: f64) -> String {
    if jacobian.abs() < 1e3 { format!("{jacobian:.3}") } else { format!("{jacobian:.3e}") }
}

fn label(element: u32, problem: &Problem) -> u64 {
    problem.mesh.element_labels().get(element as usize).map_or(0, |label| label.0)
}

/// Part, nodes and first position of an element.
fn whereabouts(element: u32, problem: &Problem, simulation: &Simulation) -> String {
    let elements = problem.mesh.elements();
    if element as usize >= elements.len() {
        return String::new();
    }
    let of_element = elements.nodes(element as usize);
    let count = of_element.len() as f64;
    let nodes: Vec<String> =
        of_element.iter().map(|node| problem.mesh.node_labels()[*node as usize].0.to_string()).collect();
    let centre: [f64; 3] = std::array::from_fn(|axis| {
        of_element.iter().map(|node| simulation.reference()[*node as usize][axis] / count).sum()
    });
    let mut parts = problem.parts.iter().zip(&problem.model.parts);
    let part =
        parts.find(|(_, part)| part.elements.contains(&element)).map_or("", |(description, _)| &description.group);
    format!(
        "it is in part {part}, has the nodes {}, and was at x = {:.4e}, y = {:.4e}, z = {:.4e} m",
        nodes.join(" "),
        centre[0],
        centre[1],
        centre[2]
    )
}
