//! Density and the two constants of isotropic elasticity.

use crate::parameter::{ParameterError, checked, positive};
use estar_tensor::{Real, array};

/// Density ρ (kg/m³) and the isotropic elastic constants, valid by construction: ρ > 0, μ > 0, k > 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IsotropicElasticity {
    density: f64,
    shear_modulus: f64,
    bulk_modulus: f64,
}

/// One of the five constants of isotropic elasticity, in Pa (Poisson's ratio is a pure number). Any two of different
/// kind determine the others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ElasticConstant {
    /// Young's modulus E.
    YoungModulus(f64),
    /// Poisson's ratio ν, −1 < ν < ½.
    PoissonRatio(f64),
    /// Bulk modulus k.
    BulkModulus(f64),
    /// Shear modulus μ.
    ShearModulus(f64),
    /// First Lamé constant λ.
    LameLambda(f64),
}

impl IsotropicElasticity {
    /// The elasticity of density `density` that has both given constants.
    ///
    /// # Errors
    /// A constant out of its bounds, two constants of the same kind, or a pair that no stable solid has.
    pub fn new(density: f64, first: ElasticConstant, second: ElasticConstant) -> Result<Self, ParameterError> {
        use ElasticConstant::{BulkModulus, LameLambda, PoissonRatio, ShearModulus, YoungModulus};
        let density = positive("density", density)?;
        for constant in [first, second] {
            constant.check()?;
        }
        // (first, second) in the order of the enum's variants, so that each pair stands once below
        let (first, second) = if first.rank() <= second.rank() { (first, second) } else { (second, first) };
        let from_young_poisson = |e: f64, nu: f64| (e / (2.0 * (1.0 + nu)), e / (3.0 * (1.0 - 2.0 * nu)));
        let (shear_modulus, bulk_modulus) = match (first, second) {
            (YoungModulus(e), PoissonRatio(nu)) => from_young_poisson(e, nu),
            (YoungModulus(e), BulkModulus(k)) => (3.0 * k * e / (9.0 * k - e), k),
            (YoungModulus(e), ShearModulus(mu)) => (mu, e * mu / (3.0 * (3.0 * mu - e))),
            (YoungModulus(e), LameLambda(lambda)) => {
                let root = (e * e + 9.0 * lambda * lambda + 2.0 * e * lambda).sqrt();
                ((e - 3.0 * lambda + root) / 4.0, (e + 3.0 * lambda + root) / 6.0)
            }
            (PoissonRatio(nu), BulkModulus(k)) => (3.0 * k * (1.0 - 2.0 * nu) / (2.0 * (1.0 + nu)), k),
            (PoissonRatio(nu), ShearModulus(mu)) => (mu, 2.0 * mu * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu))),
            (PoissonRatio(nu), LameLambda(lambda)) => {
                (lambda * (1.0 - 2.0 * nu) / (2.0 * nu), lambda * (1.0 + nu) / (3.0 * nu))
            }
            (BulkModulus(k), ShearModulus(mu)) => (mu, k),
            (BulkModulus(k), LameLambda(lambda)) => (1.5 * (k - lambda), k),
            (ShearModulus(mu), LameLambda(lambda)) => (mu, lambda + 2.0 * mu / 3.0),
            (constant, _) => {
                return Err(ParameterError {
                    parameter: constant.name(),
                    value: constant.value(),
                    bound: "two different elastic constants are needed",
                });
            }
        };
        let stable = |value: f64| value > 0.0;
        let bound = "the two elastic constants together must give a positive shear modulus and bulk modulus";
        Ok(Self {
            density,
            shear_modulus: checked("shear_modulus", shear_modulus, stable, bound)?,
            bulk_modulus: checked("bulk_modulus", bulk_modulus, stable, bound)?,
        })
    }

    /// Density ρ, kg/m³.
    pub fn density(&self) -> f64 {
        self.density
    }

    /// Shear modulus μ, Pa.
    pub fn shear_modulus(&self) -> f64 {
        self.shear_modulus
    }

    /// Bulk modulus k, Pa.
    pub fn bulk_modulus(&self) -> f64 {
        self.bulk_modulus
    }

    /// First Lamé constant λ = k − ⅔ μ, Pa.
    pub fn lame_lambda(&self) -> f64 {
        self.bulk_modulus - 2.0 * self.shear_modulus / 3.0
    }

    /// P-wave modulus k + 4μ/3, Pa.
    pub fn p_wave_modulus(&self) -> f64 {
        self.bulk_modulus + 4.0 * self.shear_modulus / 3.0
    }

    /// σᵢ = 2μ εᵢ + λ tr ε, Pa, of principal strains.
    #[inline(always)]
    pub fn principal_stress<R: Real>(&self, strain: [R; 3]) -> [R; 3] {
        let spherical = (strain[0] + strain[1] + strain[2]) * self.lame_lambda();
        array(|i| strain[i].mul_add(R::splat(2.0 * self.shear_modulus), spherical))
    }

    /// Young's modulus E = 9kμ/(3k + μ), Pa.
    pub fn young_modulus(&self) -> f64 {
        9.0 * self.bulk_modulus * self.shear_modulus / (3.0 * self.bulk_modulus + self.shear_modulus)
    }

    /// Poisson's ratio ν = (3k − 2μ)/(2(3k + μ)).
    pub fn poisson_ratio(&self) -> f64 {
        (3.0 * self.bulk_modulus - 2.0 * self.shear_modulus) / (2.0 * (3.0 * self.bulk_modulus + self.shear_modulus))
    }
}

impl ElasticConstant {
    /// The deck's name of the constant.
    pub fn name(self) -> &'static str {
        match self {
            Self::YoungModulus(_) => "young_modulus",
            Self::PoissonRatio(_) => "poisson_ratio",
            Self::BulkModulus(_) => "bulk_modulus",
            Self::ShearModulus(_) => "shear_modulus",
            Self::LameLambda(_) => "lame_lambda",
        }
    }

    fn value(self) -> f64 {
        match self {
            Self::YoungModulus(value)
            | Self::PoissonRatio(value)
            | Self::BulkModulus(value)
            | Self::ShearModulus(value)
            | Self::LameLambda(value) => value,
        }
    }

    fn rank(self) -> u8 {
        match self {
            Self::YoungModulus(_) => 0,
            Self::PoissonRatio(_) => 1,
            Self::BulkModulus(_) => 2,
            Self::ShearModulus(_) => 3,
            Self::LameLambda(_) => 4,
        }
    }

    fn check(self) -> Result<(), ParameterError> {
        match self {
            Self::PoissonRatio(value) => {
                checked("poisson_ratio", value, |nu| -1.0 < nu && nu < 0.5, "it must lie between -1 and 0.5")
            }
            Self::LameLambda(value) => checked("lame_lambda", value, |_| true, "it must be finite"),
            other => positive(other.name(), other.value()),
        }
        .map(|_| ())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pair_of_constants_gives_the_same_solid() {
        for poisson_ratio in [-0.3, 0.2, 0.35, 0.499] {
            let solid = IsotropicElasticity::new(
                8930.0,
                ElasticConstant::YoungModulus(117e9),
                ElasticConstant::PoissonRatio(poisson_ratio),
            )
            .unwrap();
            let constants = [
                ElasticConstant::YoungModulus(solid.young_modulus()),
                ElasticConstant::PoissonRatio(solid.poisson_ratio()),
                ElasticConstant::BulkModulus(solid.bulk_modulus()),
                ElasticConstant::ShearModulus(solid.shear_modulus()),
                ElasticConstant::LameLambda(solid.lame_lambda()),
            ];
            for first in constants {
                for second in constants.into_iter().filter(|second| second.name() != first.name()) {
                    let same = IsotropicElasticity::new(8930.0, first, second).unwrap();
                    let close = |a: f64, b: f64| (a - b).abs() <= 1e-9 * b;
                    assert!(close(same.shear_modulus(), solid.shear_modulus()), "{first:?} {second:?}");
                    assert!(close(same.bulk_modulus(), solid.bulk_modulus()), "{first:?} {second:?}");
                }
            }
        }
    }

    #[test]
    fn impossible_constants_are_refused_by_name() {
        use ElasticConstant::{BulkModulus, PoissonRatio, ShearModulus, YoungModulus};
        let refused = |density, a, b| IsotropicElasticity::new(density, a, b).unwrap_err().parameter;
        assert_eq!(refused(-1.0, YoungModulus(1.0), PoissonRatio(0.3)), "density");
        assert_eq!(refused(f64::NAN, YoungModulus(1.0), PoissonRatio(0.3)), "density");
        assert_eq!(refused(1.0, YoungModulus(0.0), PoissonRatio(0.3)), "young_modulus");
        assert_eq!(refused(1.0, YoungModulus(1.0), PoissonRatio(0.5)), "poisson_ratio");
        assert_eq!(refused(1.0, YoungModulus(f64::INFINITY), PoissonRatio(0.3)), "young_modulus");
        assert_eq!(refused(1.0, BulkModulus(1.0), BulkModulus(2.0)), "bulk_modulus");
        // E < 3 μ is needed for a positive bulk modulus
        assert_eq!(refused(1.0, YoungModulus(4.0), ShearModulus(1.0)), "bulk_modulus");
    }
}
