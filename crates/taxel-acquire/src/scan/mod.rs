//! Scanning on the device: comes with the firmware.
