//! Filled and stroked outlines, written as SVG or drawn as PNG.

pub use png::EncodingError;

use std::fmt::Write;
use tiny_skia::{FillRule, LineCap, LineJoin, Paint, PathBuilder, Pixmap, Stroke, StrokeDash, Transform};

/// A colour: red, green, blue.
pub type Colour = [u8; 3];

/// A piece of an outline, in units of the drawing; y points down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Segment {
    /// A new beginning.
    Move([f64; 2]),
    /// A straight line.
    Line([f64; 2]),
    /// A quadratic Bézier curve: control point, end.
    Quadratic([f64; 2], [f64; 2]),
    /// A line back to the beginning.
    Close,
}

/// How an outline is drawn.
#[derive(Clone, Debug, PartialEq)]
pub enum Ink {
    /// Its inside is filled.
    Fill(Colour),
    /// It is followed by a pen.
    Stroke {
        /// Its colour.
        colour: Colour,
        /// Its width.
        width: f64,
        /// Lengths of dashes and gaps in turn; none for a solid line.
        dashes: &'static [f64],
    },
}

/// Pixels of a picture, row by row from the top.
#[derive(Clone, Debug)]
pub struct Raster {
    /// Width and height.
    pub size: [usize; 2],
    /// The pixels.
    pub pixels: Vec<Colour>,
}

/// Tenths of a second that a frame of an animation is seen, and the last one.
const DELAYS: [u16; 2] = [1, 15];

impl Raster {
    /// The picture as PNG.
    ///
    /// # Errors
    /// It has no pixels.
    pub fn png(&self) -> Result<Vec<u8>, EncodingError> {
        let mut content = Vec::new();
        let mut writer = self.encoder(&mut content).write_header()?;
        writer.write_image_data(self.pixels.as_flattened())?;
        writer.finish()?;
        Ok(content)
    }

    fn encoder<'a>(&self, content: &'a mut Vec<u8>) -> png::Encoder<'a, &'a mut Vec<u8>> {
        let mut encoder = png::Encoder::new(content, self.size[0] as u32, self.size[1] as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder
    }
}

/// So many pictures of one size, one after another, as an animated PNG that begins again at its end.
///
/// # Errors
/// A picture cannot be made, there are fewer, or they have no pixels.
pub fn animated_png<E: From<EncodingError>>(
    count: usize,
    mut pictures: impl Iterator<Item = Result<Raster, E>>,
) -> Result<Vec<u8>, E> {
    let mut content = Vec::new();
    let Some(first) = pictures.next().transpose()? else { return Ok(content) };
    let mut encoder = first.encoder(&mut content);
    encoder.set_animated(count as u32, 0)?;
    encoder.set_frame_delay(DELAYS[0], 10)?;
    let mut writer = encoder.write_header()?;
    for (index, picture) in std::iter::once(Ok(first)).chain(pictures).enumerate() {
        if index + 1 == count {
            writer.set_frame_delay(DELAYS[1], 10)?;
        }
        writer.write_image_data(picture?.pixels.as_flattened())?;
    }
    writer.finish()?;
    Ok(content)
}

/// Shapes on a white ground, later ones over earlier ones.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    size: [f64; 2],
    shapes: Vec<(Vec<Segment>, Ink)>,
}

impl Drawing {
    /// An empty drawing of a width and a height.
    pub fn new(size: [f64; 2]) -> Self {
        Self { size, shapes: Vec::new() }
    }

    /// Adds an outline.
    pub fn draw(&mut self, outline: Vec<Segment>, ink: Ink) {
        self.shapes.push((outline, ink));
    }

    /// Adds a line through points.
    pub fn line(&mut self, points: &[[f64; 2]], ink: Ink) {
        let later = points.iter().skip(1).map(|point| Segment::Line(*point));
        self.draw(points.iter().take(1).map(|point| Segment::Move(*point)).chain(later).collect(), ink);
    }

    /// Adds a polygon with these corners.
    pub fn polygon(&mut self, corners: &[[f64; 2]], ink: Ink) {
        let later = corners.iter().skip(1).map(|corner| Segment::Line(*corner));
        let first = corners.iter().take(1).map(|corner| Segment::Move(*corner));
        self.draw(first.chain(later).chain([Segment::Close]).collect(), ink);
    }

    /// Adds a rectangle between two corners.
    pub fn rectangle(&mut self, [left, top]: [f64; 2], [right, bottom]: [f64; 2], ink: Ink) {
        self.polygon(&[[left, top], [right, top], [right, bottom], [left, bottom]], ink);
    }

    /// The drawing as SVG.
    pub fn svg(&self) -> String {
        let [width, height] = self.size;
        let mut text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} \
             {height}\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
        );
        for (outline, ink) in &self.shapes {
            text.push_str("<path d=\"");
            for segment in outline {
                // hundredths of a unit are below what can be seen
                let _ = match segment {
                    Segment::Move([x, y]) => write!(text, "M{x:.2} {y:.2}"),
                    Segment::Line([x, y]) => write!(text, "L{x:.2} {y:.2}"),
                    Segment::Quadratic([a, b], [x, y]) => write!(text, "Q{a:.2} {b:.2} {x:.2} {y:.2}"),
                    Segment::Close => write!(text, "Z"),
                };
            }
            let _ = match ink {
                Ink::Fill(colour) => writeln!(text, "\" fill=\"{}\"/>", hex(*colour)),
                Ink::Stroke { colour, width, dashes } => {
                    let dashes = match dashes {
                        [] => String::new(),
                        dashes => {
                            let lengths: Vec<String> = dashes.iter().map(f64::to_string).collect();
                            format!(" stroke-dasharray=\"{}\"", lengths.join(" "))
                        }
                    };
                    let colour = hex(*colour);
                    writeln!(
                        text,
                        "\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\" stroke-linejoin=\"round\"{dashes}/>"
                    )
                }
            };
        }
        text + "</svg>\n"
    }

    /// The drawing as PNG, with so many pixels per unit; nothing if that is more than a picture can hold.
    pub fn png(&self, scale: f64) -> Option<Vec<u8>> {
        self.pixmap(scale)?.encode_png().ok()
    }

    /// The drawing in pixels, so many per unit; nothing if that is more than a picture can hold.
    pub fn raster(&self, scale: f64) -> Option<Raster> {
        let pixmap = self.pixmap(scale)?;
        let size = [pixmap.width(), pixmap.height()].map(|length| length as usize);
        let pixels = pixmap.pixels().iter().map(|pixel| [pixel.red(), pixel.green(), pixel.blue()]).collect();
        Some(Raster { size, pixels })
    }

    fn pixmap(&self, scale: f64) -> Option<Pixmap> {
        let [width, height] = self.size.map(|length| (length * scale).ceil() as u32);
        let mut pixels = Pixmap::new(width, height)?;
        pixels.fill(tiny_skia::Color::WHITE);
        let transform = Transform::from_scale(scale as f32, scale as f32);
        for (outline, ink) in &self.shapes {
            let Some(path) = path(outline) else { continue };
            let mut paint = Paint { anti_alias: true, ..Paint::default() };
            match ink {
                Ink::Fill([r, g, b]) => {
                    paint.set_color_rgba8(*r, *g, *b, 255);
                    pixels.fill_path(&path, &paint, FillRule::Winding, transform, None);
                }
                Ink::Stroke { colour: [r, g, b], width, dashes } => {
                    paint.set_color_rgba8(*r, *g, *b, 255);
                    let stroke = Stroke {
                        width: *width as f32,
                        line_cap: LineCap::Butt,
                        line_join: LineJoin::Round,
                        dash: StrokeDash::new(dashes.iter().map(|length| *length as f32).collect(), 0.0),
                        ..Stroke::default()
                    };
                    pixels.stroke_path(&path, &paint, &stroke, transform, None);
                }
            }
        }
        Some(pixels)
    }
}

fn hex([r, g, b]: Colour) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn path(outline: &[Segment]) -> Option<tiny_skia::Path> {
    let mut builder = PathBuilder::new();
    for segment in outline {
        match *segment {
            Segment::Move([x, y]) => builder.move_to(x as f32, y as f32),
            Segment::Line([x, y]) => builder.line_to(x as f32, y as f32),
            Segment::Quadratic([a, b], [x, y]) => builder.quad_to(a as f32, b as f32, x as f32, y as f32),
            Segment::Close => builder.close(),
        }
    }
    builder.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_formats_have_every_shape() {
        let mut drawing = Drawing::new([20.0, 10.0]);
        drawing.rectangle([2.0, 2.0], [8.0, 8.0], Ink::Fill([255, 0, 0]));
        let pen = Ink::Stroke { colour: [0, 0, 255], width: 1.5, dashes: &[2.0, 1.0] };
        drawing.line(&[[10.0, 5.0], [18.0, 5.0]], pen);
        let svg = drawing.svg();
        assert!(svg.contains("M2.00 2.00L8.00 2.00L8.00 8.00L2.00 8.00Z\" fill=\"#ff0000\""), "{svg}");
        assert!(svg.contains("stroke=\"#0000ff\" stroke-width=\"1.5\"") && svg.contains("stroke-dasharray=\"2 1\""));
        let png = Pixmap::decode_png(&drawing.png(2.0).unwrap()).unwrap();
        assert_eq!((png.width(), png.height()), (40, 20));
        let colour = |x, y| png.pixel(x, y).map(|pixel| [pixel.red(), pixel.green(), pixel.blue()]);
        assert_eq!(colour(10, 10), Some([255, 0, 0]));
        assert_eq!(colour(21, 10), Some([0, 0, 255]));
        assert_eq!(colour(39, 19), Some([255, 255, 255]));
    }

    #[test]
    fn outlines_without_extent_or_number_do_no_harm() {
        let mut drawing = Drawing::new([10.0, 10.0]);
        let pen = Ink::Stroke { colour: [0, 0, 0], width: 1.0, dashes: &[] };
        drawing.line(&[], pen.clone());
        drawing.line(&[[1.0, 1.0]], pen.clone());
        drawing.line(&[[f64::NAN, 1.0], [2.0, 2.0]], pen);
        assert!(drawing.png(1.0).is_some() && drawing.svg().ends_with("</svg>\n"));
        assert!(drawing.png(0.0).is_none());
    }
}
