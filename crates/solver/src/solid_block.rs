//! Blocks of elements of one material and one formulation, packed so that the lanes of a number are elements.

use crate::averages::{Packs, Task};
use crate::fields::ElementMeans;
use crate::linear::{Linear, LinearPack};
use crate::model::{Formulation, Part};
use crate::patch::{PATCH, Patches};
use crate::patch_rows::PatchRows;
use estar_element::element::{
    Element, ElementHistory, ElementMotion, ElementStep, ElementUpdate, ElementVisitor, Tangent,
};
use estar_material::{Material, MaterialVisitor};
use estar_mesh::Mesh;
use estar_tensor::{Kernel, LaneLevel, Mask, Real, SymmetricTensor, WithLanes, array, dispatch};
use rayon::prelude::*;

/// No number has more lanes.
pub(crate) const MOST_LANES: usize = 8;
/// Partial sums of a patch: element e adds to the sum e mod 8 for any number of lanes.
const SUM_SLOTS: usize = MOST_LANES;

/// Where the nodes are and how they move; each a vector per node.
#[derive(Clone, Copy)]
pub(crate) struct NodalMotion<'a> {
    /// X, m.
    pub reference: &'a [[f64; 3]],
    /// u_{n+1}, m.
    pub displacement: &'a [[f64; 3]],
    /// v_{n+½}, m/s.
    pub velocity: &'a [[f64; 3]],
}

/// A value and the element of the mesh that has it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extreme {
    pub value: f64,
    pub element: u32,
}

impl Extreme {
    pub const NONE: Self = Self { value: f64::INFINITY, element: 0 };

    fn smaller(self, other: Self) -> Self {
        if other.value < self.value { other } else { self }
    }
}

/// What a step of one or more blocks gives; energies are those of the step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BlockReport {
    pub internal_energy: f64,
    pub plastic_dissipation: f64,
    pub viscous_energy: f64,
    pub hourglass_energy: f64,
    pub min_jacobian: Extreme,
    pub stable_time_step: Extreme,
    /// The first element with a force or an energy that is not finite.
    pub not_finite: Option<u32>,
    /// Elements that were deleted in the step.
    pub deleted_count: u32,
    /// The stress power that they had taken until then.
    pub deleted_energy: f64,
    /// By how much the largest eigenvalue of the assembled mesh may have grown since its estimate, 1/s².
    pub growth: f64,
    /// By how much it may have fallen.
    pub decline: f64,
}

/// What a step is held against.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepLimits {
    /// Of a block that deletes elements, those are whose stable time step is below this, s.
    pub least_stable_time_step: f64,
    /// The largest eigenvalue of the assembled mesh when it was estimated, 1/s².
    pub eigenvalue: f64,
}

/// What a block does besides moving its elements.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Behaviour {
    /// It deletes elements that turn inside out.
    pub deletes: bool,
    /// It watches how the frequencies of its elements grow.
    pub watches: bool,
}

impl BlockReport {
    pub const EMPTY: Self = Self {
        internal_energy: 0.0,
        plastic_dissipation: 0.0,
        viscous_energy: 0.0,
        hourglass_energy: 0.0,
        min_jacobian: Extreme::NONE,
        stable_time_step: Extreme::NONE,
        not_finite: None,
        deleted_count: 0,
        deleted_energy: 0.0,
        growth: 0.0,
        decline: 0.0,
    };

    /// The report of this and of a later block or patch.
    pub fn followed_by(self, later: &Self) -> Self {
        Self {
            internal_energy: self.internal_energy + later.internal_energy,
            plastic_dissipation: self.plastic_dissipation + later.plastic_dissipation,
            viscous_energy: self.viscous_energy + later.viscous_energy,
            hourglass_energy: self.hourglass_energy + later.hourglass_energy,
            min_jacobian: self.min_jacobian.smaller(later.min_jacobian),
            stable_time_step: self.stable_time_step.smaller(later.stable_time_step),
            not_finite: self.not_finite.or(later.not_finite),
            deleted_count: self.deleted_count + later.deleted_count,
            deleted_energy: self.deleted_energy + later.deleted_energy,
            growth: self.growth.max(later.growth),
            decline: self.decline.max(later.decline),
        }
    }
}

/// Extremes over the quadrature points of a block.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Largest {
    /// Equivalent plastic strain.
    pub plastic_strain: f64,
    /// Temperature, K; −∞ where the material has none.
    pub temperature: f64,
}

impl Largest {
    pub const NONE: Self = Self { plastic_strain: 0.0, temperature: f64::NEG_INFINITY };

    pub fn larger(self, other: Self) -> Self {
        Self {
            plastic_strain: self.plastic_strain.max(other.plastic_strain),
            temperature: self.temperature.max(other.temperature),
        }
    }
}

/// A block of elements, whatever their material and number of lanes. Called once a step, not once an element.
pub(crate) trait ElementBlock: Send + Sync {
    /// Elements of the mesh, in the order of the block.
    fn members(&self) -> &[u32];

    /// The nodes of the block.
    fn patches(&self) -> &Patches;

    /// Moves every element to t_{n+1} and writes the forces −∫ T ∇N_a dV on the nodes of each patch to its rows; where elements
    /// share their volume change, those of dev T.
    fn advance(
        &mut self,
        motion: NodalMotion<'_>,
        step: &ElementStep,
        limits: &StepLimits,
        patch_forces: &mut [[f64; 4]],
    ) -> BlockReport;

    /// Whether its elements share their volume change with their neighbours.
    fn shares_volume(&self) -> bool;

    /// Does a part of the averaging with every element that shares its volume change: `averages` are of the nodes of the mesh,
    /// `rows` of the nodes of each patch.
    fn visit_neighbourhoods(
        &mut self,
        task: Task,
        motion: NodalMotion<'_>,
        averages: &[[f64; 3]],
        rows: &mut [[f64; 4]],
    );

    /// Finds what the linear forces need besides the geometry, at t_n with the damping of the step.
    fn find_tangents(&mut self, motion: NodalMotion<'_>, step: &ElementStep);

    /// Writes the linear forces −(K + 2C/Δt) z on the nodes of each patch to its rows, z for the velocity of the motion.
    fn apply_tangents(&self, motion: NodalMotion<'_>, patch_forces: &mut [[f64; 4]]);

    /// Takes the frequencies of the elements as of the last step for those that their growth is measured from.
    fn watch(&mut self);

    /// Whether the elements damp of themselves.
    fn is_damped(&self) -> bool;

    /// Bytes of the block's own data, rows of forces included, that [`ElementBlock::advance`] reads and writes.
    fn bytes_per_step(&self) -> usize;

    /// Whether the linear forces of its elements are known.
    fn has_linear_forces(&self) -> bool;

    /// Makes an element heavier by a factor, as far as its stable time step goes.
    fn scale_mass(&mut self, element: usize, factor: f64);

    /// Stable time step of an element on its last geometry, s; infinite of one that has been deleted.
    fn stable_time_step(&self, element: usize) -> f64;

    /// The share of the plastic dissipation that heats the material, where it has a temperature.
    fn heat_share(&self) -> Option<f64>;

    /// Extremes over the quadrature points.
    fn largest(&self) -> Largest;

    /// Writes the means over the points of each element of a patch to their places in the fields; the place of
    /// the first is at their beginning.
    fn write_means(&self, patch: usize, means: ElementMeans<'_>);

    /// Calls `visit` with every number of every history, in an order that does not depend on the lanes.
    fn for_each_number(&self, visit: &mut dyn FnMut(f64));

    /// Takes the histories whose numbers `next` gives in that order.
    fn restore(&mut self, next: &mut dyn FnMut() -> f64);
}

/// The block of a part. `corner_mass` is the smallest corner mass of each of its elements.
pub(crate) fn block(
    part: Part,
    mesh: &Mesh,
    corner_mass: Vec<f64>,
    behaviour: Behaviour,
    level: LaneLevel,
) -> Box<dyn ElementBlock> {
    let elements = Elements { members: part.elements, formulation: part.element, mesh, corner_mass, behaviour };
    part.material.visit(BlockOf { elements, level })
}

/// The node at each corner of an element whose shape the formulation is made for.
pub(crate) fn corner_nodes<const NODES: usize>(formulation: Formulation, mesh: &Mesh, element: u32) -> [u32; NODES] {
    let (elements, element) = (mesh.elements(), element as usize);
    let nodes = elements.nodes(element);
    let places = formulation.places(elements.shape(element)).unwrap_or_default();
    array(|corner| nodes[places[corner]])
}

struct BlockOf<'a> {
    elements: Elements<'a>,
    level: LaneLevel,
}

impl MaterialVisitor for BlockOf<'_> {
    type Output = Box<dyn ElementBlock>;

    fn visit<M: Material>(self, material: &M) -> Box<dyn ElementBlock> {
        let Self { elements, level } = self;
        elements.formulation.visit(BlockOfMaterial { material: material.clone(), elements, level })
    }
}

struct BlockOfMaterial<'a, M> {
    material: M,
    elements: Elements<'a>,
    level: LaneLevel,
}

impl<M: Material> ElementVisitor for BlockOfMaterial<'_, M> {
    type Output = Box<dyn ElementBlock>;

    fn visit<const NODES: usize, E: Element<NODES>>(self, element: E) -> Box<dyn ElementBlock> {
        let Self { material, elements, level } = self;
        dispatch(level, NewBlock::<_, _, NODES> { element, elements, material })
    }
}

/// The elements of a block, not yet packed.
struct Elements<'a> {
    members: Vec<u32>,
    formulation: Formulation,
    mesh: &'a Mesh,
    corner_mass: Vec<f64>,
    behaviour: Behaviour,
}

struct NewBlock<'a, M, E, const NODES: usize> {
    element: E,
    elements: Elements<'a>,
    material: M,
}

impl<M: Material, E: Element<NODES>, const NODES: usize> WithLanes for NewBlock<'_, M, E, NODES> {
    type Output = Box<dyn ElementBlock>;

    fn with_lanes<R: Real>(self) -> Box<dyn ElementBlock> {
        Box::new(SolidBlock::<M, E, R, NODES>::new(self))
    }
}

type History<M, E, R, const NODES: usize> = <E as Element<NODES>>::History<R, <M as Material>::State<R>>;

/// Elements of one material and one formulation, `R::LANES` side by side. The last pack is filled up with copies of the last
/// element, whose results nobody reads.
struct SolidBlock<M: Material, E: Element<NODES>, R: Real, const NODES: usize> {
    material: M,
    element: E,
    members: Vec<u32>,
    patches: Patches,
    corner_mass: Vec<R>,
    history: Vec<History<M, E, R, NODES>>,
    /// Stress power that each element of each patch has taken, J, for the ledger of those that are deleted; empty where none
    /// ever is.
    internal_energies: Vec<Vec<R>>,
    /// Frequencies of each pack of elements of each patch; empty where nobody watches them.
    frequencies: Vec<Vec<Frequencies<R>>>,
    /// Of each pack, since the last [`ElementBlock::find_tangents`].
    linear: Vec<LinearPack<R>>,
    reports: Vec<BlockReport>,
}

/// Squares of the highest frequencies that elements may have, ω_e² = 4/Δt_e², 1/s².
#[derive(Clone, Copy)]
struct Frequencies<R> {
    /// As of the last step.
    now: R,
    /// When the assembled mesh was last looked at.
    then: R,
}

/// A value for each pack of each patch where there are any.
fn of_packs<R: Real, T: Copy>(value: T, pack_count: usize, has_any: bool) -> Vec<Vec<T>> {
    let packs = PATCH / R::LANES;
    let count = |patch: usize| if has_any { (pack_count - patch * packs).min(packs) } else { 0 };
    (0..pack_count.div_ceil(packs)).map(|patch| vec![value; count(patch)]).collect()
}

impl<R: Real> Frequencies<R> {
    /// Enters the stable time step of now, and tells the growth of the frequencies as it counts for the assembled mesh.
    #[inline(always)]
    fn growth(&mut self, stable_time_step: R, eigenvalue: f64) -> R {
        let half = stable_time_step * 0.5;
        self.now = (half * half).recip();
        // Δω² min(1, Λ/ω²)
        (self.now - self.then) * (R::splat(eigenvalue) / self.then).min(R::splat(1.0))
    }
}

impl<M: Material, E: Element<NODES>, R: Real, const NODES: usize> SolidBlock<M, E, R, NODES> {
    /// Corners of a pack.
    const PACK_CORNERS: usize = NODES * R::LANES;

    fn new(block: NewBlock<M, E, NODES>) -> Self {
        let NewBlock { element, elements, material } = block;
        let Elements { members, formulation, mesh, corner_mass, behaviour } = elements;
        let connectivity: Vec<[u32; NODES]> =
            members.iter().map(|&element| corner_nodes(formulation, mesh, element)).collect();
        let patches = Patches::new(&connectivity, R::LANES);
        let count = members.len();
        let pack_count = count.div_ceil(R::LANES);
        let initial = E::initial_history(&material, 0.0);
        let zero = R::splat(0.0);
        let mass = |pack: usize| R::from_lanes(|lane| corner_mass[(pack * R::LANES + lane).min(count - 1)]);
        Self {
            material,
            element,
            members,
            patches,
            corner_mass: (0..pack_count).map(mass).collect(),
            // each thread is the first to touch its part, which takes as long as all else here
            history: (0..pack_count).into_par_iter().map(|_| initial).collect(),
            internal_energies: of_packs::<R, _>(zero, pack_count, behaviour.deletes),
            frequencies: of_packs::<R, _>(Frequencies { now: zero, then: zero }, pack_count, behaviour.watches),
            linear: Vec::new(),
            reports: vec![BlockReport::EMPTY; count.div_ceil(PATCH)],
        }
    }
}

impl<M: Material, E: Element<NODES>, R: Real, const NODES: usize> ElementBlock for SolidBlock<M, E, R, NODES> {
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
        let (material, element, patches) = (&self.material, self.element, &self.patches);
        let work = self
            .history
            .par_chunks_mut(packs)
            .zip(self.members.par_chunks(PATCH))
            .zip(patches.corners().par_chunks(packs * Self::PACK_CORNERS))
            .zip(self.corner_mass.par_chunks(packs))
            .zip(patch_forces.par_chunks_mut(patches.stride()))
            .zip(self.internal_energies.par_iter_mut())
            .zip(self.frequencies.par_iter_mut())
            .zip(self.reports.par_iter_mut())
            .enumerate();
        work.for_each(
            |(
                patch,
                (((((((history, members), corners), corner_mass), forces), internal_energies), frequencies), report),
            )| {
                let nodes = patches.nodes(patch);
                *report = PatchRows::of_motion(nodes, motion, |rows| {
                    R::vectorize(PatchKernel::<M, E, R, NODES> {
                        material,
                        element,
                        rows,
                        step,
                        limits,
                        members,
                        history,
                        internal_energies,
                        frequencies,
                        corners,
                        corner_mass,
                        forces: &mut forces[..nodes.len()],
                    })
                });
            },
        );
        self.reports.iter().fold(BlockReport::EMPTY, BlockReport::followed_by)
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
        let mut packs = Packs::<_, R>::new(&self.patches, &mut self.history, self.members.len(), NODES);
        packs.visit::<M::State<R>>(task, motion, averages, rows);
    }

    fn find_tangents(&mut self, motion: NodalMotion<'_>, step: &ElementStep) {
        let absent = LinearPack { stable_time_step: R::splat(f64::INFINITY), tangent: Tangent::none() };
        self.linear.resize(self.history.len(), absent);
        for (pack, history) in self.linear.iter_mut().zip(&self.history) {
            pack.stable_time_step = history.stable_time_step();
        }
        let linear = Linear { element: self.element, elasticity: self.material.elasticity(), patches: &self.patches };
        linear.find_tangents(motion, step, &self.corner_mass, &mut self.linear);
    }

    fn apply_tangents(&self, motion: NodalMotion<'_>, patch_forces: &mut [[f64; 4]]) {
        let linear = Linear { element: self.element, elasticity: self.material.elasticity(), patches: &self.patches };
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
            + 2 * frequencies
            + self.patches.bytes_per_step()
    }

    fn scale_mass(&mut self, element: usize, factor: f64) {
        let (mass, own) = (&mut self.corner_mass[element / R::LANES], element % R::LANES);
        // the last pack is filled up with copies of the last element, which must stay copies
        let copies = if element + 1 == self.members.len() { own..R::LANES } else { own..own + 1 };
        *mass = R::from_lanes(|lane| if copies.contains(&lane) { factor * mass.lane(lane) } else { mass.lane(lane) });
    }

    fn stable_time_step(&self, element: usize) -> f64 {
        self.history[element / R::LANES].stable_time_step().lane(element % R::LANES)
    }

    fn heat_share(&self) -> Option<f64> {
        self.material.heat_share()
    }

    fn largest(&self) -> Largest {
        // the copies that fill the last pack have the values of an element that is counted anyway
        let of_pack = |pack: &History<M, E, R, NODES>| {
            let states = || pack.states().iter();
            Largest {
                plastic_strain: largest_lane(states().map(|state| self.material.equivalent_plastic_strain(state))),
                temperature: largest_lane(states().filter_map(|state| self.material.temperature(state))),
            }
        };
        self.history.par_iter().with_min_len(PATCH).map(of_pack).reduce(|| Largest::NONE, Largest::larger)
    }

    fn write_means(&self, patch: usize, means: ElementMeans<'_>) {
        let (members, history) = (&self.members[patch * PATCH..], &self.history[patch * (PATCH / R::LANES)..]);
        let members = &members[..members.len().min(PATCH)];
        R::vectorize(MeansKernel::<M, E, R, NODES> { material: &self.material, members, history, means });
    }

    fn for_each_number(&self, visit: &mut dyn FnMut(f64)) {
        for element in 0..self.members.len() {
            let (pack, lane) = (&self.history[element / R::LANES], element % R::LANES);
            pack.for_each(|number| visit(number.lane(lane)));
            let energies = &self.internal_energies[element / PATCH];
            if let Some(energy) = energies.get(element % PATCH / R::LANES) {
                visit(energy.lane(lane));
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
        self.history[0].for_each(|_| count += 1);
        let deletes = self.internal_energies.iter().any(|energies| !energies.is_empty());
        let watches = self.frequencies.iter().any(|frequencies| !frequencies.is_empty());
        count += usize::from(deletes) + 2 * usize::from(watches);
        let mut numbers = vec![0.0; count * R::LANES];
        let mut internal_energies = self.internal_energies.iter_mut().flatten();
        let mut frequencies = self.frequencies.iter_mut().flatten();
        for (pack, members) in self.history.iter_mut().zip(self.members.chunks(R::LANES)) {
            numbers[..count * members.len()].fill_with(&mut *next);
            let mut at = 0;
            let mut number = || {
                let lanes = R::from_lanes(|lane| numbers[count * lane.min(members.len() - 1) + at]);
                at += 1;
                lanes
            };
            *pack = ElementHistory::from_numbers(&mut number);
            if let Some(energy) = internal_energies.next() {
                *energy = number();
            }
            if let Some(frequencies) = frequencies.next() {
                *frequencies = Frequencies { now: number(), then: number() };
            }
        }
    }
}

/// The work of one thread at a time.
struct PatchKernel<'a, M: Material, E: Element<NODES>, R: Real, const NODES: usize> {
    material: &'a M,
    element: E,
    rows: PatchRows<'a, 3>,
    step: &'a ElementStep,
    limits: &'a StepLimits,
    members: &'a [u32],
    history: &'a mut [History<M, E, R, NODES>],
    /// Of each pack; empty where no element is ever deleted.
    internal_energies: &'a mut [R],
    /// Of each pack; empty where nobody watches them.
    frequencies: &'a mut [Frequencies<R>],
    corners: &'a [u16],
    corner_mass: &'a [R],
    forces: &'a mut [[f64; 4]],
}

impl<M: Material, E: Element<NODES>, R: Real, const NODES: usize> Kernel for PatchKernel<'_, M, E, R, NODES> {
    type Output = BlockReport;

    #[inline(always)]
    fn run(self) -> BlockReport {
        let mut sums = [[R::splat(0.0); 4]; SUM_SLOTS];
        let slots = SUM_SLOTS / R::LANES;
        let mut min_jacobian = LaneExtreme::none();
        let mut stable_time_step = LaneExtreme::none();
        let (mut growth, mut decline) = (R::splat(0.0), R::splat(0.0));
        let mut not_finite = None;
        let deletes = !self.internal_energies.is_empty();
        let mut deleted = Deleted { count: 0, energy: 0.0 };
        // forces of a pack, the corners of an element side by side
        let mut corner_forces = [[[0.0; 4]; NODES]; MOST_LANES];
        self.forces.fill([0.0; 4]);
        let mut motion = ElementMotion::at_the_origin();
        let packs = self
            .members
            .chunks(R::LANES)
            .zip(self.corners.chunks_exact(SolidBlock::<M, E, R, NODES>::PACK_CORNERS))
            .zip(self.corner_mass);
        for (pack, ((members, corners), &corner_mass)) in packs.enumerate() {
            let (now, later) = self.history[pack..].split_at_mut(1);
            let (history, upcoming) = (&mut now[0], later.first());
            motion.corner_mass = corner_mass;
            self.rows.motion(corners, &mut motion, |_, _| ());
            let zero = R::splat(0.0);
            let mut is_deleted = zero.lt(zero);
            if deletes {
                is_deleted = rest(history.stable_time_step(), &mut motion);
            }
            let mut update = self.element.advance(self.material, history, upcoming, &motion, self.step);
            if deletes {
                let energy_so_far = &mut self.internal_energies[pack];
                let is_flat = update.stable_time_step.lt(R::splat(self.limits.least_stable_time_step));
                let ends = (update.min_jacobian.le(zero) | is_flat) & !is_deleted;
                is_deleted = is_deleted | ends;
                if is_deleted.any() {
                    delete(is_deleted, &mut update);
                    let initial = E::initial_history(self.material, f64::INFINITY);
                    *history = ElementHistory::select(is_deleted, &initial, history);
                    deleted.enter(ends, energy_so_far, members.len());
                }
                *energy_so_far += update.internal_energy;
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
pub(crate) fn subtract<R: Real, const NODES: usize>(
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

/// Elements that are deleted in a step.
struct Deleted {
    count: u32,
    /// The stress power that they had taken, J.
    energy: f64,
}

impl Deleted {
    /// Enters those of the first `count` lanes that are deleted now, and takes what they had from `energy`.
    fn enter<R: Real>(&mut self, now: R::Mask, energy: &mut R, count: usize) {
        let zero = R::splat(0.0);
        let (marks, taken) = (R::select(now, R::splat(1.0), zero), R::select(now, *energy, zero));
        for lane in 0..count {
            self.count += marks.lane(lane) as u32;
            self.energy += taken.lane(lane);
        }
        *energy = R::select(now, zero, *energy);
    }
}

/// The lanes of elements that have been deleted, which their infinite time step tells. They stand still where they began, so
/// that nothing comes of them.
#[inline(always)]
pub(crate) fn rest<R: Real, const NODES: usize>(stable_time_step: R, motion: &mut ElementMotion<R, NODES>) -> R::Mask {
    let are_deleted = stable_time_step.ge(R::splat(f64::INFINITY));
    if are_deleted.any() {
        for corner in 0..NODES {
            for axis in 0..3 {
                let (reference, position) = (motion.reference[corner].0[axis], &mut motion.position[corner].0[axis]);
                *position = R::select(are_deleted, reference, *position);
                let velocity = &mut motion.velocity[corner].0[axis];
                *velocity = R::select(are_deleted, R::splat(0.0), *velocity);
            }
        }
    }
    are_deleted
}

/// Takes force, energies and time step from deleted elements.
fn delete<R: Real, const NODES: usize>(deleted: R::Mask, update: &mut ElementUpdate<R, NODES>) {
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

/// The smallest value of each lane and the pack that has it.
#[derive(Clone, Copy)]
struct LaneExtreme<R> {
    value: R,
    pack: R,
}

impl<R: Real> LaneExtreme<R> {
    #[inline(always)]
    fn none() -> Self {
        Self { value: R::splat(f64::INFINITY), pack: R::splat(0.0) }
    }

    #[inline(always)]
    fn enter(&mut self, value: R, pack: usize) {
        let smaller = value.lt(self.value);
        self.value = R::select(smaller, value, self.value);
        self.pack = R::select(smaller, R::splat(pack as f64), self.pack);
    }

    /// The smallest of all lanes; of equal ones that of the first element.
    fn resolved(self, members: &[u32]) -> Extreme {
        let of_lane = |lane: usize| (self.value.lane(lane), self.pack.lane(lane) as usize * R::LANES + lane);
        let smaller = |a: (f64, usize), b: (f64, usize)| if b < a { b } else { a };
        let (value, element) = (0..R::LANES).map(of_lane).fold((f64::INFINITY, usize::MAX), smaller);
        // the copies that fill the last pack are those of the last element
        Extreme { value, element: members[element.min(members.len() - 1)] }
    }
}

/// The largest lane of all numbers; −∞ of none.
fn largest_lane<R: Real>(numbers: impl Iterator<Item = R>) -> f64 {
    numbers.reduce(R::max).map_or(f64::NEG_INFINITY, |largest| {
        (0..R::LANES).map(|lane| largest.lane(lane)).fold(f64::NEG_INFINITY, f64::max)
    })
}

/// Means over the points of the elements of a patch, as a user sees them.
struct MeansKernel<'a, M: Material, E: Element<NODES>, R: Real, const NODES: usize> {
    material: &'a M,
    members: &'a [u32],
    history: &'a [History<M, E, R, NODES>],
    means: ElementMeans<'a>,
}

impl<M: Material, E: Element<NODES>, R: Real, const NODES: usize> Kernel for MeansKernel<'_, M, E, R, NODES> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { material, members, history, means } = self;
        let ElementMeans { mut cauchy_stress, mut equivalent_plastic_strain, mut temperature, mut volume_ratio } =
            means;
        let share = R::splat(1.0 / E::POINTS as f64);
        let mut lanes = [[0.0; MOST_LANES]; 6];
        for (pack, of_pack) in history.iter().zip(members.chunks(R::LANES)) {
            let places = || of_pack.iter().map(|element| (element - members[0]) as usize).enumerate();
            if let Some(field) = &mut cauchy_stress {
                let mut mean = SymmetricTensor::zero();
                for (state, rotation) in pack.states().iter().zip(pack.rotations()) {
                    mean = mean + material.cauchy_stress(state, *rotation) * share;
                }
                if let Some(shared) = pack.neighbourhood() {
                    // dev T + σ̄ I, of which the forces are
                    mean = mean.plus_spherical(shared.mean_stress - mean.trace() * (1.0 / 3.0));
                }
                for (lanes, component) in lanes.iter_mut().zip(mean.0) {
                    component.store(lanes);
                }
                for (lane, place) in places() {
                    field[place] = array(|component| lanes[component][lane]);
                }
            }
            let [lanes, ..] = &mut lanes;
            if let Some(field) = &mut equivalent_plastic_strain {
                let mut mean = R::splat(0.0);
                for state in pack.states() {
                    mean += material.equivalent_plastic_strain(state) * share;
                }
                mean.store(lanes);
                places().for_each(|(lane, place)| field[place] = lanes[lane]);
            }
            if let Some(field) = &mut temperature {
                let none = R::splat(f64::NAN);
                let mut mean = R::splat(0.0);
                for state in pack.states() {
                    mean += material.temperature(state).unwrap_or(none) * share;
                }
                mean.store(lanes);
                places().for_each(|(lane, place)| field[place] = lanes[lane]);
            }
            if let (Some(field), Some(shared)) = (&mut volume_ratio, pack.neighbourhood()) {
                shared.jacobian.store(lanes);
                places().for_each(|(lane, place)| field[place] = lanes[lane]);
            }
        }
    }
}
