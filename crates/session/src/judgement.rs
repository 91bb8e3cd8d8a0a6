//! What a run that has ended is to be doubted for: each doubt in the run's own numbers, with what helps.

use crate::problem::Problem;
use crate::quasi_static::{MOST_DAMPING, MOST_KINETIC};
use crate::summary::{PartSummary, QuasiStaticSummary, Summary, number};
use estar_deck::model::element_name;
use estar_solver::model::Formulation;

/// Work against hourglass control over internal energy, above which practice no longer takes it for a small correction.
const MOST_HOURGLASS: f64 = 0.1;
/// Such work, as a share of the energy in play, is too little to speak of.
const HOURGLASS_OF_NO_ACCOUNT: f64 = 1e-6;
/// Energy that contact with tools has given, over the largest energy in play, from which on the run is doubted.
const MOST_GIVEN_BY_CONTACT: f64 = 0.01;
/// Energy error, as a fraction, above which an explicit run is doubted.
const MOST_ENERGY_ERROR: f64 = 0.01;

/// The warnings of a run; `in_play` is the largest energy in play, J.
pub fn warnings(summary: &Summary, problem: &Problem, in_play: f64) -> Vec<String> {
    let hourglass = summary.parts.iter().filter_map(|part| of_hourglass(part, in_play));
    let gone = summary.parts.iter().filter_map(of_deletion);
    let contact = of_contact(summary.energies.contact_energy, in_play);
    let slowness = summary.quasi_static.iter().flat_map(of_slowness);
    hourglass.chain(of_energy(summary.energy_error, problem)).chain(contact).chain(gone).chain(slowness).collect()
}

fn of_hourglass(part: &PartSummary, in_play: f64) -> Option<String> {
    let most = (MOST_HOURGLASS * part.internal_energy).max(HOURGLASS_OF_NO_ACCOUNT * in_play);
    (part.hourglass_energy > most).then(|| {
        format!(
            "warning: the hourglass control of part {} has taken {:.3e} J, {} of its internal energy, where up to {:.0} % is sound: a \
             finer mesh helps, or element = \"hex8-b-bar\"",
            part.group,
            part.hourglass_energy,
            number(100.0 * part.hourglass_energy / part.internal_energy)
                .map_or("more than all".to_owned(), |share| format!("{share:.0} %")),
            100.0 * MOST_HOURGLASS
        )
    })
}

fn of_contact(contact: f64, in_play: f64) -> Option<String> {
    (contact < -MOST_GIVEN_BY_CONTACT * in_play).then(|| {
        format!(
            "warning: contact with tools has given {:.3e} J, {:.1} % of the largest energy in play, where it can only take: tools meet \
             what is held, or too few nodes touch them",
            -contact,
            -100.0 * contact / in_play
        )
    })
}

fn of_energy(error: f64, problem: &Problem) -> Option<String> {
    if error.is_nan() || error.abs() < MOST_ENERGY_ERROR {
        return None;
    }
    Some(format!(
        "warning: the energy error is {:+.2} %, where less than {:.0} % is sound: {}",
        100.0 * error,
        100.0 * MOST_ENERGY_ERROR,
        energy_advice(problem)
    ))
}

/// What helps against an energy error.
pub fn energy_advice(problem: &Problem) -> String {
    let parts = problem.parts.iter().zip(&problem.model.parts);
    let of_f_bar: Vec<&str> = parts
        .filter(|(_, part)| part.element == Formulation::FBar)
        .map(|(description, _)| description.group.as_str())
        .collect();
    let general = "a smaller [time] safety_factor, or a finer mesh where it deforms most";
    if of_f_bar.is_empty() {
        general.to_owned()
    } else {
        format!(
            "the forces of `{}` (part {}) do other work than its stress; with element = \"hex8-b-bar\", which costs a tenth more, \
             they do the same. Otherwise {general}",
            element_name(Formulation::FBar),
            of_f_bar.join(", ")
        )
    }
}

/// What is to be doubted of a process that should be slow.
fn of_slowness(summary: &QuasiStaticSummary) -> Vec<String> {
    let mut doubts = Vec::new();
    if summary.largest_kinetic_over_internal > MOST_KINETIC {
        doubts.push(format!(
            "warning: the kinetic energy was up to {:.1} % of the internal energy, where up to {:.0} % is taken for quasi-static: \
             more `transits` in [time] quasi_static make the process slower",
            100.0 * summary.largest_kinetic_over_internal,
            100.0 * MOST_KINETIC
        ));
    }
    if summary.damping_over_external_work > MOST_DAMPING {
        doubts.push(format!(
            "warning: damping took {:.1} % of the external work, where up to {:.0} % is taken for quasi-static: forces are too large by \
             about as much; more `transits` or less `damping` in [time] quasi_static",
            100.0 * summary.damping_over_external_work,
            100.0 * MOST_DAMPING
        ));
    }
    doubts
}

fn of_deletion(part: &PartSummary) -> Option<String> {
    (part.deleted_elements == part.elements && part.elements > 0).then(|| gone(&part.group, part.elements))
}

/// A part of which nothing is left.
pub fn gone(group: &str, element_count: u64) -> String {
    format!(
        "warning: all {element_count} elements of part {group} are deleted: from then on only the mass of its nodes moves on, and \
         nothing of it carries a force"
    )
}
