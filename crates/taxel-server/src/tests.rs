//! A real server, and viewers that behave and that do not.

mod access;
mod wire;

use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

use super::*;

#[derive(Default)]
struct Stage {
    asked: Mutex<Vec<Command>>,
    joined: AtomicUsize,
    /// Held while a deed is to take long.
    busy: Mutex<()>,
}

impl ViewerBackend for Stage {
    fn hello(&self) -> Hello {
        let source = SourceFacts::new("sim:test", SourceKind::Sim);
        Hello::new("test 1", SensorFacts::new("test", 64, 128), source)
    }
    fn state(&self, viewers: usize) -> State {
        State {
            clients: viewers,
            ..State::default()
        }
    }
    fn news(&self) -> Vec<Event> {
        Vec::new()
    }
    fn details(&self, watched: &Watched) -> Details {
        let at = |&(row, column): &(usize, usize)| TaxelDetails::at(row, column);
        Details {
            figures: watched.figures.then(FigureDetails::default),
            ..Details::new(watched.taxels.iter().map(at).collect())
        }
    }
    fn joined(&self) {
        self.joined.fetch_add(1, Ordering::Relaxed);
    }
    fn command(&self, command: Command) -> Result<Reply, Refused> {
        if command == Command::Play {
            drop(self.busy.lock());
        }
        self.asked.lock().unwrap().push(command.clone());
        match command {
            Command::Stop => Err(Refused::because("nothing is being recorded")),
            _ => Ok(Reply::saying("done")),
        }
    }
}

fn start(token: Option<&str>) -> (Server, Arc<Stage>) {
    let stage = Arc::new(Stage::default());
    let options = Options {
        token: token.map(str::to_owned),
        ..Options::new("127.0.0.1:0")
    };
    (Server::start(&options, stage.clone()).unwrap(), stage)
}

type Viewer = WebSocket<MaybeTlsStream<TcpStream>>;

fn view(server: &Server, query: &str) -> Viewer {
    let url = format!("ws://{}/live{query}", server.address());
    let (viewer, _) = tungstenite::connect(url).unwrap();
    if let MaybeTlsStream::Plain(stream) = viewer.get_ref() {
        stream
            .set_read_timeout(Some(Duration::from_secs(10)))
            .unwrap();
    }
    viewer
}

/// The next message that is wanted.
fn next(viewer: &mut Viewer, wanted: impl Fn(&Message) -> bool) -> Message {
    loop {
        let message = viewer.read().unwrap();
        if wanted(&message) {
            return message;
        }
    }
}

fn text_of(viewer: &mut Viewer, kind: &str) -> String {
    let kind = format!(r#""kind":"{kind}""#);
    let message = next(
        viewer,
        |m| matches!(m, Message::Text(t) if t.contains(&kind)),
    );
    message.into_text().unwrap().to_string()
}

fn frame(sequence: u64) -> FrameMessage {
    FrameMessage {
        sequence,
        ..FrameMessage::new(64, 128)
    }
}

/// Asks by hand; the status line and the rest.
fn ask(server: &Server, request: &str) -> String {
    let mut stream = TcpStream::connect(server.address()).unwrap();
    stream
        .set_read_timeout(Some(Duration::from_secs(5)))
        .unwrap();
    stream.write_all(request.as_bytes()).unwrap();
    let mut answer = Vec::new();
    let _ = stream.read_to_end(&mut answer);
    String::from_utf8_lossy(&answer).into_owned()
}

fn get(server: &Server, path: &str, headers: &str) -> String {
    let host = server.address();
    let close = "Connection: close\r\n";
    let named = if headers.contains("Host:") {
        String::new()
    } else {
        format!("Host: {host}\r\n")
    };
    ask(
        server,
        &format!("GET {path} HTTP/1.1\r\n{named}{close}{headers}\r\n"),
    )
}

#[test]
fn a_viewer_is_told_and_asks_and_is_answered() {
    let (server, stage) = start(None);
    let mut viewer = view(&server, "");
    assert!(text_of(&mut viewer, "hello").contains("hello"));
    assert!(text_of(&mut viewer, "state").contains(r#""clients":1"#));
    for (request, ok, says) in [
        (r#"{"id":1,"do":"tare"}"#, true, "done"),
        (
            r#"{"id":2,"do":"stop"}"#,
            false,
            "nothing is being recorded",
        ),
        (r#"{"id":3,"do":"explode"}"#, false, "unknown variant"),
        ("not json", false, "no request"),
        (r#"{"id":5,"do":"seek","secs":1e999}"#, false, "seek"),
    ] {
        viewer.send(Message::text(request)).unwrap();
        let answer = text_of(&mut viewer, "answer");
        assert!(answer.contains(&format!(r#""ok":{ok}"#)), "{answer}");
        assert!(answer.contains(says), "{answer}");
    }
    let asked = stage.asked.lock().unwrap().clone();
    assert_eq!(asked, [Command::Tare { force: false }, Command::Stop]);
    viewer
        .send(Message::text(r#"{"id":6,"do":"watch","taxels":[[3,7]]}"#))
        .unwrap();
    let details = text_of(&mut viewer, "details");
    assert!(details.contains(r#""row":3,"column":7"#), "{details}");
    assert!(details.contains(r#""figures":null"#), "{details}");
    // What a frame amounts to is told to those who ask for it, also where they watch no taxel.
    viewer
        .send(Message::text(
            r#"{"id":7,"do":"watch","taxels":[],"figures":true}"#,
        ))
        .unwrap();
    let told = |m: &Message| matches!(m, Message::Text(t) if t.contains(r#""taxels":[],"figures":{"sequence":0"#));
    next(&mut viewer, told);
}

/// A stalled viewer gets no more than is on the way, and the others lose nothing by it.
#[test]
fn a_stalled_viewer_holds_up_nobody() {
    let (server, _) = start(None);
    let mut stalled = view(&server, "");
    let mut good = view(&server, "");
    text_of(&mut stalled, "hello");
    text_of(&mut good, "hello");
    let rate = Message::text(r#"{"id":1,"do":"rate","frames_per_second":2000}"#);
    good.send(rate.clone()).unwrap();
    stalled.send(rate).unwrap();
    for sequence in 0..50 {
        server.publish(frame(sequence));
        loop {
            // A viewer that waits for nothing fails here, by its read's time-out.
            let message = next(&mut good, Message::is_binary).into_data();
            let got = u64::from_le_bytes(message[8..16].try_into().unwrap());
            good.send(Message::text(format!(r#"{{"do":"got","sequence":{got}}}"#)))
                .unwrap();
            if got == sequence {
                break;
            }
        }
    }
    drop(server);
    let mut frames = 0;
    while let Ok(message) = stalled.read() {
        frames += usize::from(message.is_binary());
    }
    assert!(frames <= 3, "{frames}");
}

/// A browser that has a file asks whether it is still the same, and gets it only if it is not.
#[test]
fn files_that_a_browser_has_are_not_sent_again() {
    let (server, _) = start(None);
    for path in ["/", "/model", "/assets/app.css", "/assets/js/main.js"] {
        let first = get(&server, path, "");
        let (head, body) = first.split_once("\r\n\r\n").unwrap();
        assert!(!body.is_empty(), "{path}: {head}");
        let line = head.lines().find_map(|line| line.strip_prefix("etag: "));
        let tag = line.unwrap_or_else(|| panic!("{path} has no tag: {head}"));
        for known in [tag, &format!("\"0\", W/{tag}"), "*"] {
            let again = get(&server, path, &format!("If-None-Match: {known}\r\n"));
            let (head, body) = again.split_once("\r\n\r\n").unwrap();
            assert!(head.starts_with("HTTP/1.1 304"), "{path}, {known}: {head}");
            assert!(
                head.contains(tag) && head.contains("no-cache"),
                "{path}: {head}"
            );
            assert_eq!(body, "", "{path}, {known}");
        }
        let other = get(&server, path, "If-None-Match: \"0\"\r\n");
        assert!(other.starts_with("HTTP/1.1 200"), "{path}: {other}");
        assert!(other.ends_with(body), "{path}");
    }
    let css = get(&server, "/assets/app.css", "");
    let script = get(&server, "/assets/js/main.js", "");
    let tag = |answer: &str| {
        answer
            .lines()
            .find(|l| l.starts_with("etag"))
            .map(str::to_owned)
    };
    assert_ne!(tag(&css), tag(&script));
}

#[test]
fn floods_and_giants_are_cut_off_and_the_rest_goes_on() {
    let (server, _) = start(None);
    let mut flood = view(&server, "");
    let closed = (0..2000).any(|id| {
        let request = format!(r#"{{"id":{id},"do":"tare"}}"#);
        flood.send(Message::text(request)).is_err()
    });
    let closed = closed || {
        let mut last = flood.read();
        while matches!(&last, Ok(message) if !message.is_close()) {
            last = flood.read();
        }
        true
    };
    assert!(closed);
    let mut giant = view(&server, "");
    text_of(&mut giant, "hello");
    let _ = giant.send(Message::text("x".repeat(1 << 20)));
    let mut last = giant.read();
    while matches!(&last, Ok(message) if !message.is_close()) {
        last = giant.read();
    }
    let mut binary = view(&server, "");
    text_of(&mut binary, "hello");
    binary.send(Message::binary(vec![1, 2, 3])).unwrap();
    next(&mut binary, Message::is_close);
    let mut good = view(&server, "");
    text_of(&mut good, "hello");
}

#[test]
fn there_is_an_end_to_viewers_and_to_silent_connections() {
    let (server, _) = start(None);
    let mut viewers: Vec<Viewer> = (0..MAX_VIEWERS).map(|_| view(&server, "")).collect();
    let url = format!("ws://{}/live", server.address());
    let refused = tungstenite::connect(&url);
    assert!(
        matches!(&refused, Err(tungstenite::Error::Http(answer)) if answer.status() == 503),
        "{refused:?}"
    );
    // One that never says what it wants holds up nobody, and those that leave make room.
    let _silent: Vec<TcpStream> = (0..20)
        .map(|_| TcpStream::connect(server.address()).unwrap())
        .collect();
    for mut viewer in viewers.drain(..) {
        let _ = viewer.close(None);
        while viewer.read().is_ok() {}
    }
    let begun = Instant::now();
    while tungstenite::connect(&url).is_err() {
        assert!(begun.elapsed() < Duration::from_secs(10));
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// What takes long for one viewer holds up no other.
#[test]
fn a_deed_that_takes_long_holds_up_nobody() {
    let (server, stage) = start(None);
    let mut asks = view(&server, "");
    let mut looks = view(&server, "");
    text_of(&mut asks, "hello");
    text_of(&mut looks, "hello");
    let busy = stage.busy.lock().unwrap();
    asks.send(Message::text(r#"{"id":1,"do":"play"}"#)).unwrap();
    for sequence in 0..3 {
        server.publish(frame(sequence));
        let message = next(&mut looks, Message::is_binary).into_data();
        let got = u64::from_le_bytes(message[8..16].try_into().unwrap());
        looks
            .send(Message::text(format!(r#"{{"do":"got","sequence":{got}}}"#)))
            .unwrap();
    }
    looks
        .send(Message::text(r#"{"id":7,"do":"tare"}"#))
        .unwrap();
    assert!(text_of(&mut looks, "answer").contains(r#""to":7"#));
    drop(busy);
    assert!(text_of(&mut asks, "answer").contains(r#""to":1"#));
}

/// A frame of before a viewer came is none of its own.
#[test]
fn a_viewer_gets_no_frame_of_before_it_came() {
    let (server, stage) = start(None);
    server.publish(frame(1));
    let mut viewer = view(&server, "");
    text_of(&mut viewer, "hello");
    let begun = Instant::now();
    while stage.joined.load(Ordering::Relaxed) == 0 {
        assert!(begun.elapsed() < Duration::from_secs(10), "nobody was told");
        std::thread::sleep(Duration::from_millis(5));
    }
    server.publish(frame(2));
    let message = next(&mut viewer, Message::is_binary).into_data();
    assert_eq!(message[8], 2);
}
