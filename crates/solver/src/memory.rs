//! The memory that a simulation takes, told before it takes it.

use crate::model::{Model, OnInversion};
use estar_element::hex8::{CORNERS, HexHistory};
use estar_material::{Material, MaterialVisitor};
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
    let of_node = (vector + number) + (4 * vector + number) + external_force + 4 * index;

    let corners = CORNERS * size_of::<u16>();
    let row = size_of::<[f64; 4]>() + 2 * index;
    // nodes and label in the mesh, nodes once more while the block is made
    let of_hex = 2 * CORNERS * index + number + corners + 2 * number + index + ROWS * row / OF_ELEMENTS;

    let deletes = model.settings.on_inversion == OnInversion::Delete;
    let energy = if deletes { number } else { 0 };
    let histories: usize =
        model.parts.iter().map(|part| part.hexes.len() * (part.material.visit(BytesOfHistory) + energy)).sum();
    let of_group = |group: &estar_mesh::Group| {
        size_of_val(&*group.nodes) + size_of_val(&*group.hexes) + size_of_val(&*group.faces)
    };
    let groups: usize = mesh.groups().iter().map(of_group).sum();
    mesh.node_count() * of_node + mesh.hex_count() * of_hex + histories + groups
}

/// Bytes of the history of one element.
struct BytesOfHistory;

impl MaterialVisitor for BytesOfHistory {
    type Output = usize;

    fn visit<M: Material>(self, _: &M) -> usize {
        size_of::<HexHistory<M::State<f64>, f64>>()
    }
}
