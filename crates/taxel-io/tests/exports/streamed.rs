//! Files that are read piece by piece: JSON whose snapshots are longer or stand otherwise than usual, and tables with cells over
//! several lines.

use super::{Folder, cut, error_of, missing_of, read, read_with, sensor_of, sum};
use std::path::PathBuf;

fn json(folder: &Folder, snapshots: &str) -> PathBuf {
    let text = format!("{{\"tactilus_rows\":2,\"tactilus_columns\":2,\"snapshots\":{snapshots}}}");
    folder.write("t.json", text)
}

#[test]
fn snapshots_however_they_stand() {
    let folder = Folder::new();
    let list = |first: u32| format!("{{\"tactilus_readings\":[{first},2,0,0.5]}}");
    let between = [
        format!("[{}, {}]", list(1), list(3)),
        format!("{{\"4\":{}, \"5\":{}}}", list(1), list(3)),
        format!("{{\n \"5\": {},\n \"4\": {}\n}}", list(3), list(1)),
        // Words with brackets and quotes in them, before the readings and behind.
        r#"[{"note":"a ] } \" { [","tactilus_readings":[1,2,0,0.5]},{"tactilus_readings":[3,2e0,0,5e-1],"t":"}"}]"#.to_owned(),
        r#"[{"inner":{"tactilus_readings":[9]},"tactilus_readings":[1,2,0,0.5]},{"tactilus_readings":
            [3,
             2, 0, 0.50]}]"#.to_owned(),
    ];
    for snapshots in between {
        let frames = read(&json(&folder, &snapshots));
        let found: Vec<f64> = frames.iter().map(sum).collect();
        // A count is a half or a tenth, by the digits.
        let [first, second] = found[..] else {
            panic!("{snapshots}: {found:?}");
        };
        assert_eq!(first * 5.5, second * 3.5, "{snapshots}");
        if snapshots.contains("\"5\"") {
            let numbers: Vec<_> = frames.iter().map(|frame| frame.number).collect();
            assert_eq!(numbers, [Some(4), Some(5)], "{snapshots}");
        }
    }
    // What a mat is like may stand behind its frames.
    let text = "{\"name\":\"Anna\", \"snapshots\":[{\"tactilus_readings\":[1,2]}], \"tactilus_rows\" : 1 ,\"tactilus_columns\":2}";
    assert_eq!(read(&folder.write("b.json", text)).len(), 1);
}

/// Longer than what is read at once, so that values lie across two reads.
#[test]
fn a_snapshot_is_whole_wherever_a_read_ends() {
    let folder = Folder::new();
    let frame = |first: usize| {
        let cells: Vec<String> = (0..2000).map(|at| (first + at % 90).to_string()).collect();
        format!(
            "{{\"tactilus_readings\":[{}],\"at\":\"\\\\\\\"]\"}}",
            cells.join(", ")
        )
    };
    let frames: Vec<String> = (0..120).map(frame).collect();
    let text = format!(
        "{{\"tactilus_rows\":40,\"tactilus_columns\":50,\"snapshots\":[{}]}}",
        frames.join(" ,\n")
    );
    assert!(text.len() > 3 * 256 * 1024);
    let sums: Vec<f64> = read(&folder.write("t.json", text))
        .iter()
        .map(sum)
        .collect();
    let expected = |first: usize| (0..2000).map(|at| (first + at % 90) as f64).sum::<f64>();
    assert_eq!(sums, (0..120).map(expected).collect::<Vec<_>>());
}

#[test]
fn json_that_is_cut_gives_what_is_whole_and_tells_it() {
    let folder = Folder::new();
    let whole = "[{\"tactilus_readings\":[1,2,3,4]},{\"tactilus_readings\":[5,6,7,8]}]";
    let text = std::fs::read_to_string(json(&folder, whole)).unwrap();
    let second = text.rfind('{').unwrap();
    for end in second - 1..text.len() {
        let file = folder.write("c.json", &text[..end]);
        let outcome = read_with(&file, &sensor_of(&file), true);
        let is_told = outcome
            .missing
            .iter()
            .any(|words| words.contains("end of the file"));
        assert!(is_told, "{end}: {:?}", outcome.missing);
        let has_both = outcome.frames.len() == 2;
        assert!(has_both || end <= text.len() - 2, "{end}");
        if !has_both {
            assert_eq!(sum(&outcome.frames[0]), 10.0, "{end}");
        }
    }
    assert!(error_of(&folder.write("d.json", &text[..30])).contains("tactilus_"));
}

#[test]
fn json_that_is_broken_is_an_error_with_its_place() {
    let folder = Folder::new();
    let good = "{\"tactilus_readings\":[1,2,3,4]}";
    for (snapshots, told) in [
        (format!("[{good} {good}]"), "`,` or the end at byte"),
        (format!("{{{good}}}"), "a key between quotes at byte"),
        (format!("[{good}]}} x"), "end of the file at byte"),
        (
            format!("[{good}],\"tactilus_rows\":2"),
            "`tactilus_rows` is there twice",
        ),
        ("7".to_owned(), "list or object of snapshots at byte"),
        (
            format!("[{good},{{\"tactilus_readings\":[1,2,3]}}]"),
            "snapshot 1 has 3 readings",
        ),
        (
            format!("[{good},{{\"tactilus_readings\":[1,2,3,-4]}}]"),
            "snapshot 1 reads -4",
        ),
        (
            format!("[{good},{{\"tactilus_readings\":[1,2,3,4,]}}]"),
            "snapshot 1 is broken",
        ),
        (
            format!("[{good},{{\"tactilus_readings\":[1,2,3,4],x}}]"),
            "snapshot 1 is broken",
        ),
        (
            format!("[{good},{{\"other\":[1,2,3,4]}}]"),
            "missing field `tactilus_readings`",
        ),
        (
            format!("[{good},{{\"tactilus_readings\":[1,2,3,4],\"tactilus_readings\":[1,2,3,4]}}]"),
            "duplicate field",
        ),
    ] {
        let error = error_of(&json(&folder, &snapshots));
        assert!(error.contains(told), "{snapshots}: {error}");
    }
    let file = json(&folder, &format!("[{good},7,{good}]"));
    let outcome = read_with(&file, &sensor_of(&file), true);
    assert_eq!((outcome.frames.len(), outcome.left_out.len()), (2, 1));
}

fn picture(first: u32, between: &str) -> String {
    let mut cells = vec!["0".to_owned(); 33 * 15];
    cells[0] = first.to_string();
    cells.join(between)
}

#[test]
fn pictures_over_several_lines_and_quotes_that_are_lost() {
    let folder = Folder::new();
    let line = |at: u32, first: u32| {
        format!(
            "{at},\"[[{}]]\",\"[[{}]]\"\n",
            picture(first, ", "),
            picture(first + 1, "\r\n  ")
        )
    };
    let whole = format!(
        "frame,Matrix_0,Matrix_1\n{}\n{}{}",
        line(0, 5),
        line(1, 7),
        line(2, 9)
    );
    for (foot, expected) in [("#0", [5.0, 7.0, 9.0]), ("#1", [6.0, 8.0, 10.0])] {
        folder.write("i.csv", &whole);
        let file = folder.0.path().join(format!("i.csv{foot}"));
        let sums: Vec<f64> = read(&file).iter().map(sum).collect();
        assert_eq!(sums, expected, "{foot}");
        // Without its quote a line is lost for both feet, and no other one.
        folder.write("i.csv", whole.replacen("]]\"\n\n1,", "]]\n\n1,", 1));
        let outcome = read_with(&file, &sensor_of(&file), true);
        let sums: Vec<f64> = outcome.frames.iter().map(sum).collect();
        assert_eq!(sums, expected[1..], "{foot}");
        assert!(outcome.left_out[0].1.contains("without its end"), "{foot}");
    }
}

/// A last number without its last digits is no smaller number.
#[test]
fn an_insole_that_ends_within_a_number_is_told() {
    let folder = Folder::new();
    let table = |names: &str, line: &str| format!("{names}\n{line}\n{line}\n");
    let cells = picture(5, ",").replacen(",0", ",0,1234", 1);
    let cells = cells.strip_suffix(",0").unwrap();
    let text = table("Matrix_0", &format!("\"[{cells}]\""));
    let file = folder.write("i.csv", &text[..text.len() - 1]);
    assert_eq!(missing_of(&file), "");
    let file = folder.write("i.csv", &text[..text.len() - 3]);
    let outcome = read_with(&file, &sensor_of(&file), true);
    assert_eq!((outcome.frames.len(), outcome.left_out.len()), (1, 1));
    let text = table("Matrix_0,time_ms", &format!("\"[{cells}]\",1020"));
    let file = folder.write("i.csv", &text[..text.len() - 2]);
    assert!(missing_of(&file).contains("end of the file"));
}

/// Lines of nothing but plain numbers are read by another way than those with anything else between them: to the same end.
#[test]
fn a_picture_of_plain_numbers_is_that_of_careful_ones() {
    let folder = Folder::new();
    let emed = super::latin(&cut("emed.lst"));
    let bytes = |text: &str| text.chars().map(|c| c as u8).collect::<Vec<u8>>();
    let plain: Vec<f64> = read(&cut("emed.lst")).iter().map(sum).collect();
    // An exponent is nothing plain.
    let careful = emed.replacen("\t0.00\t", "\t0.00e0\t", 40);
    assert_ne!(careful, emed);
    let file = folder.write("emed.lst", bytes(&careful));
    let found: Vec<f64> = read(&file).iter().map(sum).collect();
    assert_eq!(found, plain);
}
