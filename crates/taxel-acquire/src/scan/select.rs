//! One line out of many: address pins, shift registers.

use core::marker::PhantomData;

use embedded_hal::digital::OutputPin;

/// Connects one line of many.
pub trait Select {
    /// What can go wrong.
    type Error;

    /// Connects line `line`, and no other.
    ///
    /// # Errors
    /// Whatever the pins say.
    fn select(&mut self, line: u16) -> Result<(), Self::Error>;
}

/// The level of each address pin of a multiplexer, lowest bit first, that selects a line: at input `wiring[line]`, or at its own
/// number beyond the table.
pub(super) fn address(wiring: &[u16], line: u16) -> impl Fn(usize) -> bool {
    let input = wiring.get(usize::from(line)).copied().unwrap_or(line);
    move |bit| input >> bit & 1 == 1
}

/// A multiplexer with address pins, lowest bit first. Lines need not be wired in order: a table says which input of
/// the multiplexer a line is at.
///
/// `S` holds the pins and `W` the table: arrays on a microcontroller, vectors elsewhere.
pub struct Multiplexer<P, S, W = [u16; 0]> {
    pins: S,
    wiring: W,
    pin: PhantomData<P>,
}

impl<P: OutputPin, S: AsMut<[P]>> Multiplexer<P, S> {
    /// Line k at input k.
    pub fn new(pins: S) -> Self {
        Self::wired(pins, [])
    }
}

impl<P: OutputPin, S: AsMut<[P]>, W: AsRef<[u16]>> Multiplexer<P, S, W> {
    /// Line k at input `wiring[k]`; lines beyond the table at their own number.
    pub fn wired(pins: S, wiring: W) -> Self {
        Self {
            pins,
            wiring,
            pin: PhantomData,
        }
    }
}

impl<P: OutputPin, S: AsMut<[P]>, W: AsRef<[u16]>> Select for Multiplexer<P, S, W> {
    type Error = P::Error;

    fn select(&mut self, line: u16) -> Result<(), P::Error> {
        let is_high = address(self.wiring.as_ref(), line);
        for (bit, pin) in self.pins.as_mut().iter_mut().enumerate() {
            pin.set_state(is_high(bit).into())?;
        }
        Ok(())
    }
}

/// A chain of shift registers with one output high: data, shift clock, latch. Line 0 is the output nearest to the
/// data pin.
pub struct ShiftRegister<P> {
    data: P,
    clock: P,
    latch: P,
    outputs: u16,
    at: Option<u16>,
}

impl<P: OutputPin> ShiftRegister<P> {
    /// `outputs`: of the whole chain.
    pub fn new(data: P, clock: P, latch: P, outputs: u16) -> Self {
        Self {
            data,
            clock,
            latch,
            outputs,
            at: None,
        }
    }

    fn shift(&mut self, high: bool) -> Result<(), P::Error> {
        self.data.set_state(high.into())?;
        self.clock.set_high()?;
        self.clock.set_low()
    }
}

impl<P: OutputPin> Select for ShiftRegister<P> {
    type Error = P::Error;

    fn select(&mut self, line: u16) -> Result<(), P::Error> {
        self.latch.set_low()?;
        match self.at {
            // The bit that is in the chain moves on by one; no other step needs so few pulses.
            Some(at) if at + 1 == line => self.shift(false)?,
            _ => {
                for output in (0..self.outputs).rev() {
                    self.shift(output == line)?;
                }
            }
        }
        self.at = Some(line);
        self.latch.set_high()
    }
}
