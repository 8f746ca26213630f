//! What is kept of a guided calibration: a folder with the frames of every press, and `session.json`, written anew after each, so that
//! a crash loses no press.

use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};
use taxel::calibrate::MadePress;
use taxel::{Counts, Frame, Sensor};
use taxel_io::npy::Element;
use taxel_io::{AtomicFile, FrameSource, NpyWriter, ReadOptions, open_counts};
use taxel_server::AskedPress;

use crate::error::Error;
use crate::fingerprint;
use crate::session::time_stamp;
use crate::text_file;

const FILE: &str = "session.json";
const VERSION: u32 = 1;
/// The longest such file, bytes.
const MAX: u64 = 4 << 20;
/// One that was left longer ago than this is not gone on with by itself, seconds: materials and rooms change.
const RESUMED_WITHIN: u64 = 12 * 3600;

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

fn since_1970(at: SystemTime) -> u64 {
    at.duration_since(UNIX_EPOCH).unwrap_or_default().as_secs()
}

impl CalibrationRecord {
    pub(super) fn new(sensor: &Sensor, source: String, loads_g: &[f64], even_g: &[f64]) -> Self {
        let now = since_1970(SystemTime::now());
        Self {
            version: VERSION,
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

    /// A new folder below `all`.
    pub(super) fn new_folder(all: &Path, at: SystemTime) -> Result<PathBuf, Error> {
        let stamp = time_stamp(at);
        let names = (1..1000).map(|n| match n {
            1 => stamp.clone(),
            n => format!("{stamp}-{n}"),
        });
        let mut folders = names.map(|name| all.join(name));
        let folder = folders.find(|folder| !folder.exists());
        let folder = folder.unwrap_or_else(|| all.join(&stamp));
        std::fs::create_dir_all(&folder).map_err(|source| Error::Folder {
            folder: folder.clone(),
            source,
        })?;
        Ok(folder)
    }

    /// The newest below `all` that is of the same sensor, source and loads, and was left unfinished not long ago.
    pub(super) fn unfinished(&self, all: &Path) -> Option<(PathBuf, Self)> {
        let folders = std::fs::read_dir(all).ok()?;
        let mut folders: Vec<PathBuf> = folders.flatten().map(|entry| entry.path()).collect();
        folders.sort_unstable();
        let read = folders.into_iter().rev();
        let mut read = read.filter_map(|folder| Some((Self::read(&folder).ok()?, folder)));
        let is_same = |other: &Self| {
            other.parts_sha256 == self.parts_sha256
                && other.source == self.source
                && other.loads_g == self.loads_g
                && other.even_g == self.even_g
        };
        let (record, folder) = read.find(|(record, _)| is_same(record))?;
        let left = self.began_secs.saturating_sub(record.written_secs);
        (!record.is_finished && left < RESUMED_WITHIN).then_some((folder, record))
    }

    fn read(folder: &Path) -> Result<Self, Error> {
        let file = folder.join(FILE);
        let text = text_file::read(&file, "a guided calibration", MAX)?;
        let record: Self = serde_json::from_str(&text).map_err(|error| Error::Request {
            what: format!("{}: {error}", file.display()),
            hint: "`taxel calibrate --live` writes it",
        })?;
        if record.version == VERSION {
            return Ok(record);
        }
        Err(Error::Request {
            what: format!(
                "{}: version {}, this program reads {VERSION}",
                file.display(),
                record.version
            ),
            hint: "a newer program wrote it",
        })
    }

    /// Keeps it: whole, or as it was.
    pub(super) fn write(&mut self, folder: &Path) -> Result<(), Error> {
        self.written_secs = since_1970(SystemTime::now());
        let text = serde_json::to_string_pretty(self).expect("plain data is JSON");
        Ok(AtomicFile::write_whole(folder.join(FILE), text.as_bytes())?)
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
