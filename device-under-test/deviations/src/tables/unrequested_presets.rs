//! Presets that no handshake has requested, and writes to what cannot be written: what several rows of the tables share.

use crate::seams::Deviations;
use alloc::rc::Rc;
use alloc::vec::Vec;
use core::cell::{Cell, RefCell};
use encoder_profile::checks::EncoderCheck;
use encoder_profile::encoder::PresetMode;
use encoder_profile::encoder::measuring::OffsetSum;
use encoder_profile::hooks::WorkingPreset;
use reference_devices::models::sick_afx60::hooks::Event;

/// The value of an absolute preset that is carried out in the next cycle, as soon as there is one.
pub fn next_preset(d: &mut Deviations) -> Rc<Cell<Option<u64>>> {
    let next = Rc::new(Cell::new(None));
    let due = next.clone();
    d.encoder.working_preset(move |view, held| match due.take() {
        Some(value) => WorkingPreset { offset: view.measuring.preset(PresetMode::Absolute, value), ..held },
        None => held,
    });
    next
}

/// The button makes a preset although class 4 is off, and its offset acts from then on.
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
    d.measuring.shifted(move |sum, right| match acts.get() {
        true => OffsetSum { offset_acts: true, ..*sum }.position(),
        false => right,
    });
}

/// The elements of a parameter from `first` on can be written: they are read back and have no effect.
pub fn takes_writes(d: &mut Deviations, of: u16, first: usize) {
    let kept = Rc::new(RefCell::new(Vec::<(usize, u64)>::new()));
    let (shown, lost) = (kept.clone(), kept.clone());
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
        kept.borrow_mut().extend(above);
        (taken > 0).then(|| values[..taken].to_vec())
    });
    d.encoder.element(move |_, (number, at), right| {
        let shown = shown.borrow();
        let last = shown.iter().rev().find(|(element, _)| number == of && *element == at);
        last.map_or(right, |(_, value)| *value)
    });
    d.afx60.kept(move |event, _, kept| {
        if event != Event::Start {
            lost.borrow_mut().clear();
        }
        kept
    });
}
