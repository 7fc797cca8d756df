//! What a factory reset does.

use crate::facts::Reset as Cleared;
use device_stack::profinet::{Identity, StationData};

/// What a factory reset does; it clears everything that was set, if healthy, whenever it comes.
#[derive(Clone, Copy, Debug)]
pub struct Reset {
    /// What is cleared, from what should be.
    pub clears: fn(Cleared) -> Cleared,
    /// The preset value P65000 afterwards, from the one before.
    pub preset_value: fn(u32) -> u32,
    /// The offset afterwards, from the one before.
    pub offset: fn(u64) -> u64,
    /// Name and addresses afterwards, from those before.
    pub station: fn(&StationData) -> StationData,
    /// What happens to the identification data.
    pub identity: fn(&mut Identity),
    /// Whether the reset is refused, from whether a connection exchanges data.
    pub is_refused: fn(bool) -> bool,
    /// Whether name and addresses are still cleared after a power cycle.
    pub lasts: bool,
}

impl Default for Reset {
    fn default() -> Reset {
        Reset {
            clears: |right| right,
            preset_value: |_| 0,
            offset: |_| 0,
            station: |_| StationData::default(),
            identity: |_| {},
            is_refused: |_| false,
            lasts: true,
        }
    }
}
