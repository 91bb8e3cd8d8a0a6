//! External loads as nodal forces: gravity, pressure that follows its surface, traction on the reference area.

use crate::curve::Curve;
use crate::energy::CentredWork;
use crate::model::LoadKind;
use estar_mesh::Face;

/// Coordinate of the Gauss points of a face, 1/√3.
const GAUSS: f64 = 0.577_350_269_189_625_8;
/// (ξ, η) of the corners of a face.
const FACE_SIGNS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

/// A load on its nodes.
#[derive(Clone, Debug)]
pub(crate) struct NodalLoad {
    nodes: Vec<u32>,
    forces: Vec<[f64; 3]>,
    rule: Rule,
    /// Work on the body.
    pub work: CentredWork,
}

/// How the forces follow from time and place.
#[derive(Clone, Debug)]
enum Rule {
    Constant,
    /// `faces` hold positions in `NodalLoad::nodes`.
    Pressure {
        faces: Vec<Face>,
        curve: Curve,
    },
    /// `areas` belong to the nodes: ∫ N_a dA on the reference configuration, m².
    Traction {
        areas: Vec<f64>,
        direction: [f64; 3],
        curve: Curve,
    },
}

impl NodalLoad {
    /// The load of a model on a body with the given nodal masses.
    pub fn new(kind: &LoadKind, reference: &[[f64; 3]], mass: &[f64]) -> Self {
        match kind {
            LoadKind::Gravity { acceleration } => Self {
                nodes: (0..).take(mass.len()).collect(),
                // f_a = m_a g
                forces: mass.iter().map(|mass| acceleration.map(|g| mass * g)).collect(),
                rule: Rule::Constant,
                work: CentredWork::default(),
            },
            LoadKind::Pressure { faces, curve } => {
                let (nodes, faces) = local_faces(faces);
                let forces = vec![[0.0; 3]; nodes.len()];
                Self {
                    nodes,
                    forces,
                    rule: Rule::Pressure { faces, curve: curve.clone() },
                    work: CentredWork::default(),
                }
            }
            LoadKind::Traction { faces, direction, curve } => {
                let (nodes, faces) = local_faces(faces);
                let mut areas = vec![0.0; nodes.len()];
                for face in &faces {
                    let place = |node: u32| reference[nodes[node as usize] as usize];
                    area_vectors(face, place, norm, |node, area| areas[node as usize] += area);
                }
                let forces = vec![[0.0; 3]; nodes.len()];
                let rule = Rule::Traction { areas, direction: *direction, curve: curve.clone() };
                Self { nodes, forces, rule, work: CentredWork::default() }
            }
        }
    }

    /// Sets the forces of `time` in the current configuration and adds them to `external_force`.
    pub fn apply(
        &mut self,
        time: f64,
        reference: &[[f64; 3]],
        displacement: &[[f64; 3]],
        external_force: &mut [[f64; 3]],
    ) {
        match &self.rule {
            Rule::Constant => {}
            Rule::Pressure { faces, curve } => {
                // f_a = −∫ p N_a n dA on the current configuration
                let pressure = curve.value(time);
                self.forces.fill([0.0; 3]);
                for face in faces {
                    let place = |node: u32| {
                        let node = self.nodes[node as usize] as usize;
                        std::array::from_fn(|i| reference[node][i] + displacement[node][i])
                    };
                    let forces = &mut self.forces;
                    let add = |node: u32, area: [f64; 3]| {
                        for (force, area) in forces[node as usize].iter_mut().zip(area) {
                            *force -= pressure * area;
                        }
                    };
                    area_vectors(face, place, |vector| vector, add);
                }
            }
            Rule::Traction { areas, direction, curve } => {
                // f_a = t(time) ∫ N_a dA₀
                let traction = curve.value(time);
                for (force, area) in self.forces.iter_mut().zip(areas) {
                    *force = direction.map(|component| component * (traction * area));
                }
            }
        }
        for (node, force) in self.nodes.iter().zip(&self.forces) {
            for (sum, force) in external_force[*node as usize].iter_mut().zip(force) {
                *sum += force;
            }
        }
    }

    /// Power of the forces at the given velocities, W.
    pub fn power(&self, velocity: &[[f64; 3]]) -> f64 {
        let power = |(node, force): (&u32, &[f64; 3])| {
            let v = velocity[*node as usize];
            force[0] * v[0] + force[1] * v[1] + force[2] * v[2]
        };
        self.nodes.iter().zip(&self.forces).map(power).sum()
    }
}

/// The nodes of the faces, sorted, and the faces as positions among them.
fn local_faces(faces: &[Face]) -> (Vec<u32>, Vec<Face>) {
    let mut nodes: Vec<u32> = faces.iter().flat_map(Face::nodes).copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    let local = |node| nodes.partition_point(|&other| other < node) as u32;
    let faces = faces.iter().map(|face| face.map(local)).collect();
    (nodes, faces)
}

/// Hands ∫ N_a `measure`(∂x/∂ξ × ∂x/∂η) dξ dη of each node a of a face, whose nodes are at `place`, to `add`.
fn area_vectors<T: Accumulate>(
    face: &Face,
    place: impl Fn(u32) -> [f64; 3],
    measure: impl Fn([f64; 3]) -> T,
    mut add: impl FnMut(u32, T),
) {
    match face {
        Face::Quad4(nodes) => {
            for (corner, area) in face_area_vectors(&nodes.map(place), measure) {
                add(nodes[corner], area);
            }
        }
        Face::Triangle3(nodes) => {
            // N_a integrates to a third of the area
            let [a, b, c] = nodes.map(place);
            let third = T::ZERO.plus(measure(cross(minus(b, a), minus(c, a))), 1.0 / 6.0);
            nodes.iter().for_each(|&node| add(node, third));
        }
        Face::Triangle6(nodes) => {
            for (&node, area) in nodes.iter().zip(triangle_area_vectors(&nodes.map(place), measure)) {
                add(node, area);
            }
        }
    }
}

/// Two of the volume coordinates of six points of a triangle (the third is what is missing to 1) and their shares of the
/// area, which are exact up to the fourth degree: for the area vectors of a curved triangle of six nodes (Dunavant 1985).
const TRIANGLE_POINTS: [([f64; 2], f64); 6] = {
    const A: f64 = 0.445_948_490_915_964_9;
    const B: f64 = 0.091_576_213_509_770_7;
    const OF_A: f64 = 0.223_381_589_678_011_5;
    const OF_B: f64 = 1.0 / 3.0 - OF_A;
    [
        ([A, A], OF_A),
        ([A, 1.0 - 2.0 * A], OF_A),
        ([1.0 - 2.0 * A, A], OF_A),
        ([B, B], OF_B),
        ([B, 1.0 - 2.0 * B], OF_B),
        ([1.0 - 2.0 * B, B], OF_B),
    ]
};

/// ∫ N_a `measure`(∂x/∂ξ × ∂x/∂η) dξ dη for each node a of a triangle of six nodes.
fn triangle_area_vectors<T: Accumulate>(nodes: &[[f64; 3]; 6], measure: impl Fn([f64; 3]) -> T) -> [T; 6] {
    let mut sums = [T::ZERO; 6];
    for ([xi, eta], share) in TRIANGLE_POINTS {
        let rest = 1.0 - xi - eta;
        // the middles follow the corners: 01, 12, 20
        let shape = [
            rest * (2.0 * rest - 1.0),
            xi * (2.0 * xi - 1.0),
            eta * (2.0 * eta - 1.0),
            4.0 * rest * xi,
            4.0 * xi * eta,
            4.0 * eta * rest,
        ];
        let by_xi = [1.0 - 4.0 * rest, 4.0 * xi - 1.0, 0.0, 4.0 * (rest - xi), 4.0 * eta, -4.0 * eta];
        let by_eta = [1.0 - 4.0 * rest, 0.0, 4.0 * eta - 1.0, -4.0 * xi, 4.0 * xi, 4.0 * (rest - eta)];
        let along = |slopes: [f64; 6]| {
            let component = |i: usize| nodes.iter().zip(slopes).map(|(node, slope)| slope * node[i]).sum();
            std::array::from_fn(component)
        };
        let measured = measure(cross(along(by_xi), along(by_eta)));
        for (sum, shape) in sums.iter_mut().zip(shape) {
            *sum = sum.plus(measured, 0.5 * share * shape);
        }
    }
    sums
}

/// ∫ N_a `measure`(∂x/∂ξ × ∂x/∂η) dξ dη for each corner a of a bilinear face; exact for the vector itself.
fn face_area_vectors<T: Accumulate>(corners: &[[f64; 3]; 4], measure: impl Fn([f64; 3]) -> T) -> [(usize, T); 4] {
    let mut sums = [(0, T::ZERO), (1, T::ZERO), (2, T::ZERO), (3, T::ZERO)];
    for [xi, eta] in FACE_SIGNS.map(|signs| signs.map(|sign| sign * GAUSS)) {
        let mut along_xi = [0.0; 3];
        let mut along_eta = [0.0; 3];
        for (corner, [sign_xi, sign_eta]) in corners.iter().zip(FACE_SIGNS) {
            for i in 0..3 {
                along_xi[i] += 0.25 * sign_xi * (1.0 + sign_eta * eta) * corner[i];
                along_eta[i] += 0.25 * sign_eta * (1.0 + sign_xi * xi) * corner[i];
            }
        }
        let measured = measure(cross(along_xi, along_eta));
        for ((_, sum), [sign_xi, sign_eta]) in sums.iter_mut().zip(FACE_SIGNS) {
            let shape_function = 0.25 * (1.0 + sign_xi * xi) * (1.0 + sign_eta * eta);
            *sum = sum.plus(measured, shape_function);
        }
    }
    sums
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

fn cross([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

fn norm(vector: [f64; 3]) -> f64 {
    vector.iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// What [`face_area_vectors`] can sum.
trait Accumulate: Copy {
    const ZERO: Self;
    fn plus(self, other: Self, factor: f64) -> Self;
}

impl Accumulate for f64 {
    const ZERO: Self = 0.0;
    fn plus(self, other: Self, factor: f64) -> Self {
        self + factor * other
    }
}

impl Accumulate for [f64; 3] {
    const ZERO: Self = [0.0; 3];
    fn plus(self, other: Self, factor: f64) -> Self {
        std::array::from_fn(|i| self[i] + factor * other[i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::Interpolation;

    const FACE: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 3.0, 0.0], [0.0, 3.0, 0.0]];

    #[test]
    fn pressure_on_a_rectangle_is_shared_equally_and_points_inwards() {
        let curve = Curve::new(vec![[0.0, 0.0], [1.0, 8.0]], Interpolation::Linear).unwrap();
        let kind = LoadKind::Pressure { faces: vec![[0, 1, 2, 3].into()], curve };
        let mut load = NodalLoad::new(&kind, &FACE, &[1.0; 4]);
        let mut external = vec![[0.0; 3]; 4];
        load.apply(0.5, &FACE, &[[0.0; 3]; 4], &mut external);
        for force in external {
            assert!(force[0] == 0.0 && force[1] == 0.0 && (force[2] + 6.0).abs() < 1e-14, "{force:?}");
        }
        assert!((load.power(&[[1.0, 1.0, -2.0]; 4]) - 48.0).abs() < 1e-13);
    }

    #[test]
    fn traction_keeps_its_direction_and_area_when_the_body_moves() {
        let kind = LoadKind::Traction {
            faces: vec![[0, 1, 2, 3].into()],
            direction: [0.0, 1.0, 0.0],
            curve: Curve::constant(2.0),
        };
        let mut load = NodalLoad::new(&kind, &FACE, &[1.0; 4]);
        let mut external = vec![[0.0; 3]; 4];
        let moved: Vec<[f64; 3]> = FACE.iter().map(|x| [x[1], -x[0], 7.0 * x[0]]).collect();
        load.apply(0.5, &FACE, &moved, &mut external);
        let total: f64 = external.iter().map(|force| force[1]).sum();
        assert!((total - 12.0).abs() < 1e-14);
        assert_eq!(external[0][0], 0.0);
    }

    /// A flat triangle of six nodes carries its load at the middles of its edges, a third each, and triangles of three nodes
    /// at the corners; a curved one has the area vector of its boundary, ½ ∮ x × dx.
    #[test]
    fn triangles_share_their_load_as_their_shape_functions_say() {
        let mut nodes =
            [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.5, 0.0], [0.0, 1.5, 0.0]];
        let areas = triangle_area_vectors(&nodes, |vector| vector);
        for (area, expected) in areas.iter().zip([0.0, 0.0, 0.0, 1.0, 1.0, 1.0]) {
            assert!(area[0] == 0.0 && area[1] == 0.0 && (area[2] - expected).abs() < 1e-15, "{area:?}");
        }
        let mut of_corners = Vec::new();
        area_vectors(&Face::from([0, 1, 2]), |node| nodes[node as usize], norm, |_, area| of_corners.push(area));
        assert!(of_corners.iter().all(|area| (area - 1.0).abs() < 1e-15));
        nodes[4] = [1.2, 1.6, 0.3];
        nodes[3] = [1.1, -0.2, 0.1];
        let sum =
            triangle_area_vectors(&nodes, |vector| vector).into_iter().fold([0.0; 3], |sum, area| sum.plus(area, 1.0));
        let mut around = [0.0; 3];
        for (a, middle, b) in [(0, 3, 1), (1, 4, 2), (2, 5, 0)] {
            // x × dx along a parabola by Simpson's rule, exact up to the third degree
            for (t, share) in [(0.0, 1.0 / 6.0), (0.5, 4.0 / 6.0), (1.0, 1.0 / 6.0)] {
                let of = |[p, q, r]: [f64; 3]| {
                    std::array::from_fn(|i| p * nodes[a][i] + q * nodes[middle][i] + r * nodes[b][i])
                };
                let x = of([(1.0 - t) * (1.0 - 2.0 * t), 4.0 * t * (1.0 - t), t * (2.0 * t - 1.0)]);
                around = around.plus(cross(x, of([4.0 * t - 3.0, 4.0 - 8.0 * t, 4.0 * t - 1.0])), 0.5 * share);
            }
        }
        assert!(norm(minus(sum, around)) < 1e-14, "{sum:?} {around:?}");
    }
}
