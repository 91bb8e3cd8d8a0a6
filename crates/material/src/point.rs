//! The material-point driver: a material along a path of deformation gradients, without a mesh.
//!
//! [`drive`] takes a path that gives all of F; [`follow`] one that gives F as far as a [`Control`] says, where the lateral
//! stretches of a test under uniaxial stress are found step by step.

use crate::factors::{Factors, metric, strain};
use crate::{Material, MaterialUpdate, Motion, PointGradients, PointState, StepKinematics};
use estar_tensor::{Real, Rotation, SymmetricTensor, Tensor};

/// One material point with its history.
#[derive(Clone, Debug)]
pub struct MaterialPoint<'a, M: Material, R: Real = f64> {
    material: &'a M,
    state: M::State<R>,
    rotation: Rotation<R>,
    deformation_gradient: Tensor<R>,
    stress: SymmetricTensor<R>,
    internal_energy: R,
    plastic_dissipation: R,
    last: LastStep<M::State<R>, R>,
}

/// What the last step of a point began with, and how it moved.
#[derive(Clone, Copy, Debug)]
struct LastStep<S, R> {
    state_old: S,
    deformation_gradient_old: Tensor<R>,
    kinematics: StepKinematics<R>,
    /// s; 0 before the first step.
    time_step: f64,
}

impl<'a, M: Material, R: Real> MaterialPoint<'a, M, R> {
    /// The undeformed point.
    pub fn new(material: &'a M) -> Self {
        let (state, deformation_gradient) = (material.initial_state(), Tensor::identity());
        Self {
            material,
            state,
            rotation: Rotation::identity(),
            deformation_gradient,
            stress: SymmetricTensor::zero(),
            internal_energy: R::splat(0.0),
            plastic_dissipation: R::splat(0.0),
            last: LastStep {
                state_old: state,
                deformation_gradient_old: deformation_gradient,
                kinematics: StepKinematics::at_rest(deformation_gradient, Rotation::identity()),
                time_step: 0.0,
            },
        }
    }

    /// Moves the point in a straight line to the deformation gradient `target` in the time `time_step` (s).
    #[inline(always)]
    pub fn advance(&mut self, target: &Tensor<R>, time_step: f64) {
        let rate = (*target - self.deformation_gradient) * R::splat(time_step.recip());
        // ξ = X
        let gradients = PointGradients { reference: Tensor::identity(), position: *target, velocity: rate };
        let rotation = Rotation::nearest(target, self.rotation);
        let (incremental_displacement_gradient, volume_half) = gradients.incremental_displacement_gradient(time_step);
        let kinematics = StepKinematics {
            incremental_displacement_gradient,
            deformation_gradient: *target,
            rotation_old: self.rotation,
            rotation_new: rotation,
        };
        let update = self.material.update(&self.state, &M::Motion::new(&kinematics), time_step);
        let MaterialUpdate { state, internal_energy, plastic_dissipation } = update;
        // per reference volume: dV = J_{n+½} dV₀
        self.internal_energy += internal_energy * volume_half;
        self.plastic_dissipation += plastic_dissipation * volume_half;
        self.stress = self.material.cauchy_stress(&state, rotation);
        self.last = LastStep {
            state_old: self.state,
            deformation_gradient_old: self.deformation_gradient,
            kinematics,
            time_step,
        };
        self.state = state;
        self.rotation = rotation;
        self.deformation_gradient = *target;
    }

    /// Cauchy stress T, Pa.
    pub fn stress(&self) -> &SymmetricTensor<R> {
        &self.stress
    }

    /// Rotated Cauchy stress RᵀTR, Pa.
    pub fn rotated_stress(&self) -> SymmetricTensor<R> {
        self.stress.pulled_by(&self.rotation.to_tensor())
    }

    /// ε̄ᵖ.
    pub fn equivalent_plastic_strain(&self) -> R {
        self.material.equivalent_plastic_strain(&self.state)
    }

    /// History.
    pub fn state(&self) -> &M::State<R> {
        &self.state
    }

    /// F.
    pub fn deformation_gradient(&self) -> &Tensor<R> {
        &self.deformation_gradient
    }

    /// Stress power integrated over time, J per m³ of reference volume.
    pub fn internal_energy(&self) -> R {
        self.internal_energy
    }

    /// Its dissipated part, J/m³ of reference volume.
    pub fn plastic_dissipation(&self) -> R {
        self.plastic_dissipation
    }
}

/// The point after the path `deformation_gradient(time)`, 0 < time ≤ `end`, in `steps` equal steps; `visit` sees it
/// after each.
pub fn drive<'a, M: Material>(
    material: &'a M,
    deformation_gradient: impl Fn(f64) -> Tensor<f64>,
    end: f64,
    steps: u32,
    mut visit: impl FnMut(f64, &MaterialPoint<'a, M>),
) -> MaterialPoint<'a, M> {
    let mut point = MaterialPoint::new(material);
    for step in 1..=steps {
        let time = end * f64::from(step) / f64::from(steps);
        point.advance(&deformation_gradient(time), end / f64::from(steps));
        visit(time, &point);
    }
    point
}

/// The deformation gradient at the end of a step as far as a path gives it.
#[derive(Clone, Copy, Debug)]
pub struct Control {
    deformation_gradient: Tensor<f64>,
    free_axes: &'static [usize],
}

impl Control {
    /// All of F.
    pub fn deformation_gradient(deformation_gradient: Tensor<f64>) -> Self {
        Self { deformation_gradient, free_axes: &[] }
    }

    /// F = diag(λ, 1, 1).
    pub fn uniaxial_strain(stretch: f64) -> Self {
        Self::deformation_gradient(diagonal([stretch, 1.0, 1.0]))
    }

    /// F = diag(λ, λ₂, λ₂) with the λ₂ that leaves T₂₂ = T₃₃ = 0: every material here is isotropic.
    pub fn uniaxial_stress(stretch: f64) -> Self {
        Self { free_axes: &[1, 2], ..Self::uniaxial_strain(stretch) }
    }

    /// F = diag(λ, λ₂, 1) with the λ₂ that leaves T₂₂ = 0.
    pub fn plane_strain_tension(stretch: f64) -> Self {
        Self { free_axes: &[1], ..Self::uniaxial_strain(stretch) }
    }

    /// F = I + γ e₁ ⊗ e₂.
    pub fn simple_shear(shear: f64) -> Self {
        Self::deformation_gradient(Tensor::from_rows([[1.0, shear, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]))
    }

    /// F with the components F_ii of the free axes multiplied by e^`logarithm` from those of `last`.
    fn stretched(&self, last: &Tensor<f64>, logarithm: f64) -> Tensor<f64> {
        let mut gradient = self.deformation_gradient;
        for &axis in self.free_axes {
            gradient.columns[axis].0[axis] = last.at(axis, axis) * logarithm.exp();
        }
        gradient
    }
}

fn diagonal([a, b, c]: [f64; 3]) -> Tensor<f64> {
    SymmetricTensor([a, b, c, 0.0, 0.0, 0.0]).to_tensor()
}

/// A step that cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PointError {
    /// det F is not positive at the end of the step.
    #[error("det F = {jacobian:.4e} is not positive: no body can be deformed so")]
    Inverted {
        /// det F.
        jacobian: f64,
    },
    /// det F is almost zero or negative half way from one deformation gradient to the next.
    #[error(
        "one step turns or squeezes too far: half way along a straight line det F = {jacobian:.4e}; take more steps"
    )]
    StepTooLarge {
        /// det F half way.
        jacobian: f64,
    },
    /// A stress, or a number of the history, is not finite.
    #[error(
        "the stress, or what the material remembers, is not finite: the deformation or the stiffness is beyond what numbers hold, or the flow rule leads to no \
         admissible stress any more"
    )]
    NotFinite,
    /// No lateral stretch leaves the lateral stress zero.
    #[error(
        "no lateral stretch was found that leaves the lateral stress zero; the least is {stress:.4e} Pa; take more steps"
    )]
    NoBalance {
        /// The lateral stress that is left, Pa.
        stress: f64,
    },
}

/// A path that could not be followed to its end.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("step {step}, from time {time_old:?} s to {time:?} s: {error}")]
pub struct PathError {
    /// The step, from 1.
    pub step: usize,
    /// Where it began, s.
    pub time_old: f64,
    /// Where it should have ended, s.
    pub time: f64,
    /// Why it could not be made.
    pub error: PointError,
}

/// A trial of a controlled step.
struct Trial<'a, M: Material> {
    point: MaterialPoint<'a, M>,
    /// By how much the logarithms of the free stretches grow.
    logarithm: f64,
    /// Lateral Kirchhoff stress J T_ii, Pa. The Cauchy stress falls where the body only swells, and would lead astray.
    residual: f64,
}

/// Volume half way through a step beside that at its ends. A turn by half a revolution has none half way; one by 179.9
/// degrees has this.
const FLATTEST: f64 = 7e-7;
/// A stress this small beside the P-wave modulus is zero.
const BALANCED: f64 = 1e-10;
/// A stress this small beside the P-wave modulus is rounding.
const ROUNDING: f64 = 1e-15;
/// Corrections of the lateral stretch. The secant takes three to eight, and more only across a corner of the response.
const MOST_CORRECTIONS: usize = 100;
/// Growth of a logarithmic stretch that no correction exceeds.
const LARGEST_CORRECTION: f64 = 0.5;
/// Growth of a logarithmic stretch that no step exceeds.
const LARGEST_GROWTH: f64 = 2.0;

impl<'a, M: Material> MaterialPoint<'a, M> {
    /// Moves the point to the deformation gradient of `control`, in a straight line and in the time `time_step` (s). On
    /// failure the point stays as it is.
    ///
    /// # Errors
    /// The deformation gradient, or the one half way to it, is not that of a body, or no lateral stretch is found.
    pub fn follow(&mut self, control: &Control, time_step: f64) -> Result<(), PointError> {
        if control.free_axes.is_empty() {
            *self = self.moved(&control.deformation_gradient, time_step)?;
            return Ok(());
        }
        let axis = control.free_axes[0];
        let trial = |logarithm: f64| -> Result<Trial<'a, M>, PointError> {
            let target = control.stretched(&self.deformation_gradient, logarithm);
            let point = self.moved(&target, time_step)?;
            let residual = target.determinant() * point.stress.0[axis];
            Ok(Trial { point, logarithm, residual })
        };
        let modulus = self.material.elasticity().p_wave_modulus();
        let mut best = trial(0.0)?;
        // the lateral stress grows with the lateral stretch: a secant, kept between what is known to be too small and too large
        let (mut too_small, mut too_large) = (-LARGEST_GROWTH, LARGEST_GROWTH);
        let mut slope = modulus;
        for _ in 0..MOST_CORRECTIONS {
            if best.residual.abs() <= ROUNDING * modulus {
                break;
            }
            *(if best.residual < 0.0 { &mut too_small } else { &mut too_large }) = best.logarithm;
            let correction = (-best.residual / slope).clamp(-LARGEST_CORRECTION, LARGEST_CORRECTION);
            let mut logarithm = best.logarithm + correction;
            if !(too_small < logarithm && logarithm < too_large) {
                logarithm = 0.5 * (too_small + too_large);
            }
            // as close as numbers are
            if logarithm == too_small || logarithm == too_large {
                break;
            }
            let next = match trial(logarithm) {
                Ok(next) => next,
                // where no body or no stress is, is too far
                Err(_) => {
                    *(if logarithm < best.logarithm { &mut too_small } else { &mut too_large }) = logarithm;
                    continue;
                }
            };
            let secant = (next.residual - best.residual) / (next.logarithm - best.logarithm);
            slope = if secant > 0.0 { secant } else { modulus };
            best = next;
        }
        if best.residual.abs() > BALANCED * modulus {
            return Err(PointError::NoBalance { stress: best.point.stress.0[axis] });
        }
        *self = best.point;
        Ok(())
    }

    /// The point after a step to `target`.
    fn moved(&self, target: &Tensor<f64>, time_step: f64) -> Result<Self, PointError> {
        let jacobian = target.determinant();
        if !(jacobian > 0.0 && jacobian.is_finite()) {
            return Err(PointError::Inverted { jacobian });
        }
        let half = ((*target + self.deformation_gradient) * 0.5).determinant();
        if half.is_nan() || half < FLATTEST * jacobian.min(self.deformation_gradient.determinant()) {
            return Err(PointError::StepTooLarge { jacobian: half });
        }
        let mut moved = self.clone();
        moved.advance(target, time_step);
        let mut is_finite = moved.stress.0.iter().all(|component| component.is_finite());
        moved.state.for_each(|number| is_finite &= number.is_finite());
        if is_finite { Ok(moved) } else { Err(PointError::NotFinite) }
    }

    /// ĝ over the last step.
    fn loading_index(&self) -> Option<f64> {
        let LastStep { state_old, deformation_gradient_old, kinematics, time_step } = &self.last;
        let at_rest = StepKinematics::at_rest(*deformation_gradient_old, kinematics.rotation_old);
        let of = |motion| self.material.yield_criterion(state_old, &M::Motion::new(motion));
        let (begun, predicted) = (of(&at_rest)?, of(kinematics)?);
        let index = |time_step| predicted.loading_index(begun.equivalent_stress, time_step);
        Some(if *time_step > 0.0 { index(*time_step) } else { 0.0 })
    }

    /// What there is to tell of the point.
    pub fn observation(&self) -> Observation {
        let gradient = self.deformation_gradient;
        let inverse = gradient.inverse();
        let right_metric = metric(&gradient);
        let plastic_metric = self.material.plastic_metric(&self.state, &right_metric);
        let factors = Factors::new(&gradient, &plastic_metric);
        Observation {
            deformation_gradient: gradient,
            stress: self.stress,
            rotated_stress: self.rotated_stress(),
            // S = J F⁻¹ T F⁻ᵀ
            second_piola_stress: self.stress.pushed_by(&inverse) * gradient.determinant(),
            green_strain: strain(&right_metric),
            factors,
            equivalent_plastic_strain: self.equivalent_plastic_strain(),
            hardening_index: self.material.hardening_index(&self.state, &gradient),
            loading_index: self.loading_index(),
            temperature: self.material.temperature(&self.state),
            plastic_dissipation: self.plastic_dissipation,
            internal_energy: self.internal_energy,
            plastic_determinant: plastic_metric.determinant(),
        }
    }
}

/// What there is to tell of a point at a moment.
#[derive(Clone, Copy, Debug)]
pub struct Observation {
    /// F.
    pub deformation_gradient: Tensor<f64>,
    /// Cauchy stress T, Pa.
    pub stress: SymmetricTensor<f64>,
    /// Rotated Cauchy stress RᵀTR, Pa.
    pub rotated_stress: SymmetricTensor<f64>,
    /// Second Piola-Kirchhoff stress S, Pa.
    pub second_piola_stress: SymmetricTensor<f64>,
    /// Green strain E = ½ (C − I).
    pub green_strain: SymmetricTensor<f64>,
    /// F = R_* U_* U_p, from which E_p and E_* follow.
    pub factors: Factors,
    /// ε̄ᵖ.
    pub equivalent_plastic_strain: f64,
    /// Φ, where the material can flow and there is a closed form.
    pub hardening_index: Option<f64>,
    /// ĝ, Pa²/s, the mean over the last step: see [`YieldCriterion`](crate::YieldCriterion). None where the material cannot
    /// flow, or where more than it decides whether it does.
    pub loading_index: Option<f64>,
    /// Temperature, K, where the material has one.
    pub temperature: Option<f64>,
    /// What plastic flow has dissipated, J per m³ of reference volume.
    pub plastic_dissipation: f64,
    /// Stress power integrated over time, J per m³ of reference volume.
    pub internal_energy: f64,
    /// det C_p.
    pub plastic_determinant: f64,
}

/// The point after the path `control(time)` at the `times` (s), at the first of which it is undeformed; `visit` sees it
/// after each step.
///
/// # Errors
/// A step that cannot be made.
pub fn follow<'a, M: Material>(
    material: &'a M,
    control: impl Fn(f64) -> Control,
    times: &[f64],
    mut visit: impl FnMut(f64, &MaterialPoint<'a, M>),
) -> Result<MaterialPoint<'a, M>, PathError> {
    let mut point = MaterialPoint::new(material);
    for (index, pair) in times.windows(2).enumerate() {
        let [time_old, time] = [pair[0], pair[1]];
        point.follow(&control(time), time - time_old).map_err(|error| PathError {
            step: index + 1,
            time_old,
            time,
            error,
        })?;
        visit(time, &point);
    }
    Ok(point)
}

/// A measure of the stretch λ of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StretchMeasure {
    /// ½ (λ² − 1).
    GreenLagrange,
    /// λ.
    Stretch,
    /// ln λ.
    Logarithmic,
}

impl StretchMeasure {
    /// λ, if the value is one that a stretch can have.
    pub fn stretch(self, value: f64) -> Option<f64> {
        let stretch = match self {
            Self::GreenLagrange => (1.0 + 2.0 * value).sqrt(),
            Self::Stretch => value,
            Self::Logarithmic => value.exp(),
        };
        (stretch > 0.0 && stretch.is_finite()).then_some(stretch)
    }
}
