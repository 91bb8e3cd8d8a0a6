//! Goal: a slow process stays slow whatever its body is: a strip in bending is paced by its own slowest vibration, curves do what the
//! deck says, and what is not slow is told.
//!
//! Mesh: a strip of 20 × 2 × 2 mm, one end held, the other moved across by 0.2 mm. Source: Timoshenko's beam,
//! F = 3 E I δ/L³ / (1 + 3 E I/(κ G A L²)); the frequency of Euler and Bernoulli's, (1.8751/L)² √(E I/(ρ A))/2π.

mod common;

use common::{Said, Workshop};

const LENGTH: f64 = 20e-3;
const SIDE: f64 = 2e-3;
const YOUNG: f64 = 200e9;
const STROKE: f64 = 0.2e-3;

const STRIP: &str = r#"
[mesh]
file = "strip.msh"

[material.steel]
theory = "elastic"
density = "7850 kg/m^3"
young_modulus = "200 GPa"
poisson_ratio = 0.0

[[part]]
group = "box"
material = "steel"
element = "hex8-one-point"

[[fix]]
group = "x_min"
directions = ["x", "y", "z"]

[[prescribed]]
group = "x_max"
direction = "z"
quantity = "displacement"
curve = CURVE

[time]
end = "1 s"
quasi_static = SLOWLY

[output]
frames = 1

[[probe]]
name = "force"
kind = "reaction"
group = "x_max"
direction = "z"

[[probe]]
name = "deflection"
kind = "group-average"
group = "x_max"
field = "displacement"
component = "z"

[[probe]]
name = "speed"
kind = "group-average"
group = "x_max"
field = "velocity"
component = "z"
"#;

const STRAIGHT: &str = "[[0, 0], [\"1 s\", \"0.2 mm\"]]";

/// Fifty straight lines on one.
fn fifty() -> String {
    let points = (0..=50).map(|i| format!("[{:.2}, {:.6}]", 0.02 * f64::from(i), STROKE / 50.0 * f64::from(i)));
    format!("[{}]", points.collect::<Vec<_>>().join(", "))
}

struct Bending(Workshop);

impl Bending {
    fn new() -> Self {
        let workshop = Workshop::new();
        let size = ["--size", "20mm", "2mm", "2mm", "--cells", "10", "1", "2"];
        workshop.estar(&[&["mesh", "box", "--output", "strip.msh"], &size[..]].concat()).assert(0, &[]);
        Self(workshop)
    }

    fn deck(curve: &str, slowly: &str) -> String {
        STRIP.replace("CURVE", curve).replace("SLOWLY", slowly)
    }

    fn run(&self, curve: &str, slowly: &str) -> Said {
        self.0.run_deck(&Self::deck(curve, slowly), &[])
    }

    fn check(&self, curve: &str) -> Said {
        self.0.write("deck.toml", &Self::deck(curve, "{}"));
        self.0.estar(&["check", "deck.toml"])
    }

    /// Columns of history.csv.
    fn columns<const N: usize>(&self, names: [&str; N]) -> Vec<[f64; N]> {
        let text = self.0.read("deck/history.csv");
        let mut lines = text.lines();
        let head: Vec<&str> = lines.next().unwrap().split(',').collect();
        let places = names.map(|name| head.iter().position(|column| *column == name).unwrap());
        let row = |line: &str| {
            let cells: Vec<&str> = line.split(',').collect();
            places.map(|place| cells[place].parse().unwrap())
        };
        lines.map(row).collect()
    }

    /// The largest deviation of the force from the stiffness of the beam times the deflection, over the largest force.
    fn largest_deviation(&self) -> f64 {
        let rows = self.columns(["force", "deflection"]);
        let [last_force, last_deflection] = *rows.last().unwrap();
        let deviation = |[force, deflection]: &[f64; 2]| (force - deflection * last_force / last_deflection).abs();
        rows.iter().map(deviation).fold(0.0, f64::max) / last_force.abs()
    }
}

#[test]
fn strip_in_bending_is_slow_without_any_choice() {
    let bending = Bending::new();
    let said = bending.run(STRAIGHT, "{}");
    said.assert(0, &[]);
    assert!(!said.errors.contains("taken for quasi-static"), "{}", said.errors);
    let summary = bending.0.summary();
    let number = |name: &str| summary["quasi_static"][name].as_f64().unwrap();
    // I/A = h²/12
    let slowest =
        (1.875_104 / LENGTH).powi(2) * (YOUNG / 7850.0).sqrt() * SIDE / 12.0_f64.sqrt() / std::f64::consts::TAU;
    let found = number("natural_frequency");
    let kinetic = number("largest_kinetic_over_internal");
    let damping = number("damping_over_external_work");
    let inertia = SIDE.powi(4) / 12.0;
    let of_bending = 3.0 * YOUNG * inertia * STROKE / LENGTH.powi(3);
    // G = E/2, κ = 5/6
    let shear = 3.0 * inertia / (5.0 / 6.0 * 0.5 * SIDE * SIDE * LENGTH * LENGTH);
    let (force, exact) = (summary["probes"]["force"].as_f64().unwrap(), of_bending / (1.0 + shear));
    println!(
        "{found:.1} Hz, beam {slowest:.1} Hz; {force:.2} N, beam {exact:.2} N; kinetic {kinetic:.4}, damping {damping:.5}"
    );
    assert!((found / slowest - 1.0).abs() < 0.02, "{found} {slowest}");
    assert!(kinetic < 0.02, "{kinetic}");
    assert!(damping < 0.005, "{damping}");
    assert!((force / exact - 1.0).abs() < 0.03, "{force} {exact}");
    assert!(bending.largest_deviation() < 0.01, "{}", bending.largest_deviation());
    assert!(said.text.contains("half periods of the lowest natural frequency"), "{}", said.text);
}

#[test]
fn curve_of_many_points_neither_stops_nor_starts_with_a_blow() {
    let bending = Bending::new();
    bending.run(&fifty(), "{}").assert(0, &[]);
    let deviation = bending.largest_deviation();
    let rows = bending.columns(["time", "speed"]);
    let speed =
        |from: f64, to: f64| rows.iter().filter(move |[time, _]| (from..to).contains(time)).map(|[_, speed]| *speed);
    println!("deviation {deviation:.4}");
    assert!(deviation < 0.01, "{deviation}");
    assert!(speed(0.05, 0.95).all(|speed| (speed / STROKE - 1.0).abs() < 0.01), "it stops on its way");
    assert!(rows[0][1].abs() < 0.01 * STROKE && rows[1][1] < 0.1 * STROKE, "{:?}", &rows[..2]);
}

#[test]
fn chosen_interpolation_is_kept_in_a_slow_process() {
    let bending = Bending::new();
    let slowly = "{ transits = 10 }";
    let speeds = |interpolation: &str| {
        bending.run(&format!("{}\ninterpolation = \"{interpolation}\"", fifty()), slowly).assert(0, &[]);
        let rows = bending.columns(["time", "speed"]);
        rows.into_iter()
            .filter(|[time, _]| (0.005..0.995).contains(time))
            .map(|[_, speed]| speed / STROKE)
            .collect::<Vec<_>>()
    };
    assert!(speeds("linear").iter().all(|speed| (speed - 1.0).abs() < 0.01));
    let smooth = speeds("smooth");
    assert!(
        smooth.iter().any(|speed| *speed < 0.1) && smooth.iter().any(|speed| *speed > 1.7),
        "it stops at each point"
    );
}

#[test]
fn damping_that_takes_much_of_the_work_is_told() {
    let bending = Bending::new();
    let said = bending.run(STRAIGHT, "{ transits = 20, damping = 1.0 }");
    said.assert(0, &["warning: damping took", "of the external work, where up to 2 %"]);
    let summary = bending.0.summary();
    let share = summary["quasi_static"]["damping_over_external_work"].as_f64().unwrap();
    let [damping, work] = ["damping_energy", "external_work"].map(|name| summary["energies"][name].as_f64().unwrap());
    assert!(share > 0.02 && (share - damping / work).abs() < 1e-12, "{share}");
    assert!(bending.0.read("deck/estar.log").contains("warning: damping took"));
}

#[test]
fn process_that_is_too_fast_is_told_its_frequency() {
    let bending = Bending::new();
    bending.0.write("deck.toml", &Bending::deck(&STRAIGHT.replace("1 s", "1 ms"), "{}").replace("\"1 s\"", "\"1 ms\""));
    let said = bending.0.estar(&["check", "deck.toml"]);
    said.assert(
        2,
        &["too fast for `time.quasi_static`", "half periods of the slowest vibration", "Hz", "a later `time.end`"],
    );
    bending.run(STRAIGHT, "{ transits = 9 }").assert(2, &["`time.quasi_static.transits` must be 10 or greater"]);
}

#[test]
fn body_with_a_hinge_is_paced_by_waves_with_a_word() {
    let workshop = Workshop::new();
    // two bricks that share an edge
    let mesh = "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 1, 1, 0\n4, 0, 1, 0\n5, 0, 0, 1\n6, 1, 0, 1\n7, 1, 1, 1\n8, 0, 1, 1\n\
                9, 2, 1, 0\n10, 2, 2, 0\n11, 1, 2, 0\n12, 2, 1, 1\n13, 2, 2, 1\n14, 1, 2, 1\n\
                *ELEMENT, TYPE=C3D8, ELSET=box\n1, 1, 2, 3, 4, 5, 6, 7, 8\n2, 3, 9, 10, 11, 7, 12, 13, 14\n*NSET, NSET=x_min\n1, 4, 5, 8\n*NSET, NSET=x_max\n9, 10, 12, 13\n";
    workshop.write("strip.inp", mesh);
    workshop.write("deck.toml", &Bending::deck(STRAIGHT, "{}").replace("strip.msh", "strip.inp"));
    let said = workshop.estar(&["check", "deck.toml"]);
    said.assert(
        0,
        &["warning: the body can move in itself without any stiffness", "waves along the body set the pace"],
    );
    assert!(said.text.contains("passes of a wave"), "{}", said.text);
}

#[test]
fn displacement_that_jumps_is_refused_at_any_time() {
    let bending = Bending::new();
    let jumps = [
        // within a step, a tenth of an element in less, and faster than a wave for long
        "[[0, 0], [0.5, 0], [0.500000001, 1e-4], [1, 1e-4]]",
        "[[0, 0], [0.25, 1e-5], [0.250000000001, 2e-4]]",
        "[[0, 0], [0.5, 0.0], [0.501, 0.5]]",
        // a jump at time 0 is refused from 1e-4 of the largest value on, however small it is
        "[[0, 0], [0.5, 0], [0.500000001, 1e-7], [1, 1e-7]]",
    ];
    for curve in jumps {
        for interpolation in ["", "\ninterpolation = \"linear\"", "\ninterpolation = \"smooth\""] {
            let curve = format!("{curve}{interpolation}");
            for said in [bending.check(&curve), bending.run(&curve, "{}")] {
                said.assert(
                    2,
                    &["the prescribed displacement jumps by", "deck.toml:", "a step is about", "let it take longer"],
                );
            }
        }
    }
    let at_start = bending.check("[[0, 1e-4], [1, 2e-4]]");
    at_start.assert(2, &["the prescribed displacement jumps to"]);
    let twice = bending.check("[[0, 0], [0.5, 0], [0.5, 1e-4]]");
    twice.assert(2, &["must increase"]);
    // data of a fine clock do not jump
    let points: Vec<String> =
        (0..=20_000).map(|i| format!("[{:.9}, {:.12}]", 5e-5 * f64::from(i), 1e-8 * f64::from(i))).collect();
    bending.check(&format!("[{}]", points.join(", "))).assert(0, &[]);
    // a tool jumps, too
    let tool = "\n[[rigid_wall]]\npoint = [0, 0, \"1 cm\"]\nnormal = [0, 0, -1]\nmotion = { direction = [0, 0, 1], quantity = \
                \"displacement\", curve = [[0, 0], [0.5, 0], [0.500000001, \"0.05 mm\"]] }\n";
    bending.0.write("deck.toml", &format!("{}{tool}", Bending::deck(STRAIGHT, "{}")));
    bending.0.estar(&["check", "deck.toml"]).assert(2, &["the prescribed displacement jumps by"]);
}
