//! Follows consecutive connections of a device: turns observations into ticks and updates the image.

use super::image::{ConnectionImage, CurrentEvent, ObservedAlarm, ObservedHello, ObservedLldp, Placement};
use super::{JudgeTick, TickKind};
use crate::observe::{Address, ArId, Dp, FrameDirection, Leaving, Observation, ObservedAr};
use station::Time;
use suite::device::DeviceDescription;
use wire::ethernet::Mac;
use wire::lldp::{Lldp, Tlv};
use wire::profibus::fdl::BROADCAST;
use wire::profinet::alarm::{AlarmNotification, AlarmPriority};
use wire::profinet::dcp::{Dcp, DcpValue, ServiceId};
use wire::profinet::diagnosis::AlarmItem;

/// The effect of an observation on the followed connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConnectionChange {
    /// A connection is established; the memory of the previous one is invalid.
    Opened,
    /// A frame or an event to be judged.
    Tick(JudgeTick),
    /// The connection ended; open windows stay undecided. The tick is the event that ended it.
    Closed(JudgeTick, Ending),
}

/// How a connection ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// It was released.
    Released,
    /// An ERR-RTA from this sender; PNIO status as one number.
    Aborted(FrameDirection, u32),
    /// No frame of this direction for longer than the watchdog time.
    Starved(FrameDirection),
    /// The slave left data exchange (PROFIBUS).
    Left(Leaving),
}

/// The followed connection and its image.
#[derive(Clone, Debug)]
pub struct Follower {
    /// The values of the connection.
    pub image: ConnectionImage,
    /// Address of the device, if it is known before the connection is established.
    pub station: Option<Address>,
    ar: Option<ArId>,
    /// The last followed connection, if it ended in silence: an ERR-RTA for it is still an event.
    starved: Option<ArId>,
}

impl Follower {
    /// A follower without a connection.
    pub fn new(device: &DeviceDescription) -> Follower {
        Follower { image: ConnectionImage::new(device), station: None, ar: None, starved: None }
    }

    /// The followed connection.
    pub fn ar(&self) -> Option<ArId> {
        self.ar
    }

    /// Processes an observation; ignores connections for which `is_followed` is false.
    pub fn observe(
        &mut self,
        device: &DeviceDescription,
        ars: &[ObservedAr],
        is_followed: impl Fn(&ObservedAr) -> bool,
        (time, frame): (Time, u64),
        observation: &Observation<'_>,
    ) -> Option<ConnectionChange> {
        let event = JudgeTick { time, frame, kind: TickKind::Event };
        match observation {
            Observation::Connected { ar } => {
                let observed = ars.get(ar.0 as usize)?;
                if !is_followed(observed) || observed.submodules.is_empty() {
                    return None;
                }
                (self.ar, self.starved) = (Some(*ar), None);
                self.image.open(device, observed);
                Some(ConnectionChange::Opened)
            }
            _ if observation.ar().is_none_or(|ar| Some(ar) != self.ar) => match observation {
                Observation::Lldp { source, pdu } => {
                    let observed = ObservedLldp { source: Some(*source), ..announcement(pdu) };
                    let is_device = |mac: Mac| self.is_device(ars, Address::Mac(mac));
                    let is_device = is_device(*source) || observed.mac.is_some_and(is_device);
                    if is_device { self.happened(CurrentEvent::Lldp(observed), event) } else { None }
                }
                Observation::Dcp { source, pdu, .. } if pdu.service_id == ServiceId::HELLO => {
                    let is_device = self.is_device(ars, Address::Mac(*source));
                    if is_device { self.happened(CurrentEvent::Hello(said(pdu)), event) } else { None }
                }
                Observation::Aborted { ar, direction, status } if Some(*ar) == self.starved => {
                    self.starved = None;
                    self.happened(abort(*direction, u32::from(*status)), event)
                }
                Observation::Dp { event: Dp::Control { station, control, .. }, .. }
                    if *station == BROADCAST || self.is_device(ars, Address::Fdl(*station)) =>
                {
                    self.image.controlled(control.command);
                    None
                }
                Observation::Dp { event: Dp::Diagnosis { station, octets, at, .. }, .. }
                    if self.is_device(ars, Address::Fdl(*station)) =>
                {
                    self.image.diagnosed(octets, Placement { time, frame, at: *at });
                    self.happened(CurrentEvent::Diagnosis, event)
                }
                _ => None,
            },
            Observation::Dp { event: dp, .. } => match dp {
                Dp::Diagnosis { octets, at, .. } => {
                    self.image.diagnosed(octets, Placement { time, frame, at: *at });
                    self.happened(CurrentEvent::Diagnosis, event)
                }
                Dp::Left { why } => self.end(CurrentEvent::Nothing, event, Ending::Left(*why)),
                Dp::Control { .. } | Dp::Parameters { .. } | Dp::Configuration { .. } | Dp::AddressGiven { .. } => None,
            },
            Observation::Cyclic { direction, data, at, status, .. } => {
                let good = self.image.cyclic(*direction, data, *status, Placement { time, frame, at: *at });
                self.image.happening = CurrentEvent::Nothing;
                let kind = match (direction, good) {
                    (FrameDirection::ToDevice, _) => TickKind::Output,
                    (FrameDirection::ToController, true) => TickKind::Sample,
                    (FrameDirection::ToController, false) => TickKind::BadSample,
                };
                Some(ConnectionChange::Tick(JudgeTick { time, frame, kind }))
            }
            Observation::Record { written: true, target, data, status, .. } => {
                let (_, slot, subslot, index) = *target;
                self.image.record(device, slot, subslot, index, data, status.is_ok());
                None
            }
            Observation::RecordRequested { target: (_, slot, subslot, index), .. } => {
                self.image.record_requested(device, *slot, *subslot, *index);
                None
            }
            Observation::Alarm { notification, .. } => self.happened(CurrentEvent::Alarm(alarm(notification)), event),
            Observation::PlugReady { alarm, .. } => self.happened(CurrentEvent::Ready(*alarm), event),
            Observation::Aborted { direction, status, .. } => {
                let code = u32::from(*status);
                self.end(abort(*direction, code), event, Ending::Aborted(*direction, code))
            }
            Observation::Released { .. } => self.end(CurrentEvent::Nothing, event, Ending::Released),
            Observation::Starved { direction, .. } => {
                self.starved = self.ar;
                self.end(CurrentEvent::Nothing, event, Ending::Starved(*direction))
            }
            Observation::ConnectRefused { .. }
            | Observation::Record { .. }
            | Observation::CallFailed { .. }
            | Observation::ParameterEnd { .. }
            | Observation::ApplicationReady { .. }
            | Observation::AlarmAcknowledged { .. }
            | Observation::Dcp { .. }
            | Observation::Lldp { .. }
            | Observation::Traffic(_)
            | Observation::Gap { .. }
            | Observation::Unreadable { .. } => None,
        }
    }

    /// Whether `address` is that of the device: the one of the followed connection, else the known one. Ports may send from
    /// their own addresses; their LLDP frames then contain the address of the device.
    fn is_device(&self, ars: &[ObservedAr], address: Address) -> bool {
        let of_ar = self.ar.and_then(|ar| ars.get(ar.0 as usize)).map(|ar| ar.device.address);
        of_ar.or(self.station) == Some(address)
    }

    fn happened(&mut self, happening: CurrentEvent, tick: JudgeTick) -> Option<ConnectionChange> {
        self.image.happening = happening;
        Some(ConnectionChange::Tick(tick))
    }

    fn end(&mut self, happening: CurrentEvent, tick: JudgeTick, ending: Ending) -> Option<ConnectionChange> {
        self.image.close();
        self.image.happening = happening;
        self.ar = None;
        Some(ConnectionChange::Closed(tick, ending))
    }
}

/// What an abort is for `abort`, which the device alone can do: a controller that gives up proves nothing of the device.
fn abort(direction: FrameDirection, code: u32) -> CurrentEvent {
    match direction {
        FrameDirection::ToController => CurrentEvent::Abort(code),
        FrameDirection::ToDevice => CurrentEvent::Nothing,
    }
}

/// The values of `hello.*` for a Hello.
fn said(pdu: &Dcp) -> ObservedHello {
    let mut observed = ObservedHello::default();
    for block in pdu.blocks() {
        match &block.value {
            DcpValue::NameOfStation(name) => observed.name = Some(String::from_utf8_lossy(name).into_owned()),
            DcpValue::IpParameter(ip) => observed.ip = Some(ip.address.octets()),
            _ => {}
        }
    }
    observed
}

/// The values of `lldp.*` for an LLDP frame.
///
/// The station name is in the chassis id, in newer devices in the port id after a dot.
fn announcement(pdu: &Lldp) -> ObservedLldp {
    let text = |octets: &[u8]| String::from_utf8_lossy(octets).into_owned();
    let mut observed = ObservedLldp::default();
    let mut behind_the_dot = None;
    for tlv in &pdu.tlvs {
        match tlv {
            Tlv::ChassisId { subtype, id } => {
                let is_name = *subtype == Tlv::LOCALLY_ASSIGNED;
                observed.name = Some(if is_name { text(id) } else { String::new() });
                observed.chassis = Some(id.clone());
            }
            Tlv::PortId { id, .. } => {
                let id = text(id);
                let (port, name) = id.split_once('.').map_or((&*id, None), |(port, name)| (port, Some(name)));
                behind_the_dot = name.map(str::to_owned);
                observed.port = Some(port.to_owned());
            }
            Tlv::ChassisMac(mac) => observed.mac = Some(*mac),
            Tlv::TimeToLive(seconds) => observed.ttl = Some(*seconds),
            _ => {}
        }
    }
    observed.name = behind_the_dot.or(observed.name);
    pdu.write(&mut observed.octets);
    observed
}

/// The length of a UserStructureIdentifier in bytes.
const USER_STRUCTURE_IDENTIFIER: usize = 2;

/// The values of `alarm.*` for an alarm: its first channel diagnosis, if it has one.
fn alarm(notification: &AlarmNotification) -> ObservedAlarm {
    let item = notification.items.iter().find(|item| !item.channels().is_empty()).or(notification.items.first());
    let channel = item.and_then(|item| item.channels().first().copied());
    ObservedAlarm {
        alarm_type: notification.alarm_type.0,
        is_high: notification.priority == AlarmPriority::High,
        payload: item.map(|item| {
            let mut octets = Vec::new();
            item.write(&mut octets);
            octets.split_off(octets.len().min(USER_STRUCTURE_IDENTIFIER))
        }),
        sequence: notification.specifier.sequence_number(),
        slot: notification.slot,
        subslot: notification.subslot,
        structure: item.map(AlarmItem::identifier),
        change: channel.map(|channel| channel.properties.change() as u8),
        error: channel.map(|channel| channel.error_type.0),
        severity: channel.map(|channel| channel.properties.severity() as u8),
        channel: channel.map(|channel| channel.channel),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    const MAC: Mac = Mac([0x10, 0xB9, 0xFE, 0, 0, 1]);

    fn chassis(subtype: u8, id: &[u8]) -> Tlv {
        Tlv::ChassisId { subtype, id: id.into() }
    }

    fn port(id: &str) -> Tlv {
        Tlv::PortId { subtype: Tlv::LOCALLY_ASSIGNED, id: id.into() }
    }

    /// The station name is in the chassis id, in newer devices after the port; a device without a name sends its address only.
    #[rstest]
    #[case(vec![chassis(7, b"enc-1"), port("port-001")], (Some("enc-1"), Some("port-001"), None))]
    #[case(vec![chassis(7, b"Encoder 1.0"), port("port-001.enc.one")], (Some("enc.one"), Some("port-001"), None))]
    #[case(vec![chassis(4, &MAC.0), port("port-001"), Tlv::ChassisMac(MAC)], (Some(""), Some("port-001"), Some(MAC)))]
    #[case(vec![chassis(4, &MAC.0), port("port-001.enc-1")], (Some("enc-1"), Some("port-001"), None))]
    #[case(vec![Tlv::TimeToLive(20)], (None, None, None))]
    fn values_of_an_lldp_frame(
        #[case] tlvs: Vec<Tlv>,
        #[case] (name, port, mac): (Option<&str>, Option<&str>, Option<Mac>),
    ) {
        let observed = announcement(&Lldp { tlvs });
        assert_eq!((observed.name.as_deref(), observed.port.as_deref(), observed.mac), (name, port, mac));
    }
}
