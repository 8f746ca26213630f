//! One open link.

use std::io::{self, Read};
use std::net::{SocketAddr, TcpStream, ToSocketAddrs, UdpSocket};
use std::path::Path;
use std::time::Duration;

use serial2::SerialPort;

use crate::Address;
use crate::permission::with_remedy;

/// How long a device may take to accept a connection.
const CONNECT: Duration = Duration::from_secs(3);

/// Bytes from a device.
#[derive(Debug)]
pub(super) enum Link {
    /// A serial port.
    Serial(SerialPort),
    /// A socket that listens for datagrams.
    Udp(UdpSocket),
    /// A connection.
    Tcp(TcpStream),
    /// Standard input.
    Stdin(io::Stdin),
}

impl Link {
    /// Opens it; reads wait no longer than `patience` (standard input waits as long as it takes).
    ///
    /// # Errors
    /// What the system says; [`io::ErrorKind::Unsupported`] for sources that are no link (files, `rpi:`, `sim:`).
    pub(super) fn open(address: &Address, patience: Duration) -> io::Result<Self> {
        match address {
            Address::Serial { port, baud, .. } => {
                let mut port = SerialPort::open(port, *baud).map_err(|error| {
                    let words = with_remedy(Path::new(port), &error);
                    io::Error::new(error.kind(), words)
                })?;
                port.set_read_timeout(patience)?;
                // Boards with a USB converter wait for this before they send.
                let _ = port.set_dtr(true);
                Ok(Self::Serial(port))
            }
            Address::Udp { bind, .. } => {
                let socket = UdpSocket::bind(bind)?;
                socket.set_read_timeout(Some(patience))?;
                Ok(Self::Udp(socket))
            }
            Address::Tcp { host, .. } => {
                let mut last = io::Error::new(io::ErrorKind::NotFound, "no such host");
                for address in host.to_socket_addrs()? {
                    match TcpStream::connect_timeout(&address, CONNECT) {
                        Ok(stream) => {
                            stream.set_read_timeout(Some(patience))?;
                            stream.set_nodelay(true)?;
                            return Ok(Self::Tcp(stream));
                        }
                        Err(error) => last = error,
                    }
                }
                Err(last)
            }
            Address::Stdin { .. } => Ok(Self::Stdin(io::stdin())),
            Address::File { .. } | Address::Sim { .. } | Address::Board { .. } => {
                Err(io::Error::from(io::ErrorKind::Unsupported))
            }
        }
    }

    /// Whether the other end may be gone without a word: a connection through a network that is down.
    pub(super) fn can_die_unseen(&self) -> bool {
        matches!(self, Self::Tcp(_))
    }

    /// Where it was opened: `address`, with the port that the system chose where that left it to it (`udp:0.0.0.0:0`).
    pub(super) fn place(&self, address: &Address) -> Address {
        match (self, address) {
            (Self::Udp(socket), Address::Udp { bind, protocol }) => Address::Udp {
                bind: match socket.local_addr() {
                    Ok(chosen) if bind.ends_with(":0") => chosen.to_string(),
                    _ => bind.clone(),
                },
                protocol: *protocol,
            },
            _ => address.clone(),
        }
    }

    /// Reads some bytes, or a datagram with its sender; 0: there will be no more.
    ///
    /// # Errors
    /// What the system says; a time-out when nothing came.
    pub(super) fn read(&mut self, bytes: &mut [u8]) -> io::Result<(usize, Option<SocketAddr>)> {
        if let Self::Udp(socket) = self {
            return match socket.recv_from(bytes)? {
                (0, _) => Err(io::Error::from(io::ErrorKind::WouldBlock)),
                (count, sender) => Ok((count, Some(sender))),
            };
        }
        self.read_stream(bytes).map(|count| (count, None))
    }

    fn read_stream(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        match self {
            // A port that says nothing at all, though it was readable, has been unplugged.
            Self::Serial(port) => match port.read(bytes)? {
                0 => Err(io::Error::new(io::ErrorKind::BrokenPipe, "unplugged")),
                count => Ok(count),
            },
            Self::Udp(_) => Err(io::Error::from(io::ErrorKind::Unsupported)),
            Self::Tcp(stream) => match stream.read(bytes)? {
                0 => Err(io::Error::new(
                    io::ErrorKind::ConnectionReset,
                    "the device closed the connection",
                )),
                count => Ok(count),
            },
            Self::Stdin(input) => input.read(bytes),
        }
    }
}
