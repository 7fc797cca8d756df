//! Causes of differences that no capture shows: what a manual leaves to each device, and what happened to the power, the shaft and the stand.
//!
//! A cause is assumed if the device, driven again with it, differs in less and in nothing else. A difference that is gone then could be
//! explained by it. That is a possibility and no proof, so the difference is reported all the same.

use super::action::ControllerAction;
use super::compare::{ConversationClock, Difference, DifferenceKind, compare};
use super::conversation::{Conversation, SuiteValue};
use super::drive::{CannotDrive, ScriptBench};
use super::masks::Masks;
use super::shaft_fit::{ShaftFit, counts, differences};
use super::shaft_position::set_shaft;
use super::timed_script::TimedScript;
use engine::DutSpec;
use station::{Duration, Time};
use std::collections::{BTreeMap, BTreeSet};

/// Upper limits of the runs with which causes are tried, and of the samples of all these runs together.
const MOST_RUNS: u128 = 500;
const MOST_SAMPLES: u128 = 150_000;
/// How often all causes are tried: some have an effect only together with others.
const ROUNDS: usize = 5;
/// Before how many of the first differences something may have happened at the stand.
const FIRST: usize = 3;
/// How often the shaft is moved before the search for its new position is given up.
const MOVES: usize = 10;
/// How long the power is off at least: a device starts in the time until the next connection.
const OFF: Duration = Duration::from_millis(20);
/// For how long a button is held.
const HELD: Duration = Duration::from_secs(1);

/// What is known of a capture after the device was driven once.
pub(super) struct UnseenCauses<'a, 'm> {
    pub bench: &'a ScriptBench<'m>,
    pub recorded: &'a Conversation,
    pub masks: &'a Masks,
    pub fit: &'a ShaftFit,
}

/// A device and a stand that are assumed instead of the known ones.
#[derive(Clone, Debug)]
struct Assumption {
    dut: DutSpec,
    stand: Vec<(Time, ControllerAction)>,
}

/// What is assumed in addition.
enum AddedAssumption {
    Variation(&'static str),
    Stand(Vec<(Time, ControllerAction)>),
}

/// A cause, as an assumption and in words.
struct AssumedCause {
    adds: AddedAssumption,
    text: String,
    /// Whether the power was off: then all that differs later may only be missing.
    is_power: bool,
}

/// What makes a difference the same in two runs: its kind, its name and its step.
type DifferenceKey = (DifferenceKind, String, Option<usize>);

fn key(of: &Difference) -> DifferenceKey {
    (of.kind, of.name.clone(), of.step)
}

fn number(value: &Option<SuiteValue>) -> Option<i128> {
    value.as_ref().and_then(|value| value.number)
}

impl Assumption {
    fn with(&self, adds: &AddedAssumption) -> Assumption {
        let mut with = self.clone();
        match adds {
            AddedAssumption::Variation(name) => with.dut = with.dut.with_deviation(name),
            AddedAssumption::Stand(steps) => with.stand.extend(steps.iter().cloned()),
        }
        with
    }

    /// The last assumed raw position of the shaft.
    fn shaft(&self) -> Option<i128> {
        self.last("shaft.counts")?.parse().ok()
    }

    /// Whether a fault is present after all assumed steps.
    fn has_fault(&self, name: &str) -> bool {
        self.last(name) == Some("present")
    }

    /// The last assumed value of a name of the stand.
    fn last(&self, name: &str) -> Option<&str> {
        let sets = self.stand.iter().rev().filter_map(|(_, ask)| match ask {
            ControllerAction::Set(of) => Some(of),
            _ => None,
        });
        sets.flatten().find(|(known, _)| known == name).map(|(_, value)| value.as_str())
    }
}

/// The script of a capture with the shaft turned as recorded, and with each of the things that may have happened at the stand before the
/// device first differed from a reference device.
pub(super) fn stand_scripts(
    bench: &ScriptBench<'_>,
    reference: &DutSpec,
    recorded: &Conversation,
    masks: &Masks,
) -> Result<Vec<Vec<ControllerAction>>, CannotDrive> {
    let (mut masks, mut fit) = (masks.clone(), ShaftFit::default());
    let mut found = differences(bench, reference, recorded, (&mut masks, &[]), &mut fit)?;
    found.retain(|of| counts(recorded, of));
    let unseen = UnseenCauses { bench, recorded, masks: &masks, fit: &fit };
    let assumed = Assumption { dut: reference.clone(), stand: Vec::new() };
    let mut scripts: Vec<Vec<ControllerAction>> = Vec::new();
    if fit.turning.is_some() {
        scripts.push(unseen.script(&assumed));
    }
    for cause in unseen.of_the_stand(&assumed, &found)? {
        scripts.push(unseen.script(&assumed.with(&cause.adds)));
    }
    Ok(scripts)
}

impl UnseenCauses<'_, '_> {
    /// For each difference of `dut` a cause that could explain it.
    pub fn explain(&self, dut: &DutSpec, found: &[Difference]) -> Result<Vec<Option<String>>, CannotDrive> {
        let mut assumed = Assumption { dut: dut.clone(), stand: Vec::new() };
        let mut causes: Vec<String> = Vec::new();
        let mut gone: BTreeMap<DifferenceKey, String> = BTreeMap::new();
        let mut left = self.differs(&assumed)?.unwrap_or_default();
        let mut runs = 0;
        for _ in 0..ROUNDS {
            let before = causes.len();
            for search in [Self::of_the_stand, Self::permitted] {
                for cause in search(self, &assumed, &left)? {
                    if left.is_empty() || runs >= self.most_runs() {
                        break;
                    }
                    runs += 1;
                    let with = assumed.with(&cause.adds);
                    let known: BTreeSet<DifferenceKey> = left.iter().map(key).collect();
                    // What explains one difference and makes another one is no explanation, unless it explains most of them.
                    let explains = |next: &Vec<Difference>| {
                        let is_part = next.iter().all(|of| known.contains(&key(of)));
                        next.len() < left.len() && (is_part || (!cause.is_power && next.len() * 2 <= left.len()))
                    };
                    let Some(next) = self.differs(&with)?.filter(explains) else { continue };
                    let still: BTreeSet<DifferenceKey> = next.iter().map(key).collect();
                    for of in known.difference(&still) {
                        gone.entry(of.clone()).or_insert_with(|| cause.text.clone());
                    }
                    (assumed, left) = (with, next);
                    causes.push(cause.text);
                }
            }
            if left.is_empty() || causes.len() == before {
                break;
            }
        }
        let still = self.still(&assumed, &left, causes.is_empty(), found)?;
        let all = causes.join("; and ");
        let explained = |of: &Difference| {
            let same = key(of);
            let gone = (!still.contains(&same)).then(|| gone.get(&same).unwrap_or(&all).clone());
            gone.or_else(|| self.turned(of))
        };
        Ok(found.iter().map(explained).collect())
    }

    /// The differences that no cause explains: the shaft is found again for the assumed device, and what differs then remains.
    fn still(
        &self,
        assumed: &Assumption,
        left: &[Difference],
        is_same: bool,
        found: &[Difference],
    ) -> Result<BTreeSet<DifferenceKey>, CannotDrive> {
        if is_same {
            return Ok(found.iter().map(key).collect());
        }
        let mut masks = self.masks.clone();
        let mut fit = ShaftFit::default();
        match differences(self.bench, &assumed.dut, self.recorded, (&mut masks, &assumed.stand), &mut fit) {
            Ok(again) => Ok(again.iter().filter(|of| counts(self.recorded, of)).map(key).collect()),
            Err(CannotDrive::Nothing(_) | CannotDrive::NotUnderstood(_)) => Ok(left.iter().map(key).collect()),
            Err(error) => Err(error),
        }
    }

    /// How many runs are made: fewer, the longer the capture is.
    fn most_runs(&self) -> u128 {
        let begin = self.recorded.actions.first().map_or(Time::ZERO, |asked| asked.at);
        let cycle = self.recorded.cycle_or_usual().as_nanos();
        let samples = self.recorded.end.since(begin).as_nanos().checked_div(cycle).unwrap_or_default();
        MOST_SAMPLES.checked_div(samples).map_or(MOST_RUNS, |runs| runs.min(MOST_RUNS))
    }

    /// The turning shaft as a cause: how it turned is only known from the positions.
    fn turned(&self, of: &Difference) -> Option<String> {
        let is_place = self.recorded.tracks.get(&of.name).is_some_and(|track| track.is_place);
        let tolerance = self.masks.tolerance(self.recorded.cycle.unwrap_or_default());
        let text = "the shaft, which turned: how, is only known from the recorded positions";
        (is_place && self.masks.turns(of.at, tolerance)).then(|| text.to_owned())
    }

    /// The script of the capture with the assumed steps of the stand.
    fn script(&self, assumed: &Assumption) -> Vec<ControllerAction> {
        let (mut timed, turning) = match &self.fit.turning {
            Some((turning, timed)) => (timed.clone(), Some(turning)),
            None => (TimedScript::new(self.recorded), None),
        };
        assumed.stand.iter().for_each(|(at, ask)| timed.insert(*at, ask.clone()));
        let mut script = turning.map_or_else(|| timed.script(), |turning| turning.script(&timed, 0));
        if let Some(place) = self.fit.place.filter(|_| turning.is_none()) {
            script.insert(0, set_shaft(place));
        }
        script
    }

    /// What the device answers under an assumption; `None` if it cannot be driven so.
    fn drive(&self, assumed: &Assumption) -> Result<Option<Conversation>, CannotDrive> {
        match self.bench.drive(&self.script(assumed), &assumed.dut) {
            Ok(run) => Ok(Some(run)),
            Err(CannotDrive::Nothing(_) | CannotDrive::NotUnderstood(_)) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// The differences under an assumption, each name in each step once; `None` if the device cannot be driven so.
    fn differs(&self, assumed: &Assumption) -> Result<Option<Vec<Difference>>, CannotDrive> {
        let Some(run) = self.drive(assumed)? else { return Ok(None) };
        let mut found = compare(self.recorded, &run, self.masks);
        let follows =
            |of: &Difference| self.fit.follows.as_ref().is_some_and(|shaft| shaft.explains(of, self.recorded));
        found.retain(|of| counts(self.recorded, of) && !follows(of));
        Ok(Some(found))
    }

    /// The variations that the manual permits and that are not assumed yet.
    fn permitted(&self, assumed: &Assumption, _: &[Difference]) -> Result<Vec<AssumedCause>, CannotDrive> {
        let known = assumed.dut.variations();
        let all = assumed.dut.permitted_variations().into_iter().filter(|(name, _)| known.iter().all(|of| of != name));
        let causes = all.map(|(name, sentence)| AssumedCause {
            adds: AddedAssumption::Variation(name),
            is_power: false,
            text: format!("what the manual permits ({name}): {}", sentence.trim_end_matches('.')),
        });
        Ok(causes.collect())
    }

    /// What may have happened to the power, the shaft and the stand just before one of the first differences.
    fn of_the_stand(&self, assumed: &Assumption, left: &[Difference]) -> Result<Vec<AssumedCause>, CannotDrive> {
        let stand = &self.bench.manual().device.stand;
        let mut causes = Vec::new();
        let mut add = |steps: Vec<(Time, String, &str)>, text: String| {
            let is_power = steps.iter().any(|(_, name, _)| name == "power");
            let set =
                |(at, name, value): (Time, String, &str)| (at, ControllerAction::Set(vec![(name, value.to_owned())]));
            let adds = AddedAssumption::Stand(steps.into_iter().map(set).collect());
            causes.push(AssumedCause { adds, text, is_power });
        };
        let mut times: Vec<Time> =
            left.iter().take(if self.fit.turning.is_some() { 1 } else { FIRST }).map(|of| of.at).collect();
        times.dedup();
        for at in times {
            let early = self.before(at);
            let said = |what: &str| format!("{what} before {:.3} s", at.since(Time::ZERO).as_secs_f64());
            for (fault, _) in &stand.faults {
                let name = format!("fault.{fault}");
                if assumed.has_fault(&name) {
                    add(vec![(early, name, "absent")], said(&format!("the stand: the fault {fault}, which ended")));
                } else {
                    let from_begin = format!("the stand: the fault {fault} from the begin on");
                    add(vec![(Time::ZERO, name.clone(), "present")], from_begin);
                    add(vec![(early, name, "present")], said(&format!("the stand: the fault {fault}")));
                }
            }
            for (button, _) in &stand.buttons {
                let name = format!("button.{button}");
                let steps = vec![(early, name.clone(), "pressed"), (early + HELD, name, "released")];
                add(steps, said(&format!("the stand: the button {button}")));
            }
            let supplies =
                [("supply.voltage", stand.permitted_voltage), ("supply.temperature", stand.permitted_temperature)];
            for (name, range) in supplies {
                for limit in range.into_iter().flatten().map(|limit| limit.to_string()) {
                    add(vec![(early, name.to_owned(), limit.as_str())], said(&format!("the stand: {name} at {limit}")));
                }
            }
            let steps = vec![(early, "power".to_owned(), "down"), (early + OFF, "power".to_owned(), "up")];
            add(steps, said("the power, which was off"));
        }
        causes.extend(self.moved(assumed, left)?);
        Ok(causes)
    }

    /// The shaft at rest, moved at once to where the first position that differs is the recorded one.
    fn moved(&self, assumed: &Assumption, left: &[Difference]) -> Result<Option<AssumedCause>, CannotDrive> {
        let cycle = self.recorded.cycle_or_usual();
        let is_place = |of: &&Difference| self.recorded.tracks.get(&of.name).is_some_and(|track| track.is_place);
        let first = left.iter().find(|of| of.kind == DifferenceKind::Input && is_place(of));
        let Some((of, place)) = first.zip(self.fit.place) else { return Ok(None) };
        let Some((wanted, mut observed)) = number(&of.first).zip(number(&of.second)) else { return Ok(None) };
        let (mut counts, mut before) = (assumed.shaft().unwrap_or(place), None::<(i128, i128)>);
        for _ in 0..MOVES {
            let missing = wanted - observed;
            let step = match before {
                Some((at, seen)) if seen != observed => (missing * (counts - at)).checked_div(observed - seen),
                _ => Some(missing),
            };
            before = Some((counts, observed));
            counts = (counts + step.filter(|step| *step != 0).unwrap_or(missing)).max(0);
            let adds = AddedAssumption::Stand(vec![(self.before(of.at), set_shaft(counts))]);
            let Some(run) = self.drive(&assumed.with(&adds))? else { return Ok(None) };
            let at = ConversationClock::between(self.recorded, &run).there(of.at + cycle * 2);
            let shown = at.and_then(|at| number(&run.tracks.get(&of.name)?.at(at)?.value));
            match shown {
                Some(shown) if shown == wanted => {
                    let seconds = of.at.since(Time::ZERO).as_secs_f64();
                    let text = format!("the shaft, which was moved before {seconds:.3} s");
                    return Ok(Some(AssumedCause { adds, text, is_power: false }));
                }
                Some(shown) => observed = shown,
                None => return Ok(None),
            }
        }
        Ok(None)
    }

    /// Two cycles earlier, but not before the connection.
    fn before(&self, at: Time) -> Time {
        let cycle = self.recorded.cycle_or_usual();
        let early = Time::from_nanos(at.as_nanos().saturating_sub((cycle * 2).as_nanos() as u64));
        let connected = self.recorded.actions.iter().filter(|asked| matches!(asked.ask, ControllerAction::Connect(_)));
        connected.map(|asked| asked.done).filter(|done| *done <= at).fold(early, Time::max)
    }
}
