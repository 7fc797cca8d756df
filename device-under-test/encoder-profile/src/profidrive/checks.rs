//! The yes-or-no decisions of an encoder, which a deviation may flip. All of them go through one call.

use crate::encoder::Hardware;
use crate::profidrive::sensor::SensorRequest;
use crate::profidrive::telegram::InputSignal;
use crate::profidrive::user_parameters::UserParameterData;
use device_stack::Attached;
use wire::profidrive::{Attribute, ParameterFormat};

/// A decision of an encoder and its subject. Each comment says what `true` means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EncoderCheck {
    /// The position is frozen now, as it may be while a preset is stored.
    PositionIsFrozen,
    /// A parameter request for this axis or drive object is answered.
    Axis(u8),
    /// A parameter has this attribute.
    Attribute(Attribute),
    /// A parameter can be written.
    Writable {
        number: u16,
        /// The element; `None` for the whole parameter.
        element: Option<u16>,
    },
    /// A parameter may be accessed with this number of elements, including 0.
    ElementCount {
        count: u8,
        /// Whether the parameter has elements.
        has_elements: bool,
    },
    /// A parameter that is no array may be accessed with this number of elements and this subindex.
    WholeValue {
        /// The number of elements, at least 1.
        count: usize,
        subindex: u16,
    },
    /// An array has the accessed elements.
    Elements {
        /// The subindex after the last accessed element.
        end: usize,
        /// The number of elements of the array.
        length: usize,
    },
    /// A write request has the right number of values for a parameter.
    ValueCount {
        /// The number of values.
        values: usize,
        /// The number of accessed elements.
        elements: usize,
    },
    /// This number of parameters, which the format permits, is served in one request.
    ParameterCount(usize),
    /// Values of this format can be written.
    KnownFormat(ParameterFormat),
    /// A value of this format may be written to a parameter of that format.
    ValueFormat {
        /// The format of the value.
        format: ParameterFormat,
        /// The format of the parameter.
        parameter: ParameterFormat,
    },
    /// A write request may have this number of bytes after its last value.
    SurplusOctets(usize),
    /// A value of this number of bytes still fits into a response.
    ValueFits(usize),
    /// A preset value may be written.
    PresetValue {
        value: u32,
        /// The number of positions.
        range: u64,
    },
    /// Diagnoses are reported with these user parameters.
    AlarmChannel {
        /// Whether compatibility mode is on.
        compatible: bool,
        /// Whether the alarm channel is on.
        is_on: bool,
    },
    /// This speed in revolutions per minute is too high.
    TooFast(i64),
    /// A record is served at this API, slot and subslot.
    RecordAnswersAt(u32, u16, u16),
    /// The record of this index is the parameter access.
    IsParameterAccess(u16),
    /// A start without user parameters is no error.
    StartsWithoutRecord,
    /// User parameters may be written during data exchange.
    RecordInExchange,
    /// User parameters take effect as soon as they are written.
    RecordActsAtOnce,
    /// These user parameters are valid with the telegram of this number.
    UserParametersAreRight(UserParameterData, u16),
    /// The hardware supports the scaling of these user parameters.
    ScalingIsServed(UserParameterData, Hardware),
    /// A velocity unit of this number exists.
    VelocityUnitExists(u8),
    /// The number of tolerated sign-of-life failures is valid.
    ToleranceIsRight(UserParameterData),
    /// The scaling of these user parameters is applied.
    ScalingActs(UserParameterData),
    /// The code sequence of these user parameters is applied.
    CodeSequenceActs(UserParameterData),
    /// Presets and their offset are applied with these user parameters.
    PresetsAct(UserParameterData),
    /// Positions saturate at the last value of their range, with these user parameters.
    PositionSaturates(UserParameterData),
    /// A preset acts on this position signal, with these user parameters.
    PresetActsOn(InputSignal, UserParameterData),
    /// The velocity is calculated, with these user parameters.
    VelocityIsMeasured(UserParameterData),
    /// G1_STW is valid.
    ControlByPlc {
        /// Whether compatibility mode is on.
        compatible: bool,
        /// Whether bit 10 of STW2_ENC is set.
        set: bool,
    },
    /// Bit 9 of ZSW2_ENC, Control requested, is set.
    RequestsControl {
        /// Whether compatibility mode is on.
        compatible: bool,
        /// Whether bit 10 of STW2_ENC is set.
        set: bool,
    },
    /// A preset is started by G1_STW.
    BeginsPreset {
        /// The requests of the previous cycle.
        before: SensorRequest,
        /// The requests of this cycle.
        now: SensorRequest,
        /// Whether the encoder is parked.
        parked: bool,
    },
    /// A preset by G1_STW is acknowledged by bit 12 of G1_ZSW.
    AnswersPreset {
        /// Whether it was carried out.
        carried_out: bool,
        /// Whether its request is still held.
        requested: bool,
        /// Whether the encoder is parked.
        parked: bool,
    },
    /// A preset is carried out and not blocked.
    CarriesOutPreset {
        /// `true`: requested by G1_STW. `false`: by the trigger bit of a preset word.
        by_request: bool,
        /// Whether there is an error.
        has_error: bool,
    },
    /// A preset is started by the trigger bit of a preset word.
    TriggersPreset {
        /// The previous word; `None` before the first one of a connection.
        before: Option<u32>,
        /// The current word.
        now: u32,
    },
    /// The encoder parks on a new request.
    Parks {
        /// Whether the shaft turns.
        moving: bool,
        /// Whether there is an error.
        has_error: bool,
    },
    /// Parking clears the errors.
    ParkingClearsErrors,
    /// An error whose cause is present is raised.
    RaisesError {
        /// The code of the error, if it has one.
        code: Option<u16>,
        /// Whether the encoder is parked.
        parked: bool,
    },
    /// An error whose cause has gone stays latched.
    LatchesError {
        /// The code of the error, if it has one.
        code: Option<u16>,
    },
    /// Requests to acknowledge errors are answered.
    Acknowledges {
        /// Whether the encoder is parked.
        parked: bool,
    },
    /// An acknowledgement clears an error.
    ClearsError {
        /// The code of the error, if it has one.
        code: Option<u16>,
        /// Whether the cause is still present.
        persists: bool,
    },
    /// The sign of life of the controller is monitored.
    MonitorsController {
        /// Whether bit 10 of STW2_ENC, Control by PLC, is set.
        has_control: bool,
        /// Whether the encoder is parked.
        parked: bool,
    },
    /// Monitoring starts with this sign of life.
    StartsMonitoring {
        /// The sign of life.
        sign: u8,
    },
    /// A sign of life is the successor of the previous one.
    FollowsLifeSign {
        /// The previous sign of life.
        last: u8,
        /// The current sign of life.
        sign: u8,
        /// Whether the tolerated number of failures was exceeded.
        has_failed: bool,
    },
    /// A pending preset takes effect now.
    PresetTakesEffect,
    /// A preset counts as carried out; normally it does if its offset could be stored.
    PresetIsCarriedOut,
    /// A supply voltage of this many millivolts suffices.
    SupplySuffices(u64),
    /// A factory reset is carried out.
    FactoryReset {
        /// Whether a connection exchanges data or is being set up.
        is_connected: bool,
    },
}

/// Flips decisions. The default keeps those of the manual.
#[allow(unused_variables, reason = "the names document the hook")]
pub trait EncoderChecks {
    /// Replaces a decision of the encoder, which is `verdict`.
    fn check(&mut self, check: EncoderCheck, verdict: bool) -> bool {
        verdict
    }
}

/// The checks that are attached to the parts of an encoder.
#[derive(Clone, Debug, Default)]
pub struct AttachedChecks(pub Attached<dyn EncoderChecks>);

impl AttachedChecks {
    /// Returns `verdict`, unless a deviation flips it.
    #[inline(always)]
    pub fn check(&self, check: EncoderCheck, verdict: bool) -> bool {
        self.0.apply(verdict, |hooks, verdict| hooks.check(check, verdict))
    }
}
