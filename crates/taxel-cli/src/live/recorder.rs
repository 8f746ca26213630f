//! The thread that writes: it never drops a frame, and never holds up who reads them.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, channel, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime};

use taxel::metric::Figures;
use taxel::{Frame, Newtons};
use taxel_record::McapWriter;
use taxel_record::mcap::About;

use super::desk::{Desk, Recording};
use super::{Arrived, Options};
use crate::error::Error;

/// What is recorded beside the counts.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Wanted {
    /// Compensated loads.
    pub(crate) loads: bool,
    /// Total force and the like.
    pub(crate) figures: bool,
}

/// Items that may wait for the disk: five seconds at 100 frames a second.
const QUEUE: usize = 512;
/// How often it looks around while nothing comes.
const LOOK: Duration = Duration::from_millis(100);

enum Item {
    Counts(Arrived),
    Solved(Option<Box<Frame<Newtons>>>, Figures, u64, SystemTime),
    Event(&'static str, String, SystemTime),
}

enum Order {
    Begin(Box<McapWriter>),
    Stop(Sender<()>),
}

/// The recorder's near end.
pub(super) struct Recorder {
    items: SyncSender<Item>,
    orders: Mutex<Sender<Order>>,
    shared: Arc<Shared>,
    about: About,
    wanted: Wanted,
    thread: Mutex<Option<std::thread::JoinHandle<()>>>,
}

/// What both ends see.
struct Shared {
    /// A recording is going on.
    recording: AtomicBool,
    /// The queue was full: the disk is too slow.
    overrun: AtomicBool,
    /// No more will come.
    finished: AtomicBool,
    desk: Arc<Desk>,
}

impl Recorder {
    pub(super) fn start(options: &Options, desk: Arc<Desk>) -> Result<Self, Error> {
        let (items, received) = sync_channel(QUEUE);
        let (orders, ordered) = channel();
        let shared = Arc::new(Shared {
            recording: AtomicBool::new(false),
            overrun: AtomicBool::new(false),
            finished: AtomicBool::new(false),
            desk,
        });
        let with = shared.clone();
        let thread = std::thread::Builder::new()
            .name("recorder".to_owned())
            .spawn(move || write(&received, &ordered, &with))
            .map_err(Error::Thread)?;
        Ok(Self {
            items,
            orders: Mutex::new(orders),
            shared,
            about: About {
                sensor: options.sensor.clone(),
                program: format!("taxel {}", env!("CARGO_PKG_VERSION")),
                source: options.address.to_string(),
            },
            wanted: options.wanted,
            thread: Mutex::new(Some(thread)),
        })
    }

    /// Begins a file.
    pub(super) fn begin(&self, path: PathBuf) -> Result<(), Error> {
        let writer = McapWriter::create(path, &self.about)?;
        self.shared.overrun.store(false, Ordering::Relaxed);
        self.shared.desk.set_recording(Some(Recording {
            name: shown_name(writer.path()),
            ..Recording::default()
        }));
        self.order(Order::Begin(Box::new(writer)));
        self.shared.recording.store(true, Ordering::Relaxed);
        Ok(())
    }

    /// Ends the file, when it is whole; false when there is none.
    pub(super) fn stop(&self) -> bool {
        if !self.shared.recording.swap(false, Ordering::Relaxed) {
            return false;
        }
        let (done, wait) = channel();
        self.order(Order::Stop(done));
        let _ = wait.recv_timeout(Duration::from_secs(2));
        true
    }

    fn order(&self, order: Order) {
        let orders = self.orders.lock().unwrap_or_else(PoisonError::into_inner);
        let _ = orders.send(order);
    }

    pub(super) fn wants(&self) -> Wanted {
        match self.shared.recording.load(Ordering::Relaxed) {
            true => self.wanted,
            false => Wanted::default(),
        }
    }

    pub(super) fn counts(&self, arrived: &Arrived) {
        self.put(|| Item::Counts(arrived.clone()));
    }

    /// The same from a source that can wait for the disk.
    pub(super) fn counts_waiting(&self, arrived: &Arrived) {
        if self.shared.recording.load(Ordering::Relaxed) {
            let _ = self.items.send(Item::Counts(arrived.clone()));
        }
    }

    pub(super) fn solved(
        &self,
        loads: Option<&Frame<Newtons>>,
        figures: Figures,
        sequence: u64,
        at: SystemTime,
    ) {
        self.put(|| Item::Solved(loads.cloned().map(Box::new), figures, sequence, at));
    }

    pub(super) fn event(&self, kind: &'static str, text: &str) {
        self.put(|| Item::Event(kind, text.to_owned(), SystemTime::now()));
    }

    fn put(&self, item: impl FnOnce() -> Item) {
        if self.shared.recording.load(Ordering::Relaxed) && self.items.try_send(item()).is_err() {
            self.shared.overrun.store(true, Ordering::Relaxed);
        }
    }

    /// Writes what waits and ends.
    pub(super) fn finish(&self) {
        self.shared.finished.store(true, Ordering::Relaxed);
        let thread = self
            .thread
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        if let Some(thread) = thread {
            let _ = thread.join();
        }
    }
}

fn shown_name(path: &Path) -> String {
    path.file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

/// The file, and since when.
struct Open {
    writer: McapWriter,
    begun: Instant,
}

fn write(items: &Receiver<Item>, orders: &Receiver<Order>, shared: &Shared) {
    let mut open: Option<Open> = None;
    let mut told = Instant::now();
    loop {
        let mut item = match items.recv_timeout(LOOK) {
            Ok(item) => Some(item),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => return end(open.take(), shared, None),
        };
        // Orders after the item: what came before a stop belongs to the file, what comes after a beginning too.
        for order in orders.try_iter() {
            match order {
                Order::Begin(writer) => {
                    end(open.take(), shared, None);
                    shared.recording.store(true, Ordering::Relaxed);
                    open = Some(Open {
                        writer: *writer,
                        begun: Instant::now(),
                    });
                }
                Order::Stop(done) => {
                    put_all(&mut open, item.take(), items, shared);
                    end(open.take(), shared, None);
                    let _ = done.send(());
                }
            }
        }
        if shared.finished.load(Ordering::Relaxed) {
            put_all(&mut open, item, items, shared);
            return end(open.take(), shared, None);
        }
        match item {
            Some(item) => put(&mut open, item, shared),
            None => {
                if let Some(file) = &mut open
                    && let Err(error) = file.writer.flush_if_due()
                {
                    end(open.take(), shared, Some(error.to_string()));
                }
            }
        }
        if shared.overrun.swap(false, Ordering::Relaxed) {
            let why = format!("the disk is slower than the sensor: {QUEUE} frames were waiting");
            end(open.take(), shared, Some(why));
        }
        if let Some(file) = &open
            && told.elapsed() > LOOK
        {
            told = Instant::now();
            shared.desk.set_recording(Some(file.status(None)));
        }
    }
}

impl Open {
    fn status(&self, error: Option<String>) -> Recording {
        Recording {
            name: shown_name(self.writer.path()),
            frames: self.writer.frames(),
            bytes: self.writer.bytes(),
            secs: self.begun.elapsed().as_secs_f64(),
            error,
        }
    }
}

/// An item and all that wait behind it.
fn put_all(open: &mut Option<Open>, item: Option<Item>, items: &Receiver<Item>, shared: &Shared) {
    for item in item.into_iter().chain(items.try_iter()) {
        put(open, item, shared);
    }
}

fn put(open: &mut Option<Open>, item: Item, shared: &Shared) {
    let Some(file) = open else {
        return;
    };
    let writer = &mut file.writer;
    let written = match item {
        Item::Counts(arrived) => writer.write_counts(&arrived.frame, arrived.at),
        Item::Solved(loads, figures, sequence, at) => {
            let loads = loads.map_or(Ok(()), |loads| writer.write_loads(&loads, at));
            loads.and_then(|()| writer.write_figures(&figures, sequence, at))
        }
        Item::Event(kind, text, at) => writer.write_event(kind, &text, at),
    };
    if let Err(error) = written {
        end(open.take(), shared, Some(error.to_string()));
    }
}

/// Closes the file; an error stays to be seen, a good end does not.
fn end(open: Option<Open>, shared: &Shared, mut error: Option<String>) {
    let Some(file) = open else {
        return;
    };
    let mut status = file.status(None);
    if error.is_none() {
        error = file.writer.finish().err().map(|error| error.to_string());
    }
    shared.recording.store(false, Ordering::Relaxed);
    status.error = error;
    // On the command line the last word counts too; viewers see the end by `null`.
    match (&status.error, shared.finished.load(Ordering::Relaxed)) {
        (None, false) => shared.desk.set_recording(None),
        _ => shared.desk.set_recording(Some(status)),
    }
}
