//! The shortest list of steps that still shows something.
//!
//! Delta debugging (ddmin: Zeller and Hildebrandt, 2002).

use crate::action::{ConnectAction, ControllerAction};

/// Removes as many steps as possible while `still` returns true.
pub fn fewest<T: Clone, E>(mut steps: Vec<T>, still: &mut dyn FnMut(&[T]) -> Result<bool, E>) -> Result<Vec<T>, E> {
    let mut parts = 2;
    while steps.len() >= 2 {
        let size = steps.len().div_ceil(parts);
        let mut reduced = None;
        for begin in (0..steps.len()).step_by(size).rev() {
            let mut rest = steps.clone();
            rest.drain(begin..(begin + size).min(steps.len()));
            if still(&rest)? {
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
    Ok(steps)
}

/// Replaces each step by a smaller one as long as `still` returns true; `smaller` returns those to try, the first one first.
pub fn simplest<T: Clone, E>(
    mut steps: Vec<T>,
    smaller: fn(&T) -> Vec<T>,
    still: &mut dyn FnMut(&[T]) -> Result<bool, E>,
) -> Result<Vec<T>, E> {
    for place in 0..steps.len() {
        let mut tries = smaller(&steps[place]).into_iter();
        while let Some(step) = tries.next() {
            let mut trial = steps.clone();
            trial[place] = step;
            if still(&trial)? {
                tries = smaller(&trial[place]).into_iter();
                steps = trial;
            }
        }
    }
    Ok(steps)
}

/// The list without each of its items in turn.
pub fn without<T: Clone>(list: &[T]) -> Vec<Vec<T>> {
    let one_less = |leave: usize| {
        let kept = list.iter().enumerate().filter(|(place, _)| *place != leave);
        kept.map(|(_, item)| item.clone()).collect()
    };
    (0..list.len()).map(one_less).collect()
}

/// The same action with one name, value or setting less; none for one that has only one.
pub fn one_less(action: &ControllerAction) -> Vec<ControllerAction> {
    match action {
        ControllerAction::Set(entries) if entries.len() > 1 => {
            without(entries).into_iter().map(ControllerAction::Set).collect()
        }
        ControllerAction::Write(entries) if entries.len() > 1 => {
            without(entries).into_iter().map(ControllerAction::Write).collect()
        }
        ControllerAction::Read(names) if names.len() > 1 => {
            // A single name first, since a record has many.
            let alone = names.iter().map(|name| ControllerAction::Read(vec![name.clone()]));
            alone.chain(without(names).into_iter().map(ControllerAction::Read)).collect()
        }
        ControllerAction::Connect(of) => {
            let settings = without(&of.settings).into_iter().map(|settings| ConnectAction { settings, ..of.clone() });
            let instead = without(&of.instead).into_iter().map(|instead| ConnectAction { instead, ..of.clone() });
            settings.chain(instead).map(ControllerAction::Connect).collect()
        }
        _ => Vec::new(),
    }
}
