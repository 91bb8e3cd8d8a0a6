//! Reads back a frame that this program wrote: a VTK unstructured grid with compressed arrays behind the XML.
//!
//! It is no reader of `.vtu` in general: other programs write the same grids in a dozen ways. What is not as it was written
//! here is refused with what is wrong.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use flate2::read::ZlibDecoder;
use thiserror::Error;

use crate::file::read_ordinary;

/// A frame that cannot be read.
#[derive(Debug, Error)]
pub enum FrameReadError {
    /// The system refused.
    #[error("{}: cannot be read: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The file is not as it was written.
    #[error("{}: no frame of this program: {what}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
}

/// A frame.
#[derive(Debug, Clone, Default)]
pub struct FrameContent {
    /// The simulated time, s.
    pub time: f64,
    /// Where the nodes are, m.
    pub points: Vec<[f64; 3]>,
    /// The nodes of all cells, one cell after another.
    pub connectivity: Vec<u32>,
    /// Where the nodes of each cell end in `connectivity`.
    pub offsets: Vec<usize>,
    /// VTK's number of the shape of each cell.
    pub types: Vec<u8>,
    /// Fields at the nodes.
    pub node_fields: BTreeMap<String, FieldContent>,
    /// Fields in the cells.
    pub cell_fields: BTreeMap<String, FieldContent>,
}

/// The numbers of a field.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldContent {
    /// Numbers per node or cell.
    pub components: usize,
    /// All components of the first node or cell, then of the second, and so on.
    pub data: Vec<f64>,
}

impl FrameContent {
    /// The nodes of a cell.
    pub fn cell(&self, cell: usize) -> &[u32] {
        let start = if cell == 0 { 0 } else { self.offsets[cell - 1] };
        &self.connectivity[start..self.offsets[cell]]
    }
}

/// Reads the frame of a file.
///
/// # Errors
/// The file cannot be read, or is not as it was written.
pub fn read_frame(path: &Path) -> Result<FrameContent, FrameReadError> {
    read_frame_with(path, FrameLimits::default(), |_| true)
}

/// How large a frame may be that is read.
#[derive(Debug, Clone, Copy)]
pub struct FrameLimits {
    /// Bytes of the file.
    pub file: u64,
    /// Bytes of the numbers that it is unpacked into.
    pub numbers: u64,
}

/// None, but that of every frame: no file is unpacked into more than 64 times its own bytes.
impl Default for FrameLimits {
    fn default() -> Self {
        Self { file: u64::MAX, numbers: u64::MAX }
    }
}

/// Bytes of numbers in memory, eight each, over bytes of the file. The frames of this program are far from it: those of boxes of
/// equal elements at rest, whose fields are all zero, have 7 to 10, and zlib alone could make 8,000 of single bytes that are all
/// the same.
const MOST_UNPACKED: u64 = 64;
/// The head of a small file is most of it.
const ALWAYS_UNPACKED: u64 = 1 << 20;

/// Reads the frame of a file, but of its fields only the numbers of those that are wanted by name: the others are there with their
/// components and without numbers. Unpacking is most of the work.
///
/// # Errors
/// The file cannot be read, is not as it was written, or is larger than the limits.
pub fn read_frame_with(
    path: &Path,
    limits: FrameLimits,
    wanted: impl Fn(&str) -> bool,
) -> Result<FrameContent, FrameReadError> {
    let bytes = read_ordinary(path, limits.file)
        .map_err(|source| FrameReadError::Unreadable { path: path.to_owned(), source })?;
    frame_of(&bytes, limits.numbers, wanted).map_err(|what| FrameReadError::Content { path: path.to_owned(), what })
}

/// Reads a frame from the bytes of its file; an error says what is wrong.
///
/// # Errors
/// The bytes are not as they were written.
pub fn read_frame_bytes(bytes: &[u8]) -> Result<FrameContent, String> {
    frame_of(bytes, u64::MAX, |_| true)
}

fn frame_of(bytes: &[u8], most_numbers: u64, wanted: impl Fn(&str) -> bool) -> Result<FrameContent, String> {
    const APPENDED: &[u8] = b"<AppendedData encoding=\"raw\">\n_";
    let start =
        bytes.windows(APPENDED.len()).position(|window| window == APPENDED).ok_or("it has no arrays behind the XML")?;
    let xml = std::str::from_utf8(&bytes[..start]).map_err(|_| "its XML is not text")?;
    let appended = &bytes[start + APPENDED.len()..];
    let room = Cell::new((MOST_UNPACKED * bytes.len() as u64).max(ALWAYS_UNPACKED).min(most_numbers));

    let mut frame = FrameContent::default();
    let (mut node_count, mut cell_count) = (None, None);
    let mut section = String::new();
    for tag in tags(xml) {
        let name = tag.split([' ', '/', '>']).next().unwrap_or("");
        match name {
            "Piece" => {
                node_count = Some(number_of(tag, "NumberOfPoints")?);
                cell_count = Some(number_of(tag, "NumberOfCells")?);
            }
            "FieldData" | "PointData" | "CellData" | "Points" | "Cells" => section = name.to_owned(),
            "DataArray" => {
                let array = Array::of(tag, appended, &room)?;
                let counts = || Some((node_count?, cell_count?));
                if section == "FieldData" {
                    if array.name == "TimeValue" {
                        frame.time = array.numbers(1)?.first().copied().ok_or("it has no time")?;
                    }
                    continue;
                }
                let (node_count, cell_count) = counts().ok_or("its arrays come before their counts")?;
                let field = |tuples: usize| {
                    if wanted(&array.name) {
                        array.field(tuples)
                    } else {
                        Ok(FieldContent { components: array.components, data: Vec::new() })
                    }
                };
                match section.as_str() {
                    "Points" => frame.points = array.triples(node_count)?,
                    "PointData" => {
                        frame.node_fields.insert(array.name.clone(), field(node_count)?);
                    }
                    "CellData" => {
                        frame.cell_fields.insert(array.name.clone(), field(cell_count)?);
                    }
                    "Cells" => match array.name.as_str() {
                        "connectivity" => frame.connectivity = array.all_indices(node_count)?,
                        "offsets" => {
                            frame.offsets =
                                array.numbers(cell_count)?.into_iter().map(|offset| offset as usize).collect();
                        }
                        "types" => {
                            frame.types = array.numbers(cell_count)?.into_iter().map(|kind| kind as u8).collect();
                        }
                        _ => {}
                    },
                    _ => {}
                }
            }
            _ => {}
        }
    }
    let is_rising = frame.offsets.is_sorted() && frame.offsets.last().copied().unwrap_or(0) == frame.connectivity.len();
    let is_whole = Some(frame.points.len()) == node_count
        && Some(frame.offsets.len()) == cell_count
        && frame.types.len() == frame.offsets.len();
    if is_whole && is_rising { Ok(frame) } else { Err("its points and cells do not fit together".to_owned()) }
}

/// What stands between `<` and `>`, of tags that open.
fn tags(xml: &str) -> impl Iterator<Item = &str> {
    xml.split('<').filter_map(|piece| piece.split_once('>').map(|(tag, _)| tag)).filter(|tag| !tag.starts_with('/'))
}

fn attribute<'a>(tag: &'a str, name: &str) -> Option<&'a str> {
    let (_, after) = tag.split_once(&format!(" {name}=\""))?;
    after.split_once('"').map(|(value, _)| value)
}

fn number_of(tag: &str, name: &str) -> Result<usize, String> {
    let text = attribute(tag, name).ok_or_else(|| format!("a tag lacks {name}"))?;
    text.parse().map_err(|_| format!("{name} is no number"))
}

/// An array as the XML describes it, and the bytes from its beginning on.
struct Array<'a> {
    name: String,
    kind: &'a str,
    components: usize,
    bytes: &'a [u8],
    /// Bytes of numbers that the frame may still have.
    room: &'a Cell<u64>,
}

impl<'a> Array<'a> {
    fn of(tag: &'a str, appended: &'a [u8], room: &'a Cell<u64>) -> Result<Self, String> {
        let name = attribute(tag, "Name").ok_or("an array has no name")?;
        let components =
            if attribute(tag, "NumberOfComponents").is_some() { number_of(tag, "NumberOfComponents")? } else { 1 };
        if !(1..=9).contains(&components) {
            return Err(format!("the array {name} has {components} components"));
        }
        let bytes = appended.get(number_of(tag, "offset")?..).ok_or("an array begins behind the end of the file")?;
        let name = name.replace("&quot;", "\"").replace("&gt;", ">").replace("&lt;", "<").replace("&amp;", "&");
        Ok(Self { name, kind: attribute(tag, "type").unwrap_or(""), components, bytes, room })
    }

    fn size(&self) -> Result<usize, String> {
        match self.kind {
            "UInt8" => Ok(1),
            "Int32" | "Float32" => Ok(4),
            "Int64" | "Float64" => Ok(8),
            kind => Err(format!("the array {} is of the type \"{kind}\"", self.name)),
        }
    }

    /// `tuples` times its components.
    fn numbers(&self, tuples: usize) -> Result<Vec<f64>, String> {
        let size = self.size()?;
        let count = tuples.checked_mul(self.components).ok_or("a count that nothing holds")?;
        let left = (count as u64).checked_mul(8).and_then(|bytes| self.room.get().checked_sub(bytes));
        let left = left.ok_or_else(|| format!("the array {} promises more than such a file can hold", self.name))?;
        self.room.set(left);
        let bytes = self.unpacked(count.checked_mul(size).ok_or("a count that nothing holds")?)?;
        let number = |bytes: &[u8]| match (self.kind, bytes) {
            ("UInt8", [byte]) => f64::from(*byte),
            ("Int32", [a, b, c, d]) => f64::from(i32::from_le_bytes([*a, *b, *c, *d])),
            ("Float32", [a, b, c, d]) => f64::from(f32::from_le_bytes([*a, *b, *c, *d])),
            ("Int64", [a, b, c, d, e, f, g, h]) => i64::from_le_bytes([*a, *b, *c, *d, *e, *f, *g, *h]) as f64,
            ("Float64", [a, b, c, d, e, f, g, h]) => f64::from_le_bytes([*a, *b, *c, *d, *e, *f, *g, *h]),
            _ => f64::NAN,
        };
        Ok(bytes.chunks_exact(size).map(number).collect())
    }

    fn field(&self, tuples: usize) -> Result<FieldContent, String> {
        Ok(FieldContent { components: self.components, data: self.numbers(tuples)? })
    }

    fn triples(&self, tuples: usize) -> Result<Vec<[f64; 3]>, String> {
        if self.components != 3 {
            return Err("its points have not three coordinates".to_owned());
        }
        let numbers = self.numbers(tuples)?;
        Ok(numbers.chunks_exact(3).map(|triple| [triple[0], triple[1], triple[2]]).collect())
    }

    /// As many node numbers as there are.
    fn all_indices(&self, node_count: usize) -> Result<Vec<u32>, String> {
        let Header { full, block, rest, .. } = Header::of(self.bytes)?;
        let count = (full * block + rest) / self.size()?;
        let numbers = self.numbers(count)?;
        let is_node = |number: &f64| *number >= 0.0 && *number < node_count as f64;
        if !numbers.iter().all(is_node) {
            return Err("a cell has a node that is not there".to_owned());
        }
        Ok(numbers.into_iter().map(|number| number as u32).collect())
    }

    /// The bytes of the array, of which there must be `expected`.
    fn unpacked(&self, expected: usize) -> Result<Vec<u8>, String> {
        let Header { full, block, rest, sizes, data } = Header::of(self.bytes)?;
        let count = full * block + rest;
        if count != expected {
            return Err(format!("the array {} has {count} bytes instead of {expected}", self.name));
        }
        // zlib makes a thousandth of what is all the same at best: a file that promises more lies
        if expected / 1100 > data.len() {
            return Err(format!("the array {} is too short for what it should be", self.name));
        }
        let mut bytes = Vec::with_capacity(expected);
        let mut packed = data;
        for (index, &size) in sizes.iter().enumerate() {
            let (own, others) = packed.split_at_checked(size).ok_or("it ends in an array")?;
            packed = others;
            let wanted = if index < full { block } else { rest };
            let before = bytes.len();
            let read = ZlibDecoder::new(own).take(wanted as u64 + 1).read_to_end(&mut bytes);
            if read.is_err() || bytes.len() - before != wanted {
                return Err(format!("the array {} cannot be unpacked", self.name));
            }
        }
        Ok(bytes)
    }
}

/// VTK's head of a compressed array.
struct Header<'a> {
    /// Blocks of full size.
    full: usize,
    /// Bytes of a full block.
    block: usize,
    /// Bytes of a last one that is shorter, or 0.
    rest: usize,
    /// Packed bytes of each block.
    sizes: Vec<usize>,
    /// The packed blocks.
    data: &'a [u8],
}

impl<'a> Header<'a> {
    fn of(bytes: &'a [u8]) -> Result<Self, String> {
        /// No block that this program writes is larger.
        const LARGEST: usize = 1 << 24;
        let word = |index: usize| -> Result<usize, String> {
            let word = bytes.get(8 * index..8 * index + 8).ok_or("it ends in the head of an array")?;
            let word: [u8; 8] = word.try_into().map_err(|_| "it ends in the head of an array")?;
            usize::try_from(u64::from_le_bytes(word)).map_err(|_| "a count that nothing holds".to_owned())
        };
        let [count, block, rest] = [word(0)?, word(1)?, word(2)?];
        // each block has a word of its own: no count is greater than the file
        if count > bytes.len() / 8 || block > LARGEST || rest > block || (rest > 0 && count == 0) {
            return Err("the head of an array makes no sense".to_owned());
        }
        let sizes = (0..count).map(|index| word(3 + index)).collect::<Result<Vec<usize>, String>>()?;
        let full = if rest > 0 { count - 1 } else { count };
        Ok(Self { full, block, rest, sizes, data: bytes.get(8 * (3 + count)..).unwrap_or(&[]) })
    }
}
