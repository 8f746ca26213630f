//! Which protocol a device speaks: the one whose decoder first finds a whole frame.
//!
//! No single byte decides. All decoders read until one of them has a frame; from then on that one alone, until what
//! comes makes no frames any more, or the link was broken or silent: then all of them read again.

use std::time::Duration;

use taxel::{Counts, Frame};

use super::{Decoder, Expected, FrameFault, LinkStats, Protocol};

/// The protocols that are tried: those that say enough of themselves to be told from others.
const TRIED: [Protocol; 4] = [
    Protocol::Taxel1,
    Protocol::Lines,
    Protocol::EconeText,
    Protocol::RowText,
];
/// Bytes without a frame after which all decoders read again, in frames of text.
const DOUBT: usize = 2;

/// Tries protocols until one of them fits.
pub struct Auto {
    decoders: Vec<Box<dyn Decoder>>,
    /// The one that found a frame last.
    found: Option<usize>,
    /// That one alone reads.
    sure: bool,
    /// The tally up to where the present reading began, and those of the decoders then.
    before: LinkStats,
    began: Vec<LinkStats>,
    /// What is added to the found decoder's sequence numbers, and the next number.
    shift: u64,
    next: u64,
    /// Bytes since the last frame, how many of them are of no text, and how many are cause for doubt.
    bytes: usize,
    binary: usize,
    doubt: usize,
}

impl Auto {
    /// For frames of one sensor.
    pub fn new(expected: Expected) -> Self {
        Self {
            decoders: TRIED.map(|p| p.decoder(expected.clone())).into(),
            found: None,
            sure: false,
            before: LinkStats::default(),
            began: vec![LinkStats::default(); TRIED.len()],
            shift: 0,
            next: 0,
            bytes: 0,
            binary: 0,
            doubt: DOUBT * (14 * expected.taxels() + 64),
        }
    }

    /// The decoder that speaks for all: the one that found frames, else the one that such bytes are for.
    fn likely(&self) -> usize {
        self.found
            .unwrap_or(if 10 * self.binary > self.bytes { 0 } else { 1 })
    }

    /// Hands bytes to one decoder; whether frames came of it.
    fn try_one(&mut self, one: usize, bytes: &[u8], take: &mut dyn FnMut(&Frame<Counts>)) -> bool {
        let is_other = self.found != Some(one);
        let (mut shift, mut next, mut any) = (self.shift, self.next, false);
        let mut copy = None;
        self.decoders[one].feed(bytes, &mut |frame| {
            if is_other && !any {
                shift = next.saturating_sub(frame.sequence);
            }
            any = true;
            next = frame.sequence + shift + 1;
            match shift {
                0 => take(frame),
                shift => {
                    let copy = copy.get_or_insert_with(|| frame.clone());
                    copy.clone_from(frame);
                    copy.sequence += shift;
                    take(copy);
                }
            }
        });
        if any {
            (self.shift, self.next) = (shift, next);
            self.decide(one);
        }
        any
    }

    /// This decoder is the one: what it counted since all began to read counts.
    fn decide(&mut self, one: usize) {
        self.found = Some(one);
        self.sure = true;
        (self.bytes, self.binary) = (0, 0);
    }

    /// All decoders read from here on. Those that did not, forget what they had.
    fn doubt(&mut self) {
        if !self.sure {
            return;
        }
        let link_stats = self.link_stats();
        self.sure = false;
        self.before = link_stats;
        for (one, decoder) in self.decoders.iter_mut().enumerate() {
            if self.found != Some(one) {
                decoder.forget();
            }
            self.began[one] = decoder.link_stats();
        }
    }
}

impl Decoder for Auto {
    fn feed(&mut self, bytes: &[u8], take: &mut dyn FnMut(&Frame<Counts>)) {
        self.bytes += bytes.len();
        let is_text = |byte: &u8| matches!(byte, b'\t' | b'\n' | b'\r' | b' '..=b'~');
        if self.found.is_none() {
            self.binary += bytes.iter().filter(|byte| !is_text(byte)).count();
        }
        match self.found.filter(|_| self.sure) {
            Some(one) => {
                if !self.try_one(one, bytes, take) && self.bytes > self.doubt {
                    self.doubt();
                }
            }
            None => {
                // The one that found frames before comes first.
                let first = self.found.unwrap_or(0);
                let others = (0..TRIED.len()).filter(|other| *other != first);
                for one in std::iter::once(first).chain(others) {
                    if self.try_one(one, bytes, take) {
                        break;
                    }
                }
            }
        }
    }

    fn forget(&mut self) {
        for (one, decoder) in self.decoders.iter_mut().enumerate() {
            if !self.sure || self.found == Some(one) {
                decoder.forget();
            }
        }
        self.doubt();
    }

    fn datagram(&mut self, after: Duration) {
        for decoder in &mut self.decoders {
            decoder.datagram(after);
        }
    }

    fn link_stats(&self) -> LinkStats {
        let one = self.likely();
        self.before
            .and(&self.decoders[one].link_stats().since(&self.began[one]))
    }

    fn last_fault(&self) -> Option<&FrameFault> {
        self.decoders[self.likely()].last_fault()
    }

    fn name(&self) -> &'static str {
        self.found.map_or("auto", |one| self.decoders[one].name())
    }
}
