//! `popu-96kg.npz`: snapshots of one person, each with the name of its posture.

use std::error::Error;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use taxel::{Frame, Newtons};
use taxel_io::{FrameSource, NpyOptions, NpyReader};

pub const ROWS: usize = 64;
pub const COLUMNS: usize = 27;

/// Readings of one moment, row by row.
pub type Snapshot = Vec<f64>;

/// The person has not moved between these snapshots.
pub struct Posture {
    /// Family, number and variation: `left1_0`.
    pub name: String,
    pub snapshots: Vec<Snapshot>,
}

impl Posture {
    /// `left1`: its variations are the same pose, slightly shifted.
    pub fn pose(&self) -> &str {
        self.name.split('_').next().unwrap_or_default()
    }

    /// `left`.
    pub fn family(&self) -> &str {
        self.pose().trim_end_matches(|c: char| c.is_ascii_digit())
    }
}

pub struct Recording {
    pub postures: Vec<Posture>,
    /// The mean of the snapshots without anybody.
    pub empty: Snapshot,
    /// Snapshots without a posture: the empty mat, and a person who moves.
    pub others: Vec<Snapshot>,
}

pub fn read(path: &Path) -> Result<Recording, Box<dyn Error>> {
    let mut options = NpyOptions::default();
    options.shape = Some((ROWS, COLUMNS));
    options.array = Some("reading".to_owned());
    // The unit is the vendor's; nothing here depends on it.
    let frames = NpyReader::<Newtons>::open_values(path, options)?.frames();
    let names = names(path)?;
    let mut all: Vec<Posture> = Vec::new();
    for (frame, name) in frames.zip(names) {
        let frame: Frame<Newtons> = frame?;
        let snapshot = frame.values().to_vec();
        match all.iter_mut().find(|posture| posture.name == name) {
            Some(posture) => posture.snapshots.push(snapshot),
            None => all.push(Posture {
                name,
                snapshots: vec![snapshot],
            }),
        }
    }
    let mut take = |family: &str| -> Result<Vec<Snapshot>, String> {
        let found = all.iter().position(|posture| posture.family() == family);
        let index = found.ok_or(format!("{}: no posture {family}", path.display()))?;
        Ok(all.remove(index).snapshots)
    };
    Ok(Recording {
        empty: mean(&take("empty")?),
        others: take("others")?,
        postures: all,
    })
}

fn mean(snapshots: &[Snapshot]) -> Snapshot {
    let of = |taxel| snapshots.iter().map(|one| one[taxel]).sum::<f64>() / snapshots.len() as f64;
    (0..ROWS * COLUMNS).map(of).collect()
}

/// The array `posture`: texts of one length, four bytes a letter, as numpy writes them.
fn names(path: &Path) -> Result<Vec<String>, Box<dyn Error>> {
    let mut bytes = Vec::new();
    let mut archive = zip::ZipArchive::new(File::open(path)?)?;
    archive.by_name("posture.npy")?.read_to_end(&mut bytes)?;
    let wrong = "posture.npy: no array of texts";
    let length = bytes.get(8..10).ok_or(wrong)?;
    let start = 10 + usize::from(u16::from_le_bytes([length[0], length[1]]));
    let header = String::from_utf8_lossy(bytes.get(10..start).ok_or(wrong)?).into_owned();
    let (_, letters) = header.split_once("'<U").ok_or(wrong)?;
    let letters: usize = letters.split('\'').next().ok_or(wrong)?.parse()?;
    let letter = |code: &[u8]| {
        let code = u32::from_le_bytes([code[0], code[1], code[2], code[3]]);
        char::from_u32(code).filter(|&letter| letter != '\0')
    };
    let texts = bytes[start..].chunks_exact(4 * letters.max(1));
    Ok(texts
        .map(|text| text.chunks_exact(4).filter_map(letter).collect())
        .collect())
}
