//! A plain table of numbers, every column a double.

use std::path::Path;

use super::thrift::Struct;
use super::{DOUBLE, MAGIC, put_chunk, write_chunk};
use crate::atomic::AtomicFile;
use crate::column::Column;
use crate::error::Error;

/// Writes columns of equal length as one group of rows; what is not finite stays what it is.
pub(crate) fn write(path: &Path, columns: &[Column]) -> Result<(), Error> {
    let mut file = AtomicFile::create(path)?;
    file.put(MAGIC)?;
    let mut at = MAGIC.len() as u64;
    let rows = columns.first().map_or(0, |column| column.values.len());
    let mut chunks = Vec::new();
    for column in columns {
        let page: Vec<u8> = column
            .values
            .iter()
            .flat_map(|value| value.to_le_bytes())
            .collect();
        let name = vec![column.name.clone()];
        chunks.push(put_chunk(
            &mut file, path, &mut at, name, DOUBLE, rows, &page,
        )?);
    }
    let mut footer = Vec::new();
    let mut about = Struct::begin(&mut footer);
    about.i32(1, 2); // version
    let names: Vec<Option<&str>> = std::iter::once(None)
        .chain(columns.iter().map(|column| Some(column.name.as_str())))
        .collect();
    about.structs(2, &names, |name, fields| match name {
        None => {
            fields.text(4, "schema");
            fields.i32(5, columns.len() as i32);
        }
        Some(name) => {
            fields.i32(1, DOUBLE);
            fields.i32(3, 0); // always there
            fields.text(4, name);
        }
    });
    about.i64(3, rows as i64);
    about.structs(4, &[&chunks], |chunks, fields| {
        fields.structs(1, chunks, write_chunk);
        let bytes: u64 = chunks.iter().map(|chunk| chunk.plain_bytes).sum();
        fields.i64(2, bytes as i64);
        fields.i64(3, rows as i64);
    });
    about.text(6, concat!("taxel version ", env!("CARGO_PKG_VERSION")));
    about.end();
    file.put(&footer)?;
    file.put(&(footer.len() as u32).to_le_bytes())?;
    file.put(MAGIC)?;
    file.commit()
}
