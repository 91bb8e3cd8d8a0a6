//! The state of a simulation at one step, as probes and frames see it.

use estar_deck::fields::{Component, ProbeField};
use estar_mesh::Mesh;
use estar_solver::Simulation;
use estar_solver::fields::{ElementMeans, pressure, volume_ratio, von_mises_stress};
use estar_solver::model::Direction;
use std::cell::OnceCell;

/// A look at a simulation; what costs a sweep over the mesh is computed when first asked for.
pub struct Snapshot<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// The simulation.
    pub simulation: &'a Simulation,
    cauchy_stress: OnceCell<Vec<[f64; 6]>>,
    equivalent_plastic_strain: OnceCell<Vec<f64>>,
    temperature: OnceCell<Vec<f64>>,
    volume_ratio: OnceCell<Vec<f64>>,
}

impl<'a> Snapshot<'a> {
    /// The present state.
    pub fn new(mesh: &'a Mesh, simulation: &'a Simulation) -> Self {
        Self {
            mesh,
            simulation,
            cauchy_stress: OnceCell::new(),
            equivalent_plastic_strain: OnceCell::new(),
            temperature: OnceCell::new(),
            volume_ratio: OnceCell::new(),
        }
    }

    /// Cauchy stress of every hex, Pa.
    fn cauchy_stress(&self) -> &[[f64; 6]] {
        self.cauchy_stress.get_or_init(|| {
            let mut field = vec![[0.0; 6]; self.mesh.element_count()];
            self.simulation.write_means(ElementMeans { cauchy_stress: Some(&mut field), ..ElementMeans::default() });
            field
        })
    }

    /// Equivalent plastic strain of every hex.
    fn equivalent_plastic_strain(&self) -> &[f64] {
        self.equivalent_plastic_strain.get_or_init(|| {
            let mut field = vec![0.0; self.mesh.element_count()];
            self.simulation
                .write_means(ElementMeans { equivalent_plastic_strain: Some(&mut field), ..ElementMeans::default() });
            field
        })
    }

    /// Temperature of every hex, K.
    fn temperature(&self) -> &[f64] {
        self.temperature.get_or_init(|| {
            let mut field = vec![0.0; self.mesh.element_count()];
            self.simulation.write_means(ElementMeans { temperature: Some(&mut field), ..ElementMeans::default() });
            field
        })
    }

    /// Volume ratio of every element.
    fn volume_ratio(&self) -> &[f64] {
        self.volume_ratio.get_or_init(|| {
            let mut field = vec![0.0; self.mesh.element_count()];
            self.simulation.write_volume_ratio(&mut field);
            field
        })
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
            ProbeField::Velocity => component.of_vector(&self.simulation.velocity(at)),
            ProbeField::CauchyStress => component.of_tensor(&self.cauchy_stress()[at]),
            ProbeField::EquivalentPlasticStrain => self.equivalent_plastic_strain()[at],
            ProbeField::Temperature => self.temperature()[at],
            ProbeField::VonMisesStress => von_mises_stress(&self.cauchy_stress()[at]),
            ProbeField::Pressure => pressure(&self.cauchy_stress()[at]),
            ProbeField::VolumeRatio if self.simulation.shares_volume() => self.volume_ratio()[at],
            ProbeField::VolumeRatio => {
                volume_ratio(self.mesh.elements(), at, self.mesh.coordinates(), self.simulation.displacement())
            }
        }
    }

    /// Force with which constraints hold nodes in a direction.
    pub fn reaction(&self, nodes: &[u32], direction: Direction) -> f64 {
        self.simulation.reaction(nodes, direction)
    }
}
