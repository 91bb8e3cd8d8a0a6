//! What a block of elements asks of an element.

use crate::bulk_viscosity::BulkViscosity;
use estar_material::{Material, PointState};
use estar_tensor::{Real, Rotation, Vector3};

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
    /// ⅓ tr T of the element at t_{n+1}, Pa, the forces of which are left to who averages.
    pub mean_stress: R,
}

/// An element of so many nodes with what is chosen of it.
pub trait Element<const NODES: usize>: Copy + Send + Sync + 'static {
    /// Quadrature points.
    const POINTS: usize;

    /// Whether volume change and mean stress are averaged over neighbours, see [`Neighbourhood`].
    const SHARES_VOLUME: bool = false;

    /// Where the nodes of the parent element are.
    const PARENT: [[f64; 3]; NODES];

    /// History of an element of a material with the history `S` at a point.
    type History<R: Real, S: PointState<R>>: ElementHistory<R, S>;

    /// The history of elements that have not moved.
    fn initial_history<R: Real, M: Material>(material: &M, stable_time_step: f64) -> Self::History<R, M::State<R>>;

    /// Lumped mass of each node, kg.
    fn lumped_mass(reference: &[Vector3<f64>; NODES], density: f64) -> [f64; NODES];

    /// Smallest Jacobian of the points, and of the centre of a hex, on the parent element.
    fn smallest_jacobian(position: &[Vector3<f64>; NODES]) -> f64;

    /// One step of an element: stress and history at t_{n+1}, the internal force there, energies and the stable time step on the
    /// new geometry. `upcoming` is the history of the pack that comes next. Implementations are `#[inline(always)]`.
    fn advance<R: Real, M: Material>(
        self,
        material: &M,
        history: &mut Self::History<R, M::State<R>>,
        upcoming: Option<&Self::History<R, M::State<R>>>,
        motion: &ElementMotion<R, NODES>,
        step: &ElementStep,
    ) -> ElementUpdate<R, NODES>;
}

/// Work for any element: the way to all that is the same for every one.
pub trait ElementVisitor {
    /// What the work returns.
    type Output;

    /// Does the work for an element.
    fn visit<const NODES: usize, E: Element<NODES>>(self, element: E) -> Self::Output;
}

/// The numbers of an element's history, in one fixed order.
pub trait ElementHistory<R: Real, S>: Copy + Send + Sync + 'static {
    /// History of the material at each point.
    fn states(&self) -> &[S];

    /// Rotation at each point.
    fn rotations(&self) -> &[Rotation<R>];

    /// Stable time step at t_n, s.
    fn stable_time_step(&self) -> R;

    /// What the element shares with its neighbours; set before each step, so that it is no part of the numbers below.
    fn neighbourhood(&mut self) -> Option<&mut Neighbourhood<R>> {
        None
    }

    /// Calls `visit` with every number.
    fn for_each(&self, visit: impl FnMut(R));

    /// The history whose numbers `next` gives in the order of [`ElementHistory::for_each`].
    fn from_numbers(next: impl FnMut() -> R) -> Self;

    /// `chosen` where the mask is set, else `otherwise`.
    fn select(mask: R::Mask, chosen: &Self, otherwise: &Self) -> Self;
}
