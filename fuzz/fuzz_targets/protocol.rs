//! No bytes from a device make a decoder panic, hand on a frame of another shape, or count wrongly.
#![no_main]

use libfuzzer_sys::fuzz_target;
use taxel_acquire::protocol::{Expected, Protocol};

fuzz_target!(|data: &[u8]| {
    // The first byte chooses the protocol and the size of the pieces in which the others come.
    let Some((&choice, bytes)) = data.split_first() else {
        return;
    };
    let (_, protocol) = Protocol::NAMES[usize::from(choice) % Protocol::NAMES.len()];
    let expected = Expected {
        rows: 3,
        columns: 5,
        // FlexiTac's counts have 8 bits.
        max_count: if protocol == Protocol::FlexiTac {
            255
        } else {
            1023
        },
        absent: Vec::new(),
    };
    let mut decoder = protocol.decoder(expected);
    let mut frames = 0;
    for piece in bytes.chunks(1 + usize::from(choice) / Protocol::NAMES.len()) {
        decoder.feed(piece, &mut |frame| {
            assert_eq!((frame.rows(), frame.columns()), (3, 5));
            assert!(frame.values().iter().all(|v| (0.0..=1023.0).contains(v)));
            frames += 1;
        });
    }
    assert_eq!(decoder.link_stats().frames, frames);
});
