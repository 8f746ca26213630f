//! What a person does with a sensor: watch it live, record it, compensate a recording, evaluate it by a plan.
//!
//! It joins the mathematics (`taxel`) with devices, files, models, pictures and the viewer, and is what every door stands
//! on: the `taxel` command, a program of your own. It prints nothing and never ends the program: what is to be told goes
//! to a [`Reporter`], what fails comes back as an [`Error`].
//!
//! | module | what it does |
//! |---|---|
//! | [`session`] | from a source to viewers and a file, while it happens |
//! | [`evaluation`] | from a plan and its recordings to a report |
//! | [`batch`] | from an archive of recordings to loads, figures and one table |
//! | [`measure`] | from a recording to forces over time, trial by trial |
//! | [`grip`] | a grip session: one operator, one person, trial after trial, one page |
//! | [`guided`] | a guided calibration: which taxel to press with what, press after press, to a certificate |
//! | [`conversion`] | from a recording to files of numbers, on all cores |
//! | [`chain`] | from frames of a file to numbers in a unit, one frame at a time |
//! | [`frames`] | files of frames by their extension |
//! | [`sensor_source`] | the sensor of a source: of a file, a preset, or what a recording brings |
//! | [`identify`] | from recordings to the read-out that explains them |
//! | [`in_order`] | work that several threads share, its results in order |
//! | [`line_survey`], [`presses`], [`check`], [`training_set`] | what is read before the work: faulty lines, labelled presses, known loads of the day, what a model learns from |

pub mod batch;
pub mod calibration_age;
pub mod calibration_certificate;
pub mod calibration_picture;
pub mod carry;
pub mod chain;
pub mod check;
pub mod conversion;
pub mod error;
pub mod evaluation;
pub mod executor;
pub mod exported;
pub mod figures;
pub mod fingerprint;
#[cfg(feature = "foxglove")]
pub mod foxglove;
pub mod frames;
pub mod grip;
pub mod guided;
pub mod identify;
pub mod in_order;
pub mod json_line;
pub mod line_survey;
pub mod measure;
pub mod methods;
pub mod named_files;
pub mod presses;
pub mod reporter;
pub mod residuals;
pub mod sensor_source;
pub mod session;
mod session_folder;
pub mod simulated;
pub mod standard_error;
pub mod tare;
pub mod text_file;
mod ticker;
pub mod training_set;
pub mod units;

pub use error::{Error, remedy};
pub use reporter::{Reporter, Silent, Stage};
