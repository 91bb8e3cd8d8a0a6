//! Solid elements: from the motion of corners to the forces on them. An element sees neither the mesh nor the deck.

pub mod bulk_viscosity;
pub mod element;
pub mod hex8;
pub mod hex8_one_point;
pub mod stable_time_step;
pub mod tet10;
pub mod tet4;
mod tet_parent;

/// 1/√3.
pub(crate) const PER_ROOT_3: f64 = 0.577_350_269_189_625_8;
