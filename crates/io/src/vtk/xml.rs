//! `.vtu`: VTK's XML file of an unstructured grid, whose arrays are text, base64, or bytes behind the XML.
//!
//! The format: VTK User's Guide, "XML file formats"; <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>.

use std::borrow::Cow;

use roxmltree::{Document, Node};

use super::binary::{Compressor, Kind, Packing, Room, Stream, numbers, whole_numbers};
use super::{Numbers, Piece};
use crate::error::{Located, Place, Problem, excerpt};
use crate::other_format::other_vtk;

/// The pieces of the grid, and the format in words.
pub(super) fn read(bytes: &[u8], limit: u64) -> Result<(Vec<Piece>, String), Located> {
    const APPENDED: &[u8] = b"<AppendedData";
    let start = bytes.windows(APPENDED.len()).position(|window| window == APPENDED);
    let (xml, appended) = bytes.split_at(start.unwrap_or(bytes.len()));
    if start.is_some() && !bytes.trim_ascii_end().ends_with(b"</VTKFile>") {
        return Err(Problem::Truncated { within: "AppendedData" }.at(Place::File));
    }
    let xml = std::str::from_utf8(xml).map_err(|error| {
        let line = 1 + xml[..error.valid_up_to()].iter().filter(|byte| **byte == b'\n').count() as u64;
        syntax("the XML is not UTF-8; export the mesh again").at(Place::Line(line))
    })?;
    // what follows may be any bytes: the XML is closed before them
    let xml = if start.is_some() { Cow::Owned(format!("{xml}</VTKFile>")) } else { Cow::Borrowed(xml) };
    let document = Document::parse(&xml).map_err(|error| {
        let line = u64::from(error.pos().row);
        syntax(format!("bad XML: {error}; the file is truncated or damaged: export it again")).at(Place::Line(line))
    })?;
    let file = File::new(&document, appended)?;
    let root = document.root_element();
    let grids = root.children().filter(|node| node.has_tag_name("UnstructuredGrid"));
    let mut room = Room::of_file(bytes.len(), limit);
    let mut pieces = Vec::new();
    for piece in grids.flat_map(|grid| grid.children()).filter(|node| node.has_tag_name("Piece")) {
        pieces.push(file.piece(piece, &mut room)?);
    }
    Ok((pieces, file.format(root)))
}

fn syntax(message: impl Into<String>) -> Problem {
    Problem::Syntax { message: message.into() }
}

/// What is the same for all arrays of a file.
struct File<'a> {
    document: &'a Document<'a>,
    packing: Packing,
    /// How and what stands behind the XML, from the underscore on.
    appended: Option<(bool, &'a [u8])>,
}

impl<'a> File<'a> {
    fn new(document: &'a Document<'a>, appended: &'a [u8]) -> Result<Self, Located> {
        let root = document.root_element();
        let at_root = |problem: Problem| problem.at(Place::Line(1));
        let of_root = |name| root.attribute(name).unwrap_or_default();
        if of_root("type") != "UnstructuredGrid" {
            return Err(at_root(other_vtk(of_root("type"))));
        }
        let is_big = match of_root("byte_order") {
            "BigEndian" => true,
            "LittleEndian" | "" => false,
            other => return Err(at_root(syntax(format!("byte_order is \"{}\"", excerpt(other.as_bytes()))))),
        };
        let word = match of_root("header_type") {
            "UInt64" => 8,
            "UInt32" | "" => 4,
            other => return Err(at_root(syntax(format!("header_type is \"{}\"", excerpt(other.as_bytes()))))),
        };
        let compressor = match of_root("compressor") {
            "" => None,
            "vtkZLibDataCompressor" => Some(Compressor::Zlib),
            "vtkLZ4DataCompressor" => Some(Compressor::Lz4),
            other => {
                let what = format!("the compressor \"{}\"", excerpt(other.as_bytes()));
                let advice = "save the mesh with the compressor ZLib or LZ4, or none";
                return Err(at_root(Problem::NotSupported { what, advice }));
            }
        };
        let appended = appended_data(appended).map_err(|problem| problem.at(Place::File))?;
        Ok(Self { document, packing: Packing { is_big, word, compressor }, appended })
    }

    fn format(&self, root: Node) -> String {
        let packed = match self.packing.compressor {
            None => "",
            Some(Compressor::Zlib) => ", zlib",
            Some(Compressor::Lz4) => ", LZ4",
        };
        let version = excerpt(root.attribute("version").unwrap_or("").as_bytes());
        format!("VTU {version}{packed}")
    }

    fn place(&self, node: Node) -> Place {
        Place::Line(u64::from(self.document.text_pos_at(node.range().start).row))
    }

    fn piece(&self, piece: Node<'a, 'a>, room: &mut Room) -> Result<Piece, Located> {
        let section = |name| piece.children().find(|node: &Node| node.has_tag_name(name));
        let arrays = |name| {
            let nodes = section(name).into_iter().flat_map(|node| node.children());
            nodes.filter(|node: &Node| node.has_tag_name("DataArray"))
        };
        let [node_count, cell_count] = [self.count(piece, "NumberOfPoints")?, self.count(piece, "NumberOfCells")?];
        let missing = |name: &str| {
            let message = format!("the piece has no array \"{name}\"; export the mesh again, with all of it");
            syntax(message).at(self.place(piece))
        };
        let points = arrays("Points").next().ok_or_else(|| missing("Points"))?;
        let coordinates = self.array(points, Some(node_count), room)?.numbers();
        if self.components(points)? != 3 {
            return Err(self.fail(points, "has not three numbers for each point"));
        }
        let cells = |name| {
            let found = arrays("Cells").find(|node| node.attribute("Name") == Some(name));
            found.ok_or_else(|| missing(name))
        };
        let whole = |name, tuples, room: &mut Room| {
            let node = cells(name)?;
            if self.components(node)? != 1 {
                return Err(self.fail(node, "has more than one number for each entry"));
            }
            self.array(node, tuples, room)?
                .whole_numbers()
                .ok_or_else(|| self.fail(node, "has numbers that are not whole"))
        };
        let ends = whole("offsets", Some(cell_count), room)?;
        let types = whole("types", Some(cell_count), room)?;
        let connectivity = whole("connectivity", None, room)?;
        let mut passed_over = Vec::new();
        let mut fields = |name, count, room: &mut Room| -> Result<Vec<Numbers>, Located> {
            let mut kept = Vec::new();
            for node in arrays(name) {
                let array = node.attribute("Name").unwrap_or_default().to_owned();
                let kind = node.attribute("type").and_then(Kind::of_xml);
                if self.components(node)? == 1 && kind.is_some_and(Kind::is_whole) {
                    let values = self.array(node, Some(count), room)?.whole_numbers();
                    let values = values.ok_or_else(|| self.fail(node, "has numbers beyond 2^63"))?;
                    kept.push(Numbers { name: array, values });
                } else {
                    passed_over.push(array);
                }
            }
            Ok(kept)
        };
        let node_arrays = fields("PointData", node_count, room)?;
        let cell_arrays = fields("CellData", cell_count, room)?;
        let (points, _) = coordinates.as_chunks::<3>();
        let points = points.to_vec();
        Ok(Piece { points, connectivity, ends, types, node_arrays, cell_arrays, passed_over })
    }

    fn count(&self, node: Node, name: &'static str) -> Result<usize, Located> {
        let text = node.attribute(name).unwrap_or_default();
        text.trim()
            .parse()
            .map_err(|_| Problem::NotANumber { what: name, found: excerpt(text.as_bytes()) }.at(self.place(node)))
    }

    fn components(&self, node: Node) -> Result<usize, Located> {
        match node.attribute("NumberOfComponents") {
            Some(_) => self.count(node, "NumberOfComponents"),
            None => Ok(1),
        }
    }

    fn fail(&self, node: Node, what: impl Into<String>) -> Located {
        let array = excerpt(node.attribute("Name").unwrap_or("Points").as_bytes());
        Problem::Array { array, what: what.into() }.at(self.place(node))
    }

    /// The numbers of an array: `tuples` times its components, or as many as there are.
    fn array(&self, node: Node<'a, 'a>, tuples: Option<usize>, room: &mut Room) -> Result<Values<'a>, Located> {
        let fail = |what: String| self.fail(node, what);
        let kind = node.attribute("type").unwrap_or_default();
        let kind = Kind::of_xml(kind).ok_or_else(|| fail(format!("has the type \"{}\"", excerpt(kind.as_bytes()))))?;
        let too_many = || fail("has more numbers than any file can hold".to_owned());
        let count = match tuples {
            Some(tuples) => Some(tuples.checked_mul(self.components(node)?).ok_or_else(too_many)?),
            None => None,
        };
        let format = node.attribute("format").unwrap_or("ascii");
        if format.eq_ignore_ascii_case("ascii") {
            let text = node.text().unwrap_or_default();
            room.take(text.len().saturating_mul(4)).map_err(fail)?;
            let values = Values::of_text(kind, text).map_err(fail)?;
            return match count {
                Some(count) if count != values.len() => {
                    Err(fail(format!("has {} numbers instead of {count}", values.len())))
                }
                _ => Ok(values),
            };
        }
        let size = kind.size();
        let length = match count {
            Some(count) => Some(count.checked_mul(size).ok_or_else(too_many)?),
            None => None,
        };
        let bytes = match format {
            "binary" => {
                let text = node.text().unwrap_or_default().trim_ascii().as_bytes();
                if text.iter().any(u8::is_ascii_whitespace) {
                    let text: Vec<u8> = text.iter().copied().filter(|byte| !byte.is_ascii_whitespace()).collect();
                    let bytes = Stream::base64(&text).array(self.packing, length, room).map_err(fail)?;
                    Cow::Owned(bytes.into_owned())
                } else {
                    Stream::base64(text).array(self.packing, length, room).map_err(fail)?
                }
            }
            "appended" => {
                let offset = self.count(node, "offset")?;
                let from = self.appended.and_then(|(is_base64, bytes)| Some((is_base64, bytes.get(offset..)?)));
                let (is_base64, bytes) = from.ok_or_else(|| fail("begins behind the end of the file".to_owned()))?;
                let mut stream = if is_base64 { Stream::base64(bytes) } else { Stream::raw(bytes) };
                stream.array(self.packing, length, room).map_err(fail)?
            }
            other => return Err(fail(format!("has the format \"{}\"", excerpt(other.as_bytes())))),
        };
        if bytes.len() % size != 0 {
            return Err(fail(format!("has {} bytes, which are no whole numbers of {size}", bytes.len())));
        }
        room.take((bytes.len() / size).saturating_mul(8)).map_err(fail)?;
        Ok(Values::Bytes { kind, bytes, is_big: self.packing.is_big })
    }
}

/// The numbers of an array, as they are in the file.
enum Values<'a> {
    Whole(Vec<i64>),
    Float(Vec<f64>),
    Bytes { kind: Kind, bytes: Cow<'a, [u8]>, is_big: bool },
}

impl Values<'_> {
    fn of_text(kind: Kind, text: &str) -> Result<Self, String> {
        fn parsed<T: std::str::FromStr>(text: &str) -> Result<Vec<T>, String> {
            let number =
                |word: &str| word.parse().map_err(|_| format!("has \"{}\" for a number", excerpt(word.as_bytes())));
            text.split_ascii_whitespace().map(number).collect()
        }
        Ok(if kind.is_whole() { Self::Whole(parsed(text)?) } else { Self::Float(parsed(text)?) })
    }

    fn len(&self) -> usize {
        match self {
            Self::Whole(numbers) => numbers.len(),
            Self::Float(numbers) => numbers.len(),
            Self::Bytes { kind, bytes, .. } => bytes.len() / kind.size(),
        }
    }

    fn numbers(self) -> Vec<f64> {
        match self {
            Self::Whole(whole) => whole.into_iter().map(|number| number as f64).collect(),
            Self::Float(numbers) => numbers,
            Self::Bytes { kind, bytes, is_big } => numbers(kind, &bytes, is_big),
        }
    }

    fn whole_numbers(self) -> Option<Vec<i64>> {
        match self {
            Self::Whole(numbers) => Some(numbers),
            Self::Float(_) => None,
            Self::Bytes { kind, bytes, is_big } => whole_numbers(kind, &bytes, is_big),
        }
    }
}

/// Whether what is behind the XML is base64, and where its first array can begin: behind the underscore.
fn appended_data(bytes: &[u8]) -> Result<Option<(bool, &[u8])>, Problem> {
    let Some(end) = bytes.iter().position(|byte| *byte == b'>') else {
        return if bytes.is_empty() { Ok(None) } else { Err(Problem::Truncated { within: "AppendedData" }) };
    };
    let (tag, data) = (&bytes[..end], &bytes[end + 1..]);
    let has = |word: &[u8]| tag.windows(word.len()).any(|window| window == word);
    let is_base64 = match (has(b"base64"), has(b"raw")) {
        (true, false) => true,
        (false, true) => false,
        _ => return Err(syntax("the encoding of AppendedData is neither raw nor base64")),
    };
    let data = data.trim_ascii_start().strip_prefix(b"_");
    let data = data.ok_or_else(|| syntax("no underscore is before the bytes of AppendedData"))?;
    Ok(Some((is_base64, data)))
}
