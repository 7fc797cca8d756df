//! The shortest sequence that still shows something: steps, then what is in them, then times.

use crate::step::SequenceStep;
use compare::action::ControllerAction;
use compare::minimal::{fewest, one_less, simplest, without};
use std::convert::Infallible;
use std::time::Duration;

/// Waits are not shortened below this.
const SHORTEST_WAIT: Duration = Duration::from_millis(4);

/// Removes as much as possible while `shows` returns true.
pub fn minimise(steps: Vec<SequenceStep>, shows: &mut dyn FnMut(&[SequenceStep]) -> bool) -> Vec<SequenceStep> {
    let mut still = |steps: &[SequenceStep]| Ok::<_, Infallible>(shows(steps));
    let Ok(steps) = fewest(steps, &mut still);
    let Ok(steps) = simplest(steps, smaller, &mut still);
    let steps = joined(steps, &mut still);
    let Ok(steps) = fewest(steps, &mut still);
    steps
}

/// Makes one wait of two that follow each other.
fn joined(
    mut steps: Vec<SequenceStep>,
    still: &mut dyn FnMut(&[SequenceStep]) -> Result<bool, Infallible>,
) -> Vec<SequenceStep> {
    let mut place = 0;
    while place + 1 < steps.len() {
        let both = steps.get(place).zip(steps.get(place + 1)).map(|(one, two)| (&one.action, &two.action));
        if let Some((ControllerAction::Wait(one), ControllerAction::Wait(two))) = both {
            let mut trial = steps.clone();
            trial.splice(place..place + 2, [ControllerAction::Wait(*one + *two).into()]);
            if still(&trial) == Ok(true) {
                steps = trial;
                continue;
            }
        }
        place += 1;
    }
    steps
}

/// The same step with one thing less.
fn smaller(step: &SequenceStep) -> Vec<SequenceStep> {
    let of = |action: ControllerAction| SequenceStep { action, modifiers: step.modifiers.clone() };
    let modified = |modifiers| SequenceStep { action: step.action.clone(), modifiers };
    let mut list: Vec<SequenceStep> = without(&step.modifiers).into_iter().map(modified).collect();
    list.extend(one_less(&step.action).into_iter().map(of));
    match &step.action {
        ControllerAction::Set(entries) => {
            if let [(name, value)] = &entries[..]
                && name == "shaft.counts"
                && value != "0"
            {
                list.push(of(ControllerAction::Set(vec![(name.clone(), "0".to_owned())])));
            }
        }
        ControllerAction::Wait(long) if *long > SHORTEST_WAIT => {
            let half = Duration::from_millis((long.as_millis() / 2) as u64).max(SHORTEST_WAIT);
            list.extend(
                [SHORTEST_WAIT, Duration::from_millis(20).min(half), half].map(|wait| of(ControllerAction::Wait(wait))),
            );
            list.dedup();
            list.retain(|other| other != step);
        }
        _ => {}
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(name: &str, value: &str) -> SequenceStep {
        ControllerAction::Set(vec![(name.to_owned(), value.to_owned())]).into()
    }

    #[test]
    fn what_does_not_matter_is_removed() {
        let both = ControllerAction::Set(vec![("a".into(), "1".into()), ("b".into(), "1".into())]);
        let wait = |millis| SequenceStep::from(ControllerAction::Wait(Duration::from_millis(millis)));
        let steps = vec![set("x", "0"), both.into(), wait(400), set("c", "1"), wait(3)];
        let text = |steps: &[SequenceStep]| steps.iter().map(|step| step.action.yaml()).collect::<Vec<_>>().join("; ");
        let small = minimise(steps, &mut |steps| {
            let text = text(steps);
            text.contains("b: 1") && text.contains("wait") && text.contains("c: 1")
        });
        assert_eq!(text(&small), "set: { b: 1 }; wait: 4ms; set: { c: 1 }");
    }
}
