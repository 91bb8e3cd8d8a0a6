//! How good the elements are, and what makes a mesh unusable, by the numbers of the user's file.

use std::fmt;

use nalgebra::Vector3;
use rayon::prelude::*;
use thiserror::Error;

use crate::hex::CORNER_SIGNS;
use crate::points::difference;
use crate::{ElementLabel, MOST_NODES, Mesh, NodeLabel, Shape};

/// A corner counts as inverted below this scaled Jacobian: a flat corner (180°) is poor, not inverted, and its value
/// is rounding of either sign.
const INVERTED_BELOW: f64 = -1e-9;
/// An element counts as degenerate when its volume is this small against the cube of its longest edge.
const ZERO_VOLUME: f64 = 1e-12;
/// Bins of the histogram over scaled Jacobians, from 0 to 1.
const BIN_COUNT: usize = 10;

/// The quality of one element.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElementQuality {
    /// The least Jacobian determinant at the corners, of the map from the unit cube (1 for a cube of edge 1) or from the tet
    /// with three edges along the axes.
    pub min_jacobian: f64,
    /// The least corner Jacobian divided by the lengths of the three edges there, over what it is in the best element of the
    /// shape: 1 for a cube and for wedges, pyramids and tets with equal edges, 0 for a flat corner, negative when inverted.
    pub scaled_jacobian: f64,
    /// The volume.
    pub volume: f64,
}

impl ElementQuality {
    /// The quality of the element of a shape with these nodes.
    pub fn new(shape: Shape, nodes: &[[f64; 3]]) -> Self {
        Self::with_longest_edge(shape, nodes).0
    }

    /// The quality, and the length of the longest edge at a corner.
    fn with_longest_edge(shape: Shape, nodes: &[[f64; 3]]) -> (Self, f64) {
        // the volume of a unit triad along the edges at a corner of the best element
        let best = match shape {
            Shape::Hex8 => 1.0,
            Shape::Wedge6 => 0.75_f64.sqrt(),
            Shape::Pyramid5 | Shape::Tet4 | Shape::Tet10 => 0.5_f64.sqrt(),
        };
        let (mut min_jacobian, mut scaled_jacobian, mut longest) = (f64::INFINITY, f64::INFINITY, 0.0_f64);
        for (corner, neighbours) in shape.corner_neighbours().iter().enumerate() {
            let edges = neighbours.map(|other| edge_at(shape, nodes, corner, other));
            let jacobian = determinant(&edges);
            let lengths = edges.map(|edge| edge.norm());
            let product = lengths[0] * lengths[1] * lengths[2];
            min_jacobian = min_jacobian.min(jacobian);
            scaled_jacobian = scaled_jacobian.min(if product > 0.0 { jacobian / (product * best) } else { 0.0 });
            longest = lengths.into_iter().fold(longest, f64::max);
        }
        (Self { min_jacobian, scaled_jacobian, volume: volume(shape, nodes) }, longest)
    }
}

/// The edge from a corner to another as it leaves the corner.
fn edge_at(shape: Shape, nodes: &[[f64; 3]], corner: usize, other: usize) -> Vector3<f64> {
    let to = |node: usize| Vector3::from(nodes[node]) - Vector3::from(nodes[corner]);
    match shape.middle(corner, other) {
        None => to(other),
        // the tangent of a parabola through three nodes
        Some(middle) => 4.0 * to(middle) - to(other),
    }
}

/// Something that makes a mesh unusable.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum QualityError {
    /// An element with a negative Jacobian at a corner.
    #[error("element {element} is inverted{}", if *.mirrored { ": its volume is negative; reverse its node order" } else { " at a corner; repair the mesh there" })]
    Inverted {
        /// The element.
        element: ElementLabel,
        /// True when the whole element is turned inside out, as by a wrong node order.
        mirrored: bool,
    },
    /// An element with a node twice.
    #[error(
        "element {element} has node {node} twice, and is no hex that is collapsed to a wedge, a pyramid or a tet; repair \
         the mesh there"
    )]
    RepeatedNode {
        /// The element.
        element: ElementLabel,
        /// The node.
        node: NodeLabel,
    },
    /// A ten-node tet one of whose edges has its middle node elsewhere.
    #[error(
        "element {element}: node {middle} should be near the middle between nodes {} and {}; check the order of its nodes, \
         or make its edges less curved", ends[0], ends[1]
    )]
    MiddleElsewhere {
        /// The element.
        element: ElementLabel,
        /// The node.
        middle: NodeLabel,
        /// The ends of the edge.
        ends: [NodeLabel; 2],
    },
    /// An element without volume.
    #[error("element {element} has no volume; remove it or move its nodes apart")]
    ZeroVolume {
        /// The element.
        element: ElementLabel,
    },
    /// Two elements with the same nodes.
    #[error("elements {first} and {second} have the same nodes; remove one of them")]
    Duplicate {
        /// The one that comes first in the file.
        first: ElementLabel,
        /// The other.
        second: ElementLabel,
    },
    /// A node of no element.
    #[error("node {node} belongs to no element; remove it, or mesh what it should belong to")]
    UnusedNode {
        /// The node.
        node: NodeLabel,
    },
}

/// The quality of every element of a mesh and what is wrong with it.
#[derive(Debug, Clone, PartialEq)]
pub struct QualityReport {
    elements: Vec<ElementQuality>,
    element_labels: Vec<ElementLabel>,
    errors: Vec<QualityError>,
}

impl QualityReport {
    /// The report on a mesh.
    pub fn new(mesh: &Mesh) -> Self {
        let quality =
            |element| ElementQuality::with_longest_edge(mesh.elements().shape(element), &mesh.positions(element));
        let measured: Vec<(ElementQuality, f64)> = (0..mesh.element_count()).into_par_iter().map(quality).collect();
        let errors = measured.par_iter().enumerate();
        let errors = errors.filter_map(|(element, (quality, longest))| element_error(mesh, element, quality, *longest));
        let mut errors: Vec<QualityError> = errors.collect();
        let elements = measured.into_iter().map(|(quality, _)| quality).collect();
        errors.extend(duplicates(mesh));
        errors.extend(unused_nodes(mesh).map(|node| QualityError::UnusedNode { node }));
        Self { elements, element_labels: mesh.element_labels().to_vec(), errors }
    }

    /// What makes the mesh unusable: bad elements in the mesh's order, then duplicates, then unused nodes.
    pub fn errors(&self) -> &[QualityError] {
        &self.errors
    }

    /// The quality of each element.
    pub fn elements(&self) -> &[ElementQuality] {
        &self.elements
    }

    /// The elements inverted at a corner or as a whole, or with nodes in a wrong order.
    pub fn inverted(&self) -> Vec<ElementLabel> {
        self.labels(|error| match error {
            QualityError::Inverted { element, .. } | QualityError::MiddleElsewhere { element, .. } => Some(*element),
            _ => None,
        })
    }

    /// The elements with repeated nodes or without volume.
    pub fn degenerate(&self) -> Vec<ElementLabel> {
        self.labels(|error| match error {
            QualityError::RepeatedNode { element, .. } | QualityError::ZeroVolume { element } => Some(*element),
            _ => None,
        })
    }

    /// The elements whose nodes are those of an earlier one.
    pub fn duplicates(&self) -> Vec<ElementLabel> {
        self.labels(|error| match error {
            QualityError::Duplicate { second, .. } => Some(*second),
            _ => None,
        })
    }

    /// The nodes of no element.
    pub fn unused_nodes(&self) -> Vec<NodeLabel> {
        self.labels(|error| match error {
            QualityError::UnusedNode { node } => Some(*node),
            _ => None,
        })
    }

    fn labels<L>(&self, label: impl Fn(&QualityError) -> Option<L>) -> Vec<L> {
        self.errors.iter().filter_map(label).collect()
    }

    /// The least scaled Jacobian and the element it belongs to.
    pub fn worst(&self) -> Option<(ElementLabel, f64)> {
        let labelled = self.elements.iter().zip(&self.element_labels);
        let worst = labelled.min_by(|a, b| a.0.scaled_jacobian.total_cmp(&b.0.scaled_jacobian));
        worst.map(|(quality, &label)| (label, quality.scaled_jacobian))
    }

    /// The sum of all volumes.
    pub fn total_volume(&self) -> f64 {
        self.elements.iter().map(|element| element.volume).sum()
    }

    /// Figures that describe the mesh in a few lines.
    pub fn summary(&self) -> QualitySummary {
        let count = self.elements.len() as f64;
        let mut histogram = [0; BIN_COUNT];
        for element in &self.elements {
            let bin = (element.scaled_jacobian.clamp(0.0, 1.0) * BIN_COUNT as f64) as usize;
            histogram[bin.min(BIN_COUNT - 1)] += 1;
        }
        let least = |value: fn(&ElementQuality) -> f64| self.elements.iter().map(value).fold(f64::INFINITY, f64::min);
        QualitySummary {
            element_count: self.elements.len(),
            min_scaled_jacobian: least(|element| element.scaled_jacobian),
            mean_scaled_jacobian: self.elements.iter().map(|element| element.scaled_jacobian).sum::<f64>() / count,
            min_jacobian: least(|element| element.min_jacobian),
            min_volume: least(|element| element.volume),
            max_volume: self.elements.iter().map(|element| element.volume).fold(f64::NEG_INFINITY, f64::max),
            total_volume: self.total_volume(),
            histogram,
        }
    }
}

/// Figures over all elements of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct QualitySummary {
    /// How many elements.
    pub element_count: usize,
    /// The least scaled Jacobian.
    pub min_scaled_jacobian: f64,
    /// The mean of the elements' least scaled Jacobians.
    pub mean_scaled_jacobian: f64,
    /// The least corner Jacobian.
    pub min_jacobian: f64,
    /// The least volume of an element.
    pub min_volume: f64,
    /// The greatest volume of an element.
    pub max_volume: f64,
    /// The volume of all elements.
    pub total_volume: f64,
    /// How many elements have a scaled Jacobian of 0 to 0.1 (or less), 0.1 to 0.2, ... 0.9 to 1.
    pub histogram: [usize; BIN_COUNT],
}

impl fmt::Display for QualitySummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "scaled Jacobian: least {:.4}, mean {:.4}; volume: {:.6e} in all, an element {:.3e} to {:.3e}",
            self.min_scaled_jacobian, self.mean_scaled_jacobian, self.total_volume, self.min_volume, self.max_volume
        )?;
        let most = self.histogram.iter().copied().max().unwrap_or(0).max(1);
        for (bin, &count) in self.histogram.iter().enumerate().filter(|(_, count)| **count > 0) {
            let low = bin as f64 / BIN_COUNT as f64;
            let bar = "#".repeat((count * 40).div_ceil(most));
            writeln!(f, "  {low:.1} to {:.1}  {count:>9}  {bar}", low + 0.1)?;
        }
        Ok(())
    }
}

fn element_error(mesh: &Mesh, index: usize, quality: &ElementQuality, longest_edge: f64) -> Option<QualityError> {
    let element = mesh.element_labels()[index];
    let key = sorted_nodes(mesh, index);
    let nodes = &key[..mesh.elements().nodes(index).len()];
    if let Some(pair) = nodes.windows(2).find(|pair| pair[0] == pair[1]) {
        return Some(QualityError::RepeatedNode { element, node: mesh.node_labels()[pair[0] as usize] });
    }
    if let Some([middle, a, b]) = misplaced_middle(mesh, index) {
        return Some(QualityError::MiddleElsewhere { element, middle, ends: [a, b] });
    }
    // False also for a volume that overflowed to NaN.
    let has_volume = quality.volume.abs() > ZERO_VOLUME * longest_edge.powi(3);
    if !has_volume {
        Some(QualityError::ZeroVolume { element })
    } else if quality.scaled_jacobian < INVERTED_BELOW {
        Some(QualityError::Inverted { element, mirrored: quality.volume < 0.0 })
    } else {
        None
    }
}

/// A middle node that is farther from the middle of its edge than a third of its length, with the ends of the edge.
fn misplaced_middle(mesh: &Mesh, element: usize) -> Option<[NodeLabel; 3]> {
    let (shape, nodes) = (mesh.elements().shape(element), mesh.elements().nodes(element));
    if shape != Shape::Tet10 {
        return None;
    }
    let positions = mesh.positions(element);
    let edges = (0..4).flat_map(|b| (0..b).map(move |a| [a, b]));
    edges.filter_map(|[a, b]| Some([shape.middle(a, b)?, a, b])).find_map(|[middle, a, b]| {
        let edge = difference(&positions[b], &positions[a]);
        let off = difference(&positions[middle], &positions[a]) - 0.5 * edge;
        let is_far = off.norm_squared() > edge.norm_squared() / 9.0;
        is_far.then(|| [middle, a, b].map(|place| mesh.node_labels()[nodes[place] as usize]))
    })
}

/// The nodes of an element in ascending order, behind them numbers that no node has.
fn sorted_nodes(mesh: &Mesh, element: usize) -> [u32; MOST_NODES] {
    let mut key = [u32::MAX; MOST_NODES];
    let nodes = mesh.elements().nodes(element);
    key[..nodes.len()].copy_from_slice(nodes);
    key.sort_unstable();
    key
}

fn duplicates(mesh: &Mesh) -> Vec<QualityError> {
    let keys = (0..mesh.element_count()).into_par_iter();
    let mut keyed: Vec<([u32; MOST_NODES], u32)> =
        keys.map(|element| (sorted_nodes(mesh, element), element as u32)).collect();
    keyed.par_sort_unstable();
    let label = |element: u32| mesh.element_labels()[element as usize];
    keyed
        .windows(2)
        .filter(|pair| pair[0].0 == pair[1].0)
        .map(|pair| QualityError::Duplicate { first: label(pair[0].1), second: label(pair[1].1) })
        .collect()
}

fn unused_nodes(mesh: &Mesh) -> impl Iterator<Item = NodeLabel> + '_ {
    let mut used = vec![false; mesh.node_count()];
    for &node in mesh.elements().all_nodes() {
        used[node as usize] = true;
    }
    used.into_iter().zip(mesh.node_labels()).filter(|(used, _)| !used).map(|(_, &label)| label)
}

/// ∂N_a/∂ξ of each corner a at each of the 2×2×2 Gauss points.
const SLOPES: [[[f64; 3]; 8]; 8] = {
    const GAUSS: f64 = 0.577_350_269_189_625_8;
    let mut slopes = [[[0.0; 3]; 8]; 8];
    let mut entry = 0;
    while entry < 8 * 8 * 3 {
        let (point, corner, axis) = (CORNER_SIGNS[entry / 24], entry / 3 % 8, entry % 3);
        let (signs, j, k) = (CORNER_SIGNS[corner], (axis + 1) % 3, (axis + 2) % 3);
        // ∂N/∂ξ_axis = s_axis/8 (1 + s_j ξ_j)(1 + s_k ξ_k)
        slopes[entry / 24][corner][axis] =
            signs[axis] * (1.0 + signs[j] * point[j] * GAUSS) * (1.0 + signs[k] * point[k] * GAUSS) / 8.0;
        entry += 1;
    }
    slopes
};

/// The volume that the elements of a shape give mass to: ∫ det ∂x/∂ξ dξ of the trilinear hex, and of a ten-node tet what the four
/// flat triangles of each face enclose, whether its edges are straight or bent.
pub fn volume(shape: Shape, nodes: &[[f64; 3]]) -> f64 {
    match shape {
        Shape::Tet4 => determinant(&[1, 2, 3].map(|node| difference(&nodes[node], &nodes[0]))) / 6.0,
        Shape::Tet10 => tet10_volume(nodes),
        Shape::Hex8 | Shape::Wedge6 | Shape::Pyramid5 => {
            let places = shape.corners_of_hex().unwrap_or(&[0; 8]);
            hex_volume(&places.map(|node| nodes[node]))
        }
    }
}

/// ⅙ Σ x_a · (x_b × x_c) over the triangles of the faces, which go from the corners to the middles of the edges.
fn tet10_volume(nodes: &[[f64; 3]]) -> f64 {
    let of_face = |face: &&[usize]| {
        let &&[a, b, c, ab, bc, ca] = face else { return 0.0 };
        let triangles = [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]];
        // from one of its nodes, so that nothing is lost far from the origin
        triangles.map(|triangle| determinant(&triangle.map(|node| difference(&nodes[node], &nodes[0])))).iter().sum()
    };
    Shape::Tet10.faces().iter().map(of_face).sum::<f64>() / 6.0
}

fn hex_volume(corners: &[[f64; 3]; 8]) -> f64 {
    let at_point = |slopes: &[[f64; 3]; 8]| {
        let mut jacobian = [[0.0; 3]; 3];
        for (corner, slope) in corners.iter().zip(slopes) {
            for (row, slope) in jacobian.iter_mut().zip(slope) {
                for (value, x) in row.iter_mut().zip(corner) {
                    *value += slope * x;
                }
            }
        }
        determinant(&jacobian.map(Vector3::from))
    };
    SLOPES.iter().map(at_point).sum()
}

fn determinant(columns: &[Vector3<f64>; 3]) -> f64 {
    columns[0].dot(&columns[1].cross(&columns[2]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::{BoxSpec, box_mesh};

    fn mesh_of(coordinates: Vec<[f64; 3]>, hexes: Vec<[u32; 8]>) -> Mesh {
        let node_labels = (0..coordinates.len() as u64).map(|k| NodeLabel(100 + k)).collect();
        let element_labels = (0..hexes.len() as u64).map(|k| ElementLabel(500 + k)).collect();
        Mesh::new(coordinates, node_labels, hexes, element_labels, vec![]).unwrap()
    }

    fn unit_cube() -> Vec<[f64; 3]> {
        CORNER_SIGNS.iter().map(|s| s.map(|v| 0.5 + 0.5 * v)).collect()
    }

    const STRAIGHT: [u32; 8] = [0, 1, 2, 3, 4, 5, 6, 7];

    #[test]
    fn a_unit_cube_is_perfect() {
        let report = QualityReport::new(&mesh_of(unit_cube(), vec![STRAIGHT]));
        let hex = report.elements()[0];
        assert_eq!((hex.min_jacobian, hex.scaled_jacobian), (1.0, 1.0));
        assert!((hex.volume - 1.0).abs() < 1e-15);
        assert!(report.errors().is_empty());
        assert_eq!(report.summary().histogram[9], 1);
    }

    #[test]
    fn a_sheared_hex_keeps_its_volume_and_loses_quality() {
        let sheared: Vec<_> = unit_cube().iter().map(|x| [x[0] + x[1], x[1], x[2]]).collect();
        let hex = QualityReport::new(&mesh_of(sheared, vec![STRAIGHT])).elements()[0];
        assert!((hex.volume - 1.0).abs() < 1e-15);
        assert!((hex.scaled_jacobian - 0.5_f64.sqrt()).abs() < 1e-15);
    }

    #[test]
    fn a_mirrored_hex_is_inverted_and_says_so() {
        let report = QualityReport::new(&mesh_of(unit_cube(), vec![[4, 5, 6, 7, 0, 1, 2, 3]]));
        assert_eq!(report.errors(), [QualityError::Inverted { element: ElementLabel(500), mirrored: true }]);
        assert_eq!(report.inverted(), [ElementLabel(500)]);
    }

    #[test]
    fn one_pushed_in_corner_is_an_inversion_at_a_corner() {
        let mut points = unit_cube();
        points[6] = [0.2, 0.2, 0.2];
        let report = QualityReport::new(&mesh_of(points, vec![STRAIGHT]));
        assert_eq!(report.errors(), [QualityError::Inverted { element: ElementLabel(500), mirrored: false }]);
    }

    #[test]
    fn collapsed_and_flat_hexes_are_degenerate() {
        let report = QualityReport::new(&mesh_of(unit_cube(), vec![[0, 1, 2, 2, 4, 5, 6, 7]]));
        assert!(
            report.errors().contains(&QualityError::RepeatedNode { element: ElementLabel(500), node: NodeLabel(102) })
        );
        let flat: Vec<_> = unit_cube().iter().map(|x| [x[0], x[1], 0.0]).collect();
        let report = QualityReport::new(&mesh_of(flat, vec![STRAIGHT]));
        assert_eq!(report.degenerate(), [ElementLabel(500)]);
    }

    #[test]
    fn duplicate_hexes_and_unused_nodes_are_found() {
        let mut points = unit_cube();
        points.push([9.0; 3]);
        let report = QualityReport::new(&mesh_of(points, vec![STRAIGHT, [1, 2, 3, 0, 5, 6, 7, 4]]));
        assert_eq!(report.duplicates(), [ElementLabel(501)]);
        assert_eq!(report.unused_nodes(), [NodeLabel(108)]);
        let text: Vec<String> = report.errors().iter().map(ToString::to_string).collect();
        assert_eq!(text[0], "elements 500 and 501 have the same nodes; remove one of them");
    }

    /// The best element of each shape has the quality 1 and the volume that geometry gives it, the tets however they are numbered.
    #[test]
    fn elements_with_equal_edges_are_perfect() {
        let (half, root) = (0.75_f64.sqrt(), 0.5_f64.sqrt());
        let triangle = |z: f64| [[0.0, 0.0, z], [1.0, 0.0, z], [0.5, half, z]];
        let wedge = [triangle(0.0), triangle(1.0)].concat();
        let pyramid = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.5, root]].to_vec();
        let tet = [triangle(0.0).to_vec(), vec![[0.5, half / 3.0, (2.0_f64 / 3.0).sqrt()]]].concat();
        let middle = |[a, b]: [usize; 2]| std::array::from_fn(|i| 0.5 * (tet[a][i] + tet[b][i]));
        let tet10 = [tet.clone(), [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]].map(middle).to_vec()].concat();
        for (shape, nodes, volume) in [
            (Shape::Wedge6, wedge, 0.5 * half),
            (Shape::Pyramid5, pyramid, root / 3.0),
            (Shape::Tet4, tet.clone(), root / 6.0),
            (Shape::Tet10, tet10, root / 6.0),
        ] {
            let quality = ElementQuality::new(shape, &nodes);
            assert!((quality.scaled_jacobian - 1.0).abs() < 1e-14, "{shape}: {quality:?}");
            assert!((quality.volume - volume).abs() < 1e-15, "{shape}: {quality:?}");
            let mirrored: Vec<[f64; 3]> = nodes.iter().map(|x| [x[0], x[1], -x[2]]).collect();
            let quality = ElementQuality::new(shape, &mirrored);
            assert!((quality.volume + volume).abs() < 1e-15 && quality.scaled_jacobian < -0.99, "{shape}: {quality:?}");
        }
    }

    /// A middle that is pulled out by h along two faces takes h/4 with it, the cone over the six nodes around it; the quadratic
    /// map of the same nodes would take h/3.
    #[test]
    fn a_bent_tet_has_the_volume_within_its_flat_triangles() {
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let middle = |[a, b]: [usize; 2]| std::array::from_fn(|i| 0.5 * (corners[a][i] + corners[b][i]));
        let mut nodes = [&corners[..], &[[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]].map(middle)].concat();
        let far =
            |nodes: &[[f64; 3]]| volume(Shape::Tet10, &nodes.iter().map(|x| x.map(|c| c + 8.0)).collect::<Vec<_>>());
        assert!((far(&nodes) - 1.0 / 6.0).abs() < 1e-15);
        nodes[4] = [0.5, -0.1, -0.1];
        assert!((far(&nodes) - (1.0 / 6.0 + 0.1 / 4.0)).abs() < 1e-15, "{}", far(&nodes));
    }

    #[test]
    fn the_summary_adds_up() {
        let report = QualityReport::new(&box_mesh(&BoxSpec::new([2.0, 3.0, 4.0], [3, 4, 5]).unwrap()));
        let summary = report.summary();
        assert_eq!(summary.histogram.iter().sum::<usize>(), 60);
        assert!((summary.total_volume - 24.0).abs() < 1e-12);
        assert!(summary.to_string().contains("least 1.0000"));
        assert_eq!(report.worst().map(|(_, value)| (value * 1e9).round()), Some(1e9));
    }
}
