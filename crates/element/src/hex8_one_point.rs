//! The eight-node hex with one point, `hex8-one-point`: the mean gradient of the element (Flanagan & Belytschko 1981), which sees
//! every uniform motion exactly, and hourglass control of the four motions of each direction that it does not see.
//!
//! A field is taken in its modes c_m times eight (see [`hex8`]), those of two letters over √3 besides. In these the mean gradient
//! is L̄ = Σ_m v_m ⊗ g_m/W with
//!
//! ```text
//! g_ξ  = c_η × c_ζ + c_ξη × c_ζξ,   g_ξη = c_η × c_ηζ + c_ζξ × c_ξ,   and so on round ξ → η → ζ → ξ
//! W    = 64 V = ⅓ Σ_m g_m · c_m,    g_ξηζ = 0
//! ```
//!
//! which are the integrals of cof(∂x/∂ξ) ∂N/∂ξ, exact for any trilinear hex. What remains of a motion are the hourglass rates
//! q̇_α = v_α − L̄ c_α, α = ξη, ηζ, ζξ, ξηζ: none in any linear motion. Forces Q_α on them have the power Σ Q_α · q̇_α; they turn
//! with the element, Q̂ = RᵀQ.

use crate::PER_ROOT_3;
use crate::bulk_viscosity::{ViscousState, damped_step_factor};
use crate::element::{Element, ElementHistory, ElementStep, OwnHistory, Tangent, stiffening};
use crate::hex8::{
    self, CORNER_SIGNS, CORNERS, CornerVectors, HexMotion, HexUpdate, Modes, corner_values, eightfold_modes,
};
use crate::stable_time_step::{ElasticBounds, Metrics};
use estar_material::points::{Exchange, PackPoints};
use estar_material::{IsotropicElasticity, PointState};
use estar_tensor::{Real, SymmetricTensor, Tensor, Vector3, array, inlined};

/// Hourglass modes.
const HOURGLASS: usize = 4;
/// Modes with a mean gradient: all but ξηζ.
const LINKED: usize = 6;
/// Squares of what takes a mode as scaled above back to its coefficient: ξη, ηζ, ζξ, ξηζ.
const UNSCALED_SQUARED: [f64; HOURGLASS] = [3.0 / 64.0, 3.0 / 64.0, 3.0 / 64.0, 1.0 / 64.0];

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

/// Hourglass forces Q̂_α of an element in the frame that turns with it, N.
#[derive(Clone, Copy, Debug)]
pub struct HourglassForces<R>(pub [Vector3<R>; HOURGLASS]);

impl<R: Real> PointState<R> for HourglassForces<R> {
    fn for_each(&self, visit: impl FnMut(R)) {
        self.0.iter().flat_map(|force| force.0).for_each(visit);
    }

    fn from_numbers(mut next: impl FnMut() -> R) -> Self {
        Self(array(|_| Vector3(array(|_| next()))))
    }

    fn select(mask: R::Mask, chosen: &Self, otherwise: &Self) -> Self {
        Self(array(|mode| Vector3::select(mask, chosen.0[mode], otherwise.0[mode])))
    }
}

impl<R: Real> OwnHistory<R> for HourglassForces<R> {
    fn at_rest() -> Self {
        Self([Vector3::zero(); HOURGLASS])
    }
}

/// The vectors g_m of ξ, η, ζ, ξη, ηζ, ζξ, m², and the volume.
#[derive(Clone, Copy)]
struct MeanOperator<R> {
    vectors: [Vector3<R>; LINKED],
    /// W = 64 V.
    weight: R,
    /// 1/W.
    per_weight: R,
}

impl<R: Real> MeanOperator<R> {
    #[inline(always)]
    fn new(modes: &Modes<R>) -> Self {
        let [xi, eta, zeta, xi_eta, eta_zeta, zeta_xi, _] = *modes;
        let vectors = [
            two_crosses(eta, zeta, xi_eta, zeta_xi),
            two_crosses(zeta, xi, eta_zeta, xi_eta),
            two_crosses(xi, eta, zeta_xi, eta_zeta),
            two_crosses(eta, eta_zeta, zeta_xi, xi),
            two_crosses(zeta, zeta_xi, xi_eta, eta),
            two_crosses(xi, xi_eta, eta_zeta, zeta),
        ];
        // all four triple products of which ⅓ Σ_m g_m · c_m has each three times
        let weight = xi.dot(vectors[0]) + eta_zeta.dot(vectors[4]);
        Self { vectors, weight, per_weight: weight.recip() }
    }

    /// V, m³.
    #[inline(always)]
    fn volume(&self) -> R {
        self.weight * (1.0 / 64.0)
    }

    /// W² Σ_a b̄_a b̄_aᵀ/8 = 8 W V Σ_a b̄_a b̄_aᵀ, where a field with the values v_a at the corners has the mean gradient Σ_a v_a ⊗ b̄_a.
    #[inline(always)]
    fn spread(&self) -> SymmetricTensor<R> {
        let [xi, eta, zeta, xi_eta, eta_zeta, zeta_xi] = self.vectors;
        squares(&[xi, eta, zeta]) + squares(&[xi_eta, eta_zeta, zeta_xi]) * R::splat(1.0 / 3.0)
    }

    /// Stiffness of the stiffest uniform strain, V (2μ λ_max + λ⁺ tr) of Σ_a b̄_a b̄_aᵀ, N/m.
    #[inline(always)]
    fn uniform_stiffness(&self, elasticity: &IsotropicElasticity) -> R {
        let bounds =
            ElasticBounds { shear_modulus: elasticity.shear_modulus(), bulk_modulus: elasticity.bulk_modulus() };
        bounds.stiffness(&Metrics::of(&self.spread()).greatest()) * self.per_weight * 0.125
    }

    /// Upper bound of c = λ_max(B̄ᵀB̄ XᵀX) of the places X of the corners: tr − 2, since B̄ᵀX = I leaves no principal value below 1.
    #[inline(always)]
    fn obliqueness(&self, position: &Modes<R>) -> R {
        let [xi, eta, zeta, xi_eta, eta_zeta, zeta_xi, xi_eta_zeta] = *position;
        // XᵀX = Σ_a x_a x_aᵀ times 8
        let places = squares(&[xi, eta, zeta, xi_eta_zeta]) + squares(&[xi_eta, eta_zeta, zeta_xi]) * R::splat(3.0);
        (self.spread().double_dot(&places) * (self.per_weight * self.per_weight) - 2.0).max(R::splat(1.0))
    }

    /// Σ_m f_m ⊗ g_m/W, the mean gradient of a field.
    #[inline(always)]
    fn gradient(&self, field: &Modes<R>) -> Tensor<R> {
        self.weighted_gradient(field) * self.per_weight
    }

    /// W times that.
    #[inline(always)]
    fn weighted_gradient(&self, field: &Modes<R>) -> Tensor<R> {
        let mut columns = [Vector3::zero(); 3];
        for (mode, vector) in field.iter().zip(&self.vectors) {
            for (column, component) in columns.iter_mut().zip(vector.0) {
                *column = mode.mul_add(component, *column);
            }
        }
        Tensor { columns }
    }
}

/// What of the hourglass modes of a field its mean gradient does not see.
#[inline(always)]
fn slips<R: Real>(gradient: &Tensor<R>, field: &Modes<R>, position: &Modes<R>) -> [Vector3<R>; HOURGLASS] {
    let mut slips = [Vector3::zero(); HOURGLASS];
    for (alpha, slip) in slips.iter_mut().enumerate() {
        let mut rest = field[3 + alpha];
        for (column, component) in gradient.columns.iter().zip(position[3 + alpha].0) {
            rest = column.mul_add(-component, rest);
        }
        *slip = rest;
    }
    slips
}

/// a × b + c × d.
#[inline(always)]
fn two_crosses<R: Real>(a: Vector3<R>, b: Vector3<R>, c: Vector3<R>, d: Vector3<R>) -> Vector3<R> {
    let component = inlined!(|i: usize, j: usize| {
        let first = a.0[i].mul_add(b.0[j], -(a.0[j] * b.0[i]));
        c.0[i].mul_add(d.0[j], (-c.0[j]).mul_add(d.0[i], first))
    });
    Vector3([component(1, 2), component(2, 0), component(0, 1)])
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

    /// Hourglass forces of the hourglass motion `slip` (m) of a hex with these tangents.
    ///
    /// The displacement Σ q_α h_α has a gradient with a part linear in ζ, q_ηζ ⊗ ∇η + q_ζξ ⊗ ∇ξ; in the plane normal to ∇ζ,
    /// which the tangents of ξ and η span, it is the bending and torsion of a plate in plane stress. With the metric m_ab = x_a · x_b
    /// of the tangents and its inverse m^ab, ε_ξξ = q_ζξ · x_ξ, ε_ηη = q_ηζ · x_η, 2 ε_ξη = q_ζξ · x_η + q_ηζ · x_ξ and
    /// σ^ab = 2μ (m^ac m^bd ε_cd + ν/(1 − ν) m^ab tr ε). Likewise round ξ → η → ζ → ξ. The trilinear mode stretches along ∇ξ by
    /// η ζ q · ∇ξ, in uniaxial stress.
    #[inline(always)]
    fn forces<R: Real>(
        &self,
        slip: &[Vector3<R>; HOURGLASS],
        tangents: &Tangents<R>,
        volume: R,
    ) -> [Vector3<R>; HOURGLASS] {
        let Tangents { tangents: [xi, eta, zeta], cofactors, planes, per_determinant_squared } = tangents;
        let [xi_eta, eta_zeta, zeta_xi, xi_eta_zeta] = *slip;
        // of the plane normal to ∇ζ the modes ζξ with ∇ξ and ηζ with ∇η, and so on round; ∫ ζ² dV = V/3, against the 3 of two
        // modes over √3
        let modulus = volume * (2.0 * self.shear);
        let of_xi = self.plane(xi_eta, zeta_xi, *eta, *zeta, &planes[0], modulus);
        let of_eta = self.plane(eta_zeta, xi_eta, *zeta, *xi, &planes[1], modulus);
        let of_zeta = self.plane(zeta_xi, eta_zeta, *xi, *eta, &planes[2], modulus);
        // ∫ η² ζ² dV = V/9
        let ninth = volume * *per_determinant_squared * (self.young / 9.0);
        let mut of_trilinear = Vector3::zero();
        for cofactor in cofactors {
            of_trilinear = cofactor.mul_add(xi_eta_zeta.dot(*cofactor) * ninth, of_trilinear);
        }
        [of_xi[0] + of_eta[1], of_eta[0] + of_zeta[1], of_zeta[0] + of_xi[1], of_trilinear]
    }

    /// Forces on two modes whose slips bend the plane of the tangents `x` and `y`.
    #[inline(always)]
    fn plane<R: Real>(
        &self,
        slip_of_x: Vector3<R>,
        slip_of_y: Vector3<R>,
        x: Vector3<R>,
        y: Vector3<R>,
        plane: &Plane<R>,
        modulus: R,
    ) -> [Vector3<R>; 2] {
        let Plane { xx, yy, xy } = *plane;
        let strain_xx = slip_of_x.dot(x);
        let strain_yy = slip_of_y.dot(y);
        let strain_xy = (slip_of_x.dot(y) + slip_of_y.dot(x)) * 0.5;
        // m^ac ε_cb
        let mixed_xx = xx.mul_add(strain_xx, xy * strain_xy);
        let mixed_xy = xx.mul_add(strain_xy, xy * strain_yy);
        let mixed_yx = xy.mul_add(strain_xx, yy * strain_xy);
        let mixed_yy = xy.mul_add(strain_xy, yy * strain_yy);
        let sphere = (mixed_xx + mixed_yy) * self.lateral;
        let (along_x, along_y) = (mixed_xx + sphere, mixed_yy + sphere);
        let stress_xx = along_x.mul_add(xx, mixed_xy * xy) * modulus;
        let stress_xy = along_x.mul_add(xy, mixed_xy * yy) * modulus;
        let stress_yy = mixed_yx.mul_add(xy, along_y * yy) * modulus;
        [x.mul_add(stress_xx, y * stress_xy), x.mul_add(stress_xy, y * stress_yy)]
    }

    /// Upper bound K of |Q| ≤ K |q|, N/m, for coefficients q that are not scaled.
    ///
    /// By |sym(P H P)| ≤ |P H P| and |a ⊗ P∇ξ + b ⊗ P∇η|² ≤ λ (a² + b²), λ the larger principal value of m^ab, the energy of each plane is
    /// at most (V/3) λ (a² + b²) max(μ, μ (1 + ν)/(1 − ν)), and each mode is in two of the planes; the rows of m^ab bound λ. That of the
    /// trilinear mode is at most (V/18) E (|∇ξ|² + |∇η|² + |∇ζ|²) q².
    #[inline(always)]
    fn bound<R: Real>(&self, tangents: &Tangents<R>, volume: R) -> R {
        let Tangents { cofactors, planes, per_determinant_squared, .. } = tangents;
        let [xi, eta, zeta] = planes;
        let rows = [xi.largest_row(), eta.largest_row(), zeta.largest_row()];
        let two_largest = (rows[0] + rows[1]).max(rows[1] + rows[2]).max(rows[2] + rows[0]);
        let of_planes = two_largest * (2.0 / 3.0 * self.shear * (1.0 + 2.0 * self.lateral).max(1.0));
        let squares = cofactors[0].dot(cofactors[0]) + cofactors[1].dot(cofactors[1]) + cofactors[2].dot(cofactors[2]);
        let of_trilinear = squares * *per_determinant_squared * (self.young / 9.0);
        // tangents are eightfold
        of_planes.max(of_trilinear) * volume * 64.0
    }
}

/// The tangents ∂x/∂ξ, ∂x/∂η, ∂x/∂ζ at the centre times eight, and what follows from them.
struct Tangents<R> {
    tangents: [Vector3<R>; 3],
    /// x_η × x_ζ and so on round, along ∇ξ, ∇η, ∇ζ.
    cofactors: [Vector3<R>; 3],
    /// The planes normal to these.
    planes: [Plane<R>; 3],
    /// 1/(x_ξ · x_η × x_ζ)².
    per_determinant_squared: R,
}

impl<R: Real> Tangents<R> {
    #[inline(always)]
    fn new(tangents: [Vector3<R>; 3]) -> Self {
        let [xi, eta, zeta] = tangents;
        let cofactors = [eta.cross(zeta), zeta.cross(xi), xi.cross(eta)];
        let (xi_xi, eta_eta, zeta_zeta) = (xi.dot(xi), eta.dot(eta), zeta.dot(zeta));
        let (xi_eta, eta_zeta, zeta_xi) = (xi.dot(eta), eta.dot(zeta), zeta.dot(xi));
        let planes = [
            Plane::new(eta_eta, zeta_zeta, eta_zeta, cofactors[0]),
            Plane::new(zeta_zeta, xi_xi, zeta_xi, cofactors[1]),
            Plane::new(xi_xi, eta_eta, xi_eta, cofactors[2]),
        ];
        let determinant = xi.dot(cofactors[0]);
        Self { tangents, cofactors, planes, per_determinant_squared: (determinant * determinant).recip() }
    }
}

/// The inverse m^ab of the metric of two tangents x and y, 1/m².
struct Plane<R> {
    xx: R,
    yy: R,
    xy: R,
}

impl<R: Real> Plane<R> {
    /// From x · x, y · y, x · y and x × y.
    #[inline(always)]
    fn new(xx: R, yy: R, xy: R, area: Vector3<R>) -> Self {
        let per_area_squared = area.dot(area).recip();
        Self { xx: yy * per_area_squared, yy: xx * per_area_squared, xy: -(xy * per_area_squared) }
    }

    /// No principal value is greater.
    #[inline(always)]
    fn largest_row(&self) -> R {
        self.xx.max(self.yy) + self.xy.abs()
    }
}

impl Element<CORNERS> for HourglassControl {
    const HAS_LINEAR_FORCES: bool = true;
    const POINTS: usize = 1;
    const PARENT: [[f64; 3]; CORNERS] = CORNER_SIGNS;
    type Own<R: Real> = HourglassForces<R>;

    fn lumped_mass(reference: &CornerVectors<f64>, density: f64) -> [f64; CORNERS] {
        hex8::lumped_mass(reference, density)
    }

    fn smallest_jacobian(position: &CornerVectors<f64>) -> f64 {
        hex8::least_jacobian(position)
    }

    #[inline(always)]
    fn advance<R: Real>(
        self,
        elasticity: &IsotropicElasticity,
        mut points: PackPoints<'_, R>,
        history: &mut ElementHistory<R, HourglassForces<R>>,
        motion: &HexMotion<R>,
        step: &ElementStep,
    ) -> HexUpdate<R> {
        let zero = R::splat(0.0);
        let reference = scaled_modes(&motion.reference);
        let position = scaled_modes(&motion.position);
        let initially = MeanOperator::new(&reference);
        let now = MeanOperator::new(&position);
        let jacobian = now.weight * initially.per_weight;
        let volume = now.volume();

        // (i) the mean motion
        let mean_gradient = initially.weighted_gradient(&position);
        let velocity = scaled_modes(&motion.velocity);
        let half_step = R::splat(-0.5 * step.time_step);
        let mut half = position;
        for (half, velocity) in half.iter_mut().zip(&velocity) {
            *half = velocity.mul_add(half_step, *half);
        }
        let midway = MeanOperator::new(&half);
        let volume_half = midway.volume();
        let velocity_gradient = midway.gradient(&velocity);
        let told = &mut points.exchange.motions[0];
        told.incremental_displacement_gradient = velocity_gradient * R::splat(step.time_step);
        told.scaled_gradient = mean_gradient;
        told.volume_half = volume_half;
        if points.points.needs().deformation_gradient {
            // the volume is that of the hex, not of its mean gradient
            told.deformation_gradient = mean_gradient * (jacobian / mean_gradient.determinant()).cbrt();
        }
        points.exchange.tells_flow = true;

        // (ii) history and stress of the point, and what the bound needs of the geometry
        let update = points.update(step.time_step);
        let Exchange { stresses: [stress, ..], rotations: [[rotation_old, rotation], ..], flow: [flow, ..], .. } =
            *points.exchange;
        let mut slip_rates = slips(&velocity_gradient, &velocity, &half);
        let uniform = now.uniform_stiffness(elasticity);
        let obliqueness = now.obliqueness(&position);
        let volumetric_rate = velocity_gradient.trace();
        let viscous = step.bulk_viscosity.map(|viscosity| {
            viscosity.response(&viscous_state(elasticity, volumetric_rate, jacobian, history.stable_time_step))
        });
        let viscous_pressure = viscous.map_or(zero, |response| response.pressure);

        // (iii) hourglass forces, in the frame that turns with the element
        let turned = rotation.to_tensor();
        let turned_half = rotation_old.half_way_to(rotation);
        let mut slips = slip_rates;
        for (rate, slip) in slip_rates.iter_mut().zip(&mut slips) {
            *rate = turned_half.transpose_apply(*rate);
            *slip = *rate * R::splat(step.time_step);
        }
        let HourglassForces(forces_old) = history.own;
        let mut hourglass_stiffness = zero;
        let mut hourglass_viscosity = zero;
        let mut forces = forces_old;
        match self {
            Self::Physical => {
                let assumed = AssumedStrain::new(elasticity);
                let [xi, eta, zeta, ..] = position;
                let mut tangents = [xi, eta, zeta];
                for tangent in &mut tangents {
                    *tangent = turned.transpose_apply(*tangent);
                }
                let tangents = Tangents::new(tangents);
                hourglass_stiffness = assumed.bound(&tangents, volume);
                let increments = assumed.forces(&slips, &tangents, volume);
                // the deviator returns by ‖s‖/‖s trial‖ = σ/(σ + 3μ Δε̄ᵖ), and by the flow rule so does what is added to it
                let equivalent = (stress.deviator().norm_squared() * 1.5).sqrt();
                let returned = equivalent / flow.mul_add(R::splat(3.0 * elasticity.shear_modulus()), equivalent);
                let kept = R::select(flow.gt(zero), returned, R::splat(1.0));
                for (force, increment) in forces.iter_mut().zip(increments) {
                    *force = (*force + increment) * kept;
                }
            }
            Self::Stiffness { coefficient } => {
                hourglass_stiffness = uniform * (8.0 * coefficient);
                for ((force, slip), scale) in forces.iter_mut().zip(&slips).zip(UNSCALED_SQUARED) {
                    *force = slip.mul_add(hourglass_stiffness * scale, *force);
                }
            }
            Self::Viscous { coefficient } => {
                hourglass_viscosity = viscosity(coefficient, elasticity, jacobian, volume);
                for ((force, rate), scale) in forces.iter_mut().zip(&slip_rates).zip(UNSCALED_SQUARED) {
                    *force = *rate * (hourglass_viscosity * scale);
                }
            }
        }
        history.own = HourglassForces(forces);
        let mut hourglass_energy = zero;
        for alpha in 0..HOURGLASS {
            hourglass_energy += (forces_old[alpha] + forces[alpha]).dot(slips[alpha]);
        }
        hourglass_energy = hourglass_energy * 0.5;

        // (iv) forces of the stress and of the hourglass forces, turned back
        for force in &mut forces {
            *force = turned.apply(*force);
        }
        let internal_force = corner_forces(&now, &stress.plus_spherical(-viscous_pressure), &forces, &position);

        // (v) Δt = 2/ω, ω² ≤ λ/m; of motions q = Γ u with Γ = (I − X B̄ᵀ)/√8 on the hourglass modes, |Γ|² ≤ |X B̄ᵀ|²/8 ≤ c/8, since a
        // projection and its complement have one norm
        let of_corners = obliqueness * 0.125;
        let largest = largest_stiffness(uniform, hourglass_stiffness * of_corners, obliqueness);
        let mut undamped = (motion.corner_mass / largest).sqrt() * 2.0;
        if let Some(ratio) = update.stiffening {
            // hourglass control has the moduli at rest, and does not soften with the material
            undamped = undamped / ratio.max(R::splat(1.0)).sqrt();
        }
        history.stable_time_step = undamped;
        // damping ratio ξ = C/(2 m ω) of the hourglass viscosity
        let hourglass_damping = hourglass_viscosity * of_corners * undamped / (motion.corner_mass * 4.0);
        let damping = viscous.map_or(zero, |response| response.damping_ratio) + hourglass_damping;
        let mean_pressure = (history.viscous_pressure + viscous_pressure) * 0.5;
        let viscous_energy = -(mean_pressure * volumetric_rate * volume_half * step.time_step);
        history.viscous_pressure = viscous_pressure;
        HexUpdate {
            internal_force,
            internal_energy: update.internal_energy,
            plastic_dissipation: update.plastic_dissipation,
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
        let [reference, position, velocity] = [&motion.reference, &motion.position, &motion.velocity].map(scaled_modes);
        let now = MeanOperator::new(&position);
        let jacobian = now.weight * MeanOperator::new(&reference).per_weight;
        let per_half_step = 2.0 / step.time_step;
        let viscous_modulus = step.bulk_viscosity.map_or(zero, |bulk_viscosity| {
            let volumetric_rate = now.gradient(&velocity).trace();
            let state = viscous_state(elasticity, volumetric_rate, jacobian, stable_time_step);
            bulk_viscosity.modulus(&state) * per_half_step
        });
        let stiffening = stiffening(self, elasticity, stable_time_step, motion);
        let hourglass_modulus = match self {
            Self::Physical => zero,
            Self::Stiffness { coefficient } => now.uniform_stiffness(elasticity) * stiffening * (8.0 * coefficient),
            Self::Viscous { coefficient } => viscosity(coefficient, elasticity, jacobian, now.volume()) * per_half_step,
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
        let position = scaled_modes(position);
        let displacement = scaled_modes(displacement);
        let now = MeanOperator::new(&position);
        let gradient = now.gradient(&displacement);
        let strain = gradient.symmetric_part();
        let double_shear = tangent.stiffening * (2.0 * elasticity.shear_modulus());
        let bulk = tangent.stiffening.mul_add(R::splat(elasticity.bulk_modulus()), tangent.viscous_modulus);
        let tension = (double_shear * (-1.0 / 3.0) + bulk) * strain.trace();
        let stress = (strain * double_shear).plus_spherical(tension);
        let mut forces = slips(&gradient, &displacement, &position);
        if self == Self::Physical {
            let [xi, eta, zeta, ..] = position;
            forces = AssumedStrain::new(elasticity).forces(&forces, &Tangents::new([xi, eta, zeta]), now.volume());
            for force in &mut forces {
                *force = *force * tangent.stiffening;
            }
        } else {
            for (force, scale) in forces.iter_mut().zip(UNSCALED_SQUARED) {
                *force = *force * (tangent.hourglass_modulus * scale);
            }
        }
        corner_forces(&now, &stress, &forces, &position)
    }
}

/// Upper bound of the principal values of A + B, both symmetric and not negative: A ≤ `uniform` and zero but on the span of the b̄, B ≤
/// `hourglass` and zero but on what is normal to the fields that are linear in place. B̄ᵀX = I and c = λ_max(B̄ᵀB̄ XᵀX), the `obliqueness`, say
/// that no field of the span is more than arccos(1/√c) off the linear ones, so that the cosine between the two supports is at most
/// s = √(1 − 1/c). Hence the values are at most those of the matrix of `uniform`, `hourglass` and s times their geometric mean beside the diagonal.
#[inline(always)]
fn largest_stiffness<R: Real>(uniform: R, hourglass: R, obliqueness: R) -> R {
    let half_difference = (uniform - hourglass) * 0.5;
    let coupling = uniform * hourglass * ((obliqueness - 1.0) / obliqueness);
    (uniform + hourglass).mul_add(R::splat(0.5), half_difference.mul_add(half_difference, coupling).sqrt())
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

/// Forces f_a = Σ_m Γ_ma (T g_m + …), the transpose of the mean gradient and of the hourglass motions.
#[inline(always)]
fn corner_forces<R: Real>(
    now: &MeanOperator<R>,
    stress: &SymmetricTensor<R>,
    hourglass_forces: &[Vector3<R>; HOURGLASS],
    position: &Modes<R>,
) -> CornerVectors<R> {
    // V T : L̄ + Σ Q_α · (v_α − L̄ c_α) with L̄ = Σ v_m ⊗ g_m/W
    let mut columns = [Vector3::zero(); 3];
    for (force, place) in hourglass_forces.iter().zip(&position[3..]) {
        for (column, component) in columns.iter_mut().zip(place.0) {
            *column = force.mul_add(component, *column);
        }
    }
    let per_vector = (*stress * R::splat(1.0 / 64.0)).to_tensor() + Tensor { columns } * -now.per_weight;
    let mut modes = [Vector3::zero(); 7];
    for (mode, vector) in modes.iter_mut().zip(&now.vectors) {
        *mode = per_vector.apply(*vector);
    }
    for (mode, force) in modes[3..].iter_mut().zip(hourglass_forces) {
        *mode = *mode + *force;
    }
    for mode in &mut modes[3..LINKED] {
        *mode = *mode * R::splat(PER_ROOT_3);
    }
    corner_values(&modes)
}

/// Modes of a field with the given corner values, scaled as the head of this file says.
#[inline(always)]
fn scaled_modes<R: Real>(corners: &[Vector3<R>; 8]) -> Modes<R> {
    let mut modes = eightfold_modes(corners);
    for mode in &mut modes[3..LINKED] {
        *mode = *mode * R::splat(PER_ROOT_3);
    }
    modes
}
