//! Numbers that are one `f64` or several side by side, and the vectors and tensors made of them.
//!
//! Physics above this crate is written once, generic over [`Real`]. With `f64` it runs one quadrature point; with the
//! lanes that [`dispatch`] chooses at run time it runs the same point of several elements in the same instructions, and
//! every lane ends in the bits that the `f64` code gives.

mod array;
mod counted;
mod elementary;
mod lanes;
mod real;
mod rotation;
mod symmetric;
mod tensor;
mod vector;

pub use array::array;
pub use counted::{Counted, Operations, operations};
pub use lanes::{LaneLevel, WithLanes, dispatch, prefetch};
pub use real::{Kernel, Mask, Real};
pub use rotation::{Rotation, polar_rotation};
pub use symmetric::{Eigensystem, SymmetricTensor};
pub use tensor::Tensor;
pub use vector::Vector3;
