//! What every protocol must survive.

use proptest::prelude::*;
use taxel::{Counts, Frame};

use super::taxel1::{Header, encode};
use super::{Decoder, Expected, Fault, Protocol};

const EXPECTED: Expected = Expected {
    rows: 3,
    columns: 5,
    max_count: 1023,
};

fn frame(number: u64) -> Frame<Counts> {
    let values = (0..15).map(|i| ((37 * i + 101 * number) % 1024) as f64);
    Frame::new(3, 5, values.collect()).unwrap()
}

/// The bytes of a frame in each protocol, and the name that `auto` must find.
fn bytes_of(number: u64, protocol: &str) -> Vec<u8> {
    let frame = frame(number);
    let row = |row: usize| -> String {
        let numbers = frame.values()[5 * row..5 * row + 5].iter();
        numbers.map(|v| format!("{v},")).collect()
    };
    match protocol {
        "taxel-1" => {
            let mut bytes = Vec::new();
            let header = Header {
                bits: [10, 12, 16][number as usize % 3],
                sensor_id: 7,
                sequence: number as u32,
                time_us: 10_000 * number,
            };
            encode(&frame, &header, &mut bytes);
            bytes
        }
        "lines" => format!("{}{}{}\n", row(0), row(1), row(2)).into_bytes(),
        "indexed" => (0..3)
            .map(|r| format!("{r}, {}\r\n", row(r).trim_end_matches(',')))
            .collect::<String>()
            .into_bytes(),
        "parted" => format!("t = {number}\n{}\n{}\n{}\n", row(0), row(1), row(2)).into_bytes(),
        _ => format!("{}\n{}\n{}\n", row(0), row(1), row(2)).into_bytes(),
    }
}

const KINDS: [(&str, Protocol); 5] = [
    ("taxel-1", Protocol::Taxel1),
    ("lines", Protocol::Lines),
    ("indexed", Protocol::Lines),
    ("econe-text", Protocol::EconeText),
    ("parted", Protocol::EconeText),
];

fn read(decoder: &mut dyn Decoder, bytes: &[u8], piece: usize) -> Vec<Frame<Counts>> {
    let mut found = Vec::new();
    for piece in bytes.chunks(piece) {
        decoder.feed(piece, &mut |frame| found.push(frame.clone()));
    }
    found
}

#[test]
fn every_protocol_gives_the_frames_back_in_pieces_of_any_size() {
    for (kind, protocol) in KINDS {
        let bytes: Vec<u8> = (0..20).flat_map(|n| bytes_of(n, kind)).collect();
        for piece in [1, 7, 64, 100_000] {
            for protocol in [protocol, Protocol::Auto] {
                let mut decoder = protocol.decoder(EXPECTED);
                let found = read(&mut *decoder, &bytes, piece);
                // What tells a protocol may come after its first line.
                assert_eq!(found.len(), 20, "{kind} {piece} {protocol:?}");
                for (n, found) in found.iter().enumerate() {
                    assert_eq!(found.values(), frame(n as u64).values(), "{kind} {piece}");
                    assert_eq!(found.sequence, n as u64);
                }
                assert_eq!(decoder.tally().frames, 20);
                assert_eq!(decoder.tally().corrupt, 0);
                if kind == "taxel-1" {
                    assert_eq!(found[3].time_secs, Some(0.03));
                }
            }
        }
    }
}

#[test]
fn counts_of_every_width_come_back() {
    for bits in [8, 10, 12, 16] {
        let most = (1u64 << bits) - 1;
        let expected = Expected {
            max_count: most,
            ..EXPECTED
        };
        let values = (0..15).map(|i| ((i * 9973) % (most + 1)) as f64).collect();
        let mut frame = Frame::<Counts>::new(3, 5, values).unwrap();
        frame.values_mut()[4] = most as f64;
        let header = Header {
            bits: bits as u8,
            sensor_id: 1,
            sequence: 1,
            time_us: u64::MAX,
        };
        let mut bytes = Vec::new();
        encode(&frame, &header, &mut bytes);
        assert!(bytes[1..bytes.len() - 1].iter().all(|byte| *byte != 0));
        let found = read(&mut *Protocol::Taxel1.decoder(expected), &bytes, 11);
        assert_eq!(found[0].values(), frame.values());
    }
}

/// Noise in the middle costs the frame it hits and no more.
#[test]
fn after_noise_the_next_frame_is_whole() {
    for (kind, protocol) in KINDS {
        let mut frames: Vec<Vec<u8>> = (0..6).map(|n| bytes_of(n, kind)).collect();
        let at = frames[2].len() / 2;
        frames[2][at] = b'x';
        frames[2][at + 1] ^= 0x55;
        let mut decoder = protocol.decoder(EXPECTED);
        let found = read(&mut *decoder, &frames.concat(), 9);
        let numbers: Vec<u64> = (0..6)
            .filter(|n| found.iter().any(|f| f.values() == frame(*n).values()))
            .collect();
        assert_eq!(numbers, [0, 1, 3, 4, 5], "{kind}");
        assert_eq!(decoder.tally().corrupt, 1, "{kind}");
        assert!(decoder.last_fault().is_some());
        let lost = if kind == "taxel-1" { 1 } else { 0 };
        assert_eq!(decoder.tally().lost, lost, "{kind}");
    }
}

#[test]
fn a_broken_link_forgets_the_half_that_came() {
    for (kind, protocol) in KINDS {
        let mut decoder = protocol.decoder(EXPECTED);
        let first = bytes_of(1, kind);
        read(&mut *decoder, &first[..2 * first.len() / 3], 8);
        decoder.forget();
        let found = read(&mut *decoder, &bytes_of(2, kind), 8);
        assert_eq!(found.len(), 1, "{kind}");
        assert_eq!(found[0].values(), frame(2).values(), "{kind}");
    }
}

#[test]
fn lost_and_repeated_frames_are_counted() {
    let mut decoder = Protocol::Taxel1.decoder(EXPECTED);
    let bytes: Vec<u8> = [0, 1, 1, 5, 4, 6]
        .into_iter()
        .flat_map(|n| bytes_of(n, "taxel-1"))
        .collect();
    let found = read(&mut *decoder, &bytes, 50);
    let numbers: Vec<u64> = found.iter().map(|f| f.sequence).collect();
    assert_eq!(numbers, [0, 1, 5, 6]);
    let tally = decoder.tally();
    assert_eq!((tally.lost, tally.repeated, tally.corrupt), (3, 2, 0));
}

#[test]
fn what_is_wrong_is_said_with_both_numbers() {
    let other = Expected {
        columns: 6,
        ..EXPECTED
    };
    let small = Expected {
        max_count: 500,
        ..EXPECTED
    };
    let cases = [
        (
            "taxel-1",
            Protocol::Taxel1,
            other,
            "3 x 5 taxels, but the sensor has 3 x 6",
        ),
        (
            "taxel-1",
            Protocol::Taxel1,
            small,
            "but the converter's largest is 500",
        ),
        (
            "lines",
            Protocol::Lines,
            small,
            "but the converter's largest is 500",
        ),
        (
            "lines",
            Protocol::Lines,
            other,
            "a line of 15 numbers, but a row has 6",
        ),
        (
            "econe-text",
            Protocol::EconeText,
            small,
            "but the converter's largest is 500",
        ),
    ];
    for (kind, protocol, expected, says) in cases {
        let mut decoder = protocol.decoder(expected);
        let bytes: Vec<u8> = (0..4).flat_map(|n| bytes_of(n, kind)).collect();
        read(&mut *decoder, &bytes, 1000);
        let fault = decoder.last_fault().expect(kind).to_string();
        assert!(fault.contains(says), "{kind}: {fault}");
    }
    let mut bytes = Vec::new();
    let mut packet = vec![2u8; 24];
    packet.extend(crc32fast::hash(&packet).to_le_bytes());
    bytes.extend(cobs::encode_vec(&packet));
    bytes.push(0);
    let mut decoder = Protocol::Taxel1.decoder(EXPECTED);
    read(&mut *decoder, &bytes, 100);
    assert_eq!(decoder.last_fault(), Some(&Fault::Version { found: 2 }));
}

/// What the sketch in examples/firmware sends, as its own encoder wrote it.
#[test]
fn the_sketch_s_packets_are_read() {
    let bytes = include_bytes!("../../../../testdata/taxel-1/arduino-16x16.bin");
    let expected = Expected {
        rows: 16,
        columns: 16,
        max_count: 1023,
    };
    let mut decoder = Protocol::Taxel1.decoder(expected);
    let found = read(&mut *decoder, bytes, 31);
    assert_eq!(found.len(), 3);
    for (number, found) in found.iter().enumerate() {
        let values = (0..256).map(|i| ((37 * i + 101 * number) % 1024) as f64);
        assert_eq!(found.values(), values.collect::<Vec<f64>>());
        assert_eq!(found.time_secs, Some(0.01 * number as f64));
    }
    // And ours, of the same frames, byte by byte.
    let mut ours = Vec::new();
    for (number, frame) in found.iter().enumerate() {
        let header = Header {
            bits: 10,
            sensor_id: 7,
            sequence: number as u32,
            time_us: 10_000 * number as u64,
        };
        encode(frame, &header, &mut ours);
    }
    assert_eq!(ours, bytes);
}

proptest! {
    /// Any bytes at all: nothing panics, and a good frame after them is found once a delimiter has come.
    #[test]
    fn no_bytes_break_a_decoder(
        noise in proptest::collection::vec(any::<u8>(), 0..600),
        piece in 1usize..80,
    ) {
        for (kind, protocol) in KINDS {
            let mut decoder = protocol.decoder(EXPECTED);
            read(&mut *decoder, &noise, piece);
            decoder.forget();
            let bytes: Vec<u8> = (0..3).flat_map(|n| bytes_of(n, kind)).collect();
            let found = read(&mut *decoder, &bytes, piece);
            prop_assert!(found.iter().any(|f| f.values() == frame(2).values()), "{}", kind);
        }
    }

    /// Digits and separators in any order get further into the text protocols.
    #[test]
    fn no_lines_break_a_decoder(text in "[0-9,; \n-]{0,400}", piece in 1usize..80) {
        for protocol in [Protocol::Lines, Protocol::EconeText, Protocol::Auto] {
            read(&mut *protocol.decoder(EXPECTED), text.as_bytes(), piece);
        }
    }
}
