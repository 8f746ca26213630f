//! Where frames are sent to: a pipe, datagrams, a connection, whoever connects.

use std::io::{self, Write};
use std::net::{SocketAddr, TcpListener, TcpStream, UdpSocket};
use std::time::Duration;

use taxel::Sensor;

use crate::error::Error;

/// The largest datagram: a frame beyond it must go another way.
const MAX_DATAGRAM: usize = 65_507;

/// One that takes nothing for this long is gone: a network that is down says nothing.
const PATIENCE: Duration = Duration::from_secs(5);

/// Bits of a count in packets of protocol taxel-1.
pub(crate) fn packet_bits(sensor: &Sensor) -> u8 {
    match sensor.converter().bits {
        0..=8 => 8,
        9..=10 => 10,
        11..=12 => 12,
        _ => 16,
    }
}

/// One computer at a time that has connected: the newest, since an older one may be gone without a word.
pub(crate) struct Listening {
    listener: TcpListener,
    to: Option<(TcpStream, SocketAddr)>,
    missed: u64,
    news: Vec<String>,
}

impl Listening {
    fn open(address: &str) -> io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        let news = vec![format!("waiting at {}", listener.local_addr()?)];
        Ok(Self {
            listener,
            to: None,
            missed: 0,
            news,
        })
    }

    /// Takes whoever has come since.
    fn accept(&mut self) {
        while let Ok((stream, from)) = self.listener.accept() {
            let ready = stream
                .set_nonblocking(false)
                .and_then(|()| stream.set_nodelay(true))
                .and_then(|()| stream.set_write_timeout(Some(PATIENCE)));
            if ready.is_ok() {
                self.news.push(format!("{from} has connected"));
                self.to = Some((stream, from));
            }
        }
    }

    /// Whether somebody took it. A part of a frame that went before the connection broke is the receiver's to leave out.
    fn send(&mut self, bytes: &[u8]) -> bool {
        self.accept();
        let Some((stream, from)) = &mut self.to else {
            self.missed += 1;
            return false;
        };
        if let Err(why) = stream.write_all(bytes) {
            self.news.push(format!("{from} is gone: {why}"));
            self.to = None;
            self.missed += 1;
            return false;
        }
        true
    }
}

/// An open way.
pub(crate) enum Out {
    /// To whoever listens.
    Udp(UdpSocket),
    /// To who has answered.
    Tcp(TcpStream),
    /// To whoever connects.
    Listening(Listening),
    /// To standard output.
    Standard(io::Stdout),
}

impl Out {
    /// Opens `udp:HOST:PORT`, `tcp:HOST:PORT`, `listen:HOST:PORT` or `-`, of the option `--to`.
    pub(crate) fn open(to: &str) -> Result<Self, Error> {
        if to == "-" {
            return Ok(Self::Standard(io::stdout()));
        }
        let failed = |source: io::Error| Error::Arguments {
            what: format!("--to {to}: {source}"),
            hint: "HOST:PORT of the computer that receives; udp:127.0.0.1:9000, tcp:127.0.0.1:9000",
        };
        if let Some(address) = to.strip_prefix("tcp:") {
            return TcpStream::connect(address).map(Self::Tcp).map_err(failed);
        }
        if let Some(address) = to.strip_prefix("listen:") {
            return Listening::open(address)
                .map(Self::Listening)
                .map_err(|source| Error::Arguments {
                    what: format!("--to {to}: {source}"),
                    hint: "an address of this computer and a free port; listen:0.0.0.0:9000 for all that it has",
                });
        }
        let Some(address) = to.strip_prefix("udp:") else {
            return Err(Error::Arguments {
                what: format!(
                    "--to {to}: neither udp:HOST:PORT, tcp:HOST:PORT, listen:HOST:PORT nor -"
                ),
                hint: "udp:127.0.0.1:9000",
            });
        };
        let socket = UdpSocket::bind("0.0.0.0:0").map_err(failed)?;
        socket.connect(address).map_err(failed)?;
        Ok(Self::Udp(socket))
    }

    /// Frames that nobody was there to take.
    pub(crate) fn missed(&self) -> u64 {
        match self {
            Out::Listening(listening) => listening.missed,
            _ => 0,
        }
    }

    /// Who has come and gone, in words.
    pub(crate) fn take_news(&mut self) -> Vec<String> {
        match self {
            Out::Listening(listening) => {
                listening.accept();
                std::mem::take(&mut listening.news)
            }
            _ => Vec::new(),
        }
    }

    /// Sends a frame as a whole; whether there was somebody to send it to.
    pub(crate) fn send(&mut self, bytes: &[u8]) -> Result<bool, Error> {
        match self {
            Out::Udp(_) if bytes.len() > MAX_DATAGRAM => Err(Error::Arguments {
                what: format!(
                    "a frame of {} bytes does not fit a datagram of {MAX_DATAGRAM}",
                    bytes.len()
                ),
                hint: "--to - and a pipe, or tcp:HOST:PORT",
            }),
            Out::Udp(socket) => {
                // Nobody listens yet, or no more: a device would not care either.
                let _ = socket.send(bytes);
                Ok(true)
            }
            Out::Tcp(stream) => match stream.write_all(bytes) {
                Ok(()) => Ok(true),
                Err(source) => Err(Error::Arguments {
                    what: format!("the receiver does not take frames any more: {source}"),
                    hint: "start it again, and then this",
                }),
            },
            Out::Listening(listening) => Ok(listening.send(bytes)),
            Out::Standard(out) => match out.write_all(bytes).and_then(|()| out.flush()) {
                Ok(()) => Ok(true),
                Err(error) => Err(Error::Stdout(error)),
            },
        }
    }
}
