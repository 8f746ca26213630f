//! What `info` tells of a file that another program has exported.

use std::fmt;

use serde::Serialize;
use taxel_io::exports::{ExportAbout, Quantity, Survey};

/// What the file says, and what its numbers come to.
#[derive(Debug, Serialize)]
pub(super) struct Exported {
    format: &'static str,
    program: String,
    /// The sensor of those in the file, where it holds several.
    #[serde(skip_serializing_if = "String::is_empty")]
    sensor: String,
    unit: String,
    /// Sensels there are.
    sensels: usize,
    pitch_mm: Option<[f64; 2]>,
    area_mm2: Option<f64>,
    /// Where its numbers end, in its unit.
    saturation: Option<f64>,
    /// Below which value it has written 0, in its unit.
    threshold: Option<f64>,
    /// The largest number, and the sum of all, in its unit.
    largest: f64,
    sum: f64,
    /// The frame with the largest sum, from 0, and that in its unit and in newtons.
    heaviest_frame: Option<u64>,
    heaviest_sum: Option<f64>,
    heaviest_newtons: Option<f64>,
    /// How many frames it says it has.
    frames_told: Option<u64>,
    /// Whether raw counts stand behind all of its numbers, which `#raw` gives; `null` where it tells no calibration.
    has_raw_counts: Option<bool>,
    header: String,
}

impl Exported {
    pub(super) fn new(about: &ExportAbout, survey: &Survey, with_names: bool) -> Self {
        let pad = &about.pads[survey.pad];
        let newtons = pad.newtons_per_unit().filter(|_| pad.areas_mm2.is_empty());
        let (frame, sum) = survey.heaviest.unzip();
        Self {
            format: about.format,
            program: about.program.clone(),
            sensor: pad.name.clone(),
            unit: pad.unit.clone(),
            sensels: pad.taxels(),
            pitch_mm: pad.pitch_mm,
            area_mm2: pad.area_mm2,
            saturation: pad.saturation.filter(|_| pad.quantity != Quantity::Raw),
            threshold: survey.threshold,
            largest: survey.largest,
            sum: survey.sum,
            heaviest_frame: frame,
            heaviest_sum: sum,
            heaviest_newtons: newtons.zip(sum).map(|(newtons, sum)| newtons * sum),
            frames_told: about.frames,
            has_raw_counts: survey.has_raw,
            header: if with_names {
                about.header.clone()
            } else {
                about.header_without_names()
            },
        }
    }
}

impl fmt::Display for Exported {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            format,
            program,
            unit,
            sensels,
            ..
        } = self;
        writeln!(
            f,
            "{format}, written by {program}: {unit} of {sensels} sensels"
        )?;
        if let Some([down, across]) = self.pitch_mm {
            write!(f, "sensels {down} mm x {across} mm apart")?;
        }
        match self.area_mm2 {
            Some(area) => writeln!(f, ", {area:.4} mm² each")?,
            None => writeln!(f, "the file does not tell how large they are")?,
        }
        writeln!(
            f,
            "largest {} {unit}, sum of all {:.2} {unit}",
            self.largest, self.sum
        )?;
        if let Some((frame, sum)) = self.heaviest_frame.zip(self.heaviest_sum) {
            write!(f, "heaviest frame {frame}: {sum:.2} {unit}")?;
            match self.heaviest_newtons {
                Some(newtons) => writeln!(f, ", {newtons:.2} N")?,
                None => writeln!(f)?,
            }
        }
        match self.has_raw_counts {
            Some(true) => writeln!(
                f,
                "raw counts stand behind all of its numbers: `#raw` behind the name reads them"
            )?,
            Some(false) => writeln!(
                f,
                "its calibration is not that of its numbers: no raw counts come of them"
            )?,
            None => {}
        }
        for line in self.header.lines() {
            writeln!(f, "  {line}")?;
        }
        Ok(())
    }
}
