//! Blocks of elements: what a simulation asks of one, and how one is made.

mod averages;
mod averages_task;
mod deletion;
mod element_block;
mod frequencies;
mod means;
mod patch_kernel;
mod report;
mod solid;
mod tangents;

pub(crate) use averages::NodalAverages;
pub use element_block::ElementMeans;
pub(crate) use element_block::{Behaviour, Block, ElementBlock, StepLimits, corner_nodes};
pub(crate) use report::{BlockReport, Extreme};

use crate::model::Part;
use element_block::Elements;
use estar_element::element::{Element, ElementVisitor};
use estar_mesh::Mesh;
use estar_tensor::{LaneLevel, Real, WithLanes, dispatch};
use solid::SolidBlock;

/// The block of a part. `corner_mass` is the smallest corner mass of each of its elements.
pub(crate) fn block(
    part: Part,
    mesh: &Mesh,
    corner_mass: Vec<f64>,
    behaviour: Behaviour,
    level: LaneLevel,
) -> Box<dyn ElementBlock> {
    let Part { elements: members, material, element: formulation } = part;
    let elements = Elements { members, formulation, material, mesh, corner_mass, behaviour };
    formulation.visit(BlockOf { elements, level })
}

struct BlockOf<'a> {
    elements: Elements<'a>,
    level: LaneLevel,
}

impl ElementVisitor for BlockOf<'_> {
    type Output = Box<dyn ElementBlock>;

    fn visit<const NODES: usize, E: Element<NODES>>(self, element: E) -> Box<dyn ElementBlock> {
        let Self { elements, level } = self;
        dispatch(level, NewBlock::<_, NODES> { element, elements })
    }
}

struct NewBlock<'a, E, const NODES: usize> {
    element: E,
    elements: Elements<'a>,
}

impl<E: Element<NODES>, const NODES: usize> WithLanes for NewBlock<'_, E, NODES> {
    type Output = Box<dyn ElementBlock>;

    fn with_lanes<R: Real>(self) -> Box<dyn ElementBlock> {
        Box::new(SolidBlock::<E, R, NODES>::new(self.element, self.elements))
    }
}
