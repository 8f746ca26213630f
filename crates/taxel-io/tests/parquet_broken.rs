//! Parquet that is cut, or has bits the other way round: an error or a frame, never a panic, and bounded memory. Alone in its
//! program, whose memory it looks at.
#![cfg(feature = "parquet")]

use std::fs;
use std::time::SystemTime;

use taxel::{Counts, Frame, Newtons};
use taxel_io::{FrameSource, ParquetReader, ParquetWriter, ReadOptions, sensor_toml_of, shape_of};

/// What a command may take, as the whole program's tests have it.
const MAX_MEMORY_KIB: u64 = 256 << 10;

fn written() -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.parquet");
    let sensor = taxel::sensor::preset("mat-16x16-cd4067").unwrap();
    let mut writer = ParquetWriter::create_with_loads(&path, &sensor, true).unwrap();
    for place in 0..30 {
        let values =
            |step: f64| (0..256).map(move |taxel| (f64::from(taxel * place) * step).floor());
        let counts = Frame::<Counts>::new(16, 16, values(3.0).collect()).unwrap();
        let loads = Frame::<Newtons>::new(16, 16, values(0.1).collect()).unwrap();
        writer
            .write_loads(Some(&counts), &loads, SystemTime::UNIX_EPOCH)
            .unwrap();
    }
    writer.commit().unwrap();
    fs::read(&path).unwrap()
}

/// Reads all there is; gives the number of frames of counts.
fn read(path: &std::path::Path) -> usize {
    let mut options = ReadOptions::new(16, 16);
    options.keep_going = true;
    let _ = (shape_of(path), sensor_toml_of(path));
    if let Ok(source) = ParquetReader::<Newtons>::open_loads(path, options) {
        assert!(source.frames().take_while(Result::is_ok).count() < 1000);
    }
    let Ok(source) = ParquetReader::open_counts(path, options) else {
        return 0;
    };
    source.frames().take_while(Result::is_ok).count()
}

/// The same numbers everywhere.
struct Draws(u64);

impl Draws {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (self.0 >> 33) as usize % end
    }
}

#[test]
fn broken_files_are_errors_and_take_no_memory() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("broken.parquet");
    let whole = written();
    fs::write(&path, &whole).unwrap();
    assert_eq!(read(&path), 30);
    let mut draws = Draws(7);
    // The end says where all else is: broken more often than its length would have it.
    let footer = whole.len()
        - 8
        - u32::from_le_bytes(whole[whole.len() - 8..][..4].try_into().unwrap()) as usize;
    for turn in 0..3000 {
        let mut bytes = whole.clone();
        match turn % 4 {
            0 => bytes.truncate(draws.below(whole.len())),
            1 => {
                let at = footer + draws.below(whole.len() - footer);
                bytes[at] ^= 1 << draws.below(8);
            }
            2 => {
                let at = footer + draws.below(whole.len() - footer);
                bytes[at] = draws.below(256) as u8;
            }
            _ => {
                for _ in 0..1 + draws.below(4) {
                    let at = draws.below(whole.len());
                    bytes[at] ^= 1 << draws.below(8);
                }
            }
        }
        fs::write(&path, &bytes).unwrap();
        assert!(read(&path) <= 30, "turn {turn}");
    }
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    if let Some(peak) = peak {
        let peak: u64 = peak.trim().trim_end_matches(" kB").parse().unwrap();
        assert!(peak < MAX_MEMORY_KIB, "{peak} KiB");
    }
}
