//! `taxel batch`: an archive, killed, broken, in parts, and done again.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::recordings::tared;
use crate::run::Folder;

/// Recordings of three formats in two folders.
fn archive() -> Folder {
    let folder = Folder::new();
    for name in ["s1", "s2"] {
        fs::create_dir(folder.path(name)).unwrap();
    }
    for (seed, name) in [
        (1, "s1/grip.txt"),
        (2, "s1/other.npy"),
        (3, "s2/grip.txt"),
        (4, "s2/press.csv"),
        (5, "s2/long.txt"),
    ] {
        folder.good(&format!(
            "simulate --sensor sensor.toml --pattern hand --frames {} --seed {seed} --load-g 300 -o {name}",
            if name == "s2/long.txt" { 400 } else { 70 }
        ));
    }
    folder
}

const ALL: &str = "s1/grip.txt s1/other.npy s2/grip.txt s2/press.csv s2/long.txt";

/// Everything below a folder that is the same in every run: entries and the manifest tell how long it took.
fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(at) = folders.pop() {
        for file in fs::read_dir(at).unwrap() {
            let path = file.unwrap().path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let name = path.strip_prefix(folder).unwrap().to_str().unwrap();
            let is_timed = name.ends_with("entry.json") || name.contains("manifest");
            if !is_timed {
                found.insert(name.to_owned(), fs::read(&path).unwrap());
            }
        }
    }
    found
}

/// The column of a table.
fn column(folder: &Folder, table: &str, name: &str) -> Vec<String> {
    let text = folder.read(table);
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let place = reader
        .headers()
        .unwrap()
        .iter()
        .position(|cell| cell == name);
    let place = place.unwrap_or_else(|| panic!("{name} in {table}"));
    let cells = reader.records().map(|line| line.unwrap()[place].to_owned());
    cells.collect()
}

#[test]
fn an_archive_becomes_loads_figures_and_a_table() {
    let folder = archive();
    let run = folder.taxel(&format!(
        "batch {ALL} --sensor sensor.toml --out out --pictures"
    ));
    assert_eq!(run.code, Some(0), "{run}");
    assert!(
        run.err.contains("5 recordings: 5 done; 680 frames"),
        "{run}"
    );
    assert_eq!(
        column(&folder, "out/summary.csv", "recording").join(" "),
        ALL
    );
    assert_eq!(
        column(&folder, "out/summary.csv", "frames"),
        ["70", "70", "70", "70", "400"]
    );
    // The loads are those that `compensate` writes, and the figures those of the loads.
    folder.good("compensate s1/grip.txt --sensor sensor.toml -o alone.parquet");
    let bytes = |name: &str| fs::read(folder.path(name)).unwrap();
    assert!(bytes("out/s1/grip.txt.loads.parquet") == bytes("alone.parquet"));
    folder.good("compensate s1/grip.txt --sensor sensor.toml --unit N -o n.csv --figures f.csv");
    let forces: Vec<f64> = column(&folder, "out/s1/grip.txt.figures.csv", "total_force_N")
        .iter()
        .map(|cell| cell.parse().unwrap())
        .collect();
    for (force, loads) in forces.iter().zip(folder.numbers("n.csv").chunks(24)) {
        assert!((force - loads.iter().sum::<f64>()).abs() < 1e-9);
    }
    let peak = forces.iter().copied().fold(f64::MIN, f64::max);
    let told: f64 = column(&folder, "out/summary.csv", "peak_force_n")[0]
        .parse()
        .unwrap();
    assert_eq!(told, peak);
    // Half of the interval of the heaviest frame is that of `compensate --figures`.
    let half: f64 = column(&folder, "out/summary.csv", "peak_force_half_width_n")[0]
        .parse()
        .unwrap();
    let at = forces.iter().position(|force| *force == peak).unwrap();
    let wanted: f64 = column(&folder, "f.csv", "total_force_half_width_95_N")[at]
        .parse()
        .unwrap();
    assert!((half / wanted - 1.0).abs() < 1e-9, "{half} {wanted}");
    assert!(bytes("out/s2/long.txt.png").starts_with(b"\x89PNG"));
}

#[test]
fn every_frame_has_its_interval_where_that_is_asked_for() {
    let folder = archive();
    folder.good("batch s1/grip.txt --sensor sensor.toml --out out --intervals");
    folder.good("compensate s1/grip.txt --sensor sensor.toml --unit N -o n.csv --figures f.csv");
    assert_eq!(
        folder.read("out/s1/grip.txt.figures.csv"),
        folder.read("f.csv")
    );
    let halves = column(&folder, "f.csv", "total_force_half_width_95_N");
    let halves = halves.iter().map(|cell| cell.parse::<f64>().unwrap());
    let mean = halves.sum::<f64>() / 70.0;
    let told: f64 = column(&folder, "out/summary.csv", "mean_force_half_width_n")[0]
        .parse()
        .unwrap();
    assert!((told / mean - 1.0).abs() < 1e-12);
}

#[test]
fn a_frame_without_an_answer_is_no_largest_force() {
    let folder = archive();
    let wrong = folder
        .read("sensor.toml")
        .replace("_ohms = 10.0", "_ohms = 4000.0");
    folder.write("wrong.toml", &wrong);
    let run = folder.taxel("batch s1/grip.txt --sensor wrong.toml --out out");
    assert_eq!(run.code, Some(3), "{run}");
    let cell = |name: &str| column(&folder, "out/summary.csv", name)[0].clone();
    assert_eq!(cell("status"), "incomplete");
    // By the marks: what was measured is unresolved (8) in a frame without an answer.
    let words = "compensate s1/grip.txt --sensor wrong.toml --unit N -o n.csv";
    assert_eq!(folder.taxel(words).code, Some(3));
    let (loads, marks) = (folder.numbers("n.csv"), folder.numbers("n.marks.csv"));
    let frames = loads.chunks(24).zip(marks.chunks(24));
    let solved = frames.filter(|(_, marks)| !marks.contains(&8.0));
    let forces: Vec<f64> = solved.map(|(loads, _)| loads.iter().sum()).collect();
    assert_eq!(cell("unsolved_frames"), (70 - forces.len()).to_string());
    assert!(!forces.is_empty() && forces.len() < 70);
    let peak: f64 = cell("peak_force_n").parse().unwrap();
    let wanted = forces.iter().copied().fold(f64::MIN, f64::max);
    assert!((peak / wanted - 1.0).abs() < 1e-12, "{peak} {wanted}");
    assert!(!cell("peak_force_half_width_n").is_empty());
}

#[test]
fn what_is_done_is_not_done_again_and_what_has_changed_is() {
    let folder = archive();
    let words = format!("batch {ALL} --sensor sensor.toml --out out");
    folder.good(&words);
    let first = contents(&folder.path("out"));
    let run = folder.taxel(&words);
    assert!(run.err.contains("5 of them done before; 0 frames"), "{run}");
    assert!(contents(&folder.path("out")) == first);
    // A copy with another date and the same content; one with the same date and another content; a file that is gone.
    let text = folder.read("s1/grip.txt");
    folder.write("s1/grip.txt", &text);
    let short: Vec<&str> = text.lines().take(4 * 60).collect();
    folder.write("s2/grip.txt", &(short.join("\n") + "\n"));
    fs::remove_file(folder.path("out/s2/press.csv.figures.csv")).unwrap();
    let run = folder.taxel(&words);
    assert!(
        run.err.contains("3 of them done before; 130 frames"),
        "{run}"
    );
    // Other settings are other work, and what the settings before have left goes.
    assert!(folder.exists("out/s2/press.csv.loads.parquet"));
    let run = folder.taxel(&format!("{words} --loads none"));
    assert!(run.err.contains("5 done; 670 frames"), "{run}");
    assert!(!folder.exists("out/s2/press.csv.loads.parquet"));
    fs::write(
        folder.path("sensor.toml"),
        folder.read("sensor.toml").replace("0.857", "0.9"),
    )
    .unwrap();
    let run = folder.taxel(&format!("{words} --loads none"));
    assert!(run.err.contains("5 done; 670 frames"), "{run}");
}

#[test]
fn killed_anywhere_and_run_again_it_is_as_if_nothing_had_been() {
    let folder = archive();
    let words = format!("batch {ALL} --sensor sensor.toml --threads 1 --pictures --out");
    folder.good(&format!("{words} whole"));
    let whole = contents(&folder.path("whole"));
    for after in 0..5 {
        let out = format!("killed{after}");
        let mut child = Command::new(env!("CARGO_BIN_EXE_taxel"))
            .args(format!("{words} {out}").split_whitespace())
            .current_dir(folder.path(""))
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let done = || {
            let files = contents(&folder.path(&out));
            let pictures = files.keys().filter(|name| name.ends_with(".png"));
            pictures.count()
        };
        while (!folder.path(&out).exists() || done() < after) && child.try_wait().unwrap().is_none()
        {
            std::thread::yield_now();
        }
        child.kill().unwrap();
        child.wait().unwrap();
        folder.good(&format!("{words} {out}"));
        assert!(
            contents(&folder.path(&out)) == whole,
            "killed after {after}"
        );
    }
}

#[test]
fn parts_of_an_archive_are_the_archive() {
    let folder = archive();
    let words = format!("batch {ALL} --sensor sensor.toml --out");
    folder.good(&format!("{words} whole"));
    for part in 1..=3 {
        folder.good(&format!("{words} parts --shard {part}/3"));
        assert!(folder.exists(&format!("parts/summary-{part}-of-3.csv")));
    }
    let run = folder.taxel(&format!("{words} parts"));
    assert!(run.err.contains("5 of them done before; 0 frames"), "{run}");
    let mut parts = contents(&folder.path("parts"));
    parts.retain(|name, _| !name.contains("-of-"));
    assert!(parts == contents(&folder.path("whole")));
    // As many parts as anybody likes, also those without a recording.
    folder.good(&format!("{words} many --shard 9/9"));
    folder.good(&format!("{words} bare --no-summary"));
    assert!(folder.exists("bare/s1/grip.txt.entry.json") && !folder.exists("bare/summary.csv"));
    assert!(column(&folder, "parts/summary-3-of-3.csv", "recording") == ["s2/grip.txt"]);
}

#[test]
fn one_that_is_broken_does_not_stop_the_others() {
    let folder = archive();
    folder.write("s1/words.txt", "this is no recording\n");
    let text = folder.read("s2/grip.txt");
    folder.write("s1/cut.txt", &text[..text.len() - 8]);
    folder.write("s1/odd.mcap", "no recording either");
    let words = format!("batch s1/words.txt s1/cut.txt s1/odd.mcap s1/none.txt s1 {ALL} --out out");
    let run = folder.taxel(&format!("{words} --sensor sensor.toml"));
    assert_eq!(run.code, Some(3), "{run}");
    assert!(
        run.err
            .contains("10 recordings: 5 done, 1 incomplete, 4 broken"),
        "{run}"
    );
    assert!(
        run.err.contains("s1/none.txt: broken: cannot open"),
        "{run}"
    );
    let status = column(&folder, "out/summary.csv", "status");
    assert_eq!(
        status[..5],
        ["broken", "incomplete", "broken", "broken", "broken"]
    );
    assert_eq!(column(&folder, "out/summary.csv", "skipped_frames")[1], "1");
    let errors = column(&folder, "out/summary.csv", "error");
    assert!(
        errors[0].contains("no frame can be read; the first:"),
        "{errors:?}"
    );
    assert!(
        errors[1].is_empty() && errors[4].contains("is a directory"),
        "{errors:?}"
    );
    assert!(!folder.exists("out/s1/words.txt.figures.csv"));
    // What is broken is tried again, and mended by then.
    folder.write("s1/words.txt", &text);
    let run = folder.taxel(&format!("{words} --sensor sensor.toml"));
    assert!(
        run.err
            .contains("6 done, 1 incomplete, 3 broken, 6 of them done before; 70 frames"),
        "{run}"
    );
    // Without a sensor for all, recordings bring their own; text does not.
    folder.good("convert s1/grip.txt --sensor sensor.toml -o own.mcap");
    let run = folder.taxel("batch own.mcap s1/grip.txt --out own");
    assert_eq!(run.code, Some(3), "{run}");
    assert_eq!(
        column(&folder, "own/summary.csv", "status"),
        ["done", "broken"]
    );
}

#[test]
fn without_an_inverse_there_are_forces_and_no_intervals() {
    let folder = archive();
    folder.good("batch s1/grip.txt --sensor sensor.toml --out out --method raw");
    let peak: f64 = column(&folder, "out/summary.csv", "peak_force_n")[0]
        .parse()
        .unwrap();
    folder.good("compensate s1/grip.txt --sensor sensor.toml --method raw --unit N -o raw.csv");
    let loads = folder.numbers("raw.csv");
    let forces = loads.chunks(24).map(|frame| frame.iter().sum::<f64>());
    assert!((forces.fold(f64::MIN, f64::max) / peak - 1.0).abs() < 1e-12);
    assert_eq!(
        column(&folder, "out/summary.csv", "peak_force_half_width_n"),
        [""]
    );
    let run =
        folder.taxel("batch s1/grip.txt --sensor sensor.toml --out out --method raw --intervals");
    assert_eq!(run.code, Some(2), "{run}");
    assert!(
        run.err.contains("no intervals with the method raw"),
        "{run}"
    );
}

#[test]
fn a_list_and_paths_from_elsewhere() {
    let folder = archive();
    let list = ALL.replace(' ', "\n") + "\n\n";
    folder.write("list.txt", &list);
    folder.good("batch --list list.txt --sensor sensor.toml --out a");
    let run = folder.taxel_with("batch --list - --sensor sensor.toml --out b", &list);
    assert_eq!(run.code, Some(0), "{run}");
    assert!(contents(&folder.path("a")) == contents(&folder.path("b")));
    let whole = folder.path("s1/grip.txt").display().to_string();
    folder.good(&format!("batch {whole} --sensor sensor.toml --out c"));
    let inside = whole.trim_start_matches('/');
    assert!(folder.exists(&format!("c/{inside}.loads.parquet")));
}

#[test]
fn what_cannot_be_is_said_before_any_work() {
    let folder = archive();
    folder.write(
        "bare.toml",
        folder
            .read("sensor.toml")
            .split("[material]")
            .next()
            .unwrap(),
    );
    for (words, code, told) in [
        (
            "batch --sensor sensor.toml --out out",
            2,
            "no recording is named",
        ),
        (
            "batch s1/grip.txt ./s1/grip.txt --sensor sensor.toml --out out",
            2,
            "under one name",
        ),
        (
            "batch s1/grip.txt --sensor none.toml --out out",
            1,
            "none.toml",
        ),
        (
            "batch s1/grip.txt --sensor bare.toml --out out",
            1,
            "material",
        ),
        (
            "batch s1/grip.txt --sensor sensor.toml --out sensor.toml/x",
            1,
            "cannot make the folder",
        ),
        (
            "batch s1/grip.txt --sensor sensor.toml --out out --shard 4/3",
            2,
            "no part of a whole",
        ),
        (
            "batch s1/grip.txt --sensor sensor.toml --out out --method no.safetensors",
            1,
            "no.safetensors",
        ),
        (
            "batch --list none.txt --sensor sensor.toml --out out",
            1,
            "none.txt",
        ),
    ] {
        let run = folder.taxel(words);
        assert_eq!(run.code, Some(code), "{words}: {run}");
        assert!(run.err.contains(told), "{words}: {run}");
        assert!(!folder.exists("out/summary.csv"), "{words}");
    }
}

/// What a recording's tare takes off is told, in the line and in the table.
#[test]
fn a_tare_of_a_recording_is_taken_off_and_told() {
    let folder = Folder::new();
    tared(&folder);
    let with = folder.good("batch run.mcap --out with");
    assert!(with.err.contains("a tare of 12.00 N taken off"), "{with}");
    assert!(with.err.contains("(noise alone)"), "{with}");
    let without = folder.good("batch run.mcap --no-tare --out without");
    assert!(!without.err.contains("tare"), "{without}");
    let cell =
        |out: &str, name: &str| column(&folder, &format!("{out}/summary.csv"), name)[0].clone();
    assert_eq!(
        (
            cell("with", "tare_n").as_str(),
            cell("without", "tare_n").as_str()
        ),
        ("12", "")
    );
    let mean = |out: &str| cell(out, "mean_force_n").parse::<f64>().unwrap();
    // Two of four frames.
    assert!((mean("without") - mean("with") - 6.0).abs() < 1e-9);
}
