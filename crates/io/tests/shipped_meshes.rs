//! The meshes that come with the program are what `meshes/README.md` says.

use std::f64::consts::PI;
use std::path::Path;

use estar_io::read_mesh;
use estar_mesh::quality::QualityReport;
use estar_mesh::{GroupKind, Mesh};

/// Reads a mesh, in which nothing may be wrong.
fn mesh(name: &str) -> Mesh {
    let file = read_mesh(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../meshes").join(name)).unwrap();
    assert_eq!((file.format.as_str(), file.warnings.len()), ("Gmsh 4.1, binary", 0));
    let report = QualityReport::new(&file.mesh);
    assert_eq!(report.errors(), []);
    assert!(report.summary().min_scaled_jacobian > 0.7);
    for group in file.mesh.groups().iter().filter(|group| group.kind == GroupKind::Surface) {
        assert_eq!(file.mesh.outward_faces(group).unwrap().len(), group.faces.len());
    }
    file.mesh
}

fn group_names(mesh: &Mesh) -> Vec<(GroupKind, &str)> {
    mesh.groups().iter().map(|group| (group.kind, group.name.as_str())).collect()
}

/// The relative difference of the mesh's volume from another.
fn volume_error(mesh: &Mesh, exact: f64) -> f64 {
    QualityReport::new(mesh).total_volume() / exact - 1.0
}

#[test]
fn taylor_is_a_quarter_of_the_cylinder() {
    use GroupKind::{Curve, Surface, Volume};
    let mesh = mesh("taylor/taylor.msh");
    assert_eq!((mesh.element_count(), mesh.node_count()), (3510, 4400));
    let surfaces = ["symmetry_x", "symmetry_y", "foot", "top", "side"].map(|name| (Surface, name));
    assert_eq!(group_names(&mesh), [&[(Volume, "bar")][..], &surfaces, &[(Curve, "axis"), (Volume, "all")]].concat());
    // 10 edges on the quarter circle: sin(π/20)/(π/20).
    let polygon = (PI / 20.0).sin() / (PI / 20.0);
    assert!(volume_error(&mesh, polygon * PI * 3.2 * 3.2 * 32.4 / 4.0).abs() < 1e-9);
    assert_eq!(mesh.extent()[0], [0.0; 3]);
}

#[test]
fn necking_is_an_eighth_of_the_tapered_bar() {
    let mesh = mesh("necking/necking.msh");
    assert_eq!((mesh.element_count(), mesh.node_count()), (405, 592));
    let neck = mesh.coordinates()[mesh.group("neck").unwrap().nodes[0] as usize];
    assert!((neck[0] - 0.982 * 6.413).abs() < 1e-12 && neck[1] == 0.0 && neck[2] == 0.0);
    for name in ["symmetry_x", "symmetry_y", "symmetry_z", "grip", "side", "axis", "bar"] {
        assert!(mesh.group(name).is_some(), "{name}");
    }
    let (end, neck) = (6.413, 0.982 * 6.413);
    let frustum = PI / 3.0 * 26.667 * (end * end + end * neck + neck * neck) / 4.0;
    let polygon = (PI / 12.0).sin() / (PI / 12.0);
    assert!(volume_error(&mesh, polygon * frustum).abs() < 1e-9);
}

#[test]
fn cook_is_one_element_thick() {
    let mesh = mesh("cook/cook.msh");
    assert_eq!((mesh.element_count(), mesh.node_count()), (64, 162));
    assert!(volume_error(&mesh, 48.0 * (44.0 + 16.0) / 2.0).abs() < 1e-12);
    assert_eq!(mesh.coordinates()[mesh.group("tip").unwrap().nodes[0] as usize], [48.0, 60.0, 0.0]);
    for (name, face_count) in [("clamped", 8), ("loaded", 8), ("back", 64), ("front", 64)] {
        assert_eq!(mesh.group(name).unwrap().faces.len(), face_count);
    }
}
