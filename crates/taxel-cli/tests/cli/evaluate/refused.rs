//! Plans and tables that make no sense.

use super::accuracy::presses;
use super::{Pressed, conductances, responses};
use crate::run::{Folder, SENSOR};

#[test]
#[expect(clippy::too_many_lines, reason = "a table of cases")]
fn plans_that_make_no_sense_are_refused_with_words() {
    let folder = Folder::new();
    insta::assert_snapshot!(folder.fails("evaluate nowhere.toml"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: cannot open nowhere.toml: No such file or directory (os error 2)
    hint: docs/evaluate.md has an example of a plan
    ");
    let good = "[[experiment]]\nkind = \"creep\"\nname = \"x\"\ntrials = \"t.csv\"\n";
    let plan = |text: &str| {
        folder.write("plan.toml", text);
        folder.fails("evaluate plan.toml")
    };
    let head = "format = 1\nsensor = \"sensor.toml\"\n";
    insta::assert_snapshot!(plan(&format!("{head}sead = 3\n{good}")), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: plan.toml: TOML parse error at line 3, column 1
      |
    3 | sead = 3
      | ^^^^
    unknown field `sead`, expected one of `format`, `title`, `sensor`, `seed`, `resamples`, `confidence`, `frames_per_second`, `live_frames`, `regions`, `experiment`
    hint: docs/evaluate.md has every key of a plan
    ");
    insta::assert_snapshot!(plan(&format!("{head}{}", good.replace("creep", "crosstalk"))), @r#"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: plan.toml: TOML parse error at line 4, column 8
      |
    4 | kind = "crosstalk"
      |        ^^^^^^^^^^^
    unknown variant `crosstalk`, expected one of `repeatability`, `response`, `hysteresis`, `creep`, `cross-talk`, `accuracy`
    hint: docs/evaluate.md has every key of a plan
    "#);
    insta::assert_snapshot!(plan(&format!("{head}{}", good.replace("[[experiment]]", "[experiment]"))), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: plan.toml: TOML parse error at line 3, column 1
      |
    3 | [experiment]
      | ^^^^^^^^^^^^
    invalid type: map, expected a sequence
    write [[experiment]], with two brackets: there may be more than one
    hint: docs/evaluate.md has every key of a plan
    ");
    for (text, says) in [
        (String::new(), "missing field `format`"),
        (
            format!("format = 2\nsensor = \"sensor.toml\"\n{good}"),
            "format = 2, but this program knows format 1",
        ),
        (
            format!("{head}experiment = []\n"),
            "no experiment: each begins with [[experiment]]",
        ),
        (head.to_owned(), "missing field `experiment`"),
        (
            format!("{head}{}", good.replace("name = \"x\"", "")),
            "missing field `name`",
        ),
        (
            format!("{head}{}", good.replace("\"x\"", "\" \"")),
            "no name",
        ),
        (
            format!("{head}{}", good.replace("trials", "trial")),
            "unknown field `trial`",
        ),
        (
            format!("{head}{}", good.replace("trials = \"t.csv\"", "")),
            "no trials",
        ),
        (
            format!("{head}{good}recording = \"r.npy\"\n"),
            "both trials and recording",
        ),
        (
            format!(
                "{head}{}",
                good.replace("trials = \"t.csv\"", "recording = \"r\"\ntruth_g = \"t\"")
            ),
            "creep needs trials",
        ),
        (
            format!(
                "{head}{}",
                good.replace("creep", "accuracy")
                    .replace("trials", "recording")
            ),
            "recording and truth_g go together",
        ),
        (
            format!("{head}confidence = 95\n{good}"),
            "confidence = 95, expected 0.5 to below 1",
        ),
        (
            format!("{head}resamples = 5\n{good}"),
            "resamples = 5, expected 100",
        ),
        (
            format!("{head}frames_per_second = 0\n{good}"),
            "frames_per_second = 0, expected a number above 0",
        ),
        (
            format!("{head}live_frames = 0\n{good}"),
            "live_frames = 0, expected 1 or more",
        ),
        (
            format!("{head}{good}along = \"column\"\n"),
            "along applies to cross-talk only",
        ),
        (
            format!("{head}{good}value = \"newtons\"\n"),
            "unknown variant `newtons`",
        ),
        (
            format!("{head}{good}ranges_g = [1, 0]\n"),
            "ranges_g applies to accuracy only",
        ),
        (
            format!(
                "{head}{}ranges_g = [1, 0]\n",
                good.replace("creep", "accuracy")
            ),
            "ranges_g = [1.0, 0.0] must ascend",
        ),
        (
            format!(
                "{head}{}value = \"grams\"\n",
                good.replace("creep", "accuracy")
            ),
            "value applies to all kinds but accuracy and cross-talk",
        ),
        (
            format!("{head}{good}frames_per_experiment = 2\n"),
            "frames_per_experiment applies to accuracy of a recording with truth_g only",
        ),
        (
            format!("format = 1\nsensor = \"nosensor.toml\"\n{good}"),
            "cannot open nosensor.toml",
        ),
        (format!("{head}{good}"), "cannot open t.csv"),
    ] {
        let run = plan(&text);
        assert_eq!(run.code, Some(1), "{run}");
        assert!(run.err.contains(says), "{says}\n{run}");
    }
    let none = folder.fails("evaluate");
    assert_eq!(none.code, Some(2));
    for (name, says) in [
        (
            "report.docx",
            "report.docx: cannot write a report as .docx\nhint: use .html or .pdf",
        ),
        (
            "report",
            "report: a report needs an extension\nhint: use .html or .pdf",
        ),
    ] {
        let run = folder.fails(&format!("evaluate plan.toml -o {name}"));
        assert_eq!(run.code, Some(2), "{run}");
        assert!(run.err.contains(says), "{run}");
        assert_eq!(
            folder.fails(&format!("report plan.toml -o {name}")).code,
            Some(2)
        );
    }
}

#[test]
#[expect(clippy::too_many_lines, reason = "a table of cases")]
fn tables_that_do_not_fit_their_kind_are_refused_with_their_place() {
    let folder = Folder::new();
    let frames: Vec<Pressed> = (0..12).map(|_| vec![(1, 1, 1e-3)]).collect();
    folder.scan("sensor.toml", "r.txt", &frames);
    let trial = |kind: &str, table: &str| {
        folder.plan(&format!(
            "[[experiment]]\nkind = \"{kind}\"\nname = \"x\"\ntrials = \"t.csv\"\n"
        ));
        folder.write("t.csv", table);
        folder.fails("evaluate plan.toml")
    };
    insta::assert_snapshot!(trial("response", "recording,row,column\nr.txt,1,1\n"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: t.csv, line 2: response needs load_g in every line
    hint: docs/evaluate.md says which columns each kind needs
    ");
    insta::assert_snapshot!(trial("response", "recording,row,column,load_g\nr.txt,1,1,5\nr.txt,4,1,5\n"), @r"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: taxel outside the array at t.csv, line 3, column 7: `4,1` is row 4, column 1, but the array has 4 rows x 6 columns, counted from 0
    hint: check the label, `labels` under [array] in the sensor file, and which sensor this is
    ");
    insta::assert_snapshot!(trial("hysteresis", "recording,frame,row,column,load_g\nr.txt,0,1,1,5\nr.txt,1,1,1,7\n"), @"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: t.csv, setting all: hysteresis needs a loop (lines with one word under experiment) whose load grows and falls over two loads or more; its 2 readings are not enough
    ");
    for (kind, table, says) in [
        (
            "repeatability",
            "recording\nr.txt\n",
            "line 2: repeatability needs row and column, or taxel",
        ),
        (
            "hysteresis",
            "recording,row,column\nr.txt,1,1\n",
            "hysteresis needs load_g",
        ),
        (
            "creep",
            "recording,load_g\nr.txt,1\n",
            "creep needs row and column, or taxel",
        ),
        (
            "cross-talk",
            "recording,row,column\nr.txt,1,1\n",
            "cross-talk needs others",
        ),
        (
            "cross-talk",
            "recording,frame,row,column,others\nr.txt,0,1,1,1\nr.txt,1,1,1,6\n",
            "line 3: 6 others pressed, but a row has 6 taxels",
        ),
        (
            "cross-talk",
            "recording,row,column,others\nr.txt,1,1,2\n",
            "cross-talk needs readings with two numbers of others",
        ),
        (
            "accuracy",
            "recording,row,column\nr.txt,1,1\n",
            "accuracy needs taxel or region and load_g, or total_g, or x_mm and y_mm",
        ),
        ("accuracy", "recording,total_g,x_mm\nr.txt,1,1\n", "y_mm"),
        (
            "accuracy",
            "recording,total_g,x_mm,y_mm\nr.txt,1,1,\n",
            "x_mm and y_mm go together",
        ),
        (
            "accuracy",
            "recording,x_mm,y_mm\nr.txt,-1,1\n",
            "places count from the centre of the taxel",
        ),
        ("response", "row,column,load_g\n1,1,1\n", "recording"),
        ("response", "recording,row,load_g\nr.txt,1,1\n", "column"),
        (
            "response",
            "recording,row,column,load\nr.txt,1,1,1\n",
            "did you mean `load_g`?",
        ),
        (
            "response",
            "recording,row,column,load_g\nr.txt,1,1,heavy\n",
            "must be a finite number",
        ),
        (
            "response",
            "recording,row,column,load_g\nnowhere.txt,1,1,1\n",
            "cannot open nowhere.txt",
        ),
        (
            "response",
            "recording,frame,row,column,load_g\nr.txt,12,1,1,1\n",
            "line 2: frame 12 of r.txt, but it has 12 frames",
        ),
        (
            "response",
            "recording,row,column,load_g\nr.txt,1,1,1\n",
            "response needs readings under two loads or more",
        ),
        (
            "creep",
            "recording,row,column\nr.txt,1,1\n",
            "r.txt: no times, but experiment 'x' is about time",
        ),
        (
            "response",
            "recording,row,column,load_g\n",
            "no trial in t.csv",
        ),
    ] {
        let run = trial(kind, table);
        assert_eq!(run.code, Some(1), "{run}");
        assert!(run.err.contains(says), "{says}\n{run}");
    }
}

/// Lines that were copied are no new experiments: intervals would be too narrow.
#[test]
fn the_same_readings_are_no_second_experiment() {
    let folder = Folder::new();
    presses(&folder);
    let table = folder.read("t.csv");
    let mut lines: Vec<&str> = table.lines().collect();
    lines.push(lines[2]);
    folder.write("t.csv", &lines.join("\n"));
    folder.plan("[[experiment]]\nkind = \"accuracy\"\nname = \"a\"\ntrials = \"t.csv\"\n");
    let run = folder.fails("evaluate plan.toml");
    let says = format!("t.csv, lines 3 and {}: frame ", lines.len());
    assert!(run.err.contains(&says), "{run}");
    assert!(
        run.err
            .contains("the same taxel or region twice, as two experiments"),
        "{run}"
    );
    // A recording read whole has each of its frames in it.
    let whole = "recording,frame,row,column\nr.txt,,1,1\nr.txt,3,1,1\n";
    folder.write("whole.csv", whole);
    folder.plan("[[experiment]]\nkind = \"repeatability\"\nname = \"r\"\ntrials = \"whole.csv\"\n");
    let run = folder.fails("evaluate plan.toml");
    assert!(
        run.err.contains("whole.csv, lines 2 and 3: frame 3 of "),
        "{run}"
    );
    // With a name they are one experiment, read twice or not.
    let named = "recording,frame,row,column,experiment\nr.txt,0,1,1,a\nr.txt,0,1,1,a\n";
    folder.write("named.csv", named);
    folder.plan("[[experiment]]\nkind = \"repeatability\"\nname = \"r\"\ntrials = \"named.csv\"\n");
    let run = folder.taxel("evaluate plan.toml");
    assert!(!run.err.contains("twice"), "{run}");
}

#[test]
fn settings_that_no_trial_has_are_refused() {
    let folder = Folder::new();
    responses(&folder);
    folder.plan(
        "[[experiment]]\nkind = \"response\"\nname = \"r\"\ntrials = \"t.csv\"\n[experiment.settings]\n\"2V\" = \"v2.toml\"\n",
    );
    insta::assert_snapshot!(folder.fails("evaluate plan.toml"), @r#"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: plan.toml: experiment 'r': [experiment.settings] names '2V'; t.csv has '0.4 V' and '2 V'
    hint: docs/evaluate.md has every key of a plan
    "#);
}

#[test]
fn loads_need_a_load_law_and_truths() {
    let folder = Folder::new();
    presses(&folder);
    let without = SENSOR.split("[material]").next().unwrap();
    folder.write("plain.toml", without);
    folder.plan("[[experiment]]\nkind = \"accuracy\"\nname = \"a\"\ntrials = \"t.csv\"\nsensor = \"plain.toml\"\n");
    let run = folder.fails("evaluate plan.toml");
    assert!(
        run.err
            .contains("has no [material]\nhint: calibrate the sensor"),
        "{run}"
    );
    folder.plan("[[experiment]]\nkind = \"repeatability\"\nname = \"a\"\ntrials = \"t.csv\"\nvalue = \"grams\"\nsensor = \"plain.toml\"\n");
    assert!(
        folder
            .fails("evaluate plan.toml")
            .err
            .contains("has no [material]")
    );
    let fewer: Vec<Pressed> = vec![vec![(1, 1, 5.0)]; 5];
    folder.write("truth.csv", &conductances(&fewer, 0.0));
    folder.plan(
        "[[experiment]]\nkind = \"accuracy\"\nname = \"a\"\nrecording = \"presses.txt\"\ntruth_g = \"truth.csv\"\n",
    );
    insta::assert_snapshot!(folder.fails("evaluate plan.toml"), @"
    exit code: 1
    ----- stdout -----

    ----- stderr -----
    error: truth.csv: known loads of 5 frame(s), but presses.txt has more
    hint: one frame of loads for each frame of counts
    ");
    folder.plan(
        "[[experiment]]\nkind = \"accuracy\"\nname = \"a\"\nrecording = \"presses.txt\"\ntruth_g = \"truth.csv\"\nmethods = [\"rwa\"]\n",
    );
    let run = folder.fails("evaluate plan.toml");
    assert_eq!(run.code, Some(2), "{run}");
    assert!(run.err.contains("no method `rwa`"), "{run}");
}
