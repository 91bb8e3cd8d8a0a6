//! The lowest natural frequency of a body as it is held: the slowest vibration that a process has to be slow for.
//!
//! **Operator.** K is that of the elements at time 0, as in [`global_time_step`](crate::global_time_step), of tets that of the
//! displacements alone. Held and driven directions stand still. Rigid tools and loads hold nothing. Motions of a whole body
//! without stiffness (six of a body that nothing holds, one of a bar between two planes of symmetry) are taken out: bodies are what
//! elements connect, and the motions of each that no held direction hinders are found from six small numbers.
//!
//! **Estimate.** The smallest Ritz value of Lanczos' method from a random start falls to the smallest eigenvalue λ₁ of M⁻¹K from
//! above. As long as it has not got there it falls with the square of the steps k, λ_max/k²; then it stands still. It is taken once it has
//! changed by [`CHANGE`] or less while k grew by a quarter. That takes some √(λ_max/(λ₂ − λ₁)) times a few steps, each cheaper than a
//! step of the run; one period of the slowest vibration takes π √(λ_max/λ₁) steps of the run.

use crate::constraints::{Constraints, dot};
use crate::lanczos::Lanczos;
use crate::simulation::Simulation;
use estar_element::element::ElementStep;
use estar_mesh::Mesh;
use std::f64::consts::TAU;

/// Change of the Ritz value over the last quarter of the steps that is none.
const CHANGE: f64 = 1e-2;
/// Steps after which the Ritz value is looked at for the first time.
const FIRST_LOOK: usize = 32;
/// Steps after which the search is given up.
const MOST_STEPS: usize = 20_000;
/// Steps after which rigid motions are taken out again.
const PURIFY_EVERY: usize = 16;
/// A Ritz value below this share of the largest is that of a motion without stiffness: rounding leaves 10⁻¹⁶ of it.
const NO_STIFFNESS: f64 = 1e-12;
/// A rigid motion is free if the sum of the squares of what it does in held directions, over its mean square, is less.
const HINDERED: f64 = 1e-10;

/// What was found of the lowest natural frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NaturalFrequency {
    /// It was found.
    Found {
        /// The frequency, 1/s.
        frequency: f64,
        /// Steps of the search.
        steps: usize,
    },
    /// It was not found in so many steps.
    NotConverged {
        /// It is at most this, 1/s.
        at_most: f64,
        /// Steps of the search.
        steps: usize,
    },
    /// The body can move in itself without any stiffness, as parts that share an edge turn about it.
    Mechanism,
    /// Nothing can vibrate: every direction is held or driven.
    NothingFree,
}

impl Simulation {
    /// The lowest natural frequency of the body with its present mass, other than that of rigid motions.
    pub fn natural_frequency(mut self) -> NaturalFrequency {
        let rigid = RigidMotions::new(&self.mesh, &self.nodes.mass, &self.constraints);
        let constraints = self.constraints.clone();
        let kept = |node: usize, z: [f64; 3]| -> [f64; 3] {
            let free = constraints.free_directions(node);
            std::array::from_fn(|i| if free[i] { z[i] } else { 0.0 })
        };
        let mut lanczos = Lanczos::new(self.nodes.mass.len(), 0);
        let step = ElementStep { bulk_viscosity: None, time_step: self.element_time_step() };
        let mut operator = self.linear_operator(&step);
        let mass = operator.mass;
        let take_out = |z: &mut [[f64; 3]]| {
            rigid.take_out(mass, z);
            z.iter_mut().enumerate().for_each(|(node, z)| *z = kept(node, *z));
        };
        lanczos.start(0, mass, kept);
        let square = lanczos.square();
        lanczos.purify(mass, take_out);
        // what rounding leaves of a random vector is no direction
        if lanczos.square() <= f64::EPSILON * square {
            return NaturalFrequency::NothingFree;
        }
        let mut before = f64::INFINITY;
        let mut look = FIRST_LOOK;
        loop {
            let mut goes_on = true;
            while goes_on && lanczos.steps() < look {
                let next = (lanczos.steps() + PURIFY_EVERY).min(look);
                goes_on = lanczos.extend_to(next, &mut operator, kept);
                lanczos.purify(mass, take_out);
            }
            let (eigenvalue, steps) = (lanczos.smallest_ritz_value(), lanczos.steps());
            if eigenvalue <= NO_STIFFNESS * lanczos.largest_ritz_value() {
                return NaturalFrequency::Mechanism;
            }
            let frequency = eigenvalue.sqrt() / TAU;
            if !goes_on || before <= (1.0 + CHANGE) * eigenvalue {
                return NaturalFrequency::Found { frequency, steps };
            }
            if steps >= MOST_STEPS {
                return NaturalFrequency::NotConverged { at_most: frequency, steps };
            }
            before = eigenvalue;
            look += look / 4;
        }
    }
}

/// The rigid motions of each body that nothing hinders.
struct RigidMotions {
    /// The body of each node.
    body: Vec<u32>,
    /// Each node from the centre of its body, m.
    arms: Vec<[f64; 3]>,
    /// Of each body motions of unit length in its mass, at right angles to one another.
    motions: Vec<Vec<RigidMotion>>,
}

/// Velocity of the centre and rate of rotation about it.
type RigidMotion = [f64; 6];

/// The velocity of a motion at an arm from the centre, v + ω × r.
fn velocity([x, y, z, p, q, r]: &RigidMotion, arm: &[f64; 3]) -> [f64; 3] {
    [x + q * arm[2] - r * arm[1], y + r * arm[0] - p * arm[2], z + p * arm[1] - q * arm[0]]
}

/// Translations along the axes and rotations about them.
fn along_axes(arm: &[f64; 3]) -> [[f64; 3]; 6] {
    std::array::from_fn(|i| velocity(&std::array::from_fn(|j| f64::from(u8::from(i == j))), arm))
}

impl RigidMotions {
    fn new(mesh: &Mesh, mass: &[f64], constraints: &Constraints) -> Self {
        let body = bodies(mesh);
        let count = body.iter().max().map_or(0, |last| *last as usize + 1);
        // mass and its moment
        let mut moments = vec![[0.0; 4]; count];
        for ((x, mass), body) in mesh.coordinates().iter().zip(mass).zip(&body) {
            for (moment, factor) in moments[*body as usize].iter_mut().zip([1.0, x[0], x[1], x[2]]) {
                *moment += mass * factor;
            }
        }
        let arm = |(x, body): (&[f64; 3], &u32)| {
            let [mass, moments @ ..] = moments[*body as usize];
            std::array::from_fn(|i| x[i] - moments[i] / mass)
        };
        let arms: Vec<[f64; 3]> = mesh.coordinates().iter().zip(&body).map(arm).collect();
        // products of the motions along the axes: of momentum, and in held directions
        let mut in_mass = vec![[[0.0; 6]; 6]; count];
        let mut in_held = in_mass.clone();
        for (node, arm) in arms.iter().enumerate() {
            let body = body[node] as usize;
            let (motions, free) = (along_axes(arm), constraints.free_directions(node));
            for (i, a) in motions.iter().enumerate() {
                for (j, b) in motions.iter().enumerate() {
                    let product = |axis: usize| a[axis] * b[axis];
                    in_mass[body][i][j] += mass[node] * (0..3).map(product).sum::<f64>();
                    in_held[body][i][j] += (0..3).filter(|axis| !free[*axis]).map(product).sum::<f64>();
                }
            }
        }
        let of_bodies = in_mass.iter().zip(&in_held).zip(&moments);
        let motions = of_bodies.map(|((in_mass, in_held), moments)| free_motions(in_mass, in_held, moments[0]));
        Self { motions: motions.collect(), body, arms }
    }

    /// Takes the rigid motions out of a field of velocities.
    fn take_out(&self, mass: &[f64], field: &mut [[f64; 3]]) {
        let mut shares: Vec<Vec<f64>> = self.motions.iter().map(|motions| vec![0.0; motions.len()]).collect();
        for (node, v) in field.iter().enumerate() {
            let body = self.body[node] as usize;
            for (share, motion) in shares[body].iter_mut().zip(&self.motions[body]) {
                *share += mass[node] * dot(&velocity(motion, &self.arms[node]), v);
            }
        }
        for (node, v) in field.iter_mut().enumerate() {
            let body = self.body[node] as usize;
            for (share, motion) in shares[body].iter().zip(&self.motions[body]) {
                let of_motion = velocity(motion, &self.arms[node]);
                *v = std::array::from_fn(|i| v[i] - share * of_motion[i]);
            }
        }
    }
}

/// The rigid motions of a body of this mass that no held direction hinders, from the products of those along the axes.
fn free_motions(in_mass: &Matrix, in_held: &Matrix, mass: f64) -> Vec<RigidMotion> {
    // translations and rotations become of one size
    let scale: [f64; 6] = std::array::from_fn(|i| in_mass[i][i].sqrt().recip());
    let scaled = std::array::from_fn(|i| std::array::from_fn(|j| scale[i] * in_mass[i][j] * scale[j]));
    let (squares, axes) = principal_axes(scaled);
    let motions: Matrix = std::array::from_fn(|k| std::array::from_fn(|i| scale[i] * axes[k][i] / squares[k].sqrt()));
    let held = |a: &RigidMotion, b: &RigidMotion| -> f64 {
        let row = |i: usize| a[i] * in_held[i].iter().zip(b).map(|(held, b)| held * b).sum::<f64>();
        mass * (0..6).map(row).sum::<f64>()
    };
    let (hindrances, axes) =
        principal_axes(std::array::from_fn(|k| std::array::from_fn(|l| held(&motions[k], &motions[l]))));
    let free = hindrances.iter().zip(&axes).filter(|(hindrance, _)| **hindrance < HINDERED);
    let sum = |axis: &[f64; 6], i: usize| axis.iter().zip(&motions).map(|(share, motion)| share * motion[i]).sum();
    free.map(|(_, axis)| std::array::from_fn(|i| sum(axis, i))).collect()
}

type Matrix = [[f64; 6]; 6];

/// Eigenvalues and eigenvectors of a symmetric matrix, by Jacobi's rotations: small, and of the same bits on every machine.
fn principal_axes(mut matrix: Matrix) -> ([f64; 6], Matrix) {
    const SWEEPS: usize = 12;
    let mut axes = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    let turn = |rows: &mut Matrix, p: usize, q: usize, [c, s]: [f64; 2]| {
        let (a, b) = (rows[p], rows[q]);
        rows[p] = std::array::from_fn(|k| c * a[k] - s * b[k]);
        rows[q] = std::array::from_fn(|k| s * a[k] + c * b[k]);
    };
    for (p, q) in (0..SWEEPS).flat_map(|_| (0..6).flat_map(|p| (p + 1..6).map(move |q| (p, q)))) {
        if matrix[p][q] == 0.0 {
            continue;
        }
        // t = tan φ with t² + 2 θ t = 1
        let theta = (matrix[q][q] - matrix[p][p]) / (2.0 * matrix[p][q]);
        let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
        let c = (t * t + 1.0).sqrt().recip();
        for _ in 0..2 {
            turn(&mut matrix, p, q, [c, t * c]);
            matrix = std::array::from_fn(|i| std::array::from_fn(|j| matrix[j][i]));
        }
        turn(&mut axes, p, q, [c, t * c]);
    }
    (std::array::from_fn(|i| matrix[i][i]), axes)
}

/// The body of each node, counted from 0: nodes that elements connect are of one.
fn bodies(mesh: &Mesh) -> Vec<u32> {
    let mut leaders: Vec<u32> = (0..mesh.node_count() as u32).collect();
    let leader = |leaders: &mut [u32], mut node: u32| {
        while leaders[node as usize] != node {
            leaders[node as usize] = leaders[leaders[node as usize] as usize];
            node = leaders[node as usize];
        }
        node
    };
    for nodes in mesh.elements().iter() {
        let first = leader(&mut leaders, nodes[0]);
        for &node in nodes {
            // the least node leads, so that it comes first below
            let other = leader(&mut leaders, node);
            let first = leader(&mut leaders, first);
            leaders[first.max(other) as usize] = first.min(other);
        }
    }
    let mut body = vec![0; leaders.len()];
    let mut count = 0;
    for node in 0..leaders.len() {
        let leader = leader(&mut leaders, node as u32) as usize;
        if leader == node {
            body[node] = count;
            count += 1;
        } else {
            body[node] = body[leader];
        }
    }
    body
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn principal_axes_are_those_of_a_known_matrix() {
        // 2, −1 on six places: 2 − 2 cos(kπ/7)
        let matrix: Matrix = std::array::from_fn(|i| {
            std::array::from_fn(|j: usize| match i.abs_diff(j) {
                0 => 2.0,
                1 => -1.0,
                _ => 0.0,
            })
        });
        let (mut values, axes) = principal_axes(matrix);
        for (value, axis) in values.iter().zip(&axes) {
            for (i, row) in matrix.iter().enumerate() {
                let product: f64 = row.iter().zip(axis).map(|(a, b)| a * b).sum();
                assert!((product - value * axis[i]).abs() < 1e-13, "{product} {value}");
            }
        }
        values.sort_by(f64::total_cmp);
        for (k, value) in (1..).zip(values) {
            let exact = 2.0 - 2.0 * (f64::from(k) * std::f64::consts::PI / 7.0).cos();
            assert!((value - exact).abs() < 1e-13, "{k}: {value} {exact}");
        }
    }
}
