//! Whoever solves a frame, its numbers are the same: on one core or several, of a file or of a pipe.

use crate::run::{Folder, SENSOR};

const FILES: [&str; 8] = [
    "loads.csv",
    "loads.marks.csv",
    "se.npy",
    "se.noise.npy",
    "se.fit.npy",
    "se.model.npy",
    "half.npy",
    "figures.csv",
];

/// All that is written of a recording.
fn converted(folder: &Folder, recording: &str, words: &str) -> Vec<Vec<u8>> {
    folder.good(&format!(
        "compensate {recording} --sensor sensor.toml -o loads.csv --standard-error se.npy --parts --interval half.npy \
         --figures figures.csv {words}"
    ));
    FILES
        .iter()
        .map(|name| std::fs::read(folder.path(name)).unwrap())
        .collect()
}

/// Blobs that jump, with noise and readings that are stuck: more frames than one thread gets at once.
fn many_frames(sensor: &str) -> Folder {
    let folder = Folder::new();
    folder.write("sensor.toml", sensor);
    folder.good(
        "simulate --sensor sensor.toml --pattern hand --frames 300 --seed 5 --load-g 300 -o many.txt",
    );
    folder
}

#[test]
fn every_number_of_threads_gives_the_same_files() {
    let remembers = format!(
        "{SENSOR}\n[material.dynamic]\nlag_weight = [0.08]\nlag_secs = [0.8]\nplay_weight = [0.07]\nplay_g = [40.0]\nperiod_secs = 0.01\n"
    );
    for sensor in [SENSOR, &remembers] {
        let folder = many_frames(sensor);
        let one = converted(&folder, "many.txt", "--threads 1");
        for words in ["--threads 2", "--threads 7", ""] {
            assert!(converted(&folder, "many.txt", words) == one, "{words}");
        }
    }
}

#[test]
fn a_recording_written_by_several_threads_holds_the_same_frames() {
    let folder = many_frames(SENSOR);
    folder.good("convert many.txt --sensor sensor.toml -o many.mcap");
    for (ending, one, three) in [
        ("mcap", "a.mcap", "b.mcap"),
        ("parquet", "a.parquet", "b.parquet"),
    ] {
        for (output, threads) in [(one, 1), (three, 3)] {
            folder.good(&format!(
                "compensate many.mcap -o {output} --threads {threads}"
            ));
        }
        let bytes = |name: &str| std::fs::read(folder.path(name)).unwrap();
        assert!(bytes(one) == bytes(three), "{ending}");
    }
}

#[test]
fn a_pipe_gives_what_the_file_gives() {
    let folder = many_frames(SENSOR);
    let text = folder.read("many.txt");
    // A pipe is not looked through for faulty lines first; there are none.
    let of_file = folder.taxel("compensate many.txt --sensor sensor.toml");
    let of_pipe = folder.taxel_with("compensate - --sensor sensor.toml", &text);
    assert_eq!((of_file.code, of_pipe.code), (Some(0), Some(0)));
    assert!(of_file.out == of_pipe.out);
}

#[test]
fn a_frame_that_is_broken_is_named_whoever_reads_it() {
    let folder = many_frames(SENSOR);
    let text = folder.read("many.txt");
    let whole: Vec<&str> = text.lines().take(4 * 200).collect();
    let broken = whole.join("\n") + "\n1,2,x,4,5,6,\n";
    for threads in ["--threads 1", "--threads 3"] {
        // A pipe: a file is looked through before anything is solved.
        let words = format!("compensate - --sensor sensor.toml {threads}");
        let run = folder.taxel_with(&words, &broken);
        assert_eq!(run.code, Some(1), "{run}");
        assert!(run.err.contains("line 801"), "{run}");
        let run = folder.taxel_with(&format!("{words} --keep-going -o some.csv"), &broken);
        assert_eq!(run.code, Some(3), "{run}");
        assert_eq!(folder.read("some.csv").lines().count(), 4 * 200);
    }
}

#[test]
fn no_threads_are_refused() {
    let folder = many_frames(SENSOR);
    for threads in ["0", "-1", "x", "100000"] {
        let words =
            format!("compensate many.txt --sensor sensor.toml -o a.npy --threads={threads}");
        let run = folder.taxel(&words);
        assert_eq!(run.code, Some(2), "{run}");
        assert!(run.err.contains("--threads"), "{run}");
    }
}
