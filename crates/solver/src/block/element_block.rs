//! What a simulation asks of a block of elements.

use super::averages_task::Task;
use super::report::{BlockReport, Extreme};
use crate::model::Formulation;
use crate::patch::Patches;
use crate::patch_rows::NodalMotion;
use estar_element::element::ElementStep;
use estar_material::MaterialModel;
use estar_material::points::PointExtremes;
use estar_mesh::Mesh;
use estar_tensor::array;

/// A block of elements.
pub(crate) struct Block {
    pub elements: Box<dyn ElementBlock>,
    /// Smallest det F of its elements.
    pub min_jacobian: Extreme,
    /// Stress power of its elements so far, of those that are deleted too, J.
    pub internal_energy: f64,
    /// Work against their hourglass control, J.
    pub hourglass_energy: f64,
    /// Its elements that have been deleted.
    pub deleted_count: u64,
}

/// What a step is held against.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepLimits {
    /// Of a block that deletes elements, those are whose stable time step is below this, s.
    pub least_stable_time_step: f64,
    /// The largest eigenvalue of the assembled mesh when it was estimated, 1/s².
    pub eigenvalue: f64,
}

/// What a block does besides moving its elements.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Behaviour {
    /// It deletes elements that turn inside out.
    pub deletes: bool,
    /// It watches how the frequencies of its elements grow.
    pub watches: bool,
}

/// A block of elements, whatever their material and number of lanes. Called once a step, not once an element.
pub(crate) trait ElementBlock: Send + Sync {
    /// Elements of the mesh, in the order of the block.
    fn members(&self) -> &[u32];

    /// The nodes of the block.
    fn patches(&self) -> &Patches;

    /// Moves every element to t_{n+1} and writes the forces −∫ T ∇N_a dV on the nodes of each patch to its rows; where elements
    /// share their volume change, those of dev T.
    fn advance(
        &mut self,
        motion: NodalMotion<'_>,
        step: &ElementStep,
        limits: &StepLimits,
        patch_forces: &mut [[f64; 4]],
    ) -> BlockReport;

    /// Whether its elements share their volume change with their neighbours.
    fn shares_volume(&self) -> bool;

    /// Does a part of the averaging with every element that shares its volume change: `averages` are of the nodes of the mesh,
    /// `rows` of the nodes of each patch.
    fn visit_neighbourhoods(
        &mut self,
        task: Task,
        motion: NodalMotion<'_>,
        averages: &[[f64; 3]],
        rows: &mut [[f64; 4]],
    );

    /// Finds what the linear forces need besides the geometry, at t_n with the damping of the step.
    fn find_tangents(&mut self, motion: NodalMotion<'_>, step: &ElementStep);

    /// Writes the linear forces −(K + 2C/Δt) z on the nodes of each patch to its rows, z for the velocity of the motion.
    fn apply_tangents(&self, motion: NodalMotion<'_>, patch_forces: &mut [[f64; 4]]);

    /// Takes the frequencies of the elements as of the last step for those that their growth is measured from.
    fn watch(&mut self);

    /// Whether the elements damp of themselves.
    fn is_damped(&self) -> bool;

    /// Bytes of the block's own data, rows of forces included, that [`ElementBlock::advance`] reads and writes.
    fn bytes_per_step(&self) -> usize;

    /// Whether the linear forces of its elements are known.
    fn has_linear_forces(&self) -> bool;

    /// Makes an element heavier by a factor, as far as its stable time step goes.
    fn scale_mass(&mut self, element: usize, factor: f64);

    /// Whether an element has been deleted.
    fn is_deleted(&self, element: usize) -> bool;

    /// Stable time step of an element on its last geometry, s; infinite of one that has been deleted.
    fn stable_time_step(&self, element: usize) -> f64;

    /// The share of the plastic dissipation that heats the material, where it has a temperature.
    fn heat_share(&self) -> Option<f64>;

    /// Extremes over the quadrature points.
    fn extremes(&self) -> PointExtremes;

    /// Writes the means over the points of each element of a patch to their places in the fields; the place of
    /// the first is at their beginning.
    fn write_means(&self, patch: usize, means: ElementMeans<'_>);

    /// Calls `visit` with every number of every history, in an order that does not depend on the lanes.
    fn for_each_number(&self, visit: &mut dyn FnMut(f64));

    /// Takes the histories whose numbers `next` gives in that order.
    fn restore(&mut self, next: &mut dyn FnMut() -> f64);
}

/// The elements of a block, not yet packed.
pub(super) struct Elements<'a> {
    pub members: Vec<u32>,
    pub formulation: Formulation,
    pub material: MaterialModel,
    pub mesh: &'a Mesh,
    pub corner_mass: Vec<f64>,
    pub behaviour: Behaviour,
}

/// The node at each corner of an element whose shape the formulation is made for.
pub(crate) fn corner_nodes<const NODES: usize>(formulation: Formulation, mesh: &Mesh, element: u32) -> [u32; NODES] {
    let (elements, element) = (mesh.elements(), element as usize);
    let nodes = elements.nodes(element);
    let places = formulation.places(elements.shape(element)).unwrap_or_default();
    array(|corner| nodes[places[corner]])
}

/// Fields over all elements that are to be filled with means over the quadrature points; none is a field not wanted.
#[derive(Debug, Default)]
pub struct ElementMeans<'a> {
    /// Cauchy stress with the components xx, yy, zz, xy, yz, xz, Pa; in four-node tets with the mean stress of the neighbourhood,
    /// which acts.
    pub cauchy_stress: Option<&'a mut [[f64; 6]]>,
    /// Equivalent plastic strain ε̄ᵖ.
    pub equivalent_plastic_strain: Option<&'a mut [f64]>,
    /// Temperature, K; not a number in an element whose material has none.
    pub temperature: Option<&'a mut [f64]>,
    /// Volume ratio of the neighbourhood of each four-node tet, which is what its material sees; nothing is written for other
    /// elements, see [`volume_ratio`](crate::fields::volume_ratio).
    pub volume_ratio: Option<&'a mut [f64]>,
}
