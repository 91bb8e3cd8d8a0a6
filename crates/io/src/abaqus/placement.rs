//! Where nodes are: systems of coordinates in which they are given, and instances of parts that are moved.

/// Turns and moves positions: x ↦ origin + Σ x_i axis_i.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Placement {
    pub origin: [f64; 3],
    pub axes: [[f64; 3]; 3],
}

impl Default for Placement {
    fn default() -> Self {
        Self { origin: [0.0; 3], axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] }
    }
}

impl Placement {
    pub fn apply(&self, x: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| self.origin[i] + (0..3).map(|k| x[k] * self.axes[k][i]).sum::<f64>())
    }

    /// A translation, then a turn by an angle (degrees) about the axis from one point to another; none if the points are one.
    pub fn moved(translation: [f64; 3], turn: Option<([f64; 3], [f64; 3], f64)>) -> Option<Self> {
        let Some((from, to, angle)) = turn else { return Some(Self { origin: translation, ..Self::default() }) };
        let axis = unit(minus(to, from))?;
        let (sin, cos) = sin_cos_of_degrees(angle);
        // R x = cos x + sin a×x + (1 − cos) (a·x) a
        let turned = |x: [f64; 3]| {
            let (across, along) = (cross(axis, x), dot(axis, x));
            std::array::from_fn(|i| cos * x[i] + sin * across[i] + (1.0 - cos) * along * axis[i])
        };
        let moved = turned(minus(translation, from));
        let origin = std::array::from_fn(|i| from[i] + moved[i]);
        Some(Self { origin, axes: Self::default().axes.map(turned) })
    }

    /// The system with a point on its first axis and one in the plane of its first two; none if they define none. Without the
    /// last one the third axis stays that of the whole, and the first is projected on its plane.
    pub fn of_points(origin: [f64; 3], on_first: Option<[f64; 3]>, in_plane: Option<[f64; 3]>) -> Option<Self> {
        let Some(on_first) = on_first else { return Some(Self { origin, ..Self::default() }) };
        let mut first = minus(on_first, origin);
        let third = match in_plane {
            Some(in_plane) => unit(cross(first, minus(in_plane, origin)))?,
            None => {
                first[2] = 0.0;
                [0.0, 0.0, 1.0]
            }
        };
        let first = unit(first)?;
        Some(Self { origin, axes: [first, cross(third, first), third] })
    }
}

/// What the three coordinates of a node are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Coordinates {
    Rectangular,
    /// Radius, angle about the third axis (degrees), height.
    Cylindrical,
    /// Radius, longitude, latitude (degrees).
    Spherical,
}

impl Coordinates {
    pub fn rectangular(self, [a, b, c]: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Rectangular => [a, b, c],
            Self::Cylindrical => {
                let (sin, cos) = sin_cos_of_degrees(b);
                [a * cos, a * sin, c]
            }
            Self::Spherical => {
                let ((sin, cos), (sin_latitude, cos_latitude)) = (sin_cos_of_degrees(b), sin_cos_of_degrees(c));
                [a * cos * cos_latitude, a * sin * cos_latitude, a * sin_latitude]
            }
        }
    }
}

/// Exact where the angle is a multiple of 90°, so that a quarter turn leaves no 1e-17.
fn sin_cos_of_degrees(angle: f64) -> (f64, f64) {
    let turned = angle.rem_euclid(360.0);
    match turned {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        _ => turned.to_radians().sin_cos(),
    }
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(a: [f64; 3]) -> Option<[f64; 3]> {
    let length = dot(a, a).sqrt();
    (length > 0.0 && length.is_finite()).then(|| a.map(|x| x / length))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: [f64; 3], b: [f64; 3]) {
        assert!(minus(a, b).iter().all(|d| d.abs() < 1e-12), "{a:?} {b:?}");
    }

    #[test]
    fn an_instance_is_moved_first_and_turned_then() {
        let turn = ([1.0, 0.0, 0.0], [1.0, 0.0, 2.0], 90.0);
        let placement = Placement::moved([3.0, 0.0, 0.0], Some(turn)).unwrap();
        // (0, 1, 5) moves to (3, 1, 5), which is (2, 1) from the axis and turns to (-1, 2)
        near(placement.apply([0.0, 1.0, 5.0]), [0.0, 2.0, 5.0]);
        assert_eq!(Placement::moved([0.0; 3], Some(([1.0; 3], [1.0; 3], 30.0))), None);
    }

    #[test]
    fn a_system_is_given_by_one_two_or_three_points() {
        let of = |b, c| Placement::of_points([1.0, 2.0, 3.0], b, c);
        near(of(None, None).unwrap().apply([1.0, 0.0, 0.0]), [2.0, 2.0, 3.0]);
        // the first axis is projected: (0, 5, 7) is as good as (0, 1, 0)
        near(of(Some([1.0, 7.0, 10.0]), None).unwrap().apply([1.0, 0.0, 2.0]), [1.0, 3.0, 5.0]);
        let system = of(Some([1.0, 2.0, 9.0]), Some([5.0, 2.0, 20.0])).unwrap();
        near(system.apply([1.0, 2.0, 3.0]), [3.0, 5.0, 4.0]);
        assert_eq!(of(Some([1.0, 2.0, 9.0]), Some([1.0, 2.0, 20.0])), None);
    }

    #[test]
    fn angles_are_in_degrees() {
        near(Coordinates::Cylindrical.rectangular([2.0, 30.0, 5.0]), [3.0_f64.sqrt(), 1.0, 5.0]);
        near(Coordinates::Spherical.rectangular([2.0, 90.0, 30.0]), [0.0, 3.0_f64.sqrt(), 1.0]);
    }
}
