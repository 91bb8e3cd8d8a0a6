//! Symmetric second-order tensors and their principal values.

use crate::real::{Mask, Real};
use crate::tensor::Tensor;
use crate::vector::Vector3;
use std::ops::{Add, Mul, Sub};

/// A symmetric tensor; components in the order xx, yy, zz, xy, yz, xz.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SymmetricTensor<R>(pub [R; 6]);

/// Principal values and directions: A = Σ valuesᵢ vᵢ ⊗ vᵢ, the vᵢ being the columns of `vectors`.
#[derive(Clone, Copy, Debug)]
pub struct Eigensystem<R> {
    /// Principal values, the largest first.
    pub values: [R; 3],
    /// Orthonormal principal directions as columns.
    pub vectors: Tensor<R>,
}

impl<R: Real> SymmetricTensor<R> {
    /// The zero tensor.
    #[inline(always)]
    pub fn zero() -> Self {
        Self([R::splat(0.0); 6])
    }

    /// `amount` I.
    #[inline(always)]
    pub fn spherical(amount: R) -> Self {
        let zero = R::splat(0.0);
        Self([amount, amount, amount, zero, zero, zero])
    }

    /// The tensor with these values on the base vectors.
    #[inline(always)]
    pub fn diagonal(values: [R; 3]) -> Self {
        let zero = R::splat(0.0);
        Self([values[0], values[1], values[2], zero, zero, zero])
    }

    /// tr A.
    #[inline(always)]
    pub fn trace(&self) -> R {
        self.0[0] + self.0[1] + self.0[2]
    }

    /// dev A = A − ⅓ tr(A) I.
    #[inline(always)]
    pub fn deviator(&self) -> Self {
        self.plus_spherical(self.trace() * (-1.0 / 3.0))
    }

    /// `self + amount I`.
    #[inline(always)]
    pub fn plus_spherical(&self, amount: R) -> Self {
        let [xx, yy, zz, xy, yz, xz] = self.0;
        Self([xx + amount, yy + amount, zz + amount, xy, yz, xz])
    }

    /// A : B.
    #[inline(always)]
    pub fn double_dot(&self, other: &Self) -> R {
        let (a, b) = (self.0, other.0);
        let normal = a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]));
        let shear = a[3].mul_add(b[3], a[4].mul_add(b[4], a[5] * b[5]));
        shear.mul_add(R::splat(2.0), normal)
    }

    /// ‖A‖² = A : A.
    #[inline(always)]
    pub fn norm_squared(&self) -> R {
        self.double_dot(self)
    }

    /// `self × factor + addend`, a fused operation a component.
    #[inline(always)]
    pub fn mul_add(&self, factor: R, addend: &Self) -> Self {
        let (a, b) = (self.0, addend.0);
        let component = |i: usize| a[i].mul_add(factor, b[i]);
        Self([component(0), component(1), component(2), component(3), component(4), component(5)])
    }

    /// `chosen` where the mask is set, else `otherwise`.
    #[inline(always)]
    pub fn select(mask: R::Mask, chosen: &Self, otherwise: &Self) -> Self {
        let (a, b) = (chosen.0, otherwise.0);
        let component = |i: usize| R::select(mask, a[i], b[i]);
        Self([component(0), component(1), component(2), component(3), component(4), component(5)])
    }

    /// The tensor where the mask is set, else zero.
    #[inline(always)]
    pub fn or_zero(&self, mask: R::Mask) -> Self {
        Self::select(mask, self, &Self::zero())
    }

    /// det A.
    #[inline(always)]
    pub fn determinant(&self) -> R {
        let [xx, yy, zz, xy, yz, xz] = self.0;
        let first = xx * yy.mul_add(zz, -(yz * yz));
        let second = xy * xy.mul_add(zz, -(yz * xz));
        let third = xz * xy.mul_add(yz, -(yy * xz));
        first - second + third
    }

    /// The same tensor with nine components.
    #[inline(always)]
    pub fn to_tensor(self) -> Tensor<R> {
        let [xx, yy, zz, xy, yz, xz] = self.0;
        Tensor { columns: [Vector3([xx, xy, xz]), Vector3([xy, yy, yz]), Vector3([xz, yz, zz])] }
    }

    /// A A, symmetric as A is.
    #[inline(always)]
    pub fn square(&self) -> Self {
        let a = self.to_tensor().columns;
        Self([a[0].dot(a[0]), a[1].dot(a[1]), a[2].dot(a[2]), a[0].dot(a[1]), a[1].dot(a[2]), a[0].dot(a[2])])
    }

    /// B A Bᵀ.
    #[inline(always)]
    pub fn pushed_by(&self, b: &Tensor<R>) -> Self {
        self.pulled_by(&b.transpose())
    }

    /// Bᵀ A B.
    #[inline(always)]
    pub fn pulled_by(&self, b: &Tensor<R>) -> Self {
        let ab = self.to_tensor().dot(b).columns;
        let b = b.columns;
        Self([b[0].dot(ab[0]), b[1].dot(ab[1]), b[2].dot(ab[2]), b[0].dot(ab[1]), b[1].dot(ab[2]), b[0].dot(ab[2])])
    }

    /// Principal values and directions by cyclic Jacobi rotations.
    ///
    /// Equal values need no special case: a rotation is skipped where the off-diagonal component is already nothing
    /// beside the diagonal, and no division ever has a zero divisor.
    #[inline(always)]
    pub fn eigensystem(&self) -> Eigensystem<R> {
        let mut a = self.to_tensor();
        let mut vectors = Tensor::identity();
        for _ in 0..JACOBI_SWEEPS {
            for (p, q) in [(0, 1), (1, 2), (0, 2)] {
                jacobi_rotation(&mut a, &mut vectors, p, q);
            }
        }
        let mut system = Eigensystem { values: [a.at(0, 0), a.at(1, 1), a.at(2, 2)], vectors };
        for (i, j) in [(0, 1), (1, 2), (0, 1)] {
            system.sort_pair(i, j);
        }
        system
    }
}

/// After four sweeps of a 3 × 3 tensor nothing is left to rotate (convergence is quadratic at first, cubic at last).
const JACOBI_SWEEPS: usize = 5;

/// One Jacobi rotation in the plane of `p` and `q` that removes the component (p, q) of `a`.
#[inline(always)]
fn jacobi_rotation<R: Real>(a: &mut Tensor<R>, vectors: &mut Tensor<R>, p: usize, q: usize) {
    let (one, zero) = (R::splat(1.0), R::splat(0.0));
    let off_diagonal = a.at(p, q);
    let diagonal = a.at(p, p).abs() + a.at(q, q).abs();
    let rotates = off_diagonal.abs().gt(diagonal * JACOBI_NOTHING) & off_diagonal.abs().gt(R::splat(f64::MIN_POSITIVE));
    if !rotates.any() {
        return;
    }
    // θ = (a_qq − a_pp)/(2 a_pq), t = tan φ = sign θ/(|θ| + √(θ² + 1)) (Golub & Van Loan, section 8.5); |θ| is bounded
    // so that its square stays finite
    let theta = (a.at(q, q) - a.at(p, p)) / (R::select(rotates, off_diagonal, one) * 2.0);
    let theta = theta.max(R::splat(-1e150)).min(R::splat(1e150));
    let tangent = (theta.abs() + theta.mul_add(theta, one).sqrt()).recip();
    let tangent = R::select(theta.lt(zero), -tangent, tangent);
    let tangent = R::select(rotates, tangent, zero);
    let cosine = tangent.mul_add(tangent, one).sqrt().recip();
    let sine = tangent * cosine;

    let r = 3 - p - q;
    let (a_rp, a_rq) = (a.at(r, p), a.at(r, q));
    a.columns[p].0[p] = a.at(p, p) - tangent * off_diagonal;
    a.columns[q].0[q] = a.at(q, q) + tangent * off_diagonal;
    let removed = R::select(rotates, zero, off_diagonal);
    a.columns[q].0[p] = removed;
    a.columns[p].0[q] = removed;
    let (new_rp, new_rq) = (cosine * a_rp - sine * a_rq, sine * a_rp + cosine * a_rq);
    a.columns[p].0[r] = new_rp;
    a.columns[r].0[p] = new_rp;
    a.columns[q].0[r] = new_rq;
    a.columns[r].0[q] = new_rq;
    let (v_p, v_q) = (vectors.columns[p], vectors.columns[q]);
    vectors.columns[p] = v_p * cosine - v_q * sine;
    vectors.columns[q] = v_p * sine + v_q * cosine;
}

/// An off-diagonal component this much smaller than the diagonal does not change the principal values' last bit.
const JACOBI_NOTHING: f64 = 1e-20;

impl<R: Real> Eigensystem<R> {
    #[inline(always)]
    fn sort_pair(&mut self, i: usize, j: usize) {
        let swap = self.values[i].lt(self.values[j]);
        let pick = |a: R, b: R| (R::select(swap, b, a), R::select(swap, a, b));
        (self.values[i], self.values[j]) = pick(self.values[i], self.values[j]);
        for row in 0..3 {
            let (first, second) = pick(self.vectors.at(row, i), self.vectors.at(row, j));
            self.vectors.columns[i].0[row] = first;
            self.vectors.columns[j].0[row] = second;
        }
    }
}

impl<R: Real> Add for SymmetricTensor<R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let (a, b) = (self.0, other.0);
        Self([a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3], a[4] + b[4], a[5] + b[5]])
    }
}

impl<R: Real> Sub for SymmetricTensor<R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let (a, b) = (self.0, other.0);
        Self([a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3], a[4] - b[4], a[5] - b[5]])
    }
}

impl<R: Real> Mul<R> for SymmetricTensor<R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: R) -> Self {
        let [xx, yy, zz, xy, yz, xz] = self.0;
        Self([xx * factor, yy * factor, zz * factor, xy * factor, yz * factor, xz * factor])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reconstruction_error(a: [f64; 6]) -> f64 {
        let a = SymmetricTensor(a);
        let system = a.eigensystem();
        let v = system.vectors;
        assert!((v.transpose_dot(&v) - Tensor::identity()).norm_squared() < 1e-28);
        assert!(system.values[0] >= system.values[1] && system.values[1] >= system.values[2]);
        let diagonal = SymmetricTensor([system.values[0], system.values[1], system.values[2], 0.0, 0.0, 0.0]);
        let scale = a.norm_squared().max(f64::MIN_POSITIVE);
        ((diagonal.pushed_by(&v) - a).norm_squared() / scale).sqrt()
    }

    #[test]
    fn principal_values_rebuild_the_tensor_also_where_they_are_equal() {
        for a in [
            [3.0, -1.0, 2.0, 0.4, -0.7, 0.2],
            [1.0, 1.0, 1.0, 0.0, 0.0, 0.0],
            [0.0; 6],
            [1.0, 1.0, 1.0, 1e-9, 0.0, 0.0],
            [2.0, 2.0, 5.0, 0.0, 0.0, 0.0],
            [1e-300, 2e-300, 3e-300, 1e-300, 0.0, 0.0],
            [1e9, 1e-9, 1.0, 1e3, 1e-3, 1.0],
            [0.0, 0.0, 0.0, 1.0, 1.0, 1.0],
        ] {
            let error = reconstruction_error(a);
            assert!(error < 1e-14, "{a:?}: {error}");
        }
    }

    #[test]
    fn pushing_forward_and_pulling_back_are_inverse_for_a_rotation() {
        let rotation = crate::Rotation::<f64>::about([0.3, -0.5, 0.8], 2.0).to_tensor();
        let a = SymmetricTensor([3.0, -1.0, 2.0, 0.4, -0.7, 0.2]);
        let error = a.pushed_by(&rotation).pulled_by(&rotation) - a;
        assert!(error.norm_squared() < 1e-29);
    }
}
