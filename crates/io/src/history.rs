//! History tables: CSV that grows row by row and survives the end of the program at any of them.

use std::fmt;
use std::fs::{File, OpenOptions};
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::Path;

use crate::atomic::append_whole;
use crate::file::{create_ordinary, open_ordinary, reopen};

/// One entry of a history row.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A number, printed with the fewest digits that read back as the same bits.
    Real(f64),
    /// A count or a label.
    Integer(u64),
    /// Nothing: an empty entry.
    Missing,
}

impl From<f64> for Value {
    fn from(value: f64) -> Self {
        Value::Real(value)
    }
}

impl From<u64> for Value {
    fn from(value: u64) -> Self {
        Value::Integer(value)
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            // `Debug` has exponents: 1e-300 is not three hundred digits.
            Value::Real(value) => write!(f, "{value:?}"),
            Value::Integer(value) => write!(f, "{value}"),
            Value::Missing => Ok(()),
        }
    }
}

/// Bytes of a value and of the comma behind it, at most.
const LONGEST_VALUE: u64 = 32;

/// Writes a CSV table, each row in one piece.
#[derive(Debug)]
pub struct HistoryWriter {
    file: File,
    column_count: usize,
    row: String,
}

impl HistoryWriter {
    /// Starts a table with a header row.
    ///
    /// # Errors
    /// What the system says.
    pub fn create<S: AsRef<str>>(path: &Path, columns: &[S]) -> io::Result<Self> {
        let mut file = create_ordinary(path)?;
        file.write_all(header(columns).as_bytes())?;
        Ok(Self { file, column_count: columns.len(), row: String::new() })
    }

    /// Goes on with a table after its first `row_count` rows; later ones, and one cut short, are dropped.
    ///
    /// # Errors
    /// What the system says; [`io::ErrorKind::InvalidData`] if the header is another one or rows are missing.
    pub fn resume<S: AsRef<str>>(path: &Path, columns: &[S], row_count: u64) -> io::Result<Self> {
        let length = Self::length_of(path, columns, row_count)?;
        let mut file = reopen(path, OpenOptions::new().write(true))?;
        file.set_len(length)?;
        file.seek(SeekFrom::End(0))?;
        Ok(Self { file, column_count: columns.len(), row: String::new() })
    }

    /// Bytes of the header and of the first `row_count` rows of a table, which is left as it is.
    ///
    /// # Errors
    /// As [`HistoryWriter::resume`].
    pub fn length_of<S: AsRef<str>>(path: &Path, columns: &[S], row_count: u64) -> io::Result<u64> {
        let invalid = |message: String| io::Error::new(io::ErrorKind::InvalidData, message);
        let header = header(columns);
        let mut reader = BufReader::new(open_ordinary(path)?);
        // no row is longer than so many numbers
        let longest = (header.len() as u64).max(LONGEST_VALUE * (columns.len() as u64 + 1));
        let mut line = String::new();
        let mut next_line = |line: &mut String| reader.by_ref().take(longest).read_line(line);
        let mut length = next_line(&mut line)? as u64;
        if line != header {
            return Err(invalid("its columns are not those of this run".to_owned()));
        }
        for row in 0..row_count {
            line.clear();
            length += next_line(&mut line)? as u64;
            if !line.ends_with('\n') {
                return Err(invalid(format!("it has {row} whole rows of the {row_count} expected")));
            }
        }
        Ok(length)
    }

    /// Puts the rows so far on the disk, so that they survive the end of the machine.
    ///
    /// # Errors
    /// What the system says.
    pub fn sync(&self) -> io::Result<()> {
        self.file.sync_data()
    }

    /// Adds a row; it is in the file when this returns, whatever happens to the program afterwards.
    ///
    /// # Errors
    /// What the system says; [`io::ErrorKind::InvalidInput`] unless there is a value for every column.
    pub fn write_row(&mut self, values: &[Value]) -> io::Result<()> {
        if values.len() != self.column_count {
            let message = format!("{} values for {} columns", values.len(), self.column_count);
            return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
        }
        self.row.clear();
        for (k, value) in values.iter().enumerate() {
            let separator = if k == 0 { "" } else { "," };
            self.row += &format!("{separator}{value}");
        }
        self.row.push('\n');
        // One write of the whole row: a kill leaves whole rows.
        append_whole(&mut self.file, self.row.as_bytes())
    }
}

/// The header row; a name with a comma, a quote or a line end is quoted.
fn header<S: AsRef<str>>(columns: &[S]) -> String {
    let quoted = |name: &str| {
        if name.contains([',', '"', '\n', '\r']) { format!("\"{}\"", name.replace('"', "\"\"")) } else { name.into() }
    };
    columns.iter().map(|name| quoted(name.as_ref())).collect::<Vec<_>>().join(",") + "\n"
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::test_folder::TestFolder;

    #[test]
    fn rows_are_in_the_file_at_once_and_read_back_as_the_same_bits() {
        let folder = TestFolder::new();
        let path = folder.path().join("history.csv");
        let mut history = HistoryWriter::create(&path, &["time", "step", "a, \"b\""]).unwrap();
        let values = [0.1 + 0.2, 1e-300, -0.0, f64::MAX, 1.0 / 3.0];
        for (step, value) in (0_u64..).zip(values) {
            history.write_row(&[value.into(), step.into(), Value::Missing]).unwrap();
            let text = fs::read_to_string(&path).unwrap();
            let last = text.lines().last().unwrap().split(',').next().unwrap();
            assert_eq!(last.parse::<f64>().unwrap().to_bits(), value.to_bits());
        }
        assert!(fs::read_to_string(&path).unwrap().starts_with("time,step,\"a, \"\"b\"\"\"\n0.30000000000000004,0,\n"));
    }

    #[test]
    fn a_row_of_the_wrong_length_is_refused() {
        let folder = TestFolder::new();
        let mut history = HistoryWriter::create(&folder.path().join("h.csv"), &["time"]).unwrap();
        assert_eq!(history.write_row(&[]).unwrap_err().kind(), io::ErrorKind::InvalidInput);
    }

    #[test]
    fn resuming_drops_later_rows_and_a_row_cut_short() {
        let folder = TestFolder::new();
        let path = folder.path().join("h.csv");
        fs::write(&path, "time\n1\n2\n3\n4.5").unwrap();
        let mut history = HistoryWriter::resume(&path, &["time"], 2).unwrap();
        history.write_row(&[9.0.into()]).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "time\n1\n2\n9.0\n");
        assert!(HistoryWriter::resume(&path, &["time"], 7).is_err());
        assert!(HistoryWriter::resume(&path, &["clock"], 1).is_err());
    }
}
