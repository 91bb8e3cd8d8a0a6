//! What is written in Gmsh's format reads back as the same mesh.

mod common;

use common::with_all;
use estar_io::{read_mesh_bytes, write_gmsh};
use estar_mesh::generate::{
    BoxSpec, CylinderParameters, NeckingBarParameters, Section, box_mesh, cylinder, necking_bar,
};
use estar_mesh::{ElementLabel, Group, Mesh, NodeLabel, locality_order};

fn meshes() -> Vec<Mesh> {
    let bar = CylinderParameters {
        radius: 3.2,
        length: 32.4,
        section: Section::Full,
        core_cells: 2,
        radial_rings: 2,
        axial_cells: 3,
        axial_grading: 1.0,
    };
    let necking = NeckingBarParameters {
        full_length: 53.334,
        end_radius: 6.413,
        neck_ratio: 0.982,
        core_cells: 2,
        radial_rings: 2,
        axial_cells: 4,
        axial_grading: 3.0,
    };
    vec![
        box_mesh(&BoxSpec::new([1.0, 2.0, 3.0], [2, 3, 1]).unwrap()),
        cylinder(&bar.try_into().unwrap()),
        necking_bar(&necking.try_into().unwrap()),
    ]
}

fn written(mesh: &Mesh, binary: bool) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_gmsh(&mut bytes, mesh, binary).unwrap();
    bytes
}

#[test]
fn a_mesh_comes_back_bit_for_bit_as_text_and_as_bytes() {
    for mesh in meshes() {
        // Shuffled, so that node numbers without gaps come in another order than their nodes.
        for mesh in [mesh.renumbered(&locality_order(&mesh)), mesh] {
            for binary in [false, true] {
                let file = read_mesh_bytes(&written(&mesh, binary), "a.msh").unwrap();
                assert_eq!(file.mesh, with_all(&mesh));
                assert_eq!(file.format, if binary { "Gmsh 4.1, binary" } else { "Gmsh 4.1, ASCII" });
                assert!(file.warnings.is_empty());
            }
        }
    }
}

#[test]
fn overlapping_volumes_loose_hexes_and_huge_numbers_come_back() {
    let mesh = box_mesh(&BoxSpec::new([4.0, 1.0, 1.0], [4, 1, 1]).unwrap());
    let node_labels = (0..mesh.node_count() as u64).map(|k| NodeLabel(u64::MAX - k * k)).collect();
    let element_labels = [7, 1 << 60, 3, 1 << 40].map(ElementLabel).to_vec();
    let groups = vec![
        Group::volume("left", vec![0, 1]),
        Group::volume("middle", vec![1, 2]),
        Group::volume("all", vec![0, 1, 2, 3]),
        Group::curve("one node", vec![3]),
        Group::point("points", vec![9, 2]),
    ];
    let mesh =
        Mesh::new(mesh.coordinates().to_vec(), node_labels, mesh.elements().clone(), element_labels, groups).unwrap();
    for binary in [false, true] {
        let read = read_mesh_bytes(&written(&mesh, binary), "a.msh").unwrap().mesh;
        // Hexes come back entity by entity: compare by number.
        let mut order: Vec<u32> = (0..4).collect();
        order.sort_by_key(|&hex| mesh.element_labels().iter().position(|l| *l == read.element_labels()[hex as usize]));
        let renumbering = estar_mesh::Renumbering { old_nodes: (0..20).collect(), old_elements: order };
        assert_eq!(read.renumbered(&renumbering), mesh);
    }
}

#[test]
fn a_name_that_a_file_cannot_hold_is_refused() {
    let mesh = box_mesh(&BoxSpec::new([1.0; 3], [1; 3]).unwrap());
    let refused = |groups: Vec<Group>| {
        let (x, n, h, e) = (mesh.coordinates(), mesh.node_labels(), mesh.elements(), mesh.element_labels());
        let mesh = Mesh::new(x.to_vec(), n.to_vec(), h.clone(), e.to_vec(), groups).unwrap();
        write_gmsh(&mut Vec::new(), &mesh, true).is_err()
    };
    assert!(refused(vec![Group::volume("a \"b\"", vec![0])]));
    // points and node sets are one dimension
    assert!(refused(vec![Group::point("a", vec![0]), Group::node_set("a", vec![1])]));
    assert!(!refused(vec![Group::volume("a", vec![0]), Group::node_set("a", vec![1])]));
}
