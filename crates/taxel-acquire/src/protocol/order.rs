//! Sequence numbers: what is next, what is missing, what came again.

use super::LinkStats;

/// A frame that comes late by no more than this was overtaken on its way; a device that falls back further has been
/// restarted.
const LATE: u32 = 32;

/// Follows a device's 32-bit sequence numbers.
#[derive(Debug, Default)]
pub(super) struct Order {
    last: Option<u32>,
    total: u64,
}

impl Order {
    /// The frame's place in the stream, with gaps; `None` for one that came before.
    pub fn place(&mut self, sequence: u32, link_stats: &mut LinkStats) -> Option<u64> {
        let step = match self.last {
            None => 0,
            Some(last) => {
                let ahead = sequence.wrapping_sub(last);
                let behind = last.wrapping_sub(sequence);
                if ahead == 0 {
                    link_stats.repeated += 1;
                    return None;
                }
                if behind < u32::MAX / 2 {
                    if behind <= LATE {
                        link_stats.repeated += 1;
                        return None;
                    }
                    link_stats.restarts += 1;
                    1
                } else {
                    link_stats.lost += u64::from(ahead - 1);
                    u64::from(ahead)
                }
            }
        };
        self.last = Some(sequence);
        self.total += step;
        link_stats.frames += 1;
        Some(self.total)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_repeats_late_ones_restarts_and_the_end_of_32_bits() {
        let (mut order, mut link_stats) = (Order::default(), LinkStats::default());
        let mut place = |sequence| order.place(sequence, &mut link_stats);
        assert_eq!(place(5000), Some(0));
        assert_eq!(place(5001), Some(1));
        assert_eq!(place(5001), None);
        assert_eq!(place(5005), Some(5));
        assert_eq!(place(5004), None);
        assert_eq!(place(0), Some(6));
        assert_eq!(place(1), Some(7));
        assert_eq!(
            link_stats,
            LinkStats {
                frames: 5,
                lost: 3,
                corrupt: 0,
                repeated: 2,
                restarts: 1,
                ..LinkStats::default()
            }
        );
        let (mut order, mut link_stats) = (Order::default(), LinkStats::default());
        assert_eq!(order.place(u32::MAX - 1, &mut link_stats), Some(0));
        assert_eq!(order.place(1, &mut link_stats), Some(3));
        assert_eq!((link_stats.lost, link_stats.restarts), (2, 0));
    }
}
