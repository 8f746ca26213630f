//! Frames of counts, of loads, or of both as a Parquet table, written: one row a frame.
//!
//! | column | type |
//! |---|---|
//! | `sequence` | int64 |
//! | `time_secs` | double: device time, NaN where unknown |
//! | `host_time` | timestamp, µs, UTC |
//! | `counts` | fixed-size list of rows · columns uint16, row by row |
//! | `newtons` | fixed-size list of rows · columns double |
//! | `marks` | fixed-size list of rows · columns uint8: how far each load can be trusted |
//!
//! The Parquet crate with its arrow types takes longer to compile than the rest of this program together; this one
//! table needs one page a column, plain numbers and zstd. Source: the format's specification (parquet-format 2.10).

mod columns;
mod schema;
mod thrift;

pub(crate) use columns::write as write_columns;

use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use taxel::{Counts, Frame, Newtons, Sensor};

use crate::atomic::AtomicFile;
use crate::error::Error;
use crate::rows::check_counts;
use schema::{Meaning, elements};
use thrift::{Struct, varint};

const MAGIC: &[u8; 4] = b"PAR1";
/// Numbers of counts that a group of rows holds, about: what a reader holds at once.
const GROUP: usize = 1 << 20;
const LEVEL: i32 = 3;
/// Arrow's own description of the columns, with the length of the lists to be put in at these places: pyarrow wrote
/// it, and readers that know Arrow find a fixed-size list by it.
struct Arrow {
    schema: &'static [u8],
    lengths_at: &'static [usize],
}

static COUNTS: Arrow = Arrow {
    schema: include_bytes!("arrow.schema"),
    lengths_at: &[116],
};
static LOADS: Arrow = Arrow {
    schema: include_bytes!("arrow-loads.schema"),
    lengths_at: &[120, 220],
};
static COUNTS_AND_LOADS: Arrow = Arrow {
    schema: include_bytes!("arrow-counts-loads.schema"),
    lengths_at: &[124, 216, 308],
};

/// Physical types.
const INT32: i32 = 1;
const INT64: i32 = 2;
const DOUBLE: i32 = 5;

/// A column of the table.
struct Column {
    name: &'static str,
    kind: i32,
    meaning: Meaning,
    /// One number a taxel, not one a row.
    is_list: bool,
    /// Plain numbers of the present group.
    values: Vec<u8>,
}

impl Column {
    fn new(name: &'static str, kind: i32, meaning: Meaning, is_list: bool) -> Self {
        Self {
            name,
            kind,
            meaning,
            is_list,
            values: Vec::new(),
        }
    }

    fn path(&self) -> Vec<String> {
        let inner: &[&str] = if self.is_list {
            &["list", "element"]
        } else {
            &[]
        };
        let names = std::iter::once(self.name).chain(inner.iter().copied());
        names.map(str::to_owned).collect()
    }
}

/// Where a column of a group went.
struct Chunk {
    kind: i32,
    path: Vec<String>,
    offset: u64,
    values: u64,
    plain_bytes: u64,
    packed_bytes: u64,
}

struct Group {
    chunks: Vec<Chunk>,
    rows: u64,
}

/// Writes a table, which appears with [`ParquetWriter::commit`].
pub struct ParquetWriter {
    file: AtomicFile,
    path: std::path::PathBuf,
    at: u64,
    shape: (usize, usize),
    sensor_toml: String,
    arrow: &'static Arrow,
    /// Number, times, then what stands for every taxel.
    columns: Vec<Column>,
    rows: u64,
    rows_in_group: usize,
    groups: Vec<Group>,
}

impl ParquetWriter {
    /// Begins a table of a sensor's counts.
    ///
    /// # Errors
    /// [`Error::Create`], [`Error::Write`].
    pub fn create(path: impl AsRef<Path>, sensor: &Sensor) -> Result<Self, Error> {
        Self::begin(path.as_ref(), sensor, &COUNTS)
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
        let arrow = if has_counts {
            &COUNTS_AND_LOADS
        } else {
            &LOADS
        };
        Self::begin(path.as_ref(), sensor, arrow)
    }

    fn begin(path: &Path, sensor: &Sensor, arrow: &'static Arrow) -> Result<Self, Error> {
        let path = path.to_owned();
        let mut file = AtomicFile::create(&path)?;
        file.put(MAGIC)?;
        let mut columns = vec![
            Column::new("sequence", INT64, Meaning::Plain, false),
            Column::new("time_secs", DOUBLE, Meaning::Plain, false),
            Column::new("host_time", INT64, Meaning::Micros, false),
        ];
        if !std::ptr::eq(arrow, &LOADS) {
            columns.push(Column::new("counts", INT32, Meaning::Uint16, true));
        }
        if !std::ptr::eq(arrow, &COUNTS) {
            columns.push(Column::new("newtons", DOUBLE, Meaning::Plain, true));
            columns.push(Column::new("marks", INT32, Meaning::Uint8, true));
        }
        Ok(Self {
            file,
            path,
            at: MAGIC.len() as u64,
            shape: (sensor.rows(), sensor.columns()),
            sensor_toml: sensor.to_toml(),
            arrow,
            columns,
            rows: 0,
            rows_in_group: 0,
            groups: Vec::new(),
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
        let newtons = loads.values().iter().flat_map(|load| load.to_le_bytes());
        self.column("newtons").extend(newtons);
        let codes = loads.marks().iter().map(|mark| i32::from(mark.code()));
        let codes = codes.flat_map(i32::to_le_bytes);
        self.column("marks").extend(codes);
        self.end_row(loads.sequence, loads.time_secs, host)
    }

    fn put_counts(&mut self, frame: &Frame<Counts>) -> Result<(), Error> {
        self.check_shape(frame)?;
        check_counts(
            frame,
            &self.path,
            "the table holds raw counts, whole numbers of up to 16 bits; averaged recordings keep their fractions in .npy",
        )?;
        let numbers = frame.values().iter();
        let bytes = numbers.flat_map(|&count| (count as i32).to_le_bytes());
        self.column("counts").extend(bytes);
        Ok(())
    }

    fn check_shape<Q>(&self, frame: &Frame<Q>) -> Result<(), Error> {
        let found = (frame.rows(), frame.columns());
        if found == self.shape {
            Ok(())
        } else {
            Err(Error::FrameShape {
                file: self.path.clone(),
                frame: frame.sequence,
                found,
                expected: self.shape,
            })
        }
    }

    /// The numbers of a column that the table has.
    fn column(&mut self, name: &str) -> &mut Vec<u8> {
        let found = self.columns.iter_mut().find(|column| column.name == name);
        &mut found.expect("the table was begun with it").values
    }

    fn end_row(
        &mut self,
        sequence: u64,
        time_secs: Option<f64>,
        host: SystemTime,
    ) -> Result<(), Error> {
        let since = host.duration_since(UNIX_EPOCH).unwrap_or_default();
        let secs = time_secs.unwrap_or(f64::NAN);
        let numbers = [
            (sequence as i64).to_le_bytes(),
            secs.to_le_bytes(),
            (since.as_micros() as i64).to_le_bytes(),
        ];
        for (column, number) in self.columns.iter_mut().zip(numbers) {
            column.values.extend(number);
        }
        self.rows += 1;
        self.rows_in_group += 1;
        if self.rows_in_group * self.taxels() >= GROUP {
            self.close_group()
        } else {
            Ok(())
        }
    }

    /// Finishes the file and gives it its name.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn commit(mut self) -> Result<(), Error> {
        self.close_group()?;
        let footer = self.footer();
        self.file.put(&footer)?;
        self.file.put(&(footer.len() as u32).to_le_bytes())?;
        self.file.put(MAGIC)?;
        self.file.commit()
    }

    fn taxels(&self) -> usize {
        self.shape.0 * self.shape.1
    }

    fn close_group(&mut self) -> Result<(), Error> {
        let rows = std::mem::take(&mut self.rows_in_group);
        if rows == 0 {
            return Ok(());
        }
        let taxels = self.taxels();
        let mut group = Group {
            chunks: Vec::new(),
            rows: rows as u64,
        };
        for column in &mut self.columns {
            let numbers = if column.is_list { rows * taxels } else { rows };
            let mut page = Vec::with_capacity(column.values.len() + 64);
            if column.is_list {
                put_levels(&mut page, rows, taxels);
            }
            page.append(&mut column.values);
            let chunk = put_chunk(
                &mut self.file,
                &self.path,
                &mut self.at,
                column.path(),
                column.kind,
                numbers,
                &page,
            )?;
            group.chunks.push(chunk);
        }
        self.groups.push(group);
        Ok(())
    }

    fn footer(&self) -> Vec<u8> {
        let mut out = Vec::new();
        let mut file = Struct::begin(&mut out);
        file.i32(1, 2); // version
        file.structs(2, &elements(&self.columns), |element, fields| {
            element.write(fields);
        });
        file.i64(3, self.rows as i64);
        file.structs(4, &self.groups, |group, fields| {
            fields.structs(1, &group.chunks, write_chunk);
            let bytes: u64 = group.chunks.iter().map(|chunk| chunk.plain_bytes).sum();
            fields.i64(2, bytes as i64);
            fields.i64(3, group.rows as i64);
        });
        let mut arrow = self.arrow.schema.to_vec();
        for &at in self.arrow.lengths_at {
            arrow[at..at + 4].copy_from_slice(&(self.taxels() as u32).to_le_bytes());
        }
        let entries = [
            ("ARROW:schema", base64(&arrow)),
            ("taxel.rows", self.shape.0.to_string()),
            ("taxel.columns", self.shape.1.to_string()),
            ("taxel.sensor_toml", self.sensor_toml.clone()),
        ];
        file.structs(5, &entries, |(key, value), fields| {
            fields.text(1, key);
            fields.text(2, value);
        });
        file.text(6, concat!("taxel version ", env!("CARGO_PKG_VERSION")));
        file.end();
        out
    }
}

/// Packs a page of plain numbers and writes it, with its header, as a column's chunk.
fn put_chunk(
    file: &mut AtomicFile,
    name: &Path,
    at: &mut u64,
    path: Vec<String>,
    kind: i32,
    numbers: usize,
    page: &[u8],
) -> Result<Chunk, Error> {
    let packed = zstd::bulk::compress(page, LEVEL).map_err(|source| Error::Write {
        file: name.to_owned(),
        bytes: *at,
        kept: None,
        source,
    })?;
    let mut header = Vec::new();
    let mut fields = Struct::begin(&mut header);
    fields.i32(1, 0); // a data page
    fields.i32(2, page.len() as i32);
    fields.i32(3, packed.len() as i32);
    fields.inner(5, |data| {
        data.i32(1, numbers as i32);
        data.i32(2, 0); // plain
        data.i32(3, 3); // run lengths
        data.i32(4, 3);
    });
    fields.end();
    file.put(&header)?;
    file.put(&packed)?;
    let chunk = Chunk {
        kind,
        path,
        offset: *at,
        values: numbers as u64,
        plain_bytes: (header.len() + page.len()) as u64,
        packed_bytes: (header.len() + packed.len()) as u64,
    };
    *at += chunk.packed_bytes;
    Ok(chunk)
}

fn write_chunk(chunk: &Chunk, fields: &mut Struct) {
    fields.i64(2, 0);
    fields.inner(3, |about| {
        about.i32(1, chunk.kind);
        about.i32s(2, &[0, 3]);
        about.texts(3, &chunk.path);
        about.i32(4, 6); // zstd
        about.i64(5, chunk.values as i64);
        about.i64(6, chunk.plain_bytes as i64);
        about.i64(7, chunk.packed_bytes as i64);
        about.i64(9, chunk.offset as i64);
    });
}

/// Repetition and definition of a list that is always there and always full: a row's first number is 0, the others 1;
/// all are defined.
fn put_levels(page: &mut Vec<u8>, rows: usize, taxels: usize) {
    let mut repetition = Vec::new();
    let run = |out: &mut Vec<u8>, count: usize, level: u8| {
        if count > 0 {
            varint(out, (count as u64) << 1);
            out.push(level);
        }
    };
    for _ in 0..rows {
        run(&mut repetition, 1, 0);
        run(&mut repetition, taxels - 1, 1);
    }
    let mut definition = Vec::new();
    run(&mut definition, rows * taxels, 1);
    for levels in [repetition, definition] {
        page.extend((levels.len() as u32).to_le_bytes());
        page.extend(levels);
    }
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let number = three
            .iter()
            .fold(0u32, |number, &byte| number << 8 | u32::from(byte))
            << (8 * (3 - three.len()));
        for digit in 0..4 {
            if digit <= three.len() {
                text.push(DIGITS[(number >> (18 - 6 * digit)) as usize & 63] as char)
            } else {
                text.push('=')
            }
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_known_words() {
        for (word, coded) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(base64(word.as_bytes()), coded);
        }
    }

    #[test]
    fn the_lengths_of_the_lists_have_their_places() {
        for arrow in [&COUNTS, &LOADS, &COUNTS_AND_LOADS] {
            for &at in arrow.lengths_at {
                assert_eq!(arrow.schema[at..at + 4], [0; 4]);
            }
        }
    }
}
