//! Panels of curves over axes, with a legend where no curve is.

use super::drawing::{Colour, Drawing, Ink};
use super::text::{self, Anchor, CAPITAL_HEIGHT, Placement};

/// Panels side by side and below one another, under one title.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Its title; none if empty.
    pub title: String,
    /// Its panels, two in a row.
    pub panels: Vec<Panel>,
}

/// Curves over a pair of axes.
#[derive(Clone, Debug, Default)]
pub struct Panel {
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// Whether a unit is as long on both axes, as in a picture of a plane.
    pub is_isometric: bool,
    /// The curves, later ones over earlier ones.
    pub curves: Vec<Curve>,
}

/// What an axis shows.
#[derive(Clone, Debug, Default)]
pub struct Axis {
    /// Its name, with markup.
    pub label: String,
    /// Its unit; none if empty.
    pub unit: String,
    /// Whether a power of ten has the same length everywhere; values that are not positive do not show then.
    pub is_logarithmic: bool,
}

/// A line through points. One that is not finite breaks it.
#[derive(Clone, Debug, Default)]
pub struct Curve {
    /// Its name in the legend, with markup; one without a name is not in it.
    pub label: String,
    /// Which of the colours it has.
    pub colour: usize,
    /// Which of the dash patterns it has.
    pub dash: usize,
    /// Whether it is broad and pale, so that a curve over it does not hide it.
    pub is_broad: bool,
    /// Whether its points are marked by dots.
    pub is_dotted: bool,
    /// Its points.
    pub points: Vec<[f64; 2]>,
}

/// Width and height of a panel with its labels.
const PANEL: [f64; 2] = [430.0, 310.0];
/// From the edges of a panel to its frame.
const LEFT: f64 = 68.0;
const RIGHT: f64 = 16.0;
const TOP: f64 = 12.0;
const BOTTOM: f64 = 50.0;
/// Height of the title.
const TITLE: f64 = 34.0;
/// Sizes of type.
const TITLE_SIZE: f64 = 15.0;
const LABEL_SIZE: f64 = 13.0;
const TICK_SIZE: f64 = 11.5;
const LEGEND_SIZE: f64 = 11.5;
/// Of a legend: height of a row, length of the piece of line, distance to frame and curves.
const ROW: f64 = 17.0;
const SAMPLE: f64 = 30.0;
const MARGIN: f64 = 8.0;

const INK: Colour = [32, 32, 32];
const GRID: Colour = [226, 226, 226];
const ZERO: Colour = [160, 160, 160];
/// Colours that people with any colour vision tell apart, also in print (Okabe & Ito 2008).
pub const COLOURS: [Colour; 7] =
    [[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [230, 159, 0], [86, 180, 233], [0, 0, 0]];
/// The first is the widest, so that a dashed curve over it does not hide it.
const PENS: [(f64, &[f64]); 4] = [(2.4, &[]), (1.8, &[7.0, 3.0]), (1.8, &[2.0, 2.2]), (1.8, &[8.0, 2.5, 2.0, 2.5])];

fn pen(curve: &Curve) -> Ink {
    let (width, dashes) = PENS[curve.dash % PENS.len()];
    let colour = COLOURS[curve.colour % COLOURS.len()];
    if curve.is_broad {
        let pale = colour.map(|part| part / 2 + 127);
        return Ink::Stroke { colour: pale, width: 2.0 * width, dashes };
    }
    Ink::Stroke { colour, width, dashes }
}

fn hairline(colour: Colour) -> Ink {
    Ink::Stroke { colour, width: 0.8, dashes: &[] }
}

impl Figure {
    /// The figure, laid out.
    pub fn drawing(&self) -> Drawing {
        let columns = self.panels.len().clamp(1, 2);
        let rows = self.panels.len().div_ceil(columns);
        let title = if self.title.is_empty() { 0.0 } else { TITLE };
        let size = [PANEL[0] * columns as f64, PANEL[1] * rows as f64 + title];
        let mut drawing = Drawing::new(size);
        if !self.title.is_empty() {
            let at = [0.5 * size[0], 0.5 * (TITLE + TITLE_SIZE * CAPITAL_HEIGHT) + 1.0];
            // a title that is too long is set smaller
            let fits = (size[0] - 2.0 * MARGIN) / text::width(&self.title, TITLE_SIZE);
            let size = TITLE_SIZE * fits.min(1.0);
            let placement = Placement { at, size, anchor: Anchor::Middle, upright: false };
            text::write(&mut drawing, &self.title, placement, INK);
        }
        for (index, panel) in self.panels.iter().enumerate() {
            let corner = [PANEL[0] * (index % columns) as f64, PANEL[1] * (index / columns) as f64 + title];
            panel.draw(&mut drawing, corner);
        }
        drawing
    }
}

impl Panel {
    fn draw(&self, drawing: &mut Drawing, [left, top]: [f64; 2]) {
        let points = || self.curves.iter().flat_map(|curve| &curve.points).filter(|p| p.iter().all(|c| c.is_finite()));
        let x = Scale::new(&self.x, points().map(|point| point[0]), 0.0, [left + LEFT, left + PANEL[0] - RIGHT]);
        let height = [top + PANEL[1] - BOTTOM, top + TOP];
        // room above the curves until the legend has a place
        let mut headroom = 0.0;
        let ((frame, lines), legend) = loop {
            let y = Scale::new(&self.y, points().map(|point| point[1]), headroom, height);
            let mut frame = Frame { x: x.clone(), y };
            if self.is_isometric {
                frame.make_isometric();
            }
            let lines: Vec<Vec<Vec<[f64; 2]>>> = self.curves.iter().map(|curve| frame.lines(curve)).collect();
            let place = self.legend_place(&frame, &lines);
            if place.is_some() || headroom > MOST_HEADROOM || self.named().count() < 2 {
                break ((frame, lines), place);
            }
            headroom += 0.1;
        };
        frame.draw(drawing, self);
        for (curve, lines) in self.curves.iter().zip(&lines) {
            lines.iter().for_each(|line| drawing.line(line, pen(curve)));
            if curve.is_dotted {
                frame.places(curve).into_iter().flatten().for_each(|place| draw_dot(drawing, place, curve));
            }
        }
        if let Some(corner) = legend
            && self.named().count() > 1
        {
            self.draw_legend(drawing, corner);
        }
    }

    /// The curves that the legend names.
    fn named(&self) -> impl Iterator<Item = &Curve> {
        self.curves.iter().filter(|curve| !curve.label.is_empty())
    }

    fn legend_size(&self) -> [f64; 2] {
        let widest = self.named().map(|curve| text::width(&curve.label, LEGEND_SIZE)).fold(0.0, f64::max);
        [SAMPLE + 6.0 + widest, ROW * self.named().count() as f64]
    }

    /// The corner of a legend that no line crosses: the first that is free, from the right above to the left below.
    fn legend_place(&self, frame: &Frame, lines: &[Vec<Vec<[f64; 2]>>]) -> Option<[f64; 2]> {
        let [width, height] = self.legend_size();
        let [[left, right], [bottom, top]] = [frame.x.pixels, frame.y.pixels];
        let points: Vec<[f64; 2]> = lines.iter().flatten().flat_map(|line| dense(line)).collect();
        const PLACES: usize = 12;
        let along = |from: f64, to: f64, index: usize| from + (to - from) * index as f64 / PLACES as f64;
        let is_free = |[x, y]: [f64; 2]| {
            let inside = |p: &[f64; 2]| {
                x - MARGIN < p[0] && p[0] < x + width + MARGIN && y - MARGIN < p[1] && p[1] < y + height + MARGIN
            };
            !points.iter().any(inside)
        };
        let (first, last) = ([right - MARGIN - width, top + MARGIN], [left + MARGIN, bottom - MARGIN - height]);
        if first[0] < left || last[1] < top {
            return None;
        }
        let places = (0..=PLACES).flat_map(|row| (0..=PLACES).map(move |column| (row, column)));
        places
            .map(|(row, column)| [along(first[0], last[0], column), along(first[1], last[1], row)])
            .find(|p| is_free(*p))
    }

    fn draw_legend(&self, drawing: &mut Drawing, [left, top]: [f64; 2]) {
        for (row, curve) in self.named().enumerate() {
            let middle = top + ROW * (row as f64 + 0.5);
            drawing.line(&[[left, middle], [left + SAMPLE, middle]], pen(curve));
            if curve.is_dotted {
                draw_dot(drawing, [left + 0.5 * SAMPLE, middle], curve);
            }
            let at = [left + SAMPLE + 6.0, middle + 0.5 * LEGEND_SIZE * CAPITAL_HEIGHT];
            let placement = Placement { at, size: LEGEND_SIZE, anchor: Anchor::Start, upright: false };
            text::write(drawing, &curve.label, placement, INK);
        }
    }
}

/// Radius of a dot.
const DOT: f64 = 2.6;

fn draw_dot(drawing: &mut Drawing, [x, y]: [f64; 2], curve: &Curve) {
    // an octagon of this size looks round
    let corners: Vec<[f64; 2]> = (0..8)
        .map(|k| {
            let (sine, cosine) = (std::f64::consts::TAU * (f64::from(k) + 0.5) / 8.0).sin_cos();
            [x + DOT * cosine, y + DOT * sine]
        })
        .collect();
    drawing.polygon(&corners, Ink::Fill(COLOURS[curve.colour % COLOURS.len()]));
}

/// A legend that needs more room than this above the curves, beside their range, has too many rows to be read: it is left out.
const MOST_HEADROOM: f64 = 2.0;

/// Points on a line, no farther from one another than a few units.
fn dense(line: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut points: Vec<[f64; 2]> = line.first().copied().into_iter().collect();
    for pair in line.windows(2) {
        let [[a, b], [c, d]] = [pair[0], pair[1]];
        let pieces = ((c - a).hypot(d - b) / 4.0).ceil().clamp(1.0, 1e3);
        points.extend((1..=pieces as usize).map(|k| {
            let fraction = k as f64 / pieces;
            [a + (c - a) * fraction, b + (d - b) * fraction]
        }));
    }
    points
}

/// The two scales of a panel.
struct Frame {
    x: Scale,
    y: Scale,
}

impl Frame {
    /// The points of a curve in the drawing, in the pieces that it is broken into.
    fn places(&self, curve: &Curve) -> Vec<Vec<[f64; 2]>> {
        let places: Vec<[f64; 2]> = curve.points.iter().map(|[x, y]| [self.x.place(*x), self.y.place(*y)]).collect();
        let pieces = places.split(|place| !place.iter().all(|c| c.is_finite()));
        pieces.filter(|piece| !piece.is_empty()).map(<[_]>::to_vec).collect()
    }

    /// The same, those points left out that do not show.
    fn lines(&self, curve: &Curve) -> Vec<Vec<[f64; 2]>> {
        self.places(curve).iter().map(|piece| simplified(piece)).collect()
    }

    /// Widens one of the scales until a unit is as long on both.
    fn make_isometric(&mut self) {
        let unit = |scale: &Scale| (scale.pixels[1] - scale.pixels[0]).abs() / (scale.values[1] - scale.values[0]);
        let shorter = unit(&self.x).min(unit(&self.y));
        for scale in [&mut self.x, &mut self.y] {
            let half = 0.5 * (scale.pixels[1] - scale.pixels[0]).abs() / shorter;
            let middle = 0.5 * (scale.values[0] + scale.values[1]);
            scale.values = [middle - half, middle + half];
        }
    }

    fn draw(&self, drawing: &mut Drawing, panel: &Panel) {
        let [[left, right], [bottom, top]] = [self.x.pixels, self.y.pixels];
        let write = |drawing: &mut Drawing, text: &str, at, size, anchor, upright| {
            text::write(drawing, text, Placement { at, size, anchor, upright }, INK);
        };
        let shade = |value: f64| hairline(if value == 0.0 { ZERO } else { GRID });
        let x_ticks = self.x.ticks();
        for minor in self.x.minor_ticks() {
            drawing.line(&[[minor, bottom], [minor, bottom + 2.5]], hairline(INK));
        }
        for minor in self.y.minor_ticks() {
            drawing.line(&[[left - 2.5, minor], [left, minor]], hairline(INK));
        }
        for tick in &x_ticks.values {
            let x = self.x.place(*tick);
            drawing.line(&[[x, bottom], [x, top]], shade(*tick));
            drawing.line(&[[x, bottom], [x, bottom + 4.0]], hairline(INK));
            let at = [x, bottom + 7.0 + TICK_SIZE * CAPITAL_HEIGHT];
            write(drawing, &x_ticks.text(*tick), at, TICK_SIZE, Anchor::Middle, false);
        }
        let y_ticks = self.y.ticks();
        for tick in &y_ticks.values {
            let y = self.y.place(*tick);
            drawing.line(&[[left, y], [right, y]], shade(*tick));
            drawing.line(&[[left - 4.0, y], [left, y]], hairline(INK));
            let at = [left - 7.0, y + 0.5 * TICK_SIZE * CAPITAL_HEIGHT];
            write(drawing, &y_ticks.text(*tick), at, TICK_SIZE, Anchor::End, false);
        }
        drawing.rectangle([left, top], [right, bottom], hairline(INK));
        let at = [0.5 * (left + right), bottom + 38.0];
        write(drawing, &panel.x.text(&x_ticks), at, LABEL_SIZE, Anchor::Middle, false);
        // a long label is set smaller, so that it stays beside its axis
        let label = panel.y.text(&y_ticks);
        let size = LABEL_SIZE * ((bottom - top) / text::width(&label, LABEL_SIZE)).min(1.0);
        write(drawing, &label, [left - 50.0, 0.5 * (bottom + top)], size, Anchor::Middle, true);
    }
}

impl Axis {
    /// Name and unit, with the power of ten that the ticks leave out.
    fn text(&self, ticks: &Ticks) -> String {
        let power = match ticks.power {
            0 => String::new(),
            power => format!("10^{{{}}}", power.to_string().replace('-', "−")),
        };
        match (power.as_str(), self.unit.as_str()) {
            ("", "") => self.label.clone(),
            (power, "") => format!("{} ({power})", self.label),
            ("", unit) => format!("{} ({unit})", self.label),
            (power, unit) => format!("{} ({power} {unit})", self.label),
        }
    }
}

/// From values to places in the drawing.
#[derive(Clone, Debug)]
struct Scale {
    /// The ends: values, or their logarithms to the base 10.
    values: [f64; 2],
    pixels: [f64; 2],
    is_logarithmic: bool,
}

impl Scale {
    /// The scale that shows all values. Vertical scales (those that run upwards) leave a little room at both ends, and at
    /// their upper end so much more of the range.
    fn new(axis: &Axis, values: impl Iterator<Item = f64>, headroom: f64, pixels: [f64; 2]) -> Self {
        let is_logarithmic = axis.is_logarithmic;
        let shown = values.map(|value| if is_logarithmic { value.log10() } else { value }).filter(|v| v.is_finite());
        let range = shown.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)]);
        let [mut low, mut high] = if range[0] <= range[1] { range } else { [0.0, 1.0] };
        let magnitude = low.abs().max(high.abs());
        // what is constant but for rounding is shown as constant
        if high - low <= 1e-6 * magnitude {
            let room = if magnitude == 0.0 { 1.0 } else { 0.1 * magnitude };
            [low, high] = [low - room, high + room];
        }
        let range = high - low;
        let room = if pixels[1] < pixels[0] { 0.05 * range } else { 0.0 };
        Self { values: [low - room, high + room + headroom * range], pixels, is_logarithmic }
    }

    /// The place of a value; not a number for one that has none.
    fn place(&self, value: f64) -> f64 {
        let value = if self.is_logarithmic { value.log10() } else { value };
        let ([low, high], [from, to]) = (self.values, self.pixels);
        from + (to - from) * ((value - low) / (high - low))
    }

    /// Places between the labels of a logarithmic scale.
    fn minor_ticks(&self) -> Vec<f64> {
        if !self.is_logarithmic {
            return Vec::new();
        }
        let [low, high] = self.values;
        let decades = low.floor() as i32..=high.floor() as i32;
        let digits = decades.flat_map(|decade| (2..=9).map(move |digit| f64::from(digit) * 10_f64.powi(decade)));
        digits.filter(|value| (low..=high).contains(&value.log10())).map(|value| self.place(value)).collect()
    }

    /// Round values, as many as their labels have room for.
    fn ticks(&self) -> Ticks {
        let [low, high] = self.values;
        let length = self.pixels[1] - self.pixels[0];
        // the labels of a vertical axis stand closer
        let most = (length.abs() / if length > 0.0 { 55.0 } else { 42.0 }).max(2.0);
        if self.is_logarithmic {
            let step = ((high - low) / most).ceil().max(1.0) as i32;
            let first = (low / f64::from(step) - 1e-9).ceil() as i32 * step;
            let decades = (first..).step_by(step as usize).take_while(|decade| f64::from(*decade) <= high + 1e-9);
            return Ticks { values: decades.map(|decade| 10_f64.powi(decade)).collect(), power: 0, decimals: None };
        }
        let raw = (high - low) / most;
        let largest = low.abs().max(high.abs());
        if !raw.is_normal() || raw < largest * 1e-12 {
            // no step between them can be told in digits
            return Ticks { values: vec![low], power: 0, decimals: Some(0) };
        }
        let decade = 10_f64.powf(raw.log10().floor());
        let step = [1.0, 2.0, 5.0].map(|digit| digit * decade).into_iter().find(|step| *step >= raw);
        let step = step.unwrap_or(10.0 * decade);
        let (first, last) = ((low / step - 1e-9).ceil() as i64, (high / step + 1e-9).floor() as i64);
        let exponent = largest.log10().floor() as i32;
        let power = if (-2..4).contains(&exponent) { 0 } else { exponent };
        let step_exponent = (step.log10() + 1e-9).floor() as i32;
        Ticks {
            values: (first..=last).map(|count| count as f64 * step).collect(),
            power,
            decimals: Some((power - step_exponent).max(0) as usize),
        }
    }
}

/// Values at which an axis is labelled.
struct Ticks {
    values: Vec<f64>,
    /// The power of ten that the labels leave out.
    power: i32,
    /// None where the values are powers of ten.
    decimals: Option<usize>,
}

impl Ticks {
    fn text(&self, value: f64) -> String {
        let text = match self.decimals {
            Some(decimals) => format!("{:.*}", decimals.min(17), value / 10_f64.powi(self.power)),
            None => format!("10^{{{}}}", value.log10().round()),
        };
        text.replace('-', "−")
    }
}

/// A line that differs from the one through all points by less than shows (Ramer 1972, Douglas & Peucker 1973).
fn simplified(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    const INVISIBLE: f64 = 0.05;
    let Some(last) = points.len().checked_sub(1) else { return Vec::new() };
    let mut is_kept = vec![false; points.len()];
    (is_kept[0], is_kept[last]) = (true, true);
    let mut spans = vec![(0, last)];
    while let Some((from, to)) = spans.pop() {
        let away = |index: usize| (distance(points[index], points[from], points[to]), index);
        let farthest = (from + 1..to).map(away).max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((distance, index)) = farthest
            && distance > INVISIBLE
        {
            is_kept[index] = true;
            spans.extend([(from, index), (index, to)]);
        }
    }
    points.iter().zip(is_kept).filter(|(_, is_kept)| *is_kept).map(|(point, _)| *point).collect()
}

/// Distance of a point from the piece of line between two others.
fn distance(point: [f64; 2], from: [f64; 2], to: [f64; 2]) -> f64 {
    let [along, offset] = [[to[0] - from[0], to[1] - from[1]], [point[0] - from[0], point[1] - from[1]]];
    let squared = along[0] * along[0] + along[1] * along[1];
    let fraction = ((offset[0] * along[0] + offset[1] * along[1]) / squared.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    (offset[0] - fraction * along[0]).hypot(offset[1] - fraction * along[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ticks(low: f64, high: f64) -> (Vec<String>, i32) {
        let ticks = Scale { values: [low, high], pixels: [0.0, 330.0], is_logarithmic: false }.ticks();
        (ticks.values.iter().map(|value| ticks.text(*value)).collect(), ticks.power)
    }

    #[test]
    fn ticks_are_round_and_have_the_digits_they_need() {
        assert_eq!(ticks(0.0, 0.2), (["0.00", "0.05", "0.10", "0.15", "0.20"].map(String::from).to_vec(), 0));
        assert_eq!(ticks(-260.0, 260.0).0, ["−200", "−100", "0", "100", "200"]);
        assert_eq!(ticks(0.0, 1.3e-3), (["0.0", "0.5", "1.0"].map(String::from).to_vec(), -3));
        let (labels, power) = ticks(0.0, 2.6e8);
        assert_eq!((labels[1].as_str(), power), ("0.5", 8));
        assert_eq!(ticks(999.9999, 1000.0001).0.len(), 5);
        assert_eq!(ticks(0.0, 0.02).0[1], "0.005");
    }

    #[test]
    fn a_line_keeps_its_corners_and_loses_what_lies_between() {
        let points: Vec<[f64; 2]> = (0..=100).map(|k| [f64::from(k), f64::from((k - 50_i32).abs())]).collect();
        assert_eq!(simplified(&points), [[0.0, 50.0], [50.0, 0.0], [100.0, 50.0]]);
        // there and back again along one line
        let points = [[0.0, 0.0], [5.0, 0.0], [10.0, 0.0], [5.0, 0.0], [0.0, 0.0]];
        assert_eq!(simplified(&points), [[0.0, 0.0], [10.0, 0.0], [0.0, 0.0]]);
        assert!(simplified(&[]).is_empty());
    }

    #[test]
    fn powers_of_ten_have_the_same_distance_on_a_logarithmic_axis() {
        let axis = Axis { is_logarithmic: true, ..Axis::default() };
        let scale = Scale::new(&axis, [1e-3, 1e-1, 10.0, 0.0, -1.0].into_iter(), 0.0, [0.0, 400.0]);
        assert_eq!([1e-3, 1e-2, 0.1, 10.0].map(|value| scale.place(value).round()), [0.0, 100.0, 200.0, 400.0]);
        assert!(!scale.place(0.0).is_finite() && !scale.place(-1.0).is_finite());
        let ticks = scale.ticks();
        let labels: Vec<String> = ticks.values.iter().map(|value| ticks.text(*value)).collect();
        assert_eq!(labels, ["10^{−3}", "10^{−2}", "10^{−1}", "10^{0}", "10^{1}"]);
        assert_eq!(scale.minor_ticks().len(), 4 * 8);
    }

    #[test]
    fn a_point_that_is_no_number_breaks_a_line() {
        let points = vec![[0.0, 0.0], [1.0, 1.0], [f64::NAN, 0.0], [2.0, 0.0], [3.0, 1.0]];
        let curve = Curve { points, ..Curve::default() };
        let scale = |axis: &Axis| Scale::new(axis, [0.0, 3.0].into_iter(), 0.0, [0.0, 30.0]);
        let frame = Frame { x: scale(&Axis::default()), y: scale(&Axis::default()) };
        assert_eq!(frame.lines(&curve), [[[0.0, 0.0], [10.0, 10.0]], [[20.0, 0.0], [30.0, 10.0]]]);
    }

    #[test]
    fn no_curve_crosses_the_legend() {
        let curve = |shift: f64| Curve {
            label: "a curve with a name".to_owned(),
            points: (0..=400).map(|k| [f64::from(k), (0.1 * f64::from(k)).sin() + shift]).collect(),
            ..Curve::default()
        };
        let axis = || Axis { label: "x".to_owned(), unit: "MPa".to_owned(), ..Axis::default() };
        let curves = vec![curve(0.0), curve(0.5), curve(1.0)];
        let panel = Panel { x: axis(), y: axis(), curves, ..Panel::default() };
        let scale = |headroom| Scale::new(&axis(), [-1.0, 2.0].into_iter(), headroom, [300.0, 0.0]);
        let lines = |frame: &Frame| -> Vec<_> { panel.curves.iter().map(|curve| frame.lines(curve)).collect() };
        let x = Scale::new(&axis(), [0.0, 400.0].into_iter(), 0.0, [0.0, 400.0]);
        let full = Frame { x: x.clone(), y: scale(0.0) };
        assert_eq!(panel.legend_place(&full, &lines(&full)), None);
        let roomy = Frame { x, y: scale(0.5) };
        let [left, top] = panel.legend_place(&roomy, &lines(&roomy)).unwrap();
        let [width, height] = panel.legend_size();
        assert!(left >= 0.0 && left + width <= 400.0 && top >= 0.0 && top + height < 150.0);
    }

    #[test]
    fn curves_without_points_range_or_finite_values_are_drawn() {
        let axis = |is_logarithmic| Axis { label: "T_{11}".to_owned(), is_logarithmic, ..Axis::default() };
        for points in
            [vec![], vec![[1.0, 1.0]], vec![[0.0, f64::NAN], [f64::INFINITY, 1.0]], vec![[0.0, 1e300], [1.0, -1e300]]]
        {
            for is_logarithmic in [false, true] {
                let curve = Curve {
                    label: "T".to_owned(),
                    colour: 9,
                    dash: 9,
                    is_broad: true,
                    is_dotted: true,
                    points: points.clone(),
                };
                let (x, y) = (axis(is_logarithmic), axis(is_logarithmic));
                let panel = Panel { x, y, is_isometric: true, curves: vec![curve] };
                let figure = Figure { title: "x".repeat(500), panels: vec![panel.clone(), panel.clone(), panel] };
                assert!(figure.drawing().png(1.0).is_some());
            }
        }
        assert!(Figure { title: String::new(), panels: Vec::new() }.drawing().svg().contains("<svg"));
    }
}
