//! Bugs of presets and of the memory of their offset.

use super::diagnosis::{extend, patch};
use super::offset_state::{
    LateWrites, OffsetAtStandstill, OffsetPerClass, OffsetShownFromRam, OldOffset, OldShaftPosition,
    RestoredShaftPosition,
};
use super::preset_state::{
    BeyondTheRange, EarlyOutputs, OnePresetOnly, RepeatedOutputs, SetByParameters, TotalTriggerCycles,
    UndoneWithTrigger, UnusedRange, WithoutTrigger,
};
use super::values::{position, set_position};
use crate::tables::Deviation;
use core::time::Duration;
use encoder_profile::encoder::CountingDirection;
use reference_devices::models::datalogic_amt58::hooks::NewOffset;
use reference_devices::models::datalogic_amt58::preset::{TRIGGER, VALUE};

/// The bugs of presets.
pub static BUGS: &[Deviation] = bugs! {
    // Cycles and trigger
    "preset-in-the-first-cycle" "The preset is made in the first cycle with bit 31, and the answer already has the value."
        => |d| d.amt58.preset_cycles(|cycles, _| cycles == 1);
    "preset-in-the-second-cycle" "The preset is made in the second consecutive cycle with bit 31."
        => |d| d.amt58.preset_cycles(|cycles, _| cycles == 2);
    "preset-in-the-fourth-cycle" "The preset is made only in the fourth consecutive cycle with bit 31."
        => |d| d.amt58.preset_cycles(|cycles, _| cycles == 4);
    "preset-count-not-reset" "A cycle without bit 31 does not reset the count of cycles; the three cycles need not be consecutive."
        => |d| d.amt58.add(TotalTriggerCycles::default());
    "preset-undone-with-its-bit" "When bit 31 is cleared, the offset from before the preset is restored."
        => |d| d.amt58.add(UndoneWithTrigger::default());
    "value-without-trigger" "A new value in the outputs sets the position although bit 31 is 0."
        => |d| d.amt58.add(WithoutTrigger::default());
    "preset-mixes-telegrams" "The upper half of the preset value is taken from the second cycle and the lower half from the third."
        => |d| {
            let mut before = 0;
            d.amt58.outputs(move |_, outputs| {
                let upper = core::mem::replace(&mut before, outputs) & VALUE & 0xFFFF_0000;
                outputs & (TRIGGER | 0xFFFF) | upper
            });
        };
    "preset-trigger-in-last-byte" "The preset is triggered by the highest bit of the fourth output byte, and the value is read in reverse byte order."
        => |d| d.amt58.outputs(|_, outputs| outputs.swap_bytes());
    "outputs-taken-before-exchange" "Outputs before the data exchange are refused, but they count as cycles and make a preset."
        => |d| {
            let early = EarlyOutputs::default();
            d.slave.add(early.clone());
            d.amt58.add(early);
        };
    "outputs-held-after-loss" "After a watchdog timeout the last outputs are retained, and their preset is repeated at the next data exchange."
        => |d| {
            let repeated = RepeatedOutputs::default();
            d.slave.add(repeated.clone());
            d.amt58.add(repeated);
        };
    "preset-from-byte-20" "With byte 20 at FFh Set_Prm makes a preset to 0."
        => |d| d.amt58.add(SetByParameters::default());

    // Values
    "preset-of-16-bits" "Only the lower 16 bits of the preset value are used."
        => |d| d.amt58.outputs(|_, outputs| outputs & (TRIGGER | 0xFFFF));
    "zero-is-no-preset" "A preset to 0 is not carried out."
        => |d| d.amt58.preset_value(|_, value, right| right && value > 0);
    "highest-preset-is-invalid" "A preset to the highest position of the range is treated as invalid and not carried out."
        => |d| d.amt58.preset_value(|view, value, right| right && value + 1 < view.measuring.range());
    "preset-limit-one-too-high" "A preset to the value of the range is carried out, and the position is then equal to the range."
        => |d| {
            d.amt58.preset_value(|view, value, right| right || value == view.measuring.range());
            d.amt58.inputs(|view, inputs| if position(inputs) == 0 && view.offset > 0 {
                set_position(inputs, view.measuring.range() as u32);
            });
        };
    "preset-beyond-the-range-shown" "A preset value at or beyond the range is carried out, and the position is shown as it was sent."
        => |d| d.amt58.add(BeyondTheRange::default());
    "preset-checked-against-unused-range" "With scaling off the preset value is compared with the total resolution of Set_Prm."
        => |d| d.amt58.add(UnusedRange::default());
    "preset-needs-class-2" "In Class 1 no preset is made."
        => |d| d.amt58.preset_value(|view, _, right| right && view.parameters.is_class_2);
    "preset-refused-in-motion" "A preset is not carried out while the shaft turns."
        => |d| d.amt58.preset_value(|view, _, right| right && !view.shaft.is_moving(view.now));
    "only-first-preset" "After power-up only the first preset is carried out."
        => |d| d.amt58.add(OnePresetOnly::default());
    "trigger-counts-as-value" "Bit 31 of the outputs is part of the preset value, and is set in the position."
        => |d| d.amt58.inputs(|view, inputs| if view.offset != 0 {
            set_position(inputs, position(inputs) | TRIGGER);
        });

    // The offset
    "offset-only-at-standstill" "The offset is lost as soon as the shaft moves."
        => |d| d.amt58.add(OffsetAtStandstill::default());
    "position-not-reduced" "The sum of position and offset is not reduced to the range."
        => |d| d.measuring.shift(|position, offset, _| position + offset);
    "preset-from-old-place" "The offset is computed from the position of the shaft 50 ms before the third cycle."
        => |d| d.amt58.add(OldShaftPosition::default());
    "old-offset-added-again" "After a Set_Prm with another scaling the first preset adds the previous offset to its own."
        => |d| d.amt58.add(OldOffset::default());
    "offset-negated-when-counterclockwise" "With code sequence 1 the offset is subtracted instead of added."
        => |d| d.amt58.inputs(|view, inputs| if view.parameters.direction == CountingDirection::Counterclockwise {
            let range = view.measuring.range().max(1) as i64;
            set_position(inputs, (view.measuring.position() as i64 - view.offset).rem_euclid(range) as u32);
        });
    "offset-never-shown" "The offset in the extended diagnosis is always 0; the position is right."
        => |d| extend(d, |_, octets| patch(octets, 31, &[0; 4]));
    "set-prm-clears-offset" "Each Set_Prm clears the preset offset."
        => |d| d.amt58.offset(|_, cause, offset| if cause == NewOffset::SetPrm { 0 } else { offset });
    "offset-per-class" "Each class has a separate offset."
        => |d| d.amt58.add(OffsetPerClass::default());

    // Memory
    "preset-stored-late" "The offset of a preset is written to the memory 10 s after the preset."
        => |d| d.amt58.add(LateWrites::after(Duration::from_secs(10)));
    "offset-only-in-ram" "The offset of a preset is never stored."
        => |d| d.amt58.store(|_, _| None);
    "offset-shown-from-ram" "After power-up the diagnosis shows an offset of 0 until the next preset; the position is right."
        => |d| d.amt58.add(OffsetShownFromRam::default());
    "position-restored-from-memory" "After power-up the position is the one before power-off, wherever the shaft is."
        => |d| d.amt58.add(RestoredShaftPosition::default());
};
