//! What every protocol must survive.

use std::time::Duration;

use proptest::prelude::*;
use taxel::{Counts, Frame};

use super::taxel1::{Header, encode};
use super::{Decoder, Expected, FrameFault, Protocol};

const EXPECTED: Expected = Expected {
    rows: 3,
    columns: 5,
    max_count: 1023,
    absent: Vec::new(),
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
        "row-text" => (0..3)
            .map(|r| format!("{r}: {}\n", row(r).replace(',', " ")))
            .collect::<String>()
            .into_bytes(),
        "worded" => (0..3)
            .map(|r| format!("Row {r}:\t{}\r\n", row(r).replace(',', "\t")))
            .chain(["\r\n".to_owned()])
            .collect::<String>()
            .into_bytes(),
        "parted" => format!("t = {number}\n{}\n{}\n{}\n", row(0), row(1), row(2)).into_bytes(),
        _ => format!("{}\n{}\n{}\n", row(0), row(1), row(2)).into_bytes(),
    }
}

const KINDS: [(&str, Protocol); 7] = [
    ("taxel-1", Protocol::Taxel1),
    ("lines", Protocol::Lines),
    ("indexed", Protocol::Lines),
    ("econe-text", Protocol::EconeText),
    ("parted", Protocol::EconeText),
    ("row-text", Protocol::RowText),
    ("worded", Protocol::RowText),
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
                assert_eq!(decoder.link_stats().frames, 20);
                assert_eq!(decoder.link_stats().corrupt, 0);
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
        assert_eq!(decoder.link_stats().corrupt, 1, "{kind}");
        assert!(decoder.last_fault().is_some());
        let lost = if kind == "taxel-1" { 1 } else { 0 };
        assert_eq!(decoder.link_stats().lost, lost, "{kind}");
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
    let link_stats = decoder.link_stats();
    assert_eq!(
        (link_stats.lost, link_stats.repeated, link_stats.corrupt),
        (3, 2, 0)
    );
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
            other.clone(),
            "3 x 5 taxels, but the sensor has 3 x 6",
        ),
        (
            "taxel-1",
            Protocol::Taxel1,
            small.clone(),
            "but the converter's largest is 500",
        ),
        (
            "lines",
            Protocol::Lines,
            small.clone(),
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
    assert_eq!(
        decoder.last_fault(),
        Some(&FrameFault::Version { found: 2 })
    );
}

/// What the sketch in examples/firmware sends, as its own encoder wrote it.
#[test]
fn the_sketch_s_packets_are_read() {
    let bytes = include_bytes!("../../testdata/arduino-16x16.bin");
    let expected = Expected {
        rows: 16,
        columns: 16,
        max_count: 1023,
        absent: Vec::new(),
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

/// A zero byte, greetings, or another protocol's noise before a stream decide nothing.
#[test]
fn what_comes_before_the_first_frame_does_not_decide_the_protocol() {
    let frames: Vec<u8> = (0..6).flat_map(|n| bytes_of(n, "econe-text")).collect();
    for before in [&b"\0"[..], b"\0\0\0", b"\0ready\n", b"\xff\0\xfe\n"] {
        for piece in [1, 16, 4096] {
            let mut decoder = Protocol::Auto.decoder(EXPECTED);
            let found = read(&mut *decoder, &[before, &frames].concat(), piece);
            assert!(found.len() >= 5, "{before:?} {piece}: {} of 6", found.len());
            assert_eq!(decoder.name(), "econe-text");
        }
    }
}

/// A device that comes back with another firmware is read again; its frames count on.
#[test]
fn after_a_broken_link_or_nonsense_the_protocol_is_guessed_again() {
    for forget in [true, false] {
        let mut decoder = Protocol::Auto.decoder(EXPECTED);
        let binary: Vec<u8> = (0..4).flat_map(|n| bytes_of(n, "taxel-1")).collect();
        assert_eq!(read(&mut *decoder, &binary, 50).len(), 4);
        if forget {
            decoder.forget();
        }
        let text: Vec<u8> = (0..60).flat_map(|n| bytes_of(n % 6, "lines")).collect();
        let found = read(&mut *decoder, &text, 50);
        assert!(found.len() > 30, "{} of 60", found.len());
        assert!(found[0].sequence >= 4);
        assert!(
            found
                .windows(2)
                .all(|pair| pair[0].sequence < pair[1].sequence)
        );
        assert_eq!(decoder.name(), "lines");
        assert_eq!(decoder.link_stats().frames, 4 + found.len() as u64);
    }
}

/// A packet without an end is counted while it comes.
#[test]
fn a_packet_or_a_line_without_an_end_is_counted_and_takes_no_memory() {
    for (protocol, byte) in [(Protocol::Taxel1, b'7'), (Protocol::Lines, b'7')] {
        let mut decoder = protocol.decoder(EXPECTED);
        read(&mut *decoder, &vec![byte; 100_000], 1000);
        assert_eq!(decoder.link_stats().corrupt, 1, "{protocol:?}");
    }
}

#[test]
fn half_a_frame_at_a_broken_link_is_counted() {
    for (kind, protocol) in KINDS {
        let mut decoder = protocol.decoder(EXPECTED);
        let bytes = [bytes_of(0, kind), bytes_of(1, kind)].concat();
        let half = bytes.len() - bytes_of(1, kind).len() / 3;
        let found = read(&mut *decoder, &bytes[..half], 8);
        assert_eq!(
            (found.len(), decoder.link_stats().corrupt),
            (1, 0),
            "{kind}"
        );
        decoder.forget();
        assert_eq!(decoder.link_stats().corrupt, 1, "{kind}");
        // Again, with nothing begun: nothing broken.
        decoder.forget();
        assert_eq!(decoder.link_stats().corrupt, 1, "{kind}");
    }
}

/// A line whose first byte is damaged is one that was lost, and leaves a gap.
#[test]
fn a_damaged_first_byte_is_no_comment() {
    for (kind, protocol) in [
        ("lines", Protocol::Lines),
        ("econe-text", Protocol::EconeText),
    ] {
        let mut decoder = protocol.decoder(EXPECTED);
        let mut frames: Vec<Vec<u8>> = (0..5).map(|n| bytes_of(n, kind)).collect();
        frames[2][0] = b'~';
        let found = read(&mut *decoder, &frames.concat(), 9);
        let values: Vec<_> = found.iter().map(|f| f.values().to_vec()).collect();
        let whole = [0, 1, 3, 4].map(|n| frame(n).values().to_vec());
        assert_eq!(values, whole, "{kind}");
        assert_eq!(decoder.link_stats().corrupt, 1, "{kind}");
        let sequences: Vec<u64> = found.iter().map(|f| f.sequence).collect();
        assert_eq!(sequences, [0, 1, 3, 4], "{kind}");
    }
    let mut decoder = Protocol::Lines.decoder(EXPECTED);
    read(&mut *decoder, b"# ready\nhello 3\nboot: 12\n", 9);
    assert_eq!(
        (
            decoder.link_stats().passed_over,
            decoder.link_stats().corrupt
        ),
        (3, 0)
    );
}

/// Frames of two datagrams each, some lost: none is made of two.
#[test]
fn lost_datagrams_never_glue_two_frames() {
    for (kind, protocol) in [
        ("indexed", Protocol::Lines),
        ("econe-text", Protocol::EconeText),
        ("parted", Protocol::EconeText),
        ("econe-text", Protocol::Auto),
        ("row-text", Protocol::RowText),
    ] {
        let mut decoder = protocol.decoder(EXPECTED);
        let mut found = Vec::new();
        let mut lost = 0;
        let mut since = 0;
        for number in 0..200u64 {
            let bytes = bytes_of(number, kind);
            // The first row in one datagram, the others in the next, a millisecond later; ten to the next frame.
            let rows: Vec<usize> = (0..bytes.len()).filter(|&i| bytes[i] == b'\n').collect();
            let cut = rows[rows.len() - 3] + 1;
            for (part, after) in [(&bytes[..cut], 9), (&bytes[cut..], 1)] {
                since += after;
                let datagram = 2 * number + u64::from(after == 1);
                // The end of a frame and the beginning of the next; now and then one alone.
                if number > 10 && (datagram % 20 == 1 || datagram % 20 == 2 || datagram % 33 == 0) {
                    lost += 1;
                    continue;
                }
                decoder.datagram(Duration::from_millis(since));
                since = 0;
                decoder.feed(part, &mut |frame| found.push(frame.values().to_vec()));
            }
        }
        assert!(lost > 20);
        let real: Vec<Vec<f64>> = (0..200).map(|n| frame(n).values().to_vec()).collect();
        let glued = found.iter().filter(|found| !real.contains(found)).count();
        assert_eq!(glued, 0, "{kind} {protocol:?}");
        assert!(found.len() > 140, "{kind} {protocol:?}: {}", found.len());
    }
}

#[test]
fn frames_of_another_sensor_are_counted_not_taken() {
    let packet = |sensor_id, sequence| {
        let header = Header {
            bits: 16,
            sensor_id,
            sequence,
            time_us: 0,
        };
        let mut bytes = Vec::new();
        encode(&frame(u64::from(sequence)), &header, &mut bytes);
        bytes
    };
    let mut decoder = Protocol::Taxel1.decoder(EXPECTED);
    let bytes: Vec<u8> = (0..5)
        .flat_map(|n| [packet(1, n), packet(2, n)].concat())
        .collect();
    assert_eq!(read(&mut *decoder, &bytes, 40).len(), 5);
    let link_stats = decoder.link_stats();
    assert_eq!(
        (
            link_stats.strangers,
            link_stats.corrupt,
            link_stats.repeated,
            link_stats.lost
        ),
        (5, 0, 0, 0)
    );
    // After a silence it may be another.
    decoder.forget();
    assert_eq!(read(&mut *decoder, &packet(2, 5), 40).len(), 1);
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
    fn no_lines_break_a_decoder(text in "[0-9,; \n:Rrow-]{0,400}", piece in 1usize..80) {
        for protocol in [Protocol::Lines, Protocol::EconeText, Protocol::RowText, Protocol::Auto] {
            read(&mut *protocol.decoder(EXPECTED), text.as_bytes(), piece);
        }
    }
}
