//! Goal: what is probably not meant in a mesh or a deck is told, with its place and what to do, and nothing else is.
//! Meshes that are not joined or do not match; bodies that pass through each other; numbers in another unit.

mod common;

use common::{DECK, Workshop};
use estar_session::Session;
use estar_solver::LaneLevel;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// A mesh in the making.
#[derive(Default)]
struct Mesh {
    nodes: Vec<[f64; 3]>,
    /// Abaqus type, nodes from 1, set.
    elements: Vec<(&'static str, Vec<usize>, &'static str)>,
}

const CORNERS: [[usize; 3]; 8] =
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];

impl Mesh {
    /// The node at a place: one of those after the first `from`, or a new one.
    fn node(&mut self, place: [f64; 3], from: usize) -> usize {
        match self.nodes[from..].iter().position(|node| *node == place) {
            Some(known) => from + known + 1,
            None => {
                self.nodes.push(place);
                self.nodes.len()
            }
        }
    }

    /// Cubes at places of a grid; nodes are shared with all but the first `from`.
    fn cubes(&mut self, places: &[[usize; 3]], origin: [f64; 3], edge: f64, from: usize, set: &'static str) {
        for place in places {
            let corner = |offset: [usize; 3]| std::array::from_fn(|k| origin[k] + edge * (place[k] + offset[k]) as f64);
            let nodes = CORNERS.map(|offset| self.node(corner(offset), from));
            self.elements.push(("C3D8", nodes.to_vec(), set));
        }
    }

    /// Tets round the middle of a unit cube, whose faces all have the diagonal through the corner nearest to the origin or the
    /// farthest from it; below stays a pyramid where asked.
    fn tets_in(&mut self, place: [usize; 3], has_pyramid: bool) {
        let corner = |offset: [usize; 3]| std::array::from_fn(|k| (place[k] + offset[k]) as f64);
        let nodes = CORNERS.map(|offset| self.node(corner(offset), 0));
        let middle = self.node(std::array::from_fn(|k| place[k] as f64 + 0.5), 0);
        // normals inwards; the first corner of each lies on the diagonal
        let faces = [[0, 1, 2, 3], [6, 5, 4, 7], [0, 4, 5, 1], [0, 3, 7, 4], [6, 7, 3, 2], [6, 2, 1, 5]];
        for (number, face) in faces.into_iter().enumerate() {
            let [a, b, c, d] = face.map(|corner| nodes[corner]);
            if has_pyramid && number == 0 {
                self.elements.push(("C3D5", vec![a, b, c, d, middle], "hexes"));
            } else {
                self.elements.push(("C3D4", vec![a, b, c, middle], "tets"));
                self.elements.push(("C3D4", vec![a, c, d, middle], "tets"));
            }
        }
    }

    /// The file, with sets of the nodes that lie in planes.
    fn text(&self, planes: &[(&str, usize, f64)]) -> String {
        let mut text = String::from("*NODE\n");
        for (number, [x, y, z]) in self.nodes.iter().enumerate() {
            let _ = writeln!(text, "{}, {x}, {y}, {z}", number + 1);
        }
        for (number, (kind, nodes, set)) in self.elements.iter().enumerate() {
            let nodes = nodes.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
            let _ = writeln!(text, "*ELEMENT, TYPE={kind}, ELSET={set}\n{}, {nodes}", number + 1);
        }
        for (name, axis, place) in planes {
            let _ = writeln!(text, "*NSET, NSET={name}");
            for (number, _) in self.nodes.iter().enumerate().filter(|(_, node)| node[*axis] == *place) {
                let _ = writeln!(text, "{},", number + 1);
            }
        }
        text
    }
}

/// All places of a grid of `counts` cubes.
fn grid(counts: [usize; 3]) -> Vec<[usize; 3]> {
    let [nx, ny, nz] = counts;
    (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z]))).collect()
}

const STEEL: &str =
    "[material.steel]\ntheory = \"elastic\"\ndensity = 7850.0\nyoung_modulus = \"200 GPa\"\npoisson_ratio = 0.0\n";

fn part(group: &str) -> String {
    format!("[[part]]\ngroup = \"{group}\"\nmaterial = \"steel\"\n")
}

/// Two boxes side by side along x, each 1 m long, whose common nodes are there twice; one end is held, the other pulled.
fn two_boxes(workshop: &Workshop, merge: &str) -> String {
    let mut mesh = Mesh::default();
    mesh.cubes(&grid([2, 2, 2]), [0.0; 3], 0.5, 0, "all");
    let from = mesh.nodes.len();
    mesh.cubes(&grid([2, 2, 2]), [1.0, 0.0, 0.0], 0.5, from, "all");
    workshop.write("two.inp", &mesh.text(&[("x0", 0, 0.0), ("x2", 0, 2.0)]));
    format!(
        "[mesh]\nfile = \"two.inp\"\n{merge}\n{STEEL}{}[[fix]]\ngroup = \"x0\"\ndirections = [\"x\"]\n\
         [[prescribed]]\ngroup = \"x2\"\ndirection = \"x\"\nquantity = \"displacement\"\ninterpolation = \"smooth\"\n\
         curve = [[0, 0], [\"10 ms\", \"2 mm\"]]\n[time]\nend = \"10 ms\"\n[output]\nframes = 1\n\
         [[probe]]\nname = \"force\"\nkind = \"reaction\"\ngroup = \"x2\"\ndirection = \"x\"\n",
        part("all")
    )
}

#[test]
fn unmerged_nodes_are_warned_of_and_merged_on_demand() {
    let workshop = Workshop::new();
    let told = ["9 nodes lie exactly at the place of another", "such as node 9 and node 28 at (1, 0, 0) m", "merge = "];
    let force = |deck: &str, told: &[&str]| {
        let said = workshop.run_deck(deck, &[]);
        said.assert(0, told);
        (workshop.summary()["probes"]["force"].as_f64().unwrap(), said)
    };
    let (apart, _) = force(&two_boxes(&workshop, ""), &told);
    let (joined, said) = force(&two_boxes(&workshop, "merge = \"1e-6 mm\""), &[]);
    // E A ε = 200 GPa · 1 m² · 1e-3
    assert!((joined / 2e8 - 1.0).abs() < 0.01, "{joined}");
    assert!(apart.abs() < 1e-3 * joined, "{apart}");
    assert!(!said.errors.contains("warning"), "{}", said.errors);
    assert!(said.text.contains("merge      9 nodes joined to others, 0 m away at most"), "{}", said.text);

    let said = workshop.estar(&["mesh", "info", "two.inp"]);
    said.assert(0, &[]);
    assert!(
        said.text.contains("2 bodies that share no nodes: 8 elements, 1 × 1 × 1 (element 1 is one)"),
        "{}",
        said.text
    );
    assert!(said.text.contains("warning: 9 nodes lie exactly at the place of another"), "{}", said.text);

    workshop.write("deck.toml", &two_boxes(&workshop, ""));
    let said = workshop.estar(&["check", "deck.toml", "--json"]);
    let report: serde_json::Value = serde_json::from_str(&said.text).unwrap();
    assert_eq!((&report["is_good"], &report["findings"][0]["severity"]), (&true.into(), &"warning".into()));
}

#[test]
fn the_merge_that_is_advised_joins_the_nodes() {
    let workshop = Workshop::new();
    let cubes = |gap: f64| {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let heights = [0.0, 1.0, 1.0 + gap, 2.0 + gap];
        let nodes = heights.iter().flat_map(|z| square.map(|[x, y]| format!("{x}, {y}, {z:?}")));
        let nodes: String = nodes.enumerate().map(|(index, place)| format!("{}, {place}\n", index + 1)).collect();
        format!("*NODE\n{nodes}*ELEMENT, TYPE=C3D8\n1, 1, 2, 3, 4, 5, 6, 7, 8\n2, 9, 10, 11, 12, 13, 14, 15, 16\n")
    };
    let deck =
        |merge: &str| format!("[mesh]\nfile = \"cubes.inp\"\n{merge}\n{STEEL}{}[time]\nend = \"1 us\"\n", part("all"));
    for (gap, advised) in [(0.0, "1e-6 m"), (5e-4, "1e-3 m"), (6e-4, "1e-2 m"), (1e-6, "1e-5 m")] {
        workshop.write("cubes.inp", &cubes(gap));
        workshop.write("deck.toml", &deck(""));
        let said = workshop.estar(&["check", "deck.toml"]);
        said.assert(0, &["the mesh is not connected there"]);
        let merge = said.errors.split('`').find(|part| part.starts_with("merge = ")).unwrap().to_owned();
        let info = workshop.estar(&["mesh", "info", "cubes.inp"]);
        let millimetres = advised.replace(" m", " mm");
        let told = format!("(\"{advised}\" of a file in m, \"{millimetres}\" of one in mm)");
        assert!(info.text.contains(&told), "{told}: {}", info.text);
        assert_eq!(merge, format!("merge = \"{advised}\""), "{gap}");
        workshop.write("deck.toml", &deck(&merge));
        let said = workshop.estar(&["check", "deck.toml"]);
        said.assert(0, &[]);
        assert!(said.text.contains("4 nodes joined to others"), "{}", said.text);
        assert!(!said.errors.contains("not connected"), "{}", said.errors);
    }
}

#[test]
fn a_merge_that_would_collapse_elements_is_refused_and_an_idle_one_is_told() {
    let workshop = Workshop::new();
    let coarse = two_boxes(&workshop, "merge = \"0.6 m\"");
    workshop
        .run_deck(&coarse, &[])
        .assert(2, &["deck.toml:3:9", "of element 1, which are 5e-1 m apart", "16 elements"]);
    let none = DECK.replacen("file = \"box.msh\"", "file = \"box.msh\"\nmerge = \"1 um\"", 1);
    workshop.run_deck(&none, &[]).assert(0, &["no two nodes are within 1e-6 m of each other", "deck.toml:6:9"]);
    workshop.run_deck(&none.replacen("1 um", "-1 um", 1), &[]).assert(2, &["`mesh.merge` must be greater than 0"]);
    workshop.run_deck(&none.replacen("1 um", "1 us", 1), &[]).assert(2, &["`mesh.merge` must be a length"]);
}

/// Hexes below tets, 2 × 2 columns, in uniaxial strain; between them pyramids, or nothing that makes them match.
fn hexes_under_tets(workshop: &Workshop, has_pyramids: bool) -> String {
    let mut mesh = Mesh::default();
    mesh.cubes(&grid([2, 2, 1]), [0.0; 3], 1.0, 0, "hexes");
    for [x, y, _] in grid([2, 2, 1]) {
        mesh.tets_in([x, y, 1], has_pyramids);
    }
    let planes = [("x0", 0, 0.0), ("x1", 0, 2.0), ("y0", 1, 0.0), ("y1", 1, 2.0), ("z0", 2, 0.0), ("z1", 2, 2.0)];
    workshop.write("mixed.inp", &mesh.text(&planes));
    let fixes = [("x0", "x"), ("x1", "x"), ("y0", "y"), ("y1", "y"), ("z0", "z")]
        .map(|(group, axis)| format!("[[fix]]\ngroup = \"{group}\"\ndirections = [\"{axis}\"]\n"));
    let probe = |name: &str, kind: &str, group: &str| {
        format!(
            "[[probe]]\nname = \"{name}\"\nkind = \"{kind}\"\ngroup = \"{group}\"\nfield = \"cauchy_stress\"\ncomponent = \"zz\"\n"
        )
    };
    format!(
        "[mesh]\nfile = \"mixed.inp\"\n[material.m]\ntheory = \"elastic\"\ndensity = 1000.0\nyoung_modulus = \"1 GPa\"\n\
         poisson_ratio = 0.3\n[[part]]\ngroup = \"hexes\"\nmaterial = \"m\"\nelement = \"hex8-b-bar\"\n[[part]]\ngroup = \"tets\"\n\
         material = \"m\"\nelement = \"tet4\"\n{}[[prescribed]]\ngroup = \"z1\"\ndirection = \"z\"\nquantity = \"displacement\"\n\
         curve = [[0, 0], [\"0.1 s\", \"2 mm\"]]\ninterpolation = \"smooth\"\n[time]\nend = \"0.2 s\"\nmass_damping = 300.0\n\
         [output]\nframes = 1\nhistory = \"1 ms\"\n{}{}{}{}",
        fixes.concat(),
        probe("hexes", "group-average", "hexes"),
        probe("hexes_most", "maximum", "hexes"),
        probe("tets", "group-average", "tets"),
        probe("tets_most", "maximum", "tets"),
    )
}

/// Uniaxial strain of one material: (λ + 2μ) ln(1.001) everywhere, if the mesh conforms.
#[test]
fn quads_on_triangles_are_warned_of_and_uniaxial_strain_is_uniform_where_meshes_conform() {
    let workshop = Workshop::new();
    let stresses = |has_pyramids: bool| {
        let said = workshop.run_deck(&hexes_under_tets(&workshop, has_pyramids), &[]);
        said.assert(0, &[]);
        let probes = workshop.summary()["probes"].clone();
        let relative = ["hexes", "hexes_most", "tets", "tets_most"].map(|name| {
            let exact = 1e9 * 0.7 / (1.3 * 0.4) * 1.001_f64.ln();
            probes[name].as_f64().unwrap() / exact - 1.0
        });
        (relative, said.errors)
    };
    let (relative, errors) = stresses(true);
    assert!(relative.iter().all(|error| error.abs() < 1e-4), "{relative:?}");
    assert_eq!(errors, "");
    let (relative, errors) = stresses(false);
    assert!(relative.iter().any(|error| error.abs() > 0.03), "{relative:?}");
    let told =
        "faces of the mesh do not match: 4 quads that lie on two triangles each, such as between elements 1 and ";
    assert!(errors.contains(told) && errors.contains("at (0.5, 0.5, 1) m") && errors.contains("pyramids"), "{errors}");
}

#[test]
fn hanging_nodes_hinges_and_bodies_on_each_other_are_told_by_mesh_info() {
    let workshop = Workshop::new();
    let info = |mesh: &Mesh, told: &[&str]| {
        workshop.write("mesh.inp", &mesh.text(&[]));
        let said = workshop.estar(&["mesh", "info", "mesh.inp"]);
        said.assert(0, &[]);
        assert_eq!(said.text.matches("warning").count(), told.len(), "{}", said.text);
        assert!(told.iter().all(|part| said.text.contains(part)), "{}", said.text);
    };
    let mut mesh = Mesh::default();
    mesh.cubes(&grid([1, 1, 1]), [0.0; 3], 1.0, 0, "all");
    info(&mesh, &[]);
    mesh.cubes(&grid([2, 2, 1]), [0.0, 0.0, 1.0], 0.5, 0, "all");
    info(
        &mesh,
        &["5 nodes lie on a face or an edge of an element that does not have it (a hanging node), such as node"],
    );
    let mut mesh = Mesh::default();
    mesh.cubes(&grid([2, 2, 2]), [0.0; 3], 0.5, 0, "all");
    let from = mesh.nodes.len();
    mesh.cubes(&grid([4, 4, 4]), [1.0, 0.1, 0.2], 0.1875, from, "all");
    info(&mesh, &["nodes of one body lie on a face of another body that does not have it, such as node"]);
    let mut mesh = Mesh::default();
    mesh.cubes(&[[0, 0, 0], [1, 1, 0]], [0.0; 3], 1.0, 0, "all");
    info(&mesh, &["2 nodes alone hold together pieces of a body that share no face, such as node 3 at (1, 1, 0)"]);
}

/// A cube that flies at a plate of its own mesh, which is held; there is no contact.
#[test]
fn bodies_that_pass_through_each_other_are_warned_of_before_and_after() {
    let workshop = Workshop::new();
    let mut mesh = Mesh::default();
    mesh.cubes(&grid([4, 4, 1]), [0.0; 3], 1.0, 0, "plate");
    let from = mesh.nodes.len();
    mesh.cubes(&grid([2, 2, 2]), [1.2, 1.3, 1.5], 0.5, from, "ball");
    workshop.write("two.inp", &mesh.text(&[("edge", 0, 0.0)]));
    let deck = |speed: f64| {
        format!(
            "[mesh]\nfile = \"two.inp\"\n{STEEL}{}{}[[fix]]\ngroup = \"edge\"\ndirections = [\"x\", \"y\", \"z\"]\n\
             [[initial_velocity]]\ngroup = \"ball\"\nvalue = [0, 0, {speed:?}]\n[time]\nend = \"10 ms\"\n[output]\nframes = 10\n",
            part("plate"),
            part("ball")
        )
    };
    let before = [
        "the mesh has 2 bodies that share no nodes",
        "16 elements of `plate`, 4 × 4 × 1 m",
        "8 elements of `ball`, 1 × 1 × 1 m",
    ];
    let after = "faces of the surface are inside of elements that they do not belong to";
    let said = workshop.run_deck(&deck(-100.0), &[]);
    said.assert(0, &before);
    said.assert(0, &[after, "of another body", "at t = 6.0"]);
    assert_eq!(said.errors.matches(after).count(), 1, "{}", said.errors);
    assert!(workshop.read("deck/estar.log").contains(after));
    let said = workshop.run_deck(&deck(100.0), &[]);
    said.assert(0, &before);
    assert!(!said.errors.contains(after), "{}", said.errors);
}

/// A clamp of two jaws, one of which flies at the other: it is one body, and its jaws pass through each other.
#[test]
fn a_body_that_passes_through_itself_is_warned_of() {
    let workshop = Workshop::new();
    let mut mesh = Mesh::default();
    let row = |z: usize| (0..6).map(|x| [x, 0, z]).collect::<Vec<_>>();
    mesh.cubes(&[row(0), vec![[0, 0, 1]]].concat(), [0.0; 3], 1.0, 0, "clamp");
    mesh.cubes(&row(2), [0.0; 3], 1.0, 0, "jaw");
    workshop.write("clamp.inp", &mesh.text(&[("foot", 2, 0.0)]));
    let soft = STEEL.replace("200 GPa", "10 MPa").replace("7850", "1000");
    let deck = |speed: f64| {
        format!(
            "[mesh]\nfile = \"clamp.inp\"\n{soft}{}{}[[fix]]\ngroup = \"foot\"\ndirections = [\"x\", \"y\", \"z\"]\n\
             [[initial_velocity]]\ngroup = \"jaw\"\nvalue = [0, 0, {speed:?}]\n\
             [time]\nend = \"100 ms\"\n[output]\nframes = 20\n",
            part("clamp"),
            part("jaw")
        )
    };
    let after = "inside of elements that they do not belong to";
    let said = workshop.run_deck(&deck(-16.0), &[]);
    said.assert(0, &[after, "of the same body"]);
    let said = workshop.run_deck(&deck(-1.0), &[]);
    said.assert(0, &[]);
    assert_eq!(said.errors, "");
}

#[test]
fn a_body_to_which_nothing_happens_is_told() {
    let workshop = Workshop::new();
    let idle = DECK.replacen("value = [1.0, 0.0, 0.0]", "value = [0.0, 0.0, 0.0]", 1);
    let told = "a body is neither held nor driven nor loaded and does not move";
    workshop.run_deck(&idle, &[]).assert(0, &[told, "8 elements of `box`, 1 × 1 × 1 m (element 1 is one)"]);
    for something in [
        "[[gravity]]\nacceleration = [0, 0, -9.81]\n",
        "[[fix]]\ngroup = \"x_min\"\ndirections = [\"x\"]\n",
        "[[pressure]]\ngroup = \"x_min\"\ncurve = [[0, 1]]\n",
        "[[rigid_wall]]\npoint = [0, 0, -1]\nnormal = [0, 0, 1]\nmotion = { direction = [0, 0, 1], quantity = \"velocity\", curve = [[0, 1]] }\n",
    ] {
        let said = workshop.run_deck(&format!("{idle}{something}"), &[]);
        said.assert(0, &[]);
        assert_eq!(said.errors, "", "{something}");
    }
}

/// Every number that is probably in another unit is told with the likely one, and its neighbours are not.
#[test]
fn numbers_of_another_unit_are_told_with_the_likely_one() {
    let workshop = Workshop::new();
    let metal = DECK
        .replacen(
            "theory = \"elastic\"",
            "theory = \"e-star\"\nhardening = { law = \"linear\", yield_stress = \"400 MPa\", modulus = \"100 MPa\" }",
            1,
        )
        .replacen("density = 1000.0", "density = 8930.0", 1)
        .replacen("100 MPa\"\npoisson", "117 GPa\"\npoisson", 1)
        .replacen("20 ms", "1 ms", 1);
    let said = |deck: &str| {
        workshop.write("deck.toml", deck);
        workshop.estar(&["check", "deck.toml"])
    };
    let sound = said(&metal);
    sound.assert(0, &[]);
    assert_eq!(sound.errors, "");
    let pull = "[[fix]]\ngroup = \"x_min\"\ndirections = [\"x\"]\n[[prescribed]]\ngroup = \"x_max\"\ndirection = \"x\"\n\
                quantity = \"displacement\"\ncurve = [[0, 0], [\"1 s\", 200]]\n";
    let scaled = |scale: &str| format!("file = \"box.msh\"\nscale = {scale}");
    let (same, tiny, milli) = (scaled("1.0"), scaled("1e-6"), scaled("1e-3"));
    let large = scaled("1e3");
    let fast =
        "[[prescribed]]\ngroup = \"x_max\"\ndirection = \"x\"\nquantity = \"velocity\"\ncurve = [[0, -300e3]]\n[time]";
    let cases: [(&str, &str, &[&str]); 14] = [
        (
            "[time]",
            fast,
            &["a prescribed velocity of 3e5 m/s is 82.88 times that of sound", "numbers without a unit are in m/s"],
        ),
        (
            "file = \"box.msh\"",
            &large,
            &["the mesh is 1000 × 1000 × 1000 m large, 1000 times the size of the file", "1e-3 of mm"],
        ),
        (
            "8930.0",
            "\"8.93 g/mm^3\"",
            &["no solid has a density of 8.93e6 kg/m^3", "g/cm^3 instead of g/mm^3 would make it 8930"][..],
        ),
        ("8930.0", "8.93e-9", &["no solid has a density", "t/mm^3 would make it 8930 kg/m^3"]),
        ("8930.0", "8.93e-6", &["no solid has a density", "kg/mm^3 would make it 8930 kg/m^3"]),
        ("\"117 GPa\"", "117e3", &["sound would go at 3.62 m/s", "if MPa are meant: \"1.17e5 MPa\""]),
        (
            "\"400 MPa\"",
            "400",
            &["it yields first at 400 Pa, which is 3.419e-9 of Young's modulus", "if stresses in MPa are meant"],
        ),
        (
            "law = \"linear\", yield_stress = \"400 MPa\", modulus = \"100 MPa\"",
            "law = \"tabulated\", points = [[0, 400], [0.5, 600]]",
            &["it yields first at 400 Pa", "if stresses in MPa are meant, give them that unit, also in tables"],
        ),
        ("\"400 MPa\"", "\"400 GPa\"", &["it yields first at 4e11 Pa, which is 3.419 of Young's modulus"]),
        ("file = \"box.msh\"", &same, &[]),
        ("file = \"box.msh\"", &tiny, &["the mesh is 1e-6 × 1e-6 × 1e-6 m large", "in metres already"]),
        (
            "value = [1.0, 0.0, 0.0]",
            "value = [0.0, 0.0, -227000.0]",
            &["an initial velocity of 2.27e5 m/s is 62.71 times that of sound"],
        ),
        ("\"1 ms\"", "\"80\"", &[]),
        ("\"1 ms\"", "8e4", &["the run takes", "steps of", "if another unit is meant", "end = \"80000 us\""]),
    ];
    for (from, to, told) in cases {
        assert!(metal.contains(from), "{from}");
        let found = said(&metal.replacen(from, to, 1));
        found.assert(0, told);
        assert_eq!(
            found.errors.matches("warning:").count(),
            usize::from(!told.is_empty()),
            "{from} {to}\n{}",
            found.errors
        );
    }
    workshop.write("deck.toml", &format!("{}{pull}", metal.replacen("1 ms", "1 s", 1)));
    workshop.estar(&["check", "deck.toml"]).assert(0, &["a displacement of 200 m is 200 times the size of the mesh"]);
    // a rod in mm without a scale
    workshop.estar(&[
        "mesh", "box", "--output", "box.msh", "--force", "--size", "6.4", "6.4", "32.4", "--cells", "2", "2", "6",
    ]);
    let told = [
        "the mesh is 6.4 × 6.4 × 32.4 m large, and sound goes through 0.8937 % of that until the end, 8e-5 s",
        "scale = 1e-3",
    ];
    said(&metal.replacen("1 ms", "80 us", 1)).assert(0, &told);
    let found = said(&metal.replacen("1 ms", "80 us", 1).replacen("file = \"box.msh\"", &milli, 1));
    found.assert(0, &[]);
    assert_eq!(found.errors, "");
}

/// Copies a folder, and gives the decks in it.
fn copied(from: &Path, to: &Path, decks: &mut Vec<PathBuf>) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let (path, copy) = (entry.as_ref().unwrap().path(), to.join(entry.unwrap().file_name()));
        if path.is_dir() {
            copied(&path, &copy, decks);
        } else {
            std::fs::copy(&path, &copy).unwrap();
            if copy.extension().is_some_and(|extension| extension == "toml") {
                decks.push(copy);
            }
        }
    }
}

#[test]
fn no_shipped_deck_is_doubted() {
    let workshop = Workshop::new();
    let mut decks = Vec::new();
    copied(&Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes"), &workshop.path("meshes"), &mut decks);
    let (mut simulations, mut points) = (0, 0);
    for deck in decks {
        let text = std::fs::read_to_string(&deck).unwrap();
        if !text.contains("[mesh]") {
            let reading = estar_deck::read_point(&deck, &text, &[]);
            assert_eq!(
                reading.decoder.diagnostics.render(&reading.sources, false).to_string(),
                "",
                "{}",
                deck.display()
            );
            points += 1;
            continue;
        }
        // some say how their mesh is made
        if let Some(command) = text.lines().find_map(|line| line.strip_prefix("# The mesh: estar ")) {
            let words: Vec<&str> = command.split(' ').chain(["--force"]).collect();
            workshop.estar(&words).assert(0, &[]);
        }
        let session = Session::load(&deck, &[], LaneLevel::best(), &mut ());
        let session = session.unwrap_or_else(|error| panic!("{}: {error}", deck.display()));
        assert_eq!(session.problem().findings.render(false).to_string(), "", "{}", deck.display());
        simulations += 1;
    }
    assert!(simulations >= 14 && points >= 9, "{simulations} {points}");
}
