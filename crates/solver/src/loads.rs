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
            for (corner, area) in face_area_vectors(&nodes.map(&place), measure) {
                add(nodes[corner], area);
            }
        }
        Face::Triangle3(nodes) => {
            // N_a integrates to a third of the area
            let [a, b, c] = nodes.map(place);
            let third = T::ZERO.plus(measure(cross(minus(b, a), minus(c, a))), 1.0 / 6.0);
            nodes.iter().for_each(|&node| add(node, third));
        }
        // as the motion of `tet10`, four triangles
        Face::Triangle6([a, b, c, ab, bc, ca]) => {
            for nodes in [[*a, *ab, *ca], [*ab, *b, *bc], [*ca, *bc, *c], [*ab, *bc, *ca]] {
                let [x, y, z] = nodes.map(&place);
                let third = T::ZERO.plus(measure(cross(minus(y, x), minus(z, x))), 1.0 / 6.0);
                nodes.iter().for_each(|&node| add(node, third));
            }
        }
    }
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

    /// A triangle of three nodes shares its load equally; one of six is four of them, so that a corner has a twelfth and a middle
    /// a quarter. Its area vector is that of its boundary, ½ Σ x × Δx, also when it is not flat.
    #[test]
    fn triangles_share_their_load_as_their_elements_move() {
        let mut nodes =
            [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.5, 0.0], [0.0, 1.5, 0.0]];
        let areas = |face: Face, nodes: &[[f64; 3]; 6]| {
            let mut areas = [[0.0; 3]; 6];
            let add = |node: u32, area: [f64; 3]| areas[node as usize] = areas[node as usize].plus(area, 1.0);
            area_vectors(&face, |node| nodes[node as usize], |vector| vector, add);
            areas
        };
        let six = Face::from([0, 1, 2, 3, 4, 5]);
        for (face, of_corner, of_middle) in [(Face::from([0, 1, 2]), 1.0, 0.0), (six, 0.25, 0.75)] {
            for (node, area) in areas(face, &nodes).iter().enumerate() {
                let expected = [0.0, 0.0, if node < 3 { of_corner } else { of_middle }];
                assert!(norm(minus(*area, expected)) < 1e-15, "{area:?}");
            }
        }
        nodes[4] = [1.2, 1.6, 0.3];
        nodes[3] = [1.1, -0.2, 0.1];
        let sum = areas(six, &nodes).into_iter().fold([0.0; 3], |sum, area| sum.plus(area, 1.0));
        let around = [[0, 3], [3, 1], [1, 4], [4, 2], [2, 5], [5, 0]];
        let around = around.iter().fold([0.0; 3], |sum, &[a, b]| sum.plus(cross(nodes[a], nodes[b]), 0.5));
        assert!(norm(minus(sum, around)) < 1e-14, "{sum:?} {around:?}");
    }
}
