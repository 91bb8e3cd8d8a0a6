//! Line plots as SVG and PNG, the same in both, and shaded pictures of bodies: text is drawn as outlines of one font that the
//! program carries.
//!
//! [`figure`] says what is shown and lays it out, [`text`] sets type, [`drawing`] holds the shapes and writes them. [`surface`] is
//! the outside of a body with a field on it, which [`shaded`] draws.

pub mod drawing;
pub mod figure;
pub mod shaded;
pub mod surface;
pub mod text;

pub use drawing::Drawing;
pub use figure::{Axis, Curve, Figure, Panel};
