//! Do the intervals that the sensor file states hold what is known?

use taxel::evaluate::accuracy::{Pair, accuracy};
use taxel::frame::grams_from_newtons;
use taxel::metric::is_usable;
use taxel::pipeline::FrameResult;
use taxel::sensor::Region;
use taxel::stats::{Bootstrap, median};
use taxel::uncertainty::{FigureErrors, StandardErrors};
use taxel::{Frame, Newtons, Sensor};
use taxel_plot::cells;
use taxel_plot::report::{Cell, Table};

use super::readings::Group;
use crate::methods::MethodName;

const HEAD: [&str; 4] = ["", "readings", "inside, %", "half of the interval, median"];

/// What finds half of the 95 % interval of each load and of their sum.
pub struct Intervals {
    loads: StandardErrors,
    sum: FigureErrors,
    half_g: Vec<f64>,
    regions: Vec<Region>,
    region_half_g: Vec<f64>,
}

/// Halves of the intervals of one frame, grams; infinite where nothing bounds a load.
pub struct Halves<'a> {
    /// Of each taxel.
    pub taxels: &'a [f64],
    /// Of the sum of all.
    pub total: f64,
    /// Of the sum of each named region.
    pub regions: &'a [f64],
}

impl Intervals {
    /// `None` for a method that does not undo the circuit, of which errors are not known, and for a sensor without
    /// a circuit or a load law.
    pub fn new(sensor: &Sensor, method: &MethodName) -> Option<Self> {
        let undoes = matches!(
            method,
            MethodName::Auto | MethodName::Exact | MethodName::Newton
        );
        let is_lawful = sensor.material().is_some();
        Some(Self {
            loads: StandardErrors::new(sensor, None)
                .ok()
                .filter(|_| undoes && is_lawful)?,
            sum: FigureErrors::new(sensor, None).ok()?,
            half_g: vec![f64::INFINITY; sensor.rows() * sensor.columns()],
            regions: sensor.regions().to_vec(),
            region_half_g: vec![f64::INFINITY; sensor.regions().len()],
        })
    }

    /// Of a frame's loads; nothing where it has none.
    pub fn of(&mut self, result: &FrameResult<'_>) -> Option<Halves<'_>> {
        let (siemens, loads) = (result.siemens?, result.loads?);
        let is_answer = result.outcome.is_answer();
        let mut marks = loads.marks().to_vec();
        let factor = self.loads.factor_95();
        let errors = self
            .loads
            .of_loads(siemens, loads.values(), is_answer, &mut marks)
            .ok()?;
        for (half, &error) in self.half_g.iter_mut().zip(errors.values()) {
            *half = grams_from_newtons(factor * error);
        }
        let sum = self.sum.of(siemens, loads, is_answer);
        for (half, region) in self.region_half_g.iter_mut().zip(&self.regions) {
            *half = grams_from_newtons(self.sum.of_region(loads, region).half_width_95);
        }
        Some(Halves {
            taxels: &self.half_g,
            regions: &self.region_half_g,
            total: grams_from_newtons(sum.total_force_newtons.half_width_95),
        })
    }
}

/// How many of the known loads lie in their intervals, by experiment.
#[derive(Default)]
pub(super) struct Held {
    /// 100 for a load in its interval, 0 for another.
    experiments: Vec<Vec<Pair>>,
    halves: Vec<f64>,
}

impl Held {
    /// What follows is of another experiment.
    pub(super) fn begin_experiment(&mut self) {
        self.experiments.push(Vec::new());
    }

    /// Loads in the same unit; one without bounds says nothing.
    pub(super) fn add(&mut self, truth: f64, estimate: f64, half: f64) {
        if !half.is_finite() {
            return;
        }
        let is_inside = (estimate - truth).abs() <= half;
        if self.experiments.is_empty() {
            self.begin_experiment();
        }
        self.experiments
            .last_mut()
            .expect("one was begun")
            .push(Pair {
                truth: 0.0,
                estimate: if is_inside { 100.0 } else { 0.0 },
            });
        self.halves.push(half);
    }

    fn row(&self, name: String, bootstrap: &Bootstrap) -> Option<Vec<Cell>> {
        let found = accuracy(&self.experiments, bootstrap)?;
        let half = median(self.halves.iter().copied());
        Some(cells![name, found.readings, found.bias, half])
    }
}

/// What a recording with all loads known says of the intervals of a method.
pub(super) struct WholeFrames {
    intervals: Option<Intervals>,
    loaded: Held,
    unloaded: Held,
    total: Held,
}

impl WholeFrames {
    pub(super) fn new(sensor: &Sensor, method: &MethodName) -> Self {
        Self {
            intervals: Intervals::new(sensor, method),
            loaded: Held::default(),
            unloaded: Held::default(),
            total: Held::default(),
        }
    }

    pub(super) fn add(&mut self, result: &FrameResult<'_>, truth: &Frame<Newtons>, is_new: bool) {
        if is_new {
            for held in [&mut self.loaded, &mut self.unloaded, &mut self.total] {
                held.begin_experiment();
            }
        }
        let (Some(intervals), Some(loads)) = (&mut self.intervals, result.loads) else {
            return;
        };
        let Some(halves) = intervals.of(result) else {
            return;
        };
        let both = truth.values().iter().zip(loads.values()).zip(loads.marks());
        for (((&truth, &load), &mark), &half) in both.zip(halves.taxels) {
            let held = if truth > 0.0 {
                &mut self.loaded
            } else {
                &mut self.unloaded
            };
            if is_usable(mark) {
                held.add(grams_from_newtons(truth), grams_from_newtons(load), half);
            }
        }
        if let Some((truth, found)) = measured_sums(truth, loads) {
            let grams = grams_from_newtons;
            self.total.add(grams(truth), grams(found), halves.total);
        }
    }

    /// The rows of its method.
    pub(super) fn rows(&self, name: &str, bootstrap: &Bootstrap) -> Vec<Vec<Cell>> {
        let kinds = [
            ("loaded taxels", &self.loaded),
            ("unloaded taxels", &self.unloaded),
            ("whole array", &self.total),
        ];
        let rows = kinds.into_iter();
        rows.filter_map(|(kind, held)| held.row(format!("{name}, {kind}"), bootstrap))
            .collect()
    }
}

/// Sums over the taxels that were measured, of what stood there and of what was found; `None` where none was.
pub(super) fn measured_sums(truth: &Frame<Newtons>, loads: &Frame<Newtons>) -> Option<(f64, f64)> {
    let both = truth.values().iter().zip(loads.values());
    let measured = both
        .zip(loads.marks())
        .filter(|(_, mark)| is_usable(**mark));
    measured.fold(None, |sums, ((truth, found), _)| {
        let (all, of_found) = sums.unwrap_or_default();
        Some((all + truth, of_found + found))
    })
}

/// The table that such rows stand in.
pub(super) fn table(sensor: &Sensor, of: &str) -> Table {
    let stated = if sensor.uncertainty().is_some() {
        "the 95 % intervals of the sensor file"
    } else {
        "95 % intervals by noise alone (the sensor file has no [uncertainty])"
    };
    Table::new(format!("Known loads within {stated}, g{of}"), &HEAD)
}

/// What labelled readings say of the intervals of a method: of single taxels, and of whole arrays.
#[derive(Default)]
pub(super) struct Labelled {
    taxels: Held,
    regions: Held,
    total: Held,
}

impl Labelled {
    pub(super) fn of(group: &Group, method: usize) -> Self {
        let mut labelled = Self::default();
        for one in group.experiments() {
            labelled.taxels.begin_experiment();
            labelled.regions.begin_experiment();
            labelled.total.begin_experiment();
            for reading in one {
                let (trial, answer) = (&group.trials[reading.trial], &reading.answers[method]);
                let load = trial
                    .load_g
                    .filter(|_| super::has_place(trial) && !reading.marked);
                if let (Some(truth), Some(estimate), Some(half)) =
                    (load, answer.grams, answer.half_g)
                {
                    let held = match trial.region {
                        Some(_) => &mut labelled.regions,
                        None => &mut labelled.taxels,
                    };
                    held.add(truth, estimate, half);
                }
                if let (Some(truth), Some(estimate), Some(half)) =
                    (trial.total_g, answer.total_g, answer.total_half_g)
                {
                    labelled.total.add(truth, estimate, half);
                }
            }
        }
        labelled
    }

    pub(super) fn rows(&self, name: &str, bootstrap: &Bootstrap) -> Vec<Vec<Cell>> {
        let kinds = [
            ("taxel", &self.taxels),
            ("region", &self.regions),
            ("whole array", &self.total),
        ];
        let rows = kinds.into_iter();
        rows.filter_map(|(kind, held)| held.row(format!("{name}, {kind}"), bootstrap))
            .collect()
    }
}
