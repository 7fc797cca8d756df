//! Where the records of an encoder answer, and what they do to the cyclic exchange.

use crate::profidrive::telegram::Telegram;
use crate::profidrive::user_parameters::UserParameters;
use alloc::vec::Vec;
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
    /// The octets of the operating status in a record of its own, from the right ones and those of the user parameters
    /// that were written last.
    pub status: fn(Vec<u8>, &[u8]) -> Vec<u8>,
    /// Whether the encoder gets into data exchange, from the telegram and whether the start-up had a parameter request.
    pub starts: fn(&Telegram, bool) -> bool,
    /// Whether parameter requests are taken with these user parameters.
    pub takes_requests: fn(&UserParameters) -> bool,
    /// Whether user parameters go with a telegram, from whether class 4 is on.
    pub go_with: fn(&Telegram, bool) -> bool,
}

impl Default for Records {
    fn default() -> Records {
        Records {
            answer_at: |asked, access_point| asked == access_point,
            parameter_access: 0xB02E,
            hold_up: Duration::ZERO,
            status: |octets, _| octets,
            starts: |_, _| true,
            takes_requests: |_| true,
            go_with: |_, _| true,
        }
    }
}
