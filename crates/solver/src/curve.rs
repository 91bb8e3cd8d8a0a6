//! Functions of time given by points, with their integrals.

/// How a [`Curve`] runs between its points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Straight lines.
    Linear,
    /// Between two points the quintic s³(10 − 15 s + 6 s²): first and second rate are zero at every point.
    Smooth,
    /// Quintics that go through the points without a stop: rate and second rate are continuous, both are zero at the first and
    /// the last point, and no rise turns into a fall between two points. Two points have the curve of [`Interpolation::Smooth`].
    ///
    /// The second rate is zero at every point. The rate is the harmonic mean of the slopes on both sides (Brodlie 1980), zero where
    /// the values turn round or stand still. It is at most twice the smaller slope, and then the quintic is monotone.
    Monotone,
}

/// A function of time through given points; constant before the first and after the last.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    points: Vec<[f64; 2]>,
    interpolation: Interpolation,
    /// Rate at each point of a monotone curve; empty for others.
    rates: Vec<f64>,
}

/// A curve that cannot be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CurveError {
    /// No point at all.
    #[error("the curve has no points")]
    Empty,
    /// A coordinate that is infinite or not a number.
    #[error("point {} of the curve is not finite", index + 1)]
    NotFinite {
        /// Index of the point.
        index: usize,
    },
    /// A time that does not lie after the one before.
    #[error("the times of the curve must increase: point {} has {time:?} s after {previous:?} s", index + 1)]
    NotIncreasing {
        /// Index of the second point of the pair.
        index: usize,
        /// Its time, s.
        time: f64,
        /// The time before, s.
        previous: f64,
    },
}

impl Curve {
    /// The curve through `points`, each `[time in s, value]`.
    ///
    /// # Errors
    /// No points, a coordinate that is not finite, or times that do not increase.
    pub fn new(points: Vec<[f64; 2]>, interpolation: Interpolation) -> Result<Self, CurveError> {
        if points.is_empty() {
            return Err(CurveError::Empty);
        }
        if let Some(index) = points.iter().position(|point| !point.iter().all(|c| c.is_finite())) {
            return Err(CurveError::NotFinite { index });
        }
        if let Some(index) = points.windows(2).position(|pair| pair[1][0] <= pair[0][0]) {
            let (time, previous) = (points[index + 1][0], points[index][0]);
            return Err(CurveError::NotIncreasing { index: index + 1, time, previous });
        }
        let rates = match interpolation {
            Interpolation::Linear | Interpolation::Smooth => Vec::new(),
            Interpolation::Monotone => monotone_rates(&points),
        };
        Ok(Self { points, interpolation, rates })
    }

    /// The curve that has `value` at all times.
    pub fn constant(value: f64) -> Self {
        Self { points: vec![[0.0, value]], interpolation: Interpolation::Linear, rates: Vec::new() }
    }

    /// Times of the points.
    pub fn times(&self) -> Vec<f64> {
        self.points.iter().map(|point| point[0]).collect()
    }

    /// Value at `time`.
    pub fn value(&self, time: f64) -> f64 {
        let next = self.points.partition_point(|point| point[0] <= time);
        if next == 0 {
            return self.points[0][1];
        }
        if next == self.points.len() {
            return self.points[next - 1][1];
        }
        let segment = self.segment(next - 1);
        segment.start + segment.of(&self.shapes(segment.fraction(time)))
    }

    /// Integral of the value from time 0 to `time` ≥ 0.
    pub fn integral(&self, time: f64) -> f64 {
        self.integral_from_start(time) - self.integral_from_start(0.0)
    }

    /// Twofold integral of the value from time 0 to `time` ≥ 0: ∫₀ᵗ∫₀ˢ value dr ds.
    pub fn double_integral(&self, time: f64) -> f64 {
        self.double_integral_from_start(time)
            - self.double_integral_from_start(0.0)
            - time * self.integral_from_start(0.0)
    }

    /// The largest change of the value within a span of time (s), and when that span begins. Of a curve of straight lines it is
    /// exact; of others it is found from spans that begin, end, or have their middle at a point or midway between two.
    pub fn largest_change(&self, span: f64) -> (f64, f64) {
        let times = self.points.iter().map(|point| point[0]);
        let middles = self.points.windows(2).map(|pair| 0.5 * (pair[0][0] + pair[1][0]));
        let beginnings = times.chain(middles).flat_map(|time| [time, time - 0.5 * span, time - span]);
        let change = |time: f64| ((self.value(time + span) - self.value(time)).abs(), time);
        beginnings.map(change).fold((0.0, 0.0), |largest, next| if next.0 > largest.0 { next } else { largest })
    }

    /// ∫ value from the first point's time to `time` (negative before it).
    fn integral_from_start(&self, time: f64) -> f64 {
        let first = self.points[0];
        if time <= first[0] {
            return first[1] * (time - first[0]);
        }
        let mut sum = 0.0;
        for index in 0..self.points.len() - 1 {
            let segment = self.segment(index);
            let fraction = segment.fraction(time).min(1.0);
            sum += segment.length * (segment.start * fraction + segment.of(&self.shape_integrals(fraction)));
            if time <= self.points[index + 1][0] {
                return sum;
            }
        }
        let last = self.points[self.points.len() - 1];
        sum + last[1] * (time - last[0])
    }

    /// ∬ value from the first point's time to `time`.
    fn double_integral_from_start(&self, time: f64) -> f64 {
        let first = self.points[0];
        if time <= first[0] {
            return 0.5 * first[1] * (time - first[0]).powi(2);
        }
        let mut integral = 0.0;
        let mut sum = 0.0;
        for index in 0..self.points.len() - 1 {
            let segment = self.segment(index);
            let Segment { length, start, .. } = segment;
            let fraction = segment.fraction(time).min(1.0);
            let elapsed = length * fraction;
            sum += integral * elapsed
                + 0.5 * start * elapsed * elapsed
                + length * length * segment.of(&self.shape_double_integrals(fraction));
            integral += length * (start * fraction + segment.of(&self.shape_integrals(fraction)));
            if time <= self.points[index + 1][0] {
                return sum;
            }
        }
        let last = self.points[self.points.len() - 1];
        let elapsed = time - last[0];
        sum + integral * elapsed + 0.5 * last[1] * elapsed * elapsed
    }

    /// What the value adds to that of the segment's start at `s` of its length: for a rise of 1, and for a rate of 1 at the start and
    /// at the end.
    fn shapes(&self, s: f64) -> [f64; 3] {
        match self.interpolation {
            Interpolation::Linear => [s, 0.0, 0.0],
            Interpolation::Smooth => [smooth(s), 0.0, 0.0],
            // rates (1 − s)³(1 + 3 s) and s³(4 − 3 s), which rise by 2/5
            Interpolation::Monotone => [
                smooth(s),
                s * (1.0 + s * s * (-2.0 + s * (2.0 - 0.6 * s))) - 0.4 * smooth(s),
                s.powi(4) * (1.0 - 0.6 * s) - 0.4 * smooth(s),
            ],
        }
    }

    /// ∫₀ˢ of [`Curve::shapes`].
    fn shape_integrals(&self, s: f64) -> [f64; 3] {
        let smooth = s.powi(4) * (2.5 + s * (-3.0 + s));
        match self.interpolation {
            Interpolation::Linear => [0.5 * s * s, 0.0, 0.0],
            Interpolation::Smooth => [smooth, 0.0, 0.0],
            Interpolation::Monotone => [
                smooth,
                s * s * (0.5 + s * s * (-0.5 + s * (0.4 - 0.1 * s))) - 0.4 * smooth,
                s.powi(5) * (0.2 - 0.1 * s) - 0.4 * smooth,
            ],
        }
    }

    /// ∬₀ˢ of [`Curve::shapes`].
    fn shape_double_integrals(&self, s: f64) -> [f64; 3] {
        let smooth = s.powi(5) * (0.5 + s * (-0.5 + s / 7.0));
        match self.interpolation {
            Interpolation::Linear => [s.powi(3) / 6.0, 0.0, 0.0],
            Interpolation::Smooth => [smooth, 0.0, 0.0],
            Interpolation::Monotone => [
                smooth,
                s.powi(3) * (1.0 / 6.0 + s * s * (-0.1 + s * (1.0 / 15.0 - s / 70.0))) - 0.4 * smooth,
                s.powi(6) * (1.0 / 30.0 - s / 70.0) - 0.4 * smooth,
            ],
        }
    }

    /// The segment that begins at a point.
    fn segment(&self, index: usize) -> Segment {
        let (start, end) = (self.points[index], self.points[index + 1]);
        let length = end[0] - start[0];
        // a rate times the length of the segment is a rise
        let rise_by_rate = |index: usize| self.rates.get(index).map_or(0.0, |rate| rate * length);
        Segment {
            time: start[0],
            length,
            start: start[1],
            rises: [end[1] - start[1], rise_by_rate(index), rise_by_rate(index + 1)],
        }
    }
}

/// A curve between two of its points.
struct Segment {
    /// When it begins, s.
    time: f64,
    /// How long it lasts, s.
    length: f64,
    /// Value at its beginning.
    start: f64,
    /// Its rise, and what it would rise by with the rate of its beginning and of its end.
    rises: [f64; 3],
}

impl Segment {
    fn fraction(&self, time: f64) -> f64 {
        (time - self.time) / self.length
    }

    /// The sum of the shapes.
    fn of(&self, shapes: &[f64; 3]) -> f64 {
        // of a curve without rates only the first is there
        self.rises[0] * shapes[0] + (self.rises[1] * shapes[1] + self.rises[2] * shapes[2])
    }
}

/// The rise from 0 to 1 at rest at both ends.
fn smooth(s: f64) -> f64 {
    s * s * s * (10.0 + s * (-15.0 + 6.0 * s))
}

/// Rates at the points of a monotone curve.
fn monotone_rates(points: &[[f64; 2]]) -> Vec<f64> {
    let slope = |pair: &[[f64; 2]]| (pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0]);
    let slopes: Vec<f64> = points.windows(2).map(slope).collect();
    let mut rates = vec![0.0; points.len()];
    for (rate, pair) in rates.iter_mut().skip(1).zip(slopes.windows(2)) {
        if pair[0] * pair[1] > 0.0 {
            // 2/(1/a + 1/b)
            *rate = 2.0 * pair[0] * (pair[1] / (pair[0] + pair[1]));
        }
    }
    rates
}

#[cfg(test)]
mod tests {
    use super::*;

    const KINDS: [Interpolation; 3] = [Interpolation::Linear, Interpolation::Smooth, Interpolation::Monotone];

    fn curves() -> [Curve; 3] {
        let points = vec![[0.5, 1.0], [1.0, -2.0], [3.0, 4.0], [3.5, 6.0], [3.7, 6.0]];
        KINDS.map(|kind| Curve::new(points.clone(), kind).unwrap())
    }

    #[test]
    fn curve_passes_its_points_and_is_constant_outside() {
        for curve in curves() {
            for (time, value) in [(0.0, 1.0), (0.5, 1.0), (1.0, -2.0), (3.0, 4.0), (9.0, 6.0)] {
                assert_eq!(curve.value(time), value);
            }
        }
    }

    #[test]
    fn integrals_agree_with_quadrature() {
        let count = 400_000;
        let end = 4.0;
        let step = end / f64::from(count);
        for curve in curves() {
            let (mut integral, mut double) = (0.0, 0.0);
            for i in 0..count {
                let value = curve.value((f64::from(i) + 0.5) * step);
                double += step * (integral + 0.5 * step * value);
                integral += step * value;
            }
            assert!((curve.integral(end) - integral).abs() < 1e-9, "{} {integral}", curve.integral(end));
            assert!((curve.double_integral(end) - double).abs() < 1e-9, "{} {double}", curve.double_integral(end));
        }
    }

    #[test]
    fn smooth_curve_starts_and_ends_at_rest() {
        let curve = Curve::new(vec![[0.0, 0.0], [1.0, 1.0]], Interpolation::Smooth).unwrap();
        assert!(curve.value(1e-3) < 1.1e-8);
        assert!(1.0 - curve.value(1.0 - 1e-3) < 1.1e-8);
        assert_eq!(curve.value(0.5), 0.5);
    }

    #[test]
    fn monotone_curve_of_straight_points_stops_only_at_its_ends() {
        let points: Vec<[f64; 2]> = (0..=50).map(|i| [0.02 * f64::from(i), 0.06 * f64::from(i)]).collect();
        let curve = Curve::new(points, Interpolation::Monotone).unwrap();
        let rate = |time: f64| (curve.value(time + 1e-6) - curve.value(time - 1e-6)) / 2e-6;
        assert!(rate(0.0).abs() < 1e-3 && rate(1.0).abs() < 1e-3);
        for time in (10..490).map(|i| 0.02 + 0.002 * f64::from(i - 10)) {
            assert!((rate(time) - 3.0).abs() < 1e-6, "{time}: {}", rate(time));
        }
    }

    #[test]
    fn monotone_curve_of_two_points_is_the_smooth_one() {
        let of = |kind| Curve::new(vec![[1.0, 2.0], [3.0, -1.0]], kind).unwrap();
        for time in (0..40).map(|i| 0.1 * f64::from(i)) {
            assert_eq!(of(Interpolation::Monotone).value(time), of(Interpolation::Smooth).value(time));
        }
    }

    #[test]
    fn monotone_curve_never_turns_between_points_and_has_a_continuous_rate() {
        let times = [0.0, 0.1, 0.5, 0.6, 2.0, 2.1, 2.2, 3.0];
        let values = [0.0, 1.0, 1.01, 5.0, 5.0, 4.0, 3.99, -7.0];
        let points: Vec<[f64; 2]> = times.into_iter().zip(values).map(|(time, value)| [time, value]).collect();
        let curve = Curve::new(points.clone(), Interpolation::Monotone).unwrap();
        for pair in points.windows(2) {
            let (length, rise) = (pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]);
            let value = |i: i32| curve.value(pair[0][0] + length * f64::from(i) / 200.0);
            for i in 0..200 {
                assert!((value(i + 1) - value(i)) * rise.signum() >= -1e-12, "{pair:?} {i}");
            }
        }
        let slope = |from: f64, to: f64| (curve.value(to) - curve.value(from)) / (to - from);
        for time in times {
            let (before, after) = (slope(time - 1e-7, time), slope(time, time + 1e-7));
            assert!((before - after).abs() < 1e-3, "{time}: {before} {after}");
        }
    }

    #[test]
    fn largest_change_finds_jumps_of_any_kind() {
        for kind in KINDS {
            let curve = Curve::new(vec![[0.0, 0.0], [1.0, 0.5], [1.0 + 1e-9, 2.0], [3.0, 2.0]], kind).unwrap();
            let (change, time) = curve.largest_change(1e-3);
            assert!(change >= 1.5 && (0.998..1.001).contains(&time), "{kind:?}: {change} {time}");
            let steady = Curve::new(vec![[0.0, 0.0], [1.0, 0.5]], kind).unwrap().largest_change(1e-3).0;
            let peak = if kind == Interpolation::Linear { 1.0 } else { 1.875 };
            assert!((steady / 0.5e-3 - peak).abs() < 1e-4, "{kind:?}: {steady}");
        }
    }

    #[test]
    fn impossible_curves_are_refused() {
        let linear = |points: &[[f64; 2]]| Curve::new(points.to_vec(), Interpolation::Linear).unwrap_err();
        assert_eq!(linear(&[]), CurveError::Empty);
        assert_eq!(linear(&[[0.0, f64::NAN]]), CurveError::NotFinite { index: 0 });
        let error = linear(&[[0.0, 0.0], [1.0, 1.0], [1.0, 2.0]]);
        assert_eq!(error, CurveError::NotIncreasing { index: 2, time: 1.0, previous: 1.0 });
    }
}
