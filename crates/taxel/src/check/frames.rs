//! Frames of known loads as a calibrated sensor reads them.

use super::CheckData;
use super::scale::Reading;
use super::verdict::OF_MEDIAN;
use crate::calibrate::PressLabel;
use crate::frame::grams_from_newtons;
use crate::metric::CONTACT_NEWTONS;
use crate::pipeline::Pipeline;
use crate::screen::{LineFaults, LineScreen};
use crate::sensor::UncertaintySpec;
use crate::solve::default_method;
use crate::stats::median;
use crate::uncertainty::{FigureErrors, NoiseBias, StandardErrors};
use crate::{Counts, Error, Frame, Grams, Mark, Sensor, Siemens};

/// A press stands alone where nothing is two to three taxels away: less than this share of its load on any taxel,
const RING_SHARE: f64 = 0.05;
/// or than so many times what unloaded taxels read, standard deviations.
const RING_FLOORS: f64 = 3.0;
/// Taxels from a press to the end of that ring.
const RING: usize = 3;
/// Unloaded taxels tell the offset of a frame where no more than this share carries more than a tenth of its press.
const QUIET_SHARE: f64 = 0.25;

/// Frames of the empty array whose noise is looked at: it is much the same in all.
const NOISY_FRAMES: usize = 5;

/// A frame solved once: its loads follow by any load law.
struct Solved {
    siemens: Frame<Siemens>,
    /// What noise has a part in, grams.
    noise_g: Vec<f64>,
    marks: Vec<Mark>,
    sum: NoiseOfSum,
}

/// What noise does to the sum of a frame's loads, grams.
#[derive(Debug, Clone, Copy, Default)]
struct NoiseOfSum {
    /// What it has added in the mean, where lines are left open.
    added_g: f64,
    /// Standard error of one frame's sum,
    error_g: f64,
    /// and of what is taken off, which frames share.
    common_g: f64,
}

impl Solved {
    /// `None` where nothing bounds it, or it was not asked for.
    fn noise_of(&self, taxel: usize) -> Option<f64> {
        Some(self.noise_g[taxel]).filter(|g| g.is_finite())
    }
}

/// The frames of a check.
pub(super) struct Measurement<'a> {
    sensor: &'a Sensor,
    data: &'a CheckData,
    frames: Vec<Option<Solved>>,
    totals: Vec<Vec<Solved>>,
    empty: Vec<Solved>,
    /// What could not be compared, and why.
    pub(super) left_out: Vec<String>,
}

/// What is read of a press.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PressReading {
    /// Index into the data's presses.
    pub(super) press: usize,
    pub(super) reading: Reading,
    /// It stood alone: its eight neighbours carry a part of the load.
    pub(super) summed: bool,
}

/// Everything that is read by one scale of conductances.
#[derive(Debug, Default)]
pub(super) struct Readings {
    /// Of loads above 0.
    pub(super) presses: Vec<PressReading>,
    /// Of the whole array.
    pub(super) totals: Vec<Reading>,
    /// Of taxels that are said to carry nothing.
    pub(super) unloaded: Vec<Unloaded>,
    /// What half of the taxels of a quiet or empty frame read less than.
    pub(super) offsets: Vec<Unloaded>,
}

/// What is read where nothing stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Unloaded {
    pub(super) reads_g: f64,
    /// What noise has a part in of one reading, a standard deviation; where it was looked at.
    pub(super) noise_g: Option<f64>,
}

/// Turns frames into solved ones.
struct Reader {
    pipeline: Pipeline,
    errors: StandardErrors,
    bias: Option<NoiseBias>,
    sums: FigureErrors,
}

/// What is asked of a frame beside its conductances.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Asked {
    Nothing,
    /// What noise has a part in of every taxel: many times the work.
    NoiseOfTaxels,
    NoiseOfSum,
}

impl Reader {
    fn new(sensor: &Sensor, faults: &LineFaults) -> Result<Self, Error> {
        let pipeline = || -> Result<Pipeline, Error> {
            let mut pipeline = Pipeline::new(sensor, default_method(sensor)?)?;
            pipeline.set_lines(faults);
            Ok(pipeline)
        };
        Ok(Self {
            pipeline: pipeline()?,
            errors: StandardErrors::new(sensor, faults.level)?,
            bias: NoiseBias::new(sensor, pipeline()?, faults.level),
            sums: FigureErrors::new(sensor, faults.level)?,
        })
    }

    /// A frame's conductances, and what is asked beside. None without an answer.
    fn solve(&mut self, frame: &Frame<Counts>, asked: Asked) -> Result<Option<Solved>, Error> {
        self.pipeline.begin_anew();
        let result = self.pipeline.process(frame);
        let (Some(siemens), true) = (result.siemens, result.outcome.is_answer()) else {
            return Ok(None);
        };
        let loads = result.newtons()?;
        let mut noise_g = vec![f64::NAN; loads.values().len()];
        if asked == Asked::NoiseOfTaxels {
            let mut marks = loads.marks().to_vec();
            self.errors
                .of_loads(siemens, loads.values(), true, &mut marks)?;
            let parts = self.errors.parts().noise.values();
            for (to, &newtons) in noise_g.iter_mut().zip(parts) {
                *to = grams_from_newtons(newtons);
            }
        }
        let mut sum = NoiseOfSum::default();
        if asked == Asked::NoiseOfSum {
            let bias = self.bias.as_mut();
            let bias = bias.and_then(|bias| bias.of(result.volts, loads));
            self.sums.set_bias(bias);
            sum.added_g = bias.map_or(0.0, |bias| grams_from_newtons(bias.of_sum()));
            if let Some([error, common]) = self.sums.noise_of_total(siemens, loads) {
                (sum.error_g, sum.common_g) =
                    (grams_from_newtons(error), grams_from_newtons(common));
            }
        }
        Ok(Some(Solved {
            siemens: siemens.clone(),
            noise_g,
            marks: loads.marks().to_vec(),
            sum,
        }))
    }
}

impl<'a> Measurement<'a> {
    pub(super) fn new(sensor: &'a Sensor, data: &'a CheckData) -> Result<Self, Error> {
        let mut reader = Reader::new(sensor, &line_faults(sensor, data)?)?;
        let mut left_out = data.left_out.clone();
        let mut frames = Vec::with_capacity(data.frames.len());
        for (i, frame) in data.frames.iter().enumerate() {
            let solved = reader.solve(frame, Asked::NoiseOfTaxels)?;
            if solved.is_none() {
                left_out.push(format!("frame {i} of the presses has no answer"));
            }
            frames.push(solved);
        }
        let mut totals = Vec::new();
        for (recording, _) in &data.totals {
            totals.push(solve_all(
                &mut reader,
                recording,
                "a total",
                |_| Asked::NoiseOfSum,
                &mut left_out,
            )?);
        }
        let empty = solve_all(
            &mut reader,
            &data.empty,
            "the empty array",
            |frame| {
                if frame < NOISY_FRAMES {
                    Asked::NoiseOfTaxels
                } else {
                    Asked::Nothing
                }
            },
            &mut left_out,
        )?;
        let mut found = Self {
            sensor,
            data,
            frames,
            totals,
            empty,
            left_out,
        };
        found.name_lost();
        found.drop_hidden_totals()?;
        Ok(found)
    }

    /// Names presses on taxels without a number.
    fn name_lost(&mut self) {
        for press in &self.data.presses {
            let taxel = press.row * self.sensor.columns() + press.column;
            if let Some(solved) = &self.frames[press.frame]
                && solved.marks[taxel] != Mark::Good
            {
                self.left_out.push(format!(
                    "row {}, column {}, {} g: no measurement there ({})",
                    press.row,
                    press.column,
                    press.load_g,
                    solved.marks[taxel].word()
                ));
            }
        }
    }

    /// Leaves out totals part of which may stand where nothing was measured: beside a load. What the rest carries tells no scale.
    fn drop_hidden_totals(&mut self) -> Result<(), Error> {
        let mut laws = Pipeline::new(self.sensor, default_method(self.sensor)?)?;
        let (rows, columns) = (self.sensor.rows(), self.sensor.columns());
        let mut loads = Frame::<Grams>::zeros(rows, columns);
        for (frames, (_, load_g)) in self.totals.iter_mut().zip(&self.data.totals) {
            let mut hidden = Vec::new();
            for solved in &*frames {
                loads_into(&mut laws, solved, &mut loads)?;
                hidden.push(lost_beside_loads(solved, &loads) as f64);
            }
            if let Some(taxels) = median(hidden).filter(|taxels| *taxels > 0.0) {
                self.left_out.push(format!(
                    "a total of {load_g:.0} g: {taxels:.0} taxels beside loads were not measured, and what stands on them is missing from its sum"
                ));
                frames.clear();
            }
        }
        Ok(())
    }

    /// Whether loads above nothing were to be compared.
    pub(super) fn has_known_loads(&self) -> bool {
        let presses = &self.data.presses;
        presses.iter().any(|press| press.load_g > 0.0) || !self.data.totals.is_empty()
    }

    /// Whether it is known what the empty array reads.
    pub(super) fn has_empty(&self) -> bool {
        !self.empty.is_empty()
    }

    /// What is read where films conduct `conductance_scale` times what they did.
    pub(super) fn read(&self, conductance_scale: f64) -> Result<Readings, Error> {
        let scaled = self.sensor.edited(|spec| {
            if let Some(material) = &mut spec.material {
                material.factor *= conductance_scale;
            }
        })?;
        let mut laws = Pipeline::new(&scaled, default_method(&scaled)?)?;
        let mut loads = Frame::<Grams>::zeros(scaled.rows(), scaled.columns());
        let mut readings = Readings::default();
        for (at, solved) in self.frames.iter().enumerate() {
            let Some(solved) = solved else { continue };
            loads_into(&mut laws, solved, &mut loads)?;
            self.read_presses(at, solved, &loads, &mut readings);
        }
        let mut empty = Vec::new();
        for solved in &self.empty {
            loads_into(&mut laws, solved, &mut loads)?;
            readings.offsets.extend(middle(solved, &loads));
            empty.push(loads.values().iter().sum());
        }
        // What the empty array reads adds up over all taxels.
        let zero_g = median(empty).unwrap_or(0.0);
        for (frames, (_, load_g)) in self.totals.iter().zip(&self.data.totals) {
            let mut sums = Vec::new();
            let mut sigma_g = 0.0f64;
            for solved in frames {
                loads_into(&mut laws, solved, &mut loads)?;
                let sum = loads.values().iter().sum::<f64>();
                sums.push(sum - solved.sum.added_g - zero_g);
                let noise_g = noise_of_median_g(solved.sum, frames.len());
                sigma_g = self.model_of_total_g(loads.values()).hypot(noise_g);
            }
            if let Some(reads_g) = median(sums) {
                readings.totals.push(Reading {
                    load_g: *load_g,
                    reads_g,
                    sigma_g,
                    expected_g: sigma_g,
                });
            }
        }
        Ok(readings)
    }

    fn read_presses(&self, frame: usize, solved: &Solved, loads: &Frame<Grams>, to: &mut Readings) {
        let numbered = self.data.presses.iter().enumerate();
        let mut heaviest = 0.0f64;
        for (press, label) in numbered.filter(|(_, label)| label.frame == frame) {
            let taxel = label.row * loads.columns() + label.column;
            if solved.marks[taxel] != Mark::Good {
                continue;
            }
            if label.load_g == 0.0 {
                to.unloaded.push(Unloaded {
                    reads_g: loads.values()[taxel],
                    noise_g: solved.noise_of(taxel),
                });
                continue;
            }
            heaviest = heaviest.max(label.load_g);
            let summed = self.stands_alone(label, loads);
            let (mut reads_g, mut noise) = (0.0, 0.0);
            for (row, column) in around(label, 0, usize::from(summed), loads) {
                let taxel = row * loads.columns() + column;
                if is_measured(solved.marks[taxel]) {
                    reads_g += loads.values()[taxel];
                    noise += solved.noise_of(taxel).unwrap_or(0.0).powi(2);
                }
            }
            let noise_g = noise.sqrt();
            let reading = Reading {
                load_g: label.load_g,
                reads_g,
                sigma_g: noise_g.hypot(self.model_g(reads_g)),
                expected_g: noise_g.hypot(self.model_g(label.load_g)),
            };
            to.presses.push(PressReading {
                press,
                reading,
                summed,
            });
        }
        let values = loads.values();
        let loaded = values.iter().filter(|g| **g > 0.1 * heaviest).count();
        if heaviest > 0.0 && (loaded as f64) < QUIET_SHARE * values.len() as f64 {
            to.offsets.extend(middle(solved, loads));
        }
    }

    fn model_g(&self, load_g: f64) -> f64 {
        self.stated().map_or(0.0, |stated| stated.model_g(load_g))
    }

    /// What the model leaves unexplained of a sum: a share of it and a floor that a frame's taxels are off by together, and what each is
    /// off by besides. A floor that they share is in the empty array as well, if that was read.
    fn model_of_total_g(&self, loads_g: &[f64]) -> f64 {
        let Some(stated) = self.stated() else {
            return 0.0;
        };
        let (share, floor_g) = (stated.shared_share(), stated.shared_floor_g());
        let own = loads_g.iter().map(|load_g| stated.own_g(*load_g).powi(2));
        let own = own.sum::<f64>().sqrt();
        let floors_g = if self.empty.is_empty() {
            floor_g * loads_g.len() as f64
        } else {
            0.0
        };
        (share * loads_g.iter().sum::<f64>())
            .hypot(floors_g)
            .hypot(own)
    }

    fn stated(&self) -> Option<&UncertaintySpec> {
        self.sensor.uncertainty()
    }

    /// Whether nothing else is near a press, so that what its neighbours read is its own.
    fn stands_alone(&self, press: &PressLabel, loads: &Frame<Grams>) -> bool {
        let floor = self.stated().map_or(0.0, |stated| stated.model_floor_g);
        let most = (RING_SHARE * press.load_g).max(RING_FLOORS * floor);
        let near = |(row, column)| loads.values()[row * loads.columns() + column] < most;
        around(press, 2, RING, loads).all(near)
    }
}

/// Taxels from `from` to `to` away from a press, diagonals too.
fn around(
    press: &PressLabel,
    from: usize,
    to: usize,
    loads: &Frame<Grams>,
) -> impl Iterator<Item = (usize, usize)> + use<> {
    let (row, column) = (press.row, press.column);
    let rows = row.saturating_sub(to)..=(row + to).min(loads.rows() - 1);
    let columns = column.saturating_sub(to)..=(column + to).min(loads.columns() - 1);
    rows.flat_map(move |r| columns.clone().map(move |c| (r, c)))
        .filter(move |&(r, c)| r.abs_diff(row).max(c.abs_diff(column)) >= from)
}

/// Taxels that were not measured and may carry something: one next to them does.
fn lost_beside_loads(solved: &Solved, loads: &Frame<Grams>) -> usize {
    let largest_g = loads.values().iter().copied().fold(0.0, f64::max);
    let least_g = grams_from_newtons(CONTACT_NEWTONS).max(RING_SHARE * largest_g);
    let (rows, columns) = (loads.rows(), loads.columns());
    let is_loaded =
        |taxel: usize| is_measured(solved.marks[taxel]) && loads.values()[taxel] > least_g;
    let is_beside = |taxel: &usize| {
        let (row, column) = (taxel / columns, taxel % columns);
        let mut near = (row.saturating_sub(1)..=(row + 1).min(rows - 1)).flat_map(|r| {
            (column.saturating_sub(1)..=(column + 1).min(columns - 1)).map(move |c| (r, c))
        });
        near.any(|(r, c)| is_loaded(r * columns + c))
    };
    let lost = solved.marks.iter().enumerate();
    let lost = lost.filter(|(_, mark)| !is_measured(**mark) && **mark != Mark::Absent);
    lost.filter(|(taxel, _)| is_beside(taxel)).count()
}

/// Standard error by noise of the median of sums of so many frames that are alike, grams.
fn noise_of_median_g(sum: NoiseOfSum, frames: usize) -> f64 {
    let of_one = if frames > 2 { OF_MEDIAN } else { 1.0 };
    (of_one * sum.error_g / (frames as f64).sqrt()).hypot(sum.common_g)
}

fn is_measured(mark: Mark) -> bool {
    matches!(mark, Mark::Good | Mark::Interpolated)
}

/// What half of the taxels read less than.
fn middle(solved: &Solved, loads: &Frame<Grams>) -> Option<Unloaded> {
    let is_good = |taxel: &usize| solved.marks[*taxel] == Mark::Good;
    let good = || (0..solved.marks.len()).filter(is_good);
    Some(Unloaded {
        reads_g: median(good().map(|taxel| loads.values()[taxel]))?,
        noise_g: median(good().filter_map(|taxel| solved.noise_of(taxel))),
    })
}

fn loads_into(laws: &mut Pipeline, solved: &Solved, loads: &mut Frame<Grams>) -> Result<(), Error> {
    laws.begin_anew();
    let newtons = laws.process_siemens(&solved.siemens).newtons()?;
    for (to, &newtons) in loads.values_mut().iter_mut().zip(newtons.values()) {
        *to = grams_from_newtons(newtons);
    }
    Ok(())
}

fn solve_all(
    reader: &mut Reader,
    frames: &[Frame<Counts>],
    what: &str,
    asked: impl Fn(usize) -> Asked,
    left_out: &mut Vec<String>,
) -> Result<Vec<Solved>, Error> {
    let mut all = Vec::new();
    for (i, frame) in frames.iter().enumerate() {
        match reader.solve(frame, asked(i))? {
            Some(solved) => all.push(solved),
            None => left_out.push(format!("frame {i} of {what} has no answer")),
        }
    }
    Ok(all)
}

/// Lines that the frames show to be out, and those of the sensor file.
fn line_faults(sensor: &Sensor, data: &CheckData) -> Result<LineFaults, Error> {
    let mut screen = LineScreen::from_sensor(sensor);
    let totals = data.totals.iter().flat_map(|(frames, _)| frames);
    for frame in data.frames.iter().chain(totals).chain(&data.empty) {
        screen.observe(frame)?;
    }
    Ok(screen.finish().with_declared(sensor.screen()))
}
