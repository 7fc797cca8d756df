//! Processes the requests of calls.

use super::calls::{Asked, CallKey, number};
use super::connect::{asked, ids};
use super::tracker::{Seen, Sink, Tracker};
use super::{ArId, CallPart, Direction, Observation, Stage, Traffic};
use rustc_hash::FxHasher;
use std::hash::Hasher;
use wire::WireError;
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::connect::Connect;
use wire::profinet::blocks::control::Control;
use wire::profinet::blocks::record::{ReadRequest, WriteRequest};
use wire::profinet::rpc::{Header, NdrRequest, Opnum, Uuid};

impl Tracker {
    /// Processes the complete body of a request.
    pub(super) fn request(
        &mut self,
        received: &Seen<'_>,
        header: &Header,
        body: &[u8],
        sink: Sink<'_>,
    ) -> Result<(), WireError> {
        let key = (header.activity, header.sequence);
        let mut hasher = FxHasher::default();
        hasher.write(body);
        let (hash, ars) = (hasher.finish(), &self.ars);
        let over = |ar: ArId| {
            let known = ars.get(ar.0 as usize);
            known.is_none_or(|ar| !matches!(ar.stage, Stage::Asked | Stage::Refused) && !ar.stage.stands())
        };
        if let Some(before) = self.calls.repetition(key, hash, received.time, over) {
            self.counts.repeated += 1;
            if !before.is_copy {
                self.called(received, key, (before.service, before.ar), CallPart::Again, sink);
            }
            return Ok(());
        }
        let outcome = self.asked(received, header, body, sink);
        // Unreadable requests are stored too, so that their repetitions are not reported again.
        let (asked, outcome) = match outcome {
            Ok(asked) => (asked, Ok(())),
            Err(error) => (Asked::Nothing, Err(error)),
        };
        let what = (asked.service(), asked.ar());
        self.calls.ask(key, hash, received.time, asked);
        self.called(received, key, what, CallPart::Asked, sink);
        outcome
    }

    /// Reports a step of a call.
    pub(super) fn called(
        &mut self,
        received: &Seen<'_>,
        key: CallKey,
        (service, ar): (&'static str, Option<ArId>),
        part: CallPart,
        sink: Sink<'_>,
    ) {
        let (source, destination) = (received.header.source, received.header.destination);
        let traffic = Traffic::Call { ar, number: number(key), service, part, source, destination };
        sink(&self.ars, Observation::Traffic(traffic));
    }

    fn asked(&mut self, received: &Seen<'_>, header: &Header, body: &[u8], sink: Sink<'_>) -> Result<Asked, WireError> {
        let (ndr, blocks) = NdrRequest::parse(header.order(), body)?;
        let blocks = blocks.get(..ndr.args_length as usize).unwrap_or(blocks);
        let asked = match header.opnum {
            Opnum::CONNECT => self.connect_request(received, header, blocks),
            Opnum::READ | Opnum::READ_IMPLICIT => self.read_request(received, header, blocks),
            Opnum::WRITE => self.write_request(received, header, blocks),
            Opnum::CONTROL | Opnum::RELEASE => self.control_request(received, header, blocks, sink),
            _ => Ok(Asked::Nothing),
        };
        asked.map_err(|error| error.behind(NdrRequest::LENGTH))
    }

    fn connect_request(&mut self, received: &Seen<'_>, header: &Header, blocks: &[u8]) -> Result<Asked, WireError> {
        self.calls.forget(header.activity);
        let connect = Connect::parse(blocks)?;
        let macs = (received.header.source, received.header.destination);
        let at = (received.number, received.time);
        let Some((mut ar, link)) = asked(&connect, macs, header.object, at) else { return Ok(Asked::Nothing) };
        self.make_way(ar.controller.mac(), ar.device.mac());
        self.stations.complete(&mut ar.controller);
        self.stations.complete(&mut ar.device);
        Ok(Asked::Connect(self.add(ar, link).map(ArId)))
    }

    fn read_request(&mut self, received: &Seen<'_>, header: &Header, blocks: &[u8]) -> Result<Asked, WireError> {
        let record = ReadRequest::parse(blocks)?.header;
        let target = (record.api, record.slot_number, record.subslot_number, record.index);
        Ok(Asked::Read(self.connection(record.ar_uuid, received, header, Direction::ToDevice), target))
    }

    fn write_request(&mut self, received: &Seen<'_>, header: &Header, blocks: &[u8]) -> Result<Asked, WireError> {
        let request = WriteRequest::parse(blocks)?;
        let ar = self.connection(request.header.ar_uuid, received, header, Direction::ToDevice);
        let several = request.records().transpose()?;
        Ok(match several {
            Some(records) => Asked::Write(ar, records, true),
            None => Asked::Write(ar, vec![request], false),
        })
    }

    fn control_request(
        &mut self,
        received: &Seen<'_>,
        header: &Header,
        blocks: &[u8],
        sink: Sink<'_>,
    ) -> Result<Asked, WireError> {
        let block = Control::parse(blocks)?.block;
        let kind = block.header.kind;
        let direction = match kind {
            BlockType::APPLICATION_READY_REQ | BlockType::PLUG_APPLICATION_READY_REQ => Direction::ToController,
            _ => Direction::ToDevice,
        };
        let known = self.connection(block.ar_uuid, received, header, direction);
        let Some((id, ar)) = known.and_then(|id| Some((id, self.ars.get_mut(id.0 as usize)?))) else {
            return Ok(Asked::Control(None));
        };
        match (header.opnum, kind) {
            (Opnum::RELEASE, _) | (_, BlockType::RELEASE_REQ) => {
                let first = ar.release_frame.replace(received.number).is_none();
                if ar.stage.stands() {
                    ar.stage = Stage::Released;
                }
                if first {
                    // The data are invalid from here on, whatever the device answers.
                    sink(&self.ars, Observation::Released { ar: id });
                }
                Ok(Asked::Release(known))
            }
            (_, BlockType::PRM_END_REQ) => {
                ar.parameter_end_frame.get_or_insert(received.number);
                Ok(Asked::ParameterEnd(known))
            }
            (_, BlockType::APPLICATION_READY_REQ) => {
                ar.application_ready_frame.get_or_insert(received.number);
                if ar.stage.stands() {
                    ar.stage = Stage::Ready;
                }
                sink(&self.ars, Observation::ApplicationReady { ar: id });
                Ok(Asked::Ready(known))
            }
            _ => Ok(Asked::Control(known)),
        }
    }

    /// The last connection with this UUID; adds one that was established before the trace began.
    fn connection(&mut self, uuid: Uuid, received: &Seen<'_>, header: &Header, direction: Direction) -> Option<ArId> {
        if uuid.is_nil() {
            return None;
        }
        if let Some(&index) = self.by_uuid.get(&uuid) {
            return Some(ArId(index));
        }
        let (source, destination) = (received.header.source, received.header.destination);
        let (controller, device) = match direction {
            Direction::ToDevice => (source, destination),
            Direction::ToController => (destination, source),
        };
        let index = self.meet(uuid, controller, device)?;
        if let Some(ar) = self.ars.get_mut(index as usize) {
            let called = match direction {
                Direction::ToDevice => &mut ar.device,
                Direction::ToController => &mut ar.controller,
            };
            called.ids = called.ids.or(ids(header.object));
        }
        Some(ArId(index))
    }
}
