//! What a block of elements asks of an element.

use crate::bulk_viscosity::BulkViscosity;
use crate::hex8::{CORNERS, CornerVectors, HexMotion, HexUpdate};
use estar_material::{Elastic, IsotropicElasticity, Material, PointState};
use estar_tensor::{Real, Rotation, Vector3};

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

    /// Whether it damps without bulk viscosity.
    fn is_damped(self) -> bool;

    /// What the linear forces need besides the geometry, at t_n, of an element with this stable time step (s). `step.time_step` is the
    /// Δt of K + 2C/Δt.
    fn tangent<R: Real>(
        self,
        elasticity: &IsotropicElasticity,
        stable_time_step: R,
        motion: &HexMotion<R>,
        step: &ElementStep,
    ) -> Tangent<R>;

    /// Forces (K + 2C/Δt) u of the displacement u about the corners at `position`: of stiffness as if nothing yielded, of
    /// linear damping, and without the stiffness of stress itself; of operators that are not symmetric their symmetric part.
    /// Implementations are `#[inline(always)]`.
    fn linear_forces<R: Real>(
        self,
        elasticity: &IsotropicElasticity,
        tangent: &Tangent<R>,
        position: &CornerVectors<R>,
        displacement: &CornerVectors<R>,
    ) -> CornerVectors<R>;
}

/// What the linear forces of an element depend on besides its elastic constants and its geometry.
#[derive(Clone, Copy, Debug)]
pub struct Tangent<R> {
    /// Factor on the elastic constants, see [`Material::stiffening`].
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
pub(crate) fn stiffening<E: Element, R: Real>(
    element: E,
    elasticity: &IsotropicElasticity,
    stable_time_step: R,
    motion: &HexMotion<R>,
) -> R {
    let elastic = Elastic::new(*elasticity);
    let mut unstiffened = E::initial_history(&elastic, 0.0);
    let at_rest = HexMotion { reference: motion.position, velocity: [Vector3::zero(); CORNERS], ..*motion };
    let no_step = ElementStep { bulk_viscosity: None, time_step: 0.0 };
    element.advance(&elastic, &mut unstiffened, None, &at_rest, &no_step);
    let ratio = unstiffened.stable_time_step() / stable_time_step;
    ratio * ratio
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
