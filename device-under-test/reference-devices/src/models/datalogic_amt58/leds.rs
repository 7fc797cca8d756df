//! The two LEDs of the connection cap (manual, 4.9).

use device_stack::profibus::{DpState, SlaveStatus};

/// What the LEDs show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Leds {
    /// The red LED, Fault.
    pub fault: &'static str,
    /// The green LED, Power.
    pub power: &'static str,
}

/// What the LEDs depend on.
#[derive(Clone, Copy, Debug)]
pub struct Situation {
    /// Power supply, cable and state of the slave.
    pub status: SlaveStatus,
    /// Whether the memory could not be read at power-up.
    pub is_unreadable: bool,
    /// Whether the watchdog ended the last data exchange.
    pub has_expired: bool,
    /// Whether the last parameters were wrong.
    pub is_invalid: bool,
    /// Whether the shaft is in the red zone.
    pub is_in_zone: bool,
}

/// No power supply.
pub const NO_SUPPLY: Leds = Leds { fault: "dark", power: "dark" };
/// Correct operation.
pub const OPERATION: Leds = Leds { fault: "dark", power: "green" };
/// The shaft is in the red zone.
pub const RED_ZONE: Leds = Leds { fault: "dark", power: "green_flashing" };
/// The configuration parameters are not valid.
pub const INVALID_PARAMETERS: Leds = Leds { fault: "red", power: "green_flashing" };
/// Transmission time-out.
pub const TIME_OUT: Leds = Leds { fault: "red", power: "dark" };
/// Bus communication failure.
pub const BUS_FAILURE: Leds = Leds { fault: "red_flashing", power: "green" };
/// Flash memory error.
pub const MEMORY_ERROR: Leds = Leds { fault: "red_flashing", power: "green_flashing" };

/// Returns what the LEDs show by the table of 4.9. The precedence of its lines is invented.
pub fn leds(of: &Situation) -> Leds {
    let exchanges = of.status.state == DpState::DataExchange && of.status.is_linked;
    if !of.status.has_supply {
        NO_SUPPLY
    } else if of.is_unreadable {
        MEMORY_ERROR
    } else if of.has_expired {
        TIME_OUT
    } else if of.is_invalid {
        INVALID_PARAMETERS
    } else if !exchanges {
        BUS_FAILURE
    } else if of.is_in_zone {
        RED_ZONE
    } else {
        OPERATION
    }
}
