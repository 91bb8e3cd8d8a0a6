//! Ordered assembly: each element writes its corner forces to slots of its own, and each node sums its corners in one
//! fixed order. No two threads write to one place, and the sum does not depend on who computed what.

/// Where a node finds the forces of its corners.
#[derive(Clone, Debug)]
pub(crate) struct CornerLists {
    /// Start of each node's list in `slots`, and the end of the last.
    starts: Vec<u32>,
    /// Position of the x component of a corner force; y and z follow at `stride`.
    slots: Vec<u32>,
    stride: usize,
}

impl CornerLists {
    /// The lists of `node_count` nodes from `(node, slot)` of every corner, in the order of summation.
    pub fn new(node_count: usize, corners: impl Iterator<Item = (u32, u32)> + Clone, stride: usize) -> Self {
        let mut starts = vec![0; node_count + 1];
        for (node, _) in corners.clone() {
            starts[node as usize + 1] += 1;
        }
        for node in 0..node_count {
            starts[node + 1] += starts[node];
        }
        let mut next = starts.clone();
        let mut slots = vec![0; starts[node_count] as usize];
        for (node, slot) in corners {
            slots[next[node as usize] as usize] = slot;
            next[node as usize] += 1;
        }
        Self { starts, slots, stride }
    }

    /// Bytes that the sums of all nodes read: the lists and every corner force.
    pub fn bytes_per_step(&self) -> usize {
        let forces = self.slots.len() * 3 * size_of::<f64>();
        size_of_val(&*self.starts) + size_of_val(&*self.slots) + forces
    }

    /// Sum of the corner forces of `node`, N.
    #[inline]
    pub fn sum(&self, corner_forces: &[f64], node: usize) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for &slot in &self.slots[self.starts[node] as usize..self.starts[node + 1] as usize] {
            for (component, sum) in sum.iter_mut().enumerate() {
                *sum += corner_forces[slot as usize + component * self.stride];
            }
        }
        sum
    }
}
