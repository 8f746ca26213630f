//! What is too large is refused with a sentence, in bounded memory; who waits says what for.

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

use crate::run::{Folder, Run, SENSOR};

/// The most memory that a reader may take, KiB.
#[cfg(target_os = "linux")]
const MAX_KIB: u32 = 256 << 10;

/// Runs `taxel` with no more memory of its own than a reader may take: what asks for more is ended by the system.
#[cfg(target_os = "linux")]
fn bounded(folder: &Folder, words: &str) -> Run {
    let output = Command::new("sh")
        .args(["-c", "ulimit -d $0 && exec \"$@\""])
        .arg(MAX_KIB.to_string())
        .arg(env!("CARGO_BIN_EXE_taxel"))
        .args(words.split_whitespace())
        .current_dir(folder.path(""))
        .stdin(Stdio::null())
        .output()
        .unwrap();
    Run::from(output)
}

/// A sensor file of another size.
fn sensor(rows: usize, columns: usize) -> String {
    SENSOR
        .replace("rows = 4", &format!("rows = {rows}"))
        .replace("columns = 6", &format!("columns = {columns}"))
}

#[cfg(target_os = "linux")]
#[test]
fn a_table_of_too_many_lines_cells_or_bytes_is_refused() {
    let folder = Folder::new();
    folder.write("run.txt", "1,2,3,4,5,6\n");
    folder.write(
        "lines.csv",
        &format!("recording\n{}", "a\n".repeat(4_000_000)),
    );
    let header = "conductance_siemens,load_g";
    folder.write(
        "cells.csv",
        &format!("{header}{}\n1,2\n", ",".repeat(8_000_000)),
    );
    folder.write(
        "bytes.csv",
        &format!("{header}\n{}", "1,2\n".repeat(15_000_000)),
    );
    let press = "recording,frame,row,column,load_g";
    folder.write(
        "presses.csv",
        &format!("{press}\n{}", "run.txt,0,0,0,1\n".repeat(500_000)),
    );
    folder.write(
        "plan.toml",
        "format = 1\nsensor = \"sensor.toml\"\n[[experiment]]\nkind = \"repeatability\"\nname = \"a\"\ntrials = \"lines.csv\"\n",
    );
    let to = "--sensor sensor.toml -o k.toml";
    for (words, told) in [
        (
            "evaluate plan.toml".to_owned(),
            "has 262145 lines or more, at most 262144",
        ),
        (
            format!("calibrate --pairs cells.csv {to}"),
            "has 8000002 columns, at most 256",
        ),
        (
            format!("calibrate --pairs bytes.csv {to}"),
            "has 8388609 bytes, at most 8388608",
        ),
        (
            format!("calibrate --presses presses.csv {to}"),
            "has 262145 lines or more, at most 262144",
        ),
    ] {
        let run = bounded(&folder, &words);
        assert_eq!(run.code, Some(1), "{words}: {run}");
        assert!(run.err.contains(told), "{words}: {run}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn frames_of_a_table_that_do_not_fit_are_refused_before_one_is_read() {
    let folder = Folder::new();
    folder.write("large.toml", &sensor(512, 512));
    let lines: String = (0..80).map(|n| format!("no.txt,{n},0,0,1\n")).collect();
    folder.write(
        "presses.csv",
        &format!("recording,frame,row,column,load_g\n{lines}"),
    );
    let run = bounded(
        &folder,
        "calibrate --sensor large.toml --presses presses.csv -o k.toml",
    );
    assert_eq!(run.code, Some(1), "{run}");
    let told = "its 80 frames of 262144 taxels take 180 MiB of memory, at most 160 are taken";
    assert!(run.err.contains(told), "{run}");
}

#[cfg(target_os = "linux")]
#[test]
fn an_array_that_does_not_fit_is_refused_by_every_verb() {
    let folder = Folder::new();
    folder.write("huge.toml", &sensor(4096, 4096));
    folder.write("long.toml", &sensor(4096, 8));
    folder.write("run.txt", "1,2,3,4,5,6\n");
    for words in [
        "record sim:huge.toml?hand --frames 2 -o a.mcap",
        "simulate --sensor huge.toml --pattern hand --frames 2 -o a.npy",
        "budget huge.toml",
        "netlist --sensor huge.toml -o a.cir",
        "info run.txt --sensor huge.toml",
        "analyse run.txt --sensor huge.toml --taxel 0,0",
        "plot run.txt --sensor huge.toml -o a.png",
    ] {
        let run = bounded(&folder, words);
        assert_eq!(run.code, Some(1), "{words}: {run}");
        let told = "4096 rows x 4096 columns need about 10240 MiB of memory, at most 256 are taken";
        assert!(run.err.contains(told), "{words}: {run}");
    }
    // Long and thin: only the exact inverse has no room.
    for words in [
        "budget long.toml",
        "compensate run.txt --sensor long.toml --unit siemens -o a.csv",
        "record sim:long.toml?hand --frames 2 -o a.mcap",
    ] {
        let run = bounded(&folder, words);
        assert_eq!(run.code, Some(1), "{words}: {run}");
        assert!(
            run.err.contains("for 4096 rows, at most 256"),
            "{words}: {run}"
        );
    }
    assert!(!folder.exists("a.mcap") && !folder.exists("a.csv"));
    let run = bounded(
        &folder,
        "simulate --sensor long.toml --pattern hand --frames 2 -o a.txt",
    );
    assert_eq!(run.code, Some(0), "{run}");
    let solved = "compensate a.txt --sensor long.toml --unit siemens --method newton -o a.csv";
    let run = bounded(&folder, solved);
    assert_eq!(run.code, Some(0), "{run}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_device_without_end_is_no_plan_no_table_and_no_token() {
    let folder = Folder::new();
    folder.write("wide.csv", &"1,".repeat(16 << 20));
    let to = "--sensor sensor.toml -o m.safetensors";
    for (words, told) in [
        (
            "evaluate /dev/zero".to_owned(),
            "more than the 1048576 bytes that a plan may have",
        ),
        (
            "report /dev/zero -o a.html".to_owned(),
            "more than the 1048576 bytes that a plan may have",
        ),
        (
            format!("train row-set --rows /dev/zero {to}"),
            "more than the 32 MiB",
        ),
        (
            format!("train row-set --rows wide.csv {to}"),
            "16777217 cells, expected 8",
        ),
        (
            "crosstalk --points /dev/zero".to_owned(),
            "more than the 4194304 bytes that a file of points may have",
        ),
        (
            "live sim:econe --token-file /dev/zero".to_owned(),
            "more than the 65536 bytes that a file with a token may have",
        ),
        (
            "netlist --sensor /dev/zero -o a.cir".to_owned(),
            "no sensor file has so many",
        ),
    ] {
        let run = bounded(&folder, &words);
        assert_eq!(run.code, Some(1), "{words}: {run}");
        assert!(run.err.contains(told), "{words}: {run}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_sensor_file_of_the_most_bytes_takes_no_more_than_there_may_be() {
    let folder = Folder::new();
    let most = 2 << 20;
    let room = most - SENSOR.len() - 20;
    let list = format!("{SENSOR}gain = [{}]\n", "1,".repeat(room / 2));
    folder.write("list.toml", &list);
    let run = bounded(&folder, "netlist --sensor list.toml -o a.cir");
    assert_eq!(run.code, Some(1), "{run}");
    assert!(run.err.contains("list.toml"), "{run}");
    folder.write("long.toml", &format!("{SENSOR}# {}\n", "x".repeat(most)));
    let run = bounded(&folder, "netlist --sensor long.toml -o a.cir");
    assert!(run.err.contains("more than 2097152 bytes"), "{run}");
}

#[test]
fn more_rows_than_a_sensor_may_have_are_refused() {
    let folder = Folder::new();
    folder.write("run.txt", "1,2,3,4,5,6\n");
    for words in [
        "info run.txt",
        "plot run.txt -o a.png",
        "analyse run.txt --column 1",
    ] {
        for rows in ["0", "4097", "18446744073709551615"] {
            let run = folder.taxel(&format!("{words} --rows {rows}"));
            assert_eq!(run.code, Some(2), "{run}");
            assert!(run.err.contains("from 1 to 4096"), "{run}");
        }
    }
}

#[test]
fn a_header_without_sense_is_quoted_in_part() {
    let folder = Folder::new();
    let word = "F".repeat(1 << 20);
    let header = format!(r#"{{"a":{{"dtype":"{word}","shape":[1],"data_offsets":[0,4]}}}}"#);
    let mut bytes = (header.len() as u64).to_le_bytes().to_vec();
    bytes.extend(header.bytes());
    bytes.extend([0; 4]);
    std::fs::write(folder.path("m.safetensors"), bytes).unwrap();
    let run = folder.fails("model show m.safetensors");
    assert!(run.err.contains("not a safetensors file"), "{run}");
    assert!(run.err.len() < 300, "{} bytes", run.err.len());
    folder.write("plan.toml", &"1".repeat(1 << 18));
    let run = folder.fails("evaluate plan.toml");
    assert!(run.err.len() < 1500, "{} bytes", run.err.len());
}

/// The first line that a command says while nothing is said to it.
fn first_word(folder: &Folder, words: &str) -> String {
    let mut child = Command::new(env!("CARGO_BIN_EXE_taxel"))
        .args(words.split(' '))
        .current_dir(folder.path(""))
        // Held open, and silent.
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut told = String::new();
    let mut lines = BufReader::new(child.stderr.take().unwrap());
    lines.read_line(&mut told).unwrap();
    child.kill().unwrap();
    child.wait().unwrap();
    told
}

#[test]
fn who_waits_for_standard_input_says_so() {
    let folder = Folder::new();
    let told = first_word(&folder, "compensate - --sensor sensor.toml -o a.csv");
    assert!(
        told.contains("standard input may not have said all of it"),
        "{told}"
    );
}

#[cfg(unix)]
#[test]
fn who_waits_for_a_pipe_that_another_file_names_says_so() {
    let folder = Folder::new();
    let pipe = folder.path("run.txt");
    assert!(Command::new("mkfifo").arg(pipe).status().unwrap().success());
    folder.write(
        "presses.csv",
        "recording,frame,row,column,load_g\nrun.txt,0,1,1,100\n",
    );
    folder.write(
        "plan.toml",
        "format = 1\nsensor = \"sensor.toml\"\n[[experiment]]\nname = \"once\"\nkind = \"repeatability\"\ntrials = \"trials.csv\"\n",
    );
    folder.write(
        "trials.csv",
        "recording,row,column,experiment\nrun.txt,1,1,a\n",
    );
    for words in [
        "calibrate --sensor sensor.toml --presses presses.csv -o a.toml",
        "evaluate plan.toml",
        "record file:run.txt --sensor sensor.toml -o a.mcap",
    ] {
        let told = first_word(&folder, words);
        assert!(
            told.contains("run.txt may not have said all"),
            "{words}: {told}"
        );
    }
}
