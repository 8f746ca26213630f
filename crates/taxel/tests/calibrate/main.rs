//! Fits of simulated sensors: one program, so that long ones run beside each other.

#[path = "../every_sensor/mod.rs"]
mod every_sensor;

mod alone;
mod lines;
mod presses;
mod readouts;
mod sheet;
mod totals;
mod uniform;
