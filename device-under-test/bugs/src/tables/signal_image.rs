//! Tests and changes of a signal image that several bugs share.

use encoder_profile::encoder::measuring::MeasuringSettings;
use encoder_profile::hooks::EncoderView;
use encoder_profile::profidrive::telegram::{PreviousCycle, SignalImage};

// Bits of G1_ZSW; the same bits of G1_STW are the requests.
/// Bit 13: the absolute value is transferred.
pub const POSITION: u16 = 0x2000;
/// Bit 14: the encoder is parked.
pub const PARKED: u16 = 0x4000;
/// Bit 15: an error.
pub const ERROR: u16 = 0x8000;

/// Bit 12: the preset was executed.
pub const EXECUTED: u16 = 0x1000;

/// Whether the error bit is set.
pub fn has_error(image: &SignalImage) -> bool {
    image.g1_zsw & ERROR != 0
}

/// Whether the encoder shows that it is parked.
pub fn is_parked(image: &SignalImage) -> bool {
    image.g1_zsw & PARKED != 0
}

/// Whether the preset is confirmed.
pub fn is_executed(image: &SignalImage) -> bool {
    image.g1_zsw & EXECUTED != 0
}

/// Whether the absolute value is transferred.
pub fn has_position(image: &SignalImage) -> bool {
    image.g1_zsw & POSITION != 0
}

/// Whether a transferred absolute value was not sent in the previous cycle.
pub fn is_lost(before: &PreviousCycle) -> bool {
    before.unhooked.is_transferred && before.sent.g1_zsw & POSITION == 0
}

/// The image without the absolute value.
pub fn without_transfer(image: SignalImage) -> SignalImage {
    if has_position(&image) { SignalImage { g1_zsw: image.g1_zsw & !POSITION, g1_xist2: 0, ..image } } else { image }
}

/// Returns the velocity of the previous measurement, in the unit and direction in force.
pub fn velocity_before(view: &EncoderView<'_>) -> i64 {
    let MeasuringSettings { scaling, direction, .. } = view.measuring.settings;
    view.velocity.way(view.velocity.mean_steps().0, view.velocity.unit(), scaling, direction).velocity()
}
