//! What a step moves between memory and processor.

use crate::block::NodalAverages;
use crate::simulation::Simulation;

impl Simulation {
    /// Bytes that a step reads and writes, counted from the sizes of the data.
    ///
    /// Each sweep of the step (see `central_difference.rs`) is taken to move all that it touches once: a node that eight
    /// elements gather is read once, a store moves only what it stores, and nothing stays in a cache from one sweep to the
    /// next. Left out are loads, and the few nodes that are constrained. Rotations are counted for theories that need none too:
    /// they are moved as a part of the history.
    pub fn bytes_per_step(&self) -> usize {
        const VECTOR: usize = size_of::<[f64; 3]>();
        const NUMBER: usize = size_of::<f64>();
        // u read and written, v read
        let drift = 3 * VECTOR;
        // X, u and v read
        let elements = 3 * VECTOR;
        // X, u and m read, v read and written, a written, the node's place among the constraints read
        let kick = 5 * VECTOR + NUMBER + size_of::<u32>();
        let blocks: usize = self.blocks.iter().map(|block| block.elements.bytes_per_step()).sum();
        let averages: usize = self.averages.iter().map(NodalAverages::bytes_per_step).sum();
        self.nodes.mass.len() * (drift + elements + kick) + blocks + averages + self.row_lists.bytes_per_step()
    }
}
