//! The flow stress of Johnson & Cook, with adiabatic heating (G. R. Johnson and W. H. Cook, A constitutive model and data for
//! metals subjected to large strains, high strain rates and high temperatures, 7th International Symposium on Ballistics, 1983).
//!
//! - flow stress   σ_y = (A + B (ε̄ᵖ)ⁿ) (1 + C ln max(ε̄̇ᵖ/ε̇₀, 1)) (1 − θ*ᵐ), θ* = (θ − θ_r)/(θ_m − θ_r) between 0 and 1
//! - heating       ρ₀ c θ̇ = β ẇ_p, ẇ_p the plastic dissipation per undeformed volume, β the share of Taylor & Quinney
//!
//! The rate of a step is p/Δt with its increment p of ε̄ᵖ, so that the return mapping solves for both at once (backward Euler).
//! The temperature is that of t_n: over a step it is constant, and the heat of the step comes after. So σ_y does not fall with p,
//! and the return has one solution for any step; what a step of p = 10⁻³ leaves out is some 10⁻⁴ of σ_y.
//!
//! Parameters: A, B (Pa), n, C, ε̇₀ (1/s), m, θ_r, θ_m (K), c (J/(kg K)), β, initial temperature (K). Memory: θ.

use crate::hardening::{FlowStart, FlowStress, Hardening, IsotropicHardening};
use crate::parameter::{ParameterError, checked, not_negative, positive};
use crate::{IsotropicElasticity, point_state};
use estar_tensor::Real;

/// Parameters of the flow stress, as the deck names them.
#[derive(Clone, Copy, Debug)]
pub struct JohnsonCookParameters {
    /// A, Pa: flow stress of the slow, cold material at first yield.
    pub a: f64,
    /// B, Pa.
    pub b: f64,
    /// n, in (0, 1].
    pub n: f64,
    /// C.
    pub c: f64,
    /// m, greater than 0.
    pub m: f64,
    /// ε̇₀, 1/s: below it the rate has no effect.
    pub reference_rate: f64,
    /// θ_r, K: below it the temperature has no effect.
    pub reference_temperature: f64,
    /// θ_m, K: from it on a millionth of the flow stress is left.
    pub melting_temperature: f64,
}

/// Parameters of the heating.
#[derive(Clone, Copy, Debug)]
pub struct AdiabaticHeating {
    /// c, J/(kg K).
    pub specific_heat: f64,
    /// β: the share of the plastic dissipation that heats.
    pub taylor_quinney: f64,
    /// Temperature at time 0, K.
    pub initial_temperature: f64,
}

/// The law of Johnson & Cook.
#[derive(Clone, Debug, PartialEq)]
pub struct JohnsonCook {
    /// A + B (ε̄ᵖ)ⁿ.
    strain_hardening: IsotropicHardening,
    rate_factor: f64,
    per_reference_rate: f64,
    reference_temperature: f64,
    /// 1/(θ_m − θ_r), 1/K.
    per_temperature_range: f64,
    thermal_exponent: f64,
    initial_temperature: f64,
    taylor_quinney: f64,
    /// β/(ρ₀ c), K m³/J.
    heating_per_dissipation: f64,
}

/// The temperature of a point.
#[derive(Clone, Copy, Debug)]
pub struct Temperature<R> {
    /// θ, K.
    pub temperature: R,
}

point_state!(Temperature { temperature: number });

/// What is left of the strength of a melt: next to nothing, but enough for flow to have a direction.
const MOLTEN: f64 = 1e-6;

impl JohnsonCook {
    /// The law of a material that stays at its reference temperature.
    ///
    /// # Errors
    /// A parameter out of its bounds.
    pub fn new(parameters: JohnsonCookParameters) -> Result<Self, ParameterError> {
        let JohnsonCookParameters { a, b, n, c, m, reference_rate, reference_temperature, melting_temperature } =
            parameters;
        let reference_temperature = not_negative("reference_temperature", reference_temperature)?;
        let melting_temperature = checked(
            "melting_temperature",
            melting_temperature,
            |melting| melting > reference_temperature,
            "it must be above reference_temperature",
        )?;
        positive("a", a)?;
        not_negative("b", b)?;
        let strain_hardening =
            IsotropicHardening::ludwik(a, b, n).map_err(|error| ParameterError { parameter: "n", ..error })?;
        Ok(Self {
            strain_hardening,
            rate_factor: not_negative("c", c)?,
            per_reference_rate: positive("reference_rate", reference_rate)?.recip(),
            reference_temperature,
            per_temperature_range: (melting_temperature - reference_temperature).recip(),
            thermal_exponent: positive("m", m)?,
            initial_temperature: reference_temperature,
            taylor_quinney: 0.0,
            heating_per_dissipation: 0.0,
        })
    }

    /// The law of a material of the density of `elasticity` that its own flow heats.
    ///
    /// # Errors
    /// A parameter out of its bounds.
    pub fn with_heating(
        self,
        heating: AdiabaticHeating,
        elasticity: &IsotropicElasticity,
    ) -> Result<Self, ParameterError> {
        let specific_heat = positive("specific_heat", heating.specific_heat)?;
        let share = |share| (0.0..=1.0).contains(&share);
        let taylor_quinney = checked("taylor_quinney", heating.taylor_quinney, share, "it must lie between 0 and 1")?;
        Ok(Self {
            initial_temperature: not_negative("initial_temperature", heating.initial_temperature)?,
            taylor_quinney,
            heating_per_dissipation: taylor_quinney / (elasticity.density() * specific_heat),
            ..self
        })
    }

    /// θ_r, K.
    pub fn reference_temperature(&self) -> f64 {
        self.reference_temperature
    }

    /// 1 − θ*ᵐ.
    #[inline(always)]
    fn thermal_factor<R: Real>(&self, temperature: R) -> R {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let homologous = (temperature - self.reference_temperature) * self.per_temperature_range;
        let homologous = homologous.max(zero).min(one);
        // 0ᵐ = 0, as near to it as a normal number is
        let power = (homologous.max(R::splat(f64::MIN_POSITIVE)).ln() * self.thermal_exponent).exp();
        (one - R::select(homologous.gt(zero), power, zero)).max(R::splat(MOLTEN))
    }
}

impl Hardening for JohnsonCook {
    type Memory<R: Real> = Temperature<R>;

    fn initial_memory<R: Real>(&self) -> Temperature<R> {
        Temperature { temperature: R::splat(self.initial_temperature) }
    }

    #[inline(always)]
    fn flow_stress<R: Real>(&self, start: &FlowStart<R, Temperature<R>>, increment: R) -> FlowStress<R> {
        let one = R::splat(1.0);
        let slow = self.strain_hardening.at(start.plastic_strain + increment);
        // 1 + C ln max(ε̇*, 1), ε̇* = p/(Δt ε̇₀), and its derivative C/p
        let rate = increment * (start.per_time_step * self.per_reference_rate);
        let is_fast = rate.gt(one);
        let rate_term = (rate.max(one).ln() * self.rate_factor) + 1.0;
        let rate_slope =
            R::select(is_fast, R::splat(self.rate_factor) / R::select(is_fast, increment, one), R::splat(0.0));
        let thermal = self.thermal_factor(start.memory.temperature);
        FlowStress {
            stress: slow.stress * rate_term * thermal,
            slope: slow.slope.mul_add(rate_term, slow.stress * rate_slope) * thermal,
        }
    }

    #[inline(always)]
    fn heated<R: Real>(&self, memory: Temperature<R>, dissipation: R) -> Temperature<R> {
        Temperature { temperature: dissipation.mul_add(R::splat(self.heating_per_dissipation), memory.temperature) }
    }

    #[inline(always)]
    fn temperature<R: Real>(&self, memory: &Temperature<R>) -> Option<R> {
        Some(memory.temperature)
    }

    fn heat_share(&self) -> Option<f64> {
        Some(self.taylor_quinney)
    }

    fn depends_on_rate(&self) -> bool {
        self.rate_factor > 0.0
    }

    /// ∂σ_y/∂ε̄ᵖ + ∂σ_y/∂θ β σ_y/(ρ₀ c), below zero where heating softens more than strain hardens; the factor of the rate is
    /// that by which the flow stress exceeds that of slow flow.
    fn slope_of_flow(&self, plastic_strain: f64, memory: &Temperature<f64>, flow_stress: f64) -> f64 {
        let slow = self.strain_hardening.at(plastic_strain);
        let homologous = (memory.temperature - self.reference_temperature) * self.per_temperature_range;
        let thermal = self.thermal_factor(memory.temperature);
        let softening = if homologous > 0.0 && homologous < 1.0 {
            self.thermal_exponent * homologous.powf(self.thermal_exponent - 1.0) * self.per_temperature_range
        } else {
            0.0
        };
        let heating = self.heating_per_dissipation * flow_stress;
        let rate_term = flow_stress / (slow.stress * thermal);
        rate_term * (slow.slope * thermal - slow.stress * softening * heating)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ElasticConstant;

    const PARAMETERS: JohnsonCookParameters = JohnsonCookParameters {
        a: 806e6,
        b: 614e6,
        n: 0.168,
        c: 0.0089,
        m: 1.1,
        reference_rate: 1.0,
        reference_temperature: 293.15,
        melting_temperature: 1813.15,
    };
    const HEATING: AdiabaticHeating =
        AdiabaticHeating { specific_heat: 460.0, taylor_quinney: 0.9, initial_temperature: 293.15 };

    fn steel() -> IsotropicElasticity {
        let constants = (ElasticConstant::YoungModulus(206.9e9), ElasticConstant::PoissonRatio(0.3));
        IsotropicElasticity::new(7830.0, constants.0, constants.1).unwrap()
    }

    fn law(change: impl Fn(&mut JohnsonCookParameters)) -> JohnsonCook {
        let mut parameters = PARAMETERS;
        change(&mut parameters);
        JohnsonCook::new(parameters).unwrap().with_heating(HEATING, &steel()).unwrap()
    }

    fn start(plastic_strain: f64, temperature: f64, time_step: f64) -> FlowStart<f64, Temperature<f64>> {
        FlowStart::new(plastic_strain, Temperature { temperature }, time_step)
    }

    #[test]
    fn the_flow_stress_is_the_product_of_its_three_terms() {
        let law = law(|_| ());
        let close = |found: f64, wanted: f64| assert!((found / wanted - 1.0).abs() < 1e-14, "{found} {wanted}");
        let slow = 806e6 + 614e6 * 0.5_f64.powf(0.168);
        // slow and cold
        close(law.flow_stress(&start(0.5, 293.15, 1.0), 0.0).stress, slow);
        close(law.flow_stress(&start(0.4, 100.0, 1.0), 0.1).stress, slow);
        // 10⁵ 1/s, and half way to the melting point
        let fast = 1.0 + 0.0089 * 1e5_f64.ln();
        let found = law.flow_stress(&start(0.4, 1053.15, 1e-6), 0.1).stress;
        assert!((found / (slow * fast * (1.0 - 0.5_f64.powf(1.1))) - 1.0).abs() < 1e-14, "{found}");
        // molten
        close(law.flow_stress(&start(0.4, 1813.15, 1e-6), 0.1).stress, slow * fast * MOLTEN);
        close(law.flow_stress(&start(0.4, 5000.0, 1e-6), 0.1).stress, slow * fast * MOLTEN);
        // a step of length zero is slow
        close(law.flow_stress(&start(0.5, 293.15, 0.0), 0.0).stress, slow);
    }

    #[test]
    fn the_slope_is_the_derivative_of_the_flow_stress() {
        let law = law(|_| ());
        for (time_step, increment) in [(1.0, 1e-3), (1e-8, 1e-3), (1e-8, 1e-6), (1e-3, 0.1)] {
            let start = start(0.2, 500.0, time_step);
            let step = 1e-5 * increment;
            let [low, high] = [increment - step, increment + step].map(|p| law.flow_stress(&start, p).stress);
            let slope = law.flow_stress(&start, increment).slope;
            assert!(((high - low) / (2.0 * step) / slope - 1.0).abs() < 1e-5, "{time_step} {increment}");
        }
    }

    #[test]
    fn flow_hardens_at_first_and_softens_when_heat_outweighs_strain() {
        let law = law(|_| ());
        let memory = |temperature| Temperature { temperature };
        let slope = |strain: f64, temperature: f64, rate: f64| {
            // an increment that is nothing, at the rate
            let step = 1e-6;
            let at = |p: f64, temperature: f64| {
                law.flow_stress(&start(strain + p - step, temperature, step / rate), step).stress
            };
            let flow_stress = at(0.0, temperature);
            // dσ_y along dε̄ᵖ with the heat of its own dissipation
            let stress = |p: f64| at(p, law.heated(memory(temperature), flow_stress * p).temperature);
            let difference = (stress(step) - stress(-step)) / (2.0 * step);
            let slope = law.slope_of_flow(strain, &memory(temperature), flow_stress);
            assert!((slope / difference - 1.0).abs() < 1e-5, "{slope} {difference}");
            slope
        };
        for rate in [1e-3, 1e5] {
            assert!(slope(0.05, 310.0, rate) > 0.0);
            assert!(slope(1.5, 900.0, rate) < 0.0);
        }
        // where slow flow still hardens fast flow softens
        let strains = (5..150).map(|percent| 0.01 * f64::from(percent));
        let between = strains.filter(|strain| slope(*strain, 420.0, 1e-3) > 0.0 && slope(*strain, 420.0, 1e7) < 0.0);
        assert!(between.count() > 1);
    }

    #[test]
    fn a_joule_heats_as_much_as_mass_and_share_say() {
        let memory = law(|_| ()).heated(Temperature { temperature: 300.0 }, 7830.0 * 460.0);
        assert!((memory.temperature - 300.9).abs() < 1e-12);
    }

    #[test]
    fn every_bad_parameter_is_refused_by_name() {
        let refused = |change: &dyn Fn(&mut JohnsonCookParameters, &mut AdiabaticHeating)| {
            let (mut parameters, mut heating) = (PARAMETERS, HEATING);
            change(&mut parameters, &mut heating);
            let law = JohnsonCook::new(parameters).and_then(|law| law.with_heating(heating, &steel()));
            law.unwrap_err().parameter
        };
        for bad in [-1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(refused(&|parameters, _| parameters.a = bad), "a");
            assert_eq!(refused(&|parameters, _| parameters.b = bad), "b");
            assert_eq!(refused(&|parameters, _| parameters.n = bad), "n");
            assert_eq!(refused(&|parameters, _| parameters.c = bad), "c");
            assert_eq!(refused(&|parameters, _| parameters.m = bad), "m");
            assert_eq!(refused(&|parameters, _| parameters.reference_rate = bad), "reference_rate");
            assert_eq!(refused(&|parameters, _| parameters.reference_temperature = bad), "reference_temperature");
            assert_eq!(refused(&|parameters, _| parameters.melting_temperature = bad), "melting_temperature");
            assert_eq!(refused(&|_, heating| heating.specific_heat = bad), "specific_heat");
            assert_eq!(refused(&|_, heating| heating.taylor_quinney = bad), "taylor_quinney");
            assert_eq!(refused(&|_, heating| heating.initial_temperature = bad), "initial_temperature");
        }
        assert_eq!(refused(&|parameters, _| parameters.a = 0.0), "a");
        assert_eq!(refused(&|parameters, _| parameters.n = 1.5), "n");
        assert_eq!(refused(&|parameters, _| parameters.melting_temperature = 293.0), "melting_temperature");
        assert_eq!(refused(&|_, heating| heating.taylor_quinney = 1.1), "taylor_quinney");
        assert_eq!(refused(&|_, heating| heating.specific_heat = 0.0), "specific_heat");
    }
}
