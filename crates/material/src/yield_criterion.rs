//! Whether a step flows, and the loading index of every theory.
//!
//! Every theory here yields where an equivalent stress q reaches a flow stress σ_y, √(3/2) ‖dev T‖ in the E* theory. A step
//! flows if the q of its elastic predictor exceeds σ_y. With q̇ at fixed plastic strain
//!
//! ĝ = ⅔ |q| q̇,
//!
//! which is the rate of the yield function ½ dev T : dev T − K² at fixed plastic strain, the loading index Γ : D of de Vera 2016
//! (eq. 3.10, 6.30, 7.76), where q is von Mises'.
//!
//! What is told of a point, no part of a step: numbers are `f64`.

use crate::{FlowStart, Hardening};

/// The equivalent stress of an elastic predictor beside the flow stress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct YieldCriterion {
    /// q, Pa.
    pub equivalent_stress: f64,
    /// σ_y before the step, Pa.
    pub flow_stress: f64,
}

impl YieldCriterion {
    /// That of an equivalent stress under a hardening law; none of a law that depends on the rate, by which a state flows on
    /// while it unloads.
    pub(crate) fn under<H: Hardening>(
        hardening: &H,
        plastic_strain: f64,
        memory: &H::Memory<f64>,
        equivalent_stress: f64,
    ) -> Option<Self> {
        let start = FlowStart::new(plastic_strain, *memory, 0.0);
        let flow_stress = hardening.flow_stress(&start, 0.0).stress;
        (!hardening.depends_on_rate()).then_some(Self { equivalent_stress, flow_stress })
    }

    /// Whether the step flows.
    pub fn flows(&self) -> bool {
        self.equivalent_stress > self.flow_stress
    }

    /// ĝ, Pa²/s, the mean over a step of length `time_step` (s) that began at the equivalent stress `equivalent_stress_old`
    /// (Pa): above 0 in every step that flows.
    pub fn loading_index(&self, equivalent_stress_old: f64, time_step: f64) -> f64 {
        // a step that flows ends on the surface
        let equivalent_stress = self.equivalent_stress.min(self.flow_stress);
        2.0 / 3.0 * equivalent_stress.abs() * (self.equivalent_stress - equivalent_stress_old) / time_step
    }
}
