//! Where a recording goes: straight to its file from its first frame on, whole up to a known byte, or to a file that appears once it is whole.

use std::fs::{self, File};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use super::PLAIN_END;
use crate::atomic::AtomicFile;
use crate::error::Error;
use crate::temporary::Temporary;

/// A file that counts its bytes.
pub(super) struct Tail {
    out: Out,
    state: Arc<State>,
    room: u64,
}

/// How a file stands, to be asked and told while a writer has it.
#[derive(Debug, Default)]
pub(super) struct State {
    bytes: AtomicU64,
    has_frames: AtomicBool,
}

impl State {
    /// Bytes so far.
    pub fn bytes(&self) -> u64 {
        self.bytes.load(Ordering::Relaxed)
    }

    /// Frames have been written: the file gets its name when they go to it.
    pub fn has_frames(&self) {
        self.has_frames.store(true, Ordering::Relaxed);
    }
}

enum Out {
    /// Under its name from its first frame on: what is whole in it survives the program.
    Straight(File),
    /// The same, before its first frame.
    Nameless(Box<Nameless>),
    /// Under its name only once it is whole.
    Once(Box<AtomicFile>),
    /// Its name was taken meanwhile.
    Gone,
}

struct Nameless {
    file: Temporary,
    path: PathBuf,
}

impl Tail {
    /// A new file that is there from its first frame on. `room`: bytes after which the disk is taken to be full.
    pub fn straight(path: &Path, room: u64) -> Result<Self, Error> {
        if fs::symlink_metadata(path).is_ok() {
            return Err(Error::creating(path, io::ErrorKind::AlreadyExists.into()));
        }
        let file = Temporary::next_to(path).map_err(|source| Error::creating(path, source))?;
        let path = path.to_owned();
        let out = Out::Nameless(Box::new(Nameless { file, path }));
        Ok(Self::new(out, room))
    }

    /// A new file that is there once [`Self::finish`] was called.
    pub fn once(path: &Path) -> Result<Self, Error> {
        let file = AtomicFile::create_new(path)?;
        Ok(Self::new(Out::Once(Box::new(file)), u64::MAX))
    }

    /// The same, in place of an older file of the name.
    pub fn once_instead(path: &Path) -> Result<Self, Error> {
        let file = AtomicFile::create(path)?;
        Ok(Self::new(Out::Once(Box::new(file)), u64::MAX))
    }

    fn new(out: Out, room: u64) -> Self {
        Self {
            out,
            state: Arc::default(),
            room,
        }
    }

    /// To be asked while a writer has the file.
    pub fn state(&self) -> Arc<State> {
        self.state.clone()
    }

    /// Gives a file that has frames its name.
    fn name(&mut self) -> io::Result<()> {
        if !self.state.has_frames.load(Ordering::Relaxed) {
            return Ok(());
        }
        let out = std::mem::replace(&mut self.out, Out::Gone);
        let Out::Nameless(nameless) = out else {
            self.out = out;
            return Ok(());
        };
        let Nameless { file, path } = *nameless;
        let file = file.name_new(&path).map_err(|failed| failed.error)?;
        self.out = Out::Straight(file);
        Ok(())
    }

    /// Ends a file that is whole.
    pub fn finish(self) -> Result<(), Error> {
        match self.out {
            // A recording goes on for hours; its last bytes may wait for the disk as all before did.
            Out::Straight(_) => Ok(()),
            Out::Once(file) => file.commit(),
            // Without a frame it would only stand in the way of the next.
            Out::Nameless(_) | Out::Gone => Ok(()),
        }
    }

    /// Cuts off what was half written and ends the file after the first of `whole` bytes that leave room for the end.
    /// The place of that in `whole`, if any.
    pub fn make_whole(self, whole: &[u64]) -> Option<usize> {
        let Out::Straight(mut file) = self.out else {
            // Let go, it leaves nothing.
            return None;
        };
        whole.iter().position(|&length| {
            let ended = file.set_len(length).and_then(|()| {
                file.seek(SeekFrom::Start(length))?;
                file.write_all(PLAIN_END)?;
                file.sync_all()
            });
            ended.is_ok()
        })
    }
}

impl Write for Tail {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.state.bytes() + bytes.len() as u64 > self.room {
            return Err(io::ErrorKind::StorageFull.into());
        }
        let count = match &mut self.out {
            Out::Straight(file) => file.write(bytes)?,
            Out::Nameless(nameless) => nameless.file.file_mut().write(bytes)?,
            Out::Once(file) => file.write(bytes)?,
            Out::Gone => return Err(io::ErrorKind::BrokenPipe.into()),
        };
        self.state.bytes.fetch_add(count as u64, Ordering::Relaxed);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.out {
            Out::Once(file) => file.flush(),
            // They hold nothing back.
            Out::Straight(_) | Out::Nameless(_) | Out::Gone => self.name(),
        }
    }
}

impl Seek for Tail {
    /// Tells where it is; the writer, told not to seek, asks for nothing else.
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match to {
            SeekFrom::Current(0) => Ok(self.state.bytes()),
            _ => Err(io::ErrorKind::NotSeekable.into()),
        }
    }
}
