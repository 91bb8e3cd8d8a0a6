//! Fields over nodes and hexes: what frames and probes see of a state. Each is written to a slice that the caller keeps,
//! by all threads of the pool.

use crate::patch::PATCH;
use crate::simulation::Simulation;
use estar_element::hex8;
use estar_tensor::{SymmetricTensor, Vector3};
use rayon::prelude::*;

impl Simulation {
    /// Writes the velocity of every node at t_n, m/s.
    pub fn write_velocity(&self, field: &mut [[f64; 3]]) {
        let velocity = |(node, velocity): (usize, &mut [f64; 3])| *velocity = self.velocity(node);
        field.par_iter_mut().with_min_len(PATCH).enumerate().for_each(velocity);
    }

    /// Writes means over the quadrature points of every hex, of the fields that are wanted. One sweep over the histories
    /// gives all; their size is what it costs.
    pub fn write_means(&self, means: HexMeans<'_>) {
        let HexMeans { mut cauchy_stress, mut equivalent_plastic_strain, mut temperature } = means;
        for block in &self.blocks {
            let hexes = block.elements.hexes();
            let stresses = pieces(hexes, cauchy_stress.as_deref_mut());
            let strains = pieces(hexes, equivalent_plastic_strain.as_deref_mut());
            let temperatures = pieces(hexes, temperature.as_deref_mut());
            let chunks = stresses.into_par_iter().zip(strains).zip(temperatures).enumerate();
            chunks.for_each(|(chunk, ((cauchy_stress, equivalent_plastic_strain), temperature))| {
                let means = HexMeans { cauchy_stress, equivalent_plastic_strain, temperature };
                block.elements.write_means(chunk, means);
            });
        }
    }
}

/// Fields over all hexes that are to be filled with means over the quadrature points; none is a field not wanted.
#[derive(Debug, Default)]
pub struct HexMeans<'a> {
    /// Cauchy stress with the components xx, yy, zz, xy, yz, xz, Pa.
    pub cauchy_stress: Option<&'a mut [[f64; 6]]>,
    /// Equivalent plastic strain ε̄ᵖ.
    pub equivalent_plastic_strain: Option<&'a mut [f64]>,
    /// Temperature, K; not a number in a hex whose material has none.
    pub temperature: Option<&'a mut [f64]>,
}

/// The piece of a field over all hexes that holds each chunk of a block, whose hexes ascend; none of no field.
fn pieces<'a, T>(hexes: &[u32], field: Option<&'a mut [T]>) -> Vec<Option<&'a mut [T]>> {
    let (mut rest, mut begin) = (field, 0);
    let piece = |chunk: &[u32]| {
        let (first, end) = (chunk[0] as usize, chunk[chunk.len() - 1] as usize + 1);
        let (piece, behind) = rest.take()?[first - begin..].split_at_mut(end - first);
        (rest, begin) = (Some(behind), end);
        Some(piece)
    };
    hexes.chunks(PATCH).map(piece).collect()
}

/// Von Mises stress √(3/2) ‖dev T‖ of a stress with the components xx, yy, zz, xy, yz, xz.
pub fn von_mises_stress(stress: &[f64; 6]) -> f64 {
    (1.5 * SymmetricTensor(*stress).deviator().norm_squared()).sqrt()
}

/// Pressure −⅓ tr T of a stress with the components xx, yy, zz, xy, yz, xz.
pub fn pressure(stress: &[f64; 6]) -> f64 {
    SymmetricTensor(*stress).trace() / -3.0
}

/// det F at the centre of a hex, the volume ratio that F-bar gives every point.
pub fn volume_ratio(corners: &[u32; 8], reference: &[[f64; 3]], displacement: &[[f64; 3]]) -> f64 {
    let moved = |node: u32| {
        let (x, u) = (&reference[node as usize], &displacement[node as usize]);
        Vector3(std::array::from_fn(|i| x[i] + u[i]))
    };
    let still = |node: u32| Vector3(reference[node as usize]);
    hex8::central_jacobian(&corners.map(moved)) / hex8::central_jacobian(&corners.map(still))
}
