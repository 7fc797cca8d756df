//! The hooks of an encoder: the seams at which a deviation may change what comes in and what goes out.
//!
//! The encoder itself is plain. Without the feature `deviations` no hook is ever called. Its decisions are in
//! [`checks`](crate::profidrive::checks); steps of arithmetic and handshakes that no seam reaches have traits beside the part that takes them.

use crate::encoder::{Hardware, Measuring, PresetMode, Velocity};
use crate::encoder_object::Store;
use crate::facts::{Facts, Reset, Submodule};
use crate::profidrive::parameters::{Exchange, Parameter};
use crate::profidrive::sensor::{Error, Sensor};
use crate::profidrive::telegram::{Before, Image, Outputs, Telegram};
use crate::profidrive::user_parameters::UserParameters;
use alloc::string::String;
use alloc::vec::Vec;
use core::time::Duration;
use device_stack::profinet::{Access, ArKey, Plug, RecordRefusal, Seen, Severity, StationData};
use station::Time;

/// The hooks of an encoder; each default changes nothing.
#[allow(unused_variables, reason = "the names tell what a seam is about")]
pub trait EncoderHooks {
    /// A connection with cyclic data begins.
    fn starts(&mut self, view: &View<'_>) {}

    /// A connection with cyclic data has ended; the last cycle is still the one before.
    fn ends(&mut self, view: &View<'_>) {}

    /// What the controller sends in one telegram, as it arrives; none of what is bad or missing.
    fn outputs(&mut self, view: &View<'_>, telegram: &Telegram, arrived: Outputs) -> Outputs {
        arrived
    }

    /// The errors whose cause is there now, before the sensor interface raises them.
    fn causes(&mut self, view: &View<'_>, right: Vec<Error>) -> Vec<Error> {
        right
    }

    /// The signals of a frame, from those that are right now and the cycle before.
    fn image(&mut self, view: &View<'_>, before: &Before, now: Image) -> Image {
        now
    }

    /// The submodules that are plugged for a connection that begins.
    fn plugged(&mut self, plugged: Vec<Plug>) -> Vec<Plug> {
        plugged
    }

    /// The octets of inputs that a telegram announces to the stack.
    fn input_octets(&mut self, telegram: &Telegram, right: u16) -> u16 {
        right
    }

    /// The inputs of a submodule before they are sent, from the signals of the frame.
    fn inputs(
        &mut self,
        view: &View<'_>,
        submodule: &Submodule,
        image: &Image,
        right: SubmoduleInputs,
    ) -> SubmoduleInputs {
        right
    }

    /// The octets of a record that is written, before it is taken or refused.
    fn write_record(&mut self, view: &View<'_>, access: &Access, octets: RecordOctets) -> RecordOctets {
        octets
    }

    /// The answer to a record that was read.
    fn read_record(&mut self, view: &View<'_>, access: &Access, octets: RecordOctets) -> RecordOctets {
        octets
    }

    /// The user parameters before they come into force; the view has those before.
    fn user_parameters(&mut self, view: &View<'_>, right: UserParameters) -> UserParameters {
        right
    }

    /// How long it takes from the end of the parameters to the first good data.
    fn ready(&mut self, view: &View<'_>, right: Duration) -> Duration {
        right
    }

    /// The value of an element of a parameter, by the number of the parameter and the place of the element.
    fn element(&mut self, view: &View<'_>, at: (u16, usize), right: u64) -> u64 {
        right
    }

    /// What the working memory holds of a preset, once the requests of a cycle were carried out and before its signals are taken.
    fn held(&mut self, view: &View<'_>, held: Held) -> Held {
        held
    }

    /// A parameter as it is read, after [`element`](EncoderHooks::element).
    fn parameter(&mut self, view: &View<'_>, number: u16, right: Parameter) -> Parameter {
        right
    }

    /// The values that a parameter is given from a subindex on; none are acknowledged and change nothing.
    fn written(&mut self, view: &View<'_>, at: (u16, u16), values: Option<Vec<u64>>) -> Option<Vec<u64>> {
        values
    }

    /// The octets of a parameter request as they arrive from a connection.
    fn parameter_request(&mut self, from: ArKey, octets: Vec<u8>) -> Vec<u8> {
        octets
    }

    /// The octets of a response before it waits for the connection to fetch it.
    fn parameter_response(&mut self, exchange: &Exchange, octets: Vec<u8>) -> Vec<u8> {
        octets
    }

    /// What a connection fetches as the response to its parameter request; none where no response waits for it.
    fn fetched_response(&mut self, by: ArKey, waiting: Option<Vec<u8>>) -> Option<Vec<u8>> {
        waiting
    }

    /// The units by which a preset that G1_STW requests sets or shifts the position.
    fn preset_units(&mut self, view: &View<'_>, mode: PresetMode, right: u64) -> u64 {
        right
    }

    /// The bits of the warnings whose cause is there.
    fn warnings(&mut self, view: &View<'_>, right: u32) -> u32 {
        right
    }

    /// The diagnoses that are reported: error type and severity of each.
    fn diagnoses(&mut self, view: &View<'_>, right: Vec<(u16, Severity)>) -> Vec<(u16, Severity)> {
        right
    }

    /// The supply has come: what is volatile is lost.
    fn powered_up(&mut self) {}

    /// What is about to be written to memory, if anything is.
    fn store(&mut self, view: &View<'_>, write: Option<Write>) -> Option<Write> {
        write
    }

    /// What comes back from memory when the supply comes; nothing of it is in force yet.
    fn load(&mut self, view: &View<'_>, retained: Retained) -> Retained {
        retained
    }

    /// What a factory reset that is to clear this leaves.
    fn reset(&mut self, view: &View<'_>, clears: Reset, left: Retained) -> Retained {
        left
    }

    /// The supply goes.
    fn power_down(&mut self, view: &View<'_>) {}

    /// How often a counter has counted, by its name.
    fn counter(&mut self, name: &str, count: u64) -> u64 {
        count
    }

    /// What an LED shows to who looks at it.
    fn led(&mut self, lit: &Lit<'_>, right: &'static str) -> &'static str {
        right
    }
}

/// The octets of a record, or why it is refused.
pub type RecordOctets = Result<Vec<u8>, RecordRefusal>;

/// The inputs of a submodule.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SubmoduleInputs {
    /// The octets, as many as the signals have; the stack sends as many as were announced.
    pub octets: Vec<u8>,
    /// Whether they are good.
    pub are_good: bool,
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
    /// Whether a connection with cyclic data sends its parameters.
    pub is_starting: bool,
    /// The cycle before; all of it is 0 before the first one of a connection.
    pub before: &'a Before,
    /// Latched errors, oldest first.
    pub errors: &'a [Error],
    /// The submodules with data in use; there is at least one.
    pub submodules: &'a [&'static Submodule],
    /// Whether this connection has brought user parameters.
    pub has_record: bool,
    /// How long this connection has exchanged data; none if it does not.
    pub exchanged_for: Option<Duration>,
    /// The fault bits of the errors that are there.
    pub faults: u32,
    /// The bits of the warnings that are there.
    pub warnings: u32,
    /// How many positions there are, in units.
    pub positions: u64,
    /// The offset of a preset that is being stored.
    pub next_offset: Option<u64>,
    /// The velocity.
    pub velocity: &'a Velocity,
    /// The measuring task.
    pub measuring: &'a Measuring,
    /// The preset value.
    pub preset_value: u32,
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
}

/// What the working memory holds of a preset.
#[derive(Clone, Copy, Debug)]
pub struct Held {
    /// The offset in force.
    pub offset: u64,
    /// The preset value, P65000.
    pub preset_value: u32,
}

/// Something of a preset that is written to memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Write {
    /// The offset of a preset.
    Offset {
        /// The offset.
        offset: u64,
        /// How long it takes.
        takes: Duration,
    },
    /// The preset value, P65000.
    PresetValue {
        /// The value.
        value: u32,
        /// How long it takes.
        takes: Duration,
    },
}

/// What memory retains without power.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Retained {
    /// The offset of all presets.
    pub offset: u64,
    /// The preset value, P65000.
    pub preset_value: u32,
    /// Name and addresses.
    pub station: StationData,
    /// The serial number.
    pub serial_number: String,
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
