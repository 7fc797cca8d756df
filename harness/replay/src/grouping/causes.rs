//! One cause is one finding: what follows from another finding is listed under it.
//!
//! This module must not know how a finding was made, only which checks follow from which.

use crate::finding::{CaptureBlame, CaptureFinding};
use crate::protocol::table::*;
use crate::report::ConnectionReport;
use wire::profinet::status::{AbortReason, PnioStatus};

/// What a cause and its consequence have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum CommonGround {
    /// The connection.
    Connection,
    /// The connection, and the consequence is found in the same frame.
    Frame,
    /// The frame, whatever the connection.
    SameFrame,
    /// The connection, and a slot and subslot.
    Submodule,
    /// Controller and device, also in another connection.
    Pair,
    /// A station that the cause names.
    Station,
    /// Nothing but the time.
    Time,
}

/// Checks whose findings follow from those of others.
struct CauseRule {
    causes: &'static [&'static ProtocolCheck],
    consequences: &'static [&'static ProtocolCheck],
    common: CommonGround,
    /// The consequence is found at most so many seconds before its cause, and so many after it.
    seconds: (f64, f64),
    /// Whether this consequence follows, by its blame and the reason of the ERR-RTA.
    is_possible: fn(&CaptureFinding, Option<AbortReason>) -> bool,
}

const fn follows(
    causes: &'static [&'static ProtocolCheck],
    consequences: &'static [&'static ProtocolCheck],
    common: CommonGround,
    seconds: (f64, f64),
) -> CauseRule {
    CauseRule { causes, consequences, common, seconds, is_possible: |_, _| true }
}

/// Seconds after which the end of a connection no longer follows from what a third party did.
const LATE: f64 = 60.0;

const RULES: &[CauseRule] = &[
    follows(
        &[SET_RUNNING, RESET_RUNNING],
        &[
            ABORTED,
            START_INCOMPLETE,
            CYCLE_SILENT,
            CYCLE_LOST,
            RECORD_REFUSED,
            CALL_FAILED,
            CALL_UNANSWERED,
            ALARM_UNACKNOWLEDGED,
            STATUS_STOP,
            STATUS_PROBLEM,
            STATUS_INVALID,
            STATUS_BAD_PROVIDER,
            STATUS_BAD_CONSUMER,
        ],
        CommonGround::Connection,
        (0.0, LATE),
    ),
    follows(
        &[SET_RUNNING, RESET_RUNNING],
        &[START_REFUSED, START_UNANSWERED, START_INCOMPLETE, CALL_FAILED, RECORD_REFUSED, NAME_UNKNOWN, NAME_DUPLICATE],
        CommonGround::Pair,
        (0.0, LATE),
    ),
    follows(
        &[NAME_DUPLICATE, ADDRESS_DUPLICATE],
        &[START_UNANSWERED, START_REFUSED, START_INCOMPLETE, CALL_UNANSWERED],
        CommonGround::Station,
        (2.0, LATE),
    ),
    CauseRule {
        is_possible: |_, reason| reason == Some(AbortReason::IP_SUITE_CHANGED),
        ..follows(&[ADDRESS_DUPLICATE], &[ABORTED], CommonGround::Station, (2.0, LATE))
    },
    follows(
        &[ADDRESS_FORGED],
        &[ABORTED, CYCLE_SILENT, CYCLE_LOST, START_UNANSWERED, START_INCOMPLETE, CALL_UNANSWERED],
        CommonGround::Station,
        (0.0, 10.0),
    ),
    follows(
        &[FLOOD],
        &[ABORTED, CYCLE_SILENT, CYCLE_LOST, START_UNANSWERED, START_INCOMPLETE, CALL_UNANSWERED, CALL_SLOW],
        CommonGround::Time,
        (0.0, 5.0),
    ),
    CauseRule {
        is_possible: |_, reason| reason.is_none_or(|of| of == AbortReason::CONSUMER_TIMEOUT || is_of_start(of)),
        ..follows(
            &[CYCLE_SILENT],
            &[ABORTED, START_INCOMPLETE, CALL_UNANSWERED, ALARM_UNACKNOWLEDGED],
            CommonGround::Connection,
            (2.0, LATE),
        )
    },
    CauseRule {
        is_possible: |_, reason| reason.is_some_and(is_of_start),
        ..follows(&[START_INCOMPLETE], &[ABORTED], CommonGround::Connection, (2.0, LATE))
    },
    CauseRule {
        is_possible: |_, reason| {
            reason.is_some_and(|of| [AbortReason::ALARM_SEND, AbortReason::ALARM_ACK_SEND].contains(&of))
        },
        ..follows(&[ALARM_UNACKNOWLEDGED], &[ABORTED], CommonGround::Connection, (2.0, LATE))
    },
    CauseRule {
        is_possible: |_, reason| reason.is_some_and(is_of_calls),
        ..follows(&[CALL_UNANSWERED, ANSWER_MALFORMED], &[ABORTED], CommonGround::Connection, (2.0, LATE))
    },
    follows(&[CALL_UNANSWERED, ANSWER_MALFORMED], &[START_INCOMPLETE], CommonGround::Connection, (2.0, LATE)),
    // A controller that gives up after a refusal.
    CauseRule {
        is_possible: |of, _| of.blame == CaptureBlame::Controller,
        ..follows(&[RECORD_REFUSED], &[START_INCOMPLETE, ABORTED], CommonGround::Connection, (0.0, LATE))
    },
    follows(
        &[ABORTED],
        &[CALL_FAILED, RECORD_REFUSED, CALL_UNANSWERED, ALARM_UNACKNOWLEDGED],
        CommonGround::Connection,
        (0.0, LATE),
    ),
    CauseRule {
        is_possible: |_, reason| !reason.is_some_and(is_of_start),
        ..follows(&[ABORTED], &[START_INCOMPLETE], CommonGround::Frame, (0.0, 0.0))
    },
    follows(&[ABORTED, CYCLE_SILENT], &[START_AGAIN], CommonGround::Frame, (0.0, 0.0)),
    follows(
        &[START_MODULES],
        &[STATUS_BAD_PROVIDER, STATUS_BAD_CONSUMER, RECORD_REFUSED],
        CommonGround::Submodule,
        (0.0, f64::MAX),
    ),
    follows(&[ALARM_DIAGNOSIS], &[STATUS_PROBLEM], CommonGround::Connection, (2.0, 2.0)),
    follows(&[ALARM_DIAGNOSIS], &[STATUS_BAD_PROVIDER, STATUS_BAD_CONSUMER], CommonGround::Submodule, (2.0, f64::MAX)),
    follows(
        &[STATUS_STOP],
        &[STATUS_INVALID, STATUS_PROBLEM, STATUS_BAD_PROVIDER],
        CommonGround::SameFrame,
        (0.0, 0.0),
    ),
    follows(&[STATUS_INVALID], &[STATUS_BAD_PROVIDER], CommonGround::SameFrame, (0.0, 0.0)),
    follows(
        &[DP_ADDRESS, DP_OTHER_MASTER],
        &[DP_SILENT, DP_LEFT, DP_WATCHDOG, DP_UNANSWERED, DP_DIAGNOSIS],
        CommonGround::Connection,
        (0.0, LATE),
    ),
    follows(
        &[DP_PARAMETER_FAULT, DP_CONFIGURATION_FAULT],
        &[DP_DIAGNOSIS, DP_LEFT],
        CommonGround::Connection,
        (1.0, LATE),
    ),
    follows(&[DP_WATCHDOG, DP_LEFT, DP_SILENT], &[DP_UNANSWERED], CommonGround::Connection, (0.5, LATE)),
    follows(&[DP_WATCHDOG], &[DP_LEFT, DP_SILENT], CommonGround::Connection, (1.0, LATE)),
    follows(
        &[DP_TOKEN_TWICE],
        &[DP_DAMAGED, DP_TOKEN_LOST, DP_UNANSWERED, DP_REPEATED],
        CommonGround::Time,
        (1.0, LATE),
    ),
];

/// Whether a reason says that a step of the start-up is missing.
fn is_of_start(reason: AbortReason) -> bool {
    [AbortReason::CMI_TIMEOUT, AbortReason::APPLICATION_READY_TIMEOUT].contains(&reason)
}

/// Whether a reason says that a call failed.
fn is_of_calls(reason: AbortReason) -> bool {
    reason == AbortReason::RPC_CLIENT_CALL || (AbortReason::RPC_BIND.0..=AbortReason::RPC_CONTROL.0).contains(&reason.0)
}

/// Lists each finding that follows from another one under it. The blame of a consequence is that of its cause, unless it is the capture;
/// a cause is as severe as what follows from it.
pub(crate) fn under_their_causes(findings: Vec<CaptureFinding>, ars: &[ConnectionReport]) -> Vec<CaptureFinding> {
    let mut parents: Vec<Option<usize>> = vec![None; findings.len()];
    let causes: Vec<usize> = (0..findings.len()).filter(|at| is_cause(&findings[*at])).collect();
    for (at, of) in findings.iter().enumerate() {
        let explaining = causes.iter().copied().filter(|cause| *cause != at && explains(&findings[*cause], of, ars));
        // A cause of the connection itself says more than one that only came at the same time; the last one before is meant.
        parents[at] = explaining.min_by_key(|cause| {
            let frame = findings[*cause].frame;
            (strength(&findings[*cause], of), frame > of.frame, frame.abs_diff(of.frame))
        });
    }
    let roots: Vec<Option<usize>> = (0..findings.len()).map(|at| root(&parents, at)).collect();
    let mut consequences: Vec<Vec<CaptureFinding>> = vec![Vec::new(); findings.len()];
    let mut kept: Vec<(usize, CaptureFinding)> = Vec::new();
    for (at, finding) in findings.into_iter().enumerate() {
        match roots[at] {
            Some(root) => consequences[root].push(finding),
            None => kept.push((at, finding)),
        }
    }
    let with_consequences = kept.into_iter().map(|(at, mut finding)| {
        for mut consequence in std::mem::take(&mut consequences[at]) {
            finding.severity = finding.severity.max(consequence.severity);
            if consequence.blame != CaptureBlame::Capture {
                consequence.blame = finding.blame;
            }
            (consequence.cause, consequence.next) = (None, None);
            finding.consequences.push(consequence);
        }
        finding
    });
    with_consequences.collect()
}

fn is_cause(finding: &CaptureFinding) -> bool {
    RULES.iter().any(|rule| has(rule.causes, finding))
}

fn has(checks: &[&ProtocolCheck], finding: &CaptureFinding) -> bool {
    checks.iter().any(|check| check.id == finding.id)
}

/// The finding from which one follows in the end; `None` for one that follows from none, and for a circle.
fn root(parents: &[Option<usize>], at: usize) -> Option<usize> {
    let mut root = parents[at]?;
    for _ in 0..parents.len() {
        match parents[root] {
            Some(next) if next == at => return None,
            Some(next) => root = next,
            None => return Some(root),
        }
    }
    None
}

/// The place of the first rule by which one follows from the other.
fn strength(cause: &CaptureFinding, of: &CaptureFinding) -> usize {
    RULES.iter().position(|rule| has(rule.causes, cause) && has(rule.consequences, of)).unwrap_or(RULES.len())
}

fn explains(cause: &CaptureFinding, of: &CaptureFinding, ars: &[ConnectionReport]) -> bool {
    RULES.iter().any(|rule| {
        has(rule.causes, cause)
            && has(rule.consequences, of)
            && is_at_the_time(cause, of, rule.seconds)
            && is_common(rule.common, cause, of, ars)
            && (rule.is_possible)(of, reason(of, ars))
    })
}

/// The reason of the ERR-RTA that a finding is about.
fn reason(finding: &CaptureFinding, ars: &[ConnectionReport]) -> Option<AbortReason> {
    let abort = ars.get(finding.ar?)?.abort.filter(|abort| abort.frame == finding.frame)?;
    PnioStatus::from(abort.code).abort_reason()
}

fn is_at_the_time(cause: &CaptureFinding, of: &CaptureFinding, (before, after): (f64, f64)) -> bool {
    match (cause.time, of.time) {
        (Some(cause), Some(of)) => (-before..=after).contains(&(of - cause)),
        _ => of.frame >= cause.frame,
    }
}

fn is_common(common: CommonGround, cause: &CaptureFinding, of: &CaptureFinding, ars: &[ConnectionReport]) -> bool {
    let is_same = cause.ar.is_some() && cause.ar == of.ar && cause.bus == of.bus;
    match common {
        CommonGround::Connection => is_same,
        CommonGround::Frame => is_same && cause.frame == of.frame,
        CommonGround::SameFrame => cause.frame == of.frame && cause.ar == of.ar,
        CommonGround::Submodule => is_same && submodules(cause).any(|place| names(of, place)),
        CommonGround::Pair => is_same_pair(cause, of, ars),
        CommonGround::Station => stations(of, ars).iter().any(|station| cause.text.contains(station)),
        CommonGround::Time => cause.bus == of.bus,
    }
}

/// The submodules, as `slot 1 subslot 0x0002`, that a finding names.
fn submodules(finding: &CaptureFinding) -> impl Iterator<Item = &str> {
    const LENGTH: usize = " subslot 0x0000".len();
    let texts = finding.details.iter().chain([&finding.text]);
    texts.flat_map(|text| text.match_indices("slot ").map(move |(at, _)| (text, at))).filter_map(|(text, at)| {
        let rest = text.get(at..)?;
        let end = rest.find(" subslot 0x")?;
        // Another slot in between belongs to the next place.
        let is_next = rest.get(5..end)?.bytes().all(|octet| octet.is_ascii_digit());
        rest.get(..end + LENGTH).filter(|_| is_next)
    })
}

fn names(finding: &CaptureFinding, place: &str) -> bool {
    finding.text.contains(place) || finding.details.iter().any(|detail| detail.contains(place))
}

/// The stations of the connection of a finding: MAC addresses and station names in quotation marks.
fn stations(finding: &CaptureFinding, ars: &[ConnectionReport]) -> Vec<String> {
    let Some(ar) = finding.ar.and_then(|ar| ars.get(ar)) else { return Vec::new() };
    let macs = [&ar.controller.mac, &ar.device.mac].into_iter().flatten().cloned();
    macs.chain(ar.device.station.iter().map(|name| format!("'{name}'"))).collect()
}

fn is_same_pair(cause: &CaptureFinding, of: &CaptureFinding, ars: &[ConnectionReport]) -> bool {
    let Some(ar) = cause.ar.and_then(|ar| ars.get(ar)) else { return false };
    match of.ar.and_then(|ar| ars.get(ar)) {
        Some(other) => {
            (&ar.controller.mac, ar.controller.address) == (&other.controller.mac, other.controller.address)
                && (&ar.device.mac, ar.device.address) == (&other.device.mac, other.device.address)
        }
        // The search for the name that the device had.
        None if of.id == NAME_UNKNOWN.id => {
            ar.device.station.as_ref().is_some_and(|name| of.text.contains(&format!("'{name}'")))
        }
        None => ar.device.mac.as_ref().is_some_and(|mac| of.text.contains(mac.as_str())),
    }
}
