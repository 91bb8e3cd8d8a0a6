//! The history of theories whose plastic variable is the metric C_p = F_pᵀF_p = U_p².

use crate::material::point_state;
use estar_tensor::{Real, SymmetricTensor};

/// C_p⁻¹, ε̄ᵖ, and T for the stress power of the next step.
#[derive(Clone, Copy, Debug)]
pub struct MetricState<R> {
    /// Inverse plastic metric C_p⁻¹.
    pub inverse_plastic_metric: SymmetricTensor<R>,
    /// Equivalent plastic strain ε̄ᵖ.
    pub equivalent_plastic_strain: R,
    /// Cauchy stress T, Pa.
    pub stress: SymmetricTensor<R>,
}

point_state!(MetricState { inverse_plastic_metric: symmetric, equivalent_plastic_strain: number, stress: symmetric });

impl<R: Real> MetricState<R> {
    /// No plastic strain and no stress.
    pub(crate) fn initial() -> Self {
        Self {
            inverse_plastic_metric: SymmetricTensor::spherical(R::splat(1.0)),
            equivalent_plastic_strain: R::splat(0.0),
            stress: SymmetricTensor::zero(),
        }
    }
}

impl MetricState<f64> {
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
