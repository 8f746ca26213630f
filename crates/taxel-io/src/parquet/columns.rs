//! A plain table of numbers, every column a double.

use std::path::Path;

use parquet::basic::Type as Physical;
use parquet::data_type::DoubleType;
use parquet::file::properties::{EnabledStatistics, WriterProperties};

use super::write::{Output, put, scalar};
use crate::column::Column;
use crate::error::Error;

/// Rows of a group.
const GROUP: usize = 1 << 20;

/// Writes columns of equal length; what is not finite stays what it is.
pub(crate) fn write(path: &Path, columns: &[Column]) -> Result<(), Error> {
    let types = columns
        .iter()
        .map(|column| scalar(&column.name, Physical::DOUBLE, None))
        .collect::<Result<_, _>>();
    let types = types.map_err(|error| Error::Create {
        file: path.to_owned(),
        source: std::io::Error::other(error),
    })?;
    let properties = WriterProperties::builder().set_statistics_enabled(EnabledStatistics::Chunk);
    let mut output = Output::create(path, types, properties)?;
    let rows = columns.first().map_or(0, |column| column.values.len());
    for begin in (0..rows).step_by(GROUP) {
        let end = rows.min(begin + GROUP);
        output.write_group(|group| {
            for column in columns {
                put::<DoubleType>(group, &column.values[begin..end], None)?;
            }
            Ok(())
        })?;
    }
    output.commit()
}
