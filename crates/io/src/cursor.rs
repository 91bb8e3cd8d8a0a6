//! A place in a Gmsh file that moves forward over numbers, whether they are text or bytes.

use crate::error::{Located, Place, Problem, excerpt};

/// Reads numbers from a file, ASCII or little-endian binary, and never past its end.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u64,
    pub binary: bool,
    /// The part of the file that messages name.
    pub within: &'static str,
}

impl<'a> Cursor<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, line: 1, binary: false, within: "the header" }
    }

    pub fn place(&self) -> Place {
        if self.binary { Place::Byte(self.at as u64) } else { Place::Line(self.line) }
    }

    /// The place of the next number.
    pub fn next_place(mut self) -> Place {
        if !self.binary {
            self.skip_white_space();
        }
        self.place()
    }

    pub fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    fn remaining(&self) -> u64 {
        (self.bytes.len() - self.at) as u64
    }

    pub fn fail(&self, problem: Problem) -> Located {
        problem.at(self.place())
    }

    fn advance(&mut self, byte_count: usize) {
        if !self.binary {
            self.line += self.bytes[self.at..self.at + byte_count].iter().filter(|byte| **byte == b'\n').count() as u64;
        }
        self.at += byte_count;
    }

    pub fn skip_white_space(&mut self) {
        let count = self.rest().iter().take_while(|byte| byte.is_ascii_whitespace()).count();
        self.advance(count);
    }

    /// The rest of the line, without its end, which is passed over.
    pub fn line(&mut self) -> &'a [u8] {
        let rest = self.rest();
        let (length, end) = match rest.iter().position(|byte| *byte == b'\n') {
            Some(end) => (end, end + 1),
            None => (rest.len(), rest.len()),
        };
        self.advance(end);
        rest[..length].trim_ascii()
    }

    /// Passes over everything up to and including the line `end`.
    pub fn skip_past(&mut self, end: &[u8]) -> Result<(), Located> {
        let found = self.rest().windows(end.len()).position(|window| window == end);
        let Some(found) = found else { return Err(self.fail(Problem::Truncated { within: self.within })) };
        self.advance(found);
        self.line();
        Ok(())
    }

    fn token(&mut self) -> Result<&'a [u8], Located> {
        self.skip_white_space();
        let rest = self.rest();
        let length = rest.iter().take_while(|byte| !byte.is_ascii_whitespace()).count();
        let token = &rest[..length];
        match token.first() {
            None => Err(self.fail(Problem::Truncated { within: self.within })),
            Some(b'$') => Err(self.fail(Problem::SectionTooShort { within: self.within })),
            Some(_) => {
                self.at += length;
                Ok(token)
            }
        }
    }

    fn parsed<T: std::str::FromStr>(&mut self, what: &'static str) -> Result<T, Located> {
        let token = self.token()?;
        let number = std::str::from_utf8(token).ok().and_then(|text| text.parse().ok());
        number.ok_or_else(|| self.fail(Problem::NotANumber { what, found: excerpt(token) }))
    }

    fn array<const SIZE: usize>(&mut self) -> Result<[u8; SIZE], Located> {
        let Some(&array) = self.rest().first_chunk() else {
            return Err(self.fail(Problem::Truncated { within: self.within }));
        };
        self.at += SIZE;
        Ok(array)
    }

    /// A count or a label: `size_t` of the format.
    pub fn size(&mut self, what: &'static str) -> Result<u64, Located> {
        if self.binary { Ok(u64::from_le_bytes(self.array()?)) } else { self.parsed(what) }
    }

    /// `int` of the format.
    pub fn int(&mut self, what: &'static str) -> Result<i32, Located> {
        if self.binary { Ok(i32::from_le_bytes(self.array()?)) } else { self.parsed(what) }
    }

    /// `double` of the format.
    pub fn double(&mut self, what: &'static str) -> Result<f64, Located> {
        if self.binary { Ok(f64::from_le_bytes(self.array()?)) } else { self.parsed(what) }
    }

    /// Passes over `count` entries of `size` bytes each, or of `numbers` words each.
    pub fn skip(&mut self, what: &'static str, count: u64, numbers: u64, size: u64) -> Result<(), Located> {
        self.check_room(what, count, numbers, size)?;
        if self.binary {
            // Fits: the room was checked.
            self.at += (count * size) as usize;
        } else {
            for _ in 0..count * numbers {
                self.token()?;
            }
        }
        Ok(())
    }

    /// An error unless the rest of the file has room for `count` entries, so that a bad count costs nothing.
    pub fn check_room(&self, what: &'static str, count: u64, numbers: u64, size: u64) -> Result<(), Located> {
        // A word of text and the space before it take two bytes.
        let least = if self.binary { size } else { 2 * numbers };
        match count.checked_mul(least) {
            Some(needed) if needed <= self.remaining() + 1 && needed <= i64::MAX as u64 => {
                if self.binary && needed > self.remaining() {
                    return Err(self.fail(Problem::Truncated { within: self.within }));
                }
                Ok(())
            }
            _ => Err(self.fail(Problem::CountTooLarge { what, count, bytes: self.remaining() })),
        }
    }
}
