//! A virtual instrument: pins and a converter whose voltages come from the exact circuit. The driver, unchanged, must
//! read what the circuit's scan predicts.

use std::cell::RefCell;
use std::convert::Infallible;
use std::rc::Rc;

use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{ErrorType, OutputPin};
use embedded_hal::spi::{self, Operation, SpiDevice};
use taxel::circuit::{Circuit, Converter as Counting, LinearCircuit};
use taxel::sensor::preset;
use taxel::simulate::Pattern;
use taxel::{Counts, Frame, Sensor, Siemens, material::LoadLaw};

use super::*;

/// The board: levels of its pins, and the array behind them.
struct Board {
    levels: Vec<bool>,
    /// Outputs of a shift register on the first three pins, shifted in and latched.
    shifted: Vec<bool>,
    latched: Vec<bool>,
    counts: Frame<Counts>,
    row_pins: std::ops::Range<usize>,
    column_pins: std::ops::Range<usize>,
    uses_register: bool,
    /// Time since the column changed, ns: readings before it has settled are wrong.
    since_column_ns: u64,
    settles_in_ns: u64,
    conversions: u64,
}

impl Board {
    fn number(&self, pins: &std::ops::Range<usize>) -> usize {
        pins.clone()
            .enumerate()
            .map(|(bit, pin)| usize::from(self.levels[pin]) << bit)
            .sum()
    }

    fn column(&self) -> usize {
        if self.uses_register {
            let high: Vec<usize> = (0..self.latched.len())
                .filter(|&output| self.latched[output])
                .collect();
            assert_eq!(high.len(), 1, "exactly one column is driven: {high:?}");
            high[0]
        } else {
            self.number(&self.column_pins)
        }
    }

    fn set(&mut self, pin: usize, high: bool) {
        let before = self.levels[pin];
        self.levels[pin] = high;
        if self.column_pins.contains(&pin) && before != high {
            self.since_column_ns = 0;
        }
        let rises = high && !before;
        match (self.uses_register, pin, rises) {
            (true, 1, true) => {
                self.shifted.rotate_right(1);
                self.shifted[0] = self.levels[0];
            }
            (true, 2, true) => self.latched.clone_from(&self.shifted),
            _ => {}
        }
    }

    fn convert(&mut self) -> u16 {
        self.conversions += 1;
        let settled = self.since_column_ns >= self.settles_in_ns;
        let (row, column) = (self.number(&self.row_pins), self.column());
        if settled {
            self.counts.at(row, column) as u16
        } else {
            0
        }
    }
}

#[derive(Clone)]
struct Pin {
    board: Rc<RefCell<Board>>,
    number: usize,
}

impl ErrorType for Pin {
    type Error = Infallible;
}

impl OutputPin for Pin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.board.borrow_mut().set(self.number, false);
        Ok(())
    }
    fn set_high(&mut self) -> Result<(), Infallible> {
        self.board.borrow_mut().set(self.number, true);
        Ok(())
    }
}

struct Clock(Rc<RefCell<Board>>);

impl DelayNs for Clock {
    fn delay_ns(&mut self, ns: u32) {
        self.0.borrow_mut().since_column_ns += u64::from(ns);
    }
}

/// A 16-bit converter on SPI with two bits of zeros before its 12.
struct Spi(Rc<RefCell<Board>>);

impl spi::ErrorType for Spi {
    type Error = spi::ErrorKind;
}

impl SpiDevice for Spi {
    fn transaction(&mut self, operations: &mut [Operation<u8>]) -> Result<(), spi::ErrorKind> {
        for operation in operations {
            let Operation::Read(bytes) = operation else {
                return Err(spi::ErrorKind::Other);
            };
            let count = self.0.borrow_mut().convert();
            bytes.copy_from_slice(&(count << 2).to_be_bytes());
        }
        Ok(())
    }
}

/// What the circuit's own scan predicts, in counts.
fn predicted(sensor: &Sensor) -> Frame<Counts> {
    let law = LoadLaw::from_sensor(sensor).unwrap();
    let loads = Pattern::hand().loads(sensor.array(), 3, 80);
    let siemens: Frame<Siemens> = loads.map(|taxel, grams| law.siemens_from_grams(taxel, grams));
    let volts = LinearCircuit::from_sensor(sensor)
        .unwrap()
        .predict(&siemens)
        .unwrap();
    Counting::from_sensor(sensor).counts_from_volts(&volts)
}

fn board(sensor: &Sensor, uses_register: bool) -> Rc<RefCell<Board>> {
    let bits = |lines: usize| lines.next_power_of_two().trailing_zeros() as usize;
    let rows = 3..3 + bits(sensor.rows());
    let columns = rows.end..rows.end + bits(sensor.columns());
    Rc::new(RefCell::new(Board {
        levels: vec![false; columns.end],
        shifted: vec![false; sensor.columns()],
        latched: vec![false; sensor.columns()],
        counts: predicted(sensor),
        row_pins: rows,
        column_pins: columns,
        uses_register,
        since_column_ns: 0,
        settles_in_ns: 15_000,
        conversions: 0,
    }))
}

fn pins<const PINS: usize>(board: &Rc<RefCell<Board>>, first: usize) -> [Pin; PINS] {
    std::array::from_fn(|bit| Pin {
        board: board.clone(),
        number: first + bit,
    })
}

fn whole(sensor: &Sensor) -> Vec<u16> {
    predicted(sensor)
        .values()
        .iter()
        .map(|&count| count as u16)
        .collect()
}

#[test]
fn a_mat_through_two_multiplexers_reads_as_the_circuit_predicts() {
    let sensor = preset("mat-16x16-cd4067").unwrap();
    let board = board(&sensor, false);
    let inside = board.clone();
    let mut scanner = Scanner::new(
        (16, Multiplexer::new(pins::<4>(&board, 3))),
        (16, Multiplexer::new(pins::<4>(&board, 7))),
        move || Ok::<u16, Infallible>(inside.borrow_mut().convert()),
        Clock(board.clone()),
        Timing {
            oversampling: 3,
            ..Timing::default()
        },
    );
    let mut counts = [0; 256];
    scanner.scan_into(&mut counts).unwrap();
    assert_eq!(counts.to_vec(), whole(&sensor));
    assert!(counts.iter().any(|count| *count > 100));
    assert_eq!(board.borrow().conversions, 3 * 256);
    assert!(matches!(
        scanner.scan_into(&mut [0; 9]),
        Err(ScanError::Length {
            found: 9,
            expected: 256
        })
    ));
}

#[test]
fn the_e_cone_through_shift_registers_and_spi_reads_as_the_circuit_predicts() {
    let mut sensor = preset("econe").unwrap();
    sensor = sensor
        .edited(|spec| {
            spec.converter.bits = 12;
        })
        .unwrap();
    let board = board(&sensor, true);
    let [data, clock, latch] = pins::<3>(&board, 0);
    let mut scanner = Scanner::new(
        (64, Multiplexer::new(pins::<6>(&board, 3))),
        (128, ShiftRegister::new(data, clock, latch, 128)),
        SpiConverter::new(Spi(board.clone()), 2, 12),
        Clock(board.clone()),
        Timing::default(),
    );
    let mut counts = vec![0; 64 * 128];
    for _ in 0..2 {
        counts.fill(0);
        scanner.scan_into(&mut counts).unwrap();
        assert_eq!(counts, whole(&sensor));
    }
}

#[test]
fn a_column_that_has_not_settled_reads_wrong_and_wiring_is_undone() {
    let sensor = preset("mat-16x16-cd4067").unwrap();
    let board = board(&sensor, false);
    let wiring: Vec<u16> = (0..16).rev().collect();
    let read = |timing| {
        let inside = board.clone();
        let mut scanner = Scanner::new(
            (16, Multiplexer::wired(pins::<4>(&board, 3), &wiring)),
            (16, Multiplexer::new(pins::<4>(&board, 7))),
            move || Ok::<u16, Infallible>(inside.borrow_mut().convert()),
            Clock(board.clone()),
            timing,
        );
        let mut counts = [0; 256];
        scanner.scan_into(&mut counts).unwrap();
        counts.to_vec()
    };
    let expected: Vec<u16> = whole(&sensor).chunks(16).rev().flatten().copied().collect();
    assert_eq!(read(Timing::default()), expected);
    let hasty = read(Timing {
        column_settling_ns: 100,
        row_settling_ns: 100,
        oversampling: 1,
    });
    assert_ne!(hasty, expected);
}
