//! What goes to memory, and when.

/// What goes to memory, and when.
#[derive(Clone, Copy, Debug)]
pub struct Memory {
    /// Whether a preset stores its offset.
    pub stores_offset: bool,
    /// Whether a preset is carried out when its offset is stored, and not before.
    pub waits_for_store: bool,
    /// Whether a preset whose offset could not be stored is given up.
    pub heeds_failure: bool,
    /// Whether P65000 is stored whenever it is written.
    pub stores_every_write: bool,
    /// Whether a preset takes P65000 as it is stored, and not as it is.
    pub presets_stored_value: bool,
    /// Whether a save comes to an end.
    pub ends_save: bool,
    /// Whether the station name is stored.
    pub stores_name: bool,
    /// Whether the user parameters survive a loss of power.
    pub keeps_user_parameters: bool,
    /// Whether the position after power-up is the one before, wherever the shaft is.
    pub keeps_position: bool,
    /// Whether a memory that cannot be read at power-up is a fault.
    pub reports_unreadable: bool,
}

impl Default for Memory {
    fn default() -> Memory {
        Memory {
            stores_offset: true,
            waits_for_store: true,
            heeds_failure: true,
            stores_every_write: false,
            presets_stored_value: false,
            ends_save: true,
            stores_name: true,
            keeps_user_parameters: false,
            keeps_position: false,
            reports_unreadable: true,
        }
    }
}
