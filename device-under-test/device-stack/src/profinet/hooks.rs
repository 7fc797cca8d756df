//! The hooks of a PROFINET stack: the seams at which a deviation may change what comes in and what goes out, and the checks it may
//! flip.
//!
//! The stack itself is plain. Without the feature `deviations` no hook is ever called.

use crate::attached::Attached;
use crate::profinet::{Access, Application, DiagnosisChange, Plug, StationData};
use alloc::vec::Vec;
use station::{Duration, Time};
use wire::ethernet::Mac;
use wire::profinet::alarm::AlarmNotification;
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::connect::{AlarmCrBlockReq, ArBlockReq, IocrBlockReq};
use wire::profinet::blocks::module_diff::ModuleDiffBlock;
use wire::profinet::dcp::Value;
use wire::profinet::rpc::Header;
use wire::profinet::rt::{FrameId, IoxS};
use wire::profinet::status::{AbortReason, RecordError};

/// A yes or no that the stack decides, with what it decides about; the comment says what `true` means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StackCheck<'a> {
    /// A frame to this address is for the device alone.
    Addressed(Mac),
    /// The first name, which is that of the device, is the second one, for which Identify looks.
    AskedName(&'a [u8], &'a [u8]),
    /// The device may be given this name; the empty name is blank.
    Name(&'a [u8]),
    /// Signal has a value for which the LED flashes.
    Signal(u16),
    /// The connections end, for this reason.
    Ends(AbortReason),
    /// A block of Connect that is not for this device is passed over.
    PassedOver(BlockType),
    /// The field of this number, the header counted, has a value that the device takes.
    ArField(&'a ArBlockReq, u8),
    /// The same of a connection of cyclic data.
    IocrField(&'a IocrBlockReq, u8),
    /// The same of the connection of alarms.
    AlarmCrField(&'a AlarmCrBlockReq, u8),
    /// A submodule that is expected to have this many octets of inputs has them.
    InputLength(u16),
    /// A submodule that is expected to have this many octets of outputs has them.
    OutputLength(u16),
    /// There is room for a connection beside so many others of its kind: with cyclic data, or for records alone.
    Room {
        /// Whether it has cyclic data.
        is_exchange: bool,
        /// How many others there are.
        others: usize,
    },
    /// The old connection of a controller gives way to the new one of the same controller.
    GivesWay,
    /// Outputs are expected under this frame id.
    FrameId(FrameId),
    /// Outputs are expected from this station.
    Source(Mac),
    /// A cyclic frame is as long as was agreed.
    FrameLength(usize),
    /// Outputs with this status count.
    ProviderStatus(IoxS),
    /// The outputs of a submodule were good and are missing from now on.
    OutputsEnd,
    /// Inputs may be good.
    InputsReady,
    /// The device takes outputs, as their consumer status says.
    TakesOutputs,
    /// An alarm PDU is for the alarm endpoint of a connection.
    AlarmEndpoint,
    /// An acknowledgement is that of the alarm that waits for it.
    Acknowledgement,
    /// There is something plugged where this record is looked up.
    Plugged(Access),
    /// A record is longer than the reader has room for, and is cut.
    TooLong,
}

/// A connection begins or ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Connection {
    /// It was opened.
    Opened,
    /// Its controller has released it.
    Released,
    /// Its controller has aborted it.
    Aborted,
    /// The device has ended it.
    Ended,
}

/// When the stored name and addresses are taken into use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// At power-up.
    PowerUp,
    /// After a reset through DCP.
    Reset,
}

/// What of a device a deviation can read.
#[derive(Clone, Copy)]
pub struct StackView<'a> {
    /// The time by the clock of the stack.
    pub now: Time,
    /// The application behind the stack.
    pub application: &'a dyn Application,
    /// The address of the device.
    pub mac: Mac,
    /// The name and the addresses in use.
    pub station: &'a StationData,
    /// What is plugged, interface and ports among it.
    pub plugged: &'a [Plug],
}

/// The hooks of a stack; each default changes nothing.
#[allow(unused_variables, reason = "the names tell what a seam is about")]
pub trait StackHooks {
    /// What the stack has decided about this.
    fn check(&mut self, check: StackCheck<'_>, verdict: bool) -> bool {
        verdict
    }

    /// The frames that the stack receives in the place of one that came.
    fn comes(&mut self, view: &StackView<'_>, frames: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        frames
    }

    /// Changes a frame that the stack sends; an empty one is not sent.
    fn goes(&mut self, view: &StackView<'_>, frame: &mut Vec<u8>) {}

    /// Changes the body of a call, from the NDR header on, once it is whole.
    fn call(&mut self, view: &StackView<'_>, header: &Header, body: &mut Vec<u8>) {}

    /// Changes which record is accessed.
    fn access(&mut self, access: &mut Access) {}

    /// Changes a record that was read.
    fn read(&mut self, access: Access, result: &mut Result<Vec<u8>, RecordError>) {}

    /// Changes how it went to write a record.
    fn written(&mut self, access: Access, data: &[u8], result: &mut Result<(), RecordError>) {}

    /// The value of an element of DCP, as the device says it and compares it with a filter.
    fn element(&mut self, value: Value) -> Value {
        value
    }

    /// The MAC address, from that of the piece; asked once, and after each reset through DCP.
    fn mac(&mut self, mac: Mac) -> Mac {
        mac
    }

    /// Changes the stored name and addresses that are taken into use.
    fn load_station(&mut self, start: Start, station: &mut StationData) {}

    /// Changes what a Set has made of the station in use and of the stored one, from the one that was in use before.
    fn set_station(&mut self, before: &StationData, station: &mut StationData, stored: &mut StationData) {}

    /// Changes what can be plugged, interface and ports among it.
    fn plugs(&mut self, plugs: &mut Vec<Plug>) {}

    /// Changes what Connect and ApplicationReady say of modules that differ, from how `all` that are expected compare.
    fn difference(&mut self, all: &ModuleDiffBlock, differing: &mut Option<ModuleDiffBlock>) {}

    /// Changes the outputs that a submodule is given; none once they are bad or missing.
    fn outputs(&mut self, slot: u16, subslot: u16, data: &mut Option<Vec<u8>>) {}

    /// How long outputs may be missing, from what was agreed.
    fn hold(&mut self, agreed: Duration) -> Duration {
        agreed
    }

    /// Changes a diagnosis that comes or goes; `false` keeps it from the stack.
    fn diagnosis(&mut self, change: &mut DiagnosisChange, is_noted: bool) -> bool {
        is_noted
    }

    /// Changes an alarm; `false` keeps it from being sent.
    fn alarm(&mut self, alarm: &mut AlarmNotification, is_sent: bool) -> bool {
        is_sent
    }

    /// A connection begins or ends.
    fn connection(&mut self, event: Connection) {}

    /// Whether all connections end now although nothing demands it; asked after each input.
    fn aborts(&mut self, aborts: bool) -> bool {
        aborts
    }
}

/// The deviations of a stack, as its parts ask them.
#[derive(Clone, Debug, Default)]
pub(super) struct Hooks(pub Attached<dyn StackHooks>);

impl Hooks {
    /// The decision that counts: `verdict`, unless a deviation flips it.
    #[inline]
    pub(super) fn check(&self, check: StackCheck<'_>, verdict: bool) -> bool {
        self.0.apply(verdict, |hooks, verdict| hooks.check(check, verdict))
    }
}

impl core::ops::Deref for Hooks {
    type Target = Attached<dyn StackHooks>;

    fn deref(&self) -> &Attached<dyn StackHooks> {
        &self.0
    }
}
