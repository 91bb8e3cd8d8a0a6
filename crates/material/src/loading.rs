//! Loading criteria of the strain-space formulation, for the E* theory (de Vera 2016, eq. 3.10, 3.15, 5.104, 6.30).
//!
//! Yield function g_* = ½ τ̃ : τ̃ − K² with τ̃ = dev T̃ = 2μ dev E_* and √3 K = σ_y (dV 7.76, 7.78); its rate at fixed plastic
//! strain is the loading index ĝ = Γ : D with Γ = F_* (∂g_*/∂E_*) F_*ᵀ. Since ∂g_*/∂E_* = 2μ τ̃ and F_* = V_* R_*,
//! Γ = 2μ V_* dev T V_*, which is 2μ dev T (I + 2 R_* E_* R_*ᵀ): all have the principal axes of T.
//!
//! The source prints the yield function once without deviators (dV 5.85); dV 7.76 has them.
//!
//! What is told of a point, no part of a step: numbers are `f64`.

use crate::IsotropicElasticity;
use crate::factors::elastic_strain;
use estar_tensor::SymmetricTensor;

/// What a motion does to a state of stress.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loading {
    /// g < 0.
    Elastic,
    /// g = 0, ĝ < 0.
    Unloading,
    /// g = 0, ĝ = 0.
    Neutral,
    /// g = 0, ĝ > 0: plastic flow.
    Plastic,
}

/// Yield function and loading normal at a state of the E* theory.
#[derive(Clone, Copy, Debug)]
pub struct LoadingCriterion {
    yield_function: f64,
    normal: SymmetricTensor<f64>,
    /// K², Pa².
    radius_squared: f64,
}

/// A g this small beside K² is 0.
const ON_SURFACE: f64 = 1e-9;

/// Γ = 2μ dev T (I + 2 R_* E_* R_*ᵀ) at the Cauchy stress T; Pa².
pub fn loading_normal(elasticity: &IsotropicElasticity, stress: &SymmetricTensor<f64>) -> SymmetricTensor<f64> {
    // I + 2 R_* E_* R_*ᵀ, and the product of two tensors with the same axes
    let elastic_metric = (elastic_strain(elasticity, stress) * 2.0).plus_spherical(1.0);
    let product = stress.deviator().to_tensor().dot(&elastic_metric.to_tensor()).symmetric_part();
    product * (2.0 * elasticity.shear_modulus())
}

impl LoadingCriterion {
    /// At the Cauchy stress T, where the flow stress is σ_y; Pa.
    pub fn new(elasticity: &IsotropicElasticity, stress: &SymmetricTensor<f64>, flow_stress: f64) -> Self {
        let radius_squared = flow_stress * flow_stress / 3.0;
        Self {
            yield_function: 0.5 * stress.deviator().norm_squared() - radius_squared,
            normal: loading_normal(elasticity, stress),
            radius_squared,
        }
    }

    /// g, Pa².
    pub fn yield_function(&self) -> f64 {
        self.yield_function
    }

    /// Γ, Pa².
    pub fn normal(&self) -> &SymmetricTensor<f64> {
        &self.normal
    }

    /// ĝ = Γ : D, Pa²/s, of the rate of deformation D (1/s).
    pub fn index(&self, rate_of_deformation: &SymmetricTensor<f64>) -> f64 {
        self.normal.double_dot(rate_of_deformation)
    }

    /// What the rate of deformation does (dV 3.15).
    pub fn loading(&self, rate_of_deformation: &SymmetricTensor<f64>) -> Loading {
        let index = self.index(rate_of_deformation);
        if self.yield_function < -ON_SURFACE * self.radius_squared {
            Loading::Elastic
        } else if index < 0.0 {
            Loading::Unloading
        } else if index > 0.0 {
            Loading::Plastic
        } else {
            Loading::Neutral
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::point::MaterialPoint;
    use crate::{EStar, EStarTotal, ElasticConstant, IsotropicHardening, Material};
    use estar_tensor::Tensor;

    const YIELD: f64 = 260e6;

    fn solid() -> IsotropicElasticity {
        let constants = (ElasticConstant::YoungModulus(200e9), ElasticConstant::PoissonRatio(0.32));
        IsotropicElasticity::new(7850.0, constants.0, constants.1).unwrap()
    }

    fn simple_shear(gamma: f64) -> Tensor<f64> {
        Tensor::from_rows([[1.0, gamma, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    }

    #[test]
    fn the_index_is_the_rate_of_the_yield_function_at_fixed_plastic_strain() {
        let law = IsotropicHardening::perfect(100.0 * YIELD).unwrap();
        let material = EStarTotal::new(solid(), law);
        let gradient = Tensor::from_rows([[1.02, 0.03, 0.0], [0.01, 0.97, 0.02], [0.0, -0.01, 1.01]]);
        let rate = Tensor::from_rows([[0.3, 0.7, -0.2], [0.1, -0.8, 0.4], [-0.5, 0.2, 0.6]]);
        let criterion = |time: f64| {
            let mut point = MaterialPoint::new(&material);
            point.advance(&(rate * time).plus_spherical(1.0).dot(&gradient), 1.0);
            assert_eq!(point.equivalent_plastic_strain(), 0.0);
            LoadingCriterion::new(&solid(), point.stress(), YIELD)
        };
        let step = 1e-6;
        let difference = (criterion(step).yield_function() - criterion(-step).yield_function()) / (2.0 * step);
        let index = criterion(0.0).index(&rate.symmetric_part());
        assert!((index / difference - 1.0).abs() < 1e-8, "{index:e} {difference:e}");
    }

    /// The criterion at the point and D of the next step along simple shear.
    fn criterion<M: Material>(point: &MaterialPoint<'_, M>, flow_stress: f64) -> LoadingCriterion {
        LoadingCriterion::new(&solid(), point.stress(), flow_stress)
    }

    #[test]
    fn a_shear_loads_and_unloads() {
        let material = EStar::new(solid(), IsotropicHardening::perfect(YIELD).unwrap(), ());
        let forward = (simple_shear(1.0) - Tensor::identity()).symmetric_part();
        let mut point = MaterialPoint::new(&material);
        point.advance(&simple_shear(0.001), 1.0);
        assert_eq!(criterion(&point, YIELD).loading(&forward), Loading::Elastic);
        point.advance(&simple_shear(0.01), 1.0);
        let on_surface = criterion(&point, YIELD);
        assert!(on_surface.yield_function().abs() < 1e-12 * YIELD * YIELD);
        assert_eq!(on_surface.loading(&forward), Loading::Plastic);
        assert_eq!(on_surface.loading(&(forward * -1.0)), Loading::Unloading);
        assert_eq!(on_surface.loading(&SymmetricTensor::zero()), Loading::Neutral);
    }

    #[test]
    fn hardening_is_the_share_of_the_index_that_the_stress_follows() {
        // Φ = f̂/ĝ = H/(3μ + H) (dV 3.28), but for the size of the elastic strain
        let modulus = 40e9;
        let law = IsotropicHardening::linear(YIELD, modulus).unwrap();
        let material = EStar::new(solid(), law.clone(), ());
        let mut point = MaterialPoint::new(&material);
        point.advance(&simple_shear(0.005), 1.0);
        let half_square =
            |point: &MaterialPoint<'_, EStar<(), IsotropicHardening>>| 0.5 * point.stress().deviator().norm_squared();
        let old = point.clone();
        let step = 1e-6;
        point.advance(&simple_shear(0.005 + step), step);
        let flow_stress = law.at(old.equivalent_plastic_strain()).stress;
        let rate = (simple_shear(1.0) - Tensor::identity()).symmetric_part();
        let index = criterion(&old, flow_stress).index(&rate);
        let ratio = (half_square(&point) - half_square(&old)) / step / index;
        // the index of a point is the same, but for the size of the elastic strain
        let of_point = point.observation().loading_index.unwrap();
        assert!((of_point / index - 1.0).abs() < 4.0 * flow_stress / 200e9, "{of_point:e} {index:e}");
        let expected = modulus / (3.0 * solid().shear_modulus() + modulus);
        assert!((ratio / expected - 1.0).abs() < 4.0 * flow_stress / 200e9, "{ratio} {expected}");
    }
}
