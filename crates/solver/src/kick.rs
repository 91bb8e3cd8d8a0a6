//! What changes the velocity of one node at t_n: forces, damping, what holds or drives it, and walls.

use crate::constraints::{Constraints, dot};
use crate::energy::Passage;
use crate::rigid_wall::MovingWall;
use crate::wall_contact::{Behind, NodeStep, WallContact, pushed};

/// What a kick needs besides the node itself.
pub(crate) struct Kick<'a> {
    /// Δt̄ = ½ (Δt_{n−½} + Δt_{n+½}), s.
    pub mean_step: f64,
    /// Δt_{n+½}, s.
    pub step_new: f64,
    /// s = ½ Δt_{n−½}/Δt̄: where t_n lies between the half steps.
    pub share_old: f64,
    /// ½ α Δt̄ of the damping −α m ½ (v_{n−½} + v_{n+½}).
    pub damping: f64,
    pub constraints: &'a Constraints,
    pub walls: &'a [MovingWall],
}

/// A node and where it is.
pub(crate) struct Place<'a> {
    pub node: usize,
    pub reference: &'a [f64; 3],
    pub displacement: &'a [f64; 3],
}

/// What a kick does to a node.
pub(crate) struct Moved {
    /// v_{n+½}, m/s.
    pub velocity: [f64; 3],
    /// None at a node that neither a constraint nor a wall holds.
    pub impulses: Option<Impulses>,
}

/// Impulses on a node that is not free, N s.
pub(crate) struct Impulses {
    /// Of held and driven directions.
    pub of_constraints: [f64; 3],
    pub of_walls: [f64; 3],
    /// Work of the friction of walls on the sliding of the node, before t_n and after it, J.
    pub friction_work: [f64; 2],
    /// The wall behind which constraints take the node, if they do.
    pub behind: Option<Behind>,
}

impl Kick<'_> {
    /// The velocity of a node after the forces of t_n, and what held it. The impulses of walls are added to `wall_impulses`.
    #[inline]
    pub fn moved(
        &self,
        place: &Place<'_>,
        mass: f64,
        force: &[f64; 3],
        velocity_old: &[f64; 3],
        wall_impulses: &mut [[f64; 3]],
    ) -> Moved {
        // v_{n+½} = v_{n−½} + Δt̄ f_n / m, with f_n − α m ½ (v_{n−½} + v_{n+½}) in place of f_n
        let scale = self.mean_step / mass;
        let undamped: [f64; 3] = std::array::from_fn(|i| velocity_old[i] + scale * force[i]);
        let free = if self.damping > 0.0 {
            let share = self.damping / (1.0 + self.damping);
            std::array::from_fn(|i| undamped[i] - share * (velocity_old[i] + undamped[i]))
        } else {
            undamped
        };
        let is_held = self.constraints.constrain(place.node);
        let position: [f64; 3] = std::array::from_fn(|i| place.reference[i] + place.displacement[i]);
        if !is_held && !self.walls.iter().any(|wall| wall.stops(&free, &position, self.step_new)) {
            return Moved { velocity: free, impulses: None };
        }
        let directions = self.constraints.free_directions(place.node);
        let step = NodeStep { position, time_step: self.step_new, free: directions };
        let held = self.constraints.velocity(place.node, free, place.displacement, self.step_new);
        let contact = pushed(self.walls, &held, &step);
        let impulses = self.impulses(mass, force, velocity_old, directions, &contact, wall_impulses);
        Moved { velocity: contact.velocity, impulses: Some(impulses) }
    }

    fn impulses(
        &self,
        mass: f64,
        force: &[f64; 3],
        velocity_old: &[f64; 3],
        free: [bool; 3],
        contact: &WallContact,
        wall_impulses: &mut [[f64; 3]],
    ) -> Impulses {
        let passage = Passage::new(velocity_old, &contact.velocity, self.share_old);
        // damping weighs on what an impulse changes, too: (1 + ½ α Δt̄) m Δv = I
        let damped_mass = (1.0 + self.damping) * mass;
        let (mut of_walls, mut friction_work) = ([0.0; 3], [0.0; 2]);
        for push in &contact.pushes {
            let (wall, impulse) = (&self.walls[push.wall], push.change.map(|change| damped_mass * change));
            let friction = push.friction.map(|change| damped_mass * change);
            let (on_node, on_wall) = (passage.works(&friction), wall.passage().works(&friction));
            for i in 0..3 {
                wall_impulses[push.wall][i] += impulse[i];
                of_walls[i] += impulse[i];
            }
            friction_work = std::array::from_fn(|side| friction_work[side] + on_node[side] - on_wall[side]);
        }
        // what neither forces nor damping nor walls did the constraints did
        let damping = self.damping_impulse(mass, velocity_old, &contact.velocity);
        let of_constraints = std::array::from_fn(|i| {
            let change = contact.velocity[i] - velocity_old[i];
            if free[i] { 0.0 } else { mass * change - self.mean_step * force[i] - damping[i] - of_walls[i] }
        });
        Impulses { of_constraints, of_walls, friction_work, behind: contact.behind }
    }

    /// −α m ½ (v_{n−½} + v_{n+½}) Δt̄ with the velocities that constraints and walls leave, N s.
    #[inline]
    pub fn damping_impulse(&self, mass: f64, old: &[f64; 3], new: &[f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| -self.damping * mass * (old[i] + new[i]))
    }
}

/// Sums over the nodes of a chunk.
#[derive(Clone, Copy, Default)]
pub(crate) struct NodeSums {
    /// Σ ½ m |v_n|², J.
    pub kinetic: f64,
    /// The part of it that is of added mass, J.
    pub added_kinetic: f64,
    /// Works before t_n and after it, J.
    pub integration: [f64; 2],
    pub constraint_work: [f64; 2],
    pub contact_work: [f64; 2],
    pub friction_work: [f64; 2],
    pub damping_work: [f64; 2],
    /// The node farthest behind a wall that constraints take it through.
    pub behind: Option<(Behind, usize)>,
}

impl NodeSums {
    /// Enters the kinetic energy of a node at t_n, and what central differences leave open there; that energy.
    #[inline]
    pub fn enter(&mut self, mass: f64, impulse_of_forces: &[f64; 3], passage: &Passage) -> f64 {
        let kinetic = 0.5 * mass * dot(&passage.now, &passage.now);
        self.kinetic += kinetic;
        // The work of a force is ½ Δt_{n−½} f_n · v_{n−½} before t_n and ½ Δt_{n+½} f_n · v_{n+½} after it. Of what its impulse
        // gives the node that is ½ s² I · Δv too little before and ½ (1 − s)² I · Δv too much after.
        let change = dot(impulse_of_forces, &passage.change);
        let (s, t) = (passage.share_old, 1.0 - passage.share_old);
        add(&mut self.integration, [-0.5 * s * s * change, 0.5 * t * t * change]);
        kinetic
    }

    /// Enters the works of the impulses on a node that is held.
    #[inline]
    pub fn enter_impulses(&mut self, node: usize, impulses: &Impulses, passage: &Passage) {
        add(&mut self.constraint_work, passage.works(&impulses.of_constraints));
        add(&mut self.contact_work, passage.works(&impulses.of_walls));
        add(&mut self.friction_work, impulses.friction_work);
        if let Some(behind) = impulses.behind {
            self.note_behind(behind, node);
        }
    }

    /// Enters the work of damping.
    #[inline]
    pub fn enter_damping(&mut self, impulse: &[f64; 3], passage: &Passage) {
        add(&mut self.damping_work, passage.works(impulse));
    }

    fn note_behind(&mut self, behind: Behind, node: usize) {
        if self.behind.is_none_or(|(deepest, _)| behind.depth > deepest.depth) {
            self.behind = Some((behind, node));
        }
    }

    /// The sums of two chunks, of which `other` comes after.
    pub fn plus(mut self, other: Self) -> Self {
        self.kinetic += other.kinetic;
        self.added_kinetic += other.added_kinetic;
        add(&mut self.integration, other.integration);
        add(&mut self.constraint_work, other.constraint_work);
        add(&mut self.contact_work, other.contact_work);
        add(&mut self.friction_work, other.friction_work);
        add(&mut self.damping_work, other.damping_work);
        if let Some((behind, node)) = other.behind {
            self.note_behind(behind, node);
        }
        self
    }
}

#[inline]
fn add(sum: &mut [f64; 2], works: [f64; 2]) {
    sum[0] += works[0];
    sum[1] += works[1];
}
