//! Tests and changes of a signal image that several bugs share.

use encoder_profile::encoder::measuring::MeasuringSettings;
use encoder_profile::hooks::EncoderView;
use encoder_profile::profidrive::telegram::{PreviousCycle, SignalImage};

// Bits of G1_ZSW; the same bits of G1_STW are the requests.
pub const POSITION: u16 = 0x2000;
pub const PARKED: u16 = 0x4000;
pub const ERROR: u16 = 0x8000;

pub const EXECUTED: u16 = 0x1000;

pub fn has_error(image: &SignalImage) -> bool {
    image.g1_zsw & ERROR != 0
}

pub fn is_parked(image: &SignalImage) -> bool {
    image.g1_zsw & PARKED != 0
}

pub fn is_executed(image: &SignalImage) -> bool {
    image.g1_zsw & EXECUTED != 0
}

pub fn has_position(image: &SignalImage) -> bool {
    image.g1_zsw & POSITION != 0
}

pub fn is_lost(before: &PreviousCycle) -> bool {
    before.unhooked.is_transferred && before.sent.g1_zsw & POSITION == 0
}

pub fn without_transfer(image: SignalImage) -> SignalImage {
    if has_position(&image) { SignalImage { g1_zsw: image.g1_zsw & !POSITION, g1_xist2: 0, ..image } } else { image }
}

/// Returns the velocity of the previous measurement, in the unit and direction in force.
pub fn velocity_before(view: &EncoderView<'_>) -> i64 {
    let MeasuringSettings { scaling, direction, .. } = view.measuring.settings;
    view.velocity.way(view.velocity.mean_steps().0, view.velocity.unit(), scaling, direction).velocity()
}
