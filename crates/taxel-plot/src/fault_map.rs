//! A map of the array with what a self-test found.

mod glyph;

use taxel::screen::Axis;
use taxel::selftest::{Fault, Finding, Place, SelfTestResult};

use crate::MARGIN;
use crate::colour_bar::{HAIRLINE, LABEL_SIZE, TICK};
use crate::heatmap::layout::{NOTE_LEADING, NOTE_SIZE, TITLE_LEADING, TITLE_SIZE};
use crate::picture::Picture;
use crate::svg::{Anchor, Canvas, INK, Rect, number};
use crate::text;
use crate::ticks::index_ticks;
use glyph::{Glyph, Look, draw_glyph, rectangle};

/// The largest plot, in points, and the smallest text column beside or below it.
const ROOM: (f64, f64) = (520.0, 400.0);
const NARROWEST: f64 = 300.0;
const MAX_TAXEL: f64 = 24.0;
/// A glyph is at least this large, so that a single taxel of many is seen.
const MIN_GLYPH: f64 = 7.0;
const SOUND: &str = "#eef0f1";
const GRID: &str = "#ffffff";
const GAP: f64 = 3.0;
/// Space above the plot for the numbers of columns, and to its right for those of rows.
const LABEL_ROOM: f64 = 22.0;
const SWATCH: f64 = 9.0;
/// Places of one fault that are listed.
const LISTED: usize = 8;

/// A picture of the array: every faulty taxel in the colour of its fault, lines with their number at the edge, single taxels
/// with a sign of their own, and a legend that names them. Row 0 is at the top.
///
/// ```
/// use taxel::selftest::{SelfTestOptions, SelfTest};
/// use taxel::{Counts, Frame};
/// use taxel_plot::FaultMap;
///
/// let mut test = SelfTest::new(8, 8, 1023.0, &SelfTestOptions::default());
/// for _ in 0..16 {
///     test.observe_empty(&Frame::<Counts>::filled(8, 8, 5.0))?;
/// }
/// for k in 0..16 {
///     test.observe_rubbed(&Frame::<Counts>::filled(8, 8, 300.0 + f64::from(k)))?;
/// }
/// let picture = FaultMap::of(&test.finish()?).title("mat").picture();
/// assert!(picture.svg().contains("nothing found"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct FaultMap<'a> {
    result: &'a SelfTestResult,
    title: String,
    pitch_mm: [f64; 2],
}

/// One colour a kind of fault, of the eight that every kind of colour vision tells apart (Okabe and Ito 2008); what is wrong
/// along a line has a darker and a lighter one of an open line's.
fn look(fault: Fault) -> Look {
    let (colour, glyph) = match fault {
        Fault::LineOpen => ("#d55e00", Glyph::None),
        Fault::LineBroken => ("#8c3b00", Glyph::None),
        Fault::LineResists => ("#f2b48c", Glyph::None),
        Fault::LineSilent => ("#e69f00", Glyph::None),
        Fault::LineAtSupply => ("#56b4e9", Glyph::None),
        Fault::LineAtGround => ("#009e73", Glyph::None),
        Fault::LinesShorted => ("#0072b2", Glyph::None),
        Fault::LineFlickering => ("#cc79a7", Glyph::None),
        Fault::LineNoisy => ("#f0e442", Glyph::None),
        Fault::TaxelOpen => ("#d55e00", Glyph::Ring),
        Fault::TaxelShorted => ("#0072b2", Glyph::Cross),
        Fault::TaxelStuck => ("#333333", Glyph::Square),
        Fault::TaxelFlickering => ("#cc79a7", Glyph::Bars),
        Fault::TaxelNoisy => ("#f0e442", Glyph::Triangle),
        _ => ("#c4c8ca", Glyph::None),
    };
    Look { colour, glyph }
}

/// Whether a fault has a place on the map.
fn has_place(finding: &Finding) -> bool {
    finding.place != Place::Array || finding.fault == Fault::NotPressed
}

impl<'a> FaultMap<'a> {
    /// A map of what was found.
    pub fn of(result: &'a SelfTestResult) -> Self {
        Self {
            result,
            title: String::new(),
            pitch_mm: [1.0, 1.0],
        }
    }

    /// The line above it.
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// Distance between rows and between columns in mm, as in the sensor file: the shape of the picture.
    pub fn pitch_mm(mut self, pitch_mm: [f64; 2]) -> Self {
        self.pitch_mm = pitch_mm;
        self
    }

    /// The picture.
    pub fn picture(&self) -> Picture {
        let mut canvas = Canvas::default();
        let row_ticks = index_ticks(self.result.rows, 8);
        let labels: Vec<String> = row_ticks.iter().map(usize::to_string).collect();
        let left = MARGIN + LABEL_SIZE + 5.0 + text::widest(&labels, LABEL_SIZE) + GAP + TICK;
        let (plot_width, plot_height) = self.plot_size();
        let width = plot_width.max(NARROWEST);
        let title = text::wrap(&self.title, TITLE_SIZE, width);
        let top = MARGIN + title.len() as f64 * TITLE_LEADING + LABEL_ROOM;
        let plot = Rect {
            x: left,
            y: top,
            width: plot_width,
            height: plot_height,
        };
        for (i, line) in title.iter().enumerate() {
            let y = MARGIN + TITLE_SIZE * 0.8 + i as f64 * TITLE_LEADING;
            canvas.text(left, y, TITLE_SIZE, Anchor::Start, line);
        }
        self.draw_cells(&mut canvas, plot);
        self.draw_axes(&mut canvas, plot, &row_ticks);
        self.draw_line_labels(&mut canvas, plot);
        self.draw_glyphs(&mut canvas, plot);
        let legend_top = plot.bottom() + TICK + GAP + 2.0 * LABEL_SIZE + 18.0;
        let bottom = self.draw_legend(&mut canvas, left, legend_top, width + LABEL_ROOM);
        Picture::new(canvas, left + width + LABEL_ROOM + MARGIN, bottom + MARGIN)
    }

    /// Whole half points a taxel, so that taxels fall on pixels.
    fn plot_size(&self) -> (f64, f64) {
        let larger = self.pitch_mm[0].max(self.pitch_mm[1]);
        let share = |pitch: f64| match pitch / larger {
            share if share.is_finite() && share > 0.05 => share,
            _ => 0.05,
        };
        let (across, down) = (share(self.pitch_mm[1]), share(self.pitch_mm[0]));
        let (columns, rows) = (self.result.columns as f64, self.result.rows as f64);
        let mut side = (ROOM.0 / (columns * across))
            .min(ROOM.1 / (rows * down))
            .min(MAX_TAXEL);
        if side >= 1.0 {
            side = (2.0 * side).floor() / 2.0;
        }
        (columns * across * side, rows * down * side)
    }

    fn cell(&self, plot: Rect, row: usize, column: usize) -> Rect {
        let (width, height) = (
            plot.width / self.result.columns as f64,
            plot.height / self.result.rows as f64,
        );
        Rect {
            x: plot.x + column as f64 * width,
            y: plot.y + row as f64 * height,
            width,
            height,
        }
    }

    /// Sound taxels in grey, faulty ones in colour, crossings without one left white, and thin lines between them where there
    /// is room.
    fn draw_cells(&self, canvas: &mut Canvas, plot: Rect) {
        canvas.filled(&rectangle(plot), SOUND);
        let faults = self.result.by_taxel();
        for fault in Fault::ALL {
            let mut data = String::new();
            let of_fault = (0..faults.len()).filter(|&taxel| faults[taxel] == Some(fault));
            for taxel in of_fault {
                let (row, column) = (taxel / self.result.columns, taxel % self.result.columns);
                data += &rectangle(self.cell(plot, row, column));
            }
            if !data.is_empty() {
                canvas.filled(&data, look(fault).colour);
            }
        }
        let absent = self.result.absent.iter().enumerate();
        let blank: String = absent
            .filter(|(_, absent)| **absent)
            .map(|(taxel, _)| {
                let (row, column) = (taxel / self.result.columns, taxel % self.result.columns);
                rectangle(self.cell(plot, row, column))
            })
            .collect();
        if !blank.is_empty() {
            canvas.filled(&blank, GRID);
        }
        let cell = self.cell(plot, 0, 0);
        if cell.width.min(cell.height) >= 3.0 {
            let mut data = String::new();
            for column in 1..self.result.columns {
                let x = self.cell(plot, 0, column).x;
                data += &format!(
                    "M{} {}V{}",
                    number(x),
                    number(plot.y),
                    number(plot.bottom())
                );
            }
            for row in 1..self.result.rows {
                let y = self.cell(plot, row, 0).y;
                data += &format!("M{} {}H{}", number(plot.x), number(y), number(plot.right()));
            }
            canvas.strokes(&data, GRID, 0.4);
        }
        canvas.frame(plot, HAIRLINE);
    }

    fn draw_axes(&self, canvas: &mut Canvas, plot: Rect, row_ticks: &[usize]) {
        let mut marks = String::new();
        let baseline = plot.bottom() + TICK + GAP + LABEL_SIZE * 0.75;
        let most = (plot.width / 36.0).clamp(1.0, 14.0) as usize;
        for column in index_ticks(self.result.columns, most) {
            let cell = self.cell(plot, 0, column);
            let x = cell.x + cell.width / 2.0;
            marks += &format!("M{} {}v{TICK}", number(x), number(plot.bottom()));
            canvas.text(x, baseline, LABEL_SIZE, Anchor::Middle, &column.to_string());
        }
        for &row in row_ticks {
            let cell = self.cell(plot, row, 0);
            let y = cell.y + cell.height / 2.0;
            marks += &format!("M{} {}h-{TICK}", number(plot.x), number(y));
            let (x, y) = (plot.x - TICK - GAP, y + LABEL_SIZE * 0.36);
            canvas.text(x, y, LABEL_SIZE, Anchor::End, &row.to_string());
        }
        canvas.strokes(&marks, INK, HAIRLINE);
        let (x, y) = (plot.x + plot.width / 2.0, baseline + LABEL_SIZE + 4.0);
        canvas.text(x, y, LABEL_SIZE, Anchor::Middle, "column");
        let x = MARGIN + LABEL_SIZE * 0.8;
        canvas.text_upwards(x, plot.y + plot.height / 2.0, LABEL_SIZE, "row");
    }

    /// The numbers of faulty rows to the right, of faulty columns above; where two would overlap, the first.
    fn draw_line_labels(&self, canvas: &mut Canvas, plot: Rect) {
        let mut lines: Vec<(Axis, usize)> = Vec::new();
        for finding in &self.result.findings {
            match finding.place {
                Place::Line { axis, index } | Place::Along { axis, index, .. } => {
                    lines.push((axis, index))
                }
                Place::Pair { axis, first } => lines.extend([(axis, first), (axis, first + 1)]),
                _ => {}
            }
        }
        lines.sort_by_key(|&(axis, index)| (axis == Axis::Column, index));
        lines.dedup();
        let mut free = [f64::NEG_INFINITY; 2];
        for (axis, index) in lines {
            let label = index.to_string();
            match axis {
                Axis::Row => {
                    let cell = self.cell(plot, index, 0);
                    let y = cell.y + cell.height / 2.0;
                    if y >= free[0] {
                        free[0] = y + NOTE_SIZE;
                        let (x, y) = (plot.right() + GAP, y + NOTE_SIZE * 0.36);
                        canvas.text(x, y, NOTE_SIZE, Anchor::Start, &label);
                    }
                }
                Axis::Column => {
                    let cell = self.cell(plot, 0, index);
                    let x = cell.x + cell.width / 2.0;
                    let half = text::width(&label, NOTE_SIZE) / 2.0 + 1.5;
                    if x - half >= free[1] {
                        free[1] = x + half;
                        canvas.text(x, plot.y - GAP - 1.0, NOTE_SIZE, Anchor::Middle, &label);
                    }
                }
            }
        }
    }

    fn draw_glyphs(&self, canvas: &mut Canvas, plot: Rect) {
        for finding in &self.result.findings {
            if let Place::Taxel { row, column } = finding.place {
                let cell = self.cell(plot, row, column);
                let side = cell.width.min(cell.height).max(MIN_GLYPH);
                let centre = (cell.x + cell.width / 2.0, cell.y + cell.height / 2.0);
                let is_small = cell.width.min(cell.height) < MIN_GLYPH;
                draw_glyph(canvas, centre, side, &look(finding.fault), is_small);
            }
        }
    }

    /// What is on the map, then what concerns the whole read-out. Gives its lower end.
    fn draw_legend(&self, canvas: &mut Canvas, left: f64, top: f64, width: f64) -> f64 {
        let mut y = top;
        let indent = SWATCH + 6.0;
        let mut entry = |swatch: Option<&Look>, words: &str| {
            let first = y;
            for line in text::wrap(words, NOTE_SIZE, width - indent) {
                canvas.text(left + indent, y, NOTE_SIZE, Anchor::Start, &line);
                y += NOTE_LEADING;
            }
            if let Some(look) = swatch {
                let rect = Rect {
                    x: left,
                    y: first - SWATCH + 1.5,
                    width: SWATCH,
                    height: SWATCH,
                };
                canvas.filled(&rectangle(rect), look.colour);
                let centre = (rect.x + SWATCH / 2.0, rect.y + SWATCH / 2.0);
                draw_glyph(canvas, centre, SWATCH, look, false);
            }
        };
        for fault in Fault::ALL {
            let of_fault = |f: &&Finding| f.fault == fault && has_place(f);
            let findings: Vec<&Finding> = self.result.findings.iter().filter(of_fault).collect();
            if !findings.is_empty() {
                entry(Some(&look(fault)), &listed(fault, &findings));
            }
        }
        for finding in self.result.findings.iter().filter(|f| !has_place(f)) {
            entry(
                None,
                &format!("{}: {}", finding.fault.words(), finding.evidence),
            );
        }
        if self.result.is_good() {
            entry(None, "nothing found");
        }
        y
    }
}

/// `open: row 11, column 64`, or `stuck taxel (row,column): 3,4; 7,8`.
fn listed(fault: Fault, findings: &[&Finding]) -> String {
    let name = |place: Place| match place {
        Place::Taxel { row, column } => format!("{row},{column}"),
        Place::Array => findings[0].evidence.clone(),
        line => line.to_string(),
    };
    let mut places: Vec<String> = findings
        .iter()
        .take(LISTED)
        .map(|f| name(f.place))
        .collect();
    if findings.len() > LISTED {
        places.push(format!("and {} more", findings.len() - LISTED));
    }
    match findings[0].place {
        Place::Taxel { .. } => format!(
            "{} taxel (row,column): {}",
            fault.words(),
            places.join("; ")
        ),
        _ => format!("{}: {}", fault.words(), places.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use taxel::selftest::{SelfTest, SelfTestOptions};
    use taxel::{Counts, Frame};

    use super::*;

    /// An array that nothing was found on, and then these findings.
    fn result(
        rows: usize,
        columns: usize,
        findings: Vec<(Fault, Place, Vec<usize>)>,
    ) -> SelfTestResult {
        let mut test = SelfTest::new(rows, columns, 1023.0, &SelfTestOptions::default());
        for _ in 0..16 {
            test.observe_empty(&Frame::<Counts>::filled(rows, columns, 5.0))
                .unwrap();
        }
        for k in 0..16 {
            let frame = Frame::<Counts>::filled(rows, columns, 300.0 + f64::from(k));
            test.observe_rubbed(&frame).unwrap();
        }
        let mut result = test.finish().unwrap();
        let finding = |(fault, place, taxels)| Finding {
            fault,
            place,
            taxels,
            evidence: "seen in so many frames".to_owned(),
            advice: String::new(),
        };
        result.findings = findings.into_iter().map(finding).collect();
        result
    }

    fn everything(rows: usize, columns: usize) -> SelfTestResult {
        let mut findings = Vec::new();
        for (i, fault) in Fault::ALL.into_iter().enumerate() {
            let (row, column) = (i * rows / 20, i * columns / 20);
            let row_taxels = || (0..columns).map(|c| row * columns + c).collect::<Vec<_>>();
            let axis = Axis::Row;
            findings.push(match fault {
                Fault::LinesShorted => (fault, Place::Pair { axis, first: row }, row_taxels()),
                _ if i < 9 => (fault, Place::Line { axis, index: row }, row_taxels()),
                _ if i < 14 => (
                    fault,
                    Place::Taxel { row, column },
                    vec![row * columns + column],
                ),
                _ => (fault, Place::Array, vec![0, rows * columns - 1]),
            });
        }
        result(rows, columns, findings)
    }

    #[test]
    fn every_fault_is_in_the_legend_and_the_picture_is_drawn() {
        for (rows, columns) in [(16, 16), (64, 128), (1, 3), (200, 2)] {
            let result = everything(rows, columns);
            let picture = FaultMap::of(&result).title("all at once").picture();
            for fault in Fault::ALL {
                assert!(picture.svg().contains(fault.words()), "{fault:?}");
            }
            assert!(picture.png().unwrap().starts_with(b"\x89PNG"));
        }
    }

    #[test]
    fn no_text_leaves_the_picture() {
        for (rows, columns) in [(16, 16), (64, 128)] {
            let result = everything(rows, columns);
            let picture = FaultMap::of(&result)
                .title("a long title ".repeat(20))
                .picture();
            let tree = crate::picture::parse(picture.svg()).unwrap();
            let drawn = tree.root().abs_bounding_box();
            assert!(
                drawn.right() <= picture.width() as f32
                    && drawn.bottom() <= picture.height() as f32
            );
            assert!(drawn.left() >= 0.0 && drawn.top() >= 0.0);
        }
    }

    #[test]
    fn a_sound_array_is_said_to_be_so() {
        let result = result(4, 4, vec![]);
        let picture = FaultMap::of(&result).pitch_mm([10.0, 0.0]).picture();
        assert!(picture.svg().contains("nothing found"));
    }
}
