//! The values of some taxels, frame by frame.

use taxel::screen::{FrameScreen, LineFaults, LineScreen, ScreenOptions};
use taxel::{Counts, Frame, Mark, Sensor};
use taxel_io::{FrameSource, Integrity, ReadOptions, open_counts};

use super::Args;
use crate::doubts::warn_of_suspects;
use crate::error::Error;
use crate::progress::Progress;
use crate::recorded::Untared;
use taxel_app::chain::Chain;
use taxel_app::frames::{DisplayUnit, FrameReader, show};
use taxel_app::methods::MethodName;

/// Values that are held at most: 800 MB.
const MAX_VALUES: usize = 100_000_000;

/// What was read.
pub(super) struct Taken {
    pub(super) names: Vec<String>,
    /// Position of each frame in the recording.
    pub(super) sequence: Vec<u64>,
    /// Seconds of each frame, where all are known.
    pub(super) secs: Option<Vec<f64>>,
    /// Of each taxel, in each frame.
    pub(super) values: Vec<Vec<f64>>,
    /// Whether the screen marked them.
    pub(super) marked: Vec<Vec<bool>>,
    pub(super) skipped_frames: usize,
    pub(super) skipped: Vec<String>,
    pub(super) integrity: Integrity,
}

impl Taken {
    pub(super) fn frames(&self) -> usize {
        self.sequence.len()
    }

    /// Seconds, else the frame's number.
    pub(super) fn position(&self, frame: usize) -> f64 {
        match &self.secs {
            Some(secs) => secs[frame],
            None => self.sequence[frame] as f64,
        }
    }

    /// The mean over the taxels of what is not filtered.
    pub(super) fn mean_screened(&self) -> Vec<f64> {
        let mean = |frame: usize| {
            let good = (0..self.names.len()).filter(|&taxel| !self.marked[taxel][frame]);
            let values: Vec<f64> = good.map(|taxel| self.values[taxel][frame]).collect();
            values.iter().sum::<f64>() / values.len() as f64
        };
        (0..self.frames()).map(mean).collect()
    }
}

/// What makes the unit that is asked for of counts.
fn chain_of(
    args: &Args,
    sensor: Option<&Sensor>,
    faults: &LineFaults,
) -> Result<Option<Chain>, Error> {
    let (Some(sensor), Some(unit)) = (sensor, args.unit) else {
        return Ok(None);
    };
    let file = args.sensor.as_deref().unwrap_or(&args.recording);
    let mut chain = Chain::new(sensor, file, &args.method, unit)?;
    chain.set_lines(faults);
    Ok(Some(chain))
}

/// Reads the recording twice: for faulty lines, then for values.
pub(super) fn take(
    args: &Args,
    sensor: Option<&Sensor>,
    options: ReadOptions,
    places: &[(String, usize, usize)],
) -> Result<Taken, Error> {
    let max_count = match options.max_count {
        Some(most) => most,
        None => largest(args, options)?,
    };
    let spec = sensor
        .map(|sensor| sensor.screen().clone())
        .unwrap_or_default();
    let screening = sensor.map_or_else(ScreenOptions::default, ScreenOptions::from_sensor);
    let faults = line_faults(args, options, max_count, &screening)?.with_declared(&spec);
    warn_of_suspects(&faults);
    let mut screen = FrameScreen::new(options.rows, options.columns, max_count, &screening);
    screen.set_lines(&faults);
    let mut chain = chain_of(args, sensor, &faults)?;
    let mut taken = Taken {
        names: places.iter().map(|place| place.0.clone()).collect(),
        sequence: Vec::new(),
        secs: Some(Vec::new()),
        values: vec![Vec::new(); places.len()],
        marked: vec![Vec::new(); places.len()],
        skipped_frames: 0,
        skipped: Vec::new(),
        integrity: Integrity::default(),
    };
    let mut reading = FrameReader::Counts(
        open_counts(&args.recording, options)?,
        Frame::zeros(options.rows, options.columns),
    );
    let mut shown = Frame::<DisplayUnit>::zeros(options.rows, options.columns);
    let mut untared = Untared::new(args.no_tare);
    let progress = Progress::new("reading");
    while reading.advance()? {
        let FrameReader::Counts(_, counts) = &mut reading else {
            unreachable!("it was opened as counts");
        };
        let mut screened = counts.clone();
        screen.mark(&mut screened)?;
        if let Some(chain) = &mut chain {
            chain.take(&reading)?;
            chain.show_into(&mut shown)?;
            let raw = args.method == MethodName::Raw;
            untared.apply(reading.tare(), raw, chain.load_unit(), shown.values_mut());
        }
        taken.add(args, &screened, chain.is_some().then_some(&shown), places)?;
        reading.show(&progress);
    }
    taken.integrity = reading.integrity();
    let (skipped, first) = reading.skips();
    taken.skipped_frames = skipped;
    let words = |skip: &taxel_io::Skipped| format!("frame {} left out: {}", skip.frame, skip.error);
    taken.skipped = first.iter().take(10).map(words).collect();
    Ok(taken)
}

impl Taken {
    fn add(
        &mut self,
        args: &Args,
        screened: &Frame<Counts>,
        shown: Option<&Frame<DisplayUnit>>,
        places: &[(String, usize, usize)],
    ) -> Result<(), Error> {
        if (self.sequence.len() + 1) * places.len() > MAX_VALUES {
            return Err(Error::Arguments {
                what: format!(
                    "{} taxels over {} frames are more values than are held, {MAX_VALUES}",
                    places.len(),
                    self.sequence.len() + 1
                ),
                hint: "look at fewer taxels, or cut the recording",
            });
        }
        let frame = self.sequence.len();
        self.sequence.push(screened.sequence);
        let counted = args.frames_per_second.map(|rate| frame as f64 / rate);
        match (screened.time_secs.or(counted), &mut self.secs) {
            (Some(secs), Some(all)) => all.push(secs),
            _ => self.secs = None,
        }
        for (i, &(_, row, column)) in places.iter().enumerate() {
            let value = shown.map_or(screened.at(row, column), |shown| shown.at(row, column));
            self.values[i].push(value);
            let mark = screened.mark_at(row, column);
            let lost = shown.is_some_and(|shown| shown.mark_at(row, column) == Mark::Unresolved);
            let filtered =
                lost || !matches!(mark, Mark::Good | Mark::Saturated | Mark::Interpolated);
            self.marked[i].push(filtered);
        }
        Ok(())
    }
}

fn line_faults(
    args: &Args,
    options: ReadOptions,
    max_count: f64,
    screening: &ScreenOptions,
) -> Result<LineFaults, Error> {
    let mut lines = LineScreen::new(options.rows, options.columns, max_count, screening);
    each(args, options, "looking for line faults", |frame| {
        Ok(lines.observe(frame)?)
    })?;
    Ok(lines.finish())
}

/// Without a sensor file the largest count stands for the converter's end.
fn largest(args: &Args, options: ReadOptions) -> Result<f64, Error> {
    let mut most = 1.0f64;
    each(args, options, "range", |frame| {
        most = frame.values().iter().copied().fold(most, f64::max);
        Ok(())
    })?;
    // All bits set, as a converter's end is.
    Ok(2f64.powf((most + 1.0).log2().ceil()) - 1.0)
}

fn each(
    args: &Args,
    options: ReadOptions,
    name: &str,
    mut see: impl FnMut(&Frame<Counts>) -> Result<(), Error>,
) -> Result<(), Error> {
    let mut source = open_counts(&args.recording, options)?;
    let mut frame = Frame::zeros(options.rows, options.columns);
    let progress = Progress::new(name);
    while source.next_into(&mut frame)? {
        see(&frame)?;
        show(&source, &progress);
    }
    Ok(())
}
