//! How fast files of other programs are read: megabytes a second on one core, a pass alone and with the survey that finds
//! what a count is.
//!
//! `cargo run --release -p taxel-io --example export_speed testdata/exports/fscan.asf …`

use std::path::Path;
use std::time::{Duration, Instant};

use taxel::Frame;
use taxel_io::exports::{ExportReader, about, survey};
use taxel_io::{Error, FrameSource, ReadOptions};

/// Reads all frames of the first sensor; how many.
fn read(path: &Path, shape: (usize, usize), unit: Option<f64>) -> Result<u64, Error> {
    let mut options = ReadOptions::new(shape.0, shape.1);
    options.unit_per_count = unit;
    let mut reader = ExportReader::open(path, options)?.expect("an export");
    let mut frame = Frame::zeros(shape.0, shape.1);
    let mut frames = 0;
    while reader.next_into(&mut frame)? {
        frames += 1;
    }
    Ok(frames)
}

/// Megabytes a second, the best of what fits into two seconds.
fn speed(bytes: u64, mut read: impl FnMut() -> Result<u64, Error>) -> Result<(u64, f64), Error> {
    let (begun, mut best, mut frames) = (Instant::now(), f64::INFINITY, 0);
    while begun.elapsed() < Duration::from_secs(2) {
        let start = Instant::now();
        frames = read()?;
        best = best.min(start.elapsed().as_secs_f64());
    }
    Ok((frames, bytes as f64 / 1e6 / best))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!(
        "| file | MB | frames | MB/s, a pass | MB/s, with the survey |\n|---|---|---|---|---|"
    );
    for path in std::env::args().skip(1) {
        let path = Path::new(&path);
        let about = about(path)?.ok_or("no export")?;
        let pad = &about.pads[0];
        let named = match about.pads.len() {
            1 => path.display().to_string(),
            _ => format!("{}#{}", path.display(), pad.name),
        };
        let (_, found) = survey(Path::new(&named))?.ok_or("no export")?;
        let (shape, unit) = ((pad.rows, pad.columns), found.unit_per_count.or(Some(1.0)));
        let bytes = std::fs::metadata(path)?.len();
        let (frames, pass) = speed(bytes, || read(Path::new(&named), shape, unit))?;
        let (_, whole) = speed(bytes, || read(Path::new(&named), shape, None))?;
        let name = path.file_name().unwrap_or_default().display();
        println!(
            "| {name} | {:.2} | {frames} | {pass:.0} | {whole:.0} |",
            bytes as f64 / 1e6
        );
    }
    Ok(())
}
