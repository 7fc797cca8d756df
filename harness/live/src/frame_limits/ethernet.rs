//! Frames on PROFINET: cyclic outputs, calls, DCP, web pages.

use super::outputs::{OutputArea, OutputLayout};
use super::{FrameLimits, LastingFrameChanges};
use suite::device::Origin;
use wire::datagram::{Datagram, Ipv4};
use wire::ethernet::{EtherType, FrameHeader, Mac};
use wire::profinet::blocks::connect::{ArType, Connect, IocrType};
use wire::profinet::blocks::record::WriteRequest;
use wire::profinet::dcp::{Dcp, DcpValue, ServiceId};
use wire::profinet::rpc::{Assembled, NdrRequest, Opnum, PacketType, RpcHeader, RpcPdu, Uuid};
use wire::profinet::rt::{CyclicFrame, FrameId, FrameKind, IoxS};

/// Every bit that a status of outputs or inputs may have; the others are reserved.
const STATUS_BITS: u8 = 0xE0;

impl FrameLimits {
    /// Judges a frame to the device, or of discovery, and counts what it changes; the error says why it may not be sent.
    pub fn judge_frame(&mut self, frame: &[u8]) -> Result<(), String> {
        let (header, payload) = FrameHeader::parse(frame).map_err(|_| "an unreadable frame")?;
        match header.ether_type {
            EtherType::ARP => Ok(()),
            EtherType::LLDP if self.direct_cable => Ok(()),
            EtherType::LLDP => Err("an LLDP frame, and the bench does not say `direct_cable: true`".to_owned()),
            EtherType::IPV4 => self.judge_packet(frame, payload),
            EtherType::PROFINET => {
                let id = FrameId::peek(payload).map_err(|_| "an unreadable frame")?;
                match id.kind() {
                    FrameKind::DcpIdentifyRequest | FrameKind::AlarmHigh | FrameKind::AlarmLow => Ok(()),
                    FrameKind::DcpGetSet => self.judge_dcp(payload),
                    FrameKind::RtClass1 | FrameKind::RtClass2 => self.judge_cyclic(header.source, payload),
                    _ => Err(format!("a frame with the frame ID 0x{:04X}", id.0)),
                }
            }
            other => Err(format!("a frame with the EtherType 0x{:04X}", other.0)),
        }
    }

    fn judge_cyclic(&mut self, source: Mac, payload: &[u8]) -> Result<(), String> {
        let layout = self.layouts.iter().find(|(of, _)| *of == source).map(|(_, layout)| layout.clone());
        let layout = layout.ok_or("cyclic data without a Connect")?;
        let frame = CyclicFrame::parse(payload, layout.octets);
        let frame = frame.map_err(|_| "cyclic data that are not those of the Connect")?;
        let is_output = |at: usize| layout.areas.iter().any(|area| area.at.contains(&at));
        let may_be = |at: usize| if layout.statuses.contains(&at) { STATUS_BITS } else { 0 };
        if frame.data.iter().enumerate().any(|(at, octet)| !is_output(at) && octet & !may_be(at) != 0) {
            return Err("cyclic data with a bit that is neither an output nor a status".to_owned());
        }
        let is_good = |at: usize| frame.data.get(at).is_some_and(|octet| IoxS(*octet).is_good());
        let are_good = layout.areas.iter().all(|area| is_good(area.at.end));
        let status = frame.status.data_status;
        self.judge_outputs(&layout, frame.data, are_good && status.is_valid() && status.is_run())
    }

    fn judge_packet(&mut self, frame: &[u8], payload: &[u8]) -> Result<(), String> {
        let packet = Ipv4::parse(payload).map_err(|_| "an unreadable IP packet")?;
        if packet.is_fragment() {
            return Err("a fragment of an IP packet".to_owned());
        }
        match packet.protocol {
            Ipv4::ICMP => Ok(()),
            Ipv4::TCP => self.judge_page(packet.payload),
            Ipv4::UDP => {
                let datagram = Datagram::parse(frame).map_err(|_| "an unreadable UDP packet")?;
                let pdu = RpcPdu::parse(datagram.payload).map_err(|_| "a UDP packet that is no call of PROFINET")?;
                self.judge_call(datagram.source_mac, &pdu)
            }
            other => Err(format!("an IP packet of protocol {other}")),
        }
    }

    /// A request over TCP: only pages are read, which start no firmware update. No form is submitted, so that no log-in is used.
    fn judge_page(&self, segment: &[u8]) -> Result<(), String> {
        let data = segment.get(12).and_then(|offset| segment.get(usize::from(offset >> 4) * 4..));
        let data = data.ok_or("an unreadable TCP packet")?;
        if data.is_empty() {
            return Ok(());
        }
        let path = data.strip_prefix(b"GET ").and_then(|rest| rest.split(|octet| *octet == b' ').next());
        let firmware: Vec<&str> = self.device.pages_for_firmware().map(|page| page.name.as_str()).collect();
        let is_known = |path: &[u8]| {
            let pages = self.device.pages.iter().filter(|page| page.origin != Origin::Invented);
            let mut harmless = pages.filter(|page| !firmware.contains(&page.name.as_str()));
            harmless.any(|page| page.path.as_bytes() == path)
        };
        match path {
            Some(path) if is_known(path) => Ok(()),
            _ => Err("a request over TCP that does not read a page of the manual".to_owned()),
        }
    }

    fn judge_call(&mut self, source: Mac, pdu: &RpcPdu<'_>) -> Result<(), String> {
        if pdu.header.packet_type != PacketType::REQUEST || pdu.header.interface == Uuid::ENDPOINT_MAPPER {
            return Ok(());
        }
        match self.calls.take(pdu) {
            Assembled::Whole(body) => self.judge_request(source, &pdu.header, &body),
            // Without its last fragment the device has no call.
            Assembled::Waiting { .. } | Assembled::Repeated => Ok(()),
            Assembled::Contradicts | Assembled::Refused => Err("fragments of a call that do not fit".to_owned()),
        }
    }

    fn judge_request(&mut self, source: Mac, header: &RpcHeader, body: &[u8]) -> Result<(), String> {
        let blocks = || NdrRequest::parse(header.order(), body).map(|(_, blocks)| blocks);
        match header.opnum {
            Opnum::READ | Opnum::READ_IMPLICIT | Opnum::RELEASE | Opnum::CONTROL => Ok(()),
            _ if body.is_empty() => Ok(()),
            Opnum::CONNECT => {
                let blocks = blocks().map_err(|_| "a Connect that cannot be read")?;
                let connect = Connect::parse(blocks).map_err(|_| "a Connect that cannot be read")?;
                self.judge_connect(source, &connect)
            }
            Opnum::WRITE => {
                let blocks = blocks().map_err(|_| "a write that cannot be read")?;
                let request = WriteRequest::parse(blocks).map_err(|_| "a write that cannot be read")?;
                let inner = request.records().transpose().map_err(|_| "a write that cannot be read")?;
                let mut changes = LastingFrameChanges::default();
                for record in inner.as_deref().unwrap_or(std::slice::from_ref(&request)) {
                    if !record.rest.is_empty() {
                        return Err("a write with more bytes than it says".to_owned());
                    }
                    let at = (record.header.slot_number, record.header.subslot_number, record.header.index);
                    changes = changes.and(self.record_changes(at, &record.data)?);
                }
                self.permit(changes)
            }
            other => Err(format!("a call of operation {}", other.0)),
        }
    }

    fn judge_connect(&mut self, source: Mac, connect: &Connect) -> Result<(), String> {
        let request = connect.ar_req().ok_or("a Connect without an ARBlockReq")?;
        if request.ar_type != ArType::IOCAR_SINGLE && !self.consent.alone {
            return Err(format!("a Connect with the AR type 0x{:04X} without the consent alone", request.ar_type.0));
        }
        let mut layout = OutputLayout::default();
        let output = connect.iocr_requests().find(|iocr| iocr.iocr_type == IocrType::OUTPUT);
        if let Some(output) = output {
            layout.octets = output.data_length.into();
            let consumers = output.apis.iter().flat_map(|api| &api.iocs);
            layout.statuses.extend(consumers.map(|of| usize::from(of.frame_offset)));
            for module in connect.expected_modules() {
                for submodule in &module.submodules {
                    let mut described = submodule.data_descriptions.iter();
                    let length = described.find(|of| of.is_output()).map_or(0, |of| of.submodule_data_length.into());
                    let place = (module.slot_number, submodule.subslot_number);
                    let objects = output.apis.iter().flat_map(|api| &api.io_data_objects);
                    let mut objects = objects.filter(|of| (of.slot_number, of.subslot_number) == place);
                    let Some(at) = objects.next().map(|of| usize::from(of.frame_offset)) else { continue };
                    layout.statuses.push(at + length);
                    let known = self.device.submodules.iter().find(|of| {
                        (of.slot, of.subslot) == place
                            && of.ident == submodule.submodule_ident_number
                            && usize::from(of.output_octets) == length
                    });
                    let signals = known.map(|of| of.outputs.clone());
                    layout.areas.push(OutputArea { at: at..at + length, signals });
                }
            }
        }
        self.layouts.retain(|(of, _)| *of != source);
        self.layouts.push((source, layout));
        self.held.clear();
        Ok(())
    }

    fn judge_dcp(&mut self, payload: &[u8]) -> Result<(), String> {
        let dcp = Dcp::parse(payload).map_err(|_| "a DCP frame that cannot be read")?;
        if dcp.service_id == ServiceId::GET {
            return Ok(());
        }
        if dcp.service_id != ServiceId::SET {
            return Err("a DCP service that is neither Get nor Set".to_owned());
        }
        let mut changes = LastingFrameChanges::default();
        for block in dcp.blocks() {
            let one = match &block.value {
                DcpValue::Start | DcpValue::Stop | DcpValue::Signal(_) => LastingFrameChanges::default(),
                DcpValue::NameOfStation(_) => {
                    LastingFrameChanges { name: true, writes: 1, ..LastingFrameChanges::default() }
                }
                DcpValue::IpParameter(_) | DcpValue::FullIpSuite(..) if block.qualifier().is_permanent() => {
                    LastingFrameChanges { ip: true, writes: 1, ..LastingFrameChanges::default() }
                }
                DcpValue::IpParameter(_) | DcpValue::FullIpSuite(..) => LastingFrameChanges::default(),
                DcpValue::FactoryReset | DcpValue::ResetToFactory => {
                    LastingFrameChanges { factory_reset: true, writes: 1, ..LastingFrameChanges::default() }
                }
                value => {
                    let element = value.element();
                    return Err(format!("a DCP Set of {}.{}", element.option, element.suboption));
                }
            };
            changes = changes.and(one);
        }
        self.permit(changes)
    }
}
