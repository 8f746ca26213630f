//! Loads of a Taxel sensor as ROS 2 messages over DDS, without an installation of ROS.
//!
//! ```sh
//! taxel stream "serial:/dev/ttyACM0?baud=1000000" --sensor mine.toml | taxel-ros2
//! taxel-ros2 --listen 10          # in another terminal: what arrives, a line of JSON a message
//! ```
//!
//! | topic | message |
//! |---|---|
//! | `/taxel/loads/image` | `sensor_msgs/Image`, 32FC1: newtons, NaN where nothing was measured |
//! | `/taxel/force` | `geometry_msgs/WrenchStamped`: the sum of the loads along z, newtons |

mod messages;

use std::error::Error;
use std::io::{BufRead, Write};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use ros2_client::qos::{Durability, History, WhenFull};
use ros2_client::{
    Context, Message, MessageTypeName, Name, Node, NodeName, NodeOptions, Publisher, QosProfile,
    Subscription,
};
use serde::Deserialize;
use serde_json::json;

use messages::{Header, Image, Time, Vector3, Wrench, WrenchStamped};

const USAGE: &str = "taxel stream … | taxel-ros2 [--wait SECONDS]\ntaxel-ros2 --listen MESSAGES";
/// Whoever listens is given so long to be found before the first message, seconds.
const WAIT_SECS: f64 = 1.0;
/// A listener gives up after so long without any message.
const PATIENCE: Duration = Duration::from_secs(20);

/// A line of `taxel stream`.
#[derive(Deserialize)]
struct Line {
    unix_s: f64,
    total_n: Option<f64>,
    loads_n: Option<Vec<Vec<Option<f64>>>>,
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let done = match words[..] {
        [] => publish(WAIT_SECS),
        ["--wait", secs] => secs.parse().map_err(Into::into).and_then(publish),
        ["--listen", count] => count.parse().map_err(Into::into).and_then(listen),
        _ => {
            eprintln!("{USAGE}");
            return ExitCode::from(2);
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

type Outcome = Result<(), Box<dyn Error>>;

fn node(name: &str) -> Result<Node, Box<dyn Error>> {
    let name = format!("{name}_{}", std::process::id());
    let context = Context::new().map_err(|error| format!("no DDS: {error:?}"))?;
    let name = NodeName::new("/taxel", &name).map_err(|error| format!("{error:?}"))?;
    let node = context.new_node(name, NodeOptions::new());
    Ok(node.map_err(|error| format!("no node: {error:?}"))?)
}

/// The messages of a topic: its namespace and name, the package of their type, and the type.
type Kind = (&'static str, &'static str, &'static str, &'static str);

const LOADS: Kind = ("/taxel/loads", "image", "sensor_msgs", "Image");
const FORCE: Kind = ("/taxel", "force", "geometry_msgs", "WrenchStamped");

/// Makes a topic of a node, and of it a publisher or a subscription.
macro_rules! on_topic {
    ($node:expr, $kind:expr, $make:ident) => {{
        let (space, name, package, of) = $kind;
        let qos = QosProfile::publisher_default()
            .reliability_reliable(WhenFull::DEFAULT)
            .durability(Durability::Volatile)
            .history(History::KeepLast { depth: 10 });
        let full = Name::new(space, name).map_err(|error| format!("{error:?}"))?;
        let topic = $node
            .create_topic(&full, MessageTypeName::new(package, of), &qos)
            .map_err(|error| format!("topic {name}: {error:?}"))?;
        $node
            .$make(&topic, Some(qos))
            .map_err(|error| format!("topic {name}: {error:?}"))?
    }};
}

fn publisher<M: Message>(node: &mut Node, kind: Kind) -> Result<Publisher<M>, Box<dyn Error>> {
    Ok(on_topic!(node, kind, create_publisher))
}

fn subscription<M: Message + 'static>(
    node: &mut Node,
    kind: Kind,
) -> Result<Subscription<M>, Box<dyn Error>> {
    Ok(on_topic!(node, kind, create_subscription))
}

/// Lines of standard input as messages, until it ends.
fn publish(wait_secs: f64) -> Outcome {
    let mut node = node("stream")?;
    let loads = publisher::<Image>(&mut node, LOADS)?;
    let force = publisher::<WrenchStamped>(&mut node, FORCE)?;
    std::thread::sleep(Duration::try_from_secs_f64(wait_secs)?);
    let mut sent = 0u64;
    for (number, line) in std::io::stdin().lock().lines().enumerate() {
        let line: Line = serde_json::from_str(&line?).map_err(|error| {
            format!(
                "line {}: {error}; expected lines of `taxel stream`",
                number + 1
            )
        })?;
        let header = Header {
            stamp: Time::from_secs(line.unix_s),
            frame_id: "taxel".to_owned(),
        };
        if let Some(newtons) = line.total_n {
            let z = Vector3 {
                z: newtons,
                ..Vector3::default()
            };
            let wrench = Wrench {
                force: z,
                ..Wrench::default()
            };
            let message = WrenchStamped {
                header: header.clone(),
                wrench,
            };
            force
                .publish(message)
                .map_err(|error| format!("{error:?}"))?;
        }
        if let Some(rows) = &line.loads_n {
            let message = Image::of_loads(header, rows);
            loads
                .publish(message)
                .map_err(|error| format!("{error:?}"))?;
            sent += 1;
        }
    }
    // Those who ask for what they missed are still answered.
    std::thread::sleep(Duration::from_millis(500));
    eprintln!("{sent} images");
    Ok(())
}

/// What arrives, as lines of JSON, until so many images have.
fn listen(count: u64) -> Outcome {
    let mut node = node("listener")?;
    let loads = subscription::<Image>(&mut node, LOADS)?;
    let force = subscription::<WrenchStamped>(&mut node, FORCE)?;
    let mut out = std::io::stdout().lock();
    let (mut images, mut last) = (0, Instant::now());
    while images < count {
        let mut is_idle = true;
        while let Some((message, _)) = force.take().map_err(|error| format!("{error:?}"))? {
            let stamp = message.header.stamp;
            let line = json!({"topic": "/taxel/force", "sec": stamp.sec, "nanosec": stamp.nanosec, "z": message.wrench.force.z});
            writeln!(out, "{line}")?;
            is_idle = false;
        }
        while let Some((message, _)) = loads.take().map_err(|error| format!("{error:?}"))? {
            let stamp = message.header.stamp;
            let pixels: Vec<Option<f32>> = message
                .pixels()
                .map(|pixel| (!pixel.is_nan()).then_some(pixel))
                .collect();
            let line = json!({"topic": "/taxel/loads/image", "sec": stamp.sec, "nanosec": stamp.nanosec, "height": message.height, "width": message.width, "encoding": message.encoding, "newtons": pixels});
            writeln!(out, "{line}")?;
            images += 1;
            is_idle = false;
        }
        out.flush()?;
        if !is_idle {
            last = Instant::now();
        } else if last.elapsed() > PATIENCE {
            return Err(format!("{images} images, and none for {} s", PATIENCE.as_secs()).into());
        } else {
            std::thread::sleep(Duration::from_millis(5));
        }
    }
    Ok(())
}
