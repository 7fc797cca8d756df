//! Acyclic services of PROFIBUS: DP-V1 records and Set_Slave_Address.
//!
//! The master requests a record in one frame and polls for the response; until then the slave only acknowledges.

use super::super::tracker::Sink;
use super::super::{ArId, Dp, Observation, PollFault};
use super::{DpAnswer, DpTracker, PendingDpRequest, TrackedSlave};
use wire::profibus::address::SetSlaveAddress;
use wire::profibus::dpv1::{Dpv1Function, Dpv1Pdu, Dpv1Record, Dpv1Refusal, PduDirection};
use wire::profibus::sap::SapService;
use wire::profinet::status::{ErrorCode, ErrorDecode, PnioStatus};

/// Maximum number of pending requests of one slave; further ones are not reported.
const MOST_OPEN: usize = 16;

/// A pending record request.
#[derive(Clone, Debug)]
pub(super) struct Acyclic {
    master: u8,
    service: SapService,
    record: Dpv1Record,
    written: bool,
}

impl DpTracker {
    pub(super) fn acyclic(&mut self, asked: &PendingDpRequest, answer: DpAnswer<'_>, sink: Sink<'_>) {
        let slave = &mut self.slaves[usize::from(asked.da)];
        let ar = slave.ar.map(ArId);
        match Dpv1Pdu::parse(&asked.data, PduDirection::Request) {
            Ok(Dpv1Pdu::Read(record)) => slave.ask(asked, record, false),
            Ok(Dpv1Pdu::Write(record)) => slave.ask(asked, record, true),
            _ => {}
        }
        if !answer.function.has_data() {
            return;
        }
        let said = match Dpv1Pdu::parse(answer.data, PduDirection::Response) {
            Ok(said) => said,
            Err(_) if self.is_recorded => {
                let fault = PollFault::Unreadable { octets: answer.data.len() };
                return self.fault((asked.sa, asked.da, asked.service), fault, sink);
            }
            Err(error) => {
                return sink(&self.ars, Observation::Unreadable { why: &error.at_offset(answer.at).to_string() });
            }
        };
        let own = |open: &Acyclic| (open.master, open.service) == (asked.sa, asked.service);
        let (data, written, status): (&[u8], _, _) = match &said {
            Dpv1Pdu::Read(read) => (&read.data, false, PnioStatus::OK),
            Dpv1Pdu::Write(_) => (&[], true, PnioStatus::OK),
            Dpv1Pdu::Refused(refusal) => (&[], refusal.function == Dpv1Function::WRITE_REFUSED, status(refusal)),
            _ => return,
        };
        let Some(place) = slave.acyclic.iter().position(|open| own(open) && open.written == written) else { return };
        let open = slave.acyclic.remove(place);
        let target = (0, open.record.slot.into(), 0, open.record.index.into());
        let data = if written { &open.record.data } else { data };
        sink(&self.ars, Observation::Record { ar, written, target, data, status });
    }

    pub(super) fn address_given(&mut self, asked: &PendingDpRequest, sink: Sink<'_>) {
        let Ok(given) = SetSlaveAddress::parse(&asked.data) else { return };
        let (master, station) = (asked.sa, asked.da);
        let event = Dp::AddressGiven { master, station, address: given.address, ident: given.ident };
        sink(&self.ars, Observation::Dp { ar: None, event });
    }
}

impl TrackedSlave {
    fn ask(&mut self, asked: &PendingDpRequest, record: Dpv1Record, written: bool) {
        self.acyclic.retain(|open| (open.master, open.service) != (asked.sa, asked.service));
        if self.acyclic.len() < MOST_OPEN {
            self.acyclic.push(Acyclic { master: asked.sa, service: asked.service, record, written });
        }
    }
}

/// A negative response of DP-V1 as PNIO status, which uses the same codes.
fn status(refusal: &Dpv1Refusal) -> PnioStatus {
    PnioStatus {
        error_code: ErrorCode(refusal.function.0),
        error_decode: ErrorDecode(refusal.decode.0),
        error_code1: refusal.code_1,
        error_code2: refusal.code_2,
    }
}
