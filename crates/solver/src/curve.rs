//! Functions of time given by points, with their integrals.

/// How a [`Curve`] runs between its points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Straight lines.
    Linear,
    /// Between two points the quintic s³(10 − 15 s + 6 s²): first and second rate are zero at every point.
    Smooth,
}

/// A function of time through given points; constant before the first and after the last.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    points: Vec<[f64; 2]>,
    interpolation: Interpolation,
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
        Ok(Self { points, interpolation })
    }

    /// The curve that has `value` at all times.
    pub fn constant(value: f64) -> Self {
        Self { points: vec![[0.0, value]], interpolation: Interpolation::Linear }
    }

    /// Times of the points.
    pub fn times(&self) -> Vec<f64> {
        self.points.iter().map(|point| point[0]).collect()
    }

    /// Value at `time`.
    pub fn value(&self, time: f64) -> f64 {
        match self.segment(time) {
            Place::Before => self.points[0][1],
            Place::After => self.points[self.points.len() - 1][1],
            Place::Within { start, end, fraction } => start[1] + (end[1] - start[1]) * self.shape(fraction),
        }
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

    /// ∫ value from the first point's time to `time` (negative before it).
    fn integral_from_start(&self, time: f64) -> f64 {
        let first = self.points[0];
        if time <= first[0] {
            return first[1] * (time - first[0]);
        }
        let mut sum = 0.0;
        for pair in self.points.windows(2) {
            let (start, end) = (pair[0], pair[1]);
            let length = end[0] - start[0];
            let fraction = ((time - start[0]) / length).min(1.0);
            sum += length * (start[1] * fraction + (end[1] - start[1]) * self.shape_integral(fraction));
            if time <= end[0] {
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
        for pair in self.points.windows(2) {
            let (start, end) = (pair[0], pair[1]);
            let length = end[0] - start[0];
            let fraction = ((time - start[0]) / length).min(1.0);
            let rise = end[1] - start[1];
            let elapsed = length * fraction;
            sum += integral * elapsed
                + 0.5 * start[1] * elapsed * elapsed
                + rise * length * length * self.shape_double_integral(fraction);
            integral += length * (start[1] * fraction + rise * self.shape_integral(fraction));
            if time <= end[0] {
                return sum;
            }
        }
        let last = self.points[self.points.len() - 1];
        let elapsed = time - last[0];
        sum + integral * elapsed + 0.5 * last[1] * elapsed * elapsed
    }

    /// The rise from 0 to 1 over a segment, at `s` of its length.
    fn shape(&self, s: f64) -> f64 {
        match self.interpolation {
            Interpolation::Linear => s,
            Interpolation::Smooth => s * s * s * (10.0 + s * (-15.0 + 6.0 * s)),
        }
    }

    /// ∫₀ˢ shape.
    fn shape_integral(&self, s: f64) -> f64 {
        match self.interpolation {
            Interpolation::Linear => 0.5 * s * s,
            Interpolation::Smooth => s.powi(4) * (2.5 + s * (-3.0 + s)),
        }
    }

    /// ∬₀ˢ shape.
    fn shape_double_integral(&self, s: f64) -> f64 {
        match self.interpolation {
            Interpolation::Linear => s.powi(3) / 6.0,
            Interpolation::Smooth => s.powi(5) * (0.5 + s * (-0.5 + s / 7.0)),
        }
    }

    fn segment(&self, time: f64) -> Place {
        let next = self.points.partition_point(|point| point[0] <= time);
        if next == 0 {
            return Place::Before;
        }
        if next == self.points.len() {
            return Place::After;
        }
        let (start, end) = (self.points[next - 1], self.points[next]);
        Place::Within { start, end, fraction: (time - start[0]) / (end[0] - start[0]) }
    }
}

/// Where a time lies among the points of a curve.
enum Place {
    Before,
    Within { start: [f64; 2], end: [f64; 2], fraction: f64 },
    After,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curves() -> [Curve; 2] {
        let points = vec![[0.5, 1.0], [1.0, -2.0], [3.0, 4.0]];
        [Interpolation::Linear, Interpolation::Smooth].map(|kind| Curve::new(points.clone(), kind).unwrap())
    }

    #[test]
    fn curve_passes_its_points_and_is_constant_outside() {
        for curve in curves() {
            for (time, value) in [(0.0, 1.0), (0.5, 1.0), (1.0, -2.0), (3.0, 4.0), (9.0, 4.0)] {
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
    fn impossible_curves_are_refused() {
        let linear = |points: &[[f64; 2]]| Curve::new(points.to_vec(), Interpolation::Linear).unwrap_err();
        assert_eq!(linear(&[]), CurveError::Empty);
        assert_eq!(linear(&[[0.0, f64::NAN]]), CurveError::NotFinite { index: 0 });
        let error = linear(&[[0.0, 0.0], [1.0, 1.0], [1.0, 2.0]]);
        assert_eq!(error, CurveError::NotIncreasing { index: 2, time: 1.0, previous: 1.0 });
    }
}
