//! Nothing that a viewer sends makes the server's reader of requests panic.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    if let Ok(text) = std::str::from_utf8(data) {
        let _ = taxel_server::is_request(text);
    }
});
