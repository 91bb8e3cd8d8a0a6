//! Goal: the returned stress is the nearest admissible one in the energy norm, on smooth and on cornered surfaces.
//!
//! Loading: random trial stresses far outside and near corners. Source: "Exploring closest point return plasticity";
//! the projection theorem; the return mappings of the theories of Hencky and E*.

use estar_material::point::{MaterialPoint, drive};
use estar_material::{ClosestPoint, EStar, ElasticConstant, Hencky, IsotropicElasticity, IsotropicHardening, Material};
use estar_tensor::{Kernel, LaneLevel, Real, SymmetricTensor, Tensor, WithLanes, dispatch};
use proptest::prelude::*;

const STRENGTH: f64 = 260e6;
const YOUNG: f64 = 200e9;

fn solid(poisson_ratio: f64) -> IsotropicElasticity {
    let constants = (ElasticConstant::YoungModulus(YOUNG), ElasticConstant::PoissonRatio(poisson_ratio));
    IsotropicElasticity::new(7850.0, constants.0, constants.1).unwrap()
}

/// Every surface whose flow is associated.
fn surfaces(elasticity: IsotropicElasticity) -> [(&'static str, ClosestPoint); 6] {
    let angle = 0.5;
    [
        ("von Mises", ClosestPoint::von_mises(elasticity, STRENGTH).unwrap()),
        ("Drucker-Prager", ClosestPoint::drucker_prager(elasticity, angle, STRENGTH, angle).unwrap()),
        ("Rankine", ClosestPoint::rankine(elasticity, STRENGTH).unwrap()),
        ("Mohr-Coulomb", ClosestPoint::mohr_coulomb(elasticity, angle, STRENGTH).unwrap()),
        ("steep Mohr-Coulomb", ClosestPoint::mohr_coulomb(elasticity, 1.3, STRENGTH).unwrap()),
        ("flat Mohr-Coulomb", ClosestPoint::mohr_coulomb(elasticity, 0.01, STRENGTH).unwrap()),
    ]
}

fn sorted(mut stress: [f64; 3]) -> [f64; 3] {
    stress.sort_by(|a, b| b.total_cmp(a));
    stress
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Principal stresses, some with two or three equal.
fn stresses(scale: f64) -> impl Strategy<Value = [f64; 3]> {
    (prop::array::uniform3(-1.0..1.0_f64), 0..4_u8).prop_map(move |([a, b, c], equal)| {
        let (b, c) = match equal {
            0 => (a, c),
            1 => (b, b),
            2 => (a, a),
            _ => (b, c),
        };
        sorted([a * scale, b * scale, c * scale])
    })
}

/// The admissible stress on the way from `inside` to `stress` that is nearest to `stress`.
fn drawn_in(surface: &ClosestPoint, inside: [f64; 3], stress: [f64; 3]) -> [f64; 3] {
    let at = |t: f64| sorted([0, 1, 2].map(|i| inside[i] + t * (stress[i] - inside[i])));
    if surface.yield_function(at(1.0)) <= 0.0 {
        return at(1.0);
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if surface.yield_function(at(middle)) <= 0.0 { low = middle } else { high = middle }
    }
    at(low)
}

#[test]
fn the_returned_stress_is_on_the_surface_and_no_admissible_stress_is_nearer() {
    let samples = prop::collection::vec(stresses(20.0 * STRENGTH), 24);
    let mut runner = proptest::test_runner::TestRunner::new(ProptestConfig {
        cases: 500,
        failure_persistence: None,
        ..ProptestConfig::default()
    });
    let outcome = runner.run(&(stresses(10.0 * STRENGTH), samples), |(trial, samples)| {
        for poisson_ratio in [-0.3, 0.0, 0.32, 0.49] {
            for (name, surface) in surfaces(solid(poisson_ratio)) {
                let found = surface.returned(trial);
                prop_assert!(found[0] >= found[1] - 1e-3 && found[1] >= found[2] - 1e-3, "{name}: {found:?}");
                if surface.yield_function(trial) <= 0.0 {
                    prop_assert_eq!(found, trial);
                    continue;
                }
                // rounding of the trial, and of the apex of the flat cone, which is 100 times as far away
                let excess = surface.yield_function(found);
                prop_assert!(excess.abs() < 1e-11 * STRENGTH, "{name}: {excess}");
                let distance = surface.energy_norm_squared(minus(trial, found)).sqrt();
                let inside = [-0.5 * STRENGTH; 3];
                for &sample in &samples {
                    let other = drawn_in(&surface, inside, sample);
                    // also half way from the sample to the answer
                    let near = [0, 1, 2].map(|i| found[i] + 1e-3 * (other[i] - found[i]));
                    for other in [other, near] {
                        let longer = surface.energy_norm_squared(minus(trial, other)).sqrt();
                        prop_assert!(longer >= distance * (1.0 - 1e-9), "{name}: {trial:?} {found:?} {other:?}");
                    }
                }
            }
        }
        Ok(())
    });
    outcome.unwrap();
}

/// Principal stresses on a grid, sorted.
fn grid() -> impl Iterator<Item = [f64; 3]> {
    let value = |i: i32| 0.4 * STRENGTH * f64::from(i);
    (-9..=9).flat_map(move |i| (-9..=i).flat_map(move |j| (-9..=j).map(move |k| [value(i), value(j), value(k)])))
}

#[test]
fn face_both_edges_and_apex_are_reached() {
    let surface = ClosestPoint::mohr_coulomb(solid(0.32), 0.5, STRENGTH).unwrap();
    let mut count = [0; 4];
    for trial in grid().filter(|trial| surface.yield_function(*trial) > 0.0) {
        let [a, b, c] = surface.returned(trial);
        let equal = |x: f64, y: f64| (x - y).abs() < 1e-9 * STRENGTH;
        count[usize::from(equal(a, b)) + 2 * usize::from(equal(b, c))] += 1;
    }
    assert!(count.iter().all(|count| *count > 20), "{count:?}");
    let apex = surface.returned([10.0 * STRENGTH; 3]);
    // c cot φ
    assert!(apex.iter().all(|stress| (stress * 0.5_f64.tan() / STRENGTH - 1.0).abs() < 1e-12), "{apex:?}");
}

/// The largest difference, over E, between the stress τ or T after one step to a trial stress and its closest point. `target`
/// gives F of principal strains, `stress` what the surface bounds.
fn distance_from_closest_point<M: Material>(
    material: &M,
    surface: &ClosestPoint,
    target: fn(f64) -> f64,
    stress: fn(&MaterialPoint<'_, M>) -> SymmetricTensor<f64>,
) -> f64 {
    let mut worst: f64 = 0.0;
    for trial in grid() {
        // ε = C⁻¹ σ
        let sum: f64 = trial.iter().sum();
        let strain = trial.map(|stress| (1.32 * stress - 0.32 * sum) / YOUNG);
        let mut point = MaterialPoint::new(material);
        point.advance(&SymmetricTensor::diagonal(strain.map(target)).to_tensor(), 1.0);
        let stress = stress(&point).0;
        for (i, found) in surface.returned(trial).into_iter().enumerate() {
            worst = worst.max((found - stress[i]).abs() / YOUNG);
        }
    }
    worst
}

fn kirchhoff<M: Material>(point: &MaterialPoint<'_, M>) -> SymmetricTensor<f64> {
    *point.stress() * point.deformation_gradient().determinant()
}

#[test]
fn the_projector_gives_the_return_mappings_of_hencky_and_of_e_star() {
    let elasticity = solid(0.32);
    let law = || IsotropicHardening::perfect(STRENGTH).unwrap();
    let von_mises = ClosestPoint::von_mises(elasticity, STRENGTH).unwrap();
    let rankine = ClosestPoint::rankine(elasticity, STRENGTH).unwrap();
    let found = [
        // F = e^ε, and the Kirchhoff stress
        distance_from_closest_point(&Hencky::von_mises(elasticity, law()), &von_mises, f64::exp, kirchhoff),
        distance_from_closest_point(&Hencky::rankine(elasticity, law()), &rankine, f64::exp, kirchhoff),
        // Δt D = 2 (λ − 1)/(λ + 1) from I to λ in a straight line, and the Cauchy stress
        distance_from_closest_point(
            &EStar::new(elasticity, law(), ()),
            &von_mises,
            |strain| (2.0 + strain) / (2.0 - strain),
            |point| *point.stress(),
        ),
    ];
    assert!(found.iter().all(|distance| *distance < 1e-14), "{found:?}");
}

#[test]
fn hencky_with_the_projector_is_hencky_with_its_own_returns_along_a_path() {
    let elasticity = solid(0.32);
    let law = || IsotropicHardening::perfect(STRENGTH).unwrap();
    let path = |t: f64| {
        let (a, b) = (0.3 * (3.0 * t).sin(), 0.4 * t * t);
        Tensor::from_rows([[1.0 + a, b, 0.0], [0.1 * t, 1.0 - 0.5 * a, -b], [0.0, 0.2 * t, 1.0 - 0.4 * a]])
    };
    fn ends<M: Material>(material: &M, path: impl Fn(f64) -> Tensor<f64>) -> ([f64; 6], f64) {
        let point = drive(material, path, 1.0, 400, |_, _| ());
        (point.stress().0, point.plastic_dissipation())
    }
    let pairs = [
        (
            ends(&Hencky::von_mises(elasticity, law()), path),
            ends(&Hencky::closest_point(ClosestPoint::von_mises(elasticity, STRENGTH).unwrap()), path),
        ),
        (
            ends(&Hencky::rankine(elasticity, law()), path),
            ends(&Hencky::closest_point(ClosestPoint::rankine(elasticity, STRENGTH).unwrap()), path),
        ),
    ];
    for ((own, own_dissipation), (projected, dissipation)) in pairs {
        for (own, projected) in own.into_iter().zip(projected) {
            assert!((own - projected).abs() < 1e-11 * YOUNG, "{own} {projected}");
        }
        assert!((dissipation / own_dissipation - 1.0).abs() < 1e-9);
    }
}

#[test]
fn without_dilatancy_the_cone_keeps_the_mean_stress() {
    let (angle, elasticity) = (0.5, solid(0.32));
    let associated = ClosestPoint::drucker_prager(elasticity, angle, STRENGTH, angle).unwrap();
    for dilatancy in [0.0, 0.2, 0.5] {
        let cone = ClosestPoint::drucker_prager(elasticity, angle, STRENGTH, dilatancy).unwrap();
        let slope = |angle: f64| 2.0 * 2.0_f64.sqrt() * angle.sin() / (3.0 - angle.sin());
        for trial in grid().filter(|trial| cone.yield_function(*trial) > 0.0) {
            let found = cone.returned(trial);
            assert!(cone.yield_function(found).abs() < 1e-12 * STRENGTH, "{trial:?}");
            let flow = minus(trial, found);
            let volumetric = flow.iter().sum::<f64>() / 3.0_f64.sqrt();
            let mean = flow.iter().sum::<f64>() / 3.0;
            let deviatoric = flow.iter().map(|stress| (stress - mean).powi(2)).sum::<f64>().sqrt();
            let is_apex = found.iter().all(|stress| (stress - found[0]).abs() < 1e-9 * STRENGTH);
            if !is_apex {
                // Δz/Δr = 3k B_ψ/2μ
                let ratio = 3.0 * elasticity.bulk_modulus() * slope(dilatancy) / (2.0 * elasticity.shear_modulus());
                assert!((volumetric - ratio * deviatoric).abs() < 1e-9 * STRENGTH, "{dilatancy} {trial:?}");
            }
            // no other flow dissipates as much distance
            let nearest = associated.energy_norm_squared(minus(trial, associated.returned(trial)));
            assert!(cone.energy_norm_squared(flow) >= nearest * (1.0 - 1e-12));
        }
    }
}

struct Returns<'a, R> {
    surface: &'a ClosestPoint,
    trials: Vec<[R; 3]>,
}

impl<R: Real> Kernel for Returns<'_, R> {
    type Output = Vec<R>;

    #[inline(always)]
    fn run(self) -> Vec<R> {
        self.trials.into_iter().flat_map(|trial| self.surface.returned(trial)).collect()
    }
}

struct AllBits(ClosestPoint);

impl WithLanes for AllBits {
    type Output = Vec<u64>;

    fn with_lanes<R: Real>(self) -> Vec<u64> {
        let all: Vec<[f64; 3]> = grid().collect();
        let chunks = all.chunks_exact(8).flat_map(|eight| eight.chunks_exact(R::LANES));
        let trials = chunks.map(|chunk| [0, 1, 2].map(|i| R::from_lanes(|lane| chunk[lane][i]))).collect();
        let returned = R::vectorize(Returns { surface: &self.0, trials });
        returned
            .chunks_exact(3)
            .flat_map(|point| (0..R::LANES).flat_map(|lane| [0, 1, 2].map(|i| point[i].lane(lane).to_bits())))
            .collect()
    }
}

#[test]
fn every_lane_has_the_bits_of_f64() {
    for (name, surface) in surfaces(solid(0.32)) {
        let alone = dispatch(LaneLevel::Portable, AllBits(surface));
        for level in LaneLevel::ALL.into_iter().filter(|level| level.is_available()) {
            assert!(dispatch(level, AllBits(surface)) == alone, "{name}, {level:?}");
        }
    }
}

#[test]
fn bad_parameters_are_refused_by_name() {
    let elasticity = solid(0.3);
    let refused = |made: Result<ClosestPoint, estar_material::ParameterError>| made.unwrap_err().parameter;
    assert_eq!(refused(ClosestPoint::von_mises(elasticity, 0.0)), "yield_stress");
    assert_eq!(refused(ClosestPoint::rankine(elasticity, -1.0)), "strength");
    assert_eq!(refused(ClosestPoint::mohr_coulomb(elasticity, 0.0, 1.0)), "friction_angle");
    assert_eq!(refused(ClosestPoint::mohr_coulomb(elasticity, 1.6, 1.0)), "friction_angle");
    assert_eq!(refused(ClosestPoint::mohr_coulomb(elasticity, 0.5, f64::NAN)), "cohesion");
    assert_eq!(refused(ClosestPoint::drucker_prager(elasticity, 0.5, 1.0, 0.6)), "dilatancy_angle");
}
