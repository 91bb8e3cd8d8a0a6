//! What can be wrong with a mesh file, said so that a user can put it right.

use std::fmt;
use std::io;

use estar_mesh::MeshError;
use thiserror::Error;

use crate::text::{LONGEST_NAME, steers};

/// Why a mesh file was not read.
#[derive(Debug, Error)]
pub enum ReadError {
    /// The file could not be opened or read at all.
    #[error("{file}: cannot be read: {source}")]
    Unreadable {
        /// The file.
        file: String,
        /// What the system says.
        source: io::Error,
    },
    /// The file was read, but what it says is no usable mesh.
    #[error("{file}{place}: {problem}")]
    Content {
        /// The file.
        file: String,
        /// Where in the file.
        place: Place,
        /// What is wrong and what to do.
        problem: Box<Problem>,
    },
}

impl ReadError {
    /// True when the file could not be opened or read, as against read and found bad.
    pub fn is_unreadable(&self) -> bool {
        matches!(self, ReadError::Unreadable { .. })
    }

    /// Where in the file, if it could be read.
    pub fn place(&self) -> Option<Place> {
        match self {
            ReadError::Unreadable { .. } => None,
            ReadError::Content { place, .. } => Some(*place),
        }
    }
}

/// Where in a file. Written so that it follows the file's name: `:12` or `, byte 40`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// A line, counted from 1.
    Line(u64),
    /// A byte of a binary file, counted from 0.
    Byte(u64),
    /// The file as a whole.
    File,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Line(line) => write!(f, ":{line}"),
            Place::Byte(byte) => write!(f, ", byte {byte}"),
            Place::File => Ok(()),
        }
    }
}

/// Elements of one kind that this program cannot use.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unsupported {
    /// What they are, as "4-node tetrahedra".
    pub kind: String,
    /// How many.
    pub count: u64,
    /// The number in the file of the first.
    pub first: u64,
    /// What to do about them.
    pub advice: &'static str,
}

/// What is wrong with a mesh file, and what to do.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum Problem {
    /// None of the formats.
    #[error("not a mesh this program knows; export Gmsh 4.1 or 2.2 (.msh), Abaqus (.inp), or VTK (.vtu, .vtk)")]
    UnknownFormat,
    /// A format that is known, but not read.
    #[error("this is {what}, which is not read; {advice}")]
    OtherFormat {
        /// What it is.
        what: &'static str,
        /// How it becomes a mesh that is read.
        advice: String,
    },
    /// Gmsh, but of another version.
    #[error("Gmsh format {version} is not supported; convert it: gmsh old.msh -save -format msh41 -o new.msh")]
    GmshVersion {
        /// The version.
        version: String,
    },
    /// A header that is none.
    #[error("bad Gmsh header: {what}; export the mesh again")]
    GmshHeader {
        /// What is wrong with it.
        what: String,
    },
    /// A binary file of a big-endian machine.
    #[error("the file is big-endian; save it as ASCII, or on a little-endian machine")]
    BigEndian,
    /// A data size other than 8.
    #[error("the file's data size is {size}, only 8 is supported; save it as ASCII, or with a 64-bit Gmsh")]
    DataSize {
        /// The size.
        size: u64,
    },
    /// The file ends too soon.
    #[error("the file ends in the middle of {within}; it is truncated: copy or export it again")]
    Truncated {
        /// What it ends in.
        within: &'static str,
    },
    /// A section ends too soon.
    #[error("{within}: the section ends before it has as many entries as it says")]
    SectionTooShort {
        /// Which part of the file.
        within: &'static str,
    },
    /// A section has more than it says.
    #[error("the section ${section} should end here, but \"{found}\" follows; its counts are wrong")]
    SectionTooLong {
        /// The section.
        section: String,
        /// What follows.
        found: String,
    },
    /// Something else where a section should start.
    #[error("expected a section such as $Nodes, found \"{found}\"")]
    NotASection {
        /// What is there.
        found: String,
    },
    /// A section twice.
    #[error("a second section ${section}; a mesh has one")]
    SecondSection {
        /// The section.
        section: &'static str,
    },
    /// A section that must be there is not.
    #[error("no section ${section}{before}; export the mesh again, with all of it")]
    MissingSection {
        /// The section.
        section: &'static str,
        /// " before ..." where order is what is wrong.
        before: &'static str,
    },
    /// A number that is none.
    #[error("{what}: expected a number, found \"{found}\"")]
    NotANumber {
        /// What should be there.
        what: &'static str,
        /// What is there.
        found: String,
    },
    /// A number that cannot be what it stands for.
    #[error("{what}: {value} is not possible here")]
    BadValue {
        /// What the number is.
        what: &'static str,
        /// The number.
        value: i128,
    },
    /// More entries than the file has room for.
    #[error("{what}: {count} are announced, but only {bytes} bytes of the file are left; it is truncated or damaged")]
    CountTooLarge {
        /// What.
        what: &'static str,
        /// How many are announced.
        count: u64,
        /// What is left of the file.
        bytes: u64,
    },
    /// A total that is not the sum of its parts.
    #[error("{announced} {what} are announced, but there are {found}; the file is damaged: export it again")]
    CountMismatch {
        /// "nodes" or "elements".
        what: &'static str,
        /// How many are announced.
        announced: u64,
        /// How many there are.
        found: u64,
    },
    /// A partitioned mesh.
    #[error("the mesh is partitioned; save it unpartitioned (Mesh > Unpartition)")]
    Partitioned,
    /// A name that is not text.
    #[error("a name is not valid UTF-8; rename the group")]
    NameNotUtf8,
    /// A name that no deck can write, and that could steer a terminal.
    #[error("the name {name:?} has a control character or a mark of the direction of writing; rename the group")]
    NameWithControl {
        /// The name.
        name: String,
    },
    /// A name that nobody can read.
    #[error("a name has {length} characters, where up to {LONGEST_NAME} are read; rename the group {beginning}...")]
    NameTooLong {
        /// How long it is.
        length: usize,
        /// How it begins.
        beginning: String,
    },
    /// A line that cannot be understood.
    #[error("{message}")]
    Syntax {
        /// What is wrong with it.
        message: String,
    },
    /// An element with a node that is not in the file.
    #[error("element {element} refers to node {node}, which the file does not have")]
    MissingNode {
        /// The element's number in the file.
        element: u64,
        /// The node's number in the file.
        node: u64,
    },
    /// A set or surface with a member that is not in the file.
    #[error("\"{group}\" refers to {what} {label}, which the file does not have{hint}")]
    MissingMember {
        /// The set or surface.
        group: Box<str>,
        /// "node", "element" or "set".
        what: &'static str,
        /// The number or name.
        label: Box<str>,
        /// What it has instead, if something is near.
        hint: Box<str>,
    },
    /// An element type that the format itself does not have, or that is beyond the usual ones.
    #[error(
        "element {element}: element type {code} is not supported; mesh with Mesh.ElementOrder = 1, or 2 for tetrahedra"
    )]
    UnknownElementType {
        /// The first element's number in the file.
        element: u64,
        /// The type's code in the format.
        code: i64,
    },
    /// Elements that cannot be used.
    #[error("unsupported elements: {}", list(.0))]
    UnsupportedElements(Vec<Unsupported>),
    /// Elements without which bodies come apart.
    #[error(
        "cohesive or gasket elements hold bodies together, and are not supported: {types} (the first is element {first}); \
         take them out and let the bodies have their nodes in common"
    )]
    Joints {
        /// How many of which type.
        types: String,
        /// The number of the first.
        first: u64,
    },
    /// Elements, but no solids.
    #[error("the mesh has no solid elements, only {types}; mesh its volume with hexahedra, wedges or tetrahedra")]
    NoSolids {
        /// How many of which type.
        types: String,
    },
    /// A Gmsh file without solids. Gmsh saves what is in a physical group, if there is any.
    #[error(
        "the file has no solid elements; mesh the volume (Mesh > 3D), and where the model has physical groups, which alone are saved, add \
         one of the volume (Physical Volume) or save all with Mesh.SaveAll = 1"
    )]
    NoVolume,
    /// Something legal in the format that is not supported here.
    #[error("{what} is not supported; {advice}")]
    NotSupported {
        /// What.
        what: String,
        /// What to do.
        advice: &'static str,
    },
    /// An array of VTK that is not as it should be.
    #[error("the array \"{array}\" {what}; the file is damaged: export it again")]
    Array {
        /// The array.
        array: String,
        /// What it has or does.
        what: String,
    },
    /// A cell of VTK with a point that is not there.
    #[error("cell {cell} refers to point {node}, but there are {count}, numbered from 0")]
    NoSuchPoint {
        /// The cell, counted from 0.
        cell: u64,
        /// The point.
        node: String,
        /// How many points there are.
        count: usize,
    },
    /// A cell of VTK with more or fewer points than its type has.
    #[error("cell {cell} has {found} points, which {kind} cannot have; the file is damaged: export it again")]
    CellSize {
        /// The cell, counted from 0.
        cell: u64,
        /// What it should be.
        kind: String,
        /// How many points it has.
        found: usize,
    },
    /// More bytes, with all files that the mesh includes, than there is memory for.
    #[error(
        "the mesh, with all that it includes or is unpacked to, has more than {} MB, which is what memory is left for; take a \
         coarser mesh or a machine with more memory, or end other programs",
        limit / 1_000_000
    )]
    NoMemory {
        /// The bytes that there may be.
        limit: u64,
    },
    /// Parts that do not make a mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

fn list(unsupported: &[Unsupported]) -> String {
    let one = |u: &Unsupported| format!("{} {} (the first is element {}): {}", u.count, u.kind, u.first, u.advice);
    unsupported.iter().map(one).collect::<Vec<_>>().join("; ")
}

/// A problem and where it is, before the file's name is known.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Located {
    /// Which of the files that make up the mesh; 0 is the file itself.
    pub source: u32,
    pub place: Place,
    pub problem: Problem,
}

impl Located {
    pub fn in_file(self, file: &str) -> ReadError {
        ReadError::Content { file: file.to_owned(), place: self.place, problem: Box::new(self.problem) }
    }
}

impl Problem {
    pub(crate) fn at(self, place: Place) -> Located {
        Located { source: 0, place, problem: self }
    }
}

/// The first few of a list, and how many there are beside them.
pub(crate) fn and_more(list: impl IntoIterator<Item = String>) -> String {
    const MOST_SHOWN: usize = 5;
    let mut list = list.into_iter();
    let shown = list.by_ref().take(MOST_SHOWN).collect::<Vec<_>>().join(", ");
    match list.count() {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

/// A name that can be shown as it is.
pub(crate) fn visible_name(name: &str) -> Result<String, Problem> {
    let length = name.chars().count();
    if length > LONGEST_NAME {
        return Err(Problem::NameTooLong { length, beginning: name.chars().take(20).collect() });
    }
    if name.contains(steers) {
        return Err(Problem::NameWithControl { name: name.to_owned() });
    }
    Ok(name.to_owned())
}

/// A short, printable form of bytes from a file.
pub(crate) fn excerpt(bytes: &[u8]) -> String {
    const LONGEST: usize = 40;
    let text: String = String::from_utf8_lossy(&bytes[..bytes.len().min(4 * LONGEST)])
        .chars()
        .take_while(|c| !matches!(c, '\n' | '\r'))
        .map(|c| if steers(c) { '\u{fffd}' } else { c })
        .collect();
    if text.chars().count() > LONGEST { text.chars().take(LONGEST).chain("...".chars()).collect() } else { text }
}
