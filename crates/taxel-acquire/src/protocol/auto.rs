//! Which protocol the first bytes look like.

use taxel::{Counts, Frame};

use super::fields::counts;
use super::{Decoder, Expected, Fault, Protocol, Tally};

/// Waits for a zero byte (`taxel-1`) or two line ends (text), then reads what it is.
pub struct Auto {
    expected: Expected,
    held: Vec<u8>,
    found: Option<Box<dyn Decoder>>,
}

impl Auto {
    /// For frames of one sensor.
    pub fn new(expected: Expected) -> Self {
        Self {
            expected,
            held: Vec::new(),
            found: None,
        }
    }

    fn guess(&self) -> Option<Protocol> {
        if self.held.contains(&0) {
            return Some(Protocol::Taxel1);
        }
        // The first line may be the rest of one.
        let mut lines = self.held.split(|&byte| byte == b'\n').skip(1).peekable();
        let mut fields = Vec::new();
        while let Some(line) = lines.next() {
            let complete = lines.peek().is_some();
            if !complete || !counts(line, &mut fields) {
                continue;
            }
            if fields.len() == self.expected.columns && self.expected.rows > 1 {
                return Some(Protocol::EconeText);
            }
            if fields.len() == self.expected.taxels() || fields.len() == self.expected.columns + 1 {
                return Some(Protocol::Lines);
            }
        }
        // Enough for several lines of any kind: let the text protocol say what is wrong.
        (self.held.len() > 64 * (self.expected.taxels() + 64)).then_some(Protocol::Lines)
    }
}

impl Decoder for Auto {
    fn feed(&mut self, bytes: &[u8], take: &mut dyn FnMut(&Frame<Counts>)) {
        if let Some(decoder) = &mut self.found {
            return decoder.feed(bytes, take);
        }
        self.held.extend_from_slice(bytes);
        if let Some(protocol) = self.guess() {
            let mut decoder = protocol.decoder(self.expected);
            decoder.feed(&std::mem::take(&mut self.held), take);
            self.found = Some(decoder);
        }
    }

    fn forget(&mut self) {
        self.held.clear();
        if let Some(decoder) = &mut self.found {
            decoder.forget();
        }
    }

    fn tally(&self) -> Tally {
        self.found.as_ref().map_or(Tally::default(), |d| d.tally())
    }

    fn last_fault(&self) -> Option<&Fault> {
        self.found.as_ref().and_then(|d| d.last_fault())
    }

    fn name(&self) -> &'static str {
        self.found.as_ref().map_or("auto", |d| d.name())
    }
}
