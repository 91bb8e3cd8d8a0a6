//! Ordered assembly: each patch of elements sums the forces on its nodes in rows of its own, and each node sums its rows
//! in one fixed order. No two threads write to one place, and the sum does not depend on who computed what.

/// Nodes that one thread takes at a time; sums over nodes are formed within such a chunk first.
pub(crate) const CHUNK: usize = 1024;

/// Where a node finds the forces of the patches that touch it.
#[derive(Clone, Debug)]
pub(crate) struct RowLists {
    /// Start of each node's list in `rows`, and the end of the last.
    starts: Vec<u32>,
    rows: Vec<u32>,
}

impl RowLists {
    /// The lists of `node_count` nodes from the node and the position of every row, in the order of summation; `rows` is
    /// gone through twice.
    pub fn new<I: Iterator<Item = (u32, usize)>>(node_count: usize, rows: impl Fn() -> I) -> Self {
        let mut starts = vec![0; node_count + 1];
        for (node, _) in rows() {
            starts[node as usize + 1] += 1;
        }
        for node in 0..node_count {
            starts[node + 1] += starts[node];
        }
        let mut next = starts.clone();
        let mut list = vec![0; starts[node_count] as usize];
        for (node, row) in rows() {
            list[next[node as usize] as usize] = row as u32;
            next[node as usize] += 1;
        }
        Self { starts, rows: list }
    }

    /// Bytes that the sums of all nodes read: the lists and every row.
    pub fn bytes_per_step(&self) -> usize {
        size_of_val(&*self.starts) + size_of_val(&*self.rows) + self.rows.len() * size_of::<[f64; 4]>()
    }

    /// Sum of the forces on `node`, N.
    #[inline]
    pub fn sum(&self, patch_forces: &[[f64; 4]], node: usize) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for &row in &self.rows[self.starts[node] as usize..self.starts[node + 1] as usize] {
            let [x, y, z, _] = patch_forces[row as usize];
            sum = [sum[0] + x, sum[1] + y, sum[2] + z];
        }
        sum
    }

    /// Sum of all four numbers of the rows of `node`.
    pub fn sums(&self, rows: &[[f64; 4]], node: usize) -> [f64; 4] {
        let mut sums = [0.0; 4];
        for &row in &self.rows[self.starts[node] as usize..self.starts[node + 1] as usize] {
            for (sum, number) in sums.iter_mut().zip(rows[row as usize]) {
                *sum += number;
            }
        }
        sums
    }
}
