//! Sizes that grow geometrically from one end to the other.

/// Positions 0 to `length` of the ends of `cell_count` cells; the last cell is `ratio` times as long as the first.
pub(super) fn graded_levels(length: f64, cell_count: u32, ratio: f64) -> Vec<f64> {
    let growth = if cell_count > 1 { ratio.powf(1.0 / f64::from(cell_count - 1)) } else { 1.0 };
    let mut levels = Vec::with_capacity(cell_count as usize + 1);
    let (mut level, mut size) = (0.0, 1.0);
    for _ in 0..=cell_count {
        levels.push(level);
        level += size;
        size *= growth;
    }
    let last = levels[cell_count as usize];
    for level in &mut levels {
        // k/n · L rather than k · (L/n): the last one is the length itself, bit for bit.
        *level = *level / last * length;
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_cell_is_the_ratio_times_the_first() {
        let levels = graded_levels(7.0, 9, 4.0);
        assert_eq!((levels[0], levels[9]), (0.0, 7.0));
        assert!(((levels[9] - levels[8]) / (levels[1] - levels[0]) - 4.0).abs() < 1e-12);
    }

    #[test]
    fn ratio_one_is_uniform_and_one_cell_needs_no_ratio() {
        assert_eq!(graded_levels(4.0, 4, 1.0), [0.0, 1.0, 2.0, 3.0, 4.0]);
        assert_eq!(graded_levels(4.0, 1, 9.0), [0.0, 4.0]);
    }
}
