//! What differs, and what each device did there, as texts.

use crate::difference::{DifferenceName, LogDifference, shown};
use crate::literal;
use engine::step_log::{Observed, StepLog};
use suite::device::DeviceDescription;

/// The words of a device and one of its variants.
pub(crate) struct DeviceWords<'a> {
    pub device: &'a DeviceDescription,
    pub variant: usize,
}

impl DeviceWords<'_> {
    /// What differs as a name of the suite language.
    pub(crate) fn name(&self, found: &LogDifference, logs: [&StepLog; 2]) -> String {
        let [one, two] = logs.map(|log| raw(log, found));
        match &found.name {
            DifferenceName::Read(name) => name.clone(),
            DifferenceName::Part(key) => {
                let answers =
                    logs.into_iter().filter_map(|log| log.steps.get(found.step)).flat_map(|step| &step.answers);
                let part = answers.map(|(part, _)| part).find(|part| format!("{part:?}") == key.0);
                let name = part.and_then(|part| literal::part_name(self.device, part));
                name.map_or_else(|| "answer".to_owned(), |name| format!("answer.{name}"))
            }
            DifferenceName::Event(kind) => kind.clone(),
            DifferenceName::Protocol(kind) => (*kind).to_owned(),
            DifferenceName::Rule(id) => id.clone(),
            DifferenceName::Sent(name) => {
                let said = literal::of_sent(self.device, self.variant, *name, one.or(two).or(Some(0)), two.or(one));
                said.map_or_else(|| format!("{name:?}"), |(path, _)| path)
            }
        }
    }

    /// What one of the devices did there.
    pub(crate) fn value(&self, log: &StepLog, found: &LogDifference) -> String {
        let Some(step) = log.steps.get(found.step) else { return String::new() };
        match &found.name {
            DifferenceName::Read(name) => {
                let value = step.reads.iter().find(|(known, _)| known == name).map(|(_, value)| value);
                value.and_then(|value| literal::of_value(value, &[])).unwrap_or_else(|| "nothing".to_owned())
            }
            DifferenceName::Part(part) => {
                let reply = step.answers.iter().find(|(known, _)| format!("{known:?}") == part.0);
                reply.map_or_else(
                    || step.error.clone().unwrap_or_else(|| "nothing".to_owned()),
                    |(_, reply)| {
                        let said = literal::of_reply(self.device, reply);
                        said.unwrap_or_else(|| shown(reply))
                    },
                )
            }
            DifferenceName::Sent(name) => {
                let values = step.changes.iter().filter_map(|change| match change.what {
                    Observed::Value(known, value) if known == *name => Some((change.after, value)),
                    _ => None,
                });
                let texts: Vec<String> = values
                    .map(|(after, value)| match value {
                        Some(value) => format!("0x{value:X} after {after:?}"),
                        None => format!("nothing after {after:?}"),
                    })
                    .take(4)
                    .collect();
                match (texts.is_empty(), raw(log, found)) {
                    (false, _) => texts.join(", "),
                    (true, Some(value)) => format!("still 0x{value:X}"),
                    (true, None) => "unchanged".to_owned(),
                }
            }
            DifferenceName::Event(_) => {
                let steps = log.steps.get(found.first_step..=found.step).unwrap_or_default();
                let events = steps.iter().flat_map(|step| &step.changes).filter_map(|change| match &change.what {
                    Observed::Event(said) => Some(
                        said.iter()
                            .filter_map(|(name, value)| Some(format!("{name}: {}", literal::of_value(value, &[])?)))
                            .collect::<Vec<_>>()
                            .join(", "),
                    ),
                    Observed::Value(..) => None,
                });
                let events: Vec<String> = events.collect();
                if events.is_empty() { "none".to_owned() } else { events.join("; ") }
            }
            DifferenceName::Protocol(_) => "as the bus requires".to_owned(),
            DifferenceName::Rule(_) => "as the rule says".to_owned(),
        }
    }
}

/// The value of what differs at the time when it does.
fn raw(log: &StepLog, found: &LogDifference) -> Option<u64> {
    let DifferenceName::Sent(name) = &found.name else { return None };
    let changes = log
        .steps
        .iter()
        .enumerate()
        .take(found.step + 1)
        .flat_map(|(step, of)| of.changes.iter().map(move |of| (step, of)));
    let at_the_time = changes.filter(|(step, change)| *step < found.step || change.after <= found.after);
    let mut values = at_the_time.filter_map(|(_, change)| match change.what {
        Observed::Value(known, value) if known == *name => Some(value),
        _ => None,
    });
    values.next_back().flatten()
}
