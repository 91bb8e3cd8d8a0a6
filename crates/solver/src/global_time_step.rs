//! The stable time step from the highest frequency of the assembled mesh, `time_step = "power"`.
//!
//! Central differences are stable for Δt² K + 2 Δt C ≤ 4 M, with the viscous forces C v taken at the half step before: the
//! energy (M − ½ Δt C − ¼ Δt² K) of the half steps stays positive then. With Λ the largest eigenvalue of
//! M⁻¹(K + (2/Δt*) C) that holds for Δt = 2/√Λ if Δt ≥ Δt*, since C has no more weight then than in Λ, and for
//! Δt = (2/√Λ)²/Δt* else. Without damping Δt* does not matter.
//!
//! **Operator.** K is the sum of the elastic stiffnesses of the elements on the current geometry, each in its own formulation
//! ([`Element::linear_forces`](estar_element::element::Element::linear_forces)), with the constants that the bound of the element
//! has: no yielding, which only softens, no stiffness of stress, and no constraints, which only lower Λ. Of F-bar, and of the bulk
//! viscosity of distorted elements, it is the symmetric part S. The real parts of all eigenvalues are at most λ_max(S), the
//! imaginary ones at most the largest of the skew part, so that |λ| ≤ λ_max(S) √(1 + s²) with s their ratio; imaginary parts of
//! some 10⁻³ (`crates/element/tests/stable_time_step.rs`) change that by 10⁻⁶.
//!
//! **Estimate.** k steps of Lanczos' method in the inner product of M from a random start give a largest Ritz value θ ≤ Λ.
//! No residual can tell that θ belongs to the largest eigenvalue and not to another; the random start can: whatever the
//! eigenvalues, θ < (1 − ε) Λ for at most the share √n exp(−(2k − 1) √ε), times a constant near 1.65, of all directions to start
//! in n dimensions (Kuczyński & Woźniakowski 1992, SIAM J. Matrix Anal. Appl. 13). k is chosen so that this is
//! [`CHANCE`], and θ/(1 − ε) is taken for Λ. The
//! step is then at most √(1 − ε) = 0.98 of the exact one where θ has converged. Starts are pseudo-random with the number of the
//! step for a seed: the same for any number of threads and after a restart, and another one each time.
//!
//! **Between estimates** each element tells by how much the square of its own frequency, ω_e² = 4/Δt_e², has grown since. If its
//! stiffness has grown by no more than the ratio of the two, then Λ has grown by at most the largest growth of ω_e² where
//! ω_e² ≤ Λ, and by that ratio where ω_e² > Λ, of elements that lean on the mass of others: max_e (Δω_e² min(1, Λ/ω_e²)).
//! The bound of an element is not its frequency: a distorted element that becomes more regular may stiffen while its bound does
//! not. So once that growth, or a decline of the same kind, is [`TOLERATED_CHANGE`] of Λ the next estimate comes early. The step is never
//! below that of the bound of the elements.

use crate::lanczos::Lanczos;

/// ε, by which Lanczos' method may underestimate Λ.
pub(crate) const UNDERESTIMATE: f64 = 0.04;
/// The chance that it underestimates it by more, for the worst of all spectra. On meshes of 9,000 nodes, regular, distorted and
/// slender, k steps miss 10⁻⁴ of the step and half as many 10⁻².
const CHANCE: f64 = 1e-2;
/// Growth or decline of Λ between estimates, as a share of it, after which the next comes early.
const TOLERATED_CHANGE: f64 = 0.1;
/// Estimates that come early are at least the interval over this apart: with 2 in place of 8 steps of a block that is squeezed within
/// three intervals come to 1.10 of the exact one, with 8 to 1.01.
const EARLIEST: u64 = 8;
/// The largest eigenvalue of the assembled mesh as of some step, and what it takes to find it.
pub(crate) struct GlobalTimeStep {
    /// Steps from one estimate to the next.
    pub interval: u64,
    /// Λ, 1/s².
    pub eigenvalue: f64,
    /// When it was estimated.
    pub step: u64,
    /// By how much it may have grown since, 1/s².
    pub growth: f64,
    /// By how much it may have fallen.
    pub decline: f64,
    /// Estimates so far.
    pub count: u64,
    pub lanczos: Lanczos,
}

impl GlobalTimeStep {
    pub fn new(interval: u64, node_count: usize) -> Self {
        let lanczos = Lanczos::new(node_count, estimating_steps(3 * node_count));
        Self { interval, eigenvalue: f64::INFINITY, step: 0, growth: 0.0, decline: 0.0, count: 0, lanczos }
    }

    /// 2/√Λ, s.
    pub fn stable_time_step(&self) -> f64 {
        2.0 / (self.eigenvalue + self.growth).sqrt()
    }

    /// Whether it is time for the next at this step.
    pub fn is_due(&self, step: u64) -> bool {
        let age = step - self.step;
        let has_changed = self.growth.max(self.decline) > TOLERATED_CHANGE * self.eigenvalue;
        age >= self.interval || (has_changed && age * EARLIEST >= self.interval)
    }
}

/// k with √n exp(−(2k − 1) √ε) 1.648 = [`CHANCE`].
pub(crate) fn estimating_steps(dimension: usize) -> usize {
    let exponent = (1.648 * (dimension as f64).sqrt() / CHANCE).ln();
    (0.5 * (exponent / UNDERESTIMATE.sqrt() + 1.0)).ceil() as usize
}
