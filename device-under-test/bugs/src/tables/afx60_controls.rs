//! Bugs of the button, the switches and the vendor record of the AFS60 and AFM60: save mode, preset value of the start, manual reset.

use super::Group;
use super::unrequested_presets::{button_without_class_4, next_preset};
use crate::needs::Need;
use crate::seams::Deviations;
use alloc::rc::Rc;
use core::cell::Cell;
use device_stack::profinet::{StackCheck, StationData};
use reference_devices::manuals;
use reference_devices::models::sick::hooks;
use reference_devices::models::sick_afx60::hooks::{Afx60Check, Afx60Event, RetainedVendorData};

/// The bugs, by what they need.
pub static GROUPS: &[Group] = &[
    Group {
        needs: &[Need::Of(&manuals::SICK_AFX60)],
        deviations: bugs! {
            // Presets
            "button-without-class-4-presets" "The button makes a preset although class 4 is off."
                => |d| button_without_class_4(d);
            "button-presets-to-zero" "The button sets the position to 0."
                => |d| d.sick.button(|_| 0);
            "button-ignored" "The button makes no preset."
                => |d| d.sick.check(|check, right| right && !matches!(check, hooks::SickCheck::ButtonPresets(_)));
            "preset-range-not-checked" "A preset beyond the range is carried out and not reported."
                => |d| d.afx60.check(|check, right| right || matches!(check, Afx60Check::PresetValue { .. }));
            "highest-preset-is-invalid" "A preset to the highest position is treated as invalid."
                => |d| d.afx60.check(|check, right| match check {
                    Afx60Check::PresetValue { value, range, .. } => value + 1 < range,
                    _ => right,
                });
            "preset-checked-against-multiturn" "The singleturn encoder compares a preset with the range of the multiturn encoder."
                => |d| d.afx60.check(|check, right| match check {
                    Afx60Check::PresetValue { value, revolutions: 1, .. } => value < 1 << 30,
                    _ => right,
                });
            "preset-warning-at-the-write" "A preset value beyond the range is already reported when it is written."
                => |d| preset_warning_at_the_write(d);
            "writing-while-requested-presets" "A preset value written while a preset is requested makes a preset at once."
                => |d| writing_while_requested_presets(d);

            // The vendor record
            "start-preset-ignored" "The preset value of the start is ignored."
                => |d| d.afx60.check(|check, right| right && !matches!(check, Afx60Check::StartPresetValue { .. }));
            "start-preset-always-taken" "The preset value of the start is always used, even if it is not transmitted."
                => |d| d.afx60.check(|check, right| right || matches!(check, Afx60Check::StartPresetValue { .. }));
            "stored-value-before-start-preset" "A stored preset value takes precedence over that of the start."
                => |d| d.afx60.set(Afx60Check::StartPresetValue { is_stored: true }, false);
            "start-preset-locks-value" "P65000 cannot be written if the start has transmitted its value."
                => |d| start_preset_locks_value(d);
            "start-preset-moves-position" "The preset value of the start sets the position."
                => |d| start_preset_moves_position(d);

            // Memory
            "save-leaves-limits" "P971 saves only P65000."
                => |d| d.afx60.set(Afx60Check::Stores(971), false);
            "preset-value-never-stored" "P65000 is lost at power-off, saved or not."
                => |d| d.afx60.at_event(Afx60Event::PowerUp, |_, retained| RetainedVendorData { preset_value: 0, ..retained });
            "auto-save-ignored" "Nothing is stored without P971."
                => |d| d.afx60.check(|check, right| match check {
                    Afx60Check::Stores(1006 | 1007 | 65000) => false,
                    _ => right,
                });
            "interrupted-save-is-mixed" "An interrupted save stores only a part of the data."
                => |d| interrupted_save_is_mixed(d);
            "second-save-spoils-memory" "A save during a save leaves 0 in memory."
                => |d| second_save_spoils_memory(d);

            // Manual reset
            "hand-reset-ignored" "The manual reset has no effect."
                => |d| d.afx60.check(|check, right| right && !matches!(check, Afx60Check::ResetSwitches(_)));
            "hand-reset-without-power-cycle" "The manual reset does not wait for a power cycle."
                => |d| d.afx60.set(Afx60Check::Works { is_reset_due: true }, false);
            "hand-reset-after-any-press" "With the switches at 888 any press of the button prepares the reset."
                => |d| d.afx60.check(|check, right| right || matches!(check, Afx60Check::ResetIsHeld(_)));
            "hand-reset-at-any-switches" "The button prepares the reset with any position of the switches."
                => |d| d.afx60.check(|check, right| right || matches!(check, Afx60Check::ResetSwitches(_)));
            "reset-keeps-limits" "P1006 and P1007 survive a reset."
                => |d| d.afx60.at_event(Afx60Event::Reset, |before, retained| RetainedVendorData { limits: before.limits, ..retained });
            "reset-keeps-round-axis" "Nominator and divisor of the round axis survive a reset."
                => |d| d.afx60.kept(|event, before, mut retained| {
                    match event {
                        Afx60Event::Reset => retained.axis = before.axis,
                        Afx60Event::Start | Afx60Event::PowerUp => {
                            (retained.axis.nominator, retained.axis.divisor) = (before.axis.nominator, before.axis.divisor);
                        }
                        Afx60Event::PowerDown { .. } | Afx60Event::LogReset => {}
                    }
                    retained
                });

            // Station
            "delivered-with-one-name" "Every variant has the same factory name."
                => |d| d.stack.load_station(|_, station| if is_of_delivery(station) { station.name = b"afx60a".to_vec() });
            "delivered-without-a-name" "The factory name is empty."
                => |d| d.stack.load_station(|_, station| if is_of_delivery(station) { station.name.clear() });
        },
    },
    Group {
        needs: &[Need::Profinet],
        deviations: bugs! {
            // Station
            "alarm-acknowledgement-not-taken" "Alarm acknowledgements are ignored, and no further alarm is sent."
                => |d| d.stack.set(StackCheck::Acknowledgement, false);
        },
    },
    Group {
        needs: &[Need::SecondPort],
        deviations: bugs! {
            // Station
            "second-port-missing" "The second port is missing."
                => |d| d.stack.plugs(|plugs| plugs.retain(|plug| plug.subslot != 0x8002));
        },
    },
];

fn preset_warning_at_the_write(d: &mut Deviations) {
    let is_invalid = Rc::new(Cell::new(false));
    let (written, preset, started, lit) =
        (is_invalid.clone(), is_invalid.clone(), is_invalid.clone(), is_invalid.clone());
    d.encoder.written(move |view, (number, _), values| {
        let value = values.iter().flatten().next().filter(|_| number == 65000);
        written.set(written.get() || value.is_some_and(|value| *value >= view.positions));
        values
    });
    d.afx60.check(move |check, right| {
        preset.set(preset.get() && !matches!(check, Afx60Check::PresetValue { .. }));
        right
    });
    d.afx60.kept(move |event, _, retained| {
        started.set(started.get() && !matches!(event, Afx60Event::Start | Afx60Event::PowerUp));
        retained
    });
    d.encoder.element(move |_, at, right| match at {
        (1001, 1) if is_invalid.get() => right | INVALID_PRESET,
        _ => right,
    });
    d.encoder
        .led(move |of, right| if (of.name, right) == ("encoder", "green") && lit.get() { "orange" } else { right });
}

fn writing_while_requested_presets(d: &mut Deviations) {
    let next = next_preset(d);
    d.encoder.written(move |view, (number, _), values| {
        if number == 65000 && view.sensor.request().home {
            next.set(values.iter().flatten().next().copied());
        }
        values
    });
}

fn start_preset_locks_value(d: &mut Deviations) {
    let is_locked = Rc::new(Cell::new(false));
    let (begins, ends) = (is_locked.clone(), is_locked.clone());
    d.afx60.start_record(move |fields| {
        begins.set(fields.transmits == 1);
        fields
    });
    d.afx60.kept(move |event, _, retained| {
        ends.set(ends.get() && !matches!(event, Afx60Event::Start | Afx60Event::PowerUp));
        retained
    });
    d.encoder.written(move |_, (number, _), values| values.filter(|_| number != 65000 || !is_locked.get()));
}

fn start_preset_moves_position(d: &mut Deviations) {
    let next = next_preset(d);
    d.afx60.start_record(move |fields| {
        next.set((fields.transmits == 1).then_some(fields.preset_value.into()));
        fields
    });
}

fn second_save_spoils_memory(d: &mut Deviations) {
    let is_spoiled = Rc::new(Cell::new(false));
    let spoiled = is_spoiled.clone();
    d.encoder.written(move |view, (number, _), values| {
        if number != 971 {
            return values;
        }
        let is_running = view.store.preset_value.deadline().is_some();
        spoiled.set(is_running);
        values.filter(|_| !is_running)
    });
    d.afx60.kept(move |event, _, retained| match event {
        Afx60Event::PowerUp if is_spoiled.get() => RetainedVendorData { preset_value: 0, ..retained },
        _ => retained,
    });
}

/// An interrupted save stores P65000 and nothing else.
fn interrupted_save_is_mixed(d: &mut Deviations) {
    let mut stored = None;
    d.afx60.kept(move |event, before, retained| match event {
        Afx60Event::PowerDown { is_saving } => {
            stored = is_saving.then_some(before.preset_value);
            retained
        }
        Afx60Event::PowerUp => {
            RetainedVendorData { preset_value: stored.take().unwrap_or(retained.preset_value), ..retained }
        }
        _ => retained,
    });
}

/// Bit of S_STAT_B for an invalid preset.
const INVALID_PRESET: u64 = 1 << 4;

fn is_of_delivery(station: &StationData) -> bool {
    station.name == b"afs60a" || station.name == b"afm60a"
}
