//! Control by PLC: bit 10 of STW2_ENC, and bits 3 and 9 of ZSW2_ENC.

/// Bit 10 of STW2_ENC.
pub const CONTROL_BY_PLC: u16 = 0x0400;

/// What a manual specifies about Control by PLC.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ControlFacts {
    /// Whether G1_STW is valid without Control by PLC in compatibility mode.
    pub optional_in_compatibility: bool,
    /// When bit 9 of ZSW2_ENC, Control requested, is set.
    pub requested: ControlRequested,
    /// Whether a preset request that is already set when Control by PLC is set counts as a new one.
    pub accepts_held_preset: bool,
    /// Whether bit 3 of ZSW2_ENC shows that there is a fault.
    pub shows_fault: bool,
}

/// When bit 9 of ZSW2_ENC, Control requested, is set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ControlRequested {
    /// While Control by PLC is set, without compatibility mode.
    WithControl,
    /// Without compatibility mode.
    WithoutCompatibility,
    /// Always.
    Always,
}

impl ControlFacts {
    /// Control by PLC in the XAC77 manual: chapter 10, STW2_ENC and ZSW2_ENC, and 16.1.
    pub const PROFILE: ControlFacts = ControlFacts {
        optional_in_compatibility: true,
        requested: ControlRequested::WithControl,
        accepts_held_preset: true,
        shows_fault: false,
    };

    /// Whether G1_STW is valid in this compatibility mode and with this Control by PLC.
    pub fn is_valid(&self, compatible: bool, set: bool) -> bool {
        set || compatible && self.optional_in_compatibility
    }

    /// Whether bit 9 of ZSW2_ENC is set in this compatibility mode and with this Control by PLC.
    pub fn is_requested(&self, compatible: bool, set: bool) -> bool {
        match self.requested {
            ControlRequested::WithControl => !compatible && set,
            ControlRequested::WithoutCompatibility => !compatible,
            ControlRequested::Always => true,
        }
    }
}
