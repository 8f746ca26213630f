//! The recorder alone: its end is answered, its death noticed, its numbers exact.

use super::*;
use taxel::Counts;
use taxel::sensor::preset;

struct Bed {
    recorder: Recorder,
    status: Arc<SessionStatus>,
    folder: tempfile::TempDir,
}

fn bed(wanted: RecordTopics) -> Bed {
    bed_of(QUEUE, wanted)
}

fn bed_of(queue: usize, wanted: RecordTopics) -> Bed {
    let status = Arc::new(SessionStatus::waiting("a test"));
    let about = About {
        sensor: preset("mat-16x16-cd4067").unwrap(),
        program: "test".to_owned(),
        source: "test".to_owned(),
    };
    Bed {
        recorder: Recorder::new(about, wanted, status.clone(), queue, true).unwrap(),
        status,
        folder: tempfile::tempdir().unwrap(),
    }
}

impl Bed {
    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

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

#[test]
fn the_end_is_answered_with_what_the_file_has() {
    let bed = bed(RecordTopics::default());
    let path = bed.path("a.mcap");
    bed.frames(0..3);
    bed.recorder
        .begin(path.clone(), Owner::Operator, None)
        .unwrap();
    bed.frames(3..103);
    let saved = bed.recorder.stop().unwrap();
    assert_eq!((saved.frames, saved.error.as_deref()), (100, None));
    // Whole: it can be taken away at once.
    let reader = taxel_io::McapReader::open_any(&path).unwrap();
    assert_eq!(reader.extent().unwrap().1, 100);
    assert!(bed.recorder.stop().is_none());
    assert_eq!(
        bed.status.take_messages(),
        [format!("{}: 100 frames", path.display())]
    );
    // The next one needs no waiting.
    bed.recorder
        .begin(bed.path("b.mcap"), Owner::Viewer, None)
        .unwrap();
    let twice = bed.recorder.begin(bed.path("c.mcap"), Owner::Viewer, None);
    assert!(matches!(twice, Err(Error::AlreadyRecording { .. })));
    assert!(!bed.path("c.mcap").exists());
    let taken = bed.recorder.stop().unwrap();
    assert_eq!(taken.frames, 0);
    // Nothing in it: it is in nobody's way.
    assert!(!bed.path("b.mcap").exists());
    let taken = bed.recorder.begin(path, Owner::Viewer, None);
    assert!(matches!(taken, Err(Error::RecordingExists { .. })));
}

#[test]
fn a_source_that_waits_loses_no_event_either() {
    let bed = bed_of(2, RecordTopics::default());
    bed.recorder
        .begin(bed.path("a.mcap"), Owner::Operator, None)
        .unwrap();
    for sequence in 0..300 {
        bed.frames(sequence..sequence + 1);
        bed.recorder.event("device", "nothing comes for a while");
    }
    let saved = bed.recorder.stop().unwrap();
    assert_eq!((saved.frames, saved.error.as_deref()), (300, None));
}

#[test]
fn no_more_frames_than_asked_for() {
    let bed = bed(RecordTopics::default());
    bed.recorder
        .begin(bed.path("a.mcap"), Owner::Operator, Some(7))
        .unwrap();
    bed.frames(0..200);
    assert_eq!(bed.recorder.stop().unwrap().frames, 7);
}

#[test]
fn a_recorder_that_dies_is_noticed_and_what_it_had_is_whole() {
    let bed = bed(RecordTopics::default());
    let path = bed.path("a.mcap");
    bed.recorder
        .begin(path.clone(), Owner::Operator, None)
        .unwrap();
    bed.frames(0..5);
    bed.recorder.items.send(Item::Panic).unwrap();
    // Whoever comes first: the source, the command line, the end.
    while bed.status.ended().is_empty() {
        bed.frames(5..6);
        bed.recorder.check();
    }
    bed.recorder.finish();
    let ended = bed.status.ended();
    assert_eq!(ended.len(), 1);
    let why = ended[0].error.clone().unwrap();
    assert!(why.contains("asked for by a test"), "{why}");
    assert!(bed.status.recording().unwrap().error.is_some());
    assert!(bed.status.take_messages()[0].starts_with("error: recording "));
    let refused = bed
        .recorder
        .begin(bed.path("b.mcap"), Owner::Operator, None);
    assert!(matches!(refused, Err(Error::RecorderGone)));
    let reader = taxel_io::McapReader::open_any(&path).unwrap();
    assert_eq!(reader.extent().unwrap().1, 5);
}

#[test]
fn loads_that_never_come_are_counted() {
    let bed = bed(RecordTopics {
        loads: false,
        figures: true,
        images: false,
    });
    bed.recorder
        .begin(bed.path("a.mcap"), Owner::Operator, None)
        .unwrap();
    bed.frames(10..20);
    // One of before, one that is no frame of it, and six of its ten.
    for sequence in [9, 99].into_iter().chain(10..16) {
        bed.solved(sequence);
    }
    let saved = bed.recorder.stop().unwrap();
    assert_eq!((saved.frames, saved.without_loads), (10, 4));
    assert!(
        saved.words().ends_with("10 frames; 4 without loads"),
        "{}",
        saved.words()
    );
    assert!(saved.for_viewers().starts_with("Saved "));
}

/// A disk that is too slow ends the recording, and what was in the queue is in the file.
#[test]
fn a_queue_that_is_full_ends_the_recording_with_what_it_holds() {
    let bed = bed(RecordTopics::default());
    bed.recorder
        .begin(bed.path("a.mcap"), Owner::Operator, None)
        .unwrap();
    bed.frames(0..3);
    assert!(bed.recorder.shared.go(Phase::Recording, Phase::Overrun));
    while bed.status.ended().is_empty() {
        std::thread::sleep(Duration::from_millis(1));
    }
    let ended = &bed.status.ended()[0];
    assert_eq!(ended.frames, 3);
    assert!(
        ended
            .error
            .as_ref()
            .unwrap()
            .contains("slower than the sensor")
    );
    bed.recorder
        .begin(bed.path("b.mcap"), Owner::Operator, None)
        .unwrap();
    bed.frames(3..5);
    assert_eq!(bed.recorder.stop().unwrap().frames, 2);
}

/// Whoever is first, the queue's end or a viewer: that frames were refused is said.
#[test]
fn a_stop_right_after_the_queue_was_full_says_so() {
    let bed = bed(RecordTopics::default());
    bed.recorder
        .begin(bed.path("a.mcap"), Owner::Operator, None)
        .unwrap();
    bed.frames(0..3);
    assert!(bed.recorder.shared.go(Phase::Recording, Phase::Overrun));
    if let Some(saved) = bed.recorder.stop() {
        assert!(saved.error.unwrap().contains("slower than the sensor"));
    }
    let ended = bed.status.ended();
    assert_eq!(ended.len(), 1);
    assert!(ended[0].error.is_some(), "{}", ended[0].words());
}

#[test]
fn a_stop_while_many_begin_and_end_is_always_answered() {
    let bed = bed(RecordTopics::default());
    std::thread::scope(|scope| {
        for thread in 0..3 {
            let bed = &bed;
            scope.spawn(move || {
                for turn in 0..30 {
                    let path = bed.path(&format!("{thread}-{turn}.mcap"));
                    if bed.recorder.begin(path, Owner::Viewer, None).is_ok() {
                        bed.frames(0..4);
                        bed.recorder.stop();
                    }
                }
            });
        }
    });
    bed.recorder
        .begin(bed.path("last.mcap"), Owner::Viewer, None)
        .unwrap();
    bed.frames(0..4);
    assert_eq!(bed.recorder.stop().unwrap().frames, 4);
}
