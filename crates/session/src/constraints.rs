//! Constraints that contradict each other, and displacements that jump.

use estar_deck::Deck;
use estar_deck::diagnostics::{Diagnostic, Diagnostics, Span};
use estar_deck::model::PrescribedTable;
use estar_deck::names::{GroupName, OfNodes};
use estar_mesh::Mesh;
use estar_solver::Curve;
use estar_solver::model::{Direction, Part, Quantity};

/// Reports nodes that are held and moved, or moved in two ways, in one direction.
pub fn check(deck: &Deck, mesh: &Mesh, diagnostics: &mut Diagnostics) {
    let motion = |prescribed: &PrescribedTable| {
        let interpolation = deck.interpolation(prescribed.interpolation);
        (prescribed.motion.quantity(), prescribed.motion.curve(interpolation))
    };
    for fix in deck.fix.iter().filter(|fix| fix.directions.is_empty()) {
        let diagnostic = Diagnostic::error("`fix.directions` is empty: nothing is held").at(fix.span, "this fix");
        diagnostics.push(diagnostic.help("such as directions = [\"x\", \"y\"]"));
    }
    for (index, prescribed) in deck.prescribed.iter().enumerate() {
        let group = &prescribed.group;
        for fix in &deck.fix {
            let held = fix.directions.iter().find(|direction| direction.value == prescribed.direction.value);
            if let (Some(held), Some(common)) = (held, common_nodes(mesh, group, &fix.group)) {
                let message = format!("{common} both fixed and prescribed in {}", name(prescribed.direction.value));
                report(message, prescribed, held.span, "fixed here", diagnostics);
            }
        }
        for other in &deck.prescribed[..index] {
            let differs = other.direction.value == prescribed.direction.value && motion(other) != motion(prescribed);
            if let Some(common) = common_nodes(mesh, group, &other.group).filter(|_| differs) {
                let message = format!("{common} prescribed in {} in two ways", name(prescribed.direction.value));
                report(message, prescribed, other.direction.span, "first prescribed here", diagnostics);
            }
        }
        if let (Quantity::Displacement, Some(curve)) = motion(prescribed)
            && curve.value(0.0) != 0.0
        {
            let message = format!("the prescribed displacement jumps to {:?} m at time 0", curve.value(0.0));
            let diagnostic = Diagnostic::error(message).at(prescribed.span, "this motion");
            diagnostics.push(diagnostic.help("let the curve begin with [0.0, 0.0]"));
        }
    }
}

/// A displacement that the deck prescribes.
#[derive(Clone, Debug)]
pub struct Driven {
    /// Where the deck does.
    span: Span,
    curve: Curve,
}

/// The displacements that a deck prescribes, of nodes and of tools.
pub fn driven(deck: &Deck) -> Vec<Driven> {
    let of_nodes = deck.prescribed.iter().map(|entry| (&entry.motion, entry.interpolation, entry.span));
    let of_tools = deck.rigid_wall.iter().filter_map(|wall| wall.motion.as_ref());
    let of_tools = of_tools.map(|entry| (&entry.motion, entry.interpolation, entry.span));
    let displacements = of_nodes.chain(of_tools).filter(|(motion, ..)| motion.quantity() == Quantity::Displacement);
    let driven = displacements.filter_map(|(motion, interpolation, span)| {
        Some(Driven { span, curve: motion.curve(deck.interpolation(interpolation))? })
    });
    driven.collect()
}

/// A prescribed displacement may not go further in a step than a wave does; what it does between two points that are less than a
/// step apart is a blow, and may not be more than this share of that.
const BLOW: f64 = 0.1;

/// Reports displacements that jump while the time goes on in steps of about `time_step` (s), or outrun every wave in parts of so
/// many times their mass.
pub fn jumps(driven: &[Driven], parts: &[Part], mass_factor: f64, time_step: f64) -> Diagnostics {
    // c = √((k + 4μ/3)/ρ), of the fastest material
    let speed = |part: &Part| {
        let elasticity = part.material.elasticity();
        (elasticity.p_wave_modulus() / (elasticity.density() * mass_factor)).sqrt()
    };
    let speed = parts.iter().map(speed).fold(0.0, f64::max);
    let mut diagnostics = Diagnostics::default();
    for Driven { span, curve } in driven {
        let within = speed * time_step;
        let blow = curve.largest_rise(time_step).filter(|(rise, _)| *rise > BLOW * within);
        let (change, time) = curve.largest_change(time_step);
        let Some((change, time)) = blow.or((change > within).then_some((change, time))) else { continue };
        let message = format!("the prescribed displacement jumps by {change:.3e} m at {time:.6e} s");
        let label = format!("a step is about {time_step:.3e} s");
        let help = format!(
            "let it take longer: waves run at {speed:.4e} m/s and nothing is to be driven faster; what begins to move at once has \
             quantity = \"velocity\""
        );
        diagnostics.push(Diagnostic::error(message).at(*span, label).help(help));
    }
    diagnostics
}

fn report(message: String, prescribed: &PrescribedTable, other: Span, label: &str, diagnostics: &mut Diagnostics) {
    let diagnostic = Diagnostic::error(message).at(prescribed.direction.span, "prescribed here").at(other, label);
    diagnostics.push(diagnostic.help("take the common nodes out of one of the groups, or drop one of the two"));
}

fn name(direction: Direction) -> &'static str {
    match direction {
        Direction::X => "x",
        Direction::Y => "y",
        Direction::Z => "z",
    }
}

/// The nodes that are in both groups, in words, if there are any.
fn common_nodes(mesh: &Mesh, first: &GroupName<OfNodes>, second: &GroupName<OfNodes>) -> Option<String> {
    let (first, second) = (first.group(mesh)?, second.group(mesh)?);
    let mut common = first.nodes.iter().filter(|node| second.nodes.binary_search(node).is_ok());
    let example = mesh.node_labels()[*common.next()? as usize].0;
    Some(match common.count() {
        0 => format!("node {example} is"),
        more => format!("{} nodes, among them node {example}, are", more + 1),
    })
}
