//! Constitutive theories: how stress and internal state follow from motion, one file a theory.
//!
//! A theory implements [`Material`] once, generic over the number; [`point`] drives it along a path without a mesh.

mod e_star;
mod e_star_kinematic;
mod e_star_total;
mod elastic;
mod elasticity;
mod factors;
mod hardening;
mod kinematics;
mod material;
mod objective_rate;
mod parameter;
pub mod point;
mod return_mapping;

pub use e_star::{EStar, EStarState, KinematicRule, Return, Trial};
pub use e_star_kinematic::EStarKinematicState;
pub use e_star_total::{EStarTotal, EStarTotalState};
pub use elastic::{Elastic, ElasticState};
pub use elasticity::{ElasticConstant, IsotropicElasticity};
pub use factors::Factors;
pub use hardening::{FlowStress, IsotropicHardening, KinematicHardening};
pub use kinematics::{Motion, PointGradients, RotatedMotion, SpatialMotion, StepKinematics};
pub use material::{Material, MaterialModel, MaterialUpdate, MaterialVisitor, PointState};
pub use objective_rate::{Hypoelastic, HypoelasticState, ObjectiveRate, Turning};
pub use parameter::ParameterError;
