//! Sums over the whole body, up a binary tree of fixed shape: neither threads nor how the leaves are shared out show in the bits.

/// What `count` leaves give together: the leaves of the left half, as many as the greatest power of two below their count, and
/// those of the right half, each by the same rule. `none` of no leaf.
pub(crate) fn up_the_tree<T>(count: usize, none: T, leaf: &impl Fn(usize) -> T, join: &impl Fn(T, T) -> T) -> T {
    if count == 0 { none } else { subtree(0, count, leaf, join) }
}

fn subtree<T>(first: usize, count: usize, leaf: &impl Fn(usize) -> T, join: &impl Fn(T, T) -> T) -> T {
    if count == 1 {
        return leaf(first);
    }
    let half = count.next_power_of_two() / 2;
    join(subtree(first, half, leaf, join), subtree(first + half, count - half, leaf, join))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// So that a rank that holds such a subtree can sum it alone.
    #[test]
    fn a_sum_is_that_of_its_halves_at_the_power_of_two() {
        let leaf = |index: usize| 1.0 / (1.0 + index as f64);
        let join = |a: f64, b: f64| a + b;
        for count in 2..100_usize {
            let half = count.next_power_of_two() / 2;
            let left = up_the_tree(half, 0.0, &leaf, &join);
            let right = up_the_tree(count - half, 0.0, &|index| leaf(half + index), &join);
            assert_eq!(up_the_tree(count, 0.0, &leaf, &join).to_bits(), (left + right).to_bits());
        }
        assert_eq!(up_the_tree(0, 7.0, &leaf, &join), 7.0);
    }
}
