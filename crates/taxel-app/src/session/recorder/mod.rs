//! The thread that writes: it never drops a frame, and never holds up who reads them.
//!
//! Everything goes to it through one bounded queue, in order: frames, loads, events, the beginning and the end of a
//! recording. The end is answered when the file is closed, however long the disk takes.

mod file;
mod shared;

use std::path::PathBuf;
use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant, SystemTime};

use taxel::metric::FrameFigures;
use taxel::{Frame, Newtons};
use taxel_io::mcap::About;
use taxel_io::{McapWriter, Tare};

use super::status::{Recording, SessionStatus};
use super::sync::{
    AtomicU8, Builder, JoinHandle, Mutex, Receiver, RecvTimeoutError, Sender, SyncSender,
    TrySendError, channel, sync_channel, unit_tests,
};
use super::{SessionOptions, TimestampedFrame};
use crate::error::Error;
use file::Open;
pub use file::{Owner, SavedRecording};
use shared::{Phase, Shared};

/// What is recorded beside the counts.
#[derive(Debug, Clone, Copy, Default)]
pub struct RecordTopics {
    /// Compensated loads.
    pub loads: bool,
    /// Total force and the like.
    pub figures: bool,
    /// With the loads, images and wrenches that other programs know.
    pub images: bool,
}

impl RecordTopics {
    pub(super) fn any(self) -> bool {
        self.loads || self.figures
    }
}

/// Items that may wait for the disk: five seconds at 100 frames a second.
const QUEUE: usize = 512;
/// How often it looks around while nothing comes.
const LOOK: Duration = Duration::from_millis(100);
/// At the end of a recording, loads that come no more are not waited for after this silence.
const LOADS_WITHIN: Duration = Duration::from_secs(1);

enum Item {
    Begin(Box<Open>),
    Counts(TimestampedFrame),
    SolvedFrame(Box<SolvedFrame>),
    Event(&'static str, String, SystemTime),
    Tare(Box<Tare>),
    /// End the recording; the answer comes when the file is closed.
    Stop(Sender<Option<SavedRecording>>),
    /// The same, and the thread ends too: no loads are on their way any more.
    Finish,
    #[cfg(test)]
    Panic,
}

/// Loads and figures of a frame.
pub(super) struct SolvedFrame {
    pub(super) loads: Option<Frame<Newtons>>,
    pub(super) figures: FrameFigures,
    pub(super) sequence: u64,
    pub(super) at: SystemTime,
}

/// The recorder's near end.
pub(super) struct Recorder {
    items: SyncSender<Item>,
    shared: Arc<Shared>,
    /// Held while a recording is begun or ended: one at a time.
    control: Mutex<()>,
    about: About,
    wanted: RecordTopics,
    /// The source holds what the disk has no time for: all that is recorded of it waits, none is lost.
    waits: bool,
    thread: Mutex<Option<JoinHandle<()>>>,
}

impl Recorder {
    pub(super) fn start(
        options: &SessionOptions,
        status: Arc<SessionStatus>,
        waits: bool,
    ) -> Result<Self, Error> {
        let about = About {
            sensor: options.sensor.clone(),
            program: format!("taxel {}", env!("CARGO_PKG_VERSION")),
            source: options.address.to_string(),
        };
        Self::new(about, options.topics, status, QUEUE, waits)
    }

    pub(super) fn new(
        about: About,
        wanted: RecordTopics,
        status: Arc<SessionStatus>,
        queue: usize,
        waits: bool,
    ) -> Result<Self, Error> {
        let (items, received) = sync_channel(queue);
        let shared = Arc::new(Shared {
            phase: AtomicU8::new(Phase::Idle as u8),
            status,
            tare: Mutex::new(None),
        });
        let with = shared.clone();
        let thread = Builder::new()
            .name("recorder".to_owned())
            .spawn(move || Writing::new(&with).run(&received))
            .map_err(Error::Thread)?;
        Ok(Self {
            items,
            shared,
            control: Mutex::new(()),
            about,
            wanted,
            waits,
            thread: Mutex::new(Some(thread)),
        })
    }

    /// Begins a file of at most `most` frames.
    pub(super) fn begin(
        &self,
        path: PathBuf,
        owner: Owner,
        most: Option<u64>,
    ) -> Result<(), Error> {
        let _one = self.control.lock().unwrap_or_else(PoisonError::into_inner);
        if path.exists() {
            return Err(Error::RecordingExists { file: path });
        }
        if self.shared.phase() == Phase::Dead {
            return Err(Error::RecorderGone);
        }
        if !self.shared.go(Phase::Idle, Phase::Beginning) {
            let name = self.shared.status.recording().unwrap_or_default().name;
            return Err(Error::AlreadyRecording { name });
        }
        let begun = McapWriter::create(path, &self.about).map(|writer| match self.wanted {
            RecordTopics { images: true, .. } => writer.with_images(self.about.sensor.name()),
            _ => writer,
        });
        let writer = begun.inspect_err(|_| self.shared.set(Phase::Idle))?;
        let open = Open::new(
            writer,
            owner,
            most,
            self.wanted,
            self.shared.status.link_stats(),
        );
        self.shared.status.set_recording(Some(open.status(None)));
        if owner == Owner::Viewer {
            let path = open.path().display();
            self.shared
                .status
                .tell(format!("a viewer begins to record to {path}"));
        }
        if self.items.send(Item::Begin(Box::new(open))).is_err() {
            self.died();
        }
        // What comes from here on is behind the beginning in the queue.
        self.shared.go(Phase::Beginning, Phase::Recording);
        Ok(())
    }

    /// Ends the file and gives what is in it, when it is closed; `None` when there is none.
    pub(super) fn stop(&self) -> Option<SavedRecording> {
        let one = self.control.lock().unwrap_or_else(PoisonError::into_inner);
        let goes_on = self.shared.go(Phase::Recording, Phase::Closing);
        if !goes_on && matches!(self.shared.phase(), Phase::Idle | Phase::Dead) {
            return None;
        }
        let (done, wait) = channel();
        if self.items.send(Item::Stop(done)).is_err() {
            self.died();
            return None;
        }
        drop(one);
        wait.recv().unwrap_or_else(|_| {
            self.died();
            None
        })
    }

    /// What is wanted beside the counts now.
    pub(super) fn wants(&self) -> RecordTopics {
        match self.shared.phase() {
            Phase::Recording | Phase::Closing => self.wanted,
            _ => RecordTopics::default(),
        }
    }

    /// Whose recording is going on.
    pub(super) fn owner(&self) -> Option<Owner> {
        match self.shared.phase() {
            Phase::Idle | Phase::Dead => None,
            _ => self
                .shared
                .status
                .recording()
                .map(|recording| recording.owner),
        }
    }

    pub(super) fn counts(&self, arrived: &TimestampedFrame) {
        self.put(|| Item::Counts(arrived.clone()));
    }

    /// Loads that the disk has no time for are left out, and counted at the end; `waits`: until it has.
    pub(super) fn solved(&self, solved: SolvedFrame, waits: bool) {
        let item = Item::SolvedFrame(Box::new(solved));
        let gone = if waits {
            self.items.send(item).is_err()
        } else {
            matches!(
                self.items.try_send(item),
                Err(TrySendError::Disconnected(_))
            )
        };
        if gone {
            self.died();
        }
    }

    pub(super) fn event(&self, kind: &'static str, text: &str) {
        self.put(|| Item::Event(kind, text.to_owned(), SystemTime::now()));
    }

    /// A tare is part of the recording: what it took off can be taken off again where it is played.
    pub(super) fn tare(&self, tare: Tare) {
        *self.shared.tare() = (!tare.is_undone()).then(|| tare.clone());
        self.put(|| Item::Tare(Box::new(tare)));
    }

    /// What is taken off now.
    pub(super) fn taken_off(&self) -> Option<Tare> {
        self.shared.tare().clone()
    }

    fn put(&self, item: impl FnOnce() -> Item) {
        if self.shared.phase() != Phase::Recording {
            return;
        }
        let sent = if self.waits {
            let sent = self.items.send(item());
            sent.map_err(|gone| TrySendError::Disconnected(gone.0))
        } else {
            self.items.try_send(item())
        };
        match sent {
            Ok(()) => {}
            Err(TrySendError::Full(_)) => {
                self.shared.go(Phase::Recording, Phase::Overrun);
            }
            Err(TrySendError::Disconnected(_)) => self.died(),
        }
    }

    /// Notices a thread that has ended before its time.
    pub(super) fn check(&self) {
        let thread = self.thread.lock().unwrap_or_else(PoisonError::into_inner);
        let gone = thread.as_ref().is_some_and(|thread| thread.is_finished());
        drop(thread);
        if gone {
            self.died();
        }
    }

    /// The thread is gone: says so once, with the reason.
    fn died(&self) {
        self.shared.set(Phase::Dead);
        let thread = self
            .thread
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        let Some(thread) = thread else { return };
        let why = match thread.join() {
            Ok(()) => "the recording thread ended".to_owned(),
            Err(panic) => format!("the recording thread failed: {}", words_of(&*panic)),
        };
        let status = self.shared.status.recording().unwrap_or_default();
        self.shared.status.saved(SavedRecording {
            error: Some(why),
            ..SavedRecording::of(status)
        });
    }

    /// Writes what waits and ends; a thread that failed is told of in the status.
    pub(super) fn finish(&self) {
        if self.items.send(Item::Finish).is_err() {
            return self.died();
        }
        let thread = self
            .thread
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        if let Some(thread) = thread
            && let Err(panic) = thread.join()
        {
            let status = self.shared.status.recording().unwrap_or_default();
            self.shared.status.saved(SavedRecording {
                error: Some(format!(
                    "the recording thread failed: {}",
                    words_of(&*panic)
                )),
                ..SavedRecording::of(status)
            });
        }
    }
}

/// What a panic said.
fn words_of(panic: &(dyn std::any::Any + Send)) -> String {
    let words = panic
        .downcast_ref::<&str>()
        .map(|words| (*words).to_owned());
    words
        .or_else(|| panic.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "for no known reason".to_owned())
}

/// The thread's own.
struct Writing<'a> {
    shared: &'a Shared,
    open: Option<Open>,
    /// Who waits for the end, and since when nothing has come.
    closing: Option<(Sender<Option<SavedRecording>>, Instant)>,
    reported: Instant,
}

impl<'a> Writing<'a> {
    fn new(shared: &'a Shared) -> Self {
        Self {
            shared,
            open: None,
            closing: None,
            reported: Instant::now(),
        }
    }

    fn run(mut self, items: &Receiver<Item>) {
        loop {
            let overrun = self.shared.phase() == Phase::Overrun;
            let patience = if overrun { Duration::ZERO } else { LOOK };
            match items.recv_timeout(patience) {
                Ok(Item::Finish) | Err(RecvTimeoutError::Disconnected) => {
                    return self.end(None);
                }
                Ok(item) => self.take(item),
                Err(RecvTimeoutError::Timeout) if overrun => self.end(None),
                Err(RecvTimeoutError::Timeout) => self.flush(),
            }
            self.close_if_complete();
            if let Some(file) = &self.open
                && self.reported.elapsed() > LOOK
            {
                self.reported = Instant::now();
                self.shared.status.set_recording(Some(file.status(None)));
            }
        }
    }

    fn take(&mut self, item: Item) {
        match item {
            Item::Begin(file) => {
                self.open = Some(*file);
                let tare = self.shared.tare().clone();
                if let Some(tare) = tare {
                    self.write(|file| file.tare(&tare));
                }
            }
            Item::Stop(done) => self.closing = Some((done, Instant::now())),
            Item::Finish => {}
            #[cfg(test)]
            Item::Panic => panic!("asked for by a test"),
            Item::Counts(arrived) => {
                self.write(|file| file.counts(&arrived));
                if self.open.as_ref().is_some_and(Open::is_full)
                    && self.shared.go(Phase::Recording, Phase::Closing)
                {
                    // At once, for those who wait for the last frame.
                    self.reported = Instant::now() - LOOK;
                }
            }
            Item::SolvedFrame(solved) => {
                self.write(|file| file.solved(&solved));
                if let Some((_, since)) = &mut self.closing {
                    *since = Instant::now();
                }
            }
            Item::Tare(tare) => self.write(|file| file.tare(&tare)),
            Item::Event(kind, text, at) => self.write(|file| file.event(kind, &text, at)),
        }
    }

    fn write(&mut self, write: impl FnOnce(&mut Open) -> Result<(), taxel_io::Error>) {
        if let Some(file) = &mut self.open
            && let Err(error) = write(file)
        {
            self.end(Some(error.to_string()));
        }
    }

    fn flush(&mut self) {
        self.write(Open::flush);
    }

    /// Ends the recording when that was asked for and its last loads have come, or come no more.
    fn close_if_complete(&mut self) {
        let complete = self.open.as_ref().is_none_or(Open::has_all_loads);
        if complete {
            self.shared.go(Phase::Closing, Phase::Complete);
        }
        let Some((_, since)) = &self.closing else {
            return;
        };
        if complete || since.elapsed() > LOADS_WITHIN {
            self.end(None);
        }
    }

    /// Closes the file, tells how it went, and is ready for the next.
    fn end(&mut self, error: Option<String>) {
        // Frames were refused, whoever ends it now and why.
        let overrun = self.shared.phase() == Phase::Overrun;
        let slow = || format!("the disk is slower than the sensor: {QUEUE} frames were waiting");
        let error = error.or_else(|| overrun.then(slow));
        let saved = self.open.take().map(|file| {
            let saved = file.end(error, self.shared.status.link_stats());
            self.shared.status.saved(saved.clone());
            self.shared.set(Phase::Idle);
            saved
        });
        if let Some((done, _)) = self.closing.take() {
            let _ = done.send(saved);
        }
    }
}

unit_tests! {
    mod tests;
}
