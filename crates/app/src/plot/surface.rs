//! The outer surface of a body of cells, for pictures of it.

use estar_io::FrameContent;
use std::collections::HashMap;

/// The outer faces of a body over the nodes of its frames: the same in all of them until cells are deleted.
#[derive(Clone, Debug, Default)]
pub struct Skin {
    faces: Vec<Vec<u32>>,
}

/// The surface of a body: polygons over vertices with a position and a value.
#[derive(Clone, Debug, Default)]
pub struct Surface {
    /// Positions, m.
    pub vertices: Vec<[f64; 3]>,
    /// A value at each vertex.
    pub values: Vec<f64>,
    /// The vertices around each face, counterclockwise seen from outside.
    pub faces: Vec<Vec<u32>>,
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

/// What says of cells that they are not to be seen.
pub const GHOSTS: &str = "vtkGhostType";

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
        let of_cell = |(cell, order): (usize, usize)| face(frame, cell, faces_of(frame.types[cell])[order]);
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
            (Self::Component(index), _) => components.get(index).copied().unwrap_or(f64::NAN),
            (Self::Magnitude, [scalar]) => *scalar,
            (Self::Magnitude, vector) => vector.iter().map(|component| component * component).sum::<f64>().sqrt(),
        }
    }
}

impl Surface {
    /// The surface of a frame, with a field of it; none if the frame has no such field. Deleted cells are left out.
    pub fn of(frame: &FrameContent, field: &str, part: Part) -> Option<Self> {
        Self::on(&Skin::of(frame), frame, field, part)
    }

    /// The same where the outer faces are known already.
    pub fn on(skin: &Skin, frame: &FrameContent, field: &str, part: Part) -> Option<Self> {
        let mut values = vec![f64::NAN; frame.points.len()];
        if let Some(field) = frame.node_fields.get(field) {
            for (value, components) in values.iter_mut().zip(field.data.chunks_exact(field.components)) {
                *value = part.of(components);
            }
        } else {
            let field = frame.cell_fields.get(field)?;
            let mut sums = vec![(0.0, 0.0); frame.points.len()];
            for cell in (0..frame.types.len()).filter(|&cell| is_seen(frame, cell)) {
                let value = part.of(&field.data[cell * field.components..(cell + 1) * field.components]);
                for &node in frame.cell(cell) {
                    let (sum, count) = &mut sums[node as usize];
                    *sum += value;
                    *count += 1.0;
                }
            }
            for (value, (sum, count)) in values.iter_mut().zip(sums) {
                *value = sum / count;
            }
        }

        let mut places = vec![u32::MAX; frame.points.len()];
        let mut surface = Self::default();
        for face in &skin.faces {
            let mut vertex = |&node: &u32| {
                let place = &mut places[node as usize];
                if *place == u32::MAX {
                    *place = surface.vertices.len() as u32;
                    surface.vertices.push(frame.points[node as usize]);
                    surface.values.push(values[node as usize]);
                }
                *place
            };
            let face = face.iter().map(&mut vertex).collect();
            surface.faces.push(face);
        }
        Some(surface)
    }

    /// The body with its mirror image in the plane where a coordinate is zero; what lies in the plane is inside then.
    pub fn mirrored(mut self, axis: usize) -> Self {
        let size = self.vertices.iter().map(|vertex| vertex[axis].abs()).fold(0.0, f64::max);
        let is_in_plane = |surface: &Self, face: &Vec<u32>| {
            face.iter().all(|&vertex| surface.vertices[vertex as usize][axis].abs() < 1e-6 * size)
        };
        let kept: Vec<Vec<u32>> = self.faces.iter().filter(|face| !is_in_plane(&self, face)).cloned().collect();
        let count = self.vertices.len() as u32;
        let turned = kept.iter().map(|face| face.iter().rev().map(|vertex| vertex + count).collect());
        self.faces = kept.iter().cloned().chain(turned).collect();
        let images: Vec<[f64; 3]> = self
            .vertices
            .iter()
            .map(|&vertex| {
                let mut image = vertex;
                image[axis] = -image[axis];
                image
            })
            .collect();
        self.vertices.extend(images);
        self.values.extend_from_within(..);
        self
    }

    /// The least and the greatest value; none where no value is a finite number.
    pub fn range(&self) -> Option<[f64; 2]> {
        let finite = || self.values.iter().copied().filter(|value| value.is_finite());
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

    #[test]
    fn the_face_between_two_cells_is_inside() {
        let surface = Surface::of(&two_cubes(), "plastic", Part::Magnitude).unwrap();
        assert_eq!((surface.faces.len(), surface.vertices.len()), (10, 12));
        assert_eq!(surface.range(), Some([1.0, 3.0]));
        // a node of both cells has their mean
        let shared = surface.vertices.iter().position(|vertex| vertex[0] == 1.0).unwrap();
        assert_eq!(surface.values[shared], 2.0);
    }

    #[test]
    fn faces_look_outwards() {
        let surface = Surface::of(&two_cubes(), "plastic", Part::Magnitude).unwrap();
        // ∮ x · n dA = 3 V
        let mut sum = 0.0;
        for face in &surface.faces {
            let [a, b, c, d] = [0, 1, 2, 3].map(|corner| surface.vertices[face[corner] as usize]);
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
    fn a_mirror_image_closes_the_body() {
        let surface = Surface::of(&two_cubes(), "plastic", Part::Magnitude).unwrap().mirrored(0);
        assert_eq!((surface.faces.len(), surface.vertices.len()), (18, 24));
        assert!(surface.vertices.iter().any(|vertex| vertex[0] == -2.0));
    }
}
