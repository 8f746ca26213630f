//! Scanning on the device: lines selected through pins, one conversion after the other.
//!
//! For a microcontroller or a Linux board, over the traits of embedded-hal 1.0; no allocation, no standard library.
//! [`Scanner`] drives a column, waits until it has settled, and reads its rows: column-major, as the circuit settles
//! with the column. What comes out is row by row, as everywhere else.
//!
//! | part | in between |
//! |---|---|
//! | CD74HC4067, ADG732, ADG726, CD4051 and the like | [`Multiplexer`]: address pins |
//! | 74HC595 and other shift registers | [`ShiftRegister`]: data, clock, latch |
//! | an SPI converter (MCP3201, ADS7042, AD7940 …) | [`SpiConverter`] |
//! | a converter in the microcontroller | any `FnMut() -> Result<u16, _>` |

#[cfg(feature = "std")]
pub mod config;
mod converter;
#[cfg(feature = "rpi")]
pub mod rpi;
mod select;

pub use converter::{Converter, SpiConverter};
pub use select::{Multiplexer, Select, ShiftRegister};

use embedded_hal::delay::DelayNs;

/// How a scan is timed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Timing {
    /// Wait after another column is driven, nanoseconds.
    pub column_settling_ns: u32,
    /// Wait after another row is sensed, nanoseconds.
    pub row_settling_ns: u32,
    /// Conversions a reading is the mean of, at least 1.
    pub oversampling: u16,
}

impl Default for Timing {
    /// 20 µs a column, 10 µs a row, one conversion.
    fn default() -> Self {
        Self {
            column_settling_ns: 20_000,
            row_settling_ns: 10_000,
            oversampling: 1,
        }
    }
}

/// What failed during a scan: columns, rows, or the converter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum ScanError<C, R, A> {
    /// A column could not be selected.
    Column(C),
    /// A row could not be selected.
    Row(R),
    /// The converter did not answer.
    Converter(A),
    /// The buffer has another length than the array has taxels.
    Length {
        /// The buffer's.
        found: usize,
        /// Rows · columns.
        expected: usize,
    },
}

/// The failures of a scanner with these parts.
pub type ErrorOf<C, R, A> =
    ScanError<<C as Select>::Error, <R as Select>::Error, <A as Converter>::Error>;

/// Scans an array, frame after frame.
pub struct Scanner<C, R, A, D> {
    columns: C,
    rows: R,
    converter: A,
    delay: D,
    shape: (u16, u16),
    timing: Timing,
}

impl<C: Select, R: Select, A: Converter, D: DelayNs> Scanner<C, R, A, D> {
    /// `rows` sensed and `columns` driven lines.
    pub fn new(
        (rows, row_select): (u16, R),
        (columns, column_select): (u16, C),
        converter: A,
        delay: D,
        timing: Timing,
    ) -> Self {
        Self {
            columns: column_select,
            rows: row_select,
            converter,
            delay,
            shape: (rows, columns),
            timing,
        }
    }

    /// Rows and columns.
    pub fn shape(&self) -> (u16, u16) {
        self.shape
    }

    /// One frame: counts row by row, `rows · columns` of them.
    ///
    /// # Errors
    /// Whatever a part says, and a buffer of the wrong length. The frame is then not to be used.
    pub fn scan_into(&mut self, counts: &mut [u16]) -> Result<(), ErrorOf<C, R, A>> {
        let (rows, columns) = self.shape;
        let expected = usize::from(rows) * usize::from(columns);
        if counts.len() != expected {
            return Err(ScanError::Length {
                found: counts.len(),
                expected,
            });
        }
        let samples = u32::from(self.timing.oversampling.max(1));
        for column in 0..columns {
            self.columns.select(column).map_err(ScanError::Column)?;
            self.delay.delay_ns(self.timing.column_settling_ns);
            for row in 0..rows {
                self.rows.select(row).map_err(ScanError::Row)?;
                self.delay.delay_ns(self.timing.row_settling_ns);
                let mut sum = 0u32;
                for _ in 0..samples {
                    sum += u32::from(self.converter.convert().map_err(ScanError::Converter)?);
                }
                let at = usize::from(row) * usize::from(columns) + usize::from(column);
                counts[at] = ((sum + samples / 2) / samples) as u16;
            }
        }
        Ok(())
    }
}

#[cfg(all(test, feature = "std"))]
mod tests;
