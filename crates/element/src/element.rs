//! What a block of elements asks of an element.

use crate::bulk_viscosity::BulkViscosity;
use crate::hex8::{HexMotion, HexUpdate};
use estar_material::{Material, PointState};
use estar_tensor::{Real, Rotation};

/// What all elements of a block share in a step.
#[derive(Clone, Copy, Debug)]
pub struct ElementStep {
    /// Bulk viscosity, if any.
    pub bulk_viscosity: Option<BulkViscosity>,
    /// Δt from t_n to t_{n+1}, s.
    pub time_step: f64,
}

/// A hex of eight nodes with what is chosen of it.
pub trait Element: Copy + Send + Sync + 'static {
    /// Quadrature points.
    const POINTS: usize;

    /// History of an element of a material with the history `S` at a point.
    type History<R: Real, S: PointState<R>>: ElementHistory<R, S>;

    /// The history of elements that have not moved.
    fn initial_history<R: Real, M: Material>(material: &M, stable_time_step: f64) -> Self::History<R, M::State<R>>;

    /// One step of an element: stress and history at t_{n+1}, the internal force there, energies and the stable time step on the
    /// new geometry. `upcoming` is the history of the pack that comes next. Implementations are `#[inline(always)]`.
    fn advance<R: Real, M: Material>(
        self,
        material: &M,
        history: &mut Self::History<R, M::State<R>>,
        upcoming: Option<&Self::History<R, M::State<R>>>,
        motion: &HexMotion<R>,
        step: &ElementStep,
    ) -> HexUpdate<R>;
}

/// Work for any element: the way to all that is the same for every one.
pub trait ElementVisitor {
    /// What the work returns.
    type Output;

    /// Does the work for an element.
    fn visit<E: Element>(self, element: E) -> Self::Output;
}

/// The numbers of an element's history, in one fixed order.
pub trait ElementHistory<R: Real, S>: Copy + Send + Sync + 'static {
    /// History of the material at each point.
    fn states(&self) -> &[S];

    /// Rotation at each point.
    fn rotations(&self) -> &[Rotation<R>];

    /// Stable time step at t_n, s.
    fn stable_time_step(&self) -> R;

    /// Calls `visit` with every number.
    fn for_each(&self, visit: impl FnMut(R));

    /// The history whose numbers `next` gives in the order of [`ElementHistory::for_each`].
    fn from_numbers(next: impl FnMut() -> R) -> Self;

    /// `chosen` where the mask is set, else `otherwise`.
    fn select(mask: R::Mask, chosen: &Self, otherwise: &Self) -> Self;
}
