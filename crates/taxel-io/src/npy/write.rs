//! Frames to `.npy` and `.npz`.

use std::io::{self, Write};
use std::marker::PhantomData;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use taxel::Frame;
use zip::result::ZipError;
use zip::write::{SimpleFileOptions, StreamWriter};
use zip::{CompressionMethod, ZipWriter};

use super::element::Element;
use super::header::Header;
use crate::atomic::AtomicFile;
use crate::error::Error;
use crate::rows::check_frame;

/// Writes frames as one 3-D array (frames, rows, columns), little-endian, one behind the other.
pub struct NpyWriter<Q> {
    file: AtomicFile,
    element: Element,
    frames: u64,
    maximum: f64,
    shape: (usize, usize),
    bytes: Vec<u8>,
    quantity: PhantomData<Q>,
}

impl<Q> NpyWriter<Q> {
    /// Begins the file for frames of `rows` × `columns`; it appears with [`NpyWriter::commit`].
    ///
    /// # Errors
    /// [`Error::Create`].
    pub fn create(
        path: impl AsRef<Path>,
        rows: usize,
        columns: usize,
        element: Element,
    ) -> Result<Self, Error> {
        let mut file = AtomicFile::create(path)?;
        if !file.can_go_back() {
            let name = file.path().to_owned();
            return Err(Error::CannotGoBack {
                file: name,
                frames: 0,
            });
        }
        file.put(&Header::write(element, &[0, rows as u64, columns as u64]))?;
        Ok(Self {
            file,
            element,
            frames: 0,
            maximum: f64::MAX,
            shape: (rows, columns),
            bytes: Vec::new(),
            quantity: PhantomData,
        })
    }

    /// The same, but infinite numbers are written too: standard errors of what nothing bounds. Such a file is not read
    /// back by this library.
    pub fn allow_infinity(mut self) -> Self {
        self.maximum = f64::INFINITY;
        self
    }

    /// Appends a frame.
    ///
    /// # Errors
    /// [`Error::Write`] (disk full), [`Error::FrameShape`], [`Error::Value`] for a value that is not finite,
    /// [`Error::DoesNotFit`] for one that the number type cannot hold.
    pub fn write(&mut self, frame: &Frame<Q>) -> Result<(), Error> {
        let name = self.file.path();
        encode(
            frame,
            self.element,
            name,
            self.frames,
            (self.shape, self.maximum),
            &mut self.bytes,
        )?;
        self.file.put(&self.bytes)?;
        self.frames += 1;
        Ok(())
    }

    /// Frames written so far.
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// Fills in the number of frames, finishes the file and gives it its name.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn commit(mut self) -> Result<(), Error> {
        let (rows, columns) = self.shape;
        let shape = [self.frames, rows as u64, columns as u64];
        self.file
            .put_at_start(&Header::write(self.element, &shape))?;
        self.file.commit()
    }
}

fn encode<Q>(
    frame: &Frame<Q>,
    element: Element,
    name: &Path,
    number: u64,
    (shape, maximum): ((usize, usize), f64),
    out: &mut Vec<u8>,
) -> Result<(), Error> {
    check_frame(frame, name, number, Some(shape), -f64::MAX..=maximum)?;
    let is_lost = |value: &&f64| value.is_finite() && !element.holds(**value);
    // Whatever is allowed in a frame is a number of eight bytes.
    let mut narrow = frame.values().iter().filter(|_| element != Element::F8);
    if let Some(found) = narrow.find(is_lost) {
        let (minimum, maximum) = element.range();
        return Err(Error::DoesNotFit {
            file: name.to_owned(),
            found: *found,
            element: element.name(),
            minimum,
            maximum,
        });
    }
    out.clear();
    element.encode(frame.values(), out);
    Ok(())
}

/// Writes named arrays into one compressed archive, frame by frame. The number of frames of each array must
/// be known when it is begun.
pub struct NpzWriter {
    archive: ZipWriter<StreamWriter<AtomicFile>>,
    name: PathBuf,
    kept: Arc<OnceLock<PathBuf>>,
    array: Option<Array>,
    maximum: f64,
    written: u64,
    bytes: Vec<u8>,
}

/// The array being written.
struct Array {
    shown: PathBuf,
    element: Element,
    shape: (usize, usize),
    announced: u64,
    frames: u64,
}

impl NpzWriter {
    /// Begins the file, which appears with [`NpzWriter::commit`].
    ///
    /// # Errors
    /// [`Error::Create`].
    pub fn create(path: impl AsRef<Path>) -> Result<Self, Error> {
        let file = AtomicFile::create(path)?;
        Ok(Self {
            name: file.path().to_owned(),
            kept: file.kept(),
            archive: ZipWriter::new_stream(file),
            array: None,
            maximum: f64::MAX,
            written: 0,
            bytes: Vec::new(),
        })
    }

    /// The same, but infinite numbers are written too, as [`NpyWriter::allow_infinity`].
    pub fn allow_infinity(mut self) -> Self {
        self.maximum = f64::INFINITY;
        self
    }

    /// Begins the array `name` of frames of `rows` × `columns`: 3-D for `Some(frames)`, 2-D (one frame) for
    /// `None`.
    ///
    /// # Errors
    /// [`Error::Write`], also for a name that is taken; [`Error::FrameCount`] when the array before has not
    /// the frames announced for it.
    pub fn begin_array(
        &mut self,
        name: &str,
        frames: Option<u64>,
        rows: usize,
        columns: usize,
        element: Element,
    ) -> Result<(), Error> {
        self.end_array()?;
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .large_file(true);
        let begun = self.archive.start_file(format!("{name}.npy"), options);
        begun.map_err(|error| self.error(error))?;
        let (r, c) = (rows as u64, columns as u64);
        let header = match frames {
            Some(frames) => Header::write(element, &[frames, r, c]),
            None => Header::write(element, &[r, c]),
        };
        self.put(&header)?;
        self.array = Some(Array {
            shown: self.name.join(name),
            element,
            shape: (rows, columns),
            announced: frames.unwrap_or(1),
            frames: 0,
        });
        Ok(())
    }

    /// Appends a frame to the array begun last.
    ///
    /// # Errors
    /// As [`NpyWriter::write`]; [`Error::FrameCount`] for a frame more than announced.
    pub fn write<Q>(&mut self, frame: &Frame<Q>) -> Result<(), Error> {
        let mut bytes = std::mem::take(&mut self.bytes);
        let Some(array) = self.array.as_mut() else {
            let file = self.name.clone();
            return Err(Error::FrameCount {
                file,
                found: 1,
                expected: 0,
            });
        };
        encode(
            frame,
            array.element,
            &array.shown,
            array.frames,
            (array.shape, self.maximum),
            &mut bytes,
        )?;
        array.frames += 1;
        if array.frames > array.announced {
            return Err(array.wrong_count());
        }
        self.put(&bytes)?;
        self.bytes = bytes;
        Ok(())
    }

    /// Finishes the file and gives it its name.
    ///
    /// # Errors
    /// [`Error::Write`]; [`Error::FrameCount`] when the last array has not the frames announced for it.
    pub fn commit(mut self) -> Result<(), Error> {
        self.end_array()?;
        let Self {
            archive,
            name,
            kept,
            written,
            ..
        } = self;
        match archive.finish() {
            Ok(out) => out.into_inner().commit(),
            Err(error) => Err(write_error(&name, &kept, written, error)),
        }
    }

    fn end_array(&mut self) -> Result<(), Error> {
        match self.array.take() {
            Some(array) if array.frames != array.announced => Err(array.wrong_count()),
            _ => Ok(()),
        }
    }

    fn put(&mut self, bytes: &[u8]) -> Result<(), Error> {
        let result = self.archive.write_all(bytes);
        result.map_err(|source| self.error(ZipError::Io(source)))?;
        self.written += bytes.len() as u64;
        Ok(())
    }

    fn error(&self, error: ZipError) -> Error {
        write_error(&self.name, &self.kept, self.written, error)
    }
}

impl Array {
    fn wrong_count(&self) -> Error {
        Error::FrameCount {
            file: self.shown.clone(),
            found: self.frames,
            expected: self.announced,
        }
    }
}

fn write_error(name: &Path, kept: &OnceLock<PathBuf>, bytes: u64, error: ZipError) -> Error {
    Error::Write {
        file: name.to_owned(),
        bytes,
        kept: kept.get().cloned(),
        source: match error {
            ZipError::Io(source) => source,
            other => io::Error::other(other),
        },
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use taxel::Counts;

    #[test]
    fn a_full_disk_is_told_by_every_writer() {
        let frame = Frame::<Counts>::zeros(2, 2);
        let mut writer = NpzWriter::create("/dev/full").unwrap();
        writer.begin_array("a", None, 2, 2, Element::U2).unwrap();
        writer.write(&frame).unwrap();
        let error = writer.commit().unwrap_err().to_string();
        assert!(
            error.starts_with("cannot finish /dev/full after "),
            "{error}"
        );
        assert!(error.contains("nothing is kept\nhint: "), "{error}");
        let error = NpyWriter::<Counts>::create("/dev/null", 2, 2, Element::U2).err();
        assert!(error.unwrap().to_string().contains("a pipe cannot go back"));
    }

    #[test]
    fn an_array_has_as_many_frames_as_announced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npz");
        let frame = Frame::<Counts>::zeros(2, 2);
        let mut writer = NpzWriter::create(&path).unwrap();
        assert!(matches!(
            writer.write(&frame),
            Err(Error::FrameCount { .. })
        ));
        writer.begin_array("a", Some(2), 2, 2, Element::U2).unwrap();
        writer.write(&frame).unwrap();
        let error = writer
            .begin_array("b", None, 2, 2, Element::U2)
            .unwrap_err();
        assert!(
            matches!(
                error,
                Error::FrameCount {
                    found: 1,
                    expected: 2,
                    ..
                }
            ),
            "{error}"
        );
        drop(writer);
        assert!(!path.exists());
    }
}
