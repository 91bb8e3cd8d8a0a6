//! The parent of tets: the regular one whose corners are four of the cube ∓1. There 4 λ_i = 1 + Σ_k s_ik r_k with the signs
//! of corner i, so that derivatives by r are sums and differences of what belongs to the corners, and no corner is unlike the
//! others.

use estar_tensor::{Real, Tensor, Vector3};

/// Corners of a tet.
pub(crate) const CORNERS: usize = 4;

/// s_ik, where the corners of the parent are.
pub(crate) const SIGNS: [[f64; 3]; CORNERS] =
    [[-1.0, -1.0, -1.0], [-1.0, 1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, -1.0]];

/// Volume of the parent.
pub(crate) const VOLUME: f64 = 8.0 / 3.0;

/// ∂x/∂r_k = ¼ Σ_i s_ik ∂x/∂λ_i.
#[inline(always)]
pub(crate) fn gradient<R: Real>(slopes: &[Vector3<R>; CORNERS]) -> Tensor<R> {
    let [a, b, c, d] = *slopes;
    let quarter = R::splat(0.25);
    let (ab, cd) = (a - b, c - d);
    Tensor { columns: [(c + d - a - b) * quarter, (cd + ab) * -quarter, (cd - ab) * quarter] }
}

/// The transpose of [`gradient`].
#[inline(always)]
pub(crate) fn slopes<R: Real>(flux: &Tensor<R>) -> [Vector3<R>; CORNERS] {
    let quarter = R::splat(0.25);
    let [x, y, z] = flux.columns;
    let (x, y, z) = (x * quarter, y * quarter, z * quarter);
    let (sum, difference) = (y + z, y - z);
    [Vector3::zero() - x - sum, sum - x, x - difference, x + difference]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gradient_and_slopes_are_transposes_and_the_parent_is_its_own_gradient() {
        let itself = gradient(&SIGNS.map(Vector3));
        let identity = Tensor::<f64>::identity();
        for k in 0..3 {
            assert_eq!(itself.columns[k].0, identity.columns[k].0);
            let mut flux = Tensor::zero();
            flux.columns[k].0[0] = 4.0;
            assert_eq!(slopes(&flux).map(|slope| slope.0[0]), SIGNS.map(|signs| signs[k]));
        }
    }
}
