//! Activities that overlap, put in order as steps.

use crate::step::SequenceStep;
use compare::action::ControllerAction;
use std::time::Duration;

/// Actions at times, in cycles from the begin of a part.
#[derive(Default)]
pub(crate) struct Schedule {
    events: Vec<(u64, SequenceStep)>,
}

impl Schedule {
    pub fn add(&mut self, cycle: u64, step: impl Into<SequenceStep>) {
        self.events.push((cycle, step.into()));
    }

    pub fn set(&mut self, cycle: u64, name: &str, value: impl Into<String>) {
        self.add(cycle, ControllerAction::Set(vec![(name.to_owned(), value.into())]));
    }

    /// The actions with the waits between them. What is set at one time is set by one step; such a step takes a cycle itself.
    pub fn steps(mut self, cycle: Duration, length: u64) -> Vec<SequenceStep> {
        self.events.sort_by_key(|(at, _)| *at);
        let (mut steps, mut now, mut last) = (Vec::<SequenceStep>::new(), 0, None);
        let wait = |from: u64, to: u64| {
            let cycles = u32::try_from(to.saturating_sub(from)).unwrap_or(u32::MAX);
            (cycles > 0).then(|| SequenceStep::from(ControllerAction::Wait(cycle * cycles)))
        };
        for (at, step) in self.events {
            if last == Some(at)
                && let (Some(ControllerAction::Set(before)), ControllerAction::Set(more)) =
                    (steps.last_mut().map(|last| &mut last.action), &step.action)
            {
                for (name, value) in more {
                    before.retain(|(known, _)| known != name);
                    before.push((name.clone(), value.clone()));
                }
                continue;
            }
            steps.extend(wait(now, at));
            now = now.max(at) + u64::from(matches!(step.action, ControllerAction::Set(_)));
            last = Some(at);
            steps.push(step);
        }
        steps.extend(wait(now, length));
        steps
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_set_at_one_time_is_one_step_and_takes_a_cycle() {
        let mut schedule = Schedule::default();
        schedule.set(3, "b", "1");
        schedule.set(0, "a", "1");
        schedule.set(1, "a", "0");
        schedule.set(3, "c", "1");
        schedule.set(3, "b", "2");
        let steps: Vec<String> =
            schedule.steps(Duration::from_millis(4), 6).iter().map(|step| step.action.yaml()).collect();
        let expected = ["set: { a: 1 }", "set: { a: 0 }", "wait: 4ms", "set: { c: 1, b: 2 }", "wait: 8ms"];
        assert_eq!(steps, expected);
    }
}
