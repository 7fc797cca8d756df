//! The two LEDs (manual, 4.9).

use super::program::Program;
use device_stack::profibus::{Seen, State};

/// What the LEDs show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lamps {
    /// The red one: fault.
    pub red: &'static str,
    /// The green one: power.
    pub green: &'static str,
}

/// What the LEDs show it from.
#[derive(Clone, Copy, Debug)]
pub struct Situation {
    /// What the slave knows.
    pub seen: Seen,
    /// Whether the memory could not be read.
    pub is_unreadable: bool,
    /// Whether the watchdog ended the last exchange.
    pub has_expired: bool,
    /// For how many milliseconds that has been so.
    pub expired_for: u64,
    /// Whether the last parameters were wrong.
    pub is_invalid: bool,
    /// Whether parameters were wrong since power-up.
    pub was_invalid: bool,
    /// Whether the wrong parameters have a number of revolutions that is no power of two.
    pub is_invalid_with_zone: bool,
    /// Whether the shaft is in the red zone.
    pub is_in_zone: bool,
    /// The program in force.
    pub program: Program,
    /// Whether its scaling has a red zone.
    pub has_zone: bool,
    /// Whether the hardware has several revolutions.
    pub is_multiturn: bool,
}

/// No supply.
pub const DARK: Lamps = Lamps { red: "dark", green: "dark" };
/// Data are exchanged.
pub const GOOD: Lamps = Lamps { red: "dark", green: "green" };
/// The shaft is in the red zone.
pub const ZONE: Lamps = Lamps { red: "dark", green: "green_flashing" };
/// The parameters are wrong.
pub const INVALID: Lamps = Lamps { red: "red", green: "green_flashing" };
/// The watchdog has expired.
pub const TIME_OUT: Lamps = Lamps { red: "red", green: "dark" };
/// There is no communication.
pub const NO_BUS: Lamps = Lamps { red: "red_flashing", green: "green" };
/// The memory is broken.
pub const MEMORY: Lamps = Lamps { red: "red_flashing", green: "green_flashing" };

/// What the LEDs show.
pub fn lamps(of: &Situation) -> Lamps {
    let exchanges = of.seen.state == State::DataExchange && of.seen.is_linked;
    if !of.seen.has_supply {
        DARK
    } else if of.is_unreadable {
        MEMORY
    } else if of.has_expired {
        TIME_OUT
    } else if of.is_invalid {
        INVALID
    } else if !exchanges {
        NO_BUS
    } else if of.is_in_zone {
        ZONE
    } else {
        GOOD
    }
}
