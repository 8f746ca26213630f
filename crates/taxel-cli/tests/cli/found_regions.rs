//! `taxel measure --regions auto` where a hand moves, by phalanges, and of feet: found, kept in a file, changed, used again.

use taxel::frame::newtons_from_grams;
use taxel::simulate::Pattern;
use taxel_app::measure::recording_regions_of_file;

use crate::live::{Running, told, view};
use crate::run::Folder;

/// Two grips in two places, each sliding: through the circuit and its noise all fingers keep their names and forces.
#[test]
fn a_hand_that_moves_keeps_its_fingers_and_its_file_can_be_changed() {
    let econe = taxel::sensor::preset("econe").unwrap();
    let pattern = Pattern::named("regrip").unwrap();
    let (mut frames, mut right) = (0, 0);
    for seed in [1, 2] {
        let folder = Folder::new();
        folder.good(&format!(
            "simulate --sensor econe --pattern regrip --frames 320 --seed {seed} -o hand.txt"
        ));
        let run = folder.good("measure hand.txt --sensor econe --frames-per-second 100 --no-intervals --regions auto --write-regions r.toml -o f.csv --json");
        assert!(
            run.err.contains("a hand, with a confidence of") && run.err.contains("windows of time"),
            "{run}"
        );
        let told: serde_json::Value = serde_json::from_str(&run.out).unwrap();
        assert!(told["region_confidence"]["little"].as_f64().unwrap() > 0.5);
        assert_eq!(told["regions"].as_array().unwrap().len(), 6);
        let fingers = ["index", "middle", "ring", "little"];
        let found = fingers.map(|name| folder.column("f.csv", &format!("{name}_n")));
        for frame in (50..115).chain(210..275) {
            let loads = pattern.loads(econe.array(), seed, frame);
            let parts = pattern.hand_parts(econe.array(), seed, frame).unwrap();
            let is_right = |(name, found): (&str, &Vec<f64>)| {
                let own = parts
                    .iter()
                    .enumerate()
                    .filter(|(_, part)| **part == Some(name));
                let grams: f64 = own.map(|(taxel, _)| loads.values()[taxel]).sum();
                (found[frame as usize] / newtons_from_grams(grams) - 1.0).abs() < 0.05
            };
            frames += 1;
            right += usize::from(fingers.into_iter().zip(&found).all(is_right));
        }
        let text = folder.read("r.toml");
        assert!(text.matches("name = \"little\"").count() > 1 && text.contains("frames = ["));
        folder.write("r.toml", &text.replace("\"little\"", "\"small finger\""));
        folder.good("measure hand.txt --sensor econe --frames-per-second 100 --no-intervals --regions r.toml -o g.csv");
        assert_eq!(folder.column("g.csv", "small_finger_n"), found[3]);
        follows_all_taxels_of_its_windows(&folder);
        // Where nothing is known of frames there is nothing that moves.
        for elsewhere in [
            "live sim:econe --regions r.toml",
            "view hand.txt --beside hand.txt --sensor econe --regions r.toml",
        ] {
            let run = folder.taxel(elsewhere);
            assert!(
                run.code == Some(1)
                    && run
                        .err
                        .contains("regions that move belong to one recording"),
                "{run}"
            );
        }
        are_shown_where_they_are(&folder);
    }
    assert!(
        right as f64 >= 0.95 * f64::from(frames),
        "{right} of {frames}"
    );
}

/// `analyse` has a line for each taxel on which a region lies at any time, and says so.
fn follows_all_taxels_of_its_windows(folder: &Folder) {
    let econe = taxel::sensor::preset("econe").unwrap();
    let file = folder.path("r.toml");
    let regions = recording_regions_of_file(&file, &econe).unwrap();
    let ring = regions.iter().find(|r| r.name() == "ring").unwrap();
    let analyse = "analyse hand.txt --sensor econe --region";
    let run = folder.good(&format!("{analyse} ring --regions r.toml --json"));
    let (windows, taxels) = (ring.windows().count(), ring.taxels().len());
    let says =
        format!("ring moves: these are all the taxels of its {windows} windows of time, {taxels}");
    assert!(windows > 1 && run.err.contains(&says), "{run}");
    let told: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    let names = told["taxels"].as_array().unwrap().iter();
    let names: Vec<&str> = names.map(|taxel| taxel["name"].as_str().unwrap()).collect();
    let wanted = ring.taxels().iter();
    let wanted = wanted.map(|taxel| format!("row {}, column {}", taxel / 128, taxel % 128));
    assert_eq!(names, wanted.collect::<Vec<String>>());
    let run = folder.taxel(&format!("{analyse} thump --regions r.toml"));
    assert!(
        run.code == Some(2) && run.err.contains("--region thump: there are"),
        "{run}"
    );
}

/// The page is told where each region of the file lies in which frames.
fn are_shown_where_they_are(folder: &Folder) {
    let view_words =
        "view hand.txt --sensor econe --regions r.toml --listen 127.0.0.1:0 --token abcdefgh";
    let mut running = Running::start(folder, view_words);
    let hello = told(&mut view(&running.url()), "hello");
    let regions = hello["sensor"]["regions"].as_array().unwrap();
    let small = regions
        .iter()
        .find(|region| region["name"] == "small finger")
        .unwrap();
    let windows = small["windows"].as_array().unwrap();
    let text = folder.read("r.toml");
    assert_eq!(windows.len(), text.matches("\"small finger\"").count());
    for window in windows {
        let [first, last] = [&window["frames"][0], &window["frames"][1]];
        assert!(
            text.contains(&format!("frames = [{first}, {last}]")),
            "{window}"
        );
        assert!(!window["boxes"].as_array().unwrap().is_empty());
    }
}

#[test]
fn fingers_are_cut_at_their_joints_where_asked_for() {
    let folder = Folder::new();
    folder.good("simulate --sensor econe --pattern hand --frames 160 --seed 4 -o hand.txt");
    let measure = "measure hand.txt --sensor econe --frames-per-second 100 --no-intervals";
    folder.good(&format!("{measure} --regions auto -o whole.csv"));
    folder.good(&format!(
        "{measure} --regions phalanges --write-regions r.toml -o cut.csv"
    ));
    let whole = folder.column("whole.csv", "ring_n");
    let parts =
        ["proximal", "middle", "distal"].map(|p| folder.column("cut.csv", &format!("ring_{p}_n")));
    for (frame, whole) in whole.iter().enumerate() {
        let sum: f64 = parts.iter().map(|part| part[frame]).sum();
        assert!((sum - whole).abs() < 1e-9, "{frame}: {sum} {whole}");
    }
    assert_eq!(folder.read("r.toml").matches("confidence").count(), 14);
}

#[test]
fn feet_are_cut_from_heel_to_toes() {
    let folder = Folder::new();
    folder.good("simulate --sensor mat-32x32-adg732 --pattern feet --frames 60 -o feet.txt");
    let run = folder.good("measure feet.txt --sensor mat-32x32-adg732 --frames-per-second 100 --no-intervals --regions auto -o f.csv");
    assert!(
        run.err
            .contains("a footprint or more, with a confidence of"),
        "{run}"
    );
    let sum: f64 = (1..=2)
        .flat_map(|foot| {
            ["heel", "midfoot", "forefoot", "toes"].map(|part| format!("foot_{foot}_{part}_n"))
        })
        .map(|name| folder.column("f.csv", &name)[30])
        .sum();
    let total = folder.column("f.csv", "total_n")[30];
    assert!((sum / total - 1.0).abs() < 0.02, "{sum} of {total}");
}

#[test]
fn windows_of_a_region_that_overlap_are_refused() {
    let folder = Folder::new();
    folder.good("simulate --sensor mat-32x32-adg732 --pattern hand --frames 20 -o hand.txt");
    let window = |frames: &str| {
        format!("[[region]]\nname = \"heel\"\nboxes = [[0, 1, 0, 1]]\nframes = {frames}\n")
    };
    let bad = |frames: [&str; 2], words: &str| {
        folder.write("r.toml", &(window(frames[0]) + &window(frames[1])));
        let run = folder.taxel("measure hand.txt --sensor mat-32x32-adg732 --regions r.toml");
        assert!(
            run.code != Some(0) && run.err.contains(words) && run.err.contains("hint"),
            "{run}"
        );
    };
    bad(
        ["[0, 9]", "[9, 19]"],
        "frames 9 to 19 and of frames 0 to 9, which overlap",
    );
    bad(
        ["[5, 4]", "[9, 19]"],
        "frames 5 to 4, which end before they begin",
    );
}
