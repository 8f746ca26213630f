//! Frames for Foxglove, live, by the real binary; what they hold is compared by `.ci/reference-readers`.
#![cfg(feature = "foxglove")]

use std::io::{BufRead, BufReader};

use serde_json::{Value, json};
use tungstenite::Message;
use tungstenite::client::IntoClientRequest;
use tungstenite::http::HeaderValue;

use crate::live::{Running, Viewer};
use crate::run::Folder;

#[test]
fn every_topic_is_served_in_foxglove_s_own_protocol() {
    let folder = Folder::new();
    let mut running = Running::start(
        &folder,
        "live sim:sensor.toml?uniform --listen=127.0.0.1:0 --foxglove=127.0.0.1:0",
    );
    let said = BufReader::new(running.child.stderr.take().unwrap()).lines();
    let mut urls = said.map_while(Result::ok).filter_map(|line| {
        line.strip_prefix("Foxglove connects to ")
            .map(str::to_owned)
    });
    let mut client = connect(&urls.next().unwrap());
    let channels = loop {
        if let Some(channels) = text(&mut client)["channels"].as_array() {
            break channels.clone();
        }
    };
    let mut topics: Vec<&str> = channels
        .iter()
        .map(|channel| channel["topic"].as_str().unwrap())
        .collect();
    topics.sort_unstable();
    assert_eq!(
        topics,
        ["/taxel/figures", "/taxel/loads", "/taxel/loads/image"]
    );
    let figures = channels
        .iter()
        .find(|channel| channel["topic"] == "/taxel/figures")
        .unwrap();
    assert_eq!(figures["encoding"], "json");
    let wanted =
        json!({"op": "subscribe", "subscriptions": [{"id": 7, "channelId": figures["id"]}]});
    client.send(Message::text(wanted.to_string())).unwrap();
    let figures = loop {
        if let Message::Binary(bytes) = client.read().unwrap() {
            assert_eq!(bytes[..5], [1, 7, 0, 0, 0]);
            break serde_json::from_slice::<Value>(&bytes[13..]).unwrap();
        }
    };
    assert!(figures["total_force_newtons"].as_f64().unwrap() > 0.0);
    assert_eq!(figures["measured_share"], 1.0);
}

/// The next text, as JSON.
fn text(client: &mut Viewer) -> Value {
    loop {
        if let Message::Text(text) = client.read().unwrap() {
            return serde_json::from_str(&text).unwrap();
        }
    }
}

fn connect(url: &str) -> Viewer {
    let mut request = url.into_client_request().unwrap();
    request.headers_mut().insert(
        "Sec-WebSocket-Protocol",
        HeaderValue::from_static("foxglove.sdk.v1"),
    );
    tungstenite::connect(request).unwrap().0
}

#[test]
fn an_address_that_is_none_or_taken_is_an_error() {
    let folder = Folder::new();
    let live = "live sim:sensor.toml?uniform --listen=127.0.0.1:0";
    let run = folder.fails(&format!("{live} --foxglove=8765"));
    assert!(
        run.err
            .contains("expected HOST:PORT, such as 127.0.0.1:8765"),
        "{run}"
    );
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap();
    let run = folder.fails(&format!("{live} --foxglove={address}"));
    assert!(run.err.contains(&address.to_string()), "{run}");
}
