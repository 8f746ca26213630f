//! Folders of sessions that outlive a crash: each has a name from when it began, and `session.json`, written anew after every step.

use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use serde::Serialize;
use serde::de::DeserializeOwned;
use taxel_io::AtomicFile;
use taxel_server::ResultFile;

use crate::error::Error;
use crate::session::time_stamp;
use crate::text_file;

/// The file that says how a session stands.
const FILE: &str = "session.json";
/// The longest such file, bytes.
const MAX: u64 = 4 << 20;
/// A session that was left longer ago than this is not gone on with by itself, seconds: hands, materials and rooms change.
const RESUMED_WITHIN: u64 = 12 * 3600;

/// What is kept of a session in its folder.
pub(crate) trait SessionRecord: Serialize + DeserializeOwned {
    /// What it is of, with its article.
    const OF: &str;
    /// The version of the file that this program writes and reads.
    const VERSION: u32;
    /// What is said to one who has another file there.
    const HINT: &'static str;

    /// Its file's version.
    fn version(&self) -> u32;
    /// When it was written last, seconds since 1970, to be set.
    fn written_secs(&mut self) -> &mut u64;

    /// Reads it from its folder.
    fn read(folder: &Path) -> Result<Self, Error> {
        let file = folder.join(FILE);
        let text = text_file::read(&file, Self::OF, MAX)?;
        let record: Self = serde_json::from_str(&text).map_err(|error| Error::Request {
            what: format!("{}: {error}", file.display()),
            hint: Self::HINT,
        })?;
        if record.version() == Self::VERSION {
            return Ok(record);
        }
        Err(Error::Request {
            what: format!(
                "{}: version {}, this program reads {}",
                file.display(),
                record.version(),
                Self::VERSION
            ),
            hint: "a newer program wrote it",
        })
    }

    /// Keeps it: whole, or as it was.
    fn write(&mut self, folder: &Path) -> Result<(), Error> {
        *self.written_secs() = since_1970(SystemTime::now());
        let text = serde_json::to_string_pretty(self).expect("plain data is JSON");
        Ok(AtomicFile::write_whole(folder.join(FILE), text.as_bytes())?)
    }

    /// Those in folders below `all` that can be read, the newest first.
    fn newest_first(all: &Path) -> impl Iterator<Item = (PathBuf, Self)> {
        let folders = std::fs::read_dir(all).into_iter().flatten().flatten();
        let mut folders: Vec<PathBuf> = folders.map(|entry| entry.path()).collect();
        folders.sort_unstable();
        let newest = folders.into_iter().rev();
        newest.filter_map(|folder| Some((folder.clone(), Self::read(&folder).ok()?)))
    }
}

/// Whether a folder is that of a session.
pub(crate) fn is_session(folder: &Path) -> bool {
    folder.join(FILE).exists()
}

/// Whether a session that was written last then is gone on with by itself.
pub(crate) fn is_recent(written_secs: u64, now_secs: u64) -> bool {
    now_secs.saturating_sub(written_secs) < RESUMED_WITHIN
}

/// Whole seconds since 1970.
pub(crate) fn since_1970(at: SystemTime) -> u64 {
    at.duration_since(UNIX_EPOCH).unwrap_or_default().as_secs()
}

/// A new folder below `all`, named after a time.
pub(crate) fn new_folder(all: &Path, at: SystemTime) -> Result<PathBuf, Error> {
    let stamp = time_stamp(at);
    let names = (1..1000).map(|n| match n {
        1 => stamp.clone(),
        n => format!("{stamp}-{n}"),
    });
    let mut folders = names.map(|name| all.join(name));
    let folder = folders.find(|folder| !folder.exists());
    let folder = folder.unwrap_or_else(|| all.join(&stamp));
    std::fs::create_dir_all(&folder).map_err(|source| Error::Folder {
        folder: folder.clone(),
        source,
    })?;
    Ok(folder)
}

/// A file of results, as a browser gets it; `None` where there is none, or one of another kind.
pub(crate) fn result_file(file: &Path) -> Option<ResultFile> {
    let kind = match file.extension()?.to_str()? {
        "html" => "text/html; charset=utf-8",
        "pdf" => "application/pdf",
        "csv" => "text/csv; charset=utf-8",
        "json" => "application/json",
        "toml" => "text/plain; charset=utf-8",
        _ => return None,
    };
    let bytes = std::fs::read(file).ok()?;
    Some(ResultFile { bytes, kind })
}
