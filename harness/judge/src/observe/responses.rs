//! Processes the responses to calls.

use super::calls::CallService;
use super::connect::accepted;
use super::tracker::{ReceivedFrame, Sink, Tracker};
use super::{ArId, ArStage, CallPart, Observation, StartRecord, Traffic};
use wire::WireError;
use wire::datagram::{Checksum, Datagram};
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
        let call = (asked.service(), asked.ar());
        let needs_blocks = !matches!(asked, CallService::Connect(None) | CallService::Nothing);
        let has_none = |(ndr, blocks): (NdrResponse, &[u8])| {
            ndr.status.is_ok() && (ndr.args_length == 0 || blocks.is_empty()) && needs_blocks
        };
        let is_empty = NdrResponse::parse(header.order(), body).is_ok_and(has_none);
        let outcome = self.outcome(received, header, body, asked, sink);
        match &outcome {
            _ if is_empty => self.malformed(received, call, "it has no block", sink),
            Err(error) => self.malformed(received, call, &error.to_string(), sink),
            Ok(()) => {}
        }
        outcome
    }

    /// Processes the body of a response to a known request.
    fn outcome(
        &mut self,
        received: &ReceivedFrame<'_>,
        header: &RpcHeader,
        body: &[u8],
        asked: CallService,
        sink: Sink<'_>,
    ) -> Result<(), WireError> {
        let (ndr, blocks) = NdrResponse::parse(header.order(), body)?;
        let blocks = blocks.get(..ndr.args_length as usize).unwrap_or(blocks);
        let outcome = match asked {
            CallService::Connect(Some(ar)) => self.connect_response(received, ar, ndr.status, blocks, sink),
            CallService::Read(ar, target) => self.read_response(ar, target, ndr.status, blocks, sink),
            CallService::Write(ar, records, several) => {
                self.write_response(received, (ar, &records, several), ndr.status, blocks, sink)
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
        let requested = usize::from(link.input_reference.is_some()) + usize::from(link.output_reference.is_some());
        let missing = match (connect.ar_res(), connect.iocr_responses().count()) {
            _ if blocks.is_empty() => None,
            (None, _) => Some("it has no ARBlockRes".to_owned()),
            (Some(_), granted) if granted < requested => Some(format!("it has {granted} of {requested} IOCRBlockRes")),
            _ => None,
        };
        accepted(&connect, ar, link);
        self.stations.complete(&mut ar.device);
        let (controllers, devices) = ([link.macs.0, ar.controller.mac()], [received.header.source, ar.device.mac()]);
        self.stands_between(id.0, controllers, devices);
        sink(&self.ars, Observation::Connected { ar: id });
        if let Some(why) = missing {
            self.malformed(received, ("Connect", Some(id)), &why, sink);
        }
        let diff = connect.block(BlockType::MODULE_DIFF);
        if let Some(diff) = diff.and_then(|octets| ModuleDiffBlock::read(&mut ByteReader::new("block", &octets)).ok()) {
            sink(&self.ars, Observation::Traffic(Traffic::ModulesDiffer { ar: id, diff: &diff }));
        }
        Ok(())
    }

    /// Reports a response that is empty, or that cannot be read; in a recording only.
    fn malformed(
        &mut self,
        received: &ReceivedFrame<'_>,
        (service, ar): (&'static str, Option<ArId>),
        why: &str,
        sink: Sink<'_>,
    ) {
        let checksum = Datagram::parse(received.octets).map_or(Checksum::Bad, |datagram| datagram.udp_checksum);
        // A datagram with a wrong checksum was damaged on its way.
        if self.is_recorded && checksum != Checksum::Bad {
            let (source, destination) = (received.header.source, received.header.destination);
            let is_proven = checksum == Checksum::Good;
            let answer = Traffic::AnswerMalformed { ar, service, source, destination, is_proven, why };
            sink(&self.ars, Observation::Traffic(answer));
        }
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
        received: &ReceivedFrame<'_>,
        (ar, records, several): (Option<ArId>, &[WriteRequest], bool),
        status: PnioStatus,
        blocks: &[u8],
        sink: Sink<'_>,
    ) -> Result<(), WireError> {
        let answers = if status.is_ok() { WriteResponse::parse_all(blocks)? } else { Vec::new() };
        let answers = answers.get(usize::from(several)..).unwrap_or_default();
        if status.is_ok() && !blocks.is_empty() && answers.len() < records.len() {
            let why = format!("it answers {} of {} records", answers.len(), records.len());
            self.malformed(received, ("Write", ar), &why, sink);
        }
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
