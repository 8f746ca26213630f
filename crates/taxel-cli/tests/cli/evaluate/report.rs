//! What a report says beside its numbers: when its recordings were made, today's date where it is asked for, and readings at the
//! end of the converter's range.

use crate::run::Folder;

/// Recordings of two loads, one of which is more than the converter reads.
fn saturated(folder: &Folder) {
    for (name, load) in [("low", "100"), ("high", "3000")] {
        folder.good(&format!(
            "simulate --sensor sensor.toml --pattern uniform --load-g {load} --frames 4 --seed 5 -o {name}.txt"
        ));
        folder.good(&format!(
            "convert {name}.txt --sensor sensor.toml --frames-per-second 10 -o {name}.mcap"
        ));
    }
    folder.write(
        "t.csv",
        "recording,row,column,load_g\nlow.txt,1,1,100\nhigh.txt,1,1,3000\n",
    );
}

fn plan_of(folder: &Folder, kind: &str, more: &str) {
    folder.plan(&format!(
        "[[experiment]]\nkind = \"{kind}\"\nname = \"x\"\ntrials = \"t.csv\"\n{more}"
    ));
}

#[test]
fn readings_at_the_converter_s_end_are_marked_in_pictures() {
    let folder = Folder::new();
    saturated(&folder);
    for (kind, has_ceiling) in [("repeatability", true), ("accuracy", false)] {
        plan_of(&folder, kind, "");
        folder.good("report plan.toml -o r.html");
        let page = folder.read("r.html");
        assert!(page.contains("at the converter"), "{kind}");
        assert_eq!(page.contains(">converter's end<"), has_ceiling, "{kind}");
    }
    folder.write("t.csv", "recording,row,column,load_g\nlow.txt,1,1,100\n");
    folder.good("report plan.toml -o r.html");
    assert!(!folder.read("r.html").contains("at the converter"));
}

#[test]
fn a_report_says_when_its_recordings_were_made_and_today_s_date_on_request() {
    let folder = Folder::new();
    saturated(&folder);
    plan_of(&folder, "repeatability", "");
    folder.good("report plan.toml -o text.html");
    // Text knows no day.
    let page = folder.read("text.html");
    assert!(!page.contains("<dt>recorded</dt>") && !page.contains("<dt>date</dt>"));
    let table = folder.read("t.csv").replace(".txt", ".mcap");
    folder.write("t.csv", &table);
    for name in ["a.html", "b.html"] {
        folder.good(&format!("report plan.toml -o {name}"));
    }
    let page = folder.read("a.html");
    assert_eq!(page, folder.read("b.html"));
    let day = page.split("<dt>recorded</dt><dd>").nth(1).unwrap();
    assert!(
        day[10..].starts_with(" (UTC)") && day.starts_with("20"),
        "{}",
        &day[..20]
    );
    folder.good("report plan.toml --dated -o d.html");
    let dated = folder.read("d.html");
    let line = dated.split("<dt>date</dt>").nth(1).unwrap();
    let rest = dated.replacen(
        &format!("<dt>date</dt>{}\n", line.split('\n').next().unwrap()),
        "",
        1,
    );
    assert_eq!(rest, page);
    assert!(
        folder
            .good("evaluate plan.toml --dated")
            .out
            .contains("date: 20")
    );
}
