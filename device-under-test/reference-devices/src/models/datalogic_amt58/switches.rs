//! The switches of the node number (manual, 4.8 and 6.8).

use super::knobs::Switches;
use wire::profibus::fdl::UNNAMED;

/// The address: that of the switches, or at 126 the one that the bus has given.
pub fn address(switches: Switches) -> u8 {
    match switches.address {
        UNNAMED => switches.given.unwrap_or(UNNAMED),
        address => address,
    }
}

/// Whether the bus may give an address: only with the switches at 126.
pub fn takes_address(switches: Switches) -> bool {
    switches.address == UNNAMED
}
