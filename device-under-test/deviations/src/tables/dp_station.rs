//! Bugs of what hands set and lights show at an encoder with PROFIBUS.

use super::Deviation;
use super::slave_memory::FollowsAddress;
use reference_devices::models::sick_a3m60::knobs::address;

/// The bugs of this seam.
pub static BUGS: &[Deviation] = bugs! {
    // LEDs
    "bus-led-green-without-exchange" "The LED of the bus is green whenever there is power."
        => |b| b.at_encoder.led(|lit, right| if lit.name == "bus" && matches!(right, "red" | "orange") { "green" } else { right });
    "leds-dark-after-wrong-initialization" "When the initialization fails the LEDs stay dark."
        => |b| b.a3m60.bad_start_light = "dark";
    "undervoltage-not-on-leds" "A supply that is too low is not shown."
        => |b| b.a3m60.lowest_voltage = 0;
    "bus-led-red-with-wrong-parameters" "With wrong parameters the LED of the bus is red."
        => |b| b.at_encoder.led(|lit, right| if (lit.name, right) == ("bus", "orange") { "red" } else { right });
    "bus-led-stays-green" "The LED of the bus stays green when the master has gone."
        => |b| b.at_encoder.led(|lit, right| if (lit.name, right) == ("bus", "red") && lit.has_record { "green" } else { right });
    "encoder-led-follows-the-bus" "The LED of the encoder is orange without an exchange of data."
        => |b| b.at_encoder.led(|lit, right| if (lit.name, right) == ("encoder", "green") && !lit.seen.exchanges_data { "orange" } else { right });
    "sensor-error-not-on-led" "Errors of the sensor are not shown."
        => |b| b.a3m60.is_orange = |_, _| false;
    "warning-on-the-encoder-led" "A speed that is too high makes the LED of the encoder orange."
        => |b| b.a3m60.is_orange = |right, words| right || words.a & 1 << 5 != 0;

    // Switches
    "address-in-hexadecimal" "The address is sixteen times the first switch and the second one."
        => |b| b.a3m60.address = |[tens, ones]| permitted(tens * 16 + ones);
    "address-1-refused" "With the switches at 1 the encoder stays off the bus."
        => |b| b.a3m60.address = |switches| address(switches).filter(|address| *address != 1);
    "addresses-above-99-refused" "Above 99 the encoder stays off the bus."
        => |b| b.a3m60.address = |switches| address(switches).filter(|address| *address <= 99);
    "hexadecimal-letters-as-0" "Letters of the first switch count as 0 to 5."
        => |b| b.a3m60.address = |[tens, ones]| address([tens % 10, ones]);
    "address-modulo-128" "Of an address above 127 the lower seven bits are taken."
        => |b| b.a3m60.address = |[tens, ones]| permitted((tens * 10 + ones) % 128);
    "works-at-0" "With both switches at 0 the encoder answers at 0."
        => |b| b.a3m60.address = |switches| address(switches).or((switches == [0; 2]).then_some(0));
    "address-taken-over-the-bus" "Set_Slave_Address is taken."
        => |b| b.a3m60.takes_address = true;
    "address-changes-on-the-fly" "The switches count at once."
        => |b| {
            b.a3m60.reads_switches_at_once = true;
            b.slave.add(FollowsAddress);
        };
    "one-switch-terminates" "One switch is enough for the termination."
        => |b| b.a3m60.terminates = |switches| switches != [0; 2];

    // Button
    "button-ignored" "The button makes no preset."
        => |b| b.sick.button = |_| None;
    "button-always-sets-0" "The button sets the position to 0."
        => |b| b.sick.button = |_| Some(0);
    "button-without-class-4-presets" "The button makes a preset although class 4 is off."
        => |b| b.sick.button_needs_class_4 = false;
};

fn permitted(address: u32) -> Option<u8> {
    u8::try_from(address).ok().filter(|address| (1..=125).contains(address))
}
