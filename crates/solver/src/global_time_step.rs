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

use crate::assembly::RowLists;
use crate::central_difference::CHUNK;
use crate::constraints::dot;
use crate::simulation::Simulation;
use crate::solid_block::NodalMotion;
use estar_element::element::ElementStep;
use rayon::prelude::*;

/// ε, by which Lanczos' method may underestimate Λ.
const UNDERESTIMATE: f64 = 0.04;
/// The chance that it underestimates it by more, for the worst of all spectra. On meshes of 9,000 nodes, regular, distorted and
/// slender, k steps miss 10⁻⁴ of the step and half as many 10⁻².
const CHANCE: f64 = 1e-2;
/// Growth or decline of Λ between estimates, as a share of it, after which the next comes early.
const TOLERATED_CHANGE: f64 = 0.1;
/// Estimates that come early are at least the interval over this apart: with 2 in place of 8 steps of a block that is squeezed within
/// three intervals come to 1.10 of the exact one, with 8 to 1.01.
const EARLIEST: u64 = 8;
/// Accuracy to which the weight of damping is made to fit the first step, and the times that this is tried.
const FIT: f64 = 1e-3;
const MOST_FITS: usize = 50;

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
    lanczos: Lanczos,
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

    fn is_due(&self, step: u64) -> bool {
        let age = step - self.step;
        let has_changed = self.growth.max(self.decline) > TOLERATED_CHANGE * self.eigenvalue;
        age >= self.interval || (has_changed && age * EARLIEST >= self.interval)
    }
}

/// k with √n exp(−(2k − 1) √ε) 1.648 = [`CHANCE`].
fn estimating_steps(dimension: usize) -> usize {
    let exponent = (1.648 * (dimension as f64).sqrt() / CHANCE).ln();
    (0.5 * (exponent / UNDERESTIMATE.sqrt() + 1.0)).ceil() as usize
}

impl Simulation {
    /// The stable time step at t_n that steps are taken from, s: that of the elements or, if larger, of the assembled mesh.
    pub(crate) fn stable_time_step(&self) -> f64 {
        let of_elements = self.elements.stable_time_step.value;
        self.global_time_step.as_ref().map_or(of_elements, |global| of_elements.max(global.stable_time_step()))
    }

    /// Estimates of the stable time step of the assembled mesh so far.
    pub fn estimate_count(&self) -> u64 {
        self.global_time_step.as_ref().map_or(0, |global| global.count)
    }

    /// The first estimate, which leaves no forces in the rows of the patches.
    pub(crate) fn begin_global_time_step(&mut self) {
        let Some(mut global) = self.global_time_step.take() else { return };
        let time_step = self.first_estimate(&mut global.lanczos);
        global.eigenvalue = 4.0 / (time_step * time_step);
        global.count = 1;
        self.global_time_step = Some(global);
        self.watch_elements();
    }

    /// A new estimate on the state of t_n, if it is time.
    pub(crate) fn renew_global_time_step(&mut self) {
        if !self.global_time_step.as_ref().is_some_and(|global| global.is_due(self.step)) {
            return;
        }
        let time_step = self.stable_time_step();
        let Some(mut global) = self.global_time_step.take() else { return };
        let estimate = self.estimated_time_step(&mut global.lanczos, time_step);
        global.eigenvalue = 4.0 / (estimate * estimate);
        (global.step, global.growth, global.decline) = (self.step, 0.0, 0.0);
        global.count += 1;
        self.global_time_step = Some(global);
        self.watch_elements();
    }

    /// The stable time step of the assembled mesh at t_n as `time_step = "power"` has it, s; none where that is not known for some of
    /// the elements.
    pub fn global_time_step(&mut self) -> Option<f64> {
        if !self.blocks.iter().all(|block| block.elements.has_linear_forces()) {
            return None;
        }
        let node_count = self.nodes.mass.len();
        let mut lanczos = Lanczos::new(node_count, estimating_steps(3 * node_count));
        Some(self.first_estimate(&mut lanczos))
    }

    /// The estimate where no earlier one tells with which step damping counts: the same over and over, from the bound of the elements
    /// on.
    fn first_estimate(&mut self, lanczos: &mut Lanczos) -> f64 {
        let mut time_step = self.elements.stable_time_step.value;
        for _ in 0..MOST_FITS {
            let estimate = self.estimated_time_step(lanczos, time_step);
            let has_grown = self.is_damped() && estimate > time_step * (1.0 + FIT);
            time_step = time_step.max(estimate);
            if !has_grown {
                break;
            }
        }
        time_step
    }

    /// The same without the allowance for what k steps of Lanczos' method miss, s: exact for a `k` that is large enough.
    pub fn exact_global_time_step(&mut self, k: usize) -> f64 {
        let mut lanczos = Lanczos::new(self.nodes.mass.len(), k);
        let mut time_step = self.elements.stable_time_step.value;
        for _ in 0..MOST_FITS {
            let fitted = 2.0 / self.largest_ritz_value(&mut lanczos, time_step).sqrt();
            let change = fitted / time_step - 1.0;
            time_step = fitted;
            if change.abs() < 1e-10 {
                break;
            }
        }
        time_step
    }

    /// The stable time step at t_n from an upper estimate of Λ with the damping of the step `time_step`.
    fn estimated_time_step(&mut self, lanczos: &mut Lanczos, time_step: f64) -> f64 {
        let step = 2.0 / (self.largest_ritz_value(lanczos, time_step) / (1.0 - UNDERESTIMATE)).sqrt();
        // less by rounding alone is no less
        if step >= time_step || !self.is_damped() { step } else { step * step / time_step }
    }

    fn is_damped(&self) -> bool {
        self.settings.bulk_viscosity.is_some() || self.blocks.iter().any(|block| block.elements.is_damped())
    }

    fn watch_elements(&mut self) {
        for block in &mut self.blocks {
            block.elements.watch();
        }
    }

    /// θ, 1/s², with the damping of the step `time_step`. The rows of the patches serve as rows of the operator.
    fn largest_ritz_value(&mut self, lanczos: &mut Lanczos, time_step: f64) -> f64 {
        let nodes = &self.nodes;
        let reference = self.mesh.coordinates();
        let step = ElementStep { bulk_viscosity: self.settings.bulk_viscosity, time_step };
        let motion = NodalMotion { reference, displacement: &nodes.displacement, velocity: &nodes.velocity };
        for block in &mut self.blocks {
            block.elements.find_tangents(motion, &step);
        }
        let (blocks, rows, row_lists) = (&self.blocks, &mut self.patch_forces, &self.row_lists);
        lanczos.largest_ritz_value(self.step, &nodes.mass, row_lists, rows, |vector, rows| {
            let motion = NodalMotion { velocity: vector, ..motion };
            let mut rest = rows;
            for block in blocks {
                let (own, others) = rest.split_at_mut(block.elements.patches().row_count());
                rest = others;
                block.elements.apply_tangents(motion, own);
            }
        })
    }
}

/// Lanczos' method in the inner product of the mass.
struct Lanczos {
    /// z_k = √b_k q_k with the normed vector q_k of the method.
    vector: Vec<[f64; 3]>,
    /// z_{k−1}, then z_{k+1}.
    other: Vec<[f64; 3]>,
    /// Of each chunk of nodes.
    sums: Vec<f64>,
    /// α_k = q_kᵀ K q_k.
    diagonal: Vec<f64>,
    /// b_{k+1} = β_k² = z_{k+1}ᵀ M z_{k+1}.
    off_diagonal_squared: Vec<f64>,
    steps: usize,
}

impl Lanczos {
    fn new(node_count: usize, steps: usize) -> Self {
        Self {
            vector: vec![[0.0; 3]; node_count],
            other: vec![[0.0; 3]; node_count],
            sums: vec![0.0; node_count.div_ceil(CHUNK)],
            diagonal: Vec::with_capacity(steps),
            off_diagonal_squared: Vec::with_capacity(steps),
            steps,
        }
    }

    /// The largest Ritz value of M⁻¹K, where `apply` writes −K z to the rows of the patches.
    fn largest_ritz_value(
        &mut self,
        seed: u64,
        mass: &[f64],
        row_lists: &RowLists,
        rows: &mut [[f64; 4]],
        apply: impl Fn(&[[f64; 3]], &mut [[f64; 4]]),
    ) -> f64 {
        self.diagonal.clear();
        self.off_diagonal_squared.clear();
        // z₁ = M^{−½} g with g in any direction alike
        let start = |node: usize, _: [f64; 3], _: [f64; 3]| {
            let scale = mass[node].sqrt().recip();
            let normal = |axis: usize| scale * pseudo_normal(seed, (3 * node + axis) as u64);
            let z = std::array::from_fn(normal);
            (z, mass[node] * dot(&z, &z))
        };
        let mut square = self.sweep(start);
        std::mem::swap(&mut self.vector, &mut self.other);
        let mut square_before = f64::INFINITY;
        for step in 0..self.steps {
            apply(&self.vector, rows);
            let rows = &*rows;
            // w = M⁻¹ K q_k − β_{k−1} q_{k−1}, α = q_kᵀ K q_k
            let (per_norm, share_before) = (square.sqrt().recip(), (square / square_before).sqrt());
            let along = self.sweep(|node, z, before| {
                let force = row_lists.sum(rows, node).map(|component| -component);
                let scale = per_norm / mass[node];
                (std::array::from_fn(|i| scale * force[i] - share_before * before[i]), dot(&z, &force))
            });
            let alpha = along / square;
            self.diagonal.push(alpha);
            if step + 1 == self.steps {
                break;
            }
            // z_{k+1} = w − α q_k
            let share = alpha * per_norm;
            let next = self.sweep(|node, z, w| {
                let z: [f64; 3] = std::array::from_fn(|i| w[i] - share * z[i]);
                (z, mass[node] * dot(&z, &z))
            });
            // an invariant subspace, which of a random start is all of it, has been found
            if next <= (f64::EPSILON * alpha).powi(2) {
                break;
            }
            self.off_diagonal_squared.push(next);
            std::mem::swap(&mut self.vector, &mut self.other);
            (square_before, square) = (square, next);
        }
        largest_eigenvalue(&self.diagonal, &self.off_diagonal_squared)
    }

    /// Gives `other` at every node a new value from those of both vectors there, and sums what `value` gives besides.
    fn sweep(&mut self, value: impl Fn(usize, [f64; 3], [f64; 3]) -> ([f64; 3], f64) + Sync) -> f64 {
        let chunks = self.other.par_chunks_mut(CHUNK).zip(self.vector.par_chunks(CHUNK)).zip(&mut self.sums);
        chunks.enumerate().for_each(|(chunk, ((other, vector), sum))| {
            *sum = 0.0;
            for (local, (other, vector)) in other.iter_mut().zip(vector).enumerate() {
                let (new, term) = value(chunk * CHUNK + local, *vector, *other);
                *other = new;
                *sum += term;
            }
        });
        self.sums.iter().sum()
    }
}

/// A number close to normally distributed, of variance 1/3 of (2¹⁶)²: the sum of the four quarters of a hash (Steele, Lea & Flood
/// 2014), exact on every machine.
fn pseudo_normal(seed: u64, index: u64) -> f64 {
    let golden = 0x9e37_79b9_7f4a_7c15_u64;
    let mix = |z: u64| {
        let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    let bits = mix(mix(seed.wrapping_add(golden)).wrapping_add(index.wrapping_mul(golden)));
    (0..4).map(|quarter| (bits >> (16 * quarter) & 0xffff) as f64 - 32767.5).sum()
}

/// The largest eigenvalue of a symmetric tridiagonal matrix, by bisection with Sturm's sequence.
fn largest_eigenvalue(diagonal: &[f64], off_diagonal_squared: &[f64]) -> f64 {
    // all pivots of T − x I are negative if and only if x is above every eigenvalue
    let is_above = |x: f64| {
        let mut pivot = f64::NEG_INFINITY;
        diagonal.iter().enumerate().all(|(i, alpha)| {
            let coupling = if i == 0 { 0.0 } else { off_diagonal_squared[i - 1] };
            pivot = alpha - x - coupling / pivot;
            pivot < 0.0
        })
    };
    let mut low = diagonal.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut high = low + 2.0 * off_diagonal_squared.iter().copied().fold(0.0, f64::max).sqrt();
    loop {
        let middle = 0.5 * (low + high);
        // no number lies between, or there are none at all
        let splits = low < middle && middle < high;
        if !splits {
            return high;
        }
        if is_above(middle) { high = middle } else { low = middle }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn largest_eigenvalue_of_a_chain_of_springs_is_its_closed_form() {
        // 2, −1: λ_max = 2 + 2 cos(π/(n + 1))
        for n in [1_usize, 2, 7, 40] {
            let exact = 2.0 + 2.0 * (std::f64::consts::PI / (n as f64 + 1.0)).cos();
            let found = largest_eigenvalue(&vec![2.0; n], &vec![1.0; n - 1]);
            assert!((found - exact).abs() < 1e-14, "{n}: {found} {exact}");
        }
    }

    #[test]
    fn starts_have_the_moments_of_a_normal_distribution() {
        let numbers: Vec<f64> = (0..100_000).map(|i| pseudo_normal(3, i) / (65536.0 / 3.0_f64.sqrt())).collect();
        let moment = |power| numbers.iter().map(|x| x.powi(power)).sum::<f64>() / numbers.len() as f64;
        // four uniform numbers have the kurtosis 3 − 0.3
        let found = [moment(1), moment(2), moment(3), moment(4)];
        // four times what 10⁵ samples scatter, √((E x²ᵖ − (E xᵖ)²)/10⁵)
        let exact = [(0.0, 0.013), (1.0, 0.017), (0.0, 0.05), (2.7, 0.1)];
        for (found, (exact, scatter)) in found.into_iter().zip(exact) {
            assert!((found - exact).abs() < scatter, "{found} {exact}");
        }
    }
}
