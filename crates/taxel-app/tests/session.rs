//! A live session as a program of one's own runs it.

use std::net::TcpListener;

use taxel::sensor::preset;
use taxel_app::Error;
use taxel_app::session::{Session, SessionOptions};

#[test]
fn a_session_that_cannot_begin_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("there.mcap");
    std::fs::write(&file, "somebody's").unwrap();
    let free = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = free.local_addr().unwrap();
    drop(free);

    let sensor = preset("mat-16x16-cd4067").unwrap();
    let source = "sim:mat-16x16-cd4067".parse().unwrap();
    let mut options = SessionOptions::new(source, sensor, "mat");
    options.server = Some(taxel_server::Options::new(address.to_string()));
    options.record = Some(file.clone());
    let refused = Session::start(options);
    assert!(matches!(refused.err(), Some(Error::RecordingExists { .. })));
    assert_eq!(std::fs::read(&file).unwrap(), b"somebody's");
    // Its page is gone: another session may have the address.
    TcpListener::bind(address).expect("a free port");
}
