//! Goal: elements of a soil fail at the strength that theory gives, under the pressure that confines them.
//!
//! Mesh and loading: a column under pressure on its sides is pressed slowly from above (the triaxial test). Source: Mohr and
//! Coulomb: σ₁ = σ₃ tan²(45° + φ/2) + 2 c tan(45° + φ/2); the cone of Drucker and Prager goes through these edges.

mod common;

use common::{DIRECTIONS, bricks, elasticity, faces, load, new, nodes, prescribed, stresses, until, whole};
use estar_material::{ClosestPoint, Hencky};
use estar_solver::model::{Direction, Fix, Formulation, LoadKind, Quantity};
use estar_solver::{Curve, Interpolation, Model};

#[test]
fn a_confined_column_fails_at_the_strength_of_mohr_and_coulomb() {
    let (cohesion, confinement, angle) = (1e6, 2e6, 30_f64.to_radians());
    let slope = (0.25 * std::f64::consts::PI + 0.5 * angle).tan();
    let strength = confinement * slope * slope + 2.0 * cohesion * slope;
    // so light that the stress of waves, ρ c v, is a few thousandths of the strength
    let rock = elasticity(2.0, 1e9, 0.25);
    let surfaces = [
        ("Mohr-Coulomb", ClosestPoint::mohr_coulomb(rock, angle, cohesion)),
        ("Drucker-Prager", ClosestPoint::drucker_prager(rock, angle, cohesion, angle)),
        ("Drucker-Prager without dilatancy", ClosestPoint::drucker_prager(rock, angle, cohesion, 0.0)),
    ];
    for (name, surface) in surfaces {
        let surface = surface.unwrap();
        // the forces of F-bar do not do the work of its strains, and flow that changes the volume feeds on that
        let formulation = Formulation::Full;
        let mesh = bricks([20e-3, 20e-3, 40e-3], [2, 2, 4]);
        // the pressure is all there before the column is pressed
        let pressure = |face| {
            let curve = Curve::new(vec![[0.0, 0.0], [1e-3, confinement], [1.0, confinement]], Interpolation::Smooth);
            load(face, LoadKind::Pressure { faces: faces(&mesh, face), curve: curve.unwrap() })
        };
        let pressed = Curve::new(vec![[0.0, 0.0], [1e-3, 0.0], [4e-3, -1e-3]], Interpolation::Smooth).unwrap();
        let held = |group, direction: Direction| Fix { nodes: nodes(&mesh, group), directions: vec![direction] };
        let model = Model {
            parts: whole(&mesh, Hencky::closest_point(surface).into(), formulation),
            fixes: ["x_min", "y_min", "z_min"].into_iter().zip(DIRECTIONS).map(|(group, d)| held(group, d)).collect(),
            prescribed: vec![prescribed(nodes(&mesh, "z_max"), Direction::Z, Quantity::Displacement, pressed)],
            loads: vec![pressure("x_max"), pressure("y_max")],
            settings: until(4e-3),
            ..Model::default()
        };
        let mut simulation = new(&mesh, model);
        let mut strongest = 0.0_f64;
        common::run(&mut simulation, |now| {
            let mean = stresses(now).iter().map(|stress| stress[2]).sum::<f64>() / mesh.element_count() as f64;
            strongest = strongest.max(-mean);
        });
        let lateral = stresses(&simulation).iter().map(|stress| stress[0]).sum::<f64>() / mesh.element_count() as f64;
        println!(
            "{name}: {strongest:.4e} of {strength:.4e} Pa, lateral {lateral:.4e} Pa, energy error {:.1e}",
            simulation.energies().error()
        );
        // Kirchhoff's stress yields, and J differs from 1 by the elastic strain
        assert!((strongest / strength - 1.0).abs() < 0.01, "{name}: {strongest} of {strength}");
        assert!((lateral / confinement + 1.0).abs() < 0.05, "{name}: {lateral}");
        assert!(simulation.energies().error().abs() < 1e-3, "{name}");
    }
}
