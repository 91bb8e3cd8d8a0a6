//! Goal: every class of bad input has an answer that names the place and says what would be right.
//!
//! `docs/bad-input.md` shows what a user is told, and this test makes it: `ESTAR_UPDATE_DOCS=1 cargo test --release --test
//! bad_input` rewrites it.

mod common;

use common::{DECK, Said, Workshop};
use std::fmt::Write;
use std::fs;
use std::path::Path;

const HEAD: &str = "\
# What bad input is told

One example of every class, as the program answers it: made by a test (`ESTAR_UPDATE_DOCS=1 cargo test --release --test
bad_input` rewrites this page), so that this is what a user sees. The deck is that of a box that flies; each example changes it,
its mesh or the command line in one place. Exit status: 2 bad input, 3 the simulation failed, 4 a file could not be read or
written. What the machine does to a run, from full disks to kills, is in [reliability.md](reliability.md).
";

/// A sound deck and mesh, to be damaged.
struct Input {
    workshop: Workshop,
    mesh: String,
    /// The page.
    page: String,
}

impl Input {
    fn new() -> Self {
        let workshop = Workshop::new();
        workshop
            .estar(&["mesh", "box", "--ascii", "--force", "--output", "box.msh", "--cells", "2", "2", "2"])
            .assert(0, &[]);
        let mesh = workshop.read("box.msh");
        Self { workshop, mesh, page: HEAD.to_owned() }
    }

    fn section(&mut self, title: &str) {
        let _ = write!(self.page, "\n## {title}\n");
    }

    /// Runs a deck on a mesh, asserts status and place, and enters what was said.
    #[track_caller]
    fn answer(&mut self, what: &str, deck: &str, mesh: &[u8], arguments: &[&str], code: i32, place: &str) {
        fs::write(self.workshop.path("box.msh"), mesh).unwrap();
        self.workshop.write("deck.toml", deck);
        let said = self.workshop.estar(&[&["run", "deck.toml"], arguments].concat());
        self.enter(what, &said, code, place);
        let _ = fs::remove_dir_all(self.workshop.path("deck"));
    }

    #[track_caller]
    fn enter(&mut self, what: &str, said: &Said, code: i32, place: &str) {
        said.assert(code, &[place]);
        let told: Vec<&str> = said.errors.trim_end().lines().map(str::trim_end).collect();
        assert!(told.len() < 60, "{}", said.errors);
        let _ = write!(self.page, "\n### {what}\nExit status {code}.\n```text\n{}\n```\n", told.join("\n"));
    }

    /// The deck with pieces replaced.
    #[track_caller]
    fn deck(&mut self, what: &str, changes: &[(&str, &str)], place: &str) {
        let mesh = self.mesh.clone();
        self.answer(what, &replaced(DECK, changes), mesh.as_bytes(), &[], 2, place);
    }

    /// The mesh with pieces replaced.
    #[track_caller]
    fn mesh(&mut self, what: &str, changes: &[(&str, &str)], place: &str) {
        let mesh = replaced(&self.mesh, changes);
        self.answer(what, DECK, mesh.as_bytes(), &[], 2, place);
    }

    /// The deck with an addition, which fails with a status.
    #[track_caller]
    fn addition(&mut self, what: &str, addition: &str, arguments: &[&str], code: i32, place: &str) {
        let mesh = self.mesh.clone();
        self.answer(what, &format!("{DECK}{addition}"), mesh.as_bytes(), arguments, code, place);
    }
}

#[track_caller]
fn replaced(text: &str, changes: &[(&str, &str)]) -> String {
    let mut text = text.to_owned();
    for (from, to) in changes {
        assert!(text.contains(from), "{from:?}");
        text = text.replacen(from, to, 1);
    }
    text
}

#[test]
fn every_class_of_bad_input_is_answered_as_the_page_shows() {
    let mut input = Input::new();

    input.section("Deck");
    input.deck("unknown key", &[("young_modulus", "youngs_modulus")], "deck.toml:10:1");
    input.deck("wrong type", &[("density = 1000.0", "density = [1000.0]")], "deck.toml:9:11");
    input.deck("missing key", &[("density = 1000.0\n", "")], "lacks `density`");
    input.deck("unit that there is none of", &[("100 MPa", "100 MPas")], "deck.toml:10:17");
    input.deck("unit of another dimension", &[("20 ms", "20 mm")], "deck.toml:22:7");
    input.deck("negative density", &[("1000.0", "-1000.0")], "deck.toml:9:11");
    input.deck("Poisson's ratio of 0.5 or more", &[("0.3", "0.5")], "deck.toml:11:17");
    input.deck(
        "group that is not in the mesh",
        &[("group = \"box\"\nmaterial", "group = \"boxx\"\nmaterial")],
        "did you mean",
    );
    input.deck(
        "part of a material that there is none of",
        &[("material = \"rubber\"", "material = \"steel\"")],
        "deck.toml:15:12",
    );
    input.deck(
        "word of another code",
        &[("material = \"rubber\"", "material = \"rubber\"\nelement = \"C3D8R\"")],
        "deck.toml:16:11",
    );
    input.addition("what there is in other codes", "[[contact]]\nfriction = 0.2\n", &[], 2, "deck.toml:27:3");
    let path = "[material.steel]\n[path]\nsteps = 10\n";
    input.answer("deck of a material point", path, b"", &[], 2, "estar point");
    let long = "n".repeat(70_000);
    input.deck("name that is too long", &[("[material.rubber]", &format!("[material.{long}]"))], "up to 255 are read");
    input.deck("no TOML", &[("end = \"20 ms\"", "end = 20 ms")], "deck.toml:22");
    let curve = "[[prescribed]]\ngroup = \"x_max\"\ndirection = \"x\"\nquantity = \"displacement\"\ncurve = [[0, 0], [2, 1], [1, 1]]\n";
    input.addition("curve that does not increase", curve, &[], 2, "deck.toml:31:26");
    input.addition(
        "several at once",
        "[[fix]]\ngroup = \"x_mim\"\ndirection = [\"x\"]\n",
        &["--set", "time.end=1"],
        2,
        "x_min",
    );
    input.addition("value of the command line", "", &["--set", "time.end='1 mm'"], 2, "--set");
    let mesh = input.mesh.clone();
    fs::write(input.workshop.path("latin.toml"), b"title = \"caf\xe9\"").unwrap();
    let said = input.workshop.estar(&["run", "latin.toml"]);
    input.enter("text in another encoding", &said, 2, "latin.toml:1");
    let said = input.workshop.estar(&["run", "no.toml"]);
    input.enter("deck that is not there", &said, 4, "no.toml");

    input.section("Mesh");
    let missing = replaced(DECK, &[("box.msh", "bocks.msh")]);
    input.answer("mesh that is not there", &missing, b"", &[], 4, "bocks.msh");
    input.answer("no mesh", DECK, b"solid cube\nfacet normal 0 0 1\n", &[], 2, "box.msh");
    input.answer("garbage", DECK, b"\x7fELF\x02\x01\x01\0\0\0\xff\xfe", &[], 2, "box.msh");
    input.answer("cut short", DECK, &mesh.as_bytes()[..mesh.len() * 2 / 3], &[], 2, "box.msh:84");
    input.answer("format that is not read", DECK, b"    -1\n  2411\n", &[], 2, "an I-deas universal file");
    input.mesh("wrong version", &[("4.1 0 8", "3.0 0 8")], "Gmsh format 3.0");
    let quadratic = format!("8 33 1 33 \n3 1 17 1 \n33{}\n3 1 5 8 \n", " 1".repeat(20));
    input.mesh("elements that are not supported", &[("7 32 1 32 \n3 1 5 8 \n", &quadratic)], "element 33");
    input.mesh("inverted hex", &[("1 1 2 5 4 10 11 14 13", "1 10 11 14 13 1 2 5 4")], "element 1");
    input.mesh("degenerate hex", &[("1 1 2 5 4 10 11 14 13", "1 1 1 5 4 10 11 14 13")], "element 1");
    input.mesh("two hexes in one place", &[("2 2 3 6 5 11 12 15 14", "2 1 2 5 4 10 11 14 13")], "elements 1 and 2");
    input.mesh("node that is not there", &[("1 1 2 5 4 10 11 14 13", "1 1 2 5 4 10 11 14 99")], "box.msh:");
    input.mesh("coordinate that is no number", &[("\n0.5 0.0 0.0 \n", "\nnan 0.0 0.0 \n")], "node 2");
    input.mesh("word where a number should be", &[("\n0.5 0.0 0.0 \n", "\n0,5 0.0 0.0 \n")], "box.msh:");
    let hold = |group: &str| format!("{DECK}[[fix]]\ngroup = \"{group}\"\ndirections = [\"x\"]\n");
    let empty = replaced(&input.mesh, &[("7\n3 1 \"box\"", "8\n3 1 \"box\"\n2 9 \"top\"")]);
    input.answer("group without elements", &hold("top"), empty.as_bytes(), &[], 2, "surface \"top\"");
    let namesakes = replaced(&input.mesh, &[("2 2 \"x_min\"", "2 2 \"box\"")]);
    input.answer("name of two groups", &hold("box"), namesakes.as_bytes(), &[], 2, "`surface.box`");
    input.mesh(
        "counts that lie",
        &[("1 27 1 27 \n3 1 0 27 ", "1 99999999999999 1 27 \n3 1 0 99999999999999 ")],
        "box.msh:",
    );
    input.mesh("name that is too long", &[("3 1 \"box\"", &format!("3 1 \"{long}\""))], "up to 255 are read");
    input.mesh(
        "name that turns the direction of writing",
        &[("3 1 \"box\"", "3 1 \"b\u{202e}x\"")],
        "direction of writing",
    );
    input.mesh("number used twice", &[("2 2 3 6 5 11 12 15 14", "1 2 3 6 5 11 12 15 14")], "element number 1");

    input.section("Model");
    let fix = "[[fix]]\ngroup = \"x_min\"\ndirections = [\"y\"]\n";
    let pull = "[[prescribed]]\ngroup = \"z_max\"\ndirection = \"y\"\nquantity = \"displacement\"\ncurve = [[0, 0], [1, 0.1]]\n";
    let jump = pull.replace("[1, 0.1]", "[0.01, 0], [0.010000001, 0.1]");
    input.addition("displacement that jumps", &jump, &[], 2, "deck.toml:27");
    let idle = "[[probe]]\nname = \"force\"\nkind = \"reaction\"\ngroup = \"x_max\"\ndirection = \"y\"\n";
    input.addition("reaction where nothing is held", &format!("{fix}{idle}"), &[], 2, "nothing holds or drives");
    input.addition("nodes that are held and moved", &format!("{fix}{pull}"), &[], 2, "both fixed and prescribed");
    let twice = "[[part]]\ngroup = \"box\"\nmaterial = \"rubber\"\n";
    let tets = ["--set", "part.0.element='tet10'"];
    input.addition("hexes in a part of tets", "", &tets, 2, "--set");
    input.addition("element in two parts", twice, &[], 2, "deck.toml");
    let half = replaced(
        &input.mesh,
        &[
            ("7\n3 1 \"box\"", "8\n3 1 \"box\"\n3 2 \"rest\""),
            ("0 0 6 1 ", "0 0 6 2 "),
            ("1 1 0 \n$EndEntities", "1 1 0 \n2 0.0 0.0 0.0 1.0 1.0 1.0 1 2 0 \n$EndEntities"),
            ("7 32 1 32 \n3 1 5 8 \n", "8 32 1 32 \n3 1 5 6 \n"),
            ("7 13 14 17 16 22 23 26 25", "3 2 5 2 \n7 13 14 17 16 22 23 26 25"),
        ],
    );
    input.answer("elements without a material", DECK, half.as_bytes(), &[], 2, "no part: 7, 8");
    let wall = "[[rigid_wall]]\npoint = [0.5, 0, 0]\nnormal = [1, 0, 0]\n";
    input.addition("body behind a wall", wall, &[], 2, "this wall");
    let ball = "[[rigid_wall]]\nshape = \"sphere\"\ncentre = [0.5, 0.5, 1.1]\nradius = 0.2\n";
    input.addition("body inside of a tool", ball, &[], 2, "the body is outside of the tool");
    let needle = "\n[[rigid_wall]]\nshape = \"cylinder\"\npoint = [0.5, 0.0, 1.2]\naxis = [0, 1, 0]\nradius = 0.2\n";
    input.addition("tool between nodes", needle, &[], 2, "elements of at most 2.0000e-1 m where it meets them");
    let held = "\n[[fix]]\ngroup = \"z_max\"\ndirections = [\"z\"]\n";
    let press = "\n[[rigid_wall]]\npoint = [0, 0, 1]\nnormal = [0, 0, -1]\nmotion = { direction = [0, 0, -1], quantity = \"velocity\", curve = [[0, 1.0]] }\n";
    input.addition("wall that moves into what is held", &format!("{held}{press}"), &[], 2, "behind the wall at t =");
    let force = "[[probe]]\nname = \"force\"\nkind = \"contact-force\"\nwall = \"anvil\"\ndirection = \"z\"\n";
    input.addition("force of a wall that is not there", force, &[], 2, "no rigid wall `anvil`");
    let heavy = "time.mass_scaling={ target_time_step = 1e-3 }";
    input.addition("more added mass than allowed", "", &["--set", heavy], 2, "stays within the limit");
    let slow = "time.quasi_static={ transits = 1e6 }";
    let resting = replaced(DECK, &[("[[initial_velocity]]\ngroup = \"box\"\nvalue = [1.0, 0.0, 0.0]\n", "")]);
    input.answer("process that is not slow", &resting, mesh.as_bytes(), &["--set", slow], 2, "too fast");
    let flying = &["--set", "time.quasi_static={}"];
    input.addition("slow process that begins in motion", "", flying, 2, "begins at rest");
    let twice = "time.mass_damping=1.0";
    let settings = &["--set", "time.quasi_static={}", "--set", twice];
    input.addition("damping that is chosen twice", "", settings, 2, "chooses the damping itself");
    input.addition("threads that no machine has", "", &["--threads", "100000"], 2, "4096");

    input.section("What is probably not meant");
    // the second layer of hexes has nodes of its own
    let apart = replaced(
        &input.mesh,
        &[
            ("1 27 1 27 \n3 1 0 27 \n", "1 31 1 31 \n3 1 0 31 \n28 \n29 \n30 \n31 \n"),
            ("\n0.0 0.0 0.0 \n", "\n0.5 0.5 0.5 \n1.0 0.5 0.5 \n0.5 1.0 0.5 \n1.0 1.0 0.5 \n0.0 0.0 0.0 \n"),
            ("8 14 15 18 17 23 24 27 26", "8 28 29 31 30 23 24 27 26"),
        ],
    );
    input.answer("nodes at one place that are not joined", DECK, apart.as_bytes(), &[], 0, "4 nodes lie exactly");
    let merge = replaced(DECK, &[("file = \"box.msh\"", "file = \"box.msh\"\nmerge = \"0.6 m\"")]);
    input.answer("merge of nodes that are no closer than others", &merge, mesh.as_bytes(), &[], 2, "would make one");
    let dense = replaced(DECK, &[("1000.0", "\"8.93 g/mm^3\"")]);
    input.answer("unit of another density", &dense, mesh.as_bytes(), &[], 0, "g/cm^3");
    let rod =
        ["mesh", "box", "--ascii", "--output", "rod.msh", "--size", "6.4", "6.4", "32.4", "--cells", "2", "2", "10"];
    input.workshop.estar(&rod).assert(0, &[]);
    let (rod, short) = (input.workshop.read("rod.msh"), replaced(DECK, &[("20 ms", "80 us")]));
    input.answer("mesh in mm without a scale", &short, rod.as_bytes(), &[], 0, "sound goes through");
    input.addition("time in seconds", "", &["--set", "time.end=1e6", "--stop-at-step", "2"], 0, "steps of");

    input.section("Run");
    let crush = "[[fix]]\ngroup = \"x_min\"\ndirections = [\"x\"]\n[[prescribed]]\ngroup = \"x_max\"\ndirection = \"x\"\n\
                 quantity = \"displacement\"\ncurve = [[0, 0], [\"20 ms\", -3]]\n";
    input.addition("element that inverts", crush, &["--set", "time.energy_error_limit=1e9"], 3, "element");
    let torn = crush.replace("displacement", "velocity").replace("-3", "1e300");
    input.addition("values that are not finite", &torn, &["--set", "time.energy_error_limit=1e300"], 3, "step 1");
    input.addition("energy that does not balance", crush, &["--set", "time.energy_error_limit=1e-3"], 3, "energy");
    let heavy = "time.mass_scaling={ factor = 4.0 }";
    input.addition("too much energy in added mass", "", &["--set", heavy], 3, "kinetic_limit");
    input.addition("too many steps", "", &["--set", "time.max_steps=3"], 3, "max_steps");

    input.section("Output and checkpoints");
    input.addition("output that is a file", "", &["--output", "box.msh"], 4, "box.msh is a file");
    input.addition("nothing to resume from", "", &["--resume"], 4, "no checkpoint");
    fs::write(input.workshop.path("box.msh"), &mesh).unwrap();
    input.workshop.run_deck(DECK, &["--stop-at-step", "3"]).assert(0, &[]);
    let said = input.workshop.estar(&["run", "deck.toml"]);
    input.enter("results that are there already", &said, 2, "--force");
    let said = input.workshop.estar(&["run", "deck.toml", "--resume", "--set", "time.end=1.0"]);
    input.enter("checkpoint of another deck", &said, 4, "another deck");
    let said = input.workshop.estar(&["run", "deck.toml", "--resume", "--set", "mesh.scale=2.0"]);
    input.enter("checkpoint of another mesh", &said, 4, "another mesh");
    let path = input.workshop.path("deck/checkpoint_000000000003.estar");
    let bytes = fs::read(&path).unwrap();
    let damages: [(&str, Vec<u8>, &str); 3] = [
        ("checkpoint with a wrong byte", [&bytes[..400], b"?", &bytes[401..]].concat(), "checksum"),
        // its length differs from run to run with the digits of the wall time, and so would the message for half of it
        ("checkpoint of which only the beginning is there", bytes[..20].to_vec(), "is no checkpoint"),
        ("checkpoint of another layout", [&bytes[..8], &9_u32.to_le_bytes(), &bytes[12..]].concat(), "layout 9"),
    ];
    for (what, damaged, reason) in damages {
        fs::write(&path, damaged).unwrap();
        let said = input.workshop.estar(&["run", "deck.toml", "--resume"]);
        input.enter(what, &said, 4, reason);
    }
    fs::write(&path, bytes).unwrap();
    fs::write(input.workshop.path("deck/history.csv"), "time,step\n").unwrap();
    let said = input.workshop.estar(&["run", "deck.toml", "--resume"]);
    input.enter("history of another run", &said, 4, "its columns are not those of this run");
    if cfg!(unix) {
        a_link_in_the_way(&mut input);
    }

    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/bad-input.md");
    if std::env::var_os("ESTAR_UPDATE_DOCS").is_some() {
        fs::write(&path, &input.page).unwrap();
    }
    let found = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        found == input.page,
        "docs/bad-input.md is stale: ESTAR_UPDATE_DOCS=1 cargo test --release --test bad_input"
    );
}

#[cfg(unix)]
fn a_link_in_the_way(input: &mut Input) {
    fs::create_dir(input.workshop.path("theirs")).unwrap();
    std::os::unix::fs::symlink("../deck.toml", input.workshop.path("theirs/history.csv")).unwrap();
    let said = input.workshop.estar(&["run", "deck.toml", "--output", "theirs"]);
    input.enter("link where results are to be written", &said, 4, "a link is in its place");
}

#[cfg(not(unix))]
fn a_link_in_the_way(_: &mut Input) {}
