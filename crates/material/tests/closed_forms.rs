//! Goal: the theories meet what can be written down about them.
//!
//! Loading: simple shear, uniaxial stress and isochoric tension at one material point. Source: de Vera 2016, chapters 6
//! and 7; Armstrong & Frederick 1966; the laws themselves.

use estar_material::point::{Control, MaterialPoint, drive, follow};
use estar_material::{
    AdiabaticHeating, ClosestPoint, EStar, EStarTotal, ElasticConstant, GreenNaghdi, GreenNaghdiState, Hencky,
    IsotropicElasticity, IsotropicHardening, JohnsonCook, JohnsonCookParameters, KinematicHardening, Material,
    PrincipalSurface,
};
use estar_tensor::{Rotation, SymmetricTensor, Tensor};

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
fn uniaxial_stress_green_naghdi_gives_the_dissertations_figures() {
    let material = GreenNaghdi::new(solid(), perfect());
    let mut last = None;
    uniaxial_stress(&material, |strain, point| {
        let GreenNaghdiState { plastic_strain, equivalent_plastic_strain, .. } = point.state();
        // S₁₁ = E E₁₁, then σ₀ from E₁₁ = σ₀/E = 0.0013 on; E_p11 = E₁₁ − σ₀/E (de Vera 2016, eq. 7.117, 7.119)
        let piola_kirchhoff = (YOUNG * strain).min(YIELD);
        assert!((second_piola_kirchhoff(point) / piola_kirchhoff - 1.0).abs() < 1e-9, "E11 = {strain}");
        assert!((plastic_strain.0[0] - (strain - 0.0013).max(0.0)).abs() < 1e-11, "E11 = {strain}");
        assert!((equivalent_plastic_strain - plastic_strain.0[0]).abs() < 1e-12);
        // T₁₁ = S₁₁ λ₁/λ₂² (eq. 7.106) with tr E = (1 − 2ν) S₁₁/E (eq. 7.121, 7.122)
        let trace = (1.0 - 2.0 * POISSON) * piola_kirchhoff / YOUNG;
        let stretch = (1.0 + 2.0 * strain).sqrt();
        let cauchy = piola_kirchhoff * stretch / (1.0 + trace - strain);
        assert!((point.stress().0[0] / cauchy - 1.0).abs() < 1e-9, "E11 = {strain}");
        last = Some((point.stress().0[0], plastic_strain.0[0]));
    });
    let (cauchy, plastic) = last.unwrap();
    assert!((cauchy - 384.3e6).abs() < 5e4, "{cauchy}");
    assert!((plastic - 0.1987).abs() < 5e-7, "{plastic}");
    // λ_p = √(1 + 2 (γ₁₁ − γ₁₁(t₀))) (eq. 7.120) and E*₁₁ = (E₁₁ − E_p11)/λ_p² (eq. 7.123), printed as 0.00093
    let plastic_stretch = (1.0 + 2.0 * plastic).sqrt();
    let elastic = (0.2 - plastic) / plastic_stretch.powi(2);
    assert!((elastic - 0.00093).abs() < 5e-6, "{elastic}");
    assert!((elastic / (0.0013 / 1.3974) - 1.0).abs() < 1e-8, "{elastic}");
}

/// A bar of the Green-Naghdi theory is pressed to an eighth of its length: the force on it falls as the length does, and the
/// work is bounded by σ₀/2 a volume, however far it is pressed. Of the E* theory the force grows and the work has no bound.
#[test]
fn a_green_naghdi_bar_is_pressed_to_nothing_by_finite_work() {
    /// Work per volume and force per area, both undeformed, at stretches that halve.
    fn pressed<M: Material>(material: &M) -> Vec<[f64; 2]> {
        let times: Vec<f64> = (0..=3000).map(|step| f64::from(step) * 1e-3).collect();
        let mut seen = Vec::new();
        let halving = |t: f64| Control::uniaxial_stress(0.5_f64.powf(t));
        follow(material, halving, &times, |time, point| {
            if time.fract() == 0.0 {
                let gradient = point.deformation_gradient();
                let force = point.stress().0[0] * gradient.determinant() / gradient.at(0, 0);
                seen.push([point.internal_energy(), force]);
            }
        })
        .unwrap();
        seen
    }
    let elastic = 0.5 * YIELD * YIELD / YOUNG;
    for (halvings, [work, force]) in (1..).zip(pressed(&GreenNaghdi::new(solid(), perfect()))) {
        // S₁₁ = −σ₀, and dW = S₁₁ dE₁₁
        let stretch = 0.5_f64.powi(halvings);
        let exact = 0.5 * YIELD * (1.0 - stretch * stretch) - elastic;
        // half of the stress of the step in which it yields is open
        assert!((work - exact).abs() < 0.5 * YIELD * 0.001 * 2_f64.ln(), "{halvings}: {work} {exact}");
        assert!((force / (-YIELD * stretch) - 1.0).abs() < 1e-9, "{halvings}: {force}");
    }
    for (halvings, [work, force]) in (1..).zip(pressed(&EStarTotal::new(solid(), perfect()))) {
        assert!(work > 0.99 * YIELD * f64::from(halvings) * 2_f64.ln(), "{halvings}: {work}");
        assert!(force < -0.99 * YIELD * 2_f64.powi(halvings), "{halvings}: {force}");
    }
}

#[test]
fn uniaxial_stress_hencky_yields_at_the_kirchhoff_stress() {
    fn claim<S: PrincipalSurface>(strain: f64, point: &MaterialPoint<'_, Hencky<S>>, keeps_volume: bool) {
        let logarithmic = 0.5 * (2.0 * strain).ln_1p();
        // τ₁₁ = E ε₁₁, then σ₀; ε̄ᵖ = ln λ₁ − σ₀/E
        let kirchhoff = (YOUNG * logarithmic).min(YIELD);
        let jacobian = point.deformation_gradient().determinant();
        assert!((jacobian * point.stress().0[0] / kirchhoff - 1.0).abs() < 1e-9, "E11 = {strain}");
        let plastic = (logarithmic - YIELD / YOUNG).max(0.0);
        assert!((point.equivalent_plastic_strain() - plastic).abs() < 1e-11, "E11 = {strain}");
        // ln J = (1 − 2ν) τ₁₁/E, and for Rankine the opening: only the largest principal strain flows
        let opening = if keeps_volume { 0.0 } else { plastic };
        let volume = (1.0 - 2.0 * POISSON) * kirchhoff / YOUNG + opening;
        assert!((jacobian.ln() - volume).abs() < 1e-11, "E11 = {strain}");
    }
    uniaxial_stress(&Hencky::von_mises(solid(), perfect()), |strain, point| claim(strain, point, true));
    uniaxial_stress(&Hencky::rankine(solid(), perfect()), |strain, point| claim(strain, point, false));
}

/// Soils that are pulled and pressed with free sides: the Kirchhoff stress is the strength, and the volume grows with the
/// plastic length as the normal of the flow says.
#[test]
fn uniaxial_stress_of_soils_is_their_strength_and_they_open() {
    /// Perfect flow at `strength` in the direction `sign`, whose volume grows by `opening` for each plastic length.
    fn claim(surface: ClosestPoint, sign: f64, strength: f64, opening: f64) {
        for steps in [50, 2000] {
            let times: Vec<f64> = (0..=steps).map(|step| f64::from(step) / f64::from(steps)).collect();
            let material = Hencky::closest_point(surface);
            let control = |t: f64| Control::uniaxial_stress((0.1 * sign * t).exp());
            let point = follow(&material, control, &times, |_, _| {}).unwrap();
            let jacobian = point.deformation_gradient().determinant();
            let kirchhoff = jacobian * point.stress().0[0];
            assert!((kirchhoff / (sign * strength) - 1.0).abs() < 1e-9, "{sign} {steps}: {kirchhoff} {strength}");
            let plastic = 0.1 * sign - kirchhoff / YOUNG;
            let volume = (1.0 - 2.0 * POISSON) * kirchhoff / YOUNG + opening * plastic;
            assert!((jacobian.ln() - volume).abs() < 1e-9, "{sign} {steps}: {} {volume}", jacobian.ln());
        }
    }
    let cohesion = 1e6;
    for angle in [10.0_f64, 30.0, 45.0].map(f64::to_radians) {
        let (sine, cosine) = (angle.sin(), angle.cos());
        let surface = ClosestPoint::mohr_coulomb(solid(), angle, cohesion).unwrap();
        claim(surface, 1.0, 2.0 * cohesion * cosine / (1.0 + sine), 2.0 * sine / (1.0 + sine));
        claim(surface, -1.0, 2.0 * cohesion * cosine / (1.0 - sine), -2.0 * sine / (1.0 - sine));
        // √(½) ‖dev τ‖ + α tr τ = κ, flow by α_ψ
        let slope = |angle: f64| 2.0 * angle.sin() / (3.0_f64.sqrt() * (3.0 - angle.sin()));
        let bound = 6.0 * cohesion * cosine / (3.0_f64.sqrt() * (3.0 - sine));
        for dilatancy in [0.0, 0.3 * angle, angle] {
            let surface = ClosestPoint::drucker_prager(solid(), angle, cohesion, dilatancy).unwrap();
            let (shear, alpha) = (3.0_f64.sqrt().recip(), slope(dilatancy));
            for sign in [1.0, -1.0] {
                let strength = bound / (shear + sign * slope(angle));
                claim(surface, sign, strength, 3.0 * alpha / (sign * shear + alpha));
            }
        }
    }
}

/// Trial Hencky strains ε₁ ≥ ε₂ ≥ ε₃ on a grid, up to ten times the strain of first yield.
fn trial_strains() -> impl Iterator<Item = [f64; 3]> {
    let grid = |i: i32| 1e-3 * f64::from(i);
    (-13..=13).flat_map(move |i| (-13..=i).flat_map(move |j| (-13..=j).map(move |k| [grid(i), grid(j), grid(k)])))
}

/// The principal Hencky strains after one step from rest to the principal strains `trial` on turned axes.
fn returned<S: PrincipalSurface>(material: &Hencky<S>, trial: [f64; 3]) -> [f64; 3] {
    let axes = Rotation::<f64>::about([0.2, 0.7, -0.4], 0.8).to_tensor();
    let target = SymmetricTensor::diagonal(trial.map(f64::exp)).pushed_by(&axes).to_tensor();
    let mut point = MaterialPoint::new(material);
    point.advance(&target, 1.0);
    // ε = C⁻¹ τ, on the axes of the trial
    let kirchhoff = (*point.stress() * target.determinant()).pulled_by(&axes).0;
    let lateral = |i: usize| kirchhoff[0] + kirchhoff[1] + kirchhoff[2] - kirchhoff[i];
    assert!(kirchhoff[3..].iter().all(|shear| shear.abs() < 1e-14 * YOUNG), "{kirchhoff:?}");
    [0, 1, 2].map(|i| (kirchhoff[i] - POISSON * lateral(i)) / YOUNG)
}

#[test]
fn rankine_return_is_that_of_the_four_branches() {
    // "Supplementary notes on return mapping", section 1, with τ_C = σ₀
    let (mu, lambda) = (solid().shear_modulus(), solid().lame_lambda());
    let projection = |[e1, e2, e3]: [f64; 3]| {
        let sum = e1 + e2 + e3;
        if lambda * sum + 2.0 * mu * e1 <= YIELD {
            (0, [e1, e2, e3])
        } else if (2.0 * mu + lambda) * e2 + lambda * (sum - e1) <= YIELD {
            (1, [(YIELD - lambda * (sum - e1)) / (2.0 * mu + lambda), e2, e3])
        } else if (2.0 * mu + 3.0 * lambda) * e3 <= YIELD {
            let both = (YIELD - lambda * e3) / (2.0 * mu + 2.0 * lambda);
            (2, [both, both, e3])
        } else {
            (3, [YIELD / (2.0 * mu + 3.0 * lambda); 3])
        }
    };
    let material = Hencky::rankine(solid(), perfect());
    let mut count = [0; 4];
    for trial in trial_strains() {
        let (branch, expected) = projection(trial);
        count[branch] += 1;
        let found = returned(&material, trial);
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 2e-15, "{trial:?}, branch {branch}: {found} {expected}");
        }
    }
    assert!(count.iter().all(|count| *count > 50), "{count:?}");
}

#[test]
fn rankine_with_hardening_cuts_at_the_flow_stress_of_its_opening() {
    let law = IsotropicHardening::saturation(YIELD, 2.0 * YIELD, 300.0, 1e9).unwrap();
    let material = Hencky::rankine(solid(), law.clone());
    let linear = IsotropicHardening::linear(YIELD, 1e9).unwrap();
    let table = IsotropicHardening::tabulated(&[[0.0, YIELD], [1.0, YIELD + 1e9]]).unwrap();
    let [linear, table] = [linear, table].map(|law| Hencky::rankine(solid(), law));
    for trial in trial_strains() {
        let [e1, e2, e3] = returned(&material, trial);
        let opening = (trial[0] - e1) + (trial[1] - e2) + (trial[2] - e3);
        if opening > 1e-9 {
            let cut = solid().principal_stress([e1, e2, e3])[0];
            assert!((cut / law.at(opening).stress - 1.0).abs() < 1e-11, "{trial:?}");
        }
        // the closed form of a straight law and the iteration
        let (one, other) = (returned(&linear, trial), returned(&table, trial));
        assert!(one.iter().zip(other).all(|(one, other)| (one - other).abs() < 2e-15), "{trial:?}");
    }
}

#[test]
fn von_mises_return_scales_the_deviator() {
    // "Supplementary notes on return mapping", section 1, with the deviator τ̂ − ⅓ (1·τ̂) 1 and τ_C = √⅔ σ₀
    let material = Hencky::von_mises(solid(), perfect());
    for trial in trial_strains() {
        let stress = solid().principal_stress(trial);
        let mean = stress.iter().sum::<f64>() / 3.0;
        let norm = stress.iter().map(|stress| (stress - mean).powi(2)).sum::<f64>().sqrt();
        let scale = ((2.0_f64 / 3.0).sqrt() * YIELD / norm).min(1.0);
        let found = solid().principal_stress(returned(&material, trial));
        for (found, stress) in found.iter().zip(stress) {
            assert!((found - (mean + scale * (stress - mean))).abs() < 1e-14 * YOUNG, "{trial:?}");
        }
    }
}

#[test]
fn hencky_dissipation_is_that_of_the_lie_derivative() {
    // −½ τ : (L_v b_e b_e⁻¹), L_v b_e = F (dC_p⁻¹/dt) Fᵀ ("Supplementary notes on return mapping", eq. 10 and 27)
    fn claim<S: PrincipalSurface>(material: &Hencky<S>) {
        let error = |steps: u32| {
            let mut old = MaterialPoint::new(material).state().inverse_plastic_metric;
            let mut sum = 0.0;
            let point = drive(material, simple_shear, 0.5, steps, |_, point| {
                let gradient = point.deformation_gradient();
                let metric = point.state().inverse_plastic_metric;
                let lie = (metric - old).pushed_by(gradient).to_tensor();
                let inverse = metric.pushed_by(gradient).to_tensor().inverse();
                let kirchhoff = (*point.stress() * gradient.determinant()).to_tensor();
                sum -= 0.5 * kirchhoff.dot(&lie.dot(&inverse)).trace();
                old = metric;
            });
            assert!(sum > 0.0);
            sum / point.plastic_dissipation() - 1.0
        };
        let errors = [500, 1000, 2000].map(error);
        assert!((errors[1] / errors[2]).log2() > 0.95, "{errors:?}");
    }
    claim(&Hencky::von_mises(solid(), perfect()));
    claim(&Hencky::rankine(solid(), perfect()));
    claim(&Hencky::closest_point(ClosestPoint::drucker_prager(solid(), 0.5, YIELD, 0.2).unwrap()));
    claim(&Hencky::closest_point(ClosestPoint::mohr_coulomb(solid(), 0.5, YIELD).unwrap()));
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
            let value = law.at(strain).stress;
            assert!((value / formula(strain) - 1.0).abs() < 1e-14, "{law:?} at {strain}: {value}");
        }
        // away from the corners of the table
        for strain in [1e-3, 0.02, 0.15, 0.7] {
            let half = 1e-6;
            let difference = (formula(strain + half) - formula(strain - half)) / (2.0 * half);
            let slope = law.at(strain).slope;
            assert!((slope - difference).abs() < 1e-6 * difference.abs() + 100.0, "{law:?} at {strain}: {slope}");
        }
    }
}

#[test]
fn ludwik_starts_at_the_yield_stress_and_never_falls() {
    for exponent in [0.01, 0.1, 0.5, 1.0] {
        let law = IsotropicHardening::ludwik(100e6, 500e6, exponent).unwrap();
        assert_eq!(law.at(0.0).stress, 100e6);
        let mut last = 100e6;
        for decade in -160..=10 {
            let flow = law.at(10_f64.powf(0.1 * f64::from(decade)));
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
            let error = von_mises(point.stress()) / law.at(strain).stress - 1.0;
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
    [state.equivalent_plastic_strain, von_mises(&state.back_stress.rotated_back_stress), von_mises(point.stress())]
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
fn e_star_heats_by_the_volume_more_than_theories_whose_kirchhoff_stress_yields() {
    // a constant flow stress, heated by all of the dissipation
    let parameters = JohnsonCookParameters {
        a: YIELD,
        b: 0.0,
        n: 1.0,
        c: 0.0,
        m: 1.0,
        reference_rate: 1.0,
        reference_temperature: 1e6,
        melting_temperature: 2e6,
    };
    let heating = AdiabaticHeating { specific_heat: 460.0, taylor_quinney: 1.0, initial_temperature: 0.0 };
    let law = JohnsonCook::new(parameters).unwrap().with_heating(heating, &solid()).unwrap();
    fn heated<M: Material>(material: &M, control: fn(f64) -> Control, stretch: f64) -> [f64; 2] {
        let times: Vec<f64> = (0..=4000).map(|step| f64::from(step) / 4000.0).collect();
        let path = |time: f64| control(1.0 + (stretch - 1.0) * time);
        let point = follow(material, path, &times, |_, _| ()).unwrap();
        [point.observation().temperature.unwrap(), point.deformation_gradient().determinant()]
    }
    let of = |control: fn(f64) -> Control, stretch: f64| {
        let [rate, _] = heated(&EStar::new(solid(), law.clone(), ()), control, stretch);
        let [total, volume] = heated(&EStarTotal::new(solid(), law.clone()), control, stretch);
        let [hencky, _] = heated(&Hencky::von_mises(solid(), law.clone()), control, stretch);
        [rate / hencky, total / hencky, volume]
    };
    // uniaxial strain: Δε̄ᵖ = ⅔ d ln J all the way, so that ∫ J dε̄ᵖ is (J − 1)/ln J times ∫ dε̄ᵖ
    let [rate, total, volume] = of(Control::uniaxial_strain, 2.0);
    assert_eq!(volume, 2.0);
    assert!((rate * 2_f64.ln() - 1.0).abs() < 3e-3 && (total * 2_f64.ln() - 1.0).abs() < 3e-3, "{rate} {total}");
    // tension: J stays what the elastic strain makes it, e^{(1 − 2ν) σ/E}; the strain at yield differs by (σ/E)²
    let [rate, total, volume] = of(Control::uniaxial_stress, 2.0);
    let tolerance = 2.0 * (YIELD / YOUNG).powi(2) / 2_f64.ln();
    assert!([rate, total].iter().all(|ratio| (ratio / volume - 1.0).abs() < tolerance), "{rate} {total} {volume}");
}

/// Perfect plasticity of 200 MPa with a back stress that saturates at C/γ = 200 MPa.
fn saturating() -> EStar<KinematicHardening, IsotropicHardening> {
    let constants = (ElasticConstant::YoungModulus(YOUNG), ElasticConstant::PoissonRatio(0.3));
    let solid = IsotropicElasticity::new(7850.0, constants.0, constants.1).unwrap();
    let rule = KinematicHardening::armstrong_frederick(40e9, 200.0).unwrap();
    EStar::new(solid, IsotropicHardening::perfect(200e6).unwrap(), rule)
}

#[test]
fn a_saturated_back_stress_dissipates_all_work() {
    // p = Δε̄ᵖ to ln λ = 1: σ₀ p + (C/γ) (p − 2 (1 − e^{−γp})/γ + (1 − e^{−2γp})/2γ), 3.98·10⁸ J/m³
    let (stress, recovery, p) = (200e6, 200.0_f64, 1.0 - 400e6 / YOUNG);
    let fading = |factor: f64| (1.0 - (-factor * recovery * p).exp()) / (factor * recovery);
    let dissipation = stress * p + stress * (p - 2.0 * fading(1.0) + fading(2.0));
    let times: Vec<f64> = (0..=5000).map(|step| f64::from(step) / 5000.0).collect();
    let material = saturating();
    let point = follow(&material, |time| Control::uniaxial_stress(time.exp()), &times, |_, _| ()).unwrap();
    // J = e^{(1 − 2ν) σ/E}
    let volume = (0.4 * 400e6 / YOUNG).exp();
    let found = point.plastic_dissipation() / (volume * dissipation) - 1.0;
    assert!((dissipation / 3.98e8 - 1.0).abs() < 1e-3 && found.abs() < 1e-4, "{dissipation:e} {found}");
    // what is left of the work is stored: σ²/2E and α²/2C of the uniaxial α = C/γ
    let stored = point.internal_energy() - point.plastic_dissipation();
    let expected = volume * (0.5 * 400e6_f64.powi(2) / YOUNG + 0.5 * stress.powi(2) / 40e9);
    assert!((stored / expected - 1.0).abs() < 2e-3, "{stored:e} {expected:e}");
}

#[test]
fn a_stable_closed_cycle_dissipates_all_its_work() {
    // between ln λ = ±0.02: plastic strain Δ = 0.04 − 2 (σ₀ + α)/E a half cycle, α = (C/γ) tanh ½γΔ, and the work of a
    // cycle is 2 ((σ₀ + C/γ) Δ − 2 α/γ), 2.480·10⁷ J/m³
    let mut alpha: f64 = 200e6;
    let plastic = |alpha: f64| 0.04 - 2.0 * (200e6 + alpha) / YOUNG;
    for _ in 0..50 {
        alpha = 200e6 * (100.0 * plastic(alpha)).tanh();
    }
    let work = 2.0 * (400e6 * plastic(alpha) - 2.0 * alpha / 200.0);
    assert!((work / 2.480e7 - 1.0).abs() < 1e-3, "{work:e}");
    // to 0.02, then back and forth in 2 s each
    let strain = |time: f64| 0.02 * if time < 1.0 { time } else { ((time - 1.0) % 4.0 - 2.0).abs() - 1.0 };
    let times: Vec<f64> = (0..=21_000).map(|step| f64::from(step) * 1e-3).collect();
    let material = saturating();
    let mut energies = Vec::new();
    follow(
        &material,
        |time| Control::uniaxial_stress(strain(time).exp()),
        &times,
        |_, point| {
            energies.push([point.internal_energy(), point.plastic_dissipation()]);
        },
    )
    .unwrap();
    // from the fifth peak to the sixth
    let [input, dissipated] = [0, 1].map(|index| energies[20_999][index] - energies[16_999][index]);
    assert!((dissipated / input - 1.0).abs() < 1e-6, "{input:e} {dissipated:e}");
    assert!((input / work - 1.0).abs() < 2e-3, "{input:e} {work:e}");
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
