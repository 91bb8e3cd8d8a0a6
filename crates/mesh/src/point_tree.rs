//! Points sorted so that those in a box are found fast: the k-d tree of J. L. Bentley, "Multidimensional binary search trees used
//! for associative searching", Commun. ACM 18 (1975) 509-517, without any pointers.

use std::ops::ControlFlow;

use rayon::prelude::*;

/// Points with the indices that they are known by. Any coordinates will do: many equal ones, huge ones.
#[derive(Debug)]
pub struct PointTree {
    /// In each range of more than [`LEAF`] points the middle one splits the others along its axis.
    points: Vec<([f64; 3], u32)>,
    /// The axis along which the point of the same place splits its range.
    axes: Vec<u8>,
}

/// A range of so many points is not split any more.
const LEAF: usize = 8;
/// A range of so many points is sorted by several threads.
const SHARED: usize = 4096;

impl PointTree {
    /// The tree of these points.
    pub fn new(mut points: Vec<([f64; 3], u32)>) -> Self {
        let mut axes = vec![0; points.len()];
        arrange(&mut points, &mut axes);
        Self { points, axes }
    }

    /// Calls `visit` with the points that are in the box or on its sides, in no particular order, until it breaks off.
    pub fn in_box(&self, low: &[f64; 3], high: &[f64; 3], mut visit: impl FnMut(u32, &[f64; 3]) -> ControlFlow<()>) {
        let mut look = |&(position, index): &([f64; 3], u32)| {
            let is_inside = (0..3).all(|axis| low[axis] <= position[axis] && position[axis] <= high[axis]);
            if is_inside { visit(index, &position) } else { ControlFlow::Continue(()) }
        };
        // halving 2³² points leaves one after 32 times, and each time one half waits
        let mut waiting = [(0, 0); 33];
        let mut count = 1;
        waiting[0] = (0, self.points.len());
        while count > 0 {
            count -= 1;
            let (from, to) = waiting[count];
            if to - from <= LEAF {
                if self.points[from..to].iter().try_for_each(&mut look).is_break() {
                    return;
                }
                continue;
            }
            let middle = from + (to - from) / 2;
            let axis = self.axes[middle] as usize;
            let split = self.points[middle].0[axis];
            if look(&self.points[middle]).is_break() {
                return;
            }
            for (is_met, half) in [(split <= high[axis], (middle + 1, to)), (low[axis] <= split, (from, middle))] {
                if is_met {
                    waiting[count] = half;
                    count += 1;
                }
            }
        }
    }
}

fn arrange(points: &mut [([f64; 3], u32)], axes: &mut [u8]) {
    if points.len() <= LEAF {
        return;
    }
    let (middle, axis) = (points.len() / 2, widest_axis(points));
    points.select_nth_unstable_by(middle, |a, b| a.0[axis].total_cmp(&b.0[axis]));
    axes[middle] = axis as u8;
    let is_shared = points.len() >= SHARED;
    let (lower, rest) = points.split_at_mut(middle);
    let (lower_axes, rest_axes) = axes.split_at_mut(middle);
    let (upper, upper_axes) = (&mut rest[1..], &mut rest_axes[1..]);
    if is_shared {
        rayon::join(|| arrange(lower, lower_axes), || arrange(upper, upper_axes));
    } else {
        arrange(lower, lower_axes);
        arrange(upper, upper_axes);
    }
}

fn widest_axis(points: &[([f64; 3], u32)]) -> usize {
    let empty = || [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    let both = |a: [[f64; 3]; 2], b: [[f64; 3]; 2]| {
        [std::array::from_fn(|axis| a[0][axis].min(b[0][axis])), std::array::from_fn(|axis| a[1][axis].max(b[1][axis]))]
    };
    let chunks =
        points.par_chunks(SHARED).map(|chunk| chunk.iter().fold(empty(), |all, point| both(all, [point.0; 2])));
    let [low, high] = if points.len() < 4 * SHARED {
        points.iter().fold(empty(), |all, point| both(all, [point.0; 2]))
    } else {
        chunks.reduce(empty, both)
    };
    let width = |axis: usize| high[axis] - low[axis];
    (1..3).fold(0, |widest, axis| if width(axis) > width(widest) { axis } else { widest })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers without order, the same every time.
    fn scattered(count: usize) -> Vec<([f64; 3], u32)> {
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            // few values, so that many are equal
            f64::from((state >> 33) as u32 % 40) - 20.0
        };
        (0..count as u32).map(|index| ([next(), next(), next()], index)).collect()
    }

    fn found(tree: &PointTree, low: [f64; 3], high: [f64; 3]) -> Vec<u32> {
        let mut found = Vec::new();
        tree.in_box(&low, &high, |index, _| {
            found.push(index);
            ControlFlow::Continue(())
        });
        found.sort_unstable();
        found
    }

    #[test]
    fn a_box_has_the_points_that_a_look_at_each_finds() {
        for count in [0, 1, 7, 9, 1000, 20_000] {
            let points = scattered(count);
            let tree = PointTree::new(points.clone());
            for (low, high) in [([-3.0, 0.0, 2.0], [4.0, 9.0, 2.0]), ([-99.0; 3], [99.0; 3]), ([5.0; 3], [4.0; 3])] {
                let inside =
                    points.iter().filter(|(x, _)| (0..3).all(|axis| low[axis] <= x[axis] && x[axis] <= high[axis]));
                assert_eq!(found(&tree, low, high), inside.map(|(_, index)| *index).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn equal_and_huge_coordinates_end() {
        let huge = f64::MAX;
        let mut points: Vec<_> = (0..20_000).map(|index| ([1.0; 3], index)).collect();
        points.extend((20_000..20_100).map(|index| ([if index % 2 == 0 { huge } else { -huge }; 3], index)));
        let tree = PointTree::new(points);
        assert_eq!(found(&tree, [0.0; 3], [2.0; 3]).len(), 20_000);
        assert_eq!(found(&tree, [huge; 3], [huge; 3]).len(), 50);
    }

    #[test]
    fn a_search_can_be_broken_off() {
        let tree = PointTree::new((0..100).map(|index| ([0.0; 3], index)).collect());
        let mut count = 0;
        tree.in_box(&[0.0; 3], &[0.0; 3], |_, _| {
            count += 1;
            if count < 5 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        assert_eq!(count, 5);
    }
}
