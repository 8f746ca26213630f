//! Frames of counts as a Parquet table, written: one row a frame.
//!
//! | column | type |
//! |---|---|
//! | `sequence` | int64 |
//! | `time_secs` | double: device time, NaN where unknown |
//! | `host_time` | timestamp, µs, UTC |
//! | `counts` | fixed-size list of rows · columns uint16, row by row |
//!
//! The Parquet crate with its arrow types takes longer to compile than the rest of this program together; this one
//! table needs one page a column, plain numbers and zstd. Source: the format's specification (parquet-format 2.10).

mod columns;
mod thrift;

pub(crate) use columns::write as write_columns;

use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use taxel::{Counts, Frame, Sensor};

use crate::atomic::AtomicFile;
use crate::error::Error;
use crate::rows::check_counts;
use thrift::{Struct, varint};

const MAGIC: &[u8; 4] = b"PAR1";
/// Numbers of counts that a group of rows holds, about: what a reader holds at once.
const GROUP: usize = 1 << 20;
const LEVEL: i32 = 3;
/// Arrow's own description of the columns, with the length of the list to be put in: pyarrow wrote it, and readers
/// that know Arrow find a fixed-size list by it.
const ARROW_SCHEMA: &[u8] = include_bytes!("arrow.schema");
const LENGTH_AT: usize = 116;

/// Physical types.
const INT32: i32 = 1;
const INT64: i32 = 2;
const DOUBLE: i32 = 5;

/// A column of the table.
struct Column {
    path: &'static [&'static str],
    kind: i32,
    /// Plain numbers of the present group.
    values: Vec<u8>,
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
    columns: [Column; 4],
    rows: u64,
    groups: Vec<Group>,
}

impl ParquetWriter {
    /// Begins a table of frames of a sensor.
    ///
    /// # Errors
    /// [`Error::Create`], [`Error::Write`].
    pub fn create(path: impl AsRef<Path>, sensor: &Sensor) -> Result<Self, Error> {
        let path = path.as_ref().to_owned();
        let mut file = AtomicFile::create(&path)?;
        file.put(MAGIC)?;
        let column = |path, kind| Column {
            path,
            kind,
            values: Vec::new(),
        };
        Ok(Self {
            file,
            path,
            at: MAGIC.len() as u64,
            shape: (sensor.rows(), sensor.columns()),
            sensor_toml: sensor.to_toml(),
            columns: [
                column(&["sequence"], INT64),
                column(&["time_secs"], DOUBLE),
                column(&["host_time"], INT64),
                column(&["counts", "list", "element"], INT32),
            ],
            rows: 0,
            groups: Vec::new(),
        })
    }

    /// Appends a frame.
    ///
    /// # Errors
    /// [`Error::FrameShape`]; [`Error::Value`] for a count that is no whole number of 16 bits; [`Error::Write`].
    pub fn write(&mut self, frame: &Frame<Counts>, host: SystemTime) -> Result<(), Error> {
        let found = (frame.rows(), frame.columns());
        if found != self.shape {
            return Err(Error::FrameShape {
                file: self.path.clone(),
                frame: frame.sequence,
                found,
                expected: self.shape,
            });
        }
        let micros = host
            .duration_since(UNIX_EPOCH)
            .unwrap_or_default()
            .as_micros() as i64;
        let [sequence, time, host, counts] = &mut self.columns;
        sequence
            .values
            .extend((frame.sequence as i64).to_le_bytes());
        let secs = frame.time_secs.unwrap_or(f64::NAN);
        time.values.extend(secs.to_le_bytes());
        host.values.extend(micros.to_le_bytes());
        check_counts(
            frame,
            &self.path,
            "the table holds raw counts, whole numbers of up to 16 bits; averaged recordings keep their fractions in .npy",
        )?;
        for &count in frame.values() {
            counts.values.extend((count as i32).to_le_bytes());
        }
        self.rows += 1;
        if counts.values.len() >= 4 * GROUP {
            self.close_group()?;
        }
        Ok(())
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
        let rows = self.columns[0].values.len() / 8;
        if rows == 0 {
            return Ok(());
        }
        let taxels = self.taxels();
        let mut group = Group {
            chunks: Vec::new(),
            rows: rows as u64,
        };
        for column in &mut self.columns {
            let is_list = column.kind == INT32;
            let numbers = if is_list { rows * taxels } else { rows };
            let mut page = Vec::with_capacity(column.values.len() + 64);
            if is_list {
                put_levels(&mut page, rows, taxels);
            }
            page.append(&mut column.values);
            let path = column.path.iter().map(|&name| name.to_owned()).collect();
            let chunk = put_chunk(
                &mut self.file,
                &self.path,
                &mut self.at,
                path,
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
        file.structs(2, &SCHEMA, |element, fields| element.write(fields));
        file.i64(3, self.rows as i64);
        file.structs(4, &self.groups, |group, fields| {
            fields.structs(1, &group.chunks, write_chunk);
            let bytes: u64 = group.chunks.iter().map(|chunk| chunk.plain_bytes).sum();
            fields.i64(2, bytes as i64);
            fields.i64(3, group.rows as i64);
        });
        let mut arrow = ARROW_SCHEMA.to_vec();
        arrow[LENGTH_AT..LENGTH_AT + 4].copy_from_slice(&(self.taxels() as u32).to_le_bytes());
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

/// One line of the schema.
struct Element {
    kind: Option<i32>,
    repetition: Option<i32>,
    name: &'static str,
    children: Option<i32>,
    meaning: Meaning,
}

#[derive(Clone, Copy, PartialEq)]
enum Meaning {
    Plain,
    List,
    Uint16,
    Micros,
}

const fn element(
    kind: Option<i32>,
    repetition: Option<i32>,
    name: &'static str,
    children: Option<i32>,
    meaning: Meaning,
) -> Element {
    Element {
        kind,
        repetition,
        name,
        children,
        meaning,
    }
}

const REQUIRED: Option<i32> = Some(0);
const REPEATED: Option<i32> = Some(2);
const SCHEMA: [Element; 7] = [
    element(None, None, "schema", Some(4), Meaning::Plain),
    element(Some(INT64), REQUIRED, "sequence", None, Meaning::Plain),
    element(Some(DOUBLE), REQUIRED, "time_secs", None, Meaning::Plain),
    element(Some(INT64), REQUIRED, "host_time", None, Meaning::Micros),
    element(None, REQUIRED, "counts", Some(1), Meaning::List),
    element(None, REPEATED, "list", Some(1), Meaning::Plain),
    element(Some(INT32), REQUIRED, "element", None, Meaning::Uint16),
];

impl Element {
    fn write(&self, fields: &mut Struct) {
        if let Some(kind) = self.kind {
            fields.i32(1, kind);
        }
        if let Some(repetition) = self.repetition {
            fields.i32(3, repetition);
        }
        fields.text(4, self.name);
        if let Some(children) = self.children {
            fields.i32(5, children);
        }
        // Once as old readers know it, once as new ones do.
        match self.meaning {
            Meaning::Plain => {}
            Meaning::List => {
                fields.i32(6, 3);
                fields.inner(10, |kind| kind.inner(3, |_| ()));
            }
            Meaning::Uint16 => {
                fields.i32(6, 12);
                fields.inner(10, |kind| {
                    kind.inner(10, |integer| {
                        integer.i8(1, 16);
                        integer.boolean(2, false);
                    });
                });
            }
            Meaning::Micros => {
                fields.i32(6, 10);
                fields.inner(10, |kind| {
                    kind.inner(8, |time| {
                        time.boolean(1, true);
                        time.inner(2, |unit| unit.inner(2, |_| ()));
                    });
                });
            }
        }
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
            match digit <= three.len() {
                true => text.push(DIGITS[(number >> (18 - 6 * digit)) as usize & 63] as char),
                false => text.push('='),
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
    fn the_length_of_the_list_has_its_place() {
        assert_eq!(ARROW_SCHEMA[LENGTH_AT..LENGTH_AT + 4], [0; 4]);
    }
}
