//! The principal logarithm of a tensor without symmetry.
//!
//! Square roots by the product form of Denman & Beavers' iteration bring it near I; there ln X = 2 artanh((X − I)(X + I)⁻¹),
//! and ln A = 2ⁿ ln A^(1/2ⁿ) (Cheng, Higham, Kenney & Laub, SIAM J. Matrix Anal. Appl. 22, 2001). Digits are lost as the ratio of
//! the principal values grows.

use estar_tensor::{Mask, Real, Tensor};

/// Square roots that bring any tensor that numbers can hold near I.
const MOST_ROOTS: usize = 16;
/// Steps of the iteration for one square root; it takes about half the binary logarithm of the condition and six more.
const MOST_STEPS: usize = 48;
/// Distance from I from which the series is exact to rounding.
const NEAR: f64 = 0.2;
/// Distance of M from I at which a root is one to rounding.
const ROOTED: f64 = 1e-14;
/// Odd powers of the series: (½ · 0.2/0.9)^21 is below 10⁻¹⁹.
const ODD_POWERS: usize = 10;

/// ln A; not a number where A has a principal value on the negative axis, where there is no principal logarithm.
pub(crate) fn logarithm<R: Real>(tensor: &Tensor<R>) -> Tensor<R> {
    let near = R::splat(NEAR * NEAR);
    let mut root = *tensor;
    let mut scale = R::splat(2.0);
    let is_far = |root: &Tensor<R>| !distance_squared(root).le(near);
    for _ in 0..MOST_ROOTS {
        let far = is_far(&root);
        if !far.any() {
            break;
        }
        root = select(far, &square_root(&root), &root);
        scale = R::select(far, scale * 2.0, scale);
    }
    let one = R::splat(1.0);
    // W = (X − I)(X + I)⁻¹, artanh W = W (I + W²/3 + W⁴/5 + …)
    let w = root.plus_spherical(-one).dot(&root.plus_spherical(one).inverse());
    let square = w.dot(&w);
    let mut sum = Tensor::identity() * R::splat(1.0 / (2 * ODD_POWERS + 1) as f64);
    for power in (0..ODD_POWERS).rev() {
        sum = square.dot(&sum).plus_spherical(R::splat(1.0 / (2 * power + 1) as f64));
    }
    let nowhere = R::select(is_far(&root), R::splat(f64::NAN), one);
    w.dot(&sum) * (scale * nowhere)
}

/// A^½: Y ← ½ Y (I + M⁻¹), M ← ½ (I + ½ (M + M⁻¹)) from Y = M = A, until M = I. A lane that has converged keeps its bits.
fn square_root<R: Real>(tensor: &Tensor<R>) -> Tensor<R> {
    let (mut root, mut rest) = (*tensor, *tensor);
    let one = R::splat(1.0);
    for _ in 0..MOST_STEPS {
        let moves = !distance_squared(&rest).le(R::splat(ROOTED * ROOTED));
        if !moves.any() {
            break;
        }
        let inverse = rest.inverse();
        root = select(moves, &(root.dot(&inverse.plus_spherical(one)) * R::splat(0.5)), &root);
        rest = select(moves, &(((rest + inverse) * R::splat(0.5)).plus_spherical(one) * R::splat(0.5)), &rest);
    }
    root
}

/// ‖A − I‖².
fn distance_squared<R: Real>(tensor: &Tensor<R>) -> R {
    tensor.plus_spherical(R::splat(-1.0)).norm_squared()
}

/// `chosen` where the mask is set, else `otherwise`.
fn select<R: Real>(mask: R::Mask, chosen: &Tensor<R>, otherwise: &Tensor<R>) -> Tensor<R> {
    Tensor::from_rows(std::array::from_fn(|i| {
        std::array::from_fn(|j| R::select(mask, chosen.at(i, j), otherwise.at(i, j)))
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use estar_tensor::Rotation;

    fn error(found: &Tensor<f64>, wanted: &Tensor<f64>) -> f64 {
        ((*found - *wanted).norm_squared() / wanted.norm_squared().max(1.0)).sqrt()
    }

    #[test]
    fn it_is_the_inverse_of_the_exponential() {
        // similar to diag(a, b, c), and with a pair of complex principal values
        let basis = Tensor::from_rows([[1.0, 0.4, -0.3], [0.2, 1.1, 0.5], [-0.6, 0.1, 0.9]]);
        let similar = |x: Tensor<f64>| basis.dot(&x).dot(&basis.inverse());
        for values in [[0.0, 0.0, 0.0], [1e-9, -2e-9, 3e-9], [0.1, -0.2, 0.3], [3.0, -2.0, 1.0]] {
            let diagonal = |values: [f64; 3]| {
                Tensor::from_rows([[values[0], 0.0, 0.0], [0.0, values[1], 0.0], [0.0, 0.0, values[2]]])
            };
            let found = logarithm(&similar(diagonal(values.map(f64::exp))));
            let wanted = similar(diagonal(values));
            // beside a principal value of e³ that of e⁻² has lost the digits of e⁵
            let rounding = 1e-15 * (values[0] - values[1]).abs().exp().max(10.0);
            assert!(error(&found, &wanted) < rounding, "{values:?}: {}", error(&found, &wanted));
        }
        for (angle, growth) in [(0.01, 0.0), (1.0, 0.3), (3.0, -1.0)] {
            let turn = Rotation::<f64>::about([0.0, 0.0, 1.0], angle).to_tensor() * f64::exp(growth);
            let rows = [[growth, -angle, 0.0], [angle, growth, 0.0], [0.0, 0.0, growth]];
            let wanted = similar(Tensor::from_rows(rows));
            let found = logarithm(&similar(turn));
            assert!(error(&found, &wanted) < 1e-13, "{angle}: {}", error(&found, &wanted));
        }
    }

    #[test]
    fn there_is_none_of_a_negative_principal_value() {
        let rows = [[-1.0, 0.3, 0.0], [0.0, 2.0, 0.1], [0.0, 0.0, 1.0]];
        assert!(logarithm(&Tensor::from_rows(rows)).norm_squared().is_nan());
        assert!(logarithm(&Tensor::<f64>::zero()).norm_squared().is_nan());
        assert!(logarithm(&Tensor::from_rows([[f64::NAN; 3]; 3])).norm_squared().is_nan());
    }
}
