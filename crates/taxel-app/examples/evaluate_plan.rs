//! An evaluation without the command: `cargo run -p taxel-app --example evaluate_plan -- plan.toml report.html`.
//!
//! The plan is the one of docs/evaluate.md; examples/evaluate has a whole one with its recordings.

use std::path::PathBuf;

use taxel_app::evaluation::{self, plan::Plan};
use taxel_app::{Reporter, Stage};
use taxel_io::AtomicFile;

/// Progress as lines on standard error.
struct Lines;

impl Reporter for Lines {
    fn warn(&self, text: &str) {
        eprintln!("warning: {text}");
    }

    fn stage(&self, name: &str) -> Box<dyn Stage + '_> {
        eprintln!("{name} …");
        Box::new(taxel_app::Silent)
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut files = std::env::args_os().skip(1).map(PathBuf::from);
    let plan = files.next().ok_or("which plan?")?;
    let found = evaluation::run(&Plan::read(&plan)?, &Lines)?;
    println!("{}", found.report.title);
    for section in &found.report.sections {
        println!("\n{section}");
    }
    if let Some(file) = files.next() {
        AtomicFile::write_whole(&file, found.report.html().as_bytes())?;
    }
    if found.lost > 0 {
        return Err(format!("{} frames were left out", found.lost).into());
    }
    Ok(())
}
