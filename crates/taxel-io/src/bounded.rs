//! Small text files, read no further than they may be long: a device has no end.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// The text of a file of at most `most` bytes; `None` where it has more.
///
/// # Errors
/// A file that cannot be opened or read, or that is not UTF-8.
pub fn read_text(file: &Path, most: u64) -> io::Result<Option<String>> {
    let mut bytes = Vec::new();
    // One byte more than may be tells a file that is too long.
    File::open(file)?.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        return Ok(None);
    }
    let text = String::from_utf8(bytes);
    text.map(Some)
        .map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "it is not UTF-8 text"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_read_whole_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a");
        std::fs::write(&file, "four").unwrap();
        assert_eq!(read_text(&file, 4).unwrap().as_deref(), Some("four"));
        assert_eq!(read_text(&file, 3).unwrap(), None);
        std::fs::write(&file, b"\xff").unwrap();
        let told = read_text(&file, 3).unwrap_err().to_string();
        assert!(told.contains("UTF-8"), "{told}");
    }

    #[cfg(unix)]
    #[test]
    fn a_device_without_end_is_left_at_the_bound() {
        assert_eq!(read_text(Path::new("/dev/zero"), 1000).unwrap(), None);
    }
}
