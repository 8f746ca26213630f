//! A table of numbers for a spreadsheet or a notebook: `.csv`, `.xlsx`, `.parquet` by the name.

use std::ffi::OsStr;
use std::fmt::Write;
use std::path::Path;

use crate::atomic::AtomicFile;
use crate::error::Error;
use crate::{parquet, xlsx};

/// A column; a number that is not finite is an empty cell (in Parquet it stays what it is).
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Its name.
    pub name: String,
    /// Its numbers, as many as every other column has.
    pub values: Vec<f64>,
}

/// Writes columns of equal length, in the format of the name.
///
/// # Errors
/// [`Error::UnknownFormat`], [`Error::Create`], [`Error::Write`]; [`Error::SheetSize`] for more than a spreadsheet holds.
pub fn write_columns(path: impl AsRef<Path>, columns: &[Column]) -> Result<(), Error> {
    let path = path.as_ref();
    let extension = path.extension().and_then(OsStr::to_str).unwrap_or_default();
    match extension.to_ascii_lowercase().as_str() {
        "csv" => write_csv(path, columns),
        "xlsx" => xlsx::write(path, columns),
        "parquet" => parquet::write_columns(path, columns),
        other => Err(Error::UnknownFormat {
            file: path.to_owned(),
            extension: match other {
                "" => String::new(),
                other => format!(".{other}"),
            },
        }),
    }
}

fn write_csv(path: &Path, columns: &[Column]) -> Result<(), Error> {
    let mut file = AtomicFile::create(path)?;
    let quoted = |column: &Column| {
        if column.name.contains([',', '"']) {
            format!("\"{}\"", column.name.replace('"', "\"\""))
        } else {
            column.name.clone()
        }
    };
    let names: Vec<String> = columns.iter().map(quoted).collect();
    file.put(format!("{}\n", names.join(",")).as_bytes())?;
    let rows = columns.first().map_or(0, |column| column.values.len());
    let mut line = String::new();
    for row in 0..rows {
        line.clear();
        for (i, column) in columns.iter().enumerate() {
            if i > 0 {
                line.push(',');
            }
            let value = column.values[row];
            if value.is_finite() {
                // Writing to a string cannot fail.
                let _ = write!(line, "{value}");
            }
        }
        line.push('\n');
        file.put(line.as_bytes())?;
    }
    file.commit()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    fn columns() -> Vec<Column> {
        let column = |name: &str, values: &[f64]| Column {
            name: name.to_owned(),
            values: values.to_vec(),
        };
        vec![
            column("frame", &[0.0, 1.0, 2.0]),
            column("row 1, column <2>", &[0.5, f64::NAN, -3e-9]),
        ]
    }

    #[test]
    fn csv_has_names_and_empty_cells() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        write_columns(&path, &columns()).unwrap();
        let text = std::fs::read_to_string(path).unwrap();
        assert_eq!(
            text,
            "frame,\"row 1, column <2>\"\n0,0.5\n1,\n2,-0.000000003\n"
        );
    }

    #[test]
    fn a_sheet_is_an_archive_of_the_parts_that_a_spreadsheet_wants() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.xlsx");
        write_columns(&path, &columns()).unwrap();
        let mut archive = zip::ZipArchive::new(std::fs::File::open(path).unwrap()).unwrap();
        let mut sheet = String::new();
        let mut part = archive.by_name("xl/worksheets/sheet1.xml").unwrap();
        part.read_to_string(&mut sheet).unwrap();
        assert!(
            sheet.contains(
                "<c r=\"B1\" t=\"inlineStr\"><is><t>row 1, column &lt;2&gt;</t></is></c>"
            )
        );
        assert!(sheet.contains("<c r=\"A4\"><v>2</v></c><c r=\"B4\"><v>-0.000000003</v></c>"));
        assert!(!sheet.contains("NaN") && !sheet.contains("r=\"B3\""));
    }

    #[test]
    fn parquet_begins_and_ends_as_it_must_and_holds_every_number() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.parquet");
        write_columns(&path, &columns()).unwrap();
        let bytes = std::fs::read(path).unwrap();
        assert!(bytes.starts_with(b"PAR1") && bytes.ends_with(b"PAR1"));
        let length = u32::from_le_bytes(bytes[bytes.len() - 8..][..4].try_into().unwrap());
        assert!((length as usize) < bytes.len() - 12);
        let footer = &bytes[bytes.len() - 8 - length as usize..];
        let has = |name: &[u8]| footer.windows(name.len()).any(|window| window == name);
        assert!(has(b"frame") && has(b"row 1, column <2>"));
    }

    #[test]
    fn other_names_are_refused() {
        let refused = write_columns("table.doc", &columns());
        assert!(matches!(refused, Err(Error::UnknownFormat { .. })));
    }
}
