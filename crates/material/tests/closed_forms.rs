//! Goal: the theories meet what can be written down about them.
//!
//! Loading: simple shear, uniaxial stress and isochoric tension at one material point. Source: de Vera 2016, chapters 6
//! and 7; Armstrong & Frederick 1966; the laws themselves.

use estar_material::point::{Control, MaterialPoint, drive, follow};
use estar_material::{
    EStar, EStarTotal, ElasticConstant, IsotropicElasticity, IsotropicHardening, KinematicHardening, Material,
};
use estar_tensor::{SymmetricTensor, Tensor};

const YOUNG: f64 = 200e9;
const POISSON: f64 = 0.32;
/// de Vera 2016, section 7.5 (printed there as 260 GPa).
const YIELD: f64 = 260e6;

fn solid() -> IsotropicElasticity {
    let constants = (ElasticConstant::YoungModulus(YOUNG), ElasticConstant::PoissonRatio(POISSON));
    IsotropicElasticity::new(7850.0, constants.0, constants.1).unwrap()
}

fn perfect() -> IsotropicHardening {
    IsotropicHardening::perfect(YIELD).unwrap()
}

fn simple_shear(gamma: f64) -> Tensor<f64> {
    Tensor::from_rows([[1.0, gamma, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
}

fn isochoric_tension(stretch: f64) -> Tensor<f64> {
    let lateral = stretch.sqrt().recip();
    Tensor::from_rows([[stretch, 0.0, 0.0], [0.0, lateral, 0.0], [0.0, 0.0, lateral]])
}

fn von_mises(stress: &SymmetricTensor<f64>) -> f64 {
    (1.5 * stress.deviator().norm_squared()).sqrt()
}

/// Uniaxial stress to E₁₁ = 0.2 in 400 steps; `visit` sees E₁₁ and the point.
fn uniaxial_stress<M: Material>(material: &M, visit: impl FnMut(f64, &MaterialPoint<'_, M>)) {
    let strains: Vec<f64> = (0..=400).map(|step| 0.2 * f64::from(step) / 400.0).collect();
    follow(material, |strain| Control::uniaxial_stress((1.0 + 2.0 * strain).sqrt()), &strains, visit).unwrap();
}

/// S₁₁ = J F₁₁⁻² T₁₁.
fn second_piola_kirchhoff<M: Material>(point: &MaterialPoint<'_, M>) -> f64 {
    let gradient = point.deformation_gradient();
    gradient.determinant() * point.stress().0[0] / gradient.at(0, 0).powi(2)
}

#[test]
fn uniaxial_stress_total_gives_the_dissertations_figures() {
    let material = EStarTotal::new(solid(), perfect());
    let mut last = None;
    uniaxial_stress(&material, |strain, point| {
        // constant from E₁₁ = σ₀/E = 0.0013 on
        if strain > YIELD / YOUNG {
            assert!((point.stress().0[0] / YIELD - 1.0).abs() < 1e-10, "E11 = {strain}");
            // E* = ½ (F² C_p⁻¹ − I), E_p = ½ (C_p − I) on the axis
            let inverse_metric = point.state().inverse_plastic_metric.0[0];
            let elastic = 0.5 * ((1.0 + 2.0 * strain) * inverse_metric - 1.0);
            assert!((elastic - 0.0013).abs() < 1e-12, "{elastic}");
            last = Some((0.5 * (inverse_metric.recip() - 1.0), second_piola_kirchhoff(point)));
        } else {
            assert!((point.stress().0[0] / (YOUNG * strain) - 1.0).abs() < 1e-10, "E11 = {strain}");
        }
    });
    let (plastic, piola_kirchhoff) = last.unwrap();
    // λ_p = λ/λ(t₀) (de Vera 2016, eq. 7.99)
    assert!((plastic - 0.5 * (1.4 / 1.0026 - 1.0)).abs() < 1e-12);
    assert!((plastic - 0.1982).abs() < 5e-5, "{plastic}");
    assert!((piola_kirchhoff - 185.8e6).abs() < 5e4, "{piola_kirchhoff}");
    // J² = (1 + 2 E*₁₁)(1 − 2 ν E*₁₁)²
    let jacobian = 1.0026_f64.sqrt() * (1.0 - 2.0 * POISSON * 0.0013);
    assert!((piola_kirchhoff / (jacobian * YIELD / 1.4) - 1.0).abs() < 1e-10);
}

#[test]
fn uniaxial_stress_box_rate_gives_the_dissertations_figures() {
    let material = EStar::new(solid(), perfect(), ());
    let mut last = None;
    uniaxial_stress(&material, |strain, point| {
        let stress = point.stress().0[0];
        // here the elastic strain is logarithmic: yield at ½ (e^{2 σ₀/E} − 1) = 0.0013017
        if strain > 0.5 * (2.0 * YIELD / YOUNG).exp_m1() {
            assert!((stress / YIELD - 1.0).abs() < 1e-10, "E11 = {strain}");
        } else {
            assert!((stress / (YOUNG * 0.5 * (2.0 * strain).ln_1p()) - 1.0).abs() < 1e-6, "E11 = {strain}");
        }
        // E* = T/E on the axis, E_p = ½ (λ²/(1 + 2 E*) − 1)
        let elastic = stress / YOUNG;
        last =
            Some((elastic, 0.5 * ((1.0 + 2.0 * strain) / (1.0 + 2.0 * elastic) - 1.0), second_piola_kirchhoff(point)));
        // ε̄ᵖ = ln λ − T/E
        let plastic = point.equivalent_plastic_strain();
        assert!((plastic - (0.5 * (2.0 * strain).ln_1p() - elastic)).abs() < 1e-6, "E11 = {strain}: {plastic}");
    });
    let (elastic, plastic, piola_kirchhoff) = last.unwrap();
    assert!((elastic - 0.0013).abs() < 1e-12);
    assert!((plastic - 0.1982).abs() < 5e-5, "{plastic}");
    assert!((piola_kirchhoff - 185.8e6).abs() < 5e4, "{piola_kirchhoff}");
}

#[test]
fn hardening_laws_have_the_values_of_their_formulas() {
    let table = [[0.0, 200e6], [0.1, 300e6], [0.3, 350e6]];
    type Formula = fn(f64) -> f64;
    let laws: [(IsotropicHardening, Formula); 7] = [
        (IsotropicHardening::perfect(200e6).unwrap(), |_| 200e6),
        (IsotropicHardening::linear(400e6, 100e6).unwrap(), |e| 400e6 + 100e6 * e),
        (IsotropicHardening::voce(200e6, 350e6, 12.0).unwrap(), |e| 200e6 + 150e6 * (1.0 - (-12.0 * e).exp())),
        // Simo's necking bar
        (IsotropicHardening::saturation(450e6, 715e6, 16.93, 129.24e6).unwrap(), |e| {
            450e6 + 265e6 * (1.0 - (-16.93 * e).exp()) + 129.24e6 * e
        }),
        (IsotropicHardening::ludwik(90e6, 292e6, 0.31).unwrap(), |e| 90e6 + 292e6 * e.powf(0.31)),
        (IsotropicHardening::swift(500e6, 0.002, 0.2).unwrap(), |e| 500e6 * (0.002 + e).powf(0.2)),
        (IsotropicHardening::tabulated(&table).unwrap(), |e| match e {
            e if e < 0.1 => 200e6 + 1e9 * e,
            e if e < 0.3 => 300e6 + 250e6 * (e - 0.1),
            _ => 350e6,
        }),
    ];
    for (law, formula) in laws {
        for strain in [0.0, 1e-9, 1e-4, 0.02, 0.0999, 0.1, 0.15, 0.3, 1.0, 10.0] {
            let value = law.flow_stress(strain).stress;
            assert!((value / formula(strain) - 1.0).abs() < 1e-14, "{law:?} at {strain}: {value}");
        }
        // away from the corners of the table
        for strain in [1e-3, 0.02, 0.15, 0.7] {
            let half = 1e-6;
            let difference = (formula(strain + half) - formula(strain - half)) / (2.0 * half);
            let slope = law.flow_stress(strain).slope;
            assert!((slope - difference).abs() < 1e-6 * difference.abs() + 100.0, "{law:?} at {strain}: {slope}");
        }
    }
}

#[test]
fn ludwik_starts_at_the_yield_stress_and_never_falls() {
    for exponent in [0.01, 0.1, 0.5, 1.0] {
        let law = IsotropicHardening::ludwik(100e6, 500e6, exponent).unwrap();
        assert_eq!(law.flow_stress(0.0).stress, 100e6);
        let mut last = 100e6;
        for decade in -160..=10 {
            let flow = law.flow_stress(10_f64.powf(0.1 * f64::from(decade)));
            assert!(flow.stress > last && flow.slope > 0.0 && flow.slope.is_finite(), "{exponent} {decade}");
            last = flow.stress;
        }
    }
}

#[test]
fn ludwik_yields_from_zero_strain_whatever_its_exponent() {
    // the first step ends inside and outside of the straight start of the law
    for exponent in [0.01, 0.05, 0.3, 0.9] {
        for excess in [1e-12, 1e-6, 1e-3, 0.1, 10.0] {
            let law = IsotropicHardening::ludwik(YIELD, 400e6, exponent).unwrap();
            let material = EStar::new(solid(), law.clone(), ());
            let mut point = MaterialPoint::new(&material);
            let gamma = YIELD * (1.0 + excess) / (3_f64.sqrt() * solid().shear_modulus());
            point.advance(&simple_shear(gamma), 1.0);
            let strain = point.equivalent_plastic_strain();
            let error = von_mises(point.stress()) / law.flow_stress(strain).stress - 1.0;
            assert!(strain > 0.0 && error.abs() < 1e-12, "n = {exponent}, excess {excess}: ε̄ᵖ = {strain}, {error}");
        }
    }
}

#[test]
fn a_table_of_a_linear_law_is_that_law() {
    let linear = IsotropicHardening::linear(YIELD, 1e9).unwrap();
    let points = [0.0, 0.003, 0.05, 0.2, 3.0].map(|strain| [strain, YIELD + 1e9 * strain]);
    let table = IsotropicHardening::tabulated(&points).unwrap();
    for path in [simple_shear as fn(f64) -> Tensor<f64>, |t| isochoric_tension(1.0 + t)] {
        let materials = [&linear, &table].map(|law| EStar::new(solid(), law.clone(), ()));
        let [one, other] = materials.each_ref().map(|material| drive(material, path, 1.0, 200, |_, _| ()));
        assert!((*one.stress() - *other.stress()).norm_squared().sqrt() < 1e-11 * YIELD);
        assert!((one.equivalent_plastic_strain() - other.equivalent_plastic_strain()).abs() < 1e-13);
        assert!(one.equivalent_plastic_strain() > 0.3);
    }
}

/// Isochoric tension to the stretch `end`: ε̄ᵖ, the uniaxial back stress X = √(3/2) ‖α‖ and the von Mises stress.
fn kinematic_tension(rule: KinematicHardening, end: f64, steps: u32) -> [f64; 3] {
    let material = EStar::new(solid(), perfect(), rule);
    let point = drive(&material, |t| isochoric_tension((end.ln() * t).exp()), 1.0, steps, |_, _| ());
    let state = point.state();
    [state.equivalent_plastic_strain, von_mises(&state.rotated_back_stress), von_mises(point.stress())]
}

#[test]
fn prager_moves_the_surface_in_proportion_to_the_plastic_strain() {
    let rule = KinematicHardening::prager(3e9).unwrap();
    for steps in [3, 200] {
        let [strain, back_stress, stress] = kinematic_tension(rule, 1.2, steps);
        assert!(strain > 0.17);
        // X = C ε̄ᵖ, T₁₁ − T₂₂ = σ₀ + X
        assert!((back_stress / (3e9 * strain) - 1.0).abs() < 1e-12);
        assert!((stress / (YIELD + back_stress) - 1.0).abs() < 1e-12);
    }
}

#[test]
fn armstrong_frederick_follows_its_exponential_and_saturates() {
    let (modulus, recovery) = (20e9, 80.0);
    let rule = KinematicHardening::armstrong_frederick(modulus, recovery).unwrap();
    // X = C/γ (1 − e^{−γ ε̄ᵖ}); backward Euler meets it at first order
    let error = |steps| {
        let [strain, back_stress, _] = kinematic_tension(rule, 1.02, steps);
        back_stress * recovery / modulus / -(-recovery * strain).exp_m1() - 1.0
    };
    let errors = [1000, 2000, 4000].map(error);
    assert!((errors[1] / errors[2]).log2() > 0.98 && (errors[1] / errors[2]).log2() < 1.02, "{errors:?}");
    assert!(errors[2].abs() < 1e-3);
    // without its first-order part
    assert!((2.0 * errors[2] - errors[1]).abs() < 1e-6, "{errors:?}");

    let [_, back_stress, stress] = kinematic_tension(rule, 1.6, 500);
    assert!((back_stress / (modulus / recovery) - 1.0).abs() < 1e-9);
    assert!((stress / (YIELD + modulus / recovery) - 1.0).abs() < 1e-9);
}

#[test]
fn prager_yields_in_reverse_two_yield_stresses_below() {
    let material = EStar::new(solid(), perfect(), KinematicHardening::prager(10e9).unwrap());
    let path = |t: f64| isochoric_tension(1.0 + 0.02 * (1.0 - (t - 1.0).abs()));
    // T₁₁ − T₂₂ and ε̄ᵖ where the load turns, and the first stress after it at which plastic strain grows
    let mut turn = (0.0, 0.0);
    let mut reverse = None;
    drive(&material, path, 2.0, 20_000, |time, point| {
        let difference = point.stress().0[0] - point.stress().0[1];
        let strain = point.equivalent_plastic_strain();
        if time <= 1.0 {
            turn = (difference, strain);
        } else if strain > turn.1 && reverse.is_none() {
            reverse = Some(difference);
        }
    });
    let fallen = turn.0 - reverse.unwrap();
    // a step moves the stress by 3μ Δε = 0.45 MPa
    assert!((fallen - 2.0 * YIELD).abs() < 0.5e6, "{fallen}");
}

#[test]
fn box_rate_and_total_differ_by_the_elastic_strain() {
    // simple shear to γ = 1 of solids that yield at half the stress each time: half the elastic strain, half the gap
    let gap = |scale: f64| {
        let law = IsotropicHardening::perfect(YIELD * scale).unwrap();
        let (rate, total) = (EStar::new(solid(), law.clone(), ()), EStarTotal::new(solid(), law));
        let rate = drive(&rate, simple_shear, 1.0, 8000, |_, _| ());
        let total = drive(&total, simple_shear, 1.0, 8000, |_, _| ());
        (*rate.stress() - *total.stress()).norm_squared().sqrt() / von_mises(total.stress())
    };
    let gaps = [4.0, 2.0, 1.0, 0.5].map(gap);
    for pair in gaps.windows(2) {
        assert!((pair[0] / pair[1] - 2.0).abs() < 0.01, "{gaps:?}");
    }
    // σ₀/E = 0.0013
    assert!(gaps[2] < 2.0 * YIELD / YOUNG, "{gaps:?}");
}
