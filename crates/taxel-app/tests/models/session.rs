//! What the files of the session see around them, and the models.

use std::sync::Arc;
use std::time::SystemTime;

use taxel::{Counts, Frame, Sensor};
use taxel_acquire::Address;

#[path = "../../src/session/latest_queue.rs"]
mod latest_queue;
#[path = "../../src/session/recorder/mod.rs"]
mod recorder;
#[path = "../../src/session/status.rs"]
mod status;
mod sync;

mod queue_model;
mod recorder_model;

/// As in the session.
#[derive(Clone)]
pub struct TimestampedFrame {
    frame: Arc<Frame<Counts>>,
    at: SystemTime,
    tare: Option<Option<Arc<taxel_io::Tare>>>,
}

/// What the recorder and the status ask of the session's options.
pub struct SessionOptions {
    sensor: Sensor,
    address: Address,
    topics: recorder::RecordTopics,
}
