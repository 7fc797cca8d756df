//! What goes to memory, and when.

use crate::encoder::PresetMode;
use crate::encoder::memory::Outcome;
use crate::profidrive::sensor::Request;
use core::time::Duration;
use device_stack::profinet::StationData;

/// What goes to memory, and when.
#[derive(Clone, Copy, Debug)]
pub struct Memory {
    /// Whether a preset of this mode stores its offset.
    pub stores_offset: fn(PresetMode) -> bool,
    /// How long a preset takes, from how long it should.
    pub preset_takes: fn(Duration) -> Duration,
    /// The offset of a preset that begins before another one is carried out, from that of the other, its own and the
    /// position without offset.
    pub preset_during_preset: fn(u64, u64, u64) -> u64,
    /// Whether a preset is carried out, from the way in which the last one of this connection was asked for and this one is;
    /// `true` is by G1_STW.
    pub heeds: fn(Option<bool>, bool) -> bool,
    /// Whether P65000 is 0 after a preset.
    pub uses_up_preset_value: bool,
    /// Whether the offset is stored again in a frame with these requests.
    pub stores_in_frame: fn(Request) -> bool,
    /// Whether a preset is carried out when its offset is stored, and not before.
    pub waits_for_store: bool,
    /// Whether a preset whose offset could not be stored is given up.
    pub heeds_failure: bool,
    /// Whether P65000 is stored whenever it is written.
    pub stores_every_write: bool,
    /// Whether a preset takes P65000 as it is stored, and not as it is.
    pub presets_stored_value: bool,
    /// Whether a save begins, from how many there were since power-up and whether one is running.
    pub begins_save: fn(u32, bool) -> bool,
    /// Whether P971 still reads 1 after a save that ended so.
    pub stays_after_save: fn(Outcome) -> bool,
    /// Whether a save by P971 stores the offset of the last power-up again.
    pub save_restores_offset: bool,
    /// What is stored of name and addresses, from what was set.
    pub stores_station: fn(StationData) -> StationData,
    /// What the encoder begins with after power-up.
    pub at_power_up: fn(&mut PowerUp),
    /// P65000 after power-up, from what is stored.
    pub preset_value_begins: fn(u32) -> u32,
    /// Whether a memory that cannot be read at power-up is a fault.
    pub reports_unreadable: bool,
    /// Whether a memory that was never written is a fault.
    pub reports_empty: bool,
}

/// What an encoder finds after power-up, and what it begins with.
#[derive(Clone, Copy, Debug)]
pub struct PowerUp {
    /// Whether P971 has ever saved.
    pub was_saved: bool,
    /// Whether the encoder was parked when the power went.
    pub was_parked: bool,
    /// The offset with which the position would be the one before.
    pub offset_as_before: u64,
    /// The offset of a preset with P65000 as it is stored.
    pub offset_of_preset_value: u64,
    /// The offset in memory.
    pub stored_offset: u64,
    /// The offset in force.
    pub offset: u64,
    /// Whether P971 reads 1.
    pub is_saving: bool,
    /// Whether the encoder is parked until parking is requested and taken back.
    pub is_parked: bool,
}

impl Default for Memory {
    fn default() -> Memory {
        Memory {
            stores_offset: |_| true,
            preset_takes: |right| right,
            preset_during_preset: |_, new, _| new,
            heeds: |_, _| true,
            uses_up_preset_value: false,
            stores_in_frame: |_| false,
            waits_for_store: true,
            heeds_failure: true,
            stores_every_write: false,
            presets_stored_value: false,
            begins_save: |_, _| true,
            stays_after_save: |outcome| outcome == Outcome::Failed,
            save_restores_offset: false,
            stores_station: |station| station,
            at_power_up: |_| {},
            preset_value_begins: |stored| stored,
            reports_unreadable: true,
            reports_empty: false,
        }
    }
}
