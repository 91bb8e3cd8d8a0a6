//! Frames, written by a thread of their own so that output does not stop the loop.

use crate::failure::Failure;
use crate::fields::Field;
use crate::snapshot::Snapshot;
use estar_io::{FieldData, Frame, ResultWriter};
use estar_mesh::Mesh;
use estar_solver::model::Part;
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::JoinHandle;

/// Frames that may wait for the writer before the solver waits, too.
const WAITING_FRAMES: usize = 2;
/// One thread packs frames for so many threads of the loop.
const SHARE_OF_THREADS: usize = 4;

/// Hands frames to the thread that writes them.
#[derive(Debug)]
pub struct FrameWriter {
    fields: Vec<Field>,
    sender: Option<SyncSender<OwnedFrame>>,
    thread: Option<JoinHandle<Result<usize, Failure>>>,
    last_step: Option<u64>,
}

/// What a frame needs beside what never changes.
#[derive(Debug)]
struct OwnedFrame {
    time: f64,
    points: Vec<[f64; 3]>,
    node_fields: Vec<OwnedField>,
    cell_fields: Vec<OwnedField>,
}

#[derive(Debug)]
struct OwnedField {
    name: &'static str,
    components: usize,
    data: Vec<f64>,
}

/// What is the same in every frame.
#[derive(Debug)]
struct Unchanging {
    hexes: Vec<[u32; 8]>,
    node_labels: Vec<i64>,
    hex_labels: Vec<i64>,
    parts: Vec<i32>,
}

impl FrameWriter {
    /// Starts the thread.
    ///
    /// # Errors
    /// The directory cannot be written to.
    pub fn start(directory: &Path, mesh: &Mesh, parts: &[Part], fields: &[Field]) -> Result<Self, Failure> {
        let mut writer = ResultWriter::create(directory).map_err(|error| Failure::File(format!("error: {error}")))?;
        let mut part_of_hex = vec![0; mesh.hex_count()];
        for (number, part) in parts.iter().enumerate() {
            for hex in &part.hexes {
                part_of_hex[*hex as usize] = number as i32 + 1;
            }
        }
        let unchanging = Arc::new(Unchanging {
            hexes: mesh.hexes().to_vec(),
            node_labels: mesh.node_labels().iter().map(|label| label.0 as i64).collect(),
            hex_labels: mesh.hex_labels().iter().map(|label| label.0 as i64).collect(),
            parts: part_of_hex,
        });
        // packing a frame must not crowd out the loop
        let threads = rayon::current_num_threads().div_ceil(SHARE_OF_THREADS);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(|error| Failure::File(format!("error: no threads for the frames: {error}")))?;
        let (sender, receiver) = sync_channel::<OwnedFrame>(WAITING_FRAMES);
        let write_all = move || {
            let mut count = 0;
            for frame in receiver {
                let frame = frame.borrowed(&unchanging);
                pool.install(|| writer.write_frame(&frame))
                    .map_err(|error| Failure::File(format!("error: {error}")))?;
                count += 1;
            }
            Ok(count)
        };
        let thread = std::thread::Builder::new().name("frames".to_owned()).spawn(write_all);
        let thread = thread.map_err(|error| Failure::File(format!("error: no thread for the frames: {error}")))?;
        Ok(Self { fields: fields.to_vec(), sender: Some(sender), thread: Some(thread), last_step: None })
    }

    /// Hands over the frame of the present step, unless it was the last one handed over.
    ///
    /// # Errors
    /// An earlier frame could not be written.
    pub fn write(&mut self, snapshot: &Snapshot<'_>) -> Result<(), Failure> {
        let step = snapshot.simulation.step();
        if self.last_step == Some(step) {
            return Ok(());
        }
        self.last_step = Some(step);
        let frame = OwnedFrame::of(snapshot, &self.fields);
        match self.sender.as_ref().map(|sender| sender.send(frame)) {
            Some(Ok(())) => Ok(()),
            _ => self.finish().map(|_| ()),
        }
    }

    /// Waits until all frames are written; their number.
    ///
    /// # Errors
    /// A frame could not be written.
    pub fn finish(&mut self) -> Result<usize, Failure> {
        self.sender = None;
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(result)) => result,
            Some(Err(_)) => Err(Failure::File("error: the writer of the frames broke down".to_owned())),
            None => Ok(0),
        }
    }
}

impl OwnedFrame {
    fn of(snapshot: &Snapshot<'_>, fields: &[Field]) -> Self {
        let simulation = snapshot.simulation;
        let (mut node_fields, mut cell_fields) = (Vec::new(), Vec::new());
        let vector = |name, data: &[[f64; 3]]| OwnedField { name, components: 3, data: data.as_flattened().to_vec() };
        let scalar = |name, data: &[f64]| OwnedField { name, components: 1, data: data.to_vec() };
        for field in fields {
            match field {
                Field::Displacement => node_fields.push(vector("displacement", simulation.displacement())),
                Field::Velocity => node_fields.push(vector("velocity", snapshot.velocity())),
                Field::CauchyStress => cell_fields.push(OwnedField {
                    name: "cauchy_stress",
                    components: 6,
                    data: snapshot.hex_fields().cauchy_stress.as_flattened().to_vec(),
                }),
                Field::EquivalentPlasticStrain => cell_fields
                    .push(scalar("equivalent_plastic_strain", &snapshot.hex_fields().equivalent_plastic_strain)),
                Field::VonMisesStress => {
                    cell_fields.push(scalar("von_mises_stress", &snapshot.hex_fields().von_mises_stress));
                }
                Field::Pressure => cell_fields.push(scalar("pressure", &snapshot.hex_fields().pressure)),
                Field::VolumeRatio => cell_fields.push(scalar("volume_ratio", &snapshot.hex_fields().volume_ratio)),
            }
        }
        let points = (0..snapshot.mesh.node_count() as u32).map(|node| snapshot.position(node)).collect();
        Self { time: simulation.time(), points, node_fields, cell_fields }
    }

    fn borrowed<'a>(&'a self, unchanging: &'a Unchanging) -> Frame<'a> {
        let field = |field: &'a OwnedField| estar_io::Field {
            name: field.name,
            components: field.components,
            data: FieldData::F64(&field.data),
        };
        let label = |name, data| estar_io::Field { name, components: 1, data };
        let mut node_fields: Vec<_> = self.node_fields.iter().map(field).collect();
        node_fields.push(label("node_id", FieldData::I64(&unchanging.node_labels)));
        let mut cell_fields: Vec<_> = self.cell_fields.iter().map(field).collect();
        cell_fields.push(label("element_id", FieldData::I64(&unchanging.hex_labels)));
        cell_fields.push(label("part", FieldData::I32(&unchanging.parts)));
        Frame { time: self.time, points: &self.points, hexes: &unchanging.hexes, node_fields, cell_fields }
    }
}
