//! The elements of a mesh, of any mix of shapes, in one list of nodes.

use rayon::prelude::*;

use crate::{Face, Shape};

/// Elements by shape and nodes.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Elements {
    shapes: Vec<Shape>,
    /// Where the nodes of each element begin.
    starts: Vec<usize>,
    nodes: Vec<u32>,
}

impl Elements {
    /// None yet, with room for some.
    pub fn with_capacity(shape: Shape, count: usize) -> Self {
        let mut elements = Self::default();
        elements.reserve(shape, count);
        elements
    }

    /// Makes room for more.
    pub fn reserve(&mut self, shape: Shape, count: usize) {
        self.shapes.reserve(count);
        self.starts.reserve(count);
        self.nodes.reserve(count * shape.node_count());
    }

    /// Adds an element.
    ///
    /// # Panics
    /// If the shape has another number of nodes.
    pub fn push(&mut self, shape: Shape, nodes: &[u32]) {
        assert_eq!(nodes.len(), shape.node_count(), "nodes of a {shape}");
        self.shapes.push(shape);
        self.starts.push(self.nodes.len());
        self.nodes.extend_from_slice(nodes);
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.shapes.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.shapes.is_empty()
    }

    /// The shape of an element.
    pub fn shape(&self, element: usize) -> Shape {
        self.shapes[element]
    }

    /// The shapes of all.
    pub fn shapes(&self) -> &[Shape] {
        &self.shapes
    }

    /// Where the nodes of an element begin in [`Elements::all_nodes`].
    pub fn start(&self, element: usize) -> usize {
        self.starts[element]
    }

    /// The nodes of an element.
    pub fn nodes(&self, element: usize) -> &[u32] {
        let start = self.starts[element];
        &self.nodes[start..start + self.shapes[element].node_count()]
    }

    /// The nodes of the first element, then those of the second, and so on.
    pub fn all_nodes(&self) -> &[u32] {
        &self.nodes
    }

    /// The nodes of each element.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[u32]> + Clone {
        (0..self.len()).map(|element| self.nodes(element))
    }

    /// The nodes of each element, for several threads.
    pub fn par_iter(&self) -> impl IndexedParallelIterator<Item = &[u32]> {
        (0..self.len()).into_par_iter().map(|element| self.nodes(element))
    }

    /// The faces of an element, each with its normal outwards.
    pub fn faces(&self, element: usize) -> impl Iterator<Item = Face> {
        let nodes = self.nodes(element);
        let face = move |places: &&[usize]| {
            let mut of_face = [0; 6];
            for (node, &place) in of_face.iter_mut().zip(*places) {
                *node = nodes[place];
            }
            Face::new(&of_face[..places.len()])
        };
        self.shapes[element].faces().iter().filter_map(face)
    }

    /// How many there are of each shape that there is, in the order of [`Shape::ALL`].
    pub fn counts(&self) -> impl Iterator<Item = (Shape, usize)> {
        let mut counts = Shape::ALL.map(|shape| (shape, 0));
        for &shape in &self.shapes {
            counts[shape as usize].1 += 1;
        }
        counts.into_iter().filter(|(_, count)| *count > 0)
    }

    /// The same elements in another order, with other nodes in the place of theirs.
    pub(crate) fn reordered(&self, old_elements: &[u32], node: impl Fn(u32) -> u32) -> Self {
        let mut new = Self {
            shapes: Vec::with_capacity(self.shapes.len()),
            starts: Vec::with_capacity(self.starts.len()),
            nodes: Vec::with_capacity(self.nodes.len()),
        };
        for &old in old_elements {
            new.shapes.push(self.shapes[old as usize]);
            new.starts.push(new.nodes.len());
            new.nodes.extend(self.nodes(old as usize).iter().map(|&old| node(old)));
        }
        new
    }

    /// Bytes that the elements take.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.shapes) + size_of_val(&*self.starts) + size_of_val(&*self.nodes)
    }
}

/// Hexes by their corners.
impl From<Vec<[u32; 8]>> for Elements {
    fn from(hexes: Vec<[u32; 8]>) -> Self {
        Self {
            shapes: vec![Shape::Hex8; hexes.len()],
            starts: (0..hexes.len()).map(|hex| 8 * hex).collect(),
            nodes: hexes.into_flattened(),
        }
    }
}
