//! Parts of Ethernet frames: RT, alarms, DCP, RPC calls, and the headers of other protocols.

use super::Parts;
use crate::observe::describe::{element, operation, service, stream_of};
use crate::observe::{FrameDirection, ObservedAr};
use plain_text::escaped;
use wire::ethernet::{EtherType, Mac};
use wire::profinet::blocks::BlockType;
use wire::profinet::dcp::{Element, ServiceId};
use wire::profinet::rpc::{NdrRequest, Opnum, PacketType, RpcHeader, RpcPdu};
use wire::profinet::rt::{ApduStatus, DataStatus, FrameId, FrameKind, IoxS};
use wire::profinet::status::PnioStatus;

/// Length of the UDP header in bytes.
const UDP_HEADER: usize = 8;

pub(super) fn frame(parts: &mut Parts<'_>, ars: &[ObservedAr]) {
    let mac = |octets: &[u8]| octets.try_into().map(|octets| Mac(octets).to_string()).unwrap_or_default();
    let address = |at: usize| parts.octets.get(at..at + 6).and_then(|octets| octets.try_into().ok()).map(Mac);
    let (destination, source) = (address(0), address(6));
    parts.take(6, "destination", mac);
    parts.take(6, "source", mac);
    while let [0x81, 0x00, ..] | [0x88, 0xA8, ..] = parts.left() {
        parts.plain(2, "VLAN tag");
        parts.number(2, "priority and VLAN", |tag| Some(format!("priority {}, VLAN {}", tag >> 13, tag & 0x0FFF)));
    }
    let ether_type = parts.left().first_chunk().map(|octets| EtherType(u16::from_be_bytes(*octets)));
    parts.number(2, "EtherType", |number| {
        let word = match EtherType(number as u16) {
            EtherType::PROFINET => "PROFINET",
            EtherType::IPV4 => "IPv4",
            EtherType::ARP => "ARP",
            EtherType::LLDP => "LLDP",
            _ => "another protocol",
        };
        Some(word.to_owned())
    });
    match ether_type {
        Some(EtherType::PROFINET) => real_time(parts, ars, source.zip(destination)),
        Some(EtherType::IPV4) => internet(parts),
        _ => {}
    }
}

fn real_time(parts: &mut Parts<'_>, ars: &[ObservedAr], way: Option<(Mac, Mac)>) {
    let Some(id) = parts.left().first_chunk().map(|octets| FrameId(u16::from_be_bytes(*octets))) else { return };
    parts.number(2, "frame id", |number| Some(format!("0x{number:04X}")));
    match id.kind() {
        _ if id.is_cyclic() => cyclic(parts, ars, way, id),
        FrameKind::AlarmHigh | FrameKind::AlarmLow => alarm(parts),
        FrameKind::DcpHello | FrameKind::DcpGetSet | FrameKind::DcpIdentifyRequest | FrameKind::DcpIdentifyResponse => {
            dcp(parts);
        }
        _ => {}
    }
}

/// The data area by submodules, then the padding and the APDU status.
fn cyclic(parts: &mut Parts<'_>, ars: &[ObservedAr], way: Option<(Mac, Mac)>, id: FrameId) {
    let found = way.and_then(|way| stream_of(ars, way, id));
    let begin = parts.at;
    if let Some((ar, direction)) = found {
        let mut spots: Vec<(usize, usize, String)> = Vec::new();
        for placed in &ar.submodules {
            let who = format!("slot {} subslot 0x{:04X}", placed.slot, placed.subslot);
            let (data, word, provider, consumer) = match direction {
                FrameDirection::ToController => (&placed.input, "inputs", placed.input_status, placed.output_consumer),
                FrameDirection::ToDevice => (&placed.output, "outputs", placed.output_status, placed.input_consumer),
            };
            spots.extend(
                data.clone()
                    .filter(|data| !data.is_empty())
                    .map(|data| (data.start, data.len(), format!("{word} of {who}"))),
            );
            spots.extend(provider.map(|at| (at, 1, format!("IOPS of {who}"))));
            spots.extend(consumer.map(|at| (at, 1, format!("IOCS of {who}"))));
        }
        spots.sort_by_key(|(at, ..)| *at);
        for (at, length, name) in spots {
            parts.until(begin + at, "padding");
            if name.starts_with("IO") {
                parts.number(length, name, |octet| {
                    Some(if IoxS(octet as u8).is_good() { "good" } else { "bad" }.to_owned())
                });
            } else {
                parts.plain(length, name);
            }
        }
        let length = ar.stream(direction).data_length;
        parts.until(begin + length, "padding");
    } else {
        let end = parts.octets.len().saturating_sub(ApduStatus::LENGTH);
        parts.until(end, "data");
    }
    parts.number(2, "cycle counter", |_| None);
    parts.number(1, "data status", |octet| Some(data_status(DataStatus(octet as u8))));
    parts.number(1, "transfer status", |_| None);
    parts.rest("padding of Ethernet");
}

fn data_status(status: DataStatus) -> String {
    let words = [
        (DataStatus::PRIMARY, "primary", "backup"),
        (DataStatus::DATA_VALID, "valid", "not valid"),
        (DataStatus::RUN, "run", "stop"),
        (DataStatus::NO_PROBLEM, "no problem", "problem"),
    ];
    words.map(|(bit, set, clear)| if status.has(bit) { set } else { clear }).join(", ")
}

fn alarm(parts: &mut Parts<'_>) {
    parts.number(2, "destination endpoint", |_| None);
    parts.number(2, "source endpoint", |_| None);
    let kind = parts.left().first().map(|octet| octet & 0x0F);
    parts.number(1, "version and PDU type", |octet| {
        let word = match octet & 0x0F {
            1 => "data",
            2 => "NACK",
            3 => "ACK",
            4 => "error",
            _ => "unknown",
        };
        Some(word.to_owned())
    });
    parts.number(1, "flags", |_| None);
    parts.number(2, "sequence number", |number| Some(format!("0x{number:04X}")));
    parts.number(2, "acknowledged sequence number", |number| Some(format!("0x{number:04X}")));
    let length = parts.left().first_chunk().map_or(0, |octets| usize::from(u16::from_be_bytes(*octets)));
    parts.number(2, "length", |_| None);
    let end = parts.at + length;
    match kind {
        Some(4) => status(parts),
        Some(1) => blocks(parts, end),
        _ => {}
    }
    parts.until(end, "data");
    parts.rest("padding of Ethernet");
}

fn status(parts: &mut Parts<'_>) {
    parts.number(4, "PNIO status", |number| Some(words(PnioStatus::from(number as u32))));
}

fn words(status: PnioStatus) -> String {
    status.sentence().map_or_else(|| status.to_string(), |words| format!("{status}: {words}"))
}

fn dcp(parts: &mut Parts<'_>) {
    let kind = parts.left().first_chunk::<2>().copied();
    parts.number(1, "service", |number| service(ServiceId(number as u8)).map(str::to_owned));
    parts.number(1, "service type", |number| {
        Some(match number {
            0 => "request".to_owned(),
            1 => "response".to_owned(),
            other => other.to_string(),
        })
    });
    parts.number(4, "XID", |number| Some(format!("0x{number:08X}")));
    parts.number(2, "response delay factor", |_| None);
    let length = parts.left().first_chunk().map_or(0, |octets| usize::from(u16::from_be_bytes(*octets)));
    parts.number(2, "length", |_| None);
    let end = (parts.at + length).min(parts.octets.len());
    if kind == Some([3, 0]) {
        while parts.at < end {
            parts.take(2, "requested element", option);
        }
    }
    while parts.at + 4 <= end {
        let at = parts.at;
        let name = parts.octets.get(at..at + 2).map(option).unwrap_or_default();
        let length = parts.octets.get(at + 2..at + 4).map_or(0, |of| usize::from(of[0]) << 8 | usize::from(of[1]));
        parts.take(2, "option", option);
        parts.number(2, "length", |_| None);
        let behind = (parts.at + length).min(end);
        match kind {
            Some([4, 0]) => parts.number(2, "block qualifier", |_| None),
            Some([3 | 5, 1] | [6, _]) => parts.number(2, "block info", |_| None),
            _ => {}
        }
        parts.take(behind.saturating_sub(parts.at), name, text);
        if length % 2 == 1 && parts.at < end {
            parts.plain(1, "padding");
        }
    }
    parts.until(end, "cut off");
    parts.rest("padding of Ethernet");
}

fn option(octets: &[u8]) -> String {
    let &[option, suboption] = octets else { return String::new() };
    element(Element { option, suboption })
}

/// Bytes as a text, if they are printable.
fn text(octets: &[u8]) -> String {
    let readable = |octet: &u8| octet.is_ascii_graphic() || *octet == b' ';
    if octets.len() > 2 && octets.iter().all(readable) { format!("'{}'", escaped(octets)) } else { String::new() }
}

fn internet(parts: &mut Parts<'_>) {
    let head = parts.left().first().map_or(0, |octet| usize::from(octet & 0x0F) * 4);
    let protocol = parts.left().get(9).copied();
    let address = |octets: &[u8]| octets.iter().map(u8::to_string).collect::<Vec<_>>().join(".");
    parts.plain(8, "IPv4 version, length, fragment");
    parts.number(1, "time to live", |_| None);
    parts.number(1, "protocol", |number| {
        Some(match number {
            6 => "TCP".to_owned(),
            17 => "UDP".to_owned(),
            other => other.to_string(),
        })
    });
    parts.plain(2, "checksum");
    parts.take(4, "source address", address);
    parts.take(4, "destination address", address);
    parts.plain(head.saturating_sub(20), "options");
    if protocol != Some(17) {
        return;
    }
    let length = parts.left().get(4..6).map_or(0, |of| usize::from(of[0]) << 8 | usize::from(of[1]));
    let end = (parts.at + length).min(parts.octets.len());
    let payload = parts.octets.get(parts.at + UDP_HEADER..end).unwrap_or_default();
    parts.number(2, "source port", |_| None);
    parts.number(2, "destination port", |_| None);
    parts.number(2, "length", |_| None);
    parts.plain(2, "checksum");
    if let Ok(pdu) = RpcPdu::parse(payload) {
        call(parts, &pdu, end);
    }
    parts.until(end, "data");
    parts.rest("padding of Ethernet");
}

fn call(parts: &mut Parts<'_>, pdu: &RpcPdu<'_>, end: usize) {
    let header: &RpcHeader = &pdu.header;
    let packet = header.packet_type;
    let begin = parts.at;
    parts.plain(1, "RPC version");
    parts.number(1, "packet type", |_| packet.word().map(str::to_owned));
    parts.plain(2, "flags");
    parts.plain(4, "data representation and serial number");
    parts.take(16, "object", |_| header.object.to_string());
    parts.take(16, "interface", |_| header.interface.to_string());
    parts.take(16, "activity", |_| header.activity.to_string());
    parts.plain(4, "server boot time");
    parts.plain(4, "interface version");
    parts.plain(4, "sequence number");
    parts.take(2, "operation", |_| operation(header.opnum).map_or_else(|| header.opnum.0.to_string(), str::to_owned));
    parts.until(begin + RpcHeader::LENGTH, "hints, length, fragment");
    let is_pnio = header.opnum.0 <= Opnum::READ_IMPLICIT.0;
    match packet {
        PacketType::REQUEST if is_pnio => parts.plain(NdrRequest::LENGTH, "NDR lengths"),
        PacketType::RESPONSE if is_pnio => {
            parts.take(4, "PNIO status", |octets| {
                let number = octets.try_into().map(|of| match header.order() {
                    wire::octets::ByteOrder::Big => u32::from_be_bytes(of),
                    wire::octets::ByteOrder::Little => u32::from_le_bytes(of),
                });
                words(PnioStatus::from(number.unwrap_or_default()))
            });
            parts.plain(NdrRequest::LENGTH - 4, "NDR lengths");
        }
        _ => return,
    }
    blocks(parts, end);
}

/// Consecutive PROFINET blocks: type, length, content.
fn blocks(parts: &mut Parts<'_>, end: usize) {
    while parts.at + 4 <= end {
        let Some(&[a, b, c, d]) = parts.left().first_chunk() else { return };
        let kind = BlockType(u16::from_be_bytes([a, b]));
        let length = usize::from(u16::from_be_bytes([c, d]));
        let Some(word) = kind.word().filter(|_| length >= 2 && parts.at + 4 + length <= end) else { return };
        parts.take(2, "block", |_| word.to_owned());
        parts.number(2, "length", |_| None);
        parts.plain(2, "version");
        parts.plain(length - 2, format!("content of {word}"));
    }
}
