//! How good the hexes are, and what makes a mesh unusable, by the numbers of the user's file.

use std::fmt;

use rayon::prelude::*;
use thiserror::Error;

use crate::hex::{CORNER_NEIGHBOURS, CORNER_SIGNS};
use crate::{ElementLabel, Mesh, NodeLabel};

/// A corner counts as inverted below this scaled Jacobian: a flat corner (180°) is poor, not inverted, and its value
/// is rounding of either sign.
const INVERTED_BELOW: f64 = -1e-9;
/// A hex counts as degenerate when its volume is this small against the cube of its longest edge.
const ZERO_VOLUME: f64 = 1e-12;
/// Bins of the histogram over scaled Jacobians, from 0 to 1.
const BIN_COUNT: usize = 10;

/// The quality of one hex.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HexQuality {
    /// The least Jacobian determinant at the eight corners, of the map from the unit cube: 1 for a cube of edge 1.
    pub min_jacobian: f64,
    /// The least corner Jacobian divided by the lengths of the three edges there: 1 for right angles, 0 for a flat
    /// corner, negative when inverted.
    pub scaled_jacobian: f64,
    /// The volume.
    pub volume: f64,
}

impl HexQuality {
    /// The quality of the hex with these corners.
    pub fn new(corners: &[[f64; 3]; 8]) -> Self {
        let (mut min_jacobian, mut scaled_jacobian) = (f64::INFINITY, f64::INFINITY);
        for (corner, neighbours) in CORNER_NEIGHBOURS.iter().enumerate() {
            let edges = neighbours.map(|neighbour| difference(&corners[neighbour], &corners[corner]));
            let jacobian = determinant(&edges);
            let lengths: f64 = edges.iter().map(|edge| square(edge).sqrt()).product();
            min_jacobian = min_jacobian.min(jacobian);
            scaled_jacobian = scaled_jacobian.min(if lengths > 0.0 { jacobian / lengths } else { 0.0 });
        }
        Self { min_jacobian, scaled_jacobian, volume: volume(corners) }
    }
}

/// Something that makes a mesh unusable.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum QualityError {
    /// A hex with a negative Jacobian at a corner.
    #[error("element {element} is inverted{}", if *.mirrored { ": its volume is negative; reverse its node order" } else { " at a corner; repair the mesh there" })]
    Inverted {
        /// The hex.
        element: ElementLabel,
        /// True when the whole hex is turned inside out, as by a wrong node order.
        mirrored: bool,
    },
    /// A hex with a node twice.
    #[error(
        "element {element} has node {node} at more than one corner; use hexes with eight nodes of their own, \
         not collapsed ones"
    )]
    RepeatedNode {
        /// The hex.
        element: ElementLabel,
        /// The node.
        node: NodeLabel,
    },
    /// A hex without volume.
    #[error("element {element} has no volume; remove it or move its nodes apart")]
    ZeroVolume {
        /// The hex.
        element: ElementLabel,
    },
    /// Two hexes with the same nodes.
    #[error("elements {first} and {second} have the same eight nodes; remove one of them")]
    Duplicate {
        /// The one that comes first in the file.
        first: ElementLabel,
        /// The other.
        second: ElementLabel,
    },
    /// A node of no hex.
    #[error("node {node} belongs to no element; remove it, or mesh what it should belong to")]
    UnusedNode {
        /// The node.
        node: NodeLabel,
    },
}

/// The quality of every hex of a mesh and what is wrong with it.
#[derive(Debug, Clone, PartialEq)]
pub struct QualityReport {
    hexes: Vec<HexQuality>,
    hex_labels: Vec<ElementLabel>,
    errors: Vec<QualityError>,
}

impl QualityReport {
    /// The report on a mesh.
    pub fn new(mesh: &Mesh) -> Self {
        let hexes: Vec<HexQuality> =
            (0..mesh.hex_count()).into_par_iter().map(|hex| HexQuality::new(&mesh.corners(hex))).collect();
        let errors = hexes.par_iter().enumerate().filter_map(|(hex, quality)| hex_error(mesh, hex, quality));
        let mut errors: Vec<QualityError> = errors.collect();
        errors.extend(duplicates(mesh));
        errors.extend(unused_nodes(mesh).map(|node| QualityError::UnusedNode { node }));
        Self { hexes, hex_labels: mesh.hex_labels().to_vec(), errors }
    }

    /// What makes the mesh unusable: bad hexes in the mesh's order, then duplicates, then unused nodes.
    pub fn errors(&self) -> &[QualityError] {
        &self.errors
    }

    /// The quality of each hex.
    pub fn hexes(&self) -> &[HexQuality] {
        &self.hexes
    }

    /// The hexes inverted at a corner or as a whole.
    pub fn inverted(&self) -> Vec<ElementLabel> {
        self.labels(|error| match error {
            QualityError::Inverted { element, .. } => Some(*element),
            _ => None,
        })
    }

    /// The hexes with repeated nodes or without volume.
    pub fn degenerate(&self) -> Vec<ElementLabel> {
        self.labels(|error| match error {
            QualityError::RepeatedNode { element, .. } | QualityError::ZeroVolume { element } => Some(*element),
            _ => None,
        })
    }

    /// The hexes whose eight nodes are those of an earlier one.
    pub fn duplicates(&self) -> Vec<ElementLabel> {
        self.labels(|error| match error {
            QualityError::Duplicate { second, .. } => Some(*second),
            _ => None,
        })
    }

    /// The nodes of no hex.
    pub fn unused_nodes(&self) -> Vec<NodeLabel> {
        self.labels(|error| match error {
            QualityError::UnusedNode { node } => Some(*node),
            _ => None,
        })
    }

    fn labels<L>(&self, label: impl Fn(&QualityError) -> Option<L>) -> Vec<L> {
        self.errors.iter().filter_map(label).collect()
    }

    /// The least scaled Jacobian and the hex it belongs to.
    pub fn worst(&self) -> Option<(ElementLabel, f64)> {
        let worst =
            self.hexes.iter().zip(&self.hex_labels).min_by(|a, b| a.0.scaled_jacobian.total_cmp(&b.0.scaled_jacobian));
        worst.map(|(quality, &label)| (label, quality.scaled_jacobian))
    }

    /// The sum of all volumes.
    pub fn total_volume(&self) -> f64 {
        self.hexes.iter().map(|hex| hex.volume).sum()
    }

    /// Figures that describe the mesh in a few lines.
    pub fn summary(&self) -> QualitySummary {
        let count = self.hexes.len() as f64;
        let mut histogram = [0; BIN_COUNT];
        for hex in &self.hexes {
            let bin = (hex.scaled_jacobian.clamp(0.0, 1.0) * BIN_COUNT as f64) as usize;
            histogram[bin.min(BIN_COUNT - 1)] += 1;
        }
        let least = |value: fn(&HexQuality) -> f64| self.hexes.iter().map(value).fold(f64::INFINITY, f64::min);
        QualitySummary {
            hex_count: self.hexes.len(),
            min_scaled_jacobian: least(|hex| hex.scaled_jacobian),
            mean_scaled_jacobian: self.hexes.iter().map(|hex| hex.scaled_jacobian).sum::<f64>() / count,
            min_jacobian: least(|hex| hex.min_jacobian),
            min_volume: least(|hex| hex.volume),
            max_volume: self.hexes.iter().map(|hex| hex.volume).fold(f64::NEG_INFINITY, f64::max),
            total_volume: self.total_volume(),
            histogram,
        }
    }
}

/// Figures over all hexes of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct QualitySummary {
    /// How many hexes.
    pub hex_count: usize,
    /// The least scaled Jacobian.
    pub min_scaled_jacobian: f64,
    /// The mean of the hexes' least scaled Jacobians.
    pub mean_scaled_jacobian: f64,
    /// The least corner Jacobian.
    pub min_jacobian: f64,
    /// The least volume of a hex.
    pub min_volume: f64,
    /// The greatest volume of a hex.
    pub max_volume: f64,
    /// The volume of all hexes.
    pub total_volume: f64,
    /// How many hexes have a scaled Jacobian of 0 to 0.1 (or less), 0.1 to 0.2, ... 0.9 to 1.
    pub histogram: [usize; BIN_COUNT],
}

impl fmt::Display for QualitySummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "scaled Jacobian: least {:.4}, mean {:.4}; volume: {:.6e} in all, a hex {:.3e} to {:.3e}",
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

fn hex_error(mesh: &Mesh, hex: usize, quality: &HexQuality) -> Option<QualityError> {
    let element = mesh.hex_labels()[hex];
    let mut nodes = mesh.hexes()[hex];
    nodes.sort_unstable();
    if let Some(pair) = nodes.windows(2).find(|pair| pair[0] == pair[1]) {
        return Some(QualityError::RepeatedNode { element, node: mesh.node_labels()[pair[0] as usize] });
    }
    let corners = mesh.corners(hex);
    let longest_edge = CORNER_NEIGHBOURS
        .iter()
        .enumerate()
        .flat_map(|(corner, neighbours)| neighbours.map(|other| square(&difference(&corners[other], &corners[corner]))))
        .fold(0.0, f64::max)
        .sqrt();
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

fn duplicates(mesh: &Mesh) -> Vec<QualityError> {
    let mut keyed: Vec<([u32; 8], u32)> = mesh
        .hexes()
        .par_iter()
        .enumerate()
        .map(|(hex, nodes)| {
            let mut key = *nodes;
            key.sort_unstable();
            (key, hex as u32)
        })
        .collect();
    keyed.par_sort_unstable();
    let label = |hex: u32| mesh.hex_labels()[hex as usize];
    keyed
        .windows(2)
        .filter(|pair| pair[0].0 == pair[1].0)
        .map(|pair| QualityError::Duplicate { first: label(pair[0].1), second: label(pair[1].1) })
        .collect()
}

fn unused_nodes(mesh: &Mesh) -> impl Iterator<Item = NodeLabel> + '_ {
    let mut used = vec![false; mesh.node_count()];
    for &node in mesh.hexes().iter().flatten() {
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

/// ∫ det ∂x/∂ξ dξ over the reference cube, by 2×2×2 Gauss points, which is exact for a trilinear hex.
pub fn volume(corners: &[[f64; 3]; 8]) -> f64 {
    let at_point = |slopes: &[[f64; 3]; 8]| {
        let mut jacobian = [[0.0; 3]; 3];
        for (corner, slope) in corners.iter().zip(slopes) {
            for (row, slope) in jacobian.iter_mut().zip(slope) {
                for (value, x) in row.iter_mut().zip(corner) {
                    *value += slope * x;
                }
            }
        }
        determinant(&jacobian)
    };
    SLOPES.iter().map(at_point).sum()
}

fn difference(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn square(a: &[f64; 3]) -> f64 {
    a[0] * a[0] + a[1] * a[1] + a[2] * a[2]
}

fn determinant([a, b, c]: &[[f64; 3]; 3]) -> f64 {
    a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::{BoxSpec, box_mesh};

    fn mesh_of(coordinates: Vec<[f64; 3]>, hexes: Vec<[u32; 8]>) -> Mesh {
        let node_labels = (0..coordinates.len() as u64).map(|k| NodeLabel(100 + k)).collect();
        let hex_labels = (0..hexes.len() as u64).map(|k| ElementLabel(500 + k)).collect();
        Mesh::new(coordinates, node_labels, hexes, hex_labels, vec![]).unwrap()
    }

    fn unit_cube() -> Vec<[f64; 3]> {
        CORNER_SIGNS.iter().map(|s| s.map(|v| 0.5 + 0.5 * v)).collect()
    }

    const STRAIGHT: [u32; 8] = [0, 1, 2, 3, 4, 5, 6, 7];

    #[test]
    fn a_unit_cube_is_perfect() {
        let report = QualityReport::new(&mesh_of(unit_cube(), vec![STRAIGHT]));
        let hex = report.hexes()[0];
        assert_eq!((hex.min_jacobian, hex.scaled_jacobian), (1.0, 1.0));
        assert!((hex.volume - 1.0).abs() < 1e-15);
        assert!(report.errors().is_empty());
        assert_eq!(report.summary().histogram[9], 1);
    }

    #[test]
    fn a_sheared_hex_keeps_its_volume_and_loses_quality() {
        let sheared: Vec<_> = unit_cube().iter().map(|x| [x[0] + x[1], x[1], x[2]]).collect();
        let hex = QualityReport::new(&mesh_of(sheared, vec![STRAIGHT])).hexes()[0];
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
        assert_eq!(text[0], "elements 500 and 501 have the same eight nodes; remove one of them");
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
