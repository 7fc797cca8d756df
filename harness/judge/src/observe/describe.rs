//! Formats an Ethernet frame as one line, for the trace around a failure and for listings.
//!
//! Text from stations is escaped. An unreadable frame gets a line with the error.

use super::{FrameDirection, ObservedAr, SubmodulePlacement};
use plain_text::{escaped, hex_start};
use std::fmt::Write as _;
use wire::datagram::arp::{Arp, ArpOperation};
use wire::datagram::{Datagram, Ipv4};
use wire::ethernet::{EtherType, FrameHeader, Mac};
use wire::lldp::{Lldp, Tlv};
use wire::profinet::alarm::{AlarmPriority, RtaBody, RtaPdu};
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::connect::{ArType, Connect};
use wire::profinet::blocks::control::ControlBlocks;
use wire::profinet::blocks::record::{ReadRequest, ReadResponse, RecordHeader, WriteRequest, WriteResponse};
use wire::profinet::dcp::{Dcp, DcpValue, ServiceId, ServiceType};
use wire::profinet::rpc::{
    Flags1, NdrRequest, NdrResponse, Opnum, PORT, PacketType, RejectStatus, RpcHeader, RpcPdu, Uuid,
};
use wire::profinet::rt::{CyclicFrame, DataStatus, FrameId, FrameKind};

/// Maximum number of data bytes in a line.
const MOST_OCTETS: usize = 48;

/// Formats a frame as one line without a line break; `ars` are the known connections.
pub fn describe(octets: &[u8], ars: &[ObservedAr]) -> String {
    let (header, payload) = match FrameHeader::parse(octets) {
        Ok(parsed) => parsed,
        Err(error) => return error.to_string(),
    };
    match header.ether_type {
        EtherType::PROFINET => profinet(&header, payload, ars),
        EtherType::IPV4 => datagram(octets),
        EtherType::ARP => arp(payload),
        EtherType::LLDP => lldp(payload),
        EtherType(other) => format!("EtherType {other:#06x} ({} bytes)", payload.len()),
    }
}

fn profinet(header: &FrameHeader, payload: &[u8], ars: &[ObservedAr]) -> String {
    let frame_id = match FrameId::peek(payload) {
        Ok(frame_id) => frame_id,
        Err(error) => return error.to_string(),
    };
    match frame_id.kind() {
        _ if frame_id.is_cyclic() => cyclic(header, payload, frame_id, ars),
        FrameKind::AlarmHigh | FrameKind::AlarmLow => alarm(frame_id, payload.get(2..).unwrap_or_default()),
        FrameKind::DcpHello | FrameKind::DcpGetSet | FrameKind::DcpIdentifyRequest | FrameKind::DcpIdentifyResponse => {
            dcp(payload)
        }
        FrameKind::Ptcp => format!("PTCP {:#06x}", frame_id.0),
        FrameKind::Rsi => "RSI".into(),
        FrameKind::Fragment => format!("fragment of a frame {:#06x}", frame_id.0),
        _ => format!("PROFINET frame {:#06x} ({} bytes)", frame_id.0, payload.len()),
    }
}

/// `RT out 0xC000 cycle 12345 04 00 20 00 | 80 80`: data of all submodules, then their status bytes.
fn cyclic(header: &FrameHeader, payload: &[u8], frame_id: FrameId, ars: &[ObservedAr]) -> String {
    let found = stream_of(ars, (header.source, header.destination), frame_id);
    let parsed = match found {
        Some((ar, direction)) => CyclicFrame::parse(payload, ar.stream(direction).data_length),
        None => CyclicFrame::parse_to_end(payload),
    };
    let word = match found {
        Some((_, FrameDirection::ToController)) => "in ",
        Some((_, FrameDirection::ToDevice)) => "out ",
        None => "",
    };
    let mut line = format!("RT {word}0x{:04X}", frame_id.0);
    let frame = match parsed {
        Ok(frame) => frame,
        Err(error) => return format!("{line}: {error}"),
    };
    let _ = write!(line, " cycle {} ", frame.status.cycle_counter);
    match found {
        Some((ar, direction)) if !ar.submodules.is_empty() => {
            let (data, status) = areas(&ar.submodules, direction, frame.data);
            line += &hex(&data);
            line += " | ";
            line += &hex(&status);
        }
        _ => line += &hex(frame.data),
    }
    if frame.status.data_status != DataStatus::NORMAL {
        let _ = write!(line, " data status {:#04x}", frame.status.data_status.0);
    }
    if frame.status.transfer_status != 0 {
        let _ = write!(line, " transfer status {:#04x}", frame.status.transfer_status);
    }
    line
}

/// The latest connection of a cyclic frame, and its direction; `way` is source and destination.
pub(super) fn stream_of(
    ars: &[ObservedAr],
    way: (Mac, Mac),
    frame_id: FrameId,
) -> Option<(&ObservedAr, FrameDirection)> {
    ars.iter().rev().find_map(|ar| {
        let (device, controller) = (ar.device.mac(), ar.controller.mac());
        if (way, frame_id.0) == ((device, controller), ar.inputs.frame_id) {
            Some((ar, FrameDirection::ToController))
        } else if (way, frame_id.0) == ((controller, device), ar.outputs.frame_id) {
            Some((ar, FrameDirection::ToDevice))
        } else {
            None
        }
    })
}

/// Data of the submodules and all status bytes of one direction, each in frame order.
fn areas(submodules: &[SubmodulePlacement], direction: FrameDirection, data: &[u8]) -> (Vec<u8>, Vec<u8>) {
    let (mut areas, mut places) = (Vec::new(), Vec::new());
    for placed in submodules {
        let (area, status, consumer) = match direction {
            FrameDirection::ToController => (&placed.input, placed.input_status, placed.output_consumer),
            FrameDirection::ToDevice => (&placed.output, placed.output_status, placed.input_consumer),
        };
        areas.extend(area.clone());
        places.extend(status);
        places.extend(consumer);
    }
    areas.sort_by_key(|area| area.start);
    places.sort_unstable();
    let octets = areas.into_iter().filter_map(|area| data.get(area)).flatten().copied().collect();
    (octets, places.into_iter().filter_map(|at| data.get(at).copied()).collect())
}

fn alarm(frame_id: FrameId, payload: &[u8]) -> String {
    let priority = match AlarmPriority::from_frame_id(frame_id.0) {
        Some(AlarmPriority::High) => "alarm high",
        _ => "alarm low",
    };
    let pdu = match RtaPdu::parse(payload) {
        Ok(pdu) => pdu,
        Err(error) => return format!("{priority}: {error}"),
    };
    let sequence = format!("sequence {:#06x}, acknowledges {:#06x}", pdu.header.send_seq_num, pdu.header.ack_seq_num);
    match &pdu.body {
        RtaBody::Notification(alarm) => {
            let kind = alarm.alarm_type.word().map_or_else(|| format!("{:#06x}", alarm.alarm_type.0), str::to_owned);
            let mut line = format!("{priority} {kind} slot {} subslot {:#06x}", alarm.slot, alarm.subslot);
            for channel in alarm.items.iter().flat_map(|item| item.channels()) {
                let (severity, change) = (channel.properties.severity().word(), channel.properties.change().word());
                let _ = write!(line, ", channel {:#06x} error ", channel.channel);
                match channel.error_type.word() {
                    Some(word) => line += word,
                    None => {
                        let _ = write!(line, "{:#06x}", channel.error_type.0);
                    }
                }
                let _ = write!(line, " {severity} {change}");
            }
            format!("{line}, {sequence}")
        }
        RtaBody::Acknowledgement(acknowledgement) => {
            format!("{priority} acknowledged by the application: {}, {sequence}", acknowledgement.status)
        }
        RtaBody::Error { status, .. } => format!("{priority} ERR-RTA {status}"),
        RtaBody::Octets(_) => {
            let kind = pdu.header.kind.word().map_or_else(|| pdu.header.kind.0.to_string(), str::to_uppercase);
            format!("{priority} RTA {kind}, {sequence}")
        }
    }
}

fn dcp(payload: &[u8]) -> String {
    let pdu = match Dcp::parse(payload) {
        Ok(pdu) => pdu,
        Err(error) => return error.to_string(),
    };
    let service = service(pdu.service_id).map_or_else(|| format!("service {}", pdu.service_id.0), str::to_owned);
    let mut line = format!("DCP {service}");
    match pdu.service_type {
        ServiceType::REQUEST if pdu.service_id == ServiceId::HELLO => {}
        ServiceType::REQUEST => line += " request",
        ServiceType::RESPONSE => line += " response",
        ServiceType::NOT_SUPPORTED => line += " not supported",
        ServiceType(other) => {
            let _ = write!(line, " type {other}");
        }
    }
    let values = match pdu.blocks() {
        [] => pdu.elements().map(element).collect(),
        blocks => blocks.iter().map(|block| value(&block.value)).collect::<Vec<_>>(),
    };
    if !values.is_empty() {
        let _ = write!(line, " {}", values.join(", "));
    }
    line
}

/// The name of a DCP service; `None` if unknown.
pub(super) fn service(id: ServiceId) -> Option<&'static str> {
    Some(match id {
        ServiceId::GET => "Get",
        ServiceId::SET => "Set",
        ServiceId::IDENTIFY => "Identify",
        ServiceId::HELLO => "Hello",
        _ => return None,
    })
}

/// The name of a DCP element, or its option and suboption numbers.
pub(super) fn element(element: wire::profinet::dcp::Element) -> String {
    element.word().map_or_else(|| format!("{}/{}", element.option, element.suboption), str::to_owned)
}

fn value(value: &DcpValue) -> String {
    match value {
        DcpValue::Mac(mac) => format!("MAC {mac}"),
        DcpValue::IpParameter(ip) | DcpValue::FullIpSuite(ip, _) => {
            format!("IP {}/{} via {}", ip.address, ip.mask, ip.gateway)
        }
        DcpValue::Vendor(text) => format!("type '{}'", escaped(text)),
        DcpValue::NameOfStation(text) => format!("name '{}'", escaped(text)),
        DcpValue::AliasName(text) => format!("alias '{}'", escaped(text)),
        DcpValue::DeviceId { vendor_id, device_id } => format!("device {vendor_id:#06x}/{device_id:#06x}"),
        DcpValue::DeviceRole { role, .. } => format!("role {role:#04x}"),
        DcpValue::Response { element: of, error } => {
            let word = error.word().map_or_else(|| error.0.to_string(), str::to_owned);
            format!("{} {word}", element(*of))
        }
        other => element(other.element()),
    }
}

fn datagram(octets: &[u8]) -> String {
    let datagram = match Datagram::parse(octets) {
        Ok(datagram) => datagram,
        Err(_) => return segment(octets).unwrap_or_else(|| "IPv4".into()),
    };
    let on_port = datagram.source.port() == PORT || datagram.destination.port() == PORT;
    match RpcPdu::parse(datagram.payload) {
        Ok(pdu) => rpc(&pdu),
        Err(error) if on_port => error.to_string(),
        Err(_) => format!("UDP {} to {} ({} bytes)", datagram.source, datagram.destination, datagram.payload.len()),
    }
}

/// Formats a TCP packet: addresses, flags and the first line of its data.
fn segment(octets: &[u8]) -> Option<String> {
    let (_, packet) = Ipv4::of_frame(octets).filter(|(_, packet)| packet.protocol == Ipv4::TCP)?;
    let (head, _) = packet.payload.split_first_chunk::<20>()?;
    let port = |at: usize| u16::from_be_bytes([head[at], head[at + 1]]);
    let flags = [(0x02, " SYN"), (0x01, " FIN"), (0x04, " RST")];
    let flags: String = flags.iter().filter(|(bit, _)| head[13] & bit != 0).map(|(_, word)| *word).collect();
    let data = packet.payload.get(usize::from(head[12] >> 4) * 4..).unwrap_or_default();
    let line = data.split(|octet| *octet == b'\r').next().unwrap_or_default();
    let line = if line.is_empty() { String::new() } else { format!(" '{}'", escaped(&line[..line.len().min(60)])) };
    let (from, to) = (packet.source, packet.destination);
    Some(format!("TCP {from}:{} to {to}:{}{flags} ({} bytes){line}", port(0), port(2), data.len()))
}

fn rpc(pdu: &RpcPdu<'_>) -> String {
    let header = &pdu.header;
    let kind = header.packet_type.word().map_or_else(|| format!("type {}", header.packet_type.0), str::to_owned);
    if header.interface == Uuid::ENDPOINT_MAPPER {
        return format!("RPC endpoint mapper {kind}");
    }
    let service = operation(header.opnum).map_or_else(|| format!("operation {}", header.opnum.0), str::to_owned);
    let head = match header.packet_type {
        PacketType::REQUEST | PacketType::RESPONSE if header.opnum.0 > 1 && header.opnum.0 < 6 => {
            format!("PNIO {service}")
        }
        _ => format!("RPC {service} {kind}"),
    };
    if header.flags1.has(Flags1::FRAGMENT) {
        let last = if header.flags1.has(Flags1::LAST_FRAGMENT) { ", the last" } else { "" };
        return format!("RPC {service} {kind} fragment {}{last}", header.fragment);
    }
    let detail = match header.packet_type {
        PacketType::REQUEST => request(header, pdu.body),
        PacketType::RESPONSE => response(header, pdu.body),
        PacketType::FAULT | PacketType::REJECT => RejectStatus::parse(header.order(), pdu.body)
            .map(|status| status.word().map_or_else(|| format!("{:#010x}", status.0), str::to_owned)),
        _ => Ok(String::new()),
    };
    match detail {
        Ok(detail) if detail.is_empty() => head,
        Ok(detail) => format!("{head} {detail}"),
        Err(error) => format!("{head}: {error}"),
    }
}

/// The name of an RPC operation; `None` if it is not a PROFINET operation.
pub(super) fn operation(opnum: Opnum) -> Option<&'static str> {
    Some(match opnum {
        Opnum::CONNECT => "Connect",
        Opnum::RELEASE => "Release",
        Opnum::READ => "Read",
        Opnum::WRITE => "Write",
        Opnum::CONTROL => "Control",
        Opnum::READ_IMPLICIT => "Read implicit",
        _ => return None,
    })
}

fn request(header: &RpcHeader, body: &[u8]) -> wire::Result<String> {
    let (ndr, blocks) = NdrRequest::parse(header.order(), body)?;
    let blocks = blocks.get(..ndr.args_length as usize).unwrap_or(blocks);
    Ok(match header.opnum {
        Opnum::CONNECT => match Connect::parse(blocks)?.ar_req() {
            Some(ar) if ar.ar_type == ArType::IOSAR => format!("device access {}", ar.ar_uuid),
            Some(ar) => format!("from '{}' {}", escaped(&ar.cm_initiator_station_name), ar.ar_uuid),
            None => String::new(),
        },
        Opnum::READ | Opnum::READ_IMPLICIT => {
            let record = ReadRequest::parse(blocks)?.header;
            format!("{} (at most {} bytes)", place(&record), record.record_data_length)
        }
        Opnum::WRITE => {
            let request = WriteRequest::parse(blocks)?;
            match request.records().transpose()? {
                Some(records) => {
                    let one =
                        |record: &WriteRequest| format!("{} ({} bytes)", place(&record.header), record.data.len());
                    records.iter().map(one).collect::<Vec<_>>().join(", ")
                }
                None => format!("{} ({} bytes)", place(&request.header), request.data.len()),
            }
        }
        Opnum::CONTROL | Opnum::RELEASE => control(blocks)?,
        _ => String::new(),
    })
}

fn response(header: &RpcHeader, body: &[u8]) -> wire::Result<String> {
    let (ndr, blocks) = NdrResponse::parse(header.order(), body)?;
    let blocks = blocks.get(..ndr.args_length as usize).unwrap_or(blocks);
    if !ndr.status.is_ok() {
        return Ok(match header.opnum {
            Opnum::CONNECT | Opnum::RELEASE => ndr.status.to_string(),
            _ => format!("response {}", ndr.status),
        });
    }
    Ok(match header.opnum {
        Opnum::READ | Opnum::READ_IMPLICIT => {
            let response = ReadResponse::parse(blocks)?;
            format!("response {} ({} bytes)", place(&response.header), response.record().len())
        }
        Opnum::WRITE => {
            let responses = WriteResponse::parse_all(blocks)?;
            let refused = responses.iter().find(|response| !response.status.is_ok());
            match refused {
                Some(response) => format!("response {} {}", place(&response.header), response.status),
                None => "response ok".into(),
            }
        }
        Opnum::CONTROL => format!("response {}", control(blocks)?),
        _ => String::new(),
    })
}

fn control(blocks: &[u8]) -> wire::Result<String> {
    let block = ControlBlocks::parse(blocks)?.block;
    Ok(match block.header.kind {
        BlockType::PRM_END_REQ | BlockType::PRM_END_RES => "end of parameters".into(),
        BlockType::APPLICATION_READY_REQ | BlockType::APPLICATION_READY_RES => "ApplicationReady".into(),
        BlockType::RELEASE_REQ | BlockType::RELEASE_RES => String::new(),
        kind => kind.word().map_or_else(|| format!("{:#06x}", kind.0), str::to_owned),
    })
}

/// `0xBF00 of slot 1 subslot 0x0002`.
fn place(record: &RecordHeader) -> String {
    let RecordHeader { index, slot_number, subslot_number, .. } = record;
    format!("0x{index:04X} of slot {slot_number} subslot {subslot_number:#06x}")
}

fn arp(payload: &[u8]) -> String {
    match Arp::parse(payload) {
        Ok(arp) if arp.operation == ArpOperation::REQUEST => format!("ARP who has {}", arp.target_ip),
        Ok(arp) => format!("ARP {} is at {}", arp.sender_ip, arp.sender_mac),
        Err(error) => error.to_string(),
    }
}

fn lldp(payload: &[u8]) -> String {
    let Ok(lldp) = Lldp::parse(payload) else { return "LLDP".into() };
    let mut line = String::from("LLDP");
    for tlv in &lldp.tlvs {
        match tlv {
            Tlv::ChassisId { id, .. } => line += &format!(" chassis '{}'", escaped(id)),
            Tlv::PortId { id, .. } => line += &format!(" port '{}'", escaped(id)),
            _ => {}
        }
    }
    line
}

pub(super) fn hex(octets: &[u8]) -> String {
    let mut text = hex_start(octets, MOST_OCTETS).to_lowercase();
    if octets.len() > MOST_OCTETS {
        let _ = write!(text, " .. ({} bytes)", octets.len());
    }
    text
}
