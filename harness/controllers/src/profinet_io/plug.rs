//! What a controller does after a submodule was plugged or released: it ends the parameters of that submodule, so that the device
//! can report it as ready.
//!
//! The start records of the submodule are not written again: no device of the suites has start records and exchangeable modules. A
//! refused PrmEnd changes nothing, since the submodule then stays as it is.

use super::call::ControllerCall;
use super::context::{ARGS_MAXIMUM, ControllerContext};
use super::state::AwaitedEvent;
use alloc::collections::VecDeque;
use core::time::Duration;
use station::{Outbox, Time};
use wire::datagram::Datagram;
use wire::profinet::alarm::{AlarmNotification, AlarmType};
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::control::{ControlBlock, ControlBlocks, ControlCommand};
use wire::profinet::rpc::{NdrRequest, Opnum};

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

    /// Adds a submodule by the sequence number of its alarm.
    pub(super) fn add(&mut self, now: Time, sequence: u16) {
        self.waiting.push_back((now + self.pause, sequence));
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
        self.call.take_if(|call| call.receive(now, datagram, out).is_some()).is_some()
    }
}

impl ControllerContext {
    /// Sends the PrmEnd that is due, or repeats one that is not answered.
    pub(super) fn wake_plugs(&mut self, now: Time, out: &mut Outbox) {
        let ControllerContext { own, ids, ar: Some(ar), .. } = self else { return };
        ar.plugs.call.take_if(|call| call.wake(now, out).is_some());
        if ar.plugs.call.is_some() {
            return;
        }
        let Some((_, sequence)) = ar.plugs.waiting.front().copied().filter(|(due, _)| *due <= now) else { return };
        ar.plugs.waiting.pop_front();
        let (uuid, key) = (ar.names.uuid, ar.names.session_key);
        let block = ControlBlock {
            alarm_sequence_number: sequence,
            ..ControlBlock::request(BlockType::PLUG_PRM_END_REQ, uuid, key, ControlCommand::PRM_END)
        };
        let header = ar.callee(ids.uuid(), 0, Opnum::CONTROL).header();
        let body = NdrRequest::body(ar.order, ARGS_MAXIMUM, &ControlBlocks::from(block).to_vec());
        let ends = (*own, ar.partner);
        ar.plugs.call = Some(ControllerCall::new(AwaitedEvent::ParameterEnd, ends, header, &body, now, out));
    }
}
