//! Recordings that were damaged, that tell of losses, that carry a sensor and a tare; and times that are none.

use std::path::Path;
use std::time::{Duration, SystemTime};

use taxel::{Counts, Frame, Sensor};
use taxel_io::mcap::About;
use taxel_io::{Losses, McapWriter, Tare};

use crate::run::{Folder, SENSOR};

pub(crate) fn at(secs: f64) -> SystemTime {
    SystemTime::UNIX_EPOCH + Duration::from_secs_f64(1.7e9 + secs)
}

/// Counts of a loaded sensor of 4 x 6, drawn once.
pub(crate) fn counts(folder: &Folder) -> Vec<f64> {
    folder.good("simulate --sensor sensor.toml --pattern uniform --load-g 200 -o one.txt");
    folder.numbers("one.txt")
}

/// A recording of frames with these numbers, the same counts in each.
pub(crate) fn write(
    path: &Path,
    counts: &[f64],
    numbers: &[u64],
    mut each: impl FnMut(usize, &mut McapWriter),
) {
    let about = About {
        sensor: Sensor::from_toml(SENSOR).unwrap(),
        program: "taxel test".to_owned(),
        source: "test".to_owned(),
    };
    let mut writer = McapWriter::create(path, &about).unwrap();
    for (place, &number) in numbers.iter().enumerate() {
        each(place, &mut writer);
        let mut frame = Frame::<Counts>::new(4, 6, counts.to_vec()).unwrap();
        frame.sequence = number;
        let secs = 0.01 * place as f64;
        frame.time_secs = Some(secs);
        writer.write_counts(&frame, at(secs)).unwrap();
    }
    writer.finish().unwrap();
}

/// `run.mcap`: four frames of a loaded sensor, with a tare of half a newton a taxel (a quarter where nothing is compensated) from the
/// second on, which ends before the fourth.
pub(crate) fn tared(folder: &Folder) {
    let counts = counts(folder);
    let path = folder.path("run.mcap");
    write(&path, &counts, &[0, 1, 2, 3], |place, writer| {
        let tare = Tare {
            from_sequence: 1,
            at: at(0.01),
            unit: "N".to_owned(),
            loads: vec![0.5; 24],
            raw: vec![0.25; 24],
        };
        match place {
            1 => writer.write_tare(&tare).unwrap(),
            3 => writer.write_tare(&Tare::undone(3, at(0.03))).unwrap(),
            _ => {}
        }
    });
}

#[test]
fn the_sensor_comes_from_the_recording_where_none_is_given() {
    let folder = Folder::new();
    let counts = counts(&folder);
    write(&folder.path("run.mcap"), &counts, &[0, 1, 2], |_, _| {});
    std::fs::remove_file(folder.path("sensor.toml")).unwrap();
    for words in [
        "info run.mcap",
        "compensate run.mcap -o loads.csv",
        "plot run.mcap -o a.svg",
        "netlist run.mcap",
        "analyse run.mcap --taxel 1,1 --unit N",
    ] {
        let run = folder.good(words);
        assert!(
            run.err.contains("sensor `small` as run.mcap carries it"),
            "{run}"
        );
        assert!(!run.out.contains("assumed"), "{run}");
    }
    for words in [
        "compensate one.txt -o b.csv",
        "plot one.txt -o b.svg",
        "netlist",
    ] {
        let run = folder.taxel(words);
        assert_eq!(run.code, Some(2), "{run}");
        assert!(run.err.contains("sensor"), "{run}");
    }
}

#[test]
fn gaps_restarts_and_losses_are_told_and_cost_the_exit_code() {
    let folder = Folder::new();
    let counts = counts(&folder);
    let numbers = [5, 6, 7, 10, 11, 0, 1];
    write(
        &folder.path("run.mcap"),
        &counts,
        &numbers,
        |place, writer| {
            let mut losses = Losses::default();
            losses.corrupt = place as u64;
            writer.set_losses(losses);
        },
    );
    for words in [
        "info run.mcap",
        "convert run.mcap -o run.csv",
        "convert run.mcap -o run.parquet",
        "convert run.mcap -o again.mcap",
        "compensate run.mcap -o loads.csv",
        "analyse run.mcap --taxel 1,1",
    ] {
        let run = folder.taxel(words);
        assert_eq!(run.code, Some(3), "{words}: {run}");
        let said = format!("{}{}", run.out, run.err);
        for words in [
            "2 of the device's frame numbers missing after number 7",
            "the device's frame numbers began anew once",
            "6 packets or lines came broken",
        ] {
            assert!(said.contains(words), "{run}");
        }
    }
    // And again from what was converted; and for scripts.
    let json = folder.taxel("info again.mcap --json");
    assert_eq!(json.code, Some(3), "{json}");
    let json: serde_json::Value = serde_json::from_str(&json.out).unwrap();
    assert_eq!(json["integrity"]["gaps"]["missing"], 2);
    assert_eq!(json["integrity"]["gaps"]["restarts"], 1);
    assert_eq!(json["integrity"]["losses"]["corrupt"], 6);
}

#[test]
fn a_tare_is_taken_off_from_its_frame_on_unless_it_is_not_wanted() {
    let folder = Folder::new();
    tared(&folder);
    let told = folder.good("compensate run.mcap --unit N -o with.csv");
    assert!(
        told.err.contains("tare of the recording is taken off"),
        "{told}"
    );
    folder.good("compensate run.mcap --unit N --no-tare -o without.csv");
    folder.good("compensate run.mcap --unit N --method raw -o raw.csv");
    folder.good("compensate run.mcap --unit N --method raw --no-tare -o raw-without.csv");
    for (with, without, zero) in [
        ("with.csv", "without.csv", 0.5),
        ("raw.csv", "raw-without.csv", 0.25),
    ] {
        let (with, without) = (folder.numbers(with), folder.numbers(without));
        for (i, (with, without)) in with.iter().zip(&without).enumerate() {
            let expected = if (1..3).contains(&(i / 24)) {
                zero
            } else {
                0.0
            };
            assert!(
                (without - with - expected).abs() < 1e-12,
                "{i}: {without} {with}"
            );
        }
    }
    let mean = |words: &str| {
        let run = folder.good(&format!(
            "analyse run.mcap --taxel 1,1 --unit N --json {words}"
        ));
        let json: serde_json::Value = serde_json::from_str(&run.out).unwrap();
        json["taxels"][0]["mean"].as_f64().unwrap()
    };
    assert!((mean("--no-tare") - mean("") - 0.25).abs() < 1e-9);
    folder.good("convert run.mcap -o again.mcap");
    folder.good("compensate again.mcap --unit N -o again.csv");
    assert_eq!(folder.numbers("again.csv"), folder.numbers("with.csv"));
    // It is no finger's place in a picture of counts.
    let plot = folder.good("plot run.mcap --frame 2 -o a.svg");
    assert!(plot.err.contains("tare"), "{plot}");
}

#[test]
fn a_damaged_recording_is_told_and_its_rest_is_read() {
    let folder = Folder::new();
    let counts = counts(&folder);
    let numbers: Vec<u64> = (0..40).collect();
    write(
        &folder.path("good.mcap"),
        &counts,
        &numbers,
        |place, writer| {
            if place % 10 == 0 && place > 0 {
                // Ends the chunk.
                writer
                    .write_tare(&Tare::undone(place as u64, at(0.01 * place as f64)))
                    .unwrap();
            }
        },
    );
    let whole = std::fs::read(folder.path("good.mcap")).unwrap();
    let packing = b"\x04\0\0\0zstd";
    let mut chunks = whole
        .windows(8)
        .enumerate()
        .filter(|(_, word)| word == packing);
    let second = chunks.nth(1).unwrap().0;
    // In what it holds, in its operation code, in its length, in its checksum.
    for change in [second + 30, second - 37, second - 35, second - 3] {
        let mut bytes = whole.clone();
        bytes[change] ^= 0x11;
        std::fs::write(folder.path("bad.mcap"), &bytes).unwrap();
        let before = folder.names();
        let info = folder.taxel("info bad.mcap");
        assert_eq!(info.code, Some(3), "{change}: {info}");
        assert!(info.out.contains("missing:"), "{info}");
        let _ = std::fs::remove_file(folder.path("saved.mcap"));
        for words in [
            "convert bad.mcap -o bad.txt",
            "recover bad.mcap -o saved.mcap",
        ] {
            let run = folder.taxel(words);
            assert_eq!(run.code, Some(3), "{change}: {run}");
        }
        // What was lost stays lost, and is said of the mended file too.
        let run = folder.taxel("convert saved.mcap -o saved.txt");
        let is_whole = folder.numbers("saved.txt").len() / 24 == 40;
        assert_eq!(
            run.code,
            Some(if is_whole { 0 } else { 3 }),
            "{change}: {run}"
        );
        let (found, saved) = (folder.numbers("bad.txt"), folder.numbers("saved.txt"));
        assert!(found.len() / 24 >= 30, "{change}: {}", found.len());
        assert_eq!(found, saved);
        // Who has not the means to say what is missing says that it will not.
        let strict = folder.fails("selftest --empty bad.mcap --rubbed bad.mcap");
        assert!(strict.err.contains("is damaged"), "{strict}");
        for name in ["bad.txt", "saved.txt", "saved.mcap"] {
            std::fs::remove_file(folder.path(name)).unwrap();
        }
        assert_eq!(
            folder.names().len(),
            before.len() - usize::from(before.contains(&"saved.mcap".to_owned()))
        );
    }
}

#[test]
fn times_that_are_none_are_refused_and_leave_nothing() {
    let folder = Folder::new();
    let counts = counts(&folder);
    let line = |row: usize| {
        let row: Vec<String> = counts[6 * row..6 * row + 6]
            .iter()
            .map(f64::to_string)
            .collect();
        row.join(",")
    };
    let frame = (0..4).map(line).collect::<Vec<_>>().join("\n");
    let names = folder.names();
    for time in ["1e300", "1e19", "nan", "inf", "1e400", "0,01"] {
        folder.write(
            "run.csv",
            &format!("time_secs=0\n{frame}\ntime_secs={time}\n{frame}\n"),
        );
        let run = folder.fails("convert run.csv --sensor sensor.toml -o run.mcap");
        assert_eq!(run.code, Some(1), "{run}");
        assert!(run.err.contains("not a time at run.csv, line 6"), "{run}");
        assert!(run.err.contains(time), "{run}");
        let run = folder.taxel_bytes("replay run.csv --sensor sensor.toml --to - --speed 0");
        let err = String::from_utf8(run.stderr).unwrap();
        assert!(!run.status.success() && err.contains("not a time"), "{err}");
    }
    std::fs::remove_file(folder.path("run.csv")).unwrap();
    folder.write("run.txt", &format!("{frame}\n{frame}\n"));
    for words in [
        "convert run.txt --sensor sensor.toml -o run.mcap --frames-per-second 1e-300",
        "convert run.txt --sensor sensor.toml -o run.mcap --frames-per-second 0",
        "record sim:sensor.toml?hand -o run.mcap --secs nan",
        "replay run.txt --sensor sensor.toml --to - --speed nan",
    ] {
        let run = folder.taxel(words);
        assert_eq!(run.code, Some(2), "{words}: {run}");
    }
    std::fs::remove_file(folder.path("run.txt")).unwrap();
    assert_eq!(folder.names(), names);
}

#[test]
fn a_clock_that_jumps_is_not_waited_for() {
    let folder = Folder::new();
    let counts = counts(&folder);
    let row = |k: usize| {
        counts[6 * k..6 * k + 6]
            .iter()
            .map(f64::to_string)
            .collect::<Vec<_>>()
            .join(",")
    };
    let frame = (0..4).map(row).collect::<Vec<_>>().join("\n");
    let times = ["0", "0.01", "9e9", "9e9", "0.02"];
    let text: String = times
        .map(|time| format!("time_secs={time}\n{frame}\n"))
        .concat();
    folder.write("run.csv", &text);
    let run = folder.taxel_bytes("replay run.csv --sensor sensor.toml --to -");
    let err = String::from_utf8(run.stderr).unwrap();
    assert!(run.status.success(), "{err}");
    assert_eq!(err.matches("is not waited for").count(), 2, "{err}");
    assert!(err.contains("5 frames sent"), "{err}");
}

#[test]
fn converters_of_more_than_16_bits_are_refused_where_16_is_all_there_is_room_for() {
    let folder = Folder::new();
    folder.write("wide.toml", &SENSOR.replace("bits = 16", "bits = 24"));
    folder.good("simulate --sensor wide.toml --pattern hand -o run.npy");
    for words in [
        "simulate --sensor wide.toml --pattern hand -o run.mcap",
        "convert run.npy --sensor wide.toml -o run.mcap",
        "convert run.npy --sensor wide.toml -o run.parquet",
        "replay run.npy --sensor wide.toml --to -",
    ] {
        let run = folder.taxel(words);
        assert_eq!(run.code, Some(2), "{words}: {run}");
        assert!(run.err.contains("16") && run.err.contains("24"), "{run}");
    }
    assert!(!folder.exists("run.mcap") && !folder.exists("run.parquet"));
}

#[test]
fn a_sensor_file_without_end_is_refused() {
    let folder = Folder::new();
    folder.write("long.toml", &format!("a = \"{}\"", "x".repeat(5 << 20)));
    for file in ["long.toml", "/dev/zero"] {
        let run = folder.fails(&format!("netlist --sensor {file}"));
        assert!(
            run.err.contains("no sensor file has so many"),
            "{}",
            &run.err[..run.err.len().min(400)]
        );
        assert!(run.err.len() < 1000);
    }
}

/// Twenty frames a second, told by the lines between the frames.
#[test]
fn a_text_recording_is_played_by_its_own_times() {
    let folder = Folder::new();
    let mut text = String::new();
    for frame in 0..21 {
        text += &format!("time_secs={}\n", 3.0 + 0.05 * f64::from(frame));
        text += &"100,100,100,100,100,100,\n".repeat(4);
    }
    folder.write("timed.csv", &text);
    folder.good("record file:timed.csv?speed=max --sensor sensor.toml -o timed.mcap");
    let run = folder.good("info timed.mcap");
    assert!(run.out.contains("20.00 frames/s"), "{run}");
}

/// A pipe cannot be read a second time for its length, which nobody looks at here.
#[cfg(unix)]
#[test]
fn a_pipe_by_name_is_recorded_to_its_end() {
    let folder = Folder::new();
    folder.write("frames.txt", &"100,100,100,100,100,100,\n".repeat(4 * 30));
    let script = format!(
        "mkfifo pipe.txt && {{ cat frames.txt > pipe.txt & }} && \
         timeout 60 {} record 'file:pipe.txt?speed=max' --sensor sensor.toml -o pipe.mcap",
        env!("CARGO_BIN_EXE_taxel")
    );
    let output = std::process::Command::new("bash")
        .args(["-c", &script])
        .current_dir(folder.path(""))
        .output()
        .unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{told}");
    assert!(told.contains("pipe.mcap: 30 frames"), "{told}");
}

/// One name for one thing: the older ones are understood, and shown nowhere.
#[test]
fn a_frame_rate_has_one_name_and_its_older_ones_are_understood() {
    let folder = Folder::new();
    folder.good("simulate --sensor sensor.toml --pattern hand --frames 9 -o run.txt");
    for words in [
        "convert run.txt --sensor sensor.toml -o run.mcap",
        "measure run.txt --sensor sensor.toml",
        "budget sensor.toml",
        "design --rows 8 --columns 8",
    ] {
        let verb = words.split(' ').next().unwrap();
        let help = folder.good(&format!("{verb} --help")).out;
        assert!(help.contains("--frames-per-second"), "{help}");
        assert!(
            !help.contains("--fps") && !help.contains("--rate"),
            "{help}"
        );
        let said = |option: &str| {
            let _ = std::fs::remove_file(folder.path("run.mcap"));
            let made = folder.good(&format!("{words} {option}")).out;
            let exists = folder.exists("run.mcap");
            let info = exists.then(|| folder.good("info run.mcap --json").out);
            (made, info)
        };
        let [new, fps, rate] =
            ["frames-per-second", "fps", "rate"].map(|n| said(&format!("--{n} 20")));
        assert!(
            new == fps && new == rate,
            "{verb}: {new:?} {fps:?} {rate:?}"
        );
        assert_ne!(new, said("--frames-per-second 2000"), "{verb}");
    }
}
