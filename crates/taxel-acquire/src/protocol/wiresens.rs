//! WiReSens' packets, as its boards send them over a serial line.
//!
//! | at | bytes | what (little-endian) |
//! |---|---|---|
//! | 0 | 1 | sensor id |
//! | 1 | 2 | index of the first count |
//! | 3 | 2·N | counts, N a packet; behind the last of a frame follows the first of the next |
//! | 3 + 2·N | 4 | packet number, one more than the packet before |
//! | 7 + 2·N | 2 | `wr` |
//!
//! Index `i` is read wire `i` mod R of ground wire `i / R`: a row of column `i / R`. N is the board's setting and stands
//! nowhere; two packets that follow each other tell it. Nothing is escaped, but counts of 12 bits cannot be `wr`; numbers
//! can. A frame that lacks a packet is left out, also one that the board predicted rather than sent.

use taxel::{Counts, Frame};

use super::{Decoder, Expected, FrameFault, LinkStats};

/// Behind every packet.
const END: [u8; 2] = *b"wr";
/// Bytes of a packet that are no counts.
const AROUND: usize = 9;
/// The most counts in a packet that a board can be set to.
const MAX_COUNTS: usize = 256;

/// What a packet says beside its counts.
#[derive(Debug, Clone, Copy)]
struct Header {
    id: u8,
    start: usize,
    number: u32,
}

/// Reads WiReSens' packets.
pub struct WiReSens {
    expected: Expected,
    frame: Frame<Counts>,
    held: Vec<u8>,
    /// N, once it is known.
    counts: Option<usize>,
    /// The packet before.
    last: Option<Header>,
    /// Counts of this frame so far; `None`: its beginning has not come.
    filled: Option<usize>,
    link_stats: LinkStats,
    fault: Option<FrameFault>,
}

impl WiReSens {
    /// For frames of one sensor.
    pub fn new(expected: Expected) -> Self {
        Self {
            frame: expected.frame(),
            expected,
            held: Vec::new(),
            counts: None,
            last: None,
            filled: None,
            link_stats: LinkStats::default(),
            fault: None,
        }
    }

    /// The most counts that a packet is taken to have.
    fn most(&self) -> usize {
        self.expected.taxels().min(MAX_COUNTS)
    }

    /// The packet of so many counts that begins there; `None` where that is none or has not come yet.
    fn packet(&self, from: usize, counts: usize) -> Option<Header> {
        let packet = self.held.get(from..from + AROUND + 2 * counts)?;
        let behind = 3 + 2 * counts;
        let start = usize::from(u16::from_le_bytes([packet[1], packet[2]]));
        let number = packet[behind..behind + 4].try_into().ok()?;
        let is_one = packet[behind + 4..] == END && start < self.expected.taxels();
        is_one.then_some(Header {
            id: packet[0],
            start,
            number: u32::from_le_bytes(number),
        })
    }

    /// Whether a packet is the next but `missing`, if any, behind one.
    fn missing(&self, before: Header, packet: Header, counts: usize) -> Option<u32> {
        let ahead = packet.number.checked_sub(before.number)?;
        let step = u64::from(ahead) * counts as u64;
        let start = (before.start as u64 + step) % self.expected.taxels() as u64;
        let follows = ahead > 0 && packet.id == before.id && start == packet.start as u64;
        follows.then(|| ahead - 1)
    }

    /// How many counts a packet that begins there has, by the packet behind it.
    fn counts_at(&self, from: usize) -> Option<usize> {
        (1..=self.most()).find(|&counts| {
            let first = self.packet(from, counts);
            let second = self.packet(from + AROUND + 2 * counts, counts);
            first
                .zip(second)
                .is_some_and(|(first, second)| self.missing(first, second, counts) == Some(0))
        })
    }

    /// Reads what is whole.
    fn settle(&mut self, take: &mut dyn FnMut(&Frame<Counts>)) {
        let mut from = 0;
        loop {
            if self.counts.is_none() {
                self.counts = self.counts_at(from);
            }
            let length = AROUND + 2 * self.counts.unwrap_or(self.most());
            let wanted = if self.counts.is_some() {
                length
            } else {
                2 * length
            };
            let packet = self.counts.and_then(|counts| self.packet(from, counts));
            if let Some((header, counts)) = packet.zip(self.counts) {
                self.take_packet(header, from + 3, counts, take);
                from += length;
            } else if self.held.len() - from >= wanted {
                // None begins there: behind the next end one may.
                self.give_up(
                    "a packet that begins behind the last taxel, or does not end where it should",
                );
                let held = &self.held[from..];
                let end = held.windows(2).position(|two| two == END);
                from += end.map_or(held.len() - 1, |end| end + END.len());
            } else {
                break;
            }
        }
        self.held.drain(..from);
    }

    /// The frame that was begun lacks something.
    fn give_up(&mut self, what: &'static str) {
        if self.filled.take().is_some() {
            self.link_stats.corrupt += 1;
        }
        self.fault = Some(FrameFault::Broken { what });
    }

    fn take_packet(
        &mut self,
        header: Header,
        at: usize,
        counts: usize,
        take: &mut dyn FnMut(&Frame<Counts>),
    ) {
        let missing = self.last.map(|last| self.missing(last, header, counts));
        self.last = Some(header);
        match missing {
            None | Some(Some(0)) => {}
            Some(Some(missing)) => {
                // Frames that began within them.
                let taxels = self.expected.taxels() as u64;
                let counts = u64::from(missing) * counts as u64;
                let begun = (taxels - header.start as u64 % taxels) % taxels;
                self.link_stats.lost += (counts + begun) / taxels;
                self.give_up("a packet of it is missing");
            }
            Some(None) => {
                // The packet before was read: which of the two is damaged, or whether the board began anew, is not told.
                self.give_up("its packets do not follow each other");
            }
        }
        let taxels = self.expected.taxels();
        for n in 0..counts {
            let index = (header.start + n) % taxels;
            if index == 0 {
                self.filled = Some(0);
            }
            let found = u16::from_le_bytes([self.held[at + 2 * n], self.held[at + 2 * n + 1]]);
            self.put(index, u64::from(found), take);
        }
    }

    /// Puts a count into the frame, and hands that on when it is whole.
    fn put(&mut self, index: usize, found: u64, take: &mut dyn FnMut(&Frame<Counts>)) {
        if self.filled != Some(index) {
            return;
        }
        let Expected {
            rows,
            columns,
            max_count: largest,
            ..
        } = self.expected;
        if found > largest {
            self.filled = None;
            self.link_stats.corrupt += 1;
            self.fault = Some(FrameFault::Range { found, largest });
            return;
        }
        let (column, row) = (index / rows, index % rows);
        self.frame.values_mut()[row * columns + column] = found as f64;
        self.filled = Some(index + 1);
        if index + 1 == rows * columns {
            self.filled = None;
            self.frame.sequence =
                self.link_stats.frames + self.link_stats.corrupt + self.link_stats.lost;
            self.link_stats.frames += 1;
            take(&self.frame);
        }
    }
}

impl Decoder for WiReSens {
    fn feed(&mut self, mut bytes: &[u8], take: &mut dyn FnMut(&Frame<Counts>)) {
        let most = 2 * (AROUND + 2 * self.most());
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
        if self.filled.is_some() {
            self.give_up("it ended before its last packet");
        }
        self.held.clear();
        (self.counts, self.last) = (None, None);
    }

    fn link_stats(&self) -> LinkStats {
        self.link_stats
    }

    fn last_fault(&self) -> Option<&FrameFault> {
        self.fault.as_ref()
    }

    fn name(&self) -> &'static str {
        "wiresens"
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::Protocol;
    use super::*;

    const ROWS: usize = 5;
    const COLUMNS: usize = 3;
    const TAXELS: usize = ROWS * COLUMNS;

    fn decoder() -> Box<dyn Decoder> {
        Protocol::WiReSens.decoder(Expected {
            rows: ROWS,
            columns: COLUMNS,
            max_count: 4095,
            absent: Vec::new(),
        })
    }

    fn count(frame: usize, index: usize) -> u16 {
        ((TAXELS * frame + index) * 7 % 4096) as u16
    }

    /// The frame as it is to come: index by index down the columns.
    fn values(frame: usize) -> Vec<f64> {
        let taxels = (0..TAXELS).map(|taxel| (taxel % COLUMNS) * ROWS + taxel / COLUMNS);
        taxels.map(|index| f64::from(count(frame, index))).collect()
    }

    /// Packets of `size` counts, without end.
    fn packets(size: usize, number: usize) -> Vec<Vec<u8>> {
        let packet = |number: usize| {
            let start = number * size;
            let mut bytes = vec![3];
            bytes.extend(((start % TAXELS) as u16).to_le_bytes());
            for at in start..start + size {
                bytes.extend(count(at / TAXELS, at % TAXELS).to_le_bytes());
            }
            bytes.extend((number as u32).to_le_bytes());
            bytes.extend(END);
            bytes
        };
        (0..number).map(packet).collect()
    }

    fn read(decoder: &mut dyn Decoder, bytes: &[u8], piece: usize) -> Vec<Vec<f64>> {
        let mut found = Vec::new();
        for piece in bytes.chunks(piece) {
            decoder.feed(piece, &mut |frame| found.push(frame.values().to_vec()));
        }
        found
    }

    #[test]
    fn packets_of_any_size_make_frames() {
        for size in [1, 4, 6, 15] {
            let packets = packets(size, 8 * TAXELS);
            let whole = 8 * size;
            for piece in [1, 10, 1000] {
                for begin in [0, 2] {
                    let mut decoder = decoder();
                    let found = read(&mut *decoder, &packets.concat()[begin..], piece);
                    let sent: Vec<Vec<f64>> = (0..whole).map(values).collect();
                    assert!(sent.ends_with(&found), "{size} {piece}");
                    assert!(found.len() + 3 * begin >= whole, "{size} {}", found.len());
                    let stats = decoder.link_stats();
                    assert_eq!((stats.corrupt, stats.lost), (0, 0), "{size}");
                }
            }
        }
    }

    #[test]
    fn a_frame_without_a_packet_is_counted_and_left_out() {
        for (size, gone, without) in [(6, 5, 2), (6, 7, 2), (15, 4, 4), (5, 9, 3)] {
            let mut packets = packets(size, 30);
            packets.remove(gone);
            let mut decoder = decoder();
            let found = read(&mut *decoder, &packets.concat(), 9);
            let frames = 30 * size / TAXELS;
            let hit = |frame: &usize| {
                let (first, end) = (gone * size, (gone + 1) * size);
                first < (frame + 1) * TAXELS && end > frame * TAXELS
            };
            assert!(hit(&without));
            let sent = (0..frames).filter(|frame| !hit(frame)).map(values);
            assert_eq!(found, sent.collect::<Vec<_>>(), "{size} {gone}");
            let stats = decoder.link_stats();
            let left_out = (0..frames).filter(hit).count() as u64;
            assert_eq!(stats.corrupt + stats.lost, left_out, "{size} {gone}");
        }
    }

    #[test]
    fn counts_out_of_range_and_broken_links_cost_their_frame() {
        let mut packets = packets(5, 12);
        packets[4][4] = 0x7F;
        let mut decoder = decoder();
        let found = read(&mut *decoder, &packets.concat(), 9);
        assert_eq!(found, [0, 2, 3].map(values));
        assert_eq!(decoder.link_stats().corrupt, 1);
        let fault = decoder.last_fault().expect("it was refused").to_string();
        assert!(
            fault.contains("but the converter's largest is 4095"),
            "{fault}"
        );
        read(&mut *decoder, &packets[0][..9], 9);
        decoder.forget();
        assert_eq!(read(&mut *decoder, &packets.concat(), 9).len(), 3);
    }

    proptest! {
        /// A gap or noise anywhere: no frame is handed on that was not sent, and from the second behind it on each one is.
        #[test]
        fn no_gap_and_no_noise_make_a_frame(
            size in 3..=TAXELS,
            at in 0usize..300,
            gap in 1usize..40,
            noise in proptest::collection::vec(any::<u8>(), 0..40),
            piece in 1usize..80,
        ) {
            let packets = packets(size, 60);
            let bytes = packets.concat();
            let end = if noise.is_empty() { at + gap } else { at };
            let behind = (end / packets[0].len() + 1) * size / TAXELS + 3;
            let frames = 60 * size / TAXELS;
            let mut broken = bytes;
            broken.splice(at..end, noise);
            let mut decoder = decoder();
            let found = read(&mut *decoder, &broken, piece);
            let sent: Vec<Vec<f64>> = (0..frames).map(values).collect();
            for found in &found {
                prop_assert!(sent.contains(found));
            }
            for (frame, values) in sent.iter().enumerate().skip(behind) {
                prop_assert!(found.contains(values), "frame {frame} of {frames}");
            }
        }

        /// Any bytes at all: nothing panics, and good frames behind them are found.
        #[test]
        fn no_bytes_break_it(
            noise in proptest::collection::vec(any::<u8>(), 0..400),
            piece in 1usize..80,
        ) {
            let mut decoder = decoder();
            let after = packets(5, 30).concat();
            let found = read(&mut *decoder, &[noise, after].concat(), piece);
            prop_assert!(found.ends_with(&[values(8), values(9)]));
        }
    }
}
