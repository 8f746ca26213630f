//! What is kept of a guided calibration: a folder with the frames of every press, and `session.json`, written anew after each, so that
//! a crash loses no press.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use serde::{Deserialize, Serialize};
use taxel::calibrate::MadePress;
use taxel::{Counts, Frame, Sensor};
use taxel_io::npy::Element;
use taxel_io::{FrameSource, NpyWriter, ReadOptions, open_counts};
use taxel_server::AskedPress;

use crate::error::Error;
use crate::fingerprint;
use crate::session_folder::{SessionRecord, is_recent, since_1970};

/// A guided calibration, as far as it has come.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct CalibrationRecord {
    version: u32,
    pub program: String,
    /// Name of the sensor, and SHA-256 of its parts list.
    pub sensor: String,
    pub parts_sha256: String,
    /// Where frames came from.
    pub source: String,
    pub is_simulated: bool,
    /// The loads that there are, grams: of single presses, and on each taxel where all are loaded.
    pub loads_g: Vec<f64>,
    pub even_g: Vec<f64>,
    pub began_secs: u64,
    pub written_secs: u64,
    /// Every press that was taken, in order.
    pub presses: Vec<KeptPress>,
    pub is_finished: bool,
}

/// A press that was taken.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct KeptPress {
    /// Row and column, from 0; `None` of a load on all taxels.
    pub taxel: Option<(usize, usize)>,
    /// Grams: on that taxel, or on each.
    pub load_g: f64,
    /// Other things lay on the sensor.
    pub is_among_others: bool,
    /// The mean of its frames, in the session's folder; its frames themselves are beside it, as .mcap.
    pub file: String,
    /// How much its reading rose, siemens as if it were alone.
    pub rise_siemens: f64,
    /// It was asked for again: the others contradicted the first.
    pub is_again: bool,
    /// Why it does not count; empty where it does.
    pub left_out: String,
}

impl KeptPress {
    /// What was asked for, where it stood.
    pub(super) fn asked(&self) -> AskedPress {
        let mut asked = match self.taxel {
            Some((row, column)) => AskedPress::of_taxel(row, column, self.load_g),
            None => AskedPress::of_all(self.load_g),
        };
        asked.is_among_others = self.is_among_others;
        asked.is_again = self.is_again;
        asked
    }

    pub(super) fn counts(&self) -> bool {
        self.left_out.is_empty()
    }

    /// As a press of one taxel.
    pub(super) fn made(&self) -> Option<MadePress> {
        let (row, column) = self.taxel?;
        Some(MadePress {
            row,
            column,
            load_g: self.load_g,
            is_among_others: self.is_among_others,
        })
    }
}

impl SessionRecord for CalibrationRecord {
    const OF: &str = "a guided calibration";
    const VERSION: u32 = 1;
    const HINT: &'static str = "`taxel calibrate --live` writes it";

    fn version(&self) -> u32 {
        self.version
    }

    fn written_secs(&mut self) -> &mut u64 {
        &mut self.written_secs
    }
}

impl CalibrationRecord {
    pub(super) fn new(sensor: &Sensor, source: String, loads_g: &[f64], even_g: &[f64]) -> Self {
        let now = since_1970(SystemTime::now());
        Self {
            version: Self::VERSION,
            program: format!("taxel {}", env!("CARGO_PKG_VERSION")),
            sensor: sensor.name().to_owned(),
            parts_sha256: fingerprint::of_text(&sensor.to_toml()),
            is_simulated: source.starts_with("sim:"),
            source,
            loads_g: loads_g.to_vec(),
            even_g: even_g.to_vec(),
            began_secs: now,
            written_secs: now,
            presses: Vec::new(),
            is_finished: false,
        }
    }

    /// The newest below `all` that is of the same sensor, source and loads, and was left unfinished not long ago.
    pub(super) fn unfinished(&self, all: &Path) -> Option<(PathBuf, Self)> {
        let is_same = |other: &Self| {
            other.parts_sha256 == self.parts_sha256
                && other.source == self.source
                && other.loads_g == self.loads_g
                && other.even_g == self.even_g
        };
        let mut kept = Self::newest_first(all);
        let (folder, record) = kept.find(|(_, record)| is_same(record))?;
        let is_recent = is_recent(record.written_secs, self.began_secs);
        (!record.is_finished && is_recent).then_some((folder, record))
    }

    /// A name that no press in the folder has, without its ending.
    pub(super) fn free_name(folder: &Path) -> String {
        let names = (1..).map(|n| format!("press-{n:03}"));
        let is_free = |name: &String| {
            ["npy", "mcap"]
                .iter()
                .all(|ending| !folder.join(format!("{name}.{ending}")).exists())
        };
        names.into_iter().find(is_free).expect("numbers do not end")
    }
}

/// Keeps the mean of a press's frames.
pub(super) fn write_mean(file: &Path, frame: &Frame<Counts>) -> Result<(), Error> {
    let mut writer = NpyWriter::create(file, frame.rows(), frame.columns(), Element::F8)?;
    writer.write(frame)?;
    Ok(writer.commit()?)
}

/// Reads it again.
pub(super) fn read_mean(file: &Path, sensor: &Sensor) -> Result<Frame<Counts>, Error> {
    let mut source = open_counts(file, ReadOptions::of(sensor))?;
    let mut frame = Frame::zeros(sensor.rows(), sensor.columns());
    if source.next_into(&mut frame)? {
        return Ok(frame);
    }
    Err(Error::Request {
        what: format!("{} has no frame", file.display()),
        hint: "the press is lost: take its line out of session.json",
    })
}
