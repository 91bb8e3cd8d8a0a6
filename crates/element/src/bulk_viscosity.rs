//! Bulk viscosity: a pressure against the rate of volume change that spreads shocks over a few elements.

use estar_tensor::Real;

/// Bulk viscosity with a linear part, which damps ringing, and a quadratic one, which carries shocks
/// (Landshoff 1955; von Neumann & Richtmyer 1950):
///
/// q = −b₁ ρ c l ε̇_v + (b₂ l ε̇_v)² ρ, the second part in compression only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BulkViscosity {
    /// b₁.
    pub linear: f64,
    /// b₂.
    pub quadratic: f64,
}

/// What the viscosity of one element depends on.
#[derive(Clone, Copy, Debug)]
pub struct ViscousState<R> {
    /// Rate of volume change ε̇_v = tr D, 1/s.
    pub volumetric_rate: R,
    /// Density ρ, kg/m³.
    pub density: R,
    /// Speed of pressure waves c, m/s.
    pub wave_speed: R,
    /// Characteristic length l, m: the way of a pressure wave in the element's stable time step.
    pub length: R,
}

/// What the viscosity of one element does.
#[derive(Clone, Copy, Debug)]
pub struct ViscousResponse<R> {
    /// Pressure q, Pa.
    pub pressure: R,
    /// Fraction of critical damping ξ = b₁ + 2 b₂² (l/c) max(0, −ε̇_v) in the element's highest mode.
    pub damping_ratio: R,
}

impl BulkViscosity {
    /// Pressure and damping in the given state.
    #[inline(always)]
    pub fn response<R: Real>(&self, state: &ViscousState<R>) -> ViscousResponse<R> {
        let rate_of_compression = (-state.volumetric_rate).max(R::splat(0.0));
        let shock_speed = state.length * rate_of_compression * (self.quadratic * self.quadratic);
        // q = ρ l (b₁ c (−ε̇_v) + b₂² l max(0, −ε̇_v)²)
        let linear = state.wave_speed * self.linear * -state.volumetric_rate;
        ViscousResponse {
            pressure: state.density * state.length * (linear + shock_speed * rate_of_compression),
            // the viscous modulus is ρ l (b₁ c + 2 b₂² l |ε̇_v|) and the highest mode has ω = 2 c/l, so that
            // ξ = ½ ω (viscous modulus)/(ρ c²)
            damping_ratio: (shock_speed + shock_speed) / state.wave_speed + self.linear,
        }
    }

    /// ∂q/∂(−ε̇_v) = ρ l (b₁ c + 2 b₂² l max(0, −ε̇_v)) = ρ c l ξ, Pa s.
    #[inline(always)]
    pub fn modulus<R: Real>(&self, state: &ViscousState<R>) -> R {
        state.density * state.wave_speed * state.length * self.response(state).damping_ratio
    }
}

/// Factor on the undamped stable time step at the damping ratio ξ: √(1 + ξ²) − ξ (Belytschko, Liu & Moran 2000,
/// section 6.6.7).
#[inline(always)]
pub fn damped_step_factor<R: Real>(damping_ratio: R) -> R {
    damping_ratio.mul_add(damping_ratio, R::splat(1.0)).sqrt() - damping_ratio
}
