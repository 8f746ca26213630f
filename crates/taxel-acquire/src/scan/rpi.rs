//! A Raspberry Pi, or any Linux board with GPIO and SPI devices, as a source: the scanner on `linux-embedded-hal`.

use std::time::SystemTime;

use linux_embedded_hal::gpio_cdev::{Chip, LineRequestFlags};
use linux_embedded_hal::spidev::SpidevOptions;
use linux_embedded_hal::{CdevPin, Delay, SpidevDevice};
use taxel::{Counts, Frame};

use super::config::{Board, Lines};
use super::{Multiplexer, Scanner, Select, ShiftRegister, SpiConverter};
use crate::protocol::LinkStats;
use crate::transport::{Receiver, State};

/// A board's way to select one line.
enum Selector {
    Multiplexer(Multiplexer<CdevPin, Vec<CdevPin>, Vec<u16>>),
    Register(Box<ShiftRegister<CdevPin>>),
}

impl Select for Selector {
    type Error = linux_embedded_hal::CdevPinError;

    fn select(&mut self, line: u16) -> Result<(), Self::Error> {
        match self {
            Selector::Multiplexer(multiplexer) => multiplexer.select(line),
            Selector::Register(register) => register.select(line),
        }
    }
}

type Parts = Scanner<Selector, Selector, SpiConverter<SpidevDevice>, Delay>;

fn open(board: &Board) -> Result<Parts, String> {
    let mut chip = Chip::new(&board.gpio).map_err(|error| format!("{}: {error}", board.gpio))?;
    let mut pin = |number: u32| -> Result<CdevPin, String> {
        let failed = |error| format!("pin {number} of {}: {error}", board.gpio);
        let line = chip.get_line(number).map_err(failed)?;
        let handle = line
            .request(LineRequestFlags::OUTPUT, 0, "taxel")
            .map_err(failed)?;
        CdevPin::new(handle).map_err(failed)
    };
    let mut selector = |lines: &Lines| -> Result<Selector, String> {
        Ok(match (&lines.address_pins, lines.register_pins) {
            (_, Some(pins)) => Selector::Register(Box::new(ShiftRegister::new(
                pin(pins.data)?,
                pin(pins.clock)?,
                pin(pins.latch)?,
                lines.count,
            ))),
            (Some(pins), None) => {
                let pins: Result<Vec<CdevPin>, String> = pins.iter().map(|&n| pin(n)).collect();
                Selector::Multiplexer(Multiplexer::wired(pins?, lines.wiring.clone()))
            }
            (None, None) => return Err("a board without pins".to_owned()),
        })
    };
    let rows = (board.rows.count, selector(&board.rows)?);
    let columns = (board.columns.count, selector(&board.columns)?);
    let failed = |error: &dyn std::fmt::Display| format!("{}: {error}", board.converter.spi);
    let mut device = SpidevDevice::open(&board.converter.spi).map_err(|e| failed(&e))?;
    let options = SpidevOptions::new()
        .max_speed_hz(board.converter.clock_hz)
        .build();
    device.configure(&options).map_err(|error| failed(&error))?;
    let converter = SpiConverter::new(device, board.converter.leading_zeros, board.converter.bits);
    Ok(Scanner::new(
        rows,
        columns,
        converter,
        Delay,
        board.timing.into(),
    ))
}

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
    let begun = std::time::Instant::now();
    receiver.state(State::Live, "scanning");
    while !receiver.stopped() {
        match scanner.scan_into(&mut counts) {
            Ok(()) => {
                for (value, &count) in frame.values_mut().iter_mut().zip(&counts) {
                    *value = f64::from(count);
                }
                frame.sequence = link_stats.frames;
                frame.time_secs = Some(begun.elapsed().as_secs_f64());
                link_stats.frames += 1;
                receiver.frame(&frame, SystemTime::now());
            }
            Err(_) => link_stats.corrupt += 1,
        }
        receiver.link_stats(link_stats);
    }
}
