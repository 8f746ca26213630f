//! Tables of presses and pairs, and recordings found by name.

use std::fs;
use std::path::PathBuf;

use taxel_io::experiments::{read_presses_from, taxel_of_label};
use taxel_io::{Error, Press, ReadOptions, open_counts, read_pairs, read_uniform_loads, shape_of};

fn presses(text: &str) -> Result<Vec<Press>, Error> {
    read_presses_from(text.as_bytes(), "rig/experiments.csv", 8, 4, None)
}

#[test]
fn columns_in_any_order_and_quotes() {
    let text = "\u{feff}Load_g, row,column,recording,frame,replicate,note,contact_area_mm2\r\n\
        12.5,7,3,\"a,b.txt\",10,r1,\"wet, then\ndry\",10\r\n\r\n,,,,,,,\r\n0,0,0,c.npy,0,,,,,\r\n";
    let found = presses(text).unwrap();
    assert_eq!(
        found[0],
        Press {
            recording: PathBuf::from("rig/a,b.txt"),
            frame: 10,
            row: 7,
            column: 3,
            load_g: 12.5,
            replicate: Some("r1".into()),
            contact_area_mm2: Some(10.0),
            note: Some("wet, then\ndry".into()),
            line: 2,
        }
    );
    assert_eq!((found[1].line, found[1].contact_area_mm2), (6, None));
}

#[test]
fn labels_name_taxels() {
    let found = presses("recording,frame,taxel,load_g\na.txt,0,C7,5\na.txt,1,d0,5\n").unwrap();
    assert_eq!((found[0].row, found[0].column), (7, 2));
    assert_eq!((found[1].row, found[1].column), (0, 3));
    for (label, map, taxel) in [
        ("A0", None, Some((0, 0))),
        ("Z12", None, Some((12, 25))),
        ("AB3", None, Some((3, 27))),
        ("C7", Some("HGFEDCBA"), Some((7, 5))),
        ("c7", Some("abcABC"), Some((7, 2))),
        ("c7", Some("ABC"), Some((7, 2))),
        ("D7", Some("ABC"), None),
        ("AB3", Some("ABC"), None),
        ("7", None, None),
        ("C", None, None),
        ("C7x", None, None),
        ("C99999999999999999999", None, None),
        ("ZZZZZZZZZZZZZZZZZZZZ1", None, None),
    ] {
        assert_eq!(taxel_of_label(label, map), taxel, "{label}");
    }
}

#[test]
fn bad_tables_say_what_where_and_both_numbers() {
    let at = "rig/experiments.csv, line";
    let head = "recording,frame,row,column,load_g\n";
    let needs =
        "hint: the header must have recording, frame, load_g, and row and column (or taxel)";
    let load = "hint: a decimal point, no unit: the unit is in the column's name";
    for (text, message) in [
        (String::new(), "no header in rig/experiments.csv: 0 found, at least 1 expected\nhint: the file is empty or holds blank lines only; was the recording ever started?".to_owned()),
        (head.to_owned(), "no press in rig/experiments.csv: 0 found, at least 1 expected\nhint: the file is empty or holds blank lines only; was the recording ever started?".to_owned()),
        ("recording,frame,row,load_g\n".into(), format!("no column `column` at {at} 1, column 1: the header has `recording,frame,row,load_g`\n{needs}")),
        ("recording,frame,load_g\n".into(), format!("no column `row` at {at} 1, column 1: the header has `recording,frame,load_g`\n{needs}")),
        ("recording,frame,row,column,laod_g\n".into(), format!("unknown column `laod_g` at {at} 1, column 1\nhint: did you mean `load_g`?")),
        ("recording;frame;row;column;load_g\n".into(), format!("unknown column `recording;frame;row;column;load_…` at {at} 1, column 1\nhint: cells are separated by commas")),
        (format!("{head}a,0,8,3,1\n"), format!("taxel outside the array at {at} 2, column 5: `8,3` is row 8, column 3, but the array has 8 rows x 4 columns, counted from 0\nhint: check the label, `labels` under [array] in the sensor file, and which sensor this is")),
        (format!("{head}a,0,7,3,heavy\n"), format!("`load_g` is `heavy` at {at} 2, column 9, but must be a finite number\n{load}")),
        (format!("{head}a,0,7,3,nan\n"), format!("`load_g` is `nan` at {at} 2, column 9, but must be a finite number\n{load}")),
        (format!("{head}a,0,7,3,-5\n"), format!("negative load_g at {at} 2, column 9: -5, at least 0 expected\nhint: subtract no tare from a labelled load")),
        (format!("{head}a,0,7,3,5\n\n\"b,c\",1.5,7,3,5\n"), format!("`frame` is `1.5` at {at} 4, column 7, but must be a whole number\nhint: it counts from 0")),
        (format!("{head}a,0,7\n"), format!("not a table at {at} 2, column 1: 3 cells found, 5 expected\nhint: one line a press, cells separated by commas; quote a cell that holds a comma")),
        (format!("{head}a,0,7,3,5,6\n"), format!("not a table at {at} 2, column 1: 6 cells found, 5 expected\nhint: one line a press, cells separated by commas; quote a cell that holds a comma")),
        (format!("{head},0,7,3,5\n"), format!("`recording` is `` at {at} 2, column 1, but must be the name of a recording\nhint: paths are relative to this table's folder")),
        ("recording,frame,taxel,load_g\na,0,E1,5\n".into(), format!("taxel outside the array at {at} 2, column 5: `E1` is row 1, column 4, but the array has 8 rows x 4 columns, counted from 0\nhint: check the label, `labels` under [array] in the sensor file, and which sensor this is")),
        ("recording,frame,taxel,load_g\na,0,17,5\n".into(), format!("`taxel` is `17` at {at} 2, column 5, but must be letters and a number, like `C7`\nhint: letters: the column, in the order of `labels` under [array] in the sensor file; number: the row, from 0")),
        ("recording,frame,taxel,row,column,load_g\na,0,C7,7,1,5\n".into(), format!("`taxel` is `C7` at {at} 2, column 5, but must be the same taxel as its row and column\nhint: leave out one of taxel and row, column, or the table contradicts itself")),
    ] {
        assert_eq!(presses(&text).unwrap_err().to_string(), message, "{text:?}");
    }
}

#[test]
fn a_label_or_a_row_and_column_in_each_line() {
    let text = "recording,frame,taxel,row,column,load_g\na,0,C7,,,5\na,0,,7,1,5\na,0,C7,7,2,5\n";
    let found = presses(text).unwrap();
    let taxels: Vec<_> = found.iter().map(|p| (p.row, p.column)).collect();
    assert_eq!(taxels, [(7, 2), (7, 1), (7, 2)]);
}

#[test]
fn text_that_is_not_utf8_is_told() {
    let text = b"recording,frame,row,column,load_g\nw\xe4rme.txt,0,0,0,5\n";
    let error = read_presses_from(&text[..], "e.csv", 8, 4, None).unwrap_err();
    assert_eq!(
        error.to_string(),
        "not text at e.csv, line 2, column 1: cell 1 is not UTF-8\nhint: save the table as CSV UTF-8"
    );
}

#[test]
fn uniform_loads_and_pairs() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("equilibration.csv");
    fs::write(&path, "frame,recording,load_g\n3,sub/a.txt,100\n").unwrap();
    let loads = read_uniform_loads(&path).unwrap();
    assert_eq!(loads[0].recording, folder.path().join("sub/a.txt"));
    assert_eq!(
        (loads[0].frame, loads[0].load_g, loads[0].line),
        (3, 100.0, 2)
    );

    let path = folder.path().join("pairs.csv");
    fs::write(&path, "load_n,resistance_ohms\n9.80665,2000\n").unwrap();
    let pairs = read_pairs(&path).unwrap();
    assert!((pairs[0].0 - 5e-4).abs() < 1e-18 && (pairs[0].1 - 1000.0).abs() < 1e-9);
    fs::write(&path, "conductance_siemens,load_g\n1e-6,0\n2e-6,3\n").unwrap();
    assert_eq!(read_pairs(&path).unwrap(), [(1e-6, 0.0), (2e-6, 3.0)]);
    fs::write(&path, "resistance_ohms,load_g\n0,3\n").unwrap();
    let error = read_pairs(&path).unwrap_err().to_string();
    assert!(
        error.contains("pairs.csv, line 2, column 1, but must be above 0"),
        "{error}"
    );
    fs::write(&path, "load_g\n3\n").unwrap();
    let error = read_pairs(&path).unwrap_err().to_string();
    assert!(
        error.starts_with("no column `conductance_siemens` at "),
        "{error}"
    );
}

#[test]
fn a_recording_is_known_by_its_name_and_its_shape_by_its_beginning() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        path
    };
    let shape = |path| {
        let shape = shape_of(path).unwrap();
        (shape.rows, shape.columns, shape.extra_line)
    };
    assert_eq!(
        shape(write("a.txt", "1,2,3,\n4,5,6,\n")),
        (None, Some(3), Some(false))
    );
    let csv = "\n1,2,3,\n4,5,6,\n\n1,2,3,\n";
    assert_eq!(shape(write("a.csv", csv)), (Some(2), Some(3), Some(true)));
    let timed = "12.5\n1,2,3,\n4,5,6,\n12.6\n1,2,3,\n";
    assert_eq!(shape(write("b.csv", timed)), (Some(2), Some(3), Some(true)));
    assert!(matches!(
        shape_of(write("e.txt", "\n")),
        Err(Error::Empty { .. })
    ));
    let error = open_counts(folder.path().join("no.txt"), ReadOptions::new(1, 1)).err();
    assert!(error.unwrap().to_string().starts_with("cannot open "));
    let error = open_counts("a.xlsx", ReadOptions::new(1, 1)).err();
    assert_eq!(
        error.unwrap().to_string(),
        "cannot tell the format of a.xlsx from `.xlsx`\nhint: recordings end in .txt, .csv, .npy, .npz or .mcap"
    );
    let error = open_counts(folder.path().with_extension("txt"), ReadOptions::new(0, 1)).err();
    assert!(error.is_some());
}
