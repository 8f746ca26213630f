//! Recordings as Parquet: what is written is read again, wherever a recording is.
#![cfg(feature = "parquet")]

use crate::recordings::{counts, write};
use crate::run::Folder;

/// A recording with gaps in its numbers, and the same as a table.
fn recorded() -> Folder {
    let folder = Folder::new();
    let counts = counts(&folder);
    write(&folder.path("run.mcap"), &counts, &[5, 6, 7, 10], |_, _| {});
    let run = folder.taxel("convert run.mcap -o run.parquet");
    assert_eq!(run.code, Some(3), "{run}");
    folder
}

#[test]
fn a_table_is_read_wherever_its_recording_is() {
    let folder = recorded();
    let run = folder.taxel("convert run.parquet -o back.mcap");
    assert_eq!(run.code, Some(3), "{run}");
    for name in ["run.mcap", "back.mcap", "run.parquet"] {
        let run = folder.taxel(&format!("convert {name} -o {name}.csv"));
        assert_eq!(run.code, Some(3), "{run}");
        let gap = "2 of the device's frame numbers missing after number 7";
        assert!(run.err.contains(gap), "{run}");
        let run = folder.taxel(&format!("compensate {name} -o {name}.loads.csv"));
        assert_eq!(run.code, Some(3), "{run}");
        assert!(run.err.contains("sensor `small` as "), "{run}");
    }
    for name in ["back.mcap", "run.parquet"] {
        for ending in ["csv", "loads.csv"] {
            let (found, expected) = (format!("{name}.{ending}"), format!("run.mcap.{ending}"));
            assert_eq!(folder.read(&found), folder.read(&expected), "{found}");
        }
    }
    let run = folder.taxel("info run.parquet --json");
    assert_eq!(run.code, Some(3), "{run}");
    let json: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!(json["frames"], 4);
    assert_eq!(json["integrity"]["gaps"]["missing"], 2);
    folder.good("plot run.parquet -o a.svg");
}

#[test]
fn loads_of_a_table_are_shown_as_they_stand() {
    let folder = recorded();
    let run = folder.taxel("compensate run.parquet -o loads.parquet");
    assert_eq!(run.code, Some(3), "{run}");
    let info = folder.taxel("info loads.parquet --values --json");
    let json: serde_json::Value = serde_json::from_str(&info.out).unwrap();
    assert_eq!(json["frames"], 4, "{info}");
    folder.good("plot loads.parquet --values -o a.svg");
    assert!(folder.read("a.svg").contains("N"));
    let none = folder.fails("info run.parquet --values");
    assert!(
        none.err.contains("no column `newtons` in run.parquet"),
        "{none}"
    );
    assert!(none.err.contains("taxel compensate"), "{none}");
    let volts = folder.fails("compensate run.parquet --input-unit volts -o v.csv");
    assert_eq!(volts.code, Some(2), "{volts}");
}

#[test]
fn a_table_that_is_cut_or_another_programs_is_told() {
    let folder = recorded();
    let whole = std::fs::read(folder.path("run.parquet")).unwrap();
    std::fs::write(folder.path("cut.parquet"), &whole[..whole.len() / 2]).unwrap();
    for words in [
        "info cut.parquet",
        "convert cut.parquet --sensor sensor.toml -o cut.txt",
        "plot cut.parquet --values --sensor sensor.toml -o cut.svg",
    ] {
        let run = folder.fails(words);
        assert_eq!(run.code, Some(1), "{run}");
        assert!(
            run.err.contains("cannot read cut.parquet as Parquet: "),
            "{run}"
        );
    }
    folder.write(
        "uneven.toml",
        &crate::run::SENSOR.replace("rows = 4", "rows = 3"),
    );
    let run = folder.fails("convert run.parquet --sensor uneven.toml -o a.txt");
    assert!(run.err.contains("4 rows x 6 columns"), "{run}");
    assert!(!folder.exists("cut.txt") && !folder.exists("cut.svg") && !folder.exists("a.txt"));
}
