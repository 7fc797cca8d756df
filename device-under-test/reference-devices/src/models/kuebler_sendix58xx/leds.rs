//! What the LEDs show: chapter 4.

use super::Sendix;
use device_stack::profinet::StackStatus;
use encoder_profile::encoder_object::PoweredEncoder;
use encoder_profile::facts::FaultEffect;

/// Returns what the LED of this name shows; `None` if it does not exist.
pub fn led(live: &PoweredEncoder<'_, Sendix>, name: &str, status: &StackStatus) -> Option<&'static str> {
    let lit = |pattern| if status.has_supply { pattern } else { "dark" };
    Some(match name {
        "power" => lit(if status.is_signalling { "green_flashing" } else { "green" }),
        "error" => lit(error(live, status)),
        // The only cable of the bench is at port 1.
        "link1" if status.is_linked && status.exchanges_data => lit("green_yellow"),
        "link1" if status.is_linked => lit("green"),
        "link1" | "link2" => "dark",
        _ => return None,
    })
}

/// Hardware errors take precedence over the state of the connection, the sensor over the memory.
fn error(live: &PoweredEncoder<'_, Sendix>, status: &StackStatus) -> &'static str {
    if live.faults.have(FaultEffect::NoReading, live.facts) {
        return "red_five_hertz";
    }
    if live.faults.have(FaultEffect::NoMemory, live.facts) {
        return "red_one_hertz";
    }
    if !status.exchanges_data || status.module_differs {
        return "red";
    }
    if live.ram.wrong_parameters { "red_half_hertz" } else { "dark" }
}
