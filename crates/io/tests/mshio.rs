//! Goal: a reader that others wrote sees the same in our Gmsh 4.1 files. mshio reads every mesh that comes with the program, the
//! small files of the tests, and what the writer writes, of every shape, as text and as bytes.
//!
//! mshio passes over `$PhysicalNames` and the groups of entities. So groups are compared by dimension: the faces, the nodes of
//! curves and the points of all entities are those of all groups.

mod common;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use common::{gmsh41, sample};
use estar_io::read_mesh_bytes;
use estar_mesh::generate::{BoxSpec, box_mesh, cut_into};
use estar_mesh::{Face, GroupKind, Mesh, Shape};
use mshio::ElementType;

/// The files below a folder that are Gmsh 4.1.
fn files_below(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files_below(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "msh") {
            let start = fs::read(&path).unwrap();
            if start.windows(4).take(40).any(|window| window == b"4.1 ") {
                found.push(path);
            }
        }
    }
}

fn shape(element_type: ElementType) -> Option<Shape> {
    match element_type {
        ElementType::Hex8 => Some(Shape::Hex8),
        ElementType::Pri6 => Some(Shape::Wedge6),
        ElementType::Pyr5 => Some(Shape::Pyramid5),
        ElementType::Tet4 => Some(Shape::Tet4),
        ElementType::Tet10 => Some(Shape::Tet10),
        _ => None,
    }
}

/// Compares what mshio reads with our mesh of the same bytes.
fn compare(name: &str, bytes: &[u8], mesh: &Mesh) {
    let file = mshio::parse_msh_bytes(bytes).unwrap_or_else(|error| panic!("{name}: {error:?}"));
    let nodes = file.data.nodes.unwrap();
    let mut theirs = BTreeMap::new();
    for block in &nodes.node_blocks {
        let tags = block.node_tags.clone();
        let first = theirs.len() as u64 + 1;
        for (k, node) in block.nodes.iter().enumerate() {
            // mshio names nodes by their place where the numbers leave no gap
            let tag = tags
                .as_ref()
                .map_or(first + k as u64, |tags| tags.iter().find(|(_, at)| **at == k).map(|(tag, _)| *tag).unwrap());
            theirs.insert(tag, [node.x, node.y, node.z]);
        }
    }
    for (label, position) in mesh.node_labels().iter().zip(mesh.coordinates()) {
        assert_eq!(theirs.get(&label.0), Some(position), "{name}: node {label}");
    }

    // every block belongs to an entity that the file describes, if it describes any
    let mut known: BTreeSet<(i32, i32)> = BTreeSet::new();
    if let Some(entities) = &file.data.entities {
        known.extend(entities.points.iter().map(|entity| (0, entity.tag)));
        known.extend(entities.curves.iter().map(|entity| (1, entity.tag)));
        known.extend(entities.surfaces.iter().map(|entity| (2, entity.tag)));
        known.extend(entities.volumes.iter().map(|entity| (3, entity.tag)));
    }
    let (mut solids, mut faces, mut line_nodes, mut points) =
        (Vec::new(), BTreeSet::new(), BTreeSet::new(), BTreeSet::new());
    for block in &file.data.elements.unwrap().element_blocks {
        let entity = (block.entity_dim, block.entity_tag);
        assert!(known.is_empty() || known.contains(&entity), "{name}: {entity:?} is none of {known:?}");
        for element in &block.elements {
            let tag = element.element_tag;
            let mut nodes = element.nodes.clone();
            match shape(block.element_type) {
                Some(shape) => {
                    if shape == Shape::Tet10 {
                        nodes.swap(8, 9);
                    }
                    solids.push((tag, shape, nodes));
                }
                None if block.entity_dim == 2 => {
                    nodes.sort_unstable();
                    faces.insert(nodes);
                }
                None if block.entity_dim == 1 => line_nodes.extend(nodes),
                None => points.extend(nodes),
            }
        }
    }
    let label = |node: &u32| mesh.node_labels()[*node as usize].0;
    let ours: Vec<(u64, Shape, Vec<u64>)> = (0..mesh.element_count())
        .map(|element| {
            let nodes = mesh.elements().nodes(element).iter().map(label).collect();
            (mesh.element_labels()[element].0, mesh.elements().shape(element), nodes)
        })
        .collect();
    assert_eq!(ours, solids, "{name}");
    let groups = |kind| mesh.groups().iter().filter(move |group| group.kind == kind);
    let of_face = |face: &Face| {
        let mut nodes: Vec<u64> = face.nodes().iter().map(label).collect();
        nodes.sort_unstable();
        nodes
    };
    assert_eq!(
        groups(GroupKind::Surface).flat_map(|group| &group.faces).map(of_face).collect::<BTreeSet<_>>(),
        faces,
        "{name}"
    );
    for (kind, theirs) in [(GroupKind::Curve, line_nodes), (GroupKind::Point, points)] {
        assert_eq!(groups(kind).flat_map(|group| &group.nodes).map(label).collect::<BTreeSet<_>>(), theirs, "{name}");
    }
}

#[test]
fn the_files_that_come_with_the_program_are_the_same_to_mshio() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    for folder in ["../../meshes", "../../fuzz/seeds", "tests/corpus"] {
        files_below(&root.join(folder), &mut files);
    }
    // mshio does not know nodes with parameters in text
    files.retain(|file| !file.ends_with("parametric.msh"));
    for file in &files {
        let (name, bytes) = (file.display().to_string(), fs::read(file).unwrap());
        compare(&name, &bytes, &read_mesh_bytes(&bytes, &name).unwrap().mesh);
    }
    assert!(files.len() >= 10, "{files:?}");
}

#[test]
fn what_is_written_is_the_same_to_mshio() {
    let bricks = box_mesh(&BoxSpec::new([1.0, 2.0, 3.0], [2, 3, 1]).unwrap());
    let cut = [Shape::Wedge6, Shape::Tet4, Shape::Tet10].map(|shape| cut_into(&bricks, shape));
    for mesh in [sample(), bricks].iter().chain(&cut) {
        for binary in [false, true] {
            let bytes = gmsh41(mesh, binary);
            compare(&format!("binary: {binary}"), &bytes, mesh);
        }
    }
}
