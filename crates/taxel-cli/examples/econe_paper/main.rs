//! The e-Cone paper's experiments, simulated and evaluated: `cargo run --example econe_paper -- report.html`.
//!
//! A reproduction is a program over the library, no part of it; `taxel evaluate --paper` runs the same.

mod reproduction;

use std::path::PathBuf;

use taxel_app::Reporter;
use taxel_io::AtomicFile;

/// What the program is doing goes to standard error.
struct Told;

impl Reporter for Told {
    fn note(&self, text: &str) {
        eprintln!("{text}");
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let output = std::env::args_os().nth(1).map(PathBuf::from);
    let folder = tempfile::tempdir()?;
    let found = reproduction::run(folder.path(), &Told)?;
    match output {
        Some(file) => AtomicFile::write_whole(&file, found.report.html().as_bytes())?,
        None => found
            .report
            .sections
            .iter()
            .for_each(|section| println!("{section}")),
    }
    Ok(())
}
