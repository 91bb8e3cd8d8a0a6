//! A box of equal bricks.

use super::spec::{SpecError, hex_count, positive_count, positive_length};
use crate::{Group, Mesh};

/// A box from the origin to `lengths`, cut into `cells` along each axis.
#[derive(Debug, Clone, PartialEq)]
pub struct BoxSpec {
    lengths: [f64; 3],
    cells: [u32; 3],
}

impl BoxSpec {
    /// Checks that lengths are positive and cell counts at least 1.
    ///
    /// # Errors
    /// The first parameter out of its bounds.
    pub fn new(lengths: [f64; 3], cells: [u32; 3]) -> Result<Self, SpecError> {
        for (name, length) in ["length in x", "length in y", "length in z"].into_iter().zip(lengths) {
            positive_length(name, length)?;
        }
        for (name, count) in ["cells in x", "cells in y", "cells in z"].into_iter().zip(cells) {
            positive_count(name, count)?;
        }
        hex_count(cells.into_iter().map(f64::from).product())?;
        Ok(Self { lengths, cells })
    }
}

/// A mesh of the box: volume `box`, surfaces `x_min`, `x_max`, `y_min`, `y_max`, `z_min`, `z_max`.
pub fn box_mesh(spec: &BoxSpec) -> Mesh {
    let [nx, ny, nz] = spec.cells;
    let node = |i: u32, j: u32, k: u32| (k * (ny + 1) + j) * (nx + 1) + i;
    let place = |axis: usize, index: u32| f64::from(index) / f64::from(spec.cells[axis]) * spec.lengths[axis];

    let mut coordinates = Vec::with_capacity(node(nx, ny, nz) as usize + 1);
    for k in 0..=nz {
        for j in 0..=ny {
            for i in 0..=nx {
                coordinates.push([place(0, i), place(1, j), place(2, k)]);
            }
        }
    }
    let mut hexes = Vec::with_capacity(nx as usize * ny as usize * nz as usize);
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                let layer = |k| [node(i, j, k), node(i + 1, j, k), node(i + 1, j + 1, k), node(i, j + 1, k)];
                let ([a, b, c, d], [e, f, g, h]) = (layer(k), layer(k + 1));
                hexes.push([a, b, c, d, e, f, g, h]);
            }
        }
    }
    // A face of the grid u × v, at the least or the greatest value of the third axis, with its normal outwards.
    let side = |name: &str, u_count: u32, v_count: u32, outwards: bool, at: &dyn Fn(u32, u32) -> u32| {
        let cells = (0..v_count).flat_map(|v| (0..u_count).map(move |u| (u, v)));
        let faces = cells.map(|(u, v)| {
            let mut face = [at(u, v), at(u + 1, v), at(u + 1, v + 1), at(u, v + 1)];
            if !outwards {
                face.reverse();
            }
            face
        });
        Group::surface(name, faces)
    };
    let groups = vec![
        Group::volume("box", (0..hexes.len() as u32).collect()),
        side("x_min", ny, nz, false, &|u, v| node(0, u, v)),
        side("x_max", ny, nz, true, &|u, v| node(nx, u, v)),
        side("y_min", nz, nx, false, &|u, v| node(v, 0, u)),
        side("y_max", nz, nx, true, &|u, v| node(v, ny, u)),
        side("z_min", nx, ny, false, &|u, v| node(u, v, 0)),
        side("z_max", nx, ny, true, &|u, v| node(u, v, nz)),
    ];
    Mesh::generated(coordinates, hexes, groups)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quality::QualityReport;

    #[test]
    fn a_box_has_its_volume_and_its_sides_their_area() {
        let mesh = box_mesh(&BoxSpec::new([2.0, 3.0, 5.0], [2, 3, 4]).unwrap());
        let report = QualityReport::new(&mesh);
        assert!(report.errors().is_empty());
        assert!((report.total_volume() - 30.0).abs() < 1e-12);
        for (name, axis, value, face_count) in
            [("x_min", 0, 0.0, 12), ("x_max", 0, 2.0, 12), ("y_max", 1, 3.0, 8), ("z_min", 2, 0.0, 6)]
        {
            let group = mesh.group(name).unwrap();
            assert_eq!(group.faces.len(), face_count);
            assert!(group.nodes.iter().all(|&node| mesh.coordinates()[node as usize][axis] == value));
            // Written outwards already, up to the first corner.
            for (written, outward) in group.faces.iter().zip(mesh.outward_faces(group).unwrap()) {
                let (written, outward) = (written.nodes(), outward.nodes());
                let start = outward.iter().position(|node| *node == written[0]).unwrap();
                assert_eq!([0, 1, 2, 3].map(|k| outward[(start + k) % 4]), *written);
            }
        }
    }

    #[test]
    fn a_bad_parameter_is_named_with_its_value_and_bound() {
        let error = BoxSpec::new([1.0, -2.0, 1.0], [1, 1, 1]).unwrap_err();
        assert_eq!(error.to_string(), "length in y = -2: must be a length greater than 0, from 1e-90 to 1e90");
        assert!(BoxSpec::new([1.0; 3], [1, 0, 1]).is_err());
        assert!(BoxSpec::new([1.0; 3], [u32::MAX; 3]).is_err());
        assert!(BoxSpec::new([f64::NAN, 1.0, 1.0], [1; 3]).is_err());
    }
}
