//! Bugs of the Sendix 58xx alone: LEDs, supply and start-up.

use super::Group;
use super::persona_bugs::AR_PROPERTIES;
use crate::needs::Need;
use core::time::Duration;
use device_stack::profinet::StackCheck;
use encoder_profile::checks::EncoderCheck;
use encoder_profile::hooks::LedInput;
use reference_devices::manuals;
use wire::profinet::blocks::connect::ArProperties;

/// The bugs, by what they need.
pub static GROUPS: &[Group] = &[Group {
    needs: &[Need::Of(&manuals::KUEBLER_SENDIX58XX)],
    deviations: bugs! {
        // Supply
        "works-from-12-volts-only" "Below 12 V the encoder does not work."
            => |d| d.checks.check(|check, right| match check {
                EncoderCheck::SupplySuffices(millivolts) => right && millivolts >= 12_000,
                _ => right,
            });
        // Start-up
        "legacy-start-refused" "A Connect with the legacy startup mode is refused."
            => |d| d.stack.check(|check, right| match check {
                StackCheck::ArField(ar, AR_PROPERTIES) => right && ar.ar_properties.has(ArProperties::STARTUP_ADVANCED),
                _ => right,
            });
        // Ports
        "port-leds-exchanged" "The LEDs of the two ports are swapped."
            => |d| d.encoder.led(port_leds_exchanged);
        "link-led-without-activity" "The LED of a port shows only the link, not the traffic."
            => |d| d.encoder.led(|_, right| if right == "green_yellow" { "green" } else { right });
        "link-led-busy-without-traffic" "The LED of a port with a link always shows traffic."
            => |d| d.encoder.led(|lit, right| if is_port(lit) && right == "green" { "green_yellow" } else { right });
        "link-led-on-without-link" "The LED of the first port is lit without a cable."
            => |d| d.encoder.led(|lit, right| if lit.name == "link1" && !lit.stack.is_linked { "green" } else { right });

        // Power and signal
        "power-led-off-in-stop" "The power LED is dark while there are no valid outputs."
            => |d| d.encoder.led(|lit, right| if lit.name == "power" && lit.stack.has_connection && !lit.has_outputs { "dark" } else { right });
        "signal-on-another-led" "DCP Signal flashes the error LED instead of the power LED."
            => |d| d.encoder.led(|lit, right| match lit.name {
                "power" if lit.stack.is_signalling => "green",
                _ => signal_on_two_leds(lit, right),
            });
        "signal-on-two-leds" "DCP Signal flashes the error LED in addition to the power LED."
            => |d| d.encoder.led(signal_on_two_leds);

        // Errors
        "error-led-off-with-a-cable" "The error LED is dark with a link, although there is no connection."
            => |d| d.encoder.led(|lit, right| if is_alone(lit, right) && lit.stack.is_linked { "dark" } else { right });
        "error-led-off-without-a-cable" "The error LED is dark without a link."
            => |d| d.encoder.led(|lit, right| if is_alone(lit, right) && !lit.stack.is_linked { "dark" } else { right });
        "error-led-on-in-operation" "The error LED is lit during data exchange."
            => |d| d.encoder.led(|lit, right| if is_silent(lit, right) { "red" } else { right });
        "error-led-off-late" "The error LED is still lit for 12 s after the start of data exchange."
            => |d| d.encoder.led(|lit, right| match lit.exchanged_for {
                Some(time) if is_silent(lit, right) && time < Duration::from_secs(12) => "red",
                _ => right,
            });
        "missing-parameters-led-steady" "The error LED is steady instead of flashing without user parameters."
            => |d| d.encoder.led(|lit, right| if right == HALF && !lit.has_record { "red" } else { right });
        "invalid-parameters-as-memory-error" "The error LED flashes at 1 Hz with invalid user parameters."
            => |d| d.encoder.led(|lit, right| if right == HALF && lit.has_record { ONE } else { right });
        "error-led-patterns-exchanged" "The patterns of the error LED for memory and sensor errors are swapped."
            => |d| d.encoder.led(|_, right| match right {
                ONE => FIVE,
                FIVE => ONE,
                right => right,
            });
        "error-led-one-frequency" "The error LED always flashes at 1 Hz."
            => |d| d.encoder.led(|_, right| if let HALF | FIVE = right { ONE } else { right });
    },
}];

const HALF: &str = "red_half_hertz";
const ONE: &str = "red_one_hertz";
const FIVE: &str = "red_five_hertz";

fn is_port(lit: &LedInput<'_>) -> bool {
    lit.name == "link1" || lit.name == "link2"
}

/// Whether the error LED is lit because there is no connection.
fn is_alone(lit: &LedInput<'_>, right: &str) -> bool {
    lit.name == "error" && right == "red"
}

/// Whether the error LED is dark although there is power.
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
