//! The energy ledger: every joule has a row.

/// Energies at one time, in J.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Energies {
    /// Kinetic energy at time 0.
    pub initial_kinetic: f64,
    /// Kinetic energy Σ ½ m v_{n−½} · v_{n+½}.
    pub kinetic: f64,
    /// Stress power at the quadrature points ∫∫ T : D dV dt, elastic and plastic.
    pub internal: f64,
    /// The part of it that plastic flow has dissipated.
    pub plastic_dissipation: f64,
    /// Work against bulk viscosity.
    pub viscous: f64,
    /// Work of each load of the model.
    pub load_work: Vec<f64>,
    /// Work of the constraints that move: prescribed motions.
    pub constraint_work: f64,
    /// Energy that rigid walls have taken, by impact and by friction.
    pub contact: f64,
}

impl Energies {
    /// Work of the outside on the body: loads and prescribed motions.
    pub fn external_work(&self) -> f64 {
        self.load_work.iter().sum::<f64>() + self.constraint_work
    }

    /// Kinetic + internal + viscous + contact − external work − initial.
    pub fn imbalance(&self) -> f64 {
        self.kinetic + self.internal + self.viscous + self.contact - self.external_work() - self.initial_kinetic
    }

    /// The imbalance as a fraction of the energy in play: the greater of what came in and what is there.
    ///
    /// The rows are computed independently of one another (internal energy is the stress power at the points, not the
    /// work of nodal forces), so that this is a check and no identity; it is of second order in the time step.
    pub fn error(&self) -> f64 {
        let came_in = (self.initial_kinetic + self.external_work()).abs();
        let is_there = (self.kinetic + self.internal + self.viscous + self.contact).abs();
        let scale = came_in.max(is_there);
        if scale > 0.0 { self.imbalance() / scale } else { 0.0 }
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
