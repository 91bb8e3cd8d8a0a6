//! A table of numbers as `history.csv` has it: a row of names, then rows of numbers.

use crate::error::PostError;
use estar_deck::memory;
use estar_io::read_ordinary;
use std::path::Path;

/// Columns of numbers under names.
#[derive(Clone, Debug)]
pub struct Table {
    names: Vec<String>,
    columns: Vec<Vec<f64>>,
}

impl Table {
    /// Reads the table of a file. Empty cells are not a number.
    ///
    /// # Errors
    /// It cannot be read, or is no such table.
    pub fn read(path: &Path) -> Result<Self, PostError> {
        let unusable = |what: String| PostError::Unusable { path: path.to_owned(), what };
        if let Some(shortage) = memory::shortage_of_table(path) {
            return Err(PostError::NoMemory { shortage });
        }
        let bytes = read_ordinary(path, u64::MAX).map_err(PostError::reading(path))?;
        let text = String::from_utf8(bytes).map_err(|_| unusable("it is no text".to_owned()))?;
        Self::parse(&text).map_err(unusable)
    }

    fn parse(text: &str) -> Result<Self, String> {
        // a row without its end is still being written
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        let mut lines = whole.lines();
        let names: Vec<String> = lines.next().unwrap_or("").split(',').map(str::to_owned).collect();
        let mut columns = vec![Vec::new(); names.len()];
        for (index, line) in lines.enumerate() {
            for (column, number) in columns.iter_mut().zip(row(line, names.len(), index + 2)?) {
                column.push(number);
            }
        }
        if columns.iter().any(Vec::is_empty) {
            return Err("it has no rows".to_owned());
        }
        Ok(Self { names, columns })
    }

    /// The names of the columns.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(String::as_str)
    }

    /// The numbers of a column.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        let place = self.names.iter().position(|known| known == name)?;
        Some(&self.columns[place])
    }

    /// The numbers of one column over those of another.
    pub fn pairs(&self, over: &str, name: &str) -> Option<Vec<[f64; 2]>> {
        let (x, y) = (self.column(over)?, self.column(name)?);
        Some(x.iter().zip(y).map(|(x, y)| [*x, *y]).collect())
    }
}

/// The numbers of a line of a table with so many columns. Empty cells are not a number.
///
/// # Errors
/// What is wrong with the line, by its number in the file.
pub fn row(line: &str, columns: usize, number: usize) -> Result<Vec<f64>, String> {
    let cells: Vec<&str> = line.split(',').collect();
    if cells.len() != columns {
        return Err(format!("line {number} has {} cells, not {columns}", cells.len()));
    }
    let value = |cell: &str| if cell.is_empty() { Ok(f64::NAN) } else { cell.parse() };
    cells.into_iter().map(|cell| value(cell).map_err(|_| format!("line {number}: \"{cell}\" is no number"))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_found_by_name_and_empty_cells_are_no_number() {
        let table = Table::parse("time,force\n0.0,1.5\n1e-3,\n").unwrap();
        assert_eq!(table.column("time"), Some(&[0.0, 1e-3][..]));
        assert!(table.column("force").unwrap()[1].is_nan());
        assert_eq!(table.pairs("time", "force").unwrap()[0], [0.0, 1.5]);
        assert_eq!(table.column("mass"), None);
    }

    #[test]
    fn what_is_no_table_is_refused_by_its_line() {
        assert_eq!(Table::parse("a,b\n1,2\n3\n").unwrap_err(), "line 3 has 1 cells, not 2");
        assert_eq!(Table::parse("a,b\n1,x\n").unwrap_err(), "line 2: \"x\" is no number");
        for text in ["", "a,b\n", "a,b\n1,2"] {
            assert_eq!(Table::parse(text).unwrap_err(), "it has no rows");
        }
    }
}
