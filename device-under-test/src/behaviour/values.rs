//! What single parameters say.

use crate::encoder::Hardware;

/// Values of single parameters.
#[derive(Clone, Copy, Debug)]
pub struct Values {
    /// What P922 says of the telegram in use.
    pub telegram: fn(u16) -> u16,
    /// The version in P965, from whether compatibility mode is on.
    pub profile_version: fn(bool) -> u8,
    /// The vendor in P964 and P975.
    pub vendor: fn(u16) -> u16,
    /// The hardware that P979 describes.
    pub sensor_format: fn(Hardware) -> Hardware,
    /// How many of its numbers P980 lists.
    pub listed: usize,
    /// The operating status in P65001.
    pub operating_status: fn(u8) -> u8,
    /// The offset in P65001, from the offset and the range.
    pub offset: fn(u64, u64) -> u64,
    /// The fault word in P65001.
    pub faults: fn(u32) -> u32,
    /// Whether a value starts a save when it is written to P971; none if it is refused.
    pub saves: fn(u64) -> Option<bool>,
    /// Whether P971 stays at 1 until the save is done.
    pub save_is_shown: bool,
    /// What P65000 becomes when it is written.
    pub preset_value: fn(u32) -> u32,
    /// Whether writing P65000 carries out a preset.
    pub preset_value_presets: bool,
}

impl Default for Values {
    fn default() -> Values {
        Values {
            telegram: |number| number,
            profile_version: |compatible| if compatible { 31 } else { 41 },
            vendor: |vendor| vendor,
            sensor_format: |hardware| hardware,
            listed: usize::MAX,
            operating_status: |bits| bits,
            offset: |offset, _| offset,
            faults: |faults| faults,
            saves: |value| (value <= 1).then_some(value == 1),
            save_is_shown: true,
            preset_value: |value| value,
            preset_value_presets: false,
        }
    }
}
