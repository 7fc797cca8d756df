//! What the LEDs show: manual, 5.3.1.
//!
//! Reading: steady and flashing are lost in the print; flashing is what the text calls so.

use super::{PoweredEncoder, State, limits};
use device_stack::profinet::StackStatus;

/// What an LED shows.
pub fn light(live: &PoweredEncoder<'_, State>, name: &str, seen: &StackStatus) -> Option<&'static str> {
    let light = match name {
        "sf" if seen.is_signalling => "red_flashing",
        "sf" if live.errors().iter().any(|error| error.code.is_some()) => "red",
        "sf" => "dark",
        "bf" if seen.exchanges_data => "dark",
        "bf" if seen.is_booting || seen.has_connection => "green",
        "bf" => "red",
        "encoder" => encoder_light(live, seen),
        "la1" if !seen.is_linked => "dark",
        "la1" if seen.exchanges_data => "orange",
        "la1" => "green",
        // The bench has no cable for the second port.
        "la2" => "dark",
        _ => return None,
    };
    Some(if seen.has_supply { light } else { "dark" })
}

fn encoder_light(live: &PoweredEncoder<'_, State>, seen: &StackStatus) -> &'static str {
    let errors = live.errors();
    let is_wrong = live.model.status.has_invalid_preset || live.model.status.has_invalid_parameter;
    match () {
        () if seen.is_booting => "red_green",
        () if live.model.around.reset_is_due => "green_flashing",
        () if errors.iter().any(|error| error.fault_bits & super::POSITION_OR_MEMORY != 0) => "red",
        () if limits::is_beyond_limits(live) => "red_green",
        () if is_wrong => "orange",
        () => "green",
    }
}
