//! Tables that are refused, and the words.

use crate::sensor::Sensor;

const TABLE: &str = "[readout]
topology = \"line-ends\"
reads = \"voltage\"
v_test_volts = 5.0
driven.selected = { to = \"v_test\", ohms = 45.0 }
driven.unselected = { to = \"ground\", ohms = 30.0 }
sensed.selected = { to = \"ground\", ohms = 1000.0 }
sensed.unselected = { to = \"ground\", ohms = 1000.0 }
";

fn read(readout: &str) -> Result<Sensor, String> {
    let text = format!(
        "format = 1\n[array]\nrows = 2\ncolumns = 3\n{readout}[converter]\nbits = 10\nfull_scale_volts = 5.0\n"
    );
    Sensor::from_toml(&text).map_err(|error| error.to_string())
}

fn changed(from: &str, to: &str) -> Result<Sensor, String> {
    assert!(TABLE.contains(from), "{from}");
    read(&TABLE.replace(from, to))
}

const DRIVEN: &str = "driven.selected = { to = \"v_test\", ohms = 45.0 }";
const LOW: &str = "driven.unselected = { to = \"ground\", ohms = 30.0 }";
const SENSED: &str = "sensed.selected = { to = \"ground\", ohms = 1000.0 }";
const HELD: &str = "sensed.unselected = { to = \"ground\", ohms = 1000.0 }";

/// What is changed in the table, to what, and words of the refusal.
const REFUSED: &[(&str, &str, &str)] = &[
    (
        DRIVEN,
        "driven.selected = { to = \"ground\", ohms = 45.0 }",
        "never leads to V_t at column 0",
    ),
    (
        DRIVEN,
        "driven.selected = { to = \"v_test\", ohms = [45, inf, 45] }",
        "never leads to V_t at column 1",
    ),
    (
        DRIVEN,
        "driven.selected = { to = \"v_test\", ohms = [45, 45] }",
        "has 2 numbers, but the array has 3 columns",
    ),
    (
        DRIVEN,
        "driven.selected = { to = \"v_test\", ohms = 0.0 }",
        "`readout.driven.selected.ohms` is 0",
    ),
    (
        DRIVEN,
        "driven.selected = { to = \"v_test\", ohms = [45, -1, 45] }",
        "`readout.driven.selected.ohms[1]` is -1",
    ),
    (
        DRIVEN,
        "driven.selected = { to = \"v_test\", ohms = inf }",
        "`readout.driven.selected.ohms` is inf",
    ),
    (
        DRIVEN,
        "driven.selected = { to = \"v_test\" }",
        "leads to `v_test` without any resistance",
    ),
    (
        DRIVEN,
        "driven.selected = [{ to = \"v_test\", ohms = 45.0 }, { to = \"follower\", ohms = 45.0 }]",
        "leads to the follower",
    ),
    (
        DRIVEN,
        "driven.selected = { to = \"v_tets\", ohms = 45.0 }",
        "did you mean `v_test`?",
    ),
    (
        DRIVEN,
        "driven.selected = { to = \"v_test\", ohm = 45.0 }",
        "unknown key `ohm` in [readout.driven.selected]",
    ),
    (
        LOW,
        "driven.unselected = { to = \"amplifier\", ohms = 30.0 }",
        "amplifiers read sensed lines",
    ),
    (
        LOW,
        "driven.unselected = { to = \"open\", ohms = 30.0 }",
        "is open and has a resistance",
    ),
    (
        LOW,
        "driven.unselected = [{ to = \"ground\", switched = true }, { to = \"v_test\", switched = true }]",
        "two ends behind one switch",
    ),
    (
        SENSED,
        "sensed.selected = { to = \"v_test\", ohms = 1000.0 }",
        "has no end to ground at row 0",
    ),
    (
        SENSED,
        "sensed.selected = { to = \"ground\", ohms = [1000, inf] }",
        "has no end to ground at row 1",
    ),
    (
        SENSED,
        "sensed.selected = { to = \"open\" }",
        "has no end to ground at row 0",
    ),
    (
        SENSED,
        "sensed.selected = { to = \"ground\", switched = true }",
        "without a resistor",
    ),
    (
        SENSED,
        "sensed.selected = { to = \"amplifier\", ohms = 1.0 }",
        "leads to an amplifier, but a voltage is read",
    ),
    (
        HELD,
        "sensed.unselected = { to = \"amplifier\", ohms = 1.0 }",
        "leads to an amplifier, but a voltage is read",
    ),
    (
        "reads = \"voltage\"",
        "reads = \"current\"\nr_feedback_ohms = 2000.0",
        "has no virtual ground at row 0",
    ),
    (
        "reads = \"voltage\"",
        "reads = \"charge\"",
        "is `charge`, which is none of its words",
    ),
    ("reads = \"voltage\"\n", "", "`readout.reads` is missing"),
    (
        "v_test_volts = 5.0",
        "v_test_volts = 5.0\nr_pull_down_ohms = 1000.0",
        "stands beside a table",
    ),
    (
        "line-ends",
        "divider-floating",
        "stands beside topology `divider-floating`",
    ),
];

#[test]
fn tables_of_no_board_are_refused_in_words() {
    for (from, to, words) in REFUSED {
        let error = changed(from, to).expect_err(to);
        assert!(
            error.contains(words) && error.contains("hint: "),
            "{to}\n{error}"
        );
    }
    let without = |part: &str| {
        let lines = TABLE.lines().filter(|line| !line.starts_with(part));
        let text: String = lines.map(|line| format!("{line}\n")).collect();
        read(&text).unwrap_err()
    };
    assert!(without("driven").contains("`readout.driven` is missing"));
    assert!(without("sensed").contains("`readout.sensed` is missing"));
}

#[test]
fn a_follower_of_a_current_is_refused() {
    let table = TABLE
        .replace(
            "reads = \"voltage\"",
            "reads = \"current\"\nr_feedback_ohms = 2000.0",
        )
        .replace(
            "sensed.selected = { to = \"ground\"",
            "sensed.selected = { to = \"amplifier\"",
        );
    read(&table).unwrap();
    let error = read(&table.replace("r_feedback_ohms = 2000.0\n", ""));
    assert!(
        error
            .unwrap_err()
            .contains("`readout.r_feedback_ohms` is missing")
    );
    let error = read(&table.replace(
        "driven.unselected = { to = \"ground\"",
        "driven.unselected = { to = \"follower\"",
    ));
    assert!(
        error
            .unwrap_err()
            .contains("none but the amplifier's ground")
    );
}

#[test]
fn it_says_itself_in_words() {
    let words = |table: &str| read(table).unwrap().readout().words();
    assert_eq!(
        words(TABLE),
        "line-ends (columns v_test 45 Ω, else ground 30 Ω; rows ground 1000 Ω, else the same)"
    );
    let several = TABLE
        .replace("ohms = 30.0", "ohms = [30.0, inf, 40.0]")
        .replace("sensed.unselected = { to = \"ground\", ohms = 1000.0 }\n", "")
        .replace("{ to = \"ground\", ohms = 1000.0 }", "[{ to = \"ground\", ohms = 1e5 }, { to = \"ground\", ohms = 1000.0, switched = true }]");
    assert_eq!(
        words(&several),
        "line-ends (columns v_test 45 Ω, else ground 30 to 40 Ω; rows ground 100000 Ω and ground behind the switch 1000 Ω, else open)"
    );
}
