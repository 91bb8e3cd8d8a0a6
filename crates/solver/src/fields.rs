//! Fields over nodes and elements: what frames and probes see of a state. Each is written to a slice that the caller keeps,
//! by all threads of the pool.

pub use crate::block::ElementMeans;
use crate::patch::PATCH;
use crate::simulation::Simulation;
use estar_element::{hex8, tet4, tet10};
use estar_mesh::{Elements, Shape};
use estar_tensor::{SymmetricTensor, Vector3};
use rayon::prelude::*;

impl Simulation {
    /// Writes the velocity of every node at t_n, m/s.
    pub fn write_velocity(&self, field: &mut [[f64; 3]]) {
        let velocity = |(node, velocity): (usize, &mut [f64; 3])| *velocity = self.velocity(node);
        field.par_iter_mut().with_min_len(PATCH).enumerate().for_each(velocity);
    }

    /// Writes the volume ratio of every element as its material sees it: of four-node tets that of their neighbourhood, of others
    /// [`volume_ratio`].
    pub fn write_volume_ratio(&self, field: &mut [f64]) {
        let own = |(element, ratio): (usize, &mut f64)| {
            *ratio = volume_ratio(self.mesh.elements(), element, self.mesh.coordinates(), &self.nodes.displacement);
        };
        field.par_iter_mut().with_min_len(PATCH).enumerate().for_each(own);
        self.write_means(ElementMeans { volume_ratio: Some(field), ..ElementMeans::default() });
    }

    /// Whether it has elements that share their volume change with their neighbours.
    pub fn shares_volume(&self) -> bool {
        !self.averages.is_empty()
    }

    /// Writes means over the quadrature points of every element, of the fields that are wanted. One sweep over the histories
    /// gives all; their size is what it costs.
    pub fn write_means(&self, means: ElementMeans<'_>) {
        let ElementMeans { mut cauchy_stress, mut equivalent_plastic_strain, mut temperature, mut volume_ratio } =
            means;
        for block in &self.blocks {
            let members = block.elements.members();
            let stresses = pieces(members, cauchy_stress.as_deref_mut());
            let strains = pieces(members, equivalent_plastic_strain.as_deref_mut());
            let temperatures = pieces(members, temperature.as_deref_mut());
            let ratios = pieces(members, volume_ratio.as_deref_mut());
            let chunks = stresses.into_par_iter().zip(strains).zip(temperatures).zip(ratios).enumerate();
            chunks.for_each(|(chunk, (((cauchy_stress, equivalent_plastic_strain), temperature), volume_ratio))| {
                let means = ElementMeans { cauchy_stress, equivalent_plastic_strain, temperature, volume_ratio };
                block.elements.write_means(chunk, means);
            });
        }
    }
}

/// The piece of a field over all elements that holds each chunk of a block, whose members ascend; none of no field.
fn pieces<'a, T>(members: &[u32], field: Option<&'a mut [T]>) -> Vec<Option<&'a mut [T]>> {
    let (mut rest, mut begin) = (field, 0);
    let piece = |chunk: &[u32]| {
        let (first, end) = (chunk[0] as usize, chunk[chunk.len() - 1] as usize + 1);
        let (piece, behind) = rest.take()?[first - begin..].split_at_mut(end - first);
        (rest, begin) = (Some(behind), end);
        Some(piece)
    };
    members.chunks(PATCH).map(piece).collect()
}

/// Von Mises stress √(3/2) ‖dev T‖ of a stress with the components xx, yy, zz, xy, yz, xz.
pub fn von_mises_stress(stress: &[f64; 6]) -> f64 {
    (1.5 * SymmetricTensor(*stress).deviator().norm_squared()).sqrt()
}

/// Pressure −⅓ tr T of a stress with the components xx, yy, zz, xy, yz, xz.
pub fn pressure(stress: &[f64; 6]) -> f64 {
    SymmetricTensor(*stress).trace() / -3.0
}

/// Volume of an element over what it was: det F at the centre of a hex, a wedge or a pyramid, which F-bar gives every point, the
/// mean of the whole of a tet. It is what the material sees, but for four-node tets: see [`Simulation::write_volume_ratio`].
pub fn volume_ratio(elements: &Elements, element: usize, reference: &[[f64; 3]], displacement: &[[f64; 3]]) -> f64 {
    let nodes = elements.nodes(element);
    let moved = |place: usize| {
        let (x, u) = (&reference[nodes[place] as usize], &displacement[nodes[place] as usize]);
        Vector3(std::array::from_fn(|i| x[i] + u[i]))
    };
    let still = |place: usize| Vector3(reference[nodes[place] as usize]);
    match elements.shape(element) {
        Shape::Tet4 => tet4::volume(&std::array::from_fn(moved)) / tet4::volume(&std::array::from_fn(still)),
        Shape::Tet10 => tet10::volume(&std::array::from_fn(moved)) / tet10::volume(&std::array::from_fn(still)),
        shape @ (Shape::Hex8 | Shape::Wedge6 | Shape::Pyramid5) => {
            let places = shape.corners_of_hex().unwrap_or(&[0; 8]);
            hex8::central_jacobian(&places.map(moved)) / hex8::central_jacobian(&places.map(still))
        }
    }
}
