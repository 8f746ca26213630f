//! A small computer reads and records, a larger one compensates: counts over the network.

use std::io::{BufRead, BufReader, Read};
use std::net::{TcpStream, UdpSocket};
use std::time::{Duration, Instant};

use crate::live::{Running, wait};
use crate::run::Folder;

#[test]
fn counts_go_to_another_computer_and_are_recorded_on_both() {
    let folder = Folder::new();
    let words = "record udp:127.0.0.1:0 --sensor sensor.toml -o laptop.mcap --frames 20 --loads";
    let mut laptop = Running::start(&folder, words);
    let (place, _said) = laptop.place();
    let pi = folder.good(&format!(
        "stream sim:sensor.toml?hand&fps=100 --counts --to {place} --record pi.mcap --frames 40"
    ));
    assert!(pi.err.contains("40 packets, 0 frames"), "{pi}");
    wait("the laptop's end", || {
        laptop.child.try_wait().unwrap().is_some()
    });
    for name in ["pi", "laptop"] {
        folder.good(&format!("convert {name}.mcap -o {name}.txt"));
    }
    let (pi, laptop) = (folder.numbers("pi.txt"), folder.numbers("laptop.txt"));
    assert_eq!(laptop.len(), 24 * 20);
    assert!(pi.len() >= 24 * 40, "{}", pi.len() / 24);
    // The same frames, from the first that was heard on.
    let first = &laptop[..24];
    let from = pi.chunks(24).position(|frame| frame == first).unwrap();
    assert_eq!(pi[24 * from..24 * from + laptop.len()], laptop);
}

/// Each takes longer than `stream` asks whether the source has ended.
#[test]
fn frames_that_are_solved_after_the_source_has_ended_are_sent_too() {
    let folder = Folder::new();
    let mat = taxel::sensor::preset("mat-32x32-adg732").unwrap();
    let text = mat.to_toml().replace("s = 32\n", "s = 48\n");
    let lines = "[readout]\nr_line_row_ohms = 10.0\nr_line_column_ohms = 10.0\n";
    folder.write("slow.toml", &text.replace("[readout]\n", lines));
    folder.good("simulate --sensor slow.toml --pattern blobs --frames 6 --seed 2 -o blobs.npy");
    let sent = folder.good("stream file:blobs.npy?speed=max --sensor slow.toml");
    assert_eq!(sent.out.lines().count(), 6, "{sent}");
}

#[test]
fn who_connects_gets_the_counts_and_who_connects_again_as_well() {
    let folder = Folder::new();
    let words =
        "stream sim:sensor.toml?hand&fps=50 --counts --to listen:127.0.0.1:0 --record pi.mcap";
    let mut pi = Running::start(&folder, words);
    let mut said = BufReader::new(pi.child.stderr.take().unwrap()).lines();
    let place = said.find_map(|line| {
        let line = line.unwrap();
        line.strip_prefix("waiting at ").map(str::to_owned)
    });
    let place = place.unwrap();
    for _ in 0..2 {
        let mut link = TcpStream::connect(&place).unwrap();
        let patience = Some(Duration::from_secs(20));
        link.set_read_timeout(patience).unwrap();
        let mut bytes = [0; 200];
        link.read_exact(&mut bytes).unwrap();
        assert!(bytes.contains(&0), "packets end with a zero byte");
    }
    let mut taken = Running::start(
        &folder,
        &format!("record tcp:{place} --sensor sensor.toml -o laptop.mcap --frames 10"),
    );
    wait("ten frames", || taken.child.try_wait().unwrap().is_some());
    folder.good("convert laptop.mcap -o laptop.txt");
    assert_eq!(folder.numbers("laptop.txt").len(), 24 * 10);
    // What was recorded until now is in the file when as much again is: the last half second is not.
    let size = || std::fs::metadata(folder.path("pi.mcap")).unwrap().len();
    let before = size();
    wait("more on the Pi", || size() >= before + 8_000);
    drop(pi);
    folder.taxel("recover pi.mcap -o whole.mcap");
    // From the first frame on, though nobody was there to take it.
    folder.good("convert whole.mcap -o whole.txt");
    assert!(folder.numbers("whole.txt").len() > 24 * 10);
}

#[test]
fn times_of_a_device_without_a_clock_only_run() {
    let (folder, begun) = (Folder::new(), Instant::now());
    let mut laptop = Running::start(
        &folder,
        "record udp:127.0.0.1:0 --sensor sensor.toml -o run.mcap --frames 3",
    );
    let (place, _said) = laptop.place();
    let device = UdpSocket::bind("127.0.0.1:0").unwrap();
    let row = "30,31,32,33,34,35,\n";
    for _ in 0..3 {
        device
            .send_to(
                row.repeat(4).as_bytes(),
                place.strip_prefix("udp:").unwrap(),
            )
            .unwrap();
        std::thread::sleep(Duration::from_millis(100));
    }
    wait("the end", || laptop.child.try_wait().unwrap().is_some());
    let info = folder.good("info run.mcap");
    let told = info.out.lines().find(|line| line.contains("frames/s"));
    let secs: f64 = told
        .unwrap()
        .trim()
        .split(' ')
        .next()
        .unwrap()
        .parse()
        .unwrap();
    // They are there, and of this run: how far apart depends on how busy the machine is.
    assert!(secs > 0.0 && begun.elapsed().as_secs_f64() > secs, "{info}");
}

#[test]
fn what_cannot_be_sent_to_is_said() {
    let folder = Folder::new();
    for (words, says) in [
        (
            "stream sim:sensor.toml --counts --to listen:nowhere",
            "--to listen:nowhere",
        ),
        (
            "stream sim:sensor.toml --counts --sums",
            "cannot be used with",
        ),
        ("stream sim:sensor.toml --counts --record run.txt", ".mcap"),
    ] {
        let run = folder.taxel(words);
        assert_eq!(run.code, Some(2), "{run}");
        assert!(run.err.contains(says), "{words}: {run}");
    }
}
