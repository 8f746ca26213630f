//! A block of frames on its way through a worker.

use std::ops::Range;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use taxel::metric::FrameFigures;
use taxel::pipeline::Pipeline as Chain;
use taxel::screen::{FrameScreen, Level};
use taxel::solve::Outcome;
use taxel::uncertainty::{FigureErrors, StandardErrors};
use taxel::{Counts, Frame, Newtons, Sensor, Siemens, Volts};
use taxel_app::in_order::Work;

use super::Source;
use crate::arrays::{self, crossings};
use crate::errors;
use crate::interrupt::Stop;
use crate::output::{Output, bytes, room};

/// What the numbers of frames are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Input {
    Counts(f64),
    Volts,
    Siemens,
}

impl Input {
    pub(super) fn named(unit: &str, sensor: &Sensor) -> PyResult<Self> {
        Ok(match unit {
            "counts" => Self::Counts(sensor.max_count()),
            "volts" => Self::Volts,
            "siemens" => Self::Siemens,
            other => {
                return Err(errors::other(format!(
                    "unit {other:?}\nhint: frames are counts, volts or siemens"
                )));
            }
        })
    }

    pub(super) fn range(self) -> arrays::Range {
        match self {
            Self::Counts(most) => arrays::Range::Counts(most),
            Self::Volts => arrays::Range::Finite,
            Self::Siemens => arrays::Range::NotNegative,
        }
    }
}

/// What is to come back beside loads, marks and answers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wanted {
    pub(super) siemens: bool,
    pub(super) standard_errors: bool,
    pub(super) figures: bool,
}

/// Frames, and what became of them.
pub(super) struct Block {
    frames: Vec<Frame<Counts>>,
    len: usize,
    done: Vec<Done>,
}

/// What became of one frame.
struct Done {
    loads: Frame<Newtons>,
    siemens: Vec<f64>,
    standard_errors: Vec<f64>,
    is_answer: bool,
    rounds: u32,
    residual: f64,
    figures: [f64; FIGURES.len()],
}

/// Figures of a frame; half-widths of 95 % intervals stand where standard errors were asked for.
pub(super) const FIGURES: [&str; 10] = [
    "force_newtons",
    "peak_kilopascals",
    "contact_area_mm2",
    "centre_y_mm",
    "centre_x_mm",
    "measured_share",
    "force_half_width_newtons",
    "contact_area_half_width_mm2",
    "centre_y_half_width_mm",
    "centre_x_half_width_mm",
];
/// How many of them need no standard errors.
const PLAIN: usize = 6;

impl Block {
    pub(super) fn new(sensor: &Sensor, frames: usize) -> Self {
        let (rows, columns) = (sensor.rows(), sensor.columns());
        let done = || Done {
            loads: Frame::zeros(rows, columns),
            siemens: Vec::new(),
            standard_errors: Vec::new(),
            is_answer: false,
            rounds: 0,
            residual: 0.0,
            figures: [f64::NAN; FIGURES.len()],
        };
        Self {
            frames: vec![Frame::zeros(rows, columns); frames],
            len: 0,
            done: (0..frames).map(|_| done()).collect(),
        }
    }

    /// Takes frames of the source, screened; false where there are none.
    pub(super) fn fill(
        &mut self,
        range: Range<usize>,
        source: &Source,
        screen: &mut FrameScreen,
    ) -> Result<bool, String> {
        self.len = range.len();
        for (frame, at) in self.frames.iter_mut().zip(range) {
            source.copy_frame(at, frame)?;
            frame.sequence = at as u64;
            let time = source.time.map(|time| time[at]);
            frame.time_secs = time.filter(|time| time.is_finite());
            if matches!(source.input, Input::Counts(_)) {
                let marked = screen.mark(frame);
                marked.expect("the frame has the sensor's shape");
            }
        }
        Ok(self.len > 0)
    }
}

/// A thread's own pipeline.
pub(super) struct Worker {
    pub(super) chain: Chain,
    standard_errors: Option<StandardErrors>,
    figure_errors: Option<FigureErrors>,
    volts: Frame<Volts>,
    siemens: Frame<Siemens>,
}

impl Worker {
    pub(super) fn new(chain: Chain) -> Self {
        let result = chain.result();
        let (rows, columns) = (result.volts.rows(), result.volts.columns());
        Self {
            chain,
            standard_errors: None,
            figure_errors: None,
            volts: Frame::zeros(rows, columns),
            siemens: Frame::zeros(rows, columns),
        }
    }

    /// Whether frames come to loads.
    pub(super) fn has_loads(&self) -> bool {
        self.chain.has_loads()
    }

    pub(super) fn noise_counts(&self) -> Option<f64> {
        self.standard_errors
            .as_ref()
            .map(StandardErrors::noise_counts)
    }

    /// What is needed for what is wanted.
    pub(super) fn prepare(
        &mut self,
        sensor: &Sensor,
        level: Option<Level>,
        wanted: Wanted,
    ) -> PyResult<()> {
        if !wanted.standard_errors {
            (self.standard_errors, self.figure_errors) = (None, None);
            return Ok(());
        }
        if !self.chain.has_siemens() {
            return Err(errors::other(
                "standard errors need an inverse to carry the converter's noise through\nhint: take the method auto, exact or newton",
            ));
        }
        let found = StandardErrors::new(sensor, level).map_err(errors::of_taxel)?;
        self.standard_errors = Some(found);
        if wanted.figures && self.has_loads() {
            let found = FigureErrors::new(sensor, level).map_err(errors::of_taxel)?;
            self.figure_errors = Some(found);
        }
        Ok(())
    }

    fn process(&mut self, counts: &Frame<Counts>, input: Input, out: &mut Done) {
        match input {
            Input::Counts(_) => drop(self.chain.process_screened(counts)),
            Input::Volts => {
                self.volts.copy_meta_from(counts);
                self.volts.values_mut().copy_from_slice(counts.values());
                self.chain.process_volts(&self.volts);
            }
            Input::Siemens => {
                self.siemens.copy_meta_from(counts);
                self.siemens.values_mut().copy_from_slice(counts.values());
                self.chain.process_siemens(&self.siemens);
            }
        }
        let result = self.chain.result();
        let outcome: &Outcome = result.outcome;
        (out.is_answer, out.rounds) = (outcome.is_answer(), outcome.iterations);
        out.residual = outcome.residual;
        match (result.loads, result.siemens) {
            (Some(loads), _) => {
                out.loads.copy_meta_from(loads);
                out.loads.values_mut().copy_from_slice(loads.values());
            }
            (None, Some(siemens)) => out.loads.copy_meta_from(siemens),
            (None, None) => out.loads.copy_meta_from(result.volts),
        }
        out.siemens.clear();
        if let Some(siemens) = result.siemens {
            out.siemens.extend_from_slice(siemens.values());
        }
    }

    /// Standard errors of the loads, or of the conductances where there are no loads; also marks what they exceed.
    fn find_errors(&mut self, out: &mut Done) {
        let result = self.chain.result();
        let (Some(errors), Some(siemens)) = (&mut self.standard_errors, result.siemens) else {
            return;
        };
        out.standard_errors.clear();
        if result.loads.is_some() {
            let (values, marks) = out.loads.values_and_marks_mut();
            let found = errors.of_loads(siemens, values, out.is_answer, marks);
            let found = found.expect("there are loads, so there is a law");
            out.standard_errors.extend_from_slice(found.values());
        } else {
            let found = errors.of_siemens(siemens, out.is_answer, out.loads.marks_mut());
            out.standard_errors.extend_from_slice(found.values());
        }
    }

    fn find_figures(&mut self, sensor: &Sensor, out: &mut Done) {
        let result = self.chain.result();
        let figures = FrameFigures::of(&out.loads, sensor);
        let centre = figures.centre_mm.unwrap_or([f64::NAN; 2]);
        out.figures[..PLAIN].copy_from_slice(&[
            figures.total_force_newtons,
            figures.peak_kilopascals,
            figures.contact_area_mm2,
            centre[0],
            centre[1],
            figures.measured_share,
        ]);
        if let (Some(errors), Some(siemens)) = (&mut self.figure_errors, result.siemens) {
            let found = errors.of(siemens, &out.loads, out.is_answer);
            let centre = found.centre_mm.map(|axes| axes.map(|e| e.half_width_95));
            let centre = centre.unwrap_or([f64::NAN; 2]);
            out.figures[PLAIN..].copy_from_slice(&[
                found.total_force_newtons.half_width_95,
                found.contact_area_mm2.half_width_95,
                centre[0],
                centre[1],
            ]);
        }
    }
}

/// The second half of a pipeline, by any thread.
pub(super) struct Solving<'a> {
    pub(super) wanted: Wanted,
    pub(super) input: Input,
    /// What is taken off each load, newtons: of every frame the same, or of each frame.
    pub(super) tare: Option<&'a [f64]>,
    pub(super) begins_anew: bool,
    pub(super) stop: &'a Stop,
    pub(super) sensor: &'a Sensor,
}

impl Work<Block> for Solving<'_> {
    type Worker = Worker;

    fn work(&self, worker: &mut Worker, block: &mut Block) {
        if self.begins_anew {
            worker.chain.begin_anew();
        }
        for (frame, out) in block.frames[..block.len].iter().zip(&mut block.done) {
            // The caller's thread looks, too, and unwinds.
            if self.stop.is_set() {
                return;
            }
            worker.process(frame, self.input, out);
            if self.wanted.standard_errors {
                worker.find_errors(out);
            }
            // Readings were uncertain by as much before it.
            if let Some(tare) = self.tare {
                let taxels = frame.taxels();
                let is_one = tare.len() == taxels;
                let at = if is_one { 0 } else { frame.sequence as usize };
                let zeros = &tare[at * taxels..][..taxels];
                let loads = out.loads.values_mut().iter_mut().zip(zeros);
                loads.for_each(|(load, zero)| *load -= zero);
            }
            if self.wanted.figures && worker.has_loads() {
                worker.find_figures(self.sensor, out);
            }
        }
    }
}

/// What came of all frames.
pub(super) struct Results {
    loads: Option<Output>,
    siemens: Option<Output>,
    standard_errors: Option<Output>,
    marks: Vec<u8>,
    answers: Vec<bool>,
    rounds: Vec<u32>,
    residuals: Vec<f64>,
    figures: Option<[Vec<f64>; FIGURES.len()]>,
    factor_95: Option<f64>,
    plain: usize,
}

impl Results {
    pub(super) fn new(
        sensor: &Sensor,
        frames: usize,
        single: bool,
        wanted: Wanted,
        has_loads: bool,
    ) -> PyResult<Self> {
        let numbers = frames.saturating_mul(crossings(sensor));
        let some = |yes: bool| yes.then(|| Output::new(single, numbers)).transpose();
        let factor_95 = sensor.uncertainty().map(|found| found.factor_95);
        Ok(Self {
            loads: some(has_loads)?,
            siemens: some(wanted.siemens || !has_loads)?,
            standard_errors: some(wanted.standard_errors)?,
            marks: room(numbers)?,
            answers: room(frames)?,
            rounds: room(frames)?,
            residuals: room(frames)?,
            figures: (wanted.figures && has_loads).then(|| std::array::from_fn(|_| Vec::new())),
            factor_95: factor_95.filter(|_| has_loads),
            plain: if wanted.standard_errors {
                FIGURES.len()
            } else {
                PLAIN
            },
        })
    }

    pub(super) fn take(&mut self, block: &Block) {
        for done in &block.done[..block.len] {
            if let Some(loads) = &mut self.loads {
                loads.extend(done.loads.values().iter().copied());
            }
            if let Some(siemens) = &mut self.siemens {
                siemens.extend(done.siemens.iter().copied());
            }
            if let Some(errors) = &mut self.standard_errors {
                errors.extend(done.standard_errors.iter().copied());
            }
            let codes = done.loads.marks().iter().map(|mark| mark.code());
            self.marks.extend(codes);
            self.answers.push(done.is_answer);
            self.rounds.push(done.rounds);
            self.residuals.push(done.residual);
            if let Some(figures) = &mut self.figures {
                for (column, value) in figures.iter_mut().zip(done.figures) {
                    column.push(value);
                }
            }
        }
    }

    /// Arrays by their names, of one axis each: `taxel._pipeline` gives them their shape.
    pub(super) fn into_dict(
        self,
        py: Python<'_>,
        noise_counts: Option<f64>,
    ) -> PyResult<Bound<'_, PyDict>> {
        use numpy::IntoPyArray;
        let dict = PyDict::new(py);
        for (name, output) in [
            ("loads", self.loads),
            ("siemens", self.siemens),
            ("standard_errors", self.standard_errors),
        ] {
            if let Some(output) = output {
                dict.set_item(name, output.into_array(py))?;
            }
        }
        dict.set_item("marks", bytes(py, self.marks))?;
        dict.set_item("answered", self.answers.into_pyarray(py))?;
        dict.set_item("rounds", self.rounds.into_pyarray(py))?;
        dict.set_item("residuals", self.residuals.into_pyarray(py))?;
        dict.set_item("factor_95", self.factor_95.unwrap_or(1.96))?;
        dict.set_item("noise_counts", noise_counts)?;
        if let Some(figures) = self.figures {
            let table = PyDict::new(py);
            for (name, column) in FIGURES.iter().zip(figures).take(self.plain) {
                table.set_item(name, column.into_pyarray(py))?;
            }
            dict.set_item("figures", table)?;
        }
        Ok(dict)
    }
}
