//! The memory that a run of a problem takes.

use crate::problem::Problem;
use estar_deck::memory;
use estar_solver::memory_needed;

/// A frame on its way, with its grid: bytes of numbers and of what they are packed into, per node and per element.
const FRAME_PER_NODE: usize = 56;
const FRAME_PER_ELEMENT: usize = 100;

/// Bytes that a run of a problem takes beside those that it has taken already, about.
pub fn needed(problem: &Problem) -> u64 {
    let mesh = &problem.mesh;
    // the thread that writes the frames has a mesh of its own
    let frames = mesh.node_count() * (FRAME_PER_NODE + 32) + mesh.element_count() * (FRAME_PER_ELEMENT + 40);
    (memory_needed(mesh, &problem.model) + frames) as u64
}

/// Why a problem cannot be run, if it does not fit.
pub fn shortage(problem: &Problem) -> Option<String> {
    memory::shortage("this run", needed(problem))
}
