//! A history that grows: only what is new is read, and what is kept does not grow with it.

use crate::curves::{CurvePanel, panels, plain};
use crate::table;
use estar_deck::history_column;
use estar_io::{open_ordinary, visible};
use serde_json::{Value, json};
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

/// When so many rows are kept, every other one is left out from then on.
const MOST_KEPT: usize = 2400;
/// Bytes of a line that is read: that of a run with more columns is told of in place of curves.
const LONGEST_LINE: u64 = 1 << 20;
/// Columns of probes that are shown, as many as a page can be looked through.
const MOST_PROBES: usize = 100;

/// What has been read of `history.csv`.
#[derive(Debug, Default)]
pub struct HistoryTail {
    /// Where the next line begins.
    offset: u64,
    /// Where the last line begins, and what it says: another run in its place says something else there.
    last_line: (u64, Vec<u8>),
    /// Names of the columns that are shown, and their places in a row.
    names: Vec<String>,
    places: Vec<usize>,
    column_count: usize,
    rows: usize,
    /// Every so many rows are kept.
    stride: usize,
    /// Kept rows, each a column.
    kept: Vec<Vec<f64>>,
    last: Vec<f64>,
    /// Largest absolute value of each column.
    largest: Vec<f64>,
    error: Option<String>,
    /// Probes of the run.
    probe_count: usize,
}

impl HistoryTail {
    /// Reads what is new.
    pub fn update(&mut self, path: &Path) {
        if let Err(error) = self.read(path) {
            self.error = Some(error);
        }
    }

    /// Why it could not be read to its end, or what of it is not shown.
    pub fn note(&self) -> Option<String> {
        let more = self.probe_count > MOST_PROBES;
        let of_probes = || {
            format!(
                "it follows {} probes, of which this page shows the first {MOST_PROBES}; the file has all of them",
                self.probe_count
            )
        };
        self.error.clone().or_else(|| more.then(of_probes))
    }

    fn read(&mut self, path: &Path) -> Result<(), String> {
        let unreadable = |error: io::Error| error.to_string();
        let mut file = open_ordinary(path).map_err(|error| {
            *self = Self::default();
            unreadable(error)
        })?;
        if !self.goes_on_in(&mut file).map_err(unreadable)? {
            *self = Self::default();
        }
        self.error = None;
        file.seek(SeekFrom::Start(self.offset)).map_err(unreadable)?;
        let mut reader = BufReader::with_capacity(1 << 16, file);
        let mut line = Vec::new();
        loop {
            line.clear();
            let count = reader.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut line).map_err(unreadable)?;
            if count as u64 == LONGEST_LINE {
                let longest = LONGEST_LINE >> 10;
                return Err(format!("it has too many columns for this page: a line is longer than {longest} KiB"));
            }
            // a row without its end is still being written
            if line.last() != Some(&b'\n') {
                return Ok(());
            }
            self.take(&line[..count - 1])?;
            self.last_line = (self.offset, line.clone());
            self.offset += count as u64;
        }
    }

    /// Whether what was read is still there.
    fn goes_on_in(&self, file: &mut File) -> io::Result<bool> {
        let (start, line) = &self.last_line;
        file.seek(SeekFrom::Start(*start))?;
        let mut found = Vec::new();
        file.take(line.len() as u64).read_to_end(&mut found)?;
        Ok(found == *line)
    }

    fn take(&mut self, line: &[u8]) -> Result<(), String> {
        let line = std::str::from_utf8(line).map_err(|_| "it is not text".to_owned())?.trim_end_matches('\r');
        if self.names.is_empty() {
            let names: Vec<&str> = line.split(',').collect();
            if names[0] != "time" {
                return Err("it is no history of a run".to_owned());
            }
            for (place, name) in names.iter().enumerate() {
                if !history_column::is_column(name) {
                    self.probe_count += 1;
                    if self.probe_count > MOST_PROBES {
                        continue;
                    }
                }
                self.names.push(visible(name).into_owned());
                self.places.push(place);
            }
            self.column_count = names.len();
            (self.kept, self.largest) = (vec![Vec::new(); self.names.len()], vec![0.0; self.names.len()]);
            self.stride = 1;
            return Ok(());
        }
        let row = table::row(line, self.column_count, self.rows + 2)?;
        let row: Vec<f64> = self.places.iter().map(|place| row[*place]).collect();
        for (largest, value) in self.largest.iter_mut().zip(&row) {
            *largest = largest.max(value.abs());
        }
        if self.rows.is_multiple_of(self.stride) {
            for (column, value) in self.kept.iter_mut().zip(&row) {
                column.push(*value);
            }
        }
        self.rows += 1;
        self.last = row;
        if self.kept[0].len() >= MOST_KEPT {
            self.stride *= 2;
            for column in &mut self.kept {
                *column = column.iter().copied().step_by(2).collect();
            }
        }
        Ok(())
    }

    /// The curves and the panels that they belong to.
    pub fn json(&self) -> Vec<u8> {
        let place = |name: &str| self.names.iter().position(|known| known == name);
        let names: Vec<&str> = self.names.iter().map(String::as_str).collect();
        let panels = if self.rows == 0 {
            Vec::new()
        } else {
            panels(&names, |name| place(name).map_or(0.0, |column| self.largest[column]))
        };
        let is_last_kept = self.rows > 0 && (self.rows - 1).is_multiple_of(self.stride);
        let values = |name: &str| -> Vec<Value> {
            let Some(column) = place(name) else { return Vec::new() };
            let last = self.last.get(column).filter(|_| !is_last_kept);
            // what no number of JSON is becomes null
            self.kept[column].iter().chain(last).map(|value| json!(rounded(*value))).collect()
        };
        let curve = |column: &&str| json!({ "name": plain(column), "values": values(column) });
        let panel = |panel: &CurvePanel| {
            json!({
                "label": panel.label,
                "unit": panel.unit,
                "is_logarithmic": panel.is_logarithmic,
                "is_probe": panel.is_probe,
                "curves": panel.columns.iter().map(curve).collect::<Vec<_>>(),
            })
        };
        let content = json!({
            "rows": self.rows,
            "time": values("time"),
            "panels": panels.iter().map(panel).collect::<Vec<_>>(),
        });
        content.to_string().into_bytes()
    }
}

/// To seven significant digits, which are more than a curve shows and half as many as the number has.
fn rounded(value: f64) -> f64 {
    format!("{value:.6e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::{self, OpenOptions};
    use std::io::Write;

    const HEAD: &str = "time,kinetic_energy,length\n";

    fn shown(tail: &HistoryTail) -> Value {
        serde_json::from_slice(&tail.json()).unwrap()
    }

    #[test]
    fn rows_are_read_as_they_come_and_a_row_without_its_end_is_waited_for() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("history.csv");
        let mut tail = HistoryTail::default();
        tail.update(&path);
        assert!(tail.note().is_some() && shown(&tail)["rows"] == 0);
        fs::write(&path, format!("{HEAD}0,1,5\n1,2")).unwrap();
        tail.update(&path);
        assert_eq!((tail.note(), &shown(&tail)["time"]), (None, &json!([0.0])));
        let mut file = OpenOptions::new().append(true).open(&path).unwrap();
        file.write_all(b",\n2,4,7\n").unwrap();
        tail.update(&path);
        let content = shown(&tail);
        assert_eq!(content["time"], json!([0.0, 1.0, 2.0]));
        assert_eq!(content["panels"][1]["curves"][0]["values"], json!([5.0, null, 7.0]));
        assert_eq!(
            (&content["panels"][1]["label"], &content["panels"][1]["is_probe"]),
            (&json!("length"), &json!(true))
        );
        // another run in its place
        fs::write(&path, format!("{HEAD}0,1,6\n1,2,6\n2,4,6\n3,4,6\n")).unwrap();
        tail.update(&path);
        assert_eq!(shown(&tail)["panels"][1]["curves"][0]["values"], json!([6.0, 6.0, 6.0, 6.0]));
    }

    #[test]
    fn values_have_seven_digits_and_the_range_of_their_kind() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("history.csv");
        fs::write(&path, format!("{HEAD}0,1,59.706358987\n1,1,-1.5e200\n2,1,1e-200\n3,1,inf\n")).unwrap();
        let mut tail = HistoryTail::default();
        tail.update(&path);
        let text = String::from_utf8(tail.json()).unwrap();
        assert!(
            text.contains("[59.70636,-1.5e200,1e-200,null]") || text.contains("[59.70636,-1.5e+200,1e-200,null]"),
            "{text}"
        );
    }

    #[test]
    fn what_is_kept_of_a_long_history_is_bounded_and_has_its_end() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("history.csv");
        let rows: String = (0..50_000).map(|row| format!("{row},1,5\n")).collect();
        fs::write(&path, format!("{HEAD}{rows}")).unwrap();
        let mut tail = HistoryTail::default();
        tail.update(&path);
        let content = shown(&tail);
        let times = content["time"].as_array().unwrap();
        assert_eq!(content["rows"], 50_000);
        assert!((MOST_KEPT / 2..=MOST_KEPT).contains(&times.len()), "{}", times.len());
        assert_eq!((&times[0], times.last().unwrap()), (&json!(0.0), &json!(49_999.0)));
    }

    #[test]
    fn of_very_many_probes_the_first_are_shown_and_the_rest_is_told_of() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("history.csv");
        let probes: String = (0..5000).map(|probe| format!(",p{probe}")).collect();
        let row: String = (0..5000).map(|probe| format!(",{probe}")).collect();
        fs::write(&path, format!("time,kinetic_energy{probes},heat\n0,1{row},7\n1,2{row},8\n")).unwrap();
        let mut tail = HistoryTail::default();
        tail.update(&path);
        let told = tail.note().unwrap();
        assert!(told.contains("5000 probes, of which this page shows the first 100"), "{told}");
        let content = shown(&tail);
        let panels = content["panels"].as_array().unwrap();
        let labels: Vec<&str> = panels.iter().map(|panel| panel["label"].as_str().unwrap()).collect();
        assert_eq!((labels.len(), labels[0], labels[1], labels[101]), (102, "energy", "p0", "heat"));
        assert_eq!(panels[100]["curves"][0]["values"], json!([99.0, 99.0]));
        assert_eq!(panels[101]["curves"][0]["values"], json!([7.0, 8.0]));
    }

    #[test]
    fn what_is_no_history_is_told_and_read_again_when_it_is_one() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("history.csv");
        let mut tail = HistoryTail::default();
        for (content, part) in [
            (format!("{HEAD}0,1\n"), "line 2 has 2 cells"),
            (format!("{HEAD}0,1,x\n"), "line 2: \"x\""),
            ("rubbish\n".to_owned(), "no history"),
            ("x".repeat(2 << 20), "too many columns for this page"),
        ] {
            fs::write(&path, content).unwrap();
            tail.update(&path);
            assert!(tail.note().is_some_and(|note| note.contains(part)), "{:?}", tail.note());
        }
        fs::write(&path, format!("{HEAD}0,1,5\n")).unwrap();
        tail.update(&path);
        assert_eq!((tail.note(), &shown(&tail)["rows"]), (None, &json!(1)));
    }
}
