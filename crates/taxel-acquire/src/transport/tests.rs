//! Real sockets and a real pseudo-terminal, broken on purpose.

use std::io::Write;
use std::net::{TcpListener, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use super::*;
use crate::protocol::taxel1::{Header, encode};
use crate::protocol::{Expected, Protocol};

const EXPECTED: Expected = Expected {
    rows: 4,
    columns: 6,
    max_count: 4095,
    absent: Vec::new(),
};

#[derive(Default)]
struct Heard {
    sequences: Vec<u64>,
    states: Vec<(State, String)>,
    link_stats: LinkStats,
}

#[derive(Clone, Default)]
struct Ear {
    heard: Arc<Mutex<Heard>>,
    stop: Arc<AtomicBool>,
}

impl Receiver for Ear {
    fn frame(&mut self, frame: &Frame<Counts>, _: SystemTime) {
        self.heard.lock().unwrap().sequences.push(frame.sequence);
    }
    fn state(&mut self, state: State, text: &str) {
        let mut heard = self.heard.lock().unwrap();
        heard.states.push((state, text.to_owned()));
    }
    fn link_stats(&mut self, link_stats: LinkStats) {
        self.heard.lock().unwrap().link_stats = link_stats;
    }
    fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

impl Ear {
    /// Listens on a thread of its own until `enough`, then stops.
    fn listen(&self, address: Address) -> std::thread::JoinHandle<()> {
        let mut ear = self.clone();
        std::thread::spawn(move || {
            let mut decoder = Protocol::Taxel1.decoder(EXPECTED);
            receive(&address, &mut *decoder, &mut ear);
        })
    }

    /// The socket that was opened for `udp:HOST:0`.
    fn port(&self) -> std::net::SocketAddr {
        self.wait("an open socket", |heard| !heard.states.is_empty());
        let heard = self.heard.lock().unwrap();
        let (_, text) = &heard.states[0];
        let place = text.strip_suffix(" is open, nothing yet").unwrap();
        place.strip_prefix("udp:").unwrap().parse().unwrap()
    }

    fn wait(&self, what: &str, enough: impl Fn(&Heard) -> bool) {
        let begun = Instant::now();
        while !enough(&self.heard.lock().unwrap()) {
            assert!(begun.elapsed() < Duration::from_secs(20), "no {what}");
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

fn packet(sequence: u32) -> Vec<u8> {
    let values = (0..24).map(|i| f64::from(i + sequence)).collect();
    let header = Header {
        bits: 12,
        sensor_id: 1,
        sequence,
        time_us: 0,
    };
    let mut bytes = Vec::new();
    encode(&Frame::new(4, 6, values).unwrap(), &header, &mut bytes);
    bytes
}

#[test]
fn a_device_that_goes_away_is_heard_again_when_it_comes_back() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let ear = Ear::default();
    let thread = ear.listen(format!("tcp:{address}").parse().unwrap());
    let (mut device, _) = listener.accept().unwrap();
    device
        .write_all(&[packet(0), packet(1), packet(2)[..20].to_vec()].concat())
        .unwrap();
    ear.wait("frames", |heard| heard.sequences == [0, 1]);
    drop(device);
    ear.wait("loss", |heard| {
        heard
            .states
            .iter()
            .any(|(state, text)| *state == State::Lost && text.contains("trying again in 0.2"))
    });
    let (mut device, _) = listener.accept().unwrap();
    device.write_all(&[packet(7), packet(8)].concat()).unwrap();
    ear.wait("frames", |heard| heard.sequences == [0, 1, 7, 8]);
    ear.stop.store(true, Ordering::Relaxed);
    thread.join().unwrap();
    // What the last tally says is said at the end, too: half a frame was broken, the device was away once.
    let link_stats = ear.heard.lock().unwrap().link_stats;
    assert_eq!(
        (link_stats.lost, link_stats.corrupt, link_stats.outages),
        (5, 1, 1)
    );
}

/// A network that goes down says nothing: the connection stays open on this side, and nothing will ever come through it.
#[test]
fn a_connection_that_falls_silent_is_opened_again() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let ear = Ear::default();
    let thread = ear.listen(format!("tcp:{address}").parse().unwrap());
    let (mut silent, _) = listener.accept().unwrap();
    silent.write_all(&packet(0)).unwrap();
    ear.wait("a frame", |heard| heard.sequences == [0]);
    let (mut device, _) = listener.accept().unwrap();
    ear.wait("the reason", |heard| {
        let mut states = heard.states.iter();
        states.any(|(state, text)| *state == State::Lost && text.contains("nothing has come for"))
    });
    device.write_all(&packet(4)).unwrap();
    ear.wait("frames", |heard| heard.sequences == [0, 4]);
    ear.stop.store(true, Ordering::Relaxed);
    thread.join().unwrap();
    let link_stats = ear.heard.lock().unwrap().link_stats;
    assert_eq!((link_stats.lost, link_stats.outages), (3, 1));
    drop(silent);
}

#[test]
fn datagrams_are_received_and_a_stranger_s_are_counted_as_corrupt() {
    let ear = Ear::default();
    let thread = ear.listen("udp:127.0.0.1:0".parse().unwrap());
    let port = ear.port();
    let device = UdpSocket::bind("127.0.0.1:0").unwrap();
    for sequence in 0..5 {
        device.send_to(&packet(sequence), port).unwrap();
    }
    device.send_to(b"\0hello there\0", port).unwrap();
    device.send_to(&packet(5), port).unwrap();
    ear.wait("frames", |heard| heard.sequences == [0, 1, 2, 3, 4, 5]);
    ear.wait("tally", |heard| heard.link_stats.corrupt == 1);
    ear.wait("words", |heard| {
        heard.states.last().unwrap().0 == State::Live
    });
    ear.wait("silence", |heard| {
        heard.states.last().unwrap().0 == State::Waiting
    });
    ear.stop.store(true, Ordering::Relaxed);
    thread.join().unwrap();
}

/// Only Linux tells the name of a pseudo-terminal this way.
#[cfg(target_os = "linux")]
#[test]
fn a_serial_line_is_read() {
    let (device, port) = serial2::SerialPort::pair().unwrap();
    let descriptor = std::os::fd::AsRawFd::as_raw_fd(&port);
    let name = std::fs::read_link(format!("/proc/self/fd/{descriptor}")).unwrap();
    let ear = Ear::default();
    let address = format!("serial:{}?baud=2000000", name.display());
    let thread = ear.listen(address.parse().unwrap());
    ear.wait("an open port", |heard| !heard.states.is_empty());
    for sequence in 0..3 {
        device.write_all(&packet(sequence)).unwrap();
    }
    ear.wait("frames", |heard| heard.sequences == [0, 1, 2]);
    // Both ends gone: unplugged.
    drop(port);
    drop(device);
    ear.wait("loss", |heard| {
        heard.states.last().unwrap().0 == State::Lost
    });
    ear.stop.store(true, Ordering::Relaxed);
    thread.join().unwrap();
}

#[test]
fn a_port_that_is_not_there_is_tried_again_and_named() {
    let ear = Ear::default();
    let thread = ear.listen("serial:/dev/no-such-port?baud=9600".parse().unwrap());
    ear.wait("attempts", |heard| heard.states.len() >= 3);
    ear.stop.store(true, Ordering::Relaxed);
    thread.join().unwrap();
    let heard = ear.heard.lock().unwrap();
    assert!(heard.states.iter().all(|(state, _)| *state == State::Lost));
    assert!(heard.states[0].1.contains("/dev/no-such-port"));
    assert!(heard.states[2].1.contains("trying again in 1.0 s"));
}

/// Two devices on one port: the first whose datagrams make frames is heard, the other counted.
#[test]
fn datagrams_of_one_sender_are_taken() {
    let ear = Ear::default();
    let thread = ear.listen("udp:127.0.0.1:0".parse().unwrap());
    let port = ear.port();
    let [device, other] = [(); 2].map(|()| UdpSocket::bind("127.0.0.1:0").unwrap());
    device.send_to(&packet(0), port).unwrap();
    ear.wait("the first frame", |heard| heard.sequences == [0]);
    for sequence in 1..6 {
        other.send_to(&packet(100 + sequence), port).unwrap();
        device.send_to(&packet(sequence), port).unwrap();
    }
    ear.wait("frames", |heard| heard.sequences == [0, 1, 2, 3, 4, 5]);
    ear.wait("strangers", |heard| {
        heard.link_stats.strangers == 5 && heard.link_stats.repeated == 0
    });
    ear.wait("words", |heard| {
        heard
            .states
            .iter()
            .any(|(_, text)| text.contains("other senders"))
    });
    // Silent, it gives way; and coming back to frames after a silence is an outage.
    ear.wait("silence", |heard| {
        heard.states.last().unwrap().0 == State::Waiting
    });
    other.send_to(&packet(200), port).unwrap();
    ear.wait("the other", |heard| {
        heard.sequences.len() == 7 && heard.link_stats.outages == 1
    });
    ear.stop.store(true, Ordering::Relaxed);
    thread.join().unwrap();
}
