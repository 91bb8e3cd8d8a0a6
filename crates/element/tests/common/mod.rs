//! What the tests of elements share: shapes, materials, and a quadrature of their own from the shape functions
//! themselves, to hold against the sums and differences of the element.

// each file of tests uses a part of this
#![allow(dead_code)]

use estar_element::element::{Element, ElementHistory, ElementMotion, ElementStep, ElementUpdate};
use estar_element::hex8::{CornerVectors, Formulation, HexMotion, HexUpdate, POINTS};
use estar_material::points::{Exchange, MaterialPoints, PackPoints, StoredPoints};
use estar_material::{ElasticConstant, IsotropicElasticity, Material};
use estar_tensor::{Kernel, Real, Rotation, SymmetricTensor, Tensor, Vector3};
use std::sync::Arc;

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

/// An element of a material on its way, or as many as there are lanes.
pub struct Driven<E: Element<NODES>, M: Material, R: Real, const NODES: usize> {
    pub element: E,
    pub material: Arc<M>,
    pub points: Box<dyn KnownPoints<M, R>>,
    pub history: ElementHistory<R, E::Own<R>>,
}

impl<E: Element<NODES>, M: Material, R: Real, const NODES: usize> Driven<E, M, R, NODES> {
    pub fn new(element: E, material: &M) -> Self {
        let material = Arc::new(material.clone());
        let points: Box<dyn KnownPoints<M, R>> = match E::POINTS {
            1 => Box::new(StoredPoints::<M, R, 1>::new(material.clone(), 1, 1)),
            count => Box::new(StoredPoints::<M, R, 4>::new(material.clone(), count / 4, 1)),
        };
        Self { element, material, points, history: ElementHistory::new(0.0) }
    }

    pub fn advance(&mut self, motion: &ElementMotion<R, NODES>, step: &ElementStep) -> ElementUpdate<R, NODES> {
        R::vectorize(Advance { driven: self, motion, step })
    }

    /// T of each point.
    pub fn stresses(&self) -> Vec<SymmetricTensor<R>> {
        let points = self.points.states().into_iter().zip(self.points.rotations());
        points.map(|(state, rotation)| self.material.cauchy_stress(&state, rotation)).collect()
    }

    /// Every number of its points and of its own.
    pub fn for_each(&self, visit: &mut dyn FnMut(R)) {
        self.points.for_each(0, visit);
        self.history.for_each(visit);
    }
}

impl<E: Element<NODES>, M: Material, R: Real, const NODES: usize> Clone for Driven<E, M, R, NODES> {
    fn clone(&self) -> Self {
        let (material, points) = (self.material.clone(), self.points.cloned());
        Self { element: self.element, material, points, history: self.history }
    }
}

/// The points of one pack of a material that is known.
pub trait KnownPoints<M: Material, R: Real>: MaterialPoints<R> {
    fn states(&self) -> Vec<M::State<R>>;
    fn rotations(&self) -> Vec<Rotation<R>>;
    fn cloned(&self) -> Box<dyn KnownPoints<M, R>>;
}

impl<M: Material, R: Real, const POINTS: usize> KnownPoints<M, R> for StoredPoints<M, R, POINTS> {
    fn states(&self) -> Vec<M::State<R>> {
        self.states().as_flattened().to_vec()
    }

    fn rotations(&self) -> Vec<Rotation<R>> {
        self.rotations().as_flattened().to_vec()
    }

    fn cloned(&self) -> Box<dyn KnownPoints<M, R>> {
        Box::new(self.clone())
    }
}

/// One step, compiled for its lanes.
struct Advance<'a, E: Element<NODES>, M: Material, R: Real, const NODES: usize> {
    driven: &'a mut Driven<E, M, R, NODES>,
    motion: &'a ElementMotion<R, NODES>,
    step: &'a ElementStep,
}

impl<E: Element<NODES>, M: Material, R: Real, const NODES: usize> Kernel for Advance<'_, E, M, R, NODES> {
    type Output = ElementUpdate<R, NODES>;

    #[inline(always)]
    fn run(self) -> ElementUpdate<R, NODES> {
        let Driven { element, material, points, history } = self.driven;
        let points = PackPoints { points: &mut **points, pack: 0, exchange: &mut Exchange::new() };
        element.advance(material.elasticity(), points, history, self.motion, self.step)
    }
}

/// A hex of eight points.
pub type Hex<M> = Driven<Formulation, M, f64, 8>;

impl<M: Material> Hex<M> {
    /// Moves it from `old` to `new` within `step.time_step` along straight lines.
    pub fn moved(&mut self, reference: &Corners, [old, new]: [&Corners; 2], step: &ElementStep) -> HexUpdate<f64> {
        let velocity =
            std::array::from_fn(|a| Vector3(std::array::from_fn(|i| (new[a][i] - old[a][i]) / step.time_step)));
        let corner_mass = smallest(&row_sum_mass(reference, self.material.elasticity().density()));
        let motion = HexMotion { reference: vectors(reference), position: vectors(new), velocity, corner_mass };
        self.advance(&motion, step)
    }
}
