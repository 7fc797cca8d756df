//! The LEDs: manual, 5.3.1.
//!
//! Interpretation: the print does not distinguish steady from flashing; an LED flashes only where the text says so.

use super::{Afx60State, PoweredEncoder, limits};
use device_stack::profinet::StackStatus;

/// Returns what the LED of this name shows; `None` if it does not exist.
pub fn led(live: &PoweredEncoder<'_, Afx60State>, name: &str, status: &StackStatus) -> Option<&'static str> {
    let pattern = match name {
        "sf" if status.is_signalling => "red_flashing",
        "sf" if live.errors().iter().any(|error| error.code.is_some()) => "red",
        "sf" => "dark",
        "bf" if status.exchanges_data => "dark",
        "bf" if status.is_booting || status.has_connection => "green",
        "bf" => "red",
        "encoder" => encoder_led(live, status),
        "la1" if !status.is_linked => "dark",
        "la1" if status.exchanges_data => "orange",
        "la1" => "green",
        // The second port of the bench has no cable.
        "la2" => "dark",
        _ => return None,
    };
    Some(if status.has_supply { pattern } else { "dark" })
}

fn encoder_led(live: &PoweredEncoder<'_, Afx60State>, status: &StackStatus) -> &'static str {
    let errors = live.errors();
    let is_wrong = live.model.status.has_invalid_preset || live.model.status.has_invalid_parameter;
    if status.is_booting {
        "red_green"
    } else if live.model.inputs.reset_is_due {
        "green_flashing"
    } else if errors.iter().any(|error| error.fault_bits & super::POSITION_OR_MEMORY != 0) {
        "red"
    } else if limits::is_beyond_limits(live) {
        "red_green"
    } else if is_wrong {
        "orange"
    } else {
        "green"
    }
}
