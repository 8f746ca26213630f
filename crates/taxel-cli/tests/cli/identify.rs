//! `taxel identify`: recordings of a mat in, the read-outs that explain them out.

use crate::run::Folder;

#[test]
fn a_floating_mat_is_identified_from_its_recording_alone() {
    let folder = Folder::new();
    folder.good(
        "simulate --sensor mat-16x16-cd4067 --pattern fingers --frames 12 --seed 3 -o run.txt",
    );
    let run = folder.good("identify run.txt --rows 16");
    assert!(
        run.out.starts_with("read-out     divider-floating\n"),
        "{run}"
    );
    assert!(run.err.contains("assumed: 16 rows x 16 columns"), "{run}");
    let json = folder
        .good("identify run.txt --sensor mat-16x16-cd4067 --json")
        .out;
    assert!(json.contains("\"verdict\": \"one\""), "{json}");
}

#[test]
fn a_recorder_that_cuts_small_readings_off_is_seen() {
    let folder = Folder::new();
    folder
        .good("simulate --sensor mat-16x16-cd4067 --pattern hand --frames 40 --seed 3 -o run.txt");
    let text = folder.read("run.txt");
    let cut = |word: &str| match word.parse::<u32>() {
        Ok(count) if count <= 40 => "0".to_owned(),
        _ => word.to_owned(),
    };
    let cut = text.lines().map(|line| {
        let words: Vec<String> = line.split(',').map(cut).collect();
        words.join(",") + "\n"
    });
    folder.write("cut.txt", &cut.collect::<String>());
    let run = folder.good("identify cut.txt --rows 16");
    assert!(run.err.contains("writes 0 for 40 counts and less"), "{run}");
    // What was cut off is no reading of 0, which would speak against lines that float.
    assert!(
        run.out.starts_with("read-out     divider-floating\n"),
        "{run}"
    );
}

#[test]
fn what_cannot_be_identified_says_why() {
    let folder = Folder::new();
    let line = "40,40,41,40,40,40,40,40\n";
    folder.write("empty.txt", &line.repeat(16));
    folder.write("nothing.txt", "");
    let run = folder.taxel("identify empty.txt --rows 8");
    assert_eq!(run.code, Some(1), "{run}");
    assert!(run.err.contains("frames must be pressed"), "{run}");
    let run = folder.taxel("identify empty.txt");
    assert!(run.err.contains("`--rows N`"), "{run}");
    let run = folder.taxel("identify nothing.txt --rows 8");
    assert_eq!(run.code, Some(1), "{run}");
    let run = folder.taxel("identify empty.txt --sensor mat-16x16-cd4067");
    assert_eq!(run.code, Some(1), "{run}");
    assert!(run.err.contains("16"), "{run}");
}
