//! Arrays of VTK's XML as bytes: base64 or raw, whole or in compressed blocks; and numbers of bytes.
//!
//! Counts of the file are compared with what is left of it before memory is taken for them.

use std::borrow::Cow;
use std::io::Read;

use base64::Engine;
use base64::engine::general_purpose::{GeneralPurpose, GeneralPurposeConfig};
use flate2::read::ZlibDecoder;

/// The type of the numbers of an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Signed(usize),
    Unsigned(usize),
    Float(usize),
}

impl Kind {
    /// The type by its name in XML, as "UInt8".
    pub fn of_xml(name: &str) -> Option<Self> {
        Some(match name {
            "Int8" => Self::Signed(1),
            "Int16" => Self::Signed(2),
            "Int32" => Self::Signed(4),
            "Int64" => Self::Signed(8),
            "UInt8" => Self::Unsigned(1),
            "UInt16" => Self::Unsigned(2),
            "UInt32" => Self::Unsigned(4),
            "UInt64" => Self::Unsigned(8),
            "Float32" => Self::Float(4),
            "Float64" => Self::Float(8),
            _ => return None,
        })
    }

    /// Bytes of a number.
    pub fn size(self) -> usize {
        match self {
            Self::Signed(size) | Self::Unsigned(size) | Self::Float(size) => size,
        }
    }

    pub fn is_whole(self) -> bool {
        !matches!(self, Self::Float(_))
    }
}

/// The numbers of bytes, each made by `of` of the bytes of one, the lowest first.
fn each<const SIZE: usize, T>(bytes: &[u8], is_big: bool, of: impl Fn([u8; SIZE]) -> T) -> Vec<T> {
    let (chunks, _) = bytes.as_chunks::<SIZE>();
    let ordered = |mut chunk: [u8; SIZE]| {
        if is_big {
            chunk.reverse();
        }
        chunk
    };
    chunks.iter().map(|chunk| of(ordered(*chunk))).collect()
}

/// Numbers of bytes, if they are whole and not beyond 2⁶³.
pub(super) fn whole_numbers(kind: Kind, bytes: &[u8], is_big: bool) -> Option<Vec<i64>> {
    Some(match kind {
        Kind::Signed(1) => each(bytes, is_big, |b| i64::from(i8::from_le_bytes(b))),
        Kind::Signed(2) => each(bytes, is_big, |b| i64::from(i16::from_le_bytes(b))),
        Kind::Signed(4) => each(bytes, is_big, |b| i64::from(i32::from_le_bytes(b))),
        Kind::Signed(_) => each(bytes, is_big, i64::from_le_bytes),
        Kind::Unsigned(1) => each(bytes, is_big, |b| i64::from(u8::from_le_bytes(b))),
        Kind::Unsigned(2) => each(bytes, is_big, |b| i64::from(u16::from_le_bytes(b))),
        Kind::Unsigned(4) => each(bytes, is_big, |b| i64::from(u32::from_le_bytes(b))),
        Kind::Unsigned(_) => {
            let numbers = each(bytes, is_big, i64::from_le_bytes);
            return numbers.iter().all(|number| *number >= 0).then_some(numbers);
        }
        Kind::Float(_) => return None,
    })
}

/// Numbers of bytes.
pub(super) fn numbers(kind: Kind, bytes: &[u8], is_big: bool) -> Vec<f64> {
    match kind {
        Kind::Float(4) => each(bytes, is_big, |b| f64::from(f32::from_le_bytes(b))),
        Kind::Float(_) => each(bytes, is_big, f64::from_le_bytes),
        _ => whole_numbers(kind, bytes, is_big).unwrap_or_default().into_iter().map(|number| number as f64).collect(),
    }
}

/// Bytes that a file may be unpacked into.
///
/// Meshes of this program's generators have 2 to 12 times their compressed file; zlib alone could make a thousand times.
#[derive(Debug)]
pub(super) struct Room(u64);

impl Room {
    pub fn of_file(length: usize, limit: u64) -> Self {
        const MOST_UNPACKED: u64 = 64;
        /// The head of a small file is most of it.
        const ALWAYS: u64 = 1 << 20;
        Self((MOST_UNPACKED * length as u64).max(ALWAYS).min(limit))
    }

    pub fn take(&mut self, bytes: usize) -> Result<(), String> {
        let left = self
            .0
            .checked_sub(bytes as u64)
            .ok_or("has more numbers than such a file can hold, or than memory is left for")?;
        self.0 = left;
        Ok(())
    }
}

/// How the numbers of a file are packed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Packing {
    pub is_big: bool,
    /// Bytes of a word in the head of an array.
    pub word: usize,
    pub compressor: Option<Compressor>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Compressor {
    Zlib,
    Lz4,
}

/// Bytes one after another, raw or in base64.
pub(super) struct Stream<'a> {
    rest: &'a [u8],
    is_base64: bool,
    /// What was decoded and not yet taken.
    ahead: Vec<u8>,
}

/// Some programs leave bits behind the last byte.
const BASE64: GeneralPurpose =
    GeneralPurpose::new(&base64::alphabet::STANDARD, GeneralPurposeConfig::new().with_decode_allow_trailing_bits(true));

const ENDS: &str = "goes on behind the end of the file";

impl<'a> Stream<'a> {
    pub fn raw(bytes: &'a [u8]) -> Self {
        Self { rest: bytes, is_base64: false, ahead: Vec::new() }
    }

    /// Base64, without white space.
    pub fn base64(text: &'a [u8]) -> Self {
        Self { rest: text, is_base64: true, ahead: Vec::new() }
    }

    /// Bytes that are left, at most.
    fn left(&self) -> usize {
        if self.is_base64 { self.ahead.len() + self.rest.len() / 4 * 3 } else { self.rest.len() }
    }

    /// The next bytes. Base64 may be padded wherever a program has begun anew, as behind the head of an array.
    fn take(&mut self, count: usize) -> Result<Cow<'a, [u8]>, String> {
        if count > self.left() {
            return Err(ENDS.to_owned());
        }
        if !self.is_base64 {
            let (taken, rest) = self.rest.split_at_checked(count).ok_or(ENDS)?;
            self.rest = rest;
            return Ok(Cow::Borrowed(taken));
        }
        let mut taken = std::mem::take(&mut self.ahead);
        while taken.len() < count {
            let wanted = ((count - taken.len()).div_ceil(3) * 4).min(self.rest.len());
            let padded = self.rest[..wanted].iter().position(|byte| *byte == b'=').map(|at| at / 4 * 4 + 4);
            let (text, rest) = self.rest.split_at_checked(padded.unwrap_or(wanted)).ok_or(ENDS)?;
            if text.is_empty() {
                return Err(ENDS.to_owned());
            }
            BASE64.decode_vec(text, &mut taken).map_err(|error| format!("is no base64: {error}"))?;
            self.rest = rest;
        }
        self.ahead = taken.split_off(count);
        Ok(Cow::Owned(taken))
    }

    fn word(&mut self, packing: Packing) -> Result<usize, String> {
        let bytes = self.take(packing.word)?;
        let mut word = [0; 8];
        for (to, from) in word.iter_mut().zip(bytes.iter()) {
            *to = *from;
        }
        if packing.is_big {
            word[..packing.word].reverse();
        }
        usize::try_from(u64::from_le_bytes(word)).map_err(|_| ENDS.to_owned())
    }

    /// The bytes of the array that begins here, of which there must be `expected` unless the array itself is to say.
    pub fn array(
        &mut self,
        packing: Packing,
        expected: Option<usize>,
        room: &mut Room,
    ) -> Result<Cow<'a, [u8]>, String> {
        let Some(compressor) = packing.compressor else {
            let length = self.word(packing)?;
            is_as_long(length, expected)?;
            return self.take(length);
        };
        let [count, block, rest] = [self.word(packing)?, self.word(packing)?, self.word(packing)?];
        // each block has a word of its own
        if count > self.left() / packing.word || rest > block || (rest > 0 && count == 0) {
            return Err("has a head that makes no sense".to_owned());
        }
        let full = if rest > 0 { count - 1 } else { count };
        let length = full.checked_mul(block).and_then(|bytes| bytes.checked_add(rest)).ok_or(ENDS)?;
        is_as_long(length, expected)?;
        let sizes = (0..count).map(|_| self.word(packing)).collect::<Result<Vec<usize>, String>>()?;
        room.take(length)?;
        let mut bytes = vec![0; length];
        let blocks = bytes.chunks_mut(block.max(1));
        for (size, unpacked) in sizes.into_iter().zip(blocks) {
            let packed = self.take(size)?;
            let is_whole = match compressor {
                Compressor::Zlib => ZlibDecoder::new(&packed[..]).read_exact(unpacked).is_ok(),
                Compressor::Lz4 => {
                    lz4_flex::block::decompress_into(&packed, unpacked).is_ok_and(|length| length == unpacked.len())
                }
            };
            if !is_whole {
                return Err("cannot be unpacked".to_owned());
            }
        }
        Ok(Cow::Owned(bytes))
    }
}

fn is_as_long(length: usize, expected: Option<usize>) -> Result<(), String> {
    match expected {
        Some(expected) if expected != length => Err(format!("has {length} bytes instead of {expected}")),
        _ => Ok(()),
    }
}
