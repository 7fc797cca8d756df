//! What LEDs show.

use core::time::Duration;
use device_stack::profinet::Seen;

/// What an LED could show.
#[derive(Clone, Copy, Debug)]
pub struct Lit<'a> {
    /// Its name.
    pub name: &'a str,
    /// What the stack knows.
    pub seen: &'a Seen,
    /// The fault bits of the errors that are there.
    pub faults: u32,
    /// Whether the user parameters are wrong or missing.
    pub has_wrong_parameters: bool,
    /// Whether the connection has brought user parameters.
    pub has_record: bool,
    /// Whether there was a warning since power-up.
    pub had_warning: bool,
    /// How long this connection has exchanged data; none if it does not.
    pub exchanged_for: Option<Duration>,
    /// Whether there are outputs that count.
    pub has_outputs: bool,
    /// What it shows if it is healthy.
    pub right: &'static str,
}
