//! What a device keeps over a power cycle, as its description says: a parameter marked as permanent and what was saved keep their values,
//! every other one is as after the power-up before. No reference device is needed for that.

use crate::draw::Draw;
use crate::names::SequenceNames;
use crate::step::SequenceStep;
use compare::action::{ConnectAction, ControllerAction};
use engine::step_log::{LoggedStep, StepLog};
use judge::answer::ReceivedReply;
use std::time::Duration;
use suite::device::DeviceDescription;

/// The kind of error of a device that keeps what it must not keep, or does not keep what it must.
pub(crate) const RETENTION: &str = "retention";
/// How long a device may take to save, and to start; longer than the times of any manual.
const SAVING: Duration = Duration::from_secs(3);
const STARTING: Duration = Duration::from_secs(8);
const OFF: Duration = Duration::from_millis(500);

/// A sequence that writes a parameter between two power cycles; `None` if the manual has none that can be written.
pub(crate) fn sequence(names: &SequenceNames, save: u16, draw: &mut Draw) -> Option<Vec<SequenceStep>> {
    let save = format!("P{save}");
    let written: Vec<&(String, u32)> = names.writable.iter().filter(|(name, _)| is_whole(name, &save)).collect();
    let (name, width) = draw.one(&written)?;
    let module = draw.one(&names.modules)?.name.clone();
    let connect = || {
        SequenceStep::from(ControllerAction::Connect(ConnectAction {
            module: module.clone(),
            ..ConnectAction::default()
        }))
    };
    let read = |name: &str| SequenceStep::from(ControllerAction::Read(vec![name.to_owned()]));
    let write = |name: &str, value: String| SequenceStep::from(ControllerAction::Write(vec![(name.to_owned(), value)]));
    let power = |value: &str| SequenceStep::from(ControllerAction::Set(vec![("power".to_owned(), value.to_owned())]));
    let wait = |time: Duration| SequenceStep::from(ControllerAction::Wait(time));
    let cycle = [power("down"), wait(OFF), power("up"), wait(STARTING)];
    let value = draw.number(*width).max(1).to_string();
    let mut steps = cycle.to_vec();
    steps.extend([connect(), read(name), write(name, value), read(name), wait(SAVING)]);
    if draw.chance(50) && names.writable.iter().any(|(known, _)| *known == save) {
        steps.extend([write(&save, "1".to_owned()), wait(SAVING), read(&save)]);
    }
    steps.extend(cycle);
    steps.extend([connect(), read(name)]);
    Some(steps)
}

/// Whether this is a parameter without elements that is not the one that saves.
fn is_whole(name: &str, save: &str) -> bool {
    name != save && !name.contains('.')
}

/// What is known of the parameter of a sequence.
#[derive(Default)]
struct TrackedParameter {
    name: String,
    /// Its value after a power-up.
    stored: Option<i128>,
    /// Its value now.
    present: Option<i128>,
    /// Whether it has been read since the last power-up.
    was_written: bool,
    cycles: usize,
    /// Whether what is stored is known to be what is expected after the next power-up.
    is_expected: bool,
}

/// What a device does not keep as its description says, in a sentence. Sequences with any other step say nothing.
pub(crate) fn broken(device: &DeviceDescription, steps: &[SequenceStep], log: &StepLog) -> Option<String> {
    let save = format!("P{}", device.parameter_access.save);
    let mut known = TrackedParameter::default();
    let mut saving = false;
    for (step, logged) in steps.iter().zip(&log.steps) {
        if !step.modifiers.is_empty() || logged.error.is_some() {
            return None;
        }
        match &step.action {
            // Until it has been stored, a failing supply leaves either value.
            ControllerAction::Wait(wait) => {
                if *wait >= SAVING && known.was_written && is_permanent(device, &known.name) {
                    (known.stored, known.is_expected) = (known.present, known.present.is_some());
                }
            }
            ControllerAction::Disconnect => {}
            ControllerAction::Connect(connect) if connect.settings.is_empty() && connect.instead.is_empty() => {}
            ControllerAction::Set(entries) => match entries.as_slice() {
                [(name, value)] if name == "power" => {
                    if value == "up" {
                        (known.present, known.was_written) = (None, false);
                        known.cycles += 1;
                    }
                }
                [(name, _)] if name == "shaft.counts" => {}
                _ => return None,
            },
            ControllerAction::Write(entries) => match entries.as_slice() {
                [(name, _)] if *name == save => saving = !is_refused(logged),
                [(name, _)] if is_whole(name, &save) && (known.name.is_empty() || known.name == *name) => {
                    known.name.clone_from(name);
                    known.was_written = !is_refused(logged);
                    known.present = None;
                }
                _ => return None,
            },
            ControllerAction::Read(names) => {
                let [name] = names.as_slice() else { return None };
                let value = logged.reads.iter().find(|(of, _)| of == name).and_then(|(_, value)| value.as_whole())?;
                if *name == save {
                    // A save that is not shown as complete says nothing.
                    if saving && value == 0 {
                        (known.stored, known.is_expected) = (known.present, true);
                    } else if saving {
                        return None;
                    }
                    saving = false;
                    continue;
                }
                if !known.name.is_empty() && known.name != *name {
                    return None;
                }
                known.name.clone_from(name);
                if known.cycles == 0 {
                    return None;
                }
                if known.present.is_none() && !known.was_written {
                    // The first reading after a power-up.
                    if let Some(stored) = known.stored.filter(|stored| known.is_expected && *stored != value) {
                        return Some(format!(
                            "{name} is {value} after a power cycle; it should be {stored}, by what was saved and what is permanent."
                        ));
                    }
                    (known.stored, known.is_expected) = (Some(value), true);
                }
                known.present = Some(value);
                if known.was_written && is_permanent(device, name) {
                    known.is_expected = false;
                }
            }
            _ => return None,
        }
        if saving && matches!(&step.action, ControllerAction::Set(_)) {
            // Power that fails during a save leaves either value.
            return None;
        }
    }
    None
}

fn is_refused(step: &LoggedStep) -> bool {
    step.answers.iter().any(|(_, reply)| !matches!(reply, ReceivedReply::Accepted | ReceivedReply::Value(_)))
}

fn is_permanent(device: &DeviceDescription, name: &str) -> bool {
    let number = name.strip_prefix('P').and_then(|number| number.parse::<u16>().ok());
    device.parameters.iter().any(|of| Some(of.number) == number && of.permanent)
}

#[cfg(test)]
mod tests {
    use super::*;
    use expression::Value;

    /// The log of a sequence in which reads have these values, in order, and everything else succeeds.
    fn log(steps: &[SequenceStep], values: &[i64]) -> StepLog {
        let mut values = values.iter();
        let logged = steps.iter().map(|step| {
            let mut logged = LoggedStep::default();
            if let ControllerAction::Read(names) = &step.action {
                let value = values.next().map(|value| Value::Word(*value));
                logged.reads = names.iter().cloned().zip(value).collect();
            }
            logged
        });
        let mut log = StepLog::default();
        log.steps = logged.collect();
        log
    }

    /// A power cycle, a connection, P65000 read, written and read, perhaps saved, and read after another power cycle.
    fn steps(saved: bool) -> Vec<SequenceStep> {
        let set = |value: &str| SequenceStep::from(ControllerAction::Set(vec![("power".to_owned(), value.to_owned())]));
        let read = |name: &str| SequenceStep::from(ControllerAction::Read(vec![name.to_owned()]));
        let write = |name: &str| SequenceStep::from(ControllerAction::Write(vec![(name.to_owned(), "7".to_owned())]));
        let connect = || SequenceStep::from(ControllerAction::Connect(ConnectAction::default()));
        let mut list = vec![set("down"), set("up"), connect(), read("P65000"), write("P65000"), read("P65000")];
        list.push(ControllerAction::Wait(SAVING).into());
        if saved {
            list.extend([write("P971"), read("P971")]);
        }
        list.extend([set("down"), set("up"), connect(), read("P65000")]);
        list
    }

    #[test]
    fn what_is_kept_follows_from_saves_and_permanent_parameters() {
        let manuals = |name: &str| suite_yaml::load(&suites::sources(), Some(name)).expect("the suite");
        let (lika, a3m60) = (manuals("lika-xac77-profinet"), manuals("sick-a3m60-profibus"));
        let of = |device: &DeviceDescription, saved: bool, values: &[i64]| {
            broken(device, &steps(saved), &log(&steps(saved), values)).is_some()
        };
        let lika = &lika[0].device;
        assert!(!of(lika, false, &[1, 7, 1]), "it is lost");
        assert!(of(lika, false, &[1, 7, 7]), "kept without a save");
        assert!(!of(lika, true, &[1, 7, 0, 7]), "it was saved");
        assert!(of(lika, true, &[1, 7, 0, 1]), "lost although it was saved");
        assert!(!of(lika, true, &[1, 7, 1, 1]), "the save was not complete");
        let a3m60 = &a3m60[0].device;
        assert!(!of(a3m60, false, &[1, 7, 7]), "it is permanent");
        assert!(of(a3m60, false, &[1, 7, 1]), "lost although it is permanent");
    }
}
