//! What is said of a run: what is going to be computed, and what came of it.

use estar_deck::format::{bytes, column_width, count, duration, elements, prefixed};
use estar_deck::model::element_name;
use estar_deck::units::Dimension;
use estar_io::one_line;
use estar_session::{Outcome, Probe, Problem, Summary};
use estar_solver::model::TimeStep;
use estar_solver::{LaneLevel, Simulation};
use std::fmt::Write;
use std::path::Path;

/// What is going to be computed.
pub fn announcement(problem: &Problem, simulation: &Simulation, threads: usize, lanes: LaneLevel) -> String {
    let mut text = format!("Estar {}", env!("CARGO_PKG_VERSION"));
    if !problem.title.is_empty() {
        let _ = write!(text, ": {}", one_line(&problem.title));
    }
    let time_step = simulation.time_step();
    let _ = write!(
        text,
        "\n  mesh       {} ({}): {} nodes, {}",
        problem.mesh_path.display(),
        problem.mesh_format,
        count(problem.mesh.node_count() as f64),
        elements(&problem.mesh, |number| count(number as f64))
    );
    if let Some(merged) = &problem.merged {
        let _ = write!(text, "\n  merge      {merged}");
    }
    for (description, part) in problem.parts.iter().zip(&problem.model.parts) {
        let _ = write!(
            text,
            "\n  part       {}: {} elements of {}, {}, {:.6e} kg",
            description.group,
            count(description.element_count as f64),
            description.material,
            element_name(part.element),
            description.mass
        );
    }
    if let Some(chosen) = &problem.quasi_static {
        let _ = write!(text, "\n  process    {}", chosen.told());
    }
    let added: f64 = simulation.added_mass().iter().sum();
    if added > 0.0 {
        let _ = write!(text, "\n  scaling    {added:.6e} kg added by mass scaling");
    }
    let (end, time) = (simulation.end_time(), simulation.time());
    let steps = count(((end - time) / time_step).ceil());
    let mass = problem.parts.iter().map(|part| part.mass).sum::<f64>();
    let _ = write!(text, "\n  mass       {mass:.6e} kg\n  time       {end:.6e} s, ");
    let _ = match simulation.step() {
        0 => write!(text, "first step {time_step:.4e} s, about {steps} steps if it stays so"),
        _ => write!(
            text,
            "{time:.6e} s of it done; next step {time_step:.4e} s, about {steps} more steps if it stays so"
        ),
    };
    if let TimeStep::Power { interval } = problem.model.settings.time_step {
        let gain = 100.0 * (simulation.extremes().stable_time_step / simulation.element_time_step() - 1.0);
        let _ = write!(
            text,
            "\n  time step  of the assembled mesh, estimated every {} steps: {gain:.1} % above the bound of the elements",
            count(interval as f64)
        );
    }
    let cores = std::thread::available_parallelism().map_or(threads, usize::from);
    let sharing = if threads > cores { format!(" (on {cores} cores, which is no faster)") } else { String::new() };
    let _ = write!(text, "\n  machine    {threads} threads{sharing}, {} lanes of {}", lanes.lanes(), lanes.name());
    text
}

/// What came of it.
pub fn conclusion(summary: &Summary, probes: &[Probe], directory: &Path) -> String {
    let energies = &summary.energies;
    let mut text = format!(
        "{} at t = {:.6e} s after {} steps in {}{}\n",
        summary.status,
        summary.time,
        count(summary.steps as f64),
        duration(summary.wall_seconds),
        summary.grind_time_ns.map_or(String::new(), |grind| {
            format!(": {}element steps/s, {grind:.1} ns per element step", prefixed(summary.element_steps_per_second))
        })
    );
    let rows = [
        ("kinetic energy", energies.kinetic_energy),
        ("internal energy", energies.internal_energy),
        ("plastic dissipation", energies.plastic_dissipation),
        ("of it as heat", energies.heat),
        ("deleted elements", energies.deleted_energy),
        ("bulk viscosity", energies.viscous_energy),
        ("hourglass control", energies.hourglass_energy),
        ("external work", energies.external_work),
        ("contact", energies.contact_energy),
        ("of it by friction", energies.friction_energy),
        ("damping", energies.damping_energy),
        ("motion of added mass", energies.mass_scaling_energy),
        ("time integration", energies.integration_energy),
        ("brought along", energies.initial_kinetic_energy),
    ];
    for (name, value) in rows.iter().filter(|(_, value)| *value != 0.0) {
        let _ = writeln!(text, "  {name:<20} {value:>14.6e} J");
    }
    match rows.iter().filter(|(_, value)| *value == 0.0).count() {
        0 => {}
        1 => text.push_str("  1 other row of the energy ledger is 0\n"),
        count => {
            let _ = writeln!(text, "  {count} other rows of the energy ledger are 0");
        }
    }
    let _ = writeln!(text, "  {:<20} {:>14.4} %", "energy error", 100.0 * summary.energy_error);
    if let Some(quasi_static) = &summary.quasi_static {
        let share = 100.0 * quasi_static.largest_kinetic_over_internal;
        let _ = writeln!(text, "  {:<20} {share:>14.4} % at most", "kinetic / internal");
        let share = 100.0 * quasi_static.damping_over_external_work;
        let _ = writeln!(text, "  {:<20} {share:>14.4} %", "damping / work");
    }
    for (name, value) in &summary.probes {
        let dimension = probes.iter().find(|probe| probe.name == *name).map(|probe| probe.dimension);
        let unit = dimension.filter(|dimension| *dimension != Dimension::NUMBER).map(Dimension::si_unit);
        let line = format!("  {name:<20} {value:>14.6e} {}", unit.unwrap_or_default());
        let _ = writeln!(text, "{}", line.trim_end());
    }
    let _ = writeln!(
        text,
        "  largest plastic strain {:.4}, {}\n  state {}",
        summary.extremes.max_equivalent_plastic_strain,
        match summary.extremes.min_jacobian {
            Some(jacobian) => format!("smallest Jacobian {jacobian:.4}"),
            None => "no element is left".to_owned(),
        },
        summary.state_hash
    );
    let _ = write!(
        text,
        "  {} ({} frames, {})",
        directory.join("results.pvd").display(),
        summary.frames,
        bytes(size_of_directory(directory))
    );
    text
}

/// Bytes of the frames.
fn size_of_directory(directory: &Path) -> f64 {
    let entries = std::fs::read_dir(directory.join("fields")).into_iter().flatten().flatten();
    entries.filter_map(|entry| entry.metadata().ok()).map(|metadata| metadata.len() as f64).sum()
}

/// A table of what was asked and what came out.
pub fn expectation_table(outcomes: &[Outcome]) -> String {
    let width = column_width(outcomes.iter().map(|outcome| outcome.probe.as_str())).max(5);
    let mut text = format!(
        "{:width$}  {:>12}  {:>14}  {:>14}  {:>12}  {:>9}\n",
        "probe", "time, s", "expected", "found", "tolerance", ""
    );
    for outcome in outcomes {
        let Outcome { probe, time, expected, found, tolerance, met } = outcome;
        let deviation = if *expected == 0.0 { String::new() } else { format!(" ({} %)", deviation(*found, *expected)) };
        let verdict = if *met { "met" } else { "MISSED" };
        text.push_str(&format!(
            "{probe:width$}  {time:>12.5e}  {expected:>14.6e}  {found:>14.6e}  {tolerance:>12.3e}  {verdict:>9}{deviation}\n"
        ));
    }
    text
}

/// How far `found` is from `expected`, in per cent with its sign; what rounds to nothing has none.
fn deviation(found: f64, expected: f64) -> String {
    let text = format!("{:+.2}", 100.0 * (found / expected - 1.0));
    if text == "-0.00" || text == "+0.00" { "0.00".to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_deviation_that_rounds_to_nothing_has_no_sign() {
        let found = [0.999_99, 1.0, 1.000_01, 0.9991, 1.0123, f64::NAN];
        let texts = found.map(|found| deviation(found, 1.0));
        assert_eq!(texts, ["0.00", "0.00", "0.00", "-0.09", "+1.23", "NaN"]);
    }
}
