//! Errors, warnings and their diagnoses, the sensor status and the LEDs.

use super::TEMPERATURE;
use crate::needs::Need;
use crate::seams::Deviations;
use crate::tables::Group;
use alloc::rc::Rc;
use alloc::vec::Vec;
use core::cell::{Cell, RefCell};
use core::time::Duration;
use device_stack::profinet::DiagnosisSeverity;
use encoder_profile::hooks::{EncoderHooks, EncoderView, LedInput};
use encoder_profile::profidrive::sensor::SensorError;
use encoder_profile::profidrive::telegram::{PreviousCycle, SignalImage};
use reference_devices::manuals;
use reference_devices::models::sick_afx60::hooks::Afx60Check;
use station::Time;

/// The variations.
pub const GROUP: Group = Group {
    needs: &[Need::Of(&manuals::SICK_AFX60)],
    deviations: permitted! {
        // Errors and warnings
        "undervoltage-without-a-word" "Below its limit the encoder is down until the supply is sufficient, so that no error is shown."
            "5.4.4, Table 53 (1003h): the encoder is started again; when it stops is not printed"
            => |d| undervoltage_without_a_word(d);
        "temperature-limit-is-an-error" "A temperature above the limit of P1006 is the error 0F05h, besides the warning."
            "5.4.4, Table 53: operating temperature exceeded is an error; which limit applies is not printed"
            => |d| temperature_limit_is_an_error(d);
        "commissioning-as-sensor-error" "The error 'diagnostics during commissioning' has the code 0001h in G1_XIST2."
            "5.4.4, Table 53 has no row for it; 0001h covers errors in the electronics"
            => |d| d.encoder.code(|fact| if fact.fault_bits == COMMISSIONING { Some(1) } else { fact.code });
        "warnings-wait-for-an-acknowledgement" "A warning in P65001 and its diagnosis stay until they are acknowledged."
            "5.4.2: what P65001 shows can be reset by bit 15 of G1_STW"
            => |d| warnings_wait_for_an_acknowledgement(d);
        "cold-not-in-p65001" "A temperature below its limit is reported by the alarm and the sensor status, not in P65001."
            "5.4.2, Table 49 bit 1: operating temperature exceeded"
            => |d| cold_not_in_p65001(d);
        "alarm-ends-with-its-cause" "The diagnosis of an error is withdrawn when its cause is gone, before the error is acknowledged."
            "5.4.3 is silent about the end of a diagnosis"
            => |d| alarm_ends_with_its_cause(d);
        "maintenance-demanded" "A warning is reported as maintenance demanded."
            "5.4.3: maintenance prompts, of which PROFINET has two"
            => |d| d.encoder.diagnoses(|_, all| all.into_iter().map(|(error_type, severity)| (error_type, match severity {
                DiagnosisSeverity::MaintenanceRequired => DiagnosisSeverity::MaintenanceDemanded,
                other => other,
            })).collect());

        // The sensor status
        "invalid-preset-shown-until-power-off" "The warning of an invalid preset stays until power-off."
            "5.4.1, Table 45 bit 4 is silent about the end of the warning"
            => |d| d.encoder.add(InvalidPresetStays::default());
        "preset-accepted-until-its-request-ends" "Bit 12 of S_STAT_C is 0 once the preset is no longer requested."
            "5.4.1, Table 46 bit 12 is silent about the end of the bit"
            => |d| d.encoder.element(|view, at, right| if at == (1001, 2) && !view.sensor.request().home { right & !0x1000 } else { right });
        "synchronous-operation" "S_STAT_C shows synchronous operation instead of free run."
            "5.4.1, Table 46 bits 15 and 14: which of both applies without isochronous mode is not printed"
            => |d| d.encoder.element(|_, at, right| if at == (1001, 2) { right & !0x4000 | 0x8000 } else { right });
        "save-complete-for-a-second" "S_STAT_C shows a complete save for one second."
            "5.4.1, Table 46 bits 1 and 0 are silent about the end of the state"
            => |d| d.encoder.add(CompleteForASecond::default());

        // The LEDs
        "red-and-orange-flash" "The encoder LED flashes red for an error and orange for an invalid value."
            "5.3.1, Table 42: the symbols do not tell steady from flashing"
            => |d| d.encoder.led(|lit, right| match (lit.name, right) {
                ("encoder", "red") => "red_flashing",
                ("encoder", "orange") => "orange_flashing",
                _ => right,
            });
        "bf-flashes" "BF flashes green during initialization and red without a connection."
            "5.3.1, Table 41: the symbols do not tell steady from flashing"
            => |d| d.encoder.led(|lit, right| match (lit.name, right) {
                ("bf", "red") => "red_flashing",
                ("bf", "green") => "green_flashing",
                _ => right,
            });
        "traffic-flashes-green" "The LED of a port flashes green with traffic."
            "5.3.1, Table 43: green for data transmission"
            => |d| d.encoder.led(|lit, right| if (lit.name, right) == ("la1", "orange") { "green_flashing" } else { right });
        "sf-red-without-data-exchange" "SF is red while no data are exchanged, with or without an error."
            "5.3.1, Table 40: encoder error, no data exchange"
            => |d| d.encoder.led(|lit, right| if is_sf(lit, "dark", right) && lit.stack.has_supply && !lit.stack.exchanges_data { "red" } else { right });
        "sf-dark-during-data-exchange" "SF is dark during data exchange, even in an error."
            "5.3.1, Table 40: encoder error, no data exchange"
            => |d| d.encoder.led(|lit, right| if is_sf(lit, "red", right) && lit.stack.exchanges_data { "dark" } else { right });
    },
};

/// Fault bit of the error 'diagnostics during commissioning'.
const COMMISSIONING: u32 = 1 << 4;
/// Code of an operating temperature that is exceeded.
const HOT: u16 = 0x0F05;
/// Bit of S_STAT_B for an invalid preset.
const INVALID_PRESET: u64 = 1 << 4;

fn is_sf(lit: &LedInput<'_>, shown: &str, right: &str) -> bool {
    (lit.name, right) == ("sf", shown)
}

fn undervoltage_without_a_word(d: &mut Deviations) {
    let is_low = Cell::new(false);
    d.afx60.check(move |check, right| match check {
        Afx60Check::Undervoltage(..) => {
            is_low.set(right);
            right
        }
        Afx60Check::Works { .. } => right && !is_low.get(),
        _ => right,
    });
}

fn temperature_limit_is_an_error(d: &mut Deviations) {
    let is_hot = Rc::new(Cell::new(false));
    let measured = is_hot.clone();
    d.afx60.check(move |check, right| {
        if let Afx60Check::TemperatureIsOutside(celsius, [_, upper]) = check {
            measured.set(celsius > upper);
        }
        right
    });
    d.encoder.causes(move |view, mut all| {
        let hot = view.facts.errors.iter().position(|fact| fact.code == Some(HOT));
        let hot = hot.map(|number| SensorError { number: number as u16, code: Some(HOT) });
        all.extend(hot.filter(|hot| is_hot.get() && !all.contains(hot)));
        all
    });
}

fn warnings_wait_for_an_acknowledgement(d: &mut Deviations) {
    let latched = Rc::new(Cell::new(0));
    let shown = latched.clone();
    d.encoder.warnings(move |_, right| {
        shown.set(shown.get() | right);
        shown.get()
    });
    let at_power_up = latched.clone();
    d.encoder.powered_up(move || at_power_up.set(0));
    d.encoder.signals(move |before, now| {
        if before.unhooked.request.acknowledge && !now.request.acknowledge {
            latched.set(0);
        }
        now
    });
}

fn cold_not_in_p65001(d: &mut Deviations) {
    let is_cold = Rc::new(Cell::new(false));
    let measured = is_cold.clone();
    d.afx60.check(move |check, right| {
        if let Afx60Check::TemperatureIsOutside(celsius, [lower, _]) = check {
            measured.set(celsius <= lower);
        }
        right
    });
    d.encoder.element(
        move |_, at, right| {
            if at == (65001, 4) && is_cold.get() { right & !u64::from(TEMPERATURE) } else { right }
        },
    );
}

fn alarm_ends_with_its_cause(d: &mut Deviations) {
    let present = Rc::new(RefCell::new(Vec::new()));
    let causes = present.clone();
    d.encoder.causes(move |_, all| {
        *causes.borrow_mut() = all.iter().map(|error| error.number).collect::<Vec<u16>>();
        all
    });
    d.encoder.diagnoses(move |view, all| {
        let present = present.borrow();
        let ends = |error_type: u16| {
            let of = view.facts.errors.iter().enumerate().filter(|(_, fact)| fact.error_type == Some(error_type));
            let numbers: Vec<u16> = of.map(|(number, _)| number as u16).collect();
            !numbers.is_empty() && !numbers.iter().any(|number| present.contains(number))
        };
        all.into_iter().filter(|(error_type, _)| !ends(*error_type)).collect()
    });
}

/// Keeps the bit of an invalid preset.
#[derive(Default)]
struct InvalidPresetStays {
    is_set: bool,
}

impl EncoderHooks for InvalidPresetStays {
    fn element(&mut self, _: &EncoderView<'_>, at: (u16, usize), right: u64) -> u64 {
        if at != (1001, 1) {
            return right;
        }
        self.is_set |= right & INVALID_PRESET != 0;
        if self.is_set { right | INVALID_PRESET } else { right }
    }

    fn powered_up(&mut self) {
        self.is_set = false;
    }
}

/// Clears the state of a complete save after a second.
#[derive(Default)]
struct CompleteForASecond {
    saving_at: Option<Time>,
}

impl EncoderHooks for CompleteForASecond {
    fn image(&mut self, view: &EncoderView<'_>, _: &PreviousCycle, now: SignalImage) -> SignalImage {
        if view.store.preset_value.deadline().is_some() {
            self.saving_at = Some(view.now);
        }
        now
    }

    fn element(&mut self, view: &EncoderView<'_>, at: (u16, usize), right: u64) -> u64 {
        let is_over = self.saving_at.is_none_or(|saving| view.now.since(saving) > Duration::from_secs(1));
        if at == (1001, 2) && right & 3 == 2 && is_over { right & !3 } else { right }
    }
}
