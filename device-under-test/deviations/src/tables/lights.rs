//! Bugs of LEDs with the words of an encoder that has one light for itself, one for faults, one for the bus and one for
//! each port.

use super::Group;
use crate::needs::Need;
use encoder_profile::hooks::LedInput;
use reference_devices::manuals;

/// The bugs, by what they need.
pub static GROUPS: &[Group] = &[Group {
    needs: &[Need::Of(&manuals::SICK_AFX60)],
    deviations: bugs! {
        "signal-on-another-led" "When DCP asks for it the LED of the encoder flashes, and SF does not."
            => |d| d.encoder.led(signal_on_another_led);
        "sf-led-dark-in-error" "SF stays dark in an error."
            => |d| d.encoder.led(|lit, right| if (lit.name, right) == ("sf", "red") { "dark" } else { right });
        "bf-led-red-in-operation" "BF is red while data are exchanged."
            => |d| d.encoder.led(|lit, right| if lit.name == "bf" && lit.stack.exchanges_data { "red" } else { right });
        "bf-led-red-while-starting" "BF is red while the encoder starts."
            => |d| d.encoder.led(|lit, right| if (lit.name, right) == ("bf", "green") { "red" } else { right });
        "bf-led-dark-without-connection" "BF is dark without a connection."
            => |d| d.encoder.led(|lit, right| if (lit.name, right) == ("bf", "red") { "dark" } else { right });
        "led-lit-without-power" "Without supply the LEDs show what they showed before."
            => |d| d.encoder.led(led_lit_without_power);
        "self-test-not-on-leds" "The LED of the encoder is green while the encoder starts."
            => |d| d.encoder.led(|lit, right| if lit.name == "encoder" && lit.stack.is_booting { "green" } else { right });
        "encoder-led-stays-red-green" "The LED of the encoder stays red and green after the start."
            => |d| d.encoder.led(|lit, right| if (lit.name, right) == ("encoder", "green") { "red_green" } else { right });
        "limits-not-on-led" "The LED of the encoder stays green when a limit is passed."
            => |d| d.encoder.led(|lit, right| if right == "red_green" && !lit.stack.is_booting { "green" } else { right });
        "warning-stays-on-led" "The LED of the encoder stays red and green when a warning has gone."
            => |d| d.encoder.led(|lit, right| if lit.had_warning && (lit.name, right) == ("encoder", "green") { "red_green" } else { right });
        "memory-error-not-on-led" "The LED of the encoder stays green with an error of the memory."
            => |d| d.encoder.led(|lit, right| if lit.name == "encoder" && lit.faults & MEMORY != 0 { "green" } else { right });
        "invalid-preset-not-on-led" "The LED of the encoder stays green when a preset is invalid."
            => |d| d.encoder.led(|lit, right| if right == "orange" && !lit.has_wrong_parameters && lit.name == "encoder" { "green" } else { right });
        "invalid-configuration-not-on-led" "The LED of the encoder stays green when the configuration is invalid."
            => |d| d.encoder.led(|lit, right| if right == "orange" && lit.has_wrong_parameters && lit.name == "encoder" { "green" } else { right });
        "port-leds-exchanged" "The LEDs of the two ports are exchanged."
            => |d| d.encoder.led(port_leds_exchanged);
        "link-led-on-without-link" "The LED of the first port stays as it was without a cable."
            => |d| d.encoder.led(|lit, right| if lit.name == "la1" && lit.stack.has_supply && !lit.stack.is_linked { "green" } else { right });
        "link-led-without-activity" "The LED of a port shows the link alone."
            => |d| d.encoder.led(|lit, right| if (lit.name, right) == ("la1", "orange") { "green" } else { right });
        "link-led-busy-without-traffic" "The LED of a port with a cable shows traffic all the time."
            => |d| d.encoder.led(|lit, right| if (lit.name, right) == ("la1", "green") { "orange" } else { right });
        "reset-led-steady" "The LED of the encoder stays green when the reset is prepared."
            => |d| d.encoder.led(|_, right| if right == "green_flashing" { "green" } else { right });
    },
}];

/// Fault bit of the memory.
const MEMORY: u32 = 1 << 5;

fn signal_on_another_led(lit: &LedInput<'_>, right: &'static str) -> &'static str {
    match (lit.name, lit.stack.is_signalling) {
        ("sf", true) if lit.faults == 0 => "dark",
        ("sf", true) => "red",
        ("encoder", true) => "green_flashing",
        _ => right,
    }
}

fn led_lit_without_power(lit: &LedInput<'_>, right: &'static str) -> &'static str {
    match (lit.name, lit.stack.has_supply) {
        ("encoder" | "la1", false) => "green",
        ("bf", false) => "red",
        _ => right,
    }
}

fn port_leds_exchanged(lit: &LedInput<'_>, right: &'static str) -> &'static str {
    match lit.name {
        "la1" => "dark",
        "la2" if !lit.stack.has_supply || !lit.stack.is_linked => "dark",
        "la2" if lit.stack.exchanges_data => "orange",
        "la2" => "green",
        _ => right,
    }
}
