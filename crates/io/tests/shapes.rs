//! Goal: every shape of element comes out of every format as it went in, and hexes that are collapsed are what they look like.

mod common;

use common::{gmsh22, gmsh41};
use estar_io::{Problem, ReadError, read_mesh_bytes};
use estar_mesh::quality::QualityReport;
use estar_mesh::{ElementLabel, Elements, Face, Group, Mesh, NodeLabel, Shape};

/// A cube with a wedge and a pyramid on it, a tet on the pyramid, and a ten-node tet by itself.
fn mixed() -> Mesh {
    let mut coordinates = vec![
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [1.0, 0.0, 1.0],
        [1.0, 1.0, 1.0],
        [0.0, 1.0, 1.0],
        [2.0, 0.5, 0.0],
        [2.0, 0.5, 1.0],
        [0.5, 0.5, 1.5],
        [0.5, -0.5, 1.5],
    ];
    let tet = [[5.0, 0.0, 0.0], [6.0, 0.1, 0.0], [5.2, 1.0, 0.0], [5.1, 0.3, 1.0]];
    let middle = |[a, b]: [usize; 2]| std::array::from_fn(|i| 0.5 * (tet[a][i] + tet[b][i]));
    coordinates.extend(tet);
    coordinates.extend([[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]].map(middle));
    let mut elements = Elements::default();
    elements.push(Shape::Hex8, &[0, 1, 2, 3, 4, 5, 6, 7]);
    elements.push(Shape::Wedge6, &[1, 8, 2, 5, 9, 6]);
    elements.push(Shape::Pyramid5, &[4, 5, 6, 7, 10]);
    elements.push(Shape::Tet4, &[4, 11, 5, 10]);
    elements.push(Shape::Tet10, &[12, 13, 14, 15, 16, 17, 18, 19, 20, 21]);
    let top = [Face::from([5, 9, 6]), Face::from([5, 6, 10])];
    let faces = [Face::from([0, 3, 2, 1])].into_iter().chain(top).chain([Face::from([12, 14, 13, 18, 17, 16])]);
    let groups = vec![Group::volume("all", (0..5).collect()), Group::surface("faces", faces)];
    let node_labels = (1..=coordinates.len() as u64).map(NodeLabel).collect();
    Mesh::new(coordinates, node_labels, elements, (1..=5).map(ElementLabel).collect(), groups).unwrap()
}

#[track_caller]
fn assert_same(read: &Mesh, mesh: &Mesh) {
    assert_eq!(read.elements(), mesh.elements());
    assert_eq!(read.element_labels(), mesh.element_labels());
    let keys = |mesh: &Mesh| {
        let mut faces = mesh.outward_faces(mesh.group("faces").unwrap()).unwrap();
        faces.sort_by_key(Face::key);
        faces
    };
    assert_eq!(keys(read), keys(mesh));
    assert_eq!(read.group("all"), mesh.group("all"));
}

#[test]
fn every_shape_comes_out_of_every_format_as_it_went_in() {
    let mesh = mixed();
    assert!(QualityReport::new(&mesh).errors().is_empty());
    for binary in [false, true] {
        for bytes in [gmsh41(&mesh, binary), gmsh22(&mesh, binary)] {
            assert_same(&read_mesh_bytes(&bytes, "a.msh").unwrap().mesh, &mesh);
        }
    }
    assert_same(&read_mesh_bytes(&abaqus(&mesh), "a.inp").unwrap().mesh, &mesh);
}

fn abaqus(mesh: &Mesh) -> Vec<u8> {
    let mut out = String::from("*Node\n");
    for (label, x) in mesh.node_labels().iter().zip(mesh.coordinates()) {
        out += &format!("{label}, {}, {}, {}\n", x[0], x[1], x[2]);
    }
    for (element, element_type) in ["C3D8", "C3D6", "C3D5", "C3D4", "C3D10M"].into_iter().enumerate() {
        let nodes: Vec<String> = mesh.elements().nodes(element).iter().map(|node| (node + 1).to_string()).collect();
        out += &format!("*Element, type={element_type}\n{}, {}\n", element + 1, nodes.join(", "));
    }
    out += "*Elset, elset=all, generate\n1, 5, 1\n*Surface, name=faces\n1, S1\n2, S2\n3, S3\n5, S1\n";
    out.into_bytes()
}

/// Gmsh numbers the edges of its ten-node tet 01, 12, 20, 30, 23, 13 (reference manual, "Node ordering").
#[test]
fn the_middles_of_a_gmsh_tet_are_in_the_middle_of_their_edges() {
    let mesh = mixed();
    let file = gmsh22(&mesh, false);
    let text = String::from_utf8(file).unwrap();
    assert!(text.contains("5 11 2 1 7 13 14 15 16 17 18 19 20 22 21\n"), "{text}");
    let straight = read_mesh_bytes(text.as_bytes(), "a.msh").unwrap().mesh;
    assert!(QualityReport::new(&straight).errors().is_empty());
    // read in the order of VTK the tet is no good, and is named
    let swapped = text.replace("20 22 21\n", "20 21 22\n");
    let swapped = read_mesh_bytes(swapped.as_bytes(), "a.msh").unwrap().mesh;
    assert_eq!(QualityReport::new(&swapped).inverted(), [ElementLabel(5)]);
}

#[test]
fn collapsed_bricks_are_wedges_pyramids_and_tets() {
    let mesh = mixed();
    let mut bricks = String::from_utf8(abaqus(&mesh)).unwrap();
    for (from, to) in [
        ("*Element, type=C3D6\n2, 2, 9, 3, 6, 10, 7\n", "*Element, type=C3D8\n2, 2, 9, 3, 3, 6, 10, 7, 7\n"),
        ("*Element, type=C3D5\n3, 5, 6, 7, 8, 11\n", "*Element, type=C3D8\n3, 5, 6, 7, 8, 11, 11, 11, 11\n"),
        ("*Element, type=C3D4\n4, 5, 12, 6, 11\n", "*Element, type=C3D8\n4, 5, 12, 6, 6, 11, 11, 11, 11\n"),
        // the faces of the collapsed ones
        ("3, S3\n", "3, S4\n"),
    ] {
        assert!(bricks.contains(from), "{from}");
        bricks = bricks.replace(from, to);
    }
    let read = read_mesh_bytes(bricks.as_bytes(), "a.inp").unwrap().mesh;
    assert!(QualityReport::new(&read).errors().is_empty());
    assert_same(&read, &mesh);
}

#[test]
fn a_face_that_a_shape_has_not_is_named() {
    let bytes = String::from_utf8(abaqus(&mixed())).unwrap().replace("5, S1\n", "5, S5\n");
    let ReadError::Content { problem, .. } = read_mesh_bytes(bytes.as_bytes(), "a.inp").unwrap_err() else {
        panic!("the file was read");
    };
    assert!(
        matches!(*problem, Problem::MissingMember { .. }) && problem.to_string().contains("S5 of the tet10 5"),
        "{problem}"
    );
}

/// Every beginning of every file is an error that says where, or a mesh, and so is every file with a byte changed.
#[test]
fn cut_and_changed_files_never_panic() {
    let mesh = mixed();
    for file in [gmsh41(&mesh, false), gmsh41(&mesh, true), gmsh22(&mesh, false), gmsh22(&mesh, true), abaqus(&mesh)] {
        let name = if file.starts_with(b"*") { "a.inp" } else { "a.msh" };
        for end in 0..file.len() {
            let _ = read_mesh_bytes(&file[..end], name);
            for digit in [b'0', b'7', 0xff] {
                let mut changed = file.clone();
                changed[end] = digit;
                if let Ok(read) = read_mesh_bytes(&changed, name) {
                    let _ = QualityReport::new(&read.mesh);
                }
            }
        }
    }
}
