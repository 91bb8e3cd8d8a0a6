//! The seam between elements and materials: the points of a patch of elements, met once a pack.
//!
//! An element and a material know each other by one virtual call for all points of a pack of elements: gradients in, stresses
//! and energies out. So elements and materials are compiled side by side, and not each element with each material. Histories and
//! rotations live here, with the material.

use crate::kinematics::{Motion, StepKinematics};
use crate::material::{Material, MaterialModel, MaterialVisitor, PointState};
use arrayvec::ArrayVec;
use estar_tensor::{
    Counted, Kernel, LaneLevel, Real, Rotation, SymmetricTensor, Tensor, WithLanes, array, dispatch, prefetch,
};
use std::any::{Any, TypeId};
use std::marker::PhantomData;
use std::ops::Range;
use std::sync::Arc;

/// No element has more quadrature points.
pub const MOST_POINTS: usize = 8;

/// The motion of one point in a step, as its element has made it.
#[derive(Clone, Copy, Debug)]
pub struct PointMotion<R> {
    /// Δt L with L = ∂v/∂x at mid-step and the volume change that the element chooses.
    pub incremental_displacement_gradient: Tensor<R>,
    /// c F_{n+1} with any c > 0: what has the rotation of F. Needed where [`Needs::rotation`] or [`Exchange::tells_flow`].
    pub scaled_gradient: Tensor<R>,
    /// F_{n+1} with the volume change that the element chooses. Needed where [`Needs::deformation_gradient`].
    pub deformation_gradient: Tensor<R>,
    /// What the point's energies per volume are multiplied by: its part of the volume at mid-step.
    pub volume_half: R,
}

/// What materials need of the motion besides Δt L.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Needs {
    /// [`PointMotion::scaled_gradient`].
    pub rotation: bool,
    /// [`PointMotion::deformation_gradient`].
    pub deformation_gradient: bool,
}

/// What an element and the material of its points tell each other in a step. Lists have an entry for each point.
#[derive(Clone, Debug)]
pub struct Exchange<R> {
    /// How the points move. From the element.
    pub motions: [PointMotion<R>; MOST_POINTS],
    /// Whether the element wants [`Exchange::rotations`] and [`Exchange::flow`]. From the element.
    pub tells_flow: bool,
    /// Cauchy stress T_{n+1}, Pa.
    pub stresses: [SymmetricTensor<R>; MOST_POINTS],
    /// R_n and R_{n+1}.
    pub rotations: [[Rotation<R>; 2]; MOST_POINTS],
    /// Δε̄ᵖ.
    pub flow: [R; MOST_POINTS],
}

impl<R: Real> Exchange<R> {
    /// With nothing in it yet.
    pub fn new() -> Self {
        let zero = R::splat(0.0);
        let motion = PointMotion {
            incremental_displacement_gradient: Tensor::zero(),
            scaled_gradient: Tensor::zero(),
            deformation_gradient: Tensor::zero(),
            volume_half: zero,
        };
        Self {
            motions: [motion; MOST_POINTS],
            tells_flow: false,
            stresses: [SymmetricTensor::zero(); MOST_POINTS],
            rotations: [[Rotation::identity(); 2]; MOST_POINTS],
            flow: [zero; MOST_POINTS],
        }
    }
}

impl<R: Real> Default for Exchange<R> {
    fn default() -> Self {
        Self::new()
    }
}

/// What the points of a pack give in a step, summed over the points.
#[derive(Clone, Copy, Debug)]
pub struct PointsUpdate<R> {
    /// Stress power, times [`PointMotion::volume_half`], J.
    pub internal_energy: R,
    /// Its dissipated part, J.
    pub plastic_dissipation: R,
    /// The greatest [`Material::stiffening`], where the material has one.
    pub stiffening: Option<R>,
}

/// Extremes over points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointExtremes {
    /// Largest equivalent plastic strain.
    pub plastic_strain: f64,
    /// Highest temperature, K; −∞ where the material has none.
    pub temperature: f64,
}

impl PointExtremes {
    /// Of no point.
    pub const NONE: Self = Self { plastic_strain: 0.0, temperature: f64::NEG_INFINITY };

    /// Of these points and others.
    pub fn and(self, other: Self) -> Self {
        Self {
            plastic_strain: self.plastic_strain.max(other.plastic_strain),
            temperature: self.temperature.max(other.temperature),
        }
    }
}

/// The points of packs of elements, whatever their material. A method is called once a pack at most.
pub trait MaterialPoints<R: Real>: Send + Sync {
    /// As many packs of the same material, undeformed.
    fn of_packs(&self, pack_count: usize) -> Box<dyn MaterialPoints<R>>;

    /// What the material needs of the motion.
    fn needs(&self) -> Needs;

    /// Takes the points of a pack to t_{n+1}, Δt = `time_step` (s) after t_n.
    fn update(&mut self, pack: usize, exchange: &mut Exchange<R>, time_step: f64) -> PointsUpdate<R>;

    /// Makes the points of a pack undeformed in the lanes of the mask.
    fn reset(&mut self, pack: usize, lanes: R::Mask);

    /// Mean of T over the points of a pack, Pa.
    fn mean_stress(&self, pack: usize) -> SymmetricTensor<R>;

    /// Mean of ε̄ᵖ over the points of a pack.
    fn mean_plastic_strain(&self, pack: usize) -> R;

    /// Mean temperature of the points of a pack, K; not a number where the material has none.
    fn mean_temperature(&self, pack: usize) -> R;

    /// Extremes over all points.
    fn extremes(&self) -> PointExtremes;

    /// Calls `visit` with every number of the points of a pack.
    fn for_each(&self, pack: usize, visit: &mut dyn FnMut(R));

    /// Gives the points of a pack the numbers that `next` gives in the order of [`MaterialPoints::for_each`].
    fn restore(&mut self, pack: usize, next: &mut dyn FnMut() -> R);

    /// Bytes of the histories.
    fn bytes(&self) -> usize;
}

/// The points of one pack, as an element drives them.
pub struct PackPoints<'a, R: Real> {
    /// The points of this and of other packs.
    pub points: &'a mut dyn MaterialPoints<R>,
    /// The pack.
    pub pack: usize,
    /// What is told, and written over by every step.
    pub exchange: &'a mut Exchange<R>,
}

impl<R: Real> PackPoints<'_, R> {
    /// Takes the points to t_{n+1}, Δt = `time_step` (s) after t_n.
    #[inline(always)]
    pub fn update(&mut self, time_step: f64) -> PointsUpdate<R> {
        self.points.update(self.pack, self.exchange, time_step)
    }
}

/// Points of packs of elements of one material, and their histories. A pack has one or several groups of `POINTS` points, which are
/// updated side by side: many short chains of operations keep the processor busier than one long chain a point.
#[derive(Clone)]
pub struct StoredPoints<M: Material, R: Real, const POINTS: usize> {
    material: Arc<M>,
    /// Groups of each pack.
    group_count: usize,
    states: Vec<[M::State<R>; POINTS]>,
    /// R_n, the first guesses of the next polar decompositions; none where nobody needs any.
    rotations: Vec<[Rotation<R>; POINTS]>,
}

impl<M: Material, R: Real, const POINTS: usize> StoredPoints<M, R, POINTS> {
    /// Undeformed points.
    pub fn new(material: Arc<M>, group_count: usize, pack_count: usize) -> Self {
        let (states, rotations) = ([material.initial_state(); POINTS], [Rotation::identity(); POINTS]);
        let count = group_count * pack_count;
        Self { material, group_count, states: vec![states; count], rotations: vec![rotations; count] }
    }

    /// Where the groups of a pack are.
    fn groups(&self, pack: usize) -> Range<usize> {
        pack * self.group_count..(pack + 1) * self.group_count
    }

    /// The histories of the points, group by group.
    pub fn states(&self) -> &[[M::State<R>; POINTS]] {
        &self.states
    }

    /// The rotations of the points, group by group.
    pub fn rotations(&self) -> &[[Rotation<R>; POINTS]] {
        &self.rotations
    }

    /// Mean of a number of the points of a pack.
    fn mean(&self, pack: usize, number: impl Fn(&M::State<R>) -> R) -> R {
        let share = R::splat(1.0 / (POINTS * self.group_count) as f64);
        let mut mean = R::splat(0.0);
        for state in self.states[self.groups(pack)].as_flattened() {
            mean += number(state) * share;
        }
        mean
    }
}

impl<M: Material, R: Real, const POINTS: usize> MaterialPoints<R> for StoredPoints<M, R, POINTS> {
    fn of_packs(&self, pack_count: usize) -> Box<dyn MaterialPoints<R>> {
        Box::new(Self::new(self.material.clone(), self.group_count, pack_count))
    }

    fn needs(&self) -> Needs {
        Needs {
            rotation: M::Motion::<R>::NEEDS_ROTATION,
            deformation_gradient: M::Motion::<R>::NEEDS_DEFORMATION_GRADIENT,
        }
    }

    fn update(&mut self, pack: usize, exchange: &mut Exchange<R>, time_step: f64) -> PointsUpdate<R> {
        let zero = R::splat(0.0);
        let mut total = PointsUpdate { internal_energy: zero, plastic_dissipation: zero, stiffening: None };
        for (place, group) in self.groups(pack).enumerate() {
            // what comes into the cache meanwhile is the same group of the next pack
            let (states, states_later) = self.states[group..].split_at_mut(1);
            let (rotations, rotations_later) = self.rotations[group..].split_at_mut(1);
            let ahead = self.group_count - 1;
            R::vectorize(Update {
                material: &*self.material,
                states: &mut states[0],
                rotations: &mut rotations[0],
                upcoming_states: states_later.get(ahead),
                upcoming_rotations: rotations_later.get(ahead),
                exchange,
                first: place * POINTS,
                time_step,
                total: &mut total,
            });
        }
        total
    }

    fn reset(&mut self, pack: usize, lanes: R::Mask) {
        let initial = self.material.initial_state();
        let Rotation(identity) = Rotation::identity();
        let groups = self.groups(pack);
        for state in self.states[groups.clone()].as_flattened_mut() {
            *state = M::State::select(lanes, &initial, state);
        }
        for Rotation(rotation) in self.rotations[groups].as_flattened_mut() {
            *rotation = array(|i| R::select(lanes, identity[i], rotation[i]));
        }
    }

    fn mean_stress(&self, pack: usize) -> SymmetricTensor<R> {
        R::vectorize(MeanStress { points: self, pack })
    }

    fn mean_plastic_strain(&self, pack: usize) -> R {
        self.mean(pack, |state| self.material.equivalent_plastic_strain(state))
    }

    fn mean_temperature(&self, pack: usize) -> R {
        let none = R::splat(f64::NAN);
        self.mean(pack, |state| self.material.temperature(state).unwrap_or(none))
    }

    fn extremes(&self) -> PointExtremes {
        let states = || self.states.as_flattened().iter();
        PointExtremes {
            plastic_strain: largest(states().map(|state| self.material.equivalent_plastic_strain(state))),
            temperature: largest(states().filter_map(|state| self.material.temperature(state))),
        }
    }

    fn for_each(&self, pack: usize, visit: &mut dyn FnMut(R)) {
        let groups = self.groups(pack);
        let (states, rotations) = (&self.states[groups.clone()], &self.rotations[groups]);
        for (state, rotation) in states.as_flattened().iter().zip(rotations.as_flattened()) {
            state.for_each(&mut *visit);
            rotation.0.into_iter().for_each(&mut *visit);
        }
    }

    fn restore(&mut self, pack: usize, next: &mut dyn FnMut() -> R) {
        let groups = self.groups(pack);
        let (states, rotations) = (&mut self.states[groups.clone()], &mut self.rotations[groups]);
        for (state, rotation) in states.as_flattened_mut().iter_mut().zip(rotations.as_flattened_mut()) {
            *state = M::State::from_numbers(&mut *next);
            *rotation = Rotation(array(|_| next()));
        }
    }

    fn bytes(&self) -> usize {
        size_of_val(&*self.states) + size_of_val(&*self.rotations)
    }
}

/// The largest lane of all numbers; −∞ of none.
fn largest<R: Real>(numbers: impl Iterator<Item = R>) -> f64 {
    numbers.reduce(R::max).map_or(f64::NEG_INFINITY, |largest| {
        (0..R::LANES).map(|lane| largest.lane(lane)).fold(f64::NEG_INFINITY, f64::max)
    })
}

struct Update<'a, M: Material, R: Real, const POINTS: usize> {
    material: &'a M,
    states: &'a mut [M::State<R>; POINTS],
    rotations: &'a mut [Rotation<R>; POINTS],
    /// Of the next pack.
    upcoming_states: Option<&'a [M::State<R>; POINTS]>,
    upcoming_rotations: Option<&'a [Rotation<R>; POINTS]>,
    exchange: &'a mut Exchange<R>,
    /// Place of the first point of the group in the exchange.
    first: usize,
    time_step: f64,
    total: &'a mut PointsUpdate<R>,
}

impl<M: Material, R: Real, const POINTS: usize> Kernel for Update<'_, M, R, POINTS> {
    type Output = ();

    /// Each stage takes all points of the group before the next. Meanwhile the histories of the next pack come into the cache, a
    /// part of them with each point, since all at once would wait for the memory.
    #[inline(always)]
    fn run(self) {
        let Self { material, states, rotations, exchange, first, time_step, total, .. } = self;
        let Exchange { motions, tells_flow, stresses, rotations: turns, flow } = exchange;
        let motions: &[PointMotion<R>; POINTS] = motions[first..].first_chunk().expect("a motion for each point");
        let stresses: &mut [_; POINTS] = stresses[first..].first_chunk_mut().expect("a stress for each point");
        let turns: &mut [_; POINTS] = turns[first..].first_chunk_mut().expect("rotations of each point");
        let flow: &mut [_; POINTS] = flow[first..].first_chunk_mut().expect("a flow for each point");
        let turns_points = M::Motion::<R>::NEEDS_ROTATION || *tells_flow;

        // (i) R of the polar decomposition
        let mut rotations_new = ArrayVec::<Rotation<R>, POINTS>::new();
        for point in 0..POINTS {
            if let Some(upcoming) = self.upcoming_states {
                prefetch(&upcoming[point]);
            }
            rotations_new.push(if turns_points {
                Rotation::nearest(&motions[point].scaled_gradient, rotations[point])
            } else {
                Rotation::identity()
            });
        }

        // (ii) the motion that the material sees
        let mut seen = ArrayVec::<M::Motion<R>, POINTS>::new();
        for point in 0..POINTS {
            let (mut rotation_old, rotation_new) = (Rotation::identity(), rotations_new[point]);
            if turns_points {
                if let Some(upcoming) = self.upcoming_rotations {
                    prefetch(&upcoming[point]);
                }
                rotation_old = std::mem::replace(&mut rotations[point], rotation_new);
            }
            seen.push(M::Motion::new(&StepKinematics {
                incremental_displacement_gradient: motions[point].incremental_displacement_gradient,
                deformation_gradient: motions[point].deformation_gradient,
                rotation_old,
                rotation_new,
            }));
            if *tells_flow {
                turns[point] = [rotation_old, rotation_new];
            }
        }

        // (iii) history, ∫ T : D dV over the step on the mid-step volume, and T
        let PointsUpdate { internal_energy, plastic_dissipation, stiffening } = total;
        for point in 0..POINTS {
            let state = &mut states[point];
            let update = material.update(state, &seen[point], time_step);
            if *tells_flow {
                let strain_old = material.equivalent_plastic_strain(state);
                flow[point] = material.equivalent_plastic_strain(&update.state) - strain_old;
            }
            *state = update.state;
            if let Some(ratio) = material.stiffening(state, &seen[point]) {
                *stiffening = Some(stiffening.map_or(ratio, |largest| largest.max(ratio)));
            }
            let volume_half = motions[point].volume_half;
            *internal_energy = update.internal_energy.mul_add(volume_half, *internal_energy);
            *plastic_dissipation = update.plastic_dissipation.mul_add(volume_half, *plastic_dissipation);
            stresses[point] = material.cauchy_stress(state, rotations_new[point]);
        }
    }
}

struct MeanStress<'a, M: Material, R: Real, const POINTS: usize> {
    points: &'a StoredPoints<M, R, POINTS>,
    pack: usize,
}

impl<M: Material, R: Real, const POINTS: usize> Kernel for MeanStress<'_, M, R, POINTS> {
    type Output = SymmetricTensor<R>;

    #[inline(always)]
    fn run(self) -> SymmetricTensor<R> {
        let StoredPoints { material, group_count, states, rotations } = self.points;
        let groups = self.points.groups(self.pack);
        let share = R::splat(1.0 / (POINTS * group_count) as f64);
        let mut mean = SymmetricTensor::zero();
        let (states, rotations) = (states[groups.clone()].as_flattened(), rotations[groups].as_flattened());
        for (state, rotation) in states.iter().zip(rotations) {
            mean = mean + material.cauchy_stress(state, *rotation) * share;
        }
        mean
    }
}

/// Points that bear nothing and keep nothing, for what depends on the geometry of an element alone.
pub struct Bare;

impl<R: Real> MaterialPoints<R> for Bare {
    fn of_packs(&self, _: usize) -> Box<dyn MaterialPoints<R>> {
        Box::new(Self)
    }

    fn needs(&self) -> Needs {
        Needs { rotation: false, deformation_gradient: false }
    }

    fn update(&mut self, _: usize, exchange: &mut Exchange<R>, _: f64) -> PointsUpdate<R> {
        R::vectorize(BareUpdate(exchange))
    }

    fn reset(&mut self, _: usize, _: R::Mask) {}

    fn mean_stress(&self, _: usize) -> SymmetricTensor<R> {
        SymmetricTensor::zero()
    }

    fn mean_plastic_strain(&self, _: usize) -> R {
        R::splat(0.0)
    }

    fn mean_temperature(&self, _: usize) -> R {
        R::splat(f64::NAN)
    }

    fn extremes(&self) -> PointExtremes {
        PointExtremes::NONE
    }

    fn for_each(&self, _: usize, _: &mut dyn FnMut(R)) {}

    fn restore(&mut self, _: usize, _: &mut dyn FnMut() -> R) {}

    fn bytes(&self) -> usize {
        0
    }
}

struct BareUpdate<'a, R>(&'a mut Exchange<R>);

impl<R: Real> Kernel for BareUpdate<'_, R> {
    type Output = PointsUpdate<R>;

    #[inline(always)]
    fn run(self) -> PointsUpdate<R> {
        let zero = R::splat(0.0);
        let Exchange { motions, tells_flow, stresses, rotations, flow } = self.0;
        *stresses = [SymmetricTensor::zero(); MOST_POINTS];
        if *tells_flow {
            let at_rest = Rotation::identity();
            rotations[0] = [at_rest, Rotation::nearest(&motions[0].scaled_gradient, at_rest)];
            *flow = [zero; MOST_POINTS];
        }
        PointsUpdate { internal_energy: zero, plastic_dissipation: zero, stiffening: None }
    }
}

impl MaterialModel {
    /// Points of this material, `point_count` to a pack, none yet: [`MaterialPoints::of_packs`] makes them. All that is compiled for
    /// a theory is compiled in this crate.
    ///
    /// # Panics
    /// A number of points that no element has, or numbers of a type that [`dispatch`] does not make, [`Counted`] excepted.
    pub fn points<R: Real>(&self, point_count: usize) -> Box<dyn MaterialPoints<R>> {
        let points = if TypeId::of::<R>() == TypeId::of::<Counted>() {
            self.counted(point_count)
        } else {
            self.on_lanes(R::LEVEL, point_count)
        };
        *points.downcast().expect("points of these numbers")
    }

    /// `Box<dyn MaterialPoints<Counted>>`.
    fn counted(&self, point_count: usize) -> Box<dyn Any> {
        OfModel { model: self, point_count }.with_lanes::<Counted>()
    }

    /// `Box<dyn MaterialPoints<R>>` for the lanes of a level.
    fn on_lanes(&self, level: LaneLevel, point_count: usize) -> Box<dyn Any> {
        dispatch(level, OfModel { model: self, point_count })
    }
}

struct OfModel<'a> {
    model: &'a MaterialModel,
    point_count: usize,
}

impl WithLanes for OfModel<'_> {
    type Output = Box<dyn Any>;

    fn with_lanes<R: Real>(self) -> Box<dyn Any> {
        self.model.visit(OnNumbers::<R> { point_count: self.point_count, numbers: PhantomData })
    }
}

struct OnNumbers<R> {
    point_count: usize,
    numbers: PhantomData<R>,
}

impl<R: Real> MaterialVisitor for OnNumbers<R> {
    type Output = Box<dyn Any>;

    fn visit<M: Material>(self, material: &M) -> Box<dyn Any> {
        let material = Arc::new(material.clone());
        let points: Box<dyn MaterialPoints<R>> = match self.point_count {
            1 => Box::new(StoredPoints::<M, R, 1>::new(material, 1, 0)),
            4 => Box::new(StoredPoints::<M, R, 4>::new(material, 1, 0)),
            8 => Box::new(StoredPoints::<M, R, 4>::new(material, 2, 0)),
            other => panic!("no element has {other} points"),
        };
        Box::new(points)
    }
}
