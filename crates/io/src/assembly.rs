//! From the numbers of a file to a mesh: what all formats share.

use std::collections::HashMap;

use estar_mesh::{ElementLabel, ElementNodes, Elements, Group, Mesh, NodeLabel, Shape};

use crate::MeshFile;
use crate::error::Problem;

/// Nodes and elements on their way to a mesh.
#[derive(Debug, Default)]
pub(crate) struct Assembly {
    pub coordinates: Vec<[f64; 3]>,
    pub node_labels: Vec<NodeLabel>,
    pub elements: Elements,
    pub element_labels: Vec<ElementLabel>,
    pub groups: Vec<Group>,
    pub warnings: Vec<String>,
}

impl Assembly {
    /// Adds an element, a collapsed hex as the wedge, the pyramid or the tet that it is, and returns its index.
    pub fn add(&mut self, label: u64, shape: Shape, nodes: &[u32]) -> u32 {
        match (shape, <&[u32; 8]>::try_from(nodes)) {
            (Shape::Hex8, Ok(corners)) => {
                let (shape, nodes) = Shape::of_hex(corners);
                self.elements.push(shape, &nodes);
            }
            _ => self.elements.push(shape, nodes),
        }
        self.element_labels.push(ElementLabel(label));
        self.elements.len() as u32 - 1
    }

    /// The finished mesh.
    pub fn finish(self, format: String) -> Result<MeshFile, Problem> {
        let mesh = Mesh::new(self.coordinates, self.node_labels, self.elements, self.element_labels, self.groups)?;
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

    /// The nodes of an element by their indices.
    pub fn nodes(&self, element: u64, labels: &[u64]) -> Result<ElementNodes, Problem> {
        let index = |&node: &u64| self.get(node).ok_or(Problem::MissingNode { element, node });
        labels.iter().map(index).collect()
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
