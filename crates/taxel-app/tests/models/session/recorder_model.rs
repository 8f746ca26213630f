//! The recorder: no frame is lost without a word, every end is answered, every recording is told of once.
//!
//! In shuttle no time passes: a wait with a limit is one without. What only the clock would end would show as a deadlock.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::SystemTime;

use shuttle::scheduler::{PctScheduler, RandomScheduler};
use shuttle::thread;
use shuttle::{Config, Runner};
use taxel::metric::FrameFigures;
use taxel::sensor::preset;
use taxel::{Counts, Frame};
use taxel_io::mcap::About;

use super::TimestampedFrame;
use super::recorder::{Owner, RecordTopics, Recorder, SolvedFrame};
use super::status::SessionStatus;

/// Short, so that it is often full.
const QUEUE: usize = 2;
/// Each writes files.
const SCHEDULES: usize = 400;

struct Bed {
    recorder: Recorder,
    status: Arc<SessionStatus>,
    folder: tempfile::TempDir,
}

impl Bed {
    fn new(wanted: RecordTopics) -> Arc<Self> {
        let status = Arc::new(SessionStatus::waiting("a model"));
        let about = About {
            sensor: preset("mat-16x16-cd4067").unwrap(),
            program: "model".to_owned(),
            source: "model".to_owned(),
        };
        Arc::new(Self {
            recorder: Recorder::new(about, wanted, status.clone(), QUEUE, false).unwrap(),
            status,
            folder: tempfile::tempdir().unwrap(),
        })
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// A device that never waits.
    fn frames(&self, sequences: std::ops::Range<u64>) {
        for sequence in sequences {
            let mut frame = Frame::<Counts>::zeros(16, 16);
            frame.sequence = sequence;
            self.recorder.counts(&TimestampedFrame {
                frame: Arc::new(frame),
                at: SystemTime::now(),
                tare: None,
            });
        }
    }

    fn solved(&self, sequence: u64) {
        let solved = SolvedFrame {
            loads: None,
            figures: FrameFigures::default(),
            sequence,
            at: SystemTime::now(),
        };
        self.recorder.solved(solved, true);
    }
}

fn check(model: impl Fn() + Send + Sync + Copy + 'static) {
    let config = || {
        let mut config = Config::new();
        // Files are written on the models' own stacks.
        config.stack_size = 1 << 20;
        config
    };
    Runner::new(RandomScheduler::new(SCHEDULES), config()).run(model);
    Runner::new(PctScheduler::new(3, SCHEDULES), config()).run(model);
}

#[test]
fn all_frames_are_in_the_file_or_it_says_why_not() {
    check(|| {
        let bed = Bed::new(RecordTopics::default());
        let path = bed.path("a.mcap");
        bed.recorder.begin(path, Owner::Operator, None).unwrap();
        let source = bed.clone();
        let source = thread::spawn(move || source.frames(0..6));
        source.join().unwrap();
        bed.recorder.stop();
        bed.recorder.finish();
        let ended = bed.status.ended();
        assert_eq!(ended.len(), 1);
        assert!(
            ended[0].frames == 6 || ended[0].error.is_some(),
            "{}",
            ended[0].words()
        );
    });
}

#[test]
fn every_end_is_answered_and_every_recording_told_of_once() {
    check(|| {
        let bed = Bed::new(RecordTopics::default());
        let viewers = ["a", "b"].map(|name| {
            let bed = bed.clone();
            thread::spawn(move || {
                let path = bed.path(name).with_extension("mcap");
                let begun = bed.recorder.begin(path, Owner::Viewer, None).is_ok();
                bed.recorder.stop();
                usize::from(begun)
            })
        });
        let source = bed.clone();
        let source = thread::spawn(move || source.frames(0..4));
        let begun: usize = viewers.map(|viewer| viewer.join().unwrap()).iter().sum();
        source.join().unwrap();
        bed.recorder.finish();
        assert!(begun >= 1);
        assert_eq!(bed.status.ended().len(), begun);
    });
}

/// The command line ends the session while a viewer ends the recording.
#[test]
#[ignore = "shuttle's channel keeps what nobody received when its receiver goes, std's drops it and so answers who waits"]
fn an_end_beside_the_session_s_end_waits_for_nobody() {
    check(|| {
        let bed = Bed::new(RecordTopics::default());
        let path = bed.path("a.mcap");
        bed.recorder.begin(path, Owner::Viewer, None).unwrap();
        let viewer = bed.clone();
        let viewer = thread::spawn(move || viewer.recorder.stop());
        bed.frames(0..2);
        bed.recorder.finish();
        viewer.join().unwrap();
        assert_eq!(bed.status.ended().len(), 1);
    });
}

/// Loads come from the engine, after their frames, and the end waits for those that are on their way.
#[test]
fn the_loads_of_every_frame_are_waited_for() {
    check(|| {
        let bed = Bed::new(RecordTopics {
            loads: false,
            figures: true,
            images: false,
        });
        let path = bed.path("a.mcap");
        bed.recorder.begin(path, Owner::Operator, None).unwrap();
        bed.frames(0..QUEUE as u64);
        let engine = bed.clone();
        let engine = thread::spawn(move || (0..QUEUE as u64).for_each(|i| engine.solved(i)));
        let saved = bed.recorder.stop();
        engine.join().unwrap();
        bed.recorder.finish();
        let ended = bed.status.ended();
        assert_eq!(ended.len(), 1);
        assert!(saved.is_some() || ended[0].error.is_some());
        assert!(ended[0].without_loads == 0 || ended[0].error.is_some());
    });
}
