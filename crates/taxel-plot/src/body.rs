//! One frame on the handle that the array is wrapped around, seen from four sides.

use std::f64::consts::{FRAC_PI_2, TAU};

use taxel::sensor::{Handle, Rings};

use crate::colour::Rgb;
use crate::colour_bar::{Beyond, ColourBar, LABEL_SIZE};
use crate::extent::Extent;
use crate::fitting::{Drawn, fit};
use crate::heatmap::Panel;
use crate::heatmap::layout::{Room, TITLE_LEADING, TITLE_SIZE};
use crate::picture::{PNG_SCALE, Picture, write_image};
use crate::raster::{Interpolation, position};
use crate::sheet::{draw_caption, headed};
use crate::svg::{Anchor, Canvas, Rect};
use crate::{Error, MARGIN, outline, text};

/// Sides that it is seen from.
const VIEWS: usize = 4;
/// How far above the first ring's side the eye is, radians: so much of its end is seen that it looks like a body.
const ELEVATION: f64 = 0.3;
/// What a side that faces away keeps of its colour.
const DARKEST: f64 = 0.6;
/// What a side that faces the light shines, of 255: a body without a load has a shape.
const SHINE: f64 = 18.0;
/// Where there is no taxel, and the end of the body.
const BARE: Rgb = [206, 206, 210];
const END: Rgb = [212, 212, 216];
const GAP: f64 = 14.0;
const BAR_GAP: f64 = 20.0;
const LABEL_GAP: f64 = 6.0;
const MIN_BAR: f64 = 110.0;
/// Of each side, in points.
const USUAL: Room = Room {
    width: 130.0,
    height: 260.0,
};

/// A frame on a cylinder or a cone, shaded by its values, seen from four sides a quarter turn apart: the map rolled up and
/// looked at from outside, its first ring on top, the lines along the body in their order to the right.
///
/// Values that are not finite, and the seam, are grey; marked taxels are counted below.
///
/// ```
/// use taxel_plot::{Body, Format, Panel};
/// let sensor = taxel::sensor::preset("econe").unwrap();
/// let loads = vec![1.0; sensor.rows() * sensor.columns()];
/// let panel = Panel::new(sensor.rows(), sensor.columns(), &loads)?.unit("g");
/// let picture = Body::new(panel, sensor.handle().unwrap())?.picture()?;
/// assert!(picture.svg().contains("90°"));
/// # Ok::<(), taxel_plot::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Body<'a> {
    panel: Panel<'a>,
    handle: &'a Handle,
    title: String,
    caption: String,
    extent: Option<Extent>,
}

/// A point of the surface: its ring and its line, neither whole, and how light it is.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Surface {
    ring: f64,
    line: f64,
    light: f64,
}

/// What is seen at a point of a view.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Seen {
    Surface(Surface),
    End,
}

/// A body seen from a side.
#[derive(Debug, Clone, Copy)]
struct View<'a> {
    handle: &'a Handle,
    /// sin and cos of the direction it is seen from.
    side: (f64, f64),
}

impl<'a> Body<'a> {
    /// A frame, with its range, colours and title, on a handle.
    ///
    /// # Errors
    /// [`Error::Shape`] where the handle is another array's.
    pub fn new(panel: Panel<'a>, handle: &'a Handle) -> Result<Self, Error> {
        let (rows, columns) = (panel.grid.rows, panel.grid.columns);
        let (rings, lines) = (handle.radii_mm.len(), handle.angles.len());
        let fits = match handle.rings {
            Rings::Columns => (lines, rings) == (rows, columns),
            _ => (rings, lines) == (rows, columns),
        };
        if !fits {
            return Err(Error::Shape {
                what: "taxels of the handle",
                expected: rows * columns,
                found: rings * lines,
                rows,
                columns,
            });
        }
        Ok(Self {
            panel,
            handle,
            title: String::new(),
            caption: String::new(),
            extent: None,
        })
    }

    /// The line above all of it.
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// The sentence or two below it.
    pub fn caption(mut self, caption: impl Into<String>) -> Self {
        self.caption = caption.into();
        self
    }

    /// The size that the whole picture is to have.
    pub fn fit(mut self, extent: Extent) -> Self {
        self.extent = Some(extent);
        self
    }

    /// The body as a picture.
    ///
    /// # Errors
    /// [`Error::Png`] should a side not be encodable; [`Error::NoRoom`] in an [`Extent`] that is too small.
    pub fn picture(&self) -> Result<Picture, Error> {
        match self.extent {
            None => Ok(self.draw(USUAL)?.whole()),
            Some(extent) => Ok(fit(extent, Room::SMALLEST, |room| self.draw(room))?.0),
        }
    }

    fn draw(&self, room: Room) -> Result<Drawn, Error> {
        let [wide, high] = View::new(self.handle, 0).size_mm();
        let scale = (room.width / wide).min(room.height / high);
        let (width, height) = (wide * scale, high * scale);
        let range = self.panel.drawn_range();
        let values = self.panel.values();
        let labels = (self.panel.quantity.as_str(), self.panel.unit.as_str());
        let beyond = Beyond::of(&values, range);
        let length = (height.max(MIN_BAR), false);
        let bar = ColourBar::new(range, labels, self.panel.colour_map, beyond, length);
        let sides = (width + GAP) * VIEWS as f64 - GAP;
        let whole = sides + BAR_GAP + bar.breadth();
        let mut canvas = Canvas::default();
        let mut top = MARGIN;
        for line in text::wrap(&self.panel.title, TITLE_SIZE, whole) {
            let baseline = top + TITLE_SIZE * 0.8;
            canvas.text(MARGIN, baseline, TITLE_SIZE, Anchor::Start, &line);
            top += TITLE_LEADING;
        }
        top += 6.0;
        for side in 0..VIEWS {
            let view = View::new(self.handle, side);
            let plot = Rect {
                x: MARGIN + side as f64 * (width + GAP),
                y: top,
                width,
                height,
            };
            let png = self.png(&view, &values, range, 1.0 / scale)?;
            canvas.image(plot, &png, true);
            let x = plot.x + plot.width / 2.0;
            let y = plot.bottom() + LABEL_GAP + LABEL_SIZE * 0.8;
            canvas.text(x, y, LABEL_SIZE, Anchor::Middle, &view.name(side));
        }
        bar.draw(&mut canvas, MARGIN + sides + BAR_GAP, top)?;
        let bottom = top + (height + LABEL_GAP + 1.2 * LABEL_SIZE).max(length.0 + 6.0);
        let bottom = draw_caption(&mut canvas, &self.said(), bottom, whole);
        let drawn = Drawn {
            canvas,
            width: whole + 2.0 * MARGIN,
            height: bottom + MARGIN,
            plot: (width, height),
            grid: (VIEWS, 1),
        };
        Ok(headed(&self.title, drawn))
    }

    /// The caption, and which taxels are marked.
    fn said(&self) -> String {
        match self.panel.marks.and_then(outline::counted) {
            Some(marks) if self.caption.is_empty() => format!("marked: {marks}"),
            Some(marks) => format!("{}; marked: {marks}", self.caption),
            None => self.caption.clone(),
        }
    }

    /// A side as a PNG on nothing, `mm` a point.
    fn png(
        &self,
        view: &View<'_>,
        values: &[f64],
        range: (f64, f64),
        mm: f64,
    ) -> Result<Vec<u8>, Error> {
        let size = view.size_mm();
        let step = mm / (f64::from(PNG_SCALE) * 1.25);
        let [wide, high] = size.map(|side| (side / step).ceil().max(1.0) as u32);
        let mut pixels = Vec::with_capacity(4 * wide as usize * high as usize);
        for y in 0..high {
            for x in 0..wide {
                // Four points a pixel, so that edges are smooth.
                let points = [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)];
                let mut sum = [0.0; 3];
                let mut count = 0.0;
                for (right, down) in points {
                    let right = (f64::from(x) + right) * step - size[0] / 2.0;
                    let up = size[1] / 2.0 - (f64::from(y) + down) * step;
                    let Some(seen) = view.at(right, up) else {
                        continue;
                    };
                    count += 1.0;
                    for (sum, part) in sum.iter_mut().zip(self.colour(seen, values, range)) {
                        *sum += part;
                    }
                }
                let colour = sum.map(|part| (part / f64::max(count, 1.0)).round() as u8);
                pixels.extend(colour);
                pixels.push((count * 255.0 / 4.0) as u8);
            }
        }
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, wide, high);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::Balanced);
        write_image(encoder, &pixels)?;
        Ok(bytes)
    }

    fn colour(&self, seen: Seen, values: &[f64], range: (f64, f64)) -> [f64; 3] {
        let (colour, light) = match seen {
            Seen::End => (END, 1.0),
            Seen::Surface(at) => match self.value(at, values) {
                Some(value) if value.is_finite() => {
                    let share = position(value, range).clamp(0.0, 1.0);
                    (self.panel.colour_map.rgb(share), at.light)
                }
                _ => (BARE, at.light),
            },
        };
        let shine = SHINE * (light - DARKEST) / (1.0 - DARKEST);
        colour.map(|part| (f64::from(part) * light + shine).min(255.0))
    }

    /// The value at a place, by the taxels around it; nothing on the seam.
    fn value(&self, at: Surface, values: &[f64]) -> Option<f64> {
        let (rings, lines) = (self.handle.radii_mm.len(), self.handle.angles.len());
        let ring = at.ring.clamp(0.0, (rings - 1) as f64);
        let of = |ring: usize, line: usize| {
            values[match self.handle.rings {
                Rings::Columns => line * rings + ring,
                _ => ring * lines + line,
            }]
        };
        let [(left, right, across), nearest] = self.lines_at(at.line)?;
        if self.panel.interpolation == Interpolation::Nearest {
            return Some(of(ring.round() as usize, nearest.0));
        }
        let (upper, down) = (ring.floor() as usize, ring - ring.floor());
        let lower = (upper + 1).min(rings - 1);
        if !of(ring.round() as usize, nearest.0).is_finite() {
            return None;
        }
        let corners = [
            (of(upper, left), (1.0 - down) * (1.0 - across)),
            (of(upper, right), (1.0 - down) * across),
            (of(lower, left), down * (1.0 - across)),
            (of(lower, right), down * across),
        ];
        let known = corners.iter().filter(|(value, _)| value.is_finite());
        let (sum, total) = known.fold((0.0, 0.0), |(sum, total), (value, weight)| {
            (sum + weight * value, total + weight)
        });
        Some(sum / total)
    }

    /// The lines to both sides of a place and how far it lies towards the second; and the nearest, in the same form. Nothing
    /// on the seam.
    fn lines_at(&self, line: f64) -> Option<[(usize, usize, f64); 2]> {
        let last = self.handle.angles.len() - 1;
        let whole = TAU / self.handle.angles[1];
        let beyond = line - last as f64;
        let (left, right, across) = if beyond <= 0.0 {
            let left = (line.floor() as usize).min(last - 1);
            (left, left + 1, line - left as f64)
        } else if self.handle.closes() {
            (last, 0, beyond / (whole - last as f64))
        } else if beyond <= 0.5 {
            (last, last, 0.0)
        } else if whole - line <= 0.5 {
            (0, 0, 0.0)
        } else {
            return None;
        };
        let nearest = if across < 0.5 { left } else { right };
        Some([(left, right, across), (nearest, nearest, 0.0)])
    }
}

impl<'a> View<'a> {
    fn new(handle: &'a Handle, side: usize) -> Self {
        Self {
            handle,
            side: (side as f64 * FRAC_PI_2).sin_cos(),
        }
    }

    /// From one ring to the next along the axis, mm.
    fn step_mm(&self) -> f64 {
        self.handle.step_mm * self.handle.slope.cos()
    }

    /// Radius and ring of both ends, half a step beyond the first ring and the last.
    fn ends(&self) -> [(f64, f64); 2] {
        let radii = &self.handle.radii_mm;
        let last = (radii.len() - 1) as f64;
        let narrows = if radii.len() > 1 {
            (radii[radii.len() - 1] - radii[0]) / last
        } else {
            0.0
        };
        [-0.5, last + 0.5].map(|ring| (radii[0] + ring * narrows, ring))
    }

    /// Width and height of what is seen, mm.
    fn size_mm(&self) -> [f64; 2] {
        let [(upper, from), (lower, to)] = self.ends();
        let high = (to - from) * self.step_mm() * ELEVATION.cos();
        [
            2.0 * upper.max(lower),
            high + (upper + lower) * ELEVATION.sin(),
        ]
    }

    /// What is seen so far to the right of the middle and above it, mm. The body's axis is z, its upper end at z = 0.
    fn at(&self, right: f64, up: f64) -> Option<Seen> {
        let (sin, cos) = ELEVATION.sin_cos();
        let [(upper, first), (lower, last)] = self.ends();
        let height = (last - first) * self.step_mm();
        // The middle of the picture is that of the two outermost points.
        let up = up + (upper - lower) / 2.0 * sin - height / 2.0 * cos;
        // A point of the ray: `right` to the right, `away` towards the eye; its height above the upper end follows.
        let z = |away: f64| (up + away * sin) / cos;
        let slope = (upper - lower) / height;
        // right² + away² = (upper + slope z)², and away grows towards the eye.
        let (constant, linear) = (upper + slope * up / cos, slope * sin / cos);
        let a = 1.0 - linear * linear;
        let b = -2.0 * constant * linear;
        let c = right * right - constant * constant;
        let root = (b * b - 4.0 * a * c).sqrt();
        if !root.is_finite() {
            return None;
        }
        let away = (root - b) / (2.0 * a);
        let depth = -z(away);
        if (0.0..=height).contains(&depth) {
            return Some(self.surface(right, away, depth, slope));
        }
        // Through the upper end, where the ray comes from above it.
        let away = -up / sin;
        (depth < 0.0 && right.hypot(away) <= upper).then_some(Seen::End)
    }

    fn surface(&self, right: f64, away: f64, depth: f64, slope: f64) -> Seen {
        let (sin, cos) = self.side;
        // Towards the eye is the direction (cos, sin), to the right (−sin, cos).
        let (x, y) = (away * cos - right * sin, away * sin + right * cos);
        let radius = right.hypot(away);
        let angle = y.atan2(x).rem_euclid(TAU);
        // The surface faces (right, away, −slope radius) / radius; the light comes from the eye's left, above it.
        let norm = 1f64.hypot(slope) * radius.max(1e-12);
        let light = (-0.3 * right + 0.85 * away - 0.43 * slope * radius) / norm;
        Seen::Surface(Surface {
            ring: depth / self.step_mm() - 0.5,
            line: angle / self.handle.angles[1],
            light: DARKEST + (1.0 - DARKEST) * light.clamp(0.0, 1.0),
        })
    }

    /// From where it is seen: the angle, and the line along the body that faces the eye.
    fn name(&self, side: usize) -> String {
        let quarter = side as f64 * FRAC_PI_2;
        let line = (quarter / self.handle.angles[1]).round() as usize;
        let lines = match self.handle.rings {
            Rings::Columns => "row",
            _ => "column",
        };
        let degrees = 90 * side;
        if line < self.handle.angles.len() {
            format!("{degrees}° ({lines} {line})")
        } else {
            format!("{degrees}°")
        }
    }
}

#[cfg(test)]
mod tests;
