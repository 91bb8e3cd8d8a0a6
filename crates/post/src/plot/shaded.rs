//! Shaded pictures of surfaces: an orthographic view through a depth buffer, light from beside the eye, a colour for each value.

use super::drawing::{Colour, Raster};
use super::surface::{Corner, Surface};

/// Where the eye is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Angle from x towards y, degrees.
    pub azimuth: f64,
    /// Angle above the plane of x and y, degrees.
    pub elevation: f64,
}

impl View {
    /// Directions to the right, up and towards the eye.
    fn axes(self) -> [[f64; 3]; 3] {
        let ([sa, ca], [se, ce]) = (sine(self.azimuth), sine(self.elevation));
        [[-sa, ca, 0.0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]]
    }
}

fn sine(degrees: f64) -> [f64; 2] {
    let angle = degrees.to_radians();
    [angle.sin(), angle.cos()]
}

/// How a surface is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Style {
    /// Where the eye is.
    pub view: View,
    /// The values at the two ends of the colours.
    pub range: [f64; 2],
    /// Whether the edges of the faces are drawn.
    pub has_edges: bool,
}

/// A rectangle of the plane of the picture, in m: what is seen.
#[derive(Clone, Copy, Debug)]
pub struct Window {
    /// Its middle.
    pub centre: [f64; 2],
    /// Its width and height.
    pub size: [f64; 2],
}

/// What of the plane of the picture surfaces take up.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    low: [f64; 2],
    high: [f64; 2],
}

impl Extent {
    /// That of nothing.
    pub const NOTHING: Self = Self { low: [f64::INFINITY; 2], high: [f64::NEG_INFINITY; 2] };

    /// Takes in a surface.
    pub fn take_in(&mut self, surface: &Surface, view: View) {
        let [right, up, _] = view.axes();
        for vertex in surface.vertices.iter().filter(|vertex| vertex.iter().all(|x| x.is_finite())) {
            for (i, along) in [dot(vertex, &right), dot(vertex, &up)].into_iter().enumerate() {
                self.low[i] = self.low[i].min(along);
                self.high[i] = self.high[i].max(along);
            }
        }
    }

    /// The window with this extent; that of one metre around the origin where there is nothing.
    pub fn window(self) -> Window {
        let Self { low, high } = self;
        if low[0] > high[0] {
            return Window { centre: [0.0; 2], size: [1.0; 2] };
        }
        Window {
            centre: std::array::from_fn(|i| 0.5 * (low[i] + high[i])),
            size: std::array::from_fn(|i| high[i] - low[i]),
        }
    }
}

impl Window {
    /// The smallest window around a surface.
    pub fn around(surface: &Surface, view: View) -> Self {
        let mut extent = Extent::NOTHING;
        extent.take_in(surface, view);
        extent.window()
    }
}

/// Pixels are the means of so many in a row and in a column.
const FINER: usize = 3;
/// Faces that meet at a sharper angle than this have an edge between them (cosine).
const CREASE: f64 = 0.8;
/// Width of the edges, in pixels of the picture.
const EDGE_WIDTH: f64 = 0.55;
/// How much of an edge's colour is seen.
const EDGE_STRENGTH: f32 = 0.45;
const EDGE: [f32; 3] = [36.0, 28.0, 44.0];
/// Room around the body, as a share of the picture.
const MARGIN: f64 = 0.04;

/// Draws a surface as it is seen through a window, on white; the larger of the window's sides that do not fit decides the scale.
pub fn draw(surface: &Surface, style: &Style, window: &Window, size: [usize; 2]) -> Raster {
    let fine = size.map(|length| length * FINER);
    let mut canvas = Canvas {
        size: fine,
        pixels: vec![[255.0; 3]; fine[0] * fine[1]],
        depths: vec![f64::NEG_INFINITY; fine[0] * fine[1]],
    };
    let axes = style.view.axes();
    let scale = (0..2)
        .map(|i| fine[i] as f64 * (1.0 - 2.0 * MARGIN) / window.size[i].max(f64::MIN_POSITIVE))
        .fold(f64::INFINITY, f64::min);
    let place = |vertex: &[f64; 3]| {
        let [right, up, towards] = axes.map(|axis| dot(vertex, &axis));
        [
            0.5 * fine[0] as f64 + scale * (right - window.centre[0]),
            0.5 * fine[1] as f64 - scale * (up - window.centre[1]),
            scale * towards,
        ]
    };
    let places: Vec<[f64; 3]> = surface.vertices.iter().map(place).collect();
    let normals: Vec<[f64; 3]> = surface.faces.iter().map(|face| normal(face, &surface.vertices)).collect();
    let mut around: Vec<Vec<u32>> = vec![Vec::new(); surface.vertices.len()];
    for (index, face) in surface.faces.iter().enumerate() {
        for corner in face {
            around[corner.vertex as usize].push(index as u32);
        }
    }
    // from above the eye's left shoulder
    let light = unit(std::array::from_fn(|i| axes[2][i] - 0.45 * axes[0][i] + 0.6 * axes[1][i]));
    for (face, own_normal) in surface.faces.iter().zip(&normals) {
        if dot(own_normal, &axes[2]) <= 0.0 {
            continue;
        }
        let spot = |&Corner { vertex, value }: &Corner| {
            // the mean normal of the faces that go on smoothly
            let smooth = around[vertex as usize].iter().map(|&index| &normals[index as usize]);
            let smooth = smooth.filter(|normal| dot(normal, own_normal) > CREASE);
            let sum = smooth.fold([0.0; 3], |sum, normal| std::array::from_fn(|i| sum[i] + normal[i]));
            Spot { place: places[vertex as usize], value, light: dot(&unit(sum), &light).max(0.0) }
        };
        let spots: Vec<Spot> = face.iter().map(spot).collect();
        if spots.iter().any(|spot| spot.place.iter().any(|x| !x.is_finite())) {
            continue;
        }
        let middle = Spot::mean(&spots);
        for (index, first) in spots.iter().enumerate() {
            let second = &spots[(index + 1) % spots.len()];
            canvas.triangle([middle, *first, *second], style);
        }
    }
    canvas.averaged(size)
}

/// A corner of a triangle on the canvas.
#[derive(Clone, Copy)]
struct Spot {
    place: [f64; 3],
    value: f64,
    light: f64,
}

impl Spot {
    fn mean(spots: &[Self]) -> Self {
        let share = (spots.len() as f64).recip();
        let mean = |of: &dyn Fn(&Self) -> f64| spots.iter().map(of).sum::<f64>() * share;
        Self {
            place: std::array::from_fn(|i| mean(&|spot| spot.place[i])),
            value: mean(&|spot| spot.value),
            light: mean(&|spot| spot.light),
        }
    }
}

struct Canvas {
    size: [usize; 2],
    pixels: Vec<[f32; 3]>,
    depths: Vec<f64>,
}

impl Canvas {
    /// A triangle whose side opposite to the first corner is an edge of a face.
    fn triangle(&mut self, spots: [Spot; 3], style: &Style) {
        let [a, b, c] = spots.map(|spot| spot.place);
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if area == 0.0 || !area.is_finite() {
            return;
        }
        let per_area = area.recip();
        // distance from the edge is the weight of the first corner times this height
        let height = area.abs() / (c[0] - b[0]).hypot(c[1] - b[1]).max(f64::MIN_POSITIVE);
        let bounds = |axis: usize| {
            let low = a[axis].min(b[axis]).min(c[axis]).floor().max(0.0) as usize;
            let high = a[axis].max(b[axis]).max(c[axis]).ceil().max(0.0) as usize;
            low..high.min(self.size[axis])
        };
        let (columns, rows) = (bounds(0), bounds(1));
        for row in rows {
            for column in columns.clone() {
                let (x, y) = (column as f64 + 0.5, row as f64 + 0.5);
                let second = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) * per_area;
                let third = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) * per_area;
                let weights = [1.0 - second - third, second, third];
                if weights.iter().any(|&weight| weight < 0.0) {
                    continue;
                }
                let mean = |of: [f64; 3]| weights[0] * of[0] + weights[1] * of[1] + weights[2] * of[2];
                let depth = mean([a[2], b[2], c[2]]);
                let index = row * self.size[0] + column;
                if depth <= self.depths[index] {
                    continue;
                }
                self.depths[index] = depth;
                let colour = colour(mean(spots.map(|spot| spot.value)), style.range);
                let brightness = (0.52 + 0.55 * mean(spots.map(|spot| spot.light))) as f32;
                let mut pixel = colour.map(|part| (f32::from(part) * brightness).min(255.0));
                if style.has_edges && weights[0] * height < EDGE_WIDTH * FINER as f64 {
                    pixel = std::array::from_fn(|i| pixel[i] + EDGE_STRENGTH * (EDGE[i] - pixel[i]));
                }
                self.pixels[index] = pixel;
            }
        }
    }

    fn averaged(&self, size: [usize; 2]) -> Raster {
        let share = ((FINER * FINER) as f32).recip();
        let mut pixels = Vec::with_capacity(size[0] * size[1]);
        for row in 0..size[1] {
            for column in 0..size[0] {
                let mut sum = [0.0_f32; 3];
                for i in 0..FINER {
                    let start = (row * FINER + i) * self.size[0] + column * FINER;
                    for pixel in &self.pixels[start..start + FINER] {
                        sum = std::array::from_fn(|part| sum[part] + pixel[part]);
                    }
                }
                pixels.push(sum.map(|part| (part * share).round() as u8));
            }
        }
        Raster { size, pixels }
    }
}

/// Colours from small to large values: light blue over sand and red to plum, each darker than the one before, so that the order
/// is seen without colour, too.
pub const COLOURS: [Colour; 6] =
    [[221, 230, 238], [246, 217, 166], [240, 163, 85], [221, 95, 50], [168, 32, 47], [90, 15, 60]];
/// Of what is no number.
pub const NO_VALUE: Colour = [170, 170, 170];

/// The colour of a value.
pub fn colour(value: f64, [low, high]: [f64; 2]) -> Colour {
    let share = if high > low { (value - low) / (high - low) } else { 0.5 };
    if !share.is_finite() {
        return NO_VALUE;
    }
    let place = share.clamp(0.0, 1.0) * (COLOURS.len() - 1) as f64;
    let index = (place as usize).min(COLOURS.len() - 2);
    let rest = place - index as f64;
    std::array::from_fn(|part| {
        let (from, to) = (f64::from(COLOURS[index][part]), f64::from(COLOURS[index + 1][part]));
        (from + rest * (to - from)).round() as u8
    })
}

fn normal(face: &[Corner], vertices: &[[f64; 3]]) -> [f64; 3] {
    // Newell's sum: half of it is the area vector, also of a face that is not plane
    let mut sum = [0.0; 3];
    for (index, corner) in face.iter().enumerate() {
        let next = face[(index + 1) % face.len()];
        let (a, b) = (vertices[corner.vertex as usize], vertices[next.vertex as usize]);
        sum[0] += (a[1] - b[1]) * (a[2] + b[2]);
        sum[1] += (a[2] - b[2]) * (a[0] + b[0]);
        sum[2] += (a[0] - b[0]) * (a[1] + b[1]);
    }
    unit(sum)
}

fn unit(vector: [f64; 3]) -> [f64; 3] {
    let length = dot(&vector, &vector).sqrt();
    if length > 0.0 { vector.map(|component| component / length) } else { vector }
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    const VIEW: View = View { azimuth: 0.0, elevation: 0.0 };

    /// A square of 1 m in the plane x = `depth`, whose normal points to the eye on the axis x.
    fn square(depth: f64, value: f64) -> Surface {
        let vertices = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[y, z]| [depth, y, z]).to_vec();
        let face = (0..4).map(|vertex| Corner { vertex, value }).collect();
        Surface { vertices, faces: vec![face], ..Surface::default() }
    }

    fn style() -> Style {
        Style { view: VIEW, range: [0.0, 1.0], has_edges: false }
    }

    #[test]
    fn the_nearer_of_two_faces_is_seen_and_white_is_around() {
        let mut both = square(0.0, 0.0);
        let near = square(1.0, 1.0);
        both.vertices.extend(near.vertices);
        both.faces.push((4..8).map(|vertex| Corner { vertex, value: 1.0 }).collect());
        let window = Window::around(&both, VIEW);
        let seen = draw(&both, &style(), &window, [60, 60]);
        let alone = draw(&square(1.0, 1.0), &style(), &window, [60, 60]);
        assert_eq!(seen.pixels, alone.pixels);
        assert_eq!(seen.pixels[0], [255; 3]);
        assert_ne!(seen.pixels[30 * 60 + 30], [255; 3]);
    }

    #[test]
    fn faces_that_look_away_are_not_seen() {
        let mut turned = square(0.0, 0.5);
        turned.faces[0].reverse();
        let window = Window::around(&turned, VIEW);
        assert!(draw(&turned, &style(), &window, [30, 30]).pixels.iter().all(|pixel| *pixel == [255; 3]));
    }

    #[test]
    fn numbers_that_are_none_do_no_harm() {
        let mut broken = square(0.0, f64::NAN);
        broken.vertices[2] = [f64::INFINITY, f64::NAN, 0.0];
        let window = Window::around(&broken, VIEW);
        draw(&broken, &style(), &window, [30, 30]);
        let nothing = Surface::default();
        let window = Window::around(&nothing, VIEW);
        draw(&nothing, &style(), &window, [30, 30]);
        assert_eq!(colour(f64::NAN, [0.0, 1.0]), NO_VALUE);
        assert_eq!(colour(5.0, [1.0, 1.0]), colour(0.5, [0.0, 1.0]));
    }

    #[test]
    fn colours_darken_from_end_to_end() {
        let sums = (0..=20).map(|i| colour(f64::from(i), [0.0, 20.0]).iter().map(|part| u32::from(*part)).sum::<u32>());
        let sums: Vec<u32> = sums.collect();
        assert!(sums.windows(2).all(|pair| pair[1] < pair[0]), "{sums:?}");
    }
}
