//! The memory that a simulation takes, told before it takes it.

use crate::model::{Model, OnInversion, TimeStep};
use estar_element::element::{Element, ElementHistory, ElementVisitor};
use estar_material::MaterialModel;
use estar_mesh::Mesh;

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
        .map(|part| part.elements.len() * (part.element.visit(BytesOf(&part.material)) + energy))
        .sum();
    let of_group = |group: &estar_mesh::Group| {
        size_of_val(&*group.nodes) + size_of_val(&*group.elements) + size_of_val(&*group.faces)
    };
    let groups: usize = mesh.groups().iter().map(of_group).sum();
    let elements = mesh.element_count() * of_element + mesh.elements().all_nodes().len() * of_corner;
    mesh.node_count() * of_node + elements + histories + groups
}

/// Bytes of the history of one element and of its points.
struct BytesOf<'a>(&'a MaterialModel);

impl ElementVisitor for BytesOf<'_> {
    type Output = usize;

    fn visit<const NODES: usize, E: Element<NODES>>(self, _: E) -> usize {
        size_of::<ElementHistory<f64, E::Own<f64>>>() + self.0.points::<f64>(E::POINTS).of_packs(1).bytes()
    }
}
