//! Objective rates of the Cauchy stress, and isotropic elasticity in rate form with each of them.
//!
//! T° = 2μ dev D + k tr(D) I, where T° is (de Vera 2016, section 6.5; L = D + W)
//!
//! - box (Green-McInnis, Green-Naghdi)   Ṫ − ΩT + TΩ, Ω = ṘRᵀ
//! - Jaumann                             Ṫ − WT + TW
//! - logarithmic                         Ṫ − Ω_log T + T Ω_log (Xiao, Bruhns & Meyers 1997)
//! - Truesdell                           Ṫ − LT − TLᵀ + tr(D) T
//! - upper convected (Oldroyd)           Ṫ − LT − TLᵀ
//! - lower convected (Cotter-Rivlin)     Ṫ + LᵀT + TL (dV 6.84; dV 2.52 has the signs otherwise)
//!
//! Each has the form Ṫ − ΛT − TΛᵀ (+ tr(D) T): the rate seen by an observer whom Λ carries along. The stress is carried from
//! t_n to mid-step by a tensor A, grows there, and is carried on to t_{n+1} by a tensor B,
//!
//! T_{n+1} = B (A T_n Aᵀ + Δt (2μ dev D + k tr(D) I)) Bᵀ,
//!
//! which is of second order in the step and exactly objective.
//!
//! The stress of a closed cycle of strain returns to zero with the logarithmic rate alone, which gives T = 2μ dev ln V +
//! k tr(ln V) I; at constant volume it does with the convected rates, too, which give T = μ (B − I), Truesdell's as well as
//! the upper, and T = μ (I − B⁻¹), the lower, B = V² = FFᵀ. Jaumann's stress oscillates in simple shear.
//!
//! Parameters: elasticity, rate. History: T.

use crate::elastic::{predicted_stress, stress_power};
use crate::point_state;
use crate::{IsotropicElasticity, Material, MaterialUpdate, StepKinematics};
use estar_tensor::{Real, Rotation, SymmetricTensor, Tensor, inlined};

/// An objective rate of the Cauchy stress.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ObjectiveRate {
    /// Ṫ − ΩT + TΩ, Ω = ṘRᵀ.
    Box,
    /// Ṫ − WT + TW.
    Jaumann,
    /// Ṫ − LT − TLᵀ + tr(D) T.
    Truesdell,
    /// Ṫ − LT − TLᵀ.
    UpperConvected,
    /// Ṫ + LᵀT + TL.
    LowerConvected,
    /// Ṫ − Ω_log T + T Ω_log.
    Logarithmic,
}

impl ObjectiveRate {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Box, Self::Jaumann, Self::Truesdell, Self::UpperConvected, Self::LowerConvected, Self::Logarithmic];

    /// Whether it is the rate seen by an observer who only turns: then it leaves the elastic stiffness as it is.
    pub fn is_corotational(self) -> bool {
        matches!(self, Self::Box | Self::Jaumann | Self::Logarithmic)
    }

    /// The tensors A and B that carry a stress from t_n to mid-step and from there to t_{n+1}.
    #[inline(always)]
    fn carriers<R: Real>(self, step: &StepKinematics<R>) -> [Tensor<R>; 2] {
        let gradient = &step.incremental_displacement_gradient;
        let half = *gradient * R::splat(0.5);
        // with a constant velocity x_n = (I − ½ ΔtL) x_{n+½}, x_{n+1} = (I + ½ ΔtL) x_{n+½}
        let from_half_to_new = half.plus_spherical(R::splat(1.0));
        let from_half_to_old = Tensor::identity() - half;
        match self {
            Self::Box => {
                let new = step.rotation_new.to_tensor();
                let old = step.rotation_old.to_tensor();
                let half = step.rotation_old.half_way_to(step.rotation_new);
                [half.dot(&old.transpose()), new.dot(&half.transpose())]
            }
            Self::Jaumann => [half_turn(&skew_part(gradient)); 2],
            Self::Logarithmic => {
                // B = FFᵀ at mid-step
                let gradient_half = from_half_to_new.inverse().dot(&step.deformation_gradient);
                let left_metric = gradient_half.dot(&gradient_half.transpose()).symmetric_part();
                let turning = logarithmic_turning(&left_metric, &gradient.symmetric_part());
                [half_turn(&(skew_part(gradient) + turning)); 2]
            }
            // d(F⁻¹TF⁻ᵀ)/dt = F⁻¹T°F⁻ᵀ
            Self::UpperConvected => [from_half_to_old.inverse(), from_half_to_new],
            // d(J F⁻¹TF⁻ᵀ)/dt = J F⁻¹T°F⁻ᵀ
            Self::Truesdell => {
                let (before, after) = (from_half_to_old.determinant(), from_half_to_new.determinant());
                [from_half_to_old.inverse() * before.sqrt(), from_half_to_new * after.sqrt().recip()]
            }
            // d(FᵀTF)/dt = FᵀT°F
            Self::LowerConvected => [from_half_to_old.transpose(), from_half_to_new.inverse().transpose()],
        }
    }

    /// The objective rate T° of a stress T that changes at the rate Ṫ.
    pub fn of(
        self,
        stress_rate: &SymmetricTensor<f64>,
        stress: &SymmetricTensor<f64>,
        motion: &Turning,
    ) -> SymmetricTensor<f64> {
        let l = &motion.velocity_gradient;
        let stretching = l.symmetric_part();
        let zero = Tensor::zero();
        // Λ
        let carrying = match self {
            Self::Box => motion.rotation_rate,
            Self::Jaumann => skew_part(l),
            Self::Logarithmic => skew_part(l) + logarithmic_turning(&motion.left_metric, &stretching),
            Self::Truesdell | Self::UpperConvected => *l,
            Self::LowerConvected => zero - l.transpose(),
        };
        // ΛT + TΛᵀ = 2 sym(ΛT)
        let carried = carrying.dot(&stress.to_tensor()).symmetric_part() * 2.0;
        let spread = if self == Self::Truesdell { stretching.trace() } else { 0.0 };
        stress.mul_add(spread, &(*stress_rate - carried))
    }
}

/// How the neighbourhood of a point turns and stretches at a moment.
#[derive(Clone, Copy, Debug)]
pub struct Turning {
    /// L, 1/s.
    pub velocity_gradient: Tensor<f64>,
    /// Ω = ṘRᵀ, 1/s.
    pub rotation_rate: Tensor<f64>,
    /// B = FFᵀ.
    pub left_metric: SymmetricTensor<f64>,
}

/// ½ (A − Aᵀ).
#[inline(always)]
fn skew_part<R: Real>(tensor: &Tensor<R>) -> Tensor<R> {
    (*tensor - tensor.transpose()) * R::splat(0.5)
}

/// The rotation of half a step with the spin Δt W at mid-step. The whole step's is that of Hughes & Winget (1980), by the
/// angle θ with tan ½θ = ½ |ω|, exact for a rigid rotation along straight lines.
#[inline(always)]
fn half_turn<R: Real>(spin: &Tensor<R>) -> Tensor<R> {
    let one = R::splat(1.0);
    // g = ½ ω
    let [x, y, z] = [spin.at(2, 1) * 0.5, spin.at(0, 2) * 0.5, spin.at(1, 0) * 0.5];
    let length = x.mul_add(x, y.mul_add(y, z.mul_add(z, one))).sqrt().recip();
    Rotation::identity().half_way_to(Rotation([length, x * length, y * length, z * length]))
}

/// Ω_log − W = Σ_{i≠j} h(bᵢ/bⱼ) Pᵢ D Pⱼ, h(x) = (1 + x)/(1 − x) + 2/ln x, with the principal values bᵢ and projections
/// Pᵢ = vᵢ ⊗ vᵢ of B = FFᵀ (Xiao, Bruhns & Meyers 1997).
#[inline(always)]
fn logarithmic_turning<R: Real>(left_metric: &SymmetricTensor<R>, stretching: &SymmetricTensor<R>) -> Tensor<R> {
    let system = left_metric.eigensystem();
    let d = stretching.pulled_by(&system.vectors).0;
    let [a, b, c] = system.values;
    let component = inlined!(|x: R, y: R, d: R| log_weight((x / y).ln()) * d);
    let (xy, yz, xz) = (component(a, b, d[3]), component(b, c, d[4]), component(a, c, d[5]));
    let zero = R::splat(0.0);
    let principal = Tensor::from_rows([[zero, xy, xz], [-xy, zero, yz], [-xz, -yz, zero]]);
    system.vectors.dot(&principal).dot(&system.vectors.transpose())
}

/// h of the ratio e^u: 2/u − coth ½u, an odd function that goes to −u/6 + u³/360 − u⁵/15120 at 0.
#[inline(always)]
fn log_weight<R: Real>(u: R) -> R {
    let square = u * u;
    let series = square.mul_add(R::splat(-1.0 / 15_120.0), R::splat(1.0 / 360.0));
    let series = series.mul_add(square, R::splat(-1.0 / 6.0)) * u;
    let near = u.abs().lt(R::splat(SERIES_REACH));
    let safe = R::select(near, R::splat(1.0), u);
    // −coth ½u = (1 + e^u)/(1 − e^u)
    let power = safe.exp();
    let exact = (power + 1.0) / (R::splat(1.0) - power) + R::splat(2.0) / safe;
    R::select(near, series, exact)
}

/// Below it the series is exact to 1e-13, and above it the difference of two large numbers is.
const SERIES_REACH: f64 = 0.05;

/// Isotropic elasticity in rate form with any objective rate. [`crate::Elastic`] is the same with the box rate, in the
/// frame where that costs least.
#[derive(Clone, Debug, PartialEq)]
pub struct Hypoelastic {
    elasticity: IsotropicElasticity,
    rate: ObjectiveRate,
}

/// History of [`Hypoelastic`].
#[derive(Clone, Copy, Debug)]
pub struct HypoelasticState<R> {
    /// Cauchy stress T, Pa.
    pub stress: SymmetricTensor<R>,
}

point_state!(HypoelasticState { stress: symmetric });

impl Hypoelastic {
    /// The material with these constants and this rate.
    pub fn new(elasticity: IsotropicElasticity, rate: ObjectiveRate) -> Self {
        Self { elasticity, rate }
    }

    /// The rate.
    pub fn rate(&self) -> ObjectiveRate {
        self.rate
    }
}

impl Material for Hypoelastic {
    type State<R: Real> = HypoelasticState<R>;

    type Motion<R: Real> = StepKinematics<R>;

    fn elasticity(&self) -> &IsotropicElasticity {
        &self.elasticity
    }

    fn initial_state<R: Real>(&self) -> HypoelasticState<R> {
        HypoelasticState { stress: SymmetricTensor::zero() }
    }

    #[inline(always)]
    fn update<R: Real>(
        &self,
        old: &HypoelasticState<R>,
        motion: &StepKinematics<R>,
        _: f64,
    ) -> MaterialUpdate<R, HypoelasticState<R>> {
        // T_{n+1} = B (A T_n Aᵀ + Δt (2μ dev D + k tr(D) I)) Bᵀ
        let [to_half, to_new] = self.rate.carriers(motion);
        let strain_increment = motion.incremental_displacement_gradient.symmetric_part();
        let carried = old.stress.pushed_by(&to_half);
        let grown = predicted_stress(&self.elasticity, &carried, &strain_increment);
        MaterialUpdate {
            state: HypoelasticState { stress: grown.pushed_by(&to_new) },
            internal_energy: stress_power(&carried, &grown, &strain_increment),
            plastic_dissipation: R::splat(0.0),
        }
    }

    #[inline(always)]
    fn cauchy_stress<R: Real>(&self, state: &HypoelasticState<R>, _: Rotation<R>) -> SymmetricTensor<R> {
        state.stress
    }

    #[inline(always)]
    fn equivalent_plastic_strain<R: Real>(&self, _: &HypoelasticState<R>) -> R {
        R::splat(0.0)
    }

    fn plastic_metric(&self, _: &HypoelasticState<f64>, _: &SymmetricTensor<f64>) -> SymmetricTensor<f64> {
        SymmetricTensor::spherical(1.0)
    }

    fn hardening_index(&self, _: &HypoelasticState<f64>, _: &Tensor<f64>) -> Option<f64> {
        None
    }

    fn obstacle_to_elements(&self) -> Option<&'static str> {
        let obstacle = "a rate that stretches with the material makes it stiffer as it is stretched, beyond what the bound of \
                        the stable time step knows; the rates box, jaumann and logarithmic can run";
        (!self.rate.is_corotational()).then_some(obstacle)
    }
}
