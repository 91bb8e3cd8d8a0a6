//! Points in space.

use nalgebra::Vector3;

/// The vector from `b` to `a`.
pub(crate) fn difference(a: &[f64; 3], b: &[f64; 3]) -> Vector3<f64> {
    Vector3::from(*a) - Vector3::from(*b)
}

/// How far two points are from each other.
pub(crate) fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    difference(a, b).norm()
}
