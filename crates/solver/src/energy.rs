//! The energy ledger: every joule has a row.

/// Energies at one time, in J.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Energies {
    /// Kinetic energy at time 0.
    pub initial_kinetic: f64,
    /// Kinetic energy Σ ½ m v_{n−½} · (v_{n−½} + Δt_{n−½} a_n): with equal steps ½ m v_{n−½} · v_{n+½}.
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
    /// What `kinetic` does not hold since the step has changed, from nothing at the start on:
    /// Σ (½ − s) Δt̄ f · (v_{n+½} − v_{n−½}) over all times, with the mean step Δt̄ and s = ½ Δt_{n−½}/Δt̄.
    ///
    /// Central differences keep ½ m (|v_n|² − ¼ Δt² |a_n|²) in place of ½ m |v_n|², so that a step that grows costs
    /// ⅛ m |a|² times the growth of Δt². It is of second order, but at a start under load it is the kinetic energy of the
    /// first step: without this row a body that falls from rest would be 25 % off balance then.
    pub step_change: f64,
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

    /// Kinetic + internal + deleted + viscous + hourglass + contact + damping + step change − external work − initial.
    pub fn imbalance(&self) -> f64 {
        self.is_there() + self.step_change - self.came_in()
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

/// A sum of works f_n · Δx that is centred in time: half of each force's work belongs to the step before, half to the
/// step after.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct CentredWork {
    /// Work up to t_n.
    pub until_now: f64,
    /// Work that belongs to the step that begins at t_n.
    pub begun: f64,
}

impl CentredWork {
    /// Enters the forces of a new t_n: their work over the step before and over the step after.
    pub fn enter(&mut self, before: f64, after: f64) {
        self.until_now += self.begun + before;
        self.begun = after;
    }
}
