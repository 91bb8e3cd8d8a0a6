//! Constraints on nodes: held or driven degrees of freedom.

use crate::error::{ConstraintSource, ModelError};
use crate::model::{Direction, Model, Prescribed};

/// Nodes without a constraint have this place in [`Constraints::of_node`].
const FREE: u32 = u32::MAX;

/// All held and driven degrees of freedom.
#[derive(Clone, Debug)]
pub(crate) struct Constraints {
    /// Place of each node in `motions`, or [`FREE`].
    of_node: Vec<u32>,
    /// What drives each direction of a constrained node.
    motions: Vec<[Motion; 3]>,
    prescribed: Vec<Prescribed>,
    /// Displacement of each prescribed curve at the end of the step.
    displacements: Vec<f64>,
}

/// What drives one degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Motion {
    Free,
    Held,
    /// Position in `Constraints::prescribed`.
    Driven(u32),
}

impl Constraints {
    /// The constraints of a model.
    ///
    /// # Errors
    /// One degree of freedom that two entries drive differently.
    pub fn new(model: &Model, node_count: usize) -> Result<Self, ModelError> {
        let prescribed = model.prescribed.clone();
        let displacements = vec![0.0; prescribed.len()];
        let mut constraints = Self { of_node: vec![FREE; node_count], motions: Vec::new(), prescribed, displacements };
        let mut sources: Vec<[Option<ConstraintSource>; 3]> = Vec::new();
        let fixes = model.fixes.iter().enumerate().flat_map(|(position, fix)| {
            fix.directions.iter().map(move |&direction| (&fix.nodes, direction, ConstraintSource::Fix(position)))
        });
        let driven = model.prescribed.iter().enumerate().map(|(position, prescribed)| {
            (&prescribed.nodes, prescribed.direction, ConstraintSource::Prescribed(position))
        });
        for (nodes, direction, source) in fixes.chain(driven) {
            for &node in nodes {
                constraints.add(node, direction, source, &mut sources)?;
            }
        }
        Ok(constraints)
    }

    fn add(
        &mut self,
        node: u32,
        direction: Direction,
        source: ConstraintSource,
        sources: &mut Vec<[Option<ConstraintSource>; 3]>,
    ) -> Result<(), ModelError> {
        let place = &mut self.of_node[node as usize];
        if *place == FREE {
            *place = self.motions.len() as u32;
            self.motions.push([Motion::Free; 3]);
            sources.push([None; 3]);
        }
        let (place, i) = (*place as usize, direction.index());
        if let Some(first) = sources[place][i] {
            return if self.same_motion(first, source) {
                Ok(())
            } else {
                Err(ModelError::ConflictingConstraints { node, direction, first, second: source })
            };
        }
        sources[place][i] = Some(source);
        self.motions[place][i] = match source {
            ConstraintSource::Fix(_) => Motion::Held,
            ConstraintSource::Prescribed(position) => Motion::Driven(position as u32),
        };
        Ok(())
    }

    fn same_motion(&self, first: ConstraintSource, second: ConstraintSource) -> bool {
        match (first, second) {
            (ConstraintSource::Fix(_), ConstraintSource::Fix(_)) => true,
            (ConstraintSource::Prescribed(a), ConstraintSource::Prescribed(b)) => {
                let (a, b) = (&self.prescribed[a], &self.prescribed[b]);
                a.quantity == b.quantity && a.curve == b.curve
            }
            _ => false,
        }
    }

    /// Looks up the curves at the end of a step.
    pub fn prepare(&mut self, time_new: f64) {
        for (displacement, prescribed) in self.displacements.iter_mut().zip(&self.prescribed) {
            *displacement = prescribed.quantity.displacement(&prescribed.curve, time_new);
        }
    }

    /// Whether any direction of the node is held or driven.
    #[inline]
    pub fn constrain(&self, node: usize) -> bool {
        self.of_node[node] != FREE
    }

    /// The directions of a node that are neither held nor driven.
    #[inline]
    pub fn free_directions(&self, node: usize) -> [bool; 3] {
        match self.of_node[node] {
            FREE => [true; 3],
            place => self.motions[place as usize].map(|motion| motion == Motion::Free),
        }
    }

    /// The velocity that meets the constraints of a node: driven directions reach their displacement at the end of the
    /// step.
    #[inline]
    pub fn velocity(&self, node: usize, free: [f64; 3], displacement: &[f64; 3], time_step: f64) -> [f64; 3] {
        let place = self.of_node[node];
        if place == FREE {
            return free;
        }
        let motions = &self.motions[place as usize];
        std::array::from_fn(|i| match motions[i] {
            Motion::Free => free[i],
            Motion::Held => 0.0,
            // v_{n+½} = (u(t_{n+1}) − u_n)/Δt
            Motion::Driven(position) => (self.displacements[position as usize] - displacement[i]) / time_step,
        })
    }
}

#[inline]
pub(crate) fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
