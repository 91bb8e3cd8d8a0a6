//! Hardening: how the flow stress σ_y follows from plastic flow, and the motion of the yield surface's centre.
//!
//! [`IsotropicHardening`] has the laws that know the equivalent plastic strain ε̄ᵖ alone; [`JohnsonCook`](crate::JohnsonCook)
//! knows its rate and the temperature as well.

use crate::PointState;
use crate::parameter::{ParameterError, checked, not_negative, positive};
use estar_tensor::Real;

/// How the flow stress follows from plastic flow.
pub trait Hardening: Clone + Send + Sync + 'static {
    /// What the law remembers besides ε̄ᵖ: `()`, or a temperature.
    type Memory<R: Real>: PointState<R>;

    /// The memory of the undeformed material.
    fn initial_memory<R: Real>(&self) -> Self::Memory<R>;

    /// σ_y(ε̄ᵖ_n + p) after the `increment` p ≥ 0 of a step, and dσ_y/dp; σ_y does not fall with p. Implementations are
    /// `#[inline(always)]`.
    fn flow_stress<R: Real>(&self, start: &FlowStart<R, Self::Memory<R>>, increment: R) -> FlowStress<R>;

    /// dσ_y/dp, Pa, of a law that has the same for every flow.
    #[inline(always)]
    fn constant_slope(&self) -> Option<f64> {
        None
    }

    /// The memory after a step whose flow has dissipated `dissipation` J per m³ of undeformed volume. Implementations are
    /// `#[inline(always)]`.
    fn heated<R: Real>(&self, memory: Self::Memory<R>, dissipation: R) -> Self::Memory<R>;

    /// Temperature, K, of a law that has one. Implementations are `#[inline(always)]`.
    #[inline(always)]
    fn temperature<R: Real>(&self, _memory: &Self::Memory<R>) -> Option<R> {
        None
    }

    /// The share of the plastic dissipation that heats, of a law that has a temperature.
    fn heat_share(&self) -> Option<f64> {
        None
    }

    /// Whether the flow stress depends on the rate of flow.
    fn depends_on_rate(&self) -> bool {
        false
    }

    /// dσ_y/dε̄ᵖ, Pa, along a flow that goes on at its rate and now has the flow stress `flow_stress` (Pa).
    fn slope_of_flow(&self, plastic_strain: f64, memory: &Self::Memory<f64>, flow_stress: f64) -> f64;
}

/// What the flow of a step starts from.
#[derive(Clone, Copy, Debug)]
pub struct FlowStart<R, Memory> {
    /// ε̄ᵖ_n.
    pub plastic_strain: R,
    /// The law's memory of t_n.
    pub memory: Memory,
    /// 1/Δt, 1/s; zero in a step of length zero, in which nothing flows.
    pub per_time_step: f64,
}

impl<R: Real, Memory> FlowStart<R, Memory> {
    /// The start of a step of length `time_step` (s).
    #[inline(always)]
    pub fn new(plastic_strain: R, memory: Memory, time_step: f64) -> Self {
        let per_time_step = if time_step > 0.0 { time_step.recip() } else { 0.0 };
        Self { plastic_strain, memory, per_time_step }
    }
}

impl Hardening for IsotropicHardening {
    type Memory<R: Real> = ();

    #[inline(always)]
    fn initial_memory<R: Real>(&self) {}

    #[inline(always)]
    fn flow_stress<R: Real>(&self, start: &FlowStart<R, ()>, increment: R) -> FlowStress<R> {
        self.at(start.plastic_strain + increment)
    }

    #[inline(always)]
    fn constant_slope(&self) -> Option<f64> {
        match self.0 {
            Law::Linear { modulus, .. } => Some(modulus),
            Law::Saturation { .. } | Law::Power { .. } | Law::Tabulated(_) => None,
        }
    }

    #[inline(always)]
    fn heated<R: Real>(&self, _: (), _: R) {}

    fn slope_of_flow(&self, plastic_strain: f64, _: &(), _: f64) -> f64 {
        self.at(plastic_strain).slope
    }
}

/// Isotropic hardening: the flow stress σ_y(ε̄ᵖ) in Pa, one variant a law of the deck. Made by its constructors, which
/// check the parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct IsotropicHardening(Law);

#[derive(Clone, Debug, PartialEq)]
enum Law {
    Linear { yield_stress: f64, modulus: f64 },
    Saturation { yield_stress: f64, saturation_stress: f64, saturation_exponent: f64, modulus: f64 },
    Power { yield_stress: f64, coefficient: f64, initial_strain: f64, exponent: f64 },
    Tabulated(Vec<Segment>),
}

/// One straight piece of a tabulated law: σ = `stress` + `slope` (ε̄ᵖ − `strain`) from `strain` on.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Segment {
    strain: f64,
    stress: f64,
    slope: f64,
}

/// Flow stress and its slope at one equivalent plastic strain, or after one increment of it.
#[derive(Clone, Copy, Debug)]
pub struct FlowStress<R> {
    /// σ_y, Pa.
    pub stress: R,
    /// Its derivative by the strain, or by the increment, Pa.
    pub slope: R,
}

impl IsotropicHardening {
    /// Perfect plasticity: σ_y = σ₀.
    ///
    /// # Errors
    /// `yield_stress` not greater than 0.
    pub fn perfect(yield_stress: f64) -> Result<Self, ParameterError> {
        Self::linear(yield_stress, 0.0)
    }

    /// Linear hardening: σ_y = σ₀ + H ε̄ᵖ.
    ///
    /// # Errors
    /// `yield_stress` not greater than 0, or a negative `modulus`.
    pub fn linear(yield_stress: f64, modulus: f64) -> Result<Self, ParameterError> {
        Ok(Self(Law::Linear {
            yield_stress: positive("yield_stress", yield_stress)?,
            modulus: not_negative("modulus", modulus)?,
        }))
    }

    /// Voce: σ_y = σ₀ + (σ_∞ − σ₀)(1 − e^{−δ ε̄ᵖ}).
    ///
    /// # Errors
    /// A stress not greater than 0 or a negative exponent.
    pub fn voce(yield_stress: f64, saturation_stress: f64, saturation_exponent: f64) -> Result<Self, ParameterError> {
        Self::saturation(yield_stress, saturation_stress, saturation_exponent, 0.0)
    }

    /// Simo's saturation law: σ_y = σ₀ + (σ_∞ − σ₀)(1 − e^{−δ ε̄ᵖ}) + H ε̄ᵖ.
    ///
    /// # Errors
    /// A stress not greater than 0, a saturation stress below the yield stress, a negative exponent or modulus.
    pub fn saturation(
        yield_stress: f64,
        saturation_stress: f64,
        saturation_exponent: f64,
        modulus: f64,
    ) -> Result<Self, ParameterError> {
        let yield_stress = positive("yield_stress", yield_stress)?;
        Ok(Self(Law::Saturation {
            yield_stress,
            saturation_stress: checked(
                "saturation_stress",
                saturation_stress,
                |stress| stress >= yield_stress,
                "it must not be below yield_stress",
            )?,
            saturation_exponent: not_negative("saturation_exponent", saturation_exponent)?,
            modulus: not_negative("modulus", modulus)?,
        }))
    }

    /// Ludwik: σ_y = σ₀ + B (ε̄ᵖ)ⁿ.
    ///
    /// # Errors
    /// `yield_stress` not greater than 0, a negative coefficient, or an exponent outside (0, 1].
    pub fn ludwik(yield_stress: f64, coefficient: f64, exponent: f64) -> Result<Self, ParameterError> {
        Ok(Self(Law::Power {
            yield_stress: positive("yield_stress", yield_stress)?,
            coefficient: not_negative("coefficient", coefficient)?,
            initial_strain: 0.0,
            exponent: power_exponent(exponent)?,
        }))
    }

    /// Swift: σ_y = C (ε₀ + ε̄ᵖ)ⁿ.
    ///
    /// # Errors
    /// `coefficient` not greater than 0, `initial_strain` below 10⁻¹², or an exponent outside (0, 1].
    pub fn swift(coefficient: f64, initial_strain: f64, exponent: f64) -> Result<Self, ParameterError> {
        Ok(Self(Law::Power {
            yield_stress: 0.0,
            coefficient: positive("coefficient", coefficient)?,
            initial_strain: checked(
                "initial_strain",
                initial_strain,
                |strain| strain >= CHORD_STRAIN,
                "it must be 1e-12 or greater",
            )?,
            exponent: power_exponent(exponent)?,
        }))
    }

    /// A table of `[strain, stress]` points, straight between them and constant beyond the last.
    ///
    /// # Errors
    /// No point, a first strain other than 0, strains that do not increase, a stress that is not positive or falls, or a
    /// slope that no number holds.
    pub fn tabulated(points: &[[f64; 2]]) -> Result<Self, ParameterError> {
        let Some(first) = points.first() else {
            return Err(ParameterError {
                parameter: "points",
                value: 0.0,
                bound: "the table needs at least one point",
            });
        };
        checked("points", first[0], |strain| strain == 0.0, "the first strain of the table must be 0")?;
        positive("points", first[1])?;
        for pair in points.windows(2) {
            checked("points", pair[1][0], |strain| strain > pair[0][0], "the strains of the table must increase")?;
            checked("points", pair[1][1], |stress| stress >= pair[0][1], "the stresses of the table must not fall")?;
            let slope = (pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0]);
            checked("points", slope, |_| true, "the slope of the table must be finite")?;
        }
        let slope = |index: usize| match points.get(index + 1) {
            Some(next) => (next[1] - points[index][1]) / (next[0] - points[index][0]),
            None => 0.0,
        };
        let segment =
            |(index, point): (usize, &[f64; 2])| Segment { strain: point[0], stress: point[1], slope: slope(index) };
        Ok(Self(Law::Tabulated(points.iter().enumerate().map(segment).collect())))
    }

    /// Flow stress and slope dσ_y/dε̄ᵖ at `plastic_strain` ≥ 0.
    #[inline(always)]
    pub fn at<R: Real>(&self, plastic_strain: R) -> FlowStress<R> {
        match &self.0 {
            Law::Linear { yield_stress, modulus } => {
                // σ₀ + H ε̄ᵖ
                let slope = R::splat(*modulus);
                FlowStress { stress: slope.mul_add(plastic_strain, R::splat(*yield_stress)), slope }
            }
            Law::Saturation { yield_stress, saturation_stress, saturation_exponent, modulus } => {
                // σ_∞ − (σ_∞ − σ₀) e^{−δ ε̄ᵖ} + H ε̄ᵖ
                let remaining =
                    R::splat(saturation_stress - yield_stress) * (plastic_strain * -*saturation_exponent).exp();
                let linear = R::splat(*modulus).mul_add(plastic_strain, R::splat(*saturation_stress));
                FlowStress { stress: linear - remaining, slope: remaining * *saturation_exponent + *modulus }
            }
            Law::Power { yield_stress, coefficient, initial_strain, exponent } => {
                // σ₀ + C (ε₀ + ε̄ᵖ)ⁿ; where ε₀ = 0 the slope at the first yield would be infinite, so the power starts
                // along the chord to its value at a first strain
                let strain = plastic_strain + *initial_strain;
                let on_chord = strain.lt(R::splat(CHORD_STRAIN));
                let power_strain = strain.max(R::splat(CHORD_STRAIN));
                let power = R::splat(*coefficient) * (power_strain.ln() * *exponent).exp();
                let chord = power * CHORD_STRAIN.recip();
                FlowStress {
                    stress: R::select(on_chord, chord * strain, power) + *yield_stress,
                    slope: R::select(on_chord, chord, power * *exponent / power_strain),
                }
            }
            Law::Tabulated(segments) => {
                let mut result =
                    FlowStress { stress: R::splat(segments[0].stress), slope: R::splat(segments[0].slope) };
                result.stress = result.slope.mul_add(plastic_strain, result.stress);
                for segment in &segments[1..] {
                    let offset = plastic_strain - segment.strain;
                    let beyond = offset.ge(R::splat(0.0));
                    let stress = R::splat(segment.slope).mul_add(offset, R::splat(segment.stress));
                    result.stress = R::select(beyond, stress, result.stress);
                    result.slope = R::select(beyond, R::splat(segment.slope), result.slope);
                }
                result
            }
        }
    }
}

/// The strain below which a power law without initial strain is straight.
const CHORD_STRAIN: f64 = 1e-12;

fn power_exponent(exponent: f64) -> Result<f64, ParameterError> {
    checked("exponent", exponent, |n| 0.0 < n && n <= 1.0, "it must lie in (0, 1]")
}

/// Kinematic hardening: the motion of the centre α of the yield surface with plastic flow.
///
/// Armstrong & Frederick: α̇ = ⅔ C D_p − γ α ε̄̇ᵖ; γ = 0 is Prager's law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KinematicHardening {
    modulus: f64,
    recovery: f64,
}

impl KinematicHardening {
    /// No kinematic hardening.
    pub const NONE: Self = Self { modulus: 0.0, recovery: 0.0 };

    /// Prager: α̇ = ⅔ C D_p, C in Pa.
    ///
    /// # Errors
    /// A negative modulus.
    pub fn prager(modulus: f64) -> Result<Self, ParameterError> {
        Self::armstrong_frederick(modulus, 0.0)
    }

    /// Armstrong-Frederick: α̇ = ⅔ C D_p − γ α ε̄̇ᵖ, C in Pa, γ a pure number; α saturates at the uniaxial value C/γ.
    ///
    /// # Errors
    /// A negative modulus or recovery.
    pub fn armstrong_frederick(modulus: f64, recovery: f64) -> Result<Self, ParameterError> {
        Ok(Self { modulus: not_negative("modulus", modulus)?, recovery: not_negative("recovery", recovery)? })
    }

    /// C, Pa.
    pub fn modulus(&self) -> f64 {
        self.modulus
    }

    /// γ.
    pub fn recovery(&self) -> f64 {
        self.recovery
    }

    /// Whether the yield surface moves at all.
    pub fn is_active(&self) -> bool {
        self.modulus > 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused<T: std::fmt::Debug>(made: Result<T, ParameterError>) -> (&'static str, f64) {
        let error = made.unwrap_err();
        assert!(error.to_string().starts_with(error.parameter) && error.to_string().contains(error.bound));
        (error.parameter, error.value)
    }

    #[test]
    fn every_bad_parameter_is_refused_by_name_and_value() {
        use IsotropicHardening as Law;
        // each law with one parameter replaced by what it must not be
        for bad in [0.0, -1.0, f64::INFINITY] {
            assert_eq!(refused(Law::perfect(bad)), ("yield_stress", bad));
            assert_eq!(refused(Law::linear(bad, 1.0)), ("yield_stress", bad));
            assert_eq!(refused(Law::voce(bad, 2.0, 1.0)), ("yield_stress", bad));
            assert_eq!(refused(Law::saturation(bad, 2.0, 1.0, 0.0)), ("yield_stress", bad));
            assert_eq!(refused(Law::ludwik(bad, 1.0, 0.5)), ("yield_stress", bad));
            assert_eq!(refused(Law::swift(bad, 0.1, 0.5)), ("coefficient", bad));
            assert_eq!(refused(Law::swift(1.0, bad, 0.5)), ("initial_strain", bad));
            assert_eq!(refused(Law::ludwik(1.0, 1.0, bad)), ("exponent", bad));
            assert_eq!(refused(Law::swift(1.0, 0.1, bad)), ("exponent", bad));
            assert_eq!(refused(Law::tabulated(&[[0.0, bad]])), ("points", bad));
        }
        for bad in [-1.0, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(refused(Law::linear(1.0, bad)), ("modulus", bad));
            assert_eq!(refused(Law::voce(1.0, 2.0, bad)), ("saturation_exponent", bad));
            assert_eq!(refused(Law::saturation(1.0, 2.0, bad, 0.0)), ("saturation_exponent", bad));
            assert_eq!(refused(Law::saturation(1.0, 2.0, 1.0, bad)), ("modulus", bad));
            assert_eq!(refused(Law::ludwik(1.0, bad, 0.5)), ("coefficient", bad));
            assert_eq!(refused(KinematicHardening::prager(bad)), ("modulus", bad));
            assert_eq!(refused(KinematicHardening::armstrong_frederick(bad, 1.0)), ("modulus", bad));
            assert_eq!(refused(KinematicHardening::armstrong_frederick(1.0, bad)), ("recovery", bad));
        }
        assert_eq!(refused(Law::voce(2.0, 1.0, 1.0)), ("saturation_stress", 1.0));
        assert_eq!(refused(Law::saturation(2.0, 1.0, 1.0, 0.0)), ("saturation_stress", 1.0));
        assert_eq!(refused(Law::ludwik(1.0, 1.0, 1.5)), ("exponent", 1.5));
        assert_eq!(refused(Law::swift(1.0, 1e-13, 0.5)), ("initial_strain", 1e-13));
        assert!(refused(Law::perfect(f64::NAN)).1.is_nan());
    }

    #[test]
    fn a_table_out_of_order_is_refused() {
        let refused = |points: &[[f64; 2]]| refused(IsotropicHardening::tabulated(points)).1;
        assert_eq!(refused(&[]), 0.0);
        assert_eq!(refused(&[[0.1, 1.0]]), 0.1);
        assert_eq!(refused(&[[0.0, 1.0], [0.2, 2.0], [0.2, 3.0]]), 0.2);
        assert_eq!(refused(&[[0.0, 1.0], [0.2, 2.0], [0.1, 3.0]]), 0.1);
        assert_eq!(refused(&[[0.0, 2.0], [0.2, 1.0]]), 1.0);
        assert_eq!(refused(&[[0.0, 1.0], [f64::INFINITY, 2.0]]), f64::INFINITY);
        assert!(refused(&[[0.0, 1.0], [0.2, f64::NAN]]).is_nan());
        // a step in stress is no function of strain, however thin
        assert_eq!(refused(&[[0.0, 1e6], [1e-305, 2e6]]), f64::INFINITY);
    }
}
