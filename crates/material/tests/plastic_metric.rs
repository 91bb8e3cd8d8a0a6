//! Goal: the seven flow rules for the plastic metric are what they claim to be, and what they keep is found by computing it.
//!
//! Loading: non-proportional paths of deformation gradients at one material point. Source: Neff & Ghiba, "Comparison of
//! isotropic elasto-plastic models for the plastic metric tensor C_p = F_pᵀF_p" (NG).

use estar_material::point::{Control, MaterialPoint, drive};
use estar_material::{
    Consistency, EStarTotal, ElasticConstant, ElasticEnergy, FlowRule, Hencky, IsotropicElasticity, IsotropicHardening,
    PlasticMetric,
};
use estar_tensor::{SymmetricTensor, Tensor};
use proptest::prelude::*;

const ENERGIES: [ElasticEnergy; 2] = [ElasticEnergy::Hencky, ElasticEnergy::NeoHooke];
const CONSISTENT: [FlowRule; 5] =
    [FlowRule::SimoMiehe, FlowRule::Miehe, FlowRule::Lion, FlowRule::Helm, FlowRule::GrandiStefanelli];

fn solid() -> IsotropicElasticity {
    let constants = (ElasticConstant::YoungModulus(200e9), ElasticConstant::PoissonRatio(0.32));
    IsotropicElasticity::new(7850.0, constants.0, constants.1).unwrap()
}

/// A solid that yields at `share` of Young's modulus.
fn material(energy: ElasticEnergy, rule: FlowRule, share: f64) -> PlasticMetric {
    PlasticMetric::new(solid(), IsotropicHardening::linear(share * 200e9, 1e9).unwrap(), energy, rule)
}

/// Stretch, then shear on other axes, then back: 0 ≤ t ≤ 1.
fn path(t: f64) -> Tensor<f64> {
    let (a, b, c) = (0.25 * (2.0 * t).sin(), 0.5 * t * t, 0.3 * (5.0 * t).sin());
    let gradient = Tensor::from_rows([[1.0 + a, b, 0.1 * t], [c, 1.0 - 0.5 * a, 0.2 * b], [0.0, -c, 1.0 - 0.4 * a]]);
    gradient * gradient.determinant().cbrt().recip()
}

fn size(tensor: Tensor<f64>) -> f64 {
    tensor.norm_squared().sqrt()
}

#[test]
fn five_flow_rules_give_one_plastic_metric_on_random_paths() {
    let targets = prop::collection::vec(prop::array::uniform9(-0.25..0.25_f64), 1..5);
    let mut runner = proptest::test_runner::TestRunner::new(ProptestConfig {
        cases: 32,
        failure_persistence: None,
        ..ProptestConfig::default()
    });
    let outcome = runner.run(&targets, |targets| {
        for energy in ENERGIES {
            let materials = CONSISTENT.map(|rule| material(energy, rule, 0.005));
            let mut points = materials.each_ref().map(MaterialPoint::new);
            let mut gradient = Tensor::identity();
            for [a, b, c, d, e, f, g, h, i] in &targets {
                // in a straight line to (I + G) F, ‖G‖ < 1, in 40 steps
                let step = Tensor::from_rows([[*a, *b, *c], [*d, *e, *f], [*g, *h, *i]]) * (1.0 / 40.0);
                let increment = step.dot(&gradient);
                for _ in 0..40 {
                    gradient = gradient + increment;
                    for point in &mut points {
                        point.advance(&gradient, 1.0);
                    }
                }
            }
            let first = points[0].state();
            for (rule, point) in CONSISTENT.iter().zip(&points) {
                let error = size(point.state().inverse_plastic_metric - first.inverse_plastic_metric);
                let scale = size(first.inverse_plastic_metric);
                prop_assert!(error < 1e-8 * scale, "{energy:?} {rule:?}: {error:e} of {scale}");
            }
            prop_assert!(points[0].equivalent_plastic_strain() > 0.0);
        }
        Ok(())
    });
    outcome.unwrap();
}

#[test]
fn pressure_is_that_of_the_volume_where_a_rule_keeps_it() {
    // of Hencky's energy ⅓ tr τ = k ln J_e, with J_e = J of every rule but one, symmetric or not
    let swelling = |t: f64| path(t) * (1.0 + 0.01 * t);
    for rule in FlowRule::ALL {
        let material = material(ElasticEnergy::Hencky, rule, 0.005);
        let point = drive(&material, swelling, 1.0, 1000, |_, _| ());
        let jacobian = point.deformation_gradient().determinant();
        let pressure = solid().bulk_modulus() * jacobian.ln() / jacobian;
        let error = (point.stress().trace() / 3.0 / pressure - 1.0).abs();
        assert_eq!(error > 1e-9, rule == FlowRule::SimoHughes, "{rule:?}: {error:e}");
    }
}

#[test]
fn what_a_rule_does_not_dissipate_is_in_its_energy() {
    for energy in ENERGIES {
        for rule in FlowRule::ALL.into_iter().filter(|rule| *rule != FlowRule::SimoHughes) {
            let material = material(energy, rule, 0.005);
            let error = |steps| {
                let point = drive(&material, path, 1.0, steps, |_, _| ());
                let stored =
                    material.elastic_energy(point.deformation_gradient(), &point.state().inverse_plastic_metric);
                let work = point.internal_energy();
                ((work - point.plastic_dissipation() - stored) / work).abs()
            };
            let (coarse, fine) = (error(1000), error(4000));
            assert!(fine < 1e-3 && (fine < 1e-5 || coarse / fine > 3.0), "{energy:?} {rule:?}: {coarse:e} {fine:e}");
        }
    }
}

#[test]
fn consistent_rules_keep_the_determinant_through_100_000_steps() {
    for energy in ENERGIES {
        for rule in CONSISTENT {
            let material = material(energy, rule, 0.0013);
            let mut worst: f64 = 0.0;
            let there_and_back = |t: f64| path(0.5 - 0.5 * (2.0 * t).cos());
            let point = drive(&material, there_and_back, 20.0, 100_000, |_, point| {
                worst = worst.max((point.state().inverse_plastic_metric.determinant() - 1.0).abs());
            });
            assert!(worst < 1e-12, "{energy:?} {rule:?}: {worst:e}");
            assert!(point.equivalent_plastic_strain() > 1.0);
        }
    }
}

/// dC_p⁻¹/dt for γ̇ = 1 as NG has it, from C, C_p⁻¹ and the stress alone.
fn rate(
    rule: FlowRule,
    gradient: &Tensor<f64>,
    inverse_metric: &Tensor<f64>,
    kirchhoff: &SymmetricTensor<f64>,
) -> Tensor<f64> {
    let inverse = gradient.inverse();
    let deviator = kirchhoff.deviator();
    let n = (deviator * deviator.norm_squared().sqrt().recip()).to_tensor();
    let elastic_metric = inverse_metric.symmetric_part().pushed_by(gradient).to_tensor();
    // dev Σ̃ = dev(C S), S = F⁻¹ τ F⁻ᵀ
    let metric = gradient.transpose_dot(gradient);
    let mandel = metric.dot(&kirchhoff.pushed_by(&inverse).to_tensor());
    let mandel = mandel.plus_spherical(-mandel.trace() / 3.0);
    let invariant = mandel.dot(&mandel).trace().sqrt();
    // any F_p of C_p⁻¹ = F_p⁻¹ F_p⁻ᵀ: the symmetric one
    let system = inverse_metric.symmetric_part().eigensystem();
    let root = SymmetricTensor::diagonal(system.values.map(f64::sqrt)).pushed_by(&system.vectors).to_tensor();
    match rule {
        FlowRule::SimoMiehe => inverse.dot(&n.dot(&elastic_metric)).dot(&inverse.transpose()) * -2.0,
        FlowRule::Miehe => mandel.transpose().dot(inverse_metric) * (-2.0 / invariant),
        FlowRule::Lion => {
            let elastic = gradient.dot(&root);
            let stress = elastic.transpose_dot(&deviator.to_tensor().dot(&elastic.inverse().transpose()));
            root.dot(&stress).dot(&root.transpose()) * (-2.0 / size(stress))
        }
        FlowRule::SimoHughes => inverse.dot(&n).dot(&inverse.transpose()) * (-2.0 / 3.0 * elastic_metric.trace()),
        FlowRule::Helm => {
            // d(C_p⁻¹) = −C_p⁻¹ dC_p C_p⁻¹
            inverse_metric.dot(&mandel) * (-2.0 / invariant)
        }
        FlowRule::GrandiStefanelli => {
            let stress = root.dot(&mandel).dot(&root.inverse());
            root.dot(&stress).dot(&root) * (-2.0 / size(stress))
        }
        FlowRule::FrobeniusNormal => mandel.dot(inverse_metric) * (-2.0 / size(mandel)),
    }
}

/// The rate equations themselves, without any update: C_p⁻¹ at the end of F(t), `begin` ≤ t ≤ 1, by the classical Runge-Kutta
/// method, from C_p = I at first yield. The multiplier of each rule keeps its own yield function at zero. Perfect plasticity,
/// neo-Hooke.
fn integrated(rule: FlowRule, gradient: &dyn Fn(f64) -> Tensor<f64>, begin: f64, steps: u32) -> Tensor<f64> {
    let kirchhoff = |time: f64, metric: &Tensor<f64>| {
        let (mu, lambda) = (solid().shear_modulus(), solid().lame_lambda());
        let gradient = gradient(time);
        let elastic_metric = gradient.dot(&metric.dot(&gradient.transpose()));
        (elastic_metric.symmetric_part() * mu).plus_spherical(0.5 * lambda * elastic_metric.determinant().ln() - mu)
    };
    let yield_function = |time: f64, metric: &Tensor<f64>| {
        let deviator = kirchhoff(time, metric).deviator();
        1.5 * deviator.norm_squared() / YIELD.powi(2)
    };
    let slope = |time: f64, metric: &Tensor<f64>| {
        let flow = rate(rule, &gradient(time), metric, &kirchhoff(time, metric));
        let step = 1e-6;
        let by_time = yield_function(time + step, metric) - yield_function(time - step, metric);
        let by_flow = yield_function(time, &(*metric + flow * step)) - yield_function(time, &(*metric - flow * step));
        let multiplier = -by_time / by_flow;
        assert!(multiplier > 0.0, "{rule:?} unloads at t = {time}");
        flow * multiplier
    };
    let mut metric = Tensor::identity();
    let step = (1.0 - begin) / f64::from(steps);
    for index in 0..steps {
        let time = begin + step * f64::from(index);
        let first = slope(time, &metric);
        let second = slope(time + 0.5 * step, &(metric + first * (0.5 * step)));
        let third = slope(time + 0.5 * step, &(metric + second * (0.5 * step)));
        let fourth = slope(time + step, &(metric + third * step));
        metric = metric + (first + (second + third) * 2.0 + fourth) * (step / 6.0);
    }
    metric
}

/// 0.5 % of Young's modulus.
const YIELD: f64 = 0.005 * 200e9;

#[test]
fn the_rate_equations_of_the_five_rules_have_one_solution_to_which_every_update_converges() {
    let straight = prop::array::uniform9(-0.2..0.2_f64);
    let mut runner = proptest::test_runner::TestRunner::new(ProptestConfig {
        cases: 12,
        failure_persistence: None,
        ..ProptestConfig::default()
    });
    let outcome = runner.run(&(straight, prop::array::uniform9(-0.06..0.06_f64)), |(first, second)| {
        // stretch and shear in one direction at first, more and more in another: it loads all the way
        let rows = |[a, b, c, d, e, f, g, h, i]: [f64; 9]| Tensor::from_rows([[a, b, c], [d, e, f], [g, h, i]]);
        let (first, second) = (rows(first), rows(second));
        let gradient = |t: f64| {
            let raw = (first * t + second * (t * t)).plus_spherical(1.0);
            raw * raw.determinant().cbrt().recip()
        };
        let elastic = PlasticMetric::new(
            solid(),
            IsotropicHardening::perfect(1e3 * YIELD).unwrap(),
            ElasticEnergy::NeoHooke,
            FlowRule::SimoMiehe,
        );
        let outside = |t: f64| {
            let mut point = MaterialPoint::new(&elastic);
            point.advance(&gradient(t), 1.0);
            1.5 * point.stress().deviator().norm_squared() > YIELD.powi(2)
        };
        prop_assume!(outside(0.3));
        let (mut begin, mut high) = (0.0, 0.3);
        for _ in 0..60 {
            let middle = 0.5 * (begin + high);
            if outside(middle) { high = middle } else { begin = middle }
        }
        let solutions = CONSISTENT.map(|rule| integrated(rule, &gradient, begin, 4000));
        for (rule, solution) in CONSISTENT.iter().zip(&solutions) {
            let error = size(*solution - solutions[0]);
            prop_assert!(error < 1e-8, "{rule:?}: {error:e}");
            prop_assert!((solution.determinant() - 1.0).abs() < 1e-8 && size(*solution - solution.transpose()) < 1e-8);
        }
        for rule in CONSISTENT {
            let law = IsotropicHardening::perfect(YIELD).unwrap();
            let material = PlasticMetric::new(solid(), law, ElasticEnergy::NeoHooke, rule);
            let error = |steps| {
                let point = drive(&material, gradient, 1.0, steps, |_, _| ());
                size(point.state().inverse_plastic_metric - solutions[0])
            };
            let (coarse, fine) = (error(1000), error(4000));
            prop_assert!(fine < 0.3 * coarse && fine < 1e-3, "{rule:?}: {coarse:e} {fine:e}");
        }
        // and the two others have other solutions
        for rule in [FlowRule::SimoHughes, FlowRule::FrobeniusNormal] {
            let error = size(integrated(rule, &gradient, begin, 500) - solutions[0]);
            prop_assert!(error > 1e-6, "{rule:?}: {error:e}");
        }
        Ok(())
    });
    outcome.unwrap();
}

#[test]
fn every_rule_moves_at_its_own_rate() {
    for energy in ENERGIES {
        for rule in FlowRule::ALL {
            let material = material(energy, rule, 0.005);
            let error = |steps: u32| {
                let mut old = MaterialPoint::new(&material);
                let mut worst: f64 = 0.0;
                drive(&material, path, 1.0, steps, |time, point| {
                    let (state, state_old) = (point.state(), old.state());
                    let multiplier =
                        1.5_f64.sqrt() * (state.equivalent_plastic_strain - state_old.equivalent_plastic_strain);
                    // from a state well in the midst of flow
                    if time > 0.5 && multiplier > 0.0 && state_old.equivalent_plastic_strain > 0.0 {
                        let moved = state.inverse_plastic_metric - state_old.inverse_plastic_metric;
                        let gradient = point.deformation_gradient();
                        let kirchhoff = *point.stress() * gradient.determinant();
                        let wanted = rate(rule, gradient, &state_old.inverse_plastic_metric, &kirchhoff);
                        worst = worst.max(size(moved * multiplier.recip() - wanted));
                    }
                    old = point.clone();
                });
                worst
            };
            let (coarse, fine) = (error(1000), error(4000));
            // of a rate of some 2; a straight line meets it at once
            let converges = fine < 0.05 && (coarse / fine).log2() > 1.7;
            assert!(converges || fine < 1e-10, "{energy:?} {rule:?}: {coarse:e} {fine:e}");
        }
    }
}

fn consistency(material: &PlasticMetric, steps: u32) -> Consistency {
    let times: Vec<f64> = (0..=steps).map(|step| f64::from(step) / f64::from(steps)).collect();
    Consistency::along(material, |time| Control::deformation_gradient(path(time)), &times)
}

#[test]
fn the_verdict_on_each_rule_comes_from_its_figures() {
    for energy in ENERGIES {
        println!("{energy:?}: least dissipation, |det C_p - 1|, asymmetry, least principal value, from Simo-Miehe");
        for rule in FlowRule::ALL {
            let found = consistency(&material(energy, rule, 0.005), 2000);
            println!(
                "{:18} {:10.3e} {:10.3e} {:10.3e} {:8.5} {:10.3e}  {}",
                rule.name(),
                found.least_dissipation,
                found.determinant_drift,
                found.asymmetry,
                found.least_principal_value,
                found.distance_from_simo_miehe,
                if found.is_consistent() == Some(true) { "consistent" } else { "not consistent" },
            );
            // what the Frobenius-normal rule loses of the symmetry it gains in energy
            assert!(found.dissipates() || rule == FlowRule::FrobeniusNormal, "{rule:?} {found:?}");
            assert_eq!(found.is_consistent(), Some(rule.fault().is_none()), "{rule:?} {found:?}");
            assert_eq!(found.equals_simo_miehe(), rule.fault().is_none(), "{rule:?} {found:?}");
            assert_eq!(found.is_isochoric(), rule != FlowRule::SimoHughes, "{rule:?} {found:?}");
            assert_eq!(found.is_metric(), rule != FlowRule::FrobeniusNormal, "{rule:?} {found:?}");
        }
    }
}

#[test]
fn a_path_without_flow_and_one_that_ends_give_no_good_verdict() {
    for rule in FlowRule::ALL {
        let material = material(ElasticEnergy::Hencky, rule, 0.005);
        let times = [0.0, 0.5, 1.0];
        let along = |control: fn(f64) -> Control| Consistency::along(&material, control, &times);
        let found = along(|time| Control::uniaxial_strain(1.0 + 1e-6 * time));
        assert_eq!((found.flowing_steps, found.is_consistent(), found.ended), (0, None, None), "{rule:?}");
        let found = along(|time| Control::uniaxial_strain(1.1 - 1.3 * (time - 0.5).max(0.0) * 2.0));
        assert_eq!((found.flowing_steps, found.is_consistent()), (1, Some(false)), "{rule:?}");
        assert_eq!(found.ended.unwrap().step, 2, "{rule:?}");
    }
}

#[test]
fn faults_do_not_go_away_with_the_step() {
    for (rule, fault) in [
        (FlowRule::SimoHughes, (|found| found.determinant_drift) as fn(Consistency) -> f64),
        (FlowRule::FrobeniusNormal, |found| found.asymmetry),
    ] {
        let material = material(ElasticEnergy::NeoHooke, rule, 0.005);
        let [coarse, fine] = [1000, 4000].map(|steps| fault(consistency(&material, steps)));
        assert!((coarse / fine - 1.0).abs() < 0.1 && fine > 1e-4, "{rule:?}: {coarse:e} {fine:e}");
    }
}

#[test]
fn with_its_energy_the_stress_is_that_of_the_hencky_theory() {
    let law = IsotropicHardening::linear(1e9, 1e9).unwrap();
    let hencky = Hencky::von_mises(solid(), law.clone());
    let expected = drive(&hencky, path, 1.0, 500, |_, _| ());
    for rule in CONSISTENT {
        let material = PlasticMetric::new(solid(), law.clone(), ElasticEnergy::Hencky, rule);
        let found = drive(&material, path, 1.0, 500, |_, _| ());
        assert!((*found.stress() - *expected.stress()).norm_squared().sqrt() < 1e-10 * 200e9, "{rule:?}");
    }
}

#[test]
fn neo_hooke_flows_as_e_star_total_where_the_volume_stays() {
    let law = IsotropicHardening::linear(1e9, 1e9).unwrap();
    let total = EStarTotal::new(solid(), law.clone());
    let expected = drive(&total, path, 1.0, 500, |_, _| ());
    for rule in CONSISTENT {
        let material = PlasticMetric::new(solid(), law.clone(), ElasticEnergy::NeoHooke, rule);
        let found = drive(&material, path, 1.0, 500, |_, _| ());
        let difference = found.stress().deviator() - expected.stress().deviator();
        assert!(difference.norm_squared().sqrt() < 1e-10 * 200e9, "{rule:?}");
        assert!((found.equivalent_plastic_strain() - expected.equivalent_plastic_strain()).abs() < 1e-10, "{rule:?}");
    }
}
