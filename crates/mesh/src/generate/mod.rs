//! Structured meshes of simple bodies, of hexes or of what they are cut into, so that no mesher is needed to start.
//!
//! A `…Spec` is valid once it exists; a mesh made from one always exists.

mod brick;
mod cut;
mod disc;
mod grading;
mod round_bar;
mod spec;

pub use brick::{BoxSpec, box_mesh};
pub use cut::cut_into;
pub use round_bar::{
    CylinderParameters, CylinderSpec, NeckingBarParameters, NeckingBarSpec, Section, cylinder, necking_bar,
};
pub use spec::SpecError;
