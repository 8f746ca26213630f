//! How a board is wired, as TOML: what the module `rpi` scans by.
//!
//! ```toml
//! [rows]                              # sensed lines
//! count = 64
//! address_pins = [17, 27, 22, 5, 6, 13]   # lowest bit first
//!
//! [columns]                           # driven lines
//! count = 128
//! register_pins = { data = 16, clock = 20, latch = 21 }
//! # wiring = [3, 2, 1, 0]             # input of line 0, 1, …; for multiplexers
//!
//! [converter]
//! spi = "/dev/spidev0.0"
//! clock_hz = 2000000
//! leading_zeros = 0
//! bits = 16
//!
//! [timing]
//! column_settling_us = 20.0
//! row_settling_us = 10.0
//! oversampling = 1
//! ```

use std::vec::Vec;

use serde::Deserialize;

use super::Timing;

/// A board.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Board {
    /// The chip that the pins are of.
    #[serde(default = "first_chip")]
    pub gpio: std::string::String,
    /// Sensed lines.
    pub rows: Lines,
    /// Driven lines.
    pub columns: Lines,
    /// The converter.
    pub converter: Spi,
    /// Waits.
    #[serde(default)]
    pub timing: Waits,
}

fn first_chip() -> std::string::String {
    "/dev/gpiochip0".into()
}

/// Lines and how one of them is selected: by address pins or by a shift register.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lines {
    /// How many.
    pub count: u16,
    /// A multiplexer's address, lowest bit first.
    pub address_pins: Option<Vec<u32>>,
    /// A shift register.
    pub register_pins: Option<RegisterPins>,
    /// The multiplexer's input of every line, where they are not in order.
    #[serde(default)]
    pub wiring: Vec<u16>,
}

/// Pins of a shift register.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RegisterPins {
    /// Serial data.
    pub data: u32,
    /// Shift clock.
    pub clock: u32,
    /// Output latch.
    pub latch: u32,
}

/// A converter on SPI.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spi {
    /// The device.
    pub spi: std::string::String,
    /// Hertz.
    pub clock_hz: u32,
    /// Bits before the count.
    #[serde(default)]
    pub leading_zeros: u8,
    /// Bits of the count.
    pub bits: u8,
}

/// Waits during a scan.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Waits {
    /// After another column is driven, µs.
    pub column_settling_us: f64,
    /// After another row is sensed, µs.
    pub row_settling_us: f64,
    /// Conversions a reading is the mean of.
    pub oversampling: u16,
}

impl Default for Waits {
    fn default() -> Self {
        let timing = Timing::default();
        Self {
            column_settling_us: f64::from(timing.column_settling_ns) / 1e3,
            row_settling_us: f64::from(timing.row_settling_ns) / 1e3,
            oversampling: timing.oversampling,
        }
    }
}

impl From<Waits> for Timing {
    fn from(waits: Waits) -> Self {
        Self {
            column_settling_ns: (1e3 * waits.column_settling_us) as u32,
            row_settling_ns: (1e3 * waits.row_settling_us) as u32,
            oversampling: waits.oversampling,
        }
    }
}

/// Why a text describes no board.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BadBoard(std::string::String);

impl core::fmt::Display for BadBoard {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(&self.0)
    }
}

impl core::error::Error for BadBoard {}

impl Board {
    /// Reads and checks a board's description.
    ///
    /// # Errors
    /// What is wrong, with the line where TOML has one.
    pub fn from_toml(text: &str) -> Result<Self, BadBoard> {
        Self::parse(text).map_err(BadBoard)
    }

    fn parse(text: &str) -> Result<Self, std::string::String> {
        let board: Self = toml::from_str(text).map_err(|error| std::format!("{error}"))?;
        for (name, lines) in [("rows", &board.rows), ("columns", &board.columns)] {
            lines.check(name)?;
        }
        if !(1..=16).contains(&board.converter.bits) {
            return Err(std::format!(
                "converter.bits: {}, expected 1 to 16",
                board.converter.bits
            ));
        }
        let waits = &board.timing;
        let sound = |us: f64| (0.0..=1e6).contains(&us);
        if !(sound(waits.column_settling_us) && sound(waits.row_settling_us)) {
            return Err("timing: settling times from 0 to 1000000 µs".into());
        }
        Ok(board)
    }
}

impl Lines {
    fn check(&self, name: &str) -> Result<(), std::string::String> {
        if self.count == 0 {
            return Err(std::format!("{name}.count: 0, expected at least 1"));
        }
        let inputs = match (&self.address_pins, &self.register_pins) {
            (Some(pins), None) if pins.len() <= 16 => 1u32 << pins.len(),
            (None, Some(_)) => u32::from(self.count),
            _ => {
                return Err(std::format!(
                    "{name}: either address_pins (at most 16) or register_pins"
                ));
            }
        };
        if inputs < u32::from(self.count) {
            return Err(std::format!(
                "{name}.address_pins select {inputs} lines, but there are {}",
                self.count
            ));
        }
        let wrong = self
            .wiring
            .iter()
            .find(|input| u32::from(**input) >= inputs);
        if let Some(wrong) = wrong {
            return Err(std::format!(
                "{name}.wiring: input {wrong}, but the last is {}",
                inputs - 1
            ));
        }
        if !self.wiring.is_empty() && self.wiring.len() != usize::from(self.count) {
            return Err(std::format!(
                "{name}.wiring has {} inputs, but there are {} lines",
                self.wiring.len(),
                self.count
            ));
        }
        Ok(())
    }
}
