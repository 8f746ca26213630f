//! `taxel dataset`, `train`, `compare`, `model`: labelled presses in, models and an honest table out.

use crate::calibrate::pressed;

const TRAIN: &str =
    "train row-set --sensor sensor.toml --presses experiments.csv --epochs 40 --members 2";

#[test]
fn a_table_is_the_papers_and_reads_back_the_same() {
    let folder = pressed(12);
    folder.good("dataset --sensor sensor.toml --presses experiments.csv -o rows.csv");
    let text = folder.read("rows.csv");
    assert_eq!(text.lines().count(), 12);
    let columns = folder.numbers("calibration.txt").len() / 12;
    assert!(text.lines().all(|line| line.split(',').count() < columns));
    folder.good("dataset --sensor sensor.toml --rows rows.csv -o again.csv");
    assert_eq!(folder.read("again.csv"), text);
}

#[test]
fn simulated_shards_do_not_depend_on_their_size() {
    let folder = pressed(8);
    folder.good("dataset --sensor sensor.toml --simulate 7 --shard 3 --seed 5 -o three");
    folder.good("dataset --sensor sensor.toml --simulate 7 --shard 7 --seed 5 -o one");
    folder.good("dataset --sensor sensor.toml --simulate 7 --shard 3 --seed 5 -o again");
    for shard in ["00000", "00001", "00002"] {
        let name = format!("shard-{shard}.npz");
        let file = |set: &str| std::fs::read(folder.path(&format!("{set}/{name}"))).unwrap();
        assert_eq!(file("three"), file("again"), "{name}");
    }
    assert!(folder.path("one/shard-00000.npz").exists());
    assert!(!folder.path("one/shard-00001.npz").exists());
}

#[test]
fn a_model_is_trained_the_same_by_seed_and_compensates() {
    let folder = pressed(60);
    let run = folder.good(&format!("{TRAIN} -o model.safetensors"));
    assert!(run.out.contains("held-out presses (9)"), "{run}");
    assert!(run.out.contains("not for: "), "{run}");
    folder.good(&format!("{TRAIN} -o same.safetensors"));
    folder.good(&format!("{TRAIN} --seed 2 -o other.safetensors"));
    let bytes = |name: &str| std::fs::read(folder.path(name)).unwrap();
    assert_eq!(bytes("model.safetensors"), bytes("same.safetensors"));
    assert_ne!(bytes("model.safetensors"), bytes("other.safetensors"));
    // The parts list alone is enough: no switches, no material.
    let run = folder.good(
        "compensate calibration.txt --sensor parts.toml --method model.safetensors -o loads.csv",
    );
    assert!(run.err.contains("method row-set"), "{run}");
    let loads = folder.numbers("loads.csv");
    assert!(loads.iter().any(|&load| load > 10.0));
    assert!(loads.iter().all(|&load| load >= 0.0));
    let card = folder.good("model show model.safetensors").out;
    assert!(card.contains("\"kind\": \"row-set\""), "{card}");
}

#[test]
fn the_papers_network_goes_on_from_its_checkpoint_and_out_as_onnx() {
    let folder = pressed(30);
    let train = "train paper-mlp --sensor sensor.toml --presses experiments.csv --copies 3";
    folder.good(&format!("{train} --epochs 4 -o model.safetensors"));
    folder.good("model export model.safetensors -o model.onnx");
    let run = folder.fails("model export model.safetensors -o model.safetensors");
    assert_eq!(run.code, Some(2), "{run}");
    let run = folder.fails("model export model.safetensors -o other.safetensors");
    assert!(run.err.contains(".onnx"), "{run}");
    folder.good("model show model.safetensors");
    let run = folder.good(
        "model import model.onnx --sensor sensor.toml --presses experiments.csv -o back.safetensors",
    );
    assert!(run.out.contains("mean absolute error"), "{run}");
    for model in ["model", "back"] {
        folder.good(&format!(
            "compensate calibration.txt --sensor sensor.toml --method {model}.safetensors -o {model}.csv"
        ));
    }
    let (ours, back) = (folder.numbers("model.csv"), folder.numbers("back.csv"));
    let both = ours
        .iter()
        .zip(&back)
        .filter(|(a, b)| **a > 1.0 && **b > 1.0);
    assert!(both.clone().count() > 10);
    for (a, b) in both {
        assert!((a - b).abs() < 1e-3 * a.max(1.0), "{a} {b}");
    }
    let run = folder.fails(&format!("{train} --epochs 4 --resume -o none.safetensors"));
    assert!(run.err.contains("none.safetensors.checkpoint"), "{run}");
}

#[test]
fn ways_are_compared_on_presses_that_none_has_seen() {
    let folder = pressed(60);
    folder.good(
        "simulate --sensor sensor.toml --pattern blobs --frames 3 --seed 9 --load-g 300 \
         -o validation.txt --truth truth.csv",
    );
    let run = folder.good(
        "compare validation.txt --truth truth.csv --sensor parts.toml --presses experiments.csv \
         --epochs 2 --copies 2 --without row-set -o table.csv --figure figure.svg",
    );
    for name in ["none", "one curve", "paper-mlp", "exact", "hybrid"] {
        assert!(run.out.lines().any(|line| line.starts_with(name)), "{run}");
    }
    assert!(run.out.contains("judged on 12 held-out presses"), "{run}");
    let table = folder.read("table.csv");
    let error = |name: &str| -> f64 {
        let line = table.lines().find(|line| line.starts_with(name)).unwrap();
        line.split(',').nth(3).unwrap().parse().unwrap()
    };
    assert!(error("exact") < 0.2 * error("one curve"), "{table}");
    assert!(folder.read("figure.svg").contains("Error against load"));
    let run = folder.good(
        "compare --sensor parts.toml --presses experiments.csv --most-presses 12,40 \
         --without row-set,paper-mlp,hybrid --figure curve.svg",
    );
    assert_eq!(
        run.out.lines().filter(|l| l.starts_with("exact")).count(),
        2,
        "{run}"
    );
    assert!(folder.read("curve.svg").contains("Learning curve"));
    let run = folder.fails("compare validation.txt --sensor parts.toml --presses experiments.csv");
    assert!(
        run.err.contains("1 recordings, but 0 files of --truth"),
        "{run}"
    );
}

#[test]
fn what_cannot_be_learnt_from_is_refused() {
    let folder = pressed(12);
    let broken: [(&str, String, &str); 5] = [
        (
            "few",
            row(7.0, 50.0).repeat(3),
            "3 labelled presses, but a training needs at least 8",
        ),
        (
            "same",
            row(7.0, 50.0).repeat(9),
            "the taxel's reading is 7 in every press",
        ),
        (
            "nan",
            (0..9).map(|i| row(f64::from(i), f64::NAN)).collect(),
            "press 0: the load is NaN",
        ),
        (
            "heavy",
            (0..9).map(|i| row(f64::from(i), 20_000.0)).collect(),
            "press 0: a load of 20000 g, beyond the 10000 g",
        ),
        (
            "short",
            "1,2,3\n".to_owned(),
            "line 1: 3 cells, expected 18",
        ),
    ];
    for (name, text, reason) in broken {
        folder.write(&format!("{name}.csv"), &text);
        let run = folder.fails(&format!(
            "train row-set --sensor mat-16x16-cd4067 --rows {name}.csv -o model.safetensors"
        ));
        assert!(run.err.contains(reason), "{name}: {run}");
        assert!(run.err.contains(&format!("{name}.csv")), "{name}: {run}");
    }
    assert!(!folder.path("model.safetensors").exists());
    folder.write("model.safetensors", "no model at all");
    let run = folder.fails(
        "compensate calibration.txt --sensor sensor.toml --method model.safetensors -o loads.csv",
    );
    assert!(run.err.contains("not a safetensors file"), "{run}");
    let run = folder.fails("train hybrid --sensor sensor.toml --rows few.csv -o m.safetensors");
    assert!(
        run.err.contains("few.csv: line 1") || run.err.contains("few.csv, line 1"),
        "{run}"
    );
}

/// What would need more memory than there is, or leaves nothing to learn from, is a message and no crash.
#[test]
fn more_than_a_machine_holds_is_refused() {
    let folder = pressed(12);
    let train = "train paper-mlp --sensor sensor.toml --presses experiments.csv -o m.safetensors";
    for (option, reason) in [
        ("--copies 100000000", "100000000 is not in 1..=100000"),
        ("--members 1000000000", "1000000000 is not in 1..=100"),
        ("--epochs 0", "0 is not in 1..=1000000"),
        (
            "--check-share 0.5 --test-share 0.5",
            "leaves 0 to learn from and 6 to stop by",
        ),
    ] {
        let run = folder.fails(&format!("{train} {option}"));
        assert!(run.err.contains(reason), "{run}");
    }
    for (option, reason) in [
        ("--most-presses 0", "0 is not in 8.."),
        ("--copies 0", "0 is not in 1..=100000"),
    ] {
        let run = folder.fails(&format!(
            "compare --sensor parts.toml --presses experiments.csv {option}"
        ));
        assert!(run.err.contains(reason), "{run}");
    }
    let many: String = (0..100_000)
        .map(|i| row(f64::from(i % 900), 50.0 + f64::from(i % 7)))
        .collect();
    folder.write("many.csv", &many);
    let run = folder.fails(
        "train paper-mlp --sensor mat-16x16-cd4067 --rows many.csv --copies 100000 -o m.safetensors",
    );
    assert!(
        run.err
            .contains("70000 presses x 100000 copies x 18 numbers"),
        "{run}"
    );
    assert!(run.err.contains("2048 MiB is the most"), "{run}");
    assert!(!folder.exists("m.safetensors"));
}

/// Every network says so in its card: not for another sensor.
#[test]
fn a_network_of_another_sensor_is_not_used() {
    let folder = pressed(30);
    folder.good(&format!("{TRAIN} -o model.safetensors"));
    let parts = folder.read("parts.toml");
    let other = parts.replace("v_test_volts = 0.4", "v_test_volts = 0.8");
    assert_ne!(parts, other);
    folder.write("other.toml", &other);
    let run = folder.fails(
        "compensate calibration.txt --sensor other.toml --method model.safetensors -o loads.csv",
    );
    assert!(
        run.err
            .contains("readout.v_test_volts is 0.4 there and 0.8 here"),
        "{run}"
    );
    assert!(!folder.exists("loads.csv"));
}

#[test]
fn files_that_are_no_models_are_refused_and_so_are_files_too_large_for_one() {
    let folder = pressed(12);
    let long = std::fs::File::create(folder.path("long.safetensors")).unwrap();
    long.set_len(1 << 33).unwrap();
    drop(long);
    let run = folder.fails("model show long.safetensors");
    assert!(run.err.contains("more than the 32 MiB"), "{run}");
    let run = folder.fails(
        "model import long.safetensors --sensor sensor.toml --presses experiments.csv -o m.safetensors",
    );
    assert!(run.err.contains("more than the 32 MiB"), "{run}");
    // A header that says that it is longer than memory.
    let mut lying = u64::MAX.to_le_bytes().to_vec();
    lying.extend(b"{}");
    std::fs::write(folder.path("lying.safetensors"), lying).unwrap();
    let run = folder.fails("model show lying.safetensors");
    assert!(
        run.err.contains("a header of 18446744073709551615 bytes"),
        "{run}"
    );
}

/// Networks that learnt for a moment do not stand in a table beside ways that were finished.
#[cfg(unix)]
#[test]
fn ctrl_c_ends_a_comparison_without_a_table() {
    use std::io::{BufRead, BufReader, Read};
    use std::process::{Command, Stdio};

    let folder = pressed(40);
    let mut child = Command::new(env!("CARGO_BIN_EXE_taxel"))
        .args(
            "compare --sensor parts.toml --presses experiments.csv --epochs 1000000 --without exact,hybrid -o t.csv"
                .split(' '),
        )
        .current_dir(folder.path(""))
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut err = BufReader::new(child.stderr.take().unwrap());
    let mut said = String::new();
    while !said.contains("learning from") {
        assert!(err.read_line(&mut said).unwrap() > 0, "it ended: {said}");
    }
    let pid = child.id().to_string();
    let sent = Command::new("kill").args(["-INT", &pid]).status().unwrap();
    assert!(sent.success());
    err.read_to_string(&mut said).unwrap();
    let run = child.wait_with_output().unwrap();
    assert_eq!(run.status.code(), Some(3), "{said}");
    assert!(said.contains("stopped by Ctrl-C"), "{said}");
    assert!(
        run.stdout.is_empty(),
        "{}",
        String::from_utf8_lossy(&run.stdout)
    );
    assert!(!folder.exists("t.csv"));
}

/// A line of the paper's table for 16 columns.
fn row(taxel: f64, load: f64) -> String {
    format!("{taxel}{},{load}\n", ",30".repeat(16))
}
