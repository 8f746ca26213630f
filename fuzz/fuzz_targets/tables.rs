//! No table of presses, uniform loads, pairs or trials makes its reader panic; no damaged recording makes its recovery.
#![no_main]

use libfuzzer_sys::fuzz_target;
use taxel_io::{read_pairs, read_presses, read_trials, read_uniform_loads, recordings_named_in};

fuzz_target!(|data: &[u8]| {
    let Some((&choice, bytes)) = data.split_first() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("table.csv");
    std::fs::write(&table, bytes).unwrap();
    let labels = (choice >= 128).then_some("ABCD");
    match choice % 5 {
        0 => {
            for press in read_presses(&table, 4, 6, labels).unwrap_or_default() {
                assert!(press.row < 4 && press.column < 6);
            }
            let _ = recordings_named_in(&table);
        }
        1 => drop(read_uniform_loads(&table)),
        2 => drop(read_pairs(&table)),
        3 => drop(read_trials(&table, 4, 6, labels)),
        _ => drop(taxel_io::mcap::recover(
            &table,
            folder.path().join("whole.mcap"),
        )),
    }
});
