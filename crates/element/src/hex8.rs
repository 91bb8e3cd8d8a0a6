//! The eight-node hex with 2 × 2 × 2 Gauss points: `hex8` (full integration), `hex8-f-bar` (de Souza Neto, Perić, Dutko & Owen
//! 1996) and `hex8-b-bar` (mean dilatation; Nagtegaal, Parks & Rice 1974, Hughes 1980).
//!
//! ```text
//!        7-----------6            ζ
//!       /|          /|            |  η
//!      4-----------5 |            | /
//!      | |         | |            |/
//!      | 3---------|-2            +----- ξ
//!      |/          |/
//!      0-----------1
//! ```
//!
//! Corner a lies at (ξ, η, ζ) = `CORNER_SIGNS[a]`, shape functions are N_a = ⅛ (1 + ξ_a ξ)(1 + η_a η)(1 + ζ_a ζ), and a
//! field is x = Σ N_a x_a = c₀ + c_ξ ξ + c_η η + c_ζ ζ + c_ξη ξη + c_ηζ ηζ + c_ζξ ζξ + c_ξηζ ξηζ. Its mode coefficients
//! are sums and differences of the corner values, and ∂x/∂ξ does not depend on ξ, so that it has four distinct values
//! over the eight Gauss points: no table of shape-function gradients is needed. The force is the transpose of the same.
//!
//! F-bar: F̄ = (J₀/J)^⅓ F with J₀ = det F at the centre; in rate form the volumetric part of D is that of the centre.
//!
//! B-bar: the same with the volume change of the whole element, J̄ = v/V and θ̄ = ∫ tr D dv / v, and with the mean pressure in
//! the forces, which makes their power the stress power: ∫ T : D̄ dv = ∫ (dev T : D + p̄ tr D) dv with p̄ v = ∫ p dv.

use crate::PER_ROOT_3;
use crate::bulk_viscosity::{ViscousState, damped_step_factor};
use crate::element::{Element, ElementHistory, ElementMotion, ElementStep, ElementUpdate, Tangent, stiffening};
use crate::stable_time_step::{ElasticBounds, ElementGeometry, Metrics};
use arrayvec::ArrayVec;
use estar_material::points::PackPoints;
use estar_material::{IsotropicElasticity, PointGradients};
use estar_tensor::{Real, SymmetricTensor, Tensor, Vector3, array, inlined};

/// Corners of an element.
pub const CORNERS: usize = 8;
/// Quadrature points of an element. Point i + 2 j + 4 k lies at (±, ±, ±) 1/√3, the sign plus where the bit is set.
pub const POINTS: usize = 8;

/// (ξ, η, ζ) of each corner.
pub const CORNER_SIGNS: [[f64; 3]; CORNERS] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

/// Coordinate of the Gauss points, 1/√3.
const GAUSS: f64 = PER_ROOT_3;

/// A vector at each corner.
pub type CornerVectors<R> = [Vector3<R>; CORNERS];

/// Formulation of the volumetric response.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Formulation {
    /// Volume change of each point: locks when the material is nearly incompressible, as every yielding metal is.
    Full,
    /// Volume change of the centre at every point.
    FBar,
    /// Volume change of the whole element at every point, and the mean pressure in the forces.
    BBar,
}

/// Where the corners are, how they move and what they weigh.
pub type HexMotion<R> = ElementMotion<R, CORNERS>;

/// What a step of a hex gives.
pub type HexUpdate<R> = ElementUpdate<R, CORNERS>;

/// What a hex keeps.
pub type HexHistory<R> = ElementHistory<R, ()>;

impl Element<CORNERS> for Formulation {
    const HAS_LINEAR_FORCES: bool = true;
    const POINTS: usize = POINTS;
    const PARENT: [[f64; 3]; CORNERS] = CORNER_SIGNS;
    type Own<R: Real> = ();

    fn lumped_mass(reference: &CornerVectors<f64>, density: f64) -> [f64; CORNERS] {
        lumped_mass(reference, density)
    }

    fn smallest_jacobian(position: &CornerVectors<f64>) -> f64 {
        least_jacobian(position)
    }

    #[inline(always)]
    fn advance<R: Real>(
        self,
        elasticity: &IsotropicElasticity,
        mut points: PackPoints<'_, R>,
        history: &mut HexHistory<R>,
        motion: &HexMotion<R>,
        step: &ElementStep,
    ) -> HexUpdate<R> {
        let reference_modes = eightfold_modes(&motion.reference);
        let position_modes = eightfold_modes(&motion.position);
        let velocity_modes = eightfold_modes(&motion.velocity);
        let reference = ParentGradients::new(&reference_modes);
        let position = ParentGradients::new(&position_modes);
        let velocity = ParentGradients::new(&velocity_modes);
        let centre = Centre::new(&reference_modes, &position_modes, &velocity_modes, step.time_step);
        let zero = R::splat(0.0);
        let viscous = step
            .bulk_viscosity
            .map(|viscosity| viscosity.response(&viscous_state(elasticity, &centre, history.stable_time_step)));
        let viscous_pressure = viscous.map_or(zero, |response| response.pressure);

        let gradients = inlined!(|point: usize| PointGradients {
            reference: reference.at(point),
            position: position.at(point),
            velocity: velocity.at(point),
        });
        // Each stage takes all points before the next: many short chains of operations side by side keep the processor busier
        // than one long chain a point.
        // (i) the motion of the points
        let volumetric = match self {
            Formulation::Full => None,
            Formulation::FBar => {
                Some(Volumetric { increment: centre.volumetric_rate * step.time_step, jacobian: centre.jacobian })
            }
            Formulation::BBar => Some(Volumetric::mean(gradients, step.time_step)),
        };
        let needs = points.points.needs();
        let exchange = &mut *points.exchange;
        exchange.tells_flow = false;
        let mut per_reference_volumes = ArrayVec::<R, POINTS>::new();
        let mut volume_change = zero;
        for point in 0..POINTS {
            let told = &mut exchange.motions[point];
            let gradients = gradients(point);
            let (scaled_gradient, per_reference_volume) = gradients.scaled_deformation_gradient();
            per_reference_volumes.push(per_reference_volume);
            let (mut increment, volume_half) = gradients.incremental_displacement_gradient(step.time_step);
            let trace = increment.trace();
            volume_change = trace.mul_add(volume_half, volume_change);
            if let Some(volumetric) = volumetric {
                // L̄ = L + ⅓ (θ̄ − tr L) I, of F-bar θ̄ = tr L₀
                increment = increment.plus_spherical((volumetric.increment - trace) * (1.0 / 3.0));
            }
            told.incremental_displacement_gradient = increment;
            told.volume_half = volume_half;
            if needs.rotation {
                told.scaled_gradient = scaled_gradient;
            }
            if needs.deformation_gradient {
                let mut deformation_gradient = scaled_gradient * per_reference_volume;
                if let Some(volumetric) = volumetric {
                    // F̄ = (J̄/J)^⅓ F, of F-bar J̄ = J₀
                    let scale = (volumetric.jacobian / deformation_gradient.determinant()).cbrt();
                    deformation_gradient = deformation_gradient * scale;
                }
                told.deformation_gradient = deformation_gradient;
            }
        }

        // (ii) history and stress
        let update = points.update(step.time_step);
        let stresses = &points.exchange.stresses;

        // (iii) forces f_a = Σ_q T cof(∂x/∂ξ) ∂N_a/∂ξ, of B-bar with the mean pressure in T
        let mean_stress = if self == Formulation::BBar {
            let (mut sum, mut volume) = (zero, zero);
            for (point, stress) in stresses.iter().enumerate() {
                let jacobian = position.at(point).determinant();
                sum = stress.trace().mul_add(jacobian, sum);
                volume += jacobian;
            }
            Some(sum / (volume * 3.0))
        } else {
            None
        };
        let mut cofactors = ArrayVec::<Tensor<R>, POINTS>::new();
        let mut fluxes = ArrayVec::<Tensor<R>, POINTS>::new();
        let mut volume = zero;
        let mut min_jacobian = centre.jacobian;
        let mut metrics = Metrics::none();
        for (point, &stress) in stresses.iter().enumerate() {
            let position_gradient = position.at(point);
            let cofactor = position_gradient.cofactor();
            let jacobian = position_gradient.columns[0].dot(cofactor.columns[0]);
            volume += jacobian;
            min_jacobian = min_jacobian.min(jacobian * per_reference_volumes[point]);
            metrics = metrics.with(&position_gradient, &cofactor, jacobian);
            let mut stress = stress;
            if let Some(mean) = mean_stress {
                stress = stress.plus_spherical(mean - stress.trace() * (1.0 / 3.0));
            }
            fluxes.push(stress.plus_spherical(-viscous_pressure).to_tensor().dot(&cofactor));
            cofactors.push(cofactor);
        }

        let mean_divergence = ParentGradients::sums(&cofactors).transposed();
        let geometry = ElementGeometry {
            metric: metrics.greatest(),
            volume,
            mean_divergence_squared: corner_norm_squared(&mean_divergence),
            divergence_difference_squared: {
                // V b₀ has the linear modes 8 cof₀ V/(8 j₀)
                let scale = volume / centre.parent_jacobian;
                let mut difference = mean_divergence;
                for (mode, column) in difference.iter_mut().zip(centre.cofactor.columns) {
                    *mode = *mode - column * scale;
                }
                corner_norm_squared(&difference)
            },
        };
        let bounds =
            ElasticBounds { shear_modulus: elasticity.shear_modulus(), bulk_modulus: elasticity.bulk_modulus() };
        let undamped = match self {
            Formulation::Full => bounds.stable_time_step(&geometry, motion.corner_mass),
            Formulation::FBar => bounds.stable_time_step_f_bar(&geometry, motion.corner_mass),
            Formulation::BBar => bounds.stable_time_step_b_bar(&geometry, motion.corner_mass),
        };
        let undamped = if let Some(ratio) = update.stiffening { undamped / ratio.sqrt() } else { undamped };
        history.stable_time_step = undamped;
        // −∫∫ q dV̇ dt, the mean pressure of the step on the volume change of all points, as the forces have it
        let mean_pressure = (history.viscous_pressure + viscous_pressure) * 0.5;
        let viscous_energy = -(mean_pressure * volume_change);
        history.viscous_pressure = viscous_pressure;
        HexUpdate {
            internal_force: {
                let eightfold = corner_values(&ParentGradients::sums(&fluxes).transposed());
                array(|corner| eightfold[corner] * R::splat(1.0 / 8.0))
            },
            internal_energy: update.internal_energy,
            plastic_dissipation: update.plastic_dissipation,
            viscous_energy,
            hourglass_energy: zero,
            min_jacobian,
            stable_time_step: viscous
                .map_or(undamped, |response| undamped * damped_step_factor(response.damping_ratio)),
        }
    }

    fn is_damped(self) -> bool {
        false
    }

    #[inline(always)]
    fn tangent<R: Real>(
        self,
        elasticity: &IsotropicElasticity,
        stable_time_step: R,
        motion: &HexMotion<R>,
        step: &ElementStep,
    ) -> Tangent<R> {
        let viscous_modulus = step.bulk_viscosity.map_or(R::splat(0.0), |viscosity| {
            let [reference, position, velocity] =
                [&motion.reference, &motion.position, &motion.velocity].map(eightfold_modes);
            let centre = Centre::new(&reference, &position, &velocity, 0.0);
            viscosity.modulus(&viscous_state(elasticity, &centre, stable_time_step)) * (2.0 / step.time_step)
        });
        Tangent {
            stiffening: stiffening(self, elasticity, stable_time_step, motion),
            viscous_modulus,
            hourglass_modulus: R::splat(0.0),
        }
    }

    /// F-bar and bulk viscosity have pressures from the volume change of the centre, which do work on that of the whole
    /// element: with b̄ b₀ᵀ their symmetric part has ½ (b̄ b₀ᵀ + b₀ b̄ᵀ).
    #[inline(always)]
    fn linear_forces<R: Real>(
        self,
        elasticity: &IsotropicElasticity,
        tangent: &Tangent<R>,
        position: &CornerVectors<R>,
        displacement: &CornerVectors<R>,
    ) -> CornerVectors<R> {
        let position_modes = eightfold_modes(position);
        let displacement_modes = eightfold_modes(displacement);
        let position = ParentGradients::new(&position_modes);
        let displacement = ParentGradients::new(&displacement_modes);
        let centre = Centre::new(&position_modes, &position_modes, &displacement_modes, 0.0);
        let zero = R::splat(0.0);
        let double_shear = tangent.stiffening * (2.0 * elasticity.shear_modulus());
        let bulk = tangent.stiffening * elasticity.bulk_modulus();
        let deviatoric = double_shear * (-1.0 / 3.0);
        // moduli of the pressures from the volume change of the point, of the element and, on the element, of the centre
        let (of_point, of_element, of_centre) = match self {
            Formulation::Full => (deviatoric + bulk, zero, tangent.viscous_modulus),
            Formulation::FBar => (deviatoric, zero, tangent.viscous_modulus + bulk),
            Formulation::BBar => (deviatoric, bulk, tangent.viscous_modulus),
        };

        // 2μ D + λ tr(D) I of the point, with j ∇u = (∂u/∂ξ) cof(∂x/∂ξ)ᵀ
        let mut cofactors = ArrayVec::<Tensor<R>, POINTS>::new();
        let mut stresses = ArrayVec::<SymmetricTensor<R>, POINTS>::new();
        let (mut volume, mut change) = (zero, zero);
        for point in 0..POINTS {
            let gradient = position.at(point);
            let cofactor = gradient.cofactor();
            let jacobian = gradient.columns[0].dot(cofactor.columns[0]);
            let per_jacobian = jacobian.recip();
            let strain = displacement.at(point).dot(&cofactor.transpose()).symmetric_part();
            let trace = strain.trace();
            volume += jacobian;
            change += trace;
            let stress = strain * (double_shear * per_jacobian);
            stresses.push(stress.plus_spherical(of_point * trace * per_jacobian));
            cofactors.push(cofactor);
        }

        // with the uniform tension k θ̄ of B-bar and ½ k θ₀
        let half_of_centre = of_centre * 0.5;
        let tension = half_of_centre.mul_add(centre.volumetric_rate, of_element * change / volume);
        let mut fluxes = ArrayVec::<Tensor<R>, POINTS>::new();
        for (stress, cofactor) in stresses.iter().zip(&cofactors) {
            fluxes.push(stress.plus_spherical(tension).to_tensor().dot(cofactor));
        }
        let mut modes = ParentGradients::sums(&fluxes).transposed();
        // ½ k θ̄ V b₀, where V b₀ has the linear modes cof₀ V/j₀
        let central = half_of_centre * change / centre.parent_jacobian;
        for (mode, column) in modes.iter_mut().zip(centre.cofactor.columns) {
            *mode = column.mul_add(central, *mode);
        }
        let eightfold = corner_values(&modes);
        array(|corner| eightfold[corner] * R::splat(1.0 / 8.0))
    }
}

/// Derivatives of a vector field by ξ, η and ζ: `along[0][j + 2 k]`, `along[1][i + 2 k]`, `along[2][i + 2 j]`.
#[derive(Clone, Copy, Debug)]
struct ParentGradients<R> {
    along: [[Vector3<R>; 4]; 3],
}

/// The three entries of [`ParentGradients::along`] at point q.
const fn entries(point: usize) -> [usize; 3] {
    let (i, j, k) = (point & 1, (point >> 1) & 1, point >> 2);
    [j + 2 * k, i + 2 * k, i + 2 * j]
}

/// Coefficients of the seven modes that deform: ξ, η, ζ, ξη, ηζ, ζξ, ξηζ.
pub(crate) type Modes<R> = [Vector3<R>; 7];

/// Eight times the mode coefficients of a field with the given corner values (a Hadamard transform by butterflies).
#[inline(always)]
pub(crate) fn eightfold_modes<R: Real>(corners: &CornerVectors<R>) -> Modes<R> {
    let x = corners;
    // sums and differences along ξ; those of the edges (0,1) (3,2) (4,5) (7,6)
    let (s0, s1, s2, s3) = (x[0] + x[1], x[3] + x[2], x[4] + x[5], x[7] + x[6]);
    let (d0, d1, d2, d3) = (x[1] - x[0], x[2] - x[3], x[5] - x[4], x[6] - x[7]);
    // along η, then along ζ
    let (ss0, ss1, sd0, sd1) = (s0 + s1, s2 + s3, s1 - s0, s3 - s2);
    let (ds0, ds1, dd0, dd1) = (d0 + d1, d2 + d3, d1 - d0, d3 - d2);
    [ds0 + ds1, sd0 + sd1, ss1 - ss0, dd0 + dd1, sd1 - sd0, ds1 - ds0, dd1 - dd0]
}

/// Corner values of the field with the given mode coefficients: the transpose of [`eightfold_modes`].
#[inline(always)]
pub(crate) fn corner_values<R: Real>(modes: &Modes<R>) -> CornerVectors<R> {
    let [xi, eta, zeta, xi_eta, eta_zeta, zeta_xi, xi_eta_zeta] = *modes;
    // along ζ, then along η, then along ξ
    let (ss0, ss1) = (Vector3::zero() - zeta, zeta);
    let (ds0, ds1) = (xi - zeta_xi, xi + zeta_xi);
    let (sd0, sd1) = (eta - eta_zeta, eta + eta_zeta);
    let (dd0, dd1) = (xi_eta - xi_eta_zeta, xi_eta + xi_eta_zeta);
    let (s0, s1, s2, s3) = (ss0 - sd0, ss0 + sd0, ss1 - sd1, ss1 + sd1);
    let (d0, d1, d2, d3) = (ds0 - dd0, ds0 + dd0, ds1 - dd1, ds1 + dd1);
    [s0 - d0, s0 + d0, s1 + d1, s1 - d1, s2 - d2, s2 + d2, s3 + d3, s3 - d3]
}

/// The four values of a + b s + c t + d s t at s, t = ∓1, s the faster.
#[inline(always)]
fn four_values<R: Real>(a: Vector3<R>, b: Vector3<R>, c: Vector3<R>, d: Vector3<R>) -> [Vector3<R>; 4] {
    let (low, high, low_slope, high_slope) = (a - c, a + c, b - d, b + d);
    [low - low_slope, low + low_slope, high - high_slope, high + high_slope]
}

/// The transpose of [`four_values`].
#[inline(always)]
fn four_sums<R: Real>(values: &[Vector3<R>; 4]) -> [Vector3<R>; 4] {
    let [a, b, c, d] = *values;
    let (low, high, low_slope, high_slope) = (a + b, c + d, b - a, d - c);
    [low + high, low_slope + high_slope, high - low, high_slope - low_slope]
}

impl<R: Real> ParentGradients<R> {
    /// Derivatives at the Gauss points of the field with `modes` times eight.
    #[inline(always)]
    fn new(modes: &Modes<R>) -> Self {
        let linear = |mode: Vector3<R>| mode * R::splat(1.0 / 8.0);
        let bilinear = |mode: Vector3<R>| mode * R::splat(GAUSS / 8.0);
        let [xi, eta, zeta] = [linear(modes[0]), linear(modes[1]), linear(modes[2])];
        let [xi_eta, eta_zeta, zeta_xi] = [bilinear(modes[3]), bilinear(modes[4]), bilinear(modes[5])];
        let xi_eta_zeta = modes[6] * R::splat(GAUSS * GAUSS / 8.0);
        Self {
            along: [
                four_values(xi, xi_eta, zeta_xi, xi_eta_zeta),
                four_values(eta, xi_eta, eta_zeta, xi_eta_zeta),
                four_values(zeta, zeta_xi, eta_zeta, xi_eta_zeta),
            ],
        }
    }

    /// ∂x/∂ξ at a point, the derivatives being the columns.
    #[inline(always)]
    fn at(&self, point: usize) -> Tensor<R> {
        let [xi, eta, zeta] = entries(point);
        Tensor { columns: [self.along[0][xi], self.along[1][eta], self.along[2][zeta]] }
    }

    /// The transpose of [`ParentGradients::at`]: sums of the fluxes of the points, whose columns belong to ∂/∂ξ, ∂/∂η,
    /// ∂/∂ζ.
    #[inline(always)]
    fn sums(fluxes: &[Tensor<R>]) -> Self {
        let mut along = [[Vector3::zero(); 4]; 3];
        for (direction, sums) in along.iter_mut().enumerate() {
            let bit = 1 << direction;
            for point in 0..POINTS {
                if point & bit == 0 {
                    let column = |point: usize| fluxes[point].columns[direction];
                    sums[entries(point)[direction]] = column(point) + column(point | bit);
                }
            }
        }
        Self { along }
    }

    /// The transpose of [`ParentGradients::new`]: eight times what the modes do work on.
    #[inline(always)]
    fn transposed(&self) -> Modes<R> {
        let [xi, eta, zeta] = [four_sums(&self.along[0]), four_sums(&self.along[1]), four_sums(&self.along[2])];
        let gauss = R::splat(GAUSS);
        [
            xi[0],
            eta[0],
            zeta[0],
            (xi[1] + eta[1]) * gauss,
            (eta[2] + zeta[2]) * gauss,
            (xi[2] + zeta[1]) * gauss,
            (xi[3] + eta[3] + zeta[3]) * R::splat(GAUSS * GAUSS),
        ]
    }
}

/// ∂x/∂ξ at the centre from eight times the modes.
#[inline(always)]
fn central_gradient<R: Real>(modes: &Modes<R>) -> Tensor<R> {
    Tensor { columns: [modes[0], modes[1], modes[2]] } * R::splat(1.0 / 8.0)
}

/// Volumetric response of the centre, for F-bar and for bulk viscosity.
#[derive(Clone, Copy)]
struct Centre<R> {
    /// tr L at mid-step, 1/s.
    volumetric_rate: R,
    /// det F_{n+1}.
    jacobian: R,
    /// cof(∂x/∂ξ) at t_{n+1}.
    cofactor: Tensor<R>,
    /// det(∂x/∂ξ) at t_{n+1}.
    parent_jacobian: R,
}

impl<R: Real> Centre<R> {
    #[inline(always)]
    fn new(reference: &Modes<R>, position: &Modes<R>, velocity: &Modes<R>, time_step: f64) -> Self {
        let position = central_gradient(position);
        let velocity = central_gradient(velocity);
        let half = position + velocity * R::splat(-0.5 * time_step);
        let cofactor_half = half.cofactor();
        let jacobian_half = half.columns[0].dot(cofactor_half.columns[0]);
        // tr L = (∂v/∂ξ) : cof(∂x/∂ξ) / det(∂x/∂ξ)
        let flux: [R; 3] = array(|i| velocity.columns[i].dot(cofactor_half.columns[i]));
        let cofactor = position.cofactor();
        let parent_jacobian = position.columns[0].dot(cofactor.columns[0]);
        Self {
            volumetric_rate: (flux[0] + flux[1] + flux[2]) / jacobian_half,
            jacobian: parent_jacobian / central_gradient(reference).determinant(),
            cofactor,
            parent_jacobian,
        }
    }
}

/// Volumetric response that takes the place of that of each point.
#[derive(Clone, Copy)]
struct Volumetric<R> {
    /// Δt tr L at mid-step.
    increment: R,
    /// det F_{n+1}.
    jacobian: R,
}

impl<R: Real> Volumetric<R> {
    /// That of the whole element, for B-bar.
    #[inline(always)]
    fn mean(points: impl Fn(usize) -> PointGradients<R>, time_step: f64) -> Self {
        let zero = R::splat(0.0);
        let (mut change, mut volume_half, mut volume, mut reference_volume) = (zero, zero, zero, zero);
        for point in 0..POINTS {
            let gradients = points(point);
            let (incremental_displacement_gradient, half) = gradients.incremental_displacement_gradient(time_step);
            change = incremental_displacement_gradient.trace().mul_add(half, change);
            volume_half += half;
            volume += gradients.position.determinant();
            reference_volume += gradients.reference.determinant();
        }
        Self { increment: change / volume_half, jacobian: volume / reference_volume }
    }
}

/// What the bulk viscosity of an element depends on.
#[inline(always)]
fn viscous_state<R: Real>(
    elasticity: &IsotropicElasticity,
    centre: &Centre<R>,
    stable_time_step: R,
) -> ViscousState<R> {
    let density = R::splat(elasticity.density()) / centre.jacobian;
    let wave_speed = (R::splat(elasticity.p_wave_modulus()) / density).sqrt();
    let length = wave_speed * stable_time_step;
    ViscousState { volumetric_rate: centre.volumetric_rate, density, wave_speed, length }
}

/// Σ_a |f_a|² of the corner values ⅛ Σ modes, from the orthogonality of the modes: ⅛ Σ |mode|².
#[inline(always)]
fn corner_norm_squared<R: Real>(modes: &Modes<R>) -> R {
    let mut sum = R::splat(0.0);
    for mode in modes {
        sum += mode.dot(*mode);
    }
    sum * (1.0 / 8.0)
}

/// Lumped mass of each corner by row sum, m_a = ∫ ρ N_a dV, kg.
pub fn lumped_mass<R: Real>(reference: &CornerVectors<R>, density: f64) -> [R; CORNERS] {
    let gradients = ParentGradients::new(&eightfold_modes(reference));
    let mut mass = [R::splat(0.0); CORNERS];
    for point in 0..POINTS {
        let point_mass = gradients.at(point).determinant() * density;
        for (corner, signs) in CORNER_SIGNS.iter().enumerate() {
            mass[corner] += point_mass * shape_function(signs, point);
        }
    }
    mass
}

/// det(∂x/∂ξ) at the centre.
pub fn central_jacobian<R: Real>(position: &CornerVectors<R>) -> R {
    central_gradient(&eightfold_modes(position)).determinant()
}

/// Smallest det(∂x/∂ξ) of the quadrature points.
pub fn smallest_jacobian<R: Real>(position: &CornerVectors<R>) -> R {
    let gradients = ParentGradients::new(&eightfold_modes(position));
    (0..POINTS).fold(R::splat(f64::INFINITY), |smallest, point| smallest.min(gradients.at(point).determinant()))
}

/// The smaller of that and of the one at the centre; not a number where the latter is.
pub(crate) fn least_jacobian(position: &CornerVectors<f64>) -> f64 {
    let (smallest, central) = (smallest_jacobian(position), central_jacobian(position));
    if central < smallest { central } else { smallest }
}

/// N_a at a Gauss point.
fn shape_function(corner_signs: &[f64; 3], point: usize) -> f64 {
    let coordinate = |direction: usize| if point >> direction & 1 == 1 { GAUSS } else { -GAUSS };
    (0..3).map(|direction| 0.5 * (1.0 + corner_signs[direction] * coordinate(direction))).product()
}
