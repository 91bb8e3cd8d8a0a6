//! The eight-node hex with one point, `hex8-one-point`: the mean gradient of the element (Flanagan & Belytschko 1981), which sees
//! every uniform motion exactly, and hourglass control of the four motions of each direction that it does not see.
//!
//! In the modes c_m of a field (see [`hex8`]) the mean gradient is L̄ = (8/V) Σ_m v_m ⊗ g_m with
//!
//! ```text
//! g_ξ  = c_η × c_ζ + ⅓ c_ξη × c_ζξ,   g_ξη = ⅓ (c_η × c_ηζ + c_ζξ × c_ξ),   and so on round ξ → η → ζ → ξ
//! V/8  = ⅓ Σ_m g_m · c_m,             g_ξηζ = 0
//! ```
//!
//! which are the integrals of cof(∂x/∂ξ) ∂N/∂ξ, exact for any trilinear hex. What remains of a motion are the hourglass rates
//! q̇_α = v_α − L̄ c_α, α = ξη, ηζ, ζξ, ξηζ: none in any linear motion. Forces Q_α on them have the power Σ Q_α · q̇_α; they turn
//! with the element, Q̂ = RᵀQ.

use crate::bulk_viscosity::{ViscousState, damped_step_factor};
use crate::element::{Element, ElementHistory, ElementStep, Tangent, stiffening};
use crate::hex8::{
    self, CORNER_SIGNS, CORNERS, CornerVectors, HexMotion, HexUpdate, Modes, corner_values, eightfold_modes,
};
use crate::stable_time_step::{ElasticBounds, Metrics};
use estar_material::{IsotropicElasticity, Material, Motion, PointState, StepKinematics};
use estar_tensor::{Real, Rotation, SymmetricTensor, Tensor, Vector3, array, prefetch};

/// Hourglass modes.
const HOURGLASS: usize = 4;
/// Modes with a mean gradient: all but ξηζ.
const LINKED: usize = 6;

/// What resists the motions that one point does not see.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HourglassControl {
    /// Stiffness of strains that are assumed in the element: in each of its three middle planes bending and torsion in plane
    /// stress, without the shear that they do not have (after Belytschko & Bindeman 1993); where the point yields, the hourglass
    /// stress returns by the factor of the point's deviator. Nothing is to be chosen.
    Physical,
    /// Stiffness, as a share of that of the element's stiffest uniform strain (after Flanagan & Belytschko 1981).
    Stiffness {
        /// The share.
        coefficient: f64,
    },
    /// Viscosity Q = 16 `coefficient` ρ c V^⅔ q̇ (after Flanagan & Belytschko 1981).
    Viscous {
        /// The coefficient.
        coefficient: f64,
    },
}

/// History of an element.
#[derive(Clone, Copy, Debug)]
pub struct OnePointHistory<State, R> {
    /// History of the material.
    pub states: [State; 1],
    /// Rotation R_n.
    pub rotations: [Rotation<R>; 1],
    /// Q̂ at t_n, N, of ξη, ηζ, ζξ, ξηζ.
    pub hourglass_forces: [Vector3<R>; HOURGLASS],
    /// Stable time step at t_n, s.
    pub stable_time_step: R,
    /// Pressure of bulk viscosity at t_n, Pa.
    pub viscous_pressure: R,
}

impl<R: Real, S: PointState<R>> ElementHistory<R, S> for OnePointHistory<S, R> {
    fn states(&self) -> &[S] {
        &self.states
    }

    fn rotations(&self) -> &[Rotation<R>] {
        &self.rotations
    }

    fn stable_time_step(&self) -> R {
        self.stable_time_step
    }

    fn for_each(&self, mut visit: impl FnMut(R)) {
        self.states[0].for_each(&mut visit);
        self.rotations[0].0.into_iter().for_each(&mut visit);
        self.hourglass_forces.iter().flat_map(|force| force.0).for_each(&mut visit);
        visit(self.stable_time_step);
        visit(self.viscous_pressure);
    }

    fn from_numbers(mut next: impl FnMut() -> R) -> Self {
        Self {
            states: [S::from_numbers(&mut next)],
            rotations: [Rotation(array(|_| next()))],
            hourglass_forces: array(|_| Vector3(array(|_| next()))),
            stable_time_step: next(),
            viscous_pressure: next(),
        }
    }

    fn select(mask: R::Mask, chosen: &Self, otherwise: &Self) -> Self {
        let number = |chosen: R, otherwise: R| R::select(mask, chosen, otherwise);
        Self {
            states: [S::select(mask, &chosen.states[0], &otherwise.states[0])],
            rotations: [Rotation(array(|i| number(chosen.rotations[0].0[i], otherwise.rotations[0].0[i])))],
            hourglass_forces: array(|mode| {
                Vector3::select(mask, chosen.hourglass_forces[mode], otherwise.hourglass_forces[mode])
            }),
            stable_time_step: number(chosen.stable_time_step, otherwise.stable_time_step),
            viscous_pressure: number(chosen.viscous_pressure, otherwise.viscous_pressure),
        }
    }
}

/// The vectors g_m of ξ, η, ζ, ξη, ηζ, ζξ, m², and the volume.
#[derive(Clone, Copy)]
struct MeanOperator<R> {
    vectors: [Vector3<R>; LINKED],
    /// V/8.
    eighth: R,
    /// 8/V.
    per_eighth: R,
}

impl<R: Real> MeanOperator<R> {
    #[inline(always)]
    fn new(modes: &Modes<R>) -> Self {
        let [xi, eta, zeta, xi_eta, eta_zeta, zeta_xi, _] = *modes;
        let third = R::splat(1.0 / 3.0);
        let vectors = [
            xi_eta.cross(zeta_xi).mul_add(third, eta.cross(zeta)),
            eta_zeta.cross(xi_eta).mul_add(third, zeta.cross(xi)),
            zeta_xi.cross(eta_zeta).mul_add(third, xi.cross(eta)),
            (eta.cross(eta_zeta) + zeta_xi.cross(xi)) * third,
            (zeta.cross(zeta_xi) + xi_eta.cross(eta)) * third,
            (xi.cross(xi_eta) + eta_zeta.cross(zeta)) * third,
        ];
        let mut sum = R::splat(0.0);
        for (vector, mode) in vectors.iter().zip(modes) {
            sum += vector.dot(*mode);
        }
        let eighth = sum * third;
        Self { vectors, eighth, per_eighth: eighth.recip() }
    }

    /// (8/V) Σ_m f_m ⊗ g_m, the mean gradient of a field.
    #[inline(always)]
    fn gradient(&self, field: &Modes<R>) -> Tensor<R> {
        let mut columns = [Vector3::zero(); 3];
        for (mode, vector) in field.iter().zip(&self.vectors) {
            for (column, component) in columns.iter_mut().zip(vector.0) {
                *column = mode.mul_add(component, *column);
            }
        }
        Tensor { columns } * self.per_eighth
    }
}

/// Σ a_m a_mᵀ.
#[inline(always)]
fn squares<R: Real>(vectors: &[Vector3<R>]) -> SymmetricTensor<R> {
    let mut sum = SymmetricTensor::zero();
    for vector in vectors {
        let [x, y, z] = vector.0;
        sum = sum + SymmetricTensor([x * x, y * y, z * z, x * y, y * z, z * x]);
    }
    sum
}

/// ½ (a ⊗ b + b ⊗ a).
#[inline(always)]
fn symmetric_product<R: Real>(a: Vector3<R>, b: Vector3<R>) -> SymmetricTensor<R> {
    let ([x, y, z], [u, v, w]) = (a.0, b.0);
    SymmetricTensor([x * u, y * v, z * w, (x * v + y * u) * 0.5, (y * w + z * v) * 0.5, (x * w + z * u) * 0.5])
}

#[inline(always)]
fn apply<R: Real>(tensor: &SymmetricTensor<R>, vector: Vector3<R>) -> Vector3<R> {
    tensor.to_tensor().apply(vector)
}

/// Moduli of the assumed strains, Pa.
#[derive(Clone, Copy)]
struct AssumedStrain {
    /// μ.
    shear: f64,
    /// ν/(1 − ν).
    lateral: f64,
    /// E.
    young: f64,
}

impl AssumedStrain {
    #[inline(always)]
    fn new(elasticity: &IsotropicElasticity) -> Self {
        let (shear, poisson) = (elasticity.shear_modulus(), elasticity.poisson_ratio());
        Self { shear, lateral: poisson / (1.0 - poisson), young: 2.0 * shear * (1.0 + poisson) }
    }

    /// Hourglass forces of the hourglass motion `slip` (m) where `gradients` are ∇ξ, ∇η, ∇ζ at the centre.
    ///
    /// The displacement Σ q_α h_α has a gradient with a part linear in ζ, q_ηζ ⊗ ∇η + q_ζξ ⊗ ∇ξ; in the plane normal to ∇ζ
    /// it is the bending and torsion of a plate in plane stress, σ = 2μ (ε + ν/(1 − ν) tr ε). Likewise round ξ → η → ζ → ξ. The
    /// trilinear mode stretches along ∇ξ by η ζ q · ∇ξ, in uniaxial stress.
    #[inline(always)]
    fn forces<R: Real>(
        &self,
        slip: &[Vector3<R>; HOURGLASS],
        gradients: &[Vector3<R>; 3],
        volume: R,
    ) -> [Vector3<R>; HOURGLASS] {
        let mut forces = [Vector3::zero(); HOURGLASS];
        // ∫ ζ² dV = V/3, ∫ η² ζ² dV = V/9
        let third = volume * (1.0 / 3.0);
        for normal in 0..3 {
            // of the plane normal to ∇ζ the modes ζξ = 2 with ∇ξ and ηζ = 1 with ∇η, and so on round
            let (mode, other_mode) = (normal, (normal + 2) % 3);
            let (along, in_mode, in_other) =
                (gradients[normal], gradients[(normal + 1) % 3], gradients[(normal + 2) % 3]);
            let strain = symmetric_product(slip[mode], in_mode) + symmetric_product(slip[other_mode], in_other);
            // P ε P with P = I − n nᵀ
            let per_square = along.dot(along).recip();
            let strain_of_normal = apply(&strain, along);
            let normal_strain = strain_of_normal.dot(along) * per_square;
            let correction = strain_of_normal.mul_add(R::splat(-2.0), along * normal_strain) * per_square;
            let in_plane = strain + symmetric_product(correction, along);
            // 2μ (P ε P + ν/(1 − ν) tr(P ε P) P)
            let sphere = (strain.trace() - normal_strain) * self.lateral;
            let unit = in_plane.plus_spherical(sphere) + symmetric_product(along, along) * (-sphere * per_square);
            let stress = unit * (third * (2.0 * self.shear));
            forces[mode] = forces[mode] + apply(&stress, in_mode);
            forces[other_mode] = forces[other_mode] + apply(&stress, in_other);
        }
        let ninth = volume * (self.young / 9.0);
        for gradient in gradients {
            forces[3] = gradient.mul_add(slip[3].dot(*gradient) * ninth, forces[3]);
        }
        forces
    }

    /// Upper bound K of |Q| ≤ K |q|, N/m, where `largest` is that of the principal values of Σ ∇ξ ∇ξᵀ: by |sym(P H P)| ≤ |H| and
    /// |a ⊗ ∇ξ + b ⊗ ∇η|² ≤ λ_max (a² + b²) the energy of each plane is at most (V/3) λ_max (a² + b²) max(μ, μ (1 + ν)/(1 − ν)),
    /// and each mode is in two of them.
    #[inline(always)]
    fn bound<R: Real>(&self, largest: R, volume: R) -> R {
        largest * volume * (4.0 / 3.0 * self.shear * (1.0 + 2.0 * self.lateral).max(1.0))
    }
}

impl Element<CORNERS> for HourglassControl {
    const HAS_LINEAR_FORCES: bool = true;
    const POINTS: usize = 1;
    const PARENT: [[f64; 3]; CORNERS] = CORNER_SIGNS;
    type History<R: Real, S: PointState<R>> = OnePointHistory<S, R>;

    fn initial_history<R: Real, M: Material>(material: &M, stable_time_step: f64) -> Self::History<R, M::State<R>> {
        OnePointHistory {
            states: [material.initial_state()],
            rotations: [Rotation::identity()],
            hourglass_forces: [Vector3::zero(); HOURGLASS],
            stable_time_step: R::splat(stable_time_step),
            viscous_pressure: R::splat(0.0),
        }
    }

    fn lumped_mass(reference: &CornerVectors<f64>, density: f64) -> [f64; CORNERS] {
        hex8::lumped_mass(reference, density)
    }

    fn smallest_jacobian(position: &CornerVectors<f64>) -> f64 {
        hex8::least_jacobian(position)
    }

    #[inline(always)]
    fn advance<R: Real, M: Material>(
        self,
        material: &M,
        history: &mut Self::History<R, M::State<R>>,
        upcoming: Option<&Self::History<R, M::State<R>>>,
        motion: &HexMotion<R>,
        step: &ElementStep,
    ) -> HexUpdate<R> {
        if let Some(upcoming) = upcoming {
            prefetch(upcoming);
        }
        let elasticity = material.elasticity();
        let zero = R::splat(0.0);
        let reference = coefficients(&motion.reference);
        let position = coefficients(&motion.position);
        let velocity = coefficients(&motion.velocity);
        let half_step = R::splat(-0.5 * step.time_step);
        let mut half = position;
        for (half, velocity) in half.iter_mut().zip(&velocity) {
            *half = velocity.mul_add(half_step, *half);
        }
        let initially = MeanOperator::new(&reference);
        let midway = MeanOperator::new(&half);
        let now = MeanOperator::new(&position);
        let jacobian = now.eighth * initially.per_eighth;
        let volume = now.eighth * 8.0;
        let volume_half = midway.eighth * 8.0;

        // (i) the mean motion
        let velocity_gradient = midway.gradient(&velocity);
        let mean_gradient = initially.gradient(&position);
        let rotation_old = history.rotations[0];
        let rotation = Rotation::nearest(&mean_gradient, rotation_old);
        history.rotations[0] = rotation;
        // the volume is that of the hex, not of its mean gradient
        let deformation_gradient = mean_gradient * (jacobian / mean_gradient.determinant()).cbrt();
        let motion_of_point = M::Motion::new(&StepKinematics {
            incremental_displacement_gradient: velocity_gradient * R::splat(step.time_step),
            deformation_gradient,
            rotation_old,
            rotation_new: rotation,
        });
        let volumetric_rate = velocity_gradient.trace();
        let viscous = step.bulk_viscosity.map(|viscosity| {
            viscosity.response(&viscous_state(elasticity, volumetric_rate, jacobian, history.stable_time_step))
        });
        let viscous_pressure = viscous.map_or(zero, |response| response.pressure);

        // (ii) history and stress of the point
        let strain_old = material.equivalent_plastic_strain(&history.states[0]);
        let update = material.update(&history.states[0], &motion_of_point, step.time_step);
        history.states[0] = update.state;
        let stress = material.cauchy_stress(&update.state, rotation);

        // (iii) hourglass forces, in the frame that turns with the element
        let turned = rotation.to_tensor();
        let turned_half = rotation_old.half_way_to(rotation);
        let mut slip_rates = [Vector3::zero(); HOURGLASS];
        let mut slips = slip_rates;
        for alpha in 0..HOURGLASS {
            let rate = velocity[3 + alpha] - velocity_gradient.apply(half[3 + alpha]);
            slip_rates[alpha] = turned_half.transpose_apply(rate);
            slips[alpha] = slip_rates[alpha] * R::splat(step.time_step);
        }
        let (mut gradients, per_determinant) = scaled_central_gradients(&position);
        for gradient in &mut gradients {
            *gradient = turned.transpose_apply(*gradient) * per_determinant;
        }
        let bounds =
            ElasticBounds { shear_modulus: elasticity.shear_modulus(), bulk_modulus: elasticity.bulk_modulus() };
        // V Σ_a b̄_a b̄_aᵀ = (8/V) Σ_m g_m g_mᵀ
        let spread = squares(&now.vectors);
        let metric = Metrics::of(&spread).greatest();
        // stiffness of the stiffest uniform strain: V (2μ λ_max + λ⁺ tr) of Σ b̄ b̄ᵀ, N/m
        let uniform = bounds.stiffness(&metric) * now.per_eighth;
        let forces_old = history.hourglass_forces;
        let mut hourglass_stiffness = zero;
        let mut hourglass_viscosity = zero;
        let mut forces = forces_old;
        match self {
            Self::Physical => {
                let assumed = AssumedStrain::new(elasticity);
                let largest = Metrics::of(&squares(&gradients)).greatest().largest;
                hourglass_stiffness = assumed.bound(largest, volume);
                let increments = assumed.forces(&slips, &gradients, volume);
                // the deviator returns by ‖s‖/‖s trial‖ = σ/(σ + 3μ Δε̄ᵖ), and by the flow rule so does what is added to it
                let flow = material.equivalent_plastic_strain(&update.state) - strain_old;
                let equivalent = (stress.deviator().norm_squared() * 1.5).sqrt();
                let returned = equivalent / flow.mul_add(R::splat(3.0 * elasticity.shear_modulus()), equivalent);
                let share = R::select(flow.gt(zero), returned, R::splat(1.0));
                for (force, increment) in forces.iter_mut().zip(increments) {
                    *force = (*force + increment) * share;
                }
            }
            Self::Stiffness { coefficient } => {
                hourglass_stiffness = uniform * (8.0 * coefficient);
                for (force, slip) in forces.iter_mut().zip(&slips) {
                    *force = slip.mul_add(hourglass_stiffness, *force);
                }
            }
            Self::Viscous { coefficient } => {
                hourglass_viscosity = viscosity(coefficient, elasticity, jacobian, volume);
                for (force, rate) in forces.iter_mut().zip(&slip_rates) {
                    *force = *rate * hourglass_viscosity;
                }
            }
        }
        history.hourglass_forces = forces;
        let mut hourglass_energy = zero;
        for alpha in 0..HOURGLASS {
            hourglass_energy += (forces_old[alpha] + forces[alpha]).dot(slips[alpha]) * 0.5;
        }

        // (iv) forces of the stress and of the hourglass forces, turned back
        for force in &mut forces {
            *force = turned.apply(*force);
        }
        let internal_force = corner_forces(&now, &stress.plus_spherical(-viscous_pressure), &forces, &position);

        // (v) Δt = 2/ω, ω² ≤ (uniform + K c/8)/m with Σ |q|² ≤ c Σ |u_a|²/8
        let obliqueness = {
            // c = λ_max(B̄ᵀB̄ XᵀX) ≤ tr − 2, since B̄ᵀX = I leaves no principal value below 1
            let places = squares(&position);
            spread.double_dot(&places) * (now.per_eighth * now.per_eighth) - 2.0
        };
        let share = obliqueness * 0.125;
        let frequency_squared = (hourglass_stiffness * share + uniform) / motion.corner_mass;
        let mut undamped = frequency_squared.sqrt().recip() * 2.0;
        if let Some(ratio) = material.stiffening(&motion_of_point) {
            undamped = undamped / ratio.sqrt();
        }
        history.stable_time_step = undamped;
        // damping ratio ξ = C/(2 m ω) of the hourglass viscosity
        let hourglass_damping = hourglass_viscosity * share * undamped / (motion.corner_mass * 4.0);
        let damping = viscous.map_or(zero, |response| response.damping_ratio) + hourglass_damping;
        let mean_pressure = (history.viscous_pressure + viscous_pressure) * 0.5;
        let viscous_energy = -(mean_pressure * volumetric_rate * volume_half * step.time_step);
        history.viscous_pressure = viscous_pressure;
        HexUpdate {
            internal_force,
            internal_energy: update.internal_energy * volume_half,
            plastic_dissipation: update.plastic_dissipation * volume_half,
            viscous_energy,
            hourglass_energy,
            min_jacobian: jacobian,
            stable_time_step: undamped * damped_step_factor(damping),
        }
    }

    fn is_damped(self) -> bool {
        matches!(self, Self::Viscous { .. })
    }

    #[inline(always)]
    fn tangent<R: Real>(
        self,
        elasticity: &IsotropicElasticity,
        stable_time_step: R,
        motion: &HexMotion<R>,
        step: &ElementStep,
    ) -> Tangent<R> {
        let zero = R::splat(0.0);
        let [reference, position, velocity] = [&motion.reference, &motion.position, &motion.velocity].map(coefficients);
        let now = MeanOperator::new(&position);
        let jacobian = now.eighth * MeanOperator::new(&reference).per_eighth;
        let per_half_step = 2.0 / step.time_step;
        let viscous_modulus = step.bulk_viscosity.map_or(zero, |bulk_viscosity| {
            let volumetric_rate = now.gradient(&velocity).trace();
            let state = viscous_state(elasticity, volumetric_rate, jacobian, stable_time_step);
            bulk_viscosity.modulus(&state) * per_half_step
        });
        let stiffening = stiffening(self, elasticity, stable_time_step, motion);
        let hourglass_modulus = match self {
            Self::Physical => zero,
            Self::Stiffness { coefficient } => {
                let bounds = ElasticBounds {
                    shear_modulus: elasticity.shear_modulus(),
                    bulk_modulus: elasticity.bulk_modulus(),
                };
                let metric = Metrics::of(&squares(&now.vectors)).greatest();
                bounds.stiffness(&metric) * now.per_eighth * stiffening * (8.0 * coefficient)
            }
            Self::Viscous { coefficient } => {
                viscosity(coefficient, elasticity, jacobian, now.eighth * 8.0) * per_half_step
            }
        };
        Tangent { stiffening, viscous_modulus, hourglass_modulus }
    }

    #[inline(always)]
    fn linear_forces<R: Real>(
        self,
        elasticity: &IsotropicElasticity,
        tangent: &Tangent<R>,
        position: &CornerVectors<R>,
        displacement: &CornerVectors<R>,
    ) -> CornerVectors<R> {
        let position = coefficients(position);
        let displacement = coefficients(displacement);
        let now = MeanOperator::new(&position);
        let gradient = now.gradient(&displacement);
        let strain = gradient.symmetric_part();
        let double_shear = tangent.stiffening * (2.0 * elasticity.shear_modulus());
        let bulk = tangent.stiffening.mul_add(R::splat(elasticity.bulk_modulus()), tangent.viscous_modulus);
        let tension = (double_shear * (-1.0 / 3.0) + bulk) * strain.trace();
        let stress = (strain * double_shear).plus_spherical(tension);
        let mut slips = [Vector3::zero(); HOURGLASS];
        for (alpha, slip) in slips.iter_mut().enumerate() {
            *slip = displacement[3 + alpha] - gradient.apply(position[3 + alpha]);
        }
        let (mut forces, factor) = if self == Self::Physical {
            let (mut gradients, per_determinant) = scaled_central_gradients(&position);
            for gradient in &mut gradients {
                *gradient = *gradient * per_determinant;
            }
            let assumed = AssumedStrain::new(elasticity);
            (assumed.forces(&slips, &gradients, now.eighth * 8.0), tangent.stiffening)
        } else {
            (slips, tangent.hourglass_modulus)
        };
        for force in &mut forces {
            *force = *force * factor;
        }
        corner_forces(&now, &stress, &forces, &position)
    }
}

/// What the bulk viscosity of an element depends on.
#[inline(always)]
fn viscous_state<R: Real>(
    elasticity: &IsotropicElasticity,
    volumetric_rate: R,
    jacobian: R,
    stable_time_step: R,
) -> ViscousState<R> {
    let density = R::splat(elasticity.density()) / jacobian;
    let wave_speed = (R::splat(elasticity.p_wave_modulus()) / density).sqrt();
    let length = wave_speed * stable_time_step;
    ViscousState { volumetric_rate, density, wave_speed, length }
}

/// 16 `coefficient` ρ c V^⅔, N s/m.
#[inline(always)]
fn viscosity<R: Real>(coefficient: f64, elasticity: &IsotropicElasticity, jacobian: R, volume: R) -> R {
    let density = R::splat(elasticity.density()) / jacobian;
    let impedance = (density * elasticity.p_wave_modulus()).sqrt();
    let edge = volume.cbrt();
    impedance * edge * edge * (16.0 * coefficient)
}

/// ∇ξ, ∇η, ∇ζ at the centre times the determinant of ∂x/∂ξ, and one over that.
#[inline(always)]
fn scaled_central_gradients<R: Real>(position: &Modes<R>) -> ([Vector3<R>; 3], R) {
    let [xi, eta, zeta] = [position[0], position[1], position[2]];
    let gradients = [eta.cross(zeta), zeta.cross(xi), xi.cross(eta)];
    (gradients, xi.dot(gradients[0]).recip())
}

/// Forces f_a = Σ_m Γ_ma (T g_m + …), the transpose of the mean gradient and of the hourglass motions.
#[inline(always)]
fn corner_forces<R: Real>(
    now: &MeanOperator<R>,
    stress: &SymmetricTensor<R>,
    hourglass_forces: &[Vector3<R>; HOURGLASS],
    position: &Modes<R>,
) -> CornerVectors<R> {
    let stress = stress.to_tensor();
    let mut modes = [Vector3::zero(); 7];
    for (mode, vector) in modes.iter_mut().zip(&now.vectors) {
        *mode = stress.apply(*vector);
    }
    let per_volume = now.per_eighth * 0.125;
    for (alpha, &force) in hourglass_forces.iter().enumerate() {
        modes[3 + alpha] = force.mul_add(R::splat(0.125), modes[3 + alpha]);
        for (linked, vector) in now.vectors.iter().enumerate() {
            let share = vector.dot(position[3 + alpha]) * per_volume;
            modes[linked] = modes[linked] - force * share;
        }
    }
    corner_values(&modes)
}

/// Mode coefficients of a field with the given corner values.
#[inline(always)]
fn coefficients<R: Real>(corners: &[Vector3<R>; 8]) -> Modes<R> {
    let mut modes = eightfold_modes(corners);
    for mode in &mut modes {
        *mode = *mode * R::splat(1.0 / 8.0);
    }
    modes
}
