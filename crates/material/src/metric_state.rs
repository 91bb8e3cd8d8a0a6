//! The history of theories whose plastic variable is the metric C_p = F_pᵀF_p = U_p².

use crate::point_state;
use estar_tensor::{Real, SymmetricTensor};

/// C_p⁻¹, ε̄ᵖ, T for the stress power of the next step, and what the hardening law remembers.
#[derive(Clone, Copy, Debug)]
pub struct MetricState<R, Memory> {
    /// Inverse plastic metric C_p⁻¹.
    pub inverse_plastic_metric: SymmetricTensor<R>,
    /// Equivalent plastic strain ε̄ᵖ.
    pub equivalent_plastic_strain: R,
    /// Cauchy stress T, Pa.
    pub stress: SymmetricTensor<R>,
    /// What the hardening law remembers.
    pub memory: Memory,
}

point_state!(MetricState<Memory> {
    inverse_plastic_metric: symmetric,
    equivalent_plastic_strain: number,
    stress: symmetric,
    memory: inner,
});

impl<R: Real, Memory> MetricState<R, Memory> {
    /// No plastic strain and no stress.
    pub(crate) fn initial(memory: Memory) -> Self {
        Self {
            inverse_plastic_metric: SymmetricTensor::spherical(R::splat(1.0)),
            equivalent_plastic_strain: R::splat(0.0),
            stress: SymmetricTensor::zero(),
            memory,
        }
    }
}

impl<Memory> MetricState<f64, Memory> {
    /// C_p.
    pub(crate) fn plastic_metric(&self) -> SymmetricTensor<f64> {
        self.inverse_plastic_metric.to_tensor().inverse().symmetric_part()
    }
}

/// `metric`, whose determinant is 1 but for rounding, without that rounding: det C_p⁻¹ does not drift, however many steps
/// there are. d^(−1/3) = 1 − ⅓ (d − 1) for d = 1 + rounding.
#[inline(always)]
pub(crate) fn isochoric<R: Real>(metric: &SymmetricTensor<R>) -> SymmetricTensor<R> {
    *metric * ((metric.determinant() - 4.0) * (-1.0 / 3.0))
}
