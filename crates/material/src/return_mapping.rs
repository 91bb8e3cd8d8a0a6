//! The scalar equation at the heart of every return mapping here.

use crate::FlowStress;
use estar_tensor::{Mask, Real};

/// Most corrections of one return; the bracket alone reaches rounding in fewer than twice as many.
const MOST_ITERATIONS: usize = 60;
/// A residual this small beside the flow stress is rounding.
const TOLERANCE: f64 = 1e-13;

/// Stress measure and its slope at a trial plastic increment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Equivalent<R> {
    /// von Mises stress of the returned state, Pa.
    pub stress: R,
    /// Its derivative with respect to the increment of ε̄ᵖ, Pa.
    pub slope: R,
}

/// The increment p of ε̄ᵖ that solves q(p) = σ_y(p), where `yields`; zero elsewhere.
///
/// q falls from above σ_y at p = 0 and σ_y does not fall, so the root is unique and lies in (0, `upper_bound`).
/// Newton's method from p = 0, kept inside the bracket by halving. A lane that has converged keeps its bits.
#[inline(always)]
pub(crate) fn plastic_increment<R: Real>(
    yields: R::Mask,
    upper_bound: R,
    equivalent: impl Fn(R) -> Equivalent<R>,
    flow: impl Fn(R) -> FlowStress<R>,
) -> R {
    let zero = R::splat(0.0);
    let mut active = yields;
    let mut low = zero;
    let mut high = upper_bound;
    let mut increment = zero;
    for _ in 0..MOST_ITERATIONS {
        let (q, y) = (equivalent(increment), flow(increment));
        let residual = q.stress - y.stress;
        active = active & (y.stress * TOLERANCE).lt(residual.abs());
        if !active.any() {
            break;
        }
        let below = residual.gt(zero);
        low = R::select(below, increment, low);
        high = R::select(below, high, increment);
        let newton = increment - residual / (q.slope - y.slope);
        let inside = newton.gt(low) & newton.lt(high);
        let next = R::select(inside, newton, (low + high) * 0.5);
        increment = R::select(active, next, increment);
    }
    increment
}
