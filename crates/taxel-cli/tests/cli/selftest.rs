//! `taxel selftest`: what was broken in a recording is named, and what cannot be tested is refused.

use std::fs;

use crate::run::Folder;

/// An array of 16 × 16: reads 20 to 30 counts unloaded.
const ROWS: usize = 16;
const COLUMNS: usize = 16;

fn sensor(folder: &Folder) {
    let text = crate::run::SENSOR
        .replace("rows = 4", "rows = 16")
        .replace("columns = 6", "columns = 16")
        .replace("small", "rubbed");
    folder.write("sensor.toml", &text);
}

/// A number from 0 to 1 that depends on what is asked for alone.
fn noise(taxel: usize, frame: usize) -> f64 {
    let mut x = (taxel as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ ((frame as u64 + 1) << 32);
    for _ in 0..3 {
        x ^= x >> 31;
        x = x.wrapping_mul(0xd6e8_feb8_6659_fd93);
    }
    x as f64 / u64::MAX as f64
}

/// Frames of counts under a round load that goes over the array line by line, or under none; `broken` has the last word.
fn recording(frames: usize, rubbed: bool, broken: impl Fn(usize, usize, f64) -> f64) -> String {
    let mut text = String::new();
    for frame in 0..frames {
        let along = frame as f64 / frames as f64 * 6.0;
        let centre = [
            (along.floor() + 0.5) / 6.0 * ROWS as f64,
            (along.fract() * 1.2 - 0.1) * COLUMNS as f64,
        ];
        for row in 0..ROWS {
            for column in 0..COLUMNS {
                let away = (row as f64 + 0.5 - centre[0]).hypot(column as f64 + 0.5 - centre[1]);
                let load = if rubbed && away < 3.6 {
                    9000.0 * (1.0 - (away / 3.6).powi(2))
                } else {
                    0.0
                };
                let taxel = row * COLUMNS + column;
                let uneven = 1.0 + 0.2 * (noise(taxel, 7777) - 0.5);
                let value = 20.0 + 10.0 * noise(taxel, frame) + load * uneven;
                let value = broken(taxel, frame, value.round());
                text += &format!("{value},");
            }
            text.push('\n');
        }
    }
    text
}

fn sound(_: usize, _: usize, value: f64) -> f64 {
    value
}

/// Row 5 and taxel 9,12 open, taxel 12,3 stuck; column 13 out in every third frame.
fn broken(taxel: usize, frame: usize, value: f64) -> f64 {
    let dead = (3.0 * noise(taxel, frame)).round();
    match (taxel / COLUMNS, taxel % COLUMNS) {
        (5, _) => dead,
        (_, 13) if frame.is_multiple_of(3) => dead,
        (9, 10) => 20.0 + 10.0 * noise(taxel, frame).round(),
        (12, 3) => 777.0,
        _ => value,
    }
}

fn folder(broken: impl Fn(usize, usize, f64) -> f64 + Copy) -> Folder {
    let folder = Folder::new();
    sensor(&folder);
    folder.write("empty.txt", &recording(40, false, broken));
    folder.write("rubbed.txt", &recording(240, true, broken));
    folder
}

const BOTH: &str = "selftest --empty empty.txt --rubbed rubbed.txt --sensor sensor.toml";

#[test]
fn a_sound_sensor_is_healthy_and_the_exit_code_is_0() {
    insta::assert_snapshot!(folder(sound).taxel(BOTH), @r"
    exit code: 0
    ----- stdout -----
    16 rows x 16 columns, 40 frames empty, 240 rubbed
    baseline 25.0 counts, noise 3.52 counts; 100.0 % of the taxels tested
    healthy: nothing to solder
    settling: a reading keeps -0.01 ± 0.01 % of the one before
    mains hum: cannot be judged: the empty recording has no times; --frames-per-second says how many frames a second
    converter codes: all of the 5 that could be judged occur
    ----- stderr -----
    ");
}

#[test]
fn what_is_broken_is_listed_with_what_to_do_and_the_exit_code_is_3() {
    let folder = folder(broken);
    insta::assert_snapshot!(folder.taxel(BOTH), @r"
    exit code: 3
    ----- stdout -----
    16 rows x 16 columns, 40 frames empty, 240 rubbed
    baseline 25.0 counts, noise 3.38 counts; 100.0 % of the taxels tested
    4 found, on 33 of 256 taxels beside what concerns all; what to do, the most taxels first:
      row 5: open – check the joint of row line 5 at the connector, then its switch (16 of 16 taxels never responded; unloaded they read 1, the array 25)
      column 13: flickering – solder the joint of column line 13 again, or clean its contact at the connector (out in 80 of 240 rubbed frames)
      taxel at row 12, column 3: stuck – look at the crossing of row 12 and column 3; if it moves with the scan, suspect the converter (777 in all 280 frames)
      taxel at row 9, column 10: open – look for a gap in the material, or glue, at the crossing of row 9 and column 10 (reads 0 % of what is around it, in 13 frames in which all of that was loaded)
    settling: a reading keeps -0.01 ± 0.01 % of the one before
    mains hum: cannot be judged: the empty recording has no times; --frames-per-second says how many frames a second
    converter codes: all of the 5 that could be judged occur
    ----- stderr -----
    ");
    let run = folder.taxel(&format!("{BOTH} -o map.png"));
    assert_eq!(run.code, Some(3), "{run}");
    assert!(
        fs::read(folder.path("map.png"))
            .unwrap()
            .starts_with(b"\x89PNG")
    );
    folder.taxel(&format!("{BOTH} -o map.svg"));
    assert!(folder.read("map.svg").contains("open: row 5"));
    let run = folder.taxel(&format!("{BOTH} --json --frames-per-second 43"));
    assert_eq!(run.code, Some(3), "{run}");
    let json: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    let faults: Vec<&str> = json["findings"]
        .as_array()
        .unwrap()
        .iter()
        .map(|f| f["fault"].as_str().unwrap())
        .collect();
    assert_eq!(
        faults,
        ["line-open", "line-flickering", "taxel-stuck", "taxel-open"]
    );
    assert_eq!(json["findings"][0]["row"], 5);
    assert_eq!(json["findings"][0]["taxels"], 16);
    assert_eq!(json["healthy"], false);
}

#[test]
#[expect(clippy::too_many_lines, reason = "a table of cases")]
fn what_cannot_be_tested_is_refused() {
    let folder = folder(sound);
    insta::assert_snapshot!(
        folder.taxel("selftest --empty rubbed.txt --rubbed empty.txt --sensor sensor.toml"), @r"
    exit code: 2
    ----- stdout -----

    ----- stderr -----
    error: rubbed.txt: the empty recording has a load: 11.1 % of its readings move as under a load, 0.0 % of those of the rubbed one, and 0.0 % of the rubbed one lie far below it
    hint: are the two recordings swapped? take everything off the array while the empty one is made
    ");
    folder.write("none.txt", "");
    insta::assert_snapshot!(
        folder.taxel("selftest --empty none.txt --rubbed rubbed.txt --sensor sensor.toml"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: no frame in none.txt: 0 found, at least 1 expected
    hint: the file is empty or holds blank lines only; was the recording ever started?
    ");
    folder.write("short.txt", &recording(5, false, sound));
    insta::assert_snapshot!(
        folder.taxel("selftest --empty short.txt --rubbed rubbed.txt --sensor sensor.toml"), @r"
    exit code: 2
    ----- stdout -----

    ----- stderr -----
    error: short.txt: the empty recording has 5 frames, but the self-test takes 16
    hint: record for a few seconds; a hand needs longer to reach every taxel
    ");
    insta::assert_snapshot!(
        folder.taxel("selftest --empty empty.txt --rubbed empty.txt --sensor sensor.toml"), @r"
    exit code: 2
    ----- stdout -----

    ----- stderr -----
    error: empty.txt: the rubbed recording has no load: none of its 10240 readings rises 328 counts above the empty one
    hint: rub a hand over the whole array while it is recorded, and check that counts grow with the load
    ");
    insta::assert_snapshot!(
        folder.taxel("selftest --empty empty.txt --rubbed rubbed.txt --sensor econe"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: wrong number of values at empty.txt, line 1, column 1: 16 found, 128 expected
    hint: the recording is of another sensor; check rows and columns in the sensor file
    ");
    insta::assert_snapshot!(folder.taxel("selftest --empty empty.txt --rubbed rubbed.txt"), @r"
    exit code: 2
    ----- stdout -----

    ----- stderr -----
    error: empty.txt names no sensor
    hint: --sensor takes a sensor file or the name of a preset (econe, mat-16x16-cd4067, mat-32x32-adg732)
    ");
    insta::assert_snapshot!(folder.taxel("selftest --empty empty.txt --sensor sensor.toml"), @r"
    exit code: 2
    ----- stdout -----

    ----- stderr -----
    error: the following required arguments were not provided:
      --rubbed <FILE>

    Usage: taxel selftest --rubbed <FILE> --sensor <FILE|PRESET> <--empty <FILE>|--live <ADDRESS>>

    For more information, try '--help'.
    ");
    insta::assert_snapshot!(folder.taxel(&format!("{BOTH} -o map.jpg")), @r"
    exit code: 2
    ----- stdout -----

    ----- stderr -----
    error: no picture format has the extension `jpg`
    hint: known are png, svg, pdf
    ");
}

#[test]
fn live_asks_for_both_recordings_and_keeps_them() {
    let folder = folder(sound);
    let live = "selftest --live sim:sensor.toml?blobs&fps=100 --seconds 1.5";
    let run = folder.taxel_with(&format!("{live} --keep kept"), "\n\n");
    assert_eq!(run.code, Some(0), "{run}");
    assert!(
        run.err.contains("take everything off the mat, then Enter"),
        "{run}"
    );
    assert!(run.err.contains("rub a hand over the whole mat"), "{run}");
    assert!(run.out.contains("healthy: nothing to solder"), "{run}");
    // The recordings bring their sensor.
    let again = folder.good("selftest --empty kept/empty.mcap --rubbed kept/rubbed.mcap");
    assert_eq!(again.out, run.out);
    let quiet = folder.taxel(live);
    insta::assert_snapshot!(quiet, @r"
    exit code: 2
    ----- stdout -----

    ----- stderr -----
    take everything off the mat, then Enter
    error: no Enter came: standard input has ended
    hint: run it in a terminal, or with --yes, which does not wait
    ");
    insta::assert_snapshot!(folder.taxel("selftest --live file:rubbed.txt --sensor sensor.toml"), @r"
    exit code: 2
    ----- stdout -----

    ----- stderr -----
    error: rubbed.txt is a recording, not a live sensor
    hint: give two recordings with --empty and --rubbed
    ");
}
