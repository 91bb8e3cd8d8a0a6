//! Constraints that contradict each other.

use crate::deck::Deck;
use crate::deck::model::PrescribedTable;
use crate::diagnostics::{Diagnostic, Diagnostics, Span};
use estar_mesh::Mesh;
use estar_solver::Curve;
use estar_solver::model::{Direction, Quantity};

/// Reports nodes that are held and moved, or moved in two ways, in one direction.
pub fn check(deck: &Deck, mesh: &Mesh, diagnostics: &mut Diagnostics) {
    for fix in deck.fix.iter().filter(|fix| fix.directions.is_empty()) {
        let diagnostic = Diagnostic::error("`fix.directions` is empty: nothing is held").at(fix.span, "this fix");
        diagnostics.push(diagnostic.help("such as directions = [\"x\", \"y\"]"));
    }
    for (index, prescribed) in deck.prescribed.iter().enumerate() {
        let group = &prescribed.group.name;
        for fix in &deck.fix {
            let held = fix.directions.iter().find(|direction| direction.value == prescribed.direction.value);
            if let (Some(held), Some(common)) = (held, common_nodes(mesh, &group.value, &fix.group.name.value)) {
                let message = format!("{common} both fixed and prescribed in {}", name(prescribed.direction.value));
                report(message, prescribed, held.span, "fixed here", diagnostics);
            }
        }
        for other in &deck.prescribed[..index] {
            let differs = other.direction.value == prescribed.direction.value && motion(other) != motion(prescribed);
            if let Some(common) = common_nodes(mesh, &group.value, &other.group.name.value).filter(|_| differs) {
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

fn report(message: String, prescribed: &PrescribedTable, other: Span, label: &str, diagnostics: &mut Diagnostics) {
    let diagnostic = Diagnostic::error(message).at(prescribed.direction.span, "prescribed here").at(other, label);
    diagnostics.push(diagnostic.help("take the common nodes out of one of the groups, or drop one of the two"));
}

fn motion(prescribed: &PrescribedTable) -> (Quantity, Option<Curve>) {
    (prescribed.motion.quantity(), prescribed.motion.curve(prescribed.interpolation))
}

fn name(direction: Direction) -> &'static str {
    match direction {
        Direction::X => "x",
        Direction::Y => "y",
        Direction::Z => "z",
    }
}

/// The nodes that are in both groups, in words, if there are any.
fn common_nodes(mesh: &Mesh, first: &str, second: &str) -> Option<String> {
    let (first, second) = (mesh.group(first)?, mesh.group(second)?);
    let mut common = first.nodes.iter().filter(|node| second.nodes.binary_search(node).is_ok());
    let example = mesh.node_labels()[*common.next()? as usize].0;
    Some(match common.count() {
        0 => format!("node {example} is"),
        more => format!("{} nodes, among them node {example}, are", more + 1),
    })
}
