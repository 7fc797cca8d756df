//! The node number: DIP A and Set_Slave_Address (manual, 4.8 and 6.8).

use wire::profibus::fdl::UNNAMED;

/// What the node number is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NodeNumber {
    /// Switches 1 to 7 of DIP A as a binary number, the first one the lowest bit (4.8); the eighth is not used.
    pub switches: u8,
    /// The number that the bus has set.
    pub set_by_bus: Option<u8>,
}

impl NodeNumber {
    /// The address: that of the switches, or at 126 the one that the bus has set (6.8).
    pub fn address(&self) -> u8 {
        match self.switches {
            UNNAMED => self.set_by_bus.unwrap_or(UNNAMED),
            address => address,
        }
    }

    /// Whether Set_Slave_Address is served: only with the switches at 126 (6.8).
    pub fn is_left_to_bus(&self) -> bool {
        self.switches == UNNAMED
    }
}
