//! FlexiTac's frames: a marker, then a byte a taxel.
//!
//! | at | bytes | what |
//! |---|---|---|
//! | 0 | 2 | 0xAA 0x55 |
//! | 2 | R·C | counts of 8 bits, row by row |
//!
//! The next frame follows at once. Nothing is escaped: two counts beside each other can look like a marker. A frame
//! therefore begins where a marker has two more behind it, exactly a frame apart, and is handed on when they have come:
//! one alone may be counts that added bytes have moved there. The first after a gap only tells where frames begin, for the
//! same reason. Where counts inside look like a marker as well, one more is waited for, since the real one comes again.
//!
//! What cannot be told, for want of a checksum and of a number: bytes that were changed, as many bytes added as lost in
//! one frame, a gap of exactly a frame's length, counts that look like the marker twice just where a gap makes it due,
//! and how many frames went by in a gap.

use taxel::{Counts, Frame};

use super::{Decoder, Expected, FrameFault, LinkStats};

const MARKER: [u8; 2] = [0xAA, 0x55];
/// The largest count, whatever the converter has: its lowest bits are not sent.
const LARGEST: u64 = 255;
/// Frames behind a marker that are waited for: always, and where counts look like one.
const MIN_AHEAD: usize = 2;
const MAX_AHEAD: usize = 3;

/// What is known of a place where a frame may begin.
#[derive(Debug, PartialEq, Eq)]
enum Verdict {
    /// One begins there.
    Frame,
    /// None begins there, or it is not whole.
    Nothing,
    /// Counts elsewhere come again as a marker does.
    Unclear,
    /// What tells has not come yet.
    Open,
}

/// Reads FlexiTac's frames.
pub struct FlexiTac {
    expected: Expected,
    frame: Frame<Counts>,
    /// What has come and is not decided.
    held: Vec<u8>,
    /// A frame ended where what is held begins.
    locked: bool,
    /// Bytes passed over since then, and since the last marker that began none.
    skipped: usize,
    apart: Option<usize>,
    link_stats: LinkStats,
    fault: Option<FrameFault>,
}

impl FlexiTac {
    /// For frames of one sensor.
    pub fn new(expected: Expected) -> Self {
        let length = MARKER.len() + expected.taxels();
        Self {
            frame: expected.frame(),
            held: Vec::with_capacity(MAX_AHEAD * length + MARKER.len()),
            expected,
            locked: false,
            skipped: 0,
            apart: None,
            link_stats: LinkStats::default(),
            fault: None,
        }
    }

    /// From one marker to the next, bytes.
    fn length(&self) -> usize {
        MARKER.len() + self.expected.taxels()
    }

    /// Whether a marker stands there; `None` if that has not come yet.
    fn mark(&self, at: usize) -> Option<bool> {
        let there = self.held.get(at..at + MARKER.len())?;
        Some(there == MARKER)
    }

    /// Whether a frame begins at a marker.
    fn judge(&self, from: usize) -> Verdict {
        let length = self.length();
        for ahead in 1..=MAX_AHEAD {
            match self.mark(from + ahead * length) {
                None => return Verdict::Open,
                Some(false) => return Verdict::Nothing,
                Some(true) => {}
            }
            if ahead < MIN_AHEAD {
                continue;
            }
            // Another marker inside that comes again as long: it has to have ended before this one's last.
            let comes_again =
                |at: &usize| (0..ahead).all(|n| self.mark(at + n * length) == Some(true));
            if !(from + 1..from + length).any(|at| comes_again(&at)) {
                return Verdict::Frame;
            }
        }
        // Counts stand still and look like a marker: whoever knew the beginning still does.
        if self.locked {
            Verdict::Frame
        } else {
            Verdict::Unclear
        }
    }

    /// Decides what can be decided.
    fn settle(&mut self, take: &mut dyn FnMut(&Frame<Counts>)) {
        let mut from = 0;
        loop {
            let next = self.next_marker(from);
            self.skip(next - from);
            from = next;
            if from + MARKER.len() > self.held.len() {
                break;
            }
            let length = self.length();
            let apart = self.apart.take();
            if let Some(found) = apart.filter(|found| *found != length) {
                self.fault = Some(FrameFault::Length {
                    found,
                    expected: length,
                    taxels: self.expected.taxels(),
                });
            }
            match self.judge(from) {
                Verdict::Open => break,
                Verdict::Frame => {
                    if self.locked {
                        self.hand_on(from + MARKER.len(), take);
                    } else {
                        // At the very beginning nothing was broken.
                        self.link_stats.corrupt += u64::from(self.link_stats.frames > 0);
                    }
                    self.locked = true;
                    self.skipped = 0;
                    from += length;
                }
                verdict => {
                    let counts = self.locked || apart == Some(length);
                    self.let_go(verdict == Verdict::Unclear, counts);
                    self.skip(1);
                    from += 1;
                }
            }
        }
        self.held.drain(..from);
    }

    /// Where a marker stands from there on, or may when more has come.
    fn next_marker(&self, from: usize) -> usize {
        let held = &self.held;
        (from..held.len())
            .find(|&at| held[at] == MARKER[0] && self.mark(at) != Some(false))
            .unwrap_or(held.len())
    }

    /// Nothing is known to begin at a marker. It `counts` as a broken frame where a frame ended or one was due.
    fn let_go(&mut self, is_unclear: bool, counts: bool) {
        let what = if is_unclear {
            "counts beside each other look like its marker, so that where it begins cannot be told"
        } else {
            self.apart = Some(0);
            "no two markers stand behind it, each a frame of this sensor on"
        };
        let fault = FrameFault::Broken { what };
        self.locked = false;
        if counts {
            self.skipped = 0;
            self.blame(fault);
        } else {
            self.fault = Some(fault);
        }
    }

    /// Passes over bytes; every frame's length of them beyond the first counts as another broken frame.
    fn skip(&mut self, bytes: usize) {
        self.skipped += bytes;
        if let Some(apart) = &mut self.apart {
            *apart += bytes;
        }
        while self.skipped >= 2 * self.length() {
            self.skipped -= self.length();
            self.link_stats.corrupt += 1;
            self.fault.get_or_insert(FrameFault::Broken {
                what: "no two markers a frame of this sensor apart",
            });
        }
    }

    fn blame(&mut self, fault: FrameFault) {
        self.link_stats.corrupt += 1;
        self.fault = Some(fault);
    }

    fn hand_on(&mut self, from: usize, take: &mut dyn FnMut(&Frame<Counts>)) {
        let largest = self.expected.max_count;
        if largest != LARGEST {
            return self.blame(FrameFault::Width {
                found: LARGEST,
                expected: largest,
            });
        }
        for (value, &count) in self.frame.values_mut().iter_mut().zip(&self.held[from..]) {
            *value = f64::from(count);
        }
        // A broken frame leaves a gap.
        self.frame.sequence = self.link_stats.frames + self.link_stats.corrupt;
        self.link_stats.frames += 1;
        take(&self.frame);
    }
}

impl Decoder for FlexiTac {
    fn feed(&mut self, mut bytes: &[u8], take: &mut dyn FnMut(&Frame<Counts>)) {
        let most = MAX_AHEAD * self.length() + MARKER.len();
        while !bytes.is_empty() {
            // So much decides in any case, and leaves room.
            let room = most - self.held.len();
            let (part, rest) = bytes.split_at(room.min(bytes.len()));
            self.held.extend_from_slice(part);
            self.settle(take);
            bytes = rest;
        }
    }

    fn forget(&mut self) {
        if self.held.len() >= MARKER.len() {
            self.link_stats.corrupt += self.held.len().div_ceil(self.length()) as u64;
            self.fault = Some(FrameFault::Broken {
                what: "it ended before the next one began",
            });
        }
        self.held.clear();
        self.locked = false;
        self.skipped = 0;
        self.apart = None;
    }

    fn link_stats(&self) -> LinkStats {
        self.link_stats
    }

    fn last_fault(&self) -> Option<&FrameFault> {
        self.fault.as_ref()
    }

    fn name(&self) -> &'static str {
        "flexitac"
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::Protocol;
    use super::*;

    const ROWS: usize = 3;
    const COLUMNS: usize = 8;
    const TAXELS: usize = ROWS * COLUMNS;

    fn expected() -> Expected {
        Expected {
            rows: ROWS,
            columns: COLUMNS,
            max_count: LARGEST,
            absent: Vec::new(),
        }
    }

    /// Frames that differ, without a marker in them.
    fn plain(number: usize) -> Vec<u8> {
        let count = |taxel: usize| ((37 * taxel + 11 * number) % 160) as u8;
        (0..TAXELS).map(count).collect()
    }

    fn packet(counts: &[u8]) -> Vec<u8> {
        [&MARKER, counts].concat()
    }

    fn read(decoder: &mut dyn Decoder, bytes: &[u8], piece: usize) -> Vec<Vec<u8>> {
        let mut found = Vec::new();
        for piece in bytes.chunks(piece) {
            decoder.feed(piece, &mut |frame| {
                found.push(frame.values().iter().map(|v| *v as u8).collect());
            });
        }
        found
    }

    fn decoder() -> Box<dyn Decoder> {
        Protocol::FlexiTac.decoder(expected())
    }

    #[test]
    fn frames_come_back_in_pieces_of_any_size_from_any_beginning() {
        let sent: Vec<Vec<u8>> = (0..20).map(plain).collect();
        let bytes: Vec<u8> = sent.iter().flat_map(|counts| packet(counts)).collect();
        for piece in [1, 7, 64, 100_000] {
            for begin in [0, 1, 5, TAXELS] {
                let mut decoder = decoder();
                let found = read(&mut *decoder, &bytes[begin..], piece);
                // The first only tells where they begin; one is known to be whole when two more have begun.
                assert_eq!(
                    found,
                    sent[1 + usize::from(begin > 0)..18],
                    "{piece} {begin}"
                );
                assert_eq!(decoder.link_stats().corrupt, 0);
                let next = read(&mut *decoder, &packet(&plain(20)), piece);
                assert_eq!(next, sent[18..19]);
            }
        }
    }

    #[test]
    fn lost_and_added_bytes_cost_the_frame_and_its_neighbours_and_are_counted() {
        for change in [-20, -1, 1, 20i32] {
            let mut bytes: Vec<u8> = (0..8).flat_map(|n| packet(&plain(n))).collect();
            let at = 3 * (TAXELS + 2) + 3;
            match change {
                1.. => drop(bytes.splice(at..at, vec![7; change as usize])),
                _ => drop(bytes.drain(at..at + change.unsigned_abs() as usize)),
            }
            let mut decoder = decoder();
            let found = read(&mut *decoder, &bytes, 10);
            let whole: Vec<Vec<u8>> = [1, 5].map(plain).to_vec();
            assert_eq!(found, whole, "{change}");
            assert_eq!(decoder.link_stats().corrupt, 3, "{change}");
            let fault = decoder.last_fault().expect("it was broken").to_string();
            let length = 26 + change;
            let says = format!("frames of {length} bytes, but");
            assert!(fault.contains(&says), "{fault}");
            assert!(fault.contains("24 taxels make 26"), "{fault}");
        }
    }

    /// Two taxels that read 170 and 85 in all frames. Whoever came before them knows where frames begin; whoever comes
    /// later waits until one of the two has moved.
    #[test]
    fn counts_that_stand_still_as_a_marker_are_no_beginning() {
        let mut counts = plain(0);
        counts[9..11].copy_from_slice(&MARKER);
        let standing = vec![counts; 12];
        let moving: Vec<Vec<u8>> = (1..6).map(plain).collect();
        let join = |parts: &[&[Vec<u8>]]| -> Vec<u8> {
            let all = parts.concat();
            all.iter().flat_map(|counts| packet(counts)).collect()
        };
        let bytes = join(&[&moving, &standing, &moving]);
        let mut known = decoder();
        let found = read(&mut *known, &bytes, 13);
        assert_eq!(found.len(), 19);
        assert_eq!(known.link_stats().corrupt, 0);

        let mut late = decoder();
        let found = read(&mut *late, &join(&[&standing, &moving])[5..], 13);
        let sent = [standing, moving].concat();
        assert!(found.iter().all(|found| sent.contains(found)));
        assert!(found.ends_with(&sent[12..15]), "{}", found.len());
        assert!(late.link_stats().corrupt > 5);
    }

    #[test]
    fn another_shape_and_another_converter_are_told_with_both_numbers() {
        let bytes: Vec<u8> = (0..9).flat_map(|n| packet(&plain(n))).collect();
        let wider = Expected {
            columns: COLUMNS + 1,
            ..expected()
        };
        let finer = Expected {
            max_count: 1023,
            ..expected()
        };
        for (expected, says) in [
            (
                wider,
                "frames of 26 bytes, but the sensor's 27 taxels make 29",
            ),
            (finer, "counts of at most 255, but the sensor's converter"),
        ] {
            let mut decoder = Protocol::FlexiTac.decoder(expected);
            assert!(read(&mut *decoder, &bytes, 50).is_empty());
            let fault = decoder.last_fault().expect(says).to_string();
            assert!(fault.contains(says), "{fault}");
            assert!(decoder.link_stats().corrupt > 4);
        }
    }

    #[test]
    fn after_a_silence_it_begins_anew() {
        let mut decoder = decoder();
        let bytes: Vec<u8> = (0..4).flat_map(|n| packet(&plain(n))).collect();
        assert_eq!(read(&mut *decoder, &bytes[..bytes.len() - 9], 8).len(), 1);
        decoder.forget();
        assert_eq!(decoder.link_stats().corrupt, 2);
        decoder.forget();
        assert_eq!(decoder.link_stats().corrupt, 2);
        assert_eq!(read(&mut *decoder, &bytes, 8).len(), 1);
    }

    proptest! {
        /// A gap or noise anywhere, and counts that look like markers anywhere: no frame is handed on that was not sent,
        /// and from the third frame on, counted from the one it begins in, each one is.
        #[test]
        fn no_gap_and_no_noise_make_a_frame(
            mut sent in proptest::collection::vec(proptest::collection::vec(any::<u8>(), TAXELS), 12),
            markers in proptest::collection::vec((0..12usize, 0..TAXELS - 1), 0..12),
            at in 0..6 * (TAXELS + 2),
            gap in 1..TAXELS + 2,
            noise in proptest::collection::vec(any::<u8>(), 0..TAXELS + 1),
            piece in 1usize..80,
        ) {
            // At one place in two frames running they would be what cannot be told.
            let mut places = [true; TAXELS];
            for (frame, taxel) in markers {
                if !std::mem::take(&mut places[taxel]) {
                    continue;
                }
                sent[frame][taxel..taxel + 2].copy_from_slice(&MARKER);
            }
            let mut bytes: Vec<u8> = sent.iter().flat_map(|counts| packet(counts)).collect();
            let is_gap = noise.is_empty();
            if is_gap {
                bytes.drain(at..at + gap);
            } else {
                bytes.splice(at..at, noise);
            }
            let mut decoder = decoder();
            let found = read(&mut *decoder, &bytes, piece);
            for found in &found {
                prop_assert!(sent.contains(found));
            }
            // Hit: the frame where it begins, and the next if the gap reaches into it; then one that tells where frames begin.
            let next = at / (TAXELS + 2) + 3;
            let last = sent[next..9].iter().all(|sent| found.contains(sent));
            prop_assert!(last, "{} of 12, hit at {at}", found.len());
            let stats = decoder.link_stats();
            prop_assert_eq!(stats.frames, found.len() as u64);
            prop_assert!(stats.corrupt <= 6, "{}", stats.corrupt);
        }

        /// Any bytes at all: nothing panics, and good frames behind them are found.
        #[test]
        fn no_bytes_break_it(
            noise in proptest::collection::vec(any::<u8>(), 0..400),
            piece in 1usize..80,
        ) {
            let mut decoder = decoder();
            let after: Vec<u8> = (0..7).flat_map(|n| packet(&plain(n))).collect();
            let found = read(&mut *decoder, &[noise, after].concat(), piece);
            for number in 2..5 {
                prop_assert!(found.contains(&plain(number)));
            }
        }
    }
}
