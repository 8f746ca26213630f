//! `taxel budget`, `design`, `rig` and `crosstalk`.

use serde_json::Value;

use crate::run::{Folder, Run, SENSOR};

fn json(run: &Run) -> Value {
    serde_json::from_str(&run.out).unwrap()
}

fn number(value: &Value, path: &str) -> f64 {
    let found = value.pointer(path).and_then(Value::as_f64);
    found.unwrap_or_else(|| panic!("{path} in {value:#}"))
}

#[test]
fn a_budget_names_every_cause_and_part() {
    let run = Folder::new().good("budget sensor.toml");
    for words in [
        "small: 4 x 6 taxels",
        "== a gripping hand: ",
        "== every taxel under 600 g: 24 loaded taxels, the best 502 Ω ==",
        "column switches",
        "row switches",
        "source resistor",
        "amplifier gain",
        "converter range",
        "converter bits",
        "noise",
        "CD74HC4067 at most, 160 Ω",
        "ADG726, ADG732, 4 Ω",
        "10 bits (Arduino Uno)",
    ] {
        assert!(run.out.contains(words), "{words}: {run}");
    }
    assert!(
        run.out.lines().all(|line| line.chars().count() <= 130),
        "{run}"
    );
    assert_eq!(run.err, "");
}

#[test]
fn a_budgets_numbers_are_those_of_its_definitions() {
    let report = json(&Folder::new().good("budget sensor.toml --json"));
    let worst = report.pointer("/scenes/1").unwrap();
    let mean = |path: &str| number(worst, &format!("{path}/percent/mean"));
    // Six taxels of a row share its 10 Ω, and all of them are pressed.
    let rows = &worst["causes"][1];
    assert_eq!(rows["cause"], "row-switches");
    assert!(mean("/causes/1/alone") > mean("/causes/0/alone"));
    assert!(mean("/causes/1/without") < mean("/raw"));
    assert!(
        number(worst, "/causes/2/alone/percent/worst") < 1e-6,
        "R_v is 0"
    );
    // What the converter leaves is a hundredth of what the switches took.
    assert!(mean("/compensated") < 0.01 * mean("/raw"));
    assert!(number(worst, "/compensated/grams/mean") < 1.0);
    let parts = worst["other_parts"].as_array().unwrap();
    let errors: Vec<f64> = parts
        .iter()
        .filter(|part| part["name"].as_str().unwrap().ends_with("Ω"))
        .map(|part| number(part, "/raw/percent/mean"))
        .collect();
    assert!(errors.is_sorted_by(|a, b| a > b), "{errors:?}");
    let again = Folder::new().good("budget sensor.toml --json");
    assert_eq!(json(&again), report, "the same seed");
}

#[test]
fn a_budget_takes_a_frame_of_a_recording() {
    let folder = Folder::new();
    folder.good("simulate --sensor sensor.toml --pattern blobs --frames 3 -o a.txt");
    let run = folder.good("budget sensor.toml --frame a.txt:2");
    assert!(run.out.contains("== frame 2 of a.txt: "), "{run}");
    assert!(!run.out.contains("gripping"), "{run}");
    let run = folder.fails("budget sensor.toml --frame a.txt:3");
    assert!(
        run.err.contains("frame 3 of a.txt, but it has 3 frames"),
        "{run}"
    );
    let run = folder.fails("budget sensor.toml --frame none.txt");
    assert!(run.err.contains("cannot open none.txt"), "{run}");
}

#[test]
fn a_budget_without_a_load_law_is_in_percent() {
    let folder = Folder::new();
    let (circuit, _) = SENSOR.split_once("[material]").unwrap();
    folder.write("bare.toml", circuit);
    let run = folder.good("budget bare.toml");
    assert!(
        run.out.contains("ghost %") && !run.out.contains("mean g"),
        "{run}"
    );
    assert!(
        run.out.contains("24 loaded taxels, the best 500 Ω"),
        "{run}"
    );
}

#[test]
fn a_budget_refuses_what_is_no_sensor_and_no_number() {
    let folder = Folder::new();
    insta::assert_snapshot!(folder.fails("budget none.toml"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: cannot open none.toml: No such file or directory (os error 2)
    hint: a sensor is a file, or one of the presets econe, mat-16x16-cd4067, mat-32x32-adg732
    ");
    insta::assert_snapshot!(folder.fails("budget sensor.toml --frames-per-second 0"), @r"
    exit code: 2
    ----- stdout -----

    ----- stderr -----
    error: --frames-per-second is 0, but must be a finite number above 0
    hint: 30 frames a second and 600 grams are the defaults
    ");
}

#[test]
fn the_papers_range_gives_the_papers_sensor_which_other_commands_take() {
    let folder = Folder::new();
    let run = folder.good("design --rows 8 --columns 12 -o made.toml");
    assert!(run.out.contains("test voltage           0.4000 V"), "{run}");
    assert!(run.out.contains("feedback resistor R_k  2000 Ω"), "{run}");
    assert!(run.err.contains("wrote made.toml"), "{run}");
    let text = folder.read("made.toml");
    assert!(text.starts_with("# A sensor to begin with"), "{text}");
    folder.good("simulate --sensor made.toml --pattern hand --frames 2 -o a.txt");
    folder.good("info a.txt --sensor made.toml");
    folder.good("compensate a.txt --sensor made.toml -o a.csv");
    let budget = folder.good("budget made.toml");
    assert!(
        budget.out.contains("design 8x12: 8 x 12 taxels"),
        "{budget}"
    );
}

#[test]
fn a_design_says_what_is_wrong_with_the_numbers_given() {
    let folder = Folder::new();
    let of = |words: &str| {
        folder
            .good(&format!("design --rows 8 --columns 8 {words}"))
            .err
    };
    assert_eq!(of("--frames-per-second 1"), "");
    let saturated = of("--frames-per-second 1 --resistor 12k");
    assert!(
        saturated.contains("converter's ceiling from 107 g on"),
        "{saturated}"
    );
    assert!(saturated.contains("2062 Ω at most"), "{saturated}");
    let noisy = folder.good("design --v-test 10mV").err;
    assert!(noisy.contains("warning: noise makes ghosts"), "{noisy}");
    let late = of("--frames-per-second 1e5");
    assert!(
        late.contains("with one taxel pressed a reading settles in"),
        "{late}"
    );
    assert!(
        late.contains("warning: at this scan rate the amplifier's gain is 2"),
        "{late}"
    );
}

/// A mat with open lines and ten bits: undoing the cross-talk makes of noise more than was there.
#[test]
fn a_design_warns_where_compensation_makes_it_worse() {
    let folder = Folder::new();
    let words =
        "design --topology divider-floating --rows 16 --columns 16 --bits 10 --taxel 500..30000";
    let run = folder.good(words);
    assert!(
        run.err.contains("warning: with ") && run.err.contains(" g compensated: "),
        "{run}"
    );
    assert!(
        run.err.contains("hint: ground the unselected lines"),
        "{run}"
    );
    let run = folder.good(&words.replace("divider-floating", "divider-grounded-columns"));
    assert!(!run.err.contains(" g compensated: "), "{run}");
}

#[test]
fn a_designs_json_holds_the_sensor_and_the_definitions_numbers() {
    let run = Folder::new().good("design --rows 8 --columns 8 --switch CD74HC4067 --json");
    let report = json(&run);
    assert_eq!(number(&report, "/r_feedback_ohms"), 2000.0);
    assert_eq!(number(&report, "/sensor/readout/r_mux_row_ohms"), 70.0);
    let available = number(&report, "/timing/available_secs");
    assert!((available - 1.0 / (30.0 * 64.0)).abs() < 1e-12);
    let raw = number(&report, "/ghosts/1/raw/percent/ghost");
    let compensated = number(&report, "/ghosts/1/compensated/percent/ghost");
    assert!(raw > 10.0 * compensated, "{raw} {compensated}");
}

#[test]
fn a_design_refuses_nonsense_and_names_the_nearest_part() {
    let folder = Folder::new();
    insta::assert_snapshot!(folder.fails("design --switch CD74HC4607"), @r"
    exit code: 2
    ----- stdout -----

    ----- stderr -----
    error: invalid value 'CD74HC4607' for '--switch <PART|OHMS>': no switch `CD74HC4607` is known
    hint: did you mean `CD74HC4067`? known: CD4051B, MUX36S16, CD74HC4067, CD74HCT4051, TMUX1308, ADG726, ADG732, ADG706, TMUX1109, ADG839, MCU-PIN; any other by its on-resistance in ohms

    For more information, try '--help'.
    ");
    insta::assert_snapshot!(folder.fails("design --taxel 3000..500"), @r"
    exit code: 2
    ----- stdout -----

    ----- stderr -----
    error: invalid value '3000..500' for '--taxel <MIN..MAX>': from 3000 to 500 Ω
    hint: both above 0, and the smaller first: pressing lowers the resistance

    For more information, try '--help'.
    ");
    insta::assert_snapshot!(folder.fails("design --rows 0 -o made.toml"), @r"
    exit code: 2
    ----- stdout -----

    ----- stderr -----
    error: 0 rows, but a design is computed for 1 to 512
    hint: size a part of the array: its lines are alike
    ");
    assert!(!folder.exists("made.toml"));
    for words in [
        "--bits 33",
        "--switch 0",
        "--switch nan",
        "--gbw -1",
        "--capacitance 300",
        "--headroom 100",
    ] {
        let run = folder.fails(&format!("design {words}"));
        assert_eq!(run.code, Some(2), "{words}: {run}");
    }
}

#[test]
fn the_papers_tables_stand_beside_ours_and_the_misprint_is_named() {
    insta::assert_snapshot!(Folder::new().good("rig --table"), @r"
    exit code: 0
    ----- stdout -----
    Table I: 0.06 N/mm, 1.53 N at most
      tip mm2     paper MPa      ours MPa
            1          1.53          1.53
            2         0.765         0.765
            4        0.3825        0.3825
            8        0.1913        0.1913
    Table II: 0.08 N/mm, 2.57 N at most
      tip mm2     paper MPa      ours MPa
            1          2.57          2.57
            2         1.285         1.285
            4        0.6425        0.6425
            8        0.3213        0.3213
    Table III: 0.09 N/mm, 3.64 N at most
      tip mm2     paper MPa      ours MPa
            1          3.64          3.64
            2          1.82          1.82
            4          0.91          0.91
            8         0.465         0.455  misprint in the paper
    ----- stderr -----
    ");
}

#[test]
fn a_rig_is_compressed_for_a_pressure_or_a_load() {
    let folder = Folder::new();
    insta::assert_snapshot!(folder.good("rig --pressure 200kPa --spring 0.08 --area 4"), @r"
    exit code: 0
    ----- stdout -----
     spring N/mm   tip mm2              load      pressure   compression
            0.08         4    81.6 g 0.800 N    0.2000 MPa       9.79 mm
    ----- stderr -----
    ");
    let all = folder.good("rig --load 132g");
    assert_eq!(all.out.matches("132.0 g 1.294 N").count(), 12, "{all}");
    let heavy = folder.good("rig --load 3N --area 8");
    assert!(
        heavy
            .out
            .contains("more than the paper's mechanism has, 25.2 mm"),
        "{heavy}"
    );
    insta::assert_snapshot!(folder.fails("rig --load 1g --spring 0.06 --area 1"), @r"
    exit code: 2
    ----- stdout -----

    ----- stderr -----
    error: a load of 0.0098 N is less than the moving parts weigh, 0.0167 N
    hint: use lighter parts, or a smaller tip for the same pressure
    ");
    for words in [
        "--load 132",
        "--load",
        "--pressure 2psi",
        "--load 1N --spring 0",
        "",
        "--load 1N --pressure 1MPa",
    ] {
        let run = folder.fails(&format!("rig {words}"));
        assert_eq!(run.code, Some(2), "{words}: {run}");
    }
}

#[test]
fn the_number_of_experiments_follows_from_what_is_wanted() {
    let folder = Folder::new();
    insta::assert_snapshot!(folder.good("rig --confidence 95 --margin 5g --spread 12g --shares 22,5"), @r"
    exit code: 0
    ----- stdout -----
    25 experiments: repetitions that scatter by 12 g give a mean within 5 g, 95 % sure
    63 readings of each sensor: shares of 22 % and 5 % are told apart, 95 % sure, 80 times in 100
    ----- stderr -----
    ");
    let report = json(&folder.good("rig --margin 5g --spread 12g --confidence 99 --json"));
    assert!(number(&report, "/experiments/count") > 25.0);
    for words in [
        "--margin 5g",
        "--margin 0 --spread 1",
        "--margin 1 --spread 1 --confidence 100",
        "--shares 5,5",
        "--shares 5",
    ] {
        let run = folder.fails(&format!("rig {words}"));
        assert_eq!(run.code, Some(2), "{words}: {run}");
    }
}

#[test]
fn cross_talk_is_printed_by_the_equation_and_by_the_circuit() {
    let folder = Folder::new();
    insta::assert_snapshot!(folder.good("crosstalk -n 2"), @"
    exit code: 0
    ----- stdout -----
    |V_out| in volts, by the paper's equation 6 and by the whole circuit of each setting; N other taxels of the row are pressed
      1: Table V, no switches
      2: Table V, switches of 10 Ω
         N    1: eq. 6  1: circuit    2: eq. 6  2: circuit
         0     0.80000     0.79998     0.80000     0.78429
         1     0.79998     0.79996     0.79998     0.77666
         2     0.79997     0.79994     0.79997     0.76918
    ----- stderr -----
    ");
}

#[test]
fn cross_talk_is_drawn_with_what_was_measured() {
    let folder = Folder::new();
    folder.write("p.csv", "n,value,replicate\n0,0.78,1\n0,0.80,2\n3,0.7,1\n");
    let run =
        folder.good("crosstalk --points p.csv --setting R_mux=10,name=mine -n 4 -o a.svg --csv");
    insta::assert_snapshot!(run, @"
    exit code: 0
    ----- stdout -----
    n,equation_1_volts,circuit_1_volts,measured_volts,interval_95_half_volts
    0,0.800000,0.784291,0.790000,0.127062
    1,0.799984,0.776661,,
    2,0.799968,0.769179,,
    3,0.799952,0.761839,0.700000,
    4,0.799936,0.754638,,
    ----- stderr -----
    wrote a.svg
    ");
    let svg = folder.read("a.svg");
    assert!(svg.contains(">mine<") && svg.contains(">measured, 95 %<"));
    assert!(svg.contains("stroke-dasharray"));
    let counts = folder.good("crosstalk --points p.csv --volts-per-count 2 -n 0 --csv");
    assert!(counts.out.contains("1.580000"), "{counts}");
}

#[test]
fn cross_talk_refuses_nonsense() {
    let folder = Folder::new();
    folder.write("bad.csv", "n,value\n0,0.7\n1,high\n");
    folder.write("empty.csv", "n,value\n");
    insta::assert_snapshot!(folder.fails("crosstalk --points bad.csv"), @r"
    exit code: 2
    ----- stdout -----

    ----- stderr -----
    error: bad.csv, line 3: `1,high` is no point
    hint: a line is n,value: the number of other pressed taxels, 0 or more, and what was read
    ");
    let run = folder.fails("crosstalk --points none.csv");
    assert!(
        run.err.contains("cannot open none.csv") && run.code == Some(1),
        "{run}"
    );
    let run = folder.fails("crosstalk --setting r_k=5");
    assert!(run.err.contains("did you mean `R_k`?"), "{run}");
    for words in ["--points empty.csv", "-o a.jpg", "--setting A=0", "-n 5000"] {
        folder.fails(&format!("crosstalk {words}"));
    }
    let five = "--setting A=10 --setting A=20 --setting A=30 --setting A=40 --setting A=50";
    let run = folder.fails(&format!("crosstalk {five}"));
    assert!(run.err.contains("5 settings, but at most 4"), "{run}");
    assert!(!folder.exists("a.jpg"));
}

#[test]
fn a_design_keeps_the_wiring_of_a_sensor_file() {
    let folder = Folder::new();
    let table =
        include_str!("../../../../testdata/ngspice/line-ends-12x5-shift-register/sensor.toml");
    folder.write("shift.toml", table);
    let run = folder.good("design --sensor shift.toml --taxel 1k..30k -o sized.toml");
    for words in [
        "12 x 5 taxels of 1000 to 30000 Ω, line-ends",
        "as the table of line ends says",
        "of the table; 5477 Ω computed",
        "wrote sized.toml",
    ] {
        assert!(
            (run.out.clone() + &run.err).contains(words),
            "{words}: {run}"
        );
    }
    // What was written is a sensor that can be simulated, with the same line ends.
    folder.good("simulate --sensor sized.toml --pattern fingers --frames 2 -o s.npy");
    let ends = |text: &str| {
        let file: toml::Table = text.parse().unwrap();
        file["readout"]["driven"].clone()
    };
    assert_eq!(ends(&folder.read("sized.toml")), ends(table));
    let run = folder.fails("design --sensor shift.toml --resistor 1k");
    assert!(
        run.err.contains("table of line ends, which has its own"),
        "{run}"
    );
    let run = folder.fails("design --sensor shift.toml --rows 5");
    assert!(run.err.contains("cannot be used with"), "{run}");
    let run = folder.fails("design --sensor nobody");
    assert!(run.err.contains("known: econe"), "{run}");
}

#[test]
fn a_design_takes_lines_that_resist_and_diodes() {
    let folder = Folder::new();
    let run = folder.good("design --rows 32 --columns 32 --line-ohms 20 --json");
    let report = json(&run);
    let along = number(&report, "/line_reach/0/attenuation");
    assert!((along - 20.0 / 500.0 * 1024.0).abs() < 1e-9, "{along}");
    assert!(
        run.err.contains("the far end of a row cannot be read"),
        "{run}"
    );
    let run =
        folder.good("design --rows 16 --columns 16 --line-ohms 0.05,0 --diode 1n4148 -o d.toml");
    assert!(
        run.out.contains("in each taxel 1N4148") && run.out.contains("and a diode"),
        "{run}"
    );
    let written = folder.read("d.toml");
    assert!(written.contains("r_line_row_ohms = 0.05") && written.contains("part = \"1N4148\""));
    assert!(!written.contains("r_line_column_ohms"), "{written}");
    for (words, says) in [
        ("--diode 1N9999", "no diode `1N9999` is known"),
        ("--line-ohms=-1", "-1 Ω from one taxel to the next"),
        ("--line-ohms 1,2,3", "3 resistances with --line-ohms"),
        ("--line-ohms nan", "number"),
    ] {
        let run = folder.fails(&format!("design --rows 8 --columns 8 {words}"));
        assert!(run.err.contains(says), "{words}: {run}");
    }
}
