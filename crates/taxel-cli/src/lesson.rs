//! What a network is trained with: presses from recordings and from the paper's table, in one list.

use std::path::{Path, PathBuf};

use taxel::calibrate::Data;
use taxel::screen::{FrameScreen, LineScreen, ScreenOptions, repair_readings};
use taxel::{Mark, Sensor};
use taxel_learn::{Rows, Source};

use crate::error::Error;
use crate::{out, presses};

/// Where presses come from.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct Sources {
    /// Labelled presses: CSV with recording, frame, row, column (or taxel), load_g
    #[arg(long, value_name = "FILE", required_unless_present = "rows")]
    pub(crate) presses: Option<PathBuf>,
    /// Labelled rows, the paper's table: taxel, the values of its row, load; no header
    #[arg(long, value_name = "FILE")]
    pub(crate) rows: Option<PathBuf>,
    /// The recordings have rows and columns swapped
    #[arg(long)]
    pub(crate) transpose: bool,
    /// Reject labels above this load, g
    #[arg(long, value_name = "GRAMS", default_value_t = 10_000.0)]
    pub(crate) most_load: f64,
}

/// Presses read and checked.
pub(crate) struct Lessons {
    /// Those of `--presses`, with their frames.
    pub(crate) data: Data,
    /// All of them: those of `--presses` first, then those of `--rows`.
    pub(crate) rows: Rows,
    /// Their files.
    pub(crate) sources: Vec<Source>,
}

impl Lessons {
    /// Reads everything that was given.
    pub(crate) fn read(
        from: &Sources,
        equilibration: Option<&Path>,
        sensor: &Sensor,
    ) -> Result<Self, Error> {
        let mut lessons = Self {
            data: Data::default(),
            rows: Rows::new(sensor.columns()),
            sources: Vec::new(),
        };
        if let Some(table) = &from.presses {
            lessons.data = presses::read(table, equilibration, from.transpose, sensor)?;
            let lost = screen(&mut lessons.data, sensor)?;
            if lost > 0 {
                out::warn(&format!(
                    "{lost} of {} presses left out: their reading is stuck, a spike, or on a faulty line",
                    lost + lessons.data.presses.len()
                ));
            }
            lessons.rows = rows_of(&lessons.data, sensor.columns());
            lessons.add_source(table, lessons.rows.len())?;
        }
        if let Some(table) = &from.rows {
            let more = Rows::read_csv(table, sensor.columns())?;
            let count = more.len();
            lessons.rows.append(more);
            lessons.add_source(table, count)?;
        }
        let file = from.presses.as_ref().or(from.rows.as_ref());
        lessons
            .rows
            .check(from.most_load)
            .map_err(|source| Error::Lesson {
                file: file.cloned().unwrap_or_default(),
                source,
            })?;
        Ok(lessons)
    }

    fn add_source(&mut self, file: &Path, presses: usize) -> Result<(), Error> {
        let bytes = std::fs::read(file).map_err(|source| taxel_learn::Error::File {
            file: file.to_owned(),
            source,
        })?;
        self.sources.push(Source {
            name: file.display().to_string(),
            fingerprint: Source::fingerprint(&bytes),
            presses,
        });
        Ok(())
    }
}

/// Screens the frames of presses in place (stuck readings and spikes get the median around them) and leaves out the
/// presses whose own reading is lost; says how many.
pub(crate) fn screen(data: &mut Data, sensor: &Sensor) -> Result<usize, Error> {
    let options = ScreenOptions::from_sensor(sensor);
    let (rows, columns) = (sensor.rows(), sensor.columns());
    let mut lines = LineScreen::new(rows, columns, sensor.max_count(), &options);
    for frame in &data.frames {
        lines.observe(frame)?;
    }
    let faults = lines.finish().with_declared(sensor.screen());
    let mut screen = FrameScreen::new(rows, columns, sensor.max_count(), &options);
    screen.set_lines(&faults);
    let mut lost = vec![false; data.presses.len()];
    let mut around = Vec::new();
    for (at, frame) in data.frames.iter_mut().enumerate() {
        screen.mark(frame)?;
        for (press, lost) in data.presses.iter().zip(&mut lost) {
            if press.frame == at {
                *lost = frame.marks()[press.row * columns + press.column] != Mark::Good;
            }
        }
        repair_readings(frame, &mut around);
    }
    let before = data.presses.len();
    let mut lost = lost.into_iter();
    data.presses.retain(|_| lost.next() != Some(true));
    Ok(before - data.presses.len())
}

/// The row of every press, as the paper's table has it.
pub(crate) fn rows_of(data: &Data, columns: usize) -> Rows {
    let mut rows = Rows::new(columns);
    for press in &data.presses {
        let frame = &data.frames[press.frame];
        rows.push(
            frame.at(press.row, press.column),
            (0..columns).map(|column| frame.at(press.row, column)),
            press.load_g,
        );
    }
    rows
}
