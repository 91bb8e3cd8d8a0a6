//! `summary.json`: what a run was and what came of it.

use crate::error::SessionError;
use crate::expectations::Outcome;
use crate::files::SUMMARY;
use crate::problem::Problem;
use crate::snapshot::Snapshot;
use estar_deck::format::hex;
use estar_io::write_atomically;
use estar_solver::{Extremes, Simulation};
use serde::Serialize;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::path::Path;

/// The content of `summary.json`.
#[derive(Debug, Serialize)]
pub struct Summary {
    /// Version of Estar.
    pub version: &'static str,
    /// Title of the deck.
    pub title: String,
    /// File of the deck.
    pub deck: String,
    /// SHA-256 of the deck's text (and of overrides, if any).
    pub deck_hash: String,
    /// The mesh.
    pub mesh: MeshSummary,
    /// "finished", "failed" or "interrupted".
    pub status: &'static str,
    /// Why it did not finish.
    pub message: Option<String>,
    /// Simulated time, s.
    pub time: f64,
    /// Steps.
    pub steps: u64,
    /// The last time step, s.
    pub time_step: f64,
    /// The first time step, s.
    pub initial_time_step: f64,
    /// What the stable time step was taken from, "element" or "power".
    pub time_step_source: &'static str,
    /// Stable time step at the end, s, by the bound of the elements and without the safety factor; none where all are deleted.
    pub element_time_step: Option<f64>,
    /// The one that was used, s, without the safety factor; none where all elements are deleted.
    pub stable_time_step: Option<f64>,
    /// Estimates for the assembled mesh.
    pub time_step_estimates: u64,
    /// Wall time of the loop with its output, s.
    pub wall_seconds: f64,
    /// Elements times steps over wall time.
    pub element_steps_per_second: f64,
    /// Wall time per element step, ns; none before the first.
    pub grind_time_ns: Option<f64>,
    /// Threads.
    pub threads: usize,
    /// Vector instructions.
    pub lanes: &'static str,
    /// Frames written.
    pub frames: usize,
    /// Energies at the end, J.
    pub energies: EnergySummary,
    /// Energy error at the end, as a fraction.
    pub energy_error: f64,
    /// Linear momentum at the end, kg m/s.
    pub momentum: [f64; 3],
    /// What the run is to be doubted for.
    pub warnings: Vec<String>,
    /// Extremes at the end.
    pub extremes: ExtremeSummary,
    /// Elements that have been deleted.
    pub deleted_elements: u64,
    /// Of a quasi-static process, what was chosen for it and what came of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quasi_static: Option<QuasiStaticSummary>,
    /// By the number of the part in the deck, from 1: its group, and the smallest Jacobian of the run with its element.
    pub parts: Vec<PartSummary>,
    /// Value of every probe at the end, SI.
    pub probes: BTreeMap<String, f64>,
    /// What became of the expectations.
    pub expectations: Vec<Outcome>,
    /// Whether all were met.
    pub expectations_met: bool,
    /// SHA-256 of every bit of the final state.
    pub state_hash: String,
}

/// The mesh in numbers.
#[derive(Debug, Serialize)]
pub struct MeshSummary {
    /// Its file.
    pub file: String,
    /// The file's format.
    pub format: String,
    /// Nodes.
    pub nodes: usize,
    /// Elements.
    pub elements: usize,
    /// Groups.
    pub groups: usize,
    /// Mass, kg.
    pub mass: f64,
}

/// The rows of the energy ledger, J.
#[derive(Debug, Serialize)]
#[allow(missing_docs)]
pub struct EnergySummary {
    pub initial_kinetic_energy: f64,
    pub kinetic_energy: f64,
    pub internal_energy: f64,
    pub plastic_dissipation: f64,
    /// The part of the dissipation that has heated materials with a temperature.
    pub heat: f64,
    /// What deleted elements had taken, and `internal_energy` has no more.
    pub deleted_energy: f64,
    pub viscous_energy: f64,
    pub hourglass_energy: f64,
    pub external_work: f64,
    /// By name of the load.
    pub load_work: BTreeMap<String, f64>,
    pub prescribed_work: f64,
    /// By name of the rigid wall, of those that move.
    pub wall_work: BTreeMap<String, f64>,
    pub contact_energy: f64,
    /// The part of it that friction has taken.
    pub friction_energy: f64,
    pub damping_energy: f64,
    /// The part of the kinetic energy that is of added mass.
    pub mass_scaling_energy: f64,
    pub integration_energy: f64,
}

/// What was chosen for a quasi-static process, and what came of it.
#[derive(Debug, Serialize)]
pub struct QuasiStaticSummary {
    /// Factor on the mass of every element.
    pub mass_factor: f64,
    /// α of the damping −α m v, 1/s.
    pub mass_damping: f64,
    /// Half periods of the slowest vibration; passes of a wave through the body where its natural frequency is not known.
    pub transits: f64,
    /// The lowest natural frequency of the body as it is held, with its own mass, 1/s.
    pub natural_frequency: Option<f64>,
    /// Largest kinetic over internal energy since a tenth of the time.
    pub largest_kinetic_over_internal: f64,
    /// Share of the external work that damping has taken.
    pub damping_over_external_work: f64,
}

/// What was seen of a part.
#[derive(Debug, Serialize)]
pub struct PartSummary {
    /// Its group.
    pub group: String,
    /// Its elements.
    pub elements: u64,
    /// Those of them that have been deleted.
    pub deleted_elements: u64,
    /// Stress power of its elements, of deleted ones too, J.
    pub internal_energy: f64,
    /// Work against their hourglass control, J.
    pub hourglass_energy: f64,
    /// Mass that mass scaling has added, kg.
    pub added_mass: f64,
    /// The smallest Jacobian, det F, that one of its elements had in any step.
    pub smallest_jacobian: f64,
    /// The element.
    pub element: u64,
    /// When, s.
    pub time: f64,
}

/// Extremes over the elements.
#[derive(Debug, Serialize)]
#[allow(missing_docs)]
pub struct ExtremeSummary {
    pub max_equivalent_plastic_strain: f64,
    /// K, of the quadrature points; none where no material has a temperature.
    pub max_temperature: Option<f64>,
    /// None where all elements are deleted.
    pub min_jacobian: Option<f64>,
    /// None where all elements are deleted.
    pub controlling_element: Option<u64>,
}

impl MeshSummary {
    /// The mesh of a problem.
    pub fn new(problem: &Problem) -> Self {
        Self {
            file: problem.mesh_path.display().to_string(),
            format: problem.mesh_format.clone(),
            nodes: problem.mesh.node_count(),
            elements: problem.mesh.element_count(),
            groups: problem.mesh.groups().len(),
            mass: problem.parts.iter().map(|part| part.mass).sum(),
        }
    }
}

impl EnergySummary {
    /// The ledger of a simulation.
    pub fn new(simulation: &Simulation, problem: &Problem) -> Self {
        let energies = simulation.energies();
        let load_names = problem.model.loads.iter().map(|load| load.name.clone());
        let wall_names = problem.wall_names.iter().cloned();
        let of_walls = wall_names.zip(energies.wall_work.iter().copied());
        let moving = of_walls.zip(&problem.model.walls).filter(|(_, wall)| wall.motion.is_some());
        Self {
            initial_kinetic_energy: energies.initial_kinetic,
            kinetic_energy: energies.kinetic,
            internal_energy: energies.internal,
            plastic_dissipation: energies.plastic_dissipation,
            heat: energies.heat,
            deleted_energy: energies.deleted,
            viscous_energy: energies.viscous,
            hourglass_energy: energies.hourglass,
            external_work: energies.external_work(),
            load_work: load_names.zip(energies.load_work.iter().copied()).collect(),
            prescribed_work: energies.constraint_work,
            wall_work: moving.map(|(work, _)| work).collect(),
            contact_energy: energies.contact,
            friction_energy: energies.friction,
            damping_energy: energies.damping,
            mass_scaling_energy: energies.mass_scaling,
            integration_energy: energies.integration,
        }
    }
}

impl ExtremeSummary {
    /// The extremes of a simulation.
    pub fn new(snapshot: &Snapshot<'_>) -> Self {
        let extremes = snapshot.simulation.extremes();
        Self {
            max_equivalent_plastic_strain: extremes.max_equivalent_plastic_strain,
            max_temperature: extremes.max_temperature,
            min_jacobian: number(extremes.min_jacobian),
            controlling_element: controlling_element(snapshot, &extremes),
        }
    }
}

impl Summary {
    /// Writes the file, whole or not at all.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(&self, directory: &Path) -> Result<(), SessionError> {
        let path = directory.join(SUMMARY);
        let write = || -> std::io::Result<()> {
            let mut text = serde_json::to_string_pretty(self)?;
            text.push('\n');
            write_atomically(&path, text.as_bytes())
        };
        write().map_err(SessionError::writing(&path))
    }
}

/// A value that is a number; extremes over nothing are infinite, and so are quotients by it.
pub fn number(value: f64) -> Option<f64> {
    Some(value).filter(|value| value.is_finite())
}

/// The number in the mesh file of the element that sets the time step; none where all are deleted.
pub fn controlling_element(snapshot: &Snapshot<'_>, extremes: &Extremes) -> Option<u64> {
    let label = snapshot.mesh.element_labels()[extremes.controlling_element as usize].0;
    number(snapshot.simulation.element_time_step()).map(|_| label)
}

/// SHA-256 of every bit of a state: equal hashes are equal states.
pub fn state_hash(simulation: &Simulation) -> String {
    let mut hasher = Sha256::new();
    let mut buffer = Vec::with_capacity(1 << 16);
    simulation.for_each_number(|number| {
        buffer.extend_from_slice(&number.to_bits().to_le_bytes());
        if buffer.len() >= 1 << 16 {
            hasher.update(&buffer);
            buffer.clear();
        }
    });
    hasher.update(&buffer);
    hasher.update(simulation.step().to_le_bytes());
    hex(&hasher.finalize())
}
