//! What the recordings of an experiment say of the taxels that its trials look at.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};

use taxel::circuit::Converter;
use taxel::frame::grams_from_newtons;
use taxel::metric::FrameFigures;
use taxel::pipeline::{FrameResult, Pipeline};
use taxel::{Counts, Frame, Mark, Newtons, Sensor};
use taxel_io::{FrameSource, ReadOptions, Trial, open_counts};

use super::coverage::{Halves, Intervals};
use super::plan::Value;
use super::regions;
use crate::error::Error;
use crate::frames::{Input, show};
use crate::line_survey::Survey;
use crate::methods::MethodName;
use crate::reporter::Reporter;
use crate::units::InputUnit;

/// How many frames that cannot be read are named, of each recording.
const NAMED: usize = 10;

/// The most readings of one table: they are held together, some 300 bytes each.
const MAX_READINGS: usize = 1 << 19;

/// What one frame says of a trial.
#[derive(Debug, Clone)]
pub struct TrialReading {
    /// The trial, by its place in the table.
    pub trial: usize,
    /// Device time, seconds.
    pub secs: Option<f64>,
    /// Place of the frame in its recording, from 0.
    pub frame: u64,
    /// Counts of the taxel; of a region those of any taxel, and nothing to look at.
    pub counts: f64,
    /// Its volts.
    pub volts: f64,
    /// Stuck, spiked, outside of the mask: no measurement.
    pub marked: bool,
    /// The converter's end was reached.
    pub saturated: bool,
    /// By each method.
    pub answers: Vec<Answer>,
}

/// What a method makes of a frame.
#[derive(Debug, Clone, Copy, Default)]
pub struct Answer {
    /// Conductance of the taxel; a region has none.
    pub siemens: Option<f64>,
    /// Load of the taxel, or of the region, where the sensor has a load law.
    pub grams: Option<f64>,
    /// Half of the 95 % interval of that, where it was asked for.
    pub half_g: Option<f64>,
    /// Load of the whole frame, grams.
    pub total_g: Option<f64>,
    /// Half of the 95 % interval of that, where it was asked for.
    pub total_half_g: Option<f64>,
    /// Centre of pressure, mm.
    pub centre_mm: Option<[f64; 2]>,
}

impl TrialReading {
    /// Neither marked nor at the converter's end: its value is one.
    pub fn is_measured(&self) -> bool {
        !self.marked && !self.saturated
    }

    /// In the unit that the plan asks for, by the first method.
    pub fn value(&self, value: Value) -> Option<f64> {
        match value {
            Value::Counts => Some(self.counts),
            Value::Volts => Some(self.volts),
            Value::Siemens => self.answers.first()?.siemens,
            Value::Grams => self.answers.first()?.grams,
        }
    }
}

/// A sensor with the methods that are asked of it.
pub struct Reader<'a> {
    sensor: Sensor,
    converter: Converter,
    pipelines: Vec<Pipeline>,
    /// Of each method, where they are asked for and it has them.
    intervals: Vec<Option<Intervals>>,
    frames_per_second: Option<f64>,
    reporter: &'a dyn Reporter,
    /// The material has creep or hysteresis: every frame counts, wanted or not.
    remembers: bool,
    /// Frames that a method found no answer to.
    pub unsolved: u64,
    /// The last of them in the recording at hand, by its sequence number.
    failed: Option<u64>,
    /// Frames that could not be read.
    pub skipped: u64,
    /// Lines that recordings show to be out, in words.
    pub faulty: BTreeSet<String>,
}

impl<'a> Reader<'a> {
    /// Opens the methods for a sensor that comes from `file`.
    ///
    /// # Errors
    /// A method that is none, or does not suit the sensor.
    pub fn new(
        sensor: &Sensor,
        file: &Path,
        methods: &[MethodName],
        frames_per_second: Option<f64>,
        reporter: &'a dyn Reporter,
    ) -> Result<Self, Error> {
        let pipeline = |method: &MethodName| method.pipeline(sensor, file);
        Ok(Self {
            converter: Converter::from_sensor(sensor),
            pipelines: methods.iter().map(pipeline).collect::<Result<_, _>>()?,
            intervals: methods.iter().map(|_| None).collect(),
            remembers: sensor.material().is_some_and(|m| m.dynamic.is_some()),
            sensor: sensor.clone(),
            frames_per_second,
            reporter,
            unsolved: 0,
            failed: None,
            skipped: 0,
            faulty: BTreeSet::new(),
        })
    }

    /// Finds intervals of loads as well, of the methods that have them.
    pub fn find_intervals(&mut self, methods: &[MethodName]) {
        let of = |method| Intervals::new(&self.sensor, method);
        self.intervals = methods.iter().map(of).collect();
    }

    /// Reads every recording of the trials once; readings in the order of the trials, then of time.
    pub fn read(&mut self, table: &Path, trials: &[Trial]) -> Result<Vec<TrialReading>, Error> {
        let mut by_recording: BTreeMap<&PathBuf, Vec<usize>> = BTreeMap::new();
        for (number, trial) in trials.iter().enumerate() {
            by_recording
                .entry(&trial.recording)
                .or_default()
                .push(number);
        }
        let mut readings = Vec::new();
        for (recording, numbers) in by_recording {
            let frames = self.read_one(table, recording, trials, &numbers, &mut readings)?;
            let beyond = numbers
                .iter()
                .filter_map(|&number| Some((&trials[number], trials[number].frame?)))
                .find(|(_, frame)| *frame as u64 >= frames);
            if let Some((trial, wanted)) = beyond {
                return Err(Error::NoFrame {
                    asked_by: format!("{}, line {}", table.display(), trial.line),
                    file: recording.clone(),
                    wanted: wanted as u64,
                    found: frames,
                });
            }
        }
        readings.sort_by_key(|reading| (reading.trial, reading.frame));
        Ok(readings)
    }

    fn read_one(
        &mut self,
        table: &Path,
        recording: &Path,
        trials: &[Trial],
        numbers: &[usize],
        readings: &mut Vec<TrialReading>,
    ) -> Result<u64, Error> {
        self.each_frame(recording, |reader, frame, index| {
            let of_frame = |number: &&usize| {
                let wanted = trials[**number].frame;
                wanted.is_none_or(|wanted| wanted as u64 == index)
            };
            let wanted: Vec<usize> = numbers.iter().filter(of_frame).copied().collect();
            if !wanted.is_empty() {
                if readings.len() + wanted.len() > MAX_READINGS {
                    return Err(Error::TooManyReadings {
                        table: table.to_owned(),
                        most: MAX_READINGS,
                    });
                }
                reader.take(frame, index, trials, &wanted, readings);
            } else if reader.remembers {
                reader.pass(frame);
            }
            Ok(())
        })
    }

    /// Calls `see` with every frame of a recording that can be read, and its place in it. Gives how many frames the
    /// recording has.
    pub fn each_frame(
        &mut self,
        recording: &Path,
        mut see: impl FnMut(&mut Self, &Frame<Counts>, u64) -> Result<(), Error>,
    ) -> Result<u64, Error> {
        let mut options = ReadOptions::of(&self.sensor);
        options.keep_going = true;
        self.look_for_faulty_lines(recording, options)?;
        let mut source = open_counts(recording, options)?;
        let mut frame = Frame::zeros(self.sensor.rows(), self.sensor.columns());
        let stage = self.reporter.stage("reading");
        for pipeline in &mut self.pipelines {
            pipeline.begin_anew();
        }
        let mut read = 0;
        self.failed = None;
        loop {
            // A format without times leaves what stands here.
            frame.time_secs = None;
            if !source.next_into(&mut frame)? {
                break;
            }
            // Frames that could not be read keep their places.
            let index = read + source.skipped() as u64;
            let counted = self.frames_per_second.map(|rate| index as f64 / rate);
            frame.time_secs = frame.time_secs.or(counted);
            see(self, &frame, index)?;
            show(&source, &*stage);
            read += 1;
        }
        let skipped = source.skipped() as u64;
        for skip in source.skips().iter().take(NAMED) {
            self.reporter
                .warn(&format!("frame {} left out: {}", skip.frame, skip.error));
        }
        self.skipped += skipped;
        Ok(read + skipped)
    }

    /// What is out in a recording is no measurement, whatever is looked at.
    fn look_for_faulty_lines(
        &mut self,
        recording: &Path,
        options: ReadOptions,
    ) -> Result<(), Error> {
        let input = Input {
            file: recording.to_owned(),
            unit: InputUnit::Counts,
            options,
        };
        let survey = Survey::of(&input, &self.sensor, self.reporter, None)?;
        for pipeline in &mut self.pipelines {
            pipeline.set_lines(&survey.faults);
        }
        let found = survey.lines().into_iter().skip(survey.declared);
        let name = recording.file_name().unwrap_or_default().to_string_lossy();
        self.faulty
            .extend(found.map(|line| format!("{name}: {}", line.text)));
        Ok(())
    }

    fn take(
        &mut self,
        frame: &Frame<Counts>,
        index: u64,
        trials: &[Trial],
        wanted: &[usize],
        readings: &mut Vec<TrialReading>,
    ) {
        let secs = frame.time_secs;
        let columns = self.sensor.columns();
        let taxel_of = |trial: usize| trials[trial].taxel.map(|(r, c)| r * columns + c);
        let region_of =
            |trial: usize| regions::place(trials[trial].region.as_deref(), &self.sensor);
        let regions: Vec<Option<usize>> = wanted.iter().map(|&trial| region_of(trial)).collect();
        let any = (0..frame.values().len()).find(|&taxel| !self.sensor.is_absent(taxel));
        let any = any.unwrap_or(0);
        let mut answers: Vec<Vec<Answer>> = vec![Vec::new(); wanted.len()];
        let mut marks = vec![Mark::Good; wanted.len()];
        let mut is_answered = true;
        for method in 0..self.pipelines.len() {
            is_answered &= self.solve(method, frame);
            let (total_g, centre_mm) = self.whole(method);
            let result = self.pipelines[method].result();
            let intervals = self.intervals[method].as_mut();
            let halves = intervals
                .filter(|_| is_answered)
                .and_then(|intervals| intervals.of(&result));
            for (place, &trial) in wanted.iter().enumerate() {
                let (mark, answer) = match regions[place] {
                    Some(at) => of_region(&result, halves.as_ref(), &self.sensor, at),
                    None => {
                        let taxel = taxel_of(trial).unwrap_or(any);
                        of_taxel(&result, halves.as_ref(), taxel)
                    }
                };
                marks[place] = mark;
                answers[place].push(Answer {
                    total_g,
                    total_half_g: halves.as_ref().map(|halves| halves.total),
                    centre_mm,
                    ..answer
                });
            }
        }
        // A frame that one method has no answer for is left out for all: they are compared on the same frames.
        if !is_answered {
            return;
        }
        for ((&trial, mark), answers) in wanted.iter().zip(marks).zip(answers) {
            let counts = frame.values()[taxel_of(trial).unwrap_or(any)];
            let is_region = trials[trial].region.is_some();
            let is_at_end = !is_region && counts >= self.sensor.max_count();
            readings.push(TrialReading {
                trial,
                secs,
                frame: index,
                counts,
                volts: self.volts(counts),
                marked: !matches!(mark, Mark::Good | Mark::Saturated | Mark::Interpolated),
                saturated: mark == Mark::Saturated || is_at_end,
                answers,
            });
        }
    }

    /// Lets the material see a frame that nobody asks for.
    fn pass(&mut self, frame: &Frame<Counts>) {
        for method in 0..self.pipelines.len() {
            self.solve(method, frame);
        }
    }

    /// Whether a method has an answer to a frame of counts, which stands in its pipeline afterwards.
    pub fn solve(&mut self, method: usize, frame: &Frame<Counts>) -> bool {
        let is_answer = self.pipelines[method].process(frame).outcome.is_answer();
        if !is_answer {
            // A frame counts once, however many methods fail.
            self.unsolved += u64::from(self.failed != Some(frame.sequence));
            self.failed = Some(frame.sequence);
        }
        is_answer
    }

    /// What a method made of the frame solved last.
    pub fn result(&self, method: usize) -> FrameResult<'_> {
        self.pipelines[method].result()
    }

    /// Total load, grams, and centre of pressure, mm.
    fn whole(&self, method: usize) -> (Option<f64>, Option<[f64; 2]>) {
        let Some(loads) = self.result(method).loads else {
            return (None, None);
        };
        let figures = FrameFigures::of(loads, &self.sensor);
        let total = grams_from_newtons(figures.total_force_newtons);
        (Some(total), figures.centre_mm)
    }

    /// V_out of a count.
    pub fn volts(&self, count: f64) -> f64 {
        let counts = Frame::<Counts>::filled(1, 1, count);
        self.converter.volts_from_counts(&counts).values()[0]
    }
}

/// What a method makes of a taxel, with the mark of its reading.
fn of_taxel(result: &FrameResult<'_>, halves: Option<&Halves<'_>>, taxel: usize) -> (Mark, Answer) {
    let grams = |loads: &Frame<Newtons>| grams_from_newtons(loads.values()[taxel]);
    let answer = Answer {
        siemens: result.siemens.map(|siemens| siemens.values()[taxel]),
        grams: result.loads.map(grams),
        half_g: halves.map(|halves| halves.taxels[taxel]),
        ..Answer::default()
    };
    (result.volts.marks()[taxel], answer)
}

/// The same of a region of the sensor, by its place among them.
fn of_region(
    result: &FrameResult<'_>,
    halves: Option<&Halves<'_>>,
    sensor: &Sensor,
    at: usize,
) -> (Mark, Answer) {
    let region = &sensor.regions()[at];
    let answer = Answer {
        grams: result.loads.map(|loads| regions::grams(loads, region)),
        half_g: halves.map(|halves| halves.regions[at]),
        ..Answer::default()
    };
    (regions::mark(result.volts, region), answer)
}

/// The trials of one setting and what was read.
pub struct Group {
    /// What the experiment is called.
    pub experiment: String,
    /// Frames that could not be read or have no answer.
    pub lost: u64,
    /// Empty where the table names none.
    pub setting: String,
    /// The sensor of this setting.
    pub sensor: Sensor,
    /// Its trials.
    pub trials: Vec<Trial>,
    /// What was read, in the order of the trials.
    pub readings: Vec<TrialReading>,
}

impl Group {
    /// Readings by experiment: the table's word for it, else its line.
    pub fn experiments(&self) -> Vec<Vec<&TrialReading>> {
        let mut places: HashMap<String, usize> = HashMap::new();
        let mut groups: Vec<Vec<&TrialReading>> = Vec::new();
        for reading in &self.readings {
            let trial = &self.trials[reading.trial];
            let name = match &trial.experiment {
                Some(word) => word.clone(),
                None => format!("line {}", trial.line),
            };
            let place = *places.entry(name).or_insert(groups.len());
            match groups.get_mut(place) {
                Some(group) => group.push(reading),
                None => groups.push(vec![reading]),
            }
        }
        groups
    }

    /// What `make` makes of every reading that `keep`s, by experiment.
    pub fn collect<T>(
        &self,
        keep: impl Fn(&TrialReading) -> bool,
        make: impl Fn(&Trial, &TrialReading) -> Result<T, Error>,
    ) -> Result<Vec<Vec<T>>, Error> {
        let each = |one: Vec<&TrialReading>| {
            let kept = one.into_iter().filter(|reading| keep(reading));
            kept.map(|reading| make(&self.trials[reading.trial], reading))
                .collect()
        };
        self.experiments().into_iter().map(each).collect()
    }

    /// What stands over a picture: the setting, or where there is one alone what the experiment is called.
    pub fn title(&self) -> &str {
        match self.setting.as_str() {
            "" => &self.experiment,
            setting => setting,
        }
    }

    /// The setting as it stands in a table.
    pub fn name(&self) -> &str {
        match self.setting.as_str() {
            "" => "all",
            setting => setting,
        }
    }
}
