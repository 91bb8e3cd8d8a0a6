//! The state of a simulation as numbers in one fixed order: for hashes, and for checkpoints from which it goes on with the
//! same bits. What follows from the model and the mesh is no part of it.

use crate::block::Extreme;
use crate::energy::CentredWork;
use crate::simulation::Simulation;
use thiserror::Error;

/// Numbers that are those of no state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("its numbers are those of no state of this run")]
pub struct NoState;

/// Version of what [`Simulation::for_each_number`] visits and of its order; it grows with each change of that.
pub const STATE_LAYOUT: u32 = 2;

/// Numbers of the state that stand alone.
const SCALARS: usize = 20;

impl Simulation {
    /// Calls `visit` with every number of the state, in an order that depends neither on threads nor on lanes.
    pub fn for_each_number(&self, mut visit: impl FnMut(f64)) {
        self.scalars().into_iter().for_each(&mut visit);
        for work in self.works() {
            visit(work.until_now);
            visit(work.begun);
        }
        if let Some(global) = &self.global_time_step {
            [global.eigenvalue, global.step as f64, global.growth, global.decline, global.count as f64]
                .into_iter()
                .for_each(&mut visit);
        }
        let nodes = &self.nodes;
        for field in [&nodes.displacement, &nodes.velocity, &nodes.acceleration, &nodes.reaction] {
            field.iter().flatten().for_each(|&number| visit(number));
        }
        self.walls.iter().flat_map(|wall| wall.force).for_each(&mut visit);
        for block in &self.blocks {
            visit(block.internal_energy);
            visit(block.hourglass_energy);
            block.elements.for_each_number(&mut visit);
        }
    }

    /// Takes the state whose numbers `next` gives in the order of [`Simulation::for_each_number`]: that of a simulation of
    /// the same model on the same mesh.
    ///
    /// # Errors
    /// The numbers are none of such a state; then the simulation is of no use any more.
    pub fn restore(&mut self, mut next: impl FnMut() -> f64) -> Result<(), NoState> {
        let scalars: [f64; SCALARS] = std::array::from_fn(|_| next());
        self.set_scalars(scalars);
        for work in self.works_mut() {
            *work = CentredWork { until_now: next(), begun: next() };
        }
        if let Some(global) = &mut self.global_time_step {
            global.eigenvalue = next();
            global.step = next() as u64;
            global.growth = next();
            global.decline = next();
            global.count = next() as u64;
        }
        let nodes = &mut self.nodes;
        for field in [&mut nodes.displacement, &mut nodes.velocity, &mut nodes.acceleration, &mut nodes.reaction] {
            field.iter_mut().flatten().for_each(|number| *number = next());
        }
        self.walls.iter_mut().flat_map(|wall| &mut wall.force).for_each(|number| *number = next());
        for block in &mut self.blocks {
            block.internal_energy = next();
            block.hourglass_energy = next();
            block.elements.restore(&mut next);
            let elements = &block.elements;
            let is_deleted = |place: &usize| elements.is_deleted(*place);
            block.deleted_count = (0..elements.members().len()).filter(is_deleted).count() as u64;
        }
        // at time 0 the works have begun, and the ledger has not seen them yet
        if self.step > 0 {
            self.enter_works();
        }
        let counts = self.mesh.element_count() as u32;
        let extremes = [self.elements.min_jacobian, self.elements.stable_time_step];
        let times = [self.time, self.time_step, self.next_time_step];
        let is_state = scalars[0] == self.step as f64
            && self.global_time_step.as_ref().is_none_or(|global| global.step <= self.step)
            && times.iter().all(|time| time.is_finite() && *time >= 0.0)
            && extremes.iter().all(|extreme| extreme.element < counts);
        if is_state { Ok(()) } else { Err(NoState) }
    }

    fn scalars(&self) -> [f64; SCALARS] {
        let (energies, elements) = (&self.energies, &self.elements);
        [
            // counts and indices are far below the 2⁵³ up to which a number holds them exactly
            self.step as f64,
            self.time,
            self.time_step,
            self.next_time_step,
            f64::from(u8::from(self.step_is_last)),
            energies.kinetic,
            energies.internal,
            energies.plastic_dissipation,
            energies.heat,
            energies.viscous,
            energies.in_play,
            elements.min_jacobian.value,
            f64::from(elements.min_jacobian.element),
            elements.stable_time_step.value,
            f64::from(elements.stable_time_step.element),
            energies.deleted,
            self.deleted_count as f64,
            energies.hourglass,
            energies.mass_scaling,
            energies.kinetic_share,
        ]
    }

    fn set_scalars(&mut self, scalars: [f64; SCALARS]) {
        let (energies, elements) = (&mut self.energies, &mut self.elements);
        let step_is_last;
        [
            self.time,
            self.time_step,
            self.next_time_step,
            step_is_last,
            energies.kinetic,
            energies.internal,
            energies.plastic_dissipation,
            energies.heat,
            energies.viscous,
            energies.in_play,
        ] = std::array::from_fn(|i| scalars[i + 1]);
        self.step = scalars[0] as u64;
        self.step_is_last = step_is_last != 0.0;
        elements.min_jacobian = Extreme { value: scalars[11], element: scalars[12] as u32 };
        elements.stable_time_step = Extreme { value: scalars[13], element: scalars[14] as u32 };
        energies.deleted = scalars[15];
        self.deleted_count = scalars[16] as u64;
        energies.hourglass = scalars[17];
        energies.mass_scaling = scalars[18];
        energies.kinetic_share = scalars[19];
    }

    fn works(&self) -> impl Iterator<Item = &CentredWork> {
        let others =
            [&self.constraint_work, &self.contact_work, &self.friction_work, &self.damping_work, &self.integration];
        let walls = self.walls.iter().map(|wall| &wall.work);
        self.loads.iter().map(|load| &load.work).chain(walls).chain(others)
    }

    fn works_mut(&mut self) -> impl Iterator<Item = &mut CentredWork> {
        let others = [
            &mut self.constraint_work,
            &mut self.contact_work,
            &mut self.friction_work,
            &mut self.damping_work,
            &mut self.integration,
        ];
        let walls = self.walls.iter_mut().map(|wall| &mut wall.work);
        self.loads.iter_mut().map(|load| &mut load.work).chain(walls).chain(others)
    }

    /// Enters the works up to now into the ledger.
    pub(crate) fn enter_works(&mut self) {
        for (load, work) in self.loads.iter().zip(&mut self.energies.load_work) {
            *work = load.work.until_now;
        }
        for (wall, work) in self.walls.iter().zip(&mut self.energies.wall_work) {
            *work = wall.work.until_now;
        }
        self.energies.constraint_work = self.constraint_work.until_now;
        // what walls do and the body does not get is lost between them
        self.energies.contact = self.energies.wall_work.iter().sum::<f64>() - self.contact_work.until_now;
        self.energies.friction = -self.friction_work.until_now;
        self.energies.damping = -self.damping_work.until_now;
        self.energies.integration = self.integration.until_now;
    }
}
