//! Where the records of an encoder answer, and what they do to the cyclic exchange.

use crate::profidrive::telegram::Telegram;
use core::time::Duration;

/// API, slot and subslot.
type Place = (u32, u16, u16);

/// Records of the encoder object.
#[derive(Clone, Copy, Debug)]
pub struct Records {
    /// Whether they answer at a place, from the place and where the parameter access point is.
    pub answer_at: fn(Place, Place) -> bool,
    /// Index of the parameter access.
    pub parameter_access: u16,
    /// For how long a parameter request holds up the signals of the telegram.
    pub hold_up: Duration,
    /// Whether user parameters go with a telegram, from whether class 4 is on.
    pub go_with: fn(&Telegram, bool) -> bool,
}

impl Default for Records {
    fn default() -> Records {
        Records {
            answer_at: |asked, access_point| asked == access_point,
            parameter_access: 0xB02E,
            hold_up: Duration::ZERO,
            go_with: |_, _| true,
        }
    }
}
