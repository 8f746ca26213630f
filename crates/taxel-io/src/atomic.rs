//! Output files that are either whole or not there.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use crate::error::Error;
pub use crate::temporary::discard_all;
use crate::temporary::{NotNamed, Temporary, folder_of};

const BUFFER: usize = 256 * 1024;

/// A file that appears under its name only when [`AtomicFile::commit`] has written all of it to the disk.
///
/// Until then it has no name, or a hidden one in the same folder where the system has no files without; dropped
/// without `commit`, it is gone and an older file of the name untouched. When the disk is full, what was written is kept as `<name>.partial`.
/// `-`, `/dev/stdout`, pipes and devices are written straight through.
#[derive(Debug)]
pub struct AtomicFile {
    name: PathBuf,
    target: PathBuf,
    sink: Sink,
    buffer: Vec<u8>,
    bytes: u64,
    kept: Arc<OnceLock<PathBuf>>,
    /// An older file of the name is never replaced.
    new_only: bool,
    #[cfg(test)]
    fails_after: Option<u64>,
}

#[derive(Debug)]
enum Sink {
    Standard(io::Stdout),
    Through(File),
    Beside(Temporary),
    Failed,
}

impl AtomicFile {
    /// Begins the file `path`.
    ///
    /// # Errors
    /// [`Error::Create`] when nothing can be written there.
    pub fn create(path: impl AsRef<Path>) -> Result<Self, Error> {
        let name = path.as_ref().to_owned();
        let (target, sink) = open_sink(&name).map_err(|source| Error::Create {
            file: name.clone(),
            source,
        })?;
        Ok(Self {
            name,
            target,
            sink,
            buffer: Vec::with_capacity(BUFFER),
            bytes: 0,
            kept: Arc::default(),
            new_only: false,
            #[cfg(test)]
            fails_after: None,
        })
    }

    /// Writes a whole file, or leaves what was there.
    ///
    /// # Errors
    /// [`Error::Create`] and [`Error::Write`].
    pub fn write_whole(path: impl AsRef<Path>, bytes: &[u8]) -> Result<(), Error> {
        let mut file = Self::create(path)?;
        file.put(bytes)?;
        file.commit()
    }

    /// Begins the file `path`, which must not be there: not now and not when it is committed.
    ///
    /// # Errors
    /// [`Error::Exists`]; [`Error::Create`] when nothing can be written there.
    pub fn create_new(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        if fs::symlink_metadata(path).is_ok() {
            return Err(Error::Exists {
                file: path.to_owned(),
            });
        }
        let mut file = Self::create(path)?;
        file.new_only = true;
        Ok(file)
    }

    /// The name it was created with.
    pub fn path(&self) -> &Path {
        &self.name
    }

    /// Whether the file is written beside its target, so that its start can be written again.
    pub fn can_go_back(&self) -> bool {
        matches!(self.sink, Sink::Beside(_))
    }

    /// The folder in which the file is written; none where it is written straight through.
    #[cfg(feature = "xlsx")]
    pub(crate) fn folder(&self) -> Option<&Path> {
        self.can_go_back().then(|| folder_of(&self.target))
    }

    /// Appends `bytes`.
    ///
    /// # Errors
    /// [`Error::Write`], naming what is kept.
    pub fn put(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.write_all(bytes).map_err(|source| self.error(source))
    }

    /// Writes `bytes` over the first bytes of the file. Only where [`AtomicFile::can_go_back`].
    ///
    /// # Errors
    /// [`Error::Write`], naming what is kept.
    pub(crate) fn put_at_start(&mut self, bytes: &[u8]) -> Result<(), Error> {
        let result = self.drain().and_then(|()| match &mut self.sink {
            Sink::Beside(file) => {
                let file = file.file_mut();
                file.seek(SeekFrom::Start(0))?;
                file.write_all(bytes)?;
                file.seek(SeekFrom::End(0)).map(|_| ())
            }
            _ => Err(io::ErrorKind::NotSeekable.into()),
        });
        result.map_err(|source| {
            self.keep();
            self.error(source)
        })
    }

    /// Writes the rest, waits until the disk has it, and gives the file its name.
    ///
    /// # Errors
    /// [`Error::Write`], naming what is kept; an older file of that name is untouched.
    pub fn commit(mut self) -> Result<(), Error> {
        let result = self.drain().and_then(|()| self.settle());
        if let Err(source) = result {
            self.keep();
            return Err(self.error(source));
        }
        let Sink::Beside(file) = std::mem::replace(&mut self.sink, Sink::Failed) else {
            return Ok(());
        };
        let named = if self.new_only {
            file.name_new(&self.target)
        } else {
            file.name_over(&self.target)
        };
        if let Err(NotNamed { file, error }) = named {
            self.sink = Sink::Beside(file);
            self.keep();
            return Err(self.error(error));
        }
        sync_folder(&self.target);
        Ok(())
    }

    /// Where the part that was written is kept after a failure; to be asked when the file itself is owned by
    /// an archive.
    pub(crate) fn kept(&self) -> Arc<OnceLock<PathBuf>> {
        self.kept.clone()
    }

    pub(crate) fn error(&self, source: io::Error) -> Error {
        Error::Write {
            file: self.name.clone(),
            bytes: self.bytes,
            kept: self.kept.get().cloned(),
            source,
        }
    }

    fn settle(&mut self) -> io::Result<()> {
        match &mut self.sink {
            Sink::Standard(out) => out.flush(),
            Sink::Through(file) => file.flush(),
            Sink::Beside(file) => file.file().sync_all(),
            Sink::Failed => Err(io::ErrorKind::BrokenPipe.into()),
        }
    }

    /// Writes what is held; on an error the part so far is kept under another name.
    fn drain(&mut self) -> io::Result<()> {
        let mut done = 0;
        while done < self.buffer.len() {
            match self.write_some(done) {
                Ok(0) => return self.give_up(io::ErrorKind::WriteZero.into()),
                Ok(n) => {
                    done += n;
                    if !matches!(self.sink, Sink::Failed) {
                        self.bytes += n as u64;
                    }
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return self.give_up(error),
            }
        }
        self.buffer.clear();
        Ok(())
    }

    fn write_some(&mut self, done: usize) -> io::Result<usize> {
        let bytes = &self.buffer[done..];
        #[cfg(test)]
        if let Some(left) = self.fails_after {
            let room = left.saturating_sub(self.bytes).min(bytes.len() as u64) as usize;
            if room == 0 {
                return Err(io::ErrorKind::StorageFull.into());
            }
            return match &mut self.sink {
                Sink::Beside(file) => file.file_mut().write(&bytes[..room]),
                _ => Ok(room),
            };
        }
        match &mut self.sink {
            Sink::Standard(out) => out.write(bytes),
            Sink::Through(file) => file.write(bytes),
            Sink::Beside(file) => file.file_mut().write(bytes),
            // Told once already; `commit` tells again. What follows, as an archive's end, goes nowhere.
            Sink::Failed => Ok(bytes.len()),
        }
    }

    fn give_up(&mut self, error: io::Error) -> io::Result<()> {
        self.buffer.clear();
        self.keep();
        Err(error)
    }

    /// Gives what was written so far the name `<name>.partial`.
    fn keep(&mut self) {
        if let Sink::Beside(file) = std::mem::replace(&mut self.sink, Sink::Failed) {
            if self.bytes == 0 {
                // Nothing is no part of anything; let go, it is gone.
                return;
            }
            let mut name = self.target.clone().into_os_string();
            name.push(".partial");
            let partial = PathBuf::from(name);
            if file.name_over(&partial).is_ok() {
                let _ = self.kept.set(partial);
            }
        }
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.buffer.len() + bytes.len() > BUFFER {
            self.drain()?;
        }
        let taken = bytes.len().min(BUFFER);
        self.buffer.extend_from_slice(&bytes[..taken]);
        Ok(taken)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.drain()
    }
}

/// Whether a path names a device or what the kernel shows, and no file; `/dev/shm` is a folder of files in memory.
pub fn is_device(path: &Path) -> bool {
    let in_memory = path.starts_with("/dev/shm");
    !in_memory && (path.starts_with("/dev") || path.starts_with("/proc"))
}

/// The real target behind links, and what to write into.
fn open_sink(path: &Path) -> io::Result<(PathBuf, Sink)> {
    if path.as_os_str() == "-" || path == Path::new("/dev/stdout") {
        return Ok((path.to_owned(), Sink::Standard(io::stdout())));
    }
    let about = match fs::metadata(path) {
        Ok(about) => Some(about),
        Err(error) if error.kind() == io::ErrorKind::NotFound => None,
        Err(error) => return Err(error),
    };
    if about.as_ref().is_some_and(fs::Metadata::is_dir) {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    if is_device(path) && about.is_some() || about.as_ref().is_some_and(|about| !about.is_file()) {
        let file = OpenOptions::new().write(true).open(path)?;
        return Ok((path.to_owned(), Sink::Through(file)));
    }
    let target = match about {
        Some(_) => fs::canonicalize(path)?,
        None => path.to_owned(),
    };
    let file = Temporary::next_to(&target)?;
    if let Some(about) = about {
        file.file().set_permissions(about.permissions())?;
    }
    Ok((target, Sink::Beside(file)))
}

/// Makes the new name itself last through a power cut, where the system can.
fn sync_folder(target: &Path) {
    if let Ok(folder) = File::open(folder_of(target)) {
        let _ = folder.sync_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_in_memory_are_files() {
        for device in ["/dev/null", "/dev/fd/1", "/dev/stdout", "/proc/self/fd/1"] {
            assert!(is_device(Path::new(device)), "{device}");
        }
        for file in ["/dev/shm/a.npy", "dev/a", "/device/a", "/tmp/dev/a"] {
            assert!(!is_device(Path::new(file)), "{file}");
        }
    }

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn the_old_file_stays_until_commit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        fs::write(&path, "old").unwrap();
        let mut file = AtomicFile::create(&path).unwrap();
        file.put(b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        file.commit().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(names(folder.path()), ["a.csv"]);
    }

    #[test]
    fn dropped_it_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let mut file = AtomicFile::create(folder.path().join("a.csv")).unwrap();
        file.put(b"new").unwrap();
        drop(file);
        assert_eq!(names(folder.path()), [] as [&str; 0]);
    }

    #[test]
    fn on_a_full_disk_the_part_is_kept_apart() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        fs::write(&path, "old").unwrap();
        let mut file = AtomicFile::create(&path).unwrap();
        file.fails_after = Some(300_000);
        file.put(&[b'x'; 200_000]).unwrap();
        file.put(&[b'y'; 100_000]).unwrap();
        file.put(&[b'z'; 100_000]).unwrap();
        let error = file.commit().unwrap_err();
        let partial = fs::canonicalize(folder.path())
            .unwrap()
            .join("a.csv.partial");
        assert!(
            error.to_string().starts_with(&format!(
                "cannot finish {} after 300000 bytes: ",
                path.display()
            )),
            "{error}"
        );
        assert!(error.to_string().ends_with(&format!(
            "what was written is kept as {}, an older file is untouched\nhint: make room, then run again",
            partial.display()
        )));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::metadata(&partial).unwrap().len(), 300_000);
        assert_eq!(names(folder.path()), ["a.csv", "a.csv.partial"]);
    }

    #[test]
    fn a_missing_folder_is_told_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let error = AtomicFile::create(folder.path().join("no/a.csv")).unwrap_err();
        assert!(matches!(error, Error::Create { .. }), "{error}");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_device_is_written_straight_through() {
        let mut file = AtomicFile::create("/dev/full").unwrap();
        assert!(!file.can_go_back());
        file.put(b"x").unwrap();
        let error = file.commit().unwrap_err();
        assert!(error.to_string().contains("nothing is kept"), "{error}");
        let mut file = AtomicFile::create("/dev/null").unwrap();
        file.put(b"x").unwrap();
        file.commit().unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_permissions_kept() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let (real, link) = (folder.path().join("real"), folder.path().join("link"));
        fs::write(&real, "old").unwrap();
        fs::set_permissions(&real, fs::Permissions::from_mode(0o640)).unwrap();
        symlink(&real, &link).unwrap();
        let mut file = AtomicFile::create(&link).unwrap();
        file.put(b"new").unwrap();
        file.commit().unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&real).unwrap(), b"new");
        let mode = fs::metadata(&real).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o640);
    }
}
