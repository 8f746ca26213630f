//! A real server, and viewers that behave and that do not.

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

impl Host for Stage {
    fn hello(&self) -> String {
        r#"{"kind":"hello"}"#.to_owned()
    }
    fn state(&self, viewers: usize) -> String {
        format!(r#"{{"kind":"state","clients":{viewers}}}"#)
    }
    fn news(&self) -> Vec<String> {
        Vec::new()
    }
    fn details(&self, taxels: &[(usize, usize)]) -> String {
        format!(r#"{{"kind":"details","taxels":{taxels:?}}}"#).replace(['(', ')'], "")
    }
    fn joined(&self) {
        self.joined.fetch_add(1, Ordering::Relaxed);
    }
    fn command(&self, command: Command) -> Result<String, String> {
        if command == Command::Play {
            drop(self.busy.lock());
        }
        self.asked.lock().unwrap().push(command.clone());
        match command {
            Command::Stop => Err("nothing is being recorded".to_owned()),
            _ => Ok("done".to_owned()),
        }
    }
}

fn start(token: Option<&str>) -> (Server, Arc<Stage>) {
    let stage = Arc::new(Stage::default());
    let options = Options {
        address: "127.0.0.1:0".to_owned(),
        token: token.map(str::to_owned),
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
    let taxels = 64 * 128;
    FrameMessage {
        rows: 64,
        columns: 128,
        sequence,
        counts: vec![1; taxels],
        raw: vec![0.0; taxels],
        loads: vec![0.0; taxels],
        marks: vec![0; taxels],
        ..FrameMessage::default()
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
    if headers.contains("Host:") {
        ask(
            server,
            &format!("GET {path} HTTP/1.1\r\n{close}{headers}\r\n"),
        )
    } else {
        ask(
            server,
            &format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n{close}{headers}\r\n"),
        )
    }
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
    assert!(text_of(&mut viewer, "details").contains("[3, 7]"));
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

#[test]
fn without_the_token_nothing_is_seen() {
    let (server, stage) = start(Some("secret-8"));
    let port = server.address().port();
    let good = format!("Cookie: a=b; taxel_token_{port}=secret-8\r\n");
    let bad = format!("Cookie: taxel_token_{port}=secret-\r\n");
    for (path, headers, status) in [
        ("/", "", "401"),
        ("/model", "", "401"),
        ("/?token=wrong", "", "401"),
        ("/?token=", "", "401"),
        ("/assets/app.css", "", "401"),
        ("/?token=secret-8", "", "200"),
        ("/assets/app.css", good.as_str(), "200"),
        ("/assets/app.css", bad.as_str(), "401"),
    ] {
        let answer = get(&server, path, headers);
        assert!(
            answer.starts_with(&format!("HTTP/1.1 {status}")),
            "{path}: {answer}"
        );
    }
    let page = get(&server, "/?token=secret-8", "");
    assert!(page.contains(&format!(
        "taxel_token_{port}=secret-8; HttpOnly; SameSite=Strict"
    )));
    let mut stranger = view(&server, "?token=wrong");
    let message = stranger.read().unwrap();
    let Message::Close(Some(close)) = message else {
        panic!("{message:?}");
    };
    assert_eq!(u16::from(close.code), 4401);
    let mut viewer = view(&server, "?token=secret-8");
    text_of(&mut viewer, "hello");
    assert!(stage.asked.lock().unwrap().is_empty());
}

/// A page elsewhere, or a name elsewhere that leads here, can neither read nor control.
#[test]
fn other_pages_and_other_names_are_refused() {
    let (server, _) = start(None);
    let port = server.address().port();
    let upgrade = "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n\
                   Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";
    for (headers, status) in [
        ("Host: evil.example\r\n".to_owned(), "403"),
        (format!("Host: evil.example:{port}\r\n"), "403"),
        (format!("Host: localhost:{}\r\n", port ^ 1), "403"),
        (format!("Host: localhost:{port}\r\n"), "200"),
        (format!("Host: LOCALHOST:{port}\r\n"), "200"),
        (
            format!("Host: localhost:{port}\r\nOrigin: http://evil.example\r\n"),
            "403",
        ),
        (
            format!("Host: localhost:{port}\r\nOrigin: http://localhost:{port}\r\n"),
            "200",
        ),
        (format!("Host: localhost:{port}\r\nOrigin: null\r\n"), "403"),
    ] {
        let answer = get(&server, "/", &headers);
        assert!(
            answer.starts_with(&format!("HTTP/1.1 {status}")),
            "{headers}: {answer}"
        );
    }
    let headers = format!("{upgrade}Host: localhost:{port}\r\nOrigin: http://evil.example\r\n");
    let answer = ask(&server, &format!("GET /live HTTP/1.1\r\n{headers}\r\n"));
    assert!(answer.starts_with("HTTP/1.1 403"), "{answer}");
}

#[test]
fn no_path_leads_out_of_the_page_s_files() {
    let (server, _) = start(None);
    for path in [
        "/assets/../Cargo.toml",
        "/assets/%2e%2e/Cargo.toml",
        "/assets//etc/passwd",
        "/assets/js/../../Cargo.toml",
        "/recordings/x.mcap",
        "/assets/",
    ] {
        let answer = get(&server, path, "");
        assert!(answer.starts_with("HTTP/1.1 404"), "{path}: {answer}");
    }
    assert!(get(&server, "/assets/app.css", "").contains("text/css"));
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

#[test]
fn beyond_this_machine_only_with_a_token() {
    let options = Options {
        address: "0.0.0.0:0".to_owned(),
        token: None,
    };
    let error = Server::start(&options, Arc::new(Stage::default()))
        .err()
        .unwrap();
    assert_eq!(error.kind(), io::ErrorKind::PermissionDenied);
    assert_ne!(random_token(), random_token());
    assert_eq!(random_token().len(), 32);
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

/// Strangers that hold on to their connections give way to who knows the token.
#[test]
fn strangers_cannot_keep_viewers_out() {
    let (server, _) = start(Some("secret-8"));
    let host = server.address();
    let mut strangers = Vec::new();
    for turn in 0..120 {
        let mut stranger = TcpStream::connect(host).unwrap();
        // Some ask without the token and do not read, some say nothing at all.
        if turn % 2 == 0 {
            let request = format!("GET / HTTP/1.1\r\nHost: {host}\r\n\r\n");
            let _ = stranger.write_all(request.repeat(50).as_bytes());
        }
        strangers.push(stranger);
    }
    assert!(get(&server, "/?token=secret-8", "").starts_with("HTTP/1.1 200"));
    let mut viewer = view(&server, "?token=secret-8");
    text_of(&mut viewer, "hello");
    drop(strangers);
}

#[test]
fn whoever_is_refused_is_let_go_and_every_answer_is_guarded() {
    let (server, _) = start(Some("secret-8"));
    let host = server.address();
    for (path, status) in [
        ("/", "401"),
        ("/none?token=secret-8", "404"),
        ("/?token=secret-8", "200"),
    ] {
        let request = format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n");
        let mut stream = TcpStream::connect(host).unwrap();
        stream
            .set_read_timeout(Some(Duration::from_secs(20)))
            .unwrap();
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = [0; 512];
        let count = stream.read(&mut answer).unwrap();
        let answer = String::from_utf8_lossy(&answer[..count]).to_lowercase();
        assert!(
            answer.starts_with(&format!("http/1.1 {status}")),
            "{answer}"
        );
        assert!(
            answer.contains("x-content-type-options: nosniff"),
            "{answer}"
        );
        assert!(
            answer.contains("content-security-policy: default-src 'self'"),
            "{answer}"
        );
        assert_eq!(
            answer.contains("connection: close"),
            status != "200",
            "{answer}"
        );
    }
}

#[test]
fn tokens_that_protect_nothing_are_refused() {
    for (token, says) in [
        ("", "0 characters, expected 8"),
        ("x", "1 characters, expected 8"),
        ("a&b#c%d+", "has a '&'"),
        ("pass word", "has a ' '"),
        ("caf\u{e9}caf\u{e9}", "\\u{e9}"),
    ] {
        let options = Options {
            address: "127.0.0.1:0".to_owned(),
            token: Some(token.to_owned()),
        };
        let error = Server::start(&options, Arc::new(Stage::default()))
            .err()
            .unwrap();
        assert!(error.to_string().contains(says), "{token}: {error}");
    }
    assert_eq!(token_problem(&random_token()), None);
}

#[test]
fn a_server_everywhere_is_reached_by_real_addresses() {
    let options = Options {
        address: "0.0.0.0:0".to_owned(),
        token: Some("secret-8".to_owned()),
    };
    let server = Server::start(&options, Arc::new(Stage::default())).unwrap();
    let urls = server.urls();
    assert!(urls.iter().all(|url| !url.contains("0.0.0.0")), "{urls:?}");
    assert!(
        urls.last().unwrap().starts_with("http://127.0.0.1:"),
        "{urls:?}"
    );
}
