//! Lanczos' method for the eigenvalues of M⁻¹K of the assembled mesh at both ends of the spectrum.
//!
//! K is the sum of the linear forces of the elements on their present geometry, see
//! [`Element::linear_forces`](estar_element::element::Element::linear_forces); it is never written down. Sums are formed in chunks of
//! nodes, so that the bits are the same for any number of threads.

use crate::assembly::{CHUNK, RowLists};
use crate::block::Block;
use crate::constraints::dot;
use crate::patch_rows::NodalMotion;
use rayon::prelude::*;

/// M and K of a body.
pub(crate) struct Operator<'a> {
    /// Lumped mass of each node, kg.
    pub mass: &'a [f64],
    pub motion: NodalMotion<'a>,
    pub blocks: &'a [Block],
    pub rows: &'a mut [[f64; 4]],
    pub row_lists: &'a RowLists,
}

impl Operator<'_> {
    /// Writes −K z to the rows of the patches.
    fn apply(&mut self, z: &[[f64; 3]]) {
        let motion = NodalMotion { velocity: z, ..self.motion };
        let mut rest = &mut *self.rows;
        for block in self.blocks {
            let (own, others) = rest.split_at_mut(block.elements.patches().row_count());
            rest = others;
            block.elements.apply_tangents(motion, own);
        }
    }
}

/// Lanczos' method in the inner product of the mass, in a subspace: what `kept` leaves of a vector at a node.
pub(crate) struct Lanczos {
    /// z_k = √b_k q_k with the normed vector q_k of the method.
    vector: Vec<[f64; 3]>,
    /// z_{k−1}; once α_k is known, what z_{k+1} is made of.
    other: Vec<[f64; 3]>,
    /// Of each chunk of nodes.
    sums: Vec<f64>,
    /// Steps that are made without allocation.
    planned: usize,
    /// α_k = q_kᵀ K q_k.
    diagonal: Vec<f64>,
    /// b_{k+1} = β_k² = z_{k+1}ᵀ M z_{k+1}.
    off_diagonal_squared: Vec<f64>,
    /// b_k.
    square: f64,
    /// b_{k−1}.
    square_before: f64,
}

impl Lanczos {
    /// The method for a body of so many nodes; the planned steps are made without allocation.
    pub fn new(node_count: usize, planned: usize) -> Self {
        Self {
            vector: vec![[0.0; 3]; node_count],
            other: vec![[0.0; 3]; node_count],
            sums: vec![0.0; node_count.div_ceil(CHUNK)],
            planned,
            diagonal: Vec::with_capacity(planned),
            off_diagonal_squared: Vec::with_capacity(planned),
            square: 0.0,
            square_before: f64::INFINITY,
        }
    }

    /// Steps that are made without allocation.
    pub fn planned(&self) -> usize {
        self.planned
    }

    /// Steps made so far, k.
    pub fn steps(&self) -> usize {
        self.diagonal.len()
    }

    /// Takes out of the vectors, between two steps, what rounding has brought back of directions that the start did not have.
    pub fn purify(&mut self, mass: &[f64], take_out: impl Fn(&mut [[f64; 3]])) {
        take_out(&mut self.vector);
        take_out(&mut self.other);
        self.square = mass.iter().zip(&self.vector).map(|(mass, z)| mass * dot(z, z)).sum();
    }

    /// b_k, the square of the length of z_k.
    pub fn square(&self) -> f64 {
        self.square
    }

    /// Starts from z₁ = M^{−½} g with g in any direction of the subspace alike.
    pub fn start(&mut self, seed: u64, mass: &[f64], kept: impl Fn(usize, [f64; 3]) -> [f64; 3] + Sync) {
        self.diagonal.clear();
        self.off_diagonal_squared.clear();
        self.square = self.sweep(|node, _, _| {
            let scale = mass[node].sqrt().recip();
            let normal = |axis: usize| scale * pseudo_normal(seed, (3 * node + axis) as u64);
            let z = kept(node, std::array::from_fn(normal));
            (z, mass[node] * dot(&z, &z))
        });
        std::mem::swap(&mut self.vector, &mut self.other);
        self.square_before = f64::INFINITY;
    }

    /// Goes on until `count` steps have been made; whether the subspace had enough directions.
    pub fn extend_to(
        &mut self,
        count: usize,
        operator: &mut Operator<'_>,
        kept: impl Fn(usize, [f64; 3]) -> [f64; 3] + Sync,
    ) -> bool {
        let mass = operator.mass;
        while self.steps() < count {
            // z_{k+1} = w − α_k q_k
            if let Some(&alpha) = self.diagonal.last() {
                let share = alpha * self.square.sqrt().recip();
                let next = self.sweep(|node, z, w| {
                    let z: [f64; 3] = std::array::from_fn(|i| w[i] - share * z[i]);
                    (z, mass[node] * dot(&z, &z))
                });
                // an invariant subspace, which of a random start is all of it, has been found
                if next <= (f64::EPSILON * alpha).powi(2) {
                    return false;
                }
                self.off_diagonal_squared.push(next);
                std::mem::swap(&mut self.vector, &mut self.other);
                (self.square_before, self.square) = (self.square, next);
            }
            operator.apply(&self.vector);
            let (rows, row_lists) = (&*operator.rows, operator.row_lists);
            // w = M⁻¹ K q_k − β_{k−1} q_{k−1}, α_k = q_kᵀ K q_k
            let (per_norm, share_before) = (self.square.sqrt().recip(), (self.square / self.square_before).sqrt());
            let along = self.sweep(|node, z, before| {
                let force = row_lists.sum(rows, node).map(|component| -component);
                let scale = per_norm / mass[node];
                let w = std::array::from_fn(|i| scale * force[i] - share_before * before[i]);
                (kept(node, w), dot(&z, &force))
            });
            self.diagonal.push(along / self.square);
        }
        true
    }

    /// The largest Ritz value.
    pub fn largest_ritz_value(&self) -> f64 {
        largest_eigenvalue(&self.diagonal, &self.off_diagonal_squared, 1.0)
    }

    /// The smallest Ritz value.
    pub fn smallest_ritz_value(&self) -> f64 {
        -largest_eigenvalue(&self.diagonal, &self.off_diagonal_squared, -1.0)
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

/// The largest eigenvalue of a symmetric tridiagonal matrix whose diagonal has this sign, by bisection with Sturm's sequence.
fn largest_eigenvalue(diagonal: &[f64], off_diagonal_squared: &[f64], sign: f64) -> f64 {
    // all pivots of T − x I are negative if and only if x is above every eigenvalue
    let is_above = |x: f64| {
        let mut pivot = f64::NEG_INFINITY;
        diagonal.iter().enumerate().all(|(i, alpha)| {
            let coupling = if i == 0 { 0.0 } else { off_diagonal_squared[i - 1] };
            pivot = sign * alpha - x - coupling / pivot;
            pivot < 0.0
        })
    };
    let mut low = diagonal.iter().map(|alpha| sign * alpha).fold(f64::NEG_INFINITY, f64::max);
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
    fn eigenvalues_of_a_chain_of_springs_are_their_closed_forms() {
        // 2, −1: λ = 2 ± 2 cos(π/(n + 1)) at the ends
        for n in [1_usize, 2, 7, 40] {
            let exact = 2.0 + 2.0 * (std::f64::consts::PI / (n as f64 + 1.0)).cos();
            let found = largest_eigenvalue(&vec![2.0; n], &vec![1.0; n - 1], 1.0);
            assert!((found - exact).abs() < 1e-14, "{n}: {found} {exact}");
            let smallest = -largest_eigenvalue(&vec![2.0; n], &vec![1.0; n - 1], -1.0);
            assert!((smallest - (4.0 - exact)).abs() < 1e-14, "{n}: {smallest}");
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
