//! What a network is trained with: presses from recordings and from the paper's table, in one list.

use std::path::{Path, PathBuf};

use taxel::calibrate::CalibrationData;
use taxel::screen::{FrameScreen, LineScreen, Surroundings, repair_readings};
use taxel::{Mark, Sensor};
use taxel_learn::{Rows, Source};

use crate::error::Error;
use crate::presses;
use crate::reporter::Reporter;

/// Where presses come from.
#[derive(Debug, Clone)]
pub struct TrainingFiles {
    /// Labelled presses: CSV with recording, frame, row, column (or taxel), load_g
    pub presses: Option<PathBuf>,
    /// Labelled rows, the paper's table: taxel, the values of its row, load; no header
    pub rows: Option<PathBuf>,
    /// The recordings have rows and columns swapped
    pub transpose: bool,
    /// Reject labels above this load, g
    pub max_load_g: f64,
}

/// Presses read and checked.
pub struct TrainingSet {
    /// Those of `--presses`, with their frames.
    pub data: CalibrationData,
    /// All of them: those of `--presses` first, then those of `--rows`.
    pub rows: Rows,
    /// Their files.
    pub sources: Vec<Source>,
}

impl TrainingSet {
    /// Reads everything that was given.
    pub fn read(
        from: &TrainingFiles,
        equilibration: Option<&Path>,
        sensor: &Sensor,
        reporter: &dyn Reporter,
    ) -> Result<Self, Error> {
        let mut training_set = Self {
            data: CalibrationData::default(),
            rows: Rows::new(sensor.columns()),
            sources: Vec::new(),
        };
        if let Some(table) = &from.presses {
            training_set.data =
                presses::read(table, equilibration, from.transpose, sensor, reporter)?;
            let lost = screen(&mut training_set.data, sensor)?;
            if lost > 0 {
                reporter.warn(&format!(
                    "{lost} of {} presses left out: their reading is stuck, a spike, or on a faulty line",
                    lost + training_set.data.presses.len()
                ));
            }
            training_set.rows = rows_of(&training_set.data, sensor.columns());
            training_set.add_source(table, training_set.rows.len())?;
        }
        if let Some(table) = &from.rows {
            let more = Rows::read_csv(table, sensor.columns())?;
            let count = more.len();
            training_set.rows.append(more);
            training_set.add_source(table, count)?;
        }
        let file = from.presses.as_ref().or(from.rows.as_ref());
        training_set
            .rows
            .check(from.max_load_g)
            .map_err(|source| Error::TrainingSet {
                file: file.cloned().unwrap_or_default(),
                source,
            })?;
        Ok(training_set)
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
pub fn screen(data: &mut CalibrationData, sensor: &Sensor) -> Result<usize, Error> {
    let columns = sensor.columns();
    let mut lines = LineScreen::from_sensor(sensor);
    for frame in &data.frames {
        lines.observe(frame)?;
    }
    let faults = lines.finish().with_declared(sensor.screen());
    let mut screen = FrameScreen::from_sensor(sensor);
    screen.set_lines(&faults);
    let mut lost = vec![false; data.presses.len()];
    let mut around = Surroundings::of_sensor(sensor);
    for (at, frame) in data.frames.iter_mut().enumerate() {
        screen.mark(frame)?;
        for (press, lost) in data.presses.iter().zip(&mut lost) {
            if press.frame == at {
                let mark = frame.marks()[press.row * columns + press.column];
                if mark == Mark::Absent {
                    return Err(taxel::Error::PressOnAbsent {
                        row: press.row,
                        column: press.column,
                        frame: press.frame,
                    }
                    .into());
                }
                *lost = mark != Mark::Good;
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
pub fn rows_of(data: &CalibrationData, columns: usize) -> Rows {
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
