//! Structured hex meshes of simple bodies, so that no mesher is needed to start.
//!
//! A `…Spec` is valid once it exists; a mesh made from one always exists.

mod brick;
mod disc;
mod grading;
mod round_bar;
mod spec;

pub use brick::{BoxSpec, box_mesh};
pub use round_bar::{
    CylinderParameters, CylinderSpec, NeckingBarParameters, NeckingBarSpec, Section, cylinder, necking_bar,
};
pub use spec::SpecError;
