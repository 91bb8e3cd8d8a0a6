//! Elements that come close to inversion: who is warned of, how close each part came, and a small series of frames of the
//! element that turned inside out, with its neighbours, through its last steps.

use crate::bits::Bits;
use crate::error::SessionError;
use crate::files::TROUBLE;
use crate::frames::{FrameNumbers, grid, part_of_element};
use crate::judgement;
use crate::problem::Problem;
use crate::summary::PartSummary;
use estar_deck::fields::Field;
use estar_deck::model::element_name;
use estar_io::{Grid, ResultWriter, WriteError, make_own_folder};
use estar_mesh::{Elements, Mesh};
use estar_solver::Simulation;
use estar_solver::model::Formulation;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::path::Path;

/// An element whose Jacobian falls below this share of its start is warned of.
const CLOSE: f64 = 0.1;
/// Steps before the last that the series shows.
pub const STEPS_SHOWN: u64 = 20;

/// How close each part has come so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Approach {
    parts: Vec<Closest>,
    /// Elements of each part that are deleted.
    deleted: Vec<u64>,
}

/// Elements that have been deleted, in words.
pub struct Deletions {
    /// How many, and what they took with them.
    pub told: String,
    /// The parts of which nothing is left now.
    pub warnings: Vec<String>,
}

/// The smallest Jacobian of a part so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Closest {
    jacobian: Bits,
    element: u32,
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
        let element_count = problem.mesh.element_count() as u32;
        self.parts.len() == problem.parts.len()
            && self.deleted.len() == problem.parts.len()
            && self.parts.iter().all(|closest| closest.element < element_count)
    }

    /// Before anything has moved.
    pub fn beginning(problem: &Problem) -> Self {
        let closest = |part: &estar_solver::model::Part| Closest {
            jacobian: Bits::from(1.0),
            element: part.elements.first().copied().unwrap_or(0),
            time: Bits::from(0.0),
        };
        Self { parts: problem.model.parts.iter().map(closest).collect(), deleted: vec![0; problem.parts.len()] }
    }

    /// Looks at a step; a warning for each part that comes close for the first time.
    pub fn look(&mut self, problem: &Problem, simulation: &Simulation) -> Vec<String> {
        let mut warnings = Vec::new();
        for (number, (closest, (jacobian, element))) in
            self.parts.iter_mut().zip(simulation.min_jacobians()).enumerate()
        {
            if jacobian < f64::from(closest.jacobian) {
                let was_close = closest.is_close();
                let (jacobian, time) = (Bits::from(jacobian), Bits::from(simulation.time()));
                *closest = Closest { jacobian, element, time };
                if closest.is_close() && !was_close {
                    warnings.push(warning(number, closest, problem, simulation));
                }
            }
        }
        warnings
    }

    /// What has been deleted since the last look.
    pub fn deletions(&mut self, problem: &Problem, simulation: &Simulation) -> Option<Deletions> {
        let so_far = simulation.deleted_count();
        let new = so_far - self.deleted.iter().sum::<u64>();
        if new == 0 {
            return None;
        }
        let mut warnings = Vec::new();
        for ((known, now), part) in self.deleted.iter_mut().zip(simulation.deleted_counts()).zip(&problem.parts) {
            let all = part.element_count as u64;
            if now == all && *known < all {
                let when = format!("step {}, t = {:.6e} s", simulation.step(), simulation.time());
                warnings.push(format!("{} ({when})", judgement::gone(&part.group, all)));
            }
            *known = now;
        }
        let told = format!(
            "step {}, t = {:.6e} s: {new} of {} elements turned inside out or were squeezed flat, and are deleted, {} so far, {:.4e} J with them",
            simulation.step(),
            simulation.time(),
            problem.mesh.element_count(),
            so_far,
            simulation.energies().deleted
        );
        Some(Deletions { told, warnings })
    }

    /// How close each part came, and its energies.
    pub fn summary(&self, problem: &Problem, simulation: &Simulation) -> Vec<PartSummary> {
        let counts = problem.parts.iter().zip(simulation.deleted_counts());
        let work = simulation.part_energies().zip(simulation.added_mass());
        let parts = self.parts.iter().zip(counts).zip(work);
        parts
            .map(|((closest, (part, deleted_elements)), ([internal_energy, hourglass_energy], added_mass))| {
                PartSummary {
                    group: part.group.clone(),
                    elements: part.element_count as u64,
                    deleted_elements,
                    internal_energy,
                    hourglass_energy,
                    added_mass: *added_mass,
                    smallest_jacobian: f64::from(closest.jacobian),
                    element: problem.mesh.element_labels()[closest.element as usize].0,
                    time: f64::from(closest.time),
                }
            })
            .collect()
    }
}

/// The element that held where those of a formulation turned inside out (docs/elements.md), in words; none where none is known.
pub fn other_element(element: Formulation) -> Option<String> {
    matches!(element, Formulation::FBar | Formulation::BBar).then(|| {
        format!(
            "element = \"hex8-one-point\", which held in the impacts and indentations that turned `{}` inside out",
            element_name(element)
        )
    })
}

fn warning(part: usize, closest: &Closest, problem: &Problem, simulation: &Simulation) -> String {
    let of_element = problem.mesh.elements().nodes(closest.element as usize).iter();
    let labels = of_element.map(|&node| problem.mesh.node_labels()[node as usize].0.to_string());
    let nodes = labels.collect::<Vec<_>>().join(" ");
    format!(
        "warning: element {} of part {} is squeezed to {:.3} of its volume or less at step {}, t = {:.6e} s; its nodes are \
         {nodes}. It may turn inside out. What helps: {}a finer or better shaped mesh there{}",
        problem.mesh.element_labels()[closest.element as usize].0,
        problem.parts[part].group,
        f64::from(closest.jacobian),
        simulation.step(),
        simulation.time(),
        other_element(problem.model.parts[part].element).map_or(String::new(), |other| other + ", "),
        if simulation.deletes() { "" } else { ", or [time] on_inversion = \"delete\"" }
    )
}

/// An element and those that share a node with it.
pub struct Neighbourhood {
    mesh: Mesh,
    grid: Grid,
    nodes: Vec<u32>,
    elements: Vec<u32>,
    fields: Vec<Field>,
}

impl Neighbourhood {
    /// That of an element.
    ///
    /// # Errors
    /// None is to be expected: it is a piece of a mesh that was good.
    pub fn of(element: u32, problem: &Problem) -> Result<Self, SessionError> {
        let whole = &problem.mesh;
        let nodes_of = |element: u32| whole.elements().nodes(element as usize);
        let corners: BTreeSet<u32> = nodes_of(element).iter().copied().collect();
        let touches = |element: &u32| nodes_of(*element).iter().any(|node| corners.contains(node));
        let elements: Vec<u32> = (0..whole.element_count() as u32).filter(touches).collect();
        let nodes: BTreeSet<u32> = elements.iter().flat_map(|element| nodes_of(*element)).copied().collect();
        let nodes: Vec<u32> = nodes.into_iter().collect();
        let place = |node: u32| nodes.binary_search(&node).unwrap_or_default() as u32;
        let parts = part_of_element(whole, &problem.model.parts);
        let at = |index: &u32| *index as usize;
        let mut pieces = Elements::default();
        for &element in &elements {
            let of_piece: Vec<u32> = nodes_of(element).iter().map(|&node| place(node)).collect();
            pieces.push(whole.elements().shape(element as usize), &of_piece);
        }
        let mesh = Mesh::new(
            nodes.iter().map(|node| whole.coordinates()[at(node)]).collect(),
            nodes.iter().map(|node| whole.node_labels()[at(node)]).collect(),
            pieces,
            elements.iter().map(|element| whole.element_labels()[at(element)]).collect(),
            Vec::new(),
        );
        let mesh = mesh?;
        let parts: Vec<i32> = elements.iter().map(|element| parts[at(element)]).collect();
        let grid = grid(&mesh, &parts)?;
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
        Ok(Self { mesh, grid, nodes, elements, fields })
    }

    /// The present state of it.
    pub fn seen(&self, simulation: &Simulation) -> FrameNumbers {
        let mut numbers = FrameNumbers::default();
        numbers.take(simulation, &self.fields);
        numbers.of(&self.nodes, &self.elements)
    }

    /// Writes a series of states into the folder of the series.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(&self, states: &[FrameNumbers], directory: &Path) -> Result<(), SessionError> {
        let write = || -> Result<(), WriteError> {
            let folder = directory.join(TROUBLE);
            make_own_folder(&folder).map_err(|source| WriteError::Unwritable { path: folder.clone(), source })?;
            let mut writer = ResultWriter::create(&folder)?;
            states.iter().try_for_each(|state| state.write(&mut writer, &self.grid, &self.mesh, &self.fields))
        };
        Ok(write()?)
    }
}
