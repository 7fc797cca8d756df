//! The hooks of a PROFINET stack: the seams at which a deviation may change incoming and outgoing data, and the
//! checks that it may flip.
//!
//! The stack itself conforms. Without the feature `deviations` no hook is called.

use crate::attached::Attached;
use crate::profinet::{
    DiagnosisChange, IoApplication, IoIdentity, MibObject, PluggableSubmodule, RecordAccess, SnmpAnswer, StationData,
};
use alloc::vec::Vec;
use station::{Duration, Time};
use wire::ethernet::Mac;
use wire::octets::ByteOrder;
use wire::profinet::alarm::AlarmNotification;
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::connect::{AlarmCrBlockReq, ArBlockReq, IocrBlockReq};
use wire::profinet::blocks::module_diff::ModuleDiffBlock;
use wire::profinet::dcp::DcpValue;
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::rpc::RpcHeader;
use wire::profinet::rt::{DataStatus, FrameId, IoxS};
use wire::profinet::status::{AbortReason, PnioStatus, RecordError};

/// A yes-or-no decision of the stack and its subject. Each comment says what `true` means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StackCheck<'a> {
    /// A frame with this destination is addressed to the device.
    Addressed(Mac),
    /// The device answers an Identify for all stations.
    IdentifyAll,
    /// The name of the device (first) equals the name in an Identify filter (second).
    IdentifyName(&'a [u8], &'a [u8]),
    /// The device accepts this name; an empty name clears it.
    Name(&'a [u8]),
    /// A station can use these addresses.
    Address(IpParameter),
    /// A Set comes from the station whose transaction is open.
    TransactionOwner,
    /// A transaction without a Stop ends.
    TransactionEnds,
    /// A call is older than the last one of its activity and is not answered.
    OldCall,
    /// A cyclic frame with this DataStatus is ignored as a whole.
    IgnoredFrame(DataStatus),
    /// The outputs of a frame with this DataStatus count.
    DataStatus(DataStatus),
    /// The LED flashes for this Signal value.
    Signal(u16),
    /// The connections end, for this reason.
    Ends(AbortReason),
    /// The device ignores a block of this type in Connect.
    IgnoredBlock(BlockType),
    /// The device accepts the version of a block of this type in Connect.
    BlockVersion(BlockType),
    /// The device accepts the value of the field of this number. The fields of the block header count.
    ArField(&'a ArBlockReq, u8),
    /// The same for a field of IOCRBlockReq.
    IocrField(&'a IocrBlockReq, u8),
    /// The same for a field of AlarmCRBlockReq.
    AlarmCrField(&'a AlarmCrBlockReq, u8),
    /// The same for a field of ExpectedSubmoduleBlockReq.
    ExpectedField(u8),
    /// The plugged submodule has the expected input length in bytes.
    InputLength(u16),
    /// The plugged submodule has the expected output length in bytes.
    OutputLength(u16),
    /// The device accepts one more connection of this kind: with cyclic data, or for records only.
    ConnectionLimit {
        /// Whether the connection has cyclic data.
        is_exchange: bool,
        /// The number of open connections of this kind.
        others: usize,
    },
    /// A diagnosis is reported to a connection that expects the submodule and does not own it.
    DiagnosisOfOthers,
    /// Another connection owns the submodule at this slot and subslot.
    OwnedByOther(u16, u16),
    /// A connection that does not own the submodule of this record may write it.
    WritesOfOthers(RecordAccess),
    /// A connection may read a record of a submodule that another one owns.
    ReadsOfOthers,
    /// The inputs of the submodule at this slot and subslot can be good: it is plugged, and its connection owns it.
    Usable(u16, u16),
    /// The outputs of the submodule at this slot and subslot can be consumed, for the same reasons.
    Consumes(u16, u16),
    /// A connection for records only ends when its initiator is silent for too long.
    EndsWhenSilent,
    /// The data of a plugged submodule stay bad until the end of its parameters.
    PlugAwaitsParameters,
    /// A plugged submodule is ready once its parameters are complete.
    PlugBecomesReady,
    /// A new connection of a controller replaces its old one.
    ReplacesConnection,
    /// Frames with this FrameID carry the expected outputs.
    FrameId(FrameId),
    /// The outputs are expected from this station.
    Source(Mac),
    /// A cyclic frame has the agreed length.
    FrameLength(usize),
    /// Outputs with this IOPS are valid.
    ProviderStatus(IoxS),
    /// The application is informed that the outputs of a submodule, good so far, are missing from now on.
    OutputsEnd,
    /// Inputs may have a good IOPS.
    InputsReady,
    /// The device consumes outputs: their IOCS is good.
    TakesOutputs,
    /// Alarms of high priority have their own sequence numbers.
    NumbersOfHighAlarms,
    /// An alarm is sent in frames of high priority.
    InHighFrames,
    /// An alarm of high priority is sent while one of low priority waits for its acknowledgement.
    HighBesideLow,
    /// An alarm PDU is for the alarm endpoint of a connection.
    AlarmEndpoint,
    /// An acknowledgement belongs to the alarm that waits for one.
    Acknowledgement,
    /// The neighbour is the expected station.
    PeerStation,
    /// The neighbour is connected with the expected one of its ports.
    PeerPort,
    /// The device says Hello: after its start, or because its cable was plugged in.
    SaysHello {
        /// After its start.
        at_start: bool,
    },
    /// The first Hello waits for the delay of record 0x8090.
    DelayedHello,
    /// This Hello is the last one.
    LastHello,
    /// Record 0x8090 is kept over a loss of power.
    KeepsFastStartUp,
    /// A reset of the communication parameters clears record 0x8090.
    ResetsFastStartUp,
    /// A submodule that is plugged replaces the one that is listed at its address.
    ReplacesPlugged,
    /// A record of a port has the right block.
    PortBlock,
    /// A record of a port names the port that it is written to.
    PortAddress,
    /// A submodule is plugged at the address of this record access.
    Plugged(RecordAccess),
    /// The agent answers messages of this version of SNMP: 0 is SNMPv1, 1 is SNMPv2c.
    SnmpVersion(i32),
    /// The agent answers this community.
    SnmpCommunity(&'a [u8]),
    /// A record is longer than the reader accepts and is truncated.
    RecordTooLong,
}

/// The begin or end of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArEvent {
    /// The connection was opened.
    Opened,
    /// The controller released it.
    Released,
    /// The controller aborted it.
    Aborted,
    /// The device ended it.
    Ended,
}

/// When the device starts to use the stored name and addresses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StationLoad {
    /// At power-up.
    PowerUp,
    /// After a reset through DCP.
    Reset,
}

/// The state of a device that a deviation can read.
#[derive(Clone, Copy)]
pub struct StackView<'a> {
    /// The time of the stack's clock.
    pub now: Time,
    /// The application.
    pub application: &'a dyn IoApplication,
    /// MAC address of the device.
    pub mac: Mac,
    /// The name and the addresses in use.
    pub station: &'a StationData,
    /// The plugged submodules, including interface and ports.
    pub plugged: &'a [PluggableSubmodule],
}

/// The hooks of a stack; each default changes nothing.
#[allow(unused_variables, reason = "the names document the hook")]
pub trait StackHooks {
    /// Replaces a decision of the stack, which is `verdict`.
    fn check(&mut self, check: StackCheck<'_>, verdict: bool) -> bool {
        verdict
    }

    /// Replaces a received frame by the frames that the stack receives instead.
    fn received_frames(&mut self, view: &StackView<'_>, frames: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        frames
    }

    /// Changes a frame that the stack sends; an empty frame is not sent.
    fn sent_frame(&mut self, view: &StackView<'_>, frame: &mut Vec<u8>) {}

    /// When the next frame that a deviation holds back is due.
    fn due(&mut self, due: Option<Time>) -> Option<Time> {
        due
    }

    /// Appends the received frames that were held back and are due now.
    fn late_received(&mut self, now: Time, frames: &mut Vec<Vec<u8>>) {}

    /// Appends the frames to send that were held back and are due now.
    fn late_sent(&mut self, now: Time, frames: &mut Vec<Vec<u8>>) {}

    /// Changes the byte order of the RPC and NDR headers that the device sends; the value is that of the request. One
    /// order always results in the same one.
    fn byte_order(&mut self, order: ByteOrder) -> ByteOrder {
        order
    }

    /// Changes the status and the blocks of the answer to a call with this header.
    fn answer(&mut self, header: &RpcHeader, status: &mut PnioStatus, blocks: &mut Vec<u8>) {}

    /// Changes the UDP port from which the device calls the controller.
    fn client_port(&mut self, port: u16) -> u16 {
        port
    }

    /// Changes the FrameID of the outputs that the device chooses, because the initiator leaves it open.
    fn chosen_frame_id(&mut self, frame_id: u16) -> u16 {
        frame_id
    }

    /// Changes the LocalAlarmReference of the device in a connection.
    fn alarm_reference(&mut self, reference: u16) -> u16 {
        reference
    }

    /// Changes an IOPS or IOCS that the device sends.
    fn status(&mut self, status: IoxS) -> IoxS {
        status
    }

    /// Changes the identification data. Called once at each start.
    fn identity(&mut self, identity: &mut IoIdentity) {}

    /// Changes the reassembled body of a call, from the NDR header on.
    fn call(&mut self, view: &StackView<'_>, header: &RpcHeader, body: &mut Vec<u8>) {}

    /// Changes which record is accessed.
    fn access(&mut self, access: &mut RecordAccess) {}

    /// Changes a record that was read.
    fn read(&mut self, access: RecordAccess, result: &mut Result<Vec<u8>, RecordError>) {}

    /// Changes the result of writing a record.
    fn written(&mut self, access: RecordAccess, data: &[u8], result: &mut Result<(), RecordError>) {}

    /// Changes the objects of the SNMP agent, which are in the order of their names.
    fn snmp_objects(&mut self, objects: &mut Vec<MibObject>) {}

    /// Changes a response of the SNMP agent.
    fn snmp_answer(&mut self, answer: &mut SnmpAnswer) {}

    /// Changes the value of a DCP element that the device reports and compares with Identify filters.
    fn element(&mut self, value: DcpValue) -> DcpValue {
        value
    }

    /// Changes the MAC address, which is by default that of the specimen. Called once, and after each reset by DCP.
    fn mac(&mut self, mac: Mac) -> Mac {
        mac
    }

    /// Changes the stored name and addresses that the device starts to use.
    fn load_station(&mut self, start: StationLoad, station: &mut StationData) {}

    /// Changes the name and addresses in use and the stored ones after a Set; `before` was in use until then.
    fn set_station(&mut self, before: &StationData, station: &mut StationData, stored: &mut StationData) {}

    /// Changes the list of submodules that can be plugged, including interface and ports.
    fn plugs(&mut self, plugs: &mut Vec<PluggableSubmodule>) {}

    /// Changes the ModuleDiffBlock of Connect and ApplicationReady. `all` compares every expected submodule.
    fn difference(&mut self, all: &ModuleDiffBlock, differing: &mut Option<ModuleDiffBlock>) {}

    /// Changes the outputs for a submodule; `None` once they are bad or missing.
    fn outputs(&mut self, slot: u16, subslot: u16, data: &mut Option<Vec<u8>>) {}

    /// Changes the data hold time.
    fn data_hold_time(&mut self, agreed: Duration) -> Duration {
        agreed
    }

    /// Changes a diagnosis that appears or disappears. `false` hides it from the stack.
    fn diagnosis(&mut self, change: &mut DiagnosisChange, is_noted: bool) -> bool {
        is_noted
    }

    /// Changes an alarm. `false` suppresses it.
    fn alarm(&mut self, alarm: &mut AlarmNotification, is_sent: bool) -> bool {
        is_sent
    }

    /// Changes the sequence number of the alarm in an ApplicationReady for a plugged or released submodule; with `None` there is none.
    fn plug_ready(&mut self, alarm: Option<u16>) -> Option<u16> {
        alarm
    }

    /// A connection begins or ends.
    fn connection(&mut self, event: ArEvent) {}

    /// Changes the reason of the ERR-RTA for a released connection; with `None` there is none.
    fn release_error(&mut self, reason: Option<AbortReason>) -> Option<AbortReason> {
        reason
    }

    /// Whether the device aborts all connections now, without a reason. Called after each event.
    fn aborts(&mut self, aborts: bool) -> bool {
        aborts
    }
}

/// The hooks of a stack as its parts hold them.
pub(super) type AttachedStackHooks = Attached<dyn StackHooks>;

impl AttachedStackHooks {
    /// Returns `verdict`, unless a deviation flips it.
    #[inline]
    pub(super) fn check(&self, check: StackCheck<'_>, verdict: bool) -> bool {
        self.apply(verdict, |hooks, verdict| hooks.check(check, verdict))
    }

    /// The byte order of an answer or call, given that of the request.
    pub(super) fn byte_order(&self, order: ByteOrder) -> ByteOrder {
        self.apply(order, |hooks, order| hooks.byte_order(order))
    }
}
