//! `taxel batch` and files: names of every kind, what was there before, what is out of reach.

use std::fs;
use std::process::Command;

use crate::run::Folder;

/// A folder with a recording that brings its sensor, and one that does not.
fn recorded() -> Folder {
    let folder = Folder::new();
    for (seed, name) in [(1, "a.txt"), (2, "b.txt")] {
        folder.good(&format!(
            "simulate --sensor sensor.toml --pattern hand --frames 30 --seed {seed} --load-g 300 -o {name}"
        ));
    }
    folder.good("convert a.txt --sensor sensor.toml -o a.mcap");
    folder
}

fn bytes(folder: &Folder, name: &str) -> Vec<u8> {
    fs::read(folder.path(name)).unwrap()
}

#[test]
fn recordings_of_loads_are_made_again_in_their_place() {
    let folder = recorded();
    let words = "batch a.mcap --out out --loads mcap";
    folder.good(words);
    let first = bytes(&folder, "out/a.mcap.loads.mcap");
    // As after a kill between the loads and their entry, with other settings, and after a disk was full.
    fs::remove_file(folder.path("out/a.mcap.entry.json")).unwrap();
    folder.write("out/a.mcap.loads.mcap.partial", "the start of it");
    folder.good(words);
    folder.good(&format!("{words} --pictures"));
    assert!(bytes(&folder, "out/a.mcap.loads.mcap") == first);
    assert!(!folder.exists("out/a.mcap.loads.mcap.partial"));
    // What other settings do not make goes; what is not ours stays.
    folder.write("out/a.mcap.note", "mine");
    folder.good("batch a.mcap --out out --loads none");
    assert!(!folder.exists("out/a.mcap.loads.mcap") && !folder.exists("out/a.mcap.png"));
    assert!(folder.exists("out/a.mcap.note"));
}

#[test]
fn nothing_that_is_read_is_replaced() {
    let folder = recorded();
    fs::copy(folder.path("a.mcap"), folder.path("a.mcap.loads.mcap")).unwrap();
    folder.write("a.mcap.png", "mine");
    let run = folder.taxel("batch a.mcap a.mcap.loads.mcap --out .");
    assert_eq!(run.code, Some(2), "{run}");
    let told = "the recording a.mcap.loads.mcap would be replaced: what is made of a.mcap is written there";
    assert!(run.err.contains(told), "{run}");
    assert_eq!(folder.read("a.mcap.png"), "mine");
    assert!(bytes(&folder, "a.mcap.loads.mcap") == bytes(&folder, "a.mcap"));
    fs::copy(folder.path("a.txt"), folder.path("summary.csv")).unwrap();
    let run = folder.taxel("batch summary.csv --sensor sensor.toml --out .");
    assert_eq!(run.code, Some(2), "{run}");
    assert!(run.err.contains("a table is written there"), "{run}");
    assert!(bytes(&folder, "summary.csv") == bytes(&folder, "a.txt"));
}

#[test]
fn a_recording_that_is_out_of_reach_costs_nothing_that_was_made_of_it() {
    let folder = recorded();
    let words = "batch a.txt --sensor sensor.toml --out out";
    folder.good(words);
    let loads = bytes(&folder, "out/a.txt.loads.parquet");
    fs::rename(folder.path("a.txt"), folder.path("elsewhere")).unwrap();
    let run = folder.taxel(words);
    assert_eq!(run.code, Some(3), "{run}");
    assert!(folder.read("out/summary.csv").contains("a.txt,broken"));
    assert!(bytes(&folder, "out/a.txt.loads.parquet") == loads);
    fs::rename(folder.path("elsewhere"), folder.path("a.txt")).unwrap();
    let run = folder.good(words);
    assert!(run.err.contains("1 done, 1 of them done before"), "{run}");
}

#[test]
fn a_name_that_cannot_be_written_does_not_stop_the_others() {
    let folder = recorded();
    let long = format!("{}.txt", "x".repeat(246));
    fs::copy(folder.path("a.txt"), folder.path(&long)).unwrap();
    fs::create_dir_all(folder.path("out")).unwrap();
    fs::create_dir(folder.path("sub")).unwrap();
    fs::copy(folder.path("a.txt"), folder.path("sub/a.txt")).unwrap();
    folder.write("out/sub", "no folder");
    let run = folder.taxel(&format!(
        "batch {long} sub/a.txt b.txt a.txt --sensor sensor.toml --out out"
    ));
    assert_eq!(run.code, Some(3), "{run}");
    assert!(run.err.contains("4 recordings: 2 done, 2 broken"), "{run}");
    assert_eq!(folder.read("out/summary.csv").matches(",done,").count(), 2);
}

#[cfg(unix)]
#[test]
fn what_can_be_read_once_only_is_no_recording_of_an_archive() {
    let folder = recorded();
    let made = Command::new("mkfifo").arg(folder.path("pipe.txt")).status();
    assert!(made.unwrap().success());
    let run = folder.taxel("batch pipe.txt /dev/null a.txt --sensor sensor.toml --out out");
    assert_eq!(run.code, Some(3), "{run}");
    assert!(run.err.contains("pipe.txt is no file"), "{run}");
    assert!(run.err.contains("3 recordings: 1 done, 2 broken"), "{run}");
}

#[cfg(target_os = "linux")]
#[test]
fn names_that_are_no_text_are_names() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;

    let folder = recorded();
    let names = [b"n\xff.txt", b"n\xfe.txt"].map(|name| OsStr::from_bytes(name));
    for name in names {
        fs::copy(folder.path("a.txt"), folder.path("").join(name)).unwrap();
    }
    let run = || {
        let done = Command::new(env!("CARGO_BIN_EXE_taxel"))
            .args(["batch", "--sensor", "sensor.toml", "--out", "out"])
            .args(names)
            .current_dir(folder.path(""))
            .output();
        String::from_utf8(done.unwrap().stderr).unwrap()
    };
    assert!(run().contains("2 recordings: 2 done; 60 frames"));
    assert!(run().contains("2 of them done before"));
    let summary = folder.read("out/summary.csv");
    assert!(
        summary.contains(r"n\xFF.txt") && summary.contains(r"n\xFE.txt"),
        "{summary}"
    );
}

#[test]
fn lists_as_editors_and_find_write_them() {
    let folder = recorded();
    folder.write("list.txt", "\u{feff}a.txt\r\n\r\nb.txt\r\n");
    for (list, input) in [("list.txt", ""), ("-", "a.txt\0b.txt\0")] {
        let words = format!("batch --list {list} --sensor sensor.toml --out out");
        let run = folder.taxel_with(&words, input);
        assert_eq!(run.code, Some(0), "{run}");
        assert!(run.err.contains("2 recordings: 2 done"), "{run}");
    }
}

#[test]
fn a_recording_of_another_shape_says_both() {
    let folder = recorded();
    folder.good("convert a.txt --sensor sensor.toml -o a.parquet");
    let other = folder.read("sensor.toml").replace("rows = 4", "rows = 5");
    folder.write("other.toml", &other);
    for name in ["a.mcap", "a.parquet"] {
        let run = folder.taxel(&format!("batch {name} --sensor other.toml --out out"));
        let told =
            format!("wrong shape of {name}: 4 rows x 6 columns, expected 5 rows x 6 columns");
        assert!(run.err.contains(&told), "{run}");
    }
    let swapped = folder
        .read("sensor.toml")
        .replace("rows = 4", "rows = 6")
        .replace("columns = 6", "columns = 4");
    folder.write("swapped.toml", &swapped);
    let run = folder.taxel("compensate a.mcap --sensor swapped.toml -o x.npy");
    assert!(run.err.contains("--transpose"), "{run}");
}

#[test]
fn an_entry_that_contradicts_itself_is_none() {
    let folder = recorded();
    let words = "batch a.txt --sensor sensor.toml --out out";
    folder.good(words);
    let summary = folder.read("out/summary.csv");
    let whole = folder.read("out/a.txt.entry.json");
    let (before, _) = whole.split_once("\"row\"").unwrap();
    for damaged in [
        "",
        "{}",
        &whole[..200],
        &format!("{}}}", before.trim_end().trim_end_matches(',')),
    ] {
        folder.write("out/a.txt.entry.json", damaged);
        let run = folder.good(words);
        assert!(run.err.contains("30 frames in"), "{damaged}: {run}");
        assert_eq!(folder.read("out/summary.csv"), summary);
    }
}

#[test]
fn of_a_pipe_it_is_said_that_faulty_lines_are_not_looked_for() {
    let folder = recorded();
    let run = folder.taxel_with(
        "compensate - --sensor sensor.toml -o x.npy",
        &folder.read("a.txt"),
    );
    assert_eq!(run.code, Some(0), "{run}");
    assert!(
        run.err.contains("faulty lines were not looked for"),
        "{run}"
    );
    let run = folder.good("compensate a.txt --sensor sensor.toml -o y.npy");
    assert!(!run.err.contains("not looked for"), "{run}");
}
