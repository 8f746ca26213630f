//! `taxel devices`: what a sensor may be plugged in to.

use taxel_acquire::transport::serial_ports;

use crate::error::Error;
use crate::{Exit, out};

/// List the serial ports of this machine
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Print the list as JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub(crate) fn run(args: &Args) -> Result<Exit, Error> {
    let ports: Vec<String> = serial_ports()?
        .iter()
        .map(|port| format!("serial:{}", port.display()))
        .collect();
    if args.json {
        out::json(&ports)?;
        return Ok(Exit::Good);
    }
    if ports.is_empty() {
        out::note("no serial port; plug the device in, or use udp:, tcp:, sim:")
    } else {
        out::result(&ports.join("\n"))?
    }
    Ok(Exit::Good)
}
