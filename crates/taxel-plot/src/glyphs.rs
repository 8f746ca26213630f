//! Text as outlines of the shipped font. The rasteriser could set text itself, with shaping for all the world's scripts,
//! at a seventh of this program's compile time; labels of axes need none of it.

use std::fmt::Write;
use std::sync::OnceLock;

use resvg::usvg::{Options, Tree};
use ttf_parser::{Face, GlyphId, OutlineBuilder};

use crate::Error;
use crate::svg::number;

/// Inter Regular, reduced; its licence is in `fonts/OFL.txt`.
const FONT: &[u8] = include_bytes!("../fonts/Inter-Regular-subset.ttf");

/// What the path of a text is called, before its number.
const NAME: &str = "taxel-text-";

/// One text of a document, as it is set.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(not(feature = "pdf"), allow(dead_code))]
pub(crate) struct Line {
    pub(crate) text: String,
    /// Type size, in the units of its path.
    pub(crate) size: f64,
    /// Where its first glyph starts, in the units of its path.
    pub(crate) x: f64,
    /// Its baseline.
    pub(crate) y: f64,
}

/// The bytes of the font.
#[cfg(feature = "pdf")]
pub(crate) fn font_bytes() -> &'static [u8] {
    FONT
}

/// The glyph of a character, the empty box where the font has none.
pub(crate) fn glyph_of(character: char) -> GlyphId {
    font().glyph_index(character).unwrap_or_default()
}

/// How far a glyph moves the next one, in type sizes.
pub(crate) fn advance_of(glyph: GlyphId) -> f64 {
    let face = font();
    f64::from(face.glyph_hor_advance(glyph).unwrap_or(0)) / f64::from(face.units_per_em())
}

/// Width of `text` as it is drawn at type size `size`.
pub(crate) fn width(text: &str, size: f64) -> f64 {
    let advances = text
        .chars()
        .map(|character| advance_of(glyph_of(character)));
    advances.sum::<f64>() * size
}

/// Which of the lines that [`outlined`] gave a path of this name draws.
#[cfg(feature = "pdf")]
pub(crate) fn line_number(name: &str) -> Option<usize> {
    name.strip_prefix(NAME)?.parse().ok()
}

fn font() -> &'static Face<'static> {
    static FACE: OnceLock<Face<'static>> = OnceLock::new();
    FACE.get_or_init(|| Face::parse(FONT, 0).expect("the font that this crate carries"))
}

/// The document with every text element, as [`crate::svg::Canvas`] writes them, in outlines, and what these texts are. The
/// paths are named after the place of their text; in a document that has such names of its own, none is.
pub(crate) fn outlined(svg: &str) -> (String, Vec<Line>) {
    let is_free = !svg.contains(&format!(" id=\"{NAME}"));
    let mut lines = Vec::new();
    let mut out = String::with_capacity(svg.len() + svg.len() / 4);
    let mut rest = svg;
    while let Some(start) = rest.find("<text ") {
        let element = &rest[start..];
        let parts = element.split_once("</text>").and_then(|(open, after)| {
            let (attributes, text) = open.split_once('>')?;
            Some((attributes, text, after))
        });
        let Some((attributes, text, after)) = parts else {
            break;
        };
        out.push_str(&rest[..start]);
        let name = is_free.then(|| format!(" id=\"{NAME}{}\"", lines.len()));
        let line = draw(
            attributes,
            unescaped(text),
            &name.unwrap_or_default(),
            &mut out,
        );
        lines.push(line);
        rest = after;
    }
    out.push_str(rest);
    (out, lines)
}

/// A document without texts as the rasteriser understands it.
pub(crate) fn tree_of(outlines: &str) -> Result<Tree, Error> {
    Tree::from_str(outlines, &Options::default()).map_err(|error| Error::Raster {
        message: error.to_string(),
    })
}

/// One text as one path, its ends where the anchor says.
fn draw(attributes: &str, text: String, name: &str, out: &mut String) -> Line {
    let value = |name: &str| {
        let (_, after) = attributes.split_once(&format!(" {name}=\""))?;
        Some(after.split('"').next().unwrap_or_default())
    };
    let coordinate = |name| {
        value(name)
            .and_then(|text| text.parse().ok())
            .unwrap_or(0.0)
    };
    let face = font();
    let size = coordinate("font-size");
    let width = width(&text, size);
    let before = match value("text-anchor") {
        Some("middle") => width / 2.0,
        Some("end") => width,
        _ => 0.0,
    };
    let mut path = Path {
        scale: size / f64::from(face.units_per_em()),
        x: coordinate("x") - before,
        y: coordinate("y"),
        data: String::new(),
    };
    let line = Line {
        size,
        x: path.x,
        y: path.y,
        text,
    };
    for glyph in line.text.chars().map(glyph_of) {
        face.outline_glyph(glyph, &mut path);
        path.x += size * advance_of(glyph);
    }
    let kept: String = ["transform", "fill", "stroke", "stroke-width"]
        .iter()
        .filter_map(|name| Some(format!(" {name}=\"{}\"", value(name)?)))
        .collect();
    // Writing to a string cannot fail.
    let _ = write!(out, "<path{name} d=\"{}\"{kept}/>", path.data);
    line
}

/// Path data of glyphs at a place; the font's y goes up, the document's down.
struct Path {
    scale: f64,
    x: f64,
    y: f64,
    data: String,
}

impl Path {
    fn push(&mut self, command: char, points: &[(f32, f32)]) {
        self.data.push(command);
        for (i, (x, y)) in points.iter().enumerate() {
            let gap = if i > 0 { " " } else { "" };
            let (x, y) = (
                self.x + self.scale * f64::from(*x),
                self.y - self.scale * f64::from(*y),
            );
            let _ = write!(self.data, "{gap}{} {}", number(x), number(y));
        }
    }
}

impl OutlineBuilder for Path {
    fn move_to(&mut self, x: f32, y: f32) {
        self.push('M', &[(x, y)]);
    }
    fn line_to(&mut self, x: f32, y: f32) {
        self.push('L', &[(x, y)]);
    }
    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.push('Q', &[(x1, y1), (x, y)]);
    }
    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.push('C', &[(x1, y1), (x2, y2), (x, y)]);
    }
    fn close(&mut self) {
        self.data.push('Z');
    }
}

fn unescaped(text: &str) -> String {
    text.replace("&lt;", "<")
        .replace("&gt;", ">")
        .replace("&quot;", "\"")
        .replace("&amp;", "&")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::svg::{Anchor, Canvas};

    #[test]
    fn every_text_becomes_a_path_and_all_else_stays() {
        let mut canvas = Canvas::default();
        canvas.text(10.0, 20.0, 12.0, Anchor::End, "a < b & c");
        canvas.text_upwards(5.0, 50.0, 12.0, "load (g)");
        canvas.strokes("M0 0L1 1", "#123456", 1.0);
        let svg = canvas.finish(100.0, 100.0);
        let (drawn, lines) = outlined(&svg);
        assert!(!drawn.contains("<text") && drawn.contains("#123456"));
        assert_eq!(
            drawn.matches("<path").count(),
            svg.matches("<path").count() + 2
        );
        assert!(drawn.contains("rotate(-90)"));
        assert_eq!(outlined(&drawn), (drawn, Vec::new()));
        let texts: Vec<&str> = lines.iter().map(|line| line.text.as_str()).collect();
        assert_eq!(texts, ["a < b & c", "load (g)"]);
        assert!((lines[0].x + width("a < b & c", 12.0) - 10.0).abs() < 1e-9);
    }

    #[test]
    fn names_of_a_document_that_has_such_ones_are_left_alone() {
        let svg =
            "<svg><rect id=\"taxel-text-0\"/><text x=\"1\" y=\"2\" font-size=\"3\">A</text></svg>";
        assert_eq!(outlined(svg).0.matches("taxel-text-").count(), 1);
    }
}
