//! Rigid tools that no node passes: planes, cylinders and spheres, at rest or moved along a curve.
//!
//! Contact is kinematic: a node that would be behind the surface at t_{n+1} gets the impulse that puts it on the surface, and
//! Coulomb's friction works against what is left of its sliding. So nothing penetrates, no stiffness is to be chosen, and the
//! step stays as it is. What is lost is what a node brings to the surface: half of its mass times its speed of approach squared,
//! which is a row of the ledger and falls with the size of the mesh.

use crate::constraints::dot;
use crate::energy::CentredWork;
use crate::model::{RigidWall, WallShape};

/// A node whose free directions lie in the plane of a wall to this accuracy cannot be moved off it: sin² of 10⁻⁶ rad.
const SMALLEST_MOBILITY: f64 = 1e-12;

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

/// Of a curved tool: where less of the normal than this is free, cos² of 60°, a node would have to go far along the surface to get
/// out, and is left to what holds it.
const SMALLEST_MOBILITY_ON_CURVES: f64 = 0.25;

impl WallShape {
    /// The λ with which `gap` + λ along the free part of the normal ends on the surface; none where that part is too small.
    #[inline]
    fn way_out(&self, gap: f64, free_normal: &[f64; 3]) -> Option<f64> {
        let mobility = dot(free_normal, free_normal);
        let (radius, across) = match self {
            Self::Plane { .. } => return (mobility >= SMALLEST_MOBILITY).then(|| -gap / mobility),
            Self::Sphere { radius, .. } => (radius, mobility),
            Self::Cylinder { axis, radius, .. } => (radius, mobility - dot(free_normal, axis).powi(2)),
        };
        if mobility < SMALLEST_MOBILITY_ON_CURVES {
            return None;
        }
        // |a + λ n_f|² = r² across the axis, with a = (r + g) n and a · n_f = (r + g) n_f · n_f
        let arm = radius + gap;
        let along = arm * mobility;
        Some(((along * along + across * (radius * radius - arm * arm)).sqrt() - along) / across)
    }
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
    /// Velocity over the step that ends at t_n, m/s.
    velocity_old: [f64; 3],
    /// Velocity over the step that begins at t_n, m/s.
    velocity_new: [f64; 3],
    /// Its work on the body.
    pub work: CentredWork,
    /// Its force on the body at t_n, N.
    pub force: [f64; 3],
}

/// Changes of a node's velocity by a wall, m/s.
pub(crate) struct Contact {
    /// All of it.
    pub change: [f64; 3],
    /// The part of friction.
    pub friction: [f64; 3],
}

/// A step of a node that walls may stop.
pub(crate) struct NodeStep {
    /// Place at t_n, m.
    pub position: [f64; 3],
    /// Δt to t_{n+1}, s.
    pub time_step: f64,
    /// The directions that no constraint holds.
    pub free: [bool; 3],
}

impl MovingWall {
    pub fn new(wall: RigidWall) -> Self {
        Self {
            wall,
            displacement_new: [0.0; 3],
            velocity_old: [0.0; 3],
            velocity_new: [0.0; 3],
            work: CentredWork::default(),
            force: [0.0; 3],
        }
    }

    /// Looks up the motion over the step before `time` and over the one after; at the start there is no step before.
    pub fn prepare(&mut self, time: f64, step_old: f64, step_new: f64) {
        if self.wall.motion.is_none() {
            return;
        }
        let now = self.wall.displacement(time);
        self.displacement_new = self.wall.displacement(time + step_new);
        self.velocity_new = difference(&self.displacement_new, &now).map(|distance| distance / step_new);
        self.velocity_old = if step_old > 0.0 {
            difference(&now, &self.wall.displacement(time - step_old)).map(|distance| distance / step_old)
        } else {
            self.velocity_new
        };
    }

    /// Enters the impulse of the wall on the body at t_n, N s.
    pub fn enter(&mut self, impulse: &[f64; 3], mean_step: f64) {
        self.work.enter(0.5 * dot(impulse, &self.velocity_old), 0.5 * dot(impulse, &self.velocity_new));
        self.force = impulse.map(|component| component / mean_step);
    }

    /// Work of an impulse on this wall's velocity, half of it before t_n and half after, J.
    #[inline]
    pub fn work_of(&self, impulse: &[f64; 3]) -> [f64; 2] {
        [0.5 * dot(impulse, &self.velocity_old), 0.5 * dot(impulse, &self.velocity_new)]
    }

    /// Distance at t_{n+1} of a node with this velocity, and the normal there.
    #[inline]
    fn gap_new(&self, velocity: &[f64; 3], position: &[f64; 3], time_step: f64) -> (f64, [f64; 3]) {
        let place = std::array::from_fn(|i| position[i] + time_step * velocity[i] - self.displacement_new[i]);
        self.wall.shape.gap_and_normal(&place)
    }

    /// Whether a node with this velocity would pass the wall within the step.
    #[inline]
    pub fn stops(&self, velocity: &[f64; 3], position: &[f64; 3], time_step: f64) -> bool {
        self.gap_new(velocity, position, time_step).0 < 0.0
    }

    /// What the wall does to the velocity of a node that may not pass it within the step: the smallest change along the normal
    /// that ends on the wall, and Coulomb friction up to μ times that change against the sliding along the wall. Only free
    /// directions give way; what the wall does along the others is for the constraint to take back.
    #[inline]
    pub fn contact(&self, velocity: &[f64; 3], step: &NodeStep) -> Contact {
        const NONE: Contact = Contact { change: [0.0; 3], friction: [0.0; 3] };
        let NodeStep { position, time_step, free } = step;
        let (gap_new, normal) = self.gap_new(velocity, position, *time_step);
        if gap_new >= 0.0 {
            return NONE;
        }
        // n_f, the part of the normal along which the node can move; a node held against the wall is not the wall's
        let free_normal: [f64; 3] = std::array::from_fn(|i| if free[i] { normal[i] } else { 0.0 });
        let mobility = dot(&free_normal, &free_normal);
        // the normal impulse per mass that brings the gap to zero: −g_{n+1}/(Δt n_f · n_f) on a plane
        let Some(way_out) = self.wall.shape.way_out(gap_new, &free_normal) else { return NONE };
        let normal_change = way_out / time_step;
        let relative = difference(velocity, &self.velocity_new);
        let approach = dot(&relative, &free_normal) / mobility;
        let sliding: [f64; 3] =
            std::array::from_fn(|i| if free[i] { relative[i] - approach * free_normal[i] } else { 0.0 });
        let speed = dot(&sliding, &sliding).sqrt();
        let friction_change = (self.wall.friction * normal_change).min(speed);
        let slowed = if speed > 0.0 { friction_change / speed } else { 0.0 };
        let friction = sliding.map(|component| -slowed * component);
        Contact { change: std::array::from_fn(|i| normal_change * normal[i] + friction[i]), friction }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::{Curve, Interpolation};
    use crate::model::{Quantity, WallMotion};

    const UP: [f64; 3] = [0.0, 0.0, 1.0];

    fn velocity(wall: &RigidWall, velocity: [f64; 3], position: [f64; 3], free: [bool; 3]) -> [f64; 3] {
        let mut wall = MovingWall::new(wall.clone());
        wall.prepare(0.0, 0.0, 0.1);
        let contact = wall.contact(&velocity, &NodeStep { position, time_step: 0.1, free });
        std::array::from_fn(|i| velocity[i] + contact.change[i])
    }

    #[test]
    fn wall_stops_a_node_on_its_plane_and_friction_never_reverses_sliding() {
        let wall = RigidWall::plane([0.0; 3], UP, 0.5);
        let free = [true; 3];
        assert_eq!(velocity(&wall, [3.0, 0.0, -2.0], [0.0, 0.0, 0.1], free), [2.5, 0.0, -1.0]);
        assert_eq!(velocity(&wall, [0.1, 0.0, -2.0], [0.0; 3], free), [0.0; 3]);
        assert_eq!(velocity(&wall, [0.1, 0.0, 2.0], [0.0; 3], free), [0.1, 0.0, 2.0]);
    }

    #[test]
    fn an_oblique_wall_stops_a_node_on_a_symmetry_plane() {
        // x is held, the wall rises at 45° in x and y: along y alone the node must give way twice as far
        let normal = [std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::FRAC_1_SQRT_2, 0.0];
        let free = [false, true, true];
        let [_, y, z] = velocity(&RigidWall::plane([0.0; 3], normal, 0.0), [0.0, -2.0, 3.0], [0.0, 0.1, 0.0], free);
        assert!((y + 1.0).abs() < 1e-12 && z == 3.0, "{y} {z}");
        // friction acts along z, the one direction of sliding that is left, up to μ times the change along the normal
        let [_, y, z] = velocity(&RigidWall::plane([0.0; 3], normal, 0.5), [0.0, -2.0, 3.0], [0.0, 0.1, 0.0], free);
        assert!((y + 1.0).abs() < 1e-12 && (z - (3.0 - 0.5 * 2.0_f64.sqrt())).abs() < 1e-12, "{y} {z}");
    }

    #[test]
    fn a_node_held_against_a_wall_is_left_to_its_constraint() {
        let wall = RigidWall::plane([0.0; 3], UP, 0.5);
        assert_eq!(velocity(&wall, [1.0, 0.0, -2.0], [0.0; 3], [true, true, false]), [1.0, 0.0, -2.0]);
    }

    #[test]
    fn a_moving_wall_carries_along_what_sticks_to_it() {
        let curve = Curve::new(vec![[0.0, 0.0], [1.0, 5.0]], Interpolation::Linear).unwrap();
        let direction = [0.6, 0.0, 0.8];
        let motion = Some(WallMotion { direction, quantity: Quantity::Displacement, curve });
        let wall = RigidWall { motion, friction: f64::INFINITY, ..RigidWall::plane([0.0; 3], UP, 0.0) };
        let carried = velocity(&wall, [1.0, 2.0, -3.0], [0.0; 3], [true; 3]);
        let expected = [3.0, 0.0, 4.0];
        assert!(carried.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{carried:?}");
        // without friction it is pushed along the normal only
        let smooth = RigidWall { friction: 0.0, ..wall };
        let pushed = velocity(&smooth, [1.0, 2.0, -3.0], [0.0; 3], [true; 3]);
        assert!((pushed[2] - 4.0).abs() < 1e-12 && pushed[0] == 1.0 && pushed[1] == 2.0, "{pushed:?}");
    }

    #[test]
    fn a_node_on_a_symmetry_plane_ends_on_a_curved_surface_or_is_left_to_what_holds_it() {
        let shape = WallShape::Sphere { centre: [0.0; 3], radius: 1.0 };
        let wall = RigidWall { shape, friction: 0.0, motion: None };
        // z is held: the way out is along x
        let position = [0.9, 0.0, 0.5];
        let v = velocity(&wall, [-1.0, 0.0, 0.0], position, [true, true, false]);
        let end = [position[0] + 0.1 * v[0], 0.0, 0.5];
        assert!(wall.gap(&end, 0.0).abs() < 1e-14, "{end:?}");
        // nearly below the centre it would be flung out of there
        let below = [1e-3, 0.0, 0.99];
        assert_eq!(velocity(&wall, [-1.0, 0.0, 0.0], below, [true, true, false]), [-1.0, 0.0, 0.0]);
    }

    #[test]
    fn a_node_ends_on_the_surface_of_a_sphere_and_of_a_cylinder() {
        let sphere = WallShape::Sphere { centre: [1.0, 2.0, 3.0], radius: 2.0 };
        let cylinder = WallShape::Cylinder { point: [1.0, 2.0, 3.0], axis: [0.6, 0.8, 0.0], radius: 2.0 };
        for shape in [sphere, cylinder] {
            let wall = RigidWall { shape, friction: 0.0, motion: None };
            let position = [1.2, 2.1, 5.5];
            assert!(wall.gap(&position, 0.0) > 0.0);
            let v = velocity(&wall, [0.3, -0.2, -9.0], position, [true; 3]);
            let end = std::array::from_fn(|i| position[i] + 0.1 * v[i]);
            assert!(wall.gap(&end, 0.0).abs() < 1e-14, "{shape:?}: {}", wall.gap(&end, 0.0));
        }
    }
}
