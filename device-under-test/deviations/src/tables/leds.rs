//! Bugs of LEDs; their words are those of the manuals that have them.

use super::Group;
use crate::needs::Need;
use core::time::Duration;
use encoder_profile::hooks::LedInput;
use reference_devices::manuals;

/// The bugs, by what they need.
pub static GROUPS: &[Group] = &[Group {
    needs: &[Need::Of(&manuals::KUEBLER_SENDIX58XX)],
    deviations: bugs! {
        // Ports
        "port-leds-exchanged" "The LEDs of the two ports are exchanged."
            => |d| d.encoder.led(port_leds_exchanged);
        "link-led-without-activity" "The LED of a port shows the link alone and nothing of the traffic."
            => |d| d.encoder.led(|_, right| if right == "green_yellow" { "green" } else { right });
        "link-led-busy-without-traffic" "The LED of a port with a cable shows traffic all the time."
            => |d| d.encoder.led(|lit, right| if is_port(lit) && right == "green" { "green_yellow" } else { right });
        "link-led-on-without-link" "The LED of the first port is lit without a cable."
            => |d| d.encoder.led(|lit, right| if lit.name == "link1" && !lit.stack.is_linked { "green" } else { right });

        // Supply and signal
        "power-led-off-in-stop" "The LED of the supply is dark while no outputs count."
            => |d| d.encoder.led(|lit, right| if lit.name == "power" && lit.stack.has_connection && !lit.has_outputs { "dark" } else { right });
        "signal-on-another-led" "The LED of errors flashes when DCP asks for it, and that of the supply does not."
            => |d| d.encoder.led(|lit, right| match lit.name {
                "power" if lit.stack.is_signalling => "green",
                _ => signal_on_two_leds(lit, right),
            });
        "signal-on-two-leds" "The LED of errors flashes beside that of the supply when DCP asks for it."
            => |d| d.encoder.led(signal_on_two_leds);

        // Errors
        "error-led-off-with-a-cable" "The LED of errors is dark with a cable, although nothing is connected."
            => |d| d.encoder.led(|lit, right| if is_alone(lit, right) && lit.stack.is_linked { "dark" } else { right });
        "error-led-off-without-a-cable" "The LED of errors is dark without a cable."
            => |d| d.encoder.led(|lit, right| if is_alone(lit, right) && !lit.stack.is_linked { "dark" } else { right });
        "error-led-on-in-operation" "The LED of errors is lit while data are exchanged."
            => |d| d.encoder.led(|lit, right| if is_silent(lit, right) { "red" } else { right });
        "error-led-off-late" "The LED of errors goes dark 12 s after the exchange of data has begun."
            => |d| d.encoder.led(|lit, right| match lit.exchanged_for {
                Some(time) if is_silent(lit, right) && time < Duration::from_secs(12) => "red",
                _ => right,
            });
        "missing-parameters-led-steady" "The LED of errors does not flash without user parameters."
            => |d| d.encoder.led(|lit, right| if right == HALF && !lit.has_record { "red" } else { right });
        "invalid-parameters-not-on-led" "The LED of errors is dark with user parameters that are invalid."
            => |d| d.encoder.led(|lit, right| if right == HALF && lit.has_record { "dark" } else { right });
        "error-led-patterns-exchanged" "The LED of errors flashes for the memory as it should for the sensor, and the other way round."
            => |d| d.encoder.led(|_, right| match right {
                ONE => FIVE,
                FIVE => ONE,
                right => right,
            });
        "error-led-one-frequency" "The LED of errors flashes with 1 Hz whenever it flashes."
            => |d| d.encoder.led(|_, right| if let HALF | FIVE = right { ONE } else { right });
    },
}];

const HALF: &str = "red_half_hertz";
const ONE: &str = "red_one_hertz";
const FIVE: &str = "red_five_hertz";

fn is_port(lit: &LedInput<'_>) -> bool {
    lit.name == "link1" || lit.name == "link2"
}

/// Whether it is lit for want of a connection.
fn is_alone(lit: &LedInput<'_>, right: &str) -> bool {
    lit.name == "error" && right == "red"
}

/// Whether it is dark although there is power.
fn is_silent(lit: &LedInput<'_>, right: &str) -> bool {
    lit.name == "error" && lit.stack.has_supply && right == "dark"
}

fn port_leds_exchanged(lit: &LedInput<'_>, right: &'static str) -> &'static str {
    match lit.name {
        "link1" => "dark",
        "link2" if !lit.stack.is_linked || !lit.stack.has_supply => "dark",
        "link2" if lit.stack.exchanges_data => "green_yellow",
        "link2" => "green",
        _ => right,
    }
}

fn signal_on_two_leds(lit: &LedInput<'_>, right: &'static str) -> &'static str {
    if lit.name == "error" && lit.stack.is_signalling { ONE } else { right }
}
