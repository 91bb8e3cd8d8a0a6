//! Mass scaling: elements made heavier so that the run takes longer steps.
//!
//! The stable step of an element goes with the square root of its mass. A factor on every mass (density scaling) makes a slow
//! process quick to compute; a target makes heavier only those few elements that would hold the step down. The mass stays as
//! it is made at time 0, so that momentum and energy keep their balance; when elements shrink the step shrinks with them.
//! Added mass has inertia but no weight. The ledger shows the kinetic energy of it.

use crate::error::ModelError;
use crate::model::{Formulation, MassScaling};
use crate::simulation::{Simulation, corner_masses_of};

/// An element that a target makes heavier.
struct Light {
    /// Its number in the block.
    element: usize,
    /// Its mass, kg.
    mass: f64,
    /// The time step that it allows, s.
    time_step: f64,
}

impl Light {
    /// Factor on its mass for a time step: Δt ∝ √m.
    fn factor(&self, target: f64) -> f64 {
        (target / self.time_step).powi(2).max(1.0)
    }
}

/// Passes over the elements until the target is met. One does, but where a damping that mass changes shortens the steps of
/// elements by shares of their own.
const MOST_PASSES: usize = 16;

impl Simulation {
    /// Makes elements heavier until the run begins with the target step.
    pub(crate) fn scale_mass(
        &mut self,
        scaling: &MassScaling,
        makes: &[(Formulation, f64)],
        masses: &[f64],
    ) -> Result<(), ModelError> {
        let mut by_target = vec![0.0; masses.len()];
        for _ in 0..MOST_PASSES {
            self.scale_to_target(scaling, makes, masses, &mut by_target)?;
            self.update_elements(0.0);
            let time_step = self.settings.safety_factor * self.elements.stable_time_step.value;
            if time_step >= scaling.target_time_step * (1.0 - 1e-9) {
                break;
            }
        }
        for (added, by_target) in self.added_mass.iter_mut().zip(by_target) {
            *added += by_target;
        }
        Ok(())
    }

    /// Makes the elements heavier that do not allow the target step. `makes` are elements and density of the parts, with the factor of
    /// the scaling in it; `masses` are their own, and `added` takes what the target adds to each.
    fn scale_to_target(
        &mut self,
        scaling: &MassScaling,
        makes: &[(Formulation, f64)],
        masses: &[f64],
        added: &mut [f64],
    ) -> Result<(), ModelError> {
        let target = scaling.target_time_step;
        let undamped = self.stable_time_steps().into_iter().fold(f64::INFINITY, f64::min);
        // safety factor, and what bulk viscosity takes of the step, the same share of every element at rest
        let share = self.settings.safety_factor * self.elements.stable_time_step.value / undamped;
        for (part, block) in self.blocks.iter_mut().enumerate() {
            let mut light = Vec::new();
            let (formulation, density) = makes[part];
            for (element, &member) in block.elements.members().iter().enumerate() {
                let time_step = share * block.elements.stable_time_step(element);
                if time_step < target {
                    let corners = corner_masses_of(formulation, member, &self.mesh, density)?;
                    let mass = corners.iter().map(|(_, mass)| mass).sum();
                    light.push(Light { element, mass, time_step });
                }
            }
            if light.is_empty() {
                continue;
            }
            let addition =
                |target: f64| light.iter().map(|light| light.mass * (light.factor(target) - 1.0)).sum::<f64>();
            let (of_target, allowed) = (addition(target), scaling.limit * masses[part] - added[part]);
            if of_target > allowed {
                let attainable = largest_within(allowed, target, addition);
                return Err(ModelError::AddedMass {
                    part,
                    share: (added[part] + of_target) / masses[part],
                    limit: scaling.limit,
                    count: light.len(),
                    attainable,
                });
            }
            added[part] += of_target;
            for light in light {
                let (factor, member) = (light.factor(target), block.elements.members()[light.element]);
                for (node, corner_mass) in corner_masses_of(formulation, member, &self.mesh, density)? {
                    self.nodes.mass[node as usize] += (factor - 1.0) * corner_mass;
                }
                block.elements.scale_mass(light.element, factor);
            }
        }
        Ok(())
    }

    /// Mass that mass scaling has added to each part, kg.
    pub fn added_mass(&self) -> &[f64] {
        &self.added_mass
    }
}

/// The largest target, to a part in 10⁴ and rounded down, whose addition is allowed: the addition grows with the target.
fn largest_within(allowed: f64, target: f64, addition: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, target);
    while high - low > 1e-4 * high {
        let middle = 0.5 * (low + high);
        if addition(middle) > allowed { high = middle } else { low = middle }
    }
    low
}
