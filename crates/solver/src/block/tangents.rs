//! The linear forces of a block: what they depend on, and their sums on the nodes. The material is its elastic constants, so that
//! this is compiled once for each element and not for each material.

use super::deletion::rest;
use super::patch_kernel::subtract;
use crate::patch::{MOST_LANES, PATCH, Patches};
use crate::patch_rows::{NodalMotion, PatchRows};
use estar_element::element::{Element, ElementMotion, ElementStep, Tangent};
use estar_material::IsotropicElasticity;
use estar_tensor::{Kernel, Real};
use rayon::prelude::*;

/// A pack of elements in linear motion.
#[derive(Clone, Copy)]
pub(crate) struct LinearPack<R: Real> {
    /// Elements that are there no more.
    pub deleted: R::Mask,
    /// On its last geometry, s.
    pub stable_time_step: R,
    pub tangent: Tangent<R>,
}

/// A block of elements in linear motion.
#[derive(Clone, Copy)]
pub(crate) struct Linear<'a, E, const NODES: usize> {
    pub element: E,
    pub elasticity: &'a IsotropicElasticity,
    pub patches: &'a Patches,
}

impl<E: Element<NODES>, const NODES: usize> Linear<'_, E, NODES> {
    /// Finds the tangents of all packs at t_n with the damping of the step.
    pub fn find_tangents<R: Real>(
        self,
        motion: NodalMotion<'_>,
        step: &ElementStep,
        corner_mass: &[R],
        linear: &mut [LinearPack<R>],
    ) {
        let Self { element, elasticity, patches } = self;
        let packs = PATCH / R::LANES;
        let corners = patches.corners().par_chunks(packs * NODES * R::LANES);
        let work = linear.par_chunks_mut(packs).zip(corners).zip(corner_mass.par_chunks(packs)).enumerate();
        work.for_each(|(patch, ((linear, corners), corner_mass))| {
            PatchRows::of_motion(patches.nodes(patch), motion, |rows| {
                let places = Places { rows, corners };
                R::vectorize(TangentKernel { element, elasticity, places, step, corner_mass, linear });
            });
        });
    }

    /// Writes −(K + 2C/Δt) z to the rows of the patches, z for the velocity of the motion.
    pub fn apply_tangents<R: Real>(
        self,
        motion: NodalMotion<'_>,
        members: &[u32],
        linear: &[LinearPack<R>],
        patch_forces: &mut [[f64; 4]],
    ) {
        let Self { element, elasticity, patches } = self;
        let packs = PATCH / R::LANES;
        let work = patch_forces
            .par_chunks_mut(patches.stride())
            .zip(members.par_chunks(PATCH))
            .zip(patches.corners().par_chunks(packs * NODES * R::LANES))
            .zip(linear.par_chunks(packs))
            .enumerate();
        work.for_each(|(patch, (((forces, members), corners), linear))| {
            let nodes = patches.nodes(patch);
            PatchRows::of_motion(nodes, motion, |rows| {
                let (places, forces) = (Places { rows, corners }, &mut forces[..nodes.len()]);
                R::vectorize(LinearKernel { element, elasticity, places, count: members.len(), linear, forces });
            });
        });
    }
}

/// Where the nodes of a patch are and how they move.
struct Places<'a, const NODES: usize> {
    rows: PatchRows<'a, 3>,
    corners: &'a [u16],
}

impl<const NODES: usize> Places<'_, NODES> {
    /// The motion of a pack; deleted elements stand still where they began.
    #[inline(always)]
    fn motion<R: Real>(&self, pack: usize, deleted: R::Mask, corner_mass: R) -> ElementMotion<R, NODES> {
        let count = NODES * R::LANES;
        let mut motion = ElementMotion { corner_mass, ..ElementMotion::at_the_origin() };
        self.rows.motion(&self.corners[pack * count..(pack + 1) * count], &mut motion, |_, _| ());
        rest(deleted, &mut motion);
        motion
    }
}

/// Finds the tangents of a patch.
struct TangentKernel<'a, E, R: Real, const NODES: usize> {
    element: E,
    elasticity: &'a IsotropicElasticity,
    places: Places<'a, NODES>,
    step: &'a ElementStep,
    corner_mass: &'a [R],
    linear: &'a mut [LinearPack<R>],
}

impl<E: Element<NODES>, R: Real, const NODES: usize> Kernel for TangentKernel<'_, E, R, NODES> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (pack, linear) in self.linear.iter_mut().enumerate() {
            let stable_time_step = linear.stable_time_step;
            let motion = self.places.motion(pack, linear.deleted, self.corner_mass[pack]);
            let tangent = self.element.tangent(self.elasticity, stable_time_step, &motion, self.step);
            linear.tangent = Tangent::select(linear.deleted, &Tangent::none(), &tangent);
        }
    }
}

/// Linear forces of a patch.
struct LinearKernel<'a, E, R: Real, const NODES: usize> {
    element: E,
    elasticity: &'a IsotropicElasticity,
    places: Places<'a, NODES>,
    /// Elements.
    count: usize,
    linear: &'a [LinearPack<R>],
    forces: &'a mut [[f64; 4]],
}

impl<E: Element<NODES>, R: Real, const NODES: usize> Kernel for LinearKernel<'_, E, R, NODES> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let mut corner_forces = [[[0.0; 4]; NODES]; MOST_LANES];
        self.forces.fill([0.0; 4]);
        let corners = self.places.corners.chunks_exact(NODES * R::LANES);
        for ((pack, linear), corners) in self.linear.iter().enumerate().zip(corners) {
            let motion = self.places.motion::<R>(pack, linear.deleted, R::splat(0.0));
            let forces =
                self.element.linear_forces(self.elasticity, &linear.tangent, &motion.position, &motion.velocity);
            for (corner, force) in forces.iter().enumerate() {
                R::scatter(force.0, &mut corner_forces.as_flattened_mut()[corner..], NODES);
            }
            let lanes = (self.count - pack * R::LANES).min(R::LANES);
            subtract::<R, NODES>(self.forces, &corner_forces[..lanes], corners);
        }
    }
}
