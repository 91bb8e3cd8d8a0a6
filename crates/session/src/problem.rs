//! A problem that can be run, as data.

use crate::constraints::Driven;
use crate::expectations::Expectation;
use crate::output::OutputPlan;
use crate::probes::Probe;
use crate::quasi_static::QuasiStatic;
use estar_deck::diagnostics::Findings;
use estar_mesh::quality::QualitySummary;
use estar_mesh::{Connectivity, Mesh};
use estar_solver::model::Model;
use std::path::PathBuf;

/// A problem that can be run: everything the deck and the mesh say, checked.
#[derive(Debug)]
pub struct Problem {
    /// The deck's title.
    pub title: String,
    /// The deck's file.
    pub deck_path: PathBuf,
    /// SHA-256 of the deck's text, and of the files that it names and the overrides of the command line if there are any.
    pub deck_hash: String,
    /// The mesh's file.
    pub mesh_path: PathBuf,
    /// The format of the mesh's file.
    pub mesh_format: String,
    /// The mesh, in m, in an order that is good for the machine; labels are those of the file.
    pub mesh: Mesh,
    /// Quality of the mesh.
    pub quality: QualitySummary,
    /// What `[mesh] merge` did, in words.
    pub merged: Option<String>,
    /// How its elements hang together.
    pub connectivity: Connectivity,
    /// What the solver is given.
    pub model: Model,
    /// What was chosen for a quasi-static process.
    pub quasi_static: Option<QuasiStatic>,
    /// Displacements that the deck prescribes, of nodes and of tools.
    pub driven: Vec<Driven>,
    /// What each part is called and made of.
    pub parts: Vec<PartDescription>,
    /// What the rigid walls are called.
    pub wall_names: Vec<String>,
    /// What is followed.
    pub probes: Vec<Probe>,
    /// What the probes must give.
    pub expectations: Vec<Expectation>,
    /// What is written.
    pub output: OutputPlan,
    /// Findings that do not stop the run.
    pub findings: Findings,
}

/// A part in words.
#[derive(Debug)]
pub struct PartDescription {
    /// Its group.
    pub group: String,
    /// Its material.
    pub material: String,
    /// Number of its elements.
    pub element_count: usize,
    /// Its mass, kg.
    pub mass: f64,
}
