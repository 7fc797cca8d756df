//! Bugs of LEDs with the words of an encoder that has one light for itself, one for faults, one for the bus and one for
//! each port.

use super::Bug;
use encoder_profile::deviation::Lit;

/// The bugs of this seam.
pub static BUGS: &[Bug] = encoder_bugs! {
    "signal-on-another-led" "When DCP asks for it the LED of the encoder flashes, and SF does not."
        => |b| b.at_encoder.led(signal_on_another_led);
    "sf-led-dark-in-error" "SF stays dark in an error."
        => |b| b.at_encoder.led(|lit| if (lit.name, lit.right) == ("sf", "red") { "dark" } else { lit.right });
    "bf-led-red-in-operation" "BF is red while data are exchanged."
        => |b| b.at_encoder.led(|lit| if lit.name == "bf" && lit.seen.exchanges_data { "red" } else { lit.right });
    "bf-led-red-while-starting" "BF is red while the encoder starts."
        => |b| b.at_encoder.led(|lit| if (lit.name, lit.right) == ("bf", "green") { "red" } else { lit.right });
    "bf-led-dark-without-connection" "BF is dark without a connection."
        => |b| b.at_encoder.led(|lit| if (lit.name, lit.right) == ("bf", "red") { "dark" } else { lit.right });
    "led-lit-without-power" "Without supply the LEDs show what they showed before."
        => |b| b.at_encoder.led(led_lit_without_power);
    "self-test-not-on-leds" "The LED of the encoder is green while the encoder starts."
        => |b| b.at_encoder.led(|lit| if lit.name == "encoder" && lit.seen.is_booting { "green" } else { lit.right });
    "encoder-led-stays-red-green" "The LED of the encoder stays red and green after the start."
        => |b| b.at_encoder.led(|lit| if (lit.name, lit.right) == ("encoder", "green") { "red_green" } else { lit.right });
    "limits-not-on-led" "The LED of the encoder stays green when a limit is passed."
        => |b| b.at_encoder.led(|lit| if lit.right == "red_green" && !lit.seen.is_booting { "green" } else { lit.right });
    "warning-stays-on-led" "The LED of the encoder stays red and green when a warning has gone."
        => |b| b.at_encoder.led(|lit| if lit.had_warning && (lit.name, lit.right) == ("encoder", "green") { "red_green" } else { lit.right });
    "memory-error-not-on-led" "The LED of the encoder stays green with an error of the memory."
        => |b| b.at_encoder.led(|lit| if lit.name == "encoder" && lit.faults & MEMORY != 0 { "green" } else { lit.right });
    "invalid-preset-not-on-led" "The LED of the encoder stays green when a preset is invalid."
        => |b| b.at_encoder.led(|lit| if lit.right == "orange" && !lit.has_wrong_parameters && lit.name == "encoder" { "green" } else { lit.right });
    "invalid-configuration-not-on-led" "The LED of the encoder stays green when the configuration is invalid."
        => |b| b.at_encoder.led(|lit| if lit.right == "orange" && lit.has_wrong_parameters && lit.name == "encoder" { "green" } else { lit.right });
    "port-leds-exchanged" "The LEDs of the two ports are exchanged."
        => |b| b.at_encoder.led(port_leds_exchanged);
    "link-led-on-without-link" "The LED of the first port stays as it was without a cable."
        => |b| b.at_encoder.led(|lit| if lit.name == "la1" && lit.seen.has_supply && !lit.seen.is_linked { "green" } else { lit.right });
    "link-led-without-activity" "The LED of a port shows the link alone."
        => |b| b.at_encoder.led(|lit| if (lit.name, lit.right) == ("la1", "orange") { "green" } else { lit.right });
    "link-led-busy-without-traffic" "The LED of a port with a cable shows traffic all the time."
        => |b| b.at_encoder.led(|lit| if (lit.name, lit.right) == ("la1", "green") { "orange" } else { lit.right });
    "reset-led-steady" "The LED of the encoder stays green when the reset is prepared."
        => |b| b.at_encoder.led(|lit| if lit.right == "green_flashing" { "green" } else { lit.right });
};

/// Fault bit of the memory.
const MEMORY: u32 = 1 << 5;

fn signal_on_another_led(lit: &Lit<'_>) -> &'static str {
    match (lit.name, lit.seen.is_signalling) {
        ("sf", true) if lit.faults == 0 => "dark",
        ("sf", true) => "red",
        ("encoder", true) => "green_flashing",
        _ => lit.right,
    }
}

fn led_lit_without_power(lit: &Lit<'_>) -> &'static str {
    match (lit.name, lit.seen.has_supply) {
        ("encoder" | "la1", false) => "green",
        ("bf", false) => "red",
        _ => lit.right,
    }
}

fn port_leds_exchanged(lit: &Lit<'_>) -> &'static str {
    match lit.name {
        "la1" => "dark",
        "la2" if !lit.seen.has_supply || !lit.seen.is_linked => "dark",
        "la2" if lit.seen.exchanges_data => "orange",
        "la2" => "green",
        _ => lit.right,
    }
}
