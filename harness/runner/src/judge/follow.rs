//! Follows one connection after the other: observations in, ticks out, the image up to date.

use super::image::{AlarmSeen, Happening, Image, Placement};
use super::{Tick, TickKind};
use crate::observe::{Ar, ArId, Direction, Observation};
use crate::suite::device::Device;
use station::Time;
use wire::profinet::alarm::AlarmNotification;
use wire::profinet::diagnosis::AlarmItem;

/// What an observation changed for whoever follows the connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// A connection stands; what was remembered of the one before does not count any more.
    Opened,
    /// A frame or an event to be judged.
    Tick(Tick),
    /// The connection ended; what is open stays undecided. The tick is the event that ended it.
    Closed(Tick, Ending),
}

/// How a connection ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// It was released.
    Released,
    /// An ERR-RTA from this side; PNIO status as one number.
    Aborted(Direction, u32),
    /// This direction fell silent for longer than the watchdog.
    Starved(Direction),
}

/// The connection that is followed and what is known about it.
#[derive(Clone, Debug)]
pub struct Follower {
    /// What is known.
    pub image: Image,
    ar: Option<ArId>,
}

impl Follower {
    /// Follows nothing yet.
    pub fn new(device: &Device) -> Follower {
        Follower { image: Image::new(device), ar: None }
    }

    /// The connection that is followed.
    pub fn ar(&self) -> Option<ArId> {
        self.ar
    }

    /// Takes in an observation; connections for which `ours` is false are left alone.
    pub fn observe(
        &mut self,
        device: &Device,
        ars: &[Ar],
        ours: impl Fn(&Ar) -> bool,
        (time, frame): (Time, u64),
        observation: &Observation<'_>,
    ) -> Option<Change> {
        let event = Tick { time, frame, kind: TickKind::Event };
        match observation {
            Observation::Connected { ar } => {
                let seen = ars.get(ar.0 as usize)?;
                if !ours(seen) || seen.submodules.is_empty() {
                    return None;
                }
                self.ar = Some(*ar);
                self.image.open(device, seen);
                Some(Change::Opened)
            }
            _ if observation.ar().is_none_or(|ar| Some(ar) != self.ar) => match observation {
                Observation::Lldp { .. } if self.ar.is_some() => self.happened(Happening::Lldp, event),
                _ => None,
            },
            Observation::Cyclic { direction, data, at, status, .. } => {
                let good = self.image.cyclic(*direction, data, *status, Placement { frame, at: *at });
                self.image.happening = Happening::Nothing;
                let kind = match (direction, good) {
                    (Direction::ToDevice, _) => TickKind::Output,
                    (Direction::ToController, true) => TickKind::Sample,
                    (Direction::ToController, false) => TickKind::BadSample,
                };
                Some(Change::Tick(Tick { time, frame, kind }))
            }
            Observation::Record { written: true, target, data, status, .. } => {
                let (_, slot, subslot, index) = *target;
                self.image.record(device, slot, subslot, index, data, status.is_ok());
                None
            }
            Observation::Alarm { notification, .. } => self.happened(Happening::Alarm(alarm(notification)), event),
            Observation::Aborted { direction, status, .. } => {
                let code = u32::from(*status);
                self.end(Happening::Abort(code), event, Ending::Aborted(*direction, code))
            }
            Observation::Released { .. } => self.end(Happening::Nothing, event, Ending::Released),
            Observation::Starved { direction, .. } => self.end(Happening::Nothing, event, Ending::Starved(*direction)),
            Observation::ConnectRefused { .. }
            | Observation::Record { .. }
            | Observation::CallFailed { .. }
            | Observation::ParameterEnd { .. }
            | Observation::ApplicationReady { .. }
            | Observation::AlarmAcknowledged { .. }
            | Observation::Dcp { .. }
            | Observation::Lldp { .. }
            | Observation::Unreadable { .. } => None,
        }
    }

    fn happened(&mut self, happening: Happening, tick: Tick) -> Option<Change> {
        self.image.happening = happening;
        Some(Change::Tick(tick))
    }

    fn end(&mut self, happening: Happening, tick: Tick, ending: Ending) -> Option<Change> {
        self.image.close();
        self.image.happening = happening;
        self.ar = None;
        Some(Change::Closed(tick, ending))
    }
}

/// An alarm as the names show it: its first channel diagnosis, where it has one.
fn alarm(notification: &AlarmNotification) -> AlarmSeen {
    let item = notification.items.iter().find(|item| !item.channels().is_empty()).or(notification.items.first());
    let channel = item.and_then(|item| item.channels().first().copied());
    AlarmSeen {
        slot: notification.slot,
        subslot: notification.subslot,
        structure: item.map(AlarmItem::identifier),
        change: channel.map(|channel| channel.properties.change() as u8),
        error: channel.map(|channel| channel.error_type.0),
        severity: channel.map(|channel| channel.properties.severity() as u8),
        channel: channel.map(|channel| channel.channel),
    }
}
