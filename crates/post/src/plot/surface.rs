//! The outer surface of a body of cells, for pictures of it.

use estar_deck::fields::is_label;
use estar_io::{FieldContent, FrameContent};
use std::collections::HashMap;

/// The outer faces of a body over the nodes of its frames: the same in all of them until cells are deleted.
#[derive(Clone, Debug, Default)]
pub struct Skin {
    faces: Vec<OuterFace>,
}

/// A face that no other cell shares.
#[derive(Clone, Debug)]
struct OuterFace {
    cell: usize,
    nodes: Vec<u32>,
}

/// The surface of a body: polygons over vertices with a position. A corner of a polygon has a value of its own, so that a value can
/// jump from one polygon to the next.
#[derive(Clone, Debug, Default)]
pub struct Surface {
    /// Positions, m.
    pub vertices: Vec<[f64; 3]>,
    /// The corners of each face, counterclockwise seen from outside.
    pub faces: Vec<Vec<Corner>>,
    /// Of the axes x, y and z: whether the value becomes its negative in a mirror image along it.
    pub(super) is_odd: [bool; 3],
    /// Whether the values are means over cells.
    pub(super) is_mean: bool,
}

/// A corner of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// Its vertex.
    pub vertex: u32,
    /// The value there.
    pub value: f64,
}

/// Corners of the faces of each of VTK's shapes, counterclockwise seen from outside; nodes on edges stand between corners.
fn faces_of(shape: u8) -> &'static [&'static [usize]] {
    const TET4: &[&[usize]] = &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[0, 3, 2]];
    const HEX8: &[&[usize]] =
        &[&[0, 3, 2, 1], &[4, 5, 6, 7], &[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7, 6], &[3, 0, 4, 7]];
    const WEDGE6: &[&[usize]] = &[&[0, 2, 1], &[3, 4, 5], &[0, 1, 4, 3], &[1, 2, 5, 4], &[2, 0, 3, 5]];
    const PYRAMID5: &[&[usize]] = &[&[0, 3, 2, 1], &[0, 1, 4], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4]];
    const TET10: &[&[usize]] = &[&[0, 6, 2, 5, 1, 4], &[0, 4, 1, 8, 3, 7], &[1, 5, 2, 9, 3, 8], &[0, 7, 3, 9, 2, 6]];
    match shape {
        10 => TET4,
        12 => HEX8,
        13 => WEDGE6,
        14 => PYRAMID5,
        24 => TET10,
        _ => &[],
    }
}

/// Most nodes of a face.
const MOST_NODES: usize = 6;

/// The field that says of cells that they are not to be seen.
pub const GHOSTS: &str = "vtkGhostType";
/// The field that says of cells which part they are of.
pub const PART: &str = "part";

/// Whether a cell is there, or else was deleted.
fn is_seen(frame: &FrameContent, cell: usize) -> bool {
    const HIDDEN: u8 = 32;
    frame.cell_fields.get(GHOSTS).is_none_or(|ghosts| (ghosts.data[cell] as u8) & HIDDEN == 0)
}

/// The nodes of a face of a cell; none where it has shrunk to a line.
fn face(frame: &FrameContent, cell: usize, corners: &[usize]) -> Option<Vec<u32>> {
    let nodes = frame.cell(cell);
    let mut face = corners.iter().map(|&corner| nodes.get(corner).copied()).collect::<Option<Vec<u32>>>()?;
    face.dedup();
    if face.first() == face.last() {
        face.pop();
    }
    (face.len() >= 3).then_some(face)
}

impl Skin {
    /// The outer faces of a frame. Deleted cells are left out.
    pub fn of(frame: &FrameContent) -> Self {
        // faces that one cell has so far: the second takes them out again, because a face of two is inside
        let mut open: HashMap<[u32; MOST_NODES], (usize, usize)> = HashMap::new();
        for cell in (0..frame.types.len()).filter(|&cell| is_seen(frame, cell)) {
            for (order, corners) in faces_of(frame.types[cell]).iter().enumerate() {
                let Some(face) = face(frame, cell, corners) else { continue };
                let mut key = [u32::MAX; MOST_NODES];
                key[..face.len()].copy_from_slice(&face);
                key.sort_unstable();
                if open.remove(&key).is_none() {
                    open.insert(key, (cell, order));
                }
            }
        }
        let mut outer: Vec<(usize, usize)> = open.into_values().collect();
        // the order of a hash map is nobody's
        outer.sort_unstable();
        let of_cell = |(cell, order): (usize, usize)| {
            Some(OuterFace { cell, nodes: face(frame, cell, faces_of(frame.types[cell])[order])? })
        };
        Self { faces: outer.into_iter().filter_map(of_cell).collect() }
    }
}

/// How a field becomes one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// One of its components.
    Component(usize),
    /// The length of a vector, or a scalar as it is.
    Magnitude,
}

impl Part {
    /// The names of the components of a field that has so many.
    pub fn names(components: usize) -> &'static [&'static str] {
        match components {
            3 => &["x", "y", "z"],
            6 => &["xx", "yy", "zz", "xy", "yz", "xz"],
            _ => &[],
        }
    }

    fn of(self, components: &[f64]) -> f64 {
        match (self, components) {
            (_, []) => f64::NAN,
            (Self::Component(index), _) => components.get(index).copied().unwrap_or(f64::NAN),
            (Self::Magnitude, [scalar]) => *scalar,
            (Self::Magnitude, vector) => vector.iter().map(|component| component * component).sum::<f64>().sqrt(),
        }
    }

    /// Its number for a node or a cell.
    fn at(self, field: &FieldContent, index: usize) -> f64 {
        let start = index * field.components;
        self.of(field.data.get(start..start + field.components).unwrap_or_default())
    }

    /// Of the axes x, y and z: whether the number becomes its negative in a mirror image along it, as the components of vectors
    /// and tensors do that have the axis once in their name.
    fn is_odd(self, components: usize) -> [bool; 3] {
        let Self::Component(index) = self else { return [false; 3] };
        let name = Self::names(components).get(index).copied().unwrap_or_default();
        ['x', 'y', 'z'].map(|axis| name.chars().filter(|letter| *letter == axis).count() == 1)
    }
}

/// Means around the nodes of a skin, of the cells of one part each: parts may be of different materials, and where they meet the
/// stresses along their faces jump.
struct Means {
    /// Sum and number of the values of the cells of a part around a node.
    sums: HashMap<(u32, i64), (f64, f64)>,
}

impl Means {
    fn of(frame: &FrameContent, field: &FieldContent, part: Part, is_on_skin: &[bool]) -> Self {
        let mut sums = HashMap::new();
        for cell in (0..frame.types.len()).filter(|&cell| is_seen(frame, cell)) {
            let nodes = frame.cell(cell).iter().filter(|&&node| is_on_skin[node as usize]);
            for &node in nodes {
                let (sum, count) = sums.entry((node, part_of(frame, cell))).or_insert((0.0, 0.0));
                *sum += part.at(field, cell);
                *count += 1.0;
            }
        }
        Self { sums }
    }

    fn at(&self, node: u32, part: i64) -> f64 {
        self.sums.get(&(node, part)).map_or(f64::NAN, |(sum, count)| sum / count)
    }
}

/// The number of the part that a cell is of; one number for all in frames that do not tell.
fn part_of(frame: &FrameContent, cell: usize) -> i64 {
    frame.cell_fields.get(PART).and_then(|parts| parts.data.get(cell)).map_or(0, |part| *part as i64)
}

impl Surface {
    /// The surface of a frame, with a field of it; none if the frame has no such field. Deleted cells are left out.
    ///
    /// A field of nodes has their values. A field of cells has at a node the mean of the cells around it that are of the same part;
    /// one that numbers cells or marks them has the value of each as it is.
    pub fn of(frame: &FrameContent, field: &str, part: Part) -> Option<Self> {
        Self::on(&Skin::of(frame), frame, field, part)
    }

    /// The same where the outer faces are known already.
    pub fn on(skin: &Skin, frame: &FrameContent, name: &str, part: Part) -> Option<Self> {
        let mut surface = Self::default();
        let mut places = vec![u32::MAX; frame.points.len()];
        for &node in skin.faces.iter().flat_map(|face| &face.nodes) {
            let place = &mut places[node as usize];
            if *place == u32::MAX {
                *place = surface.vertices.len() as u32;
                surface.vertices.push(frame.points[node as usize]);
            }
        }
        let mut with_values = |field: &FieldContent, value: &dyn Fn(usize, u32) -> f64| {
            let corner = |cell, node: u32| Corner { vertex: places[node as usize], value: value(cell, node) };
            let corners = |face: &OuterFace| face.nodes.iter().map(|&node| corner(face.cell, node)).collect();
            surface.faces = skin.faces.iter().map(corners).collect();
            surface.is_odd = part.is_odd(field.components);
        };
        if let Some(field) = frame.node_fields.get(name) {
            with_values(field, &|_, node| part.at(field, node as usize));
            return Some(surface);
        }
        let field = frame.cell_fields.get(name)?;
        if is_label(name) {
            with_values(field, &|cell, _| part.at(field, cell));
            return Some(surface);
        }
        let is_on_skin: Vec<bool> = places.iter().map(|place| *place != u32::MAX).collect();
        let means = Means::of(frame, field, part, &is_on_skin);
        with_values(field, &|cell, node| means.at(node, part_of(frame, cell)));
        surface.is_mean = true;
        Some(surface)
    }

    /// Whether the body lies on both sides of the plane where a coordinate is zero, by more than a thousandth of its size.
    pub fn is_cut_by(&self, axis: usize) -> bool {
        let places = || self.vertices.iter().map(|vertex| vertex[axis]);
        let (low, high) = (places().fold(f64::INFINITY, f64::min), places().fold(f64::NEG_INFINITY, f64::max));
        (-low).min(high) > 1e-3 * (high - low)
    }

    /// The body with its mirror image in the plane where a coordinate is zero; what lies in the plane is inside then. A value that
    /// becomes its negative in the mirror does so in the image.
    pub fn mirrored(mut self, axis: usize) -> Self {
        let size = self.vertices.iter().map(|vertex| vertex[axis].abs()).fold(0.0, f64::max);
        let is_in_plane: Vec<bool> = self.vertices.iter().map(|vertex| vertex[axis].abs() < 1e-6 * size).collect();
        let is_inside = |corner: &Corner| is_in_plane[corner.vertex as usize];
        self.faces.retain(|face| !face.iter().all(is_inside));
        let sign = if self.is_odd[axis] { -1.0 } else { 1.0 };
        if self.is_odd[axis] && self.is_mean {
            // half of the cells around a node in the plane are images
            self.faces.iter_mut().flatten().filter(|corner| is_inside(corner)).for_each(|corner| corner.value = 0.0);
        }
        let count = self.vertices.len() as u32;
        let image = |corner: &Corner| Corner { vertex: corner.vertex + count, value: sign * corner.value };
        let images: Vec<Vec<Corner>> = self.faces.iter().map(|face| face.iter().rev().map(image).collect()).collect();
        self.faces.extend(images);
        self.vertices.extend_from_within(..);
        self.vertices[count as usize..].iter_mut().for_each(|vertex| vertex[axis] = -vertex[axis]);
        self
    }

    /// The least and the greatest value; none where no value is a finite number.
    pub fn range(&self) -> Option<[f64; 2]> {
        let finite = || self.faces.iter().flatten().map(|corner| corner.value).filter(|value| value.is_finite());
        let range = [finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max)];
        (range[0] <= range[1]).then_some(range)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use estar_io::FieldContent;
    use std::collections::BTreeMap;

    /// Two cubes of 1 m side by side along x.
    fn two_cubes() -> FrameContent {
        let points = (0..12).map(|node| [node % 3, node / 3 % 2, node / 6].map(f64::from)).collect();
        let cube = |first: u32| [0, 1, 4, 3, 6, 7, 10, 9].map(|node| node + first);
        let plastic = FieldContent { components: 1, data: vec![1.0, 3.0] };
        let velocity = FieldContent { components: 3, data: [3.0, 0.0, 4.0].repeat(12) };
        FrameContent {
            time: 0.0,
            points,
            connectivity: [cube(0), cube(1)].concat(),
            offsets: vec![8, 16],
            types: vec![12, 12],
            node_fields: BTreeMap::from([("velocity".to_owned(), velocity)]),
            cell_fields: BTreeMap::from([("plastic".to_owned(), plastic)]),
        }
    }

    /// The values of the corners where x is this.
    fn values_at(surface: &Surface, x: f64) -> Vec<f64> {
        let corners = surface.faces.iter().flatten();
        corners.filter(|corner| surface.vertices[corner.vertex as usize][0] == x).map(|corner| corner.value).collect()
    }

    #[test]
    fn the_face_between_two_cells_is_inside() {
        let surface = Surface::of(&two_cubes(), "plastic", Part::Magnitude).unwrap();
        assert_eq!((surface.faces.len(), surface.vertices.len()), (10, 12));
        assert_eq!(surface.range(), Some([1.0, 3.0]));
        // a node of both cells has their mean
        assert_eq!(values_at(&surface, 1.0), [2.0; 16]);
    }

    #[test]
    fn no_mean_is_taken_across_parts() {
        let mut frame = two_cubes();
        frame.cell_fields.insert(PART.to_owned(), FieldContent { components: 1, data: vec![1.0, 2.0] });
        let surface = Surface::of(&frame, "plastic", Part::Magnitude).unwrap();
        assert_eq!((surface.faces.len(), surface.vertices.len()), (10, 12));
        // where the parts meet, each of the four faces on either side has the value of its own
        let mut values = values_at(&surface, 1.0);
        values.sort_by(f64::total_cmp);
        assert_eq!(values, [[1.0; 8], [3.0; 8]].concat());
        for face in &surface.faces {
            assert!(face.iter().all(|corner| corner.value == face[0].value));
        }
    }

    #[test]
    fn a_number_of_cells_is_drawn_as_it_is() {
        let mut frame = two_cubes();
        for name in [PART, "element_id"] {
            frame.cell_fields.insert(name.to_owned(), FieldContent { components: 1, data: vec![1.0, 3.0] });
            let surface = Surface::of(&frame, name, Part::Magnitude).unwrap();
            let values: Vec<f64> = surface.faces.iter().flatten().map(|corner| corner.value).collect();
            assert!(values.iter().all(|value| [1.0, 3.0].contains(value)), "{name}: {values:?}");
        }
    }

    #[test]
    fn faces_look_outwards() {
        let surface = Surface::of(&two_cubes(), "plastic", Part::Magnitude).unwrap();
        // ∮ x · n dA = 3 V
        let mut sum = 0.0;
        for face in &surface.faces {
            let [a, b, c, d] = [0, 1, 2, 3].map(|corner| surface.vertices[face[corner].vertex as usize]);
            let (p, q): ([f64; 3], [f64; 3]) =
                (std::array::from_fn(|i| c[i] - a[i]), std::array::from_fn(|i| d[i] - b[i]));
            let area = [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
            let centre: [f64; 3] = std::array::from_fn(|i| 0.25 * (a[i] + b[i] + c[i] + d[i]));
            sum += (0..3).map(|i| 0.5 * area[i] * centre[i]).sum::<f64>();
        }
        assert!((sum - 6.0).abs() < 1e-12, "{sum}");
    }

    #[test]
    fn deleted_cells_are_left_out_and_fields_have_parts() {
        let mut frame = two_cubes();
        frame.cell_fields.insert(GHOSTS.to_owned(), FieldContent { components: 1, data: vec![0.0, 32.0] });
        let surface = Surface::of(&frame, "velocity", Part::Magnitude).unwrap();
        assert_eq!(surface.faces.len(), 6);
        assert_eq!(surface.range(), Some([5.0, 5.0]));
        let along = Surface::of(&frame, "velocity", Part::Component(2)).unwrap();
        assert_eq!(along.range(), Some([4.0, 4.0]));
        assert!(Surface::of(&frame, "heat", Part::Magnitude).is_none());
    }

    #[test]
    fn a_plane_cuts_the_body_that_lies_on_both_sides_of_it() {
        let mut surface = Surface::of(&two_cubes(), "plastic", Part::Magnitude).unwrap();
        assert!(!surface.is_cut_by(0));
        surface.vertices.iter_mut().for_each(|vertex| vertex[0] -= 0.5);
        assert_eq!([0, 1, 2].map(|axis| surface.is_cut_by(axis)), [true, false, false]);
    }

    #[test]
    fn a_mirror_image_closes_the_body() {
        let surface = Surface::of(&two_cubes(), "plastic", Part::Magnitude).unwrap().mirrored(0);
        assert_eq!((surface.faces.len(), surface.vertices.len()), (18, 24));
        assert!(surface.vertices.iter().any(|vertex| vertex[0] == -2.0));
    }

    #[test]
    fn components_turn_their_sign_in_the_mirror_as_vectors_and_tensors_do() {
        let mut frame = two_cubes();
        let stress = FieldContent { components: 6, data: [1.0, 2.0, 3.0, 4.0, 5.0, 6.0].repeat(2) };
        frame.cell_fields.insert("stress".to_owned(), stress);
        // of x, y, z, xx, yy, zz, xy, yz, xz under x → −x, y → −y, z → −z
        let signs = [
            ("velocity", 0, [-1.0, 1.0, 1.0]),
            ("velocity", 2, [1.0, 1.0, -1.0]),
            ("stress", 0, [1.0, 1.0, 1.0]),
            ("stress", 1, [1.0, 1.0, 1.0]),
            ("stress", 2, [1.0, 1.0, 1.0]),
            ("stress", 3, [-1.0, -1.0, 1.0]),
            ("stress", 4, [1.0, -1.0, -1.0]),
            ("stress", 5, [-1.0, 1.0, -1.0]),
        ];
        for (field, component, signs) in signs {
            let surface = Surface::of(&frame, field, Part::Component(component)).unwrap();
            let value = surface.faces[0][0].value;
            for (axis, sign) in signs.into_iter().enumerate() {
                let mirrored = surface.clone().mirrored(axis);
                let image = mirrored.faces[mirrored.faces.len() / 2..].iter().flatten();
                let away = image.filter(|corner| mirrored.vertices[corner.vertex as usize][axis] != 0.0);
                let values: Vec<f64> = away.map(|corner| corner.value).collect();
                assert!(values.iter().all(|found| *found == sign * value), "{field} {component} {axis}: {values:?}");
                let range = if sign < 0.0 { [-value, value] } else { [value, value] };
                assert_eq!(mirrored.range(), Some(range), "{field} {component} {axis}");
            }
        }
        // twice: the sign of each mirror
        let twice = Surface::of(&frame, "stress", Part::Component(3)).unwrap().mirrored(0).mirrored(1);
        let value = |x: f64, y: f64| {
            let is_there = |corner: &&Corner| twice.vertices[corner.vertex as usize][..2] == [x, y];
            twice.faces.iter().flatten().find(is_there).map(|corner| corner.value)
        };
        assert_eq!([value(2.0, 1.0), value(-2.0, 1.0), value(-2.0, -1.0)], [Some(4.0), Some(-4.0), Some(4.0)]);
        // a mean around a node in the plane is one of cells and of their images
        assert_eq!(value(0.0, 1.0), Some(0.0));
        assert_eq!(Surface::of(&frame, "velocity", Part::Magnitude).unwrap().mirrored(0).range(), Some([5.0, 5.0]));
    }
}
