//! Where a live device differs from the reference device: answers, and values at points where both have been at rest for a while.
//!
//! Its times depend on its host and its line, so that no time is compared, nor a value that has just changed, nor one that counts.

use crate::difference::{
    AnswerKey, DifferenceName, LogDifference, LogDifferenceKind, event_kind, protocol_error_or_rule, shown,
};
use crate::sequence_log::SequenceLog;
use engine::step_log::{LoggedStep, Observed, ObservedName};
use expression::Value;
use judge::answer::ReceivedReply;
use station::Duration;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use suite::device::DeviceDescription;
use suite::model::AnswerPart;

/// A step that takes this long ends at a point where values are compared.
pub(crate) const SETTLING: Duration = Duration::from_millis(100);
/// How long a value has to be the same on both sides before it is compared.
const AT_REST: Duration = Duration::from_millis(50);

/// How a live device is compared.
#[derive(Clone, Debug)]
pub struct SettledComparison {
    device: Arc<DeviceDescription>,
    /// What differed before any sequence, so that it says nothing.
    ignored: BTreeSet<(LogDifferenceKind, DifferenceName)>,
}

/// The last value of a name on one side, and since when.
#[derive(Clone, Copy, Debug, Default)]
struct StandingValue {
    value: Option<u64>,
    since: Duration,
}

impl SettledComparison {
    pub fn new(device: &Arc<DeviceDescription>) -> SettledComparison {
        SettledComparison { device: device.clone(), ignored: BTreeSet::new() }
    }

    /// From now on this is not compared.
    pub fn ignore(&mut self, found: &LogDifference) {
        self.ignored.insert(found.target());
    }

    /// The first difference.
    pub fn first(&self, reference: &SequenceLog, other: &SequenceLog) -> Option<LogDifference> {
        self.all(reference, other).into_iter().next()
    }

    /// All differences in their order; an error of the protocol or a broken rule only if there is nothing else.
    pub fn all(&self, reference: &SequenceLog, other: &SequenceLog) -> Vec<LogDifference> {
        let mut list = Vec::new();
        let mut standing: BTreeMap<ObservedName, [StandingValue; 2]> = BTreeMap::new();
        let mut events: [Vec<ComparedEvent>; 2] = [Vec::new(), Vec::new()];
        let mut began = [Duration::ZERO; 2];
        let mut first_step = 0;
        for (step, sides) in reference.log.steps.iter().zip(&other.log.steps).enumerate() {
            let sides = [sides.0, sides.1];
            let lengths = sides.map(|side| side.ended.since(side.began));
            let at = |kind, name| LogDifference { kind, name, step, first_step, after: lengths[0] };
            list.extend(answers(sides).into_iter().map(|name| at(LogDifferenceKind::Answer, name)));
            for (index, side) in sides.into_iter().enumerate() {
                for change in &side.changes {
                    match &change.what {
                        Observed::Value(name, value) => {
                            let since = began[index] + change.after;
                            standing.entry(*name).or_default()[index] = StandingValue { value: *value, since };
                        }
                        Observed::Event(said) => events[index].extend(ComparedEvent::of(said)),
                    }
                }
                began[index] += lengths[index];
            }
            if lengths.iter().any(|length| *length < SETTLING) {
                continue;
            }
            for (name, values) in &standing {
                let rests = |index: usize| values[index].since + AT_REST <= began[index];
                let [one, two] = values.map(|of| of.value.map(|value| value & self.compared_bits(*name)));
                if self.is_compared(*name) && rests(0) && rests(1) && one != two {
                    list.push(at(LogDifferenceKind::Value, DifferenceName::Sent(*name)));
                }
            }
            events.iter_mut().for_each(|side| side.sort());
            if events[0] != events[1] {
                let only_one =
                    events[0].iter().chain(&events[1]).find(|of| !events.iter().all(|side| side.contains(of)));
                let kind = only_one.map_or("alarm", |event| event.kind);
                list.push(at(LogDifferenceKind::Event, DifferenceName::Event(kind.to_owned())));
            }
            events.iter_mut().for_each(Vec::clear);
            first_step = step + 1;
        }
        list.retain(|of| !self.ignored.contains(&of.target()));
        if list.is_empty() {
            list.extend(protocol_error_or_rule(reference, other).filter(|of| !self.ignored.contains(&of.target())));
        }
        list
    }

    /// LEDs blink, and are read from time to time; the others are sent with each frame.
    fn is_compared(&self, name: ObservedName) -> bool {
        !matches!(name, ObservedName::Led(_))
    }

    /// The bits that do not count from the start of the device.
    fn compared_bits(&self, name: ObservedName) -> u64 {
        let ObservedName::Signal(index) = name else { return u64::MAX };
        let fields = self.device.signals.get(index).map_or(&[][..], |signal| &signal.fields);
        let counting = fields.iter().filter(|field| field.counts.is_some());
        !counting.fold(0, |all, field| all | field.mask())
    }
}

/// What is compared of an event.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct ComparedEvent {
    kind: &'static str,
    text: String,
}

impl ComparedEvent {
    /// `None` for LLDP, which may come at any time. The name and the address in a Hello are those of this device, so only that they are
    /// there is compared.
    fn of(said: &[(String, Value)]) -> Option<ComparedEvent> {
        let entry = |(name, value): &(String, Value)| match name.as_str() {
            "hello.name" | "hello.ip" => name.clone(),
            name => format!("{name}: {value:?}"),
        };
        let kind = event_kind(said);
        let text = said.iter().map(entry).collect::<Vec<_>>().join(", ");
        (kind != "lldp").then_some(ComparedEvent { kind, text })
    }
}

/// The parts of the answers and the read values that differ, each once.
fn answers([one, two]: [&LoggedStep; 2]) -> Vec<DifferenceName> {
    let mut list: Vec<DifferenceName> = Vec::new();
    let mut add = |name: DifferenceName| {
        if !list.contains(&name) {
            list.push(name);
        }
    };
    let read =
        |step: &LoggedStep, name: &String| step.reads.iter().find(|(of, _)| of == name).map(|(_, value)| value.clone());
    for (name, _) in one.reads.iter().chain(&two.reads).filter(|(name, _)| read(one, name) != read(two, name)) {
        add(DifferenceName::Read(name.clone()));
    }
    let reply = |step: &LoggedStep, part: &AnswerPart| -> Option<String> {
        let (_, reply): &(AnswerPart, ReceivedReply) = step.answers.iter().find(|(of, _)| of == part)?;
        Some(shown(reply))
    };
    let parts = one.answers.iter().chain(&two.answers).map(|(part, _)| part);
    // Whole answers have the name and the addresses of the device in them.
    for part in parts.filter(|part| **part != AnswerPart::Bytes && reply(one, part) != reply(two, part)) {
        add(DifferenceName::Part(AnswerKey(format!("{part:?}"))));
    }
    if one.error.is_some() != two.error.is_some() {
        add(DifferenceName::Part(AnswerKey("Error".to_owned())));
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;
    use engine::step_log::{LoggedChange, StepLog};
    use station::Time;

    /// A log of one step of 300 ms in which a signal takes these values at these milliseconds.
    fn log(changes: &[(u64, u64)]) -> SequenceLog {
        let change = |(at, value): &(u64, u64)| LoggedChange {
            after: Duration::from_millis(*at),
            frame: 1,
            what: Observed::Value(ObservedName::DataStatus, Some(*value)),
        };
        let step = LoggedStep {
            ended: Time::ZERO + Duration::from_millis(300),
            changes: changes.iter().map(change).collect(),
            ..LoggedStep::default()
        };
        let mut log = StepLog::default();
        log.steps.push(step);
        SequenceLog { log, frames: 1, broken: Vec::new(), spoilt: None }
    }

    /// A log of one step of 300 ms with an event.
    fn event(said: &[(&str, &str)]) -> SequenceLog {
        let said = said.iter().map(|(name, value)| ((*name).to_owned(), Value::text(*value))).collect();
        let mut log = log(&[]);
        log.log.steps[0].changes.push(LoggedChange { after: Duration::ZERO, frame: 1, what: Observed::Event(said) });
        log
    }

    fn comparison() -> SettledComparison {
        let manuals = suite_yaml::load(&suites::sources(), Some("lika-xac77-profinet")).expect("the suite");
        SettledComparison::new(&manuals[0].device)
    }

    #[test]
    fn of_a_hello_not_the_name_is_compared_but_that_it_is_said() {
        let of = comparison();
        let hello = |name: &str| event(&[("hello.name", name), ("hello.ip", "0.0.0.0")]);
        assert_eq!(of.first(&hello("encoder-under-test"), &hello("lldp.abort")), None);
        let found = of.first(&hello("a"), &log(&[])).expect("no Hello");
        assert_eq!(found.name, DifferenceName::Event("hello".to_owned()));
        let found = of.first(&hello("a"), &event(&[("hello.name", "a")])).expect("no address");
        assert_eq!(found.name, DifferenceName::Event("hello".to_owned()));
        assert_eq!(of.first(&log(&[]), &event(&[("lldp.name", "a")])), None, "it may come at any time");
        let found = of.first(&log(&[]), &event(&[("abort.code", "1")])).expect("an abort");
        assert_eq!(found.name, DifferenceName::Event("abort".to_owned()));
    }

    #[test]
    fn only_values_at_rest_are_compared() {
        let of = comparison();
        assert_eq!(of.first(&log(&[(0, 5), (40, 6)]), &log(&[(3, 5), (90, 6)])), None, "the same, at other times");
        assert_eq!(of.first(&log(&[(0, 5), (10, 7), (20, 6)]), &log(&[(0, 6)])), None, "a change that is over");
        assert_eq!(of.first(&log(&[(0, 5)]), &log(&[(0, 5), (270, 6)])), None, "it has just changed");
        let found = of.first(&log(&[(0, 5)]), &log(&[(0, 5), (100, 6)])).expect("another value at rest");
        assert_eq!(found.name, DifferenceName::Sent(ObservedName::DataStatus));
        let mut of = of;
        of.ignore(&found);
        assert_eq!(of.first(&log(&[(0, 5)]), &log(&[(0, 5), (100, 6)])), None, "it is ignored");
    }
}
