//! Figures of any number of panels, written as sheets that a screen shows and a picture can hold.

use crate::error::PostError;
use crate::plot::{Figure, Panel};
use estar_io::write_atomically;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Most panels of a sheet: more curves than most runs have, and 45 MB of pixels.
const MOST_PANELS: usize = 20;
/// Pixels of a picture per unit of the drawing: sharp on paper at the width of a page.
const PIXELS_PER_UNIT: f64 = 2.0;

/// Draws panels as `NAME.svg` and `NAME.png`, those that a sheet has no room for as `NAME_2.svg`, `NAME_2.png` and so on. Sheets of an
/// earlier figure that this one does not have are removed. One sheet after another is in memory. Returns how many there are.
///
/// # Errors
/// A file cannot be written or removed.
pub fn write(
    directory: &Path,
    name: &str,
    title: &str,
    mut panels: impl ExactSizeIterator<Item = Panel>,
) -> Result<usize, PostError> {
    let count = panels.len().div_ceil(MOST_PANELS);
    for number in 1..=count {
        let title = match count {
            1 => title.to_owned(),
            count => format!("{title}, sheet {number} of {count}").trim_start_matches(", ").to_owned(),
        };
        let figure = Figure { title, panels: panels.by_ref().take(MOST_PANELS).collect() };
        let drawing = figure.drawing();
        let pixels = drawing.png(PIXELS_PER_UNIT).ok_or(PostError::TooLarge)?;
        for (ending, content) in [("svg", drawing.svg().as_bytes()), ("png", pixels.as_slice())] {
            let path = sheet(directory, name, number, ending);
            write_atomically(&path, content).map_err(PostError::writing(&path))?;
        }
    }
    for number in count + 1.. {
        let files = ["svg", "png"].map(|ending| sheet(directory, name, number, ending));
        let [first, second] = files.map(|path| remove(&path));
        if !first? & !second? {
            break;
        }
    }
    Ok(count)
}

/// What says which files [`write()`] has written.
pub fn written(directory: &Path, name: &str, count: usize) -> Vec<String> {
    let file = |number, ending| sheet(directory, name, number, ending).display().to_string();
    let first = ["svg", "png"].into_iter().take(2 * count).map(|ending| file(1, ending));
    let second = ["svg", "png"].into_iter().filter(|_| count == 2).map(|ending| file(2, ending));
    let more = (count > 2).then(|| {
        let [from, to] = [2, count].map(|number| file(number, "svg"));
        format!("{from} to {to}, and the same as .png: {count} sheets of {MOST_PANELS} panels in all")
    });
    first.chain(second).chain(more).collect()
}

fn sheet(directory: &Path, name: &str, number: usize, ending: &str) -> PathBuf {
    directory.join(if number == 1 { format!("{name}.{ending}") } else { format!("{name}_{number}.{ending}") })
}

/// Removes a file; whether there was one.
fn remove(path: &Path) -> Result<bool, PostError> {
    match std::fs::remove_file(path) {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(false),
        Err(error) => Err(PostError::writing(path)(error)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{Axis, Curve};

    fn panels(count: usize) -> impl ExactSizeIterator<Item = Panel> {
        (0..count).map(|number| {
            let y = Axis { label: number.to_string(), ..Axis::default() };
            let curves = vec![Curve { points: vec![[0.0, 0.0], [1.0, 1.0]], ..Curve::default() }];
            Panel { y, curves, ..Panel::default() }
        })
    }

    fn names(directory: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(directory).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    #[test]
    fn many_panels_are_on_many_sheets_and_none_of_an_earlier_figure_stays() {
        let directory = tempfile::tempdir().unwrap();
        let at = directory.path();
        std::fs::write(at.join("curves_of_mine.png"), "").unwrap();
        assert_eq!(write(at, "curves", "a run", panels(2 * MOST_PANELS + 1)).unwrap(), 3);
        let sheets = ["curves", "curves_2", "curves_3"].map(|name| [format!("{name}.png"), format!("{name}.svg")]);
        let mut expected = [sheets.concat(), vec!["curves_of_mine.png".to_owned()]].concat();
        expected.sort();
        assert_eq!(names(at), expected);
        let size = |name: &str| {
            let bytes = std::fs::read(at.join(name)).unwrap();
            [16, 20].map(|start| u32::from_be_bytes(bytes[start..start + 4].try_into().unwrap()))
        };
        // a full sheet has ten rows of two panels, the last one panel
        let [full, last] = [size("curves.png"), size("curves_3.png")];
        assert_eq!(size("curves_2.png"), full);
        assert!(full[0] == 2 * last[0] && full[1] > 9 * last[1] && full[1] < 10 * last[1], "{full:?} {last:?}");

        assert_eq!(write(at, "curves", "", panels(1)).unwrap(), 1);
        assert_eq!(names(at), ["curves.png", "curves.svg", "curves_of_mine.png"]);
        assert_eq!(write(at, "curves", "", panels(0)).unwrap(), 0);
        assert_eq!(names(at), ["curves_of_mine.png"]);
    }

    #[test]
    fn what_was_written_is_told_in_a_few_lines() {
        let told = |count| written(Path::new("plots"), "history", count).join("\n").replace('\\', "/");
        assert_eq!(told(0), "");
        assert_eq!(told(1), "plots/history.svg\nplots/history.png");
        assert_eq!(told(2), "plots/history.svg\nplots/history.png\nplots/history_2.svg\nplots/history_2.png");
        let many = told(51);
        assert_eq!(many.lines().count(), 3);
        assert!(many.contains("plots/history_2.svg to plots/history_51.svg") && many.contains("51 sheets"), "{many}");
    }
}
