//! `taxel replay`: a recording as if a device sent it now.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use taxel::Frame;
use taxel_acquire::protocol::taxel1::{Header, encode};
use taxel_io::{FrameSource, ReadOptions, open_counts};

use crate::error::Error;
use crate::sending::{Out, packet_bits};
use crate::{Exit, interrupt, out};
use taxel_app::sensor_source;
use taxel_io::sensor_file;

/// Send a recording as a device would, in protocol taxel-1
///
/// To a UDP address, where `taxel live udp:…` listens, over TCP, or to standard output. `taxel view` shows a recording without
/// this detour.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Recording of counts
    recording: PathBuf,
    /// udp:HOST:PORT, tcp:HOST:PORT, listen:HOST:PORT for whoever connects there, or - for standard output
    #[arg(long, value_name = "ADDRESS")]
    to: String,
    /// Sensor file, or the name of a preset; .mcap and .parquet bring their own
    #[arg(long, value_name = "FILE|PRESET")]
    sensor: Option<PathBuf>,
    /// Playback speed, times as recorded, 0.001 to 1000; max (or 0): as fast as possible
    #[arg(long, value_name = "FACTOR|max", default_value = "1", value_parser = speed)]
    speed: f64,
}

/// Recorded seconds without a frame that are waited for; more is a clock that jumped.
const MAX_GAP: f64 = 10.0;
/// How often it looks whether it is to end.
const LOOK: Duration = Duration::from_millis(50);

/// When the next frame is due.
struct Pace {
    speed: f64,
    /// A recorded second, and when that was.
    anchor: Option<(f64, Instant)>,
    last: f64,
}

impl Pace {
    fn new(speed: f64) -> Self {
        Self {
            speed,
            anchor: None,
            last: 0.0,
        }
    }

    /// Waits for a recorded second, unless it is asked to end.
    fn wait(&mut self, secs: f64, frame: u32) {
        let gap = secs - std::mem::replace(&mut self.last, secs);
        if self.anchor.is_some() && !(0.0..=MAX_GAP).contains(&gap) {
            out::note(&format!(
                "frame {frame}: the recorded clock jumps by {gap:.3} s; that is not waited for"
            ));
            self.anchor = None;
        }
        let (from, begun) = *self.anchor.get_or_insert((secs, Instant::now()));
        while self.speed > 0.0 && !interrupt::asked() {
            let left = (secs - from) / self.speed - begun.elapsed().as_secs_f64();
            if left <= 0.0 {
                break;
            }
            std::thread::sleep(Duration::from_secs_f64(left.min(LOOK.as_secs_f64())));
        }
    }
}

/// Times as fast as recorded; slower, nobody would see it move.
const SPEEDS: std::ops::RangeInclusive<f64> = 1e-3..=1e3;

/// Reads `--speed`; 0 is as fast as can be.
fn speed(text: &str) -> Result<f64, String> {
    if text == "max" {
        return Ok(0.0);
    }
    let number = text.parse::<f64>().ok();
    let known = number.filter(|speed| *speed == 0.0 || SPEEDS.contains(speed));
    known.ok_or_else(|| {
        format!(
            "expected a number from {} to {} times as recorded, or max for as fast as can be",
            SPEEDS.start(),
            SPEEDS.end()
        )
    })
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    let sensor = match &args.sensor {
        Some(file) => sensor_file::load(file)?,
        None => sensor_source::of_recording(&args.recording)?.0,
    };
    if sensor.converter().bits > 16 {
        return Err(Error::Arguments {
            what: format!(
                "the converter has {} bits, but protocol taxel-1 sends up to 16",
                sensor.converter().bits
            ),
            hint: "a sensor file with bits of at most 16 reads the recording as well, if its counts are that small",
        });
    }
    let bits = packet_bits(&sensor);
    let mut source = open_counts(&args.recording, ReadOptions::of(&sensor))?;
    let mut to = Out::open(&args.to)?;
    interrupt::listen();
    let mut frame = Frame::zeros(sensor.rows(), sensor.columns());
    let mut pace = Pace::new(args.speed);
    let mut sequence = 0u32;
    let mut bytes = Vec::new();
    while !interrupt::asked() && source.next_into(&mut frame)? {
        if frame.values().iter().any(|count| count.fract() != 0.0) {
            return Err(Error::Arguments {
                what: format!("frame {sequence} has counts with fractions"),
                hint: "a device sends whole counts; averaged recordings cannot be replayed this way",
            });
        }
        let secs = frame.time_secs.unwrap_or(f64::from(sequence) / 100.0);
        pace.wait(secs, sequence);
        if interrupt::asked() {
            break;
        }
        bytes.clear();
        let header = Header {
            bits,
            sensor_id: 0,
            sequence,
            time_us: (1e6 * secs).max(0.0) as u64,
        };
        encode(&frame, &header, &mut bytes);
        to.send(&bytes)?;
        for line in to.take_news() {
            out::note(&line);
        }
        sequence = sequence.wrapping_add(1);
    }
    out::note(&format!("{sequence} frames sent"));
    Ok(Exit::Good)
}
