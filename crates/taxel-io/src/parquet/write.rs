//! Writing a table, a group of rows at a time.

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};
use std::time::{SystemTime, UNIX_EPOCH};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use parquet::basic::{Compression, LogicalType, Repetition, TimeUnit, Type as Physical, ZstdLevel};
use parquet::data_type::{DataType, DoubleType, Int32Type, Int64Type};
use parquet::errors::{ParquetError, Result as ParquetResult};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties, WriterPropertiesBuilder};
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{ColumnPath, Type, TypePtr};
use taxel::{Counts, Frame, Newtons, Sensor};

use super::{
    COUNTS, HOST_TIME, MARKS, META_COLUMNS, META_ROWS, META_SENSOR, NEWTONS, SEQUENCE, TIME_SECS,
};
use crate::atomic::AtomicFile;
use crate::error::Error;
use crate::rows::check_counts;

/// Numbers of a list that a group of rows holds, about.
const GROUP: usize = 1 << 20;
const LEVEL: i32 = 3;

/// The file below: an error of it leaves what was written, and this knows where.
pub(super) struct Output {
    writer: SerializedFileWriter<AtomicFile>,
    path: PathBuf,
    kept: Arc<OnceLock<PathBuf>>,
}

impl Output {
    /// Begins a file of these columns.
    pub(super) fn create(
        path: &Path,
        columns: Vec<TypePtr>,
        properties: WriterPropertiesBuilder,
    ) -> Result<Self, Error> {
        let file = AtomicFile::create(path)?;
        let kept = file.kept();
        let level = ZstdLevel::try_new(LEVEL).unwrap_or_default();
        let properties = properties
            .set_compression(Compression::ZSTD(level))
            // Counts and loads seldom repeat.
            .set_dictionary_enabled(false)
            .set_offset_index_disabled(true)
            .set_created_by(concat!("taxel version ", env!("CARGO_PKG_VERSION")).to_owned())
            .build();
        let begun = Type::group_type_builder("schema")
            .with_fields(columns)
            .build()
            .and_then(|schema| {
                SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties))
            });
        match begun {
            Ok(writer) => Ok(Self {
                writer,
                path: path.to_owned(),
                kept,
            }),
            Err(error) => Err(failed(path, &kept, 0, error)),
        }
    }

    /// Writes a group of rows; `put` gives its columns, one by one.
    pub(super) fn write_group(
        &mut self,
        put: impl FnOnce(&mut SerializedRowGroupWriter<'_, AtomicFile>) -> ParquetResult<()>,
    ) -> Result<(), Error> {
        let written = self.writer.next_row_group().and_then(|mut group| {
            put(&mut group)?;
            group.close().map(|_| ())
        });
        let bytes = self.writer.bytes_written() as u64;
        written.map_err(|error| failed(&self.path, &self.kept, bytes, error))
    }

    /// Finishes the file and gives it its name.
    pub(super) fn commit(self) -> Result<(), Error> {
        let bytes = self.writer.bytes_written() as u64;
        match self.writer.into_inner() {
            Ok(file) => file.commit(),
            Err(error) => Err(failed(&self.path, &self.kept, bytes, error)),
        }
    }
}

fn failed(path: &Path, kept: &OnceLock<PathBuf>, bytes: u64, error: ParquetError) -> Error {
    let source = match error {
        ParquetError::External(inner) => match inner.downcast::<std::io::Error>() {
            Ok(source) => *source,
            Err(other) => std::io::Error::other(other),
        },
        other => std::io::Error::other(other),
    };
    Error::Write {
        file: path.to_owned(),
        bytes,
        kept: kept.get().cloned(),
        source,
    }
}

/// Writes the numbers of a group's next column.
pub(super) fn put<T: DataType>(
    group: &mut SerializedRowGroupWriter<'_, AtomicFile>,
    values: &[T::T],
    levels: Option<(&[i16], &[i16])>,
) -> ParquetResult<()> {
    let Some(mut column) = group.next_column()? else {
        let words = "a group of more columns than the table";
        return Err(ParquetError::General(words.to_owned()));
    };
    let (definition, repetition) = levels.unzip();
    column
        .typed::<T>()
        .write_batch(values, definition, repetition)?;
    column.close()
}

/// A column of one number a row, always there.
pub(super) fn scalar(
    name: &str,
    kind: Physical,
    meaning: Option<LogicalType>,
) -> ParquetResult<TypePtr> {
    let column = Type::primitive_type_builder(name, kind)
        .with_repetition(Repetition::REQUIRED)
        .with_logical_type(meaning);
    Ok(Arc::new(column.build()?))
}

/// A column of a list in each row; list and numbers are always there.
fn list(name: &str, kind: Physical, meaning: Option<LogicalType>) -> ParquetResult<TypePtr> {
    let group = |name, repetition, meaning, inner| {
        Type::group_type_builder(name)
            .with_repetition(repetition)
            .with_logical_type(meaning)
            .with_fields(vec![inner])
            .build()
            .map(Arc::new)
    };
    let element = scalar("element", kind, meaning)?;
    let repeated = group("list", Repetition::REPEATED, None, element)?;
    group(
        name,
        Repetition::REQUIRED,
        Some(LogicalType::List),
        repeated,
    )
}

/// Writes a table, which appears with [`ParquetWriter::commit`].
pub struct ParquetWriter {
    output: Output,
    shape: (usize, usize),
    has_counts: bool,
    has_loads: bool,
    /// The present group.
    group: Group,
}

/// The numbers of a group of rows.
#[derive(Default)]
struct Group {
    rows: usize,
    sequence: Vec<i64>,
    time_secs: Vec<f64>,
    host_time: Vec<i64>,
    counts: Vec<i32>,
    newtons: Vec<f64>,
    marks: Vec<i32>,
    /// Of a list that is always there and always full: all are defined, and a row's first number repeats nothing.
    definition: Vec<i16>,
    repetition: Vec<i16>,
}

impl ParquetWriter {
    /// Begins a table of a sensor's counts.
    ///
    /// # Errors
    /// [`Error::Create`], [`Error::Write`].
    pub fn create(path: impl AsRef<Path>, sensor: &Sensor) -> Result<Self, Error> {
        Self::begin(path.as_ref(), sensor, true, false)
    }

    /// Begins a table of a sensor's loads with their marks, and of its counts too where there are any.
    ///
    /// # Errors
    /// As [`Self::create`].
    pub fn create_with_loads(
        path: impl AsRef<Path>,
        sensor: &Sensor,
        has_counts: bool,
    ) -> Result<Self, Error> {
        Self::begin(path.as_ref(), sensor, has_counts, true)
    }

    fn begin(
        path: &Path,
        sensor: &Sensor,
        has_counts: bool,
        has_loads: bool,
    ) -> Result<Self, Error> {
        let shape = (sensor.rows(), sensor.columns());
        let entry = |key: &str, value: String| KeyValue::new(key.to_owned(), value);
        let metadata = vec![
            entry(
                "ARROW:schema",
                arrow_schema(has_counts, has_loads, shape.0 * shape.1),
            ),
            entry(META_ROWS, shape.0.to_string()),
            entry(META_COLUMNS, shape.1.to_string()),
            entry(META_SENSOR, sensor.to_toml()),
        ];
        let mut properties = WriterProperties::builder()
            .set_statistics_enabled(EnabledStatistics::None)
            .set_key_value_metadata(Some(metadata));
        // What a reader finds its rows by.
        for name in [SEQUENCE, TIME_SECS, HOST_TIME] {
            properties = properties
                .set_column_statistics_enabled(ColumnPath::from(name), EnabledStatistics::Chunk);
        }
        let columns = columns(has_counts, has_loads).map_err(|error| Error::Create {
            file: path.to_owned(),
            source: std::io::Error::other(error),
        })?;
        Ok(Self {
            output: Output::create(path, columns, properties)?,
            shape,
            has_counts,
            has_loads,
            group: Group::default(),
        })
    }

    /// Appends a frame to a table of counts.
    ///
    /// # Errors
    /// [`Error::FrameShape`]; [`Error::Value`] for a count that is no whole number of 16 bits; [`Error::Write`].
    pub fn write(&mut self, frame: &Frame<Counts>, host: SystemTime) -> Result<(), Error> {
        self.put_counts(frame)?;
        self.end_row(frame.sequence, frame.time_secs, host)
    }

    /// Appends a frame to a table of loads; `counts` where the table has them.
    ///
    /// # Errors
    /// As [`Self::write`].
    pub fn write_loads(
        &mut self,
        counts: Option<&Frame<Counts>>,
        loads: &Frame<Newtons>,
        host: SystemTime,
    ) -> Result<(), Error> {
        self.check_shape(loads)?;
        if let Some(counts) = counts {
            self.put_counts(counts)?;
        }
        self.group.newtons.extend(loads.values());
        let codes = loads.marks().iter().map(|mark| i32::from(mark.code()));
        self.group.marks.extend(codes);
        self.end_row(loads.sequence, loads.time_secs, host)
    }

    fn put_counts(&mut self, frame: &Frame<Counts>) -> Result<(), Error> {
        self.check_shape(frame)?;
        check_counts(
            frame,
            &self.output.path,
            "the table holds raw counts, whole numbers of up to 16 bits; averaged recordings keep their fractions in .npy",
        )?;
        let counts = frame.values().iter().map(|&count| count as i32);
        self.group.counts.extend(counts);
        Ok(())
    }

    fn check_shape<Q>(&self, frame: &Frame<Q>) -> Result<(), Error> {
        let found = (frame.rows(), frame.columns());
        if found == self.shape {
            return Ok(());
        }
        Err(Error::FrameShape {
            file: self.output.path.clone(),
            frame: frame.sequence,
            found,
            expected: self.shape,
        })
    }

    fn end_row(
        &mut self,
        sequence: u64,
        time_secs: Option<f64>,
        host: SystemTime,
    ) -> Result<(), Error> {
        let since = host.duration_since(UNIX_EPOCH).unwrap_or_default();
        let micros = i64::try_from(since.as_micros()).unwrap_or(i64::MAX);
        self.group.sequence.push(sequence as i64);
        self.group.time_secs.push(time_secs.unwrap_or(f64::NAN));
        self.group.host_time.push(micros);
        self.group.rows += 1;
        if self.group.rows * self.shape.0 * self.shape.1 >= GROUP {
            return self.close_group();
        }
        Ok(())
    }

    /// Finishes the file and gives it its name.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn commit(mut self) -> Result<(), Error> {
        self.close_group()?;
        self.output.commit()
    }

    fn close_group(&mut self) -> Result<(), Error> {
        let group = &mut self.group;
        if group.rows == 0 {
            return Ok(());
        }
        let taxels = self.shape.0 * self.shape.1;
        group.definition.resize(group.rows * taxels, 1);
        group.repetition.clear();
        group.repetition.resize(group.rows * taxels, 1);
        for first in group.repetition.iter_mut().step_by(taxels) {
            *first = 0;
        }
        let levels = Some((group.definition.as_slice(), group.repetition.as_slice()));
        let (has_counts, has_loads) = (self.has_counts, self.has_loads);
        self.output.write_group(|out| {
            put::<Int64Type>(out, &group.sequence, None)?;
            put::<DoubleType>(out, &group.time_secs, None)?;
            put::<Int64Type>(out, &group.host_time, None)?;
            if has_counts {
                put::<Int32Type>(out, &group.counts, levels)?;
            }
            if has_loads {
                put::<DoubleType>(out, &group.newtons, levels)?;
                put::<Int32Type>(out, &group.marks, levels)?;
            }
            Ok(())
        })?;
        group.rows = 0;
        group.sequence.clear();
        group.time_secs.clear();
        group.host_time.clear();
        group.counts.clear();
        group.newtons.clear();
        group.marks.clear();
        Ok(())
    }
}

/// The table's columns.
fn columns(has_counts: bool, has_loads: bool) -> ParquetResult<Vec<TypePtr>> {
    let unsigned = |bits| Some(LogicalType::integer(bits, false));
    let micros = Some(LogicalType::timestamp(true, TimeUnit::MICROS));
    let mut columns = vec![
        scalar(SEQUENCE, Physical::INT64, None)?,
        scalar(TIME_SECS, Physical::DOUBLE, None)?,
        scalar(HOST_TIME, Physical::INT64, micros)?,
    ];
    if has_counts {
        columns.push(list(COUNTS, Physical::INT32, unsigned(16))?);
    }
    if has_loads {
        columns.push(list(NEWTONS, Physical::DOUBLE, None)?);
        columns.push(list(MARKS, Physical::INT32, unsigned(8))?);
    }
    Ok(columns)
}

/// Arrow's own description of the columns, which pyarrow wrote, with the length of the lists to be put in at these places:
/// readers that know Arrow find a fixed-size list by it. The crate writes it too, with all of Arrow built for that.
struct Arrow {
    schema: &'static [u8],
    lengths_at: &'static [usize],
}

static ARROW_COUNTS: Arrow = Arrow {
    schema: include_bytes!("arrow.schema"),
    lengths_at: &[116],
};
static ARROW_LOADS: Arrow = Arrow {
    schema: include_bytes!("arrow-loads.schema"),
    lengths_at: &[120, 220],
};
static ARROW_COUNTS_AND_LOADS: Arrow = Arrow {
    schema: include_bytes!("arrow-counts-loads.schema"),
    lengths_at: &[124, 216, 308],
};

fn arrow_schema(has_counts: bool, has_loads: bool, taxels: usize) -> String {
    let arrow = match (has_counts, has_loads) {
        (_, false) => &ARROW_COUNTS,
        (false, true) => &ARROW_LOADS,
        (true, true) => &ARROW_COUNTS_AND_LOADS,
    };
    let mut bytes = arrow.schema.to_vec();
    for &at in arrow.lengths_at {
        bytes[at..at + 4].copy_from_slice(&(taxels as u32).to_le_bytes());
    }
    STANDARD.encode(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lengths_of_the_lists_have_their_places() {
        for arrow in [&ARROW_COUNTS, &ARROW_LOADS, &ARROW_COUNTS_AND_LOADS] {
            for &at in arrow.lengths_at {
                assert_eq!(arrow.schema[at..at + 4], [0; 4]);
            }
        }
    }
}
