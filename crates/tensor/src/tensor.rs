//! Second-order tensors.

use crate::array::array;
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
        Self { columns: array(|j| Vector3(array(|i| rows[i][j]))) }
    }

    /// The identity I.
    #[inline(always)]
    pub fn identity() -> Self {
        let component = |i, j| R::splat(if i == j { 1.0 } else { 0.0 });
        Self { columns: array(|j| Vector3(array(|i| component(i, j)))) }
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
        Self { columns: array(|j| Vector3(array(|i| self.at(j, i)))) }
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

    /// A B.
    #[inline(always)]
    pub fn dot(&self, other: &Self) -> Self {
        Self { columns: array(|j| self.apply(other.columns[j])) }
    }

    /// Aᵀ B.
    #[inline(always)]
    pub fn transpose_dot(&self, other: &Self) -> Self {
        Self { columns: array(|j| Vector3(array(|i| self.columns[i].dot(other.columns[j])))) }
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
        let mut sum = *self;
        for i in 0..3 {
            sum.columns[i].0[i] += amount;
        }
        sum
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
        Self { columns: array(|j| self.columns[j] + other.columns[j]) }
    }
}

impl<R: Real> Sub for Tensor<R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { columns: array(|j| self.columns[j] - other.columns[j]) }
    }
}

impl<R: Real> Mul<R> for Tensor<R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: R) -> Self {
        Self { columns: array(|j| self.columns[j] * factor) }
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
