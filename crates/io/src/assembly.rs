//! From the numbers of a file to a mesh: what all formats share.

use std::collections::HashMap;

use estar_mesh::{ElementLabel, Group, Mesh, NodeLabel};

use crate::MeshFile;
use crate::error::Problem;

/// Nodes and hexes on their way to a mesh.
#[derive(Debug, Default)]
pub(crate) struct Assembly {
    pub coordinates: Vec<[f64; 3]>,
    pub node_labels: Vec<NodeLabel>,
    pub hexes: Vec<[u32; 8]>,
    pub hex_labels: Vec<ElementLabel>,
    pub groups: Vec<Group>,
    pub warnings: Vec<String>,
}

impl Assembly {
    /// The finished mesh.
    pub fn finish(self, format: String) -> Result<MeshFile, Problem> {
        let mesh = Mesh::new(self.coordinates, self.node_labels, self.hexes, self.hex_labels, self.groups)?;
        Ok(MeshFile { mesh, format, warnings: self.warnings })
    }
}

/// The index of each node by its number in the file.
#[derive(Debug)]
pub(crate) enum NodeIndex {
    /// Numbers that leave few gaps: a table from the first on; `u32::MAX` is a gap.
    Dense { first: u64, table: Vec<u32> },
    /// Any numbers.
    Sparse(HashMap<u64, u32>),
}

impl NodeIndex {
    /// Labels used twice keep one index; [`Mesh::new`] refuses them.
    pub fn new(labels: &[NodeLabel]) -> Self {
        let first = labels.iter().map(|label| label.0).min().unwrap_or(0);
        let last = labels.iter().map(|label| label.0).max().unwrap_or(0);
        let indexed = labels.iter().zip(0_u32..).map(|(label, index)| (label.0, index));
        // A table is ten times faster than a map; it may be up to four times as long as the list it indexes.
        if last - first < 4 * labels.len() as u64 {
            let mut table = vec![u32::MAX; (last - first) as usize + 1];
            for (label, index) in indexed {
                table[(label - first) as usize] = index;
            }
            Self::Dense { first, table }
        } else {
            Self::Sparse(indexed.collect())
        }
    }

    pub fn get(&self, label: u64) -> Option<u32> {
        match self {
            Self::Dense { first, table } => {
                let offset = usize::try_from(label.checked_sub(*first)?).ok()?;
                table.get(offset).copied().filter(|index| *index != u32::MAX)
            }
            Self::Sparse(map) => map.get(&label).copied(),
        }
    }

    /// The corners of an element by their indices.
    pub fn corners<const COUNT: usize>(&self, element: u64, labels: &[u64]) -> Result<[u32; COUNT], Problem> {
        let mut corners = [0; COUNT];
        for (corner, &node) in corners.iter_mut().zip(labels) {
            *corner = self.get(node).ok_or(Problem::MissingNode { element, node })?;
        }
        Ok(corners)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_are_found_by_dense_and_by_sparse_numbers() {
        for labels in [vec![5, 3, 4, 9], vec![u64::MAX, 3, 1 << 60, 0]] {
            let labels: Vec<NodeLabel> = labels.into_iter().map(NodeLabel).collect();
            let index = NodeIndex::new(&labels);
            for (expected, label) in labels.iter().enumerate() {
                assert_eq!(index.get(label.0), Some(expected as u32));
            }
            assert_eq!((index.get(6), index.get(2), index.get(1 << 61)), (None, None, None));
        }
    }
}
