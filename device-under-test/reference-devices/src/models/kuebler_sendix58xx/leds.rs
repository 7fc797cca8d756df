//! What the LEDs show: chapter 4.

use super::Sendix;
use device_stack::profinet::StackStatus;
use encoder_profile::encoder_object::PoweredEncoder;
use encoder_profile::facts::FaultEffect;

/// What the LED of this name shows; none if there is none.
pub fn led(live: &PoweredEncoder<'_, Sendix>, name: &str, seen: &StackStatus) -> Option<&'static str> {
    let lit = |shown| if seen.has_supply { shown } else { "dark" };
    Some(match name {
        "power" => lit(if seen.is_signalling { "green_flashing" } else { "green" }),
        "error" => lit(error(live, seen)),
        // The bench has one cable, and it is at port 1.
        "link1" if seen.is_linked && seen.exchanges_data => lit("green_yellow"),
        "link1" if seen.is_linked => lit("green"),
        "link1" | "link2" => "dark",
        _ => return None,
    })
}

/// Errors of the hardware come before the state of the connection, the sensor before the memory.
fn error(live: &PoweredEncoder<'_, Sendix>, seen: &StackStatus) -> &'static str {
    if live.faults.have(FaultEffect::NoReading, live.facts) {
        return "red_five_hertz";
    }
    if live.faults.have(FaultEffect::NoMemory, live.facts) {
        return "red_one_hertz";
    }
    if !seen.exchanges_data || seen.module_differs {
        return "red";
    }
    if live.ram.wrong_parameters { "red_half_hertz" } else { "dark" }
}
