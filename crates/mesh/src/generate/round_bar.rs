//! Bars of round section along z: the cylinder, and the bar that necks.

use super::disc::{Disc, disc, quarter_quad_count};
use super::grading::graded_levels;
use super::spec::{SpecError, grading_ratio, hex_count, positive_count, positive_length};
use crate::{Group, Mesh};

/// How much of a round section is meshed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Section {
    /// The quarter x, y ≥ 0, between the symmetry planes x = 0 and y = 0.
    Quarter,
    /// All of it.
    Full,
}

/// What a [`CylinderSpec`] is made from.
#[derive(Debug, Clone, PartialEq)]
pub struct CylinderParameters {
    /// The radius.
    pub radius: f64,
    /// The length along z, from z = 0.
    pub length: f64,
    /// How much of the section.
    pub section: Section,
    /// Cells along each side of a quarter's core.
    pub core_cells: u32,
    /// Rings of cells around the core.
    pub radial_rings: u32,
    /// Cells along z.
    pub axial_cells: u32,
    /// Length of the last cell along z over that of the first; 1 is uniform.
    pub axial_grading: f64,
}

/// A cylinder whose parameters are valid.
#[derive(Debug, Clone, PartialEq)]
pub struct CylinderSpec(CylinderParameters);

impl TryFrom<CylinderParameters> for CylinderSpec {
    type Error = SpecError;

    fn try_from(p: CylinderParameters) -> Result<Self, SpecError> {
        positive_length("radius", p.radius)?;
        positive_length("length", p.length)?;
        positive_count("core cells", p.core_cells)?;
        positive_count("radial rings", p.radial_rings)?;
        positive_count("axial cells", p.axial_cells)?;
        grading_ratio("axial grading", p.axial_grading)?;
        let quarters = if p.section == Section::Full { 4.0 } else { 1.0 };
        hex_count(quarters * quarter_quad_count(p.core_cells, p.radial_rings) * f64::from(p.axial_cells))?;
        Ok(Self(p))
    }
}

/// A mesh of the cylinder, O-grid in section: volume `bar`; surfaces `foot` (z = 0), `top`, `side`, and in a quarter
/// `symmetry_x` (x = 0) and `symmetry_y` (y = 0); curve `axis`.
pub fn cylinder(spec: &CylinderSpec) -> Mesh {
    let p = &spec.0;
    let section = disc(p.core_cells, p.radial_rings, p.section == Section::Full);
    let levels = graded_levels(p.length, p.axial_cells, p.axial_grading);
    let bar = Bar { section: &section, levels: &levels };
    let mut groups = bar.groups("foot", "top");
    groups.push(Group::curve("axis", (0..levels.len()).map(|k| bar.node(section.centre, k)).collect()));
    Mesh::generated(bar.coordinates(|_| p.radius), bar.hexes(), groups)
}

/// What a [`NeckingBarSpec`] is made from.
#[derive(Debug, Clone, PartialEq)]
pub struct NeckingBarParameters {
    /// Length L₀ of the whole bar; half of it is meshed.
    pub full_length: f64,
    /// Radius R₀ at the ends.
    pub end_radius: f64,
    /// Radius at the mid-plane over that at the ends: 0.982 in the published problem.
    pub neck_ratio: f64,
    /// Cells along each side of the core.
    pub core_cells: u32,
    /// Rings of cells around the core.
    pub radial_rings: u32,
    /// Cells along z.
    pub axial_cells: u32,
    /// Length of the last cell along z (at the grip) over that of the first (at the neck).
    pub axial_grading: f64,
}

/// A bar that necks, whose parameters are valid.
#[derive(Debug, Clone, PartialEq)]
pub struct NeckingBarSpec(NeckingBarParameters);

impl TryFrom<NeckingBarParameters> for NeckingBarSpec {
    type Error = SpecError;

    fn try_from(p: NeckingBarParameters) -> Result<Self, SpecError> {
        positive_length("full length", p.full_length)?;
        positive_length("end radius", p.end_radius)?;
        if !(p.neck_ratio >= 0.5 && p.neck_ratio <= 1.0) {
            return Err(SpecError { parameter: "neck ratio", value: p.neck_ratio, bound: "between 0.5 and 1" });
        }
        positive_count("core cells", p.core_cells)?;
        positive_count("radial rings", p.radial_rings)?;
        positive_count("axial cells", p.axial_cells)?;
        grading_ratio("axial grading", p.axial_grading)?;
        hex_count(quarter_quad_count(p.core_cells, p.radial_rings) * f64::from(p.axial_cells))?;
        Ok(Self(p))
    }
}

impl NeckingBarSpec {
    /// r(z) = R₀ (q + 2 (1 − q) |z|/L₀): R₀ at the ends, q R₀ at the mid-plane z = 0.
    fn radius(&self, z: f64) -> f64 {
        let p = &self.0;
        p.end_radius * (p.neck_ratio + 2.0 * (1.0 - p.neck_ratio) * z.abs() / p.full_length)
    }
}

/// An eighth of the necking bar: volume `bar`; surfaces `symmetry_x` (x = 0), `symmetry_y` (y = 0), `symmetry_z`
/// (the mid-plane z = 0), `grip` (the pulled end), `side`; curve `axis`; point `neck` (on x, at the mid-plane's rim).
///
/// The published problem (J. C. Simo and T. J. R. Hughes, Computational Inelasticity, 1998) has L₀ = 53.334 mm,
/// R₀ = 6.413 mm and a neck ratio of 0.982.
pub fn necking_bar(spec: &NeckingBarSpec) -> Mesh {
    let p = &spec.0;
    let section = disc(p.core_cells, p.radial_rings, false);
    let levels = graded_levels(0.5 * p.full_length, p.axial_cells, p.axial_grading);
    let bar = Bar { section: &section, levels: &levels };
    let mut groups = bar.groups("symmetry_z", "grip");
    groups.push(Group::curve("axis", (0..levels.len()).map(|k| bar.node(section.centre, k)).collect()));
    groups.push(Group::point("neck", vec![bar.node(section.east, 0)]));
    Mesh::generated(bar.coordinates(|z| spec.radius(z)), bar.hexes(), groups)
}

/// A section swept through levels of z.
struct Bar<'a> {
    section: &'a Disc,
    levels: &'a [f64],
}

impl Bar<'_> {
    fn node(&self, point: u32, level: usize) -> u32 {
        (level * self.section.points.len()) as u32 + point
    }

    fn coordinates(&self, radius: impl Fn(f64) -> f64) -> Vec<[f64; 3]> {
        let mut coordinates = Vec::with_capacity(self.levels.len() * self.section.points.len());
        for &z in self.levels {
            let r = radius(z);
            coordinates.extend(self.section.points.iter().map(|[x, y]| [r * x, r * y, z]));
        }
        coordinates
    }

    fn hexes(&self) -> Vec<[u32; 8]> {
        let mut hexes = Vec::with_capacity((self.levels.len() - 1) * self.section.quads.len());
        for level in 0..self.levels.len() - 1 {
            for quad in &self.section.quads {
                let [a, b, c, d] = quad.map(|point| self.node(point, level));
                let [e, f, g, h] = quad.map(|point| self.node(point, level + 1));
                hexes.push([a, b, c, d, e, f, g, h]);
            }
        }
        hexes
    }

    /// The volume and all surfaces, normals outwards.
    fn groups(&self, low_end: &str, high_end: &str) -> Vec<Group> {
        let last = self.levels.len() - 1;
        let swept = |edges: &[[u32; 2]]| {
            let mut faces = Vec::with_capacity(last * edges.len());
            for level in 0..last {
                for &[from, to] in edges {
                    faces.push([
                        self.node(from, level),
                        self.node(to, level),
                        self.node(to, level + 1),
                        self.node(from, level + 1),
                    ]);
                }
            }
            faces
        };
        let end = |level: usize| self.section.quads.iter().map(move |quad| quad.map(|point| self.node(point, level)));
        let downwards = |[a, b, c, d]: [u32; 4]| [a, d, c, b];
        let hex_count = (last * self.section.quads.len()) as u32;
        let mut groups = vec![Group::volume("bar", (0..hex_count).collect())];
        if !self.section.on_x.is_empty() {
            groups.push(Group::surface("symmetry_x", swept(&self.section.on_x)));
            groups.push(Group::surface("symmetry_y", swept(&self.section.on_y)));
        }
        groups.push(Group::surface(low_end, end(0).map(downwards)));
        groups.push(Group::surface(high_end, end(last)));
        groups.push(Group::surface("side", swept(&self.section.side)));
        groups
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::GroupKind;
    use crate::quality::QualityReport;

    fn bar(section: Section, core_cells: u32, radial_rings: u32) -> Mesh {
        let spec = CylinderParameters {
            radius: 3.2,
            length: 32.4,
            section,
            core_cells,
            radial_rings,
            axial_cells: 3,
            axial_grading: 2.0,
        };
        cylinder(&spec.try_into().unwrap())
    }

    #[test]
    fn the_o_grid_is_well_shaped_for_any_counts() {
        for section in [Section::Quarter, Section::Full] {
            for core_cells in [1, 2, 3, 5, 8, 20] {
                for radial_rings in [1, 2, 4, 7, 20] {
                    let report = QualityReport::new(&bar(section, core_cells, radial_rings));
                    assert!(report.errors().is_empty());
                    let least = report.summary().min_scaled_jacobian;
                    assert!(least > 0.6, "{section:?}, core {core_cells}, rings {radial_rings}: {least}");
                }
            }
        }
    }

    #[test]
    fn volume_converges_to_the_cylinder_s_with_second_order() {
        for (section, share) in [(Section::Quarter, 0.25), (Section::Full, 1.0)] {
            let exact = share * PI * 3.2 * 3.2 * 32.4;
            let error = |n| exact - QualityReport::new(&bar(section, n, n)).total_volume();
            let order = (error(4) / error(8)).log2();
            assert!((order - 2.0).abs() < 0.02, "order {order}");
            assert!(error(16) > 0.0 && error(16) < 1e-3 * exact);
        }
    }

    #[test]
    fn every_surface_lies_where_its_name_says_and_faces_outwards() {
        let mesh = bar(Section::Quarter, 3, 2);
        let at = |node: u32| mesh.coordinates()[node as usize];
        let radius = |x: [f64; 3]| x[0].hypot(x[1]);
        let everywhere = |name: &str, test: &dyn Fn([f64; 3]) -> bool| {
            let group = mesh.group(name).unwrap();
            assert!(group.nodes.iter().all(|&node| test(at(node))), "{name}");
            for (written, outward) in group.faces.iter().zip(mesh.outward_faces(group).unwrap()) {
                let (written, outward) = (written.nodes(), outward.nodes());
                let start = outward.iter().position(|node| *node == written[0]).unwrap();
                assert_eq!([0, 1, 2, 3].map(|k| outward[(start + k) % 4]), *written, "{name}");
            }
        };
        everywhere("symmetry_x", &|x| x[0] == 0.0);
        everywhere("symmetry_y", &|x| x[1] == 0.0);
        everywhere("foot", &|x| x[2] == 0.0);
        everywhere("top", &|x| x[2] == 32.4);
        everywhere("side", &|x| (radius(x) - 3.2).abs() < 1e-12);
        everywhere("axis", &|x| radius(x) == 0.0);
        let outer_face_count: usize =
            mesh.groups().iter().filter(|g| g.kind == GroupKind::Surface).map(|g| g.faces.len()).sum();
        // 21 quads in section, 3 layers: two ends, 5 edges on each symmetry plane, 6 on the circle.
        assert_eq!((mesh.element_count(), outer_face_count), (63, 2 * 21 + 3 * (5 + 5 + 6)));
    }

    #[test]
    fn a_full_cylinder_has_no_symmetry_planes() {
        let mesh = bar(Section::Full, 2, 2);
        assert!(mesh.group("symmetry_x").is_none());
        assert_eq!(mesh.element_count(), 4 * 12 * 3);
        assert_eq!(mesh.outward_faces(mesh.group("side").unwrap()).unwrap().len(), 48);
    }

    #[test]
    fn the_necking_bar_is_thinnest_at_its_mid_plane() {
        let spec = NeckingBarParameters {
            full_length: 53.334,
            end_radius: 6.413,
            neck_ratio: 0.982,
            core_cells: 3,
            radial_rings: 3,
            axial_cells: 15,
            axial_grading: 4.0,
        };
        let mesh = necking_bar(&spec.try_into().unwrap());
        let neck = mesh.group("neck").unwrap();
        assert_eq!(neck.kind, GroupKind::Point);
        assert_eq!(mesh.coordinates()[neck.nodes[0] as usize], [0.982 * 6.413, 0.0, 0.0]);
        let grip = mesh.group("grip").unwrap();
        let widest = grip.nodes.iter().map(|&n| mesh.coordinates()[n as usize][0]).fold(0.0, f64::max);
        assert!((widest - 6.413).abs() < 1e-12);
        let report = QualityReport::new(&mesh);
        assert!(report.errors().is_empty() && report.summary().min_scaled_jacobian > 0.6);
        assert_eq!(mesh.element_count(), 27 * 15);
    }

    #[test]
    fn a_bad_parameter_is_named() {
        let p = CylinderParameters {
            radius: 1.0,
            length: 1.0,
            section: Section::Full,
            core_cells: 1,
            radial_rings: 1,
            axial_cells: 1,
            axial_grading: 0.0,
        };
        let error = CylinderSpec::try_from(p).unwrap_err();
        assert_eq!(error.to_string(), "axial grading = 0: must be between 0.001 and 1000");
    }
}
