//! A table of numbers for a spreadsheet or a notebook: `.csv`, `.xlsx`, `.parquet` by the name.

use std::ffi::OsStr;
use std::fmt::Write;
use std::path::Path;

use crate::atomic::AtomicFile;
use crate::column::Column;
use crate::error::Error;
use crate::{parquet, xlsx};

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
        "json" => write_json(path, columns),
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

/// A list of records, a line each; what is not finite is `null`.
fn write_json(path: &Path, columns: &[Column]) -> Result<(), Error> {
    let mut file = AtomicFile::create(path)?;
    let names: Vec<String> = columns
        .iter()
        .map(|column| serde_json::Value::from(column.name.as_str()).to_string())
        .collect();
    let rows = columns.first().map_or(0, |column| column.values.len());
    let mut line = String::new();
    for row in 0..rows {
        line.clear();
        line.push_str(if row == 0 { "[{" } else { ",\n{" });
        for (i, (name, column)) in names.iter().zip(columns).enumerate() {
            let comma = if i > 0 { "," } else { "" };
            // Rust writes a finite number as JSON does; writing to a string cannot fail.
            let _ = match column.values[row] {
                value if value.is_finite() => write!(line, "{comma}{name}:{value}"),
                _ => write!(line, "{comma}{name}:null"),
            };
        }
        line.push('}');
        file.put(line.as_bytes())?;
    }
    file.put(if rows == 0 { b"[]\n" } else { b"]\n" })?;
    file.commit()
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn json_is_a_list_of_records() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        let read = |columns: &[Column]| -> serde_json::Value {
            write_columns(&path, columns).unwrap();
            serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap()
        };
        let found = read(&columns());
        assert_eq!(found.as_array().unwrap().len(), 3);
        assert_eq!(found[2]["row 1, column <2>"], -3e-9);
        assert!(found[1]["row 1, column <2>"].is_null() && found[1]["frame"] == 1.0);
        assert_eq!(read(&[]), serde_json::json!([]));
    }

    #[cfg(feature = "xlsx")]
    #[test]
    fn a_sheet_has_the_names_above_the_numbers_and_empty_cells() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.xlsx");
        write_columns(&path, &columns()).unwrap();
        // Its numbers are read by another's library in .ci/reference-readers.
        let mut archive = zip::ZipArchive::new(std::fs::File::open(path).unwrap()).unwrap();
        let mut sheet = String::new();
        let mut part = archive.by_name("xl/worksheets/sheet1.xml").unwrap();
        std::io::Read::read_to_string(&mut part, &mut sheet).unwrap();
        assert!(sheet.contains("row 1, column &lt;2&gt;"), "{sheet}");
        for cell in [
            "\"A4\"><v>2</v>",
            "\"B2\"><v>0.5</v>",
            "\"B4\"><v>-0.000000003</v>",
        ] {
            assert!(sheet.contains(cell), "{cell}: {sheet}");
        }
        assert!(!sheet.contains("NaN") && !sheet.contains("r=\"B3\""));
        let wide = vec![columns()[0].clone(); 16_385];
        let error = write_columns(folder.path().join("b.xlsx"), &wide).unwrap_err();
        let words = "4 rows x 16385 columns, but a sheet holds 1048576 x 16384";
        assert!(error.to_string().contains(words), "{error}");
    }

    #[cfg(feature = "parquet")]
    #[test]
    fn parquet_holds_every_number() {
        use ::parquet::file::reader::{FileReader, SerializedFileReader};
        use ::parquet::record::Field;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.parquet");
        write_columns(&path, &columns()).unwrap();
        let file = std::fs::File::open(path).unwrap();
        let reader = SerializedFileReader::new(file).unwrap();
        let mut found = 0;
        for (at, row) in reader.get_row_iter(None).unwrap().enumerate() {
            let row = row.unwrap();
            let cells: Vec<_> = row.get_column_iter().collect();
            assert_eq!(cells.len(), 2);
            for ((name, field), column) in cells.into_iter().zip(&columns()) {
                assert_eq!(name, &column.name);
                let Field::Double(value) = field else {
                    panic!("{field:?}");
                };
                assert_eq!(value.to_bits(), column.values[at].to_bits());
                found += 1;
            }
        }
        assert_eq!(found, 6);
    }

    #[cfg(not(any(feature = "parquet", feature = "xlsx")))]
    #[test]
    fn a_format_that_is_left_out_is_told() {
        for name in ["a.xlsx", "a.parquet"] {
            let error = write_columns(name, &columns()).unwrap_err();
            assert!(matches!(error, Error::NotBuilt { .. }), "{error}");
        }
    }

    #[test]
    fn other_names_are_refused() {
        let refused = write_columns("table.doc", &columns());
        assert!(matches!(refused, Err(Error::UnknownFormat { .. })));
    }
}
