//! One file a verb, each with `run(args) -> Result<Exit, Error>`.

mod access;
pub(crate) mod analyse;
pub(crate) mod batch;
pub(crate) mod bench;
pub(crate) mod budget;
pub(crate) mod calibrate;
pub(crate) mod check;
pub(crate) mod compare;
pub(crate) mod compensate;
pub(crate) mod completions;
pub(crate) mod convert;
pub(crate) mod crosstalk;
pub(crate) mod dataset;
pub(crate) mod demo;
pub(crate) mod design;
pub(crate) mod devices;
pub(crate) mod evaluate;
pub(crate) mod grip;
pub(crate) mod identify;
pub(crate) mod info;
pub(crate) mod live;
#[cfg(feature = "manual")]
pub(crate) mod manual;
pub(crate) mod measure;
pub(crate) mod model;
pub(crate) mod netlist;
pub(crate) mod plot;
mod positive;
pub(crate) mod record;
pub(crate) mod recover;
pub(crate) mod replay;
pub(crate) mod report;
pub(crate) mod rig;
pub(crate) mod selftest;
pub(crate) mod simulate;
mod taxel_address;
pub(crate) mod train;
