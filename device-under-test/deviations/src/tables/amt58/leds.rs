//! Bugs of the LEDs.

use crate::tables::Deviation;
use reference_devices::models::datalogic_amt58::lights::{
    self, GOOD, INVALID, Lamps, NO_BUS, Situation, TIME_OUT, ZONE, lamps,
};
use reference_devices::models::datalogic_amt58::program;

/// The bugs of this seam.
pub static BUGS: &[Deviation] = bugs! {
    "led-lit-without-power" "Without supply the red LED stays lit."
        => |b| b.amt58.lamps = |of| if of.seen.has_supply { lamps(of) } else { TIME_OUT };
    "power-led-flashes-in-operation" "In data exchange without a fault the green LED flashes."
        => |b| b.amt58.lamps = |of| instead(of, GOOD, ZONE);
    "led-patterns-exchanged" "In the red zone the LEDs show what invalid parameters have to show, and the other way round."
        => |b| b.amt58.lamps = |of| match lamps(of) {
            ZONE => INVALID,
            INVALID => ZONE,
            shown => shown,
        };
    "invalid-parameters-not-on-led" "With invalid parameters the LEDs show a bus communication failure."
        => |b| b.amt58.lamps = |of| instead(of, INVALID, NO_BUS);
    "time-out-shown-as-bus-failure" "When the watchdog has expired the LEDs show a bus communication failure."
        => |b| b.amt58.lamps = |of| instead(of, TIME_OUT, NO_BUS);
    "fault-led-steady-on-bus-failure" "With a bus communication failure the red LED is lit instead of flashing."
        => |b| b.amt58.lamps = |of| instead(of, NO_BUS, UNDEFINED);
    "memory-error-not-on-led" "A memory error is not shown by the LEDs."
        => |b| b.amt58.lamps = |of| lamps(&Situation { is_unreadable: false, ..*of });
    "memory-fault-ignored-at-power-up" "The checksum of the memory is not looked at when the supply comes."
        => |b| b.amt58.checks_memory = false;
    "undefined-led-pattern" "For a second after the watchdog has expired the red LED is lit while the green one is still lit."
        => |b| b.amt58.lamps = |of| if of.expired_for < 1_000 { instead(of, TIME_OUT, UNDEFINED) } else { lamps(of) };
    "parameter-error-latched" "The LEDs show invalid parameters until the supply goes off, although right ones came."
        => |b| b.amt58.lamps = |of| lamps(&Situation { is_invalid: of.was_invalid, ..*of });
    "red-zone-before-invalid-parameters" "A scaling that is refused and whose number of revolutions is no power of two is shown as the red zone."
        => |b| b.amt58.lamps = |of| if of.is_invalid_with_zone { instead(of, INVALID, ZONE) } else { lamps(of) };

    // Red zone
    "red-zone-always-signalled" "With scaling on the green LED flashes wherever the shaft is."
        => |b| b.amt58.is_in_zone = |zone| zone.program.scales;
    "one-revolution-has-red-zone" "One revolution is not taken for a power of two, and the green LED flashes all the time."
        => |b| b.amt58.is_in_zone = |zone| {
            let scaling = &zone.program.scaling;
            program::is_in_zone(zone) || zone.program.scales && scaling.range == scaling.units_per_revolution
        };
    "red-led-in-red-zone" "In the red zone the red LED is lit too."
        => |b| b.amt58.lamps = |of| instead(of, ZONE, INVALID);
    "red-zone-led-by-parameters" "With a scaling that has a red zone the green LED flashes wherever the shaft is."
        => |b| b.amt58.is_in_zone = |zone| {
            zone.program.scales && program::zone(&zone.program.scaling, zone.hardware).1 > 0
        };
    "red-zone-not-on-led" "The green LED does not flash in the red zone."
        => |b| b.amt58.is_in_zone = |_| false;
    "singleturn-has-red-zone" "On the singleturn encoder counts per revolution that are no power of two make the green LED flash."
        => |b| b.amt58.is_in_zone = |zone| {
            let is_odd = !zone.program.scaling.units_per_revolution.is_power_of_two();
            program::is_in_zone(zone) || zone.program.scales && zone.hardware.revolutions == 1 && is_odd
        };
};

const UNDEFINED: Lamps = Lamps { red: lights::TIME_OUT.red, green: lights::GOOD.green };

fn instead(of: &Situation, right: Lamps, wrong: Lamps) -> Lamps {
    let shown = lamps(of);
    if shown == right { wrong } else { shown }
}
