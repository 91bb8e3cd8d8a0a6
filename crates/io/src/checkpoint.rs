//! Checkpoint files: the numbers of a state under a head of text, whole or not there, and damaged ones known as such.
//!
//! ```text
//! byte 0   ESTARCKP
//! byte 8   version of this layout, u32
//! byte 12  length of the head in bytes, u32
//! byte 16  how many numbers, u64
//! byte 24  the head, UTF-8
//!          the numbers, f64
//!          SHA-256 of everything before
//! ```
//!
//! Everything is little-endian. What the head and the numbers mean is the program's affair.

use crate::atomic::AtomicFile;
use crate::file::open_ordinary;
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use thiserror::Error;

const MAGIC: [u8; 8] = *b"ESTARCKP";
const VERSION: u32 = 1;
const FIXED: u64 = 24;
const CHECKSUM: u64 = 32;
/// A head longer than this is none.
const LONGEST_HEAD: u32 = 1 << 27;
/// Bytes that are handed on at a time.
const CHUNK: usize = 1 << 18;

/// Why a checkpoint file cannot be used.
#[derive(Debug, Error)]
pub enum CheckpointError {
    /// The system refused.
    #[error("cannot be read: {0}")]
    Unreadable(#[from] io::Error),
    /// Another kind of file.
    #[error("is no checkpoint: it does not begin as one")]
    NotACheckpoint,
    /// The layout of another version.
    #[error("has layout {found}, but this program reads layout {VERSION}")]
    Layout {
        /// The version in the file.
        found: u32,
    },
    /// Less or more bytes than the file itself announces.
    #[error("is damaged: it has {found} bytes of the {announced} that it announces")]
    Length {
        /// Bytes in the file.
        found: u64,
        /// Bytes that its first ones announce.
        announced: u128,
    },
    /// A head that is too long or no text.
    #[error("is damaged: its head is no text")]
    Head,
    /// Bytes that are not those that were written.
    #[error("is damaged: its checksum is not that of its content")]
    Checksum,
}

/// Writes a checkpoint number by number. Dropped before [`CheckpointWriter::commit`] it leaves nothing behind.
#[derive(Debug)]
pub struct CheckpointWriter {
    file: AtomicFile,
    hasher: Sha256,
    buffer: Vec<u8>,
    missing: u64,
    error: Option<io::Error>,
}

impl CheckpointWriter {
    /// Begins a file with a head and so many numbers to come.
    ///
    /// # Errors
    /// What the system says; [`io::ErrorKind::InvalidInput`] for a head of 128 MiB or more.
    pub fn create(path: &Path, head: &str, number_count: u64) -> io::Result<Self> {
        let length = u32::try_from(head.len()).ok().filter(|length| *length < LONGEST_HEAD);
        let length = length.ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "the head is too long"))?;
        let mut buffer = Vec::with_capacity(CHUNK + head.len());
        buffer.extend_from_slice(&MAGIC);
        buffer.extend_from_slice(&VERSION.to_le_bytes());
        buffer.extend_from_slice(&length.to_le_bytes());
        buffer.extend_from_slice(&number_count.to_le_bytes());
        buffer.extend_from_slice(head.as_bytes());
        let file = AtomicFile::create(path)?;
        Ok(Self { file, hasher: Sha256::new(), buffer, missing: number_count, error: None })
    }

    /// Adds a number. An error waits for [`CheckpointWriter::commit`].
    pub fn number(&mut self, number: f64) {
        self.missing = self.missing.wrapping_sub(1);
        self.buffer.extend_from_slice(&number.to_le_bytes());
        if self.buffer.len() >= CHUNK {
            self.hand_on();
        }
    }

    fn hand_on(&mut self) {
        if self.error.is_none() {
            self.hasher.update(&self.buffer);
            self.error = self.file.write_all(&self.buffer).err();
        }
        self.buffer.clear();
    }

    /// Gives the file its name, once it is on the disk.
    ///
    /// # Errors
    /// The first thing that the system said; [`io::ErrorKind::InvalidInput`] unless as many numbers came as were announced.
    pub fn commit(mut self) -> io::Result<()> {
        self.hand_on();
        if let Some(error) = self.error {
            return Err(error);
        }
        if self.missing != 0 {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "not as many numbers as announced"));
        }
        self.file.write_all(&self.hasher.finalize())?;
        self.file.commit_durably()
    }
}

/// A checkpoint file that has been read through and found whole.
#[derive(Debug)]
pub struct Checkpoint {
    path: PathBuf,
    head: String,
    number_count: u64,
}

impl Checkpoint {
    /// Reads a file through and verifies every byte of it. Memory is needed for the head alone.
    ///
    /// # Errors
    /// See [`CheckpointError`].
    pub fn open(path: &Path) -> Result<Self, CheckpointError> {
        let mut file = open_ordinary(path)?;
        let found = file.metadata()?.len();
        let mut fixed = [0; FIXED as usize];
        file.read_exact(&mut fixed).map_err(|error| match error.kind() {
            io::ErrorKind::UnexpectedEof => CheckpointError::NotACheckpoint,
            _ => CheckpointError::Unreadable(error),
        })?;
        let [a, b, c, d, e, f, g, h, rest @ ..] = fixed;
        if [a, b, c, d, e, f, g, h] != MAGIC {
            return Err(CheckpointError::NotACheckpoint);
        }
        let [a, b, c, d, e, f, g, h, count @ ..] = rest;
        let (version, length) = (u32::from_le_bytes([a, b, c, d]), u32::from_le_bytes([e, f, g, h]));
        let number_count = u64::from_le_bytes(count);
        if version != VERSION {
            return Err(CheckpointError::Layout { found: version });
        }
        let announced = u128::from(FIXED) + u128::from(length) + 8 * u128::from(number_count) + u128::from(CHECKSUM);
        if announced != u128::from(found) {
            return Err(CheckpointError::Length { found, announced });
        }
        if length >= LONGEST_HEAD {
            return Err(CheckpointError::Head);
        }
        let mut hasher = Sha256::new();
        hasher.update(fixed);
        let mut head = vec![0; length as usize];
        file.read_exact(&mut head)?;
        hasher.update(&head);
        let mut numbers = (&mut file).take(8 * number_count);
        let mut chunk = vec![0; CHUNK];
        loop {
            match numbers.read(&mut chunk)? {
                0 => break,
                count => hasher.update(&chunk[..count]),
            }
        }
        let mut checksum = [0; CHECKSUM as usize];
        file.read_exact(&mut checksum)?;
        if hasher.finalize()[..] != checksum {
            return Err(CheckpointError::Checksum);
        }
        let head = String::from_utf8(head).map_err(|_| CheckpointError::Head)?;
        Ok(Self { path: path.to_owned(), head, number_count })
    }

    /// The head.
    pub fn head(&self) -> &str {
        &self.head
    }

    /// How many numbers there are.
    pub fn number_count(&self) -> u64 {
        self.number_count
    }

    /// The numbers from the first on.
    ///
    /// # Errors
    /// What the system says.
    pub fn numbers(&self) -> io::Result<Numbers> {
        let mut file = open_ordinary(&self.path)?;
        file.seek(SeekFrom::Start(FIXED + self.head.len() as u64))?;
        Ok(Numbers { reader: BufReader::with_capacity(CHUNK, file).take(8 * self.number_count), error: None })
    }
}

/// The numbers of a checkpoint, one after another.
#[derive(Debug)]
pub struct Numbers {
    reader: io::Take<BufReader<File>>,
    error: Option<io::Error>,
}

impl Numbers {
    /// The next number; not a number after the last, or when one cannot be read: see [`Numbers::finish`].
    pub fn next_number(&mut self) -> f64 {
        let mut bytes = [0; 8];
        if self.error.is_none() {
            self.error = self.reader.read_exact(&mut bytes).err();
        }
        if self.error.is_some() { f64::NAN } else { f64::from_le_bytes(bytes) }
    }

    /// Whether every number was read, and no more than there are.
    ///
    /// # Errors
    /// What the system said first; [`io::ErrorKind::InvalidData`] if numbers are left.
    pub fn finish(self) -> io::Result<()> {
        match self.error {
            Some(error) => Err(error),
            None if self.reader.limit() > 0 => Err(io::Error::new(io::ErrorKind::InvalidData, "numbers are left")),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_folder::TestFolder;
    use std::fs;

    const NUMBERS: [f64; 4] = [0.1, -0.0, f64::INFINITY, 1e-300];

    fn written(folder: &TestFolder) -> PathBuf {
        let path = folder.path().join("a.estar");
        let mut writer = CheckpointWriter::create(&path, "{\"step\": 3}", 4).unwrap();
        NUMBERS.iter().for_each(|number| writer.number(*number));
        writer.commit().unwrap();
        path
    }

    fn refused(path: &Path) -> String {
        Checkpoint::open(path).unwrap_err().to_string()
    }

    #[test]
    fn what_is_written_is_read_to_the_last_bit() {
        let folder = TestFolder::new();
        let checkpoint = Checkpoint::open(&written(&folder)).unwrap();
        assert_eq!((checkpoint.head(), checkpoint.number_count()), ("{\"step\": 3}", 4));
        let mut numbers = checkpoint.numbers().unwrap();
        for number in NUMBERS {
            assert_eq!(numbers.next_number().to_bits(), number.to_bits());
        }
        numbers.finish().unwrap();
        let mut numbers = checkpoint.numbers().unwrap();
        numbers.next_number();
        assert_eq!(numbers.finish().unwrap_err().kind(), io::ErrorKind::InvalidData);
        let mut numbers = checkpoint.numbers().unwrap();
        (0..5).for_each(|_| {
            numbers.next_number();
        });
        assert_eq!(numbers.finish().unwrap_err().kind(), io::ErrorKind::UnexpectedEof);
        // many chunks
        let path = folder.path().join("b.estar");
        let mut writer = CheckpointWriter::create(&path, "", 100_000).unwrap();
        (0..100_000).for_each(|k| writer.number(f64::from(k)));
        writer.commit().unwrap();
        let mut numbers = Checkpoint::open(&path).unwrap().numbers().unwrap();
        assert!((0..100_000).all(|k| numbers.next_number() == f64::from(k)));
    }

    #[test]
    fn every_flipped_bit_and_every_lost_byte_is_noticed() {
        let folder = TestFolder::new();
        let path = written(&folder);
        let whole = fs::read(&path).unwrap();
        for byte in 0..whole.len() {
            for bit in 0..8 {
                let mut damaged = whole.clone();
                damaged[byte] ^= 1 << bit;
                fs::write(&path, &damaged).unwrap();
                assert!(Checkpoint::open(&path).is_err(), "bit {bit} of byte {byte}");
            }
            fs::write(&path, &whole[..byte]).unwrap();
            assert!(Checkpoint::open(&path).is_err(), "cut at byte {byte}");
        }
        fs::write(&path, [&whole[..], b"x"].concat()).unwrap();
        assert!(refused(&path).contains("is damaged: it has"));
    }

    #[test]
    fn huge_counts_cost_nothing_and_other_files_are_known() {
        let folder = TestFolder::new();
        let path = folder.path().join("a.estar");
        let head = |version: u32, length: u32, count: u64| {
            let mut bytes = MAGIC.to_vec();
            bytes.extend(version.to_le_bytes());
            bytes.extend(length.to_le_bytes());
            bytes.extend(count.to_le_bytes());
            bytes
        };
        fs::write(&path, head(1, u32::MAX, u64::MAX)).unwrap();
        assert!(refused(&path).contains("it has 24 bytes of the 1475739525"), "{}", refused(&path));
        fs::write(&path, head(2, 0, 0)).unwrap();
        assert!(refused(&path).contains("has layout 2"));
        fs::write(&path, "title = \"a deck, and a long one\"").unwrap();
        assert!(refused(&path).contains("is no checkpoint"));
        fs::write(&path, "").unwrap();
        assert!(refused(&path).contains("is no checkpoint"));
        assert!(refused(&folder.path().join("none")).contains("cannot be read"));
    }

    #[test]
    fn a_file_with_too_few_or_too_many_numbers_is_not_made() {
        let folder = TestFolder::new();
        for count in [3, 5] {
            let path = folder.path().join("a.estar");
            let mut writer = CheckpointWriter::create(&path, "", count).unwrap();
            NUMBERS.iter().for_each(|number| writer.number(*number));
            assert!(writer.commit().is_err());
            assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
        }
        assert!(CheckpointWriter::create(&folder.path().join("a"), &"x".repeat(1 << 27), 0).is_err());
    }
}
