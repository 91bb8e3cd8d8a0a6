//! Kinematic hardening of the E* theory in box-rate form: the centre α̃ of the yield surface moves with plastic flow.
//!
//! dα̃/dt = ⅔ C D̄_p − γ ε̄̇ᵖ α̃ (Armstrong & Frederick 1966; Prager for γ = 0), α̃ = RᵀαR, so that the box rate of α
//! follows (de Vera 2016, eq. 6.7).
//!
//! Energy: the back stress stores ψ_α = (3/4C) ‖α̃‖². Its rate is α̃ : D̄_p − (3γ/2C) ‖α̃‖² ε̄̇ᵖ, so that of the work α̃ : D̄_p the
//! dynamic recovery dissipates (3γ/2C) ‖α̃‖² ε̄̇ᵖ: nothing by Prager's law, all of it once α̃ has saturated.
//!
//! History: α̃, beside that of [`EStar`](crate::EStar).

use crate::e_star::{KinematicRule, Return, Trial, von_mises};
use crate::point_state;
use crate::return_mapping::{Equivalent, RadialReturn, plastic_increment};
use crate::{Hardening, KinematicHardening};
use estar_tensor::{Real, SymmetricTensor, inlined};

/// α̃ as a history keeps it.
#[derive(Clone, Copy, Debug)]
pub struct RotatedBackStress<R> {
    /// Rotated back stress α̃ = RᵀαR, Pa.
    pub rotated_back_stress: SymmetricTensor<R>,
}

point_state!(RotatedBackStress { rotated_back_stress: symmetric });

impl KinematicRule for KinematicHardening {
    type BackStress<R: Real> = RotatedBackStress<R>;

    #[inline(always)]
    fn back_stress<R: Real>(kept: &RotatedBackStress<R>) -> SymmetricTensor<R> {
        kept.rotated_back_stress
    }

    #[inline(always)]
    fn kept<R: Real>(back_stress: SymmetricTensor<R>) -> RotatedBackStress<R> {
        RotatedBackStress { rotated_back_stress: back_stress }
    }

    /// C − γ √(3/2) n : α̃.
    fn back_stress_slope(&self, back_stress: &SymmetricTensor<f64>, relative: &SymmetricTensor<f64>) -> f64 {
        let along = 1.5 * relative.double_dot(back_stress) / von_mises(relative).max(f64::MIN_POSITIVE);
        self.modulus() - self.recovery() * along
    }

    /// Return with p = Δε̄ᵖ and θ = 1/(1 + γ p), backward Euler:
    ///
    /// α̃_{n+1} = θ (α̃_n + ⅔ C Δγ n), η = dev T̃_trial − θ α̃_n, n = η/‖η‖, Δγ = √(3/2) p,
    /// √(3/2) ‖η‖ − (3μ + C θ) p = σ_y(ε̄ᵖ_n + p).
    #[inline(always)]
    fn return_mapping<R: Real, H: Hardening>(&self, trial: &Trial<R>, law: &RadialReturn<'_, H, R>) -> Return<R> {
        let one = R::splat(1.0);
        let three_mu = 3.0 * law.elasticity.shear_modulus();
        let modulus = R::splat(self.modulus());
        let recovery = R::splat(self.recovery());
        let theta = inlined!(|p: R| recovery.mul_add(p, one).recip());
        let relative = inlined!(|theta: R| trial.back_stress.mul_add(-theta, &trial.deviator));

        let equivalent = inlined!(|p: R| {
            let theta = theta(p);
            let eta = relative(theta);
            let eta_equivalent = von_mises(&eta);
            // dθ/dp = −γ θ²; d(√(3/2) ‖η‖)/dp = −(3/2) η : α̃_n / (√(3/2) ‖η‖) dθ/dp
            let theta_slope = -(recovery * theta * theta);
            let turning = eta.double_dot(&trial.back_stress) * theta_slope * 1.5 / eta_equivalent;
            let stiffness = modulus * theta + three_mu;
            Equivalent {
                stress: eta_equivalent - stiffness * p,
                slope: -(stiffness + modulus * theta_slope * p + turning),
            }
        });
        let flow = inlined!(|p: R| law.hardening.flow_stress(&law.start, p));
        // √(3/2) ‖η‖ falls or rises by at most C θ² a unit of p, since √(3/2) ‖α̃‖ ≤ C/γ always, and (C θ p)' = C θ²:
        // the left side falls at 3μ or faster. The bracket from ‖η‖ ≤ ‖dev T̃_trial‖ + ‖α̃_n‖.
        let upper_bound = (von_mises(&trial.deviator) + von_mises(&trial.back_stress)) * three_mu.recip();
        let p = plastic_increment(
            trial.yields,
            upper_bound,
            (equivalent(R::splat(0.0)), trial.flow_stress_old),
            equivalent,
            flow,
        );

        let theta = theta(p);
        let eta = relative(theta);
        // √(3/2) n = (3/2) η / (√(3/2) ‖η‖)
        let safe_equivalent = R::select(trial.yields, von_mises(&eta), one);
        let direction = eta * (R::splat(1.5) / safe_equivalent);
        let moved = direction.mul_add(modulus * p * (2.0 / 3.0), &trial.back_stress) * theta;
        // α̃_{n+1} − α̃_n = ⅔ C Δε_p − γ p α̃_{n+1}, so that of the work ½ (α̃_n + α̃_{n+1}) : Δε_p exactly
        // (3γ/4C) p (α̃_n + α̃_{n+1}) : α̃_{n+1} does not end in ψ_α
        let per_modulus = if self.is_active() { 0.75 * self.recovery() / self.modulus() } else { 0.0 };
        let recovered = (trial.back_stress + moved).double_dot(&moved) * (p * per_modulus);
        Return {
            stress_correction: (direction * (p * (2.0 / 3.0 * three_mu))).or_zero(trial.yields),
            plastic_increment: p,
            back_stress: SymmetricTensor::select(trial.yields, &moved, &trial.back_stress),
            recovered_energy: Some(R::select(trial.yields, recovered, R::splat(0.0))),
        }
    }
}
