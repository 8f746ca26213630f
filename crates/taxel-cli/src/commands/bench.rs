//! `taxel bench`: how long scan and inverse take, on this machine, for one sensor.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use serde::Serialize;
use taxel::circuit::{Circuit, OperatingPoint, SensorCircuit};
use taxel::estimate::LoadEstimator;
use taxel::solve::Solver;
use taxel::stats::median_in_place;
use taxel::{Frame, Sensor, Siemens, Volts};

use crate::error::Error;
use crate::progress::Progress;
use crate::{Exit, out};
use taxel_app::methods::{MethodName, Opened};
use taxel_io::sensor_file;

/// Time scan and inverse of a sensor on this machine
///
/// The frames: 3 taxels in 10 pressed to between 500 and 3000 ohms, the others at 1 microsiemens. Warm: each
/// frame starts from the one before it, whose pressed taxels differ by up to 4 %. As live, an inverse stops where
/// noise and rounding of the sensor file hide the rest.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Sensor file, or the name of a preset
    #[arg(long, value_name = "FILE|PRESET", default_value = "econe")]
    sensor: PathBuf,
    /// How loads are found: auto, exact, newton, raw, or the file of a model that `taxel train` wrote
    #[arg(long, value_name = "NAME|MODEL", default_value_t)]
    method: MethodName,
    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
}

/// Frames in a stream, one after the other and from the start again.
const STREAM: usize = 8;
/// How long each of the three is repeated.
const BUDGET: Duration = Duration::from_millis(650);
/// Fewest repeats, however long they take.
const MIN: usize = 5;

#[derive(Debug, Serialize)]
struct Report {
    sensor: String,
    rows: usize,
    columns: usize,
    method: &'static str,
    scan_us: Times,
    inverse_cold_us: Times,
    inverse_warm_us: Times,
    /// Of a warm stream, one core, by the median.
    frames_per_second: f64,
}

/// Microseconds a frame.
#[derive(Debug, Clone, Copy, Serialize)]
struct Times {
    min: f64,
    median: f64,
    repeats: usize,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    let sensor = sensor_file::load(&args.sensor)?;
    let in_file = |source| taxel_app::Error::InFile {
        file: args.sensor.clone(),
        source,
    };
    let circuit = SensorCircuit::from_sensor(&sensor).map_err(in_file)?;
    let mut work = Work::new(args.method.open(&sensor, &args.sensor)?);
    let progress = Progress::new("timing");
    let mut bench = Bench::new(&sensor, &circuit)?;
    let scan_us = bench.scan();
    progress.set(0.33);
    let inverse_cold_us = bench.inverse(&mut work, true);
    progress.set(0.66);
    let inverse_warm_us = bench.inverse(&mut work, false);
    drop(progress);
    let report = Report {
        sensor: match sensor.name() {
            "" => args.sensor.display().to_string(),
            name => name.to_owned(),
        },
        rows: sensor.rows(),
        columns: sensor.columns(),
        method: work.name,
        scan_us,
        inverse_cold_us,
        inverse_warm_us,
        frames_per_second: 1e6 / inverse_warm_us.median,
    };
    if args.json {
        out::json(&report)?
    } else {
        out::result(&report.table())?
    }
    if bench.unsolved > 0 {
        out::warn(&format!(
            "{} of {} solves did not converge: these times are not those of an answer",
            bench.unsolved, bench.solved
        ));
    }
    Ok(Exit::Good)
}

impl Report {
    fn table(&self) -> String {
        let line = |what, times: Times| {
            format!(
                "{what:<14}{:>12.1}{:>12.1}{:>10}\n",
                times.min, times.median, times.repeats
            )
        };
        format!(
            "{}, {} rows x {} columns, method {}, one core\n\n{:<14}{:>12}{:>12}{:>10}\n{}{}{}\n{:.0} frames/s in a warm stream\n",
            self.sensor,
            self.rows,
            self.columns,
            self.method,
            "us a frame",
            "min",
            "median",
            "repeats",
            line("scan", self.scan_us),
            line("inverse, cold", self.inverse_cold_us),
            line("inverse, warm", self.inverse_warm_us),
            self.frames_per_second
        )
    }
}

/// What is timed beside the scan.
struct Work {
    name: &'static str,
    way: Way,
}

enum Way {
    Solve(Box<dyn Solver>),
    Estimate(Box<dyn LoadEstimator>),
}

impl Work {
    fn new(opened: Opened) -> Self {
        match opened {
            Opened::Method(method) => {
                let mut solver = method.solver();
                solver.set_rounded(true);
                Self {
                    name: method.name(),
                    way: Way::Solve(solver),
                }
            }
            Opened::Estimator(estimator) => Self {
                name: estimator.name(),
                way: Way::Estimate(estimator),
            },
        }
    }
}

/// A short stream of frames and its scan.
struct Bench {
    point: Box<dyn OperatingPoint>,
    siemens: Vec<Frame<Siemens>>,
    volts: Vec<Frame<Volts>>,
    solved: usize,
    unsolved: usize,
}

impl Bench {
    fn new(sensor: &Sensor, circuit: &SensorCircuit) -> Result<Self, Error> {
        let siemens: Vec<_> = (0..STREAM).map(|i| pressed(sensor, i)).collect();
        let mut point = circuit.operating_point();
        let mut volts = Vec::new();
        for frame in &siemens {
            point
                .set(frame.values())
                .map_err(|source| Error::NotPassive {
                    file: "the bench's own frame".into(),
                    frame: 0,
                    source,
                })?;
            let mut scan = frame.map(|_, _| 0.0);
            point.predict_into(scan.values_mut());
            volts.push(scan);
        }
        Ok(Self {
            point,
            siemens,
            volts,
            solved: 0,
            unsolved: 0,
        })
    }

    fn scan(&mut self) -> Times {
        let mut out = self.volts[0].clone();
        repeat(|i| {
            let frame = &self.siemens[i % STREAM];
            if self.point.set(frame.values()).is_ok() {
                self.point.predict_into(out.values_mut());
            }
        })
    }

    fn inverse(&mut self, work: &mut Work, cold: bool) -> Times {
        let mut siemens = self.siemens[0].clone();
        let mut loads = siemens.map(|_, _| 0.0);
        repeat(|i| {
            let volts = &self.volts[i % STREAM];
            let outcome = match &mut work.way {
                Way::Solve(solver) => {
                    if cold {
                        solver.forget();
                    }
                    solver.solve_into(volts, &mut siemens)
                }
                Way::Estimate(estimator) => {
                    if cold {
                        estimator.forget();
                    }
                    estimator.estimate_into(volts, &mut loads)
                }
            };
            self.solved += 1;
            self.unsolved += usize::from(!outcome.stop.is_good());
        })
    }
}

/// Repeats `work`, once without looking at the clock, then until the time is used up.
fn repeat(mut work: impl FnMut(usize)) -> Times {
    work(0);
    let started = Instant::now();
    let mut times = Vec::new();
    while times.len() < MIN || started.elapsed() < BUDGET {
        let begin = Instant::now();
        work(times.len() + 1);
        times.push(begin.elapsed().as_secs_f64() * 1e6);
    }
    Times {
        min: times.iter().copied().fold(f64::INFINITY, f64::min),
        median: median_in_place(&mut times).unwrap_or(0.0),
        repeats: times.len(),
    }
}

/// Frame `i` of the stream: the same taxels pressed, each swelling and fading by up to 5 %.
fn pressed(sensor: &Sensor, i: usize) -> Frame<Siemens> {
    let turn = std::f64::consts::TAU * i as f64 / STREAM as f64;
    // A linear congruential generator: the same taxels on every machine.
    let mut state = 1u32;
    let mut random = || {
        state = state.wrapping_mul(2_654_435_761).wrapping_add(12_345);
        f64::from(state >> 8) / f64::from(1u32 << 24)
    };
    Frame::<Siemens>::zeros(sensor.rows(), sensor.columns()).map(|_, _| {
        let (is_pressed, ohms, phase) = (random() < 0.3, random(), random());
        if is_pressed {
            (1.0 + 0.05 * (turn + 6.3 * phase).sin()) / (500.0 + 2500.0 * ohms)
        } else {
            1e-6
        }
    })
}
