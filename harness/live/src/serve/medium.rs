//! The medium of served devices: a wire that carries Ethernet frames, or a serial line.

use link::{LinkError, SerialBus, Step, Wire};
use station::{Station, Time};

/// The line of a server.
#[derive(Debug)]
pub enum Medium {
    /// Ethernet frames.
    Wire(Box<Wire>),
    /// PROFIBUS.
    Bus(Box<SerialBus>),
}

impl From<Wire> for Medium {
    fn from(wire: Wire) -> Medium {
        Medium::Wire(wire.into())
    }
}

impl From<SerialBus> for Medium {
    fn from(bus: SerialBus) -> Medium {
        Medium::Bus(bus.into())
    }
}

impl Medium {
    /// The current time of its clock.
    pub fn now(&self) -> Time {
        match self {
            Medium::Wire(wire) => wire.now(),
            Medium::Bus(bus) => bus.now(),
        }
    }

    /// Its description, for messages.
    pub fn describe(&self) -> String {
        match self {
            Medium::Wire(wire) => wire.port().describe(),
            Medium::Bus(bus) => bus.serial().describe(),
        }
    }

    /// Whether no peer is connected to the other end yet.
    pub fn is_open_ended(&self) -> bool {
        match self {
            Medium::Wire(wire) => wire.port().mac().is_none() && !wire.port().carrier(),
            Medium::Bus(_) => false,
        }
    }

    /// Tries to reopen a lost line until its clock reaches `until`.
    pub fn recover(&mut self, until: Time) -> Result<(), LinkError> {
        match self {
            Medium::Wire(wire) => wire.recover(until),
            Medium::Bus(bus) => bus.recover(until),
        }
    }

    /// Runs all events before `until`; the stations come with their MAC addresses, which a bus ignores.
    pub fn run(&mut self, mut stations: Vec<([u8; 6], &mut dyn Station)>, until: Time) -> Result<(), LinkError> {
        match self {
            Medium::Wire(wire) => loop {
                let step = wire.step(&mut stations, until, &mut |_| true, &mut |_, _| {})?;
                if step == Step::Idle || wire.now() >= until {
                    return Ok(());
                }
            },
            Medium::Bus(bus) => {
                let mut stations: Vec<&mut dyn Station> = stations.into_iter().map(|(_, station)| station).collect();
                loop {
                    let step = bus.step(&mut stations, until, &mut |_| true, &mut |_| ())?;
                    if step == Step::Idle || bus.now() >= until {
                        return Ok(());
                    }
                }
            }
        }
    }
}
