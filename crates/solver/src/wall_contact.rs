//! One node against the rigid walls that it would pass within a step: which impulses stop it.
//!
//! All walls act at once, so that their order does not matter:
//! - along the normals the smallest change of velocity after which the node is behind no wall at t_{n+1};
//! - along the walls Coulomb's friction, at most μ times the normal impulse of each, against the whole of the sliding, that which
//!   a constraint or another wall imposes included.
//!
//! Only the directions that no constraint holds give way. What walls do along the others is for the constraint to take back.
//! Where friction along an imposed sliding presses the node on the wall or lifts it, the two are solved in turns.

use crate::constraints::dot;
use crate::rigid_wall::MovingWall;
use arrayvec::ArrayVec;

/// Most walls that act on one node at a time: a node that more walls press on stays behind some, and the run says so.
const MOST_WALLS: usize = 8;
/// A plane along whose normal less than this of a node is free cannot move it: sin² of 10⁻⁶ rad.
const LEAST_MOBILITY: f64 = 1e-12;
/// Of a curved tool: where less of the normal than this is free, cos² of 60°, a node would have to go far along the surface to
/// get out, and is left to what holds it.
const LEAST_MOBILITY_ON_CURVES: f64 = 0.25;
/// Changes of velocity below this share of those sought are rounding.
const ROUNDING: f64 = 1e-13;
/// Turns after which normal impulses and friction, or places on curved surfaces, are left as they are.
const MOST_TURNS: usize = 50;

/// A step of a node that walls may stop.
pub(crate) struct NodeStep {
    /// Place at t_n, m.
    pub position: [f64; 3],
    /// Δt to t_{n+1}, s.
    pub time_step: f64,
    /// The directions that no constraint holds.
    pub free: [bool; 3],
}

impl NodeStep {
    /// What rounding of places makes of velocities, m/s.
    fn noise(&self) -> f64 {
        32.0 * f64::EPSILON * norm(&self.position) / self.time_step
    }
}

/// What walls do to a node.
pub(crate) struct WallContact {
    /// The velocity after it, m/s.
    pub velocity: [f64; 3],
    /// What each wall that pushes does.
    pub pushes: ArrayVec<Push, MOST_WALLS>,
    /// The wall behind which the node gets all the same.
    pub behind: Option<Behind>,
}

/// Changes of a node's velocity by a wall, m/s; along held directions what they would be.
pub(crate) struct Push {
    /// Position of the wall.
    pub wall: usize,
    /// All of it.
    pub change: [f64; 3],
    /// The part of friction.
    pub friction: [f64; 3],
}

/// How far a node gets behind a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Behind {
    /// Position of the wall.
    pub wall: usize,
    /// Depth, m.
    pub depth: f64,
}

/// A wall that acts on the node.
struct Acting<'a> {
    place: usize,
    wall: &'a MovingWall,
    /// n at the place of the node at t_{n+1}.
    normal: [f64; 3],
    /// The least n_f · d that ends on the wall or before it, for the change d of the node's velocity, m/s.
    least: f64,
    /// λ, the normal impulse per mass, m/s.
    push: f64,
    /// τ, that of friction, m/s.
    friction: [f64; 3],
}

/// What the walls do to a node with the velocity `held`, which meets its constraints.
pub(crate) fn pushed(walls: &[MovingWall], held: &[f64; 3], step: &NodeStep) -> WallContact {
    let mut acting: ArrayVec<Acting<'_>, MOST_WALLS> = ArrayVec::new();
    let mut velocity = *held;
    loop {
        let known = acting.len();
        for (place, wall) in walls.iter().enumerate() {
            let (gap, normal) = wall.gap_new(&velocity, &step.position, step.time_step);
            if gap < 0.0
                && !acting.is_full()
                && acting.iter().all(|known| known.place != place)
                && can_move_along(wall, &normal, step.free)
            {
                acting.push(Acting { place, wall, normal, least: 0.0, push: 0.0, friction: [0.0; 3] });
            }
        }
        if acting.len() == known {
            break;
        }
        velocity = solve(&mut acting, held, step);
    }
    let pushes = acting.iter().map(|wall| {
        let change = std::array::from_fn(|i| wall.push * wall.normal[i] + wall.friction[i]);
        Push { wall: wall.place, change, friction: wall.friction }
    });
    WallContact { velocity, pushes: pushes.collect(), behind: behind(walls, &velocity, step) }
}

fn can_move_along(wall: &MovingWall, normal: &[f64; 3], free: [bool; 3]) -> bool {
    let part = only(free, normal);
    dot(&part, &part) >= if wall.is_plane() { LEAST_MOBILITY } else { LEAST_MOBILITY_ON_CURVES }
}

/// The wall that the node gets farthest behind.
fn behind(walls: &[MovingWall], velocity: &[f64; 3], step: &NodeStep) -> Option<Behind> {
    let mut deepest: Option<Behind> = None;
    for (wall, tool) in walls.iter().enumerate() {
        let depth = -tool.gap_new(velocity, &step.position, step.time_step).0;
        if depth > deepest.map_or(0.0, |deepest| deepest.depth) {
            deepest = Some(Behind { wall, depth });
        }
    }
    deepest
}

/// Normal impulses and friction of the walls that act; the velocity with them.
fn solve(acting: &mut [Acting<'_>], held: &[f64; 3], step: &NodeStep) -> [f64; 3] {
    acting.iter_mut().for_each(|wall| wall.friction = [0.0; 3]);
    let mut velocity = along_normals(acting, held, step);
    let mut last = f64::INFINITY;
    for _ in 0..MOST_TURNS {
        if !rub(acting, &velocity, step) {
            break;
        }
        let pushes: ArrayVec<f64, MOST_WALLS> = acting.iter().map(|wall| wall.push).collect();
        let rubbed = add_all(held, acting.iter().map(|wall| only(step.free, &wall.friction)));
        velocity = along_normals(acting, &rubbed, step);
        let changes = acting.iter().zip(&pushes).map(|(wall, push)| (wall.push - push).abs());
        let change = changes.fold(0.0, f64::max);
        let largest = acting.iter().map(|wall| wall.push).fold(0.0, f64::max);
        // a wedge that jams would be pressed ever harder
        if change <= ROUNDING * largest + step.noise() || change >= last {
            break;
        }
        last = change;
    }
    velocity
}

/// The smallest change of `start` along the free parts of the normals after which the node is behind none of the walls:
/// d minimises ½ |d|² with n_f · d ≥ −g/Δt on the planes that touch the surfaces at the place at t_{n+1}.
fn along_normals(acting: &mut [Acting<'_>], start: &[f64; 3], step: &NodeStep) -> [f64; 3] {
    let mut velocity = *start;
    for _ in 0..MOST_TURNS {
        for wall in acting.iter_mut() {
            let (gap, normal) = wall.wall.gap_new(&velocity, &step.position, step.time_step);
            wall.normal = normal;
            wall.least = -gap / step.time_step + dot(&normal, &minus(&velocity, start));
        }
        push(acting, step.free);
        let new = add_all(start, acting.iter().map(|wall| scaled(&only(step.free, &wall.normal), wall.push)));
        let change = norm(&minus(&new, &velocity));
        velocity = new;
        let is_settled = change <= ROUNDING * norm(&minus(&velocity, start)) + step.noise();
        if is_settled || acting.iter().all(|wall| wall.wall.is_plane()) {
            break;
        }
    }
    velocity
}

/// λ ≥ 0 of every wall: d = Σ λ n_f with n_f · d ≥ `least`, and λ = 0 where that is more than needed. Of at most three walls, as
/// few as will do; where several sets of walls would do, as in a pyramid, each has its share.
fn push(acting: &mut [Acting<'_>], free: [bool; 3]) {
    if let [wall] = acting {
        let part = only(free, &wall.normal);
        wall.push = (wall.least / dot(&part, &part)).max(0.0);
        return;
    }
    let parts: ArrayVec<[f64; 3], MOST_WALLS> = acting.iter().map(|wall| only(free, &wall.normal)).collect();
    let least: ArrayVec<f64, MOST_WALLS> = acting.iter().map(|wall| wall.least).collect();
    acting.iter_mut().for_each(|wall| wall.push = 0.0);
    if least.iter().all(|least| *least <= 0.0) {
        return;
    }
    let count = acting.len();
    let mut set_count = 0.0;
    for size in 1..=count.min(3) {
        for set in (1_u32..1 << count).filter(|set| set.count_ones() as usize == size) {
            let Some(pushes) = of_set(set, &parts, &least) else { continue };
            set_count += 1.0;
            acting.iter_mut().zip(pushes).for_each(|(wall, push)| wall.push += push);
        }
        if set_count > 0.0 {
            acting.iter_mut().for_each(|wall| wall.push /= set_count);
            return;
        }
    }
    // nothing would do, as between two tools that meet: the node stays between them
    let share = (count as f64).recip();
    for ((wall, part), least) in acting.iter_mut().zip(&parts).zip(&least) {
        wall.push = share * (least / dot(part, part)).max(0.0);
    }
}

/// The pushes with which the walls of a set alone, all of them, meet what every wall demands; none where they do not.
fn of_set(set: u32, parts: &[[f64; 3]], least: &[f64]) -> Option<[f64; MOST_WALLS]> {
    let members: ArrayVec<usize, 3> = (0..parts.len()).filter(|wall| set >> wall & 1 == 1).collect();
    let largest = least.iter().fold(0.0_f64, |largest, least| largest.max(least.abs()));
    // G λ = b with G_ij = n_i · n_j, by Gauss
    let count = members.len();
    let mut rows = [[0.0; 4]; 3];
    for (row, &i) in rows.iter_mut().zip(&members) {
        for (entry, &j) in row.iter_mut().zip(&members) {
            *entry = dot(&parts[i], &parts[j]);
        }
        row[3] = least[i];
    }
    for pivot in 0..count {
        if rows[pivot][pivot] < 1e-9 * dot(&parts[members[pivot]], &parts[members[pivot]]) {
            return None;
        }
        for below in pivot + 1..count {
            let factor = rows[below][pivot] / rows[pivot][pivot];
            let above = rows[pivot];
            rows[below].iter_mut().zip(above).for_each(|(entry, above)| *entry -= factor * above);
        }
    }
    let mut pushes = [0.0; MOST_WALLS];
    for row in (0..count).rev() {
        let known: f64 = (row + 1..count).map(|later| rows[row][later] * pushes[members[later]]).sum();
        pushes[members[row]] = (rows[row][3] - known) / rows[row][row];
    }
    let change = add_all(&[0.0; 3], parts.iter().zip(pushes).map(|(part, push)| scaled(part, push)));
    let does = members.iter().all(|&wall| pushes[wall] >= 0.0)
        && parts.iter().zip(least).all(|(part, least)| dot(part, &change) >= least - 1e-12 * largest);
    does.then_some(pushes)
}

/// Friction of the walls that push, for the normal impulses that they have and the velocity with these and with the friction so
/// far; whether there is any.
fn rub(acting: &mut [Acting<'_>], velocity: &[f64; 3], step: &NodeStep) -> bool {
    let axes = pushed_axes(acting, step.free);
    let rubbing = acting.iter().filter(|wall| wall.push > 0.0 && wall.wall.friction() > 0.0).count();
    if rubbing == 0 {
        return false;
    }
    // several walls rub at once: each turn takes the mean of what each would do alone
    let share = (rubbing as f64).recip();
    let mut velocity = *velocity;
    for _ in 0..MOST_TURNS {
        let mut turned = [0.0; 3];
        let mut largest = 0.0_f64;
        for wall in acting.iter_mut().filter(|wall| wall.push > 0.0 && wall.wall.friction() > 0.0) {
            let alone = wall.friction_alone(&velocity, &axes, step);
            let change: [f64; 3] = std::array::from_fn(|i| share * (alone[i] - wall.friction[i]));
            wall.friction = std::array::from_fn(|i| wall.friction[i] + change[i]);
            turned = std::array::from_fn(|i| turned[i] + change[i]);
            largest = largest.max(norm(&wall.friction));
        }
        velocity = add_all(&velocity, [across(&axes, &only(step.free, &turned))]);
        if rubbing == 1 || norm(&turned) <= ROUNDING * largest {
            break;
        }
    }
    acting.iter().any(|wall| wall.friction != [0.0; 3])
}

impl Acting<'_> {
    /// τ of Coulomb's friction against the sliding u = (I − n nᵀ)(v − V) with the velocity V of the wall. Of u friction can change
    /// the part u_r that neither a constraint nor a wall imposes; u_0 is imposed. τ minimises ½ |τ_r|² + τ · u within
    /// |τ| ≤ μ λ: τ_r = −u_r/(1 + κ), τ_0 = −u_0/κ, where u is the sliding without this friction.
    fn friction_alone(&self, velocity: &[f64; 3], axes: &ArrayVec<[f64; 3], 3>, step: &NodeStep) -> [f64; 3] {
        let free = step.free;
        let relative = minus(velocity, self.wall.velocity());
        let approach = dot(&relative, &self.normal);
        let sliding: [f64; 3] = std::array::from_fn(|i| relative[i] - approach * self.normal[i]);
        let own = across(axes, &only(free, &self.friction));
        let resisted = minus(&across(axes, &only(free, &sliding)), &own);
        let imposed = minus(&minus(&sliding, &own), &resisted);
        let (resisted_speed, imposed_speed) = (norm(&resisted), norm(&imposed));
        let limit = self.wall.friction() * self.push;
        // what rounding leaves of a sliding is none
        let noise = ROUNDING * (norm(velocity) + norm(self.wall.velocity()) + self.push) + step.noise();
        if imposed_speed <= noise || limit.is_infinite() {
            let slowed = if resisted_speed > limit { limit / resisted_speed } else { 1.0 };
            return scaled(&resisted, -slowed);
        }
        // κ of |u_r|²/(1 + κ)² + |u_0|²/κ² = (μ λ)², convex and falling: Newton's steps from the left stay on the left
        let mut kappa = imposed_speed / limit;
        for _ in 0..MOST_TURNS {
            let (a, b) = (resisted_speed / (1.0 + kappa), imposed_speed / kappa);
            let (value, slope) = (a * a + b * b - limit * limit, -2.0 * (a * a / (1.0 + kappa) + b * b / kappa));
            let change = value / slope;
            kappa -= change;
            if change.abs() <= ROUNDING * kappa {
                break;
            }
        }
        std::array::from_fn(|i| -resisted[i] / (1.0 + kappa) - imposed[i] / kappa)
    }
}

/// An orthonormal basis of the free parts of the normals of the walls that push.
fn pushed_axes(acting: &[Acting<'_>], free: [bool; 3]) -> ArrayVec<[f64; 3], 3> {
    let mut axes: ArrayVec<[f64; 3], 3> = ArrayVec::new();
    for wall in acting.iter().filter(|wall| wall.push > 0.0) {
        let part = only(free, &wall.normal);
        let rest = across(&axes, &across(&axes, &part));
        let length = norm(&rest);
        if length > 1e-6 * norm(&part) && !axes.is_full() {
            axes.push(scaled(&rest, length.recip()));
        }
    }
    axes
}

/// The part of a vector across all of the axes.
#[inline]
fn across(axes: &ArrayVec<[f64; 3], 3>, vector: &[f64; 3]) -> [f64; 3] {
    axes.iter().fold(*vector, |rest, axis| {
        let along = dot(&rest, axis);
        std::array::from_fn(|i| rest[i] - along * axis[i])
    })
}

/// The free components of a vector.
#[inline]
fn only(free: [bool; 3], vector: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| if free[i] { vector[i] } else { 0.0 })
}

#[inline]
fn add_all(start: &[f64; 3], vectors: impl IntoIterator<Item = [f64; 3]>) -> [f64; 3] {
    vectors.into_iter().fold(*start, |sum, vector| std::array::from_fn(|i| sum[i] + vector[i]))
}

#[inline]
fn minus(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

#[inline]
fn scaled(vector: &[f64; 3], factor: f64) -> [f64; 3] {
    vector.map(|component| factor * component)
}

#[inline]
fn norm(vector: &[f64; 3]) -> f64 {
    dot(vector, vector).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::{Curve, Interpolation};
    use crate::model::{Quantity, RigidWall, WallMotion, WallShape};

    const UP: [f64; 3] = [0.0, 0.0, 1.0];
    const STEP: f64 = 0.1;

    fn contact(walls: &[RigidWall], velocity: [f64; 3], position: [f64; 3], free: [bool; 3]) -> WallContact {
        let prepared = |wall: &RigidWall| {
            let mut wall = MovingWall::new(wall.clone());
            wall.prepare(0.0, [0.0, STEP], 0.0);
            wall
        };
        let walls: Vec<MovingWall> = walls.iter().map(prepared).collect();
        pushed(&walls, &velocity, &NodeStep { position, time_step: STEP, free })
    }

    fn velocity(wall: &RigidWall, velocity: [f64; 3], position: [f64; 3], free: [bool; 3]) -> [f64; 3] {
        contact(std::slice::from_ref(wall), velocity, position, free).velocity
    }

    #[track_caller]
    fn assert_near(value: [f64; 3], expected: [f64; 3]) {
        assert!(value.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{value:?} in place of {expected:?}");
    }

    fn belt(friction: f64, velocity: [f64; 3]) -> RigidWall {
        let speed = norm(&velocity);
        let curve = Curve::new(vec![[0.0, speed]], Interpolation::Linear).unwrap();
        let motion = WallMotion { direction: scaled(&velocity, speed.recip()), quantity: Quantity::Velocity, curve };
        RigidWall { motion: Some(motion), ..RigidWall::plane([0.0; 3], UP, friction) }
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
    }

    /// y is driven and nothing else moves the node along the wall: of the friction μ λ its share of the sliding is along x, which
    /// brakes x as fast as its share of the sliding falls.
    #[test]
    fn friction_works_against_the_whole_sliding_driven_directions_included() {
        let wall = RigidWall::plane([0.0; 3], UP, 0.5);
        let done = contact(std::slice::from_ref(&wall), [0.3, 1.0, -2.0], [0.0; 3], [true, false, true]);
        let [x, y, z] = done.velocity;
        // μ λ = 1 m/s against the sliding (x, 1) that is left
        let of_x = x / x.hypot(1.0);
        assert!((0.3 - x - of_x).abs() < 1e-12 && y == 1.0 && z == 0.0, "{x} {y} {z}");
        let friction = done.pushes[0].friction;
        assert!((norm(&friction) - 1.0).abs() < 1e-12, "{friction:?}");
        assert!((friction[1] + 1.0 / x.hypot(1.0)).abs() < 1e-12, "{friction:?}");
    }

    #[test]
    fn a_belt_rubs_on_a_node_that_is_held_with_all_of_its_friction() {
        let done = contact(&[belt(0.5, [3.0, 4.0, 0.0])], [0.0, 0.0, -2.0], [0.0; 3], [false, false, true]);
        assert_near(done.velocity, [0.0; 3]);
        assert_near(done.pushes[0].friction, [0.6, 0.8, 0.0]);
    }

    /// A wedge: x is driven along a slope of 45°, so that y rises with it. Friction along the slope presses the node on it, and the
    /// normal impulse is 1/(1 − μ) of that without friction. Source: equilibrium along y, λ/√2 − μ λ/√2 = the change of y.
    #[test]
    fn friction_on_a_wedge_raises_what_presses_on_it() {
        let normal = [-std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::FRAC_1_SQRT_2, 0.0];
        let wall = RigidWall::plane([0.0; 3], normal, 0.25);
        let done = contact(std::slice::from_ref(&wall), [1.0, -0.5, 0.0], [0.0; 3], [false, true, true]);
        assert_near(done.velocity, [1.0, 1.0, 0.0]);
        let push = &done.pushes[0];
        let friction = norm(&push.friction);
        let normal_push = dot(&push.change, &normal);
        assert!((normal_push - 1.5 * 2.0_f64.sqrt() / 0.75).abs() < 1e-10, "{normal_push}");
        assert!((friction - 0.25 * normal_push).abs() < 1e-10, "{friction}");
    }

    #[test]
    fn a_node_held_against_a_wall_gets_behind_it_and_that_is_told() {
        let wall = RigidWall::plane([0.0; 3], UP, 0.5);
        let done = contact(std::slice::from_ref(&wall), [1.0, 0.0, -2.0], [0.0; 3], [true, true, false]);
        assert_eq!(done.velocity, [1.0, 0.0, -2.0]);
        let behind = done.behind.unwrap();
        assert!(behind.wall == 0 && (behind.depth - 0.2).abs() < 1e-15, "{behind:?}");
    }

    #[test]
    fn a_moving_wall_carries_along_what_sticks_to_it() {
        let curve = Curve::new(vec![[0.0, 0.0], [1.0, 5.0]], Interpolation::Linear).unwrap();
        let direction = [0.6, 0.0, 0.8];
        let motion = Some(WallMotion { direction, quantity: Quantity::Displacement, curve });
        let wall = RigidWall { motion, friction: f64::INFINITY, ..RigidWall::plane([0.0; 3], UP, 0.0) };
        assert_near(velocity(&wall, [1.0, 2.0, -3.0], [0.0; 3], [true; 3]), [3.0, 0.0, 4.0]);
        // without friction it is pushed along the normal only
        let smooth = RigidWall { friction: 0.0, ..wall };
        assert_near(velocity(&smooth, [1.0, 2.0, -3.0], [0.0; 3], [true; 3]), [1.0, 2.0, 4.0]);
    }

    #[test]
    fn a_node_on_a_symmetry_plane_ends_on_a_curved_surface_or_is_left_to_what_holds_it() {
        let shape = WallShape::Sphere { centre: [0.0; 3], radius: 1.0 };
        let wall = RigidWall { shape, friction: 0.0, motion: None };
        // z is held: the way out is along x
        let position = [0.9, 0.0, 0.5];
        let v = velocity(&wall, [-1.0, 0.0, 0.0], position, [true, true, false]);
        let end = [position[0] + STEP * v[0], 0.0, 0.5];
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
            let end = std::array::from_fn(|i| position[i] + STEP * v[i]);
            assert!(wall.gap(&end, 0.0).abs() < 1e-14, "{shape:?}: {}", wall.gap(&end, 0.0));
        }
    }

    /// Two planes that rise at ±30°: a groove of 120° along y.
    fn groove(friction: f64) -> [RigidWall; 2] {
        let (sin, cos) = (0.5, 0.75_f64.sqrt());
        [[sin, 0.0, cos], [-sin, 0.0, cos]].map(|normal| RigidWall::plane([0.0; 3], normal, friction))
    }

    #[test]
    fn a_node_that_falls_into_a_groove_gets_equal_impulses_and_is_behind_no_wall() {
        let done = contact(&groove(0.0), [0.0, 0.5, -1.0], [0.0, 0.0, 0.02], [true; 3]);
        assert_near(done.velocity, [0.0, 0.5, -0.2]);
        let [left, right] = [0, 1].map(|wall| norm(&done.pushes[wall].change));
        // 2 λ cos 30° = 0.8
        assert!((left - 0.8 / 3.0_f64.sqrt()).abs() < 1e-14 && (right - left).abs() < 1e-15, "{left} {right}");
        assert!(done.behind.is_none_or(|behind| behind.depth < 1e-15));
        // both rub along the groove: 2 μ λ
        let done = contact(&groove(0.1), [0.0, 0.5, -1.0], [0.0, 0.0, 0.0], [true; 3]);
        assert_near(done.velocity, [0.0, 0.5 - 0.2 / 3.0_f64.sqrt(), 0.0]);
        let [left, right] = [0, 1].map(|wall| done.pushes[wall].friction[1]);
        assert!(left < 0.0 && (left - right).abs() < 1e-14, "{left} {right}");
    }

    #[test]
    fn the_order_of_walls_in_a_corner_does_not_matter() {
        let normals = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.48, 0.6, 0.64], [0.0, 0.6, -0.8]];
        for friction in [0.0, 0.3, f64::INFINITY] {
            for [a, b, c] in [[0, 1, 2], [0, 3, 4], [1, 2, 3], [2, 3, 4]] {
                let walls = |order: [usize; 3]| order.map(|i| RigidWall::plane([0.0; 3], normals[i], friction));
                let position = [0.0, 0.0, 0.0];
                let fall = [-1.0, -0.7, -0.4];
                let done = contact(&walls([a, b, c]), fall, position, [true; 3]);
                for order in [[a, c, b], [b, a, c], [b, c, a], [c, a, b], [c, b, a]] {
                    let other = contact(&walls(order), fall, position, [true; 3]);
                    let difference = norm(&minus(&done.velocity, &other.velocity));
                    assert!(difference < 1e-12, "{friction} {order:?}: {:?} {:?}", done.velocity, other.velocity);
                }
                let depth = done.behind.map_or(0.0, |behind| behind.depth);
                assert!(depth < 1e-12, "{friction} {a} {b} {c}: {depth:e}");
            }
        }
    }

    #[test]
    fn walls_that_are_given_twice_share_the_impulse() {
        let wall = RigidWall::plane([0.0; 3], UP, 0.5);
        let done = contact(&[wall.clone(), wall], [3.0, 0.0, -2.0], [0.0; 3], [true; 3]);
        assert_near(done.velocity, [2.0, 0.0, 0.0]);
        assert_near(done.pushes[0].change, done.pushes[1].change);
    }
}
