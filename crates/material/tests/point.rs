//! Goal: the material-point driver finds the lateral stretches of a test under uniaxial stress, and says what it cannot do.
//!
//! Loading: uniaxial stress, plane-strain tension and cycles at one material point. Source: closed forms of each theory.

use estar_material::point::{Control, PathError, PointError, StretchMeasure, follow};
use estar_material::{
    EStar, EStarTotal, Elastic, ElasticConstant, Hencky, Hypoelastic, IsotropicElasticity, IsotropicHardening,
    KinematicHardening, Material, ObjectiveRate,
};
use estar_tensor::{Rotation, Tensor};
use std::f64::consts::PI;

const YOUNG: f64 = 200e9;
const POISSON: f64 = 0.32;
const YIELD: f64 = 260e6;

fn solid(poisson: f64) -> IsotropicElasticity {
    let constants = [ElasticConstant::YoungModulus(YOUNG), ElasticConstant::PoissonRatio(poisson)];
    IsotropicElasticity::new(7850.0, constants[0], constants[1]).unwrap()
}

fn perfect() -> IsotropicHardening {
    IsotropicHardening::perfect(YIELD).unwrap()
}

/// `steps` equal steps from 0 to `end`.
fn times(end: f64, steps: u32) -> Vec<f64> {
    (0..=steps).map(|step| end * f64::from(step) / f64::from(steps)).collect()
}

/// The largest lateral stress of a path of uniaxial stress whose stretch is `stretch(time)`, Pa.
fn lateral_stress<M: Material>(material: &M, stretch: impl Fn(f64) -> f64, times: &[f64]) -> f64 {
    let mut largest = 0.0_f64;
    let path = |time| Control::uniaxial_stress(stretch(time));
    let point = follow(material, path, times, |_, point| {
        let [_, yy, zz, ..] = point.stress().0;
        largest = largest.max(yy.abs()).max(zz.abs());
    });
    point.unwrap();
    largest
}

#[test]
fn lateral_stress_vanishes_in_tension_compression_and_cycles_of_every_theory() {
    type Stretch = fn(f64) -> f64;
    let paths: [(Stretch, f64); 4] = [
        (|t| (1.0 + 2.0 * t).sqrt(), 0.2),
        (|t| (1.0 - 2.0 * t).sqrt(), 0.2),
        (|t| (0.03 * (10.0 * t).sin()).exp(), 2.0),
        (|t| (1.5 * t).exp(), 1.0),
    ];
    for (stretch, end) in paths {
        for steps in [7, 100] {
            let times = times(end, steps);
            for poisson in [0.0, 0.32, 0.4999] {
                let solid = solid(poisson);
                let limit = 1e-10 * solid.p_wave_modulus();
                assert!(lateral_stress(&Elastic::new(solid), stretch, &times) <= limit);
                assert!(lateral_stress(&EStar::new(solid, perfect(), ()), stretch, &times) <= limit);
                assert!(lateral_stress(&EStarTotal::new(solid, perfect()), stretch, &times) <= limit);
                let law = IsotropicHardening::ludwik(YIELD, 400e6, 0.3).unwrap();
                let rule = KinematicHardening::armstrong_frederick(20e9, 80.0).unwrap();
                assert!(lateral_stress(&EStar::new(solid, law.clone(), rule), stretch, &times) <= limit);
                assert!(lateral_stress(&EStarTotal::new(solid, law), stretch, &times) <= limit);
                let rates = ObjectiveRate::ALL.into_iter().filter(|rate| rate.is_corotational());
                for rate in rates {
                    assert!(lateral_stress(&Hypoelastic::new(solid, rate), stretch, &times) <= limit);
                }
            }
        }
    }
}

#[test]
fn elastic_uniaxial_stress_is_hookes_law_in_logarithmic_strain() {
    let material = Elastic::new(solid(POISSON));
    let path = |strain: f64| Control::uniaxial_stress(strain.exp());
    follow(&material, path, &times(0.1, 1000), |strain, point| {
        assert!((point.stress().0[0] / (YOUNG * strain) - 1.0).abs() < 1e-7, "{strain}");
        let lateral = point.deformation_gradient().at(1, 1).ln();
        assert!((lateral / (-POISSON * strain) - 1.0).abs() < 1e-7, "{strain}: {lateral}");
    })
    .unwrap();
}

#[test]
fn plane_strain_tension_yields_at_two_over_root_three_of_the_yield_stress() {
    // far into perfect plastic flow without elastic change of volume the deviator is (1, −1, 0)
    let material = EStarTotal::new(solid(POISSON), perfect());
    let path = |strain: f64| Control::plane_strain_tension(1.0 + strain);
    let point = follow(&material, path, &times(0.2, 500), |_, _| ()).unwrap();
    let [xx, yy, zz, ..] = point.stress().0;
    assert!(yy.abs() < 1e-10 * material.elasticity().p_wave_modulus());
    assert!((xx / YIELD / (2.0 / 3.0_f64.sqrt()) - 1.0).abs() < 1e-3, "{}", xx / YIELD);
    assert!((zz / xx - 0.5).abs() < 2e-3, "{}", zz / xx);
    assert_eq!(point.deformation_gradient().at(2, 2), 1.0);
}

#[test]
fn an_observation_has_the_stresses_and_strains_of_the_theory() {
    let material = EStarTotal::new(solid(POISSON), perfect());
    let path = |strain: f64| Control::uniaxial_stress((1.0 + 2.0 * strain).sqrt());
    let point = follow(&material, path, &times(0.2, 400), |_, _| ()).unwrap();
    let seen = point.observation();
    let close = |found: f64, wanted: f64| assert!((found / wanted - 1.0).abs() < 1e-9, "{found} is not {wanted}");
    close(seen.stress.0[0], YIELD);
    close(seen.rotated_stress.0[0], YIELD);
    close(seen.green_strain.0[0], 0.2);
    // λ_p = λ/λ(t₀) (dV 7.99)
    close(seen.factors.plastic_strain().0[0], 0.5 * (1.4 / 1.0026 - 1.0));
    close(seen.factors.elastic_strain().0[0], 0.0013);
    close(seen.factors.elastic_strain().0[1], -POISSON * 0.0013);
    close(seen.plastic_determinant, 1.0);
    // J T₁₁/λ², J from the elastic strain
    close(seen.second_piola_stress.0[0], 1.0026_f64.sqrt() * (1.0 - 2.0 * POISSON * 0.0013) * YIELD / 1.4);
    assert_eq!(seen.hardening_index, Some(0.0));
    assert!((seen.internal_energy - seen.plastic_dissipation) / (0.5 * YIELD * 0.0013) - 1.0 < 0.01);

    // the same from the stress alone
    let rate = EStar::new(solid(POISSON), perfect(), ());
    let seen = follow(&rate, path, &times(0.2, 400), |_, _| ()).unwrap().observation();
    // whose elastic strain is logarithmic
    close(seen.factors.elastic_strain().0[0], 0.5 * (f64::exp(2.0 * 0.0013) - 1.0));
    assert!((seen.factors.plastic_strain().0[0] - 0.1982).abs() < 5e-5, "{}", seen.factors.plastic_strain().0[0]);
    assert!((seen.plastic_determinant - 1.0).abs() < 1e-8, "{}", seen.plastic_determinant);
}

#[test]
fn the_box_rate_has_no_plastic_strain_without_flow_and_none_of_volume_with_it() {
    let plastic_strain = |law: IsotropicHardening, path: &dyn Fn(f64) -> Control, steps: u32| {
        let material = EStar::new(solid(POISSON), law, ());
        let mut jump = 0.0_f64;
        let mut last = 0.0;
        let point = follow(&material, path, &times(1.0, steps), |_, point| {
            let strain = point.observation().factors.plastic_strain().norm_squared().sqrt();
            jump = jump.max((strain - last).abs());
            last = strain;
        });
        (point.unwrap().observation(), last, jump)
    };
    let stretched = |t: f64| Control::uniaxial_strain(1.0 + 0.05 * t);
    let sheared = |t: f64| Control::simple_shear(0.1 * t);
    let elastic = IsotropicHardening::perfect(1e3 * YIELD).unwrap();
    for path in [&stretched as &dyn Fn(f64) -> Control, &sheared] {
        let (seen, strain, _) = plastic_strain(elastic.clone(), path, 100);
        assert_eq!((strain, seen.equivalent_plastic_strain), (0.0, 0.0));
    }
    // a solid that yields at 2 % of Young's modulus, to a volume of 1.2: no jump where it begins to flow
    let strong = IsotropicHardening::perfect(0.02 * YOUNG).unwrap();
    let (seen, strain, jump) = plastic_strain(strong, &|t| Control::uniaxial_strain(1.0 + 0.2 * t), 2000);
    assert!((seen.plastic_determinant - 1.0).abs() < 1e-6, "{}", seen.plastic_determinant);
    assert!(strain > 0.1 && jump < 3.0 * strain / 2000.0, "{strain} {jump}");
}

#[test]
fn the_hardening_index_is_the_slope_over_the_elastic_slope_and_it() {
    let (modulus, three_mu) = (1e9, 3.0 * solid(POISSON).shear_modulus());
    let path = |stretch: f64| Control::uniaxial_stress(1.0 + stretch);
    let law = IsotropicHardening::linear(YIELD, modulus).unwrap();
    let total = EStarTotal::new(solid(POISSON), law.clone());
    let seen = follow(&total, path, &times(0.1, 50), |_, _| ()).unwrap();
    // but for the size of the elastic strain, which has tr b_e = 3 + 2 tr E*
    let index = seen.observation().hardening_index.unwrap() / (modulus / (three_mu + modulus));
    assert!((index - 1.0).abs() < 2.0 * YIELD / YOUNG && index != 1.0, "{index}");
    let hencky = Hencky::von_mises(solid(POISSON), law.clone());
    let seen = follow(&hencky, path, &times(0.1, 50), |_, _| ()).unwrap();
    assert_eq!(seen.observation().hardening_index, Some(modulus / (three_mu + modulus)));
    // Prager's rule hardens as much as its modulus
    let prager = EStar::new(solid(POISSON), law, KinematicHardening::prager(2e9).unwrap());
    let seen = follow(&prager, path, &times(0.1, 50), |_, _| ()).unwrap().observation();
    assert_eq!(seen.hardening_index, Some(3e9 / (three_mu + 3e9)));
    // Armstrong and Frederick's no longer does once it has saturated
    let rule = KinematicHardening::armstrong_frederick(20e9, 400.0).unwrap();
    let saturated = EStar::new(solid(POISSON), perfect(), rule);
    let seen = follow(&saturated, path, &times(0.2, 200), |_, _| ()).unwrap().observation();
    assert!(seen.hardening_index.unwrap().abs() < 1e-9, "{:?}", seen.hardening_index);
    let elastic = Elastic::new(solid(POISSON));
    assert_eq!(follow(&elastic, path, &[0.0, 0.1], |_, _| ()).unwrap().observation().hardening_index, None);
}

#[test]
fn what_cannot_be_followed_is_said_with_its_step() {
    let material = Elastic::new(solid(POISSON));
    let turned = |angle: f64| Control::deformation_gradient(Rotation::<f64>::about([0.0, 0.0, 1.0], angle).to_tensor());
    let failure = |times: &[f64], path: &dyn Fn(f64) -> Control| follow(&material, path, times, |_, _| ()).unwrap_err();
    let PathError { step, time_old, time, error } =
        failure(&[0.0, 1.0, 2.0], &|t| Control::uniaxial_stress(1.0 - 0.6 * t));
    assert_eq!((step, time_old, time), (2, 1.0, 2.0));
    assert!(matches!(error, PointError::Inverted { .. }), "{error}");
    assert!(matches!(failure(&[0.0, PI], &turned).error, PointError::StepTooLarge { .. }));
    let reflection = Control::deformation_gradient(Tensor::identity() * -1.0);
    assert!(matches!(failure(&[0.0, 1.0], &|_| reflection).error, PointError::Inverted { jacobian: -1.0 }));
    let nowhere = Control::deformation_gradient(Tensor::identity() * f64::NAN);
    assert!(matches!(failure(&[0.0, 1.0], &|_| nowhere).error, PointError::Inverted { .. }));
    let message = failure(&[0.0, PI], &turned).to_string();
    assert!(message.contains("step 1, from time 0.0 s to 3.14") && message.contains("take more steps"), "{message}");
}

#[test]
fn stretch_measures_give_the_stretch_and_refuse_what_none_has() {
    let measures = [StretchMeasure::GreenLagrange, StretchMeasure::Stretch, StretchMeasure::Logarithmic];
    for (measure, value) in measures.into_iter().zip([0.22, 1.2, 1.2_f64.ln()]) {
        assert!((measure.stretch(value).unwrap() - 1.2).abs() < 1e-15);
    }
    for (measure, values) in
        measures.into_iter().zip([[-0.5, -1.0, f64::INFINITY], [0.0, -1.0, f64::NAN], [800.0, -800.0, f64::NAN]])
    {
        assert!(values.into_iter().all(|value| measure.stretch(value).is_none()), "{measure:?}");
    }
}

#[test]
fn the_loading_index_tells_flow_from_unloading() {
    // ln λ = 0.02 t and back
    let stretch = |t: f64| (0.02 * if t <= 1.0 { t } else { 2.0 - t }).exp();
    let times = times(1.01, 1010);
    let elasticity = solid(POISSON);
    let path = |t| Control::uniaxial_stress(stretch(t));
    follow(&EStarTotal::new(elasticity, perfect()), path, &times, |t, point| {
        let found = point.observation().loading_index.unwrap();
        if (0.1..=1.0).contains(&t) {
            // Γ : D = 2μ σ₀ d ln λ/dt where the volume is kept, to the order of the elastic strain
            let index = 2.0 * elasticity.shear_modulus() * YIELD * 0.02;
            assert!((found / index - 1.0).abs() < 5e-3, "{t}: {found} {index}");
        } else {
            assert_eq!(found > 0.0, t < 1.0, "{t}: {found}");
        }
    })
    .unwrap();
}
