//! How good a sensor is: the paper's experiments as pure functions over readings.
//!
//! Readings come grouped by *experiment*: what was set up once, and would have to be set up again to learn something
//! new. Ten frames of one press are one experiment. Every figure carries an interval that is bootstrapped over
//! experiments ([`Bootstrap`](crate::stats::Bootstrap)), never over frames, which would make it too narrow by the square root of their number.
//!
//! | module | the paper's | question |
//! |---|---|---|
//! | [`repeatability`] | Figs. 19 and 20, Table IV | does the same load read the same? |
//! | [`response`] | Figs. 24 and 25 | how does the reading follow the load, and where does it end? |
//! | [`hysteresis`] | | does it matter whether the load grew or fell? |
//! | [`creep`] | | does it matter how long the load has been there? |
//! | [`sweep`] | Figs. 28, 29 and 31 | what do other pressed taxels of the line do to one? |
//! | [`accuracy`] | section VII | how far are estimates from known loads? |
//!
//! Values may be counts, volts, siemens or grams: functions say which unit comes back.

pub mod accuracy;
pub mod creep;
pub mod hysteresis;
mod power;
pub mod repeatability;
pub mod response;
pub mod sweep;

pub use power::Power;

#[cfg(test)]
mod tests;
