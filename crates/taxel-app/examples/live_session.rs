//! A live session without the command: `cargo run -p taxel-app --example live_session -- sim:econe?hand grip.mcap`.
//!
//! It records 300 frames with their loads, prints the force as it comes, and serves the page meanwhile.

use std::path::PathBuf;
use std::sync::mpsc;
use std::time::Duration;

use taxel_app::sensor_source;
use taxel_app::session::{RecordTopics, Session, SessionOptions};

const FRAMES: u64 = 300;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut words = std::env::args().skip(1);
    let address = words
        .next()
        .unwrap_or("sim:econe?hand".to_owned())
        .parse()?;
    let file = PathBuf::from(words.next().unwrap_or("grip.mcap".to_owned()));
    // A simulated sensor and a recording bring their sensor; for a device, name its file in the place of `None`.
    let (sensor, sensor_file) = sensor_source::of(&address, None)?;

    let (send, forces) = mpsc::channel();
    let mut options = SessionOptions::new(address, sensor, sensor_file);
    options.record = Some(file.clone());
    options.max_frames = Some(FRAMES);
    options.topics = RecordTopics {
        loads: true,
        figures: true,
        images: false,
    };
    options.observer = Some(Box::new(move |frame| {
        let _ = send.send(frame.figures.total_force_newtons);
    }));
    options.server = Some(taxel_server::Options::new("127.0.0.1:0"));

    let mut session = Session::start(options)?;
    println!("{}", session.urls().join(" "));
    while session
        .recording()
        .is_some_and(|recording| recording.frames < FRAMES)
    {
        if let Ok(newtons) = forces.recv_timeout(Duration::from_secs(1)) {
            println!("{newtons:.1} N");
        }
    }
    session.end();
    for saved in session.ended() {
        let missing = saved.missing().join("; ");
        println!(
            "{} frames in {} {missing}",
            saved.frames,
            saved.path.display()
        );
    }
    Ok(())
}
