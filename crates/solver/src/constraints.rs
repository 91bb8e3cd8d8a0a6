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

    /// The velocity of a node that may not pass the wall within the step: the smallest change along the normal that
    /// ends on the wall, and Coulomb friction up to μ times that change along the tangent.
    #[inline]
    pub(crate) fn velocity(&self, velocity: [f64; 3], position: &[f64; 3], time_step: f64) -> [f64; 3] {
        let approach: f64 = (0..3).map(|i| velocity[i] * self.normal[i]).sum();
        let gap_new = self.gap(position) + time_step * approach;
        if gap_new >= 0.0 {
            return velocity;
        }
        // the normal impulse per mass −g_{n+1}/Δt brings the gap to zero
        let normal_change = -gap_new / time_step;
        let tangential: [f64; 3] = std::array::from_fn(|i| velocity[i] - approach * self.normal[i]);
        let speed = tangential.iter().map(|c| c * c).sum::<f64>().sqrt();
        let friction_change = (self.friction * normal_change).min(speed);
        let kept = if speed > 0.0 { 1.0 - friction_change / speed } else { 1.0 };
        std::array::from_fn(|i| kept * tangential[i] + (approach + normal_change) * self.normal[i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wall_stops_a_node_on_its_plane_and_friction_never_reverses_sliding() {
        let wall = RigidWall { point: [0.0; 3], normal: [0.0, 0.0, 1.0], friction: 0.5 };
        let stopped = wall.velocity([3.0, 0.0, -2.0], &[0.0, 0.0, 0.1], 0.1);
        assert_eq!(stopped, [2.5, 0.0, -1.0]);
        let stuck = wall.velocity([0.1, 0.0, -2.0], &[0.0, 0.0, 0.0], 0.1);
        assert_eq!(stuck, [0.0, 0.0, 0.0]);
        let leaving = wall.velocity([0.1, 0.0, 2.0], &[0.0, 0.0, 0.0], 0.1);
        assert_eq!(leaving, [0.1, 0.0, 2.0]);
    }
}
