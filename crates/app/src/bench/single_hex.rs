//! One element (or one a lane) in the motion of the bar's foot: to count the operations of an element step, and to time the
//! element alone.

use estar_element::element::{Element, ElementHistory, ElementMotion, ElementStep, ElementUpdate, ElementVisitor};
use estar_material::points::{Exchange, MaterialPoints, PackPoints};
use estar_material::{IsotropicElasticity, MaterialModel};
use estar_solver::model::Formulation;
use estar_tensor::{Counted, Kernel, Operations, Real, Vector3, array, operations};

/// Edge of the hex, or of the cube round the tet, m.
const EDGE: f64 = 0.25e-3;
/// Steps that lead to the state of interest.
pub const STEPS_BEFORE: usize = 20;

/// How fast an element is deformed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// As where a wave passes: every point stays elastic.
    Elastic,
    /// As in the foot of the bar: every point yields.
    Yielding,
}

impl Pace {
    /// Rate of the compression along z, 1/s.
    fn rate(self) -> f64 {
        match self {
            Self::Elastic => 5e2,
            Self::Yielding => 5e4,
        }
    }
}

/// An element that is compressed, sheared, turned and bent at a constant rate, so that no two of its points do the same.
pub struct SingleElement<E: Element<NODES>, R: Real, const NODES: usize> {
    elasticity: IsotropicElasticity,
    element: E,
    history: ElementHistory<R, E::Own<R>>,
    points: Box<dyn MaterialPoints<R>>,
    exchange: Exchange<R>,
    motion: ElementMotion<R, NODES>,
    step: ElementStep,
}

impl<E: Element<NODES>, R: Real, const NODES: usize> SingleElement<E, R, NODES> {
    /// The element at rest.
    pub fn new(material: &MaterialModel, element: E, pace: Pace) -> Self {
        // a corner is moved, so that no two edges are parallel by chance
        let corner = |corner: usize| -> [f64; 3] {
            let place = E::PARENT[corner].map(|sign| 0.5 * EDGE * sign);
            if corner == 6 { std::array::from_fn(|i| place[i] * [1.05, 0.98, 1.03][i]) } else { place }
        };
        let velocity = |[x, y, z]: [f64; 3]| {
            let bend = x * y / EDGE;
            let gradient = [0.5 * x + 0.3 * z, 0.5 * y - 0.2 * x, 0.2 * bend - z + 0.1 * y];
            gradient.map(|component| component * pace.rate())
        };
        let vector = |components: [f64; 3]| Vector3(components.map(R::splat));
        let elasticity = material.elasticity();
        let reference = array(|a| vector(corner(a)));
        let positions: [Vector3<f64>; NODES] = array(|a| Vector3(corner(a)));
        let lumped_mass = E::lumped_mass(&positions, elasticity.density());
        let mut element = Self {
            elasticity,
            element,
            history: ElementHistory::new(0.0),
            points: material.points::<R>(E::POINTS).of_packs(1),
            exchange: Exchange::new(),
            motion: ElementMotion {
                reference,
                position: reference,
                velocity: array(|a| vector(velocity(corner(a)))),
                corner_mass: R::splat(lumped_mass.into_iter().fold(f64::INFINITY, f64::min)),
            },
            step: ElementStep { bulk_viscosity: None, time_step: 0.0 },
        };
        element.step.time_step = 0.9 * element.advance().stable_time_step.lane(0);
        element
    }

    /// Moves the element by one step.
    pub fn advance(&mut self) -> ElementUpdate<R, NODES> {
        R::vectorize(Step(self))
    }

    /// Every number of the history.
    fn numbers(&self) -> Vec<R> {
        let mut numbers = Vec::new();
        self.points.for_each(0, &mut |number| numbers.push(number));
        self.history.for_each(|number| numbers.push(number));
        numbers
    }
}

struct Step<'a, E: Element<NODES>, R: Real, const NODES: usize>(&'a mut SingleElement<E, R, NODES>);

impl<E: Element<NODES>, R: Real, const NODES: usize> Kernel for Step<'_, E, R, NODES> {
    type Output = ElementUpdate<R, NODES>;

    #[inline(always)]
    fn run(self) -> ElementUpdate<R, NODES> {
        let single = self.0;
        for (position, velocity) in single.motion.position.iter_mut().zip(&single.motion.velocity) {
            *position = velocity.mul_add(R::splat(single.step.time_step), *position);
        }
        let points = PackPoints { points: &mut *single.points, pack: 0, exchange: &mut single.exchange };
        single.element.advance(&single.elasticity, points, &mut single.history, &single.motion, &single.step)
    }
}

/// The operations of a step of one element, those that move its corners included.
pub fn operations_of_step(material: &MaterialModel, formulation: Formulation, pace: Pace) -> Operations {
    formulation.visit(OperationsOf { material, pace })
}

struct OperationsOf<'a> {
    material: &'a MaterialModel,
    pace: Pace,
}

impl ElementVisitor for OperationsOf<'_> {
    type Output = Operations;

    fn visit<const NODES: usize, E: Element<NODES>>(self, element: E) -> Operations {
        let mut single = SingleElement::<E, Counted, NODES>::new(self.material, element, self.pace);
        for _ in 0..STEPS_BEFORE {
            single.advance();
        }
        operations(|| {
            let update = single.advance();
            let mut results = single.numbers();
            results.extend(update.internal_force.iter().flat_map(|force| force.0));
            results.extend([
                update.internal_energy,
                update.plastic_dissipation,
                update.viscous_energy,
                update.hourglass_energy,
                update.min_jacobian,
                update.stable_time_step,
            ]);
            results
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::taylor_bar::ELEMENTS;
    use crate::bench::taylor_bar::materials;
    use estar_element::hex8;

    /// Plastic strain of the points after the steps that lead to the state of interest, and after one more.
    fn strains(material: &MaterialModel, pace: Pace) -> [Vec<f64>; 2] {
        let mut hex = SingleElement::<_, f64, 8>::new(material, hex8::Formulation::FBar, pace);
        for _ in 0..STEPS_BEFORE {
            hex.advance();
        }
        // of each point T̃, ε̄ᵖ and the rotation
        let strains = |hex: &SingleElement<hex8::Formulation, f64, 8>| -> Vec<f64> {
            hex.numbers().chunks_exact(6 + 1 + 4).map(|point| point[6]).collect()
        };
        let before = strains(&hex);
        hex.advance();
        [before, strains(&hex)]
    }

    #[test]
    fn the_hex_is_elastic_at_one_pace_and_yields_at_every_point_at_the_other() {
        let (_, material) = materials().swap_remove(0);
        assert!(matches!(material, MaterialModel::EStar(_)), "the first material is E* in box-rate form");
        assert_eq!(strains(&material, Pace::Elastic)[1], [0.0; hex8::POINTS]);
        let [before, after] = strains(&material, Pace::Yielding);
        assert_eq!(before.len(), hex8::POINTS);
        assert!(
            before.iter().zip(&after).all(|(before, after)| after > before && *before > 0.0),
            "{before:?} {after:?}"
        );
    }

    #[test]
    fn an_element_step_has_more_operations_where_it_yields() {
        for (name, material) in materials() {
            for formulation in ELEMENTS {
                let elastic = operations_of_step(&material, formulation, Pace::Elastic);
                let yielding = operations_of_step(&material, formulation, Pace::Yielding);
                assert_eq!(elastic.flops() < yielding.flops(), name != "elastic", "{name}");
            }
        }
    }
}
