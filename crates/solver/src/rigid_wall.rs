//! Rigid tools that no node passes: planes, cylinders and spheres, at rest or moved along a curve.
//!
//! Contact is kinematic: a node that would be behind the surface at t_{n+1} gets the impulse that puts it on the surface
//! (`wall_contact.rs`). So nothing penetrates, no stiffness is to be chosen, and the step stays as it is. What is lost is what a
//! node brings to the surface: half of its mass times its speed of approach squared, which is a row of the ledger and falls with
//! the size of the mesh.

use crate::constraints::dot;
use crate::energy::{CentredWork, Passage};
use crate::model::{RigidWall, WallShape};

impl WallShape {
    /// Signed distance of a point from the surface (m), positive outside, and the unit normal there.
    #[inline]
    fn gap_and_normal(&self, position: &[f64; 3]) -> (f64, [f64; 3]) {
        match *self {
            Self::Plane { point, normal } => (dot(&difference(position, &point), &normal), normal),
            Self::Cylinder { point, axis, radius } => {
                let arm = difference(position, &point);
                let along = dot(&arm, &axis);
                from_centre(std::array::from_fn(|i| arm[i] - along * axis[i]), radius)
            }
            Self::Sphere { centre, radius } => from_centre(difference(position, &centre), radius),
        }
    }
}

/// Distance from a surface of this radius and the direction away from it, for the arm from its centre; at the centre itself no
/// direction is the way out.
#[inline]
fn from_centre(arm: [f64; 3], radius: f64) -> (f64, [f64; 3]) {
    let distance = dot(&arm, &arm).sqrt();
    let per_distance = if distance > 0.0 { distance.recip() } else { 0.0 };
    (distance - radius, arm.map(|component| component * per_distance))
}

fn difference(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

impl RigidWall {
    /// A plane at rest through a point with the unit normal towards the body; `friction` is Coulomb's coefficient.
    pub const fn plane(point: [f64; 3], normal: [f64; 3], friction: f64) -> Self {
        Self { shape: WallShape::Plane { point, normal }, friction, motion: None }
    }

    /// Displacement of the wall at a time, m.
    pub fn displacement(&self, time: f64) -> [f64; 3] {
        self.motion.as_ref().map_or([0.0; 3], |motion| {
            let distance = motion.quantity.displacement(&motion.curve, time);
            motion.direction.map(|component| distance * component)
        })
    }

    /// Signed distance of a point from the wall at a time, positive on the body's side, m.
    pub fn gap(&self, position: &[f64; 3], time: f64) -> f64 {
        self.shape.gap_and_normal(&difference(position, &self.displacement(time))).0
    }
}

/// A wall on its way.
#[derive(Clone, Debug)]
pub(crate) struct MovingWall {
    wall: RigidWall,
    /// Displacement at t_{n+1}, m.
    displacement_new: [f64; 3],
    /// Velocity over the step that begins at t_n, m/s.
    velocity_new: [f64; 3],
    /// From the velocity of the step before t_n to that of the step after it.
    passage: Passage,
    /// Its work on the body.
    pub work: CentredWork,
    /// Its force on the body at t_n, N.
    pub force: [f64; 3],
}

impl MovingWall {
    pub fn new(wall: RigidWall) -> Self {
        Self {
            wall,
            displacement_new: [0.0; 3],
            velocity_new: [0.0; 3],
            passage: Passage::default(),
            work: CentredWork::default(),
            force: [0.0; 3],
        }
    }

    /// Looks up the motion over the step before `time` and over the one after; at the start there is no step before.
    pub fn prepare(&mut self, time: f64, [step_old, step_new]: [f64; 2], share_old: f64) {
        if self.wall.motion.is_none() {
            return;
        }
        let now = self.wall.displacement(time);
        self.displacement_new = self.wall.displacement(time + step_new);
        self.velocity_new = difference(&self.displacement_new, &now).map(|distance| distance / step_new);
        let velocity_old = if step_old > 0.0 {
            difference(&now, &self.wall.displacement(time - step_old)).map(|distance| distance / step_old)
        } else {
            self.velocity_new
        };
        self.passage = Passage::new(&velocity_old, &self.velocity_new, share_old);
    }

    /// Enters the impulse of the wall on the body at t_n, N s.
    pub fn enter(&mut self, impulse: &[f64; 3], mean_step: f64) {
        self.work.enter(self.passage.works(impulse));
        self.force = impulse.map(|component| component / mean_step);
    }

    /// Its velocity on the way through t_n.
    #[inline]
    pub fn passage(&self) -> &Passage {
        &self.passage
    }

    /// Velocity over the step that begins at t_n, m/s.
    #[inline]
    pub fn velocity(&self) -> &[f64; 3] {
        &self.velocity_new
    }

    /// Coulomb's coefficient.
    #[inline]
    pub fn friction(&self) -> f64 {
        self.wall.friction
    }

    /// Whether the surface is flat.
    #[inline]
    pub fn is_plane(&self) -> bool {
        matches!(self.wall.shape, WallShape::Plane { .. })
    }

    /// Distance at t_{n+1} of a node with this velocity (m), and the normal there.
    #[inline]
    pub fn gap_new(&self, velocity: &[f64; 3], position: &[f64; 3], time_step: f64) -> (f64, [f64; 3]) {
        let place = std::array::from_fn(|i| position[i] + time_step * velocity[i] - self.displacement_new[i]);
        self.wall.shape.gap_and_normal(&place)
    }

    /// Whether a node with this velocity would pass the wall within the step.
    #[inline]
    pub fn stops(&self, velocity: &[f64; 3], position: &[f64; 3], time_step: f64) -> bool {
        self.gap_new(velocity, position, time_step).0 < 0.0
    }

    /// Whether a curved tool moves farther within the step than its radius: it could pass over a node.
    pub fn outruns_itself(&self, time_step: f64) -> bool {
        match self.wall.shape {
            WallShape::Plane { .. } => false,
            WallShape::Cylinder { radius, .. } | WallShape::Sphere { radius, .. } => {
                time_step * dot(&self.velocity_new, &self.velocity_new).sqrt() > radius
            }
        }
    }
}
