//! What the four-node tets of a material have between them: volume change and mean stress, averaged over nodes and back (see
//! [`tet4`]), however the material is cut into parts. As with forces, each patch sums in rows of its own and each node sums its
//! rows in one order.

use super::averages_task::Task;
use super::deletion::Life;
use super::element_block::Block;
use crate::assembly::RowLists;
use crate::patch::{MOST_LANES, PATCH, Patches};
use crate::patch_rows::{NodalMotion, PatchRows};
use estar_element::element::{ElementHistory, ElementMotion, Neighbourhood, OwnHistory};
use estar_element::tet4::{self, NODES, mean_stress_forces, volumes};
use estar_material::MaterialModel;
use estar_tensor::{Kernel, Real, Vector3};
use rayon::prelude::*;
use std::ops::Range;

/// Averages over the nodes of all tets of one material.
pub(crate) struct NodalAverages {
    members: Vec<Member>,
    /// Four sums for each node of each patch, block by block.
    rows: Vec<[f64; 4]>,
    lists: RowLists,
    /// Of each node of the mesh J^¼, Δt θ and σ; of one that is in no element 1, 0, 0.
    nodes: Vec<[f64; 3]>,
}

/// A block whose elements take part.
struct Member {
    /// Its place in the simulation.
    block: usize,
    /// Its rows here.
    rows: Range<usize>,
    /// Its rows among those of the forces of all blocks.
    force_rows: Range<usize>,
}

/// The packs of a block, in patches.
pub(crate) struct Packs<'a, Own, R: Real> {
    patches: &'a Patches,
    history: &'a mut [ElementHistory<R, Own>],
    lives: &'a [Vec<Life<R>>],
    element_count: usize,
}

impl<'a, Own, R: Real> Packs<'a, Own, R> {
    /// The packs of `element_count` elements.
    pub fn new(
        patches: &'a Patches,
        history: &'a mut [ElementHistory<R, Own>],
        lives: &'a [Vec<Life<R>>],
        element_count: usize,
    ) -> Self {
        Self { patches, history, lives, element_count }
    }
}

impl NodalAverages {
    /// Those of each material that has elements which share their volume change; `materials` are those of the blocks. Blocks of
    /// equal parameters are of one material.
    pub fn of_materials(materials: &[MaterialModel], blocks: &[Block], node_count: usize) -> Vec<Self> {
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for block in (0..blocks.len()).filter(|&block| blocks[block].elements.shares_volume()) {
            match groups.iter_mut().find(|group| materials[group[0]] == materials[block]) {
                Some(group) => group.push(block),
                None => groups.push(vec![block]),
            }
        }
        groups.iter().map(|group| Self::new(group, blocks, node_count)).collect()
    }

    /// Of elements of the blocks of a group that have not moved.
    fn new(group: &[usize], blocks: &[Block], node_count: usize) -> Self {
        let row_count = |block: &Block| block.elements.patches().row_count();
        let mut end = 0;
        let member = |&block: &usize| {
            let (start, first_force_row) = (end, blocks[..block].iter().map(row_count).sum::<usize>());
            end += row_count(&blocks[block]);
            Member { block, rows: start..end, force_rows: first_force_row..first_force_row + end - start }
        };
        let members: Vec<Member> = group.iter().map(member).collect();
        let rows = || {
            members.iter().flat_map(|Member { block, rows, .. }| {
                blocks[*block].elements.patches().rows().map(|(node, row)| (node, rows.start + row))
            })
        };
        let lists = RowLists::new(node_count, rows);
        Self { members, rows: vec![[0.0; 4]; end], lists, nodes: vec![[1.0, 0.0, 0.0]; node_count] }
    }

    /// Gives every element the volume change of its neighbourhood.
    pub fn share_volumes(&mut self, blocks: &mut [Block], motion: NodalMotion<'_>, time_step: f64) {
        self.visit(blocks, motion, Task::AddVolumes { time_step });
        let (rows, lists) = (&self.rows, &self.lists);
        self.nodes.par_iter_mut().with_min_len(PATCH).enumerate().for_each(|(node, average)| {
            let [reference, now, half, change] = lists.sums(rows, node);
            *average =
                if reference > 0.0 { [(now / reference).sqrt().sqrt(), change / half, 0.0] } else { [1.0, 0.0, 0.0] };
        });
        self.visit(blocks, motion, Task::TakeVolumes);
    }

    /// Adds the forces of the mean stress of every neighbourhood to those of the patches of all blocks.
    pub fn add_mean_stress_forces(
        &mut self,
        blocks: &mut [Block],
        motion: NodalMotion<'_>,
        patch_forces: &mut [[f64; 4]],
    ) {
        self.visit(blocks, motion, Task::AddStresses);
        let (rows, lists) = (&self.rows, &self.lists);
        self.nodes.par_iter_mut().with_min_len(PATCH).enumerate().for_each(|(node, average)| {
            let [weighted, volume, ..] = lists.sums(rows, node);
            average[2] = if volume > 0.0 { weighted / volume } else { 0.0 };
        });
        for Member { block, force_rows, .. } in &self.members {
            let forces = &mut patch_forces[force_rows.clone()];
            blocks[*block].elements.visit_neighbourhoods(Task::TakeStresses, motion, &self.nodes, forces);
        }
    }

    fn visit(&mut self, blocks: &mut [Block], motion: NodalMotion<'_>, task: Task) {
        for Member { block, rows, .. } in &self.members {
            let rows = &mut self.rows[rows.clone()];
            blocks[*block].elements.visit_neighbourhoods(task, motion, &self.nodes, rows);
        }
    }

    /// Bytes that a step reads and writes: rows and nodes of two means, and X, u, v and the mean of each node for four tasks.
    pub fn bytes_per_step(&self) -> usize {
        let node_vectors = 2 + 4 * 4;
        4 * size_of_val(&*self.rows) + 2 * self.lists.bytes_per_step() + node_vectors * size_of_val(&*self.nodes)
    }
}

impl<Own: OwnHistory<R>, R: Real> Packs<'_, Own, R> {
    /// Does a task with every element, in parallel patches.
    pub fn visit(&mut self, task: Task, motion: NodalMotion<'_>, averages: &[[f64; 3]], rows: &mut [[f64; 4]]) {
        let (patches, packs) = (self.patches, PATCH / R::LANES);
        let pack_corners = NODES * R::LANES;
        let element_count = self.element_count;
        let work = self
            .history
            .par_chunks_mut(packs)
            .zip(patches.corners().par_chunks(packs * pack_corners))
            .zip(rows.par_chunks_mut(patches.stride()))
            .zip(self.lives.par_iter())
            .enumerate();
        work.for_each(|(patch, (((history, corners), rows), lives))| {
            let nodes = patches.nodes(patch);
            PatchRows::of_motion_and(nodes, motion, averages, |of_nodes| {
                R::vectorize(PatchTask {
                    task,
                    of_nodes,
                    history,
                    lives,
                    element_count: (element_count - patch * PATCH).min(PATCH),
                    corners,
                    pack_corners,
                    rows: &mut rows[..nodes.len()],
                });
            });
        });
    }
}

/// The work of one thread at a time.
struct PatchTask<'a, Own, R: Real> {
    task: Task,
    of_nodes: PatchRows<'a, 4>,
    history: &'a mut [ElementHistory<R, Own>],
    lives: &'a [Life<R>],
    element_count: usize,
    corners: &'a [u16],
    pack_corners: usize,
    rows: &'a mut [[f64; 4]],
}

impl<Own: OwnHistory<R>, R: Real> Kernel for PatchTask<'_, Own, R> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { task, of_nodes, history, lives, element_count, corners, pack_corners, rows } = self;
        if matches!(task, Task::AddVolumes { .. } | Task::AddStresses) {
            rows.fill([0.0; 4]);
        }
        let zero = R::splat(0.0);
        let mut motion = ElementMotion::at_the_origin();
        let mut averages = [Vector3::zero(); NODES];
        let mut of_lanes = [[0.0; MOST_LANES]; 4];
        let mut force_lanes = [[[0.0; MOST_LANES]; 3]; NODES];
        for (pack, (history, corners)) in history.iter_mut().zip(corners.chunks_exact(pack_corners)).enumerate() {
            let is_deleted = lives.get(pack).map_or(zero.lt(zero), |life| life.deleted);
            let Some(shared) = history.own.neighbourhood_mut() else { continue };
            of_nodes.motion(corners, &mut motion, |corner, rows| averages[corner] = Vector3(rows[3]));
            let lane_count = R::LANES.min(element_count - pack * R::LANES);
            let added = match task {
                Task::AddVolumes { time_step } => {
                    let volumes = volumes(&motion, time_step);
                    [volumes.reference, volumes.now, volumes.half, volumes.change]
                }
                Task::AddStresses => {
                    let volume = tet4::volume(&motion.position);
                    [shared.mean_stress * volume, volume, zero, zero]
                }
                Task::TakeVolumes => {
                    take_volumes(shared, &averages);
                    continue;
                }
                Task::TakeStresses => {
                    let [a, b, c, d] = &averages;
                    let (a, b, c, d) = (a.0[2], b.0[2], c.0[2], d.0[2]);
                    let mean_stress = R::select(is_deleted, zero, ((a + b) + (c + d)) * 0.25);
                    shared.mean_stress = mean_stress;
                    let forces = mean_stress_forces(&motion.position, mean_stress);
                    for (lanes, force) in force_lanes.iter_mut().zip(&forces) {
                        for (lanes, component) in lanes.iter_mut().zip(force.0) {
                            component.store(lanes);
                        }
                    }
                    // element by element: the order of a sum is that of any number of lanes
                    for lane in 0..lane_count {
                        for (corner, lanes) in force_lanes.iter().enumerate() {
                            let row = &mut rows[corners[corner * R::LANES + lane] as usize];
                            for (sum, component) in row.iter_mut().zip(lanes) {
                                *sum -= component[lane];
                            }
                        }
                    }
                    continue;
                }
            };
            for (lanes, number) in of_lanes.iter_mut().zip(added) {
                R::select(is_deleted, zero, number).store(lanes);
            }
            for lane in 0..lane_count {
                for corner in 0..NODES {
                    let row = &mut rows[corners[corner * R::LANES + lane] as usize];
                    for (sum, number) in row.iter_mut().zip(&of_lanes) {
                        *sum += number[lane];
                    }
                }
            }
        }
    }
}

/// J̄ = (Π J_a)^¼, θ̄ = ¼ Σ θ_a.
#[inline(always)]
fn take_volumes<R: Real>(shared: &mut Neighbourhood<R>, averages: &[Vector3<R>; NODES]) {
    let [a, b, c, d] = averages;
    let (a, b, c, d) = (a.0, b.0, c.0, d.0);
    shared.jacobian = (a[0] * b[0]) * (c[0] * d[0]);
    shared.increment = ((a[1] + b[1]) + (c[1] + d[1])) * 0.25;
}
