//! Bodies that pass through each other, or through themselves, in a run: without contact nothing stops them, and nobody should
//! take that for a result.

use crate::problem::Problem;
use estar_mesh::{Face, PointTree, Shape};
use estar_solver::Simulation;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::ops::ControlFlow;

/// A point is in a body when it is behind the surface there by this share of the element's thickness.
const DEEP: f64 = 0.1;
/// Between elements a point belongs to both: it may be outside of one by this share.
const SLACK: f64 = 0.01;

/// Looks whether faces of the surface are inside of elements that they do not belong to, until there are some.
#[derive(Debug)]
pub struct Passing {
    /// Of each element, a bit for each of its faces that is an outer one.
    outer: Vec<u8>,
    is_told: bool,
}

impl Passing {
    /// Nothing has been seen yet.
    pub fn new(problem: &Problem) -> Self {
        let mut outer = vec![0; problem.mesh.element_count()];
        for face in &problem.connectivity.outer_faces {
            let element = face.element as usize;
            if let Some(place) = problem.mesh.elements().faces(element).position(|other| other == face.face) {
                outer[element] |= 1 << place;
            }
        }
        Self { outer, is_told: false }
    }

    /// Looks at the present step; a warning the first time that something passes through something.
    pub fn look(&mut self, problem: &Problem, simulation: &Simulation) -> Option<String> {
        if self.is_told {
            return None;
        }
        let label = |element: u32| problem.mesh.element_labels()[element as usize];
        let found = self.inside(problem, simulation);
        let &(owner, element, _) = found.iter().min_by_key(|&&(owner, element, _)| (label(owner), label(element)))?;
        self.is_told = true;
        let bodies = &problem.connectivity.body_of_element;
        let whose = if bodies[owner as usize] == bodies[element as usize] { "the same body" } else { "another body" };
        let faces = found.iter().map(|(_, _, face)| face).collect::<BTreeSet<_>>().len();
        let are = if faces == 1 {
            "1 face of the surface is".to_owned()
        } else {
            format!("{faces} faces of the surface are")
        };
        Some(format!(
            "warning: {are} inside of elements that they do not belong to at t = {:.6e} s, such as one of element {} inside element {} of \
             {whose}: bodies of elements do not touch, neither each other nor themselves, so they pass through each other without any force",
            simulation.time(),
            label(owner),
            label(element),
        ))
    }

    /// Outer faces whose middle is inside of an element: the element that has the face, the other, and the face.
    fn inside(&self, problem: &Problem, simulation: &Simulation) -> Vec<(u32, u32, u32)> {
        let (reference, displacement) = (simulation.reference(), simulation.displacement());
        let place = |node: u32| -> [f64; 3] {
            std::array::from_fn(|axis| reference[node as usize][axis] + displacement[node as usize][axis])
        };
        let (elements, faces) = (problem.mesh.elements(), &problem.connectivity.outer_faces);
        let is_deleted = if simulation.deletes() { simulation.deleted() } else { vec![false; elements.len()] };
        let middle = |face: &Face| {
            let corners = if let Face::Triangle6(nodes) = face { &nodes[..3] } else { face.nodes() };
            mean(&corners.iter().map(|&node| place(node)).collect::<Vec<_>>())
        };
        let middles = (0..).zip(faces).filter(|(_, outer)| !is_deleted[outer.element as usize]);
        let tree = PointTree::new(middles.map(|(number, outer)| (middle(&outer.face), number)).collect());
        let in_element = |element: usize| {
            let own = elements.nodes(element);
            let places: Vec<[f64; 3]> = own.iter().map(|&node| place(node)).collect();
            let side = |start: f64, choose: fn(f64, f64) -> f64| -> [f64; 3] {
                std::array::from_fn(|axis| places.iter().map(|place| place[axis]).fold(start, choose))
            };
            let mut found = Vec::new();
            if !is_deleted[element] {
                tree.in_box(&side(f64::INFINITY, f64::min), &side(f64::NEG_INFINITY, f64::max), |face, point| {
                    let owner = faces[face as usize].element;
                    // neighbours overlap where a mesh is badly distorted: that is no other body
                    let is_neighbour = || elements.nodes(owner as usize).iter().any(|node| own.contains(node));
                    if is_inside(point, elements.shape(element), &places, self.outer[element]) && !is_neighbour() {
                        found.push((owner, element as u32, face));
                    }
                    ControlFlow::Continue(())
                });
            }
            found
        };
        (0..elements.len()).into_par_iter().flat_map_iter(in_element).collect()
    }
}

fn mean(points: &[[f64; 3]]) -> [f64; 3] {
    std::array::from_fn(|axis| points.iter().map(|point| point[axis]).sum::<f64>() / points.len() as f64)
}

/// Whether a point is inside of an element: well behind its outer faces, and behind the others.
fn is_inside(point: &[f64; 3], shape: Shape, nodes: &[[f64; 3]], outer: u8) -> bool {
    let volume = estar_mesh::quality::volume(shape, nodes);
    volume > 0.0
        && shape.faces().iter().enumerate().all(|(number, face)| {
            let count = if face.len() == 4 { 4 } else { 3 };
            let corners: Vec<[f64; 3]> = face[..count].iter().map(|&place| nodes[place]).collect();
            let (centre, to) = (mean(&corners), |a: usize, b: usize| -> [f64; 3] {
                std::array::from_fn(|axis| corners[b][axis] - corners[a][axis])
            });
            // of a quad half the product of the diagonals
            let [a, b] = if count == 4 { [to(0, 2), to(1, 3)] } else { [to(0, 1), to(0, 2)] };
            let area: [f64; 3] = std::array::from_fn(|i| {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                0.5 * (a[j] * b[k] - a[k] * b[j])
            });
            // (x − c)·A ≤ s V, where V/|A| is the thickness behind the face
            let height: f64 = (0..3).map(|axis| (point[axis] - centre[axis]) * area[axis]).sum();
            let is_outer = outer >> number & 1 == 1;
            height <= if is_outer { -DEEP } else { SLACK } * volume
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_inside_where_it_is_behind_every_face_and_well_behind_outer_ones() {
        let cube: Vec<[f64; 3]> = estar_mesh::hex::CORNER_SIGNS.to_vec();
        let inside = |point: [f64; 3], outer: u8| is_inside(&point, Shape::Hex8, &cube, outer);
        assert!(inside([0.0; 3], 0x3f) && inside([0.79, -0.79, 0.79], 0x3f));
        assert!(!inside([0.81, 0.0, 0.0], 0x3f) && !inside([0.0, 0.0, -0.81], 0x3f) && !inside([3.0, 0.0, 0.0], 0));
        // the first face is that below
        assert!(inside([1.0, 1.0, 1.0], 1) && inside([0.0, 0.0, -0.81], 0) && !inside([0.0, 0.0, -0.81], 1));
        let tet = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        assert!(is_inside(&[0.2; 3], Shape::Tet4, &tet, 0xf) && !is_inside(&[0.01; 3], Shape::Tet4, &tet, 0xf));
        assert!(!is_inside(&[0.33; 3], Shape::Tet4, &tet, 0xf) && is_inside(&[0.33; 3], Shape::Tet4, &tet, 0));
    }
}
