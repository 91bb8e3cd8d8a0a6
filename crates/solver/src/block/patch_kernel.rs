//! A step of the elements of a patch.

use super::deletion::{Deleted, Life, delete, rest};
use super::element_block::StepLimits;
use super::frequencies::Frequencies;
use super::report::{BlockReport, LaneExtreme};
use crate::patch::MOST_LANES;
use crate::patch_rows::PatchRows;
use estar_element::element::{Element, ElementHistory, ElementMotion, ElementStep};
use estar_material::IsotropicElasticity;
use estar_material::points::{Exchange, MaterialPoints, PackPoints};
use estar_tensor::{Kernel, Mask, Real};

/// What an element keeps.
pub(super) type History<E, R, const NODES: usize> = ElementHistory<R, <E as Element<NODES>>::Own<R>>;

/// Partial sums of a patch: element e adds to the sum e mod 8 for any number of lanes.
const SUM_SLOTS: usize = MOST_LANES;

/// The work of one thread at a time.
pub(super) struct PatchKernel<'a, E: Element<NODES>, R: Real, const NODES: usize> {
    pub elasticity: &'a IsotropicElasticity,
    pub element: E,
    pub rows: PatchRows<'a, 3>,
    pub step: &'a ElementStep,
    pub limits: &'a StepLimits,
    pub members: &'a [u32],
    pub history: &'a mut [History<E, R, NODES>],
    pub points: &'a mut dyn MaterialPoints<R>,
    /// Of each pack; empty where no element is ever deleted.
    pub lives: &'a mut [Life<R>],
    /// Of each pack; empty where nobody watches them.
    pub frequencies: &'a mut [Frequencies<R>],
    pub corners: &'a [u16],
    pub corner_mass: &'a [R],
    pub forces: &'a mut [[f64; 4]],
}

impl<E: Element<NODES>, R: Real, const NODES: usize> Kernel for PatchKernel<'_, E, R, NODES> {
    type Output = BlockReport;

    #[inline(always)]
    fn run(self) -> BlockReport {
        let mut sums = [[R::splat(0.0); 4]; SUM_SLOTS];
        let slots = SUM_SLOTS / R::LANES;
        let mut min_jacobian = LaneExtreme::none();
        let mut stable_time_step = LaneExtreme::none();
        let (mut growth, mut decline) = (R::splat(0.0), R::splat(0.0));
        let mut not_finite = None;
        let mut deleted = Deleted { count: 0, energy: 0.0 };
        // forces of a pack, the corners of an element side by side
        let mut corner_forces = [[[0.0; 4]; NODES]; MOST_LANES];
        self.forces.fill([0.0; 4]);
        let mut motion = ElementMotion::at_the_origin();
        let mut exchange = Exchange::new();
        let packs =
            self.members.chunks(R::LANES).zip(self.corners.chunks_exact(NODES * R::LANES)).zip(self.corner_mass);
        for (pack, ((members, corners), &corner_mass)) in packs.enumerate() {
            let history = &mut self.history[pack];
            motion.corner_mass = corner_mass;
            self.rows.motion(corners, &mut motion, |_, _| ());
            let zero = R::splat(0.0);
            let mut is_deleted = zero.lt(zero);
            if let Some(life) = self.lives.get(pack) {
                is_deleted = life.deleted;
                rest(is_deleted, &mut motion);
            }
            let points = PackPoints { points: &mut *self.points, pack, exchange: &mut exchange };
            let mut update = self.element.advance(self.elasticity, points, history, &motion, self.step);
            if let Some(life) = self.lives.get_mut(pack) {
                let is_flat = update.stable_time_step.lt(R::splat(self.limits.least_stable_time_step));
                let ends = (update.min_jacobian.le(zero) | is_flat) & !is_deleted;
                is_deleted = is_deleted | ends;
                if is_deleted.any() {
                    delete(is_deleted, &mut update);
                    self.points.reset(pack, is_deleted);
                    *history = ElementHistory::select(is_deleted, &ElementHistory::new(f64::INFINITY), history);
                    deleted.enter(ends, &mut life.internal_energy, members.len());
                }
                life.deleted = is_deleted;
                life.internal_energy += update.internal_energy;
            }

            let mut force_sum = R::splat(0.0);
            for (corner, force) in update.internal_force.iter().enumerate() {
                R::scatter(force.0, &mut corner_forces.as_flattened_mut()[corner..], NODES);
                force_sum += force.0[0] + force.0[1] + force.0[2];
            }
            subtract::<R, NODES>(self.forces, &corner_forces[..members.len()], corners);
            let finite =
                force_sum.is_finite() & update.internal_energy.is_finite() & update.stable_time_step.is_finite();
            let finite = finite | is_deleted;
            if !finite.all() && not_finite.is_none() {
                let marked = R::select(finite, R::splat(1.0), R::splat(0.0));
                not_finite = (0..members.len()).find(|&lane| marked.lane(lane) == 0.0).map(|lane| members[lane]);
            }
            let mut energies =
                [update.internal_energy, update.plastic_dissipation, update.viscous_energy, update.hourglass_energy];
            if members.len() < R::LANES {
                let counts = R::from_lanes(|lane| if lane < members.len() { 1.0 } else { 0.0 }).gt(zero);
                energies = energies.map(|energy| R::select(counts, energy, zero));
            }
            let sum = &mut sums[pack % slots];
            for (sum, energy) in sum.iter_mut().zip(energies) {
                *sum += energy;
            }
            min_jacobian.enter(update.min_jacobian, pack);
            stable_time_step.enter(update.stable_time_step, pack);
            if let Some(frequencies) = self.frequencies.get_mut(pack) {
                let change = frequencies.growth(update.stable_time_step, self.limits.eigenvalue);
                growth = growth.max(change);
                decline = decline.max(-change);
            }
        }
        let total =
            |energy: usize| (0..SUM_SLOTS).map(|slot| sums[slot / R::LANES][energy].lane(slot % R::LANES)).sum();
        BlockReport {
            internal_energy: total(0),
            plastic_dissipation: total(1),
            viscous_energy: total(2),
            hourglass_energy: total(3),
            min_jacobian: min_jacobian.resolved(self.members),
            stable_time_step: stable_time_step.resolved(self.members),
            not_finite,
            deleted_count: deleted.count,
            deleted_energy: deleted.energy,
            growth: largest_lane([growth].into_iter()),
            decline: largest_lane([decline].into_iter()),
        }
    }
}

/// Subtracts the forces on the corners of a pack from the rows of its patch.
#[inline(always)]
pub(super) fn subtract<R: Real, const NODES: usize>(
    rows: &mut [[f64; 4]],
    corner_forces: &[[[f64; 4]; NODES]],
    corners: &[u16],
) {
    for (lane, forces) in corner_forces.iter().enumerate() {
        for (corner, force) in forces.iter().enumerate() {
            let sum = &mut rows[corners[corner * R::LANES + lane] as usize];
            for (sum, force) in sum.iter_mut().zip(force) {
                *sum -= force;
            }
        }
    }
}

/// The largest lane of all numbers; −∞ of none.
fn largest_lane<R: Real>(numbers: impl Iterator<Item = R>) -> f64 {
    numbers.reduce(R::max).map_or(f64::NEG_INFINITY, |largest| {
        (0..R::LANES).map(|lane| largest.lane(lane)).fold(f64::NEG_INFINITY, f64::max)
    })
}
