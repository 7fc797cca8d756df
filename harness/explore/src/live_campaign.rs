//! Exploring a live device: what differs before any sequence is learned first, and a difference counts only if it shows each time and no
//! other waits explain it.

use crate::bench::{CannotExplore, ExploreBench};
use crate::campaign::{Campaign, CampaignEvent, CampaignEvents, Finding};
use crate::described::DeviceWords;
use crate::difference::{DifferenceName, LogDifference, LogDifferenceKind};
use crate::learn::LearnedReference;
use crate::live_steps::with_other_waits;
use crate::minimise::minimise;
use crate::names::SequenceNames;
use crate::sequence::at_position;
use crate::sequence_log::{SILENCE, SequenceLog};
use crate::settled::SETTLING;
use crate::step::SequenceStep;
use compare::action::{ConnectAction, ControllerAction};
use engine::DutSpec;
use std::time::{Duration, Instant};

/// How often a difference has to show before it is shortened.
const REPEATS: usize = 2;
/// How many other waits of the reference device are tried to explain a difference.
const OTHER_WAITS: u64 = 12;
/// How many sets of variations are tried.
const MOST_RUNS: usize = 100;
/// How many shorter sequences are tried for a finding, and for how long.
const MOST_TRIES: usize = 80;
const LONGEST_SHORTENING: Duration = Duration::from_secs(90);
/// The most modules that are connected before the sequences, and names that are read at once.
const MOST_MODULES: usize = 12;
const READ_TOGETHER: usize = 10;
/// The position of the shaft meanwhile, in hardware steps.
const SHAFT: u64 = 0x1234;

/// What a live device does differently before any sequence, which is not compared.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IgnoredDifference {
    pub name: String,
    /// What the reference device does.
    pub reference: String,
    /// What this device does.
    pub device: String,
}

/// Reads all that the manual names in a connection with each module. Variations that explain what differs are learned, and what they do
/// not explain is not compared from now on: it is returned.
pub fn learn_baseline(
    bench: &mut ExploreBench<'_>,
    dut: &DutSpec,
    reference: &mut LearnedReference,
) -> Result<Vec<IgnoredDifference>, CannotExplore> {
    let mut list: Vec<IgnoredDifference> = Vec::new();
    for steps in baseline(bench) {
        let mut steps = steps;
        bench.retain_possible(&mut steps, dut);
        if steps.is_empty() {
            continue;
        }
        let loaded = bench.load(std::slice::from_ref(&steps))?;
        let other = bench.run(&loaded, 0, dut)?;
        if let Some(why) = other.spoilt {
            return Err(CannotExplore::Nothing(format!("the device cannot be read before the sequences: {why}")));
        }
        if other.is_silent() {
            let why = other.log.protocol_errors.first().map(|of| of.what.clone()).unwrap_or_default();
            return Err(CannotExplore::Nothing(why));
        }
        reference.approach(bench, &loaded, 0, &other);
        let expected = bench.run(&loaded, 0, &reference.device())?;
        while let Some(found) = bench.first(&expected, &other) {
            if found.kind.is_error() {
                break;
            }
            let words = DeviceWords { device: &bench.manual().device, variant: bench.variant_index() };
            list.push(IgnoredDifference {
                name: words.name(&found, [&expected.log, &other.log]),
                reference: words.value(&expected.log, &found),
                device: words.value(&other.log, &found),
            });
            bench.ignore(&found);
        }
    }
    Ok(list)
}

/// Sequences that only connect and read.
fn baseline(bench: &ExploreBench<'_>) -> Vec<Vec<SequenceStep>> {
    let names = SequenceNames::of(bench.manual());
    let pause = || SequenceStep::from(ControllerAction::Wait(SETTLING * 2));
    let read = |names: &[String]| SequenceStep::from(ControllerAction::Read(names.to_vec()));
    let mut list = Vec::new();
    for (index, module) in names.modules.iter().take(MOST_MODULES).enumerate() {
        let connect = ConnectAction { module: module.name.clone(), ..ConnectAction::default() };
        let shaft = names.stand.has_shaft.then(|| at_position(SHAFT));
        let mut steps: Vec<SequenceStep> = shaft.into_iter().collect();
        steps.extend([ControllerAction::Connect(connect).into(), pause()]);
        if index == 0 {
            steps.extend(names.readable.chunks(READ_TOGETHER).map(read));
            steps.extend(names.records.iter().map(|(_, fields)| read(fields)));
            if names.on_profinet {
                let station = ["name", "ip", "mask", "gateway", "vendor_id", "device_id", "type"];
                steps.push(read(&station.map(|name| format!("station.{name}"))));
            }
            steps.push(pause());
        }
        list.push(steps);
    }
    list
}

/// Whether a step puts the shaft to a position.
fn is_of_shaft(step: &SequenceStep) -> bool {
    matches!(&step.action, ControllerAction::Set(entries) if entries.iter().any(|(name, _)| name == "shaft.counts"))
}

impl Campaign<'_, '_> {
    /// Confirms a difference on a live device, then shortens its sequence.
    pub(crate) fn live_difference(
        &mut self,
        number: u64,
        steps: &[SequenceStep],
        found: &LogDifference,
        events: CampaignEvents<'_>,
    ) -> Result<(), CannotExplore> {
        let target = found.target();
        let shows = |this: &Self, steps: &[SequenceStep]| this.shows(steps).is_some_and(|of| of.target() == target);
        if !(0..REPEATS).all(|_| shows(self, steps)) || self.is_explained(steps, found)? {
            return self.unconfirmed(found);
        }
        let name = self.words().name(found, [&Default::default(), &Default::default()]);
        let place = self.result.findings.len() + 1;
        events(CampaignEvent::Confirmed { number: place, name: &name, steps });
        let (began, mut left) = (Instant::now(), MOST_TRIES);
        // Without its first step the position of the shaft is any.
        let (shaft, rest) = match steps {
            [first, rest @ ..] if is_of_shaft(first) => (std::slice::from_ref(first), rest),
            rest => (&[][..], rest),
        };
        let whole = |rest: &[SequenceStep]| [shaft, rest].concat();
        let rest = minimise(rest.to_vec(), &mut |rest| {
            left -= usize::from(left > 0);
            left > 0 && began.elapsed() < LONGEST_SHORTENING && shows(self, &whole(rest))
        });
        let mut small = whole(&rest);
        if self.is_explained(&small, found)? {
            small = steps.to_vec();
        }
        let loaded = self.bench.load(std::slice::from_ref(&small))?;
        let [reference, other] = self.both(&loaded)?;
        self.known.insert(target);
        match self.bench.first(&reference, &other) {
            Some(rest) if other.spoilt.is_none() => {
                self.finding((number, steps.len()), &small, [&reference, &other], &rest, events)
            }
            _ => self.unstable(number, &small, found, events),
        }
    }

    fn unconfirmed(&mut self, found: &LogDifference) -> Result<(), CannotExplore> {
        let name = self.words().name(found, [&Default::default(), &Default::default()]);
        *self.result.unconfirmed.entry(name).or_default() += 1;
        Ok(())
    }

    /// Whether permitted variations, or waits that are a little longer or shorter, make the reference device do the same.
    fn is_explained(&mut self, steps: &[SequenceStep], found: &LogDifference) -> Result<bool, CannotExplore> {
        if self.reference.is_none() {
            return Ok(false);
        }
        let loaded = self.bench.load(std::slice::from_ref(&steps.to_vec()))?;
        let [_, other] = self.both(&loaded)?;
        if other.spoilt.is_some() {
            return Ok(true);
        }
        for number in 1..=OTHER_WAITS {
            let loaded = self.bench.load(&[with_other_waits(steps, number)])?;
            let expected = self.expected(&loaded, 0, &other)?;
            if self.bench.first(&expected, &other).is_none_or(|of| of.target() != found.target()) {
                return Ok(true);
            }
        }
        match &mut self.reference {
            Some(learned) => learned.explain(self.bench, &loaded, 0, &other, MOST_RUNS),
            None => Ok(false),
        }
    }

    /// The device does not answer before a sequence: what it did before is the finding, and nothing more can be found.
    pub(crate) fn lost_device(
        &mut self,
        number: u64,
        steps: &[SequenceStep],
        other: &SequenceLog,
        events: CampaignEvents<'_>,
    ) -> Result<(), CannotExplore> {
        let again = self.bench.drive(steps, self.dut)?;
        if !again.is_silent() {
            *self.result.unconfirmed.entry(SILENCE.to_owned()).or_default() += 1;
            return Ok(());
        }
        let what = other.log.protocol_errors.first().map(|of| of.what.clone()).unwrap_or_default();
        let last = std::mem::take(&mut self.last);
        self.known.insert((LogDifferenceKind::Protocol, DifferenceName::Protocol(SILENCE)));
        let finding = Finding {
            name: SILENCE.to_owned(),
            kind: LogDifferenceKind::Protocol,
            reference: "it answers".to_owned(),
            device: what,
            sequence: number.saturating_sub(1),
            before: last.len(),
            steps: last,
            case: None,
            rules: Vec::new(),
            is_stable: true,
        };
        self.add(finding, events);
        self.result.ended = Some("the device no longer answers; the steps are those of the sequence before".to_owned());
        Ok(())
    }
}
