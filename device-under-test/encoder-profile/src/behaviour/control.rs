//! Control by PLC, as the status and control words show it.

use crate::profidrive::sensor::Request;

/// What is known about Control by PLC at one frame.
#[derive(Clone, Copy, Debug)]
pub struct ByPlc {
    /// Whether compatibility mode is on.
    pub compatible: bool,
    /// Whether bit 10 of STW2_ENC was set in the frame before.
    pub before: bool,
    /// Whether it is set in this one.
    pub now: bool,
    /// Whether it was set before the outputs were bad that have been good again for less than a second.
    pub was_set: bool,
}

/// What Control by PLC decides.
#[derive(Clone, Copy, Debug)]
pub struct Control {
    /// Whether G1_STW is obeyed.
    pub is_valid: fn(ByPlc) -> bool,
    /// Whether bit 9 of ZSW2_ENC is set.
    pub is_requested: fn(ByPlc) -> bool,
    /// Whether bit 3 of ZSW2_ENC is set, from the fault bits of the errors that are there.
    pub fault_present: fn(u32) -> bool,
    /// Whether a request of G1_STW that is held when Control by PLC comes counts as a new one.
    pub takes_held: bool,
    /// Whether a request to acknowledge that is held when Control by PLC comes counts as a new one, where others do not.
    pub takes_held_acknowledgement: bool,
    /// The requests that are answered while G1_STW is not obeyed, from those answered before.
    pub when_void: fn(Request) -> Request,
}

impl Default for Control {
    fn default() -> Control {
        Control {
            is_valid: |by_plc| by_plc.compatible || by_plc.now,
            is_requested: |by_plc| !by_plc.compatible && by_plc.now,
            fault_present: |_| false,
            takes_held: true,
            takes_held_acknowledgement: false,
            when_void: |_| Request::default(),
        }
    }
}
