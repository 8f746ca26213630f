//! What viewers may do with a recording and with a page, by the real binary.

use std::process::Command;

use crate::live::{Running, ask, frame, told, view, wait};
use crate::run::{Folder, SENSOR};

const SIM: &str = "sim:sensor.toml?uniform";

#[test]
fn viewers_neither_end_nor_replace_the_operator_s_recording() {
    let folder = Folder::new();
    let mut running = Running::start(
        &folder,
        &format!("live {SIM} --listen 127.0.0.1:0 --record op.mcap"),
    );
    let mut viewer = view(&running.url());
    told(&mut viewer, "hello");
    let record = ask(&mut viewer, r#"{"id":1,"do":"record","name":"mine"}"#);
    assert_eq!(record["ok"], false, "{record}");
    assert!(
        record["text"]
            .as_str()
            .unwrap()
            .contains("op.mcap is being recorded"),
        "{record}"
    );
    let stop = ask(&mut viewer, r#"{"id":2,"do":"stop"}"#);
    assert_eq!(stop["ok"], false, "{stop}");
    wait("frames", || {
        told(&mut viewer, "state")["recording"]["frames"].as_u64() > Some(20)
    });
    assert!(!folder.exists("recordings/mine.mcap"));
    end(&mut running);
    folder.good("convert op.mcap -o op.txt");
}

/// Those of the sensor file, or those of another in their place, and each as boxes.
#[test]
fn viewers_are_told_of_named_regions_from_the_start() {
    let folder = Folder::new();
    let thumb =
        "[[region]]\nname = \"thumb\"\noutline = [[-0.5, -0.5], [-0.5, 3.6], [3.6, -0.5]]\n";
    folder.write("sensor.toml", &format!("{SENSOR}\n{thumb}"));
    folder.write(
        "r.toml",
        "[[region]]\nname = \"Far half\"\nboxes = [[0, 3, 3, 5], [2, 2, 0, 2]]\n",
    );
    let told_of = |words: &str| {
        let mut running = Running::start(&folder, &format!("{words} --listen 127.0.0.1:0"));
        told(&mut view(&running.url()), "hello")["sensor"]["regions"].take()
    };
    assert_eq!(
        told_of(&format!("live {SIM}")),
        serde_json::json!([{ "name": "thumb", "boxes": [[0, 0, 0, 3], [1, 1, 0, 2], [2, 2, 0, 1], [3, 3, 0, 0]], "windows": [] }])
    );
    folder.good("simulate --sensor sensor.toml --pattern uniform --frames 3 -o run.txt");
    assert_eq!(
        told_of("view run.txt --sensor sensor.toml --regions r.toml"),
        serde_json::json!([{ "name": "Far half", "boxes": [[0, 1, 3, 5], [2, 2, 0, 5], [3, 3, 3, 5]], "windows": [] }])
    );
    folder.write(
        "r.toml",
        "[[region]]\nname = \"heel\"\nboxes = [[0, 4, 0, 1]]\n",
    );
    let refused = folder.taxel(&format!("live {SIM} --regions r.toml --listen 127.0.0.1:0"));
    assert!(
        refused.code == Some(1) && refused.err.contains("rows 0 to 3"),
        "{refused}"
    );
}

/// A recording that is held at its first frame is known as a whole, also to who comes later; of a long one every so many-th frame.
#[test]
fn viewers_are_told_what_the_whole_recording_looks_like() {
    let folder = Folder::new();
    for (frames, points) in [(300, 300), (2500, 1250)] {
        folder.good(&format!(
            "simulate --sensor sensor.toml --pattern hand --load-g 300 --frames {frames} -o run.txt"
        ));
        folder.good("measure run.txt --sensor sensor.toml --no-intervals -o f.csv");
        let table = folder.read("f.csv");
        let totals = table.lines().skip(1);
        let totals: Vec<f64> = totals
            .map(|line| line.split(',').nth(1).unwrap().parse().unwrap())
            .collect();
        let mut running = Running::start(
            &folder,
            "view run.txt --sensor sensor.toml --listen 127.0.0.1:0",
        );
        let url = running.url();
        let curve = told(&mut view(&url), "curve");
        let numbers = |name: &str| -> Vec<f64> {
            let column = curve[name].as_array().unwrap().iter();
            column.map(|number| number.as_f64().unwrap()).collect()
        };
        assert_eq!(numbers("secs").len(), points);
        assert!(numbers("peak_kilopascals").iter().any(|peak| *peak > 1.0));
        for (found, wanted) in numbers("total_newtons")
            .iter()
            .zip(totals.iter().step_by(frames / points))
        {
            assert!(
                (found - wanted).abs() < 1e-4 * wanted.abs().max(1.0),
                "{found} {wanted}"
            );
        }
        assert_eq!(told(&mut view(&url), "curve"), curve);
    }
}

/// Asks it to end, as Ctrl-C does; what it said.
fn end(running: &mut Running) -> String {
    let pid = running.child.id().to_string();
    assert!(
        Command::new("kill")
            .args(["-INT", &pid])
            .status()
            .unwrap()
            .success()
    );
    let mut said = String::new();
    std::io::Read::read_to_string(running.child.stderr.as_mut().unwrap(), &mut said).unwrap();
    assert!(running.child.wait().unwrap().code().is_some());
    said
}

#[test]
fn every_beginning_and_end_of_a_recording_is_said() {
    let folder = Folder::new();
    let mut running = Running::start(&folder, &format!("live {SIM} --listen 127.0.0.1:0"));
    let mut viewer = view(&running.url());
    for name in ["-rf", "../x", "a\u{202e}b"] {
        let refused = ask(
            &mut viewer,
            &format!(r#"{{"id":1,"do":"record","name":"{name}"}}"#),
        );
        assert_eq!(refused["ok"], false, "{refused}");
    }
    let begun = ask(
        &mut viewer,
        r#"{"id":1,"do":"record","name":"grip \u00e9"}"#,
    );
    assert_eq!(begun["ok"], true, "{begun}");
    wait("frames", || {
        told(&mut viewer, "state")["recording"]["frames"].as_u64() > Some(20)
    });
    let stopped = ask(&mut viewer, r#"{"id":2,"do":"stop"}"#);
    assert_eq!(stopped["ok"], true, "{stopped}");
    let words = stopped["text"].as_str().unwrap();
    assert!(
        words.starts_with("Saved recordings/grip \u{e9}.mcap (")
            && words.ends_with(" frames, 0 lost)"),
        "{words}"
    );
    let said = end(&mut running);
    assert!(
        said.contains("a viewer begins to record to recordings/grip \u{e9}.mcap\n"),
        "{said}"
    );
    assert!(said.contains("recordings/grip \u{e9}.mcap: "), "{said}");
}

/// What was taken off while it was recorded is taken off where it is played, until somebody undoes it.
#[test]
fn a_tare_is_part_of_the_recording() {
    let folder = Folder::new();
    let mut running = Running::start(&folder, &format!("live {SIM} --listen 127.0.0.1:0"));
    let mut viewer = view(&running.url());
    told(&mut viewer, "hello");
    wait("load", || frame(&mut viewer).0 > 139.0);
    let forced = ask(&mut viewer, r#"{"id":1,"do":"tare","force":true}"#);
    assert!(
        forced["text"].as_str().unwrap().contains("141."),
        "{forced}"
    );
    // It is the mean of 20 frames.
    let mut frames = 0;
    wait("tare", || {
        let (total, tared) = frame(&mut viewer);
        frames += u32::from(tared && total.abs() < 0.5);
        frames > 30
    });
    assert_eq!(
        ask(&mut viewer, r#"{"id":2,"do":"record","name":"tared"}"#)["ok"],
        true
    );
    wait("frames", || {
        told(&mut viewer, "state")["recording"]["frames"].as_u64() > Some(50)
    });
    assert_eq!(ask(&mut viewer, r#"{"id":3,"do":"stop"}"#)["ok"], true);
    let mut player = Running::start(&folder, "view recordings/tared.mcap --listen 127.0.0.1:0");
    let mut watcher = view(&player.url());
    let (total, tared) = frame(&mut watcher);
    assert!(tared && total.abs() < 0.5, "{total}");
    // The state that is told next may be of before the first frame.
    wait("tare", || told(&mut watcher, "state")["tare"]["on"] == true);
    assert_eq!(ask(&mut watcher, r#"{"id":4,"do":"untare"}"#)["ok"], true);
    assert_eq!(ask(&mut watcher, r#"{"id":5,"do":"play"}"#)["ok"], true);
    wait("load", || {
        let (total, tared) = frame(&mut watcher);
        !tared && total > 139.0
    });
}

/// A clock that jumped while it was recorded holds up nobody who plays it.
#[test]
fn a_clock_that_jumps_does_not_stop_playback() {
    let folder = Folder::new();
    let rows = "30,31,32,33,34,35,\n".repeat(4);
    let text: String = [0.0, 0.1, 9e6, 9e6 + 0.1, 0.2, 0.3]
        .iter()
        .map(|secs| format!("time_secs={secs}\n{rows}"))
        .collect();
    folder.write("jumps.csv", &text);
    folder.good("convert jumps.csv --sensor sensor.toml -o jumps.mcap");
    let mut running = Running::start(&folder, "view jumps.mcap --listen 127.0.0.1:0");
    let mut viewer = view(&running.url());
    frame(&mut viewer);
    assert_eq!(ask(&mut viewer, r#"{"id":1,"do":"play"}"#)["ok"], true);
    wait("end", || {
        told(&mut viewer, "state")["device"]["state"] == "ended"
    });
}

#[test]
fn tokens_come_from_a_file_and_protect_something() {
    let folder = Folder::new();
    folder.write("token", "long-enough\n");
    let mut running = Running::start(
        &folder,
        &format!("live {SIM} --listen 127.0.0.1:0 --token-file token"),
    );
    assert!(running.url().ends_with("/?token=long-enough"));
    for token in [
        "--token=",
        "--token=x",
        "--token=a&b#c%d+e",
        "--token-file=none",
    ] {
        let run = folder.taxel(&format!("live {SIM} --listen 127.0.0.1:0 {token}"));
        assert_eq!(run.code, Some(2), "{run}");
        assert!(run.err.contains("token"), "{run}");
    }
    let mut everywhere = Running::start(&folder, &format!("live {SIM} --listen 0.0.0.0:0"));
    let url = everywhere.url();
    assert!(
        url.contains("/?token=") && !url.contains("0.0.0.0"),
        "{url}"
    );
}

/// One page for two recordings: what stands beside is looked at by way of the first one's address, and by its token.
#[test]
fn a_second_recording_is_shown_beside_the_first() {
    let folder = Folder::new();
    for (name, load, frames) in [("a", 100, 30), ("b", 200, 20)] {
        folder.good(&format!(
            "simulate --sensor sensor.toml --pattern uniform --load-g {load} --frames {frames} -o {name}.txt"
        ));
    }
    let words =
        "view a.txt --beside b.txt --sensor sensor.toml --listen 127.0.0.1:0 --token abcdefgh1";
    let mut running = Running::start(&folder, words);
    let url = running.url();
    let query = "?token=abcdefgh1";
    assert!(url.ends_with(&format!("/beside{query}")), "{url}");
    let place = url.replace(&format!("beside{query}"), "");
    let mut seen = Vec::new();
    for path in ["live", "beside/live"] {
        let mut viewer = view(&format!("{place}{path}{query}"));
        let hello = told(&mut viewer, "hello");
        let curve = told(&mut viewer, "curve");
        seen.push((
            hello["source"]["address"].as_str().unwrap().to_owned(),
            curve["secs"].as_array().unwrap().len(),
            curve["total_newtons"][0].as_f64().unwrap(),
        ));
    }
    assert!(seen[0].0.contains("a.txt") && seen[1].0.contains("b.txt"));
    assert_eq!((seen[0].1, seen[1].1), (30, 20));
    assert!((seen[1].2 / seen[0].2 - 2.0).abs() < 0.01, "{seen:?}");
    let refused = tungstenite::connect(format!("{place}beside/live").replace("http", "ws"));
    let closed = refused.unwrap().0.read().unwrap();
    assert!(closed.is_close(), "{closed}");
    end(&mut running);
}

#[test]
fn loads_stand_beside_loads_alone() {
    let folder = Folder::new();
    let plain = SENSOR.split("[material]").next().unwrap();
    folder.write("plain.toml", plain);
    for (sensor, name) in [("sensor", "a"), ("plain", "b")] {
        folder.good(&format!(
            "simulate --sensor sensor.toml --pattern uniform --frames 3 -o {name}.txt"
        ));
        folder.good(&format!(
            "convert {name}.txt --sensor {sensor}.toml --frames-per-second 10 -o {name}.mcap"
        ));
    }
    let refused = folder.fails("view b.mcap --beside a.mcap --listen 127.0.0.1:0");
    assert!(
        refused
            .err
            .contains("a.mcap has loads, and the sensor of b.mcap has no load law"),
        "{refused}"
    );
}
