//! Bugs of the LEDs of the AFS60 and AFM60: the encoder LED, SF, BF and the link LEDs.

use super::Group;
use crate::needs::Need;
use encoder_profile::hooks::LedInput;
use reference_devices::manuals;

/// The bugs, by what they need.
pub static GROUPS: &[Group] = &[Group {
    needs: &[Need::Of(&manuals::SICK_AFX60)],
    deviations: bugs! {
        "signal-on-another-led" "DCP Signal flashes the encoder LED instead of SF."
            => |d| d.encoder.led(signal_on_another_led);
        "sf-led-dark-in-error" "SF stays dark during an error."
            => |d| d.encoder.led(|lit, right| if (lit.name, right) == ("sf", "red") { "dark" } else { right });
        "bf-led-red-in-operation" "BF is red during data exchange."
            => |d| d.encoder.led(|lit, right| if lit.name == "bf" && lit.stack.exchanges_data { "red" } else { right });
        "bf-led-red-while-starting" "BF is red during start-up."
            => |d| d.encoder.led(|lit, right| if (lit.name, right) == ("bf", "green") { "red" } else { right });
        "bf-led-dark-without-connection" "BF is dark without a connection."
            => |d| d.encoder.led(|lit, right| if (lit.name, right) == ("bf", "red") { "dark" } else { right });
        "led-lit-without-power" "Without power the LEDs stay lit."
            => |d| d.encoder.led(led_lit_without_power);
        "self-test-not-on-leds" "The encoder LED is green during start-up."
            => |d| d.encoder.led(|lit, right| if lit.name == "encoder" && lit.stack.is_booting { "green" } else { right });
        "encoder-led-stays-red-green" "The encoder LED stays red and green after start-up."
            => |d| d.encoder.led(|lit, right| if (lit.name, right) == ("encoder", "green") { "red_green" } else { right });
        "limits-not-on-led" "The encoder LED stays green when a limit is exceeded."
            => |d| d.encoder.led(|lit, right| if right == "red_green" && !lit.stack.is_booting { "green" } else { right });
        "warning-stays-on-led" "The encoder LED stays red and green after a warning has disappeared."
            => |d| d.encoder.led(|lit, right| if lit.had_warning && (lit.name, right) == ("encoder", "green") { "red_green" } else { right });
        "memory-error-not-on-led" "The encoder LED stays green during a memory error."
            => |d| d.encoder.led(|lit, right| if lit.name == "encoder" && lit.faults & MEMORY != 0 { "green" } else { right });
        "invalid-preset-not-on-led" "The encoder LED stays green after an invalid preset."
            => |d| d.encoder.led(|lit, right| if right == "orange" && !lit.has_wrong_parameters && lit.name == "encoder" { "green" } else { right });
        "invalid-configuration-not-on-led" "The encoder LED stays green with an invalid configuration."
            => |d| d.encoder.led(|lit, right| if right == "orange" && lit.has_wrong_parameters && lit.name == "encoder" { "green" } else { right });
        "port-leds-exchanged" "The LEDs of the two ports are swapped."
            => |d| d.encoder.led(port_leds_exchanged);
        "link-led-on-without-link" "The LED of the first port is green without a link."
            => |d| d.encoder.led(|lit, right| if lit.name == "la1" && lit.stack.has_supply && !lit.stack.is_linked { "green" } else { right });
        "link-led-without-activity" "The LED of a port shows only the link, not the traffic."
            => |d| d.encoder.led(|lit, right| if (lit.name, right) == ("la1", "orange") { "green" } else { right });
        "link-led-busy-without-traffic" "The LED of a port with a link always shows traffic."
            => |d| d.encoder.led(|lit, right| if (lit.name, right) == ("la1", "green") { "orange" } else { right });
        "reset-led-steady" "The encoder LED does not flash when the reset is prepared."
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
