//! Explicit dynamics of solids: central differences over blocks of elements.
//!
//! A [`Model`] on a mesh becomes a [`Simulation`], which [`Simulation::advance`] moves one step at a time. Read
//! `central_difference.rs` first.

mod assembly;
mod block;
mod central_difference;
mod constraints;
mod curve;
mod energy;
mod error;
pub mod fields;
mod global_time_step;
mod kick;
mod lanczos;
mod loads;
mod mass_scaling;
mod memory;
pub mod model;
mod natural_frequency;
mod patch;
mod patch_rows;
mod rigid_wall;
mod simulation;
mod spectrum;
mod state;
mod sums;
mod traffic;
mod wall_contact;

pub use curve::{Curve, CurveError, Interpolation};
pub use energy::Energies;
pub use error::{ConstraintSource, ModelError, SimulationError};
pub use estar_tensor::LaneLevel;
pub use memory::memory_needed;
pub use model::Model;
pub use natural_frequency::NaturalFrequency;
pub use simulation::{Extremes, Simulation};
pub use state::{NoState, STATE_LAYOUT};
