//! What the tests of elements share: shapes, materials, and a quadrature of their own from the shape functions
//! themselves, to hold against the sums and differences of the element.

// each file of tests uses a part of this
#![allow(dead_code)]

use estar_element::hex8::{CornerVectors, Formulation, HexHistory, HexMotion, HexStep, HexUpdate, POINTS, advance};
use estar_material::{ElasticConstant, IsotropicElasticity, Material};
use estar_tensor::{Rotation, Tensor, Vector3};

pub type Corners = [[f64; 3]; 8];

pub const FORMULATIONS: [Formulation; 3] = [Formulation::Full, Formulation::FBar, Formulation::BBar];

/// (ξ, η, ζ) of the corners in the order of VTK.
const SIGNS: Corners = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

/// Density, kg/m³.
pub const DENSITY: f64 = 8930.0;
/// Young's modulus, Pa.
pub const YOUNG_MODULUS: f64 = 117e9;

pub fn elasticity(poisson_ratio: f64) -> IsotropicElasticity {
    let constants = (ElasticConstant::YoungModulus(YOUNG_MODULUS), ElasticConstant::PoissonRatio(poisson_ratio));
    IsotropicElasticity::new(DENSITY, constants.0, constants.1).unwrap()
}

/// Numbers in [0, 1) from a linear congruential generator: the same in every run.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    pub fn tensor(&mut self, size: f64) -> Tensor<f64> {
        Tensor::from_rows(std::array::from_fn(|_| std::array::from_fn(|_| self.between(-size, size))))
    }
}

/// The corners of the box with the given sides, centred at the origin.
pub fn brick(sides: [f64; 3]) -> Corners {
    SIGNS.map(|signs| std::array::from_fn(|i| 0.5 * signs[i] * sides[i]))
}

/// Every corner moved by up to `amount` in each direction.
pub fn perturbed(corners: &Corners, amount: f64, random: &mut Random) -> Corners {
    corners.map(|x| x.map(|c| c + random.between(-amount, amount)))
}

pub fn mapped(corners: &Corners, map: &Tensor<f64>) -> Corners {
    corners.map(|x| map.apply(Vector3(x)).0)
}

/// Random hexes that a solver accepts: cubes with displaced corners, stretched up to 10 : 1 in each direction, sheared
/// and turned.
pub fn distorted_hexes(count: usize, random: &mut Random) -> Vec<Corners> {
    let mut hexes = Vec::with_capacity(count);
    while hexes.len() < count {
        let amount = random.between(0.0, 0.45);
        let cube = perturbed(&brick([1.0; 3]), amount, random);
        let mut map = random.tensor(0.5);
        for i in 0..3 {
            map.columns[i].0[i] += 1.0;
        }
        let stretch: [f64; 3] = std::array::from_fn(|_| 10_f64.powf(random.between(-1.0, 0.0)));
        let hex = mapped(&cube.map(|x| std::array::from_fn(|i| stretch[i] * x[i])), &map);
        if is_usable(&hex) {
            hexes.push(hex);
        }
    }
    hexes
}

/// Whether a solver takes a hex of this shape: Jacobians and corner masses are positive.
pub fn is_usable(corners: &Corners) -> bool {
    quadrature(corners).iter().chain([&centre(corners)]).all(|point| point.volume > 0.0)
        && row_sum_mass(corners, 1.0).iter().all(|&mass| mass > 0.0)
}

/// Shape functions of a point on a given geometry.
pub struct Point {
    /// N_a.
    pub shape: [f64; 8],
    /// ∇N_a.
    pub gradient: Corners,
    /// det(∂x/∂ξ), times the weight 1.
    pub volume: f64,
}

/// The point (ξ, η, ζ) of a hex: N_a = ⅛ Π (1 + ξ_a ξ), ∇N_a = (∂x/∂ξ)⁻ᵀ ∂N_a/∂ξ.
fn point(corners: &Corners, xi: [f64; 3]) -> Point {
    let factor = |a: usize, i: usize| 0.5 * (1.0 + SIGNS[a][i] * xi[i]);
    let slope = |a: usize, i: usize| 0.5 * SIGNS[a][i] * factor(a, (i + 1) % 3) * factor(a, (i + 2) % 3);
    let component = |i: usize, j: usize| (0..8).map(|a| corners[a][i] * slope(a, j)).sum::<f64>();
    let jacobian = Tensor::from_rows(std::array::from_fn(|i| std::array::from_fn(|j| component(i, j))));
    let inverse_transposed = jacobian.inverse().transpose();
    Point {
        shape: std::array::from_fn(|a| (0..3).map(|i| factor(a, i)).product()),
        gradient: std::array::from_fn(|a| inverse_transposed.apply(Vector3(std::array::from_fn(|i| slope(a, i)))).0),
        volume: jacobian.determinant(),
    }
}

pub fn quadrature(corners: &Corners) -> [Point; POINTS] {
    SIGNS.map(|signs| point(corners, signs.map(|sign| sign / 3_f64.sqrt())))
}

pub fn centre(corners: &Corners) -> Point {
    point(corners, [0.0; 3])
}

pub fn row_sum_mass(corners: &Corners, density: f64) -> [f64; 8] {
    let points = quadrature(corners);
    std::array::from_fn(|a| points.iter().map(|point| density * point.shape[a] * point.volume).sum())
}

pub fn smallest(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

pub fn vectors(corners: &Corners) -> CornerVectors<f64> {
    corners.map(Vector3)
}

/// The history of an undeformed element.
pub fn initial_history<M: Material>(material: &M) -> HexHistory<M::State<f64>, f64> {
    HexHistory {
        states: [material.initial_state(); POINTS],
        rotations: [Rotation::identity(); POINTS],
        stable_time_step: 0.0,
        viscous_pressure: 0.0,
    }
}

/// Moves an element from `old` to `new` within `step.time_step` along straight lines.
pub fn moved<M: Material>(
    material: &M,
    history: &mut HexHistory<M::State<f64>, f64>,
    reference: &Corners,
    [old, new]: [&Corners; 2],
    step: &HexStep,
) -> HexUpdate<f64> {
    let velocity = std::array::from_fn(|a| Vector3(std::array::from_fn(|i| (new[a][i] - old[a][i]) / step.time_step)));
    let corner_mass = smallest(&row_sum_mass(reference, material.elasticity().density()));
    let motion = HexMotion { reference: vectors(reference), position: vectors(new), velocity, corner_mass };
    advance(material, history, None, &motion, step)
}
