//! Patches: runs of consecutive elements of a block that one thread takes at a time, with the nodes that they touch.
//!
//! Each patch sums the forces of its elements in rows of its own, in the order of the elements; then each node sums its
//! rows in the order of the patches (`assembly.rs`). No two threads write to one place, and no sum depends on who computed
//! what. With elements in an order that keeps neighbours together a patch has little more than a node an element, so that
//! its rows stay in the nearest cache while they are summed.

/// No number has more lanes.
pub(crate) const MOST_LANES: usize = 8;
/// Elements of a patch, but for the last of a block; a multiple of every number of lanes. Sums of energies are formed
/// within a patch first as well.
pub(crate) const PATCH: usize = 512;

/// The nodes of the patches of a block.
pub(crate) struct Patches {
    /// Nodes of all patches, each once a patch.
    nodes: Vec<u32>,
    /// Start of each patch in `nodes`, and the end of the last.
    starts: Vec<u32>,
    /// Which of its patch's nodes each corner is: in each pack the first corner of all lanes, then the second, ...
    corners: Vec<u16>,
    /// Rows set aside for a patch: the most nodes of one.
    stride: usize,
}

impl Patches {
    /// The patches of the elements with these nodes, `lanes` elements a pack. The last pack is filled up with copies of the
    /// last element.
    pub fn new<const NODES: usize>(connectivity: &[[u32; NODES]], lanes: usize) -> Self {
        let node_count = connectivity.as_flattened().iter().max().map_or(0, |&node| node as usize + 1);
        // the last patch that has a node, and the node's place in it
        let mut seen = vec![(u32::MAX, 0_u16); node_count];
        let mut patches = Self { nodes: Vec::new(), starts: vec![0], corners: Vec::new(), stride: 0 };
        patches.corners.reserve_exact(connectivity.len().next_multiple_of(lanes) * NODES);
        for (patch, elements) in connectivity.chunks(PATCH).enumerate() {
            let start = patches.nodes.len();
            for &node in elements.as_flattened() {
                let (last_patch, place) = &mut seen[node as usize];
                if *last_patch != patch as u32 {
                    (*last_patch, *place) = (patch as u32, (patches.nodes.len() - start) as u16);
                    patches.nodes.push(node);
                }
            }
            for pack in elements.chunks(lanes) {
                let element = |lane: usize| &pack[lane.min(pack.len() - 1)];
                for place in 0..NODES * lanes {
                    let node = element(place % lanes)[place / lanes];
                    patches.corners.push(seen[node as usize].1);
                }
            }
            patches.stride = patches.stride.max(patches.nodes.len() - start);
            patches.starts.push(patches.nodes.len() as u32);
        }
        patches
    }

    /// Rows set aside for each patch.
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// Rows set aside for all patches.
    pub fn row_count(&self) -> usize {
        (self.starts.len() - 1) * self.stride
    }

    /// Nodes of a patch; the n-th has the n-th of the patch's rows.
    pub fn nodes(&self, patch: usize) -> &[u32] {
        &self.nodes[self.starts[patch] as usize..self.starts[patch + 1] as usize]
    }

    /// The node of every row that is used, with the row.
    pub fn rows(&self) -> impl Iterator<Item = (u32, usize)> {
        (0..self.starts.len() - 1).flat_map(move |patch| {
            self.nodes(patch).iter().enumerate().map(move |(place, &node)| (node, patch * self.stride + place))
        })
    }

    /// Which of its patch's nodes each corner is, pack by pack.
    pub fn corners(&self) -> &[u16] {
        &self.corners
    }

    /// Bytes that a sweep over the elements reads of this, and writes of the rows.
    pub fn bytes_per_step(&self) -> usize {
        let rows = self.nodes.len() * size_of::<[f64; 4]>();
        size_of_val(&*self.nodes) + size_of_val(&*self.starts) + size_of_val(&*self.corners) + rows
    }
}
