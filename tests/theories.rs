//! Figures of `docs/theories.md` that no single path gives: how the updates of E* differ, how fast each update converges,
//! yield surfaces with the ways of closest-point returns. Each is computed, held to what it must show, and drawn.
//!
//! `ESTAR_UPDATE_DOCS=1 cargo test --release --test theories` draws them anew.

use estar_material::point::{MaterialPoint, drive};
use estar_material::{
    AdiabaticHeating, ClosestPoint, EStar, EStarTotal, Elastic, ElasticConstant, GreenNaghdi, Hencky,
    IsotropicElasticity, IsotropicHardening, JohnsonCook, JohnsonCookParameters, KinematicHardening, Material,
};
use estar_post::plot::{Axis, Curve, Figure, Panel};
use estar_tensor::{SymmetricTensor, Tensor};
use std::path::Path;

const YOUNG: f64 = 200e9;
const YIELD: f64 = 260e6;

fn solid() -> IsotropicElasticity {
    let constants = (ElasticConstant::YoungModulus(YOUNG), ElasticConstant::PoissonRatio(0.32));
    IsotropicElasticity::new(7850.0, constants.0, constants.1).unwrap()
}

fn perfect(yield_stress: f64) -> IsotropicHardening {
    IsotropicHardening::perfect(yield_stress).unwrap()
}

/// Compares a figure with the one that the docs show, or replaces that.
fn assert_shown(name: &str, figure: &Figure) {
    let drawing = figure.drawing();
    let shown = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("docs/figures/{name}.svg"));
    if std::env::var_os("ESTAR_UPDATE_DOCS").is_some() {
        std::fs::write(&shown, drawing.svg()).unwrap();
    }
    let stale = "is stale: ESTAR_UPDATE_DOCS=1 cargo test --release --test theories";
    assert!(std::fs::read_to_string(&shown).unwrap_or_default() == drawing.svg(), "{} {stale}", shown.display());
}

fn axis(label: &str, unit: &str, is_logarithmic: bool) -> Axis {
    Axis { label: label.to_owned(), unit: unit.to_owned(), is_logarithmic }
}

fn size(tensor: &SymmetricTensor<f64>) -> f64 {
    tensor.norm_squared().sqrt()
}

fn simple_shear(gamma: f64) -> Tensor<f64> {
    Tensor::from_rows([[1.0, gamma, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
}

/// Tension at constant volume, ln λ = 0.5 t.
fn tension(t: f64) -> Tensor<f64> {
    let stretch = (0.5 * t).exp();
    SymmetricTensor::diagonal([stretch, stretch.sqrt().recip(), stretch.sqrt().recip()]).to_tensor()
}

#[test]
fn the_two_updates_of_e_star_differ_by_the_elastic_strain() {
    // ‖T_box − T_total‖/‖T_total‖ of solids whose elastic strain at yield is halved again and again
    let gap = |path: fn(f64) -> Tensor<f64>, strain: f64| {
        let law = perfect(strain * YOUNG);
        // steps well below the elastic strain, so that their own error does not show
        let steps = (20.0 / strain) as u32;
        let (rate, total) = (EStar::new(solid(), law.clone(), ()), EStarTotal::new(solid(), law));
        let rate = drive(&rate, path, 1.0, steps, |_, _| ());
        let total = drive(&total, path, 1.0, steps, |_, _| ());
        size(&(*rate.stress() - *total.stress())) / size(total.stress())
    };
    let strains: Vec<f64> = (0..9).map(|halvings| 0.04 * 0.5_f64.powi(halvings)).collect();
    let curve = |label: &str, colour, path: fn(f64) -> Tensor<f64>| {
        let points: Vec<[f64; 2]> = strains.iter().map(|strain| [*strain, gap(path, *strain)]).collect();
        // 0.0013, the solid of the other figures, lies in the midst of the last five
        for pair in points[4..].windows(2) {
            let order = (pair[0][1] / pair[1][1]).log2();
            assert!((order - 1.0).abs() < 0.02, "{label}: order {order} at {:?}", pair[1]);
        }
        Curve { label: label.to_owned(), colour, is_dotted: true, points, ..Curve::default() }
    };
    let curves = vec![
        curve("simple shear to γ = 1", 0, simple_shear),
        curve("tension to ln λ = ½, volume kept", 1, tension),
        Curve {
            label: "slope 1".to_owned(),
            colour: 6,
            dash: 2,
            points: [strains[0], strains[8]].map(|strain| [strain, 2.5 * strain]).to_vec(),
            ..Curve::default()
        },
    ];
    let panel = Panel {
        x: axis("elastic strain at yield σ_{0}/E", "", true),
        y: axis("|T_{box} − T_{total}|/|T_{total}|", "", true),
        curves,
        ..Panel::default()
    };
    assert_shown("updates-gap", &Figure { title: String::new(), panels: vec![panel] });
}

/// Large stretch and shear whose principal directions turn, and a little change of volume, 0 ≤ t ≤ 1.
fn turning(t: f64) -> Tensor<f64> {
    let gradient = Tensor::from_rows([
        [1.0 + 0.25 * t, 0.2 * t, 0.05 * t * t],
        [0.3 * t * t, 1.0 - 0.15 * t, 0.1 * t],
        [0.0, 0.08 * (3.0 * t).sin(), 1.0 - 0.1 * t],
    ]);
    gradient * ((1.0 + 1e-3 * t) / gradient.determinant()).cbrt()
}

/// Steps over the way from t = 0.5 to 0.9, which begins in the midst of flow.
const STEPS: [u32; 6] = [25, 50, 100, 200, 400, 800];
/// Steps that stand for the exact solution.
const REFERENCE: u32 = 51_200;

/// ‖T − T_exact‖/‖T_exact‖ at the end, for each number of steps.
fn errors<M: Material>(material: &M, path: impl Fn(f64) -> Tensor<f64>) -> Vec<[f64; 2]> {
    let start = drive(material, |t| path(0.5 * t), 1.0, 400, |_, _| ());
    let stress = |steps: u32| {
        let mut point: MaterialPoint<'_, M> = start.clone();
        for step in 1..=steps {
            point.advance(&path(0.5 + 0.4 * f64::from(step) / f64::from(steps)), 0.4 / f64::from(steps));
        }
        *point.stress()
    };
    let exact = stress(REFERENCE);
    STEPS.iter().map(|steps| [f64::from(*steps), size(&(stress(*steps) - exact)) / size(&exact)]).collect()
}

#[test]
fn every_update_converges_with_its_order() {
    let hardening = || IsotropicHardening::saturation(YIELD, 500e6, 15.0, 130e6).unwrap();
    let kinematic = KinematicHardening::armstrong_frederick(2e10, 100.0).unwrap();
    let heated = JohnsonCook::new(JohnsonCookParameters {
        a: YIELD,
        b: 400e6,
        n: 0.3,
        c: 0.02,
        m: 0.9,
        reference_rate: 1e-2,
        reference_temperature: 293.15,
        melting_temperature: 1800.0,
    });
    let heating = AdiabaticHeating { specific_heat: 460.0, taylor_quinney: 0.9, initial_temperature: 300.0 };
    let heated = heated.unwrap().with_heating(heating, &solid()).unwrap();
    let cone = ClosestPoint::drucker_prager(solid(), 0.5, YIELD, 0.2).unwrap();
    // proportional flow: nothing turns but the body
    let straight = |t: f64| {
        let turn = estar_tensor::Rotation::<f64>::about([0.1, 0.9, 0.4], 1.5 * t).to_tensor();
        turn.dot(&tension(t))
    };
    let found = [
        ("elastic, box rate", 2.0, errors(&Elastic::new(solid()), turning)),
        ("E* box-rate, flow in one direction", 2.0, errors(&EStar::new(solid(), hardening(), ()), straight)),
        ("E* box-rate", 1.0, errors(&EStar::new(solid(), hardening(), ()), turning)),
        ("E* box-rate, Armstrong-Frederick", 1.0, errors(&EStar::new(solid(), hardening(), kinematic), turning)),
        ("E* total", 1.0, errors(&EStarTotal::new(solid(), hardening()), turning)),
        ("E* total, Johnson-Cook", 1.0, errors(&EStarTotal::new(solid(), heated), turning)),
        ("Hencky", 1.0, errors(&Hencky::von_mises(solid(), hardening()), turning)),
        ("Hencky, Drucker-Prager", 1.0, errors(&Hencky::closest_point(cone), turning)),
        ("Green-Naghdi", 1.0, errors(&GreenNaghdi::new(solid(), hardening()), turning)),
    ];
    let mut panels = [1.0, 2.0].map(|order| Panel {
        x: axis("steps", "", true),
        y: axis(&format!("error of the stress, order {order}"), "", true),
        ..Panel::default()
    });
    for (label, order, points) in found {
        let [.., coarse, fine] = points[..] else { unreachable!("six numbers of steps") };
        let seen = (coarse[1] / fine[1]).log2();
        println!("{label}: order {seen:.3}, error {:.2e} in {} steps", fine[1], fine[0]);
        assert!(seen > order - 0.05, "{label}: order {seen}");
        let curves = &mut panels[order as usize - 1].curves;
        let place = curves.len();
        curves.push(Curve {
            label: label.to_owned(),
            colour: place,
            dash: place,
            is_dotted: true,
            points,
            ..Curve::default()
        });
    }
    assert_shown("convergence", &Figure { title: String::new(), panels: panels.to_vec() });
}

/// The surfaces of the closest-point return, all of the same strength in uniaxial tension but for Mohr-Coulomb's own.
fn surfaces() -> [(&'static str, ClosestPoint); 4] {
    [
        ("von Mises", ClosestPoint::von_mises(solid(), YIELD).unwrap()),
        ("Rankine", ClosestPoint::rankine(solid(), YIELD).unwrap()),
        ("Drucker-Prager", ClosestPoint::drucker_prager(solid(), 0.5, YIELD, 0.5).unwrap()),
        ("Mohr-Coulomb", ClosestPoint::mohr_coulomb(solid(), 0.5, YIELD).unwrap()),
    ]
}

/// The order that sorts principal stresses, the largest first.
fn sorting(stress: [f64; 3]) -> [usize; 3] {
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| stress[*b].total_cmp(&stress[*a]));
    order
}

fn yield_function(surface: &ClosestPoint, stress: [f64; 3]) -> f64 {
    surface.yield_function(sorting(stress).map(|i| stress[i]))
}

fn returned(surface: &ClosestPoint, stress: [f64; 3]) -> [f64; 3] {
    let order = sorting(stress);
    let found = surface.returned(order.map(|i| stress[i]));
    let mut back = [0.0; 3];
    for (place, value) in order.into_iter().zip(found) {
        back[place] = value;
    }
    back
}

/// A plane of principal stresses: from places (MPa) to stresses (Pa) and back.
struct Plane {
    stress: fn([f64; 2]) -> [f64; 3],
    place: fn([f64; 3]) -> [f64; 2],
    /// A place inside every surface.
    inside: [f64; 2],
}

/// √(2μ/3k): it makes the energy norm Euclidean in (z, r).
fn volumetric_scale() -> f64 {
    (2.0 * solid().shear_modulus() / (3.0 * solid().bulk_modulus())).sqrt()
}

/// σ₂ = σ₃: x = z √(2μ/3k), y = ±r with the Lode coordinates z = tr σ/√3 and r = √⅔ (σ₁ − σ₂).
const RENDULIC: Plane = Plane {
    stress: |[x, y]| {
        let (mean, deviator) = (1e6 * x / volumetric_scale() / 3_f64.sqrt(), 1e6 * y);
        [mean + deviator * (2.0_f64 / 3.0).sqrt(), mean - deviator / 6_f64.sqrt(), mean - deviator / 6_f64.sqrt()]
    },
    place: |stress| {
        let z = stress.iter().sum::<f64>() / 3_f64.sqrt();
        let r = (2.0_f64 / 3.0).sqrt() * (stress[0] - 0.5 * (stress[1] + stress[2]));
        [1e-6 * z * volumetric_scale(), 1e-6 * r]
    },
    inside: [-150.0, 0.0],
};

/// Mean stress of the deviatoric plane, Pa.
const MEAN: f64 = -100e6;

/// tr σ = 3 × [`MEAN`]: the axes of σ₁, σ₂, σ₃ at 90°, 210° and 330°.
const DEVIATORIC: Plane = Plane {
    stress: |[x, y]| {
        let axis = |angle: f64| {
            let (sine, cosine) = angle.to_radians().sin_cos();
            MEAN + 1e6 * (2.0_f64 / 3.0).sqrt() * (x * cosine + y * sine)
        };
        [axis(90.0), axis(210.0), axis(330.0)]
    },
    place: |stress| {
        let along = |part: fn(f64) -> f64| {
            let sum: f64 =
                [90_f64, 210.0, 330.0].iter().zip(stress).map(|(angle, s)| s * part(angle.to_radians())).sum();
            1e-6 * (2.0_f64 / 3.0).sqrt() * sum
        };
        [along(f64::cos), along(f64::sin)]
    },
    inside: [0.0, 0.0],
};

/// The outline of a surface, as far as `reach` (MPa).
fn outline(surface: &ClosestPoint, plane: &Plane, reach: f64) -> Vec<[f64; 2]> {
    const RAYS: usize = 1440;
    let ray = |index: usize| {
        let (sine, cosine) = (std::f64::consts::TAU * index as f64 / RAYS as f64).sin_cos();
        let at = |radius: f64| [plane.inside[0] + radius * cosine, plane.inside[1] + radius * sine];
        let is_inside = |radius: f64| yield_function(surface, (plane.stress)(at(radius))) <= 0.0;
        if is_inside(reach) {
            return [f64::NAN; 2];
        }
        let (mut low, mut high) = (0.0, reach);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if is_inside(middle) { low = middle } else { high = middle }
        }
        at(low)
    };
    (0..=RAYS).map(ray).collect()
}

/// A panel with the outline of a surface and the ways of trial stresses to their closest points.
fn panel(name: &str, surface: &ClosestPoint, plane: &Plane, trials: &[[f64; 2]], labels: [&str; 2]) -> Panel {
    let mut ways = Vec::new();
    for trial in trials {
        let stress = (plane.stress)(*trial);
        if yield_function(surface, stress) <= 0.0 {
            continue;
        }
        let found = returned(surface, stress);
        assert!(yield_function(surface, found).abs() < 1e-6 * YIELD, "{name}: {stress:?}");
        ways.extend([*trial, (plane.place)(found), [f64::NAN; 2]]);
    }
    let outline = outline(surface, plane, 900.0);
    let curves = vec![
        Curve { label: format!("{name}: surface"), points: outline, ..Curve::default() },
        Curve {
            label: "from trial to closest point".to_owned(),
            colour: 1,
            dash: 1,
            is_dotted: true,
            points: ways,
            ..Curve::default()
        },
    ];
    Panel { x: axis(labels[0], "MPa", false), y: axis(labels[1], "MPa", false), is_isometric: true, curves }
}

#[test]
fn closest_point_returns_meet_their_surfaces_in_both_planes() {
    let grid = |from: i32, to: i32| (from..=to).map(|k| 160.0 * f64::from(k));
    let rendulic: Vec<[f64; 2]> = grid(-2, 3).flat_map(|x| grid(-3, 3).map(move |y| [x, y])).collect();
    let panels = surfaces().map(|(name, surface)| panel(name, &surface, &RENDULIC, &rendulic, ["√(2μ/3k) z", "±r"]));
    assert_shown("surfaces-rendulic", &Figure { title: String::new(), panels: panels.to_vec() });

    // outside by half of the way from the middle
    let panels = surfaces().map(|(name, surface)| {
        let trials: Vec<[f64; 2]> = outline(&surface, &DEVIATORIC, 900.0)
            .iter()
            .skip(20)
            .step_by(40)
            .map(|place| place.map(|c| 1.5 * c))
            .collect();
        panel(name, &surface, &DEVIATORIC, &trials, ["deviatoric plane", "σ_{1} axis"])
    });
    assert_shown("surfaces-deviatoric", &Figure { title: String::new(), panels: panels.to_vec() });
}
