//! The problem that time per element step is measured on: a quarter of a copper rod, 32.4 mm long and 6.4 mm across,
//! that hits a wall at 227 m/s. `estar bench` and the benchmarks share it.

use estar_material::{
    AdiabaticHeating, EStar, EStarTotal, Elastic, ElasticConstant, ElasticEnergy, FlowRule, Hencky,
    IsotropicElasticity, IsotropicHardening, JohnsonCook, JohnsonCookParameters, KinematicHardening, MaterialModel,
    PlasticMetric,
};
use estar_mesh::generate::{CylinderParameters, CylinderSpec, Section, cut_into, cylinder};
use estar_mesh::{Mesh, Shape, locality_order};
use estar_solver::model::{
    Direction, Fix, Formulation, HourglassControl, InitialVelocity, Model, Part, RigidWall, TimeSettings,
};

/// Hexes of the mesh on which published codes were measured: the bar of 12 cells along the edge of the core.
pub const PEERS_HEX_COUNT: usize = bar_hex_count(12);

/// Hexes of the bar with so many cells along the edge of the core, as many rings, and eight times as many along the axis.
const fn bar_hex_count(cells: usize) -> usize {
    3 * cells * cells * 8 * cells
}

/// The mesh that has nearest to `element_count` elements of a shape, hexes or what they are cut into, in an order kind to the cache.
pub fn mesh(element_count: usize, shape: Shape) -> Mesh {
    let per_hex = match shape {
        Shape::Hex8 | Shape::Pyramid5 => 1,
        Shape::Wedge6 => 2,
        Shape::Tet4 | Shape::Tet10 => 6,
    };
    let cells = (element_count as f64 / (per_hex * bar_hex_count(1)) as f64).cbrt().round().max(1.0) as u32;
    let parameters = CylinderParameters {
        radius: 3.2e-3,
        length: 32.4e-3,
        section: Section::Quarter,
        core_cells: cells,
        radial_rings: cells,
        axial_cells: 8 * cells,
        axial_grading: 1.0,
    };
    let mesh = cut_into(&cylinder(&CylinderSpec::try_from(parameters).expect("valid parameters")), shape);
    mesh.renumbered(&locality_order(&mesh))
}

/// The bar on a mesh of [`mesh`].
pub fn model(mesh: &Mesh, material: MaterialModel, element: Formulation) -> Model {
    let nodes = |name: &str| mesh.group(name).expect("a group of the generator").nodes.clone();
    let bar = mesh.group("bar").expect("a group of the generator");
    Model {
        parts: vec![Part { elements: bar.elements.clone(), material, element }],
        fixes: vec![
            Fix { nodes: nodes("symmetry_x"), directions: vec![Direction::X] },
            Fix { nodes: nodes("symmetry_y"), directions: vec![Direction::Y] },
        ],
        initial_velocities: vec![InitialVelocity {
            nodes: bar.nodes.clone(),
            translation: [0.0, 0.0, -227.0],
            spin: None,
        }],
        walls: vec![RigidWall::plane([0.0; 3], [0.0, 0.0, 1.0], 0.0)],
        settings: TimeSettings { end: 80e-6, ..TimeSettings::default() },
        ..Model::default()
    }
}

/// Every material that is measured, by name. Green-Naghdi's theory is not: it does not reach the end of this impact.
pub fn materials() -> Vec<(&'static str, MaterialModel)> {
    let elasticity =
        IsotropicElasticity::new(8930.0, ElasticConstant::YoungModulus(117e9), ElasticConstant::PoissonRatio(0.35))
            .expect("valid constants");
    let linear = IsotropicHardening::linear(400e6, 100e6).expect("valid parameters");
    let voce = IsotropicHardening::voce(400e6, 500e6, 10.0).expect("valid parameters");
    let kinematic = KinematicHardening::prager(1e8).expect("valid parameters");
    // copper of Johnson and Cook 1983
    let johnson_cook = JohnsonCook::new(JohnsonCookParameters {
        a: 90e6,
        b: 292e6,
        n: 0.31,
        c: 0.025,
        m: 1.09,
        reference_rate: 1.0,
        reference_temperature: 293.0,
        melting_temperature: 1356.0,
    });
    let heating = AdiabaticHeating { specific_heat: 383.0, taylor_quinney: 0.9, initial_temperature: 293.0 };
    let johnson_cook = johnson_cook.and_then(|law| law.with_heating(heating, &elasticity)).expect("valid parameters");
    let box_rate = |hardening: &IsotropicHardening, kinematic| {
        MaterialModel::e_star_box_rate(elasticity, hardening.clone(), kinematic)
    };
    vec![
        ("e-star box-rate linear", box_rate(&linear, KinematicHardening::NONE)),
        ("e-star box-rate voce", box_rate(&voce, KinematicHardening::NONE)),
        ("e-star box-rate prager", box_rate(&linear, kinematic)),
        ("e-star johnson-cook", EStar::new(elasticity, johnson_cook, ()).into()),
        ("e-star total linear", EStarTotal::new(elasticity, linear.clone()).into()),
        (
            "simo-miehe linear",
            PlasticMetric::new(elasticity, linear.clone(), ElasticEnergy::Hencky, FlowRule::SimoMiehe).into(),
        ),
        ("hencky linear", Hencky::von_mises(elasticity, linear).into()),
        ("elastic", Elastic::new(elasticity).into()),
    ]
}

/// Every element, with the control that needs nothing chosen.
pub const ELEMENTS: [Formulation; 6] = [
    Formulation::FBar,
    Formulation::BBar,
    Formulation::OnePoint(HourglassControl::Physical),
    Formulation::Full,
    Formulation::Tet4,
    Formulation::Tet10,
];

/// The shape that an element is measured in.
pub const fn shape(element: Formulation) -> Shape {
    match element {
        Formulation::Tet4 => Shape::Tet4,
        Formulation::Tet10 => Shape::Tet10,
        _ => Shape::Hex8,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_has_the_hexes_of_the_peers_or_as_near_as_can_be() {
        assert_eq!(PEERS_HEX_COUNT, 41_472);
        assert_eq!(mesh(PEERS_HEX_COUNT, Shape::Hex8).element_count(), PEERS_HEX_COUNT);
        assert_eq!(mesh(1, Shape::Hex8).element_count(), 24);
        assert_eq!(mesh(200, Shape::Hex8).element_count(), 192);
        assert_eq!(mesh(1_000, Shape::Tet10).element_count(), 1_152);
    }
}
