//! One sheet of numbers as Office Open XML (ECMA-376). Needs the feature `xlsx`.

#[cfg(feature = "xlsx")]
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
#[cfg(feature = "xlsx")]
use std::path::PathBuf;

#[cfg(feature = "xlsx")]
use rust_xlsxwriter::{Workbook, XlsxError};

#[cfg(feature = "xlsx")]
use crate::atomic::AtomicFile;
use crate::column::Column;
use crate::error::Error;

/// Writes columns of equal length below a line of names; what is not finite is an empty cell.
#[cfg(feature = "xlsx")]
pub(crate) fn write(path: &Path, columns: &[Column]) -> Result<(), Error> {
    check_size(path, columns)?;
    let mut file = AtomicFile::create(path)?;
    let kept = file.kept();
    // The crate has no error for a temporary file that cannot be written, as on a full disk: it panics. What the panic leaves
    // half done, the sheet and `file`, is not used after it.
    let saved = catch_unwind(AssertUnwindSafe(|| save(columns, &mut file)));
    let source = match saved {
        Ok(Ok(())) => return file.commit(),
        Ok(Err(XlsxError::IoError(source))) => source,
        Ok(Err(other)) => std::io::Error::other(other),
        Err(_) => std::io::Error::other(format!(
            "the temporary file of its lines, in {}, could not be written",
            temporary_folder(&file).display()
        )),
    };
    Err(Error::Write {
        file: path.to_owned(),
        bytes: 0,
        kept: kept.get().cloned(),
        source,
    })
}

/// Where there is room for the output; the system's own folder for such files may be smaller, or in memory. Of an output that
/// is a pipe or a device, there is nothing beside it.
#[cfg(feature = "xlsx")]
fn temporary_folder(file: &AtomicFile) -> PathBuf {
    file.folder()
        .map_or_else(std::env::temp_dir, Path::to_owned)
}

/// The sheet goes line by line through a temporary file on its way to `file`.
#[cfg(feature = "xlsx")]
fn save(columns: &[Column], file: &mut AtomicFile) -> Result<(), XlsxError> {
    let mut book = Workbook::new();
    book.set_tempdir(temporary_folder(file))?;
    let sheet = book.add_worksheet_with_constant_memory()?;
    sheet.set_name("taxel")?;
    for (column, at) in columns.iter().zip(0u16..) {
        sheet.write_string(0, at, &column.name)?;
    }
    let rows = columns.first().map_or(0, |column| column.values.len());
    for (row, line) in (0..rows).zip(1u32..) {
        for (column, at) in columns.iter().zip(0u16..) {
            let value = column.values[row];
            if value.is_finite() {
                sheet.write_number(line, at, value)?;
            }
        }
    }
    book.save_to_writer(file)
}

/// Refuses what a sheet does not hold.
#[cfg(feature = "xlsx")]
fn check_size(path: &Path, columns: &[Column]) -> Result<(), Error> {
    const MAX_ROWS: usize = 1_048_576;
    const MAX_COLUMNS: usize = 16_384;
    let rows = columns.first().map_or(0, |column| column.values.len());
    if rows < MAX_ROWS && columns.len() <= MAX_COLUMNS {
        return Ok(());
    }
    Err(Error::SheetSize {
        file: path.to_owned(),
        rows: rows + 1,
        columns: columns.len(),
        most_rows: MAX_ROWS,
        most_columns: MAX_COLUMNS,
    })
}

/// Refuses: this build writes no sheets.
#[cfg(not(feature = "xlsx"))]
pub(crate) fn write(path: &Path, _columns: &[Column]) -> Result<(), Error> {
    Err(Error::NotBuilt {
        file: path.to_owned(),
        format: "XLSX",
        feature: "xlsx",
    })
}
