//! What the formats have besides what the cuts show, in small files.

use taxel::Mark;
use taxel_io::exports;

use super::*;

fn tekscan(header: &str, frames: &str) -> String {
    format!("DATA_TYPE MOVIE\n{header}\nASCII_DATA @@\n\n{frames}@@\n")
}

const TWO_BY_TWO: &str =
    "ROWS 2\nCOLS 2\nROW_SPACING 0.5 inches\nCOL_SPACING 0.1 inches\nSECONDS_PER_FRAME 0.5";

#[test]
fn a_calibration_by_two_points_gives_every_raw_count_back() {
    let folder = Folder::new();
    let value = |raw: u32| 0.006_605_38 * f64::from(raw).powf(1.252_78);
    let counts = [0, 3, 100, 255];
    let cells: Vec<String> = counts
        .iter()
        .map(|&raw| format!("{:.4}", value(raw)))
        .collect();
    let header = format!(
        "{TWO_BY_TWO}\nUNITS MPa\nSENSEL_AREA 2 mm2\nSCALE_FACTOR 0.00660538\nEXPONENT 1.25278\nSATURATION_PRESSURE 6.8354 MPa "
    );
    let frames = format!(
        "Frame 1\n{},{}\n{},{}\n\n",
        cells[0], cells[1], cells[2], cells[3]
    );
    let file = folder.write("knee.asf", tekscan(&header, &frames));
    let raw = read(&file.with_file_name("knee.asf#raw"));
    assert_eq!(raw[0].frame.values(), [0.0, 3.0, 100.0, 255.0]);
    // Both ways it is a force of pressure times area, 2 N a MPa; the second knows no rounding.
    let expected: f64 = cells
        .iter()
        .map(|cell| 2.0 * cell.parse::<f64>().unwrap())
        .sum();
    near(&forces(&file), &[expected], 1e-9);
    let exact: f64 = counts.iter().map(|&raw| 2.0 * value(raw)).sum();
    // The largest value tells the scale, to five digits.
    near(
        &forces(&file.with_file_name("knee.asf#raw")),
        &[exact],
        2e-5 * exact,
    );
    assert_eq!(read(&file)[0].frame.marks()[3], Mark::Saturated);
}

/// Mixed line ends, inches, time stamps in milliseconds, a comment of several lines, keys of nobody, and names of persons.
#[test]
fn headers_and_line_ends_of_other_programs() {
    let folder = Folder::new();
    let header = format!(
        "{TWO_BY_TWO}\r\nFirst name: Anna\nCOMMENTS:\nthe ROWS are 3\nand more\r\nUNITS raw\nMY_KEY 7"
    );
    let frames = "Frame 1, timestamp 728\r\n1,2\r\n3,4\n\r\nFrame 2, timestamp 761\n5,6\n7,8\n\n";
    let file = folder.write("asf", tekscan(&header, frames));
    let frames = read(&file);
    near(
        &frames.iter().map(sum).collect::<Vec<_>>(),
        &[10.0, 26.0],
        0.0,
    );
    near(&[frames[1].frame.time_secs.unwrap()], &[0.761], 1e-12);
    let spec = spec_of(&file);
    near(&spec.array.pitch_mm, &[12.7, 2.54], 1e-9);
    let header = spec.exported.unwrap().header.unwrap();
    assert!(
        header.contains("MY_KEY 7") && header.contains("COMMENTS:\n(left out)"),
        "{header}"
    );
    assert!(
        !header.contains("Anna") && !header.contains("the ROWS are 3"),
        "{header}"
    );
}

#[test]
fn a_spreadsheet_has_saved_it_again() {
    let folder = Folder::new();
    let header = TWO_BY_TWO.replace('\n', ",,,\r\n");
    let text = format!(
        "\u{feff}DATA_TYPE MOVIE,,,\r\n{header},,,\r\nUNITS KPa,,,\r\nASCII_DATA @@,,,\r\n,,,\r\nFrame 1,,,\r\n1,B,,\r\n3,4,,\r\n,,,\r\nFrame 2,,,\r\n5,B,,\r\n7,8,,\r\n,,,\r\n@@,,,\r\n"
    );
    let file = folder.write("again.csv", text);
    let frames = read(&file);
    near(
        &frames.iter().map(sum).collect::<Vec<_>>(),
        &[8.0, 20.0],
        0.0,
    );
    near(&[frames[1].frame.time_secs.unwrap()], &[0.5], 1e-12);
    // No calibration in it: the values are as they are.
    assert_eq!(spec_of(&file).exported.unwrap().unit_per_count, Some(1.0));
    assert!(exports::sensor_of(&file.with_file_name("again.csv#raw")).is_err());
}

const X3: &str = "Units:\tN/cm2\nThreshold:\t0.07\n\nFrame:\t1\nDate:\t\"2016-08-09\"\nTime:\t\"23:59:59.900\"\nSensor:\t\"LX100:36.36.02 S0240\"\nRows:\t2\nColumns:\t3\nCOP Row:\t1.5\nSensel Width (cm):\t1.27\nSensel Height (cm):\t1.27\nSensels:\n0.1\t0.2\t0.3\n0\t1.25\t0\n\nFrame:\t2\nTime:\t\"00:00:00.100\"\nSensor:\t\"LX100:36.36.02 S0240\"\nRows:\t2\nColumns:\t3\nSensels:\n0\t0\t0\n0\t2\t0\n";

#[test]
fn xsensor_text_of_one_mat_over_midnight() {
    let folder = Folder::new();
    let colons = X3.replace('\t', " ");
    for (name, text) in [
        ("tabs.txt", X3.to_owned()),
        ("commas.csv", X3.replace('\t', ",")),
        (
            "decimal-commas.txt",
            X3.replace('.', ",").replace("LX100:36,36,02", "LX100"),
        ),
        ("colons.txt", colons),
        (
            "quoted.csv",
            X3.replace("0.1\t0.2\t0.3", "\"0,1\",\"0,2\",\"0,3\"")
                .replace("0\t1.25\t0", "0,\"1,25\",0")
                .replace('\t', ","),
        ),
    ] {
        let file = folder.write(name, text);
        near(&sums(&file), &[1.85, 2.0], 1e-9);
        let frames = read(&file);
        let secs = frames[1].frame.time_secs.unwrap() - frames[0].frame.time_secs.unwrap();
        near(&[secs], &[0.2], 1e-6);
        near(&spec_of(&file).array.pitch_mm, &[12.7, 12.7], 1e-9);
    }
}

#[test]
fn pictures_of_pedcad() {
    let folder = Folder::new();
    let head = "[General]\nDescription=pedcad Importfile\nSource=<<zebris>>\nUnitPressure=N/cm2\n[Customer]\nName=Muster\n[Technical]\nSensCountX=3\nSensCountY=2\nLDistX=8.5\nLDistY=8\n";
    let one = folder.write("walk.apd", format!("{head}[Data]\n-1\t2.5\n3\t4\n-1\t0\n"));
    near(&sums(&one), &[9.5], 1e-9);
    assert_eq!(
        read(&one)[0].frame.values(),
        [0.0, 25.0, 30.0, 40.0, 0.0, 0.0]
    );
    near(&spec_of(&one).array.pitch_mm, &[8.5, 8.0], 0.0);
    assert!(
        !spec_of(&one)
            .exported
            .unwrap()
            .header
            .unwrap()
            .contains("Muster")
    );
    let many = format!(
        "{head}MinIdx=0\nMaxIdx=1\nTimeDiff=10\n[Data]\n3\t3\n3\t4\n3\t3\n[Data0]\n1\t1\n1\t1\n1\t1\n[Data1]\n3\t3\n3\t4\n3\t3\n"
    );
    let many = folder.write("roll.apd", many);
    near(&sums(&many), &[6.0, 19.0], 1e-9);
    near(&[read(&many)[1].frame.time_secs.unwrap()], &[0.01], 1e-12);
}

#[test]
fn one_foot_of_footscan_saved_as_text() {
    let folder = Folder::new();
    let text = "Dynamic Roll off\tright\r\nPatient name: Muster, Anna\r\nRectangle width\t3\r\nRectangle height\t2\r\n\r\nFrame 0 (0,00 ms)\r\n0,0\t1,5\t2,0\r\n0,0\t0,0\t0,1\r\n\r\nFrame 1 (2,00 ms)\r\n1,0\t1,0\t1,0\r\n1,0\t1,0\t1,0\r\n\r\n";
    let file = folder.write("roll off.xls", text);
    near(&sums(&file), &[3.6, 6.0], 1e-9);
    near(&[read(&file)[1].frame.time_secs.unwrap()], &[0.002], 1e-12);
    assert!(
        !spec_of(&file)
            .exported
            .unwrap()
            .header
            .unwrap()
            .contains("Anna")
    );
}

#[test]
fn a_line_a_frame_and_json_and_matrices_in_cells() {
    let folder = Folder::new();
    let line = |first: u32| {
        let cells: Vec<String> = (0..2048)
            .map(|at| if at == 5 { first } else { at % 7 }.to_string())
            .collect();
        cells.join("\t")
    };
    let file = folder.write("bed.txt", format!("{}\n{}\n", line(100), line(900)));
    let sensor = sensor_of(&file);
    assert_eq!((sensor.rows(), sensor.columns()), (32, 64));
    let frames = read(&file);
    assert_eq!((largest(&frames[0]), largest(&frames[1])), (100.0, 900.0));

    let json = r#"{"volunteer_id": "7", "weight": 96, "snapshots": {"10": {"id": "b", "tactilus_readings": [6, 7.25, 8, 9, 10, 11]},
        "9": {"id": "a", "tactilus_readings": [0, 1, 2, 3, 4, 5], "sensomatt_readings": [1]}}, "tactilus_columns": 3, "tactilus_rows": 2}"#;
    let file = folder.write("left.json", json);
    near(&sums(&file), &[15.0, 51.25], 1e-9);
    assert_eq!(read(&file)[1].number, Some(10));

    let matrix = |first: u32| {
        let numbers: Vec<String> = (0..495)
            .map(|at| if at == 0 { first } else { at % 3 }.to_string())
            .collect();
        format!("\"[{}]\"", numbers.join(", "))
    };
    let text = format!(
        "Timestamp,Matrix_0,Matrix_1,note\n1747000000000,{},{},a\n1747000000500,{},{},b\n",
        matrix(10),
        matrix(20),
        matrix(30),
        matrix(40)
    );
    let file = folder.write("walk.csv", text);
    let right = read(&file.with_file_name("walk.csv#1"));
    assert_eq!((largest(&right[0]), largest(&right[1])), (20.0, 40.0));
    let secs = right[1].frame.time_secs.unwrap() - right[0].frame.time_secs.unwrap();
    near(&[secs], &[0.5], 1e-6);
}
