//! The time loop: explicit central differences with half-step velocities and a variable step.

use crate::assembly::CHUNK;
use crate::block::{BlockReport, StepLimits};
use crate::energy::Passage;
use crate::error::SimulationError;
use crate::kick::{Kick, NodeSums, Place};
use crate::patch_rows::NodalMotion;
use crate::simulation::Simulation;
use crate::sums::up_the_tree;
use crate::wall_contact::Behind;
use estar_element::element::ElementStep;
use rayon::prelude::*;

/// Share of the time from which kinetic energy is judged: at the beginning of a process that is driven all
/// energy is kinetic.
const JUDGED_FROM: f64 = 0.1;

impl Simulation {
    /// Moves the body from t_n to t_{n+1}.
    ///
    /// # Errors
    /// An inverted element, a value that is not finite, or a limit of the settings that is passed. The state is that of
    /// t_{n+1} then, so that it can be looked at; after an inversion it cannot be advanced further with sense.
    pub fn advance(&mut self) -> Result<(), SimulationError> {
        // Λ, if it is time
        self.renew_global_time_step();
        let time_step = self.next_time_step;

        // u_{n+1} = u_n + Δt_{n+½} v_{n+½}
        self.drift(time_step);
        self.step += 1;
        self.time_step = time_step;
        self.time = if self.step_is_last { self.settings.end } else { self.time + time_step };

        // f_int(u_{n+1}), internal energy, Δt_{n+3/2}
        self.update_elements(time_step);
        self.choose_next_time_step();

        // f_ext(t_{n+1})
        self.update_loads();

        // a_{n+1} = M⁻¹ (f_ext − f_int), v_{n+3/2} = v_{n+½} + ½ (Δt_{n+½} + Δt_{n+3/2}) a_{n+1}
        self.kick();
        self.check()
    }

    /// u ← u + Δt v.
    fn drift(&mut self, time_step: f64) {
        let displacement = self.nodes.displacement.par_chunks_mut(CHUNK);
        displacement.zip(self.nodes.velocity.par_chunks(CHUNK)).for_each(|(displacement, velocity)| {
            for (displacement, velocity) in displacement.iter_mut().zip(velocity) {
                for (u, v) in displacement.iter_mut().zip(velocity) {
                    *u += time_step * v;
                }
            }
        });
    }

    /// Forces of the elements, energies of the step, smallest Jacobian and stable time step on the current displacement.
    pub(crate) fn update_elements(&mut self, time_step: f64) {
        let nodes = &self.nodes;
        let motion = NodalMotion {
            reference: self.mesh.coordinates(),
            displacement: &nodes.displacement,
            velocity: &nodes.velocity,
        };
        let step = ElementStep { bulk_viscosity: self.settings.bulk_viscosity, time_step };
        let limits = StepLimits {
            least_stable_time_step: self.least_stable_time_step,
            eigenvalue: self.global_time_step.as_ref().map_or(0.0, |global| global.eigenvalue),
        };
        for averages in &mut self.averages {
            averages.share_volumes(&mut self.blocks, motion, time_step);
        }
        self.elements = BlockReport::EMPTY;
        let mut patch_forces = self.patch_forces.as_mut_slice();
        for block in &mut self.blocks {
            let (own, rest) = patch_forces.split_at_mut(block.elements.patches().row_count());
            patch_forces = rest;
            let report = block.elements.advance(motion, &step, &limits, own);
            block.min_jacobian = report.min_jacobian;
            block.internal_energy += report.internal_energy;
            block.hourglass_energy += report.hourglass_energy;
            block.deleted_count += u64::from(report.deleted_count);
            self.energies.heat += report.plastic_dissipation * block.elements.heat_share().unwrap_or(0.0);
            self.elements = self.elements.followed_by(report);
        }
        for averages in &mut self.averages {
            averages.add_mean_stress_forces(&mut self.blocks, motion, &mut self.patch_forces);
        }
        self.energies.internal += self.elements.internal_energy - self.elements.deleted_energy;
        self.energies.deleted += self.elements.deleted_energy;
        self.deleted_count += u64::from(self.elements.deleted_count);
        self.energies.plastic_dissipation += self.elements.plastic_dissipation;
        self.energies.viscous += self.elements.viscous_energy;
        self.energies.hourglass += self.elements.hourglass_energy;
        if let Some(global) = &mut self.global_time_step {
            (global.growth, global.decline) = (self.elements.growth, self.elements.decline);
        }
    }

    /// Δt = safety × stable step; the last step ends at the end, and the one before is as long.
    pub(crate) fn choose_next_time_step(&mut self) {
        // without any element left nothing else limits it
        let stable = (self.settings.safety_factor * self.stable_time_step()).min(self.settings.end);
        let remaining = self.settings.end - self.time;
        self.step_is_last = remaining <= stable;
        self.next_time_step = if remaining <= 0.0 {
            stable
        } else if self.step_is_last {
            remaining
        } else if remaining < 2.0 * stable {
            0.5 * remaining
        } else {
            stable
        };
    }

    /// Forces of the loads at the current time and place.
    pub(crate) fn update_loads(&mut self) {
        if self.loads.is_empty() {
            return;
        }
        self.external_force.fill([0.0; 3]);
        for load in &mut self.loads {
            load.apply(self.time, self.mesh.coordinates(), &self.nodes.displacement, &mut self.external_force);
        }
    }

    /// Accelerations at t_n from the forces there, velocities at the next half step, and the energies of t_n.
    pub(crate) fn kick(&mut self) {
        // at the start there is no step before: Δt_{−½} = 0
        let (step_old, step_new) = (self.time_step, self.next_time_step);
        let mean_step = 0.5 * (step_old + step_new);
        // where t_n lies between the half steps
        let share_old = 0.5 * step_old / mean_step;
        self.constraints.prepare(self.time + step_new);
        for wall in &mut self.walls {
            wall.prepare(self.time, [step_old, step_new], share_old);
        }
        for (load, power) in self.loads.iter().zip(&mut self.load_power) {
            *power = load.power(&self.nodes.velocity);
        }

        let nodes = &mut self.nodes;
        let kick = Kick {
            mean_step,
            step_new,
            share_old,
            damping: 0.5 * self.settings.mass_damping * mean_step,
            constraints: &self.constraints,
            walls: &self.walls,
        };
        let added_shares = &self.added_shares;
        let (row_lists, patch_forces) = (&self.row_lists, &self.patch_forces);
        let (reference, displacement, mass) = (self.mesh.coordinates(), &nodes.displacement, &nodes.mass);
        let external_force = &self.external_force;
        let chunks = nodes
            .velocity
            .par_chunks_mut(CHUNK)
            .zip(nodes.acceleration.par_chunks_mut(CHUNK))
            .zip(nodes.reaction.par_chunks_mut(CHUNK))
            .zip(self.node_sums.par_iter_mut())
            .zip(self.wall_impulses.par_chunks_mut(self.walls.len().max(1)))
            .enumerate();
        let per_mean_step = mean_step.recip();
        chunks.for_each(|(chunk, ((((velocity, acceleration), reaction), sums), wall_impulses))| {
            *sums = NodeSums::default();
            wall_impulses.fill([0.0; 3]);
            for local in 0..velocity.len() {
                let node = chunk * CHUNK + local;
                let mut force = row_lists.sum(patch_forces, node);
                if let Some(external) = external_force.get(node) {
                    force = std::array::from_fn(|i| force[i] + external[i]);
                }
                let velocity_old = velocity[local];
                let place = Place { node, reference: &reference[node], displacement: &displacement[node] };
                let moved = kick.moved(&place, mass[node], &force, &velocity_old, wall_impulses);
                let passage = Passage::new(&velocity_old, &moved.velocity, share_old);
                let kinetic = sums.enter(mass[node], &force.map(|force| mean_step * force), &passage);
                if let Some(share) = added_shares.get(node) {
                    sums.added_kinetic += share * kinetic;
                }
                if kick.damping > 0.0 {
                    let impulse = kick.damping_impulse(mass[node], &velocity_old, &moved.velocity);
                    sums.enter_damping(&impulse, &passage);
                }
                if let Some(impulses) = &moved.impulses {
                    sums.enter_impulses(node, impulses, &passage);
                    if self.constraints.constrain(node) {
                        reaction[local] = impulses.of_constraints.map(|impulse| impulse * per_mean_step);
                    }
                }
                acceleration[local] = passage.change.map(|change| change * per_mean_step);
                velocity[local] = moved.velocity;
            }
        });
        let of_chunk = |chunk: usize| self.node_sums[chunk];
        let sums = up_the_tree(self.node_sums.len(), NodeSums::default(), &of_chunk, &NodeSums::plus);
        self.behind = sums.behind;

        // works of the forces of t_n: half over the step before, half over the step after
        for (load, power_old) in self.loads.iter_mut().zip(&self.load_power) {
            let power_new = load.power(&self.nodes.velocity);
            load.work.enter([0.5 * step_old * power_old, 0.5 * step_new * power_new]);
        }
        self.constraint_work.enter(sums.constraint_work);
        self.contact_work.enter(sums.contact_work);
        self.friction_work.enter(sums.friction_work);
        self.damping_work.enter(sums.damping_work);
        let wall_count = self.walls.len();
        for (index, wall) in self.walls.iter_mut().enumerate() {
            let of_chunk = |chunk: usize| self.wall_impulses[chunk * wall_count + index];
            let plus = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|i| a[i] + b[i]);
            let impulse = up_the_tree(self.node_sums.len(), [0.0; 3], &of_chunk, &plus);
            wall.enter(&impulse, mean_step);
        }
        self.energies.kinetic = sums.kinetic;
        self.energies.mass_scaling = sums.added_kinetic;
        self.integration.enter(sums.integration);
        self.enter_works();
        let is_judged = self.is_judged();
        self.energies.note_in_play(is_judged);
    }

    /// Whether the kinetic energy of the present can be held against the process.
    fn is_judged(&self) -> bool {
        self.time >= JUDGED_FROM * self.settings.end
    }

    fn check(&self) -> Result<(), SimulationError> {
        let (step, time) = (self.step, self.time);
        let elements = &self.elements;
        if elements.min_jacobian.value <= 0.0 {
            let (element, jacobian) = (elements.min_jacobian.element, elements.min_jacobian.value);
            return Err(SimulationError::ElementInverted { element, jacobian, step, time });
        }
        if let Some(element) = elements.not_finite {
            return Err(SimulationError::NotFinite { element, step, time });
        }
        if let Some((Behind { wall, depth }, node)) = self.behind
            && depth > self.wall_tolerance
        {
            return Err(SimulationError::HeldBehindWall { wall, node: node as u32, depth, step, time });
        }
        let time_step = self.next_time_step;
        if let Some(wall) = self.walls.iter().position(|wall| wall.outruns_itself(time_step)) {
            return Err(SimulationError::ToolTooFast { wall, time_step, step, time });
        }
        if time + time_step <= time {
            let element = elements.stable_time_step.element;
            return Err(SimulationError::Standstill { element, time_step, step, time });
        }
        let stable = self.stable_time_step();
        if stable < self.least_stable_time_step && !self.is_finished() {
            let factor = self.settings.safety_factor;
            let (element, time_step) = (elements.stable_time_step.element, factor * stable);
            let limit = factor * self.least_stable_time_step;
            return Err(SimulationError::TimeStepTooSmall { element, time_step, limit, step, time });
        }
        let (error, limit) = (self.energies.error(), self.settings.energy_error_limit);
        // an error that is not a number is not within the limit
        let within = error.abs() <= limit;
        if !within {
            return Err(SimulationError::EnergyError { error, limit, step, time });
        }
        if let Some(scaling) = &self.settings.mass_scaling
            && self.is_judged()
        {
            let share = self.energies.mass_scaling / self.energies.in_play;
            if share > scaling.kinetic_limit {
                return Err(SimulationError::AddedKineticEnergy { share, limit: scaling.kinetic_limit, step, time });
            }
        }
        if self.settings.max_steps.is_some_and(|limit| step >= limit) && !self.is_finished() {
            return Err(SimulationError::StepLimit { step, time });
        }
        Ok(())
    }
}
