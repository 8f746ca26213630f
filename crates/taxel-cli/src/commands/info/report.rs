//! What `info` found, for people and for scripts.

use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::path::Path;

use serde::Serialize;
use taxel::frame::are_zeros;
use taxel::screen::ScreenReport;
use taxel::{Frame, Mark};
use taxel_io::exports::{ExportAbout, Survey, file_of};
use taxel_io::{Event, Integrity, Skipped};

use super::exported::Exported;

use taxel_app::line_survey::FaultyLine;
use taxel_app::simulated::simulated_source;

/// How many frames left out, and how many events, are named one by one.
const NAMED: usize = 10;
/// Resolutions of converters people use.
const BITS: [u32; 9] = [8, 10, 12, 14, 16, 18, 20, 24, 32];

#[derive(Debug, Serialize)]
pub(super) struct Report {
    file: String,
    /// Bytes of the file.
    bytes: Option<u64>,
    pub(super) sensor: Option<String>,
    /// What simulated it, where it tells.
    #[serde(skip_serializing_if = "Option::is_none")]
    simulated: Option<String>,
    /// What another program that has exported the file says of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    exported: Option<Exported>,
    /// `null` where nothing tells.
    rows: Option<usize>,
    columns: usize,
    /// `null` where the rows are unknown.
    frames: Option<u64>,
    lines: u64,
    least: Option<f64>,
    most: Option<f64>,
    mean: Option<f64>,
    /// Where there is no sensor: the least resolution of a converter that gives these counts.
    assumed_bits: Option<u32>,
    duration_secs: Option<f64>,
    frames_per_second: Option<f64>,
    baseline_counts: Option<f64>,
    noise_counts: Option<f64>,
    /// Readings that are not good, as a share of all.
    outlier_share: Option<f64>,
    marks: BTreeMap<&'static str, u64>,
    /// Share of the readings outside the mask of the sensor file, if it has one.
    outside_mask_share: Option<f64>,
    faulty_lines: Vec<FaultyLine>,
    /// What happened during the recording.
    events: Vec<Happened>,
    pub(super) skipped_frames: usize,
    pub(super) skipped: Vec<String>,
    /// What the file has lost, what the frames' numbers tell, what was counted while it was recorded.
    integrity: Integrity,
    /// The same in words.
    pub(super) missing: Vec<String>,
    #[serde(skip)]
    pub(super) rows_known: bool,
    #[serde(skip)]
    pub(super) range: Range,
    #[serde(skip)]
    screened: Option<String>,
}

impl Report {
    pub(super) fn new(file: &Path, rows: usize, columns: usize, rows_known: bool) -> Self {
        let about = fs::metadata(file_of(file))
            .ok()
            .filter(fs::Metadata::is_file);
        Self {
            file: file.display().to_string(),
            bytes: about.map(|about| about.len()),
            sensor: None,
            simulated: simulated_source(file),
            exported: None,
            rows: rows_known.then_some(rows),
            columns,
            frames: None,
            lines: 0,
            least: None,
            most: None,
            mean: None,
            assumed_bits: None,
            duration_secs: None,
            frames_per_second: None,
            baseline_counts: None,
            noise_counts: None,
            outlier_share: None,
            marks: BTreeMap::new(),
            outside_mask_share: None,
            faulty_lines: Vec::new(),
            events: Vec::new(),
            skipped_frames: 0,
            skipped: Vec::new(),
            integrity: Integrity::default(),
            missing: Vec::new(),
            rows_known,
            range: Range::default(),
            screened: None,
        }
    }

    /// The largest count of the smallest usual converter that can have given `most`.
    pub(super) fn assume_bits(&mut self, most: f64) -> f64 {
        let largest = |bits: u32| 2f64.powi(bits as i32) - 1.0;
        let bits = BITS.into_iter().find(|&bits| largest(bits) >= most);
        self.assumed_bits = bits;
        bits.map_or(most, largest)
    }

    /// What another program says of its file, as far as it has exported it.
    pub(super) fn add_export(&mut self, found: Option<(ExportAbout, Survey)>, with_names: bool) {
        self.exported = found.map(|(about, survey)| Exported::new(&about, &survey, with_names));
    }

    pub(super) fn add_skips(&mut self, count: usize, first: &[Skipped]) {
        self.skipped_frames = count;
        let named = first.iter().take(NAMED);
        self.skipped = named
            .map(|skipped| format!("frame {} left out: {}", skipped.frame, skipped.error))
            .collect();
    }

    pub(super) fn add_integrity(&mut self, integrity: Integrity) {
        self.missing = integrity.words();
        self.integrity = integrity;
    }

    pub(super) fn add_events(&mut self, events: Vec<Event>) {
        self.events = events
            .into_iter()
            .map(|event| Happened {
                secs: event.secs,
                kind: event.kind,
                text: event.text,
            })
            .collect();
    }

    /// Whether another program has exported the file: it has screened the readings, and what it left out is no baseline.
    pub(super) fn is_exported(&self) -> bool {
        self.exported.is_some()
    }

    pub(super) fn screen(&mut self, screened: &ScreenReport) {
        self.baseline_counts = screened.lines.level.map(|level| level.baseline_counts);
        self.noise_counts = screened.lines.level.map(|level| level.noise_counts);
        self.outlier_share = Some(screened.outlier_share());
        self.marks = Mark::ALL
            .into_iter()
            .filter(|&mark| mark != Mark::Absent && screened.count(mark) > 0)
            .map(|mark| (mark.word(), screened.count(mark)))
            .collect();
        self.outside_mask_share = screened.mask.map(|(_, count)| count.share());
        let faults = screened.lines.faults.iter();
        self.faulty_lines = faults.map(|fault| FaultyLine::new(fault, false)).collect();
        // Its first line counts frames and readings, which are told already.
        let text = screened.to_string();
        self.screened = text.split_once('\n').map(|(_, rest)| rest.to_owned());
    }

    /// Fills in what is known once every frame was seen.
    pub(super) fn finish(&mut self) {
        let range = &self.range;
        self.frames = self.rows_known.then_some(range.frames);
        self.lines = range.frames * self.rows.unwrap_or(1) as u64;
        if range.readings > 0 {
            (self.least, self.most) = (Some(range.least), Some(range.most));
            self.mean = Some(range.sum / range.readings as f64);
        }
        if let Some((first, last)) = range.times
            && last > first
        {
            self.duration_secs = Some(last - first);
            self.frames_per_second = Some((range.frames - 1) as f64 / (last - first));
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = match self.bytes {
            Some(bytes) => format!("  {bytes} bytes"),
            None => String::new(),
        };
        writeln!(f, "{}{size}", self.file)?;
        if let Some(exported) = &self.exported {
            write!(f, "{exported}")?;
        }
        if let Some(source) = &self.simulated {
            writeln!(f, "simulated ({source}): nobody pressed")?;
        }
        match (self.rows, self.frames) {
            (Some(rows), Some(frames)) => {
                writeln!(
                    f,
                    "{frames} frames of {rows} rows x {} columns",
                    self.columns
                )?;
            }
            _ => writeln!(
                f,
                "{} lines of {} columns; how many make a frame is not in the file\nhint: give --rows or --sensor, to have it screened",
                self.lines, self.columns
            )?,
        }
        if let (Some(least), Some(most), Some(mean)) = (self.least, self.most, self.mean) {
            writeln!(f, "values {least} to {most}, mean {mean:.6}")?;
        }
        if let (Some(bits), None) = (self.assumed_bits, &self.sensor) {
            writeln!(
                f,
                "converter of {bits} bits assumed; a sensor file would say"
            )?;
        }
        if let (Some(duration), Some(rate)) = (self.duration_secs, self.frames_per_second) {
            writeln!(f, "{duration:.3} s, {rate:.2} frames/s")?;
        }
        if self.skipped_frames > 0 {
            writeln!(f, "{} frames left out", self.skipped_frames)?;
        }
        for (at, words) in self.missing.iter().enumerate() {
            let head = if at == 0 { "missing:\n" } else { "" };
            writeln!(f, "{head}  {words}")?;
        }
        f.write_str(self.screened.as_deref().unwrap_or_default())?;
        if !self.events.is_empty() {
            writeln!(f, "events:")?;
        }
        for event in self.events.iter().take(NAMED) {
            writeln!(f, "  {:10.3} s  {}: {}", event.secs, event.kind, event.text)?;
        }
        if self.events.len() > NAMED {
            writeln!(
                f,
                "  and {} more; --json has them all",
                self.events.len() - NAMED
            )?;
        }
        Ok(())
    }
}

/// An event of the recording.
#[derive(Debug, Serialize)]
struct Happened {
    /// Seconds since the first frame.
    secs: f64,
    kind: String,
    text: String,
}

/// Least, most and sum of all values, and the first and last time.
#[derive(Debug, Clone, Default)]
pub(super) struct Range {
    frames: u64,
    readings: u64,
    least: f64,
    most: f64,
    sum: f64,
    times: Option<(f64, f64)>,
}

impl Range {
    pub(super) fn add<Q>(&mut self, frame: &Frame<Q>) {
        if self.readings == 0 {
            (self.least, self.most) = (f64::INFINITY, f64::NEG_INFINITY);
        }
        self.frames += 1;
        self.readings += frame.taxels() as u64;
        let (values, last_values) = frame.values().as_chunks::<8>();
        let (marks, last_marks) = frame.marks().as_chunks::<8>();
        // Eight at once, each into a sum of its own.
        let (mut least, mut most, mut sums) = ([self.least; 8], [self.most; 8], [0.0; 8]);
        // Places of the eight that nothing was seen at: what reads nothing as well changes none of the three.
        let mut has_zero = [false; 8];
        for (values, marks) in values.iter().zip(marks) {
            let is_there: [bool; 8] = std::array::from_fn(|lane| marks[lane] != Mark::Absent);
            if are_zeros(values) {
                let pairs = is_there.iter().zip(&has_zero);
                if !pairs.fold(false, |any, (there, seen)| any | (there & !seen)) {
                    continue;
                }
                (0..8).for_each(|lane| has_zero[lane] |= is_there[lane]);
            }
            for lane in 0..8 {
                let (value, is_there) = (values[lane], is_there[lane]);
                if is_there & (value < least[lane]) {
                    least[lane] = value;
                }
                if is_there & (value > most[lane]) {
                    most[lane] = value;
                }
                sums[lane] += if is_there { value } else { 0.0 };
            }
        }
        let there = last_values.iter().zip(last_marks);
        let there = there.filter(|(_, mark)| **mark != Mark::Absent);
        let last = there.map(|(value, _)| *value);
        self.sum += sums.iter().copied().chain(last.clone()).sum::<f64>();
        self.least = least
            .iter()
            .copied()
            .chain(last.clone())
            .fold(self.least, f64::min);
        self.most = most.iter().copied().chain(last).fold(self.most, f64::max);
        if let Some(now) = frame.time_secs {
            self.times = Some((self.times.map_or(now, |(first, _)| first), now));
        }
    }

    pub(super) fn most(&self) -> f64 {
        self.most
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use taxel::Counts;

    /// Of frames of few readings and many, above and below nothing, with absent crossings and without.
    #[test]
    fn what_reads_nothing_is_seen_once() {
        for seed in 0..200usize {
            let mut frame = Frame::<Counts>::zeros(2, 1 + seed % 67);
            let (values, marks) = frame.values_and_marks_mut();
            for (at, (value, mark)) in values.iter_mut().zip(marks).enumerate() {
                let drawn = (at * 7919 + seed * 104_729) % 1009;
                if (at / 8 + seed).is_multiple_of(3) {
                    *value = drawn as f64 / 7.0 - [0.0, 60.0, -1.0][seed % 3];
                }
                if (drawn + seed).is_multiple_of(4) {
                    *mark = Mark::Absent;
                }
            }
            let mut range = Range::default();
            range.add(&frame);
            let pairs = frame.values().iter().zip(frame.marks());
            let there = pairs.filter(|(_, mark)| **mark != Mark::Absent);
            let there: Vec<f64> = there.map(|(value, _)| *value).collect();
            assert_eq!(range.readings, there.len() as u64);
            assert_eq!(
                range.least,
                there.iter().copied().fold(f64::INFINITY, f64::min)
            );
            assert_eq!(
                range.most,
                there.iter().copied().fold(f64::NEG_INFINITY, f64::max)
            );
            assert!((range.sum - there.iter().sum::<f64>()).abs() < 1e-9 * (1.0 + range.sum.abs()));
        }
    }
}
