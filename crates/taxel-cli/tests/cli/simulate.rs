//! `taxel simulate`.

use crate::run::Folder;

/// Two frames of conductances of a 4 × 6 array, siemens.
pub const CONDUCTANCES: &str = "\
1e-6,1e-6,1e-6,1e-6,1e-6,1e-6
1e-6,0.001,1e-6,1e-6,1e-6,1e-6
1e-6,1e-6,1e-6,1e-6,0.0005,1e-6
1e-6,1e-6,1e-6,1e-6,1e-6,1e-6
0.0003,1e-6,1e-6,0.0003,1e-6,1e-6
1e-6,1e-6,1e-6,1e-6,1e-6,1e-6
0.0003,1e-6,1e-6,1e-6,1e-6,1e-6
1e-6,1e-6,1e-6,1e-6,1e-6,1e-6
";

#[test]
fn conductances_are_scanned_and_volts_become_the_same_conductances_again() {
    let folder = Folder::new();
    folder.write("g.csv", CONDUCTANCES);
    let run =
        folder.taxel("simulate --sensor sensor.toml --conductance g.csv --unit volts -o volts.csv");
    insta::assert_snapshot!(run, @r"
    exit code: 0
    ----- stdout -----

    ----- stderr -----
    2 frames scanned, in volts.csv
    ");
    let volts = folder.numbers("volts.csv");
    assert_eq!(volts.len(), 48);
    assert!(volts.iter().all(|&v| v < 0.0), "an inverting amplifier");
    // R_k · G of the pressed taxel, less what the switches take.
    assert!((volts[7] / (-0.4 * 2000.0 * 1e-3) - 1.0).abs() < 0.03);
    folder.good(
        "compensate volts.csv --input-unit volts --sensor sensor.toml --unit siemens -o again.csv",
    );
    let (given, again) = (folder.numbers("g.csv"), folder.numbers("again.csv"));
    for (given, again) in given.iter().zip(&again) {
        assert!((given - again).abs() < 1e-8 * 1e-3, "{given} {again}");
    }
}

#[test]
fn arrays_and_text_hold_the_same_numbers() {
    let folder = Folder::new();
    folder.write("g.csv", CONDUCTANCES);
    for name in ["v.npy", "v.npz", "v.csv"] {
        folder.good(&format!(
            "simulate --sensor sensor.toml --conductance g.csv -o {name}"
        ));
        folder.good(&format!(
            "compensate {name} --input-unit volts --sensor sensor.toml --unit siemens -o {name}.csv"
        ));
    }
    assert_eq!(folder.read("v.npy.csv"), folder.read("v.csv.csv"));
    assert_eq!(folder.read("v.npz.csv"), folder.read("v.csv.csv"));
}

#[test]
fn without_a_file_the_numbers_go_to_standard_output() {
    let folder = Folder::new();
    folder.write("g.csv", CONDUCTANCES);
    let run = folder.taxel("simulate --sensor sensor.toml --conductance g.csv --unit counts");
    insta::assert_snapshot!(run, @r"
    exit code: 0
    ----- stdout -----
    24,24,24,24,24,24,
    24,23361,24,24,24,24,
    24,24,24,24,11796,24,
    24,24,24,24,24,24,
    7085,24,24,7085,24,24,
    24,24,24,24,24,24,
    7095,24,24,34,24,24,
    24,24,24,24,24,24,
    ----- stderr -----
    ");
}

#[test]
fn every_topology_is_scanned_and_inverted() {
    let folder = Folder::new();
    folder.write("g.csv", CONDUCTANCES);
    for (topology, end) in [
        ("tia-zero-potential", ""),
        ("divider-grounded-columns", "r_pull_down_ohms = 1000.0\n"),
        ("divider-floating", "r_pull_down_ohms = 1000.0\n"),
        ("divider-voltage-feedback", "r_pull_down_ohms = 1000.0\n"),
    ] {
        let sensor = crate::run::SENSOR
            .replace("tia-grounded-columns", topology)
            .replace(
                "r_mux_row_ohms = 10.0\n",
                &format!("r_mux_row_ohms = 10.0\n{end}"),
            );
        folder.write("other.toml", &sensor);
        folder.good("simulate --sensor other.toml --conductance g.csv -o v.csv");
        folder.good(
            "compensate v.csv --input-unit volts --sensor other.toml --unit siemens -o again.csv",
        );
        let (given, again) = (folder.numbers("g.csv"), folder.numbers("again.csv"));
        for (given, again) in given.iter().zip(&again) {
            assert!(
                (given - again).abs() < 1e-6 * 1e-3,
                "{topology}: {given} {again}"
            );
        }
    }
}

#[test]
fn a_pattern_is_the_same_for_the_same_seed() {
    let folder = Folder::new();
    let simulate = "simulate --sensor sensor.toml --pattern blobs --frames 3 --seed";
    let run = folder.taxel(&format!("{simulate} 5 -o a.txt --truth a.csv"));
    insta::assert_snapshot!(run, @r"
    exit code: 0
    ----- stdout -----

    ----- stderr -----
    3 frames simulated, in a.txt
    ");
    folder.good(&format!("{simulate} 5 -o b.txt --truth b.csv"));
    folder.good(&format!("{simulate} 6 -o c.txt"));
    assert_eq!(folder.read("a.txt"), folder.read("b.txt"));
    assert_eq!(folder.read("a.csv"), folder.read("b.csv"));
    assert_ne!(folder.read("a.txt"), folder.read("c.txt"));
    assert_eq!(folder.numbers("a.csv").len(), 3 * 24);
}

#[test]
fn uniform_levels_share_the_frames_and_are_labelled() {
    let folder = Folder::new();
    folder.good(
        "simulate --sensor sensor.toml --pattern uniform --frames 4 --load-g 50,150 \
         -o u.txt --presses equilibration.csv --imperfect uneven --truth-sensor truth.toml",
    );
    insta::assert_snapshot!(folder.read("equilibration.csv"), @r"
    recording,frame,load_g
    u.txt,0,50
    u.txt,1,50
    u.txt,2,150
    u.txt,3,150
    ");
    assert!(folder.read("truth.toml").contains("r_mux_row_ohms = ["));
}

#[test]
fn what_belongs_to_a_pattern_does_not_go_with_conductances() {
    let folder = Folder::new();
    let run = folder.taxel("simulate --sensor sensor.toml --conductance g.csv --frames 3");
    assert_eq!(run.code, Some(2), "{run}");
    let run = folder.taxel("simulate --sensor sensor.toml");
    assert_eq!(run.code, Some(2), "{run}");
    // An empty array, as the self-test wants it.
    folder.good(
        "simulate --sensor sensor.toml --pattern uniform --load-g 0 --frames 3 -o empty.txt --truth none.csv",
    );
    assert!(folder.numbers("none.csv").iter().all(|&load| load == 0.0));
    let run = folder.taxel("simulate --sensor sensor.toml --pattern hand --load-g -5");
    assert_eq!(run.code, Some(2), "{run}");
}

#[test]
fn conductances_of_an_active_network_are_refused_with_their_frame() {
    let folder = Folder::new();
    folder.write("g.csv", &CONDUCTANCES.replace("0.0005", "-90"));
    let run = folder.taxel("simulate --sensor sensor.toml --conductance g.csv -o v.csv");
    insta::assert_snapshot!(run, @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: g.csv, frame 0: these conductances make the network active: no scan exists
    hint: conductances must not be negative
    ");
    assert!(!folder.exists("v.csv"));
}

/// Held loads creep, what is gone is still read; the sensor that was drawn knows it, and its law undoes it.
#[test]
fn a_material_that_creeps_is_drawn_and_undone() {
    let folder = Folder::new();
    let drawn = "--imperfect creep --pattern fingers --frames 6 --period 1 --seed 3";
    folder.good(&format!(
        "simulate --sensor mat-32x32-adg732 {drawn} --truth t.csv --truth-sensor true.toml -o c.csv"
    ));
    folder.good("compensate c.csv --sensor true.toml --unit g -o l.csv");
    folder.good("compensate c.csv --sensor mat-32x32-adg732 --unit g -o s.csv");
    let truth = folder.numbers("t.csv");
    let error = |name: &str| {
        let found = folder.numbers(name);
        let loaded = truth.iter().zip(found).filter(|(load, _)| **load > 20.0);
        loaded
            .map(|(load, found)| (found / load - 1.0).abs())
            .fold(0.0, f64::max)
    };
    assert!(
        error("l.csv") < 0.1 && error("s.csv") > 0.1,
        "{} {}",
        error("l.csv"),
        error("s.csv")
    );
}

#[test]
fn so_many_readings_stand_at_an_end() {
    let folder = Folder::new();
    let words =
        "simulate --sensor mat-32x32-adg732 --pattern blobs --load-g 100 --frames 20 --seed 5";
    folder.good(&format!("{words} --stuck 1% -o stuck.csv"));
    let counts = folder.numbers("stuck.csv");
    let at_end = counts
        .iter()
        .filter(|&&count| count == 0.0 || count == 4095.0)
        .count();
    let share = at_end as f64 / counts.len() as f64;
    // 205 of 20,480 expected, a standard deviation of 14.
    assert!((0.007..0.013).contains(&share), "{share}");
    let run = folder.fails(&format!("{words} --stuck 70% -o never.csv"));
    assert!(run.err.contains("a share from 0 to below a half"), "{run}");
}
