//! Goal: elasticity in rate form meets the closed forms of simple shear with every objective rate, and the rates are
//! related as they must be.
//!
//! Loading: simple shear to γ = 10, spin, uniaxial stretch at one material point. Source: de Vera 2016, section 6.5; Xiao,
//! Bruhns & Meyers 1997; Dienes 1979 for the box rate.

use estar_material::point::{Control, drive, follow};
use estar_material::{Elastic, ElasticConstant, Hypoelastic, IsotropicElasticity, Material, ObjectiveRate, Turning};
use estar_tensor::{Rotation, SymmetricTensor, Tensor, polar_rotation};

/// μ = 1 Pa, ν = 0.3.
fn solid() -> IsotropicElasticity {
    let constants = [ElasticConstant::ShearModulus(1.0), ElasticConstant::PoissonRatio(0.3)];
    IsotropicElasticity::new(1.0, constants[0], constants[1]).unwrap()
}

fn simple_shear(gamma: f64) -> Tensor<f64> {
    Tensor::from_rows([[1.0, gamma, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
}

/// T₁₂, T₁₁ and T₂₂ over μ in simple shear.
fn closed_form(rate: ObjectiveRate, gamma: f64) -> [f64; 3] {
    match rate {
        ObjectiveRate::Box => {
            // tan β = γ/2
            let beta = (0.5 * gamma).atan();
            let (sine, cosine) = (2.0 * beta).sin_cos();
            let logarithm = beta.cos().ln();
            let shear = 2.0 * (cosine * (2.0 * beta - beta.tan()) - 2.0 * sine * logarithm);
            let normal = 4.0 * (cosine * logarithm + beta * sine - beta.sin().powi(2));
            [shear, normal, -normal]
        }
        ObjectiveRate::Jaumann => [gamma.sin(), 1.0 - gamma.cos(), gamma.cos() - 1.0],
        ObjectiveRate::Truesdell | ObjectiveRate::UpperConvected => [gamma, gamma * gamma, 0.0],
        ObjectiveRate::LowerConvected => [gamma, 0.0, -gamma * gamma],
        ObjectiveRate::Logarithmic => {
            // T = 2μ ln V, the principal values of ln V being ±asinh ½γ
            let half = 0.5 * gamma;
            let logarithm = 2.0 * half.asinh() / half.hypot(1.0);
            [logarithm, half * logarithm, -half * logarithm]
        }
    }
}

#[test]
fn closed_forms_have_their_published_values() {
    use ObjectiveRate::{Box, Jaumann, Logarithmic};
    // γ, T₁₂/μ, T₁₁/μ
    let known = [
        (Jaumann, [(1.0, 0.841471, 0.459698), (2.0, 0.909297, 1.416147), (5.0, -0.958924, 0.716338)]),
        (Box, [(1.0, 0.869784, 0.415900), (2.0, 1.386294, 1.141593), (5.0, 2.905369, 2.704319)]),
        (Logarithmic, [(1.0, 0.860818, 0.430409), (2.0, 1.246450, 1.246450), (5.0, 1.223533, 3.058831)]),
    ];
    for (rate, values) in known {
        for (gamma, shear, normal) in values {
            let [t12, t11, t22] = closed_form(rate, gamma);
            let error = (t12 - shear).abs().max((t11 - normal).abs());
            assert!(error < 6e-7 && t22 == -t11, "{rate:?}, γ = {gamma}: {t12} {t11}");
        }
    }
}

/// The largest error of a stress component over μ on the way to γ = 10.
fn error_of_simple_shear<M: Material>(material: &M, rate: ObjectiveRate, steps: u32) -> f64 {
    let mut worst = 0.0_f64;
    drive(material, simple_shear, 10.0, steps, |gamma, point| {
        let [xx, yy, zz, xy, yz, xz] = point.stress().0;
        let [shear, first, second] = closed_form(rate, gamma);
        for error in [xy - shear, xx - first, yy - second, zz, yz, xz] {
            worst = worst.max(error.abs());
        }
    });
    worst
}

#[test]
fn simple_shear_to_ten_meets_the_closed_forms_at_second_order() {
    let assert_errors = |rate: ObjectiveRate, error: &dyn Fn(u32) -> f64| {
        let [coarse, middle, fine] = [1000, 2000, 8000].map(error);
        // the convected stresses are polynomials in γ, which the update has exactly
        assert!(fine < 1e-10 || (coarse / middle).log2() > 1.95, "{rate:?}: {coarse:e} {middle:e}");
        assert!(fine < 3e-6, "{rate:?}: {fine:e}");
    };
    for rate in ObjectiveRate::ALL {
        let material = Hypoelastic::new(solid(), rate);
        assert_errors(rate, &|steps| error_of_simple_shear(&material, rate, steps));
    }
    let material = Elastic::new(solid());
    assert_errors(ObjectiveRate::Box, &|steps| error_of_simple_shear(&material, ObjectiveRate::Box, steps));
}

#[test]
fn the_box_rate_in_space_is_the_box_rate_in_the_frame_that_turns() {
    let (space, frame) = (Hypoelastic::new(solid(), ObjectiveRate::Box), Elastic::new(solid()));
    let path = |t: f64| Rotation::<f64>::about([1.0, 2.0, 0.5], 3.0 * t).to_tensor().dot(&simple_shear(2.0 * t));
    let space = drive(&space, path, 1.0, 300, |_, _| ());
    let frame = drive(&frame, path, 1.0, 300, |_, _| ());
    assert!((*space.stress() - *frame.stress()).norm_squared().sqrt() < 1e-13);
    assert!((space.internal_energy() / frame.internal_energy() - 1.0).abs() < 1e-13);
}

/// F, Ḟ and what follows from them at a moment of a motion in which nothing is special.
fn moment(time: f64) -> (Tensor<f64>, Turning) {
    let gradient = |t: f64| {
        let stretch = Tensor::from_rows([
            [1.0 + 0.4 * t, 0.3 * t * t, -0.1 * t],
            [0.2 * t, 1.0 - 0.2 * t, 0.5 * t],
            [0.1 * t * t, -0.3 * t, 1.0 + 0.3 * t],
        ]);
        Rotation::<f64>::about([0.4, -1.0, 0.7], 2.0 * t).to_tensor().dot(&stretch)
    };
    const STEP: f64 = 1e-5;
    let rate = |of: &dyn Fn(f64) -> Tensor<f64>| (of(time + STEP) - of(time - STEP)) * (0.5 / STEP);
    let now = gradient(time);
    let rotation_rate = rate(&|t| polar_rotation(&gradient(t))).dot(&polar_rotation(&now).transpose());
    let turning = Turning {
        velocity_gradient: rate(&gradient).dot(&now.inverse()),
        // the difference is skew but for its error
        rotation_rate: (rotation_rate - rotation_rate.transpose()) * 0.5,
        left_metric: now.dot(&now.transpose()).symmetric_part(),
    };
    (now, turning)
}

const STRESS: SymmetricTensor<f64> = SymmetricTensor([0.7, -0.4, 0.2, 0.5, -0.3, 0.1]);
const STRESS_RATE: SymmetricTensor<f64> = SymmetricTensor([0.1, 0.3, -0.6, 0.2, 0.4, -0.2]);

/// dV 6.77 and 6.86 to 6.88: the rotated rates differ by A^{j,c}, A^{j,□}, A^{c,□} of D, as does Ṫ̃ from each.
#[test]
fn rotated_rates_differ_by_the_tensors_of_the_dissertation() {
    let (gradient, motion) = moment(0.6);
    let rotation = polar_rotation(&gradient);
    let rotated = |rate: ObjectiveRate| rate.of(&STRESS_RATE, &STRESS, &motion).pulled_by(&rotation);
    let (l, omega, t) = (motion.velocity_gradient, motion.rotation_rate, STRESS.to_tensor());
    let spin = (l - l.transpose()) * 0.5;
    // Rᵀ{XᵀT + TX}R
    let tensor = |x: Tensor<f64>| (t.dot(&x).symmetric_part() * 2.0).pulled_by(&rotation);
    let stretching = l.symmetric_part().to_tensor();
    let relations = [
        // 6.86: −DT − TD
        (ObjectiveRate::Jaumann, ObjectiveRate::LowerConvected, tensor(stretching * -1.0)),
        // 6.87: (Wᵀ − Ωᵀ)T + T(W − Ω)
        (ObjectiveRate::Jaumann, ObjectiveRate::Box, tensor(spin - omega)),
        // 6.88: (Lᵀ − Ωᵀ)T + T(L − Ω)
        (ObjectiveRate::LowerConvected, ObjectiveRate::Box, tensor(l - omega)),
        // and those that follow in the same way for the other rates
        (ObjectiveRate::UpperConvected, ObjectiveRate::LowerConvected, tensor(stretching * -2.0)),
        (ObjectiveRate::Truesdell, ObjectiveRate::UpperConvected, STRESS.pulled_by(&rotation) * stretching.trace()),
    ];
    for (first, second, difference) in relations {
        let error = rotated(first) - rotated(second) - difference;
        assert!(error.norm_squared().sqrt() < 1e-14, "{first:?} {second:?}");
    }
    // the box rate turned back is the rate of the rotated stress (6.85): d(RᵀTR)/dt
    let step = 1e-5;
    let stress = |dt: f64| {
        let rotation = polar_rotation(&moment(0.6 + dt).0);
        STRESS_RATE.mul_add(dt, &STRESS).pulled_by(&rotation)
    };
    let difference = (stress(step) - stress(-step)) * (0.5 / step);
    assert!((difference - rotated(ObjectiveRate::Box)).norm_squared().sqrt() < 1e-8);
}

#[test]
fn the_update_makes_the_objective_rate_of_its_stress_that_of_elasticity() {
    let elasticity = solid();
    for rate in ObjectiveRate::ALL {
        let material = Hypoelastic::new(elasticity, rate);
        // steps to t and beyond it on both sides; the difference of the stresses is Ṫ
        let (time, steps) = (0.6, 3000);
        let step = time / f64::from(steps);
        let point = drive(&material, |t| moment(t).0, time - step, steps - 1, |_, _| ());
        let before = *point.stress();
        let mut point = point;
        point.advance(&moment(time).0, step);
        let stress = *point.stress();
        point.advance(&moment(time + step).0, step);
        let stress_rate = (*point.stress() - before) * (0.5 / step);
        let motion = moment(time).1;
        let found = rate.of(&stress_rate, &stress, &motion);
        let d = motion.velocity_gradient.symmetric_part();
        let wanted = (d * (2.0 * elasticity.shear_modulus())).plus_spherical(elasticity.lame_lambda() * d.trace());
        let error = (found - wanted).norm_squared().sqrt() / wanted.norm_squared().sqrt();
        assert!(error < 1e-5, "{rate:?}: {error:e}");
    }
}

/// A square in stretch and shear that ends where it began; it keeps the volume or does not.
fn closed_cycle(time: f64, keeps_volume: bool) -> Tensor<f64> {
    let (stretch, shear) = match time {
        t if t < 1.0 => (t, 0.0),
        t if t < 2.0 => (1.0, t - 1.0),
        t if t < 3.0 => (3.0 - t, 1.0),
        t => (0.0, 4.0 - t),
    };
    let stretch = (0.5 * stretch).exp();
    let lateral = if keeps_volume { stretch.recip() } else { 1.0 };
    simple_shear(shear).dot(&SymmetricTensor([stretch, lateral, 1.0, 0.0, 0.0, 0.0]).to_tensor())
}

#[test]
fn a_closed_cycle_leaves_no_stress_with_the_logarithmic_rate_alone() {
    for rate in ObjectiveRate::ALL {
        let material = Hypoelastic::new(solid(), rate);
        for keeps_volume in [true, false] {
            let left = |steps| {
                let point = drive(&material, |t| closed_cycle(t, keeps_volume), 4.0, steps, |_, _| ());
                point.stress().norm_squared().sqrt()
            };
            let (coarse, fine) = (left(800), left(1600));
            // at constant volume the convected rates are those of μ(B − I) and μ(I − B⁻¹)
            if rate == ObjectiveRate::Logarithmic || (keeps_volume && !rate.is_corotational()) {
                assert!(fine < 1e-5, "{rate:?}: {fine:e}");
                assert!(fine < 1e-12 || (coarse / fine).log2() > 1.95, "{rate:?}: {coarse:e} {fine:e}");
            } else {
                assert!(fine > 0.05, "{rate:?}, volume kept: {keeps_volume}: {fine}");
            }
        }
    }
}

#[test]
fn at_constant_volume_the_convected_rates_are_those_of_elastic_solids() {
    let path = |t: f64| closed_cycle(t, true);
    let end = path(1.7);
    let metric = end.dot(&end.transpose());
    let upper = (metric - Tensor::identity()).symmetric_part();
    let lower = (Tensor::identity() - metric.inverse()).symmetric_part();
    for (rate, wanted) in [
        (ObjectiveRate::UpperConvected, upper),
        (ObjectiveRate::Truesdell, upper),
        (ObjectiveRate::LowerConvected, lower),
    ] {
        let material = Hypoelastic::new(solid(), rate);
        let point = drive(&material, path, 1.7, 1700, |_, _| ());
        let error = (*point.stress() - wanted).norm_squared().sqrt();
        assert!(error < 1e-5, "{rate:?}: {error:e}");
    }
}

#[test]
fn a_turn_of_150_degrees_in_one_step_only_turns_the_stress() {
    let turn = Rotation::<f64>::about([0.4, -0.2, 1.0], 150_f64.to_radians()).to_tensor();
    for rate in ObjectiveRate::ALL {
        let material = Hypoelastic::new(solid(), rate);
        let mut point = drive(&material, simple_shear, 2.0, 100, |_, _| ());
        let before = *point.stress();
        point.advance(&turn.dot(&simple_shear(2.0)), 1.0);
        let error = (*point.stress() - before.pushed_by(&turn)).norm_squared().sqrt();
        // half a step to one side and half to the other stretch by 1/cos 75° = 3.9 in the making
        assert!(error < 1e-12, "{rate:?}: {error:e}");
    }
}

#[test]
fn uniaxial_strain_is_logarithmic_with_every_rate_that_only_turns() {
    for rate in ObjectiveRate::ALL.into_iter().filter(|rate| rate.is_corotational()) {
        let material = Hypoelastic::new(solid(), rate);
        let times: Vec<f64> = (0..=2000).map(|step| 1.0 + f64::from(step) / 2000.0).collect();
        let point = follow(&material, Control::uniaxial_strain, &times, |_, _| ()).unwrap();
        let stress = point.stress().0;
        let wanted = [material.elasticity().p_wave_modulus(), material.elasticity().lame_lambda()];
        for (component, modulus) in stress.into_iter().zip([wanted[0], wanted[1], wanted[1]]) {
            assert!((component / (modulus * 2.0_f64.ln()) - 1.0).abs() < 1e-7, "{rate:?}: {component}");
        }
    }
}
