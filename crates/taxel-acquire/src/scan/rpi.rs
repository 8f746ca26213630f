//! A Raspberry Pi, or any Linux board with GPIO and SPI devices, as a source: the scanner on `linux-embedded-hal`.

use std::fmt;
use std::fs::OpenOptions;
use std::path::Path;
use std::time::{Duration, Instant, SystemTime};

use embedded_hal::delay::DelayNs;
use linux_embedded_hal::gpio_cdev::{Chip, LineRequestFlags, MultiLineHandle};
use linux_embedded_hal::spidev::SpidevOptions;
use linux_embedded_hal::{CdevPin, SpidevDevice};
use taxel::{Counts, Frame};

use super::config::{Board, Lines};
use super::select::address;
use super::{ScanError, Scanner, Select, ShiftRegister, SpiConverter};
use crate::permission::remedy;
use crate::protocol::LinkStats;
use crate::transport::{Receiver, State};

/// Who holds the pins, for whoever asks the system.
const CONSUMER: &str = "taxel";

/// A multiplexer's address pins, set by one call into the kernel: pin by pin, a scan of 64 × 128 taxels would need 50,000
/// calls and pass through addresses that nobody asked for.
struct AddressPins {
    /// None for a single line, which needs no address.
    pins: Option<MultiLineHandle>,
    wiring: Vec<u16>,
    levels: Vec<u8>,
}

impl AddressPins {
    fn select(&mut self, line: u16) -> Result<(), String> {
        let is_high = address(&self.wiring, line);
        for (bit, level) in self.levels.iter_mut().enumerate() {
            *level = u8::from(is_high(bit));
        }
        match &self.pins {
            Some(pins) => pins
                .set_values(&self.levels)
                .map_err(|error| error.to_string()),
            None => Ok(()),
        }
    }
}

/// A board's way to select one line.
enum Selector {
    Multiplexer(AddressPins),
    Register(Box<ShiftRegister<CdevPin>>),
}

impl Select for Selector {
    type Error = String;

    fn select(&mut self, line: u16) -> Result<(), String> {
        match self {
            Selector::Multiplexer(pins) => pins.select(line),
            Selector::Register(register) => {
                register.select(line).map_err(|error| error.to_string())
            }
        }
    }
}

/// Settling times. A thread that sleeps is woken 50 µs late and more, which a scan of 8192 taxels would pay 8192 times:
/// short waits are spent looking at the clock.
struct Settling;

impl Settling {
    /// What the system may be late by.
    const LATE: Duration = Duration::from_micros(200);
}

impl DelayNs for Settling {
    fn delay_ns(&mut self, ns: u32) {
        let (begun, wait) = (Instant::now(), Duration::from_nanos(ns.into()));
        if let Some(sleep) = wait.checked_sub(Self::LATE) {
            std::thread::sleep(sleep);
        }
        while begun.elapsed() < wait {
            std::hint::spin_loop();
        }
    }
}

type Parts = Scanner<Selector, Selector, SpiConverter<SpidevDevice>, Settling>;

/// Why a device does not open, and what would help: the errors of GPIO and SPI hold neither.
fn refused(device: &str, error: &dyn fmt::Display) -> String {
    let path = Path::new(device);
    let opened = OpenOptions::new().read(true).write(true).open(path);
    match opened.err().and_then(|error| remedy(path, &error)) {
        Some(remedy) => format!("{device}: {error}; {remedy}"),
        None => format!("{device}: {error}"),
    }
}

fn selector(chip: &mut Chip, gpio: &str, lines: &Lines) -> Result<Selector, String> {
    if let Some(pins) = lines.register_pins {
        let mut pin = |number: u32| -> Result<CdevPin, String> {
            let failed = |error| format!("pin {number} of {gpio}: {error}");
            let line = chip.get_line(number).map_err(failed)?;
            let handle = line
                .request(LineRequestFlags::OUTPUT, 0, CONSUMER)
                .map_err(failed)?;
            CdevPin::new(handle).map_err(failed)
        };
        let (data, clock, latch) = (pin(pins.data)?, pin(pins.clock)?, pin(pins.latch)?);
        let register = ShiftRegister::new(data, clock, latch, lines.count);
        return Ok(Selector::Register(Box::new(register)));
    }
    let Some(pins) = &lines.address_pins else {
        return Err("a board without pins".to_owned());
    };
    let failed = |error| format!("pins {pins:?} of {gpio}: {error}");
    let levels = vec![0; pins.len()];
    let handle = if pins.is_empty() {
        None
    } else {
        let of_chip = chip.get_lines(pins).map_err(failed)?;
        let request = of_chip.request(LineRequestFlags::OUTPUT, &levels, CONSUMER);
        Some(request.map_err(failed)?)
    };
    Ok(Selector::Multiplexer(AddressPins {
        pins: handle,
        wiring: lines.wiring.clone(),
        levels,
    }))
}

fn open(board: &Board) -> Result<Parts, String> {
    let mut chip = Chip::new(&board.gpio).map_err(|error| refused(&board.gpio, &error))?;
    let rows = (
        board.rows.count,
        selector(&mut chip, &board.gpio, &board.rows)?,
    );
    let columns = (
        board.columns.count,
        selector(&mut chip, &board.gpio, &board.columns)?,
    );
    let spi = &board.converter.spi;
    let mut device = SpidevDevice::open(spi).map_err(|error| refused(spi, &error))?;
    let options = SpidevOptions::new()
        .max_speed_hz(board.converter.clock_hz)
        .build();
    device
        .configure(&options)
        .map_err(|error| format!("{spi}: {error}"))?;
    let converter = SpiConverter::new(device, board.converter.leading_zeros, board.converter.bits);
    Ok(Scanner::new(
        rows,
        columns,
        converter,
        Settling,
        board.timing.into(),
    ))
}

/// What failed in a scan, in words.
fn words<A: fmt::Display>(error: ScanError<String, String, A>, board: &Board) -> String {
    match error {
        ScanError::Column(why) => format!("a column of {}: {why}", board.gpio),
        ScanError::Row(why) => format!("a row of {}: {why}", board.gpio),
        ScanError::Converter(why) => format!("{}: {why}", board.converter.spi),
        ScanError::Length { .. } => "a frame of another size".to_owned(),
    }
}

/// A scan that fails is tried again after this.
const AGAIN: Duration = Duration::from_millis(100);

/// Scans until it is stopped.
pub fn receive(board: &Board, receiver: &mut dyn Receiver) {
    let mut scanner = match open(board) {
        Ok(scanner) => scanner,
        Err(why) => return receiver.state(State::Ended, &why),
    };
    let (rows, columns) = scanner.shape();
    let (rows, columns) = (usize::from(rows), usize::from(columns));
    let mut counts = vec![0; rows * columns];
    let mut frame = Frame::<Counts>::zeros(rows, columns);
    let mut link_stats = LinkStats::default();
    let begun = Instant::now();
    receiver.state(State::Live, "scanning");
    let mut failed = false;
    while !receiver.stopped() {
        match scanner.scan_into(&mut counts) {
            Ok(()) => {
                if std::mem::take(&mut failed) {
                    receiver.state(State::Live, "scanning");
                }
                for (value, &count) in frame.values_mut().iter_mut().zip(&counts) {
                    *value = f64::from(count);
                }
                frame.sequence = link_stats.frames;
                frame.time_secs = Some(begun.elapsed().as_secs_f64());
                link_stats.frames += 1;
                receiver.frame(&frame, SystemTime::now());
            }
            Err(error) => {
                link_stats.corrupt += 1;
                if !std::mem::replace(&mut failed, true) {
                    receiver.state(State::Lost, &words(error, board));
                }
                std::thread::sleep(AGAIN);
            }
        }
        receiver.link_stats(link_stats);
    }
}
