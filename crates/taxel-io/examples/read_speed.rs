//! How fast text recordings are read and written: makes about 100 MB of frames as an e-Cone writes them,
//! reads them back and prints megabytes a second.
//!
//! `cargo run --release -p taxel-io --example read_speed [folder]` keeps the recording in `folder`;
//! `… read_speed folder recording.txt` reads this one of 64 x 128 taxels in its place.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use taxel::parallel::Serial;
use taxel::{Counts, Executor, Frame};
use taxel_io::{Error, FrameSource, ReadOptions, TextReader, TextWriter};

const ROWS: usize = 64;
const COLUMNS: usize = 128;
const RUNS: usize = 20;
const BYTES: u64 = 100_000_000;

/// The next of a sequence of 16-bit counts that look random (Knuth's 64-bit generator).
fn next_count(state: &mut u64) -> f64 {
    *state = state
        .wrapping_mul(6_364_136_223_846_793_005)
        .wrapping_add(1_442_695_040_888_963_407);
    (*state >> 48) as f64
}

fn write(path: &Path) -> Result<u64, Error> {
    let mut writer = TextWriter::create(path)?;
    let mut frame = Frame::<Counts>::zeros(ROWS, COLUMNS);
    let mut state = 1;
    // A number and its comma take 5.8 bytes on average.
    while writer.frames() * ((ROWS * COLUMNS) as u64 * 58 / 10) < BYTES {
        let values = frame.values_mut().iter_mut();
        values.for_each(|value| *value = next_count(&mut state));
        writer.write(&frame)?;
    }
    let frames = writer.frames();
    writer.commit()?;
    Ok(frames)
}

fn read(path: &Path) -> Result<(u64, f64), Error> {
    let mut options = ReadOptions::new(ROWS, COLUMNS);
    options.max_count = Some(65535.0);
    let mut reader = TextReader::open(path, options)?;
    let mut frame = Frame::zeros(ROWS, COLUMNS);
    let (mut frames, mut sum) = (0, 0.0);
    while reader.next_into(&mut frame)? {
        frames += 1;
        sum += frame.at(ROWS - 1, COLUMNS - 1);
    }
    Ok((frames, sum))
}

/// As many threads as there are cores.
struct Cores;

impl Executor for Cores {
    fn each(&self, jobs: usize, job: &(dyn Fn(usize) + Sync)) {
        let next = AtomicUsize::new(0);
        let work = || {
            while let i = next.fetch_add(1, Ordering::Relaxed)
                && i < jobs
            {
                job(i);
            }
        };
        let cores = std::thread::available_parallelism().map_or(1, |cores| cores.get());
        std::thread::scope(|scope| {
            (1..cores.min(jobs)).for_each(|_| drop(scope.spawn(work)));
            work();
        });
    }
}

/// As an array of 16 bits a number, as far as it can be.
fn read_counts(path: &Path, executor: &dyn Executor) -> Result<(u64, f64), Error> {
    let mut options = ReadOptions::new(ROWS, COLUMNS);
    options.max_count = Some(65535.0);
    let mut reader = TextReader::open(path, options)?;
    let mut frame = Frame::zeros(ROWS, COLUMNS);
    let mut counts: Vec<u16> = Vec::new();
    loop {
        reader.next_counts(usize::MAX, &mut counts, executor)?;
        if !reader.next_into(&mut frame)? {
            break;
        }
        counts.extend(frame.values().iter().map(|count| *count as u16));
    }
    let frames = counts.len() / (ROWS * COLUMNS);
    Ok((frames as u64, 0.0))
}

/// How many frames are read, and a sum of them.
type Way<'a> = dyn Fn() -> Result<(u64, f64), Error> + 'a;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let kept = std::env::args().nth(1).map(PathBuf::from);
    let temporary = tempfile::tempdir()?;
    let folder = kept.as_deref().unwrap_or(temporary.path());
    let given = std::env::args().nth(2).map(PathBuf::from);
    let is_given = given.is_some();
    let path = given.unwrap_or(folder.join("read_speed.txt"));
    let start = Instant::now();
    let frames = if is_given {
        read(&path)?.0
    } else {
        write(&path)?
    };
    let wrote = start.elapsed().as_secs_f64();
    let megabytes = fs::metadata(&path)?.len() as f64 / 1e6;
    println!("{frames} frames of {ROWS} x {COLUMNS}, {megabytes:.1} MB");
    if !is_given {
        println!("wrote  {:7.1} MB/s", megabytes / wrote);
    }
    let ways: [(&str, &Way); 3] = [
        ("frame by frame", &|| read(&path)),
        ("an array, one core", &|| read_counts(&path, &Serial)),
        ("an array, all cores", &|| read_counts(&path, &Cores)),
    ];
    for (name, way) in ways {
        let mut best = f64::INFINITY;
        for _ in 0..RUNS {
            let start = Instant::now();
            assert_eq!(way()?.0, frames);
            best = best.min(start.elapsed().as_secs_f64());
        }
        println!(
            "{name:20} {:7.1} MB/s, {:7.0} frames/s, {:.2} ms (best of {RUNS}, file in memory)",
            megabytes / best,
            frames as f64 / best,
            1e3 * best
        );
    }
    Ok(())
}
