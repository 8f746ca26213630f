//! Sources, recordings and the viewer's server, by the real binary.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

use crate::run::Folder;

/// A simulated source of the small sensor.
const SIM: &str = "sim:sensor.toml?uniform";

/// The binary at work; killed when the test ends.
pub struct Running {
    pub child: Child,
}

impl Running {
    pub fn start(folder: &Folder, words: &str) -> Self {
        let child = Command::new(env!("CARGO_BIN_EXE_taxel"))
            .args(words.split_whitespace())
            .current_dir(folder.path(""))
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        Self { child }
    }

    /// The first line of standard output: the page's address.
    pub fn url(&mut self) -> String {
        let mut line = String::new();
        let out = self.child.stdout.take().unwrap();
        BufReader::new(out).read_line(&mut line).unwrap();
        line.trim().to_owned()
    }

    /// Where the port is that the system chose for `udp:HOST:0`, and what else is said, to be kept as long as it speaks.
    pub fn place(&mut self) -> (String, impl Iterator + use<>) {
        let mut said = BufReader::new(self.child.stderr.take().unwrap()).lines();
        let place = said.find_map(|line| {
            let line = line.unwrap();
            line.strip_suffix(" is open, nothing yet")
                .map(str::to_owned)
        });
        (place.expect("a port that is open"), said)
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

pub fn wait(what: &str, mut done: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !done() {
        assert!(begun.elapsed() < Duration::from_secs(30), "no {what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

pub type Viewer = WebSocket<MaybeTlsStream<TcpStream>>;

pub fn view(url: &str) -> Viewer {
    let url = url.replace("http://", "ws://").replace("/?", "/live?");
    let url = if url.contains("/live") {
        url
    } else {
        format!("{url}live")
    };
    let (viewer, _) = tungstenite::connect(url).unwrap();
    if let MaybeTlsStream::Plain(stream) = viewer.get_ref() {
        stream
            .set_read_timeout(Some(Duration::from_secs(20)))
            .unwrap();
    }
    viewer
}

/// The next message whose JSON has this kind.
pub fn told(viewer: &mut Viewer, kind: &str) -> serde_json::Value {
    loop {
        match viewer.read().unwrap() {
            Message::Text(text) => {
                let json: serde_json::Value = serde_json::from_str(&text).unwrap();
                if json["kind"] == kind {
                    return json;
                }
            }
            Message::Binary(bytes) => got(viewer, &bytes),
            _ => {}
        }
    }
}

/// Says that a frame has arrived: the server sends no more than a few that nobody took.
fn got(viewer: &mut Viewer, bytes: &[u8]) {
    let sequence = u64::from_le_bytes(bytes[8..16].try_into().unwrap());
    let text = format!(r#"{{"do":"got","sequence":{sequence}}}"#);
    viewer.send(Message::text(text)).unwrap();
}

/// Asks for something; the answer.
pub fn ask(viewer: &mut Viewer, request: &str) -> serde_json::Value {
    viewer.send(Message::text(request)).unwrap();
    told(viewer, "answer")
}

/// The next frame: total force and tare flag.
pub fn frame(viewer: &mut Viewer) -> (f32, bool) {
    loop {
        if let Message::Binary(bytes) = viewer.read().unwrap() {
            got(viewer, &bytes);
            let total = f32::from_le_bytes(bytes[32..36].try_into().unwrap());
            return (total, bytes[6] & 2 != 0);
        }
    }
}

#[test]
fn a_recording_has_counts_times_and_the_sensor() {
    let folder = Folder::new();
    let run = folder.good(&format!(
        "record {SIM} -o run.mcap --frames 50 --loads --figures"
    ));
    assert!(run.err.contains("run.mcap: "), "{run}");
    // The recording brings its sensor; a text copy of it is the same.
    folder.good("convert run.mcap -o run.txt");
    folder.good("compensate run.mcap --sensor sensor.toml -o a.csv");
    folder.good("compensate run.txt --sensor sensor.toml -o b.csv");
    assert_eq!(folder.numbers("run.txt").len() / 24, 50);
    assert_eq!(folder.numbers("a.csv"), folder.numbers("b.csv"));
    // There and back.
    folder.good("convert run.txt --sensor sensor.toml -o again.mcap");
    folder.good("convert again.mcap -o again.txt");
    assert_eq!(folder.read("again.txt"), folder.read("run.txt"));
    for name in ["x.csv", "x.npy", "x.npz", "x.parquet"] {
        folder.good(&format!("convert run.mcap -o {name}"));
    }
    folder.good("convert x.npz --sensor sensor.toml -o y.txt");
    assert_eq!(folder.read("y.txt"), folder.read("run.txt"));
    let info = folder.good("info run.mcap");
    assert!(info.out.contains("4 rows x 6 columns"), "{info}");
    // An existing recording is never overwritten.
    let again = folder.fails(&format!("record {SIM} -o run.mcap --frames 5"));
    assert!(again.err.contains("run.mcap"), "{again}");
}

#[test]
fn a_killed_recording_is_recovered() {
    let folder = Folder::new();
    // Killed when the file has nothing but its beginning, and when it has chunks.
    for (turn, bytes) in [0, 8_000, 16_000].into_iter().enumerate() {
        let (run, saved) = (format!("{turn}.mcap"), format!("saved{turn}.mcap"));
        let mut running = Running::start(&folder, &format!("record {SIM} -o {run}"));
        let size = || std::fs::metadata(folder.path(&run)).map_or(0, |about| about.len());
        wait("file", || folder.exists(&run) && size() >= bytes);
        running.child.kill().unwrap();
        running.child.wait().unwrap();
        let recovered = folder.taxel(&format!("recover {run} -o {saved}"));
        assert_eq!(recovered.code, Some(3), "{recovered}");
        assert!(recovered.err.contains("the end was missing"), "{recovered}");
        if bytes > 0 {
            folder.good(&format!("convert {saved} -o {turn}.txt"));
            assert!(folder.numbers(&format!("{turn}.txt")).len() >= 24);
            let cut = folder.fails(&format!("convert {run} -o cut.txt"));
            assert!(cut.err.contains("taxel recover"), "{cut}");
        }
    }
    let none = folder.fails("recover sensor.toml -o x.mcap");
    assert!(none.err.contains("is not an MCAP file"), "{none}");
}

#[test]
fn what_a_device_sends_is_recorded_and_what_is_lost_is_said() {
    let folder = Folder::new();
    folder.good(&format!("record {SIM} -o run.mcap --frames 30"));
    let words = "record udp:127.0.0.1:0 --sensor sensor.toml -o heard.mcap --frames 20";
    let mut recording = Running::start(&folder, words);
    let (place, _said) = recording.place();
    // Once is enough, but for datagrams that nobody has to deliver. The last ones may come too late.
    for sent in 0.. {
        if recording.child.try_wait().unwrap().is_some() {
            break;
        }
        assert!(sent < 100, "nothing was heard");
        folder.taxel(&format!("replay run.mcap --to {place} --speed 0"));
    }
    let converted = folder.taxel("convert heard.mcap -o heard.txt");
    // Where it had to be sent again, the packets of the second sender are told of.
    let again = converted.err.contains("of other senders");
    assert_eq!(
        converted.code,
        Some(if again { 3 } else { 0 }),
        "{converted}"
    );
    folder.good("convert run.mcap -o run.txt");
    let (heard, run) = (folder.read("heard.txt"), folder.read("run.txt"));
    let first: Vec<&str> = heard.lines().take(4).collect();
    assert!(run.contains(&first.join("\n")));
    // A pipe with noise in it.
    let replayed = Command::new(env!("CARGO_BIN_EXE_taxel"))
        .args(["replay", "run.mcap", "--to", "-", "--speed", "0"])
        .current_dir(folder.path(""))
        .output()
        .unwrap();
    let mut bytes = replayed.stdout;
    let middle = bytes.len() / 2;
    bytes[middle] ^= 0x55;
    let mut child = Command::new(env!("CARGO_BIN_EXE_taxel"))
        .args([
            "record",
            "stdin:",
            "--sensor",
            "sensor.toml",
            "-o",
            "piped.mcap",
        ])
        .current_dir(folder.path(""))
        .stdin(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(&bytes).unwrap();
    let ended = child.wait_with_output().unwrap();
    let words = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert_eq!(ended.status.code(), Some(3), "{words}");
    assert!(words.contains("1 lost, 1 corrupt"), "{words}");
}

#[test]
#[expect(
    clippy::too_many_lines,
    reason = "one run of the program, step by step"
)]
fn viewers_see_tare_record_and_are_told_what_they_may_not() {
    let folder = Folder::new();
    let mut running = Running::start(&folder, &format!("live {SIM} --listen 127.0.0.1:0"));
    let url = running.url();
    let mut viewer = view(&url);
    let hello = told(&mut viewer, "hello");
    assert_eq!(hello["sensor"]["columns"], 6);
    assert_eq!(hello["source"]["type"], "sim");
    let (total, tared) = frame(&mut viewer);
    // 24 taxels under 600 g each.
    assert!((total - 141.2).abs() < 2.0, "{total}");
    assert!(!tared);
    let refused = ask(&mut viewer, r#"{"id":1,"do":"tare"}"#);
    assert_eq!(refused["ok"], false);
    assert!(
        refused["text"].as_str().unwrap().starts_with("141."),
        "{refused}"
    );
    let forced = r#"{"id":1,"do":"tare","force":true}"#;
    assert_eq!(ask(&mut viewer, forced)["ok"], true);
    wait("tare", || {
        let (total, tared) = frame(&mut viewer);
        tared && total.abs() < 0.5
    });
    assert_eq!(ask(&mut viewer, r#"{"id":2,"do":"untare"}"#)["ok"], true);
    wait("load", || frame(&mut viewer).0 > 139.0);
    // Cross-talk comes, and the inverse that knows of it takes it off again.
    let slide = r#"{"id":3,"do":"slider","key":"r_mux_column_ohms","value":200}"#;
    assert_eq!(ask(&mut viewer, slide)["ok"], true);
    wait("slider", || {
        let state = told(&mut viewer, "state");
        state["sliders"]["r_mux_column_ohms"] == 200.0
    });
    wait("inverse", || (frame(&mut viewer).0 - 141.2).abs() < 2.0);
    let outside = ask(&mut viewer, r#"{"id":4,"do":"record","name":"../outside"}"#);
    assert_eq!(outside["ok"], false);
    let begun = ask(&mut viewer, r#"{"id":5,"do":"record","name":"grip"}"#);
    assert_eq!(begun["ok"], true, "{begun}");
    wait("frames", || {
        told(&mut viewer, "state")["recording"]["frames"].as_u64() > Some(30)
    });
    ask(&mut viewer, r#"{"id":6,"do":"event","text":"now"}"#);
    assert_eq!(told(&mut viewer, "event")["text"], "now");
    let twice = ask(&mut viewer, r#"{"id":7,"do":"record","name":"grip"}"#);
    assert_eq!(twice["ok"], false, "{twice}");
    assert_eq!(ask(&mut viewer, r#"{"id":8,"do":"stop"}"#)["ok"], true);
    assert_eq!(ask(&mut viewer, r#"{"id":9,"do":"stop"}"#)["ok"], false);
    folder.good("convert recordings/grip.mcap -o grip.txt");
    assert!(folder.numbers("grip.txt").len() / 24 > 30);
    // What was marked is told of the recording, and told again when it is played.
    let info = folder.good("info recordings/grip.mcap");
    assert!(info.out.contains(" s  mark: now\n"), "{info}");
    let mut player = Running::start(&folder, "view recordings/grip.mcap --listen 127.0.0.1:0");
    // Held at its first frame, until somebody plays it.
    let mut watcher = view(&player.url());
    frame(&mut watcher);
    wait("pause", || {
        let state = told(&mut watcher, "state")["device"]["state"].clone();
        assert_ne!(state, "live");
        state == "paused"
    });
    assert_eq!(ask(&mut watcher, r#"{"id":1,"do":"play"}"#)["ok"], true);
    while told(&mut watcher, "event")["text"] != "now" {}
    // Another method, and one that is a file's name.
    let raw = ask(&mut viewer, r#"{"id":10,"do":"method","name":"raw"}"#);
    assert_eq!(raw["ok"], true);
    let file = ask(
        &mut viewer,
        r#"{"id":11,"do":"method","name":"/etc/passwd"}"#,
    );
    assert_eq!(file["ok"], false);
    viewer
        .send(Message::text(
            r#"{"id":12,"do":"watch","taxels":[[1,2],[99,0]]}"#,
        ))
        .unwrap();
    wait("details", || {
        frame(&mut viewer);
        let details = told(&mut viewer, "details");
        let found = details["taxels"].as_array().unwrap();
        found.len() == 1
            && found[0]["half_width_95_newtons"].as_f64() > Some(0.0)
            && found[0]["noise_only"] == true
    });
}

#[test]
#[expect(
    clippy::too_many_lines,
    reason = "one run of the program, step by step"
)]
fn a_file_is_played_held_and_moved() {
    let folder = Folder::new();
    folder.good("record sim:sensor.toml?hand -o run.mcap --secs 2");
    let mut running = Running::start(
        &folder,
        "view run.mcap --listen 127.0.0.1:0 --token abcdefgh",
    );
    let url = running.url();
    let stranger: SocketAddr = url["http://".len()..]
        .split('/')
        .next()
        .unwrap()
        .parse()
        .unwrap();
    let mut page = TcpStream::connect(stranger).unwrap();
    write!(
        page,
        "GET / HTTP/1.1\r\nHost: {stranger}\r\nConnection: close\r\n\r\n"
    )
    .unwrap();
    let mut answer = String::new();
    page.read_to_string(&mut answer).unwrap();
    assert!(answer.starts_with("HTTP/1.1 401"), "{answer}");
    let mut viewer = view(&url);
    assert_eq!(told(&mut viewer, "hello")["source"]["type"], "file");
    assert_eq!(ask(&mut viewer, r#"{"id":1,"do":"pause"}"#)["ok"], true);
    assert_eq!(
        ask(&mut viewer, r#"{"id":2,"do":"seek","secs":1.0}"#)["ok"],
        true
    );
    wait("place", || {
        let player = &told(&mut viewer, "state")["player"];
        // There is no position before the first frame has been played.
        let position = player["position_secs"].as_f64();
        player["playing"] == false && position.is_some_and(|secs| (secs - 1.0).abs() < 0.05)
    });
    assert_eq!(
        ask(&mut viewer, r#"{"id":3,"do":"speed","factor":10}"#)["ok"],
        true
    );
    assert_eq!(ask(&mut viewer, r#"{"id":4,"do":"play"}"#)["ok"], true);
    wait("end", || {
        told(&mut viewer, "state")["device"]["state"] == "ended"
    });
    // Moved back it goes on; played at the end it begins again.
    let back = ask(&mut viewer, r#"{"id":7,"do":"seek","secs":0.5}"#);
    assert_eq!(back["ok"], true);
    wait("live", || {
        told(&mut viewer, "state")["device"]["state"] == "live"
    });
    wait("end", || {
        told(&mut viewer, "state")["device"]["state"] == "ended"
    });
    for id in [8, 9] {
        let play = format!(r#"{{"id":{id},"do":"play"}}"#);
        assert_eq!(ask(&mut viewer, &play)["ok"], true);
        wait("play", || {
            told(&mut viewer, "state")["device"]["state"] == "live"
        });
        wait("end", || {
            told(&mut viewer, "state")["device"]["state"] == "ended"
        });
    }
    assert_eq!(
        ask(&mut viewer, r#"{"id":5,"do":"tare","force":true}"#)["ok"],
        true
    );
    assert_eq!(
        ask(
            &mut viewer,
            r#"{"id":6,"do":"slider","key":"noise_counts","value":1}"#
        )["ok"],
        false
    );
}

#[test]
fn what_is_wrong_is_said_before_anything_starts() {
    let folder = Folder::new();
    folder.write("broken.mcap", "nothing of the kind");
    for (words, says) in [
        (
            "live nonsense",
            "'nonsense' is not a source: expected serial:",
        ),
        ("live serial:/dev/ttyACM0", "names no sensor"),
        ("live rpi:board.toml --sensor sensor.toml", "built without"),
        (
            "live sim:nowhere?hand",
            "no preset sensor is called `nowhere`",
        ),
        ("live sim:econe?hnad", "did you mean hand?"),
        ("view no-such.mcap", "no-such.mcap"),
        ("view broken.mcap", "is not an MCAP file"),
        ("view sensor.toml", "names no sensor"),
        (
            "live sim:econe --listen 127.0.0.1:99999",
            "cannot listen on 127.0.0.1:99999",
        ),
        ("record sim:econe -o nowhere/run.mcap", "nowhere/run.mcap"),
        ("convert broken.mcap -o x.txt", "is not an MCAP file"),
        (
            "replay broken.mcap --to udp:1 --sensor sensor.toml",
            "is not an MCAP file",
        ),
    ] {
        let run = folder.taxel(words);
        assert!(matches!(run.code, Some(1 | 2)), "{words}: {run}");
        assert!(run.err.contains(says), "{words}: {run}");
    }
}

#[test]
fn frames_of_a_file_that_cannot_be_read_are_told() {
    let folder = Folder::new();
    let row = "30,31,32,33,34,35,\n";
    let text = format!(
        "{}{}1,x,3,\n{}",
        row.repeat(8),
        row.repeat(2),
        row.repeat(9)
    );
    folder.write("hurt.txt", &text);
    let run = folder.taxel("record file:hurt.txt?speed=max --sensor sensor.toml -o hurt.mcap");
    assert_eq!(run.code, Some(3), "{run}");
    assert!(run.err.contains("corrupt"), "{run}");
}
