//! `history.csv`: a row of numbers every so often.

use crate::checkpoint;
use crate::failure::Failure;
use crate::setup::Problem;
use crate::snapshot::Snapshot;
use estar_io::{HistoryWriter, Value};
use estar_solver::model::OnInversion;
use std::path::{Path, PathBuf};

/// The columns before those of the probes.
pub const COLUMNS: [&str; 18] = [
    "time",
    "step",
    "time_step",
    "kinetic_energy",
    "internal_energy",
    "plastic_dissipation",
    "viscous_energy",
    "hourglass_energy",
    "external_work",
    "contact_energy",
    "mass_scaling_energy",
    "energy_error",
    "momentum_x",
    "momentum_y",
    "momentum_z",
    "max_equivalent_plastic_strain",
    "min_jacobian",
    "controlling_element",
];

/// Those that follow where a material has a temperature.
pub const THERMAL_COLUMNS: [&str; 2] = ["heat", "max_temperature"];

/// Those that follow where elements can be deleted.
pub const DELETION_COLUMNS: [&str; 2] = ["deleted_energy", "deleted_elements"];

/// The growing file.
#[derive(Debug)]
pub struct History {
    path: PathBuf,
    writer: HistoryWriter,
    row_count: u64,
}

const FILE: &str = "history.csv";

/// The columns of the history of a problem.
fn columns(problem: &Problem) -> Vec<&str> {
    let has_temperature = problem.model.parts.iter().any(|part| part.material.has_temperature());
    let thermal = THERMAL_COLUMNS.into_iter().filter(|_| has_temperature);
    let deletes = problem.model.settings.on_inversion == OnInversion::Delete;
    let deletion = DELETION_COLUMNS.into_iter().filter(|_| deletes);
    let probes = problem.probes.iter().map(|probe| probe.name.as_str());
    COLUMNS.into_iter().chain(thermal).chain(deletion).chain(probes).collect()
}

impl History {
    /// Begins the file in a directory.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn create(directory: &Path, problem: &Problem) -> Result<Self, Failure> {
        let path = directory.join(FILE);
        let writer = HistoryWriter::create(&path, &columns(problem)).map_err(Failure::writing(&path))?;
        Ok(Self { path, writer, row_count: 0 })
    }

    /// Goes on with the file after its first rows; later ones are dropped.
    ///
    /// # Errors
    /// It cannot be read or written, or has not so many rows.
    pub fn resume(directory: &Path, problem: &Problem, row_count: u64) -> Result<Self, Failure> {
        let path = directory.join(FILE);
        let writer = HistoryWriter::resume(&path, &columns(problem), row_count).map_err(|error| {
            Failure::File(format!("error: the run cannot go on: {}: {error}{}", path.display(), checkpoint::START_OVER))
        })?;
        Ok(Self { writer, path, row_count })
    }

    /// Rows so far.
    pub fn row_count(&self) -> u64 {
        self.row_count
    }

    /// Puts the rows on the disk.
    ///
    /// # Errors
    /// The system refuses.
    pub fn sync(&self) -> Result<(), Failure> {
        self.writer.sync().map_err(Failure::writing(&self.path))
    }

    /// Adds the row of the present state, with the values of the probes; the smallest Jacobian.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(&mut self, snapshot: &Snapshot<'_>, probes: &[f64]) -> Result<f64, Failure> {
        let simulation = snapshot.simulation;
        let energies = simulation.energies();
        let [x, y, z] = simulation.momentum();
        let extremes = simulation.extremes();
        let label = snapshot.mesh.element_labels()[extremes.controlling_element as usize].0;
        let mut row = vec![
            Value::Real(simulation.time()),
            Value::Integer(simulation.step()),
            Value::Real(simulation.time_step()),
            Value::Real(energies.kinetic),
            Value::Real(energies.internal),
            Value::Real(energies.plastic_dissipation),
            Value::Real(energies.viscous),
            Value::Real(energies.hourglass),
            Value::Real(energies.external_work()),
            Value::Real(energies.contact),
            // no mass is scaled: that row of the ledger is empty
            Value::Real(0.0),
            Value::Real(energies.error()),
            Value::Real(x),
            Value::Real(y),
            Value::Real(z),
            Value::Real(extremes.max_equivalent_plastic_strain),
            Value::Real(extremes.min_jacobian),
            Value::Integer(label),
        ];
        if let Some(temperature) = extremes.max_temperature {
            row.extend([Value::Real(energies.heat), Value::Real(temperature)]);
        }
        if simulation.deletes() {
            row.extend([Value::Real(energies.deleted), Value::Integer(simulation.deleted_count())]);
        }
        row.extend(probes.iter().map(|value| Value::Real(*value)));
        self.writer.write_row(&row).map_err(Failure::writing(&self.path))?;
        self.row_count += 1;
        Ok(extremes.min_jacobian)
    }
}
