//! Actions of a controller other than connections and requests: DCP Set and alarms that it does not acknowledge; and other parties that
//! access the device.
//!
//! An action without a step in the suite language is left out, with the time from which on it matters.

use super::ConversationState;
use crate::action::ControllerAction;
use crate::conversation::{AnsweredAction, SuiteValue};
use judge::observe::{Address, FrameDirection, Observation, ObservedAr};
use plain_text::escaped;
use station::{Duration, Time};
use wire::ethernet::Mac;
use wire::profinet::alarm::RtaKind;
use wire::profinet::dcp::{BlockError, Dcp, DcpValue, ServiceId, ServiceType};

/// An alarm without acknowledgement for this time is held on purpose.
const HELD: Duration = Duration::from_millis(50);
/// The name by which a controller holds its acknowledgements.
const ACKNOWLEDGE: &str = "io.alarm_acknowledge";
/// Upper limit of the DCP Sets that are remembered before the device is known.
const MOST_EARLY: usize = 64;

impl ConversationState<'_> {
    /// Takes in a DCP Set or its answer.
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
            let send = |service: &str, fields: String| ControllerAction::Send {
                service: service.to_owned(),
                fields,
                answered: true,
            };
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
                                self.left_open(self.now.0, "a DCP reset with an unknown mode");
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
                            self.left_open(
                                self.now.0,
                                format!("a station name that the suite language cannot write: {text}"),
                            );
                        }
                        continue;
                    }
                    ControllerAction::Write(vec![("station.name".to_owned(), format!("'{text}'"))])
                }
                DcpValue::IpParameter(ip) => {
                    // Without a connection a new IP address belongs to the following start-up, which sets one by itself.
                    if !self.exchanges_data() {
                        continue;
                    }
                    let entry = |name: &str, value: String| (format!("station.{name}"), value);
                    ControllerAction::Write(vec![
                        entry("ip", ip.address.to_string()),
                        entry("mask", ip.mask.to_string()),
                        entry("gateway", ip.gateway.to_string()),
                    ])
                }
                DcpValue::Start | DcpValue::Stop => continue,
                _ => {
                    if known.is_some() {
                        self.left_open(self.now.0, "a DCP Set of an element without a name");
                    }
                    continue;
                }
            };
            let (at, frame) = self.now;
            let asked = AnsweredAction::new(ask, (at, at), frame);
            if known.is_some() {
                self.unanswered = Some((pdu.xid, self.conversation.actions.len()));
                self.conversation.actions.push(asked);
            } else if self.early.len() < MOST_EARLY {
                self.early.push((destination, pdu.xid, asked));
            }
        }
    }

    /// Whether cyclic data are exchanged.
    fn exchanges_data(&self) -> bool {
        let last = self.conversation.tracks.get("connection").and_then(|track| track.changes.last());
        last.and_then(|change| change.value.as_ref()).is_some_and(|value| value.text == "data")
    }

    fn dcp_answer(&mut self, source: Mac, pdu: &Dcp) {
        let refused = pdu.blocks().iter().find_map(|block| match &block.value {
            DcpValue::Response { error, .. } if *error != BlockError::OK => Some(error.0),
            _ => None,
        });
        let answer = match refused {
            None => SuiteValue::word("accepted"),
            Some(number) => SuiteValue { text: format!("{{ refused: {number} }}"), number: Some(number.into()) },
        };
        let answer = ("answer".to_owned(), answer);
        let (done, frame) = self.now;
        let early = self.early.iter_mut().find(|(device, xid, _)| (*device, *xid) == (source, pdu.xid));
        let open = self.unanswered.filter(|(xid, _)| *xid == pdu.xid).map(|(_, place)| place);
        let asked = match early {
            Some((_, _, asked)) => Some(asked),
            None => open.and_then(|place| self.conversation.actions.get_mut(place)),
        };
        if let Some(asked) = asked {
            (asked.done, asked.frame) = (done, frame);
            asked.answer = vec![answer];
        }
    }

    /// Adds the earlier DCP Sets of the device, which is now known.
    pub(super) fn take_early_sets(&mut self) {
        let device = self.pair.map(|(_, device)| device);
        let early = std::mem::take(&mut self.early);
        let own = early.into_iter().filter(|(mac, _, _)| device == Some(Address::Mac(*mac)));
        self.conversation.actions.extend(own.map(|(_, _, asked)| asked));
    }

    /// Notes a connection of another controller to the device, which is not repeated.
    pub(super) fn other_party(&mut self, ar: &ObservedAr, observation: &Observation<'_>) {
        if self.pair.is_none_or(|(_, device)| device != ar.device.address) {
            return;
        }
        let same = |what: &str| self.conversation.left_out.iter().any(|left| left.what == what);
        let who = match ar.controller.address {
            Address::Mac(mac) => format!("controller {mac}"),
            Address::Fdl(number) => format!("master {number}"),
        };
        let what = match observation {
            Observation::Connected { .. } => format!("a connection of another party, {who}"),
            Observation::ConnectRefused { .. } => {
                let what = format!("a refused connection of another party, {who}");
                if !same(&what) {
                    self.left_out(what);
                }
                return;
            }
            Observation::Record { written: true, .. } => format!("a write of another party, {who}"),
            _ => return,
        };
        if !same(&what) {
            self.left_open(self.now.0, what);
        }
    }

    /// Tracks whether alarms of the device are acknowledged.
    pub(super) fn alarm_channel(&mut self, direction: FrameDirection, kind: RtaKind) {
        match (direction, kind) {
            (FrameDirection::ToController, RtaKind::DATA) => {
                self.alarm.get_or_insert(self.now);
            }
            (FrameDirection::ToDevice, RtaKind::DATA) => self.alarm = None,
            _ => {}
        }
    }

    /// The connection has ended: an alarm without acknowledgement was held on purpose.
    pub(super) fn alarm_ends(&mut self, end: Time) {
        let Some((at, frame)) = self.alarm.take().filter(|(at, _)| end.since(*at) >= HELD) else { return };
        let ask = ControllerAction::Set(vec![(ACKNOWLEDGE.to_owned(), "held".to_owned())]);
        let place = self
            .conversation
            .actions
            .iter()
            .rposition(|asked| matches!(asked.ask, ControllerAction::Connect(_)) && asked.at <= at);
        let place = place.map_or(0, |place| place + 1);
        let begin = self.conversation.actions.get(place.saturating_sub(1)).map_or(at, |asked| asked.done);
        self.conversation.actions.insert(place, AnsweredAction::new(ask, (begin, begin), frame));
    }
}
