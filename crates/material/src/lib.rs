//! Constitutive theories: how stress and internal state follow from motion, one file a theory.

mod elasticity;
mod hardening;
mod parameter;

pub use elasticity::{ElasticConstant, IsotropicElasticity};
pub use hardening::{FlowStress, IsotropicHardening, KinematicHardening};
pub use parameter::ParameterError;
