//! The hooks of an encoder: the seams at which a deviation may change incoming and outgoing data.
//!
//! The encoder itself conforms. Without the feature `deviations` no hook is called. Its decisions are in
//! [`checks`](crate::profidrive::checks). Steps of computations and handshakes that no seam reaches have their own
//! traits, next to the code that takes the step.

use crate::encoder::{Hardware, Measuring, PresetMode, Velocity};
use crate::encoder_object::NonVolatileData;
use crate::facts::{ClearedData, ManualFacts, SubmoduleFacts};
use crate::profidrive::parameters::{ParameterContent, ParameterExchange};
use crate::profidrive::sensor::{Sensor, SensorError};
use crate::profidrive::telegram::{OutputValues, PreviousCycle, SignalImage, Telegram};
use crate::profidrive::user_parameters::UserParameterData;
use alloc::string::String;
use alloc::vec::Vec;
use core::time::Duration;
use device_stack::profinet::{
    ArKey, DiagnosisSeverity, PluggableSubmodule, RecordAccess, RecordRefusal, StackStatus, StationData,
};
use station::Time;

/// The hooks of an encoder; each default changes nothing.
#[allow(unused_variables, reason = "the names document the hook")]
pub trait EncoderHooks {
    /// A connection with cyclic data begins.
    fn starts(&mut self, view: &EncoderView<'_>) {}

    /// A connection with cyclic data has ended. The view still has its last cycle.
    fn ends(&mut self, view: &EncoderView<'_>) {}

    /// Changes the outputs that arrive with one telegram. Fields are `None` while they are bad or missing.
    fn outputs(&mut self, view: &EncoderView<'_>, telegram: &Telegram, arrived: OutputValues) -> OutputValues {
        arrived
    }

    /// Changes the errors whose cause is present, before the sensor interface raises them.
    fn causes(&mut self, view: &EncoderView<'_>, right: Vec<SensorError>) -> Vec<SensorError> {
        right
    }

    /// Changes the signals of a frame. `previous` is the previous cycle.
    fn image(&mut self, view: &EncoderView<'_>, before: &PreviousCycle, now: SignalImage) -> SignalImage {
        now
    }

    /// Changes the submodules that are plugged for a new connection.
    fn plugged(&mut self, plugged: Vec<PluggableSubmodule>) -> Vec<PluggableSubmodule> {
        plugged
    }

    /// Changes the input length in bytes that is reported to the stack.
    fn input_octets(&mut self, telegram: &Telegram, right: u16) -> u16 {
        right
    }

    /// Changes the inputs of a submodule before they are sent.
    fn inputs(
        &mut self,
        view: &EncoderView<'_>,
        submodule: &SubmoduleFacts,
        image: &SignalImage,
        right: SubmoduleInputs,
    ) -> SubmoduleInputs {
        right
    }

    /// Changes the data of a record write before the encoder checks it.
    fn write_record(&mut self, view: &EncoderView<'_>, access: &RecordAccess, octets: RecordOctets) -> RecordOctets {
        octets
    }

    /// Changes the answer to a record read.
    fn read_record(&mut self, view: &EncoderView<'_>, access: &RecordAccess, octets: RecordOctets) -> RecordOctets {
        octets
    }

    /// Changes the user parameters before they take effect. The view still has the previous ones.
    fn user_parameters(&mut self, view: &EncoderView<'_>, right: UserParameterData) -> UserParameterData {
        right
    }

    /// Changes the time from PrmEnd to the first good data.
    fn ready(&mut self, view: &EncoderView<'_>, right: Duration) -> Duration {
        right
    }

    /// Changes the value of an element of a parameter. `at` is parameter number and element index.
    fn element(&mut self, view: &EncoderView<'_>, at: (u16, usize), right: u64) -> u64 {
        right
    }

    /// Changes offset and preset value in working memory, after the requests of a cycle and before its signals.
    fn working_preset(&mut self, view: &EncoderView<'_>, held: WorkingPreset) -> WorkingPreset {
        held
    }

    /// Changes a parameter that is read, after [`element`](EncoderHooks::element).
    fn parameter(&mut self, view: &EncoderView<'_>, number: u16, right: ParameterContent) -> ParameterContent {
        right
    }

    /// Changes the values written to a parameter. `at` is parameter number and first subindex. With `None` the write
    /// is acknowledged and has no effect.
    fn written(&mut self, view: &EncoderView<'_>, at: (u16, u16), values: Option<Vec<u64>>) -> Option<Vec<u64>> {
        values
    }

    /// Changes the bytes of a received parameter request.
    fn parameter_request(&mut self, from: ArKey, octets: Vec<u8>) -> Vec<u8> {
        octets
    }

    /// Changes the bytes of a parameter response before it is stored for the connection.
    fn parameter_response(&mut self, exchange: &ParameterExchange, octets: Vec<u8>) -> Vec<u8> {
        octets
    }

    /// Changes the parameter response that a connection fetches; `None` if there is none.
    fn fetched_response(&mut self, by: ArKey, waiting: Option<Vec<u8>>) -> Option<Vec<u8>> {
        waiting
    }

    /// Changes the position, or the shift, of a preset requested by G1_STW, in units.
    fn preset_units(&mut self, view: &EncoderView<'_>, mode: PresetMode, right: u64) -> u64 {
        right
    }

    /// Changes the warning bits.
    fn warnings(&mut self, view: &EncoderView<'_>, right: u32) -> u32 {
        right
    }

    /// Changes the reported diagnoses: ChannelErrorType and severity of each.
    fn diagnoses(
        &mut self,
        view: &EncoderView<'_>,
        right: Vec<(u16, DiagnosisSeverity)>,
    ) -> Vec<(u16, DiagnosisSeverity)> {
        right
    }

    /// The supply was switched on: drop volatile state.
    fn powered_up(&mut self) {}

    /// Changes or drops a write to memory.
    fn store(&mut self, view: &EncoderView<'_>, write: Option<MemoryWrite>) -> Option<MemoryWrite> {
        write
    }

    /// Changes the data loaded from memory at power-up, before they take effect.
    fn load(&mut self, view: &EncoderView<'_>, retained: RetainedEncoderData) -> RetainedEncoderData {
        retained
    }

    /// Changes the data that remain after a factory reset. `clears` is what the reset must clear.
    fn reset(&mut self, view: &EncoderView<'_>, clears: ClearedData, left: RetainedEncoderData) -> RetainedEncoderData {
        left
    }

    /// The supply fails.
    fn power_down(&mut self, view: &EncoderView<'_>) {}

    /// Changes the value of a counter.
    fn counter(&mut self, name: &str, count: u64) -> u64 {
        count
    }

    /// Changes what an LED shows.
    fn led(&mut self, lit: &LedInput<'_>, right: &'static str) -> &'static str {
        right
    }
}

/// The data of a record, or the refusal.
pub type RecordOctets = Result<Vec<u8>, RecordRefusal>;

/// The inputs of a submodule.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SubmoduleInputs {
    /// The bytes of the signals. The frame has the length that was reported to the stack.
    pub octets: Vec<u8>,
    /// Whether the inputs are good (IOPS).
    pub are_good: bool,
}

/// The state of the encoder when a hook is called.
pub struct EncoderView<'a> {
    pub now: Time,
    pub facts: &'static ManualFacts,
    pub hardware: Hardware,
    /// The hardware of another variant of the manual; the same if there is no other.
    pub other_hardware: Hardware,
    /// The user parameters in force.
    pub user: &'a UserParameterData,
    /// Whether a connection with cyclic data is in start-up and sends its parameters.
    pub is_starting: bool,
    /// The previous cycle; all 0 before the first cycle of a connection.
    pub previous: &'a PreviousCycle,
    /// Latched errors, oldest first.
    pub errors: &'a [SensorError],
    /// The submodules with data in use; there is at least one.
    pub submodules: &'a [&'static SubmoduleFacts],
    /// Whether this connection has written user parameters.
    pub has_record: bool,
    /// Time since the begin of data exchange; `None` without data exchange.
    pub exchanged_for: Option<Duration>,
    /// The fault bits of the present errors.
    pub faults: u32,
    /// The bits of the present warnings.
    pub warnings: u32,
    /// Number of positions, in units.
    pub positions: u64,
    /// The offset of a preset that is being stored.
    pub next_offset: Option<u64>,
    pub velocity: &'a Velocity,
    pub measuring: &'a Measuring,
    /// The preset value, P65000.
    pub preset_value: u32,
    pub sensor: &'a Sensor,
    /// The outputs in use.
    pub outputs: &'a OutputValues,
    /// The stored data.
    pub store: &'a NonVolatileData,
    /// When data exchange began; `None` without data exchange.
    pub data_since: Option<Time>,
    /// Name and addresses in use.
    pub station: &'a StationData,
}

/// Offset and preset value in working memory.
#[derive(Clone, Copy, Debug)]
pub struct WorkingPreset {
    /// The offset in force.
    pub offset: u64,
    /// The preset value, P65000.
    pub preset_value: u32,
}

/// A write to memory that a preset causes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MemoryWrite {
    /// The offset of a preset; the write takes `takes`.
    Offset { offset: u64, takes: Duration },
    /// The preset value, P65000; the write takes `takes`.
    PresetValue { value: u32, takes: Duration },
}

/// The data that memory retains without power.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RetainedEncoderData {
    /// The offset of all presets.
    pub offset: u64,
    /// The preset value, P65000.
    pub preset_value: u32,
    /// Name and addresses.
    pub station: StationData,
    /// The serial number.
    pub serial_number: String,
}

/// The state that LEDs show.
#[derive(Clone, Copy, Debug)]
pub struct LedInput<'a> {
    /// Name of the LED.
    pub name: &'a str,
    /// The state of the stack.
    pub stack: &'a StackStatus,
    /// The fault bits of the present errors.
    pub faults: u32,
    /// Whether the user parameters are invalid or missing.
    pub has_wrong_parameters: bool,
    /// Whether the connection has written user parameters.
    pub has_record: bool,
    /// Whether there was a warning since power-up.
    pub had_warning: bool,
    /// Time since the begin of data exchange; `None` without data exchange.
    pub exchanged_for: Option<Duration>,
    /// Whether there are valid outputs.
    pub has_outputs: bool,
}
