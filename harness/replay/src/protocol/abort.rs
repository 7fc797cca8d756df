//! ERR-RTA: which side ended a connection, what the reason means, and what happened before.

use super::coverage::{CapturePosition, FindingList};
use super::table::ABORTED;
use super::text::{of, sender, span, status};
use crate::finding::{CaptureBlame, FindingSeverity};
use judge::observe::{ArId, FrameDirection, Observation, ObservedAr};
use std::collections::BTreeMap;
use wire::ethernet::Mac;
use wire::profinet::dcp::{DcpValue, ServiceId, ServiceType};
use wire::profinet::status::{AbortReason, PnioStatus};

/// Upper limit of the connections and of the stations whose last event is remembered.
const MOST: usize = 4_096;

/// The last event of each connection, and the last DCP Set to each station.
#[derive(Debug, Default)]
pub(super) struct Aborts {
    events: BTreeMap<ArId, (CapturePosition, String)>,
    touched: BTreeMap<Mac, (CapturePosition, String)>,
}

impl Aborts {
    pub fn observe(
        &mut self,
        now: CapturePosition,
        ars: &[ObservedAr],
        observation: &Observation<'_>,
        findings: &mut FindingList,
    ) {
        let (ar, what) = match observation {
            Observation::Aborted { ar, direction, status } => {
                self.aborted(now, ars, *ar, *direction, status, findings);
                return;
            }
            Observation::Dcp { source, destination, pdu }
                if (pdu.service_id, pdu.service_type) == (ServiceId::SET, ServiceType::REQUEST) =>
            {
                let what = pdu.blocks().iter().find_map(|block| match block.value {
                    DcpValue::NameOfStation(_) => Some("gave it a name"),
                    DcpValue::IpParameter(_) | DcpValue::FullIpSuite(..) => Some("gave it an address"),
                    DcpValue::ResetToFactory | DcpValue::FactoryReset => Some("reset it"),
                    _ => None,
                });
                if let Some(what) = what
                    && self.touched.len() < MOST
                {
                    self.touched.insert(*destination, (now, format!("{source} {what} by DCP")));
                }
                return;
            }
            Observation::CallFailed { ar: Some(ar), service, why } => (*ar, format!("{service} failed: {why}")),
            Observation::Record { ar: Some(ar), target, status: code, .. } if !code.is_ok() => {
                (*ar, format!("record 0x{:04X} was refused: {}", target.3, status(code)))
            }
            Observation::Released { ar } => (*ar, "the controller released it".to_owned()),
            Observation::Starved { ar, direction } => {
                let who = of(ars, *ar).map_or_else(String::new, |ar| sender(ar, *direction));
                (*ar, format!("{who} fell silent for longer than the watchdog"))
            }
            Observation::Alarm { ar, notification, .. } => {
                let kind = notification.alarm_type;
                let word = kind.word().map_or_else(|| format!("0x{:04X}", kind.0), |word| word.replace('_', " "));
                (*ar, format!("the device sent the alarm {word}"))
            }
            Observation::Connected { ar } => (*ar, "it was accepted".to_owned()),
            Observation::ParameterEnd { ar } => (*ar, "the parameters ended".to_owned()),
            Observation::ApplicationReady { ar } => (*ar, "the device said that it is ready".to_owned()),
            _ => return,
        };
        if self.events.len() < MOST || self.events.contains_key(&ar) {
            self.events.insert(ar, (now, what));
        }
    }

    fn aborted(
        &mut self,
        now: CapturePosition,
        ars: &[ObservedAr],
        id: ArId,
        direction: FrameDirection,
        code: &PnioStatus,
        findings: &mut FindingList,
    ) {
        let Some(ar) = of(ars, id) else { return };
        let who = sender(ar, direction);
        let before = |(when, what): &(CapturePosition, String)| {
            let since = now.since(*when).map_or_else(String::new, |since| format!(" {} earlier", span(since)));
            format!("{what} (frame {}{since})", when.frame)
        };
        let touched =
            self.touched.get(&ar.device.mac()).filter(|(when, _)| ar.connect_frame.is_none_or(|of| of < when.frame));
        let mut went: Vec<String> = self.events.get(&id).into_iter().chain(touched).map(before).collect();
        if went.is_empty() {
            went.push("the capture shows none of its frames".to_owned());
        }
        let silent = match direction {
            FrameDirection::ToController => &ar.outputs,
            FrameDirection::ToDevice => &ar.inputs,
        };
        if let Some(last) = silent.last {
            went.push(format!("the other side sent its last cyclic frame {} earlier", span(now.time.since(last))));
        }
        let (own, others) = match direction {
            FrameDirection::ToController => (CaptureBlame::Device, CaptureBlame::Controller),
            FrameDirection::ToDevice => (CaptureBlame::Controller, CaptureBlame::Device),
        };
        let in_time =
            silent.last.is_some_and(|last| !silent.watchdog.is_zero() && now.time.since(last) <= silent.watchdog);
        let (severity, blame, hint) = match code.abort_reason() {
            Some(AbortReason::RELEASE_RECEIVED) if ar.release_frame.is_some() => {
                (FindingSeverity::Info, own, "; this is the normal end of a connection")
            }
            Some(AbortReason::RELEASE_RECEIVED) => (
                FindingSeverity::Info,
                CaptureBlame::Capture,
                "; this is the normal end of a connection; its Release is not in the capture",
            ),
            Some(AbortReason::CONSUMER_TIMEOUT) if in_time => (
                FindingSeverity::Error,
                CaptureBlame::Network,
                "; its frames are in the capture in time, so they were lost between the capture point and the receiver",
            ),
            Some(AbortReason::CONSUMER_TIMEOUT) if direction == FrameDirection::ToDevice => (
                FindingSeverity::Error,
                CaptureBlame::Network,
                "; the device, its power supply or the link between them has failed",
            ),
            Some(AbortReason::CONSUMER_TIMEOUT | AbortReason::CMI_TIMEOUT | AbortReason::APPLICATION_READY_TIMEOUT) => {
                (FindingSeverity::Error, others, "")
            }
            Some(
                AbortReason::STATION_NAME_CHANGED
                | AbortReason::RESET_TO_FACTORY
                | AbortReason::IP_SUITE_CHANGED
                | AbortReason::LINK_DOWN,
            ) => (FindingSeverity::Error, CaptureBlame::Network, ""),
            // An alarm cannot be sent where the other side does not acknowledge it.
            Some(AbortReason::ALARM_SEND) => {
                (FindingSeverity::Error, others, "; the other side did not acknowledge it")
            }
            Some(AbortReason::PROTOCOL_VIOLATION | AbortReason::SEQUENCE) => (FindingSeverity::Error, others, ""),
            Some(AbortReason::RE_RUN | AbortReason::ABORT_REQUEST | AbortReason::DEVICE_DEACTIVATED) => {
                (FindingSeverity::Warning, own, "")
            }
            _ => (FindingSeverity::Error, own, ""),
        };
        let blame = match blame {
            CaptureBlame::Device | CaptureBlame::Controller if !ar.roles_known => CaptureBlame::Undecided,
            blame => blame,
        };
        let why = status(code);
        let text = format!("{who} ended the connection: {why}{hint}; before that: {}", went.join("; "));
        findings.add(ABORTED.finding(severity, blame, now.frame, text).ar(id).observed(why));
    }
}
