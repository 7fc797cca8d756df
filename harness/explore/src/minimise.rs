//! The shortest sequence that still shows something: steps, then what is in them, then times.
//!
//! Delta debugging (ddmin: Zeller and Hildebrandt, 2002).

use crate::step::SequenceStep;
use compare::action::{ConnectAction, ControllerAction};
use std::time::Duration;

/// Waits are not shortened below this.
const SHORTEST_WAIT: Duration = Duration::from_millis(4);

/// Removes as much as possible while `shows` returns true.
pub fn minimise(steps: Vec<SequenceStep>, shows: &mut dyn FnMut(&[SequenceStep]) -> bool) -> Vec<SequenceStep> {
    let steps = fewer(steps, shows);
    let steps = simpler(steps, shows);
    fewer(joined(steps, shows), shows)
}

/// Makes one wait of two that follow each other.
fn joined(mut steps: Vec<SequenceStep>, shows: &mut dyn FnMut(&[SequenceStep]) -> bool) -> Vec<SequenceStep> {
    let mut place = 0;
    while place + 1 < steps.len() {
        let both = steps.get(place).zip(steps.get(place + 1)).map(|(one, two)| (&one.action, &two.action));
        if let Some((ControllerAction::Wait(one), ControllerAction::Wait(two))) = both {
            let mut trial = steps.clone();
            trial.splice(place..place + 2, [ControllerAction::Wait(*one + *two).into()]);
            if shows(&trial) {
                steps = trial;
                continue;
            }
        }
        place += 1;
    }
    steps
}

fn fewer(mut steps: Vec<SequenceStep>, shows: &mut dyn FnMut(&[SequenceStep]) -> bool) -> Vec<SequenceStep> {
    let mut parts = 2;
    while steps.len() >= 2 {
        let size = steps.len().div_ceil(parts);
        let mut reduced = None;
        for begin in (0..steps.len()).step_by(size).rev() {
            let mut rest = steps.clone();
            rest.drain(begin..(begin + size).min(steps.len()));
            if shows(&rest) {
                reduced = Some(rest);
                break;
            }
        }
        match reduced {
            Some(rest) => {
                steps = rest;
                parts = (parts - 1).max(2);
            }
            None if size == 1 => break,
            None => parts = (parts * 2).min(steps.len()),
        }
    }
    steps
}

fn simpler(mut steps: Vec<SequenceStep>, shows: &mut dyn FnMut(&[SequenceStep]) -> bool) -> Vec<SequenceStep> {
    for place in 0..steps.len() {
        while let Some(step) = steps.get(place).cloned() {
            let taken = smaller(&step).into_iter().find_map(|step| {
                let mut trial = steps.clone();
                *trial.get_mut(place)? = step;
                shows(&trial).then_some(trial)
            });
            match taken {
                Some(trial) => steps = trial,
                None => break,
            }
        }
    }
    steps
}

/// The same step with one thing less.
fn smaller(step: &SequenceStep) -> Vec<SequenceStep> {
    fn without<T: Clone>(list: &[T]) -> Vec<Vec<T>> {
        let one_less = |leave: usize| {
            let kept = list.iter().enumerate().filter(|(place, _)| *place != leave);
            kept.map(|(_, item)| item.clone()).collect()
        };
        (0..list.len()).map(one_less).collect()
    }
    let of = |action: ControllerAction| SequenceStep { action, modifiers: step.modifiers.clone() };
    let mut list: Vec<SequenceStep> = without(&step.modifiers)
        .into_iter()
        .map(|modifiers| SequenceStep { action: step.action.clone(), modifiers })
        .collect();
    match &step.action {
        ControllerAction::Set(entries) if entries.len() > 1 => {
            list.extend(without(entries).into_iter().map(|entries| of(ControllerAction::Set(entries))));
        }
        ControllerAction::Write(entries) if entries.len() > 1 => {
            list.extend(without(entries).into_iter().map(|entries| of(ControllerAction::Write(entries))));
        }
        ControllerAction::Read(names) if names.len() > 1 => {
            let alone = names.iter().map(|name| vec![name.clone()]);
            list.extend(alone.chain(without(names)).map(|names| of(ControllerAction::Read(names))));
        }
        ControllerAction::Connect(connect) => {
            let settings = without(&connect.settings);
            let settings = settings.into_iter().map(|settings| ConnectAction { settings, ..connect.clone() });
            let instead = without(&connect.instead);
            let instead = instead.into_iter().map(|instead| ConnectAction { instead, ..connect.clone() });
            list.extend(settings.chain(instead).map(|connect| of(ControllerAction::Connect(connect))));
        }
        ControllerAction::Set(entries) if entries.iter().any(|(name, _)| name == "shaft.counts") => {
            let first: Vec<(String, String)> = entries.iter().map(|(name, _)| (name.clone(), "0".to_owned())).collect();
            list.extend((first != *entries).then(|| of(ControllerAction::Set(first))));
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
