//! `foxglove.Grid` as protobuf: one value (or a few) a taxel, row by row.
//!
//! Field numbers are those of Foxglove's published schema; `foxglove.Grid.desc` beside this file is its descriptor
//! (MIT licence, foxglove-schemas-protobuf 0.4.0), which every recording carries.

use std::path::Path;

use crate::error::Error;
use prost::Message;
use prost::encoding::{DecodeContext, decode_key, skip_field};

/// Name of the schema.
pub(super) const SCHEMA: &str = "foxglove.Grid";
/// Its descriptor set.
pub(super) const DESCRIPTOR: &[u8] = include_bytes!("foxglove.Grid.desc");

/// A point in time.
#[derive(Clone, PartialEq, Message)]
pub(super) struct Timestamp {
    #[prost(int64, tag = "1")]
    pub seconds: i64,
    #[prost(int32, tag = "2")]
    pub nanos: i32,
}

#[derive(Clone, PartialEq, Message)]
pub(super) struct Vector2 {
    #[prost(double, tag = "1")]
    pub x: f64,
    #[prost(double, tag = "2")]
    pub y: f64,
}

#[derive(Clone, PartialEq, Message)]
pub(super) struct Vector3 {
    #[prost(double, tag = "1")]
    pub x: f64,
    #[prost(double, tag = "2")]
    pub y: f64,
    #[prost(double, tag = "3")]
    pub z: f64,
}

#[derive(Clone, PartialEq, Message)]
pub(super) struct Quaternion {
    #[prost(double, tag = "1")]
    pub x: f64,
    #[prost(double, tag = "2")]
    pub y: f64,
    #[prost(double, tag = "3")]
    pub z: f64,
    #[prost(double, tag = "4")]
    pub w: f64,
}

#[derive(Clone, PartialEq, Message)]
pub(super) struct Pose {
    #[prost(message, optional, tag = "1")]
    pub position: Option<Vector3>,
    #[prost(message, optional, tag = "2")]
    pub orientation: Option<Quaternion>,
}

/// A number of every cell.
#[derive(Clone, PartialEq, Message)]
pub(super) struct Field {
    #[prost(string, tag = "1")]
    pub name: String,
    #[prost(fixed32, tag = "2")]
    pub offset: u32,
    #[prost(enumeration = "Numeric", tag = "3")]
    pub numeric: i32,
}

/// Types of numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, prost::Enumeration)]
#[repr(i32)]
pub(super) enum Numeric {
    Unknown = 0,
    Uint8 = 1,
    Int8 = 2,
    Uint16 = 3,
    Int16 = 4,
    Uint32 = 5,
    Int32 = 6,
    Float32 = 7,
    Float64 = 8,
}

impl Numeric {
    fn bytes(self) -> usize {
        match self {
            Numeric::Unknown => 0,
            Numeric::Uint8 | Numeric::Int8 => 1,
            Numeric::Uint16 | Numeric::Int16 => 2,
            Numeric::Uint32 | Numeric::Int32 | Numeric::Float32 => 4,
            Numeric::Float64 => 8,
        }
    }

    /// A little-endian number; `None` beyond the end of `bytes`.
    fn read(self, bytes: &[u8]) -> Option<f64> {
        let bytes = bytes.get(..self.bytes())?;
        Some(match self {
            Numeric::Unknown => return None,
            Numeric::Uint8 => f64::from(bytes[0]),
            Numeric::Int8 => f64::from(bytes[0] as i8),
            Numeric::Uint16 => f64::from(u16::from_le_bytes(bytes.try_into().ok()?)),
            Numeric::Int16 => f64::from(i16::from_le_bytes(bytes.try_into().ok()?)),
            Numeric::Uint32 => f64::from(u32::from_le_bytes(bytes.try_into().ok()?)),
            Numeric::Int32 => f64::from(i32::from_le_bytes(bytes.try_into().ok()?)),
            Numeric::Float32 => f64::from(f32::from_le_bytes(bytes.try_into().ok()?)),
            Numeric::Float64 => f64::from_le_bytes(bytes.try_into().ok()?),
        })
    }
}

/// The message.
#[derive(Clone, PartialEq, Message)]
pub(super) struct Grid {
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    #[prost(string, tag = "2")]
    pub frame_id: String,
    #[prost(message, optional, tag = "3")]
    pub pose: Option<Pose>,
    #[prost(fixed32, tag = "4")]
    pub column_count: u32,
    #[prost(message, optional, tag = "5")]
    pub cell_size: Option<Vector2>,
    #[prost(fixed32, tag = "6")]
    pub row_stride: u32,
    #[prost(fixed32, tag = "7")]
    pub cell_stride: u32,
    #[prost(message, repeated, tag = "8")]
    pub fields: Vec<Field>,
    #[prost(bytes = "vec", tag = "9")]
    pub data: Vec<u8>,
}

/// The most fields that a cell is believed to have: memory goes with the bytes of a message, not with the number of
/// empty fields in it.
const MAX_FIELDS: usize = 64;
/// Tag of the fields in a grid's message.
const FIELDS: u32 = 8;

impl Grid {
    /// A grid from a message.
    ///
    /// # Errors
    /// Why it is none, in words.
    pub fn read_from(message: &[u8]) -> Result<Self, String> {
        let (mut rest, mut fields) = (message, 0);
        while !rest.is_empty() {
            let skip = decode_key(&mut rest).and_then(|(tag, wire)| {
                fields += usize::from(tag == FIELDS);
                skip_field(wire, tag, &mut rest, DecodeContext::default())
            });
            skip.map_err(|error| error.to_string())?;
        }
        if fields > MAX_FIELDS {
            return Err(format!(
                "a grid with {fields} fields a cell, at most {MAX_FIELDS} expected"
            ));
        }
        Self::decode(message).map_err(|error| error.to_string())
    }

    /// Refuses a grid of another shape than (rows, columns), turned over where `transposed`; `file` and `frame` are its
    /// place.
    pub(crate) fn check_shape(
        &self,
        (rows, columns): (usize, usize),
        transposed: bool,
        file: &Path,
        frame: u64,
    ) -> Result<(), Error> {
        let found = (self.rows(), self.column_count as usize);
        let expected = if transposed {
            (columns, rows)
        } else {
            (rows, columns)
        };
        if found == expected {
            Ok(())
        } else {
            Err(Error::FrameShape {
                file: file.to_owned(),
                frame,
                found,
                expected,
            })
        }
    }

    /// An empty grid with these fields, one behind the other in each cell. Cells are `pitch_mm` (between rows, between
    /// columns) large.
    pub fn new(columns: usize, pitch_mm: [f64; 2], fields: &[(&str, Numeric)]) -> Self {
        let mut offset = 0;
        let fields: Vec<Field> = fields
            .iter()
            .map(|(name, numeric)| {
                let field = Field {
                    name: (*name).to_owned(),
                    offset,
                    numeric: *numeric as i32,
                };
                offset += numeric.bytes() as u32;
                field
            })
            .collect();
        Self {
            timestamp: None,
            frame_id: "taxel".to_owned(),
            pose: Some(Pose {
                position: Some(Vector3::default()),
                orientation: Some(Quaternion {
                    w: 1.0,
                    ..Quaternion::default()
                }),
            }),
            column_count: columns as u32,
            cell_size: Some(Vector2 {
                x: pitch_mm[1] / 1000.0,
                y: pitch_mm[0] / 1000.0,
            }),
            row_stride: columns as u32 * offset,
            cell_stride: offset,
            fields,
            data: Vec::new(),
        }
    }

    /// Nanoseconds since 1970.
    pub fn set_time(&mut self, nanos: u64) {
        self.timestamp = Some(Timestamp {
            seconds: (nanos / 1_000_000_000) as i64,
            nanos: (nanos % 1_000_000_000) as i32,
        });
    }

    /// Rows that the data has; none where rows or cells would lie on each other.
    pub fn rows(&self) -> usize {
        let (cell, columns) = (u64::from(self.cell_stride), u64::from(self.column_count));
        match u64::from(self.row_stride) {
            0 => 0,
            row if cell == 0 || cell * columns > row => 0,
            row => self.data.len() / row as usize,
        }
    }

    /// The field of that name, or the first.
    pub fn field(&self, name: &str) -> Option<&Field> {
        let named = self.fields.iter().find(|field| field.name == name);
        named.or_else(|| self.fields.first())
    }

    /// Copies a field's numbers, row by row; false when the data ends before them.
    pub fn read(&self, field: &Field, values: &mut [f64]) -> bool {
        let Ok(numeric) = Numeric::try_from(field.numeric) else {
            return false;
        };
        let columns = self.column_count as usize;
        for (i, value) in values.iter_mut().enumerate() {
            let at = (i / columns).checked_mul(self.row_stride as usize);
            let cell = (i % columns).checked_mul(self.cell_stride as usize);
            let found = at
                .zip(cell)
                .and_then(|(row, cell)| row.checked_add(cell)?.checked_add(field.offset as usize))
                .and_then(|at| numeric.read(self.data.get(at..)?));
            match found {
                Some(found) => *value = found,
                None => return false,
            }
        }
        true
    }
}
