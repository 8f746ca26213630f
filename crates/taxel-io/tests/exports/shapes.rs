//! Frames that are torn, or of another shape than the header or the other frames say.

use super::*;

fn frames(rows: &[&[&str]]) -> String {
    let mut text = String::new();
    for (number, rows) in rows.iter().enumerate() {
        text += &format!("Frame {number} ({number}.00 ms)\n{}\n\n", rows.join("\n"));
    }
    text
}

/// A first frame that lost a row is the torn one, and not all behind it.
#[test]
fn rsscan_has_the_shape_that_most_frames_have() {
    let folder = Folder::new();
    let whole: &[&str] = &["1.5\t0\t0", "0\t0\t2"];
    let torn: &[&str] = &["1.5\t0\t0"];
    let longer: &[&str] = &["1.5\t0\t0", "0\t0\t2", "0\t9\t9"];
    for (broken, says) in [
        (torn, "1 rows"),
        (longer, "the end of the frame behind 2 rows"),
    ] {
        for place in 0..4 {
            let mut all = vec![whole; 4];
            all[place] = broken;
            let file = folder.write("r.txt", frames(&all));
            let sensor = sensor_of(&file);
            assert_eq!((sensor.rows(), sensor.columns()), (2, 3));
            let kept = read_with(&file, &sensor, true);
            assert_eq!((kept.frames.len(), kept.left_out.len()), (3, 1));
            assert_eq!(kept.left_out[0].0, place as u64);
            assert!(kept.left_out[0].1.contains(says), "{}", kept.left_out[0].1);
            assert!(kept.frames.iter().all(|read| sum(read) == 35.0));
        }
    }
}

#[test]
fn rsscan_is_held_against_its_rectangle() {
    let folder = Folder::new();
    let rows: &[&str] = &["1.0\t0.0\t0.0", "0.0\t0.0\t2.0"];
    let file = |width: u32, height: u32| {
        let header = format!(
            "Dynamic Roll off\tright\nHeight\t180\nRectangle width\t{width}\nRectangle height\t{height}\n\n"
        );
        folder.write("r.txt", header + &frames(&[rows, rows]))
    };
    near(&sums(&file(3, 2)), &[3.0, 3.0], 1e-9);
    for (width, height) in [(2, 3), (4, 2), (3, 3)] {
        let error = error_of(&file(width, height));
        let expected = format!("expected {height} rows x {width} columns");
        assert!(error.contains("frames of 2 rows x 3 columns"), "{error}");
        assert!(
            error.contains(&expected) && error.contains("line "),
            "{error}"
        );
    }
}

fn pedcad(size: [u32; 2], pictures: &str) -> String {
    let [x, y] = size;
    format!(
        "[General]\nUnitPressure=N/cm2\n[Technical]\nSensCountX={x}\nSensCountY={y}\nLDistX=5\nLDistY=5\n{pictures}"
    )
}

#[test]
fn pedcad_has_as_many_numbers_on_a_line_as_it_says() {
    let folder = Folder::new();
    let whole = "[Data]\n-1\t0.5\n2.0\t-1\n4.0\t1.0\n";
    near(
        &sums(&folder.write("a.apd", pedcad([3, 2], whole))),
        &[7.5],
        1e-9,
    );
    let torn = whole.replace("-1\t0.5\n2.0\t-1", "-1\n0.5\t2.0\t-1");
    for (size, text, found) in [
        ([3, 2], torn.as_str(), "1 numbers"),
        ([2, 3], whole, "2 numbers"),
    ] {
        let error = error_of(&folder.write("a.apd", pedcad(size, text)));
        assert!(
            error.contains(found) && error.contains("on a line"),
            "{error}"
        );
        assert!(error.contains("line 9"), "{error}");
    }
}

/// The picture of the largest pressures is no frame where there are some, told or not.
#[test]
fn pedcad_with_frames_that_its_header_does_not_count() {
    let folder = Folder::new();
    let pictures = "[Data]\n3\t4\n[Data5]\n1\t4\n[Data6]\n3\t2\n";
    near(
        &sums(&folder.write("a.apd", pedcad([1, 2], pictures))),
        &[5.0, 5.0],
        1e-9,
    );
}

fn xsensor(frames: &[(u32, &[(&str, &str)])]) -> String {
    let mut text = "Units:,mmHg\n\n".to_owned();
    for (number, sensors) in frames {
        text += &format!("FRAME,{number}\nTime, 08:21:17.{number}\n");
        for (name, rows) in *sensors {
            text += &format!("SENSOR,{name}\nRows,1\nColumns,2\nSENSELS\n{rows}\n");
        }
    }
    text
}

/// Frames begin with their line, whatever its number.
#[test]
fn xsensor_frames_of_one_number_are_two() {
    let folder = Folder::new();
    let frame: &[(&str, &str)] = &[("S", "1,2")];
    let file = folder.write("x.csv", xsensor(&[(4, frame), (4, frame)]));
    near(&sums_of(&file), &[3.0, 3.0], 0.0);
}

/// Sums of a file that may tell something of its frames.
fn sums_of(file: &Path) -> Vec<f64> {
    let outcome = read_with(file, &sensor_of(file), false);
    assert!(outcome.error.is_none());
    outcome.frames.iter().map(sum).collect()
}

#[test]
fn xsensor_sensors_that_the_first_frame_lacks() {
    let folder = Folder::new();
    let (one, both): (&[_], &[_]) = (&[("A-LF", "1,2")], &[("A-LF", "3,4"), ("B-RF", "5,6")]);
    let file = folder.write("x.csv", xsensor(&[(1, one), (2, both), (3, both)]));
    near(
        &sums_of(&file.with_file_name("x.csv#left")),
        &[3.0, 7.0, 7.0],
        0.0,
    );
    near(
        &sums_of(&file.with_file_name("x.csv#right")),
        &[11.0, 11.0],
        0.0,
    );
    // A file of one sensor has none by name.
    let file = folder.write("x.csv", xsensor(&[(1, one)]));
    let error = exports::sensor_of(&file.with_file_name("x.csv#right")).unwrap_err();
    let error = error.to_string();
    assert!(
        error.contains("it has one, which has no name") && error.contains("leave out the #"),
        "{error}"
    );
}
