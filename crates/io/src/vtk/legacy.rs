//! `.vtk`: VTK's file of lines with keywords, whose arrays are text or big-endian bytes.
//!
//! The format: <https://docs.vtk.org/en/latest/vtk_file_formats/vtk_legacy_file_format.html>, with what VTK itself writes
//! beside it: `FIELD` before the points, `OFFSETS` and `CONNECTIVITY` of version 5, `METADATA`, names with `%20`.

use super::binary::{Kind, numbers, whole_numbers};
use super::{Numbers, Piece};
use crate::error::{Located, Place, Problem, excerpt};
use crate::other_format::other_vtk;

/// The grid and the format in words.
pub(super) fn read(bytes: &[u8]) -> Result<(Piece, String), Located> {
    let mut reader = Reader { bytes, at: 0, line: 1, is_binary: false };
    let version = reader.line();
    let version = excerpt(version.split(|byte| *byte == b' ').next_back().unwrap_or_default());
    reader.line();
    reader.is_binary = match reader.line().to_ascii_uppercase().as_slice() {
        b"ASCII" => false,
        b"BINARY" => true,
        _ => return Err(reader.syntax("the third line of a VTK file is ASCII or BINARY")),
    };
    let encoding = if reader.is_binary { "binary" } else { "ASCII" };
    Ok((reader.grid()?, format!("VTK {version}, {encoding}")))
}

/// What the arrays that follow belong to.
#[derive(Clone, Copy)]
enum Owner {
    Nothing,
    Nodes(usize),
    Cells(usize),
}

/// The type of the numbers of an array.
#[derive(Clone, Copy)]
enum Type {
    Of(Kind),
    Bits,
    Texts,
}

impl Type {
    fn of(name: &[u8]) -> Option<Self> {
        Some(Self::Of(match name.to_ascii_lowercase().as_slice() {
            b"char" | b"signed_char" | b"vtktypeint8" => Kind::Signed(1),
            b"unsigned_char" | b"vtktypeuint8" => Kind::Unsigned(1),
            b"short" | b"vtktypeint16" => Kind::Signed(2),
            b"unsigned_short" | b"vtktypeuint16" => Kind::Unsigned(2),
            // VTK writes its own type of ids with four bytes
            b"int" | b"vtktypeint32" | b"vtkidtype" => Kind::Signed(4),
            b"unsigned_int" | b"vtktypeuint32" => Kind::Unsigned(4),
            b"long" | b"long_long" | b"vtktypeint64" => Kind::Signed(8),
            b"unsigned_long" | b"unsigned_long_long" | b"vtktypeuint64" => Kind::Unsigned(8),
            b"float" => Kind::Float(4),
            b"double" => Kind::Float(8),
            b"bit" => return Some(Self::Bits),
            b"string" => return Some(Self::Texts),
            _ => return None,
        }))
    }
}

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u64,
    is_binary: bool,
}

impl<'a> Reader<'a> {
    fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    fn fail(&self, problem: Problem) -> Located {
        // lines cannot be counted through bytes
        problem.at(if self.is_binary { Place::Byte(self.at as u64) } else { Place::Line(self.line) })
    }

    fn syntax(&self, message: impl Into<String>) -> Located {
        self.fail(Problem::Syntax { message: message.into() })
    }

    fn truncated(&self, within: &'static str) -> Located {
        self.fail(Problem::Truncated { within })
    }

    fn advance(&mut self, count: usize) {
        self.line += self.bytes[self.at..self.at + count].iter().filter(|byte| **byte == b'\n').count() as u64;
        self.at += count;
    }

    /// The rest of the line, which is passed over with its end.
    fn line(&mut self) -> &'a [u8] {
        let rest = self.rest();
        let end = rest.iter().position(|byte| *byte == b'\n');
        let line = &rest[..end.unwrap_or(rest.len())];
        self.advance(end.map_or(rest.len(), |end| end + 1));
        line.trim_ascii()
    }

    fn skip_white_space(&mut self) {
        let count = self.rest().iter().take_while(|byte| byte.is_ascii_whitespace()).count();
        self.advance(count);
    }

    /// The next word, across lines; empty at the end of the file.
    fn word(&mut self) -> &'a [u8] {
        self.skip_white_space();
        let rest = self.rest();
        let length = rest.iter().take_while(|byte| !byte.is_ascii_whitespace()).count();
        self.at += length;
        &rest[..length]
    }

    /// The words of the next line that has any, the first in capitals; empty at the end of the file.
    fn keyword(&mut self) -> (Vec<u8>, Vec<&'a [u8]>) {
        self.skip_white_space();
        let mut words = self.line().split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        (words.next().unwrap_or_default().to_ascii_uppercase(), words.collect())
    }

    fn count(&self, words: &[&[u8]], place: usize, what: &'static str) -> Result<usize, Located> {
        let word = words.get(place).copied().unwrap_or_default();
        let number = std::str::from_utf8(word).ok().and_then(|text| text.parse().ok());
        number.ok_or_else(|| self.fail(Problem::NotANumber { what, found: excerpt(word) }))
    }

    fn type_of(&self, words: &[&[u8]], place: usize) -> Result<Type, Located> {
        let word = words.get(place).copied().unwrap_or_default();
        Type::of(word).ok_or_else(|| self.syntax(format!("\"{}\" is no type of numbers of VTK", excerpt(word))))
    }

    fn grid(&mut self) -> Result<Piece, Located> {
        let mut piece = Piece::default();
        let mut owner = Owner::Nothing;
        let (mut has_points, mut has_cells, mut has_types) = (false, false, false);
        loop {
            let (keyword, words) = self.keyword();
            match keyword.as_slice() {
                b"" => break,
                b"DATASET" => match words.first().map(|word| word.to_ascii_uppercase()).as_deref() {
                    Some(b"UNSTRUCTURED_GRID") => {}
                    other => return Err(self.fail(other_vtk(&excerpt(other.unwrap_or_default())))),
                },
                b"POINTS" => {
                    let count = self.count(&words, 0, "the number of points")?;
                    let of_type = self.type_of(&words, 1)?;
                    let numbers = self.numbers(of_type, self.times(count, 3)?)?;
                    piece.points = numbers.as_chunks::<3>().0.to_vec();
                    has_points = true;
                }
                b"CELLS" => {
                    let [first, second] = [0, 1].map(|place| self.count(&words, place, "the number of cells"));
                    (piece.ends, piece.connectivity) = self.cells(first?, second?)?;
                    has_cells = true;
                }
                b"CELL_TYPES" => {
                    let count = self.count(&words, 0, "the number of cell types")?;
                    piece.types = self.whole_numbers(Kind::Signed(4), count)?;
                    has_types = true;
                }
                b"CELL_DATA" => owner = Owner::Cells(self.count(&words, 0, "the number of cells")?),
                b"POINT_DATA" => owner = Owner::Nodes(self.count(&words, 0, "the number of points")?),
                b"METADATA" => while !self.line().is_empty() {},
                b"FIELD" => {
                    for _ in 0..self.count(&words, 1, "the number of arrays")? {
                        self.field_array(owner, &mut piece)?;
                    }
                }
                other => self.attribute(other, &words, owner, &mut piece)?,
            }
        }
        for (is_there, section) in [(has_points, "POINTS"), (has_cells, "CELLS"), (has_types, "CELL_TYPES")] {
            if !is_there {
                return Err(self.truncated(section));
            }
        }
        Ok(piece)
    }

    fn times(&self, count: usize, factor: usize) -> Result<usize, Located> {
        let bytes = self.rest().len() as u64;
        let too_large = || self.fail(Problem::CountTooLarge { what: "numbers", count: count as u64, bytes });
        count.checked_mul(factor).ok_or_else(too_large)
    }

    /// Where the nodes of each cell end, and the nodes.
    fn cells(&mut self, first: usize, second: usize) -> Result<(Vec<i64>, Vec<i64>), Located> {
        self.skip_white_space_of_text();
        let is_new = self.rest().get(..7).is_some_and(|word| word.eq_ignore_ascii_case(b"OFFSETS"));
        if is_new {
            // version 5: the first offset is 0, the others are the ends
            let mut ends = self.named_numbers(b"OFFSETS", first)?;
            if !ends.is_empty() {
                ends.remove(0);
            }
            return Ok((ends, self.named_numbers(b"CONNECTIVITY", second)?));
        }
        let mut words = self.whole_numbers(Kind::Signed(4), second)?;
        // the nodes move up over the counts before them, so that there is one list only
        let (mut ends, mut to, mut from) = (Vec::new(), 0, 0);
        while let Some(&count) = words.get(from) {
            let end = usize::try_from(count).ok().and_then(|count| (from + 1).checked_add(count));
            let Some(end) = end.filter(|end| *end <= words.len()) else {
                return Err(
                    self.syntax(format!("a cell of {count} nodes does not fit into CELLS; the file is damaged"))
                );
            };
            words.copy_within(from + 1..end, to);
            to += end - from - 1;
            ends.push(to as i64);
            from = end;
        }
        words.truncate(to);
        if ends.len() != first {
            let (announced, found) = (first as u64, ends.len() as u64);
            return Err(self.fail(Problem::CountMismatch { what: "cells", announced, found }));
        }
        Ok((ends, words))
    }

    /// In binary files a byte of white space may be a number.
    fn skip_white_space_of_text(&mut self) {
        if !self.is_binary {
            self.skip_white_space();
        }
    }

    fn named_numbers(&mut self, name: &'static [u8], count: usize) -> Result<Vec<i64>, Located> {
        let (keyword, words) = self.keyword();
        match self.type_of(&words, 0)? {
            Type::Of(kind) if keyword == name => self.whole_numbers(kind, count),
            _ => Err(self.syntax(format!("expected {}, found {}", excerpt(name), excerpt(&keyword)))),
        }
    }

    fn field_array(&mut self, owner: Owner, piece: &mut Piece) -> Result<(), Located> {
        let (name, words) = loop {
            self.skip_white_space();
            let mut words = self.line().split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
            match (words.next(), words.collect::<Vec<_>>()) {
                (None, _) => return Err(self.truncated("FIELD")),
                (Some(b"METADATA"), _) => while !self.line().is_empty() {},
                (Some(name), words) => break (name, words),
            }
        };
        let components = self.count(&words, 0, "the number of components")?;
        let tuples = self.count(&words, 1, "the number of tuples")?;
        let of_type = self.type_of(&words, 2)?;
        self.array(name, of_type, components, tuples, owner, piece)
    }

    /// Arrays that have a keyword of their own.
    fn attribute(
        &mut self,
        keyword: &[u8],
        words: &[&'a [u8]],
        owner: Owner,
        piece: &mut Piece,
    ) -> Result<(), Located> {
        let tuples = match owner {
            Owner::Nodes(count) | Owner::Cells(count) => count,
            Owner::Nothing => {
                return Err(self.syntax(format!("expected a section such as POINTS, found \"{}\"", excerpt(keyword))));
            }
        };
        let name = words.first().copied().unwrap_or_default();
        let of_bytes = if self.is_binary { Type::Of(Kind::Unsigned(1)) } else { Type::Of(Kind::Float(4)) };
        let (of_type, components) = match keyword {
            b"SCALARS" => {
                let components = if words.len() > 2 { self.count(words, 2, "the number of components")? } else { 1 };
                let of_type = self.type_of(words, 1)?;
                let start = (self.at, self.line);
                if self.keyword().0 != b"LOOKUP_TABLE" {
                    (self.at, self.line) = start;
                }
                (of_type, components)
            }
            b"VECTORS" | b"NORMALS" => (self.type_of(words, 1)?, 3),
            b"TENSORS" => (self.type_of(words, 1)?, 9),
            b"TENSORS6" => (self.type_of(words, 1)?, 6),
            b"GLOBAL_IDS" | b"PEDIGREE_IDS" | b"EDGE_FLAGS" => (self.type_of(words, 1)?, 1),
            b"TEXTURE_COORDINATES" => (self.type_of(words, 2)?, self.count(words, 1, "the number of components")?),
            b"COLOR_SCALARS" => (of_bytes, self.count(words, 1, "the number of components")?),
            b"LOOKUP_TABLE" => {
                let entries = self.count(words, 1, "the number of colours")?;
                return self.array(name, of_bytes, 4, entries, Owner::Nothing, piece);
            }
            other => return Err(self.syntax(format!("\"{}\" is no keyword of VTK that is known here", excerpt(other)))),
        };
        self.array(name, of_type, components, tuples, owner, piece)
    }

    /// Reads an array of the piece, or passes over it.
    fn array(
        &mut self,
        name: &[u8],
        of_type: Type,
        components: usize,
        tuples: usize,
        owner: Owner,
        piece: &mut Piece,
    ) -> Result<(), Located> {
        let count = self.times(tuples, components)?;
        let name = with_blanks(name);
        let values = match of_type {
            Type::Of(kind) if kind.is_whole() && components == 1 => self.whole_numbers(kind, count)?,
            _ => {
                self.skip(of_type, count)?;
                if !matches!(owner, Owner::Nothing) {
                    piece.passed_over.push(name);
                }
                return Ok(());
            }
        };
        match owner {
            Owner::Nodes(_) => piece.node_arrays.push(Numbers { name, values }),
            Owner::Cells(_) => piece.cell_arrays.push(Numbers { name, values }),
            Owner::Nothing => {}
        }
        Ok(())
    }

    /// The bytes of so many numbers of a binary file.
    fn take(&mut self, size: usize, count: usize) -> Result<&'a [u8], Located> {
        let left = self.rest().len() as u64;
        let taken = count.checked_mul(size).and_then(|length| self.rest().get(..length));
        let taken = taken
            .ok_or_else(|| self.fail(Problem::CountTooLarge { what: "numbers", count: count as u64, bytes: left }))?;
        self.at += taken.len();
        Ok(taken)
    }

    fn skip(&mut self, of_type: Type, count: usize) -> Result<(), Located> {
        match of_type {
            Type::Of(kind) if self.is_binary => self.take(kind.size(), count).map(|_| ()),
            Type::Bits if self.is_binary => self.take(1, count.div_ceil(8)).map(|_| ()),
            Type::Texts if self.is_binary => (0..count).try_for_each(|_| self.skip_text()),
            Type::Texts => (0..count).try_for_each(|_| match self.rest() {
                [] => Err(self.truncated("an array")),
                _ => {
                    self.line();
                    Ok(())
                }
            }),
            _ => (0..count).try_for_each(|_| match self.word() {
                [] => Err(self.truncated("an array")),
                _ => Ok(()),
            }),
        }
    }

    /// A text of a binary file: its length comes first, in 1, 2, 4 or 8 bytes, as the two highest bits say.
    fn skip_text(&mut self) -> Result<(), Located> {
        let first = *self.rest().first().ok_or_else(|| self.truncated("a text"))?;
        let size = [8, 4, 2, 1][usize::from(first >> 6)];
        let head = self.take(1, size)?;
        let length = head.iter().fold(0_u64, |length, byte| length << 8 | u64::from(*byte));
        let length = length & ((1 << (8 * size - 2)) - 1);
        let length = usize::try_from(length).map_err(|_| self.truncated("a text"))?;
        self.take(1, length).map(|_| ())
    }

    fn parsed<T: std::str::FromStr>(&mut self, count: usize) -> Result<Vec<T>, Located> {
        // a number and what parts it from the next take two bytes
        if count > self.rest().len() / 2 + 1 {
            let bytes = self.rest().len() as u64;
            return Err(self.fail(Problem::CountTooLarge { what: "numbers", count: count as u64, bytes }));
        }
        let mut numbers = Vec::with_capacity(count);
        for _ in 0..count {
            let word = self.word();
            let number = std::str::from_utf8(word).ok().and_then(|text| text.parse().ok());
            match number {
                Some(number) => numbers.push(number),
                None if word.is_empty() => return Err(self.truncated("an array")),
                None => {
                    return Err(self.fail(Problem::NotANumber { what: "a number of an array", found: excerpt(word) }));
                }
            }
        }
        Ok(numbers)
    }

    fn whole_numbers(&mut self, kind: Kind, count: usize) -> Result<Vec<i64>, Located> {
        if !self.is_binary {
            return self.parsed(count);
        }
        let bytes = self.take(kind.size(), count)?;
        whole_numbers(kind, bytes, true)
            .ok_or_else(|| self.syntax("an array has numbers that are not whole, or beyond 2^63"))
    }

    fn numbers(&mut self, of_type: Type, count: usize) -> Result<Vec<f64>, Located> {
        let Type::Of(kind) = of_type else {
            return Err(self.syntax("points have coordinates of the type float or double"));
        };
        if !self.is_binary {
            return self.parsed(count);
        }
        Ok(numbers(kind, self.take(kind.size(), count)?, true))
    }
}

/// A name as it was before VTK wrote `%20` for a blank, and so on.
fn with_blanks(name: &[u8]) -> String {
    let hex = |byte: &u8| char::from(*byte).to_digit(16);
    let mut decoded = Vec::with_capacity(name.len());
    let mut rest = name;
    while let Some((&byte, others)) = rest.split_first() {
        let code = match (byte, others) {
            (b'%', [high, low, ..]) => hex(high).zip(hex(low)).map(|(high, low)| (16 * high + low) as u8),
            _ => None,
        };
        decoded.push(code.unwrap_or(byte));
        rest = if code.is_some() { &others[2..] } else { others };
    }
    String::from_utf8_lossy(&decoded).into_owned()
}
