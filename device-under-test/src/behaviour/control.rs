//! Control by PLC, as the status and control words show it.

/// Control by PLC, from whether compatibility mode is on and whether bit 10 of STW2_ENC is set.
#[derive(Clone, Copy, Debug)]
pub struct Control {
    /// Whether G1_STW is obeyed.
    pub is_valid: fn(bool, bool) -> bool,
    /// Whether bit 9 of ZSW2_ENC is set.
    pub is_requested: fn(bool, bool) -> bool,
}

impl Default for Control {
    fn default() -> Control {
        Control {
            is_valid: |compatible, by_plc| compatible || by_plc,
            is_requested: |compatible, by_plc| !compatible && by_plc,
        }
    }
}
