//! What a controller does besides connections and requests: DCP Set, alarms that it does not take; and who else speaks to the device.
//!
//! What has no step in the language is left out, and from when on that matters is said with it.

use super::Listener;
use crate::ask::Ask;
use crate::heard::{Asked, Value};
use judge::observe::{Address, Ar, Direction, Observation};
use plain_text::escaped;
use station::{Duration, Time};
use wire::ethernet::Mac;
use wire::profinet::alarm::RtaKind;
use wire::profinet::dcp::{BlockError, Dcp, ServiceId, ServiceType, Value as DcpValue};

/// An alarm that nobody takes for so long is not taken on purpose.
const HELD: Duration = Duration::from_millis(50);
/// The name by which a controller holds its acknowledgements.
const ACKNOWLEDGE: &str = "io.alarm_acknowledge";
/// What is remembered of DCP before the device is known.
const MOST_EARLY: usize = 64;

impl Listener<'_> {
    /// What is set by DCP, and how it was answered.
    pub(super) fn dcp(&mut self, source: Mac, destination: Mac, pdu: &Dcp) {
        if pdu.service_id != ServiceId::SET {
            return;
        }
        if pdu.service_type != ServiceType::REQUEST {
            return self.dcp_answer(source, pdu);
        }
        let known = self.pair.map(|(_, device)| device);
        if known.is_some_and(|device| device != Address::Mac(destination)) {
            return;
        }
        for block in pdu.blocks() {
            let send =
                |service: &str, fields: String| Ask::Send { service: service.to_owned(), fields, answered: true };
            let ask = match &block.value {
                DcpValue::ResetToFactory | DcpValue::FactoryReset => {
                    let mode = match &block.value {
                        DcpValue::FactoryReset => Some("factory"),
                        _ => block.qualifier().reset_mode().word(),
                    };
                    match mode {
                        Some(mode) => send("dcp_reset", format!("{{ mode: {mode} }}")),
                        None => {
                            if known.is_some() {
                                self.left_open(self.now.0, "a reset by DCP whose mode has no word");
                            }
                            continue;
                        }
                    }
                }
                DcpValue::Signal(_) => send("dcp_signal", "{}".to_owned()),
                DcpValue::NameOfStation(name) => {
                    let text = escaped(name);
                    if text.contains(['\\', '\'', '"']) {
                        if known.is_some() {
                            self.left_open(self.now.0, format!("a station name that has no text: {text}"));
                        }
                        continue;
                    }
                    Ask::Write(vec![("station.name".to_owned(), format!("'{text}'"))])
                }
                DcpValue::IpParameter(ip) => {
                    // An address that is given while nothing stands is part of the start-up behind it, which gives one by itself.
                    if !self.stands_now() {
                        continue;
                    }
                    let entry = |name: &str, value: String| (format!("station.{name}"), value);
                    Ask::Write(vec![
                        entry("ip", ip.address.to_string()),
                        entry("mask", ip.mask.to_string()),
                        entry("gateway", ip.gateway.to_string()),
                    ])
                }
                DcpValue::Start | DcpValue::Stop => continue,
                _ => {
                    if known.is_some() {
                        self.left_open(self.now.0, "something that is set by DCP and has no name");
                    }
                    continue;
                }
            };
            let (at, frame) = self.now;
            let asked = Asked { ask, at, done: at, frame, answer: Vec::new() };
            if known.is_some() {
                self.unanswered = Some((pdu.xid, self.heard.asked.len()));
                self.heard.asked.push(asked);
            } else if self.early.len() < MOST_EARLY {
                self.early.push((destination, pdu.xid, asked));
            }
        }
    }

    /// Whether cyclic data are exchanged.
    fn stands_now(&self) -> bool {
        let last = self.heard.tracks.get("connection").and_then(|track| track.changes.last());
        last.and_then(|change| change.value.as_ref()).is_some_and(|value| value.text == "data")
    }

    fn dcp_answer(&mut self, source: Mac, pdu: &Dcp) {
        let refused = pdu.blocks().iter().find_map(|block| match &block.value {
            DcpValue::Response { error, .. } if *error != BlockError::OK => Some(error.0),
            _ => None,
        });
        let answer = match refused {
            None => Value::word("accepted"),
            Some(number) => Value { text: format!("{{ refused: {number} }}"), number: Some(number.into()) },
        };
        let answer = ("answer".to_owned(), answer);
        let (done, frame) = self.now;
        let early = self.early.iter_mut().find(|(device, xid, _)| (*device, *xid) == (source, pdu.xid));
        let open = self.unanswered.filter(|(xid, _)| *xid == pdu.xid).map(|(_, place)| place);
        let asked = match early {
            Some((_, _, asked)) => Some(asked),
            None => open.and_then(|place| self.heard.asked.get_mut(place)),
        };
        if let Some(asked) = asked {
            (asked.done, asked.frame) = (done, frame);
            asked.answer = vec![answer];
        }
    }

    /// Now it is known whom the capture is about: what was set of that device before is part of it.
    pub(super) fn early(&mut self) {
        let device = self.pair.map(|(_, device)| device);
        let early = std::mem::take(&mut self.early);
        let own = early.into_iter().filter(|(mac, _, _)| device == Some(Address::Mac(*mac)));
        self.heard.asked.extend(own.map(|(_, _, asked)| asked));
    }

    /// A connection of another controller to the device that is listened to: its manner is not made again.
    pub(super) fn somebody_else(&mut self, ar: &Ar, observation: &Observation<'_>) {
        if self.pair.is_none_or(|(_, device)| device != ar.device.address) {
            return;
        }
        let same = |what: &str| self.heard.left_out.iter().any(|left| left.what == what);
        let who = match ar.controller.address {
            Address::Mac(mac) => format!("controller {mac}"),
            Address::Fdl(number) => format!("master {number}"),
        };
        let what = match observation {
            Observation::Connected { .. } => format!("a connection of another party, {who}"),
            Observation::ConnectRefused { .. } => {
                let what = format!("a connection that another party, {who}, asked for and did not get");
                if !same(&what) {
                    self.left_out(what);
                }
                return;
            }
            Observation::Record { written: true, .. } => format!("what another party, {who}, wrote"),
            _ => return,
        };
        if !same(&what) {
            self.left_open(self.now.0, what);
        }
    }

    /// Whether alarms of the device are acknowledged.
    pub(super) fn alarm_channel(&mut self, direction: Direction, kind: RtaKind) {
        match (direction, kind) {
            (Direction::ToController, RtaKind::DATA) => {
                self.alarm.get_or_insert(self.now);
            }
            (Direction::ToDevice, RtaKind::DATA) => self.alarm = None,
            _ => {}
        }
    }

    /// The connection is over: an alarm that was not taken until then was held on purpose.
    pub(super) fn alarm_ends(&mut self, end: Time) {
        let Some((at, frame)) = self.alarm.take().filter(|(at, _)| end.since(*at) >= HELD) else { return };
        let ask = Ask::Set(vec![(ACKNOWLEDGE.to_owned(), "held".to_owned())]);
        let place = self.heard.asked.iter().rposition(|asked| matches!(asked.ask, Ask::Connect(_)) && asked.at <= at);
        let place = place.map_or(0, |place| place + 1);
        let begin = self.heard.asked.get(place.saturating_sub(1)).map_or(at, |asked| asked.done);
        self.heard.asked.insert(place, Asked { ask, at: begin, done: begin, frame, answer: Vec::new() });
    }
}
