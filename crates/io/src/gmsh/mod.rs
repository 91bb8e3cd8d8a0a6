//! Gmsh meshes: formats 4.1, 4.0 and 2.2, each as text or bytes.

mod element_type;
mod groups;
mod v22;
mod v4;
mod write;

pub use write::{write_gmsh, write_gmsh_file};

use crate::MeshFile;
use crate::cursor::Cursor;
use crate::error::{Located, Place, Problem, excerpt};

/// Reads a Gmsh file of any supported version.
pub(crate) fn read(bytes: &[u8]) -> Result<MeshFile, Located> {
    let mut cursor = Cursor::new(bytes);
    cursor.skip_white_space();
    let first_line = cursor.line();
    if first_line != b"$MeshFormat" {
        return Err(match first_line {
            b"$NOD" => Problem::GmshVersion { version: "1".into() }.at(Place::Line(1)),
            _ => Problem::UnknownFormat.at(Place::File),
        });
    }
    let header_place = cursor.place();
    let header = String::from_utf8_lossy(cursor.line());
    let bad = |what: &str| Problem::GmshHeader { what: what.to_owned() }.at(header_place);
    let mut words = header.split_ascii_whitespace();
    let (Some(version), Some(file_type), Some(data_size), None) =
        (words.next(), words.next(), words.next(), words.next())
    else {
        return Err(bad("the line after $MeshFormat must be version, file type and data size"));
    };
    let binary = match file_type {
        "0" => false,
        "1" => true,
        _ => return Err(bad("the file type must be 0 (ASCII) or 1 (binary)")),
    };
    let size = data_size.parse().map_err(|_| bad("the data size must be a number"))?;
    if size != 8 {
        return Err(Problem::DataSize { size }.at(header_place));
    }
    if !matches!(version, "4.1" | "4" | "4.0" | "2" | "2.0" | "2.1" | "2.2") {
        return Err(Problem::GmshVersion { version: excerpt(version.as_bytes()) }.at(header_place));
    }
    if binary {
        cursor.binary = true;
        match cursor.int("the byte-order mark")? {
            1 => {}
            one if one == 1_i32.swap_bytes() => return Err(Problem::BigEndian.at(header_place)),
            _ => return Err(bad("the byte-order mark of a binary file must be 1")),
        }
    }
    section_end(&mut cursor, "MeshFormat")?;

    let encoding = if binary { "binary" } else { "ASCII" };
    match version {
        "4.1" => v4::read(cursor, v4::Version::V41, format!("Gmsh 4.1, {encoding}")),
        "4" | "4.0" => v4::read(cursor, v4::Version::V40, format!("Gmsh 4.0, {encoding}")),
        _ => v22::read(cursor, format!("Gmsh {version}, {encoding}")),
    }
}

/// Passes over the line that ends a section.
fn section_end(cursor: &mut Cursor, section: &str) -> Result<(), Located> {
    cursor.skip_white_space();
    let at = *cursor;
    let line = cursor.line();
    match line.strip_prefix(b"$End") {
        Some(name) if name == section.as_bytes() => Ok(()),
        _ if line.is_empty() => Err(at.fail(Problem::Truncated { within: at.within })),
        _ => Err(at.fail(Problem::SectionTooLong { section: section.to_owned(), found: excerpt(line) })),
    }
}

/// The name of the next section, or none at the end of the file.
fn next_section<'a>(cursor: &mut Cursor<'a>) -> Result<Option<&'a [u8]>, Located> {
    cursor.skip_white_space();
    let at = *cursor;
    let line = cursor.line();
    match line.strip_prefix(b"$") {
        Some(name) if !name.is_empty() && !name.starts_with(b"End") => Ok(Some(name)),
        None if line.is_empty() => Ok(None),
        _ => Err(at.fail(Problem::NotASection { found: excerpt(line) })),
    }
}

/// Passes over a section of no interest.
fn skip_section(cursor: &mut Cursor, name: &[u8]) -> Result<(), Located> {
    cursor.within = "a section that is passed over";
    cursor.skip_past(&[b"$End", name].concat())
}
