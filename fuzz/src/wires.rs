//! Formats of the wire alone: the first byte says which. What was read is written and read again, and is the same.

use crate::twice;
use wire::datagram::icmp::IcmpEcho;
use wire::datagram::{Datagram, arp::Arp};
use wire::ethernet::FrameHeader;
use wire::http::{HttpRequest, HttpResponse};
use wire::lldp::Lldp;
use wire::octets::ByteOrder;
use wire::profibus::address::SetSlaveAddress;
use wire::profibus::call::{Call, DpIm0};
use wire::profibus::cfg::Identifier;
use wire::profibus::diag::{DiagnosisMessage, SlaveDiag};
use wire::profibus::dpv1::{Dpv1Pdu, PduDirection};
use wire::profibus::fdl::FdlFrame;
use wire::profibus::global_control::GlobalControl;
use wire::profibus::prm::{Isochronous, PrmBlock, SetPrm};
use wire::profidrive::{ParameterRequest, ParameterResponse};
use wire::profinet::alarm::RtaPdu;
use wire::profinet::blocks::{RawBlock, connect, control, identification, im, module_diff, physical, record};
use wire::profinet::dcp::Dcp;
use wire::profinet::diagnosis::DiagnosisData;
use wire::profinet::rpc::{
    Cancel, CancelAck, Fack, LookupRequest, LookupResponse, NdrRequest, NdrResponse, RejectStatus, RpcPdu,
};
use wire::profinet::rt::CyclicFrame;
use wire::snmp::SnmpMessage;

/// PROFINET, PROFIdrive, SNMP and HTTP.
pub fn profinet(data: &[u8]) {
    let Some((which, octets)) = data.split_first() else { return };
    match which % 25 {
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
        19 => rpc(octets),
        20 => {
            drop(HttpRequest::read(octets));
            drop(HttpResponse::read(octets, true));
        }
        21 => {
            if let Ok(first) = SnmpMessage::parse(octets) {
                assert_eq!(SnmpMessage::parse(&first.to_vec()).as_ref(), Ok(&first));
            }
        }
        22 => twice!(identification::ApiData::parse, octets),
        23 => twice!(RawBlock::parse, octets),
        _ => {
            let _ = Datagram::parse(octets);
            let _ = FrameHeader::parse(octets);
            let _ = IcmpEcho::parse(octets);
            let _ = CyclicFrame::parse_to_end(octets);
            twice!(Arp::parse, octets);
        }
    }
}

/// A PDU of RPC, and its body as everything that a body can be.
fn rpc(octets: &[u8]) {
    let Ok(pdu) = RpcPdu::parse(octets) else { return };
    for order in [ByteOrder::Little, ByteOrder::Big] {
        let _ = NdrRequest::parse(order, pdu.body);
        let _ = NdrResponse::parse(order, pdu.body);
        let _ = RejectStatus::parse(order, pdu.body);
        drop(Fack::parse(order, pdu.body));
        let _ = Cancel::parse(order, pdu.body);
        let _ = CancelAck::parse(order, pdu.body);
        let _ = LookupRequest::parse(order, pdu.body);
        drop(LookupResponse::parse(order, pdu.body));
    }
}

/// PROFIBUS, from a telegram of FDL to the services of DP-V1.
pub fn profibus(data: &[u8]) {
    let Some((which, octets)) = data.split_first() else { return };
    match which % 11 {
        0 => twice!(FdlFrame::parse, octets),
        1 => twice!(SlaveDiag::parse, octets),
        2 => twice!(DiagnosisMessage::parse, octets),
        3 => twice!(SetPrm::parse, octets),
        4 => drop(PrmBlock::parse_all(octets)),
        5 => twice!(Isochronous::parse, octets),
        6 => drop(Identifier::parse_all(octets)),
        7 => twice!(|octets| Dpv1Pdu::parse(octets, PduDirection::Request), octets),
        8 => twice!(|octets| Dpv1Pdu::parse(octets, PduDirection::Response), octets),
        9 => {
            twice!(Call::parse, octets);
            twice!(DpIm0::parse, octets);
        }
        _ => {
            twice!(GlobalControl::parse, octets);
            twice!(SetSlaveAddress::parse, octets);
        }
    }
}
