//! A simulation: the state of a body in motion, made from a model and a mesh.

use crate::assembly::{CHUNK, RowLists};
use crate::block::{Behaviour, Block, BlockReport, Extreme, NodalAverages, block, corner_nodes};
use crate::constraints::Constraints;
use crate::energy::{CentredWork, Energies};
use crate::error::ModelError;
use crate::global_time_step::GlobalTimeStep;
use crate::kick::NodeSums;
use crate::loads::NodalLoad;
use crate::model::{
    Direction, Formulation, LoadKind, MassScaling, Model, OnInversion, Part, RigidWall, TimeSettings, TimeStep,
    WallShape,
};
use crate::rigid_wall::MovingWall;
use crate::wall_contact::Behind;
use arrayvec::ArrayVec;
use estar_element::element::{Element, ElementVisitor};
use estar_material::MaterialModel;
use estar_material::points::PointExtremes;
use estar_mesh::{Face, MOST_NODES, Mesh};
use estar_tensor::{LaneLevel, Vector3};
use rayon::prelude::*;

/// Where elements are deleted, those are whose stable time step is below this share of the first of the mesh.
const DELETED_BELOW: f64 = 0.01;

/// Elements whose masses are held at a time.
const MASS_CHUNK: usize = 1 << 16;

/// The state of a body at a time t_n, with the velocities of the half step that comes next.
///
/// Two simulations of one model on one mesh have the same bits, whatever the number of threads and the lane level.
/// [`Simulation::advance`] is to be called inside of a rayon thread pool (`pool.install`); then a step allocates
/// nothing.
pub struct Simulation {
    pub(crate) settings: TimeSettings,
    /// Stable time step, s, below which the run stops or elements are deleted.
    pub(crate) least_stable_time_step: f64,
    pub(crate) step: u64,
    pub(crate) time: f64,
    /// Δt_{n−½}.
    pub(crate) time_step: f64,
    /// Δt_{n+½}.
    pub(crate) next_time_step: f64,
    pub(crate) step_is_last: bool,
    pub(crate) nodes: Nodes,
    pub(crate) blocks: Vec<Block>,
    /// Of each material with elements that share their volume change.
    pub(crate) averages: Vec<NodalAverages>,
    pub(crate) patch_forces: Vec<[f64; 4]>,
    pub(crate) row_lists: RowLists,
    pub(crate) loads: Vec<NodalLoad>,
    pub(crate) load_power: Vec<f64>,
    /// One vector a node where there are loads, else empty.
    pub(crate) external_force: Vec<[f64; 3]>,
    pub(crate) constraints: Constraints,
    pub(crate) walls: Vec<MovingWall>,
    pub(crate) node_sums: Vec<NodeSums>,
    /// The node that constraints take farthest behind a wall by t_{n+1}, if there is one.
    pub(crate) behind: Option<(Behind, usize)>,
    /// How far behind a wall a node may lie, m: rounding.
    pub(crate) wall_tolerance: f64,
    /// Impulses of the walls on each chunk of nodes, N s.
    pub(crate) wall_impulses: Vec<[f64; 3]>,
    /// The share of added mass in the mass of each node; empty where none is added.
    pub(crate) added_shares: Vec<f64>,
    pub(crate) added_mass: Vec<f64>,
    pub(crate) elements: BlockReport,
    /// With [`TimeStep::Power`].
    pub(crate) global_time_step: Option<GlobalTimeStep>,
    pub(crate) deleted_count: u64,
    pub(crate) energies: Energies,
    pub(crate) constraint_work: CentredWork,
    pub(crate) contact_work: CentredWork,
    pub(crate) friction_work: CentredWork,
    pub(crate) damping_work: CentredWork,
    pub(crate) integration: CentredWork,
    pub(crate) mesh: Mesh,
}

/// Fields over the nodes.
pub(crate) struct Nodes {
    /// u_n, m.
    pub displacement: Vec<[f64; 3]>,
    /// v_{n+½}, m/s.
    pub velocity: Vec<[f64; 3]>,
    /// a_n, with the impulses of constraints and walls, m/s².
    pub acceleration: Vec<[f64; 3]>,
    /// Force of held and driven directions at t_n, N; zero at free nodes.
    pub reaction: Vec<[f64; 3]>,
    /// Lumped mass, kg.
    pub mass: Vec<f64>,
}

/// Extremes over the elements at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extremes {
    /// Largest equivalent plastic strain of a quadrature point.
    pub max_equivalent_plastic_strain: f64,
    /// Highest temperature of a quadrature point, K, where a material has one.
    pub max_temperature: Option<f64>,
    /// Smallest det F of a quadrature point; infinite where all elements are deleted.
    pub min_jacobian: f64,
    /// Stable time step of the mesh, s, without the safety factor; infinite where all elements are deleted.
    pub stable_time_step: f64,
    /// The element with the smallest of its own, which sets it unless it is that of the assembled mesh.
    pub controlling_element: u32,
}

impl Simulation {
    /// The simulation of `model` on `mesh` at time 0.
    ///
    /// # Errors
    /// Everything that [`ModelError`] lists.
    pub fn new(mesh: &Mesh, mut model: Model, level: LaneLevel) -> Result<Self, ModelError> {
        check_settings(&model.settings)?;
        check_indices(mesh, &model)?;
        let reference = mesh.coordinates();
        let node_count = reference.len();
        check_shapes(mesh, &model.parts)?;
        check_owners(mesh.element_count(), &model.parts)?;
        check_directions(&model)?;
        check_walls(&model.walls, reference)?;

        let mut mass = vec![0.0; node_count];
        let mut blocks = Vec::new();
        let mut elastic_scale = 0.0;
        let scaling = model.settings.mass_scaling;
        let factor = scaling.map_or(1.0, |scaling| scaling.factor);
        let (mut makes, mut masses, mut added_mass) = (Vec::new(), Vec::new(), Vec::new());
        let materials: Vec<MaterialModel> = model.parts.iter().map(|part| part.material.clone()).collect();
        for mut part in std::mem::take(&mut model.parts) {
            // in the order of the mesh neighbours meet in the cache, and a chunk owns a piece of every field
            part.elements.sort_unstable();
            let mut part_mass = add_mass(&part, mesh, &mut mass)?;
            part_mass.smallest_corners.iter_mut().for_each(|mass| *mass *= factor);
            makes.push((part.element, part.material.elasticity().density() * factor));
            masses.push(part_mass.total);
            added_mass.push(part_mass.total * (factor - 1.0));
            let elasticity = part.material.elasticity();
            elastic_scale += part_mass.total / elasticity.density() * elasticity.p_wave_modulus();
            let behaviour = Behaviour {
                deletes: model.settings.on_inversion == OnInversion::Delete,
                watches: model.settings.time_step != TimeStep::Element,
            };
            let elements = block(part, mesh, part_mass.smallest_corners, behaviour, level);
            blocks.push(Block {
                elements,
                min_jacobian: Extreme::NONE,
                internal_energy: 0.0,
                hourglass_energy: 0.0,
                deleted_count: 0,
            });
        }
        if model.settings.time_step != TimeStep::Element
            && let Some(part) = blocks.iter().position(|block| !block.elements.has_linear_forces())
        {
            return Err(ModelError::NoGlobalTimeStep { part });
        }
        let massless: Vec<usize> = (0..node_count).filter(|&node| mass[node] <= 0.0).collect();
        if let Some(&first) = massless.first() {
            return Err(ModelError::NodeWithoutMass { count: massless.len(), first: first as u32 });
        }

        let row_count = blocks.iter().map(|block| block.elements.patches().row_count()).sum();
        let rows = || {
            let mut before = 0;
            blocks.iter().flat_map(move |block| {
                let patches = block.elements.patches();
                let first = before;
                before += patches.row_count();
                patches.rows().map(move |(node, row)| (node, first + row))
            })
        };
        let row_lists = RowLists::new(node_count, rows);

        let loads: Vec<NodalLoad> =
            model.loads.iter().map(|load| NodalLoad::new(&load.kind, reference, &mass)).collect();
        // added mass has no weight: loads know nothing of it
        let own_mass = if scaling.is_some() { mass.clone() } else { Vec::new() };
        mass.iter_mut().for_each(|mass| *mass *= factor);
        let chunk_count = node_count.div_ceil(CHUNK);
        let mut simulation = Self {
            settings: model.settings,
            least_stable_time_step: 0.0,
            step: 0,
            time: 0.0,
            time_step: 0.0,
            next_time_step: 0.0,
            step_is_last: false,
            patch_forces: vec![[0.0; 4]; row_count],
            row_lists,
            load_power: vec![0.0; loads.len()],
            external_force: vec![[0.0; 3]; if loads.is_empty() { 0 } else { node_count }],
            constraints: Constraints::new(&model, node_count)?,
            wall_impulses: vec![[0.0; 3]; chunk_count * model.walls.len().max(1)],
            walls: std::mem::take(&mut model.walls).into_iter().map(MovingWall::new).collect(),
            added_shares: Vec::new(),
            added_mass,
            node_sums: vec![NodeSums::default(); chunk_count],
            behind: None,
            wall_tolerance: wall_tolerance(reference),
            elements: BlockReport::EMPTY,
            global_time_step: match model.settings.time_step {
                TimeStep::Element => None,
                TimeStep::Power { interval } => Some(GlobalTimeStep::new(interval, node_count)),
            },
            deleted_count: 0,
            energies: Energies::default(),
            constraint_work: CentredWork::default(),
            contact_work: CentredWork::default(),
            friction_work: CentredWork::default(),
            damping_work: CentredWork::default(),
            integration: CentredWork::default(),
            mesh: mesh.clone(),
            loads,
            averages: NodalAverages::of_materials(&materials, &blocks, node_count),
            blocks,
            nodes: Nodes {
                displacement: vec![[0.0; 3]; node_count],
                velocity: initial_velocity(&model, reference),
                acceleration: vec![[0.0; 3]; node_count],
                reaction: vec![[0.0; 3]; node_count],
                mass,
            },
        };
        simulation.update_elements(0.0);
        if let Some(element) = simulation.elements.not_finite {
            return Err(ModelError::NotFinite { element });
        }
        if let Some(scaling) = &scaling {
            simulation.scale_mass(scaling, &makes, &masses)?;
            let shares = own_mass.iter().zip(&simulation.nodes.mass).map(|(own, mass)| 1.0 - own / mass);
            simulation.added_shares = shares.collect();
        }
        let nodes = &simulation.nodes;
        let of_node = |(mass, v): (&f64, &[f64; 3])| 0.5 * mass * v.iter().map(|v| v * v).sum::<f64>();
        let kinetic = || nodes.mass.iter().zip(&nodes.velocity).map(of_node);
        let mut energies =
            Energies::new(kinetic().sum(), elastic_scale, simulation.loads.len(), simulation.walls.len());
        energies.mass_scaling = kinetic().zip(&simulation.added_shares).map(|(kinetic, share)| kinetic * share).sum();
        simulation.energies = energies.clone();
        let settings = &simulation.settings;
        simulation.least_stable_time_step = match settings.min_time_step {
            Some(least) => least / settings.safety_factor,
            None if simulation.deletes() => DELETED_BELOW * simulation.elements.stable_time_step.value,
            None => 0.0,
        };
        if simulation.global_time_step.is_some() {
            simulation.begin_global_time_step();
            simulation.update_elements(0.0);
        }
        simulation.choose_next_time_step();
        simulation.update_loads();
        simulation.kick();
        // what walls and constraints change at time 0 they change after it has been looked at
        simulation.energies = energies;
        Ok(simulation)
    }

    /// Of each part the stress power so far, also of elements that are deleted, and the work against hourglass control, J.
    pub fn part_energies(&self) -> impl Iterator<Item = [f64; 2]> {
        self.blocks.iter().map(|block| [block.internal_energy, block.hourglass_energy])
    }

    /// Time t_n, s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Steps so far, n.
    pub fn step(&self) -> u64 {
        self.step
    }

    /// The smallest stable time step of an element at t_n, s, without the safety factor.
    pub fn element_time_step(&self) -> f64 {
        self.elements.stable_time_step.value
    }

    /// The step that led here, Δt_{n−½}; before the first step the one that comes. In s.
    pub fn time_step(&self) -> f64 {
        if self.step == 0 { self.next_time_step } else { self.time_step }
    }

    /// Whether the end has been reached.
    pub fn is_finished(&self) -> bool {
        self.time >= self.settings.end
    }

    /// The end of the simulation, s.
    pub fn end_time(&self) -> f64 {
        self.settings.end
    }

    /// The energy ledger of t_n.
    pub fn energies(&self) -> &Energies {
        &self.energies
    }

    /// Linear momentum Σ m v, kg m/s.
    pub fn momentum(&self) -> [f64; 3] {
        let mass = &self.nodes.mass;
        let of_node = |node: usize| self.velocity(node).map(|v| mass[node] * v);
        (0..mass.len()).map(of_node).fold([0.0; 3], |sum, p| [sum[0] + p[0], sum[1] + p[1], sum[2] + p[2]])
    }

    /// Angular momentum Σ x × m v about the origin, kg m²/s.
    pub fn angular_momentum(&self) -> [f64; 3] {
        let nodes = &self.nodes;
        let mut sum = [0.0; 3];
        for node in 0..nodes.mass.len() {
            let x: [f64; 3] = std::array::from_fn(|i| self.reference()[node][i] + nodes.displacement[node][i]);
            let p = self.velocity(node).map(|v| v * nodes.mass[node]);
            let moment = cross(&x, &p);
            sum = std::array::from_fn(|i| sum[i] + moment[i]);
        }
        sum
    }

    /// Extremes over the elements; looks at every quadrature point.
    pub fn extremes(&self) -> Extremes {
        let extremes = self.blocks.iter().map(|block| block.elements.extremes());
        let largest = extremes.fold(PointExtremes::NONE, PointExtremes::and);
        Extremes {
            max_equivalent_plastic_strain: largest.plastic_strain,
            max_temperature: Some(largest.temperature).filter(|temperature| *temperature > f64::NEG_INFINITY),
            min_jacobian: self.elements.min_jacobian.value,
            stable_time_step: self.stable_time_step(),
            controlling_element: self.elements.stable_time_step.element,
        }
    }

    /// Smallest det F of the elements of each part of the model and the one that has it, as of the last step. 1 is the start.
    pub fn min_jacobians(&self) -> impl Iterator<Item = (f64, u32)> {
        self.blocks.iter().map(|block| (block.min_jacobian.value, block.min_jacobian.element))
    }

    /// Whether elements that turn inside out are deleted.
    pub fn deletes(&self) -> bool {
        self.settings.on_inversion == OnInversion::Delete
    }

    /// How many elements have been deleted.
    pub fn deleted_count(&self) -> u64 {
        self.deleted_count
    }

    /// How many elements of each part have been deleted.
    pub fn deleted_counts(&self) -> impl Iterator<Item = u64> {
        self.blocks.iter().map(|block| block.deleted_count)
    }

    /// Whether each element has been deleted.
    pub fn deleted(&self) -> Vec<bool> {
        let mut deleted = vec![false; self.element_count()];
        for block in &self.blocks {
            for (place, &element) in block.elements.members().iter().enumerate() {
                deleted[element as usize] = block.elements.is_deleted(place);
            }
        }
        deleted
    }

    /// Stable time step of every element, s, without the safety factor and without the effect of bulk viscosity; infinite of
    /// deleted ones.
    pub fn stable_time_steps(&self) -> Vec<f64> {
        let mut steps = vec![0.0; self.element_count()];
        for block in &self.blocks {
            for (place, &element) in block.elements.members().iter().enumerate() {
                steps[element as usize] = block.elements.stable_time_step(place);
            }
        }
        steps
    }

    /// Coordinates at time 0, m.
    pub fn reference(&self) -> &[[f64; 3]] {
        self.mesh.coordinates()
    }

    /// Displacement of every node at t_n, m.
    pub fn displacement(&self) -> &[[f64; 3]] {
        &self.nodes.displacement
    }

    /// Acceleration of every node at t_n, m/s².
    pub fn acceleration(&self) -> &[[f64; 3]] {
        &self.nodes.acceleration
    }

    /// Lumped mass of every node, kg.
    pub fn mass(&self) -> &[f64] {
        &self.nodes.mass
    }

    /// Sum of the forces that hold or drive `nodes` in `direction`, on the body, N.
    pub fn reaction(&self, nodes: &[u32], direction: Direction) -> f64 {
        nodes.iter().map(|&node| self.nodes.reaction[node as usize][direction.index()]).sum()
    }

    /// Force of a rigid wall on the body, N; walls are counted as in the model.
    pub fn wall_force(&self, wall: usize) -> [f64; 3] {
        self.walls[wall].force
    }

    /// Number of elements.
    pub fn element_count(&self) -> usize {
        self.mesh.element_count()
    }

    /// Velocity of a node at t_n, v_n = v_{n+½} − ½ Δt_{n+½} a_n, m/s.
    pub fn velocity(&self, node: usize) -> [f64; 3] {
        let (velocity, acceleration) = (&self.nodes.velocity[node], &self.nodes.acceleration[node]);
        std::array::from_fn(|i| velocity[i] - 0.5 * self.next_time_step * acceleration[i])
    }
}

fn cross(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Mass of a part.
struct PartMass {
    /// Smallest corner mass of each of its elements, kg.
    smallest_corners: Vec<f64>,
    /// All of it, kg.
    total: f64,
}

/// Adds the lumped mass of a part to its nodes.
fn add_mass(part: &Part, mesh: &Mesh, mass: &mut [f64]) -> Result<PartMass, ModelError> {
    let density = part.material.elasticity().density();
    let mut part_mass = PartMass { smallest_corners: Vec::with_capacity(part.elements.len()), total: 0.0 };
    // threads find the masses of elements; the sums, and the first fault, are those of the order of the elements
    let mut corner_masses = Vec::new();
    for elements in part.elements.chunks(MASS_CHUNK) {
        let formulation = part.element;
        let corner_mass = |&element: &u32| corner_masses_of(formulation, element, mesh, density);
        elements.par_iter().map(corner_mass).collect_into_vec(&mut corner_masses);
        for corner_mass in corner_masses.drain(..) {
            let corner_mass: CornerMasses = corner_mass?;
            for &(node, corner_mass) in &corner_mass {
                mass[node as usize] += corner_mass;
            }
            part_mass.total += corner_mass.iter().map(|(_, mass)| mass).sum::<f64>();
            let smallest = corner_mass.iter().map(|(_, mass)| *mass).fold(f64::INFINITY, f64::min);
            part_mass.smallest_corners.push(smallest);
        }
    }
    Ok(part_mass)
}

/// The node of each corner of an element and the lumped mass there, kg.
pub(crate) type CornerMasses = ArrayVec<(u32, f64), MOST_NODES>;

/// Lumped mass of the corners of an element.
pub(crate) fn corner_masses_of(
    formulation: Formulation,
    element: u32,
    mesh: &Mesh,
    density: f64,
) -> Result<CornerMasses, ModelError> {
    formulation.visit(CornerMass { formulation, element, mesh, density })
}

/// An element whose corners have a mass.
struct CornerMass<'a> {
    formulation: Formulation,
    element: u32,
    mesh: &'a Mesh,
    density: f64,
}

impl ElementVisitor for CornerMass<'_> {
    type Output = Result<CornerMasses, ModelError>;

    fn visit<const NODES: usize, E: Element<NODES>>(self, _: E) -> Self::Output {
        let Self { formulation, element, mesh, density } = self;
        let nodes: [u32; NODES] = corner_nodes(formulation, mesh, element);
        let positions = nodes.map(|node| Vector3(mesh.coordinates()[node as usize]));
        let positive = |what, value: f64| {
            let is_good = value.is_finite() && value > 0.0;
            if is_good { Ok(()) } else { Err(ModelError::BadElement { element, what, value }) }
        };
        positive("Jacobian at the quadrature points and the centre", E::smallest_jacobian(&positions))?;
        let corner_mass = E::lumped_mass(&positions, density);
        corner_mass.iter().try_for_each(|&mass| positive("corner mass", mass))?;
        Ok(nodes.into_iter().zip(corner_mass).collect())
    }
}

/// Every element is of a shape that the formulation of its part is made for.
fn check_shapes(mesh: &Mesh, parts: &[Part]) -> Result<(), ModelError> {
    for (position, part) in parts.iter().enumerate() {
        for &element in &part.elements {
            let shape = mesh.elements().shape(element as usize);
            if part.element.places(shape).is_none() {
                return Err(ModelError::WrongShape { part: position, element, shape });
            }
        }
    }
    Ok(())
}

/// Every element belongs to one part.
fn check_owners(element_count: usize, parts: &[Part]) -> Result<(), ModelError> {
    const NOBODY: u32 = u32::MAX;
    let mut owners = vec![NOBODY; element_count];
    for (second, part) in parts.iter().enumerate() {
        for &element in &part.elements {
            match std::mem::replace(&mut owners[element as usize], second as u32) {
                NOBODY => {}
                first => return Err(ModelError::ElementInTwoParts { element, first: first as usize, second }),
            }
        }
    }
    let orphans = owners.iter().filter(|&&owner| owner == NOBODY);
    match owners.iter().position(|&owner| owner == NOBODY) {
        Some(first) => Err(ModelError::ElementWithoutPart { count: orphans.count(), first: first as u32 }),
        None => Ok(()),
    }
}

fn initial_velocity(model: &Model, reference: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let mut velocity = vec![[0.0; 3]; reference.len()];
    for entry in &model.initial_velocities {
        for &node in &entry.nodes {
            let mut v = entry.translation;
            if let Some(spin) = entry.spin {
                // v = ω × (x − c)
                let arm = std::array::from_fn(|i| reference[node as usize][i] - spin.centre[i]);
                let turning = cross(&spin.rate, &arm);
                v = std::array::from_fn(|i| v[i] + turning[i]);
            }
            velocity[node as usize] = v;
        }
    }
    velocity
}

fn check_settings(settings: &TimeSettings) -> Result<(), ModelError> {
    let check = |setting, value: f64, allowed: bool, bound| {
        if value.is_finite() && allowed { Ok(()) } else { Err(ModelError::Setting { setting, value, bound }) }
    };
    check("end", settings.end, settings.end > 0.0, "it must be greater than 0")?;
    let factor = settings.safety_factor;
    check("safety_factor", factor, 0.0 < factor && factor <= 1.0, "it must lie in (0, 1]")?;
    if let Some(viscosity) = settings.bulk_viscosity {
        check("linear", viscosity.linear, viscosity.linear >= 0.0, "it must be 0 or greater")?;
        check("quadratic", viscosity.quadratic, viscosity.quadratic >= 0.0, "it must be 0 or greater")?;
    }
    let limit = settings.energy_error_limit;
    check("energy_error_limit", limit, limit > 0.0, "it must be greater than 0")?;
    if let Some(MassScaling { factor, target_time_step, limit, kinetic_limit }) = settings.mass_scaling {
        check("factor", factor, factor >= 1.0, "it must be 1 or greater")?;
        check("target_time_step", target_time_step, target_time_step >= 0.0, "it must be 0 or greater")?;
        check("limit", limit, limit >= 0.0, "it must be 0 or greater")?;
        check("kinetic_limit", kinetic_limit, kinetic_limit > 0.0, "it must be greater than 0")?;
    }
    let damping = settings.mass_damping;
    check("mass_damping", damping, damping >= 0.0, "it must be 0 or greater")?;
    let least = settings.min_time_step.unwrap_or(0.0);
    check("min_time_step", least, least >= 0.0, "it must be 0 or greater")
}

/// Every index of the model is one of the mesh.
fn check_indices(mesh: &Mesh, model: &Model) -> Result<(), ModelError> {
    let check = |what, indices: &mut dyn Iterator<Item = u32>, count: usize| {
        for index in indices {
            if index as usize >= count {
                return Err(ModelError::OutOfRange { what, index, count });
            }
        }
        Ok(())
    };
    let (nodes, elements) = (mesh.node_count(), mesh.element_count());
    for (position, part) in model.parts.iter().enumerate() {
        if part.elements.is_empty() {
            return Err(ModelError::EmptyPart { part: position });
        }
        check("a part", &mut part.elements.iter().copied(), elements)?;
    }
    for fix in &model.fixes {
        check("a fix", &mut fix.nodes.iter().copied(), nodes)?;
    }
    for prescribed in &model.prescribed {
        check("a prescribed motion", &mut prescribed.nodes.iter().copied(), nodes)?;
    }
    for velocity in &model.initial_velocities {
        check("an initial velocity", &mut velocity.nodes.iter().copied(), nodes)?;
    }
    for load in &model.loads {
        if let LoadKind::Pressure { faces, .. } | LoadKind::Traction { faces, .. } = &load.kind {
            check("a load", &mut faces.iter().flat_map(Face::nodes).copied(), nodes)?;
        }
    }
    Ok(())
}

fn check_directions(model: &Model) -> Result<(), ModelError> {
    let is_unit = |vector: &[f64; 3]| (vector.iter().map(|c| c * c).sum::<f64>() - 1.0).abs() < 1e-9;
    for load in &model.loads {
        if let LoadKind::Traction { direction, .. } = &load.kind
            && !is_unit(direction)
        {
            return Err(ModelError::NotUnit { what: "direction of a traction" });
        }
    }
    for wall in &model.walls {
        let (unit, what) = match &wall.shape {
            WallShape::Plane { normal, .. } => (Some(normal), "normal of a rigid wall"),
            WallShape::Cylinder { axis, .. } => (Some(axis), "axis of a rigid cylinder"),
            WallShape::Sphere { .. } => (None, "sphere"),
        };
        if unit.is_some_and(|unit| !is_unit(unit)) {
            return Err(ModelError::NotUnit { what });
        }
        if wall.motion.as_ref().is_some_and(|motion| !is_unit(&motion.direction)) {
            return Err(ModelError::NotUnit { what: "direction of a rigid wall's motion" });
        }
        if let WallShape::Cylinder { radius, .. } | WallShape::Sphere { radius, .. } = wall.shape
            && !(radius.is_finite() && radius > 0.0)
        {
            return Err(ModelError::Setting { setting: "radius", value: radius, bound: "it must be greater than 0" });
        }
        if wall.friction.is_nan() || wall.friction < 0.0 {
            let (setting, bound) = ("friction", "it must be 0 or greater");
            return Err(ModelError::Setting { setting, value: wall.friction, bound });
        }
    }
    Ok(())
}

/// How far behind a wall a node of a body may lie by rounding, m: 10⁻⁹ of the largest coordinate.
fn wall_tolerance(reference: &[[f64; 3]]) -> f64 {
    1e-9 * reference.iter().flatten().fold(0.0_f64, |size, coordinate| size.max(coordinate.abs()))
}

/// No node begins behind a wall by more than rounding.
fn check_walls(walls: &[RigidWall], reference: &[[f64; 3]]) -> Result<(), ModelError> {
    let tolerance = wall_tolerance(reference);
    for (wall, tool) in walls.iter().enumerate() {
        let behind = |position: &[f64; 3]| tool.gap(position, 0.0) < -tolerance;
        let count = reference.iter().filter(|position| behind(position)).count();
        let gaps = reference.iter().map(|position| tool.gap(position, 0.0)).enumerate();
        if let Some((node, gap)) = gaps.min_by(|a, b| a.1.total_cmp(&b.1))
            && count > 0
        {
            return Err(ModelError::NodeBehindWall { wall, count, node: node as u32, depth: -gap });
        }
    }
    Ok(())
}
