//! What a step of elements gives: sums and extremes.

use estar_tensor::Real;

/// A value and the element of the mesh that has it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extreme {
    pub value: f64,
    pub element: u32,
}

impl Extreme {
    pub const NONE: Self = Self { value: f64::INFINITY, element: 0 };

    fn smaller(self, other: Self) -> Self {
        if other.value < self.value { other } else { self }
    }
}

/// What a step of one or more blocks gives; energies are those of the step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BlockReport {
    pub internal_energy: f64,
    pub plastic_dissipation: f64,
    pub viscous_energy: f64,
    pub hourglass_energy: f64,
    pub min_jacobian: Extreme,
    pub stable_time_step: Extreme,
    /// The first element with a force or an energy that is not finite.
    pub not_finite: Option<u32>,
    /// Elements that were deleted in the step.
    pub deleted_count: u32,
    /// The stress power that they had taken until then.
    pub deleted_energy: f64,
    /// By how much the largest eigenvalue of the assembled mesh may have grown since its estimate, 1/s².
    pub growth: f64,
    /// By how much it may have fallen.
    pub decline: f64,
}

impl BlockReport {
    pub const EMPTY: Self = Self {
        internal_energy: 0.0,
        plastic_dissipation: 0.0,
        viscous_energy: 0.0,
        hourglass_energy: 0.0,
        min_jacobian: Extreme::NONE,
        stable_time_step: Extreme::NONE,
        not_finite: None,
        deleted_count: 0,
        deleted_energy: 0.0,
        growth: 0.0,
        decline: 0.0,
    };

    /// The report of this and of a later block or patch.
    pub fn followed_by(self, later: Self) -> Self {
        Self {
            internal_energy: self.internal_energy + later.internal_energy,
            plastic_dissipation: self.plastic_dissipation + later.plastic_dissipation,
            viscous_energy: self.viscous_energy + later.viscous_energy,
            hourglass_energy: self.hourglass_energy + later.hourglass_energy,
            min_jacobian: self.min_jacobian.smaller(later.min_jacobian),
            stable_time_step: self.stable_time_step.smaller(later.stable_time_step),
            not_finite: self.not_finite.or(later.not_finite),
            deleted_count: self.deleted_count + later.deleted_count,
            deleted_energy: self.deleted_energy + later.deleted_energy,
            growth: self.growth.max(later.growth),
            decline: self.decline.max(later.decline),
        }
    }
}

/// The smallest value of each lane and the pack that has it.
#[derive(Clone, Copy)]
pub(super) struct LaneExtreme<R> {
    value: R,
    pack: R,
}

impl<R: Real> LaneExtreme<R> {
    #[inline(always)]
    pub fn none() -> Self {
        Self { value: R::splat(f64::INFINITY), pack: R::splat(0.0) }
    }

    #[inline(always)]
    pub fn enter(&mut self, value: R, pack: usize) {
        let smaller = value.lt(self.value);
        self.value = R::select(smaller, value, self.value);
        self.pack = R::select(smaller, R::splat(pack as f64), self.pack);
    }

    /// The smallest of all lanes; of equal ones that of the first element.
    pub fn resolved(self, members: &[u32]) -> Extreme {
        let of_lane = |lane: usize| (self.value.lane(lane), self.pack.lane(lane) as usize * R::LANES + lane);
        let smaller = |a: (f64, usize), b: (f64, usize)| if b < a { b } else { a };
        let (value, element) = (0..R::LANES).map(of_lane).fold((f64::INFINITY, usize::MAX), smaller);
        // the copies that fill the last pack are those of the last element
        Extreme { value, element: members[element.min(members.len() - 1)] }
    }
}
