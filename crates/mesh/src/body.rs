//! Which elements hang together: outer faces, pieces that share faces, bodies that share nodes.

use rayon::prelude::*;

use crate::{ElementLabel, Face, FaceKey, Mesh};

/// A face that one element has alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OuterFace {
    /// The face, its normal outwards.
    pub face: Face,
    /// The element.
    pub element: u32,
}

/// Elements that hang together by shared nodes, and share none with any other.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// How many elements.
    pub element_count: usize,
    /// How many pieces it has whose elements hang together by shared faces.
    pub piece_count: usize,
    /// The least label of its elements.
    pub first_element: ElementLabel,
    /// The least and the greatest coordinates.
    pub extent: [[f64; 3]; 2],
}

/// How the elements of a mesh hang together.
#[derive(Debug, Clone, PartialEq)]
pub struct Connectivity {
    /// Faces of one element only.
    pub outer_faces: Vec<OuterFace>,
    /// The bodies, those with most elements first.
    pub bodies: Vec<Body>,
    /// The body of each element, by its place in `bodies`.
    pub body_of_element: Vec<u32>,
    /// The piece of each element: elements of one piece reach each other through shared faces.
    pub piece_of_element: Vec<u32>,
}

/// Nodes whose faces one thread compares at a time.
const CHUNK: usize = 1 << 14;
const NONE: u32 = u32::MAX;

impl Connectivity {
    /// That of a mesh.
    pub fn new(mesh: &Mesh) -> Self {
        let (outer_faces, neighbours) = match_faces(mesh);
        let mut sets = DisjointSets::new(mesh.element_count());
        for [a, b] in neighbours {
            sets.join(a, b);
        }
        let (piece_of_element, piece_count) = sets.numbered();
        // pieces are joined to bodies by the nodes that they share
        if piece_count > 1 {
            let mut owners = vec![NONE; mesh.node_count()];
            for (element, nodes) in mesh.elements().iter().enumerate() {
                for &node in nodes {
                    match owners[node as usize] {
                        NONE => owners[node as usize] = element as u32,
                        owner if piece_of_element[owner as usize] == piece_of_element[element] => {}
                        owner => sets.join(owner, element as u32),
                    }
                }
            }
        }
        let (body_of_element, body_count) = sets.numbered();
        let (bodies, new_numbers) = described(mesh, &body_of_element, body_count, &piece_of_element);
        let body_of_element = body_of_element.into_iter().map(|body| new_numbers[body as usize]).collect();
        Self { outer_faces, bodies, body_of_element, piece_of_element }
    }

    /// The nodes of outer faces, ascending.
    pub fn outer_nodes(&self, mesh: &Mesh) -> Vec<u32> {
        let mut is_outer = vec![false; mesh.node_count()];
        for &node in self.outer_faces.iter().flat_map(|outer| outer.face.nodes()) {
            is_outer[node as usize] = true;
        }
        (0..).zip(is_outer).filter(|(_, is_outer)| *is_outer).map(|(node, _)| node).collect()
    }
}

/// The faces of one element only, and the pairs of elements that share one. Faces are gathered at their least node, and
/// compared there.
fn match_faces(mesh: &Mesh) -> (Vec<OuterFace>, Vec<[u32; 2]>) {
    let elements = mesh.elements();
    let least_node = |element: usize, places: &[usize]| {
        let nodes = elements.nodes(element);
        places.iter().map(|&place| nodes[place]).min().unwrap_or(0) as usize
    };
    // (i) how many faces each node gathers, hence where they begin
    let mut starts = vec![0_usize; mesh.node_count() + 1];
    for element in 0..elements.len() {
        for places in elements.shape(element).faces() {
            starts[least_node(element, places) + 1] += 1;
        }
    }
    for node in 1..starts.len() {
        starts[node] += starts[node - 1];
    }
    // (ii) the faces, each as its element and its place there
    let mut gathered = vec![(0_u32, 0_u8); starts[mesh.node_count()]];
    let mut next = starts.clone();
    for element in 0..elements.len() {
        for (place, places) in elements.shape(element).faces().iter().enumerate() {
            let slot = &mut next[least_node(element, places)];
            gathered[*slot] = (element as u32, place as u8);
            *slot += 1;
        }
    }
    // (iii) those with the same nodes, at each node
    let compare = |chunk: usize| {
        let (mut outer, mut neighbours) = (Vec::new(), Vec::new());
        let mut keyed: Vec<(FaceKey, u32, u8)> = Vec::new();
        for node in chunk * CHUNK..((chunk + 1) * CHUNK).min(mesh.node_count()) {
            keyed.clear();
            keyed.extend(gathered[starts[node]..starts[node + 1]].iter().map(|&(element, place)| {
                let (nodes, places) =
                    (elements.nodes(element as usize), elements.shape(element as usize).faces()[place as usize]);
                let mut key = [NONE; 6];
                for (entry, &place) in key.iter_mut().zip(places) {
                    *entry = nodes[place];
                }
                key[..places.len()].sort_unstable();
                (key, element, place)
            }));
            keyed.sort_unstable();
            for same in keyed.chunk_by(|a, b| a.0 == b.0) {
                match *same {
                    [(_, element, place)] => {
                        let face = elements.faces(element as usize).nth(place as usize);
                        outer.extend(face.map(|face| OuterFace { face, element }));
                    }
                    _ => neighbours.extend(same.windows(2).map(|pair| [pair[0].1, pair[1].1])),
                }
            }
        }
        (outer, neighbours)
    };
    let chunks = (0..mesh.node_count().div_ceil(CHUNK)).into_par_iter().map(compare).collect::<Vec<_>>();
    let (outer, neighbours): (Vec<_>, Vec<_>) = chunks.into_iter().unzip();
    (outer.concat(), neighbours.concat())
}

/// The bodies, those with most elements first, and where each number went.
fn described(mesh: &Mesh, body_of_element: &[u32], count: usize, piece_of_element: &[u32]) -> (Vec<Body>, Vec<u32>) {
    let empty = Body {
        element_count: 0,
        piece_count: 0,
        first_element: ElementLabel(u64::MAX),
        extent: [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]],
    };
    let mut bodies = vec![empty; count];
    let mut is_known = vec![false; mesh.element_count()];
    for (element, &body) in body_of_element.iter().enumerate() {
        let body = &mut bodies[body as usize];
        body.element_count += 1;
        body.first_element = body.first_element.min(mesh.element_labels()[element]);
        let piece = piece_of_element[element] as usize;
        if !std::mem::replace(&mut is_known[piece], true) {
            body.piece_count += 1;
        }
        for &node in mesh.elements().nodes(element) {
            let position = mesh.coordinates()[node as usize];
            body.extent[0] = std::array::from_fn(|axis| body.extent[0][axis].min(position[axis]));
            body.extent[1] = std::array::from_fn(|axis| body.extent[1][axis].max(position[axis]));
        }
    }
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by_key(|&body| (std::cmp::Reverse(bodies[body].element_count), bodies[body].first_element));
    let mut new_numbers = vec![0; count];
    for (new, &old) in order.iter().enumerate() {
        new_numbers[old] = new as u32;
    }
    (order.into_iter().map(|old| bodies[old].clone()).collect(), new_numbers)
}

/// Sets that grow together: R. E. Tarjan, "Efficiency of a good but not linear set union algorithm", J. ACM 22 (1975) 215-225.
pub(crate) struct DisjointSets {
    parents: Vec<u32>,
}

impl DisjointSets {
    /// `count` sets of one.
    pub fn new(count: usize) -> Self {
        Self { parents: (0..count as u32).collect() }
    }

    /// The least member of the set.
    pub fn first(&mut self, mut member: u32) -> u32 {
        while self.parents[member as usize] != member {
            let grandparent = self.parents[self.parents[member as usize] as usize];
            self.parents[member as usize] = grandparent;
            member = grandparent;
        }
        member
    }

    /// Makes one set of two.
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.first(a), self.first(b));
        self.parents[a.max(b) as usize] = a.min(b);
    }

    /// The number of the set of each, in the order of their least members, and how many sets there are.
    pub fn numbered(&mut self) -> (Vec<u32>, usize) {
        let mut numbers = vec![0; self.parents.len()];
        let mut count = 0;
        for member in 0..self.parents.len() as u32 {
            let first = self.first(member);
            numbers[member as usize] = if first == member {
                count += 1;
                count - 1
            } else {
                numbers[first as usize]
            };
        }
        (numbers, count as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::{BoxSpec, box_mesh, cut_into};
    use crate::{Elements, NodeLabel, Shape};

    fn cells(count: u32) -> Mesh {
        box_mesh(&BoxSpec::new([1.0; 3], [count; 3]).unwrap())
    }

    /// Hexes by their corners, each corner by its place in a grid of unit steps.
    fn hexes(places: &[[u32; 3]]) -> Mesh {
        let node = |x: u32, y: u32, z: u32| x + 10 * y + 100 * z;
        let corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];
        let of_place = |[x, y, z]: &[u32; 3]| corners.map(|[i, j, k]| node(x + i, y + j, z + k));
        let elements = Elements::from(places.iter().map(of_place).collect::<Vec<_>>());
        let coordinates =
            (0..1000).map(|node| [f64::from(node % 10), f64::from(node / 10 % 10), f64::from(node / 100)]);
        let labels = (0..1000).map(NodeLabel).collect();
        let element_labels = (0..places.len() as u64).map(|k| ElementLabel(7 + k)).collect();
        Mesh::new(coordinates.collect(), labels, elements, element_labels, vec![]).unwrap()
    }

    #[test]
    fn a_box_is_one_body_whose_outer_faces_are_its_sides() {
        for (shape, faces_of_square) in [(Shape::Hex8, 1), (Shape::Tet4, 2), (Shape::Tet10, 2)] {
            let mesh = if shape == Shape::Hex8 { cells(3) } else { cut_into(&cells(3), shape) };
            let connectivity = Connectivity::new(&mesh);
            assert_eq!(connectivity.outer_faces.len(), 6 * 9 * faces_of_square, "{shape}");
            assert_eq!((connectivity.bodies.len(), connectivity.bodies[0].piece_count), (1, 1));
            assert_eq!(connectivity.bodies[0].extent, [[0.0; 3], [1.0; 3]]);
            // outwards: the fluxes of x through closed surfaces add up to three volumes
            let flux = |outer: &OuterFace| {
                let corner = |k: usize| mesh.coordinates()[outer.face.nodes()[k] as usize];
                let triangle = |a: [f64; 3], b: [f64; 3], c: [f64; 3]| {
                    (a[0] * (b[1] * c[2] - b[2] * c[1])
                        + a[1] * (b[2] * c[0] - b[0] * c[2])
                        + a[2] * (b[0] * c[1] - b[1] * c[0]))
                        / 2.0
                };
                let rest =
                    if let Face::Quad4(_) = outer.face { triangle(corner(0), corner(2), corner(3)) } else { 0.0 };
                triangle(corner(0), corner(1), corner(2)) + rest
            };
            let flux: f64 = connectivity.outer_faces.iter().map(flux).sum();
            assert!((flux - 3.0).abs() < 1e-12, "{shape}: {flux}");
        }
    }

    #[test]
    fn bodies_share_no_node_and_pieces_share_no_face() {
        // a row of two; one that touches it at an edge; one that touches that at a node; two apart, the larger body first
        let mesh = hexes(&[[8, 8, 8], [0, 0, 0], [1, 0, 0], [2, 1, 0], [3, 2, 1], [5, 5, 5], [5, 5, 6]]);
        let connectivity = Connectivity::new(&mesh);
        let told: Vec<_> = connectivity
            .bodies
            .iter()
            .map(|body| (body.element_count, body.piece_count, body.first_element.0))
            .collect();
        assert_eq!(told, [(4, 3, 8), (2, 1, 12), (1, 1, 7)]);
        assert_eq!(connectivity.body_of_element, [2, 0, 0, 0, 0, 1, 1]);
        assert_eq!(connectivity.bodies[0].extent, [[0.0; 3], [4.0, 3.0, 2.0]]);
    }

    #[test]
    fn a_face_of_three_elements_is_no_outer_face() {
        let mesh = hexes(&[[0, 0, 0], [1, 0, 0], [0, 0, 0]]);
        let connectivity = Connectivity::new(&mesh);
        assert_eq!((connectivity.bodies.len(), connectivity.bodies[0].piece_count), (1, 1));
        assert_eq!(connectivity.outer_faces.len(), 5);
    }
}
