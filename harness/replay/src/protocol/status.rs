//! The status next to the cyclic data: STOP, problem, invalid; bad IOPS and IOCS of submodules.

use super::coverage::{CaptureCoverage, CapturePosition, FindingList};
use super::table::{
    ProtocolCheck, STATUS_BAD_CONSUMER, STATUS_BAD_PROVIDER, STATUS_INVALID, STATUS_PROBLEM, STATUS_STOP,
};
use super::text::{of, sender, span};
use crate::finding::{CaptureBlame, FindingSeverity};
use judge::observe::{ArId, ArStage, CyclicStatus, FrameDirection, Observation, ObservedAr, SubmodulePlacement};
use station::Duration;
use std::collections::BTreeMap;
use wire::profinet::rt::{DataStatus, IoxS};

/// After ApplicationReady both sides may need a few cycles until their data are good.
const GRACE: Duration = Duration::from_secs(1);
/// Upper limit of the checked submodules of one connection.
const MOST_SUBMODULES: usize = 64;
/// Upper limit of the remembered states.
const MOST_STATES: usize = 4_096;

/// A bad status of one direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum BadStatus {
    Stop,
    Problem,
    Invalid,
    /// The provider status (IOPS) of a submodule; index into those of the connection.
    Provider(u8),
    /// The consumer status (IOCS) of a submodule; index into those of the connection.
    Consumer(u8),
}

/// The bad statuses of one frame: the data status, and a bit for each submodule.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct BadStatuses {
    stop: bool,
    problem: bool,
    invalid: bool,
    providers: u64,
    consumers: u64,
}

#[derive(Clone, Copy, Debug)]
struct StatusPeriods {
    /// Since when it lasts; `None` if it has ended.
    since: Option<CapturePosition>,
    first: CapturePosition,
    octet: usize,
    count: u64,
    /// The duration of the longest one that has ended.
    longest: Duration,
    /// The frame in which the last one ended.
    ended: u64,
    /// Whether the first one began with the first frame that counts.
    from_the_start: bool,
}

#[derive(Clone, Copy, Debug)]
struct StatusWatch {
    /// The first frame that counts.
    begun: CapturePosition,
    state: BadStatuses,
}

/// The states of all connections.
#[derive(Debug, Default)]
pub(super) struct StatusChecks {
    watches: Vec<[Option<StatusWatch>; 2]>,
    spells: BTreeMap<(ArId, bool, BadStatus), StatusPeriods>,
}

impl StatusChecks {
    #[inline]
    pub fn observe(
        &mut self,
        now: CapturePosition,
        ars: &[ObservedAr],
        observation: &Observation<'_>,
        findings: &mut FindingList,
    ) {
        let Observation::Cyclic { ar: id, direction, data, at, status: CyclicStatus::Apdu(status) } = observation
        else {
            return;
        };
        let Some(ar) = of(ars, *id) else { return };
        // Before ApplicationReady the data need not be good. If the capture does not show the start-up, every frame counts.
        if ar.stage != ArStage::Ready && ar.connect_frame.is_some() {
            return;
        }
        let index = id.0 as usize;
        if self.watches.len() <= index {
            self.watches.resize(index + 1, [None; 2]);
        }
        let watch = &mut self.watches[index][*direction as usize];
        let state = BadStatuses::of(ar, *direction, data, status.data_status);
        match watch {
            Some(watch) if watch.state == state => return,
            Some(watch) => watch.state = state,
            None => *watch = Some(StatusWatch { begun: now, state }),
        }
        let begun = watch.map_or(now, |watch| watch.begun);
        if self.changed((now, begun), ar, (*id, *direction), *at, data.len(), state) {
            findings.note(now.frame);
        }
    }

    /// Whether a status is bad for the first time.
    #[cold]
    fn changed(
        &mut self,
        (now, begun): (CapturePosition, CapturePosition),
        ar: &ObservedAr,
        (id, direction): (ArId, FrameDirection),
        at: usize,
        length: usize,
        state: BadStatuses,
    ) -> bool {
        let mut first = false;
        let to_device = direction == FrameDirection::ToDevice;
        let apdu = at + length;
        let mut wrongs: Vec<(BadStatus, usize, bool)> = vec![
            (BadStatus::Stop, apdu + 2, state.stop),
            (BadStatus::Problem, apdu + 2, state.problem),
            (BadStatus::Invalid, apdu + 2, state.invalid),
        ];
        for (place, submodule) in ar.submodules.iter().take(MOST_SUBMODULES).enumerate() {
            let (provider, consumer) = places(submodule, direction);
            let bit = |mask: u64| mask >> place & 1 != 0;
            wrongs.extend(provider.map(|of| (BadStatus::Provider(place as u8), at + of, bit(state.providers))));
            wrongs.extend(consumer.map(|of| (BadStatus::Consumer(place as u8), at + of, bit(state.consumers))));
        }
        for (wrong, octet, is) in wrongs {
            let key = (id, to_device, wrong);
            let has_room = self.spells.len() < MOST_STATES;
            match (is, self.spells.get_mut(&key)) {
                (true, None) if has_room => {
                    let from_the_start = now.frame == begun.frame;
                    let (since, longest) = (Some(now), Duration::ZERO);
                    let spell = StatusPeriods { since, first: now, octet, count: 1, longest, ended: 0, from_the_start };
                    self.spells.insert(key, spell);
                    first = true;
                }
                (true, Some(spell)) if spell.since.is_none() => {
                    (spell.since, spell.count) = (Some(now), spell.count + 1);
                    if spell.from_the_start && spell.count == 2 && spell.longest < GRACE {
                        // A bad status right after the start-up does not count.
                        (spell.first, spell.octet, spell.count, spell.from_the_start) = (now, octet, 1, false);
                        first = true;
                    }
                }
                (false, Some(spell)) => {
                    if let Some(since) = spell.since.take() {
                        spell.longest = spell.longest.max(now.time.since(since.time));
                        spell.ended = now.frame;
                    }
                }
                _ => {}
            }
        }
        first
    }

    pub fn end(self, _sight: &CaptureCoverage, ars: &[ObservedAr], findings: &mut FindingList) {
        for ((id, to_device, wrong), spell) in &self.spells {
            let Some(ar) = of(ars, *id) else { continue };
            let direction = if *to_device { FrameDirection::ToDevice } else { FrameDirection::ToController };
            let last = ar.stream(direction).last.unwrap_or_default();
            let open = spell.since.map(|since| last.since(since.time));
            let lasted = open.map_or(spell.longest, |open| open.max(spell.longest));
            if spell.from_the_start && spell.count == 1 && lasted < GRACE && ar.connect_frame.is_some() {
                continue;
            }
            // A status in a single frame may be damage of the file.
            let cycle = ar.stream(direction).cycle;
            if spell.longest.max(lasted) * 2 < cycle * 3 {
                continue;
            }
            let has = |wrong: BadStatus| self.spells.contains_key(&(*id, *to_device, wrong));
            let opposite = |wrong: BadStatus| self.spells.contains_key(&(*id, !*to_device, wrong));
            let (check, severity) = match (wrong, to_device) {
                // In STOP, and with invalid data, all submodules are bad; their IOPS and IOCS add nothing.
                (BadStatus::Provider(_), true) if has(BadStatus::Stop) || has(BadStatus::Invalid) => continue,
                (BadStatus::Provider(_), _) if has(BadStatus::Invalid) => continue,
                (BadStatus::Consumer(place), _)
                    if opposite(BadStatus::Provider(*place)) || opposite(BadStatus::Stop) =>
                {
                    continue;
                }
                (BadStatus::Stop, true) => (STATUS_STOP, FindingSeverity::Info),
                (BadStatus::Stop, false) => (STATUS_STOP, FindingSeverity::Warning),
                (BadStatus::Problem, true) => (STATUS_PROBLEM, FindingSeverity::Info),
                (BadStatus::Problem, false) => (STATUS_PROBLEM, FindingSeverity::Warning),
                (BadStatus::Invalid, _) => (STATUS_INVALID, FindingSeverity::Warning),
                (BadStatus::Provider(_), true) => (STATUS_BAD_PROVIDER, FindingSeverity::Info),
                (BadStatus::Provider(_), false) => (STATUS_BAD_PROVIDER, FindingSeverity::Warning),
                (BadStatus::Consumer(_), true) => (STATUS_BAD_CONSUMER, FindingSeverity::Info),
                (BadStatus::Consumer(_), false) => (STATUS_BAD_CONSUMER, FindingSeverity::Warning),
            };
            report_period(check, severity, (ar, *id, direction), *wrong, (spell, lasted, open.is_some()), findings);
        }
    }
}

fn report_period(
    check: &ProtocolCheck,
    severity: FindingSeverity,
    (ar, id, direction): (&ObservedAr, ArId, FrameDirection),
    wrong: BadStatus,
    (spell, lasted, open): (&StatusPeriods, Duration, bool),
    findings: &mut FindingList,
) {
    let place = |index: u8| {
        let submodule = ar.submodules.get(usize::from(index));
        submodule.map_or_else(String::new, |of| format!("slot {} subslot 0x{:04X}", of.slot, of.subslot))
    };
    let (what, expected, bit) = match wrong {
        BadStatus::Stop => ("is in STOP state".to_owned(), "RUN", Some(4)),
        BadStatus::Problem => ("reports a problem".to_owned(), "no problem", Some(5)),
        BadStatus::Invalid => ("marks its data as invalid".to_owned(), "valid data", Some(2)),
        BadStatus::Provider(index) => {
            (format!("marks the data of {} as bad", place(index)), "IOPS good (0x80)", Some(7))
        }
        BadStatus::Consumer(index) => {
            (format!("does not accept the data of {}", place(index)), "IOCS good (0x80)", Some(7))
        }
    };
    let from = if spell.from_the_start { "from the first frame of the data exchange" } else { "from this frame on" };
    let until = match (open, spell.count) {
        (true, 1) => "until the last frame".to_owned(),
        (true, count) => format!("{count} times, last until the last frame"),
        (false, 1) => format!("until frame {}", spell.ended),
        (false, count) => format!("{count} times until frame {}", spell.ended),
    };
    let who = sender(ar, direction);
    let blame = match direction {
        FrameDirection::ToController => CaptureBlame::Device,
        FrameDirection::ToDevice => CaptureBlame::Controller,
    };
    let text = format!("{who} {what} {from}, {until}; longest duration {}", span(lasted));
    findings
        .add(check.finding(severity, blame, spell.first.frame, text).ar(id).at(spell.octet, bit).expected(expected));
}

/// The offsets of provider and consumer status of a submodule in the frames of a direction.
#[inline]
fn places(submodule: &SubmodulePlacement, direction: FrameDirection) -> (Option<usize>, Option<usize>) {
    match direction {
        FrameDirection::ToController => (submodule.input_status, submodule.output_consumer),
        FrameDirection::ToDevice => (submodule.output_status, submodule.input_consumer),
    }
}

impl BadStatuses {
    #[inline]
    fn of(ar: &ObservedAr, direction: FrameDirection, data: &[u8], status: DataStatus) -> BadStatuses {
        let bad = |at: Option<usize>| at.and_then(|at| data.get(at)).is_some_and(|octet| !IoxS(*octet).is_good());
        let mut state = BadStatuses {
            stop: !status.is_run(),
            problem: status.has_problem(),
            invalid: !status.is_valid(),
            ..BadStatuses::default()
        };
        for (place, submodule) in ar.submodules.iter().take(MOST_SUBMODULES).enumerate() {
            let (provider, consumer) = places(submodule, direction);
            state.providers |= u64::from(bad(provider)) << place;
            state.consumers |= u64::from(bad(consumer)) << place;
        }
        state
    }
}
