//! No file makes a reader panic or take memory without bound, and what it gives is in range.
#![no_main]

use libfuzzer_sys::fuzz_target;
use taxel::{Counts, Frame, Newtons, Sensor};
use taxel_io::{FrameSource, ParquetReader, ReadOptions, open_counts, shape_of};

fuzz_target!(|data: &[u8]| {
    let Some((&choice, bytes)) = data.split_first() else {
        return;
    };
    let extension = ["txt", "csv", "npy", "npz", "mcap", "parquet"][usize::from(choice) % 6];
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run").with_extension(extension);
    std::fs::write(&path, bytes).unwrap();
    let _ = shape_of(&path);
    let mut options = ReadOptions::new(2, 3);
    options.max_count = Some(1023.0);
    options.keep_going = choice >= 128;
    if let Ok(mut source) = open_counts(&path, options) {
        let mut frame = Frame::<Counts>::zeros(2, 3);
        while let Ok(true) = source.next_into(&mut frame) {
            assert!(frame.values().iter().all(|v| (0.0..=1023.0).contains(v)));
        }
    }
    if extension == "parquet"
        && let Ok(mut source) = ParquetReader::<Newtons>::open_loads(&path, options)
    {
        let mut frame = Frame::<Newtons>::zeros(2, 3);
        while let Ok(true) = source.next_into(&mut frame) {
            assert!(frame.values().iter().all(|v| v.is_finite()));
        }
    }
    if let Ok(text) = std::str::from_utf8(bytes) {
        let _ = Sensor::from_toml(text);
    }
});
