#![cfg_attr(feature = "std", doc = include_str!("../README.md"))]
#![cfg_attr(
    not(feature = "std"),
    doc = "From hardware to frames of counts: scanning on the device itself."
)]
//!
//! # Modules, in reading order
//!
//! | module | from → to |
//! |---|---|
//! | [`scan`] | pins and converter → counts, on the device itself (`no_std`, embedded-hal) |
//! | [`protocol`] | bytes → frames, without input or output |
//! | [`transport`] | serial port, UDP, TCP, standard input → bytes; broken links are opened again |
//! | [`address`] | `serial:/dev/ttyACM0?baud=2000000`, `udp:0.0.0.0:9000`, `sim:econe?hand` … |
//! | [`simulated`] | a virtual sensor that scans in real time, with parameters to turn |
#![cfg_attr(not(feature = "std"), no_std)]

#[cfg(feature = "std")]
pub mod address;
#[cfg(feature = "std")]
mod error;
#[cfg(feature = "std")]
mod permission;
#[cfg(feature = "std")]
pub mod protocol;
pub mod scan;
#[cfg(feature = "std")]
pub mod simulated;
#[cfg(feature = "std")]
pub mod transport;

#[cfg(feature = "std")]
pub use address::Address;
#[cfg(feature = "std")]
pub use error::Error;
