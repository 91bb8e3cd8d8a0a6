//! `history.csv`: a row of numbers every so often.

use crate::error::SessionError;
use crate::files::HISTORY;
use crate::problem::Problem;
use crate::snapshot::Snapshot;
use crate::summary::{controlling_element, number};
use estar_deck::history_column::{COLUMNS, Extra};
use estar_io::{HistoryWriter, Value};
use estar_solver::model::OnInversion;
use std::path::{Path, PathBuf};

/// The growing file.
#[derive(Debug)]
pub struct History {
    path: PathBuf,
    extras: Vec<Extra>,
    writer: HistoryWriter,
    row_count: u64,
}

/// Whether a problem has such columns.
fn has(problem: &Problem, extra: Extra) -> bool {
    let model = &problem.model;
    match extra {
        Extra::Thermal => model.parts.iter().any(|part| part.material.has_temperature()),
        Extra::Deletion => model.settings.on_inversion == OnInversion::Delete,
        Extra::Friction => model.walls.iter().any(|wall| wall.friction > 0.0),
        Extra::Damping => model.settings.mass_damping > 0.0,
        Extra::QuasiStatic => problem.quasi_static.is_some(),
    }
}

fn extras(problem: &Problem) -> Vec<Extra> {
    Extra::ALL.into_iter().filter(|extra| has(problem, *extra)).collect()
}

/// The columns of the history of a problem.
fn columns<'a>(problem: &'a Problem, extras: &[Extra]) -> Vec<&'a str> {
    let extras = extras.iter().flat_map(|extra| extra.columns()).copied();
    let probes = problem.probes.iter().map(|probe| probe.name.as_str());
    COLUMNS.into_iter().chain(extras).chain(probes).collect()
}

impl History {
    /// Begins the file in a directory.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn create(directory: &Path, problem: &Problem) -> Result<Self, SessionError> {
        let path = directory.join(HISTORY);
        let extras = extras(problem);
        let writer = HistoryWriter::create(&path, &columns(problem, &extras)).map_err(SessionError::writing(&path))?;
        Ok(Self { path, extras, writer, row_count: 0 })
    }

    /// Goes on with the file after its first rows; later ones are dropped.
    ///
    /// # Errors
    /// It cannot be read or written, or has not so many rows.
    pub fn resume(directory: &Path, problem: &Problem, row_count: u64) -> Result<Self, SessionError> {
        let path = directory.join(HISTORY);
        let extras = extras(problem);
        let writer = HistoryWriter::resume(&path, &columns(problem, &extras), row_count);
        Ok(Self { writer: writer.map_err(SessionError::writing(&path))?, path, extras, row_count })
    }

    /// Why a run cannot go on after so many rows of the file, which is left as it is.
    ///
    /// # Errors
    /// The reason.
    pub fn check(directory: &Path, problem: &Problem, row_count: u64) -> Result<(), String> {
        let columns = columns(problem, &extras(problem));
        let length = HistoryWriter::length_of(&directory.join(HISTORY), &columns, row_count);
        length.map(|_| ()).map_err(|error| format!("{HISTORY}: {error}"))
    }

    /// Rows so far.
    pub fn row_count(&self) -> u64 {
        self.row_count
    }

    /// Puts the rows on the disk.
    ///
    /// # Errors
    /// The system refuses.
    pub fn sync(&self) -> Result<(), SessionError> {
        self.writer.sync().map_err(SessionError::writing(&self.path))
    }

    /// Adds the row of the present state, with the values of the probes; the smallest Jacobian.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(&mut self, snapshot: &Snapshot<'_>, probes: &[f64]) -> Result<f64, SessionError> {
        let simulation = snapshot.simulation;
        let energies = simulation.energies();
        let [x, y, z] = simulation.momentum();
        let extremes = simulation.extremes();
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
            Value::Real(energies.mass_scaling),
            Value::Real(energies.error()),
            Value::Real(x),
            Value::Real(y),
            Value::Real(z),
            Value::Real(extremes.max_equivalent_plastic_strain),
            Value::Real(extremes.min_jacobian),
            controlling_element(snapshot, &extremes).map_or(Value::Missing, Value::Integer),
        ];
        for extra in &self.extras {
            match extra {
                Extra::Thermal => {
                    row.extend([Value::Real(energies.heat), Value::Real(extremes.max_temperature.unwrap_or(f64::NAN))])
                }
                Extra::Deletion => {
                    row.extend([Value::Real(energies.deleted), Value::Integer(simulation.deleted_count())]);
                }
                Extra::Friction => row.push(Value::Real(energies.friction)),
                Extra::Damping => row.push(Value::Real(energies.damping)),
                Extra::QuasiStatic => row.push(Value::Real(energies.kinetic_over_internal())),
            }
        }
        row.extend(probes.iter().map(|value| Value::Real(*value)));
        // an extreme over elements that are all deleted, or energies over none, are no numbers
        for value in &mut row {
            if matches!(value, Value::Real(value) if number(*value).is_none()) {
                *value = Value::Missing;
            }
        }
        self.writer.write_row(&row).map_err(SessionError::writing(&self.path))?;
        self.row_count += 1;
        Ok(extremes.min_jacobian)
    }
}
