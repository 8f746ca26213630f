//! Where a recording goes: straight to its file, whole up to a known byte, or to a file that appears once it is whole.

use std::fs::{File, OpenOptions};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::PLAIN_END;
use crate::atomic::AtomicFile;
use crate::error::Error;

/// A file that counts its bytes.
pub(super) struct Tail {
    out: Out,
    at: Arc<AtomicU64>,
    room: u64,
}

enum Out {
    /// Under its name from the first byte on: what is whole in it survives the program.
    Straight(File),
    /// Under its name only once it is whole.
    Once(Box<AtomicFile>),
}

impl Tail {
    /// A new file that is there from now on. `room`: bytes after which the disk is taken to be full.
    pub fn straight(path: &Path, room: u64) -> Result<Self, Error> {
        let file = OpenOptions::new().write(true).create_new(true).open(path);
        let file = file.map_err(|source| Error::creating(path, source))?;
        Ok(Self::new(Out::Straight(file), room))
    }

    /// A new file that is there once [`Self::finish`] was called.
    pub fn once(path: &Path) -> Result<Self, Error> {
        let file = AtomicFile::create_new(path)?;
        Ok(Self::new(Out::Once(Box::new(file)), u64::MAX))
    }

    fn new(out: Out, room: u64) -> Self {
        Self {
            out,
            at: Arc::default(),
            room,
        }
    }

    /// Bytes so far, to be asked while a writer has the file.
    pub fn counter(&self) -> Arc<AtomicU64> {
        self.at.clone()
    }

    /// Ends a file that is whole.
    pub fn finish(self) -> Result<(), Error> {
        match self.out {
            // A recording goes on for hours; its last bytes may wait for the disk as all before did.
            Out::Straight(_) => Ok(()),
            Out::Once(file) => file.commit(),
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
        if self.at.load(Ordering::Relaxed) + bytes.len() as u64 > self.room {
            return Err(io::ErrorKind::StorageFull.into());
        }
        let count = match &mut self.out {
            Out::Straight(file) => file.write(bytes)?,
            Out::Once(file) => file.write(bytes)?,
        };
        self.at.fetch_add(count as u64, Ordering::Relaxed);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.out {
            Out::Straight(file) => file.flush(),
            Out::Once(file) => file.flush(),
        }
    }
}

impl Seek for Tail {
    /// Tells where it is; the writer, told not to seek, asks for nothing else.
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match to {
            SeekFrom::Current(0) => Ok(self.at.load(Ordering::Relaxed)),
            _ => Err(io::ErrorKind::NotSeekable.into()),
        }
    }
}
