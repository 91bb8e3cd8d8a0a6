//! The deck: what is read, and what a user is told about what cannot be read.

use estar_deck::diagnostics::Diagnostics;
use estar_deck::{self as deck, Reading};
use estar_session::output_plan;
use estar_solver::model::WallShape;
use std::path::Path;

const GOOD: &str = r#"
title = "Taylor bar"

[mesh]
file = "taylor.msh"
scale = 1e-3

[material.copper]
theory = "e-star"
density = 8930.0
young_modulus = "117 GPa"
poisson_ratio = 0.35
hardening = { law = "linear", yield_stress = "400 MPa", modulus = "100 MPa" }

[[part]]
group = "bar"
material = "copper"

[[initial_velocity]]
group = "bar"
value = [0.0, 0.0, "-227 m/s"]

[[fix]]
group = "symmetry_x"
directions = ["x"]

[[rigid_wall]]
point = [0.0, 0.0, 0.0]
normal = [0.0, 0.0, 2.0]

[time]
end = "80 us"

[[probe]]
name = "length"
kind = "extent"
group = "bar"
axis = "z"

[[expect]]
probe = "length"
value = "21.42 mm"
tolerance = "0.3 %"
"#;

fn read(text: &str) -> Reading {
    deck::read(Path::new("deck.toml"), text, &[])
}

/// What a user is told about a deck.
fn told(text: &str) -> String {
    let reading = read(text);
    reading.decoder.diagnostics.render(&reading.sources, false).to_string()
}

/// What a user is told about the good deck after one replacement.
fn told_after(from: &str, to: &str) -> String {
    assert!(GOOD.contains(from), "{from}");
    told(&GOOD.replacen(from, to, 1))
}

#[track_caller]
fn assert_told(told: &str, parts: &[&str]) {
    for part in parts {
        assert!(told.contains(part), "no {part:?} in\n{told}");
    }
}

#[test]
fn good_deck_is_read_in_si_units() {
    let reading = read(GOOD);
    assert_eq!(told(GOOD), "");
    let deck = reading.deck.unwrap();
    assert_eq!(deck.time.end.value, 80e-6);
    assert_eq!(deck.initial_velocity[0].value.unwrap().value, [0.0, 0.0, -227.0]);
    let plane = WallShape::Plane { point: [0.0; 3], normal: [0.0, 0.0, 1.0] };
    assert_eq!(deck.rigid_wall[0].surface.shape(), plane);
    assert_eq!(deck.expect[0].value.value.0.value, 21.42e-3);
    assert_eq!(deck.material.0[0].1.elasticity().density(), 8930.0);
}

#[test]
fn a_tool_has_a_shape_a_roughness_and_a_motion() {
    let tool = |keys: &str| read(&GOOD.replacen("normal = [0.0, 0.0, 2.0]", keys, 1));
    let of = |keys: &str| {
        let reading = tool(keys);
        let told = reading.decoder.diagnostics.render(&reading.sources, false).to_string();
        (reading.deck.map(|deck| deck.rigid_wall[0].clone()), told)
    };
    let roller =
        "shape = \"cylinder\"\naxis = [0, 3, 0]\nradius = \"5 mm\"\nfriction = \"sticking\"\nname = \"roller\"\n";
    let motion = "motion = { direction = [0, 0, -2], quantity = \"velocity\", curve = [[0, \"1 m/s\"]] }";
    let (wall, told) = of(&format!("{roller}{motion}"));
    assert_eq!(told, "");
    let wall = wall.unwrap();
    assert_eq!(wall.surface.shape(), WallShape::Cylinder { point: [0.0; 3], axis: [0.0, 1.0, 0.0], radius: 5e-3 });
    assert_eq!(wall.friction.0, f64::INFINITY);
    assert_eq!(wall.motion.unwrap().direction.0, [0.0, 0.0, -1.0]);

    let faults = [
        ("normal = [0, 0, 1]\nradius = 1.0", "belongs to"),
        ("shape = \"cone\"", "the choices are"),
        ("shape = \"cylinder\"\naxis = [0, 0, 1]", "lacks `radius`"),
        ("shape = \"cylinder\"\naxis = [0, 0, 0]\nradius = 1.0", "axis"),
        ("shape = \"cylinder\"\naxis = [0, 0, 1]\nradius = 0.0", "must be greater than 0"),
        ("normal = [0, 0, 1]\nfriction = -0.1", "friction"),
        ("normal = [0, 0, 1]\nfriction = \"stuck\"", "friction"),
        ("normal = [0, 0, 1]\nmotion = { direction = [0, 0, 1] }", "lacks `quantity`"),
    ];
    for (keys, part) in faults {
        let (wall, told) = of(keys);
        assert!(wall.is_none(), "{keys}");
        assert_told(&told, &[part]);
    }
}

#[test]
fn probes_of_contact_name_a_wall_that_is_there() {
    let probe = |name: &str| {
        let named = GOOD.replacen("[[rigid_wall]]", "[[rigid_wall]]\nname = \"anvil\"", 1);
        told(&format!(
            "{named}\n[[probe]]\nname = \"force\"\nkind = \"contact-force\"\nwall = \"{name}\"\ndirection = \"z\"\n"
        ))
    };
    assert_eq!(probe("anvil"), "");
    assert_told(&probe("anvill"), &["there is no rigid wall `anvill`", "did you mean \"anvil\"?"]);
}

#[test]
fn mass_scaling_and_damping_have_their_bounds() {
    let time = |keys: &str| told_after("end = \"80 us\"", &format!("end = \"80 us\"\n{keys}"));
    assert_eq!(time("mass_scaling = { target_time_step = \"1e-8 s\", limit = 0.05 }"), "");
    assert_eq!(time("quasi_static = {}\nmass_damping = 0.0"), "");
    assert_told(&time("mass_scaling = { factor = 0.5 }"), &["must be 1 or greater"]);
    assert_told(&time("mass_scaling = { target_time_step = 0.0 }"), &["greater than 0"]);
    assert_told(&time("mass_scaling = { target_time_steps = 1e-8 }"), &["did you mean `target_time_step`?"]);
    assert_told(&time("mass_damping = -1.0"), &["mass_damping"]);
    assert_told(&time("quasi_static = { transits = 9.9 }"), &["`time.quasi_static.transits` must be 10 or greater"]);
    assert_told(&time("quasi_static = { damping = 2.0 }"), &["damping"]);
}

#[test]
fn windows_line_ends_and_tabs_change_nothing() {
    assert_eq!(told(&GOOD.replace('\n', "\r\n")), "");
    assert_eq!(told(&GOOD.replace(" = ", "\t=\t")), "");
    let told = told(&GOOD.replace('\n', "\r\n").replace("8930.0", "\"heavy\""));
    assert_told(&told, &["deck.toml:10:11", "density = \"heavy\"", "^^^^^^^"]);
}

#[test]
fn all_faults_are_told_at_once_each_with_its_place() {
    let text = GOOD
        .replace("density = 8930.0", "densty = 8930.0")
        .replace("\"80 us\"", "\"80 mm\"")
        .replace("axis = \"z\"", "axis = \"w\"")
        .replace("normal = [0.0, 0.0, 2.0]", "normal = [0, 0, 0]")
        .replace("probe = \"length\"", "probe = \"lenght\"");
    assert_told(
        &told(&text),
        &[
            "unknown key `densty` in `material.copper`",
            "did you mean `density`?",
            "`material.copper` lacks `density`",
            "`time.end` must be a time, not a length",
            "\"80 us\"",
            "`probe.axis` cannot be \"w\"",
            "the choices are `x`, `y`, `z`",
            "must have a direction",
            "there is no probe `lenght`",
            "did you mean \"length\"?",
            "6 errors in the input",
        ],
    );
}

#[test]
fn a_broken_grammar_is_told_with_its_line() {
    let told = told_after("end = \"80 us\"", "end = 80 us");
    assert_told(&told, &["deck.toml:32:7", "end = 80 us", "a number with a unit is a string: \"80 us\""]);
    let list = told_after("point = [0.0, 0.0, 0.0]", "point = [0.0, 0.0, 5 mm]");
    assert_told(&list, &["a number with a unit is a string: \"5 mm\""]);
    let name = told_after("theory = \"e-star\"", "theory = e-star");
    assert_told(&name, &["strings stand in quotes: \"e-star\""]);
    assert_told(&self::told("a = 1\na = 2\n"), &["deck.toml:2:1", "duplicate key"]);
}

#[test]
fn an_empty_deck_lacks_what_every_deck_needs() {
    let told = told("");
    assert_told(&told, &["lacks `mesh`", "lacks `material`", "lacks `part`", "lacks `time`", "4 errors"]);
}

#[test]
fn wrong_types_say_what_is_needed() {
    assert_told(&told_after("density = 8930.0", "density = [1]"), &["`material.copper.density` must be", "not a list"]);
    assert_told(
        &told_after("directions = [\"x\"]", "directions = \"x\""),
        &["`fix.directions` must be a list", "directions = [\"x\"]"],
    );
    assert_told(&told_after("[[part]]", "[part]"), &["`part` must be a list of tables, each headed [[part]]"]);
    assert_told(&told_after("[0.0, 0.0, \"-227 m/s\"]", "[0.0, 1.0]"), &["must have three components, not 2"]);
    assert_told(&told_after("title = \"Taylor bar\"", "title = 2024-01-01"), &["must be a string, not a date"]);
}

#[test]
fn units_are_checked_and_suggested() {
    assert_told(&told_after("117 GPa", "117 Gpa"), &["the unit `Gpa` is not known", "did you mean `GPa`?"]);
    assert_told(&told_after("117 GPa", "117 GPa/s"), &["must be a stress, not a quantity in m^-1*kg^1*s^-3"]);
    assert_told(&told_after("117 GPa", "117,5 GPa"), &["the decimal sign is a point"]);
    assert_told(&told_after("\"117 GPa\"", "nan"), &["must be a finite number"]);
    assert_told(&told_after("\"117 GPa\"", "\"1e999 GPa\""), &["must be a finite number"]);
}

#[test]
fn units_are_read_as_people_write_them() {
    for unit in ["117 N/mm2", "117e3 N/mm**2", "117000 N/mm²", "1.17e5N/mm2"] {
        let reading = read(&GOOD.replacen("117 GPa", unit, 1));
        assert!(reading.deck.is_some(), "{unit}");
    }
    let reading = read(&GOOD.replacen("117 GPa", "117000 N/mm2", 1).replacen("80 us", "80us", 1));
    let deck = reading.deck.unwrap();
    let elasticity = |deck: &deck::Deck| deck.material.0[0].1.elasticity();
    assert_eq!(elasticity(&deck), elasticity(&read(GOOD).deck.unwrap()));
    assert_eq!(deck.time.end.value, 80e-6);
}

#[test]
fn words_of_other_codes_are_answered_with_what_there_is_instead() {
    let part = |key: &str| told_after("material = \"copper\"", &format!("material = \"copper\"\n{key}"));
    assert_told(&part("element = \"C3D8R\""), &["cannot be \"C3D8R\"", "\"hex8-one-point\"", "1 error "]);
    assert_told(&part("element = \"C3D10M\""), &["\"tet10\""]);
    assert_told(&part("element = \"S4R\""), &["no shells"]);
    assert_told(&part("elform = 2"), &["unknown key `elform`", "element = \"hex8-f-bar\""]);
    let theory = |name: &str| told_after("theory = \"e-star\"", &format!("theory = \"{name}\""));
    assert_told(&theory("johnson-cook"), &["law of hardening", "law = \"johnson-cook\""]);
    assert_told(&theory("MAT_024"), &["law = \"tabulated\""]);
    let top = |addition: &str| told(&format!("{addition}\n{GOOD}"));
    assert_told(&top("units = \"mm\""), &["unknown key `units`", "SI units", "scale = 1e-3"]);
    let table = |addition: &str| told(&format!("{GOOD}\n{addition}"));
    assert_told(&table("[[contact]]\nfriction = 0.1"), &["unknown key `contact`", "[[rigid_wall]]"]);
    assert_told(&table("[boundary]"), &["[[fix]]", "[[prescribed]]"]);
    let pull =
        "[[prescribed]]\ngroup = \"top\"\ndirection = \"z\"\nquantity = \"displacement\"\ncurve = \"disp.csv\"\n";
    assert_told(&table(pull), &["must be a list of points [time, value], not a string", "curve = [[0.0, 0.0], ...]"]);
    let listed = pull.replace("\"z\"", "[\"z\"]").replace("\"disp.csv\"", "[[0, 0], [1, 0]]");
    assert_told(&table(&listed), &["one name, without brackets: \"z\""]);
    // a word that nobody knows is answered with the choices, as ever
    assert_told(&part("element = \"hex9\""), &["did you mean \"hex8\"?", "the choices are"]);
}

#[test]
fn deck_of_the_other_kind_is_told_its_command() {
    let point = "[material.copper]\ntheory = \"elastic\"\n[path]\nsteps = 10\n";
    let told = told(point);
    assert_told(&told, &["this is the deck of a material point", "run it by `estar point deck.toml`", "1 error "]);
    let reading = deck::read_point(Path::new("deck.toml"), GOOD, &[]);
    let told = reading.decoder.diagnostics.render(&reading.sources, false).to_string();
    assert_told(&told, &["this is the deck of a simulation", "run it by `estar run deck.toml`", "1 error "]);
}

#[test]
fn material_bounds_are_told_at_the_parameter() {
    let negative = told_after("density = 8930.0", "density = -1");
    assert_told(&negative, &["deck.toml:10:11", "`material.copper.density` must be greater than 0"]);
    let incompressible = told_after("poisson_ratio = 0.35", "poisson_ratio = 0.5");
    assert_told(&incompressible, &["deck.toml:12:17", "between -1 and 0.5"]);
    let softening = told_after("modulus = \"100 MPa\"", "modulus = \"-100 MPa\"");
    assert_told(&softening, &["deck.toml:13:", "material.copper.hardening.modulus"]);
    let three = told_after("poisson_ratio = 0.35", "poisson_ratio = 0.35\nbulk_modulus = 1e11");
    assert_told(&three, &["needs two elastic constants, but has `young_modulus`, `poisson_ratio`, `bulk_modulus`"]);
    let together = told_after("poisson_ratio = 0.35", "shear_modulus = \"1 GPa\"");
    assert_told(&together, &["together must give a positive shear modulus and bulk modulus"]);
    // one fault of a material hides no other
    let faults =
        GOOD.replace("density = 8930.0", "density = -1").replace("poisson_ratio = 0.35", "poisson_ratio = 0.5");
    let all = told(&faults.replace("hardening = {", "hardning = {"));
    assert_told(&all, &["density` must be", "poisson_ratio` must be", "lacks `hardening`", "4 errors"]);
}

#[test]
fn keys_of_another_choice_are_told_where_they_belong() {
    let told = told_after("law = \"linear\"", "law = \"perfect\"");
    assert_told(&told, &["unknown key `modulus` in `material.copper.hardening`", "belongs to law = \"linear\""]);
    let told = told_after("theory = \"e-star\"", "theory = \"rubber\"");
    assert_told(
        &told,
        &[
            "cannot be \"rubber\"",
            "the choices are `e-star`, `green-naghdi`, `hencky`, `plastic-metric`, `elastic`",
            "1 error ",
        ],
    );
    let told = told_after("kind = \"extent\"", "kind = \"extend\"");
    assert_told(&told, &["did you mean \"extent\"?", "1 error "]);
}

#[test]
fn the_total_update_refuses_kinematic_hardening() {
    let told = told_after(
        "poisson_ratio = 0.35",
        "poisson_ratio = 0.35\nupdate = \"total\"\nkinematic = { law = \"prager\", modulus = \"1 GPa\" }",
    );
    assert_told(&told, &["no kinematic hardening", "use update = \"box-rate\""]);
}

const JOHNSON_COOK: &str = "hardening = { law = \"johnson-cook\", a = \"90 MPa\", b = \"292 MPa\", n = 0.31, c = 0.025, m = 1.09, \
                            reference_rate = \"1 1/s\", reference_temperature = \"20 degC\", melting_temperature = \"1083 degC\" }\n\
                            specific_heat = \"383 J/(kg K)\"";

/// What a user is told about the good deck with the theory, the law and the keys of another material.
fn told_with(theory: &str, hardening: &str) -> String {
    let old = "hardening = { law = \"linear\", yield_stress = \"400 MPa\", modulus = \"100 MPa\" }";
    told(&GOOD.replacen(old, hardening, 1).replacen("theory = \"e-star\"", theory, 1))
}

#[test]
fn johnson_cook_is_read_where_a_theory_has_it() {
    for theory in ["theory = \"e-star\"", "theory = \"e-star\"\nupdate = \"total\"", "theory = \"hencky\""] {
        assert_eq!(told_with(theory, JOHNSON_COOK), "");
        assert_eq!(
            told_with(theory, &format!("{JOHNSON_COOK}\ntaylor_quinney = 0.0\ninitial_temperature = 300.0")),
            ""
        );
    }
    for theory in [
        "theory = \"green-naghdi\"",
        "theory = \"plastic-metric\"\nflow_rule = \"lion\"",
        "theory = \"hencky\"\nyield_surface = { kind = \"rankine\" }",
    ] {
        assert_told(&told_with(theory, JOHNSON_COOK), &["no law that knows rate and temperature", "e-star and hencky"]);
    }
    let kinematic = format!("{JOHNSON_COOK}\nkinematic = {{ law = \"prager\", modulus = \"1 GPa\" }}");
    assert_told(
        &told_with("theory = \"e-star\"", &kinematic),
        &["\"johnson-cook\" has no kinematic hardening", "^^^^^^^^^"],
    );
}

#[test]
fn parameters_of_johnson_cook_are_checked_each_at_its_place() {
    let after = |from: &str, to: &str| {
        assert!(JOHNSON_COOK.contains(from), "{from}");
        told_with("theory = \"e-star\"", &JOHNSON_COOK.replacen(from, to, 1))
    };
    assert_told(&after("n = 0.31", "n = 1.5"), &["`material.copper.hardening.n` must be greater than 0 and at most 1"]);
    assert_told(&after("m = 1.09, ", ""), &["`material.copper.hardening` lacks `m`"]);
    assert_told(&after("\"1 1/s\"", "\"1 s\""), &["reference_rate` must be a rate, not a time"]);
    assert_told(
        &after("\"1083 degC\"", "\"10 degC\""),
        &["material.copper.hardening.melting_temperature = 283.15", "must be above reference_temperature"],
    );
    assert_told(
        &after("\"20 degC\"", "\"-300 degC\""),
        &["reference_temperature` must be 0 or greater", "this is -26.85", " K"],
    );
    // degrees Celsius without the unit
    assert_told(
        &after("\"20 degC\"", "20.0"),
        &["warning: `material.copper.hardening.reference_temperature` is 20.0 K", "\"20.0 degC\""],
    );
    assert_told(&after("hardening = {", "hardening = \"\" #"), &["`material.copper.hardening` must be a table"]);
    let lacks = told_with("theory = \"e-star\"", "");
    assert_told(&lacks, &["`material.copper` lacks `hardening`", "a table with `law`"]);
    assert_told(&after("\nspecific_heat = \"383 J/(kg K)\"", ""), &["heats and needs `specific_heat`", "460 J/(kg K)"]);
    assert_told(&after("\"383 J/(kg K)\"", "\"383 W\""), &["specific_heat"]);
    assert_told(
        &after("specific_heat", "taylor_quinney = 1.1\nspecific_heat"),
        &["taylor_quinney` must be from 0 to 1"],
    );
    // a law that knows no temperature
    let linear =
        "hardening = { law = \"perfect\", yield_stress = \"400 MPa\" }\nspecific_heat = 383.0\ntaylor_quinney = 0.9";
    assert_told(
        &told_with("theory = \"e-star\"", linear),
        &["`specific_heat` is of no use", "`taylor_quinney` is of no use", "2 errors"],
    );
}

#[test]
fn surfaces_of_soils_are_read_and_their_angles_checked() {
    let told = |surface: &str, more: &str| {
        told_with("theory = \"hencky\"", &format!("yield_surface = {{ {surface} }}\n{more}"))
    };
    let cone = "kind = \"drucker-prager\", friction_angle = \"30 deg\", cohesion = \"2 MPa\"";
    let pyramid = "kind = \"mohr-coulomb\", friction_angle = \"30 deg\", cohesion = \"2 MPa\"";
    assert_eq!(told(cone, ""), "");
    assert_eq!(told(&format!("{cone}, dilatancy_angle = 0.0"), ""), "");
    assert_eq!(told(pyramid, ""), "");
    assert_told(&told(&format!("{cone}, dilatancy_angle = \"31 deg\""), ""), &["dilatancy_angle = 0.54", "^^^^^^^^"]);
    assert_told(
        &told(&pyramid.replace("30 deg", "90 deg"), ""),
        &["material.copper.yield_surface.friction_angle = 1.57", "a right angle"],
    );
    assert_told(
        &told(&pyramid.replace("\"30 deg\"", "30"), ""),
        &["friction_angle` is an angle without a unit", "\"30 deg\" or \"30 rad\""],
    );
    assert_eq!(told(&pyramid.replace("30 deg", "0.5 rad"), ""), "");
    assert_told(
        &told(&pyramid.replace("friction_angle = \"30 deg\", ", ""), ""),
        &["such as friction_angle = \"30 deg\""],
    );
    assert_told(&told(&pyramid.replace("\"2 MPa\"", "0.0"), ""), &["cohesion` must be greater than 0"]);
    assert_told(&told(&pyramid.replace(", cohesion = \"2 MPa\"", ""), ""), &["lacks `cohesion`"]);
    assert_told(
        &told(pyramid, "hardening = { law = \"perfect\", yield_stress = 1.0 }"),
        &["perfectly plastic", "leave it out"],
    );
    assert_told(&told("kind = \"rankine\"", ""), &["`hardening` is missing", "yield_stress"]);
}

#[test]
fn curves_must_increase_in_time() {
    let prescribed = |curve: &str| {
        let entry =
            format!("[[prescribed]]\ngroup = \"top\"\ndirection = \"z\"\nquantity = \"velocity\"\ncurve = {curve}\n");
        told(&format!("{GOOD}{entry}"))
    };
    assert_eq!(prescribed("[[0, 0], [\"1 ms\", \"3 m/s\"]]"), "");
    assert_told(&prescribed("[[0, 0], [1, 1], [1, 2]]"), &["the times of the curve must increase: point 3", ":48:26"]);
    assert_told(&prescribed("[]"), &["the curve has no points"]);
    assert_told(&prescribed("[[0, 0], [1]]"), &["a point of `prescribed.curve` must be [time, value]"]);
    assert_told(&prescribed("[[0, 0], [1, \"2 mm\"]]"), &["must be a velocity, not a length"]);
}

#[test]
fn overrides_are_read_like_the_deck() {
    let overrides = ["time.end=\"1 us\"".to_owned(), "part.0.element=\"hex8\"".to_owned()];
    let reading = deck::read(Path::new("deck.toml"), GOOD, &overrides);
    assert_eq!(reading.deck.unwrap().time.end.value, 1e-6);
    let reading = deck::read(Path::new("deck.toml"), GOOD, &["time.end=\"1 mm\"".to_owned()]);
    let told = reading.decoder.diagnostics.render(&reading.sources, false).to_string();
    assert_told(&told, &["--set time.end=\"1 mm\":1:10", "must be a time, not a length"]);
}

#[test]
fn an_output_field_is_named_once() {
    let deck = format!("{GOOD}[output]\nfields = [\"velocity\", \"pressure\", \"velocity\"]\n");
    let reading = read(&deck);
    let mut diagnostics = Diagnostics::default();
    output_plan(&reading.deck.unwrap(), &mut diagnostics);
    let told = diagnostics.render(&reading.sources, false).to_string();
    assert_told(&told, &["names a field twice", "the second time", "the first time", "1 error"]);
}

#[test]
fn names_can_be_seen_and_have_no_control_characters() {
    for name in ["", " ", "a,b", "a\\nb", "\\u0000"] {
        let told = told_after("name = \"length\"", &format!("name = \"{name}\""));
        assert_told(&told, &["a probe cannot be named", "control character"]);
    }
}

#[test]
fn of_very_many_names_the_first_are_listed() {
    let materials: String = (0..3000)
        .map(|index| {
            format!(
                "[material.m{index}]\ntheory = \"elastic\"\ndensity = 1.0\nyoung_modulus = 1.0\npoisson_ratio = 0.3\n"
            )
        })
        .collect();
    let told = told(&GOOD.replacen("material = \"copper\"", "material = \"gold\"", 1).replacen(
        "[[part]]",
        &format!("{materials}[[part]]"),
        1,
    ));
    assert_told(&told, &["there is no material `gold`", "`copper`, `m0`", ", and 2971 more"]);
}

#[test]
fn any_text_is_answered_without_a_panic() {
    let long = format!("title = \"{}\"\nbad = 1\n", "x".repeat(1_000_000));
    let deep = format!("a = {}", "[".repeat(50_000));
    let wide = format!("{GOOD}\n[wide]\n{}", (0..20_000).map(|i| format!("k{i} = {i}\n")).collect::<String>());
    for text in [
        &long,
        &deep,
        &wide,
        "\0",
        "=",
        "[",
        "[[",
        "\"",
        "a.b.c",
        "[a]\n[a]",
        "\u{feff}a=1",
        "a = 99999999999999999999",
    ] {
        assert!(told(text).contains("error"), "{:?}", &text[..text.len().min(40)]);
    }
    // every prefix, and every deletion of a line
    for end in (0..GOOD.len()).filter(|end| GOOD.is_char_boundary(*end)) {
        told(&GOOD[..end]);
    }
    let lines: Vec<&str> = GOOD.lines().collect();
    for skipped in 0..lines.len() {
        let kept = lines.iter().enumerate().filter(|(index, _)| *index != skipped);
        told(&kept.map(|(_, line)| format!("{line}\n")).collect::<String>());
    }
}

#[test]
fn damaged_decks_are_answered_without_a_panic() {
    let pieces = [
        "\"",
        "[",
        "]]",
        "=",
        "\n",
        "{",
        "'''",
        "1e999",
        "-",
        "µ",
        "\t",
        ",",
        "#",
        "\u{0}",
        "99999999999999999999",
        "nan",
    ];
    // a linear congruential generator: the same damage on every machine
    let mut state = 1_u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    for _ in 0..3000 {
        let mut deck = GOOD.to_owned();
        for _ in 0..=random(4) {
            let start = random(deck.len());
            let end = (start + random(12)).min(deck.len());
            if deck.is_char_boundary(start) && deck.is_char_boundary(end) {
                deck.replace_range(start..end, pieces[random(pieces.len())]);
            }
        }
        told(&deck);
    }
}

/// Every table and value below a value, by the keys that lead there.
fn places(value: &toml::Value, path: &mut Vec<String>, found: &mut Vec<Vec<String>>) {
    found.push(path.clone());
    let entries: Vec<(String, &toml::Value)> = match value {
        toml::Value::Table(table) => table.iter().map(|(key, value)| (key.clone(), value)).collect(),
        toml::Value::Array(list) => list.iter().enumerate().map(|(index, value)| (index.to_string(), value)).collect(),
        _ => Vec::new(),
    };
    for (key, value) in entries {
        path.push(key);
        places(value, path, found);
        path.pop();
    }
}

fn at<'a>(value: &'a mut toml::Value, path: &[String]) -> &'a mut toml::Value {
    path.iter().fold(value, |value, key| match value {
        toml::Value::Array(list) => &mut list[key.parse::<usize>().unwrap()],
        value => &mut value[key.as_str()],
    })
}

/// A deck, whether its parser reads it, and whether anything that the schema knows of was damaged.
struct Case {
    is_point: bool,
    deck: toml::Value,
    is_read: bool,
    is_damaged: bool,
}

/// A deck, and all decks that differ from it in one place: a key that there is none of, a wrong type, a key that is gone.
fn cases_of(text: &str, path: &Path, is_point: bool) -> Vec<Case> {
    let case = |deck: toml::Value, is_damaged| {
        let text = toml::to_string(&deck).unwrap();
        let is_read = if is_point {
            deck::read_point(path, &text, &[]).deck.is_some()
        } else {
            deck::read(path, &text, &[]).deck.is_some()
        };
        Case { is_point, deck, is_read, is_damaged }
    };
    let good: toml::Value = toml::from_str(text).unwrap();
    let mut cases = vec![case(good.clone(), false)];
    assert!(cases[0].is_read, "{}", path.display());
    let mut found = Vec::new();
    places(&good, &mut Vec::new(), &mut found);
    for place in found {
        let mut deck = good.clone();
        // a table under names may have any
        let is_named = place.len() == 1 && place[0] == "material";
        if let toml::Value::Table(table) = at(&mut deck, &place)
            && !is_named
        {
            table.insert("no_such_key".to_owned(), 1.into());
            cases.push(case(deck, true));
        }
        let Some((key, parent)) = place.split_last() else { continue };
        let mut deck = good.clone();
        *at(&mut deck, &place) = true.into();
        cases.push(case(deck, true));
        let mut deck = good.clone();
        if let toml::Value::Table(table) = at(&mut deck, parent) {
            table.remove(key);
            cases.push(case(deck, false));
        }
    }
    cases
}

/// Needs Python with the package `jsonschema`; without it the test says that it was skipped.
#[test]
fn the_json_schema_takes_what_the_parser_takes_and_knows_every_key_and_type() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let python = |arguments: &[&std::ffi::OsStr]| std::process::Command::new("python3").args(arguments).output();
    if !python(&["-c".as_ref(), "import jsonschema".as_ref()]).is_ok_and(|output| output.status.success()) {
        eprintln!("skipped: Python's package jsonschema is not installed (pip install jsonschema)");
        return;
    }
    let mut cases = Vec::new();
    for folder in ["meshes/taylor", "meshes/necking", "meshes/cook", "meshes/point", "fuzz/seeds/deck"] {
        let entries = std::fs::read_dir(root.join(folder)).unwrap();
        let paths = entries.map(|entry| entry.unwrap().path());
        for path in paths.filter(|path| path.extension().is_some_and(|extension| extension == "toml")) {
            cases.extend(cases_of(&std::fs::read_to_string(&path).unwrap(), &path, folder.ends_with("point")));
        }
    }
    let directory = tempfile::tempdir().unwrap();
    let questions = directory.path().join("questions.json");
    let decks: Vec<_> = cases.iter().map(|case| (usize::from(case.is_point), &case.deck)).collect();
    let schemas = [deck::json_schema::of_deck(), deck::json_schema::of_point_deck()];
    std::fs::write(&questions, serde_json::to_vec(&(schemas, decks)).unwrap()).unwrap();
    let answer = python(&[root.join("tests/validate_decks.py").as_ref(), questions.as_ref()]).unwrap();
    assert!(answer.status.success(), "{}", String::from_utf8_lossy(&answer.stderr));
    let faults: Vec<Option<String>> = serde_json::from_slice(&answer.stdout).unwrap();
    assert_eq!(faults.len(), cases.len());
    for (case, fault) in cases.iter().zip(&faults) {
        let deck = toml::to_string(&case.deck).unwrap();
        assert!(fault.is_none() || !case.is_read, "the schema refuses what is read: {fault:?}\n{deck}");
        assert!(!case.is_damaged || (fault.is_some() && !case.is_read), "damage is not seen: {fault:?}\n{deck}");
    }
}

#[test]
fn the_schema_has_every_key_of_the_reference() {
    fn keys(schema: &serde_json::Value, found: &mut std::collections::BTreeSet<String>) {
        if let Some(properties) = schema["properties"].as_object() {
            found.extend(properties.keys().cloned());
        }
        match schema {
            serde_json::Value::Object(map) => map.values().for_each(|value| keys(value, found)),
            serde_json::Value::Array(list) => list.iter().for_each(|value| keys(value, found)),
            _ => {}
        }
    }
    let mut in_schema = std::collections::BTreeSet::new();
    keys(&deck::json_schema::of_deck(), &mut in_schema);
    keys(&deck::json_schema::of_point_deck(), &mut in_schema);
    let reference = deck::document::markdown();
    let first = |line: &str, before: &str| Some(line.trim_start().strip_prefix(before)?.split('`').next()?.to_owned());
    let mut in_reference: std::collections::BTreeSet<String> =
        reference.lines().filter_map(|line| first(line, "| `").or_else(|| first(line, "**`"))).collect();
    // these are headings: `[mesh]`, `[[part]]`, `[material.NAME]`
    in_reference.extend(reference.lines().filter_map(|line| {
        let name = line.strip_prefix("## `[")?.trim_start_matches('[');
        Some(name.split([']', '.']).next()?.to_owned())
    }));
    assert_eq!(in_schema, in_reference);
}

#[test]
fn deck_reference_is_up_to_date() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/deck.md");
    let wanted = deck::document::markdown();
    if std::env::var_os("ESTAR_UPDATE_DOCS").is_some() {
        std::fs::write(&path, &wanted).unwrap();
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(found == wanted, "docs/deck.md is stale: ESTAR_UPDATE_DOCS=1 cargo test --release --test deck");
}
