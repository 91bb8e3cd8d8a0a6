//! How the frequencies of elements grow, for the time step of the assembled mesh.

use estar_tensor::Real;

/// Squares of the highest frequencies that elements may have, ω_e² = 4/Δt_e², 1/s².
#[derive(Clone, Copy)]
pub(super) struct Frequencies<R> {
    /// As of the last step.
    pub now: R,
    /// When the assembled mesh was last looked at.
    pub then: R,
}

impl<R: Real> Frequencies<R> {
    /// Enters the stable time step of now, and tells the growth of the frequencies as it counts for the assembled mesh.
    #[inline(always)]
    pub fn growth(&mut self, stable_time_step: R, eigenvalue: f64) -> R {
        let half = stable_time_step * 0.5;
        self.now = (half * half).recip();
        // Δω² min(1, Λ/ω²)
        (self.now - self.then) * (R::splat(eigenvalue) / self.then).min(R::splat(1.0))
    }
}
