//! Composing an SVG document, piece by piece.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// Colour of text, ticks and frames.
pub(crate) const INK: &str = "#222222";
/// Families asked for: the shipped font first, then what most machines have.
const FAMILIES: &str = "Inter, Helvetica, Arial, sans-serif";

/// A rectangle, x to the right and y down, in SVG points.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Rect {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) width: f64,
    pub(crate) height: f64,
}

impl Rect {
    pub(crate) fn right(&self) -> f64 {
        self.x + self.width
    }

    pub(crate) fn bottom(&self) -> f64 {
        self.y + self.height
    }

    pub(crate) fn moved(&self, x: f64, y: f64) -> Rect {
        Rect {
            x: self.x + x,
            y: self.y + y,
            ..*self
        }
    }
}

/// Which point of a text stands at its position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

impl Anchor {
    fn word(self) -> &'static str {
        match self {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        }
    }
}

/// What a text looks like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Look {
    /// Type size, in points.
    pub(crate) size: f64,
    pub(crate) colour: &'static str,
    pub(crate) bold: bool,
}

/// Width of the stroke about a bold letter, in type sizes: the shipped font has one weight.
const BOLD: f64 = 0.035;

/// The growing document.
#[derive(Debug, Clone, Default)]
pub(crate) struct Canvas {
    body: String,
}

impl Canvas {
    /// Text whose baseline is at `y`.
    pub(crate) fn text(&mut self, x: f64, y: f64, size: f64, anchor: Anchor, text: &str) {
        let place = format!("x=\"{}\" y=\"{}\"", number(x), number(y));
        self.push_text(&place, size, anchor, text);
    }

    /// Text in a look of its own, its baseline at `y`.
    pub(crate) fn styled_text(
        &mut self,
        (x, y): (f64, f64),
        look: Look,
        anchor: Anchor,
        text: &str,
    ) {
        let colour = look.colour;
        let mut place = format!("x=\"{}\" y=\"{}\" fill=\"{colour}\"", number(x), number(y));
        if look.bold {
            let width = number(BOLD * look.size);
            place += &format!(" stroke=\"{colour}\" stroke-width=\"{width}\"");
        }
        self.push_text(&place, look.size, anchor, text);
    }

    /// Text that reads upwards, centred on `y`, its baseline at `x`.
    pub(crate) fn text_upwards(&mut self, x: f64, y: f64, size: f64, text: &str) {
        let place = format!(
            "transform=\"translate({} {}) rotate(-90)\"",
            number(x),
            number(y)
        );
        self.push_text(&place, size, Anchor::Middle, text);
    }

    fn push_text(&mut self, place: &str, size: f64, anchor: Anchor, text: &str) {
        let (size, anchor, text) = (number(size), anchor.word(), escaped(text));
        self.push(format_args!(
            "<text {place} font-size=\"{size}\" text-anchor=\"{anchor}\">{text}</text>"
        ));
    }

    /// An outline without filling.
    pub(crate) fn frame(&mut self, rect: Rect, width: f64) {
        let place = placed(rect);
        self.push(format_args!(
            "<rect {place} fill=\"none\" stroke=\"{INK}\" stroke-width=\"{}\"/>",
            number(width)
        ));
    }

    /// Straight strokes along the path `data`, in absolute SVG path commands.
    pub(crate) fn strokes(&mut self, data: &str, colour: &str, width: f64) {
        if data.is_empty() {
            return;
        }
        self.push(format_args!(
            "<path d=\"{data}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{}\" \
             stroke-linejoin=\"round\" stroke-linecap=\"round\"/>",
            number(width)
        ));
    }

    /// The same in dashes, of a length that suits the width.
    pub(crate) fn dashes(&mut self, data: &str, colour: &str, width: f64) {
        if data.is_empty() {
            return;
        }
        self.push(format_args!(
            "<path d=\"{data}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{}\" \
             stroke-dasharray=\"{} {}\" stroke-linejoin=\"round\"/>",
            number(width),
            number(3.5 * width),
            number(2.5 * width)
        ));
    }

    /// A filled shape along the path `data`.
    pub(crate) fn filled(&mut self, data: &str, colour: &str) {
        self.push(format_args!("<path d=\"{data}\" fill=\"{colour}\"/>"));
    }

    /// A PNG stretched over `rect`; `smooth` unless its pixels are to stay square.
    pub(crate) fn image(&mut self, rect: Rect, png: &[u8], smooth: bool) {
        let rendering = if smooth {
            "optimizeQuality"
        } else {
            "pixelated"
        };
        let (place, data) = (placed(rect), STANDARD.encode(png));
        self.push(format_args!(
            "<image {place} preserveAspectRatio=\"none\" image-rendering=\"{rendering}\" \
             href=\"data:image/png;base64,{data}\"/>"
        ));
    }

    /// A whole document of its own in `rect`, as large as it is.
    pub(crate) fn nested(&mut self, rect: Rect, document: &str) {
        let rest = document.strip_prefix("<svg ").unwrap_or(document);
        self.push(format_args!(
            "<svg x=\"{}\" y=\"{}\" {rest}",
            number(rect.x),
            number(rect.y)
        ));
    }

    /// All that `part` has, `scale` as large, its origin at `(x, y)`.
    pub(crate) fn group(&mut self, (x, y): (f64, f64), scale: f64, part: &Canvas) {
        let (x, y, body) = (number(x), number(y), &part.body);
        let scale = if scale == 1.0 {
            String::new()
        } else {
            format!(" scale({scale:.6})")
        };
        self.push(format_args!(
            "<g transform=\"translate({x} {y}){scale}\">\n{body}</g>"
        ));
    }

    fn push(&mut self, element: std::fmt::Arguments<'_>) {
        // Writing to a String does not fail.
        let _ = writeln!(self.body, "{element}");
    }

    /// The document, on white.
    pub(crate) fn finish(self, width: f64, height: f64) -> String {
        let (width, height) = (number(width), number(height));
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" font-family=\"{FAMILIES}\" fill=\"{INK}\">\n\
             <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n{}</svg>\n",
            self.body
        )
    }
}

/// A coordinate with at most two decimals.
pub(crate) fn number(value: f64) -> String {
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" {
        "0".to_owned()
    } else {
        text.to_owned()
    }
}

fn placed(rect: Rect) -> String {
    format!(
        "x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"",
        number(rect.x),
        number(rect.y),
        number(rect.width),
        number(rect.height)
    )
}

/// `text` as the content of an element or an attribute, of XML and of HTML; characters that XML does not allow become
/// U+FFFD.
pub(crate) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            '\n' | '\t' => out.push(character),
            c if c.is_control() => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_cannot_break_out_of_its_element() {
        assert_eq!(
            escaped("a<b>\n& \"c\"\u{1}\u{ffff}"),
            "a&lt;b&gt;\n&amp; &quot;c&quot;\u{fffd}\u{fffd}"
        );
    }

    #[test]
    fn coordinates_are_short() {
        assert_eq!(number(12.0), "12");
        assert_eq!(number(0.126), "0.13");
        assert_eq!(number(-0.001), "0");
    }
}
