//! The medium of served devices: a wire that carries Ethernet frames, or a serial line.

use link::{LinkError, SerialBus, Wire, WireStep};
use station::{Station, Time};

/// The line of a server.
#[derive(Debug)]
pub enum ServedMedium {
    /// Ethernet frames.
    Wire(Box<Wire>),
    /// PROFIBUS.
    Bus(Box<SerialBus>),
}

impl From<Wire> for ServedMedium {
    fn from(wire: Wire) -> ServedMedium {
        ServedMedium::Wire(wire.into())
    }
}

impl From<SerialBus> for ServedMedium {
    fn from(bus: SerialBus) -> ServedMedium {
        ServedMedium::Bus(bus.into())
    }
}

impl ServedMedium {
    /// The current time of its clock.
    pub fn now(&self) -> Time {
        match self {
            ServedMedium::Wire(wire) => wire.now(),
            ServedMedium::Bus(bus) => bus.now(),
        }
    }

    /// Its description, for messages.
    pub fn describe(&self) -> String {
        match self {
            ServedMedium::Wire(wire) => wire.port().describe(),
            ServedMedium::Bus(bus) => bus.serial().describe(),
        }
    }

    /// Whether no peer is connected to the other end yet.
    pub fn is_open_ended(&self) -> bool {
        match self {
            ServedMedium::Wire(wire) => wire.port().mac().is_none() && !wire.port().carrier(),
            ServedMedium::Bus(_) => false,
        }
    }

    /// Tries to reopen a lost line until its clock reaches `until`.
    pub fn recover(&mut self, until: Time) -> Result<(), LinkError> {
        match self {
            ServedMedium::Wire(wire) => wire.recover(until),
            ServedMedium::Bus(bus) => bus.recover(until),
        }
    }

    /// Runs all events before `until`; the stations come with their MAC addresses, which a bus ignores.
    pub fn run(&mut self, mut stations: Vec<([u8; 6], &mut dyn Station)>, until: Time) -> Result<(), LinkError> {
        match self {
            ServedMedium::Wire(wire) => loop {
                let step = wire.step(&mut stations, until, &mut |_| true, &mut |_, _| {})?;
                if step == WireStep::Idle || wire.now() >= until {
                    return Ok(());
                }
            },
            ServedMedium::Bus(bus) => {
                let mut stations: Vec<&mut dyn Station> = stations.into_iter().map(|(_, station)| station).collect();
                loop {
                    let step = bus.step(&mut stations, until, &mut |_| true, &mut |_| ())?;
                    if step == WireStep::Idle || bus.now() >= until {
                        return Ok(());
                    }
                }
            }
        }
    }
}
