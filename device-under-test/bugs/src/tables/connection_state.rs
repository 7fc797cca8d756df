//! Deviations of the PROFINET stack that have state about connections.

use crate::seams::stack::{IM0, cyclic, profinet};
use alloc::vec::Vec;
use core::mem;
use device_stack::profinet::{
    ArEvent, DiagnosisChange, RecordAccess, StackCheck, StackHooks, StackView, StationData, StationLoad,
};
use wire::profinet::alarm::AlarmNotification;
use wire::profinet::blocks::connect::{IocrBlockReq, IocrType};
use wire::profinet::blocks::im::Im0;
use wire::profinet::rpc::{Opnum, RpcHeader};
use wire::profinet::rt::{ApduStatus, DataStatus, IoxS};
use wire::profinet::status::RecordError;

/// Opens only three connections.
#[derive(Default)]
pub struct ThreeConnectionsOnly {
    connections: u32,
}

impl StackHooks for ThreeConnectionsOnly {
    fn connection(&mut self, event: ArEvent) {
        self.connections += u32::from(event == ArEvent::Opened);
    }

    fn check(&mut self, check: StackCheck<'_>, verdict: bool) -> bool {
        verdict && !(self.connections >= 3 && matches!(check, StackCheck::ConnectionLimit { .. }))
    }
}

/// Refuses further connections after one has ended in a certain way.
pub struct RefusesAfterEnd {
    /// The end of a connection after which others are refused.
    pub after: ArEvent,
    /// Whether a connection has ended in this way since power-up.
    pub is_taken: bool,
}

impl StackHooks for RefusesAfterEnd {
    fn connection(&mut self, event: ArEvent) {
        self.is_taken |= event == self.after;
    }

    fn load_station(&mut self, start: StationLoad, _: &mut StationData) {
        self.is_taken &= start != StationLoad::PowerUp;
    }

    fn check(&mut self, check: StackCheck<'_>, verdict: bool) -> bool {
        verdict && !(self.is_taken && matches!(check, StackCheck::ConnectionLimit { is_exchange: true, .. }))
    }
}

/// Ends all connections when a cyclic frame is too short.
#[derive(Default)]
pub struct AbortsAtShortFrame {
    aborts: bool,
}

impl StackHooks for AbortsAtShortFrame {
    fn check(&mut self, check: StackCheck<'_>, verdict: bool) -> bool {
        self.aborts |= matches!(check, StackCheck::FrameLength(_)) && !verdict;
        verdict
    }

    fn aborts(&mut self, aborts: bool) -> bool {
        mem::take(&mut self.aborts) || aborts
    }
}

/// Ends all connections when a record is read without one.
#[derive(Default)]
pub struct AbortsAtImplicitRead {
    aborts: bool,
}

impl StackHooks for AbortsAtImplicitRead {
    fn call(&mut self, _: &StackView<'_>, header: &RpcHeader, _: &mut Vec<u8>) {
        self.aborts |= header.opnum == Opnum::READ_IMPLICIT;
    }

    fn aborts(&mut self, aborts: bool) -> bool {
        mem::take(&mut self.aborts) || aborts
    }
}

/// Writes only the first record of a call: the others go to an empty slot, and all are answered positively.
#[derive(Default)]
pub struct WritesFirstRecord {
    is_in_write: bool,
    records: usize,
}

impl StackHooks for WritesFirstRecord {
    fn call(&mut self, _: &StackView<'_>, header: &RpcHeader, _: &mut Vec<u8>) {
        (self.is_in_write, self.records) = (header.opnum == Opnum::WRITE, 0);
    }

    fn access(&mut self, access: &mut RecordAccess) {
        self.records += 1;
        if self.is_in_write && self.records > 1 {
            access.slot = 0xFFFF;
        }
    }

    fn written(&mut self, _: RecordAccess, _: &[u8], result: &mut Result<(), RecordError>) {
        if self.records > 1 {
            *result = Ok(());
        }
    }
}

/// Makes I&M0 writable.
#[derive(Default)]
pub struct WritableIm0 {
    written: Option<Im0>,
}

impl StackHooks for WritableIm0 {
    fn written(&mut self, access: RecordAccess, data: &[u8], result: &mut Result<(), RecordError>) {
        if access.index == IM0 && *result == Err(RecordError::ACCESS_DENIED) {
            self.written = Im0::parse(data).ok().or(self.written.take());
            *result = Im0::parse(data).map(|_| ()).map_err(|_| RecordError::WRITE_LENGTH_ERROR);
        }
    }

    fn read(&mut self, access: RecordAccess, result: &mut Result<Vec<u8>, RecordError>) {
        if let (IM0, Ok(data), Some(im0)) = (access.index, result, &self.written) {
            data.clear();
            im0.write(data);
        }
    }
}

/// Sends bad inputs while an alarm waits for its acknowledgement.
#[derive(Default)]
pub struct AlarmsBlockInputs {
    waiting: usize,
}

impl StackHooks for AlarmsBlockInputs {
    fn connection(&mut self, _: ArEvent) {
        self.waiting = 0;
    }

    fn alarm(&mut self, _: &mut AlarmNotification, is_sent: bool) -> bool {
        self.waiting += usize::from(is_sent);
        is_sent
    }

    fn check(&mut self, check: StackCheck<'_>, verdict: bool) -> bool {
        match check {
            StackCheck::Acknowledgement => {
                self.waiting = self.waiting.saturating_sub(verdict.into());
                verdict
            }
            StackCheck::InputsReady | StackCheck::TakesOutputs => verdict && self.waiting == 0,
            _ => verdict,
        }
    }
}

/// Sends alarms only when a diagnosis appears or disappears, not for diagnoses from before the connection.
#[derive(Default)]
pub struct OnlyNewAlarms {
    is_new: bool,
}

impl StackHooks for OnlyNewAlarms {
    fn received_frames(&mut self, _: &StackView<'_>, frames: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        self.is_new = false;
        frames
    }

    fn diagnosis(&mut self, _: &mut DiagnosisChange, is_noted: bool) -> bool {
        self.is_new = true;
        is_noted
    }

    fn alarm(&mut self, _: &mut AlarmNotification, is_sent: bool) -> bool {
        is_sent && self.is_new
    }
}

/// The offsets of the outputs of each submodule in the frames of the last connection.
#[derive(Default)]
struct OutputFrame {
    agreed: Option<IocrBlockReq>,
}

impl OutputFrame {
    /// Stores the output IOCR of a Connect.
    fn note(&mut self, check: StackCheck<'_>) {
        if let StackCheck::IocrField(block, 4) = check
            && block.iocr_type == IocrType::OUTPUT
        {
            self.agreed = Some(block.clone());
        }
    }

    /// Returns the offset of the IOPS of each submodule in an output frame, and its number of output bytes.
    fn statuses(&self, view: &StackView<'_>, frame: &[u8]) -> Vec<(usize, u16)> {
        let is_received =
            |at: &usize| profinet(frame).is_some_and(|(header, ..)| header.destination == view.mac) && *at > 0;
        let (Some(agreed), Some(at)) = (&self.agreed, cyclic(frame).filter(is_received)) else { return Vec::new() };
        let status = |api: u32, slot: u16, subslot: u16, offset: u16| {
            let plug = view.plugged.iter().find(|plug| (plug.api, plug.slot, plug.subslot) == (api, slot, subslot))?;
            let status_at = at + 2 + usize::from(offset) + usize::from(plug.output_octets);
            (status_at < frame.len()).then_some((status_at, plug.output_octets))
        };
        let objects = agreed.apis.iter().flat_map(|api| api.io_data_objects.iter().map(move |of| (api.api, of)));
        objects.filter_map(|(api, of)| status(api, of.slot_number, of.subslot_number, of.frame_offset)).collect()
    }
}

/// Treats the outputs of all submodules as bad if those of one are bad.
#[derive(Default)]
pub struct OneBadClearsAll {
    outputs: OutputFrame,
}

impl StackHooks for OneBadClearsAll {
    fn check(&mut self, check: StackCheck<'_>, verdict: bool) -> bool {
        self.outputs.note(check);
        verdict
    }

    fn received_frames(&mut self, view: &StackView<'_>, mut frames: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        for frame in &mut frames {
            let statuses = self.outputs.statuses(view, frame);
            if statuses.iter().any(|(at, _)| !IoxS(frame[*at]).is_good()) {
                statuses.iter().for_each(|(at, _)| frame[*at] = IoxS::BAD.0);
            }
        }
        frames
    }
}

/// Freezes the inputs while outputs are bad.
#[derive(Default)]
pub struct InputsStandStill {
    outputs: OutputFrame,
    are_bad: bool,
    last: Vec<u8>,
}

impl StackHooks for InputsStandStill {
    fn check(&mut self, check: StackCheck<'_>, verdict: bool) -> bool {
        self.outputs.note(check);
        verdict
    }

    fn connection(&mut self, _: ArEvent) {
        self.are_bad = false;
    }

    fn received_frames(&mut self, view: &StackView<'_>, frames: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        for frame in &frames {
            let statuses = self.outputs.statuses(view, frame);
            let Some(at) = cyclic(frame).filter(|_| !statuses.is_empty()) else { continue };
            let length = self.outputs.agreed.as_ref().map_or(0, |agreed| agreed.data_length);
            let data_status = frame.get(at + 2 + usize::from(length) + 2).copied().map_or(DataStatus(0), DataStatus);
            let is_good = |at: &usize| IoxS(frame[*at]).is_good();
            let counts = data_status.has(DataStatus::PRIMARY | DataStatus::DATA_VALID | DataStatus::RUN);
            self.are_bad = !counts || statuses.iter().any(|(at, octets)| *octets > 0 && !is_good(at));
        }
        frames
    }

    fn sent_frame(&mut self, _: &StackView<'_>, frame: &mut Vec<u8>) {
        let Some(at) = cyclic(frame) else { return };
        let data = at + 2..frame.len() - ApduStatus::LENGTH;
        if self.are_bad && self.last.len() == data.len() {
            frame[data].copy_from_slice(&self.last);
        } else {
            self.last = frame[data].to_vec();
        }
    }
}
