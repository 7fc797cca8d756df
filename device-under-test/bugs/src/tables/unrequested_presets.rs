//! Presets without a request, and writes to read-only parameters, which several deviations share.

use crate::seams::Deviations;
use alloc::rc::Rc;
use alloc::vec::Vec;
use core::cell::{Cell, RefCell};
use encoder_profile::checks::EncoderCheck;
use encoder_profile::encoder::PresetMode;
use encoder_profile::encoder::measuring::OffsetSum;
use encoder_profile::hooks::WorkingPreset;
use reference_devices::models::sick_afx60::hooks::Afx60Event;

/// Returns a cell: a value in it makes an absolute preset in the next cycle.
pub fn next_preset(d: &mut Deviations) -> Rc<Cell<Option<u64>>> {
    let next = Rc::new(Cell::new(None));
    let due = next.clone();
    d.encoder.working_preset(move |view, held| match due.take() {
        Some(value) => WorkingPreset { offset: view.measuring.preset(PresetMode::Absolute, value), ..held },
        None => held,
    });
    next
}

/// Lets the button make a preset although class 4 is off, with an offset that is in force from then on.
pub fn button_without_class_4(d: &mut Deviations) {
    let (pressed, acts) = (Rc::new(Cell::new(None)), Rc::new(Cell::new(false)));
    let (due, begins) = (pressed.clone(), acts.clone());
    d.sick.button(move |value| {
        pressed.set(Some(value));
        value
    });
    d.encoder.working_preset(move |view, held| match due.take() {
        Some(value) if !view.user.class_4 => {
            begins.set(true);
            WorkingPreset { offset: view.measuring.preset(PresetMode::Absolute, value.into()), ..held }
        }
        _ => {
            begins.set(begins.get() && !view.user.class_4);
            held
        }
    });
    d.measuring
        .shifted(move |sum, right| if acts.get() { OffsetSum { offset_acts: true, ..*sum }.position() } else { right });
}

/// Makes the elements of a parameter from `first` on writable. Written values are read back but have no effect.
pub fn takes_writes(d: &mut Deviations, of: u16, first: usize) {
    let retained = Rc::new(RefCell::new(Vec::<(usize, u64)>::new()));
    let (shown, lost) = (retained.clone(), retained.clone());
    d.checks.check(move |check, right| match check {
        EncoderCheck::Writable { number, element } if number == of => {
            right || element.is_none_or(|at| usize::from(at) >= first)
        }
        _ => right,
    });
    d.encoder.written(move |_, (number, subindex), values| {
        let values = values?;
        let taken = first.saturating_sub(subindex.into()).min(values.len());
        if number != of || taken == values.len() {
            return Some(values);
        }
        let above = (usize::from(subindex)..).zip(values.iter().copied()).skip(taken);
        retained.borrow_mut().extend(above);
        (taken > 0).then(|| values[..taken].to_vec())
    });
    d.encoder.element(move |_, (number, at), right| {
        let shown = shown.borrow();
        let last = shown.iter().rev().find(|(element, _)| number == of && *element == at);
        last.map_or(right, |(_, value)| *value)
    });
    d.afx60.kept(move |event, _, retained| {
        if event != Afx60Event::Start {
            lost.borrow_mut().clear();
        }
        retained
    });
}
