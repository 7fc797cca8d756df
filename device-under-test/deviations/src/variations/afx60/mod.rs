//! What the manual of the AFS60 and AFM60 leaves free.

mod diagnosis;
mod measured;
mod memory;
mod parameters;
mod settings;
mod signals;
mod start;

use crate::seams::Deviations;
use alloc::rc::Rc;
use alloc::vec::Vec;
use core::cell::Cell;
use encoder_profile::hooks::EncoderView;
use wire::profidrive::{ErrorNumber, ParameterError, RequestId};

/// The variations, by topic.
pub static GROUPS: &[super::Group] = &[
    diagnosis::GROUP,
    measured::GROUP,
    memory::GROUP,
    parameters::GROUP,
    settings::GROUP,
    signals::GROUP,
    start::GROUP,
];

/// A bit that a condition of the warning word of the encoder object sets: speed, temperature, LED.
const TEMPERATURE: u32 = 1 << 1;

/// Refuses those writes to a parameter for which `refuses` returns `true`; they have no effect.
fn refuse_writes(
    d: &mut Deviations,
    of: u16,
    number: ErrorNumber,
    mut refuses: impl FnMut(&EncoderView<'_>, u16, &[u64]) -> bool + 'static,
) {
    let is_refused = Rc::new(Cell::new(false));
    let refused = is_refused.clone();
    d.encoder.written(move |view, (number, subindex), values| {
        values.filter(|values: &Vec<u64>| {
            let takes = number != of || !refuses(view, subindex, values);
            refused.set(refused.get() || !takes);
            takes
        })
    });
    d.encoder.refuse(move |id, parameter, before| {
        if (id, parameter) == (RequestId::CHANGE, of) && is_refused.take() {
            return Some(ParameterError { number, subindex: None });
        }
        before
    });
}
