//! `estar plot`: curves and pictures of a run, without a display.

use crate::console::{print, tell};
use crate::failure::Failure;
use clap::Args;
use estar_deck::fields;
use estar_deck::units::{self, Dimension};
use estar_io::{FrameContent, make_own_folder, write_atomically};
use estar_post::curves::{self, CurvePanel, plain};
use estar_post::plot::drawing::{self, Ink, Raster};
use estar_post::plot::shaded::{self, Extent, Style, View, Window};
use estar_post::plot::surface::{Part, Surface};
use estar_post::plot::text::{self, Anchor, Placement};
use estar_post::plot::{Axis, Curve, Drawing, Panel};
use estar_post::series::Series;
use estar_post::sheets;
use estar_post::table::Table;
use estar_session::files::HISTORY;
use std::path::{Path, PathBuf};

/// What the command line asks for.
#[derive(Debug, Args)]
pub struct PlotArguments {
    /// Directory of a run's results
    #[arg(value_name = "DIR")]
    directory: PathBuf,
    /// Directory of another run, whose curves are laid over those of the first
    #[arg(long, value_name = "DIR2")]
    compare: Option<PathBuf>,
    /// Directory to write to; `plots` in DIR unless given
    #[arg(long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Field that colours the picture: any of the frames
    #[arg(long, value_name = "NAME", default_value = "equivalent_plastic_strain")]
    field: String,
    /// Component of the field: x, y, z, xx, yy, zz, xy, yz or xz, which a tensor needs; the length of a vector unless given
    #[arg(long, value_name = "NAME")]
    component: Option<String>,
    /// Frame at or before this time, such as 20us or, in s, 2e-5; the last unless given
    #[arg(long, value_name = "TIME", conflicts_with = "animate", value_parser = time)]
    time: Option<f64>,
    /// From where: iso, x, y, z, or azimuth and elevation in degrees such as 30,20
    #[arg(long, value_name = "VIEW", default_value = "iso", value_parser = view, allow_hyphen_values = true)]
    view: View,
    /// Values at the ends of the colours, such as 0,2; those of the field unless given
    #[arg(long, value_name = "LOW,HIGH", value_parser = range, allow_hyphen_values = true)]
    range: Option<[f64; 2]>,
    /// Mirror the body in the planes x = 0, y = 0 or z = 0, such as x,y for a quarter
    #[arg(long, value_name = "AXES", value_delimiter = ',', value_parser = axis)]
    mirror: Vec<usize>,
    /// Leave out the edges of the elements
    #[arg(long)]
    no_edges: bool,
    /// Width and height of the picture in pixels
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "1200x900", value_parser = size)]
    size: Size,
    /// All frames as one animation (animation.png, an APNG, which browsers play)
    #[arg(long)]
    animate: bool,
}

/// Width and height in pixels.
#[derive(Clone, Copy, Debug)]
struct Size([usize; 2]);

fn view(text: &str) -> Result<View, String> {
    let named = [("iso", 35.0, 25.0), ("x", 0.0, 0.0), ("y", 90.0, 0.0), ("z", -90.0, 90.0)];
    if let Some((_, azimuth, elevation)) = named.into_iter().find(|(name, ..)| *name == text) {
        return Ok(View { azimuth, elevation });
    }
    match pair(text) {
        Some([azimuth, elevation]) => Ok(View { azimuth, elevation }),
        None => Err("iso, x, y, z, or two angles in degrees such as 30,20".to_owned()),
    }
}

fn time(text: &str) -> Result<f64, String> {
    let time = units::parse(text).ok().filter(|time| time.dimension.is_none_or(|unit| unit == Dimension::TIME));
    let time = time.map(|time| time.value).filter(|time| time.is_finite() && *time >= 0.0);
    time.ok_or_else(|| "a time, 0 or greater, such as 20us or, in s, 2e-5".to_owned())
}

fn range(text: &str) -> Result<[f64; 2], String> {
    match pair(text) {
        Some([low, high]) if low < high && (high - low).is_finite() => Ok([low, high]),
        _ => Err("two numbers, the smaller first, such as 0,2".to_owned()),
    }
}

fn pair(text: &str) -> Option<[f64; 2]> {
    let (first, second) = text.split_once(',')?;
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    Some([number(first)?, number(second)?])
}

fn axis(text: &str) -> Result<usize, String> {
    ["x", "y", "z"].iter().position(|name| *name == text).ok_or_else(|| "x, y or z".to_owned())
}

fn size(text: &str) -> Result<Size, String> {
    let number = |text: &str| text.parse().ok().filter(|length| (64..=8192).contains(length));
    let size = text.split_once('x').and_then(|(width, height)| Some(Size([number(width)?, number(height)?])));
    size.ok_or_else(|| "two whole numbers from 64 to 8192, such as 1200x900".to_owned())
}

/// Plots a run.
///
/// # Errors
/// There are no results, they cannot be read, or the plots cannot be written.
pub fn plot(arguments: &PlotArguments) -> Result<(), Failure> {
    let runs: Vec<&PathBuf> = [Some(&arguments.directory), arguments.compare.as_ref()].into_iter().flatten().collect();
    if let Some(stranger) = runs.iter().find(|run| !Series::file(run).exists()) {
        let message = format!("error: {} holds no results of a run", stranger.display());
        return Err(Failure::File(format!("{message}\nhelp: it is to be the directory that `estar run` wrote to")));
    }
    let output = arguments.output.clone().unwrap_or_else(|| arguments.directory.join("plots"));
    let histories = runs.iter().map(|run| Table::read(&run.join(HISTORY))).collect::<Result<Vec<_>, _>>()?;
    // one that the user names may be a link, what is among results may not
    let made = if arguments.output.is_some() { std::fs::create_dir_all(&output) } else { make_own_folder(&output) };
    made.map_err(Failure::writing(&output))?;
    let sheet_count = sheets::write(&output, "history", &history_title(&runs), history_panels(&histories))?;
    let mut written = sheets::written(&output, "history", sheet_count);
    let mut write = |name: &str, content: &[u8]| -> Result<(), Failure> {
        let path = output.join(name);
        write_atomically(&path, content).map_err(Failure::writing(&path))?;
        written.push(path.display().to_string());
        Ok(())
    };

    let series = Series::of(&arguments.directory)?;
    if !arguments.mirror.is_empty() {
        warn_of_cut_bodies(arguments, &series.at(arguments.time)?)?;
    }
    if arguments.animate {
        write("animation.png", &animation(arguments, &series)?)?;
    } else {
        let frame = series.at(arguments.time)?;
        let surface = surface(arguments, &frame)?;
        let range = arguments.range.or(surface.range()).unwrap_or(NO_RANGE);
        let window = Window::around(&surface, arguments.view);
        write("picture.png", &picture(arguments, frame.time, &surface, range, window)?.png()?)?;
    }
    print(&written.join("\n"))
}

/// Values at the ends of the colours where there are no values.
const NO_RANGE: [f64; 2] = [0.0, 1.0];

impl From<drawing::EncodingError> for Failure {
    fn from(error: drawing::EncodingError) -> Self {
        Self::File(format!("error: the picture cannot be written: {error}"))
    }
}

fn too_large() -> Failure {
    Failure::Input("error: the plot is larger than a picture can be".to_owned())
}

/// The surface with the field that is asked for.
fn surface_without_images(arguments: &PlotArguments, frame: &FrameContent) -> Result<Surface, Failure> {
    let part = part(arguments, frame)?;
    Surface::of(frame, &arguments.field, part).ok_or_else(|| no_field(arguments, frame))
}

/// The same with the mirror images that are asked for.
fn surface(arguments: &PlotArguments, frame: &FrameContent) -> Result<Surface, Failure> {
    let surface = surface_without_images(arguments, frame)?;
    Ok(arguments.mirror.iter().fold(surface, |surface, axis| surface.mirrored(*axis)))
}

/// Says which planes of `--mirror` cut the body, whose image then lies within it.
fn warn_of_cut_bodies(arguments: &PlotArguments, frame: &FrameContent) -> Result<(), Failure> {
    let surface = surface_without_images(arguments, frame)?;
    for axis in arguments.mirror.iter().filter(|axis| surface.is_cut_by(**axis)) {
        let name = ["x", "y", "z"][*axis];
        tell(&format!(
            "warning: the body lies on both sides of the plane {name} = 0, and its mirror image is drawn within it\n\
             help: --mirror is for a body that ends at a plane of symmetry"
        ));
    }
    Ok(())
}

fn no_field(arguments: &PlotArguments, frame: &FrameContent) -> Failure {
    let names: Vec<&str> = frame.node_fields.keys().chain(frame.cell_fields.keys()).map(String::as_str).collect();
    let similar = estar_deck::diagnostics::nearest(&arguments.field, names.iter().copied());
    let similar = similar.map_or(String::new(), |name| format!("did you mean `{name}`? "));
    Failure::Input(format!(
        "error: the frames have no field `{}`\nhelp: {similar}they have {}",
        arguments.field,
        estar_deck::diagnostics::listed(names.iter().copied())
    ))
}

fn part(arguments: &PlotArguments, frame: &FrameContent) -> Result<Part, Failure> {
    let field = frame.node_fields.get(&arguments.field).or_else(|| frame.cell_fields.get(&arguments.field));
    let field = field.ok_or_else(|| no_field(arguments, frame))?;
    let names = Part::names(field.components);
    let Some(name) = &arguments.component else {
        // the length of a tensor is nothing that anybody asks for
        return if names.contains(&"xx") { Err(no_component(arguments, names)) } else { Ok(Part::Magnitude) };
    };
    let place = names.iter().position(|known| known == name);
    place.map(Part::Component).ok_or_else(|| {
        let help = match names {
            [] => "it is one number".to_owned(),
            names => format!("its components are {}", estar_deck::diagnostics::listed(names.iter().copied())),
        };
        Failure::Input(format!("error: the field `{}` has no component `{name}`\nhelp: {help}", arguments.field))
    })
}

fn no_component(arguments: &PlotArguments, names: &[&str]) -> Failure {
    let field = &arguments.field;
    let names = estar_deck::diagnostics::listed(names.iter().copied());
    let scalars = if field == "cauchy_stress" { "; von_mises_stress and pressure are one number each" } else { "" };
    Failure::Input(format!(
        "error: the field `{field}` is a tensor: --component says which of its components\nhelp: they are {names}{scalars}"
    ))
}

/// Room for the colour bar at the right, in pixels of a picture that is 900 high.
const BAR_ROOM: f64 = 190.0;

/// A picture with its colour bar.
fn picture(
    arguments: &PlotArguments,
    time: f64,
    surface: &Surface,
    range: [f64; 2],
    window: Window,
) -> Result<Raster, Failure> {
    let Size([width, height]) = arguments.size;
    let unit = height as f64 / 900.0;
    let body_width = width.saturating_sub((BAR_ROOM * unit) as usize).max(1);
    let style = Style { view: arguments.view, range, has_edges: !arguments.no_edges };
    let body = shaded::draw(surface, &style, &window, [body_width, height]);

    let mut drawing = Drawing::new([width as f64, height as f64]);
    let bar = [width as f64 - (BAR_ROOM - 24.0) * unit, 260.0 * unit, 34.0 * unit, 420.0 * unit];
    colour_bar(&mut drawing, arguments, range, bar, unit);
    let time = format!("t = {} s", estar_deck::format::short(time));
    let at = [bar[0], bar[1] + bar[3] + 60.0 * unit];
    write_text(&mut drawing, &time, at, 19.0 * unit);
    let mut raster = drawing.raster(1.0).ok_or_else(too_large)?;
    for row in 0..height {
        let start = row * width;
        raster.pixels[start..start + body_width]
            .copy_from_slice(&body.pixels[row * body_width..(row + 1) * body_width]);
    }
    Ok(raster)
}

fn write_text(drawing: &mut Drawing, words: &str, at: [f64; 2], size: f64) {
    let placement = Placement { at, size, anchor: Anchor::Start, upright: false };
    text::write(drawing, words, placement, [32, 32, 32]);
}

fn colour_bar(
    drawing: &mut Drawing,
    arguments: &PlotArguments,
    range: [f64; 2],
    [left, top, width, height]: [f64; 4],
    unit: f64,
) {
    const STEPS: usize = 128;
    const TICKS: usize = 4;
    // shares of the bar's height
    let along = |share: f64| top + height * (1.0 - share);
    let label = |value: f64, share: f64| {
        (estar_deck::format::short(value), [left + width + 9.0 * unit, along(share) + 7.0 * unit])
    };
    let numbers = fields::is_label(&arguments.field).then(|| whole_numbers(range)).flatten();
    let steps = numbers.as_ref().map_or(STEPS, Vec::len);
    for step in 0..steps {
        let [from, middle, to] = [0.0, 0.5, 1.0].map(|part| (step as f64 + part) / steps as f64);
        let value = numbers.as_ref().map_or(range[0] + middle * (range[1] - range[0]), |numbers| numbers[step]);
        // a little higher than its share, so that no seam is seen
        let upper = (along(to) - 0.5).max(top);
        drawing.rectangle([left, upper], [left + width, along(from)], Ink::Fill(shaded::colour(value, range)));
    }
    let pen = Ink::Stroke { colour: [32, 32, 32], width: unit, dashes: &[] };
    drawing.rectangle([left, top], [left + width, top + height], pen);
    let labels: Vec<(String, [f64; 2])> = match &numbers {
        Some(numbers) => {
            let middle = |index: usize| (index as f64 + 0.5) / steps as f64;
            numbers.iter().enumerate().map(|(index, number)| label(*number, middle(index))).collect()
        }
        None => {
            let shares = (0..=TICKS).map(|tick| tick as f64 / TICKS as f64);
            shares.map(|share| label(range[0] + share * (range[1] - range[0]), share)).collect()
        }
    };
    labels.iter().for_each(|(text, at)| write_text(drawing, text, *at, 19.0 * unit));
    let component = arguments.component.as_ref().map_or(String::new(), |name| format!(" {name}"));
    let name = format!("{}{component}", arguments.field.replace('_', " "));
    let unit_name = fields::unit_of(&arguments.field).map_or(String::new(), |unit| format!("[{unit}]"));
    // a word a line: names are longer than the bar is wide
    let lines: Vec<&str> = name.split(' ').chain([unit_name.as_str()]).filter(|line| !line.is_empty()).collect();
    for (index, line) in lines.iter().rev().enumerate() {
        write_text(drawing, line, [left, top - (18.0 + 25.0 * index as f64) * unit], 20.0 * unit);
    }
}

/// The whole numbers from one end of a range to the other; none where they are too many for a colour each.
fn whole_numbers([low, high]: [f64; 2]) -> Option<Vec<f64>> {
    const MOST: f64 = 12.0;
    let is_whole = low.fract() == 0.0 && high.fract() == 0.0;
    (is_whole && high - low < MOST).then(|| (0..=(high - low) as u32).map(|step| low + f64::from(step)).collect())
}

/// A picture of each frame, all with the same window and range, as an animation. Frames are read twice, so that one of them at a time
/// is in memory.
fn animation(arguments: &PlotArguments, series: &Series) -> Result<Vec<u8>, Failure> {
    let mut extent = Extent::NOTHING;
    let mut range: Option<[f64; 2]> = None;
    for frame in series.all() {
        let surface = surface(arguments, &frame?)?;
        extent.take_in(&surface, arguments.view);
        let joined = |[low, high]: [f64; 2], [least, most]: [f64; 2]| [low.min(least), high.max(most)];
        range = surface.range().map(|own| range.map_or(own, |range| joined(range, own))).or(range);
    }
    let range = arguments.range.or(range).unwrap_or(NO_RANGE);
    let window = extent.window();
    let pictures = series.all().map(|frame| {
        let frame = frame?;
        picture(arguments, frame.time, &surface(arguments, &frame)?, range, window)
    });
    drawing::animated_png(series.frames.len(), pictures)
}

/// The curves of one run, or of two laid over each other: the first solid, the second dashed.
fn history_panels(histories: &[Table]) -> impl ExactSizeIterator<Item = Panel> {
    let first = &histories[0];
    let panel = |CurvePanel { label, unit, is_logarithmic, columns, .. }: CurvePanel| {
        let of_run = |(run, history): (usize, &Table)| -> Vec<Curve> {
            let curve = |(colour, column): (usize, &&str)| {
                // one quantity has its name on the axis, and the second run has the colours of the first
                let label = if columns.len() > 1 && run == 0 { plain(column) } else { String::new() };
                Some(Curve { label, colour, dash: run, points: history.pairs("time", column)?, ..Curve::default() })
            };
            columns.iter().enumerate().filter_map(curve).collect()
        };
        let axis = |label: &str, unit: &str| Axis { label: label.to_owned(), unit: unit.to_owned(), ..Axis::default() };
        let curves = histories.iter().enumerate().flat_map(of_run).collect();
        let y = Axis { is_logarithmic, ..axis(&label, &unit) };
        Panel { x: axis("time", "s"), y, curves, ..Panel::default() }
    };
    let largest = |column: &str| {
        first.column(column).map_or(0.0, |values| values.iter().map(|value| value.abs()).fold(0.0, f64::max))
    };
    let names: Vec<&str> = first.names().collect();
    curves::panels(&names, largest).into_iter().map(panel)
}

fn history_title(runs: &[&PathBuf]) -> String {
    let name = |run: &Path| match run.file_name() {
        Some(name) => name.to_string_lossy().into_owned(),
        None => run.display().to_string(),
    };
    match runs {
        [first, second] => format!("{} (solid), {} (dashed)", name(first), name(second)),
        runs => runs.iter().map(|run| name(run)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_of_few_whole_numbers_has_a_colour_for_each() {
        assert_eq!(whole_numbers([1.0, 3.0]), Some(vec![1.0, 2.0, 3.0]));
        assert_eq!(whole_numbers([1.0, 1.0]), Some(vec![1.0]));
        assert_eq!(whole_numbers([1.0, 13.0]), None);
        assert_eq!(whole_numbers([0.5, 3.0]), None);
        assert_eq!(whole_numbers([0.0, 1e300]), None);
    }
}
