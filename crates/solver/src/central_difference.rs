//! The time loop: explicit central differences with half-step velocities and a variable step.

use crate::constraints::{Constraints, dot};
use crate::error::SimulationError;
use crate::rigid_wall::{MovingWall, NodeStep};
use crate::simulation::Simulation;
use crate::solid_block::{BlockReport, NodalMotion, StepLimits};
use estar_element::element::ElementStep;
use rayon::prelude::*;

/// Nodes that one thread takes at a time; sums over nodes are formed within such a chunk first.
pub(crate) const CHUNK: usize = 1024;

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
        self.elements = BlockReport::EMPTY;
        let mut patch_forces = self.patch_forces.as_mut_slice();
        for block in &mut self.blocks {
            let (own, rest) = patch_forces.split_at_mut(block.elements.patches().row_count());
            patch_forces = rest;
            let report = block.elements.advance(motion, &step, &limits, own);
            block.min_jacobian = report.min_jacobian;
            block.internal_energy += report.internal_energy;
            block.hourglass_energy += report.hourglass_energy;
            self.energies.heat += report.plastic_dissipation * block.elements.heat_share().unwrap_or(0.0);
            self.elements = self.elements.followed_by(&report);
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
        self.constraints.prepare(self.time + step_new);
        for wall in &mut self.walls {
            wall.prepare(self.time, step_old, step_new);
        }
        for (load, power) in self.loads.iter().zip(&mut self.load_power) {
            *power = load.power(&self.nodes.velocity);
        }

        let nodes = &mut self.nodes;
        // where t_n lies between the half steps
        let share_old = 0.5 * step_old / mean_step;
        // ½ α Δt̄ of the damping −α m ½ (v_{n−½} + v_{n+½})
        let damping = 0.5 * self.settings.mass_damping * mean_step;
        let kick = Kick { mean_step, step_new, damping, constraints: &self.constraints, walls: &self.walls };
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
                let moved = kick.moved(&place, mass[node], force, velocity_old, wall_impulses);
                let mut kinetic = sums.enter(mass[node], &velocity_old, &moved.velocity, share_old);
                if damping > 0.0 {
                    let impulse = moved.damping.map(|change| mass[node] * change);
                    sums.enter_damping(&impulse, &velocity_old, &moved.velocity, share_old);
                }
                if let Some(impulses) = &moved.impulses {
                    kinetic += sums.enter_impulses(impulses, &velocity_old, &moved.velocity, share_old);
                    if self.constraints.constrain(node) {
                        reaction[local] = impulses.of_constraints.map(|impulse| impulse * per_mean_step);
                    }
                }
                if let Some(share) = added_shares.get(node) {
                    sums.added_kinetic += share * kinetic;
                }
                acceleration[local] = std::array::from_fn(|i| (moved.velocity[i] - velocity_old[i]) * per_mean_step);
                velocity[local] = moved.velocity;
            }
        });
        let sums = self.node_sums.iter().fold(NodeSums::default(), NodeSums::plus);

        // works of the forces of t_n: half over the step before, half over the step after
        for (load, power_old) in self.loads.iter_mut().zip(&self.load_power) {
            let power_new = load.power(&self.nodes.velocity);
            load.work.enter(0.5 * step_old * power_old, 0.5 * step_new * power_new);
        }
        self.constraint_work.enter(sums.constraint_work_before, sums.constraint_work_after);
        self.contact_work.enter(sums.contact_work_before, sums.contact_work_after);
        self.friction_work.enter(sums.friction_work_before, sums.friction_work_after);
        self.damping_work.enter(sums.damping_work_before, sums.damping_work_after);
        let wall_count = self.walls.len();
        for (index, wall) in self.walls.iter_mut().enumerate() {
            let of_chunks = self.wall_impulses.iter().skip(index).step_by(wall_count);
            let impulse = of_chunks.fold([0.0; 3], |sum, impulse| std::array::from_fn(|i| sum[i] + impulse[i]));
            wall.enter(&impulse, mean_step);
        }
        self.energies.kinetic = sums.kinetic;
        self.energies.mass_scaling = sums.added_kinetic;
        self.step_change.enter(0.0, sums.step_change);
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
        let time_step = self.next_time_step;
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

/// What a kick needs besides the node itself.
struct Kick<'a> {
    mean_step: f64,
    step_new: f64,
    damping: f64,
    constraints: &'a Constraints,
    walls: &'a [MovingWall],
}

/// A node and where it is.
struct Place<'a> {
    node: usize,
    reference: &'a [f64; 3],
    displacement: &'a [f64; 3],
}

/// What a kick does to a node.
struct Moved {
    /// v_{n+½}.
    velocity: [f64; 3],
    /// Change of velocity by damping, m/s.
    damping: [f64; 3],
    /// None at a node that neither a constraint nor a wall holds.
    impulses: Option<Impulses>,
}

/// Impulses on a node that is not free, N s.
struct Impulses {
    /// Of held and driven directions.
    of_constraints: [f64; 3],
    of_walls: [f64; 3],
    /// Work of the friction of walls on the sliding of the node, half of it before t_n and half after, J.
    friction_work: [f64; 2],
}

impl Kick<'_> {
    /// The impulses of walls are added to `wall_impulses`.
    #[inline]
    fn moved(
        &self,
        place: &Place<'_>,
        mass: f64,
        force: [f64; 3],
        velocity_old: [f64; 3],
        wall_impulses: &mut [[f64; 3]],
    ) -> Moved {
        // v_{n+½} = v_{n−½} + ½ (Δt_{n−½} + Δt_{n+½}) f_n / m
        let scale = self.mean_step / mass;
        let undamped: [f64; 3] = std::array::from_fn(|i| velocity_old[i] + scale * force[i]);
        // with f_n − α m ½ (v_{n−½} + v_{n+½}) in place of f_n
        let damping = if self.damping > 0.0 {
            let share = self.damping / (1.0 + self.damping);
            std::array::from_fn(|i| -share * (velocity_old[i] + undamped[i]))
        } else {
            [0.0; 3]
        };
        let free = std::array::from_fn(|i| undamped[i] + damping[i]);
        let is_held = self.constraints.constrain(place.node);
        let position: [f64; 3] = std::array::from_fn(|i| place.reference[i] + place.displacement[i]);
        if !is_held && !self.walls.iter().any(|wall| wall.stops(&free, &position, self.step_new)) {
            return Moved { velocity: free, damping, impulses: None };
        }
        let constrained = |v| self.constraints.velocity(place.node, v, place.displacement, self.step_new);
        let mut velocity = constrained(free);
        let (mut of_walls, mut friction, mut friction_work) = ([0.0; 3], [0.0; 3], [0.0; 2]);
        let step = NodeStep { position, time_step: self.step_new, free: self.constraints.free_directions(place.node) };
        for (wall, wall_impulse) in self.walls.iter().zip(wall_impulses) {
            let contact = wall.contact(&velocity, &step);
            let impulse = contact.change.map(|change| mass * change);
            let of_friction = contact.friction.map(|change| mass * change);
            let carried = wall.work_of(&of_friction);
            for i in 0..3 {
                wall_impulse[i] += impulse[i];
                of_walls[i] += impulse[i];
                friction[i] += of_friction[i];
                velocity[i] += contact.change[i];
            }
            friction_work = [friction_work[0] - carried[0], friction_work[1] - carried[1]];
            velocity = constrained(velocity);
        }
        friction_work[0] += 0.5 * dot(&friction, &velocity_old);
        friction_work[1] += 0.5 * dot(&friction, &velocity);
        // what the walls did not do the constraints did
        let of_constraints = std::array::from_fn(|i| mass * (velocity[i] - free[i]) - of_walls[i]);
        Moved { velocity, damping, impulses: Some(Impulses { of_constraints, of_walls, friction_work }) }
    }
}

/// Sums over the nodes of a chunk.
#[derive(Clone, Copy, Default)]
pub(crate) struct NodeSums {
    kinetic: f64,
    step_change: f64,
    constraint_work_before: f64,
    constraint_work_after: f64,
    contact_work_before: f64,
    contact_work_after: f64,
    friction_work_before: f64,
    friction_work_after: f64,
    damping_work_before: f64,
    damping_work_after: f64,
    added_kinetic: f64,
}

impl NodeSums {
    /// Chunks of a body with `node_count` nodes.
    pub fn chunk_count(node_count: usize) -> usize {
        node_count.div_ceil(CHUNK)
    }

    /// A node whose velocity only forces change; its kinetic energy.
    #[inline]
    fn enter(&mut self, mass: f64, old: &[f64; 3], new: &[f64; 3], share_old: f64) -> f64 {
        let change: [f64; 3] = std::array::from_fn(|i| new[i] - old[i]);
        let (old_old, old_change) = (dot(old, old), dot(old, &change));
        // K_n = Σ ½ m |v_{n−½}|² + ½ Δt_{n−½} f_n · v_{n−½} with Δt f_n = m (v_{n+½} − v_{n−½})
        let kinetic = mass * (0.5 * old_old + share_old * old_change);
        self.kinetic += kinetic;
        self.step_change += mass * ((0.5 - share_old) * dot(&change, &change));
        kinetic
    }

    /// What impulses on the node change of that, and their work; the change of its kinetic energy.
    #[inline]
    fn enter_impulses(&mut self, impulses: &Impulses, old: &[f64; 3], new: &[f64; 3], share_old: f64) -> f64 {
        let Impulses { of_constraints, of_walls, friction_work } = impulses;
        let impulse: [f64; 3] = std::array::from_fn(|i| of_constraints[i] + of_walls[i]);
        let change: [f64; 3] = std::array::from_fn(|i| new[i] - old[i]);
        // an impulse is no force: half of its work is in K_n, and none of it in what a change of step does
        let kinetic = (0.5 - share_old) * dot(&impulse, old);
        self.kinetic += kinetic;
        self.step_change -= (0.5 - share_old) * dot(&impulse, &change);
        // an impulse does the work I · ½ (v_{n−½} + v_{n+½})
        self.constraint_work_before += 0.5 * dot(of_constraints, old);
        self.constraint_work_after += 0.5 * dot(of_constraints, new);
        self.contact_work_before += 0.5 * dot(of_walls, old);
        self.contact_work_after += 0.5 * dot(of_walls, new);
        self.friction_work_before += friction_work[0];
        self.friction_work_after += friction_work[1];
        kinetic
    }

    /// Work of the damping, whose force is the impulse over the mean step.
    #[inline]
    fn enter_damping(&mut self, impulse: &[f64; 3], old: &[f64; 3], new: &[f64; 3], share_old: f64) {
        self.damping_work_before += share_old * dot(impulse, old);
        self.damping_work_after += (1.0 - share_old) * dot(impulse, new);
    }

    fn plus(self, other: &Self) -> Self {
        Self {
            kinetic: self.kinetic + other.kinetic,
            step_change: self.step_change + other.step_change,
            constraint_work_before: self.constraint_work_before + other.constraint_work_before,
            constraint_work_after: self.constraint_work_after + other.constraint_work_after,
            contact_work_before: self.contact_work_before + other.contact_work_before,
            contact_work_after: self.contact_work_after + other.contact_work_after,
            friction_work_before: self.friction_work_before + other.friction_work_before,
            friction_work_after: self.friction_work_after + other.friction_work_after,
            damping_work_before: self.damping_work_before + other.damping_work_before,
            damping_work_after: self.damping_work_after + other.damping_work_after,
            added_kinetic: self.added_kinetic + other.added_kinetic,
        }
    }
}
