//! Constitutive theories: how stress and internal state follow from motion, one file a theory.
//!
//! A theory implements [`Material`] once, generic over the number; [`point`] drives it along a path without a mesh.

// the page that adds a material is compiled and run as documentation is
#[cfg(doctest)]
#[doc = include_str!("../../../docs/new-material.md")]
mod new_material {}

mod closest_point;
mod consistency;
mod e_star;
mod e_star_kinematic;
mod e_star_total;
mod elastic;
mod elasticity;
mod factors;
mod green_naghdi;
mod hardening;
mod hencky;
mod johnson_cook;
mod kinematics;
mod loading;
mod logarithm;
mod material;
mod metric_state;
mod objective_rate;
mod parameter;
mod plastic_metric;
pub mod point;
pub mod points;
mod principal_surface;
mod return_mapping;
mod tangent_bound;
mod yield_criterion;

pub use closest_point::ClosestPoint;
pub use consistency::Consistency;
pub use e_star::{EStar, EStarState, KinematicRule, Return, Trial};
pub use e_star_kinematic::RotatedBackStress;
pub use e_star_total::EStarTotal;
pub use elastic::{Elastic, ElasticState};
pub use elasticity::{ElasticConstant, IsotropicElasticity};
pub use factors::Factors;
pub use green_naghdi::{GreenNaghdi, GreenNaghdiState};
pub use hardening::{FlowStart, FlowStress, Hardening, IsotropicHardening, KinematicHardening};
pub use hencky::Hencky;
pub use johnson_cook::{AdiabaticHeating, JohnsonCook, JohnsonCookParameters, Temperature};
pub use kinematics::{Motion, PointGradients, ReferenceMotion, RotatedMotion, SpatialMotion, StepKinematics};
pub use loading::{Loading, LoadingCriterion, loading_normal};
pub use material::{Material, MaterialModel, MaterialUpdate, MaterialVisitor, PointState};
pub use metric_state::MetricState;
pub use objective_rate::{Hypoelastic, HypoelasticState, ObjectiveRate, Turning};
pub use parameter::ParameterError;
pub use plastic_metric::{ElasticEnergy, FlowRule, PlasticMetric, PlasticMetricState};
pub use principal_surface::{PrincipalReturn, PrincipalSurface, Rankine, VonMises};
pub use return_mapping::RadialReturn;
pub use yield_criterion::YieldCriterion;
