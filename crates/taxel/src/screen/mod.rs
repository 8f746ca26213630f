//! Which readings cannot be trusted: found, marked and counted, never silently repaired.
//!
//! Three questions, three parts:
//!
//! - [`LevelScreen`]: what does an unloaded taxel read (baseline), and how much does it vary (noise)?
//! - [`LineScreen`]: over a recording, which rows and columns are dead, come and go, or are shorted together?
//!   [`LineEvidence`] is what one frame tells of that.
//! - [`FrameScreen`]: in this frame, which single readings are stuck or saturated, and which lines dropped out?
//!
//! All state is of constant size, whatever the length of the recording; a frame allocates nothing.
//! [`repair`] replaces marked values where that is asked for, and says so in the mark.
//!
//! ```
//! use taxel::screen::{FrameScreen, LineScreen, ScreenOptions, ScreenReport};
//! use taxel::{Counts, Frame, Mark};
//!
//! // Two frames of a 16-bit 8 x 8 array, unloaded (25 counts); row 3 is dead.
//! let mut recording = vec![Frame::<Counts>::filled(8, 8, 25.0); 2];
//! for frame in &mut recording {
//!     frame.values_mut()[3 * 8..4 * 8].fill(0.0);
//! }
//! let options = ScreenOptions::default();
//! let mut lines = LineScreen::new(8, 8, 65_535.0, &options);
//! for frame in &recording {
//!     lines.observe(frame)?;
//! }
//! let faults = lines.finish();
//! assert_eq!(faults.dead_rows().collect::<Vec<_>>(), [3]);
//!
//! let mut screen = FrameScreen::new(8, 8, 65_535.0, &options);
//! screen.set_lines(&faults);
//! let mut report = ScreenReport::new(faults);
//! for frame in &mut recording {
//!     screen.mark(frame)?;
//!     report.add(frame);
//! }
//! assert_eq!(report.count(Mark::Open), 16);
//! # Ok::<(), taxel::Error>(())
//! ```

mod axis;
mod end;
mod evidence;
mod fault;
mod frame;
mod histogram;
mod level;
mod line;
mod line_state;
mod mask;
mod options;
mod repair;
mod report;
mod short;
mod spike;
mod suspect;
mod tally;
mod together;

pub use axis::Axis;
pub(crate) use end::LowerEnd;
pub use evidence::LineEvidence;
pub use fault::{LineFault, LineFaultKind, LineFaults};
pub use frame::FrameScreen;
pub use level::{Level, LevelScreen};
pub use line::LineScreen;
pub use mask::{CountsMask, MaskCount};
pub use options::{ScreenOptions, SpaceSpikes, TimeSpikes};
pub use repair::{Surroundings, repair, repair_readings};
pub(crate) use repair::{fill, stand_in};
pub use report::ScreenReport;
pub use spike::TimeSpikeScreen;

use crate::{Error, Frame};

/// Refuses a frame of another shape than the screen was made for.
fn check_shape<Q>(
    what: &'static str,
    rows: usize,
    columns: usize,
    frame: &Frame<Q>,
) -> Result<(), Error> {
    if frame.rows() == rows && frame.columns() == columns {
        return Ok(());
    }
    Err(Error::Shape {
        what,
        expected: rows * columns,
        found: frame.values().len(),
        rows,
        columns,
    })
}
