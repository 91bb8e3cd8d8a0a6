//! Elements that are deleted, and those that have been.

use estar_element::element::{ElementMotion, ElementUpdate};
use estar_tensor::{Mask, Real};

/// Which elements of a pack are there no more, and what they would take along.
#[derive(Clone, Copy)]
pub(super) struct Life<R: Real> {
    /// Elements that have been deleted.
    pub deleted: R::Mask,
    /// Stress power that those that are there have taken, J, for the ledger of those that are deleted.
    pub internal_energy: R,
}

impl<R: Real> Life<R> {
    /// Of elements that are all there and have taken nothing.
    pub fn new() -> Self {
        let zero = R::splat(0.0);
        Self { deleted: zero.lt(zero), internal_energy: zero }
    }

    /// Calls `visit` with the numbers of each lane: whether it has been deleted, 1 or 0, and what it has taken.
    pub fn for_each(&self, mut visit: impl FnMut(R)) {
        visit(R::select(self.deleted, R::splat(1.0), R::splat(0.0)));
        visit(self.internal_energy);
    }

    /// That whose numbers `next` gives in the order of [`Life::for_each`].
    pub fn from_numbers(mut next: impl FnMut() -> R) -> Self {
        Self { deleted: next().gt(R::splat(0.5)), internal_energy: next() }
    }
}

/// Elements that are deleted in a step.
pub(super) struct Deleted {
    pub count: u32,
    /// The stress power that they had taken, J.
    pub energy: f64,
}

impl Deleted {
    /// Enters those of the first `count` lanes that are deleted now, and takes what they had from `energy`.
    pub fn enter<R: Real>(&mut self, now: R::Mask, energy: &mut R, count: usize) {
        let zero = R::splat(0.0);
        let (marks, taken) = (R::select(now, R::splat(1.0), zero), R::select(now, *energy, zero));
        for lane in 0..count {
            self.count += marks.lane(lane) as u32;
            self.energy += taken.lane(lane);
        }
        *energy = R::select(now, zero, *energy);
    }
}

/// Lets deleted elements stand still where they began, so that nothing comes of them.
#[inline(always)]
pub(super) fn rest<R: Real, const NODES: usize>(deleted: R::Mask, motion: &mut ElementMotion<R, NODES>) {
    if deleted.any() {
        for corner in 0..NODES {
            for axis in 0..3 {
                let (reference, position) = (motion.reference[corner].0[axis], &mut motion.position[corner].0[axis]);
                *position = R::select(deleted, reference, *position);
                let velocity = &mut motion.velocity[corner].0[axis];
                *velocity = R::select(deleted, R::splat(0.0), *velocity);
            }
        }
    }
}

/// Takes force, energies and time step from deleted elements.
pub(super) fn delete<R: Real, const NODES: usize>(deleted: R::Mask, update: &mut ElementUpdate<R, NODES>) {
    let (zero, infinity) = (R::splat(0.0), R::splat(f64::INFINITY));
    for component in update.internal_force.iter_mut().flat_map(|force| &mut force.0) {
        *component = R::select(deleted, zero, *component);
    }
    let ElementUpdate { internal_energy, plastic_dissipation, viscous_energy, hourglass_energy, .. } = update;
    for energy in [internal_energy, plastic_dissipation, viscous_energy, hourglass_energy] {
        *energy = R::select(deleted, zero, *energy);
    }
    update.min_jacobian = R::select(deleted, infinity, update.min_jacobian);
    update.stable_time_step = R::select(deleted, infinity, update.stable_time_step);
}
