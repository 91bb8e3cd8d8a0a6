//! Bodies that pass through each other, or through themselves, in a run: without contact nothing stops them, and nobody should
//! take that for a result.

use crate::setup::Problem;
use estar_mesh::{PointTree, Shape};
use estar_solver::Simulation;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::ops::ControlFlow;

/// A node is inside of an element when it is behind each of its faces by this share of the element's thickness there.
const DEEP: f64 = 0.1;
/// More nodes than these are not looked into.
const MOST_FOUND: usize = 100_000;

/// Looks whether nodes of the surface are inside of elements that they do not belong to, until there are some.
#[derive(Debug)]
pub struct Passing {
    outer_nodes: Vec<u32>,
    is_told: bool,
}

impl Passing {
    /// Nothing has been seen yet.
    pub fn new(problem: &Problem) -> Self {
        Self { outer_nodes: problem.connectivity.outer_nodes(&problem.mesh), is_told: false }
    }

    /// Looks at the present step; a warning the first time that something passes through something.
    pub fn look(&mut self, problem: &Problem, simulation: &Simulation) -> Option<String> {
        if self.is_told {
            return None;
        }
        let places = Places { problem, simulation };
        let found = places.without_neighbours(places.inside(&self.outer_nodes));
        let &(node, element) = found.first()?;
        self.is_told = true;
        let bodies = &problem.connectivity.body_of_element;
        let body_of_node = |node: u32| {
            let of_node = problem.mesh.elements().iter().position(|nodes| nodes.contains(&node));
            of_node.map(|element| bodies[element])
        };
        let whose = if body_of_node(node) == Some(bodies[element as usize]) { "the same body" } else { "another body" };
        let nodes = found.iter().map(|(node, _)| node).collect::<BTreeSet<_>>().len();
        let are = if nodes == 1 {
            "1 node of the surface is".to_owned()
        } else {
            format!("{nodes} nodes of the surface are")
        };
        Some(format!(
            "warning: {are} inside of elements that they do not belong to at t = {:.6e} s, such as node {} inside element {} of {whose}: bodies \
             of elements do not touch, neither each other nor themselves, so they pass through each other without any force",
            simulation.time(),
            problem.mesh.node_labels()[node as usize],
            problem.mesh.element_labels()[element as usize],
        ))
    }
}

/// Where things are at the present step.
struct Places<'a> {
    problem: &'a Problem,
    simulation: &'a Simulation,
}

impl Places<'_> {
    fn of(&self, node: u32) -> [f64; 3] {
        let (reference, displacement) =
            (self.simulation.reference()[node as usize], self.simulation.displacement()[node as usize]);
        [0, 1, 2].map(|axis| reference[axis] + displacement[axis])
    }

    /// Nodes with elements that they are inside of.
    fn inside(&self, nodes: &[u32]) -> Vec<(u32, u32)> {
        let tree = PointTree::new(nodes.iter().map(|&node| (self.of(node), node)).collect());
        let elements = self.problem.mesh.elements();
        let is_deleted = if self.simulation.deletes() { self.simulation.deleted() } else { Vec::new() };
        let in_element = |element: usize| {
            let own = elements.nodes(element);
            let places: Vec<[f64; 3]> = own.iter().map(|&node| self.of(node)).collect();
            let side = |axis: usize, start: f64, choose: fn(f64, f64) -> f64| {
                places.iter().map(|place| place[axis]).fold(start, choose)
            };
            let low = [0, 1, 2].map(|axis| side(axis, f64::INFINITY, f64::min));
            let high = [0, 1, 2].map(|axis| side(axis, f64::NEG_INFINITY, f64::max));
            let mut found = Vec::new();
            if !is_deleted.get(element).is_some_and(|deleted| *deleted) {
                tree.in_box(&low, &high, |node, place| {
                    if !own.contains(&node) && is_inside(place, elements.shape(element), &places) {
                        found.push((node, element as u32));
                    }
                    ControlFlow::Continue(())
                });
            }
            found
        };
        let mut found: Vec<(u32, u32)> = (0..elements.len()).into_par_iter().flat_map_iter(in_element).collect();
        found.sort_by_key(|&(node, element)| {
            (self.problem.mesh.node_labels()[node as usize], self.problem.mesh.element_labels()[element as usize])
        });
        found.truncate(MOST_FOUND);
        found
    }

    /// Those whose element shares no node with an element of the node: neighbours overlap where a mesh is badly distorted.
    fn without_neighbours(&self, mut found: Vec<(u32, u32)>) -> Vec<(u32, u32)> {
        if found.is_empty() {
            return found;
        }
        let elements = self.problem.mesh.elements();
        let is_deleted = if self.simulation.deletes() { self.simulation.deleted() } else { Vec::new() };
        let mut is_found = vec![false; self.problem.mesh.node_count()];
        for &(node, _) in &found {
            is_found[node as usize] = true;
        }
        let mut around: BTreeSet<(u32, u32)> = BTreeSet::new();
        let mut has_element = vec![false; is_found.len()];
        for (element, nodes) in elements.iter().enumerate() {
            for &node in nodes.iter().filter(|&&node| is_found[node as usize]) {
                around.extend(nodes.iter().map(|&other| (node, other)));
                has_element[node as usize] |= !is_deleted.get(element).is_some_and(|deleted| *deleted);
            }
        }
        found.retain(|&(node, element)| {
            let of_element = elements.nodes(element as usize);
            // what is left of a node is no body when all its elements are deleted
            has_element[node as usize] && !of_element.iter().any(|&other| around.contains(&(node, other)))
        });
        found
    }
}

/// Whether a point is well inside of an element.
fn is_inside(point: &[f64; 3], shape: Shape, nodes: &[[f64; 3]]) -> bool {
    let volume = estar_mesh::quality::volume(shape, nodes);
    volume > 0.0
        && shape.faces().iter().all(|face| {
            let corners: Vec<[f64; 3]> =
                face.iter().take(if face.len() == 6 { 3 } else { 4 }).map(|&place| nodes[place]).collect();
            let count = corners.len();
            let centre = [0, 1, 2].map(|axis| corners.iter().map(|corner| corner[axis]).sum::<f64>() / count as f64);
            let to = |a: usize, b: usize| [0, 1, 2].map(|axis| corners[b][axis] - corners[a][axis]);
            // of a quad half the product of the diagonals
            let [a, b] = if count == 4 { [to(0, 2), to(1, 3)] } else { [to(0, 1), to(0, 2)] };
            let area = [0, 1, 2].map(|i| {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                0.5 * (a[j] * b[k] - a[k] * b[j])
            });
            // (x − c)·A ≤ −s V, where V/|A| is the thickness behind the face
            let height: f64 = (0..3).map(|axis| (point[axis] - centre[axis]) * area[axis]).sum();
            height <= -DEEP * volume
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_inside_where_it_is_well_behind_every_face() {
        let cube: Vec<[f64; 3]> = estar_mesh::hex::CORNER_SIGNS.to_vec();
        let inside = |point: [f64; 3]| is_inside(&point, Shape::Hex8, &cube);
        assert!(inside([0.0; 3]) && inside([0.79, -0.79, 0.79]));
        assert!(!inside([0.81, 0.0, 0.0]) && !inside([0.0, 0.0, -0.81]) && !inside([3.0, 0.0, 0.0]));
        let tet = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        assert!(is_inside(&[0.2; 3], Shape::Tet4, &tet) && !is_inside(&[0.01; 3], Shape::Tet4, &tet));
        assert!(!is_inside(&[0.33; 3], Shape::Tet4, &tet));
    }
}
