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
    /// Steps in which plastic strain grew.
    pub flowing_steps: usize,
    /// Least dissipation of a step with flow, at fixed F, W(F_{n+1}, C_p,n) − W(F_{n+1}, C_p,n+1), J per m³ of reference volume;
    /// not a number where no step flows, or one has none.
    pub least_dissipation: f64,
    /// Sum of |Δ ln det C_p|.
    pub determinant_drift: f64,
    /// Sum of ‖ΔC_p⁻¹ − ΔC_p⁻ᵀ‖/‖C_p⁻¹‖.
    pub asymmetry: f64,
    /// Least principal value of the symmetric part of C_p⁻¹; not a number where one is not.
    pub least_principal_value: f64,
    /// Greatest ‖C_p⁻¹ − C_p⁻¹ of Simo & Miehe‖.
    pub distance_from_simo_miehe: f64,
    /// The step that the rule could not make.
    pub ended: Option<PathError>,
}

/// More than the rounding of a path of any length.
const ROUNDING: f64 = 1e-8;

/// The smaller number; not a number where either is not.
fn least(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.min(b) }
}

impl Consistency {
    /// That of the material's flow rule along the path `control(time)` at the `times` (s), at the first of which it is
    /// undeformed, as far as the rule can go. The rule of Simo & Miehe goes along the same deformation gradients.
    pub fn along(material: &PlasticMetric, control: impl Fn(f64) -> Control, times: &[f64]) -> Self {
        let reference = material.with_rule(FlowRule::SimoMiehe);
        let (mut last, mut simo_miehe) = (MaterialPoint::new(material), MaterialPoint::new(&reference));
        let mut time_old = times.first().copied().unwrap_or(0.0);
        let mut found = Self {
            flowing_steps: 0,
            least_dissipation: f64::NAN,
            determinant_drift: 0.0,
            asymmetry: 0.0,
            least_principal_value: 1.0,
            distance_from_simo_miehe: 0.0,
            ended: None,
        };
        let journey = follow(material, control, times, |time, point| {
            let target = point.deformation_gradient();
            let old = last.state().inverse_plastic_metric;
            let moved = material.moved_by_rule(last.state(), target);
            simo_miehe.advance(target, time - time_old);
            let size = |tensor: Tensor<f64>| tensor.norm_squared().sqrt();
            if point.equivalent_plastic_strain() > last.equivalent_plastic_strain() {
                let dissipation = material.elastic_energy(target, &old) - material.elastic_energy(target, &moved);
                found.least_dissipation =
                    if found.flowing_steps == 0 { dissipation } else { least(found.least_dissipation, dissipation) };
                found.flowing_steps += 1;
            }
            let change = moved - old;
            found.determinant_drift += (moved.determinant() / old.determinant()).ln().abs();
            found.asymmetry += size(change - change.transpose()) / size(moved);
            let principal = moved.symmetric_part().eigensystem().values;
            found.least_principal_value = least(found.least_principal_value, principal[2]);
            let distance = size(moved - simo_miehe.state().inverse_plastic_metric);
            found.distance_from_simo_miehe = -least(-found.distance_from_simo_miehe, -distance);
            last = point.clone();
            time_old = time;
        });
        Self { ended: journey.err(), ..found }
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

    /// Whether the rule is consistent on this path, all three to its end; none where nothing flows and nothing is shown.
    pub fn is_consistent(&self) -> Option<bool> {
        let keeps_all = self.dissipates() && self.is_isochoric() && self.is_metric() && self.ended.is_none();
        (self.flowing_steps > 0).then_some(keeps_all)
    }

    /// Whether C_p(t) is that of Simo & Miehe.
    pub fn equals_simo_miehe(&self) -> bool {
        self.distance_from_simo_miehe < ROUNDING
    }
}
