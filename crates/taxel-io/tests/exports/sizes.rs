//! Sizes that a header says and no sensor has: told with the place, before anything of such a size is held.

use super::*;

/// A small file of each format whose header says a size.
const WHOLE: [(&str, &str); 5] = [
    (
        "z.txt",
        "Frequency,Hz\t100\nCount\t1\nPlatform {\nColumns\t3\nLines\t2\nCell width,mm\t5\nCell height,mm\t5\nUnits\tN/cm^2\n\nFrame 1 {\nTime, ms\t0.00\n\n\tx1\tx2\tx3\ny1\t0\t1\t0\ny2\t1\t0\t0\n}\n}\n",
    ),
    (
        "x.csv",
        "Units:,mmHg\nFRAME,1\nSENSOR,S\nRows,2\nColumns,3\nSENSELS\n0,1,0\n1,0,0\n",
    ),
    (
        "e.lst",
        "\tMatrix: 3x2\n\tSensor area: 0.25 cm2\n\tPict-No.: 1\n\n\t1\t2\t3\tForce\n1\t0\t1\t0\t0.03\n2\t1\t0\t0\t0.03\nForce\t0\t0\t0\t0.05\n",
    ),
    (
        "a.apd",
        "[General]\nUnitPressure=N/cm2\n[Technical]\nSensCountX=2\nSensCountY=3\n[Data]\n0\t1\t0\n1\t0\t0\n",
    ),
    (
        "t.json",
        "{\"tactilus_rows\": 2, \"tactilus_columns\": 3, \"snapshots\": [{\"tactilus_readings\": [0, 1, 0, 1, 0, 0]}]}",
    ),
];

/// What a size is written as in them, both sides.
const SIDES: [[&str; 2]; 5] = [
    ["Lines\t2", "Columns\t3"],
    ["Rows,2", "Columns,3"],
    ["x2", "3x"],
    ["CountX=2", "CountY=3"],
    ["rows\": 2", "columns\": 3"],
];

#[test]
fn sizes_that_no_sensor_has() {
    let folder = Folder::new();
    for ((name, whole), sides) in WHOLE.into_iter().zip(SIDES) {
        near(&sums(&folder.write(name, whole)), &[2.0], 0.0);
        for size in ["100000000", "4294967296", "9223372036854775807"] {
            let larger = |side: &str| {
                let digit = side.trim_matches(|c: char| !c.is_ascii_digit());
                side.replace(digit, size)
            };
            let one = whole.replace(sides[0], &larger(sides[0]));
            let other = whole.replace(sides[1], &larger(sides[1]));
            let both = one.replace(sides[1], &larger(sides[1]));
            for text in [one, other, both] {
                let error = error_of(&folder.write(name, text));
                assert!(
                    error.contains(size) && error.contains("expected 1 to 262144 sensels"),
                    "{name}: {error}"
                );
                let is_of_a_line = error.contains("line ");
                assert!(is_of_a_line || name == "t.json", "{name}: {error}");
            }
        }
    }
}

/// Rows that no empty line ends are those of one frame.
#[test]
fn tekscan_rows_without_an_end() {
    let folder = Folder::new();
    let rows = "1,2,3,4,5,6,7,8\n".repeat((1 << 15) + 1);
    let text = format!("UNITS raw\nASCII_DATA @@\n\nFrame 1\n{rows}");
    let error = error_of(&folder.write("a.asf", text));
    assert!(
        error.contains("32769 rows x 8 columns") && error.contains("262144"),
        "{error}"
    );
}
