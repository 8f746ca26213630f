//! Text as outlines of the shipped font. The rasteriser could set text itself, with shaping for all the world's scripts,
//! at a seventh of this program's compile time; labels of axes need none of it.

use std::fmt::Write;
use std::sync::OnceLock;

use ttf_parser::{Face, GlyphId, OutlineBuilder};

use crate::svg::number;

/// Inter Regular, reduced; its licence is in `fonts/OFL.txt`.
const FONT: &[u8] = include_bytes!("../fonts/Inter-Regular-subset.ttf");

fn font() -> &'static Face<'static> {
    static FACE: OnceLock<Face<'static>> = OnceLock::new();
    FACE.get_or_init(|| Face::parse(FONT, 0).expect("the font that this crate carries"))
}

/// The document with every text element, as [`crate::svg::Canvas`] writes them, in outlines.
pub(crate) fn outlined(svg: &str) -> String {
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
        draw(attributes, &unescaped(text), &mut out);
        rest = after;
    }
    out.push_str(rest);
    out
}

/// One text as one path, its ends where the anchor says.
fn draw(attributes: &str, text: &str, out: &mut String) {
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
    let scale = coordinate("font-size") / f64::from(face.units_per_em());
    let glyphs: Vec<GlyphId> = text
        .chars()
        .map(|c| face.glyph_index(c).unwrap_or_default())
        .collect();
    let advance = |glyph: GlyphId| scale * f64::from(face.glyph_hor_advance(glyph).unwrap_or(0));
    let width: f64 = glyphs.iter().map(|&glyph| advance(glyph)).sum();
    let before = match value("text-anchor") {
        Some("middle") => width / 2.0,
        Some("end") => width,
        _ => 0.0,
    };
    let mut path = Path {
        scale,
        x: coordinate("x") - before,
        y: coordinate("y"),
        data: String::new(),
    };
    for glyph in glyphs {
        face.outline_glyph(glyph, &mut path);
        path.x += advance(glyph);
    }
    let place = value("transform").map(|transform| format!(" transform=\"{transform}\""));
    // Writing to a string cannot fail.
    let _ = write!(
        out,
        "<path d=\"{}\"{}/>",
        path.data,
        place.unwrap_or_default()
    );
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
        let drawn = outlined(&svg);
        assert!(!drawn.contains("<text") && drawn.contains("#123456"));
        assert_eq!(
            drawn.matches("<path").count(),
            svg.matches("<path").count() + 2
        );
        assert!(drawn.contains("rotate(-90)"));
        assert_eq!(outlined(&drawn), drawn);
    }
}
