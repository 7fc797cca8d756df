//! The status beside the cyclic data: STOP, problem, invalid; data of submodules that are bad, or not taken.

use super::sight::{Now, Sight, Told};
use super::table::{Check, STATUS_BAD_CONSUMER, STATUS_BAD_PROVIDER, STATUS_INVALID, STATUS_PROBLEM, STATUS_STOP};
use super::words::{of, sender, span};
use crate::finding::{Blame, Severity};
use judge::observe::{Ar, ArId, CyclicStatus, Direction, Observation, Placed, Stage};
use station::Duration;
use std::collections::BTreeMap;
use wire::profinet::rt::{DataStatus, IoxS};

/// Right after ApplicationReady both sides may need a few cycles to come to data that are good.
const GRACE: Duration = Duration::from_secs(1);
/// Submodules of one connection that are looked at.
const MOST_SUBMODULES: usize = 64;
/// States that are remembered.
const MOST_STATES: usize = 4_096;

/// What may be wrong with the frames of one direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Wrong {
    Stop,
    Problem,
    Invalid,
    /// The provider status of a submodule (index into those of the connection).
    Provider(u8),
    /// The consumer status of a submodule.
    Consumer(u8),
}

/// What is wrong in one frame: the data status, and a bit for each submodule.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct State {
    stop: bool,
    problem: bool,
    invalid: bool,
    providers: u64,
    consumers: u64,
}

#[derive(Clone, Copy, Debug)]
struct Spell {
    /// Whether it is so now.
    since: Option<Now>,
    first: Now,
    octet: usize,
    count: u64,
    /// How long the longest lasted that has ended.
    longest: Duration,
    /// The frame in which the last one ended.
    ended: u64,
    /// Whether the first one began with the first frame that counts.
    from_the_start: bool,
}

#[derive(Clone, Copy, Debug)]
struct Watch {
    /// The first frame that counts.
    begun: Now,
    state: State,
}

/// The states of all connections.
#[derive(Debug, Default)]
pub(super) struct Statuses {
    watches: Vec<[Option<Watch>; 2]>,
    spells: BTreeMap<(ArId, bool, Wrong), Spell>,
}

impl Statuses {
    #[inline]
    pub fn observe(&mut self, now: Now, ars: &[Ar], observation: &Observation<'_>, told: &mut Told) {
        let Observation::Cyclic { ar: id, direction, data, at, status: CyclicStatus::Apdu(status) } = observation
        else {
            return;
        };
        let Some(ar) = of(ars, *id) else { return };
        // Until the device is ready its data need not be good; where the start was not seen they count at once.
        if ar.stage != Stage::Ready && ar.connect_frame.is_some() {
            return;
        }
        let index = id.0 as usize;
        if self.watches.len() <= index {
            self.watches.resize(index + 1, [None; 2]);
        }
        let watch = &mut self.watches[index][*direction as usize];
        let state = State::of(ar, *direction, data, status.data_status);
        match watch {
            Some(watch) if watch.state == state => return,
            Some(watch) => watch.state = state,
            None => *watch = Some(Watch { begun: now, state }),
        }
        let begun = watch.map_or(now, |watch| watch.begun);
        if self.changed((now, begun), ar, (*id, *direction), *at, data.len(), state) {
            told.note(now.frame);
        }
    }

    /// Whether something is wrong for the first time.
    #[cold]
    fn changed(
        &mut self,
        (now, begun): (Now, Now),
        ar: &Ar,
        (id, direction): (ArId, Direction),
        at: usize,
        length: usize,
        state: State,
    ) -> bool {
        let mut first = false;
        let to_device = direction == Direction::ToDevice;
        let apdu = at + length;
        let mut wrongs: Vec<(Wrong, usize, bool)> = vec![
            (Wrong::Stop, apdu + 2, state.stop),
            (Wrong::Problem, apdu + 2, state.problem),
            (Wrong::Invalid, apdu + 2, state.invalid),
        ];
        for (place, submodule) in ar.submodules.iter().take(MOST_SUBMODULES).enumerate() {
            let (provider, consumer) = places(submodule, direction);
            let bit = |mask: u64| mask >> place & 1 != 0;
            wrongs.extend(provider.map(|of| (Wrong::Provider(place as u8), at + of, bit(state.providers))));
            wrongs.extend(consumer.map(|of| (Wrong::Consumer(place as u8), at + of, bit(state.consumers))));
        }
        for (wrong, octet, is) in wrongs {
            let key = (id, to_device, wrong);
            let has_room = self.spells.len() < MOST_STATES;
            match (is, self.spells.get_mut(&key)) {
                (true, None) if has_room => {
                    let from_the_start = now.frame == begun.frame;
                    let (since, longest) = (Some(now), Duration::ZERO);
                    let spell = Spell { since, first: now, octet, count: 1, longest, ended: 0, from_the_start };
                    self.spells.insert(key, spell);
                    first = true;
                }
                (true, Some(spell)) if spell.since.is_none() => {
                    (spell.since, spell.count) = (Some(now), spell.count + 1);
                    if spell.from_the_start && spell.count == 2 && spell.longest < GRACE {
                        // What was so right after the start did not count.
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

    pub fn end(self, _sight: &Sight, ars: &[Ar], told: &mut Told) {
        for ((id, to_device, wrong), spell) in &self.spells {
            let Some(ar) = of(ars, *id) else { continue };
            let direction = if *to_device { Direction::ToDevice } else { Direction::ToController };
            let last = ar.stream(direction).last.unwrap_or_default();
            let open = spell.since.map(|since| last.since(since.time));
            let lasted = open.map_or(spell.longest, |open| open.max(spell.longest));
            if spell.from_the_start && spell.count == 1 && lasted < GRACE && ar.connect_frame.is_some() {
                continue;
            }
            // What stands in one frame alone may be damage of the file.
            let cycle = ar.stream(direction).cycle;
            if spell.longest.max(lasted) * 2 < cycle * 3 {
                continue;
            }
            let has = |wrong: Wrong| self.spells.contains_key(&(*id, *to_device, wrong));
            let opposite = |wrong: Wrong| self.spells.contains_key(&(*id, !*to_device, wrong));
            let (check, severity) = match (wrong, to_device) {
                // In STOP and with invalid data the data of all submodules are bad, which says nothing more.
                (Wrong::Provider(_), true) if has(Wrong::Stop) || has(Wrong::Invalid) => continue,
                (Wrong::Provider(_), _) if has(Wrong::Invalid) => continue,
                (Wrong::Consumer(place), _) if opposite(Wrong::Provider(*place)) || opposite(Wrong::Stop) => continue,
                (Wrong::Stop, true) => (STATUS_STOP, Severity::Info),
                (Wrong::Stop, false) => (STATUS_STOP, Severity::Warning),
                (Wrong::Problem, true) => (STATUS_PROBLEM, Severity::Info),
                (Wrong::Problem, false) => (STATUS_PROBLEM, Severity::Warning),
                (Wrong::Invalid, _) => (STATUS_INVALID, Severity::Warning),
                (Wrong::Provider(_), true) => (STATUS_BAD_PROVIDER, Severity::Info),
                (Wrong::Provider(_), false) => (STATUS_BAD_PROVIDER, Severity::Warning),
                (Wrong::Consumer(_), true) => (STATUS_BAD_CONSUMER, Severity::Info),
                (Wrong::Consumer(_), false) => (STATUS_BAD_CONSUMER, Severity::Warning),
            };
            tell(check, severity, (ar, *id, direction), *wrong, (spell, lasted, open.is_some()), told);
        }
    }
}

fn tell(
    check: &Check,
    severity: Severity,
    (ar, id, direction): (&Ar, ArId, Direction),
    wrong: Wrong,
    (spell, lasted, open): (&Spell, Duration, bool),
    told: &mut Told,
) {
    let place = |index: u8| {
        let submodule = ar.submodules.get(usize::from(index));
        submodule.map_or_else(String::new, |of| format!("slot {} subslot 0x{:04X}", of.slot, of.subslot))
    };
    let (what, expected, bit) = match wrong {
        Wrong::Stop => ("is in STOP".to_owned(), "RUN", Some(4)),
        Wrong::Problem => ("signals a problem".to_owned(), "no problem", Some(5)),
        Wrong::Invalid => ("marks its data as invalid".to_owned(), "valid data", Some(2)),
        Wrong::Provider(index) => (format!("marks the data of {} as bad", place(index)), "IOPS good (0x80)", Some(7)),
        Wrong::Consumer(index) => (format!("does not take the data of {}", place(index)), "IOCS good (0x80)", Some(7)),
    };
    let from = if spell.from_the_start { "from the first frame of the exchange on" } else { "from this frame on" };
    let until = match (open, spell.count) {
        (true, 1) => "up to the last one".to_owned(),
        (true, count) => format!("{count} times, the last time up to the last frame"),
        (false, 1) => format!("up to frame {}", spell.ended),
        (false, count) => format!("{count} times up to frame {}", spell.ended),
    };
    let who = sender(ar, direction);
    let blame = match direction {
        Direction::ToController => Blame::Device,
        Direction::ToDevice => Blame::Controller,
    };
    let text = format!("{who} {what} {from}, {until}; the longest time lasted {}", span(lasted));
    told.add(check.finding(severity, blame, spell.first.frame, text).ar(id).at(spell.octet, bit).expected(expected));
}

/// Where provider and consumer status of a submodule lie in the frames of a direction.
#[inline]
fn places(submodule: &Placed, direction: Direction) -> (Option<usize>, Option<usize>) {
    match direction {
        Direction::ToController => (submodule.input_status, submodule.output_consumer),
        Direction::ToDevice => (submodule.output_status, submodule.input_consumer),
    }
}

impl State {
    #[inline]
    fn of(ar: &Ar, direction: Direction, data: &[u8], status: DataStatus) -> State {
        let bad = |at: Option<usize>| at.and_then(|at| data.get(at)).is_some_and(|octet| !IoxS(*octet).is_good());
        let mut state = State {
            stop: !status.is_run(),
            problem: status.has_problem(),
            invalid: !status.is_valid(),
            ..State::default()
        };
        for (place, submodule) in ar.submodules.iter().take(MOST_SUBMODULES).enumerate() {
            let (provider, consumer) = places(submodule, direction);
            state.providers |= u64::from(bad(provider)) << place;
            state.consumers |= u64::from(bad(consumer)) << place;
        }
        state
    }
}
