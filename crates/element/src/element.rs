//! What a block of elements asks of an element.

use crate::bulk_viscosity::BulkViscosity;
use estar_material::points::{Bare, Exchange, PackPoints};
use estar_material::{IsotropicElasticity, PointState};
use estar_tensor::{Real, Vector3};

/// What all elements of a block share in a step.
#[derive(Clone, Copy, Debug)]
pub struct ElementStep {
    /// Bulk viscosity, if any.
    pub bulk_viscosity: Option<BulkViscosity>,
    /// Δt from t_n to t_{n+1}, s.
    pub time_step: f64,
}

/// Where the nodes of an element are, how they move and what they weigh.
#[derive(Clone, Copy, Debug)]
pub struct ElementMotion<R, const NODES: usize> {
    /// X, m.
    pub reference: [Vector3<R>; NODES],
    /// x_{n+1}, m.
    pub position: [Vector3<R>; NODES],
    /// v_{n+½}, m/s.
    pub velocity: [Vector3<R>; NODES],
    /// The smallest lumped mass of a corner, kg.
    pub corner_mass: R,
}

impl<R: Real, const NODES: usize> ElementMotion<R, NODES> {
    /// Nodes at the origin, at rest and without mass: to be filled in.
    #[inline(always)]
    pub fn at_the_origin() -> Self {
        let zero = [Vector3::zero(); NODES];
        Self { reference: zero, position: zero, velocity: zero, corner_mass: R::splat(0.0) }
    }
}

/// What a step gives.
#[derive(Clone, Copy, Debug)]
pub struct ElementUpdate<R, const NODES: usize> {
    /// Internal force on each node, f_a = ∫ T ∇N_a dV, N.
    pub internal_force: [Vector3<R>; NODES],
    /// Stress power of the step at the points, J.
    pub internal_energy: R,
    /// Its dissipated part, J.
    pub plastic_dissipation: R,
    /// Work of the step against bulk viscosity, J: on average a loss, in one step of either sign, since the pressure of
    /// t_{n+1} comes from the velocity of the half step before.
    pub viscous_energy: R,
    /// Work of the step against hourglass control, J.
    pub hourglass_energy: R,
    /// Smallest det F of the points, and of the centre of a hex.
    pub min_jacobian: R,
    /// Stable time step on the new geometry, s.
    pub stable_time_step: R,
}

/// Volume change and mean stress of an element that shares them with its neighbours.
#[derive(Clone, Copy, Debug)]
pub struct Neighbourhood<R> {
    /// det F̄ at t_{n+1}, averaged over the neighbours.
    pub jacobian: R,
    /// Δt tr D̄ at mid-step, averaged likewise.
    pub increment: R,
    /// ⅓ tr T at t_{n+1}, Pa: that of the element, the forces of which are left to who averages, and after that the mean over
    /// the neighbours, which acts.
    pub mean_stress: R,
}

impl<R: Real> PointState<R> for Neighbourhood<R> {
    /// The increment is of the step alone.
    fn for_each(&self, mut visit: impl FnMut(R)) {
        visit(self.jacobian);
        visit(self.mean_stress);
    }

    fn from_numbers(mut next: impl FnMut() -> R) -> Self {
        Self { jacobian: next(), mean_stress: next(), ..Self::at_rest() }
    }

    fn select(mask: R::Mask, chosen: &Self, otherwise: &Self) -> Self {
        Self {
            jacobian: R::select(mask, chosen.jacobian, otherwise.jacobian),
            increment: R::select(mask, chosen.increment, otherwise.increment),
            mean_stress: R::select(mask, chosen.mean_stress, otherwise.mean_stress),
        }
    }
}

impl<R: Real> OwnHistory<R> for Neighbourhood<R> {
    fn at_rest() -> Self {
        let zero = R::splat(0.0);
        Self { jacobian: R::splat(1.0), increment: zero, mean_stress: zero }
    }

    fn neighbourhood(&self) -> Option<&Self> {
        Some(self)
    }

    fn neighbourhood_mut(&mut self) -> Option<&mut Self> {
        Some(self)
    }
}

/// An element of so many nodes with what is chosen of it.
pub trait Element<const NODES: usize>: Copy + Send + Sync + 'static {
    /// Quadrature points.
    const POINTS: usize;

    /// Whether volume change and mean stress are averaged over neighbours, see [`Neighbourhood`].
    const SHARES_VOLUME: bool = false;

    /// Whether the time step of the assembled mesh can be taken from [`Element::linear_forces`]. Where it cannot, they still give the
    /// lowest frequencies.
    const HAS_LINEAR_FORCES: bool = false;

    /// Where the nodes of the parent element are.
    const PARENT: [[f64; 3]; NODES];

    /// What an element keeps besides the common numbers of [`ElementHistory`].
    type Own<R: Real>: OwnHistory<R>;

    /// Lumped mass of each node, kg.
    fn lumped_mass(reference: &[Vector3<f64>; NODES], density: f64) -> [f64; NODES];

    /// Smallest Jacobian of the points, and of the centre of a hex, on the parent element.
    fn smallest_jacobian(position: &[Vector3<f64>; NODES]) -> f64;

    /// One step of an element with these elastic constants: history and stress of its points at t_{n+1}, the internal force there,
    /// energies and the stable time step on the new geometry. Implementations are `#[inline(always)]`.
    fn advance<R: Real>(
        self,
        elasticity: &IsotropicElasticity,
        points: PackPoints<'_, R>,
        history: &mut ElementHistory<R, Self::Own<R>>,
        motion: &ElementMotion<R, NODES>,
        step: &ElementStep,
    ) -> ElementUpdate<R, NODES>;

    /// Whether it damps without bulk viscosity.
    fn is_damped(self) -> bool {
        false
    }

    /// What the linear forces need besides the geometry, at t_n, of an element with this stable time step (s). `step.time_step` is the
    /// Δt of K + 2C/Δt.
    fn tangent<R: Real>(
        self,
        elasticity: &IsotropicElasticity,
        stable_time_step: R,
        motion: &ElementMotion<R, NODES>,
        step: &ElementStep,
    ) -> Tangent<R>;

    /// Forces (K + 2C/Δt) u of the displacement u about the corners at `position`: of stiffness as if nothing yielded, of
    /// linear damping, and without the stiffness of stress itself; of operators that are not symmetric their symmetric part.
    /// Implementations are `#[inline(always)]`.
    fn linear_forces<R: Real>(
        self,
        elasticity: &IsotropicElasticity,
        tangent: &Tangent<R>,
        position: &[Vector3<R>; NODES],
        displacement: &[Vector3<R>; NODES],
    ) -> [Vector3<R>; NODES];
}

/// What the linear forces of an element depend on besides its elastic constants and its geometry.
#[derive(Clone, Copy, Debug)]
pub struct Tangent<R> {
    /// Factor on the elastic constants, see [`Material::stiffening`](estar_material::Material::stiffening).
    pub stiffening: R,
    /// Modulus 2 η/Δt of bulk viscosity with the pressure −η tr D, Pa.
    pub viscous_modulus: R,
    /// Force on each hourglass mode over its motion, N/m, where that is one number: damping counts 2/Δt-fold.
    pub hourglass_modulus: R,
}

impl<R: Real> Tangent<R> {
    /// Of an element that is not there.
    pub fn none() -> Self {
        let zero = R::splat(0.0);
        Self { stiffening: zero, viscous_modulus: zero, hourglass_modulus: zero }
    }

    /// `chosen` where the mask is set, else `otherwise`.
    #[inline(always)]
    pub fn select(mask: R::Mask, chosen: &Self, otherwise: &Self) -> Self {
        Self {
            stiffening: R::select(mask, chosen.stiffening, otherwise.stiffening),
            viscous_modulus: R::select(mask, chosen.viscous_modulus, otherwise.viscous_modulus),
            hourglass_modulus: R::select(mask, chosen.hourglass_modulus, otherwise.hourglass_modulus),
        }
    }
}

/// By how much the material has stiffened the element: the square of what its stable time step would be over what it is.
#[inline(always)]
pub(crate) fn stiffening<E: Element<NODES>, R: Real, const NODES: usize>(
    element: E,
    elasticity: &IsotropicElasticity,
    stable_time_step: R,
    motion: &ElementMotion<R, NODES>,
) -> R {
    let mut unstiffened = ElementHistory::new(0.0);
    let at_rest = ElementMotion { reference: motion.position, velocity: [Vector3::zero(); NODES], ..*motion };
    let no_step = ElementStep { bulk_viscosity: None, time_step: 0.0 };
    let points = PackPoints { points: &mut Bare, pack: 0, exchange: &mut Exchange::new() };
    element.advance(elasticity, points, &mut unstiffened, &at_rest, &no_step);
    let ratio = unstiffened.stable_time_step / stable_time_step;
    ratio * ratio
}

/// Work for any element: the way to all that is the same for every one.
pub trait ElementVisitor {
    /// What the work returns.
    type Output;

    /// Does the work for an element.
    fn visit<const NODES: usize, E: Element<NODES>>(self, element: E) -> Self::Output;
}

/// What an element keeps from step to step; its points keep their own.
#[derive(Clone, Copy, Debug)]
pub struct ElementHistory<R, Own> {
    /// Stable time step at t_n, s.
    pub stable_time_step: R,
    /// Pressure of bulk viscosity at t_n, Pa.
    pub viscous_pressure: R,
    /// What only elements of its kind keep.
    pub own: Own,
}

/// The numbers of a history that only one kind of element has.
pub trait OwnHistory<R: Real>: PointState<R> {
    /// That of an element that has not moved.
    fn at_rest() -> Self;

    /// What the element shares with its neighbours.
    fn neighbourhood(&self) -> Option<&Neighbourhood<R>> {
        None
    }

    /// The same, for who averages.
    fn neighbourhood_mut(&mut self) -> Option<&mut Neighbourhood<R>> {
        None
    }
}

impl<R: Real> OwnHistory<R> for () {
    fn at_rest() -> Self {}
}

impl<R: Real, Own: OwnHistory<R>> ElementHistory<R, Own> {
    /// That of an element that has not moved and has this stable time step (s).
    pub fn new(stable_time_step: f64) -> Self {
        Self { stable_time_step: R::splat(stable_time_step), viscous_pressure: R::splat(0.0), own: Own::at_rest() }
    }

    /// Calls `visit` with every number.
    pub fn for_each(&self, mut visit: impl FnMut(R)) {
        visit(self.stable_time_step);
        visit(self.viscous_pressure);
        self.own.for_each(visit);
    }

    /// The history whose numbers `next` gives in the order of [`ElementHistory::for_each`].
    pub fn from_numbers(mut next: impl FnMut() -> R) -> Self {
        Self { stable_time_step: next(), viscous_pressure: next(), own: Own::from_numbers(next) }
    }

    /// `chosen` where the mask is set, else `otherwise`.
    pub fn select(mask: R::Mask, chosen: &Self, otherwise: &Self) -> Self {
        Self {
            stable_time_step: R::select(mask, chosen.stable_time_step, otherwise.stable_time_step),
            viscous_pressure: R::select(mask, chosen.viscous_pressure, otherwise.viscous_pressure),
            own: Own::select(mask, &chosen.own, &otherwise.own),
        }
    }
}
