//! What several frames amount to in one map, and that a simulated recording is called so wherever its numbers stand.

use crate::run::Folder;

/// Four frames of a sensor of 2 × 2, one taxel of which has its highest load in each.
fn four_frames() -> Folder {
    let folder = Folder::new();
    folder.write(
        "loads.csv",
        "1,2\n3,0\n\n5,2\n1,0\n\n0,8\n2,0\n\n2,0\n2,4\n",
    );
    folder
}

#[test]
fn the_mean_and_the_highest_of_each_taxel_are_one_map() {
    let folder = four_frames();
    let draw = |what: &str| {
        folder.good(&format!(
            "plot loads.csv --values --rows 2 {what} -o map.svg"
        ));
        folder.read("map.svg")
    };
    let of = |numbers: &str| {
        folder.write("one.csv", numbers);
        folder.good("plot one.csv --values --rows 2 -o one.svg");
        folder.read("one.svg")
    };
    let image = |svg: &str| -> String {
        let begin = svg.find("data:image/png").unwrap();
        svg[begin..].split('"').next().unwrap().to_owned()
    };
    let mean = draw("--mean");
    assert!(
        mean.contains("mean of each taxel, 4 frames, 0 to 3"),
        "{mean}"
    );
    assert_eq!(image(&mean), image(&of("2,3\n2,1\n")));
    let peak = draw("--peak");
    assert!(
        peak.contains("highest of each taxel, 4 frames, 0 to 3"),
        "{peak}"
    );
    assert_eq!(image(&peak), image(&of("5,8\n3,4\n")));
    let some = draw("--peak --frames 1..3");
    assert!(
        some.contains("highest of each taxel, 2 frames, 1 to 2"),
        "{some}"
    );
    assert_eq!(image(&some), image(&of("5,8\n2,0\n")));
    for refused in ["--mean --peak", "--mean --frame 1", "--peak --row 1"] {
        folder.fails(&format!(
            "plot loads.csv --values --rows 2 {refused} -o no.svg"
        ));
    }
    let movie = folder.fails("plot loads.csv --values --rows 2 --mean -o no.gif");
    assert!(movie.err.contains("a movie of whole frames"), "{movie}");
}

#[test]
fn two_recordings_are_drawn_beside_each_other_over_one_range() {
    let folder = four_frames();
    folder.write("other.csv", "9,2\n3,0\n\n1,2\n1,0\n");
    let words = "plot loads.csv --values --rows 2 --beside other.csv";
    folder.good(&format!("{words} --peak -o both.svg"));
    let both = folder.read("both.svg");
    for told in [
        "loads.csv: highest of each taxel, 4 frames",
        "other.csv: highest of each taxel, 2 frames",
    ] {
        assert!(both.contains(told), "{told}");
    }
    assert_eq!(
        both.matches("data:image/png").count(),
        4,
        "two maps, each with its bar of colours"
    );
    folder.good(&format!("{words} --frame 1 -o frames.svg"));
    assert!(folder.read("frames.svg").contains("other.csv: frame 1"));
    let missing = folder.fails(&format!("{words} --frame 3 -o no.svg"));
    assert!(missing.err.contains("other.csv"), "{missing}");
    let several = folder.fails(&format!("{words} --frames 0..2 -o no.svg"));
    assert!(several.err.contains("several frames of each"), "{several}");
    folder.fails(&format!("{words} --peak -o no.gif"));
}

#[test]
fn what_was_simulated_is_called_so() {
    let folder = Folder::new();
    folder
        .good("simulate --sensor sensor.toml --pattern hand --frames 30 --period 0.05 -o run.mcap");
    let told = "simulated (simulate:small)";
    assert!(folder.good("info run.mcap").out.contains(told));
    let measured = folder.good("measure run.mcap --picture force.svg");
    assert!(measured.out.contains(told), "{measured}");
    assert!(folder.read("force.svg").contains(told));
    let json = folder.good("measure run.mcap --json");
    assert!(
        json.out.contains("\"simulated\": \"simulate:small\""),
        "{json}"
    );
    folder.good("plot run.mcap -o frame.svg");
    assert!(folder.read("frame.svg").contains(told));
    // Text tells nothing of where it came from.
    folder.good("simulate --sensor sensor.toml --pattern hand --frames 30 -o run.txt");
    let text = folder.good("info run.txt --sensor sensor.toml");
    assert!(!text.out.contains("simulated"), "{text}");
}
