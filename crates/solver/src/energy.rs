//! The energy ledger: every joule has a row.

use crate::constraints::dot;

/// Energies at one time, in J.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Energies {
    /// Kinetic energy at time 0.
    pub initial_kinetic: f64,
    /// Kinetic energy Σ ½ m |v_n|² of the nodal velocities v_n = v_{n+½} − ½ Δt_{n+½} a_n.
    pub kinetic: f64,
    /// Stress power at the quadrature points ∫∫ T : D dV dt, elastic and plastic.
    pub internal: f64,
    /// The part of it that plastic flow has dissipated, in deleted elements too.
    pub plastic_dissipation: f64,
    /// The part of that which has heated materials that have a temperature; the rest stays in the defects of the metal.
    pub heat: f64,
    /// Work against bulk viscosity.
    pub viscous: f64,
    /// Work against hourglass control, of deleted elements too.
    pub hourglass: f64,
    /// Stress power that deleted elements had taken, `internal` no more.
    pub deleted: f64,
    /// Work of each load of the model.
    pub load_work: Vec<f64>,
    /// Work of the constraints that move: prescribed motions.
    pub constraint_work: f64,
    /// Work of each rigid wall that moves, J.
    pub wall_work: Vec<f64>,
    /// Energy that contact with rigid walls has taken, by impact and by friction.
    pub contact: f64,
    /// The part of that which friction has taken.
    pub friction: f64,
    /// Work against damping in proportion to mass.
    pub damping: f64,
    /// The part of `kinetic` that is the motion of mass added by mass scaling.
    pub mass_scaling: f64,
    /// What central differences keep beside the kinetic energy, from nothing at the start on: they conserve
    /// ½ m (|v_n|² − ¼ Δt² |a_n|²) in place of ½ m |v_n|² while the step is constant, and a step that grows or shrinks moves
    /// energy between the two. With the impulse I = Δt̄ f_n of the forces of elements and loads, Δv = v_{n+½} − v_{n−½} and
    /// s = ½ Δt_{n−½}/Δt̄ the row is Σ ½ ((1 − s)² − s²) I · Δv over the times before, and −½ s² I · Δv of t_n.
    ///
    /// It is of second order in the step and means nothing physical, but at a start under load it is the kinetic energy of the
    /// first step: without this row a body that falls from rest would be 25 % off balance then.
    pub integration: f64,
    /// Largest kinetic over internal energy since a tenth of the time: small where inertia plays no part.
    pub kinetic_share: f64,
    /// The largest energy that has been in play so far, what came in or what was there: the measure of
    /// [`Energies::error`]. It begins at the elastic energy of a strain of 10⁻⁹ everywhere.
    pub in_play: f64,
}

/// Energies below that of this strain (or of a velocity of this fraction of the speed of sound) are not judged:
/// coordinates have 16 digits, so that a strain taken from them is rounded at 10⁻¹³ where elements are a thousand times
/// smaller than the body.
const SMALLEST_STRAIN: f64 = 1e-9;

impl Energies {
    /// Work of the outside on the body: loads, prescribed motions, and walls that move.
    pub fn external_work(&self) -> f64 {
        self.load_work.iter().sum::<f64>() + self.constraint_work + self.wall_work.iter().sum::<f64>()
    }

    /// What should be there: initial energy and external work.
    fn came_in(&self) -> f64 {
        self.initial_kinetic + self.external_work()
    }

    /// Where it went.
    fn is_there(&self) -> f64 {
        self.kinetic + self.internal + self.deleted + self.viscous + self.hourglass + self.contact + self.damping
    }

    /// Kinetic + internal + deleted + viscous + hourglass + contact + damping + integration − external work − initial.
    pub fn imbalance(&self) -> f64 {
        self.is_there() + self.integration - self.came_in()
    }

    /// The imbalance as a fraction of the largest energy in play so far.
    ///
    /// The rows are computed independently of one another (internal energy is the stress power at the points, not the
    /// work of nodal forces), so that this is a check and no identity; it is of second order in the time step. An
    /// imbalance is left by the energy that flowed, and stays when that flows out again: a spring pulled and let back
    /// has nearly no energy, and would be far off balance if it were measured by what it has now.
    pub fn error(&self) -> f64 {
        if self.in_play > 0.0 { self.imbalance() / self.in_play } else { 0.0 }
    }

    /// The ledger before anything has moved; `elastic_scale` is Σ V (k + 4μ/3), J.
    pub(crate) fn new(initial_kinetic: f64, elastic_scale: f64, load_count: usize, wall_count: usize) -> Self {
        let floor = 0.5 * elastic_scale * SMALLEST_STRAIN * SMALLEST_STRAIN;
        let in_play = initial_kinetic.max(floor);
        Self {
            initial_kinetic,
            kinetic: initial_kinetic,
            in_play,
            load_work: vec![0.0; load_count],
            wall_work: vec![0.0; wall_count],
            ..Self::default()
        }
    }

    /// Kinetic over internal energy; not a number while there is neither.
    pub fn kinetic_over_internal(&self) -> f64 {
        self.kinetic / self.internal
    }

    /// Notes the energy in play now, and the kinetic share if the time has come to judge it.
    pub(crate) fn note_in_play(&mut self, is_judged: bool) {
        self.in_play = self.in_play.max(self.came_in().abs()).max(self.is_there().abs());
        if is_judged && self.internal > 0.0 {
            self.kinetic_share = self.kinetic_share.max(self.kinetic_over_internal());
        }
    }
}

/// A sum of works that is centred in time: a part of what is done at t_n belongs to the time before, the rest to the time after.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct CentredWork {
    /// Work up to t_n.
    pub until_now: f64,
    /// Work that belongs to the step that begins at t_n.
    pub begun: f64,
}

impl CentredWork {
    /// Enters the works of a new t_n: before it and after it.
    pub fn enter(&mut self, [before, after]: [f64; 2]) {
        self.until_now += self.begun + before;
        self.begun = after;
    }
}

/// A velocity on its way from t_{n−½} over t_n to t_{n+½}: linear in time, as its impulses act.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Passage {
    /// v_n = v_{n−½} + s Δv, m/s.
    pub now: [f64; 3],
    /// Δv = v_{n+½} − v_{n−½}, m/s.
    pub change: [f64; 3],
    /// s, the share of the time that lies before t_n.
    pub share_old: f64,
    /// s times the mean velocity before t_n, m/s.
    before: [f64; 3],
    /// 1 − s times the mean velocity after t_n, m/s.
    after: [f64; 3],
}

impl Passage {
    #[inline]
    pub fn new(old: &[f64; 3], new: &[f64; 3], share_old: f64) -> Self {
        let change: [f64; 3] = std::array::from_fn(|i| new[i] - old[i]);
        let now: [f64; 3] = std::array::from_fn(|i| old[i] + share_old * change[i]);
        let before = std::array::from_fn(|i| 0.5 * share_old * (old[i] + now[i]));
        let after = std::array::from_fn(|i| 0.5 * (1.0 - share_old) * (now[i] + new[i]));
        Self { now, change, share_old, before, after }
    }

    /// The works of an impulse (N s) before t_n and after it, J: together I · ½ (v_{n−½} + v_{n+½}).
    #[inline]
    pub fn works(&self, impulse: &[f64; 3]) -> [f64; 2] {
        [dot(impulse, &self.before), dot(impulse, &self.after)]
    }
}

#[cfg(test)]
mod tests {
    use crate::curve::{Curve, Interpolation};
    use crate::model::{
        Direction, Fix, Formulation, InitialVelocity, Load, LoadKind, Model, Part, Prescribed, Quantity, RigidWall,
        TimeSettings, WallMotion,
    };
    use crate::{LaneLevel, Simulation};
    use estar_material::{Elastic, ElasticConstant, IsotropicElasticity};
    use estar_mesh::generate::{BoxSpec, box_mesh};

    const SPEED: f64 = 10.0;
    const SIDE: f64 = 0.01;

    /// A steel cube that is drawn up at its top at a constant speed while a plane comes down on a side of it, under its weight and
    /// mass damping.
    fn cube(safety_factor: f64) -> Simulation {
        let mesh = box_mesh(&BoxSpec::new([SIDE; 3], [2, 2, 2]).unwrap());
        let nodes = |group: &str| mesh.group(group).unwrap().nodes.clone();
        let constants = (ElasticConstant::YoungModulus(200e9), ElasticConstant::PoissonRatio(0.3));
        let steel = IsotropicElasticity::new(7850.0, constants.0, constants.1).unwrap();
        let steadily = || Curve::new(vec![[0.0, SPEED]], Interpolation::Linear).unwrap();
        let motion = WallMotion { direction: [-1.0, 0.0, 0.0], quantity: Quantity::Velocity, curve: steadily() };
        let model = Model {
            parts: vec![Part {
                elements: (0..mesh.element_count() as u32).collect(),
                material: Elastic::new(steel).into(),
                element: Formulation::BBar,
            }],
            fixes: vec![Fix { nodes: nodes("z_min"), directions: vec![Direction::Z] }],
            prescribed: vec![Prescribed {
                nodes: nodes("z_max"),
                direction: Direction::Z,
                quantity: Quantity::Velocity,
                curve: steadily(),
            }],
            initial_velocities: vec![InitialVelocity {
                nodes: (0..mesh.node_count() as u32).collect(),
                translation: [2.0, 1.0, 3.0],
                spin: None,
            }],
            loads: vec![Load { name: "weight".to_owned(), kind: LoadKind::Gravity { acceleration: [0.0, 1e5, 0.0] } }],
            walls: vec![RigidWall {
                motion: Some(motion),
                ..RigidWall::plane([SIDE, 0.0, 0.0], [-1.0, 0.0, 0.0], 0.1)
            }],
            settings: TimeSettings { end: 40e-6, safety_factor, mass_damping: 2e4, ..TimeSettings::default() },
        };
        Simulation::new(&mesh, model, LaneLevel::best()).unwrap()
    }

    /// Runs it with steps that are a random share, up to `largest`, of the stable one; the worst energy error.
    fn worst_error(largest: f64, mut visit: impl FnMut(&Simulation)) -> f64 {
        let mut simulation = cube(largest);
        let mut random = 12_345_u64;
        let mut worst = 0.0_f64;
        while !simulation.is_finished() {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            simulation.settings.safety_factor = largest * (0.2 + 0.8 * (random >> 11) as f64 / (1_u64 << 53) as f64);
            simulation.advance().unwrap();
            worst = worst.max(simulation.energies().error().abs());
            visit(&simulation);
        }
        worst
    }

    /// With steps that change at random the kinetic energy is that of the nodal velocities, the work of what drives and of the wall
    /// is that of their forces, and the balance closes to second order of the step.
    #[test]
    fn rows_are_right_and_balance_with_steps_that_change_at_random() {
        let (mut driven_work, mut wall_work) = (0.0, 0.0);
        let mut before: Option<(f64, f64)> = None;
        let worst = worst_error(0.9, |now| {
            let energies = now.energies();
            let of_node = |node: usize| now.velocity(node).map(|v| 0.5 * now.mass()[node] * v * v).iter().sum::<f64>();
            let kinetic: f64 = (0..now.mass().len()).map(of_node).sum();
            assert!((energies.kinetic - kinetic).abs() <= 1e-12 * kinetic, "{} {kinetic}", energies.kinetic);
            let top: Vec<u32> = (0..).zip(now.reference()).filter(|(_, x)| x[2] > 0.9 * SIDE).map(|(n, _)| n).collect();
            let forces = (now.reaction(&top, Direction::Z), -now.wall_force(0)[0]);
            if let Some(old) = before {
                driven_work += 0.5 * now.time_step() * SPEED * (old.0 + forces.0);
                wall_work += 0.5 * now.time_step() * SPEED * (old.1 + forces.1);
                let (constraints, walls) = (energies.constraint_work, energies.wall_work[0]);
                assert!((constraints - driven_work).abs() <= 1e-9 * driven_work.abs(), "{constraints} {driven_work}");
                assert!((walls - wall_work).abs() <= 1e-9 * wall_work.abs(), "{walls} {wall_work}");
            } else {
                // what the nodes brought to time 0 is booked there
                (driven_work, wall_work) = (energies.constraint_work, energies.wall_work[0]);
            }
            before = Some(forces);
            assert!(energies.damping >= 0.0, "{energies:?}");
        });
        let halved = worst_error(0.45, |_| {});
        println!("{worst:e} {halved:e}");
        assert!(worst < 1e-3 && halved < 0.4 * worst, "{worst:e} {halved:e}");
    }
}
