//! Bugs of the LEDs, switches and button of a PROFIBUS encoder.

use super::Group;
use super::unrequested_presets::button_without_class_4;
use crate::needs::Need;
use crate::seams::slave::{frame, with_data};
use alloc::rc::Rc;
use alloc::vec::Vec;
use core::cell::Cell;
use device_stack::profibus::{SlaveApplication, SlaveHooks, SlaveStackCheck as SlaveCheck};
use reference_devices::manuals;
use reference_devices::models::sick::hooks as sick;
use reference_devices::models::sick_a3m60::hooks::A3m60Check;
use reference_devices::models::sick_a3m60::status::OVERSPEED;
use station::StandAction;
use wire::profibus::fdl::DataFrame;

/// The bugs, by what they need.
pub static GROUPS: &[Group] = &[Group {
    needs: &[Need::Of(&manuals::SICK_A3M60)],
    deviations: bugs! {
        // LEDs
        "bus-led-green-without-exchange" "The bus LED is green even without data exchange."
            => |d| d.encoder.led(|lit, right| if lit.name == "bus" && matches!(right, "red" | "orange") { "green" } else { right });
        "leds-dark-after-wrong-initialization" "If the initialization fails, the LEDs stay dark."
            => |d| {
                let fails = d.track_fault("initialization");
                d.encoder.led(move |_, right| if fails.get() { "dark" } else { right });
            };
        "undervoltage-not-on-leds" "The LEDs do not show undervoltage."
            => |d| d.a3m60.check(|check, right| right || matches!(check, A3m60Check::Supply(_)));
        "bus-led-red-with-wrong-parameters" "With invalid parameters the bus LED is red."
            => |d| d.encoder.led(|lit, right| if (lit.name, right) == ("bus", "orange") { "red" } else { right });
        "bus-led-stays-green" "The bus LED stays green after the master has stopped."
            => |d| d.encoder.led(|lit, right| if (lit.name, right) == ("bus", "red") && lit.has_record { "green" } else { right });
        "encoder-led-follows-the-bus" "The encoder LED is orange without data exchange."
            => |d| d.encoder.led(|lit, right| if (lit.name, right) == ("encoder", "green") && !lit.stack.exchanges_data { "orange" } else { right });
        "sensor-error-not-on-led" "The LEDs do not show sensor errors."
            => |d| d.encoder.led(|lit, right| if (lit.name, right) == ("encoder", "orange") { "green" } else { right });
        "warning-on-the-encoder-led" "Overspeed turns the encoder LED orange."
            => |d| {
                let words = d.track_status();
                d.encoder.led(move |lit, right| match (lit.name, right) {
                    ("encoder", "green") if words.get().a & OVERSPEED != 0 => "orange",
                    _ => right,
                });
            };

        // Switches
        "address-in-hexadecimal" "The address is sixteen times the first switch plus the second switch."
            => |d| d.a3m60.switches(|[tens, ones]| switches(tens * 16 + ones));
        "address-1-refused" "With the switches at 1 the encoder stays off the bus."
            => |d| d.a3m60.check(|check, right| right && check != A3m60Check::Address(1));
        "addresses-above-99-refused" "With addresses above 99 the encoder stays off the bus."
            => |d| d.a3m60.check(|check, right| right && !matches!(check, A3m60Check::Address(100..)));
        "hexadecimal-letters-as-0" "The letters A to F of the first switch count as 0 to 5."
            => |d| d.a3m60.switches(|[tens, ones]| [tens % 10, ones]);
        "address-modulo-128" "An address above 127 is reduced to its lower seven bits."
            => |d| d.a3m60.switches(|[tens, ones]| switches((tens * 10 + ones) % 128));
        "address-in-factory-state-126" "With the switches in their factory position, 0 and 2, the address is 126."
            => |d| {
                d.a3m60.switches(|set| if set == [0, 2] { switches(126) } else { set });
                d.a3m60.check(|check, right| right || check == A3m60Check::Address(126));
            };
        "errors-below-12-volts" "Below 12 V the sensor status reports all its errors."
            => |d| {
                let is_low = Rc::new(Cell::new(false));
                d.slave.add(LowSupply(is_low.clone()));
                d.encoder.element(move |_, at, right| if at == (1000, 0) && is_low.get() { right | 0xEFC0 } else { right });
            };
        "works-at-0" "With both switches at 0 the encoder answers at address 0."
            => |d| d.a3m60.check(|check, right| right || check == A3m60Check::Address(0));
        "address-taken-over-the-bus" "Set_Slave_Address is accepted."
            => |d| d.slave.check(|check, right| right || check == SlaveCheck::AddressService);
        "address-changes-on-the-fly" "A new address of the switches is used at once, without a power cycle."
            => |d| {
                let address = Rc::default();
                d.slave.add(LiveHexSwitches { switches: [0; 2], address: Rc::clone(&address) });
                d.encoder.element(move |_, at, right| if at == (918, 0) { address.get().map_or(right, u64::from) } else { right });
            };
        "never-terminates" "The bus is not terminated with both switches on."
            => |d| d.a3m60.check(|check, right| right && !matches!(check, A3m60Check::Terminated(_)));
        "always-terminates" "The bus is terminated even with both switches off."
            => |d| d.a3m60.check(|check, right| right || matches!(check, A3m60Check::Terminated(_)));
        "one-switch-terminates" "One of the two switches is enough to terminate the bus."
            => |d| d.a3m60.check(|check, right| match check { A3m60Check::Terminated(switches) => switches != [0; 2], _ => right });

        // Button
        "button-ignored" "The button makes no preset."
            => |d| d.sick.check(|check, right| right && !matches!(check, sick::SickCheck::ButtonPresets(_)));
        "button-without-class-4-presets" "The button makes a preset although class 4 is off."
            => |d| button_without_class_4(d);
    },
}];

/// The positions of the switches for an address.
fn switches(address: u32) -> [u32; 2] {
    [address / 10, address % 10]
}

/// An address at which no station answers.
const NOWHERE: u8 = 255;

/// Uses the address of the switches as soon as they are turned.
struct LiveHexSwitches {
    switches: [u32; 2],
    /// The address of the switches; `None` before they are turned.
    address: Rc<Cell<Option<u8>>>,
}

impl SlaveHooks for LiveHexSwitches {
    fn act(&mut self, action: &StandAction<'_>) {
        match *action {
            StandAction::Switch("tens", place) => self.switches[0] = place,
            StandAction::Switch("ones", place) => self.switches[1] = place,
            _ => return,
        }
        let [tens, ones] = self.switches;
        let address = u8::try_from(tens * 10 + ones).ok().filter(|address| (1..=125).contains(address));
        self.address.set(Some(address.unwrap_or(NOWHERE)));
    }

    fn check(&mut self, encoder: &dyn SlaveApplication, check: SlaveCheck, verdict: bool) -> bool {
        match (check, self.address.get()) {
            (SlaveCheck::Address(requested), Some(address)) => requested == address,
            (_, Some(_)) => verdict,
            (_, None) => {
                self.switches = switches(encoder.address().into());
                verdict
            }
        }
    }

    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        if let (Some(frame), Some(address)) = (frame(telegram), self.address.get()) {
            *telegram = with_data(&DataFrame { sa: address, ..frame }, frame.data);
        }
    }
}

/// Tracks whether the supply voltage is below 12 V.
struct LowSupply(Rc<Cell<bool>>);

impl SlaveHooks for LowSupply {
    fn act(&mut self, action: &StandAction<'_>) {
        if let StandAction::SupplyVoltage(volts) = *action {
            self.0.set(volts < 12.0);
        }
    }
}
