//! The signs on single taxels.

use crate::svg::{Canvas, INK, Rect, number};

/// How a fault is drawn.
pub(super) struct Look {
    pub(super) colour: &'static str,
    pub(super) glyph: Glyph,
}

/// The sign on a single taxel.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Glyph {
    None,
    Ring,
    Cross,
    Square,
    Bars,
    Triangle,
}

/// A rectangle as path data.
pub(super) fn rectangle(rect: Rect) -> String {
    format!(
        "M{} {}H{}V{}H{}Z",
        number(rect.x),
        number(rect.y),
        number(rect.right()),
        number(rect.bottom()),
        number(rect.x)
    )
}

/// A sign about a centre, `side` wide; where the taxel is smaller than the sign, on a ground of its own.
pub(super) fn draw_glyph(
    canvas: &mut Canvas,
    (x, y): (f64, f64),
    side: f64,
    look: &Look,
    grounded: bool,
) {
    if look.glyph == Glyph::None {
        return;
    }
    let half = side / 2.0;
    if grounded {
        let ground = Rect {
            x: x - half,
            y: y - half,
            width: side,
            height: side,
        };
        canvas.filled(&rectangle(ground), look.colour);
        canvas.frame(ground, 0.5);
    }
    let data = path(look.glyph, (x, y), 0.28 * side);
    // Yellow and pink are too light for a white sign.
    let is_light = matches!(look.colour, "#f0e442" | "#cc79a7");
    let ink = if is_light { INK } else { "#ffffff" };
    match look.glyph {
        Glyph::Square | Glyph::Triangle => canvas.filled(&data, ink),
        _ => canvas.strokes(&data, ink, (0.12 * side).max(0.9)),
    }
}

/// Path data of a sign that reaches `r` from its centre.
fn path(glyph: Glyph, (x, y): (f64, f64), r: f64) -> String {
    let corners: &[(char, f64, f64)] = match glyph {
        Glyph::None => &[],
        Glyph::Ring => {
            let (radius, across) = (number(r), number(2.0 * r));
            return format!(
                "M{} {}a{radius} {radius} 0 1 0 {across} 0a{radius} {radius} 0 1 0 -{across} 0Z",
                number(x - r),
                number(y)
            );
        }
        Glyph::Cross => &[
            ('M', -1.0, -1.0),
            ('L', 1.0, 1.0),
            ('M', 1.0, -1.0),
            ('L', -1.0, 1.0),
        ],
        Glyph::Square => &[
            ('M', -0.8, -0.8),
            ('L', 0.8, -0.8),
            ('L', 0.8, 0.8),
            ('L', -0.8, 0.8),
        ],
        Glyph::Bars => &[
            ('M', -0.6, -1.0),
            ('L', -0.6, 1.0),
            ('M', 0.6, -1.0),
            ('L', 0.6, 1.0),
        ],
        Glyph::Triangle => &[('M', 0.0, -1.0), ('L', 1.0, 0.9), ('L', -1.0, 0.9)],
    };
    let points = corners
        .iter()
        .map(|(letter, dx, dy)| format!("{letter}{} {}", number(x + dx * r), number(y + dy * r)));
    points.collect()
}
