//! Sequences: connections one after the other, with activities in each.

use crate::activity::{Activities, abort};
use crate::draw::Draw;
use crate::names::{ModuleNames, SequenceNames};
use crate::requests;
use crate::retention;
use crate::schedule::Schedule;
use crate::step::SequenceStep;
use compare::action::{ConnectAction, ControllerAction};
use std::time::Duration;
use suite::model::Manual;

/// The most connections of a sequence.
const MOST_CONNECTIONS: u64 = 4;
/// The cycle of connections that say none.
const USUAL_CYCLE: Duration = Duration::from_millis(4);

/// A connection and what is done until the next one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SequencePart {
    pub connect: ConnectAction,
    pub steps: Vec<SequenceStep>,
}

/// Draws sequences for the devices of a manual.
pub struct SequenceSource {
    names: SequenceNames,
    is_broad: bool,
}

impl SequenceSource {
    pub fn new(manual: &Manual) -> SequenceSource {
        SequenceSource { names: SequenceNames::of(manual), is_broad: false }
    }

    /// Draws everything that the suite language can say, also requests and start-ups that are broken on purpose.
    pub fn broad(manual: &Manual) -> SequenceSource {
        SequenceSource { is_broad: true, ..SequenceSource::new(manual) }
    }

    /// The steps of the sequence of this seed. They begin with the position of the shaft, which otherwise depends on the name of the case.
    pub fn steps(&self, seed: u64) -> Vec<SequenceStep> {
        let shaft = self.names.stand.has_shaft.then(|| at_position(Draw::new(seed).number(18)));
        let parts = self.sequence(seed).into_iter();
        let of_parts =
            parts.flat_map(|part| std::iter::once(ControllerAction::Connect(part.connect).into()).chain(part.steps));
        shaft.into_iter().chain(of_parts).collect()
    }

    /// A sequence about what a power cycle keeps, of this seed.
    pub(crate) fn retention(&self, save: u16, seed: u64) -> Option<Vec<SequenceStep>> {
        retention::sequence(&self.names, save, &mut Draw::new(seed))
    }

    /// The sequence of this seed.
    pub fn sequence(&self, seed: u64) -> Vec<SequencePart> {
        let mut draw = Draw::new(seed);
        let count = draw.between(1, MOST_CONNECTIONS);
        (0..count).filter_map(|_| self.part(&mut draw)).collect()
    }

    fn part(&self, draw: &mut Draw) -> Option<SequencePart> {
        let (connect, module) = self.connect(draw)?;
        let lengths = if self.is_broad { [10, 20, 60, 150] } else { [20, 60, 150, 300] };
        let length = *draw.one(&lengths)?;
        let activities = Activities { names: &self.names, module, length, is_broad: self.is_broad };
        let mut schedule = Schedule::default();
        activities.hold(draw, &mut schedule);
        for _ in 0..draw.between(1, 6 + length / 6) {
            activities.add(draw, &mut schedule);
        }
        let cycle = cycle(&connect);
        let mut steps = schedule.steps(cycle, length);
        if self.is_broad && draw.chance(40) {
            steps.extend(requests::everything(&self.names, draw));
        }
        steps.extend(self.ending(draw).into_iter().map(SequenceStep::from));
        Some(SequencePart { connect, steps })
    }

    /// A connection of a case or any other, with its module.
    fn connect(&self, draw: &mut Draw) -> Option<(ConnectAction, &ModuleNames)> {
        let mut connect = match draw.one(&self.names.starts).filter(|_| draw.chance(60)) {
            Some(start) => start.clone(),
            None => {
                let module = draw.one(&self.names.modules)?.name.clone();
                ConnectAction { module, ..ConnectAction::default() }
            }
        };
        let module = self.names.module(&connect.module)?;
        for _ in 0..draw.between(0, 3) {
            let Some(field) = draw.one(&module.parameters) else { continue };
            let value = field.values.draw(draw);
            connect.settings.retain(|(known, _)| *known != field.name);
            connect.settings.push((field.name.clone(), value));
        }
        let says_times =
            connect.settings.iter().any(|(name, _)| ["cycle", "watchdog", "isochronous"].contains(&name.as_str()));
        if !says_times && draw.chance(30) {
            connect.settings.push(("cycle".to_owned(), (*draw.one(&["1ms", "2ms", "8ms"])?).to_owned()));
        }
        if self.is_broad && draw.chance(15) {
            connect.instead.extend(requests::wrong_start(&self.names, &module.start_records, draw));
        }
        Some((connect, module))
    }

    /// How a connection ends: by the next one, by the controller, by power or by the link.
    fn ending(&self, draw: &mut Draw) -> Vec<ControllerAction> {
        let set = |name: &str, value: &str| ControllerAction::Set(vec![(name.to_owned(), value.to_owned())]);
        let pause = |draw: &mut Draw| ControllerAction::Wait(Duration::from_millis(draw.between(1, 400)));
        match draw.between(0, 9) {
            0 => vec![ControllerAction::Disconnect, pause(draw)],
            1 if self.names.on_profinet => vec![abort(), pause(draw)],
            2 => vec![set("power", "down"), pause(draw), set("power", "up"), pause(draw)],
            3 => vec![set("link", "down"), pause(draw), set("link", "up"), pause(draw)],
            // Whatever is still to come may come.
            4..=5 => vec![ControllerAction::Wait(Duration::from_millis(draw.between(100, 1500)))],
            _ => Vec::new(),
        }
    }
}

/// The step that turns the shaft to a position, in hardware steps.
pub(crate) fn at_position(counts: u64) -> SequenceStep {
    ControllerAction::Set(vec![("shaft.counts".to_owned(), counts.to_string())]).into()
}

/// The time between two cyclic frames of a connection.
fn cycle(connect: &ConnectAction) -> Duration {
    let said = connect.settings.iter().find(|(name, _)| name == "cycle" || name == "isochronous");
    let units = [("ms", 1_000_000), ("us", 1_000), ("s", 1_000_000_000)];
    let nanos = said.and_then(|(_, text)| {
        let (number, unit) = units.iter().find_map(|(word, nanos)| Some((text.strip_suffix(word)?, nanos)))?;
        number.parse::<u64>().ok()?.checked_mul(*unit)
    });
    nanos.map_or(USUAL_CYCLE, Duration::from_nanos)
}
