//! From the numbers of a file to a mesh: what all formats share.

use std::collections::HashMap;

use estar_mesh::{ElementLabel, ElementNodes, Elements, Group, GroupKind, Mesh, MeshError, NodeLabel, Shape};

use crate::MeshFile;
use crate::error::{Problem, and_more};

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

    /// The finished mesh: nodes of no element are left out, and all elements are a group.
    pub fn finish(mut self, format: String) -> Result<MeshFile, Problem> {
        self.leave_out_loose_nodes();
        self.add_whole();
        let mesh = Mesh::new(self.coordinates, self.node_labels, self.elements, self.element_labels, self.groups)?;
        Ok(MeshFile { mesh, format, warnings: self.warnings })
    }

    /// Adds the group of all elements, unless the file has it. A set of that name that is less gets another one, and one that
    /// differs from it in capitals only is told.
    fn add_whole(&mut self) {
        let (nodes, elements) = (self.coordinates.len(), self.elements.len());
        let count = |members: &[u32]| {
            let mut members = members.to_vec();
            members.sort_unstable();
            members.dedup();
            members.len()
        };
        let is_whole = |group: &Group| match group.kind {
            GroupKind::Volume => count(&group.elements) == elements,
            GroupKind::Nodes => count(&group.nodes) == nodes,
            // of the others a deck is asked which it means
            GroupKind::Surface | GroupKind::Curve | GroupKind::Point => true,
        };
        let mut namesakes: HashMap<(String, GroupKind), usize> = HashMap::new();
        for group in self.groups.iter().filter(|group| group.name.eq_ignore_ascii_case(ALL)) {
            *namesakes.entry((group.name.clone(), group.kind)).or_default() += 1;
        }
        let mut others = Vec::new();
        for group in self.groups.iter_mut().filter(|group| group.name.eq_ignore_ascii_case(ALL) && !is_whole(group)) {
            let name = group.name.clone();
            if name == ALL {
                group.name = format!("set.{ALL}");
            } else if namesakes.get(&(name.clone(), group.kind)).is_some_and(|count| *count > 1) {
                // of several owners: a deck is asked which it means
                continue;
            }
            others.push(format!("\"{}\", the {} \"{name}\" of the file", group.name, group.kind));
        }
        if !others.is_empty() {
            let list = and_more(others);
            self.warnings
                .push(format!("the group \"{ALL}\" is the whole mesh; the file has others of the name: {list}"));
        }
        if !self.groups.iter().any(|group| group.name == ALL && group.kind == GroupKind::Volume) {
            self.groups.push(Group::volume(ALL, (0..elements as u32).collect()));
        }
    }

    /// Leaves out what belongs to no element: reference points, centres of arcs, nodes of shells that are left out.
    fn leave_out_loose_nodes(&mut self) {
        let mut new = vec![LOOSE; self.coordinates.len()];
        for &node in self.elements.all_nodes() {
            new[node as usize] = 0;
        }
        let loose: Vec<usize> = (0..new.len()).filter(|&node| new[node] == LOOSE).collect();
        if loose.is_empty() || self.elements.is_empty() {
            return;
        }
        let labels = and_more(loose.iter().map(|&node| self.node_labels[node].to_string()));
        self.warnings.push(match loose.len() {
            1 => format!("1 node belongs to no element and is left out: {labels}"),
            count => format!("{count} nodes belong to no element and are left out: {labels}"),
        });

        let mut count = 0;
        for (node, new) in new.iter_mut().enumerate() {
            if *new != LOOSE {
                *new = count;
                self.coordinates[count as usize] = self.coordinates[node];
                self.node_labels[count as usize] = self.node_labels[node];
                count += 1;
            }
        }
        self.coordinates.truncate(count as usize);
        self.node_labels.truncate(count as usize);
        let mut elements = Elements::default();
        for (element, nodes) in self.elements.iter().enumerate() {
            let nodes: ElementNodes = nodes.iter().map(|&node| new[node as usize]).collect();
            elements.push(self.elements.shape(element), &nodes);
        }
        self.elements = elements;
        let kept = |node: &u32| new[*node as usize] != LOOSE;
        for group in &mut self.groups {
            group.nodes.retain(kept);
            group.nodes.iter_mut().for_each(|node| *node = new[*node as usize]);
            group.faces.retain(|face| face.nodes().iter().all(kept));
            group.faces.iter_mut().for_each(|face| *face = face.map(|node| new[node as usize]));
        }
        let is_empty = |group: &Group| group.nodes.is_empty() && group.faces.is_empty() && group.elements.is_empty();
        let empty: Vec<String> =
            self.groups.iter().filter(|group| is_empty(group)).map(|group| format!("\"{}\"", group.name)).collect();
        if !empty.is_empty() {
            let (groups, are) = if empty.len() == 1 { ("group has", "is") } else { ("groups have", "are") };
            let count = empty.len();
            self.warnings.push(format!("{count} {groups} only such nodes and {are} left out: {}", and_more(empty)));
            self.groups.retain(|group| !is_empty(group));
        }
    }
}

/// The group of all elements, which every mesh that is read has.
const ALL: &str = "all";
/// A node that no element has.
const LOOSE: u32 = u32::MAX;

/// The place of each node or element by its number in the file.
#[derive(Debug)]
pub(crate) enum LabelIndex {
    /// Numbers that leave few gaps: a table from the first on; `u32::MAX` is a gap.
    Dense { first: u64, table: Vec<u32> },
    /// Any numbers.
    Sparse(HashMap<u64, u32>),
}

impl LabelIndex {
    /// The index, and a number that is there twice, if there is one.
    pub fn new(labels: impl ExactSizeIterator<Item = u64> + Clone) -> (Self, Option<u64>) {
        let first = labels.clone().min().unwrap_or(0);
        let last = labels.clone().max().unwrap_or(0);
        let count = labels.len() as u64;
        let indexed = labels.zip(0_u32..);
        let mut twice = None;
        // A table is ten times faster than a map; it may be up to four times as long as the list it indexes.
        if last - first < 4 * count {
            let mut table = vec![u32::MAX; (last - first) as usize + 1];
            for (label, index) in indexed {
                if std::mem::replace(&mut table[(label - first) as usize], index) != u32::MAX {
                    twice = twice.or(Some(label));
                }
            }
            (Self::Dense { first, table }, twice)
        } else {
            let mut map = HashMap::new();
            for (label, index) in indexed {
                if map.insert(label, index).is_some() {
                    twice = twice.or(Some(label));
                }
            }
            (Self::Sparse(map), twice)
        }
    }

    /// That of nodes, whose numbers must differ.
    pub fn of_nodes(labels: &[NodeLabel]) -> Result<Self, Problem> {
        match Self::new(labels.iter().map(|label| label.0)) {
            (index, None) => Ok(index),
            (_, Some(label)) => Err(MeshError::DuplicateNodeLabel { node: NodeLabel(label) }.into()),
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
            let (index, twice) = LabelIndex::new(labels.iter().copied());
            assert_eq!(twice, None);
            for (expected, label) in labels.iter().enumerate() {
                assert_eq!(index.get(*label), Some(expected as u32));
            }
            assert_eq!((index.get(6), index.get(2), index.get(1 << 61)), (None, None, None));
        }
    }
}
