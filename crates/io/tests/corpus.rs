//! Goal: every form that mesh files have in practice is read as its own program reads it. One small file for each form, in
//! `corpus/`, with the counts, groups and volume that follow from what it says.

mod common;

use std::fs;
use std::path::{Path, PathBuf};

use common::Folder;
use estar_io::{MeshFile, ReadError, read_mesh, read_mesh_within};
use estar_mesh::GroupKind::{Curve, Nodes, Surface, Volume};
use estar_mesh::quality::{QualityReport, volume};
use estar_mesh::{GroupError, GroupKind, Mesh, NodeLabel, Wanted};

/// Name, kind, and how many elements, faces and nodes.
type ExpectedGroup = (&'static str, GroupKind, [usize; 3]);

struct Form {
    file: &'static str,
    nodes: usize,
    elements: usize,
    volume: f64,
    /// All but the group of all elements, which is always there.
    groups: &'static [ExpectedGroup],
    /// What the warnings say, in their order.
    warnings: &'static [&'static str],
}

const FORMS: &[Form] = &[
    Form {
        file: "comma.inp",
        nodes: 12,
        elements: 2,
        volume: 2.0,
        groups: &[
            ("column", Volume, [2, 0, 12]),
            ("top", Surface, [0, 1, 4]),
            ("everything", Nodes, [0, 0, 12]),
            ("foot", Nodes, [0, 0, 4]),
        ],
        warnings: &[],
    },
    Form {
        file: "namesakes.inp",
        nodes: 12,
        elements: 2,
        volume: 2.0,
        groups: &[
            ("COLUMN", Volume, [2, 0, 12]),
            ("END", Volume, [1, 0, 8]),
            ("END", Surface, [0, 1, 4]),
            ("END", Nodes, [0, 0, 2]),
        ],
        warnings: &[],
    },
    Form {
        file: "owners.inp",
        nodes: 12,
        elements: 2,
        volume: 2.0,
        groups: &[
            ("part.Set-1", Volume, [2, 0, 12]),
            ("part.Set-1", Nodes, [0, 0, 12]),
            ("Foot", Nodes, [0, 0, 4]),
            ("assembly.Set-1", Volume, [1, 0, 8]),
            ("Top", Surface, [0, 1, 4]),
            ("assembly.Set-1", Nodes, [0, 0, 4]),
        ],
        warnings: &[
            "only the mesh is read; passed over: *BOUNDARY, *DENSITY, *ELASTIC, *END STEP, *MATERIAL, *RIGID BODY, \
             *SOLID SECTION, *STEP; what *RIGID BODY would join comes apart",
            "1 node belongs to no element and is left out: 1",
            "1 group has only such nodes and is left out: \"Reference\"",
        ],
    },
    Form {
        file: "moved.inp",
        nodes: 8,
        elements: 1,
        volume: 1.0,
        groups: &[("Set", Volume, [1, 0, 8])],
        warnings: &[],
    },
    Form {
        file: "two_instances.inp",
        nodes: 16,
        elements: 2,
        volume: 2.0,
        groups: &[
            ("Lower.ALL", Volume, [1, 0, 8]),
            ("Lower.Lid", Surface, [0, 1, 4]),
            ("Lower.Foot", Nodes, [0, 0, 4]),
            ("Upper.ALL", Volume, [1, 0, 8]),
            ("Upper.Lid", Surface, [0, 1, 4]),
            ("Upper.Foot", Nodes, [0, 0, 4]),
            ("Both", Volume, [2, 0, 16]),
            ("Ends", Surface, [0, 2, 8]),
            ("Corners", Nodes, [0, 0, 3]),
        ],
        warnings: &["those of some are larger here: Upper (nodes + 10, elements + 10)"],
    },
    Form {
        file: "two_parts.inp",
        nodes: 12,
        elements: 2,
        volume: 7.0 / 6.0,
        groups: &[("hex", Volume, [1, 0, 8]), ("tet", Volume, [1, 0, 4]), ("seam", Nodes, [0, 0, 2])],
        warnings: &["*PART, NAME=Unused, which has no instance"],
    },
    Form {
        file: "independent.inp",
        nodes: 8,
        elements: 1,
        volume: 1.0,
        groups: &[("Foot", Nodes, [0, 0, 4]), ("Corner", Nodes, [0, 0, 1])],
        warnings: &[],
    },
    Form {
        file: "cylindrical.inp",
        nodes: 12,
        elements: 2,
        // two quads between radii 1 and 2, each over 45 degrees
        volume: 3.0 * std::f64::consts::FRAC_1_SQRT_2,
        groups: &[("RING", Volume, [2, 0, 12])],
        warnings: &[],
    },
    Form {
        file: "spherical.inp",
        nodes: 4,
        elements: 1,
        volume: 8.0 / 6.0,
        groups: &[("TET", Volume, [1, 0, 4])],
        warnings: &[],
    },
    Form {
        file: "system.inp",
        nodes: 16,
        elements: 2,
        volume: 2.0,
        groups: &[("turned", Volume, [1, 0, 8]), ("straight", Volume, [1, 0, 8])],
        warnings: &[],
    },
    Form {
        file: "include/main.inp",
        nodes: 12,
        elements: 2,
        volume: 2.0,
        groups: &[("upper", Volume, [1, 0, 8]), ("foot", Nodes, [0, 0, 4]), ("rest", Nodes, [0, 0, 4])],
        warnings: &[],
    },
    Form {
        file: "reference_point.inp",
        nodes: 8,
        elements: 1,
        volume: 1.0,
        groups: &[("BLOCK", Volume, [1, 0, 8]), ("LID", Surface, [0, 1, 4]), ("MIXED", Nodes, [0, 0, 1])],
        warnings: &[
            "passed over: *COUPLING, *KINEMATIC; what *COUPLING would join comes apart",
            "2 nodes belong to no element and are left out: 1000, 2000",
            "\"REF\"",
        ],
    },
    Form {
        file: "shells.inp",
        nodes: 8,
        elements: 1,
        volume: 1.0,
        groups: &[
            ("BLOCK", Volume, [1, 0, 8]),
            ("SKIN", Surface, [0, 1, 4]),
            ("EDGE", Curve, [0, 0, 2]),
            ("EALL", Volume, [1, 0, 8]),
            ("OUTSIDE", Surface, [0, 1, 4]),
            ("MIXED", Surface, [0, 2, 8]),
        ],
        warnings: &[
            "left out (sets of them may name faces or nodes): 2 B31, 1 MASS, 1 S4R, 1 SPRINGA, 1 U1",
            "passed over: *SURFACE, TYPE=CYLINDER, *USER ELEMENT",
            "4 sets or surfaces have no nodes or faces of solids, and no group is made of them: \"SPRINGS\", \"LUMP\", \
             \"OWN\", \"SOFT\"",
            "no faces of solids or shells are left out: \"MIXED\" (4)",
            "1 node belongs to no element and is left out: 20",
        ],
    },
    Form {
        file: "amplitude_input.inp",
        nodes: 8,
        elements: 1,
        volume: 1.0,
        groups: &[("BLOCK", Volume, [1, 0, 8])],
        warnings: &["passed over: *AMPLITUDE"],
    },
    Form { file: "no_sets.inp", nodes: 8, elements: 1, volume: 1.0, groups: &[], warnings: &[] },
    Form {
        file: "collapsed.inp",
        nodes: 6,
        elements: 1,
        volume: 0.5,
        groups: &[("BLOCK", Volume, [1, 0, 6]), ("SIDE", Surface, [0, 1, 4])],
        warnings: &["\"SIDE\" (1)"],
    },
    Form {
        file: "quoted.inp",
        nodes: 12,
        elements: 2,
        volume: 2.0,
        groups: &[
            ("left, lower", Volume, [1, 0, 8]),
            ("my set", Volume, [1, 0, 8]),
            ("both", Volume, [2, 0, 12]),
            ("the top", Surface, [0, 1, 4]),
            ("all, of it", Nodes, [0, 0, 12]),
        ],
        warnings: &[],
    },
    Form {
        file: "free_surface.inp",
        nodes: 12,
        elements: 2,
        volume: 2.0,
        groups: &[
            ("COLUMN", Volume, [2, 0, 12]),
            ("WHOLE", Surface, [0, 10, 12]),
            ("LOWER", Surface, [0, 5, 8]),
            ("LID", Surface, [0, 1, 4]),
            ("FLOOR", Surface, [0, 1, 4]),
            ("ENDS", Surface, [0, 2, 8]),
        ],
        warnings: &[],
    },
    Form {
        file: "shapes.inp",
        nodes: 12,
        elements: 4,
        volume: 2.0,
        groups: &[
            ("HEX", Volume, [1, 0, 8]),
            ("WEDGE", Volume, [1, 0, 6]),
            ("PYRAMID", Volume, [1, 0, 5]),
            ("TET", Volume, [1, 0, 4]),
        ],
        warnings: &[],
    },
    Form {
        file: "same_name.msh",
        nodes: 4,
        elements: 1,
        volume: 1.0 / 6.0,
        groups: &[("block", Volume, [1, 0, 4]), ("block", Surface, [0, 1, 3])],
        warnings: &[],
    },
    Form {
        file: "name_without_elements.msh",
        nodes: 4,
        elements: 1,
        volume: 1.0 / 6.0,
        groups: &[("block", Volume, [1, 0, 4])],
        warnings: &["1 name stands for no elements of the file, and no group is made: surface \"lid\""],
    },
    Form {
        file: "no_groups.msh",
        nodes: 4,
        elements: 1,
        volume: 1.0 / 6.0,
        groups: &[
            ("volume_1", Volume, [1, 0, 4]),
            ("surface_3", Surface, [0, 1, 3]),
            ("surface_4", Surface, [0, 1, 3]),
        ],
        warnings: &[],
    },
    Form { file: "no_tags.msh", nodes: 4, elements: 1, volume: 1.0 / 6.0, groups: &[], warnings: &[] },
    Form {
        file: "centre_point.msh",
        nodes: 4,
        elements: 1,
        volume: 1.0 / 6.0,
        groups: &[("block", Volume, [1, 0, 4])],
        warnings: &["1 node belongs to no element and is left out: 5", "\"point_5\""],
    },
    Form {
        file: "one_name_twice.msh",
        nodes: 5,
        elements: 2,
        volume: 0.5,
        groups: &[("block", Volume, [2, 0, 5])],
        warnings: &["the physical volume 2 is named \"block\" as another is: both are one group"],
    },
    Form {
        file: "padded_name.msh",
        nodes: 4,
        elements: 1,
        volume: 1.0 / 6.0,
        groups: &[("block", Volume, [1, 0, 4])],
        warnings: &[],
    },
    Form {
        file: "unnamed_physical.msh",
        nodes: 5,
        elements: 2,
        volume: 0.5,
        groups: &[("physical.volume_1", Volume, [1, 0, 4]), ("entity.volume_1", Volume, [1, 0, 4])],
        warnings: &[],
    },
    Form {
        file: "version_4_0.msh",
        nodes: 4,
        elements: 1,
        volume: 1.0 / 6.0,
        groups: &[("block", Volume, [1, 0, 4]), ("foot", Surface, [0, 1, 3])],
        warnings: &[],
    },
    Form {
        file: "parametric.msh",
        nodes: 4,
        elements: 1,
        volume: 1.0 / 6.0,
        groups: &[("volume_1", Volume, [1, 0, 4])],
        warnings: &[],
    },
];

fn path(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus").join(file)
}

fn read(file: &str) -> MeshFile {
    read_mesh(&path(file)).unwrap_or_else(|error| panic!("{error}"))
}

fn error(file: &str) -> String {
    read_mesh(&path(file)).unwrap_err().to_string()
}

fn whole_volume(mesh: &Mesh) -> f64 {
    (0..mesh.element_count()).map(|k| volume(mesh.elements().shape(k), &mesh.positions(k))).sum()
}

#[test]
fn every_form_has_its_counts_groups_and_volume() {
    for form in FORMS {
        let MeshFile { mesh, warnings, .. } = read(form.file);
        let file = form.file;
        assert_eq!((mesh.node_count(), mesh.element_count()), (form.nodes, form.elements), "{file}");
        let found = whole_volume(&mesh);
        assert!((found - form.volume).abs() < 1e-12 * form.volume, "{file}: volume {found}, not {}", form.volume);
        assert!(QualityReport::new(&mesh).errors().is_empty(), "{file}");
        let sizes = |group: &estar_mesh::Group| [group.elements.len(), group.faces.len(), group.nodes.len()];
        let named = mesh.groups().iter().zip(mesh.full_names());
        let groups: Vec<_> = named.map(|(group, name)| (name, group.kind, sizes(group))).collect();
        let all = [("all", Volume, [form.elements, 0, form.nodes])];
        let expected: Vec<_> =
            form.groups.iter().chain(&all).map(|(name, kind, sizes)| (name.to_string(), *kind, *sizes)).collect();
        assert_eq!(groups, expected, "{file}");
        assert_eq!(warnings.len(), form.warnings.len(), "{file}: {warnings:#?}");
        for (warning, expected) in warnings.iter().zip(form.warnings) {
            assert!(warning.contains(expected), "{file}: {warning}");
        }
    }
}

#[test]
fn every_file_of_the_corpus_is_in_the_list() {
    let listed = |name: &str| name.starts_with("bad_") || FORMS.iter().any(|form| form.file == name);
    for entry in fs::read_dir(path("")).unwrap() {
        let entry = entry.unwrap();
        let name = entry.file_name().into_string().unwrap();
        assert!(entry.path().is_dir() || listed(&name), "{name}");
    }
}

#[test]
fn instances_are_moved_and_turned_and_systems_turn_nodes() {
    let near = |file: &str, expected: [[f64; 3]; 2]| {
        let extent = read(file).mesh.extent();
        let differs = |(a, b): (&f64, &f64)| (a - b).abs() > 1e-12;
        assert!(!extent.as_flattened().iter().zip(expected.as_flattened()).any(differs), "{file}: {extent:?}");
    };
    near("moved.inp", [[0.0, 2.0, 0.0], [1.0, 3.0, 1.0]]);
    near("independent.inp", [[0.0, 0.0, 4.0], [1.0, 1.0, 5.0]]);
    near("two_instances.inp", [[0.0; 3], [1.0, 1.0, 2.0]]);
    near("system.inp", [[0.0; 3], [11.0, 1.0, 1.0]]);
    let turned = read("system.inp").mesh;
    // the first axis is z, the second x, the third y
    assert_eq!(turned.coordinates()[1], [10.0, 0.0, 1.0]);
    assert_eq!(turned.coordinates()[3], [11.0, 0.0, 0.0]);
    assert_eq!(turned.coordinates()[4], [10.0, 1.0, 0.0]);
}

#[test]
fn numbers_of_instances_are_kept_where_they_differ() {
    let labels = |file: &str| read(file).mesh.node_labels().to_vec();
    assert_eq!(labels("two_parts.inp")[8..], [11, 12, 13, 14].map(NodeLabel));
    assert_eq!(labels("two_instances.inp")[7..9], [8, 11].map(NodeLabel));
}

#[test]
fn a_place_gets_the_group_that_it_asks_for() {
    let mesh = read("namesakes.inp").mesh;
    let labels = |nodes: &[u32]| nodes.iter().map(|&node| mesh.node_labels()[node as usize].0).collect::<Vec<_>>();
    assert_eq!(labels(&mesh.find("END", Wanted::Nodes).unwrap().nodes), [9, 10]);
    assert_eq!(mesh.find("END", Wanted::Elements).unwrap().elements, [0]);
    assert_eq!(labels(&mesh.find("END", Wanted::Faces).unwrap().nodes), [9, 10, 11, 12]);

    let mesh = read("owners.inp").mesh;
    for (wanted, part, assembly) in [(Wanted::Nodes, 12, 4), (Wanted::Elements, 12, 8)] {
        let Err(GroupError::Ambiguous(both)) = mesh.find("Set-1", wanted) else { panic!("one is taken") };
        let names: Vec<String> = both.iter().map(|group| mesh.name_to_find(group, wanted)).collect();
        assert_eq!(names, ["part.Set-1", "assembly.Set-1"]);
        assert_eq!(mesh.find("part.Set-1", wanted).unwrap().nodes.len(), part);
        assert_eq!(mesh.find("Column-1.Set-1", wanted).unwrap().nodes.len(), part);
        assert_eq!(mesh.find("assembly.Set-1", wanted).unwrap().nodes.len(), assembly);
    }

    let mesh = read("same_name.msh").mesh;
    assert_eq!(mesh.find("block", Wanted::Elements).unwrap().nodes.len(), 4);
    assert!(matches!(mesh.find("block", Wanted::Nodes), Err(GroupError::Ambiguous(_))));
    assert_eq!(mesh.find("surface.block", Wanted::Nodes).unwrap().nodes.len(), 3);
}

#[test]
fn what_cannot_be_right_is_refused_with_what_to_do() {
    let second = error("bad_second_order.inp");
    assert!(second.contains("2 of type C3D20R (the first is element 1): hexes and wedges of second order"), "{second}");
    let glued = error("bad_cohesive.inp");
    assert!(glued.contains("bad_cohesive.inp:23: cohesive or gasket elements hold bodies together"), "{glued}");
    assert!(glued.contains("1 of type COH3D8 (the first is element 3)"), "{glued}");
    let shells = error("bad_shells_only.inp");
    assert!(shells.contains("no solid elements, only 1 of type B31, 2 of type S4R"), "{shells}");
    assert!(error("bad_dyna.k").contains("keyword file of LS-DYNA"));
}

#[test]
fn an_include_that_cannot_be_read_is_told_with_the_line_that_names_it() {
    let folder = Folder::new("includes");
    fs::create_dir_all(&folder.0).unwrap();
    let at = |name: &str| folder.0.join(name);
    let main = at("main.inp");
    let told = |content: &str| {
        fs::write(&main, content).unwrap();
        read_mesh(&main).unwrap_err()
    };
    let missing = told("*HEADING\n*INCLUDE, INPUT=no.inc\n");
    assert!(missing.is_unreadable(), "{missing}");
    assert!(
        missing.to_string().contains("no.inc, which") && missing.to_string().contains("main.inp:2 names"),
        "{missing}"
    );
    fs::write(at("loop.inc"), "*INCLUDE, INPUT=main.inp\n").unwrap();
    let turns = told("*INCLUDE, INPUT=loop.inc\n");
    assert!(turns.to_string().contains("loop.inc:1: the file main.inp, which includes itself,"), "{turns}");
    // what is wrong in an included file is shown with that file's name and line
    fs::write(at("bad.inc"), "*NODE\n1, 0., zero, 0.\n").unwrap();
    let bad = told("*INCLUDE, INPUT=bad.inc\n");
    assert!(bad.to_string().contains("bad.inc:2: a coordinate: expected a number, found \"zero\""), "{bad}");
    for device in ["/dev/zero", "/dev/stdin", "."] {
        let refused = told(&format!("*INCLUDE, INPUT={device}\n"));
        assert!(matches!(refused, ReadError::Unreadable { .. }), "{refused}");
    }
    // a line that ends in a comma at the end of the file
    fs::copy(path("no_sets.inp"), at("whole.inc")).unwrap();
    for end in ["", ",", ",\n", "\n\n"] {
        fs::write(&main, format!("*INCLUDE, INPUT=whole.inc{end}")).unwrap();
        assert_eq!(read_mesh(&main).unwrap().mesh.element_count(), 1, "{end:?}");
    }
    let unknown = "*INCLUDE, INPUT=whole.inc\n*NSET, NSET=a, INSTANCE=b\n1\n";
    fs::write(&main, unknown).unwrap();
    assert!(read_mesh(&main).is_ok(), "a flat file may name the instance that it had");
    assert!(told("*INCLUDE\n").to_string().contains("*INCLUDE needs INPUT=file"));
    assert!(told("*INCLUDE, INPUT=\n").to_string().contains("names no file after INPUT="));
}

#[test]
fn includes_end_however_they_are_nested() {
    let folder = Folder::new("nested");
    fs::create_dir_all(&folder.0).unwrap();
    let at = |name: String| folder.0.join(name);
    let nodes = fs::read_to_string(path("no_sets.inp")).unwrap();
    // one in another, 25 deep
    for depth in 0..25 {
        fs::write(at(format!("{depth}.inc")), format!("*INCLUDE, INPUT={}.inc\n", depth + 1)).unwrap();
    }
    fs::write(at("25.inc".into()), &nodes).unwrap();
    let deep = read_mesh(&at("0.inc".into())).unwrap_err().to_string();
    assert!(deep.contains("in more than 20 files in one another"), "{deep}");
    assert_eq!(read_mesh(&at("10.inc".into())).unwrap().mesh.element_count(), 1);
    // each includes the next one twice: 2^12 files, were there no limit
    for depth in 0..12 {
        let twice = format!("*INCLUDE, INPUT=t{}.inc\n", depth + 1).repeat(2);
        fs::write(at(format!("t{depth}.inc")), twice).unwrap();
    }
    fs::write(at("t12.inc".into()), "*NSET, NSET=a\n1\n").unwrap();
    let wide = read_mesh(&at("t0.inc".into())).unwrap_err().to_string();
    assert!(wide.contains("more than 10 times"), "{wide}");
}

#[test]
fn copies_of_parts_have_a_limit() {
    let part = fs::read_to_string(path("two_instances.inp")).unwrap();
    let end = part.find("*ASSEMBLY").unwrap();
    let mut copies = part[..end].to_owned();
    // a part of 8,000 nodes more, 2,000 times
    let nodes: String = (9..8009).map(|label| format!("{label},\n")).collect();
    copies = copies.replace("*ELEMENT", &format!("{nodes}*ELEMENT"));
    for instance in 0..2000 {
        copies += &format!("*INSTANCE, NAME=i{instance}, PART=Block\n*END INSTANCE\n");
    }
    let error = estar_io::read_mesh_bytes(copies.as_bytes(), "copies").unwrap_err().to_string();
    assert!(error.contains("more than 10 million nodes or elements in copies of parts"), "{error}");
}

/// The program compares a mesh with the memory that is left: every file counts, each time that it is included.
#[test]
fn included_files_count_where_memory_is_short() {
    let folder = Folder::new("memory");
    fs::create_dir_all(&folder.0).unwrap();
    let main = folder.0.join("main.inp");
    let nodes = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus/no_sets.inp")).unwrap();
    fs::write(folder.0.join("part.inp"), &nodes).unwrap();
    fs::write(&main, "*INCLUDE, INPUT=part.inp\n").unwrap();
    let size = (fs::metadata(&main).unwrap().len() as usize + nodes.len()) as u64;
    assert!(read_mesh_within(&main, size).is_ok());
    let told = read_mesh_within(&main, size - 1).unwrap_err();
    assert!(!told.is_unreadable());
    assert!(told.to_string().ends_with(
        "main.inp:1: the mesh, with all that it includes or is unpacked to, has more than 0 MB, which is what memory is left \
         for; take a coarser mesh or a machine with more memory, or end other programs"
    ), "{told}");
    assert!(read_mesh_within(&main, 3).unwrap_err().to_string().contains("main.inp: the mesh, with all"));
}
