//! Constraints on nodes: held or driven degrees of freedom, and rigid walls.

use crate::error::{ConstraintSource, ModelError};
use crate::model::{Direction, Model, Prescribed, Quantity, RigidWall};

/// Nodes without a constraint have this place in [`Constraints::of_node`].
const FREE: u32 = u32::MAX;

/// All held and driven degrees of freedom.
#[derive(Clone, Debug)]
pub(crate) struct Constraints {
    /// Place of each node in `motions`, or [`FREE`].
    of_node: Vec<u32>,
    /// What drives each direction of a constrained node.
    motions: Vec<[Motion; 3]>,
    prescribed: Vec<Prescribed>,
    /// Displacement of each prescribed curve at the end of the step.
    displacements: Vec<f64>,
}

/// What drives one degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Motion {
    Free,
    Held,
    /// Position in `Constraints::prescribed`.
    Driven(u32),
}

impl Constraints {
    /// The constraints of a model.
    ///
    /// # Errors
    /// One degree of freedom that two entries drive differently.
    pub fn new(model: &Model, node_count: usize) -> Result<Self, ModelError> {
        let prescribed = model.prescribed.clone();
        let displacements = vec![0.0; prescribed.len()];
        let mut constraints = Self { of_node: vec![FREE; node_count], motions: Vec::new(), prescribed, displacements };
        let mut sources: Vec<[Option<ConstraintSource>; 3]> = Vec::new();
        let fixes = model.fixes.iter().enumerate().flat_map(|(position, fix)| {
            fix.directions.iter().map(move |&direction| (&fix.nodes, direction, ConstraintSource::Fix(position)))
        });
        let driven = model.prescribed.iter().enumerate().map(|(position, prescribed)| {
            (&prescribed.nodes, prescribed.direction, ConstraintSource::Prescribed(position))
        });
        for (nodes, direction, source) in fixes.chain(driven) {
            for &node in nodes {
                constraints.add(node, direction, source, &mut sources)?;
            }
        }
        Ok(constraints)
    }

    fn add(
        &mut self,
        node: u32,
        direction: Direction,
        source: ConstraintSource,
        sources: &mut Vec<[Option<ConstraintSource>; 3]>,
    ) -> Result<(), ModelError> {
        let place = &mut self.of_node[node as usize];
        if *place == FREE {
            *place = self.motions.len() as u32;
            self.motions.push([Motion::Free; 3]);
            sources.push([None; 3]);
        }
        let (place, i) = (*place as usize, direction.index());
        if let Some(first) = sources[place][i] {
            return if self.same_motion(first, source) {
                Ok(())
            } else {
                Err(ModelError::ConflictingConstraints { node, direction, first, second: source })
            };
        }
        sources[place][i] = Some(source);
        self.motions[place][i] = match source {
            ConstraintSource::Fix(_) => Motion::Held,
            ConstraintSource::Prescribed(position) => Motion::Driven(position as u32),
        };
        Ok(())
    }

    fn same_motion(&self, first: ConstraintSource, second: ConstraintSource) -> bool {
        match (first, second) {
            (ConstraintSource::Fix(_), ConstraintSource::Fix(_)) => true,
            (ConstraintSource::Prescribed(a), ConstraintSource::Prescribed(b)) => {
                let (a, b) = (&self.prescribed[a], &self.prescribed[b]);
                a.quantity == b.quantity && a.curve == b.curve
            }
            _ => false,
        }
    }

    /// Looks up the curves at the end of a step.
    pub fn prepare(&mut self, time_new: f64) {
        for (displacement, prescribed) in self.displacements.iter_mut().zip(&self.prescribed) {
            *displacement = match prescribed.quantity {
                Quantity::Displacement => prescribed.curve.value(time_new),
                Quantity::Velocity => prescribed.curve.integral(time_new),
                Quantity::Acceleration => prescribed.curve.double_integral(time_new),
            };
        }
    }

    /// Whether any direction of the node is held or driven.
    #[inline]
    pub fn constrain(&self, node: usize) -> bool {
        self.of_node[node] != FREE
    }

    /// The directions of a node that are neither held nor driven.
    #[inline]
    pub fn free_directions(&self, node: usize) -> [bool; 3] {
        match self.of_node[node] {
            FREE => [true; 3],
            place => self.motions[place as usize].map(|motion| motion == Motion::Free),
        }
    }

    /// The velocity that meets the constraints of a node: driven directions reach their displacement at the end of the
    /// step.
    #[inline]
    pub fn velocity(&self, node: usize, free: [f64; 3], displacement: &[f64; 3], time_step: f64) -> [f64; 3] {
        let place = self.of_node[node];
        if place == FREE {
            return free;
        }
        let motions = &self.motions[place as usize];
        std::array::from_fn(|i| match motions[i] {
            Motion::Free => free[i],
            Motion::Held => 0.0,
            // v_{n+½} = (u(t_{n+1}) − u_n)/Δt
            Motion::Driven(position) => (self.displacements[position as usize] - displacement[i]) / time_step,
        })
    }
}

impl RigidWall {
    /// Signed distance of a point from the wall, positive on the body's side, m.
    #[inline]
    pub(crate) fn gap(&self, position: &[f64; 3]) -> f64 {
        (0..3).map(|i| (position[i] - self.point[i]) * self.normal[i]).sum()
    }

    /// Whether a node with this velocity would pass the wall within the step.
    #[inline]
    pub(crate) fn stops(&self, velocity: &[f64; 3], position: &[f64; 3], time_step: f64) -> bool {
        self.gap(position) + time_step * dot(velocity, &self.normal) < 0.0
    }

    /// The velocity of a node that may not pass the wall within the step: the smallest change along the normal that
    /// ends on the wall, and Coulomb friction up to μ times that change along the tangent. Only `free` directions give
    /// way; what the wall does along the others is for the constraint to take back.
    #[inline]
    pub(crate) fn velocity(
        &self,
        velocity: [f64; 3],
        position: &[f64; 3],
        time_step: f64,
        free: [bool; 3],
    ) -> [f64; 3] {
        let gap_new = self.gap(position) + time_step * dot(&velocity, &self.normal);
        if gap_new >= 0.0 {
            return velocity;
        }
        // n_f, the part of the normal along which the node can move; a node held against the wall is not the wall's
        let free_normal: [f64; 3] = std::array::from_fn(|i| if free[i] { self.normal[i] } else { 0.0 });
        let mobility = dot(&free_normal, &free_normal);
        if mobility < SMALLEST_MOBILITY {
            return velocity;
        }
        // the normal impulse per mass −g_{n+1}/(Δt n_f · n_f) brings the gap to zero
        let normal_change = -gap_new / (time_step * mobility);
        let approach = dot(&velocity, &free_normal) / mobility;
        let tangential: [f64; 3] =
            std::array::from_fn(|i| if free[i] { velocity[i] - approach * free_normal[i] } else { 0.0 });
        let speed = dot(&tangential, &tangential).sqrt();
        let friction_change = (self.friction * normal_change).min(speed);
        let slowed = if speed > 0.0 { friction_change / speed } else { 0.0 };
        std::array::from_fn(|i| velocity[i] + normal_change * self.normal[i] - slowed * tangential[i])
    }
}

/// A node whose free directions lie in the plane of a wall to this accuracy cannot be moved off it: sin² of 10⁻⁶ rad.
const SMALLEST_MOBILITY: f64 = 1e-12;

#[inline]
pub(crate) fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wall_stops_a_node_on_its_plane_and_friction_never_reverses_sliding() {
        let wall = RigidWall { point: [0.0; 3], normal: [0.0, 0.0, 1.0], friction: 0.5 };
        let stopped = wall.velocity([3.0, 0.0, -2.0], &[0.0, 0.0, 0.1], 0.1, [true; 3]);
        assert_eq!(stopped, [2.5, 0.0, -1.0]);
        let stuck = wall.velocity([0.1, 0.0, -2.0], &[0.0, 0.0, 0.0], 0.1, [true; 3]);
        assert_eq!(stuck, [0.0, 0.0, 0.0]);
        let leaving = wall.velocity([0.1, 0.0, 2.0], &[0.0, 0.0, 0.0], 0.1, [true; 3]);
        assert_eq!(leaving, [0.1, 0.0, 2.0]);
    }

    #[test]
    fn an_oblique_wall_stops_a_node_on_a_symmetry_plane() {
        // x is held, the wall rises at 45° in x and y: along y alone the node must give way twice as far
        let normal = [std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::FRAC_1_SQRT_2, 0.0];
        let wall = RigidWall { point: [0.0; 3], normal, friction: 0.0 };
        let [_, y, z] = wall.velocity([0.0, -2.0, 3.0], &[0.0, 0.1, 0.0], 0.1, [false, true, true]);
        assert!((y + 1.0).abs() < 1e-12 && z == 3.0, "{y} {z}");
        // friction acts along z, the one direction of sliding that is left, up to μ times the change along the normal
        let rough = RigidWall { friction: 0.5, ..wall };
        let [_, y, z] = rough.velocity([0.0, -2.0, 3.0], &[0.0, 0.1, 0.0], 0.1, [false, true, true]);
        assert!((y + 1.0).abs() < 1e-12 && (z - (3.0 - 0.5 * 2.0_f64.sqrt())).abs() < 1e-12, "{y} {z}");
    }

    #[test]
    fn a_node_held_against_a_wall_is_left_to_its_constraint() {
        let wall = RigidWall { point: [0.0; 3], normal: [0.0, 0.0, 1.0], friction: 0.5 };
        let driven = wall.velocity([1.0, 0.0, -2.0], &[0.0; 3], 0.1, [true, true, false]);
        assert_eq!(driven, [1.0, 0.0, -2.0]);
    }
}
