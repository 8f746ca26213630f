//! What a recording ends with: its file, its exit code, and what is said of it.

use std::io::Write;
use std::net::UdpSocket;
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::live::{Running, wait};
use crate::run::{Folder, Run, SENSOR};

const SIM: &str = "sim:sensor.toml?uniform";

/// `taxel` with these bytes on standard input, which then ends.
fn fed(folder: &Folder, words: &str, bytes: &[u8]) -> Run {
    let mut child = folder.spawn(words);
    let _ = child.stdin.take().unwrap().write_all(bytes);
    Run::from(child.wait_with_output().unwrap())
}

/// So many frames of the small sensor as text, the first count of each its number.
fn text(frames: u32) -> String {
    let rest = "30,31,32,33,34,35,\n".repeat(3);
    (0..frames)
        .map(|n| format!("{},31,32,33,34,35,\n{rest}", 100 + n))
        .collect()
}

#[test]
fn without_a_frame_recording_fails_and_leaves_no_file() {
    let folder = Folder::new();
    for (words, says) in [
        (
            "record serial:/dev/no-such-port --sensor sensor.toml --secs 0.2",
            "no-such-port",
        ),
        (
            "record stdin: --sensor sensor.toml",
            "stdin: has ended without a frame",
        ),
        (
            "record udp:127.0.0.1:0 --sensor sensor.toml --secs 0.2",
            "udp:127.0.0.1:0",
        ),
    ] {
        // Twice: the first run is not in the way of the second.
        for _ in 0..2 {
            let run = folder.taxel(&format!("{words} -o none.mcap"));
            assert_eq!(run.code, Some(1), "{run}");
            assert!(
                run.err.contains("error: no frame came from") && run.err.contains(says),
                "{run}"
            );
            assert!(!folder.exists("none.mcap"), "{run}");
        }
    }
    // Bytes without a frame: what they are is said.
    let run = fed(
        &folder,
        "record stdin: --sensor sensor.toml -o none.mcap",
        "1,2,3\n".repeat(400).as_bytes(),
    );
    assert_eq!(run.code, Some(1), "{run}");
    assert!(
        run.err.contains("a line of 3 numbers, but a row has 6"),
        "{run}"
    );
    folder.write("taken.mcap", "somebody's");
    let taken = folder.fails(&format!("record {SIM} -o taken.mcap --frames 1"));
    let says = "taken.mcap already exists\nhint: recordings are never overwritten";
    assert!(taken.err.contains(says), "{taken}");
    assert_eq!(folder.read("taken.mcap"), "somebody's");
    for secs in ["nan", "-1", "0", "inf"] {
        let run = folder.taxel(&format!("record {SIM} -o none.mcap --secs={secs}"));
        assert_eq!(run.code, Some(2), "{run}");
    }
}

#[test]
fn so_many_frames_and_no_more() {
    let folder = Folder::new();
    folder.write("long.txt", &text(300));
    for (source, frames) in [
        ("file:long.txt?speed=max", 3),
        ("sim:sensor.toml?uniform&fps=1000", 10),
    ] {
        let name = format!("{frames}.mcap");
        let run = folder.good(&format!(
            "record {source} --sensor sensor.toml -o {name} --frames {frames} --loads --figures"
        ));
        assert!(
            run.err.contains(&format!("{name}: {frames} frames\n")),
            "{run}"
        );
        folder.good(&format!("convert {name} -o {frames}.txt"));
        assert_eq!(folder.numbers(&format!("{frames}.txt")).len(), 24 * frames);
    }
}

/// What a simulated source is does not change with what its frames are taken to be of: a truth that reads itself has no error.
#[test]
fn a_virtual_sensor_stays_what_its_address_names() {
    let folder = Folder::new();
    folder.write("other.toml", &SENSOR.replace("8.29e-6", "4.2e-6"));
    let counts = |name: &str, words: &str| {
        folder.good(&format!(
            "record {SIM}&fps=max {words} -o {name}.mcap --frames 3"
        ));
        folder.good(&format!("convert {name}.mcap -o {name}.csv"));
        let text = folder.read(&format!("{name}.csv"));
        let counts = text.lines().filter(|line| !line.starts_with("time"));
        counts.map(str::to_owned).collect::<Vec<_>>()
    };
    let own = counts("own", "");
    assert_eq!(counts("taken", "--sensor other.toml"), own);
    folder.write("wide.toml", &SENSOR.replace("columns = 6", "columns = 7"));
    let run = folder.fails(&format!("record {SIM} --sensor wide.toml -o none.mcap"));
    for words in ["of 4 × 6 taxels", "of 4 × 7", "hint: "] {
        assert!(run.err.contains(words), "{words}: {run}");
    }
}

/// The same counts of 12 bits and of 16 are other loads.
#[test]
fn a_sensor_file_that_the_recording_contradicts_is_doubted() {
    let folder = Folder::new();
    folder.good(&format!("record {SIM}&fps=max -o own.mcap --frames 3"));
    let compensated = |name: &str| {
        let run = folder.taxel(&format!("compensate own.mcap --sensor {name} -o loads.csv"));
        run.err
    };
    let doubt =
        "own.mcap carries another sensor than other.toml: converter.bits is 16 there and 12 here";
    assert!(!compensated("sensor.toml").contains("another sensor"));
    folder.write("other.toml", &SENSOR.replace("bits = 16", "bits = 12"));
    let said = compensated("other.toml");
    assert!(said.contains(doubt), "{said}");
    // What a calibration fits is no contradiction.
    folder.write(
        "fitted.toml",
        &SENSOR.replace("8.29e-6", "4.2e-6").replace("10.0", "12.0"),
    );
    assert!(!compensated("fitted.toml").contains("another sensor"));
}

/// As many loads and figures as frames, however fast they come.
#[test]
fn every_frame_has_its_loads() {
    let folder = Folder::new();
    let run = folder
        .good("record sim:sensor.toml?fingers&fps=max -o f.mcap --loads --figures --frames 700");
    assert!(run.err.contains("f.mcap: 700 frames\n"), "{run}");
    let bytes = std::fs::read(folder.path("f.mcap")).unwrap();
    let counts = messages(&bytes);
    assert_eq!(
        counts.iter().filter(|count| **count == 700).count(),
        3,
        "{counts:?}"
    );
}

/// Messages of a recording, by channel, from its statistics.
fn messages(bytes: &[u8]) -> Vec<u64> {
    let u64_at = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
    let mut at = u64_at(bytes.len() - 28) as usize;
    loop {
        let length = u64_at(at + 1) as usize;
        if bytes[at] == 0x0b {
            let counts = &bytes[at + 9 + 46..at + 9 + length];
            return counts
                .chunks(10)
                .map(|c| u64::from_le_bytes(c[2..].try_into().unwrap()))
                .collect();
        }
        at += 9 + length;
    }
}

#[test]
fn a_stray_byte_before_a_stream_costs_nothing() {
    let folder = Folder::new();
    let bytes = [&b"\0"[..], text(40).as_bytes()].concat();
    let run = fed(
        &folder,
        "record stdin: --sensor sensor.toml -o n.mcap",
        &bytes,
    );
    assert_eq!(run.code, Some(0), "{run}");
    assert!(run.err.contains("n.mcap: 40 frames\n"), "{run}");
}

/// A pipe waits for the disk: many times what the queue holds, as fast as it can be read.
#[test]
fn a_pipe_faster_than_the_disk_loses_nothing() {
    let folder = Folder::new();
    let run = fed(
        &folder,
        "record stdin: --sensor sensor.toml -o fast.mcap",
        text(20_000).as_bytes(),
    );
    assert_eq!(run.code, Some(0), "{run}");
    assert!(run.err.contains("fast.mcap: 20000 frames\n"), "{run}");
}

/// What went wrong stands in the recording, and in the exit code.
#[test]
fn what_is_lost_is_told_by_the_file_too() {
    let folder = Folder::new();
    let mut lines: Vec<String> = text(50).lines().map(str::to_owned).collect();
    lines[41] = "~x".to_owned() + &lines[41][2..];
    lines[81].replace_range(3..5, "??");
    let run = fed(
        &folder,
        "record stdin: --sensor sensor.toml -o hurt.mcap",
        (lines.join("\n") + "\n").as_bytes(),
    );
    assert_eq!(run.code, Some(3), "{run}");
    assert!(run.err.contains("hurt.mcap: 48 frames; 2 corrupt"), "{run}");
    let info = folder.taxel("info hurt.mcap");
    assert!(info.out.contains("2 corrupt"), "{info}");
    // A device that began to count anew.
    folder.good(&format!("record {SIM} -o run.mcap --frames 60"));
    let replayed = Command::new(env!("CARGO_BIN_EXE_taxel"))
        .args(["replay", "run.mcap", "--to", "-", "--speed", "0"])
        .current_dir(folder.path(""))
        .output()
        .unwrap()
        .stdout;
    let twice = [replayed.clone(), replayed].concat();
    let run = fed(
        &folder,
        "record stdin: --sensor sensor.toml -o twice.mcap",
        &twice,
    );
    assert_eq!(run.code, Some(3), "{run}");
    assert!(
        run.err.contains("120 frames; 1 restart of the device"),
        "{run}"
    );
}

#[test]
fn wider_counts_than_sixteen_bits_are_refused_live() {
    let folder = Folder::new();
    let wide = folder.read("sensor.toml").replace("bits = 16", "bits = 24");
    folder.write("wide.toml", &wide);
    let run = folder.fails("record sim:wide.toml?hand -o x.mcap --frames 1");
    assert!(
        run.err
            .contains("wide.toml: a converter of 24 bits, but live counts have at most 16"),
        "{run}"
    );
    assert!(!folder.exists("x.mcap"));
}

/// A device that sends nothing but zeros: a pulled cable. Frames go on to come.
#[test]
fn frames_of_a_pulled_cable_flow() {
    let folder = Folder::new();
    let zeros = "0,0,0,0,0,0,\n".repeat(4 * 200);
    let run = fed(
        &folder,
        "record stdin: --sensor sensor.toml -o z.mcap --loads --figures",
        zeros.as_bytes(),
    );
    assert_eq!(run.code, Some(0), "{run}");
    assert!(run.err.contains("z.mcap: 200 frames\n"), "{run}");
}

#[cfg(unix)]
#[test]
fn every_signal_that_ends_a_program_ends_a_recording_whole() {
    let folder = Folder::new();
    for signal in ["INT", "TERM", "HUP"] {
        let name = format!("{signal}.mcap");
        let mut running = Running::start(&folder, &format!("record {SIM} -o {name}"));
        let size = || std::fs::metadata(folder.path(&name)).map_or(0, |about| about.len());
        wait("a chunk of frames", || size() > 6_000);
        // Twice in a row, as `timeout` tells a program and its group.
        let pid = running.child.id().to_string();
        let mut kill = Command::new("kill");
        kill.args([&format!("-{signal}"), &pid, &pid]);
        assert!(kill.status().unwrap().success());
        assert_eq!(running.child.wait().unwrap().code(), Some(0), "{signal}");
        folder.good(&format!("convert {name} -o {signal}.txt"));
    }
}

/// Two devices send to one port: one of them is recorded.
#[test]
fn one_sender_is_recorded_and_the_other_counted() {
    let folder = Folder::new();
    let mut running = Running::start(
        &folder,
        "record udp:127.0.0.1:0 --sensor sensor.toml -o one.mcap --frames 40",
    );
    let (place, _said) = running.place();
    let port = place.strip_prefix("udp:").unwrap();
    let [device, other] = [(); 2].map(|()| UdpSocket::bind("127.0.0.1:0").unwrap());
    let mut number = 0;
    while running.child.try_wait().unwrap().is_none() {
        let row = |first: u32| {
            format!(
                "{first},31,32,33,34,35,\n{}",
                "30,31,32,33,34,35,\n".repeat(3)
            )
        };
        device
            .send_to(row(100 + number % 50).as_bytes(), port)
            .unwrap();
        if number > 5 {
            other.send_to(row(900).as_bytes(), port).unwrap();
        }
        number += 1;
        assert!(number < 10_000, "nothing is recorded");
        std::thread::sleep(Duration::from_millis(5));
    }
    assert_eq!(running.child.wait().unwrap().code(), Some(3));
    // What reads the file later says so too.
    let converted = folder.taxel("convert one.mcap -o one.txt");
    assert_eq!(converted.code, Some(3), "{converted}");
    assert!(converted.err.contains("of other senders"), "{converted}");
    let firsts: Vec<f64> = folder
        .numbers("one.txt")
        .chunks(24)
        .map(|frame| frame[0])
        .collect();
    assert_eq!(firsts.len(), 40);
    assert!(firsts.iter().all(|first| *first < 200.0), "{firsts:?}");
}

/// A folder in the temporary directory of its own goes with the program, however it is asked to end.
#[cfg(unix)]
#[test]
fn a_self_test_that_is_ended_leaves_no_folder() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("temporary")).unwrap();
    for (signal, words) in [
        (
            "TERM",
            "selftest --live sim:sensor.toml?hand --sensor sensor.toml --seconds 60 --yes",
        ),
        (
            "HUP",
            "selftest --live sim:sensor.toml?hand --sensor sensor.toml --seconds 60",
        ),
    ] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_taxel"))
            .args(words.split_whitespace())
            .current_dir(folder.path(""))
            .env("TMPDIR", folder.path("temporary"))
            .stdin(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let inside = || std::fs::read_dir(folder.path("temporary")).unwrap().count();
        wait("a folder", || inside() == 1);
        let pid = child.id().to_string();
        assert!(
            Command::new("kill")
                .args([&format!("-{signal}"), &pid])
                .status()
                .unwrap()
                .success()
        );
        assert_eq!(child.wait().unwrap().code(), Some(2), "{signal}");
        assert_eq!(inside(), 0, "{signal}");
    }
}

/// A disk with no more room, said at once; what is in the file is whole.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_ends_the_recording_with_what_it_has() {
    let folder = Folder::new();
    let taxel = env!("CARGO_BIN_EXE_taxel");
    // The shell's limit counts blocks of 512 or 1024 bytes; writing beyond it fails as on a full disk.
    let script = format!(
        "trap '' XFSZ; ulimit -f 60; exec {taxel} record sim:sensor.toml?random&fps=400 -o full.mcap --secs 60"
    );
    let script = script.replace(
        "sim:sensor.toml?random&fps=400",
        "'sim:sensor.toml?random&fps=400'",
    );
    let output = Command::new("sh")
        .args(["-c", &script])
        .current_dir(folder.path(""))
        .output()
        .unwrap();
    let run = Run::from(output);
    assert_eq!(run.code, Some(3), "{run}");
    assert!(
        run.err.contains("error: recording full.mcap ended after "),
        "{run}"
    );
    folder.good("convert full.mcap -o full.txt");
    assert!(folder.numbers("full.txt").len() >= 24);
}
