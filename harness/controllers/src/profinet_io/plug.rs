//! What a controller does after a submodule was plugged or released: it ends the parameters of that submodule, so that the device
//! can report it as ready.
//!
//! The start records of the submodule are not written again: no device of the suites has start records and exchangeable modules. A
//! refused PrmEnd changes nothing, since the submodule then stays as it is.

use super::call::{ControllerCall, RpcCallResult};
use super::context::{ARGS_MAXIMUM, ControllerContext};
use super::state::AwaitedEvent;
use alloc::collections::VecDeque;
use alloc::vec::Vec;
use core::time::Duration;
use station::{Outbox, Time};
use wire::datagram::Datagram;
use wire::profinet::alarm::{AlarmNotification, AlarmType};
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::control::{ControlBlock, ControlBlocks};
use wire::profinet::rpc::{Flags1, NdrRequest, Opnum, PacketType, RpcHeader, Uuid};

/// The submodules of an AR whose parameters have to be ended.
#[derive(Debug)]
pub(super) struct PluggedSubmodules {
    pause: Duration,
    /// When a PrmEnd is due, and the sequence number of its alarm.
    waiting: VecDeque<(Time, u16)>,
    call: Option<ControllerCall>,
}

/// Whether parameters follow an alarm.
pub(super) fn needs_parameters(alarm: &AlarmNotification) -> bool {
    matches!(alarm.alarm_type, AlarmType::PLUG | AlarmType::RELEASED)
}

impl PluggedSubmodules {
    /// None yet. The controller waits for `pause` before each PrmEnd.
    pub(super) fn new(pause: Duration) -> PluggedSubmodules {
        PluggedSubmodules { pause, waiting: VecDeque::new(), call: None }
    }

    /// Adds submodules by the sequence numbers of their alarms.
    pub(super) fn add(&mut self, now: Time, sequences: Vec<u16>) {
        self.waiting.extend(sequences.into_iter().map(|sequence| (now + self.pause, sequence)));
    }

    /// When something has to be sent.
    pub(super) fn deadline(&self) -> Option<Time> {
        match &self.call {
            Some(call) => Some(call.deadline()),
            None => self.waiting.front().map(|(due, _)| *due),
        }
    }

    /// Processes a datagram; returns whether it ended the PrmEnd.
    pub(super) fn receive(&mut self, now: Time, datagram: &Datagram, out: &mut Outbox) -> bool {
        let ended = self.call.as_mut().and_then(|call| call.receive(now, datagram, out));
        self.end_with(ended)
    }

    fn end_with(&mut self, ended: Option<RpcCallResult>) -> bool {
        if ended.is_some() {
            self.call = None;
        }
        ended.is_some()
    }
}

impl ControllerContext {
    /// Sends the PrmEnd that is due, or repeats one that is not answered.
    pub(super) fn wake_plugs(&mut self, now: Time, out: &mut Outbox) {
        let ControllerContext { own, ids, ar: Some(ar), .. } = self else { return };
        let ended = ar.plugs.call.as_mut().and_then(|call| call.wake(now, out));
        ar.plugs.end_with(ended);
        if ar.plugs.call.is_some() {
            return;
        }
        let Some((_, sequence)) = ar.plugs.waiting.front().copied().filter(|(due, _)| *due <= now) else { return };
        ar.plugs.waiting.pop_front();
        let mut block = ControlBlock::prm_end(ar.names.uuid, ar.names.session_key);
        block.header.kind = BlockType::PLUG_PRM_END_REQ;
        block.alarm_sequence_number = sequence;
        let header = RpcHeader {
            flags1: Flags1::IDEMPOTENT,
            object: ar.object,
            interface: Uuid::DEVICE_INTERFACE,
            activity: ids.uuid(),
            opnum: Opnum::CONTROL,
            ..RpcHeader::new(PacketType::REQUEST, ar.order)
        };
        let body = NdrRequest::body(ar.order, ARGS_MAXIMUM, &ControlBlocks::from(block).to_vec());
        let ends = (*own, ar.partner);
        ar.plugs.call = Some(ControllerCall::new(AwaitedEvent::ParameterEnd, ends, header, &body, now, out));
    }
}
