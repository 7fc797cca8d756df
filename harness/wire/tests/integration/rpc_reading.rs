//! Parses whole RPC PDUs in tests: into blocks and back, and into fields with the names of tshark.

use encspec_wire as wire;
use std::collections::BTreeMap;
use wire::octets::ByteOrder;
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::connect::{Connect, ConnectContent};
use wire::profinet::blocks::control::ControlBlocks;
use wire::profinet::blocks::record::{ReadRequest, ReadResponse, RecordHeader, WriteRequest, WriteResponse};
use wire::profinet::rpc::{
    Cancel, CancelAck, Fack, LookupRequest, LookupResponse, NdrRequest, NdrResponse, Opnum, PacketType, RejectStatus,
    RpcPdu, Uuid,
};
use wire::profinet::status::PnioStatus;

/// The body of a PDU, as far as the crate parses it.
#[derive(Debug)]
pub enum RpcBody {
    LookupRequest(LookupRequest),
    LookupResponse(LookupResponse),
    Request(NdrRequest, RpcBlocks),
    Response(NdrResponse, RpcBlocks),
    Fack(Option<Fack>),
    Status(RejectStatus),
    Cancel(Cancel),
    CancelAck(Option<CancelAck>),
    Empty,
}

/// The blocks after the NDR header.
#[derive(Debug)]
pub enum RpcBlocks {
    None,
    Connect(Connect),
    Control(ControlBlocks),
    Read(ReadRequest),
    ReadDone(ReadResponse),
    Write(WriteRequest, Vec<WriteRequest>),
    WriteDone(Vec<WriteResponse>),
}

/// Parses the body of a PDU that is not a fragment.
pub fn body(pdu: &RpcPdu) -> wire::Result<RpcBody> {
    let order = pdu.header.order();
    let mapper = pdu.header.interface == Uuid::ENDPOINT_MAPPER;
    Ok(match pdu.header.packet_type {
        PacketType::REQUEST if mapper => RpcBody::LookupRequest(LookupRequest::parse(order, pdu.body)?),
        PacketType::RESPONSE if mapper => RpcBody::LookupResponse(LookupResponse::parse(order, pdu.body)?),
        PacketType::REQUEST => {
            let (ndr, octets) = NdrRequest::parse(order, pdu.body)?;
            let blocks = match pdu.header.opnum {
                Opnum::CONNECT => RpcBlocks::Connect(Connect::parse(octets)?),
                Opnum::CONTROL | Opnum::RELEASE => RpcBlocks::Control(ControlBlocks::parse(octets)?),
                Opnum::READ | Opnum::READ_IMPLICIT => RpcBlocks::Read(ReadRequest::parse(octets)?),
                Opnum::WRITE => {
                    let write = WriteRequest::parse(octets)?;
                    let records = write.records().transpose()?.unwrap_or_default();
                    RpcBlocks::Write(write, records)
                }
                other => panic!("opnum {other:?}"),
            };
            RpcBody::Request(ndr, blocks)
        }
        PacketType::RESPONSE => {
            let (ndr, octets) = NdrResponse::parse(order, pdu.body)?;
            let blocks = match pdu.header.opnum {
                _ if octets.is_empty() => RpcBlocks::None,
                Opnum::CONNECT => RpcBlocks::Connect(Connect::parse(octets)?),
                Opnum::CONTROL | Opnum::RELEASE => RpcBlocks::Control(ControlBlocks::parse(octets)?),
                Opnum::READ | Opnum::READ_IMPLICIT => RpcBlocks::ReadDone(ReadResponse::parse(octets)?),
                Opnum::WRITE => RpcBlocks::WriteDone(WriteResponse::parse_all(octets)?),
                other => panic!("opnum {other:?}"),
            };
            RpcBody::Response(ndr, blocks)
        }
        PacketType::FACK | PacketType::NOCALL => RpcBody::Fack(Fack::parse(order, pdu.body)?),
        PacketType::FAULT | PacketType::REJECT => RpcBody::Status(RejectStatus::parse(order, pdu.body)?),
        PacketType::CANCEL => RpcBody::Cancel(Cancel::parse(order, pdu.body)?),
        PacketType::CANCEL_ACK => RpcBody::CancelAck(CancelAck::parse(order, pdu.body)?),
        PacketType::PING | PacketType::WORKING | PacketType::ACK => RpcBody::Empty,
        other => panic!("packet type {other:?}"),
    })
}

/// Appends a body again.
pub fn write(body: &RpcBody, out: &mut Vec<u8>, order: ByteOrder) {
    match body {
        RpcBody::LookupRequest(lookup) => lookup.write(out, order),
        RpcBody::LookupResponse(lookup) => lookup.write(out, order),
        RpcBody::Request(ndr, blocks) => {
            ndr.write(out, order);
            write_blocks(blocks, out);
        }
        RpcBody::Response(ndr, blocks) => {
            ndr.write(out, order);
            write_blocks(blocks, out);
        }
        RpcBody::Fack(fack) => fack.iter().for_each(|fack| fack.write(out, order)),
        RpcBody::Status(status) => status.write(out, order),
        RpcBody::Cancel(cancel) => cancel.write(out, order),
        RpcBody::CancelAck(ack) => ack.iter().for_each(|ack| ack.write(out, order)),
        RpcBody::Empty => {}
    }
}

fn write_blocks(blocks: &RpcBlocks, out: &mut Vec<u8>) {
    match blocks {
        RpcBlocks::None => {}
        RpcBlocks::Connect(connect) => connect.write(out),
        RpcBlocks::Control(control) => control.write(out),
        RpcBlocks::Read(read) => read.write(out),
        RpcBlocks::ReadDone(read) => read.write(out),
        RpcBlocks::Write(write, records) if records.is_empty() => write.write(out),
        RpcBlocks::Write(write, records) => {
            let header = write.header;
            let mut again = WriteRequest::multiple(header.ar_uuid, header.seq_number, records);
            // The writers of both have counted the lengths, which must match; the address may differ.
            again.header = RecordHeader { record_data_length: again.header.record_data_length, ..header };
            again.padding = write.padding;
            again.rest.clone_from(&write.rest);
            again.write(out);
        }
        RpcBlocks::WriteDone(responses) => responses.iter().for_each(|response| response.write(out)),
    }
}

/// The values of a tshark field.
type Values = Vec<String>;

/// The fields of the PDU, with the names of tshark.
pub fn fields(pdu: &RpcPdu) -> BTreeMap<&'static str, Values> {
    let mut fields = TsharkFields::default();
    let header = &pdu.header;
    fields.number("dcerpc.pkt_type", header.packet_type.0);
    fields.number("dcerpc.opnum", header.opnum.0);
    fields.number("dcerpc.drep.byteorder", u8::from(header.order() == ByteOrder::Little));
    fields.number("dcerpc.dg_seqnum", header.sequence);
    fields.text("dcerpc.dg_act_id", header.activity);
    fields.text("dcerpc.obj_id", header.object);
    fields.text("dcerpc.dg_if_id", header.interface);
    fields.number("dcerpc.dg_frag_len", header.body_length);
    fields.number("dcerpc.dg_frag_num", header.fragment);
    fields.number("dcerpc.dg_if_ver", header.interface_version);
    fields.number("dcerpc.dg_ahint", header.activity_hint);
    fields.number("dcerpc.dg_ihint", header.interface_hint);
    fields.number("dcerpc.dg_serial_hi", header.serial >> 8);
    fields.number("dcerpc.dg_serial_lo", header.serial & 0xFF);
    match body(pdu).expect("a valid body") {
        RpcBody::LookupRequest(_) | RpcBody::CancelAck(None) | RpcBody::Fack(None) | RpcBody::Empty => {}
        RpcBody::LookupResponse(lookup) => {
            for entry in &lookup.entries {
                let tower = entry.tower.as_ref().expect("a tower");
                fields.text("epm.uuid", tower.interface().expect("an interface").0);
                fields.text("epm.uuid", Uuid::NDR);
                fields.number("epm.proto.udp_port", tower.port().expect("a port"));
                let address = core::net::Ipv4Addr::from(tower.address().expect("an address"));
                fields.text("epm.proto.ip", address);
                let annotation = String::from_utf8(entry.annotation().to_vec()).expect("ASCII");
                fields.text("epm.annotation", annotation.replace(' ', "_"));
            }
        }
        RpcBody::Request(ndr, blocks) => {
            fields.number("pn_io.args_max", ndr.args_maximum);
            fields.number("pn_io.args_len", ndr.args_length);
            fields.blocks(&blocks);
        }
        RpcBody::Response(ndr, blocks) => {
            fields.number("pn_io.args_len", ndr.args_length);
            fields.status(ndr.status);
            fields.blocks(&blocks);
        }
        RpcBody::Fack(Some(fack)) => {
            fields.number("dcerpc.fack_window_size", fack.window_size);
            fields.number("dcerpc.fack_serial_num", fack.serial);
            for word in fack.selective {
                fields.number("dcerpc.fack_selack", word);
            }
        }
        RpcBody::Status(status) => fields.number("dcerpc.dg_status", status.0),
        RpcBody::Cancel(cancel) => fields.number("dcerpc.dg_cancel_id", cancel.cancel_id),
        RpcBody::CancelAck(Some(ack)) => fields.number("dcerpc.dg_cancel_id", ack.cancel_id),
    }
    fields.0
}

#[derive(Default)]
struct TsharkFields(BTreeMap<&'static str, Values>);

impl TsharkFields {
    fn text(&mut self, name: &'static str, value: impl ToString) {
        self.0.entry(name).or_default().push(value.to_string());
    }

    fn number(&mut self, name: &'static str, value: impl Into<u64>) {
        self.text(name, value.into());
    }

    fn status(&mut self, status: PnioStatus) {
        self.number("pn_io.error_code", status.error_code.0);
        self.number("pn_io.error_decode", status.error_decode.0);
        self.number("pn_io.error_code1", status.error_code1);
        self.number("pn_io.error_code2", status.error_code2);
    }

    fn blocks(&mut self, blocks: &RpcBlocks) {
        match blocks {
            RpcBlocks::None => {}
            RpcBlocks::Connect(connect) => connect.contents().for_each(|content| self.content(content)),
            RpcBlocks::Control(control) => {
                self.number("pn_io.block_type", control.block.header.kind.0);
                self.text("pn_io.ar_uuid", control.block.ar_uuid);
                self.number("pn_io.session_key", control.block.session_key);
                if control.block.header.kind == BlockType::PLUG_PRM_END_REQ {
                    self.number("pn_io.control_alarm_sequence_number", control.block.alarm_sequence_number);
                }
                self.number("pn_io.control_command", control.block.control_command.0);
            }
            RpcBlocks::Read(read) => {
                self.record(0x0009, &read.header);
                if read.header.ar_uuid.is_nil() {
                    self.text("pn_io.target_ar_uuid", read.target_ar_uuid);
                }
            }
            RpcBlocks::ReadDone(read) => {
                self.record(0x8009, &read.header);
                self.number("pn_io.add_val1", read.additional_value1);
                self.number("pn_io.add_val2", read.additional_value2);
            }
            RpcBlocks::Write(write, records) => {
                for write in std::iter::once(write).chain(records) {
                    self.record(0x0008, &write.header);
                }
            }
            RpcBlocks::WriteDone(responses) => {
                for response in responses {
                    self.record(0x8008, &response.header);
                    self.number("pn_io.add_val1", response.additional_value1);
                    self.number("pn_io.add_val2", response.additional_value2);
                    self.status(response.status);
                }
            }
        }
    }

    fn record(&mut self, kind: u16, header: &RecordHeader) {
        self.number("pn_io.block_type", kind);
        self.number("pn_io.seq_number", header.seq_number);
        self.text("pn_io.ar_uuid", header.ar_uuid);
        self.number("pn_io.api", header.api);
        self.number("pn_io.slot_nr", header.slot_number);
        self.number("pn_io.subslot_nr", header.subslot_number);
        self.number("pn_io.index", header.index);
        self.number("pn_io.record_data_length", header.record_data_length);
    }

    fn content(&mut self, content: &ConnectContent) {
        self.number("pn_io.block_type", content.kind().0);
        match content {
            ConnectContent::ArReq(ar) => {
                self.text("pn_io.ar_uuid", ar.ar_uuid);
                self.number("pn_io.session_key", ar.session_key);
                self.text("pn_io.cminitiator_mac_add", ar.cm_initiator_mac_add);
                self.text("pn_io.cminitiator_uuid", ar.cm_initiator_object_uuid);
                self.number("pn_io.ar_properties", ar.ar_properties.0);
                self.number("pn_io.cminitiator_udprtport", ar.initiator_udp_rt_port);
                let name = String::from_utf8(ar.cm_initiator_station_name.clone()).expect("ASCII");
                self.text("pn_io.cminitiator_station_name", name);
                self.number("pn_io.cminitiator_activitytimeoutfactor", ar.cm_initiator_activity_timeout_factor);
            }
            ConnectContent::ArRes(ar) => {
                self.number("pn_io.ar_type", ar.ar_type.0);
                self.text("pn_io.ar_uuid", ar.ar_uuid);
                self.number("pn_io.session_key", ar.session_key);
                self.text("pn_io.cmresponder_macadd", ar.cm_responder_mac_add);
                self.number("pn_io.cmresponder_udprtport", ar.responder_udp_rt_port);
            }
            ConnectContent::IocrReq(iocr) => {
                self.number("pn_io.iocr_type", iocr.iocr_type.0);
                self.number("pn_io.iocr_reference", iocr.iocr_reference);
                self.number("pn_io.lt", iocr.lt);
                self.number("pn_io.iocr_properties", iocr.iocr_properties.0);
                self.number("pn_io.phase", iocr.phase);
                self.number("pn_io.sequence", iocr.sequence);
                self.number("pn_io.frame_send_offset", iocr.frame_send_offset);
                self.number("pn_io.iocr_tag_header", iocr.iocr_tag_header);
                self.text("pn_io.iocr_multicast_mac_add", iocr.iocr_multicast_mac_add);
                self.number("pn_io.data_length", iocr.data_length);
                self.number("pn_io.frame_id", iocr.frame_id);
                self.number("pn_io.send_clock_factor", iocr.send_clock_factor);
                self.number("pn_io.reduction_ratio", iocr.reduction_ratio);
                self.number("pn_io.watchdog_factor", iocr.watchdog_factor);
                self.number("pn_io.data_hold_factor", iocr.data_hold_factor);
                for api in &iocr.apis {
                    self.number("pn_io.api", api.api);
                    for object in &api.io_data_objects {
                        self.number("pn_io.slot_nr", object.slot_number);
                        self.number("pn_io.subslot_nr", object.subslot_number);
                        self.number("pn_io.io_data_object.frame_offset", object.frame_offset);
                    }
                    for object in &api.iocs {
                        self.number("pn_io.slot_nr", object.slot_number);
                        self.number("pn_io.subslot_nr", object.subslot_number);
                        self.number("pn_io.iocs_frame_offset", object.frame_offset);
                    }
                }
            }
            ConnectContent::IocrRes(iocr) => {
                self.number("pn_io.iocr_type", iocr.iocr_type.0);
                self.number("pn_io.iocr_reference", iocr.iocr_reference);
                self.number("pn_io.frame_id", iocr.frame_id);
            }
            ConnectContent::AlarmCrReq(alarm) => {
                self.number("pn_io.alarmcr_type", alarm.alarm_cr_type);
                self.number("pn_io.lt", alarm.lt);
                self.number("pn_io.alarmcr_properties", alarm.alarm_cr_properties.0);
                self.number("pn_io.alarmcr_tagheaderhigh", alarm.alarm_cr_tag_header_high);
                self.number("pn_io.alarmcr_tagheaderlow", alarm.alarm_cr_tag_header_low);
                self.number("pn_io.rta_timeoutfactor", alarm.rta_timeout_factor);
                self.number("pn_io.rta_retries", alarm.rta_retries);
                self.number("pn_io.localalarmref", alarm.local_alarm_reference);
                self.number("pn_io.maxalarmdatalength", alarm.max_alarm_data_length);
            }
            ConnectContent::AlarmCrRes(alarm) => {
                self.number("pn_io.alarmcr_type", alarm.alarm_cr_type);
                self.number("pn_io.localalarmref", alarm.local_alarm_reference);
                self.number("pn_io.maxalarmdatalength", alarm.max_alarm_data_length);
            }
            ConnectContent::ExpectedSubmodule(expected) => {
                for module in &expected.modules {
                    self.number("pn_io.api", module.api);
                    self.number("pn_io.slot_nr", module.slot_number);
                    self.number("pn_io.module_ident_number", module.module_ident_number);
                    self.number("pn_io.module_properties", module.module_properties);
                    for submodule in &module.submodules {
                        self.number("pn_io.submodule_properties", submodule.submodule_properties.0);
                        self.number("pn_io.subslot_nr", submodule.subslot_number);
                        self.number("pn_io.submodule_ident_number", submodule.submodule_ident_number);
                        for description in &submodule.data_descriptions {
                            self.number("pn_io.data_description", description.data_description);
                            self.number("pn_io.length_iocs", description.length_iocs);
                            self.number("pn_io.length_iops", description.length_iops);
                            self.number("pn_io.submodule_data_length", description.submodule_data_length);
                        }
                    }
                }
            }
            ConnectContent::ArServerRes(server) => {
                let name = String::from_utf8(server.cm_responder_station_name.clone()).expect("ASCII");
                self.text("pn_io.cminitiator_station_name", name);
            }
            // tshark 4.0 dissects no field of these blocks.
            ConnectContent::PrmServerReq(_)
            | ConnectContent::ArRpcReq(_)
            | ConnectContent::ArRpcRes(_)
            | ConnectContent::Other(..) => {}
        }
    }
}

/// Parses the output of tshark, `field=value,value`, numbers in decimal.
pub fn tshark(line: &str) -> BTreeMap<String, Values> {
    let plain = |value: &str| match value.strip_prefix("0x") {
        Some(digits) => u64::from_str_radix(digits, 16).expect("hexadecimal").to_string(),
        None => value.to_owned(),
    };
    line.split(' ')
        .map(|field| field.split_once('=').expect("field=values"))
        .map(|(name, values)| (name.to_owned(), values.split(',').map(plain).collect()))
        .collect()
}

/// Asserts that the parsed fields match those of tshark; returns the number of compared values.
///
/// To the fields of blocks tshark adds values that it remembers of the AR and values inside records, so the parsed values must be
/// a subsequence of those of tshark; writing every PDU again shows that nothing is missing.
pub fn assert_same(what: &str, parsed: &BTreeMap<&'static str, Values>, tshark: &BTreeMap<String, Values>) -> usize {
    for (field, values) in parsed {
        let dissected = tshark.get(*field).map_or(&[][..], Vec::as_slice);
        let mut rest = dissected.iter();
        let is_subsequence = values.iter().all(|value| rest.any(|other| other == value));
        let same = if field.starts_with("pn_io.") { is_subsequence } else { values == dissected };
        assert!(same, "{what}: {field}: parsed {values:?}, tshark {dissected:?}");
    }
    parsed.values().map(Vec::len).sum()
}

/// Hexadecimal digits in rows of 16 bytes, to make a difference visible.
pub fn hex(octets: &[u8]) -> Vec<String> {
    octets.chunks(16).map(|row| row.iter().map(|octet| format!("{octet:02x} ")).collect()).collect()
}
