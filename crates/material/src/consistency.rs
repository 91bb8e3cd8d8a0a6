//! What a flow rule keeps of a plastic metric, computed along a path (Neff & Ghiba, "Comparison of isotropic elasto-plastic
//! models for the plastic metric tensor C_p = F_pᵀF_p", definition 1.2).

use crate::point::MaterialPoint;
use crate::{FlowRule, PlasticMetric};
use estar_tensor::Tensor;

/// The extremes of a path.
#[derive(Clone, Copy, Debug)]
pub struct Consistency {
    /// Least dissipation of a step with flow, at fixed F, W(F_{n+1}, C_p,n) − W(F_{n+1}, C_p,n+1), J per m³ of reference volume.
    pub least_dissipation: f64,
    /// Greatest |det C_p − 1|.
    pub determinant_drift: f64,
    /// Greatest ‖C_p⁻¹ − C_p⁻ᵀ‖/‖C_p⁻¹‖.
    pub asymmetry: f64,
    /// Least principal value of the symmetric part of C_p⁻¹.
    pub least_principal_value: f64,
    /// Greatest ‖C_p⁻¹ − C_p⁻¹ of Simo & Miehe‖.
    pub distance_from_simo_miehe: f64,
}

/// More than the rounding of a path of any length.
const ROUNDING: f64 = 1e-8;

impl Consistency {
    /// That of the material's flow rule along `path(time)`, 0 < time ≤ `end`, in `steps` equal steps.
    pub fn along(material: &PlasticMetric, path: impl Fn(f64) -> Tensor<f64>, end: f64, steps: u32) -> Self {
        let reference = material.with_rule(FlowRule::SimoMiehe);
        let (mut point, mut simo_miehe) = (MaterialPoint::new(material), MaterialPoint::new(&reference));
        let mut found = Self {
            least_dissipation: f64::INFINITY,
            determinant_drift: 0.0,
            asymmetry: 0.0,
            least_principal_value: f64::INFINITY,
            distance_from_simo_miehe: 0.0,
        };
        for step in 1..=steps {
            let target = path(end * f64::from(step) / f64::from(steps));
            let old = point.state().inverse_plastic_metric;
            let strain_old = point.equivalent_plastic_strain();
            point.advance(&target, end / f64::from(steps));
            simo_miehe.advance(&target, end / f64::from(steps));
            let metric = point.state().inverse_plastic_metric;
            let size = |tensor: Tensor<f64>| tensor.norm_squared().sqrt();
            let dissipation = if point.equivalent_plastic_strain() > strain_old {
                material.elastic_energy(&target, &old) - material.elastic_energy(&target, &metric)
            } else {
                f64::INFINITY
            };
            let principal = metric.symmetric_part().eigensystem().values;
            let distance = size(metric - simo_miehe.state().inverse_plastic_metric);
            found = Self {
                least_dissipation: found.least_dissipation.min(dissipation),
                determinant_drift: found.determinant_drift.max((metric.determinant().recip() - 1.0).abs()),
                asymmetry: found.asymmetry.max(size(metric - metric.transpose()) / size(metric)),
                least_principal_value: found.least_principal_value.min(principal[2]),
                distance_from_simo_miehe: found.distance_from_simo_miehe.max(distance),
            };
        }
        found
    }

    /// Whether dissipation is never negative.
    pub fn dissipates(&self) -> bool {
        self.least_dissipation >= 0.0
    }

    /// Whether det C_p = 1.
    pub fn is_isochoric(&self) -> bool {
        self.determinant_drift < ROUNDING
    }

    /// Whether C_p is symmetric and positive definite.
    pub fn is_metric(&self) -> bool {
        self.asymmetry < ROUNDING && self.least_principal_value > 0.0
    }

    /// Whether the rule is consistent on this path: all three.
    pub fn is_consistent(&self) -> bool {
        self.dissipates() && self.is_isochoric() && self.is_metric()
    }

    /// Whether C_p(t) is that of Simo & Miehe.
    pub fn equals_simo_miehe(&self) -> bool {
        self.distance_from_simo_miehe < ROUNDING
    }
}
