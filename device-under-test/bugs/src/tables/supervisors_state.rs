//! Deviations of the PROFINET stack with state about connections of supervisors.

use super::supervisors::WITHIN;
use alloc::vec::Vec;
use device_stack::profinet::{RecordAccess, StackCheck, StackHooks, StackView};
use wire::profinet::rpc::{NdrRequest, Opnum, RpcHeader};
use wire::profinet::status::RecordError;

/// ARType of a supervisor.
const SUPERVISOR: [u8; 2] = [0, 6];

/// Recognizes the calls of supervisors by the UUIDs of their connections.
#[derive(Default)]
pub struct SupervisorCalls {
    uuids: Vec<Vec<u8>>,
    is_its: bool,
}

impl SupervisorCalls {
    fn note(&mut self, header: &RpcHeader, body: &[u8]) {
        self.is_its = false;
        let Ok((_, blocks)) = NdrRequest::parse(header.order(), body) else { return };
        let (Some(kind), Some(uuid)) = (blocks.get(6..8), blocks.get(8..24)) else { return };
        if header.opnum == Opnum::CONNECT && kind == SUPERVISOR {
            self.uuids.push(uuid.to_vec());
        }
        self.is_its = WITHIN.contains(&header.opnum) && self.uuids.iter().any(|known| known == uuid);
    }
}

/// Refuses reads of supervisors.
pub struct RefusesReads(pub SupervisorCalls);

impl StackHooks for RefusesReads {
    fn call(&mut self, _: &StackView<'_>, header: &RpcHeader, body: &mut Vec<u8>) {
        self.0.note(header, body);
    }

    fn read(&mut self, access: RecordAccess, result: &mut Result<Vec<u8>, RecordError>) {
        if self.0.is_its && access.ar.is_some() {
            *result = Err(RecordError::ACCESS_DENIED);
        }
    }
}

/// Returns for each record that a supervisor has written what it was before.
#[derive(Default)]
pub struct DropsWrites {
    calls: SupervisorCalls,
    lost: Vec<u16>,
}

impl StackHooks for DropsWrites {
    fn call(&mut self, _: &StackView<'_>, header: &RpcHeader, body: &mut Vec<u8>) {
        self.calls.note(header, body);
    }

    fn written(&mut self, access: RecordAccess, _: &[u8], _: &mut Result<(), RecordError>) {
        self.lost.retain(|index| *index != access.index);
        if self.calls.is_its {
            self.lost.push(access.index);
        }
    }

    fn read(&mut self, access: RecordAccess, result: &mut Result<Vec<u8>, RecordError>) {
        if let (true, Ok(data)) = (self.lost.contains(&access.index), result) {
            let text = data.len().min(6);
            data[text..].fill(b' ');
        }
    }
}

/// Ends all connections when a supervisor connects.
#[derive(Default)]
pub struct EndsControllers {
    calls: SupervisorCalls,
    is_due: bool,
}

impl StackHooks for EndsControllers {
    fn call(&mut self, _: &StackView<'_>, header: &RpcHeader, body: &mut Vec<u8>) {
        self.calls.note(header, body);
        self.is_due |= self.calls.is_its && header.opnum == Opnum::CONNECT;
    }

    fn aborts(&mut self, aborts: bool) -> bool {
        core::mem::take(&mut self.is_due) || aborts
    }
}

/// Accepts one connection of a supervisor and no other one.
#[derive(Default)]
pub struct KeepsSupervisor {
    is_taken: bool,
}

impl StackHooks for KeepsSupervisor {
    fn check(&mut self, check: StackCheck<'_>, verdict: bool) -> bool {
        let StackCheck::ConnectionLimit { is_exchange: false, .. } = check else { return verdict };
        !core::mem::replace(&mut self.is_taken, true) && verdict
    }
}
