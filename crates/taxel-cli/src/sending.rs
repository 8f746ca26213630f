//! Where frames are sent to: a pipe, datagrams, a connection.

use std::io::{self, Write};
use std::net::{TcpStream, UdpSocket};

use crate::error::Error;

/// The largest datagram: a frame beyond it must go another way.
const MAX_DATAGRAM: usize = 65_507;

/// An open way.
pub(crate) enum Out {
    /// To whoever listens.
    Udp(UdpSocket),
    /// To who has answered.
    Tcp(TcpStream),
    /// To standard output.
    Standard(io::Stdout),
}

impl Out {
    /// Opens `udp:HOST:PORT`, `tcp:HOST:PORT` or `-`, of the option `--to`.
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
        let Some(address) = to.strip_prefix("udp:") else {
            return Err(Error::Arguments {
                what: format!("--to {to}: neither udp:HOST:PORT, tcp:HOST:PORT nor -"),
                hint: "udp:127.0.0.1:9000",
            });
        };
        let socket = UdpSocket::bind("0.0.0.0:0").map_err(failed)?;
        socket.connect(address).map_err(failed)?;
        Ok(Self::Udp(socket))
    }

    /// Sends a frame as a whole.
    pub(crate) fn send(&mut self, bytes: &[u8]) -> Result<(), Error> {
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
                Ok(())
            }
            Out::Tcp(stream) => stream.write_all(bytes).map_err(|source| Error::Arguments {
                what: format!("the receiver does not take frames any more: {source}"),
                hint: "start it again, and then this",
            }),
            Out::Standard(out) => out
                .write_all(bytes)
                .and_then(|()| out.flush())
                .map_err(Error::Stdout),
        }
    }
}
