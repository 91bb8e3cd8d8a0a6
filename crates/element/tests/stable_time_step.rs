//! Goal: the bound behind the stable time step is safe for both operators, `hex8` and `hex8-f-bar`, and not wasteful.
//!
//! Mesh: one element; hundreds of distorted shapes, and the extremes that meshes have or come to have: flat, needle,
//! sheared, tapered. Materials from auxetic to nearly incompressible.
//!
//! Source: the exact value is the largest singular value of M^{-½} K M^{-½} (24 × 24), from B matrices of this file's
//! own quadrature, row-sum mass, K = Σ j Bᵀ C B and for F-bar Σ j (B_devᵀ C B_dev) + k V b̄ ⊗ b₀, by faer. The bound comes
//! out of the shipped element: a step of length 0 gives Δt = 2/ω.
//!
//! Safety costs: a random distorted hex of copper (ν = 0.3) runs at 0.85 of its exact step in the median and at 0.58 at
//! worst; nearly incompressible at 0.9 and 0.63; flat and needle-like bricks at 0.96 to 1. The figures stand in the tests.

mod common;

use common::{
    Corners, DENSITY, FORMULATIONS, Hex, Random, brick, centre, distorted_hexes, elasticity, is_usable, mapped,
    quadrature, row_sum_mass, smallest, vectors,
};
use estar_element::element::ElementStep;
use estar_element::hex8::{Formulation, HexMotion};
use estar_material::{Elastic, IsotropicElasticity};
use estar_tensor::{Tensor, Vector3};
use faer::Mat;

/// ν from auxetic to nearly incompressible.
const POISSON_RATIOS: [f64; 4] = [-0.5, 0.0, 0.3, 0.4999];

/// What the bound may lose where it is exact but for its rounding, which is upwards and greatest for cubes.
const ROUNDED_UP: f64 = 1e-6;

/// ω² that the element's stable time step stands for.
fn bound(corners: &Corners, elasticity: &IsotropicElasticity, formulation: Formulation) -> f64 {
    let material = Elastic::new(*elasticity);
    let (position, velocity) = (vectors(corners), [Vector3([0.0; 3]); 8]);
    let corner_mass = smallest(&row_sum_mass(corners, elasticity.density()));
    let at_rest = HexMotion { reference: position, position, velocity, corner_mass };
    let step = ElementStep { bulk_viscosity: None, time_step: 0.0 };
    let update = Hex::new(formulation, &material).advance(&at_rest, &step);
    (2.0 / update.stable_time_step).powi(2)
}

/// M^{-½} K M^{-½}.
fn operator(corners: &Corners, elasticity: &IsotropicElasticity, formulation: Formulation) -> Mat<f64> {
    let (shear, bulk) = (elasticity.shear_modulus(), elasticity.bulk_modulus());
    let points = quadrature(corners);
    let volume: f64 = points.iter().map(|point| point.volume).sum();
    let mean = |a: usize, i: usize| points.iter().map(|p| p.volume * p.gradient[a][i]).sum::<f64>() / volume;
    let centre = centre(corners);
    let mass = row_sum_mass(corners, DENSITY);
    Mat::from_fn(24, 24, |row, column| {
        let ((a, i), (b, j)) = ((row / 3, row % 3), (column / 3, column % 3));
        let mut stiffness = 0.0;
        for point in &points {
            let (at_a, at_b) = (&point.gradient[a], &point.gradient[b]);
            // 2μ D : D of u = N_a e_i and N_b e_j, less its volumetric third
            let along: f64 = if i == j { (0..3).map(|l| at_a[l] * at_b[l]).sum() } else { 0.0 };
            stiffness += point.volume * shear * (along + at_a[j] * at_b[i] - 2.0 / 3.0 * at_a[i] * at_b[j]);
            if formulation == Formulation::Full {
                stiffness += point.volume * bulk * at_a[i] * at_b[j];
            }
        }
        if formulation == Formulation::FBar {
            stiffness += bulk * volume * mean(a, i) * centre.gradient[b][j];
        }
        if formulation == Formulation::BBar {
            stiffness += bulk * volume * mean(a, i) * mean(b, j);
        }
        stiffness / (mass[a] * mass[b]).sqrt()
    })
}

/// Largest singular value.
fn norm(operator: &Mat<f64>) -> f64 {
    operator.singular_values().unwrap().into_iter().fold(0.0, f64::max)
}

/// How much of the exactly stable time step the bound leaves, from the norm (which is what the proof bounds).
fn share(corners: &Corners, elasticity: &IsotropicElasticity, formulation: Formulation) -> f64 {
    let operator = operator(corners, elasticity, formulation);
    let (exact, bound) = (norm(&operator), bound(corners, elasticity, formulation));
    let name = format!("{formulation:?}, nu = {}, {corners:?}", elasticity.poisson_ratio());
    assert!(bound >= exact * (1.0 - 1e-10), "{bound} < {exact}: {name}");
    let radius = operator.eigenvalues().unwrap().iter().map(|z| z.re.hypot(z.im)).fold(0.0, f64::max);
    assert!(radius <= exact * (1.0 + 1e-10), "{radius} > {exact}: {name}");
    (exact / bound).sqrt()
}

/// Shares of many shapes, sorted.
fn shares(shapes: &[Corners], poisson_ratio: f64, formulation: Formulation) -> Vec<f64> {
    let elasticity = elasticity(poisson_ratio);
    let mut shares: Vec<f64> = shapes.iter().map(|shape| share(shape, &elasticity, formulation)).collect();
    shares.sort_by(f64::total_cmp);
    println!(
        "{formulation:?}, nu = {poisson_ratio}: least {:.3}, median {:.3}, most {:.3} of the exact step",
        shares[0],
        shares[shares.len() / 2],
        shares[shares.len() - 1]
    );
    shares
}

/// The least and the median share that a set of shapes keeps, to two digits, for ν of [`POISSON_RATIOS`].
type Kept = [[f64; 2]; 4];

fn assert_kept(shapes: &[Corners], formulation: Formulation, kept: Kept) {
    let found = POISSON_RATIOS.map(|poisson_ratio| {
        let shares = shares(shapes, poisson_ratio, formulation);
        [shares[0], shares[shares.len() / 2]]
    });
    for (found, kept) in found.as_flattened().iter().zip(kept.as_flattened()) {
        assert!((found - kept).abs() < 0.006, "{formulation:?}: {found} instead of {kept}");
    }
}

#[test]
fn bound_holds_for_hundreds_of_distorted_hexes() {
    let shapes = distorted_hexes(300, &mut Random::new(1));
    assert_kept(&shapes, Formulation::Full, [[0.50, 0.75], [0.56, 0.85], [0.58, 0.85], [0.63, 0.88]]);
    assert_kept(&shapes, Formulation::FBar, [[0.49, 0.75], [0.52, 0.84], [0.58, 0.85], [0.74, 0.92]]);
    assert_kept(&shapes, Formulation::BBar, [[0.50, 0.75], [0.54, 0.85], [0.63, 0.87], [0.80, 0.95]]);
}

#[test]
fn bound_holds_for_flat_needle_sheared_and_tapered_hexes() {
    let mut shapes = Vec::new();
    let shear = |amount: f64| Tensor::from_rows([[1.0, amount, 0.3 * amount], [0.0, 1.0, amount], [0.0, 0.0, 1.0]]);
    for sides in [[1.0, 1.0, 0.01], [1.0, 1.0, 100.0], [1.0, 0.1, 0.01], [1.0, 1.0, 1.0]] {
        shapes.push(brick(sides));
        shapes.push(mapped(&brick(sides), &shear(3.0)));
        // one face a tenth of the other, and one face nearly closed on its neighbour's edge
        let taper = |x: [f64; 3]| if x[2] > 0.0 { [0.1 * x[0], 0.1 * x[1], x[2]] } else { x };
        shapes.push(brick(sides).map(taper));
        let wedge = |x: [f64; 3]| if x[2] > 0.0 && x[0] > 0.0 { [x[0], x[1], -0.49 * sides[2]] } else { x };
        shapes.push(brick(sides).map(wedge));
    }
    assert!(shapes.iter().all(is_usable));
    assert_kept(&shapes, Formulation::Full, [[0.49, 0.87], [0.57, 1.0], [0.57, 1.0], [0.57, 1.0]]);
    assert_kept(&shapes, Formulation::FBar, [[0.49, 0.87], [0.57, 1.0], [0.62, 1.0], [0.73, 1.0]]);
    assert_kept(&shapes, Formulation::BBar, [[0.49, 0.87], [0.57, 1.0], [0.64, 1.0], [0.73, 1.0]]);
}

#[test]
fn bound_is_exact_for_cubes_and_where_nu_is_zero_and_close_for_bricks() {
    for formulation in FORMULATIONS {
        let share = |sides, poisson_ratio| share(&brick(sides), &elasticity(poisson_ratio), formulation);
        for poisson_ratio in [0.0, 0.3, 0.4999] {
            assert!((share([0.7; 3], poisson_ratio) - 1.0).abs() < ROUNDED_UP);
        }
        // two equal sides: the largest principal value of the metric is exact as well
        for sides in [[1.0, 1.0, 0.01], [1.0, 0.5, 0.5], [3.0, 1.0, 1.0]] {
            assert!((share(sides, 0.0) - 1.0).abs() < ROUNDED_UP);
            assert!(share(sides, 0.3) > 0.96 && share(sides, 0.4999) > 0.9999);
        }
        for sides in [[1.0, 0.1, 0.01], [1.0, 2.0, 3.0], [0.9, 1.0, 1.1]] {
            assert!(share(sides, 0.0) > 0.995 && share(sides, 0.3) > 0.96);
        }
    }
}

/// K of F-bar is not symmetric: its eigenvalues on distorted hexes are nearly, but not quite real. An eigenvalue
/// a + i b of M⁻¹K is a vibration that grows or decays by b/(2a) a radian; steps of any length show it, so the stable
/// step need not know of it. Largest imaginary part and smallest real part, in norms of the operator.
#[test]
fn eigenvalues_of_f_bar_are_not_negative_and_nearly_real() {
    for poisson_ratio in POISSON_RATIOS {
        let elasticity = elasticity(poisson_ratio);
        let (mut imaginary, mut real) = (0.0_f64, 0.0_f64);
        for shape in distorted_hexes(300, &mut Random::new(2)) {
            let operator = operator(&shape, &elasticity, Formulation::FBar);
            let norm = norm(&operator);
            for z in operator.eigenvalues().unwrap() {
                imaginary = imaginary.max(z.im / norm);
                real = real.min(z.re / norm);
            }
        }
        println!("nu = {poisson_ratio}: imaginary {imaginary:.1e}, real {real:.1e}");
        assert!(real > -1e-13 && imaginary < 5e-3, "nu = {poisson_ratio}: {imaginary} {real}");
    }
}
