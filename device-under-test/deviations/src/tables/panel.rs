//! Bugs of what hands and the vendor's record of a start do: button, switches, save mode, preset value of the start.

use super::Deviation;
use core::time::Duration;
use device_stack::profinet::{StackCheck, StationData};

/// The bugs of this seam.
pub static BUGS: &[Deviation] = bugs! {
    // Presets
    "button-without-class-4-presets" "The button makes a preset although class 4 is off."
        => |b| b.sick.button_needs_class_4 = false;
    "button-presets-to-zero" "The button sets the position to 0."
        => |b| b.sick.button = |_| Some(0);
    "button-ignored" "The button makes no preset."
        => |b| b.sick.button = |_| None;
    "preset-range-not-checked" "A preset beyond the range is carried out and not told."
        => |b| b.afx60.takes_preset = |_, _, _| true;
    "highest-preset-is-invalid" "A preset to the highest position is taken for invalid."
        => |b| b.afx60.takes_preset = |value, range, _| value + 1 < range;
    "preset-checked-against-multiturn" "The singleturn encoder checks a preset against all steps of the multiturn encoder."
        => |b| b.afx60.takes_preset = |value, range, hardware| value < if hardware.revolutions == 1 { 1 << 30 } else { range };
    "preset-warning-at-the-write" "A preset value beyond the range is told when it is written."
        => |b| b.afx60.warns_at_the_write = true;
    "writing-while-requested-presets" "A preset value that is written while a preset is requested is taken at once."
        => |b| b.afx60.presets_while_requested = true;

    // The record of the start
    "start-preset-ignored" "The preset value of the start is not taken."
        => |b| b.afx60.start_preset = |_, _, _| None;
    "start-preset-always-taken" "The preset value of the start is taken whether it is transmitted or not."
        => |b| b.afx60.start_preset = |_, _, value| Some(value);
    "stored-value-before-start-preset" "A preset value that is stored goes before that of the start."
        => |b| b.afx60.start_preset = |transmits, is_stored, value| (transmits && !is_stored).then_some(value);
    "start-preset-locks-value" "P65000 takes nothing while the start transmits its value."
        => |b| b.afx60.start_locks = true;
    "start-preset-moves-position" "The preset value of the start sets the position."
        => |b| b.afx60.start_presets = true;

    // Memory
    "save-leaves-limits" "P971 saves P65000 alone."
        => |b| b.afx60.saves_limits = false;
    "preset-value-never-stored" "P65000 is lost at power-off, saved or not."
        => |b| b.afx60.stores_preset_value = false;
    "auto-save-ignored" "Nothing is stored without P971."
        => |b| b.afx60.saves_by_itself = false;
    "interrupted-save-is-mixed" "A save that is interrupted has stored a part."
        => |b| b.afx60.save_is_torn = true;
    "second-save-spoils-memory" "A save during a save leaves 0 in memory."
        => |b| b.afx60.second_save_spoils = true;

    // Reset by hand
    "hand-reset-ignored" "There is no reset by hand."
        => |b| b.afx60.asks_for_reset = |_| false;
    "hand-reset-without-power-cycle" "The reset by hand does not wait for a power cycle."
        => |b| b.afx60.resets_at_once = true;
    "hand-reset-after-any-press" "At 888 any press of the button prepares the reset."
        => |b| b.afx60.reset_takes = |_| Duration::ZERO;
    "hand-reset-at-any-switches" "The button prepares the reset wherever the switches stand."
        => |b| b.afx60.asks_for_reset = |_| true;
    "reset-keeps-limits" "P1006 and P1007 survive a reset."
        => |b| b.afx60.reset_keeps_limits = true;
    "reset-keeps-round-axis" "Nominator and divisor of the round axis survive a reset."
        => |b| b.sick.axis_survives = true;

    // Station
    "delivered-with-one-name" "Every variant is delivered with the same name."
        => |d| d.stack.load_station(|_, station| if is_of_delivery(station) { station.name = b"afx60a".to_vec() });
    "delivered-without-a-name" "An encoder is delivered without a name."
        => |d| d.stack.load_station(|_, station| if is_of_delivery(station) { station.name.clear() });
    "alarm-acknowledgement-not-taken" "The acknowledgement of an alarm is not taken, and no other alarm is sent."
        => |d| d.stack.set(StackCheck::Acknowledgement, false);
    "second-port-missing" "There is no second port."
        => |d| d.stack.plugs(|plugs| plugs.retain(|plug| plug.subslot != 0x8002));
};

fn is_of_delivery(station: &StationData) -> bool {
    station.name == b"afs60a" || station.name == b"afm60a"
}
