//! Bugs of non-volatile memory.

use super::Deviation;
use super::start::first_record;
use device_stack::profinet::StationData;
use encoder_profile::encoder::PresetMode;

/// The bugs of this seam.
pub static BUGS: &[Deviation] = encoder_bugs! {
    // Offset
    "offset-only-in-ram" "The offset is lost at power-off."
        => |b| b.memory.stores_offset = |_| false;
    "relative-preset-not-stored" "The offset of a relative preset is lost at power-off."
        => |b| b.memory.stores_offset = |mode| mode == PresetMode::Absolute;
    "preset-acknowledged-before-stored" "The preset is acknowledged while the offset is still being written."
        => |b| b.memory.waits_for_store = false;
    "memory-error-swallowed" "A preset whose offset could not be stored is acknowledged."
        => |b| b.memory.heeds_failure = false;
    "offset-used-up" "The first power-up takes the offset out of the memory."
        => |b| b.memory.at_power_up = |begin| begin.stored_offset = 0;
    "offset-from-preset-value" "Power-up makes the offset anew from P65000 as it is stored."
        => |b| b.memory.at_power_up = |begin| begin.offset = begin.offset_of_preset_value;
    "position-restored-from-memory" "After power-up the position is the one before, wherever the shaft is."
        => |b| b.memory.at_power_up = |begin| begin.offset = begin.offset_as_before;

    // P65000 and P971
    "every-write-is-stored" "P65000 goes to memory without P971."
        => |b| b.memory.stores_every_write = true;
    "p971-takes-any-value" "Any value written to P971 starts a save."
        => |b| b.at_encoder.value(971, |_| 1);
    "p971-confirms-too-early" "P971 reads 0 before the save is done."
        => |b| b.at_encoder.element(|_, at, right| if at == (971, 0) { 0 } else { right });
    "p971-is-stored" "P971 reads 1 after power-up once it was written."
        => |b| b.memory.at_power_up = |begin| begin.is_saving = begin.was_saved;
    "save-never-ends" "P971 reads 1 for ever once it was written."
        => |b| b.memory.stays_after_save = |_| true;
    "failed-save-confirmed" "P971 reads 0 after a save that failed."
        => |b| b.memory.stays_after_save = |_| false;
    "only-first-save" "Only the first save after power-up has an effect."
        => |b| b.memory.begins_save = |before, _| before == 0;
    "save-during-save-lost" "A save that is asked for while another one runs is acknowledged and not done."
        => |b| b.memory.begins_save = |_, is_running| !is_running;
    "save-restores-old-offset" "P971 stores the offset of the last power-up again."
        => |b| b.memory.save_restores_offset = true;

    // Others
    "scaling-remembered" "The first record 0xBF00 stays in force for good, over a power cycle too."
        => |b| b.start.understand(first_record(Default::default()));
    "parking-survives-power-off" "An encoder that was parked when the power went is parked after power-up."
        => |b| b.memory.at_power_up = |begin| begin.is_parked = begin.was_parked;
    "name-lost-at-power-off" "The station name is lost at power-off."
        => |b| b.memory.stores_station = |station| StationData { name: [].into(), ..station };
    "address-lost-at-power-off" "The IP address is lost at power-off."
        => |b| b.memory.stores_station = |station| StationData { name: station.name, ..StationData::default() };
    "memory-fault-ignored-at-power-up" "A memory that cannot be read at power-up is taken for an empty one."
        => |b| b.memory.reports_unreadable = false;
    "empty-memory-is-a-fault" "A memory in which nothing was ever stored is a fault."
        => |b| b.memory.reports_empty = true;
};
