//! Blocks of elements of one material and one formulation, packed so that the lanes of a number are elements.

use crate::model::Part;
use estar_element::hex8::{self, CORNERS, CornerVectors, HexHistory, HexMotion, HexStep, POINTS};
use estar_material::{Material, MaterialModel, PointState};
use estar_tensor::{Kernel, LaneLevel, Mask, Real, Rotation, SymmetricTensor, Vector3, WithLanes, array, dispatch};
use rayon::prelude::*;

/// Elements that one thread takes at a time; a multiple of every number of lanes. Sums are formed within such a chunk
/// first, so that they depend neither on the threads nor on the lanes.
pub(crate) const CHUNK: usize = 512;
/// No number has more lanes.
const MOST_LANES: usize = 8;
/// Partial sums of a chunk: element e adds to the sum e mod 8 for any number of lanes.
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

/// A value and the hex of the mesh that has it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extreme {
    pub value: f64,
    pub hex: u32,
}

impl Extreme {
    const NONE: Self = Self { value: f64::INFINITY, hex: 0 };

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
    pub min_jacobian: Extreme,
    pub stable_time_step: Extreme,
    /// The first hex with a force or an energy that is not finite.
    pub not_finite: Option<u32>,
}

impl BlockReport {
    pub const EMPTY: Self = Self {
        internal_energy: 0.0,
        plastic_dissipation: 0.0,
        viscous_energy: 0.0,
        min_jacobian: Extreme::NONE,
        stable_time_step: Extreme::NONE,
        not_finite: None,
    };

    /// The report of this and of a later block or chunk.
    pub fn followed_by(self, later: &Self) -> Self {
        Self {
            internal_energy: self.internal_energy + later.internal_energy,
            plastic_dissipation: self.plastic_dissipation + later.plastic_dissipation,
            viscous_energy: self.viscous_energy + later.viscous_energy,
            min_jacobian: self.min_jacobian.smaller(later.min_jacobian),
            stable_time_step: self.stable_time_step.smaller(later.stable_time_step),
            not_finite: self.not_finite.or(later.not_finite),
        }
    }
}

/// Fields over hexes, each or none wanted: means over the quadrature points.
pub(crate) struct Means<'a> {
    /// Cauchy stress, Pa.
    pub cauchy_stress: Option<&'a mut [[f64; 6]]>,
    /// Equivalent plastic strain.
    pub equivalent_plastic_strain: Option<&'a mut [f64]>,
}

/// A block of elements, whatever their material and number of lanes. Called once a step, not once an element.
pub(crate) trait ElementBlock: Send + Sync {
    /// Hexes of the mesh, in the order of the block.
    fn hexes(&self) -> &[u32];

    /// Numbers that the corner forces of the block fill.
    fn force_count(&self) -> usize;

    /// Position of the x component of a corner force in the block's part of the forces.
    fn force_slot(&self, element: usize, corner: usize) -> usize;

    /// Distance of the y component of a corner force from its x component, and of z from y.
    fn component_stride(&self) -> usize;

    /// Moves every element to t_{n+1} and writes its corner forces −∫ T ∇N_a dV.
    fn advance(&mut self, motion: NodalMotion<'_>, step: &HexStep, corner_forces: &mut [f64]) -> BlockReport;

    /// Bytes of the block's own data, corner forces included, that [`ElementBlock::advance`] reads and writes.
    fn bytes_per_step(&self) -> usize;

    /// Stable time step of an element on its last geometry, s.
    fn stable_time_step(&self, element: usize) -> f64;

    /// Largest equivalent plastic strain of a quadrature point.
    fn largest_plastic_strain(&self) -> f64;

    /// Writes the means over the points of each element of a chunk to the places of its hexes in the fields; the place of
    /// the first is at their beginning.
    fn write_means(&self, chunk: usize, means: Means<'_>);

    /// Calls `visit` with every number of every history, in an order that does not depend on the lanes.
    fn for_each_number(&self, visit: &mut dyn FnMut(f64));
}

/// The block of a part. `corner_mass` is the smallest corner mass of each of its hexes.
pub(crate) fn block(part: Part, hexes: &[[u32; 8]], corner_mass: Vec<f64>, level: LaneLevel) -> Box<dyn ElementBlock> {
    let connectivity = part.hexes.iter().map(|&hex| hexes[hex as usize]).collect();
    let elements = Elements { hexes: part.hexes, connectivity, corner_mass };
    match part.material {
        MaterialModel::Elastic(material) => dispatch(level, NewBlock { elements, material }),
        MaterialModel::EStar(material) => dispatch(level, NewBlock { elements, material }),
        MaterialModel::EStarKinematic(material) => dispatch(level, NewBlock { elements, material }),
        MaterialModel::EStarTotal(material) => dispatch(level, NewBlock { elements, material }),
    }
}

/// The elements of a block, not yet packed.
struct Elements {
    hexes: Vec<u32>,
    connectivity: Vec<[u32; CORNERS]>,
    corner_mass: Vec<f64>,
}

struct NewBlock<M> {
    elements: Elements,
    material: M,
}

impl<M: Material> WithLanes for NewBlock<M> {
    type Output = Box<dyn ElementBlock>;

    fn with_lanes<R: Real>(self) -> Box<dyn ElementBlock> {
        Box::new(SolidBlock::<M, R>::new(self.elements, self.material))
    }
}

type History<M, R> = HexHistory<<M as Material>::State<R>, R>;

/// Elements of one material, `R::LANES` side by side. The last pack is filled up with copies of the last element, whose
/// results nobody reads.
struct SolidBlock<M: Material, R: Real> {
    material: M,
    hexes: Vec<u32>,
    connectivity: Vec<[u32; CORNERS]>,
    corner_mass: Vec<R>,
    history: Vec<History<M, R>>,
    reports: Vec<BlockReport>,
}

impl<M: Material, R: Real> SolidBlock<M, R> {
    /// Numbers that the corner forces of a pack fill.
    const PACK_FORCES: usize = CORNERS * 3 * R::LANES;

    fn new(elements: Elements, material: M) -> Self {
        let Elements { hexes, mut connectivity, corner_mass } = elements;
        let count = hexes.len();
        let pack_count = count.div_ceil(R::LANES);
        let last = connectivity[count - 1];
        connectivity.resize(pack_count * R::LANES, last);
        let initial = HexHistory {
            states: [material.initial_state(); POINTS],
            rotations: [Rotation::identity(); POINTS],
            stable_time_step: R::splat(0.0),
            viscous_pressure: R::splat(0.0),
        };
        let mass = |pack: usize| R::from_lanes(|lane| corner_mass[(pack * R::LANES + lane).min(count - 1)]);
        Self {
            material,
            hexes,
            connectivity,
            corner_mass: (0..pack_count).map(mass).collect(),
            // each thread is the first to touch its part, which takes as long as all else here
            history: (0..pack_count).into_par_iter().map(|_| initial).collect(),
            reports: vec![BlockReport::EMPTY; count.div_ceil(CHUNK)],
        }
    }
}

impl<M: Material, R: Real> ElementBlock for SolidBlock<M, R> {
    fn hexes(&self) -> &[u32] {
        &self.hexes
    }

    fn force_count(&self) -> usize {
        self.history.len() * Self::PACK_FORCES
    }

    fn force_slot(&self, element: usize, corner: usize) -> usize {
        let (pack, lane) = (element / R::LANES, element % R::LANES);
        pack * Self::PACK_FORCES + corner * 3 * R::LANES + lane
    }

    fn component_stride(&self) -> usize {
        R::LANES
    }

    fn advance(&mut self, motion: NodalMotion<'_>, step: &HexStep, corner_forces: &mut [f64]) -> BlockReport {
        let packs = CHUNK / R::LANES;
        let material = &self.material;
        let chunks = self
            .history
            .par_chunks_mut(packs)
            .zip(self.hexes.par_chunks(CHUNK))
            .zip(self.connectivity.par_chunks(CHUNK))
            .zip(self.corner_mass.par_chunks(packs))
            .zip(corner_forces.par_chunks_mut(packs * Self::PACK_FORCES))
            .zip(self.reports.par_iter_mut());
        chunks.for_each(|(((((history, hexes), connectivity), corner_mass), corner_forces), report)| {
            let kernel =
                ChunkKernel { material, motion, step, hexes, history, connectivity, corner_mass, corner_forces };
            *report = R::vectorize(kernel);
        });
        self.reports.iter().fold(BlockReport::EMPTY, BlockReport::followed_by)
    }

    fn bytes_per_step(&self) -> usize {
        let read = size_of_val(&*self.hexes) + size_of_val(&*self.connectivity) + size_of_val(&*self.corner_mass);
        let updated = size_of_val(&*self.history);
        let written = self.force_count() * size_of::<f64>();
        read + 2 * updated + written
    }

    fn stable_time_step(&self, element: usize) -> f64 {
        self.history[element / R::LANES].stable_time_step.lane(element % R::LANES)
    }

    fn largest_plastic_strain(&self) -> f64 {
        // the copies that fill the last pack have the strains of an element that is counted anyway
        let of_pack = |pack: &History<M, R>| {
            let strains = pack.states.iter().map(|state| self.material.equivalent_plastic_strain(state));
            let largest = strains.fold(R::splat(0.0), R::max);
            (0..R::LANES).map(|lane| largest.lane(lane)).fold(0.0, f64::max)
        };
        self.history.par_iter().with_min_len(CHUNK).map(of_pack).reduce(|| 0.0, f64::max)
    }

    fn write_means(&self, chunk: usize, means: Means<'_>) {
        let (hexes, history) = (&self.hexes[chunk * CHUNK..], &self.history[chunk * (CHUNK / R::LANES)..]);
        let hexes = &hexes[..hexes.len().min(CHUNK)];
        R::vectorize(MeansKernel { material: &self.material, hexes, history, means });
    }

    fn for_each_number(&self, visit: &mut dyn FnMut(f64)) {
        for element in 0..self.hexes.len() {
            let (pack, lane) = (&self.history[element / R::LANES], element % R::LANES);
            for point in 0..POINTS {
                pack.states[point].for_each(|number| visit(number.lane(lane)));
                pack.rotations[point].0.iter().for_each(|number| visit(number.lane(lane)));
            }
            visit(pack.stable_time_step.lane(lane));
            visit(pack.viscous_pressure.lane(lane));
        }
    }
}

/// The work of one thread at a time.
struct ChunkKernel<'a, M: Material, R: Real> {
    material: &'a M,
    motion: NodalMotion<'a>,
    step: &'a HexStep,
    hexes: &'a [u32],
    history: &'a mut [History<M, R>],
    connectivity: &'a [[u32; CORNERS]],
    corner_mass: &'a [R],
    corner_forces: &'a mut [f64],
}

impl<M: Material, R: Real> Kernel for ChunkKernel<'_, M, R> {
    type Output = BlockReport;

    #[inline(always)]
    fn run(self) -> BlockReport {
        let mut sums = [[0.0; SUM_SLOTS]; 3];
        let mut report = BlockReport::EMPTY;
        let packs = self.history.iter_mut().zip(self.hexes.chunks(R::LANES));
        let packs = packs.zip(self.connectivity.chunks_exact(R::LANES)).zip(self.corner_mass);
        let forces = self.corner_forces.chunks_exact_mut(SolidBlock::<M, R>::PACK_FORCES);
        for (pack, ((((history, hexes), connectivity), &corner_mass), forces)) in packs.zip(forces).enumerate() {
            let reference = gathered(self.motion.reference, connectivity);
            let displacement = gathered(self.motion.displacement, connectivity);
            let motion = HexMotion {
                reference,
                position: array(|corner| reference[corner] + displacement[corner]),
                velocity: gathered(self.motion.velocity, connectivity),
            };
            let update = hex8::advance(self.material, history, &motion, corner_mass, self.step);

            let mut force_sum = R::splat(0.0);
            for (corner, force) in update.internal_force.iter().enumerate() {
                for (component, value) in force.0.iter().enumerate() {
                    let start = (corner * 3 + component) * R::LANES;
                    (-*value).store(&mut forces[start..start + R::LANES]);
                    force_sum += *value;
                }
            }
            let finite =
                force_sum.is_finite() & update.internal_energy.is_finite() & update.stable_time_step.is_finite();
            let all_finite = finite.all();
            for (lane, &hex) in hexes.iter().enumerate() {
                let slot = (pack * R::LANES + lane) % SUM_SLOTS;
                sums[0][slot] += update.internal_energy.lane(lane);
                sums[1][slot] += update.plastic_dissipation.lane(lane);
                sums[2][slot] += update.viscous_energy.lane(lane);
                let extreme = |value: R| Extreme { value: value.lane(lane), hex };
                report.min_jacobian = report.min_jacobian.smaller(extreme(update.min_jacobian));
                report.stable_time_step = report.stable_time_step.smaller(extreme(update.stable_time_step));
                if !all_finite && report.not_finite.is_none() {
                    let marked = R::select(finite, R::splat(1.0), R::splat(0.0));
                    report.not_finite = (marked.lane(lane) == 0.0).then_some(hex);
                }
            }
        }
        let [internal_energy, plastic_dissipation, viscous_energy] = sums.map(|slots| slots.iter().sum());
        BlockReport { internal_energy, plastic_dissipation, viscous_energy, ..report }
    }
}

/// Means over the points of the elements of a chunk, as a user sees them.
struct MeansKernel<'a, M: Material, R: Real> {
    material: &'a M,
    hexes: &'a [u32],
    history: &'a [History<M, R>],
    means: Means<'a>,
}

impl<M: Material, R: Real> Kernel for MeansKernel<'_, M, R> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { material, hexes, history, means } = self;
        let Means { mut cauchy_stress, mut equivalent_plastic_strain } = means;
        let share = R::splat(1.0 / POINTS as f64);
        let mut lanes = [[0.0; MOST_LANES]; 6];
        for (pack, hexes_of_pack) in history.iter().zip(hexes.chunks(R::LANES)) {
            let places = || hexes_of_pack.iter().map(|hex| (hex - hexes[0]) as usize).enumerate();
            if let Some(field) = &mut cauchy_stress {
                let mut mean = SymmetricTensor::zero();
                for (state, rotation) in pack.states.iter().zip(&pack.rotations) {
                    mean = mean + material.output(state, &rotation.to_tensor()).cauchy_stress * share;
                }
                for (lanes, component) in lanes.iter_mut().zip(mean.0) {
                    component.store(lanes);
                }
                for (lane, place) in places() {
                    field[place] = array(|component| lanes[component][lane]);
                }
            }
            if let Some(field) = &mut equivalent_plastic_strain {
                let mut mean = R::splat(0.0);
                for state in &pack.states {
                    mean += material.equivalent_plastic_strain(state) * share;
                }
                mean.store(&mut lanes[0]);
                for (lane, place) in places() {
                    field[place] = lanes[0][lane];
                }
            }
        }
    }
}

/// The vectors of a field at the corners of the elements of a pack.
#[inline(always)]
fn gathered<R: Real>(field: &[[f64; 3]], connectivity: &[[u32; CORNERS]]) -> CornerVectors<R> {
    let mut corners = [Vector3::zero(); CORNERS];
    for (corner, vector) in corners.iter_mut().enumerate() {
        for (component, value) in vector.0.iter_mut().enumerate() {
            *value = R::from_lanes(|lane| field[connectivity[lane][corner] as usize][component]);
        }
    }
    corners
}
