//! Structured meshes of other shapes: every hex cut into wedges or tets.

use std::collections::HashMap;

use crate::{Elements, Face, FaceKey, Group, GroupKind, Mesh, Shape};

/// A structured mesh of hexes with each cut into two wedges along ζ, or into six tets; any other shape leaves it as it is.
///
/// Every quad is cut from its node of the least index, which neighbours see alike. Tets stand on the quads that the hex's
/// least node is not on, with that node as their top. The middles of the edges of
/// ten-node tets lie on straight lines.
pub fn cut_into(mesh: &Mesh, shape: Shape) -> Mesh {
    let mut cut = Cut::new(mesh);
    for (hex, nodes) in mesh.elements().iter().enumerate() {
        let corners: [u32; 8] = std::array::from_fn(|corner| nodes[corner]);
        match shape {
            Shape::Wedge6 => cut.wedges(&corners),
            Shape::Tet4 | Shape::Tet10 => cut.tets(mesh, hex, shape == Shape::Tet10),
            Shape::Hex8 | Shape::Pyramid5 => cut.elements.push(Shape::Hex8, &corners),
        }
    }
    let per_hex = (cut.elements.len() / mesh.element_count()) as u32;
    let groups = mesh.groups().iter().map(|group| Group {
        elements: group.elements.iter().flat_map(|hex| hex * per_hex..(hex + 1) * per_hex).collect(),
        faces: group.faces.iter().flat_map(|face| cut.pieces(face, shape)).collect(),
        nodes: match group.kind {
            GroupKind::Curve => cut.with_middles(&group.nodes),
            _ => group.nodes.clone(),
        },
        ..group.clone()
    });
    let groups = groups.collect();
    Mesh::generated(cut.coordinates, cut.elements, groups)
}

struct Cut {
    coordinates: Vec<[f64; 3]>,
    elements: Elements,
    /// The node between two others, the lesser first.
    middles: HashMap<[u32; 2], u32>,
    /// The pieces of the quads at the two ends of wedges.
    ends: HashMap<FaceKey, [[u32; 3]; 2]>,
}

impl Cut {
    fn new(mesh: &Mesh) -> Self {
        Self {
            coordinates: mesh.coordinates().to_vec(),
            elements: Elements::default(),
            middles: HashMap::new(),
            ends: HashMap::new(),
        }
    }

    /// Both ends are cut alike; as layers of one section are numbered alike, so do their neighbours.
    fn wedges(&mut self, corners: &[u32; 8]) {
        let [a, b, c, d, e, f, g, h] = *corners;
        let from_first = a.min(c) < b.min(d);
        let triangles = if from_first { [[0, 1, 2], [0, 2, 3]] } else { [[1, 2, 3], [1, 3, 0]] };
        for quad in [[a, b, c, d], [e, f, g, h]] {
            self.ends.insert(Face::Quad4(quad).key(), triangles.map(|triangle| triangle.map(|corner| quad[corner])));
        }
        for triangle in triangles {
            let [i, j, k] = triangle;
            self.elements.push(
                Shape::Wedge6,
                &[corners[i], corners[j], corners[k], corners[i + 4], corners[j + 4], corners[k + 4]],
            );
        }
    }

    fn tets(&mut self, mesh: &Mesh, hex: usize, with_middles: bool) {
        let top = mesh.elements().nodes(hex).iter().copied().fold(u32::MAX, u32::min);
        let beneath = mesh.elements().faces(hex).filter(|face| !face.nodes().contains(&top));
        for [a, b, c] in beneath.flat_map(|face| triangles(&face)) {
            // the normal of the face points out, and that of the tet's first three nodes to the fourth
            let [i, j, k, l] = [a, c, b, top];
            if with_middles {
                let middles = [[i, j], [j, k], [k, i], [i, l], [j, l], [k, l]].map(|ends| self.middle(ends));
                let [m, n, o, p, q, r] = middles;
                self.elements.push(Shape::Tet10, &[i, j, k, l, m, n, o, p, q, r]);
            } else {
                self.elements.push(Shape::Tet4, &[i, j, k, l]);
            }
        }
    }

    fn middle(&mut self, mut ends: [u32; 2]) -> u32 {
        ends.sort_unstable();
        *self.middles.entry(ends).or_insert_with(|| {
            let [a, b] = ends.map(|end| self.coordinates[end as usize]);
            self.coordinates.push(std::array::from_fn(|i| 0.5 * (a[i] + b[i])));
            self.coordinates.len() as u32 - 1
        })
    }

    /// What becomes of a face of a group.
    fn pieces(&self, face: &Face, shape: Shape) -> Vec<Face> {
        let known_middle = |a: u32, b: u32| self.middles.get(&[a.min(b), a.max(b)]).copied();
        match shape {
            Shape::Tet4 => triangles(face).map(Face::Triangle3).to_vec(),
            Shape::Tet10 => triangles(face)
                .into_iter()
                .filter_map(|[a, b, c]| {
                    let middles = [known_middle(a, b)?, known_middle(b, c)?, known_middle(c, a)?];
                    Some(Face::Triangle6([a, b, c, middles[0], middles[1], middles[2]]))
                })
                .collect(),
            _ => match self.ends.get(&face.key()) {
                Some(triangles) => triangles.map(Face::Triangle3).to_vec(),
                None => vec![*face],
            },
        }
    }

    /// The nodes of a curve and the middles between them.
    fn with_middles(&self, nodes: &[u32]) -> Vec<u32> {
        let mut all = nodes.to_vec();
        let on_curve = |node: &u32| nodes.contains(node);
        all.extend(self.middles.iter().filter(|(ends, _)| ends.iter().all(on_curve)).map(|(_, middle)| *middle));
        all.sort_unstable();
        all
    }
}

/// The two triangles of a quad, cut from its least node.
fn triangles(quad: &Face) -> [[u32; 3]; 2] {
    let nodes = quad.nodes();
    let first = (0..nodes.len()).min_by_key(|&corner| nodes[corner]).unwrap_or(0);
    let [a, b, c, d] = [0, 1, 2, 3].map(|k| nodes[(first + k) % nodes.len()]);
    [[a, b, c], [a, c, d]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::{BoxSpec, CylinderParameters, Section, box_mesh, cylinder};
    use crate::quality::QualityReport;

    /// The pieces fill the body, are well shaped, and every face of theirs is met by a neighbour or is on the outside.
    #[test]
    fn pieces_fit_together_and_fill_the_body() {
        let bar = CylinderParameters {
            radius: 3.2,
            length: 32.4,
            section: Section::Quarter,
            core_cells: 3,
            radial_rings: 2,
            axial_cells: 3,
            axial_grading: 2.0,
        };
        for hexes in [box_mesh(&BoxSpec::new([2.0, 3.0, 5.0], [2, 3, 4]).unwrap()), cylinder(&bar.try_into().unwrap())]
        {
            let whole = QualityReport::new(&hexes).total_volume();
            for (shape, per_hex) in [(Shape::Wedge6, 2), (Shape::Tet4, 6), (Shape::Tet10, 6)] {
                let mesh = cut_into(&hexes, shape);
                let report = QualityReport::new(&mesh);
                assert!(report.errors().is_empty(), "{shape}: {:?}", report.errors());
                assert!((report.total_volume() / whole - 1.0).abs() < 1e-13, "{shape}");
                assert_eq!(mesh.element_count(), per_hex * hexes.element_count());
                let mut faces: HashMap<FaceKey, usize> = HashMap::new();
                for face in (0..mesh.element_count()).flat_map(|element| mesh.elements().faces(element)) {
                    *faces.entry(face.key()).or_default() += 1;
                }
                let outer = faces.values().filter(|&&count| count == 1).count();
                let named: Vec<&Group> =
                    mesh.groups().iter().filter(|group| group.kind == GroupKind::Surface).collect();
                assert_eq!(outer, named.iter().map(|group| group.faces.len()).sum::<usize>(), "{shape}");
                for group in named {
                    assert!(mesh.outward_faces(group).is_ok(), "{shape}, {}", group.name);
                }
            }
        }
    }

    #[test]
    fn a_curve_has_the_middles_between_its_nodes() {
        let mut mesh = box_mesh(&BoxSpec::new([1.0, 1.0, 3.0], [1, 1, 3]).unwrap());
        let mut groups = mesh.groups().to_vec();
        groups.push(Group::curve("edge", vec![0, 4, 8, 12]));
        mesh = Mesh::generated(mesh.coordinates().to_vec(), mesh.elements().clone(), groups);
        let tets = cut_into(&mesh, Shape::Tet10);
        let edge = tets.group("edge").unwrap();
        assert_eq!(edge.nodes.len(), 7);
        assert!(edge.nodes.iter().all(|&node| tets.coordinates()[node as usize][..2] == [0.0, 0.0]));
    }
}
