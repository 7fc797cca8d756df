//! Each format of PROFINET and PROFIdrive alone; the first byte says which. What was read is written and read again, and is the same.
#![no_main]

use encspec_fuzz::twice;
use wire::datagram::{Datagram, arp::Arp};
use wire::ethernet::FrameHeader;
use wire::http::{HttpRequest, HttpResponse};
use wire::lldp::Lldp;
use wire::profidrive::{ParameterRequest, ParameterResponse};
use wire::profinet::alarm::RtaPdu;
use wire::profinet::blocks::{connect, control, identification, im, module_diff, physical, record};
use wire::profinet::dcp::Dcp;
use wire::profinet::diagnosis::DiagnosisData;
use wire::profinet::rpc::{NdrRequest, NdrResponse, RpcPdu};
use wire::profinet::rt::CyclicFrame;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let Some((which, octets)) = data.split_first() else { return };
    let order = wire::octets::ByteOrder::Little;
    match which % 22 {
        0 => twice!(Dcp::parse, octets),
        1 => twice!(RtaPdu::parse, octets),
        2 => twice!(connect::Connect::parse, octets),
        3 => twice!(control::ControlBlocks::parse, octets),
        4 => twice!(record::ReadRequest::parse, octets),
        5 => twice!(record::ReadResponse::parse, octets),
        6 => twice!(record::WriteRequest::parse, octets),
        7 => drop(record::WriteResponse::parse_all(octets)),
        8 => twice!(im::Im0::parse, octets),
        9 => twice!(im::ImText::parse, octets),
        10 => twice!(module_diff::ModuleDiffBlock::parse, octets),
        11 => twice!(physical::InterfaceDataReal::parse, octets),
        12 => twice!(physical::PortDataReal::parse, octets),
        13 => drop(physical::MultipleBlock::parse_record(octets)),
        14 => drop(identification::IdentificationData::parse_record(octets)),
        15 => drop(DiagnosisData::parse_record(octets)),
        16 => twice!(ParameterRequest::parse, octets),
        17 => twice!(ParameterResponse::parse, octets),
        18 => twice!(Lldp::parse, octets),
        19 => {
            if let Ok(pdu) = RpcPdu::parse(octets) {
                drop(NdrRequest::parse(order, pdu.body));
                let _ = NdrResponse::parse(order, pdu.body);
            }
        }
        20 => {
            drop(HttpRequest::read(octets));
            drop(HttpResponse::read(octets, true));
        }
        _ => {
            let _ = Datagram::parse(octets);
            let _ = FrameHeader::parse(octets);
            let _ = CyclicFrame::parse_to_end(octets);
            twice!(Arp::parse, octets);
        }
    }
});
