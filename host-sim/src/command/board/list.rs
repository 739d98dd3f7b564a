//! The command `palpate board list`.

use std::time::Duration;

use palpate_controller::words;
use palpate_tissue::Error as TissueError;
use serialport::SerialPortType;

use super::status::image;
use crate::error::Error;
use crate::port::{PortError, Session};

/// Longest wait for a board, which sends a record every 2 ms.
const PATIENCE: Duration = Duration::from_millis(600);

/// A port, and the product on it as USB names it.
struct FoundPort {
    name: String,
    product: String,
}

pub(super) fn run(named: &[String]) -> Result<(), Error> {
    let candidates = if named.is_empty() { usb_ports()? } else { named.iter().map(|name| of_name(name)).collect() };
    if candidates.is_empty() {
        return Err(TissueError::Usage(
            "no USB serial port is there: is the board's cable in? A port of another kind is named: `palpate board list PORT`"
                .into(),
        )
        .into());
    }
    // in parallel, because every port is listened to for up to `PATIENCE`
    let found: Vec<Result<Session, PortError>> = std::thread::scope(|scope| {
        let listening: Vec<_> =
            candidates.iter().map(|candidate| scope.spawn(|| Session::open(&candidate.name, PATIENCE))).collect();
        let joined = listening.into_iter().zip(&candidates);
        joined.map(|(port, candidate)| port.join().unwrap_or_else(|_| Err(PortError::Missing(candidate.name.clone())))).collect()
    });
    let width = candidates.iter().map(|candidate| candidate.name.len()).max().unwrap_or(0);
    for (candidate, found) in candidates.iter().zip(&found) {
        let product = if candidate.product.is_empty() { String::new() } else { format!(" ({})", candidate.product) };
        match found {
            Ok(session) => {
                let mode = session.record.mode().map_or("of a later version", words::mode);
                println!("{:width$}  {}, {mode}{product}", candidate.name, image(&session.identity));
            }
            Err(error) => println!("{:width$}  no board of ours: {}{product}", candidate.name, short(error)),
        }
    }
    if found.iter().any(Result::is_ok) {
        return Ok(());
    }
    Err(TissueError::Usage(format!(
        "none of {} answers as a board of ours: is it powered and flashed? `palpate board status --port PORT` says more; only `palpate board self-test` reads a self-test image",
        if candidates.len() == 1 { "one port".into() } else { format!("{} ports", candidates.len()) }
    ))
    .into())
}

fn of_name(name: &str) -> FoundPort {
    let known = serialport::available_ports().unwrap_or_default().into_iter().find(|port| port.port_name == name);
    FoundPort { name: name.into(), product: known.map(|port| product(&port.port_type)).unwrap_or_default() }
}

fn usb_ports() -> Result<Vec<FoundPort>, Error> {
    let ports = serialport::available_ports().map_err(|cause| {
        TissueError::Usage(format!("the system does not name its serial ports ({cause}): name one with --port"))
    })?;
    let usb = ports.into_iter().filter(|port| matches!(port.port_type, SerialPortType::UsbPort(_)));
    Ok(usb.map(|port| FoundPort { product: product(&port.port_type), name: port.port_name }).collect())
}

/// Maker and product as USB names them.
fn product(kind: &SerialPortType) -> String {
    let SerialPortType::UsbPort(usb) = kind else { return String::new() };
    let words = [usb.manufacturer.as_deref(), usb.product.as_deref()];
    words.into_iter().flatten().collect::<Vec<_>>().join(" ").replace(char::is_control, " ")
}

/// Says in a few words why a port does not answer as a board.
fn short(error: &PortError) -> &'static str {
    match error {
        PortError::Missing(_) => "no such port",
        PortError::InUse(_) => "another program has it open",
        PortError::Denied(_) => "this user may not open it",
        PortError::Unusable { .. } => "not a serial port",
        PortError::Mute(_) => "nothing is heard",
        PortError::Foreign { .. } => "speaks, but not our frames",
        PortError::Deaf(_) => "speaks our frames, but does not answer",
        PortError::Lost { .. } | PortError::Refused { .. } | PortError::Undone { .. } => "it went away",
    }
}
