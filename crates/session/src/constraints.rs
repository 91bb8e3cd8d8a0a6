//! Constraints that contradict each other, and displacements that jump.

use estar_deck::Deck;
use estar_deck::diagnostics::{Diagnostic, Diagnostics, Span};
use estar_deck::model::PrescribedTable;
use estar_deck::names::{GroupName, OfNodes};
use estar_deck::values::NEGLIGIBLE;
use estar_mesh::Mesh;
use estar_solver::Curve;
use estar_solver::model::{Direction, Model, Part, Quantity};

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

/// A displacement that jumps by Δu within a step Δt sends off a wave of the strain Δu/(c Δt), with the stress ρ c Δu/Δt. Less than
/// this strain is no blow.
const STRAIN_OF_BLOW: f64 = 1e-3;

/// Reports displacements that jump while the time goes on in steps of about `time_step` (s), or outrun every wave in parts of so
/// many times their mass.
pub fn jumps(driven: &[Driven], model: &Model, mass_factor: f64, time_step: f64) -> Diagnostics {
    // c = √((k + 4μ/3)/ρ), of the fastest material
    let speed = |part: &Part| {
        let elasticity = part.material.elasticity();
        (elasticity.p_wave_modulus() / (elasticity.density() * mass_factor)).sqrt()
    };
    let speed = model.parts.iter().map(speed).fold(0.0, f64::max);
    let mut diagnostics = Diagnostics::default();
    for Driven { span, curve } in driven {
        let within = speed * time_step;
        let blow = jump(curve, time_step, model.settings.end, STRAIN_OF_BLOW * within);
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

/// The largest jump of a displacement before the end of a run, and when it begins.
///
/// A jump takes place within a step: the step before and the step after go on less than half as far in its direction, as those of a
/// straight rise do that takes less than two steps. It counts if it is more than [`NEGLIGIBLE`] of the largest value, as one at
/// time 0 does, or more than the least that is a blow (m).
fn jump(curve: &Curve, time_step: f64, end: f64, least: f64) -> Option<(f64, f64)> {
    let points = curve.times();
    let largest = points.iter().map(|time| curve.value(*time).abs()).fold(0.0, f64::max);
    let middles = points.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
    let beginnings =
        points.iter().copied().chain(middles).flat_map(|time| [time, time - 0.5 * time_step, time - time_step]);
    let changes = beginnings.filter(|time| *time < end).filter_map(|time| {
        let places = [-1.0, 0.0, 1.0, 2.0].map(|steps| curve.value(time + steps * time_step));
        let change = places[2] - places[1];
        let goes_on = |from: f64, to: f64| (to - from) * change.signum() >= 0.5 * change.abs();
        let is_alone = !goes_on(places[0], places[1]) && !goes_on(places[2], places[3]);
        (is_alone && change.abs() > least.min(NEGLIGIBLE * largest)).then_some((change.abs(), time))
    });
    // of equal ones the first begins where the jump does
    changes.reduce(|largest, next| if next.0 > largest.0 { next } else { largest })
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

#[cfg(test)]
mod tests {
    use super::*;
    use estar_solver::Interpolation;

    /// Steps of 1 µs, of which each carries a wave 5 mm far, until 1 ms.
    fn jump_of(points: &[[f64; 2]], interpolation: Interpolation) -> Option<f64> {
        let curve = Curve::new(points.to_vec(), interpolation).unwrap();
        jump(&curve, 1e-6, 1e-3, STRAIN_OF_BLOW * 5e-3).map(|(change, _)| change)
    }

    fn is_about(found: Option<f64>, expected: f64) -> bool {
        found.is_some_and(|found| (found - expected).abs() < 1e-9 * expected)
    }

    #[test]
    fn a_displacement_that_goes_on_within_a_step_jumps() {
        for interpolation in [Interpolation::Linear, Interpolation::Smooth, Interpolation::Monotone] {
            for du in [1e-8, 1e-5, 1e-4, 5e-3] {
                let at_rest = jump_of(&[[0.0, 0.0], [5e-4, 0.0], [5.000001e-4, du], [1e-3, du]], interpolation);
                assert!(is_about(at_rest, du), "{du} m from rest, {interpolation:?}: {at_rest:?}");
                let back = jump_of(&[[0.0, du], [5e-4, du], [5.000001e-4, 0.0]], interpolation);
                assert!(is_about(back, du), "{du} m back, {interpolation:?}: {back:?}");
            }
        }
        // in several points within a step, and on the way: 100 mm in 1 ms are 0.1 mm a step
        let many = jump_of(&[[0.0, 0.0], [5e-4, 0.0], [5.002e-4, 3e-5], [5.004e-4, 1e-4]], Interpolation::Linear);
        assert!(is_about(many, 1e-4), "{many:?}");
        let moving = jump_of(&[[0.0, 0.0], [5e-4, 0.05], [5.000001e-4, 0.051], [1e-3, 0.1]], Interpolation::Linear);
        assert!(moving.is_some_and(|jump| (jump - 1e-3).abs() < 1.1e-4), "{moving:?}");
        // 0.9 % of strain in a step, though less than 1e-4 of what the curve reaches
        let small = [[0.0, 0.0], [1e-4, 0.0], [1.000001e-4, 4.5e-5], [5e-4, 4.5e-5], [1e-3, 0.5]];
        let small = jump_of(&small, Interpolation::Linear);
        assert!(small.is_some(), "{small:?}");
        let spike = [[0.0, 0.0], [5e-4, 0.0], [5.001e-4, 1e-4], [5.002e-4, 0.0], [1e-3, 0.0]];
        assert!(jump_of(&spike, Interpolation::Linear).is_some());
    }

    #[test]
    fn a_displacement_that_takes_some_steps_does_not_jump() {
        let rise = |steps: f64| [[0.0, 0.0], [5e-4, 0.0], [5e-4 + steps * 1e-6, 1e-4], [1e-3, 1e-4]];
        for interpolation in [Interpolation::Linear, Interpolation::Smooth, Interpolation::Monotone] {
            for steps in [4.0, 5.0, 50.0, 500.0 - 1e-6] {
                assert_eq!(jump_of(&rise(steps), interpolation), None, "{steps} steps, {interpolation:?}");
            }
        }
        // a velocity that begins at once, to the end of the run or beyond
        assert_eq!(jump_of(&[[0.0, 0.0], [1e-3, 0.1]], Interpolation::Linear), None);
        assert_eq!(jump_of(&[[0.0, 0.0], [1.0, 100.0]], Interpolation::Linear), None);
        // a fine clock, and a blow after the end
        let fine: Vec<[f64; 2]> =
            (0..=10_000).map(|i| [1e-7 * f64::from(i), 1e-3 * (1e-4 * f64::from(i)).powi(2)]).collect();
        assert_eq!(jump_of(&fine, Interpolation::Monotone), None);
        assert_eq!(jump_of(&[[0.0, 0.0], [2e-3, 0.0], [2.0001e-3, 1e-3]], Interpolation::Linear), None);
        // the noise of a gauge, 1e-5 of its range
        let noisy: Vec<[f64; 2]> = (0..=10_000)
            .map(|i| [1e-7 * f64::from(i), 1e-7 * f64::from(i) + if i % 2 == 0 { 0.0 } else { 1e-8 }])
            .collect();
        assert_eq!(jump_of(&noisy, Interpolation::Linear), None);
    }
}
