//! The node number: DIP A and Set_Slave_Address (manual, 4.8 and 6.8).

use wire::profibus::fdl::UNNAMED;

/// The sources of the node number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NodeNumber {
    /// Switches 1 to 7 of DIP A as a binary number, the first one the lowest bit (4.8); the eighth is not used.
    pub switches: u8,
    /// The number set by Set_Slave_Address, if any.
    pub set_by_bus: Option<u8>,
}

impl NodeNumber {
    /// Returns the address of the switches, or at 126 the one that the bus has set (6.8).
    pub fn address(&self) -> u8 {
        match self.switches {
            UNNAMED => self.set_by_bus.unwrap_or(UNNAMED),
            address => address,
        }
    }

    /// Returns whether Set_Slave_Address is accepted: only with the switches at 126 (6.8).
    pub fn is_left_to_bus(&self) -> bool {
        self.switches == UNNAMED
    }
}
