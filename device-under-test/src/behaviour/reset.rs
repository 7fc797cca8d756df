//! What a factory reset leaves alone.

/// What a factory reset leaves alone; nothing, if healthy, whenever it comes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reset {
    /// The preset value P65000.
    pub keeps_preset_value: bool,
    /// The offset.
    pub keeps_offset: bool,
    /// The station name.
    pub keeps_name: bool,
    /// The gateway.
    pub keeps_gateway: bool,
    /// Everything while a connection exchanges data, where the reset is refused.
    pub refused_while_connected: bool,
}
