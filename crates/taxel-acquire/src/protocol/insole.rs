//! The open insole's datagrams: a count a taxel, then which foot.
//!
//! | number | what (2 bytes, little-endian) |
//! |---|---|
//! | 0 to n − 1 | counts of the n taxels there are: column by column, in each from row 0 on |
//! | n | 0 for the left foot, 1 for the right |
//! | n + 1 to n + 6 | accelerations and turning rates, where the device sends them; passed over |
//!
//! The insole has 253 taxels at 32 × 10 crossings; `array.population` tells which. Two insoles send to one port: the
//! foot that is not listened to is counted, and never mixed in. Packets carry no number and no checksum: those that are
//! lost cannot be counted, and a datagram is whole by UDP's own checksum alone.

use taxel::{Counts, Frame};

use super::{Decoder, Expected, FrameFault, LinkStats};

/// Numbers of the motion sensor behind the foot.
const MOTION: usize = 6;

/// Which insole is listened to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Foot {
    /// Whichever comes first, until a silence.
    First,
    /// The left one.
    Left,
    /// The right one.
    Right,
}

impl Foot {
    /// The number that stands for it.
    fn number(self) -> Option<u16> {
        match self {
            Foot::First => None,
            Foot::Left => Some(0),
            Foot::Right => Some(1),
        }
    }
}

/// Reads the insole's datagrams.
pub struct Insole {
    foot: Foot,
    /// The one that is listened to, when it is known.
    heard: Option<u16>,
    max_count: u64,
    /// Where each count belongs.
    places: Vec<usize>,
    frame: Frame<Counts>,
    link_stats: LinkStats,
    fault: Option<FrameFault>,
}

impl Insole {
    /// For frames of one sensor.
    pub fn new(expected: Expected, foot: Foot) -> Self {
        let Expected { rows, columns, .. } = expected;
        let crossings = (0..columns).flat_map(|column| (0..rows).map(move |row| (row, column)));
        let taxels = crossings.map(|(row, column)| row * columns + column);
        Self {
            foot,
            heard: foot.number(),
            max_count: expected.max_count,
            places: taxels.filter(|&taxel| !expected.is_absent(taxel)).collect(),
            frame: expected.frame(),
            link_stats: LinkStats::default(),
            fault: None,
        }
    }

    /// Checks the packet and fills the frame.
    fn read_packet(&mut self, packet: &[u8]) -> Result<(), FrameFault> {
        let taxels = self.places.len();
        let numbers = packet.len() / 2;
        if !packet.len().is_multiple_of(2) || ![taxels + 1, taxels + 1 + MOTION].contains(&numbers)
        {
            return Err(FrameFault::Length {
                found: packet.len(),
                expected: 2 * (taxels + 1),
                taxels,
            });
        }
        let number = |at: usize| u16::from_le_bytes([packet[2 * at], packet[2 * at + 1]]);
        let found = number(taxels);
        if found > 1 {
            return Err(FrameFault::Broken {
                what: "its foot is neither 0, left, nor 1, right",
            });
        }
        if let Some(expected) = self.heard.filter(|heard| *heard != found) {
            let name = |foot| if foot == 0 { "left" } else { "right" };
            return Err(FrameFault::Foot {
                found: name(found),
                expected: name(expected),
            });
        }
        let largest = self.max_count;
        for (at, &place) in self.places.iter().enumerate() {
            let found = u64::from(number(at));
            if found > largest {
                return Err(FrameFault::Range { found, largest });
            }
            self.frame.values_mut()[place] = found as f64;
        }
        self.heard = Some(found);
        Ok(())
    }
}

impl Decoder for Insole {
    /// A datagram at a time: within a stream nothing tells where a packet begins.
    fn feed(&mut self, bytes: &[u8], take: &mut dyn FnMut(&Frame<Counts>)) {
        match self.read_packet(bytes) {
            Ok(()) => {
                self.frame.sequence = self.link_stats.frames + self.link_stats.corrupt;
                self.link_stats.frames += 1;
                take(&self.frame);
            }
            Err(fault) => {
                match fault {
                    FrameFault::Foot { .. } => self.link_stats.strangers += 1,
                    _ => self.link_stats.corrupt += 1,
                }
                self.fault = Some(fault);
            }
        }
    }

    fn forget(&mut self) {
        self.heard = self.foot.number();
    }

    fn link_stats(&self) -> LinkStats {
        self.link_stats
    }

    fn last_fault(&self) -> Option<&FrameFault> {
        self.fault.as_ref()
    }

    fn name(&self) -> &'static str {
        match self.foot {
            Foot::First => "insole-udp",
            Foot::Left => "insole-udp-left",
            Foot::Right => "insole-udp-right",
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::Protocol;
    use super::*;

    const LEFT: u16 = 0;
    const RIGHT: u16 = 1;

    /// 4 x 3 crossings, of which (0, 1), (2, 0) and (3, 2) have no taxel.
    fn expected() -> Expected {
        let mut absent = vec![false; 12];
        for taxel in [1, 6, 11] {
            absent[taxel] = true;
        }
        Expected {
            rows: 4,
            columns: 3,
            max_count: 4095,
            absent,
        }
    }

    fn packet(first: u16, foot: u16) -> Vec<u8> {
        let numbers = (first..first + 9).chain([foot]);
        numbers.flat_map(u16::to_le_bytes).collect()
    }

    fn feed(decoder: &mut dyn Decoder, packet: &[u8]) -> Vec<Vec<f64>> {
        let mut found = Vec::new();
        decoder.feed(packet, &mut |frame| found.push(frame.values().to_vec()));
        found
    }

    #[test]
    fn counts_go_column_by_column_to_the_taxels_there_are() {
        let mut decoder = Protocol::Insole(Foot::First).decoder(expected());
        let found = feed(&mut *decoder, &packet(300, LEFT));
        let rows = [
            [300.0, 0.0, 306.0],
            [301.0, 303.0, 307.0],
            [0.0, 304.0, 308.0],
            [302.0, 305.0, 0.0],
        ];
        assert_eq!(found, [rows.concat()]);
        // With the motion sensor's six behind it: what they say is no matter.
        let longer = [packet(500, LEFT), vec![0xFF; 12]].concat();
        assert_eq!(feed(&mut *decoder, &longer)[0][0], 500.0);
    }

    #[test]
    fn the_other_foot_is_counted_and_left_out() {
        for (foot, wanted) in [
            (Foot::First, LEFT),
            (Foot::Left, LEFT),
            (Foot::Right, RIGHT),
        ] {
            let mut decoder = Protocol::Insole(foot).decoder(expected());
            let mut found = Vec::new();
            for number in 0..20 {
                for side in [LEFT, RIGHT] {
                    let first = 100 * number + 1000 * side;
                    found.extend(feed(&mut *decoder, &packet(first, side)));
                }
            }
            let firsts: Vec<f64> = found.iter().map(|values| values[0]).collect();
            let sent = (0..20).map(|n| f64::from(100 * n + 1000 * wanted));
            assert_eq!(firsts, sent.collect::<Vec<f64>>());
            let stats = decoder.link_stats();
            assert_eq!((stats.frames, stats.strangers, stats.corrupt), (20, 20, 0));
            let fault = decoder.last_fault().expect("the other came").to_string();
            assert!(fault.contains("of the right foot") == (wanted == LEFT));
            // After a silence whoever comes first is heard; one that was chosen is still the one.
            decoder.forget();
            let other = feed(&mut *decoder, &packet(7, 1 - wanted)).len();
            assert_eq!(other, usize::from(foot == Foot::First));
        }
    }

    #[test]
    fn what_is_wrong_is_said_with_both_numbers() {
        let full = Expected {
            absent: Vec::new(),
            ..expected()
        };
        for (expected, packet, says) in [
            (
                full,
                packet(0, LEFT),
                "20 bytes, but the sensor's 12 taxels make 26",
            ),
            (expected(), packet(0, LEFT)[1..].to_vec(), "19 bytes, but"),
            (expected(), packet(0, 7), "neither 0, left, nor 1"),
            (expected(), packet(4090, LEFT), "a count of 4096, but"),
        ] {
            let mut decoder = Protocol::Insole(Foot::First).decoder(expected);
            assert!(feed(&mut *decoder, &packet).is_empty());
            assert_eq!(decoder.link_stats().corrupt, 1);
            let fault = decoder.last_fault().expect(says).to_string();
            assert!(fault.contains(says), "{fault}");
        }
    }

    proptest! {
        /// Datagrams of any bytes are left out; the next good one is a frame again, and nothing of theirs is in it.
        #[test]
        fn no_datagram_breaks_it(
            noise in proptest::collection::vec(proptest::collection::vec(any::<u8>(), 0..50), 0..20),
            cut in 0usize..20,
        ) {
            let mut decoder = Protocol::Insole(Foot::Left).decoder(expected());
            for noise in &noise {
                for values in feed(&mut *decoder, noise) {
                    prop_assert!(values.iter().all(|value| (0.0..=4095.0).contains(value)));
                }
            }
            prop_assert!(feed(&mut *decoder, &packet(9, LEFT)[..cut]).is_empty());
            let good = feed(&mut *decoder, &packet(9, LEFT));
            prop_assert_eq!(good[0][0], 9.0);
            prop_assert_eq!(good[0][10], 14.0);
        }
    }
}
