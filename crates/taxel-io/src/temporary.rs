//! A file that has no name, or a hidden one, until it is given its own.
//!
//! On Linux it has none where the file system allows that: a program that is killed then leaves nothing behind.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use tempfile::NamedTempFile;

/// Hidden files of this program: what a signal must not leave behind.
static HIDDEN: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Removes every hidden file that is being written, and lets none begin any more: for a program that ends at once
/// because a signal tells it to.
pub fn discard_all() {
    let hidden = HIDDEN.lock().unwrap_or_else(PoisonError::into_inner);
    for path in hidden.iter() {
        let _ = fs::remove_file(path);
    }
    std::mem::forget(hidden);
}

/// A hidden file that is in the list as long as it is one.
#[derive(Debug)]
struct Listed(PathBuf);

impl Drop for Listed {
    fn drop(&mut self) {
        let mut hidden = HIDDEN.lock().unwrap_or_else(PoisonError::into_inner);
        hidden.retain(|path| *path != self.0);
    }
}

/// The file; let go, it is gone.
#[derive(Debug)]
pub(crate) enum Temporary {
    /// Without a name.
    #[cfg(target_os = "linux")]
    Unnamed(File),
    /// With a hidden one.
    Hidden(Hidden),
}

#[derive(Debug)]
pub(crate) struct Hidden(NamedTempFile, Listed);

/// A file that could not be given its name, and is as it was.
#[derive(Debug)]
pub(crate) struct NotNamed {
    pub(crate) file: Temporary,
    pub(crate) error: io::Error,
}

impl Temporary {
    /// A new file in the folder that `target` is to be in.
    pub(crate) fn next_to(target: &Path) -> io::Result<Self> {
        let folder = folder_of(target);
        #[cfg(target_os = "linux")]
        // Not every file system can; whatever else is wrong, the hidden file is told it too.
        if let Ok(file) = linux::unnamed_in(folder) {
            return Ok(Self::Unnamed(file));
        }
        hidden_in(folder).map(Self::Hidden)
    }

    pub(crate) fn file(&self) -> &File {
        match self {
            #[cfg(target_os = "linux")]
            Self::Unnamed(file) => file,
            Self::Hidden(Hidden(file, _)) => file.as_file(),
        }
    }

    pub(crate) fn file_mut(&mut self) -> &mut File {
        match self {
            #[cfg(target_os = "linux")]
            Self::Unnamed(file) => file,
            Self::Hidden(Hidden(file, _)) => file.as_file_mut(),
        }
    }

    /// Gives it a name that no file has: [`io::ErrorKind::AlreadyExists`] where one has it.
    pub(crate) fn name_new(self, target: &Path) -> Result<File, NotNamed> {
        match self {
            #[cfg(target_os = "linux")]
            Self::Unnamed(file) => match linux::link(&file, target) {
                Ok(()) => Ok(file),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                    Err(NotNamed::of(Self::Unnamed(file), error))
                }
                Err(error) => hide(file, target, error)?.name_new(target),
            },
            Self::Hidden(Hidden(file, listed)) => file
                .persist_noclobber(target)
                .map_err(|failed| NotNamed::hidden(failed.file, listed, failed.error)),
        }
    }

    /// Gives it a name, and takes that from the file that has it.
    pub(crate) fn name_over(self, target: &Path) -> Result<File, NotNamed> {
        match self {
            #[cfg(target_os = "linux")]
            Self::Unnamed(file) => {
                let linked = match linux::link(&file, target) {
                    Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                        linux::link_over(&file, target)
                    }
                    linked => linked,
                };
                match linked {
                    Ok(()) => Ok(file),
                    Err(error) => hide(file, target, error)?.name_over(target),
                }
            }
            Self::Hidden(Hidden(file, listed)) => file
                .persist(target)
                .map_err(|failed| NotNamed::hidden(failed.file, listed, failed.error)),
        }
    }
}

impl NotNamed {
    fn of(file: Temporary, error: io::Error) -> Self {
        Self { file, error }
    }

    fn hidden(file: NamedTempFile, listed: Listed, error: io::Error) -> Self {
        Self::of(Temporary::Hidden(Hidden(file, listed)), error)
    }
}

/// The folder that a file is in.
pub(crate) fn folder_of(target: &Path) -> &Path {
    match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

fn builder() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".taxel-").suffix(".tmp");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // As for any new file; the user's mask takes away from it.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder
}

fn hidden_in(folder: &Path) -> io::Result<Hidden> {
    // The list is held meanwhile: no file is there that is not in it.
    let mut hidden = HIDDEN.lock().unwrap_or_else(PoisonError::into_inner);
    let file = builder().tempfile_in(folder)?;
    let path = file.path().to_owned();
    hidden.push(path.clone());
    Ok(Hidden(file, Listed(path)))
}

/// A copy with a hidden name of a file that the system would not give one (`why`): what was written must not be lost
/// for that.
#[cfg(target_os = "linux")]
fn hide(mut file: File, target: &Path, why: io::Error) -> Result<Temporary, NotNamed> {
    use std::io::{Seek, SeekFrom};
    let copied = hidden_in(folder_of(target)).and_then(|mut hidden| {
        let at = file.stream_position()?;
        file.seek(SeekFrom::Start(0))?;
        let copy = hidden.0.as_file_mut();
        io::copy(&mut file, copy)?;
        copy.set_permissions(file.metadata()?.permissions())?;
        copy.seek(SeekFrom::Start(at))?;
        copy.sync_all()?;
        Ok(hidden)
    });
    match copied {
        Ok(hidden) => Ok(Temporary::Hidden(hidden)),
        Err(_) => Err(NotNamed::of(Temporary::Unnamed(file), why)),
    }
}

#[cfg(target_os = "linux")]
mod linux {
    use std::fs::File;
    use std::io;
    use std::os::fd::AsRawFd;
    use std::path::Path;
    use std::sync::PoisonError;

    use rustix::fs::{AtFlags, CWD, Mode, OFlags, linkat, open};

    use super::{HIDDEN, builder, folder_of};

    pub(super) fn unnamed_in(folder: &Path) -> io::Result<File> {
        let flags = OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC;
        let file = open(folder, flags, Mode::from_raw_mode(0o666))?;
        Ok(File::from(file))
    }

    pub(super) fn link(file: &File, target: &Path) -> io::Result<()> {
        // By the file's number itself only a privileged program may.
        let open = format!("/proc/self/fd/{}", file.as_raw_fd());
        Ok(linkat(CWD, open, CWD, target, AtFlags::SYMLINK_FOLLOW)?)
    }

    /// A link never replaces a file, a new name does: for a moment the file has a hidden one.
    pub(super) fn link_over(file: &File, target: &Path) -> io::Result<()> {
        // A signal waits meanwhile.
        let _hidden = HIDDEN.lock().unwrap_or_else(PoisonError::into_inner);
        let linked = builder().make_in(folder_of(target), |path| link(file, path))?;
        linked.persist(target).map_err(|failed| failed.error)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<String> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    /// Both kinds, each as it comes out of its beginning.
    fn kinds(folder: &Path) -> Vec<Temporary> {
        let hidden = Temporary::Hidden(hidden_in(folder).unwrap());
        vec![Temporary::next_to(&folder.join("a")).unwrap(), hidden]
    }

    #[test]
    fn a_new_name_never_takes_that_of_another_file_and_the_content_stays() {
        for place in 0..2 {
            let folder = tempfile::tempdir().unwrap();
            let mut file = kinds(folder.path()).swap_remove(place);
            file.file_mut().write_all(b"new").unwrap();
            let (taken, free) = (folder.path().join("taken"), folder.path().join("free"));
            fs::write(&taken, "old").unwrap();
            let refused = file.name_new(&taken).unwrap_err();
            assert_eq!(refused.error.kind(), io::ErrorKind::AlreadyExists);
            assert_eq!(fs::read(&taken).unwrap(), b"old");
            let mut named = refused.file.name_new(&free).unwrap();
            named.write_all(b"er").unwrap();
            assert_eq!(fs::read(&free).unwrap(), b"newer");
            assert_eq!(names(folder.path()), ["free", "taken"]);
        }
    }

    #[test]
    fn a_file_that_is_replaced_leaves_nothing_beside() {
        for place in 0..2 {
            let folder = tempfile::tempdir().unwrap();
            let target = folder.path().join("a");
            fs::write(&target, "old").unwrap();
            let mut file = kinds(folder.path()).swap_remove(place);
            file.file_mut().write_all(b"new").unwrap();
            file.name_over(&target).unwrap();
            assert_eq!(fs::read(&target).unwrap(), b"new");
            assert_eq!(names(folder.path()), ["a"]);
        }
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_file_that_gets_no_name_by_a_link_is_copied() {
        let folder = tempfile::tempdir().unwrap();
        let Ok(mut file) = linux::unnamed_in(folder.path()) else {
            return;
        };
        assert_eq!(names(folder.path()), [] as [&str; 0]);
        file.write_all(b"all of it").unwrap();
        let target = folder.path().join("a");
        let copy = hide(file, &target, io::ErrorKind::Unsupported.into()).unwrap();
        let mut named = copy.name_new(&target).unwrap();
        named.write_all(b", and more").unwrap();
        assert_eq!(fs::read(&target).unwrap(), b"all of it, and more");
        assert_eq!(names(folder.path()), ["a"]);
    }
}
