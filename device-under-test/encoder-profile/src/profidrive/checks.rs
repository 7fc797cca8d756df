//! The decisions of an encoder that a deviation may flip: every yes or no about what it is asked for goes through one call.

use crate::encoder::Hardware;
use crate::profidrive::sensor::Request;
use crate::profidrive::telegram::Signal;
use crate::profidrive::user_parameters::UserParameters;
use device_stack::Attached;
use wire::profidrive::{Attribute, Format};

/// A decision of an encoder, with what it is about; the comment says what `true` means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Check {
    /// Whether the position stands still now, as it may while a preset is being stored.
    PositionStandsStill,
    /// Whether a parameter request for this axis or drive object is answered.
    Axis(u8),
    /// Whether a parameter has this attribute.
    Attribute(Attribute),
    /// Whether a parameter can be written.
    Writable {
        /// Its number.
        number: u16,
        /// The element that it is about; none for the parameter as a whole.
        element: Option<u16>,
    },
    /// Whether a parameter may be accessed with this number of elements, 0 included.
    ElementCount {
        /// The number of elements.
        count: u8,
        /// Whether the parameter consists of elements at all.
        has_elements: bool,
    },
    /// Whether a parameter that is no array may be accessed with this number of elements and this subindex.
    WholeValue {
        /// The number of elements, at least 1.
        count: usize,
        /// The subindex.
        subindex: u16,
    },
    /// Whether an array has the elements that are accessed.
    Elements {
        /// The subindex after the last of them.
        end: usize,
        /// How many elements the array has.
        there: usize,
    },
    /// Whether a write request brings the right number of values for a parameter.
    ValueCount {
        /// The number of values.
        values: usize,
        /// The number of elements that are accessed.
        of: usize,
    },
    /// Whether this is a format of values that can be written at all.
    KnownFormat(Format),
    /// Whether a value of this format may be written to a parameter.
    ValueFormat {
        /// The format of the value.
        format: Format,
        /// The format of the parameter.
        parameter: Format,
    },
    /// Whether a write request may have this number of octets after its last value.
    SurplusOctets(usize),
    /// Whether a value of this number of octets still fits into a response.
    ValueFits(usize),
    /// Whether a preset value may be written.
    PresetValue {
        /// The value.
        value: u32,
        /// The number of positions that it has to fit.
        range: u64,
    },
    /// Whether diagnoses are reported with these user parameters.
    AlarmChannel {
        /// Whether compatibility mode is on.
        compatible: bool,
        /// Whether the alarm channel is on.
        is_on: bool,
    },
    /// Whether this speed in revolutions per minute is too high.
    TooFast(i64),
    /// Whether a record answers at this API, slot and subslot.
    RecordAnswersAt(u32, u16, u16),
    /// Whether the record of this index is the parameter access.
    IsParameterAccess(u16),
    /// Whether a start without user parameters is no error.
    StartsWithoutRecord,
    /// Whether user parameters are in force as soon as they are written.
    RecordActsAtOnce,
    /// Whether these user parameters can be served with the telegram of this number.
    UserParametersAreRight(UserParameters, u16),
    /// Whether the hardware can serve the scaling of these user parameters.
    ScalingIsServed(UserParameters, Hardware),
    /// Whether there is a velocity unit of this number.
    VelocityUnitExists(u8),
    /// Whether the tolerated failures of the sign of life are allowed.
    ToleranceIsRight(UserParameters),
    /// Whether the scaling of these user parameters is in force.
    ScalingActs(UserParameters),
    /// Whether the code sequence of these user parameters is in force.
    CodeSequenceActs(UserParameters),
    /// Whether presets and their offset are in force with these user parameters.
    PresetsAct(UserParameters),
    /// Whether positions stand at the last value of their range beyond it, with these user parameters.
    PositionStands(UserParameters),
    /// Whether a preset acts on this position signal, with these user parameters.
    PresetActsOn(Signal, UserParameters),
    /// Whether the velocity is calculated, with these user parameters.
    VelocityIsMeasured(UserParameters),
    /// G1_STW counts, from compatibility mode and Control by PLC.
    ControlByPlc {
        /// Whether compatibility mode is on.
        compatible: bool,
        /// Whether bit 10 of STW2_ENC is set.
        set: bool,
    },
    /// Control by PLC is requested: bit 9 of ZSW2_ENC is set.
    RequestsControl {
        /// Whether compatibility mode is on.
        compatible: bool,
        /// Whether bit 10 of STW2_ENC is set.
        set: bool,
    },
    /// A preset begins by G1_STW.
    BeginsPreset {
        /// The requests of the cycle before.
        before: Request,
        /// The requests of this cycle.
        now: Request,
        /// Whether the encoder is parked.
        parked: bool,
    },
    /// A preset by G1_STW is answered by bit 12 of G1_ZSW.
    AnswersPreset {
        /// Whether it was carried out.
        carried_out: bool,
        /// Whether its request is still held.
        requested: bool,
        /// Whether the encoder is parked.
        parked: bool,
    },
    /// A preset is carried out, or else it is blocked.
    CarriesOutPreset {
        /// Whether G1_STW requests it, and not the trigger of a word that carries its value.
        by_request: bool,
        /// Whether there is an error.
        has_error: bool,
    },
    /// A preset begins by the trigger of a word that carries its value.
    TriggersPreset {
        /// The word before; none before the first one of a connection.
        before: Option<u32>,
        /// The word now.
        now: u32,
    },
    /// The encoder parks with a new request.
    Parks {
        /// Whether the shaft turns.
        moving: bool,
        /// Whether there is an error.
        has_error: bool,
    },
    /// Parking clears the errors.
    ParkingClearsErrors,
    /// The error of this code is raised, whose cause is there.
    RaisesError {
        /// The code of the error, if it has one.
        code: Option<u16>,
        /// Whether the encoder is parked.
        parked: bool,
    },
    /// The error of this code stays, whose cause has gone.
    LatchesError {
        /// The code of the error, if it has one.
        code: Option<u16>,
    },
    /// Requests to acknowledge errors are answered.
    Acknowledges {
        /// Whether the encoder is parked.
        parked: bool,
    },
    /// An acknowledgement clears the error of this code.
    ClearsError {
        /// The code of the error, if it has one.
        code: Option<u16>,
        /// Whether its cause is still there.
        persists: bool,
    },
    /// The sign of life of the controller is watched.
    WatchesController {
        /// Whether bit 10 of STW2_ENC, Control by PLC, is set.
        has_control: bool,
        /// Whether the encoder is parked.
        parked: bool,
    },
    /// The watch begins with this sign of life.
    BeginsToWatch {
        /// The sign of life.
        sign: u8,
    },
    /// The second of two signs of life follows the first.
    FollowsLifeSign {
        /// The sign of life before.
        last: u8,
        /// The sign of life now.
        sign: u8,
        /// Whether there were more failures than are tolerated.
        has_failed: bool,
    },
    /// A preset that waits for its offset to be stored takes effect now.
    PresetTakesEffect,
    /// A preset counts as carried out, as it does if its offset could be stored.
    PresetIsCarriedOut,
    /// A factory reset is carried out.
    FactoryReset {
        /// Whether a connection exchanges data or is being set up.
        is_connected: bool,
    },
}

/// Flips decisions; the default leaves them as the manual has them.
#[allow(unused_variables, reason = "the names say what a hook is given")]
pub trait EncoderChecks {
    /// The decision that counts, from what it is about and the decision of the manual.
    fn check(&mut self, check: Check, verdict: bool) -> bool {
        verdict
    }
}

/// The checks that are attached to the parts of an encoder.
#[derive(Clone, Debug, Default)]
pub struct Checks(pub Attached<dyn EncoderChecks>);

impl Checks {
    /// The decision that counts: `verdict`, unless a deviation flips it.
    #[inline(always)]
    pub fn check(&self, check: Check, verdict: bool) -> bool {
        self.0.apply(verdict, |hooks, verdict| hooks.check(check, verdict))
    }
}
