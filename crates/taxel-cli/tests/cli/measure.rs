//! `taxel measure`: what was pressed comes back as forces over time, of all, of a grip and of regions, and trial by trial.

use std::f64::consts::PI;

use crate::recordings::tared;
use crate::run::Folder;

/// A recording of 160 frames of a hand, with its true loads in newtons.
fn gripped(sensor: &str, seed: u32) -> (Folder, Vec<Vec<f64>>) {
    let folder = Folder::new();
    folder.good(&format!(
        "simulate --sensor {sensor} --pattern hand --frames 160 --seed {seed} -o hand.txt --truth truth.csv"
    ));
    let truth = folder.numbers("truth.csv");
    let each = truth.len() / 160;
    let newtons = |g: &f64| g * 9.80665e-3;
    let truth = truth.chunks(each).map(|f| f.iter().map(newtons).collect());
    (folder, truth.collect())
}

/// Share of frames whose number lies within what it is said to be off by.
fn covered(found: &[f64], half: &[f64], truth: &[f64]) -> f64 {
    let within = found.iter().zip(half).zip(truth);
    let within = within.filter(|((found, half), truth)| (*found - *truth).abs() <= **half);
    within.count() as f64 / found.len() as f64
}

#[test]
fn total_grip_and_a_region_are_what_was_pressed_within_their_intervals() {
    for seed in [1, 2, 3] {
        let (folder, truth) = gripped("econe", seed);
        folder.write(
            "hand.toml",
            "[[region]]\nname = \"Far half\"\nboxes = [[0, 63, 60, 127]]\n",
        );
        folder.good(
            "measure hand.txt --sensor econe --frames-per-second 100 --regions hand.toml -o f.csv",
        );
        let held = |name: &str| folder.column("f.csv", name)[50..110].to_vec();
        let truth = &truth[50..110];
        let totals: Vec<f64> = truth.iter().map(|frame| frame.iter().sum()).collect();
        assert!(covered(&held("total_n"), &held("total_error_n"), &totals) >= 0.85);
        // By a search all around, of the 128 lines that lie a pitch of 2 mm apart on 81.49 mm.
        let grip = |frame: &Vec<f64>| {
            let line = |c: usize| (0..64).map(|r| frame[r * 128 + c]).sum::<f64>();
            let lines: Vec<f64> = (0..128).map(line).collect();
            let along = |phi: f64| -> f64 {
                let each = lines.iter().enumerate();
                0.5 * each
                    .map(|(c, f)| f * (4.0 / 81.49 * c as f64 - phi).cos().abs())
                    .sum::<f64>()
            };
            (0..4000)
                .map(|i| along(PI * f64::from(i) / 4000.0))
                .fold(0.0, f64::max)
        };
        let grips: Vec<f64> = truth.iter().map(grip).collect();
        assert!(covered(&held("grip_n"), &held("grip_error_n"), &grips) >= 0.85);
        let far = |frame: &Vec<f64>| {
            let taxels = frame.iter().enumerate().filter(|(t, _)| t % 128 >= 60);
            taxels.map(|(_, f)| f).sum()
        };
        let fars: Vec<f64> = truth.iter().map(far).collect();
        assert!(covered(&held("far_half_n"), &held("far_half_error_n"), &fars) >= 0.85);
    }
}

/// Half a count of noise on a mat of 10 bits whose lines are left open: its inverse bends, and the sum of all loads was 9 % too large.
#[test]
fn noise_does_not_add_up_where_lines_are_left_open() {
    let preset = taxel::sensor::preset("mat-16x16-cd4067").unwrap();
    let noisy = preset.edited(|spec| {
        spec.converter.noise_counts = Some(0.5);
        spec.name = "mat".to_owned();
    });
    for seed in [1, 2, 3] {
        let folder = Folder::new();
        folder.write("mat.toml", &noisy.as_ref().unwrap().to_toml());
        folder.good(&format!(
            "simulate --sensor mat.toml --pattern hand --frames 110 --seed {seed} -o hand.txt --truth truth.csv"
        ));
        folder.good("measure hand.txt --sensor mat.toml --frames-per-second 100 -o f.csv");
        let truth = folder.numbers("truth.csv");
        let truth: Vec<f64> = truth
            .chunks(256)
            .map(|f| 9.80665e-3 * f.iter().sum::<f64>())
            .collect();
        let held = |name: &str| folder.column("f.csv", name)[50..].to_vec();
        let (found, half) = (held("total_n"), held("total_error_n"));
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let off = mean(&found) / mean(&truth[50..]) - 1.0;
        assert!(off.abs() < 0.01, "{off}");
        assert!(covered(&found, &half, &truth[50..]) >= 0.95);
        assert!(mean(&half) < 0.08 * mean(&found));
        assert!(held("grip_n").iter().all(|n| n.is_nan()), "the mat is flat");
        // An archive's summary says the same of the frame with the largest force.
        folder.good("batch hand.txt --sensor mat.toml --out out");
        let (all, errors) = (
            folder.column("f.csv", "total_n"),
            folder.column("f.csv", "total_error_n"),
        );
        let largest = (0..all.len())
            .max_by(|a, b| all[*a].total_cmp(&all[*b]))
            .unwrap();
        let told = |name: &str| folder.column("out/summary.csv", name)[0];
        assert!((told("peak_force_n") - all[largest]).abs() < 1e-9);
        assert!((told("peak_force_half_width_n") - errors[largest]).abs() < 1e-9);
    }
}

/// A recording tells which part is which, and each has its force within a twentieth, in every frame of the hold.
#[test]
fn the_fingers_of_a_hand_are_found_with_their_forces() {
    let econe = taxel::sensor::preset("econe").unwrap();
    let pattern = taxel::simulate::Pattern::named("hand").unwrap();
    for seed in [4, 5, 6] {
        let (folder, truth) = gripped("econe", seed);
        let run = folder.good(
            "measure hand.txt --sensor econe --frames-per-second 100 --regions auto --write-regions r.toml -o f.csv",
        );
        assert!(
            run.err.contains("a hand, with a confidence of 0.9"),
            "{run}"
        );
        let mut right = 0;
        for frame in 50..110 {
            let parts = pattern
                .hand_parts(econe.array(), u64::from(seed), frame)
                .unwrap();
            let is_right = |part: &&str| {
                let loads = truth[frame as usize].iter().zip(&parts);
                let true_newtons: f64 = loads
                    .filter(|(_, p)| **p == Some(*part))
                    .map(|(f, _)| f)
                    .sum();
                let found = folder.column("f.csv", &format!("{part}_n"))[frame as usize];
                (found / true_newtons - 1.0).abs() < 0.05
            };
            right += usize::from(taxel::segment::HAND_PARTS.iter().all(is_right));
        }
        assert!(right >= 57, "{right} of 60 frames");
        // What was found can be read back, and renamed.
        let renamed = folder
            .read("r.toml")
            .replace("\"little\"", "\"small finger\"");
        folder.write("r.toml", &renamed);
        folder.good("measure hand.txt --sensor econe --frames-per-second 100 --regions r.toml --no-intervals -o g.csv");
        let before = folder.column("f.csv", "little_n");
        assert_eq!(folder.column("g.csv", "small_finger_n"), before);
    }
}

#[test]
fn trials_are_found_by_force_or_said() {
    let (folder, _) = gripped("mat-32x32-adg732", 2);
    let measured = |words: &str| -> serde_json::Value {
        let run = folder.good(&format!(
            "measure hand.txt --sensor mat-32x32-adg732 --frames-per-second 100 --json {words}"
        ));
        serde_json::from_str(&run.out).unwrap()
    };
    let by_force = measured("");
    let trials = by_force["trials"].as_array().unwrap();
    assert_eq!(trials.len(), 1);
    let total = &trials[0]["forces"][0];
    let largest = total["peak_n"]["value"].as_f64().unwrap();
    let steady = total["plateau"]["mean_n"]["value"].as_f64().unwrap();
    assert!((0.95..1.0).contains(&(steady / largest)), "{total}");
    // It holds from frame 48 to 119.
    let from = total["plateau"]["from_s"].as_f64().unwrap();
    let to = total["plateau"]["to_s"].as_f64().unwrap();
    assert!(from > 0.4 && to < 1.25 && to - from > 0.4, "{total}");
    let two = measured("--trials 0.5..0.8,0.9..1.1");
    assert_eq!(two["trials"].as_array().unwrap().len(), 2);
    assert_eq!(two["trials"][1]["from_s"], 0.9);
    let whole = measured("--trials whole --no-intervals");
    assert_eq!(whole["trials"][0]["frames"], 160);
    assert!(
        whole["trials"][0]["forces"][0]["peak_n"]
            .get("half_width_95")
            .is_none()
    );
    // The same numbers, with intervals or without.
    let value = |of: &serde_json::Value| of["trials"][0]["forces"][0]["peak_n"]["value"].clone();
    assert_eq!(value(&whole), value(&by_force));
}

/// Seconds of counted frames are those of the recording, whether or not its first frame can be read; and what times are off by in their
/// last digit loses no frame.
#[test]
fn a_damaged_first_frame_moves_no_trial() {
    let folder = Folder::new();
    folder
        .good("simulate --sensor sensor.toml --pattern uniform --frames 40 --seed 1 -o whole.txt");
    let text = folder.read("whole.txt");
    let (first, rest) = text.split_once(',').unwrap();
    folder.write("damaged.txt", &format!("{first}x,{rest}"));
    let from_to = |name: &str| {
        let run = folder.taxel(&format!(
            "measure {name} --sensor sensor.toml --frames-per-second 10 --keep-going --no-intervals --trials 1.6..1.9 --json"
        ));
        let told: serde_json::Value = serde_json::from_str(&run.out).unwrap();
        let trial = &told["trials"][0];
        ["from_s", "to_s", "frames"].map(|key| trial[key].as_f64().unwrap())
    };
    let whole = from_to("whole.txt");
    assert_eq!(whole, [1.6, 1.9, 4.0]);
    assert_eq!(from_to("damaged.txt"), whole);
}

/// A sensor that has drifted reads what nobody presses; a second in which nothing does tells how much.
#[test]
fn a_zero_is_taken_off_and_one_under_load_is_doubted() {
    let (folder, truth) = gripped("mat-32x32-adg732", 2);
    let preset = taxel::sensor::preset("mat-32x32-adg732").unwrap();
    let drifted = preset.edited(|spec| spec.material.as_mut().unwrap().g_zero_siemens = 0.6e-6);
    folder.write("drifted.toml", &drifted.unwrap().to_toml());
    let total = |words: &str, frame: usize| {
        let run = folder.good(&format!(
            "measure hand.txt --sensor drifted.toml --frames-per-second 100 --no-intervals -o f.csv {words}"
        ));
        (folder.column("f.csv", "total_n")[frame], run.err)
    };
    let empty: f64 = truth[7].iter().sum();
    let (off, _) = total("", 7);
    let (zeroed, told) = total("--zero 0..0.05", 7);
    assert!((off - empty).abs() > 0.2 && (zeroed - empty).abs() < 0.1 * (off - empty).abs());
    assert!(told.contains("the zero takes") && !told.contains("was something pressing"));
    let run = folder.taxel(
        "measure hand.txt --sensor drifted.toml --frames-per-second 100 --no-intervals --zero 0.8..0.9",
    );
    assert!(
        run.code == Some(3) && run.err.contains("was something pressing"),
        "{run}"
    );
    let run = folder.taxel("measure hand.txt --sensor drifted.toml --zero 0..1");
    assert!(
        run.code == Some(2) && run.err.contains("to take the zero from"),
        "{run}"
    );
}

/// A quarter of what presses was there before the recording began: taken off, told, and doubted.
#[test]
fn a_tare_of_the_recording_is_taken_off_and_told() {
    let folder = Folder::new();
    tared(&folder);
    let with = folder.good("measure run.mcap -o with.csv");
    assert!(
        with.err.contains("the tare of the recording takes 12.00 N off the total, from frame number 1 on (--no-tare leaves it on)"),
        "{with}"
    );
    assert!(with.err.contains("was something pressing?"), "{with}");
    let without = folder.good("measure run.mcap --no-tare -o without.csv");
    assert!(
        without
            .err
            .contains("the tare of the recording, 12.00 N from frame number 1 on, is left on"),
        "{without}"
    );
    assert!(
        !without.err.contains("was something pressing?"),
        "{without}"
    );
    let raw = folder.good("measure run.mcap --method raw --json");
    let raw: serde_json::Value = serde_json::from_str(&raw.out).unwrap();
    assert_eq!(raw["tares"][0]["newtons"], 6.0);
    let [with, without] = ["with.csv", "without.csv"].map(|table| folder.column(table, "total_n"));
    for (frame, taken) in [0.0, 12.0, 12.0, 0.0].into_iter().enumerate() {
        assert!(
            (without[frame] - with[frame] - taken).abs() < 1e-9,
            "{frame}"
        );
    }
}

/// Half a hundredth of a newton of noise is no reason to believe in the fifth digit.
#[test]
fn where_the_interval_knows_of_noise_alone_forces_have_four_digits() {
    let (folder, _) = gripped("mat-32x32-adg732", 2);
    let run = folder.good("measure hand.txt --sensor mat-32x32-adg732 --frames-per-second 100");
    assert!(run.out.contains("; ± of noise alone"), "{run}");
    let total = run
        .out
        .lines()
        .find(|line| line.trim_start().starts_with("total"));
    let total = total.unwrap_or_else(|| panic!("{run}"));
    let words: Vec<&str> = total.split_whitespace().collect();
    let values = words.windows(2).filter(|pair| pair[1] == "±");
    let values: Vec<&str> = values.map(|pair| pair[0]).collect();
    assert!(values.len() >= 4, "{total}");
    for value in values {
        let digits = value.trim_start_matches(['-', '0', '.']);
        let digits = digits.chars().filter(char::is_ascii_digit).count();
        assert!(digits <= 4, "{value} in {total}");
    }
}

/// At the end of the converter's range a reading is a bound: the numbers are there, and not called good.
#[test]
fn saturated_frames_are_told() {
    let folder = Folder::new();
    folder.good(
        "simulate --sensor mat-32x32-adg732 --pattern hand --load-g 9000 --frames 100 -o hand.txt",
    );
    let run = folder.taxel(
        "measure hand.txt --sensor mat-32x32-adg732 --frames-per-second 100 -o f.csv --picture f.svg",
    );
    let told = "of 100 frames hold readings at the end of the converter's range";
    assert!(run.code == Some(3) && run.err.contains(told), "{run}");
    // Nothing bounds the force of the hold: an empty cell.
    let half = folder.column("f.csv", "total_error_n");
    assert!(half[80].is_nan() && half[0].is_finite());
    let picture = folder.read("f.svg");
    assert!(
        picture.contains("at the converter&apos;s end")
            || picture.contains("at the converter's end")
    );
}

/// A column that is out in every third frame makes the force shake: said, and not said where neighbours stand in for it.
#[test]
fn taxels_that_come_and_go_during_a_trial_are_told() {
    let folder = Folder::new();
    let mat = taxel::sensor::preset("mat-32x32-adg732").unwrap();
    let mat = mat.edited(|spec| spec.screen.flickering_columns = vec![16]);
    folder.write("mat.toml", &mat.unwrap().to_toml());
    folder.good("simulate --sensor mat.toml --pattern hand --frames 100 -o hand.txt");
    let measure = "measure hand.txt --sensor mat.toml --frames-per-second 100";
    let run = folder.taxel(measure);
    assert!(
        run.err
            .contains("from 96.9 to 100.0 % of the taxels were measured, from frame to frame"),
        "{run}"
    );
    assert!(run.err.contains("(a line flickers); --repair"), "{run}");
    let told: serde_json::Value =
        serde_json::from_str(&folder.taxel(&format!("{measure} --json")).out).unwrap();
    assert_eq!(told["trials"][0]["changing_share"][0], 0.96875);
    let run = folder.taxel(&format!("{measure} --repair"));
    assert!(!run.err.contains("from frame to frame"), "{run}");
}

/// What lies unloaded reads below nothing as often as above.
#[test]
fn an_unloaded_sensor_has_no_trial_and_breaks_nothing() {
    let folder = Folder::new();
    folder.good(
        "simulate --sensor mat-32x32-adg732 --pattern uniform --load-g 0 --frames 40 -o empty.txt",
    );
    let run = folder.good("measure empty.txt --sensor mat-32x32-adg732 --frames-per-second 100");
    assert!(run.err.contains("no trial"), "{run}");
    folder.write(
        "r.toml",
        "[[region]]\nname = \"corner\"\nboxes = [[0, 0, 0, 1]]\n",
    );
    for trials in ["whole", "0..0.05", "0.1..0.12,0.2..0.3"] {
        folder.good(&format!(
            "measure empty.txt --sensor mat-32x32-adg732 --frames-per-second 100 --trials {trials} --regions r.toml"
        ));
    }
}

#[test]
fn every_format_holds_the_same_numbers() {
    let (folder, _) = gripped("mat-32x32-adg732", 1);
    for name in ["f.csv", "f.json", "f.parquet", "f.xlsx"] {
        folder.good(&format!(
            "measure hand.txt --sensor mat-32x32-adg732 --frames-per-second 50 --threads 2 -o {name} --picture f.png"
        ));
    }
    let csv = folder.column("f.csv", "total_n");
    let json: Vec<serde_json::Value> = serde_json::from_str(&folder.read("f.json")).unwrap();
    assert_eq!(json.len(), 160);
    for (at, (record, value)) in json.iter().zip(&csv).enumerate() {
        assert_eq!(record["total_n"].as_f64(), Some(*value));
        assert_eq!(record["time_s"].as_f64(), Some(at as f64 / 50.0));
        assert!(record["grip_n"].is_null());
    }
    let png = std::fs::read(folder.path("f.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG"));
}

#[test]
fn what_cannot_be_measured_is_said() {
    let (folder, _) = gripped("mat-32x32-adg732", 1);
    let run = folder.taxel("measure hand.txt --sensor mat-32x32-adg732 -o f.csv");
    assert!(
        run.err.contains("tells no times") && run.code == Some(0),
        "{run}"
    );
    assert!(run.err.contains("no grip force"), "{run}");
    assert!(folder.column("f.csv", "time_s").iter().all(|s| s.is_nan()));
    let bad = |words: &str, error: &str| {
        let run = folder.taxel(&format!(
            "measure hand.txt --sensor mat-32x32-adg732 {words}"
        ));
        assert!(run.code != Some(0) && run.err.contains(error), "{run}");
        assert!(run.err.contains("hint") || run.code == Some(2), "{run}");
    };
    bad("--trials 3..1", "must be force, marks, whole");
    bad(
        "--frames-per-second 100 --trials 2..3",
        "goes from 0 s to 1.590 s",
    );
    bad("--frames-per-second 100 --trials marks", "holds no marks");
    bad("--trials 2..3", "tells no times");
    bad(
        "--frames-per-second 100 --trials 0.501..0.505",
        "holds no frame",
    );
    bad("--touched 0", "above 0");
    bad("-o hand.txt", ".csv, .parquet, .xlsx, .json");
}

#[test]
fn regions_that_cannot_be_are_refused_before_any_work() {
    let (folder, _) = gripped("mat-32x32-adg732", 1);
    let bad = |words: &str, error: &str| {
        let run = folder.taxel(&format!(
            "measure hand.txt --sensor mat-32x32-adg732 {words}"
        ));
        assert!(run.code != Some(0) && run.err.contains(error), "{run}");
    };
    folder.write(
        "r.toml",
        "[[region]]\nname = \"heel\"\nboxes = [[0, 40, 0, 1]]\n",
    );
    bad("--regions r.toml", "rows 0 to 31 and columns 0 to 31");
    folder.write("r.toml", "[[regoin]]\nname = \"heel\"\n");
    bad("--regions r.toml", "unknown field `regoin`");
    folder.write(
        "r.toml",
        "[[region]]\nname = \"Total\"\nboxes = [[0, 1, 0, 1]]\n",
    );
    bad(
        "--regions r.toml",
        "the column `total_n`, which is there already",
    );
    folder.write("r.toml", "");
    bad("--regions r.toml", "no region in it");
    let moving = |frames: &str| {
        format!("[[region]]\nname = \"heel\"\nboxes = [[0, 1, 0, 1]]\nframes = {frames}\n")
    };
    let both = format!("{}{}", moving("[0, 9]"), moving("[90000, 90009]"));
    folder.write("r.toml", &both);
    bad(
        "--regions r.toml --frames-per-second 100",
        "is said of frames 90000 to 90009, and hand.txt has",
    );
    bad(
        "--regions r.toml --write-regions s.toml",
        "what `--regions auto` finds",
    );
    folder.good(
        "simulate --sensor mat-32x32-adg732 --pattern uniform --load-g 0 --frames 20 -o hand.txt",
    );
    let run = folder.taxel("measure hand.txt --sensor mat-32x32-adg732 --regions auto");
    assert!(
        run.err.contains("no region is pressed") && run.code == Some(2),
        "{run}"
    );
}
