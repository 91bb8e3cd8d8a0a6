//! The unique factors of the deformation gradient, F = R_* U_* U_p: plastic right stretch, elastic right stretch, rotation
//! (de Vera 2016, eq. 4.27, 4.55).
//!
//! What is told of a point, no part of a step: numbers are `f64`.

use crate::IsotropicElasticity;
use estar_tensor::{SymmetricTensor, Tensor};

/// F = R_* U_* U_p.
#[derive(Clone, Copy, Debug)]
pub struct Factors {
    /// Rotation R_*.
    pub rotation: Tensor<f64>,
    /// Elastic right stretch U_*.
    pub elastic_stretch: SymmetricTensor<f64>,
    /// Plastic right stretch U_p = √C_p.
    pub plastic_stretch: SymmetricTensor<f64>,
}

impl Factors {
    /// The factors of a deformation gradient with det F > 0, from the plastic metric C_p = U_p².
    pub fn new(deformation_gradient: &Tensor<f64>, plastic_metric: &SymmetricTensor<f64>) -> Self {
        let plastic_stretch = of_principal_values(plastic_metric, f64::sqrt);
        // F_* = F U_p⁻¹ = R_* U_*
        let elastic_gradient = deformation_gradient.dot(&plastic_stretch.to_tensor().inverse());
        let elastic_stretch = of_principal_values(&metric(&elastic_gradient), f64::sqrt);
        let rotation = elastic_gradient.dot(&elastic_stretch.to_tensor().inverse());
        Self { rotation, elastic_stretch, plastic_stretch }
    }

    /// E_* = ½ (U_*² − I) (dV 4.48).
    pub fn elastic_strain(&self) -> SymmetricTensor<f64> {
        strain(&self.elastic_stretch.square())
    }

    /// E_p = ½ (U_p² − I) (dV 4.49).
    pub fn plastic_strain(&self) -> SymmetricTensor<f64> {
        strain(&self.plastic_stretch.square())
    }
}

/// FᵀF.
pub(crate) fn metric(gradient: &Tensor<f64>) -> SymmetricTensor<f64> {
    gradient.transpose_dot(gradient).symmetric_part()
}

/// ½ (C − I).
pub(crate) fn strain(metric: &SymmetricTensor<f64>) -> SymmetricTensor<f64> {
    metric.plus_spherical(-1.0) * 0.5
}

/// E_* of a rotated stress: T̃ = 2μ dev E_* + k tr(E_*) I (dV 7.36, 7.37).
pub(crate) fn elastic_strain(
    elasticity: &IsotropicElasticity,
    rotated_stress: &SymmetricTensor<f64>,
) -> SymmetricTensor<f64> {
    let deviator = rotated_stress.deviator() * (0.5 / elasticity.shear_modulus());
    deviator.plus_spherical(rotated_stress.trace() / (9.0 * elasticity.bulk_modulus()))
}

/// C_* = U_*² of a rotated stress T̃ = 2μ dev ln U_* + k tr(ln U_*) I: the rate form's elastic strain is logarithmic.
pub(crate) fn elastic_metric(
    elasticity: &IsotropicElasticity,
    rotated_stress: &SymmetricTensor<f64>,
) -> SymmetricTensor<f64> {
    of_principal_values(&(elastic_strain(elasticity, rotated_stress) * 2.0), f64::exp)
}

/// C_p = U_p² from C_* = U_*² and C: U_p C_* U_p = C has one solution with positive stretches,
/// U_p = C_*^(−½) (C_*^½ C C_*^½)^½ C_*^(−½).
pub(crate) fn plastic_metric_under(
    elastic_metric: &SymmetricTensor<f64>,
    metric: &SymmetricTensor<f64>,
) -> SymmetricTensor<f64> {
    let root = of_principal_values(elastic_metric, f64::sqrt).to_tensor();
    let between = of_principal_values(&metric.pulled_by(&root), f64::sqrt);
    between.pulled_by(&root.inverse()).square()
}

/// Σ function(aᵢ) vᵢ ⊗ vᵢ.
fn of_principal_values(tensor: &SymmetricTensor<f64>, function: impl Fn(f64) -> f64) -> SymmetricTensor<f64> {
    let system = tensor.eigensystem();
    let [a, b, c] = system.values.map(function);
    SymmetricTensor([a, b, c, 0.0, 0.0, 0.0]).pushed_by(&system.vectors)
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRADIENT: [[f64; 3]; 3] = [[1.3, 0.7, -0.2], [0.1, 0.8, 0.4], [-0.5, 0.2, 1.1]];

    fn distance(a: &Tensor<f64>, b: &Tensor<f64>) -> f64 {
        (*a - *b).norm_squared().sqrt()
    }

    #[test]
    fn the_factors_are_a_rotation_and_two_stretches_whose_product_is_the_deformation_gradient() {
        let gradient = Tensor::from_rows(GRADIENT);
        let plastic_metric = SymmetricTensor([1.5, 0.9, 0.8, 0.3, -0.1, 0.2]);
        let factors = Factors::new(&gradient, &plastic_metric);
        let product =
            factors.rotation.dot(&factors.elastic_stretch.to_tensor()).dot(&factors.plastic_stretch.to_tensor());
        assert!(distance(&product, &gradient) < 1e-14);
        assert!(distance(&factors.rotation.transpose_dot(&factors.rotation), &Tensor::identity()) < 1e-14);
        assert!(distance(&factors.plastic_stretch.square().to_tensor(), &plastic_metric.to_tensor()) < 1e-14);
        // E_* = U_p⁻¹ (E − E_p) U_p⁻¹ (dV 4.48)
        let difference = strain(&metric(&gradient)) - factors.plastic_strain();
        let pulled = difference.pulled_by(&factors.plastic_stretch.to_tensor().inverse());
        assert!(distance(&pulled.to_tensor(), &factors.elastic_strain().to_tensor()) < 1e-14);
    }

    #[test]
    fn the_plastic_metric_under_an_elastic_strain_leaves_that_strain() {
        let gradient = Tensor::from_rows(GRADIENT);
        let elastic = SymmetricTensor([0.02, -0.01, 0.005, 0.01, -0.003, 0.002]);
        let elastic_metric = (elastic * 2.0).plus_spherical(1.0);
        let plastic_metric = plastic_metric_under(&elastic_metric, &metric(&gradient));
        let found = Factors::new(&gradient, &plastic_metric).elastic_strain();
        assert!((found - elastic).norm_squared().sqrt() < 1e-14);
    }
}
