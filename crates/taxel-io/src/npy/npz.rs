//! One array of a `.npz` archive as a stream, its checksum verified at its end.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom, Take};
use std::path::{Path, PathBuf};

use flate2::Crc;
use flate2::read::DeflateDecoder;
use zip::{CompressionMethod, ZipArchive};

use crate::error::Error;
use crate::source::{Input, open_file};

/// Opens the array of that name (the first, without one), and names it for messages.
pub(crate) fn open(path: &Path, array: Option<&str>) -> Result<(Input, PathBuf), Error> {
    let (file, _) = open_file(path)?;
    let failed = |source| Error::Archive {
        file: path.to_owned(),
        source,
    };
    let mut archive = ZipArchive::new(BufReader::new(file)).map_err(failed)?;
    let names = array_names(&archive);
    let wanted = match array {
        Some(name) => names.iter().find(|(_, found)| found == name),
        None => names.first(),
    };
    let Some((index, name)) = wanted else {
        return Err(Error::NoArray {
            file: path.to_owned(),
            missing: array.unwrap_or("*").to_owned(),
            found: names.into_iter().map(|(_, name)| name).collect(),
        });
    };
    let entry = archive.by_index_raw(*index).map_err(failed)?;
    let shown = path.join(name);
    let packing = |found: String| Error::Packing {
        file: path.to_owned(),
        array: name.clone(),
        found,
    };
    if entry.encrypted() {
        return Err(packing("encrypted".to_owned()));
    }
    let (method, length, sum) = (entry.compression(), entry.compressed_size(), entry.crc32());
    let start = entry.data_start().unwrap_or_default();
    drop(entry);
    let mut file = archive.into_inner().into_inner();
    file.seek(SeekFrom::Start(start))
        .map_err(|source| Error::Open {
            file: path.to_owned(),
            source,
        })?;
    let packed = file.take(length);
    let input: Input = match method {
        CompressionMethod::Stored => {
            Box::new(Checked::new(BufReader::with_capacity(1 << 16, packed), sum))
        }
        CompressionMethod::Deflated => Box::new(Checked::new(unpack(packed), sum)),
        other => return Err(packing(other.to_string())),
    };
    Ok((input, shown))
}

fn unpack(packed: Take<File>) -> DeflateDecoder<Take<File>> {
    DeflateDecoder::new_with_buf(packed, vec![0; 1 << 16])
}

/// Positions and names of the arrays, without `.npy`, in the archive's order.
fn array_names<R>(archive: &ZipArchive<R>) -> Vec<(usize, String)>
where
    R: Read + Seek,
{
    archive
        .file_names_raw()
        .enumerate()
        .filter_map(|(i, name)| {
            let name = String::from_utf8_lossy(name);
            name.strip_suffix(".npy").map(|name| (i, name.to_owned()))
        })
        .collect()
}

/// Adds up what is read, and refuses the end when the sum is not the archive's.
struct Checked<R> {
    input: R,
    sum: Crc,
    expected: u32,
}

impl<R> Checked<R> {
    fn new(input: R, expected: u32) -> Self {
        let sum = Crc::new();
        Self {
            input,
            sum,
            expected,
        }
    }
}

impl<R: Read> Read for Checked<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let n = self.input.read(out)?;
        self.sum.update(&out[..n]);
        if n == 0 && !out.is_empty() && self.sum.sum() != self.expected {
            return Err(io::Error::new(
                io::ErrorKind::InvalidData,
                format!(
                    "checksum {:08x} found, {:08x} expected",
                    self.sum.sum(),
                    self.expected
                ),
            ));
        }
        Ok(n)
    }
}
