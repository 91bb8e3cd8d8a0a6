//! The memory that a simulation takes, told before it takes it.

use crate::model::{Formulation, Model, OnInversion, TimeStep};
use estar_element::element::{Element, ElementVisitor};
use estar_material::{Material, MaterialVisitor};
use estar_mesh::Mesh;
use std::marker::PhantomData;

/// Rows of forces an element: a patch of 512 elements has about 1.5 nodes an element where neighbours are close in the order
/// of the mesh.
const ROWS: usize = 3;
const OF_ELEMENTS: usize = 2;

/// Bytes that [`Simulation::new`](crate::Simulation::new) takes at its peak, about: what grows with the mesh.
pub fn memory_needed(mesh: &Mesh, model: &Model) -> usize {
    let vector = size_of::<[f64; 3]>();
    let number = size_of::<f64>();
    let index = size_of::<u32>();

    // positions and labels, which a simulation has of its own; motion, acceleration, reaction, mass; lists of rows
    let external_force = if model.loads.is_empty() { 0 } else { vector };
    // two vectors of Lanczos' method; what elements are and were, and their tangents
    let estimates = model.settings.time_step != TimeStep::Element;
    let (of_estimate, of_tangent) = if estimates { (2 * vector, 6 * number) } else { (0, 0) };
    let of_node = (vector + number) + (4 * vector + number) + external_force + 4 * index + of_estimate;

    let row = size_of::<[f64; 4]>() + 2 * index;
    // label, number, position of the first node and shape in the mesh, mass and step in the block
    let of_element = number + index + number + 1 + 2 * number + ROWS * row / OF_ELEMENTS + of_tangent;
    // in the mesh, once more while the block is made, and its place in a patch
    let of_corner = 2 * index + size_of::<u16>();

    let deletes = model.settings.on_inversion == OnInversion::Delete;
    let energy = if deletes { number } else { 0 };
    let histories: usize = model
        .parts
        .iter()
        .map(|part| part.elements.len() * (part.material.visit(BytesOf(part.element)) + energy))
        .sum();
    let of_group = |group: &estar_mesh::Group| {
        size_of_val(&*group.nodes) + size_of_val(&*group.elements) + size_of_val(&*group.faces)
    };
    let groups: usize = mesh.groups().iter().map(of_group).sum();
    let elements = mesh.element_count() * of_element + mesh.elements().all_nodes().len() * of_corner;
    mesh.node_count() * of_node + elements + histories + groups
}

/// Bytes of the history of one element.
struct BytesOf(Formulation);

impl MaterialVisitor for BytesOf {
    type Output = usize;

    fn visit<M: Material>(self, _: &M) -> usize {
        self.0.visit(BytesOfMaterial::<M>(PhantomData))
    }
}

struct BytesOfMaterial<M>(PhantomData<M>);

impl<M: Material> ElementVisitor for BytesOfMaterial<M> {
    type Output = usize;

    fn visit<const NODES: usize, E: Element<NODES>>(self, _: E) -> usize {
        size_of::<E::History<f64, M::State<f64>>>()
    }
}
