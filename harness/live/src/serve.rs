//! Reference devices as live devices: any number of them at one port or serial line, each with its stand behind a control socket.
//!
//! The devices live by the clock of their wire. A line that is lost is waited for; the devices notice it as devices do,
//! by their watchdogs. This room must not know which devices there are, nor suites.

mod device;
mod medium;

pub use device::{Made, Maker, Names, ServedDevice};
pub use medium::Medium;

use crate::control::LONGEST_LINE;
use link::LinkError;
use link::lines::{Connection, Listener};
use station::{Duration, Time};

/// How often control sockets are looked at.
const LOOK: Duration = Duration::from_millis(2);
/// How often it is asked whether to stop.
const BREATH: Duration = Duration::from_millis(50);
/// How many may hold a control socket at a time.
const HANDS: usize = 8;

/// A device on the wire, with whoever has it in hand.
struct Served {
    mac: [u8; 6],
    device: ServedDevice,
    desk: Option<Listener>,
    hands: Vec<Connection>,
}

/// Reference devices at a port or a serial line.
pub struct Server {
    medium: Medium,
    served: Vec<Served>,
}

impl Server {
    /// A server at `medium`, without devices.
    pub fn new(medium: impl Into<Medium>) -> Server {
        Server { medium: medium.into(), served: Vec::new() }
    }

    /// Puts a device on the wire, with its control socket where there is one.
    pub fn add(&mut self, mac: [u8; 6], device: ServedDevice, desk: Option<Listener>) {
        self.served.push(Served { mac, device, desk, hands: Vec::new() });
    }

    /// What its clock shows.
    pub fn now(&self) -> Time {
        self.medium.now()
    }

    /// Serves until the clock of the wire shows `end` or `stop` says so.
    ///
    /// `say` is told in a sentence when the line is lost and when it is back. The error is one that waiting does not mend.
    pub fn run(
        &mut self,
        end: Time,
        stop: &mut dyn FnMut() -> bool,
        say: &mut dyn FnMut(&str),
    ) -> Result<(), LinkError> {
        let has_desks = self.served.iter().any(|served| served.desk.is_some());
        let slice = if has_desks { LOOK } else { BREATH };
        // At a socket where somebody has to come, nobody has yet.
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
            self.hear();
        }
    }

    /// Lets everything happen up to `until`.
    fn step(&mut self, until: Time) -> Result<(), LinkError> {
        let Server { medium, served } = self;
        let stations = served.iter_mut().map(|served| (served.mac, &mut served.device as &mut dyn station::Station));
        medium.run(stations.collect(), until)
    }

    /// Answers the lines that have come.
    fn hear(&mut self) {
        let now = self.now();
        for Served { device, desk, hands, .. } in &mut self.served {
            let Some(desk) = desk else { continue };
            while hands.len() < HANDS
                && let Ok(Some(hand)) = desk.accept()
            {
                hands.push(hand);
            }
            hands.retain_mut(|hand| answer(hand, device, now).is_ok());
        }
    }
}

/// Answers what `hand` has asked; an error once it has gone.
fn answer(hand: &mut Connection, device: &mut ServedDevice, now: Time) -> Result<(), LinkError> {
    while let Some(line) = hand.poll_line()? {
        let line = device.answer(now, &line).to_string();
        debug_assert!(line.len() <= LONGEST_LINE, "an answer is a line");
        hand.write_line(&line)?;
    }
    Ok(())
}
