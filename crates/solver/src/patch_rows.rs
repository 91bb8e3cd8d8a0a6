//! What the elements of a patch read of its nodes, side by side: each node of a patch comes from memory once a sweep, whatever the
//! number of its elements, and is then found in the nearest caches by its place in the patch.

use estar_element::element::ElementMotion;
use estar_tensor::{Real, Vector3, prefetch};
use std::cell::RefCell;

/// Where the nodes are and how they move; each a vector per node.
#[derive(Clone, Copy)]
pub(crate) struct NodalMotion<'a> {
    /// X, m.
    pub reference: &'a [[f64; 3]],
    /// u_{n+1}, m.
    pub displacement: &'a [[f64; 3]],
    /// v_{n+½}, m/s.
    pub velocity: &'a [[f64; 3]],
}

/// Nodes are fetched this many nodes before their turn.
const NODES_AHEAD: usize = 16;

thread_local! {
    // kept, so that no memory is asked for once the thread has seen a patch of the size
    static ROWS: RefCell<Vec<[f64; 4]>> = const { RefCell::new(Vec::new()) };
}

/// `FIELDS` rows of three numbers for each node of a patch, in the order of its nodes: X, x_{n+1}, v_{n+½}, and what else there is.
#[derive(Clone, Copy)]
pub(crate) struct PatchRows<'a, const FIELDS: usize>(&'a [[f64; 4]]);

impl PatchRows<'_, 3> {
    /// Hands `work` the rows of the motion of the nodes.
    pub fn of_motion<T>(nodes: &[u32], motion: NodalMotion<'_>, work: impl FnOnce(PatchRows<'_, 3>) -> T) -> T {
        PatchRows::with(nodes, [motion.reference, motion.displacement, motion.velocity], work)
    }
}

impl PatchRows<'_, 4> {
    /// Hands `work` the rows of the motion of the nodes and of another field.
    pub fn of_motion_and<T>(
        nodes: &[u32],
        motion: NodalMotion<'_>,
        other: &[[f64; 3]],
        work: impl FnOnce(PatchRows<'_, 4>) -> T,
    ) -> T {
        PatchRows::with(nodes, [motion.reference, motion.displacement, motion.velocity, other], work)
    }
}

impl<const FIELDS: usize> PatchRows<'_, FIELDS> {
    /// Rows of the nodes' vectors in the fields, of which the first two are X and u.
    fn with<T>(nodes: &[u32], fields: [&[[f64; 3]]; FIELDS], work: impl FnOnce(PatchRows<'_, FIELDS>) -> T) -> T {
        // taken and given back: `work` may come to another patch on this thread
        let mut all = ROWS.take();
        let count = nodes.len() * FIELDS;
        if all.len() < count {
            all.resize(count, [0.0; 4]);
        }
        let rows = &mut all[..count];
        for (place, (&node, rows)) in nodes.iter().zip(rows.chunks_exact_mut(FIELDS)).enumerate() {
            if let Some(&ahead) = nodes.get(place + NODES_AHEAD) {
                for field in fields {
                    prefetch(&field[ahead as usize]);
                }
            }
            for (row, field) in rows.iter_mut().zip(fields) {
                let [x, y, z] = field[node as usize];
                *row = [x, y, z, 0.0];
            }
            rows[1] = std::array::from_fn(|component| rows[0][component] + rows[1][component]);
        }
        let result = work(PatchRows(rows));
        ROWS.set(all);
        result
    }

    /// The motion of a pack whose corners have these places in the patch; the rows of each corner go to `visit` besides.
    #[inline(always)]
    pub fn motion<R: Real, const NODES: usize>(
        &self,
        corners: &[u16],
        motion: &mut ElementMotion<R, NODES>,
        mut visit: impl FnMut(usize, &[[R; 3]; FIELDS]),
    ) {
        for (corner, places) in corners.chunks_exact(R::LANES).enumerate().take(NODES) {
            let rows: [[R; 3]; FIELDS] = R::gather(self.0, places);
            motion.reference[corner] = Vector3(rows[0]);
            motion.position[corner] = Vector3(rows[1]);
            motion.velocity[corner] = Vector3(rows[2]);
            visit(corner, &rows);
        }
    }
}
