//! What has numbers and names of its own: a file without parts, a part, an instance, the assembly.

use std::ops::Range;

use estar_mesh::{ElementNodes, MeshError, NodeLabel};

use super::element_type::Use;
use super::keyword::Origin;
use super::placement::Placement;
use super::sets::{SetDefinition, SurfaceDefinition};
use crate::assembly::LabelIndex;
use crate::error::{Located, Problem};

/// An element by the numbers of the file.
#[derive(Debug, Clone)]
pub(super) struct Element {
    pub label: u64,
    pub usage: Use,
    /// Its nodes in the list of all.
    pub nodes: Range<usize>,
    pub origin: Origin,
}

/// Nodes, elements, sets and surfaces, as they are written.
#[derive(Debug, Clone, Default)]
pub(super) struct Scope {
    pub node_labels: Vec<u64>,
    pub coordinates: Vec<[f64; 3]>,
    /// Where nodes are written that the node itself may not tell: the first and the last.
    pub node_origin: Origin,
    pub elements: Vec<Element>,
    /// The nodes of all elements, by their numbers.
    pub element_nodes: Vec<u64>,
    pub sets: Vec<SetDefinition>,
    pub surfaces: Vec<SurfaceDefinition>,
    /// In which nodes are given at this place of the file.
    pub system: Option<Placement>,
}

impl Scope {
    pub fn is_empty(&self) -> bool {
        self.node_labels.is_empty() && self.elements.is_empty() && self.sets.is_empty() && self.surfaces.is_empty()
    }

    pub fn has_solids(&self) -> bool {
        self.elements.iter().any(|element| matches!(element.usage, Use::Solid(_)))
    }

    /// This and what an instance adds to it.
    pub fn with(&self, more: &Self) -> Self {
        let mut all = self.clone();
        let (nodes, elements) = (self.node_labels.len() as u32, self.elements.len() as u32);
        let in_pool = self.element_nodes.len();
        all.node_labels.extend(&more.node_labels);
        all.coordinates.extend(&more.coordinates);
        all.element_nodes.extend(&more.element_nodes);
        all.elements.extend(more.elements.iter().map(|element| Element {
            nodes: element.nodes.start + in_pool..element.nodes.end + in_pool,
            ..element.clone()
        }));
        all.sets.extend(more.sets.iter().map(|set| set.shifted(nodes, elements)));
        all.surfaces.extend(more.surfaces.iter().cloned());
        if all.node_origin == Origin::default() {
            all.node_origin = more.node_origin;
        }
        all
    }
}

/// What the numbers of a scope stand for.
#[derive(Debug)]
pub(super) struct Index {
    pub nodes: LabelIndex,
    pub elements: LabelIndex,
    /// Each element's place among the solids; that of the next solid for what is none.
    pub solid_rank: Vec<u32>,
    /// The nodes of all elements, by their places. `u32::MAX` where one that is of no use is not there.
    pub element_nodes: Vec<u32>,
}

impl Index {
    pub fn new(scope: &Scope) -> Result<Self, Located> {
        let (nodes, twice) = LabelIndex::new(scope.node_labels.iter().copied());
        if let Some(label) = twice {
            let problem = Problem::Mesh(MeshError::DuplicateNodeLabel { node: NodeLabel(label) });
            return Err(scope.node_origin.fail(problem));
        }
        let (elements, _) = LabelIndex::new(scope.elements.iter().map(|element| element.label));
        let mut element_nodes = vec![u32::MAX; scope.element_nodes.len()];
        let mut solid_rank = Vec::with_capacity(scope.elements.len());
        let mut solid_count = 0;
        for element in &scope.elements {
            solid_rank.push(solid_count);
            solid_count += u32::from(matches!(element.usage, Use::Solid(_)));
            let is_of_use = matches!(element.usage, Use::Solid(_) | Use::Face(_) | Use::Line(_));
            for place in element.nodes.clone() {
                let node = scope.element_nodes[place];
                match nodes.get(node) {
                    Some(index) => element_nodes[place] = index,
                    None if !is_of_use => {}
                    None => return Err(element.origin.fail(Problem::MissingNode { element: element.label, node })),
                }
            }
        }
        Ok(Self { nodes, elements, solid_rank, element_nodes })
    }

    /// The nodes of an element, counted on from those before its scope.
    pub fn nodes_of(&self, element: &Element, offset: u32) -> ElementNodes {
        self.element_nodes[element.nodes.clone()]
            .iter()
            .take(estar_mesh::MOST_NODES)
            .map(|node| node + offset)
            .collect()
    }
}
