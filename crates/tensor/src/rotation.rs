//! Rotations as unit quaternions, and the rotation of the polar decomposition F = R U.

use crate::array::array;
use crate::real::{Mask, Real};
use crate::tensor::Tensor;
use crate::vector::Vector3;

/// A rotation, stored as a unit quaternion (w, x, y, z): four numbers that stay orthogonal to rounding for ever.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotation<R>(pub [R; 4]);

impl Rotation<f64> {
    /// The rotation by `angle` (rad) about `axis`, which need not have unit length.
    pub fn about(axis: [f64; 3], angle: f64) -> Self {
        let length = axis.iter().map(|c| c * c).sum::<f64>().sqrt();
        let (sine, cosine) = (0.5 * angle).sin_cos();
        Self([cosine, sine * axis[0] / length, sine * axis[1] / length, sine * axis[2] / length])
    }
}

impl<R: Real> Rotation<R> {
    /// No rotation.
    #[inline(always)]
    pub fn identity() -> Self {
        let zero = R::splat(0.0);
        Self([R::splat(1.0), zero, zero, zero])
    }

    /// The orthogonal tensor of the rotation.
    #[inline(always)]
    pub fn to_tensor(self) -> Tensor<R> {
        self.tensor(R::splat(2.0))
    }

    /// The orthogonal tensor of a quaternion of any length, from 2 over the square of that.
    #[inline(always)]
    fn tensor(self, two_per_norm_squared: R) -> Tensor<R> {
        let [w, x, y, z] = self.0;
        let (x2, y2, z2) = (x * two_per_norm_squared, y * two_per_norm_squared, z * two_per_norm_squared);
        let (wx, wy, wz) = (w * x2, w * y2, w * z2);
        let one = R::splat(1.0);
        let one_minus_zz = (-z2).mul_add(z, one);
        Tensor::from_rows([
            [(-y2).mul_add(y, one_minus_zz), x2.mul_add(y, -wz), x2.mul_add(z, wy)],
            [x2.mul_add(y, wz), (-x2).mul_add(x, one_minus_zz), y2.mul_add(z, -wx)],
            [x2.mul_add(z, -wy), y2.mul_add(z, wx), (-y2).mul_add(y, (-x2).mul_add(x, one))],
        ])
    }

    /// The rotation `self` followed by the one with the Gibbs vector `g` = tan(½ angle) × axis, when that is expressed
    /// in the frame that `self` has turned: the quaternion product self ∘ (1, g)/√(1 + g²).
    #[inline(always)]
    fn turned_by(self, g: Vector3<R>) -> Self {
        let [w, x, y, z] = self.0;
        let [a, b, c] = g.0;
        let product = [
            (-x).mul_add(a, (-y).mul_add(b, (-z).mul_add(c, w))),
            w.mul_add(a, y.mul_add(c, (-z).mul_add(b, x))),
            w.mul_add(b, z.mul_add(a, (-x).mul_add(c, y))),
            w.mul_add(c, x.mul_add(b, (-y).mul_add(a, z))),
        ];
        Self(product).normalised()
    }

    /// The quaternion scaled to unit length. Products of unit quaternions with small turns are so near to it that a
    /// series gives the last bit, without a root and a division; only where a lane is far off is the root taken.
    #[inline(always)]
    fn normalised(self) -> Self {
        let norm_squared = self.norm_squared();
        // (1 + e)^(−½) = 1 − ½ e + ⅜ e² − 5/16 e³ + …
        let excess = norm_squared - 1.0;
        let tail = excess.mul_add(R::splat(-0.3125), R::splat(0.375)).mul_add(excess, R::splat(-0.5));
        let mut scale = tail.mul_add(excess, R::splat(1.0));
        let near = excess.abs().lt(R::splat(SERIES_REACH));
        if !near.all() {
            scale = R::select(near, scale, norm_squared.sqrt().recip());
        }
        Self(array(|i| self.0[i] * scale))
    }

    /// The orthogonal tensor of the rotation half way from `self` to `other`, whose quaternions must be on one side:
    /// [`Rotation::nearest`] leaves its result on the side of the guess.
    #[inline(always)]
    pub fn half_way_to(self, other: Self) -> Tensor<R> {
        // the sum of both points half way, and its length is almost 2
        let sum = Self(array(|i| self.0[i] + other.0[i]));
        let norm_squared = sum.norm_squared();
        // 2/(4 − 4 e) = ½ (1 + e + e² + …)
        let shortfall = norm_squared.mul_add(R::splat(-0.25), R::splat(1.0));
        let tail = shortfall.mul_add(shortfall, shortfall).mul_add(shortfall, shortfall);
        let mut two_per_norm_squared = tail * 0.5 + 0.5;
        let near = shortfall.lt(R::splat(SERIES_REACH));
        if !near.all() {
            two_per_norm_squared = R::select(near, two_per_norm_squared, R::splat(2.0) / norm_squared);
        }
        sum.tensor(two_per_norm_squared)
    }

    #[inline(always)]
    fn norm_squared(self) -> R {
        let [w, x, y, z] = self.0;
        w.mul_add(w, x.mul_add(x, y.mul_add(y, z * z)))
    }

    #[inline(always)]
    fn select(mask: R::Mask, chosen: Self, otherwise: Self) -> Self {
        Self(array(|i| R::select(mask, chosen.0[i], otherwise.0[i])))
    }

    /// R of the polar decomposition F = R U of a `deformation_gradient` with det F > 0, or of any positive multiple of it,
    /// starting from a `guess`, on whose side the quaternion is.
    ///
    /// With M = R_gᵀ F for the guess R_g, the rotation Q that makes QᵀM symmetric gives R = R_g Q. Its Gibbs vector g
    /// solves A g = (1 − g²) h + (Mᵀg) × g with A = tr(M) I − M and 2 h the axial vector of M − Mᵀ: an equation whose
    /// coefficients stay while g is corrected, each correction being smaller than the last by the order of |g|. A guess
    /// too far off for that is turned by A⁻¹h, Newton's correction, and tried again; a lane that this does not lead home
    /// gets [`polar_rotation`]. A lane that is done keeps its bits.
    #[inline(always)]
    pub fn nearest(deformation_gradient: &Tensor<R>, guess: Self) -> Self {
        let (mut rotation, mut done) = guess.turned_towards(deformation_gradient);
        let mut turns = 1;
        while !done.all() && turns < MOST_TURNS {
            let (turned, arrived) = rotation.turned_towards(deformation_gradient);
            rotation = Self::select(done, rotation, turned);
            done = done | arrived;
            turns += 1;
        }
        if !done.all() {
            let found = Self::from_tensor(&polar_rotation(deformation_gradient));
            let ([w, x, y, z], [a, b, c, d]) = (found.0, guess.0);
            let cosine = w.mul_add(a, x.mul_add(b, y.mul_add(c, z * d)));
            let side = R::select(cosine.lt(R::splat(0.0)), R::splat(-1.0), R::splat(1.0));
            rotation = Self::select(done, rotation, Self(array(|i| found.0[i] * side)));
        }
        rotation
    }

    /// One turn from the guess `self`, and where it has led to the rotation of the polar decomposition.
    #[inline(always)]
    fn turned_towards(self, deformation_gradient: &Tensor<R>) -> (Self, R::Mask) {
        let m = self.to_tensor().transpose_dot(deformation_gradient);
        let axial = Vector3([m.at(2, 1) - m.at(1, 2), m.at(0, 2) - m.at(2, 0), m.at(1, 0) - m.at(0, 1)]);
        let h = axial * R::splat(0.5);
        // of −A, with cof(−A) = cof A
        let negative = m.plus_spherical(-m.trace());
        let cofactor = negative.cofactor();
        let determinant = -negative.columns[0].dot(cofactor.columns[0]);
        let per_determinant = determinant.recip();
        // other rotations make M symmetric as well; at the one of F = R U alone, A is positive definite (minors)
        let zero = R::splat(0.0);
        let positive_definite = negative.at(0, 0).lt(zero) & cofactor.at(2, 2).gt(zero) & determinant.gt(zero);

        let first = cofactor.transpose_apply(h) * per_determinant;
        let mut change_squared = first.dot(first);
        let near = change_squared.lt(R::splat(REACH_SQUARED)) & positive_definite;
        let mut gibbs = first;
        let mut settled = zero.lt(zero);
        for _ in 0..MOST_CORRECTIONS {
            let shrink = R::splat(1.0) - gibbs.dot(gibbs);
            let source = h.mul_add(shrink, m.transpose_apply(gibbs).cross(gibbs));
            let corrected = cofactor.transpose_apply(source) * per_determinant;
            let change = corrected - gibbs;
            gibbs = Vector3::select(settled, gibbs, corrected);
            // the next correction would be smaller than this one by as much as this one is than the last
            let squared = change.dot(change);
            settled = settled | (squared * squared).le(change_squared * (ROUNDING * ROUNDING));
            change_squared = squared;
            if (settled | !near).all() {
                break;
            }
        }
        if !near.all() {
            gibbs = Vector3::select(near, gibbs, first);
        }
        (self.turned_by(gibbs), near & settled)
    }

    /// The quaternion of an orthogonal tensor with determinant 1, from the column of 4 q ⊗ q that has the largest
    /// diagonal (Shepperd 1978).
    #[inline(always)]
    pub fn from_tensor(rotation: &Tensor<R>) -> Self {
        let r = |i, j| rotation.at(i, j);
        let one = R::splat(1.0);
        let (sum_yz, sum_xz, sum_xy) = (r(2, 1) + r(1, 2), r(0, 2) + r(2, 0), r(1, 0) + r(0, 1));
        let (skew_x, skew_y, skew_z) = (r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1));
        let columns = [
            [one + r(0, 0) + r(1, 1) + r(2, 2), skew_x, skew_y, skew_z],
            [skew_x, one + r(0, 0) - r(1, 1) - r(2, 2), sum_xy, sum_xz],
            [skew_y, sum_xy, one - r(0, 0) + r(1, 1) - r(2, 2), sum_yz],
            [skew_z, sum_xz, sum_yz, one - r(0, 0) - r(1, 1) + r(2, 2)],
        ];
        let mut best = columns[0];
        let mut largest = columns[0][0];
        for (i, column) in columns.iter().enumerate().skip(1) {
            let larger = column[i].gt(largest);
            largest = R::select(larger, column[i], largest);
            best = array(|k| R::select(larger, column[k], best[k]));
        }
        Self(best).normalised()
    }
}

/// An excess, or a shortfall, below which the series of (1 + e)^(−½) and 1/(1 − e) are exact to the last bit.
const SERIES_REACH: f64 = 1e-4;
/// Turns before a guess is given up. From 75° off a rigid rotation takes three, from 89° seven.
const MOST_TURNS: usize = 8;
/// Where |g| = tan(½ angle) is below 0.1, corrections shrink fast.
const REACH_SQUARED: f64 = 0.01;
/// Corrections after the first; two are enough for turns below 10⁻³.
const MOST_CORRECTIONS: usize = 8;
/// An error of g that is rounding.
const ROUNDING: f64 = 1e-15;

/// R of the polar decomposition F = R U for any F with det F > 0, by Newton's iteration
/// R ← ½ (ζ R + ζ⁻¹ R⁻ᵀ), ζ² = ‖R⁻¹‖/‖R‖ (Higham 1986).
#[inline(always)]
pub fn polar_rotation<R: Real>(deformation_gradient: &Tensor<R>) -> Tensor<R> {
    let mut rotation = *deformation_gradient;
    let mut done = R::splat(1.0).lt(R::splat(0.0));
    for _ in 0..MOST_NEWTON_STEPS {
        let inverse_transposed = rotation.inverse().transpose();
        let scale_squared = (inverse_transposed.norm_squared() / rotation.norm_squared()).sqrt();
        let scale = scale_squared.sqrt();
        let next = (rotation * (scale * 0.5)) + (inverse_transposed * (scale.recip() * 0.5));
        let change = (next - rotation).norm_squared();
        for j in 0..3 {
            for i in 0..3 {
                rotation.columns[j].0[i] = R::select(done, rotation.at(i, j), next.at(i, j));
            }
        }
        // the iteration is quadratic: after a change of 1e-9 the error is at rounding
        done = done | change.lt(R::splat(1e-18));
        if done.all() {
            break;
        }
    }
    rotation
}

/// Stretches of 10⁶ to 1 converge in nine.
const MOST_NEWTON_STEPS: usize = 12;

#[cfg(test)]
mod tests {
    use super::*;

    fn stretch(a: f64, b: f64, c: f64) -> Tensor<f64> {
        let frame = Rotation::<f64>::about([0.2, 0.9, -0.4], 1.1).to_tensor();
        crate::SymmetricTensor([a, b, c, 0.0, 0.0, 0.0]).pushed_by(&frame).to_tensor()
    }

    fn distance(a: &Tensor<f64>, b: &Tensor<f64>) -> f64 {
        (*a - *b).norm_squared().sqrt()
    }

    #[test]
    fn polar_decomposition_recovers_the_rotation_of_any_stretch() {
        for (a, b, c) in [(1.0, 1.0, 1.0), (2.0, 0.5, 1.0), (1e3, 1e-3, 1.0), (1.0, 1.0, 7.0), (1e-2, 1e-2, 1e2)] {
            for angle in [0.0, 0.3, 1.5, 3.0] {
                let rotation = Rotation::<f64>::about([0.3, -0.5, 0.8], angle).to_tensor();
                let f = rotation.dot(&stretch(a, b, c));
                let tolerance = 1e-15 * a.max(b).max(c) / a.min(b).min(c) + 1e-14;
                assert!(distance(&polar_rotation(&f), &rotation) < tolerance, "{a} {b} {c} {angle}");
            }
        }
    }

    #[test]
    fn a_guess_near_or_far_leads_to_the_rotation_of_the_polar_decomposition() {
        for (a, b, c) in [(1.0, 1.0, 1.0), (2.0, 0.4, 1.3), (0.05, 3.0, 3.0)] {
            for angle in [0.0, 1e-9, 1e-4, 0.1, 1.3, 2.6, 3.1] {
                let rotation = Rotation::<f64>::about([0.3, -0.5, 0.8], angle).to_tensor();
                let f = rotation.dot(&stretch(a, b, c));
                let found = Rotation::nearest(&f, Rotation::identity()).to_tensor();
                assert!(distance(&found, &rotation) < 2e-14, "{a} {b} {c} {angle}: {}", distance(&found, &rotation));
            }
        }
    }

    #[test]
    fn quaternion_and_tensor_of_a_rotation_agree() {
        for angle in [0.0, 0.5, 2.0, 3.1, 4.0] {
            for axis in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.3, -0.5, 0.8]] {
                let tensor = Rotation::<f64>::about(axis, angle).to_tensor();
                let again = Rotation::from_tensor(&tensor).to_tensor();
                assert!(distance(&tensor, &again) < 1e-15);
                assert!(distance(&tensor.transpose_dot(&tensor), &Tensor::identity()) < 1e-15);
            }
        }
    }
}
