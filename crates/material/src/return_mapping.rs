//! The scalar equation at the heart of every return mapping here.

use crate::{FlowStart, FlowStress, Hardening, IsotropicElasticity};
use estar_tensor::{Mask, Real, inlined};

/// Most corrections of one return. Newton's method takes two to four for metals and a dozen from the vertical tangent
/// of a power law.
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
/// On [0, `upper_bound`] q falls, from above σ_y, and σ_y does not fall, so there is at most one root. Where there is
/// none, q is above σ_y to the end, and `upper_bound` is the answer. Newton's method from p = 0, where both sides are
/// `at_zero`, kept inside the bracket by trying its end and then by halving. A lane that has converged keeps its bits.
#[inline(always)]
pub(crate) fn plastic_increment<R: Real>(
    yields: R::Mask,
    upper_bound: R,
    at_zero: (Equivalent<R>, FlowStress<R>),
    equivalent: impl Fn(R) -> Equivalent<R>,
    flow: impl Fn(R) -> FlowStress<R>,
) -> R {
    let zero = R::splat(0.0);
    let mut active = yields;
    let mut low = zero;
    let mut high = upper_bound;
    let mut increment = zero;
    let (mut q, mut y) = at_zero;
    for _ in 0..MOST_ITERATIONS {
        let residual = q.stress - y.stress;
        let above = residual.gt(zero);
        low = R::select(above, increment, low);
        high = R::select(above, high, increment);
        // done: on the yield surface, or still above it at the end of the bracket
        active = active & (y.stress * TOLERANCE).lt(residual.abs()) & low.lt(upper_bound);
        if !active.any() {
            break;
        }
        let newton = increment - residual / (q.slope - y.slope);
        let inside = newton.gt(low) & newton.lt(high);
        let end_untried = newton.ge(high) & high.ge(upper_bound);
        let next = R::select(inside, newton, R::select(end_untried, high, (low + high) * 0.5));
        // done as well: the correction is rounding, as the last digits of a stress far outside the surface are
        let moves = (increment.abs() * f64::EPSILON).lt((next - increment).abs());
        increment = R::select(active, next, increment);
        active = active & moves;
        if !active.any() {
            break;
        }
        (q, y) = (equivalent(increment), flow(increment));
    }
    increment
}

/// A radial return: its elasticity, its law and what its flow starts from.
#[derive(Clone, Copy, Debug)]
pub struct RadialReturn<'a, H: Hardening, R: Real> {
    /// The elasticity.
    pub elasticity: &'a IsotropicElasticity,
    /// The law.
    pub hardening: &'a H,
    /// What the flow starts from.
    pub start: FlowStart<R, H::Memory<R>>,
}

impl<H: Hardening, R: Real> RadialReturn<'_, H, R> {
    /// σ_y before the step.
    #[inline(always)]
    pub fn flow_stress_old(&self) -> FlowStress<R> {
        self.hardening.flow_stress(&self.start, R::splat(0.0))
    }

    /// The increment p of ε̄ᵖ, √(3/2) ‖dev T_trial‖ − 3μ p = σ_y(ε̄ᵖ_n + p), where `yields`; zero elsewhere.
    /// `equivalent_stress` is √(3/2) ‖dev T_trial‖, `flow_stress_old` that of [`RadialReturn::flow_stress_old`].
    #[inline(always)]
    pub fn plastic_increment(&self, yields: R::Mask, equivalent_stress: R, flow_stress_old: FlowStress<R>) -> R {
        let three_mu = 3.0 * self.elasticity.shear_modulus();
        if let Some(slope) = self.hardening.constant_slope() {
            let excess = equivalent_stress - flow_stress_old.stress;
            return R::select(yields, excess * (three_mu + slope).recip(), R::splat(0.0));
        }
        let equivalent = inlined!(|p: R| Equivalent {
            stress: p.mul_add(R::splat(-three_mu), equivalent_stress),
            slope: R::splat(-three_mu),
        });
        let flow = inlined!(|p: R| self.hardening.flow_stress(&self.start, p));
        let at_zero = (equivalent(R::splat(0.0)), flow_stress_old);
        plastic_increment(yields, equivalent_stress * three_mu.recip(), at_zero, equivalent, flow)
    }
}

/// Φ = H/(3μ + H), H = dσ_y/dε̄ᵖ along the flow (de Vera 2016, eq. 3.28-3.30).
pub(crate) fn radial_hardening_index(elasticity: &IsotropicElasticity, slope: f64) -> f64 {
    slope / (3.0 * elasticity.shear_modulus() + slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODULUS: f64 = 3.0;

    /// The increment for q = `trial` − 3 p and the flow stress `flow`, with how often q was asked for.
    fn solved(trial: f64, upper_bound: f64, flow: impl Fn(f64) -> (f64, f64)) -> (f64, usize) {
        let evaluations = std::cell::Cell::new(0);
        let equivalent = |p: f64| {
            evaluations.set(evaluations.get() + 1);
            Equivalent { stress: trial - MODULUS * p, slope: -MODULUS }
        };
        let flow = |p: f64| {
            let (stress, slope) = flow(p);
            FlowStress { stress, slope }
        };
        (plastic_increment(true, upper_bound, (equivalent(0.0), flow(0.0)), equivalent, flow), evaluations.get())
    }

    #[test]
    fn a_linear_equation_takes_one_correction() {
        let (p, evaluations) = solved(2.0, 2.0 / MODULUS, |p| (1.0 + p, 1.0));
        assert!((p - 0.25).abs() < 1e-16);
        assert_eq!(evaluations, 2);
    }

    #[test]
    fn a_root_beyond_the_bracket_gives_its_end() {
        let (p, evaluations) = solved(2.0, 0.1, |_| (1.0, 0.0));
        assert_eq!(p, 0.1);
        assert_eq!(evaluations, 2);
        // also where the slope is so small that Newton's method would leave by far
        assert_eq!(solved(2.0, 0.2, |p| (1.0 + 1e-3 * p, 1e-3)).0, 0.2);
    }

    #[test]
    fn kinks_and_steep_starts_stay_inside_the_bracket() {
        // a table that is flat, then steeper than the elastic slope by 10⁶: from the flat part Newton overshoots
        let kink = |p: f64| if p < 0.1 { (1.0, 0.0) } else { (1.0 + 3e6 * (p - 0.1), 3e6) };
        let (p, evaluations) = solved(2.0, 2.0 / MODULUS, kink);
        assert!((2.0 - MODULUS * p - kink(p).0).abs() < 1e-9, "{p}");
        assert!((p - 0.1).abs() < 1e-6 && evaluations <= 10, "{p} after {evaluations}");
        // and one that is steep first
        let bend = |p: f64| if p < 1e-9 { (1.0 + 5e8 * p, 5e8) } else { (1.5 + p - 1e-9, 1.0) };
        let (p, evaluations) = solved(2.0, 2.0 / MODULUS, bend);
        assert!((p - 0.125).abs() < 1e-8 && evaluations <= 6, "{p} after {evaluations}");
    }

    #[test]
    fn lanes_that_do_not_yield_or_are_not_numbers_end_the_search() {
        let equivalent = |p: f64| Equivalent { stress: 2.0 - MODULUS * p, slope: -MODULUS };
        let flow = |_: f64| FlowStress { stress: 1.0, slope: 0.0 };
        assert_eq!(plastic_increment(false, 1.0, (equivalent(0.0), flow(0.0)), equivalent, flow), 0.0);
        let (p, evaluations) = solved(f64::NAN, f64::NAN, |_| (1.0, 0.0));
        assert_eq!((p, evaluations), (0.0, 1));
        let (_, evaluations) = solved(f64::INFINITY, f64::INFINITY, |_| (1.0, 0.0));
        assert!(evaluations <= 2, "{evaluations}");
    }
}
