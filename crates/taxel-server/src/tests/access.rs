//! Who gets in, and to what.

use super::*;

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
fn beyond_this_machine_only_with_a_token() {
    let options = Options::new("0.0.0.0:0");
    let error = Server::start(&options, Arc::new(Stage::default()))
        .err()
        .unwrap();
    assert_eq!(error.kind(), io::ErrorKind::PermissionDenied);
    assert_ne!(random_token(), random_token());
    assert_eq!(random_token().len(), 32);
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
            token: Some(token.to_owned()),
            ..Options::new("127.0.0.1:0")
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
        token: Some("secret-8".to_owned()),
        ..Options::new("0.0.0.0:0")
    };
    let server = Server::start(&options, Arc::new(Stage::default())).unwrap();
    let urls = server.urls();
    assert!(urls.iter().all(|url| !url.contains("0.0.0.0")), "{urls:?}");
    assert!(
        urls.last().unwrap().starts_with("http://127.0.0.1:"),
        "{urls:?}"
    );
}
