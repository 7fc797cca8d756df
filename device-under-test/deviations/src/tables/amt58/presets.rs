//! Bugs of presets and of the memory that keeps them.

use crate::tables::Deviation;
use crate::tables::slave_memory::KeepsOutputs;
use core::time::Duration;
use encoder_profile::encoder::Direction;
use reference_devices::models::datalogic_amt58::knobs::Storing;
use reference_devices::models::datalogic_amt58::preset::{
    CYCLES, Order, TRIGGER, Trigger, VALUE, order, ordered_after, taken,
};
use reference_devices::models::datalogic_amt58::program::LAST;
use reference_devices::models::datalogic_amt58::told::{Shown, inputs};

/// The bugs of this seam.
pub static BUGS: &[Deviation] = bugs! {
    // Which cycles
    "preset-in-the-first-cycle" "The preset is made at the first cycle with bit 31, and its answer carries the value."
        => |b| b.amt58.order = |trigger, outputs, _| ordered_after(1, trigger, outputs);
    "preset-in-the-second-cycle" "The preset is made at the second cycle in a row with bit 31."
        => |b| b.amt58.order = |trigger, outputs, _| ordered_after(2, trigger, outputs);
    "preset-in-the-fourth-cycle" "The preset is made at the fourth cycle in a row with bit 31 only."
        => |b| b.amt58.order = |trigger, outputs, _| ordered_after(4, trigger, outputs);
    "preset-count-not-reset" "A cycle without bit 31 does not begin the count of the three cycles anew; they need not be in a row."
        => |b| b.amt58.order = |trigger, outputs, _| counted_without_a_row(trigger, outputs);
    "preset-undone-with-its-bit" "When bit 31 falls the offset goes back to what it was before the preset."
        => |b| b.amt58.order = |trigger, outputs, _| match trigger.count >= CYCLES && outputs & TRIGGER == 0 {
            true => {
                trigger.count = 0;
                Order::Undo
            }
            false => order(trigger, outputs),
        };
    "preset-repeats-while-requested" "While bit 31 stays, the preset is made again every third cycle."
        => |b| b.amt58.order = |trigger, outputs, _| match order(trigger, outputs) {
            Order::Nothing if trigger.count > 0 && trigger.count % CYCLES == 0 => Order::Preset(outputs & VALUE),
            order => order,
        };
    "value-without-trigger" "Another value of the output sets the position although bit 31 is 0."
        => |b| b.amt58.order = |trigger, outputs, _| match order(trigger, outputs) {
            Order::Nothing if outputs & TRIGGER == 0 && outputs & VALUE != trigger.before & VALUE => Order::Preset(outputs),
            order => order,
        };
    "preset-mixes-telegrams" "The upper half of the preset value is that of the second cycle and the lower half that of the third."
        => |b| b.amt58.order = |trigger, outputs, _| match order(trigger, outputs) {
            Order::Preset(value) => Order::Preset(trigger.before & VALUE & 0xFFFF_0000 | value & 0xFFFF),
            order => order,
        };
    "preset-trigger-in-last-octet" "The preset is triggered by the highest bit of the fourth output octet, and the value is read in the opposite order."
        => |b| b.amt58.outputs = u32::from_le_bytes;
    "outputs-taken-before-exchange" "Outputs that come before the data exchange are refused, yet they count as cycles and make a preset."
        => |b| b.amt58.outputs_before_exchange_count = true;
    "outputs-held-after-loss" "When the watchdog has expired the last outputs stay, and their preset is made once more when data are exchanged again."
        => |b| {
            b.slave.add(KeepsOutputs::default());
            b.amt58.keeps_outputs = true;
        };
    "preset-from-octet-20" "With octet 20 at FFh Set_Prm makes a preset to 0."
        => |b| b.amt58.preset_at_start = |program| (program.octets[LAST] == 0xFF).then_some(0);

    // Which values
    "preset-of-16-bits" "Of the preset value the lower 16 bits only are taken."
        => |b| b.amt58.takes_preset = |wanted| Some(u64::from(wanted.value & 0xFFFF)).filter(|value| *value < wanted.range);
    "zero-is-no-preset" "A preset to 0 is not carried out."
        => |b| b.amt58.takes_preset = |wanted| taken(wanted).filter(|value| *value > 0);
    "highest-preset-is-invalid" "A preset to the highest position of the range is taken for invalid, so that the position stays."
        => |b| b.amt58.takes_preset = |wanted| taken(wanted).filter(|value| value + 1 < wanted.range);
    "preset-limit-one-too-high" "A preset to the value of the range itself is carried out, and the position then is the range itself."
        => |b| {
            b.amt58.takes_preset = |wanted| Some(u64::from(wanted.value)).filter(|value| *value <= wanted.range);
            b.amt58.inputs = range_itself;
        };
    "preset-range-not-checked" "A preset to a value at or beyond the range is carried out with the value reduced to the range."
        => |b| b.amt58.takes_preset = |wanted| Some(u64::from(wanted.value) % wanted.range);
    "preset-checked-against-hardware" "With scaling on the preset value is compared with the total hardware resolution; what is between is carried out reduced."
        => |b| b.amt58.takes_preset = |wanted| {
            Some(u64::from(wanted.value)).filter(|value| *value < wanted.hardware.range()).map(|value| value % wanted.range)
        };
    "preset-checked-against-unused-range" "With scaling off the preset value is still compared with the total resolution of Set_Prm."
        => |b| b.amt58.takes_preset = |wanted| {
            taken(wanted).filter(|value| wanted.program.scales || *value < wanted.program.sent.range)
        };
    "preset-needs-class-2" "In Class 1 no preset is made."
        => |b| b.amt58.takes_preset = |wanted| taken(wanted).filter(|_| wanted.program.is_class_2);
    "preset-refused-in-motion" "A preset is not carried out while the shaft turns."
        => |b| b.amt58.takes_preset = |wanted| taken(wanted).filter(|_| !wanted.is_moving);
    "only-first-preset" "After power-up only the first preset is carried out."
        => |b| b.amt58.takes_preset = |wanted| taken(wanted).filter(|_| wanted.presets == 0);
    "trigger-counts-as-value" "Bit 31 of the output counts as part of the preset value too, and the position begins with it."
        => |b| b.amt58.inputs = |shown, octets| {
            let trigger = if shown.offset == 0 { 0 } else { TRIGGER };
            inputs(&Shown { position: shown.position | trigger, ..*shown }, octets);
        };

    // The offset
    "offset-only-at-standstill" "The offset is gone as soon as the shaft moves."
        => |b| b.amt58.acts = |offset, has_moved, _| if has_moved { 0 } else { offset };
    "position-not-reduced" "The sum of position and offset is not reduced to the range."
        => |b| b.measuring.shift(|position, offset, _| position + offset);
    "preset-from-old-place" "The offset is computed from the place of the shaft 50 ms before the third cycle."
        => |b| b.amt58.preset_delay = Duration::from_millis(50);
    "old-offset-added-again" "After Set_Prm with another scaling the first preset adds the offset that was there before to that of its own."
        => |b| b.amt58.offset = |right, before, is_first| if is_first { right + before } else { right };
    "offset-negated-when-counterclockwise" "With code sequence 1 the offset is subtracted instead of added."
        => |b| b.amt58.acts = |offset, _, program| match program.direction {
            Direction::Clockwise => offset,
            Direction::Counterclockwise => -offset,
        };
    "offset-never-shown" "The offset in the extended diagnosis is 0 whatever was preset; the position is right."
        => |b| b.amt58.shown_offset = |_, _| 0;
    "set-prm-clears-offset" "Each Set_Prm clears the offset of the presets."
        => |b| b.amt58.offset_at_start = |_| 0;
    "offset-per-class" "Each class has an offset of its own."
        => |b| b.amt58.offset_per_class = true;

    // Memory
    "preset-stored-late" "The offset of a preset is written to the memory 10 s after the preset."
        => |b| b.amt58.storing = Storing::After(Duration::from_secs(10));
    "offset-only-in-ram" "The offset of a preset is never stored."
        => |b| b.amt58.storing = Storing::Never;
    "offset-shown-from-ram" "After power-up the diagnosis tells an offset of 0 until the next preset; the position is right."
        => |b| b.amt58.shown_offset = |offset, presets| if presets == 0 { 0 } else { offset };
    "position-restored-from-memory" "After power-up the position is the one before, wherever the shaft is."
        => |b| b.amt58.at_power_up = |found| (found.offset, -found.moved);
};

/// Counts cycles with the bit, wherever there are others in between.
fn counted_without_a_row(trigger: &mut Trigger, outputs: u32) -> Order {
    match (outputs & TRIGGER != 0, trigger.count) {
        (false, CYCLES..) => trigger.count = 0,
        (false, _) => {}
        (true, count) => trigger.count = count.saturating_add(1),
    }
    match outputs & TRIGGER != 0 && trigger.count == CYCLES {
        true => Order::Preset(outputs & VALUE),
        false => Order::Nothing,
    }
}

/// Shows the range in the place of 0 where a preset to the range has led to it.
fn range_itself(shown: &Shown<'_>, octets: &mut [u8]) {
    let range = shown.program.scaling.range;
    let position = if shown.position == 0 && shown.offset > 0 { range as u32 } else { shown.position };
    inputs(&Shown { position, ..*shown }, octets);
}
