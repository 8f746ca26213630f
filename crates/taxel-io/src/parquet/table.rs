//! What the end of a table's file says: its columns, rows and metadata.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use parquet::basic::{LogicalType, TimeUnit, Type};
use parquet::file::metadata::{ParquetMetaData, ParquetMetaDataReader};
use parquet::schema::types::ColumnDescPtr;

use super::{COUNTS, HOST_TIME, MARKS, META_COLUMNS, META_ROWS, META_SENSOR, SEQUENCE, TIME_SECS};
use crate::error::{Error, ParquetError};
use crate::source::open_file;

const MAGIC: &[u8; 4] = b"PAR1";
/// Length of the description, and the magic.
const TAIL_BYTES: u64 = 8;
/// Largest description that is read: of some 40,000 groups of rows, more than ten hours of a large sensor.
const MAX_FOOTER_BYTES: u64 = 16 << 20;

/// An open file and its description.
pub(super) struct Table {
    pub(super) file: File,
    pub(super) bytes: u64,
    pub(super) metadata: ParquetMetaData,
    /// Rows of all groups.
    pub(super) rows: u64,
}

/// Where the columns stand, counted by their leaves.
pub(super) struct Leaves {
    pub(super) values: usize,
    pub(super) marks: Option<usize>,
    pub(super) sequence: Option<usize>,
    pub(super) time_secs: Option<usize>,
    /// With the length of its unit, nanoseconds.
    pub(super) host_time: Option<(usize, u64)>,
}

impl Table {
    /// Reads the description at the end of a file.
    ///
    /// # Errors
    /// [`Error::Open`], [`ParquetError::NotParquet`].
    pub(super) fn open(path: &Path) -> Result<Self, Error> {
        let (mut file, total) = open_file(path)?;
        let not_parquet = |reason: String| {
            Error::from(ParquetError::NotParquet {
                file: path.to_owned(),
                reason,
            })
        };
        let Some(bytes) = total else {
            let words = "it is a pipe or a device, and such a file is read from its end";
            return Err(not_parquet(words.to_owned()));
        };
        let unread = |source| Error::Read {
            file: path.to_owned(),
            bytes: 0,
            source,
        };
        if bytes < TAIL_BYTES + MAGIC.len() as u64 {
            let words = format!("it has {bytes} bytes, at least 12 expected");
            return Err(not_parquet(words));
        }
        let mut tail = [0; TAIL_BYTES as usize];
        file.seek(SeekFrom::Start(bytes - TAIL_BYTES))
            .and_then(|_| file.read_exact(&mut tail))
            .map_err(unread)?;
        let [a, b, c, d, magic @ ..] = tail;
        if &magic != MAGIC {
            let words = format!("it ends with `{}`, not `PAR1`", magic.escape_ascii());
            return Err(not_parquet(words));
        }
        let length = u64::from(u32::from_le_bytes([a, b, c, d]));
        let room = (bytes - TAIL_BYTES - MAGIC.len() as u64).min(MAX_FOOTER_BYTES);
        if length > room {
            return Err(not_parquet(format!(
                "its description has {length} bytes, at most {room} expected"
            )));
        }
        let mut footer = vec![0; length as usize];
        file.seek(SeekFrom::Start(bytes - TAIL_BYTES - length))
            .and_then(|_| file.read_exact(&mut footer))
            .map_err(unread)?;
        let metadata = ParquetMetaDataReader::decode_metadata(&footer)
            .map_err(|error| not_parquet(format!("its description cannot be read ({error})")))?;
        let groups = metadata.row_groups().iter();
        if groups.clone().any(|group| group.num_rows() < 0) {
            return Err(not_parquet("a group of less than 0 rows".to_owned()));
        }
        let rows = groups.map(|group| group.num_rows().unsigned_abs());
        let rows = rows.fold(0, u64::saturating_add);
        Ok(Self {
            file,
            bytes,
            metadata,
            rows,
        })
    }

    /// What stands under a key of its metadata.
    fn value(&self, key: &str) -> Option<&str> {
        let all = self.metadata.file_metadata().key_value_metadata()?;
        let found = all.iter().find(|entry| entry.key == key)?;
        found.value.as_deref()
    }

    /// Rows and columns of a frame, where the metadata says so.
    pub(super) fn shape(&self) -> Option<(usize, usize)> {
        let number = |key| self.value(key)?.parse().ok();
        Some((number(META_ROWS)?, number(META_COLUMNS)?))
    }

    /// The columns of frames whose numbers stand in `values`.
    ///
    /// # Errors
    /// [`ParquetError::NoColumn`], [`ParquetError::ColumnType`] for a column that is there and is no list of numbers.
    pub(super) fn leaves(&self, path: &Path, values: &'static str) -> Result<Leaves, Error> {
        let schema = self.metadata.file_metadata().schema_descr();
        let found = |name: &str| {
            let mut leaves = schema.columns().iter().enumerate();
            leaves.find(|(_, leaf)| leaf.path().parts().first().is_some_and(|part| part == name))
        };
        let Some((at, leaf)) = found(values) else {
            let fields = schema.root_schema().get_fields().iter();
            return Err(Error::from(ParquetError::NoColumn {
                file: path.to_owned(),
                missing: values,
                found: fields.map(|field| field.name().to_owned()).collect(),
                is_counts: values == COUNTS,
            }));
        };
        check_list(path, values, leaf)?;
        // The others are told where they are there as this program writes them.
        let list = |name| found(name).filter(|(_, leaf)| is_number(leaf) && is_list(leaf));
        let plain =
            |name| found(name).filter(|(_, leaf)| is_number(leaf) && leaf.max_rep_level() == 0);
        let unit = |leaf: &ColumnDescPtr| match leaf.logical_type_ref()? {
            LogicalType::Timestamp(time) => Some(match time.unit {
                TimeUnit::MILLIS => 1_000_000,
                TimeUnit::MICROS => 1_000,
                TimeUnit::NANOS => 1,
            }),
            _ => None,
        };
        Ok(Leaves {
            values: at,
            marks: list(MARKS).map(|(at, _)| at),
            sequence: plain(SEQUENCE).map(|(at, _)| at),
            time_secs: plain(TIME_SECS).map(|(at, _)| at),
            host_time: plain(HOST_TIME).and_then(|(at, leaf)| Some((at, unit(leaf)?))),
        })
    }
}

fn is_number(leaf: &ColumnDescPtr) -> bool {
    matches!(
        leaf.physical_type(),
        Type::INT32 | Type::INT64 | Type::FLOAT | Type::DOUBLE
    )
}

fn is_list(leaf: &ColumnDescPtr) -> bool {
    leaf.max_rep_level() == 1
}

fn check_list(path: &Path, column: &'static str, leaf: &ColumnDescPtr) -> Result<(), Error> {
    if is_number(leaf) && is_list(leaf) {
        return Ok(());
    }
    let kind = leaf.physical_type();
    Err(Error::from(ParquetError::ColumnType {
        file: path.to_owned(),
        column,
        found: match leaf.max_rep_level() {
            0 => format!("one {kind} a row"),
            1 => format!("a list of {kind}"),
            levels => format!("lists in lists, {levels} deep, of {kind}"),
        },
    }))
}

/// Rows and columns of a table's frames, where its metadata tells them, and how many there are.
///
/// # Errors
/// Those of [`Table::open`]; [`ParquetError::NoShape`] for a table that tells the one and not the other.
pub(crate) fn shape_of(path: &Path) -> Result<(Option<(usize, usize)>, u64), Error> {
    let table = Table::open(path)?;
    let missing = match (table.value(META_ROWS), table.value(META_COLUMNS)) {
        // Another program's.
        (None, None) => return Ok((None, table.rows)),
        (None, Some(_)) => META_ROWS,
        (Some(_), None) => META_COLUMNS,
        (Some(rows), Some(_)) => match table.shape() {
            Some(shape) => return Ok((Some(shape), table.rows)),
            // One of them is no number.
            None if rows.parse::<usize>().is_ok() => META_COLUMNS,
            None => META_ROWS,
        },
    };
    Err(Error::from(ParquetError::NoShape {
        file: path.to_owned(),
        missing,
    }))
}

/// The sensor file that a table carries.
///
/// # Errors
/// Those of [`Table::open`].
pub(crate) fn sensor_toml_of(path: &Path) -> Result<Option<String>, Error> {
    Ok(Table::open(path)?.value(META_SENSOR).map(str::to_owned))
}
