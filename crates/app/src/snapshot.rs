//! The state of a simulation at one step, as probes and frames see it.

use crate::fields::{Component, ProbeField};
use estar_mesh::Mesh;
use estar_solver::model::Direction;
use estar_solver::{HexFields, Simulation};
use std::cell::OnceCell;

/// A look at a simulation; what costs a sweep over the mesh is computed when first asked for.
pub struct Snapshot<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// The simulation.
    pub simulation: &'a Simulation,
    hex_fields: OnceCell<HexFields>,
    velocity: OnceCell<Vec<[f64; 3]>>,
}

impl<'a> Snapshot<'a> {
    /// The present state.
    pub fn new(mesh: &'a Mesh, simulation: &'a Simulation) -> Self {
        Self { mesh, simulation, hex_fields: OnceCell::new(), velocity: OnceCell::new() }
    }

    /// Fields of hexes.
    pub fn hex_fields(&self) -> &HexFields {
        self.hex_fields.get_or_init(|| self.simulation.hex_fields())
    }

    /// Velocity of every node, m/s.
    pub fn velocity(&self) -> &[[f64; 3]] {
        self.velocity.get_or_init(|| self.simulation.velocity())
    }

    /// Current position of a node.
    pub fn position(&self, node: u32) -> [f64; 3] {
        let (start, moved) = (self.mesh.coordinates()[node as usize], self.simulation.displacement()[node as usize]);
        std::array::from_fn(|axis| start[axis] + moved[axis])
    }

    /// A field at a node or in a hex.
    pub fn value(&self, field: ProbeField, component: Option<Component>, index: u32) -> f64 {
        let at = index as usize;
        let component = component.unwrap_or(Component::Magnitude);
        match field {
            ProbeField::Position => component.of_vector(&self.position(index)),
            ProbeField::Displacement => component.of_vector(&self.simulation.displacement()[at]),
            ProbeField::Velocity => component.of_vector(&self.velocity()[at]),
            ProbeField::CauchyStress => component.of_tensor(&self.hex_fields().cauchy_stress[at]),
            ProbeField::EquivalentPlasticStrain => self.hex_fields().equivalent_plastic_strain[at],
            ProbeField::VonMisesStress => self.hex_fields().von_mises_stress[at],
            ProbeField::Pressure => self.hex_fields().pressure[at],
            ProbeField::VolumeRatio => self.hex_fields().volume_ratio[at],
        }
    }

    /// Force with which constraints hold nodes in a direction.
    pub fn reaction(&self, nodes: &[u32], direction: Direction) -> f64 {
        self.simulation.reaction(nodes, direction)
    }
}
