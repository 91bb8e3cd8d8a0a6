//! Hyperelasticity with a flow rule for the plastic metric C_p = F_pᵀF_p: seven rules of the literature, compared in
//! Neff & Ghiba, "Comparison of isotropic elasto-plastic models for the plastic metric tensor C_p = F_pᵀF_p" (cited as NG).
//!
//! b_e = F C_p⁻¹ Fᵀ, Kirchhoff stress τ = J T, Σ̃ = 2 C ∂W̃(C C_p⁻¹)/∂C = Fᵀ τ F⁻ᵀ, Σ_e = F_eᵀ τ F_e⁻ᵀ, n_τ = dev τ/‖dev τ‖:
//!
//! - elasticity   Hencky: W = μ ε : ε + ½ λ (tr ε)², ε = ½ ln b_e; neo-Hooke: W = ½ μ (tr b_e − 3 − 2 ln J_e) + ½ λ (ln J_e)²,
//!   whose dev Σ̃ = μ dev(C C_p⁻¹) is that of NG A.7
//! - yield        √(3/2) ‖dev τ‖ ≤ σ_y(ε̄ᵖ), which is √(3/2 tr (dev Σ̃)²) and √(3/2) ‖dev Σ_e‖; the Frobenius-normal rule has
//!   √(3/2) ‖dev Σ̃‖ instead
//! - flow         see [`FlowRule`]; ε̄̇ᵖ = √⅔ γ̇
//!
//! The factors of the multiplier are such that all rules have D_p = γ̇ n where elastic strain is small: λ = γ̇ in the rules of
//! Simo & Miehe and of Simo & Hughes, 2 γ̇ in the others.
//!
//! Update: stress and Δγ from the return of b_trial along its own principal axes, then each rule moves its own tensor in its
//! own configuration, by the exponential of its own flow direction where that keeps what the rule keeps. An exponential of
//! x N for N similar to n_τ is a combination of I, N and N² with the coefficients of n_τ. What a consistent rule keeps,
//! C_p symmetric and det C_p = 1, is cleared of rounding. The rule of Simo & Hughes keeps no determinant and moves along a
//! straight line. The Frobenius-normal rule moves C_p out of the symmetric tensors. W̃ is a function of the invariants of
//! C C_p⁻¹ all the same, which are those of B = F C_p⁻¹ Fᵀ: with a symmetric ∂W̃/∂C the stress is τ = μ sym(ln B) + ½ λ tr(ln B) I
//! of Hencky's energy and μ (sym B − I) + ½ λ ln(det B) I of neo-Hooke's, and the pressure is that of J. What such a step
//! dissipates is the fall of W̃ at fixed C, which can be below zero: the source shows that it is not, for the Σ̃ of a ∂W̃/∂C that is
//! not symmetrized, Fᵀ (μ ln Bᵀ) F⁻ᵀ, but along that Σ̃ the paths of the tests soon come to where no flow is admissible. So can both
//! of these rules; the stress is infinite then, and who leads the point is told.
//!
//! Parameters: elasticity, hardening, energy, flow rule. History: C_p⁻¹ with nine components, ε̄ᵖ, and T for the stress power.

use crate::e_star::von_mises;
use crate::e_star_total::{Combination, EStarTotal, elastic_slope};
use crate::elastic::stress_power;
use crate::hencky::hencky_strain;
use crate::logarithm::logarithm;
use crate::point_state;
use crate::principal_surface::{PrincipalSurface, VonMises};
use crate::return_mapping::radial_hardening_index;
use crate::tangent_bound::{logarithmic, neo_hooke};
use crate::{
    FlowStart, IsotropicElasticity, IsotropicHardening, Material, MaterialUpdate, SpatialMotion, YieldCriterion,
};
use estar_tensor::{Mask, Real, Rotation, SymmetricTensor, Tensor, Vector3, array, inlined};

/// Hyperelasticity with a flow rule for the plastic metric.
#[derive(Clone, Debug, PartialEq)]
pub struct PlasticMetric {
    elasticity: IsotropicElasticity,
    hardening: IsotropicHardening,
    energy: ElasticEnergy,
    rule: FlowRule,
    /// The return with Hencky's energy.
    hencky: VonMises<IsotropicHardening>,
    /// The return with an energy whose stress is linear in dev b_e.
    linear: EStarTotal<IsotropicHardening>,
}

/// The elastic energy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ElasticEnergy {
    /// Quadratic in the logarithmic strain.
    Hencky,
    /// Linear in tr b_e.
    NeoHooke,
}

/// A flow rule for C_p.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlowRule {
    /// Simo & Miehe 1992: dC_p⁻¹/dt = −2 γ̇ F⁻¹ n_τ b_e F⁻ᵀ (NG 2.3).
    SimoMiehe,
    /// Miehe 1995: dC_p⁻¹/dt C_p = −2 γ̇ (dev Σ̃)ᵀ/√tr (dev Σ̃)² (NG 3.5).
    Miehe,
    /// Lion 1997: dC_p⁻¹/dt = −2 γ̇ F_p⁻¹ (dev Σ_e/‖dev Σ_e‖) F_p⁻ᵀ (NG 4.1).
    Lion,
    /// Simo & Hughes 1998: dC_p⁻¹/dt = −⅔ γ̇ tr(b_e) F⁻¹ n_τ F⁻ᵀ (NG 5.1).
    SimoHughes,
    /// Helm 2001: dC_p/dt = 2 γ̇ dev Σ̃/√tr (dev Σ̃)² C_p (NG 6.1).
    Helm,
    /// Grandi & Stefanelli 2015: √C_p dC_p⁻¹/dt √C_p = −2 γ̇ dev Σ°/‖dev Σ°‖, Σ° = √C_p⁻¹ Σ̃ √C_p (NG 7.2).
    GrandiStefanelli,
    /// Normal to ‖dev Σ̃‖ in the reference configuration: dC_p⁻¹/dt = −2 γ̇ (dev Σ̃/‖dev Σ̃‖) C_p⁻¹ (NG A.12).
    FrobeniusNormal,
}

impl FlowRule {
    /// All of them, in the order of their years.
    pub const ALL: [Self; 7] = [
        Self::SimoMiehe,
        Self::Miehe,
        Self::Lion,
        Self::SimoHughes,
        Self::Helm,
        Self::GrandiStefanelli,
        Self::FrobeniusNormal,
    ];

    /// The deck's name of the rule.
    pub fn name(self) -> &'static str {
        match self {
            Self::SimoMiehe => "simo-miehe",
            Self::Miehe => "miehe",
            Self::Lion => "lion",
            Self::SimoHughes => "simo-hughes",
            Self::Helm => "helm",
            Self::GrandiStefanelli => "grandi-stefanelli",
            Self::FrobeniusNormal => "frobenius-normal",
        }
    }

    /// What the rule does not keep of C_p symmetric and positive definite with det C_p = 1 (NG definition 1.2), if anything.
    pub fn fault(self) -> Option<&'static str> {
        match self {
            Self::SimoHughes => Some("it does not keep det C_p = 1: plastic flow changes the volume (NG remark 5.1)"),
            Self::FrobeniusNormal => Some("it does not keep C_p symmetric: there is no plastic metric (NG A.3)"),
            Self::SimoMiehe | Self::Miehe | Self::Lion | Self::Helm | Self::GrandiStefanelli => None,
        }
    }
}

/// History of [`PlasticMetric`].
#[derive(Clone, Copy, Debug)]
pub struct PlasticMetricState<R> {
    /// C_p⁻¹.
    pub inverse_plastic_metric: Tensor<R>,
    /// Equivalent plastic strain ε̄ᵖ.
    pub equivalent_plastic_strain: R,
    /// Cauchy stress T, Pa.
    pub stress: SymmetricTensor<R>,
}

point_state!(PlasticMetricState {
    inverse_plastic_metric: tensor,
    equivalent_plastic_strain: number,
    stress: symmetric,
});

/// The state at the end of a step.
struct Moved<R: Real> {
    yields: R::Mask,
    /// C_p⁻¹ as the rule has moved it, not cleared of rounding.
    inverse_plastic_metric: Tensor<R>,
    plastic_increment: R,
    kirchhoff: SymmetricTensor<R>,
    /// Δε_p in space.
    flow: SymmetricTensor<R>,
}

impl PlasticMetric {
    /// The material with these parameters.
    pub fn new(
        elasticity: IsotropicElasticity,
        hardening: IsotropicHardening,
        energy: ElasticEnergy,
        rule: FlowRule,
    ) -> Self {
        let hencky = VonMises { hardening: hardening.clone() };
        let linear = EStarTotal::new(elasticity, hardening.clone());
        Self { elasticity, hardening, energy, rule, hencky, linear }
    }

    /// The flow rule.
    pub fn rule(&self) -> FlowRule {
        self.rule
    }

    /// The same material with another flow rule.
    pub fn with_rule(&self, rule: FlowRule) -> Self {
        Self { rule, ..self.clone() }
    }

    /// W of F and C_p⁻¹, J per m³ of reference volume.
    pub fn elastic_energy(&self, gradient: &Tensor<f64>, inverse_plastic_metric: &Tensor<f64>) -> f64 {
        if self.rule == FlowRule::FrobeniusNormal {
            return self.energy_of_invariants(&in_space(inverse_plastic_metric, gradient));
        }
        let [mu, lambda] = [self.elasticity.shear_modulus(), self.elasticity.lame_lambda()];
        let metric = inverse_plastic_metric.symmetric_part().pushed_by(gradient);
        let values = metric.eigensystem().values;
        let logarithms = values.map(|value| 0.5 * value.ln());
        let sum: f64 = logarithms.iter().sum();
        let shape = match self.energy {
            ElasticEnergy::Hencky => logarithms.iter().map(|strain| strain * strain).sum(),
            ElasticEnergy::NeoHooke => 0.5 * (metric.trace() - 3.0) - sum,
        };
        mu * shape + 0.5 * lambda * sum * sum
    }

    /// τ of b_e.
    #[inline(always)]
    fn kirchhoff_stress<R: Real>(&self, elastic_metric: &SymmetricTensor<R>) -> SymmetricTensor<R> {
        match self.energy {
            ElasticEnergy::Hencky => {
                let system = elastic_metric.eigensystem();
                let stress = self.elasticity.principal_stress(hencky_strain(&system.values));
                SymmetricTensor::diagonal(stress).pushed_by(&system.vectors)
            }
            ElasticEnergy::NeoHooke => {
                // τ = μ (b_e − I) + λ ln J_e I
                let squared_volume = elastic_metric.determinant().max(R::splat(f64::MIN_POSITIVE));
                let spherical = squared_volume.ln() * (0.5 * self.elasticity.lame_lambda());
                let mu = self.elasticity.shear_modulus();
                (*elastic_metric * R::splat(mu)).plus_spherical(spherical - mu)
            }
        }
    }

    /// τ of B = F C_p⁻¹ Fᵀ, which need not be symmetric.
    #[inline(never)]
    fn kirchhoff_stress_of_invariants<R: Real>(&self, metric: &Tensor<R>) -> SymmetricTensor<R> {
        let [mu, half_lambda] = [self.elasticity.shear_modulus(), 0.5 * self.elasticity.lame_lambda()];
        match self.energy {
            ElasticEnergy::Hencky => {
                let logarithm = logarithm(metric);
                (logarithm.symmetric_part() * R::splat(mu)).plus_spherical(logarithm.trace() * half_lambda)
            }
            ElasticEnergy::NeoHooke => {
                let spherical = metric.determinant().ln() * half_lambda;
                (metric.symmetric_part() * R::splat(mu)).plus_spherical(spherical - mu)
            }
        }
    }

    /// W of B = F C_p⁻¹ Fᵀ, which need not be symmetric.
    fn energy_of_invariants<R: Real>(&self, metric: &Tensor<R>) -> R {
        let [mu, lambda] = [self.elasticity.shear_modulus(), self.elasticity.lame_lambda()];
        // with ε = ½ ln B: tr ε and, of Hencky's energy, tr ε², of neo-Hooke's ½ (tr B − 3) − tr ε
        let (sum, shape) = match self.energy {
            ElasticEnergy::Hencky => {
                let strain = logarithm(metric) * R::splat(0.5);
                (strain.trace(), strain.dot(&strain).trace())
            }
            ElasticEnergy::NeoHooke => {
                let sum = metric.determinant().ln() * 0.5;
                (sum, (metric.trace() - 3.0) * 0.5 - sum)
            }
        };
        shape * mu + sum * sum * (0.5 * lambda)
    }

    /// τ of F and C_p⁻¹.
    #[inline(always)]
    fn kirchhoff_stress_at<R: Real>(&self, metric: &Tensor<R>, gradient: &Tensor<R>) -> SymmetricTensor<R> {
        match self.rule {
            FlowRule::FrobeniusNormal => self.kirchhoff_stress_of_invariants(&in_space(metric, gradient)),
            _ => self.kirchhoff_stress(&metric.symmetric_part().pushed_by(gradient)),
        }
    }

    /// What the yield radius bounds, √(3/2) times it: ‖dev Σ̃‖ with dev Σ̃ = Fᵀ dev τ F⁻ᵀ, or ‖dev τ‖.
    #[inline(always)]
    fn equivalent_stress<R: Real>(&self, kirchhoff: &SymmetricTensor<R>, gradient: &Tensor<R>) -> R {
        let deviator = kirchhoff.deviator();
        match self.rule {
            FlowRule::FrobeniusNormal => (referential(&deviator, gradient).norm_squared() * 1.5).sqrt(),
            _ => von_mises(&deviator),
        }
    }

    /// C_p⁻¹ after a step to `gradient`, as the rule moves it, not cleared of rounding: what the rule keeps by itself.
    pub fn moved_by_rule(&self, old: &PlasticMetricState<f64>, gradient: &Tensor<f64>) -> Tensor<f64> {
        self.moved(old, gradient).inverse_plastic_metric
    }

    #[inline(always)]
    fn moved<R: Real>(&self, old: &PlasticMetricState<R>, gradient: &Tensor<R>) -> Moved<R> {
        match self.rule.fault() {
            None => self.consistent_step(old, gradient),
            Some(_) => self.inconsistent_step(old, gradient),
        }
    }

    /// The step of a rule that keeps the principal axes of b_trial = F C_p⁻¹ Fᵀ.
    #[inline(always)]
    fn consistent_step<R: Real>(&self, old: &PlasticMetricState<R>, gradient: &Tensor<R>) -> Moved<R> {
        let metric_old = old.inverse_plastic_metric;
        let start = FlowStart::new(old.equivalent_plastic_strain, (), 0.0);

        // (i) elastic predictor
        let trial = metric_old.symmetric_part().pushed_by(gradient);

        // (ii) admissibility and (iii) return mapping: Δε_p = Δγ n_τ in space
        let (yields, kirchhoff, flow, plastic_increment) = match self.energy {
            ElasticEnergy::Hencky => {
                let system = trial.eigensystem();
                let strain = hencky_strain(&system.values);
                let returned = self.hencky.returned(&self.elasticity, strain, &start);
                let stress = self.elasticity.principal_stress(array(|i| strain[i] - returned.flow[i]));
                let in_space = inlined!(|values: [R; 3]| SymmetricTensor::diagonal(values).pushed_by(&system.vectors));
                (returned.yields, in_space(stress), in_space(returned.flow), returned.plastic_increment)
            }
            ElasticEnergy::NeoHooke => {
                let stress = self.kirchhoff_stress(&trial);
                let flow_stress = self.hardening.at(old.equivalent_plastic_strain);
                let yields = von_mises(&stress.deviator()).gt(flow_stress.stress);
                if yields.any() {
                    let returned = self.linear.return_mapping(yields, &trial, &start);
                    let returned_stress = self.kirchhoff_stress(&returned.elastic_metric);
                    let stress = SymmetricTensor::select(yields, &returned_stress, &stress);
                    (yields, stress, returned.flow, returned.plastic_increment)
                } else {
                    (yields, stress, SymmetricTensor::zero(), R::splat(0.0))
                }
            }
        };

        let mut inverse_plastic_metric = metric_old;
        if yields.any() {
            let moved = self.moved_metric(&metric_old, gradient, &trial, &flow);
            inverse_plastic_metric = select(yields, &moved, &metric_old);
        }
        Moved { yields, inverse_plastic_metric, plastic_increment, kirchhoff, flow }
    }

    /// C_p⁻¹ after the flow Δγ n_τ, by the rule's own exponential in its own configuration.
    #[inline(always)]
    fn moved_metric<R: Real>(
        &self,
        metric: &Tensor<R>,
        gradient: &Tensor<R>,
        trial: &SymmetricTensor<R>,
        flow: &SymmetricTensor<R>,
    ) -> Tensor<R> {
        let length_squared = flow.norm_squared();
        let flows = length_squared.gt(R::splat(0.0));
        let length = R::select(flows, length_squared, R::splat(1.0)).sqrt();
        let normal = *flow * length.recip();
        let twice = R::select(flows, length * 2.0, R::splat(0.0));
        let determinant = normal.determinant();
        let normal = normal.to_tensor();
        let inverse = gradient.inverse();
        match self.rule {
            FlowRule::SimoMiehe => {
                // b_e = exp(−2 Δγ n_τ) b_trial, C_p⁻¹ = F⁻¹ b_e F⁻ᵀ
                let elastic_metric = exponential(-twice, &normal, determinant).dot(&trial.to_tensor());
                inverse.dot(&elastic_metric).dot(&inverse.transpose())
            }
            FlowRule::Miehe => {
                // C_p⁻¹ ← exp(−2 Δγ F⁻¹ n_τ F) C_p⁻¹, where F⁻¹ n_τ F = (dev Σ̃)ᵀ/√tr (dev Σ̃)²
                let direction = inverse.dot(&normal.dot(gradient));
                exponential(-twice, &direction, determinant).dot(metric)
            }
            FlowRule::Helm => {
                // C_p ← exp(2 Δγ Fᵀ n_τ F⁻ᵀ) C_p
                let direction = gradient.transpose_dot(&normal.dot(&inverse.transpose()));
                exponential(twice, &direction, determinant).dot(&metric.inverse()).inverse()
            }
            // the last two have a step of their own
            FlowRule::Lion | FlowRule::GrandiStefanelli | FlowRule::SimoHughes | FlowRule::FrobeniusNormal => {
                // F_p⁻¹ with C_p⁻¹ = F_p⁻¹ F_p⁻ᵀ: Lion's F_p may be any, and is triangular here; √C_p is symmetric
                let symmetric = metric.symmetric_part();
                let factor =
                    if self.rule == FlowRule::Lion { triangular_root(&symmetric) } else { square_root(&symmetric) };
                // C_p⁻¹ ← F_p⁻¹ exp(−2 Δγ F_eᵀ n_τ F_e⁻ᵀ) F_p⁻ᵀ with F_e = F F_p⁻¹ of the trial
                let elastic = gradient.dot(&factor);
                let direction = elastic.transpose_dot(&normal.dot(&elastic.inverse().transpose()));
                factor.dot(&exponential(-twice, &direction, determinant)).dot(&factor.transpose())
            }
        }
    }

    /// W(C, C_p,n) − W(C, C_p,n+1), the mean of that at the C of t_n and of t_{n+1}, J per m³ of the mid-step volume. Below zero
    /// where a rule gains energy.
    #[inline(never)]
    fn fall_of_energy<R: Real>(
        &self,
        old: &PlasticMetricState<R>,
        metric_new: &Tensor<R>,
        motion: &SpatialMotion<R>,
    ) -> R {
        // F_{n+½} = (I + ½ Δt D)⁻¹ F_{n+1} and F_n = (I − ½ Δt D) F_{n+½}, but for a turn
        let half_step = motion.strain_increment.to_tensor() * R::splat(0.5);
        let gradient_new = motion.deformation_gradient;
        let gradient_half = half_step.plus_spherical(R::splat(1.0)).inverse().dot(&gradient_new);
        let gradient_old = (Tensor::identity() - half_step).dot(&gradient_half);
        let energy = |metric: &Tensor<R>, gradient: &Tensor<R>| self.energy_of_invariants(&in_space(metric, gradient));
        let fall = |gradient: &Tensor<R>| energy(&old.inverse_plastic_metric, gradient) - energy(metric_new, gradient);
        (fall(&gradient_old) + fall(&gradient_new)) * 0.5 / gradient_half.determinant()
    }

    /// The step of a rule that leaves the principal axes of b_trial or its determinant: the Δγ with which its own yield
    /// stress is met at the end, by bisection. No element takes it, so that it need not be fast.
    #[inline(never)]
    fn inconsistent_step<R: Real>(&self, old: &PlasticMetricState<R>, gradient: &Tensor<R>) -> Moved<R> {
        let zero = R::splat(0.0);
        let metric_old = old.inverse_plastic_metric;
        let inverse = gradient.inverse();

        // (i) elastic predictor, (ii) admissibility
        let trial = in_space(&metric_old, gradient);
        let trial_stress = self.kirchhoff_stress_at(&metric_old, gradient);
        let deviator = trial_stress.deviator();
        let trial_equivalent = self.equivalent_stress(&trial_stress, gradient);
        let yields = trial_equivalent.gt(self.hardening.at(old.equivalent_plastic_strain).stress);

        // (iii) return mapping along the direction of the trial
        let safe = |length: R| R::select(yields, length, R::splat(1.0));
        let norm = safe(deviator.norm_squared().sqrt());
        let normal = deviator * norm.recip();
        let determinant = normal.determinant();
        let in_reference = referential(&normal, gradient);
        let shrinking = safe(in_reference.norm_squared().sqrt()).recip();
        let line = normal.pushed_by(&inverse).to_tensor();
        let moved_metric = |p: R| {
            let multiplier = p * SQRT_3_HALVES;
            if self.rule == FlowRule::FrobeniusNormal {
                // C_p⁻¹ ← exp(−2 Δγ dev Σ̃/‖dev Σ̃‖) C_p⁻¹
                exponential(multiplier * -2.0 * shrinking, &in_reference, determinant).dot(&metric_old)
            } else {
                // C_p⁻¹ ← C_p⁻¹ − ⅔ Δγ tr(b_e) F⁻¹ n_τ F⁻ᵀ
                metric_old - line * (multiplier * trial.trace() * (2.0 / 3.0))
            }
        };
        let is_outside = |p: R| {
            let stress = self.kirchhoff_stress_at(&moved_metric(p), gradient);
            let flow_stress = self.hardening.at(old.equivalent_plastic_strain + p).stress;
            // what is not a number is not admissible
            yields & !self.equivalent_stress(&stress, gradient).le(flow_stress)
        };
        let (mut low, mut high) = (zero, trial_equivalent * (3.0 * self.elasticity.shear_modulus()).recip());
        for _ in 0..MOST_DOUBLINGS {
            let outside = is_outside(high);
            if !outside.any() {
                break;
            }
            high = R::select(outside, high * 2.0, high);
        }
        for _ in 0..BISECTIONS {
            let middle = (low + high) * 0.5;
            let outside = is_outside(middle);
            low = R::select(outside, middle, low);
            high = R::select(outside, high, middle);
        }
        // these two rules can lead where no flow along them is admissible any more: there the stress is infinite
        let is_lost = is_outside(high);
        let flows = yields & !is_lost;
        let plastic_increment = R::select(flows, high, zero);

        let inverse_plastic_metric = select(flows, &moved_metric(plastic_increment), &metric_old);
        let elastic_metric = in_space(&inverse_plastic_metric, gradient);
        let kirchhoff = self.kirchhoff_stress_at(&inverse_plastic_metric, gradient);
        let nowhere = SymmetricTensor::spherical(R::splat(f64::INFINITY));
        // D_p = −½ sym(L_v b_e b_e⁻¹)
        let lie = (elastic_metric - trial).dot(&elastic_metric.inverse());
        Moved {
            yields,
            inverse_plastic_metric,
            plastic_increment,
            kirchhoff: SymmetricTensor::select(is_lost, &nowhere, &kirchhoff),
            flow: (lie.symmetric_part() * R::splat(-0.5)).or_zero(flows),
        }
    }
}

/// F C_p⁻¹ Fᵀ.
#[inline(always)]
fn in_space<R: Real>(metric: &Tensor<R>, gradient: &Tensor<R>) -> Tensor<R> {
    gradient.dot(&metric.dot(&gradient.transpose()))
}

/// Fᵀ A F⁻ᵀ.
#[inline(always)]
fn referential<R: Real>(tensor: &SymmetricTensor<R>, gradient: &Tensor<R>) -> Tensor<R> {
    gradient.transpose_dot(&tensor.to_tensor().dot(&gradient.inverse().transpose()))
}

const SQRT_3_HALVES: f64 = 1.224_744_871_391_589;
/// The bracket of the increment, at first that of a radial return, doubles until it holds the root, at most this often.
const MOST_DOUBLINGS: usize = 6;
/// Halvings of the bracket to the last bit.
const BISECTIONS: usize = 60;

/// exp(x N) for an N similar to a symmetric one with tr N = 0, tr N² = 1 and det N = `determinant`.
#[inline(always)]
fn exponential<R: Real>(x: R, normal: &Tensor<R>, determinant: R) -> Tensor<R> {
    // |x| ≤ 2⁶ √⅔ covers every strain
    let Combination([identity, linear, quadratic]) = Combination::exponential::<8>(x, determinant);
    (*normal * linear + normal.dot(normal) * quadratic).plus_spherical(identity)
}

/// The lower triangular L with positive diagonal and L Lᵀ = A (Cholesky).
#[inline(always)]
fn triangular_root<R: Real>(a: &SymmetricTensor<R>) -> Tensor<R> {
    let [xx, yy, zz, xy, yz, xz] = a.0;
    let zero = R::splat(0.0);
    let least = lost_in_rounding(a.trace());
    let l11 = xx.max(least).sqrt();
    let (l21, l31) = (xy / l11, xz / l11);
    let l22 = (yy - l21 * l21).max(least).sqrt();
    let l32 = (yz - l31 * l21) / l22;
    let l33 = (zz - l31 * l31 - l32 * l32).max(least).sqrt();
    Tensor { columns: [Vector3([l11, l21, l31]), Vector3([zero, l22, l32]), Vector3([zero, zero, l33])] }
}

/// A principal value below it, beside the `largest`, is rounding, whatever its sign.
#[inline(always)]
fn lost_in_rounding<R: Real>(largest: R) -> R {
    (largest * f64::EPSILON).max(R::splat(f64::MIN_POSITIVE))
}

/// The symmetric B with B² = A.
#[inline(always)]
fn square_root<R: Real>(a: &SymmetricTensor<R>) -> Tensor<R> {
    let system = a.eigensystem();
    let least = lost_in_rounding(system.values[0]);
    let roots = array(|i| system.values[i].max(least).sqrt());
    SymmetricTensor::diagonal(roots).pushed_by(&system.vectors).to_tensor()
}

/// `chosen` where the mask is set, else `otherwise`.
#[inline(always)]
fn select<R: Real>(mask: R::Mask, chosen: &Tensor<R>, otherwise: &Tensor<R>) -> Tensor<R> {
    Tensor { columns: array(|j| Vector3(array(|i| R::select(mask, chosen.at(i, j), otherwise.at(i, j))))) }
}

impl Material for PlasticMetric {
    type State<R: Real> = PlasticMetricState<R>;

    type Motion<R: Real> = SpatialMotion<R>;

    fn elasticity(&self) -> &IsotropicElasticity {
        &self.elasticity
    }

    /// The moduli are those of the Kirchhoff stress.
    #[inline(always)]
    fn stiffening<R: Real>(&self, state: &PlasticMetricState<R>, motion: &SpatialMotion<R>) -> Option<R> {
        let gradient = &motion.deformation_gradient;
        let jacobian = gradient.determinant();
        let kirchhoff = state.stress * jacobian;
        let tangent = match self.energy {
            ElasticEnergy::Hencky => logarithmic(&self.elasticity, &kirchhoff),
            ElasticEnergy::NeoHooke => {
                let elastic_metric = state.inverse_plastic_metric.symmetric_part().pushed_by(gradient);
                neo_hooke(&self.elasticity, &kirchhoff, elastic_metric.trace() * (1.0 / 3.0))
            }
        };
        Some(tangent.over_rest(&self.elasticity) / jacobian)
    }

    fn initial_state<R: Real>(&self) -> PlasticMetricState<R> {
        PlasticMetricState {
            inverse_plastic_metric: Tensor::identity(),
            equivalent_plastic_strain: R::splat(0.0),
            stress: SymmetricTensor::zero(),
        }
    }

    #[inline(always)]
    fn update<R: Real>(
        &self,
        old: &PlasticMetricState<R>,
        motion: &SpatialMotion<R>,
        _: f64,
    ) -> MaterialUpdate<R, PlasticMetricState<R>> {
        let gradient = &motion.deformation_gradient;
        let mut moved = self.moved(old, gradient);
        if self.rule.fault().is_none() && moved.yields.any() {
            let symmetric = moved.inverse_plastic_metric.symmetric_part().to_tensor();
            // where the determinant is no rounding of 1, stretches of many decades have eaten all digits: C_p stays
            let determinant = symmetric.determinant();
            let is_rounding = determinant.gt(R::splat(0.5)) & determinant.lt(R::splat(2.0));
            let cleared = symmetric * R::select(is_rounding, determinant, R::splat(1.0)).cbrt().recip();
            moved.inverse_plastic_metric = select(moved.yields & is_rounding, &cleared, &old.inverse_plastic_metric);
        }
        let stress = moved.kirchhoff * gradient.determinant().recip();
        let dissipation = match self.rule {
            FlowRule::FrobeniusNormal => self.fall_of_energy(old, &moved.inverse_plastic_metric, motion),
            _ => stress_power(&old.stress, &stress, &moved.flow).max(R::splat(0.0)),
        };
        MaterialUpdate {
            state: PlasticMetricState {
                inverse_plastic_metric: moved.inverse_plastic_metric,
                equivalent_plastic_strain: old.equivalent_plastic_strain + moved.plastic_increment,
                stress,
            },
            internal_energy: stress_power(&old.stress, &stress, &motion.strain_increment),
            plastic_dissipation: dissipation,
        }
    }

    #[inline(always)]
    fn equivalent_plastic_strain<R: Real>(&self, state: &PlasticMetricState<R>) -> R {
        state.equivalent_plastic_strain
    }

    #[inline(always)]
    fn cauchy_stress<R: Real>(&self, state: &PlasticMetricState<R>, _: Rotation<R>) -> SymmetricTensor<R> {
        state.stress
    }

    /// C_p, its symmetric part where a rule loses the symmetry.
    fn plastic_metric(&self, state: &PlasticMetricState<f64>, _: &SymmetricTensor<f64>) -> SymmetricTensor<f64> {
        state.inverse_plastic_metric.inverse().symmetric_part()
    }

    /// Φ = H/(3μ + H) with Hencky's energy, H/(3μ n² : b_e + H) with neo-Hooke's; none of a rule that is not consistent.
    fn hardening_index(&self, state: &PlasticMetricState<f64>, gradient: &Tensor<f64>) -> Option<f64> {
        let slope = self.hardening.at(state.equivalent_plastic_strain).slope;
        let index = match self.energy {
            ElasticEnergy::Hencky => radial_hardening_index(&self.elasticity, slope),
            ElasticEnergy::NeoHooke => {
                let elastic_metric = state.inverse_plastic_metric.symmetric_part().pushed_by(gradient);
                slope / (elastic_slope(&self.elasticity, &elastic_metric) + slope)
            }
        };
        self.rule.fault().is_none().then_some(index)
    }

    /// The rule's own equivalent stress.
    fn yield_criterion(&self, state: &PlasticMetricState<f64>, motion: &SpatialMotion<f64>) -> Option<YieldCriterion> {
        let gradient = &motion.deformation_gradient;
        let trial = self.kirchhoff_stress_at(&state.inverse_plastic_metric, gradient);
        let equivalent_stress = self.equivalent_stress(&trial, gradient);
        YieldCriterion::under(&self.hardening, state.equivalent_plastic_strain, &(), equivalent_stress)
    }

    fn obstacle_to_elements(&self) -> Option<&'static str> {
        self.rule.fault()
    }
}
