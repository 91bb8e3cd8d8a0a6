//! One frame of results as a VTK unstructured grid (`.vtu`), binary and compressed.
//!
//! The XML around the numbers is written here, and not by the crate `vtkio`: its versions 0.6.3 and 0.7.0-rc2 have no
//! place for field data, where ParaView looks for `TimeValue`; they want every array as a vector of their own; and they
//! hold it all as base64 text, which takes ten times as long (7.3 s against 0.7 s for a frame of a million hexes).

use std::collections::HashSet;
use std::fmt;
use std::io::{self, Write};

use estar_mesh::{Elements, Shape};
use flate2::Compression;
use flate2::write::ZlibEncoder;
use rayon::prelude::*;
use thiserror::Error;

use crate::results::WriteError;

/// Bytes of a compressed block: large enough to compress well, small enough to share among threads.
const BLOCK_SIZE: usize = 1 << 17;
/// The fastest level: the others save a few percent of the file for several times the time.
const LEVEL: u32 = 1;

/// The state of a mesh at one time, as it is written.
#[derive(Debug, Clone)]
pub struct Frame<'a> {
    /// The simulated time.
    pub time: f64,
    /// What is the same in every frame.
    pub grid: &'a Grid,
    /// Where the nodes are now: three numbers each.
    pub points: FieldData<'a>,
    /// Fields with a value at every node.
    pub node_fields: Vec<Field<'a>>,
    /// Fields with a value in every element.
    pub cell_fields: Vec<Field<'a>>,
}

/// A named field.
#[derive(Debug, Clone, Copy)]
pub struct Field<'a> {
    /// What ParaView calls it.
    pub name: &'a str,
    /// Numbers per node or element: 1 for a scalar, 3 for a vector, 6 for a symmetric tensor in VTK's order
    /// XX, YY, ZZ, XY, YZ, XZ, 9 for a tensor by rows.
    pub components: usize,
    /// All components of the first node or element, then of the second, and so on.
    pub data: FieldData<'a>,
}

/// The numbers of a field.
#[derive(Clone, Copy)]
pub enum FieldData<'a> {
    /// Double precision, computed from the position of the number when it is written: a field that follows from others
    /// takes no memory.
    Computed {
        /// How many numbers.
        count: usize,
        /// The number at a position.
        number: &'a (dyn Fn(usize) -> f64 + Sync),
    },
    /// Double precision.
    F64(&'a [f64]),
    /// Single precision.
    F32(&'a [f32]),
    /// 32-bit integers.
    I32(&'a [i32]),
    /// 64-bit integers.
    I64(&'a [i64]),
    /// Bytes.
    U8(&'a [u8]),
}

/// A frame that cannot be written because its parts do not fit.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum FrameError {
    /// A field of the wrong length.
    #[error("field \"{field}\": {found} numbers, but {expected} expected ({components} for each of {count})")]
    Length {
        /// The field.
        field: String,
        /// How many numbers it has.
        found: usize,
        /// How many it should have.
        expected: usize,
        /// Numbers per node or element.
        components: usize,
        /// Nodes or elements.
        count: usize,
    },
    /// Two fields of the same kind and name.
    #[error("two fields are named \"{field}\"")]
    DuplicateField {
        /// The name.
        field: String,
    },
}

/// What is the same in every frame of a series: the elements and the fields that never change, compressed once.
#[derive(Debug)]
pub struct Grid {
    node_count: usize,
    element_count: usize,
    topology: [CompressedField; 3],
    node_fields: Vec<CompressedField>,
    cell_fields: Vec<CompressedField>,
}

/// An array as it is in the file, and what the XML says of it.
#[derive(Debug)]
struct CompressedField {
    vtk_type: &'static str,
    name: String,
    attributes: String,
    bytes: Vec<u8>,
}

impl Grid {
    /// The elements by their nodes, of which there are `node_count`, and the fields that never change.
    ///
    /// # Errors
    /// A field that does not fit.
    pub fn new(
        node_count: usize,
        elements: &Elements,
        node_fields: &[Field],
        cell_fields: &[Field],
    ) -> Result<Self, WriteError> {
        check(&[], node_fields, node_count)?;
        check(&[], cell_fields, elements.len())?;
        let nodes = elements.all_nodes();
        let end = |element: usize| elements.start(element) + elements.shape(element).node_count();
        let (vtk_type, connectivity, offsets) = if node_count.max(nodes.len()) <= i32::MAX as usize {
            let connectivity = compressed(nodes.len(), |k| nodes[k].to_le_bytes())?;
            ("Int32", connectivity, compressed(elements.len(), |k| (end(k) as u32).to_le_bytes())?)
        } else {
            let connectivity = compressed(nodes.len(), |k| u64::from(nodes[k]).to_le_bytes())?;
            ("Int64", connectivity, compressed(elements.len(), |k| (end(k) as u64).to_le_bytes())?)
        };
        let types = compressed(elements.len(), |k| [vtk_cell(elements.shape(k))])?;
        let arrays =
            [(vtk_type, "connectivity", connectivity), (vtk_type, "offsets", offsets), ("UInt8", "types", types)];
        Ok(Self {
            node_count,
            element_count: elements.len(),
            topology: arrays.map(|(vtk_type, name, bytes)| CompressedField {
                vtk_type,
                name: name.to_owned(),
                attributes: String::new(),
                bytes,
            }),
            node_fields: compressed_fields(node_fields)?,
            cell_fields: compressed_fields(cell_fields)?,
        })
    }
}

/// The number of a shape among VTK's types of cells.
fn vtk_cell(shape: Shape) -> u8 {
    match shape {
        Shape::Hex8 => 12,
        Shape::Wedge6 => 13,
        Shape::Pyramid5 => 14,
        Shape::Tet4 => 10,
        Shape::Tet10 => 24,
    }
}

/// Writes a frame.
pub(crate) fn write_vtu(out: &mut impl Write, frame: &Frame) -> Result<(), WriteError> {
    let grid = frame.grid;
    check(&grid.node_fields, &frame.node_fields, grid.node_count)?;
    check(&grid.cell_fields, &frame.cell_fields, grid.element_count)?;
    let points = Field { name: "Points", components: 3, data: frame.points };
    check(&[], &[points], grid.node_count)?;

    // The numbers follow the XML, which names the place of each array among them: compress first.
    let time = Field { name: "TimeValue", components: 1, data: FieldData::F64(&[frame.time]) };
    let time = CompressedField { attributes: "NumberOfTuples=\"1\"".to_owned(), ..compressed_field(&time)? };
    let points = CompressedField { attributes: "NumberOfComponents=\"3\"".to_owned(), ..compressed_field(&points)? };
    let node_fields = compressed_fields(&frame.node_fields)?;
    let cell_fields = compressed_fields(&frame.cell_fields)?;

    let mut file = Document::default();
    file.open(
        "VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
               header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\"",
    );
    file.open("UnstructuredGrid");
    file.open("FieldData");
    file.array(&time);
    file.close("FieldData");
    let (point_count, cell_count) = (grid.node_count, grid.element_count);
    file.open(&format!("Piece NumberOfPoints=\"{point_count}\" NumberOfCells=\"{cell_count}\""));
    for (section, fields, unchanging) in
        [("PointData", &node_fields, &grid.node_fields), ("CellData", &cell_fields, &grid.cell_fields)]
    {
        file.open(section);
        fields.iter().chain(unchanging).for_each(|field| file.array(field));
        file.close(section);
    }
    file.open("Points");
    file.array(&points);
    file.close("Points");
    file.open("Cells");
    grid.topology.iter().for_each(|field| file.array(field));
    file.close("Cells");
    file.close("Piece");
    file.close("UnstructuredGrid");

    write!(out, "<?xml version=\"1.0\"?>\n{}<AppendedData encoding=\"raw\">\n_", file.xml)?;
    for array in file.appended {
        out.write_all(array)?;
    }
    out.write_all(b"\n</AppendedData>\n</VTKFile>\n")?;
    Ok(())
}

/// XML that refers to arrays behind it.
#[derive(Default)]
struct Document<'a> {
    xml: String,
    appended: Vec<&'a [u8]>,
    offset: usize,
}

impl<'a> Document<'a> {
    fn open(&mut self, tag: &str) {
        self.xml += &format!("<{tag}>\n");
    }

    fn close(&mut self, tag: &str) {
        self.xml += &format!("</{tag}>\n");
    }

    fn array(&mut self, field: &'a CompressedField) {
        let (vtk_type, name, attributes) = (field.vtk_type, escaped(&field.name), &field.attributes);
        let offset = self.offset;
        self.open(&format!(
            "DataArray type=\"{vtk_type}\" Name=\"{name}\" {attributes} format=\"appended\" offset=\"{offset}\"/"
        ));
        self.appended.push(&field.bytes);
        self.offset += field.bytes.len();
    }
}

impl fmt::Debug for FieldData<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} × {}", self.len(), self.vtk_type())
    }
}

impl FieldData<'_> {
    fn len(&self) -> usize {
        match self {
            FieldData::Computed { count, .. } => *count,
            FieldData::F64(data) => data.len(),
            FieldData::F32(data) => data.len(),
            FieldData::I32(data) => data.len(),
            FieldData::I64(data) => data.len(),
            FieldData::U8(data) => data.len(),
        }
    }

    fn vtk_type(&self) -> &'static str {
        match self {
            FieldData::Computed { .. } | FieldData::F64(_) => "Float64",
            FieldData::F32(_) => "Float32",
            FieldData::I32(_) => "Int32",
            FieldData::I64(_) => "Int64",
            FieldData::U8(_) => "UInt8",
        }
    }
}

fn check(others: &[CompressedField], fields: &[Field], count: usize) -> Result<(), FrameError> {
    let mut names: HashSet<&str> = others.iter().map(|field| field.name.as_str()).collect();
    for field in fields {
        if !names.insert(field.name) {
            return Err(FrameError::DuplicateField { field: field.name.to_owned() });
        }
        let (found, expected) = (field.data.len(), field.components * count);
        if found != expected {
            let field_name = field.name.to_owned();
            return Err(FrameError::Length { field: field_name, found, expected, components: field.components, count });
        }
    }
    Ok(())
}

fn component_attributes(components: usize) -> String {
    let names: &[&str] = match components {
        3 => &["X", "Y", "Z"],
        6 => &["XX", "YY", "ZZ", "XY", "YZ", "XZ"],
        9 => &["XX", "XY", "XZ", "YX", "YY", "YZ", "ZX", "ZY", "ZZ"],
        _ => &[],
    };
    let mut attributes = format!("NumberOfComponents=\"{components}\"");
    for (k, name) in names.iter().enumerate() {
        attributes += &format!(" ComponentName{k}=\"{name}\"");
    }
    attributes
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

fn compressed_fields(fields: &[Field]) -> io::Result<Vec<CompressedField>> {
    fields.iter().map(compressed_field).collect()
}

fn compressed_field(field: &Field) -> io::Result<CompressedField> {
    let bytes = match field.data {
        FieldData::Computed { count, number } => compressed(count, |k| number(k).to_le_bytes()),
        FieldData::F64(data) => compressed(data.len(), |k| data[k].to_le_bytes()),
        FieldData::F32(data) => compressed(data.len(), |k| data[k].to_le_bytes()),
        FieldData::I32(data) => compressed(data.len(), |k| data[k].to_le_bytes()),
        FieldData::I64(data) => compressed(data.len(), |k| data[k].to_le_bytes()),
        FieldData::U8(data) => compressed(data.len(), |k| [data[k]]),
    };
    Ok(CompressedField {
        vtk_type: field.data.vtk_type(),
        name: field.name.to_owned(),
        attributes: component_attributes(field.components),
        bytes: bytes?,
    })
}

/// `count` numbers of `SIZE` bytes in blocks, each compressed by itself, behind VTK's header: the number of blocks,
/// their size, that of a last one that is shorter (or 0), and the compressed size of each.
fn compressed<const SIZE: usize>(count: usize, number: impl Fn(usize) -> [u8; SIZE] + Sync) -> io::Result<Vec<u8>> {
    let per_block = BLOCK_SIZE / SIZE;
    // Blocks are collected in order, whatever thread made them: the file has the same bytes for any thread count.
    let blocks: Vec<Vec<u8>> = (0..count.div_ceil(per_block))
        .into_par_iter()
        .map(|block| {
            let numbers = block * per_block..count.min((block + 1) * per_block);
            let bytes: Vec<u8> = numbers.flat_map(&number).collect();
            let mut encoder = ZlibEncoder::new(Vec::with_capacity(BLOCK_SIZE / 2), Compression::new(LEVEL));
            encoder.write_all(&bytes)?;
            encoder.finish()
        })
        .collect::<io::Result<_>>()?;
    let mut header = vec![blocks.len(), per_block * SIZE, count % per_block * SIZE];
    header.extend(blocks.iter().map(Vec::len));
    let mut bytes: Vec<u8> = header.into_iter().flat_map(|number| (number as u64).to_le_bytes()).collect();
    blocks.iter().for_each(|block| bytes.extend_from_slice(block));
    Ok(bytes)
}
