//! The requests of G1_STW.

use crate::encoder::PresetMode;

/// The requests in G1_STW (chapter 10). A control word that is not valid has none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SensorRequest {
    /// Bit 11, home position mode: the preset is relative.
    pub relative: bool,
    /// Bit 12: a preset is requested.
    pub home: bool,
    /// Bit 13: the position is requested in G1_XIST2.
    pub absolute: bool,
    /// Bit 14: parking is requested.
    pub park: bool,
    /// Bit 15: the acknowledgement of an error is requested.
    pub acknowledge: bool,
}

impl SensorRequest {
    /// The requests in the bits of G1_STW; the other bits have no function.
    pub fn of(g1_stw: u16) -> SensorRequest {
        let bit = |n: u32| g1_stw >> n & 1 != 0;
        SensorRequest { relative: bit(11), home: bit(12), absolute: bit(13), park: bit(14), acknowledge: bit(15) }
    }

    /// The mode of the requested preset.
    pub fn mode(self) -> PresetMode {
        if self.relative { PresetMode::Relative } else { PresetMode::Absolute }
    }
}
