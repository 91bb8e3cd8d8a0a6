//! What mesh files say, and what is said about bad ones.

mod common;

use common::{abaqus, gmsh22, gmsh41, sample, with_all};
use estar_io::{Place, Problem, ReadError, read_mesh, read_mesh_bytes};
use estar_mesh::{ElementLabel, Face, GroupKind, Mesh, MeshError, NodeLabel, Wanted};

fn read(bytes: &[u8]) -> Mesh {
    read_mesh_bytes(bytes, "a.msh").unwrap().mesh
}

fn error(bytes: &[u8]) -> String {
    read_mesh_bytes(bytes, "a.msh").unwrap_err().to_string()
}

fn problem(bytes: &[u8]) -> Problem {
    match read_mesh_bytes(bytes, "a.msh").unwrap_err() {
        ReadError::Content { problem, .. } => *problem,
        other => panic!("{other}"),
    }
}

/// The sample as Gmsh 4.1 text with something replaced.
fn changed(from: &str, to: &str) -> Vec<u8> {
    changed_in(&gmsh41(&sample(), false), from, to)
}

fn changed_in(file: &[u8], from: &str, to: &str) -> Vec<u8> {
    let text = String::from_utf8(file.to_vec()).unwrap();
    assert!(text.contains(from), "{from:?} is not in\n{text}");
    text.replacen(from, to, 1).into_bytes()
}

/// The least file: one hex of group "b", on lines that the tests below know by number.
const ONE_HEX: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"b\"\n$EndPhysicalNames\n\
    $Entities\n0 0 0 1\n1 0 0 0 1 1 1 1 1 0\n$EndEntities\n$Nodes\n1 8 1 8\n3 1 0 8\n1\n2\n3\n4\n5\n6\n7\n8\n\
    0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n$EndNodes\n$Elements\n1 1 1 1\n3 1 5 1\n\
    1 1 2 3 4 5 6 7 8\n$EndElements\n";

#[test]
fn every_format_gives_the_same_mesh() {
    let mesh = sample();
    for file in [gmsh41(&mesh, false), gmsh41(&mesh, true), gmsh22(&mesh, false), gmsh22(&mesh, true)] {
        assert_eq!(read(&file), with_all(&mesh));
    }
    // Abaqus knows no curves: the edge is a set of nodes.
    let file = read_mesh_bytes(&abaqus(&mesh), "a.inp").unwrap();
    assert_eq!(file.mesh.elements(), mesh.elements());
    assert_eq!(file.mesh.coordinates(), mesh.coordinates());
    assert_eq!(file.mesh.element_labels(), mesh.element_labels());
    assert_eq!(file.mesh.group("edge").unwrap().nodes, mesh.group("edge").unwrap().nodes);
    assert_eq!(file.mesh.group("box").unwrap().elements, mesh.group("box").unwrap().elements);
    let outward = |mesh: &Mesh| {
        let mut faces = mesh.outward_faces(mesh.group("z_max").unwrap()).unwrap();
        faces.sort_unstable_by_key(Face::key);
        faces
    };
    assert_eq!(outward(&file.mesh), outward(&mesh));
    assert!(file.mesh.group("_top").is_none(), "internal sets are no groups");
    assert_eq!(file.warnings, ["only the mesh is read; passed over: *DENSITY, *MATERIAL"]);
}

#[test]
fn the_format_is_told_by_the_content() {
    let format = |bytes: &[u8]| read_mesh_bytes(bytes, "mesh.txt").unwrap().format;
    let mesh = sample();
    assert_eq!(format(&gmsh22(&mesh, true)), "Gmsh 2.2, binary");
    assert_eq!(format(&abaqus(&mesh)), "Abaqus");
    assert!(matches!(problem(b"some words"), Problem::UnknownFormat));
    assert!(matches!(problem(b""), Problem::UnknownFormat));
    for (file, told) in [
        ("[mesh]\nfile = \"a.msh\"\n", "a deck, not a mesh, which is not read; `estar check` and `estar run` take it"),
        (" MeshVersionFormatted 2\n Dimension\n 3\n", "a Medit mesh (.mesh), which is not read; convert it: gmsh"),
        ("NDIME= 3\nNELEM= 144\n", "a mesh of SU2, which is not read; write the mesh as"),
    ] {
        assert!(error(file.as_bytes()).contains(told), "{}", error(file.as_bytes()));
    }
    assert!(error(b"\x7fELF\0\0").contains("not a mesh this program knows"));
}

#[test]
fn line_ends_and_byte_order_marks_of_other_systems_are_read() {
    for file in [gmsh41(&sample(), false), gmsh22(&sample(), false), abaqus(&sample())] {
        let text = String::from_utf8(file.clone()).unwrap();
        let windows = format!("\u{feff}\r\n{}", text.replace('\n', " \r\n"));
        assert_eq!(read(windows.as_bytes()), read(&file));
    }
}

#[test]
fn a_missing_file_is_unreadable_and_a_bad_one_is_not() {
    let missing = read_mesh(std::path::Path::new("/no/such/mesh.msh")).unwrap_err();
    assert!(missing.is_unreadable() && missing.to_string().starts_with("/no/such/mesh.msh: cannot be read"));
    assert!(!read_mesh_bytes(b"x", "a").unwrap_err().is_unreadable());
}

#[test]
fn an_element_with_a_missing_node_is_named_with_its_line() {
    let bytes = changed_in(ONE_HEX.as_bytes(), "1 1 2 3 4 5 6 7 8", "1 1 2 3 4 5 6 7 99");
    assert_eq!(error(&bytes), "a.msh:35: element 1 refers to node 99, which the file does not have");
    let old = changed_in(&gmsh22(&sample(), false), "14 5 2 1 7 40", "14 5 2 1 7 41");
    assert_eq!(error(&old), "a.msh:34: element 14 refers to node 41, which the file does not have");
    let abaqus = changed_in(&abaqus(&sample()), "14, 40,", "14, 41,");
    assert_eq!(error(&abaqus), "a.msh:25: element 14 refers to node 41, which the file does not have");
}

#[test]
fn a_missing_node_in_a_binary_file_is_named_with_its_byte() {
    let mut bytes = gmsh41(&sample(), true);
    // The last element is the point: its node is the last number before the section's end.
    let at = bytes.len() - b"\n$EndElements\n".len() - 8;
    bytes[at..at + 8].copy_from_slice(&99_u64.to_le_bytes());
    let error = read_mesh_bytes(&bytes, "a.msh").unwrap_err();
    assert_eq!(error.place(), Some(Place::Byte(at as u64 - 8)));
    assert!(error.to_string().contains("refers to node 99"), "{error}");
}

#[test]
fn numbers_used_twice_are_named() {
    let twice = changed_in(ONE_HEX.as_bytes(), "\n7\n8\n", "\n7\n7\n");
    let twice = changed_in(&twice, "6 7 8\n", "6 7 7\n");
    assert!(matches!(problem(&twice), Problem::Mesh(MeshError::DuplicateNodeLabel { node: NodeLabel(7) })));
    let twice = changed("13 ", "12 ");
    assert!(matches!(problem(&twice), Problem::Mesh(MeshError::DuplicateElementLabel { element: ElementLabel(12) })));
}

#[test]
fn coordinates_that_are_not_finite_are_named() {
    for bad in ["nan", "inf", "-inf", "1e999"] {
        let bytes = changed_in(ONE_HEX.as_bytes(), "\n1 1 0\n", &format!("\n1 {bad} 0\n"));
        assert!(error(&bytes).contains("node 3: its y coordinate"), "{}", error(&bytes));
        let old = gmsh22(&sample(), false);
        assert!(error(&changed_in(&old, "\n40 0 0 0", &format!("\n40 0 {bad} 0"))).contains("node 40: its y"));
    }
    let mut binary = gmsh41(&sample(), true);
    let at = binary.windows(9).position(|window| window == b"\n$EndNode").unwrap() - 8;
    binary[at..at + 8].copy_from_slice(&f64::NAN.to_le_bytes());
    assert!(error(&binary).contains("node 6: its z coordinate is NaN"), "{}", error(&binary));
}

#[test]
fn a_word_that_is_no_number_is_shown_with_its_line() {
    let bytes = changed_in(ONE_HEX.as_bytes(), "\n1 1 0\n", "\n1 one 0\n");
    assert!(error(&bytes).starts_with("a.msh:25: "), "{}", error(&bytes));
    let bytes = changed_in(&gmsh22(&sample(), false), "\n40 0 0 0", "\n40 0 zero 0");
    assert_eq!(error(&bytes), "a.msh:13: a coordinate: expected a number, found \"zero\"");
    let bytes = changed_in(&abaqus(&sample()), "  40, 0, 0,", "  40, 0, O,");
    assert_eq!(error(&bytes), "a.msh:6: a coordinate: expected a number, found \"O\"");
}

#[test]
fn words_run_together_are_an_error_and_not_other_numbers() {
    for (from, to) in
        [("\n1 1 0\n", "\n1-1 0 0\n"), ("\n1 1 0\n", "\n1 1-0\n"), ("6 7 8\n", "6 7-8 1\n"), ("\n2\n", "\n2.\n")]
    {
        error(&changed_in(ONE_HEX.as_bytes(), from, to));
    }
}

#[test]
fn a_named_group_without_elements_is_left_out_and_told() {
    let bytes = changed_in(ONE_HEX.as_bytes(), "1\n3 1 \"b\"", "2\n3 1 \"b\"\n2 5 \"foot\"");
    let file = read_mesh_bytes(&bytes, "a.msh").unwrap();
    assert!(file.mesh.group("foot").is_none());
    assert_eq!(file.warnings, ["1 name stands for no elements of the file, and no group is made: surface \"foot\""]);
    let bytes = [&abaqus(&sample())[..], b"*NSET, NSET=nothing\n"].concat();
    let file = read_mesh_bytes(&bytes, "a.inp").unwrap();
    assert!(file.warnings.iter().any(|warning| warning.ends_with("no group is made of them: \"nothing\"")));
}

#[test]
fn a_group_without_a_name_is_called_by_its_number() {
    let bytes = changed_in(ONE_HEX.as_bytes(), "$PhysicalNames\n1\n3 1 \"b\"\n$EndPhysicalNames\n", "");
    assert_eq!(read(&bytes).groups()[0].name, "volume_1");
}

#[test]
fn a_hex_in_no_group_is_legal() {
    let bytes = changed_in(ONE_HEX.as_bytes(), "$PhysicalNames\n1\n3 1 \"b\"\n$EndPhysicalNames\n", "");
    let bytes = changed_in(&bytes, "1 0 0 0 1 1 1 1 1 0", "1 0 0 0 1 1 1 0 0");
    let mesh = read(&bytes);
    // by its entity, and the group of all elements
    let names: Vec<&str> = mesh.groups().iter().map(|group| group.name.as_str()).collect();
    assert_eq!(names, ["volume_1", "all"]);
}

#[test]
fn elements_of_other_kinds_are_counted_and_named() {
    let bytes = changed_in(
        ONE_HEX.as_bytes(),
        "1 1 1 1\n3 1 5 1\n",
        &format!("2 3 1 3\n3 1 17 2\n21 {0}\n22 {0}\n3 1 5 1\n", "1 ".repeat(20)),
    );
    let message = error(&bytes);
    assert!(message.contains("2 20-node hexahedra (the first is element 21): set Mesh.ElementOrder = 1"), "{message}");
    let bytes = changed_in(ONE_HEX.as_bytes(), "3 1 5 1\n1 1", "3 1 92 1\n1 1");
    assert!(matches!(problem(&bytes), Problem::UnknownElementType { element: 1, code: 92 }));
    let bytes =
        changed_in(&gmsh22(&sample(), false), "14 5 2 1 7", &format!("14 17 2 1 7 {}\n14 5 2 1 7", "40 ".repeat(20)));
    let bytes = changed_in(&bytes, "$Elements\n11", "$Elements\n12");
    assert!(error(&bytes).contains("1 20-node hexahedra (the first is element 14)"), "{}", error(&bytes));
    let bytes = changed_in(&abaqus(&sample()), "C3D8R", "C3D20");
    assert!(error(&bytes).contains("of type C3D20 (the first is element 14)"), "{}", error(&bytes));
}

#[test]
fn other_versions_sizes_and_byte_orders_are_refused_with_advice() {
    let header = |line: &str| changed_in(ONE_HEX.as_bytes(), "4.1 0 8", line);
    assert!(error(&header("3.0 0 8")).contains("Gmsh format 3.0 is not supported; convert it: gmsh"));
    assert!(error(&header("4.1 0 4")).contains("data size is 4"));
    assert!(matches!(problem(&header("4.1 0")), Problem::GmshHeader { .. }));
    assert!(matches!(problem(&header("4.1 2 8")), Problem::GmshHeader { .. }));
    let big = b"$MeshFormat\n4.1 1 8\n\0\0\0\x01\n$EndMeshFormat\n";
    assert!(matches!(problem(big), Problem::BigEndian));
    assert!(matches!(problem(b"$NOD\n1\n"), Problem::GmshVersion { .. }));
}

#[test]
fn counts_that_lie_cost_nothing() {
    let huge = 100_000_000_000_000_u64;
    for (from, to) in [
        ("1 8 1 8\n3 1 0 8\n", format!("1 {huge} 1 8\n3 1 0 {huge}\n")),
        ("1 8 1 8\n", format!("{huge} 8 1 8\n")),
        ("1 1 1 1\n3 1 5 1\n", format!("1 {huge} 1 1\n3 1 5 {huge}\n")),
        ("0 0 0 1\n", format!("0 0 0 {huge}\n")),
        ("1 0 0 0 1 1 1 1 1 0", format!("1 0 0 0 1 1 1 {huge} 1 0")),
        ("1\n3 1 \"b\"", format!("{huge}\n3 1 \"b\"")),
        ("1 8 1 8\n3 1 0 8\n", format!("1 {0} 1 8\n3 1 0 {0}\n", u64::MAX)),
    ] {
        error(&changed_in(ONE_HEX.as_bytes(), from, &to));
    }
    let binary = gmsh41(&sample(), true);
    for at in 0..binary.len() - 8 {
        let mut bytes = binary.clone();
        bytes[at..at + 8].copy_from_slice(&(huge / 3).to_le_bytes());
        // Many of these are other coordinates or numbers, and fine.
        let _ = read_mesh_bytes(&bytes, "a.msh");
    }
    let old = gmsh22(&sample(), false);
    error(&changed_in(&old, "$Nodes\n18\n", &format!("$Nodes\n{huge}\n")));
    error(&changed_in(&old, "$Elements\n11\n", &format!("$Elements\n{huge}\n")));
    let range = |numbers: &str| {
        [&abaqus(&sample())[..], format!("*NSET, NSET=many, GENERATE\n{numbers}\n").as_bytes()].concat()
    };
    let nowhere = error(&range(&format!("1000000, {}", u64::MAX)));
    assert!(nowhere.contains("\"many\" refers to node 1000000, which the file does not have"), "{nowhere}");
    let mesh = read(&range(&format!("0, {}", u64::MAX - 1)));
    assert_eq!(mesh.group("many").unwrap().nodes.len(), mesh.node_count());
}

#[test]
fn totals_must_be_the_sum_of_their_blocks() {
    let bytes = changed_in(ONE_HEX.as_bytes(), "1 8 1 8\n", "1 9 1 9\n");
    assert!(matches!(problem(&bytes), Problem::CountMismatch { what: "nodes", announced: 9, found: 8 }));
}

#[test]
fn missing_and_repeated_sections_are_named() {
    let without = ONE_HEX.split("$Elements").next().unwrap();
    assert!(error(without.as_bytes()).contains("no section $Elements"));
    let twice = ONE_HEX.replace("$Elements", "$Nodes\n1 1 1 1\n0 1 0 1\n9\n0 0 0\n$EndNodes\n$Elements");
    assert!(matches!(problem(twice.as_bytes()), Problem::SecondSection { section: "Nodes" }));
    let unknown = ONE_HEX.replace("$Nodes\n", "$Comments\n$ anything\n$EndComments\n$Nodes\n");
    assert_eq!(read(unknown.as_bytes()).element_count(), 1);
}

#[test]
fn partitioned_meshes_are_refused_with_advice() {
    let bytes =
        changed_in(ONE_HEX.as_bytes(), "$Nodes\n", "$PartitionedEntities\n1\n$EndPartitionedEntities\n$Nodes\n");
    assert!(matches!(problem(&bytes), Problem::Partitioned));
}

#[test]
fn names_that_are_not_text_are_refused() {
    let mut bytes = ONE_HEX.as_bytes().to_vec();
    let at = bytes.iter().position(|byte| *byte == b'"').unwrap() + 1;
    bytes[at] = 0xff;
    assert_eq!(problem(&bytes), Problem::NameNotUtf8);
    let bytes = [&abaqus(&sample())[..], b"*NSET, NSET=\xff\xfe\n2\n"].concat();
    assert_eq!(problem(&bytes), Problem::NameNotUtf8);
}

#[test]
fn names_that_could_steer_a_terminal_are_refused() {
    let bytes = changed_in(ONE_HEX.as_bytes(), "\"b\"", "\"b\u{1b}[2J\"");
    let told = "a control character or a mark of the direction of writing; rename the group";
    assert_eq!(error(&bytes), format!("a.msh:6: the name \"b\\u{{1b}}[2J\" has {told}"));
    let bytes = changed_in(ONE_HEX.as_bytes(), "\"b\"", "\"b\u{202e}c\"");
    assert_eq!(error(&bytes), format!("a.msh:6: the name \"b\\u{{202e}}c\" has {told}"));
    let bytes = [&abaqus(&sample())[..], b"*NSET, NSET=a\0b\n2\n"].concat();
    assert!(error(&bytes).contains("the name \"a\\0b\" has a control character"), "{}", error(&bytes));
}

#[test]
fn names_have_a_longest() {
    for length in [255, 256, 65_535, 65_536, 1 << 20] {
        let long = format!("\"{}\"", "n".repeat(length));
        let bytes = changed_in(ONE_HEX.as_bytes(), "\"b\"", &long);
        if length <= 255 {
            assert!(read(&bytes).group(long.trim_matches('"')).is_some());
        } else {
            let told = format!("a.msh:6: a name has {length} characters, where up to 255 are read");
            assert!(error(&bytes).starts_with(&told), "{}", error(&bytes));
            assert!(error(&bytes).len() < 200);
        }
        let set = format!("*NSET, NSET={}\n40\n", long.trim_matches('"'));
        let bytes = [&abaqus(&sample())[..], set.as_bytes()].concat();
        assert_eq!(read_mesh_bytes(&bytes, "a.inp").is_ok(), length <= 255, "{length}");
    }
}

#[test]
fn a_hex_in_two_groups_of_a_2_2_file_is_one_hex() {
    // Gmsh writes it once for each group, under another number.
    let mesh = sample();
    let text = String::from_utf8(gmsh22(&mesh, false)).unwrap();
    let hex = text.lines().find(|line| line.starts_with("14 5 2 1 7")).unwrap();
    let again = hex.replacen("14 5 2 1 7", "99 5 2 9 7", 1);
    let text = text.replacen(hex, &format!("{hex}\n{again}"), 1).replacen("$Elements\n11", "$Elements\n12", 1);
    let read = read(text.as_bytes());
    assert_eq!((read.element_count(), &read.group("volume_9").unwrap().elements[..]), (4, &[0][..]));
}

#[test]
fn abaqus_sets_may_name_sets_share_names_and_come_from_elements() {
    let more = "*ELSET, ELSET=both\nBOX, 11\n*Nset, nset=Part-1-1.qualified\n Part-1-1.40\n*NSET, NSET=foot, ELSET=box\n\
                *NSET, NSET=BOX, GENERATE\n6, 40, 2\n*NSET, NSET=z_max\n40\n";
    let file = read_mesh_bytes(&[&abaqus(&sample())[..], more.as_bytes()].concat(), "a.inp").unwrap();
    let group = |name: &str| file.mesh.group(name).unwrap();
    assert_eq!(group("both").elements, [0, 1, 2, 3]);
    assert_eq!(group("Part-1-1.qualified").nodes, [0]);
    assert_eq!((group("foot").kind, group("foot").nodes.len()), (GroupKind::Nodes, 18));
    let nodes = |name: &str| file.mesh.find(name, Wanted::Nodes).unwrap();
    assert_eq!((nodes("box").kind, nodes("box").nodes.len()), (GroupKind::Nodes, 18));
    assert_eq!((nodes("z_max").kind, &nodes("z_max").nodes[..]), (GroupKind::Nodes, &[0][..]));
    assert_eq!(file.mesh.find("z_max", Wanted::Faces).unwrap().faces.len(), 4);
}

#[test]
fn abaqus_names_in_quotes_are_the_same_in_keywords_and_in_data() {
    let more = "*ELSET, ELSET=\"my set\"\n11, 12\n*ELSET, ELSET=three\n\"my set\", 13\n";
    let file = read_mesh_bytes(&[&abaqus(&sample())[..], more.as_bytes()].concat(), "a.inp").unwrap();
    assert_eq!(file.mesh.group("my set").unwrap().elements.len(), 2);
    assert_eq!(file.mesh.group("three").unwrap().elements.len(), 3);
}

#[test]
fn abaqus_hierarchies_that_are_not_whole_are_refused_with_advice() {
    let with = |more: &str| error(&[&abaqus(&sample())[..], more.as_bytes()].concat());
    assert!(with("*PART, NAME=part-1\n").contains("a second *PART with the name part-1"));
    assert!(with("*INSTANCE, NAME=i, PART=p\n").contains("there is no *PART with the name p"));
    let twice = "*INSTANCE, NAME=i, PART=Part-1\n*END INSTANCE\n".repeat(2);
    assert!(with(&twice).contains("a second *INSTANCE with the name i"));
    assert!(with("*INSTANCE, NAME=i, LIBRARY=old, INSTANCE=j\n").contains("an *INSTANCE of another job"));
    let turned = "*INSTANCE, NAME=i, PART=Part-1\n0,0,0\n1, 1, 1, 1, 1, 1, 30.\n";
    assert!(with(turned).contains("the two points of the rotation's axis are one"));
    assert!(with("*INCLUDE, INPUT=b.inp\n").contains("save the mesh to a file"));
    assert!(with("*SYSTEM\n0, 0, 0, 0, 0, 0\n").contains("the points of *SYSTEM are one"));
    assert!(with("*NODE, SYSTEM=Q\n1\n").contains("SYSTEM=Q: give R, C or S"));
}

#[test]
fn abaqus_mistakes_are_shown_with_their_line() {
    let with = |more: &str| error(&[&abaqus(&sample())[..], more.as_bytes()].concat());
    assert!(with("*ELSET, ELSET=s\n99\n").contains("\"s\" refers to element 99, which the file does not have"));
    assert!(with("*ELSET, ELSET=s\nnobody\n").contains("refers to set nobody"));
    assert!(with("*SURFACE, NAME=s\nbox, S7\n").contains("face \"S7\": give S1 to S6"));
    assert!(with("*ELSET\n1\n").contains("*ELSET needs ELSET=name"));
    assert!(with("*NSET, NSET=s, GENERATE\n9, 1\n").contains("has no members"));
    let short =
        changed_in(&abaqus(&sample()), "*Elset, elset=box", "*Element, type=C3D8\n77, 40, 38\n*Elset, elset=box");
    assert!(error(&short).contains("element 77: 2 nodes instead of 8"), "{}", error(&short));
}

/// Two bricks on top of one another, numbers 1 and 2, without any set.
const TOWER: &str = "*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,1,1,1\n8,0,1,1\n9,0,0,2\n10,1,0,2\n11,1,1,2\n\
    12,0,1,2\n*ELEMENT, TYPE=C3D8\n1, 1,2,3,4,5,6,7,8\n2, 5,6,7,8,9,10,11,12\n";

/// The tower as two instances, `P-1` and, two above it, `My part-1`, of a part with a set and a surface.
fn towers(assembly: &str) -> String {
    format!(
        "*PART, NAME=P\n{TOWER}*ELSET, ELSET=E\n1, 2\n*SURFACE, NAME=top\n2, S2\n*END PART\n*ASSEMBLY, NAME=A\n*INSTANCE, NAME=P-1, \
         PART=P\n*END INSTANCE\n*INSTANCE, NAME=\"My part-1\", PART=P\n0, 0, 2\n*END INSTANCE\n{assembly}*END ASSEMBLY\n"
    )
}

#[test]
fn all_is_the_whole_whatever_else_has_the_name() {
    let sets = |name: &str| format!("{TOWER}*ELSET, ELSET={name}\n1\n*NSET, NSET={name}\n1, 2, 3, 4\n");
    let file = read_mesh_bytes(sets("all").as_bytes(), "a.inp").unwrap();
    let find = |name: &str, wanted: Wanted| file.mesh.find(name, wanted).unwrap();
    assert_eq!((find("all", Wanted::Elements).elements.len(), find("all", Wanted::Nodes).nodes.len()), (2, 12));
    assert_eq!(find("set.all", Wanted::Elements).elements, [0]);
    assert_eq!(find("set.all", Wanted::Nodes).nodes, [0, 1, 2, 3]);
    let told = "the group \"all\" is the whole mesh; the file has others of the name: \"set.all\", the volume \"all\" of the file, \
                \"set.all\", the node set \"all\" of the file";
    assert_eq!(file.warnings, [told]);
    // Abaqus takes capitals and small letters as one
    let file = read_mesh_bytes(sets("ALL").as_bytes(), "a.inp").unwrap();
    assert_eq!(file.mesh.find("all", Wanted::Elements).unwrap().elements.len(), 2);
    assert!(file.warnings[0].contains("\"ALL\", the volume \"ALL\" of the file"), "{:?}", file.warnings);
    // what is all of it keeps the name
    let whole = format!("{TOWER}*ELSET, ELSET=all\n1, 2\n*NSET, NSET=all, GENERATE\n1, 12\n");
    let file = read_mesh_bytes(whole.as_bytes(), "a.inp").unwrap();
    assert_eq!((file.mesh.find("all", Wanted::Nodes).unwrap().nodes.len(), &file.warnings[..]), (12, &[][..]));
    // a physical volume of Gmsh, of one hex of four
    let mesh = String::from_utf8(gmsh41(&sample(), false)).unwrap();
    let file = read_mesh_bytes(mesh.replace("\"box\"", "\"all\"").as_bytes(), "a.msh").unwrap();
    let is_less = sample().group("box").unwrap().elements.len() < 4;
    assert_eq!(file.mesh.find("all", Wanted::Elements).unwrap().elements.len(), 4);
    assert_eq!(file.mesh.find("set.all", Wanted::Elements).is_ok(), is_less);
}

#[test]
fn abaqus_sets_and_surfaces_may_name_what_comes_after_them() {
    let (nodes, elements) = TOWER.split_once("*ELEMENT").unwrap();
    let text = format!(
        "{nodes}*ELSET, ELSET=both\nE1, E2\n*NSET, NSET=upper, ELSET=LATER\n*SURFACE, NAME=ends, COMBINE=UNION\ntop, foot\n*ELEMENT{elements}\
         *ELSET, ELSET=E2\nLATER\n*ELSET, ELSET=E1\n1\n*ELSET, ELSET=later\n2\n*SURFACE, NAME=foot\nE1, S1\n*SURFACE, NAME=top\nE2, S2\n\
         *ELSET, ELSET=grows\nE1\n*ELSET, ELSET=grows\ngrows, E2\n"
    );
    let mesh = read(text.as_bytes());
    let group = |name: &str| mesh.group(name).unwrap();
    assert_eq!((&group("both").elements[..], &group("grows").elements[..]), (&[0, 1][..], &[0, 1][..]));
    assert_eq!(group("upper").nodes, [4, 5, 6, 7, 8, 9, 10, 11]);
    assert_eq!((group("ends").faces.len(), &group("ends").nodes[..]), (2, &[0, 1, 2, 3, 8, 9, 10, 11][..]));
    let circle = format!("{TOWER}*ELSET, ELSET=a\nb\n*ELSET, ELSET=b\nc, 1\n*ELSET, ELSET=c\na\n");
    assert!(error(circle.as_bytes()).contains("is made of what is made of it"), "{}", error(circle.as_bytes()));
    let circle = format!("{TOWER}*SURFACE, NAME=a, COMBINE=UNION\nb\n*SURFACE, NAME=b, COMBINE=UNION\na\n");
    assert!(error(circle.as_bytes()).contains("is made of what is made of it"), "{}", error(circle.as_bytes()));
    // a chain as long as a hostile file likes
    let chain: String = (0..50_000).map(|i| format!("*ELSET, ELSET=s{i}\ns{}\n", i + 1)).collect();
    let mesh = read(format!("{TOWER}{chain}*ELSET, ELSET=s50000\n2\n").as_bytes());
    assert_eq!(mesh.group("s0").unwrap().elements, [1]);
}

#[test]
fn abaqus_assemblies_may_name_surfaces_of_instances() {
    let mesh = read(
        towers(
            "*SURFACE, NAME=tops, COMBINE=UNION\nP-1.top, \"My part-1\".top\n*SURFACE, NAME=one\nP-1.top\n*NSET, NSET=two\n\
             \"My part-1\".1, My part-1.2\n*ELSET, ELSET=three\n\"My part-1\".E, P-1.1\n*ELSET, ELSET=E\nP-1.E\n",
        )
        .as_bytes(),
    );
    let group = |name: &str| mesh.groups().iter().find(|group| group.name == name).unwrap();
    assert_eq!((group("tops").faces.len(), group("one").faces.len(), group("two").nodes.len()), (2, 1, 2));
    let heights =
        |name: &str| group(name).nodes.iter().map(|node| mesh.coordinates()[*node as usize][2]).collect::<Vec<_>>();
    assert_eq!((heights("one"), heights("two")), (vec![2.0; 4], vec![2.0; 2]));
    assert_eq!(group("three").elements, [0, 2, 3]);
}

#[test]
fn what_is_there_as_something_else_is_not_said_to_be_missing() {
    let with = |more: &str| error(towers(more).as_bytes());
    let said = with("*ELSET, ELSET=x\nPART-1-1.E\n");
    assert!(said.contains("set PART-1-1.E, which the file does not have; it has P-1.E, My part-1.E"), "{said}");
    let said = with("*SURFACE, NAME=x, COMBINE=UNION\ntop\n");
    assert!(said.contains("surface top, which the file does not have; it has P-1.top, My part-1.top"), "{said}");
    let flat = |more: &str| error(format!("{TOWER}*NSET, NSET=n\n1\n*SURFACE, NAME=s\n2, S2\n{more}").as_bytes());
    assert!(flat("*ELSET, ELSET=x\nn\n").contains("\"x\" refers to the element set n, but n is a node set"));
    assert!(
        flat("*SURFACE, NAME=x, COMBINE=UNION\nn\n").contains("\"x\" refers to the surface n, but n is a node set")
    );
    assert!(flat("*NSET, NSET=x\ns\n").contains("\"x\" refers to the node set s, but s is a surface"));
    assert!(flat("*SURFACE, NAME=x\ns, S2\n").contains("\"x\" refers to the element set s, but s is a surface"));
}

#[test]
fn gaps_in_ranges_of_numbers_are_counted_and_told() {
    let text = format!("{TOWER}*NSET, NSET=a, GENERATE\n1, 100, 1\n*ELSET, ELSET=b, GENERATE\n2, 8, 3\n");
    let file = read_mesh_bytes(text.as_bytes(), "a.inp").unwrap();
    let told = "numbers of ranges (GENERATE) that are not there are left out: \"a\" (88), \"b\" (2)";
    assert_eq!(file.warnings, [told]);
    assert_eq!(file.mesh.group("a").unwrap().nodes.len(), 12);
    assert_eq!(file.mesh.group("b").unwrap().elements, [1]);
}

#[test]
fn a_gmsh_file_without_a_volume_or_of_third_order_is_told_what_to_set() {
    let surface = |version: &str, nodes: &str, elements: &str| {
        error(format!("$MeshFormat\n{version} 0 8\n$EndMeshFormat\n{nodes}{elements}").as_bytes())
    };
    let nodes = "$Nodes\n3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n$EndNodes\n";
    let of_22 = surface("2.2", nodes, "$Elements\n1\n1 2 2 1 1 1 2 3\n$EndElements\n");
    let nodes = "$Entities\n0 0 1 0\n1 0 0 0 1 1 0 0 0\n$EndEntities\n$Nodes\n1 3 1 3\n2 1 0 3\n1\n2\n3\n0 0 0\n1 0 0\n0 1 0\n$EndNodes\n";
    let of_41 = surface("4.1", nodes, "$Elements\n1 1 1 1\n2 1 2 1\n1 1 2 3\n$EndElements\n");
    for said in [of_22, of_41] {
        assert!(said.contains("has no solid elements") && said.contains("Mesh.SaveAll = 1"), "{said}");
    }
    let third = error(&changed("3 1 5 ", "3 1 29 "));
    assert!(third.contains("Mesh.ElementOrder = 1, or 2 for tetrahedra"), "{third}");
}
