//! One sheet of numbers as Office Open XML (ECMA-376), the least that Excel, LibreOffice and pandas open. The library that
//! writes all of the format (rust_xlsxwriter 0.102) takes 22 s of processor time in a cold build of 344 s, which is too long
//! already.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use crate::atomic::AtomicFile;
use crate::columns::Column;
use crate::error::Error;

/// What a sheet holds.
const MAX_ROWS: usize = 1_048_576;
const MAX_COLUMNS: usize = 16_384;

const TYPES: &str = r#"<?xml version="1.0" encoding="UTF-8" standalone="yes"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"><Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="xml" ContentType="application/xml"/><Override PartName="/xl/workbook.xml" ContentType="application/vnd.openxmlformats-officedocument.spreadsheetml.sheet.main+xml"/><Override PartName="/xl/worksheets/sheet1.xml" ContentType="application/vnd.openxmlformats-officedocument.spreadsheetml.worksheet+xml"/></Types>"#;
const ROOT: &str = r#"<?xml version="1.0" encoding="UTF-8" standalone="yes"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Id="rId1" Type="http://schemas.openxmlformats.org/officeDocument/2006/relationships/officeDocument" Target="xl/workbook.xml"/></Relationships>"#;
const WORKBOOK: &str = r#"<?xml version="1.0" encoding="UTF-8" standalone="yes"?>
<workbook xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main" xmlns:r="http://schemas.openxmlformats.org/officeDocument/2006/relationships"><sheets><sheet name="taxel" sheetId="1" r:id="rId1"/></sheets></workbook>"#;
const SHEETS: &str = r#"<?xml version="1.0" encoding="UTF-8" standalone="yes"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Id="rId1" Type="http://schemas.openxmlformats.org/officeDocument/2006/relationships/worksheet" Target="worksheets/sheet1.xml"/></Relationships>"#;
const SHEET: &str = r#"<?xml version="1.0" encoding="UTF-8" standalone="yes"?>
<worksheet xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"><sheetData>"#;

/// Writes columns of equal length below a line of names.
pub(crate) fn write(path: &Path, columns: &[Column]) -> Result<(), Error> {
    let rows = columns.first().map_or(0, |column| column.values.len());
    if rows + 1 > MAX_ROWS || columns.len() > MAX_COLUMNS {
        return Err(Error::SheetSize {
            file: path.to_owned(),
            rows: rows + 1,
            columns: columns.len(),
            most_rows: MAX_ROWS,
            most_columns: MAX_COLUMNS,
        });
    }
    let file = AtomicFile::create(path)?;
    let kept = file.kept();
    let failed = |source: std::io::Error| Error::Write {
        file: path.to_owned(),
        bytes: 0,
        kept: kept.get().cloned(),
        source,
    };
    let mut archive = ZipWriter::new_stream(file);
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
    for (name, text) in [
        ("[Content_Types].xml", TYPES),
        ("_rels/.rels", ROOT),
        ("xl/workbook.xml", WORKBOOK),
        ("xl/_rels/workbook.xml.rels", SHEETS),
        ("xl/worksheets/sheet1.xml", SHEET),
    ] {
        archive
            .start_file(name, options)
            .map_err(|e| failed(e.into()))?;
        archive.write_all(text.as_bytes()).map_err(failed)?;
    }
    let letters: Vec<String> = (0..columns.len()).map(column_letters).collect();
    let mut line = String::new();
    for row in 0..=rows {
        line.clear();
        // Writing to a string cannot fail.
        let _ = write!(line, "<row r=\"{}\">", row + 1);
        for (column, letters) in columns.iter().zip(&letters) {
            let place = format!("{letters}{}", row + 1);
            match row.checked_sub(1).map(|row| column.values[row]) {
                None => {
                    let name = escaped(&column.name);
                    let _ = write!(
                        line,
                        "<c r=\"{place}\" t=\"inlineStr\"><is><t>{name}</t></is></c>"
                    );
                }
                Some(value) if value.is_finite() => {
                    let _ = write!(line, "<c r=\"{place}\"><v>{value}</v></c>");
                }
                Some(_) => {}
            }
        }
        line.push_str("</row>");
        archive.write_all(line.as_bytes()).map_err(failed)?;
    }
    archive
        .write_all(b"</sheetData></worksheet>")
        .map_err(failed)?;
    let out = archive.finish().map_err(|e| failed(e.into()))?;
    out.into_inner().commit()
}

/// A, B, … Z, AA, …
fn column_letters(mut column: usize) -> String {
    let mut letters = Vec::new();
    loop {
        letters.push(b'A' + (column % 26) as u8);
        if column < 26 {
            break;
        }
        column = column / 26 - 1;
    }
    letters
        .iter()
        .rev()
        .map(|&letter| char::from(letter))
        .collect()
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_lettered_as_in_a_sheet() {
        let shown = [0, 25, 26, 51, 52, 701, 702, 16_383].map(column_letters);
        assert_eq!(shown, ["A", "Z", "AA", "AZ", "BA", "ZZ", "AAA", "XFD"]);
    }
}
