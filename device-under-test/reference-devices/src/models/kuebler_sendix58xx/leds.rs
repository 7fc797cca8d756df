//! What the LEDs show: chapter 4.

use super::Sendix;
use device_stack::profinet::StackStatus;
use encoder_profile::encoder_object::PoweredEncoder;
use encoder_profile::facts::FaultEffect;

/// Returns what the LED of this name shows; `None` if it does not exist.
pub fn led(live: &PoweredEncoder<'_, Sendix>, name: &str, seen: &StackStatus) -> Option<&'static str> {
    let lit = |pattern| if seen.has_supply { pattern } else { "dark" };
    Some(match name {
        "power" => lit(if seen.is_signalling { "green_flashing" } else { "green" }),
        "error" => lit(error(live, seen)),
        // The only cable of the bench is at port 1.
        "link1" if seen.is_linked && seen.exchanges_data => lit("green_yellow"),
        "link1" if seen.is_linked => lit("green"),
        "link1" | "link2" => "dark",
        _ => return None,
    })
}

/// Hardware errors take precedence over the state of the connection, the sensor over the memory.
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
