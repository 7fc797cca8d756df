//! Processes the responses to calls.

use super::calls::CallService;
use super::connect::accepted;
use super::tracker::{ReceivedFrame, Sink, Tracker};
use super::{ArId, ArStage, CallPart, Observation, StartRecord, Traffic};
use wire::WireError;
use wire::octets::ByteReader;
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::connect::Connect;
use wire::profinet::blocks::module_diff::ModuleDiffBlock;
use wire::profinet::blocks::record::{ReadResponse, WriteRequest, WriteResponse};
use wire::profinet::rpc::{NdrResponse, PacketType, RejectStatus, RpcHeader};
use wire::profinet::status::PnioStatus;

/// Maximum length of the stored start records of a connection in bytes.
const MOST_RECORD_OCTETS: usize = 1 << 16;

impl Tracker {
    /// Processes the complete body of a response.
    pub(super) fn response(
        &mut self,
        received: &ReceivedFrame<'_>,
        header: &RpcHeader,
        body: &[u8],
        sink: Sink<'_>,
    ) -> Result<(), WireError> {
        let Some(asked) = self.answered(received, header, sink) else { return Ok(()) };
        let (ndr, blocks) = NdrResponse::parse(header.order(), body)?;
        let blocks = blocks.get(..ndr.args_length as usize).unwrap_or(blocks);
        let outcome = match asked {
            CallService::Connect(Some(ar)) => self.connect_response(received, ar, ndr.status, blocks, sink),
            CallService::Read(ar, target) => self.read_response(ar, target, ndr.status, blocks, sink),
            CallService::Write(ar, records, several) => {
                self.write_response(ar, &records, several, ndr.status, blocks, sink)
            }
            CallService::ParameterEnd(ar) => {
                match ar {
                    Some(ar) if ndr.status.is_ok() => self.parameters_ended(ar, sink),
                    ar => self.refused(ar, "end of parameters", ndr.status, sink),
                }
                Ok(())
            }
            CallService::Release(ar) => {
                self.refused(ar, "Release", ndr.status, sink);
                Ok(())
            }
            CallService::Ready(ar) => {
                self.refused(ar, "ApplicationReady", ndr.status, sink);
                Ok(())
            }
            CallService::Control(ar) => {
                self.refused(ar, "Control", ndr.status, sink);
                Ok(())
            }
            CallService::Connect(None) | CallService::Nothing => Ok(()),
        };
        outcome.map_err(|error| error.at_offset(NdrResponse::LENGTH))
    }

    /// The call that a response answers, which is reported; `None` without a request.
    fn answered(&mut self, received: &ReceivedFrame<'_>, header: &RpcHeader, sink: Sink<'_>) -> Option<CallService> {
        let key = (header.activity, header.sequence);
        let asked = self.calls.answer(key)?;
        self.report_call(received, key, (asked.service(), asked.ar()), CallPart::Answered, sink);
        Some(asked)
    }

    fn connect_response(
        &mut self,
        received: &ReceivedFrame<'_>,
        id: ArId,
        status: PnioStatus,
        blocks: &[u8],
        sink: Sink<'_>,
    ) -> Result<(), WireError> {
        let index = id.0 as usize;
        let (Some(ar), Some(link)) = (self.ars.get_mut(index), self.links.get_mut(index)) else { return Ok(()) };
        if ar.stage != ArStage::Asked {
            return Ok(());
        }
        if !status.is_ok() {
            ar.stage = ArStage::Refused;
            ar.submodules = Vec::new();
            sink(&self.ars, Observation::ConnectRefused { ar: id, status });
            return Ok(());
        }
        let connect = Connect::parse(blocks)?;
        accepted(&connect, ar, link);
        self.stations.complete(&mut ar.device);
        let (controllers, devices) = ([link.macs.0, ar.controller.mac()], [received.header.source, ar.device.mac()]);
        self.stands_between(id.0, controllers, devices);
        sink(&self.ars, Observation::Connected { ar: id });
        let diff = connect.block(BlockType::MODULE_DIFF);
        if let Some(diff) = diff.and_then(|octets| ModuleDiffBlock::read(&mut ByteReader::new("block", &octets)).ok()) {
            sink(&self.ars, Observation::Traffic(Traffic::ModulesDiffer { ar: id, diff: &diff }));
        }
        Ok(())
    }

    fn read_response(
        &mut self,
        ar: Option<ArId>,
        target: (u32, u16, u16, u16),
        status: PnioStatus,
        blocks: &[u8],
        sink: Sink<'_>,
    ) -> Result<(), WireError> {
        let response = if status.is_ok() { ReadResponse::parse(blocks)? } else { ReadResponse::default() };
        let data = response.record();
        sink(&self.ars, Observation::Record { ar, written: false, target, data, status });
        Ok(())
    }

    fn write_response(
        &mut self,
        ar: Option<ArId>,
        records: &[WriteRequest],
        several: bool,
        status: PnioStatus,
        blocks: &[u8],
        sink: Sink<'_>,
    ) -> Result<(), WireError> {
        let answers = if status.is_ok() { WriteResponse::parse_all(blocks)? } else { Vec::new() };
        let answers = answers.get(usize::from(several)..).unwrap_or_default();
        for (place, record) in records.iter().enumerate() {
            let header = &record.header;
            let target = (header.api, header.slot_number, header.subslot_number, header.index);
            // A missing WriteResponse is not a refusal of the record.
            let status =
                if status.is_ok() { answers.get(place).map_or(status, |answer| answer.status) } else { status };
            self.keep(ar, target, &record.data, status.is_ok());
            sink(&self.ars, Observation::Record { ar, written: true, target, data: &record.data, status });
        }
        Ok(())
    }

    fn keep(&mut self, ar: Option<ArId>, target: (u32, u16, u16, u16), data: &[u8], accepted: bool) {
        let Some(index) = ar.map(|ar| ar.0 as usize) else { return };
        let (Some(ar), Some(link)) = (self.ars.get_mut(index), self.links.get_mut(index)) else { return };
        let cost = data.len() + size_of::<StartRecord>();
        if ar.stage == ArStage::Connected && link.record_octets + cost <= MOST_RECORD_OCTETS {
            link.record_octets += cost;
            ar.start_records.push(StartRecord { target, data: data.to_vec(), accepted });
        }
    }

    fn parameters_ended(&mut self, id: ArId, sink: Sink<'_>) {
        if let Some(ar) = self.ars.get_mut(id.0 as usize).filter(|ar| ar.stage == ArStage::Connected) {
            ar.stage = ArStage::Parameterised;
        }
        sink(&self.ars, Observation::ParameterEnd { ar: id });
    }

    fn refused(&mut self, ar: Option<ArId>, service: &'static str, status: PnioStatus, sink: Sink<'_>) {
        if !status.is_ok() {
            sink(&self.ars, Observation::CallFailed { ar, service, why: &status.to_string() });
        }
    }

    /// Processes an RPC fault or reject.
    pub(super) fn failed(
        &mut self,
        received: &ReceivedFrame<'_>,
        header: &RpcHeader,
        body: &[u8],
        sink: Sink<'_>,
    ) -> Result<(), WireError> {
        let Some(asked) = self.answered(received, header, sink) else { return Ok(()) };
        let (service, ar) = (asked.service(), asked.ar());
        let status = RejectStatus::parse(header.order(), body)?;
        if service == "Connect"
            && let Some(ar) = ar.and_then(|ar| self.ars.get_mut(ar.0 as usize))
        {
            ar.stage = ArStage::Refused;
        }
        let kind = if header.packet_type == PacketType::REJECT { "reject" } else { "fault" };
        let why = match status.word() {
            Some(word) => format!("{kind}: {word} ({:#010x})", status.0),
            None => format!("{kind}: {:#010x}", status.0),
        };
        sink(&self.ars, Observation::CallFailed { ar, service, why: &why });
        Ok(())
    }
}
