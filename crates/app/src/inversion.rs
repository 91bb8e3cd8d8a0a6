//! Elements that come close to inversion: who is warned of, how close each part came, and a small series of frames of the
//! element that turned inside out, with its neighbours, through its last steps.

use crate::checkpoint::Bits;
use crate::failure::Failure;
use crate::fields::Field;
use crate::frames::{FrameNumbers, grid, part_of_hex};
use crate::setup::{PartDescription, Problem};
use crate::summary::PartSummary;
use estar_io::{Grid, ResultWriter, WriteError};
use estar_mesh::Mesh;
use estar_solver::Simulation;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::path::Path;

/// An element whose Jacobian falls below this share of its start is warned of.
const CLOSE: f64 = 0.1;
/// Steps before the last that the series shows.
pub const STEPS_SHOWN: u64 = 20;
/// The directory of the series.
pub const FOLDER: &str = "trouble";

/// How close each part has come so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Approach {
    parts: Vec<Closest>,
    deleted: u64,
}

/// The smallest Jacobian of a part so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Closest {
    jacobian: Bits,
    hex: u32,
    time: Bits,
}

impl Closest {
    fn is_close(&self) -> bool {
        f64::from(self.jacobian) < CLOSE
    }
}

impl Approach {
    /// Whether it is one of the parts of this problem.
    pub fn is_of(&self, problem: &Problem) -> bool {
        let hex_count = problem.mesh.hex_count() as u32;
        self.parts.len() == problem.parts.len() && self.parts.iter().all(|closest| closest.hex < hex_count)
    }

    /// Before anything has moved.
    pub fn beginning(problem: &Problem) -> Self {
        let closest = |part: &estar_solver::model::Part| Closest {
            jacobian: Bits::from(1.0),
            hex: part.hexes.first().copied().unwrap_or(0),
            time: Bits::from(0.0),
        };
        Self { parts: problem.model.parts.iter().map(closest).collect(), deleted: 0 }
    }

    /// Looks at a step; a warning for each part that comes close for the first time.
    pub fn look(&mut self, problem: &Problem, simulation: &Simulation) -> Vec<String> {
        let mut warnings = Vec::new();
        for (number, (closest, (jacobian, hex))) in self.parts.iter_mut().zip(simulation.min_jacobians()).enumerate() {
            if jacobian < f64::from(closest.jacobian) {
                let was_close = closest.is_close();
                let (jacobian, time) = (Bits::from(jacobian), Bits::from(simulation.time()));
                *closest = Closest { jacobian, hex, time };
                if closest.is_close() && !was_close {
                    warnings.push(warning(number, closest, problem, simulation));
                }
            }
        }
        warnings
    }

    /// What has been deleted since the last look, in words.
    pub fn deletions(&mut self, problem: &Problem, simulation: &Simulation) -> Option<String> {
        let new = simulation.deleted_count() - self.deleted;
        if new == 0 {
            return None;
        }
        self.deleted = simulation.deleted_count();
        Some(format!(
            "step {}, t = {:.6e} s: {new} of {} elements turned inside out or were squeezed flat, and are deleted, {} so far, {:.4e} J with them",
            simulation.step(),
            simulation.time(),
            problem.mesh.hex_count(),
            self.deleted,
            simulation.energies().deleted
        ))
    }

    /// How close each part came, and its energies.
    pub fn summary(&self, problem: &Problem, simulation: &Simulation) -> Vec<PartSummary> {
        let summary =
            |(((closest, part), energies), added_mass): (((&Closest, &PartDescription), [f64; 2]), &f64)| PartSummary {
                group: part.group.clone(),
                internal_energy: energies[0],
                hourglass_energy: energies[1],
                added_mass: *added_mass,
                smallest_jacobian: f64::from(closest.jacobian),
                element: problem.mesh.hex_labels()[closest.hex as usize].0,
                time: f64::from(closest.time),
            };
        let parts = self.parts.iter().zip(&problem.parts).zip(simulation.part_energies());
        parts.zip(simulation.added_mass()).map(summary).collect()
    }
}

fn warning(part: usize, closest: &Closest, problem: &Problem, simulation: &Simulation) -> String {
    let corners = problem.mesh.hexes()[closest.hex as usize];
    let nodes = corners.map(|node| problem.mesh.node_labels()[node as usize].0.to_string()).join(" ");
    format!(
        "warning: element {} of part {} is squeezed to {:.3} of its volume or less at step {}, t = {:.6e} s; its nodes are \
         {nodes}. It may turn inside out: a finer or better shaped mesh there helps{}",
        problem.mesh.hex_labels()[closest.hex as usize].0,
        problem.parts[part].group,
        f64::from(closest.jacobian),
        simulation.step(),
        simulation.time(),
        if simulation.deletes() { "" } else { ", or [time] on_inversion = \"delete\"" }
    )
}

/// An element and those that share a node with it.
pub struct Neighbourhood {
    mesh: Mesh,
    grid: Grid,
    nodes: Vec<u32>,
    hexes: Vec<u32>,
    fields: Vec<Field>,
}

impl Neighbourhood {
    /// That of a hex.
    ///
    /// # Errors
    /// None is to be expected: it is a piece of a mesh that was good.
    pub fn of(hex: u32, problem: &Problem) -> Result<Self, Failure> {
        let whole = &problem.mesh;
        let corners: BTreeSet<u32> = whole.hexes()[hex as usize].into_iter().collect();
        let touches = |hex: &u32| whole.hexes()[*hex as usize].iter().any(|node| corners.contains(node));
        let hexes: Vec<u32> = (0..whole.hex_count() as u32).filter(touches).collect();
        let nodes: BTreeSet<u32> = hexes.iter().flat_map(|hex| whole.hexes()[*hex as usize]).collect();
        let nodes: Vec<u32> = nodes.into_iter().collect();
        let place = |node: u32| nodes.binary_search(&node).unwrap_or_default() as u32;
        let parts = part_of_hex(whole, &problem.model.parts);
        let at = |index: &u32| *index as usize;
        let mesh = Mesh::new(
            nodes.iter().map(|node| whole.coordinates()[at(node)]).collect(),
            nodes.iter().map(|node| whole.node_labels()[at(node)]).collect(),
            hexes.iter().map(|hex| whole.hexes()[at(hex)].map(place)).collect(),
            hexes.iter().map(|hex| whole.hex_labels()[at(hex)]).collect(),
            Vec::new(),
        );
        let failure = |error: &dyn std::fmt::Display| Failure::File(format!("error: {error}"));
        let mesh = mesh.map_err(|error| failure(&error))?;
        let parts: Vec<i32> = hexes.iter().map(|hex| parts[at(hex)]).collect();
        let grid = grid(&mesh, &parts).map_err(|error| failure(&error))?;
        let mut fields = vec![
            Field::Displacement,
            Field::Velocity,
            Field::CauchyStress,
            Field::EquivalentPlasticStrain,
            Field::VonMisesStress,
            Field::Pressure,
            Field::VolumeRatio,
        ];
        if problem.model.parts.iter().any(|part| part.material.has_temperature()) {
            fields.push(Field::Temperature);
        }
        Ok(Self { mesh, grid, nodes, hexes, fields })
    }

    /// The present state of it.
    pub fn seen(&self, simulation: &Simulation) -> FrameNumbers {
        let mut numbers = FrameNumbers::default();
        numbers.take(simulation, &self.fields);
        numbers.of(&self.nodes, &self.hexes)
    }

    /// Writes a series of states into the folder of the series.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(&self, states: &[FrameNumbers], directory: &Path) -> Result<(), Failure> {
        let write = || -> Result<(), WriteError> {
            let mut writer = ResultWriter::create(&directory.join(FOLDER))?;
            states.iter().try_for_each(|state| state.write(&mut writer, &self.grid, &self.mesh, &self.fields))
        };
        write().map_err(|error| Failure::File(format!("error: {error}")))
    }
}
