//! `taxel demo`: the whole chain on a simulated hand, without hardware or files.

use std::path::{Path, absolute};
use std::time::Instant;

use taxel::calibrate::{
    Calibration, CalibrationData, CalibrationOptions, LawChoice, calibrate_with, fit_pairs,
};
use taxel::frame::{grams_from_newtons, newtons_from_grams};
use taxel::material::LoadLaw;
use taxel::metric::{deviations_of_frames, ghost_level};
use taxel::pipeline::Pipeline;
use taxel::screen::{LineFaults, LineScreen};
use taxel::sensor::preset;
use taxel::simulate::{Imperfections, Pattern, VirtualSensor, labelled_presses, newtons};
use taxel::solve::{Method, Raw, default_method};
use taxel::{Counts, Frame, Newtons, Sensor};
use taxel_plot::{Panel, Sheet};

use crate::error::Error;
use crate::progress::Progress;
use crate::{Exit, out};
use taxel_app::executor::Threads;

/// Watch the whole chain at work on a simulated hand
///
/// A hand grips a virtual e-Cone of 64 x 128 taxels. Its recording is screened; the circuit is fitted to 120
/// simulated presses, with nothing known but the parts list; loads are computed with and without the circuit
/// and compared with what the hand really did. Writes taxel-demo.png in the working directory.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {}

const SEED: u64 = 3;
const PRESSES: usize = 120;
/// A firm grip, squeezing with up to this on a taxel, grams.
const PEAK_G: f64 = 600.0;
/// The frames of the recording: one grip. Loads are judged while it holds.
const FRAMES: u64 = 160;
const JUDGED: std::ops::Range<u64> = 64..72;
const PICTURE: &str = "taxel-demo.png";

/// A frame that was read, and the loads behind it.
struct Known {
    counts: Frame<Counts>,
    truth: Frame<Newtons>,
}

/// Runs the command.
pub(crate) fn run(_: &Args) -> Result<Exit, Error> {
    let begun = Instant::now();
    let nominal = preset("econe")?;
    let mut imperfections = Imperfections::default();
    imperfections.dead_columns = 1;
    imperfections.faults.stuck_share = 5e-4;
    let real = VirtualSensor::imperfect(&nominal, &imperfections, SEED)?;
    out::result(&format!(
        "a simulated hand grips {} for {FRAMES} frames",
        nominal.name()
    ))?;
    let (recording, faults) = record(&real)?;
    for fault in &faults.faults {
        out::result(&format!("screened: {fault}"))?;
    }
    let presses = labelled_presses(&real, PRESSES);
    let Calibration { sensor, report, .. } = fit(&nominal, &presses)?;
    for parameter in &report.parameters {
        out::result(&format!("calibrated: {parameter}"))?;
    }
    let compared = Compared::new(&sensor, &faults, &presses, &recording)?;
    out::result(&compared.table())?;
    compared.draw(&recording)?;
    let picture = absolute(PICTURE).unwrap_or_else(|_| PICTURE.into());
    out::result(&format!(
        "\nbefore and after: {}\n{:.1} s in all",
        picture.display(),
        begun.elapsed().as_secs_f64()
    ))?;
    Ok(Exit::Good)
}

/// Records the grip; gives back the frames to be judged, and the faulty lines found in all of them.
fn record(real: &VirtualSensor) -> Result<(Vec<Known>, LineFaults), Error> {
    let sensor = real.sensor();
    let mut screen = LineScreen::from_sensor(sensor);
    let pattern = Pattern::hand().with_peak_g(PEAK_G);
    let progress = Progress::new("gripping");
    let mut judged = Vec::new();
    for (frame, (loads, reading)) in real.recording(&pattern, 0..FRAMES).enumerate() {
        screen.observe(&reading.counts)?;
        if JUDGED.contains(&(frame as u64)) {
            judged.push(Known {
                counts: reading.counts,
                truth: newtons(&loads),
            });
        }
        progress.set(frame as f64 / FRAMES as f64);
    }
    Ok((judged, screen.finish()))
}

/// Fits the circuit and a power law, from the parts list alone.
fn fit(nominal: &Sensor, presses: &CalibrationData) -> Result<Calibration, Error> {
    let parts = nominal.edited(|spec| {
        spec.material = None;
        spec.readout.r_mux_column_ohms = None;
        spec.readout.r_mux_row_ohms = None;
    })?;
    let mut options = CalibrationOptions::default();
    options.law = LawChoice::Power;
    options.folds = 2;
    let progress = Progress::new("fitting");
    let mut show = |stage: &str, share| progress.stage(stage, share);
    Ok(calibrate_with(
        &parts, presses, &options, &Threads, &mut show,
    )?)
}

/// The ways: a word, and what it stands for.
const RAW: (&str, &str) = ("raw", "the load law on readings as they are");
const CURVE: (&str, &str) = ("one curve", "one calibration curve, no circuit");
const EXACT: (&str, &str) = ("exact", "the circuit undone, then the load law");

/// Grams for a table: one decimal from 1 g on, two below.
fn short(grams: f64) -> String {
    if grams >= 1.0 {
        format!("{grams:.1}")
    } else {
        format!("{grams:.2}")
    }
}

/// One way to the loads, and how far it is from the truth.
struct Way {
    name: &'static str,
    /// What it does, as README.md has it.
    words: &'static str,
    error_g: f64,
    ghost_largest_g: f64,
    frames_per_second: f64,
    /// Loads of the last frame.
    last: Frame<Newtons>,
}

struct Compared {
    raw: Way,
    curve: Way,
    exact: Way,
    pitch_mm: [f64; 2],
}

impl Compared {
    fn new(
        sensor: &Sensor,
        faults: &LineFaults,
        presses: &CalibrationData,
        recording: &[Known],
    ) -> Result<Self, Error> {
        let pipeline = |method: Box<dyn Method>| -> Result<Pipeline, Error> {
            let mut pipeline = Pipeline::new(sensor, method)?;
            pipeline.set_lines(faults);
            Ok(pipeline)
        };
        let raw = || pipeline(Box::new(Raw::from_sensor(sensor)));
        let curve = one_curve(&mut raw()?, presses);
        Ok(Self {
            raw: Way::of(RAW, raw()?, recording, None)?,
            curve: Way::of(CURVE, raw()?, recording, Some(&curve))?,
            exact: Way::of(EXACT, pipeline(default_method(sensor)?)?, recording, None)?,
            pitch_mm: sensor.array().pitch_mm,
        })
    }

    fn table(&self) -> String {
        let mut text = "\n| | error | largest ghost |\n|---|---|---|\n".to_owned();
        let mut speeds = Vec::new();
        for way in [&self.raw, &self.curve, &self.exact] {
            text += &format!(
                "| {} | {} g | {} g |\n",
                way.words,
                short(way.error_g),
                short(way.ghost_largest_g)
            );
            speeds.push(format!("{} {:.0}", way.name, way.frames_per_second));
        }
        text + &format!(
            "\nerror: mean absolute, over loaded taxels; ghost: load reported where there is none\n\
             frames a second: {}",
            speeds.join(", ")
        )
    }

    fn draw(&self, recording: &[Known]) -> Result<(), Error> {
        let grams = |frame: &Frame<Newtons>| -> Frame<Newtons> {
            frame.map(|_, newtons| grams_from_newtons(newtons))
        };
        let last = recording.last().map(|known| grams(&known.truth));
        let stages = [
            (self.raw.name, Some(grams(&self.raw.last))),
            (self.exact.name, Some(grams(&self.exact.last))),
            ("what the hand did", last),
        ];
        let mut panels = Vec::new();
        for (name, frame) in &stages {
            let Some(frame) = frame else { continue };
            panels.push(
                Panel::of(frame)
                    .title(match *name {
                        "raw" => "before: as read",
                        "exact" => "after: cross-talk removed",
                        other => other,
                    })
                    .unit("g")
                    .pitch_mm(self.pitch_mm),
            );
        }
        let picture = Sheet::new(panels)?
            .shared_range(true)
            .caption(format!(
                "A simulated hand on an e-Cone. Mean absolute error {:.1} g before, {:.2} g after.",
                self.raw.error_g, self.exact.error_g
            ))
            .picture()?;
        out::file(Path::new(PICTURE), &picture.png()?)
    }
}

/// The best curve through load against reading, as it would be fitted without a circuit.
fn one_curve(raw: &mut Pipeline, presses: &CalibrationData) -> LoadLaw {
    let pairs: Vec<(f64, f64)> = presses
        .presses
        .iter()
        .map(|press| {
            let found = raw.process(&presses.frames[press.frame]);
            (
                found.siemens.expect("solved").at(press.row, press.column),
                press.load_g,
            )
        })
        .collect();
    fit_pairs(&pairs).swap_remove(0).law
}

impl Way {
    fn of(
        (name, words): (&'static str, &'static str),
        mut pipeline: Pipeline,
        recording: &[Known],
        curve: Option<&LoadLaw>,
    ) -> Result<Self, Error> {
        let mut way = Self {
            name,
            words,
            error_g: 0.0,
            ghost_largest_g: 0.0,
            frames_per_second: 0.0,
            last: Frame::zeros(1, 1),
        };
        let (frames, mut seconds) = (recording.len() as f64, 0.0);
        for known in recording {
            let begun = Instant::now();
            let result = pipeline.process(&known.counts);
            way.last = match curve {
                None => result.newtons()?.clone(),
                Some(law) => result.siemens.expect("solved").map(|taxel, siemens| {
                    newtons_from_grams(law.grams_from_siemens(taxel, siemens))
                }),
            };
            seconds += begun.elapsed().as_secs_f64();
            if let Some(error) = deviations_of_frames(&way.last, &known.truth, |_, t| t > 0.0)? {
                way.error_g += grams_from_newtons(error.mean_absolute) / frames;
            }
            if let Some(ghost) = ghost_level(&way.last, &known.truth, 0.0)? {
                let largest = grams_from_newtons(ghost.largest);
                way.ghost_largest_g = way.ghost_largest_g.max(largest);
            }
        }
        way.frames_per_second = frames / seconds;
        Ok(way)
    }
}
