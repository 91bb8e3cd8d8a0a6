//! Vectors of three components.

use crate::real::Real;
use std::ops::{Add, Mul, Sub};

/// A vector of three components x, y, z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vector3<R>(pub [R; 3]);

impl<R: Real> Vector3<R> {
    /// The zero vector.
    #[inline(always)]
    pub fn zero() -> Self {
        Self([R::splat(0.0); 3])
    }

    /// a · b.
    #[inline(always)]
    pub fn dot(self, other: Self) -> R {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        a.mul_add(x, b.mul_add(y, c * z))
    }

    /// a × b.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([b.mul_add(z, -(c * y)), c.mul_add(x, -(a * z)), a.mul_add(y, -(b * x))])
    }

    /// `self × factor + addend`, a fused operation a component.
    #[inline(always)]
    pub fn mul_add(self, factor: R, addend: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, addend.0);
        Self([a.mul_add(factor, x), b.mul_add(factor, y), c.mul_add(factor, z)])
    }

    /// `chosen` where the mask is set, else `otherwise`.
    #[inline(always)]
    pub fn select(mask: R::Mask, chosen: Self, otherwise: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (chosen.0, otherwise.0);
        Self([R::select(mask, a, x), R::select(mask, b, y), R::select(mask, c, z)])
    }
}

impl<R: Real> Add for Vector3<R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([a + x, b + y, c + z])
    }
}

impl<R: Real> Sub for Vector3<R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([a - x, b - y, c - z])
    }
}

impl<R: Real> Mul<R> for Vector3<R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: R) -> Self {
        let [a, b, c] = self.0;
        Self([a * factor, b * factor, c * factor])
    }
}
