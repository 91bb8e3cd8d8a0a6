//! The E* theory in total form: stress from the elastic strain E* itself (de Vera 2016, chapters 5-7).
//!
//! With the plastic metric C_p = U_p² the elastic left Cauchy-Green tensor is b_e = F C_p⁻¹ Fᵀ = R_* (2 E* + I) R_*ᵀ, so
//!
//! - elasticity   T = μ dev b_e + ½ k (tr b_e − 3) I, which is T̃ = 2μ dev E* + k tr(E*) I (dV 7.36, 7.37) turned by R_*
//! - yield        √(3/2) ‖dev T‖ ≤ σ_y(ε̄ᵖ) (dV 7.76, 7.78)
//! - flow         D̄_p = γ̇ n with the normal n in the intermediate configuration, tr D̄_p = 0
//!
//! Update by the exponential map, b_e = b_trial exp(−2 Δγ n), n = dev b_trial/‖dev b_trial‖, in several stages of the
//! kind where the trial is far outside the yield surface. All of these tensors have the principal axes of b_trial and
//! none is ever computed: by Cayley and Hamilton n³ = ½ n + det(n) I, so every one is a combination of I, n and n² (see
//! [`Combination`]).
//!
//! Stress and history are exactly objective, however far a step turns. The stress power takes T_n as it stood at t_n,
//! so its error is of second order in the rotation of the step.
//!
//! Heating is by the dissipation per undeformed volume, J T : Δε_p over a step.
//!
//! Parameters: elasticity, isotropic hardening. History: C_p⁻¹, ε̄ᵖ, T for the stress power of the next step, and what the
//! hardening law remembers.

use crate::e_star::von_mises;
use crate::elastic::stress_power;
use crate::metric_state::isochoric;
use crate::return_mapping::{Equivalent, plastic_increment};
use crate::tangent_bound::linear_in_elastic_metric;
use crate::{
    FlowStart, Hardening, IsotropicElasticity, Material, MaterialUpdate, MetricState, SpatialMotion, YieldCriterion,
};
use estar_tensor::{Mask, Real, Rotation, SymmetricTensor, Tensor, inlined};

/// The E* theory in total form.
#[derive(Clone, Debug, PartialEq)]
pub struct EStarTotal<H> {
    elasticity: IsotropicElasticity,
    hardening: H,
}

impl<H: Hardening> EStarTotal<H> {
    /// The material with these parameters.
    pub fn new(elasticity: IsotropicElasticity, hardening: H) -> Self {
        Self { elasticity, hardening }
    }

    /// T = μ dev b_e + ½ k (tr b_e − 3) I.
    #[inline(always)]
    fn stress<R: Real>(&self, elastic_metric: &SymmetricTensor<R>) -> SymmetricTensor<R> {
        let mean = (elastic_metric.trace() - 3.0) * (0.5 * self.elasticity.bulk_modulus());
        (elastic_metric.deviator() * R::splat(self.elasticity.shear_modulus())).plus_spherical(mean)
    }

    /// The return of b_trial to the yield surface, in the lanes that yield.
    ///
    /// One stage along the normal of b_trial is the whole return, unless the trial is far outside: then the next stage
    /// starts from what it reached, along the normal there.
    #[inline(always)]
    pub(crate) fn return_mapping<R: Real>(
        &self,
        yields: R::Mask,
        trial: &SymmetricTensor<R>,
        start: &FlowStart<R, H::Memory<R>>,
    ) -> TotalReturn<R> {
        let mut outside = yields;
        let mut elastic_metric = *trial;
        let mut plastic_increment = R::splat(0.0);
        let mut flow = SymmetricTensor::zero();
        for _ in 0..MOST_STAGES {
            let stage = self.stage(outside, &elastic_metric, start, plastic_increment);
            elastic_metric = SymmetricTensor::select(outside, &stage.elastic_metric, &elastic_metric);
            flow = SymmetricTensor::select(outside, &(flow + stage.flow), &flow);
            plastic_increment += stage.plastic_increment;
            outside = outside & stage.plastic_increment.ge(stage.upper_bound);
            if !outside.any() {
                break;
            }
        }
        TotalReturn { elastic_metric, plastic_increment, flow }
    }

    /// The return along the normal n of `metric`, after `increment_before` of earlier stages, as far as the yield surface or
    /// `upper_bound`: with p = Δε̄ᵖ and x = −2 Δγ = −√6 p,
    ///
    /// √(3/2) μ ‖dev(b exp(x n))‖ = σ_y(ε̄ᵖ + p).
    ///
    /// As long as √6 p ≤ ‖dev b‖/b₁, b₁ the largest principal value of b, those of b exp(x n) keep the order of those of
    /// n, and then d/dx ½ ‖dev b‖² = dev b : n b > 0: the left side falls all the way. The bound is this one with
    /// b₁ ≤ ⅓ tr b + √⅔ ‖dev b‖. It leaves about ‖dev b‖² to the next stage, so one stage reaches the surface while
    /// ‖dev b‖² is less than its radius, and |x| < √⅔ always.
    #[inline(always)]
    fn stage<R: Real>(
        &self,
        outside: R::Mask,
        metric: &SymmetricTensor<R>,
        start: &FlowStart<R, H::Memory<R>>,
        increment_before: R,
    ) -> Stage<R> {
        let scale = SQRT_3_HALVES * self.elasticity.shear_modulus();
        let deviator = metric.deviator();
        let norm = R::select(outside, deviator.norm_squared(), R::splat(1.0)).sqrt();
        let normal = deviator * norm.recip();
        let determinant = normal.determinant();
        // b = ⅓ tr(b) I + ‖dev b‖ n
        let mean = metric.trace() * (1.0 / 3.0);
        let begun = Combination([mean, norm, R::splat(0.0)]);
        let returned =
            inlined!(|p: R| begun.times(&Combination::exponential::<2>(p * -SQRT_6, determinant), determinant));

        let equivalent_of = inlined!(|metric: Combination<R>, length: R| {
            // d b_e/dx = n b_e
            let slope = metric.times_normal(determinant);
            let length_slope = metric.deviator_dot(&slope, determinant) / length * -SQRT_6;
            Equivalent { stress: length * scale, slope: length_slope * scale }
        });
        let equivalent = inlined!(|p: R| {
            let metric = returned(p);
            equivalent_of(metric, metric.deviator_dot(&metric, determinant).sqrt())
        });
        let flow = inlined!(|p: R| self.hardening.flow_stress(start, increment_before + p));
        let upper_bound = norm / (norm.mul_add(R::splat(SQRT_2_THIRDS), mean) * SQRT_6);
        let at_zero = (equivalent_of(begun, norm), flow(R::splat(0.0)));
        let p = plastic_increment(outside, upper_bound, at_zero, equivalent, flow);

        let Combination([identity, linear, quadratic]) = returned(p);
        Stage {
            elastic_metric: normal.square().mul_add(quadratic, &(normal * linear)).plus_spherical(identity),
            plastic_increment: p,
            flow: normal * (p * SQRT_3_HALVES),
            upper_bound,
        }
    }
}

/// What a return gives.
pub(crate) struct TotalReturn<R> {
    /// b_e on the yield surface.
    pub elastic_metric: SymmetricTensor<R>,
    /// Δε̄ᵖ.
    pub plastic_increment: R,
    /// Δγ n, summed over the stages.
    pub flow: SymmetricTensor<R>,
}

/// What one stage of a return gives.
struct Stage<R> {
    elastic_metric: SymmetricTensor<R>,
    plastic_increment: R,
    flow: SymmetricTensor<R>,
    /// The largest increment that the stage could have made.
    upper_bound: R,
}

/// A stage divides the ratio of the principal values by two or more, and squares its distance from 1 once that is
/// small: more than any trial that a number can hold needs.
const MOST_STAGES: usize = 64;

impl<H: Hardening> Material for EStarTotal<H> {
    type State<R: Real> = MetricState<R, H::Memory<R>>;

    type Motion<R: Real> = SpatialMotion<R>;

    fn elasticity(&self) -> &IsotropicElasticity {
        &self.elasticity
    }

    /// Of the tangent of T(b_e), which is stiffer by tr b_e and by the stress.
    #[inline(always)]
    fn stiffening<R: Real>(&self, state: &Self::State<R>, _: &SpatialMotion<R>) -> Option<R> {
        Some(linear_in_elastic_metric(&self.elasticity, &state.stress).over_rest(&self.elasticity))
    }

    fn initial_state<R: Real>(&self) -> Self::State<R> {
        MetricState::initial(self.hardening.initial_memory())
    }

    #[inline(always)]
    fn update<R: Real>(
        &self,
        old: &Self::State<R>,
        motion: &SpatialMotion<R>,
        time_step: f64,
    ) -> MaterialUpdate<R, Self::State<R>> {
        let strain_old = old.equivalent_plastic_strain;

        // (i) elastic predictor: b_trial = F C_p⁻¹ Fᵀ with the plastic metric of t_n
        let gradient = &motion.deformation_gradient;
        let trial = old.inverse_plastic_metric.pushed_by(gradient);
        let trial_stress = self.stress(&trial);

        // (ii) admissibility: √(3/2) ‖dev T_trial‖ ≤ σ_y of t_n
        let start = FlowStart::new(strain_old, old.memory, time_step);
        let flow_stress_old = self.hardening.flow_stress(&start, R::splat(0.0));
        let yields = von_mises(&trial_stress.deviator()).gt(flow_stress_old.stress);

        // (iii) return mapping, and C_p⁻¹ = F⁻¹ b_e F⁻ᵀ
        let mut state = MetricState { stress: trial_stress, ..*old };
        let zero = R::splat(0.0);
        let mut dissipation = zero;
        if yields.any() {
            let returned = self.return_mapping(yields, &trial, &start);
            let plastic = isochoric(&returned.elastic_metric.pushed_by(&gradient.inverse()));
            state.inverse_plastic_metric = SymmetricTensor::select(yields, &plastic, &old.inverse_plastic_metric);
            state.stress = SymmetricTensor::select(yields, &self.stress(&returned.elastic_metric), &trial_stress);
            state.equivalent_plastic_strain = strain_old + returned.plastic_increment;
            // the ledger's share of the stress power by the same rule as the whole of it
            dissipation = stress_power(&old.stress, &state.stress, &returned.flow).max(zero);
            // a temperature must not depend on how the step turns: J ½ (T_n + T_{n+1}) : Δε_p with dev T_n = dev(T_trial −
            // 2μ Δt sym(D b)), b = b_trial − Δt sym(D b_trial) half way back
            let step = motion.strain_increment.to_tensor();
            let moved = inlined!(|metric: SymmetricTensor<R>| step.dot(&metric.to_tensor()).symmetric_part());
            let half_way = trial - moved(trial);
            let strained = moved(half_way) * R::splat(2.0 * self.elasticity.shear_modulus());
            let heat = stress_power(&(trial_stress - strained), &state.stress, &returned.flow) * gradient.determinant();
            state.memory = self.hardening.heated(old.memory, R::select(yields, heat, zero).max(zero));
        }
        MaterialUpdate {
            state,
            internal_energy: stress_power(&old.stress, &state.stress, &motion.strain_increment),
            plastic_dissipation: dissipation,
        }
    }

    #[inline(always)]
    fn equivalent_plastic_strain<R: Real>(&self, state: &Self::State<R>) -> R {
        state.equivalent_plastic_strain
    }

    #[inline(always)]
    fn cauchy_stress<R: Real>(&self, state: &Self::State<R>, _: Rotation<R>) -> SymmetricTensor<R> {
        state.stress
    }

    fn plastic_metric(&self, state: &Self::State<f64>, _: &SymmetricTensor<f64>) -> SymmetricTensor<f64> {
        state.plastic_metric()
    }

    /// Φ = H/(3μ n² : b_e + H).
    fn hardening_index(&self, state: &Self::State<f64>, gradient: &Tensor<f64>) -> Option<f64> {
        let flow_stress = von_mises(&state.stress.deviator());
        let slope = self.hardening.slope_of_flow(state.equivalent_plastic_strain, &state.memory, flow_stress);
        Some(slope / (elastic_slope(&self.elasticity, &state.inverse_plastic_metric.pushed_by(gradient)) + slope))
    }

    /// √(3/2) ‖dev T‖.
    fn yield_criterion(&self, state: &Self::State<f64>, motion: &SpatialMotion<f64>) -> Option<YieldCriterion> {
        let trial = self.stress(&state.inverse_plastic_metric.pushed_by(&motion.deformation_gradient));
        let strain = state.equivalent_plastic_strain;
        YieldCriterion::under(&self.hardening, strain, &state.memory, von_mises(&trial.deviator()))
    }

    #[inline(always)]
    fn temperature<R: Real>(&self, state: &Self::State<R>) -> Option<R> {
        self.hardening.temperature(&state.memory)
    }

    fn heat_share(&self) -> Option<f64> {
        self.hardening.heat_share()
    }
}

/// −dq/dp = 3μ n² : b_e, Pa, of q = √(3/2) μ ‖dev b_e‖ along the flow db_e/dp = −√6 n b_e with n = dev b_e/‖dev b_e‖.
pub(crate) fn elastic_slope(elasticity: &IsotropicElasticity, elastic_metric: &SymmetricTensor<f64>) -> f64 {
    let deviator = elastic_metric.deviator();
    let direction = deviator.square() * deviator.norm_squared().max(f64::MIN_POSITIVE).recip();
    3.0 * elasticity.shear_modulus() * direction.double_dot(elastic_metric)
}

const SQRT_6: f64 = 2.449_489_742_783_178;
const SQRT_3_HALVES: f64 = 1.224_744_871_391_589;
const SQRT_2_THIRDS: f64 = 0.816_496_580_927_726;

/// a I + b n + c n² for a symmetric n with tr n = 0 and ‖n‖ = 1, for which n³ = ½ n + d I and n⁴ = ½ n² + d n,
/// d = det n.
#[derive(Clone, Copy)]
pub(crate) struct Combination<R>(pub [R; 3]);

impl<R: Real> Combination<R> {
    /// exp(x n): its series up to x¹¹ for x/2ˢ, squared s times; exact to rounding for |x| ≤ 2ˢ⁻² √⅔.
    #[inline(always)]
    pub(crate) fn exponential<const SQUARINGS: u32>(x: R, determinant: R) -> Self {
        let part = x * f64::from(1_u32 << SQUARINGS).recip();
        let one = R::splat(1.0);
        // 1 + y n (1 + y n/2 (1 + y n/3 (…))), y = x/2ˢ
        let mut sum = Self([one, R::splat(0.0), R::splat(0.0)]);
        for order in (1..=11_u32).rev() {
            let scale = part * f64::from(order).recip();
            let [a, b, c] = sum.times_normal(determinant).0;
            sum = Self([a.mul_add(scale, one), b * scale, c * scale]);
        }
        for _ in 0..SQUARINGS {
            sum = sum.times(&sum, determinant);
        }
        sum
    }

    /// n times the combination.
    #[inline(always)]
    fn times_normal(&self, determinant: R) -> Self {
        let [a, b, c] = self.0;
        Self([c * determinant, c.mul_add(R::splat(0.5), a), b])
    }

    /// The product of two combinations.
    #[inline(always)]
    fn times(&self, other: &Self, determinant: R) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        let third = b * z + c * y;
        let fourth = c * z;
        Self([
            a.mul_add(x, third * determinant),
            a.mul_add(y, b.mul_add(x, third.mul_add(R::splat(0.5), fourth * determinant))),
            a.mul_add(z, c.mul_add(x, b.mul_add(y, fourth * 0.5))),
        ])
    }

    /// dev A : dev B, from n : n = 1, n : n² = 3 d and dev n² : dev n² = ½ − ⅓.
    #[inline(always)]
    fn deviator_dot(&self, other: &Self, determinant: R) -> R {
        let ([_, b, c], [_, y, z]) = (self.0, other.0);
        let mixed = (b * z + c * y) * determinant;
        b * y + mixed * 3.0 + c * z * (1.0 / 6.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponential_of_a_normal_is_that_of_its_principal_values() {
        for (first, second) in [(1.0, -1.0), (2.0, -1.0), (0.3, 0.3), (1.0, 0.0), (-2.0, 1.0)] {
            let raw = [first, second, -first - second];
            let length = raw.iter().map(|v: &f64| v * v).sum::<f64>().sqrt();
            let values = raw.map(|v| v / length);
            let determinant = values.iter().product();
            for x in [0.0, 1e-6, -0.01, 0.3, -0.6, -0.8165, 0.8165] {
                let Combination([a, b, c]) = Combination::exponential::<2>(x, determinant);
                for value in values {
                    let error = (a + b * value + c * value * value) / (x * value).exp() - 1.0;
                    assert!(error.abs() < 4e-15, "{raw:?} {x}: {error}");
                }
            }
        }
    }
}
