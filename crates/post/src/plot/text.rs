//! Type set as outlines. `_{...}` lowers and `^{...}` raises what stands in the braces.

use super::drawing::{Colour, Drawing, Ink, Segment};
use skrifa::instance::{LocationRef, Size};
use skrifa::outline::{DrawSettings, OutlineGlyphCollection, OutlinePen};
use skrifa::{FontRef, GlyphId, MetadataProvider};

/// DejaVu Sans 2.37, cut down to Latin, Greek and the signs of formulas (licence beside it).
const FONT: &[u8] = include_bytes!("font/DejaVuSans.ttf");

/// Which point of a text is where it is put.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// Its beginning.
    Start,
    /// Its middle.
    Middle,
    /// Its end.
    End,
}

/// Where and how a text is set.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    /// On the base line.
    pub at: [f64; 2],
    /// Height of the type.
    pub size: f64,
    /// Which point of the text is there.
    pub anchor: Anchor,
    /// Whether it runs upwards.
    pub upright: bool,
}

/// The height of capital letters over the size of the type.
pub const CAPITAL_HEIGHT: f64 = 0.73;
/// Size of what is lowered or raised.
const SCRIPT_SIZE: f64 = 0.7;
/// How far it is below the base line.
const LOWERED: f64 = 0.2;
const RAISED: f64 = -0.36;

/// Sets a text.
pub fn write(drawing: &mut Drawing, text: &str, placement: Placement, colour: Colour) {
    let Some(font) = font() else { return };
    let glyphs = glyphs(&font, text);
    let shift = match placement.anchor {
        Anchor::Start => 0.0,
        Anchor::Middle => -0.5 * advance(&glyphs),
        Anchor::End => -advance(&glyphs),
    };
    let [x, y] = placement.at;
    let outlines: OutlineGlyphCollection<'_> = font.outline_glyphs();
    let mut outline = Vec::new();
    for glyph in glyphs {
        let place = |u: f64, v: f64| {
            let along = (glyph.offset + shift + u * glyph.scale) * placement.size;
            let across = (glyph.drop - v * glyph.scale) * placement.size;
            if placement.upright { [x + across, y - along] } else { [x + along, y + across] }
        };
        // a glyph without an outline is a blank
        let Some(shape) = outlines.get(glyph.id) else { continue };
        // the tests draw every glyph of the font
        let _ = shape.draw(settings(), &mut Pen { outline: &mut outline, place, start: [0.0; 2] });
    }
    drawing.draw(outline, Ink::Fill(colour));
}

/// The width of a text.
pub fn width(text: &str, size: f64) -> f64 {
    font().map_or(0.0, |font| advance(&glyphs(&font, text)) * size)
}

/// Outlines in the font's own units.
fn settings() -> DrawSettings<'static> {
    DrawSettings::unhinted(Size::unscaled(), LocationRef::default())
}

fn font() -> Option<FontRef<'static>> {
    FontRef::new(FONT).ok()
}

/// A glyph in its place on a line of type of size 1.
struct Glyph {
    id: GlyphId,
    /// Where it begins.
    offset: f64,
    /// How far it goes on.
    advance: f64,
    /// How far it is below the base line.
    drop: f64,
    /// Size 1 over the font's own units, smaller for what is lowered or raised.
    scale: f64,
}

fn advance(glyphs: &[Glyph]) -> f64 {
    glyphs.last().map_or(0.0, |glyph| glyph.offset + glyph.advance)
}

fn glyphs(font: &FontRef<'_>, text: &str) -> Vec<Glyph> {
    let (characters, metrics) = (font.charmap(), font.glyph_metrics(Size::unscaled(), LocationRef::default()));
    let per_unit = f64::from(font.metrics(Size::unscaled(), LocationRef::default()).units_per_em).recip();
    let mut glyphs = Vec::new();
    let mut offset = 0.0;
    // how far the type is lowered, inside of braces
    let mut script: Option<f64> = None;
    let mut rest = text;
    while let Some(character) = rest.chars().next() {
        let begins = [("_{", LOWERED), ("^{", RAISED)].into_iter().find(|(mark, _)| rest.starts_with(mark));
        if let (Some((mark, drop)), None) = (begins, script) {
            script = Some(drop);
            rest = &rest[mark.len()..];
            continue;
        }
        rest = &rest[character.len_utf8()..];
        if character == '}' && script.take().is_some() {
            continue;
        }
        let id = characters.map(character).unwrap_or_default();
        let scale = if script.is_some() { SCRIPT_SIZE * per_unit } else { per_unit };
        let advance = f64::from(metrics.advance_width(id).unwrap_or_default()) * scale;
        glyphs.push(Glyph { id, offset, advance, drop: script.unwrap_or(0.0), scale });
        offset += advance;
    }
    glyphs
}

struct Pen<'a, P> {
    outline: &'a mut Vec<Segment>,
    place: P,
    /// Where the contour began.
    start: [f64; 2],
}

impl<P: Fn(f64, f64) -> [f64; 2]> Pen<'_, P> {
    fn point(&self, x: f32, y: f32) -> [f64; 2] {
        (self.place)(f64::from(x), f64::from(y))
    }
}

impl<P: Fn(f64, f64) -> [f64; 2]> OutlinePen for Pen<'_, P> {
    fn move_to(&mut self, x: f32, y: f32) {
        self.start = self.point(x, y);
        self.outline.push(Segment::Move(self.start));
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.outline.push(Segment::Line(self.point(x, y)));
    }

    fn quad_to(&mut self, a: f32, b: f32, x: f32, y: f32) {
        self.outline.push(Segment::Quadratic(self.point(a, b), self.point(x, y)));
    }

    /// The font is TrueType: its outlines have no cubic curves.
    fn curve_to(&mut self, _: f32, _: f32, _: f32, _: f32, x: f32, y: f32) {
        self.line_to(x, y);
    }

    fn close(&mut self) {
        // a straight last piece is left out by the font
        let is_back =
            matches!(self.outline.last(), Some(Segment::Line(end) | Segment::Quadratic(_, end)) if *end == self.start);
        if !is_back {
            self.outline.push(Segment::Line(self.start));
        }
        self.outline.push(Segment::Close);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn braces_are_markup_and_not_set() {
        assert!(width("T_{11}", 10.0) < width("T11", 10.0));
        assert!(width("T_{11}", 10.0) > width("T", 10.0));
        assert_eq!(width("E^{p}", 10.0), width("E_{p}", 10.0));
        // braces without a mark, and marks without braces, are characters
        assert!(width("{a}", 10.0) > width("a", 10.0) && width("a_b", 10.0) > width("ab", 10.0));
        assert_eq!(width("", 10.0), 0.0);
    }

    #[test]
    fn the_font_has_what_labels_need() {
        let characters = font().unwrap().charmap();
        for character in ('!'..='~').chain("αβγεκλμνσττφΔΣΦ·×−±≤≥√°µᵀ".chars()) {
            assert!(characters.map(character).is_some(), "{character}");
        }
    }

    #[test]
    fn every_glyph_of_the_font_is_drawn() {
        let font = font().unwrap();
        let outlines = font.outline_glyphs();
        let mut drawn = 0;
        for (character, id) in font.charmap().mappings() {
            let mut outline = Vec::new();
            let pen = &mut Pen { outline: &mut outline, place: |x, y| [x, y], start: [0.0; 2] };
            outlines.get(id).unwrap().draw(settings(), pen).unwrap();
            drawn += usize::from(!outline.is_empty());
            let is_blank = char::from_u32(character).is_none_or(char::is_whitespace);
            assert!(is_blank || !outline.is_empty(), "{character:x}");
        }
        assert!(drawn > 150, "{drawn}");
    }

    #[test]
    fn any_text_is_set() {
        let mut drawing = Drawing::new([10.0, 10.0]);
        let placement = Placement { at: [0.0, 0.0], size: 10.0, anchor: Anchor::End, upright: true };
        for text in ["_{", "^{a", "}", "_{_{a}}", "\u{0}\u{10ffff}", "日本", "a\u{304}"] {
            write(&mut drawing, text, placement, [0, 0, 0]);
        }
        assert!(drawing.png(1.0).is_some());
    }
}
