//! Second-order tensors.

use crate::real::Real;
use crate::symmetric::SymmetricTensor;
use crate::vector::Vector3;
use std::ops::{Add, Mul, Sub};

/// A second-order tensor, stored by columns: `columns[j]` is the image of the j-th base vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tensor<R> {
    /// The three columns.
    pub columns: [Vector3<R>; 3],
}

impl<R: Real> Tensor<R> {
    /// The tensor with the given rows of components.
    #[inline(always)]
    pub fn from_rows(rows: [[R; 3]; 3]) -> Self {
        let [a, b, c] = rows;
        Self { columns: [Vector3([a[0], b[0], c[0]]), Vector3([a[1], b[1], c[1]]), Vector3([a[2], b[2], c[2]])] }
    }

    /// The identity I.
    #[inline(always)]
    pub fn identity() -> Self {
        Self::zero().plus_spherical(R::splat(1.0))
    }

    /// The zero tensor.
    #[inline(always)]
    pub fn zero() -> Self {
        Self { columns: [Vector3::zero(); 3] }
    }

    /// Component in row `i` and column `j`.
    #[inline(always)]
    pub fn at(&self, i: usize, j: usize) -> R {
        self.columns[j].0[i]
    }

    /// Aᵀ.
    #[inline(always)]
    pub fn transpose(&self) -> Self {
        let [a, b, c] = self.columns;
        Self::from_rows([a.0, b.0, c.0])
    }

    /// tr A.
    #[inline(always)]
    pub fn trace(&self) -> R {
        self.at(0, 0) + self.at(1, 1) + self.at(2, 2)
    }

    /// det A.
    #[inline(always)]
    pub fn determinant(&self) -> R {
        let [a, b, c] = self.columns;
        a.dot(b.cross(c))
    }

    /// cof A = det A · A⁻ᵀ, whose columns are b × c, c × a, a × b of the columns of A.
    #[inline(always)]
    pub fn cofactor(&self) -> Self {
        let [a, b, c] = self.columns;
        Self { columns: [b.cross(c), c.cross(a), a.cross(b)] }
    }

    /// A⁻¹ = (cof A)ᵀ / det A.
    #[inline(always)]
    pub fn inverse(&self) -> Self {
        let cofactor = self.cofactor();
        let determinant = self.columns[0].dot(cofactor.columns[0]);
        cofactor.transpose() * determinant.recip()
    }

    /// A b.
    #[inline(always)]
    pub fn apply(&self, b: Vector3<R>) -> Vector3<R> {
        let [x, y, z] = b.0;
        self.columns[0].mul_add(x, self.columns[1].mul_add(y, self.columns[2] * z))
    }

    /// Aᵀ b.
    #[inline(always)]
    pub fn transpose_apply(&self, b: Vector3<R>) -> Vector3<R> {
        let [x, y, z] = self.columns;
        Vector3([x.dot(b), y.dot(b), z.dot(b)])
    }

    /// A B.
    #[inline(always)]
    pub fn dot(&self, other: &Self) -> Self {
        let [a, b, c] = other.columns;
        Self { columns: [self.apply(a), self.apply(b), self.apply(c)] }
    }

    /// Aᵀ B.
    #[inline(always)]
    pub fn transpose_dot(&self, other: &Self) -> Self {
        let [a, b, c] = other.columns;
        Self { columns: [self.transpose_apply(a), self.transpose_apply(b), self.transpose_apply(c)] }
    }

    /// sym A = ½ (A + Aᵀ).
    #[inline(always)]
    pub fn symmetric_part(&self) -> SymmetricTensor<R> {
        let half = |i, j| (self.at(i, j) + self.at(j, i)) * 0.5;
        SymmetricTensor([self.at(0, 0), self.at(1, 1), self.at(2, 2), half(0, 1), half(1, 2), half(0, 2)])
    }

    /// `self + amount I`.
    #[inline(always)]
    pub fn plus_spherical(&self, amount: R) -> Self {
        let [mut a, mut b, mut c] = self.columns;
        a.0[0] += amount;
        b.0[1] += amount;
        c.0[2] += amount;
        Self { columns: [a, b, c] }
    }

    /// Frobenius norm squared A : A.
    #[inline(always)]
    pub fn norm_squared(&self) -> R {
        let [a, b, c] = self.columns;
        a.dot(a) + b.dot(b) + c.dot(c)
    }
}

impl<R: Real> Add for Tensor<R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.columns, other.columns);
        Self { columns: [a + x, b + y, c + z] }
    }
}

impl<R: Real> Sub for Tensor<R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.columns, other.columns);
        Self { columns: [a - x, b - y, c - z] }
    }
}

impl<R: Real> Mul<R> for Tensor<R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: R) -> Self {
        let [a, b, c] = self.columns;
        Self { columns: [a * factor, b * factor, c * factor] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: [[f64; 3]; 3] = [[1.2, 0.4, -0.3], [0.1, 0.9, 0.7], [-0.2, 0.5, 1.4]];

    #[test]
    fn inverse_times_tensor_is_identity() {
        let a = Tensor::from_rows(A);
        let error = a.inverse().dot(&a) - Tensor::identity();
        assert!(error.norm_squared() < 1e-30);
        assert!((a.cofactor().transpose_dot(&a).at(1, 1) - a.determinant()).abs() < 1e-15);
    }

    #[test]
    fn transpose_dot_is_the_product_with_the_transpose() {
        let (a, b) = (Tensor::from_rows(A), Tensor::from_rows(A).dot(&Tensor::from_rows(A)));
        assert!((a.transpose_dot(&b) - a.transpose().dot(&b)).norm_squared() < 1e-30);
    }
}
