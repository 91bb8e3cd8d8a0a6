//! One small mesh in every format, and a folder to write to.
#![allow(dead_code, reason = "each test file uses its own part")]

use estar_io::write_gmsh;
use estar_mesh::generate::{BoxSpec, box_mesh};
use estar_mesh::{Group, GroupKind, Mesh, Shape};
use std::fs;
use std::path::PathBuf;

/// A folder of its own for a test, gone when the test is over.
pub struct Folder(pub PathBuf);

impl Folder {
    pub fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("estar-results-{}-{name}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Four hexes with groups of every kind, numbered with gaps and out of order.
pub fn sample() -> Mesh {
    let bricks = box_mesh(&BoxSpec::new([2.0, 2.0, 1.0], [2, 2, 1]).unwrap());
    let mut groups = vec![bricks.group("box").unwrap().clone(), bricks.group("z_max").unwrap().clone()];
    groups.push(Group::curve("edge", vec![0, 1, 2]));
    groups.push(Group::point("corner", vec![4]));
    let node_labels = (0..18).map(|k| estar_mesh::NodeLabel(40 - 2 * k)).collect();
    let element_labels = [14, 12, 13, 11].map(estar_mesh::ElementLabel).to_vec();
    Mesh::new(bricks.coordinates().to_vec(), node_labels, bricks.elements().clone(), element_labels, groups).unwrap()
}

/// The mesh with the group of all elements, as it is when it has been read.
pub fn with_all(mesh: &Mesh) -> Mesh {
    let mut groups = mesh.groups().to_vec();
    groups.push(Group::volume("all", (0..mesh.element_count() as u32).collect()));
    let (nodes, labels) = (mesh.coordinates().to_vec(), mesh.node_labels().to_vec());
    Mesh::new(nodes, labels, mesh.elements().clone(), mesh.element_labels().to_vec(), groups).unwrap()
}

pub fn gmsh41(mesh: &Mesh, binary: bool) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_gmsh(&mut bytes, mesh, binary).unwrap();
    bytes
}

/// Gmsh 2.2 as its manual says; the groups are numbered from 1.
pub fn gmsh22(mesh: &Mesh, binary: bool) -> Vec<u8> {
    let mut out = format!("$MeshFormat\n2.2 {} 8\n", u8::from(binary)).into_bytes();
    if binary {
        out.extend(1_i32.to_le_bytes());
        out.push(b'\n');
    }
    out.extend(b"$EndMeshFormat\n$PhysicalNames\n");
    out.extend(format!("{}\n", mesh.groups().len()).bytes());
    let dimension = |kind| match kind {
        GroupKind::Volume => 3,
        GroupKind::Surface => 2,
        GroupKind::Curve => 1,
        GroupKind::Point | GroupKind::Nodes => 0,
    };
    for (number, group) in (1..).zip(mesh.groups()) {
        out.extend(format!("{} {number} \"{}\"\n", dimension(group.kind), group.name).bytes());
    }
    out.extend(format!("$EndPhysicalNames\n$Nodes\n{}\n", mesh.node_count()).bytes());
    for (label, position) in mesh.node_labels().iter().zip(mesh.coordinates()) {
        if binary {
            out.extend((label.0 as i32).to_le_bytes());
            out.extend(position.iter().flat_map(|x| x.to_le_bytes()));
        } else {
            out.extend(format!("{label} {} {} {}\n", position[0], position[1], position[2]).bytes());
        }
    }
    // Type, physical group, number, nodes.
    let mut elements: Vec<(i32, i32, u64, Vec<u32>)> = Vec::new();
    let mut next = 100;
    let mut number = || {
        next += 1;
        next
    };
    for (physical, group) in (1..).zip(mesh.groups()) {
        match group.kind {
            GroupKind::Volume => elements.extend(group.elements.iter().map(|&element| {
                let element = element as usize;
                let mut nodes = mesh.elements().nodes(element).to_vec();
                let code = match mesh.elements().shape(element) {
                    Shape::Tet4 => 4,
                    Shape::Hex8 => 5,
                    Shape::Wedge6 => 6,
                    Shape::Pyramid5 => 7,
                    Shape::Tet10 => {
                        nodes.swap(8, 9);
                        11
                    }
                };
                (code, physical, mesh.element_labels()[element].0, nodes)
            })),
            GroupKind::Surface => elements.extend(group.faces.iter().map(|face| {
                let code = [2, 3, 0, 9][face.nodes().len() - 3];
                (code, physical, number(), face.nodes().to_vec())
            })),
            GroupKind::Curve => {
                elements.extend(group.nodes.windows(2).map(|line| (1, physical, number(), line.to_vec())));
            }
            GroupKind::Point | GroupKind::Nodes => {
                elements.extend(group.nodes.iter().map(|&node| (15, physical, number(), vec![node])));
            }
        }
    }
    out.extend(format!("{}$EndNodes\n$Elements\n{}\n", if binary { "\n" } else { "" }, elements.len()).bytes());
    for (code, physical, label, nodes) in elements {
        let nodes: Vec<i32> = nodes.iter().map(|&node| mesh.node_labels()[node as usize].0 as i32).collect();
        if binary {
            let words = [vec![code, 1, 2, label as i32, physical, 7], nodes].concat();
            out.extend(words.iter().flat_map(|word| word.to_le_bytes()));
        } else {
            let nodes: Vec<String> = nodes.iter().map(ToString::to_string).collect();
            out.extend(format!("{label} {code} 2 {physical} 7 {}\n", nodes.join(" ")).bytes());
        }
    }
    out.extend(if binary { &b"\n$EndElements\n"[..] } else { b"$EndElements\n" });
    out
}

/// The same mesh as Abaqus/CAE would write it, near enough.
pub fn abaqus(mesh: &Mesh) -> Vec<u8> {
    let mut out = String::from("*Heading\n** a comment\nsome title, with commas\n*Part, name=Part-1\n*Node\n");
    let label = |node: u32| mesh.node_labels()[node as usize].0;
    for (label, x) in mesh.node_labels().iter().zip(mesh.coordinates()) {
        out += &format!("  {label}, {}, {}, {:e}\n", x[0], x[1], x[2]);
    }
    out += "*Element, type=C3D8R\n";
    for (number, nodes) in mesh.element_labels().iter().zip(mesh.elements().iter()) {
        let nodes: Vec<String> = nodes.iter().map(|&node| label(node).to_string()).collect();
        out += &format!("{number}, {},\n {}\n", nodes[..5].join(", "), nodes[5..].join(", "));
    }
    out += "*Elset, elset=box, generate\n 11, 14, 1\n*Elset, elset=_top, internal\n 11, 12\n 13, 14,\n";
    out += "*Surface, type=ELEMENT,\n name=z_max\n_top, S2\n";
    out +=
        "*Nset, nset=edge\n 40, 38, 36\n*Nset, nset=corner\n32\n*End Part\n*Material, name=copper\n*Density\n8.93,\n";
    out.into_bytes()
}
