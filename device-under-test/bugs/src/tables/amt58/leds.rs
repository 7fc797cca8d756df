//! Bugs of the LEDs.

use crate::seams::Deviations;
use crate::tables::Deviation;
use core::time::Duration;
use reference_devices::models::datalogic_amt58::hooks::{Amt58Check, Amt58Hooks, Amt58View};
use reference_devices::models::datalogic_amt58::leds::{
    BUS_FAILURE, INVALID_PARAMETERS, Leds, NO_SUPPLY, OPERATION, RED_ZONE, Situation, TIME_OUT, leds,
};
use reference_devices::models::datalogic_amt58::red_zone;
use reference_devices::models::datalogic_amt58::scaling::SentScaling;
use reference_devices::models::datalogic_amt58::set_prm::{COUNTS, RESOLUTION, number};
use station::Time;

/// The bugs of the LEDs.
pub static BUGS: &[Deviation] = bugs! {
    "led-lit-without-power" "Without power the red LED stays lit."
        => |d| instead(d, NO_SUPPLY, TIME_OUT);
    "power-led-flashes-in-operation" "In data exchange without a fault the green LED flashes."
        => |d| instead(d, OPERATION, RED_ZONE);
    "led-patterns-exchanged" "The LED patterns of the red zone and of invalid parameters are swapped."
        => |d| d.amt58.leds(|_, _, leds| match leds {
            RED_ZONE => INVALID_PARAMETERS,
            INVALID_PARAMETERS => RED_ZONE,
            leds => leds,
        });
    "invalid-parameters-not-on-led" "With invalid parameters the LEDs show a bus communication failure."
        => |d| instead(d, INVALID_PARAMETERS, BUS_FAILURE);
    "time-out-shown-as-bus-failure" "After a watchdog timeout the LEDs show a bus communication failure."
        => |d| instead(d, TIME_OUT, BUS_FAILURE);
    "fault-led-steady-on-bus-failure" "With a bus communication failure the red LED is lit instead of flashing."
        => |d| instead(d, BUS_FAILURE, UNDEFINED);
    "memory-error-not-on-led" "The LEDs do not show a memory error."
        => |d| d.amt58.leds(|_, of, _| leds(&Situation { is_unreadable: false, ..*of }));
    "memory-fault-ignored-at-power-up" "The checksum of the memory is not checked at power-up."
        => |d| d.amt58.check(|_, check, right| right || check == Amt58Check::Memory);
    "undefined-led-pattern" "For a second after a watchdog timeout both LEDs are lit."
        => |d| d.amt58.add(LateTimeOut::default());
    "parameter-error-latched" "The LEDs show invalid parameters until power-off, even after valid ones."
        => |d| d.amt58.add(LatchedError::default());
    "red-zone-before-invalid-parameters" "The LEDs show the red zone for a refused scaling whose number of revolutions is not a power of two."
        => |d| d.amt58.add(RefusedZone::default());

    // Red zone
    "red-zone-always-signalled" "With scaling on the green LED always flashes, wherever the shaft is."
        => |d| d.amt58.red_zone(|view, _| view.parameters.scales);
    "one-revolution-has-red-zone" "A range of one revolution is not treated as a power of two, and the green LED always flashes."
        => |d| d.amt58.red_zone(|view, is_inside| {
            let scaling = &view.parameters.scaling;
            is_inside || view.parameters.scales && scaling.range == scaling.units_per_revolution
        });
    "red-led-in-red-zone" "In the red zone the red LED is also lit."
        => |d| instead(d, RED_ZONE, INVALID_PARAMETERS);
    "red-zone-led-by-parameters" "With a scaling that has a red zone the green LED always flashes, wherever the shaft is."
        => |d| d.amt58.red_zone(|view, _| {
            view.parameters.scales && red_zone::zone(&view.parameters.scaling, &view.hardware).1 > 0
        });
    "red-zone-not-on-led" "The green LED does not flash in the red zone."
        => |d| d.amt58.red_zone(|_, _| false);
    "singleturn-has-red-zone" "On the singleturn encoder the green LED flashes if the counts per revolution are not a power of two."
        => |d| d.amt58.red_zone(|view, is_inside| {
            let is_odd = !view.parameters.scaling.units_per_revolution.is_power_of_two();
            is_inside || view.parameters.scales && view.hardware.revolutions == 1 && is_odd
        });
};

const UNDEFINED: Leds = Leds { fault: TIME_OUT.fault, power: OPERATION.power };

/// Shows `wrong` where the manual has `right`.
fn instead(d: &mut Deviations, right: Leds, wrong: Leds) {
    d.amt58.leds(move |_, _, leds| if leds == right { wrong } else { leds });
}

/// Shows an undefined pattern for a second after a timeout.
#[derive(Default)]
struct LateTimeOut {
    /// When outputs were last received or cleared; the timeout clears them.
    outputs: Option<Time>,
}

impl Amt58Hooks for LateTimeOut {
    fn outputs(&mut self, view: &Amt58View<'_>, outputs: u32) -> u32 {
        self.outputs = Some(view.now);
        outputs
    }

    fn leds(&mut self, view: &Amt58View<'_>, _: &Situation, leds: Leds) -> Leds {
        let is_new = self.outputs.is_some_and(|time| view.now.since(time) < Duration::from_secs(1));
        if leds == TIME_OUT && is_new { UNDEFINED } else { leds }
    }
}

/// Shows invalid parameters until power-off.
#[derive(Default)]
struct LatchedError {
    was_invalid: bool,
}

impl Amt58Hooks for LatchedError {
    fn check(&mut self, _: &Amt58View<'_>, check: Amt58Check<'_>, verdict: bool) -> bool {
        self.was_invalid |=
            matches!(check, Amt58Check::UserOctets(_) | Amt58Check::Scaling(_) | Amt58Check::Unit(_)) && !verdict;
        verdict
    }

    fn load(&mut self, _: &Amt58View<'_>, offset: i64) -> i64 {
        self.was_invalid = false;
        offset
    }

    fn leds(&mut self, _: &Amt58View<'_>, of: &Situation, _: Leds) -> Leds {
        leds(&Situation { is_invalid: of.is_invalid || self.was_invalid, ..*of })
    }
}

/// Shows the red zone for invalid parameters whose scaling has one.
#[derive(Default)]
struct RefusedZone {
    has_zone: bool,
}

impl Amt58Hooks for RefusedZone {
    fn check(&mut self, view: &Amt58View<'_>, check: Amt58Check<'_>, verdict: bool) -> bool {
        if let Amt58Check::UserOctets(user) = check {
            let sent = SentScaling::new(number(user, COUNTS), number(user, RESOLUTION), &view.hardware);
            self.has_zone = red_zone::zone(&sent.forced, &view.hardware).1 > 0;
        }
        verdict
    }

    fn leds(&mut self, _: &Amt58View<'_>, _: &Situation, leds: Leds) -> Leds {
        if self.has_zone && leds == INVALID_PARAMETERS { RED_ZONE } else { leds }
    }
}
