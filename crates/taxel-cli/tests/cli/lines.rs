//! Lines that resist and diodes that cannot be, through the real command line: each is refused in words before anything is written.

use crate::run::{Folder, SENSOR};

const FRAME: &str = "1e-3,2e-3,1e-6,1e-6,5e-4,1e-6\n1e-6,1e-3,1e-3,1e-6,1e-6,1e-6\n\
    1e-6,1e-6,1e-6,1e-6,1e-6,1e-6\n2e-3,2e-3,2e-3,1e-6,1e-6,1e-3\n";

/// Has a sensor file refused: with these lines under `[readout]`, and others in place of some of its own.
fn is_refused(added: &str, replaced: &[(&str, &str)], words: &[&str]) {
    let mut file = SENSOR.replace("\n[converter]", &format!("{added}\n\n[converter]"));
    for (from, to) in replaced {
        assert!(file.contains(from), "{from} in {file}");
        file = file.replace(from, to);
    }
    let folder = Folder::new();
    folder.write("bad.toml", &file);
    folder.write("g.csv", FRAME);
    let run = folder.taxel("simulate --sensor bad.toml --conductance g.csv -o v.csv");
    assert_eq!(run.code, Some(1), "{added}\n{run}");
    assert!(run.err.starts_with("error: bad.toml: "), "{run}");
    assert!(run.err.contains("\nhint: "), "{run}");
    for word in words {
        assert!(run.err.contains(word), "{word} for {added}\n{run}");
    }
    assert!(!folder.exists("v.csv"), "{added}");
}

#[test]
fn resistances_along_lines_that_cannot_be() {
    for key in ["r_line_row_ohms", "r_line_column_ohms"] {
        let name = format!("`readout.{key}` is ");
        for (ohms, said) in [
            ("-2.0", "-2"),
            ("nan", "NaN"),
            ("inf", "inf"),
            ("2e6", "2000000"),
        ] {
            let words = [name.as_str(), said, "0 to 1e6 Ohm a pitch"];
            is_refused(&format!("{key} = {ohms}"), &[], &words);
        }
    }
    is_refused(
        "r_line_row_ohms = [1.0, 2.0, -3.0, 4.0]",
        &[],
        &["`readout.r_line_row_ohms[2]` is -3"],
    );
}

#[test]
fn lists_of_lines_of_the_wrong_length() {
    for (key, list, words) in [
        (
            "r_line_row_ohms",
            "[1.0, 2.0]",
            "has 2 numbers, but the array has 4 rows",
        ),
        (
            "r_line_column_ohms",
            "[1.0, 2.0, 3.0, 4.0]",
            "has 4 numbers, but the array has 6 columns",
        ),
    ] {
        is_refused(&format!("{key} = {list}"), &[], &[key, words]);
    }
}

#[test]
fn ends_of_lines_that_are_misspelt() {
    for key in ["row_end", "column_end"] {
        let name = format!("`readout.{key}` is `lats`");
        is_refused(
            &format!("r_line_row_ohms = 2.0\n{key} = \"lats\""),
            &[],
            &[&name, "did you mean `last`?"],
        );
    }
}

/// Behind the small sensor's read-out, as a table whose unselected columns lead to `end`.
fn table(end: &str) -> [(&'static str, String); 2] {
    let ends = format!(
        "topology = \"line-ends\"\nreads = \"voltage\"\n\
         driven.selected = {{ to = \"v_test\", ohms = 10.0 }}\n\
         driven.unselected = [{{ to = \"{end}\", ohms = 10.0 }}, {{ to = \"ground\", ohms = 1000.0 }}]\n\
         sensed.selected = {{ to = \"ground\", ohms = 1000.0 }}"
    );
    [
        ("topology = \"tia-grounded-columns\"", ends),
        (
            "r_feedback_ohms = 2000.0\nopen_loop_gain = 1e5\nr_mux_column_ohms = 10.0\nr_mux_row_ohms = 10.0\n",
            String::new(),
        ),
    ]
}

fn is_table_refused(end: &str, added: &str, words: &[&str]) {
    let replaced = table(end);
    let replaced: Vec<(&str, &str)> = replaced
        .iter()
        .map(|(from, to)| (*from, to.as_str()))
        .collect();
    is_refused(added, &replaced, words);
}

#[test]
fn lines_that_resist_beside_ends_that_nobody_has_worked_out() {
    for end in ["v_test", "follower"] {
        is_table_refused(
            end,
            "r_line_row_ohms = 2.0",
            &["r_line_row_ohms, r_line_column_ohms", "V_t"],
        );
    }
}

#[test]
fn diodes_that_cannot_be() {
    let diode = |numbers: &str| format!("\n[readout.diode]\nplace = \"taxel\"\n{numbers}");
    for (numbers, words) in [
        (
            "saturation_amperes = 0.0\nemission = 1.7",
            "`readout.diode.saturation_amperes` is 0, but must be above 0",
        ),
        (
            "saturation_amperes = -1e-9\nemission = 1.7",
            "`readout.diode.saturation_amperes` is -1e-9, but must be above 0",
        ),
        (
            "saturation_amperes = nan\nemission = 1.7",
            "`readout.diode.saturation_amperes` is NaN",
        ),
        (
            "saturation_amperes = 1e-9\nemission = 0.4",
            "`readout.diode.emission` is 0.4, but must be 0.5 to 3",
        ),
        (
            "saturation_amperes = 1e-9\nemission = 3.1",
            "`readout.diode.emission` is 3.1, but must be 0.5 to 3",
        ),
        (
            "part = \"1N4148\"\ntemperature_celsius = 300.15",
            "this looks like kelvin: take 273.15 off",
        ),
        (
            "part = \"1N4148\"\ntemperature_celsius = -273.15",
            "-60 to 150",
        ),
    ] {
        is_refused(&diode(numbers), &[], &[words]);
    }
}

#[test]
fn diodes_in_a_read_out_that_has_no_one_direction() {
    is_table_refused(
        "v_test",
        "\n[readout.diode]\nplace = \"taxel\"\npart = \"1N4148\"",
        &[
            "`readout.diode.place` is \"taxel\"",
            "current has no one direction",
        ],
    );
    is_refused(
        "\n[readout.diode]\nplace = \"driven-line\"\npart = \"1N4148\"",
        &[],
        &[
            "`readout.diode.place` is \"driven-line\"",
            "divider-pulled-rows",
        ],
    );
}

/// Lines so resistive that the far corner vanishes are no error: it is marked, and what is near the ends comes out.
#[test]
fn far_taxels_that_vanish_are_marked_and_near_ones_come_out() {
    let folder = Folder::new();
    let lines =
        "r_line_row_ohms = 2000.0\nr_line_column_ohms = 2000.0\n\n[converter]\nnoise_counts = 3.0";
    let file = SENSOR
        .replace("rows = 4\ncolumns = 6", "rows = 12\ncolumns = 12")
        .replace("\n[converter]", lines);
    folder.write("textile.toml", &file);
    let row = ["1e-3"; 12].join(",") + "\n";
    folder.write("g.csv", &row.repeat(12));
    folder.good("simulate --sensor textile.toml --conductance g.csv -o v.csv");
    let run = folder.taxel(
        "compensate v.csv --input-unit volts --sensor textile.toml --unit siemens -o out.csv --standard-error e.csv --marks m.csv",
    );
    assert_eq!(run.code, Some(0), "{run}");
    let (found, marks) = (folder.numbers("out.csv"), folder.numbers("m.csv"));
    assert!((found[0] / 1e-3 - 1.0).abs() < 0.01, "{}", found[0]);
    const UNRESOLVED: f64 = 8.0;
    assert_eq!((marks[0], marks[143]), (0.0, UNRESOLVED));
}
