//! Files of other programs through the whole command: taken as they are, said to be so, and written for others.

use std::path::Path;
use std::process::Command;

use crate::live::{Running, told, view, wait};
use crate::run::Folder;

/// A folder with cuts of real exports in it.
fn with(names: &[&str]) -> Folder {
    let folder = Folder::new();
    for name in names {
        let from = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../../testdata/exports")
            .join(name);
        std::fs::copy(from, folder.path(name)).unwrap();
    }
    folder
}

const AS_EXPORTED: &str = "has exported them (KPa): no cross-talk is removed, nothing is calibrated here, and nothing tells how far to trust them; what read below 17.8 KPa was written as 0";

#[test]
fn every_command_says_whose_loads_they_are() {
    let folder = with(&["fscan.asf"]);
    let info = folder.good("info fscan.asf");
    assert!(info.err.contains(AS_EXPORTED), "{info}");
    assert!(
        info.out
            .contains("heaviest frame 1: 35819.00 KPa, 924.36 N"),
        "{info}"
    );
    assert!(
        !info.out.contains("FraserP10") && !info.out.contains("no line fault"),
        "{info}"
    );
    let names = folder.good("info fscan.asf --with-names --json");
    assert!(
        names.out.contains("FraserP10") && names.out.contains("\"has_raw_counts\": true"),
        "{names}"
    );

    let measured = folder.good("measure fscan.asf --trials whole -o f.csv");
    assert!(measured.err.contains(AS_EXPORTED), "{measured}");
    assert!(
        measured.out.contains("intervals of 95 %: nothing"),
        "{measured}"
    );
    assert!(!measured.err.contains("noise only"), "{measured}");
    let totals = folder.column("f.csv", "total_n");
    assert!((totals[1] - 924.3594416).abs() < 1e-9, "{totals:?}");
    assert!(
        folder
            .column("f.csv", "total_error_n")
            .iter()
            .all(|error| error.is_nan())
    );

    let compensated =
        folder.good("compensate fscan.asf --unit N -o loads.npy --figures figures.csv");
    assert!(
        compensated.err.contains("method as exported"),
        "{compensated}"
    );
    let figures = folder.read("figures.csv");
    let cells = |line: &str| line.split(',').count();
    assert!(
        figures
            .lines()
            .all(|line| cells(line) == cells(figures.lines().next().unwrap())),
        "{figures}"
    );
    assert!(!figures.contains("half_width"), "{figures}");
}

#[test]
fn pictures_and_archives_say_it_as_well() {
    let folder = with(&["fscan.asf", "emed.lst"]);
    folder.good("plot fscan.asf --frame 1 --unit kPa -o foot.svg");
    let picture = folder.read("foot.svg");
    assert!(picture.contains("fscan.asf, fscan, as Tekscan Pressure"));
    assert!(!picture.contains("cross-talk removed"));

    let batch = folder.good("batch fscan.asf emed.lst --out results --loads parquet");
    assert!(
        batch.err.contains("at most 924.4 N") || batch.out.contains("at most 924.4 N"),
        "{batch}"
    );
    let summary = folder.read("results/summary.csv");
    assert!(
        summary
            .lines()
            .skip(1)
            .all(|line| line.contains(",nothing,")),
        "{summary}"
    );
}

/// Names of persons and of files are in what is written where they were asked for, and nowhere else.
#[test]
fn names_are_written_where_they_are_asked_for() {
    let folder = with(&["fscan.asf"]);
    let has_name = |file: &str| {
        let written = std::fs::read(folder.path(file)).unwrap();
        let written = String::from_utf8_lossy(&written);
        assert!(written.contains("SENSEL_AREA 25.8064 mm2"), "{file}");
        written.contains("FraserP10")
    };
    for command in [
        "convert fscan.asf -o FILE.mcap",
        "convert fscan.asf -o FILE.parquet",
        "compensate fscan.asf -o FILE.mcap",
        "compensate fscan.asf -o FILE.parquet",
        "record fscan.asf -o FILE.mcap",
    ] {
        let ending = &command[command.rfind('.').unwrap()..];
        let file = |name: &str| format!("{name}{ending}");
        for (name, option, has) in [("without", "", false), ("with", " --with-names", true)] {
            let _ = std::fs::remove_file(folder.path(&file(name)));
            folder.good(&format!("{}{option}", command.replace("FILE", name)));
            assert_eq!(has_name(&file(name)), has, "{command}{option}");
        }
    }
    for (option, has) in [("", false), (" --with-names", true)] {
        folder.good(&format!("info fscan.asf --write-sensor own.toml{option}"));
        assert_eq!(has_name("own.toml"), has);
        folder.good(&format!("compensate fscan.asf -o own.xdf{option}"));
        assert_eq!(has_name("own.xdf"), has);
        folder.good(&format!("batch fscan.asf --out results{option}"));
        assert_eq!(has_name("results/fscan.asf.loads.parquet"), has);
    }
    // What shows numbers alone has none either way.
    let measured = folder.good("measure fscan.asf --trials whole --json -o f.json");
    let drawn = folder.good("plot fscan.asf -o foot.svg");
    for text in [
        measured.out,
        drawn.err,
        folder.read("f.json"),
        folder.read("foot.svg"),
    ] {
        assert!(!text.contains("FraserP10"), "{text}");
    }
}

/// The same of what is recorded while a file is played.
#[test]
fn names_are_recorded_while_a_file_is_played_where_they_are_asked_for() {
    let folder = with(&["fscan.asf"]);
    for (name, option, has) in [("without", "", false), ("with", "--with-names", true)] {
        let live = format!(
            "live fscan.asf --record {name}.mcap --listen 127.0.0.1:0 --token abcdefgh {option}"
        );
        let mut running = Running::start(&folder, &live);
        let mut viewer = view(&running.url());
        wait("end", || {
            told(&mut viewer, "state")["device"]["state"] == "ended"
        });
        let pid = running.child.id().to_string();
        let sent = Command::new("kill").args(["-INT", &pid]).status().unwrap();
        assert!(sent.success() && running.child.wait().unwrap().success());
        let written = std::fs::read(folder.path(&format!("{name}.mcap"))).unwrap();
        let written = String::from_utf8_lossy(&written);
        assert!(written.contains("SENSEL_AREA 25.8064 mm2"), "{name}");
        assert_eq!(written.contains("FraserP10"), has, "{name}");
    }
}

#[test]
fn what_needs_a_circuit_is_refused() {
    let folder = with(&["fscan.asf", "pedar.asc", "iscan.csv", "xsensor.csv"]);
    folder.write(
        "presses.csv",
        "recording,frame,row,column,load_g\nfscan.asf,0,20,10,500\n",
    );
    for (command, says) in [
        (
            "compensate fscan.asf -o n.npy --standard-error se.npy",
            "nothing tells how far to trust these loads",
        ),
        (
            "compensate fscan.asf -o n.npy --method exact",
            "there is no circuit to undo",
        ),
        (
            "calibrate --presses presses.csv -o own.toml",
            "no readings of a circuit",
        ),
        ("identify fscan.asf", "no readings of a circuit"),
        ("measure pedar.asc#left", "they are no forces"),
        ("measure pedar.asc", "holds 2 sensors: left, right"),
        ("measure iscan.csv", "may tell circuit and load law"),
        ("measure xsensor.csv#heel", "no sensor `heel`"),
        ("info iscan.csv#raw", "no sensor `raw`"),
    ] {
        let run = folder.taxel(command);
        assert!(matches!(run.code, Some(1 | 2)), "{command}: {run}");
        assert!(run.err.contains(says), "{command}: {run}");
        assert!(run.err.contains("hint: "), "{command}: {run}");
    }
    // Nothing was written, and nothing that is read is replaced under its other name.
    assert!(!folder.exists("n.npy") && !folder.exists("own.toml"));
    let run = folder.taxel("convert xsensor.csv#left -o xsensor.csv");
    assert!(run.err.contains("would replace what is read"), "{run}");
    assert!(folder.read("xsensor.csv").contains("SENSELS"));
}

#[test]
fn the_force_that_a_file_tells_stands_beside_the_total() {
    let folder = with(&["emed.lst", "xsensor.csv"]);
    let run = folder.good("measure emed.lst --trials whole -o f.csv");
    assert!(run.out.contains("beside the force that the recording tells (3 frames, at most 818.63 N): -0.005 N on average, at most 0.005 N off"), "{run}");
    assert_eq!(
        folder.column("f.csv", "reference_n"),
        [817.38, 818.63, 816.63]
    );
    let run = folder.good("measure xsensor.csv#left --trials whole");
    assert!(run.out.contains("0.9979 times it"), "{run}");
}

#[test]
fn raw_counts_of_an_old_recording_and_its_sensor_file() {
    let folder = with(&["fscan.asf"]);
    folder.good("convert fscan.asf#raw -o raw.npy");
    folder.good("info fscan.asf#raw --write-sensor raw.toml");
    let written = folder.read("raw.toml");
    assert!(
        written.contains("bits = 8") && written.contains("[exported]"),
        "{written}"
    );
    // Without [exported] it is a sensor of one's own, and the calibrated export gives it its counts.
    let own = &written[..written.find("[exported]").unwrap()];
    folder.write("own.toml", own);
    folder.good("convert fscan.asf --sensor own.toml -o own.npy");
    assert_eq!(
        std::fs::read(folder.path("own.npy")).unwrap(),
        std::fs::read(folder.path("raw.npy")).unwrap()
    );
}

/// Loads of a calibrated sensor go out as others read them, and come back by their readers.
#[test]
fn loads_are_written_for_others() {
    let folder = Folder::new();
    folder.good("simulate --sensor sensor.toml --pattern blobs --frames 4 --seed 5 -o run.mcap");
    folder.good("compensate run.mcap --unit N -o loads.csv");
    let loads = folder.numbers("loads.csv");
    for (arguments, back) in [
        ("-o back.asf", "back.asf"),
        ("--as rsscan -o back-n.txt", "back-n.txt"),
    ] {
        let run = folder.taxel(&format!("compensate run.mcap {arguments}"));
        assert_eq!(run.code, Some(0), "{run}");
        folder.good(&format!("compensate {back} --unit N -o again.csv"));
        let again = folder.numbers("again.csv");
        assert_eq!(again.len(), loads.len());
        for (again, load) in again.iter().zip(&loads) {
            assert!(
                (again - load.max(0.0)).abs() <= 1e-4,
                "{arguments}: {again} for {load}"
            );
        }
        let below = loads.iter().filter(|load| **load < 0.0).count();
        let told = format!("{below} loads below nothing were written as 0");
        assert_eq!(run.err.contains(&told), below > 0, "{run}");
    }
    let run = folder.taxel("compensate run.mcap --as novel -o out.asc");
    assert!(
        run.code == Some(2) && run.err.contains("tekscan, rsscan, xdf, ros2 or table"),
        "{run}"
    );
    let run = folder.taxel("compensate run.mcap -o out.asc");
    assert!(
        run.code == Some(2) && run.err.contains("--as tells a format of other programs"),
        "{run}"
    );
}

#[test]
fn a_stream_is_a_line_of_json_a_frame() {
    let folder = Folder::new();
    let run = folder.good("stream sim:sensor.toml?blobs&fps=200 --frames 5");
    let lines: Vec<serde_json::Value> = run
        .out
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(lines.len(), 5, "{run}");
    for line in &lines {
        let rows = line["loads_n"].as_array().unwrap();
        assert_eq!((rows.len(), rows[0].as_array().unwrap().len()), (4, 6));
        let sum: f64 = rows
            .iter()
            .flat_map(|row| row.as_array().unwrap())
            .map(|load| load.as_f64().unwrap())
            .sum();
        // Each load is rounded to 0.1 mN.
        assert!(
            (sum - line["total_n"].as_f64().unwrap()).abs() < 24.0 * 1e-4,
            "{line}"
        );
        assert_eq!(line["is_answer"], true);
    }
    let sums = folder.good("stream sim:sensor.toml?blobs&fps=200 --frames 2 --sums");
    assert!(
        sums.out.lines().count() == 2 && !sums.out.contains("loads_n"),
        "{sums}"
    );
    let run = folder.taxel("stream sim:sensor.toml --to carrier-pigeon");
    assert!(
        run.code == Some(2)
            && run
                .err
                .contains("neither udp:HOST:PORT, tcp:HOST:PORT, listen:HOST:PORT nor -"),
        "{run}"
    );
}

/// Numbers that are no loads are shown in the unit of their file, and sums of loads that there are none of are null.
#[test]
fn numbers_that_are_no_loads_keep_their_unit() {
    let folder = with(&["iscan.csv", "pedar.asc"]);
    for (file, label) in [
        ("iscan.csv", "reading (raw)"),
        ("pedar.asc#left", "pressure (kPa)"),
    ] {
        folder.good(&format!("plot {file} --frame 1 -o a.svg"));
        let picture = folder.read("a.svg");
        assert!(
            picture.contains(label) && !picture.contains("conductance"),
            "{file}"
        );
    }
    let run = folder.good("stream file:iscan.csv?speed=max --frames 1");
    let line: serde_json::Value = serde_json::from_str(run.out.lines().next().unwrap()).unwrap();
    assert!(
        line["total_n"].is_null() && line["peak_kpa"].is_null(),
        "{run}"
    );
    let measured = folder.fails("measure iscan.csv -o m.csv");
    assert!(measured.err.contains("they are no forces"), "{measured}");
}

/// `evaluate` holds the totals against the force that the recordings tell, by itself.
#[test]
fn evaluate_compares_with_the_recordings_own_force() {
    let folder = with(&["pliance.asc"]);
    folder.good("info pliance.asc --write-sensor mat.toml");
    folder.write(
        "plan.toml",
        "format = 1\nsensor = \"mat.toml\"\n[[experiment]]\nkind = \"repeatability\"\nname = \"x\"\ntrials = \"t.csv\"\n",
    );
    let frames = ["0", "1", "2"].map(|frame| format!("pliance.asc,10,10,{frame}\n"));
    folder.write(
        "t.csv",
        &format!("recording,row,column,frame\n{}", frames.concat()),
    );
    let run = folder.good("evaluate plan.toml");
    let line = run
        .out
        .lines()
        .find(|line| line.contains("230.59"))
        .expect("a row");
    let cells: Vec<&str> = line.split_whitespace().collect();
    assert_eq!(
        cells,
        ["pliance.asc", "3", "230.59", "+0.009", "0.009", "1.0000"]
    );
    assert!(
        run.out
            .contains("as novel pliance has exported it: no cross-talk is removed"),
        "{run}"
    );
    assert!(!run.out.contains("read-out"), "{run}");
}
