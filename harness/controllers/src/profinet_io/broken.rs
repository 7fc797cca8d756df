//! Frames damaged on purpose, to check that a device survives them.
//!
//! Each is a single frame. The AR continues; observers judge whether it survives.

use super::call::CLIENT_PORT;
use super::connect::{self, ArNames};
use super::connection::{ArConfig, DeviceAddress, RecordAddress};
use super::context::{ARGS_MAXIMUM, ControllerContext};
use super::layout::Layout;
use super::record;
use super::request::Partner;
use crate::words::words;
use alloc::vec::Vec;
use core::net::SocketAddrV4;
use wire::datagram::write_udp;
use wire::ethernet::{EtherType, FrameHeader, Mac, pad};
use wire::octets::{Append, ByteOrder};
use wire::profinet::alarm::{AlarmPriority, RtaBody, RtaHeader, RtaKind, RtaPdu};
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::connect::{ArType, Connect, ConnectContent};
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::dcp::{BlockQualifier, Dcp, DcpBlock, DcpValue};
use wire::profinet::rpc::{Flags1, NdrRequest, ObjectUuid, Opnum, PORT, PacketType, RpcHeader, RpcPdu, Uuid};
use wire::profinet::rt::DataStatus;
use wire::profinet::status::{AbortReason, PnioStatus};

words! {
    /// A frame damaged on purpose.
    pub enum DamagedIoFrame {
        CyclicShort "cyclic_short" "A cyclic frame that ends in the middle of its data.",
        CyclicInvalid "cyclic_invalid" "A cyclic frame with DataValid = 0 in its data status.",
        CyclicFrameId "cyclic_frame_id" "A cyclic frame with a frame ID that was not agreed in the Connect.",
        CyclicUnknownSource "cyclic_unknown_source" "A cyclic frame with other data from a MAC address that has no AR.",
        AlarmEndpoint "alarm_endpoint" "An ERR-RTA for an alarm endpoint that does not exist.",
        RpcVersion "rpc_version" "An RPC request of version 5.",
        RpcLength "rpc_length" "An RPC request whose header announces more bytes than the datagram has.",
        RpcFragment "rpc_fragment" "The last fragment of an RPC request whose other fragments are never sent.",
        UdpChecksum "udp_checksum" "An RPC request whose UDP checksum is wrong.",
        ConnectUnknownBlock "connect_unknown_block" "A Connect for device access with a second block of a type that does not exist.",
        RecordLength "record_length" "A Write whose block announces more record bytes than follow.",
        DcpLength "dcp_length" "A DCP Set whose length exceeds the frame.",
        DcpBlockLength "dcp_block_length" "A DCP Set of the name whose block exceeds the DCP data.",
        Runt "runt" "A PROFINET frame that ends in the middle of its frame ID.",
    }
}

impl DamagedIoFrame {
    /// The damaged frame with this word.
    pub fn by_word(word: &str) -> Option<DamagedIoFrame> {
        DamagedIoFrame::TABLE.iter().find(|entry| entry.1 == word).map(|entry| entry.0)
    }
}

/// Every damaged frame that the controller can send: its word and its sentence.
pub fn broken_frames() -> impl Iterator<Item = (&'static str, &'static str)> {
    DamagedIoFrame::TABLE.iter().map(|&(_, word, sentence)| (word, sentence))
}

/// The bytes of a damaged frame to the device of the AR, or to `partner` if there is no AR; the error says what is missing.
pub(super) fn frame(
    context: &mut ControllerContext,
    broken: DamagedIoFrame,
    partner: Option<Partner>,
) -> Result<Vec<u8>, &'static str> {
    let ar = context.ar.as_ref().map(|ar| ar.partner);
    let to = ar.or(partner).or(context.partner).ok_or("there is no AR and no partner is given")?;
    let mut maker = DamagedFrameBuilder { context, to };
    match broken {
        DamagedIoFrame::CyclicShort => {
            maker.cyclic(|frame, data_at, status_at| frame.truncate(data_at + (status_at - data_at) / 2))
        }
        DamagedIoFrame::CyclicInvalid => {
            maker.cyclic(|frame, _, status_at| frame[status_at + 2] &= !DataStatus::DATA_VALID)
        }
        DamagedIoFrame::CyclicFrameId => maker.cyclic(|frame, data_at, _| frame[data_at - 1] ^= 0x40),
        DamagedIoFrame::CyclicUnknownSource => maker.cyclic(|frame, data_at, status_at| {
            frame[6..12].copy_from_slice(&UNKNOWN_SOURCE.0);
            frame[data_at..status_at].fill(0xFF);
        }),
        DamagedIoFrame::AlarmEndpoint => Ok(maker.err_rta()),
        DamagedIoFrame::RpcVersion => Ok(maker.rpc(|pdu| pdu[0] = 5)),
        DamagedIoFrame::RpcLength => Ok(maker.rpc(|pdu| pdu[74..76].copy_from_slice(&[0x7F, 0xFF]))),
        DamagedIoFrame::RpcFragment => Ok(maker.rpc(|pdu| {
            pdu[2] |= (Flags1::FRAGMENT | Flags1::LAST_FRAGMENT).0;
            pdu[76..78].copy_from_slice(&[0, 7]);
        })),
        DamagedIoFrame::UdpChecksum => {
            let mut frame = maker.rpc(|_| {});
            // The last two bytes of the UDP header, after 14 of Ethernet and 20 of IPv4.
            frame[40] ^= 0x55;
            Ok(frame)
        }
        DamagedIoFrame::ConnectUnknownBlock => Ok(maker.connect()),
        DamagedIoFrame::RecordLength => maker.write(),
        DamagedIoFrame::DcpLength => Ok(maker.dcp(|dcp| dcp[10..12].copy_from_slice(&[0x7F, 0xFF]))),
        DamagedIoFrame::DcpBlockLength => Ok(maker.dcp(|dcp| dcp[14..16].copy_from_slice(&[0x01, 0xF0]))),
        DamagedIoFrame::Runt => Ok(maker.runt()),
    }
}

/// The source address of frames from a station without an AR.
const UNKNOWN_SOURCE: Mac = Mac([0x02, 0, 0, 0, 0, 0xEE]);
/// A block type that does not exist.
const UNKNOWN_BLOCK: BlockType = BlockType(0x7FFF);

struct DamagedFrameBuilder<'a> {
    context: &'a mut ControllerContext,
    to: Partner,
}

impl DamagedFrameBuilder<'_> {
    fn cyclic(&self, damage: impl FnOnce(&mut Vec<u8>, usize, usize)) -> Result<Vec<u8>, &'static str> {
        let exchange = self.context.ar.as_ref().and_then(|ar| ar.exchange.as_ref());
        let (mut frame, data_at, status_at) = exchange.ok_or("there is no cyclic exchange")?.provider.last_frame();
        // One step of the cycle counter after the last frame, so that the device does not drop it as an old one.
        if let Some(counter) = frame.get_mut(status_at..).and_then(<[u8]>::first_chunk_mut::<2>) {
            *counter = u16::from_be_bytes(*counter).wrapping_add(1).to_be_bytes();
        }
        damage(&mut frame, data_at, status_at);
        Ok(frame)
    }

    fn header(&self, ether_type: EtherType) -> Vec<u8> {
        let mut frame = Vec::new();
        FrameHeader::new(self.to.mac, self.context.own.mac, ether_type).write(&mut frame);
        frame
    }

    fn err_rta(&self) -> Vec<u8> {
        let mut frame = self.header(EtherType::PROFINET);
        frame.put_u16(AlarmPriority::Low.frame_id());
        let header = RtaHeader::new(RtaKind::ERR, 0x7ABC, 0x7ABC, 0xFFFF, 0xFFFE);
        let body = RtaBody::Error { status: PnioStatus::abort(AbortReason::ABORT_REQUEST), more: Vec::new() };
        RtaPdu { header, body }.write(&mut frame);
        pad(&mut frame, 0);
        frame
    }

    /// A damaged read without an AR.
    fn rpc(&mut self, damage: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
        let mut blocks = Vec::new();
        let target = RecordAddress { index: 0xF840, ..RecordAddress::default() };
        record::read(Uuid::NIL, 0, target, 4096).write(&mut blocks);
        let mut pdu = self.call(Opnum::READ_IMPLICIT, &blocks);
        damage(&mut pdu);
        self.datagram(&pdu)
    }

    fn connect(&mut self) -> Vec<u8> {
        let mut connection = ArConfig::new(DeviceAddress::Mac(self.to.mac), IpParameter::NONE);
        (connection.ar_type, connection.device_access) = (ArType::IOSAR, true);
        let names = ArNames { uuid: self.context.ids.uuid(), session_key: 1, alarm_reference: 1 };
        let mut connect = connect::request(&connection, &Layout::default(), names, &self.context.settings);
        connect.extend(Connect::of([ConnectContent::Other(UNKNOWN_BLOCK, [0; 8].into())]).to_vec());
        let pdu = self.call(Opnum::CONNECT, &connect);
        self.datagram(&pdu)
    }

    fn write(&mut self) -> Result<Vec<u8>, &'static str> {
        let (uuid, number) = self.context.record_numbers(1).ok_or("there is no AR")?;
        let target = RecordAddress { index: 0x1234, ..RecordAddress::default() };
        let mut request = record::write(uuid, number, target, [0; 4].into());
        request.header.record_data_length = 0x1000;
        let mut blocks = Vec::new();
        request.write(&mut blocks);
        let pdu = self.call(Opnum::WRITE, &blocks);
        Ok(self.datagram(&pdu))
    }

    /// A complete request with its own activity UUID, so that no job waits for the answer.
    fn call(&mut self, opnum: Opnum, blocks: &[u8]) -> Vec<u8> {
        let object = self
            .context
            .ar
            .as_ref()
            .map_or(Uuid::from(ObjectUuid { instance: 1, ..ObjectUuid::default() }), |ar| ar.object);
        let header = RpcHeader {
            flags1: Flags1::IDEMPOTENT,
            object,
            interface: Uuid::DEVICE_INTERFACE,
            activity: self.context.ids.uuid(),
            opnum,
            ..RpcHeader::new(PacketType::REQUEST, ByteOrder::Big)
        };
        RpcPdu::new(header, &NdrRequest::body(ByteOrder::Big, ARGS_MAXIMUM, blocks)).to_vec()
    }

    fn datagram(&self, pdu: &[u8]) -> Vec<u8> {
        let mut frame = Vec::new();
        let end = |station: Partner, port: u16| (station.mac, SocketAddrV4::new(station.ip, port));
        // The requests above are far shorter than a frame, so they always fit.
        let _fits = write_udp(end(self.context.own, CLIENT_PORT), end(self.to, PORT), pdu, &mut frame);
        frame
    }

    fn dcp(&mut self, damage: impl FnOnce(&mut [u8])) -> Vec<u8> {
        let mut frame = self.header(EtherType::PROFINET);
        let start = frame.len();
        let name = DcpValue::NameOfStation(b"damaged".to_vec());
        Dcp::set(self.context.ids.xid(), [DcpBlock::set(BlockQualifier::TEMPORARY, name)].into()).write(&mut frame);
        damage(&mut frame[start..]);
        pad(&mut frame, 0);
        frame
    }

    fn runt(&self) -> Vec<u8> {
        let mut frame = self.header(EtherType::PROFINET);
        frame.put_u8(0x80);
        frame
    }
}
