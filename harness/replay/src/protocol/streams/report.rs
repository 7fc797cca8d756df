//! The findings on streams without a Connect, and what of them was judged.

use super::super::advice::{PAUSED, advised};
use super::super::coverage::{CaptureCoverage, FindingList};
use super::super::gaps::{GapList, GapReport, OFTEN};
use super::super::status::READ_DIAGNOSIS;
use super::super::table::{
    CYCLE_COUNTER, CYCLE_SILENT, ODD_FRAME, ProtocolCheck, STATUS_INVALID, STATUS_PROBLEM, STATUS_STOP,
};
use super::super::text::{party, span};
use super::identity::StationIdentities;
use super::{Reading, StreamStatus, WATCHDOG, WatchedStream};
use crate::finding::{CaptureBlame, CaptureFinding, FindingSeverity};
use crate::report::StreamCoverage;
use judge::observe::{Address, ObservedAr, Party};
use station::Duration;
use wire::ethernet::Mac;

/// What lasts longer than so many watchdogs in a running machine is an error.
const WATCHDOGS: u32 = 3;

/// Who sends a stream, and whom a finding on it blames.
struct StreamSender {
    text: String,
    blame: CaptureBlame,
    peer: String,
}

/// Reports what is wrong in a stream; `gaps` are those of the connections, `called` is the frame of the last call of its sender.
pub(super) fn report(
    stream: &WatchedStream,
    (all, gaps): (&[WatchedStream], &[(Mac, &GapList)]),
    (called, identities): (u64, &StationIdentities),
    sight: &CaptureCoverage,
    ars: &[ObservedAr],
    findings: &mut FindingList,
) {
    let who = sender(stream, all, identities, ars);
    statuses(stream, &who, findings);
    counter(stream, &who, findings);
    lost(stream, (all, gaps), &who, findings);
    if let Some(pause) = pause(stream, &who) {
        findings.add(pause);
    }
    // A station that called after its last cyclic frame has ended the connection, or established another one.
    if called <= stream.last.frame {
        silence(stream, all, sight, ars, &who, findings);
    }
}

/// What of a stream was judged.
pub(super) fn coverage(stream: &WatchedStream, identities: &StationIdentities, ars: &[ObservedAr]) -> StreamCoverage {
    let (source, destination, frame_id) = stream.name;
    let (judged, mut why) = match &stream.reading {
        Reading::Located(_) if stream.unread < stream.frames => {
            ("status", "its Connect is not in the capture, so its contents were not judged".to_owned())
        }
        _ => ("nothing", "neither its Connect nor the place of its status is in the capture".to_owned()),
    };
    if judged == "status" && stream.unevaluated > 0 {
        why += &format!("; the status of {} frames is that of a backup or to be ignored", stream.unevaluated);
    }
    if judged == "status" && stream.unread > 0 {
        why += &format!("; {} frames are too short", stream.unread);
    }
    let sender = identities.of(source, ars).words();
    let [source, destination] = [source, destination].map(|mac| mac.to_string());
    StreamCoverage { source, destination, frame_id, frames: stream.frames, judged, why, sender }
}

/// Its role is known if the capture shows a call of both stations; otherwise the first of a pair that sends is station A.
fn sender(
    stream: &WatchedStream,
    all: &[WatchedStream],
    identities: &StationIdentities,
    ars: &[ObservedAr],
) -> StreamSender {
    let (source, destination, _) = stream.name;
    let known = ars.iter().filter(|ar| ar.roles_known).find_map(|ar| {
        if (ar.device.mac(), ar.controller.mac()) == (source, destination) {
            Some(("device", &ar.device, "controller", &ar.controller, CaptureBlame::Device))
        } else if (ar.controller.mac(), ar.device.mac()) == (source, destination) {
            Some(("controller", &ar.controller, "device", &ar.device, CaptureBlame::Controller))
        } else {
            None
        }
    });
    match known {
        Some((own, one, others, other, blame)) => {
            StreamSender { text: format!("{own} {}", party(one)), blame, peer: format!("{others} {}", party(other)) }
        }
        None => {
            let pair = |of: &&WatchedStream| {
                let (from, to, _) = of.name;
                (from, to) == (source, destination) || (from, to) == (destination, source)
            };
            let first = all.iter().find(pair).map_or(source, |of| of.name.0);
            let text = |mac: Mac| {
                let letter = if mac == first { 'A' } else { 'B' };
                let station = identities.of(mac, ars).name;
                format!("station {letter} ({})", party(&Party { station, ..Party::at(Address::Mac(mac)) }))
            };
            StreamSender { text: text(source), blame: CaptureBlame::Undecided, peer: text(destination) }
        }
    }
}

/// Reports STOP, problem and invalid data.
fn statuses(stream: &WatchedStream, who: &StreamSender, findings: &mut FindingList) {
    let named = [
        (STATUS_STOP, "is in STOP state", "RUN", 4),
        (STATUS_PROBLEM, "reports a problem", "no problem", 5),
        (STATUS_INVALID, "marks its data as invalid", "valid data", 2),
    ];
    for ((check, what, expected, bit), watch) in named.into_iter().zip(&stream.states) {
        let Some(first) = watch.first else { continue };
        // A single odd frame may be damage of the capture.
        if watch.frames == 1 && watch.since.is_none() {
            let text = format!("a single frame of {} {what}; the capture may be damaged here", who.text);
            findings.add(ODD_FRAME.finding(FindingSeverity::Warning, CaptureBlame::Capture, first.frame, text));
            continue;
        }
        let severity = severity(check, stream, watch);
        let from = if first.frame == stream.first.frame { "from its first frame" } else { "from this frame on" };
        let until = match (watch.since.is_some(), watch.times) {
            (true, 1) => "until its last frame".to_owned(),
            (true, times) => format!("{times} times, last until its last frame"),
            (false, 1) => format!("until frame {}", watch.ended),
            (false, times) => format!("{times} times until frame {}", watch.ended),
        };
        let text = format!("{} {what} {from}, {until}; longest duration {}", who.text, span(watch.longest));
        let (blame, advice) = match check == STATUS_PROBLEM {
            true => (CaptureBlame::Undecided, READ_DIAGNOSIS),
            false => (who.blame, None),
        };
        let finding = check.finding(severity, blame, first.frame, text).at(watch.octet, Some(bit)).expected(expected);
        findings.add(advised(finding, advice));
    }
}

/// A machine whose provider stands, or whose data are invalid, for the whole capture or for long does not run.
fn severity(check: &ProtocolCheck, stream: &WatchedStream, watch: &StreamStatus) -> FindingSeverity {
    let is_whole = watch.frames + stream.unread + stream.unevaluated == stream.frames;
    match check == STATUS_PROBLEM {
        true => FindingSeverity::Warning,
        false if is_whole || watch.longest > WATCHDOG * WATCHDOGS => FindingSeverity::Error,
        false => FindingSeverity::Warning,
    }
}

fn counter(stream: &WatchedStream, who: &StreamSender, findings: &mut FindingList) {
    let (still, jumps) = (stream.counter.still, stream.counter.jumps);
    if still.0 >= OFTEN && still.0 * 2 > stream.frames - stream.frames_before {
        let text = format!("the cycle counter of {} stands still in {} of {} frames", who.text, still.0, stream.frames);
        findings.add(CYCLE_COUNTER.finding(FindingSeverity::Warning, who.blame, still.1, text));
    }
    if jumps.0 >= OFTEN {
        let text = format!(
            "the cycle counter of {} advances by another step than its usual one in {} of {} frames, although they come in time",
            who.text, jumps.0, stream.frames
        );
        findings.add(CYCLE_COUNTER.finding(FindingSeverity::Warning, who.blame, jumps.1, text));
    }
}

/// Reports missing frames; gaps of several senders at the same time are gaps of the capture.
fn lost(
    stream: &WatchedStream,
    (all, gaps): (&[WatchedStream], &[(Mac, &GapList)]),
    who: &StreamSender,
    findings: &mut FindingList,
) {
    let own = &stream.counter.gaps;
    if own.is_empty() {
        return;
    }
    let others = all.iter().map(|other| (other.name.0, &other.counter.gaps)).chain(gaps.iter().copied());
    let others = others.filter(|(sender, _)| *sender != stream.name.0).map(|(_, gaps)| gaps);
    let report = GapReport {
        who: &who.text,
        frames: stream.frames,
        more: "",
        others: "senders",
        alone: ("they were lost on the network or by a mirror port, or not sent", CaptureBlame::Undecided),
    };
    own.findings(others, [].into_iter(), &report).for_each(|finding| findings.add(finding));
}

/// The finding of a stream that paused for longer than the longest watchdog. Who fell silent and what lost frames look alike.
fn pause(stream: &WatchedStream, who: &StreamSender) -> Option<CaptureFinding> {
    let (longest, frame) = stream.longest;
    let step = match &stream.reading {
        Reading::Located(place) => Some(place.step),
        _ => None,
    };
    let advanced = stream.counter.pause.filter(|(pause, _)| *pause == longest).map(|(_, advanced)| advanced);
    if advanced.is_some() && advanced == step {
        let text = format!(
            "{} paused for {}: after it its cycle counter continues by one step, so it sent no frame in between",
            who.text,
            span(longest)
        );
        let finding = CYCLE_SILENT.finding(FindingSeverity::Error, who.blame, frame, text);
        return (longest > WATCHDOG).then(|| advised(finding, PAUSED));
    }
    let counter = match advanced {
        Some(_) => {
            "; its cycle counter then went on with the time, which it does whether frames were sent and lost or not sent"
        }
        None => "",
    };
    let text = format!(
        "{} sent no cyclic frame for {}; the agreed watchdog is not in the capture, the longest possible one is {}{counter}",
        who.text,
        span(longest),
        span(WATCHDOG)
    );
    let finding = CYCLE_SILENT.finding(FindingSeverity::Error, CaptureBlame::Undecided, frame, text);
    (longest > WATCHDOG).then_some(finding)
}

/// Reports a stream that ended before the capture.
fn silence(
    stream: &WatchedStream,
    all: &[WatchedStream],
    sight: &CaptureCoverage,
    ars: &[ObservedAr],
    who: &StreamSender,
    findings: &mut FindingList,
) {
    let Some(quiet) = sight.now.since(stream.last).filter(|quiet| *quiet > WATCHDOG) else { return };
    let (source, destination, _) = stream.name;
    let of_pair = |one: Mac, other: Mac| (one, other) == (source, destination) || (one, other) == (destination, source);
    // What ended or replaced the connection is reported by itself, or is no fault.
    let is_explained = ars.iter().filter(|ar| of_pair(ar.controller.mac(), ar.device.mac())).any(|ar| {
        let later = |frame: Option<u64>| frame.is_some_and(|frame| frame >= stream.first.frame);
        later(ar.connect_frame)
            || later(ar.release_frame)
            || later(ar.abort.map(|(frame, _)| frame))
            || ar.inputs.frames + ar.outputs.frames > 0
    });
    if is_explained {
        return;
    }
    let other = all.iter().find(|other| (other.name.0, other.name.1) == (destination, source));
    let went_on = other.map_or(Duration::ZERO, |other| other.last.time.since(stream.last.time));
    let went_on_first = other.is_some_and(|other| stream.last.time > other.last.time);
    if went_on_first {
        return;
    }
    let (severity, blame, text) = if went_on > WATCHDOG / 2 {
        let text = format!(
            "{} sent its last cyclic frame {} before the end of the capture, while {} went on for {}",
            who.text,
            span(quiet),
            who.peer,
            span(went_on)
        );
        (FindingSeverity::Error, CaptureBlame::Undecided, text)
    } else {
        let text = format!(
            "{} and the other side sent their last cyclic frames {} before the end of the capture, without a Release or an ERR-RTA: the \
             link was interrupted, or the capture ended for them",
            who.text,
            span(quiet)
        );
        (FindingSeverity::Warning, CaptureBlame::Undecided, text)
    };
    findings.add(CYCLE_SILENT.finding(severity, blame, stream.last.frame, text));
}
