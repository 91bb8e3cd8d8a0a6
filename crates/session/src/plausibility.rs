//! Sizes, speeds and numbers of steps that no real problem has: usually one in another unit than it was meant to be. Each is a warning with the likely
//! unit, never an error.

use estar_deck::Deck;
use estar_deck::diagnostics::{Diagnostic, Diagnostics, Span};
use estar_deck::format::short;
use estar_mesh::Mesh;
use estar_solver::Simulation;
use estar_solver::model::{Part, Quantity};

/// Bodies above this size (m) are rarely meant when their process is over in less than this (s), or before a wave has gone
/// through this share of them.
const LARGE: f64 = 10.0;
const SHORT_TIME: f64 = 1e-3;
const SHORT_WAY: f64 = 0.1;
/// The same of bodies that can be large, with a much shorter way.
const RATHER_LARGE: f64 = 1.0;
const VERY_SHORT_WAY: f64 = 0.01;
/// Bodies below this size (m) are rarely meant where the deck makes the mesh smaller.
const SMALL: f64 = 1e-5;
/// An initial velocity is rarely meant to be so many times that of sound.
const MOST_MACH: f64 = 10.0;
/// A displacement is rarely meant to be so many times the size of the mesh.
const MOST_DISPLACEMENT: f64 = 100.0;
/// No run has been waited for through so many steps.
const MOST_STEPS: f64 = 1e8;

/// Sizes, velocities and displacements against each other; the mesh is named in `mesh_span`.
pub fn check_sizes(deck: &Deck, mesh: &Mesh, parts: &[Part], mesh_span: Span, diagnostics: &mut Diagnostics) {
    let [low, high] = mesh.extent();
    let sizes = [0, 1, 2].map(|axis| high[axis] - low[axis]);
    let size = sizes.into_iter().fold(0.0, f64::max);
    let sound =
        |part: &Part| (part.material.elasticity().young_modulus() / part.material.elasticity().density()).sqrt();
    let sound = parts.iter().map(sound).fold(0.0, f64::max);
    let (end, scale) = (deck.time.end.value, deck.mesh.scale.value);
    let way = end * sound / size;
    let is_fast = size > LARGE && (end < SHORT_TIME || way < SHORT_WAY) || size > RATHER_LARGE && way < VERY_SHORT_WAY;
    let [x, y, z] = sizes.map(short);
    if scale == 1.0 && is_fast {
        let message = format!(
            "the mesh is {x} × {y} × {z} m large, and sound goes through {} % of that until the end, {} s",
            short(100.0 * way),
            short(end)
        );
        let help = "if the file is in mm: `scale = 1e-3` in [mesh]";
        diagnostics.push(Diagnostic::warning(message).at(mesh_span, "is it in metres?").help(help));
    }
    if scale < 1.0 && size < SMALL {
        let message = format!("the mesh is {x} × {y} × {z} m large, {} times the size of the file", short(scale));
        let help = "if the file is in metres already, leave out `scale` in [mesh]";
        diagnostics.push(Diagnostic::warning(message).at(mesh_span, "is it that small?").help(help));
    }
    if scale > 1.0 && size > LARGE {
        let message = format!("the mesh is {x} × {y} × {z} m large, {} times the size of the file", short(scale));
        let help = "`scale` in [mesh] is the length in m of a unit of the file: 1e-3 of mm";
        diagnostics.push(Diagnostic::warning(message).at(mesh_span, "is it that large?").help(help));
    }
    for entry in &deck.initial_velocity {
        let speed = entry.value.map_or(0.0, |vector| vector.value.iter().map(|v| v * v).sum::<f64>().sqrt());
        if speed > MOST_MACH * sound && sound > 0.0 {
            let message =
                format!("an initial velocity of {} m/s is {} times that of sound", short(speed), short(speed / sound));
            let diagnostic = Diagnostic::warning(message).at(entry.span, "this velocity");
            diagnostics.push(diagnostic.help("numbers without a unit are in m/s; such as \"227 mm/s\" has one"));
        }
    }
    for entry in &deck.prescribed {
        let Some(curve) = entry.motion.curve(deck.interpolation(entry.interpolation)) else { continue };
        let times = || curve.times().into_iter().filter(|time| *time <= end).chain([end]);
        let speed = match entry.motion.quantity() {
            Quantity::Velocity => times().map(|time| curve.value(time).abs()).fold(0.0, f64::max),
            Quantity::Acceleration => times().map(|time| curve.integral(time).abs()).fold(0.0, f64::max),
            // one that outruns every wave is refused once the time step is known
            Quantity::Displacement => 0.0,
        };
        if speed > MOST_MACH * sound && sound > 0.0 {
            let message = format!(
                "a prescribed velocity of {} m/s is {} times that of sound",
                short(speed),
                short(speed / sound)
            );
            let diagnostic = Diagnostic::warning(message).at(entry.span, "this motion");
            diagnostics.push(diagnostic.help("numbers without a unit are in m/s; such as \"300 mm/s\" has one"));
        }
        if entry.motion.quantity() != Quantity::Displacement {
            continue;
        }
        let most = times().map(|time| curve.value(time).abs()).fold(0.0, f64::max);
        if most > MOST_DISPLACEMENT * size {
            let message =
                format!("a displacement of {} m is {} times the size of the mesh", short(most), short(most / size));
            let diagnostic = Diagnostic::warning(message).at(entry.span, "this displacement");
            diagnostics.push(diagnostic.help("numbers without a unit are in m; such as \"7 mm\" has one"));
        }
    }
}

/// A run of more steps than anyone waits for.
pub fn doubt_about_steps(simulation: &Simulation) -> Option<Diagnostic> {
    let (end, time_step) = (simulation.end_time(), simulation.time_step());
    let steps = end / time_step;
    if steps <= MOST_STEPS {
        return None;
    }
    let message =
        format!("the run takes {} steps of {} s to its end, {} s", short(steps), short(time_step), short(end));
    // the first number of the end as one may have meant it
    let units = [(1e-3, "ms"), (1e-6, "us"), (1e-9, "ns")];
    let meant = units.into_iter().filter(|(factor, _)| (10.0..1e7).contains(&(steps * factor)));
    let meant: Vec<String> = meant
        .map(|(factor, unit)| format!("end = \"{} {unit}\" ({} steps)", short(end), short(steps * factor)))
        .collect();
    let unit =
        if meant.is_empty() { String::new() } else { format!("if another unit is meant: {}; else ", meant.join(", ")) };
    let help = format!(
        "{unit}`estar check` names the elements that control the step, and [time] quasi_static or mass_scaling make slow processes short"
    );
    Some(Diagnostic::warning(message).help(help))
}
