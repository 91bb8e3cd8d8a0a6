//! Elements of one formulation and one material, packed so that the lanes of a number are elements.

use super::averages::Packs;
use super::averages_task::Task;
use super::deletion::Life;
use super::element_block::{ElementBlock, ElementMeans, Elements, StepLimits, corner_nodes};
use super::frequencies::Frequencies;
use super::means::write_means;
use super::patch_kernel::{History, PatchKernel};
use super::report::BlockReport;
use super::tangents::{Linear, LinearPack};
use crate::patch::{PATCH, Patches};
use crate::patch_rows::{NodalMotion, PatchRows};
use crate::sums::up_the_tree;
use estar_element::element::{Element, ElementHistory, ElementStep, Tangent};
use estar_material::IsotropicElasticity;
use estar_material::points::{MaterialPoints, PointExtremes};
use estar_tensor::Real;
use rayon::prelude::*;

/// Elements of one material and one formulation, `R::LANES` side by side. The last pack is filled up with copies of the last
/// element, whose results nobody reads.
pub(super) struct SolidBlock<E: Element<NODES>, R: Real, const NODES: usize> {
    elasticity: IsotropicElasticity,
    heat_share: Option<f64>,
    element: E,
    members: Vec<u32>,
    patches: Patches,
    corner_mass: Vec<R>,
    history: Vec<History<E, R, NODES>>,
    /// Of each patch.
    points: Vec<Box<dyn MaterialPoints<R>>>,
    /// Of each pack of each patch; empty where no element is ever deleted.
    lives: Vec<Vec<Life<R>>>,
    /// Frequencies of each pack of elements of each patch; empty where nobody watches them.
    frequencies: Vec<Vec<Frequencies<R>>>,
    /// Of each pack, since the last [`ElementBlock::find_tangents`].
    linear: Vec<LinearPack<R>>,
    reports: Vec<BlockReport>,
}

/// A value for each pack of each patch where there are any.
fn of_packs<R: Real, T: Copy>(value: T, pack_count: usize, has_any: bool) -> Vec<Vec<T>> {
    let packs = PATCH / R::LANES;
    let count = |patch: usize| if has_any { (pack_count - patch * packs).min(packs) } else { 0 };
    (0..pack_count.div_ceil(packs)).map(|patch| vec![value; count(patch)]).collect()
}

impl<E: Element<NODES>, R: Real, const NODES: usize> SolidBlock<E, R, NODES> {
    /// Corners of a pack.
    const PACK_CORNERS: usize = NODES * R::LANES;

    pub fn new(element: E, elements: Elements<'_>) -> Self {
        let Elements { members, formulation, material, mesh, corner_mass, behaviour } = elements;
        let connectivity: Vec<[u32; NODES]> =
            members.iter().map(|&element| corner_nodes(formulation, mesh, element)).collect();
        let patches = Patches::new(&connectivity, R::LANES);
        let count = members.len();
        let pack_count = count.div_ceil(R::LANES);
        let packs_of_patch = PATCH / R::LANES;
        let points = material.points::<R>(E::POINTS);
        let patch_points = |patch: usize| points.of_packs((pack_count - patch * packs_of_patch).min(packs_of_patch));
        let zero = R::splat(0.0);
        let mass = |pack: usize| R::from_lanes(|lane| corner_mass[(pack * R::LANES + lane).min(count - 1)]);
        Self {
            elasticity: material.elasticity(),
            heat_share: material.heat_share(),
            element,
            members,
            patches,
            corner_mass: (0..pack_count).map(mass).collect(),
            history: vec![ElementHistory::new(0.0); pack_count],
            // each thread is the first to touch its part, which takes as long as all else here
            points: (0..count.div_ceil(PATCH)).into_par_iter().map(patch_points).collect(),
            lives: of_packs::<R, _>(Life::new(), pack_count, behaviour.deletes),
            frequencies: of_packs::<R, _>(Frequencies { now: zero, then: zero }, pack_count, behaviour.watches),
            linear: Vec::new(),
            reports: vec![BlockReport::EMPTY; count.div_ceil(PATCH)],
        }
    }
}

impl<E: Element<NODES>, R: Real, const NODES: usize> ElementBlock for SolidBlock<E, R, NODES> {
    fn members(&self) -> &[u32] {
        &self.members
    }

    fn patches(&self) -> &Patches {
        &self.patches
    }

    fn advance(
        &mut self,
        motion: NodalMotion<'_>,
        step: &ElementStep,
        limits: &StepLimits,
        patch_forces: &mut [[f64; 4]],
    ) -> BlockReport {
        let packs = PATCH / R::LANES;
        let (elasticity, element, patches) = (&self.elasticity, self.element, &self.patches);
        let work = self
            .history
            .par_chunks_mut(packs)
            .zip(self.points.par_iter_mut())
            .zip(self.members.par_chunks(PATCH))
            .zip(patches.corners().par_chunks(packs * Self::PACK_CORNERS))
            .zip(self.corner_mass.par_chunks(packs))
            .zip(patch_forces.par_chunks_mut(patches.stride()))
            .zip(self.lives.par_iter_mut())
            .zip(self.frequencies.par_iter_mut())
            .zip(self.reports.par_iter_mut())
            .enumerate();
        work.for_each(
            |(
                patch,
                ((((((((history, points), members), corners), corner_mass), forces), lives), frequencies), report),
            )| {
                let nodes = patches.nodes(patch);
                *report = PatchRows::of_motion(nodes, motion, |rows| {
                    R::vectorize(PatchKernel::<E, R, NODES> {
                        elasticity,
                        element,
                        rows,
                        step,
                        limits,
                        members,
                        history,
                        points: &mut **points,
                        lives,
                        frequencies,
                        corners,
                        corner_mass,
                        forces: &mut forces[..nodes.len()],
                    })
                });
            },
        );
        let report = |patch: usize| self.reports[patch];
        up_the_tree(self.reports.len(), BlockReport::EMPTY, &report, &BlockReport::followed_by)
    }

    fn shares_volume(&self) -> bool {
        E::SHARES_VOLUME
    }

    fn visit_neighbourhoods(
        &mut self,
        task: Task,
        motion: NodalMotion<'_>,
        averages: &[[f64; 3]],
        rows: &mut [[f64; 4]],
    ) {
        let mut packs = Packs::<_, R>::new(&self.patches, &mut self.history, &self.lives, self.members.len());
        packs.visit(task, motion, averages, rows);
    }

    fn find_tangents(&mut self, motion: NodalMotion<'_>, step: &ElementStep) {
        let zero = R::splat(0.0);
        let absent = LinearPack { deleted: zero.lt(zero), stable_time_step: zero, tangent: Tangent::none() };
        self.linear.resize(self.history.len(), absent);
        for (pack, history) in self.linear.iter_mut().zip(&self.history) {
            pack.stable_time_step = history.stable_time_step;
        }
        for (pack, life) in self.linear.iter_mut().zip(self.lives.iter().flatten()) {
            pack.deleted = life.deleted;
        }
        let linear = Linear { element: self.element, elasticity: &self.elasticity, patches: &self.patches };
        linear.find_tangents(motion, step, &self.corner_mass, &mut self.linear);
    }

    fn apply_tangents(&self, motion: NodalMotion<'_>, patch_forces: &mut [[f64; 4]]) {
        let linear = Linear { element: self.element, elasticity: &self.elasticity, patches: &self.patches };
        linear.apply_tangents(motion, &self.members, &self.linear, patch_forces);
    }

    fn watch(&mut self) {
        for frequencies in self.frequencies.iter_mut().flatten() {
            frequencies.then = frequencies.now;
        }
    }

    fn is_damped(&self) -> bool {
        self.element.is_damped()
    }

    fn has_linear_forces(&self) -> bool {
        E::HAS_LINEAR_FORCES
    }

    fn bytes_per_step(&self) -> usize {
        let frequencies: usize = self.frequencies.iter().map(|of_patch| size_of_val(&**of_patch)).sum();
        size_of_val(&*self.corner_mass)
            + 2 * size_of_val(&*self.history)
            + 2 * self.points.iter().map(|points| points.bytes()).sum::<usize>()
            + 2 * frequencies
            + self.patches.bytes_per_step()
    }

    fn scale_mass(&mut self, element: usize, factor: f64) {
        let (mass, own) = (&mut self.corner_mass[element / R::LANES], element % R::LANES);
        // the last pack is filled up with copies of the last element, which must stay copies
        let copies = if element + 1 == self.members.len() { own..R::LANES } else { own..own + 1 };
        *mass = R::from_lanes(|lane| if copies.contains(&lane) { factor * mass.lane(lane) } else { mass.lane(lane) });
    }

    fn is_deleted(&self, element: usize) -> bool {
        let life = self.lives[element / PATCH].get(element % PATCH / R::LANES);
        let mark = |life: &Life<R>| R::select(life.deleted, R::splat(1.0), R::splat(0.0)).lane(element % R::LANES);
        life.is_some_and(|life| mark(life) != 0.0)
    }

    fn stable_time_step(&self, element: usize) -> f64 {
        self.history[element / R::LANES].stable_time_step.lane(element % R::LANES)
    }

    fn heat_share(&self) -> Option<f64> {
        self.heat_share
    }

    fn extremes(&self) -> PointExtremes {
        // the copies that fill the last pack have the values of an element that is counted anyway
        self.points.par_iter().map(|points| points.extremes()).reduce(|| PointExtremes::NONE, PointExtremes::and)
    }

    fn write_means(&self, patch: usize, means: ElementMeans<'_>) {
        let (members, history) = (&self.members[patch * PATCH..], &self.history[patch * (PATCH / R::LANES)..]);
        let members = &members[..members.len().min(PATCH)];
        write_means(&*self.points[patch], members, history, means);
    }

    fn for_each_number(&self, visit: &mut dyn FnMut(f64)) {
        for element in 0..self.members.len() {
            let lane = element % R::LANES;
            let points = &self.points[element / PATCH];
            points.for_each(element % PATCH / R::LANES, &mut |number| visit(number.lane(lane)));
            self.history[element / R::LANES].for_each(|number| visit(number.lane(lane)));
            if let Some(life) = self.lives[element / PATCH].get(element % PATCH / R::LANES) {
                life.for_each(|number| visit(number.lane(lane)));
            }
            if let Some(frequencies) = self.frequencies[element / PATCH].get(element % PATCH / R::LANES) {
                visit(frequencies.now.lane(lane));
                visit(frequencies.then.lane(lane));
            }
        }
    }

    fn restore(&mut self, next: &mut dyn FnMut() -> f64) {
        // numbers of an element
        let mut count = 0;
        self.points[0].for_each(0, &mut |_| count += 1);
        self.history[0].for_each(|_| count += 1);
        let deletes = self.lives.iter().any(|lives| !lives.is_empty());
        let watches = self.frequencies.iter().any(|frequencies| !frequencies.is_empty());
        count += 2 * usize::from(deletes) + 2 * usize::from(watches);
        let mut numbers = vec![0.0; count * R::LANES];
        let mut lives = self.lives.iter_mut().flatten();
        let mut frequencies = self.frequencies.iter_mut().flatten();
        for (pack, (history, members)) in self.history.iter_mut().zip(self.members.chunks(R::LANES)).enumerate() {
            numbers[..count * members.len()].fill_with(&mut *next);
            let mut at = 0;
            let mut number = || {
                let lanes = R::from_lanes(|lane| numbers[count * lane.min(members.len() - 1) + at]);
                at += 1;
                lanes
            };
            let packs = PATCH / R::LANES;
            self.points[pack / packs].restore(pack % packs, &mut number);
            *history = ElementHistory::from_numbers(&mut number);
            if let Some(life) = lives.next() {
                *life = Life::from_numbers(&mut number);
            }
            if let Some(frequencies) = frequencies.next() {
                *frequencies = Frequencies { now: number(), then: number() };
            }
        }
    }
}
