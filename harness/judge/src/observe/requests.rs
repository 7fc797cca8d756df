//! Processes the requests of calls.

use super::calls::{CallKey, CallService, number};
use super::connect::{ids, requested_connection};
use super::tracker::{ReceivedFrame, Sink, Tracker};
use super::{ArId, ArStage, CallPart, FrameDirection, Observation, Traffic};
use rustc_hash::FxHasher;
use std::hash::Hasher;
use wire::WireError;
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::connect::Connect;
use wire::profinet::blocks::control::ControlBlocks;
use wire::profinet::blocks::record::{ReadRequest, WriteRequest};
use wire::profinet::rpc::{NdrRequest, Opnum, RpcHeader, Uuid};

impl Tracker {
    /// Processes the complete body of a request.
    pub(super) fn request(
        &mut self,
        received: &ReceivedFrame<'_>,
        header: &RpcHeader,
        body: &[u8],
        sink: Sink<'_>,
    ) -> Result<(), WireError> {
        let key = (header.activity, header.sequence);
        let mut hasher = FxHasher::default();
        hasher.write(body);
        let (hash, ars) = (hasher.finish(), &self.ars);
        let over = |ar: ArId| {
            let known = ars.get(ar.0 as usize);
            known.is_none_or(|ar| !matches!(ar.stage, ArStage::Asked | ArStage::Refused) && !ar.stage.stands())
        };
        if let Some(before) = self.calls.repetition(key, hash, received.time, over) {
            self.counts.repeated += 1;
            if !before.is_copy {
                self.report_call(received, key, (before.service, before.ar), CallPart::Again, sink);
            }
            return Ok(());
        }
        let outcome = self.asked(received, header, body, sink);
        // Unreadable requests are stored too, so that their repetitions are not reported again.
        let (asked, outcome) = match outcome {
            Ok(asked) => (asked, Ok(())),
            Err(error) => (CallService::Nothing, Err(error)),
        };
        let what = (asked.service(), asked.ar());
        self.calls.ask(key, hash, received.time, asked);
        self.report_call(received, key, what, CallPart::Asked, sink);
        outcome
    }

    /// Reports a step of a call.
    pub(super) fn report_call(
        &mut self,
        received: &ReceivedFrame<'_>,
        key: CallKey,
        (service, ar): (&'static str, Option<ArId>),
        part: CallPart,
        sink: Sink<'_>,
    ) {
        let (source, destination) = (received.header.source, received.header.destination);
        let traffic = Traffic::Call { ar, number: number(key), service, part, source, destination };
        sink(&self.ars, Observation::Traffic(traffic));
    }

    fn asked(
        &mut self,
        received: &ReceivedFrame<'_>,
        header: &RpcHeader,
        body: &[u8],
        sink: Sink<'_>,
    ) -> Result<CallService, WireError> {
        let (ndr, blocks) = NdrRequest::parse(header.order(), body)?;
        let blocks = blocks.get(..ndr.args_length as usize).unwrap_or(blocks);
        let asked = match header.opnum {
            Opnum::CONNECT => self.connect_request(received, header, blocks),
            Opnum::READ | Opnum::READ_IMPLICIT => self.read_request(received, header, blocks),
            Opnum::WRITE => self.write_request(received, header, blocks, sink),
            Opnum::CONTROL | Opnum::RELEASE => self.control_request(received, header, blocks, sink),
            _ => Ok(CallService::Nothing),
        };
        asked.map_err(|error| error.at_offset(NdrRequest::LENGTH))
    }

    fn connect_request(
        &mut self,
        received: &ReceivedFrame<'_>,
        header: &RpcHeader,
        blocks: &[u8],
    ) -> Result<CallService, WireError> {
        self.calls.forget(header.activity);
        let connect = Connect::parse(blocks)?;
        let macs = (received.header.source, received.header.destination);
        let at = (received.number, received.time);
        let Some((mut ar, link)) = requested_connection(&connect, macs, header.object, at) else {
            return Ok(CallService::Nothing);
        };
        self.remove_ended_routes(ar.controller.mac(), ar.device.mac());
        self.stations.complete(&mut ar.controller);
        self.stations.complete(&mut ar.device);
        Ok(CallService::Connect(self.add(ar, link).map(ArId)))
    }

    fn read_request(
        &mut self,
        received: &ReceivedFrame<'_>,
        header: &RpcHeader,
        blocks: &[u8],
    ) -> Result<CallService, WireError> {
        let record = ReadRequest::parse(blocks)?.header;
        let target = (record.api, record.slot_number, record.subslot_number, record.index);
        Ok(CallService::Read(self.connection(record.ar_uuid, received, header, FrameDirection::ToDevice), target))
    }

    fn write_request(
        &mut self,
        received: &ReceivedFrame<'_>,
        header: &RpcHeader,
        blocks: &[u8],
        sink: Sink<'_>,
    ) -> Result<CallService, WireError> {
        let request = WriteRequest::parse(blocks)?;
        let ar = self.connection(request.header.ar_uuid, received, header, FrameDirection::ToDevice);
        let several = request.records().transpose()?;
        let is_several = several.is_some();
        let records = several.unwrap_or_else(|| vec![request]);
        if let Some(ar) = ar {
            for WriteRequest { header, .. } in &records {
                let target = (header.api, header.slot_number, header.subslot_number, header.index);
                sink(&self.ars, Observation::RecordRequested { ar, target });
            }
        }
        Ok(CallService::Write(ar, records, is_several))
    }

    fn control_request(
        &mut self,
        received: &ReceivedFrame<'_>,
        header: &RpcHeader,
        blocks: &[u8],
        sink: Sink<'_>,
    ) -> Result<CallService, WireError> {
        let block = ControlBlocks::parse(blocks)?.block;
        let kind = block.header.kind;
        let direction = match kind {
            BlockType::APPLICATION_READY_REQ | BlockType::PLUG_APPLICATION_READY_REQ => FrameDirection::ToController,
            _ => FrameDirection::ToDevice,
        };
        let known = self.connection(block.ar_uuid, received, header, direction);
        let Some((id, ar)) = known.and_then(|id| Some((id, self.ars.get_mut(id.0 as usize)?))) else {
            return Ok(CallService::Control(None));
        };
        match (header.opnum, kind) {
            (Opnum::RELEASE, _) | (_, BlockType::RELEASE_REQ) => {
                let first = ar.release_frame.replace(received.number).is_none();
                if ar.stage.stands() {
                    ar.stage = ArStage::Released;
                }
                if first {
                    // The data are invalid from here on, whatever the device answers.
                    sink(&self.ars, Observation::Released { ar: id });
                }
                Ok(CallService::Release(known))
            }
            (_, BlockType::PRM_END_REQ) => {
                ar.parameter_end_frame.get_or_insert(received.number);
                Ok(CallService::ParameterEnd(known))
            }
            (_, BlockType::APPLICATION_READY_REQ) => {
                ar.application_ready_frame.get_or_insert(received.number);
                if ar.stage.stands() {
                    ar.stage = ArStage::Ready;
                }
                sink(&self.ars, Observation::ApplicationReady { ar: id });
                Ok(CallService::Ready(known))
            }
            (_, BlockType::PLUG_APPLICATION_READY_REQ) => {
                let alarm = block.alarm_sequence_number;
                sink(&self.ars, Observation::PlugReady { ar: id, alarm });
                Ok(CallService::Control(known))
            }
            _ => Ok(CallService::Control(known)),
        }
    }

    /// The last connection with this UUID; adds one that was established before the trace began.
    fn connection(
        &mut self,
        uuid: Uuid,
        received: &ReceivedFrame<'_>,
        header: &RpcHeader,
        direction: FrameDirection,
    ) -> Option<ArId> {
        if uuid.is_nil() {
            return None;
        }
        if let Some(&index) = self.by_uuid.get(&uuid) {
            return Some(ArId(index));
        }
        let (source, destination) = (received.header.source, received.header.destination);
        let (controller, device) = match direction {
            FrameDirection::ToDevice => (source, destination),
            FrameDirection::ToController => (destination, source),
        };
        let index = self.add_established(uuid, controller, device)?;
        if let Some(ar) = self.ars.get_mut(index as usize) {
            let called = match direction {
                FrameDirection::ToDevice => &mut ar.device,
                FrameDirection::ToController => &mut ar.controller,
            };
            called.ids = called.ids.or(ids(header.object));
        }
        Some(ArId(index))
    }
}
