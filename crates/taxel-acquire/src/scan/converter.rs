//! From a voltage to a count.

use embedded_hal::spi::SpiDevice;

/// Converts what is connected now.
pub trait Converter {
    /// What can go wrong.
    type Error;

    /// One conversion, counts.
    ///
    /// # Errors
    /// Whatever the converter says.
    fn convert(&mut self) -> Result<u16, Self::Error>;
}

/// A converter inside the microcontroller.
impl<E, F: FnMut() -> Result<u16, E>> Converter for F {
    type Error = E;

    fn convert(&mut self) -> Result<u16, E> {
        self()
    }
}

/// A converter on SPI that sends its count in two bytes, highest bit first, while it is selected.
pub struct SpiConverter<S> {
    device: S,
    /// Bits below the count's lowest: 16 − leading zeros − bits.
    below: u8,
    mask: u16,
}

impl<S: SpiDevice> SpiConverter<S> {
    /// `leading_zeros` bits before the count, which has `bits`; what is behind it is thrown away.
    pub fn new(device: S, leading_zeros: u8, bits: u8) -> Self {
        let bits = bits.clamp(1, 16);
        Self {
            device,
            below: 16u8.saturating_sub(leading_zeros).saturating_sub(bits),
            mask: ((1u32 << bits) - 1) as u16,
        }
    }
}

impl<S: SpiDevice> Converter for SpiConverter<S> {
    type Error = S::Error;

    fn convert(&mut self) -> Result<u16, S::Error> {
        let mut bytes = [0; 2];
        self.device.read(&mut bytes)?;
        Ok(u16::from_be_bytes(bytes) >> self.below & self.mask)
    }
}
