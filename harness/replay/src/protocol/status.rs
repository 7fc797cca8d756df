//! The status next to the cyclic data: STOP, problem, invalid; bad IOPS and IOCS of submodules.

use super::advice::{Advice, advised};
use super::coverage::{CaptureCoverage, CapturePosition, FindingList, SettledFrames};
use super::table::{
    ODD_FRAME, ProtocolCheck, STATUS_BAD_CONSUMER, STATUS_BAD_PROVIDER, STATUS_INVALID, STATUS_PROBLEM, STATUS_STOP,
};
use super::text::{of, sender, span};
use crate::finding::{CaptureBlame, FindingSeverity};
use judge::observe::{ArId, ArStage, CyclicStatus, FrameDirection, Observation, ObservedAr, SubmodulePlacement};
use station::Duration;
use std::collections::BTreeMap;
use wire::profinet::rt::{DataStatus, IoxS};

/// What to read when a device reports a problem.
pub(super) const READ_DIAGNOSIS: Option<Advice> = Some((
    "A diagnosis is pending at the device, or at a module of it.",
    "Read its diagnosis: record 0xF80C for the whole device, 0x800C for a subslot; and the alarms before this frame.",
));

/// What STOP of a device means.
const APPLICATION_STOPPED: Option<Advice> = Some((
    "The application of the device was stopped, restarts, or has a fault.",
    "Read its diagnosis and look at its LEDs; compare the alarms before this frame.",
));
/// What STOP of a controller means.
const PROGRAM_STOPPED: Option<Advice> = Some((
    "The program of the controller was stopped: by its switch, by an engineering tool, or by an error.",
    "Read the entries of the controller's diagnostic buffer from this time.",
));

/// After ApplicationReady both sides may need a few cycles until their data are good.
const GRACE: Duration = Duration::from_secs(1);
/// In a running machine what lasts longer than so many watchdogs is an error.
const WATCHDOGS: u32 = 3;
/// The longest watchdog of PROFINET (IEC 61158-6-10), where the agreed one is not in the capture.
const LONGEST_WATCHDOG: Duration = Duration::from_millis(1_920);
/// So many single odd frames are no accident.
const OFTEN: u64 = 3;
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
    /// The first frame that counts, and the last one.
    begun: CapturePosition,
    last: CapturePosition,
    state: BadStatuses,
}

/// The states of all connections.
#[derive(Clone, Debug, Default)]
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
        // Ignore says that the status may not be evaluated; which of a redundant pair is the backup only the Connect says.
        let is_backup = ar.connect_frame.is_none() && !status.data_status.has(DataStatus::PRIMARY);
        if status.data_status.has(DataStatus::IGNORE) || is_backup {
            return;
        }
        let index = id.0 as usize;
        if self.watches.len() <= index {
            self.watches.resize(index + 1, [None; 2]);
        }
        let watch = &mut self.watches[index][*direction as usize];
        let state = BadStatuses::of(ar, *direction, data, status.data_status);
        match watch {
            Some(watch) => {
                let (before, known) = (watch.last, watch.state);
                (watch.last, watch.state) = (now, state);
                if before.piece != now.piece {
                    self.restart((*id, *direction), now);
                }
                if known == state {
                    return;
                }
            }
            None => *watch = Some(StatusWatch { begun: now, last: now, state }),
        }
        let watch = &self.watches[index][*direction as usize];
        let begun = watch.map_or(now, |watch| watch.begun);
        if self.changed((now, begun), ar, (*id, *direction), *at, data.len(), state) {
            findings.note(now.frame);
        }
    }

    /// Nothing is measured across a hole of the capture: what lasts begins again after it.
    #[cold]
    fn restart(&mut self, (id, direction): (ArId, FrameDirection), now: CapturePosition) {
        let to_device = direction == FrameDirection::ToDevice;
        let own = self.spells.iter_mut().filter(|((of, to, _), _)| (*of, *to) == (id, to_device));
        for spell in own.filter_map(|(_, spell)| spell.since.as_mut()) {
            *spell = now;
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
                        spell.longest = spell.longest.max(now.since(since).unwrap_or_default());
                        spell.ended = now.frame;
                    }
                }
                _ => {}
            }
        }
        first
    }

    pub fn end(self, _sight: &CaptureCoverage, ars: &[ObservedAr], findings: &mut FindingList) {
        let mut odd: BTreeMap<(ArId, bool, u64), Vec<&'static str>> = BTreeMap::new();
        for ((id, to_device, wrong), spell) in &self.spells {
            let Some(ar) = of(ars, *id) else { continue };
            let direction = if *to_device { FrameDirection::ToDevice } else { FrameDirection::ToController };
            let watch = self.watches.get(id.0 as usize).and_then(|of| of[direction as usize]);
            let last = watch.map_or_else(CapturePosition::default, |watch| watch.last);
            let open = spell.since.map(|since| last.since(since).unwrap_or_default());
            let lasted = open.map_or(spell.longest, |open| open.max(spell.longest));
            if spell.from_the_start && spell.count == 1 && lasted < GRACE && ar.connect_frame.is_some() {
                continue;
            }
            // A status in a single frame may be damage of the file. At the end of the capture nothing says how long it lasts.
            let cycle = ar.stream(direction).cycle;
            if spell.longest.max(lasted) * 2 < cycle * 3 && (open.is_some() || spell.count < OFTEN) {
                if open.is_none() {
                    odd.entry((*id, *to_device, spell.first.frame)).or_default().push(wrong.words());
                }
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
                (BadStatus::Stop, true) => (STATUS_STOP, of_running(ar, spell, lasted, FindingSeverity::Info)),
                (BadStatus::Stop, false) => (STATUS_STOP, of_running(ar, spell, lasted, FindingSeverity::Warning)),
                (BadStatus::Problem, _) => (STATUS_PROBLEM, FindingSeverity::Warning),
                (BadStatus::Invalid, _) => (STATUS_INVALID, of_running(ar, spell, lasted, FindingSeverity::Warning)),
                (BadStatus::Provider(_), true) => (STATUS_BAD_PROVIDER, FindingSeverity::Info),
                (BadStatus::Provider(_), false) => (STATUS_BAD_PROVIDER, FindingSeverity::Warning),
                (BadStatus::Consumer(_), true) => (STATUS_BAD_CONSUMER, FindingSeverity::Info),
                (BadStatus::Consumer(_), false) => (STATUS_BAD_CONSUMER, FindingSeverity::Warning),
            };
            report_period(check, severity, (ar, *id, direction), *wrong, (spell, lasted, open.is_some()), findings);
        }
        for ((id, to_device, frame), what) in odd {
            let Some(ar) = of(ars, id) else { continue };
            let direction = if to_device { FrameDirection::ToDevice } else { FrameDirection::ToController };
            let text = format!(
                "a single frame of {} {}; the capture may be damaged here",
                sender(ar, direction),
                what.join(", and ")
            );
            findings.add(ODD_FRAME.finding(FindingSeverity::Warning, CaptureBlame::Capture, frame, text).ar(id));
        }
    }
}

/// The severity of STOP or invalid data: an error if they last in a machine that ran, or whose start is not in the capture.
fn of_running(ar: &ObservedAr, spell: &StatusPeriods, lasted: Duration, otherwise: FindingSeverity) -> FindingSeverity {
    let watchdog = ar.inputs.watchdog.max(ar.outputs.watchdog);
    let watchdog = if watchdog.is_zero() { LONGEST_WATCHDOG } else { watchdog };
    // A controller in STOP also connects, and one that stops releases its devices afterwards.
    let never_ran = spell.from_the_start && spell.count == 1 && ar.connect_frame.is_some();
    let is_end = spell.since.is_some() && ar.release_frame.is_some();
    match lasted > watchdog * WATCHDOGS && !never_ran && !is_end {
        true => FindingSeverity::Error,
        false => otherwise,
    }
}

impl BadStatus {
    /// What a single frame with this status says, as a predicate.
    fn words(self) -> &'static str {
        match self {
            BadStatus::Stop => "is in STOP state",
            BadStatus::Problem => "reports a problem",
            BadStatus::Invalid => "marks its data as invalid",
            BadStatus::Provider(_) => "marks the data of a submodule as bad",
            BadStatus::Consumer(_) => "does not accept the data of a submodule",
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
        _ if wrong == BadStatus::Problem => CaptureBlame::Undecided,
        FrameDirection::ToController => CaptureBlame::Device,
        FrameDirection::ToDevice => CaptureBlame::Controller,
    };
    let mut text = format!("{who} {what} {from}, {until}; longest duration {}", span(lasted));
    if (wrong, direction) == (BadStatus::Stop, FrameDirection::ToDevice) {
        text.push_str("; that its controller stands is a fact about the machine and no fault of the device");
    }
    let finding =
        check.finding(severity, blame, spell.first.frame, text).ar(id).at(spell.octet, bit).expected(expected);
    findings.add(match (wrong, direction) {
        (BadStatus::Problem, FrameDirection::ToController) => advised(finding, READ_DIAGNOSIS),
        (BadStatus::Stop, FrameDirection::ToController) => advised(finding, APPLICATION_STOPPED),
        (BadStatus::Stop, FrameDirection::ToDevice) => advised(finding, PROGRAM_STOPPED),
        _ => finding,
    });
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

impl StatusChecks {
    /// Forgets what a watch that never ends need not remember.
    pub fn forget(&mut self, settled: SettledFrames<'_>) {
        let is_over = |spell: &StatusPeriods| spell.since.is_none() && spell.ended <= settled.reported;
        self.spells.retain(|key, spell| settled.keeps(key.0) && !is_over(spell));
        for ArId(index) in settled.forgotten {
            if let Some(watches) = self.watches.get_mut(*index as usize) {
                *watches = [None; 2];
            }
        }
    }
}
