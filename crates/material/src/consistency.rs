//! What a flow rule keeps of a plastic metric, computed along a path (Neff & Ghiba, "Comparison of isotropic elasto-plastic
//! models for the plastic metric tensor C_p = F_pᵀF_p", definition 1.2).

use crate::point::{Control, MaterialPoint, PathError, follow};
use crate::{FlowRule, PlasticMetric};
use estar_tensor::Tensor;

/// The extremes of a path, and the sums over its steps of what the rule itself does not keep.
///
/// The update clears C_p of rounding where its rule is known to be consistent. The verdict does not rest on that: it is on
/// what each step of the rule did before anything was cleared.
#[derive(Clone, Copy, Debug)]
pub struct Consistency {
    /// Least dissipation of a step with flow, at fixed F, W(F_{n+1}, C_p,n) − W(F_{n+1}, C_p,n+1), J per m³ of reference volume.
    pub least_dissipation: f64,
    /// Sum of |Δ ln det C_p|.
    pub determinant_drift: f64,
    /// Sum of ‖ΔC_p⁻¹ − ΔC_p⁻ᵀ‖/‖C_p⁻¹‖.
    pub asymmetry: f64,
    /// Least principal value of the symmetric part of C_p⁻¹.
    pub least_principal_value: f64,
    /// Greatest ‖C_p⁻¹ − C_p⁻¹ of Simo & Miehe‖.
    pub distance_from_simo_miehe: f64,
}

/// More than the rounding of a path of any length.
const ROUNDING: f64 = 1e-8;

impl Consistency {
    /// That of the material's flow rule along the path `control(time)` at the `times` (s), at the first of which it is
    /// undeformed. The rule of Simo & Miehe goes along the same deformation gradients.
    ///
    /// # Errors
    /// A step that cannot be made.
    pub fn along(material: &PlasticMetric, control: impl Fn(f64) -> Control, times: &[f64]) -> Result<Self, PathError> {
        let reference = material.with_rule(FlowRule::SimoMiehe);
        let (mut last, mut simo_miehe) = (MaterialPoint::new(material), MaterialPoint::new(&reference));
        let mut time_old = times.first().copied().unwrap_or(0.0);
        let mut found = Self {
            least_dissipation: f64::INFINITY,
            determinant_drift: 0.0,
            asymmetry: 0.0,
            least_principal_value: f64::INFINITY,
            distance_from_simo_miehe: 0.0,
        };
        follow(material, control, times, |time, point| {
            let target = point.deformation_gradient();
            let old = last.state().inverse_plastic_metric;
            let moved = material.moved_by_rule(last.state(), target);
            simo_miehe.advance(target, time - time_old);
            let metric = point.state().inverse_plastic_metric;
            let size = |tensor: Tensor<f64>| tensor.norm_squared().sqrt();
            let dissipation = if point.equivalent_plastic_strain() > last.equivalent_plastic_strain() {
                material.elastic_energy(target, &old) - material.elastic_energy(target, &metric)
            } else {
                f64::INFINITY
            };
            let principal = metric.symmetric_part().eigensystem().values;
            let change = moved - old;
            let distance = size(metric - simo_miehe.state().inverse_plastic_metric);
            found = Self {
                least_dissipation: found.least_dissipation.min(dissipation),
                determinant_drift: found.determinant_drift + (moved.determinant() / old.determinant()).ln().abs(),
                asymmetry: found.asymmetry + size(change - change.transpose()) / size(moved),
                least_principal_value: found.least_principal_value.min(principal[2]),
                distance_from_simo_miehe: found.distance_from_simo_miehe.max(distance),
            };
            last = point.clone();
            time_old = time;
        })?;
        Ok(found)
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
