//! The bar that says which colour is which value.

use crate::Error;
use crate::colour::{ColourMap, hex};
use crate::raster::{Grid, Interpolation, heatmap_png, position};
use crate::scale::Scale;
use crate::svg::{Anchor, Canvas, INK, Rect, number};
use crate::text;
use crate::ticks::{nice_ticks, tick_labels};

/// Type size of tick labels and axis names.
pub(crate) const LABEL_SIZE: f64 = 10.0;
/// Length of a tick.
pub(crate) const TICK: f64 = 3.5;
/// Stroke width of ticks and frames.
pub(crate) const HAIRLINE: f64 = 0.7;
const THICKNESS: f64 = 10.0;
const GAP: f64 = 3.0;
const ARROW: f64 = 7.0;

/// Values beyond the ends of a range, shown as arrows on the bar.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Beyond {
    pub(crate) below: bool,
    pub(crate) above: bool,
}

impl Beyond {
    /// Whether finite `values` lie outside of the range.
    pub(crate) fn of(values: &[f64], (low, high): (f64, f64)) -> Beyond {
        let finite = || values.iter().filter(|v| v.is_finite());
        Beyond {
            below: finite().any(|&v| v < low),
            above: finite().any(|&v| v > high),
        }
    }

    pub(crate) fn or(self, other: Beyond) -> Beyond {
        Beyond {
            below: self.below || other.below,
            above: self.above || other.above,
        }
    }
}

/// A measured colour bar.
#[derive(Debug, Clone)]
pub(crate) struct ColourBar {
    pub(crate) horizontal: bool,
    pub(crate) length: f64,
    map: ColourMap,
    beyond: Beyond,
    /// Position along the bar, 0 to 1, and label.
    ticks: Vec<(f64, String)>,
    label: String,
}

impl ColourBar {
    /// A bar of that `length` for a drawable `range` of `quantity` in `unit`.
    pub(crate) fn new(
        range: (f64, f64),
        (quantity, unit): (&str, &str),
        map: ColourMap,
        beyond: Beyond,
        (length, horizontal): (f64, bool),
    ) -> ColourBar {
        let scale = Scale::new(unit, range);
        let scaled = (scale.apply(range.0), scale.apply(range.1));
        let spacing = if horizontal { 55.0 } else { 34.0 };
        let most = ((length / spacing) as usize).clamp(3, 7);
        let ticks = nice_ticks(scaled.0, scaled.1, most);
        let labels = tick_labels(&ticks);
        let at = |tick: &f64| position(*tick, scaled).clamp(0.0, 1.0);
        ColourBar {
            horizontal,
            length,
            map,
            beyond,
            ticks: ticks.iter().map(at).zip(labels).collect(),
            label: scale.label(quantity),
        }
    }

    /// Room it takes across its length.
    pub(crate) fn breadth(&self) -> f64 {
        let label = if self.label.is_empty() {
            0.0
        } else {
            LABEL_SIZE + 5.0
        };
        let numbers = if self.horizontal {
            LABEL_SIZE
        } else {
            self.widest_number()
        };
        THICKNESS + TICK + GAP + numbers + label
    }

    /// Room it takes along its length, label included.
    pub(crate) fn extent(&self) -> f64 {
        self.length.max(text::width(&self.label, LABEL_SIZE))
    }

    fn widest_number(&self) -> f64 {
        self.ticks
            .iter()
            .map(|(_, label)| text::width(label, LABEL_SIZE))
            .fold(0.0, f64::max)
    }

    /// Draws it with its top left corner at `x`, `y`.
    pub(crate) fn draw(&self, canvas: &mut Canvas, x: f64, y: f64) -> Result<(), Error> {
        let (width, height) = if self.horizontal {
            (self.length, THICKNESS)
        } else {
            (THICKNESS, self.length)
        };
        let bar = Rect {
            x,
            y,
            width,
            height,
        };
        canvas.image(bar, &self.gradient()?, false);
        canvas.frame(bar, HAIRLINE);
        self.draw_arrows(canvas, bar);
        if self.horizontal {
            self.draw_below(canvas, bar)
        } else {
            self.draw_beside(canvas, bar)
        }
        Ok(())
    }

    fn gradient(&self) -> Result<Vec<u8>, Error> {
        let rising = (0..=255).map(f64::from);
        let values: Vec<f64> = if self.horizontal {
            rising.collect()
        } else {
            rising.rev().collect()
        };
        let (rows, columns) = if self.horizontal { (1, 256) } else { (256, 1) };
        let grid = Grid {
            values: &values,
            rows,
            columns,
        };
        heatmap_png(
            grid,
            Interpolation::Bilinear(1),
            self.map,
            (0.0, 255.0),
            256,
        )
    }

    fn draw_arrows(&self, canvas: &mut Canvas, bar: Rect) {
        for (shown, position) in [(self.beyond.below, 0.0), (self.beyond.above, 1.0)] {
            if !shown {
                continue;
            }
            let outwards = ARROW * (2.0 * position - 1.0);
            let corners = if self.horizontal {
                let edge = bar.x + bar.width * position;
                [
                    (edge, bar.y),
                    (edge, bar.bottom()),
                    (edge + outwards, bar.y + THICKNESS / 2.0),
                ]
            } else {
                let edge = bar.bottom() - bar.height * position;
                [
                    (bar.x, edge),
                    (bar.right(), edge),
                    (bar.x + THICKNESS / 2.0, edge - outwards),
                ]
            };
            let data = polygon(&corners);
            canvas.filled(&data, &hex(self.map.rgb(position)));
            canvas.strokes(&data, INK, HAIRLINE);
        }
    }

    fn draw_beside(&self, canvas: &mut Canvas, bar: Rect) {
        let mut marks = String::new();
        for (position, label) in &self.ticks {
            let y = bar.bottom() - bar.height * position;
            marks += &format!("M{} {}h{TICK}", number(bar.right()), number(y));
            let x = bar.right() + TICK + GAP;
            canvas.text(x, y + LABEL_SIZE * 0.36, LABEL_SIZE, Anchor::Start, label);
        }
        canvas.strokes(&marks, INK, HAIRLINE);
        let x = bar.x + self.breadth();
        canvas.text_upwards(x, bar.y + bar.height / 2.0, LABEL_SIZE, &self.label);
    }

    fn draw_below(&self, canvas: &mut Canvas, bar: Rect) {
        let mut marks = String::new();
        let baseline = bar.bottom() + TICK + GAP + LABEL_SIZE * 0.75;
        for (position, label) in &self.ticks {
            let x = bar.x + bar.width * position;
            marks += &format!("M{} {}v{TICK}", number(x), number(bar.bottom()));
            canvas.text(x, baseline, LABEL_SIZE, Anchor::Middle, label);
        }
        canvas.strokes(&marks, INK, HAIRLINE);
        let (x, y) = (bar.x + bar.width / 2.0, baseline + LABEL_SIZE + 4.0);
        canvas.text(x, y, LABEL_SIZE, Anchor::Middle, &self.label);
    }
}

fn polygon(corners: &[(f64, f64)]) -> String {
    let points: Vec<String> = corners
        .iter()
        .map(|(x, y)| format!("{} {}", number(*x), number(*y)))
        .collect();
    format!("M{}Z", points.join("L"))
}
