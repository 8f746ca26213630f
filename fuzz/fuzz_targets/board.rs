//! No description of a board makes its reader panic.
#![no_main]

use libfuzzer_sys::fuzz_target;
use taxel_acquire::scan::config::Board;

fuzz_target!(|data: &[u8]| {
    if let Ok(text) = std::str::from_utf8(data) {
        let _ = Board::from_toml(text);
    }
});
