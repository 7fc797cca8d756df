//! Serves reference devices as live devices: any number of them on one port or serial line, each with its stand behind a control
//! socket.
//!
//! The devices use the clock of their wire. The server waits for a lost line; the devices notice the loss by their watchdogs.
//! This module must not know which devices exist, nor suites.

mod device;
mod medium;

pub use device::{DeclaredStandNames, DeviceMaker, InitialDeviceState, ServedDevice};
pub use medium::ServedMedium;

use crate::control::LONGEST_LINE;
use link::LinkError;
use link::lines::{LineConnection, LineListener};
use station::{Duration, Time};

/// Interval of the checks of the control sockets.
const CONTROL_INTERVAL: Duration = Duration::from_millis(2);
/// Interval of the calls to `stop`.
const STOP_INTERVAL: Duration = Duration::from_millis(50);
/// Maximum number of connections to a control socket.
const MAX_CONNECTIONS: usize = 8;

/// A device on the wire, with its control connections.
struct ServedStation {
    mac: [u8; 6],
    device: ServedDevice,
    listener: Option<LineListener>,
    connections: Vec<LineConnection>,
}

/// Reference devices on a port or a serial line.
pub struct DeviceServer {
    medium: ServedMedium,
    served: Vec<ServedStation>,
}

impl DeviceServer {
    /// A server on `medium`, without devices.
    pub fn new(medium: impl Into<ServedMedium>) -> DeviceServer {
        DeviceServer { medium: medium.into(), served: Vec::new() }
    }

    /// Adds a device to the wire, with its control socket, if any.
    pub fn add(&mut self, mac: [u8; 6], device: ServedDevice, listener: Option<LineListener>) {
        self.served.push(ServedStation { mac, device, listener, connections: Vec::new() });
    }

    /// The current time of its clock.
    pub fn now(&self) -> Time {
        self.medium.now()
    }

    /// Serves until the clock of the wire reaches `end` or `stop` returns true. `say` receives a sentence when the line is lost
    /// and when it is back. Fails with errors that waiting does not fix.
    pub fn run(
        &mut self,
        end: Time,
        stop: &mut dyn FnMut() -> bool,
        say: &mut dyn FnMut(&str),
    ) -> Result<(), LinkError> {
        let has_listeners = self.served.iter().any(|served| served.listener.is_some());
        let slice = if has_listeners { CONTROL_INTERVAL } else { STOP_INTERVAL };
        // On a socket that waits for a connection, no peer is connected yet.
        let mut lost = self.medium.is_open_ended();
        loop {
            let now = self.now();
            if now >= end || stop() {
                return Ok(());
            }
            let until = end.min(now + slice);
            match self.step(until) {
                Ok(()) => {}
                Err(LinkError::Gone(why)) => {
                    if !lost {
                        say(&why);
                    }
                    lost = true;
                }
                Err(error) => return Err(error),
            }
            if lost && self.medium.recover(until).is_ok() {
                lost = false;
                say(&format!("back at {}", self.medium.describe()));
            }
            self.answer_commands();
        }
    }

    /// Runs all events before `until`.
    fn step(&mut self, until: Time) -> Result<(), LinkError> {
        let DeviceServer { medium, served } = self;
        let stations = served.iter_mut().map(|served| (served.mac, &mut served.device as &mut dyn station::Station));
        medium.run(stations.collect(), until)
    }

    /// Answers the received command lines.
    fn answer_commands(&mut self) {
        let now = self.now();
        for ServedStation { device, listener, connections, .. } in &mut self.served {
            let Some(listener) = listener else { continue };
            while connections.len() < MAX_CONNECTIONS
                && let Ok(Some(connection)) = listener.accept()
            {
                connections.push(connection);
            }
            connections.retain_mut(|connection| answer(connection, device, now).is_ok());
        }
    }
}

/// Answers the commands of `connection`; fails once the connection has ended.
fn answer(connection: &mut LineConnection, device: &mut ServedDevice, now: Time) -> Result<(), LinkError> {
    while let Some(line) = connection.poll_line()? {
        let line = device.answer(now, &line).to_string();
        debug_assert!(line.len() <= LONGEST_LINE, "an answer fits in a line");
        connection.write_line(&line)?;
    }
    Ok(())
}
