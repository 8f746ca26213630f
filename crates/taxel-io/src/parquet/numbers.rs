//! The numbers of a column, row by row, whatever type they are stored as.

use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{DataType, DoubleType, FloatType, Int32Type, Int64Type};
use parquet::errors::Result;

/// A column's reader and its present row.
pub(super) enum Numbers {
    I32(Column<Int32Type>),
    I64(Column<Int64Type>),
    F32(Column<FloatType>),
    F64(Column<DoubleType>),
}

/// A column of one type.
pub(super) struct Column<T: DataType> {
    reader: ColumnReaderImpl<T>,
    values: Vec<T::T>,
    definition: Vec<i16>,
    repetition: Vec<i16>,
}

/// A column's next row.
pub(super) struct Row {
    /// Whether there was one.
    pub(super) is_there: bool,
    /// Its numbers, and places without one.
    pub(super) places: usize,
}

impl Numbers {
    /// `None` for a type that is no number.
    pub(super) fn new(reader: ColumnReader) -> Option<Self> {
        Some(match reader {
            ColumnReader::Int32ColumnReader(reader) => Self::I32(Column::new(reader)),
            ColumnReader::Int64ColumnReader(reader) => Self::I64(Column::new(reader)),
            ColumnReader::FloatColumnReader(reader) => Self::F32(Column::new(reader)),
            ColumnReader::DoubleColumnReader(reader) => Self::F64(Column::new(reader)),
            _ => return None,
        })
    }

    /// Reads the next row's numbers into `out`.
    pub(super) fn next(&mut self, out: &mut Vec<f64>) -> Result<Row> {
        match self {
            Self::I32(column) => column.next(out, |&value| f64::from(value)),
            // Nanoseconds since 1970 lose what is below a quarter of a microsecond.
            Self::I64(column) => column.next(out, |&value| value as f64),
            Self::F32(column) => column.next(out, |&value| f64::from(value)),
            Self::F64(column) => column.next(out, |&value| value),
        }
    }
}

impl<T: DataType> Column<T> {
    fn new(reader: ColumnReaderImpl<T>) -> Self {
        Self {
            reader,
            values: Vec::new(),
            definition: Vec::new(),
            repetition: Vec::new(),
        }
    }

    fn next(&mut self, out: &mut Vec<f64>, number: impl Fn(&T::T) -> f64) -> Result<Row> {
        self.values.clear();
        self.definition.clear();
        self.repetition.clear();
        let (rows, _, places) = self.reader.read_records(
            1,
            Some(&mut self.definition),
            Some(&mut self.repetition),
            &mut self.values,
        )?;
        out.clear();
        out.extend(self.values.iter().map(number));
        Ok(Row {
            // Behind the last row there may be an empty page: the row is then whole, and not counted.
            is_there: rows > 0 || places > 0,
            places,
        })
    }
}
