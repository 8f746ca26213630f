//! Frames of a live session for Foxglove, beside the viewers of this program.

use taxel::Sensor;
use taxel_server::FoxgloveServer;

use crate::error::Error;
use crate::session::FrameObserver;

/// A server on `HOST:PORT`, and what gives it the frames of a session: to be that session's observer, which ends it.
///
/// # Errors
/// An address that is none, or cannot be listened on.
pub fn foxglove(address: &str, sensor: &Sensor) -> Result<(FrameObserver, u16), Error> {
    let listen = |source| Error::Listen {
        address: address.to_owned(),
        source,
    };
    let (host, port) = address.rsplit_once(':').unwrap_or((address, ""));
    let port = port.parse().map_err(|_| {
        listen(std::io::Error::new(
            std::io::ErrorKind::InvalidInput,
            "expected HOST:PORT, such as 127.0.0.1:8765",
        ))
    })?;
    let mut server = FoxgloveServer::start(host, port, sensor).map_err(listen)?;
    let port = server.port();
    let observer: FrameObserver = Box::new(move |frame| {
        let loads = frame.loads.filter(|_| frame.is_answer);
        server.send(loads, frame.figures, frame.at);
    });
    Ok((observer, port))
}
