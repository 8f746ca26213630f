//! Taxels of a recording over time.

use crate::run::{Folder, SENSOR};

/// Twelve frames of the small sensor: every taxel reads 100 but row 1, column 2, which climbs by 10 a frame and is stuck at
/// the converter's end in frame 5.
fn recording(folder: &Folder) {
    let mut text = String::new();
    for frame in 0..12 {
        for row in 0..4 {
            for column in 0..6 {
                let count = match (row, column) {
                    (1, 2) if frame == 5 => 65_535,
                    (1, 2) => 1000 + 10 * frame,
                    _ => 100,
                };
                text += &format!("{count},");
            }
            text.push('\n');
        }
    }
    folder.write("run.txt", &text);
    let masked = crate::run::SENSOR.to_owned() + "\n[screen]\nhigh_counts = 65000\n";
    folder.write("masked.toml", &masked);
}

fn json(folder: &Folder, words: &str) -> serde_json::Value {
    let run = folder.good(&format!("analyse run.txt {words} --json"));
    serde_json::from_str(&run.out).unwrap()
}

#[test]
fn a_taxel_has_its_figures_before_and_after_screening() {
    let folder = Folder::new();
    recording(&folder);
    let found = json(
        &folder,
        "--sensor masked.toml --taxel C1 --frames-per-second 0.1",
    );
    let taxel = &found["taxels"][0];
    assert_eq!(taxel["name"], "C1 (row 1, column 2)");
    assert_eq!(taxel["readings"], 12);
    let number = |key: &str| taxel[key].as_f64().unwrap();
    assert!((number("filtered_percent") - 100.0 / 12.0).abs() < 1e-9);
    assert_eq!((number("least"), number("most")), (1000.0, 65_535.0));
    // 0 to 11 without 5: their sum is 61.
    let mean = 1000.0 + 10.0 * 61.0 / 11.0;
    assert!((number("mean") - mean).abs() < 1e-9);
    let before = (11.0 * mean + 65_535.0) / 12.0;
    assert!((number("mean_before") - before).abs() < 1e-9);
    // 10 counts in ten seconds.
    let drift = 100.0 * 3600.0 / mean;
    assert!(
        (number("drift_percent") / drift - 1.0).abs() < 1e-9,
        "{taxel}"
    );
    // A second says nothing of an hour.
    let short = json(
        &folder,
        "--sensor masked.toml --taxel C1 --frames-per-second 10",
    );
    assert!(short["taxels"][0]["drift_percent"].is_null(), "{short}");
    let text =
        folder.good("analyse run.txt --sensor masked.toml --taxel C1 --frames-per-second 10");
    assert!(
        text.out.contains("drift, %/h") && text.out.trim_end().ends_with('–'),
        "{text}"
    );
}

#[test]
fn rows_columns_and_regions_are_all_their_taxels() {
    let folder = Folder::new();
    recording(&folder);
    for (words, taxels) in [
        ("--row 1", 6),
        ("--column 2", 4),
        ("--region 1..2,0..3", 8),
        ("--taxel 1,2 --taxel 0,0", 2),
    ] {
        let found = json(&folder, &format!("--rows 4 {words}"));
        assert_eq!(found["taxels"].as_array().unwrap().len(), taxels, "{words}");
    }
}

#[test]
fn values_go_to_a_table_and_a_plot() {
    let folder = Folder::new();
    recording(&folder);
    let run =
        folder.good("analyse run.txt --sensor masked.toml --taxel 1,2 --export a.csv -o a.svg");
    insta::assert_snapshot!(run.out, @"
    run.txt: 12 frames, 1 taxel, counts; 8.33 % filtered
      taxel            filtered, %  least   most  mean before  SD before  mean     SD  drift, %/100 frames
      row 1, column 2        8.333   1000  65535         6429      18614  1055  37.78                94.75
    ");
    let table = folder.read("a.csv");
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(
        lines[0],
        "frame,\"row 1, column 2\",\"row 1, column 2, screened\""
    );
    assert_eq!((lines[5], lines[6]), ("4,1040,1040", "5,65535,"));
    assert!(folder.read("a.svg").contains("8.333 % filtered"));
    for name in ["b.xlsx", "b.parquet"] {
        folder.good(&format!(
            "analyse run.txt --sensor masked.toml --row 1 --export {name}"
        ));
        assert!(folder.exists(name));
    }
    // The same taxel in grams: more counts, more load.
    let grams =
        folder.good("analyse run.txt --sensor masked.toml --taxel 1,2 --unit g --export g.csv");
    assert!(grams.out.contains(", g;"), "{grams}");
    let loads = folder.read("g.csv");
    let load = |line: usize| -> f64 {
        let last = loads
            .lines()
            .nth(line)
            .unwrap()
            .split(',')
            .next_back()
            .unwrap();
        last.parse().unwrap()
    };
    assert!(load(12) > load(1) && load(1) > 0.0);
}

#[test]
fn what_cannot_be_looked_at_is_said() {
    let folder = Folder::new();
    recording(&folder);
    for (words, says) in [
        (
            "analyse run.txt --rows 4 --taxel 4,0",
            "row 4, column 0 is outside of the array of 4 rows x 6 columns",
        ),
        ("analyse run.txt --rows 4 --taxel seven", "a label like C7"),
        (
            "analyse run.txt --rows 4 --region 2..1,0..0",
            "ends included",
        ),
        ("analyse run.txt --row 1", "does not say how many rows"),
        ("analyse run.txt --rows 4 --row 1 --export a.doc", ".doc"),
        ("analyse run.txt --rows 4 --row 1 --unit g", "--sensor"),
        (
            "analyse run.txt --rows 4 --row 1 --frames-per-second 0",
            "must be a number above 0",
        ),
        ("analyse run.txt", "required"),
        ("analyse none.txt --rows 4 --row 1", "none.txt"),
    ] {
        let run = folder.taxel(words);
        assert!(matches!(run.code, Some(1 | 2)), "{words}: {run}");
        assert!(run.err.contains(says), "{words}: {run}");
    }
}

#[test]
fn a_line_that_the_sensor_file_declares_dead_is_filtered_whatever_it_reads() {
    let folder = Folder::new();
    recording(&folder);
    let sensor = crate::run::SENSOR.to_owned() + "\n[screen]\ndead_rows = [2]\n";
    folder.write("declared.toml", &sensor);
    let found = json(&folder, "--sensor declared.toml --row 2");
    for taxel in found["taxels"].as_array().unwrap() {
        assert_eq!(taxel["filtered_percent"], 100.0, "{taxel}");
    }
    let run = folder.good("info run.txt --sensor declared.toml");
    assert!(
        run.out.contains("row 2 is dead, as the sensor file says"),
        "{run}"
    );
}

#[test]
fn a_taxel_by_its_label_is_the_same_for_every_verb() {
    let folder = Folder::new();
    folder.good("simulate --sensor sensor.toml --pattern hand --frames 3 -o run.txt");
    let text = folder.read("sensor.toml");
    assert!(!text.contains("labels"));
    let named = text.replacen("[array]", "[array]\nlabels = \"FEDCBA\"", 1);
    folder.write("named.toml", &named);
    for (sensor, numbers) in [("sensor", "3,2"), ("named", "3,3")] {
        for (taxel, output) in [("C3", "label"), (numbers, "numbers")] {
            folder.good(&format!(
                "plot run.txt --sensor {sensor}.toml --taxel {taxel} -o {sensor}-{output}.svg"
            ));
            folder.good(&format!(
                "netlist run.txt --sensor {sensor}.toml --taxel {taxel} -o {sensor}-{output}.cir"
            ));
        }
        for end in ["svg", "cir"] {
            let file = |of: &str| folder.read(&format!("{sensor}-{of}.{end}"));
            assert_eq!(file("label"), file("numbers"), "{sensor}");
        }
    }
    for verb in ["plot", "netlist"] {
        let run = folder.fails(&format!(
            "{verb} run.txt --sensor named.toml --taxel Z3 -o z.svg"
        ));
        let says = "no taxel is called Z3: the sensor file's labels are FEDCBA";
        assert!(run.err.contains(says), "{run}");
        let run = folder.fails(&format!("{verb} run.txt --sensor named.toml --taxel 3"));
        assert!(run.err.contains("a label like C7"), "{run}");
    }
}

/// A region that has a name is its taxels, wherever the name stands.
#[test]
fn a_named_region_is_its_taxels() {
    let folder = Folder::new();
    folder.good("simulate --sensor sensor.toml --pattern hand --frames 9 -o run.txt");
    let region = "[[region]]\nname = \"Ball\"\nboxes = [[1, 2, 3, 4]]\n";
    folder.write("r.toml", region);
    folder.write("own.toml", &format!("{SENSOR}\n{region}"));
    let of = |words: &str| folder.good(&format!("analyse run.txt {words}")).out;
    let block = of("--sensor sensor.toml --region 1..2,3..4 --unit N");
    assert_eq!(of("--sensor own.toml --region Ball --unit N"), block);
    assert_eq!(
        of("--sensor sensor.toml --region Ball --regions r.toml --unit N"),
        block
    );
    assert!(
        block.contains("row 1, column 3") || block.contains("4 taxels"),
        "{block}"
    );
    let unknown =
        folder.fails("analyse run.txt --sensor sensor.toml --region Heel --regions r.toml");
    assert!(
        unknown.err.contains("--region Heel: there are Ball"),
        "{unknown}"
    );
    let none = folder.fails("analyse run.txt --sensor sensor.toml --region Heel");
    assert!(
        none.err.contains("the sensor file names no regions"),
        "{none}"
    );
    folder.fails("analyse run.txt --sensor sensor.toml --region 1..2");
}
