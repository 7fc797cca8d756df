//! The hooks of an encoder: the seams at which a deviation may change what comes in and what goes out.
//!
//! The encoder itself is plain. Without the feature `deviations` no hook is ever called. Its decisions are in
//! [`checks`](crate::checks); steps of arithmetic and handshakes that no seam reaches have traits beside the part that takes them.

use crate::encoder::{Hardware, Measuring};
use crate::encoder_object::Store;
use crate::facts::Facts;
use crate::profidrive::sensor::{Error, Sensor};
use crate::profidrive::telegram::{Before, Image, Outputs, Telegram};
use crate::profidrive::user_parameters::UserParameters;
use alloc::vec::Vec;
use core::time::Duration;
use device_stack::profinet::{Seen, StationData};
use station::Time;

/// The hooks of an encoder; each default changes nothing.
#[allow(unused_variables, reason = "the names tell what a seam is about")]
pub trait EncoderHooks {
    /// What the controller sends in one telegram, as it arrives; none of what is bad or missing.
    fn outputs(&mut self, view: &View<'_>, telegram: &Telegram, arrived: Outputs) -> Outputs {
        arrived
    }

    /// The errors whose cause is there now, before the sensor interface raises them.
    fn causes(&mut self, view: &View<'_>, right: Vec<Error>) -> Vec<Error> {
        right
    }

    /// The signals of a frame, from those that are right now and the cycle before.
    fn image(&mut self, before: &Before, now: Image) -> Image {
        now
    }

    /// The value of an element of a parameter, by the number of the parameter and the place of the element.
    fn element(&mut self, view: &View<'_>, at: (u16, usize), right: u64) -> u64 {
        right
    }

    /// What the working memory holds of a preset, once the requests of a cycle were carried out and before its signals are taken.
    fn held(&mut self, view: &View<'_>, held: Held) -> Held {
        held
    }

    /// What an LED shows to who looks at it.
    fn led(&mut self, lit: &Lit<'_>, right: &'static str) -> &'static str {
        right
    }
}

/// The encoder as it is when a hook is called.
pub struct View<'a> {
    /// Now.
    pub now: Time,
    /// What the manual says.
    pub facts: &'static Facts,
    /// What the sensor tells apart.
    pub hardware: Hardware,
    /// What that of another encoder of the manual tells apart; the same if there is no other.
    pub other: Hardware,
    /// The user parameters in force.
    pub user: &'a UserParameters,
    /// The cycle before; all of it is 0 before the first one of a connection.
    pub before: &'a Before,
    /// Latched errors, oldest first.
    pub errors: &'a [Error],
    /// The fault bits of the errors that are there.
    pub faults: u32,
    /// The measuring task.
    pub measuring: &'a Measuring,
    /// The preset value.
    pub preset_value: u32,
    /// The offset that was in memory at power-up.
    pub offset_at_power_up: u64,
    /// The sensor interface.
    pub sensor: &'a Sensor,
    /// What was taken from the controller.
    pub outputs: &'a Outputs,
    /// What is stored.
    pub store: &'a Store,
    /// Since when data are exchanged, if they are.
    pub data_since: Option<Time>,
    /// Name and addresses in use.
    pub station: &'a StationData,
    /// The IP address before the last assignment.
    pub address_before: [u8; 4],
}

/// What the working memory holds of a preset.
#[derive(Clone, Copy, Debug)]
pub struct Held {
    /// The offset in force.
    pub offset: u64,
    /// The preset value, P65000.
    pub preset_value: u32,
}

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
}
