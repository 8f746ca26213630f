//! `taxel-1`: one frame a packet, COBS between zero bytes, CRC-32 at its end.
//!
//! | at | bytes | what (little-endian) |
//! |---|---|---|
//! | 0 | 1 | version, 1 |
//! | 1 | 1 | bits a count: 8, 10, 12 or 16 |
//! | 2 | 2 | sensor id |
//! | 4 | 4 | sequence number |
//! | 8 | 8 | device time, µs |
//! | 16 | 2 | rows R |
//! | 18 | 2 | columns C |
//! | 20 | ⌈R·C·bits/8⌉ | counts, row by row, packed from the low bit of the first byte on |
//! | last | 4 | CRC-32 (IEEE) of all before it |

use taxel::{Counts, Frame};

use super::order::Order;
use super::{Decoder, Expected, FrameFault, LinkStats};

const VERSION: u8 = 1;
const HEADER: usize = 20;
const CHECK: usize = 4;

/// What a packet says beside its counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Header {
    /// Bits a count: 8, 10, 12 or 16.
    pub bits: u8,
    /// Which sensor.
    pub sensor_id: u16,
    /// Counts up by one a frame.
    pub sequence: u32,
    /// Device time, µs.
    pub time_us: u64,
}

/// Appends the packet of a frame, with the zero bytes around it.
///
/// # Panics
/// For counts that are no whole numbers of `bits` bits, and arrays of more than 65,535 rows or columns.
pub fn encode(frame: &Frame<Counts>, header: &Header, out: &mut Vec<u8>) {
    let mut packet = Vec::with_capacity(HEADER + 2 * frame.values().len() + CHECK);
    packet.push(VERSION);
    packet.push(header.bits);
    packet.extend(header.sensor_id.to_le_bytes());
    packet.extend(header.sequence.to_le_bytes());
    packet.extend(header.time_us.to_le_bytes());
    for lines in [frame.rows(), frame.columns()] {
        packet.extend(u16::try_from(lines).expect("few lines").to_le_bytes());
    }
    let (mut held, mut bits) = (0u32, 0);
    for &count in frame.values() {
        assert!(
            count.fract() == 0.0 && count >= 0.0 && count < f64::from(1u32 << header.bits),
            "{count} is no count of {} bits",
            header.bits
        );
        held |= (count as u32) << bits;
        bits += u32::from(header.bits);
        while bits >= 8 {
            packet.push(held as u8);
            held >>= 8;
            bits -= 8;
        }
    }
    if bits > 0 {
        packet.push(held as u8);
    }
    packet.extend(crc32fast::hash(&packet).to_le_bytes());
    out.push(0);
    out.extend(cobs::encode_vec(&packet));
    out.push(0);
}

/// Reads `taxel-1`.
pub struct Taxel1 {
    expected: Expected,
    frame: Frame<Counts>,
    packet: Vec<u8>,
    /// The packet is longer than a frame can be: skip to the next zero byte.
    overlong: bool,
    order: Order,
    /// The sensor that is listened to, from its first frame on.
    sensor: Option<u16>,
    link_stats: LinkStats,
    fault: Option<FrameFault>,
}

impl Taxel1 {
    /// For frames of one sensor.
    pub fn new(expected: Expected) -> Self {
        Self {
            frame: expected.frame(),
            expected,
            packet: Vec::new(),
            overlong: false,
            order: Order::default(),
            sensor: None,
            link_stats: LinkStats::default(),
            fault: None,
        }
    }

    /// The most bytes between zero bytes that can be a frame.
    fn longest(&self) -> usize {
        let plain = HEADER + 2 * self.expected.taxels() + CHECK;
        plain + plain / 254 + 2
    }

    fn close(&mut self, take: &mut dyn FnMut(&Frame<Counts>)) {
        // One that was too long is counted already.
        if !self.packet.is_empty() && !self.overlong {
            match self.read_packet() {
                Ok(sequence) => {
                    if let Some(place) = self.order.place(sequence, &mut self.link_stats) {
                        self.frame.sequence = place;
                        take(&self.frame);
                    }
                }
                Err(fault @ FrameFault::Sensor { .. }) => {
                    self.link_stats.strangers += 1;
                    self.fault = Some(fault);
                }
                Err(fault) => self.blame(fault),
            }
        }
        self.packet.clear();
        self.overlong = false;
    }

    fn blame(&mut self, fault: FrameFault) {
        self.link_stats.corrupt += 1;
        self.fault = Some(fault);
    }

    fn check_sensor(&self, found: u16) -> Result<(), FrameFault> {
        match self.sensor {
            Some(expected) if expected != found => Err(FrameFault::Sensor { found, expected }),
            _ => Ok(()),
        }
    }

    /// Checks the packet and fills the frame; its sequence number.
    fn read_packet(&mut self) -> Result<u32, FrameFault> {
        let broken = |what| FrameFault::Broken { what };
        let length = cobs::decode_in_place(&mut self.packet)
            .map_err(|_| broken("its bytes do not fit together"))?;
        let packet = &self.packet[..length];
        if length < HEADER + CHECK {
            return Err(broken("shorter than a header"));
        }
        let (body, check) = packet.split_at(length - CHECK);
        if crc32fast::hash(body).to_le_bytes() != *check {
            return Err(broken("its checksum is wrong"));
        }
        if body[0] != VERSION {
            return Err(FrameFault::Version { found: body[0] });
        }
        let u16_at = |at: usize| u16::from_le_bytes([body[at], body[at + 1]]);
        let sensor = u16_at(2);
        self.check_sensor(sensor)?;
        let found = (usize::from(u16_at(16)), usize::from(u16_at(18)));
        let expected = (self.expected.rows, self.expected.columns);
        if found != expected {
            return Err(FrameFault::Shape { found, expected });
        }
        let bits = usize::from(body[1]);
        if ![8, 10, 12, 16].contains(&bits) {
            return Err(broken("its counts have neither 8, 10, 12 nor 16 bits"));
        }
        let counts = &body[HEADER..];
        if counts.len() != (self.expected.taxels() * bits).div_ceil(8) {
            return Err(broken("its counts are too few or too many"));
        }
        let mask = (1u32 << bits) - 1;
        let (mut held, mut have, mut bytes) = (0u32, 0, counts.iter());
        let mut largest = 0;
        for value in self.frame.values_mut() {
            while have < bits {
                held |= u32::from(*bytes.next().expect("counted above")) << have;
                have += 8;
            }
            let count = held & mask;
            largest = largest.max(count);
            *value = f64::from(count);
            held >>= bits;
            have -= bits;
        }
        if u64::from(largest) > self.expected.max_count {
            return Err(FrameFault::Range {
                found: u64::from(largest),
                largest: self.expected.max_count,
            });
        }
        let time_us = u64::from_le_bytes(body[8..16].try_into().expect("eight bytes"));
        self.frame.time_secs = Some(time_us as f64 * 1e-6);
        self.sensor = Some(sensor);
        Ok(u32::from_le_bytes(
            body[4..8].try_into().expect("four bytes"),
        ))
    }
}

impl Decoder for Taxel1 {
    fn feed(&mut self, mut bytes: &[u8], take: &mut dyn FnMut(&Frame<Counts>)) {
        while !bytes.is_empty() {
            let end = bytes.iter().position(|&byte| byte == 0);
            let part = &bytes[..end.unwrap_or(bytes.len())];
            if !self.overlong && self.packet.len() + part.len() > self.longest() {
                // Counted now: its end may never come.
                self.overlong = true;
                self.packet.clear();
                self.blame(FrameFault::Broken {
                    what: "longer than a frame of this sensor",
                });
            }
            if !self.overlong {
                self.packet.extend_from_slice(part);
            }
            bytes = match end {
                Some(end) => {
                    self.close(take);
                    &bytes[end + 1..]
                }
                None => &[],
            };
        }
    }

    fn forget(&mut self) {
        if !self.packet.is_empty() {
            self.blame(FrameFault::Broken {
                what: "it ended before its last byte",
            });
        }
        self.packet.clear();
        self.overlong = false;
        // After a silence another sensor may take its place.
        self.sensor = None;
    }

    fn link_stats(&self) -> LinkStats {
        self.link_stats
    }

    fn last_fault(&self) -> Option<&FrameFault> {
        self.fault.as_ref()
    }

    fn name(&self) -> &'static str {
        "taxel-1"
    }
}
