//! Where frames come from, in one line: the same syntax everywhere.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use taxel::simulate::Pattern;

use crate::Error;
use crate::protocol::Protocol;

/// A source of frames.
///
/// ```
/// use taxel_acquire::Address;
/// let address: Address = "serial:/dev/ttyACM0?baud=2000000".parse()?;
/// assert_eq!(address.to_string(), "serial:/dev/ttyACM0?baud=2000000");
/// # Ok::<(), taxel_acquire::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Address {
    /// `serial:PORT?baud=N&protocol=P`
    Serial {
        /// `/dev/ttyACM0`, `COM3`.
        port: String,
        /// Bits a second.
        baud: u32,
        /// What the device speaks.
        protocol: Protocol,
    },
    /// `udp:HOST:PORT?protocol=P`: listens there; a datagram is one packet or some lines.
    Udp {
        /// Own address and port.
        bind: String,
        /// What the device speaks.
        protocol: Protocol,
    },
    /// `tcp:HOST:PORT?protocol=P`: connects there.
    Tcp {
        /// The device's address and port.
        host: String,
        /// What the device speaks.
        protocol: Protocol,
    },
    /// `file:RECORDING?speed=S`, or the name of a recording alone: at its recorded speed, or S times faster.
    File {
        /// The recording.
        path: PathBuf,
        /// 1: as recorded; `None`: as fast as it can be read.
        speed: Option<f64>,
    },
    /// `stdin:?protocol=P`
    Stdin {
        /// What comes there.
        protocol: Protocol,
    },
    /// `rpi:BOARD.toml`: this machine's own pins and SPI, wired as the file says.
    Board {
        /// The board's description.
        path: PathBuf,
    },
    /// `sim:SENSOR?PATTERN&fps=N&seed=N`: a virtual sensor.
    Sim {
        /// A preset or a sensor file.
        sensor: String,
        /// Name of the load pattern.
        pattern: String,
        /// Frames a second; `None`: as many as can be.
        frames_per_second: Option<f64>,
        /// Of everything that is drawn.
        seed: u64,
    },
}

const KINDS: [&str; 7] = ["serial", "udp", "tcp", "file", "stdin", "sim", "rpi"];
const HINT: &str = "serial:/dev/ttyACM0?baud=2000000, udp:0.0.0.0:9000, tcp:host:port, file:run.mcap, stdin:, \
                    sim:econe?hand";
const DEFAULT_BAUD: u32 = 115_200;
/// Slower than that a frame's time is beyond every clock.
const PACES: std::ops::RangeInclusive<f64> = 1e-3..=1e9;

/// The options behind the question mark.
struct Options<'a> {
    text: &'a str,
    left: Vec<(&'a str, &'a str)>,
}

impl<'a> Options<'a> {
    fn error(&self, reason: String, hint: &str) -> Error {
        Error::Address {
            text: self.text.to_owned(),
            reason,
            hint: hint.to_owned(),
        }
    }

    /// Refuses an address that does not name the place.
    fn needs(&self, place: &str, what: &str) -> Result<(), Error> {
        if place.is_empty() {
            return Err(self.error(format!("it names no {what}"), HINT));
        }
        Ok(())
    }

    fn take(&mut self, key: &str) -> Option<&'a str> {
        let at = self.left.iter().position(|(k, _)| *k == key)?;
        Some(self.left.remove(at).1)
    }

    fn number<T: FromStr>(&mut self, key: &str) -> Result<Option<T>, Error> {
        match self.take(key) {
            None => Ok(None),
            Some(value) => value.parse().map(Some).map_err(|_| {
                self.error(format!("{key}={value} is no number"), &format!("{key}=N"))
            }),
        }
    }

    /// A positive number, or `max` for none.
    fn pace(&mut self, key: &str, usual: f64) -> Result<Option<f64>, Error> {
        match self.take(key) {
            None => Ok(Some(usual)),
            Some("max") => Ok(None),
            Some(value) => match value.parse() {
                Ok(pace) if PACES.contains(&pace) => Ok(Some(pace)),
                _ => Err(self.error(
                    format!("{key}={value} is no pace"),
                    &format!(
                        "a number from {} to {}, or {key}=max",
                        PACES.start(),
                        PACES.end()
                    ),
                )),
            },
        }
    }

    /// What a stream of bytes speaks.
    fn stream_protocol(&mut self) -> Result<Protocol, Error> {
        let protocol = self.protocol()?;
        if protocol.needs_datagrams() {
            let reason =
                "that protocol comes in datagrams, of which nothing in a stream tells the ends";
            return Err(self.error(reason.to_owned(), "udp:0.0.0.0:8999?protocol=insole-udp"));
        }
        Ok(protocol)
    }

    fn protocol(&mut self) -> Result<Protocol, Error> {
        let Some(name) = self.take("protocol") else {
            return Ok(Protocol::Auto);
        };
        match Protocol::NAMES.iter().find(|(n, _)| *n == name) {
            Some((_, protocol)) => Ok(*protocol),
            None => {
                let names = Protocol::NAMES.map(|(name, _)| name).join(", ");
                Err(self.error(format!("no protocol is called {name}"), &names))
            }
        }
    }

    fn done(&self, known: &[&str]) -> Result<(), Error> {
        match self.left.first() {
            None => Ok(()),
            Some((key, _)) => Err(self.error(
                format!("nothing here is called {key}"),
                &match nearest(key, known) {
                    Some(near) => format!("did you mean {near}?"),
                    None => format!("known: {}", known.join(", ")),
                },
            )),
        }
    }
}

fn nearest<'a>(word: &str, known: &[&'a str]) -> Option<&'a str> {
    known
        .iter()
        .copied()
        .map(|k| (strsim::damerau_levenshtein(word, k), k))
        .filter(|(distance, k)| *distance <= 1 + k.len() / 3)
        .min()
        .map(|(_, k)| k)
}

impl FromStr for Address {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let (kind, rest) = match text.split_once(':') {
            // A drive letter is no kind, and a name without a kind is a recording.
            Some((kind, rest)) if kind.len() > 1 => (kind, rest),
            _ if text.contains('.') || text.contains('/') => ("file", text),
            _ => ("", text),
        };
        let (place, options) = rest.split_once('?').unwrap_or((rest, ""));
        let mut options = Options {
            text,
            left: options
                .split('&')
                .filter(|part| !part.is_empty())
                .map(|part| part.split_once('=').unwrap_or((part, "")))
                .collect(),
        };
        match kind {
            "serial" => serial(place, options),
            "udp" | "tcp" => network(kind, place, options),
            "file" => {
                options.needs(place, "recording")?;
                let speed = options.pace("speed", 1.0)?;
                options.done(&["speed"])?;
                let path = place.into();
                Ok(Self::File { path, speed })
            }
            "rpi" => {
                options.needs(place, "board file")?;
                options.done(&[])?;
                Ok(Self::Board { path: place.into() })
            }
            "stdin" => {
                let protocol = options.stream_protocol()?;
                options.done(&["protocol"])?;
                Ok(Self::Stdin { protocol })
            }
            "sim" => simulated(place, options),
            _ => {
                let hint = match nearest(kind, &KINDS) {
                    Some(near) if !kind.is_empty() => format!("did you mean {near}:?"),
                    _ => HINT.to_owned(),
                };
                let reason = format!("expected {}:", KINDS.join(":, "));
                Err(options.error(reason, &hint))
            }
        }
    }
}

fn serial(place: &str, mut options: Options) -> Result<Address, Error> {
    options.needs(place, "port")?;
    let baud = options.number("baud")?.unwrap_or(DEFAULT_BAUD);
    let protocol = options.stream_protocol()?;
    options.done(&["baud", "protocol"])?;
    Ok(Address::Serial {
        port: place.to_owned(),
        baud,
        protocol,
    })
}

/// `udp:` and `tcp:`.
fn network(kind: &str, place: &str, mut options: Options) -> Result<Address, Error> {
    let port = place.rsplit_once(':').map(|(_, port)| port.parse::<u16>());
    if !matches!(port, Some(Ok(_))) {
        let hint = format!("{kind}:host:port, such as {kind}:0.0.0.0:9000");
        return Err(options.error("it has no port number".to_owned(), &hint));
    }
    let protocol = if kind == "udp" {
        options.protocol()?
    } else {
        options.stream_protocol()?
    };
    options.done(&["protocol"])?;
    let place = place.to_owned();
    Ok(if kind == "udp" {
        Address::Udp {
            bind: place,
            protocol,
        }
    } else {
        Address::Tcp {
            host: place,
            protocol,
        }
    })
}

fn simulated(place: &str, mut options: Options) -> Result<Address, Error> {
    options.needs(place, "sensor")?;
    let bare = options.left.iter().position(|(_, value)| value.is_empty());
    let pattern = bare.map_or("hand", |at| options.left.remove(at).0);
    if Pattern::named(pattern).is_none() {
        let hint = match nearest(pattern, &Pattern::NAMES) {
            Some(near) => format!("did you mean {near}?"),
            None => Pattern::NAMES.join(", "),
        };
        return Err(options.error(format!("no pattern is called {pattern}"), &hint));
    }
    let frames_per_second = options.pace("fps", 100.0)?;
    let seed = options.number("seed")?.unwrap_or(1);
    options.done(&["fps", "seed"])?;
    Ok(Address::Sim {
        sensor: place.to_owned(),
        pattern: pattern.to_owned(),
        frames_per_second,
        seed,
    })
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let speaks = |protocol: &Protocol, sign: char| match protocol {
            Protocol::Auto => String::new(),
            _ => {
                let (name, _) = Protocol::NAMES
                    .iter()
                    .find(|(_, p)| p == protocol)
                    .expect("every protocol has a name");
                format!("{sign}protocol={name}")
            }
        };
        let pace = |pace: &Option<f64>| pace.map_or("max".to_owned(), |pace| pace.to_string());
        match self {
            Self::Serial {
                port,
                baud,
                protocol,
            } => write!(f, "serial:{port}?baud={baud}{}", speaks(protocol, '&')),
            Self::Udp { bind, protocol } => write!(f, "udp:{bind}{}", speaks(protocol, '?')),
            Self::Tcp { host, protocol } => write!(f, "tcp:{host}{}", speaks(protocol, '?')),
            Self::File { path, speed } => match speed {
                Some(1.0) => write!(f, "file:{}", path.display()),
                speed => write!(f, "file:{}?speed={}", path.display(), pace(speed)),
            },
            Self::Board { path } => write!(f, "rpi:{}", path.display()),
            Self::Stdin { protocol } => write!(f, "stdin:{}", speaks(protocol, '?')),
            Self::Sim {
                sensor,
                pattern,
                frames_per_second,
                seed,
            } => write!(
                f,
                "sim:{sensor}?{pattern}&fps={}&seed={seed}",
                pace(frames_per_second)
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_come_back_as_they_were_written() {
        for text in [
            "serial:/dev/ttyACM0?baud=2000000",
            "serial:COM3?baud=115200&protocol=lines",
            "udp:0.0.0.0:9000",
            "udp:[::1]:9000?protocol=taxel-1",
            "tcp:mat.local:7000",
            "file:a folder/run.mcap",
            "file:run.txt?speed=0.5",
            "file:run.txt?speed=max",
            "stdin:?protocol=econe-text",
            "serial:COM3?baud=2000000&protocol=flexitac",
            "udp:0.0.0.0:8999?protocol=insole-udp-right",
            "rpi:board.toml",
            "sim:econe?hand&fps=100&seed=1",
            "sim:mine.toml?feet&fps=max&seed=4",
        ] {
            let address: Address = text.parse().unwrap();
            assert_eq!(address.to_string(), text);
        }
        let short: Address = "sim:econe?hand".parse().unwrap();
        assert_eq!(short, "sim:econe".parse().unwrap());
        let bare: Address = "recordings/run.mcap".parse().unwrap();
        assert!(matches!(
            bare,
            Address::File {
                speed: Some(1.0),
                ..
            }
        ));
        assert!(matches!("C:/run.mcap".parse(), Ok(Address::File { .. })));
    }

    #[test]
    fn what_is_wrong_is_said_with_what_would_do() {
        for (text, says) in [
            ("serail:/dev/ttyACM0", "did you mean serial:?"),
            ("econe", "sim:econe?hand"),
            ("serial:", "it names no port"),
            ("serial:/dev/x?boud=9600", "did you mean baud?"),
            ("serial:/dev/x?baud=fast", "baud=fast is no number"),
            ("udp:9000", "it has no port number"),
            ("tcp:host:99999", "it has no port number"),
            ("sim:econe?hnad", "did you mean hand?"),
            ("sim:econe?fps=0", "fps=0 is no pace"),
            ("file:x.txt?speed=1e-300", "from 0.001 to"),
            ("stdin:?protocol=taxel1", "auto, taxel-1, lines, econe-text"),
            ("tcp:host:80?protocol=insole-udp-left", "comes in datagrams"),
        ] {
            let error = text.parse::<Address>().unwrap_err().to_string();
            assert!(error.contains(says), "{text}: {error}");
        }
    }
}
