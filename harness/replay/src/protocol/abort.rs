//! ERR-RTA: which side ended a connection, what the reason means, and what happened before.

use super::accepted::AcceptedFrames;
use super::advice::{advised, of_abort};
use super::coverage::{CapturePosition, FindingList, SettledFrames};
use super::surroundings::Surroundings;
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
#[derive(Clone, Debug, Default)]
pub(super) struct Aborts {
    events: BTreeMap<ArId, (CapturePosition, String)>,
    /// Position, sender and words of the last Set to each station.
    touched: BTreeMap<Mac, (CapturePosition, Mac, String)>,
}

/// What the capture shows beside the connection that ended.
#[derive(Clone, Copy)]
pub(super) struct AbortEvidence<'a> {
    /// The cyclic frames that a receiver accepts.
    pub accepted: &'a AcceptedFrames,
    pub surroundings: &'a Surroundings,
}

/// Whether the ERR-RTA belongs to an end that one side wanted: after a Release, or because the controller's own application
/// requested it.
pub(super) fn is_deliberate(ar: &ObservedAr, direction: FrameDirection, status: &PnioStatus) -> bool {
    let by_application = [AbortReason::ABORT_REQUEST, AbortReason::DEVICE_DEACTIVATED, AbortReason::AR_REMOVED];
    ar.release_frame.is_some()
        || ar.roles_known
            && direction == FrameDirection::ToDevice
            && status.abort_reason().is_some_and(|reason| by_application.contains(&reason))
}

/// How an abort is judged.
struct Judgement {
    severity: FindingSeverity,
    blame: CaptureBlame,
    /// What the frames show, to follow the reason.
    hint: String,
    /// Cause and next step, if the frames show more than the reason says.
    advice: Option<(String, String)>,
}

impl Judgement {
    fn new(severity: FindingSeverity, blame: CaptureBlame, hint: impl Into<String>) -> Judgement {
        Judgement { severity, blame, hint: hint.into(), advice: None }
    }

    fn advice(mut self, cause: impl Into<String>, next: impl Into<String>) -> Judgement {
        self.advice = Some((cause.into(), next.into()));
        self
    }
}

impl Aborts {
    pub fn observe(
        &mut self,
        now: CapturePosition,
        ars: &[ObservedAr],
        observation: &Observation<'_>,
        evidence: AbortEvidence<'_>,
        findings: &mut FindingList,
    ) {
        let (ar, what) = match observation {
            Observation::Aborted { ar, direction, status } => {
                self.aborted(now, ars, (*ar, *direction), status, evidence, findings);
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
                    self.touched.insert(*destination, (now, *source, format!("{source} {what} by DCP")));
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
            Observation::PlugReady { ar, .. } => (*ar, "the device said that a plugged submodule is ready".to_owned()),
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
        (id, direction): (ArId, FrameDirection),
        code: &PnioStatus,
        evidence: AbortEvidence<'_>,
        findings: &mut FindingList,
    ) {
        let Some(ar) = of(ars, id) else { return };
        let who = sender(ar, direction);
        let before = |when: CapturePosition, what: &str| {
            let since = now.since(when).map_or_else(String::new, |since| format!(" {} earlier", span(since)));
            format!("{what} (frame {}{since})", when.frame)
        };
        let touched = self.touched.get(&ar.device.mac());
        let touched = touched.filter(|(when, ..)| ar.connect_frame.is_none_or(|of| of < when.frame));
        let mut went: Vec<String> = self.events.get(&id).map(|(when, what)| before(*when, what)).into_iter().collect();
        went.extend(touched.map(|(when, _, what)| before(*when, what)));
        if went.is_empty() {
            went.push("the capture shows none of its steps".to_owned());
        }
        let other = match direction {
            FrameDirection::ToController => FrameDirection::ToDevice,
            FrameDirection::ToDevice => FrameDirection::ToController,
        };
        if code.abort_reason() != Some(AbortReason::CONSUMER_TIMEOUT)
            && let Some(last) = evidence.accepted.last(id, other)
            && let Some(since) = now.since(last)
        {
            went.push(format!("the other side sent its last cyclic frame {} earlier", span(since)));
        }
        let Judgement { severity, mut blame, hint, advice } = match code.abort_reason() {
            Some(AbortReason::CONSUMER_TIMEOUT) => consumer_timeout(now, ar, (id, other), evidence),
            Some(reason) => judgement(now, ar, direction, reason, touched.map(|(_, by, _)| *by)),
            None => Judgement::new(FindingSeverity::Error, own(direction), ""),
        };
        if matches!(blame, CaptureBlame::Device | CaptureBlame::Controller) && !ar.roles_known {
            blame = CaptureBlame::Undecided;
        }
        let why = status(code);
        let text = format!("{who} ended the connection: {why}{hint}; before that: {}", went.join("; "));
        let finding = ABORTED.finding(severity, blame, now.frame, text).ar(id).observed(why);
        findings.add(match advice {
            Some((cause, next)) => finding.cause(cause).next(next),
            None => advised(finding, code.abort_reason().and_then(of_abort)),
        });
    }
}

/// The party that sends in a direction.
fn own(direction: FrameDirection) -> CaptureBlame {
    match direction {
        FrameDirection::ToController => CaptureBlame::Device,
        FrameDirection::ToDevice => CaptureBlame::Controller,
    }
}

/// The party that receives in a direction.
fn others(direction: FrameDirection) -> CaptureBlame {
    match direction {
        FrameDirection::ToController => CaptureBlame::Controller,
        FrameDirection::ToDevice => CaptureBlame::Device,
    }
}

/// Judges an abort for another reason than a watchdog; `touched`: the station that named, addressed or reset the device by DCP.
fn judgement(
    now: CapturePosition,
    ar: &ObservedAr,
    direction: FrameDirection,
    reason: AbortReason,
    touched: Option<Mac>,
) -> Judgement {
    use FindingSeverity::{Error, Info, Warning};
    let (own, others) = (own(direction), others(direction));
    let by_controller = direction == FrameDirection::ToDevice;
    match reason {
        AbortReason::RELEASE_RECEIVED if ar.release_frame.is_some() => {
            Judgement::new(Info, own, "; this is the normal end of a connection").advice(
                "The controller released the connection.",
                "Nothing; look why the controller did so if it should not.",
            )
        }
        AbortReason::RELEASE_RECEIVED if now.piece > 0 => {
            let hint = "; this is the normal end of a connection; its Release is not in the capture, which lost frames";
            Judgement::new(Info, CaptureBlame::Capture, hint)
        }
        AbortReason::RELEASE_RECEIVED => {
            let hint = "; no Release of the controller is in the capture before it";
            Judgement::new(Warning, CaptureBlame::Undecided, hint).advice(
                "The device ended the connection without a Release, another station released it, or the capture lost the Release.",
                "Look in the diagnostic buffer of the controller whether it released the device at this time.",
            )
        }
        AbortReason::ABORT_REQUEST | AbortReason::DEVICE_DEACTIVATED | AbortReason::AR_REMOVED if by_controller => {
            Judgement::new(Info, own, "; this is a deliberate end by the controller")
        }
        AbortReason::CMI_TIMEOUT | AbortReason::APPLICATION_READY_TIMEOUT => Judgement::new(Error, others, ""),
        AbortReason::STATION_NAME_CHANGED | AbortReason::RESET_TO_FACTORY | AbortReason::IP_SUITE_CHANGED => {
            let blame = match touched {
                Some(by) if by == ar.controller.mac() => CaptureBlame::Controller,
                Some(_) => CaptureBlame::Network,
                // It may have been done at the station itself.
                None => CaptureBlame::Undecided,
            };
            Judgement::new(Error, blame, "")
        }
        AbortReason::LINK_DOWN => Judgement::new(Error, CaptureBlame::Network, ""),
        // An alarm cannot be sent where the other side does not acknowledge it.
        AbortReason::ALARM_SEND => Judgement::new(Error, others, "; the other side did not acknowledge it"),
        AbortReason::PROTOCOL_VIOLATION | AbortReason::SEQUENCE => Judgement::new(Error, others, ""),
        AbortReason::RE_RUN => Judgement::new(Warning, others, ""),
        AbortReason::ABORT_REQUEST | AbortReason::DEVICE_DEACTIVATED => Judgement::new(Warning, own, ""),
        _ => Judgement::new(Error, own, ""),
    }
}

/// Judges an abort because of a watchdog by the frames that are really in the capture; `missed` is the direction of those frames.
fn consumer_timeout(
    now: CapturePosition,
    ar: &ObservedAr,
    (id, missed): (ArId, FrameDirection),
    evidence: AbortEvidence<'_>,
) -> Judgement {
    use FindingSeverity::{Error, Warning};
    let who = sender(ar, missed);
    let stream = ar.stream(missed);
    let around = evidence.surroundings.around(now, [ar.controller.mac(), ar.device.mac()]);
    let hint = |text: String| match around.is_empty() {
        true => text,
        false => format!("{text}; around it: {}", around.join("; ")),
    };
    let undecided = |text: String| Judgement::new(Error, CaptureBlame::Undecided, hint(text));
    let Some(last) = evidence.accepted.last(id, missed) else {
        return undecided(format!("; the capture shows no frame of {who} that its receiver accepts")).advice(
            "The frames did not reach the capture either, or the connection was made before it began.",
            "Capture again from before the start-up, at the port of the station that ended the connection.",
        );
    };
    let Some(since) = now.since(last) else {
        let text = format!("; the capture lost frames after the last one of {who}, so nothing is measured");
        return Judgement::new(Warning, CaptureBlame::Capture, hint(text));
    };
    let limit = stream.watchdog + stream.cycle;
    let is_over = since >= stream.watchdog;
    let was_interrupted = evidence.accepted.pause_before(id, missed, now, limit);
    let length = "their length is not the agreed one";
    let is_starved = evidence.accepted.is_starved(id);
    let others_came = stream.last.is_some_and(|other| other.since(last.time) > stream.cycle);
    if is_starved && others_came {
        return undecided(format!(
            "; frames of {who} come again after a silence longer than the watchdog: whether they were accepted is not known"
        ));
    }
    let refused =
        evidence.accepted.unacceptable(id, missed).or_else(|| others_came.then_some((last.frame + 1, length)));
    if let Some((frame, why)) = refused.filter(|_| is_over) {
        let text =
            format!("; frames of {who} are in the capture, but since frame {frame} they are not acceptable: {why}");
        let sender = own(missed);
        return Judgement::new(Error, sender, hint(text)).advice(
            format!("A receiver does not take such frames ({why}), so its watchdog expired."),
            "Look why the sender sends them: its program, its state, its configuration.",
        );
    }
    if since <= limit && was_interrupted.is_none() && !stream.watchdog.is_zero() {
        let text = format!(
            "; acceptable frames of {who} are in the capture until {} before it (watchdog {}): the network after the capture point, or \
             the receiver, undecided",
            span(since),
            span(stream.watchdog)
        );
        return undecided(text).advice(
            "The frames were lost between the capture point and the receiver, or the receiver was too busy to take them.",
            "Capture at the port of the receiver: if the frames are there too, the receiver is the cause; else the network is.",
        );
    }
    let (since, until) = match was_interrupted {
        Some(pause) if since <= limit => (pause, " long, shortly before it"),
        _ => (since, " before it"),
    };
    let watchdog = match stream.watchdog.is_zero() {
        true => "the agreed watchdog is not in the capture".to_owned(),
        false => format!("watchdog {}", span(stream.watchdog)),
    };
    let text = match until {
        " before it" => format!("; the last acceptable frame of {who} is {} before it ({watchdog})", span(since)),
        _ => format!("; no acceptable frame of {who} for {}{until} ({watchdog})", span(since)),
    };
    undecided(text).advice(
        "Its sender stopped, lost power or its link, or the frames were lost before the capture point.",
        "Check the power and the link of the sender, and capture at its port.",
    )
}

impl Aborts {
    /// Forgets what a watch that never ends need not remember.
    pub fn forget(&mut self, settled: SettledFrames<'_>) {
        self.events.retain(|ar, _| settled.keeps(*ar));
        self.touched.retain(|_, (when, ..)| when.frame > settled.old);
    }
}
