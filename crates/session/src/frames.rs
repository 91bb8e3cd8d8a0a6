//! Frames, written by a thread of their own so that output does not stop the loop.
//!
//! The loop copies what only it has: displacements, velocities, means over the points of the elements, and volume ratios where
//! elements share them. What follows from these (places, von Mises stress, pressure, volume ratio elsewhere) the writer works out
//! number by number.
//!
//! A frame's numbers are in a buffer that goes to and fro. When a frame comes before the last one is written, the loop waits
//! for the buffer: memory is bounded, and no frame is lost. More buffers would help only where frames come in bursts.

use crate::error::SessionError;
use estar_deck::fields::Field;
use estar_io::{FieldData, Frame, Grid, ResultWriter, WriteError};
use estar_mesh::Mesh;
use estar_solver::Simulation;
use estar_solver::fields::{ElementMeans, pressure, volume_ratio, von_mises_stress};
use estar_solver::model::Part;
use rayon::prelude::*;
use std::path::Path;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

/// One thread packs frames for so many threads of the loop.
const SHARE_OF_THREADS: usize = 4;
/// What `vtkGhostType` says of a cell that is not to be shown.
const HIDDEN_CELL: u8 = 32;
/// Nodes that one thread copies at a time.
const CHUNK: usize = 4096;

/// Hands frames to the thread that writes them.
#[derive(Debug)]
pub struct FrameWriter {
    fields: Vec<Field>,
    sender: Option<Sender<Order>>,
    returned: Receiver<FrameNumbers>,
    thread: Option<JoinHandle<Result<usize, SessionError>>>,
    written: EarlierFrames,
}

/// Frames that have been handed over.
#[derive(Clone, Debug, Default)]
pub struct EarlierFrames {
    /// Their times, s.
    pub times: Vec<f64>,
    /// Step of the last.
    pub last_step: Option<u64>,
}

/// What the thread is to do; it gives the buffer back when it has done so.
enum Order {
    /// Write a frame.
    Write(FrameNumbers),
    /// Put the frames so far on the disk.
    Sync(FrameNumbers),
}

/// What a frame takes from the loop; a field that nobody asked for stays empty.
#[derive(Debug, Default)]
pub struct FrameNumbers {
    time: f64,
    displacement: Vec<[f64; 3]>,
    velocity: Vec<[f64; 3]>,
    cauchy_stress: Vec<[f64; 6]>,
    equivalent_plastic_strain: Vec<f64>,
    temperature: Vec<f64>,
    /// Empty where no element shares its volume change: then it follows from the displacement.
    volume_ratio: Vec<f64>,
    /// Of deleted elements [`HIDDEN_CELL`]; empty where none ever is deleted.
    ghosts: Vec<u8>,
}

impl FrameWriter {
    /// Starts the thread, for frames that follow the `earlier` ones.
    ///
    /// # Errors
    /// The directory cannot be written to, or has one of these frames damaged.
    pub fn start(
        directory: &Path,
        mesh: &Mesh,
        parts: &[Part],
        fields: &[Field],
        earlier: EarlierFrames,
    ) -> Result<Self, SessionError> {
        let mut writer = if earlier.times.is_empty() {
            ResultWriter::create(directory)?
        } else {
            ResultWriter::resume(directory, earlier.times.clone())?
        };
        let part_of_element = part_of_element(mesh, parts);
        // packing a frame must not crowd out the loop
        let threads = rayon::current_num_threads().div_ceil(SHARE_OF_THREADS);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(|error| SessionError::NoFrameThreads { reason: error.to_string() })?;
        let (sender, orders) = channel::<Order>();
        let (give_back, returned) = channel();
        let (mesh, wanted) = (mesh.clone(), fields.to_vec());
        let write_all = move || {
            // whoever is to take buffers may be gone already: then there is nothing to write
            let _ = give_back.send(FrameNumbers::default());
            let grid = pool.install(|| grid(&mesh, &part_of_element))?;
            drop(part_of_element);
            for order in orders {
                let numbers = match order {
                    Order::Write(numbers) => {
                        pool.install(|| numbers.write(&mut writer, &grid, &mesh, &wanted))?;
                        numbers
                    }
                    Order::Sync(numbers) => {
                        writer.sync()?;
                        numbers
                    }
                };
                let _ = give_back.send(numbers);
            }
            Ok(writer.frame_count())
        };
        let thread = std::thread::Builder::new().name("frames".to_owned()).spawn(write_all);
        let thread = thread.map_err(|error| SessionError::NoFrameThreads { reason: error.to_string() })?;
        let (fields, sender, thread) = (fields.to_vec(), Some(sender), Some(thread));
        Ok(Self { fields, sender, returned, thread, written: earlier })
    }

    /// Hands over the frame of the present step, unless it was the last one handed over.
    ///
    /// # Errors
    /// An earlier frame could not be written.
    pub fn write(&mut self, simulation: &Simulation) -> Result<(), SessionError> {
        if self.written.last_step >= Some(simulation.step()) {
            return Ok(());
        }
        self.written.last_step = Some(simulation.step());
        self.written.times.push(simulation.time());
        let fields = self.fields.clone();
        self.order(|mut numbers| {
            numbers.take(simulation, &fields);
            Order::Write(numbers)
        })
    }

    /// Waits until the frames so far are written and on the disk.
    ///
    /// # Errors
    /// One of them could not be written.
    pub fn sync(&mut self) -> Result<&EarlierFrames, SessionError> {
        self.order(Order::Sync)?;
        // done when the buffer is back, which the next order takes
        self.order(Order::Sync)?;
        Ok(&self.written)
    }

    /// Gives an order, with the buffer that has come back from the one before.
    fn order(&mut self, order: impl FnOnce(FrameNumbers) -> Order) -> Result<(), SessionError> {
        // no buffer comes back when the writer has given up
        let sent = self.returned.recv().ok().and_then(|numbers| self.sender.as_ref()?.send(order(numbers)).ok());
        match sent {
            Some(()) => Ok(()),
            None => self.finish().map(|_| ()),
        }
    }

    /// Waits until all frames are written; their number.
    ///
    /// # Errors
    /// A frame could not be written.
    pub fn finish(&mut self) -> Result<usize, SessionError> {
        self.sender = None;
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(result)) => result,
            Some(Err(_)) => Err(SessionError::FrameWriter),
            None => Ok(0),
        }
    }
}

/// Part of each hex, by its place in the model.
pub fn part_of_element(mesh: &Mesh, parts: &[Part]) -> Vec<i32> {
    let mut part_of_element = vec![0; mesh.element_count()];
    for (number, part) in parts.iter().enumerate() {
        for hex in &part.elements {
            part_of_element[*hex as usize] = number as i32 + 1;
        }
    }
    part_of_element
}

/// What is the same in every frame.
///
/// # Errors
/// The mesh is too large for the format.
pub fn grid(mesh: &Mesh, part_of_element: &[i32]) -> Result<Grid, WriteError> {
    let node_labels: Vec<i64> = mesh.node_labels().iter().map(|label| label.0 as i64).collect();
    let element_labels: Vec<i64> = mesh.element_labels().iter().map(|label| label.0 as i64).collect();
    let label = |name, data| estar_io::Field { name, components: 1, data };
    let of_nodes = [label("node_id", FieldData::I64(&node_labels))];
    let of_elements =
        [label("element_id", FieldData::I64(&element_labels)), label("part", FieldData::I32(part_of_element))];
    Grid::new(mesh.node_count(), mesh.elements(), &of_nodes, &of_elements)
}

impl FrameNumbers {
    /// Copies what the fields need of the present state, with all threads of the pool.
    pub fn take(&mut self, simulation: &Simulation, fields: &[Field]) {
        let (node_count, element_count) = (simulation.displacement().len(), simulation.element_count());
        let is_wanted = |those: &[Field]| fields.iter().any(|field| those.contains(field));
        self.time = simulation.time();
        self.displacement.resize(node_count, [0.0; 3]);
        let copies = self.displacement.par_chunks_mut(CHUNK).zip(simulation.displacement().par_chunks(CHUNK));
        copies.for_each(|(copy, displacement)| copy.copy_from_slice(displacement));
        if is_wanted(&[Field::Velocity]) {
            self.velocity.resize(node_count, [0.0; 3]);
            simulation.write_velocity(&mut self.velocity);
        }
        let stress = is_wanted(&[Field::CauchyStress, Field::VonMisesStress, Field::Pressure]).then(|| {
            self.cauchy_stress.resize(element_count, [0.0; 6]);
            self.cauchy_stress.as_mut_slice()
        });
        let strain = is_wanted(&[Field::EquivalentPlasticStrain]).then(|| {
            self.equivalent_plastic_strain.resize(element_count, 0.0);
            self.equivalent_plastic_strain.as_mut_slice()
        });
        let temperature = is_wanted(&[Field::Temperature]).then(|| {
            self.temperature.resize(element_count, 0.0);
            self.temperature.as_mut_slice()
        });
        self.ghosts.clear();
        if simulation.deletes() {
            self.ghosts.extend(simulation.deleted().into_iter().map(|deleted| if deleted { HIDDEN_CELL } else { 0 }));
        }
        let means =
            ElementMeans { cauchy_stress: stress, equivalent_plastic_strain: strain, temperature, volume_ratio: None };
        simulation.write_means(means);
        if is_wanted(&[Field::VolumeRatio]) && simulation.shares_volume() {
            self.volume_ratio.resize(element_count, 0.0);
            simulation.write_volume_ratio(&mut self.volume_ratio);
        }
    }

    /// The numbers of some nodes and elements, in their order.
    pub fn of(&self, nodes: &[u32], elements: &[u32]) -> Self {
        fn chosen<T: Copy>(all: &[T], indices: &[u32]) -> Vec<T> {
            let indices = indices.iter().filter(|_| !all.is_empty());
            indices.map(|&index| all[index as usize]).collect()
        }
        Self {
            time: self.time,
            displacement: chosen(&self.displacement, nodes),
            velocity: chosen(&self.velocity, nodes),
            cauchy_stress: chosen(&self.cauchy_stress, elements),
            equivalent_plastic_strain: chosen(&self.equivalent_plastic_strain, elements),
            temperature: chosen(&self.temperature, elements),
            volume_ratio: chosen(&self.volume_ratio, elements),
            ghosts: chosen(&self.ghosts, elements),
        }
    }

    /// Writes the frame.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(
        &self,
        writer: &mut ResultWriter,
        grid: &Grid,
        mesh: &Mesh,
        fields: &[Field],
    ) -> Result<(), WriteError> {
        let (reference, displacement, stress) = (mesh.coordinates(), &self.displacement, &self.cauchy_stress);
        let place = |k: usize| reference[k / 3][k % 3] + displacement[k / 3][k % 3];
        let von_mises_stress = |hex: usize| von_mises_stress(&stress[hex]);
        let pressure = |hex: usize| pressure(&stress[hex]);
        let volume_ratio = |element: usize| match self.volume_ratio.get(element) {
            Some(ratio) => *ratio,
            None => volume_ratio(mesh.elements(), element, reference, displacement),
        };
        let computed = |number| FieldData::Computed { count: mesh.element_count(), number };

        let (mut node_fields, mut cell_fields) = (Vec::new(), Vec::new());
        for field in fields {
            let (all, name, components, data) = match field {
                Field::Displacement => {
                    (&mut node_fields, "displacement", 3, FieldData::F64(displacement.as_flattened()))
                }
                Field::Velocity => (&mut node_fields, "velocity", 3, FieldData::F64(self.velocity.as_flattened())),
                Field::CauchyStress => (&mut cell_fields, "cauchy_stress", 6, FieldData::F64(stress.as_flattened())),
                Field::EquivalentPlasticStrain => {
                    let strain = FieldData::F64(&self.equivalent_plastic_strain);
                    (&mut cell_fields, "equivalent_plastic_strain", 1, strain)
                }
                Field::Temperature => (&mut cell_fields, "temperature", 1, FieldData::F64(&self.temperature)),
                Field::VonMisesStress => (&mut cell_fields, "von_mises_stress", 1, computed(&von_mises_stress)),
                Field::Pressure => (&mut cell_fields, "pressure", 1, computed(&pressure)),
                Field::VolumeRatio => (&mut cell_fields, "volume_ratio", 1, computed(&volume_ratio)),
            };
            all.push(estar_io::Field { name, components, data });
        }
        if !self.ghosts.is_empty() {
            let data = FieldData::U8(&self.ghosts);
            cell_fields.push(estar_io::Field { name: "vtkGhostType", components: 1, data });
        }
        let points = FieldData::Computed { count: 3 * mesh.node_count(), number: &place };
        writer.write_frame(&Frame { time: self.time, grid, points, node_fields, cell_fields }).map(|_| ())
    }
}
